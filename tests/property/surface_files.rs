//! Whatever is in an STL file, reading it, and finding the hull of its surface, ends with a sound one or with an error.

use crate::file_changes::{apply, change};
use contuse::mechanics::rigid::{NoHull, Solid};
use contuse::mechanics::tensor::Vec3;
use contuse::mesh::MeshError;
use contuse::mesh::read::stl::{ClosedSurface, read_stl};
use proptest::prelude::*;
use std::sync::LazyLock;

/// A wedge with a notch, as triangles that are turned outwards.
const POINTS: [[f32; 3]; 7] = [
    [0.0, 0.0, 0.0],
    [2.0, 0.0, 0.0],
    [2.0, 1.5, 0.0],
    [0.0, 1.5, 0.0],
    [0.0, 0.0, 1.0],
    [0.0, 1.5, 1.0],
    [0.5, 0.75, 0.25],
];
const TRIANGLES: [[usize; 3]; 10] = [
    [0, 2, 1],
    [0, 3, 2],
    [0, 4, 5],
    [0, 5, 3],
    [0, 1, 4],
    [3, 5, 2],
    [1, 2, 6],
    [2, 5, 6],
    [5, 4, 6],
    [4, 1, 6],
];

/// As text, and as a binary file.
static FILES: LazyLock<[Vec<u8>; 2]> = LazyLock::new(|| {
    let triangles = TRIANGLES.map(|t| t.map(|i| POINTS[i]));
    let vertex = |[x, y, z]: &[f32; 3]| format!("  vertex {x} {y} {z:e}\n");
    let facet = |t: &[[f32; 3]; 3]| {
        let vertices: String = t.iter().map(vertex).collect();
        format!("facet normal 0 0 0\n outer loop\n{vertices} endloop\nendfacet\n")
    };
    let text = format!("solid wedge\n{}endsolid wedge\n", triangles.iter().map(facet).collect::<String>());
    [text.into_bytes(), binary(&triangles)]
});

fn binary(triangles: &[[[f32; 3]; 3]]) -> Vec<u8> {
    let mut bytes = vec![0; 80];
    bytes.extend((triangles.len() as u32).to_le_bytes());
    for triangle in triangles {
        bytes.extend([0; 12]);
        bytes.extend(triangle.iter().flatten().flat_map(|x| x.to_le_bytes()));
        bytes.extend([0; 2]);
    }
    bytes
}

/// Finds the hull; what every hull keeps to.
fn check_hull(surface: &ClosedSurface) -> Result<(), TestCaseError> {
    match Solid::new(&surface.points, &surface.triangles) {
        Ok(solid) => {
            prop_assert!(solid.hull.volume() > 0.0 && solid.hull.thickness() > 0.0);
            let size = solid.hull.outer_radius();
            for corner in solid.hull.corners() {
                prop_assert!(solid.hull.eval_distance(corner).0.abs() < 1e-5 * size);
            }
            for axis in [Vec3::x(), Vec3::y(), Vec3::z()] {
                let (distance, normal) = solid.hull.eval_distance(&(axis * 3.0 * size));
                prop_assert!(
                    (1.9 * size..=4.1 * size).contains(&distance) && normal.dot(&axis) > 0.5,
                    "{distance}"
                );
            }
        }
        Err(NoHull::Flat(reason)) => prop_assert!(!reason.is_empty()),
        Err(NoHull::ManyPlanes) => prop_assert!(surface.triangles.len() > 600),
    }
    Ok(())
}

/// What every surface keeps to, whatever it was read from; an error of the form of a file names its place.
fn check(bytes: &[u8]) -> Result<(), TestCaseError> {
    match read_stl(bytes) {
        Ok(surface) => {
            let count = surface.points.len();
            prop_assert!(surface.points.iter().flatten().all(|x| x.is_finite()));
            prop_assert!(surface.triangles.iter().flatten().all(|node| (*node as usize) < count));
            // A file has some bytes for each triangle.
            prop_assert!(!surface.triangles.is_empty() && surface.triangles.len() <= bytes.len() / 50);
            prop_assert!(surface.volume() >= 0.0 || surface.volume().is_nan());
            check_hull(&surface)?;
        }
        Err(MeshError::Malformed { message, .. }) => prop_assert!(!message.is_empty()),
        Err(MeshError::Unsupported { what, .. }) => prop_assert!(what.contains(": the surface"), "{what}"),
        Err(other) => prop_assert!(false, "{other}"),
    }
    Ok(())
}

#[test]
fn the_files_are_read_as_they_are() {
    let [text, binary] = FILES.each_ref().map(|bytes| read_stl(bytes).unwrap());
    assert_eq!(text, binary);
    assert_eq!((text.points.len(), text.triangles.len()), (7, 10));
    let solid = Solid::new(&text.points, &text.triangles).unwrap();
    assert!(solid.hull_ratio > 1.05, "{}", solid.hull_ratio);
}

#[test]
fn a_surface_of_many_planes_is_refused_as_soon_as_it_has_too_many() {
    // A ball of 160 000 triangles, none of which is in the plane of another.
    let n = 400_u32;
    let at = |i: u32, j: u32| {
        let theta = std::f32::consts::PI * i as f32 / (n / 2) as f32;
        let phi = 2.0 * std::f32::consts::PI * (j % n) as f32 / n as f32;
        let across = if i.is_multiple_of(n / 2) { 0.0 } else { theta.sin() };
        [across * phi.cos() + 0.0, across * phi.sin() + 0.0, theta.cos()]
    };
    let mut triangles = Vec::new();
    for i in 0..n / 2 {
        for j in 0..n {
            let [a, b, c, d] = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
            triangles.extend([[a, b, c], [a, c, d]]);
        }
    }
    let surface = read_stl(&binary(&triangles)).unwrap();
    assert_eq!(surface.triangles.len(), 159_200);
    assert_eq!(Solid::new(&surface.points, &surface.triangles).unwrap_err(), NoHull::ManyPlanes);
}

proptest! {
    #[test]
    fn a_changed_file_is_read_or_refused(is_text in any::<bool>(), changes in prop::collection::vec(change(), 1..5)) {
        let mut bytes = FILES[usize::from(!is_text)].clone();
        for change in changes {
            apply(&mut bytes, change);
        }
        check(&bytes)?;
    }

    #[test]
    fn a_binary_file_of_any_numbers_is_read_or_refused(
        nodes in prop::collection::vec(prop::array::uniform3(any::<f32>()), 7),
        is_wild in any::<[bool; 7]>(),
    ) {
        let points: [[f32; 3]; 7] = std::array::from_fn(|i| if is_wild[i] { nodes[i] } else { POINTS[i] });
        check(&binary(&TRIANGLES.map(|t| t.map(|i| points[i]))))?;
    }

    #[test]
    fn flat_and_crowded_surfaces_have_a_hull_or_none(
        grid in prop::collection::vec(prop::array::uniform3(-2_i8..3), 7),
        size in prop::sample::select(vec![1e-12, 1e-6, 1.0, 1e9]),
    ) {
        let points = grid.iter().map(|x| Vec3::from(x.map(f64::from)) * size).collect();
        let triangles = TRIANGLES.map(|t| t.map(|i| i as u32)).to_vec();
        check_hull(&ClosedSurface { points, triangles })?;
    }
}
