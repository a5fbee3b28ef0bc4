//! A cylinder, such as a baton: an O-grid disc extruded along its axis.

use super::cubed_sphere::equiangular;
use super::o_grid::{core_fraction, core_point, ring_point};
use super::parameters::{Checks, refuse};
use super::{faceting_note, node_set};
use crate::mechanics::tensor::Vec3;
use crate::mesh::{Mesh, MeshError, ParameterProblem};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::f64::consts::PI;

/// Name of the only part.
const BATON: &str = "baton";

/// A solid cylinder of one part `baton`, node sets `side`, `bottom` (start of the axis), `top` (end of the axis) and `ends` (both).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Cylinder {
    /// Centre, half way along the axis [m].
    #[serde(default)]
    pub center_m: [f64; 3],
    /// Direction of the axis, from `bottom` to `top`; any length.
    pub axis: [f64; 3],
    /// Radius of the baton [m].
    pub radius_m: f64,
    /// Length along the axis [m].
    pub length_m: f64,
    /// Elements along a quarter of the circumference, n: n² in the core of a slice.
    pub elements_around: u32,
    /// Rings between the core and the side, of 4 n elements each.
    pub elements_through: u32,
    /// Elements along the axis.
    pub elements_along: u32,
}

impl Cylinder {
    /// All parameters out of range.
    pub fn problems(&self) -> Vec<ParameterProblem> {
        let mut checks = Checks::default();
        checks.finite("center_m", &self.center_m);
        checks.finite("axis", &self.axis);
        let length = Vec3::from(self.axis).norm();
        checks.require(length > 0.0, "axis", length, "longer than 0", "give the axis a direction");
        checks.positive_length("radius_m", self.radius_m);
        checks.positive_length("length_m", self.length_m);
        checks.count("elements_around", self.elements_around, 1);
        checks.count("elements_through", self.elements_through, 1);
        checks.count("elements_along", self.elements_along, 1);
        checks.budget(self.element_count());
        checks.into_problems()
    }

    /// Number of elements, n² + 4 n m per slice.
    pub fn element_count(&self) -> u64 {
        let (n, m) = (u64::from(self.elements_around), u64::from(self.elements_through));
        let slice = n.saturating_mul(n.saturating_add(m.saturating_mul(4)));
        slice.saturating_mul(u64::from(self.elements_along))
    }

    /// For each count, whether even numbers keep elements from extending across the middle of the body.
    pub fn counts_across(&self) -> Vec<bool> {
        vec![true, false, true]
    }

    /// All element counts, for modification.
    pub fn counts_mut(&mut self) -> Vec<&mut u32> {
        vec![&mut self.elements_around, &mut self.elements_through, &mut self.elements_along]
    }

    /// Generates the mesh, slice by slice along the axis.
    ///
    /// # Errors
    /// `Parameters` with all problems of [`Self::problems`].
    pub fn generate(&self) -> Result<Mesh, MeshError> {
        refuse("cylinder", self.problems())?;
        let disc = Disc::new(self.elements_around, self.elements_through);
        let ([e1, e2, e3], center) = (frame(&Vec3::from(self.axis)), Vec3::from(self.center_m));
        let mut mesh = Mesh { parts: vec![BATON.into()], ..Mesh::default() };
        for slice in 0..=self.elements_along {
            let along = self.length_m * (f64::from(slice) / f64::from(self.elements_along) - 0.5);
            mesh.nodes.extend(
                disc.points.iter().map(|p| center + (e1 * p.x + e2 * p.y) * self.radius_m + e3 * along),
            );
        }
        let a_slice = disc.points.len() as u32;
        for slice in 0..self.elements_along {
            mesh.cells.extend(disc.quads.iter().map(|quad| {
                let [a, b, c, d] = quad.map(|p| slice * a_slice + p);
                [a, b, c, d, a + a_slice, b + a_slice, c + a_slice, d + a_slice]
            }));
        }
        mesh.part_of = vec![0; mesh.cells.len()];

        let (bottom, top) = (0..a_slice, self.elements_along * a_slice..(self.elements_along + 1) * a_slice);
        let side = (0..=self.elements_along).flat_map(|s| disc.rim.clone().map(move |p| s * a_slice + p));
        mesh.node_sets.insert("side".into(), node_set(side));
        mesh.node_sets.insert("ends".into(), node_set(bottom.clone().chain(top.clone())));
        mesh.node_sets.insert("bottom".into(), node_set(bottom));
        mesh.node_sets.insert("top".into(), node_set(top));
        mesh.notes.push(faceting_note(BATON, mesh.volume_m3(), self.exact_volume_m3()));
        Ok(mesh)
    }

    /// Exact volume of the cylinder [m³], π R² L.
    pub fn exact_volume_m3(&self) -> f64 {
        PI * self.radius_m * self.radius_m * self.length_m
    }
}

/// A disc of unit radius in the plane z = 0.
struct Disc {
    points: Vec<Vec3>,
    /// Indices into `points`, counter-clockwise seen from +z.
    quads: Vec<[u32; 4]>,
    /// Indices of the points on the rim.
    rim: std::ops::Range<u32>,
}

impl Disc {
    /// A core of n × n quadrilaterals, then `rings` rings of 4 n, from the inside.
    fn new(n: u32, rings: u32) -> Self {
        let core_size = core_fraction(n, rings);
        let square = |i: u32, j: u32| {
            let u = equiangular([i, j, 0], n);
            Vec3::new(u.x, u.y, 0.0)
        };
        let core_point_at = |i: u32, j: u32| i + (n + 1) * j;
        let mut points: Vec<Vec3> = (0..=n)
            .flat_map(|j| (0..=n).map(move |i| (i, j)))
            .map(|(i, j)| core_point(&square(i, j)) * core_size)
            .collect();
        let mut quads: Vec<[u32; 4]> = (0..n)
            .flat_map(|j| (0..n).map(move |i| (i, j)))
            .map(|(i, j)| [(i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1)].map(|(i, j)| core_point_at(i, j)))
            .collect();

        // The boundary of the square, counter-clockwise from its lower left corner.
        let boundary: Vec<(u32, u32)> = (0..n)
            .map(|i| (i, 0))
            .chain((0..n).map(|j| (n, j)))
            .chain((0..n).map(|i| (n - i, n)))
            .chain((0..n).map(|j| (0, n - j)))
            .collect();
        let (core_points, around) = (points.len() as u32, boundary.len() as u32);
        for ring in 1..=rings {
            let fraction = f64::from(ring) / f64::from(rings);
            points.extend(boundary.iter().map(|&(i, j)| ring_point(&square(i, j), core_size, fraction)));
        }
        let node = |ring: u32, step: u32| match ring {
            0 => {
                let (i, j) = boundary[(step % around) as usize];
                core_point_at(i, j)
            }
            ring => core_points + (ring - 1) * around + step % around,
        };
        for ring in 0..rings {
            quads.extend((0..around).map(|step| {
                [node(ring, step), node(ring + 1, step), node(ring + 1, step + 1), node(ring, step + 1)]
            }));
        }
        let rim = core_points + (rings - 1) * around..core_points + rings * around;
        Self { points, quads, rim }
    }
}

/// A right-handed frame with its third vector along `axis`; the first two are close to coordinate axes.
fn frame(axis: &Vec3) -> [Vec3; 3] {
    let e3 = axis.normalize();
    // The coordinate axis most perpendicular to e3 gives e2; for an axis along z, the frame is x, y, z.
    let helper = if e3.y.abs() < 0.9 { Vec3::y() } else { Vec3::z() };
    let e1 = helper.cross(&e3).normalize();
    [e1, e3.cross(&e1), e3]
}
