//! Conjugate directions of sweeps over stacked rigid bodies.

use super::super::local::Local;
use crate::contact::Reaction;

/// Direction of the conjugate gradient; empty where no rigid body touches a plane or another.
#[derive(Clone, Debug, Default)]
pub(super) struct Conjugate {
    /// Impulses before the sweep [N s].
    before: Vec<Local>,
    direction: Vec<Local>,
}

impl Conjugate {
    /// Whether the sweeps do without.
    pub fn is_empty(&self) -> bool {
        self.direction.is_empty()
    }

    pub fn with_capacity(contacts: usize) -> Self {
        Self { before: Vec::with_capacity(contacts), direction: Vec::with_capacity(contacts) }
    }

    pub fn restart(&mut self, contacts: usize) {
        self.direction.clear();
        self.direction.resize(contacts, [0.0; 3]);
    }

    pub fn remember(&mut self, reactions: &[Reaction]) {
        self.before.clear();
        self.before.extend(reactions.iter().map(|reaction| reaction.impulse));
    }

    /// The step `β d` along the last direction d, zero where changes grow (β ≥ 1); the next direction is `β d + (p −
    /// p_before)`.
    pub fn step(&mut self, reactions: &[Reaction], beta: f64) -> &[Local] {
        let beta = if beta < 1.0 { beta } else { 0.0 };
        for ((direction, before), reaction) in self.direction.iter_mut().zip(&mut self.before).zip(reactions)
        {
            for i in 0..3 {
                let step = beta * direction[i];
                direction[i] = step + (reaction.impulse[i] - before[i]);
                before[i] = step;
            }
        }
        &self.before
    }
}
