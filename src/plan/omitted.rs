//! Features that a plan omits, each with its reason and, if there is one, the switch that keeps it.

use super::by_pair::MOST_LISTED_BODIES;
use super::compiled::Plan;
use super::report::Omitted;
use crate::mechanics::contact::ContactLaw;
use crate::scene::Scene;
use crate::scene::document::{FieldName, Keep, Role, SelfContact};

/// All that the plan does without; what can be restored comes first.
pub(super) fn omitted(plan: &Plan, scene: &Scene) -> Vec<Omitted> {
    let mut list = List::default();
    optional(plan, scene, &mut list);
    absent(plan, scene, &mut list);
    list.0
}

/// Names, of many the first.
fn in_words(names: &[impl AsRef<str>]) -> String {
    let first: Vec<&str> = names.iter().take(MOST_LISTED_BODIES).map(AsRef::as_ref).collect();
    match names.len() - first.len() {
        0 => first.join(", "),
        others => format!("{} and {others} others", first.join(", ")),
    }
}

#[derive(Default)]
struct List(Vec<Omitted>);

impl List {
    fn add(
        &mut self,
        is_omitted: bool,
        switch: Option<Keep>,
        what: impl Into<String>,
        why: impl Into<String>,
    ) {
        if is_omitted {
            self.0.push(Omitted { what: what.into(), why: why.into(), switch });
        }
    }
}

/// Features that a switch can keep.
fn optional(plan: &Plan, scene: &Scene, list: &mut List) {
    // Elements and pairs that motion has not reached.
    list.add(
        plan.skip_inactive_elements,
        Some(Keep::InactiveElements),
        "inactive elements",
        "an element that no wave has reached has no force: it is evaluated from the arrival of the front on",
    );
    for pair in &plan.distant_pairs {
        list.add(true, Some(Keep::DistantPairs), format!("contact {}", pair.name), &*pair.why);
    }
    let of_itself: Vec<&str> = plan.bodies_that_meet_themselves().map(|body| body.name.as_str()).collect();
    list.add(
        !of_itself.is_empty() && !scene.document.keeps(Keep::IdleSelfContact),
        Some(Keep::IdleSelfContact),
        format!("the search for self-contact of {} in most steps", in_words(&of_itself)),
        "parts cannot touch before their relative motion exceeds their distance",
    );
    // Contacts without friction.
    let is_frictionless = |law: ContactLaw| law == ContactLaw::Frictionless;
    let pairs = plan.contact.iter().flat_map(|contact| contact.pairs.listed());
    let names = pairs.filter(|(_, pair)| is_frictionless(pair.law)).map(|(number, _)| plan.name_of(number));
    let every = plan.contact.iter().map(|contact| contact.pairs.every_two());
    let of_every = every.filter(|every| !every.is_empty() && is_frictionless(every.law()));
    let smooth: Vec<String> = names
        .chain(of_every.map(|every| format!("every two of {} meshes", every.surfaces().count())))
        .collect();
    let relaxation = if plan.dynamic_relaxation.is_some() { " after dynamic relaxation" } else { "" };
    list.add(
        !smooth.is_empty(),
        Some(Keep::TangentialReactions),
        format!("tangential reactions of {}", in_words(&smooth)),
        format!("a frictionless contact has one unknown{relaxation}"),
    );
    // Fibres without stiffness, and fields that are not requested.
    let idle: Vec<String> = idle_fibres(scene).collect();
    list.add(
        !idle.is_empty() && !scene.document.keeps(Keep::IdleFibres),
        Some(Keep::IdleFibres),
        format!("fibres of {}", idle.join(", ")),
        "their stiffness k1 is zero",
    );
    let unrequested: Vec<String> =
        FieldName::ALL.into_iter().filter(|f| !plan.fields.contains(f)).map(field_name).collect();
    list.add(
        !unrequested.is_empty(),
        Some(Keep::UnrequestedFields),
        format!("the fields {}", unrequested.join(", ")),
        "not requested",
    );
}

/// Features that the scene does not have.
fn absent(plan: &Plan, scene: &Scene, list: &mut List) {
    let mut add = |is_omitted: bool, what: &str, why: &str| list.add(is_omitted, None, what, why);
    // Contact, of others and of itself.
    add(
        plan.contact.is_none() && plan.distant_pairs.is_empty(),
        "contact",
        "the scene has no pair that may touch",
    );
    let deforms = plan.bodies.iter().any(|body| body.rigid.is_none());
    let is_refused = scene.document.contact.self_contact == SelfContact::None;
    let finds_itself = plan.bodies_that_meet_themselves().next().is_some()
        || plan.distant_pairs.iter().any(|pair| pair.of_itself);
    add(
        deforms && is_refused,
        "self-contact",
        "disabled in the scene (`contact.self_contact`): folds interpenetrate",
    );
    add(
        deforms && !is_refused && !finds_itself,
        "self-contact",
        "the scene lists no pair: folds interpenetrate",
    );
    // Bodies, loads and initial motion.
    add(plan.rigid.is_none(), "rigid bodies", "every body is deformable");
    add(plan.gravity.is_none(), "gravity", "the scene gives none");
    add(plan.dynamic_relaxation.is_none(), "dynamic relaxation", "not requested");
    let has_fibres = plan.blocks.iter().any(|b| b.parameters.material.family_count() > 0);
    add(!has_fibres, "fibre arithmetic", "no part has fibres with stiffness");
    add(plan.initial_u.is_empty(), "initial deformation", "every body starts undeformed");
    add(plan.initial_v.is_empty(), "initial spin", "no body spins");
    // Measures of the tissue.
    let has_tissue = plan.bodies.iter().any(|b| b.role == Role::Tissue);
    add(!has_tissue, "absorbed energy and depth of stress", "no body is the tissue");
    add(!has_tissue && plan.fields.is_empty(), "stresses at points", "not needed by any measure or field");
    // Memory of the laws.
    let why = if plan.is_viscous() {
        "no law depends on more than the current strain rate"
    } else {
        "every law is elastic"
    };
    let of_bulk = plan.blocks.iter().any(|b| b.parameters.has_bulk_viscosity());
    let what = if of_bulk { "history variables except those of bulk viscosity" } else { "history variables" };
    add(!plan.has_memory(), what, why);
    let has_branches = plan.blocks.iter().any(|b| b.branch_count() > 0);
    add(
        plan.has_memory() && !has_branches,
        "history of branch forces, for the energies of relaxation",
        "no part has a Prony series",
    );
    add(!plan.erodes(), "erosion", "no part has limits of erosion");
}

/// Body and part of each set of fibres with zero stiffness.
fn idle_fibres(scene: &Scene) -> impl Iterator<Item = String> {
    let bodies = scene.document.bodies.iter().zip(&scene.bodies);
    bodies.flat_map(|(document, body)| {
        let parts = document.parts.iter().zip(&body.materials);
        let idle = parts.filter(|(_, m)| m.family_count() != m.without_idle_fibres().family_count());
        idle.map(|(part, _)| format!("{}/{}", document.name, part.part))
    })
}

/// Name of a field in the document.
fn field_name(field: FieldName) -> String {
    serde_json::to_value(field).ok().and_then(|v| v.as_str().map(str::to_owned)).unwrap_or_default()
}
