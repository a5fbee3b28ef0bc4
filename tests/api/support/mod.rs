//! A service in this process with a scripted engine, and a client that sees every header.

pub mod client;
pub mod engine;
pub mod program;

use client::{Answer, Client};
use contuse::service::Service;
use contuse::service::config::{RunConfig, ServiceConfig};
use contuse::service::jobs::engine::Engine;
use contuse::service::jobs::process::ProcessEngine;
pub use contuse::service::jobs::store::StoreAddress;
use engine::ScriptedEngine;
use serde_json::{Value, json};
use std::net::SocketAddr;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::{Duration, Instant};
use tempfile::TempDir;
use tokio::sync::oneshot;

/// A service that stops when it is dropped.
pub struct Server {
    pub address: SocketAddr,
    pub data: Arc<TempDir>,
    stop: Option<oneshot::Sender<()>>,
    thread: Option<std::thread::JoinHandle<()>>,
}

impl Server {
    pub fn start() -> Self {
        Self::with(|_| {})
    }

    pub fn with(change: impl FnOnce(&mut ServiceConfig)) -> Self {
        Self::on(Arc::new(tempfile::tempdir().unwrap()), change)
    }

    /// On a data folder that another service may have left.
    pub fn on(data: Arc<TempDir>, change: impl FnOnce(&mut ServiceConfig)) -> Self {
        Self::with_engine(data, Arc::new(ScriptedEngine), change)
    }

    /// With the engine that ships.
    pub fn simulating() -> Self {
        Self::running(Path::new(env!("CARGO_BIN_EXE_contuse")), |_| {})
    }

    /// With the engine that ships, which runs jobs as processes of a program.
    pub fn running(program: &Path, change: impl FnOnce(&mut ServiceConfig)) -> Self {
        let engine = ProcessEngine::new(&RunConfig::default(), program, None);
        Self::with_engine(Arc::new(tempfile::tempdir().unwrap()), Arc::new(engine), change)
    }

    pub fn with_engine(
        data: Arc<TempDir>,
        engine: Arc<dyn Engine>,
        change: impl FnOnce(&mut ServiceConfig),
    ) -> Self {
        let mut config = ServiceConfig {
            listen: SocketAddr::from(([127, 0, 0, 1], 0)),
            store: StoreAddress::in_folder(data.path()),
            workers: 1,
            grace: Duration::from_millis(200),
            ..ServiceConfig::default()
        };
        change(&mut config);
        let (started, address) = std::sync::mpsc::channel();
        let (stop, stopped) = oneshot::channel();
        let thread = std::thread::spawn(move || {
            let runtime =
                tokio::runtime::Builder::new_multi_thread().worker_threads(2).enable_all().build().unwrap();
            runtime.block_on(async move {
                let service = Service::start(config, engine).await.unwrap();
                started.send(service.address()).unwrap();
                let stop = async {
                    let _ = stopped.await;
                };
                service.run_until(stop, std::future::pending()).await;
            });
        });
        Self { address: address.recv().unwrap(), data, stop: Some(stop), thread: Some(thread) }
    }

    pub fn client(&self) -> Client {
        Client::new(self.address)
    }

    /// Shuts down in order, and gives the data folder back.
    pub fn stop(mut self) -> Arc<TempDir> {
        self.halt();
        Arc::clone(&self.data)
    }

    /// The files that it keeps, of the job store apart.
    pub fn files(&self) -> Vec<PathBuf> {
        let (mut folders, mut files) = (vec![self.data.path().to_owned()], Vec::new());
        while let Some(folder) = folders.pop() {
            for entry in std::fs::read_dir(folder).unwrap() {
                let path = entry.unwrap().path();
                if path.is_dir() { folders.push(path) } else { files.push(path) }
            }
        }
        let is_store =
            |path: &PathBuf| matches!(path.file_stem().unwrap().to_str(), Some("lock" | "jobs" | "audit"));
        files.into_iter().filter(|path| !is_store(path)).collect()
    }

    fn halt(&mut self) {
        if let Some(stop) = self.stop.take() {
            let _ = stop.send(());
        }
        if let Some(thread) = self.thread.take() {
            thread.join().unwrap();
        }
    }
}

impl Drop for Server {
    fn drop(&mut self) {
        self.halt();
    }
}

/// A scene of the scripted engine that ends at once.
pub fn quick() -> Value {
    json!({ "name": "quick", "end_time_s": 1e-3, "steps": 3, "step_ms": 0 })
}

/// A scene that runs until it is stopped (a minute at most).
pub fn endless() -> Value {
    json!({ "name": "endless", "end_time_s": 1.0, "steps": 60_000, "step_ms": 1 })
}

/// Submits a scene and gives the address of the job.
pub fn submit(client: &Client, scene: &Value) -> String {
    let answer = client.post_json("/v1/jobs", scene);
    assert_eq!(answer.status, 202, "{answer:?}");
    answer.header("location").unwrap().to_owned()
}

/// Waits until a job is in a state.
pub fn wait_for(client: &Client, job: &str, state: &str) -> Value {
    let limit = Instant::now() + Duration::from_secs(300);
    loop {
        let answer = client.get(job);
        assert_eq!(answer.status, 200, "{answer:?}");
        let job_now = answer.json();
        if job_now["state"] == state {
            return job_now;
        }
        let is_final = ["succeeded", "failed", "cancelled"].iter().any(|s| job_now["state"] == *s);
        assert!(!is_final, "ended as {job_now} and not as {state}");
        assert!(Instant::now() < limit, "still {job_now} and not {state}");
        std::thread::sleep(Duration::from_millis(10));
    }
}

/// Runs a scene to its end.
pub fn finished(client: &Client, scene: &Value) -> (String, Value) {
    let job = submit(client, scene);
    let end = wait_for(client, &job, "succeeded");
    (job, end)
}

/// Waits until something holds.
pub fn eventually(what: &str, mut holds: impl FnMut() -> bool) {
    let limit = Instant::now() + Duration::from_secs(300);
    while !holds() {
        assert!(Instant::now() < limit, "never: {what}");
        std::thread::sleep(Duration::from_millis(10));
    }
}

/// Checks that an answer is a problem of a kind, and gives its body.
pub fn problem(answer: &Answer, status: u16, kind: &str) -> Value {
    assert_eq!(answer.status, status, "{answer:?}");
    assert_eq!(answer.header("content-type"), Some("application/problem+json"), "{answer:?}");
    let body = answer.json();
    assert_eq!(body["type"], format!("urn:contuse:problem:{kind}"), "{body}");
    assert_eq!(body["status"], status);
    assert!(body["title"].is_string() && body["detail"].is_string(), "{body}");
    body
}

/// Whether a text names a path of this machine.
pub fn leaks(text: &str, data: &Path) -> bool {
    text.contains(data.to_str().unwrap()) || text.contains("/src/") || text.contains("sqlite")
}
