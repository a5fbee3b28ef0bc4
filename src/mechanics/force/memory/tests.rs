//! Elements of a law with internal variables against its closed form, alone and beside a memory.

use super::super::{Assembly, BlockInput, ElementForces, PointInput, Threads, branch_totals::BranchTotals};
use super::*;
use crate::element::{ElementKind, HEX8_CORNERS, ReferenceGeometry};
use crate::material::{Branch, CoupledNeoHookean, Material, Memories, PronySeries, ViscousVolume};
use crate::tensor::{Mat3, Vec3};

type U = [Vec3; 8];

const ELASTIC: CoupledNeoHookean = CoupledNeoHookean { mu: 4e3, lambda: 3e4 };
const LAW: ViscousVolume = ViscousVolume { elastic: ELASTIC, modulus: 5e4, time: 2e-3 };
/// Edge of the cube [m], step [s], rate of J [1/s].
const EDGE: f64 = 0.01;
const H: f64 = 5e-4;
const RATE: f64 = 40.0;

/// A cube around the origin.
fn block(material: Material, formulation: Formulation, memory: Memories) -> [ElementBlock; 1] {
    let parameters = BlockParameters { memory, ..BlockParameters::elastic(material, formulation, 1000.0) };
    let X = HEX8_CORNERS.map(|c| Vec3::from(c) * (0.5 * EDGE));
    let geometry = ReferenceGeometry::new(ElementKind::Hex8, &X);
    let input = BlockInput::alone(&X, geometry);
    [ElementBlock::new(0, parameters, 0, &[input]).unwrap()]
}

/// Displacements [m] of a homogeneous deformation.
fn displaced(F: Mat3) -> U {
    HEX8_CORNERS.map(|c| (F - Mat3::identity()) * Vec3::from(c) * (0.5 * EDGE))
}

/// A volume change J − 1 without distortion.
fn expanded(j: f64) -> U {
    displaced(Mat3::identity() * (1.0 + j).cbrt())
}

/// Evaluates forces a step [s] after `history`, which is taken on; with the critical time step of the elastic response.
fn step(blocks: &[ElementBlock], history: &mut [Vec<Row>], u: &U, h: f64) -> (ElementForces, f64) {
    let mut forces = ElementForces::new(blocks);
    let inverse_step = if h > 0.0 { 1.0 / h } else { 0.0 };
    let input = ForceInput { inverse_step, history, ..ForceInput::at(u) };
    forces.evaluate(&Threads::ONE, blocks, &input);
    let elastic_step = forces.totals(0).stable_step.0;
    forces.add_viscous(&Threads::ONE, blocks, &input, &[Vec3::zeros(); 8]);
    forces.copy_history(history);
    (forces, elastic_step)
}

/// Forces of history at the corners [N].
fn forces_of_history(forces: &ElementForces, blocks: &[ElementBlock]) -> U {
    let assembly = Assembly::new(8, blocks);
    std::array::from_fn(|a| forces.viscous_at_node(&assembly, a))
}

/// The first Cauchy stress of a point [Pa].
fn stress(block: &ElementBlock, input: PointInput) -> f64 {
    let mut sigma = f64::NAN;
    block.for_each_moved_batch(input, &mut |_, points| sigma = points.cauchy[0][0].0[0]);
    sigma
}

#[test]
fn internal_variables_follow_their_closed_form() {
    for (formulation, points) in [(Formulation::Full, 8), (Formulation::Reduced, 1)] {
        let blocks = block(LAW.into(), formulation, Memories::NONE);
        assert_eq!(blocks[0].history_rows(), 2 * points);
        let mut history = ElementForces::no_history(&blocks);
        for n in 0..=8 {
            let (t, h) = (f64::from(n) * H, if n > 0 { H } else { 0.0 });
            let u = expanded(RATE * t);
            let (forces, elastic_step) = step(&blocks, &mut history, &u, h);
            // e = r τ (1 − e^(−t/τ)), and its pressure on the faces of the cube.
            let e = -RATE * LAW.time * (-t / LAW.time).exp_m1();
            let p = LAW.modulus * e;
            let on_corner = 0.25 * p * (EDGE * (1.0 + RATE * t).cbrt()).powi(2);
            for (f, corner) in forces_of_history(&forces, &blocks).iter().zip(HEX8_CORNERS) {
                assert!((f - Vec3::from(corner) * on_corner).norm() <= 1e-11 * on_corner.abs(), "{n}: {f}");
            }
            let totals = forces.totals(0);
            let stored = 0.5 * p * e * EDGE.powi(3);
            assert!((totals.branches - stored).abs() <= 1e-11 * stored, "{n}: {}", totals.branches);
            assert!(totals.stable_step.0 < 0.8 * elastic_step, "{n}: {elastic_step}");
            // Stress at the time of the history.
            if n > 0 {
                let elastic = stress(&blocks[0], PointInput::at_rest(&u));
                let whole = stress(&blocks[0], PointInput { history: &history, ..PointInput::at_rest(&u) });
                assert!((whole - elastic - p).abs() <= 1e-11 * whole, "{n}: {whole} {elastic} {p}");
            }
        }
    }
}

#[test]
fn a_run_starts_with_the_elastic_response() {
    let blocks = block(LAW.into(), Formulation::Full, Memories::NONE);
    let mut history = ElementForces::no_history(&blocks);
    let (forces, _) = step(&blocks, &mut history, &expanded(0.1), 0.0);
    assert!(forces_of_history(&forces, &blocks) == U::default() && forces.totals(0).branches == 0.0);
    // What follows counts from there.
    let (forces, _) = step(&blocks, &mut history, &expanded(0.12), H);
    assert!(forces_of_history(&forces, &blocks)[0].norm() > 1e-3);
}

#[test]
fn internal_variables_and_memories_do_not_mix() {
    let branches = [1e-3, 2e-2].map(|relaxation_time| Branch { relative_modulus: 0.5, relaxation_time });
    let prony = Memories { prony: PronySeries::new(&branches).unwrap(), ..Memories::NONE };
    let run = |material: Material, memory: Memories| -> (U, [BranchTotals; 2]) {
        let blocks = block(material, Formulation::Full, memory);
        let mut history = ElementForces::no_history(&blocks);
        let mut last = None;
        for n in 0..4 {
            let t = f64::from(n);
            let F = Mat3::new(0.1, 0.05, 0.0, -0.02, 0.03, 0.04, 0.0, 0.06, 0.08) * t + Mat3::identity();
            last = Some(step(&blocks, &mut history, &displaced(F), if n > 0 { H } else { 0.0 }).0);
        }
        let forces = last.unwrap();
        (forces_of_history(&forces, &blocks), [0, 1].map(|branch| forces.branch_totals(0, branch)))
    };
    let ((law, _), (memory, of_branches)) = (run(LAW.into(), Memories::NONE), run(ELASTIC.into(), prony));
    let (both, of_branches_beside) = run(LAW.into(), prony);
    for a in 0..8 {
        let size = law[a].norm() + memory[a].norm();
        assert!(law[a].norm() > 0.1 * size && memory[a].norm() > 0.01 * size);
        assert!((both[a] - law[a] - memory[a]).norm() <= 1e-12 * size);
    }
    assert_eq!(of_branches, of_branches_beside);
}
