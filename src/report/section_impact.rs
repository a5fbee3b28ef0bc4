//! Where the path of the projectile meets the surface of the tissue at rest.

use super::instant::Body;
use crate::mechanics::tensor::Vec3;
use crate::mesh::surface;

/// What a path may miss a triangle by and still meet it: it often runs through a node [m].
const MISS: f64 = 1e-6;
/// Least cosine between the normals of triangles across an edge that is smooth; others are creases.
const SMOOTH: f64 = 0.5;

/// Point of impact at rest.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Impact {
    /// Where the path enters the surface; beside the nearest triangle if it misses the tissue [m].
    pub at: Vec3,
    /// Outward unit normal there, interpolated between those of the nodes.
    pub outward: Vec3,
}

/// A triangle of the surface.
struct Facet {
    corners: [Vec3; 3],
    nodes: [u32; 3],
    /// Normal with the length of twice the area [m²].
    normal: Vec3,
}

impl Impact {
    /// Of the path through `centre` along the unit vector `direction` on the first body that it meets; `None` if no surface faces it.
    pub fn of(tissues: &[&Body], centre: Vec3, direction: Vec3) -> Option<Self> {
        let facets = facets(tissues);
        let hits = facets.iter().filter(|facet| facet.normal.dot(&direction) < 0.0).map(|facet| {
            let along = facet.normal.dot(&(facet.corners[0] - centre)) / facet.normal.dot(&direction);
            let at = centre + direction * along;
            let weights = facet.weights(at);
            (facet, at, weights, (facet.missed_by(weights) - MISS).max(0.0), along)
        });
        // The first along the path, of those that it meets.
        let nearest = hits.min_by(|a, b| a.3.total_cmp(&b.3).then(a.4.total_cmp(&b.4)));
        let (hit, at, weights, ..) = nearest?;
        let own = hit.normal.normalize();
        let normal_at = |node: u32| {
            let around = facets.iter().filter(|facet| facet.nodes.contains(&node));
            let smooth = around.filter(|facet| facet.normal.dot(&own) > SMOOTH * facet.normal.norm());
            smooth.map(|facet| facet.normal).sum::<Vec3>().normalize()
        };
        let outward: Vec3 = (0..3).map(|i| normal_at(hit.nodes[i]) * weights[i].clamp(0.0, 1.0)).sum();
        Some(Self { at, outward: outward.normalize() })
    }
}

/// The surfaces of bodies at rest in triangles, without those of no area; the nodes of all bodies are numbered one after the other.
fn facets(bodies: &[&Body]) -> Vec<Facet> {
    let (mut facets, mut first) = (Vec::new(), 0);
    for body in bodies {
        let faces = surface::boundary(&body.cells).into_iter();
        let triangles = faces.flat_map(|[a, b, c, d]| [[a, b, c], [a, c, d]]);
        facets.extend(triangles.map(|nodes| {
            let corners = nodes.map(|node| Vec3::from(body.rest[node as usize]));
            let normal = (corners[1] - corners[0]).cross(&(corners[2] - corners[0]));
            Facet { corners, nodes: nodes.map(|node| first + node), normal }
        }));
        first += body.rest.len() as u32;
    }
    facets.retain(|facet| facet.normal.norm() > 0.0);
    facets
}

impl Facet {
    /// The edge opposite to a corner.
    fn edge(&self, corner: usize) -> [Vec3; 2] {
        [1, 2].map(|next| self.corners[(corner + next) % 3])
    }
    /// Barycentric coordinates of a point of its plane.
    fn weights(&self, at: Vec3) -> [f64; 3] {
        [0, 1, 2].map(|corner| {
            let [from, to] = self.edge(corner);
            (from - at).cross(&(to - at)).dot(&self.normal) / self.normal.norm_squared()
        })
    }
    /// Distance from the farthest edge that a point of its plane lies beyond [m]; negative inside.
    fn missed_by(&self, weights: [f64; 3]) -> f64 {
        let beyond = (0..3).map(|corner| {
            let [from, to] = self.edge(corner);
            -weights[corner] * self.normal.norm() / (to - from).norm()
        });
        beyond.fold(f64::NEG_INFINITY, f64::max)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::{CellKind, Cells};

    /// Two cubes in a row along x, whose tops rise to `ridge` between them.
    fn roof(ridge: f64) -> Body {
        let mut cells = Cells::default();
        cells.push(CellKind::Hex8, &[0, 1, 2, 3, 4, 5, 6, 7]);
        cells.push(CellKind::Hex8, &[1, 8, 9, 2, 5, 10, 11, 6]);
        let rest = [
            [-1.0, -1.0, 0.0],
            [0.0, -1.0, 0.0],
            [0.0, 1.0, 0.0],
            [-1.0, 1.0, 0.0],
            [-1.0, -1.0, 1.0],
            [0.0, -1.0, ridge],
            [0.0, 1.0, ridge],
            [-1.0, 1.0, 1.0],
            [1.0, -1.0, 0.0],
            [1.0, 1.0, 0.0],
            [1.0, -1.0, 1.0],
            [1.0, 1.0, 1.0],
        ];
        Body { cells, rest: rest.to_vec(), ..Body::default() }
    }

    #[test]
    fn the_path_enters_where_it_first_meets_the_surface() {
        let slanted = Vec3::new(1.0, 0.0, -1.0).normalize();
        let hit = Impact::of(&[&roof(1.0)], Vec3::new(-0.5, 0.3, 1.5), slanted).unwrap();
        assert!((hit.at - Vec3::new(0.0, 0.3, 1.0)).norm() < 1e-12, "{hit:?}");
        assert!((hit.outward - Vec3::z()).norm() < 1e-12, "{hit:?}");
        // Its centre has passed the surface.
        let inside = Impact::of(&[&roof(1.0)], Vec3::new(0.5, 0.3, 0.5), slanted).unwrap();
        assert!((inside.at - hit.at).norm() < 1e-12);
        // Beside the tissue: the normal of the nearest triangle.
        let beside = Impact::of(&[&roof(1.0)], Vec3::new(1.2, 0.0, 3.0), -Vec3::z()).unwrap();
        assert!((beside.outward - Vec3::z()).norm() < 1e-12, "{beside:?}");
    }

    #[test]
    fn of_several_bodies_the_first_on_the_path_is_struck() {
        let lower = roof(1.0);
        let upper =
            Body { rest: lower.rest.iter().map(|[x, y, z]| [*x, *y, z + 1.0]).collect(), ..roof(1.0) };
        for bodies in [[&lower, &upper], [&upper, &lower]] {
            let hit = Impact::of(&bodies, Vec3::new(0.3, 0.3, 4.0), -Vec3::z()).unwrap();
            assert!((hit.at - Vec3::new(0.3, 0.3, 2.0)).norm() < 1e-12, "{hit:?}");
            assert!((hit.outward - Vec3::z()).norm() < 1e-12, "{hit:?}");
        }
    }

    #[test]
    fn the_normal_is_smooth_across_blunt_edges_only() {
        // On the ridge both slopes count alike, and beside it the nearer one more; the sides do not.
        let at = |x: f64| Impact::of(&[&roof(1.2)], Vec3::new(x, 0.0, 3.0), -Vec3::z()).unwrap().outward;
        assert!((at(0.0) - Vec3::z()).norm() < 1e-12, "{}", at(0.0));
        let slope = Vec3::new(0.2, 0.0, 1.0).normalize();
        assert!(at(0.5).x > 0.05 && at(0.5).x < slope.x && at(0.5).y.abs() < 1e-12, "{}", at(0.5));
        assert!((at(1.0) - slope).norm() < 1e-12, "{}", at(1.0));
    }
}
