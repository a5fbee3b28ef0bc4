//! The planes of symmetry of a scene: bodies, materials, supports, loads and motion are their own mirror images there.

use crate::mechanics::material::Material;
use crate::mechanics::rigid::Shape;
use crate::mechanics::tensor::{Mat3, Tensor, Vec3};
use crate::mesh::mirror::{MirrorImages, MirrorPlane};
use crate::scene::document::{BodyDocument, IntegratorDocument, SceneDocument};
use crate::scene::{RigidSceneBody, Scene, SceneBody};
use rayon::prelude::*;

/// Difference of stresses of mirror images, relative to the stress, or of places, relative to the size of a body [-].
const ALIKE: f64 = 1e-9;

/// The planes of symmetry of a scene, at most one normal to each axis, with the images of each body in each of them.
pub(super) struct Symmetry {
    pub planes: Vec<MirrorPlane>,
    /// For each body, and each plane in the order of `planes`; no images of a rigid body.
    pub images: Vec<Vec<Option<MirrorImages>>>,
}

impl Symmetry {
    /// `None` if the scene has no plane of symmetry, or something that is not compared with its mirror image.
    pub fn of(scene: &Scene) -> Option<Self> {
        if !is_comparable(&scene.document) {
            return None;
        }
        let found = (0..3).into_par_iter().filter_map(|axis| {
            let at = middle(scene.bodies.first()?, axis)?;
            let plane = MirrorPlane { axis, at };
            let bodies = || scene.document.bodies.iter().zip(&scene.bodies);
            let is_mirrored =
                moves_along(&scene.document, axis) && bodies().all(|(d, b)| keeps_in(d, b, plane));
            is_mirrored.then_some(())?;
            let images = bodies().map(|(document, body)| images_of(document, body, plane));
            Some((plane, images.collect::<Option<Vec<_>>>()?))
        });
        let (planes, by_plane): (Vec<_>, Vec<_>) = found.unzip();
        let of_body = |body: usize| by_plane.iter().map(|images: &Vec<_>| images[body].clone()).collect();
        let images = (0..scene.bodies.len()).map(of_body).collect();
        (!planes.is_empty()).then_some(Self { planes, images })
    }
}

/// Whether all that acts on the bodies is compared with its mirror image here. The rest is left to computations of the whole scene.
fn is_comparable(document: &SceneDocument) -> bool {
    let is_plain = |body: &BodyDocument| {
        body.initial_deformation.is_none() && body.prescribed.is_empty() && body.face_loads.is_empty()
    };
    matches!(document.integrator, IntegratorDocument::Explicit { .. } | IntegratorDocument::Implicit { .. })
        && document.preload.is_none()
        && document.dynamic_relaxation.is_none()
        && document.bodies.iter().all(is_plain)
}

/// Middle of a body along an axis [m].
fn middle(body: &SceneBody, axis: usize) -> Option<f64> {
    if let Some(rigid) = &body.rigid {
        return Some(rigid.pose.centre[axis]);
    }
    let [low, high] = body.mesh.bounding_box()?;
    Some(0.5 * (low[axis] + high[axis]))
}

/// Whether gravity and rigid planes are parallel to planes normal to an axis.
fn moves_along(document: &SceneDocument, axis: usize) -> bool {
    document.gravity_m_per_s2.is_none_or(|g| g[axis] == 0.0)
        && document.planes.iter().all(|plane| plane.normal[axis] == 0.0)
}

/// Whether a body moves in the plane, and spins about its normal at most.
fn keeps_in(document: &BodyDocument, body: &SceneBody, plane: MirrorPlane) -> bool {
    let spin = document.spin_rad_per_s;
    let is_still = |axis: usize| axis == plane.axis || spin[axis] == 0.0;
    document.velocity_m_per_s[plane.axis] == 0.0
        && (0..3).all(is_still)
        && body.rigid.as_ref().is_none_or(|rigid| is_mirrored(rigid, plane))
}

/// Whether a rigid body is its own mirror image.
fn is_mirrored(rigid: &RigidSceneBody, plane: MirrorPlane) -> bool {
    let is_along_an_axis = |column: usize| {
        let direction = rigid.pose.orientation * Mat3::identity().column(column);
        direction.iter().filter(|x| x.abs() > ALIKE).count() == 1
    };
    (rigid.pose.centre[plane.axis] - plane.at).abs() <= ALIKE * rigid.shape.outer_radius()
        && !matches!(rigid.shape, Shape::Polyhedron(_))
        && (0..3).all(is_along_an_axis)
}

/// Images of a body's mesh with their materials and supports, `Some(None)` for a rigid body; `None` if they differ.
#[allow(clippy::option_option)] // no images, and none needed
fn images_of(document: &BodyDocument, body: &SceneBody, plane: MirrorPlane) -> Option<Option<MirrorImages>> {
    if body.rigid.is_some() {
        return Some(None);
    }
    let images = MirrorImages::new(&body.mesh, plane)?;
    let is_held_alike = document
        .fixed
        .iter()
        .filter_map(|fixed| body.mesh.node_sets.get(&fixed.set))
        .all(|set| set.iter().all(|node| set.binary_search(&images.nodes[*node as usize]).is_ok()));
    let is_alike = |(element, image): (usize, &u32)| {
        let image = *image as usize;
        let law = body.law_of[element];
        law == body.law_of[image]
            && body.part_entry[element] == body.part_entry[image]
            && (body.axes.is_empty()
                || responds_alike(
                    &body.materials[law as usize],
                    [&body.axes[element], &body.axes[image]],
                    plane,
                ))
    };
    let is_alike = is_held_alike && images.elements.iter().enumerate().all(is_alike);
    is_alike.then_some(Some(images))
}

/// A deformation without any symmetry, F − I [-].
const SHEARED: [[f64; 3]; 3] = [[0.11, -0.07, 0.05], [0.03, -0.09, 0.13], [-0.06, 0.08, 0.04]];

/// Whether the stress of a law with the mirrored axes, at the mirrored deformation, is the mirrored stress.
fn responds_alike(law: &Material, [axes, of_image]: [&Mat3; 2], plane: MirrorPlane) -> bool {
    if law.fibre_directions().is_empty() {
        return true;
    }
    let stress = |H: &Mat3, axes: &Mat3| {
        let in_reference = |direction: &[f64; 3]| (axes * Vec3::from(*direction)).into();
        let fibres: Vec<[f64; 3]> = law.fibre_directions().iter().map(in_reference).collect();
        let H = Tensor(std::array::from_fn(|i| std::array::from_fn(|j| H[(i, j)])));
        let P = law.eval_total(&H, &fibres).P;
        Mat3::from_fn(|i, j| P.0[i][j])
    };
    let mut mirror = Mat3::identity();
    mirror[(plane.axis, plane.axis)] = -1.0;
    // Fibres in tension, and in compression.
    [1.0, -1.0].iter().all(|sign| {
        let H = Mat3::from_fn(|i, j| sign * SHEARED[i][j]);
        let (own, image) = (stress(&H, axes), stress(&(mirror * H * mirror), of_image));
        (mirror * own * mirror - image).norm() <= ALIKE * own.norm()
    })
}

#[cfg(test)]
#[allow(clippy::unwrap_used)] // tests may panic
mod tests;
