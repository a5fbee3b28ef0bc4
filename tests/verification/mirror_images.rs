//! A symmetric scene whose half, quarter or eighth is computed is the scene that is computed in whole.

use crate::rig::{contact_force, plan, run, small_ball_on_block};
use contuse::mechanics::tensor::Vec3;
use contuse::plan::Plan;
use contuse::step::{Ending, Frame, Interrupt, Outcome, Recorder, RecorderError, RunOptions, State};
use serde_json::{Value, json};

/// What is compared at a step.
#[derive(Default)]
struct Step {
    time: f64,
    force: Vec3,
    energies: Vec<f64>,
    momenta: Vec<f64>,
    contacts: usize,
}

#[derive(Default)]
struct Steps(Vec<Step>);

impl Recorder for Steps {
    fn record(&mut self, frame: &Frame) -> Result<(), RecorderError> {
        let energy = frame.energy;
        let of_body = |b: &contuse::step::BodyEnergy| {
            [b.kinetic_j, b.strain_j, b.viscous_j, b.contact_work_j, b.external_work_j]
        };
        let of_pair = |p: &contuse::step::PairLedger| [p.friction_j, p.numerical_j, p.work_on_slave_j];
        let sums = [energy.total_j, energy.scale_j, energy.initial_total_j];
        let bodies = energy.bodies.iter().flat_map(of_body);
        self.0.push(Step {
            time: frame.time,
            force: contact_force(frame),
            energies: bodies.chain(energy.pairs.values().flat_map(of_pair)).chain(sums).collect(),
            momenta: energy
                .momentum_kg_m_per_s
                .into_iter()
                .chain(energy.angular_momentum_kg_m2_per_s)
                .collect(),
            contacts: frame.reactions.iter().filter(|reaction| reaction.impulse[0] > 0.0).count(),
        });
        Ok(())
    }
}

fn run_plan(plan: &Plan) -> (Vec<Step>, Outcome, State) {
    let mut steps = Steps::default();
    let options = RunOptions { threads: 1, interrupt: &|| None::<Interrupt> };
    let (outcome, state) = contuse::step::run(plan, &options, &mut [&mut steps]);
    assert_eq!(outcome.ending, Ending::Finished, "{outcome:#?}");
    (steps.0, outcome, state)
}

/// Compares a scene of so many `images` with the whole; differences of forces, energies and displacements relative to the largest are at most
/// `near`.
fn assert_same(document: &Value, images: usize, near: f64) {
    let mut keeping = document.clone();
    keeping["solver"] = json!({"keep": ["mirror_images"]});
    let (of_sector, of_whole) = (plan(document), plan(&keeping));
    assert!(of_whole.sector.is_none());
    let sector = of_sector.sector.as_ref().expect("the scene is symmetric");
    assert_eq!(sector.image_count(), images);
    assert_eq!(of_sector.element_count(), images * sector.plan.element_count());
    let (got, _, state) = run_plan(&of_sector);
    let (expected, _, whole) = run_plan(&of_whole);
    assert_eq!(got.len(), expected.len());
    assert!(expected.iter().any(|step| step.contacts > 4), "there is an impact");

    let largest = |values: &dyn Fn(&Step) -> f64| expected.iter().map(values).fold(0.0, f64::max);
    let force = largest(&|step| step.force.norm());
    let energy = largest(&|step| step.energies.iter().copied().fold(0.0, f64::max));
    let momentum = largest(&|step| step.momenta.iter().fold(0.0, |most: f64, m| most.max(m.abs())));
    let apart = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    for (a, b) in got.iter().zip(&expected) {
        assert!((a.time - b.time).abs() <= 1e-12);
        assert!((a.force - b.force).norm() <= near * force, "{} s: {} N, not {} N", a.time, a.force, b.force);
        let difference = apart(&a.energies, &b.energies) / energy;
        assert!(difference <= near, "{} s: {difference:e} of the energy", a.time);
        let difference = apart(&a.momenta, &b.momenta) / momentum;
        assert!(difference <= near, "{} s: {difference:e} of the momentum", a.time);
    }
    let moved = whole.u.iter().map(Vec3::norm).fold(0.0, f64::max);
    for (a, b) in state.u.iter().zip(&whole.u) {
        assert!((a - b).norm() <= near * moved, "{a} and {b}");
    }
}

/// A ball on a block, hit in the middle; steps of equal length, so that the same times are compared.
fn ball_on_block(velocity: [f64; 3]) -> Value {
    let mut scene = small_ball_on_block([4, 2], [8, 8, 4], velocity, 2e-4);
    scene["integrator"] = json!({"kind": "explicit", "max_step_s": 5e-7});
    scene
}

#[test]
fn a_quarter_of_a_ball_on_a_fibred_block() {
    assert_same(&ball_on_block([0.0, 0.0, -30.0]), 4, 1e-3);
}
