//! Conditional and range requests of one immutable file (RFC 9110 §13, §14).

use axum::http::{HeaderMap, HeaderName, Method, header};

/// The part of a file that a client requests.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Wanted {
    /// The whole file is sent.
    Whole,
    /// A range of bytes.
    Part {
        /// First byte, from 0.
        first: u64,
        /// Last byte, included in the range.
        last: u64,
    },
    /// Nothing: the client's copy is current.
    NotModified,
    /// Nothing: the client expects another file.
    PreconditionFailed,
    /// A range without any byte of the file.
    Unsatisfiable,
}

/// Evaluates a request for a file of `length` bytes with a strong `etag` (with its quotes). Preconditions come first,
/// in the order of RFC 9110 §13.2.2. The file has no date: conditions on dates are not met. Only a GET request can ask
/// for a range (§14.2).
pub fn wanted(method: &Method, headers: &HeaderMap, etag: &str, length: u64) -> Wanted {
    if let Some(tags) = text(headers, &header::IF_MATCH)
        && !tags_of(tags).any(|tag| tag == "*" || tag == etag)
    {
        return Wanted::PreconditionFailed;
    }
    if let Some(tags) = text(headers, &header::IF_NONE_MATCH)
        && tags_of(tags).any(|tag| tag == "*" || tag.strip_prefix("W/").unwrap_or(tag) == etag)
    {
        return Wanted::NotModified;
    }
    let Some(range) = text(headers, &header::RANGE).filter(|_| *method == Method::GET) else {
        return Wanted::Whole;
    };
    // A weak tag, a date, or the tag of another file: the client's parts would not match.
    if headers.contains_key(header::IF_RANGE) && text(headers, &header::IF_RANGE) != Some(etag) {
        return Wanted::Whole;
    }
    part(range, length)
}

/// The range named by a `Range` header. Anything but a single byte range is ignored, as RFC 9110 §14.2 allows.
fn part(range: &str, length: u64) -> Wanted {
    let Some((unit, set)) = range.split_once('=') else { return Wanted::Whole };
    if !unit.trim().eq_ignore_ascii_case("bytes") {
        return Wanted::Whole;
    }
    let Some((first, last)) = set.trim().split_once('-') else { return Wanted::Whole };
    match (number(first), number(last)) {
        (Number::Absent, Number::Is(suffix)) => match suffix.min(length) {
            0 => Wanted::Unsatisfiable,
            n => Wanted::Part { first: length - n, last: length - 1 },
        },
        (Number::Is(first), Number::Absent) if first < length => Wanted::Part { first, last: length - 1 },
        (Number::Is(first), Number::Is(last)) if first > last => Wanted::Whole,
        (Number::Is(first), Number::Is(last)) if first < length => {
            Wanted::Part { first, last: last.min(length - 1) }
        }
        (Number::Is(_), Number::Is(_) | Number::Absent) => Wanted::Unsatisfiable,
        _ => Wanted::Whole,
    }
}

enum Number {
    Absent,
    Is(u64),
    Not,
}

/// Parses decimal digits only. An overflow counts as a number beyond every file.
fn number(text: &str) -> Number {
    if text.is_empty() {
        Number::Absent
    } else if text.bytes().all(|b| b.is_ascii_digit()) {
        Number::Is(text.parse().unwrap_or(u64::MAX))
    } else {
        Number::Not
    }
}

fn text<'a>(headers: &'a HeaderMap, name: &HeaderName) -> Option<&'a str> {
    headers.get(name)?.to_str().ok().map(str::trim)
}

/// Splits a list of tags. Our tags contain no commas.
fn tags_of(list: &str) -> impl Iterator<Item = &str> {
    list.split(',').map(str::trim)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ask(pairs: &[(HeaderName, &str)]) -> Wanted {
        let headers = pairs.iter().map(|(name, value)| (name.clone(), value.parse().unwrap())).collect();
        wanted(&Method::GET, &headers, "\"abc\"", 1000)
    }
    fn range(text: &str) -> Wanted {
        ask(&[(header::RANGE, text)])
    }

    #[test]
    fn one_range_of_bytes() {
        assert_eq!(range("bytes=0-99"), Wanted::Part { first: 0, last: 99 });
        assert_eq!(range("bytes=900-"), Wanted::Part { first: 900, last: 999 });
        assert_eq!(range("bytes=-10"), Wanted::Part { first: 990, last: 999 });
        assert_eq!(range("bytes=-5000"), Wanted::Part { first: 0, last: 999 });
        assert_eq!(range("bytes=999-99999999999999999999999"), Wanted::Part { first: 999, last: 999 });
        assert_eq!(range("Bytes=0-0"), Wanted::Part { first: 0, last: 0 });
    }

    #[test]
    fn ranges_without_a_byte() {
        for text in ["bytes=1000-", "bytes=1000-1001", "bytes=-0", "bytes=99999999999999999999999-"] {
            assert_eq!(range(text), Wanted::Unsatisfiable, "{text}");
        }
        let empty = wanted(
            &Method::GET,
            &[(header::RANGE, "bytes=0-".parse().unwrap())].into_iter().collect(),
            "\"abc\"",
            0,
        );
        assert_eq!(empty, Wanted::Unsatisfiable);
    }

    #[test]
    fn what_is_no_single_range_is_ignored() {
        for text in [
            "bytes=0-1,5-6",
            "bytes=9-3",
            "bytes=a-b",
            "bytes=--1",
            "bytes=-",
            "items=0-1",
            "bytes",
            "bytes=+1-2",
        ] {
            assert_eq!(range(text), Wanted::Whole, "{text}");
        }
    }

    #[test]
    fn of_the_head_there_is_no_part() {
        let headers = [(header::RANGE, "bytes=0-1".parse().unwrap())].into_iter().collect();
        assert_eq!(wanted(&Method::HEAD, &headers, "\"abc\"", 1000), Wanted::Whole);
    }

    #[test]
    fn conditions() {
        let part = Wanted::Part { first: 0, last: 1 };
        let requested = |name: HeaderName, value: &str| ask(&[(header::RANGE, "bytes=0-1"), (name, value)]);
        assert_eq!(requested(header::IF_RANGE, "\"abc\""), part);
        assert_eq!(requested(header::IF_RANGE, "\"old\""), Wanted::Whole);
        assert_eq!(requested(header::IF_RANGE, "W/\"abc\""), Wanted::Whole);
        assert_eq!(requested(header::IF_RANGE, "Wed, 21 Oct 2015 07:28:00 GMT"), Wanted::Whole);
        assert_eq!(requested(header::IF_NONE_MATCH, "\"x\", W/\"abc\""), Wanted::NotModified);
        assert_eq!(requested(header::IF_NONE_MATCH, "*"), Wanted::NotModified);
        assert_eq!(requested(header::IF_NONE_MATCH, "\"x\""), part);
        assert_eq!(requested(header::IF_MATCH, "\"x\""), Wanted::PreconditionFailed);
        assert_eq!(requested(header::IF_MATCH, "\"abc\""), part);
    }
}
