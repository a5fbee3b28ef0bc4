//! A trial end of the step in Newton's iteration: motion, forces, and the residual of the momentum balance.

use super::midpoint::widen;
use crate::mechanics::force::{ElementForces, ForceInput, Threads};
use crate::mechanics::lanes::Row;
use crate::mechanics::tensor::Vec3;
use crate::plan::{Implicit, LoadTime, Plan, Prescribed};
use crate::step::branches::Branches;
use crate::step::failure::Failure;
use crate::step::failure::check_block;
use crate::step::loads;
use crate::step::state::State;

/// Lower bound of the reference of the residual, in multiples of the root of the energy of rounding.
const ROUNDING: f64 = 8.0;

/// Fraction of the square of a residual that dominates it.
const MOST: f64 = 0.25;
/// Residual relative to the forces below which no body counts as pushed.
const NOTABLE: f64 = 1e-3;

/// Size, damping and initial values of the step.
#[derive(Clone, Copy)]
pub(super) struct Step<'a> {
    pub plan: &'a Plan,
    pub options: &'a Implicit,
    pub threads: &'a Threads,
    /// Its velocities are those before the forces; spins of rigid bodies are in the body axes at the start of the step, here and at its
    /// end.
    pub state: &'a State,
    /// Forces at the start.
    pub start: &'a Iterate,
    /// Strain energies of the chunks at the start [J], if energy-conserving forces are used.
    pub energies: &'a [f64],
    /// History of the elements at the start, chunk by chunk.
    pub history: &'a [Vec<Row>],
    /// Load times at the start and at the end.
    pub load_times: [LoadTime; 2],
    /// Step size h [s].
    pub h: f64,
    /// Mass-proportional damping [1/s], nonzero only in dynamic relaxation.
    pub damping: f64,
}

impl Step<'_> {
    /// Velocity that brings a prescribed displacement component to its end value [m/s].
    pub fn prescribed_velocity(&self, prescribed: &Prescribed) -> f64 {
        let goal = self.plan.loads.displacement(prescribed, self.load_times[1]);
        (goal - self.state.u[prescribed.node as usize][prescribed.axis]) / self.h
    }

    /// Effective gravity in the step [m/s²].
    pub fn gravity(&self) -> Vec3 {
        let [start, end] = self.load_times.map(|time| loads::gravity(self.plan, time));
        end * self.options.xi + start * (1.0 - self.options.xi)
    }

    /// Increase of gravity in the step [m/s²].
    pub fn growth_of_gravity(&self) -> Vec3 {
        let [start, end] = self.load_times.map(|time| loads::gravity(self.plan, time));
        end - start
    }
}

/// Displacements of the widened middle of the step [m], the energy-conserving forces there [N], and the strain energies of the chunks at the
/// end [J].
#[derive(Default)]
struct Conserving {
    u: Vec<Vec3>,
    f_int: Vec<Vec3>,
    energies: Vec<f64>,
}

/// A trial end of the step.
pub(super) struct Iterate {
    /// v⁺, relative to the rigid-body velocity V [m/s].
    pub v: Vec<Vec3>,
    /// Cᵀ p, the impulses of the contacts on the nodes [N s].
    pub impulse: Vec<Vec3>,
    /// Displacement u⁺ at the end of the step [m].
    pub u: Vec<Vec3>,
    /// Internal forces at u⁺ [N].
    pub f_int: Vec<Vec3>,
    /// Part of them of viscosity and memory; empty if nothing depends on time.
    pub f_rate: Vec<Vec3>,
    /// Velocities of load steps, which are none [m/s]; empty in steps with mass, and if nothing depends on time.
    still: Vec<Vec3>,
    /// Energy-conserving forces; empty if not used.
    conserving: Conserving,
    /// Forces of loads at u⁺ [N].
    pub f_ext: Vec<Vec3>,
    /// `M (v⁺ − v) − h [ξ f⁺ + (1 − ξ) f]` of the unknowns [N s]: the impulse required of the contacts.
    pub residuals: Vec<f64>,
    /// Norm of `residuals − Cᵀ p`, and its reference: `√(Σ r²/m)` [√J].
    pub residual: f64,
    pub scale: f64,
    /// Strain energy of each body, and its part in the stabilisation [J].
    pub strain: Vec<f64>,
    pub hourglass: Vec<f64>,
    /// Part of it in the branches of Prony series and in internal variables; none if nothing depends on time.
    pub branches: Branches,
    /// Smallest J − 1 [-].
    pub smallest_j: f64,
}

impl Iterate {
    pub fn new(plan: &Plan, options: &Implicit) -> Self {
        let nodes = || vec![Vec3::zeros(); plan.node_count()];
        let depends_on_time = options.rate_effects && plan.is_viscous();
        Self {
            v: nodes(),
            impulse: nodes(),
            u: nodes(),
            f_int: nodes(),
            f_rate: if depends_on_time { nodes() } else { Vec::new() },
            still: if depends_on_time && options.statics.is_some() { nodes() } else { Vec::new() },
            conserving: Conserving::default(),
            f_ext: nodes(),
            residuals: vec![0.0; options.unknowns.count()],
            residual: 0.0,
            scale: 0.0,
            strain: vec![0.0; plan.bodies.len()],
            hourglass: vec![0.0; plan.bodies.len()],
            branches: if depends_on_time { Branches::of(plan) } else { Branches::default() },
            smallest_j: f64::INFINITY,
        }
    }

    /// Evaluates everything that follows from v and the impulses. An element that violates its law is an error naming
    /// the element.
    pub fn eval(&mut self, step: &Step, forces: &mut ElementForces) -> Result<(), Failure> {
        let (state, theta) = (step.state, step.options.theta);
        let followers = step.plan.assembly.followers();
        followers.follow(&mut self.v);
        for (node, u) in self.u.iter_mut().enumerate() {
            *u = state.u[node] + (self.v[node] * theta + state.v[node] * (1.0 - theta)) * step.h;
        }
        // Prescribed components follow their displacement: the velocity is the mean of the step.
        for Prescribed { node, axis, .. } in &step.plan.loads.prescribed {
            let node = *node as usize;
            self.u[node][*axis] = state.u[node][*axis] + self.v[node][*axis] * step.h;
        }
        followers.follow(&mut self.u);
        self.evaluate(step.plan, step.threads, step.state, (step.history, step.h), forces)?;
        if step.options.energy_momentum {
            self.conserve(step, forces)?;
        }
        loads::eval_forces(step.plan, &self.u, step.load_times[1], &mut self.f_ext);
        self.weigh(step);
        Ok(())
    }

    /// Evaluates energy-conserving forces, after the forces at u⁺.
    fn conserve(&mut self, step: &Step, forces: &mut ElementForces) -> Result<(), Failure> {
        let Conserving { u, f_int, energies } = &mut self.conserving;
        forces.chunk_energies(energies);
        let ends = [&step.state.u[..], &self.u[..]];
        let narrowing = widen(step.plan, ends, u);
        evaluate_at(u, step.plan, step.threads, forces);
        for (index, block) in step.plan.blocks.iter().enumerate() {
            check_block(step.plan, block, &forces.totals(index), step.state)?;
        }
        forces.conserve(step.threads, &step.plan.blocks, (ends, &narrowing), [step.energies, energies]);
        f_int.clear();
        f_int.extend((0..u.len()).map(|node| forces.at_node(&step.plan.assembly, node)));
        Ok(())
    }

    /// Linearisation point of the step: its end, or its widened middle for energy-conserving forces.
    pub fn tangent_point(&self, step: &Step) -> &[Vec3] {
        if step.options.energy_momentum { &self.conserving.u } else { &self.u }
    }

    /// Velocities of which the forces depend [m/s]; empty if nothing depends on time.
    pub fn velocities(&self) -> &[Vec3] {
        match (self.f_rate.is_empty(), self.still.is_empty()) {
            (true, _) => &[],
            (false, true) => &self.v,
            (false, false) => &self.still,
        }
    }

    /// Internal force of the step on a node [N].
    fn internal(&self, step: &Step, node: usize) -> Vec3 {
        if step.options.energy_momentum {
            return self.conserving.f_int[node];
        }
        self.f_int[node] * step.options.xi + step.start.f_int[node] * (1.0 - step.options.xi)
    }

    /// Evaluates forces and energies at u⁺ and v⁺, a time h [s] after a history; with h = 0 at its own time.
    pub fn evaluate(
        &mut self,
        plan: &Plan,
        threads: &Threads,
        state: &State,
        (history, h): (&[Vec<Row>], f64),
        forces: &mut ElementForces,
    ) -> Result<(), Failure> {
        evaluate_at(&self.u, plan, threads, forces);
        if !self.f_rate.is_empty() {
            let inverse_step = if h > 0.0 { 1.0 / h } else { 0.0 };
            let input = ForceInput { inverse_step, history, ..ForceInput::at(&self.u) };
            forces.add_viscous(threads, &plan.blocks, &input, self.velocities());
            self.branches.evaluate(plan, forces);
        }
        self.strain.fill(0.0);
        self.hourglass.fill(0.0);
        self.smallest_j = f64::INFINITY;
        for (index, block) in plan.blocks.iter().enumerate() {
            let totals = forces.totals(index);
            check_block(plan, block, &totals, state)?;
            self.smallest_j = self.smallest_j.min(totals.smallest_j.0);
            self.strain[block.body] += totals.strain;
            self.hourglass[block.body] += totals.hourglass;
            if !self.f_rate.is_empty() {
                self.strain[block.body] += totals.branches;
            }
        }
        for (node, f) in self.f_int.iter_mut().enumerate() {
            *f = forces.at_node(&plan.assembly, node);
            if let Some(rate) = self.f_rate.get_mut(node) {
                *rate = forces.viscous_at_node(&plan.assembly, node);
                *f += *rate;
            }
        }
        Ok(())
    }

    /// Evaluates the momentum residual, its norm without contact, and the reference of that.
    fn weigh(&mut self, step: &Step) {
        let Step { plan, options, h, .. } = *step;
        let gravity = step.gravity();
        let weight = options.inertia();
        let mut sizes = [0.0; 5];
        let followers = plan.assembly.followers();
        // Reference of the residual: the largest of the contributions to the balance.
        for node in (0..self.v.len()).filter(|node| !followers.contains(*node)) {
            let inertia = plan.inertia(node);
            let parts = [
                self.f_int[node] * h,
                (self.v[node] - step.state.v[node]).component_mul(&inertia) * weight,
                self.impulse[node],
                gravity * (plan.mass[node] * h),
                self.f_ext[node] * h,
            ];
            for (size, part) in sizes.iter_mut().zip(parts) {
                *size += energy(&part, &inertia);
            }
        }
        // Residual of the unknowns.
        let mut residuals = std::mem::take(&mut self.residuals);
        let mut residual = 0.0;
        options.unknowns.for_each(|unknown, node, axis| {
            residuals[unknown] = self.residual_at(step, &gravity, node, axis);
            residual += (residuals[unknown] - self.impulse[node][axis]).powi(2) / plan.inertia(node)[axis];
        });
        self.residuals = residuals;
        self.residual = residual.sqrt();
        let floor = ROUNDING * plan.rounding_energy.sqrt();
        self.scale = sizes.into_iter().fold(0.0, f64::max).sqrt().max(floor);
    }

    /// `m (v⁺ − v) − h f` of a node along an axis [N s]: the impulse required of contact or a support.
    fn residual_at(&self, step: &Step, gravity: &Vec3, node: usize, axis: usize) -> f64 {
        let Step { plan, options, h, .. } = *step;
        let (m, xi) = (plan.inertia(node)[axis], options.xi);
        let internal = self.internal(step, node)[axis];
        let external = xi * self.f_ext[node][axis] + (1.0 - xi) * step.start.f_ext[node][axis];
        let mean = 0.5 * (self.v[node][axis] + step.state.v[node][axis]);
        let force = plan.mass[node] * gravity[axis] - m * step.damping * mean + external - internal;
        options.inertia() * m * (self.v[node][axis] - step.state.v[node][axis]) - h * force
    }

    /// Impulses on the prescribed components [N s], for the ledger; in quasi-static steps from the mean of the forces
    /// at both ends.
    pub fn prescribed_impulses(&self, step: &Step, impulses: &mut [f64]) {
        let gravity = step.gravity();
        let growth = step.growth_of_gravity();
        for (impulse, Prescribed { node, axis, .. }) in impulses.iter_mut().zip(&step.plan.loads.prescribed) {
            let (node, axis) = (*node as usize, *axis);
            *impulse = self.residual_at(step, &gravity, node, axis) - self.impulse[node][axis];
            if step.options.statics.is_some() {
                let contact = (self.impulse[node][axis] - step.start.impulse[node][axis]) / step.h;
                let external = step.plan.mass[node] * growth[axis] + self.f_ext[node][axis]
                    - step.start.f_ext[node][axis]
                    + contact;
                *impulse -= 0.5 * step.h * (self.f_int[node][axis] - step.start.f_int[node][axis] - external);
            }
        }
    }

    /// Strain energy of a body without what memories store [J].
    pub fn elastic(&self, body: usize) -> f64 {
        self.strain[body] - self.branches.of_body(body)
    }

    /// Work of the forces of viscosity and memory on the displacement of the step of a body [J]: by the mean force as in the momentum
    /// balance, in quasi-static steps by that of both ends.
    pub fn rate_work(&self, step: &Step, body: usize) -> f64 {
        let nodes = &step.plan.bodies[body].nodes;
        let weight = if step.options.statics.is_some() { 0.5 } else { step.options.xi };
        let both = self.f_rate.iter().zip(&step.start.f_rate).enumerate();
        let of_body = both.take(nodes.end as usize).skip(nodes.start as usize);
        let work = |(node, (end, start)): (usize, (&Vec3, &Vec3))| {
            (end * weight + start * (1.0 - weight)).dot(&(self.u[node] - step.state.u[node]))
        };
        of_body.map(work).sum()
    }

    /// Energy dissipated by the time integrator in a body in the step, and by viscosity and memory [J]: the work of its internal forces on
    /// the mean velocity minus the change of elastic strain energy.
    pub fn dissipated(&self, step: &Step, body: usize, elastic_before: f64) -> f64 {
        let nodes = &step.plan.bodies[body].nodes;
        let mut work = 0.0;
        if step.options.statics.is_some() {
            return self.left_by_load_step(step, body) - (self.elastic(body) - elastic_before);
        }
        for node in nodes.start as usize..nodes.end as usize {
            work += self.internal(step, node).dot(&(self.v[node] + step.state.v[node]));
        }
        0.5 * step.h * work - (self.elastic(body) - elastic_before)
    }
    /// Work of the internal forces on prescribed nodes of a body in excess of that on their mean velocity [J]: such
    /// nodes move by `h v⁺`, not by `h ½ (v + v⁺)`, which differs where the prescribed rate jumps. Zero in quasi-static
    /// steps.
    pub fn driven_work(&self, step: &Step, body: usize) -> f64 {
        if step.options.statics.is_some() {
            return 0.0;
        }
        let nodes = &step.plan.bodies[body].nodes;
        let of_body = step.plan.loads.prescribed.iter().filter(|p| nodes.contains(&p.node));
        let work = of_body.map(|p| {
            let (node, axis) = (p.node as usize, p.axis);
            self.internal(step, node)[axis] * (self.v[node][axis] - step.state.v[node][axis])
        });
        0.5 * step.h * work.sum::<f64>()
    }

    /// Work of the internal forces of a body in a load step [J], consistent with the work of loads and contact in the ledger: by the mean
    /// of both ends.
    fn left_by_load_step(&self, step: &Step, body: usize) -> f64 {
        let nodes = step.plan.bodies[body].nodes.start as usize..step.plan.bodies[body].nodes.end as usize;
        let growth = step.growth_of_gravity();
        let mut work = 0.0;
        for node in nodes.clone() {
            let external = growth * step.plan.mass[node] + self.f_ext[node] - step.start.f_ext[node];
            let contact = (self.impulse[node] - step.start.impulse[node]) / step.h;
            work += (self.f_int[node] - (external + contact) * 0.5).dot(&self.v[node]);
        }
        for Prescribed { node, axis, .. } in &step.plan.loads.prescribed {
            let (node, axis) = (*node as usize, *axis);
            if nodes.contains(&node) {
                let contact = (self.impulse[node][axis] - step.start.impulse[node][axis]) / step.h;
                let external = growth[axis] * step.plan.mass[node] + self.f_ext[node][axis]
                    - step.start.f_ext[node][axis]
                    + contact;
                let internal = self.f_int[node][axis] - step.start.f_int[node][axis];
                work -= 0.5 * (internal - external) * self.v[node][axis];
            }
        }
        step.h * work
    }

    /// Quasi-static: an unsupported body whose resultant [N] dominates the residual of the equilibrium.
    pub fn pushed(&self, step: &Step) -> Option<(usize, Vec3)> {
        if self.residual < NOTABLE * self.scale {
            return None;
        }
        let gravity = step.gravity();
        let resultant = |body: usize| {
            let nodes = &step.plan.bodies[body].nodes;
            let mut sum = Vec3::zeros();
            for node in nodes.start as usize..nodes.end as usize {
                let residual = Vec3::from_fn(|axis, _| {
                    let is_free = step.plan.inverse_mass[node][axis] > 0.0;
                    if is_free {
                        self.residual_at(step, &gravity, node, axis) - self.impulse[node][axis]
                    } else {
                        0.0
                    }
                });
                sum -= residual;
            }
            sum
        };
        let under_constrained = step.options.statics.iter().flat_map(|statics| &statics.under_constrained);
        let mut pushed = under_constrained
            .map(|under_constrained| (under_constrained.body, resultant(under_constrained.body)));
        // In √J like the residual: the resultant distributed over the body.
        let is_most = |(body, sum): &(usize, Vec3)| {
            sum.norm_squared() / step.plan.bodies[*body].mass > MOST * self.residual * self.residual
        };
        pushed.find(is_most).map(|(body, sum)| (body, sum / step.h))
    }
}

/// Forces and energies of the elements at u [m].
fn evaluate_at(u: &[Vec3], plan: &Plan, threads: &Threads, forces: &mut ElementForces) {
    // Static evaluation: no bulk viscosity.
    let input = ForceInput::at(u);
    forces.evaluate(threads, &plan.blocks, &input);
}

/// Twice the energy of an impulse [N s, or N m s of a spin] on a node at rest [J].
pub(super) fn energy(impulse: &Vec3, inertia: &Vec3) -> f64 {
    impulse.zip_fold(inertia, 0.0, |sum, p, m| sum + p * p / m)
}
