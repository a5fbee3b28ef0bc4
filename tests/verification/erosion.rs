//! Erosion: when elements are deleted, the energy that is lost, and contact on the exposed faces.

use crate::rig::{assert_at_most, assert_close, loaded, plan, run, run_on, summary};
use contuse::step::{Ending, State};
use serde_json::{Value, json};

/// A cube of one element and of a metre, whose upper face is pulled up by a metre in a second.
fn pulled_cube(formulation: &str, erosion: &Value) -> Value {
    json!({
        "name": "pulled cube",
        "end_time_s": 1.0,
        "bodies": [{
            "name": "cube",
            "mesh": {"generator": {"kind": "block", "min_m": [0, 0, 0], "max_m": [1, 1, 1], "elements": [1, 1, 1]}},
            "fixed": [{"set": "z_min"}],
            "prescribed": [{"set": "z_max", "displacement_m": [0, 0, 1], "ramp": {"kind": "linear", "to_s": 1.0}}],
            "parts": [{
                "part": "block", "density_kg_per_m3": 1000.0, "formulation": formulation, "erosion": erosion,
                "material": {"law": "neo_hookean", "c10_pa": 5e3, "bulk_modulus_pa": 2e4}
            }]
        }],
        "integrator": {"kind": "explicit", "max_step_s": 1e-4},
        "record": {"fields": [], "field_times_s": []}
    })
}

#[test]
fn a_cube_tears_at_its_limit_and_takes_its_strain_energy_with_it() {
    for (formulation, relaxes) in
        [("mean_dilatation", false), ("full", false), ("reduced", false), ("full", true), ("reduced", true)]
    {
        let mut scene = pulled_cube(formulation, &json!({"stretch": 1.5}));
        let part = &mut scene["bodies"][0]["parts"][0];
        if relaxes {
            part["prony_series"] = json!({"branches": [{"relative_modulus": 2.0, "relaxation_time_s": 0.2}]});
            part["shear_viscosity_pa_s"] = json!(20.0);
        }
        let (mut last, mut after) = ((0.0, 0.0), None);
        run(&plan(&scene), |frame| {
            let body = &frame.energy.bodies[0];
            if frame.erosion.elements().is_empty() {
                last = (frame.time, body.strain_j);
            } else {
                after = Some((frame.time, *body, frame.energy.balance_error));
            }
        });
        let ((time, strain), (_, body, error)) = (last, after.unwrap());
        // A stretch of 1.5 at half a second.
        assert_close(time, 0.5, 2e-4, &format!("time at which a cube of {formulation} tears"));
        assert_eq!((body.strain_j, body.branches_j), (0.0, 0.0));
        // And half a step of the work of its forces.
        assert_close(body.eroded_j, strain, 1e-3, &format!("energy of the torn element of {formulation}"));
        assert_at_most(error, 3e-4, &format!("energy balance of a cube of {formulation} that tore"));
    }
}

#[test]
fn nothing_tears_below_the_limit_and_crushing_has_its_own() {
    let gone = |erosion: Value, way: f64| {
        let mut scene = pulled_cube("mean_dilatation", &erosion);
        scene["bodies"][0]["prescribed"][0]["displacement_m"] = json!([0, 0, way]);
        run(&plan(&scene), |_| {}).1.erosion.elements().len()
    };
    assert_eq!(gone(json!({"stretch": 1.5}), 0.49), 0);
    assert_eq!(gone(json!({"stretch": 1.5}), 0.51), 1);
    assert_eq!(gone(json!({"volume_ratio": 0.5}), -0.49), 0);
    assert_eq!(gone(json!({"volume_ratio": 0.5}), -0.51), 1);
    assert_eq!(gone(json!({"stretch": 1.5, "volume_ratio": 0.5}), -0.51), 1);
}

fn layer(name: &str, thickness: f64, elements: u32) -> Value {
    json!({"part": name, "thickness_m": thickness, "elements": elements})
}

/// A rigid ball on two layers, the upper of which tears.
fn ball_on_skin() -> Value {
    let part = |name: &str, c10: f64| {
        json!({"part": name, "density_kg_per_m3": 1000.0, "shear_viscosity_pa_s": 2.0, "material":
            {"law": "neo_hookean", "c10_pa": c10, "bulk_modulus_pa": 2e6}})
    };
    let (mut skin, gel) = (part("skin", 1e5), part("gel", 3e4));
    skin["erosion"] = json!({"stretch": 1.25});
    json!({
        "name": "ball on skin",
        "end_time_s": 6e-3,
        "bodies": [
            {"name": "ball", "role": "projectile", "velocity_m_per_s": [0.3, 0, -8],
             "rigid": {"shape": {"kind": "ball", "radius_m": 0.008}, "center_m": [0, 0, 0.0081], "mass_kg": 0.02}},
            {"name": "tissue", "role": "tissue", "fixed": [{"set": "z_min"}], "parts": [skin, gel],
             "mesh": {"generator": {"kind": "layered_block", "size_m": [0.06, 0.06], "elements": [20, 20],
                "layers": [layer("skin", 0.002, 1), layer("gel", 0.024, 8)]}}}
        ],
        "contact": {"friction": 0.3},
        "record": {"fields": [], "field_times_s": []}
    })
}

#[test]
fn what_skin_lays_bare_holds_the_ball() {
    let scene = ball_on_skin();
    let plan = plan(&scene);
    let skin = plan.bodies[1].boundary.nodes.clone();
    let (mut held, mut worst) = (0, 0.0_f64);
    let (_, state) = run(&plan, |frame| {
        let pressed = frame.contacts.iter().zip(frame.reactions).filter(|(_, r)| r.impulse[0] > 0.0);
        let bare = pressed.filter(|(contact, _)| skin.binary_search(&contact.slave).is_err());
        held = held.max(bare.count());
        worst = worst.max(frame.energy.balance_error);
    });
    assert!(state.erosion.elements().len() > 3, "{} elements tore", state.erosion.elements().len());
    assert!(held > 3, "{held} nodes that were inside hold the ball");
    assert_at_most(worst, 5e-3, "energy balance of a ball that tears skin");

    let said = summary(&loaded(&scene, None));
    let [of_skin] = &said.erosion[..] else { panic!("{:?}", said.erosion) };
    assert_eq!((of_skin.part.as_str(), of_skin.elements), ("skin", state.erosion.elements().len()));
    assert_close(of_skin.volume_mm3, 18.0 * of_skin.elements as f64, 1e-9, "volume of the torn elements");
    assert_close(of_skin.mass_kg, 1e-6 * of_skin.volume_mm3, 1e-9, "mass of the torn elements");
    assert!(
        said.warnings.iter().any(|words| words.contains("eroded in skin (tissue)")),
        "{:?}",
        said.warnings
    );
    let depth = said.numerics.deepest_penetration_fraction;
    assert_at_most(depth, 0.1, "penetration of a ball that tears skin, of a face");
}

/// Two rigid boxes on two layers, of which the upper tears under the first, before the second lands.
fn two_boxes_on_skin() -> Value {
    let part = |name: &str| {
        json!({"part": name, "density_kg_per_m3": 1000.0, "material":
            {"law": "neo_hookean", "c10_pa": 2e4, "bulk_modulus_pa": 1e6}})
    };
    let (mut skin, fat) = (part("skin"), part("fat"));
    skin["erosion"] = json!({"stretch": 1.03, "volume_ratio": 0.9});
    let falling = |name: &str, x: f64, z: f64| {
        json!({"name": name, "role": "projectile", "velocity_m_per_s": [0, 0, -5], "rigid": {
            "shape": {"kind": "box", "half_extents_m": [0.006, 0.012, 0.01]}, "center_m": [x, 0, z], "density_kg_per_m3": 7850}})
    };
    json!({
        "name": "two boxes on skin",
        "end_time_s": 3e-3,
        "bodies": [
            falling("first", -0.01, 0.0102),
            falling("second", 0.01, 0.0132),
            {"name": "tissue", "role": "tissue", "fixed": [{"set": "z_min"}], "parts": [skin, fat],
             "mesh": {"generator": {"kind": "layered_block", "size_m": [0.06, 0.06], "elements": [6, 6],
                "layers": [layer("skin", 0.004, 1), layer("fat", 0.04, 4)]}}}
        ],
        "contact": {"friction": 0.3, "pairs": [{"between": ["first", "tissue"]}, {"between": ["second", "tissue"]}]},
        "measures": {"force_window_s": 2e-5},
        "record": {"fields": [], "field_times_s": []}
    })
}

#[test]
fn what_lands_on_tissue_that_is_bare_has_a_patch() {
    let (document, mut first_of_second) = (two_boxes_on_skin(), None);
    run(&plan(&document), |frame| {
        let is_second = |pair: u32| frame.plan.names_of(pair as usize).contains(&"second");
        let mut contacts = frame.contacts.iter().zip(frame.reactions);
        if first_of_second.is_none()
            && contacts.any(|(contact, r)| is_second(contact.pair) && r.impulse[0] > 0.0)
        {
            first_of_second = Some(frame.erosion.elements().len());
        }
    });
    let torn = first_of_second.expect("the second box lands");
    assert!(torn > 0, "nothing has torn before it lands");
    let said = summary(&loaded(&document, None));
    let impacts = &said.values().impacts;
    let second = impacts.iter().find(|of| of.between.contains(&"second".to_owned())).unwrap();
    // The box is 12 × 24 mm large.
    let largest = second.largest_patch_area_mm2.value;
    assert!((150.0..288.0).contains(&largest), "{largest} mm²");
}

#[test]
fn torn_tissue_has_the_same_bits_on_threads_and_after_a_restart() {
    let whole = plan(&ball_on_skin());
    let finish = |plan, state, threads| {
        let (outcome, state) = run_on(plan, state, threads, |_| {});
        assert_eq!(outcome.ending, Ending::Finished);
        state
    };
    let mut first = ball_on_skin();
    first["end_time_s"] = json!(5e-4);
    let mut with_stop = ball_on_skin();
    with_stop["record"]["field_times_s"] = json!([5e-4]);
    let (whole_with_stop, first) = (plan(&with_stop), plan(&first));
    let uninterrupted = finish(&whole_with_stop, State::new(&whole_with_stop), 1);
    let half = finish(&first, State::new(&first), 1);
    assert!(!half.erosion.elements().is_empty() && half.erosion != uninterrupted.erosion);
    assert!(finish(&whole_with_stop, half, 2) == uninterrupted, "a restarted run differs");
    assert!(finish(&whole, State::new(&whole), 2).erosion.elements().len() > 3);
}
