//! A solid ball: a core of cubes blended into a cubed sphere.

use super::cubed_sphere::{CubeSurface, equiangular};
use super::grading::{Grading, graded};
use super::o_grid::{core_fraction, core_point, ring_point};
use super::parameters::{Checks, refuse};
use super::{BALL, faceting_note, node_set};
use crate::mechanics::tensor::Vec3;
use crate::mesh::defaults::{is_false, is_one, one};
use crate::mesh::{CellKind, Mesh, MeshError, ParameterProblem};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::f64::consts::{FRAC_PI_4, PI};

/// Nodes closer to a symmetry plane than this fraction of the radius are on it [-].
const ON_PLANE: f64 = 1e-9;

/// A ball of one part `ball`, node set `outer`; a quarter also has `x_min` and `y_min` on its symmetry planes.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SolidBall {
    /// Centre of the ball [m].
    #[serde(default)]
    pub center_m: [f64; 3],
    /// Radius of the ball [m].
    pub radius_m: f64,
    /// Elements along a quarter of a great circle, n: n³ in the core, 6 n² per layer.
    pub elements_around: u32,
    /// Layers between the core and the surface.
    pub elements_through: u32,
    /// Size ratio of the largest to the smallest element along x and y; the smallest are at the poles ±z.
    #[serde(default = "one", skip_serializing_if = "is_one")]
    pub grading: f64,
    /// Only the quarter with x ≥ 0 and y ≥ 0 from the centre, for symmetric scenes.
    #[serde(default, rename = "quarter", skip_serializing_if = "is_false")]
    pub is_quarter: bool,
}

impl SolidBall {
    /// All parameters out of range.
    pub fn problems(&self) -> Vec<ParameterProblem> {
        let mut checks = Checks::default();
        checks.finite("center_m", &self.center_m);
        checks.positive_length("radius_m", self.radius_m);
        checks.count("elements_around", self.elements_around, 1);
        checks.count("elements_through", self.elements_through, 1);
        checks.grading("grading", self.grading);
        checks.require(
            !self.is_quarter || self.elements_around.is_multiple_of(2),
            "elements_around",
            f64::from(self.elements_around),
            "even, for a quarter",
            "give an even number: the planes of symmetry pass between elements",
        );
        checks.budget(self.element_count());
        checks.into_problems()
    }

    /// Number of elements, n³ + 6 n² per layer for a whole ball.
    pub fn element_count(&self) -> u64 {
        let (n, m) = (u64::from(self.elements_around), u64::from(self.elements_through));
        let whole = n.saturating_mul(n).saturating_mul(n.saturating_add(m.saturating_mul(6)));
        if self.is_quarter { whole / 4 } else { whole }
    }

    /// For each count, whether even numbers keep elements from extending across the middle of the body.
    pub fn counts_across(&self) -> Vec<bool> {
        vec![true, false]
    }

    /// All element counts, for modification.
    pub fn counts_mut(&mut self) -> Vec<&mut u32> {
        vec![&mut self.elements_around, &mut self.elements_through]
    }

    /// Generates the mesh: the core first, then the layers from the inside.
    ///
    /// # Errors
    /// `Parameters` with all problems of [`Self::problems`].
    pub fn generate(&self) -> Result<Mesh, MeshError> {
        refuse("solid_ball", self.problems())?;
        let (n, layers) = (self.elements_around, self.elements_through);
        let core_size = core_fraction(n, layers);
        let center = Vec3::from(self.center_m);
        let place = |x: Vec3| center + x * self.radius_m;
        let lattice = self.lattice();
        let mut mesh = Mesh { parts: vec![BALL.into()], ..Mesh::default() };

        // Core: a lattice of (n + 1)³ nodes.
        let core_node = |[i, j, k]: [u32; 3]| i + (n + 1) * (j + (n + 1) * k);
        for k in 0..=n {
            for j in 0..=n {
                mesh.nodes.extend((0..=n).map(|i| place(core_point(&lattice([i, j, k])) * core_size)));
            }
        }
        for (k, j, i) in (0..n).flat_map(|k| (0..n).flat_map(move |j| (0..n).map(move |i| (k, j, i)))) {
            let square = |k| [[i, j, k], [i + 1, j, k], [i + 1, j + 1, k], [i, j + 1, k]].map(core_node);
            let ([a, b, c, d], [e, f, g, h]) = (square(k), square(k + 1));
            mesh.cells.push(CellKind::Hex8, &[a, b, c, d, e, f, g, h]);
        }

        // Layers: on the surface of the core, then outwards.
        let surface = CubeSurface::new(n);
        let core_nodes = mesh.nodes.len() as u32;
        let a_layer = surface.points.len() as u32;
        for layer in 1..=layers {
            let fraction = f64::from(layer) / f64::from(layers);
            let ring = |&p: &[u32; 3]| place(ring_point(&lattice(p), core_size, fraction));
            mesh.nodes.extend(surface.points.iter().map(ring));
        }
        let node = |layer: u32, point: u32| match layer {
            0 => core_node(surface.points[point as usize]),
            layer => core_nodes + (layer - 1) * a_layer + point,
        };
        for layer in 0..layers {
            mesh.cells.extend(surface.quads.iter().map(|quad| {
                let [a, b, c, d] = quad.map(|p| node(layer, p));
                let [e, f, g, h] = quad.map(|p| node(layer + 1, p));
                [a, b, c, d, e, f, g, h]
            }));
        }
        mesh.part_of = vec![0; mesh.cells.len()];
        mesh.node_sets.insert("outer".into(), node_set((0..a_layer).map(|p| node(layers, p))));
        let mut exact = self.exact_volume_m3();
        if self.is_quarter {
            self.cut(&mut mesh);
            exact /= 4.0;
        }
        mesh.notes.push(faceting_note(BALL, mesh.volume_m3(), exact));
        Ok(mesh)
    }

    /// Map from the lattice of the cube to [−1, 1]³.
    fn lattice(&self) -> impl Fn([u32; 3]) -> Vec3 + use<> {
        let (n, grading) = (self.elements_around, self.grading);
        let spread = |s: f64| if s.abs() >= 1.0 { s.signum() } else { (FRAC_PI_4 * s).tan() };
        let line: Vec<f64> =
            graded(-1.0, 1.0, 0.0, Grading::from_point(grading), n).into_iter().map(spread).collect();
        move |point| {
            let even = equiangular(point, n);
            if grading > 1.0 {
                Vec3::new(line[point[0] as usize], line[point[1] as usize], even.z)
            } else {
                even
            }
        }
    }

    /// Keeps the quarter at x ≥ 0 and y ≥ 0.
    fn cut(&self, mesh: &mut Mesh) {
        let center = Vec3::from(self.center_m);
        let is_kept = |mesh: &Mesh, element: usize| {
            let middle = mesh.cells.points(element, &mesh.nodes).iter().sum::<Vec3>() / 8.0 - center;
            middle.x > 0.0 && middle.y > 0.0
        };
        let kept = (0..mesh.cells.len()).filter(|element| is_kept(mesh, *element));
        mesh.cells = kept.map(|element| mesh.cells.get(element)).collect();
        mesh.part_of.truncate(mesh.cells.len());
        mesh.drop_unused_nodes();
        for (axis, name) in ["x_min", "y_min"].into_iter().enumerate() {
            // tan 0 is 0; a small remainder from the grading is rounding.
            let on_plane =
                |node: &u32| (mesh.nodes[*node as usize] - center)[axis].abs() < ON_PLANE * self.radius_m;
            let nodes = node_set((0..mesh.nodes.len() as u32).filter(on_plane));
            for node in &nodes {
                mesh.nodes[*node as usize][axis] = center[axis];
            }
            mesh.node_sets.insert(name.into(), nodes);
        }
    }

    /// Exact volume of the ball [m³], 4/3 π R³.
    pub fn exact_volume_m3(&self) -> f64 {
        4.0 / 3.0 * PI * self.radius_m.powi(3)
    }
}
