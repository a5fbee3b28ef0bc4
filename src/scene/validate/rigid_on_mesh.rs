//! Rigid bodies beside meshes before anything has moved: detection looks at the nodes of a mesh, so a body that lies between them is
//! not seen by it.

use super::Findings;
use crate::mechanics::contact::Surface;
use crate::mechanics::rigid::Shape;
use crate::mechanics::tensor::Vec3;
use crate::scene::problem::{Pointer, Problem};
use std::f64::consts::PI;

/// A body this much wider than a face still enters between its four nodes, where it meets its middle.
const DIAGONAL: f64 = std::f64::consts::SQRT_2;

/// Whether a point lies inside a closed surface: the solid angle that the surface fills around it is 4π, and 0 outside and in
/// cavities (Van Oosterom & Strackee 1983). `x` [m] places of the nodes.
pub fn is_inside(surface: &Surface, x: &[Vec3], point: &Vec3) -> bool {
    let angle_of = |[a, b, c]: [Vec3; 3]| {
        let (na, nb, nc) = (a.norm(), b.norm(), c.norm());
        let under = na * nb * nc + a.dot(&b) * nc + b.dot(&c) * na + c.dot(&a) * nb;
        2.0 * a.dot(&b.cross(&c)).atan2(under)
    };
    let of_face = |face: &[u32; 4]| {
        let [a, b, c, d] = face.map(|node| x[node as usize] - point);
        angle_of([a, b, c]) + angle_of([a, c, d])
    };
    surface.faces.iter().map(of_face).sum::<f64>().abs() > 2.0 * PI
}

/// Checks that a rigid body of a pair (number `index` of the document, of a `name`) does not slip between the nodes of the other
/// side, a mesh.
pub fn check_width(
    (index, name, shape): (usize, &str, &Shape),
    (mesh, surface, x): (&str, &Surface, &[Vec3]),
    out: &mut Findings,
) {
    let size = |face: &[u32; 4]| {
        let [a, b, c, d] = face.map(|node| x[node as usize]);
        (0.5 * (c - a).cross(&(d - b)).norm()).sqrt()
    };
    let sizes = || surface.faces.iter().map(size);
    let smallest = sizes().fold(f64::INFINITY, f64::min);
    let mean = sizes().sum::<f64>() / surface.faces.len().max(1) as f64;
    let width = shape.width();
    let place = Pointer::root().key("bodies").index(index).key("rigid").key("shape");
    let remedy = format!(
        "refine {mesh} until its faces are smaller than {name} is wide, or give {name} a mesh of its own"
    );
    if width < smallest {
        let message =
            format!("{name} is smaller than every face of {mesh}: it would slip between the nodes unseen");
        out.push(
            Problem::error("smaller_than_a_face", &place, message)
                .value(width)
                .limit(format!("at least the size of the smallest face, {smallest:.3e} m"))
                .remedy(remedy),
        );
    } else if width < DIAGONAL * mean {
        let message = format!(
            "{name} is hardly wider than a face of {mesh}: it sinks in between the nodes before they feel it"
        );
        out.push(
            Problem::warning("smaller_than_a_face", &place, message)
                .value(width)
                .limit(format!("at least the diagonal of the mean face, {:.3e} m", DIAGONAL * mean))
                .remedy(remedy),
        );
    }
}
