//! Headers of lines `key: value` or `key = value`, before binary data.

use crate::mesh::{MeshError, Place};
use std::collections::BTreeMap;

/// Largest size of a header [bytes].
const LONGEST: usize = 1 << 20;

/// Fields of a header: line and value of each, by its key in lower case.
pub(super) struct TextHeader {
    fields: BTreeMap<String, (usize, String)>,
    /// Keys of users, which NRRD marks by `:=`, with their values: they say nothing of the voxels.
    of_users: BTreeMap<String, String>,
    /// Place of the data, after the last line of the header.
    pub(super) end: usize,
}

/// Found text, truncated for a message.
fn shown(text: &str) -> String {
    text.chars().take(40).collect()
}

/// An error in a line.
pub(super) fn in_line(line: usize, message: impl Into<String>) -> MeshError {
    MeshError::Malformed { place: Place::Line(line), message: message.into() }
}

impl TextHeader {
    /// Reads lines until `is_last` says that one is; `mark` stands between key and value. Comments begin with `#`.
    ///
    /// # Errors
    /// `Malformed` for a line without the mark, a repeated key, and a header that does not end.
    pub(super) fn read(bytes: &[u8], mark: &str, is_last: impl Fn(&str) -> bool) -> Result<Self, MeshError> {
        let (mut fields, mut of_users, mut at) = (BTreeMap::new(), BTreeMap::new(), 0);
        for line in 1.. {
            let rest = &bytes[at..bytes.len().min(LONGEST)];
            let length = rest.iter().position(|byte| *byte == b'\n');
            let length = length.ok_or_else(|| in_line(line, "the header does not end"))?;
            let text = String::from_utf8_lossy(&rest[..length]);
            let text = text.trim();
            at += length + 1;
            if let Some((key, value)) = text.split_once(mark).filter(|_| !text.starts_with('#')) {
                let of_user = value.strip_prefix('=').filter(|_| mark == ":");
                let (key, value) = (key.trim().to_ascii_lowercase(), value.trim().to_owned());
                match fields.get(&key) {
                    _ if of_user.is_some() => {
                        of_users.extend(of_user.map(|value| (key, value.trim().to_owned())));
                    }
                    Some((before, _)) => {
                        let message = format!(
                            "{:?} was given in line {before} already: remove one of them",
                            shown(&key)
                        );
                        return Err(in_line(line, message));
                    }
                    None => drop(fields.insert(key, (line, value))),
                }
            } else if !(text.is_empty() || text.starts_with('#') || line == 1) {
                return Err(in_line(line, format!("expected `key{mark} value`, found {:?}", shown(text))));
            }
            if is_last(text) {
                return Ok(Self { fields, of_users, end: at });
            }
        }
        Err(in_line(1, "the header does not end"))
    }

    /// The value of the first of these keys that the header has, with its line.
    pub(super) fn get(&self, keys: &[&str]) -> Option<(usize, &str)> {
        keys.iter().find_map(|key| self.fields.get(*key)).map(|(line, value)| (*line, value.as_str()))
    }

    /// The value of a key of users.
    pub(super) fn of_user(&self, key: &str) -> Option<&str> {
        self.of_users.get(key).map(String::as_str)
    }

    /// The keys of users that end so: what is before the end, and the value.
    pub(super) fn of_users_ending(&self, end: &str) -> impl Iterator<Item = (&str, &str)> {
        self.of_users.iter().filter_map(move |(key, value)| Some((key.strip_suffix(end)?, value.as_str())))
    }

    /// As [`Self::get`], of a field that must be there.
    ///
    /// # Errors
    /// `Malformed` where it is missing.
    pub(super) fn need(&self, keys: &[&str]) -> Result<(usize, &str), MeshError> {
        self.get(keys).ok_or_else(|| in_line(1, format!("the header has no {:?}", keys[0])))
    }

    /// Refuses a field that has another value than one of these (in lower case).
    ///
    /// # Errors
    /// `Unsupported`.
    pub(super) fn allow(&self, keys: &[&str], values: &[&str], remedy: &str) -> Result<(), MeshError> {
        match self.get(keys) {
            Some((line, value)) if !values.contains(&value.to_ascii_lowercase().as_str()) => {
                Err(MeshError::Unsupported {
                    what: format!("{} {:?} (line {line})", keys[0], shown(value)),
                    remedy: remedy.into(),
                })
            }
            _ => Ok(()),
        }
    }
}

/// `N` numbers in a value, separated by spaces, commas or brackets.
///
/// # Errors
/// `Malformed` for another number of them.
pub(super) fn numbers<const N: usize>((line, value): (usize, &str)) -> Result<[f64; N], MeshError> {
    let words = value.split(|c: char| c.is_whitespace() || "(),".contains(c)).filter(|word| !word.is_empty());
    let parsed: Option<Vec<f64>> = words.take(N + 1).map(|word| word.parse().ok()).collect();
    let exact = parsed.and_then(|list| <[f64; N]>::try_from(list).ok());
    exact.ok_or_else(|| in_line(line, format!("expected {N} numbers, found {:?}", shown(value))))
}

/// Three distances of voxels in a value.
///
/// # Errors
/// `Malformed` for anything but three positive numbers; `directions` is the field that turns an axis.
pub(super) fn spacings(field: (usize, &str), directions: &str) -> Result<[f64; 3], MeshError> {
    let found = numbers::<3>(field)?;
    if found.iter().all(|distance| *distance > 0.0) {
        return Ok(found);
    }
    let message = format!(
        "distances of voxels are positive, found {:?}: turn an axis by {directions:?}",
        shown(field.1)
    );
    Err(in_line(field.0, message))
}

/// The data of a volume, of `size` bytes from `start` to the end of the file.
///
/// # Errors
/// `Malformed` for more or fewer of them.
pub(super) fn exactly(bytes: &[u8], start: u64, size: u64) -> Result<&[u8], MeshError> {
    let all = usize::try_from(start).ok().and_then(|start| bytes.get(start..)).unwrap_or_default();
    let found = all.len() as u64;
    if found == size {
        return Ok(all);
    }
    let message = if found < size {
        format!("the voxels are {size} bytes from byte {start}, but the file ends here")
    } else {
        let more = found - size;
        format!(
            "the voxels are {size} bytes from byte {start}, but {more} bytes follow: the sizes or the type in the header are wrong"
        )
    };
    Err(super::error::malformed(bytes.len() - found.saturating_sub(size) as usize, message))
}

/// Three numbers of voxels in a value.
///
/// # Errors
/// `Malformed` for anything else.
pub(super) fn counts((line, value): (usize, &str)) -> Result<[u64; 3], MeshError> {
    let parsed: Option<Vec<u64>> = value.split_whitespace().take(4).map(|word| word.parse().ok()).collect();
    let exact = parsed.and_then(|list| <[u64; 3]>::try_from(list).ok());
    exact.ok_or_else(|| in_line(line, format!("expected three numbers of voxels, found {:?}", shown(value))))
}
