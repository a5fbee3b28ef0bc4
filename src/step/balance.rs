//! The energy balance: the work of each step goes to the ledger, and the ledger is balanced at every t_n.
//!
//! With velocities at half steps, `K_n = ½ v₋ᵀ M v₊` and the strain energy at t_n, the sum `K + U` of a linear body
//! without contact is conserved exactly. The work of forces acting at t_n (contact, gravity) is `h̄ fᵀ ½(v₋ + v₊)`: the
//! part with v₋ belongs to the time before t_n, the part with v₊ to the time after. At t_n half of it is therefore
//! counted.
//!
//! If the steps before and after t_n differ, forces act over h̄ = ½(h₋ + h₊), but strain energy is the work of internal
//! forces over h₋ and h₊. The difference at t_n, `¼ (h₊ − h₋) f_intᵀ ½(v₋ + v₊)`, is counted as kinetic energy: the
//! remaining effect of a change of step is of second order, the change of the energy conserved with equal steps.
//!
//! The energy at t_0, `½ v_0ᵀ M v_0 + U_0`, differs from the sum conserved from t_1 on by the contribution of the first
//! half step, `½ h̄ f_intᵀ (v_½ − v_0)`: zero for initially unstrained bodies, of second order in the step for others.
//! It is no error of the motion, which starts from the exact position and velocity, but of evaluating at t_n quantities
//! defined at half steps; it is therefore booked as external work.
use super::branches::Branches;
use super::energy::{BodyEnergy, BranchEnergy, Energy, PairLedger};
use super::ledger::Ledger;
use super::motion::Motion;
use super::state::State;
use super::step_work::{Half, StepWork};
use crate::mechanics::contact::stencil::weighted;
use crate::mechanics::contact::{Contact, Reaction};
use crate::mechanics::force::Activity;
use crate::mechanics::tensor::Vec3;
use crate::plan::{ContactPlan, Plan};

/// Relative distance from the friction cone within which a reaction is on it: its contact slides.
const SLIDING: f64 = 1e-9;

impl Ledger {
    /// Adds one half of the work of the forces at t_n.
    pub(super) fn add_work(&mut self, work: &StepWork, half: Half) {
        let v = match half {
            Half::Before => &work.state.v[..],
            Half::After => work.v_after,
        };
        self.add_external(work, v);
        if let Some(contact) = &work.plan.contact {
            for (contact_point, reaction) in work.contacts.iter().zip(work.reactions) {
                self.add_contact(work, contact, contact_point, reaction, v);
            }
        }
    }

    /// Adds the work of gravity, of loads, and of prescribed motion.
    fn add_external(&mut self, work: &StepWork, v: &[Vec3]) {
        let has_forces = !work.f_ext.is_empty();
        if work.plan.gravity.is_none() && !has_forces && work.prescribed.is_empty() {
            return;
        }
        for (b, body) in work.plan.bodies.iter().enumerate() {
            let mut power = 0.0;
            for node in body.nodes.start as usize..body.nodes.end as usize {
                // Fixed components do not move: their velocity, flight included, is zero.
                let velocity = v[node] + body.flight_velocity;
                power += work.plan.mass[node] * work.gravity.dot(&velocity);
                if has_forces {
                    power += work.f_ext[node].dot(&velocity);
                }
            }
            self.external[b] += 0.5 * work.mean_step * power;
        }
        for (prescribed, impulse) in work.plan.loads.prescribed.iter().zip(work.prescribed) {
            let half = 0.5 * impulse * v[prescribed.node as usize][prescribed.axis];
            self.external[work.plan.body_of_node(prescribed.node)] += half;
        }
    }

    /// Adds the contribution of the first half step, the difference of the energy at t_0 and the conserved sum, from
    /// the internal forces [N].
    pub(super) fn add_first_half_step(&mut self, work: &StepWork, f_int: &[Vec3]) {
        for (b, body) in work.plan.bodies.iter().enumerate() {
            let nodes = body.nodes.start as usize..body.nodes.end as usize;
            let left: f64 = nodes.map(|a| f_int[a].dot(&(work.v_after[a] - work.state.v[a]))).sum();
            self.external[b] += 0.5 * work.mean_step * left;
        }
    }

    /// Adds the work of viscous and memory forces in the step to t_n: the mean of the forces [N] at both ends, those at
    /// t_n in `now` (nodes × 3, empty without viscosity), times the displacement, shifts included.
    /// The same of each branch of relaxation.
    pub(super) fn add_viscous(
        &mut self,
        plan: &Plan,
        state: &State,
        activity: &Activity,
        (now, branches): (&[Vec3], &Branches),
    ) {
        if now.is_empty() {
            return;
        }
        self.add_branch_work(branches, 0.5);
        let mean = |node: usize| (state.viscous_force[node] + now[node]) * 0.5;
        for (sum, body) in self.viscous.iter_mut().zip(&plan.bodies) {
            let power = |node: usize| mean(node).dot(&state.v[node]);
            *sum += state.last_step * activity.stepped(body.nodes.clone()).map(power).sum::<f64>();
        }
        for (node, shift) in &state.projected {
            self.viscous[plan.body_of_node(*node)] += mean(*node as usize).dot(shift);
        }
    }

    /// Adds half of the strain energy introduced by nodal shifts, from the internal forces [N] at one end of the step.
    ///
    /// With the forces at both ends the balance of a linear body is exact: the step's strain energy is the mean of both
    /// times the total displacement, while the velocity does not include the shift.
    pub(super) fn add_projection(&mut self, plan: &Plan, shifts: &[(u32, Vec3)], f_int: &[Vec3]) {
        for (node, du) in shifts {
            self.projection[plan.body_of_node(*node)] += 0.5 * f_int[*node as usize].dot(du);
        }
    }

    /// Adds `sign` times the strain energy of the bodies [J] on one side of a position projection: subtracted before
    /// and added after, the sum is the energy introduced by the projection.
    pub(super) fn add_strain_of_projection(&mut self, strain: &[f64], sign: f64) {
        for (sum, strain) in self.projection.iter_mut().zip(strain) {
            *sum += sign * strain;
        }
    }

    fn add_contact(
        &mut self,
        work: &StepWork,
        plan: &ContactPlan,
        contact: &Contact,
        reaction: &Reaction,
        v: &[Vec3],
    ) {
        let [p_n, p_1, p_2] = reaction.impulse;
        if p_n == 0.0 && p_1 == 0.0 && p_2 == 0.0 {
            return;
        }
        // Velocities of both sides at the contact point, with flight and rotation.
        let [n, t1, t2] = &contact.frame;
        let impulse = n * p_n + t1 * p_1 + t2 * p_2;
        let sides = plan.pairs.get(contact.pair as usize);
        let (slave_body, master_body) = plan.bodies_of(&sides);
        let flight =
            |body: Option<usize>| body.map_or(Vec3::zeros(), |b| work.plan.bodies[b].flight_velocity);
        let turning =
            |side: usize| work.rigid.map_or_else(Vec3::zeros, |rigid| rigid.velocity(contact, side, v));
        let has_rigid_side = contact.pair as usize >= plan.pairs.mesh_count();
        let turning = if has_rigid_side { [turning(0), turning(1)] } else { [Vec3::zeros(); 2] };
        let stencil = &contact.stencil;
        let master_v =
            |v: &[Vec3]| flight(master_body) - weighted(stencil.master(), |n| v[n as usize]) + turning[1];
        let slave_v =
            |v: &[Vec3]| weighted(stencil.slave(), |n| v[n as usize]) + flight(Some(slave_body)) + turning[0];

        // Work on both sides and friction dissipation, half of each.
        let on_slave = 0.5 * impulse.dot(&slave_v(v));
        let on_master = if master_body.is_some() { -0.5 * impulse.dot(&master_v(v)) } else { 0.0 };
        // A sliding contact dissipates by its mean slip, consistent with its work by the mean velocity: with the end
        // velocity alone every change of the slip velocity would be miscounted as numerical dissipation of either sign.
        // The energy that a contact sticking at the end takes from the slip before is numerical: impact activation of a
        // lumped node.
        let slides = p_1.hypot(p_2) >= contact.law.mu() * p_n * (1.0 - SLIDING);
        let friction = if slides {
            let slip = slave_v(v) - if master_body.is_some() { master_v(v) } else { Vec3::zeros() };
            -0.5 * (p_1 * t1.dot(&slip) + p_2 * t2.dot(&slip))
        } else {
            0.0
        };

        // Book the contributions of bodies and pair.
        self.contact_work[slave_body] += on_slave;
        if let Some(b) = master_body {
            self.contact_work[b] += on_master;
        }
        let pair = self.pairs.of(contact.pair as usize, PairLedger::default);
        for (sum, p) in pair.impulse_n_s.iter_mut().zip(&impulse) {
            *sum += 0.5 * p;
        }
        pair.work_on_slave_j += on_slave;
        pair.work_on_master_j += on_master;
        pair.friction_j += friction;
        // What is lost beyond friction is an impact of rigid bodies, or numerical: in load steps of either sign.
        let lost = -(on_slave + on_master + friction);
        if has_rigid_side && work.rigid.is_some_and(|r| r.plan.has_no_mesh(plan, contact.pair as usize)) {
            pair.impact_j += lost;
        } else {
            pair.numerical_j += lost;
        }
    }

    /// Writes the ledger at t_n to `energy`; to be called between the two halves.
    pub(super) fn balance(&mut self, work: &StepWork, motion: &Motion, energy: &mut Energy) {
        energy.bodies.clear();
        energy.pairs.copy_from(&self.pairs);
        let (mut momentum, mut angular) = (Vec3::zeros(), Vec3::zeros());
        for (b, body) in work.plan.bodies.iter().enumerate() {
            // Flight of the body as a whole, and motion of its nodes relative to it.
            let (flight, sums) = (body.flight_velocity, motion.of_body(b));
            let own = flight * body.mass + sums.momentum;
            momentum += own;
            angular += sums.angular + (body.first_moment + sums.shift).cross(&flight);
            let mut kinetic =
                sums.kinetic + body.mass * flight.norm_squared() + 2.0 * flight.dot(&sums.momentum);
            if let (Some(index), Some(rigid)) = (body.rigid, work.rigid) {
                let (energy, moment) = rigid.rotation(index, &work.state.v, work.v_after);
                kinetic += energy;
                angular += moment;
            }
            energy.bodies.push(BodyEnergy {
                kinetic_j: 0.5 * kinetic,
                strain_j: work.strain[b],
                hourglass_j: work.hourglass[b],
                branches_j: work.branches.of_body(b),
                viscous_j: self.viscous[b] - work.branches.of_body(b),
                eroded_j: self.eroded[b],
                algorithmic_j: self.algorithmic[b],
                contact_work_j: self.contact_work[b],
                external_work_j: self.external[b],
                projection_j: self.projection[b],
                momentum_kg_m_per_s: own.into(),
            });
        }
        energy.branches.clear();
        energy.branches.extend(work.branches.list().iter().zip(&self.branches).map(|(branch, work)| {
            BranchEnergy {
                body: branch.body,
                relaxation_time_s: branch.relaxation_time,
                stored_j: branch.totals.stored,
                dissipated_j: work - branch.totals.stored,
            }
        }));
        energy.momentum_kg_m_per_s = momentum.into();
        energy.angular_momentum_kg_m2_per_s = angular.into();
        self.close(work, energy);
    }

    /// Evaluates the totals and the error of the balance.
    fn close(&mut self, work: &StepWork, energy: &mut Energy) {
        let strain: f64 = work.strain.iter().sum();
        let kinetic: f64 = energy.bodies.iter().map(|b| b.kinetic_j).sum();
        self.peak_strain = self.peak_strain.max(strain);
        self.note_at_hand(kinetic - common_motion(work, energy) + strain, kinetic);
        let initial = *self.initial.get_or_insert(kinetic + strain);
        let viscous: f64 = self.viscous.iter().sum::<f64>() - work.branches.of_bodies().iter().sum::<f64>();
        let friction: f64 = self.pairs.values().map(|p| p.friction_j).sum();
        let numerical: f64 = self.pairs.values().map(|p| p.numerical_j).sum();
        let impact: f64 = self.pairs.values().map(|p| p.impact_j).sum();
        let algorithmic: f64 = self.algorithmic.iter().sum();
        let eroded: f64 = self.eroded.iter().sum();
        energy.total_j = kinetic + strain + viscous + eroded + friction + numerical + impact + algorithmic;
        energy.initial_total_j = initial;
        energy.external_work_j = self.external.iter().sum::<f64>() + self.projection.iter().sum::<f64>();
        (energy.scale_j, energy.turnover_j) = (self.scale(work.plan), self.turnover(work.plan));
        energy.balance_error = (energy.total_j - initial - energy.external_work_j).abs() / energy.scale_j;
    }
}

/// Part of the kinetic energy due to the motion of the supports' frame, or else of the common centre of mass [J].
fn common_motion(work: &StepWork, energy: &Energy) -> f64 {
    let mass: f64 = work.plan.bodies.iter().map(|body| body.mass).sum();
    let held = work.plan.holder.velocity(&work.plan.loads, work.state.time);
    let momentum = energy.momentum_kg_m_per_s;
    // ½ Σ m v² = ½ Σ m (v − V)² + V·p − ½ m V²
    let along = |(p, held): (&f64, &Option<f64>)| {
        let v = held.unwrap_or(p / mass);
        v * (p - 0.5 * mass * v)
    };
    momentum.iter().zip(&held).map(along).sum()
}
