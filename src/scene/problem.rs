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
    /// The problem with texts of bounded length: names of members may be as long as the document.
    fn in_short(mut self) -> Self {
        for text in [&mut self.pointer, &mut self.message, &mut self.limit, &mut self.remedy] {
            if let Some((end, _)) = text.char_indices().nth(LONGEST_TEXT) {
                text.truncate(end);
                text.push('…');
            }
        }
        self
    }
    /// A list with this problem only.
    pub fn alone(self) -> Problems {
        Problems(vec![self.in_short()])
    }
    /// Whether it prevents the scene from running.
    pub fn is_error(&self) -> bool {
        self.severity == Severity::Error
    }
    /// The problem as a sentence for readers of results, its place in the document last.
    pub fn in_words(&self) -> String {
        let mut rest = self.message.chars();
        let mut words: String = rest.next().into_iter().flat_map(char::to_uppercase).chain(rest).collect();
        let mut add = |before: &str, text: &str| {
            if !text.is_empty() {
                words += before;
                words += text;
            }
        };
        add("; ", &self.remedy);
        add(" (at ", if self.pointer.is_empty() { "/" } else { &self.pointer });
        add(", found ", &if self.value.is_null() { String::new() } else { self.value.to_string() });
        add(", must be ", &self.limit);
        words + ")."
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

/// Largest number of errors, and of warnings, in a list: whoever reads it corrects the first ones first.
pub const MOST_LISTED: usize = 100;
/// Code of the last problem of a list that ends early; its value is the number of those that are not listed.
const MORE: &str = "too_many_problems";
/// Problems of one severity that are kept while a list is made, from which checks may remove some.
const MOST_KEPT: usize = 10 * MOST_LISTED;
/// Longest text of a problem [characters].
const LONGEST_TEXT: usize = 2000;

/// Problems in the order in which they are found. Those beyond a limit are counted, so that the list is short whatever the
/// document is.
#[derive(Clone, Debug, Default)]
pub struct ProblemList {
    kept: Vec<Problem>,
    /// Numbers of errors and warnings found, kept or not.
    found: [u64; 2],
}

impl ProblemList {
    /// Adds a problem; beyond the limit of its severity it is only counted.
    pub fn push(&mut self, problem: Problem) {
        let index = usize::from(!problem.is_error());
        // The end of another list stands for all that it omits.
        if problem.code == MORE {
            self.found[index] += problem.value.as_u64().unwrap_or(0);
            return;
        }
        self.push_with(problem.severity, || problem);
    }
    /// Adds a problem, which is made only if it is kept.
    pub fn push_with(&mut self, severity: Severity, problem: impl FnOnce() -> Problem) {
        let found = &mut self.found[usize::from(severity == Severity::Warning)];
        *found += 1;
        if *found <= MOST_KEPT as u64 {
            self.kept.push(problem().in_short());
        }
    }
    /// Counts a problem that is not kept.
    pub fn count(&mut self, severity: Severity) {
        self.found[usize::from(severity == Severity::Warning)] += 1;
    }
    /// Whether further errors would not be listed.
    pub fn is_full(&self) -> bool {
        self.found[0] >= MOST_LISTED as u64
    }
    /// Whether there is an error.
    pub fn has_errors(&self) -> bool {
        self.found[0] > 0
    }
    /// Number of errors found, kept or not.
    pub fn error_count(&self) -> u64 {
        self.found[0]
    }
    /// Whether there is no problem.
    pub fn is_empty(&self) -> bool {
        self.found == [0, 0]
    }
    /// The problems that are kept.
    pub fn iter(&self) -> impl Iterator<Item = &Problem> {
        self.kept.iter()
    }
    /// Removes the problems that do not satisfy a condition.
    pub fn retain(&mut self, holds: impl Fn(&Problem) -> bool) {
        let found = &mut self.found;
        self.kept.retain(|problem| {
            let stays = holds(problem);
            found[usize::from(!problem.is_error())] -= u64::from(!stays);
            stays
        });
    }
    /// The first problems of each severity; if there are more, the last entry of that severity says how many.
    pub fn into_vec(self) -> Vec<Problem> {
        let mut listed = [0_u64; 2];
        let mut all = self.kept;
        all.retain(|problem| {
            let count = &mut listed[usize::from(!problem.is_error())];
            *count += u64::from(*count < MOST_LISTED as u64 + 1);
            *count <= MOST_LISTED as u64
        });
        for (index, severity) in [(0, Severity::Error), (1, Severity::Warning)] {
            let shown = listed[index].min(MOST_LISTED as u64);
            let more = self.found[index] - shown.min(self.found[index]);
            if more > 0 {
                let name = if index == 0 { "error" } else { "warning" };
                let message = format!("there are {more} more {name}s; only the first {shown} are listed");
                all.push(
                    Problem::new(severity, MORE, &Pointer::root(), message)
                        .value(more)
                        .limit(format!("a list of at most {MOST_LISTED}"))
                        .remedy("correct those that are listed, and check again"),
                );
            }
        }
        all
    }
}

impl Extend<Problem> for ProblemList {
    fn extend<T: IntoIterator<Item = Problem>>(&mut self, problems: T) {
        problems.into_iter().for_each(|problem| self.push(problem));
    }
}

impl FromIterator<Problem> for ProblemList {
    fn from_iter<T: IntoIterator<Item = Problem>>(problems: T) -> Self {
        let mut list = Self::default();
        list.extend(problems);
        list
    }
}

/// All problems of a scene that cannot run: at least one error, and the warnings found on the way, in the order in which
/// they were found. The list ends after [`MOST_LISTED`] errors, with the number of further ones.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(transparent)]
pub struct Problems(pub Vec<Problem>);

impl Problems {
    /// Number of problems that prevent the scene from running, those included that are not listed.
    pub fn error_count(&self) -> u64 {
        self.count(Severity::Error)
    }
    /// Number of warnings, those included that are not listed.
    pub fn warning_count(&self) -> u64 {
        self.count(Severity::Warning)
    }
    fn count(&self, severity: Severity) -> u64 {
        let of_entry = |p: &Problem| if p.code == MORE { p.value.as_u64().unwrap_or(1) } else { 1 };
        self.0.iter().filter(|p| p.severity == severity).map(of_entry).sum()
    }
    /// Number of errors that are not listed.
    pub fn omitted_errors(&self) -> u64 {
        let ends = self.0.iter().filter(|p| p.is_error() && p.code == MORE);
        ends.filter_map(|p| p.value.as_u64()).sum()
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
    pub fn then<T>(self, found: Result<T, Self>) -> Result<T, Self> {
        match found {
            Ok(good) if self.0.is_empty() => Ok(good),
            Ok(_) => Err(self),
            Err(Self(others)) => Err(self.0.into_iter().chain(others).collect()),
        }
    }
    /// The first problem that prevents the scene from running.
    pub fn first_error(&self) -> Option<&Problem> {
        self.0.iter().find(|p| p.is_error())
    }
}

impl From<ProblemList> for Problems {
    fn from(list: ProblemList) -> Self {
        Self(list.into_vec())
    }
}

impl FromIterator<Problem> for Problems {
    fn from_iter<T: IntoIterator<Item = Problem>>(problems: T) -> Self {
        problems.into_iter().collect::<ProblemList>().into()
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
    let known: Vec<&str> = known.into_iter().filter(|name| !name.is_empty()).collect();
    match did_you_mean(wrong, &known) {
        Some(question) => question,
        None if known.is_empty() => "none exists".into(),
        None if known.len() > MOST => format!("known names: {}, …", known[..MOST].join(", ")),
        None => format!("known names: {}", known.join(", ")),
    }
}

/// "did you mean …?" when a similar name exists.
pub fn did_you_mean(wrong: &str, known: &[&str]) -> Option<String> {
    let other =
        OTHER_WORDS.iter().find(|(word, name)| wrong.eq_ignore_ascii_case(word) && known.contains(name));
    let near = other.map(|(_, name)| *name).or_else(|| nearest_name(wrong, known.iter().copied()))?;
    Some(format!("did you mean {near:?}?"))
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
        let long = Problem::error("x", &Pointer::root().key(&"é".repeat(10_000)), "m").alone();
        assert_eq!(long.0[0].pointer.chars().count(), LONGEST_TEXT + 1);
    }

    #[test]
    fn a_list_ends_with_the_number_of_those_that_it_omits() {
        let mut list = ProblemList::default();
        for i in 0..5000 {
            list.push_with(Severity::Warning, || Problem::warning("w", &Pointer::root().index(i), "m"));
        }
        assert!(!list.has_errors(), "warnings refuse nothing, however many there are");
        list.push(Problem::error("e", &Pointer::root(), "m"));
        list.retain(|problem| problem.pointer != "/7");
        let problems = Problems::from(list);
        assert_eq!((problems.error_count(), problems.warning_count()), (1, 4999));
        assert_eq!(problems.0.len(), MOST_LISTED + 2);
        assert_eq!(problems.0[MOST_LISTED].code, "e", "errors are listed beside warnings");
        let last = problems.0.last().unwrap();
        assert_eq!((&*last.code, last.severity, last.value.as_u64()), (MORE, Severity::Warning, Some(4899)));
        let errors = |count| -> Problems {
            (0..count).map(|i| Problem::error("e", &Pointer::root().index(i), "m")).collect()
        };
        let both = errors(150).then::<()>(Err(errors(70))).unwrap_err();
        assert_eq!((both.error_count(), both.omitted_errors(), both.0.len()), (220, 120, MOST_LISTED + 1));
    }
}
