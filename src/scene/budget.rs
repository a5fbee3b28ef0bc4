//! Limits on the size of a scene, checked before anything of that size is allocated.

use serde::{Deserialize, Serialize};

/// Upper limits of a scene; each is inclusive.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Budget {
    /// Size of the document [bytes].
    pub document_bytes: u64,
    /// Size of one mesh file [bytes].
    pub mesh_bytes: u64,
    /// Number of bodies and planes together.
    pub bodies: u64,
    /// Number of elements of all bodies together.
    pub elements: u64,
    /// Number of steps to the end, estimated from the shortest edge and the wave speed at rest.
    pub steps: u64,
    /// Size of plan and state [bytes], estimated from the counts.
    pub memory_bytes: u64,
    /// Number of field frames.
    pub frames: u64,
    /// Size of the fields of all frames before compression [bytes].
    pub recording_bytes: u64,
}

const MB: u64 = 1_000_000;
const GB: u64 = 1_000_000_000;

impl Budget {
    /// Limits of the command line, high enough for any intended scene: they find typing errors.
    pub const COMMAND_LINE: Self = Self {
        document_bytes: 64 * MB,
        mesh_bytes: 2 * GB,
        bodies: 10_000,
        elements: 5_000_000,
        steps: 50_000_000,
        memory_bytes: 64 * GB,
        frames: 100_000,
        recording_bytes: 200 * GB,
    };
    /// Limits of a service, for unknown users.
    pub const SERVICE: Self = Self {
        document_bytes: 4 * MB,
        mesh_bytes: 100 * MB,
        bodies: 64,
        elements: 200_000,
        steps: 1_000_000,
        memory_bytes: 2 * GB,
        frames: 2_000,
        recording_bytes: 4 * GB,
    };
}

impl Default for Budget {
    fn default() -> Self {
        Self::COMMAND_LINE
    }
}
