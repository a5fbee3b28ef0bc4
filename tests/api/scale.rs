//! A hundred thousand jobs.

use crate::found::change;
use crate::support::*;

/// Jobs in the order of their coming: of a thousand, one failed, and of the last tenth all wait.
const MANY: &str = "
    WITH RECURSIVE numbers (i) AS (SELECT 1 UNION ALL SELECT i + 1 FROM numbers WHERE i < 100000)
    INSERT INTO jobs (id, owner, body_sha256, scene, name, content_hash, end_time_s, warnings, state, finished_at)
    SELECT printf('00000000-0000-7000-8000-%012x', i), '', '', randomblob(1000), 'job', '', 1, '[]',
           CASE WHEN i > 90000 THEN 'queued' WHEN i % 1000 = 0 THEN 'failed' ELSE 'succeeded' END,
           CASE WHEN i <= 90000 THEN strftime('%Y-%m-%dT%H:%M:%fZ', 'now') END
    FROM numbers";

#[test]
fn lists_and_counts_are_right_with_a_hundred_thousand_jobs() {
    let data = Server::start().stop();
    change(data.path(), MANY);
    let server = Server::on(data, |c| {
        c.workers = 0;
        c.max_queued = 20_000;
    });
    let client = server.client();
    let last = "/v1/jobs/00000000-0000-7000-8000-0000000186a0";
    for path in [
        "/v1/jobs?limit=50",
        "/v1/jobs?limit=50&cursor=100",
        "/v1/jobs?limit=50&state=failed",
        "/v1/jobs?limit=50&state=cancelled,running",
        "/v1/jobs?limit=200&state=queued",
        "/metrics",
        last,
    ] {
        assert_eq!(client.get(path).status, 200, "{path}");
    }
    assert_eq!(client.get(last).json()["queue_position"], 10_000);
    let page = client.get("/v1/jobs?limit=200&state=queued").json();
    let positions: Vec<u64> =
        page["jobs"].as_array().unwrap().iter().map(|job| job["queue_position"].as_u64().unwrap()).collect();
    assert_eq!(positions, (9801..=10_000).rev().collect::<Vec<_>>());
    let metrics = client.get("/metrics").text();
    for line in ["contuse_jobs{state=\"queued\"} 10000", "contuse_jobs{state=\"failed\"} 90"] {
        assert!(metrics.lines().any(|l| l == line), "{line}\n{metrics}");
    }
    submit(&client, &quick());
}
