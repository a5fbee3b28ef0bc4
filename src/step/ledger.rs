//! The energy ledger: what was done to whom, and whether it adds up.

use crate::mechanics::tensor::Vec3;
use serde::Serialize;

/// Running sums of work, part of the state. Each is the work done up to t_n, of which the impulses at t_n count half
/// (with `½ v₋`), see [`Energy`].
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Ledger {
    /// Dissipated by bulk viscosity in each body [J].
    pub viscous: Vec<f64>,
    /// Work of external forces (gravity) on each body [J].
    pub external: Vec<f64>,
    /// Work of the contact reactions on each body [J].
    pub contact_work: Vec<f64>,
    /// Strain energy put in by the position projection in each body [J].
    pub projection: Vec<f64>,
    /// One for each contact pair.
    pub pairs: Vec<PairLedger>,
}

/// Running sums of one contact pair.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct PairLedger {
    /// Impulse on the slave so far [N s], x, y, z.
    pub impulse_n_s: [f64; 3],
    /// Dissipated by friction so far, ≥ 0 [J].
    pub friction_j: f64,
    /// Numerical contact dissipation so far: what lumped contact nodes lose when they are caught [J].
    pub numerical_j: f64,
    /// Work on the slave's body so far [J].
    pub work_on_slave_j: f64,
    /// Work on the master's body so far [J].
    pub work_on_master_j: f64,
}

/// Energy of one body at t_n.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct BodyEnergy {
    /// Kinetic, `½ v₋ᵀ M v₊` with the flight velocity in [J].
    pub kinetic_j: f64,
    /// Strain, ∫ψ dV [J].
    pub strain_j: f64,
    /// Dissipated by bulk viscosity so far [J].
    pub viscous_j: f64,
    /// Work of the contact reactions on it so far [J].
    pub contact_work_j: f64,
    /// Work of external forces on it so far [J].
    pub external_work_j: f64,
    /// Strain energy put in by position projection so far [J].
    pub projection_j: f64,
}

/// The ledger at t_n.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Energy {
    /// One for each body.
    pub bodies: Vec<BodyEnergy>,
    /// One for each contact pair.
    pub pairs: Vec<PairLedger>,
    /// Sum of kinetic, strain, viscous, friction and numerical contact dissipation [J].
    pub total_j: f64,
    /// The same at the start [J].
    pub initial_total_j: f64,
    /// Work of external forces and of the position projection so far [J].
    pub external_work_j: f64,
    /// |total − initial − external| / max(K₀ + strain₀, peak strain, Σ|W_ext|, Σ dissipation) [-].
    pub balance_error: f64,
    /// Linear momentum [kg m/s].
    pub momentum_kg_m_per_s: [f64; 3],
    /// Angular momentum about the origin [kg m²/s].
    pub angular_momentum_kg_m2_per_s: [f64; 3],
}

impl Energy {
    /// Strain + kinetic energy and dissipation (viscous) of a body [J].
    pub fn of_body(&self, body: usize) -> f64 {
        let b = &self.bodies[body];
        b.kinetic_j + b.strain_j + b.viscous_j
    }
}

/// A [`Vec3`] as an array.
pub(super) fn array(v: &Vec3) -> [f64; 3] {
    [v.x, v.y, v.z]
}
