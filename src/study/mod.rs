//! Studies: from the one run of a scene to many.

pub mod coverage;
pub mod error;
mod error_bars;
pub mod leave_out;
pub mod palette;
mod png;
pub mod setting;
pub mod single;
pub mod stability;
mod variant;
pub mod what_if;

pub use leave_out::{Difference, LeaveOutRequest, LeaveOutRow, LeaveOutStudy, study_leave_out};
pub use png::png;
pub use setting::Setting;
pub use single::{Phase, Progress, RunError, RunRequest, RunResult, process_cpu_s, run_scene};
