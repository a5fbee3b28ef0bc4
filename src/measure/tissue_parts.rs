//! The tissue of a plan, part by part.

use super::computed::Computed;
use super::depth_ridge::{Ridge, middle_of};
use super::stress_field::{MOST_ENDS, StressField, TissueElement};
use crate::mechanics::tensor::Vec3;
use crate::mesh::MeshError;
use crate::mesh::distance::DepthField;
use crate::plan::Plan;
use crate::scene::document::Role;
use rayon::prelude::*;

/// Parts of the tissue; parts of the same name in several bodies are one.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TissueParts {
    /// Indices of the bodies that are tissue.
    pub bodies: Vec<usize>,
    /// Names of the parts.
    pub names: Vec<String>,
    /// Reference volume of each part [m³].
    pub volumes: Vec<f64>,
    /// For each slot of all images the index of its part; 0 in other bodies, where it is unused.
    pub of_slot: Vec<u32>,
}

impl TissueParts {
    /// The parts of the tissue of what is computed, and of its images.
    pub fn new(computed: &Computed) -> Self {
        let plan = computed.plan;
        let is_tissue = |body: &usize| plan.bodies[*body].role == Role::Tissue;
        let bodies = (0..plan.bodies.len()).filter(is_tissue).collect();
        let mut parts = Self { bodies, of_slot: vec![0; computed.slot_count()], ..Self::default() };
        for block in plan.blocks.iter().filter(|block| is_tissue(&block.body)) {
            let body = &plan.bodies[block.body];
            for (slot, element) in block.elements.iter().enumerate() {
                let name = &body.parts[body.part_of[(element - body.elements.start) as usize] as usize];
                let part = parts.index_of(name);
                let volume = block.point_volumes(slot).iter().sum::<f64>();
                parts.volumes[part] += computed.images() as f64 * volume;
                for image in 0..computed.images() {
                    parts.of_slot[computed.slot(block.first_slot + slot, image)] = part as u32;
                }
            }
        }
        parts
    }

    /// Index of the part of a name, which is added if it is new.
    fn index_of(&mut self, name: &str) -> usize {
        self.names.iter().position(|known| known == name).unwrap_or_else(|| {
            self.names.push(name.to_owned());
            self.volumes.push(0.0);
            self.names.len() - 1
        })
    }

    /// The stress field over the depth below the surface of a whole plan; `None` without one.
    ///
    /// # Errors
    /// If no distance can be taken to the surface.
    pub fn stress_field(&self, whole: &Plan) -> Result<Option<StressField>, MeshError> {
        if whole.measures.tissue_skin.is_empty() {
            return Ok(None);
        }
        let skin = DepthField::new(&whole.measures.tissue_skin, &whole.X)?;
        // Images are as deep as what is computed.
        let computed = Computed::of(whole);
        let X = &computed.plan.X;
        let mut of_computed = vec![f64::NAN; X.len()];
        for body in &self.bodies {
            let nodes = computed.plan.bodies[*body].nodes.clone();
            let nodes = nodes.start as usize..nodes.end as usize;
            of_computed[nodes.clone()].copy_from_slice(&skin.depths(&X[nodes]));
        }
        let mut depths = vec![f64::NAN; whole.X.len()];
        computed.unfold(&of_computed, &mut depths);
        // Depths in the middle of elements show where these are not linear.
        let elements: Vec<TissueElement> = self.elements(computed, 0).collect();
        let at = |node: &u32| whole.X[*node as usize];
        let corners = |element: &TissueElement| element.cell.table().corners;
        let middle = |element: &TissueElement| middle_of(element.nodes[..corners(element)].iter().map(at));
        let middles = skin.depths(&elements.iter().map(middle).collect::<Vec<_>>());
        let ridges = elements.par_iter().zip(middles).map(|(element, middle)| {
            let x: Vec<Vec3> = element.nodes.iter().map(at).collect();
            let of_corners = element.nodes[..corners(element)].iter().map(|node| depths[*node as usize]);
            let of_corners: Vec<f64> = of_corners.collect();
            Ridge::of(element.cell, &x, (&of_corners, middle), |point| skin.depth(point))
        });
        let ridges: Vec<Option<Ridge>> = ridges.collect();
        let elements = (0..computed.images()).flat_map(|image| {
            let of_image = self.elements(computed, image).zip(&ridges);
            of_image.map(|(element, ridge)| TissueElement { ridge: ridge.clone(), ..element })
        });
        let counts = (self.names.len(), computed.slot_count());
        Ok(Some(StressField::new((&depths, &ends_of_nodes(whole)), counts, elements)))
    }

    /// The elements of the tissue in an image, with their nodes of the whole.
    fn elements<'a>(
        &'a self,
        computed: Computed<'a>,
        image: usize,
    ) -> impl Iterator<Item = TissueElement> + 'a {
        let blocks = computed.plan.blocks.iter().filter(|block| self.bodies.contains(&block.body));
        blocks.flat_map(move |block| {
            let body = &computed.plan.bodies[block.body];
            block.elements.iter().enumerate().map(move |(in_block, element)| {
                let cell = body.cells.get((element - body.elements.start) as usize);
                let slot = computed.slot(block.first_slot + in_block, image);
                TissueElement {
                    slot,
                    part: self.of_slot[slot] as usize,
                    cell: cell.kind,
                    nodes: cell.nodes.iter().map(|node| computed.node(*node, image)).collect(),
                    volumes: block.point_volumes(in_block),
                    ridge: None,
                }
            })
        })
    }
}

/// For each node of a plan the bit set of the ends of the tissue that it belongs to.
pub fn ends_of_nodes(plan: &Plan) -> Vec<u32> {
    let mut of_node = vec![0; plan.node_count()];
    for (bit, end) in plan.measures.tissue_ends.iter().enumerate().take(MOST_ENDS) {
        end.nodes.iter().for_each(|node| of_node[*node as usize] |= 1 << bit);
    }
    of_node
}
