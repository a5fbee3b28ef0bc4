//! Bearer tokens: who has access, to what, and until when.

use crate::blobs::hexadecimal;
use crate::report::date::now;
use sha2::{Digest, Sha256};

/// Beginning of the digest of a token in a file.
const DIGEST: &str = "sha256:";
/// Beginning of the last day of a token in a file.
const UNTIL: &str = "until=";
/// Least number of characters of a token.
const SHORTEST: usize = 16;

/// What a token allows: each scope with all before it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Scope {
    /// To read the counters of the service.
    Metrics,
    /// To read the jobs and meshes of its owner.
    Read,
    /// To submit, cancel and delete them.
    Submit,
}

impl Scope {
    /// All scopes, each with all before it.
    pub const ALL: [Self; 3] = [Self::Metrics, Self::Read, Self::Submit];

    /// Name in a file.
    pub fn as_str(self) -> &'static str {
        match self {
            Self::Metrics => "metrics",
            Self::Read => "read",
            Self::Submit => "submit",
        }
    }

    /// The scope with a name.
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|scope| scope.as_str() == name)
    }
}

/// A token as a file has it, without the token itself.
#[derive(Clone, Debug, PartialEq, Eq)]
struct Entry {
    owner: String,
    digest: [u8; 32],
    scope: Scope,
    /// Last day in UTC, as `2026-12-31`.
    until: Option<String>,
}

/// Who presented a token.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Grant<'a> {
    /// Name of the owner.
    pub owner: &'a str,
    /// What the token allows.
    pub scope: Scope,
    /// Whether its last day is over.
    pub is_expired: bool,
}

/// Bearer tokens with the names of their owners. Only their digests are stored.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Tokens {
    entries: Vec<Entry>,
    in_clear: usize,
}

/// Why a list of tokens was rejected.
#[derive(Debug, PartialEq, Eq, thiserror::Error)]
pub enum TokensError {
    /// A line that has no owner and token, or more than these with a scope and a last day.
    #[error(
        "line {line}: expected `name sha256:digest`, then `read`, `submit` or `metrics` and `until=2026-12-31` where these apply"
    )]
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
    /// A token that an earlier line has too.
    #[error("line {line}: this token came before")]
    Repeated {
        /// Line number, from 1.
        line: usize,
    },
}

impl Tokens {
    /// Parses `name sha256:digest [scope] [until=date]` or `name token …`, one per line; empty lines and lines that begin with `#` are
    /// ignored. The scope is `submit` by default. An owner may have several tokens.
    ///
    /// # Errors
    /// A malformed line, a token below 16 characters, or a repeated token.
    pub fn parse(text: &str) -> Result<Self, TokensError> {
        let mut tokens = Self::default();
        // Some editors begin a file with a mark, which is no part of a name.
        let text = text.strip_prefix('\u{feff}').unwrap_or(text);
        for (index, line) in text.lines().enumerate() {
            let line_number = index + 1;
            let words: Vec<&str> = line.split_whitespace().collect();
            match words.as_slice() {
                [] => {}
                [first, ..] if first.starts_with('#') => {}
                [name, token, more @ ..] => tokens.add(name, token, more, line_number)?,
                _ => return Err(TokensError::Malformed { line: line_number }),
            }
        }
        Ok(tokens)
    }

    fn add(&mut self, name: &str, token: &str, more: &[&str], line: usize) -> Result<(), TokensError> {
        let digest = match token.strip_prefix(DIGEST) {
            Some(digits) => bytes_of(digits).ok_or(TokensError::BadDigest { line })?,
            None if token.len() < SHORTEST => return Err(TokensError::TooShort { line }),
            None => {
                self.in_clear += 1;
                Sha256::digest(token.as_bytes()).into()
            }
        };
        let (mut scope, mut until) = (None, None);
        for word in more {
            let day = word.strip_prefix(UNTIL).filter(|day| is_day(day));
            match (Scope::from_name(word), day) {
                (Some(found), _) if scope.is_none() => scope = Some(found),
                (None, Some(day)) if until.is_none() => until = Some(day.to_owned()),
                _ => return Err(TokensError::Malformed { line }),
            }
        }
        if self.entries.iter().any(|entry| entry.digest == digest) {
            return Err(TokensError::Repeated { line });
        }
        let (owner, scope) = (name.to_owned(), scope.unwrap_or(Scope::Submit));
        self.entries.push(Entry { owner, digest, scope, until });
        Ok(())
    }

    /// Line of a file that lets `name` in with `token`, without the token itself, until a last day.
    pub fn line(name: &str, token: &str, scope: Scope, until: Option<&str>) -> String {
        let digest = hexadecimal(&Sha256::digest(token.as_bytes()));
        let until = until.map(|day| format!(" {UNTIL}{day}")).unwrap_or_default();
        format!("{name} {DIGEST}{digest} {}{until}", scope.as_str())
    }

    /// Number of tokens that stand in the file themselves, not as a digest.
    pub fn in_clear(&self) -> usize {
        self.in_clear
    }

    /// Whether there are none: access is open to everyone.
    pub fn is_open(&self) -> bool {
        self.entries.is_empty()
    }

    /// Who a token belongs to, and what it allows. The time taken depends neither on how much of a token is correct nor on which one it is.
    pub fn grant(&self, token: &str) -> Option<Grant<'_>> {
        let presented: [u8; 32] = Sha256::digest(token.as_bytes()).into();
        let mut found = None;
        for entry in &self.entries {
            let difference = entry.digest.iter().zip(&presented).fold(0_u8, |acc, (a, b)| acc | (a ^ b));
            if std::hint::black_box(difference) == 0 {
                found = Some(entry);
            }
        }
        found.map(|entry| {
            let today = now();
            let is_expired = entry.until.as_deref().is_some_and(|day| today.get(..10) > Some(day));
            Grant { owner: &entry.owner, scope: entry.scope, is_expired }
        })
    }
}

/// Whether a text is a day like `2026-12-31`.
pub fn is_day(text: &str) -> bool {
    let pattern = text.bytes().map(|b| if b.is_ascii_digit() { b'0' } else { b });
    let number = |range| text.get(range).and_then(|digits: &str| digits.parse::<u8>().ok());
    pattern.eq(*b"0000-00-00")
        && number(5..7).is_some_and(|month| (1..=12).contains(&month))
        && number(8..10).is_some_and(|day| (1..=31).contains(&day))
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

    const ANNA: &str = "0123456789abcdef";

    #[test]
    fn tokens_name_their_owner_alone() {
        let tokens =
            Tokens::parse("\u{feff}# staff\nanna 0123456789abcdef\n\nbert fedcba9876543210\n").unwrap();
        let owner = |token| tokens.grant(token).map(|grant| grant.owner);
        assert_eq!(owner(ANNA), Some("anna"));
        assert_eq!(owner("fedcba9876543210"), Some("bert"));
        assert_eq!(owner("0123456789abcdeF"), None);
        assert_eq!(owner(""), None);
        assert!(!tokens.is_open());
    }

    #[test]
    fn a_file_need_not_hold_the_tokens() {
        let line = Tokens::line("anna", ANNA, Scope::Submit, None);
        assert!(!line.contains(ANNA));
        let tokens = Tokens::parse(&format!("{line}\nbert fedcba9876543210")).unwrap();
        assert_eq!(tokens.grant(ANNA).unwrap().owner, "anna");
        assert_eq!(tokens.grant(line.split(' ').nth(1).unwrap()), None, "the digest is no token");
        assert_eq!(tokens.in_clear(), 1);
        assert_eq!(Tokens::parse("anna sha256:12").unwrap_err(), TokensError::BadDigest { line: 1 });
    }

    #[test]
    fn a_token_has_a_scope_and_a_last_day() {
        let grant = |scope, until| {
            let tokens = Tokens::parse(&Tokens::line("anna", ANNA, scope, until)).unwrap();
            let grant = tokens.grant(ANNA).unwrap();
            (grant.scope, grant.is_expired)
        };
        let today = now();
        assert_eq!(grant(Scope::Read, today.get(..10)), (Scope::Read, false));
        assert_eq!(grant(Scope::Metrics, Some("2024-12-31")), (Scope::Metrics, true));
        assert_eq!(grant(Scope::Submit, Some("9999-01-01")), (Scope::Submit, false));
        for more in ["write", "until=tomorrow", "until=2026-13-01", "read submit", "read read"] {
            let refused = Tokens::parse(&format!("anna {ANNA} {more}")).unwrap_err();
            assert_eq!(refused, TokensError::Malformed { line: 1 }, "{more}");
        }
    }

    #[test]
    fn weak_or_unclear_tokens_are_refused() {
        assert_eq!(Tokens::parse("anna short").unwrap_err(), TokensError::TooShort { line: 1 });
        assert_eq!(Tokens::parse("\nanna").unwrap_err(), TokensError::Malformed { line: 2 });
        let twice = "anna 0123456789abcdef\nbert 0123456789abcdef";
        assert_eq!(Tokens::parse(twice).unwrap_err(), TokensError::Repeated { line: 2 });
        assert!(
            Tokens::parse("anna 0123456789abcdef\nanna fedcba9876543210").is_ok(),
            "to replace one by another"
        );
        assert!(Tokens::parse("").unwrap().is_open());
    }
}
