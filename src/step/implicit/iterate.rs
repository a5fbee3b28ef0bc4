//! An end of the step that Newton's iteration tries: motion, forces, and what is left of the momentum balance.

use crate::mechanics::force::{ElementForces, SweepInput, Threads};
use crate::mechanics::tensor::Vec3;
use crate::plan::{Implicit, Plan};
use crate::step::explicit::check_block;
use crate::step::failure::Failure;
use crate::step::state::State;

/// What the residual is measured against is at least this many times the root of the energy that rounding stirs up.
const ROUNDING: f64 = 8.0;

/// Size, damping and start of the step.
#[derive(Clone, Copy)]
pub(super) struct Step<'a> {
    pub plan: &'a Plan,
    pub options: &'a Implicit,
    pub threads: &'a Threads,
    pub state: &'a State,
    /// Velocities before the forces: those of the state, the spins of rigid bodies turned freely to the end of the step.
    pub v: &'a [Vec3],
    /// Internal forces at the start [N].
    pub f_int: &'a [Vec3],
    /// h [s].
    pub h: f64,
    /// Mass-proportional damping [1/s], 0 but while settling.
    pub damping: f64,
}

/// One end.
pub(super) struct Iterate {
    /// v⁺, relative to the flight [m/s].
    pub v: Vec<Vec3>,
    /// Cᵀ p, the impulses of the contacts on the nodes [N s].
    pub impulse: Vec<Vec3>,
    /// u⁺ [m].
    pub u: Vec<Vec3>,
    /// Internal forces at u⁺ [N].
    pub f_int: Vec<Vec3>,
    /// `M (v⁺ − v) − h [ξ f⁺ + (1 − ξ) f]` of the unknowns [N s]: what the contacts must give.
    pub lack: Vec<f64>,
    /// Size of `lack − Cᵀ p`, and what it is measured against: `√(Σ r²/m)` [√J].
    pub residual: f64,
    pub scale: f64,
    /// Strain energy of each body, what of it is the stabilisation's [J].
    pub strain: Vec<f64>,
    pub hourglass: Vec<f64>,
    /// Smallest J − 1 [-].
    pub smallest_j: f64,
}

impl Iterate {
    pub fn new(plan: &Plan, unknowns: usize) -> Self {
        let nodes = || vec![Vec3::zeros(); plan.node_count()];
        Self {
            v: nodes(),
            impulse: nodes(),
            u: nodes(),
            f_int: nodes(),
            lack: vec![0.0; unknowns],
            residual: 0.0,
            scale: 0.0,
            strain: vec![0.0; plan.bodies.len()],
            hourglass: vec![0.0; plan.bodies.len()],
            smallest_j: f64::INFINITY,
        }
    }

    /// Everything that follows from v and the impulses. An element beyond its law is an error, with the element.
    pub fn eval(&mut self, step: &Step, forces: &mut ElementForces) -> Result<(), Failure> {
        let (state, theta) = (step.state, step.options.theta);
        for (node, u) in self.u.iter_mut().enumerate() {
            *u = state.u[node] + (self.v[node] * theta + state.v[node] * (1.0 - theta)) * step.h;
        }
        self.sweep(step.plan, step.threads, step.state, forces)?;
        self.weigh(step);
        Ok(())
    }

    /// Forces and energies at u.
    pub fn sweep(
        &mut self,
        plan: &Plan,
        threads: &Threads,
        state: &State,
        forces: &mut ElementForces,
    ) -> Result<(), Failure> {
        // No step is behind the elements: there is no bulk viscosity.
        let (dilatation, viscous_pressure) = (&state.dilatation[..], &state.viscous_pressure[..]);
        let input = SweepInput { u: &self.u, inverse_step: 0.0, dilatation, viscous_pressure };
        forces.sweep(threads, &plan.blocks, &input);
        self.strain.fill(0.0);
        self.hourglass.fill(0.0);
        self.smallest_j = f64::INFINITY;
        for (index, block) in plan.blocks.iter().enumerate() {
            let totals = forces.totals(index);
            check_block(plan, block, &totals, state)?;
            self.smallest_j = self.smallest_j.min(totals.smallest_j.0);
            self.strain[block.body] += totals.strain;
            self.hourglass[block.body] += totals.hourglass;
        }
        for (node, f) in self.f_int.iter_mut().enumerate() {
            *f = forces.at_node(&plan.assembly, node);
        }
        Ok(())
    }

    /// Lack of momentum, its size without what the contacts give, and what that is measured against.
    fn weigh(&mut self, step: &Step) {
        let Step { plan, options, h, .. } = *step;
        let gravity = plan.gravity.unwrap_or_else(Vec3::zeros);
        let mut sizes = [0.0; 4];
        for node in 0..self.v.len() {
            let inertia = plan.inertia(node);
            let parts = [
                self.f_int[node] * h,
                (self.v[node] - step.v[node]).component_mul(&inertia),
                self.impulse[node],
                gravity * (plan.mass[node] * h),
            ];
            for (size, part) in sizes.iter_mut().zip(parts) {
                *size += energy(&part, &inertia);
            }
        }
        let mut residual = 0.0;
        options.unknowns.for_each(|unknown, node, axis| {
            let m = plan.inertia(node)[axis];
            let internal = options.xi * self.f_int[node][axis] + (1.0 - options.xi) * step.f_int[node][axis];
            let mean = 0.5 * (self.v[node][axis] + step.v[node][axis]);
            let force = plan.mass[node] * gravity[axis] - m * step.damping * mean - internal;
            let lack = m * (self.v[node][axis] - step.v[node][axis]) - h * force;
            self.lack[unknown] = lack;
            residual += (lack - self.impulse[node][axis]).powi(2) / m;
        });
        self.residual = residual.sqrt();
        let floor = ROUNDING * plan.rounding_energy.sqrt();
        self.scale = sizes.into_iter().fold(0.0, f64::max).sqrt().max(floor);
    }

    /// What the time integrator dissipated in a body in the step [J]: the work of its internal forces on the mean velocity less
    /// the strain energy that is there for it.
    pub fn dissipated(&self, step: &Step, body: usize, strain_before: f64) -> f64 {
        let nodes = &step.plan.bodies[body].nodes;
        let mut work = 0.0;
        for node in nodes.start as usize..nodes.end as usize {
            let force = self.f_int[node] * step.options.xi + step.f_int[node] * (1.0 - step.options.xi);
            work += force.dot(&(self.v[node] + step.state.v[node]));
        }
        0.5 * step.h * work - (self.strain[body] - strain_before)
    }
}

/// Twice the energy of an impulse [N s, or N m s of a spin] on a node at rest [J].
pub(super) fn energy(impulse: &Vec3, inertia: &Vec3) -> f64 {
    impulse.zip_fold(inertia, 0.0, |sum, p, m| sum + p * p / m)
}
