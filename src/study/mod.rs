//! Studies: from a single run of a scene to many.

mod accuracy;
pub mod bulk_modulus;
mod bulk_modulus_choice;
mod clock;
pub mod coverage;
pub mod error;
mod error_bars;
mod levels;
pub mod material_fit;
pub mod omissions;
pub mod palette;
#[cfg(feature = "png")]
mod png;
mod precision;
pub mod process;
pub mod progress;
mod run;
pub mod setting;
pub mod single;
pub mod stability;
mod variant;
pub mod what_if;

pub use omissions::{
    ASYMMETRY, Difference, OmissionsRequest, OmissionsRow, OmissionsStudy, Theory, study_omissions,
};
#[cfg(feature = "png")]
pub use png::png;
pub use process::process_cpu_s;
pub use progress::{AccuracyProgress, Phase, Progress, Stage};
pub use run::run_scene;
pub use setting::Setting;
pub use single::{RunError, RunRequest, RunResult};
