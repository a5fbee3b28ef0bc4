//! Tangents of viscosity and memory against differences of their forces at the end of a step.

use super::super::{
    Assembly, BlockInput, BlockParameters, ElementForces, ForceInput, Formulation, Threads, corner_pair,
};
use super::*;
use crate::element::{ElementKind, HEX8_CORNERS, ReferenceGeometry};
use crate::material::{
    Branch, CoupledNeoHookean, FibreFamilies, HolzapfelGasserOgden, I4Form, Material, MatrixForm, Memories,
    NeoHookean, Ogden, OgdenTerm, PronySeries, ViscousVolume, Volumetric,
};
use crate::tensor::Mat3;

type U = [Vec3; 8];
type Matrix = nalgebra::SMatrix<f64, 24, 24>;

/// Step [s] and ∂v/∂u [1/s].
const H: f64 = 2e-3;
const SLOPE: f64 = 1.0 / (0.6 * H);

/// A brick of millimetres with bent edges.
fn corners() -> U {
    HEX8_CORNERS.map(|c| {
        Vec3::new(c[0] + 0.1 * c[1] * c[2], 1.5 * c[1] + 0.2 * c[0], 0.7 * c[2] + 0.1 * c[0] * c[1]) * 1e-3
    })
}

/// A vector with components in −1 … 1, without a pattern.
fn scatter(seed: usize) -> Vec3 {
    let x = seed as f64;
    Vec3::new((12.9 * x).sin(), (78.2 * x + 1.0).sin(), (37.7 * x + 2.0).sin())
}

fn materials() -> [Material; 4] {
    let volumetric = Volumetric::LnSquared(2e5);
    let ogden =
        Ogden::new(&[OgdenTerm { mu: 3e3, alpha: 3.0 }, OgdenTerm { mu: -1e3, alpha: -2.0 }], volumetric);
    let fibres = HolzapfelGasserOgden {
        c: 3e3,
        k1: 2e3,
        k2: 0.84,
        kappa: 0.0,
        families: FibreFamilies::new(&[[0.8, 0.6, 0.0]]).unwrap(),
        i4: I4Form::Full,
        matrix: MatrixForm::Isochoric,
        volumetric,
    };
    let elastic = CoupledNeoHookean { mu: 4e3, lambda: 3e4 };
    let internal = ViscousVolume { elastic, modulus: 5e4, time: 1e-3 };
    [NeoHookean { c10: 4e3, volumetric }.into(), ogden.unwrap().into(), fibres.into(), internal.into()]
}

struct Element {
    blocks: [ElementBlock; 1],
    /// Displacements at the start of the step, and its history.
    u: U,
    history: Vec<Vec<Row>>,
}

impl Element {
    /// Strained for a step from rest.
    fn new(material: Material, formulation: Formulation, eta: f64, branches: &[Branch]) -> Self {
        let parameters = BlockParameters {
            material,
            formulation,
            single_precision: false,
            density: 1000.0,
            linear_viscosity: 0.06,
            quadratic_viscosity: 0.0,
            shear_viscosity: eta,
            memory: Memories { prony: PronySeries::new(branches).unwrap(), ..Memories::NONE },
            erosion: None,
        };
        let X = corners();
        let input = BlockInput::alone(&X, ReferenceGeometry::new(ElementKind::Hex8, &X));
        let blocks = [ElementBlock::new(0, parameters, 0, &[input]).unwrap()];
        let stretch = Mat3::new(0.2, 0.1, 0.0, -0.1, 0.1, 0.15, 0.05, 0.0, -0.15);
        let u = std::array::from_fn(|a| stretch * X[a] + scatter(a) * 4e-5);
        let history = ElementForces::no_history(&blocks);
        let mut element = Self { blocks, u, history };
        let forces = element.evaluate(&element.u);
        forces.copy_history(&mut element.history);
        element
    }

    fn velocities(&self, u: &U) -> U {
        std::array::from_fn(|a| scatter(a + 20) * 0.05 + (u[a] - self.u[a]) * SLOPE)
    }

    fn evaluate(&self, u: &U) -> ElementForces {
        let mut forces = ElementForces::new(&self.blocks);
        let input = ForceInput { inverse_step: 1.0 / H, history: &self.history, ..ForceInput::at(u) };
        forces.evaluate(&Threads::ONE, &self.blocks, &input);
        forces.add_viscous(&Threads::ONE, &self.blocks, &input, &self.velocities(u));
        forces
    }

    fn by_differences(&self, u: &U) -> Matrix {
        let (d, assembly) = (4e-9, Assembly::new(8, &self.blocks));
        let mut K = Matrix::zeros();
        for c in 0..24 {
            let side = |steps: f64| {
                let mut u = *u;
                u[c / 3][c % 3] += steps * d;
                let forces = self.evaluate(&u);
                nalgebra::SVector::<f64, 24>::from_fn(|row, _| {
                    forces.viscous_at_node(&assembly, row / 3)[row % 3]
                })
            };
            // Fourth order.
            K.set_column(c, &(((side(1.0) - side(-1.0)) * 8.0 - (side(2.0) - side(-2.0))) / (12.0 * d)));
        }
        K
    }

    fn exact(&self, u: &U) -> Matrix {
        let mut batch = StiffnessBatch::zeros();
        let v = self.velocities(u);
        let end = EndOfStep { u, v: &v, h: H, velocity_slope: SLOPE, history: &self.history };
        self.blocks[0].add_rate_stiffness(0, &end, &mut batch);
        Matrix::from_fn(|row, column| {
            let (row, column) = (row.max(column), row.min(column));
            let ((a, i), (b, j)) = ((row / 3, row % 3), (column / 3, column % 3));
            batch.0[corner_pair(a, b)][3 * i + j][0]
        })
    }
}

#[test]
fn tangents_are_the_symmetric_part_of_the_differences_of_the_forces() {
    let branch = |(g, tau)| Branch { relative_modulus: g, relaxation_time: tau };
    let series = [(0.8, 1e-3), (0.5, 2e-2)].map(branch);
    for formulation in [Formulation::MeanDilatation, Formulation::Full, Formulation::Reduced] {
        for material in materials() {
            for (eta, branches) in [(0.0, &series[..]), (5.0, &[]), (5.0, &series)] {
                let element = Element::new(material, formulation, eta, branches);
                let u = std::array::from_fn(|a| element.u[a] * 1.3 + scatter(a + 40) * 2e-5);
                let (exact, found) = (element.exact(&u), element.by_differences(&u));
                let expected = (found + found.transpose()) * 0.5;
                let error = (exact - expected).amax() / expected.amax();
                let name = material.name();
                assert!(error < 1e-8, "{name}, {formulation:?}, η = {eta}: {error:e}");
            }
        }
    }
}
