//! `GET /v1/jobs/{id}`

use crate::support::*;
use serde_json::json;

#[test]
fn finished_job_says_what_it_did() {
    let server = Server::start();
    let (_, job) = finished(&server.client(), &quick());
    assert_eq!(job["phase"], "done");
    assert_eq!(job["progress"], 1.0);
    assert_eq!(job["step"], 3);
    assert_eq!(job["simulated_time_s"], 1e-3);
    assert_eq!(job["attempts"], 1);
    assert_eq!(job["failure"], json!(null));
    assert_eq!(job["recording"]["bytes"], 1000);
    assert_eq!(job["recording"]["complete"], true);
    assert!(job["created_at"].as_str().unwrap() <= job["finished_at"].as_str().unwrap());
}

#[test]
fn running_job_says_how_far_it_is() {
    let server = Server::start();
    let client = server.client();
    let job = submit(&client, &json!({ "name": "slow", "end_time_s": 1.0, "steps": 5000, "step_ms": 1 }));
    eventually("progress", || client.get(&job).json()["step"].as_u64().unwrap() > 100);
    let now = client.get(&job).json();
    assert_eq!((&now["state"], &now["phase"]), (&json!("running"), &json!("stepping")));
    let progress = now["progress"].as_f64().unwrap();
    assert!(progress > 0.0 && progress < 1.0);
    assert!(now["eta_s"].as_f64().unwrap() > 0.0);
    assert_eq!(now["expected_steps"], 5000);
}

#[test]
fn failed_job_has_a_diagnosis_and_its_recording() {
    let server = Server::start();
    let client = server.client();
    let mut scene = quick();
    scene["ending"] = json!("failed");
    let job = submit(&client, &scene);
    let end = wait_for(&client, &job, "failed");
    assert_eq!(end["failure"]["cause"], "element_inverted");
    assert_eq!(end["failure"]["step"], 7);
    assert_eq!(end["recording"]["complete"], false);
    assert_eq!(client.get(&format!("{job}/recording")).status, 200);
    assert_eq!(client.get(&format!("{job}/summary")).status, 200);
}

#[test]
fn panicking_run_fails_alone() {
    let server = Server::start();
    let client = server.client();
    let mut scene = quick();
    scene["ending"] = json!("panic");
    let job = submit(&client, &scene);
    let end = wait_for(&client, &job, "failed");
    assert_eq!(end["failure"]["cause"], "panicked");
    assert!(!end.to_string().contains("secret"), "{end}");
    // What it left of a recording was mended.
    assert!(client.get(&format!("{job}/recording")).body.ends_with(b"mended"));
    finished(&client, &quick());
}

#[test]
fn run_that_cannot_begin_fails() {
    let server = Server::start();
    let mut scene = quick();
    scene["ending"] = json!("refused");
    let job = submit(&server.client(), &scene);
    assert_eq!(wait_for(&server.client(), &job, "failed")["failure"]["cause"], "invalid_scene");
}

#[test]
fn deadline_ends_a_job() {
    let server = Server::with(|c| c.runs.deadline = std::time::Duration::from_millis(100));
    let job = submit(&server.client(), &endless());
    assert_eq!(wait_for(&server.client(), &job, "failed")["failure"]["cause"], "deadline");
}

#[test]
fn unknown_jobs_are_not_found() {
    let server = Server::start();
    let (job, _) = finished(&server.client(), &quick());
    let id = job.rsplit('/').next().unwrap();
    for other in [
        "00000000-0000-0000-0000-000000000000",
        "1",
        "..%2f..%2fetc%2fpasswd",
        "%ff",
        &id.to_uppercase(),
        &id.replace('-', ""),
    ] {
        problem(&server.client().get(&format!("/v1/jobs/{other}")), 404, "job-not-found");
        problem(&server.client().get(&format!("/v1/jobs/{other}/recording")), 404, "job-not-found");
    }
    problem(&server.client().get("/v1/jobs/"), 404, "not-found");
    problem(&server.client().get(&format!("{job}/")), 404, "not-found");
}
