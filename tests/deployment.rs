//! The examples of deployment name commands, options and variables that the program has. They are read as text: no container runs here.

// A test fails by panicking.
#![allow(clippy::unwrap_used)]
#![cfg(feature = "service")]

use std::process::Command;

const FILES: [(&str, &str); 3] = [
    ("compose.yaml", include_str!("../compose.yaml")),
    ("deploy/kubernetes.yaml", include_str!("../deploy/kubernetes.yaml")),
    ("Dockerfile", include_str!("../Dockerfile")),
];

/// Lists in brackets after a key: commands of containers.
fn commands(text: &'static str) -> Vec<Vec<&'static str>> {
    let list = |line: &'static str| {
        let (key, items) = line.trim().split_once([':', ' '])?;
        let items = items.trim().strip_prefix('[')?.split_once(']')?.0;
        let is_command = ["command", "args", "CMD"].contains(&key);
        is_command.then(|| items.split(',').map(|item| item.trim().trim_matches('"')).collect())
    };
    text.lines().filter_map(list).collect()
}

fn help_after(arguments: &[&str]) -> (bool, String) {
    let output = Command::new(env!("CARGO_BIN_EXE_contuse")).args(arguments).arg("--help").output().unwrap();
    (output.status.success(), String::from_utf8(output.stdout).unwrap())
}

#[test]
fn commands_of_containers_are_those_of_the_program() {
    assert!(!help_after(&["serve", "--no-such-option"]).0, "an option before --help is read");
    let mut tried = Vec::new();
    for (file, text) in FILES {
        for command in commands(text) {
            if ["serve", "worker"].contains(&command[0]) {
                assert!(help_after(&command).0, "{file}: {command:?}");
                tried.push(file);
            }
        }
    }
    assert_eq!(
        tried,
        ["compose.yaml", "compose.yaml", "deploy/kubernetes.yaml", "deploy/kubernetes.yaml", "Dockerfile"]
    );
}

#[test]
fn variables_of_containers_are_those_of_the_program() {
    let help = ["serve", "worker"].map(|command| help_after(&[command]).1).concat();
    let mut count = 0;
    for (file, text) in FILES {
        let words = text.split(|c: char| !(c.is_ascii_uppercase() || c == '_'));
        // That of the commit is read by the compiler.
        let is_read = |word: &&str| word.starts_with("CONTUSE_") && *word != "CONTUSE_COMMIT";
        for variable in words.filter(is_read) {
            let is_known = ["=", "]"].iter().any(|end| help.contains(&format!("[env: {variable}{end}")));
            assert!(is_known, "{file}: {variable}");
            count += 1;
        }
    }
    assert!(count > 5, "{count}");
}
