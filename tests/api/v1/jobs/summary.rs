//! `GET /v1/jobs/{id}/summary`

use crate::support::*;
use serde_json::json;

#[test]
fn summary_is_what_the_engine_said() {
    let server = Server::start();
    let (job, _) = finished(&server.client(), &quick());
    let answer = server.client().get(&format!("{job}/summary"));
    assert_eq!(answer.header("content-type"), Some("application/json"));
    assert!(answer.header("contuse-notice").unwrap().contains("not a diagnosis"));
    assert_eq!(answer.json(), json!({ "peak_force_n": 42.0, "steps": 3 }));
}

#[test]
fn no_summary_before_the_end() {
    let server = Server::start();
    let job = submit(&server.client(), &endless());
    problem(&server.client().get(&format!("{job}/summary")), 409, "not-yet");
}

#[test]
fn run_that_never_began_left_none() {
    let server = Server::start();
    let mut scene = quick();
    scene["ending"] = json!("refused");
    let job = submit(&server.client(), &scene);
    wait_for(&server.client(), &job, "failed");
    problem(&server.client().get(&format!("{job}/summary")), 404, "not-left");
}

#[test]
fn what_is_handed_out_of_a_job() {
    let server = Server::simulating();
    let client = server.client();
    let request: serde_json::Value =
        serde_json::from_str(include_str!("../../../../api/examples/job.request.json")).unwrap();
    let (job, end) = finished(&client, &request);
    let report = client.get(&format!("{job}/report"));
    assert_eq!((report.status, report.header("content-type")), (200, Some("text/html; charset=utf-8")));
    assert!(report.text().contains("Peak force") && report.text().contains("<svg"));
    let bundle = client.get(&format!("{job}/fhir"));
    assert_eq!((bundle.status, bundle.header("content-type")), (200, Some("application/fhir+json")));
    assert_eq!(bundle.json()["timestamp"], end["finished_at"]);
    let table = client.get(&format!("{job}/export.csv")).text();
    assert!(table.starts_with("# ") && table.contains("\ntime [s],"), "{table}");
    for what in ["stl", "ply"] {
        let surfaces = client.get(&format!("{job}/export.{what}"));
        let kind = format!("model/{what}");
        assert_eq!((surfaces.status, surfaces.header("content-type")), (200, Some(kind.as_str())));
        if what == "stl" {
            let count = u32::from_le_bytes(surfaces.body[80..84].try_into().unwrap());
            assert_eq!(surfaces.body.len(), 84 + 50 * count as usize);
        } else {
            assert!(surfaces.body.starts_with(b"ply\n"));
        }
        let first = client.get(&format!("{job}/export.{what}?time_s=0"));
        assert_eq!(first.status, 200);
        assert_ne!(first.body, surfaces.body, "the first time is not the last one");
        let late = problem(&client.get(&format!("{job}/export.{what}?time_s=1e3")), 400, "bad-parameter");
        assert!(late["detail"].as_str().unwrap().contains("from 0 s"), "{late}");
    }
    let archive = client.get(&format!("{job}/export.vtu.tar"));
    assert_eq!((archive.status, archive.header("content-type")), (200, Some("application/x-tar")));
    // The name of its first file, and the list, which is the last one before two empty blocks.
    assert!(archive.body.len().is_multiple_of(512) && archive.body[..100].ends_with(&[0]));
    assert!(archive.body.windows(28).any(|text| text == b"<VTKFile type=\"Collection\" v"));
    assert!(archive.body[archive.body.len() - 1024..].iter().all(|&byte| byte == 0));
}
