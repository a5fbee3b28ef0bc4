//! Kinetic energy and momenta of each body, summed over its nodes.

use super::step_work::StepWork;
use crate::mechanics::force::{Activity, Threads};
use crate::mechanics::tensor::Vec3;
use crate::plan::Plan;
use std::ops::Range;

/// Nodes summed by one thread: the sums are the same for any number of threads.
const NODES: u32 = 32 * Activity::NODES as u32;

/// Sums over nodes, in the frame of their body's flight.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct MotionSums {
    /// `Σ m v₋·v₊ + ¼ (h₊ − h₋) f_int·(v₋ + v₊)` [kg m²/s²]: twice the kinetic energy of `balance.rs`.
    pub kinetic: f64,
    /// `Σ m ½(v₋ + v₊)` [kg m/s].
    pub momentum: Vec3,
    /// `Σ m u` [kg m].
    pub shift: Vec3,
    /// `Σ x × m ½(v₋ + v₊)` about the origin [kg m²/s].
    pub angular: Vec3,
}

/// A range of nodes of a body.
#[derive(Debug)]
struct Run {
    body: usize,
    nodes: Range<u32>,
    sums: MotionSums,
}

/// Motion sums of all bodies.
#[derive(Debug, Default)]
pub(super) struct Motion {
    runs: Vec<Run>,
}

impl Motion {
    /// Allocates the sums of a plan.
    pub fn new(plan: &Plan) -> Self {
        let of_body = |(body, Range { start, end }): (usize, Range<u32>)| {
            (start / NODES..end.div_ceil(NODES)).map(move |run| Run {
                body,
                nodes: (run * NODES).max(start)..((run + 1) * NODES).min(end),
                sums: MotionSums::default(),
            })
        };
        let bodies = plan.bodies.iter().map(|body| body.nodes.clone()).enumerate();
        Self { runs: bodies.flat_map(of_body).collect() }
    }

    /// Sums over all active nodes.
    pub fn eval(&mut self, threads: &Threads, work: &StepWork) {
        threads.for_each(&mut self.runs, |run| run.sums = sums(work, run.body, run.nodes.clone()));
    }

    /// The sums of one body.
    pub fn of_body(&self, body: usize) -> MotionSums {
        let runs = self.runs.iter().filter(|run| run.body == body);
        runs.fold(MotionSums::default(), |sum, run| MotionSums {
            kinetic: sum.kinetic + run.sums.kinetic,
            momentum: sum.momentum + run.sums.momentum,
            shift: sum.shift + run.sums.shift,
            angular: sum.angular + run.sums.angular,
        })
    }
}

/// Nodes at rest in their body's frame contribute nothing, and are skipped without affecting the result.
fn sums(work: &StepWork, body: usize, nodes: Range<u32>) -> MotionSums {
    let flown = work.plan.bodies[body].flight_velocity * work.state.time.max(0.0);
    let mut sums = MotionSums::default();
    let quarter = 0.25 * work.step_change;
    for node in work.activity.stepped(nodes) {
        let mass = work.plan.mass[node];
        let (before, after) = (&work.state.v[node], &work.v_after[node]);
        sums.kinetic += mass * before.dot(after);
        if quarter != 0.0 {
            sums.kinetic += quarter * work.f_int[node].dot(&(before + after));
        }
        let p = (before + after) * (0.5 * mass);
        sums.momentum += p;
        sums.shift += work.state.u[node] * mass;
        sums.angular += (work.plan.X[node] + flown + work.state.u[node]).cross(&p);
    }
    sums
}
