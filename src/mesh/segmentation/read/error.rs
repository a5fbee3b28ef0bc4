//! Errors of the readers of label volumes.

use crate::mesh::{MeshError, Place};

/// An error at a byte.
pub(super) fn malformed(byte: usize, message: impl Into<String>) -> MeshError {
    MeshError::Malformed { place: Place::Byte(byte), message: message.into() }
}
