//! Surface colours: viridis over a range that is fixed for the whole run.
//!
//! A range that followed the data would make different frames, or different runs, look alike. It must be known before
//! the first step, and is therefore chosen from the plan, see [`range`].

use super::proto::foxglove::Color;
use crate::mechanics::force::PointInput;
use crate::mechanics::tensor::Vec3;
use crate::plan::Plan;
use crate::scene::document::Role;

/// Viridis (van der Walt and Smith 2015) at 17 even steps; linear between them, within 0.023 of the full table.
const VIRIDIS: [[f64; 3]; 17] = [
    [0.2670, 0.0049, 0.3294],
    [0.2823, 0.0950, 0.4173],
    [0.2788, 0.1755, 0.4834],
    [0.2590, 0.2515, 0.5247],
    [0.2297, 0.3224, 0.5457],
    [0.1994, 0.3876, 0.5546],
    [0.1727, 0.4488, 0.5579],
    [0.1490, 0.5081, 0.5573],
    [0.1276, 0.5669, 0.5506],
    [0.1201, 0.6222, 0.5349],
    [0.1539, 0.6802, 0.5042],
    [0.2394, 0.7356, 0.4557],
    [0.3607, 0.7860, 0.3878],
    [0.5063, 0.8288, 0.3004],
    [0.6681, 0.8620, 0.1963],
    [0.8353, 0.8860, 0.1026],
    [0.9932, 0.9062, 0.1439],
];

/// Steps between the ends of the range: as many colours as a screen has grey levels, which compress.
const STEPS: f64 = 255.0;

/// Colour of a value between 0 and `top`, in 255 steps, clamped at the ends.
#[allow(clippy::cast_sign_loss)] // s is clamped
pub fn viridis(value: f64, top: f64) -> Color {
    let last = VIRIDIS.len() - 1;
    let s = ((value / top).clamp(0.0, 1.0) * STEPS).round() / STEPS * last as f64;
    // NaN becomes 0 here; a run with NaN ends as failed before it is drawn.
    let i = (s as usize).min(last - 1);
    let t = s - i as f64;
    let [r, g, b] = std::array::from_fn(|c| VIRIDIS[i][c] + t * (VIRIDIS[i + 1][c] - VIRIDIS[i][c]));
    Color { r, g, b, a: 1.0 }
}

/// Upper end of the colour range of von Mises stress for a run [Pa]; the lower end is 0.
///
/// With a tissue it is the highest threshold of significant stress: saturated regions exceed all of them. Otherwise it
/// is the largest a-priori estimate: the plane-wave pressure `Δv Z₁ Z₂ / (Z₁ + Z₂)` of the impact (impedance Z = ρ c),
/// the largest initial stress, and the weight `ρ g H` of a body; rounded up to 1, 2 or 5 × 10ⁿ.
pub fn range(plan: &Plan) -> f64 {
    let has_tissue = plan.bodies.iter().any(|b| b.role == Role::Tissue);
    match plan.measures.stress_thresholds.last() {
        Some(&threshold) if has_tissue && threshold > 0.0 => threshold,
        _ => nice_above(impact_pressure(plan).max(initial_stress(plan)).max(weight(plan))),
    }
}

/// Plane-wave pressure of the fastest approach of any pair [Pa].
fn impact_pressure(plan: &Plan) -> f64 {
    let Some(contact) = &plan.contact else { return 0.0 };
    let mut impedances = vec![0.0_f64; plan.bodies.len()];
    for block in &plan.blocks {
        let of_block = block.parameters.density * block.parameters.wave_speed();
        impedances[block.body] = of_block.max(impedances[block.body]);
    }
    let impedance = |body: usize| impedances[body];
    let pressure = |(_, (slave, master)): (usize, (usize, Option<usize>))| {
        let (v, Z) = (plan.bodies[slave].flight_velocity, impedance(slave));
        match master {
            Some(m) if plan.bodies[m].rigid.is_some() => Z * (v - plan.bodies[m].flight_velocity).norm(),
            None => Z * v.norm(),
            Some(m) if Z + impedance(m) > 0.0 => {
                (v - plan.bodies[m].flight_velocity).norm() * Z * impedance(m) / (Z + impedance(m))
            }
            Some(_) => 0.0,
        }
    };
    contact.each_bodies().map(pressure).fold(0.0, f64::max)
}

/// Largest von Mises stress at the start [Pa].
fn initial_stress(plan: &Plan) -> f64 {
    let mut largest = 0.0;
    if !plan.initial_u.is_empty() {
        for block in &plan.blocks {
            block.for_each_moved_batch(PointInput::at_rest(&plan.initial_u), &mut |_, points| {
                largest = points.von_mises.iter().flat_map(|row| row.0).fold(largest, f64::max);
            });
        }
    }
    largest
}

/// ρ g H of the heaviest column [Pa].
fn weight(plan: &Plan) -> f64 {
    let Some(g) = plan.gravity else { return 0.0 };
    let up = g.try_normalize(0.0).unwrap_or_else(Vec3::zeros);
    let column = |block: &crate::mechanics::force::ElementBlock| {
        let nodes = &plan.bodies[block.body].nodes;
        let heights = plan.X[nodes.start as usize..nodes.end as usize].iter().map(|x| x.dot(&up));
        let (low, high) = heights.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), h| (a.min(h), b.max(h)));
        block.parameters.density * g.norm() * (high - low).max(0.0)
    };
    plan.blocks.iter().map(column).fold(0.0, f64::max)
}

/// The smallest of 1, 2, 5 × 10ⁿ that is not less than the value; 1 for 0 and for non-finite values.
fn nice_above(value: f64) -> f64 {
    if !(value > 0.0 && value.is_finite()) {
        return 1.0;
    }
    let decade = 10f64.powf(value.log10().floor());
    let factor = [1.0, 2.0, 5.0, 10.0].into_iter().find(|f| f * decade >= value * (1.0 - 1e-12));
    decade * factor.unwrap_or(10.0)
}

#[cfg(test)]
#[allow(clippy::float_cmp)] // these values are exact
mod tests {
    use super::*;

    #[test]
    fn colours_are_clamped_and_monotonic_in_green() {
        assert_eq!(viridis(-1.0, 5.0), viridis(0.0, 5.0));
        assert_eq!(viridis(9.0, 5.0), viridis(5.0, 5.0));
        let greens: Vec<f64> = (0..=50).map(|i| viridis(f64::from(i), 50.0).g).collect();
        assert!(greens.windows(2).all(|w| w[1] > w[0]));
    }

    #[test]
    fn ranges_are_round() {
        assert_eq!([0.3, 1.0, 2.1e5, 7.0, 0.0, f64::NAN].map(nice_above), [0.5, 1.0, 5e5, 10.0, 1.0, 1.0]);
    }
}
