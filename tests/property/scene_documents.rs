//! Whatever is written in a scene document, loading it ends with a scene or with problems: it never panics, and it never
//! fails without a reason.

use contuse::scene::{Budget, FolderSource, Problems, load};
use proptest::prelude::*;
use serde_json::{Value, json};
use std::path::Path;
use std::sync::LazyLock;

/// Small enough that a mutated count cannot make a test slow.
const BUDGET: Budget = Budget { elements: 3_000, steps: 100_000, ..Budget::SERVICE };

/// The folder of a scenario that ships, and its document.
static SCENE: LazyLock<Value> = LazyLock::new(|| {
    let text = std::fs::read(folder().join("scene.json")).unwrap();
    serde_json::from_slice(&text).unwrap()
});

fn folder() -> &'static Path {
    Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/scenarios/flashball_thigh"))
}

/// A change of one place of a document.
#[derive(Clone, Debug)]
enum Change {
    Replace(Value),
    Remove,
    Add(String, Value),
    Repeat,
}

/// Any JSON value, with numbers and words that mean something in a scene among them.
fn value() -> impl Strategy<Value = Value> {
    let number = prop_oneof![
        any::<f64>().prop_map(|x| json!(x)),
        (-4.0..12.0_f64).prop_map(|x| json!(10f64.powf(x))),
        any::<i64>().prop_map(|x| json!(x)),
        prop::sample::select(vec![json!(0), json!(-1), json!(1e308), json!(5e-324), json!(u64::MAX)]),
    ];
    let words = vec![
        "",
        "*",
        "ball",
        "mesh",
        "all",
        "bone",
        "../x.msh",
        "/etc/passwd",
        "\u{0}",
        "neo_hookean",
        "explicit",
    ];
    let leaf = prop_oneof![
        Just(Value::Null),
        any::<bool>().prop_map(Value::Bool),
        number,
        prop::sample::select(words).prop_map(|w| json!(w)),
        ".{0,8}".prop_map(Value::String),
    ];
    leaf.prop_recursive(3, 16, 4, |inner| {
        prop_oneof![
            prop::collection::vec(inner.clone(), 0..4).prop_map(Value::Array),
            prop::collection::vec((member(), inner), 0..4).prop_map(|m| m.into_iter().collect()),
        ]
    })
}

/// A name of a member, often one that exists.
fn member() -> impl Strategy<Value = String> {
    let known =
        vec!["kind", "law", "name", "file", "generator", "parts", "axis", "fibres", "angles_deg", "bodies"];
    prop_oneof![prop::sample::select(known).prop_map(str::to_owned), "[a-z~/]{0,6}"]
}

fn change() -> impl Strategy<Value = Change> {
    prop_oneof![
        4 => value().prop_map(Change::Replace),
        1 => Just(Change::Remove),
        1 => (member(), value()).prop_map(|(name, value)| Change::Add(name, value)),
        1 => Just(Change::Repeat),
    ]
}

/// Pointers to every value of a document.
fn places(value: &Value, here: &str, out: &mut Vec<String>) {
    out.push(here.to_owned());
    match value {
        Value::Array(items) => {
            for (i, item) in items.iter().enumerate() {
                places(item, &format!("{here}/{i}"), out);
            }
        }
        Value::Object(members) => {
            for (name, member) in members {
                let name = name.replace('~', "~0").replace('/', "~1");
                places(member, &format!("{here}/{name}"), out);
            }
        }
        _ => {}
    }
}

/// Makes a change at the place that `choice` picks.
fn apply(document: &mut Value, choice: prop::sample::Index, change: Change) {
    let mut all = Vec::new();
    places(document, "", &mut all);
    let pointer = choice.get(&all);
    match change {
        Change::Replace(value) => *document.pointer_mut(pointer).unwrap() = value,
        Change::Add(name, value) => {
            if let Some(Value::Object(members)) = document.pointer_mut(pointer) {
                members.insert(name, value);
            }
        }
        Change::Remove | Change::Repeat => {
            let Some((parent, name)) = pointer.rsplit_once('/') else { return };
            match (document.pointer_mut(parent), change) {
                (Some(Value::Object(members)), Change::Remove) => drop(members.remove(name)),
                (Some(Value::Array(items)), Change::Remove) => {
                    items.remove(name.parse::<usize>().unwrap());
                }
                (Some(Value::Array(items)), _) => items.push(items[name.parse::<usize>().unwrap()].clone()),
                _ => {}
            }
        }
    }
}

/// A failure has at least one error, and every problem says what to do.
fn check(bytes: &[u8]) -> Result<(), TestCaseError> {
    match load(bytes, &FolderSource::new(folder()), &BUDGET) {
        Ok(loaded) => {
            prop_assert!(loaded.warnings.iter().all(|p| !p.is_error()));
            for body in &loaded.scene.bodies {
                prop_assert_eq!(body.part_entry.len(), body.mesh.hexes.len());
                prop_assert!(body.axes.is_empty() || body.axes.len() == body.mesh.hexes.len());
                prop_assert!(body.mesh.nodes.iter().all(|x| x.iter().all(|c| c.is_finite())));
            }
        }
        Err(problems) => {
            prop_assert!(problems.error_count() > 0, "{problems:?}");
            for problem in &problems.0 {
                prop_assert!(!problem.message.is_empty() && !problem.remedy.is_empty(), "{problem:?}");
                prop_assert!(problem.code != "internal" && problem.code != "schema_broken", "{problem:?}");
            }
            let text = serde_json::to_string(&problems).unwrap();
            prop_assert_eq!(serde_json::from_str::<Problems>(&text).unwrap().0.len(), problems.0.len());
        }
    }
    Ok(())
}

proptest! {
    #[test]
    fn a_changed_scene_loads_or_is_refused_with_reasons(
        changes in prop::collection::vec((any::<prop::sample::Index>(), change()), 1..4),
    ) {
        let mut document = SCENE.clone();
        for (place, change) in changes {
            apply(&mut document, place, change);
        }
        check(document.to_string().as_bytes())?;
    }

    #[test]
    fn changed_bytes_load_or_are_refused_with_reasons(
        changes in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 1..6),
        length in any::<prop::sample::Index>(),
        cut in any::<bool>(),
    ) {
        let mut bytes = SCENE.to_string().into_bytes();
        for (place, byte) in changes {
            let place = place.index(bytes.len());
            bytes[place] = byte;
        }
        if cut {
            bytes.truncate(length.index(bytes.len()));
        }
        check(&bytes)?;
    }
}
