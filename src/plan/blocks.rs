//! The elements of a body: reference geometry, and blocks of one law, one formulation and one kind each.

use super::contact_mass::ContactMass;
use super::parts::CompileError;
use crate::mechanics::element::{ElementKind, OfElement, ReferenceGeometry};
use crate::mechanics::force::{BlockInput, BlockParameters, ElementBlock};
use crate::mechanics::tensor::Mat3;
use crate::mesh::Cell;
use crate::scene::SceneBody;
use crate::scene::document::{BodyDocument, ErosionDocument, Formulation, SceneDocument};

/// Reference geometry of each element of a mesh.
///
/// # Errors
/// Inverted elements.
pub(super) fn reference_geometry(
    scene: &SceneDocument,
    document: &BodyDocument,
    body: &SceneBody,
) -> Result<Vec<ReferenceGeometry>, CompileError> {
    let mesh = &body.mesh;
    let mass = ContactMass::new(scene.contact.mass_redistribution, body);
    let of_element = |(element, cell): (usize, Cell)| {
        let geometry =
            ReferenceGeometry::with_mass_at(cell.kind.element(), &cell.points(&mesh.nodes), |volume| {
                mass.moved(cell.nodes, volume)
            });
        if geometry.smallest_jacobian > 0.0 {
            return Ok(geometry);
        }
        let ratio = geometry.smallest_jacobian;
        Err(CompileError::InvertedElement { body: document.name.clone(), element, ratio })
    };
    mesh.cells.iter().enumerate().map(of_element).collect()
}

/// What the blocks of a body need of the model.
pub(super) struct Globals {
    pub first_node: u32,
    pub first_element: u32,
    pub body: usize,
    pub viscosity: [f64; 2],
    pub keeps_idle_fibres: bool,
}

/// Adds one block for every law of the body and kind of element that occurs with it; `geometry` is that of the elements in mesh order.
pub(super) fn add_blocks(
    blocks: &mut Vec<ElementBlock>,
    globals: &Globals,
    document: &BodyDocument,
    body: &SceneBody,
    geometry: Vec<ReferenceGeometry>,
) -> Result<(), CompileError> {
    let mut inputs: Vec<Vec<BlockInput>> = vec![Vec::new(); body.materials.len() * ElementKind::ALL.len()];
    // The part of each law: the laws of elements of another stiffness come after those of the parts.
    let mut entry_of: Vec<usize> = (0..body.materials.len()).collect();
    for (e, (cell, geometry)) in body.mesh.cells.iter().zip(geometry).enumerate() {
        let law = body.law_of[e] as usize;
        entry_of[law] = body.part_entry[e] as usize;
        let block = law * ElementKind::ALL.len() + geometry.kind as usize;
        inputs[block].push(BlockInput {
            element: globals.first_element + e as u32,
            nodes: cell.nodes.iter().map(|node| node + globals.first_node).collect(),
            corners: OfElement::from_slice(&cell.points(&body.mesh.nodes)),
            axes: body.axes.get(e).copied().unwrap_or_else(Mat3::identity),
            geometry,
        });
    }
    for (place, inputs) in inputs.iter().enumerate().filter(|(_, inputs)| !inputs.is_empty()) {
        let (law, kind) = (place / ElementKind::ALL.len(), ElementKind::ALL[place % ElementKind::ALL.len()]);
        let (part, material) = (&document.parts[entry_of[law]], &body.materials[law]);
        let parameters = BlockParameters {
            material: if globals.keeps_idle_fibres { *material } else { material.without_idle_fibres() },
            formulation: part.element(material, kind),
            single_precision: part.formulation == Some(Formulation::MeanDilatationSingle),
            density: part.density_kg_per_m3,
            linear_viscosity: globals.viscosity[0],
            quadratic_viscosity: globals.viscosity[1],
            shear_viscosity: part.shear_viscosity_pa_s,
            memory: part.memory(),
            erosion: part.erosion.as_ref().map(ErosionDocument::limits),
        };
        let first_slot = blocks.last().map_or(0, ElementBlock::end_slot);
        blocks.push(ElementBlock::new(globals.body, parameters, first_slot, inputs)?);
    }
    Ok(())
}
