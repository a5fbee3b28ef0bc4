//! What a run shows, step by step, as far as quantities ask for it.

use crate::quantity::Quantity;
use contuse::mechanics::tensor::Vec3;
use contuse::plan::Plan;
use contuse::scene::Scene;
use contuse::step::{Energy, Frame, Recorder, RecorderError};
use std::collections::BTreeMap;

/// One step.
pub struct Row {
    /// t_n [s].
    pub time: f64,
    /// The ledger.
    pub energy: Energy,
    /// Force on the slave of each pair [N].
    pub force: Vec<Vec3>,
    /// Centre of mass of each body [m].
    pub center: Vec<Vec3>,
    /// Mean velocity of each body at the half step after t_n [m/s].
    pub velocity: Vec<Vec3>,
    /// Places of the nodes of each set that was requested [m].
    pub sets: Vec<Vec<Vec3>>,
}

/// A recorder of rows.
pub struct Seen {
    /// Every step.
    pub rows: Vec<Row>,
    /// Names of the bodies.
    bodies: Vec<String>,
    /// Masses of the bodies [kg].
    pub mass: Vec<f64>,
    /// Sets requested: (body, name) to the place in [`Row::sets`].
    places: BTreeMap<(String, String), usize>,
    /// Global nodes of the sets.
    nodes: Vec<Vec<u32>>,
    /// Their places at rest [m].
    pub at_rest: Vec<Vec<Vec3>>,
}

impl Seen {
    /// Ready for a run of a plan, with the node sets that the quantities speak of.
    pub fn new<'a>(scene: &Scene, plan: &Plan, quantities: impl Iterator<Item = &'a Quantity>) -> Self {
        let mut seen = Self {
            rows: Vec::new(),
            bodies: plan.bodies.iter().map(|b| b.name.clone()).collect(),
            mass: plan.bodies.iter().map(|b| b.mass).collect(),
            places: BTreeMap::new(),
            nodes: Vec::new(),
            at_rest: Vec::new(),
        };
        for (body, set) in quantities.filter_map(Quantity::node_set) {
            let b = seen.body(body);
            let first = plan.bodies[b].nodes.start;
            let of_mesh = scene.bodies[b].mesh.node_sets.get(set).unwrap_or_else(|| panic!("no set {set}"));
            let nodes: Vec<u32> = of_mesh.iter().map(|node| node + first).collect();
            seen.at_rest.push(nodes.iter().map(|node| plan.X[*node as usize]).collect());
            seen.places.insert((body.to_owned(), set.to_owned()), seen.nodes.len());
            seen.nodes.push(nodes);
        }
        seen
    }

    /// Index of a body.
    pub fn body(&self, name: &str) -> usize {
        self.bodies.iter().position(|b| b == name).unwrap_or_else(|| panic!("no body {name}"))
    }

    /// Place of a set in [`Row::sets`].
    pub fn set(&self, body: &str, set: &str) -> usize {
        self.places[&(body.to_owned(), set.to_owned())]
    }

    /// A number of the rows at a time, linear between two steps; at the end without a time.
    pub fn at(&self, time: Option<f64>, value: impl Fn(&Row) -> f64) -> f64 {
        let last = &self.rows[self.rows.len() - 1];
        let Some(time) = time else { return value(last) };
        let after = self.rows.partition_point(|row| row.time < time);
        let Some(b) = self.rows.get(after) else { panic!("the run ended before {time} s") };
        let Some(a) = after.checked_sub(1).map(|i| &self.rows[i]) else { return value(b) };
        value(a) + (value(b) - value(a)) * (time - a.time) / (b.time - a.time)
    }
}

impl Recorder for Seen {
    fn reads_all_nodes(&self) -> bool {
        true
    }

    fn record(&mut self, frame: &Frame) -> Result<(), RecorderError> {
        let plan = frame.plan;
        let mut force = vec![Vec3::zeros(); frame.energy.pairs.len()];
        for (contact, reaction) in frame.contacts.iter().zip(frame.reactions) {
            for (axis, p) in contact.frame.iter().zip(reaction.impulse) {
                force[contact.pair as usize] += axis * (p / frame.mean_step);
            }
        }
        let mean = |b: usize, value: &dyn Fn(u32) -> Vec3| {
            let weighted = plan.bodies[b].nodes.clone().map(|a| value(a) * plan.mass[a as usize]);
            weighted.sum::<Vec3>() / plan.bodies[b].mass
        };
        let bodies = 0..plan.bodies.len();
        self.rows.push(Row {
            time: frame.time,
            energy: frame.energy.clone(),
            force,
            center: bodies.clone().map(|b| mean(b, &|a| frame.position(a))).collect(),
            velocity: bodies
                .map(|b| plan.bodies[b].flight_velocity + mean(b, &|a| frame.v_after[a as usize]))
                .collect(),
            sets: self.nodes.iter().map(|nodes| nodes.iter().map(|a| frame.position(*a)).collect()).collect(),
        });
        Ok(())
    }
}
