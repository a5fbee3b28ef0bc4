//! `POST /v1/jobs/validate`

use crate::support::*;
use serde_json::json;

#[test]
fn valid_scene_is_described_and_not_kept() {
    let server = Server::start();
    let answer = server.client().post_json("/v1/jobs/validate", &quick());
    assert_eq!(answer.status, 200, "{answer:?}");
    let body = answer.json();
    assert_eq!(body["valid"], true);
    assert_eq!(body["bodies"][0]["nodes"], 8);
    assert_eq!(body["plan"]["nodes"], 8);
    assert_eq!(server.client().get("/v1/jobs").json()["jobs"], json!([]));
}

#[test]
fn invalid_scene_is_a_problem() {
    let server = Server::start();
    let body = problem(&server.client().post_json("/v1/jobs/validate", &json!({})), 422, "invalid-scene");
    assert_eq!(body["errors"].as_array().unwrap().len(), 3);
    problem(&server.client().post_text("/v1/jobs/validate", "{"), 400, "bad-json");
}
