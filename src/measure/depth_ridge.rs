//! Ridges of the depth: places where tissue is deeper than at the corners of its elements.
//!
//! The depth of a point is its distance to the nearest face of the surface. Halfway between two faces it has a ridge, and a summit where the
//! ridge meets a third one or an end of the tissue. With an odd number of elements between the faces the ridge goes through the middle of
//! elements, and all of their corners are less deep. There the middles of edges, faces and elements that are deeper than all of their
//! corners are places of the stress field, too.

use crate::mechanics::element::MOST_POINTS;
use crate::mechanics::tensor::Vec3;
use crate::mesh::cell::CellKind;

/// Excess of the depth at the middle of an element over the mean of its corners, over its shortest edge, above which a ridge is looked for
/// [-]: 1/2 if the ridge lies in its middle, 0 if the depth is linear, h/4R in a cube of edge h at a distance R from
/// the centre of a ball.
const LEAST_EXCESS: f64 = 0.125;

/// Difference of two depths, over the shortest edge, that is rounding [-].
const ROUNDING: f64 = 1e-9;

/// Depths in an element that has a ridge in it.
#[derive(Clone, Debug, PartialEq)]
pub struct Ridge {
    /// Depths of its quadrature points [m].
    pub points: [f64; MOST_POINTS],
    /// Middles of edges, of faces, and of the element, that are deeper than all of their corners.
    pub middles: Vec<Middle>,
}

/// The middle of some corners of an element.
#[derive(Clone, Debug, PartialEq)]
pub struct Middle {
    /// The corners, by their number in the element.
    pub corners: Vec<usize>,
    /// Depth of their middle [m].
    pub depth: f64,
}

impl Ridge {
    /// The ridge in an element with nodes at `x` [m], given the depths of its corners and of their middle [m] and that of any point;
    /// `None` if no middle is deeper than its corners.
    pub fn of(
        cell: CellKind,
        x: &[Vec3],
        (corners, middle): (&[f64], f64),
        depth: impl Fn(&Vec3) -> f64,
    ) -> Option<Self> {
        let (kind, table) = (cell.element(), cell.table());
        let shortest = table.edges.iter().map(|[a, b]| (x[*b] - x[*a]).norm()).fold(f64::INFINITY, f64::min);
        let mean = corners.iter().sum::<f64>() / corners.len() as f64;
        // Nearly all elements have none.
        if middle - mean <= LEAST_EXCESS * shortest {
            return None;
        }
        // Middles that are deeper than all of their corners.
        let all: Vec<usize> = (0..table.corners).collect();
        let edges = table.edges.iter().map(<[usize; 2]>::as_slice);
        let faces = table.faces.iter().map(|face| face.corners);
        let sets = edges.chain(faces).chain([all.as_slice()]);
        let deeper = sets.filter_map(|set| {
            let deepest = set.iter().map(|corner| corners[*corner]).fold(0.0, f64::max);
            let depth = depth(&middle_of(set.iter().map(|corner| x[*corner])));
            (depth > deepest + ROUNDING * shortest).then(|| Middle { corners: set.to_vec(), depth })
        });
        let middles: Vec<Middle> = deeper.collect();
        if middles.is_empty() {
            return None;
        }
        // The depth is not linear between the corners: that of each point is its own.
        let mut points = [0.0; MOST_POINTS];
        for (q, to) in points.iter_mut().enumerate().take(kind.point_count()) {
            *to = depth(&x.iter().zip(kind.shapes_at(q)).map(|(x, N)| x * *N).sum::<Vec3>());
        }
        Some(Self { points, middles })
    }
}

/// Mean of some places [m].
pub fn middle_of(places: impl ExactSizeIterator<Item = Vec3>) -> Vec3 {
    let count = places.len() as f64;
    places.sum::<Vec3>() / count
}

#[cfg(test)]
#[allow(clippy::float_cmp)] // the same value
mod tests {
    use super::*;

    /// A unit cube about the origin.
    fn cube() -> Vec<Vec3> {
        CellKind::Hex8.table().points.iter().map(|xi| Vec3::from(*xi) * 0.5).collect()
    }

    fn ridge(depth: impl Fn(&Vec3) -> f64) -> Option<Ridge> {
        let x = cube();
        let corners: Vec<f64> = x.iter().map(&depth).collect();
        Ridge::of(CellKind::Hex8, &x, (&corners, depth(&Vec3::zeros())), depth)
    }

    /// Numbers of corners of the middles, with their depths [m].
    fn middles(ridge: Option<Ridge>) -> Vec<(usize, f64)> {
        let middles = ridge.map_or_else(Vec::new, |ridge| ridge.middles);
        middles.iter().map(|middle| (middle.corners.len(), middle.depth)).collect()
    }

    #[test]
    fn between_parallel_faces_the_middles_of_the_edges_across_are_deepest() {
        let found = ridge(|x| 5.0 - x.z.abs());
        assert!(found.as_ref().is_some_and(|ridge| {
            let off = 0.5 / 3.0_f64.sqrt();
            ridge.points.iter().all(|depth| (depth - (5.0 - off)).abs() < 1e-12)
        }));
        let middles = middles(found);
        // Four edges, four faces, and the element.
        assert_eq!(
            middles.iter().map(|(corners, _)| *corners).collect::<Vec<_>>(),
            [2, 2, 2, 2, 4, 4, 4, 4, 8]
        );
        assert!(middles.iter().all(|(_, depth)| (depth - 5.0).abs() < 1e-12), "{middles:?}");
    }

    #[test]
    fn a_summit_on_the_back_is_the_middle_of_a_face() {
        // Below a top, halfway between two pairs of sides: the ridge ends at the back, which is no surface.
        let middles = middles(ridge(|x| (4.5 - x.z).min(5.0 - x.x.abs().max(x.y.abs()))));
        let deepest = middles.iter().map(|(_, depth)| *depth).fold(0.0, f64::max);
        assert!((deepest - 5.0).abs() < 1e-12, "{middles:?}");
        assert!(middles.iter().any(|(corners, depth)| *corners == 4 && *depth == deepest), "{middles:?}");
    }

    #[test]
    fn linear_depth_and_that_of_a_gently_curved_surface_have_no_ridge() {
        assert_eq!(ridge(|x| 5.0 + 0.6 * x.z - 0.3 * x.x), None);
        assert_eq!(ridge(|x| 10.0 - (x - Vec3::new(0.0, 0.0, -6.0)).norm()), None);
    }
}
