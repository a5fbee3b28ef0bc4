//! Time integration in a scene document.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Time integration scheme with its parameters.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(tag = "kind", rename_all = "snake_case", deny_unknown_fields)]
pub enum IntegratorDocument {
    /// Central differences with velocities at half steps, contact on the end-of-step gap.
    Explicit {
        /// Time step as a fraction of the critical time step, 0 … 1.
        #[serde(default = "default_safety")]
        safety_factor: f64,
        /// Largest time step [s]; unbounded by default.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        max_step_s: Option<f64>,
        /// Largest change of length of an element's edge or diagonal in a step, `h max|D|` [-]: limits the step where
        /// elements are crushed.
        #[serde(default = "default_strain_increment")]
        largest_strain_increment: f64,
        /// Linear bulk viscosity b1 [-].
        #[serde(default = "default_linear_viscosity")]
        linear_bulk_viscosity: f64,
        /// Quadratic bulk viscosity b2 [-].
        #[serde(default = "default_quadratic_viscosity")]
        quadratic_bulk_viscosity: f64,
        /// Largest error of the energy balance before the run fails [-].
        #[serde(default = "default_energy_gate")]
        energy_gate: f64,
    },
    /// The θ scheme: `M (v⁺ − v) = h [ξ f⁺ + (1 − ξ) f] + Cᵀ p`, `u⁺ = u + h [θ v⁺ + (1 − θ) v]`, contact on the end
    /// velocity. For slow or stiff scenes; no bulk viscosity.
    Implicit {
        /// Time step [s]; halved where it does not converge, and increased again.
        step_s: f64,
        /// Weight θ of the end velocity, 0.5 (conserves the energy of linear bodies) … 1 (damps most) [-].
        #[serde(default = "default_theta")]
        theta: f64,
        /// Weight ξ of the end forces, 0.5 … 1 [-]; θ by default.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        xi: Option<f64>,
        /// Mean forces of the step whose work equals the stored strain energy exactly: without contact, energy and both
        /// momenta are conserved at any step, for large motions too. Contact conserves the linear momentum; the angular
        /// momentum to first order in the step, since reactions act at the positions of the start of the step. For θ = ξ =
        /// 0.5; each iteration evaluates the internal forces twice.
        #[serde(default, skip_serializing_if = "std::ops::Not::not")]
        energy_momentum: bool,
        /// Largest residual of the momentum, relative to the impulses of the step [-].
        #[serde(default = "default_newton_tolerance")]
        newton_tolerance: f64,
        /// The run fails when a step would have to be shorter than this [s]; 1e-4 of `step_s` by default.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        smallest_step_s: Option<f64>,
        /// Largest error of the energy balance before the run fails [-].
        #[serde(default = "default_energy_gate")]
        energy_gate: f64,
    },
    /// Explicit or implicit steps, whichever is estimated to cost less; `contuse plan` reports both estimates.
    Auto {
        /// Length of implicit steps [s], the resolved time scale. By default 1/100 of the run, but no longer than the
        /// fastest body takes for half of the shortest element edge.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        step_s: Option<f64>,
        /// Weight θ of the end velocity in implicit steps, 0.5 … 1 [-]; 0.6 damps unresolved frequencies.
        #[serde(default = "default_damping_theta")]
        theta: f64,
        /// Largest error of the energy balance before the run fails [-].
        #[serde(default = "default_energy_gate")]
        energy_gate: f64,
    },
    /// Equilibrium without mass, in load steps on a pseudo-time: for slow scenes. Friction acts on the slip of a load step.
    QuasiStatic {
        /// Load step [s]; halved where it does not converge, and increased again.
        step_s: f64,
        /// Whether time is real for relaxation: Prony series relax over the load steps. By default it only orders the loads, and all
        /// has relaxed.
        #[serde(default, skip_serializing_if = "std::ops::Not::not")]
        real_time: bool,
        /// Largest residual of the equilibrium, relative to the forces [-].
        #[serde(default = "default_newton_tolerance")]
        newton_tolerance: f64,
        /// The run fails when a load step would have to be shorter than this [s]; 1e-4 of `step_s` by default.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        smallest_step_s: Option<f64>,
        /// Largest error of the energy balance before the run fails [-].
        #[serde(default = "default_energy_gate")]
        energy_gate: f64,
    },
}

impl IntegratorDocument {
    /// Default safety factor: explicit step over critical time step.
    pub const SAFETY: f64 = 0.9;

    /// Whether every step solves linear systems.
    pub fn is_implicit(&self) -> bool {
        matches!(self, Self::Implicit { .. } | Self::QuasiStatic { .. })
    }
    /// Time step [s] for a shortest crossing time `shortest` [s] of a wave through an element; `auto` counts as explicit.
    pub fn step(&self, shortest: f64) -> f64 {
        match self {
            Self::Explicit { safety_factor, max_step_s, .. } => {
                (safety_factor * shortest).min(max_step_s.unwrap_or(f64::INFINITY))
            }
            Self::Implicit { step_s, .. } | Self::QuasiStatic { step_s, .. } => *step_s,
            Self::Auto { .. } => Self::SAFETY * shortest,
        }
    }
    /// Whether time is only a pseudo-time that orders the loads.
    pub fn is_quasi_static(&self) -> bool {
        matches!(self, Self::QuasiStatic { .. })
    }
    /// Limits the step to at most `longest` [s].
    pub fn limit_step(&mut self, longest: f64) {
        match self {
            Self::Explicit { max_step_s, .. } => {
                *max_step_s = Some(max_step_s.map_or(longest, |step| step.min(longest)));
            }
            Self::Implicit { step_s, .. } | Self::QuasiStatic { step_s, .. } => {
                *step_s = step_s.min(longest);
            }
            Self::Auto { step_s, .. } => *step_s = Some(step_s.map_or(longest, |step| step.min(longest))),
        }
    }
    /// Divides the step by `divisor`; that of `auto` only where its length is given.
    pub fn divide_step(&mut self, divisor: f64) {
        match self {
            Self::Explicit { safety_factor, largest_strain_increment, .. } => {
                *safety_factor /= divisor;
                *largest_strain_increment /= divisor;
            }
            Self::Implicit { step_s: step, .. }
            | Self::QuasiStatic { step_s: step, .. }
            | Self::Auto { step_s: Some(step), .. } => *step /= divisor,
            Self::Auto { step_s: None, .. } => {}
        }
    }
    /// Implicit steps of a length [s], with default settings.
    pub fn implicit(step_s: f64) -> Self {
        Self::implicit_with(step_s, default_theta(), default_energy_gate())
    }
    /// Implicit steps of a length [s] with a weight θ [-] and a limit on the energy balance error [-].
    pub fn implicit_with(step_s: f64, theta: f64, energy_gate: f64) -> Self {
        let (newton_tolerance, smallest_step_s) = (default_newton_tolerance(), None);
        let (xi, energy_momentum) = (None, false);
        Self::Implicit { step_s, theta, xi, energy_momentum, newton_tolerance, smallest_step_s, energy_gate }
    }
    /// Explicit steps of at most a length [s] with a limit on the energy balance error [-].
    pub fn explicit_with(max_step_s: Option<f64>, energy_gate: f64) -> Self {
        Self::Explicit {
            safety_factor: Self::SAFETY,
            max_step_s,
            largest_strain_increment: default_strain_increment(),
            linear_bulk_viscosity: default_linear_viscosity(),
            quadratic_bulk_viscosity: default_quadratic_viscosity(),
            energy_gate,
        }
    }
    /// Largest error of the energy balance before the run fails [-].
    pub fn energy_gate(&self) -> f64 {
        match self {
            Self::Explicit { energy_gate, .. }
            | Self::Implicit { energy_gate, .. }
            | Self::QuasiStatic { energy_gate, .. }
            | Self::Auto { energy_gate, .. } => *energy_gate,
        }
    }
}

fn default_theta() -> f64 {
    0.5
}
fn default_damping_theta() -> f64 {
    0.6
}
fn default_newton_tolerance() -> f64 {
    1e-8
}

fn default_safety() -> f64 {
    IntegratorDocument::SAFETY
}
fn default_strain_increment() -> f64 {
    0.1
}
fn default_linear_viscosity() -> f64 {
    0.06
}
fn default_quadratic_viscosity() -> f64 {
    1.2
}
fn default_energy_gate() -> f64 {
    0.01
}

impl Default for IntegratorDocument {
    fn default() -> Self {
        Self::explicit_with(None, default_energy_gate())
    }
}
