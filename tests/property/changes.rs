//! Changes of JSON documents at random: values of any kind, members that are gone, added or repeated.

use proptest::prelude::*;
use serde_json::{Value, json};

/// A change of one place of a document.
#[derive(Clone, Debug)]
pub enum Change {
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

/// Changes of a document, one to three of them.
pub fn changes() -> impl Strategy<Value = Vec<(prop::sample::Index, Change)>> {
    prop::collection::vec((any::<prop::sample::Index>(), change()), 1..4)
}

/// The document with the changes made, one after the other.
pub fn changed(document: &Value, changes: Vec<(prop::sample::Index, Change)>) -> Value {
    let mut document = document.clone();
    for (place, change) in changes {
        apply(&mut document, place, change);
    }
    document
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
