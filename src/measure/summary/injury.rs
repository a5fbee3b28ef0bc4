//! Published injury criteria: their values, their reference values, and whether the comparison is admissible.
//!
//! A criterion is fitted to specific experiments. Outside of their range it is reported as not applicable, with the
//! reason.

use super::super::measures::Measures;
use super::quantity::{ErrorEstimate, Quantity};
use super::results::{Results, Shown};
use super::written::{marked, number, rounded, within};
use crate::measure::presented_area::Onslaught;
use crate::plan::Plan;
use crate::scene::document::{PersonDocument, Region};
use crate::step::Ending;
use serde::{Deserialize, Serialize};
use std::borrow::Cow;

/// Energy densities at 50 % risk of skin penetration, for the weakest and the strongest region [J/cm²].
const PENETRATION_J_PER_CM2: [f64; 2] = [23.99, 52.74];
/// Blunt criterion at 50 % risk of a thoracic injury of AIS 2 or 3 [-].
const BLUNT_CRITERION: f64 = 0.37;
/// Viscous criterion at 25 % risk of a thoracic injury of AIS 4 or more [m/s].
const VISCOUS_CRITERION_M_PER_S: f64 = 1.0;

/// An injury criterion evaluated for a run.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct InjuryMeasure {
    /// Name of the criterion for programs.
    pub name: Cow<'static, str>,
    /// Name of the criterion for display.
    pub title: Cow<'static, str>,
    /// Value of the criterion; absent if the scene does not specify enough.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub value: Option<f64>,
    /// Numerical error, in the unit of the value; absent if it follows from the scene alone.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub error: Option<ErrorEstimate>,
    /// Unit of the value.
    pub unit: Cow<'static, str>,
    /// Reference range; for a single reference value, that value twice.
    pub reference: [f64; 2],
    /// Meaning of the reference value.
    pub meaning: Cow<'static, str>,
    /// Whether the criterion applies: its experiments cover this scene, and the run provides what it needs.
    pub applicable: bool,
    /// Result of the comparison, or why there is none.
    pub statement: String,
    /// Fields of the scene that the criterion needs and the scene lacks.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub missing: Vec<Cow<'static, str>>,
    /// Publication: author, year, journal.
    pub source: Cow<'static, str>,
}

/// Why a criterion does not apply, and the fields of the scene that it lacks.
type Refusal = (&'static str, Vec<Cow<'static, str>>);

impl InjuryMeasure {
    /// The value with its unit, in brackets unless it is resolved; one that follows from the scene alone has no error.
    pub fn in_words(&self) -> String {
        let Some(value) = self.value else { return "-".into() };
        let unit = if self.unit == "-" { String::new() } else { format!(" {}", self.unit) };
        let is_plain = self.error.as_ref().is_none_or(ErrorEstimate::is_resolved);
        let digits = within(value, self.error.as_ref().and_then(ErrorEstimate::half_width));
        format!("{}{unit}", marked(&digits, is_plain, false))
    }

    fn refused(self, (why, missing): Refusal) -> Self {
        Self { statement: format!("not applicable: {why}"), missing, ..self }
    }
}

/// The person, if hit on the chest.
fn chest(person: Option<&PersonDocument>) -> Result<&PersonDocument, Refusal> {
    let person =
        person.ok_or(("the scene does not say where the person is hit", vec!["measures.person".into()]))?;
    if person.region == Region::Thorax {
        Ok(person)
    } else {
        Err(("the limit applies to the chest only", Vec::new()))
    }
}

/// All criteria; empty if the scene has no projectile or no tissue, or if nothing touched. Those from the run itself
/// are withheld with its results.
pub(super) fn injury_measures(
    measures: &Measures,
    plan: &Plan,
    ending: Option<&Ending>,
    results: &Shown,
) -> Vec<InjuryMeasure> {
    let Some(onslaught) = Onslaught::new(plan) else { return Vec::new() };
    if matches!(results, Shown::Results(results) if results.nothing_touched) {
        return Vec::new();
    }
    let person = plan.measures.person.as_ref();
    let mut of_skin = penetration(&onslaught, person);
    if of_skin.applicable && !measures.eroded.parts.is_empty() {
        of_skin.statement += ". The tissue of this run ruptures all the same: its material is another than that of these experiments";
    }
    let mut all = vec![of_skin, blunt(&onslaught, person)];
    match results {
        Shown::Results(Results { tissue: Some(tissue), .. }) => {
            let response = &tissue.viscous_response_m2_per_s;
            all.push(viscous(response, unfinished(measures, ending), person));
        }
        Shown::Results(_) => {}
        Shown::Withheld { .. } => {
            for measure in all.iter_mut().filter(|measure| measure.applicable) {
                measure.statement += " (from the scene alone: the run itself gives no result)";
            }
        }
    }
    all
}

/// Kinetic energy over the presented area, before the impact.
fn penetration(onslaught: &Onslaught, person: Option<&PersonDocument>) -> InjuryMeasure {
    let value = 1e-4 * onslaught.energy_density();
    let written = number(value);
    let [weakest, strongest] = PENETRATION_J_PER_CM2;
    let on_head = person.is_some_and(|person| person.region == Region::Head);
    let verdict = match value {
        x if x < weakest => {
            format!("{written} J/cm² is below all regions' 50 % risk ({weakest} to {strongest} J/cm²)")
        }
        x if x <= strongest => {
            format!("{written} J/cm² lies among the regions' 50 % risks ({weakest} to {strongest} J/cm²)")
        }
        _ => format!("{written} J/cm² is above all regions' 50 % risk ({weakest} to {strongest} J/cm²)"),
    };
    InjuryMeasure {
        name: "skin_penetration_energy_density".into(),
        title: "energy density (skin penetration)".into(),
        value: Some(value),
        error: None,
        unit: "J/cm²".into(),
        reference: [weakest, strongest],
        meaning: "50 % risk of skin penetration by a 12-gauge fin-stabilised rubber projectile, weakest and strongest region of trunk \
                  and legs of cadavers".into(),
        applicable: !on_head,
        statement: if on_head {
            "not applicable: the experiments were on trunk and legs".into()
        } else {
            format!("{verdict}; projectiles other than the one tested are compared by presented area")
        },
        missing: Vec::new(),
        source: "C. A. Bir, S. J. Stewart, M. Wilhelm (2005), Journal of Forensic Sciences 50, 1426–1429".into(),
    }
}

/// BC = ln(E / (W^(1/3) T D)), E [J], W [kg], T [cm], D [cm].
fn blunt(onslaught: &Onslaught, person: Option<&PersonDocument>) -> InjuryMeasure {
    let measure = InjuryMeasure {
        name: "blunt_criterion".into(),
        title: "blunt criterion".into(),
        value: None,
        error: None,
        unit: "-".into(),
        reference: [BLUNT_CRITERION; 2],
        meaning: "50 % risk of an injury of the chest of AIS 2 or 3 by a blunt projectile".into(),
        applicable: false,
        statement: String::new(),
        missing: Vec::new(),
        source: "L. M. Sturdivan, D. C. Viano, H. R. Champion (2004), Journal of Trauma 56, 651–663; C. Bir, D. C. Viano (2004), \
                 Journal of Trauma 57, 1218–1224".into(),
    };
    let person = match chest(person) {
        Ok(person) => person,
        Err(refusal) => return measure.refused(refusal),
    };
    let (Some(mass), Some(wall)) = (person.body_mass_kg, person.wall_thickness_m) else {
        let fields = [
            ("measures.person.body_mass_kg", person.body_mass_kg),
            ("measures.person.wall_thickness_m", person.wall_thickness_m),
        ];
        let missing = fields.iter().filter(|(_, given)| given.is_none()).map(|(name, _)| (*name).into());
        let why = "it needs the mass of the person and the thickness of the body wall";
        return measure.refused((why, missing.collect()));
    };
    let value = (onslaught.kinetic_energy / (mass.cbrt() * 100.0 * wall * 100.0 * onslaught.diameter())).ln();
    let side = if value > BLUNT_CRITERION { "above" } else { "at or below" };
    InjuryMeasure {
        value: Some(value),
        applicable: true,
        statement: format!("{} is {side} the 50 % risk of AIS 2 or 3 ({BLUNT_CRITERION})", number(value)),
        ..measure
    }
}

/// Why the largest response may not be that of the whole impact; `None` if the impact is over.
fn unfinished(measures: &Measures, ending: Option<&Ending>) -> Option<&'static str> {
    match ending {
        None => Some("the run is in progress"),
        Some(Ending::Failed { .. }) => Some("the run failed before its end"),
        Some(Ending::Cancelled) => Some("the run was stopped before its end"),
        Some(Ending::Finished) if measures.strikes().any(|pair| pair.force.is_in_contact()) => {
            Some("contact has not ended")
        }
        Some(Ending::Finished) if measures.deflection.largest_rate_time >= measures.time => {
            Some("it is largest at the end of the run")
        }
        Some(Ending::Finished) => None,
    }
}

/// VC = max V C, C the deflection over the depth of the chest, V its rate; `response` is max d ḋ [m²/s] with its error.
fn viscous(
    response: &Quantity,
    unfinished: Option<&'static str>,
    person: Option<&PersonDocument>,
) -> InjuryMeasure {
    let measure = InjuryMeasure {
        name: "viscous_criterion".into(),
        title: "viscous criterion".into(),
        value: None,
        error: None,
        unit: "m/s".into(),
        reference: [VISCOUS_CRITERION_M_PER_S; 2],
        meaning: "25 % risk of an injury of the chest of AIS 4 or more, frontal impact; the deflection is the largest displacement of a node of the surface".into(),
        applicable: false,
        statement: String::new(),
        missing: Vec::new(),
        source: "I. V. Lau, D. C. Viano (1986), SAE Technical Paper 861882 (30th Stapp Car Crash Conference)".into(),
    };
    let person = match chest(person) {
        Ok(person) => person,
        Err(refusal) => return measure.refused(refusal),
    };
    let Some(depth) = person.chest_depth_m else {
        return measure
            .refused(("it needs the depth of the chest", vec!["measures.person.chest_depth_m".into()]));
    };
    let error = response.error.scaled(1.0 / depth);
    let (applicable, statement) = verdict(response.value / depth, &error, unfinished);
    InjuryMeasure {
        value: Some(response.value / depth),
        error: Some(error),
        applicable,
        statement,
        ..measure
    }
}

/// Whether the viscous criterion may be compared with its limit, and the result.
fn verdict(value: f64, error: &ErrorEstimate, unfinished: Option<&str>) -> (bool, String) {
    const LIMIT: f64 = VISCOUS_CRITERION_M_PER_S;
    let risk = format!("the 25 % risk of AIS 4 or more ({LIMIT} m/s)");
    let (half_width, shown) = match error {
        ErrorEstimate::Estimated(e) => {
            (e.total, format!("{} m/s (± {})", within(value, Some(e.total)), rounded(e.total)))
        }
        _ => (0.0, format!("{} m/s (error not estimated)", number(value))),
    };
    // The criterion only grows: a value above the limit stays above it.
    if value - half_width > LIMIT {
        let so_far = unfinished.map_or_else(String::new, |why| format!("; at least, since {why}"));
        return (true, format!("{shown} is above {risk}{so_far}"));
    }
    if let Some(why) = unfinished {
        return (false, format!("not applicable: the impact is not over ({why}); at least {shown} so far"));
    }
    if value + half_width > LIMIT {
        return (false, format!("not decided: {shown} straddles {risk}"));
    }
    (true, format!("{shown} is at or below {risk}"))
}

#[cfg(test)]
mod tests {
    use super::super::GateResult;
    use super::*;

    const CHEST: PersonDocument = PersonDocument {
        region: Region::Thorax,
        body_mass_kg: None,
        wall_thickness_m: None,
        chest_depth_m: Some(0.2),
    };

    /// Statement for a response of 0.2 m times the value, with an error of 0.2 m times the half-width.
    fn said(value: f64, half_width: Option<f64>, unfinished: Option<&'static str>) -> InjuryMeasure {
        let mut response = Quantity::with_mesh_error(0.2 * value, 0.2 * half_width.unwrap_or(0.0), true);
        if half_width.is_none() {
            response.error = ErrorEstimate::NotEstimated;
        }
        viscous(&response, unfinished, Some(&CHEST))
    }

    #[test]
    fn an_impact_that_is_not_over_is_not_below_a_limit() {
        let going_on = said(0.488, None, Some("contact has not ended"));
        assert!(
            !going_on.applicable && going_on.statement.contains("at least 0.4880 m/s"),
            "{}",
            going_on.statement
        );
        assert!(
            going_on.statement.starts_with("not applicable: the impact is not over (contact has not ended)")
        );
        // A value already above the limit stays above it.
        let above = said(6.185, Some(0.5), Some("contact has not ended"));
        assert!(above.applicable && above.statement.contains("is above"), "{}", above.statement);
    }

    #[test]
    fn what_a_scene_lacks_is_named_beside_the_sentence() {
        let shallow = PersonDocument { chest_depth_m: None, ..CHEST };
        let response = Quantity::new(0.1, GateResult::Passed);
        let lacks = |person| {
            let measure = viscous(&response, None, person);
            (measure.statement, measure.missing)
        };
        let (statement, missing) = lacks(Some(&shallow));
        assert_eq!(statement, "not applicable: it needs the depth of the chest");
        assert_eq!(missing, ["measures.person.chest_depth_m"]);
        assert_eq!(lacks(None).1, ["measures.person"]);
        assert!(lacks(Some(&CHEST)).1.is_empty());
    }

    #[test]
    fn a_response_is_compared_with_its_error() {
        let below = said(0.5, Some(0.3), None);
        assert!(
            below.applicable && below.statement.contains("0.50 m/s (± 0.30) is at or below"),
            "{}",
            below.statement
        );
        assert!(matches!(&below.error, Some(ErrorEstimate::Estimated(e)) if (e.total - 0.3).abs() < 1e-12));
        for (value, error) in [(0.5, 3.2), (1.3, 0.4)] {
            let open = said(value, Some(error), None);
            assert!(!open.applicable && open.statement.starts_with("not decided"), "{}", open.statement);
        }
        assert!(said(0.5, None, None).statement.contains("error not estimated"));
    }
}
