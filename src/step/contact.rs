//! Contact in a step: detection, the bi-potential law on the end-of-step gap, projection.

use super::failure::FailureCause;
use super::phase::Phase;
use super::rigid::RigidStep;
use super::state::SHIFTS;
use crate::mechanics::contact::detection::detector::Motion;
use crate::mechanics::contact::detection::detectors::{ContactModel, Detectors};
use crate::mechanics::contact::projection::meshes::{MovableNodes, project_positions};
use crate::mechanics::contact::projection::rigid::RigidProjection;
use crate::mechanics::contact::solution::gauss_seidel::{self, Options, Workspace};
use crate::mechanics::contact::solution::problem::ProblemError;
use crate::mechanics::contact::solution::solvers::{self, Method, SolveReport};
use crate::mechanics::contact::solution::step_problem::{solve_step, take_off};
use crate::mechanics::contact::stencil::MOST_NODES;
use crate::mechanics::contact::{Contact, ContactLaw, Reaction, RigidSides, Surface};
use crate::mechanics::force::{Erosion, Threads};
use crate::mechanics::rigid::{Pose, RigidBody, rotated};
use crate::mechanics::tensor::Vec3;
use crate::plan::{ContactPlan, Plan};
use std::borrow::Cow;

/// Gauss–Seidel sweeps after which the solver counts as not converging.
const MOST_SWEEPS: usize = 2000;
/// Scaled residual above which a step fails; between the scene's tolerance and this it is counted and raises a warning.
const LARGEST_RESIDUAL: f64 = 1e-4;
/// The same relative to the motion, which impulses on light bodies exceed by far. Impulses that exceed it without a bound cannot stop
/// what approaches.
const LARGEST_OF_MOTION: f64 = 1e-3;
/// The same relative to the free velocities alone: the motion is that of the heavy body where it lies on a light one.
const LARGEST_OF_FREE: f64 = 1e-2;

/// Whether residuals relative to the motion and to the free velocities are small enough for a step.
fn are_small([of_motion, of_free]: [f64; 2]) -> bool {
    of_motion <= LARGEST_OF_MOTION && of_free <= LARGEST_OF_FREE
}

/// Number of contacts up to which forming W costs no more than slow sweeps.
const FEW: usize = 100;
/// Sweeps over so few contacts before Newton's method takes over, and its maximum number of iterations.
const FEW_SWEEPS: usize = 200;
const NEWTON_STEPS: usize = 60;

/// Detectors and work arrays of the contact solve; derived from the plan and the positions, so not part of the state.
pub(super) struct ContactStep<'p> {
    plan: &'p ContactPlan,
    threads: Threads,
    /// Contact surfaces of the plan, as left by erosion.
    surfaces: Cow<'p, [Surface]>,
    detectors: Detectors,
    x_end: Vec<Vec3>,
    poses_end: Vec<Pose>,
    contacts: Vec<Contact>,
    reactions: Vec<Reaction>,
    workspace: Workspace,
    moved: Vec<(u32, Vec3)>,
    /// If a pair has a rigid side.
    rigid_projection: Option<RigidProjection>,
    /// Solves that ended above the scene's tolerance: their number, and the largest residual.
    pub unconverged: (u64, f64),
}

/// Failure cause and message for a step whose numbers define no contact problem.
pub(super) fn no_problem(error: ProblemError) -> (FailureCause, String) {
    (FailureCause::NotFinite, format!("The contact problem is invalid: {error}."))
}

/// The detectors of a plan, for its contact surfaces as left by erosion.
fn detectors(plan: &Plan, contact: &ContactPlan, surfaces: &[Surface], threads: &Threads) -> Detectors {
    let model = ContactModel {
        surfaces,
        pairs: &contact.pairs,
        rigid: plan.rigid.as_ref().map_or(&[], |rigid| &rigid.bodies),
        discretisation: contact.discretisation,
        always_searches_self_contact: contact.always_searches_self_contact,
        x: &plan.X,
    };
    Detectors::new(&model, contact.most_rigid_contacts(), threads)
}

impl<'p> ContactStep<'p> {
    pub fn new(plan: &'p Plan, contact: &'p ContactPlan, threads: &Threads) -> Self {
        // Capacity for every slave node at once: untouched pages cost nothing.
        let most = contact.most_contacts();
        let surfaces = Cow::Borrowed(&contact.surfaces[..]);
        let most_rigid = contact.most_rigid_contacts();
        let has_rigid = !contact.pairs.rigid().0.is_empty();
        Self {
            plan: contact,
            threads: threads.clone(),
            detectors: detectors(plan, contact, &surfaces, threads),
            poses_end: Vec::with_capacity(contact.rigid_body.len()),
            x_end: vec![Vec3::zeros(); plan.node_count()],
            contacts: Vec::with_capacity(most),
            reactions: Vec::with_capacity(most),
            workspace: Workspace::with_capacity(contact.most_mesh_contacts(), most_rigid),
            moved: Vec::with_capacity(SHIFTS * most),
            rigid_projection: has_rigid.then(|| RigidProjection::new(plan.node_count(), most_rigid)),
            surfaces,
            unconverged: (0, 0.0),
        }
    }

    /// Contact surfaces as left by erosion.
    pub fn surfaces(&self) -> &[Surface] {
        &self.surfaces
    }

    /// Accounts for eroded elements: the surfaces they expose become contact surfaces.
    pub fn expose(&mut self, plan: &'p Plan, erosion: &Erosion) {
        let of_body = |body: &usize| plan.bodies[*body].boundary_after(erosion).into_owned();
        self.surfaces = self.plan.surface_body.iter().map(of_body).collect();
        self.detectors = detectors(plan, self.plan, &self.surfaces, &self.threads);
    }

    /// Finds the contacts that may close within the step and changes `v` from v* to v₊; including the bodies' flight
    /// velocities in flight, with full stick during dynamic relaxation.
    pub fn solve(
        &mut self,
        plan: &Plan,
        rigid: Option<&RigidStep>,
        x: &[Vec3],
        h: f64,
        phase: Phase,
        v: &mut [Vec3],
    ) -> Result<(), (FailureCause, String)> {
        self.detect(plan, rigid, x, h, phase, v)?;
        let sides = rigid.map_or(RigidSides::NONE, |rigid| rigid.work().sides);
        let masses = (&plan.inverse_mass[..], &sides);
        let Some(method) = self.plan.solver else { return self.solve_by_sweeps(masses, h, phase, v) };
        self.reactions.clear();
        self.reactions.resize(self.contacts.len(), Reaction::default());
        self.solve_as_problem(method, None, masses, h, v)
    }

    /// Gauss–Seidel, and Newton's method if its sweeps do not converge.
    fn solve_by_sweeps(
        &mut self,
        masses: (&[Vec3], &RigidSides),
        h: f64,
        phase: Phase,
        v: &mut [Vec3],
    ) -> Result<(), (FailureCause, String)> {
        // Small sets of contacts get few sweeps, since Newton's method is cheap for them.
        let has_mesh = |c: &Contact| masses.1.of_pair(c.pair)[0].is_none();
        let is_few = self.contacts.len() <= FEW && self.contacts.iter().all(has_mesh) && !phase.sticks();
        let max_sweeps = if is_few { FEW_SWEEPS } else { MOST_SWEEPS };
        let options = Options { tolerance: self.plan.tolerance, max_sweeps, acceptable: LARGEST_RESIDUAL };
        let report = gauss_seidel::solve_with_rigid(
            &self.contacts,
            masses.1,
            masses.0,
            h,
            v,
            &mut self.reactions,
            &options,
            &mut self.workspace,
        );
        if report.converged {
            return Ok(());
        }
        // With friction at several contacts that share nodes, sweeps may cycle for ever: Newton's method solves it. If
        // the sweeps came close, and Newton's method fails, the best iterate is accepted.
        let is_small = report.residual <= LARGEST_RESIDUAL;
        // A heavy body on a light one has impulses so large that a small residual says nothing about what they stop.
        let of_velocities = [report.residual_of_motion, report.residual_of_free];
        let is_near = is_small && are_small(of_velocities);
        if (is_few || !is_near) && !phase.sticks() {
            take_off(&self.contacts, &self.reactions, masses, h, v);
            let most = is_small.then_some(NEWTON_STEPS);
            return self.solve_as_problem(Method::default(), most, masses, h, v);
        }
        self.accept(report.residual, of_velocities, false, Some(report.sweeps))
    }

    /// Solves with a solver of the library, starting from the present reactions, which are not in `v`.
    fn solve_as_problem(
        &mut self,
        method: Method,
        max_iterations: Option<usize>,
        masses: (&[Vec3], &RigidSides),
        h: f64,
        v: &mut [Vec3],
    ) -> Result<(), (FailureCause, String)> {
        let options = solvers::Options {
            tolerance: self.plan.tolerance,
            method,
            max_iterations,
            ..solvers::Options::default()
        };
        let solved = solve_step(&self.contacts, &mut self.reactions, masses, h, v, &options);
        let report = solved.map_err(no_problem)?;
        report.map_or(Ok(()), |report| self.accept_report(&report))
    }

    /// Finds the contacts that may close within a step of length `h` [s] from the positions `x` [m] with the velocities
    /// `v` [m/s]; `phase` as in [`ContactStep::solve`]. They act on independent nodes.
    pub fn detect(
        &mut self,
        plan: &Plan,
        rigid: Option<&RigidStep>,
        x: &[Vec3],
        h: f64,
        phase: Phase,
        v: &[Vec3],
    ) -> Result<(), (FailureCause, String)> {
        self.find(plan, rigid, x, h, phase, v)?;
        self.complete(plan, phase);
        let sides = rigid.map_or(RigidSides::NONE, |rigid| rigid.work().sides);
        for contact in self.contacts.iter_mut().filter(|c| sides.of_pair(c.pair) == [None; 2]) {
            contact.align_with_supports(&plan.inverse_mass);
        }
        let followers = plan.assembly.followers();
        if followers.is_empty() {
            return Ok(());
        }
        for contact in &mut self.contacts {
            let too_many =
                || (FailureCause::Internal, format!("A contact has more than {MOST_NODES} nodes."));
            contact.stencil = contact.stencil.without(followers).ok_or_else(too_many)?;
        }
        Ok(())
    }

    /// Gives the contacts their laws and the relative flight of their sides.
    fn complete(&mut self, plan: &Plan, phase: Phase) {
        for of_pair in self.contacts.chunk_by_mut(|a, b| a.pair == b.pair) {
            let pair = self.plan.pairs.get(of_pair[0].pair as usize);
            let law = if phase.sticks() { ContactLaw::Coulomb(f64::INFINITY) } else { pair.law };
            let (slave, master) = self.plan.bodies_of(&pair);
            let flight = |body: usize| plan.bodies[body].flight_velocity;
            let drift = flight(slave) - master.map_or(Vec3::zeros(), flight);
            let drift = if phase.flies() { drift } else { Vec3::zeros() };
            for contact in of_pair {
                contact.complete(law, drift);
            }
        }
    }

    /// Finds the contacts of the current surfaces.
    fn find(
        &mut self,
        plan: &Plan,
        rigid: Option<&RigidStep>,
        x: &[Vec3],
        h: f64,
        phase: Phase,
        v: &[Vec3],
    ) -> Result<(), (FailureCause, String)> {
        // Positions and poses at the end of the step with the present velocities.
        let flight =
            |body: usize| if phase.flies() { plan.bodies[body].flight_velocity } else { Vec3::zeros() };
        // Contact depends on boundary nodes only.
        for (surface, &body) in self.surfaces.iter().zip(&self.plan.surface_body) {
            for node in surface.nodes.iter().map(|&node| node as usize) {
                self.x_end[node] = x[node] + (v[node] + flight(body)) * h;
            }
        }
        let RigidSides { bodies, poses, .. } = rigid.map_or(RigidSides::NONE, |rigid| rigid.work().sides);
        let of_end = |((body, pose), of): ((&RigidBody, &Pose), &usize)| Pose {
            centre: pose.centre + (v[body.centre as usize] + flight(*of)) * h,
            orientation: rotated(&pose.orientation, &v[body.spin as usize], h),
        };
        self.poses_end.clear();
        self.poses_end.extend(bodies.iter().zip(poses).zip(&self.plan.rigid_body).map(of_end));
        let motion = Motion { x, x_end: &self.x_end, poses, poses_end: &self.poses_end };
        let stopped = |e| (FailureCause::NotFinite, format!("Contact detection stopped: {e}."));
        self.detectors.detect(&motion, &mut self.contacts).map_err(stopped)
    }

    /// Applies [`Self::accept`] to the report of a library solver.
    pub fn accept_report(&mut self, report: &SolveReport) -> Result<(), (FailureCause, String)> {
        if report.converged {
            return Ok(());
        }
        let of_velocities = [report.error_of_motion, report.error_of_free];
        self.accept(report.error_scaled, of_velocities, report.is_jammed, None)
    }

    /// Whether a residual above the scene's tolerance is still acceptable, in absolute terms and relative to the motion and to the free
    /// velocities; if so, it is counted. `is_jammed`: reactions were found to grow without bound. `sweeps` is their number, if known.
    fn accept(
        &mut self,
        residual: f64,
        of_velocities: [f64; 2],
        is_jammed: bool,
        sweeps: Option<usize>,
    ) -> Result<(), (FailureCause, String)> {
        // If there is no solution, reactions grow until they mask the residual.
        if is_jammed || residual <= LARGEST_RESIDUAL && !are_small(of_velocities) {
            let message = format!(
                "No reactions of the {} contacts were found that satisfy the contact law: {:.2e} of the velocities that contact changes remain, and {:.2e} of \
                 those of approach, however large the reactions. Bodies are squeezed between parts that cannot yield, or jammed by friction.",
                self.contacts.len(),
                of_velocities[0],
                of_velocities[1]
            );
            return Err((FailureCause::ContactJammed, message));
        }
        if residual <= LARGEST_RESIDUAL {
            // Some clusters of frictional contacts have no unique or even no stable solution; the best iterate
            // satisfies the law to more digits than the mesh resolves. It is counted, and the user is warned.
            self.unconverged = (self.unconverged.0 + 1, self.unconverged.1.max(residual));
            return Ok(());
        }
        let after = sweeps.map_or_else(String::new, |sweeps| format!(" after {sweeps} sweeps"));
        let message = format!(
            "The contact solver stopped at a residual of {residual:.2e}{after} (limit {LARGEST_RESIDUAL:.0e}, {} contacts).",
            self.contacts.len()
        );
        let is_number = residual.is_finite();
        Err((if is_number { FailureCause::ContactNotConverged } else { FailureCause::NotFinite }, message))
    }

    /// Contacts and the buffer for their reactions.
    pub fn problem(&mut self) -> (&mut Vec<Contact>, &mut Vec<Reaction>) {
        (&mut self.contacts, &mut self.reactions)
    }

    /// Unknowns per contact: one if all are frictionless.
    pub fn unknowns(&self) -> usize {
        if self.contacts.iter().any(|contact| contact.law.unknowns() > 1) { 3 } else { 1 }
    }

    /// Largest scaled residual of a converged solution [-].
    pub fn tolerance(&self) -> f64 {
        self.plan.tolerance
    }

    /// Library solver named by the scene.
    pub fn named_solver(&self) -> Option<Method> {
        self.plan.solver
    }

    pub fn results(&self) -> (&[Contact], &[Reaction]) {
        (&self.contacts, &self.reactions)
    }

    /// Projects out the remaining penetration, in a step of a `fraction` of the usual one [-]: (node, shift), possibly
    /// several per node. Rigid bodies are rotated too, in `poses`.
    pub fn project(
        &mut self,
        plan: &Plan,
        x: &mut [Vec3],
        poses: &mut [Pose],
        fraction: f64,
    ) -> &[(u32, Vec3)] {
        let nodes = MovableNodes { inverse_mass: &plan.inverse_mass, followers: plan.assembly.followers() };
        let meshes = self.contacts.partition_point(|c| (c.pair as usize) < self.plan.pairs.mesh_count());
        let Self { contacts, detectors, moved, .. } = self;
        project_positions(&contacts[..meshes], detectors.surfaces(), (nodes, fraction), x, moved);
        if let (Some(projection), Some(rigid)) = (&mut self.rigid_projection, &plan.rigid) {
            let (of_pairs, first) = (&rigid.of_pairs[..], rigid.first_pair);
            let sides = RigidSides { of_pairs, first, bodies: &rigid.bodies, poses: &[] };
            projection.project(detectors, &sides, (nodes, fraction), x, poses, moved);
        }
        &self.moved
    }
}
