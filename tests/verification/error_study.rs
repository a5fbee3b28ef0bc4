//! The study of error against run time finds known orders, and knows exact values.

use contuse::scene::document::SceneDocument;
use contuse::scene::{Budget, NoFiles};
use contuse::study::Setting;
use contuse::study::error::{ErrorRequest, Quantity, Reference, study_error};
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
        exact: &BTreeMap::from([(Quantity::ImpulseNS, 0.2)]),
        threads: 1,
        interrupt: &|| None,
        progress: &mut |_, _, _| {},
    });
    assert!(study.rows.iter().all(|row| row.ending == "finished"), "{:?}", study.rows);
    assert_eq!(study.references[&Quantity::ImpulseNS], Reference::Exact { value: 0.2 });
    // The caught node loses a share of the impulse that falls with the element.
    let errors: Vec<f64> = study.rows.iter().map(|row| row.errors[&Quantity::ImpulseNS]).collect();
    let order = (errors[0] / errors[2]).log2() / 2.0;
    assert!(errors[2] < 0.02 && order > 0.7, "errors {errors:?}, order {order}");
    // The cheapest mesh that is exact to a tenth is not the finest.
    let advice = study.advice.iter().find(|a| a.quantity == Some(Quantity::ImpulseNS) && a.target > 0.05);
    assert!(advice.is_some_and(|a| a.setting.is_some()), "{:?}", study.advice);
}
