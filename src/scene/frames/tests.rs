//! Frames against closed forms.

use super::*;
use crate::mesh::generate::block::Block;
use crate::scene::document::MaterialDocument;
use serde_json::{Value, json};
use std::f64::consts::FRAC_PI_2;

/// A law with fibre families.
fn law(fibres: &Value) -> Material {
    let document: MaterialDocument = serde_json::from_value(json!({
        "law": "holzapfel_gasser_ogden", "c_pa": 1e4, "k1_pa": 1e4, "k2": 1.0, "bulk_modulus_pa": 1e6, "fibres": fibres
    }))
    .unwrap();
    document.to_material().unwrap()
}

fn along() -> Material {
    law(&json!({"angles_deg": [0]}))
}

/// A block of n elements along each side, 0 to 1, mapped.
fn mapped(n: u32, map: impl Fn(&Vec3) -> Vec3) -> (Mesh, Vec<usize>) {
    let mut mesh = Block::uniform(Vec3::zeros(), Vec3::repeat(1.0), [n; 3], "all").generate().unwrap();
    mesh.nodes.iter_mut().for_each(|x| *x = map(x));
    let elements = (0..mesh.cells.len()).collect();
    (mesh, elements)
}

/// A quarter of a ring about y, of radii 1 to 2.
fn bent_tube(x: &Vec3) -> Vec3 {
    let (radius, angle) = (1.0 + x.x, FRAC_PI_2 * x.z);
    Vec3::new(radius * angle.cos(), x.y, radius * angle.sin())
}

fn frame(document: Value) -> FibreFrameDocument {
    serde_json::from_value(document).unwrap()
}

fn is_orthonormal(axes: &Mat3) -> bool {
    (axes.transpose() * axes - Mat3::identity()).norm() < 1e-12 && axes.determinant() > 0.0
}

#[test]
fn frames_are_right_handed_and_orthonormal() {
    let frame = constant_frame([0.0, 3.0, 0.0], [5.0, 1.0, 0.0]).unwrap();
    assert!(is_orthonormal(&frame));
    assert_eq!((frame.column(0).into(), frame.column(1).into()), (Vec3::y(), Vec3::x()));
    assert!(constant_frame([1.0, 0.0, 0.0], [-2.0, 0.0, 0.0]).is_none());
    assert!(constant_frame([0.0; 3], [1.0, 0.0, 0.0]).is_none());
}

#[test]
fn a_cylindrical_frame_turns_about_its_axis() {
    let (mesh, elements) = mapped(1, |x| Vec3::new(2.0 * x.x + 1.0, 2.0 * x.y - 1.0, 2.0 * x.z - 1.0));
    let around = frame(json!({"kind": "cylindrical", "origin_m": [0, 0, 0], "axis": [0, 2, 0]}));
    let found = axes_of(Some(&around), &along(), &mesh, &elements).unwrap();
    assert_eq!(found, [Mat3::from_columns(&[Vec3::y(), Vec3::z(), Vec3::x()])]);
    let through = frame(json!({"kind": "cylindrical", "origin_m": [2, 0, 0], "axis": [0, 2, 0]}));
    assert_eq!(axes_of(Some(&through), &along(), &mesh, &elements), Err(NoAxes::OnAxis(vec![0])));
    assert_eq!(
        axes_of(Some(&frame(json!({"kind": "mesh"}))), &along(), &mesh, &elements),
        Err(NoAxes::MeshHasNone)
    );
}

#[test]
fn a_centre_line_of_many_points_leads_around_a_bend() {
    let (mesh, elements) = mapped(6, bent_tube);
    let point = |i: i32| {
        [1.5 * (f64::from(i) * FRAC_PI_2 / 30.0).cos(), 0.4, 1.5 * (f64::from(i) * FRAC_PI_2 / 30.0).sin()]
    };
    let line = frame(json!({"kind": "centre_line", "points_m": (0..=30).map(point).collect::<Vec<_>>()}));
    let found = axes_of(Some(&line), &along(), &mesh, &elements).unwrap();
    for (element, axes) in found.iter().enumerate() {
        let x = centre(&mesh, element);
        let exact = Vec3::new(-x.z, 0.0, x.x).normalize();
        assert!(is_orthonormal(axes));
        assert!(axes.column(0).angle(&exact) < 0.03, "element {element}: {}", axes.column(0).angle(&exact));
    }
    // A straight line is exact; an element on it has any frame, if all fibres run along the line.
    let (bar, elements) = mapped(3, |x| *x);
    let axis =
        frame(json!({"kind": "centre_line", "points_m": [[0.5, 0.5, -1], [0.5, 0.5, 0.3], [0.5, 0.5, 2]]}));
    let found = axes_of(Some(&axis), &along(), &bar, &elements).unwrap();
    assert!(found.iter().all(|axes| is_orthonormal(axes) && axes.column(0) == Vec3::z()));
    let oblique = law(&json!({"angles_deg": [30, -30]}));
    assert_eq!(axes_of(Some(&axis), &oblique, &bar, &elements), Err(NoAxes::OnAxis(vec![4, 13, 22])));
}

#[test]
fn laplace_frames_follow_the_bend_and_lie_in_the_plane() {
    let (mesh, elements) = mapped(8, bent_tube);
    let bend = |plane: Value| {
        frame(json!({"kind": "laplace", "from": {"set": "z_min"}, "to": {"set": "z_max"}, "plane": plane}))
    };
    let oblique = law(&json!({"angles_deg": [30, -30]}));
    let found = axes_of(Some(&bend(json!([0, 1, 0]))), &oblique, &mesh, &elements).unwrap();
    for (element, axes) in found.iter().enumerate() {
        let x = centre(&mesh, element);
        assert!(is_orthonormal(axes) && axes.column(1).dot(&Vec3::y()) > 0.999);
        assert!(axes.column(0).angle(&Vec3::new(-x.z, 0.0, x.x)) < 0.01);
    }
    assert!(axes_of(Some(&bend(Value::Null)), &along(), &mesh, &elements).is_ok());
    assert_eq!(axes_of(Some(&bend(Value::Null)), &oblique, &mesh, &elements), Err(NoAxes::NoPlane(None)));
}

#[test]
fn elements_without_a_gradient_are_named() {
    // Two bars beside each other; only the first lies between the surfaces.
    let (mut mesh, _) = mapped(2, |x| *x);
    let first = mesh.nodes.len() as u32;
    let (second, nodes) = (mesh.cells.map(|node| node + first), mesh.nodes.clone());
    mesh.nodes.extend(nodes.iter().map(|x| x + Vec3::x() * 3.0));
    mesh.cells.extend(second.iter());
    mesh.part_of = vec![0; 16];
    let elements: Vec<usize> = (0..16).collect();
    let along_z = frame(json!({"kind": "laplace", "from": {"set": "z_min"}, "to": {"set": "z_max"}}));
    let reason = axes_of(Some(&along_z), &along(), &mesh, &elements).unwrap_err();
    assert_eq!(reason, NoAxes::Flat((8..16).collect()));
    let no_set = frame(json!({"kind": "laplace", "from": {"set": "z_min"}, "to": {"part": "bone"}}));
    let reason = axes_of(Some(&no_set), &along(), &mesh, &elements).unwrap_err();
    assert!(matches!(reason, NoAxes::Surface { at_end: true, .. }), "{reason:?}");
}

#[test]
fn arrays_replace_the_families_of_the_law() {
    let (mut mesh, elements) = mapped(1, |x| *x);
    let [a, b] = [Vec3::new(1.0, 2.0, 2.0), Vec3::new(0.0, -3.0, 0.0)];
    for (name, vector) in [("a", a), ("b", b), ("none", Vec3::zeros()), ("nan", Vec3::repeat(f64::NAN))] {
        mesh.fields.add(name.into(), ElementField::Vectors(vec![vector])).unwrap();
    }
    mesh.fields.add("s".into(), ElementField::Scalars(vec![1.0])).unwrap();
    let found = |names: &[&str], law: &Material| {
        let arrays = frame(json!({"kind": "arrays", "families": names}));
        axes_of(Some(&arrays), law, &mesh, &elements)
    };
    let two = law(&json!({"angles_deg": [40, -40]}));
    let axes = found(&["a", "b"], &two).unwrap()[0];
    for (direction, exact) in two.fibre_directions().iter().zip([a, b]) {
        assert!((axes * Vec3::from(*direction) - exact.normalize()).norm() < 1e-14);
    }
    let oblique = law(&json!({"angles_deg": [25]}));
    let axes = found(&["a"], &oblique).unwrap()[0];
    assert!(is_orthonormal(&axes));
    assert!((axes * Vec3::from(oblique.fibre_directions()[0]) - a.normalize()).norm() < 1e-14);
    for name in ["none", "nan"] {
        assert_eq!(found(&["a", name], &two), Err(NoAxes::NoDirection { family: 1, elements: vec![0] }));
    }
    assert_eq!(found(&["s"], &along()), Err(NoAxes::NoArray { family: 0, scalars: true }));
    assert_eq!(found(&["c"], &along()), Err(NoAxes::NoArray { family: 0, scalars: false }));
    assert_eq!(found(&["a"], &two), Err(NoAxes::Families { of_law: 2 }));
    let same = law(&json!({"angles_deg": [40, 40]}));
    assert_eq!(found(&["a", "a"], &same), Err(NoAxes::Families { of_law: 2 }));
}
