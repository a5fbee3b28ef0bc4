//! What a producer of contacts is: a [`Detector`]. Which there are is in [`super::detectors`].

use crate::contact::Contact;
use crate::rigid::Pose;
use crate::tensor::Vec3;
use thiserror::Error;

/// Positions and poses at both ends of a step in the absence of contact.
#[derive(Clone, Copy, Debug)]
pub struct Motion<'a> {
    /// Absolute positions of the nodes at the start [m].
    pub x: &'a [Vec3],
    /// Absolute positions of the nodes at the end [m].
    pub x_end: &'a [Vec3],
    /// Poses of the rigid bodies at the start.
    pub poses: &'a [Pose],
    /// Poses of the rigid bodies at the end.
    pub poses_end: &'a [Pose],
}

impl<'a> Motion<'a> {
    /// Without rigid bodies.
    pub fn of_nodes(x: &'a [Vec3], x_end: &'a [Vec3]) -> Self {
        Self { x, x_end, poses: &[], poses_end: &[] }
    }
}

/// Reasons for which detection fails.
#[derive(Clone, Copy, Debug, Error, PartialEq)]
pub enum DetectionError {
    /// A position is NaN or infinite.
    #[error("the position of a node on surface {surface} is not finite")]
    NotFinite {
        /// Index of the surface.
        surface: usize,
    },
    /// The pose of a rigid body is NaN or infinite.
    #[error("the place of rigid body {body} is not finite")]
    BodyNotFinite {
        /// Index of the body.
        body: usize,
    },
}

/// A producer of contacts: rows of signed nodal weights with a frame and a gap.
///
/// Their number and order depend on the motion alone, neither on earlier steps nor on the number of threads.
pub trait Detector: Send {
    /// Appends the contacts that may close within the step to those of the detectors before it, which it may read: they are
    /// in ascending order of [`Contact::key`] where no side is rigid.
    ///
    /// # Errors
    /// Positions or poses that are not finite; nothing is appended then.
    fn detect(&mut self, motion: &Motion, contacts: &mut Vec<Contact>) -> Result<(), DetectionError>;
}
