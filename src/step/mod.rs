//! State, the integrators (explicit and implicit), the energy ledger, the loop, and the trait [`Recorder`].
//!
//! One step at time t_n, from `u_n` and the velocity `v₋` of the last half step (see `explicit.rs`):
//! internal forces and energies → step size → contact-free velocity → contact → ledger → recorders → new positions.

mod contact;
mod erosion;
mod explicit;
mod failure;
mod frame;
mod frame_copy;
mod implicit;
mod integrator;
mod ledger;
mod loads;
mod motion;
mod place;
mod rigid;
mod run;
mod state;

pub use failure::{ElementPlace, Failure, FailureCause};
pub use frame::{Ending, Frame, Outcome, Recorder, RecorderError};
pub use frame_copy::{FieldCopy, FrameCopy};
pub use ledger::{BodyEnergy, Energy, Ledger, PairLedger};
pub use run::{Interrupt, RunOptions, run, run_from};
pub use state::{Held, ImplicitMemory, State, Tangent};
