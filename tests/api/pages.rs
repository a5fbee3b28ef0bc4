//! `/`, `/healthz`, `/readyz`, `/metrics`, `/openapi.json`, `/docs`, `/scene.schema.json`

use crate::support::*;

#[test]
fn service_is_there_and_ready() {
    let server = Server::start();
    assert_eq!(server.client().get("/healthz").status, 200);
    assert_eq!(server.client().get("/readyz").status, 200);
}

#[test]
fn viewer_is_served_whole_and_strict() {
    let server = Server::start();
    let page = server.client().get("/");
    assert!(page.header("content-type").unwrap().starts_with("text/html"));
    assert!(page.text().contains("not a medical device"));
    // Questions of the page have keys with the build: another build answers them anew.
    let text = page.text();
    let (_, named) = text.split_once("<html data-build=\"").unwrap();
    let (name, _) = named.split_once('"').unwrap();
    assert!(name.len() == 16 && name.bytes().all(|byte| byte.is_ascii_hexdigit()), "{name}");
    let policy = page.header("content-security-policy").unwrap().to_owned();
    assert!(policy.starts_with("default-src 'none';") && !policy.contains("unsafe"), "{policy}");
    for (path, media_type) in [
        ("app.js", "text/javascript"),
        ("style.css", "text/css"),
        ("vendor/fzstd/index.mjs", "text/javascript"),
    ] {
        let file = server.client().get(&format!("/viewer/{path}"));
        assert_eq!(file.status, 200, "{path}");
        assert!(file.header("content-type").unwrap().starts_with(media_type), "{path}");
        let etag = file.header("etag").unwrap().to_owned();
        let again = server.client().get_with(&format!("/viewer/{path}"), &[("If-None-Match", &etag)]);
        assert_eq!(again.status, 304);
    }
    assert_eq!(server.client().get("/viewer/none.js").status, 404);
    assert_eq!(server.client().get("/viewer/..%2F..%2FCargo.toml").status, 404);
}

/// The text in a gzip file of one member without a name.
fn ungzipped(file: &[u8]) -> Vec<u8> {
    assert_eq!(file[..4], [0x1f, 0x8b, 8, 0], "the head of a gzip file without extras");
    miniz_oxide::inflate::decompress_to_vec(&file[10..file.len() - 8]).unwrap()
}

#[test]
fn texts_are_compressed_for_who_accepts_it_and_nothing_else_is() {
    let server = Server::start();
    let client = server.client();
    let (job, _) = finished(&client, &quick());
    let gzip = [("Accept-Encoding", "gzip, br")];
    for path in ["/", "/viewer/app.js", "/viewer/style.css", "/openapi.json", "/scene.schema.json"] {
        let (plain, packed) = (client.get(path), client.get_with(path, &gzip));
        assert_eq!(plain.header("content-encoding"), None, "{path}");
        assert_eq!(packed.header("content-encoding"), Some("gzip"), "{path}");
        assert_eq!(packed.header("vary"), Some("accept-encoding"), "{path}");
        assert_eq!(ungzipped(&packed.body), plain.body, "{path}");
        assert!(2 * packed.body.len() < plain.body.len(), "{path}");
    }
    // Read by ranges; short.
    for path in [format!("{job}/recording"), "/healthz".to_owned()] {
        assert_eq!(client.get_with(&path, &gzip).header("content-encoding"), None, "{path}");
    }
}

#[test]
fn presets_are_scenes_that_may_run() {
    let server = Server::start();
    let presets: serde_json::Value =
        serde_json::from_str(&server.client().get("/viewer/presets.json").text()).unwrap();
    let presets = presets.as_array().unwrap();
    assert!(presets.iter().any(|p| p["file"] == "flashball_thigh/scene.json"), "{presets:?}");
    assert!(presets.iter().all(|p| p["scene"]["name"].is_string()));
}

#[test]
fn metrics_count() {
    let server = Server::start();
    finished(&server.client(), &quick());
    server.client().get("/v1/jobs/nothing");
    let answer = server.client().get("/metrics");
    assert!(
        answer.header("content-type").unwrap().starts_with("application/openmetrics-text; version=1.0.0")
    );
    let text = answer.text();
    for line in [
        "contuse_queue_depth 0",
        "contuse_queue_age_seconds 0.0",
        "contuse_processes 0",
        "contuse_running_memory_bytes 0",
        "contuse_store_errors_total{store=\"jobs\"} 0",
        "contuse_store_errors_total{store=\"blobs\"} 0",
        "contuse_blobs_answer 1",
        "contuse_jobs{state=\"succeeded\"} 1",
        "contuse_jobs_ended_total{state=\"succeeded\"} 1",
        "contuse_run_seconds_count 1",
        "contuse_http_requests_total{method=\"POST\",route=\"/v1/jobs\",status=\"202\"} 1",
        "contuse_http_requests_total{method=\"GET\",route=\"/v1/jobs/{id}\",status=\"404\"} 1",
    ] {
        assert!(text.lines().any(|l| l == line), "{line:?} is not in\n{text}");
    }
    let of = |name: &str| value_of(&text, name);
    assert!(of("contuse_resident_memory_bytes ") > 1e6 && of("contuse_free_disk_bytes ") > 1e6, "{text}");
}

/// Value of a metric that has no labels; `name` with the blank after it.
fn value_of(text: &str, name: &str) -> f64 {
    let line = text.lines().find_map(|line| line.strip_prefix(name)).unwrap();
    line.trim().parse().unwrap()
}

#[test]
fn metrics_say_how_long_jobs_wait_and_what_runs() {
    let server = Server::with(|c| c.workers = 1);
    let client = server.client();
    let running = submit(&client, &endless());
    wait_for(&client, &running, "running");
    submit(&client, &quick());
    std::thread::sleep(std::time::Duration::from_millis(300));
    let text = client.get("/metrics").text();
    let of = |name: &str| value_of(&text, name);
    assert!(text.lines().any(|line| line == "contuse_queue_depth 1"), "{text}");
    assert!((0.25..60.0).contains(&of("contuse_queue_age_seconds ")), "{text}");
    assert!(of("contuse_running_memory_bytes ") >= f64::from(256 << 20), "{text}");
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
    let redirect = server.client().get("/docs");
    assert_eq!((redirect.status, redirect.header("location")), (303, Some("docs/")));
    let page = server.client().get("/docs/");
    assert_eq!(page.status, 200);
    assert!(page.header("content-type").unwrap().starts_with("text/html"));
    assert!(page.header("content-security-policy").unwrap().starts_with("default-src 'none';"));
    assert!(page.text().contains("../openapi.json") && !page.text().contains("https://"), "{}", page.text());
    for path in ["docs.js", "docs.css", "dom.js", "style.css"] {
        assert!(path == "dom.js" || page.text().contains(&format!("../viewer/{path}")), "{path}");
        assert_eq!(server.client().get(&format!("/viewer/{path}")).status, 200, "{path}");
    }
    assert!(server.client().get("/viewer/docs.js").text().contains("../openapi.json"));
}
