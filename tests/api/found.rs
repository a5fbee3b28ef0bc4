//! What is lost is found: rows, recordings, the whole store.

use crate::support::program::{Program, SERVE};
use crate::support::*;
use contuse::service::doctor::{Diagnosis, examine};
use sqlx::sqlite::{SqliteConnectOptions, SqlitePool};
use std::os::unix::fs::PermissionsExt as _;
use std::path::Path;
use std::process::{Command, Stdio};

pub fn run<T>(work: impl Future<Output = T>) -> T {
    tokio::runtime::Builder::new_multi_thread().enable_all().build().unwrap().block_on(work)
}

/// Changes the store of a service that is not running.
pub fn change(data: &Path, statement: &'static str) {
    run(async {
        let options = SqliteConnectOptions::new().filename(data.join("jobs.sqlite"));
        let pool = SqlitePool::connect_with(options).await.unwrap();
        sqlx::query(statement).execute(&pool).await.unwrap();
        pool.close().await;
    });
}

fn diagnosis(data: &Path) -> Diagnosis {
    run(examine(&StoreAddress::in_folder(data))).unwrap()
}

#[test]
fn a_row_that_cannot_be_read_does_not_hide_the_others() {
    let server = Server::start();
    let (bad, _) = finished(&server.client(), &quick());
    let (good, _) = finished(&server.client(), &quick());
    let data = server.stop();
    assert!(diagnosis(data.path()).is_sound());
    change(data.path(), "UPDATE jobs SET warnings = '{' WHERE seq = 1");
    assert_eq!(diagnosis(data.path()).unreadable, [1]);
    let server = Server::on(data, |_| {});
    let jobs = server.client().get("/v1/jobs").json()["jobs"].clone();
    assert_eq!(jobs.as_array().unwrap().len(), 1);
    assert_eq!(jobs[0]["links"]["self"], serde_json::json!(good));
    problem(&server.client().get(&bad), 500, "internal");
    // Not even its id.
    let data = server.stop();
    change(data.path(), "UPDATE jobs SET id = 'x', state = 'running' WHERE seq = 1");
    let server = Server::on(data, |_| {});
    assert_eq!(server.client().get(&good).status, 200);
    finished(&server.client(), &quick());
}

#[test]
fn a_damaged_row_is_reported_and_everything_else_goes_on() {
    let damages = [
        "UPDATE jobs SET attempts = 'x' WHERE seq = 1",
        "UPDATE jobs SET attempts = 1099511627776, state = 'running' WHERE seq = 1",
        "UPDATE jobs SET owner = x'ff', state = 'queued' WHERE seq = 1",
        "UPDATE jobs SET memory_bytes = 'x', state = 'queued' WHERE seq = 1",
        "UPDATE jobs SET trace = x'ff', state = 'queued' WHERE seq = 1",
    ];
    let mut data = {
        let server = Server::start();
        finished(&server.client(), &quick());
        server.stop()
    };
    for damage in damages {
        change(data.path(), damage);
        assert_eq!(diagnosis(data.path()).unreadable, [1], "{damage}");
        let server = Server::on(data, |_| {});
        finished(&server.client(), &quick());
        eventually("it has ended", || {
            let metrics = server.client().get("/metrics").text();
            metrics.contains("contuse_jobs{state=\"queued\"} 0")
                && metrics.contains("contuse_jobs{state=\"running\"} 0")
        });
        data = server.stop();
    }
    // The others are purged. The owner of this one is unreadable, too, as is the format of a mesh.
    change(
        data.path(),
        "INSERT INTO meshes (id, owner, format, bytes, report) VALUES ('0a', 'anna', x'ff', 1, '{}')",
    );
    let purge = Command::new(env!("CARGO_BIN_EXE_contuse"))
        .args(["purge", "--older-than-days", "0", "--data"])
        .arg(data.path())
        .output()
        .unwrap();
    let words = String::from_utf8(purge.stdout).unwrap();
    assert!(words.contains("deleted 5 job(s)") && words.contains("2 more cannot be read"), "{words}");
}

#[test]
fn what_other_users_can_read_is_reported() {
    let server = Server::start();
    finished(&server.client(), &quick());
    let data = server.stop();
    assert!(diagnosis(data.path()).is_sound());
    let set = |path: &Path, mode| {
        std::fs::set_permissions(path, std::fs::Permissions::from_mode(mode)).unwrap();
    };
    // As a backup has been made by someone with the usual mask.
    let (folder, file) = (data.path().join("recordings"), data.path().join("jobs.sqlite"));
    for (path, mode) in [(data.path(), 0o755), (&folder, 0o700), (&file, 0o640)] {
        set(path, mode);
    }
    let found = diagnosis(data.path());
    assert!(!found.is_sound());
    let modes: Vec<_> = found.open_to_others.iter().map(|(path, mode)| (path.as_path(), *mode)).collect();
    assert!(modes.contains(&(data.path(), 0o755)) && modes.contains(&(&file, 0o640)), "{modes:?}");
    assert!(modes.iter().all(|(path, _)| !path.starts_with(&folder)), "{modes:?}");
    set(data.path(), 0o755);
    let doctor =
        Command::new(env!("CARGO_BIN_EXE_contuse")).arg("doctor").arg("--data").arg(data.path()).output();
    let doctor = doctor.unwrap();
    let words = String::from_utf8(doctor.stdout).unwrap();
    assert!(words.contains("(mode 0755)") && words.contains("chmod -R go="), "{words}");
    assert_eq!(doctor.status.code(), Some(3));
    // No one else enters a folder that is closed.
    assert!(diagnosis(data.path()).is_sound());
}

#[test]
fn a_lost_recording_is_reported() {
    let server = Server::start();
    let (job, _) = finished(&server.client(), &quick());
    std::fs::remove_file(&server.files()[0]).unwrap();
    let data = server.stop();
    let lost = diagnosis(data.path()).without_recording;
    assert_eq!(lost.len(), 1);
    assert!(job.ends_with(&lost[0].to_string()));
    let server = Server::on(data, |_| {});
    problem(&server.client().get(&format!("{job}/recording")), 410, "recording-lost");
    assert_eq!(server.client().get(&format!("{job}/summary")).status, 200);
}

#[test]
fn a_lost_store_takes_neither_recordings_nor_meshes_with_it() {
    let server = Server::start();
    finished(&server.client(), &quick());
    let octets = [("Content-Type", "application/octet-stream")];
    server.client().send("POST", "/v1/meshes", &octets, b"$mesh");
    let mut kept = server.files();
    let data = server.stop();
    for end in ["", "-wal", "-shm"] {
        let _ = std::fs::remove_file(data.path().join(format!("jobs.sqlite{end}")));
    }
    let found = diagnosis(data.path());
    assert_eq!((found.store.len(), found.without_job.len()), (1, 1), "{found:?}");
    assert!(Path::new(&found.without_job[0].place).exists() && !data.path().join("jobs.sqlite").exists());
    let server = Server::on(data, |_| {});
    assert!(server.client().get("/v1/jobs").json()["jobs"].as_array().unwrap().is_empty());
    let mut left = server.files();
    left.sort();
    kept.sort();
    assert_eq!(left, kept);
}

/// A service that ran a job and was killed; and its job.
fn killed_after_a_job(data: &Path) -> String {
    let scene = serde_json::from_str(include_str!("../recording/small_ball_on_block.json")).unwrap();
    let program = Program::start(data, &[]);
    let (job, _) = finished(&program.client, &scene);
    program.kill();
    job
}

#[test]
fn a_lost_log_is_reported_at_the_start_and_by_the_doctor() {
    let data = tempfile::tempdir().unwrap();
    killed_after_a_job(data.path());
    // Killed, with its log: nothing is lost.
    assert!(diagnosis(data.path()).is_sound());
    let job = killed_after_a_job(data.path());
    let log = data.path().join("jobs.sqlite-wal");
    let length = std::fs::metadata(&log).unwrap().len();
    let removed = || std::fs::remove_file(&log).unwrap();
    let shortened =
        |length| std::fs::File::options().write(true).open(&log).unwrap().set_len(length).unwrap();
    let ways: [(&str, &dyn Fn()); 3] =
        [("cut", &|| shortened(length / 2)), ("emptied", &|| shortened(0)), ("removed", &removed)];
    for (way, lose) in ways {
        lose();
        let _ = std::fs::remove_file(data.path().join("jobs.sqlite-shm"));
        let copy = tempfile::tempdir().unwrap();
        let folder = data.path().join(".");
        assert!(Command::new("cp").arg("-a").arg(folder).arg(copy.path()).status().unwrap().success());
        // The second time as the first.
        diagnosis(copy.path());
        let found = diagnosis(copy.path());
        let is_reported = found.store.len() == 1 && found.store[0].contains("the log of jobs.sqlite is lost");
        assert!(is_reported, "{way}: {found:?}");
        // The recording of the job that went with the log can still be had.
        let recordings = found.without_job.iter().filter(|lost| lost.readable.is_ok()).count();
        assert!(recordings == 1 || way == "cut", "{way}: {found:?}");
    }
    let mut command = Command::new(env!("CARGO_BIN_EXE_contuse"));
    command.args(SERVE).arg(data.path()).stderr(Stdio::piped());
    let mut program = Program::spawn(command);
    assert_eq!(program.client.get(&job).status, 404);
    let log = program.child.stderr.take().unwrap();
    program.terminate();
    let log = std::io::read_to_string(log).unwrap();
    assert!(log.contains("the log of jobs.sqlite is lost") && log.contains("contuse doctor"), "{log}");
    assert!(diagnosis(data.path()).store.is_empty(), "reported once");
}

#[test]
fn a_log_that_was_emptied_in_order_is_not_lost() {
    let data = tempfile::tempdir().unwrap();
    let program = Program::start(data.path(), &[]);
    let scene = serde_json::from_str(include_str!("../recording/small_ball_on_block.json")).unwrap();
    let (job, _) = finished(&program.client, &scene);
    // What is erased is erased from the log, too.
    assert_eq!(program.client.delete(&job).status, 204);
    let log = data.path().join("jobs.sqlite-wal");
    eventually("the log is empty", || std::fs::metadata(&log).unwrap().len() == 0);
    program.kill();
    assert!(diagnosis(data.path()).is_sound());
}

#[test]
fn a_damaged_store_is_a_finding() {
    let data = tempfile::tempdir().unwrap();
    std::fs::write(data.path().join("jobs.sqlite"), "this is no store of jobs".repeat(1000)).unwrap();
    let found = diagnosis(data.path());
    assert_eq!(found.store.len(), 1, "{found:?}");
    let busy = Server::start();
    assert!(run(examine(&StoreAddress::in_folder(busy.data.path()))).is_err(), "a service uses it");
}
