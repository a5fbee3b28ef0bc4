//! Bytes → JSON value, with checks that `serde_json` alone lacks: repeated keys, and the place of a number out of range.

use super::problem::{Pointer, Problem, ProblemList, Problems, Severity};
use serde::de::{DeserializeSeed, Deserializer, Error as _, MapAccess, SeqAccess, Visitor};
use serde_json::{Map, Number, Value};
use std::cell::{Cell, RefCell};
use std::fmt;

/// A JSON document, and the keys that occur twice (the last one counts in `value`).
#[derive(Clone, Debug)]
pub struct Parsed {
    /// The document as a JSON value.
    pub value: Value,
    /// One problem for each repeated key, or for the first ones with the number of the others.
    pub problems: Vec<Problem>,
}

/// Parses the bytes of a document.
///
/// # Errors
/// A single problem with its place when the bytes are not JSON: invalid UTF-8, a syntax error, nesting beyond 128 levels,
/// or a number beyond the range of `f64`. Parsing stops at a syntax error.
pub fn parse(bytes: &[u8]) -> Result<Parsed, Problems> {
    let bytes = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
    let text = std::str::from_utf8(bytes).map_err(|error| {
        let place = format!("byte {} is not UTF-8", error.valid_up_to());
        Problem::error("not_utf8", &Pointer::root(), place)
            .limit("UTF-8")
            .remedy("save the file as UTF-8")
            .alone()
    })?;
    let trace = Trace::default();
    let value = trace.value(serde_json::Deserializer::from_str(text)).map_err(|error| {
        Problem::error("not_json", &trace.pointer(), format!("the document is not JSON: {error}"))
            .limit("JSON (RFC 8259), nested at most 128 deep, numbers within ±1.8e308")
            .remedy("correct the document at this line and column")
            .alone()
    })?;
    Ok(Parsed { value, problems: trace.repeated.into_inner().into_vec() })
}

/// As [`parse`], with the error of `serde_json` where the bytes are not JSON; a byte order mark is refused, and so are values
/// that take about `most_bytes` of memory or more.
///
/// # Errors
/// As `serde_json`, with line and column.
pub fn read(bytes: &[u8], most_bytes: u64) -> Result<Parsed, serde_json::Error> {
    let trace = Trace { memory_left: Cell::new(most_bytes), ..Trace::default() };
    let value = trace.value(serde_json::Deserializer::from_slice(bytes))?;
    Ok(Parsed { value, problems: trace.repeated.into_inner().into_vec() })
}

impl From<Value> for Parsed {
    /// Part of a parsed document.
    fn from(value: Value) -> Self {
        Self { value, problems: Vec::new() }
    }
}

/// Position of the reader, and the problems found so far.
struct Trace {
    /// Memory that further values may take [bytes].
    memory_left: Cell<u64>,
    /// Keys and indices from the root; kept as they are when an error ends the reading.
    path: RefCell<Vec<String>>,
    repeated: RefCell<ProblemList>,
}

impl Default for Trace {
    fn default() -> Self {
        Self { memory_left: Cell::new(u64::MAX), path: RefCell::default(), repeated: RefCell::default() }
    }
}

/// Memory of a value in a list or as a member, with the room that its container has in reserve [bytes].
const OF_VALUE: u64 = 64;
/// Memory of the first item of a list [bytes].
const OF_LIST: u64 = 128;
/// Memory of the first member of an object: the node of a tree [bytes].
const OF_OBJECT: u64 = 640;

impl Trace {
    /// Takes memory for a value.
    fn take<E: serde::de::Error>(&self, bytes: u64) -> Result<(), E> {
        let left = self.memory_left.get().checked_sub(bytes);
        let left =
            left.ok_or_else(|| E::custom("the values take too much memory for a text of this length"))?;
        self.memory_left.set(left);
        Ok(())
    }

    /// Reads the value, which must be the only one.
    fn value<'de, R: serde_json::de::Read<'de>>(
        &self,
        mut reader: serde_json::Deserializer<R>,
    ) -> Result<Value, serde_json::Error> {
        let _span = tracing::debug_span!("parse").entered();
        let value = Node(self).deserialize(&mut reader)?;
        reader.end().map(|()| value)
    }

    fn pointer(&self) -> Pointer {
        self.path.borrow().iter().fold(Pointer::root(), |p, key| p.key(key))
    }
}

/// Reads one value at the current position of the trace.
struct Node<'a>(&'a Trace);

impl<'de> DeserializeSeed<'de> for Node<'_> {
    type Value = Value;
    fn deserialize<D: Deserializer<'de>>(self, deserializer: D) -> Result<Value, D::Error> {
        self.0.take(OF_VALUE)?;
        deserializer.deserialize_any(self)
    }
}

impl<'de> Visitor<'de> for Node<'_> {
    type Value = Value;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a JSON value")
    }
    fn visit_unit<E>(self) -> Result<Value, E> {
        Ok(Value::Null)
    }
    fn visit_bool<E>(self, value: bool) -> Result<Value, E> {
        Ok(Value::Bool(value))
    }
    fn visit_i64<E>(self, value: i64) -> Result<Value, E> {
        Ok(value.into())
    }
    fn visit_u64<E>(self, value: u64) -> Result<Value, E> {
        Ok(value.into())
    }
    fn visit_f64<E: serde::de::Error>(self, value: f64) -> Result<Value, E> {
        Number::from_f64(value).map(Value::Number).ok_or_else(|| E::custom("number out of range"))
    }
    fn visit_str<E: serde::de::Error>(self, value: &str) -> Result<Value, E> {
        self.0.take(value.len() as u64)?;
        Ok(Value::String(value.to_owned()))
    }
    fn visit_seq<A: SeqAccess<'de>>(self, mut items: A) -> Result<Value, A::Error> {
        let mut list = Vec::new();
        loop {
            self.0.path.borrow_mut().push(list.len().to_string());
            let item = items.next_element_seed(Node(self.0))?;
            self.0.path.borrow_mut().pop();
            match item {
                Some(item) => {
                    if list.is_empty() {
                        self.0.take(OF_LIST)?;
                    }
                    list.push(item);
                }
                None => return Ok(Value::Array(list)),
            }
        }
    }
    fn visit_map<A: MapAccess<'de>>(self, mut members: A) -> Result<Value, A::Error> {
        let mut object = Map::new();
        while let Some(key) = members.next_key::<String>()? {
            self.0.take(key.len() as u64 + if object.is_empty() { OF_OBJECT } else { OF_VALUE })?;
            self.0.path.borrow_mut().push(key.clone());
            let value = members.next_value_seed(Node(self.0))?;
            if object.contains_key(&key) {
                self.0.repeated.borrow_mut().push_with(Severity::Error, || {
                    Problem::error("repeated_key", &self.0.pointer(), format!("{key:?} is written twice"))
                        .value(value.clone())
                        .limit("written once")
                        .remedy("keep one of them")
                });
            }
            self.0.path.borrow_mut().pop();
            object.insert(key, value);
        }
        Ok(Value::Object(object))
    }
    fn visit_bytes<E: serde::de::Error>(self, _: &[u8]) -> Result<Value, E> {
        Err(E::custom("bytes are not JSON"))
    }
    fn visit_none<E>(self) -> Result<Value, E> {
        Ok(Value::Null)
    }
    fn visit_some<D: Deserializer<'de>>(self, deserializer: D) -> Result<Value, D::Error> {
        deserializer.deserialize_any(self).map_err(D::Error::custom)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_document_is_read_as_serde_json_reads_it() {
        let text =
            r#"{"a": [1, -2, 3.5, 1e3, 18446744073709551615], "b": {"c": null, "d": true, "e": "ü\n"}}"#;
        let parsed = parse(text.as_bytes()).unwrap();
        assert_eq!(parsed.value, serde_json::from_str::<Value>(text).unwrap());
        assert!(parsed.problems.is_empty());
    }

    #[test]
    fn every_repeated_key_is_found() {
        let parsed = parse(br#"{"a": 1, "b": [{"c": 1, "c": 2}], "a": 3}"#).unwrap();
        let pointers: Vec<&str> = parsed.problems.iter().map(|p| p.pointer.as_str()).collect();
        assert_eq!(pointers, ["/b/0/c", "/a"]);
    }

    #[test]
    fn memory_is_limited() {
        let nested = format!("[{}]", vec!["{\"\":0}"; 1000].join(","));
        let most = 32 * nested.len() as u64;
        assert!(read(nested.as_bytes(), most).unwrap_err().to_string().contains("too much memory"));
        let numbers = format!("[{}]", vec!["0.125"; 1000].join(","));
        assert!(read(numbers.as_bytes(), 32 * numbers.len() as u64).is_ok());
        assert!(read(nested.as_bytes(), u64::MAX).is_ok());
    }

    #[test]
    fn what_is_no_json_says_where() {
        let refused = |bytes: &[u8]| parse(bytes).unwrap_err().0.remove(0);
        assert_eq!(refused(b"{\"a\": [1, 1e999]}").pointer, "/a/1");
        assert_eq!(refused(b"\xff").code, "not_utf8");
        assert!(refused(b"").message.contains("line 1"));
        assert!(refused(b"{} x").message.contains("trailing"));
        assert!(parse(b"NaN").is_err());
        let deep = "[".repeat(100_000);
        assert!(refused(deep.as_bytes()).message.contains("recursion"));
        assert!(parse(b"\xef\xbb\xbf{}").is_ok(), "a byte order mark is let pass");
    }
}
