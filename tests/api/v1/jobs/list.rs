//! `GET /v1/jobs`

use crate::support::*;
use serde_json::Value;

fn ids(page: &Value) -> Vec<String> {
    page["jobs"].as_array().unwrap().iter().map(|j| j["id"].as_str().unwrap().to_owned()).collect()
}

#[test]
fn pages_give_every_job_once_newest_first() {
    let server = Server::start();
    let client = server.client();
    let mut made: Vec<String> =
        (0..7).map(|_| submit(&client, &quick()).rsplit('/').next().unwrap().to_owned()).collect();
    made.reverse();
    let mut seen = Vec::new();
    let mut address = "/v1/jobs?limit=3".to_owned();
    loop {
        let page = client.get(&address).json();
        seen.extend(ids(&page));
        let Some(cursor) = page["next_cursor"].as_str() else { break };
        address = format!("/v1/jobs?limit=3&cursor={cursor}");
        // A job that comes in between belongs before the first page.
        submit(&client, &quick());
    }
    assert_eq!(seen, made);
}

#[test]
fn states_filter() {
    let server = Server::start();
    let client = server.client();
    let (_, done) = finished(&client, &quick());
    let running = submit(&client, &endless());
    wait_for(&client, &running, "running");
    let waiting = submit(&client, &quick());
    assert_eq!(ids(&client.get("/v1/jobs?state=succeeded").json()), [done["id"].as_str().unwrap()]);
    assert_eq!(ids(&client.get("/v1/jobs?state=queued,running").json()).len(), 2);
    assert_eq!(client.get(&waiting).json()["queue_position"], 1);
    assert_eq!(ids(&client.get("/v1/jobs?state=failed").json()), Vec::<String>::new());
}

#[test]
fn bad_parameters_are_refused() {
    let server = Server::start();
    for query in [
        "state=dormant",
        "limit=0",
        "limit=201",
        "limit=-1",
        "limit=x",
        "cursor=zz%20",
        "cursor=",
        "colour=red",
        "state=a%00b",
    ] {
        problem(&server.client().get(&format!("/v1/jobs?{query}")), 400, "bad-parameter");
    }
}
