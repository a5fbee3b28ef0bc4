//! Work, resultant and moment of the forces that conserve, over large steps.

use crate::element::{ElementKind, HEX8_CORNERS, OfElement, ReferenceGeometry};
use crate::force::{
    Assembly, BlockInput, BlockParameters, ElementBlock, ElementForces, ForceInput, Formulation, Threads,
};
use crate::material::{
    CoupledNeoHookean, FibreFamilies, HolzapfelGasserOgden, I4Form, Material, MatrixForm, MooneyRivlin,
    Volumetric,
};
use crate::tensor::{Mat3, Vec3};

fn materials() -> [Material; 3] {
    [
        Material::MooneyRivlin(MooneyRivlin {
            c10: 5.5e4,
            c01: 1.4e4,
            volumetric: Volumetric::LnSquared(2e7),
        }),
        Material::CoupledNeoHookean(CoupledNeoHookean { mu: 1e5, lambda: 2e5 }),
        Material::HolzapfelGasserOgden(HolzapfelGasserOgden {
            c: 3e3,
            k1: 2e3,
            k2: 0.84,
            kappa: 0.1,
            families: FibreFamilies::new(&[[0.8, 0.6, 0.0]]).unwrap(),
            i4: I4Form::Full,
            matrix: MatrixForm::Isochoric,
            volumetric: Volumetric::QuadraticLn(1e6),
        }),
    ]
}

/// One distorted element; two of its displacements that are a large motion apart.
struct Case {
    X: [Vec3; 8],
    blocks: [ElementBlock; 1],
    ends: [[Vec3; 8]; 2],
}

impl Case {
    fn new(material: Material, formulation: Formulation) -> Self {
        let X = HEX8_CORNERS
            .map(|c| Vec3::new(c[0] + 0.1 * c[1] * c[2], 1.5 * c[1] + 0.2 * c[0], 0.7 * c[2]) * 1e-3);
        let parameters = BlockParameters::elastic(material, formulation, 1000.0);
        let input = BlockInput {
            element: 0,
            nodes: (0..8).collect(),
            corners: OfElement::from_slice(&X),
            axes: Mat3::identity(),
            geometry: ReferenceGeometry::new(ElementKind::Hex8, &X),
        };
        let displaced = |angle: f64, strain: f64| {
            let R = nalgebra::Rotation3::from_euler_angles(angle, -0.5 * angle, 2.0 * angle).into_inner();
            let F = Mat3::new(1.0, 0.3, 0.1, 0.0, -0.7, 0.2, -0.1, 0.1, 0.4) * strain + Mat3::identity();
            let bend =
                |a: usize| Vec3::new((a as f64 * 2.3).sin(), (a as f64 * 1.7).cos(), 0.3 * a as f64) * 1e-4;
            std::array::from_fn(|a| R * F * (X[a] + bend(a) * strain) - X[a])
        };
        let ends = [displaced(0.1, 0.1), displaced(0.4, 0.25)];
        Self { X, blocks: [ElementBlock::new(0, parameters, 0, &[input]).unwrap()], ends }
    }

    fn evaluated(&self, u: &[Vec3; 8]) -> ElementForces {
        let input = ForceInput::at(u);
        let mut forces = ElementForces::new(&self.blocks);
        forces.evaluate(&Threads::ONE, &self.blocks, &input);
        forces
    }

    fn middle(&self) -> [Vec3; 8] {
        std::array::from_fn(|a| (self.ends[0][a] + self.ends[1][a]) * 0.5)
    }

    /// The change of the strain energy [J], and the forces [N] that conserve and those of the middle.
    fn forces(&self) -> (f64, [Vec3; 8], [Vec3; 8]) {
        let energies = self.ends.map(|u| {
            let mut energies = Vec::new();
            self.evaluated(&u).chunk_energies(&mut energies);
            energies
        });
        let mut forces = self.evaluated(&self.middle());
        let assembly = Assembly::new(8, &self.blocks);
        let at_nodes = |forces: &ElementForces| std::array::from_fn(|a| forces.at_node(&assembly, a));
        let middle = at_nodes(&forces);
        let ends = [&self.ends[0][..], &self.ends[1][..]];
        forces.conserve(
            &Threads::ONE,
            &self.blocks,
            (ends, &[Mat3::identity()]),
            [&energies[0], &energies[1]],
        );
        (energies[1][0] - energies[0][0], at_nodes(&forces), middle)
    }

    fn work(&self, f: &[Vec3; 8]) -> f64 {
        (0..8).map(|a| f[a].dot(&(self.ends[1][a] - self.ends[0][a]))).sum()
    }
}

#[test]
fn work_is_the_energy_that_is_stored_and_momenta_stay() {
    for formulation in [Formulation::MeanDilatation, Formulation::Full, Formulation::Reduced] {
        for material in materials() {
            let case = Case::new(material, formulation);
            let (stored, f, middle) = case.forces();
            let error = |f| (case.work(f) - stored).abs() / stored.abs();
            assert!(error(&f) < 1e-12, "{formulation:?}: {:e}", error(&f));
            assert!(error(&middle) > 1e-4, "{formulation:?}: there was nothing to make up for");
            let size: f64 = f.iter().map(Vec3::norm).sum();
            let resultant: Vec3 = f.iter().sum();
            assert!(resultant.norm() < 1e-13 * size);
            let u = case.middle();
            let moment: Vec3 = (0..8).map(|a| (case.X[a] + u[a]).cross(&f[a])).sum();
            assert!(moment.norm() < 1e-13 * size * 1e-3);
        }
    }
}

#[test]
fn a_rotation_without_strain_is_left_alone() {
    let mut case = Case::new(materials()[1], Formulation::Full);
    let turned = |angle: f64| {
        let R = nalgebra::Rotation3::from_euler_angles(0.0, 0.0, angle).into_inner();
        case.X.map(|X| R * X - X)
    };
    case.ends = [turned(0.0), turned(0.2)];
    let (_, f, middle) = case.forces();
    assert_eq!(f, middle);
}
