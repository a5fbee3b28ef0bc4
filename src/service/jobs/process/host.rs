//! What the process of a run asks the service for: meshes, and results by content.

use super::wire::{self, FromChild, ToChild};
use crate::blobs::{Blob, BlobEntry, BlobError, BlobStore, Unnamed};
use crate::scene::{MeshBytes, MeshSource, MeshSourceError};
use crate::service::jobs::engine::{Meshes, OpenMesh};
use crate::service::shelves::result_key;
use std::fmt;
use std::io::{self, Cursor, Write};
use std::sync::mpsc::Receiver;
use std::sync::{Arc, Mutex, PoisonError};

/// The pipe to the service, and its answers.
pub(super) struct Host {
    output: Mutex<Box<dyn Write + Send>>,
    answers: Mutex<Receiver<(ToChild, Vec<u8>)>>,
}

impl fmt::Debug for Host {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("Host")
    }
}

impl Host {
    /// A host behind a pipe, whose answers arrive in their order.
    pub fn new(output: Box<dyn Write + Send>, answers: Receiver<(ToChild, Vec<u8>)>) -> Self {
        Self { output: Mutex::new(output), answers: Mutex::new(answers) }
    }

    /// Sends a message with its bytes.
    pub fn send(&self, message: &FromChild, bytes: &[u8]) -> io::Result<()> {
        let mut output = self.output.lock().unwrap_or_else(PoisonError::into_inner);
        wire::write(&mut *output, message, bytes.len() as u64, &mut &*bytes)
    }

    /// Sends a question with its bytes, and waits for the answer. One at a time.
    fn ask(&self, question: &FromChild, bytes: &[u8]) -> io::Result<(ToChild, Vec<u8>)> {
        let answers = self.answers.lock().unwrap_or_else(PoisonError::into_inner);
        self.send(question, bytes)?;
        answers.recv().map_err(|_| io::ErrorKind::BrokenPipe.into())
    }
}

/// Meshes of the service.
pub(super) struct HostMeshes(pub Arc<Host>);

impl MeshSource for HostMeshes {
    fn read(&self, name: &str, limit: u64) -> Result<MeshBytes, MeshSourceError> {
        match self.0.ask(&FromChild::Mesh { name: name.to_owned(), limit }, &[]) {
            Ok((ToChild::Mesh(found), bytes)) => Ok(MeshBytes { file_name: found?, bytes }),
            _ => Err(MeshSourceError::Unreadable {
                name: name.to_owned(),
                reason: "the service does not answer".into(),
            }),
        }
    }
}

impl Meshes for HostMeshes {
    fn open(&self, name: &str, limit: u64) -> Result<OpenMesh, MeshSourceError> {
        let MeshBytes { file_name, bytes } = self.read(name, limit)?;
        Ok(OpenMesh { file_name, bytes: bytes.len() as u64, content: Box::new(Cursor::new(bytes)) })
    }
}

/// Results by content: the only blobs that a run reads or keeps.
#[derive(Debug)]
pub(super) struct HostResults(pub Arc<Host>);

impl HostResults {
    /// The key of a result by its name.
    fn key(name: &str) -> io::Result<String> {
        result_key(name).map(str::to_owned).ok_or_else(|| io::ErrorKind::Unsupported.into())
    }
}

fn unexpected() -> io::Error {
    io::Error::other("an answer that was not requested")
}

impl BlobStore for HostResults {
    fn unnamed(&self) -> Result<Box<dyn Unnamed>, BlobError> {
        Ok(Box::new(UnnamedResult { host: Arc::clone(&self.0), bytes: Vec::new() }))
    }

    fn open(&self, name: &str) -> Result<Option<Box<dyn Blob>>, BlobError> {
        let requested = Self::key(name).and_then(|key| self.0.ask(&FromChild::Result { key }, &[]));
        match requested.map_err(BlobError::of(name))? {
            (ToChild::Result(true), bytes) => Ok(Some(Box::new(Cursor::new(bytes)))),
            (ToChild::Result(false), _) => Ok(None),
            _ => Err(BlobError::of(name)(unexpected())),
        }
    }

    fn delete(&self, name: &str) -> Result<(), BlobError> {
        Err(BlobError::of(name)(io::ErrorKind::Unsupported.into()))
    }

    fn list(&self, shelf: &str) -> Result<Vec<BlobEntry>, BlobError> {
        Err(BlobError::of(shelf)(io::ErrorKind::Unsupported.into()))
    }
}

/// A result that is being written.
struct UnnamedResult {
    host: Arc<Host>,
    bytes: Vec<u8>,
}

impl Unnamed for UnnamedResult {
    fn append(&mut self, bytes: &[u8]) -> io::Result<()> {
        self.bytes.write_all(bytes)
    }

    fn open(&self) -> io::Result<Box<dyn Blob>> {
        Ok(Box::new(Cursor::new(self.bytes.clone())))
    }

    fn keep(self: Box<Self>, name: &str) -> io::Result<()> {
        let question = FromChild::KeepResult { key: HostResults::key(name)? };
        match self.host.ask(&question, &self.bytes)? {
            (ToChild::Result(true), _) => Ok(()),
            (ToChild::Result(false), _) => Err(io::Error::other("the service could not keep it")),
            _ => Err(unexpected()),
        }
    }
}
