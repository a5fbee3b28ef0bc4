//! The whole line, with the real program and the real engine: from a scene by HTTP to a recording that other programs read.

use crate::support::client::Client;
use crate::support::program::{Program, SERVE};
use crate::support::*;
use contuse::blobs::hexadecimal;
use mcap::{MessageStream, Summary};
use serde_json::{Value, json};
use sha2::{Digest, Sha256};
use std::io::{BufRead, BufReader};
use std::path::Path;
use std::process::{Command, Stdio};
use tempfile::TempDir;

fn example(name: &str) -> Value {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("api/examples").join(name);
    serde_json::from_str(&std::fs::read_to_string(path).unwrap()).unwrap()
}

/// The example with so small a step that it runs for a second or more.
fn slow() -> Value {
    let mut scene = example("job.request.json");
    scene["integrator"] = json!({ "kind": "explicit", "max_step_s": 2e-8 });
    scene["record"] = json!({ "field_interval_s": 1e-6, "every_steps": 100 });
    scene
}

/// A job that does not end while a test looks at it, on any machine: a hundred thousand steps, fields early on.
fn lasting() -> Value {
    let mut scene = example("job.request.json");
    scene["integrator"] = json!({ "kind": "explicit", "max_step_s": 1e-9 });
    scene["record"] = json!({ "field_interval_s": 1e-7, "every_steps": 1000 });
    // Its error bars would take as long before it begins.
    scene["solver"] = json!({ "error_bars": "none" });
    scene
}

fn data() -> TempDir {
    tempfile::tempdir().unwrap()
}

/// Downloads a recording in parts that belong to one file.
fn download(client: &Client, address: &str, part: usize) -> Vec<u8> {
    let head = client.send("HEAD", address, &[], b"");
    let (length, etag) =
        (head.header("content-length").unwrap().parse().unwrap(), head.header("etag").unwrap());
    let mut bytes: Vec<u8> = Vec::new();
    while bytes.len() < length {
        let range = format!("bytes={}-{}", bytes.len(), bytes.len() + part - 1);
        let answer = client.get_with(address, &[("Range", &range), ("If-Range", etag)]);
        assert_eq!(answer.status, 206, "{:?}", answer.headers);
        bytes.extend(answer.body);
    }
    bytes
}

/// The attachment of a recording.
fn attachment(bytes: &[u8], name: &str) -> Vec<u8> {
    let summary = Summary::read(bytes).unwrap().unwrap();
    let index = summary.attachment_indexes.iter().find(|a| a.name == name).unwrap();
    mcap::read::attachment(bytes, index).unwrap().data.into_owned()
}

/// Messages of each topic.
fn count(bytes: &[u8], topic: &str) -> usize {
    MessageStream::new(bytes).unwrap().filter(|m| m.as_ref().unwrap().channel.topic == topic).count()
}

#[test]
fn from_a_scene_to_a_recording() {
    let data = data();
    let program = Program::start(data.path(), &[]);
    let client = &program.client;
    let scene = example("job.request.json");

    let job = submit(client, &scene);
    let events: Vec<_> = client.follow(&format!("{job}/events"), None).collect();
    assert_eq!(events.last().unwrap().kind, "succeeded", "{events:?}");
    let end = client.get(&job).json();
    assert_eq!(end["progress"], 1.0);
    assert_eq!(end["simulated_time_s"], scene["end_time_s"]);

    let bytes = download(client, &format!("{job}/recording"), 50_000);
    assert_eq!(end["recording"]["sha256"], hexadecimal(&Sha256::digest(&bytes)));
    let named = client.get(&format!("{job}/recording.mcap"));
    assert_eq!(named.body, bytes, "the same file under a name that players of recordings know");
    assert_eq!(count(&bytes, "/stress/block"), 11, "every hundredth of a millisecond, and the start");
    let steps = end["step"].as_u64().unwrap() as usize;
    assert_eq!(count(&bytes, "/energy"), steps + 1);

    let summary = client.get(&format!("{job}/summary"));
    assert_eq!(summary.body, attachment(&bytes, "summary.json"), "the summary is the one in the recording");
    assert_eq!(summary.json()["steps"], steps);
    let sent: Value = serde_json::from_slice(&attachment(&bytes, "scene.json")).unwrap();
    assert_eq!(sent, scene);
}

#[test]
fn killed_program_leaves_no_job_behind() {
    let data = data();
    let program = Program::start(data.path(), &[]);
    let running = submit(&program.client, &slow());
    let waiting = submit(&program.client, &example("job.request.json"));
    eventually("it has begun", || program.client.get(&running).json()["step"].as_u64().unwrap() > 0);
    program.kill();

    let program = Program::start(data.path(), &[]);
    let end = wait_for(&program.client, &running, "succeeded");
    assert_eq!(end["attempts"], 2);
    wait_for(&program.client, &waiting, "succeeded");
    let kinds: Vec<String> =
        program.client.follow(&format!("{running}/events"), None).map(|e| e.kind).collect();
    let kept: Vec<&str> = kinds.iter().map(String::as_str).filter(|k| *k != "progress").collect();
    assert_eq!(kept, ["queued", "running", "requeued", "running", "succeeded"]);
    let bytes = program.client.get(&format!("{running}/recording")).body;
    assert!(Summary::read(&bytes).unwrap().is_some());
}

#[test]
fn job_that_kills_its_program_ends_as_failed_with_what_can_be_read() {
    let data = data();
    let mut job = String::new();
    for attempt in 1..=3 {
        let program = Program::start(data.path(), &[]);
        if attempt == 1 {
            job = submit(&program.client, &lasting());
        }
        // What a snapshot shows is on the disk.
        eventually("it records", || {
            let snapshot = program.client.get(&format!("{job}/recording"));
            snapshot.status == 200 && count(&snapshot.body, "/stress/block") > 0
        });
        program.kill();
    }
    let program = Program::start(data.path(), &[]);
    let end = program.client.get(&job).json();
    assert_eq!(end["state"], "failed");
    assert_eq!(end["failure"]["cause"], "worker_lost");
    assert_eq!(end["attempts"], 3);
    assert_eq!(end["recording"]["complete"], false);
    let bytes = program.client.get(&format!("{job}/recording")).body;
    assert!(count(&bytes, "/stress/block") > 0);
}

#[test]
fn terminated_program_puts_its_job_back_and_ends_well() {
    let data = data();
    let program = Program::start(data.path(), &["--grace-s", "0"]);
    let job = submit(&program.client, &slow());
    eventually("it has begun", || program.client.get(&job).json()["step"].as_u64().unwrap() > 0);
    assert!(program.terminate().success());

    let program = Program::start(data.path(), &[]);
    assert_eq!(wait_for(&program.client, &job, "succeeded")["attempts"], 1);
}

#[test]
fn cancelled_run_stops_soon_and_leaves_a_readable_recording() {
    let data = data();
    let program = Program::start(data.path(), &[]);
    let job = submit(&program.client, &lasting());
    eventually("it has begun", || program.client.get(&job).json()["step"].as_u64().unwrap() > 0);
    program.client.post(&format!("{job}/cancel"));
    wait_for(&program.client, &job, "cancelled");
    let bytes = program.client.get(&format!("{job}/recording")).body;
    assert!(Summary::read(&bytes).unwrap().is_some());
    assert_eq!(program.client.get(&format!("{job}/summary")).json()["ending"], "cancelled");
}

#[test]
fn uploaded_mesh_runs() {
    let data = data();
    let program = Program::start(data.path(), &[]);
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenarios/ball_on_block/scene_L0.inp");
    let bytes = std::fs::read(file).unwrap();
    let octets = [("Content-Type", "application/octet-stream")];
    let answer = program.client.send("POST", "/v1/meshes", &octets, &bytes);
    assert_eq!(answer.status, 201, "{}", answer.text());
    let mesh = answer.json();
    assert!(mesh["quality"]["min_scaled_jacobian"].as_f64().unwrap() > 0.0);

    // One part of it, thrown at nothing.
    let part = mesh["parts"].as_object().unwrap().keys().next().unwrap();
    let scene = json!({
        "name": "free flight of an uploaded mesh", "end_time_s": 1e-6,
        "bodies": [{
            "name": "it", "velocity_m_per_s": [0, 0, 1],
            "mesh": { "file": { "name": mesh["id"], "parts": [part] } },
            "parts": [{ "part": part, "density_kg_per_m3": 1000,
                        "material": { "law": "neo_hookean", "c10_pa": 1e5, "bulk_modulus_pa": 1e7 } }]
        }]
    });
    let job = submit(&program.client, &scene);
    wait_for(&program.client, &job, "succeeded");

    let mut unknown = scene;
    unknown["bodies"][0]["mesh"]["file"]["name"] = json!("../meshes/jobs.sqlite");
    let body = problem(&program.client.post_json("/v1/jobs", &unknown), 422, "invalid-scene");
    assert_eq!(body["errors"][0]["pointer"], "/bodies/0/mesh/file/name", "{body}");
}

#[test]
fn validation_says_everything_at_once() {
    let data = data();
    let program = Program::start(data.path(), &[]);
    let valid = program.client.post_json("/v1/jobs/validate", &example("job.request.json"));
    assert_eq!(valid.status, 200, "{}", valid.text());
    let plan = &valid.json()["plan"];
    assert!(plan["stable_step_s"].as_f64().unwrap() > 0.0 && plan["elements"] == 240, "{plan}");

    let mut wrong = example("job.request.json");
    wrong["end_time_s"] = json!(-1.0);
    wrong["bodies"][0]["parts"][0]["density_kg_per_m3"] = json!(0);
    wrong["bodies"][1]["fixed"][0]["set"] = json!("nothing");
    let body = problem(&program.client.post_json("/v1/jobs/validate", &wrong), 422, "invalid-scene");
    let pointers: Vec<&str> =
        body["errors"].as_array().unwrap().iter().map(|e| e["pointer"].as_str().unwrap()).collect();
    for pointer in ["/end_time_s", "/bodies/0/parts/0/density_kg_per_m3", "/bodies/1/fixed/0/set"] {
        assert!(pointers.contains(&pointer), "{pointer} is not in {pointers:?}");
    }
}

#[test]
fn scene_that_cannot_end_in_time_is_refused() {
    let data = data();
    let program = Program::start(data.path(), &["--deadline-s", "0"]);
    let body =
        problem(&program.client.post_json("/v1/jobs", &example("job.request.json")), 422, "invalid-scene");
    assert_eq!(body["errors"][0]["code"], "budget_wall_time");
}

#[test]
fn full_disk_fails_the_job_and_not_the_service() {
    let data = data();
    // Files may grow to 6 MB, which is less than the recording of the slow scene with ten times its fields, and more than the write-ahead
    // log of the store, which is emptied from 4 MB on.
    let program = Program::limited(data.path(), 12 * 1024);
    let mut scene = slow();
    scene["record"]["field_interval_s"] = json!(1e-7);
    let job = submit(&program.client, &scene);
    let end = wait_for(&program.client, &job, "failed");
    assert_eq!(end["failure"]["cause"], "recording_failed");
    assert!(!leaks(&end.to_string(), data.path()), "{end}");
    let job = submit(&program.client, &example("job.request.json"));
    wait_for(&program.client, &job, "succeeded");
}

#[test]
fn health_command_reports_whether_the_service_is_ready() {
    let data = data();
    let program = Program::start(data.path(), &[]);
    let ask = |address: &str| {
        let mut command = Command::new(env!("CARGO_BIN_EXE_contuse"));
        command.args(["health", "--address", address]).stderr(Stdio::null()).status().unwrap().success()
    };
    let address = program.client.address.to_string();
    assert!(ask(&address));
    program.kill();
    assert!(!ask(&address));
}

#[test]
fn data_is_for_its_user_alone_and_names_are_not_logged() {
    use std::os::unix::fs::PermissionsExt as _;
    let data = tempfile::tempdir().unwrap();
    let (folder, log) = (data.path().join("data"), data.path().join("log"));
    let mut command = Command::new(env!("CARGO_BIN_EXE_contuse"));
    command.args(SERVE).arg(&folder).env("RUST_LOG", "debug").stdout(Stdio::piped());
    let mut child = command.stderr(std::fs::File::create(&log).unwrap()).spawn().unwrap();
    let mut line = String::new();
    BufReader::new(child.stdout.take().unwrap()).read_line(&mut line).unwrap();
    let client = Client::new(line.trim().strip_prefix("listening on http://").unwrap().parse().unwrap());
    let program = Program { child, client: client.clone() };
    let mut scene = example("job.request.json");
    scene["name"] = json!("patient-4711-left-thigh");
    finished(&client, &scene);
    let cube = std::fs::read(Path::new(env!("CARGO_MANIFEST_DIR")).join("api/examples/cube.msh")).unwrap();
    let octets = [("Content-Type", "application/octet-stream")];
    assert_eq!(client.send("POST", "/v1/meshes", &octets, &cube).status, 201);
    let mut folders = vec![folder.clone()];
    let mut count = 0;
    while let Some(folder) = folders.pop() {
        let mode = |path: &Path| std::fs::metadata(path).unwrap().permissions().mode() & 0o777;
        assert_eq!(mode(&folder), 0o700, "{}", folder.display());
        for entry in std::fs::read_dir(&folder).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                folders.push(path);
            } else {
                assert_eq!(mode(&path), 0o600, "{}", path.display());
                count += 1;
            }
        }
    }
    assert!(count >= 5, "{count}");
    assert!(program.terminate().success());
    let text = std::fs::read_to_string(&log).unwrap();
    assert!(text.contains("accepted") && !text.contains("patient-4711"), "{text}");

    let purge = |days: &str| {
        let mut command = Command::new(env!("CARGO_BIN_EXE_contuse"));
        let output =
            command.args(["purge", "--older-than-days", days, "--data"]).arg(&folder).output().unwrap();
        String::from_utf8(output.stdout).unwrap()
    };
    assert_eq!(purge("1"), "deleted 0 job(s) and 0 mesh(es)\n");
    assert_eq!(purge("0"), "deleted 1 job(s) and 1 mesh(es)\n");
}
