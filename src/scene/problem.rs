//! Problems of a scene, in terms a user can act on.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use serde_json::Value;
use std::borrow::Cow;
use std::fmt;

/// Severity of a problem.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Severity {
    /// The scene cannot run.
    Error,
    /// The scene can run, but may not be what was intended.
    Warning,
}

/// One problem: where it is, what was found, the limit, and a remedy.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[cfg_attr(feature = "service", derive(utoipa::ToSchema), schema(as = SceneProblem))]
pub struct Problem {
    /// Whether it refuses the document: `error` or `warning`.
    #[cfg_attr(feature = "service", schema(value_type = String))]
    pub severity: Severity,
    /// Stable code of the kind of problem, for programs.
    #[cfg_attr(feature = "service", schema(value_type = String))]
    pub code: Cow<'static, str>,
    /// Place in the document, as a JSON pointer (RFC 6901); empty for the whole document.
    pub pointer: String,
    /// What is wrong, in one sentence.
    pub message: String,
    /// The value found, shortened when it is long; null when there is none.
    pub value: Value,
    /// Condition that the value must satisfy ("> 0").
    pub limit: String,
    /// How to correct it.
    pub remedy: String,
}

impl Problem {
    /// An error with the given code at `pointer`, without value, limit and remedy.
    pub fn error(code: &'static str, pointer: &Pointer, message: impl Into<String>) -> Self {
        Self::new(Severity::Error, code, pointer, message.into())
    }
    /// A warning with the given code at `pointer`, without value, limit and remedy.
    pub fn warning(code: &'static str, pointer: &Pointer, message: impl Into<String>) -> Self {
        Self::new(Severity::Warning, code, pointer, message.into())
    }
    fn new(severity: Severity, code: &'static str, pointer: &Pointer, message: String) -> Self {
        Self {
            severity,
            code: Cow::Borrowed(code),
            pointer: pointer.0.clone(),
            message,
            value: Value::Null,
            limit: String::new(),
            remedy: String::new(),
        }
    }
    /// Sets the value found (shortened when it is long).
    #[must_use]
    pub fn value(mut self, value: impl Into<Value>) -> Self {
        self.value = shortened(value.into());
        self
    }
    /// Sets the limit that the value violates.
    #[must_use]
    pub fn limit(mut self, limit: impl Into<String>) -> Self {
        self.limit = limit.into();
        self
    }
    /// Sets the remedy: what to change.
    #[must_use]
    pub fn remedy(mut self, remedy: impl Into<String>) -> Self {
        self.remedy = remedy.into();
        self
    }
    /// The problem of a document that is embedded at `place` in another one.
    #[must_use]
    pub fn under(mut self, place: &Pointer) -> Self {
        self.pointer.insert_str(0, &place.0);
        self
    }
    /// A list with this problem only.
    pub fn alone(self) -> Problems {
        Problems(vec![self])
    }
    /// Whether it prevents the scene from running.
    pub fn is_error(&self) -> bool {
        self.severity == Severity::Error
    }
}

impl fmt::Display for Problem {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let severity = if self.is_error() { "error" } else { "warning" };
        let place = if self.pointer.is_empty() { "/" } else { &self.pointer };
        write!(f, "{severity} [{}] {place}: {}", self.code, self.message)?;
        if !self.value.is_null() {
            write!(f, "; found {}", self.value)?;
        }
        if !self.limit.is_empty() {
            write!(f, "; must be {}", self.limit)?;
        }
        if !self.remedy.is_empty() {
            write!(f, "; {}", self.remedy)?;
        }
        Ok(())
    }
}

/// Truncates a long text or list.
fn shortened(value: Value) -> Value {
    const LONGEST: usize = 120;
    let text = match &value {
        Value::String(text) => text.clone(),
        Value::Array(_) | Value::Object(_) => value.to_string(),
        _ => return value,
    };
    if text.chars().count() <= LONGEST {
        return value;
    }
    Value::String(text.chars().take(LONGEST).chain("…".chars()).collect())
}

/// All problems of a scene that cannot run: at least one error, and the warnings found on the way, in the order in which
/// they were found.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(transparent)]
pub struct Problems(pub Vec<Problem>);

impl Problems {
    /// Number of problems that prevent the scene from running.
    pub fn error_count(&self) -> usize {
        self.0.iter().filter(|p| p.is_error()).count()
    }
    /// The problems of a document that is embedded at `place` in another one.
    #[must_use]
    pub fn under(self, place: &Pointer) -> Self {
        Self(self.0.into_iter().map(|problem| problem.under(place)).collect())
    }
    /// All problems, or the value of `found` if there are none.
    ///
    /// # Errors
    /// These problems, followed by those of `found`.
    pub fn then<T>(mut self, found: Result<T, Self>) -> Result<T, Self> {
        match found {
            Ok(good) if self.0.is_empty() => return Ok(good),
            Ok(_) => {}
            Err(Self(others)) => self.0.extend(others),
        }
        Err(self)
    }
    /// The first problem that prevents the scene from running.
    pub fn first_error(&self) -> Option<&Problem> {
        self.0.iter().find(|p| p.is_error())
    }
}

impl fmt::Display for Problems {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "the input has {} error(s)", self.error_count())?;
        self.0.iter().try_for_each(|p| write!(f, "\n{p}"))
    }
}

impl std::error::Error for Problems {}

/// A JSON pointer (RFC 6901) under construction.
#[derive(Clone, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub struct Pointer(String);

impl Pointer {
    /// Pointer to the whole document.
    pub fn root() -> Self {
        Self::default()
    }
    /// A pointer from its text, such as `/bodies/0`.
    pub fn from_text(text: impl Into<String>) -> Self {
        Self(text.into())
    }
    /// Pointer to a member of the object here.
    #[must_use]
    pub fn key(&self, name: &str) -> Self {
        Self(format!("{}/{}", self.0, name.replace('~', "~0").replace('/', "~1")))
    }
    /// Pointer to an item of the list here.
    #[must_use]
    pub fn index(&self, index: usize) -> Self {
        Self(format!("{}/{index}", self.0))
    }
    /// The text of the pointer, as in RFC 6901.
    pub fn as_str(&self) -> &str {
        &self.0
    }
}

/// The known name nearest to a wrong one, if it is near enough to be what was meant.
pub fn nearest_name<'a>(wrong: &str, known: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    let nearness = |name: &str| edit_distance(&wrong.to_lowercase(), &name.to_lowercase());
    known
        .into_iter()
        .map(|name| {
            // A beginning ("density" for "density_kg_per_m3") usually means that the unit was forgotten.
            let begins = wrong.len() >= 3 && name.starts_with(wrong);
            (if begins { 1 } else { nearness(name) }, name)
        })
        .filter(|(distance, name)| *distance <= 1 + name.chars().count().min(wrong.chars().count()) / 3)
        .min_by_key(|(distance, _)| *distance)
        .map(|(_, name)| name)
}

/// Common synonyms, with the name used here.
const OTHER_WORDS: [(&str, &str); 12] = [
    ("path", "name"),
    ("file", "name"),
    ("filename", "name"),
    ("chest", "thorax"),
    ("torso", "thorax"),
    ("belly", "abdomen"),
    ("stomach", "abdomen"),
    ("thigh", "limb"),
    ("leg", "limb"),
    ("arm", "limb"),
    ("neck", "head"),
    ("face", "head"),
];

/// "did you mean …?" when a similar name exists, otherwise the list of known names.
pub fn suggest<'a>(wrong: &str, known: impl IntoIterator<Item = &'a str>) -> String {
    const MOST: usize = 12;
    let known: Vec<&str> = known.into_iter().collect();
    let other =
        OTHER_WORDS.iter().find(|(word, name)| wrong.eq_ignore_ascii_case(word) && known.contains(name));
    match other.map(|(_, name)| *name).or_else(|| nearest_name(wrong, known.iter().copied())) {
        Some(name) => format!("did you mean {name:?}?"),
        None if known.is_empty() => "none exists".into(),
        None if known.len() > MOST => format!("known names: {}, …", known[..MOST].join(", ")),
        None => format!("known names: {}", known.join(", ")),
    }
}

/// Levenshtein distance: insertions, deletions and substitutions of characters.
fn edit_distance(a: &str, b: &str) -> usize {
    let b: Vec<char> = b.chars().collect();
    let mut row: Vec<usize> = (0..=b.len()).collect();
    for (i, x) in a.chars().enumerate() {
        let mut diagonal = row[0];
        row[0] = i + 1;
        for (j, y) in b.iter().enumerate() {
            let substituted = diagonal + usize::from(x != *y);
            diagonal = row[j + 1];
            row[j + 1] = substituted.min(row[j] + 1).min(diagonal + 1);
        }
    }
    row[b.len()]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pointers_escape_as_rfc_6901_says() {
        assert_eq!(Pointer::root().key("a/b").index(3).key("m~n").as_str(), "/a~1b/3/m~0n");
    }

    #[test]
    fn near_names_are_suggested_and_far_ones_are_not() {
        let known = ["density_kg_per_m3", "material", "part"];
        assert_eq!(nearest_name("densty_kg_per_m3", known), Some("density_kg_per_m3"));
        assert_eq!(nearest_name("density", known), Some("density_kg_per_m3"));
        assert_eq!(nearest_name("Material", known), Some("material"));
        assert_eq!(nearest_name("velocity", known), None);
        assert_eq!(edit_distance("kitten", "sitting"), 3);
    }

    #[test]
    fn long_values_are_shortened() {
        let problem = Problem::error("x", &Pointer::root(), "m").value("é".repeat(1000));
        assert_eq!(problem.value.as_str().unwrap().chars().count(), 121);
    }
}
