//! The impact point moved over the surface of any mesh: against straight lines, arcs of a ball, and the section of a limb.

use contuse::mechanics::tensor::Vec3;
use contuse::mesh::write::gmsh::{Encoding, Version, write_gmsh};
use contuse::scene::document::{RotationDocument, SceneDocument};
use contuse::scene::{Budget, FolderSource, Loaded, MeshSource, NoFiles, load};
use contuse::study::what_if::document::Change;
use contuse::study::what_if::{BaseFacts, Cache, WhatIfDocument, WhatIfRequest, check, study_what_if};
use nalgebra::{Rotation3, Unit};
use serde_json::{Value, json};

const BALL_RADIUS: f64 = 0.05;
/// From the surface to the centre of the projectile [m].
const HEIGHT: f64 = 0.011;

fn part(name: &str) -> Value {
    json!({"part": name, "density_kg_per_m3": 1000,
           "material": {"law": "neo_hookean", "c10_pa": 2e4, "bulk_modulus_pa": 2e6}})
}

/// A steel ball that flies at a body with a mesh.
fn scene(mesh: &Value, parts: &[&str], center: Vec3, velocity: Vec3) -> Value {
    json!({
        "name": "over the surface", "end_time_s": 1e-4,
        "bodies": [
            {"name": "steel", "role": "projectile",
             "rigid": {"shape": {"kind": "ball", "radius_m": 0.0105}, "center_m": center.as_slice(), "mass_kg": 0.03},
             "velocity_m_per_s": velocity.as_slice(), "spin_rad_per_s": [3, 0, 1]},
            {"name": "body", "role": "tissue", "mesh": mesh,
             "parts": parts.iter().map(|name| part(name)).collect::<Vec<_>>()}
        ]
    })
}

fn ball(elements: u32) -> Value {
    json!({"generator": {"kind": "solid_ball", "radius_m": BALL_RADIUS, "elements_around": elements, "elements_through": 1}})
}

fn block() -> Value {
    json!({"generator": {"kind": "block", "min_m": [-0.06, -0.05, -0.03], "max_m": [0.06, 0.05, 0], "elements": [12, 10, 3]}})
}

fn loaded(scene: &Value, source: &dyn MeshSource) -> Loaded {
    load(&serde_json::to_vec(scene).unwrap(), source, &Budget::COMMAND_LINE).unwrap()
}

fn over(along: [f64; 3]) -> Change {
    Change::ImpactOffset { body: None, target: None, along }
}

/// The document after these changes, one after the other.
fn changed(base: &Loaded, source: &(dyn MeshSource + Sync), changes: &[(Change, f64)]) -> SceneDocument {
    let facts = BaseFacts::of(base, source, &Budget::COMMAND_LINE);
    let mut scene = base.scene.document.clone();
    for (change, value) in changes {
        change.apply(*value, &mut scene, &facts).unwrap();
    }
    scene
}

fn center(scene: &SceneDocument) -> Vec3 {
    scene.bodies[0].rigid.as_ref().unwrap().center_m.into()
}

fn velocity(scene: &SceneDocument) -> Vec3 {
    scene.bodies[0].velocity_m_per_s.into()
}

fn turned(rotation: Option<&RotationDocument>) -> Rotation3<f64> {
    rotation.map_or_else(Rotation3::identity, |rotation| {
        let axis = Unit::new_normalize(Vec3::from(rotation.axis));
        Rotation3::from_axis_angle(&axis, rotation.angle_deg.to_radians())
    })
}

#[test]
fn on_a_flat_block_it_is_a_straight_line() {
    let base = loaded(
        &scene(&block(), &["block"], Vec3::new(0.005, 0.0, HEIGHT), Vec3::new(1.0, 2.0, -30.0)),
        &NoFiles,
    );
    for (along, straight) in [
        ([1.0, 0.0, 0.0], [1.0, 0.0, 0.0]),
        ([0.0, -2.0, 0.0], [0.0, -1.0, 0.0]),
        ([1.0, 3.0, 7.0], [1.0, 3.0, 0.0]),
    ] {
        for value in [-0.04, -0.01, 0.0, 1e-9, 0.0173, 0.04] {
            let over = changed(&base, &NoFiles, &[(over(along), value)]);
            let offset = changed(&base, &NoFiles, &[(Change::Offset { body: None, along: straight }, value)]);
            assert!((center(&over) - center(&offset)).norm() < 1e-15);
            assert!((velocity(&over) - velocity(&offset)).norm() < 1e-13);
            assert!(turned(over.bodies[0].rigid.as_ref().unwrap().rotation.as_ref()).angle() < 1e-14);
        }
    }
}

#[test]
fn on_a_ball_place_and_flight_turn_by_the_arc() {
    let up = Vec3::new(0.2, -0.3, 1.0).normalize();
    let slanted = -(up * 20.0) + Vec3::new(1.0, 1.0, 0.0);
    let drift = Vec3::new(0.0, 4.0, -2.0);
    // The flight as seen from the ball, which drifts itself, meets it where its normal is `up`.
    let mut errors = Vec::new();
    for elements in [6, 12] {
        let start = up * BALL_RADIUS - slanted * (0.03 / 20.0);
        let mut document = scene(&ball(elements), &["ball"], start, slanted + drift);
        document["bodies"][1]["velocity_m_per_s"] = json!(drift.as_slice());
        let base = loaded(&document, &NoFiles);
        let along = Vec3::new(1.0, 0.5, 0.0);
        let mut worst: f64 = 0.0;
        for arc in [-2.5_f64, -0.4, 0.05, 0.7, 1.9, 3.1] {
            let over = changed(&base, &NoFiles, &[(over(along.into()), arc * BALL_RADIUS)]);
            let turn = Rotation3::from_axis_angle(&Unit::new_normalize(up.cross(&along)), arc);
            worst = worst.max((center(&over) - turn * start).norm() / BALL_RADIUS);
            let flight = velocity(&over) - drift;
            worst = worst.max((flight - turn * slanted).norm() / slanted.norm());
            let spin = Vec3::from(over.bodies[0].spin_rad_per_s) - turn * Vec3::new(3.0, 0.0, 1.0);
            worst = worst.max(spin.norm() / 10.0_f64.sqrt());
            let pose = turned(over.bodies[0].rigid.as_ref().unwrap().rotation.as_ref());
            worst = worst.max((turn.inverse() * pose).angle());
            // It does not come nearer to the surface than the facets are deep.
            assert!((flight.norm() - slanted.norm()).abs() < 1e-12);
        }
        errors.push(worst);
    }
    // The facets are deep by the square of their size: 90°/n along a quarter of a great circle.
    let depth = |n: f64| (1.0 - (std::f64::consts::FRAC_PI_2 / n / 2.0_f64.sqrt()).cos()) * 3.1;
    assert!(errors[0] < depth(6.0) && errors[1] < depth(12.0), "{errors:?}");
    assert!(errors[0] / errors[1] > 3.0, "{errors:?}");
}

#[test]
fn two_ways_one_after_the_other_stay_on_the_ball() {
    let base = loaded(
        &scene(&ball(8), &["ball"], Vec3::new(0.0, 0.0, BALL_RADIUS + HEIGHT), Vec3::new(0.0, 0.0, -10.0)),
        &NoFiles,
    );
    let both = changed(&base, &NoFiles, &[(over([1.0, 0.0, 0.0]), 0.04), (over([0.0, 1.0, 0.0]), -0.05)]);
    let radial = center(&both).normalize();
    assert!((velocity(&both) + radial * 10.0).norm() < 0.02, "still straight at the ball");
    assert!((center(&both).norm() - BALL_RADIUS - HEIGHT).abs() < 5e-4);
}

#[test]
fn on_a_limb_it_is_the_arc_of_the_section() {
    let (a, b) = (0.075_f64, 0.05_f64);
    let mut errors = Vec::new();
    for around in [24, 48] {
        let limb = json!({"generator": {"kind": "limb_segment", "semi_axis_x_m": a, "semi_axis_z_m": b, "length_m": 0.2,
            "bone_semi_axis_x_m": 0.01, "bone_semi_axis_z_m": 0.01, "fat_thickness_m": 0.005, "skin_thickness_m": 0.002,
            "elements_around": around, "elements_along": 4, "muscle_elements": 1, "fat_elements": 1, "skin_elements": 1}});
        let start = Vec3::new(0.0, 0.013, b + HEIGHT);
        let document = scene(&limb, &["muscle", "fat", "skin"], start, Vec3::new(2.0, 1.0, -30.0));
        // The flight is slanted: it is aimed so that it meets the top of the limb.
        let aimed = start - Vec3::new(2.0, 1.0, 0.0) * (HEIGHT / 30.0);
        let mut document = document;
        document["bodies"][0]["rigid"]["center_m"] = json!(aimed.as_slice());
        let base = loaded(&document, &NoFiles);
        let mut worst: f64 = 0.0;
        for degrees in [-70.0_f64, -20.0, 35.0, 90.0, 130.0] {
            let around = Change::ImpactAround { body: None, limb: None };
            let known = changed(&base, &NoFiles, &[(around, degrees)]);
            let over = changed(&base, &NoFiles, &[(over([1.0, 0.0, 0.0]), arc(a, b, degrees.to_radians()))]);
            worst = worst.max((center(&over) - center(&known)).norm() / a);
            worst = worst.max((velocity(&over) - velocity(&known)).norm() / 30.0);
        }
        errors.push(worst);
    }
    assert!(errors[1] < 0.01 && errors[0] / errors[1] > 3.0, "{errors:?}");
}

/// Length of the ellipse x = a sin τ, z = b cos τ from the top to the direction at an angle from +z towards +x, by Simpson's rule.
fn arc(a: f64, b: f64, angle: f64) -> f64 {
    let end = (b * angle.sin()).atan2(a * angle.cos());
    let speed = |fraction: f64| {
        let tau = end * fraction;
        (a * tau.cos()).hypot(b * tau.sin())
    };
    let pieces = 200;
    let h = 1.0 / f64::from(pieces);
    let at = |i: u32| f64::from(i) * h;
    let simpson = |i: u32| speed(at(i)) + 4.0 * speed(at(i) + 0.5 * h) + speed(at(i + 1));
    end * h / 6.0 * (0..pieces).map(simpson).sum::<f64>()
}

#[test]
fn an_uploaded_mesh_is_walked_over_and_its_edits_make_the_case() {
    let folder = tempfile::tempdir().unwrap();
    let generated =
        scene(&ball(5), &["ball"], Vec3::new(0.0, 0.0, BALL_RADIUS + HEIGHT), Vec3::new(0.0, 0.0, -30.0));
    let of_generator = loaded(&generated, &NoFiles);
    // In millimetres, as files are.
    let in_mm = of_generator.scene.bodies[1]
        .mesh
        .transformed(&Rotation3::identity(), &Vec3::zeros(), 1000.0)
        .unwrap();
    let bytes = write_gmsh(&in_mm, Version::V4_1, Encoding::LittleEndian);
    std::fs::write(folder.path().join("body.msh"), bytes).unwrap();
    let mut uploaded = generated.clone();
    uploaded["bodies"][1]["mesh"] = json!({"file": {"name": "body.msh"}});
    uploaded["bodies"][1]["placement"] = json!({"scale": 0.001});
    let source = FolderSource::new(folder.path());
    let base = loaded(&uploaded, &source);

    let question: WhatIfDocument = serde_json::from_value(json!({
        "parameters": [{"name": "over", "low": -0.03, "high": 0.03,
                        "change": {"kind": "impact_offset_m", "body": "steel", "target": "body", "along": [1, 0, 0]}}],
        "one_at_a_time": true, "error_bars": "none"
    }))
    .unwrap();
    check(&question, &base, &source, &Budget::COMMAND_LINE).unwrap();
    let answer = study_what_if(&mut WhatIfRequest {
        question: &question,
        base: &base,
        source: &source,
        budget: &Budget::COMMAND_LINE,
        threads: 2,
        cache: &Cache::default(),
        shares_plans: true,
        interrupt: &|| None,
        report: &mut |_| {},
    });
    assert!(answer.cases.iter().all(|case| case.ending == "finished"), "{:?}", answer.cases);
    for (case, value) in answer.cases[1..].iter().zip([-0.03, 0.03]) {
        let mut edited = serde_json::to_value(&base.scene.document).unwrap();
        for (pointer, value) in &case.edits {
            match edited.pointer_mut(pointer) {
                Some(place) => *place = value.clone(),
                None => panic!("{pointer}"),
            }
        }
        let expected = changed(&of_generator, &NoFiles, &[(over([1.0, 0.0, 0.0]), value)]);
        let edited: SceneDocument = serde_json::from_value(edited).unwrap();
        assert!(
            (center(&edited) - center(&expected)).norm() < 1e-9,
            "{:?} {:?}",
            center(&edited),
            center(&expected)
        );
        assert!((velocity(&edited) - velocity(&expected)).norm() < 1e-6);
    }
}

#[test]
fn all_that_does_not_fit_is_reported_at_once() {
    let mut document = scene(&block(), &["block"], Vec3::new(0.0, 0.0, HEIGHT), Vec3::new(0.0, 0.0, -30.0));
    let lost = json!({"name": "lost", "rigid": {"shape": {"kind": "ball", "radius_m": 0.01}, "center_m": [1, 0, 0], "mass_kg": 1},
                      "velocity_m_per_s": [0, 0, -1]});
    let post = json!({"name": "post", "rigid": {"shape": {"kind": "ball", "radius_m": 0.0105}, "center_m": [-0.03, 0, HEIGHT], "mass_kg": 1}});
    document["bodies"].as_array_mut().unwrap().extend([lost, post]);
    let base = loaded(&document, &NoFiles);
    let refused = |changes: &[Value]| -> Vec<[String; 2]> {
        let parameter = |(index, change): (usize, &Value)| json!({"name": format!("p{index}"), "change": change, "low": -0.02, "high": 0.07});
        let parameters: Vec<Value> = changes.iter().enumerate().map(parameter).collect();
        let question: WhatIfDocument =
            serde_json::from_value(json!({"parameters": parameters, "one_at_a_time": true})).unwrap();
        let problems = check(&question, &base, &NoFiles, &Budget::COMMAND_LINE).unwrap_err();
        assert!(
            problems.iter().all(|problem| !problem.remedy.is_empty() && !problem.value.is_null()),
            "{problems:#?}"
        );
        problems.into_iter().map(|problem| [problem.pointer, problem.limit]).collect()
    };
    let over = |more: Value| {
        let mut change = json!({"kind": "impact_offset_m", "along": [1, 0, 0]});
        change.as_object_mut().unwrap().extend(more.as_object().unwrap().clone());
        change
    };
    let found = refused(&[
        over(json!({"along": [0, 0, 0]})),
        over(json!({"along": [0, 0, 3]})),
        over(json!({"target": "boddy"})),
        over(json!({"target": "lost"})),
        over(json!({"target": "steel"})),
        over(json!({"body": "lost", "target": "body"})),
        over(json!({"body": "lost"})),
        over(json!({"body": "absent"})),
    ]);
    let mut places: Vec<&str> = found.iter().map(|[pointer, _]| pointer.as_str()).collect();
    places.sort_unstable();
    places.dedup();
    let fields = ["along", "along", "target", "target", "target", "target", "body", "body"];
    let expected: Vec<String> = fields
        .iter()
        .enumerate()
        .map(|(index, field)| format!("/parameters/{index}/change/{field}"))
        .collect();
    assert_eq!(places, expected);

    // The edge of the block is 60 mm from its middle, and a post stands in the way to the other side.
    let found = refused(&[over(json!({}))]);
    assert_eq!(found[0][0], "/parameters/0/low");
    assert_eq!(found[1..], [["/parameters/0/high", "less than 6.0000e-2 m in this direction"]]);
}
