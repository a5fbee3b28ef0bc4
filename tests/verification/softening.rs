//! Softening of tissue: fracture energy independent of the mesh, and its place in the energy ledger.

use crate::rig::{assert_at_most, assert_close, loaded, plan, run, summary};
use serde_json::{Value, json};

/// Area of the bars [m²], fracture energy [J/m²].
const AREA: f64 = 16e-6;
const FRACTURE_ENERGY: f64 = 200.0;

/// A bar of 4 × 4 × 8 mm in cubic elements, free at its sides, pulled to more than its double length; a weak row at its lower end softens.
fn pulled_bar(divisions: u32, formulation: &str) -> Value {
    let size = 4e-3 / f64::from(divisions);
    let layer = |name: &str, thickness: f64, elements: u32| json!({"part": name, "thickness_m": thickness, "elements": elements});
    let part = |name: &str, c10: f64| {
        json!({"part": name, "density_kg_per_m3": 1000.0, "formulation": formulation,
            "material": {"law": "neo_hookean", "c10_pa": c10, "bulk_modulus_pa": 4e6, "volumetric": "quadratic"}})
    };
    let mut weak = part("weak", 1e5);
    weak["softening"] = json!({"onset_j_per_m3": 4e4, "fracture_energy_j_per_m2": FRACTURE_ENERGY});
    json!({
        "name": "pulled bar",
        "end_time_s": 0.02,
        "bodies": [{
            "name": "bar", "role": "tissue",
            "mesh": {"generator": {"kind": "layered_block", "size_m": [4e-3, 4e-3], "elements": [divisions, divisions],
                "layers": [layer("strong", 8e-3 - size, 2 * divisions - 1), layer("weak", size, 1)]}},
            "fixed": [{"set": "z_min", "axes": ["z"]}, {"set": "x_min", "axes": ["x"]}, {"set": "y_min", "axes": ["y"]}],
            "prescribed": [{"set": "z_max", "axes": ["z"], "displacement_m": [0, 0, 0.006],
                "ramp": {"kind": "linear", "to_s": 0.02}}],
            "parts": [part("strong", 1e6), weak]
        }],
        "integrator": {"kind": "explicit"},
        "record": {"fields": [], "field_times_s": []}
    })
}

#[test]
fn tearing_a_bar_consumes_the_fracture_energy_of_its_section_on_any_mesh() {
    for (divisions, formulation) in
        [(2, "mean_dilatation"), (3, "mean_dilatation"), (2, "full"), (2, "reduced")]
    {
        let (mut worst, mut end) = (0.0_f64, None);
        run(&plan(&pulled_bar(divisions, formulation)), |frame| {
            worst = worst.max(frame.energy.balance_error);
            end = Some(frame.energy.bodies[0]);
        });
        let what = format!("{divisions} elements across the bar, {formulation}");
        assert_close(
            end.unwrap().viscous_j,
            FRACTURE_ENERGY * AREA,
            0.05,
            &format!("dissipated by a tear: {what}"),
        );
        assert_at_most(worst, 5e-3, &format!("energy balance of a bar that tears: {what}"));
    }
}

#[test]
fn a_torn_layer_is_deleted_and_the_bar_is_in_two() {
    let mut scene = pulled_bar(2, "mean_dilatation");
    scene["bodies"][0]["parts"][1]["erosion"] = json!({"damage": 0.997});
    let (mut worst, mut end) = (0.0_f64, None);
    let (_, state) = run(&plan(&scene), |frame| {
        worst = worst.max(frame.energy.balance_error);
        end = Some(frame.energy.bodies[0]);
    });
    let end = end.unwrap();
    assert_eq!(state.erosion.elements().len(), 4);
    assert_close(
        end.viscous_j,
        FRACTURE_ENERGY * AREA,
        0.05,
        "dissipated by a tear whose elements are deleted",
    );
    // What is left does not strain any more.
    assert_at_most(end.strain_j, 0.01 * FRACTURE_ENERGY * AREA, "strain energy of a bar in two [J]");
    assert_at_most(worst, 5e-3, "energy balance of a bar in two");
}

#[test]
fn the_summary_says_what_exceeded_its_strength() {
    let said = summary(&loaded(&pulled_bar(2, "mean_dilatation"), None));
    let [of_weak] = &said.softening[..] else { panic!("{:?}", said.softening) };
    assert_eq!(of_weak.part, "weak");
    assert_close(of_weak.softened_mm3, 32.0, 1e-9, "softened volume");
    assert_close(of_weak.torn_mm3, 32.0, 1e-9, "torn volume");
    assert!(said.warnings.iter().any(|words| words.contains("exceeded its strength")), "{:?}", said.warnings);
}
