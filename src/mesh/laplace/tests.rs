//! Against solutions in closed form, in all kinds of cells.

use super::*;
use crate::mesh::CellKind;
use crate::mesh::generate::block::Block;
use crate::mesh::local_refinement::refined_in;
use crate::mesh::refinement_region::{Place, Region};
use std::f64::consts::FRAC_PI_2;

/// A block of n elements along each side, 0 to 1, mapped.
fn mapped(n: u32, map: impl Fn(&Vec3) -> Vec3) -> Mesh {
    let mut mesh = Block::uniform(Vec3::zeros(), Vec3::repeat(1.0), [n; 3], "all").generate().unwrap();
    mesh.nodes.iter_mut().for_each(|x| *x = map(x));
    mesh
}

fn centre(mesh: &Mesh, element: usize) -> Vec3 {
    let cell = mesh.cells.get(element);
    (cell.kind.table().place)(&cell.points(&mesh.nodes), cell.kind.table().centre)
}

/// Largest angle between the gradients from `z_min` to `z_max` and the exact directions [rad].
fn largest_angle(mesh: &Mesh, exact: impl Fn(&Vec3) -> Vec3) -> f64 {
    let elements: Vec<usize> = (0..mesh.cells.len()).collect();
    let found = gradients(mesh, &elements, &mesh.node_sets["z_min"], &mesh.node_sets["z_max"]).unwrap();
    let angle = |(element, g): (usize, &Vec3)| g.angle(&exact(&centre(mesh, element)));
    found.iter().enumerate().map(angle).fold(0.0, f64::max)
}

/// A cone between two spheres about its tip: φ = (1/a − 1/r)/(1/a − 1/b), along its rays.
fn cone(x: &Vec3) -> Vec3 {
    let ray = Vec3::new(0.6 * (x.x - 0.5), 0.6 * (x.y - 0.5), 1.0).normalize();
    ray * (1.0 + x.z)
}

/// A quarter of a ring of mean radius 1.5 about y, its slices of different angles: φ = θ/(π/2), around the ring.
fn bent_tube(x: &Vec3) -> Vec3 {
    let (radius, angle) = (1.0 + x.x, FRAC_PI_2 * (0.7 * x.z + 0.3 * x.z * x.z));
    Vec3::new(radius * angle.cos(), x.y, radius * angle.sin())
}

#[test]
fn a_straight_bar_is_exact_in_cells_of_every_kind_and_across_hanging_nodes() {
    let skewed = |x: &Vec3| Vec3::new(x.x + 0.3 * x.z, x.y, 2.0 * x.z);
    let mesh = Block::uniform(Vec3::zeros(), Vec3::repeat(1.0), [3; 3], "all").generate().unwrap();
    let places = Place::on_all(&mesh, &[Vec3::zeros()]);
    let (fine, split) = refined_in(&mesh, &[Region { places, within: 0.3, size: 0.2 }], 1000).unwrap();
    assert!(split > 0 && !fine.hanging.is_empty());
    for mesh in CellKind::ALL.map(|kind| mesh.split_to(kind)).into_iter().chain([fine]) {
        let angle = largest_angle(&mesh, |_| Vec3::z());
        assert!(angle < 1e-9, "{angle}");
        let elements: Vec<usize> = (0..mesh.cells.len()).collect();
        let found = gradients(&mesh, &elements, &mesh.node_sets["z_min"], &mesh.node_sets["z_max"]).unwrap();
        assert!(found.iter().all(|g| (g - Vec3::z()).norm() < 1e-9));
    }
    // In an oblique bar the gradient is not along the sides, but from end to end.
    let oblique = mapped(6, skewed);
    assert!(largest_angle(&oblique, |_| Vec3::new(0.3, 0.0, 2.0)) < 0.15);
}

#[test]
fn directions_in_a_cone_and_a_bent_tube_converge_to_the_exact_ones() {
    let around = |x: &Vec3| Vec3::new(-x.z, 0.0, x.x);
    let of_cone = [4, 8, 16].map(|n| largest_angle(&mapped(n, cone), |x: &Vec3| *x));
    let of_tube = [4, 8, 16].map(|n| largest_angle(&mapped(n, bent_tube), around));
    for errors in [of_cone, of_tube] {
        assert!(errors[2] < 0.01, "{errors:?}");
        assert!(errors[1] < errors[0] && errors[2] < errors[1], "{errors:?}");
    }
}

#[test]
fn surfaces_that_bound_nothing_are_refused() {
    let mesh = mapped(2, |x| *x);
    let [low, high] = ["z_min", "z_max"].map(|set| &mesh.node_sets[set][..]);
    let all: Vec<usize> = (0..8).collect();
    let lower: Vec<usize> = all.iter().copied().filter(|e| centre(&mesh, *e).z < 0.5).collect();
    assert_eq!(gradients(&mesh, &lower, low, high), Err(LaplaceError::NoNodes { at_end: true }));
    assert_eq!(gradients(&mesh, &all, &[], high), Err(LaplaceError::NoNodes { at_end: false }));
    let side = &mesh.node_sets["x_min"];
    assert_eq!(gradients(&mesh, &all, low, side), Err(LaplaceError::Meet { count: 3 }));
}
