//! Whether a document has the structure of a scene: all misspelt, missing and mistyped members at once.
//!
//! The JSON Schema finds them; this file says them in words, with the branch of a tagged enum that the document chose.
//! What is broken is then *mended* in a copy (removed, or replaced by a placeholder), so that the checks of meaning can
//! look at the rest; what they say of a placeholder is dropped.

use super::choice::{Choice, choices, only, resolve};
use super::problem::{Pointer, Problem, suggest};
use super::schema::Compiled;
use super::validate::Findings;
use jsonschema::ValidationError;
use jsonschema::error::{TypeKind, ValidationErrorKind as Kind};
use serde_json::{Map, Value};

/// Members by which the variant of an enum is chosen.
pub(super) const TAGS: [&str; 2] = ["law", "kind"];

/// The outcome of the check.
#[derive(Debug)]
pub struct Checked {
    /// What is broken.
    pub problems: Vec<Problem>,
    /// The document with what is broken mended.
    pub mended: Value,
    /// Pointers to the placeholders in it.
    pub placeholders: Vec<String>,
    /// There are more problems than are listed; the mended document is of no use.
    pub is_cut_short: bool,
}

/// Problems of structure that are listed: a document with more is not a scene with mistakes but something else, and the work
/// for it would grow with its square.
const MOST_PROBLEMS: usize = 200;
/// Items of the longest list that a document may hold.
const MOST_ITEMS: usize = 10_000;

/// A list that is longer than any scene needs.
fn longer_than_any_scene(value: &Value, at: &Pointer) -> Option<Problem> {
    match value {
        Value::Array(items) if items.len() > MOST_ITEMS => Some(
            Problem::error("list_too_long", at, "this list is too long")
                .value(items.len())
                .limit(format!("at most {MOST_ITEMS} items"))
                .remedy("put meshes into files of their own; remove what is not needed"),
        ),
        Value::Array(items) => {
            items.iter().enumerate().find_map(|(i, item)| longer_than_any_scene(item, &at.index(i)))
        }
        Value::Object(members) => {
            members.iter().find_map(|(name, member)| longer_than_any_scene(member, &at.key(name)))
        }
        _ => None,
    }
}

/// Checks `document` against a compiled schema.
pub(super) fn check(document: &Value, compiled: &Compiled) -> Checked {
    let mut out = Checked {
        problems: Vec::new(),
        mended: document.clone(),
        placeholders: Vec::new(),
        is_cut_short: false,
    };
    if let Some(problem) = longer_than_any_scene(document, &Pointer::root()) {
        out.problems.push(problem);
        out.is_cut_short = true;
        return out;
    }
    match &compiled.validator {
        Ok(validator) => {
            for error in validator.iter_errors(document) {
                out.report(&error, compiled);
                if out.problems.len() >= MOST_PROBLEMS {
                    let more = format!("there are more; the first {MOST_PROBLEMS} are listed");
                    out.problems.push(Problem::error("too_many_problems", &Pointer::root(), more));
                    out.is_cut_short = true;
                    break;
                }
            }
        }
        Err(text) => out.problems.push(Problem::error("schema_broken", &Pointer::root(), text)),
    }
    out
}

impl Checked {
    /// Whether what is said of `pointer` would be said of a placeholder: it is one, lies in one, or holds one.
    pub fn touches_placeholder(&self, pointer: &str) -> bool {
        let within = |inner: &str, outer: &str| {
            inner.strip_prefix(outer).is_some_and(|rest| rest.is_empty() || rest.starts_with('/'))
        };
        self.placeholders.iter().any(|p| within(pointer, p) || within(p, pointer))
    }

    /// All problems: those of the structure, and those of the meaning unless they speak of a placeholder.
    pub fn merged_with(self, found: Findings) -> Vec<Problem> {
        let nameless = self.placeholders.iter().any(|p| p.ends_with("/name"));
        let speaks_of_the_document = |problem: &Problem| {
            // A name that is missing makes every reference to it unknown.
            !(self.touches_placeholder(&problem.pointer) || nameless && problem.code == "unknown_body")
        };
        let kept: Vec<Problem> = found.0.into_iter().filter(speaks_of_the_document).collect();
        self.problems.into_iter().chain(kept).collect()
    }

    fn report(&mut self, error: &ValidationError, compiled: &Compiled) {
        let pointer = Pointer::from_text(error.instance_path().as_str());
        let schema = parent(error.schema_path().as_str(), &compiled.schema);
        let found = error.instance().as_ref();
        match error.kind() {
            Kind::OneOfNotValid { context } | Kind::AnyOf { context } => {
                self.report_branches(&pointer, found, context, schema, compiled);
            }
            Kind::AdditionalProperties { unexpected } => {
                for name in unexpected {
                    self.report_unknown_member(&pointer, name, schema);
                }
            }
            Kind::Required { property } => {
                let name = property.as_str().unwrap_or_default();
                let member = schema.and_then(|s| s.pointer(&format!("/properties/{name}")));
                self.problems.push(
                    Problem::error("missing_field", &pointer.key(name), format!("{name:?} is missing"))
                        .limit(member.map_or_else(String::new, describe))
                        .remedy(member.map_or_else(|| format!("add {name:?}"), |m| remedy_for(name, m))),
                );
                self.mend(&pointer.key(name), member, compiled);
            }
            kind => {
                let (code, limit) = limit_of(kind);
                self.problems.push(
                    Problem::error(code, &pointer, error.to_string())
                        .value(found.clone())
                        .limit(limit)
                        .remedy(schema.and_then(description).unwrap_or_else(|| "change the value".into())),
                );
                self.mend(&pointer, schema, compiled);
            }
        }
    }

    /// An enum (or an optional value) none of whose variants fits: the errors of the variant that the document chose by
    /// its tag, its only member or its type; when it chose none, what there is to choose.
    fn report_branches(
        &mut self,
        pointer: &Pointer,
        found: &Value,
        context: &[Vec<ValidationError<'static>>],
        schema: Option<&Value>,
        compiled: &Compiled,
    ) {
        let choices = schema.map(|s| choices(s, &compiled.schema)).unwrap_or_default();
        let chosen =
            only(&choices, |c| c.is_made_by(found)).or_else(|| only(&choices, |c| c.has_type_of(found)));
        if let Some(errors) = chosen.and_then(|i| context.get(i)) {
            for error in errors {
                self.report(error, compiled);
            }
            return;
        }
        let options: Vec<String> = choices.iter().flat_map(Choice::words).collect();
        let tag = choices.iter().find_map(Choice::tag).filter(|_| found.is_object());
        let at = tag.map_or_else(|| pointer.clone(), |tag| pointer.key(tag));
        let written = tag.map_or(Some(found), |tag| found.get(tag));
        let problem = match (written, tag) {
            (None, _) => {
                Problem::error("missing_field", &at, "the field that chooses the variant is missing")
            }
            (Some(word), Some(_)) => Problem::error("unknown_variant", &at, format!("there is no {word}")),
            (Some(Value::String(word)), None) => {
                Problem::error("unknown_variant", &at, format!("there is no {word:?}"))
            }
            _ => Problem::error("wrong_type", &at, "this is none of the variants"),
        };
        let hint = match written {
            Some(Value::String(word)) => suggest(word, options.iter().map(String::as_str)),
            _ => schema.and_then(description).unwrap_or_else(|| "choose one of them".into()),
        };
        self.problems.push(
            problem
                .value(written.cloned().unwrap_or_default())
                .limit(format!("one of {}", options.join(", ")))
                .remedy(hint),
        );
        self.mend(pointer, schema, compiled);
    }

    fn report_unknown_member(&mut self, pointer: &Pointer, name: &str, schema: Option<&Value>) {
        let members = schema.and_then(|s| s.get("properties")).and_then(Value::as_object);
        let known: Vec<&str> = members.into_iter().flat_map(Map::keys).map(String::as_str).collect();
        let value = self.mended.pointer(pointer.key(name).as_str()).cloned().unwrap_or_default();
        self.problems.push(
            Problem::error("unknown_field", &pointer.key(name), format!("{name:?} is not a field here"))
                .value(value)
                .limit(format!("one of {}", known.join(", ")))
                .remedy(suggest(name, known)),
        );
        if let Some(Value::Object(object)) = self.mended.pointer_mut(pointer.as_str()) {
            object.remove(name);
        }
    }

    /// Puts a placeholder of the right type at `pointer`.
    fn mend(&mut self, pointer: &Pointer, schema: Option<&Value>, compiled: &Compiled) {
        let value = schema.map_or(Value::Null, |s| placeholder(s, &compiled.schema));
        if let Some(place) = self.mended.pointer_mut(pointer.as_str()) {
            *place = value;
        } else if let Some((parent, name)) = pointer.as_str().rsplit_once('/')
            && let Some(Value::Object(object)) = self.mended.pointer_mut(parent)
        {
            object.insert(name.replace("~1", "/").replace("~0", "~"), value);
        }
        self.placeholders.push(pointer.as_str().to_owned());
    }
}

/// Code and limit of a simple error.
fn limit_of(kind: &Kind) -> (&'static str, String) {
    match kind {
        Kind::Type { kind } => ("wrong_type", type_name(kind)),
        Kind::Constant { expected_value } => ("unknown_variant", expected_value.to_string()),
        Kind::Enum { options } => ("unknown_variant", format!("one of {options}")),
        Kind::MinItems { limit } => ("too_few_items", format!("at least {limit} items")),
        Kind::MaxItems { limit } => ("too_many_items", format!("at most {limit} items")),
        Kind::Minimum { limit } => ("out_of_range", format!(">= {limit}")),
        Kind::Maximum { limit } => ("out_of_range", format!("<= {limit}")),
        other => ("wrong_structure", other.keyword().to_owned()),
    }
}

fn type_name(kind: &TypeKind) -> String {
    match kind {
        TypeKind::Single(json_type) => json_type.to_string(),
        TypeKind::Multiple(types) => types.iter().map(|t| t.to_string()).collect::<Vec<_>>().join(" or "),
    }
}

/// The schema that holds the keyword at `path`.
fn parent<'a>(path: &str, root: &'a Value) -> Option<&'a Value> {
    let (parent, _) = path.rsplit_once('/')?;
    root.pointer(parent)
}

fn description(schema: &Value) -> Option<String> {
    schema.get("description").and_then(Value::as_str).map(|text| format!("it means: {text}"))
}

/// What a member is, in a word or two.
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

/// The simplest value that a schema lets pass: absent where it may be, one, an empty list, the first variant.
fn placeholder(schema: &Value, root: &Value) -> Value {
    if let Some(value) = schema.get("const").or_else(|| schema.get("default")) {
        return value.clone();
    }
    if let Some(target) = resolve(schema, root) {
        return placeholder(target, root);
    }
    if let Some(variants) = schema.get("oneOf").or_else(|| schema.get("anyOf")).and_then(Value::as_array) {
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
