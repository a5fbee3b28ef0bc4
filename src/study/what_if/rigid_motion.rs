//! Rigid motions of the bodies of a document.

use crate::mechanics::tensor::{Mat3, Vec3};
use crate::scene::document::{
    BodyDocument, FibreFrameDocument, InitialDeformation, PlacementDocument, RotationDocument,
};
use nalgebra::{Rotation3, Unit};

/// Moves a body, x ↦ R x + t, and rotates its spin and its velocity, the latter relative to a frame with the velocity
/// `frame` [m/s].
pub(super) fn carry_body(body: &mut BodyDocument, turn: &Rotation3<f64>, shift: &Vec3, frame: &Vec3) {
    move_body(body, turn, shift);
    body.velocity_m_per_s = (turn * (Vec3::from(body.velocity_m_per_s) - frame) + frame).into();
    body.spin_rad_per_s = (turn * Vec3::from(body.spin_rad_per_s)).into();
}

/// Rotation matrix of a placement.
pub(super) fn rotation_of(placement: &PlacementDocument) -> Rotation3<f64> {
    placement.rotation.as_ref().map_or_else(Rotation3::identity, turn_of)
}

/// Without an axis there is no rotation, which validation reports.
fn turn_of(rotation: &RotationDocument) -> Rotation3<f64> {
    Unit::try_new(Vec3::from(rotation.axis), 0.0).map_or_else(Rotation3::identity, |axis| {
        Rotation3::from_axis_angle(&axis, rotation.angle_deg.to_radians())
    })
}

fn document_of(rotation: &Rotation3<f64>) -> Option<RotationDocument> {
    let (axis, angle) = rotation.axis_angle()?;
    Some(RotationDocument { axis: axis.into_inner().into(), angle_deg: angle.to_degrees() })
}

/// Moves a body, x ↦ R x + t, including its fibres and its initial deformation.
pub(super) fn move_body(body: &mut BodyDocument, turn: &Rotation3<f64>, shift: &Vec3) {
    let still = *turn == Rotation3::identity();
    let moved = |point: [f64; 3]| -> [f64; 3] { (turn * Vec3::from(point) + shift).into() };
    if let Some(rigid) = &mut body.rigid {
        rigid.center_m = moved(rigid.center_m);
        if !still {
            let own = rigid.rotation.as_ref().map_or_else(Rotation3::identity, turn_of);
            rigid.rotation = document_of(&(turn * own));
        }
        return;
    }
    // Placement of a meshed body.
    let placement = body.placement.get_or_insert(PlacementDocument {
        scale: 1.0,
        rotation: None,
        translation_m: [0.0; 3],
    });
    placement.translation_m = moved(placement.translation_m);
    if !still {
        placement.rotation = document_of(&(turn * rotation_of(placement)));
    }
    if let Some(deformation) = &mut body.initial_deformation {
        move_deformation(deformation, turn, moved);
    }
    // Material axes.
    let turned = |direction: [f64; 3]| -> [f64; 3] { (turn * Vec3::from(direction)).into() };
    for frame in body.parts.iter_mut().filter_map(|part| part.fibre_frame.as_mut()) {
        match frame {
            FibreFrameDocument::Mesh {} | FibreFrameDocument::Arrays { .. } => {}
            FibreFrameDocument::Constant { axis, plane } => {
                (*axis, *plane) = (turned(*axis), turned(*plane));
            }
            FibreFrameDocument::Cylindrical { origin_m, axis } => {
                (*origin_m, *axis) = (moved(*origin_m), turned(*axis));
            }
            FibreFrameDocument::CentreLine { points_m } => {
                for point in points_m {
                    *point = moved(*point);
                }
            }
            FibreFrameDocument::Laplace { plane, .. } => *plane = plane.map(turned),
        }
    }
}

fn move_deformation(
    deformation: &mut InitialDeformation,
    turn: &Rotation3<f64>,
    moved: impl Fn([f64; 3]) -> [f64; 3],
) {
    match deformation {
        InitialDeformation::SphericalInflation { center_m, .. } => *center_m = moved(*center_m),
        InitialDeformation::Affine { center_m, deformation_gradient: rows } => {
            *center_m = moved(*center_m);
            let F = turn * Mat3::from_fn(|i, j| rows[i][j]) * turn.inverse();
            *rows = std::array::from_fn(|i| std::array::from_fn(|j| F[(i, j)]));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::document::SceneDocument;
    use crate::scene::{Budget, NoFiles, load};
    use serde_json::json;

    /// Initial positions of all nodes of the first body [m], and the axes of its elements.
    fn start(scene: &SceneDocument) -> (Vec<Vec3>, Vec<Mat3>) {
        let loaded = load(&serde_json::to_vec(scene).unwrap(), &NoFiles, &Budget::COMMAND_LINE).unwrap();
        let body = &loaded.scene.bodies[0];
        let written = &loaded.scene.document.bodies[0];
        (body.mesh.nodes.iter().map(|X| written.start_position(X)).collect(), body.axes.clone())
    }

    #[test]
    fn a_body_moves_with_its_deformation_and_its_fibres() {
        let inflated = json!({"kind": "spherical_inflation", "center_m": [0.1, 0, 0], "inner_radius_m": 0.01, "inner_stretch": 1.2});
        let sheared = json!({"kind": "affine", "center_m": [0, 0.2, 0], "deformation_gradient": [[1.1, 0.3, 0], [0, 1, 0.1], [0, 0, 0.9]]});
        let along = json!({"kind": "constant", "axis": [1, 2, 0], "plane": [0, 1, 1]});
        let around = json!({"kind": "cylindrical", "origin_m": [0.3, 0, 0.1], "axis": [0, 1, 1]});
        for (deformation, frame) in [(inflated, along), (sheared, around)] {
            let mut scene: SceneDocument = serde_json::from_value(json!({
                "name": "s", "end_time_s": 1e-4,
                "bodies": [{"name": "b", "initial_deformation": deformation,
                    "placement": {"translation_m": [0.1, 0, 0], "rotation": {"axis": [0, 0, 1], "angle_deg": 20}},
                    "mesh": {"generator": {"kind": "hollow_ball", "outer_radius_m": 0.015, "inner_radius_m": 0.01,
                                           "elements_around": 2, "elements_through": 1}},
                    "parts": [{"part": "ball", "density_kg_per_m3": 1000, "fibre_frame": frame, "material":
                        {"law": "holzapfel_gasser_ogden", "c_pa": 1e4, "k1_pa": 1e4, "k2": 1,
                         "fibres": {"angles_deg": [0]}, "bulk_modulus_pa": 1e6}}]}]
            }))
            .unwrap();
            let (nodes, axes) = start(&scene);
            let turn = Rotation3::new(Vec3::new(0.4, -0.7, 1.1));
            let shift = Vec3::new(0.05, 0.2, -0.1);
            move_body(&mut scene.bodies[0], &turn, &shift);
            let (moved, turned) = start(&scene);
            assert!(nodes.iter().zip(&moved).all(|(x, y)| (turn * x + shift - y).norm() < 1e-14));
            assert!(!axes.is_empty());
            assert!(axes.iter().zip(&turned).all(|(a, b)| (turn.matrix() * a - b).norm() < 1e-12));
        }
    }
}
