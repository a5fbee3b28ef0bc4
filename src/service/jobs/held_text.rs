//! A text with the memory that counts for it.

use std::ops::Deref;
use tokio::sync::OwnedSemaphorePermit;

/// A text of a client. As long as it lives, wherever it is handed on to, it holds its part of the memory that all such texts share.
#[derive(Debug, Default)]
pub struct HeldText {
    bytes: Vec<u8>,
    memory: Option<OwnedSemaphorePermit>,
}

impl HeldText {
    /// A text that holds a part of the memory.
    pub fn new(bytes: Vec<u8>, memory: Option<OwnedSemaphorePermit>) -> Self {
        Self { bytes, memory }
    }

    /// The text, and what counts for it until it is dropped, apart.
    pub fn into_parts(self) -> (Vec<u8>, Option<OwnedSemaphorePermit>) {
        (self.bytes, self.memory)
    }
}

impl From<Vec<u8>> for HeldText {
    /// A text that counts for nothing.
    fn from(bytes: Vec<u8>) -> Self {
        Self::new(bytes, None)
    }
}

impl Deref for HeldText {
    type Target = [u8];

    fn deref(&self) -> &[u8] {
        &self.bytes
    }
}
