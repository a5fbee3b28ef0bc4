//! Why a change does not fit the scene.

use serde_json::Value;

/// Why a change does not fit the scene: the offending member of the change, its value, its limit, and a remedy.
#[derive(Clone, Debug, PartialEq)]
pub struct Misfit {
    /// Offending member of the change.
    pub field: &'static str,
    /// Value of that member.
    pub value: Value,
    /// Description of the problem.
    pub message: String,
    /// Admissible values of the member.
    pub limit: String,
    /// Suggested correction of the question.
    pub remedy: String,
}
