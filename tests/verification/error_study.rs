//! The study of error against run time: it finds known orders, and uses exact values.

use crate::record::{assert_at_most, assert_close, assert_order};
use contuse::measure::QuantityOfInterest;
use contuse::scene::document::SceneDocument;
use contuse::scene::{Budget, NoFiles, load};
use contuse::study::Setting;
use contuse::study::error::{ErrorRequest, Ladder, Reference, Row, study_error};
use serde_json::json;
use std::collections::BTreeMap;

/// The bar of `scenarios/bar_on_wall`, coarse; its impulse is 2 m v0.
fn bar(elements: u32) -> SceneDocument {
    let document = json!({
        "name": "bar", "end_time_s": 1.5,
        "bodies": [{
            "name": "bar", "role": "projectile", "velocity_m_per_s": [0, 0, -0.01],
            "mesh": {"generator": {"kind": "block", "min_m": [0, 0, 0.005], "max_m": [1, 1, 10.005],
                     "elements": [1, 1, elements]}},
            "parts": [{"part": "block", "density_kg_per_m3": 1,
                       "material": {"law": "coupled_neo_hookean", "mu_pa": 450, "lambda_pa": 0}}]
        }],
        "planes": [{"name": "wall", "point_m": [0, 0, 0], "normal": [0, 0, 1]}],
        "integrator": {"kind": "explicit", "linear_bulk_viscosity": 0, "quadratic_bulk_viscosity": 0},
        "measures": {"force_window_s": 0.1},
        "record": {"fields": [], "field_times_s": []}
    });
    serde_json::from_value(document).unwrap()
}

#[test]
fn impulse_of_the_bar_converges_to_its_exact_value() {
    let ladder = [0, 1, 2].map(|mesh_level| Setting { mesh_level, ..Setting::OWN });
    let study = study_error(&mut ErrorRequest {
        document: &bar(10),
        source: &NoFiles,
        budget: &Budget::COMMAND_LINE,
        ladder: &ladder,
        known: &BTreeMap::from([(QuantityOfInterest::ImpulseNS, Reference::Exact { value: 0.2 })]),
        threads: 1,
        interrupt: &|| None,
        progress: &mut |_, _, _| {},
    });
    assert!(study.rows.iter().all(|row| row.ending == "finished"), "{:?}", study.rows);
    assert_eq!(study.references[&QuantityOfInterest::ImpulseNS], Reference::Exact { value: 0.2 });
    // On impact activation the contact node loses a fraction of the impulse that falls with the element.
    let errors: Vec<f64> = study.rows.iter().map(|row| row.errors[&QuantityOfInterest::ImpulseNS]).collect();
    assert_at_most(errors[2], 0.02, "relative error of the impulse on the finest mesh");
    assert_order(&errors, 0.7, "impulse of the bar, in the study");
    // The cheapest mesh that is exact to a tenth is not the finest.
    let advice =
        study.advice.iter().find(|a| a.quantity == Some(QuantityOfInterest::ImpulseNS) && a.target > 0.05);
    assert!(advice.is_some_and(|a| a.setting.is_some()), "{:?}", study.advice);
}

/// What facets do to the mass of a ball, which is known exactly: 4/3 π R³ ρ.
#[test]
fn a_split_on_the_facets_separates_the_error_of_the_geometry() {
    let document = |around: u32, through: u32| {
        json!({
            "name": "ball", "end_time_s": 1e-4,
            "bodies": [{
                "name": "ball", "velocity_m_per_s": [0, 0, -1],
                "mesh": {"generator": {"kind": "solid_ball", "center_m": [0, 0, 1.001], "radius_m": 1,
                         "elements_around": around, "elements_through": through}},
                "parts": [{"part": "ball", "density_kg_per_m3": 1000,
                           "material": {"law": "neo_hookean", "c10_pa": 1e5, "bulk_modulus_pa": 1e7}}]
            }],
            "planes": [{"name": "wall", "point_m": [0, 0, 0], "normal": [0, 0, 1]}]
        })
    };
    let scene = |around: u32, through: u32| {
        let bytes = document(around, through).to_string();
        load(bytes.as_bytes(), &NoFiles, &Budget::COMMAND_LINE).unwrap().scene
    };
    let (own, finer) = (scene(4, 2), scene(8, 4));
    let mut on_facets = own.clone();
    on_facets.split_on_facets().unwrap();
    let [own_volume, on_facets_volume, finer_volume] =
        [&own, &on_facets, &finer].map(|scene| scene.bodies[0].mesh.volume_m3());
    assert_eq!(on_facets.bodies[0].mesh.cells.len(), finer.bodies[0].mesh.cells.len());
    assert_eq!(on_facets.bodies[0].part_entry.len(), finer.bodies[0].part_entry.len());
    assert_close(on_facets_volume, own_volume, 1e-12, "volume of the ball, split on its facets [m³]");
    let exact = 4.0 / 3.0 * std::f64::consts::PI;
    // Second order is assumed of the facets, and is what they have.
    let estimated = 4.0 / 3.0 * (finer_volume - on_facets_volume);
    assert_close(
        estimated,
        exact - own_volume,
        0.05,
        "volume that facets take off the ball, by the estimate [m³]",
    );
}

#[test]
fn geometry_is_separated_where_a_generator_knows_a_curved_surface() {
    let study_of = |document: &SceneDocument| {
        let ladder = Ladder {
            levels: 0..=1,
            half_levels: false,
            formulations: &[],
            implicit_steps_s: &[],
            contact_solvers: &[],
            geometry: true,
            combined: false,
        };
        study_error(&mut ErrorRequest {
            document,
            source: &NoFiles,
            budget: &Budget::COMMAND_LINE,
            ladder: &ladder.settings()[..3],
            known: &BTreeMap::new(),
            threads: 1,
            interrupt: &|| None,
            progress: &mut |_, _, _| {},
        })
    };
    // A block is all facets.
    let study = study_of(&bar(2));
    assert!(study.geometry.is_empty());
    let omitted = study.rows.iter().find(|row| row.setting.on_facets).unwrap();
    assert_eq!(omitted.reason.as_deref(), Some("no generator of the scene has a curved surface"));

    let mut ball = bar(2);
    let mesh = json!({"generator": {"kind": "solid_ball", "center_m": [0, 0, 1.005], "radius_m": 1,
                      "elements_around": 2, "elements_through": 1}});
    ball.bodies[0].mesh = serde_json::from_value(mesh).unwrap();
    ball.bodies[0].parts[0].part = "ball".into();
    let study = study_of(&ball);
    let value = |on_facets: bool, level: i32| {
        let row = |row: &&Row| row.setting.on_facets == on_facets && row.setting.mesh_level == level;
        study.rows.iter().find(row).unwrap().values[&QuantityOfInterest::ImpulseNS]
    };
    let (own, fine, on_facets) = (value(false, 0), value(false, 1), value(true, 1));
    let geometry = study.geometry[&QuantityOfInterest::ImpulseNS];
    assert_close(geometry.change, 1.0 - own / fine, 1e-12, "change of the impulse from mesh to mesh");
    assert_close(geometry.change_by_surface, 1.0 - on_facets / fine, 1e-12, "what of it is the surface's");
    // A ball that has bounced has taken an impulse that goes with its mass, and facets take mass away.
    assert!(geometry.change_by_surface > 0.0 && geometry.change_by_surface < 1.0, "{geometry:?}");
}
