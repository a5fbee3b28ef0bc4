//! The sector of a scene that its mirror images in the planes of symmetry complete: a half, a quarter or an eighth, which is computed
//! instead of the whole.
//!
//! The nodes on a plane are held along its normal, and the surfaces that touch are continued there by their mirror images. Forces,
//! energies and contacts of the whole are those of the sector and of its images.

mod cut;
mod history;
mod images;
pub(super) mod mapping;
mod point_history;
mod symmetry;

use super::compile::{compile_whole, recompile_whole};
use super::compiled::{Plan, SectorPlan};
use super::parts::CompileError;
use super::report::Omitted;
use crate::mechanics::contact::Discretisation;
use crate::mechanics::material::Law;
use crate::mesh::mirror::MirrorPlane;
use crate::scene::Scene;
use crate::scene::document::Keep;
use cut::{Cut, sector_of};
use history::histories;
use images::Images;
use mapping::Sector;
use symmetry::Symmetry;

/// Compiles a scene to a plan; of a symmetric scene with the plan of the sector that is computed.
///
/// # Errors
/// Inverted elements and massless nodes, which validation reports earlier and in full; invalid followers.
pub fn compile(scene: &Scene) -> Result<Plan, CompileError> {
    let _span = tracing::debug_span!("compile").entered();
    let (whole, part) = rayon::join(|| compile_whole(scene), || Part::of(scene));
    Ok(with_sector(whole?, part?))
}

/// As [`compile`], for a scene that differs from `before` (with plan `plan`) only in velocities, spins and friction:
/// elements, masses and the order of elimination are reused. Any other scene is compiled from the start.
///
/// The plan equals that of [`compile`] to the last bit.
///
/// # Errors
/// As [`compile`].
pub fn recompile(plan: Plan, before: &Scene, scene: &Scene) -> Result<Plan, CompileError> {
    let whole = recompile_whole(plan, before, scene)?;
    Ok(with_sector(whole, Part::of(scene)?))
}

/// The part of a symmetric scene above its planes of symmetry.
struct Part {
    planes: Vec<MirrorPlane>,
    /// Where it comes from, body by body.
    cuts: Vec<Cut>,
    plan: Plan,
}

impl Part {
    /// That of a scene; `None` without symmetry.
    ///
    /// # Errors
    /// As [`super::compile`].
    fn of(scene: &Scene) -> Result<Option<Self>, CompileError> {
        if scene.document.keeps(Keep::MirrorImages) || !has_images(scene) {
            return Ok(None);
        }
        let Some(symmetry) = Symmetry::of(scene) else { return Ok(None) };
        let (sector, cuts) = sector_of(scene, &symmetry);
        let plan = compile_whole(&sector)?;
        Ok(Some(Self { planes: symmetry.planes, cuts, plan }))
    }
}

/// How the whole follows from its sector; `None` if the plan of the sector has other pairs than that of the whole.
fn mapping(whole: &Plan, plan: &Plan, planes: Vec<MirrorPlane>, cuts: &[Cut]) -> Option<Sector> {
    let pairs = |plan: &Plan| plan.contact.as_ref().map(|contact| contact.pairs.clone());
    if pairs(whole) != pairs(plan) {
        return None;
    }
    let images = Images(planes);
    let mut nodes = vec![vec![u32::MAX; images.count()]; plan.node_count()];
    let mut source = vec![(u32::MAX, 0); whole.node_count()];
    let mut elements = vec![Vec::new(); plan.element_count()];
    for ((of_whole, of_sector), cut) in whole.bodies.iter().zip(&plan.bodies).zip(cuts) {
        for (node, of_node) in (of_sector.nodes.clone()).zip(&cut.nodes) {
            for (image, local) in of_node.iter().enumerate() {
                let global = of_whole.nodes.start + local;
                nodes[node as usize][image] = global;
                // Of a node on a plane, the first image counts.
                let entry = &mut source[global as usize];
                if entry.0 == u32::MAX {
                    *entry = (node, image as u8);
                }
            }
        }
        for (element, of_element) in of_sector.elements.clone().zip(&cut.elements) {
            elements[element as usize] =
                of_element.iter().map(|local| of_whole.elements.start + local).collect();
        }
    }
    let is_complete = source.iter().all(|(node, _)| *node != u32::MAX);
    let remembers = whole.has_memory();
    let history = if remembers { histories(whole, plan, &elements, &images)? } else { Vec::new() };
    is_complete.then_some(Sector { images, source, nodes, elements, history })
}

/// The report on what is not computed.
fn report(SectorPlan { plan, sector }: &SectorPlan) -> Omitted {
    let names = sector.images.0.iter().map(|plane| format!("{} = {}", ["x", "y", "z"][plane.axis], plane.at));
    let part = ["a half", "a quarter", "an eighth"][sector.images.0.len() - 1];
    Omitted {
        what: "mirror images".into(),
        why: format!(
            "the scene is symmetric about {}: {part} of it is computed, {} elements",
            names.collect::<Vec<_>>().join(" and "),
            plan.element_count()
        ),
        switch: Some(Keep::MirrorImages),
    }
}

/// Whether mirror images of all that a run computes can be derived: not of eroded elements, of internal variables of laws, and of averages over
/// faces.
fn has_images(scene: &Scene) -> bool {
    let mut parts = scene.document.bodies.iter().flat_map(|body| &body.parts);
    let mut laws = scene.bodies.iter().flat_map(|body| &body.materials);
    !parts.any(|part| part.erosion.is_some())
        && !laws.any(|law| law.history_len() > 0)
        && scene.document.contact.discretisation != Discretisation::Mortar
}

/// The plan of a whole scene with that of its sector, if it is symmetric.
fn with_sector(mut plan: Plan, part: Option<Part>) -> Plan {
    let sector = part.and_then(|Part { planes, cuts, plan: of_part }| {
        let sector = mapping(&plan, &of_part, planes, &cuts)?;
        Some(SectorPlan { plan: Box::new(of_part), sector })
    });
    if let Some(sector) = sector {
        let memory = plan.report.memory.clone().with_sector(&sector.plan.report.memory, &plan);
        let (report, of_sector) = (&mut plan.report, &sector.plan.report);
        report.omitted.insert(0, self::report(&sector));
        report.expected_steps = of_sector.expected_steps;
        report.expected_run_time_s = of_sector.expected_run_time_s;
        (report.memory_bytes, report.memory) = (memory.total_bytes(), memory);
        plan.sector = Some(sector);
    }
    plan
}
