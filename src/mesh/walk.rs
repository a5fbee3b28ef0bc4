//! Straight paths over a boundary surface.

use super::triangulated_surface::{SurfacePoint, TriangulatedSurface};
use crate::mechanics::tensor::Vec3;

/// Why a path ends before its length.
#[derive(Clone, Debug, PartialEq)]
pub struct WalkEnd {
    /// What stops the path.
    pub what: Obstacle,
    /// Point at which the path ends [m].
    pub place: Vec3,
    /// Length of the path up to there [m].
    pub walked: f64,
}

/// An obstacle that ends a path.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Obstacle {
    /// An edge of an open surface.
    Border,
    /// An edge where the surface is sharply bent.
    SharpEdge {
        /// Angle between the faces [°].
        turn_deg: f64,
    },
    /// The start of the path, reached from behind.
    Beginning,
}

/// The plane that contains a path: a point, and the unit normal to its left.
struct Cut {
    point: Vec3,
    left: Vec3,
}

impl TriangulatedSurface {
    /// The point that lies `length` [m] (≥ 0) over the surface from another one, straight ahead in a direction (of any length, not
    /// along the normal).
    ///
    /// The path is the section of the surface with the plane of normal and direction: a straight line on a plane, a great
    /// circle on a ball. Its length is measured on the facets.
    ///
    /// # Errors
    /// What ends the path earlier: a border, an edge where the surface turns by more than 60°, or the beginning.
    pub fn walk(&self, from: &SurfacePoint, direction: &Vec3, length: f64) -> Result<SurfacePoint, WalkEnd> {
        let left = from.normal.cross(direction).try_normalize(0.0).unwrap_or_else(Vec3::zeros);
        let cut = Cut { point: from.place, left };
        let ended = |what, place, walked| WalkEnd { what, place, walked };
        let Some(start) = self.nearest_on(&cut) else {
            return Err(ended(Obstacle::Border, from.place, 0.0));
        };
        let (mut triangle, mut place, mut walked) = (start, from.place, 0.0);
        while let Some(edge) = self.exit(triangle, &cut) {
            let exit = self.crossing(triangle, edge, &cut);
            let step = (exit - place).norm();
            if walked + step > length {
                return Ok(self.point(triangle, place + (exit - place) * ((length - walked) / step)));
            }
            (place, walked) = (exit, walked + step);
            let Some(next) = self.across(triangle, edge) else { break };
            if let Some(cosine) = self.sharp_turn(triangle, next) {
                let turn_deg = cosine.clamp(-1.0, 1.0).acos().to_degrees();
                return Err(ended(Obstacle::SharpEdge { turn_deg }, place, walked));
            }
            if next == start {
                let round = walked + (from.place - place).norm();
                return Err(ended(Obstacle::Beginning, from.place, round));
            }
            triangle = next;
        }
        Err(ended(Obstacle::Border, place, walked))
    }

    /// The triangle cut by the plane in which the path begins: the one whose section is nearest to its point. (The triangle
    /// in which the point was found may miss the plane by rounding, or lie behind one of its corners.)
    fn nearest_on(&self, cut: &Cut) -> Option<usize> {
        let distance = |triangle: usize| {
            let ends = [self.entrance(triangle, cut)?, self.exit(triangle, cut)?];
            let [a, b] = ends.map(|edge| self.crossing(triangle, edge, cut));
            let (along, arm) = (b - a, cut.point - a);
            let fraction = (arm.dot(&along) / along.norm_squared()).clamp(0.0, 1.0);
            let fraction = if fraction.is_nan() { 0.0 } else { fraction };
            Some((arm - along * fraction).norm())
        };
        let distances = (0..self.len()).filter_map(|triangle| Some((distance(triangle)?, triangle)));
        distances.min_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, triangle)| triangle)
    }

    /// The edge by which the path leaves a triangle: from its right to its left, in counter-clockwise order. A node on the
    /// plane counts as left of it, for all its triangles alike: each triangle that is cut has one such edge, and its
    /// neighbour is entered there.
    fn exit(&self, triangle: usize, cut: &Cut) -> Option<usize> {
        let is_left = self.corners(triangle).map(|x| cut.height(&x) >= 0.0);
        (0..3).find(|&edge| !is_left[edge] && is_left[(edge + 1) % 3])
    }

    /// The edge by which the path enters, from left to right.
    fn entrance(&self, triangle: usize, cut: &Cut) -> Option<usize> {
        let is_left = self.corners(triangle).map(|x| cut.height(&x) >= 0.0);
        (0..3).find(|&edge| is_left[edge] && !is_left[(edge + 1) % 3])
    }

    /// Intersection of an edge with the plane [m]; its ends lie on opposite sides.
    fn crossing(&self, triangle: usize, edge: usize, cut: &Cut) -> Vec3 {
        let corners = self.corners(triangle);
        let (a, b) = (corners[edge], corners[(edge + 1) % 3]);
        let (h, g) = (cut.height(&a), cut.height(&b));
        a + (b - a) * (h / (h - g))
    }
}

impl Cut {
    /// Signed distance of a point to the left of the plane [m].
    fn height(&self, x: &Vec3) -> f64 {
        self.left.dot(&(x - self.point))
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)] // tests may panic
mod tests {
    use super::super::generate::block::Block;
    use super::super::generate::cylinder::Cylinder;
    use super::super::generate::solid_ball::SolidBall;
    use super::super::surface::{boundary, faces_within};
    use super::*;
    use crate::mesh::Mesh;
    use proptest::prelude::*;
    use std::f64::consts::PI;

    const RADIUS: f64 = 0.05;

    fn boundary_of(mesh: &Mesh) -> TriangulatedSurface {
        TriangulatedSurface::new(&boundary(&mesh.cells), mesh.nodes.clone())
    }

    fn ball() -> TriangulatedSurface {
        let ball = SolidBall {
            center_m: [0.0; 3],
            radius_m: RADIUS,
            elements_around: 6,
            elements_through: 1,
            // Uneven facets: normals must not lean towards the larger ones.
            grading: 2.0,
            is_quarter: false,
        };
        boundary_of(&ball.generate().unwrap())
    }

    fn block() -> Mesh {
        Block::uniform(Vec3::zeros(), Vec3::new(0.6, 0.4, 0.2), [6, 4, 2], "b").generate().unwrap()
    }

    /// Least distance of the planes of the triangles from the origin [m].
    fn inner_radius(boundary: &TriangulatedSurface) -> f64 {
        let distance = |triangle: usize| {
            let [a, b, c] = boundary.corners(triangle);
            (b - a).cross(&(c - a)).normalize().dot(&a)
        };
        (0..boundary.len()).map(distance).fold(f64::INFINITY, f64::min)
    }

    proptest! {
        /// The path over the facets is a convex polygon between the ball and the largest ball inside the facets.
        #[test]
        fn on_a_ball_the_way_is_a_great_circle(
            up in prop::array::uniform3(-1.0..1.0_f64), along in prop::array::uniform3(-1.0..1.0_f64),
            fraction in 0.0..5.5_f64,
        ) {
            let (up, along) = (Vec3::from(up), Vec3::from(along));
            prop_assume!(up.norm() > 0.1 && up.normalize().cross(&along).norm() > 0.1);
            let (up, boundary) = (up.normalize(), ball());
            let inner = inner_radius(&boundary);
            let (_, from) = boundary.entry(&(up * 0.2), &-up).unwrap();
            prop_assert!((from.normal - up).norm() < 1e-12, "{:?}", from.normal);
            let to = boundary.walk(&from, &along, fraction * RADIUS).unwrap();
            prop_assert!((to.normal - to.place.normalize()).norm() < 1e-12);
            prop_assert!((inner - 1e-12..RADIUS + 1e-12).contains(&to.place.norm()));
            let across = up.cross(&along).normalize();
            prop_assert!(to.place.dot(&across).abs() < 1e-12);
            let turned = to.normal.dot(&across.cross(&up)).atan2(to.normal.dot(&up)).rem_euclid(2.0 * PI);
            let turned = if turned > 6.2 { turned - 2.0 * PI } else { turned };
            // The first and the last segment are inclined by the depth of the facets below the ball.
            let askew = (inner / RADIUS).acos();
            prop_assert!(turned > fraction * (1.0 - 1e-12) - askew * (1.0 - inner / RADIUS));
            prop_assert!(turned < fraction * RADIUS / inner * (1.0 + 1e-12) + 1e-12, "{turned} {fraction}");
        }
    }

    #[test]
    fn on_a_flat_surface_the_way_is_straight_through_nodes_and_along_edges() {
        let boundary = boundary_of(&block());
        for from in [[0.3, 0.2], [0.25, 0.2], [0.23, 0.21]] {
            let (height, from) = boundary.entry(&Vec3::new(from[0], from[1], 1.2), &-Vec3::z()).unwrap();
            assert!((height - 1.0).abs() < 1e-15 && (from.normal - Vec3::z()).norm() < 1e-15);
            for along in
                [[1.0, 0.0, 0.0], [0.0, -1.0, 0.3], [1.0, 1.0, 0.0], [-0.3, 0.1, -2.0], [2.0, 1.0, 0.0]]
            {
                let flat = Vec3::new(along[0], along[1], 0.0).normalize();
                let to = boundary.walk(&from, &Vec3::from(along), 0.17).unwrap();
                assert!((to.place - from.place - flat * 0.17).norm() < 1e-15, "{along:?}");
                assert!((to.normal - Vec3::z()).norm() < 1e-15);
            }
        }
    }

    #[test]
    fn a_way_ends_at_a_sharp_edge_at_the_border_and_where_it_began() {
        let block = block();
        let above = Vec3::new(0.3, 0.2, 1.0);
        let whole = boundary_of(&block);
        let (_, from) = whole.entry(&above, &-Vec3::z()).unwrap();
        let end = whole.walk(&from, &Vec3::x(), 0.31).unwrap_err();
        assert!(matches!(end.what, Obstacle::SharpEdge { turn_deg } if (turn_deg - 90.0).abs() < 1e-9));
        assert!((end.place - Vec3::new(0.6, 0.2, 0.2)).norm() < 1e-15 && (end.walked - 0.3).abs() < 1e-15);

        let top = faces_within(&boundary(&block.cells), &block.node_sets["z_max"]);
        let top = TriangulatedSurface::new(&top, block.nodes.clone());
        let end = top.walk(&from, &-Vec3::y(), 0.21).unwrap_err();
        assert_eq!(end.what, Obstacle::Border);
        assert!((end.place - Vec3::new(0.3, 0.0, 0.2)).norm() < 1e-15);
        assert!(top.entry(&above, &Vec3::z()).is_none() && top.entry(&-above, &Vec3::z()).is_none());

        let around = 5;
        let baton = Cylinder {
            center_m: [0.0; 3],
            axis: [0.0, 1.0, 0.0],
            radius_m: RADIUS,
            length_m: 0.1,
            elements_around: around,
            elements_through: 1,
            elements_along: 3,
        };
        let baton = boundary_of(&baton.generate().unwrap());
        let (_, from) = baton.entry(&Vec3::new(0.003, 0.01, 0.1), &-Vec3::z()).unwrap();
        let corners = f64::from(4 * around);
        let perimeter = corners * 2.0 * RADIUS * (PI / corners).sin();
        // The normal is inclined by the offset of the point from the axis: the section is that of a plane through it and
        // the axis of the baton.
        let end = baton.walk(&from, &Vec3::x(), 10.0 * RADIUS).unwrap_err();
        assert_eq!(end.what, Obstacle::Beginning);
        assert!((end.walked - perimeter).abs() < 1e-12, "{} {perimeter}", end.walked);
    }
}
