//! How a document selects a variant of an enum of the schema: by a keyword, a tag, its only member or its type.

use super::misfit::is_of_type;
use serde_json::Value;

/// Members that select the variant of an enum.
pub(super) const TAGS: [&str; 2] = ["law", "kind"];

/// How a document selects a variant of an enum.
pub(super) enum Choice {
    /// By being this keyword.
    Word(Value),
    /// By this keyword under this tag.
    Tag(&'static str, Value),
    /// By having this member, which is the only one, or the only one that must be.
    Member(String),
    /// By being of this type.
    Type(String),
    /// By one of these choices.
    Nested(Vec<Choice>),
}

impl Choice {
    /// Whether `found` makes this choice.
    pub(super) fn is_made_by(&self, found: &Value) -> bool {
        match self {
            Self::Word(word) => found == word,
            Self::Tag(tag, word) => found.get(tag) == Some(word),
            Self::Member(name) => found.get(name).is_some(),
            Self::Type(_) => self.has_type_of(found),
            Self::Nested(choices) => choices.iter().any(|c| c.is_made_by(found)),
        }
    }
    /// Whether the type of `found` fits this choice.
    pub(super) fn has_type_of(&self, found: &Value) -> bool {
        match self {
            Self::Word(_) => found.is_string(),
            Self::Tag(..) | Self::Member(_) => found.is_object(),
            Self::Type(name) => is_of_type(found, name),
            Self::Nested(choices) => choices.iter().any(|c| c.has_type_of(found)),
        }
    }
    /// Tag of the choice, if it has one.
    pub(super) fn tag(&self) -> Option<&'static str> {
        match self {
            Self::Tag(tag, _) => Some(tag),
            Self::Nested(choices) => choices.iter().find_map(Self::tag),
            _ => None,
        }
    }
    /// Member of `found` that makes the choice, if one does.
    pub(super) fn maker(&self, found: &Value) -> Option<&str> {
        match self {
            Self::Tag(tag, _) if self.is_made_by(found) => Some(tag),
            Self::Member(name) if self.is_made_by(found) => Some(name),
            Self::Nested(choices) => choices.iter().find_map(|choice| choice.maker(found)),
            _ => None,
        }
    }
    /// Text to write in the document to make the choice.
    pub(super) fn words(&self) -> Vec<String> {
        match self {
            Self::Word(word) | Self::Tag(_, word) => vec![word.as_str().unwrap_or_default().to_owned()],
            Self::Member(name) => vec![format!("{{{name:?}: …}}")],
            Self::Type(name) => vec![name.clone()],
            Self::Nested(choices) => choices.iter().flat_map(Self::words).collect(),
        }
    }
}

/// The variants of an enum or of an optional value.
pub(super) fn variants(schema: &Value) -> Option<&[Value]> {
    schema.get("oneOf").or_else(|| schema.get("anyOf"))?.as_array().map(Vec::as_slice)
}

/// How each variant is selected, in order.
pub(super) fn choices(variants: &[Value], root: &Value) -> Vec<Choice> {
    variants.iter().map(|variant| choice(variant, root)).collect()
}

fn choice(variant: &Value, root: &Value) -> Choice {
    if let Some(target) = resolve(variant, root) {
        return choice(target, root);
    }
    if let Some(word) = variant.get("const") {
        return Choice::Word(word.clone());
    }
    let properties = variant.get("properties").and_then(Value::as_object);
    for tag in TAGS {
        if let Some(word) = properties.and_then(|p| p.get(tag)?.get("const")) {
            return Choice::Tag(tag, word.clone());
        }
    }
    if let Some(name) = properties.filter(|p| p.len() == 1).and_then(|p| p.keys().next()) {
        return Choice::Member(name.clone());
    }
    if let Some([Value::String(name)]) = variant.get("required").and_then(Value::as_array).map(Vec::as_slice)
    {
        return Choice::Member(name.clone());
    }
    match variants(variant) {
        Some(nested) => Choice::Nested(choices(nested, root)),
        None => Choice::Type(variant.get("type").and_then(Value::as_str).unwrap_or("anything").to_owned()),
    }
}

/// Index of the only choice that satisfies `condition`.
pub(super) fn only(choices: &[Choice], condition: impl Fn(&Choice) -> bool) -> Option<usize> {
    let mut kept = choices.iter().enumerate().filter(|(_, choice)| condition(choice));
    let (index, _) = kept.next()?;
    kept.next().is_none().then_some(index)
}

/// Target of a `$ref`.
pub(super) fn resolve<'a>(schema: &Value, root: &'a Value) -> Option<&'a Value> {
    root.pointer(schema.get("$ref")?.as_str()?.strip_prefix('#')?)
}
