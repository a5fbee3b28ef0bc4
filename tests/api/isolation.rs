//! Runs are processes: what happens to one happens to no other, and not to the service.

use crate::support::client::Client;
use crate::support::program::Program;
use crate::support::*;
use contuse::service::config::RunConfig;
use contuse::service::jobs::process::{Groups, ProcessEngine};
use serde_json::{Value, json};
use std::os::unix::fs::PermissionsExt as _;
use std::path::Path;
use std::process::Command;
use std::sync::Arc;
use std::time::{Duration, Instant};
use tempfile::TempDir;

/// A ball on a block of so many elements in each direction, over some time.
fn ball_on_block(elements: u32, end_time_s: f64) -> Value {
    let mut scene: Value =
        serde_json::from_str(include_str!("../recording/small_ball_on_block.json")).unwrap();
    scene["bodies"][1]["mesh"]["generator"]["elements"] = json!([elements, elements, elements]);
    scene["end_time_s"] = json!(end_time_s);
    scene["record"] = json!({"field_interval_s": end_time_s});
    scene
}

/// Runs for minutes.
fn long() -> Value {
    ball_on_block(8, 1.0)
}

fn short() -> Value {
    ball_on_block(4, 1e-4)
}

fn wait_for_run(program: &Program) -> u32 {
    let mut found = Vec::new();
    eventually("a run has its process", || {
        found = program.runs();
        !found.is_empty()
    });
    found[0]
}

fn kinds(client: &Client, job: &str) -> Vec<String> {
    let kinds = client.follow(&format!("{job}/events"), None).map(|event| event.kind);
    kinds.filter(|kind| kind != "progress").collect()
}

#[test]
fn a_killed_run_is_tried_again_alone_and_its_neighbour_does_not_notice() {
    let data = tempfile::tempdir().unwrap();
    let mut command = Command::new(env!("CARGO_BIN_EXE_contuse"));
    command.args(["serve", "--listen", "127.0.0.1:0", "--workers", "2", "--max-attempts", "2", "--data"]);
    command.arg(data.path());
    let program = Program::spawn(command);
    let client = &program.client;
    let job = submit(client, &long());
    let victim = wait_for_run(&program);
    let neighbour = submit(client, &long());
    eventually("both run", || program.runs().len() == 2);
    let kill =
        |id: u32| assert!(Command::new("kill").args(["-KILL", &id.to_string()]).status().unwrap().success());
    kill(victim);
    eventually("it waits again", || client.get(&job).json()["state"] == "queued");
    std::thread::sleep(Duration::from_millis(300));
    assert_eq!(client.get(&job).json()["state"], "queued", "its neighbour still runs");
    assert_eq!(client.get(&neighbour).json()["state"], "running");
    client.post(&format!("{neighbour}/cancel"));
    assert_eq!(wait_for(client, &neighbour, "cancelled")["attempts"], 1);
    // Alone now: the next one waits, although there is a worker for it.
    wait_for(client, &job, "running");
    let next = submit(client, &short());
    std::thread::sleep(Duration::from_millis(300));
    assert_eq!(client.get(&next).json()["state"], "queued");
    kill(wait_for_run(&program));
    let end = wait_for(client, &job, "failed");
    assert_eq!((&end["attempts"], &end["failure"]["cause"]), (&json!(2), &json!("killed")), "{end}");
    assert!(end["failure"]["message"].as_str().unwrap().contains("signal: 9"), "{end}");
    assert_eq!(kinds(client, &job), ["queued", "running", "requeued", "running", "failed"]);
    wait_for(client, &next, "succeeded");
}

#[test]
fn a_run_that_needs_more_memory_than_it_may_take_fails_by_itself() {
    let data = tempfile::tempdir().unwrap();
    let program = Program::start(data.path(), &["--max-running-memory", "40M"]);
    let client = &program.client;
    let large = submit(client, &ball_on_block(40, 1e-5));
    let small = submit(client, &short());
    let end = wait_for(client, &large, "failed");
    assert_eq!(end["failure"]["cause"], "out_of_memory", "{end}");
    assert!(end["failure"]["message"].as_str().unwrap().contains("41 MB"), "{end}");
    // Once more alone, which gives it no more memory here.
    assert_eq!(end["attempts"], 2);
    wait_for(client, &small, "succeeded");
}

/// A folder of cgroups on this machine, if this user may make one.
struct Cgroup(std::path::PathBuf);

impl Cgroup {
    fn new() -> Option<Self> {
        let version_1 = Path::new("/sys/fs/cgroup/memory");
        let root = if version_1.exists() { version_1 } else { Path::new("/sys/fs/cgroup") };
        let folder = root.join(format!("contuse-test-{}", std::process::id()));
        std::fs::create_dir(&folder).ok()?;
        let made = Self(folder);
        let is_limited =
            ["memory.limit_in_bytes", "memory.max"].iter().any(|file| made.0.join(file).exists());
        is_limited.then_some(made)
    }

    fn groups(&self) -> Vec<std::path::PathBuf> {
        let entries = std::fs::read_dir(&self.0).unwrap().flatten();
        entries.map(|entry| entry.path()).filter(|path| path.is_dir()).collect()
    }
}

impl Drop for Cgroup {
    fn drop(&mut self) {
        let _ = std::fs::remove_dir(&self.0);
    }
}

#[test]
fn a_run_has_a_group_where_there_are_groups() {
    let Some(cgroup) = Cgroup::new() else {
        eprintln!("not tried: this user may not make cgroups");
        return;
    };
    let data = tempfile::tempdir().unwrap();
    let program = Program::start(data.path(), &["--cgroup", cgroup.0.to_str().unwrap()]);
    let client = &program.client;
    let job = submit(client, &long());
    let run = wait_for_run(&program);
    eventually("it has a group", || !cgroup.groups().is_empty());
    let group = cgroup.groups().remove(0);
    let read = |file: &str| std::fs::read_to_string(group.join(file)).unwrap_or_default();
    eventually("it is in its group", || read("cgroup.procs").trim() == run.to_string());
    let limit: u64 = (read("memory.limit_in_bytes") + &read("memory.max")).trim().parse().unwrap();
    assert!((256 << 20..1 << 30).contains(&limit), "twice what is expected, and 256 MB: {limit}");
    client.post(&format!("{job}/cancel"));
    eventually("its group is gone", || cgroup.groups().is_empty());
}

#[test]
fn a_folder_without_groups_is_refused_and_left_as_it_is() {
    let (data, plain) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
    for folder in [Path::new("/proc"), plain.path()] {
        let refused = Command::new(env!("CARGO_BIN_EXE_contuse"))
            .args(["serve", "--listen", "127.0.0.1:0", "--data"])
            .arg(data.path())
            .arg("--cgroup")
            .arg(folder)
            .output()
            .unwrap();
        let said = String::from_utf8_lossy(&refused.stderr);
        assert!(!refused.status.success(), "{folder:?}");
        assert!(said.contains(&format!("--cgroup {}", folder.display())), "{said}");
        assert!(said.contains("not a folder of cgroups") && said.contains("omit --cgroup"), "{said}");
    }
    assert_eq!(std::fs::read_dir(plain.path()).unwrap().count(), 0);
}

#[test]
fn a_run_that_its_group_kills_is_out_of_memory() {
    let Some(cgroup) = Cgroup::new() else {
        eprintln!("not tried: this user may not make cgroups");
        return;
    };
    let (folder, data) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
    let takes_memory = "head -c 2000000000 /dev/zero | tail -c 2000000000 >/dev/null; exit 3";
    let groups = Groups::open(&cgroup.0).unwrap();
    let engine = ProcessEngine::new(&RunConfig::default(), &scripted(&folder, takes_memory), Some(groups));
    let server = Server::with_engine(Arc::new(data), Arc::new(engine), |c| c.max_attempts = 1);
    let end = wait_for(&server.client(), &submit(&server.client(), &short()), "failed");
    assert_eq!(end["failure"]["cause"], "out_of_memory", "{end}");
    drop(server);
    assert!(cgroup.groups().is_empty());
}

#[test]
fn memory_of_the_service_stays_small() {
    let data = tempfile::tempdir().unwrap();
    let program = Program::start(data.path(), &[]);
    let client = &program.client;
    // 33 000 elements: more than the service validates itself.
    let large = ball_on_block(32, 1e-6);
    let answer = client.post_json("/v1/jobs/validate", &large);
    assert_eq!(answer.status, 200, "{answer:?}");
    let (job, _) = finished(client, &large);
    assert_eq!(client.get(&format!("{job}/plan")).status, 200);
    let peak = program.peak_memory();
    assert!(peak < 150_000_000, "{peak}");
}

#[test]
fn runs_end_with_the_service() {
    let data = tempfile::tempdir().unwrap();
    let program = Program::start(data.path(), &[]);
    submit(&program.client, &long());
    let run = wait_for_run(&program);
    program.kill();
    eventually("its run ends", || !Path::new(&format!("/proc/{run}/exe")).exists());
}

/// A program that does what a script says instead of a run.
fn scripted(folder: &TempDir, script: &str) -> std::path::PathBuf {
    let path = folder.path().join("run");
    std::fs::write(&path, format!("#!/bin/sh\nread task\n{script}\n")).unwrap();
    std::fs::set_permissions(&path, std::fs::Permissions::from_mode(0o700)).unwrap();
    path
}

#[test]
fn each_death_has_its_cause() {
    for (script, cause, attempts) in [
        ("printf '[\"Panicked\",0]\\n'", "panicked", 1),
        ("kill -SEGV $$", "killed", 2),
        ("exit 3", "killed", 2),
        ("echo nonsense", "killed", 2),
        ("echo 'memory allocation of 8 bytes failed' >&2; kill -ABRT $$", "out_of_memory", 2),
        ("kill -XCPU $$", "deadline", 1),
    ] {
        let folder = tempfile::tempdir().unwrap();
        let server = Server::running(&scripted(&folder, script), |c| c.max_attempts = 2);
        let end = wait_for(&server.client(), &submit(&server.client(), &short()), "failed");
        let found = (end["failure"]["cause"].as_str().unwrap(), &end["attempts"]);
        assert_eq!(found, (cause, &json!(attempts)), "{script}: {end}");
        assert!(!leaks(&end.to_string(), server.data.path()), "{end}");
    }
}

#[test]
fn a_run_that_does_not_listen_is_killed() {
    let folder = tempfile::tempdir().unwrap();
    let server = Server::running(&scripted(&folder, "sleep 600"), |c| c.workers = 1);
    let client = server.client();
    let job = submit(&client, &short());
    wait_for(&client, &job, "running");
    let requested = Instant::now();
    client.post(&format!("{job}/cancel"));
    wait_for(&client, &job, "cancelled");
    assert!(requested.elapsed() < Duration::from_secs(60));
}

/// A program that reads nothing of its task.
fn deaf(folder: &TempDir) -> std::path::PathBuf {
    let path = folder.path().join("deaf");
    std::fs::write(&path, "#!/bin/sh\nexec sleep 600\n").unwrap();
    std::fs::set_permissions(&path, std::fs::Permissions::from_mode(0o700)).unwrap();
    path
}

#[test]
fn a_process_that_does_not_take_its_task_is_killed() {
    let folder = tempfile::tempdir().unwrap();
    let server = Server::running(&deaf(&folder), |c| c.max_attempts = 2);
    let client = server.client();
    let words = "it took none of its input for 20 s";
    // The largest document that the service validates itself is more than a pipe holds, with the rest of its task.
    let scene = short().to_string();
    let padded = format!("{scene}{}", " ".repeat((64 << 10) - scene.len()));
    let job = client.post_text("/v1/jobs", &padded);
    assert_eq!(job.status, 202, "{job:?}");
    // Meanwhile a mesh, and a scene whose validation has a process.
    let mesh = client.send("POST", "/v1/meshes", &[], &vec![b'$'; 1_000_000]);
    assert!(problem(&mesh, 422, "invalid-mesh")["detail"].as_str().unwrap().contains(words), "{mesh:?}");
    let refused = client.post_text("/v1/jobs", &(padded + "  "));
    let refused = problem(&refused, 422, "invalid-scene");
    assert!(refused["errors"][0]["message"].as_str().unwrap().contains(words), "{refused}");
    let end = wait_for(&client, job.header("location").unwrap(), "failed");
    assert_eq!((&end["attempts"], &end["failure"]["cause"]), (&json!(2), &json!("killed")), "{end}");
    assert!(end["failure"]["message"].as_str().unwrap().contains(words), "{end}");
}

#[test]
fn reading_an_upload_has_limits_of_time_and_memory() {
    let folder = tempfile::tempdir().unwrap();
    let task = folder.path().join("task");
    let note = format!("echo \"$task\" > {}", task.display());
    for (death, words) in [
        ("kill -XCPU $$", "more than 20 s"),
        ("echo 'memory allocation of 8 bytes failed' >&2; kill -ABRT $$", "MB of memory"),
        ("exit 3", "exit status: 3"),
    ] {
        let server = Server::running(&scripted(&folder, &format!("{note}\n{death}")), |_| {});
        let answer = server.client().send("POST", "/v1/meshes", &[], b"$MeshFormat");
        let refused = problem(&answer, 422, "invalid-mesh");
        assert!(refused["detail"].as_str().unwrap().contains(words), "{death}: {refused}");
        assert!(std::fs::read_to_string(&task).unwrap().contains("\"cpu_s\":20"));
    }
}

#[test]
fn a_mesh_whose_reading_was_killed_is_not_called_invalid() {
    let folder = tempfile::tempdir().unwrap();
    let server = Server::running(&scripted(&folder, "kill -KILL $$"), |_| {});
    let answer = server.client().send("POST", "/v1/meshes", &[], b"$MeshFormat");
    let refused = problem(&answer, 503, "busy");
    assert!(refused["detail"].as_str().unwrap().contains("signal: 9"), "{refused}");
    assert!(answer.header("retry-after").is_some(), "{answer:?}");
}

#[test]
fn validating_a_large_scene_has_limits_of_time_and_memory() {
    let folder = tempfile::tempdir().unwrap();
    let task = folder.path().join("task");
    let death = format!("echo \"$task\" > {}\nkill -XCPU $$", task.display());
    let server = Server::running(&scripted(&folder, &death), |_| {});
    let answer = server.client().post_json("/v1/jobs/validate", &ball_on_block(32, 1e-6));
    let refused = problem(&answer, 422, "invalid-scene");
    assert!(refused["errors"][0]["message"].as_str().unwrap().contains("more than 300 s"), "{refused}");
    assert!(std::fs::read_to_string(&task).unwrap().contains("\"cpu_s\":300"));
}

#[test]
fn what_no_one_waits_for_is_not_read_on() {
    let folder = tempfile::tempdir().unwrap();
    let (script, id) = ("echo $$ > \"$0.id\"; exec sleep 600", folder.path().join("run.id"));
    let server = Server::running(&scripted(&folder, script), |_| {});
    let large = ball_on_block(32, 1e-6).to_string();
    for (address, body) in
        [("/v1/meshes", "$MeshFormat"), ("/v1/jobs/validate", &large), ("/v1/jobs", &large)]
    {
        let _ = std::fs::remove_file(&id);
        let kind = if body.starts_with('$') { "octet-stream" } else { "json" };
        let length = body.len();
        let request = format!(
            "POST {address} HTTP/1.1\r\nHost: localhost\r\nContent-Type: application/{kind}\r\nContent-Length: {length}\r\n\r\n{body}"
        );
        let connection = server.client().raw(request.as_bytes());
        let mut process = String::new();
        eventually("it is read", || {
            process = std::fs::read_to_string(&id).unwrap_or_default();
            process.ends_with('\n')
        });
        let place = format!("/proc/{}/exe", process.trim());
        assert!(Path::new(&place).exists());
        drop(connection);
        let closed = Instant::now();
        eventually("its process ends", || !Path::new(&place).exists());
        assert!(closed.elapsed() < Duration::from_secs(30), "{address}: {:?}", closed.elapsed());
    }
}

#[test]
fn a_run_waits_for_a_process() {
    let folder = tempfile::tempdir().unwrap();
    let program = folder.path().join("later");
    let server = Server::running(&program, |_| {});
    let client = server.client();
    let job = submit(&client, &short());
    wait_for(&client, &job, "running");
    std::os::unix::fs::symlink(env!("CARGO_BIN_EXE_contuse"), &program).unwrap();
    assert_eq!(wait_for(&client, &job, "succeeded")["attempts"], 1);
}
