//! Error bars of meshes from files, which cannot be coarsened: they come from a run with every element split into eight.
//!
//! A steel ball hits a layered plate of hexahedra, of tetrahedra, and of hexahedra, wedges and tetrahedra in one file. The numbers are
//! those of the given mesh to the last bit, and their error bars contain those of the mesh split twice, which no error bar has seen.

use crate::rig::{assert_within, loaded, summary};
use contuse::measure::Summary;
use contuse::measure::summary::{ErrorEstimate, Quantity};
use contuse::mesh::Mesh;
use contuse::mesh::generate::layered_block::{Layer, LayeredBlock};
use contuse::mesh::read::{MeshFormat, read_mesh};
use contuse::scene::Loaded;
use serde_json::{Value, json};

/// Skin, fat and muscle from a file, with a steel ball of 20 mm above them.
fn scene() -> Value {
    let part = |name: &str, c10_pa: f64| {
        json!({"part": name, "density_kg_per_m3": 1000,
               "material": {"law": "neo_hookean", "c10_pa": c10_pa, "bulk_modulus_pa": 2e6}})
    };
    json!({
        "name": "steel ball on a plate from a file",
        "end_time_s": 2e-3,
        "bodies": [
            {
                "name": "ball", "role": "projectile",
                "rigid": {"shape": {"kind": "ball", "radius_m": 0.01}, "center_m": [0.0, 0.0, 0.01005], "density_kg_per_m3": 7850},
                "velocity_m_per_s": [0, 0, -3]
            },
            {
                "name": "plate", "role": "tissue",
                "mesh": {"file": {"name": "plate.msh"}},
                "parts": [part("skin", 1e5), part("fat", 1e4), part("muscle", 2e4)],
                "sets": [{"name": "below", "min_m": [-1, -1, -0.0241], "max_m": [1, 1, -0.0239]}],
                "fixed": [{"set": "below"}]
            }
        ],
        "contact": {"friction": 0.3},
        "measures": {"force_window_s": 1e-4},
        "record": {"fields": [], "field_times_s": []}
    })
}

/// The plate of the fixture `layered_plate.msh` of hexahedra only.
fn plate() -> Mesh {
    let layer =
        |part: &str, thickness_m: f64, elements: u32| Layer { part: part.into(), thickness_m, elements };
    let layers = vec![layer("skin", 0.002, 1), layer("fat", 0.008, 2), layer("muscle", 0.014, 2)];
    let plate = LayeredBlock {
        top_center_m: [0.0; 3],
        size_m: [0.06, 0.06],
        layers,
        elements: [6, 6],
        grading: [1.0; 2],
        uniform_within_m: 0.0,
    };
    plate.generate().unwrap()
}

/// Hexahedra and wedges in skin and fat, tetrahedra in the muscle, as Gmsh writes them.
fn mixed_plate() -> Mesh {
    read_mesh(include_bytes!("../data/meshes/layered_plate.msh"), MeshFormat::Gmsh).unwrap()
}

fn without_error_bars(document: &Value) -> Value {
    let mut document = document.clone();
    document["solver"] = json!({"error_bars": "none"});
    document
}

/// Impulse, peak force, deflection and energy given.
fn numbers(summary: &Summary) -> [(&'static str, Quantity); 4] {
    let (impact, tissue) = (&summary.values().impacts[0], summary.values().tissue.as_ref().unwrap());
    [
        ("impulse [N s]", impact.impulse_n_s.clone()),
        ("peak force [N]", impact.peak_force_n.clone()),
        ("deflection [mm]", tissue.deflection_mm.quantity.clone()),
        ("energy given [J]", tissue.energy_given_j.clone()),
    ]
}

fn error_bar(quantity: &Quantity) -> f64 {
    let ErrorEstimate::Estimated(estimate) = &quantity.error else { panic!("no error bar: {quantity:?}") };
    estimate.total
}

/// Runs a scene on a mesh from a file, with its error bars.
fn check(document: &Value, mesh: &Mesh, what: &str) -> Loaded {
    let scene = loaded(document, Some(mesh.clone()));
    let own = summary(&scene);
    assert!(
        own.error_bars.starts_with("estimated from a run with every element split into eight"),
        "{}",
        own.error_bars
    );
    assert!(
        own.error_bars.ends_with("their distance from a curved surface is not in the error bars"),
        "{}",
        own.error_bars
    );
    // The numbers are those of the given mesh.
    let plain = summary(&loaded(&without_error_bars(document), Some(mesh.clone())));
    // Two more splits, of which the error bars have seen one.
    let mut fine = without_error_bars(document);
    fine["bodies"][1]["mesh"]["file"]["refine"] = json!(2);
    let refinements = fine["bodies"][1].get_mut("refinement").and_then(Value::as_array_mut);
    for refinement in refinements.into_iter().flatten() {
        refinement["size_m"] = json!(0.25 * refinement["size_m"].as_f64().unwrap());
    }
    let fine = summary(&loaded(&fine, Some(mesh.clone())));
    for (((name, own), (_, plain)), (_, fine)) in
        numbers(&own).into_iter().zip(numbers(&plain)).zip(numbers(&fine))
    {
        assert_eq!(own.value, plain.value, "{what}: {name}");
        println!(
            "{what}: {name} {:.4e} ± {:.1e}, split twice {:.4e}",
            own.value,
            error_bar(&own),
            fine.value
        );
        assert_within(own.value, fine.value, error_bar(&own), &format!("{what}: {name}"));
    }
    scene
}

#[test]
fn meshes_of_every_kind_have_error_bars_that_contain_finer_meshes() {
    check(&scene(), &plate(), "hexahedra");
    check(&scene(), &plate().split_to_tetrahedra(), "tetrahedra");
    check(&scene(), &mixed_plate(), "hexahedra, wedges and tetrahedra");
}

#[test]
fn a_mesh_from_a_file_is_refined_around_the_impact_and_has_error_bars() {
    let mut refined = scene();
    refined["bodies"][1]["refinement"] = json!([{"around": "impact", "within_m": 0.008, "size_m": 0.006}]);
    let Loaded { scene, .. } = check(&refined, &plate(), "refined around the impact");
    let [before, split] = scene.bodies[1].refined.unwrap();
    assert!(before == 180 && split > 0 && scene.element_count() == before + 7 * split, "{before} {split}");
}

#[test]
fn ten_node_tetrahedra_are_said_to_have_no_error_bars() {
    let mesh = plate().split_to_tetrahedra().to_quadratic_tetrahedra();
    let mut short = scene();
    short["end_time_s"] = json!(1e-4);
    let summary = summary(&loaded(&short, Some(mesh)));
    assert!(summary.error_bars.contains("tetrahedron of 10 nodes"), "{}", summary.error_bars);
}
