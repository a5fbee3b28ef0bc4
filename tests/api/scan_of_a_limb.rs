//! A limb as a scan, uploaded, and the same limb from the generator: one impact, the same numbers.

use crate::support::client::Client;
use crate::support::*;
use contuse::mechanics::tensor::Vec3;
use contuse::mesh::generate::limb_segment::LimbSegment;
use contuse::mesh::locate::Locator;
use nalgebra::{Rotation3, Unit};
use serde_json::{Value, json};

/// Radius of the ball [m].
const BALL: f64 = 0.02;
/// The axes of the scan are turned from those of the limb by this about [`AXIS`] [°].
const TURN: f64 = 25.0;
const AXIS: [f64; 3] = [1.0, 2.0, 3.0];
const LABELS: [&str; 3] = ["muscle", "fat", "bone"];

fn limb() -> LimbSegment {
    LimbSegment {
        semi_axis_x_m: 0.032,
        semi_axis_z_m: 0.03,
        length_m: 0.06,
        bone_semi_axis_x_m: 0.009,
        bone_semi_axis_z_m: 0.009,
        fat_thickness_m: 0.005,
        skin_thickness_m: 0.002,
        ..LimbSegment::default()
    }
}

fn turn() -> Rotation3<f64> {
    Rotation3::from_axis_angle(&Unit::new_normalize(Vec3::from(AXIS)), TURN.to_radians())
}

/// The limb as NIfTI: voxels of 1 × 2 × 1 mm at an angle to x, y, z, one of a hundred with a random label. The labels are those of
/// [`LABELS`] from 1 on; skin is not resolved, and counts as fat.
fn scan(limb: &LimbSegment) -> Vec<u8> {
    let (dims, spacing) = ([72_u16, 30, 68], [1.0, 2.0, 1.0]);
    let middle = Vec3::from_fn(|k, _| 0.5 * spacing[k] * (f64::from(dims[k]) - 1.0));
    let fine = LimbSegment { elements_around: 180, elements_along: 1, grading_around: 1.0, ..limb.clone() };
    let fine = fine.generate().unwrap();
    let locator = Locator::of((0..fine.cells.len() as u32).collect(), &fine.cells, &fine.nodes);
    let label = |x: f64, z: f64| match locator.element_at(&Vec3::new(x, 0.0, z), |_| true) {
        Some(element) => 1 + fine.part_of[element].min(1) as u8,
        None => {
            if x.hypot(z) < limb.semi_axis_z_m / 2.0 {
                3
            } else {
                0
            }
        }
    };

    let mut file = vec![0; 352];
    let mut put = |at: usize, bytes: &[u8]| file[at..at + bytes.len()].copy_from_slice(bytes);
    put(0, &348_i32.to_le_bytes());
    put(40, &3_i16.to_le_bytes());
    put(70, &2_i16.to_le_bytes()); // numbers of 8 bits
    put(72, &8_i16.to_le_bytes());
    put(108, &352_f32.to_le_bytes());
    put(123, &[2]); // millimetres
    put(254, &1_i16.to_le_bytes());
    let corner = -(turn() * middle);
    for k in 0..3 {
        put(42 + 2 * k, &dims[k].to_le_bytes());
        put(80 + 4 * k, &(spacing[k] as f32).to_le_bytes());
        for (i, space) in spacing.into_iter().enumerate() {
            put(280 + 16 * k + 4 * i, &((turn()[(k, i)] * space) as f32).to_le_bytes());
        }
        put(280 + 16 * k + 12, &(corner[k] as f32).to_le_bytes());
    }
    put(344, b"n+1\0");
    let mut random = 1_u64;
    let dims = dims.map(usize::from);
    for n in 0..dims.iter().product::<usize>() {
        let (i, k) = (n % dims[0], n / (dims[0] * dims[1]));
        random = random.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        let is_noise = random >> 32 & 0xff_ffff < 0xff_ffff / 100;
        let place = |n: usize, axis: usize| (n as f64 * spacing[axis] - middle[axis]) / 1000.0;
        file.push(if is_noise { (random >> 60 & 3) as u8 } else { label(place(i, 0), place(k, 2)) });
    }
    file
}

/// A foam ball hits a body in the place of the limb.
fn scene(limb: &LimbSegment, mut tissue: Value, fibres: &Value, skin: &str) -> Value {
    let neo_hookean = |c10: f64| json!({"law": "neo_hookean", "c10_pa": c10, "bulk_modulus_pa": 1e7, "volumetric": "quadratic_ln"});
    let muscle = json!({"law": "holzapfel_gasser_ogden", "c_pa": 6e4, "k1_pa": 4e4, "k2": 1, "fibres": {"angles_deg": [15, -15]},
                        "bulk_modulus_pa": 1e7, "volumetric": "quadratic_ln"});
    tissue["name"] = json!("limb");
    tissue["role"] = json!("tissue");
    tissue["fixed"] = json!([{"set": "bone"}]);
    tissue["parts"] = json!([
        {"part": "muscle", "density_kg_per_m3": 1060, "shear_viscosity_pa_s": 4, "fibre_frame": fibres, "material": muscle},
        {"part": "fat", "density_kg_per_m3": 950, "shear_viscosity_pa_s": 5, "material": neo_hookean(2e4)},
        {"part": "skin", "density_kg_per_m3": 1100, "shear_viscosity_pa_s": 5, "material": neo_hookean(2e5)}
    ]);
    json!({
        "name": "limb", "end_time_s": 3.5e-3,
        "bodies": [
            {"name": "ball", "role": "projectile", "velocity_m_per_s": [0, 0, -6],
             "rigid": {"shape": {"kind": "ball", "radius_m": BALL}, "density_kg_per_m3": 120,
                       "center_m": [0, 0, limb.semi_axis_z_m + BALL + 6e-4]}},
            tissue
        ],
        "contact": {"friction": 0.3},
        "record": {"field_interval_s": 1.75e-4, "fields": ["von_mises"]},
        "measures": {"force_window_s": 4e-4, "skin_set": skin, "stress_thresholds_pa": [3e4]}
    })
}

fn from_generator(limb: &LimbSegment) -> Value {
    let generator = json!({
        "kind": "limb_segment", "semi_axis_x_m": limb.semi_axis_x_m, "semi_axis_z_m": limb.semi_axis_z_m,
        "length_m": limb.length_m, "bone_semi_axis_x_m": limb.bone_semi_axis_x_m, "bone_semi_axis_z_m": limb.bone_semi_axis_z_m,
        "fat_thickness_m": limb.fat_thickness_m, "skin_thickness_m": limb.skin_thickness_m,
        "elements_around": 24, "elements_along": 14, "muscle_elements": 4, "fat_elements": 2, "skin_elements": 1,
        "grading_around": 6, "grading_along": 6, "grading_muscle": 3, "uniform_within_m": 0.01
    });
    scene(limb, json!({"mesh": {"generator": generator}}), &json!({"kind": "mesh"}), "skin_outer")
}

/// Elements of a size, and of a quarter of it where the ball hits [m].
fn from_scan(limb: &LimbSegment, id: &Value, size: f64) -> Value {
    let impact = turn() * Vec3::new(0.0, 0.0, limb.semi_axis_z_m);
    let mesh = json!({"segmentation": {
        "name": id, "size_m": size, "near": [{"point_m": impact.as_slice(), "size_m": 0.25 * size, "within_m": 0.01}],
        "labels": [{"label": 1, "part": LABELS[0]}, {"label": 2, "part": LABELS[1]}, {"label": 3, "hole": LABELS[2]}],
        "skin_thickness_m": limb.skin_thickness_m
    }});
    let placement = json!({"rotation": {"axis": AXIS, "angle_deg": -TURN}});
    let half = limb.length_m / 2.0;
    let fibres = json!({"kind": "centre_line", "points_m": [[0, -half, 0], [0, half, 0]]});
    scene(limb, json!({"mesh": mesh, "placement": placement}), &fibres, "outer")
}

/// Uploads a scan, and gives its id.
fn uploaded(client: &Client, scan: &[u8]) -> Value {
    let answer = client.send("POST", "/v1/meshes", &[("Content-Type", "application/octet-stream")], scan);
    assert_eq!(answer.status, 201, "{answer:?}");
    answer.json()["id"].clone()
}

#[test]
fn elements_of_every_size_have_the_volumes_of_the_limb() {
    let server = Server::simulating();
    let client = server.client();
    let limb = limb();
    let id = uploaded(&client, &scan(&limb));
    for size in [0.012, 0.009, 0.006] {
        let scene = from_scan(&limb, &id, size);
        let valid = client.post_json("/v1/jobs/validate", &scene).json();
        let body = valid["bodies"].as_array().unwrap().iter().find(|body| body["name"] == "limb").unwrap();
        let least = body["quality"]["min_scaled_jacobian"].as_f64().unwrap();
        println!(
            "{size} m: {} elements, scaled Jacobian from {least:.3}, {}",
            body["elements"], body["notes"]
        );
        assert!(least >= 0.2, "{body}");
        for (name, exact) in ["muscle", "fat", "skin"].into_iter().zip(limb.exact_volumes_m3()) {
            let part = |list: &Value, key: &str| {
                list.as_array().unwrap().iter().find(|part| part[key] == name).unwrap().clone()
            };
            let asked = part(&scene["bodies"][1]["parts"], "part");
            let mass = part(&body["parts"], "name")["mass_kg"].as_f64().unwrap();
            let deviation = mass / asked["density_kg_per_m3"].as_f64().unwrap() / exact - 1.0;
            println!("  {name}: {:+.2} % of {:.4} cm³", 100.0 * deviation, 1e6 * exact);
            assert!(deviation.abs() < 0.01, "{name}: {deviation}");
        }
    }
}

/// Peak force, contact patch at that time, depth of significant stress, absorbed energy at its peak: each with its error bar, below it.
fn four_numbers(client: &Client, scene: &Value) -> [[f64; 2]; 4] {
    let (job, _) = finished(client, scene);
    let summary = client.get(&format!("{job}/summary")).json();
    let results = &summary["results"];
    let [impact, tissue] = [&results["impacts"][0], &results["tissue"]];
    let depth = &tissue["significant_stress"][0]["depth_mm"];
    // Four nodes lie across the patch: it has an error bar, and is not resolved.
    let is_coarse = impact["nodes_across_patch"][0].as_u64().unwrap() < 5;
    [
        (&impact["peak_force_n"], true),
        (&impact["patch_area_mm2"], !is_coarse),
        (depth, true),
        (&tissue["peak_absorbed_energy_j"], true),
    ]
    .map(|(number, is_resolved)| {
        assert_eq!(number["error"]["resolved"], is_resolved, "{summary}");
        [&number["value"], &number["error"]["total"]].map(|x| x.as_f64().unwrap())
    })
}

#[test]
fn a_scan_and_the_generator_give_the_same_four_numbers() {
    let server = Server::simulating();
    let client = server.client();
    let limb = limb();
    let id = uploaded(&client, &scan(&limb));
    let scenes = [from_scan(&limb, &id, 0.009), from_generator(&limb)];
    let [scan, generator] = scenes.map(|scene| four_numbers(&client, &scene));
    for (i, ([a, a_bar], [b, b_bar])) in scan.into_iter().zip(generator).enumerate() {
        println!("{i}: {a} ± {a_bar} of the scan, {b} ± {b_bar} of the generator");
        assert!(
            (a - b).abs() <= a_bar + b_bar,
            "{i}: {a} ± {a_bar} of the scan, {b} ± {b_bar} of the generator"
        );
    }
}
