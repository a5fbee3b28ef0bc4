//! `GET /v1/jobs/{id}/plan`

use crate::support::*;
use serde_json::json;

#[test]
fn a_job_has_the_plan_of_its_scene_in_every_state() {
    let server = Server::simulating();
    let client = server.client();
    let text = include_str!("../../../../api/examples/job.request.json");
    let request: serde_json::Value = serde_json::from_str(text).unwrap();
    let expected = client.post_json("/v1/jobs/validate", &request).json()["plan"].clone();
    let job = submit(&client, &request);
    let plan = || {
        let address = client.get(&job).json()["links"]["plan"].as_str().unwrap().to_owned();
        client.get(&address).json()
    };
    assert_eq!(plan(), expected);
    wait_for(&client, &job, "succeeded");
    assert_eq!(plan(), expected);
    assert!(expected["omitted"][0]["switch"].is_string(), "{expected:#}");
    assert!(expected["expected_run_time_s"].as_f64().unwrap() > 0.0);
}

#[test]
fn what_the_scene_keeps_is_in_its_plan() {
    let server = Server::simulating();
    let text = include_str!("../../../../api/examples/job.request.json");
    let mut request: serde_json::Value = serde_json::from_str(text).unwrap();
    request["solver"] = json!({"keep": ["inactive_elements"]});
    let plan = server.client().post_json("/v1/jobs/validate", &request).json()["plan"].clone();
    assert_eq!(plan["restored"], json!(["inactive_elements"]));
    let omitted = plan["omitted"].as_array().unwrap();
    assert!(omitted.iter().all(|l| l["switch"] != "inactive_elements"), "{plan:#}");
}

#[test]
fn an_unknown_job_has_no_plan() {
    let server = Server::start();
    let address = "/v1/jobs/00000000-0000-0000-0000-000000000000/plan";
    problem(&server.client().get(address), 404, "job-not-found");
}
