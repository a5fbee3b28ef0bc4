//! The sector of a scene that its mirror images in the planes of symmetry complete: a half, a quarter or an eighth, which is computed
//! instead of the whole.
//!
//! The nodes on a plane are held along its normal, and the surfaces that touch are continued there by their mirror images. Forces,
//! energies and contacts of the whole are those of the sector and of its images.

mod cut;
mod history;
mod images;
mod symmetry;

use super::compile::compile_whole;
use super::compiled::Plan;
use super::contact_plan::ContactPlan;
use super::parts::CompileError;
use super::report::Omitted;
use crate::mechanics::contact::Discretisation;
use crate::mechanics::lanes::Row;
use crate::mechanics::material::Law;
use crate::mechanics::tensor::Vec3;
use crate::mesh::mirror::MirrorPlane;
use crate::scene::Scene;
use crate::scene::document::Keep;
use cut::{Cut, sector_of};
use history::{PointHistory, histories};
pub use images::Images;
use symmetry::Symmetry;

/// What is computed of a symmetric scene, and how the rest follows from it.
#[derive(Debug)]
pub struct Sector {
    /// Plan of the sector.
    pub plan: Plan,
    /// Its images in the planes of symmetry, on the upper side of each of which it is.
    pub images: Images,
    /// For each node of the whole, the node of the sector that it mirrors, and the image that it belongs to.
    pub source: Vec<(u32, u8)>,
    /// For each node of the sector, its node of the whole in each image.
    nodes: Vec<Vec<u32>>,
    /// For each element of the sector, its element of the whole in each image.
    elements: Vec<Vec<u32>>,
    /// Where the history of the whole follows from; empty if nothing is remembered.
    history: Vec<PointHistory>,
}

impl Sector {
    /// The sector of a scene with this plan; `None` without symmetry.
    ///
    /// # Errors
    /// As [`super::compile`].
    fn of(scene: &Scene, whole: &Plan) -> Result<Option<Self>, CompileError> {
        if scene.document.keeps(Keep::MirrorImages) || !has_images(whole) {
            return Ok(None);
        }
        let Some(symmetry) = Symmetry::of(scene) else { return Ok(None) };
        let (sector, cuts) = sector_of(scene, &symmetry);
        let plan = compile_whole(&sector)?;
        Ok(Self::new(whole, plan, symmetry.planes, &cuts))
    }

    /// `None` if the plan of the sector has other pairs than that of the whole.
    fn new(whole: &Plan, plan: Plan, planes: Vec<MirrorPlane>, cuts: &[Cut]) -> Option<Self> {
        let pairs = |plan: &Plan| plan.contact.as_ref().map(|contact| contact.pairs.clone());
        if pairs(whole) != pairs(&plan) {
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
        let history = if remembers { histories(whole, &plan, &elements, &images)? } else { Vec::new() };
        is_complete.then_some(Self { plan, images, source, nodes, elements, history })
    }

    /// Node of the whole that is a node of the sector in an image.
    pub fn image_of_node(&self, node: u32, image: usize) -> u32 {
        self.nodes[node as usize][image]
    }

    /// Element of the whole that is an element of the sector.
    pub fn element_of_whole(&self, element: u32) -> u32 {
        self.elements[element as usize][0]
    }

    /// The history of the whole, chunk by chunk, from that of the sector.
    pub fn unfold_history(&self, of_sector: &[Vec<Row>], whole: &mut [Vec<Row>]) {
        for point in &self.history {
            let signs = self.images.reflected(Vec3::repeat(1.0), usize::from(point.image));
            point.copy(&signs, of_sector, whole);
        }
    }

    /// The report on what is not computed.
    fn report(&self) -> Omitted {
        let names =
            self.images.0.iter().map(|plane| format!("{} = {}", ["x", "y", "z"][plane.axis], plane.at));
        let part = ["half", "quarter", "eighth"][self.images.0.len() - 1];
        Omitted {
            what: "mirror images".into(),
            why: format!(
                "the scene is symmetric about {}: a {part} of it is computed, {} elements",
                names.collect::<Vec<_>>().join(" and "),
                self.plan.element_count()
            ),
            switch: Some(Keep::MirrorImages),
        }
    }
}

/// Whether mirror images of all that a run computes can be derived: not of eroded elements, of internal variables of laws, and of averages over
/// faces.
fn has_images(plan: &Plan) -> bool {
    let is_averaged = |contact: &ContactPlan| contact.discretisation == Discretisation::Mortar;
    let has_variables = plan.blocks.iter().any(|block| block.parameters.material.history_len() > 0);
    !plan.erodes() && !has_variables && !plan.contact.as_ref().is_some_and(is_averaged)
}

/// The plan of a whole scene with that of its sector, if it is symmetric.
///
/// # Errors
/// As [`super::compile`].
pub(super) fn with_sector(mut plan: Plan, scene: &Scene) -> Result<Plan, CompileError> {
    if let Some(sector) = Sector::of(scene, &plan)? {
        let (report, of_sector) = (&mut plan.report, &sector.plan.report);
        report.omitted.insert(0, sector.report());
        report.expected_steps = of_sector.expected_steps;
        report.expected_run_time_s = of_sector.expected_run_time_s;
        report.memory_bytes += of_sector.memory_bytes;
        plan.sector = Some(Box::new(sector));
    }
    Ok(plan)
}
