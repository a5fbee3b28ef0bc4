//! The list of detectors: all that produce the contacts of a step.

use super::detector::{DetectionError, Detector, Motion};
use super::edges::BENT;
use super::guard::Guard;
use super::mortar::Mortar;
use super::node_to_face::NodeToFace;
use super::rigid_detection::RigidDetector;
use super::surfaces::PairSurfaces;
use crate::contact::pairs::Pairs;
use crate::contact::{Contact, Discretisation, Surface};
use crate::rigid::RigidBody;
use crate::tensor::Vec3;
use crate::threads::Threads;

/// What may touch, and how its contacts are discretised.
#[derive(Clone, Copy, Debug)]
pub struct ContactModel<'a> {
    /// The surfaces of all pairs.
    pub surfaces: &'a [Surface],
    /// Contact pairs, in the order of the plan.
    pub pairs: &'a Pairs,
    /// All rigid bodies.
    pub rigid: &'a [RigidBody],
    /// Discretisation of the contact of two meshes.
    pub discretisation: Discretisation,
    /// Whether self-contact is checked in every step, even where nothing can have come near since the last one.
    pub always_searches_self_contact: bool,
    /// Positions of all nodes at the start of the run [m].
    pub x: &'a [Vec3],
}

impl ContactModel<'_> {
    /// The detectors of the pairs of meshes and planes, in the order in which they append.
    fn of_meshes(&self, surfaces: &PairSurfaces, threads: &Threads) -> Vec<Box<dyn Detector>> {
        let nodes = NodeToFace::of(surfaces.clone(), self.x).on(threads);
        let nodes =
            if self.always_searches_self_contact { nodes.with_self_contact_in_every_step() } else { nodes };
        let guard = |bent| Box::new(Guard::new(surfaces, bent, self.x).on(threads));
        match self.discretisation {
            Discretisation::NodeToSurface => vec![Box::new(nodes)],
            Discretisation::TwoPass => vec![Box::new(nodes), guard(BENT)],
            // Mortar contact controls the mean over a smooth face, not single edges.
            Discretisation::Mortar => vec![Box::new(Mortar::new(nodes)), guard(f64::INFINITY)],
        }
    }

    /// The detectors of the pairs with a rigid side.
    fn of_rigid(&self, threads: &Threads) -> Vec<Box<dyn Detector>> {
        let pairs = self.pairs.rigid();
        if pairs.0.is_empty() {
            return Vec::new();
        }
        vec![Box::new(RigidDetector::new(self.surfaces, pairs, self.rigid, self.x).on(threads))]
    }
}

/// All detectors of a model.
pub struct Detectors {
    surfaces: PairSurfaces,
    meshes: Vec<Box<dyn Detector>>,
    rigid: Vec<Box<dyn Detector>>,
    of_rigid: Vec<Contact>,
    threads: Threads,
}

impl Detectors {
    /// With room for so many contacts of pairs with a rigid side.
    pub fn new(model: &ContactModel, most_rigid: usize, threads: &Threads) -> Self {
        let surfaces = PairSurfaces::new(model.surfaces, model.pairs, model.x);
        Self {
            meshes: model.of_meshes(&surfaces, threads),
            rigid: model.of_rigid(threads),
            of_rigid: Vec::with_capacity(most_rigid),
            threads: threads.clone(),
            surfaces,
        }
    }

    /// The surfaces of the pairs.
    pub fn surfaces(&self) -> &PairSurfaces {
        &self.surfaces
    }

    /// Fills `contacts` with those that may close within the step: of meshes and planes in the order of [`Contact::key`],
    /// then of the pairs with a rigid side.
    ///
    /// # Errors
    /// Positions or poses that are not finite.
    pub fn detect(&mut self, motion: &Motion, contacts: &mut Vec<Contact>) -> Result<(), DetectionError> {
        let Self { meshes, rigid, of_rigid, threads, .. } = self;
        contacts.clear();
        let of_meshes = || {
            for detector in meshes {
                let before = contacts.len();
                detector.detect(motion, contacts)?;
                // The next one searches them.
                if contacts.len() > before {
                    contacts.sort_unstable_by_key(|c| (c.key(), c.stencil.nodes().last().copied()));
                }
            }
            Ok(())
        };
        if rigid.is_empty() {
            return of_meshes();
        }
        let both = threads.join(of_meshes, || detect_in_turn(rigid, motion, of_rigid));
        both.0.and(both.1)?;
        contacts.append(of_rigid);
        Ok(())
    }

    /// As [`Detectors::detect`], of the pairs with a rigid side alone.
    ///
    /// # Errors
    /// Poses that are not finite.
    pub fn detect_rigid(
        &mut self,
        motion: &Motion,
        contacts: &mut Vec<Contact>,
    ) -> Result<(), DetectionError> {
        detect_in_turn(&mut self.rigid, motion, contacts)
    }
}

/// Fills `contacts` by one detector after the other.
fn detect_in_turn(
    detectors: &mut [Box<dyn Detector>],
    motion: &Motion,
    contacts: &mut Vec<Contact>,
) -> Result<(), DetectionError> {
    contacts.clear();
    detectors.iter_mut().try_for_each(|detector| detector.detect(motion, contacts))
}
