//! Tangents against differences of the internal force evaluation: every law in every formulation.

use crate::element::{ElementKind, HEX8_CORNERS, ReferenceGeometry};
use crate::force::{
    Assembly, BlockInput, BlockParameters, ElementBlock, ElementForces, ForceInput, Formulation,
    StiffnessBatch, Threads, corner_pair,
};
use crate::material::{
    CoupledNeoHookean, FibreFamilies, HolzapfelGasserOgden, I4Form, Material, MatrixForm, MooneyRivlin,
    NeoHookean, Volumetric,
};
use crate::tensor::{Mat3, Vec3};

type U = [Vec3; 8];
type Matrix = nalgebra::SMatrix<f64, 24, 24>;

fn distorted() -> U {
    HEX8_CORNERS.map(|c| {
        Vec3::new(c[0] + 0.1 * c[1] * c[2], 1.5 * c[1] + 0.2 * c[0], 0.7 * c[2] + 0.1 * c[0] * c[1]) * 1e-3
    })
}

/// A rotation, a stretch and some hourglass: nothing is special.
fn displacement(X: &U, strain: f64) -> U {
    let R = nalgebra::Rotation3::from_euler_angles(0.3, -0.5, 0.8).into_inner();
    let stretch = Mat3::new(1.2, 0.3, 0.1, 0.0, -0.7, 0.2, -0.1, 0.1, 0.4) * strain + Mat3::identity();
    let bend =
        |a: usize| Vec3::new((a as f64 * 2.3).sin(), (a as f64 * 1.7).cos(), (a as f64 * 0.9).sin()) * 1e-4;
    std::array::from_fn(|a| R * stretch * (X[a] + bend(a) * strain) - X[a])
}

fn materials() -> Vec<(&'static str, Material)> {
    let a = [0.8, 0.6, 0.0];
    let b = [0.8, -0.6, 0.0];
    let hgo = |families: &[[f64; 3]], kappa: f64, i4, matrix, volumetric| {
        Material::HolzapfelGasserOgden(HolzapfelGasserOgden {
            c: 3e3,
            k1: 2e3,
            k2: 0.84,
            kappa,
            families: FibreFamilies::new(families).unwrap(),
            i4,
            matrix,
            volumetric,
        })
    };
    vec![
        (
            "Mooney–Rivlin",
            Material::MooneyRivlin(MooneyRivlin {
                c10: 5.5e4,
                c01: 1.4e4,
                volumetric: Volumetric::LnSquared(2e6),
            }),
        ),
        (
            "neo-Hookean",
            Material::NeoHookean(NeoHookean { c10: 4e4, volumetric: Volumetric::Quadratic(1e5) }),
        ),
        ("coupled neo-Hookean", Material::CoupledNeoHookean(CoupledNeoHookean { mu: 1e5, lambda: 2e5 })),
        ("two fibres", hgo(&[a, b], 0.0, I4Form::Full, MatrixForm::Isochoric, Volumetric::QuadraticLn(1e6))),
        (
            "one fibre, dispersed",
            hgo(&[a], 0.2, I4Form::Full, MatrixForm::Isochoric, Volumetric::LnSquared(1e5)),
        ),
    ]
}

struct Element {
    X: U,
    blocks: [ElementBlock; 1],
}

impl Element {
    fn new(material: Material, formulation: Formulation) -> Self {
        let X = distorted();
        let parameters = BlockParameters {
            linear_viscosity: 0.06,
            quadratic_viscosity: 1.2,
            ..BlockParameters::elastic(material, formulation, 1000.0)
        };
        let geometry = ReferenceGeometry::new(ElementKind::Hex8, &X);
        let input = BlockInput::alone(&X, geometry);
        Self { X, blocks: [ElementBlock::new(0, parameters, 0, &[input]).unwrap()] }
    }

    fn force(&self, u: &U) -> U {
        let input = ForceInput::at(u);
        let mut forces = ElementForces::new(&self.blocks);
        forces.evaluate(&Threads::ONE, &self.blocks, &input);
        let assembly = Assembly::new(8, &self.blocks);
        std::array::from_fn(|a| forces.at_node(&assembly, a))
    }

    fn by_differences(&self, u: &U) -> Matrix {
        let h = 2e-6 * (self.X[6] - self.X[0]).norm();
        let mut K = Matrix::zeros();
        for c in 0..24 {
            let side = |steps: f64| {
                let mut u = *u;
                u[c / 3][c % 3] += steps * h;
                let f = self.force(&u);
                nalgebra::SVector::<f64, 24>::from_fn(|row, _| f[row / 3][row % 3])
            };
            // Fourth order.
            let slope = ((side(1.0) - side(-1.0)) * 8.0 - (side(2.0) - side(-2.0))) / (12.0 * h);
            K.set_column(c, &slope);
        }
        K
    }

    fn exact(&self, u: &U) -> Matrix {
        let mut batch = StiffnessBatch::zeros();
        self.blocks[0].tangent_at(u).eval_batch(0, &mut batch);
        Matrix::from_fn(|row, column| {
            let ((a, i), (b, j)) = ((row / 3, row % 3), (column / 3, column % 3));
            if a >= b {
                batch.0[corner_pair(a, b)][3 * i + j][0]
            } else {
                batch.0[corner_pair(b, a)][3 * j + i][0]
            }
        })
    }
}

#[test]
fn tangents_are_the_differences_of_the_forces() {
    for formulation in [Formulation::MeanDilatation, Formulation::Full, Formulation::Reduced] {
        for (name, material) in materials() {
            let element = Element::new(material, formulation);
            // At rest the tangent of fibres jumps: there is no derivative to compare with.
            let rest = (material.family_count() == 0).then_some(0.0);
            for strain in rest.into_iter().chain([0.02, 0.3, -0.3]) {
                let u = displacement(&element.X, strain);
                let (exact, expected) = (element.exact(&u), element.by_differences(&u));
                let error = (exact - expected).amax() / expected.amax();
                assert!(error < 1e-8, "{name}, {formulation:?}, strain {strain}: {error:e}");
                assert!((exact - exact.transpose()).amax() < 1e-12 * exact.amax(), "{name}: not symmetric");
            }
        }
    }
}

#[test]
fn fibres_in_compression_have_no_stiffness() {
    let (_, with) = materials().remove(3);
    let Material::HolzapfelGasserOgden(law) = with else { unreachable!() };
    let without = Material::HolzapfelGasserOgden(HolzapfelGasserOgden { k1: 0.0, ..law });
    let stiffness = |material, stretch: f64| {
        let element = Element::new(material, Formulation::MeanDilatation);
        let u = element.X.map(|X| X * (stretch - 1.0));
        element.exact(&u)
    };
    assert!((stiffness(with, 0.95) - stiffness(without, 0.95)).amax() == 0.0);
    assert!((stiffness(with, 1.05) - stiffness(without, 1.05)).amax() > 0.0);
}
