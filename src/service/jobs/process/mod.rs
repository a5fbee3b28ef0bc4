//! Runs in processes of their own: one that takes too much memory, crashes or is killed fails by itself, and the service and the other
//! runs do not notice.
//!
//! [`ProcessEngine`] starts the program once more for each run (`contuse job-process`, [`serve_one`]) and talks with it over pipes. The
//! child has no access to the job store or the blobs: it asks for meshes and results. It writes the recording in the data folder.
//!
//! - `wire`: the messages of both sides.
//! - `child`, `group`, `engine`: the side of the service.
//! - `inside`, `host`, `limits`: the side of the child.

mod child;
mod engine;
mod group;
mod host;
mod inside;
mod limits;
mod pipe;
mod wire;

pub use child::MMAP_THRESHOLD;
pub use engine::ProcessEngine;
pub use group::Groups;
pub use inside::serve_one;
