//! Depth of a point below a surface: the distance to its nearest face.

use super::MeshError;
use crate::mechanics::tensor::Vec3;
use parry3d_f64::math::Vector;
use parry3d_f64::query::{PointQuery, PointQueryWithLocation};
use parry3d_f64::shape::TriMesh;
use rayon::prelude::*;

/// Factor on the bound of a depth, so that its rounding excludes no face [-].
const ROUNDING: f64 = 1.0 + 1e-9;
/// Fewest points for which another thread is worth its start.
const FEWEST_POINTS: usize = 1024;

/// Distance to a fixed set of faces, quadrilaterals and triangles, by a tree of bounding boxes.
///
/// Each quadrilateral is split into four triangles at its centre: this keeps the distance symmetric where the face is, and
/// within a quarter of the warp of a face from the bilinear surface.
pub struct DepthField {
    triangles: TriMesh,
}

impl DepthField {
    /// Prepares the distance to the faces, with nodes at the given positions [m].
    ///
    /// # Errors
    /// `Surface` when there is no face, a position is not finite, or a face refers to a missing node.
    pub fn new(faces: &[[u32; 4]], positions: &[Vec3]) -> Result<Self, MeshError> {
        let refuse = |reason: String| MeshError::Surface { reason };
        if faces.is_empty() {
            return Err(refuse("it has no faces".into()));
        }
        let mut vertices = Vec::with_capacity(faces.len() * 5);
        let mut triangles = Vec::with_capacity(faces.len() * 4);
        for face in faces {
            let base = vertices.len() as u32;
            let is_triangle = face[2] == face[3];
            let mut centre = Vec3::zeros();
            for &a in face {
                let x = positions.get(a as usize).ok_or_else(|| refuse(format!("there is no node {a}")))?;
                if !x.iter().all(|c| c.is_finite()) {
                    return Err(refuse(format!("node {a} is at {x:?}")));
                }
                centre += x * 0.25;
                vertices.push(Vector::new(x.x, x.y, x.z));
            }
            if is_triangle {
                triangles.push([base, base + 1, base + 2]);
                continue;
            }
            vertices.push(Vector::new(centre.x, centre.y, centre.z));
            triangles.extend((0..4).map(|i| [base + i, base + (i + 1) % 4, base + 4]));
        }
        let triangles = TriMesh::new(vertices, triangles).map_err(|error| refuse(error.to_string()))?;
        Ok(Self { triangles })
    }

    /// Depths of points [m], each with the bits of [`DepthField::depth`]: found sooner where points follow their neighbours, since the nearest
    /// triangle of one bounds the distance of the next.
    pub fn depths(&self, points: &[Vec3]) -> Vec<f64> {
        let points = points.par_iter().with_min_len(FEWEST_POINTS);
        points.map_init(|| None, |near, point| self.depth_near(point, near)).collect()
    }

    /// Depth of a point [m], given a triangle that may be near, which is replaced by the nearest.
    fn depth_near(&self, point: &Vec3, near: &mut Option<u32>) -> f64 {
        let at = Vector::new(point.x, point.y, point.z);
        let distance = |triangle: u32| self.triangles.triangle(triangle).distance_to_local_point(at, true);
        let most = near.map_or(f64::MAX, distance) * ROUNDING;
        let found = self.triangles.project_local_point_and_get_location_with_max_dist(at, true, most);
        let Some((nearest, (triangle, _))) = found else { return self.depth(point) };
        *near = Some(triangle);
        (at - nearest.point).length()
    }

    /// Distance [m] from a point [m] to the nearest face, ≥ 0; NaN for a point that is not finite.
    pub fn depth(&self, point: &Vec3) -> f64 {
        if !point.iter().all(|c| c.is_finite()) {
            return f64::NAN;
        }
        self.triangles.distance_to_local_point(Vector::new(point.x, point.y, point.z), true)
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)] // tests may panic
mod tests {
    use super::super::generate::block::Block;
    use super::super::surface::{boundary, faces_within};
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn depth_inside_a_box_is_the_distance_to_its_nearest_side(
            x in 0.0..3.0_f64, y in 0.0..2.0_f64, z in 0.0..1.0_f64,
        ) {
            let mesh = Block::uniform(Vec3::zeros(), Vec3::new(3.0, 2.0, 1.0), [4, 3, 2], "b").generate().unwrap();
            let field = DepthField::new(&boundary(&mesh.cells), &mesh.nodes).unwrap();
            let exact = [x, 3.0 - x, y, 2.0 - y, z, 1.0 - z].into_iter().fold(f64::INFINITY, f64::min);
            let (point, depth) = (Vec3::new(x, y, z), field.depth(&Vec3::new(x, y, z)));
            prop_assert!((depth - exact).abs() < 1e-12);
            // Whether the triangle is near or far.
            for mut near in (0..field.triangles.num_triangles() as u32).map(Some).chain([None]) {
                prop_assert_eq!(field.depth_near(&point, &mut near).to_bits(), depth.to_bits());
            }
        }
    }

    #[test]
    fn depth_from_the_top_alone_is_the_height_below_it() {
        let mesh =
            Block::uniform(Vec3::zeros(), Vec3::new(1.0, 1.0, 1.0), [3, 3, 3], "b").generate().unwrap();
        let faces = faces_within(&boundary(&mesh.cells), &mesh.node_sets["z_max"]);
        let field = DepthField::new(&faces, &mesh.nodes).unwrap();
        assert!((field.depth(&Vec3::new(0.3, 0.9, 0.2)) - 0.8).abs() < 1e-12);
        assert!((field.depth(&Vec3::new(0.5, 0.5, 1.25)) - 0.25).abs() < 1e-12, "outside counts the same");
        let nowhere = Vec3::new(f64::NAN, 0.0, 0.0);
        assert!(field.depth(&nowhere).is_nan());
        let depths = field.depths(&[nowhere, Vec3::new(0.5, 0.5, 0.5), nowhere, Vec3::new(0.3, 0.9, 0.2)]);
        assert!(depths[0].is_nan() && depths[2].is_nan(), "{depths:?}");
        assert!((depths[1] - 0.5).abs() < 1e-12 && (depths[3] - 0.8).abs() < 1e-12, "{depths:?}");
    }

    #[test]
    fn a_surface_without_sound_faces_is_refused() {
        assert!(DepthField::new(&[], &[]).is_err());
        assert!(DepthField::new(&[[0, 1, 2, 3]], &[Vec3::zeros(); 3]).is_err());
        assert!(DepthField::new(&[[0, 1, 2, 3]], &[Vec3::repeat(f64::NAN); 4]).is_err());
    }
}
