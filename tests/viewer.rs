//! The files of the viewer, read as text: vendored modules are those of their packages, nothing comes from other hosts.

// A test fails by panicking, also in the functions that it calls.
#![allow(clippy::unwrap_used)]

use sha2::{Digest, Sha256};
use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::fs;
use std::path::{Path, PathBuf};

fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("api/viewer")
}

/// Every file under a folder, by its path from there.
fn files_under(folder: &Path) -> BTreeMap<String, Vec<u8>> {
    let mut found = BTreeMap::new();
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        let name = path.file_name().unwrap().to_string_lossy().into_owned();
        if path.is_dir() {
            found.extend(files_under(&path).into_iter().map(|(rest, data)| (format!("{name}/{rest}"), data)));
        } else {
            found.insert(name, fs::read(&path).unwrap());
        }
    }
    found
}

fn hexadecimal(bytes: &[u8]) -> String {
    bytes.iter().fold(String::new(), |mut text, byte| {
        write!(text, "{byte:02x}").unwrap();
        text
    })
}

#[test]
fn vendored_modules_are_those_of_their_packages() {
    let mut files = files_under(&folder().join("vendor"));
    let list = String::from_utf8(files.remove("VENDORED.md").unwrap()).unwrap();
    let listed: BTreeMap<String, String> = list
        .lines()
        .filter_map(|line| {
            let cells: Vec<&str> = line.split('`').collect();
            let [_, path, _, digest, _] = cells[..] else { return None };
            (digest.len() == 64).then(|| (path.to_owned(), digest.to_owned()))
        })
        .collect();
    let digest = |data: Vec<u8>| hexadecimal(&Sha256::digest(data));
    let present: BTreeMap<String, String> =
        files.into_iter().map(|(path, data)| (path, digest(data))).collect();
    assert!(present.len() > 10);
    assert_eq!(listed, present, "vendor/VENDORED.md and the files disagree");
}

#[test]
fn own_files_load_nothing_from_elsewhere_and_need_no_inline_style() {
    // Namespaces of SVG and links that a reader may follow are no loading.
    let loading = [
        "src=\"http",
        "from \"http",
        "import(\"http",
        "import \"http",
        "url(http",
        "fetch(\"http",
        "<style",
        " style=\"",
        "eval(",
    ];
    for (path, data) in files_under(&folder()).into_iter().filter(|(path, _)| !path.starts_with("vendor/")) {
        let text = String::from_utf8(data).unwrap();
        for word in loading {
            assert!(!text.contains(word), "{path}: {word}");
        }
    }
}

#[test]
fn page_has_one_import_map_and_no_other_inline_script() {
    let page = fs::read_to_string(folder().join("index.html")).unwrap();
    // The service takes its digest into the content security policy.
    assert_eq!(page.matches("<script type=\"importmap\">").count(), 1);
    let inline = page.matches("<script").count() - page.matches("<script type=\"module\" src=").count();
    assert_eq!(inline, 1);
}

#[test]
fn modules_stay_readable() {
    for (path, data) in files_under(&folder()).into_iter().filter(|(path, _)| !path.starts_with("vendor/")) {
        let lines = String::from_utf8(data).unwrap().lines().count();
        assert!(lines <= 300, "{path}: {lines} lines");
    }
}
