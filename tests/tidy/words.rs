//! The words of code, messages and docs are those of finite elements, contact mechanics and injury biomechanics.

use super::{expect_none, files_under, read, relative, root};
use std::path::Path;

/// Words that stood for a standard term, with that term. `_` counts as a space, capitals as small letters.
const REPLACED: [(&str, &str); 24] = [
    ("told", "reported"),
    ("tell", "report"),
    ("tells", "reports"),
    ("foretells", "predicts"),
    ("foretold", "predicted"),
    ("nobody", "no one in particular: name what is missing"),
    ("left out", "omitted"),
    ("leave out", "omit"),
    ("leaves out", "omits"),
    ("leaving out", "omitting"),
    ("put back", "restored"),
    ("puts back", "restores"),
    ("judge", "validate, evaluate"),
    ("judges", "validates, evaluates"),
    ("judged", "validated, evaluated"),
    ("caught", "impact activation, detected contact"),
    ("settling", "dynamic relaxation"),
    ("settles", "relaxes"),
    ("settled", "relaxed, converged"),
    ("waking", "activation"),
    ("awake", "active"),
    ("asleep", "inactive"),
    ("quiet elements", "inactive elements"),
    ("swept elements", "evaluated elements"),
];

/// The changelog, the migrations of the store and their test name what was renamed.
fn is_checked(path: &str) -> bool {
    let is_text = [".rs", ".md", ".js", ".json", ".py", ".html", ".proto", ".toml"]
        .iter()
        .any(|end| path.ends_with(end));
    let is_here = ["src/", "tests/", "benches/", "examples/", "docs/", "scenarios/", "api/"]
        .iter()
        .any(|folder| path.starts_with(folder))
        || path == "README.md"
        || path == "Cargo.toml"
        || path == "ARCHITECTURE.md";
    let is_exempt = path.starts_with("tests/tidy/")
        || path == "src/service/jobs/store/sqlite/tests.rs"
        || path.starts_with("tests/data/")
        || path.starts_with("api/viewer/vendor/")
        || path.starts_with("api/python/tests/");
    is_text && is_here && !is_exempt
}

/// Words in small letters with a space around each; signs other than `_` and those of a new line separate phrases.
fn normalised(line: &str) -> String {
    let apart = |c: char| match c {
        '_' => " ".to_owned(),
        c if c.is_alphanumeric() || c.is_whitespace() => c.to_lowercase().to_string(),
        _ => " | ".to_owned(),
    };
    let text: String = line.replace("\\n", " ").chars().map(apart).collect();
    format!(" {} ", text.split_whitespace().collect::<Vec<_>>().join(" "))
}

/// Whether a phrase has "leave" and, a few words later, "out".
fn leaves_something_out(text: &str) -> bool {
    let words: Vec<&str> = text.split_whitespace().collect();
    let later = |at: usize| {
        words[at + 1..].iter().take(6).take_while(|word| **word != "|").any(|word| *word == "out")
    };
    words.iter().enumerate().any(|(at, word)| ["leave", "leaves", "left"].contains(word) && later(at))
}

fn violations_in(file: &Path) -> Vec<String> {
    let path = relative(file);
    let mut found = Vec::new();
    for (i, line) in read(file).lines().enumerate() {
        let text = normalised(line);
        for (word, term) in REPLACED.iter().filter(|(word, _)| text.contains(&format!(" {word} "))) {
            found.push(format!("{path}:{}: `{word}` (rather: {term})", i + 1));
        }
        if leaves_something_out(&text) {
            found.push(format!("{path}:{}: `leave … out` (rather: omit)", i + 1));
        }
    }
    found
}

#[test]
fn terms_are_those_of_the_field() {
    let files = files_under(root()).into_iter().filter(|file| is_checked(&relative(file)));
    let violations: Vec<String> = files.flat_map(|file| violations_in(&file)).collect();
    expect_none("a standard term has no private synonym", &violations);
}

#[test]
fn phrases_are_found_within_one_sentence() {
    assert_eq!(normalised("fn leaves_out_the_wall()"), " fn leaves out the wall | | ");
    assert!(normalised("\"\\nPut back: {}\"").contains(" put back "));
    assert!(!normalised("refined(self.elements_left, out)").contains(" left out "));
}
