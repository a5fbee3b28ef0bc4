//! The tokens that are in force: those of a file, read again when it changes.

use super::tokens::{Tokens, TokensError};
use std::path::{Path, PathBuf};
use std::sync::{Arc, PoisonError, RwLock};
use std::time::{Duration, SystemTime};
use tokio::sync::watch;

/// Time between two looks at the file of tokens.
const LOOK_INTERVAL: Duration = Duration::from_secs(1);

/// Why a file of tokens is not used.
#[derive(Debug, thiserror::Error)]
pub enum TokensFileError {
    /// It cannot be read.
    #[error("{0}")]
    Unreadable(#[from] std::io::Error),
    /// A pipe or a device, whose end may never come.
    #[error("it is not a regular file")]
    Irregular,
    /// A line is wrong.
    #[error(transparent)]
    Wrong(#[from] TokensError),
    /// It has no token.
    #[error("it holds no token: no client could use the service")]
    Empty,
}

/// Reads the tokens of a regular file.
///
/// # Errors
/// If it cannot be read, is a pipe or a device, a line is wrong, or there is no token.
pub fn read_tokens(file: &Path) -> Result<Tokens, TokensFileError> {
    if !std::fs::metadata(file)?.is_file() {
        return Err(TokensFileError::Irregular);
    }
    let tokens = Tokens::parse(&std::fs::read_to_string(file)?)?;
    if tokens.is_open() { Err(TokensFileError::Empty) } else { Ok(tokens) }
}

/// The tokens that are in force.
#[derive(Debug, Default)]
pub struct Access(RwLock<Arc<Tokens>>);

impl Access {
    /// Access with these tokens.
    pub fn new(tokens: Tokens) -> Self {
        Self(RwLock::new(Arc::new(tokens)))
    }

    /// The tokens at this moment.
    pub fn tokens(&self) -> Arc<Tokens> {
        Arc::clone(&self.0.read().unwrap_or_else(PoisonError::into_inner))
    }

    /// Reads the tokens again whenever their file changes, until `closing` becomes true. A file that is wrong, or does not answer, changes
    /// nothing.
    pub async fn follow(&self, file: PathBuf, mut closing: watch::Receiver<bool>) {
        let mut known = None;
        loop {
            let file = file.clone();
            // Not on a thread of the runtime, since a file system of a network may not answer.
            let looking = tokio::task::spawn_blocking(move || look(&file, known));
            tokio::select! {
                Ok((found, tokens)) = looking => {
                    known = Some(found);
                    if let Some(tokens) = tokens {
                        self.take(tokens);
                    }
                }
                _ = closing.wait_for(|closing| *closing) => return,
            }
            tokio::select! {
                () = tokio::time::sleep(LOOK_INTERVAL) => {}
                _ = closing.wait_for(|closing| *closing) => return,
            }
        }
    }

    fn take(&self, tokens: Result<Tokens, TokensFileError>) {
        match tokens {
            Ok(tokens) => {
                *self.0.write().unwrap_or_else(PoisonError::into_inner) = Arc::new(tokens);
                tracing::info!("the tokens were read again");
            }
            Err(error) => tracing::error!(%error, "the tokens are unchanged: their file has an error"),
        }
    }
}

/// What is compared of a file: when it was changed, and its size; `None` if there is no such file.
type Known = Option<(SystemTime, u64)>;

/// Looks at a file, and reads its tokens if it is no longer as it was known.
fn look(file: &Path, known: Option<Known>) -> (Known, Option<Result<Tokens, TokensFileError>>) {
    let found = changed(file);
    let is_new = known.is_some_and(|known| known != found);
    (found, is_new.then(|| read_tokens(file)))
}

fn changed(file: &Path) -> Known {
    let found = std::fs::metadata(file).ok()?;
    Some((found.modified().ok()?, found.len()))
}
