//! Elements crushed, sheared and folded at random: the force is the gradient of the energy, the tangent that of the force, and the
//! critical time step below that of the true highest frequency.

use super::internal::{Evaluation, GaussPoints};
use super::one_point::OnePoint;
use super::packed::Elements;
use super::{
    Assembly, BlockInput, BlockParameters, ElementBlock, ElementForces, ForceInput, Formulation, PointInput,
    StiffnessBatch, Threads, corner_pair,
};
use crate::element::{Element as _, ElementKind, HEX8_CORNERS, Hex8, ReferenceGeometry, eval_corner_penalty};
use crate::material::{
    Branch, CoupledNeoHookean, FibreFamilies, HolzapfelGasserOgden, I4Form, Material, MatrixForm, Memories,
    MooneyRivlin, NeoHookean, PronySeries, Volumetric,
};
use crate::random::Random;
use crate::tensor::{Mat3, Vec3};
use nalgebra::{SMatrix, SVector};

type U = [Vec3; 8];
type Matrix = SMatrix<f64, 24, 24>;

const DENSITY: f64 = 1000.0;

/// One element in a block of its own.
struct Element {
    blocks: [ElementBlock; 1],
    mass: [f64; 8],
}

/// Forces on the corners [N], and what else an evaluation says.
struct Evaluated {
    force: SVector<f64, 24>,
    strain: f64,
    hourglass: f64,
    stable_step: f64,
    j: f64,
}

/// Parameters of an elastic block: no viscosity, no memory.
fn parameters(material: Material, formulation: Formulation) -> BlockParameters {
    BlockParameters::elastic(material, formulation, DENSITY)
}

impl Element {
    fn new(X: U, material: Material, formulation: Formulation) -> Self {
        Self::of(X, parameters(material, formulation))
    }

    fn of(X: U, parameters: BlockParameters) -> Self {
        let geometry = ReferenceGeometry::new(ElementKind::Hex8, &X);
        let mass = std::array::from_fn(|a| DENSITY * geometry.corner_volume[a]);
        let input = BlockInput::alone(&X, geometry);
        Self { blocks: [ElementBlock::new(0, parameters, 0, &[input]).unwrap()], mass }
    }

    fn evaluate(&self, u: &U) -> Evaluated {
        let input = ForceInput::at(u);
        let mut forces = ElementForces::new(&self.blocks);
        forces.evaluate(&Threads::ONE, &self.blocks, &input);
        self.evaluated(&forces)
    }

    /// The same as on a machine without wide registers.
    fn evaluate_in_plain_numbers(&self, u: &U) -> Evaluated {
        let input = &ForceInput::at(u);
        let mut all = ElementForces::new(&self.blocks);
        let (block, forces) = (&self.blocks[0], &mut all.chunks[0]);
        let Elements::Hex8(elements) = &block.packed else { panic!("a hexahedron") };
        let law = block.parameters.material;
        macro_rules! evaluate {
            ($formulation:expr) => {
                Evaluation { law, formulation: $formulation, elements, block, input, forces }
                    .without_wide_registers()
            };
        }
        match (block.parameters.formulation, law.volumetric()) {
            (Formulation::Reduced, _) => evaluate!(OnePoint),
            (Formulation::MeanDilatation, Some(_)) => evaluate!(GaussPoints::<true, false>),
            _ => evaluate!(GaussPoints::<false, false>),
        }
        self.evaluated(&all)
    }

    fn evaluated(&self, forces: &ElementForces) -> Evaluated {
        let totals = forces.totals(0);
        let assembly = Assembly::new(8, &self.blocks);
        Evaluated {
            force: SVector::from_fn(|i, _| forces.at_node(&assembly, i / 3)[i % 3]),
            strain: totals.strain,
            hourglass: totals.hourglass,
            stable_step: totals.stable_step.0,
            j: totals.smallest_j.0,
        }
    }

    /// The tangent ∂f/∂u by dual numbers [N/m].
    fn stiffness(&self, u: &U) -> Matrix {
        let mut batch = StiffnessBatch::zeros();
        self.blocks[0].tangent_at(u).eval_batch(0, &mut batch);
        Matrix::from_fn(|r, c| {
            let (r, c) = if r / 3 >= c / 3 { (r, c) } else { (c, r) };
            batch.0[corner_pair(r / 3, c / 3)][3 * (r % 3) + c % 3].0[0]
        })
    }

    /// Largest ω² of the generalised eigenproblem K x = ω² M x [1/s²].
    fn largest_frequency(&self, u: &U) -> f64 {
        let K = self.stiffness(u);
        let scaled = Matrix::from_fn(|r, c| K[(r, c)] / (self.mass[r / 3] * self.mass[c / 3]).sqrt());
        scaled.symmetric_eigenvalues().max()
    }
}

fn rotation(random: &mut Random) -> Mat3 {
    nalgebra::Rotation3::from_scaled_axis(random.vector() * 3.0).into_inner()
}

fn shapes() -> [U; 3] {
    let brick = |size: [f64; 3]| HEX8_CORNERS.map(|s| Vec3::from(s).component_mul(&Vec3::from(size)) * 0.5);
    let mut random = Random(3);
    let distorted = brick([1.0, 1.4, 0.8]).map(|X| X + random.vector() * 0.12);
    [brick([1.0, 1.0, 1.0]), brick([1.0, 0.2, 0.5]), distorted]
}

fn laws() -> [Material; 5] {
    let families = FibreFamilies::new(&[[1.0, 0.5, 0.0], [1.0, -0.5, 0.0]]).unwrap();
    [
        Material::NeoHookean(NeoHookean { c10: 5e4, volumetric: Volumetric::LnSquared(1e5) }),
        Material::NeoHookean(NeoHookean { c10: 5e4, volumetric: Volumetric::LnSquared(1e8) }),
        Material::MooneyRivlin(MooneyRivlin { c10: 4e4, c01: 1e4, volumetric: Volumetric::QuadraticLn(1e6) }),
        Material::CoupledNeoHookean(CoupledNeoHookean { mu: 1e5, lambda: 2e5 }),
        Material::HolzapfelGasserOgden(HolzapfelGasserOgden {
            c: 3e4,
            k1: 2e4,
            k2: 0.8,
            kappa: 0.1,
            families,
            i4: I4Form::Full,
            matrix: MatrixForm::Isochoric,
            volumetric: Volumetric::LnSquared(1e6),
        }),
    ]
}

const FORMULATIONS: [Formulation; 3] = [Formulation::Full, Formulation::MeanDilatation, Formulation::Reduced];

/// Turned, stretched up to threefold along any axes with little change of volume, every corner moved by up to `q` of the shortest edge.
fn deformed(X: &U, q: f64, random: &mut Random) -> U {
    let stretch = random.vector();
    let stretch = (stretch - Vec3::repeat(stretch.mean())).map(f64::exp);
    let axes = rotation(random);
    let F = rotation(random) * axes * Mat3::from_diagonal(&stretch) * axes.transpose();
    let edge = [1, 3, 4].map(|a| (X[a] - X[0]).norm()).into_iter().fold(f64::INFINITY, f64::min);
    X.map(|X| F * (X + random.vector() * (q * edge)) - X)
}

fn check_derivatives(element: &Element, u: &U, random: &mut Random, what: &str) {
    let (evaluated, K) = (element.evaluate(u), element.stiffness(u));
    let along = SVector::<f64, 24>::from_fn(|_, _| random.next());
    let h = 1e-7;
    let side = |sign: f64| {
        element.evaluate(&std::array::from_fn(|a| u[a] + Vec3::from_fn(|i, _| sign * h * along[3 * a + i])))
    };
    let (low, high) = (side(-1.0), side(1.0));
    let slope = (high.strain - low.strain) / (2.0 * h);
    let error = (slope - evaluated.force.dot(&along)).abs();
    assert!(
        error < 1e-6 * evaluated.force.norm() * along.norm(),
        "{what}: {slope}, J = {}",
        evaluated.j + 1.0
    );
    let slope = (high.force - low.force) / (2.0 * h);
    let error = (slope - K * along).norm() / (K.norm() * along.norm());
    assert!(error < 1e-5, "{what}: {error}, J = {}", evaluated.j + 1.0);
}

#[test]
fn machines_without_wide_registers_compute_the_same() {
    let mut random = Random(7);
    for (X, law) in shapes().iter().flat_map(|X| laws().map(|law| (X, law))) {
        for formulation in FORMULATIONS {
            let element = Element::new(*X, law, formulation);
            let u = deformed(X, 0.1, &mut random);
            let (wide, plain) = (element.evaluate(&u), element.evaluate_in_plain_numbers(&u));
            let difference = (wide.force - plain.force).norm() / wide.force.norm();
            assert!(wide.force.norm() > 0.0 && difference < 1e-10, "{law:?}, {formulation:?}: {difference}");
            for (wide, plain) in
                [(wide.strain, plain.strain), (wide.stable_step, plain.stable_step), (wide.j, plain.j)]
            {
                assert!(
                    (wide - plain).abs() <= 1e-10 * wide.abs(),
                    "{law:?}, {formulation:?}: {wide}, {plain}"
                );
            }
        }
    }
}

#[test]
fn single_precision_rounds_the_response_of_an_element_and_nothing_else() {
    let mut random = Random(11);
    let far = Vec3::new(40.0, -30.0, 50.0);
    for (X, law) in shapes().iter().flat_map(|X| laws().map(|law| (X, law))) {
        // Far from the origin, and moved far: neither costs digits.
        let X = X.map(|X| X + far);
        let exact = parameters(law, Formulation::MeanDilatation);
        let element = |single_precision| Element::of(X, BlockParameters { single_precision, ..exact });
        let (single, double) = (element(true), element(false));
        for _ in 0..20 {
            let u = deformed(&X.map(|X| X - far), 0.05, &mut random).map(|u| u + far);
            let (s, d) = (single.evaluate(&u), double.evaluate(&u));
            // What rounds is F, by 6e-8 of products of stretches up to e: the bulk modulus multiplies that, on faces of 1 m², and an
            // exponential by its exponent.
            let error = (s.force - d.force).norm();
            let bound = 5e-6 * law.moduli_at_rest().1 + 2e-5 * d.force.norm();
            assert!(error < bound, "{law:?}: {error} N of {}, J = {}", d.force.norm(), d.j + 1.0);
            assert_eq!(error > 0.0, law.volumetric().is_some(), "{law:?}: where there is such a kernel");
            assert!((s.strain - d.strain).abs() < bound, "{law:?}: {} {}", s.strain, d.strain);
            assert!((s.j - d.j).abs() < 1e-5, "{law:?}: {} {}", s.j, d.j);
            assert!((s.stable_step / d.stable_step - 1.0).abs() < 1e-5);
            // No momentum is made.
            let sum: Vec3 = s.force.as_slice().chunks(3).map(|f| Vec3::new(f[0], f[1], f[2])).sum();
            assert!(sum.norm() < 1e-12 * s.force.norm(), "{law:?}: {sum}");
        }
        assert!(single.evaluate(&[far; 8]).force.norm() < f64::MIN_POSITIVE, "a translation");
    }
}

#[test]
fn single_precision_holds_the_penalties_of_small_elements() {
    let mut random = Random(3);
    let (size, mut penalised) = (2e-5, 0);
    for (X, law) in shapes().iter().flat_map(|X| laws().map(|law| (X, law))) {
        let small = X.map(|X| X * size);
        let exact = parameters(law, Formulation::MeanDilatation);
        let element = |single_precision| Element::of(small, BlockParameters { single_precision, ..exact });
        let (single, double) = (element(true), element(false));
        for sample in 0..200 {
            let u = deformed(X, 0.002 * f64::from(sample), &mut random).map(|u| u * size);
            let (s, d) = (single.evaluate(&u), double.evaluate(&u));
            // With such a step an exponent is beyond its limit.
            if d.stable_step < 1e-12 {
                continue;
            }
            penalised += u32::from(d.hourglass > 0.0);
            let (error, norm) = ((s.force - d.force).norm(), d.force.norm());
            let bound = 5e-6 * law.moduli_at_rest().1 * size * size + 1e-3 * norm;
            assert!(error < bound, "{law:?}, {sample}: {error} N of {norm}, J = {}", d.j + 1.0);
            assert!(
                (s.stable_step / d.stable_step - 1.0).abs() < 1e-2,
                "{law:?}, {sample}: {} {}, J = {}",
                s.stable_step,
                d.stable_step,
                d.j + 1.0
            );
        }
    }
    assert!(penalised > 100, "{penalised}");
}

#[test]
fn force_and_tangent_are_derivatives_however_an_element_is_folded() {
    let mut random = Random(1);
    let mut penalised = 0;
    for (X, law) in shapes().iter().flat_map(|X| laws().map(|law| (X, law))) {
        for formulation in FORMULATIONS {
            let element = Element::new(*X, law, formulation);
            // Folded corners with all points well; and points in reach of the barrier. Nearer to J = 0 differences are no derivatives.
            for (range, q) in [(-0.7..f64::INFINITY, 0.4), (-0.93..-0.82, 0.5)] {
                let of_penalty =
                    |evaluated: &Evaluated| formulation == Formulation::Reduced || evaluated.hourglass > 0.0;
                let samples: Vec<U> = (0..2000)
                    .map(|_| deformed(X, q, &mut random))
                    .filter(|u| {
                        Some(element.evaluate(u)).is_some_and(|s| range.contains(&s.j) && of_penalty(&s))
                    })
                    .take(3)
                    .collect();
                for u in &samples {
                    check_derivatives(&element, u, &mut random, &format!("{law:?} {formulation:?}"));
                }
                penalised += samples.len();
            }
        }
    }
    assert!(penalised > 200, "nothing to see: {penalised}");
}

#[test]
fn the_stable_step_is_below_that_of_the_highest_frequency_however_an_element_is_folded() {
    let mut random = Random(2);
    for formulation in FORMULATIONS {
        let (mut largest, mut sum, mut count) = (0.0_f64, 0.0, 0.0);
        for (X, law) in shapes().iter().flat_map(|X| laws().map(|law| (X, law))) {
            let element = Element::new(*X, law, formulation);
            for sample in 0..300 {
                let u = deformed(X, 0.002 * f64::from(sample), &mut random);
                let evaluated = element.evaluate(&u);
                if evaluated.j <= -0.99 {
                    continue;
                }
                let ratio = 0.5 * evaluated.stable_step * element.largest_frequency(&u).max(0.0).sqrt();
                (largest, sum, count) = (largest.max(ratio), sum + ratio, count + 1.0);
                assert!(
                    ratio < 1.0 + 1e-9,
                    "{formulation:?}, {law:?}, sample {sample}: h ω/2 = {ratio}, J = {}",
                    1.0 + evaluated.j
                );
            }
        }
        // A bound that is far off would cost steps.
        assert!(
            largest > 0.8 && sum / count > 0.3,
            "{formulation:?}: {largest}, {} in the mean",
            sum / count
        );
    }
}

/// Energy of the penalty on the corners, of unit stiffness.
fn penalty(X: &U, u: &U) -> f64 {
    let components = |x: &U| -> [[f64; 8]; 3] { std::array::from_fn(|i| std::array::from_fn(|a| x[a][i])) };
    eval_corner_penalty(Hex8::CORNERS, &components(X), &components(u), [1.0, 1.0, 0.0]).energy
}

#[test]
fn no_corner_of_an_element_that_expands_is_folded_before_it_is_looked_for() {
    let mut random = Random(6);
    let mut penalised = 0;
    for (X, formulation) in
        shapes().into_iter().zip([Formulation::MeanDilatation, Formulation::Full].into_iter().cycle())
    {
        let element = Element::new(X, laws()[0], formulation);
        for sample in 0..20_000 {
            let (u, size) =
                (deformed(&X, 0.5 * f64::from(sample) / 20_000.0, &mut random), 1.25 + 0.25 * random.next());
            let u = std::array::from_fn(|a| (X[a] + u[a]) * size - X[a]);
            if penalty(&X, &u) > 0.0 {
                let evaluated = element.evaluate(&u);
                assert!(evaluated.hourglass > 0.0, "sample {sample}: J = {}", 1.0 + evaluated.j);
                penalised += u32::from(evaluated.j > -0.1);
            }
        }
    }
    assert!(penalised > 100, "{penalised}");
}

#[test]
fn no_corner_of_a_one_point_element_is_folded_before_it_is_looked_for() {
    let mut random = Random(5);
    let (mut passed_over, mut penalised) = (0, 0);
    for X in shapes() {
        let material = laws()[0];
        let (element, mu) = (Element::new(X, material, Formulation::Reduced), material.moduli_at_rest().0);
        let volume = element.mass.iter().sum::<f64>() / DENSITY;
        for sample in 0..20_000 {
            let u = deformed(&X, 0.5 * f64::from(sample) / 20_000.0, &mut random);
            let evaluated = element.evaluate(&u);
            let penalty = penalty(&X, &u);
            if evaluated.j - 40.0 * evaluated.hourglass / (mu * volume) >= -0.1 {
                assert!(
                    penalty <= 0.0,
                    "sample {sample}: J = {}, {}",
                    1.0 + evaluated.j,
                    evaluated.hourglass
                );
                passed_over += 1;
            }
            penalised += u32::from(penalty > 0.0);
        }
    }
    assert!(passed_over > 1000 && penalised > 1000, "{passed_over} {penalised}");
}

#[test]
fn history_has_rows_where_something_is_remembered_and_only_there() {
    let elastic = parameters(laws()[0], Formulation::MeanDilatation);
    let branches = [1e-3, 2e-3].map(|relaxation_time| Branch { relative_modulus: 0.5, relaxation_time });
    let memory = Memories { prony: PronySeries::new(&branches).unwrap(), ..Memories::NONE };
    let bulk = BlockParameters { linear_viscosity: 0.06, ..elastic };
    let relaxing = BlockParameters { memory, ..elastic };
    let both = BlockParameters { memory, ..bulk };
    let one_point = BlockParameters { formulation: Formulation::Reduced, ..both };
    // Two branches: displacements of eight nodes, and their forces.
    let (of_point, of_nodes) = (6 * 3 + 2, 3 * 8 * 3);
    let expected = [0, 2, 8 * of_point + of_nodes, 2 + 8 * of_point + of_nodes, 2 + of_point + of_nodes];
    for (parameters, rows) in [elastic, bulk, relaxing, both, one_point].into_iter().zip(expected) {
        let element = Element::of(shapes()[2], parameters);
        assert_eq!(element.blocks[0].history_rows(), rows);
        let lengths: Vec<usize> = ElementForces::no_history(&element.blocks).iter().map(Vec::len).collect();
        assert_eq!(lengths, if rows == 0 { vec![] } else { vec![rows] });
    }

    // What relaxes does not know whether bulk viscosity remembers too.
    let mut random = Random(7);
    let steps: Vec<U> = (0..3).map(|_| deformed(&shapes()[2], 0.1, &mut random)).collect();
    let forces = [relaxing, both].map(|parameters| {
        let element = Element::of(shapes()[2], parameters);
        let (mut history, v) = (ElementForces::no_history(&element.blocks), [Vec3::zeros(); 8]);
        let mut forces = ElementForces::new(&element.blocks);
        for u in &steps {
            let input = ForceInput { inverse_step: 1e3, history: &history, ..ForceInput::at(u) };
            forces.evaluate(&Threads::ONE, &element.blocks, &input);
            forces.add_viscous(&Threads::ONE, &element.blocks, &input, &v);
            forces.swap_history(&mut history);
        }
        let assembly = Assembly::new(8, &element.blocks);
        [0, 1, 2, 3, 4, 5, 6, 7].map(|a| forces.viscous_at_node(&assembly, a))
    });
    assert!(forces[0] == forces[1] && forces[0][0].norm() > 1.0);
}

#[test]
fn the_strain_rate_is_the_largest_principal_value_of_the_deviatoric_rate_of_deformation() {
    let mut random = Random(5);
    for formulation in FORMULATIONS {
        for X in shapes() {
            let element = Element::new(X, laws()[0], formulation);
            let F = Mat3::identity() + Mat3::from_iterator(random.numbers::<9>()) * 0.2;
            let L = Mat3::from_iterator(random.numbers::<9>()) * 400.0;
            let u = X.map(|X| F * X - X);
            let input = PointInput { v: &X.map(|X| L * F * X), with_rate: true, ..PointInput::at_rest(&u) };
            let d = (L + L.transpose()) * 0.5;
            let deviator = d - Mat3::identity() * (d.trace() / 3.0);
            let expected = deviator.symmetric_eigenvalues().amax();
            let mut count = 0;
            element.blocks[0].for_each_moved_batch(input, &mut |_, points| {
                for q in 0..points.count {
                    let found = points.strain_rate[q].0[0];
                    assert!(
                        (found / expected - 1.0).abs() < 1e-9,
                        "{formulation:?}: {found} and not {expected}"
                    );
                    count += 1;
                }
            });
            assert_eq!(count, 8);
        }
    }
}
