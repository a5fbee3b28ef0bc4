//! State, the integrators (explicit and implicit), the energy ledger, the loop, and the trait [`Recorder`].
//!
//! One step at time t_n, from `u_n` and the velocity `v₋` of the last half step (see `explicit.rs`):
//! internal forces and energies → step size → contact-free velocity → contact → ledger → recorders → new positions.

mod assembled;
mod balance;
mod branches;
mod contact;
mod energy;
mod erosion;
mod explicit;
mod failure;
mod frame;
mod frame_copy;
mod implicit;
mod integrator;
mod interrupt;
mod ledger;
mod loads;
mod motion;
mod phase;
mod place;
mod rigid;
mod run;
mod state;
mod step_work;
mod stepper;
mod unfold;

pub use energy::{BodyEnergy, BranchEnergy, Energy, PairLedger};
pub use failure::{ElementPlace, Failure, FailureCause};
pub use frame::{Ending, Frame, Outcome, Recorder, RecorderError};
pub use frame_copy::{FieldCopy, FrameCopy};
pub use interrupt::{Ask, Interrupt};
pub use ledger::Ledger;
pub use run::{RunOptions, run, run_from};
pub use state::{Held, ImplicitMemory, State, Tangent};
