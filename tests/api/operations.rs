//! What an operator meets: scarce descriptors, a disk that turns read-only, backups.

use crate::found::run;
use crate::support::client::read_answer;
use crate::support::program::{Program, SERVE};
use crate::support::*;
use contuse::service::doctor::examine;
use sqlx::sqlite::{SqliteConnectOptions, SqlitePool};
use std::io::{BufReader, Write as _};
use std::net::TcpStream;
use std::os::unix::fs::PermissionsExt as _;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::Arc;
use std::time::Duration;

/// A scene that runs for a moment.
fn small() -> String {
    include_str!("../recording/small_ball_on_block.json").to_owned()
}

#[test]
fn without_descriptors_requests_are_answered_503() {
    let data = tempfile::tempdir().unwrap();
    let mut command = Command::new("sh");
    command.args(["-c", "ulimit -n 64; exec \"$0\" \"$@\"", env!("CARGO_BIN_EXE_contuse")]);
    command.args(SERVE).arg(data.path());
    let program = Program::spawn(command);
    let client = &program.client;
    let (job, _) = finished(client, &serde_json::from_str(&small()).unwrap());
    // A connection that is open before all others.
    let mut open = client.raw(b"");
    let ask = |stream: &mut TcpStream, path: &str| {
        write!(stream, "GET {path} HTTP/1.1\r\nHost: {}\r\n\r\n", client.address).unwrap();
        read_answer(&mut BufReader::new(stream.try_clone().unwrap()), false)
    };
    assert_eq!(ask(&mut open, "/healthz").status, 200);
    let recording = format!("{job}/recording");
    let mut others = Vec::new();
    eventually("no descriptor is left", || {
        others.push(client.raw(b""));
        let answer = ask(&mut open, &recording);
        if answer.status == 503 {
            problem(&answer, 503, "busy");
            assert!(answer.header("retry-after").is_some());
        } else {
            assert_eq!(answer.status, 200, "{answer:?}");
        }
        answer.status == 503
    });
    assert_eq!(ask(&mut open, "/healthz").status, 200);
    drop(others);
    eventually("there are descriptors again", || ask(&mut open, &recording).status == 200);
    finished(client, &serde_json::from_str(&small()).unwrap());
}

/// A disk in a file, which turns read-only on demand as after a fault of the device. Needs the rights to mount.
struct Disk {
    image: PathBuf,
    mounted: PathBuf,
}

fn command(program: &str, arguments: &[&str]) -> bool {
    let output = Command::new(program).args(arguments).output();
    output.is_ok_and(|output| output.status.success())
}

impl Disk {
    fn new(folder: &Path) -> Option<Self> {
        let disk = Self { image: folder.join("image"), mounted: folder.join("mounted") };
        std::fs::create_dir(&disk.mounted).unwrap();
        std::fs::File::create(&disk.image).unwrap().set_len(256 << 20).unwrap();
        let is_made = command("mkfs.ext4", &["-q", disk.image.to_str().unwrap()]) && disk.mount();
        is_made.then_some(disk)
    }

    fn mount(&self) -> bool {
        command("mount", &["-o", "loop", self.image.to_str().unwrap(), self.mounted.to_str().unwrap()])
    }

    /// From now on every write fails, also to files that are open.
    fn fail(&self) {
        assert!(command("mount", &["-o", "remount,abort", self.mounted.to_str().unwrap()]));
    }

    /// Leaves so many bytes free, until the file is removed whose path this gives.
    fn fill(&self, free: u64) -> PathBuf {
        let path = self.mounted.join("filler");
        let mut filler = std::fs::File::create(&path).unwrap();
        let piece = vec![0; 1 << 20];
        while filler.write_all(&piece).is_ok() {}
        let length = filler.metadata().unwrap().len();
        filler.set_len(length - free).unwrap();
        filler.sync_all().unwrap();
        path
    }

    fn repair(&self) {
        assert!(command("umount", &[self.mounted.to_str().unwrap()]));
        // Its exit code says that it repaired something.
        command("e2fsck", &["-fy", self.image.to_str().unwrap()]);
        assert!(self.mount());
    }
}

impl Drop for Disk {
    fn drop(&mut self) {
        command("umount", &[self.mounted.to_str().unwrap()]);
    }
}

#[test]
fn a_read_only_disk_pauses_the_workers_and_refuses_jobs() {
    let folder = tempfile::tempdir().unwrap();
    let Some(disk) = Disk::new(folder.path()) else {
        eprintln!("not tried: this user may not mount a disk");
        return;
    };
    let data = disk.mounted.join("data");
    let program = Program::start(&data, &["--grace-s", "0"]);
    let client = &program.client;
    let (done, _) = finished(client, &serde_json::from_str(&small()).unwrap());
    let mut long: serde_json::Value = serde_json::from_str(&small()).unwrap();
    long["end_time_s"] = serde_json::json!(0.05);
    let running = submit(client, &long);
    wait_for(client, &running, "running");
    let waiting: Vec<String> = (0..20).map(|_| submit(client, &long)).collect();
    disk.fail();
    eventually("jobs are refused", || {
        let answer = client.post_text("/v1/jobs", &small());
        assert!([202, 503, 507].contains(&answer.status), "{answer:?}");
        assert!(answer.status == 202 || answer.header("retry-after").is_some(), "{answer:?}");
        answer.status != 202
    });
    let mesh = client.send("POST", "/v1/meshes", &[("Content-Type", "application/octet-stream")], b"$mesh");
    problem(&mesh, 503, "unavailable");
    problem(&client.get("/readyz"), 503, "unavailable");
    std::thread::sleep(std::time::Duration::from_secs(3));
    // What is there can be read, and nothing has failed.
    assert_eq!(client.get(&format!("{done}/recording")).status, 200);
    for job in &waiting {
        assert_eq!(client.get(job).json()["state"], "queued");
    }
    program.kill();
    disk.repair();
    let again = Program::start(&data, &[]);
    for job in [&running].into_iter().chain(&waiting[..2]) {
        wait_for(&again.client, job, "succeeded");
    }
    again.kill();
}

#[test]
fn a_mesh_for_which_the_disk_has_no_room_is_refused_and_leaves_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let Some(disk) = Disk::new(folder.path()) else {
        eprintln!("not tried: this user may not mount a disk");
        return;
    };
    let program = Program::start(&disk.mounted.join("data"), &["--least-free", "0"]);
    let client = &program.client;
    let filler = disk.fill(20 << 20);
    let upload = |mesh: &[u8]| {
        client.send("POST", "/v1/meshes", &[("Content-Type", "application/octet-stream")], mesh)
    };
    let large = vec![b'$'; 40 << 20];
    let cube = include_bytes!("../../api/examples/cube.msh");
    for _ in 0..3 {
        let refused = upload(&large);
        problem(&refused, 507, "storage-full");
        assert!(refused.header("retry-after").is_some());
        // What had arrived is gone: there is room for others.
        assert!([200, 201].contains(&upload(cube).status));
    }
    finished(client, &serde_json::from_str(&small()).unwrap());
    assert_eq!(client.get("/healthz").status, 200);
    std::fs::remove_file(filler).unwrap();
    problem(&upload(&large), 422, "invalid-mesh");
    program.kill();
}

#[test]
fn uploads_under_way_count_for_the_disk() {
    let folder = tempfile::tempdir().unwrap();
    let Some(disk) = Disk::new(folder.path()) else {
        eprintln!("not tried: this user may not mount a disk");
        return;
    };
    let program = Program::start(&disk.mounted.join("data"), &["--least-free", "50000000"]);
    let client = &program.client;
    let _filler = disk.fill(90 << 20);
    let refused_at_once = |declared| {
        let upload = client.begin_upload(Some(declared));
        upload.set_read_timeout(Some(std::time::Duration::from_millis(300))).unwrap();
        let is_answered = upload.peek(&mut [0]).is_ok_and(|length| length > 0);
        is_answered.then(|| read_answer(&mut BufReader::new(upload), false))
    };
    problem(&refused_at_once(60 << 20).unwrap(), 507, "storage-full");
    // Nothing of this one has arrived, and yet there is no room for another one.
    let declared = client.begin_upload(Some(30 << 20));
    std::thread::sleep(std::time::Duration::from_millis(500));
    let mut refused = None;
    eventually("two are too many", || {
        refused = refused_at_once(30 << 20);
        refused.is_some()
    });
    let refused = refused.unwrap();
    assert!(refused.header("retry-after").is_some());
    problem(&refused, 507, "storage-full");
    // One that does not say how much it is stops where the room ends.
    let mut unknown = client.begin_upload(None);
    let chunk = [b"100000\r\n".as_slice(), &vec![b'$'; 1 << 20], b"\r\n"].concat();
    let _ = (0..60).try_for_each(|_| unknown.write_all(&chunk));
    problem(&read_answer(&mut BufReader::new(&unknown), false), 507, "storage-full");
    drop((declared, unknown));
    let cube = include_bytes!("../../api/examples/cube.msh");
    let octets = [("Content-Type", "application/octet-stream")];
    let upload = || client.send("POST", "/v1/meshes", &octets, cube).status;
    eventually("those who leave make room", || upload() == 201);
    finished(client, &serde_json::from_str(&small()).unwrap());
    program.kill();
}

#[test]
fn a_recording_that_met_a_full_disk_is_tried_again_but_not_for_ever() {
    let folder = tempfile::tempdir().unwrap();
    let Some(disk) = Disk::new(folder.path()) else {
        eprintln!("not tried: this user may not mount a disk");
        return;
    };
    // More than the disk has free, and all of it is free again once the run has failed: no worker waits for room.
    let mut large: serde_json::Value = serde_json::from_str(&small()).unwrap();
    large["bodies"][1]["mesh"]["generator"]["elements"] = serde_json::json!([16, 16, 8]);
    large["record"] =
        serde_json::json!({"field_interval_s": 1e-6, "fields": ["von_mises", "element_cauchy_stress"]});
    let program = Program::start(&disk.mounted.join("data"), &["--least-free", "0", "--max-attempts", "2"]);
    let filler = disk.fill(4 << 20);
    let failed = wait_for(&program.client, &submit(&program.client, &large), "failed");
    assert_eq!(failed["failure"]["cause"], "recording_failed");
    assert_eq!(failed["attempts"], 2, "{failed}");
    finished(&program.client, &serde_json::from_str(&small()).unwrap());
    program.kill();
    // Room that comes in time is used.
    let program =
        Program::start(&disk.mounted.join("data"), &["--least-free", "0", "--max-attempts", "1000"]);
    let job = submit(&program.client, &large);
    while program.client.get(&job).json()["attempts"].as_u64() < Some(2) {
        std::thread::sleep(std::time::Duration::from_millis(20));
    }
    std::fs::remove_file(filler).unwrap();
    wait_for(&program.client, &job, "succeeded");
    program.kill();
}

#[test]
fn a_line_of_the_audit_log_is_whole_or_not_there() {
    let data = tempfile::tempdir().unwrap();
    let log = data.path().join("audit.jsonl");
    // No file grows beyond 8 MB, from which the log is as far as half a line.
    let lines = format!("{:>106}\n", "{}").repeat((8 << 20) / 107);
    assert!((8 << 20) - lines.len() < 30);
    std::fs::write(&log, &lines).unwrap();
    let program = Program::limited(data.path(), 16 << 10);
    let (job, _) = finished(&program.client, &serde_json::from_str(&small()).unwrap());
    program.client.get(&format!("{job}/summary"));
    assert!(std::fs::read_to_string(&log).unwrap() == lines);
    // Those that are missing are counted, and the service is not ready.
    let counted = "contuse_store_errors_total{store=\"audit\"} 2\n";
    let metrics = program.client.get("/metrics").text();
    assert!(metrics.contains(counted), "{metrics}");
    problem(&program.client.get("/readyz"), 503, "unavailable");
    // With room again the log says how many they are.
    let limit = format!("--pid={}", program.child.id());
    assert!(command("prlimit", &[&limit, "--fsize=unlimited:"]));
    eventually("the service is ready", || program.client.get("/readyz").status == 200);
    program.kill();
    let text = std::fs::read_to_string(&log).unwrap();
    let last: serde_json::Value = serde_json::from_str(text.strip_prefix(&lines).unwrap()).unwrap();
    assert_eq!(last["lost"], 2);
}

/// Copies a folder with all in it, if it exists.
fn copy(from: &Path, to: &Path) {
    assert!(!from.exists() || command("cp", &["-a", from.to_str().unwrap(), to.to_str().unwrap()]));
}

#[test]
fn a_backup_of_a_running_service_is_restored() {
    let server = Server::start();
    let client = server.client();
    let octets = [("Content-Type", "application/octet-stream")];
    let mesh = client.send("POST", "/v1/meshes", &octets, b"$MeshFormat").json()["id"].clone();
    let (done, end) = finished(&client, &quick());
    let running = submit(
        &client,
        &serde_json::json!({ "name": "slow", "end_time_s": 1.0, "steps": 2000, "step_ms": 1 }),
    );
    wait_for(&client, &running, "running");
    // As in docs/operations.md: first the store, then what never changes.
    let backup = tempfile::Builder::new().permissions(std::fs::Permissions::from_mode(0o700)).tempdir();
    let backup = Arc::new(backup.unwrap());
    let store = backup.path().join("jobs.sqlite");
    run(async {
        let options = SqliteConnectOptions::new().filename(server.data.path().join("jobs.sqlite"));
        let pool = SqlitePool::connect_with(options).await.unwrap();
        sqlx::query("VACUUM INTO ?1").bind(store.to_str().unwrap()).execute(&pool).await.unwrap();
        pool.close().await;
    });
    for shelf in ["recordings", "meshes", "results", "audit.jsonl"] {
        copy(&server.data.path().join(shelf), &backup.path().join(shelf));
    }
    // A job that came later is not in it.
    let later = submit(&client, &quick());
    drop(server);
    let found = run(examine(&StoreAddress::in_folder(backup.path()))).unwrap();
    assert!(found.is_sound(), "{found:?}");
    let restored = Server::on(backup, |_| {});
    let client = restored.client();
    assert_eq!(client.get(&done).json()["recording"], end["recording"]);
    assert_eq!(client.get(&format!("{done}/recording")).status, 200);
    assert_eq!(client.get(&format!("/v1/meshes/{}", mesh.as_str().unwrap())).status, 200);
    wait_for(&client, &running, "succeeded");
    assert_eq!(client.get(&later).status, 404);
}

#[test]
fn lines_of_the_log_are_objects_with_the_ids_of_request_and_job() {
    let data = tempfile::tempdir().unwrap();
    let log = data.path().join("log");
    let mut command = Command::new("sh");
    // As an operator sets it.
    command.args(["-c", "RUST_LOG=info exec \"$0\" \"$@\"", env!("CARGO_BIN_EXE_contuse")]);
    command.args(SERVE).arg(data.path().join("data")).args(["--log-format", "json"]);
    command.stderr(std::fs::File::create(&log).unwrap());
    let program = Program::spawn(command);
    let headers = [("Content-Type", "application/json"), ("X-Request-Id", "of-the-proxy")];
    let answer = program.client.send("POST", "/v1/jobs", &headers, small().as_bytes());
    let job = answer.json()["id"].clone();
    wait_for(&program.client, answer.header("location").unwrap(), "succeeded");
    program.terminate();
    let text = std::fs::read_to_string(&log).unwrap();
    let lines: Vec<serde_json::Value> = text
        .lines()
        .map(|line| serde_json::from_str(line).unwrap_or_else(|e| panic!("{e}: {line}")))
        .collect();
    let line = |message: &str| lines.iter().find(|line| line["message"] == message).unwrap();
    let accepted = line("accepted");
    assert_eq!((&accepted["job"], &accepted["span"]["id"]), (&job, &serde_json::json!("of-the-proxy")));
    for message in ["running", "ended"] {
        assert_eq!(line(message)["job"], job, "{message}");
    }
}

#[test]
fn while_the_data_folder_is_away_jobs_wait_and_recordings_are_not_called_lost() {
    let data = Arc::new(tempfile::tempdir().unwrap());
    let server = Server::on(Arc::clone(&data), |_| {});
    let client = server.client();
    let (job, _) = finished(&client, &quick());
    let statuses = || {
        let recording = client.get(&format!("{job}/recording")).status;
        [recording, client.post_json("/v1/jobs", &quick()).status, client.get("/metrics").status]
    };
    assert_eq!(statuses(), [200, 202, 200]);
    let elsewhere = data.path().with_extension("elsewhere");
    std::fs::rename(data.path(), &elsewhere).unwrap();
    assert_eq!(statuses(), [503; 3]);
    std::fs::rename(&elsewhere, data.path()).unwrap();
    // A run that ended meanwhile keeps its result first.
    eventually("jobs are accepted again", || statuses() == [200, 202, 200]);
    let (_, end) = finished(&client, &quick());
    assert_eq!(end["state"], "succeeded", "{end}");
}

/// A server whose job has moved the data folder away before it ends, that job, and where the folder is.
fn without_its_folder() -> (Server, String, PathBuf) {
    let server = Server::start();
    let elsewhere = server.data.path().with_extension("elsewhere");
    let scene =
        serde_json::json!({ "name": "moves", "end_time_s": 1e-3, "steps": 1, "leaves_to": elsewhere });
    let job = submit(&server.client(), &scene);
    eventually("the data folder is away", || elsewhere.exists());
    (server, job, elsewhere)
}

#[test]
fn a_run_whose_recording_cannot_be_named_waits_for_the_data_folder() {
    let (server, job, elsewhere) = without_its_folder();
    let client = server.client();
    // Longer than a run is refused by a folder that is there.
    std::thread::sleep(Duration::from_secs(3));
    assert_eq!(client.get(&job).json()["state"], "running");
    assert_eq!(client.get("/readyz").status, 503);
    std::fs::rename(&elsewhere, server.data.path()).unwrap();
    let end = wait_for(&client, &job, "succeeded");
    assert_eq!(end["attempts"], 1, "{end}");
    assert_eq!(client.get(&format!("{job}/recording")).body.len(), 1000);
}

#[test]
fn a_run_that_waits_for_the_data_folder_is_cancelled() {
    let (server, job, elsewhere) = without_its_folder();
    let client = server.client();
    client.post(&format!("{job}/cancel"));
    wait_for(&client, &job, "cancelled");
    std::fs::rename(&elsewhere, server.data.path()).unwrap();
    assert_eq!(client.get(&format!("{job}/recording")).status, 404);
    // Others run again.
    finished(&client, &quick());
}

#[test]
fn a_recording_that_fills_the_disk_itself_is_given_up() {
    let server = Server::with(|config| config.max_attempts = 1);
    let client = server.client();
    let scene = serde_json::json!({ "name": "large", "end_time_s": 1e-3, "steps": 1, "ending": "killed" });
    let job = submit(&client, &scene);
    let end = wait_for(&client, &job, "failed");
    assert_eq!(end["failure"]["cause"], "killed", "{end}");
    assert_eq!(std::fs::read_dir(server.data.path().join("runs")).unwrap().count(), 0);
    finished(&client, &quick());
}
