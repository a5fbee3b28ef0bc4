//! Errors of serde in terms of the document; serde itself refers to the types of the program.

use super::choice::TAGS;
use super::problem::{Pointer, Problem, suggest};
use serde_json::Value;
use serde_path_to_error::{Error, Segment};

impl Problem {
    /// The problem of a document that serde refuses, for documents without a schema here or valid under it; serde stops at
    /// the first.
    pub fn refused_by_serde(error: &Error<serde_json::Error>, document: &Value) -> Self {
        let here = error.path().iter().fold(Pointer::root(), |p, segment| match segment {
            Segment::Seq { index } => p.index(*index),
            Segment::Map { key } => p.key(key),
            Segment::Enum { .. } | Segment::Unknown => p,
        });
        let at = |pointer: &Pointer| document.pointer(pointer.as_str()).cloned();
        let text = error.inner().to_string();
        // The user's text comes first, and may contain any words.
        let (what, expected) = text.rsplit_once(", expected ").unwrap_or((text.as_str(), ""));
        let known = || expected.split('`').skip(1).step_by(2);
        let one_of = || format!("one of {}", known().collect::<Vec<_>>().join(", "));
        if let Some(name) = named(what, "missing field") {
            return Self::error("missing_field", &here.key(name), format!("{name:?} is missing"))
                .limit("present")
                .remedy(format!("add {name:?}"));
        }
        if let Some(name) = named(what, "unknown field") {
            // The path ends before the member if the variant was selected by a tag.
            let member = Some(here.key(name)).filter(|member| at(member).is_some()).unwrap_or(here);
            return Self::error("unknown_field", &member, format!("{name:?} is not a field here"))
                .value(at(&member).unwrap_or_default())
                .limit(one_of())
                .remedy(suggest(name, known()));
        }
        if let Some(name) = named(what, "unknown variant") {
            let tag = TAGS.iter().map(|tag| here.key(tag)).find(|tag| at(tag).is_some_and(|v| v == name));
            return Self::error("unknown_variant", &tag.unwrap_or(here), format!("there is no {name:?}"))
                .value(name)
                .limit(one_of())
                .remedy(suggest(name, known()));
        }
        // What remains are values of the wrong type or form.
        let message = match () {
            () if what.starts_with("data did not match") => "this is none of the variants",
            () if what.starts_with("invalid value") => "this value is not accepted",
            () if what.starts_with("invalid length") && !expected.starts_with("struct") => {
                "this list has the wrong length"
            }
            () if what.starts_with("invalid") => "this is of the wrong type",
            () => what,
        };
        let problem = Self::error("wrong_structure", &here, message).value(at(&here).unwrap_or_default());
        match expected {
            "" => problem.limit("what `contuse schema` and /docs describe").remedy("change the value"),
            _ => problem.limit(in_words_of_json(expected)).remedy("write it so"),
        }
    }
}

/// The name in backquotes after given words in a message of serde.
fn named<'a>(what: &'a str, words: &str) -> Option<&'a str> {
    let rest = what.strip_prefix(words)?.strip_prefix(" `")?;
    rest.strip_suffix("`, there are no fields").or_else(|| rest.strip_suffix('`'))
}

/// What serde expects, in terms of JSON: `f64` is a number, `struct Parameter with 3 elements` an object.
fn in_words_of_json(expected: &str) -> &str {
    match expected.split(' ').next().unwrap_or_default() {
        "f64" => "a number",
        "u8" | "u16" | "u32" | "u64" | "usize" => {
            "a whole number, not negative and not too large, written without a decimal point"
        }
        "i32" | "i64" => "a whole number, written without a decimal point",
        "struct" | "internally" | "map" => "an object",
        "string" => "a string, or an object with one member",
        "tuple" => "a list",
        _ => match expected {
            "a map" => "an object",
            "a sequence" => "a list",
            "a boolean" => "true or false",
            other => other,
        },
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde::Deserialize;
    use serde_json::json;

    #[derive(Debug, Deserialize)]
    #[serde(deny_unknown_fields)]
    #[allow(dead_code)] // read for what is refused
    struct Whole {
        changes: Vec<Change>,
        #[serde(default)]
        count: u32,
    }

    #[derive(Debug, Deserialize)]
    #[serde(tag = "kind", rename_all = "snake_case", deny_unknown_fields)]
    #[allow(dead_code)] // read for what is refused
    enum Change {
        Turn { about: [f64; 3] },
        Move { along: f64 },
    }

    fn refused(document: &Value) -> Problem {
        let read: Result<Whole, _> = serde_path_to_error::deserialize(document);
        Problem::refused_by_serde(&read.unwrap_err(), document)
    }

    #[test]
    fn what_is_refused_has_its_place_its_value_and_words_of_json() {
        let change = |change: Value| json!({ "changes": [change] });
        for (document, code, place, value, limit) in [
            (json!([]), "wrong_structure", "", json!([]), "an object"),
            (json!({}), "missing_field", "/changes", json!(null), "present"),
            (json!({"changes": 3}), "wrong_structure", "/changes", json!(3), "a list"),
            (
                json!({"changes": [], "cuont": 1}),
                "unknown_field",
                "/cuont",
                json!(1),
                "one of changes, count",
            ),
            (json!({"changes": [], "count": "x"}), "wrong_structure", "/count", json!("x"), "a whole number"),
            (json!({"changes": [], "count": -1}), "wrong_structure", "/count", json!(-1), "a whole number"),
            (
                change(json!({"kind": "tunr"})),
                "unknown_variant",
                "/changes/0/kind",
                json!("tunr"),
                "one of turn, move",
            ),
            (change(json!({"kind": "turn"})), "missing_field", "/changes/0/about", json!(null), "present"),
            (
                change(json!({"kind": "move", "along": 1, "alogn": 2})),
                "unknown_field",
                "/changes/0/alogn",
                json!(2),
                "one of along",
            ),
        ] {
            let found = refused(&document);
            assert_eq!((&*found.code, found.pointer.as_str()), (code, place), "{found}");
            assert_eq!(found.value, value, "{found}");
            assert!(found.limit.starts_with(limit), "{found}");
            assert!(!found.remedy.is_empty() && !found.to_string().contains("struct "), "{found}");
        }
        assert_eq!(refused(&json!({"changes": [], "cuont": 1})).remedy, "did you mean \"count\"?");
    }
}
