//! A text with the memory that counts for it.

use std::ops::Deref;
use tokio::sync::OwnedSemaphorePermit;

/// What counts for a text: a part of the memory for all such texts, and of that for those of its client.
#[derive(Debug)]
pub struct HeldMemory {
    /// Of the memory for all.
    pub of_all: OwnedSemaphorePermit,
    /// Of the memory for one client.
    pub of_client: OwnedSemaphorePermit,
}

impl HeldMemory {
    /// Gives back what is beyond so many units.
    pub fn shrink(&mut self, units: usize) {
        for part in [&mut self.of_all, &mut self.of_client] {
            drop(part.split(part.num_permits().saturating_sub(units)));
        }
    }
}

/// A text of a client. As long as it lives, wherever it is handed on to, it holds its part of the memory that all such texts share.
#[derive(Debug, Default)]
pub struct HeldText {
    bytes: Vec<u8>,
    memory: Option<HeldMemory>,
}

impl HeldText {
    /// A text that holds a part of the memory.
    pub fn new(bytes: Vec<u8>, memory: Option<HeldMemory>) -> Self {
        Self { bytes, memory }
    }

    /// The text, and what counts for it until it is dropped, apart.
    pub fn into_parts(self) -> (Vec<u8>, Option<HeldMemory>) {
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
