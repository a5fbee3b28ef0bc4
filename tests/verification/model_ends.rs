//! Where the tissue ends: what its back and its base decide is marked, or has a warning.

use crate::plausible::{ball_on_gel, summary};
use contuse::measure::render_table;
use serde_json::json;

#[test]
fn what_reaches_an_end_of_the_model_says_so() {
    let reached = |threshold: f64, end: f64| {
        let mut scene = ball_on_gel([0.0, 0.0, -5.0], end);
        scene["solver"] = json!({"error_bars": "none"});
        scene["measures"]["stress_thresholds_pa"] = json!([threshold]);
        let summary = summary(&scene, None);
        let stress = &summary.values().tissue.as_ref().unwrap().significant_stress[0];
        let ends = [stress.reaches.clone(), stress.depth_reaches.clone()];
        (ends, summary.plain_words.join(" "), render_table(&summary))
    };
    let (ends, words, table) = reached(1.0, 4e-3);
    assert!(ends.iter().all(|ends| ends.iter().any(|end| end.contains("z_min"))), "{ends:?}");
    assert!(words.contains("reaches the held nodes") && words.contains("the model ends there"), "{words}");
    assert!(table.contains("(≥ ") && table.contains("it reaches the held nodes"), "{table}");
    let (none, words, _) = reached(2000.0, 6e-4);
    assert!(none.iter().all(Vec::is_empty) && !words.contains("the model ends there"), "{none:?} {words}");
}

#[test]
fn a_free_surface_is_a_real_end_of_the_tissue_and_held_nodes_are_not() {
    // Held at its bottom, there along z alone, and free: with a surface on all other sides its middle is deepest, also between the nodes.
    for elements in [[8, 8, 6], [7, 7, 5]] {
        for (fixed, deepest_mm, is_cut) in [
            (json!([{"set": "z_min"}]), 30.0, true),
            (json!([{"set": "z_min", "axes": ["z"]}]), 30.0, false),
            (json!([]), 20.0, false),
        ] {
            let mut scene = ball_on_gel([0.0, 0.0, -5.0], 4e-3);
            scene["solver"] = json!({"error_bars": "none"});
            scene["bodies"][1]["fixed"] = fixed;
            scene["bodies"][1]["mesh"]["generator"]["elements"] = json!(elements);
            scene["measures"] = json!({"stress_thresholds_pa": [1.0]});
            let summary = summary(&scene, None);
            let stress = &summary.values().tissue.as_ref().unwrap().significant_stress[0];
            let depth = stress.depth_mm.as_ref().unwrap();
            assert!((depth.value - deepest_mm).abs() < 1e-9, "{elements:?}: {depth:?}");
            assert_eq!(depth.possible, [Some(0.0), Some(depth.value)]);
            // All of it is above the threshold.
            assert!((stress.volume_mm3.value / 144_000.0 - 1.0).abs() < 1e-9, "{stress:?}");
            assert_eq!([depth, &stress.volume_mm3].map(|number| number.is_lower_bound), [is_cut; 2]);
            assert_eq!([&stress.reaches, &stress.depth_reaches].map(|ends| !ends.is_empty()), [is_cut; 2]);
            let table = render_table(&summary);
            assert_eq!(table.contains("it reaches the greatest depth of the tissue"), !is_cut, "{table}");
        }
    }
}

#[test]
fn tissue_that_is_squeezed_against_its_base_has_one_warning_that_a_thicker_one_has_not() {
    let warned = |thickness: f64| {
        let mut scene = ball_on_gel([0.0, 0.0, -8.0], 6e-3);
        scene["solver"] = json!({"error_bars": "none"});
        scene["bodies"][0] = json!({
            "name": "ball", "role": "projectile", "velocity_m_per_s": [0, 0, -8],
            "rigid": {"shape": {"kind": "ball", "radius_m": 0.02}, "center_m": [0, 0, 0.0601], "mass_kg": 0.02}
        });
        scene["bodies"][1]["mesh"]["generator"]["min_m"][2] = json!(0.04 - thickness);
        let summary = summary(&scene, None);
        let is_it = |warning: &String| warning.contains("squeezed gel against");
        // It makes numbers wrong: nothing is before it.
        let found = summary.warnings.iter().position(is_it);
        assert!(found.is_none_or(|at| at == 0), "{:?}", summary.warnings);
        summary.warnings.into_iter().filter(is_it).collect::<Vec<_>>()
    };
    let thin = warned(0.01);
    assert_eq!(thin.len(), 1, "{thin:?}");
    assert!(thin[0].contains("the nodes that hold it") && thin[0].contains("10.00 mm became"), "{thin:?}");
    assert_eq!(warned(0.1), [""; 0]);
}
