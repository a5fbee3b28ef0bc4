//! Fields at the nodes and elements, projected from the quadrature points.

use super::computed::Computed;
use crate::mechanics::element::{ElementKind, MOST_NODES, MOST_POINTS};
use crate::mechanics::force::{BATCH, PointBatch, PointScalar};
use crate::mesh::Cells;
use crate::plan::Plan;
use crate::scene::document::FieldName;

/// Nodal and element fields of the whole model at one time. A field that was not requested is empty.
///
/// Nodal values are the lumped L2 projection: averages over the quadrature points of the elements around node a,
/// weighted by reference volume times N_a. They smear jumps across material interfaces; [`Fields::element_cauchy`] does
/// not.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Fields {
    /// Von Mises stress at the nodes [Pa].
    pub von_mises: Vec<f64>,
    /// Pressure at the nodes, positive in compression [Pa].
    pub pressure: Vec<f64>,
    /// Largest principal Green–Lagrange strain at the nodes [-].
    pub principal_strain: Vec<f64>,
    /// Volume-weighted mean Cauchy stress of each element, xx, yy, zz, xy, yz, xz [Pa].
    pub element_cauchy: Vec<[f64; 6]>,
    /// Sums at the nodes and elements that are computed, of which those of the whole are unfolded.
    sums: Sums,
    /// Volume around each node, and of each element [m³]; empty if no such field is requested.
    nodal_volume: Vec<f64>,
    element_volume: Vec<f64>,
    /// The elements that are computed, by their nodes.
    cells: Cells,
}

/// Sums over quadrature points, weighted by volume, at the nodes and elements that are computed, as the fields of the same name.
#[derive(Clone, Debug, Default, PartialEq)]
struct Sums {
    von_mises: Vec<f64>,
    pressure: Vec<f64>,
    principal_strain: Vec<f64>,
    element_cauchy: Vec<[f64; 6]>,
}

impl Fields {
    /// Allocates the stress and strain fields that the plan of a whole scene requests; `None` if it requests none.
    pub fn new(whole: &Plan) -> Option<Self> {
        // Requested fields only.
        let plan = Computed::of(whole).plan;
        let requested = |field| whole.fields.contains(&field);
        let room = |field, n: usize| vec![0.0; if requested(field) { n } else { 0 }];
        let has_cauchy = requested(FieldName::ElementCauchyStress);
        let tensors = |n: usize| vec![[0.0; 6]; if has_cauchy { n } else { 0 }];
        let (all, own) = (whole.node_count(), plan.node_count());
        let sums = Sums {
            von_mises: room(FieldName::VonMises, own),
            pressure: room(FieldName::Pressure, own),
            principal_strain: room(FieldName::PrincipalStrain, own),
            element_cauchy: tensors(plan.element_count()),
        };
        if !sums.is_nodal() && !has_cauchy {
            return None;
        }
        let mut fields = Self {
            von_mises: room(FieldName::VonMises, all),
            pressure: room(FieldName::Pressure, all),
            principal_strain: room(FieldName::PrincipalStrain, all),
            element_cauchy: tensors(whole.element_count()),
            nodal_volume: vec![0.0; if sums.is_nodal() { own } else { 0 }],
            element_volume: vec![0.0; sums.element_cauchy.len()],
            sums,
            cells: plan.bodies.iter().flat_map(|b| b.cells.iter()).collect(),
        };
        // Reference volumes are the weights of the averages.
        for block in &plan.blocks {
            for (slot, element) in block.elements.iter().enumerate() {
                fields.add_volume(*element, &block.point_volumes(slot));
            }
        }
        Some(fields)
    }

    /// Adds the volume of an element (global number) to those around its nodes.
    fn add_volume(&mut self, element: u32, volume: &[f64; MOST_POINTS]) {
        if let Some(sum) = self.element_volume.get_mut(element as usize) {
            *sum = volume.iter().sum();
        }
        if self.nodal_volume.is_empty() {
            return;
        }
        let kind = self.cells.kind(element as usize).element();
        for (q, volume) in volume.iter().enumerate().take(kind.point_count()) {
            for (&node, N) in self.cells.nodes(element as usize).iter().zip(kind.shapes_at(q)) {
                self.nodal_volume[node as usize] += N * volume;
            }
        }
    }

    /// Resets to zero, the value of elements that have not moved.
    pub fn clear(&mut self) {
        for field in self.sums.nodal() {
            field.fill(0.0);
        }
        self.sums.element_cauchy.fill([0.0; 6]);
    }

    /// Accumulates the quadrature points of a batch of elements that are computed (their numbers, in the order of its lanes).
    pub fn accumulate(&mut self, elements: &[u32], points: &PointBatch) {
        if !self.sums.element_cauchy.is_empty() {
            for (lane, &element) in elements.iter().enumerate() {
                let mean = &mut self.sums.element_cauchy[element as usize];
                for (cauchy, volume) in points.cauchy.iter().zip(&points.volume) {
                    mean.iter_mut().zip(cauchy).for_each(|(m, s)| *m += volume[lane] * s[lane]);
                }
            }
        }
        let cells = &self.cells;
        // A batch is of one kind.
        let Some(first) = elements.first() else { return };
        let kind = cells.kind(*first as usize).element();
        let values = [&points.von_mises, &points.pressure, &points.principal_strain];
        for (field, values) in self.sums.nodal().into_iter().zip(values) {
            if field.is_empty() {
                continue;
            }
            let corners = corner_sums(kind, &points.volume, values);
            for (lane, &element) in elements.iter().enumerate() {
                for (&node, sums) in cells.nodes(element as usize).iter().zip(&corners) {
                    field[node as usize] += sums[lane];
                }
            }
        }
    }

    /// Ends a pass: the averages of all images.
    pub fn end(&mut self, computed: &Computed) {
        self.divide_sums();
        self.unfold(computed);
    }

    /// Divides the sums by their volumes.
    fn divide_sums(&mut self) {
        let Self { sums, nodal_volume, element_volume, .. } = self;
        for sum in sums.nodal() {
            divide(sum, nodal_volume);
        }
        for (mean, &volume) in sums.element_cauchy.iter_mut().zip(&*element_volume) {
            if volume > 0.0 {
                *mean = mean.map(|m| m / volume);
            }
        }
    }

    /// Fills the fields of the whole: invariants are alike in all images, shears change their signs.
    fn unfold(&mut self, computed: &Computed) {
        let sums = &self.sums;
        computed.unfold(&sums.von_mises, &mut self.von_mises);
        computed.unfold(&sums.pressure, &mut self.pressure);
        computed.unfold(&sums.principal_strain, &mut self.principal_strain);
        for image in 0..computed.images() {
            let signs = computed.signs(image);
            let shears = [signs.x * signs.y, signs.y * signs.z, signs.x * signs.z];
            for (element, &[xx, yy, zz, xy, yz, xz]) in (0..).zip(&sums.element_cauchy) {
                // The sum makes +0 of −0.
                let [xy, yz, xz] = [xy * shears[0], yz * shears[1], xz * shears[2]].map(|shear| shear + 0.0);
                self.element_cauchy[computed.element(element, image) as usize] = [xx, yy, zz, xy, yz, xz];
            }
        }
    }
}

impl Sums {
    /// The nodal sums; empty those that are not requested.
    fn nodal(&mut self) -> [&mut Vec<f64>; 3] {
        [&mut self.von_mises, &mut self.pressure, &mut self.principal_strain]
    }

    /// Whether any nodal field is requested.
    fn is_nodal(&self) -> bool {
        !(self.von_mises.is_empty() && self.pressure.is_empty() && self.principal_strain.is_empty())
    }
}

/// Σ_q N_a V_q value_q of each node of elements of one kind: `[node][lane]`.
fn corner_sums(kind: ElementKind, volume: &PointScalar, values: &PointScalar) -> [[f64; BATCH]; MOST_NODES] {
    let mut sums = [[0.0; BATCH]; MOST_NODES];
    for (q, (volume, values)) in volume.iter().zip(values).enumerate().take(kind.point_count()) {
        let weighted: [f64; BATCH] = std::array::from_fn(|lane| volume[lane] * values[lane]);
        for (sums, N) in sums.iter_mut().zip(kind.shapes_at(q)) {
            for lane in 0..BATCH {
                sums[lane] += N * weighted[lane];
            }
        }
    }
    sums
}

/// `field[i] /= weight[i]` where the weight is not zero (a node without an element keeps 0).
fn divide(field: &mut [f64], weight: &[f64]) {
    for (value, &weight) in field.iter_mut().zip(weight) {
        if weight > 0.0 {
            *value /= weight;
        }
    }
}

#[cfg(test)]
#[allow(clippy::float_cmp)] // these values are exact
mod tests {
    use super::*;
    use crate::mechanics::element::Hex8;

    #[test]
    fn averages_are_weighted_by_volume() {
        let mut fields = Fields {
            sums: Sums { von_mises: vec![0.0; 12], element_cauchy: vec![[0.0; 6]; 2], ..Sums::default() },
            nodal_volume: vec![0.0; 12],
            element_volume: vec![0.0; 2],
            cells: vec![[0, 1, 2, 3, 4, 5, 6, 7], [4, 5, 6, 7, 8, 9, 10, 11]].into(),
            ..Fields::default()
        };
        let mut points = PointBatch::default();
        for (lane, (stress, volume)) in [(3.0, 1.0), (9.0, 2.0)].into_iter().enumerate() {
            fields.add_volume(lane as u32, &[volume; MOST_POINTS]);
            for q in 0..MOST_POINTS {
                points.volume[q][lane] = volume;
                points.von_mises[q][lane] = stress;
                points.cauchy[q][0][lane] = stress;
            }
        }
        for _ in 0..2 {
            fields.clear();
            fields.accumulate(&[0, 1], &points);
            fields.divide_sums();
        }
        assert!(
            (fields.sums.von_mises[0] - 3.0).abs() < 1e-14 && (fields.sums.von_mises[9] - 9.0).abs() < 1e-14
        );
        assert!((fields.sums.von_mises[5] - 7.0).abs() < 1e-14, "(1·3 + 2·9)/3");
        assert_eq!(fields.sums.element_cauchy[1], [9.0, 0.0, 0.0, 0.0, 0.0, 0.0]);
    }

    #[test]
    fn what_has_not_moved_takes_part_in_the_average() {
        let mut fields = Fields {
            sums: Sums { von_mises: vec![0.0; 12], ..Sums::default() },
            nodal_volume: vec![0.0; 12],
            cells: vec![[0, 1, 2, 3, 4, 5, 6, 7], [4, 5, 6, 7, 8, 9, 10, 11]].into(),
            ..Fields::default()
        };
        let mut points = PointBatch::default();
        for element in 0..2 {
            fields.add_volume(element, &[1.0; MOST_POINTS]);
        }
        for q in 0..MOST_POINTS {
            (points.volume[q][0], points.von_mises[q][0]) = (1.0, 3.0);
        }
        fields.accumulate(&[0], &points);
        fields.divide_sums();
        assert!(
            (fields.sums.von_mises[0] - 3.0).abs() < 1e-14 && (fields.sums.von_mises[4] - 1.5).abs() < 1e-14
        );
        assert_eq!(fields.sums.von_mises[8], 0.0);
    }

    #[test]
    fn a_linear_field_leans_towards_its_side() {
        let mut fields = Fields {
            sums: Sums { pressure: vec![0.0; 8], ..Sums::default() },
            nodal_volume: vec![0.0; 8],
            cells: vec![[0, 1, 2, 3, 4, 5, 6, 7]].into(),
            ..Fields::default()
        };
        let mut points = PointBatch::default();
        fields.add_volume(0, &[1.0; MOST_POINTS]);
        for q in 0..MOST_POINTS {
            (points.volume[q][0], points.pressure[q][0]) = (1.0, Hex8::point(q)[0]);
        }
        fields.accumulate(&[0], &points);
        fields.divide_sums();
        // p = ξ at points ±1/√3 with weights (1 ± ξ)/2: the projection of ξ to the corner ξ = 1 is 1/3.
        let largest = fields.sums.pressure.iter().copied().fold(0.0, f64::max);
        assert!((largest - 1.0 / 3.0).abs() < 1e-14, "{largest}");
    }
}
