//! The loads of a step: external nodal forces, their stiffness, and prescribed displacements.

use crate::mechanics::contact::solution::compliance::add_impulse;
use crate::mechanics::contact::{Contact, Reaction, RigidSides};
use crate::mechanics::face_load::{corner_areas, symmetric_stiffness};
use crate::mechanics::sparse::{SymmetricMatrix, Unknowns};
use crate::mechanics::tensor::Vec3;
use crate::plan::{FacePressure, LoadTime, Plan};

/// Gravity at a time [m/s²].
pub(super) fn gravity(plan: &Plan, time: LoadTime) -> Vec3 {
    let full = plan.gravity.unwrap_or_else(Vec3::zeros);
    match (&plan.loads.gravity, time) {
        (Some(ramp), _) => full * time.factor(ramp),
        (None, LoadTime::Preload(fraction)) => full * fraction,
        (None, LoadTime::Run(_)) => full,
    }
}

/// Nodal forces of pressures and tractions [N] at displacements `u` [m], without weight and contact. Leaves `forces`
/// unchanged if the plan has none.
pub(super) fn eval_forces(plan: &Plan, u: &[Vec3], time: LoadTime, forces: &mut [Vec3]) {
    if !plan.loads.has_forces() {
        return;
    }
    forces.fill(Vec3::zeros());
    for load in &plan.loads.forces {
        let factor = time.factor(&load.ramp);
        for (node, force) in &load.forces {
            forces[*node as usize] += force * factor;
        }
    }
    for load in &plan.loads.pressures {
        let pressure = load.pressure * time.factor(&load.ramp);
        for face in &load.faces {
            for (node, area) in face.iter().zip(corner_areas(&places(plan, u, face))) {
                forces[*node as usize] -= area * pressure;
            }
        }
    }
    plan.assembly.followers().hand_over(forces);
}

/// Each pressure at a time [Pa].
pub(super) fn pressures(plan: &Plan, time: LoadTime) -> Vec<f64> {
    plan.loads.pressures.iter().map(|load| load.pressure * time.factor(&load.ramp)).collect()
}

/// Adds `factor` times the symmetric part of the load stiffness of the pressures [Pa] at displacements `u` [m].
pub(super) fn add_stiffness(
    plan: &Plan,
    u: &[Vec3],
    pressures: &[f64],
    (factor, unknowns): (f64, &Unknowns),
    matrix: &mut SymmetricMatrix,
) {
    for (FacePressure { faces, .. }, pressure) in plan.loads.pressures.iter().zip(pressures) {
        for face in faces {
            let K = symmetric_stiffness(&places(plan, u, face));
            for a in 0..4 {
                for b in 0..=a {
                    let pair = std::array::from_fn(|i| factor * pressure * K[a][b][(i / 3, i % 3)]);
                    matrix.add_pair(unknowns, (face[a], face[b]), &pair);
                }
            }
        }
    }
}

/// Impulses on the prescribed components in an explicit step [N s], `m Δv` minus those of the forces and of the
/// contacts, which are summed in `touched`. `v` [m/s] before and after, `forces` internal and of loads [N], the latter
/// empty if there are none, with gravity [m/s²] and the time over which they act [s].
pub(super) fn weigh_prescribed(
    plan: &Plan,
    [before, after]: [&[Vec3]; 2],
    [f_int, f_ext]: [&[Vec3]; 2],
    (gravity, mean_step): (Vec3, f64),
    (contacts, reactions, sides): (&[Contact], &[Reaction], &RigidSides),
    touched: &mut [Vec3],
    impulses: &mut [f64],
) {
    if impulses.is_empty() {
        return;
    }
    touched.fill(Vec3::zeros());
    for (contact, reaction) in contacts.iter().zip(reactions) {
        add_impulse(contact, sides, reaction.impulse, touched);
    }
    for (impulse, p) in impulses.iter_mut().zip(&plan.loads.prescribed) {
        let (node, axis) = (p.node as usize, p.axis);
        let m = plan.mass[node];
        let load = f_ext.get(node).map_or(0.0, |load| load[axis]);
        let force = gravity[axis] * m + load - f_int[node][axis];
        *impulse = m * (after[node][axis] - before[node][axis]) - mean_step * force - touched[node][axis];
    }
}

fn places(plan: &Plan, u: &[Vec3], face: &[u32; 4]) -> [Vec3; 4] {
    face.map(|node| plan.X[node as usize] + u[node as usize])
}
