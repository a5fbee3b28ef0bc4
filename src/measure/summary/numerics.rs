//! How good the computation was.

use super::super::measures::Measures;
use crate::step::Outcome;
use serde::Serialize;

/// How good the computation was.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Numerics {
    /// Smallest Jacobian J at any time [-]; absent while running.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub smallest_jacobian: Option<f64>,
    /// Smallest step [s]; absent while running.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub smallest_step_s: Option<f64>,
    /// Elements that were swept over all elements, summed over the steps [-]: the rest were quiet, nothing had reached them
    /// yet; absent while running.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub swept_element_share: Option<f64>,
    /// Energy at the start [J].
    pub initial_energy_j: f64,
    /// Energy that errors are compared with [J].
    pub energy_scale_j: f64,
    /// Largest error of the energy balance [-].
    pub balance_error: f64,
    /// What lumped contact nodes lost when they were caught, all pairs [J]: a discretisation error.
    pub numerical_contact_dissipation_j: f64,
    /// The same over the energy scale, or over all that was dissipated where that is more [-].
    pub numerical_contact_dissipation_share: f64,
    /// Dissipated by friction, all pairs [J].
    pub friction_dissipation_j: f64,
    /// Peak energy of the stabilisation of one-point elements over peak strain energy, of the body where it is largest [-]:
    /// what the mesh does not resolve.
    pub hourglass_energy_share: f64,
    /// The deepest point of one side of a pair inside the other at a field time [m].
    pub deepest_penetration_m: f64,
    /// The same over the size of the nearest face [-].
    pub deepest_penetration_share: f64,
    /// The largest volume that both sides of a pair share at a field time [m³].
    pub overlapped_volume_m3: f64,
    /// The same over the volume of the smaller body [-].
    pub overlapped_volume_share: f64,
    /// Largest difference of the absorbed energy's two computations over the energy scale [-].
    pub absorbed_energy_disagreement: f64,
    /// Largest share of a body's strain energy that was beyond the limits of its laws [-]; 1 where elements have turned over.
    pub energy_share_beyond_law: f64,
}

/// Of what was measured; `outcome` is `None` while the run goes on.
pub(super) fn numerics(measures: &Measures, outcome: Option<&Outcome>) -> Numerics {
    let energy = &measures.energy;
    let scale = energy.scale_j;
    let over = |value: f64, scale: f64| if scale > 0.0 { value / scale } else { 0.0 };
    // An empty sum is −0, and would be printed as such.
    let numerical: f64 = energy.numerical_contact_j() + 0.0;
    let balance = outcome.map_or(0.0, |o| o.balance_error).max(measures.largest_balance_error);
    Numerics {
        smallest_jacobian: outcome.map(|o| o.smallest_jacobian),
        swept_element_share: outcome.map(|o| over(o.swept_element_steps as f64, o.element_steps as f64)),
        smallest_step_s: outcome.map(|o| o.smallest_step_s),
        initial_energy_j: energy.initial_total_j,
        energy_scale_j: scale,
        balance_error: balance,
        numerical_contact_dissipation_j: numerical,
        numerical_contact_dissipation_share: over(numerical, energy.turnover_j),
        friction_dissipation_j: energy.pairs.iter().map(|p| p.friction_j).sum::<f64>() + 0.0,
        hourglass_energy_share: measures.hourglass.largest_share(),
        energy_share_beyond_law: measures.laws.share_beyond(),
        deepest_penetration_m: measures.penetration.deepest.depth,
        deepest_penetration_share: measures.penetration.deepest.share,
        overlapped_volume_m3: measures.penetration.largest.volume,
        overlapped_volume_share: measures.penetration.largest.share,
        absorbed_energy_disagreement: measures.absorbed.as_ref().map_or(0.0, |a| over(a.disagreement, scale)),
    }
}
