//! How often a job parses documents, loads scenes and compiles plans: once each for its validation and its run, and once more for what its runs
//! do not share.

// A test fails by panicking, also in the functions that it calls; and not all that the tests of the API share is of use here.
#![allow(clippy::unwrap_used, clippy::format_push_string, dead_code)]

#[path = "api/support/mod.rs"]
mod support;

use contuse::service::config::RunConfig;
use contuse::service::jobs::simulator::Simulator;
use serde_json::{Value, json};
use std::collections::BTreeMap;
use std::sync::{Arc, Mutex};
use support::{Server, finished, wait_for};
use tracing::Subscriber;
use tracing::span::{Attributes, Id};
use tracing_subscriber::layer::{Context, Layer, SubscriberExt};
use tracing_subscriber::util::SubscriberInitExt;

/// Counts spans by their names.
#[derive(Clone, Default)]
struct Counter(Arc<Mutex<BTreeMap<&'static str, usize>>>);

impl<S: Subscriber> Layer<S> for Counter {
    fn on_new_span(&self, span: &Attributes<'_>, _: &Id, _: Context<'_, S>) {
        *self.0.lock().unwrap().entry(span.metadata().name()).or_default() += 1;
    }
}

impl Counter {
    /// Parses, loads and compilations since the last look.
    fn take(&self) -> [usize; 3] {
        let counts = std::mem::take(&mut *self.0.lock().unwrap());
        ["parse", "load", "compile"].map(|name| counts.get(name).copied().unwrap_or(0))
    }
}

#[test]
fn a_job_loads_each_mesh_once_for_its_validation_and_once_for_its_run() {
    let counter = Counter::default();
    tracing_subscriber::registry().with(counter.clone()).init();
    // In this process, where it can be counted.
    let engine = Simulator::new(&RunConfig::default());
    let server = Server::with_engine(Arc::new(tempfile::tempdir().unwrap()), Arc::new(engine), |_| {});
    let client = server.client();
    let scene = std::fs::read_to_string("scenarios/flashball_thigh/scene_elastic.json").unwrap();
    let mut scene: Value = serde_json::from_str(&scene).unwrap();

    // Error bars come from three runs on one coarser mesh; that of half the elements is refused, the next one is not.
    finished(&client, &scene);
    assert_eq!(counter.take(), [2, 4, 4]);
    scene["solver"] = json!({"error_bars": "none"});
    finished(&client, &scene);
    assert_eq!(counter.take(), [2, 2, 1]);

    // Cases that differ in their motion share a scene; the kept text of the question is read again. Two threads have a plan each.
    let question = json!({
        "scene": scene,
        "parameters": [{"name": "speed", "change": {"kind": "speed_m_per_s"}, "low": 80, "high": 100}],
        "one_at_a_time": true,
        "error_bars": "none"
    });
    let answer = client.post_json("/v1/what-if", &question);
    assert_eq!(answer.status, 202, "{answer:?}");
    wait_for(&client, answer.header("location").unwrap(), "succeeded");
    let [parses, loads, compilations] = counter.take();
    assert_eq!((parses, loads), (2, 2));
    assert!(compilations <= 3, "{compilations}");
}
