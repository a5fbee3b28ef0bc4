//! A solid ball: a core of cubes blended into a cubed sphere.

use super::cubed_sphere::{CubeSurface, equiangular};
use super::o_grid::{core_fraction, core_point, ring_point};
use super::parameters::{Checks, refuse};
use super::{faceting_note, node_set};
use crate::mechanics::tensor::Vec3;
use crate::mesh::{Mesh, MeshError, ParameterProblem};
use std::f64::consts::PI;

/// A ball of one part, node set `outer`.
#[derive(Clone, Debug, PartialEq)]
pub struct SolidBall {
    /// Centre [m].
    pub center: Vec3,
    /// Radius [m].
    pub radius_m: f64,
    /// Elements along a quarter of a great circle, which are also those across the core: n³ in the core.
    pub elements_around: u32,
    /// Layers of elements between the core and the surface: 6 n² elements each.
    pub elements_through: u32,
    /// Name of the part.
    pub part: String,
}

impl SolidBall {
    /// Every number out of range.
    pub fn problems(&self) -> Vec<ParameterProblem> {
        let mut checks = Checks::default();
        checks.finite("center", &self.center);
        checks.positive_length("radius_m", self.radius_m);
        checks.count("elements_around", self.elements_around, 1);
        checks.count("elements_through", self.elements_through, 1);
        checks.budget(self.element_count());
        checks.into_problems()
    }

    /// Number of elements of the mesh, n³ + 6 n² a layer.
    pub fn element_count(&self) -> u64 {
        let (n, m) = (u64::from(self.elements_around), u64::from(self.elements_through));
        n.saturating_mul(n).saturating_mul(n.saturating_add(m.saturating_mul(6)))
    }

    /// The same ball with all element counts multiplied by `factor`.
    #[must_use]
    pub fn refined(&self, factor: u32) -> Self {
        Self {
            elements_around: self.elements_around.saturating_mul(factor),
            elements_through: self.elements_through.saturating_mul(factor),
            ..self.clone()
        }
    }

    /// The mesh: core first, then the layers from the inside.
    ///
    /// # Errors
    /// `Parameters` with all that [`Self::problems`] finds.
    pub fn generate(&self) -> Result<Mesh, MeshError> {
        refuse("solid_ball", self.problems())?;
        let (n, layers) = (self.elements_around, self.elements_through);
        let core_size = core_fraction(n, layers);
        let place = |x: Vec3| self.center + x * self.radius_m;
        let mut mesh = Mesh { parts: vec![self.part.clone()], ..Mesh::default() };

        // Core: a lattice of (n + 1)³ nodes.
        let core_node = |[i, j, k]: [u32; 3]| i + (n + 1) * (j + (n + 1) * k);
        for k in 0..=n {
            for j in 0..=n {
                mesh.nodes.extend((0..=n).map(|i| place(core_point(&equiangular([i, j, k], n)) * core_size)));
            }
        }
        for (k, j, i) in (0..n).flat_map(|k| (0..n).flat_map(move |j| (0..n).map(move |i| (k, j, i)))) {
            let square = |k| [[i, j, k], [i + 1, j, k], [i + 1, j + 1, k], [i, j + 1, k]].map(core_node);
            let ([a, b, c, d], [e, f, g, h]) = (square(k), square(k + 1));
            mesh.hexes.push([a, b, c, d, e, f, g, h]);
        }

        // Layers: on the surface of the core, then outwards.
        let surface = CubeSurface::new(n);
        let core_nodes = mesh.nodes.len() as u32;
        let a_layer = surface.points.len() as u32;
        for layer in 1..=layers {
            let fraction = f64::from(layer) / f64::from(layers);
            let ring = |&p: &[u32; 3]| place(ring_point(&equiangular(p, n), core_size, fraction));
            mesh.nodes.extend(surface.points.iter().map(ring));
        }
        let node = |layer: u32, point: u32| match layer {
            0 => core_node(surface.points[point as usize]),
            layer => core_nodes + (layer - 1) * a_layer + point,
        };
        for layer in 0..layers {
            mesh.hexes.extend(surface.quads.iter().map(|quad| {
                let [a, b, c, d] = quad.map(|p| node(layer, p));
                let [e, f, g, h] = quad.map(|p| node(layer + 1, p));
                [a, b, c, d, e, f, g, h]
            }));
        }
        mesh.part_of = vec![0; mesh.hexes.len()];
        mesh.node_sets.insert("outer".into(), node_set((0..a_layer).map(|p| node(layers, p))));
        mesh.notes.push(faceting_note(&self.part, mesh.volume_m3(), self.exact_volume_m3()));
        Ok(mesh)
    }

    /// Volume of the true ball [m³], 4/3 π R³.
    pub fn exact_volume_m3(&self) -> f64 {
        4.0 / 3.0 * PI * self.radius_m.powi(3)
    }
}
