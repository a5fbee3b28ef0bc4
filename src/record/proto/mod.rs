//! Messages of a recording: the Rust side of `api/recording.proto` and of the Foxglove schemas.
//!
//! `build.rs` generates the structs from `api/recording.fds`, the compiled descriptors that are written to every file
//! (`tests/python/compile_schemas.py` generates and checks them). The `.proto` files document messages and fields.

mod conversion;
#[cfg(test)]
mod tests;

/// Packages as their files refer to each other.
#[allow(missing_docs, clippy::pedantic)]
mod generated {
    pub mod foxglove {
        include!(concat!(env!("OUT_DIR"), "/foxglove.rs"));
    }
    pub mod contuse {
        pub mod v1 {
            include!(concat!(env!("OUT_DIR"), "/contuse.v1.rs"));
        }
    }
}

pub use conversion::timestamp;
pub use generated::contuse::v1 as contuse;
pub use generated::foxglove;

use super::RecordError;
use prost::Message;
use prost_types::{FileDescriptorProto, FileDescriptorSet};
use std::sync::LazyLock;

/// The compiled `.proto` files, dependencies before their dependents.
pub const DESCRIPTORS: &[u8] = include_bytes!("../../../api/recording.fds");

/// The decoded descriptors; empty if the build embedded something else, in which case every schema is missing.
static DECODED: LazyLock<FileDescriptorSet> =
    LazyLock::new(|| FileDescriptorSet::decode(DESCRIPTORS).unwrap_or_default());

/// Serialised descriptor set of one message type: its file and the imports.
///
/// # Errors
/// `MissingSchema` if there is no such message.
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
