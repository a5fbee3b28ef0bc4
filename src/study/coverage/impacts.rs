//! Impacts of the usual kind without a known answer: balls on layered tissue, to be compared with a much finer mesh.

use serde_json::{Value, json};
use std::f64::consts::{FRAC_1_SQRT_2, SQRT_2};

/// Numbers of elements of the meshes with error bars, in units of those of the document [-]: three levels.
const MESHES: [f64; 3] = [FRAC_1_SQRT_2, 1.0, SQRT_2];
/// Those of the mesh that they are compared with, the fifth level: no error bar has seen it, and its elements have half the size of
/// the finest of the three at most.
const REFERENCE: f64 = 2.0 * SQRT_2;
/// Mesh to compare with in the short list.
const SHORT_REFERENCE: f64 = 2.0;

/// An impact over meshes.
#[derive(Clone, Debug)]
pub struct Impact {
    /// Name of the impact.
    pub scenario: &'static str,
    /// Whether constants of the error bars were chosen on it; the others are for reporting only.
    pub chosen_on: bool,
    /// Scene document of the impact.
    pub document: Value,
    /// Factors on its numbers of elements, of the meshes that have error bars.
    pub meshes: Vec<f64>,
    /// Factor on them of the mesh to compare with.
    pub reference: f64,
    /// Whether the error bars of an accuracy count, too: the mesh to compare with must be finer than its finest.
    pub with_accuracy: bool,
}

/// All impacts; the short list has two of them on the coarsest mesh, compared with one of 2√2 times its numbers of elements.
pub fn impacts(short: bool) -> Vec<Impact> {
    let ball = |radius_m: f64| {
        json!({"rigid": {
        "shape": {"kind": "ball", "radius_m": radius_m}, "center_m": at(radius_m), "density_kg_per_m3": 7850}})
    };
    let rubber = |generator: Value| {
        json!({"mesh": {"generator": generator}, "parts": [
        {"part": "ball", "density_kg_per_m3": 1000,
         "material": {"law": "mooney_rivlin", "c10_pa": 5e5, "c01_pa": 1e5, "bulk_modulus_pa": 1e7}}]})
    };
    let solid = |radius_m: f64| {
        rubber(json!({"kind": "solid_ball", "center_m": at(radius_m), "radius_m": radius_m,
                      "elements_around": 4, "elements_through": 2}))
    };
    let hollow = |outer_m: f64, inner_m: f64| {
        rubber(json!({"kind": "hollow_ball", "center_m": at(outer_m), "outer_radius_m": outer_m,
                      "inner_radius_m": inner_m, "elements_around": 6, "elements_through": 2}))
    };
    // Thickness of skin, fat and muscle [mm]; speed [m/s]; duration [s].
    let all = [
        ("steel ball of 20 mm, 3 m/s", true, ball(0.010), [2.0, 8.0, 20.0], 3.0, 4e-3),
        ("rubber ball of 30 mm, 10 m/s", true, solid(0.015), [2.0, 8.0, 20.0], 10.0, 2e-3),
        ("steel ball of 40 mm, 5 m/s", false, ball(0.020), [2.0, 12.0, 24.0], 5.0, 3e-3),
        ("steel ball of 16 mm, 8 m/s, thin skin", false, ball(0.008), [1.0, 5.0, 20.0], 8.0, 2e-3),
        ("rubber ball of 40 mm, 15 m/s, thick fat", false, solid(0.020), [2.0, 15.0, 15.0], 15.0, 2e-3),
        ("hollow rubber ball of 30 mm, 40 m/s", false, hollow(0.015, 0.012), [2.0, 8.0, 20.0], 40.0, 5e-4),
    ];
    let impact = |(scenario, chosen_on, projectile, layers_mm, speed, end_s)| Impact {
        scenario,
        chosen_on,
        document: document(projectile, layers_mm, speed, end_s),
        meshes: if short { MESHES[..1].to_vec() } else { MESHES.to_vec() },
        reference: if short { SHORT_REFERENCE } else { REFERENCE },
        with_accuracy: !short,
    };
    let is_listed = |scenario: &str| {
        !short || ["steel ball of 20 mm, 3 m/s", "rubber ball of 30 mm, 10 m/s"].contains(&scenario)
    };
    all.into_iter().filter(|(scenario, ..)| is_listed(scenario)).map(impact).collect()
}

/// Centre of a ball just above the skin, beside the middle of the mesh [m].
fn at(radius_m: f64) -> [f64; 3] {
    [0.0013, 0.0007, radius_m + 5e-5]
}

fn document(projectile: Value, layers_mm: [f64; 3], speed: f64, end_s: f64) -> Value {
    let mut ball = projectile;
    ball["name"] = json!("ball");
    ball["role"] = json!("projectile");
    ball["velocity_m_per_s"] = json!([0, 0, -speed]);
    let names = ["skin", "fat", "muscle"];
    let layer = |(i, elements): (usize, u32)| json!({"part": names[i], "thickness_m": 1e-3 * layers_mm[i], "elements": elements});
    let part = |(i, c10_pa): (usize, f64)| {
        json!({"part": names[i], "density_kg_per_m3": 1000,
        "material": {"law": "neo_hookean", "c10_pa": c10_pa, "bulk_modulus_pa": 1e7}})
    };
    let layers: Vec<Value> = [1, 2, 3].into_iter().enumerate().map(layer).collect();
    let parts: Vec<Value> = [2e5, 2e4, 4e4].into_iter().enumerate().map(part).collect();
    json!({
        "name": "ball on tissue", "end_time_s": end_s,
        "bodies": [ball, {
            "name": "tissue", "role": "tissue",
            "mesh": {"generator": {
                "kind": "layered_block", "size_m": [0.09, 0.09], "elements": [10, 10], "grading": [3, 3],
                "layers": layers}},
            "parts": parts,
            "fixed": [{"set": "z_min"}]
        }],
        "contact": {"friction": 0.3},
        "measures": {
            "force_window_s": 0.05 * end_s, "skin_set": "z_max", "stress_thresholds_pa": [1e4, 3e4],
            "strain_energy_density_thresholds_j_per_m3": [1e3], "principal_strain_thresholds": [0.1]
        },
        "record": {"fields": [], "field_interval_s": 0.05 * end_s}
    })
}
