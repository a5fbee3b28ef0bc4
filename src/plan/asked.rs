//! What a scene asks to be recorded and measured.

use super::{ForceAverage, MeasurePlan, PlanBody};
use crate::scene::Scene;
use crate::scene::document::{BodyDocument, Role, SceneDocument};
use crate::scene::exposed_faces::exposed_faces;

/// Field frames of a run that asks for none in particular.
const DEFAULT_FIELD_FRAMES: u32 = 50;

/// Field times closer than this share of the end time are the same.
const SAME_TIME: f64 = 1e-9;

/// Times [s] that the run hits exactly, from 0 to the end.
pub(super) fn field_times(scene: &Scene) -> Vec<f64> {
    let (record, end) = (&scene.document.record, scene.document.end_time_s);
    let mut times = match (&record.field_times_s, record.field_interval_s) {
        (Some(times), _) => times.clone(),
        (None, Some(interval)) => {
            let count = (end / interval * (1.0 - 1e-12)).floor() as u32;
            (1..=count).map(|i| f64::from(i) * interval).collect()
        }
        (None, None) => {
            (1..DEFAULT_FIELD_FRAMES).map(|i| end * f64::from(i) / f64::from(DEFAULT_FIELD_FRAMES)).collect()
        }
    };
    times.retain(|t| *t > 0.0 && *t < end);
    // Times that differ by rounding alone are one: a step from one to the other would be no step.
    times.retain(|t| end - t > SAME_TIME * end && *t > SAME_TIME * end);
    times.insert(0, 0.0);
    times.push(end);
    times.dedup_by(|later, earlier| *later - *earlier <= SAME_TIME * end);
    times
}

/// The tissue's skin: the asked node set, or the outer surface without faces that are wholly held.
pub(super) fn measures(scene: &Scene, bodies: &[PlanBody]) -> MeasurePlan {
    let document = &scene.document.measures;
    let ascending = |thresholds: &[f64]| {
        let mut thresholds = thresholds.to_vec();
        thresholds.sort_by(f64::total_cmp);
        thresholds
    };
    let mut skin = Vec::new();
    for (b, body) in bodies.iter().enumerate().filter(|(_, body)| body.role == Role::Tissue) {
        let first = body.nodes.start;
        let faces: Vec<[u32; 4]> = body.skin.faces.iter().map(|face| face.map(|node| node - first)).collect();
        let exposed = exposed_faces(&scene.document, b, &scene.bodies[b].mesh, &faces);
        skin.extend(exposed.into_iter().map(|face| face.map(|node| node + first)));
    }
    MeasurePlan {
        stress_thresholds: ascending(&document.stress_thresholds_pa),
        energy_density_thresholds: ascending(&document.strain_energy_density_thresholds_j_per_m3),
        strain_thresholds: ascending(&document.principal_strain_thresholds),
        person: document.person,
        force_average: match (document.force_filter, document.force_window_s) {
            (Some(filter), _) => ForceAverage::Filter(filter),
            (None, Some(window)) => ForceAverage::Window(window),
            (None, None) => ForceAverage::OfContact,
        },
        moved_by_contact_alone: is_moved_by_contact_alone(&scene.document),
        tissue_skin: skin,
    }
}

/// Whether the tissue is at rest in its own frame and undeformed, and no load or support can deform it.
fn is_moved_by_contact_alone(document: &SceneDocument) -> bool {
    let is_still = |body: &BodyDocument| {
        let flies_freely = body.fixed.is_empty() || body.velocity_m_per_s == [0.0; 3];
        flies_freely
            && body.spin_rad_per_s == [0.0; 3]
            && body.initial_deformation.is_none()
            && body.prescribed.is_empty()
            && body.face_loads.is_empty()
    };
    let is_loaded = document.gravity_m_per_s2.is_some_and(|g| g != [0.0; 3])
        || document.preload.is_some()
        || document.settle.is_some();
    !is_loaded && document.bodies.iter().filter(|body| body.role == Role::Tissue).all(is_still)
}
