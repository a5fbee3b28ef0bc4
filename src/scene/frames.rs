//! Material axes of elements from the fibre frames of the document.

use super::document::FibreFrameDocument;
use crate::mechanics::tensor::{Mat3, Vec3};
use crate::mesh::Mesh;

/// Why an element has no material axes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum NoAxes {
    /// The frame is to come from the mesh, which has none.
    MeshHasNone,
    /// The centre of this element lies on the axis of the cylinder.
    OnAxis {
        /// Index of the element.
        element: u32,
    },
    /// The directions of the frame have no length, or are parallel.
    Degenerate,
}

/// Axes e1 ∥ `axis`, e2 in the plane of both, as columns; `None` when they do not span a plane.
pub fn constant_frame(axis: [f64; 3], plane: [f64; 3]) -> Option<Mat3> {
    // Normalised first, so that only the angle between the directions matters.
    let e1 = Vec3::from(axis).try_normalize(0.0)?;
    let p = Vec3::from(plane).try_normalize(0.0)?;
    let e2 = (p - e1 * e1.dot(&p)).try_normalize(1e-9)?;
    let frame = Mat3::from_columns(&[e1, e2, e1.cross(&e2)]);
    frame.iter().all(|x| x.is_finite()).then_some(frame)
}

/// Material axes of `element`, columns e1, e2, e3. Without a frame those of the mesh, or x, y, z where it has none.
///
/// # Errors
/// [`NoAxes`] where the axes are undefined.
pub fn element_axes(frame: Option<&FibreFrameDocument>, mesh: &Mesh, element: usize) -> Result<Mat3, NoAxes> {
    let of_mesh = mesh.axes.get(element).map(|e| Mat3::from_columns(e));
    match frame {
        None => Ok(of_mesh.unwrap_or_else(Mat3::identity)),
        Some(FibreFrameDocument::Mesh {}) => of_mesh.ok_or(NoAxes::MeshHasNone),
        Some(FibreFrameDocument::Constant { axis, plane }) => {
            constant_frame(*axis, *plane).ok_or(NoAxes::Degenerate)
        }
        Some(FibreFrameDocument::Cylindrical { origin_m, axis }) => {
            let e1 = Vec3::from(*axis).try_normalize(0.0).ok_or(NoAxes::Degenerate)?;
            let corners = mesh.cells.points(element, &mesh.nodes);
            let center = corners.iter().sum::<Vec3>() / corners.len() as f64;
            let arm = center - Vec3::from(*origin_m);
            let radial = arm - e1 * e1.dot(&arm);
            let on_axis = NoAxes::OnAxis { element: element as u32 };
            let e3 = radial.try_normalize(1e-9 * arm.norm()).ok_or(on_axis)?;
            Ok(Mat3::from_columns(&[e1, e3.cross(&e1), e3]))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frames_are_right_handed_and_orthonormal() {
        let frame = constant_frame([0.0, 3.0, 0.0], [5.0, 1.0, 0.0]).unwrap();
        assert!((frame.determinant() - 1.0).abs() < 1e-15);
        assert_eq!(frame.column(0), Vec3::y());
        assert_eq!(frame.column(1), Vec3::x());
        assert!(constant_frame([1.0, 0.0, 0.0], [-2.0, 0.0, 0.0]).is_none());
        assert!(constant_frame([0.0; 3], [1.0, 0.0, 0.0]).is_none());
    }

    #[test]
    fn a_cylindrical_frame_turns_about_its_axis() {
        let corners =
            [[1, -1, -1], [3, -1, -1], [3, 1, -1], [1, 1, -1], [1, -1, 1], [3, -1, 1], [3, 1, 1], [1, 1, 1]];
        let mut mesh = Mesh {
            nodes: corners.map(|c| Vec3::from(c.map(f64::from))).to_vec(),
            cells: vec![[0, 1, 2, 3, 4, 5, 6, 7]].into(),
            ..Mesh::default()
        };
        let frame = FibreFrameDocument::Cylindrical { origin_m: [0.0; 3], axis: [0.0, 2.0, 0.0] };
        let axes = element_axes(Some(&frame), &mesh, 0).unwrap();
        assert_eq!(axes, Mat3::from_columns(&[Vec3::y(), Vec3::z(), Vec3::x()]));
        mesh.nodes.iter_mut().for_each(|x| x.x -= 2.0);
        assert_eq!(element_axes(Some(&frame), &mesh, 0), Err(NoAxes::OnAxis { element: 0 }));
        assert_eq!(element_axes(Some(&FibreFrameDocument::Mesh {}), &mesh, 0), Err(NoAxes::MeshHasNone));
    }
}
