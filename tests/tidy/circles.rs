//! No circles: a file that another one uses, directly or over others, does not use that one.
//!
//! Uses are the paths that a file names outside of its unit tests, in `use` and elsewhere. One that leads over a `pub use` leads to
//! the file that this points to; the `pub use` itself is a signpost, and a use where the same file names it elsewhere.

use super::{Source, expect_none, sources};
use std::collections::{BTreeMap, BTreeSet};

type ModulePath = Vec<String>;

/// What a file names.
struct Names {
    file: String,
    used: Vec<ModulePath>,
    /// Where each `pub use` points to, by the name that it gives.
    signposts: BTreeMap<String, ModulePath>,
}

/// The files of `src` by the paths of their modules.
type Modules = BTreeMap<ModulePath, Names>;

fn segments(path: &str) -> ModulePath {
    path.split("::").map(|segment| segment.trim().to_owned()).filter(|s| !s.is_empty()).collect()
}

/// The path of the module that a file is.
fn module_of(file: &str) -> ModulePath {
    let path = file.trim_start_matches("src/").trim_end_matches(".rs");
    path.split('/').filter(|part| !["lib", "mod"].contains(part)).map(str::to_owned).collect()
}

/// The paths of a tree of `use`: `a::{b, c::{self, d as e}}` is `a::b`, `a::c`, `a::c::d`.
fn leaves(tree: &str) -> Vec<String> {
    let Some((before, group)) = tree.split_once('{') else {
        return vec![tree.split(" as ").next().unwrap_or_default().trim().to_owned()];
    };
    let group = group.rsplit_once('}').map_or(group, |(inside, _)| inside);
    let (mut depth, mut parts) = (0, vec![String::new()]);
    for c in group.chars() {
        depth += i32::from(c == '{') - i32::from(c == '}');
        match parts.last_mut() {
            Some(part) if c != ',' || depth > 0 => part.push(c),
            _ => parts.push(String::new()),
        }
    }
    let parts = parts.iter().filter(|part| !part.trim().is_empty());
    parts.flat_map(|part| leaves(part)).map(|leaf| format!("{before}{leaf}").replace("::self", "")).collect()
}

/// The `use` statements of a file, whether each is public, and the other text.
fn statements(source: &Source) -> (Vec<(bool, String)>, String) {
    let (mut uses, mut rest, mut is_open) = (Vec::<(bool, String)>::new(), String::new(), false);
    for (_, line) in source.code() {
        let line = line.trim();
        let begins = line.split_once("use ").filter(|(before, _)| {
            before.is_empty() || before.starts_with("pub") && !before.trim().contains(' ')
        });
        if let Some((before, tree)) = begins.filter(|_| !is_open) {
            uses.push((!before.is_empty(), tree.to_owned()));
        } else if let Some((_, tree)) = uses.last_mut().filter(|_| is_open) {
            tree.push_str(line);
        } else {
            rest.push_str(line);
            rest.push('\n');
            continue;
        }
        is_open = !line.ends_with(';');
    }
    (uses, rest)
}

/// Whether a line declares a module in a file of its own.
fn is_module(line: &str) -> bool {
    line.ends_with(';') && line.split_whitespace().rev().nth(1) == Some("mod")
}

/// A path that the module `own` names, from the crate on; `None` of what is no module of it.
fn from_the_crate(path: &str, own: &[String], known: &BTreeSet<ModulePath>) -> Option<ModulePath> {
    if path.starts_with("::") {
        return None;
    }
    let mut path = segments(path);
    let mut start = own.to_vec();
    match path.first()?.as_str() {
        "crate" => start.clear(),
        "self" | "super" => {}
        child => {
            start.push(child.to_owned());
            if !known.contains(&start) {
                return None;
            }
            path.remove(0);
            return Some([start, path].concat());
        }
    }
    while path.first().is_some_and(|first| first == "super") {
        start.pop()?;
        path.remove(0);
    }
    let rest = path.into_iter().filter(|segment| segment != "crate" && segment != "self");
    Some(start.into_iter().chain(rest).collect())
}

fn modules(sources: &[Source]) -> Modules {
    let of_library = || sources.iter().filter(|source| source.path != "src/main.rs");
    let known: BTreeSet<ModulePath> = of_library().map(|source| module_of(&source.path)).collect();
    let names = |source: &Source| {
        let own = module_of(&source.path);
        let mut names = Names { file: source.path.clone(), used: Vec::new(), signposts: BTreeMap::new() };
        let (uses, rest) = statements(source);
        let rest: Vec<&str> = rest.lines().filter(|line| !is_module(line)).collect();
        let words = || {
            let words =
                rest.iter().flat_map(|line| line.split(|c: char| !(c.is_alphanumeric() || "_:".contains(c))));
            words.map(|word| word.trim_end_matches(':'))
        };
        let named: BTreeSet<&str> = words().filter_map(|word| word.split("::").next()).collect();
        for (is_public, tree) in uses {
            for path in leaves(tree.trim_end_matches(';'))
                .iter()
                .filter_map(|leaf| from_the_crate(leaf, &own, &known))
            {
                let signpost = path.last().filter(|_| is_public).cloned();
                if signpost.as_ref().is_none_or(|name| named.contains(name.as_str())) {
                    names.used.push(path.clone());
                }
                names.signposts.extend(signpost.map(|name| (name, path)));
            }
        }
        let paths = words().filter(|word| word.contains("::"));
        names.used.extend(paths.filter_map(|path| from_the_crate(path, &own, &known)));
        (own, names)
    };
    of_library().map(names).collect()
}

/// The module that a path leads to, over signposts.
fn target(path: &[String], modules: &Modules, signposts_left: u32) -> Option<ModulePath> {
    let length = (0..=path.len()).rev().find(|&length| modules.contains_key(&path[..length]))?;
    let (module, rest) = path.split_at(length);
    let points_to = rest.first().and_then(|name| modules[module].signposts.get(name));
    match points_to.filter(|_| signposts_left > 0) {
        Some(to) => target(&[to, &rest[1..]].concat(), modules, signposts_left - 1),
        None => Some(module.to_vec()),
    }
}

/// The circles among files: in each, every file uses every other one, directly or over others.
fn circles(sources: &[Source]) -> BTreeSet<BTreeSet<String>> {
    let modules = modules(sources);
    let uses: BTreeMap<&ModulePath, BTreeSet<ModulePath>> = modules
        .iter()
        .map(|(own, names)| (own, names.used.iter().filter_map(|path| target(path, &modules, 9)).collect()))
        .collect();
    let reached = |from: &ModulePath| {
        let (mut found, mut ahead) = (BTreeSet::new(), vec![from.clone()]);
        while let Some(module) = ahead.pop() {
            ahead.extend(uses[&module].iter().filter(|next| found.insert((*next).clone())).cloned());
        }
        found
    };
    let reached: BTreeMap<&ModulePath, BTreeSet<ModulePath>> =
        modules.keys().map(|module| (module, reached(module))).collect();
    let circle_of = |own: &ModulePath| -> BTreeSet<String> {
        let back = reached[own].iter().filter(|other| reached[other].contains(own));
        back.map(|module| modules[module].file.clone()).collect()
    };
    modules.keys().map(circle_of).filter(|circle| circle.len() > 1).collect()
}

#[test]
fn files_do_not_use_each_other_in_circles() {
    let found = circles(&sources(&["src"]));
    let violations: Vec<String> = found.iter().map(|circle| format!("a circle: {circle:?}")).collect();
    expect_none("move what two files share to where both may use it", &violations);
}

#[test]
fn a_circle_is_found_over_a_signpost_and_by_a_path_in_the_code() {
    let source = |path: &str, text: &str| {
        let lines: Vec<(usize, String)> = text.lines().map(str::to_owned).enumerate().collect();
        Source { path: path.to_owned(), tests_from: lines.len(), lines }
    };
    let all = |b: &str| {
        [
            source("src/lib.rs", "pub mod room;"),
            source("src/room/mod.rs", "mod a;\nmod b;\npub use a::{\n    A,\n    other::B as C,\n};"),
            source("src/room/a.rs", "use ::b::B;\nfn f() { super::b::f() }"),
            source("src/room/b.rs", b),
        ]
    };
    let circle = BTreeSet::from(["src/room/a.rs".to_owned(), "src/room/b.rs".to_owned()]);
    assert_eq!(circles(&all("use crate::{room::A, other::{X, Y}};")), BTreeSet::from([circle]));
    assert_eq!(
        circles(&all("use crate::room::elsewhere;")),
        BTreeSet::new(),
        "it is another file of the module"
    );
}

#[test]
fn a_signpost_is_a_use_where_its_file_names_it() {
    let source = |path: &str, text: &str| {
        let lines: Vec<(usize, String)> = text.lines().map(str::to_owned).enumerate().collect();
        Source { path: path.to_owned(), tests_from: lines.len(), lines }
    };
    let with = |text: &str| {
        let room = format!("mod a;\npub use a::A;\n{text}");
        circles(&[
            source("src/room/mod.rs", &room),
            source("src/room/a.rs", "use super::Room;\npub struct A;"),
        ])
    };
    let circle = BTreeSet::from(["src/room/mod.rs".to_owned(), "src/room/a.rs".to_owned()]);
    assert_eq!(with("pub struct Room(Vec<A>);"), BTreeSet::from([circle.clone()]));
    assert_eq!(with("fn room() { A::new() }"), BTreeSet::from([circle]));
    assert_eq!(with("pub struct Room(B);\npub mod A;"), BTreeSet::new());
}
