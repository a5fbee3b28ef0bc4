//! Structure of a scene document: finds all misspelt, missing and mistyped members at once.
//!
//! The document is compared with its JSON Schema; for a tagged enum, with the variant that the document selects. Invalid
//! members are *repaired* in a copy (removed, or replaced by a placeholder), so that the semantic checks can process the
//! rest; what they report about a placeholder is dropped.

use super::choice::{Choice, choices, only, resolve, variants};
use super::misfit::misfits;
use super::problem::{Pointer, Problem, ProblemList, Severity, did_you_mean};
use super::validate::Findings;
use serde_json::{Map, Value};
use std::collections::BTreeSet;

/// Outcome of the check.
#[derive(Debug)]
pub struct Checked {
    /// Problems of structure, in document order.
    pub problems: ProblemList,
    /// The document with its invalid members repaired.
    pub mended: Value,
    /// Pointers to the placeholders in `mended`.
    pub placeholders: Vec<String>,
    /// The list of problems is full, and the others are only counted; `mended` must not be used.
    pub is_cut_short: bool,
}

/// Largest number of items in a list of the document.
const MOST_ITEMS: usize = 10_000;

/// The first list that is too long for any scene: its length, and the keys and indices that lead to it, the last one first.
fn longer_than_any_scene(value: &Value) -> Option<(usize, Vec<String>)> {
    // Names are copied on the way back only: they may be long, and the document large.
    let (name, (length, mut path)) = match value {
        Value::Array(items) if items.len() > MOST_ITEMS => return Some((items.len(), Vec::new())),
        Value::Array(items) => {
            let found = |(i, item)| longer_than_any_scene(item).map(|found| (i, found));
            let (i, found) = items.iter().enumerate().find_map(found)?;
            (i.to_string(), found)
        }
        Value::Object(members) => {
            let found = |(name, member)| longer_than_any_scene(member).map(|found| (name, found));
            let (name, found): (&String, _) = members.iter().find_map(found)?;
            (name.clone(), found)
        }
        _ => return None,
    };
    path.push(name);
    Some((length, path))
}

/// Checks `document` against a schema.
pub(super) fn check(document: &Value, schema: &Value) -> Checked {
    let checked = Checked {
        problems: ProblemList::default(),
        mended: document.clone(),
        placeholders: Vec::new(),
        is_cut_short: false,
    };
    let mut walk = Walk { root: schema, checked };
    match longer_than_any_scene(document) {
        Some((length, path)) => {
            let at = path.iter().rev().fold(Pointer::root(), |at, name| at.key(name));
            walk.report(|| {
                Problem::error("list_too_long", &at, "this list is too long")
                    .value(length)
                    .limit(format!("at most {MOST_ITEMS} items"))
                    .remedy("put meshes into separate files; remove what is not needed")
            });
            walk.checked.is_cut_short = true;
        }
        None => walk.compare(document, &Pointer::root(), schema),
    }
    walk.checked
}

impl Checked {
    /// Whether a problem at `pointer` concerns a placeholder: it is one, lies inside one, or contains one.
    pub fn touches_placeholder(&self, pointer: &str) -> bool {
        let within = |inner: &str, outer: &str| {
            inner.strip_prefix(outer).is_some_and(|rest| rest.is_empty() || rest.starts_with('/'))
        };
        self.placeholders.iter().any(|p| within(pointer, p) || within(p, pointer))
    }

    /// All problems: those of the structure, and the semantic ones that do not concern a placeholder.
    pub fn merged_with(mut self, found: Findings) -> Vec<Problem> {
        let nameless = self.placeholders.iter().any(|p| p.ends_with("/name"));
        let speaks_of_the_document = |problem: &Problem| {
            // A missing name makes every reference to it unknown.
            !(self.touches_placeholder(&problem.pointer) || nameless && problem.code == "unknown_body")
        };
        let kept: Vec<Problem> = found.0.into_vec().into_iter().filter(speaks_of_the_document).collect();
        self.problems.extend(kept);
        self.problems.into_vec()
    }
}

/// A walk over the document along its schema. It supports the JSON Schema keywords that occur in the schemas of our types,
/// which the tests of `schema.rs` ensure.
struct Walk<'a> {
    /// The whole schema, which references point into.
    root: &'a Value,
    /// Problems found so far, and whether the walk was cut short.
    checked: Checked,
}

impl Walk<'_> {
    /// Compares the value at `at`, and everything in it, with its schema.
    fn compare(&mut self, found: &Value, at: &Pointer, schema: &Value) {
        for (code, message, limit) in misfits(found, schema) {
            self.report(|| {
                let remedy = description(schema).unwrap_or_else(|| "change the value".into());
                Problem::error(code, at, message).value(found.clone()).limit(limit).remedy(remedy)
            });
            self.mend(at, Some(schema));
        }
        if let Value::Object(members) = found {
            self.compare_members(members, at, schema);
        }
        if let (Value::Array(items), Some(schema)) = (found, schema.get("items")) {
            for (i, item) in items.iter().enumerate() {
                self.compare(item, &at.index(i), schema);
            }
        }
        if let Some(variants) = variants(schema) {
            self.compare_variants(found, at, schema, variants);
        }
        if let Some(target) = resolve(schema, self.root) {
            self.compare(found, at, target);
        }
    }

    /// Members that are missing, those known to the schema, and unknown ones.
    fn compare_members(&mut self, members: &Map<String, Value>, at: &Pointer, schema: &Value) {
        let Some(known) = schema.get("properties").and_then(Value::as_object) else { return };
        let required = schema.get("required").and_then(Value::as_array).into_iter().flatten();
        for name in required.filter_map(Value::as_str).filter(|name| !members.contains_key(*name)) {
            let member = known.get(name);
            self.report(|| {
                Problem::error("missing_field", &at.key(name), format!("{name:?} is missing"))
                    .limit(member.map_or_else(String::new, describe))
                    .remedy(member.map_or_else(|| format!("add {name:?}"), |m| remedy_for(name, m)))
            });
            self.mend(&at.key(name), member);
        }
        for (name, value) in members {
            if let Some(member) = known.get(name) {
                self.compare(value, &at.key(name), member);
            }
        }
        for (name, value) in members.iter().filter(|(name, _)| !known.contains_key(*name)) {
            self.report_unknown_member(name, value, at, known);
        }
    }

    /// An enum (or an optional value): compares with the variant selected by the tag, the only member or the type; lists
    /// the options when none is selected.
    fn compare_variants(&mut self, found: &Value, at: &Pointer, schema: &Value, variants: &[Value]) {
        let choices = choices(variants, self.root);
        let makers: BTreeSet<&str> = choices.iter().filter_map(|choice| choice.maker(found)).collect();
        if makers.len() > 1 {
            self.report(|| several_variants(found, at, &makers));
            return self.mend(at, Some(schema));
        }
        let chosen = only(&choices, |c| c.is_made_by(found))
            .or_else(|| only(&choices, |c| c.tag().is_some() && c.is_made_by(found)))
            .or_else(|| only(&choices, |c| c.has_type_of(found)));
        if let Some(variant) = chosen.and_then(|i| variants.get(i)) {
            return self.compare(found, at, variant);
        }
        self.report(|| no_variant(found, at, schema, &choices));
        self.mend(at, Some(schema));
    }

    fn report_unknown_member(&mut self, name: &str, value: &Value, at: &Pointer, known: &Map<String, Value>) {
        self.report(|| {
            let known: Vec<&str> = known.keys().map(String::as_str).collect();
            Problem::error("unknown_field", &at.key(name), format!("{name:?} is not a field here"))
                .value(value.clone())
                .limit(format!("one of {}", known.join(", ")))
                .remedy(
                    did_you_mean(name, &known).unwrap_or_else(|| "remove it, or choose one of these".into()),
                )
        });
        if self.checked.is_cut_short {
            return;
        }
        if let Some(Value::Object(object)) = self.checked.mended.pointer_mut(at.as_str()) {
            object.remove(name);
        }
    }

    /// Adds a problem to the list. Once the list is full nothing is repaired any more: that work would grow with the square
    /// of the number of problems.
    fn report(&mut self, problem: impl FnOnce() -> Problem) {
        if self.checked.is_cut_short {
            // Only counted; a full list never lists it.
            self.checked.problems.count(Severity::Error);
            return;
        }
        self.checked.problems.push(problem());
        self.checked.is_cut_short = self.checked.problems.is_full();
    }

    /// Puts a placeholder of the right type at `pointer`.
    fn mend(&mut self, pointer: &Pointer, schema: Option<&Value>) {
        let Checked { mended, placeholders, is_cut_short, .. } = &mut self.checked;
        if *is_cut_short {
            return;
        }
        let value = schema.map_or(Value::Null, |s| placeholder(s, self.root));
        if let Some(place) = mended.pointer_mut(pointer.as_str()) {
            *place = value;
        } else if let Some((parent, name)) = pointer.as_str().rsplit_once('/')
            && let Some(Value::Object(object)) = mended.pointer_mut(parent)
        {
            object.insert(name.replace("~1", "/").replace("~0", "~"), value);
        }
        placeholders.push(pointer.as_str().to_owned());
    }
}

/// A value that selects no variant: what is wrong with the selection, and the options.
fn no_variant(found: &Value, at: &Pointer, schema: &Value, choices: &[Choice]) -> Problem {
    let options: Vec<String> = choices.iter().flat_map(Choice::words).collect();
    let tag = choices.iter().find_map(Choice::tag).filter(|_| found.is_object());
    let place = tag.map_or_else(|| at.clone(), |tag| at.key(tag));
    let written = tag.map_or(Some(found), |tag| found.get(tag));
    let problem = match (written, tag) {
        (None, _) => Problem::error("missing_field", &place, "the field that selects the variant is missing"),
        (Some(word), Some(_)) => Problem::error("unknown_variant", &place, format!("there is no {word}")),
        (Some(Value::String(word)), None) => {
            Problem::error("unknown_variant", &place, format!("there is no {word:?}"))
        }
        _ => Problem::error("wrong_type", &place, "this is none of the variants"),
    };
    let hint = match written {
        Some(Value::String(word)) => {
            did_you_mean(word, &options.iter().map(String::as_str).collect::<Vec<_>>())
        }
        _ => description(schema),
    };
    let hint = hint.unwrap_or_else(|| "choose one of them".into());
    problem
        .value(written.cloned().unwrap_or_default())
        .limit(format!("one of {}", options.join(", ")))
        .remedy(hint)
}

/// A value whose members select more than one variant.
fn several_variants(found: &Value, at: &Pointer, makers: &BTreeSet<&str>) -> Problem {
    let names: Vec<String> = makers.iter().map(|name| format!("{name:?}")).collect();
    let message = format!("{} are alternatives, and more than one is given", names.join(" and "));
    Problem::error("several_variants", at, message)
        .value(found.clone())
        .limit(format!("one of {}", names.join(", ")))
        .remedy(format!("choose one of {}, and remove what belongs to the other", names.join(" and ")))
}

fn description(schema: &Value) -> Option<String> {
    schema.get("description").and_then(Value::as_str).map(|text| format!("it means: {text}"))
}

/// Expected type of a member, in a word or two.
fn describe(schema: &Value) -> String {
    match schema.get("type") {
        Some(Value::String(name)) => format!("present ({name})"),
        _ => "present".into(),
    }
}

fn remedy_for(name: &str, schema: &Value) -> String {
    match schema.get("description").and_then(Value::as_str) {
        Some(text) => format!("add {name:?}: {text}"),
        None => format!("add {name:?}"),
    }
}

/// The simplest value that satisfies a schema: absent if optional, 1, an empty list, the first variant.
fn placeholder(schema: &Value, root: &Value) -> Value {
    if let Some(value) = schema.get("const").or_else(|| schema.get("default")) {
        return value.clone();
    }
    if let Some(target) = resolve(schema, root) {
        return placeholder(target, root);
    }
    if let Some(variants) = variants(schema) {
        let may_be_absent = variants.iter().any(|v| v.get("type").is_some_and(|t| t == "null"));
        let first = variants.first().filter(|_| !may_be_absent);
        return first.map_or(Value::Null, |variant| placeholder(variant, root));
    }
    match schema.get("type").and_then(Value::as_str) {
        Some("number" | "integer") => 1.into(),
        Some("string") => "?".into(),
        Some("boolean") => false.into(),
        Some("array") => {
            let count = schema.get("minItems").and_then(Value::as_u64).unwrap_or(0);
            let item = schema.get("items").map_or(Value::Null, |items| placeholder(items, root));
            Value::Array((0..count).map(|_| item.clone()).collect())
        }
        Some("object") => {
            let names = schema.get("required").and_then(Value::as_array).into_iter().flatten();
            let member = |name: &str| {
                schema.pointer(&format!("/properties/{name}")).map_or(Value::Null, |m| placeholder(m, root))
            };
            names.filter_map(Value::as_str).map(|name| (name.to_owned(), member(name))).collect()
        }
        _ => Value::Null,
    }
}
