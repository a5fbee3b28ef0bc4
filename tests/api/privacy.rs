//! What is deleted is gone, and what is kept says who did what.

use crate::support::client::Client;
use crate::support::*;
use contuse::service::tokens::Tokens;
use serde_json::{Value, json};
use std::path::{Path, PathBuf};

const ANNA: &str = "anna-0123456789abcdef";
const BERT: &str = "bert-0123456789abcdef";

/// Files below a folder whose bytes contain a text.
fn files_with(folder: &Path, text: &str) -> Vec<PathBuf> {
    let mut found = Vec::new();
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            found.extend(files_with(&path, text));
        } else if std::fs::read(&path).unwrap().windows(text.len()).any(|bytes| bytes == text.as_bytes()) {
            found.push(path);
        }
    }
    found
}

fn upload(client: &Client, bytes: &[u8]) -> String {
    let octets = [("Content-Type", "application/octet-stream")];
    client.send("POST", "/v1/meshes", &octets, bytes).json()["id"].as_str().unwrap().to_owned()
}

#[test]
fn nothing_of_a_deleted_job_is_left_in_any_file() {
    let server = Server::start();
    let client = server.client();
    let name = "patient-4711-left-thigh";
    let named = |mut scene: Value| {
        scene["name"] = json!(name);
        scene
    };
    // Others remain around them.
    let (kept, _) = finished(&client, &quick());
    let (job, _) = finished(&client, &named(quick()));
    let mut growing = named(endless());
    growing["grows"] = json!(true);
    let running = submit(&client, &growing);
    eventually("it has a snapshot", || client.get(&format!("{running}/recording")).status == 200);
    finished_after(&client, &running);
    assert!(!files_with(server.data.path(), name).is_empty());
    for job in [&job, &running] {
        assert_eq!(client.delete(job).status, 204);
    }
    eventually("its files go", || files_with(server.data.path(), name).is_empty());
    assert_eq!(client.get(&kept).status, 200);
    assert_eq!(server.files().len(), 1, "{:?}", server.files());
}

/// Stops a running job, which keeps its recording.
fn finished_after(client: &Client, job: &str) {
    client.post(&format!("{job}/cancel"));
    wait_for(client, job, "cancelled");
}

#[test]
fn a_mesh_is_listed_and_deleted() {
    let lines = format!("anna {ANNA}\nbert {BERT}");
    let server = Server::with(|c| {
        c.tokens = Tokens::parse(&lines).unwrap();
        c.workers = 0;
    });
    let (anna, bert) = (server.client().with_token(ANNA), server.client().with_token(BERT));
    let mut ids: Vec<String> = (0..3).map(|i| upload(&anna, format!("$mesh {i}").as_bytes())).collect();
    assert_eq!(upload(&bert, b"$mesh 0"), ids[0]);
    let shared = ids[0].clone();
    ids.sort();
    let page = anna.get("/v1/meshes?limit=2").json();
    let cursor = page["next_cursor"].as_str().unwrap();
    let rest = anna.get(&format!("/v1/meshes?limit=2&cursor={cursor}")).json();
    let of = |page: &Value| -> Vec<String> {
        page["meshes"].as_array().unwrap().iter().map(|m| m["id"].as_str().unwrap().into()).collect()
    };
    assert_eq!([of(&page), of(&rest)].concat(), ids);
    assert_eq!(rest["next_cursor"], json!(null));
    assert_eq!(of(&bert.get("/v1/meshes").json()), std::slice::from_ref(&shared));

    let address = format!("/v1/meshes/{shared}");
    assert_eq!(anna.delete(&address).status, 204);
    problem(&anna.get(&address), 404, "mesh-not-found");
    problem(&anna.delete(&address), 404, "mesh-not-found");
    assert_eq!((bert.get(&address).status, server.files().len()), (200, 3), "bert has it, too");
    // A waiting job needs its mesh.
    let mut scene = quick();
    scene["mesh"] = json!(shared);
    let job = submit(&bert, &scene);
    let refused = problem(&bert.delete(&address), 409, "mesh-in-use");
    assert!(refused["detail"].as_str().unwrap().contains(job.rsplit('/').next().unwrap()));
    bert.post(&format!("{job}/cancel"));
    assert_eq!((bert.delete(&address).status, server.files().len()), (204, 2));
}

#[test]
fn what_is_too_old_is_purged() {
    let server = Server::with(|c| c.workers = 1);
    let client = server.client();
    finished(&client, &quick());
    upload(&client, b"$mesh");
    let data = server.stop();
    let again = Server::on(data, |c| {
        c.keep_days = Some(1);
        c.workers = 0;
    });
    std::thread::sleep(std::time::Duration::from_millis(300));
    assert_eq!(
        again.client().get("/v1/jobs").json()["jobs"].as_array().unwrap().len(),
        1,
        "not yet a day old"
    );
    let waiting = submit(&again.client(), &quick());
    let last = Server::on(again.stop(), |c| {
        c.keep_days = Some(0);
        c.workers = 0;
    });
    eventually("they are purged", || last.files().is_empty());
    let jobs = last.client().get("/v1/jobs").json()["jobs"].clone();
    assert_eq!(jobs.as_array().unwrap().len(), 1, "the one that waits stays");
    assert_eq!(jobs[0]["links"]["self"], json!(waiting));
}

#[test]
fn the_audit_log_says_who_did_what() {
    let server = Server::with(|c| c.tokens = Tokens::parse(&format!("anna {ANNA}")).unwrap());
    let anna = server.client().with_token(ANNA);
    let mut scene = quick();
    scene["name"] = json!("patient-4711");
    let (job, _) = finished(&anna, &scene);
    anna.get(&format!("{job}/summary"));
    // A flood of strangers, with and without tokens.
    for _ in 0..100 {
        server.client().get(&job);
        server.client().with_token("wrong-0123456789abcdef").post(&format!("{job}/cancel"));
    }
    anna.delete(&job);
    let data = server.stop();
    let text = std::fs::read_to_string(data.path().join("audit.jsonl")).unwrap();
    assert!(!text.contains("patient-4711"));
    let lines: Vec<Value> = text.lines().map(|line| serde_json::from_str(line).unwrap()).collect();
    assert_eq!(
        (&lines[0]["method"], &lines[0]["created"], &lines[0]["status"]),
        (&json!("POST"), &json!(job), &json!(202))
    );
    assert!(lines[0]["at"].is_string() && lines[0]["address"] == "127.0.0.1");
    let of = |method: &str, path: &str| -> Vec<&Value> {
        lines.iter().filter(|line| line["method"] == method && line["path"] == path).collect()
    };
    assert_eq!(of("GET", &format!("{job}/summary"))[0]["owner"], "anna");
    // Its state was read again and again until it ended, which says nothing.
    assert!(of("GET", &job).is_empty());
    assert_eq!(of("DELETE", &job)[0]["status"], 204);
    // The strangers are counted: those without a right token, and those who had to wait.
    let counts: Vec<&Value> = lines.iter().filter(|line| line["refused"].is_u64()).collect();
    let statuses: Vec<&Value> = counts.iter().map(|line| &line["status"]).collect();
    assert!(statuses == [401, 429], "{counts:?}");
    assert_eq!(counts.iter().map(|line| line["refused"].as_u64().unwrap()).sum::<u64>(), 200);
    assert!(counts.iter().all(|line| line["owner"].is_null() && line["network"] == "127.0.0.0/24"));
    assert_eq!(lines.len(), 3 + counts.len());
}

#[test]
fn the_audit_log_has_acts_whose_client_did_not_wait_for_the_answer() {
    let server = Server::with(|c| {
        c.workers = 0;
        c.tokens = Tokens::parse(&format!("anna {ANNA}")).unwrap();
    });
    let anna = server.client().with_token(ANNA);
    let jobs: Vec<String> = (0..20).map(|_| submit(&anna, &quick())).collect();
    for job in &jobs {
        let head =
            format!("DELETE {job} HTTP/1.1\r\nHost: localhost\r\nAuthorization: Bearer {ANNA}\r\n\r\n");
        let hung_up = anna.raw(head.as_bytes());
        std::thread::sleep(std::time::Duration::from_millis(1));
        drop(hung_up);
    }
    let is_gone = |job: &String| anna.get(job).status != 200;
    std::thread::sleep(std::time::Duration::from_millis(500));
    let gone: Vec<&String> = jobs.iter().filter(|job| is_gone(job)).collect();
    assert!(!gone.is_empty(), "some requests had arrived");
    let data = server.stop();
    let text = std::fs::read_to_string(data.path().join("audit.jsonl")).unwrap();
    let lines: Vec<Value> = text.lines().map(|line| serde_json::from_str(line).unwrap()).collect();
    for job in gone {
        let of_job = |line: &&Value| line["method"] == "DELETE" && line["path"] == json!(job);
        let line = lines.iter().find(of_job).unwrap_or_else(|| panic!("{job} is gone without a line"));
        assert!([204, 499].iter().any(|status| line["status"] == *status), "{line}");
        assert_eq!(line["owner"], "anna");
    }
}
