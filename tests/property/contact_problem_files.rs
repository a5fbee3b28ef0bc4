//! Whatever is in the file of a contact problem, it is read or refused with reasons.

use crate::changes::{changed, changes};
use contuse::record::contact_problem_file::read_contact_problem;
use proptest::prelude::*;
use serde_json::Value;
use std::sync::LazyLock;

static PROBLEM: LazyLock<Value> = LazyLock::new(|| {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/data/contact_problems/g01_hex_1c.json");
    serde_json::from_slice(&std::fs::read(path).unwrap()).unwrap()
});

proptest! {
    #[test]
    fn a_changed_problem_is_read_or_refused_with_reasons(changes in changes()) {
        let bytes = changed(&PROBLEM, changes).to_string().into_bytes();
        if let Err(problems) = read_contact_problem(&bytes, "changed") {
            prop_assert!(problems.error_count() > 0, "{problems:?}");
        }
    }
}
