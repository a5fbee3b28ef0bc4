//! Bodies made of the labels of a scan.

use super::*;

/// A scan of 24 × 20 × 16 voxels of 2.5 mm in NIfTI: fat (1) on muscle (2) with a bone (3) through it, and air (0) above.
fn scan() -> Vec<u8> {
    let mut file = vec![0_u8; 352];
    let mut put = |at: usize, bytes: &[u8]| file[at..at + bytes.len()].copy_from_slice(bytes);
    put(0, &348_i32.to_le_bytes());
    for (i, n) in [3_i16, 24, 20, 16, 1, 1, 1, 1].into_iter().enumerate() {
        put(40 + 2 * i, &n.to_le_bytes());
    }
    put(70, &2_i16.to_le_bytes());
    put(108, &352_f32.to_le_bytes());
    put(123, &[2]);
    put(254, &1_i16.to_le_bytes());
    for (row, at) in [280, 300, 320].into_iter().enumerate() {
        put(at, &2.5_f32.to_le_bytes());
        put(292 + 16 * row, &1.25_f32.to_le_bytes());
    }
    put(344, b"n+1\0");
    for k in 0..16 {
        for _ in 0..20 {
            for i in 0..24_i32 {
                let is_bone = (i - 12).pow(2) + (k - 5_i32).pow(2) < 9;
                file.push(match k {
                    12.. => 0,
                    8.. => 1,
                    _ if is_bone => 3,
                    _ => 2,
                });
            }
        }
    }
    file
}

fn scene() -> Value {
    json!({
        "name": "scan",
        "end_time_s": 1e-3,
        "bodies": [
            {"name": "ball", "role": "projectile", "velocity_m_per_s": [0, 0, -3],
             "rigid": {"shape": {"kind": "ball", "radius_m": 0.01}, "center_m": [0.03, 0.025, 0.0402], "density_kg_per_m3": 7850}},
            {"name": "limb", "role": "tissue", "fixed": [{"set": "bone"}, {"set": "z_min"}],
             "mesh": {"segmentation": {
                "name": "limb.nii",
                "labels": [{"label": 1, "part": "fat"}, {"label": 2, "part": "muscle"}, {"label": 3, "hole": "bone"}],
                "size_m": 0.005,
                "near": [{"point_m": [0.03, 0.025, 0.03], "size_m": 0.0025, "within_m": 0.005}],
                "thin_size_m": 0.005
             }},
             "parts": [{"part": "*", "density_kg_per_m3": 1000,
                        "material": {"law": "neo_hookean", "c10_pa": 5e3, "bulk_modulus_pa": 2e7}}]}
        ]
    })
}

fn load_scan(document: &Value) -> Result<Loaded, Problems> {
    let files =
        Files(vec![("limb.nii", scan()), ("cube.msh", cube(false)), ("short.nii", scan()[..5000].to_vec())]);
    load(document.to_string().as_bytes(), &files, &Budget::COMMAND_LINE)
}

/// Pointer and code of every error.
fn errors(document: &Value) -> Vec<(String, String)> {
    let problems = load_scan(document).map_or_else(|problems| problems.0, |loaded| loaded.warnings);
    problems.iter().filter(|p| p.is_error()).map(|p| (p.pointer.clone(), p.code.to_string())).collect()
}

#[test]
fn the_labels_of_a_scan_become_parts_and_holes() {
    let loaded = load_scan(&scene()).unwrap();
    let mesh = &loaded.scene.bodies[1].mesh;
    assert_eq!(mesh.parts, ["fat", "muscle"]);
    let sets: Vec<&str> = mesh.node_sets.keys().map(String::as_str).collect();
    assert_eq!(sets, ["bone", "outer", "x_max", "x_min", "y_max", "y_min", "z_min"]);
    assert!(!mesh.hanging.is_empty());
    // Flat layers of voxels: 4 of fat on 8 of muscle with a hole of 25 voxels across.
    let exact = [24.0 * 20.0 * 4.0, (24.0 * 8.0 - 25.0) * 20.0].map(|voxels| voxels * 2.5e-3_f64.powi(3));
    for (part, exact) in mesh.parts.iter().zip(exact) {
        let found = mesh.part_volume_m3(part);
        assert!((found / exact - 1.0).abs() < 0.01, "{part}: {found} of {exact}");
    }
    assert!(loaded.scene.mesh_files.contains_key("limb.nii"));
}

#[test]
fn a_skin_of_given_thickness_is_a_part() {
    let mut document = scene();
    document["bodies"][1]["mesh"]["segmentation"]["skin_thickness_m"] = json!(0.002);
    let loaded = load_scan(&document).unwrap();
    let mesh = &loaded.scene.bodies[1].mesh;
    assert_eq!(mesh.parts, ["fat", "muscle", "skin"]);
    let skin = mesh.part_volume_m3("skin");
    assert!((skin / (0.06 * 0.05 * 0.002) - 1.0).abs() < 0.03, "{skin}");
    let both = skin + mesh.part_volume_m3("fat");
    assert!((both / (0.06 * 0.05 * 0.01) - 1.0).abs() < 0.01, "{both}");
}

#[test]
fn what_a_scan_does_not_have_and_what_a_mesh_loses_of_it_is_warned_of() {
    assert_eq!(load_scan(&scene()).unwrap().warnings, []);
    let mut document = scene();
    let segmentation = &mut document["bodies"][1]["mesh"]["segmentation"];
    segmentation["labels"].as_array_mut().unwrap().push(json!({"label": 17, "part": "vessel"}));
    segmentation["near"][0]["point_m"] = json!([30, 25, 30]);
    let warnings = load_scan(&document).unwrap().warnings;
    let found: Vec<(&str, &str)> = warnings.iter().map(|p| (&*p.pointer, &*p.code)).collect();
    let at = "/bodies/1/mesh/segmentation";
    let expected = [
        (format!("{at}/labels/3/label"), "absent_label"),
        (format!("{at}/near/0/point_m"), "outside_of_scan"),
    ];
    assert_eq!(found, expected.each_ref().map(|(pointer, code)| (pointer.as_str(), *code)));

    // Elements almost as large as the bone.
    let mut document = scene();
    let segmentation = &mut document["bodies"][1]["mesh"]["segmentation"];
    segmentation.as_object_mut().unwrap().retain(|key, _| !["near", "thin_size_m"].contains(&key.as_str()));
    segmentation["size_m"] = json!(0.012);
    let warnings = load_scan(&document).unwrap().warnings;
    assert!(
        warnings.iter().any(|p| p.code == "label_volume" && p.to_string().contains("bone")),
        "{warnings:?}"
    );
}

#[test]
fn points_and_a_skin_without_effect_have_a_warning() {
    let found = |change: &dyn Fn(&mut Value)| {
        let mut document = scene();
        change(&mut document);
        let warnings = load_scan(&document).unwrap().warnings;
        let idle = warnings.into_iter().filter(|p| p.code == "without_effect");
        idle.map(|p| p.pointer).collect::<Vec<_>>()
    };
    let at = "/bodies/1/mesh/segmentation";
    // Sizes as elsewhere, beside a point that has an effect; and a point in the air, from which sizes grow to those of the tissue.
    let more = |near: Value| {
        found(&|document| {
            let all = &mut document["bodies"][1]["mesh"]["segmentation"]["near"];
            all.as_array_mut().unwrap().push(near.clone());
        })
    };
    assert_eq!(more(json!({"point_m": [0.01, 0.01, 0.01], "size_m": 0.0025})), [""; 0]);
    assert_eq!(more(json!({"point_m": [0.01, 0.01, 0.01], "size_m": 0.005})), [format!("{at}/near/1")]);
    assert_eq!(more(json!({"point_m": [0.03, 0.025, 0.0395], "size_m": 0.0025})), [format!("{at}/near/1")]);
    // A piece from within the muscle has no skin.
    let within = |skin: bool| {
        found(&|document| {
            document["bodies"][1]["fixed"] = json!([{"set": "z_min"}]);
            let scan = &mut document["bodies"][1]["mesh"]["segmentation"];
            scan["crop"] = json!({"center_m": [0.01, 0.025, 0.01], "size_m": [0.01, 0.02, 0.01]});
            scan["near"] = json!([]);
            if skin {
                scan["skin_thickness_m"] = json!(0.002);
            }
        })
    };
    assert_eq!(within(true), [format!("{at}/skin_thickness_m")]);
    assert_eq!(within(false), [""; 0]);
}

#[test]
fn a_scan_of_impossible_size_is_refused() {
    let at_z = |value: f32| {
        let mut file = scan();
        file[320..324].copy_from_slice(&value.to_le_bytes());
        file
    };
    for (value, words) in [(1e30, "check the unit"), (1e-20, "check the unit")] {
        let files = Files(vec![("limb.nii", at_z(value)), ("cube.msh", cube(false))]);
        let refused = load(scene().to_string().as_bytes(), &files, &Budget::COMMAND_LINE).unwrap_err();
        assert!(refused.to_string().contains(words), "{refused}");
    }
}

#[test]
fn what_is_wrong_with_a_scan_is_listed_with_its_place() {
    let at = "/bodies/1/mesh/segmentation";
    let place = |rest: &str| format!("{at}{rest}");
    for (rest, value, code) in [
        ("/size_m", json!(0), "not_positive"),
        ("/near/0/size_m", json!(0.1), "out_of_range"),
        ("/near/0/within_m", json!(-1), "negative"),
        ("/thin_size_m", json!(-1e-3), "not_positive"),
        ("/skin_thickness_m", json!(0), "not_positive"),
        ("/crop", json!({"center_m": [0, 0, 0], "size_m": [0.1, 0.1, 0]}), "not_positive"),
        ("/labels/0/hole", json!("x"), "several_variants"),
        ("/labels/1/label", json!(1), "repeated_item"),
        ("/labels/1/label", json!(0), "out_of_range"),
        ("/labels/1/label", json!(9), "bad_scan"),
        ("/max_elements", json!(100), "bad_scan"),
        ("/name", json!("short.nii"), "bad_scan"),
        ("/name", json!("cube.msh"), "unknown_mesh_format"),
        ("/name", json!("other.nii"), "mesh_not_found"),
    ] {
        let mut document = scene();
        set(&mut document, &place(rest), value);
        let found = errors(&document);
        assert!(found.iter().any(|(p, c)| p.starts_with(at) && c == code), "{rest} {code}: {found:?}");
    }
    let mut document = scene();
    document["bodies"][1]["refinement"] = json!([{"around": "impact", "within_m": 0.01, "size_m": 0.001}]);
    assert!(errors(&document).iter().any(|(_, code)| code == "refinement_of_scan"));
    document = scene();
    document["bodies"][1]["mesh"] = json!({"file": {"name": "limb.nii"}});
    let message = load_scan(&document).unwrap_err().to_string();
    assert!(message.contains("segmentation"), "{message}");
}
