//! Blobs in an object store, such as S3 or one with its interface.
//!
//! Drafts are local files until they are named. A blob is read in pieces, which grow while they follow each other; the store is asked for
//! the version that was opened, so that a reader never gets bytes of two.

use super::folder::UnnamedFile;
use super::{Blob, BlobDigest, BlobEntry, BlobError, BlobStore, FolderBlobs, Unnamed};
use object_store::aws::{AmazonS3Builder, AmazonS3ConfigKey};
use object_store::path::Path as ObjectPath;
use object_store::{
    ClientConfigKey, Error, GetOptions, GetRange, MultipartUpload, ObjectStore, ObjectStoreExt as _,
    PutPayload, RetryConfig,
};
use std::fs::File;
use std::io::{self, ErrorKind, Read, Seek, SeekFrom};
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::sync::{Arc, mpsc};
use std::time::{Duration, Instant};
use tokio::runtime::Handle;

/// Bytes that are read when a blob is opened, and after a jump.
const FIRST_PIECE: u64 = 256 << 10;
/// Most bytes that are read at a time.
const LARGEST_PIECE: u64 = 8 << 20;
/// Bytes that are sent at a time; larger blobs are sent in parts.
const PART: usize = 8 << 20;

/// Blobs as objects of a store, under a prefix. Any number of processes may use it.
#[derive(Clone, Debug)]
pub struct ObjectBlobs {
    store: Arc<dyn ObjectStore>,
    prefix: String,
    /// Address of the store, for people.
    address: String,
    /// Local folder of drafts.
    drafts: PathBuf,
    /// How long a request is tried while the store does not answer.
    patience: Duration,
    runtime: Handle,
}

/// Longest pause between two attempts.
const LONGEST_PAUSE: Duration = Duration::from_secs(5);
/// Longest time of one attempt, unless a variable says otherwise.
const LONGEST_ATTEMPT: Duration = Duration::from_secs(30);

impl ObjectBlobs {
    /// The store at `s3://bucket/prefix`, with endpoint, region and credentials in the variables `AWS_*`; drafts are files in a local
    /// folder. While the store does not answer, a request is tried for `patience`. Within a runtime, which does the requests.
    ///
    /// # Errors
    /// If the address or a variable is invalid, or the folder cannot be used.
    pub fn open(address: &str, drafts: &Path, patience: Duration) -> Result<Self, BlobError> {
        let failed = |reason: String| BlobError::of(address)(io::Error::new(ErrorKind::InvalidInput, reason));
        let rest = address
            .strip_prefix("s3://")
            .ok_or_else(|| failed("not an address s3://bucket/prefix".into()))?;
        let (bucket, prefix) = rest.split_once('/').unwrap_or((rest, ""));
        if bucket.is_empty() || bucket.contains(['@', ':', '?']) {
            // Not shown: it may hold keys.
            let reason = "the bucket of an address s3://bucket/prefix has neither keys nor a port: those are AWS_ACCESS_KEY_ID, AWS_SECRET_ACCESS_KEY and AWS_ENDPOINT_URL";
            return Err(BlobError::of("s3://…")(io::Error::new(ErrorKind::InvalidInput, reason)));
        }
        let endpoint = ["AWS_ENDPOINT_URL_S3", "AWS_ENDPOINT_URL", "AWS_ENDPOINT"]
            .iter()
            .find_map(|name| std::env::var(name).ok());
        // Attempts are repeated here, whatever the fault.
        let retry = RetryConfig { max_retries: 1, ..RetryConfig::default() };
        let mut builder = AmazonS3Builder::from_env().with_bucket_name(bucket).with_retry(retry);
        if patience < LONGEST_ATTEMPT {
            let timeout = format!("{} s", patience.as_secs().max(1));
            builder = builder.with_config(AmazonS3ConfigKey::Client(ClientConfigKey::Timeout), timeout);
        }
        if let Some(endpoint) = endpoint {
            builder = builder.with_allow_http(endpoint.starts_with("http://")).with_endpoint(endpoint);
        }
        let store = builder.build().map_err(|error| failed(error.to_string()))?;
        Ok(Self { patience, ..Self::of(Arc::new(store), prefix, address, drafts)? })
    }

    /// Blobs under a prefix of any object store, whose address is for people; each request is tried once.
    ///
    /// # Errors
    /// If the local folder cannot be used, or outside a runtime.
    pub fn of(
        store: Arc<dyn ObjectStore>,
        prefix: &str,
        address: &str,
        drafts: &Path,
    ) -> Result<Self, BlobError> {
        // Removes drafts of processes that no longer exist.
        FolderBlobs::open(drafts)?;
        let runtime =
            Handle::try_current().map_err(|error| BlobError::of(address)(io::Error::other(error)))?;
        let address = address.trim_end_matches('/').to_owned();
        Ok(Self {
            store,
            prefix: prefix.trim_matches('/').to_owned(),
            address,
            drafts: drafts.to_owned(),
            patience: Duration::ZERO,
            runtime,
        })
    }

    fn path(&self, name: &str) -> ObjectPath {
        ObjectPath::from(format!("{}/{name}", self.prefix))
    }

    /// Repeats requests, which are the same whether they are done once or twice, while the store does not answer.
    fn persist<T>(&self, attempt: impl Fn() -> io::Result<T>) -> io::Result<T> {
        let (begun, mut pause) = (Instant::now(), Duration::from_millis(200));
        loop {
            match attempt() {
                Err(error)
                    if error.kind() == ErrorKind::NetworkDown && begun.elapsed() + pause < self.patience =>
                {
                    tracing::debug!(%error, "the object store does not answer");
                    std::thread::sleep(pause);
                    pause = LONGEST_PAUSE.min(2 * pause);
                }
                other => return other,
            }
        }
    }

    /// Does requests in the runtime while this thread waits, whichever it is.
    fn wait<T: Send + 'static>(
        &self,
        requests: impl Future<Output = Result<T, Error>> + Send + 'static,
    ) -> io::Result<T> {
        let (sender, receiver) = mpsc::sync_channel(1);
        self.runtime.spawn(async move { sender.send(requests.await) });
        let answer = receiver.recv().map_err(|_| io::Error::other("the program is ending"))?;
        answer.map_err(|error| match error {
            Error::NotFound { .. } => io::Error::new(ErrorKind::NotFound, error),
            Error::Precondition { .. } => io::Error::other("it was replaced while it was read"),
            Error::PermissionDenied { .. } | Error::Unauthenticated { .. } => {
                io::Error::new(ErrorKind::PermissionDenied, error)
            }
            _ => io::Error::new(ErrorKind::NetworkDown, error),
        })
    }

    /// Makes a file a blob.
    fn upload(&self, file: &Path, name: &str) -> io::Result<()> {
        self.persist(|| self.try_upload(file, name))
    }

    fn try_upload(&self, file: &Path, name: &str) -> io::Result<()> {
        let mut file = File::open(file)?;
        let first = part(&mut file)?;
        let (store, path) = (Arc::clone(&self.store), self.path(name));
        if first.len() < PART {
            return self.wait(async move { store.put(&path, first.into()).await }).map(drop);
        }
        let mut upload = self.wait(async move { store.put_multipart(&path).await })?;
        match self.send_parts(&mut upload, first, &mut file) {
            Ok(()) => self.wait(async move { upload.complete().await }).map(drop),
            Err(error) => {
                // The error is that of the upload, whether or not its parts can be removed.
                let _ = self.wait(async move { upload.abort().await });
                Err(error)
            }
        }
    }

    /// Sends the parts of a file one after the other.
    fn send_parts(
        &self,
        upload: &mut Box<dyn MultipartUpload>,
        first: Vec<u8>,
        file: &mut File,
    ) -> io::Result<()> {
        let mut piece = first;
        while !piece.is_empty() {
            let sent = upload.put_part(PutPayload::from(piece));
            self.wait(sent)?;
            piece = part(file)?;
        }
        Ok(())
    }
}

/// The next part of a file; shorter at its end, and empty after it.
fn part(file: &mut File) -> io::Result<Vec<u8>> {
    let mut bytes = Vec::new();
    file.take(PART as u64).read_to_end(&mut bytes)?;
    Ok(bytes)
}

impl BlobStore for ObjectBlobs {
    fn unnamed(&self) -> Result<Box<dyn Unnamed>, BlobError> {
        let file = UnnamedFile::create(&self.drafts);
        let file = file.map_err(BlobError::of(self.drafts.display().to_string()))?;
        Ok(Box::new(UnnamedObject { file, blobs: self.clone() }))
    }

    fn open(&self, name: &str) -> Result<Option<Box<dyn Blob>>, BlobError> {
        match OpenObject::new(self, name) {
            Ok(object) => Ok(Some(Box::new(object))),
            Err(error) if error.kind() == ErrorKind::NotFound => Ok(None),
            Err(error) => Err(BlobError::of(name)(error)),
        }
    }

    fn delete(&self, name: &str) -> Result<(), BlobError> {
        let deleted = self.persist(|| {
            let (store, path) = (Arc::clone(&self.store), self.path(name));
            self.wait(async move { store.delete(&path).await })
        });
        match deleted {
            Err(error) if error.kind() != ErrorKind::NotFound => Err(BlobError::of(name)(error)),
            _ => Ok(()),
        }
    }

    fn list(&self, shelf: &str) -> Result<Vec<BlobEntry>, BlobError> {
        let listed = self.persist(|| {
            let (store, path) = (Arc::clone(&self.store), self.path(shelf));
            self.wait(async move { store.list_with_delimiter(Some(&path)).await })
        });
        let objects = listed.map_err(BlobError::of(shelf))?.objects;
        let name = |file: &str| if shelf.is_empty() { file.to_owned() } else { format!("{shelf}/{file}") };
        Ok(objects
            .into_iter()
            .filter_map(|object| {
                Some(BlobEntry { name: name(object.location.filename()?), kept: object.last_modified.into() })
            })
            .collect())
    }

    fn place(&self, name: &str) -> String {
        format!("{}/{name}", self.address)
    }

    fn adopt(&self, file: &Path, name: &str) -> Result<BlobDigest, BlobError> {
        let of_file = || BlobError::of(file.display().to_string());
        let digest = File::open(file).and_then(BlobDigest::of).map_err(of_file())?;
        self.try_upload(file, name).map_err(BlobError::of(name))?;
        std::fs::remove_file(file).map_err(of_file())?;
        Ok(digest)
    }
}

/// A draft as a local file.
struct UnnamedObject {
    file: UnnamedFile,
    blobs: ObjectBlobs,
}

impl Unnamed for UnnamedObject {
    fn append(&mut self, bytes: &[u8]) -> io::Result<()> {
        self.file.append(bytes)
    }

    fn open(&self) -> io::Result<Box<dyn Blob>> {
        self.file.open()
    }

    fn keep(self: Box<Self>, name: &str) -> io::Result<()> {
        self.blobs.upload(self.file.path(), name)
    }
}

/// A version of an object that is being read.
struct OpenObject {
    blobs: ObjectBlobs,
    path: ObjectPath,
    /// Name of the version.
    tag: Option<String>,
    size: u64,
    /// The next byte to read.
    position: u64,
    /// Bytes of the object from `start` on.
    piece: Vec<u8>,
    start: u64,
}

impl OpenObject {
    fn new(blobs: &ObjectBlobs, name: &str) -> io::Result<Self> {
        let path = blobs.path(name);
        let head = blobs.persist(|| {
            let (store, path) = (Arc::clone(&blobs.store), path.clone());
            blobs.wait(async move { store.head(&path).await })
        })?;
        let mut object = Self {
            blobs: blobs.clone(),
            path,
            tag: head.e_tag,
            size: head.size,
            position: 0,
            piece: vec![],
            start: 0,
        };
        object.fetch(FIRST_PIECE)?;
        Ok(object)
    }

    /// Reads up to `length` bytes from the position on.
    fn fetch(&mut self, length: u64) -> io::Result<()> {
        let range: Range<u64> = self.position..self.size.min(self.position + length);
        self.piece =
            if range.is_empty() { Vec::new() } else { self.blobs.persist(|| self.get(range.clone()))? };
        self.start = self.position;
        Ok(())
    }

    fn get(&self, range: Range<u64>) -> io::Result<Vec<u8>> {
        let (store, path, tag) = (Arc::clone(&self.blobs.store), self.path.clone(), self.tag.clone());
        let options =
            GetOptions { range: Some(GetRange::Bounded(range)), if_match: tag, ..GetOptions::default() };
        self.blobs.wait(async move { Ok(store.get_opts(&path, options).await?.bytes().await?.into()) })
    }
}

impl Read for OpenObject {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        if self.position >= self.size || buffer.is_empty() {
            return Ok(0);
        }
        let (length, end) = (self.piece.len() as u64, self.start + self.piece.len() as u64);
        if self.position == end {
            self.fetch((2 * length).clamp(FIRST_PIECE, LARGEST_PIECE))?;
        } else if !(self.start..end).contains(&self.position) {
            self.fetch(FIRST_PIECE)?;
        }
        let mut rest = &self.piece[(self.position - self.start) as usize..];
        if rest.is_empty() {
            return Err(ErrorKind::UnexpectedEof.into());
        }
        let n = rest.read(buffer)?;
        self.position += n as u64;
        Ok(n)
    }
}

impl Seek for OpenObject {
    fn seek(&mut self, to: SeekFrom) -> io::Result<u64> {
        let position = match to {
            SeekFrom::Start(n) => Some(n),
            SeekFrom::End(n) => self.size.checked_add_signed(n),
            SeekFrom::Current(n) => self.position.checked_add_signed(n),
        };
        self.position = position.ok_or(ErrorKind::InvalidInput)?;
        Ok(self.position)
    }
}
