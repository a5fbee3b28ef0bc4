//! The tokens that are in force: those of a file, read again when it changes.

use super::tokens::{Tokens, TokensError};
use std::path::Path;
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
    /// A line is wrong.
    #[error(transparent)]
    Wrong(#[from] TokensError),
    /// It has no token.
    #[error("it holds no token: no client could use the service")]
    Empty,
}

/// Reads the tokens of a file.
///
/// # Errors
/// If it cannot be read, a line is wrong, or there is no token.
pub fn read_tokens(file: &Path) -> Result<Tokens, TokensFileError> {
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

    /// Reads the tokens again whenever their file changes, until `closing` becomes true. A file that is wrong changes nothing.
    pub async fn follow(&self, file: &Path, mut closing: watch::Receiver<bool>) {
        let mut known = changed(file);
        loop {
            tokio::select! {
                () = tokio::time::sleep(LOOK_INTERVAL) => {}
                _ = closing.wait_for(|closing| *closing) => return,
            }
            let found = changed(file);
            if found == known {
                continue;
            }
            known = found;
            match read_tokens(file) {
                Ok(tokens) => {
                    *self.0.write().unwrap_or_else(PoisonError::into_inner) = Arc::new(tokens);
                    tracing::info!("the tokens were read again");
                }
                Err(error) => tracing::error!(%error, "the tokens are unchanged: their file has an error"),
            }
        }
    }
}

/// When a file was changed, and its size; `None` if there is no such file.
fn changed(file: &Path) -> Option<(SystemTime, u64)> {
    let found = std::fs::metadata(file).ok()?;
    Some((found.modified().ok()?, found.len()))
}
