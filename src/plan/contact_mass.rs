//! Redistributed mass: a fraction of the mass of boundary nodes is moved inwards (after Khenous, Laborde & Renard 2008).
//!
//! On impact activation a lumped node stops within one step and loses its kinetic energy: an error of first order in the
//! element size, proportional to the mass of the boundary nodes. Mass moves within each element, so mass and momentum are
//! conserved, the element-wise bound of the critical time step holds with the lighter nodes, and the step falls by at most
//! √(1 − α).
//!
//! The moments of inertia decrease, since mass moves inwards; with positive masses nothing can compensate this, as the
//! boundary is farthest from the centre. The loss is computed for each body and reported as a warning.

use crate::mechanics::element::{OfElement, ReferenceGeometry};
use crate::mechanics::tensor::Vec3;
use crate::mesh::surface::boundary_nodes;
use crate::scene::SceneBody;
use crate::scene::document::{BodyDocument, SceneDocument};

/// Lumping of a body's mass.
pub(super) struct ContactMass {
    alpha: f64,
    is_boundary: Vec<bool>,
}

impl ContactMass {
    /// Lumping that moves the fraction `alpha` [-] of the mass of boundary nodes inwards.
    pub fn new(alpha: f64, body: &SceneBody) -> Self {
        let mut is_boundary = vec![false; body.mesh.nodes.len()];
        if alpha > 0.0 {
            for node in boundary_nodes(&body.boundary()) {
                is_boundary[node as usize] = true;
            }
        }
        Self { alpha, is_boundary }
    }

    /// Moves volume from the corners on the boundary surface to the others, in equal parts; an element without others keeps its own.
    pub fn moved(&self, nodes: &[u32], mut volume: OfElement<f64>) -> OfElement<f64> {
        let on_boundary: Vec<bool> = nodes.iter().map(|node| self.is_boundary[*node as usize]).collect();
        let inner = on_boundary.iter().filter(|on_boundary| !**on_boundary).count();
        if inner == 0 || inner == nodes.len() {
            return volume;
        }
        let boundary_volume: f64 =
            volume.iter().zip(&on_boundary).filter(|(_, on_boundary)| **on_boundary).map(|(v, _)| v).sum();
        let moved = self.alpha * boundary_volume / inner as f64;
        for (volume, on_boundary) in volume.iter_mut().zip(on_boundary) {
            *volume = if on_boundary { *volume * (1.0 - self.alpha) } else { *volume + moved };
        }
        volume
    }
}

/// Mass of every node [kg], from the corner volumes of the elements [m³].
pub(super) fn lumped_mass(
    document: &BodyDocument,
    body: &SceneBody,
    corner_volume: impl Fn(usize) -> OfElement<f64>,
) -> Vec<f64> {
    let mut mass = vec![0.0; body.mesh.nodes.len()];
    for (e, cell) in body.mesh.cells.iter().enumerate() {
        let density = document.parts[body.part_entry[e] as usize].density_kg_per_m3;
        for (node, volume) in cell.nodes.iter().zip(corner_volume(e)) {
            mass[*node as usize] += density * volume;
        }
    }
    mass
}

/// Fraction of the polar moment of inertia about the centre of mass that redistribution removes [-].
pub(super) fn inertia_lost(
    scene: &SceneDocument,
    document: &BodyDocument,
    body: &SceneBody,
    mass: &[f64],
) -> f64 {
    if scene.contact.mass_redistribution == 0.0 {
        return 0.0;
    }
    let polar = |mass: &[f64]| {
        let nodes = || body.mesh.nodes.iter().zip(mass);
        let center = nodes().map(|(X, m)| X * *m).sum::<Vec3>() / mass.iter().sum::<f64>();
        nodes().map(|(X, m)| m * (X - center).norm_squared()).sum::<f64>()
    };
    let even = lumped_mass(document, body, |element| {
        let cell = body.mesh.cells.get(element);
        ReferenceGeometry::new(cell.kind.element(), &cell.points(&body.mesh.nodes)).corner_volume
    });
    1.0 - polar(mass) / polar(&even)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mechanics::element::ElementKind;
    use crate::mesh::generate::block::Block;

    #[test]
    fn mass_stays_and_boundaries_get_lighter() {
        let mesh =
            Block::uniform([0.0; 3].into(), [1.0, 2.0, 3.0].into(), [3, 4, 5], "block").generate().unwrap();
        let body = SceneBody { mesh, ..SceneBody::default() };
        let (mass, mesh) = (ContactMass::new(0.75, &body), &body.mesh);
        let mut lighter = 0;
        for hex in mesh.cells.hexes().unwrap_or_default() {
            let corners = hex.map(|node| mesh.nodes[node as usize]);
            let before = ReferenceGeometry::new(ElementKind::Hex8, &corners);
            let after = ReferenceGeometry::with_mass_at(ElementKind::Hex8, &corners, |volume| {
                mass.moved(hex, volume)
            });
            let total = |g: &ReferenceGeometry| g.corner_volume.iter().sum::<f64>();
            assert!((total(&before) - total(&after)).abs() < 1e-12);
            assert!(after.gradient_bound >= before.gradient_bound * (1.0 - 1e-12));
            assert!(after.gradient_bound <= before.gradient_bound * 4.0 * (1.0 + 1e-12));
            for corner in 0..8 {
                let ratio = after.corner_volume[corner] / before.corner_volume[corner];
                assert!((ratio - 0.25).abs() < 1e-12 || ratio >= 1.0, "{ratio}");
                lighter += u32::from(ratio < 1.0);
            }
        }
        assert!(lighter > 100, "{lighter}");
    }
}
