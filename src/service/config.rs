//! Limits and addresses of the service. Every limit has a default; nothing is unlimited.

use super::memory;
use crate::blobs::hexadecimal;
use crate::scene::Budget;
use sha2::{Digest, Sha256};
use std::net::SocketAddr;
use std::path::PathBuf;
use std::time::Duration;

/// Configuration of the service.
#[derive(Clone, Debug)]
pub struct ServiceConfig {
    /// Address to listen on; port 0 selects a free one.
    pub listen: SocketAddr,
    /// Folder of the job store, the meshes and the recordings.
    pub data: PathBuf,
    /// Number of jobs running at the same time.
    pub workers: usize,
    /// Number of threads for each run.
    pub threads_per_job: usize,
    /// Number of cases of a what-if question running at the same time.
    pub threads_per_what_if: usize,
    /// Memory of all running jobs together, by their estimates [bytes]; a job waits until its own is free.
    pub max_running_memory: u64,
    /// Maximum number of waiting jobs.
    pub max_queued: u64,
    /// Maximum number of simultaneous connections; more wait in the listen queue of the system.
    pub max_connections: usize,
    /// Maximum number of waiting validations of small scenes, and of large ones.
    pub max_validations_waiting: usize,
    /// Maximum time that a validation waits.
    pub validation_patience: Duration,
    /// Time allowed to a client for the headers of a request, and for its JSON body.
    pub request_timeout: Duration,
    /// Time allowed to a client for the upload of a mesh.
    pub upload_timeout: Duration,
    /// Least rate of uploads and downloads [bytes/s]; slower clients are cut off after `request_timeout`.
    pub least_rate: u64,
    /// Free space of the disk below which no job is accepted or begun [bytes].
    pub least_free: u64,
    /// Wall-clock limit of a job.
    pub deadline: Duration,
    /// Grace period of running jobs and open responses after a request to shut down.
    pub grace: Duration,
    /// Days after which jobs that have ended, and meshes, are deleted; never if `None`.
    pub keep_days: Option<u32>,
    /// Number of attempts after which a job counts as the cause of losing its worker.
    pub max_attempts: u32,
    /// Limits of a scene; also the largest document and the largest mesh.
    pub budget: Budget,
    /// Tokens that grant access; open to everyone if empty.
    pub tokens: Tokens,
    /// Origins of web pages that may use the service, beside its own.
    pub cors_origins: Vec<String>,
    /// Names under which a service without tokens is reached, beside `localhost` and the addresses of this machine.
    pub hosts: Vec<String>,
    /// Idle time of an event stream after which a comment is sent.
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
            max_running_memory: memory::usable().map_or(u64::MAX, |bytes| bytes / 4 * 3),
            max_queued: 1000,
            max_connections: 512,
            max_validations_waiting: 64,
            validation_patience: Duration::from_secs(30),
            request_timeout: Duration::from_secs(30),
            upload_timeout: Duration::from_secs(600),
            least_rate: 4096,
            least_free: 64 << 20,
            deadline: Duration::from_secs(3600),
            grace: Duration::from_secs(20),
            keep_days: None,
            max_attempts: 3,
            budget: Budget::SERVICE,
            tokens: Tokens::default(),
            cors_origins: Vec::new(),
            hosts: Vec::new(),
            heartbeat: Duration::from_secs(15),
        }
    }
}

/// Beginning of the digest of a token in a file.
const DIGEST: &str = "sha256:";

/// Bearer tokens with the names of their owners. Only their digests are stored.
#[derive(Clone, Debug, Default)]
pub struct Tokens {
    entries: Vec<(String, [u8; 32])>,
    in_clear: usize,
}

/// Why a list of tokens was rejected.
#[derive(Debug, PartialEq, Eq, thiserror::Error)]
pub enum TokensError {
    /// A line that is not `name token`.
    #[error("line {line}: expected `name sha256:digest` or `name token`")]
    Malformed {
        /// Line number, from 1.
        line: usize,
    },
    /// A token short enough to be guessed.
    #[error("line {line}: a token must have at least 16 characters")]
    TooShort {
        /// Line number, from 1.
        line: usize,
    },
    /// A digest that is none of SHA-256.
    #[error(
        "line {line}: a digest has 64 hexadecimal digits after `sha256:`; `contuse token NAME` makes such a line"
    )]
    BadDigest {
        /// Line number, from 1.
        line: usize,
    },
    /// A repeated name or token.
    #[error("line {line}: this name or token came before")]
    Repeated {
        /// Line number, from 1.
        line: usize,
    },
}

impl Tokens {
    /// Parses `name sha256:digest` or `name token`, one per line; empty lines and lines that begin with `#` are ignored.
    ///
    /// # Errors
    /// A malformed line, a token below 16 characters, or a repeated name or token.
    pub fn parse(text: &str) -> Result<Self, TokensError> {
        let (mut entries, mut in_clear) = (Vec::<(String, [u8; 32])>::new(), 0);
        for (index, line) in text.lines().enumerate() {
            let line_number = index + 1;
            let words: Vec<&str> = line.split_whitespace().collect();
            match words.as_slice() {
                [] => {}
                [first, ..] if first.starts_with('#') => {}
                [name, token] => {
                    let digest = match token.strip_prefix(DIGEST) {
                        Some(digits) => {
                            bytes_of(digits).ok_or(TokensError::BadDigest { line: line_number })?
                        }
                        None if token.len() < 16 => return Err(TokensError::TooShort { line: line_number }),
                        None => {
                            in_clear += 1;
                            Sha256::digest(token.as_bytes()).into()
                        }
                    };
                    if entries.iter().any(|(n, d)| n == name || *d == digest) {
                        return Err(TokensError::Repeated { line: line_number });
                    }
                    entries.push(((*name).to_owned(), digest));
                }
                _ => return Err(TokensError::Malformed { line: line_number }),
            }
        }
        Ok(Self { entries, in_clear })
    }

    /// Line of a file that lets `name` in with `token`, without the token itself.
    pub fn line(name: &str, token: &str) -> String {
        format!("{name} {DIGEST}{}", hexadecimal(&Sha256::digest(token.as_bytes())))
    }

    /// Number of tokens that stand in the file themselves, not as a digest.
    pub fn in_clear(&self) -> usize {
        self.in_clear
    }

    /// Whether access is open to everyone.
    pub fn is_open(&self) -> bool {
        self.entries.is_empty()
    }

    /// The owner of a token. The time taken depends neither on how much of a token is correct nor on which one it is.
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

/// The bytes of 64 hexadecimal digits.
fn bytes_of(digits: &str) -> Option<[u8; 32]> {
    let mut bytes = [0; 32];
    if digits.len() != 64 || !digits.bytes().all(|b| b.is_ascii_hexdigit()) {
        return None;
    }
    for (byte, pair) in bytes.iter_mut().zip(digits.as_bytes().chunks(2)) {
        *byte = u8::from_str_radix(std::str::from_utf8(pair).ok()?, 16).ok()?;
    }
    Some(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tokens_name_their_owner_alone() {
        let tokens = Tokens::parse("# staff\nanna 0123456789abcdef\n\nbert fedcba9876543210\n").unwrap();
        assert_eq!(tokens.owner("0123456789abcdef"), Some("anna"));
        assert_eq!(tokens.owner("fedcba9876543210"), Some("bert"));
        assert_eq!(tokens.owner("0123456789abcdeF"), None);
        assert_eq!(tokens.owner(""), None);
        assert!(!tokens.is_open());
    }

    #[test]
    fn a_file_need_not_hold_the_tokens() {
        let line = Tokens::line("anna", "0123456789abcdef");
        assert!(!line.contains("0123456789abcdef"));
        let tokens = Tokens::parse(&format!("{line}\nbert fedcba9876543210")).unwrap();
        assert_eq!(tokens.owner("0123456789abcdef"), Some("anna"));
        assert_eq!(tokens.owner(line.split_once(' ').unwrap().1), None, "the digest is no token");
        assert_eq!(tokens.in_clear(), 1);
        assert_eq!(Tokens::parse("anna sha256:12").unwrap_err(), TokensError::BadDigest { line: 1 });
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
