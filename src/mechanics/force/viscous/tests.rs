//! One element: what its viscous forces do is the power of the viscous stress at the points, rotation costs nothing, and the critical time step
//! stays below that of the true damping matrix.

use super::super::{BlockInput, BlockParameters, ForceInput, Formulation};
use super::*;
use crate::element::{ElementKind, HEX8_CORNERS, Hex8, POINTS, ReferenceGeometry};
use crate::material::{Material, NeoHookean, Volumetric};
use crate::tensor::Mat3;
use nalgebra::{SMatrix, SVector};

type U = [Vec3; 8];

const DENSITY: f64 = 1000.0;
const ETA: f64 = 7.0;

/// A brick of 3 × 2 × 1 mm with bent edges.
fn corners() -> U {
    std::array::from_fn(|a| {
        let X = Vec3::from(HEX8_CORNERS[a]).component_mul(&Vec3::new(1.5e-3, 1e-3, 5e-4));
        X + scatter(a as u32 + 40) * 1e-4
    })
}

/// A vector with components in −1 … 1, without a pattern.
fn scatter(seed: u32) -> Vec3 {
    let x = f64::from(seed);
    Vec3::new((12.9 * x).sin(), (78.2 * x + 1.0).sin(), (37.7 * x + 2.0).sin())
}

struct Element {
    blocks: [ElementBlock; 1],
    mass: [f64; 8],
}

impl Element {
    fn new(mu: f64, formulation: Formulation) -> Self {
        Self::with(mu, formulation, false)
    }

    fn with(mu: f64, formulation: Formulation, single_precision: bool) -> Self {
        let volumetric = Volumetric::LnSquared(1e3 * mu);
        let parameters = BlockParameters {
            material: Material::NeoHookean(NeoHookean { c10: 0.5 * mu, volumetric }),
            formulation,
            single_precision,
            density: DENSITY,
            linear_viscosity: 0.06,
            quadratic_viscosity: 1.2,
            shear_viscosity: ETA,
            memory: crate::material::Memories::NONE,
            erosion: None,
        };
        let geometry = ReferenceGeometry::new(ElementKind::Hex8, &corners());
        let mass = std::array::from_fn(|a| DENSITY * geometry.corner_volume[a]);
        let input = BlockInput::alone(&corners(), geometry);
        Self { blocks: [ElementBlock::new(0, parameters, 0, &[input]).unwrap()], mass }
    }

    /// Viscous forces [N] and critical time step [s].
    fn forces(&self, u: &U, v: &U) -> (U, f64) {
        let input = ForceInput::at(u);
        let mut forces = ElementForces::new(&self.blocks);
        forces.evaluate(&Threads::ONE, &self.blocks, &input);
        let alone = forces.totals(0).stable_step.0;
        forces.add_viscous(&Threads::ONE, &self.blocks, &input, v);
        let step = forces.totals(0).stable_step.0;
        assert!(step < alone, "{step} of {alone}");
        let assembly = Assembly::new(8, &self.blocks);
        let at_nodes = |forces: &ElementForces| std::array::from_fn(|a| forces.viscous_at_node(&assembly, a));
        // In the pass of the internal forces they have the same bits.
        let mut together = ElementForces::new(&self.blocks);
        let input = ForceInput { v, ..input };
        together.evaluate(&Threads::ONE, &self.blocks, &input);
        together.add_viscous(&Threads::ONE, &self.blocks, &input, v);
        assert_eq!((at_nodes(&together), together.totals(0).stable_step.0), (at_nodes(&forces), step));
        (at_nodes(&forces), step)
    }
}

/// Power of the viscous stress [W] at the 2×2×2 points, by matrices: `Σ w 2 η J |dev d|²`.
fn power(u: &U, v: &U) -> f64 {
    let X = corners();
    let of_point = |q: usize| {
        let dN = HEX8_CORNERS.map(|c| shape_gradient(c, Hex8::point(q)));
        let local = |x: &U| (0..8).fold(Mat3::zeros(), |sum, a| sum + x[a] * dN[a].transpose());
        let at_rest = local(&X);
        let inverse = at_rest.try_inverse().unwrap();
        let F = Mat3::identity() + local(u) * inverse;
        let l = local(v) * inverse * F.try_inverse().unwrap();
        let d = (l + l.transpose()) * 0.5;
        let deviator = d - Mat3::identity() * (d.trace() / 3.0);
        at_rest.determinant() * 2.0 * ETA * F.determinant() * deviator.norm_squared()
    };
    (0..POINTS).map(of_point).sum()
}

/// ∂N/∂ξ of the corner `c`, `N = Π ½ (1 + c_i ξ_i)`.
fn shape_gradient(c: [f64; 3], local: [f64; 3]) -> Vec3 {
    let factor = |i: usize| 0.5 * (1.0 + c[i] * local[i]);
    Vec3::from_fn(|i, _| 0.5 * c[i] * factor((i + 1) % 3) * factor((i + 2) % 3))
}

fn moved(seed: u32, by: f64) -> U {
    std::array::from_fn(|a| scatter(seed + a as u32) * by)
}

#[test]
fn forces_do_the_work_of_the_viscous_stress() {
    for formulation in [Formulation::MeanDilatation, Formulation::Full, Formulation::Reduced] {
        let element = Element::new(1e4, formulation);
        for seed in 0..20 {
            let (u, v) = (moved(100 * seed, 2e-4), moved(100 * seed + 50, 3.0));
            let (force, _) = element.forces(&u, &v);
            let work: f64 = force.iter().zip(&v).map(|(f, v)| f.dot(v)).sum();
            let expected = power(&u, &v);
            assert!((work - expected).abs() <= 1e-12 * expected, "{seed}: {work} for {expected}");
            let sum: Vec3 = force.iter().sum();
            let moment: Vec3 = (0..8).map(|a| (corners()[a] + u[a]).cross(&force[a])).sum();
            let scale = force.iter().map(Vec3::norm).sum::<f64>();
            assert!(sum.norm() <= 1e-12 * scale && moment.norm() <= 1e-14 * scale, "{sum} {moment}");
        }
    }
}

#[test]
fn single_precision_rounds_viscous_forces_and_makes_no_momentum() {
    let [single, double] =
        [true, false].map(|is_single| Element::with(1e4, Formulation::MeanDilatation, is_single));
    for seed in 0..20 {
        let far = scatter(seed) * 50.0;
        let u = moved(100 * seed, 2e-4).map(|u| u + far);
        let v = moved(100 * seed + 50, 3.0).map(|v| v + far);
        let ((s, step), (d, exact)) = (single.forces(&u, &v), double.forces(&u, &v));
        let norm = |forces: &U| forces.iter().map(Vec3::norm_squared).sum::<f64>().sqrt();
        let error = norm(&std::array::from_fn(|a| s[a] - d[a]));
        assert!(error > 0.0 && error < 2e-5 * norm(&d), "{seed}: {error} N of {}", norm(&d));
        assert!((step / exact - 1.0).abs() < 1e-5);
        assert!(s.iter().sum::<Vec3>().norm() < 1e-14 * norm(&s));
    }
}

#[test]
fn rotation_and_flight_cost_nothing() {
    let element = Element::new(1e4, Formulation::MeanDilatation);
    for seed in 0..10 {
        let u = moved(10 * seed, 3e-4);
        let spin = scatter(seed) * 1e4;
        let v: U = std::array::from_fn(|a| spin.cross(&(corners()[a] + u[a])) + Vec3::new(30.0, -5.0, 2.0));
        let (force, _) = element.forces(&u, &v);
        let (stretching, _) = element.forces(&u, &std::array::from_fn(|a| scatter(a as u32) * v[a].norm()));
        let scale = stretching.iter().map(Vec3::norm).sum::<f64>();
        assert!(force.iter().all(|f| f.norm() <= 1e-12 * scale), "{force:?} of {scale}");
    }
}

#[test]
fn folded_elements_still_dissipate() {
    // A corner is pushed through the element and out of the other side: J is below zero at points.
    let element = Element::new(1e4, Formulation::Reduced);
    for ratio in [0.5, 1.0, 1.5, 2.0, 3.0] {
        let mut u = [Vec3::zeros(); 8];
        u[0] = (corners()[6] - corners()[0]) * ratio;
        let v = moved(7, 5.0);
        let (force, step) = element.forces(&u, &v);
        let work: f64 = force.iter().zip(&v).map(|(f, v)| f.dot(v)).sum();
        assert!(work > 0.0 && work.is_finite() && step > 0.0, "{ratio}: {work} W, step {step}");
    }
}

#[test]
fn stable_step_is_below_that_of_the_damping_matrix() {
    // Next to no stiffness: what is left is the damping, h ≤ 2/λ.
    for formulation in [Formulation::MeanDilatation, Formulation::Reduced] {
        let element = Element::new(1e-6, formulation);
        for seed in 0..20 {
            let u = moved(30 * seed, 2e-4);
            let mut C = SMatrix::<f64, 24, 24>::zeros();
            for column in 0..24 {
                let mut v = [Vec3::zeros(); 8];
                v[column / 3][column % 3] = 1.0;
                let (force, _) = element.forces(&u, &v);
                let scaled = |row: usize| {
                    let mass = element.mass[row / 3] * element.mass[column / 3];
                    force[row / 3][row % 3] / mass.sqrt()
                };
                C.set_column(column, &SVector::from_fn(|row, _| scaled(row)));
            }
            assert!((C - C.transpose()).norm() <= 1e-12 * C.norm(), "dissipation has a potential");
            let largest = C.symmetric_eigenvalues().max();
            let (_, step) = element.forces(&u, &[Vec3::zeros(); 8]);
            let ratio = step * largest / 2.0;
            assert!((0.1..1.0).contains(&ratio), "{seed}: {ratio}");
        }
    }
}
