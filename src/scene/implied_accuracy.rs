//! The accuracy of scenes that do not state one.

use super::accuracy_document::AccuracyDocument;
use super::document::{ErrorBarsDocument, Role, SceneDocument};

/// Limit of the estimated run times on one core of an accuracy that the scene does not state [s]. Estimates include neither contact that
/// limits the step nor the recording: such a run takes 20 to 50 s of wall time on two threads of one core (docs/accuracy.md).
const IMPLIED_TIME_S: f64 = 50.0;

impl SceneDocument {
    /// Requires the implied accuracy, if there is one and none is stated.
    pub fn imply_accuracy(&mut self) {
        self.accuracy = self.accuracy.take().or_else(|| self.implied_accuracy());
    }

    /// Accuracy that `contuse run` requires of an impact whose document states neither an accuracy nor the source of its error
    /// bars: 10 % of the usual results, within a minute. `None` for scenes without a projectile and a tissue that deforms.
    pub fn implied_accuracy(&self) -> Option<AccuracyDocument> {
        let has = |role: Role, is_meshed: bool| {
            self.bodies.iter().any(|body| body.role == role && (body.mesh.is_some() || !is_meshed))
        };
        let is_impact = has(Role::Projectile, false) && has(Role::Tissue, true);
        let is_open = self.accuracy.is_none() && self.solver.error_bars == ErrorBarsDocument::Automatic;
        (is_impact && is_open).then(|| AccuracyDocument {
            time_budget_s: IMPLIED_TIME_S,
            reproducible: true,
            ..AccuracyDocument::default()
        })
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)] // tests may panic
mod tests {
    use super::super::accuracy_document::RequestedNumber;
    use super::*;

    #[test]
    fn impacts_that_state_nothing_have_an_accuracy() {
        let implied = |text: &str| serde_json::from_str::<SceneDocument>(text).unwrap().implied_accuracy();
        let accuracy = implied(include_str!("../../scenarios/flashball_thigh/scene.json")).unwrap();
        assert!(accuracy.reproducible && accuracy.of == RequestedNumber::usual(), "{accuracy:?}");
        // One states the source of its error bars, the other is no impact on tissue.
        assert_eq!(implied(include_str!("../../scenarios/flashball_thigh/scene_elastic.json")), None);
        assert_eq!(implied(include_str!("../../scenarios/bar_on_wall/scene.json")), None);
    }
}
