//! Bulk moduli below that of water: the parts that have them, and what studies of other impacts lead to expect of it.
//!
//! A lower modulus has slower pressure waves, and a volume that changes more. What that changes depends on the speed of the impact relative to
//! that of the waves, and on K/G; how much is known from runs on one mesh with several moduli (docs/materials.md), before a run of the scene itself.

use super::by_pair::MOST_LISTED_BODIES;
use super::compiled::Plan;
use crate::mechanics::force::ElementBlock;
use crate::mechanics::tensor::Vec3;
use crate::scene::Scene;
use std::collections::BTreeSet;

/// Largest changes of results by the modulus of the scene in place of that of water, in all studies up to some speed.
struct Studied {
    /// Largest ratio of the speed of the impact to that of pressure waves [-].
    most_speed: f64,
    /// Least K/G [-].
    least_ratio: f64,
    /// What changes, and by how much [%].
    changes: &'static [(&'static str, u32)],
}

/// The studies of docs/materials.md, of README.md in `scenarios/cricket_ball_on_thigh`, and the runs to an accuracy of docs/accuracy.md, all
/// changes rounded up; the slowest first.
const STUDIED: [Studied; 3] = [
    Studied {
        most_speed: 0.12,
        least_ratio: 40.0,
        changes: &[
            ("peak force", 7),
            ("impulse", 1),
            ("energy given to the tissue", 1),
            ("deflection of the surface", 1),
            ("contact patch", 8),
            ("depth of stress", 7),
        ],
    },
    Studied {
        most_speed: 0.47,
        least_ratio: 40.0,
        changes: &[
            ("peak force", 7),
            ("impulse", 2),
            ("energy given to the tissue", 2),
            ("deflection of the surface", 4),
            ("contact patch", 8),
            ("depth of stress", 24),
        ],
    },
    Studied {
        most_speed: 0.94,
        least_ratio: 10.0,
        changes: &[("peak force", 12), ("impulse", 11), ("deflection of the surface", 25)],
    },
];

/// Parts that are meant to keep their volume, with a bulk modulus below that of water, and the effect to be expected of it, in words.
pub(super) fn in_words(plan: &Plan, scene: &Scene) -> Option<String> {
    let of_block = |block: &ElementBlock| block.parameters.material.capped_bulk_modulus();
    let capped: Vec<(&ElementBlock, f64)> =
        plan.blocks.iter().filter_map(|block| Some((block, of_block(block)?))).collect();
    let mut parts = BTreeSet::new();
    for (block, bulk) in &capped {
        let body = &plan.bodies[block.body];
        let megapascals = 1e-6 * bulk;
        let of_part = |part| format!("{part} ({}) {megapascals:.3} MPa", body.name);
        parts.extend(body.parts_of(block).into_iter().map(of_part));
    }
    let listed = parts.into_iter().take(MOST_LISTED_BODIES).collect::<Vec<_>>().join(", ");
    (!listed.is_empty()).then(|| {
        format!(
            "Bulk modulus capped: {listed}; that of water is 2.2 GPa. {}. A run to an accuracy measures the effect on its coarsest mesh, \
             `--lower-bulk-modulus` adds it to the error bars",
            effect_in_words((plan, scene), &capped)
        )
    })
}

/// The effect to be expected of capped blocks, with what that is based on.
fn effect_in_words((plan, scene): (&Plan, &Scene), capped: &[(&ElementBlock, f64)]) -> String {
    let ratio = |block: &ElementBlock, bulk: f64| bulk / block.parameters.material.moduli_at_rest().0;
    let least_ratio = capped.iter().map(|(block, bulk)| ratio(block, *bulk)).fold(f64::INFINITY, f64::min);
    let [low, high] = velocities(plan, scene);
    let relative = |(block, _): &(&ElementBlock, f64)| {
        let own = plan.bodies[block.body].flight_velocity;
        (own - low).sup(&(high - own)).norm() / block.parameters.wave_speed()
    };
    let speed = capped.iter().map(relative).fold(0.0, f64::max);
    // Where nodes are driven, their speed counts, too.
    if speed == 0.0 || !plan.loads.prescribed.is_empty() {
        return "Effect not known before the run: the studies are of impacts, and speeds that bodies do not begin with are not known".into();
    }
    let here = format!("{speed:.2} of the speed of pressure waves and K/G of {least_ratio:.0}");
    let is_covered = |of: &&Studied| speed <= of.most_speed && least_ratio >= of.least_ratio;
    let Some(Studied { most_speed, least_ratio, changes }) = STUDIED.iter().find(is_covered) else {
        return format!("Effect not known before the run: no study has an impact at {here}");
    };
    let changes: Vec<String> =
        changes.iter().map(|(result, percent)| format!("{result} ≤ {percent} %")).collect();
    format!(
        "Effect on {}, in all studies of other impacts up to {most_speed} of the speed of pressure waves with K/G from {least_ratio} on (here \
         {here}): an expectation, no bound",
        changes.join(", ")
    )
}

/// Least and largest components of the initial velocities of all bodies and planes [m/s]. No body is faster relative to another than to the
/// farthest corner of this box.
fn velocities(plan: &Plan, scene: &Scene) -> [Vec3; 2] {
    let planes = (!scene.document.planes.is_empty()).then_some(Vec3::zeros());
    let all = plan.bodies.iter().map(|body| body.flight_velocity).chain(planes);
    let nothing = [Vec3::repeat(f64::INFINITY), Vec3::repeat(f64::NEG_INFINITY)];
    all.fold(nothing, |[low, high], velocity| [low.inf(&velocity), high.sup(&velocity)])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_studies_are_those_of_the_documentation() {
        let text = include_str!("../../docs/materials.md");
        let table = text
            .lines()
            .skip_while(|line| !line.starts_with("| studies up to"))
            .take_while(|line| !line.is_empty());
        let rows: Vec<Vec<&str>> =
            table.map(|line| line.trim_matches('|').split('|').map(str::trim).collect()).collect();
        let [head, _, studies @ ..] = &rows[..] else { panic!("no table in {text}") };
        assert_eq!(studies.len(), STUDIED.len());
        for (cells, of) in studies.iter().zip(&STUDIED) {
            let speed = cells[0].trim_start_matches("v/c = ").split(':').next();
            assert_eq!(speed.and_then(|speed| speed.parse().ok()), Some(of.most_speed), "{cells:?}");
            assert_eq!(cells[1].parse().ok(), Some(of.least_ratio), "{cells:?}");
            let known = head
                .iter()
                .zip(cells)
                .skip(2)
                .filter_map(|(name, cell)| Some((*name, cell.strip_suffix(" %")?)));
            let known: Vec<(&str, u32)> =
                known.map(|(name, percent)| (name, percent.parse().unwrap())).collect();
            assert_eq!(known.len(), of.changes.len(), "{cells:?}");
            for (name, percent) in known {
                let is_it = |(result, _): &&(&str, u32)| result.contains(name);
                let change = of.changes.iter().find(is_it).map(|(_, percent)| *percent);
                assert_eq!(change, Some(percent), "{name} of {cells:?}");
            }
        }
    }
}
