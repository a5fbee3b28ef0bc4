//! The motion of a scene: velocities, spins and friction. It can change while meshes and masses stay the same.

use super::document::{Around, ContactDocument, ContactPairs, SceneDocument};

impl SceneDocument {
    /// Whether two documents are equal apart from velocities, spins and coefficients of friction.
    pub fn differs_in_motion_only(&self, other: &Self) -> bool {
        self.at_rest() == other.at_rest()
    }

    /// The document with zero velocities, spins and friction.
    fn at_rest(&self) -> Self {
        let mut still = self.clone();
        // Refinement around the impact depends on the velocities, which are then kept.
        let stands = !self.is_refined_around_impact();
        for body in still.bodies.iter_mut().filter(|_| stands) {
            body.velocity_m_per_s = [0.0; 3];
            body.spin_rad_per_s = [0.0; 3];
        }
        still.contact.friction = 0.0;
        if let ContactPairs::List(pairs) = &mut still.contact.pairs {
            for pair in pairs {
                pair.friction = None;
            }
        }
        still
    }
}

impl SceneDocument {
    /// Whether a mesh depends on the velocities.
    pub fn is_refined_around_impact(&self) -> bool {
        let mut refinements = self.bodies.iter().flat_map(|body| &body.refinement);
        refinements.any(|refinement| refinement.around == Around::Impact)
    }
}

impl ContactDocument {
    /// Coefficient of friction of the first pair [-], or of pairs that do not give their own.
    pub fn friction_of_first_pair(&self) -> f64 {
        match &self.pairs {
            ContactPairs::List(pairs) => {
                pairs.first().and_then(|pair| pair.friction).unwrap_or(self.friction)
            }
            ContactPairs::All(_) => self.friction,
        }
    }
}
