//! The messages of a recording: the Rust side of `api/recording.proto` and of the Foxglove schemas.
//!
//! The structs are written by hand, so that building needs no protoc. `api/recording.fds` holds the compiled descriptors that
//! go into every file (`tests/python/compile_schemas.py` makes and checks them); the tests hold the structs against them.

pub mod contuse;
pub mod foxglove;
#[cfg(test)]
mod tests;

use super::RecordError;
use prost::Message;
use prost_types::{FileDescriptorProto, FileDescriptorSet};
use std::sync::LazyLock;

/// The compiled `.proto` files, dependencies before their dependents.
pub const DESCRIPTORS: &[u8] = include_bytes!("../../../api/recording.fds");

/// The same, decoded; empty if the build put in something else, and then every schema is missing.
static DECODED: LazyLock<FileDescriptorSet> =
    LazyLock::new(|| FileDescriptorSet::decode(DESCRIPTORS).unwrap_or_default());

/// The descriptor set of one message type, serialised: its file and what that imports.
///
/// # Errors
/// `MissingSchema` when there is no such message.
pub fn schema_of(message: &str) -> Result<Vec<u8>, RecordError> {
    let missing = || RecordError::MissingSchema(message.to_owned());
    let all = &*DECODED;
    let home = all.file.iter().find(|file| declares(file, message)).ok_or_else(missing)?;
    let mut needed = vec![home.name().to_owned()];
    let mut next = 0;
    while let Some(name) = needed.get(next).cloned() {
        next += 1;
        let file = all.file.iter().find(|file| file.name() == name).ok_or_else(missing)?;
        let new: Vec<_> = file.dependency.iter().filter(|d| !needed.contains(d)).cloned().collect();
        needed.extend(new);
    }
    let file =
        all.file.iter().filter(|file| needed.iter().any(|name| name == file.name())).cloned().collect();
    Ok(FileDescriptorSet { file }.encode_to_vec())
}

/// Whether a file declares a message with this full name.
fn declares(file: &FileDescriptorProto, message: &str) -> bool {
    file.message_type.iter().any(|m| message == format!("{}.{}", file.package(), m.name()))
}
