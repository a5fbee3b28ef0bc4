//! Requested output: field times, and the inputs of the measures.

use super::body::PlanBody;
use super::measure_plan::{ForceAverage, MeasurePlan, TissueEnd};
use crate::scene::Scene;
use crate::scene::document::{BodyDocument, MeasuresDocument, Role, SceneDocument};
use crate::scene::exposed_faces::{CUTS, exposed_faces, is_generated_limb};
use std::collections::BTreeSet;

/// Default number of field frames of a run.
const DEFAULT_FIELD_FRAMES: u32 = 50;

/// Field times closer than this fraction of the end time coincide [-].
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
    // Times inside the run, with its start and end.
    times.retain(|t| *t > 0.0 && *t < end);
    // Times that differ by rounding alone are one: otherwise a step would have no length.
    times.retain(|t| end - t > SAME_TIME * end && *t > SAME_TIME * end);
    times.insert(0, 0.0);
    times.push(end);
    times.dedup_by(|later, earlier| *later - *earlier <= SAME_TIME * end);
    times
}

/// Inputs of the measures. The tissue's surface is the requested node set, or the boundary without faces that are wholly held.
pub(super) fn measures(scene: &Scene, bodies: &[PlanBody]) -> MeasurePlan {
    let document = &scene.document.measures;
    let ascending = |thresholds: &[f64]| {
        let mut thresholds = thresholds.to_vec();
        thresholds.sort_by(f64::total_cmp);
        thresholds
    };
    let mut boundary = Vec::new();
    for (b, body) in bodies.iter().enumerate().filter(|(_, body)| body.role == Role::Tissue) {
        let first = body.nodes.start;
        let faces: Vec<[u32; 4]> =
            body.boundary.faces.iter().map(|face| face.map(|node| node - first)).collect();
        let exposed = exposed_faces(&scene.document, b, &scene.bodies[b].mesh, &faces);
        boundary.extend(exposed.into_iter().map(|face| face.map(|node| node + first)));
    }
    MeasurePlan {
        stress_thresholds: ascending(&document.stress_thresholds_pa),
        energy_density_thresholds: ascending(&document.strain_energy_density_thresholds_j_per_m3),
        strain_thresholds: ascending(&document.principal_strain_thresholds),
        exceeded_in_volume: document.exceeded_in_volume_m3.unwrap_or(MeasuresDocument::EXCEEDED_IN_VOLUME),
        person: document.person,
        force_average: match (document.force_filter, document.force_window_s) {
            (Some(filter), _) => ForceAverage::Filter(filter),
            (None, Some(window)) => ForceAverage::Window(window),
            (None, None) => ForceAverage::OfContact,
        },
        tissue_ends: tissue_ends(scene, bodies, &boundary),
        moved_by_contact_alone: is_moved_by_contact_alone(&scene.document),
        tissue_skin: boundary,
    }
}

/// Held node sets by name, the cuts of generated limbs, and outer faces that are no skin; not those that a symmetry holds.
fn tissue_ends(scene: &Scene, bodies: &[PlanBody], boundary: &[[u32; 4]]) -> Vec<TissueEnd> {
    let mut ends = Vec::new();
    let mut add = |name: String, mut nodes: Vec<u32>| {
        nodes.sort_unstable();
        nodes.dedup();
        if !nodes.is_empty() {
            ends.push(TissueEnd { name, nodes });
        }
    };
    let on_boundary: BTreeSet<u32> = boundary.iter().flatten().copied().collect();
    for (b, body) in
        bodies.iter().enumerate().filter(|(_, body)| body.role == Role::Tissue && body.rigid.is_none())
    {
        let (document, mesh) = (&scene.document.bodies[b], &scene.bodies[b].mesh);
        let of_set = |name: &str| {
            let nodes = mesh.node_sets.get(name).map_or(&[][..], Vec::as_slice);
            nodes.iter().map(|node| node + body.nodes.start).collect::<Vec<_>>()
        };
        let mut known: BTreeSet<u32> = document.fixed.iter().flat_map(|fixed| of_set(&fixed.set)).collect();
        for fixed in document.fixed.iter().filter(|fixed| fixed.axes.len() == 3) {
            add(format!("the held nodes \u{201c}{}\u{201d}", fixed.set), of_set(&fixed.set));
        }
        if is_generated_limb(document) {
            let cuts: Vec<u32> = CUTS.iter().flat_map(|set| of_set(set)).collect();
            known.extend(&cuts);
            add("an artificial end of the model".into(), cuts);
        }
        let is_back = |face: &&[u32; 4]| {
            !face.iter().all(|node| on_boundary.contains(node))
                && !face.iter().all(|node| known.contains(node))
        };
        let back = body.boundary.faces.iter().filter(is_back).flatten();
        add(
            "the back or a side of the model".into(),
            back.filter(|node| !on_boundary.contains(node)).copied().collect(),
        );
    }
    ends
}

/// Whether the tissue is undeformed and at rest in its own frame, and no load or support can deform it.
fn is_moved_by_contact_alone(document: &SceneDocument) -> bool {
    let is_zero = |vector: [f64; 3]| vector.iter().all(|x| *x == 0.0);
    let is_still = |body: &BodyDocument| {
        let flies_freely = body.fixed.is_empty() || is_zero(body.velocity_m_per_s);
        flies_freely
            && is_zero(body.spin_rad_per_s)
            && body.initial_deformation.is_none()
            && body.prescribed.is_empty()
            && body.face_loads.is_empty()
    };
    let is_loaded = document.gravity_m_per_s2.is_some_and(|g| !is_zero(g))
        || document.preload.is_some()
        || document.dynamic_relaxation.is_some();
    !is_loaded && document.bodies.iter().filter(|body| body.role == Role::Tissue).all(is_still)
}
