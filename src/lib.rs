//! Contuse answers one question: *this projectile hits this tissue at this speed: what happens to the tissue?*
//!
//! The flow of the data, and the order in which to read the crate:
//!
//! ```text
//! scene document ──validate──▶ Scene ──compile──▶ Plan ──advance──▶ State ──frame──▶ Recorder
//! ```
//!
//! 1. [`scene`]: what is requested, in the terms of the user.
//! 2. [`plan`]: the scene compiled to what it needs, and nothing else.
//! 3. [`step`]: the state, the integrators, the energy ledger, the loop.
//! 4. [`mechanics`]: the mathematics: laws, elements, contact.
//! 5. [`mesh`], [`measure`], [`record`], [`study`], [`report`], and on top `service` and [`cli`]; [`blobs`] stores
//!    bytes.
//!
//! Imports run one way: `blobs < mechanics < mesh < scene < plan < step < measure < record < study < report < service < cli`.

pub mod blobs;
pub mod cli;
pub mod measure;
pub mod mesh;
pub mod plan;
pub mod record;
pub mod report;
pub mod scene;
#[cfg(feature = "service")]
pub mod service;
pub mod step;
pub mod study;

pub use contuse_mechanics as mechanics;
