//! The test rig: a scene from JSON, its plan, its run, and what is seen on the way.

use contuse::measure::Summary;
use contuse::mechanics::tensor::Vec3;
use contuse::mesh::Mesh;
use contuse::mesh::write::gmsh::{Encoding, Version, write_gmsh};
use contuse::plan::{Plan, compile};
use contuse::scene::{Budget, Loaded, MeshBytes, MeshSource, MeshSourceError, load};
use contuse::step::{
    Ending, Frame, Interrupt, Outcome, Recorder, RecorderError, RunOptions, State, run_from,
};
use contuse::study::{RunRequest, run_scene};
use serde_json::{Value, json};

pub use crate::record::{assert_at_most, assert_close, assert_order, assert_within, picture};

/// One mesh in memory, whatever its name, or none.
pub struct MeshInMemory(pub Option<Mesh>);

impl MeshSource for MeshInMemory {
    fn read(&self, name: &str, _: u64) -> Result<MeshBytes, MeshSourceError> {
        let missing = || MeshSourceError::NotFound { name: name.to_owned(), known: Vec::new() };
        let mesh = self.0.as_ref().ok_or_else(missing)?;
        Ok(MeshBytes {
            file_name: "mesh.msh".into(),
            bytes: write_gmsh(mesh, Version::V4_1, Encoding::Ascii),
        })
    }
}

/// The plan of a scene document without mesh files.
pub fn plan(document: &Value) -> Plan {
    plan_with(document, None)
}

/// The plan of a scene document whose mesh files are all `mesh`.
pub fn plan_with(document: &Value, mesh: Option<Mesh>) -> Plan {
    compile(&loaded(document, mesh).scene).unwrap()
}

/// A scene document, loaded; its mesh files are all `mesh`.
pub fn loaded(document: &Value, mesh: Option<Mesh>) -> Loaded {
    let bytes = serde_json::to_vec(document).unwrap();
    load(&bytes, &MeshInMemory(mesh), &Budget::COMMAND_LINE)
        .unwrap_or_else(|problems| panic!("the scene is refused: {:#?}", problems.0))
}

/// What a run of a scene says, with the error bars that it asks for.
pub fn summary(loaded: &Loaded) -> Summary {
    let request = RunRequest {
        scene: &loaded.scene,
        sinks: Vec::new(),
        also: None,
        threads: 1,
        interrupt: &|| None,
        progress: &mut |_| {},
    };
    run_scene(request).unwrap().summary
}

/// A small hollow rubber ball over a block of fibred tissue, which it strikes aslant, with friction. `ball`: elements around and
/// through the wall; `block`: along x, y, z.
pub fn small_ball_on_block(ball: [u32; 2], block: [u32; 3], velocity: [f64; 3], end: f64) -> Value {
    json!({
        "name": "ball on block",
        "end_time_s": end,
        "bodies": [
            {
                "name": "ball",
                "mesh": {"generator": {
                    "kind": "hollow_ball", "center_m": [0, 0, 0.0652], "outer_radius_m": 0.015, "inner_radius_m": 0.012,
                    "elements_around": ball[0], "elements_through": ball[1]
                }},
                "velocity_m_per_s": velocity,
                "parts": [{"part": "ball", "density_kg_per_m3": 1000.0, "formulation": "reduced", "material": {
                    "law": "mooney_rivlin", "c10_pa": 5e5, "c01_pa": 1e5, "bulk_modulus_pa": 5e7
                }}]
            },
            {
                "name": "block",
                "mesh": {"generator": {
                    "kind": "block", "min_m": [-0.05, -0.05, 0], "max_m": [0.05, 0.05, 0.05], "elements": block
                }},
                "fixed": [{"set": "z_min"}],
                "parts": [{"part": "block", "density_kg_per_m3": 1060.0, "material": {
                    "law": "holzapfel_gasser_ogden", "c_pa": 2e4, "k1_pa": 2e4, "k2": 0.8, "kappa": 0.1,
                    "fibres": {"angles_deg": [29.0, -29.0]}, "bulk_modulus_pa": 2e7
                }}]
            }
        ],
        "contact": {"friction": 0.3},
        "record": {"fields": [], "field_times_s": []}
    })
}

/// Explicit steps of at most a length [s], and implicit ones of it.
pub fn both_integrators(step: f64) -> [Value; 2] {
    [json!({"kind": "explicit", "max_step_s": step}), json!({"kind": "implicit", "step_s": step})]
}

/// A recorder that is a closure.
struct Watch<W>(W);

impl<W: FnMut(&Frame)> Recorder for Watch<W> {
    fn record(&mut self, frame: &Frame) -> Result<(), RecorderError> {
        (self.0)(frame);
        Ok(())
    }
}

/// Runs a plan from a state on some threads, with a look at every step.
pub fn run_on(plan: &Plan, state: State, threads: usize, watch: impl FnMut(&Frame)) -> (Outcome, State) {
    let interrupt = || None::<Interrupt>;
    run_from(plan, state, &RunOptions { threads, interrupt: &interrupt }, &mut [&mut Watch(watch)])
}

/// Runs a plan to its end on one thread, with a look at every step. It must finish.
pub fn run(plan: &Plan, watch: impl FnMut(&Frame)) -> (Outcome, State) {
    let (outcome, state) = run_on(plan, State::new(plan), 1, watch);
    assert_eq!(outcome.ending, Ending::Finished, "{outcome:#?}");
    (outcome, state)
}

/// Force of all contacts on their slaves at a step [N], in space.
pub fn contact_force(frame: &Frame) -> Vec3 {
    let impulse = |(contact, reaction): (&contuse::mechanics::contact::Contact, _)| {
        let contuse::mechanics::contact::Reaction { impulse } = reaction;
        contact.frame[0] * impulse[0] + contact.frame[1] * impulse[1] + contact.frame[2] * impulse[2]
    };
    let impulses = frame.contacts.iter().zip(frame.reactions.iter().copied()).map(impulse);
    impulses.sum::<Vec3>() / frame.mean_step
}

/// Mass-weighted mean velocity of a body at the half step after t_n [m/s].
pub fn mean_velocity(frame: &Frame, body: usize) -> Vec3 {
    let b = &frame.plan.bodies[body];
    let nodes = b.nodes.start as usize..b.nodes.end as usize;
    nodes.map(|a| frame.v_after[a] * frame.plan.mass[a]).sum::<Vec3>() / b.mass + b.flight_velocity
}

/// Observed order of convergence of errors under halving.
pub fn order(coarse: f64, fine: f64) -> f64 {
    (coarse / fine).log2()
}

/// A body that starts with the velocity of a mode, `speed · shape(X)` along x: its largest difference from `exact`, the
/// displacement of the mode over its initial speed [s] at a time [s], times ω, and the largest error of the energy balance.
pub fn difference_of_a_mode(
    plan: &Plan,
    (omega, speed): (f64, f64),
    shape: impl Fn(&Vec3) -> f64,
    exact: impl Fn(f64) -> f64,
) -> (f64, f64) {
    let mode: Vec<f64> = plan.X.iter().map(shape).collect();
    let mut state = State::new(plan);
    state.v.iter_mut().zip(&mode).for_each(|(v, shape)| v.x = speed * shape);
    let norm: f64 = plan.mass.iter().zip(&mode).map(|(m, shape)| m * shape * shape).sum();
    let (mut largest, mut balance) = (0.0_f64, 0.0_f64);
    let (outcome, _) = run_on(plan, state, 1, |frame| {
        let moved = |a: usize| plan.mass[a] * frame.u[a].x * mode[a];
        let q = (0..mode.len()).map(moved).sum::<f64>() / norm;
        largest = largest.max((q / speed - exact(frame.time)).abs() * omega);
        balance = balance.max(frame.energy.balance_error);
    });
    assert_eq!(outcome.ending, Ending::Finished);
    (largest, balance)
}
