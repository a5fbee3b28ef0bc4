//! Scene → plan: element blocks, masses, contact pairs, loads, integrator.

use super::blocks::{Globals, add_blocks, reference_geometry};
use super::body::PlanBody;
use super::compiled::Plan;
use super::contact::compile_contact;
use super::contact_mass::{inertia_lost, lumped_mass};
use super::distant::BodyMotion;
use super::holder::Holder;
use super::integrator::{DynamicRelaxation, Implicit, Integrator};
use super::loads::Loads;
use super::memory::BufferSizes;
use super::parts::{CompileError, Parts};
use super::report::PlanReport;
use super::reporting::report;
use super::requested::{field_times, measures};
use super::stable_step::StableSteps;
use super::stepping::{bulk_viscosities, integrator, preload};
use crate::mechanics::contact::Surface;
use crate::mechanics::followers::{Followers, Masters};
use crate::mechanics::force::{AssembledBound, AssembledRows, Assembly, ElementForces, ForceInput, Threads};
use crate::mechanics::material::Material;
use crate::mechanics::tensor::Vec3;
use crate::mesh::Cells;
use crate::scene::document::{Axis, BodyDocument, ErrorBarsDocument, Keep, PartDocument, SceneDocument};
use crate::scene::{Scene, SceneBody};
use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

/// Compiles a scene to a plan, without looking for symmetry.
///
/// # Errors
/// Inverted elements and massless nodes, which validation reports earlier and in full; invalid followers.
pub(super) fn compile_whole(scene: &Scene) -> Result<Plan, CompileError> {
    let document = &scene.document;
    let mut parts = Parts::default();
    for (body, mesh) in document.bodies.iter().zip(&scene.bodies) {
        match &mesh.rigid {
            Some(rigid) => add_rigid_body(&mut parts, body, rigid),
            None => add_body(&mut parts, document, body, mesh)?,
        }
    }
    let followers = Followers::new(parts.X.len(), &parts.ties);
    // The followers of each body have been checked separately.
    parts.followers =
        Arc::new(followers.map_err(|error| CompileError::Followers { body: String::new(), error })?);
    parts.loads = Loads::new(scene, &parts.bodies, &parts.X);
    for prescribed in &parts.loads.prescribed {
        parts.inverse_mass[prescribed.node as usize][prescribed.axis] = 0.0;
    }
    check_followers(&mut parts)?;
    let assembly = Assembly::new(parts.X.len(), &parts.blocks).with(parts.followers.clone());
    let integrator = integrator(&document.integrator, &parts)?;
    let preload = preload(document, &parts)?;
    Ok(complete(scene, parts, assembly, (integrator, preload)))
}

/// As [`compile_whole`], for a scene that may differ from `before` (with plan `plan`) only in its motion.
pub(super) fn recompile_whole(plan: Plan, before: &Scene, scene: &Scene) -> Result<Plan, CompileError> {
    if !before.document.differs_in_motion_only(&scene.document) {
        return compile_whole(scene);
    }
    let nodes = plan.X.len();
    let mut parts = Parts {
        u: if plan.initial_u.is_empty() { vec![Vec3::zeros(); nodes] } else { plan.initial_u },
        v: Vec::with_capacity(nodes),
        X: plan.X,
        own_inverse_mass: plan.own_inverse_mass,
        mass: plan.mass,
        inverse_mass: plan.inverse_mass,
        blocks: plan.blocks,
        bodies: plan.bodies,
        rigid: plan.rigid.unwrap_or_default(),
        loads: plan.loads,
        ties: BTreeMap::new(),
        followers: plan.assembly.followers().clone(),
    };
    // New velocities; everything else is reused.
    for (index, (document, body)) in scene.document.bodies.iter().zip(&scene.bodies).enumerate() {
        let nodes = &parts.bodies[index].nodes;
        let nodes = nodes.start as usize..nodes.end as usize;
        if let Some(rigid) = parts.bodies[index].rigid {
            parts.v.extend(rigid_velocities(document, parts.rigid.orientations[rigid]));
        } else {
            let (mass, inverse) = (&parts.mass[nodes.clone()], &parts.inverse_mass[nodes]);
            parts.v.extend(spin_velocities(document, body, mass, inverse));
        }
        parts.bodies[index].flight_velocity = Vec3::from(document.velocity_m_per_s);
    }
    Ok(complete(scene, parts, plan.assembly, (plan.integrator, plan.preload)))
}

/// The plan of the collected parts.
fn complete(
    scene: &Scene,
    mut parts: Parts,
    assembly: Assembly,
    (integrator, preload): (Integrator, Option<Box<Implicit>>),
) -> Plan {
    let document = &scene.document;
    // Initial displacements and velocities of followers are those of their masters.
    parts.followers.follow(&mut parts.u);
    parts.followers.follow(&mut parts.v);
    let still = |values: &[Vec3]| values.iter().all(|v| *v == Vec3::zeros());
    let mut forces = ElementForces::new(&parts.blocks);
    let is_explicit = matches!(integrator, Integrator::Explicit(_));
    let at_start = is_explicit.then(|| fractions_at_start(&parts, &assembly, &mut forces));
    let (fractions, bound) = at_start.unwrap_or_default();
    let buffers = BufferSizes { forces: forces.memory(), bound };
    let steps = StableSteps::new(&parts.blocks, &parts.u, &fractions, &mut forces);
    let longest_step = match &integrator {
        // Without elements the scene gives the step.
        Integrator::Explicit(explicit) if parts.blocks.is_empty() => explicit.max_step,
        Integrator::Explicit(_) => steps.largest_of_bodies(&parts.blocks),
        Integrator::Implicit(implicit) => implicit.step,
    };
    let until = document.end_time_s + LONGER_THAN_A_STEP * longest_step;
    // Contact needs a bound on the end of the last step.
    let (contact, distant_pairs) =
        compile_contact(document, &parts.bodies, &parts.X, &motions(document, &parts), until);
    parts.rigid.note_pairs(contact.as_ref(), &parts.bodies);
    let mut plan = Plan {
        skip_inactive_elements: is_explicit && skips_inactive_elements(document, &parts),
        distant_pairs,
        name: document.name.clone(),
        sector: None,
        measures: measures(scene, &parts.bodies),
        bodies: parts.bodies,
        X: parts.X,
        own_inverse_mass: parts.own_inverse_mass,
        fractions,
        mass: parts.mass,
        inverse_mass: parts.inverse_mass,
        rigid: (!parts.rigid.bodies.is_empty()).then_some(parts.rigid),
        blocks: parts.blocks,
        assembly,
        contact,
        gravity: document.gravity_m_per_s2.map(Vec3::from).filter(|g| *g != Vec3::zeros()),
        loads: parts.loads,
        preload,
        dynamic_relaxation: document
            .dynamic_relaxation
            .as_ref()
            .map(|s| DynamicRelaxation { duration: s.duration_s, damping: s.damping_per_s }),
        initial_u: if still(&parts.u) { Vec::new() } else { parts.u },
        initial_v: if still(&parts.v) { Vec::new() } else { parts.v },
        integrator,
        energy_gate: document.integrator.energy_gate(),
        rounding_energy: 0.0,
        holder: Holder::default(),
        end_time: document.end_time_s,
        field_times: field_times(scene),
        fields: document.recorded_fields(),
        every_steps: document.record.every_steps.max(1),
        has_error_bars: document.solver.error_bars != ErrorBarsDocument::None,
        report: PlanReport::default(),
    };
    // Quantities that need the plan itself.
    plan.holder = plan.supports(|_| true, !document.planes.is_empty());
    plan.rounding_energy = rounding_energy(&plan) + rigid_rounding_energy(&plan, document);
    plan.report = report(&plan, scene, &steps, buffers);
    plan
}

/// Evaluations of the fractions at the start, by which their weights are close to the best.
const EVALUATIONS: usize = 4;

/// The fractions of the volumetric stiffness in the initial critical time steps, and the memory of their bound [bytes]; nothing if no element
/// has a mean dilatation.
fn fractions_at_start(
    parts: &Parts,
    assembly: &Assembly,
    forces: &mut ElementForces,
) -> (Vec<Vec<AssembledRows>>, usize) {
    let Parts { blocks, u, own_inverse_mass, .. } = parts;
    if !blocks.iter().any(|block| block.parameters.has_mean_dilatation()) {
        return Default::default();
    }
    forces.evaluate(&Threads::ONE, blocks, &ForceInput::at(u));
    let mut bound = AssembledBound::new(blocks, u.len(), parts.bodies.len());
    let mut fractions = Vec::new();
    for _ in 0..EVALUATIONS {
        let input = ForceInput { fractions: &fractions, ..ForceInput::at(u) };
        bound.evaluate(&Threads::ONE, (blocks, assembly, own_inverse_mass), forces, &input);
        fractions = bound.fractions().to_vec();
    }
    (fractions, bound.memory())
}

/// Bound on the length of a step, as a multiple of the smallest critical time step of one body [-].
const LONGER_THAN_A_STEP: f64 = 1.01;

/// Bounds on the motion of the bodies, known before the run.
fn motions(document: &SceneDocument, parts: &Parts) -> Vec<BodyMotion> {
    let is_loaded = is_loaded(document);
    let start = [&parts.u[..], &parts.v, &parts.inverse_mass];
    let of_body = |body: &PlanBody| match body.rigid {
        Some(rigid) => BodyMotion::rigid(body, &parts.rigid.bodies[rigid], &parts.X, is_loaded),
        None => BodyMotion::new(body, &parts.X, start, is_loaded),
    };
    let driven = |body: &PlanBody| {
        let motion = of_body(body);
        if parts.loads.act_on(body) { motion.driven() } else { motion }
    };
    parts.bodies.iter().map(driven).collect()
}

/// Whether a load acts on every node from the first step.
fn is_loaded(document: &SceneDocument) -> bool {
    document.gravity_m_per_s2.is_some_and(|g| Vec3::from(g) != Vec3::zeros())
        || document.dynamic_relaxation.is_some()
        || document.preload.is_some()
}

/// Under gravity nothing stays at rest, and where everything is in motion from the start nothing is; elements that are not local may have
/// forces while their nodes rest.
fn skips_inactive_elements(document: &SceneDocument, parts: &Parts) -> bool {
    let rests = |node: u32| [&parts.u, &parts.v].iter().all(|values| values[node as usize] == Vec3::zeros());
    let mut meshes = parts.bodies.iter().filter(|body| body.rigid.is_none());
    !document.keeps(Keep::InactiveElements)
        && !is_loaded(document)
        && parts.blocks.iter().all(|block| block.parameters.is_local())
        && !parts.bodies.iter().any(|body| parts.loads.act_on(body))
        && meshes.any(|body| body.nodes.clone().any(rests))
}

/// Strain that rounding of displacements may cause [-]: some thousand ulps of a displacement of the size of a body.
const ROUNDING_STRAIN: f64 = 1e-12;

/// m c² ε² of all bodies [J], ε the rounding strain: a body at rest in a rotated position is never quite at rest.
fn rounding_energy(plan: &Plan) -> f64 {
    let fastest = |b: usize| {
        let blocks = plan.blocks.iter().filter(|block| block.body == b);
        blocks.map(|block| block.parameters.wave_speed()).fold(0.0, f64::max)
    };
    plan.bodies.iter().enumerate().map(|(b, body)| body.mass * (fastest(b) * ROUNDING_STRAIN).powi(2)).sum()
}

/// m s² τ of the rigid bodies [J], s a bound on the speed of flight, spin and fall, τ the tolerance of contact: the
/// uncertainty of the contact impulses moves even a supported body.
fn rigid_rounding_energy(plan: &Plan, document: &SceneDocument) -> f64 {
    let duration = document.end_time_s + document.dynamic_relaxation.as_ref().map_or(0.0, |s| s.duration_s);
    let fall = plan.gravity.map_or(0.0, |g| g.norm() * duration);
    let of_body = |(rigid, body): (&crate::mechanics::rigid::RigidBody, &usize)| {
        let spin = plan.initial_v.get(rigid.spin as usize).map_or(0.0, Vec3::norm);
        let speed = plan.bodies[*body].flight_velocity.norm() + spin * rigid.shape.outer_radius() + fall;
        rigid.mass * speed * speed * document.contact.tolerance
    };
    plan.rigid.iter().flat_map(|r| r.bodies.iter().zip(&r.of_body)).map(of_body).sum()
}

fn add_body(
    parts: &mut Parts,
    scene: &SceneDocument,
    document: &BodyDocument,
    body: &SceneBody,
) -> Result<(), CompileError> {
    let mesh = &body.mesh;
    let (first_node, first_element) =
        (parts.X.len() as u32, parts.bodies.last().map_or(0, |b| b.elements.end));
    let geometry = reference_geometry(scene, document, body)?;

    let mut mass = lumped_mass(document, body, |element| geometry[element].corner_volume.clone());
    if let Some(node) = mass.iter().position(|m| !(*m > 0.0)) {
        return Err(CompileError::MasslessNode { body: document.name.clone(), node });
    }
    let inertia_lost = inertia_lost(scene, document, body, &mass);
    let ties = mesh.hanging.ties();
    let followers = Followers::new(mesh.nodes.len(), &ties)
        .map_err(|error| CompileError::Followers { body: document.name.clone(), error })?;
    parts.own_inverse_mass.extend(inverse_masses(document, body, &mass));
    followers.hand_over_masses(&mut mass);
    let inverse_mass = inverse_masses(document, body, &mass);
    parts.u.extend(mesh.nodes.iter().map(|X| initial_displacement(document, X)));
    parts.v.extend(spin_velocities(document, body, &mass, &inverse_mass));
    parts.inverse_mass.extend(inverse_mass);

    // Elements, in blocks of one kernel each.
    let viscosity = bulk_viscosities(&scene.integrator);
    let keeps_idle_fibres = scene.keeps(Keep::IdleFibres);
    let globals =
        Globals { first_node, first_element, body: parts.bodies.len(), viscosity, keeps_idle_fibres };
    add_blocks(&mut parts.blocks, &globals, document, body, geometry)?;

    // Boundary surface, with global node numbers.
    let global = |face: &[u32; 4]| face.map(|node| node + first_node);
    let faces: Vec<[u32; 4]> = body.boundary().iter().map(global).collect();
    let nodes = faces.iter().flatten().copied().collect::<BTreeSet<u32>>().into_iter().collect();
    let mirrored =
        body.mirrored.each_ref().map(|nodes| nodes.iter().map(|node| node + first_node).collect::<Vec<_>>());
    let (validity, sets) = entries_of_parts(document, body)
        .map(|(part, law)| (part.material.valid_to().range_of(law), part.library.clone()))
        .unzip();
    parts.bodies.push(PlanBody {
        name: document.name.clone(),
        role: document.role,
        nodes: first_node..first_node + mesh.nodes.len() as u32,
        elements: first_element..first_element + mesh.cells.len() as u32,
        flight_velocity: Vec3::from(document.velocity_m_per_s),
        cells: mesh.cells.map(|node| node + first_node),
        part_of: mesh.part_of.clone(),
        parts: mesh.parts.clone(),
        validity,
        sets,
        erodes: document.parts.iter().any(|part| part.erosion.is_some()),
        boundary: Surface { nodes, faces, mirrored },
        rigid: None,
        mass: mass.iter().sum(),
        first_moment: mesh.nodes.iter().zip(&mass).map(|(X, m)| X * *m).sum(),
        inertia_lost,
    });
    let global = |masters: Masters| masters.into_iter().map(|(node, w)| (node + first_node, w)).collect();
    parts.ties.extend(ties.into_iter().map(|(node, masters)| (node + first_node, global(masters))));
    parts.X.extend_from_slice(&mesh.nodes);
    parts.mass.extend(mass);
    Ok(())
}

/// Followers have no inertia of their own, and are held or driven as their masters are, never more.
fn check_followers(parts: &mut Parts) -> Result<(), CompileError> {
    let followers = parts.followers.clone();
    for (node, masters) in followers.each() {
        let inverse = std::mem::replace(&mut parts.inverse_mass[node as usize], Vec3::zeros());
        let is_held = |axis: usize| inverse[axis] == 0.0;
        let all_are = |axis: usize| masters.iter().all(|(m, _)| parts.inverse_mass[*m as usize][axis] == 0.0);
        if (0..3).any(|axis| is_held(axis) && !all_are(axis)) {
            let body = &parts.bodies[parts.bodies.partition_point(|body| body.nodes.end <= node)];
            let (body, node) = (body.name.clone(), node - body.nodes.start);
            return Err(CompileError::HeldFollower { body, node });
        }
    }
    parts.loads.prescribed.retain(|prescribed| !followers.contains(prescribed.node as usize));
    Ok(())
}

/// Entry in the document and law of each part of a mesh; a part without elements is skipped.
fn entries_of_parts<'a>(
    document: &'a BodyDocument,
    body: &'a crate::scene::SceneBody,
) -> impl Iterator<Item = (&'a PartDocument, &'a Material)> {
    let of_part = |part: usize| {
        let element = body.mesh.part_of.iter().position(|p| *p as usize == part).unwrap_or(0);
        let entry = *body.part_entry.get(element)? as usize;
        Some((document.parts.get(entry)?, body.materials.get(entry)?))
    };
    (0..body.mesh.parts.len()).filter_map(of_part)
}

/// Adds a rigid body as two nodes: the centre of mass, and the spin in the axes of the body.
fn add_rigid_body(parts: &mut Parts, document: &BodyDocument, rigid: &crate::scene::RigidSceneBody) {
    let centre = parts.X.len() as u32;
    let first_element = parts.bodies.last().map_or(0, |b| b.elements.end);
    let (place, mass) = (rigid.pose.centre, rigid.mass);
    let orientation = rigid.pose.orientation;
    parts.X.extend([place; 2]);
    parts.own_inverse_mass.extend([Vec3::zeros(); 2]);
    parts.mass.extend([mass, 0.0]);
    let mut inverse = [Vec3::repeat(1.0 / mass), rigid.inertia.map(|i| 1.0 / i)];
    for (inverse, held) in inverse.iter_mut().zip(rigid.held) {
        (0..3).filter(|axis| held[*axis]).for_each(|axis| inverse[axis] = 0.0);
    }
    parts.inverse_mass.extend(inverse);
    parts.u.extend([Vec3::zeros(); 2]);
    parts.v.extend(rigid_velocities(document, orientation));
    parts.bodies.push(PlanBody {
        name: document.name.clone(),
        role: document.role,
        nodes: centre..centre + 2,
        elements: first_element..first_element,
        flight_velocity: Vec3::from(document.velocity_m_per_s),
        cells: Cells::default(),
        part_of: Vec::new(),
        parts: Vec::new(),
        validity: Vec::new(),
        sets: Vec::new(),
        erodes: false,
        boundary: Surface::new(vec![centre], Vec::new()),
        rigid: Some(parts.rigid.bodies.len()),
        mass,
        first_moment: place * mass,
        inertia_lost: 0.0,
    });
    parts.rigid.of_body.push(parts.bodies.len() - 1);
    parts.rigid.orientations.push(orientation);
    parts.rigid.bodies.push(crate::mechanics::rigid::RigidBody {
        centre,
        spin: centre + 1,
        shape: rigid.shape.clone(),
        mass,
        inertia: rigid.inertia,
    });
}

/// Velocities of the two nodes of a rigid body relative to its flight: zero, and the spin in the axes of the body.
fn rigid_velocities(document: &BodyDocument, orientation: crate::mechanics::rigid::Rotation) -> [Vec3; 2] {
    [Vec3::zeros(), orientation.inverse_transform_vector(&Vec3::from(document.spin_rad_per_s))]
}

/// 1/m along each axis [1/kg], 0 where a fixed set holds the node.
fn inverse_masses(document: &BodyDocument, body: &SceneBody, mass: &[f64]) -> Vec<Vec3> {
    let mut inverse: Vec<Vec3> = mass.iter().map(|m| Vec3::repeat(1.0 / m)).collect();
    for fixed in &document.fixed {
        let axes = fixed.axes.iter().map(|axis| match axis {
            Axis::X => 0,
            Axis::Y => 1,
            Axis::Z => 2,
        });
        for axis in axes {
            if fixed.set == "*" {
                for m in &mut inverse {
                    m[axis] = 0.0;
                }
            }
            for node in body.mesh.node_sets.get(&fixed.set).into_iter().flatten() {
                inverse[*node as usize][axis] = 0.0;
            }
        }
    }
    for (axis, nodes) in body.mirrored.iter().enumerate() {
        for node in nodes {
            inverse[*node as usize][axis] = 0.0;
        }
    }
    inverse
}

fn initial_displacement(document: &BodyDocument, X: &Vec3) -> Vec3 {
    document.initial_deformation.as_ref().map_or_else(Vec3::zeros, |deformation| deformation.position(X) - X)
}

/// ω × (x − c) about the centre of mass c [m/s], zero along held axes.
fn spin_velocities(
    document: &BodyDocument,
    body: &SceneBody,
    mass: &[f64],
    inverse_mass: &[Vec3],
) -> Vec<Vec3> {
    let spin = Vec3::from(document.spin_rad_per_s);
    let placed: Vec<Vec3> = body.mesh.nodes.iter().map(|X| X + initial_displacement(document, X)).collect();
    let center = placed.iter().zip(mass).map(|(x, m)| x * *m).sum::<Vec3>() / mass.iter().sum::<f64>();
    let free = |m: f64| if m > 0.0 { 1.0 } else { 0.0 };
    let velocity = |(x, m): (&Vec3, &Vec3)| spin.cross(&(x - center)).component_mul(&m.map(free));
    placed.iter().zip(inverse_mass).map(velocity).collect()
}
