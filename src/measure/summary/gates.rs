//! Gates: whether the numbers may be shown.

use super::super::measures::Measures;
use super::super::penetration::{DEPTH_LIMIT, OVERLAP_LIMIT, TOO_DEEP};
use super::laws::beyond_limit;
use super::numerics::Numerics;
use super::quantity::GateResult;
use crate::step::{Ending, Energy, FailureCause};
use serde::Serialize;

/// Largest admissible energy created by contact, as a fraction of the energy scale [-].
const CONTACT_CREATION_LIMIT: f64 = 0.001;
/// Numerical contact dissipation over the energy scale above which the numbers are withheld [-].
const CONTACT_DISSIPATION_LIMIT: f64 = 0.5;
/// Work of the position projection over the energy scale above which the numbers are withheld [-].
const PROJECTION_LIMIT: f64 = 0.05;
/// Fraction of a body's strain energy beyond the declared limits of its laws above which all numbers are withheld [-]; below,
/// only peaks.
pub(super) const LAW_LIMIT: f64 = 0.05;
/// Gate for laws used beyond their limits, and its remedy.
const LAW_GATE: &str = "laws_within_limits";
const BEYOND_LAW: &str = "Lower the speed, or give that part a law or parameters that were fitted at such deformation; an earlier end helps with the same mesh only, since finer ones exceed the limit sooner; if you know \
                          how far a law holds, declare it in the scene (`valid_to` of the material).";
/// Gate for the dissipation of contact on a coarse mesh, and its remedy.
const DISSIPATION_GATE: &str = "contact_dissipation_within_limit";
const PROJECTION_GATE: &str = "projection_within_limit";
const COARSE_CONTACT: &str = "Refine the meshes where they meet, to four times the numbers of elements if twice do not suffice: impact activation dissipates the energy of the contact nodes, and fewer, heavier nodes lose more.";
const SHARP_EDGE: &str = "Round the edges of a rigid body where it meets the tissue, by a tenth of the size of an element or more: a sharper one enters between two nodes, and is lifted out against the stress. \
    Or refine the meshes where they meet, to three times the numbers of elements if twice do not suffice.";
/// Gates for interpenetration of bodies.
const PENETRATION_GATE: &str = "penetration_within_limit";
const OVERLAP_GATE: &str = "overlap_within_limit";

/// A check that decides whether the numbers may be shown.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Gate {
    /// Name of the gate for programs.
    pub name: &'static str,
    /// Meaning of the measured value.
    pub meaning: &'static str,
    /// Measured value, to be compared with the limit [-].
    pub value: f64,
    /// Limit of the value [-].
    pub limit: f64,
    /// Whether the value is within its limit.
    pub result: GateResult,
}

/// The largest value of a failed gate over its limit [-]; `None` if none failed, ∞ for one that is not a number.
pub(super) fn excess(gates: &[Gate]) -> Option<f64> {
    let failed =
        gates.iter().filter(|gate| gate.result == GateResult::Failed).map(|gate| gate.value / gate.limit);
    failed.map(|excess| if excess.is_nan() { f64::INFINITY } else { excess }).reduce(f64::max)
}

/// The gates of a run, from its ledger; the scene sets the limit of those of energy. They are the same checks that end
/// a run, so a run ended by a gate never reports it as passed.
pub(super) fn gates(energy: &Energy, numerics: &Numerics, limit: f64, is_static: bool) -> Vec<Gate> {
    let gate = |name, meaning, value: f64, limit: f64| {
        // Written so that NaN fails.
        let result = if value <= limit { GateResult::Passed } else { GateResult::Failed };
        Gate { name, meaning, value, limit, result }
    };
    // NaN propagates; dissipation counts as nothing created.
    let created =
        |lost: f64| if lost > 0.0 || energy.scale_j == 0.0 { 0.0 } else { -lost / energy.scale_j + 0.0 };
    // A quasi-static step has no integrator that could create energy.
    let algorithmic = if is_static { 0.0 } else { energy.algorithmic_j() };
    vec![
        gate("energy_balance", "largest error of the energy balance", numerics.balance_error, limit),
        gate(
            "contact_creates_no_energy",
            "energy created by contact over the energy scale",
            created(energy.least_contact_loss_j(is_static)),
            CONTACT_CREATION_LIMIT,
        ),
        gate(
            "integrator_creates_no_energy",
            "energy created by the time integrator over the energy scale",
            created(algorithmic),
            limit,
        ),
        gate(
            "absorbed_energy_agreement",
            "difference of the absorbed energy from the tissue's state and from the work of the reactions",
            numerics.absorbed_energy_disagreement,
            limit,
        ),
        gate(
            PENETRATION_GATE,
            "deepest penetration over the size of a face",
            numerics.deepest_penetration_fraction,
            DEPTH_LIMIT,
        ),
        gate(
            OVERLAP_GATE,
            "overlapping volume of two bodies over that of the smaller one",
            numerics.overlapped_volume_fraction,
            OVERLAP_LIMIT,
        ),
        gate(
            DISSIPATION_GATE,
            "numerical contact dissipation over the energy scale",
            numerics.numerical_contact_dissipation_fraction,
            CONTACT_DISSIPATION_LIMIT,
        ),
        gate(
            PROJECTION_GATE,
            "work of the position projection over the energy scale",
            if energy.turnover_j > 0.0 { projection_work(energy) / energy.turnover_j } else { 0.0 },
            PROJECTION_LIMIT,
        ),
        gate(
            LAW_GATE,
            "fraction of a body's strain energy beyond the declared limits of its laws, relative to its largest; 1 if elements had inverted",
            numerics.energy_fraction_beyond_declared_limits,
            LAW_LIMIT,
        ),
    ]
}

/// Why the numbers of a run are withheld, and the remedy.
pub(super) struct Withholding {
    pub reason: String,
    pub remedy: &'static str,
}

/// Checks whether the numbers must be withheld.
pub(super) fn withholding(
    gates: &[Gate],
    ending: Option<&Ending>,
    measures: &Measures,
) -> Option<Withholding> {
    if let Some(failure) = ending.and_then(Ending::failure)
        && matches!(failure.cause, FailureCause::EnergyGate | FailureCause::NotFinite)
    {
        let reason = failure.message.trim_end_matches('.').to_owned();
        return Some(Withholding { reason, remedy: failure.cause.remedy() });
    }
    let failed = gates.iter().find(|g| g.result == GateResult::Failed)?;
    let beyond = || measures.laws.worst().map(|part| beyond_limit(&measures.laws, part));
    Some(match (failed.name, measures.penetration.excess(), beyond()) {
        (LAW_GATE, _, Some(reason)) => Withholding { reason, remedy: BEYOND_LAW },
        (PENETRATION_GATE | OVERLAP_GATE, Some(reason), _) => Withholding { reason, remedy: TOO_DEEP },
        (name, ..) => Withholding {
            reason: format!(
                "the check {} failed: {} is {:.3e}, at most {:.3e} is allowed",
                failed.name, failed.meaning, failed.value, failed.limit
            ),
            remedy: match name {
                DISSIPATION_GATE => COARSE_CONTACT,
                PROJECTION_GATE => SHARP_EDGE,
                _ => FailureCause::EnergyGate.remedy(),
            },
        },
    })
}

/// Total work of the position projection, summed over the bodies [J].
pub(super) fn projection_work(energy: &Energy) -> f64 {
    energy.bodies.iter().map(|body| body.projection_j.abs()).sum()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::step::BodyEnergy;

    #[test]
    fn energy_that_the_integrator_creates_fails_a_gate() {
        let failed = |algorithmic_j: f64, is_static: bool| {
            let body = BodyEnergy { algorithmic_j, ..BodyEnergy::default() };
            let energy = Energy { scale_j: 1.0, bodies: vec![body], ..Energy::default() };
            let gates = gates(&energy, &Numerics::default(), 0.01, is_static);
            let failed = gates.iter().filter(|gate| gate.result == GateResult::Failed);
            failed.map(|gate| gate.name).collect::<Vec<_>>()
        };
        assert_eq!(failed(-0.5154, false), ["integrator_creates_no_energy"]);
        assert_eq!(failed(f64::NAN, false), ["integrator_creates_no_energy"]);
        assert!(failed(0.5, false).is_empty() && failed(-0.5, true).is_empty());
    }
}
