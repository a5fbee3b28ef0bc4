//! Ordinary impacts, as a user would try first: five projectiles on three tissues at six speeds, on three meshes, with
//! two formulations, all central and until the end of contact.

use super::scenes::Case;
use serde_json::{Value, json};

/// Speeds of the projectiles [m/s].
const SPEEDS: [f64; 6] = [2.0, 5.0, 12.0, 30.0, 60.0, 100.0];
/// Numbers of elements along a length, up to a factor.
const MESHES: [u32; 3] = [2, 3, 4];
/// Latest end of a run [s]; contact with gel lasts 5 to 10 ms.
const END: f64 = 0.02;
/// Initial distance of the projectile from the surface of the tissue, which is at z = 0 [m].
const GAP: f64 = 1e-4;
/// Bulk modulus of all materials except bone [Pa].
const BULK: f64 = 5e7;

/// Projectiles of the matrix.
const PROJECTILES: [&str; 5] =
    ["rigid ball", "rigid baton", "rubber ball", "hollow ball", "rigid box corner"];
/// Tissues of the matrix.
const TISSUES: [&str; 3] = ["gel block", "layered plate", "limb"];

/// All ordinary impacts on a number of meshes, the coarsest first; the short list has one mesh, one formulation, and
/// two speeds.
pub fn ordinary_impacts(short: bool, meshes: usize) -> Vec<Case> {
    let speeds = if short { &SPEEDS[2..4] } else { &SPEEDS[..] };
    let meshes = &MESHES[..if short { 1 } else { meshes.min(MESHES.len()) }];
    let formulations: &[&str] = if short { &["mean_dilatation"] } else { &["mean_dilatation", "reduced"] };
    let mut cases = Vec::new();
    for projectile in PROJECTILES {
        for tissue in TISSUES {
            for formulation in formulations {
                for speed in speeds {
                    for (level, mesh) in meshes.iter().enumerate() {
                        cases.push(Case {
                            axis: format!("{projectile} on {tissue}, {}", formulation.replace('_', " ")),
                            label: format!("{speed} m/s, mesh {}", level + 1),
                            is_physical: true,
                            ends_with_contact: true,
                            document: document(projectile, tissue, formulation, *speed, *mesh),
                        });
                    }
                }
            }
        }
    }
    cases
}

fn document(projectile: &str, tissue: &str, formulation: &str, speed: f64, n: u32) -> Value {
    let mut bodies = [projectile_body(projectile, n), tissue_body(tissue, n)];
    bodies[0]["role"] = json!("projectile");
    bodies[0]["velocity_m_per_s"] = json!([0, 0, -speed]);
    bodies[1]["role"] = json!("tissue");
    for body in &mut bodies {
        for part in body.get_mut("parts").and_then(Value::as_array_mut).into_iter().flatten() {
            part["formulation"] = json!(formulation);
        }
    }
    json!({
        "name": "ordinary impact",
        "end_time_s": END,
        "bodies": bodies,
        "contact": {"friction": 0.3},
        "record": {"fields": [], "field_interval_s": END / 100.0},
        "solver": {"error_bars": "none"}
    })
}

/// A projectile whose lowest point is just above z = 0.
fn projectile_body(name: &str, n: u32) -> Value {
    let rigid = |shape: Value, lowest: f64, mass_kg: f64| {
        json!({
            "name": "projectile",
            "rigid": {"shape": shape, "mass_kg": mass_kg, "center_m": [0, 0, lowest + GAP]}
        })
    };
    let rubber = |generator: Value| {
        json!({
            "name": "projectile",
            "mesh": {"generator": generator},
            "placement": {"translation_m": [0, 0, 0.022 + GAP]},
            "parts": [{"part": "ball", "density_kg_per_m3": 1000, "material":
                {"law": "mooney_rivlin", "c10_pa": 5e5, "c01_pa": 1e5, "bulk_modulus_pa": BULK}}]
        })
    };
    match name {
        // A cricket ball.
        "rigid ball" => rigid(json!({"kind": "ball", "radius_m": 0.036}), 0.036, 0.16),
        // A 37 mm baton round, end on.
        "rigid baton" => {
            let shape =
                json!({"kind": "cylinder", "radius_m": 0.0185, "half_length_m": 0.05, "axis": [0, 0, 1]});
            rigid(shape, 0.05, 0.14)
        }
        "rubber ball" => rubber(json!({
            "kind": "solid_ball", "radius_m": 0.022, "elements_around": 2 * n, "elements_through": n
        })),
        "hollow ball" => rubber(json!({
            "kind": "hollow_ball", "outer_radius_m": 0.022, "inner_radius_m": 0.01567, "elements_around": 3 * n,
            "elements_through": n.div_ceil(2)
        })),
        // A cube of 50 mm on its corner: the diagonal is aligned with z.
        _ => {
            let shape = json!({"kind": "box", "half_extents_m": [0.025, 0.025, 0.025]});
            let mut body = rigid(shape, 0.025 * 3.0_f64.sqrt(), 0.125);
            let angle = (1.0 / 3.0_f64.sqrt()).acos().to_degrees();
            body["rigid"]["rotation"] = json!({"axis": [1, -1, 0], "angle_deg": angle});
            body
        }
    }
}

/// A tissue whose surface touches z = 0 from below, fixed at its back or its bone.
fn tissue_body(name: &str, n: u32) -> Value {
    // Viscosities as shear waves of 100 to 400 Hz measure them (sources in docs/scene.md), that of fat taken like that of skin.
    let soft = |part: &str, density: f64, c10_pa: f64, viscosity: f64| {
        json!({
            "part": part, "density_kg_per_m3": density, "shear_viscosity_pa_s": viscosity,
            "material": {"law": "neo_hookean", "c10_pa": c10_pa, "bulk_modulus_pa": BULK}
        })
    };
    let layer = |part: &str, thickness_m: f64, elements: u32| {
        json!({
            "part": part, "thickness_m": thickness_m, "elements": elements
        })
    };
    let block = |layers: Value, parts: Value| {
        json!({
            "name": "tissue",
            "mesh": {"generator": {"kind": "layered_block", "size_m": [0.16, 0.16], "layers": layers,
                     "elements": [4 * n, 4 * n], "grading": [4, 4]}},
            "parts": parts,
            "fixed": [{"set": "z_min"}]
        })
    };
    match name {
        "gel block" => block(json!([layer("gel", 0.048, 2 * n)]), json!([soft("gel", 1000.0, 3e4, 1.0)])),
        "layered plate" => {
            let layers = [
                layer("skin", 0.002, n.div_ceil(2)),
                layer("fat", 0.008, n),
                layer("muscle", 0.01, n),
                layer("rib", 0.008, n.div_ceil(2)),
                layer("lung", 0.02, n),
            ];
            let (young, nu) = (5e9, 0.3);
            let rib = json!({"part": "rib", "density_kg_per_m3": 1500, "material": {
                "law": "neo_hookean", "c10_pa": young / (4.0 * (1.0 + nu)), "bulk_modulus_pa": young / (3.0 * (1.0 - 2.0 * nu))
            }});
            let lung = json!({"part": "lung", "density_kg_per_m3": 300, "material": {
                "law": "neo_hookean", "c10_pa": 5e3, "bulk_modulus_pa": 1e5
            }});
            let soft = [
                soft("skin", 1100.0, 5e5, 5.0),
                soft("fat", 950.0, 2e4, 5.0),
                soft("muscle", 1060.0, 3e4, 4.0),
            ];
            let parts: Vec<Value> = soft.into_iter().chain([rib, lung]).collect();
            block(json!(layers), json!(parts))
        }
        _ => json!({
            "name": "tissue",
            "mesh": {"generator": {
                "kind": "limb_segment", "center_m": [0, 0, -0.07], "semi_axis_x_m": 0.075, "semi_axis_z_m": 0.07, "length_m": 0.2,
                "bone_semi_axis_x_m": 0.014, "bone_semi_axis_z_m": 0.014, "fat_thickness_m": 0.008, "skin_thickness_m": 0.002,
                "elements_around": 10 * n, "elements_along": 6 * n, "muscle_elements": 2 * n, "fat_elements": n,
                "skin_elements": n.div_ceil(2), "grading_around": 6, "grading_along": 6, "grading_muscle": 3
            }},
            "parts": [
                {"part": "muscle", "density_kg_per_m3": 1060, "shear_viscosity_pa_s": 4.0, "fibre_frame": {"kind": "mesh"}, "material": {
                    "law": "holzapfel_gasser_ogden", "c_pa": 6e4, "k1_pa": 4e4, "k2": 1, "fibres": {"angles_deg": [15, -15]},
                    "bulk_modulus_pa": BULK
                }},
                soft("fat", 950.0, 2e4, 5.0),
                soft("skin", 1100.0, 5e5, 5.0)
            ],
            "fixed": [{"set": "bone"}]
        }),
    }
}
