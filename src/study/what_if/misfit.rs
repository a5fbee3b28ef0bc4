//! Why a change does not fit the scene.

use serde_json::Value;

/// Why a change does not fit the scene: the member of the change that is wrong, its value, what it must be, a remedy.
#[derive(Clone, Debug, PartialEq)]
pub struct Misfit {
    /// Member of the change.
    pub field: &'static str,
    /// What was found there.
    pub value: Value,
    /// What is wrong.
    pub message: String,
    /// What it must be.
    pub limit: String,
    /// What to do.
    pub remedy: String,
}
