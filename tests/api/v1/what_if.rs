//! `POST /v1/what-if`

use crate::support::*;
use serde_json::{Value, json};
use std::collections::BTreeSet;

/// A soft block that hits a wall: a few milliseconds a run.
fn scene() -> Value {
    json!({
        "name": "block", "end_time_s": 4e-4,
        "bodies": [{
            "name": "block", "role": "projectile", "velocity_m_per_s": [0, 0, -10],
            "mesh": {"generator": {"kind": "block", "min_m": [0, 0, 0.0001], "max_m": [0.01, 0.01, 0.0101], "elements": [2, 2, 2]}},
            "parts": [{"part": "block", "density_kg_per_m3": 1000,
                       "material": {"law": "neo_hookean", "c10_pa": 1e5, "bulk_modulus_pa": 1e6}}]
        }],
        "planes": [{"name": "wall", "point_m": [0, 0, 0], "normal": [0, 0, 1]}],
        "record": {"fields": []}
    })
}

fn question() -> Value {
    json!({
        "scene": scene(),
        "parameters": [
            {"name": "speed", "change": {"kind": "speed_m_per_s"}, "low": 8, "high": 12},
            {"name": "mass", "change": {"kind": "mass_kg"}, "low": 0.9e-3, "high": 1.1e-3}
        ],
        "one_at_a_time": true,
        "sample": {"count": 4, "seed": 1},
        "limits": [{"parameter": "speed", "measure": {"quantity": "impulse_n_s"}, "at_most": 0.01, "tolerance": 0.05}]
    })
}

#[test]
fn cases_are_events_and_the_answer_is_the_summary() {
    let server = Server::simulating();
    let client = server.client();
    let answer = client.post_json("/v1/what-if", &question());
    assert_eq!(answer.status, 202, "{}", answer.text());
    let job = answer.json();
    assert_eq!(job["name"], "what if: block");
    let address = job["links"]["self"].as_str().unwrap().to_owned();
    let events: Vec<_> = client.follow(&format!("{address}/events"), None).collect();
    let cases: Vec<Value> = events.iter().filter(|e| e.kind == "case").map(|e| e.data.clone()).collect();
    let indices: Vec<u64> = cases.iter().map(|case| case["index"].as_u64().unwrap()).collect();
    assert_eq!(indices, (0..9).collect::<Vec<_>>());
    assert!(cases.iter().all(|case| case["of"] == 9 && case["ending"] == "finished"), "{cases:#?}");
    assert_eq!(events.iter().filter(|e| e.kind == "error_bars" || e.kind == "limit").count(), 2);
    wait_for(&client, &address, "succeeded");
    let whole = client.get(&format!("{address}/summary")).json();
    assert_eq!(whole["cases"].as_array().unwrap().len(), 9);
    let impulse = |case: &Value| case["numbers"]["impulse_n_s"]["value"].as_f64().unwrap();
    assert_eq!(whole["cases"][3]["numbers"], cases[3]["numbers"]);
    assert!(impulse(&whole["cases"][1]) < impulse(&whole["cases"][2]), "the impulse grows with the speed");
    assert_eq!(whole["limits"][0]["verdict"], "kept_up_to");
    assert!(
        whole["spread"].as_array().unwrap().iter().any(|s| s["quantity"] == "impulse_n_s" && s["count"] == 4)
    );
    assert_eq!(client.get(&format!("{address}/recording")).status, 404);

    // The same again is known, and says the same.
    let again = client.post_json("/v1/what-if", &question()).json();
    let address = again["links"]["self"].as_str().unwrap().to_owned();
    wait_for(&client, &address, "succeeded");
    let again = client.get(&format!("{address}/summary")).json();
    assert_eq!(again["effort"]["computed"], 0);
    assert_eq!(again["cases"], whole["cases"]);
    assert_eq!(again["limits"], whole["limits"]);
}

#[test]
fn a_job_is_a_base() {
    let server = Server::simulating();
    let client = server.client();
    let (job, _) = finished(&client, &scene());
    let id = job.rsplit('/').next().unwrap();
    let mut requested = question();
    requested.as_object_mut().unwrap().remove("scene");
    requested["job"] = json!(id);
    let headers = [("content-type", "application/json"), ("idempotency-key", "what-if-1")];
    let body = requested.to_string();
    let first = client.send("POST", "/v1/what-if", &headers, body.as_bytes());
    assert_eq!(first.status, 202, "{}", first.text());
    // The question does not need the job any more.
    assert_eq!(client.delete(&job).status, 204);
    let replay = client.send("POST", "/v1/what-if", &headers, body.as_bytes());
    assert_eq!((replay.status, replay.header("idempotent-replayed")), (202, Some("true")));
    assert_eq!(replay.json()["id"], first.json()["id"]);
    let address = first.json()["links"]["self"].as_str().unwrap().to_owned();
    wait_for(&client, &address, "succeeded");
    let answer = problem(&client.post_json("/v1/what-if", &requested), 422, "invalid-scene");
    assert_eq!(answer["errors"][0]["pointer"], "/job");
}

#[test]
fn every_problem_of_a_question_has_its_place() {
    let server = Server::simulating();
    let client = server.client();
    let places = |body: &Value| -> Vec<String> {
        let answer = problem(&client.post_json("/v1/what-if", body), 422, "invalid-scene");
        let errors = answer["errors"].as_array().unwrap();
        errors.iter().map(|e| e["pointer"].as_str().unwrap().to_owned()).collect()
    };
    let mut wrong = question();
    wrong["parameters"][0]["change"]["body"] = json!("blok");
    wrong["limits"][0]["parameter"] = json!("weight");
    wrong["sample"]["count"] = json!(1);
    assert_eq!(places(&wrong), ["/parameters/0/change/body", "/sample/count", "/limits/0/parameter"]);
    let mut wrong = question();
    wrong["scene"]["end_time_s"] = json!(-1);
    assert!(places(&wrong).contains(&"/scene/end_time_s".to_owned()));
    let mut without = question();
    without.as_object_mut().unwrap().remove("scene");
    assert_eq!(places(&without), [""]);
    let mut twice = question();
    twice["job"] = json!("x");
    assert_eq!(places(&twice), ["/job"]);
    // A question is no scene.
    assert_eq!(client.post_json("/v1/jobs", &question()).status, 422);
}

#[test]
fn what_has_no_scene_is_no_base_and_has_no_plan() {
    let server = Server::simulating();
    let client = server.client();
    let study = client.post_json("/v1/studies", &json!({"kind": "error", "scene": scene()})).json();
    let requested = client.post_json("/v1/what-if", &question()).json();
    for (job, purpose) in [(study, "is a study"), (requested, "answers a what-if question")] {
        let mut of_it = question();
        of_it.as_object_mut().unwrap().remove("scene");
        of_it["job"] = job["id"].clone();
        let answer = problem(&client.post_json("/v1/what-if", &of_it), 422, "invalid-scene");
        assert_eq!(answer["detail"], "The question has 1 error(s); every one is listed with its place.");
        let errors = answer["errors"].as_array().unwrap();
        assert_eq!(
            (errors.len(), &errors[0]["code"], &errors[0]["pointer"]),
            (1, &json!("no_base"), &json!("/job"))
        );
        assert_eq!(errors[0]["value"], job["id"]);
        assert!(errors[0]["message"].as_str().unwrap().contains(purpose), "{answer}");
        let address = job["links"]["self"].as_str().unwrap();
        let answer = problem(&client.get(&format!("{address}/plan")), 404, "no-plan");
        assert!(answer["detail"].as_str().unwrap().contains(purpose), "{answer}");
    }
}

#[test]
fn keys_written_twice_are_refused() {
    let server = Server::simulating();
    let client = server.client();
    let places = |address: &str, body: &str| -> BTreeSet<String> {
        let answer = problem(&client.post_text(address, body), 422, "invalid-scene");
        let errors = answer["errors"].as_array().unwrap();
        assert!(errors.iter().all(|e| e["code"] == "repeated_key"), "{answer}");
        errors.iter().map(|e| e["pointer"].as_str().unwrap().to_owned()).collect()
    };
    let set = |places: &[&str]| places.iter().map(|place| (*place).to_owned()).collect::<BTreeSet<_>>();
    let text = question().to_string();
    let text = text.replacen("\"sample\":", "\"sample\":null,\"sample\":", 1);
    let text = text.replacen("\"end_time_s\":", "\"end_time_s\":1,\"end_time_s\":", 1);
    assert_eq!(places("/v1/what-if", &text), set(&["/sample", "/scene/end_time_s"]));

    let job = client.post_json("/v1/jobs", &scene()).json()["id"].clone();
    let mut of_job = question();
    of_job.as_object_mut().unwrap().remove("scene");
    of_job["job"] = job;
    let text = of_job.to_string().replacen("\"job\":", "\"job\":\"x\",\"job\":", 1);
    assert_eq!(places("/v1/what-if", &text), set(&["/job"]));

    let study = json!({"kind": "error", "scene": scene(), "geometry": false}).to_string();
    let study = study.replacen("\"geometry\":", "\"geometry\":true,\"geometry\":", 1);
    let study = study.replacen("\"planes\":", "\"planes\":[],\"planes\":", 1);
    assert_eq!(places("/v1/studies", &study), set(&["/geometry", "/scene/planes"]));
}

#[test]
fn what_is_no_question_is_reported_in_terms_of_json() {
    let server = Server::simulating();
    let mut unknown = question();
    unknown["caes"] = json!([]);
    for (body, place, limit) in [
        (json!([]), "", "an object"),
        (json!({}), "/parameters", "present"),
        (json!({"parameters": "x"}), "/parameters", "a list"),
        (unknown, "/caes", "one of scene, job, parameters"),
    ] {
        let answer = problem(&server.client().post_json("/v1/what-if", &body), 422, "invalid-scene");
        let error = &answer["errors"][0];
        assert_eq!(error["pointer"], place, "{answer}");
        assert!(error["limit"].as_str().unwrap().starts_with(limit), "{answer}");
        assert!(error["remedy"] != "" && !answer.to_string().contains("struct "), "{answer}");
    }
}

#[test]
fn results_go_with_the_last_job_that_uses_them() {
    let server = Server::simulating();
    let client = server.client();
    let ask = || {
        let answer = client.post_json("/v1/what-if", &question()).json();
        let address = answer["links"]["self"].as_str().unwrap().to_owned();
        wait_for(&client, &address, "succeeded");
        address
    };
    let (first, second) = (ask(), ask());
    let results = || {
        let is_result =
            |path: &std::path::PathBuf| path.components().any(|part| part.as_os_str() == "results");
        server.files().into_iter().filter(is_result).count()
    };
    let count = results();
    assert!(count >= 9, "{count}");
    assert_eq!(client.delete(&first).status, 204);
    assert_eq!(results(), count, "the second question uses all of them");
    assert_eq!(client.delete(&second).status, 204);
    assert_eq!(results(), 0);
    // Nor in memory: all is computed again.
    let again = client.get(&format!("{}/summary", ask())).json();
    assert!(again["effort"]["computed"].as_u64().unwrap() >= 9, "{}", again["effort"]);
}
