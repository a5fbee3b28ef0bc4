//! What the service may use, and where it listens. Every limit has a default; nothing is unlimited.

use crate::scene::Budget;
use sha2::{Digest, Sha256};
use std::net::SocketAddr;
use std::path::PathBuf;
use std::time::Duration;

/// Everything that can be set about the service.
#[derive(Clone, Debug)]
pub struct ServiceConfig {
    /// Address to listen on; port 0 takes a free one.
    pub listen: SocketAddr,
    /// Folder of the job store, the meshes and the recordings.
    pub data: PathBuf,
    /// Jobs that run at the same time.
    pub workers: usize,
    /// Threads of each run.
    pub threads_per_job: usize,
    /// Cases of a what-if question that run at the same time.
    pub threads_per_what_if: usize,
    /// Jobs that may wait at the same time.
    pub max_queued: u64,
    /// Connections at the same time; more wait in the listen queue of the system.
    pub max_connections: usize,
    /// How long a client may take for the headers of a request, and for its JSON body.
    pub request_timeout: Duration,
    /// How long a client may take to upload a mesh.
    pub upload_timeout: Duration,
    /// Wall-clock time that a job may run.
    pub deadline: Duration,
    /// How long running jobs and open answers may go on after a request to shut down.
    pub grace: Duration,
    /// How often a job is taken up before it counts as the one that kills its worker.
    pub max_attempts: u32,
    /// What a scene may ask for; also the largest document and the largest mesh.
    pub budget: Budget,
    /// Who may use the service; everybody when empty.
    pub tokens: Tokens,
    /// Origins of web pages that may change things; pages of any origin may read when this is empty.
    pub cors_origins: Vec<String>,
    /// Silence on an event stream after which a comment is sent.
    pub heartbeat: Duration,
}

impl Default for ServiceConfig {
    fn default() -> Self {
        Self {
            listen: SocketAddr::from(([127, 0, 0, 1], 8080)),
            data: PathBuf::from("data"),
            workers: std::thread::available_parallelism().map_or(1, usize::from),
            threads_per_job: 1,
            threads_per_what_if: std::thread::available_parallelism().map_or(1, usize::from),
            max_queued: 1000,
            max_connections: 512,
            request_timeout: Duration::from_secs(30),
            upload_timeout: Duration::from_secs(600),
            deadline: Duration::from_secs(3600),
            grace: Duration::from_secs(20),
            max_attempts: 3,
            budget: Budget::SERVICE,
            tokens: Tokens::default(),
            cors_origins: Vec::new(),
            heartbeat: Duration::from_secs(15),
        }
    }
}

/// Bearer tokens, each with the name of its owner. Only their digests are kept.
#[derive(Clone, Debug, Default)]
pub struct Tokens {
    entries: Vec<(String, [u8; 32])>,
}

/// Why a list of tokens was refused.
#[derive(Debug, PartialEq, Eq, thiserror::Error)]
pub enum TokensError {
    /// A line that is not `name token`.
    #[error("line {line}: expected `name token`")]
    Malformed {
        /// The line, from 1.
        line: usize,
    },
    /// A token that can be guessed.
    #[error("line {line}: a token must have at least 16 characters")]
    TooShort {
        /// The line, from 1.
        line: usize,
    },
    /// A name or a token that came before.
    #[error("line {line}: this name or token came before")]
    Repeated {
        /// The line, from 1.
        line: usize,
    },
}

impl Tokens {
    /// Reads `name token`, one a line; empty lines and lines that begin with `#` say nothing.
    ///
    /// # Errors
    /// A line of another form, a token below 16 characters, or a name or token that came before.
    pub fn parse(text: &str) -> Result<Self, TokensError> {
        let mut entries: Vec<(String, [u8; 32])> = Vec::new();
        for (index, line) in text.lines().enumerate() {
            let line_number = index + 1;
            let words: Vec<&str> = line.split_whitespace().collect();
            match words.as_slice() {
                [] => {}
                [first, ..] if first.starts_with('#') => {}
                [name, token] => {
                    if token.len() < 16 {
                        return Err(TokensError::TooShort { line: line_number });
                    }
                    let digest: [u8; 32] = Sha256::digest(token.as_bytes()).into();
                    if entries.iter().any(|(n, d)| n == name || *d == digest) {
                        return Err(TokensError::Repeated { line: line_number });
                    }
                    entries.push(((*name).to_owned(), digest));
                }
                _ => return Err(TokensError::Malformed { line: line_number }),
            }
        }
        Ok(Self { entries })
    }

    /// Whether anybody may use the service.
    pub fn is_open(&self) -> bool {
        self.entries.is_empty()
    }

    /// The owner of a token. The time taken depends neither on how much of a token is right nor on which one it is.
    pub fn owner(&self, token: &str) -> Option<&str> {
        let presented: [u8; 32] = Sha256::digest(token.as_bytes()).into();
        let mut found = None;
        for (name, digest) in &self.entries {
            let difference = digest.iter().zip(&presented).fold(0_u8, |acc, (a, b)| acc | (a ^ b));
            if std::hint::black_box(difference) == 0 {
                found = Some(name.as_str());
            }
        }
        found
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tokens_name_their_owner_and_nobody_else() {
        let tokens = Tokens::parse("# staff\nanna 0123456789abcdef\n\nbert fedcba9876543210\n").unwrap();
        assert_eq!(tokens.owner("0123456789abcdef"), Some("anna"));
        assert_eq!(tokens.owner("fedcba9876543210"), Some("bert"));
        assert_eq!(tokens.owner("0123456789abcdeF"), None);
        assert_eq!(tokens.owner(""), None);
        assert!(!tokens.is_open());
    }

    #[test]
    fn weak_or_unclear_tokens_are_refused() {
        assert_eq!(Tokens::parse("anna short").unwrap_err(), TokensError::TooShort { line: 1 });
        assert_eq!(Tokens::parse("\nanna").unwrap_err(), TokensError::Malformed { line: 2 });
        let twice = "anna 0123456789abcdef\nbert 0123456789abcdef";
        assert_eq!(Tokens::parse(twice).unwrap_err(), TokensError::Repeated { line: 2 });
        assert!(Tokens::parse("").unwrap().is_open());
    }
}
