//! Frames of a symmetric scene from those of the sector that is computed.

use super::energy::{BodyEnergy, BranchEnergy, Energy, PairLedger};
use super::frame::{Ending, Frame, Outcome, Recorder, RecorderError};
use super::state::State;
use crate::mechanics::contact::{Contact, Reaction};
use crate::mechanics::lanes::Row;
use crate::mechanics::tensor::Vec3;
use crate::plan::{Plan, Sector, SectorPlan};

/// An outcome that names the failed element by its number in the whole.
fn with_element_of(whole: &Plan, SectorPlan { plan, sector }: &SectorPlan, mut outcome: Outcome) -> Outcome {
    if let Ending::Failed { failure } = &mut outcome.ending
        && let Some(place) = &mut failure.element
        && let Some(body) = plan.bodies.iter().position(|body| body.name == place.body)
    {
        let element = sector.image_of_element(plan.bodies[body].elements.start + place.element, 0);
        place.element = element - whole.bodies[body].elements.start;
    }
    outcome
}

/// For each image of the sector, the factors of the components of a vector: −1 along the normals that it is reflected along.
struct Signs(Vec<Vec3>);

impl Signs {
    fn of(sector: &Sector) -> Self {
        Self(
            (0..sector.images.count())
                .map(|image| sector.images.reflected(Vec3::repeat(1.0), image))
                .collect(),
        )
    }
    /// The vector of a node of the whole.
    fn at(&self, sector: &Sector, values: &[Vec3], node: usize) -> Vec3 {
        let (source, image) = sector.source[node];
        // The sum makes +0 of −0.
        values[source as usize].component_mul(&self.0[image as usize]).add_scalar(0.0)
    }
    /// The vectors of all nodes of the whole.
    fn unfold(&self, sector: &Sector, values: &[Vec3], all: &mut [Vec3]) {
        all.iter_mut().enumerate().for_each(|(node, value)| *value = self.at(sector, values, node));
    }
    /// Sum of a vector and its images.
    fn sum(&self, v: Vec3) -> Vec3 {
        self.0.iter().map(|signs| signs.component_mul(&v)).sum()
    }
}

/// Passes the frames of a sector on as frames of the whole.
pub(super) struct Unfolding<'a, 'r> {
    whole: &'a Plan,
    of_sector: &'a SectorPlan,
    sector: &'a Sector,
    recorders: &'a mut [&'r mut dyn Recorder],
    signs: Signs,
    /// Whether a recorder reads the motion of all nodes in every frame.
    reads_all: bool,
    /// Nodes whose displacement every frame has.
    kept: Vec<u32>,
    u: Vec<Vec3>,
    v: Vec<Vec3>,
    v_after: Vec<Vec3>,
    /// The order of the contacts of all images: pair and slave, number in the sector, image.
    order: Vec<((u32, u32), u32, u8)>,
    contacts: Vec<Contact>,
    reactions: Vec<Reaction>,
    energy: Energy,
    /// History of all elements; empty if none remembers.
    history: Vec<Vec<Row>>,
}

impl<'a, 'r> Unfolding<'a, 'r> {
    pub fn new(
        whole: &'a Plan,
        of_sector: &'a SectorPlan,
        recorders: &'a mut [&'r mut dyn Recorder],
    ) -> Self {
        let nodes = vec![Vec3::zeros(); whole.node_count()];
        let reads_all = recorders.iter().any(|recorder| recorder.reads_all_nodes());
        let SectorPlan { plan, sector } = of_sector;
        let most = plan.most_contacts() * sector.images.count();
        Self {
            whole,
            of_sector,
            sector,
            recorders,
            signs: Signs::of(sector),
            reads_all,
            kept: whole.nodes_to_keep().collect(),
            u: nodes.clone(),
            v: nodes.clone(),
            v_after: nodes,
            order: Vec::with_capacity(most),
            contacts: Vec::with_capacity(most),
            reactions: Vec::with_capacity(most),
            energy: Energy::with_capacity(whole),
            history: whole.room_for_history(),
        }
    }

    /// Outcome and motion of the whole, given those of the sector; the state restarts no run.
    pub fn end(&self, outcome: Outcome, end: &State) -> (Outcome, State) {
        let unfolded = |values: &[Vec3]| {
            let mut all = vec![Vec3::zeros(); self.whole.node_count()];
            self.signs.unfold(self.sector, values, &mut all);
            all
        };
        let state = State {
            time: end.time,
            step: end.step,
            u: unfolded(&end.u),
            v: unfolded(&end.v),
            orientations: end.orientations.clone(),
            last_step: end.last_step,
            ..State::new(self.whole)
        };
        (with_element_of(self.whole, self.of_sector, outcome), state)
    }

    /// Displacements, and at look times velocities and history.
    fn unfold_motion(&mut self, frame: &Frame) {
        let Self { sector, signs, kept, u, v, v_after, history, reads_all, .. } = self;
        if !(frame.is_look_time || *reads_all) {
            for &node in kept.iter() {
                u[node as usize] = signs.at(sector, frame.u, node as usize);
            }
            return;
        }
        for (values, all) in [(frame.u, u), (frame.v, v), (frame.v_after, v_after)] {
            signs.unfold(sector, values, all);
        }
        if frame.is_look_time {
            sector.unfold_history(frame.history, history);
        }
    }

    /// Contacts of all images in the order of [`Contact::key`]; one in planes of symmetry coincides with images, and is one contact.
    fn unfold_contacts(&mut self, frame: &Frame) {
        let Self { sector, order, contacts, reactions, .. } = self;
        order.clear();
        for (number, contact) in (0_u32..).zip(frame.contacts) {
            let is_first = |image: &usize| !(0..*image).any(|other| coincide(sector, contact, *image, other));
            for image in (0..sector.images.count()).filter(is_first) {
                let slave = sector.image_of_node(contact.slave, image);
                order.push(((contact.pair, slave), number, image as u8));
            }
        }
        order.sort_unstable();
        contacts.clear();
        reactions.clear();
        for &(_, number, image) in order.iter() {
            let number = number as usize;
            contacts.push(image_of(sector, &frame.contacts[number], image as usize));
            let reaction = &frame.reactions[number];
            reactions.push(reaction_of(sector, &frame.contacts[number], reaction, image as usize));
        }
    }

    /// Energies and momenta of all images together.
    fn unfold_energy(&mut self, frame: &Frame) {
        let Self { sector, signs, energy, .. } = self;
        let count = sector.images.count() as f64;
        energy.copy_from(frame.energy);
        energy.bodies.iter_mut().for_each(|body| *body = body_energy(body, signs, count));
        energy.branches.iter_mut().for_each(|branch| *branch = branch_energy(branch, count));
        energy.pairs.each_mut().for_each(|(_, pair)| *pair = pair_ledger(pair, signs, count));
        for sum in [
            &mut energy.total_j,
            &mut energy.initial_total_j,
            &mut energy.external_work_j,
            &mut energy.scale_j,
            &mut energy.turnover_j,
        ] {
            *sum *= count;
        }
        // The angular momentum about a point on all planes, of whose images each changes its sign but along the normals.
        let [own, about_origin] =
            [energy.momentum_kg_m_per_s, energy.angular_momentum_kg_m2_per_s].map(Vec3::from);
        let mut centre = Vec3::zeros();
        sector.images.0.iter().for_each(|plane| centre[plane.axis] = plane.at);
        let about_centre = about_origin - centre.cross(&own);
        let axial = |signs: &Vec3| (signs * signs.product()).component_mul(&about_centre);
        let momentum = signs.sum(own);
        let angular = signs.0.iter().map(axial).sum::<Vec3>() + centre.cross(&momentum);
        energy.momentum_kg_m_per_s = momentum.into();
        energy.angular_momentum_kg_m2_per_s = angular.into();
    }
}

impl Recorder for Unfolding<'_, '_> {
    fn start(&mut self, _: &Plan) -> Result<(), RecorderError> {
        self.recorders.iter_mut().try_for_each(|recorder| recorder.start(self.whole))
    }

    fn record(&mut self, frame: &Frame) -> Result<(), RecorderError> {
        self.unfold_motion(frame);
        self.unfold_contacts(frame);
        self.unfold_energy(frame);
        let has_motion = frame.is_look_time || self.reads_all;
        let at_look = |values: &'_ [Vec3]| if has_motion { values.len() } else { 0 };
        let of_whole = Frame {
            plan: self.whole,
            u: &self.u,
            v: &self.v[..at_look(&self.v)],
            v_after: &self.v_after[..at_look(&self.v_after)],
            history: if frame.is_look_time { &self.history } else { &[] },
            contacts: &self.contacts,
            reactions: &self.reactions,
            energy: &self.energy,
            ..*frame
        };
        self.recorders.iter_mut().try_for_each(|recorder| recorder.record(&of_whole))
    }

    fn finish(&mut self, _: &Plan, outcome: &Outcome) -> Result<(), RecorderError> {
        let outcome = with_element_of(self.whole, self.of_sector, outcome.clone());
        let mut first = Ok(());
        for recorder in self.recorders.iter_mut() {
            first = first.and(recorder.finish(self.whole, &outcome));
        }
        first
    }
}

/// Whether a contact is in two images at the same nodes of the slave.
fn coincide(sector: &Sector, contact: &Contact, a: usize, b: usize) -> bool {
    let mut slaves = contact.stencil.side(false);
    slaves.all(|(node, _)| sector.image_of_node(node, a) == sector.image_of_node(node, b))
}

/// Reaction of a contact in an image, and in those that coincide with it, in the frame of that image.
fn reaction_of(sector: &Sector, contact: &Contact, reaction: &Reaction, image: usize) -> Reaction {
    let others = (0..sector.images.count()).filter(|&other| other != image);
    let mut impulse = reaction.impulse;
    for other in others.filter(|&other| coincide(sector, contact, image, other)) {
        let reflected = |direction, image| sector.images.reflected(direction, image);
        let sum: Vec3 =
            contact.frame.iter().zip(reaction.impulse).map(|(axis, p)| reflected(*axis, other) * p).sum();
        contact.frame.iter().zip(&mut impulse).for_each(|(axis, p)| *p += reflected(*axis, image).dot(&sum));
    }
    Reaction { impulse }
}

/// A contact in an image, without its face.
fn image_of(sector: &Sector, contact: &Contact, image: usize) -> Contact {
    Contact {
        pair: contact.pair,
        kind: contact.kind,
        slave: sector.image_of_node(contact.slave, image),
        face: u32::MAX,
        stencil: contact.stencil.renumbered(|node| sector.image_of_node(node, image)),
        frame: contact.frame.map(|direction| sector.images.reflected(direction, image)),
        gap: contact.gap,
        point: sector.images.image_of_point(contact.point, image),
        drift: sector.images.reflected(contact.drift, image),
        law: contact.law,
    }
}

fn body_energy(body: &BodyEnergy, signs: &Signs, count: f64) -> BodyEnergy {
    BodyEnergy {
        kinetic_j: count * body.kinetic_j,
        strain_j: count * body.strain_j,
        hourglass_j: count * body.hourglass_j,
        branches_j: count * body.branches_j,
        viscous_j: count * body.viscous_j,
        eroded_j: count * body.eroded_j,
        algorithmic_j: count * body.algorithmic_j,
        contact_work_j: count * body.contact_work_j,
        external_work_j: count * body.external_work_j,
        projection_j: count * body.projection_j,
        momentum_kg_m_per_s: signs.sum(body.momentum_kg_m_per_s.into()).into(),
    }
}

fn branch_energy(branch: &BranchEnergy, count: f64) -> BranchEnergy {
    BranchEnergy { stored_j: count * branch.stored_j, dissipated_j: count * branch.dissipated_j, ..*branch }
}

fn pair_ledger(pair: &PairLedger, signs: &Signs, count: f64) -> PairLedger {
    PairLedger {
        impulse_n_s: signs.sum(pair.impulse_n_s.into()).into(),
        friction_j: count * pair.friction_j,
        numerical_j: count * pair.numerical_j,
        impact_j: count * pair.impact_j,
        work_on_slave_j: count * pair.work_on_slave_j,
        work_on_master_j: count * pair.work_on_master_j,
    }
}
