//! Contact inside a step: detection, the bi-potential law on the end-of-step gap, projection.

use super::failure::FailureCause;
use super::integrator::Phase;
use super::ledger::stuck;
use super::place::drift;
use super::rigid::RigidStep;
use crate::mechanics::contact::detection::Detector;
use crate::mechanics::contact::gauss_seidel::{self, Options, Workspace};
use crate::mechanics::contact::guard::Guard;
use crate::mechanics::contact::problem::ProblemError;
use crate::mechanics::contact::projection::{MovableNodes, project_positions};
use crate::mechanics::contact::rigid_detection::{RigidDetector, RigidMotion};
use crate::mechanics::contact::rigid_projection::RigidProjection;
use crate::mechanics::contact::solvers::{self, LARGEST_OF_FREE, Method, SolveReport};
use crate::mechanics::contact::stencil::MOST_NODES;
use crate::mechanics::contact::step_problem::{solve_step, take_off};
use crate::mechanics::contact::{Contact, ContactLaw, Reaction, RigidSides, Surface};
use crate::mechanics::force::Erosion;
use crate::mechanics::rigid::{Pose, RigidBody, rotated};
use crate::mechanics::tensor::Vec3;
use crate::plan::{ContactPlan, Plan, RigidPlan};
use std::borrow::Cow;

/// Sweeps of Gauss–Seidel before it is said not to converge.
const MOST_SWEEPS: usize = 2000;
/// Scaled residual above which a step fails; between the scene's tolerance and this it is counted and warned about.
const LARGEST_RESIDUAL: f64 = 1e-4;
/// Contacts of which W costs no more than sweeps that take their time.
const FEW: usize = 100;
/// Sweeps over so few before Newton's method goes on from where they are, and the most iterations that it has.
const FEW_SWEEPS: usize = 200;
const NEWTON_STEPS: usize = 60;

/// Shifts of a projection for each contact that there is room for: slave and master nodes in a few passes.
pub(super) const SHIFTS: usize = 8;

/// Detector and buffers of the contact solve; derived from the plan and the positions, so no part of the state.
pub(super) struct ContactStep<'p> {
    plan: &'p ContactPlan,
    /// Those of the plan, as erosion has left them.
    surfaces: Cow<'p, [Surface]>,
    detector: Detector,
    guard: Guard,
    laws: Vec<ContactLaw>,
    stuck: Vec<ContactLaw>,
    drift: Vec<Vec3>,
    still: Vec<Vec3>,
    x_end: Vec<Vec3>,
    contacts: Vec<Contact>,
    reactions: Vec<Reaction>,
    workspace: Workspace,
    moved: Vec<(u32, Vec3)>,
    /// When a pair has a rigid side.
    rigid: Option<RigidContact<'p>>,
    /// Solves that ended above the scene's tolerance: how many, and the largest residual.
    pub unconverged: (u64, f64),
}

/// What is wrong with the numbers of a step where they make no contact problem.
pub(super) fn no_problem(error: ProblemError) -> (FailureCause, String) {
    (FailureCause::NotFinite, format!("There is no contact problem: {error}."))
}

/// What contact needs where a side is a rigid body.
struct RigidContact<'p> {
    plan: &'p RigidPlan,
    detector: RigidDetector,
    projection: RigidProjection,
    poses_end: Vec<Pose>,
}

impl<'p> RigidContact<'p> {
    fn new(plan: &'p Plan, contact: &ContactPlan, surfaces: &[Surface]) -> Option<Self> {
        let rigid = plan.rigid.as_ref().filter(|_| contact.mesh_pairs < contact.pairs.len())?;
        let (pairs, most) = (contact.pairs.len(), contact.most_rigid_contacts());
        let of_rigid = (&contact.pairs[..], contact.mesh_pairs);
        Some(Self {
            plan: rigid,
            detector: RigidDetector::new(surfaces, of_rigid, &rigid.bodies, &plan.X),
            projection: RigidProjection::new(plan.node_count(), pairs, most),
            poses_end: Vec::with_capacity(rigid.bodies.len()),
        })
    }
}

/// What finds contacts of meshes with each other and with planes.
fn detectors(plan: &Plan, contact: &ContactPlan, surfaces: &[Surface]) -> (Detector, Guard) {
    let pairs = &contact.pairs[..contact.mesh_pairs];
    let detector = Detector::new(surfaces, pairs, &plan.X).with(contact.discretisation);
    let detector =
        if contact.always_looks_at_itself { detector.that_always_looks_at_itself() } else { detector };
    (detector, Guard::new(surfaces, pairs, contact.discretisation, &plan.X))
}

impl<'p> ContactStep<'p> {
    pub fn new(plan: &'p Plan, contact: &'p ContactPlan) -> Self {
        // Room for every slave node at once: pages that nothing touches cost nothing.
        let most = contact.most_contacts();
        let drift: Vec<Vec3> = (0..contact.pairs.len()).map(|p| drift(plan, contact, p)).collect();
        let surfaces = Cow::Borrowed(&contact.surfaces[..]);
        let (detector, guard) = detectors(plan, contact, &surfaces);
        Self {
            plan: contact,
            detector,
            guard,
            laws: contact.pairs.iter().map(|p| p.law).collect(),
            stuck: stuck(&contact.pairs),
            still: vec![Vec3::zeros(); drift.len()],
            drift,
            x_end: vec![Vec3::zeros(); plan.node_count()],
            contacts: Vec::with_capacity(most),
            reactions: Vec::with_capacity(most),
            workspace: Workspace::with_capacity(
                contact.most_mesh_contacts(),
                contact.most_rigid_contacts(),
                contact.pairs.len(),
            ),
            moved: Vec::with_capacity(SHIFTS * most),
            rigid: RigidContact::new(plan, contact, &surfaces),
            surfaces,
            unconverged: (0, 0.0),
        }
    }

    /// The surfaces as they are.
    pub fn surfaces(&self) -> &[Surface] {
        &self.surfaces
    }

    /// From now on these elements are gone: what they have laid bare may be touched.
    pub fn lay_bare(&mut self, plan: &'p Plan, erosion: &Erosion) {
        let of_body = |body: &usize| plan.bodies[*body].skin_after(erosion).into_owned();
        self.surfaces = self.plan.surface_body.iter().map(of_body).collect();
        (self.detector, self.guard) = detectors(plan, self.plan, &self.surfaces);
        self.rigid = RigidContact::new(plan, self.plan, &self.surfaces);
    }

    /// Finds the contacts that may close within the step and changes `v` from v* to v₊; with the bodies' flight
    /// velocities where they fly, with full stick while settling.
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
        self.solve_as_problem(method, None, masses, h, phase, v)
    }

    /// Gauss–Seidel, and Newton where its sweeps do not lead on.
    fn solve_by_sweeps(
        &mut self,
        masses: (&[Vec3], &RigidSides),
        h: f64,
        phase: Phase,
        v: &mut [Vec3],
    ) -> Result<(), (FailureCause, String)> {
        let has_mesh = |c: &Contact| masses.1.of_pair(c.pair)[0].is_none();
        let is_few = self.contacts.len() <= FEW && self.contacts.iter().all(has_mesh) && !phase.sticks();
        let max_sweeps = if is_few { FEW_SWEEPS } else { MOST_SWEEPS };
        let options = Options { tolerance: self.plan.tolerance, max_sweeps, acceptable: LARGEST_RESIDUAL };
        let laws = if phase.sticks() { &self.stuck } else { &self.laws };
        let report = gauss_seidel::solve_with_rigid(
            &self.contacts,
            laws,
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
        // Friction at several places that share their nodes may make sweeps go round for ever: Newton solves it. Where they have come
        // near, and its steps do not lead on, the best iterate will do.
        let is_near = report.residual <= LARGEST_RESIDUAL;
        if (is_few || !is_near) && !phase.sticks() {
            take_off(&self.contacts, &self.reactions, masses, h, v);
            let most = is_near.then_some(NEWTON_STEPS);
            return self.solve_as_problem(Method::default(), most, masses, h, phase, v);
        }
        self.accept([report.residual, report.residual_of_free], Some(report.sweeps))
    }

    /// By a solver of the library, from the present reactions, which are not in `v`.
    fn solve_as_problem(
        &mut self,
        method: Method,
        max_iterations: Option<usize>,
        masses: (&[Vec3], &RigidSides),
        h: f64,
        phase: Phase,
        v: &mut [Vec3],
    ) -> Result<(), (FailureCause, String)> {
        let options = solvers::Options {
            tolerance: self.plan.tolerance,
            method,
            max_iterations,
            ..solvers::Options::default()
        };
        let laws = if phase.sticks() { &self.stuck } else { &self.laws };
        let solved = solve_step(&self.contacts, &mut self.reactions, laws, masses, h, v, &options);
        let report = solved.map_err(no_problem)?;
        report.map_or(Ok(()), |report| self.accept_report(&report))
    }

    /// Finds the contacts that may close within a step of length `h` [s] from the positions `x` [m] with the velocities `v`
    /// [m/s]; `phase` as in [`ContactStep::solve`]. They act on nodes that follow nobody.
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

    /// The contacts of the surfaces as they are.
    fn find(
        &mut self,
        plan: &Plan,
        rigid: Option<&RigidStep>,
        x: &[Vec3],
        h: f64,
        phase: Phase,
        v: &[Vec3],
    ) -> Result<(), (FailureCause, String)> {
        let drift = if phase.flies() { &self.drift } else { &self.still };
        // Contact looks at the skins only.
        for (surface, &body) in self.surfaces.iter().zip(&self.plan.surface_body) {
            let flight = if phase.flies() { plan.bodies[body].flight_velocity } else { Vec3::zeros() };
            for node in surface.nodes.iter().map(|&node| node as usize) {
                self.x_end[node] = x[node] + (v[node] + flight) * h;
            }
        }
        let stopped = |e| (FailureCause::NotFinite, format!("Contact detection stopped: {e}."));
        self.detector.detect(x, &self.x_end, drift, &mut self.contacts).map_err(stopped)?;
        self.guard.detect(x, &self.x_end, drift, &mut self.contacts).map_err(stopped)?;
        let (Some(contact), Some(rigid)) = (&mut self.rigid, rigid) else { return Ok(()) };
        let poses = rigid.work().sides.poses;
        let of_end = |((body, pose), of): ((&RigidBody, &Pose), &usize)| {
            let flight = if phase.flies() { plan.bodies[*of].flight_velocity } else { Vec3::zeros() };
            Pose {
                centre: pose.centre + (v[body.centre as usize] + flight) * h,
                orientation: rotated(&pose.orientation, &v[body.spin as usize], h),
            }
        };
        let bodies = contact.plan.bodies.iter().zip(poses).zip(&contact.plan.of_body);
        contact.poses_end.clear();
        contact.poses_end.extend(bodies.map(of_end));
        let motion = RigidMotion { x, x_end: &self.x_end, poses, poses_end: &contact.poses_end };
        contact.detector.detect(&motion, drift, &mut self.contacts).map_err(stopped)
    }

    /// As [`Self::accept`], of a solver of the library.
    pub fn accept_report(&mut self, report: &SolveReport) -> Result<(), (FailureCause, String)> {
        if report.converged {
            return Ok(());
        }
        self.accept([report.error_scaled, report.error_of_free], None)
    }

    /// Whether a residual above the scene's tolerance is still small enough, by itself and against the velocities that contact must
    /// stop; then it is counted. `sweeps` that led to it, where they were counted.
    fn accept(
        &mut self,
        [residual, of_free]: [f64; 2],
        sweeps: Option<usize>,
    ) -> Result<(), (FailureCause, String)> {
        if residual <= LARGEST_RESIDUAL && of_free > LARGEST_OF_FREE {
            // Where there is no solution, reactions grow until they hide what is missed.
            let message = format!(
                "No reactions of the {} contacts stop what they must: {of_free:.2e} of the velocities is left (limit \
                 {LARGEST_OF_FREE:.0e}). Bodies are squeezed between parts that cannot give way, or jammed by friction.",
                self.contacts.len()
            );
            return Err((FailureCause::ContactJammed, message));
        }
        if residual <= LARGEST_RESIDUAL {
            // Friction has no unique or even no stable solution in some knots of contacts; the best iterate obeys the law to
            // more digits than the mesh resolves. It is counted, and the user is told.
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

    /// Contacts and the room for their reactions.
    pub fn problem(&mut self) -> (&mut Vec<Contact>, &mut Vec<Reaction>) {
        (&mut self.contacts, &mut self.reactions)
    }

    /// Friction of a contact [-], infinite while settling.
    pub fn friction(&self, contact: &Contact, phase: Phase) -> f64 {
        contact.law(if phase.sticks() { &self.stuck } else { &self.laws }).mu()
    }

    /// Unknowns of each of the contacts: one where none of them rubs.
    pub fn unknowns(&self, phase: Phase) -> usize {
        let laws = if phase.sticks() { &self.stuck } else { &self.laws };
        let rubs = self.contacts.iter().any(|c| laws[c.pair as usize].unknowns() > 1);
        if rubs { 3 } else { 1 }
    }

    /// Largest scaled residual of a converged solution [-].
    pub fn tolerance(&self) -> f64 {
        self.plan.tolerance
    }

    /// The solver of the library that the scene names.
    pub fn named_solver(&self) -> Option<Method> {
        self.plan.solver
    }

    pub fn results(&self) -> (&[Contact], &[Reaction]) {
        (&self.contacts, &self.reactions)
    }

    /// Moves what is left inside back out, in a step of a `share` of the usual one [-]: (node, shift), a node possibly more than once.
    /// Rigid bodies are turned too, in `poses`.
    pub fn project(&mut self, plan: &Plan, x: &mut [Vec3], poses: &mut [Pose], share: f64) -> &[(u32, Vec3)] {
        let nodes = MovableNodes { inverse_mass: &plan.inverse_mass, followers: plan.assembly.followers() };
        let meshes = self.contacts.partition_point(|c| (c.pair as usize) < self.plan.mesh_pairs);
        project_positions(&self.contacts[..meshes], &self.detector, (nodes, share), x, &mut self.moved);
        if let Some(RigidContact { plan, detector, projection, .. }) = &mut self.rigid {
            projection.project(detector, &plan.of_pairs, (nodes, share), x, poses, &mut self.moved);
        }
        &self.moved
    }
}
