//! The energy ledger: the work done on each body, and the energy balance.
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

use super::motion::Motion;
use super::rigid::RigidWork;
use super::state::State;
use crate::mechanics::contact::stencil::weighted;
use crate::mechanics::contact::{Contact, ContactLaw, ContactPair, Reaction};
use crate::mechanics::force::Activity;
use crate::mechanics::tensor::Vec3;
use crate::plan::Plan;
use serde::Serialize;

/// Relative distance from the friction cone within which a reaction is on it: its contact slides.
const SLIDING: f64 = 1e-9;

/// Relative rounding error of a kinetic energy, with a wide margin [-].
const ROUNDING: f64 = 1e-10;
/// Relative energy error left by the tolerances of the contact solver, of the energy present or dissipated, with a wide
/// margin [-].
const UNDONE: f64 = 1e-4;

/// Running sums of work, part of the state.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Ledger {
    /// Energy dissipated by bulk and shear viscosity in each body [J].
    pub viscous: Vec<f64>,
    /// Strain energy removed with the eroded elements of each body [J].
    pub eroded: Vec<f64>,
    /// Energy dissipated by the time integrator in each body [J]: implicit steps with θ > ½; negative if created. For
    /// quasi-static load steps, the difference between the work along the path and the work of the end forces.
    pub algorithmic: Vec<f64>,
    /// Work of external forces (gravity, loads, prescribed motion) on each body, with the contribution of the first
    /// half step [J].
    pub external: Vec<f64>,
    /// Work of the contact reactions on each body [J].
    pub contact_work: Vec<f64>,
    /// Strain energy introduced by the position projection in each body [J].
    pub projection: Vec<f64>,
    /// One entry for each contact pair.
    pub pairs: Vec<PairLedger>,
    /// Kinetic + strain energy at the start [J]; set by the first step.
    pub initial: Option<f64>,
    /// Kinetic energy in the frame of the support, plus strain energy [J]: the energy available to an impact.
    pub at_hand: f64,
    /// Part of it that rounding and tolerances may have produced so far [J].
    pub stirred: f64,
    /// Available energy at the start, or when a pair first touched: the energy scale of the impact [J].
    pub available: f64,
    /// Number of pairs that have touched.
    pub touched: usize,
    /// Largest total strain energy so far [J].
    pub peak_strain: f64,
}

/// Running sums of one contact pair.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct PairLedger {
    /// Impulse on the slave so far [N s], x, y, z.
    pub impulse_n_s: [f64; 3],
    /// Energy dissipated by friction so far [J].
    pub friction_j: f64,
    /// Numerical contact dissipation so far: loss of lumped contact nodes at impact activation [J].
    pub numerical_j: f64,
    /// Energy lost so far by rigid bodies stopped by a plane or by each other, according to their impact law: they do
    /// not rebound [J].
    pub impact_j: f64,
    /// Work on the slave's body so far [J].
    pub work_on_slave_j: f64,
    /// Work on the master's body so far [J].
    pub work_on_master_j: f64,
}

/// Energies and momenta of one body at t_n.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct BodyEnergy {
    /// Kinetic energy, `½ v₋ᵀ M v₊` including the flight velocity, and the rotation of a rigid body [J].
    pub kinetic_j: f64,
    /// Strain energy, ∫ψ dV, including that of the stabilisation of one-point elements and of Prony series branches
    /// [J].
    pub strain_j: f64,
    /// Part of the strain energy in the stabilisation [J]; 0 in formulations that need none.
    pub hourglass_j: f64,
    /// Part of the strain energy in the branches of Prony series [J], less what is lost by softening.
    pub branches_j: f64,
    /// Energy dissipated by bulk and shear viscosity, relaxation and softening so far [J].
    pub viscous_j: f64,
    /// Strain energy removed with eroded elements so far [J].
    pub eroded_j: f64,
    /// Energy dissipated by the time integrator so far, negative if created [J]; 0 in explicit runs.
    pub algorithmic_j: f64,
    /// Work of the contact reactions on the body so far [J].
    pub contact_work_j: f64,
    /// Work of external forces on the body so far, with the contribution of the first half step [J].
    pub external_work_j: f64,
    /// Strain energy introduced by the position projection so far [J].
    pub projection_j: f64,
    /// Linear momentum [kg m/s].
    pub momentum_kg_m_per_s: [f64; 3],
}

/// The ledger at t_n.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Energy {
    /// One entry for each body.
    pub bodies: Vec<BodyEnergy>,
    /// One entry for each contact pair.
    pub pairs: Vec<PairLedger>,
    /// Sum of kinetic and strain energy and of all dissipation: viscous, erosion, algorithmic, friction, impact,
    /// numerical contact [J].
    pub total_j: f64,
    /// Kinetic and strain energy at the start [J].
    pub initial_total_j: f64,
    /// Work of external forces and of the position projection so far [J].
    pub external_work_j: f64,
    /// Energy scale of the impact, to which errors are related [J]: the maximum of K + strain at the start, K + strain
    /// when a pair first touched, and the peak strain energy; at least the level of rounding. K refers to the frame of
    /// the supports, or else of the common centre of mass, so errors do not depend on the observer. A long fall or
    /// slide does not increase it.
    pub scale_j: f64,
    /// The scale, or the total dissipation if that is larger [J]: reference for losses that accumulate over time.
    pub turnover_j: f64,
    /// |total − initial − external| / scale [-].
    pub balance_error: f64,
    /// Linear momentum [kg m/s].
    pub momentum_kg_m_per_s: [f64; 3],
    /// Angular momentum about the origin [kg m²/s].
    pub angular_momentum_kg_m2_per_s: [f64; 3],
}

impl Energy {
    /// A zero ledger with capacity for the bodies and pairs of a plan.
    pub fn with_capacity(plan: &Plan) -> Self {
        let pairs = plan.contact.as_ref().map_or(0, |c| c.pairs.len());
        let (bodies, pairs) = (Vec::with_capacity(plan.bodies.len()), Vec::with_capacity(pairs));
        Self { bodies, pairs, ..Self::default() }
    }
    /// Copies `other` into the existing buffers.
    pub fn copy_from(&mut self, other: &Self) {
        let (mut bodies, mut pairs) = (std::mem::take(&mut self.bodies), std::mem::take(&mut self.pairs));
        bodies.clone_from(&other.bodies);
        pairs.clone_from(&other.pairs);
        *self = Self { bodies, pairs, ..*other };
    }
    /// Kinetic + strain energy of a body, plus its dissipation by viscosity, erosion and the time integrator [J].
    pub fn of_body(&self, body: usize) -> f64 {
        let b = &self.bodies[body];
        b.kinetic_j + b.strain_j + b.viscous_j + b.eroded_j + b.algorithmic_j
    }
    /// Energy dissipated by the time integrator in all bodies [J].
    pub fn algorithmic_j(&self) -> f64 {
        self.bodies.iter().map(|b| b.algorithmic_j).sum()
    }
    /// Numerical contact dissipation of all pairs [J].
    pub fn numerical_contact_j(&self) -> f64 {
        self.pairs.iter().map(|p| p.numerical_j).sum()
    }
    /// Energy lost by impacts of rigid bodies, all pairs [J].
    pub fn impact_j(&self) -> f64 {
        self.pairs.iter().map(|p| p.impact_j).sum()
    }
}

/// Everything that the ledger needs of the step around t_n.
#[derive(Clone, Copy)]
pub(super) struct StepWork<'a> {
    pub plan: &'a Plan,
    pub state: &'a State,
    pub v_after: &'a [Vec3],
    /// Mean step h̄ [s].
    pub mean_step: f64,
    /// h₊ − h₋ [s]; 0 if velocities are known at t_n itself.
    pub step_change: f64,
    /// Internal forces at t_n [N], nodes × 3; not used if the step size does not change.
    pub f_int: &'a [Vec3],
    pub contacts: &'a [Contact],
    pub reactions: &'a [Reaction],
    /// Whether this is a quasi-static load step: work of the end reactions along it is no contact loss.
    pub is_static: bool,
    /// Effective gravity in the step [m/s²].
    pub gravity: Vec3,
    /// Forces of loads in the step [N], nodes × 3; empty when there are none.
    pub f_ext: &'a [Vec3],
    /// Impulses on the prescribed components of the plan, one each [N s].
    pub prescribed: &'a [f64],
    /// Strain energy of each body at t_n [J].
    pub strain: &'a [f64],
    /// Part of it in the stabilisation [J].
    pub hourglass: &'a [f64],
    /// Part of it in the branches of Prony series [J]; empty if there are none.
    pub branches: &'a [f64],
    /// Nodes that move relative to their bodies' flight.
    pub activity: &'a Activity,
    /// Rigid bodies, if there are any.
    pub rigid: Option<RigidWork<'a>>,
}

impl StepWork<'_> {
    /// Part of a body's strain energy in the branches of Prony series [J].
    fn branches_of(&self, body: usize) -> f64 {
        self.branches.get(body).copied().unwrap_or_default()
    }
    /// The same before any work is done: the initial velocities stand on both sides.
    pub fn at_the_start(&self) -> Self {
        Self { v_after: &self.state.v, step_change: 0.0, ..*self }
    }
}

/// Which half of the work at t_n is counted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Half {
    /// The half with v₋, before t_n.
    Before,
    /// The half with v₊, after t_n.
    After,
}

impl Ledger {
    /// A zero ledger for the bodies and pairs of a plan.
    pub fn new(plan: &Plan) -> Self {
        let bodies = plan.bodies.len();
        let pairs = plan.contact.as_ref().map_or(0, |c| c.pairs.len());
        Self {
            viscous: vec![0.0; bodies],
            eroded: vec![0.0; bodies],
            algorithmic: vec![0.0; bodies],
            external: vec![0.0; bodies],
            contact_work: vec![0.0; bodies],
            projection: vec![0.0; bodies],
            pairs: vec![PairLedger::default(); pairs],
            ..Self::default()
        }
    }

    /// Copies `other` into the existing buffers.
    pub(super) fn copy_from(&mut self, other: &Self) {
        let Self {
            viscous,
            eroded,
            algorithmic,
            external,
            contact_work,
            projection,
            pairs,
            initial,
            at_hand,
            stirred,
            available,
            touched,
            peak_strain,
        } = self;
        viscous.clone_from(&other.viscous);
        eroded.clone_from(&other.eroded);
        algorithmic.clone_from(&other.algorithmic);
        external.clone_from(&other.external);
        contact_work.clone_from(&other.contact_work);
        projection.clone_from(&other.projection);
        pairs.clone_from(&other.pairs);
        (*initial, *touched, *peak_strain) = (other.initial, other.touched, other.peak_strain);
        (*at_hand, *stirred, *available) = (other.at_hand, other.stirred, other.available);
    }

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
    pub(super) fn add_viscous(&mut self, plan: &Plan, state: &State, activity: &Activity, now: &[Vec3]) {
        if now.is_empty() {
            return;
        }
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
        plan: &crate::plan::ContactPlan,
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
        let (slave_body, master_body) = plan.pair_bodies[contact.pair as usize];
        let flight =
            |body: Option<usize>| body.map_or(Vec3::zeros(), |b| work.plan.bodies[b].flight_velocity);
        let turning =
            |side: usize| work.rigid.map_or_else(Vec3::zeros, |rigid| rigid.velocity(contact, side, v));
        let has_rigid_side = contact.pair as usize >= plan.mesh_pairs;
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
        let slides = p_1.hypot(p_2) >= plan.pairs[contact.pair as usize].law.mu() * p_n * (1.0 - SLIDING);
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
        let pair = &mut self.pairs[contact.pair as usize];
        for (sum, p) in pair.impulse_n_s.iter_mut().zip(&impulse) {
            *sum += 0.5 * p;
        }
        pair.work_on_slave_j += on_slave;
        pair.work_on_master_j += on_master;
        pair.friction_j += friction;
        // What is lost beyond friction is an impact of rigid bodies, an error of a load step, or numerical dissipation.
        let lost = -(on_slave + on_master + friction);
        if has_rigid_side && work.rigid.is_some_and(|r| r.plan.has_no_mesh(plan, contact.pair as usize)) {
            pair.impact_j += lost;
        } else if work.is_static {
            self.algorithmic[slave_body] += lost;
        } else {
            pair.numerical_j += lost;
        }
    }

    /// Writes the ledger at t_n to `energy`; to be called between the two halves.
    pub(super) fn balance(&mut self, work: &StepWork, motion: &Motion, energy: &mut Energy) {
        energy.bodies.clear();
        energy.pairs.clone_from(&self.pairs);
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
                branches_j: work.branches_of(b),
                viscous_j: self.viscous[b] - work.branches_of(b),
                eroded_j: self.eroded[b],
                algorithmic_j: self.algorithmic[b],
                contact_work_j: self.contact_work[b],
                external_work_j: self.external[b],
                projection_j: self.projection[b],
                momentum_kg_m_per_s: own.into(),
            });
        }
        energy.momentum_kg_m_per_s = momentum.into();
        energy.angular_momentum_kg_m2_per_s = angular.into();
        self.close(work, energy);
    }

    fn dissipated(&self) -> f64 {
        let pairs =
            self.pairs.iter().map(|p| p.friction_j + p.numerical_j.abs() + p.impact_j.abs()).sum::<f64>();
        let algorithmic = self.algorithmic.iter().map(|a| a.abs()).sum::<f64>();
        self.viscous.iter().chain(&self.eroded).sum::<f64>() + pairs + algorithmic
    }

    /// Energy scale, see [`Energy::scale_j`].
    pub fn scale(&self, plan: &Plan) -> f64 {
        let stirred = self.stirred.max(UNDONE * self.dissipated()).max(plan.rounding_energy);
        self.available.max(self.peak_strain).max(stirred)
    }

    /// Energy scale or total dissipation, see [`Energy::turnover_j`].
    pub fn turnover(&self, plan: &Plan) -> f64 {
        self.scale(plan).max(self.dissipated())
    }

    /// Updates the energy available to an impact [J], and at the first touch of a pair, that of the previous step;
    /// `kinetic` is the kinetic energy in the frame of the support [J].
    fn note_at_hand(&mut self, at_hand: f64, kinetic: f64) {
        let has_touched = |pair: &&PairLedger| pair.impulse_n_s.iter().any(|p| *p != 0.0);
        let touched = self.pairs.iter().filter(has_touched).count();
        if self.initial.is_none() {
            self.available = at_hand;
        } else if touched > self.touched {
            self.available = self.available.max(self.at_hand);
        }
        self.touched = touched;
        self.at_hand = at_hand;
        self.stirred = self.stirred.max(UNDONE * at_hand).max(ROUNDING * kinetic);
    }

    /// Evaluates the totals and the error of the balance.
    fn close(&mut self, work: &StepWork, energy: &mut Energy) {
        let strain: f64 = work.strain.iter().sum();
        let kinetic: f64 = energy.bodies.iter().map(|b| b.kinetic_j).sum();
        self.peak_strain = self.peak_strain.max(strain);
        self.note_at_hand(kinetic - common_motion(work, energy) + strain, kinetic);
        let initial = *self.initial.get_or_insert(kinetic + strain);
        let viscous: f64 = self.viscous.iter().sum::<f64>() - work.branches.iter().sum::<f64>();
        let friction: f64 = self.pairs.iter().map(|p| p.friction_j).sum();
        let numerical: f64 = self.pairs.iter().map(|p| p.numerical_j).sum();
        let impact: f64 = self.pairs.iter().map(|p| p.impact_j).sum();
        let algorithmic: f64 = self.algorithmic.iter().sum();
        let eroded: f64 = self.eroded.iter().sum();
        energy.total_j = kinetic + strain + viscous + eroded + friction + numerical + impact + algorithmic;
        energy.initial_total_j = initial;
        energy.external_work_j = self.external.iter().sum::<f64>() + self.projection.iter().sum::<f64>();
        (energy.scale_j, energy.turnover_j) = (self.scale(work.plan), self.turnover(work.plan));
        energy.balance_error = (energy.total_j - initial - energy.external_work_j).abs() / energy.scale_j;
    }
}

/// Contact laws during dynamic relaxation: full stick.
pub(super) fn stuck(pairs: &[ContactPair]) -> Vec<ContactLaw> {
    vec![ContactLaw::Coulomb(f64::INFINITY); pairs.len()]
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
