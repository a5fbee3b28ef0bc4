//! A node in contact.

use crate::mechanics::tensor::Vec3;

/// When and how a node was last pressed.
#[derive(Clone, Copy, Debug)]
pub(super) struct Touch {
    /// Time [s].
    pub time: f64,
    /// Outward normal of the other side.
    pub normal: Vec3,
    /// Sum of the weights of its contacts; 1 for a contact at the node itself.
    pub weight: f64,
    /// The largest such sum of late, with its time [s]: beside a contact of its own a node may have one that it shares with others.
    pub largest: (f64, f64),
    /// Force normal to the face [N].
    pub force: f64,
}

impl Touch {
    /// One at a time [s] with this normal; with its weight and force [N].
    pub fn new((time, normal): (f64, Vec3), weight: f64, force: f64) -> Self {
        Self { time, normal, weight, largest: (f64::NEG_INFINITY, 0.0), force }
    }
    /// Keeps the largest weight since a time [s].
    pub fn keep_largest(&mut self, since: f64) {
        let (time, largest) = self.largest;
        if self.weight >= largest || time < since {
            self.largest = (self.time, self.weight);
        }
    }
}
