//! `/`, `/healthz`, `/readyz`, `/metrics`, `/openapi.json`, `/docs`, `/scene.schema.json`

use crate::support::*;

#[test]
fn service_is_there_and_ready() {
    let server = Server::start();
    assert_eq!(server.client().get("/healthz").status, 200);
    assert_eq!(server.client().get("/readyz").status, 200);
    let landing = server.client().get("/");
    assert!(landing.header("content-type").unwrap().starts_with("text/html"));
    assert!(landing.text().contains("not a medical device"));
    assert!(server.client().get("/landing.css").header("content-type").unwrap().starts_with("text/css"));
}

#[test]
fn metrics_count() {
    let server = Server::start();
    finished(&server.client(), &quick());
    server.client().get("/v1/jobs/nothing");
    let answer = server.client().get("/metrics");
    assert!(answer.header("content-type").unwrap().starts_with("text/plain; version=0.0.4"));
    let text = answer.text();
    for line in [
        "contuse_queue_depth 0",
        "contuse_jobs{state=\"succeeded\"} 1",
        "contuse_jobs_ended_total{state=\"succeeded\"} 1",
        "contuse_run_seconds_count 1",
        "contuse_http_requests_total{method=\"POST\",route=\"/v1/jobs\",status=\"202\"} 1",
        "contuse_http_requests_total{method=\"GET\",route=\"/v1/jobs/{id}\",status=\"404\"} 1",
    ] {
        assert!(text.lines().any(|l| l == line), "{line:?} is not in\n{text}");
    }
}

#[test]
fn contract_is_the_committed_one() {
    let served = Server::start().client().get("/openapi.json").text();
    let committed =
        std::fs::read_to_string(concat!(env!("CARGO_MANIFEST_DIR"), "/api/openapi.json")).unwrap();
    assert!(
        served == committed,
        "api/openapi.json is not up to date: run `contuse openapi > api/openapi.json`"
    );
}

#[test]
fn docs_are_served_without_the_network() {
    let server = Server::start();
    let page = server.client().get("/docs/");
    assert_eq!(page.status, 200);
    let initializer = server.client().get("/docs/swagger-initializer.js").text();
    assert!(initializer.contains("/openapi.json"), "{initializer}");
    assert!(!page.text().contains("https://"), "{}", page.text());
    assert_eq!(server.client().get("/docs/swagger-ui-bundle.js").status, 200);
}
