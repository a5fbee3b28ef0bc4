//! What stores of earlier versions hold, and what this version finds in them.

use super::*;
use crate::service::jobs::Phase;

/// What a database says in its own way.
pub struct Words {
    /// The document of every job, `{}`.
    pub document: &'static str,
    pub yes: &'static str,
    /// Columns that have no default in the first version, each with a leading comma, and their values.
    pub further: (&'static str, &'static str),
}

const FAILURE: &str =
    r#"{"cause": "internal", "message": "m", "remedy": "r", "time_s": null, "step": null, "element": null}"#;

/// What versions that count what a job keeps have counted: a statement after [`filling`].
pub const COUNTED: &str = "UPDATE jobs SET kept_bytes = length(scene) + COALESCE(length(summary), 0) + COALESCE(recording_bytes, 0)";

/// Jobs in every state, one of them hidden, with events, and a mesh: in columns that all versions have.
pub fn filling(words: &Words) -> Vec<String> {
    let Words { document, yes, further: (columns, values) } = words;
    let failure = format!("'{FAILURE}'");
    let ended = "'2026-01-01T00:00:00.000Z'";
    let job = |id: u32, owner: &str, state: &str, rest: [&str; 5]| {
        let [key, ended, failure, summary, hidden] = rest;
        let recording =
            if summary == "NULL" { "NULL, NULL, NULL".into() } else { format!("1000, 'ab', {yes}") };
        format!(
            "INSERT INTO jobs (id, owner, body_sha256, scene, name, content_hash, end_time_s, warnings, state, attempts, idempotency_key,
                 finished_at, failure, summary, deleted, recording_bytes, recording_sha256, recording_complete {columns})
             VALUES ('{}', '{owner}', 'body', {document}, 'job {id}', 'hash', 1, '[]', '{state}', 1, {key}, {ended}, {failure}, {summary},
                 {hidden}, {recording} {values})",
            JobId::from_u128(id.into()),
        )
    };
    let no = "NULL";
    let mesh: serde_json::Value =
        serde_json::from_str(include_str!("../../../../../api/examples/mesh.response.json")).unwrap();
    let mut statements = vec![
        job(1, "anna", "succeeded", [no, ended, no, "'{}'", "0"]),
        job(2, "anna", "failed", [no, ended, &failure, no, "0"]),
        job(3, "bert", "cancelled", [no, ended, no, no, "0"]),
        job(4, "anna", "running", [no, no, no, no, "0"]),
        job(5, "anna", "queued", [no, no, no, no, "0"]),
        job(6, "bert", "queued", ["'key'", no, no, no, "0"]),
        job(7, "anna", "queued", [no, no, no, no, "1"]),
        format!(
            "INSERT INTO meshes (id, owner, format, bytes, report) VALUES ('0a', 'anna', 'msh', 8, '{mesh}')"
        ),
    ];
    let events = [(1, 1, "queued"), (1, 2, "running"), (1, 3, "succeeded"), (5, 1, "queued")];
    statements.extend(events.map(|(job, n, kind)| {
        format!("INSERT INTO events (job, n, kind, data) VALUES ({job}, {n}, '{kind}', '{{}}')")
    }));
    statements
}

/// Checks a store that held [`filling`] under an earlier version, and works on with it.
pub async fn check_upgraded(store: &dyn JobStore) {
    let id = |n: u32| JobId::from_u128(n.into());
    // All is there.
    assert_eq!(store.faults().await.unwrap(), (vec![], vec![]));
    let counts: Vec<u64> = store.counts().await.unwrap().into_iter().map(|(_, n)| n).collect();
    assert_eq!(counts, [2, 1, 1, 1, 1]);
    let page = Page { states: vec![], before: None, limit: 10 };
    let of_anna: Vec<i64> = store.jobs("anna", &page).await.unwrap().iter().map(|job| job.seq).collect();
    assert_eq!(of_anna, [5, 4, 2, 1]);
    let done = store.job("anna", id(1)).await.unwrap().unwrap();
    let recording = done.recording.unwrap();
    assert_eq!((done.state, recording.bytes, recording.complete), (JobState::Succeeded, 1000, true));
    assert_eq!(store.summary("anna", id(1)).await.unwrap().as_deref(), Some("{}"));
    assert_eq!(store.document("anna", id(1)).await.unwrap(), Some((JobKind::Simulation, b"{}".to_vec())));
    let failed = store.job("anna", id(2)).await.unwrap().unwrap();
    assert_eq!((failed.failure.unwrap().message.as_str(), failed.phase), ("m", Phase::Waiting));
    let (events, is_over) = store.events_after(1, 0, 10).await.unwrap();
    assert_eq!((events.len(), is_over), (3, true));
    assert_eq!(store.mesh("anna", "0a").await.unwrap().unwrap().bytes, 8);
    let replayed = store.replay("bert", "key", "body").await.unwrap();
    assert!(matches!(replayed, Some(Submitted::Replayed(job)) if job.id == id(6)));
    // What owners keep is known: six documents of anna, one of them hidden, a summary, a recording and a mesh.
    let keeping = |bytes| Quotas { bytes_of_owner: bytes, ..Quotas::NONE };
    let new_job = NewJob { kind: JobKind::Simulation, ..new("new") };
    assert!(matches!(store.submit(&new_job, keeping(1021)).await, Err(JobsError::OwnerKeeps { .. })));
    let Submitted::Created(new) = store.submit(&new_job, keeping(1022)).await.unwrap() else {
        panic!("no new job")
    };
    assert_eq!((new.seq > 7, new.queue_position), (true, Some(2)));
    // What was lost or hidden is found, and all that waits is run: owners take turns.
    let orphans = store.orphans().await.unwrap();
    let found: Vec<_> = orphans.iter().map(|orphan| (orphan.seq, orphan.request)).collect();
    assert_eq!(found, [(4, OwnerRequest::Result), (7, OwnerRequest::Deletion)]);
    store.erase(7).await.unwrap();
    assert!(store.requeue(4, 1, Requeued::WorkerLost).await.unwrap());
    let mut claimed = Vec::new();
    while let Some(job) = store.claim(None).await.unwrap() {
        claimed.push(job.seq);
        let end = JobEnd {
            ending: crate::step::Ending::Finished,
            summary: None,
            headline: None,
            recording: None,
            progress: None,
        };
        assert!(store.finish(job.seq, job.attempt, &end).await.unwrap());
    }
    assert_eq!(claimed, [4, 6, 5, new.seq]);
    let counts: Vec<u64> = store.counts().await.unwrap().into_iter().map(|(_, n)| n).collect();
    assert_eq!(counts, [0, 0, 5, 1, 1]);
}
