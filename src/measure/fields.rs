//! Fields at the nodes and elements, projected from the quadrature points.

use crate::mechanics::element::{Hex8, POINTS, shape_at};
use crate::mechanics::force::PointField;
use crate::mechanics::tensor::{Mat3, Vec3};
use crate::plan::Plan;
use crate::scene::document::FieldName;

/// Von Mises stress √(3/2 s:s), s the deviator of the Cauchy stress [Pa].
pub fn von_mises(cauchy: &Mat3) -> f64 {
    let s = cauchy - Mat3::identity() * (cauchy.trace() / 3.0);
    (1.5 * s.norm_squared()).sqrt()
}

/// Pressure −tr σ / 3, positive in compression [Pa].
pub fn pressure(cauchy: &Mat3) -> f64 {
    -cauchy.trace() / 3.0
}

/// Largest principal Green–Lagrange strain, the largest eigenvalue of E = ½ (FᵀF − I) [-].
///
/// E is formed from ∇u = F − I, E = ½ (∇u + ∇uᵀ + ∇uᵀ∇u), so that it is exactly 0 at rest and nothing cancels. Its largest
/// eigenvalue is in closed form (Smith 1961): with q = tr E / 3, B = E − q I, p² = B:B / 6 and cos 3φ = det B / (2 p³) it is
/// q + 2 p cos φ. An iteration would take longer than the law itself.
pub fn principal_strain(F: &Mat3) -> f64 {
    let H = F - Mat3::identity();
    let E = (H + H.transpose() + H.transpose() * H) * 0.5;
    let q = E.trace() / 3.0;
    let B = E - Mat3::identity() * q;
    let p = (B.norm_squared() / 6.0).sqrt();
    if p == 0.0 {
        return q;
    }
    let cos_3_phi = 0.5 * (B / p).determinant();
    q + 2.0 * p * (cos_3_phi.clamp(-1.0, 1.0).acos() / 3.0).cos()
}

/// What the measures and the fields read of a quadrature point, evaluated once for both.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PointValues {
    /// Von Mises stress [Pa].
    pub von_mises: f64,
    /// Pressure, positive in compression [Pa].
    pub pressure: f64,
    /// Largest principal Green–Lagrange strain [-].
    pub principal_strain: f64,
}

impl PointValues {
    /// At a quadrature point.
    pub fn eval(point: &PointField) -> Self {
        Self {
            von_mises: von_mises(&point.cauchy),
            pressure: pressure(&point.cauchy),
            principal_strain: principal_strain(&point.F),
        }
    }
}

/// Nodal and element fields of the whole model at one time. A field that nobody asked for is empty.
///
/// Nodal values are the lumped L2 projection: averages over the quadrature points of the elements around node a, weighted by
/// reference volume times N_a. They smear what jumps between materials; [`Fields::element_cauchy`] does not.
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
    /// Volume around each node, and of each element [m³].
    nodal_volume: Vec<f64>,
    element_volume: Vec<f64>,
    /// Corner nodes of every element (global numbers).
    hexes: Vec<[u32; 8]>,
    /// N_a at each quadrature point.
    shape: [[f64; 8]; POINTS],
}

impl Fields {
    /// Room for the stress and strain fields that the plan asks for; `None` when it asks for none.
    pub fn new(plan: &Plan) -> Option<Self> {
        let asked = |field| plan.fields.contains(&field);
        let room = |field, n: usize| vec![0.0; if asked(field) { n } else { 0 }];
        let nodes = plan.node_count();
        let fields = Self {
            von_mises: room(FieldName::VonMises, nodes),
            pressure: room(FieldName::Pressure, nodes),
            principal_strain: room(FieldName::PrincipalStrain, nodes),
            element_cauchy: if asked(FieldName::ElementCauchyStress) {
                vec![[0.0; 6]; plan.element_count()]
            } else {
                vec![]
            },
            ..Self::default()
        };
        if !fields.is_nodal() && fields.element_cauchy.is_empty() {
            return None;
        }
        Some(Self {
            nodal_volume: vec![0.0; if fields.is_nodal() { nodes } else { 0 }],
            element_volume: vec![0.0; fields.element_cauchy.len()],
            hexes: plan.bodies.iter().flat_map(|b| b.hexes.iter().copied()).collect(),
            shape: shape_at_points(),
            ..fields
        })
    }

    /// Whether any nodal field is asked for.
    fn is_nodal(&self) -> bool {
        !(self.von_mises.is_empty() && self.pressure.is_empty() && self.principal_strain.is_empty())
    }

    /// Back to zero.
    pub fn clear(&mut self) {
        for field in [
            &mut self.von_mises,
            &mut self.pressure,
            &mut self.principal_strain,
            &mut self.nodal_volume,
            &mut self.element_volume,
        ] {
            field.fill(0.0);
        }
        self.element_cauchy.fill([0.0; 6]);
    }

    /// Adds quadrature point `q` of an element (global number).
    pub fn accumulate(&mut self, element: u32, q: usize, point: &PointField, values: &PointValues) {
        let volume = point.volume;
        if let Some(mean) = self.element_cauchy.get_mut(element as usize) {
            let s = &point.cauchy;
            let components = [s[(0, 0)], s[(1, 1)], s[(2, 2)], s[(0, 1)], s[(1, 2)], s[(0, 2)]];
            mean.iter_mut().zip(components).for_each(|(m, c)| *m += volume * c);
            self.element_volume[element as usize] += volume;
        }
        if self.nodal_volume.is_empty() {
            return;
        }
        let (corners, shape) = (&self.hexes[element as usize], &self.shape[q]);
        let add = |field: &mut Vec<f64>, value: f64| {
            for (&node, N) in corners.iter().zip(shape) {
                field[node as usize] += N * volume * value;
            }
        };
        if !self.von_mises.is_empty() {
            add(&mut self.von_mises, values.von_mises);
        }
        if !self.pressure.is_empty() {
            add(&mut self.pressure, values.pressure);
        }
        if !self.principal_strain.is_empty() {
            add(&mut self.principal_strain, values.principal_strain);
        }
        add(&mut self.nodal_volume, 1.0);
    }

    /// Turns the sums into averages.
    pub fn average(&mut self) {
        for field in [&mut self.von_mises, &mut self.pressure, &mut self.principal_strain] {
            divide(field, &self.nodal_volume);
        }
        for (mean, &volume) in self.element_cauchy.iter_mut().zip(&self.element_volume) {
            if volume > 0.0 {
                *mean = mean.map(|m| m / volume);
            }
        }
    }
}

/// N_a at each quadrature point.
fn shape_at_points() -> [[f64; 8]; POINTS] {
    std::array::from_fn(|q| shape_at(Hex8::point(q)))
}

/// `field[i] /= weight[i]` where the weight is not zero (a node without an element keeps 0).
fn divide(field: &mut [f64], weight: &[f64]) {
    for (value, &weight) in field.iter_mut().zip(weight) {
        if weight > 0.0 {
            *value /= weight;
        }
    }
}

/// Visits every quadrature point of the plan at displacement `u` [m] (nodes × 3), in the order of the blocks.
pub fn for_each_point(plan: &Plan, u: &[Vec3], visit: &mut dyn FnMut(u32, usize, &PointField)) {
    for block in &plan.blocks {
        block.for_each_point(&plan.X, u, visit);
    }
}

#[cfg(test)]
#[allow(clippy::float_cmp)] // these values are exact
mod tests {
    use super::*;

    #[test]
    fn von_mises_of_uniaxial_stress_is_the_stress() {
        let sigma = Mat3::new(-5.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0);
        assert!((von_mises(&sigma) - 5.0).abs() < 1e-14 && (pressure(&sigma) - 5.0 / 3.0).abs() < 1e-14);
        let shear = Mat3::new(0.0, 2.0, 0.0, 2.0, 0.0, 0.0, 0.0, 0.0, 0.0);
        assert!((von_mises(&shear) - 2.0 * 3f64.sqrt()).abs() < 1e-14);
    }

    #[test]
    fn principal_strain_is_zero_at_rest_and_under_rotation() {
        assert_eq!(principal_strain(&Mat3::identity()), 0.0);
        let rotation = nalgebra::Rotation3::from_euler_angles(0.3, -1.0, 2.0).into_inner();
        assert!(principal_strain(&rotation).abs() < 1e-15);
        let stretch = Mat3::from_diagonal(&Vec3::new(1.2, 0.9, 1.0));
        assert!((principal_strain(&(rotation * stretch)) - 0.22).abs() < 1e-14);
        let swollen = Mat3::identity() * 1.1;
        assert!((principal_strain(&swollen) - 0.105).abs() < 1e-15);
    }

    #[test]
    fn the_closed_form_is_the_largest_eigenvalue() {
        for seed in 0..50 {
            let wave = |i: usize, j: usize| 0.3 * f64::from(seed).mul_add(1.7, (5 * i + 3 * j) as f64).sin();
            let F = Mat3::identity() + Mat3::from_fn(wave);
            let largest = ((F.transpose() * F - Mat3::identity()) * 0.5).symmetric_eigenvalues().max();
            assert!((principal_strain(&F) - largest).abs() < 1e-13, "{seed}");
        }
    }

    #[test]
    fn averages_are_weighted_by_volume() {
        let mut fields = Fields {
            von_mises: vec![0.0; 12],
            element_cauchy: vec![[0.0; 6]; 2],
            nodal_volume: vec![0.0; 12],
            element_volume: vec![0.0; 2],
            hexes: vec![[0, 1, 2, 3, 4, 5, 6, 7], [4, 5, 6, 7, 8, 9, 10, 11]],
            shape: shape_at_points(),
            ..Fields::default()
        };
        let point = |s: f64, volume| PointField {
            position: Vec3::zeros(),
            volume,
            F: Mat3::identity(),
            cauchy: Mat3::from_diagonal(&Vec3::new(s, 0.0, 0.0)),
            psi: 0.0,
            J: 1.0,
        };
        for _ in 0..2 {
            fields.clear();
            for q in 0..POINTS {
                let (a, b) = (point(3.0, 1.0), point(9.0, 2.0));
                fields.accumulate(0, q, &a, &PointValues::eval(&a));
                fields.accumulate(1, q, &b, &PointValues::eval(&b));
            }
            fields.average();
        }
        assert!((fields.von_mises[0] - 3.0).abs() < 1e-14 && (fields.von_mises[9] - 9.0).abs() < 1e-14);
        assert!((fields.von_mises[5] - 7.0).abs() < 1e-14, "(1·3 + 2·9)/3");
        assert_eq!(fields.element_cauchy[1], [9.0, 0.0, 0.0, 0.0, 0.0, 0.0]);
    }

    #[test]
    fn a_linear_field_leans_towards_its_side() {
        let mut fields = Fields {
            pressure: vec![0.0; 8],
            nodal_volume: vec![0.0; 8],
            hexes: vec![[0, 1, 2, 3, 4, 5, 6, 7]],
            shape: shape_at_points(),
            ..Fields::default()
        };
        for q in 0..POINTS {
            let cauchy = Mat3::identity() * -Hex8::point(q)[0];
            let position = Vec3::zeros();
            let point = PointField { position, volume: 1.0, F: Mat3::identity(), cauchy, psi: 0.0, J: 1.0 };
            fields.accumulate(0, q, &point, &PointValues::eval(&point));
        }
        fields.average();
        // p = ξ at points ±1/√3 with weights (1 ± ξ)/2: the projection of ξ to the corner ξ = 1 is 1/3.
        let largest = fields.pressure.iter().copied().fold(0.0, f64::max);
        assert!((largest - 1.0 / 3.0).abs() < 1e-14, "{largest}");
    }
}
