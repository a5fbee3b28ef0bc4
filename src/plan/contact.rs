//! Contact pairs of a plan, and the choice of slave and master.

use super::body::PlanBody;
use super::by_pair::{ByPair, MOST_LISTED_BODIES};
use super::contact_plan::ContactPlan;
use super::distant::{BodyMotion, DistantPair, Other, cannot_meet};
use crate::mechanics::contact::detection::slave_choice::{Slave, choose_slave, mean_face_size};
use crate::mechanics::contact::pairs::{EveryTwo, Pairs};
use crate::mechanics::contact::{ContactLaw, ContactPair, Master};
use crate::mechanics::tensor::Vec3;
use crate::scene::document::{
    ContactPairs, ContactSolver, Keep, PlaneDocument, Role, SceneDocument, SelfContact,
};

/// One side of a pair of the document.
#[derive(Clone, Copy)]
enum Side<'a> {
    Body(usize),
    Plane(&'a PlaneDocument),
}

/// The two sides of a requested pair, and their friction coefficient.
type Requested<'a> = (Side<'a>, Side<'a>, f64);

/// Compiles the contact pairs (`None` when nothing may touch), and those that cannot meet, given the `motions` of the
/// bodies and the latest time `until` [s] at which a contact may matter.
pub(super) fn compile_contact(
    document: &SceneDocument,
    bodies: &[PlanBody],
    X: &[Vec3],
    motions: &[BodyMotion],
    until: f64,
) -> (Option<ContactPlan>, Vec<DistantPair>) {
    let requested = requested_pairs(document);
    // What any of many bodies may deflect is not known in advance.
    let (requested, distant) = if are_many(document) {
        (requested, Vec::new())
    } else {
        without_distant_pairs(document, requested, bodies, motions, until)
    };
    if requested.is_empty() && !are_many(document) {
        return (None, distant);
    }
    let is_rigid = |&body: &usize| bodies[body].rigid.is_some();
    let mut plan = ContactPlan {
        surfaces: Vec::new(),
        surface_body: Vec::new(),
        pairs: Pairs::default(),
        rigid_body: (0..bodies.len()).filter(is_rigid).collect(),
        listed_names: ByPair::default(),
        tolerance: document.contact.tolerance,
        discretisation: document.contact.discretisation,
        solver: document.solver.contact.map(ContactSolver::method),
        always_searches_self_contact: document.keeps(Keep::IdleSelfContact),
    };
    // Pairs with a rigid side come last.
    let (rigid, meshes): (Vec<Requested>, Vec<Requested>) =
        requested.into_iter().partition(|(a, b, _)| a.is_rigid(bodies) || b.is_rigid(bodies));
    let every =
        if are_many(document) { every_two(&mut plan, document, bodies, X) } else { EveryTwo::default() };
    let mut names = Vec::new();
    let mut listed = |pairs: Vec<Requested>| -> Vec<ContactPair> {
        let of_requested = |requested| {
            let (pair, sides) = listed_pair(&mut plan, document, bodies, X, requested)?;
            names.push(sides);
            Some(pair)
        };
        pairs.into_iter().filter_map(of_requested).collect()
    };
    let (meshes, rigid) = (listed(meshes), listed(rigid));
    plan.pairs = Pairs::new(meshes, every, rigid);
    let mut names = names.into_iter();
    plan.listed_names = ByPair::new(Some(&plan.pairs), |_| names.next().unwrap_or_default());
    (Some(plan), distant)
}

/// Whether every two of so many bodies may touch that their pairs are not listed.
fn are_many(document: &SceneDocument) -> bool {
    matches!(document.contact.pairs, ContactPairs::All(_)) && document.bodies.len() > MOST_LISTED_BODIES
}

/// The pairs of every two deformable bodies, with the surfaces of these in the order of the bodies.
fn every_two(plan: &mut ContactPlan, document: &SceneDocument, bodies: &[PlanBody], X: &[Vec3]) -> EveryTwo {
    let meshes = (0..bodies.len()).filter(|&body| bodies[body].rigid.is_none());
    let surfaces =
        meshes.map(|body| (surface_of(plan, bodies, body), mean_face_size(&bodies[body].boundary, X)));
    let surfaces = surfaces.collect();
    EveryTwo::new(surfaces, law(plan, document, document.contact.friction))
}

/// The law of a coefficient of friction [-]. A solver named by the scene uses three unknowns per contact, with or without
/// friction.
fn law(plan: &ContactPlan, document: &SceneDocument, mu: f64) -> ContactLaw {
    let keeps_tangential = document.keeps(Keep::TangentialReactions) || plan.solver.is_some();
    if keeps_tangential { ContactLaw::Coulomb(mu) } else { ContactLaw::of(mu) }
}

/// Splits the pairs into those that may meet and those that cannot, unless the document keeps the latter.
fn without_distant_pairs<'a>(
    document: &SceneDocument,
    requested: Vec<Requested<'a>>,
    bodies: &[PlanBody],
    motions: &[BodyMotion],
    until: f64,
) -> (Vec<Requested<'a>>, Vec<DistantPair>) {
    if document.keeps(Keep::DistantPairs) {
        return (requested, Vec::new());
    }
    let sides: Vec<(usize, Other)> = requested.iter().filter_map(|(a, b, _)| moving_sides(*a, *b)).collect();
    let verdicts = cannot_meet(motions, &sides, until);
    let (mut kept, mut distant) = (Vec::new(), Vec::new());
    for ((a, b, mu), verdict) in requested.into_iter().zip(verdicts) {
        if let Some(why) = verdict {
            let name = [a, b].map(|side| side.name(bodies)).join("–");
            let of_itself = is_of_itself(a, b);
            let on_tissue = !of_itself && [a, b].iter().any(|side| side.is_tissue(bodies));
            distant.push(DistantPair { name, on_tissue, of_itself, why });
        } else {
            kept.push((a, b, mu));
        }
    }
    (kept, distant)
}

fn is_of_itself(a: Side, b: Side) -> bool {
    matches!((a, b), (Side::Body(a), Side::Body(b)) if a == b)
}

/// A pair with a body first; `None` for two planes, which validation refuses.
fn moving_sides(a: Side, b: Side) -> Option<(usize, Other)> {
    let plane =
        |plane: &PlaneDocument| Other::Plane(Vec3::from(plane.point_m), Vec3::from(plane.normal).normalize());
    match (a, b) {
        (Side::Body(a), Side::Body(b)) => Some((a, Other::Body(b))),
        (Side::Body(body), Side::Plane(p)) | (Side::Plane(p), Side::Body(body)) => Some((body, plane(p))),
        (Side::Plane(_), Side::Plane(_)) => None,
    }
}

impl<'a> Side<'a> {
    fn name(self, bodies: &'a [PlanBody]) -> &'a str {
        match self {
            Self::Body(body) => &bodies[body].name,
            Self::Plane(plane) => &plane.name,
        }
    }
    fn is_rigid(self, bodies: &[PlanBody]) -> bool {
        matches!(self, Self::Body(body) if bodies[body].rigid.is_some())
    }
    fn is_tissue(self, bodies: &[PlanBody]) -> bool {
        matches!(self, Self::Body(body) if bodies[body].role == Role::Tissue)
    }
}

/// All requested pairs with their friction, bodies before planes; without those of two of many deformable bodies.
fn requested_pairs(document: &SceneDocument) -> Vec<Requested<'_>> {
    let default = document.contact.friction;
    let side = |name: &str| {
        let body = document.bodies.iter().position(|b| b.name == name).map(Side::Body);
        body.or_else(|| document.planes.iter().find(|p| p.name == name).map(Side::Plane))
    };
    let mut pairs: Vec<Requested> = match &document.contact.pairs {
        ContactPairs::All(_) => {
            let count = document.bodies.len();
            let is_listed = |a: usize, b: usize| {
                !are_many(document) || [a, b].iter().any(|&body| document.bodies[body].rigid.is_some())
            };
            let behind = |a: usize| (a + 1..count).filter(move |&b| is_listed(a, b));
            let between =
                (0..count).flat_map(|a| behind(a).map(move |b| (Side::Body(a), Side::Body(b), default)));
            let onto =
                |a: usize| document.planes.iter().map(move |p| (Side::Body(a), Side::Plane(p), default));
            between.chain((0..count).flat_map(onto)).collect()
        }
        ContactPairs::List(list) => list
            .iter()
            .filter_map(|pair| {
                Some((side(&pair.between[0])?, side(&pair.between[1])?, pair.friction.unwrap_or(default)))
            })
            .filter(|(a, b, _)| document.contact.self_contact == SelfContact::Auto || !is_of_itself(*a, *b))
            .collect(),
    };
    let itself = |body: usize| (Side::Body(body), Side::Body(body), default);
    pairs.extend(document.bodies_that_meet_themselves().map(itself));
    pairs
}

/// A listed pair with the names of its sides; `None` for two planes, which validation refuses.
fn listed_pair(
    plan: &mut ContactPlan,
    document: &SceneDocument,
    bodies: &[PlanBody],
    X: &[Vec3],
    (a, b, mu): Requested,
) -> Option<(ContactPair, [String; 2])> {
    let (slave, master, names) = match (a, b) {
        (Side::Body(a), Side::Plane(plane)) | (Side::Plane(plane), Side::Body(a)) => {
            let normal = Vec3::from(plane.normal).normalize();
            let master = Master::Plane { point: Vec3::from(plane.point_m), normal };
            (a, master, [bodies[a].name.as_str(), plane.name.as_str()])
        }
        (Side::Body(a), Side::Body(b)) => {
            let (slave, master) = slave_and_master(document, bodies, X, a, b);
            let side = match bodies[master].rigid {
                Some(rigid) => Master::Rigid(rigid),
                None => Master::Surface(surface_of(plan, bodies, master)),
            };
            (slave, side, [bodies[slave].name.as_str(), bodies[master].name.as_str()])
        }
        (Side::Plane(_), Side::Plane(_)) => return None,
    };
    let pair = ContactPair { slave: surface_of(plan, bodies, slave), master, law: law(plan, document, mu) };
    Some((pair, names.map(str::to_owned)))
}

/// The slave is the surface that is finer in the patch where the bodies move towards each other; against a rigid body, the
/// mesh.
fn slave_and_master(
    document: &SceneDocument,
    bodies: &[PlanBody],
    X: &[Vec3],
    a: usize,
    b: usize,
) -> (usize, usize) {
    if a == b {
        return (a, b);
    }
    match [a, b].map(|body| bodies[body].rigid.is_some()) {
        [false, false] => {}
        [true, false] => return (b, a),
        [_, true] => return (a, b),
    }
    let flown = (bodies[a].flight_velocity - bodies[b].flight_velocity) * document.end_time_s;
    let (low, high) = (a.min(b), a.max(b));
    let flown = if low == a { flown } else { -flown };
    match choose_slave(&bodies[low].boundary, &bodies[high].boundary, X, &flown) {
        Slave::First => (low, high),
        Slave::Second => (high, low),
    }
}

/// Index of the body's surface in the contact plan; adds it if necessary.
fn surface_of(plan: &mut ContactPlan, bodies: &[PlanBody], body: usize) -> usize {
    if let Some(index) = plan.surface_body.iter().position(|b| *b == body) {
        return index;
    }
    plan.surfaces.push(bodies[body].boundary.clone());
    plan.surface_body.push(body);
    plan.surfaces.len() - 1
}
