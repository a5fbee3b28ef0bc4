//! Numbers of elements from a mesh file and its table: fibres, stiffness factors.

use super::*;
use crate::mechanics::material::Material;
use crate::mechanics::tensor::Vec3;
use crate::mesh::generate::block::Block;
use crate::mesh::{CellKind, Mesh};
use std::fmt::Write as _;

const ELEMENTS: usize = 27;

/// Header of an array, what follows it, and each value as text.
type CellArray<'a> = (&'a str, &'a str, &'a dyn Fn(f64) -> String);

/// A mesh as a legacy file of VTK, with arrays of its cells by name.
fn vtk(mesh: &Mesh, arrays: &[CellArray]) -> String {
    let (nodes, cells) = (mesh.nodes.len(), mesh.cells.len());
    let mut text = format!(
        "# vtk DataFile Version 3.0\ncube\nASCII\nDATASET UNSTRUCTURED_GRID\nPOINTS {nodes} double\n"
    );
    mesh.nodes.iter().for_each(|x| writeln!(text, "{} {} {}", x.x, x.y, x.z).unwrap());
    writeln!(text, "CELLS {cells} {}", 9 * cells).unwrap();
    for cell in mesh.cells.iter() {
        let nodes: Vec<String> = cell.nodes.iter().map(u32::to_string).collect();
        writeln!(text, "8 {}", nodes.join(" ")).unwrap();
    }
    let number = CellKind::Hex8.table().vtk.number;
    writeln!(text, "CELL_TYPES {cells}\n{}CELL_DATA {cells}", format!("{number}\n").repeat(cells)).unwrap();
    for (header, after, value) in arrays {
        writeln!(text, "{header}{after}").unwrap();
        (0..cells).for_each(|e| writeln!(text, "{}", value(e as f64)).unwrap());
    }
    writeln!(text, "POINT_DATA {nodes}").unwrap();
    for (name, set) in &mesh.node_sets {
        writeln!(text, "SCALARS {name} int\nLOOKUP_TABLE default").unwrap();
        (0..nodes as u32).for_each(|node| writeln!(text, "{}", u8::from(set.contains(&node))).unwrap());
    }
    text
}

/// A cube of 3 × 3 × 3 elements with arrays: `fibre` turns in the plane of x and y, `grade` takes few values and `stiffness` many.
fn cube_with_arrays() -> Vec<u8> {
    const TABLE: &str = "\nLOOKUP_TABLE default";
    let mesh = Block::uniform(Vec3::zeros(), Vec3::repeat(0.03), [3; 3], "all").generate().unwrap();
    let turning = |e: f64| format!("{} {} 0", 5.0 * (0.1 * e).cos(), 5.0 * (0.1 * e).sin());
    vtk(
        &mesh,
        &[
            ("VECTORS fibre double", "", &turning),
            ("VECTORS second float", "", &|_| "0 0 1".into()),
            ("VECTORS zero int", "", &|e| format!("{} 0 0", u8::from((e - 4.0).abs() > 0.5))),
            ("VECTORS nan double", "", &|e| {
                if (e - 7.0).abs() < 0.5 { "0 nan 0".into() } else { "0 1 0".into() }
            }),
            ("SCALARS grade double", TABLE, &|e| if e < 9.0 { "1".into() } else { "2.5".into() }),
            ("SCALARS stiffness double", TABLE, &|e| (1.0 + 0.01 * e).to_string()),
            ("SCALARS negative int", TABLE, &|e| (1.0 - e).to_string()),
        ],
    )
    .into_bytes()
}

fn scene() -> Value {
    json!({
        "name": "arrays", "end_time_s": 1e-3,
        "bodies": [{
            "name": "cube", "role": "tissue", "fixed": [{"set": "z_min"}],
            "mesh": {"file": {"name": "cube.vtk"}},
            "parts": [{
                "part": "*", "density_kg_per_m3": 1000,
                "fibre_frame": {"kind": "arrays", "families": ["fibre"]},
                "stiffness_factor": {"array": "grade"},
                "material": {"law": "holzapfel_gasser_ogden", "c_pa": 1e4, "k1_pa": 1e4, "k2": 1.0,
                             "fibres": {"angles_deg": [0]}, "bulk_modulus_pa": 2e7}
            }]
        }]
    })
}

const PART: &str = "/bodies/0/parts/0";

fn load_arrays(document: &Value) -> Result<Loaded, Problems> {
    let mut table = "element,soft,along_x,along_y,along_z\n".to_owned();
    for e in 0..ELEMENTS {
        writeln!(table, "{e},{},0,0,{}", if e % 2 == 0 { 0.5 } else { 1.0 }, e + 1).unwrap();
    }
    let files = Files(vec![
        ("cube.vtk", cube_with_arrays()),
        ("cube.csv", table.into_bytes()),
        ("short.csv", b"element,soft\n0,1\n".to_vec()),
        ("bad.csv", b"element,soft\n99,1\n".to_vec()),
        ("twice.csv", b"part,grade\nunnamed,1\n".to_vec()),
    ]);
    load(document.to_string().as_bytes(), &files, &Budget::COMMAND_LINE)
}

fn with(changes: &[(&str, Value)]) -> Value {
    let mut document = scene();
    for (pointer, value) in changes {
        set(&mut document, pointer, value.clone());
    }
    document
}

#[test]
fn fibres_and_factors_come_from_arrays_and_turn_with_the_body() {
    let loaded = load_arrays(&scene()).unwrap();
    assert!(loaded.warnings.iter().all(|p| p.code != "unused_fibre_frame"), "{:?}", loaded.warnings);
    let body = &loaded.scene.bodies[0];
    for (e, axes) in body.axes.iter().enumerate() {
        let exact = Vec3::new((0.1 * e as f64).cos(), (0.1 * e as f64).sin(), 0.0);
        assert!((axes.column(0) - exact).norm() < 1e-14);
    }
    assert_eq!(body.materials.len(), 3);
    let shear = |e: usize| body.materials[body.law_of[e] as usize].moduli_at_rest().0;
    let own = body.materials[0].moduli_at_rest();
    assert_eq!((shear(0), shear(26)), (own.0, 2.5 * own.0));
    let keeps_bulk_modulus = |law: &Material| (law.moduli_at_rest().1 - own.1).abs() < 1e-9 * own.1;
    assert!(body.materials.iter().all(keeps_bulk_modulus), "the bulk modulus stays");
    assert!(body.mesh.fields.names().next().is_none(), "nothing is kept twice");

    // A mesh from a file knows nothing of the fibres of a law, unless it or the scene says it.
    let is_guessed =
        |p: &Problem| p.code == "default_fibre_frame" && p.pointer == format!("{PART}/fibre_frame");
    assert!(!loaded.warnings.iter().any(is_guessed));
    let mut without = scene();
    without["bodies"][0]["parts"][0].as_object_mut().unwrap().remove("fibre_frame");
    assert_eq!(load_arrays(&without).unwrap().warnings.iter().filter(|p| is_guessed(p)).count(), 1);

    let turn = json!({"rotation": {"axis": [0, 0, 1], "angle_deg": 90}});
    let turned = load_arrays(&with(&[("/bodies/0/placement", turn)])).unwrap();
    assert!((turned.scene.bodies[0].axes[0].column(0) - Vec3::y()).norm() < 1e-14);
}

#[test]
fn every_child_of_a_refined_element_has_its_numbers() {
    let whole = load_arrays(&with(&[("/bodies/0/mesh/file/refine", json!(1))])).unwrap();
    let place = json!([{"around": {"point_m": [0.03, 0.03, 0.03]}, "within_m": 0.005, "size_m": 0.005}]);
    let local = load_arrays(&with(&[("/bodies/0/refinement", place)])).unwrap();
    let body = |loaded: &Loaded| loaded.scene.bodies[0].clone();
    let [coarse, whole, local] = [&load_arrays(&scene()).unwrap(), &whole, &local].map(body);
    assert_eq!(whole.axes.len(), 8 * ELEMENTS);
    assert!(local.axes.len() > ELEMENTS && local.axes.len() < 8 * ELEMENTS);
    for e in 0..whole.axes.len() {
        assert_eq!((whole.axes[e], whole.law_of[e]), (coarse.axes[e / 8], coarse.law_of[e / 8]));
    }
    assert_eq!((local.axes.first(), local.axes.last()), (coarse.axes.first(), coarse.axes.last()));
    assert!(local.law_of.iter().filter(|law| **law == 2).count() > 18, "stiffer elements are split, too");
}

#[test]
fn a_table_adds_arrays_and_is_part_of_the_problem() {
    let document = with(&[
        ("/bodies/0/mesh/file/table", json!("cube.csv")),
        (&format!("{PART}/stiffness_factor/array"), json!("soft")),
        (&format!("{PART}/fibre_frame/families"), json!(["along"])),
    ]);
    let loaded = load_arrays(&document).unwrap();
    assert!(loaded.scene.bodies[0].axes.iter().all(|axes| (axes.column(0) - Vec3::z()).norm() < 1e-14));
    assert!(loaded.scene.mesh_files.contains_key("cube.csv"));
}

#[test]
fn many_factors_are_rounded_as_asked_by_at_most_half_a_step() {
    let array = format!("{PART}/stiffness_factor");
    let requested = |ratio: f64| with(&[(&array, json!({"array": "stiffness", "rounded_to_ratio": ratio}))]);
    let loaded = load_arrays(&requested(1.05)).unwrap();
    let body = &loaded.scene.bodies[0];
    assert!(body.materials.len() <= 1 + 7, "{}", body.materials.len());
    for e in 0..ELEMENTS {
        let factor =
            body.materials[body.law_of[e] as usize].moduli_at_rest().0 / body.materials[0].moduli_at_rest().0;
        assert!((factor / (1.0 + 0.01 * e as f64)).ln().abs() <= 0.5 * 1.05_f64.ln() + 1e-12);
    }
}

#[test]
fn what_is_wrong_with_arrays_is_listed_with_its_place_and_a_remedy() {
    let table = |name: &str| ("/bodies/0/mesh/file/table", json!(name));
    let families =
        |names: Value| ("/bodies/0/parts/0/fibre_frame", json!({"kind": "arrays", "families": names}));
    let factor = |name: &str| ("/bodies/0/parts/0/stiffness_factor", json!({"array": name}));
    let frame = |frame: Value| ("/bodies/0/parts/0/fibre_frame", frame);
    for (change, pointer, code, words) in [
        (table("none.csv"), "/bodies/0/mesh/file/table", "mesh_not_found", "none.csv"),
        (table("bad.csv"), "/bodies/0/mesh/file/table", "bad_table", "line 2"),
        (table("twice.csv"), "/bodies/0/mesh/file/table", "bad_table", "two arrays \"grade\""),
        (families(json!(["fibers"])), "/bodies/0/parts/0/fibre_frame/families/0", "no_array", "\"fibers\""),
        (
            families(json!(["grade"])),
            "/bodies/0/parts/0/fibre_frame/families/0",
            "no_array",
            "three components",
        ),
        (
            families(json!(["fibre", "second"])),
            "/bodies/0/parts/0/fibre_frame/families",
            "families_of_law",
            "it has 1",
        ),
        (families(json!([])), "/bodies/0/parts/0/fibre_frame/families", "families_of_law", "it has 1"),
        (families(json!(["zero"])), "/bodies/0/parts/0/fibre_frame/families/0", "no_direction", "element 4 "),
        (families(json!(["nan"])), "/bodies/0/parts/0/fibre_frame/families/0", "no_direction", "element 7 "),
        (factor("fibre"), "/bodies/0/parts/0/stiffness_factor/array", "no_array", "one component"),
        (
            factor("negative"),
            "/bodies/0/parts/0/stiffness_factor/array",
            "out_of_range",
            "26 elements (1, 2, ",
        ),
        (
            frame(json!({"kind": "centre_line", "points_m": [[0, 0, 0]]})),
            "/bodies/0/parts/0/fibre_frame/points_m",
            "out_of_range",
            "2 to",
        ),
        (
            frame(json!({"kind": "centre_line", "points_m": [[0, 0, 0], [0, 0, 0], [0, 0, 1]]})),
            "/bodies/0/parts/0/fibre_frame/points_m/0",
            "no_direction",
            "the next",
        ),
        (
            frame(json!({"kind": "centre_line", "points_m": [[0, 0, 0], [0, 0, 1], [0, 0, 0.5]]})),
            "/bodies/0/parts/0/fibre_frame/points_m/1",
            "no_direction",
            "turns back",
        ),
        (
            frame(json!({"kind": "laplace", "from": {"set": "low"}, "to": {"set": "z_max"}})),
            "/bodies/0/parts/0/fibre_frame/from",
            "no_surface",
            "z_min",
        ),
        (
            frame(json!({"kind": "laplace", "from": {"set": "z_min"}, "to": {"set": "x_max"}})),
            "/bodies/0/parts/0/fibre_frame/to",
            "no_surface",
            "meet at 4 nodes",
        ),
        (
            frame(
                json!({"kind": "laplace", "from": {"set": "z_min"}, "to": {"set": "z_max"}, "plane": [0, 0, 1]}),
            ),
            "/bodies/0/parts/0/fibre_frame/plane",
            "parallel_directions",
            "27 elements",
        ),
        (
            ("/bodies/0/parts/0/stiffness_factor/rounded_to_ratio", json!(1.0)),
            "/bodies/0/parts/0/stiffness_factor/rounded_to_ratio",
            "out_of_range",
            "2.5 %",
        ),
    ] {
        let problems = load_arrays(&with(&[change])).unwrap_err();
        let found = problems.0.iter().find(|p| p.pointer == pointer && p.code == code);
        let found = found.unwrap_or_else(|| panic!("{pointer} {code}: {problems}")).to_string();
        assert!(found.contains(words), "{words:?}: {found}");
    }
    // A table that does not cover the part.
    let short = with(&[table("short.csv"), factor("soft")]);
    assert!(load_arrays(&short).unwrap_err().to_string().contains("26 elements"));
}
