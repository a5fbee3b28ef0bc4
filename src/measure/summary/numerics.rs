//! Quality of the computation.

use super::super::measures::Measures;
use super::listing::{Group, Row};
use super::relaxation::RelaxationOfBody;
use super::written::{number, percent};
use crate::step::Outcome;
use serde::{Deserialize, Serialize};

/// Quality of the computation.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Numerics {
    /// Smallest Jacobian J at any time [-]; absent while running.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub smallest_jacobian: Option<f64>,
    /// Smallest time step [s]; absent while running.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub smallest_step_s: Option<f64>,
    /// Fraction of elements whose internal forces were evaluated, averaged over the steps [-]: nothing had reached the rest yet, or they
    /// were evaluated every second or fourth step only; absent while running.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub active_element_fraction: Option<f64>,
    /// Energy at the start [J].
    pub initial_energy_j: f64,
    /// Energy scale to which errors are related [J].
    pub energy_scale_j: f64,
    /// Largest error of the energy balance [-].
    pub balance_error: f64,
    /// Energy lost by lumped contact nodes at impact activation, all pairs [J]: a discretisation error.
    pub numerical_contact_dissipation_j: f64,
    /// Numerical contact dissipation over the energy scale, or over the total dissipation if that is larger [-].
    pub numerical_contact_dissipation_fraction: f64,
    /// Energy lost by rigid bodies that planes or other rigid bodies have stopped, all pairs [J]: they do not rebound.
    pub rigid_impact_dissipation_j: f64,
    /// Energy dissipated by friction, all pairs [J].
    pub friction_dissipation_j: f64,
    /// Energy dissipated by bulk and shear viscosity and by softening, all bodies [J]; that of relaxation is listed branch by branch.
    #[serde(default)]
    pub viscous_dissipation_j: f64,
    /// Strain energy removed with eroded elements, all bodies [J].
    #[serde(default)]
    pub eroded_energy_j: f64,
    /// Peak energy of the stabilisation of one-point elements over peak strain energy, maximum over the bodies [-]:
    /// deformation that the mesh does not resolve.
    pub hourglass_energy_fraction: f64,
    /// Largest penetration depth between the sides of a pair at a field time [m].
    pub deepest_penetration_m: f64,
    /// Deepest penetration over the size of the nearest face [-].
    pub deepest_penetration_fraction: f64,
    /// Largest overlapping volume of the sides of a pair at a field time [m³].
    pub overlapped_volume_m3: f64,
    /// Largest overlap over the volume of the smaller body [-].
    pub overlapped_volume_fraction: f64,
    /// Largest difference between the two computations of the absorbed energy over the energy scale [-].
    pub absorbed_energy_disagreement: f64,
    /// Largest fraction of a body's strain energy beyond the limits of its laws [-]; 1 if elements have inverted.
    pub energy_fraction_beyond_law: f64,
    /// As above, beyond the limits that the scene, or the set of its library, declares for the laws.
    pub energy_fraction_beyond_declared_limits: f64,
}

/// Evaluates the measures; `outcome` is `None` while the run is in progress.
pub(super) fn numerics(measures: &Measures, outcome: Option<&Outcome>) -> Numerics {
    let energy = &measures.energy;
    let scale = energy.scale_j;
    let over = |value: f64, scale: f64| if scale > 0.0 { value / scale } else { 0.0 };
    // An empty sum is −0, and would be printed as such.
    let numerical: f64 = energy.numerical_contact_j() + 0.0;
    let balance = outcome.map_or(0.0, |o| o.balance_error).max(measures.largest_balance_error);
    Numerics {
        smallest_jacobian: outcome.map(|o| o.smallest_jacobian),
        active_element_fraction: outcome
            .map(|o| over(o.evaluated_element_steps as f64, o.element_steps as f64)),
        smallest_step_s: outcome.map(|o| o.smallest_step_s),
        initial_energy_j: energy.initial_total_j,
        energy_scale_j: scale,
        balance_error: balance,
        numerical_contact_dissipation_j: numerical,
        numerical_contact_dissipation_fraction: over(numerical, energy.turnover_j),
        rigid_impact_dissipation_j: energy.impact_j() + 0.0,
        friction_dissipation_j: energy.pairs.values().map(|p| p.friction_j).sum::<f64>() + 0.0,
        viscous_dissipation_j: energy.bodies.iter().map(|b| b.viscous_j).sum::<f64>()
            - energy.branches.iter().map(|branch| branch.dissipated_j).sum::<f64>()
            + 0.0,
        eroded_energy_j: energy.bodies.iter().map(|b| b.eroded_j).sum::<f64>() + 0.0,
        hourglass_energy_fraction: measures.hourglass.largest_fraction(),
        energy_fraction_beyond_law: measures.laws.fraction_beyond(),
        energy_fraction_beyond_declared_limits: measures.laws.fraction_beyond_declared(),
        deepest_penetration_m: measures.penetration.deepest.depth,
        deepest_penetration_fraction: measures.penetration.deepest.fraction,
        overlapped_volume_m3: measures.penetration.largest.volume,
        overlapped_volume_fraction: measures.penetration.largest.fraction,
        absorbed_energy_disagreement: measures.absorbed.as_ref().map_or(0.0, |a| over(a.disagreement, scale)),
    }
}

/// Its numbers in words, and those of the branches of relaxation.
pub fn numerics_group(n: &Numerics, relaxation: &[RelaxationOfBody]) -> Group<'static> {
    let joules = |energy: f64| format!("{} J", number(energy));
    let smallest = n.smallest_jacobian.map(|J| Row::words("smallest Jacobian J", format!("{J:.4}")));
    let evaluated = n
        .active_element_fraction
        .map(|of| Row::words("elements evaluated, mean over the steps", percent(of)));
    let mut rows: Vec<Row> = smallest.into_iter().chain(evaluated).collect();
    rows.push(Row::words("error of the energy balance", percent(n.balance_error)));
    let fraction = percent(n.numerical_contact_dissipation_fraction);
    let dissipated = format!("{} ({fraction})", joules(n.numerical_contact_dissipation_j));
    rows.push(Row::words("numerical contact dissipation", dissipated));
    if n.rigid_impact_dissipation_j > 0.0 {
        let lost = joules(n.rigid_impact_dissipation_j);
        rows.push(Row::words("lost in rigid–rigid impacts", lost).note("they do not rebound"));
    }
    rows.push(Row::words("friction dissipation", joules(n.friction_dissipation_j)));
    if n.viscous_dissipation_j > 0.0 {
        rows.push(Row::words("dissipated by viscosity and softening", joules(n.viscous_dissipation_j)));
    }
    rows.extend(relaxation.iter().map(|branch| Row::words(branch.title(), branch.in_words())));
    if n.eroded_energy_j > 0.0 {
        rows.push(Row::words("strain energy of eroded elements", joules(n.eroded_energy_j)));
    }
    if n.hourglass_energy_fraction > 0.0 {
        rows.push(Row::words("strain energy in the stabilisation", percent(n.hourglass_energy_fraction)));
    }
    let (depth, of_face) = (1e3 * n.deepest_penetration_m, percent(n.deepest_penetration_fraction));
    rows.push(Row::words("deepest penetration", format!("{} mm ({of_face} of a face)", number(depth))));
    Group { title: "Numerics".into(), nothing_touched: false, rows }
}
