//! The rules of ARCHITECTURE.md as tests: layers, what each module must not use, sizes, names, texts, words.
//!
//! They read the sources as text, line by line: fast, without dependencies, and blunt. A rule that gets in the way is
//! changed here, on purpose, with its reason.

// A test fails by panicking, also in the functions that it calls.
#![allow(clippy::expect_used)]

mod circles;
mod words;

use std::fs;
use std::path::{Path, PathBuf};

/// The modules of `src`, lowest first: a module may use itself and those before it.
const MODULES: [&str; 12] = [
    "blobs",
    "mechanics",
    "mesh",
    "scene",
    "plan",
    "step",
    "measure",
    "record",
    "study",
    "report",
    "service",
    "cli",
];

/// Lines of code in one file, comments, blank lines and unit tests apart. Aim at 300.
const MOST_LINES_OF_CODE: usize = 400;

/// One source file, taken apart.
struct Source {
    /// Path from the root of the package, with `/`.
    path: String,
    /// Lines with their numbers from 1.
    lines: Vec<(usize, String)>,
    /// Index into `lines` where the unit tests at the end of the file begin.
    tests_from: usize,
}

impl Source {
    fn read(path: &Path) -> Self {
        let mut text = read(path);
        let path = relative(path);
        // The mathematics is a package of its own, and a module of the library.
        if path.starts_with("src/mechanics/") {
            text = text.replace("crate::", "crate::mechanics::");
        }
        let lines: Vec<(usize, String)> =
            text.lines().map(str::to_owned).enumerate().map(|(i, l)| (i + 1, l)).collect();
        let is_test_file =
            path.starts_with("tests/") || path.ends_with("/tests.rs") || path.contains("/tests/");
        let inline_tests = lines.windows(4).position(|w| {
            w[0].1.trim() == "#[cfg(test)]"
                && w[1..].iter().any(|(_, l)| l.trim_start().starts_with("mod tests {"))
        });
        let tests_from = if is_test_file { 0 } else { inline_tests.unwrap_or(lines.len()) };
        Self { path, lines, tests_from }
    }

    /// The lines outside unit tests, without comments.
    fn code(&self) -> impl Iterator<Item = (usize, &str)> {
        let lines = self.lines[..self.tests_from].iter();
        lines
            .map(|(number, line)| (*number, without_comment(line)))
            .filter(|(_, line)| !line.trim().is_empty())
    }

    /// All lines without comments, tests included.
    fn all_code(&self) -> impl Iterator<Item = (usize, &str)> {
        self.lines.iter().map(|(number, line)| (*number, without_comment(line)))
    }

    /// The module of `src` that the file is in.
    fn module(&self) -> Option<&str> {
        let rest = self.path.strip_prefix("src/")?;
        rest.split_once('/').map(|(module, _)| module)
    }
}

/// The line up to `//`, if that does not stand in a string (as in an address).
fn without_comment(line: &str) -> &str {
    let is_comment = |i: usize| !line[..i].ends_with(':') && line[..i].matches('"').count().is_multiple_of(2);
    line.match_indices("//").map(|(i, _)| i).find(|i| is_comment(*i)).map_or(line, |i| &line[..i])
}

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

fn relative(path: &Path) -> String {
    path.strip_prefix(root()).expect("a file of the package").to_string_lossy().replace('\\', "/")
}

fn read(path: &Path) -> String {
    fs::read_to_string(path).unwrap_or_else(|e| panic!("{}: {e}", path.display()))
}

/// Every file under a folder, sorted, without what is built, recorded or fetched.
fn files_under(folder: &Path) -> Vec<PathBuf> {
    const OMITTED: [&str; 5] = ["target", ".git", ".venv", "data", "node_modules"];
    let mut found = Vec::new();
    let mut entries: Vec<PathBuf> = fs::read_dir(folder)
        .into_iter()
        .flatten()
        .map(|entry| entry.expect("a readable folder").path())
        .collect();
    entries.sort();
    for path in entries {
        let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
        let is_omitted = OMITTED.contains(&name.as_str()) && relative(&path) != "tests/data";
        if path.is_dir() && !is_omitted {
            found.extend(files_under(&path));
        } else if path.is_file() && path.extension().is_none_or(|e| e != "mcap") {
            found.push(path);
        }
    }
    found
}

fn sources(folders: &[&str]) -> Vec<Source> {
    let files = folders.iter().flat_map(|folder| files_under(&root().join(folder)));
    files.filter(|path| path.extension().is_some_and(|e| e == "rs")).map(|path| Source::read(&path)).collect()
}

/// Fails with every violation at once.
fn expect_none(rule: &str, violations: &[String]) {
    assert!(violations.is_empty(), "{rule}:\n  {}\n", violations.join("\n  "));
}

/// Violations in the code (tests apart) of the sources that `applies` picks.
fn forbid(sources: &[Source], words: &[&str], applies: impl Fn(&Source) -> bool) -> Vec<String> {
    let mut violations = Vec::new();
    for source in sources.iter().filter(|s| applies(s)) {
        for (number, line) in source.code() {
            for word in words.iter().filter(|word| line.contains(**word)) {
                violations.push(format!("{}:{number}: `{word}` in `{}`", source.path, line.trim()));
            }
        }
    }
    violations
}

#[test]
fn the_image_is_built_from_all_that_the_program_is() {
    let admitted = read(&root().join(".dockerignore"));
    for file in ["Cargo.toml", "Cargo.lock", "build.rs", "src", "benches", "api", "scenarios"] {
        assert!(root().join(file).exists(), "{file}");
        assert!(
            admitted.lines().any(|line| line == format!("!{file}")),
            ".dockerignore does not admit {file}"
        );
    }
}

#[test]
fn modules_use_only_the_modules_below_them() {
    let rank = |module: &str| MODULES.iter().position(|r| *r == module);
    let mut violations = Vec::new();
    for source in sources(&["src"]) {
        let Some(module) = source.module() else { continue };
        let Some(own) = rank(module) else {
            violations.push(format!("{}: `{module}` is not in the list of modules", source.path));
            continue;
        };
        for (number, line) in source.all_code() {
            for (at, _) in line.match_indices("crate::") {
                let path = &line[at + "crate::".len()..];
                let name: String = path.chars().take_while(|c| c.is_alphanumeric() || *c == '_').collect();
                if name.is_empty() || rank(&name).is_some_and(|other| other > own) {
                    violations.push(format!("{}:{number}: {module} uses `crate::{path}`", source.path));
                }
            }
        }
    }
    expect_none(
        &format!("imports run one way, each module by its own `use`: {}", MODULES.join(" < ")),
        &violations,
    );
}

#[test]
fn a_module_does_not_reach_out_by_super() {
    // In `src/<module>/mod.rs`, `super` is the crate: an import that the rule of the layers would not see.
    let sources = sources(&["src"]);
    let is_module_file = |s: &Source| s.path.matches('/').count() == 2 && s.path.ends_with("/mod.rs");
    expect_none("modules are named from the crate", &forbid(&sources, &["super::"], is_module_file));
}

#[test]
fn mechanics_is_mathematics_only() {
    let words =
        ["serde", "tracing", "std::time", "std::fs", "std::io", "std::env", "std::net", "print", "HashMap"];
    let in_mechanics = |s: &Source| s.module() == Some("mechanics");
    let violations = forbid(&sources(&["src"]), &words, in_mechanics);
    expect_none("no input or output, clock, logging or unordered map in mechanics", &violations);
}

#[test]
fn results_do_not_depend_on_the_order_of_a_hash() {
    let engine =
        |s: &Source| s.module().is_some_and(|module| ["plan", "step", "measure", "record"].contains(&module));
    let violations = forbid(&sources(&["src"]), &["HashMap", "HashSet"], engine);
    expect_none("ordered maps only, between the scene and the recording", &violations);
}

#[test]
fn the_engine_reads_no_clock() {
    // A scene gives the same plan and the same bits on every machine, however fast.
    let engine =
        |s: &Source| s.module().is_some_and(|module| ["scene", "plan", "step", "measure"].contains(&module));
    let violations = forbid(&sources(&["src"]), &["std::time", "Instant::", "SystemTime"], engine);
    expect_none("no clock below the recorders", &violations);
}

#[test]
fn only_the_command_line_prints() {
    let may_print = |s: &Source| s.module() == Some("cli") || s.path == "src/main.rs";
    let violations = forbid(&sources(&["src"]), &["println!", "print!"], |s| !may_print(s));
    expect_none("nothing prints but the command line", &violations);
}

#[test]
fn nothing_is_left_for_later_and_nothing_panics_on_purpose() {
    let sources = sources(&["src", "benches", "tests"]);
    let mut violations = forbid(&sources, &[".unwrap()", ".expect(", "panic!("], |_| true);
    let this_file = file!();
    for source in sources.iter().filter(|s| s.path != this_file) {
        for (number, line) in &source.lines {
            for word in ["todo!", "unimplemented!", "dbg!", "TODO", "FIXME", "XXX"] {
                if line.contains(word) {
                    violations.push(format!("{}:{number}: `{word}`", source.path));
                }
            }
        }
    }
    expect_none("errors are values, and what is not done is not there", &violations);
}

#[test]
fn unsafe_code_says_why_it_is_sound() {
    let mut violations = Vec::new();
    for source in sources(&["src"]) {
        for (i, (number, line)) in source.lines.iter().enumerate() {
            let uses =
                without_comment(line).split(|c: char| !c.is_alphanumeric()).any(|word| word == "unsafe");
            let explained = source.lines[i.saturating_sub(6)..i].iter().any(|(_, l)| l.contains("SAFETY"));
            if uses && !explained {
                violations.push(format!("{}:{number}", source.path));
            }
        }
    }
    expect_none("unsafe needs a SAFETY note above it", &violations);
}

#[test]
fn files_stay_readable() {
    let mut violations = Vec::new();
    for source in sources(&["src", "benches", "tests"]) {
        let tests =
            source.all_code().filter(|(_, line)| !line.trim().is_empty()).count() - source.code().count();
        for (what, count) in [("code", source.code().count()), ("tests", tests)] {
            if count > MOST_LINES_OF_CODE {
                violations.push(format!("{}: {count} lines of {what}", source.path));
            }
        }
    }
    expect_none(&format!("at most {MOST_LINES_OF_CODE} lines of code in a file"), &violations);
}

#[test]
fn every_file_says_what_it_is_for() {
    // Unit tests in a file of their own are for the file that they are named after.
    let is_named_after = |s: &Source| s.path.ends_with("/tests.rs");
    let starts_with_docs = |s: &Source| s.lines.first().is_some_and(|(_, line)| line.starts_with("//! "));
    let sources = sources(&["src", "benches", "tests"]);
    let violations: Vec<String> = sources
        .iter()
        .filter(|s| !starts_with_docs(s) && !is_named_after(s))
        .map(|s| s.path.clone())
        .collect();
    expect_none("a file begins with `//!`", &violations);
}

#[test]
fn names_say_what_is_inside() {
    let empty_words = ["utils", "util", "helpers", "helper", "common", "misc", "manager"];
    let mut violations = Vec::new();
    for file in files_under(root()) {
        let path = relative(&file);
        let stems = path.split('/').map(|part| part.split('.').next().unwrap_or_default());
        if stems.into_iter().any(|s| empty_words.contains(&s) || s.ends_with("_new") || s.ends_with("_v2")) {
            violations.push(path);
        }
    }
    expect_none("no drawers for odds and ends", &violations);
}

#[test]
fn only_one_file_knows_the_error_statuses_of_http() {
    // Statuses of success and of redirection stand where the answer is made.
    const NO_ERRORS: [&str; 6] =
        ["OK", "CREATED", "ACCEPTED", "NO_CONTENT", "PARTIAL_CONTENT", "NOT_MODIFIED"];
    let mut violations = Vec::new();
    for source in sources(&["src"]).iter().filter(|s| s.path != "src/service/http/problem.rs") {
        for (number, line) in source.code() {
            let statuses = line.match_indices("StatusCode::").map(|(at, word)| &line[at + word.len()..]);
            let is_error = |rest: &str| {
                let name: String = rest.chars().take_while(|c| c.is_alphanumeric() || *c == '_').collect();
                !NO_ERRORS.contains(&name.as_str())
            };
            let in_http = source.path.starts_with("src/service/http/");
            if statuses.into_iter().any(is_error) || (!in_http && line.contains("StatusCode")) {
                violations.push(format!("{}:{number}: {}", source.path, line.trim()));
            }
        }
    }
    expect_none(
        "error statuses live in service/http/problem.rs, statuses at all in service/http",
        &violations,
    );
}

#[test]
fn texts_belong_to_no_machine() {
    // Taken apart so that this file does not find itself.
    let folders = ["root", "home", "work"].map(|folder| format!("/{folder}/"));
    let words = ["index-url", "shared/design", "shared/data"].map(str::to_owned);
    let this_file = root().join(file!());
    let mut violations = Vec::new();
    let files = files_under(root()).into_iter().filter(|f| *f != this_file && !f.ends_with(".git"));
    for file in files {
        let Ok(text) = fs::read_to_string(&file) else { continue };
        for (i, line) in text.lines().enumerate() {
            // A folder of the machine stands alone: in `net/work/x` it is another path's.
            let stands_alone =
                |at: usize| !line[..at].ends_with(|c: char| c.is_alphanumeric() || "._-~}".contains(c));
            let machine =
                folders.iter().any(|f| line.match_indices(f.as_str()).any(|(at, _)| stands_alone(at)));
            if machine || words.iter().any(|word| line.contains(word.as_str())) {
                violations.push(format!("{}:{}: {}", relative(&file), i + 1, line.trim()));
            }
        }
    }
    expect_none("no paths or package mirrors of one machine, no documents that are not here", &violations);
}

#[test]
fn packages_come_from_the_public_registry() {
    let lock = read(&root().join("Cargo.lock"));
    let foreign =
        |line: &&str| line.starts_with("source = ") && !line.contains("rust-lang/crates.io-index\"");
    let violations: Vec<String> = lock.lines().filter(foreign).map(str::to_owned).collect();
    expect_none("every crate from crates.io", &violations);
}

#[test]
fn every_scenario_explains_itself() {
    let folder = root().join("scenarios");
    let validation = folder.join("validation");
    let mut violations = Vec::new();
    for entry in [&folder, &validation].into_iter().flat_map(fs::read_dir).flatten() {
        let path = entry.expect("a readable folder").path();
        for file in ["README.md", "scene.json", "expected.json"] {
            if path.is_dir() && path != validation && !path.join(file).is_file() {
                violations.push(format!("{}/{file} is missing", relative(&path)));
            }
        }
    }
    expect_none("a scenario is scene.json, README.md and expected.json", &violations);
}

#[test]
fn every_link_between_pages_leads_to_a_file() {
    let mut violations = Vec::new();
    let is_page = |path: &PathBuf| path.extension().is_some_and(|e| e == "md");
    for page in files_under(root()).into_iter().filter(is_page) {
        let folder = page.parent().expect("a page lies in a folder");
        for (i, line) in read(&page).lines().enumerate() {
            // What follows `](` up to the bracket, without the heading after `#`.
            let targets = line.split("](").skip(1).filter_map(|rest| rest.split(')').next());
            let files = targets.filter_map(|target| target.split('#').next());
            for file in files.filter(|file| !file.is_empty() && !file.contains(':')) {
                if !folder.join(file).exists() {
                    violations.push(format!("{}:{}: {file}", relative(&page), i + 1));
                }
            }
        }
    }
    expect_none("every relative link of a page leads to a file or folder", &violations);
}

#[test]
fn the_architecture_page_knows_every_module() {
    let page = read(&root().join("ARCHITECTURE.md"));
    let violations: Vec<String> = MODULES
        .into_iter()
        .filter(|module| !page.contains(&format!("`{module}/`")))
        .map(str::to_owned)
        .collect();
    expect_none("ARCHITECTURE.md has a paragraph on each module", &violations);
}

#[test]
fn paths_on_the_architecture_page_exist() {
    let mut known: Vec<String> = files_under(root()).iter().map(|file| relative(file)).collect();
    let folders: Vec<String> =
        known.iter().flat_map(|file| file.match_indices('/').map(|(i, _)| file[..=i].to_owned())).collect();
    known.extend(folders);
    let is_known = |path: &str| {
        let below = format!("/{path}");
        known.iter().any(|known| known == path || known.ends_with(&below))
    };
    // A path may be followed by the function that is meant: `http/jobs.rs::submit`.
    let page = read(&root().join("ARCHITECTURE.md"));
    let named = page.split('`').skip(1).step_by(2).map(|word| word.split("::").next().unwrap_or_default());
    let is_path = |word: &&str| {
        word.chars().all(|c| c.is_alphanumeric() || "/_.-".contains(c))
            && [".rs", ".js", ".md", "/"].iter().any(|end| word.ends_with(end))
    };
    let violations: Vec<String> =
        named.filter(is_path).filter(|path| !is_known(path)).map(str::to_owned).collect();
    expect_none("every file and folder that ARCHITECTURE.md names exists", &violations);
}

#[test]
fn the_readme_and_the_ci_run_the_same_commands() {
    let (readme, ci) = (read(&root().join("README.md")), read(&root().join(".ci/run")));
    let commands =
        ["cargo run --release -- run scenarios/flashball_thigh/scene.json", "cargo test --release"];
    let is_missing = |command: &&str| !(readme.contains(*command) && ci.contains(*command));
    let violations: Vec<String> = commands.into_iter().filter(is_missing).map(str::to_owned).collect();
    expect_none("both name the same two commands", &violations);
}
