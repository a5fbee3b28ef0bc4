//! One-point elements, through the kernel that a run uses.

use crate::element::{ElementKind, HEX8_CORNERS, ReferenceGeometry};
use crate::force::{
    Assembly, BlockInput, BlockParameters, ElementBlock, ElementForces, ForceInput, Formulation, Threads,
};
use crate::material::{
    CoupledNeoHookean, FibreFamilies, HolzapfelGasserOgden, I4Form, Material, MatrixForm, MooneyRivlin,
    NeoHookean, Volumetric,
};
use crate::tensor::{Mat3, Vec3};
use nalgebra::{Rotation3, SMatrix, SVector};

/// One element in a block of its own.
struct Element {
    X: [Vec3; 8],
    blocks: [ElementBlock; 1],
    mass: [f64; 8],
}

type U = [Vec3; 8];

/// What an evaluation says of the element.
#[derive(Clone, Copy, Debug)]
struct Seen {
    strain: f64,
    hourglass: f64,
    stable_step: f64,
    j: f64,
}

impl Element {
    fn new(X: [Vec3; 8], material: Material, formulation: Formulation) -> Self {
        let parameters = BlockParameters::elastic(material, formulation, 1000.0);
        let geometry = ReferenceGeometry::new(ElementKind::Hex8, &X);
        let mass = std::array::from_fn(|a| 1000.0 * geometry.corner_volume[a]);
        let input = BlockInput::alone(&X, geometry);
        Self { X, blocks: [ElementBlock::new(0, parameters, 0, &[input]).unwrap()], mass }
    }

    /// Forces on the corners [N] and totals.
    fn evaluate(&self, u: &U) -> (U, Seen) {
        let input = ForceInput::at(u);
        let mut forces = ElementForces::new(&self.blocks);
        forces.evaluate(&Threads::ONE, &self.blocks, &input);
        let totals = forces.totals(0);
        let assembly = Assembly::new(8, &self.blocks);
        let seen = Seen {
            strain: totals.strain,
            hourglass: totals.hourglass,
            stable_step: totals.stable_step.0,
            j: totals.smallest_j.0,
        };
        (std::array::from_fn(|a| forces.at_node(&assembly, a)), seen)
    }

    /// The Hessian of the energy [N/m], by differences of the forces.
    fn stiffness(&self, u: &U) -> SMatrix<f64, 24, 24> {
        let h = 1e-6 * (self.X[6] - self.X[0]).norm();
        let mut K = SMatrix::<f64, 24, 24>::zeros();
        for c in 0..24 {
            let side = |sign: f64| {
                let mut u = *u;
                u[c / 3][c % 3] += sign * h;
                flat(&self.evaluate(&u).0)
            };
            K.set_column(c, &((side(1.0) - side(-1.0)) / (2.0 * h)));
        }
        K
    }
}

fn flat(f: &U) -> SVector<f64, 24> {
    SVector::from_fn(|i, _| f[i / 3][i % 3])
}

fn brick(size: [f64; 3]) -> [Vec3; 8] {
    HEX8_CORNERS.map(|s| Vec3::from(s).component_mul(&Vec3::from(size)) * 0.5)
}

/// Numbers between −1 and 1 that are as good as random, and the same everywhere.
fn wave(i: usize) -> f64 {
    (i as f64 * 12.9898).sin() * 43758.5453 % 1.0
}

fn distorted() -> [Vec3; 8] {
    let mut X = brick([0.01, 0.014, 0.008]);
    for (a, X) in X.iter_mut().enumerate() {
        *X += Vec3::from_fn(|i, _| 0.001 * wave(3 * a + i));
    }
    X
}

/// A linear field with gradient `F` and hourglass up to `q` of an edge.
fn displaced(X: &[Vec3; 8], F: &Mat3, q: f64, seed: usize) -> U {
    let edge = (X[1] - X[0]).norm();
    std::array::from_fn(|a| {
        F * X[a] - X[a] + Vec3::from_fn(|i, _| q * edge * wave(100 * seed + 3 * a + i + 7))
    })
}

fn laws() -> Vec<Material> {
    let volumetric = Volumetric::LnSquared(1e6);
    let families = FibreFamilies::new(&[[1.0, 0.5, 0.0], [1.0, -0.5, 0.0]]).unwrap();
    let hgo = HolzapfelGasserOgden {
        c: 3e4,
        k1: 2e4,
        k2: 0.8,
        kappa: 0.1,
        families,
        i4: I4Form::Full,
        matrix: MatrixForm::Isochoric,
        volumetric,
    };
    vec![
        Material::MooneyRivlin(MooneyRivlin { c10: 4e4, c01: 1e4, volumetric }),
        Material::NeoHookean(NeoHookean { c10: 5e4, volumetric }),
        Material::CoupledNeoHookean(CoupledNeoHookean { mu: 1e5, lambda: 2e5 }),
        Material::HolzapfelGasserOgden(hgo),
        Material::HolzapfelGasserOgden(HolzapfelGasserOgden { matrix: MatrixForm::Coupled, ..hgo }),
    ]
}

/// Neo-Hookean with shear modulus `mu` and bulk modulus `K` [Pa].
fn rubber(mu: f64, K: f64) -> Material {
    Material::NeoHookean(NeoHookean { c10: 0.5 * mu, volumetric: Volumetric::LnSquared(K) })
}

fn stretched() -> Mat3 {
    Mat3::new(1.3, 0.2, -0.1, 0.05, 0.75, 0.15, -0.1, 0.1, 1.05)
}

#[test]
fn force_is_the_gradient_of_the_energy() {
    let X = distorted();
    for law in laws() {
        let element = Element::new(X, law, Formulation::Reduced);
        let u = displaced(&X, &stretched(), 0.15, 1);
        let (force, totals) = element.evaluate(&u);
        assert!(totals.hourglass > 0.01 * totals.strain, "{law:?}: little to see");
        let scale = force.iter().map(Vec3::norm).fold(0.0, f64::max);
        let h = 1e-8;
        for c in 0..24 {
            let energy = |sign: f64| {
                let mut u = u;
                u[c / 3][c % 3] += sign * h;
                element.evaluate(&u).1.strain
            };
            let slope = (energy(1.0) - energy(-1.0)) / (2.0 * h);
            let f = force[c / 3][c % 3];
            assert!((slope - f).abs() < 1e-7 * scale, "{law:?}, {c}: {slope} against {f}");
        }
    }
}

#[test]
fn turning_and_moving_the_deformed_element_turns_the_forces_and_keeps_the_energies() {
    let X = distorted();
    let R = Rotation3::from_euler_angles(0.9, -2.0, 2.7).into_inner();
    for law in laws() {
        let element = Element::new(X, law, Formulation::Reduced);
        let u = displaced(&X, &stretched(), 0.15, 2);
        let turned = std::array::from_fn(|a| R * (X[a] + u[a]) + Vec3::new(0.1, 0.2, -0.3) - X[a]);
        let ((f, before), (g, after)) = (element.evaluate(&u), element.evaluate(&turned));
        let scale = f.iter().map(Vec3::norm).fold(0.0, f64::max);
        for (f, g) in f.iter().zip(&g) {
            assert!((R * f - g).norm() < 1e-11 * scale, "{law:?}");
        }
        assert!((before.strain / after.strain - 1.0).abs() < 1e-12, "{law:?}");
        assert!((before.hourglass / after.hourglass - 1.0).abs() < 1e-12, "{law:?}");
        // No net force, no net moment.
        let moment: Vec3 = (0..8).map(|a| (X[a] + u[a]).cross(&f[a])).sum();
        assert!(f.iter().sum::<Vec3>().norm() < 1e-12 * scale);
        assert!(moment.norm() < 1e-12 * scale * 0.01, "{law:?}: {moment}");
    }
}

#[test]
fn a_linear_field_is_left_alone_by_the_stabilisation() {
    let X = distorted();
    for law in laws() {
        let element = Element::new(X, law, Formulation::Reduced);
        let (_, totals) = element.evaluate(&displaced(&X, &stretched(), 0.0, 0));
        assert!(totals.hourglass < 1e-25 * totals.strain.max(1.0), "{law:?}: {}", totals.hourglass);
    }
}

#[test]
fn rest_is_zero_bit_by_bit() {
    for law in laws() {
        let element = Element::new(distorted(), law, Formulation::Reduced);
        // Also anywhere else: rigid flight is taken out of u, but not every translation.
        let (force, totals) = element.evaluate(&[Vec3::zeros(); 8]);
        assert!(force.iter().all(|f| f.iter().all(|c| *c == 0.0)), "{law:?}: {force:?}");
        assert!(totals.strain == 0.0 && totals.hourglass == 0.0 && totals.j == 0.0);
        let (force, totals) = element.evaluate(&[Vec3::new(0.25, -0.5, 3.0); 8]);
        assert!(force.iter().all(|f| f.iter().all(|c| *c == 0.0)), "{law:?}: {force:?}");
        assert!(totals.strain == 0.0);
    }
}

#[test]
fn only_rigid_motions_cost_nothing() {
    for (X, K) in [(distorted(), 1e5), (distorted(), 1e9), (brick([1.0, 0.1, 0.3]), 1e9)] {
        let element = Element::new(X, rubber(1e5, K), Formulation::Reduced);
        let stiffness = element.stiffness(&[Vec3::zeros(); 8]);
        let asymmetry = (stiffness - stiffness.transpose()).norm() / stiffness.norm();
        assert!(asymmetry < 1e-8, "{asymmetry}");
        let mut values: Vec<f64> =
            ((stiffness + stiffness.transpose()) * 0.5).symmetric_eigenvalues().iter().copied().collect();
        values.sort_by(f64::total_cmp);
        // The softest of the others bends or twists the element by its shear modulus.
        let size = (X[6] - X[0]).norm();
        let softest = 1e5 * ReferenceGeometry::new(ElementKind::Hex8, &X).total_volume() / (size * size);
        assert!(values[5].abs() < 1e-9 * values[23], "{values:?}");
        assert!(values[6] > 0.05 * softest, "{values:?} against {softest}");
        // Against volume there is one constraint: the other 17 do not know of K.
        if K > 1e8 {
            assert!(values[22] < 0.01 * values[23], "{values:?}");
        }
    }
}

/// Energy of bending an element of edges (2a, 2b, 2c) in its first and second axes by a curvature: u_x = x y.
fn bending_energy(size: [f64; 3], material: Material, formulation: Formulation) -> f64 {
    let X = brick(size);
    let amplitude = 1e-6;
    let u = X.map(|X| Vec3::new(amplitude * X.x * X.y, 0.0, 0.0));
    let totals = Element::new(X, material, formulation).evaluate(&u).1;
    totals.strain / (amplitude * amplitude)
}

#[test]
fn bending_is_that_of_a_plate_whatever_the_shape_and_the_bulk_modulus() {
    // ½ E/(1 − ν²) ∫ y² dV: the strain along the thickness is free, that across the plate is held. No shear, no pressure.
    for K in [1e5, 1e6, 1e9] {
        let mu = 1e5;
        let nu = (3.0 * K - 2.0 * mu) / (6.0 * K + 2.0 * mu);
        for size in [[1.0, 1.0, 1.0], [1.0, 0.1, 0.3], [0.2, 1.0, 0.5]] {
            let volume: f64 = size.iter().product();
            let exact = mu / (1.0 - nu) * volume * size[1] * size[1] / 12.0;
            let got = bending_energy(size, rubber(mu, K), Formulation::Reduced);
            assert!((got / exact - 1.0).abs() < 1e-5, "{size:?}, K = {K}: {got} against {exact}");
        }
    }
    // What this is worth: a flat element of the other formulations is stiffer by parasitic shear.
    let flat = [1.0, 0.1, 0.3];
    let ratio = bending_energy(flat, rubber(1e5, 1e9), Formulation::MeanDilatation)
        / bending_energy(flat, rubber(1e5, 1e9), Formulation::Reduced);
    assert!(ratio > 20.0, "{ratio}");
}

#[test]
fn twist_is_that_of_the_full_element() {
    // u = z (−y, x, 0): shear only, which every formulation takes for what it is.
    let X = brick([1.0, 1.0, 3.0]);
    let u = X.map(|X| Vec3::new(-X.y, X.x, 0.0) * (1e-6 * X.z));
    let energy = |formulation| Element::new(X, rubber(1e5, 1e7), formulation).evaluate(&u).1.strain;
    assert!((energy(Formulation::Reduced) / energy(Formulation::Full) - 1.0).abs() < 1e-5);
}

#[test]
fn a_skew_element_bends_as_the_same_plate_cut_straight() {
    // The same bending of two parallelepipeds of equal volume and thickness, one sheared along the plate.
    let mu = 1e5;
    let energy = |shear: f64| {
        let X = brick([1.0, 0.2, 0.7]).map(|X| Vec3::new(X.x + shear * X.z, X.y, X.z));
        // Curved alike in all directions of the plate, with the deflection −½ (x² + z²) of its mid-surface at the corners.
        let u = X.map(|X| Vec3::new(X.x * X.y, -0.5 * (X.x * X.x + X.z * X.z), X.z * X.y) * 1e-6);
        Element::new(X, rubber(mu, 1e9), Formulation::Reduced).evaluate(&u).1.strain
    };
    assert!((energy(0.6) / energy(0.0) - 1.0).abs() < 1e-5, "{} against {}", energy(0.6), energy(0.0));
}

#[test]
fn the_stable_step_is_below_that_of_the_true_highest_frequency() {
    let crushed = Mat3::from_diagonal(&Vec3::new(1.3, 1.25, 0.5));
    let pulled = Mat3::from_diagonal(&Vec3::new(0.7, 0.75, 2.0));
    for X in [brick([1.0, 1.0, 1.0]), brick([1.0, 0.2, 0.4]), distorted().map(|X| X * 100.0)] {
        for K in [7e4, 2e5, 1e6, 1e9] {
            let element = Element::new(X, rubber(1e5, K), Formulation::Reduced);
            if K > 1e6 {
                // With the moduli of tissue the stabilisation costs nothing of the step.
                let other = Element::new(X, rubber(1e5, K), Formulation::MeanDilatation);
                let [step, usual] = [&element, &other].map(|e| e.evaluate(&[Vec3::zeros(); 8]).1.stable_step);
                assert!(step > 0.99 * usual, "{step} s against {usual} s");
            }
            for (i, F) in [Mat3::identity(), stretched(), crushed, pulled].iter().enumerate() {
                for q in [0.0, 0.1, 0.2] {
                    let u = displaced(&X, F, q, i);
                    let step = element.evaluate(&u).1.stable_step;
                    let mut K_M = element.stiffness(&u);
                    for r in 0..24 {
                        for c in 0..24 {
                            K_M[(r, c)] /= (element.mass[r / 3] * element.mass[c / 3]).sqrt();
                        }
                    }
                    let omega = ((K_M + K_M.transpose()) * 0.5).symmetric_eigenvalues().max().sqrt();
                    assert!(
                        step * omega < 2.0 * (1.0 + 1e-6),
                        "K = {K}, F {i}, q = {q}: h ω = {}",
                        step * omega
                    );
                }
            }
        }
    }
}
