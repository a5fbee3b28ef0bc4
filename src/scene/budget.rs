//! How large a scene may be. Checked before anything of that size is allocated.

use serde::{Deserialize, Serialize};

/// Upper limits of a scene; each is inclusive.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Budget {
    /// Bytes of the document.
    pub document_bytes: u64,
    /// Bytes of one mesh file.
    pub mesh_bytes: u64,
    /// Bodies and planes together.
    pub bodies: u64,
    /// Elements of all bodies together.
    pub elements: u64,
    /// Steps to the end, as estimated from the shortest edge and the wave speed at rest.
    pub steps: u64,
    /// Bytes of plan and state, as estimated from the counts.
    pub memory_bytes: u64,
    /// Frames of fields.
    pub frames: u64,
    /// Bytes of the fields of all frames, before compression.
    pub recording_bytes: u64,
}

const MB: u64 = 1_000_000;
const GB: u64 = 1_000_000_000;

impl Budget {
    /// What a person at a command line may ask of their own machine: enough to stop slips of the pen.
    pub const COMMAND_LINE: Self = Self {
        document_bytes: 64 * MB,
        mesh_bytes: 2 * GB,
        bodies: 1_000,
        elements: 5_000_000,
        steps: 50_000_000,
        memory_bytes: 64 * GB,
        frames: 100_000,
        recording_bytes: 200 * GB,
    };
    /// What a stranger may ask of a service.
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
