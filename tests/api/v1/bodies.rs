//! Whatever is sent, the answer is one of the contract's: never a fault of the service.

use crate::changes::{changed, changes};
use crate::support::*;
use proptest::prelude::*;
use serde_json::{Value, json};
use std::sync::LazyLock;

static SERVER: LazyLock<Server> = LazyLock::new(Server::simulating);

/// A document that cannot run, however it is changed: nothing is computed for it.
fn refused_study() -> Value {
    json!({"kind": "error", "finest": 3, "formulations": ["reduced"], "implicit_steps_s": [1e-3], "exact": {"impulse_n_s": 0.2},
           "scene": {"name": "bar", "end_time_s": 1, "bodies": [], "record": {"fields": []}}})
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn a_changed_study_is_refused_with_its_places(changes in changes()) {
        let mut study = changed(&refused_study(), changes);
        if let Value::Object(members) = &mut study && members.contains_key("finest") {
            members.insert("finest".into(), json!(9));
        }
        // The matrix of stability needs no scene, and would be accepted.
        prop_assume!(study["kind"] != "stability");
        let answer = SERVER.client().post_json("/v1/studies", &study);
        prop_assert!([400, 422].contains(&answer.status), "{} to {study}", answer.status);
        let places = answer.json()["errors"].as_array().is_some_and(|errors| !errors.is_empty());
        prop_assert!(answer.status == 400 || places, "{study}");
    }

    #[test]
    fn changed_bytes_are_no_fault_of_the_service(
        at in any::<prop::sample::Index>(), byte in any::<u8>(), end in any::<prop::sample::Index>(), cut in any::<bool>(),
    ) {
        let mut bytes = refused_study().to_string().into_bytes();
        let at = at.index(bytes.len());
        bytes[at] = byte;
        if cut {
            bytes.truncate(end.index(bytes.len()));
        }
        for (address, media) in [
            ("/v1/studies", "application/json"),
            ("/v1/jobs/validate", "application/json"),
            ("/v1/meshes?format=gmsh", "application/octet-stream"),
        ] {
            let answer = SERVER.client().send("POST", address, &[("content-type", media)], &bytes);
            prop_assert!((400..500).contains(&answer.status), "{} from {address}", answer.status);
        }
    }
}

/// Members of an object, each with the value 1.
fn members(count: usize, name: impl Fn(usize) -> String) -> String {
    (0..count).map(|i| format!("\"{}\":1", name(i))).collect::<Vec<_>>().join(",")
}

#[test]
fn a_list_of_errors_ends_and_says_how_many_more_there_are() {
    let many = 300_000;
    let distinct = members(many, |i| format!("k{i}"));
    let repeated = members(many, |_| "k".into());
    for (address, body, least) in [
        ("/v1/studies", format!("{{\"kind\":\"error\",\"scene\":{{}},\"exact\":{{{distinct}}}}}"), many),
        ("/v1/jobs/validate", format!("{{{distinct}}}"), many),
        ("/v1/jobs", format!("{{{repeated}}}"), many - 1),
    ] {
        let answer = SERVER.client().post_text(address, &body);
        let refused = problem(&answer, 422, "invalid-scene");
        assert!(answer.body.len() < 300_000, "{} bytes from {address}", answer.body.len());
        let errors = refused["errors"].as_array().unwrap();
        assert!(errors.len() <= 101, "{} errors from {address}", errors.len());
        let last = errors.last().unwrap();
        assert_eq!(last["code"], "too_many_problems", "{address}");
        let omitted = last["value"].as_u64().unwrap();
        assert!(omitted >= least as u64 - 100, "{omitted} from {address}");
        assert!(refused["detail"].as_str().unwrap().contains(&omitted.to_string()), "{}", refused["detail"]);
    }
}

#[test]
fn names_as_long_as_the_document_do_not_lengthen_the_answer() {
    let name = "n".repeat(1_000_000);
    let inner = members(2000, |_| "k".into());
    for body in [format!("{{\"{name}\":{{{inner}}}}}"), format!("{{\"end_time_s\":\"{name}\"}}")] {
        let answer = SERVER.client().post_text("/v1/jobs/validate", &body);
        problem(&answer, 422, "invalid-scene");
        assert!(answer.body.len() < 600_000, "{} bytes", answer.body.len());
    }
}
