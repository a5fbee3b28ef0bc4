//! Measures evaluated during a run: impact force, contact patch, depth of significant stress, absorbed energy, and the
//! summary composed of them.
//!
//! A [`MeasuringRecorder`] accumulates every frame of a run in its [`Measures`], once, and passes it to the [`Sink`]s
//! as a [`MeasuredFrame`]; a run without one is not measured, at no cost. What needs stresses at quadrature points
//! (depth of significant stress, peak values, nodal fields) is evaluated at the field times only, because the stepper
//! does not store stresses; what needs whole bodies (ranges of the laws, interpenetration) once in each fiftieth of a
//! run without a field time, too; everything else at every step.

pub mod absorbed_energy;
pub mod artificial_end;
pub mod channel_class;
pub mod computed;
pub mod contact_patch;
pub mod contact_time;
pub mod convergence;
pub mod deflection;
pub mod depth_profile;
pub mod depth_ridge;
pub mod eroded;
pub mod exceeded;
mod face_shape;
pub mod fields;
pub mod hourglass_energy;
pub mod impact_force;
pub mod impulse_history;
pub mod law_range;
mod measures;
pub mod pair;
pub mod penetration;
pub mod presented_area;
mod sink;
pub mod squeeze;
pub mod stress_depth;
pub mod stress_field;
pub mod summary;
pub mod tissue_parts;
pub mod wave_reach;

pub use convergence::REFINEMENT;
pub use measures::Measures;
pub use sink::{MeasuredEnd, MeasuredFrame, MeasuringRecorder, Sink};
pub use summary::{
    BulkModulusChange, Compared, ComparedRuns, ErrorBars, Level, QuantityOfInterest, QuantityTitle,
    RequestedAccuracy, Results, Summary, render_table,
};
