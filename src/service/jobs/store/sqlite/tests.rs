//! What the store promises, without HTTP.

use super::*;
use crate::service::jobs::verdict::RunEnding;
use crate::service::jobs::{JobFailure, JobFailureCause, JobKind, Phase};

async fn store() -> (tempfile::TempDir, SqliteStore) {
    let dir = tempfile::tempdir().unwrap();
    let store = SqliteStore::open(&dir.path().join("jobs.sqlite")).await.unwrap();
    (dir, store)
}

fn new(name: &str) -> NewJob {
    NewJob {
        owner: "anna".into(),
        idempotency_key: None,
        body_sha256: "0".into(),
        kind: JobKind::Study,
        document: b"{}".to_vec(),
        name: name.into(),
        content_hash: "0".into(),
        end_time_s: 1.0,
        warnings: vec![],
    }
}

async fn submitted(store: &SqliteStore, name: &str) -> JobRow {
    match store.submit(&new(name), 10).await.unwrap() {
        Submitted::Created(row) => *row,
        other => panic!("{other:?}"),
    }
}

fn end(ending: RunEnding) -> JobEnd {
    JobEnd { ending, summary: None, recording: None, progress: None }
}

#[tokio::test]
async fn jobs_are_claimed_once_in_the_order_of_their_coming() {
    let (_dir, store) = store().await;
    for name in ["a", "b", "c"] {
        submitted(&store, name).await;
    }
    let claims = futures::future::join_all((0..5).map(|_| store.claim())).await;
    let mut seqs: Vec<i64> = claims.into_iter().filter_map(|c| c.unwrap()).map(|c| c.seq).collect();
    seqs.sort_unstable();
    assert_eq!(seqs, [1, 2, 3]);
    assert!(store.claim().await.unwrap().is_none());
}

#[tokio::test]
async fn attempt_that_is_over_changes_nothing() {
    let (_dir, store) = store().await;
    let job = submitted(&store, "a").await;
    let first = store.claim().await.unwrap().unwrap();
    store.requeue(first.seq, first.attempt, Requeued::WorkerLost).await.unwrap();
    let second = store.claim().await.unwrap().unwrap();
    assert_eq!((first.attempt, second.attempt), (1, 2));

    let progress = Progress::at(Phase::Stepping, 0.5, 0, 0.0);
    store.record_progress(first.seq, first.attempt, &progress).await.unwrap();
    assert!(!store.finish(first.seq, first.attempt, &end(RunEnding::Finished)).await.unwrap());
    store.requeue(first.seq, first.attempt, Requeued::Shutdown).await.unwrap();
    let row = store.job("anna", job.id).await.unwrap().unwrap();
    assert_eq!((row.state, row.progress.progress), (JobState::Running, 0.0));

    assert!(store.finish(second.seq, second.attempt, &end(RunEnding::Finished)).await.unwrap());
    assert!(
        !store
            .finish(second.seq, second.attempt, &end(RunEnding::Failed(JobFailure::internal())))
            .await
            .unwrap()
    );
    let row = store.job("anna", job.id).await.unwrap().unwrap();
    assert_eq!((row.state, row.progress.progress), (JobState::Succeeded, 1.0));
    let (events, ended) = store.events_after(job.seq, 0, 100).await.unwrap();
    let kinds: Vec<&str> = events.iter().map(|e| e.kind.as_str()).collect();
    assert_eq!(kinds, ["queued", "running", "requeued", "running", "succeeded"]);
    assert!(ended);
}

#[tokio::test]
async fn orphans_are_those_without_a_worker_and_those_that_were_hidden() {
    let (_dir, store) = store().await;
    let mut jobs = Vec::new();
    for name in ["again", "cancelled", "deleted", "poison", "waiting"] {
        jobs.push(submitted(&store, name).await);
    }
    for _ in 0..4 {
        store.claim().await.unwrap().unwrap();
    }
    assert_eq!(store.cancel("anna", jobs[1].id).await.unwrap(), CancelAnswer::Stopping);
    let deleted = store.hide("anna", jobs[2].id).await.unwrap();
    assert_eq!(deleted, DeleteAnswer::Running { seq: jobs[2].seq });
    let wishes: Vec<OwnerWish> =
        store.orphans().await.unwrap().into_iter().map(|orphan| orphan.wish).collect();
    assert_eq!(wishes, [OwnerWish::Result, OwnerWish::Stop, OwnerWish::Deletion, OwnerWish::Result]);
    assert_eq!(store.wish(jobs[1].seq).await.unwrap(), OwnerWish::Stop);
    assert_eq!(store.wish(99).await.unwrap(), OwnerWish::Deletion);

    let lost = RunEnding::Failed(JobFailure::worker_lost(1));
    assert!(store.finish(jobs[3].seq, 1, &end(lost)).await.unwrap());
    let row = store.job("anna", jobs[3].id).await.unwrap().unwrap();
    assert_eq!(row.failure.unwrap().cause, JobFailureCause::WorkerLost);
}

#[tokio::test]
async fn what_a_job_is_for_is_read_back() {
    let (_dir, store) = store().await;
    let job = submitted(&store, "a").await;
    assert_eq!(store.document("anna", job.id).await.unwrap().unwrap(), (JobKind::Study, b"{}".to_vec()));
    assert_eq!(store.claim().await.unwrap().unwrap().kind, JobKind::Study);
}

#[tokio::test]
async fn jobs_of_before_there_were_kinds_are_told_by_their_documents() {
    let dir = tempfile::tempdir().unwrap();
    let file = dir.path().join("jobs.sqlite");
    let documents = [
        r#"{"name": "kind", "bodies": []}"#,
        r#"{"kind": "stability"}"#,
        r#"{"scene": {}, "parameters": []}"#,
        "no JSON",
    ];
    let options = SqliteConnectOptions::new().filename(&file).create_if_missing(true);
    let pool = SqlitePool::connect_with(options).await.unwrap();
    let mut first = migrations();
    first.migrations.to_mut().truncate(1);
    first.run(&pool).await.unwrap();
    for (id, document) in documents.iter().enumerate() {
        sqlx::query(
            "INSERT INTO jobs (id, owner, body_sha256, scene, name, content_hash, end_time_s, warnings)
             VALUES (?1, 'anna', '', ?2, '', '', 1, '[]')",
        )
        .bind(JobId::from_u128(id as u128).to_string())
        .bind(document.as_bytes())
        .execute(&pool)
        .await
        .unwrap();
    }
    pool.close().await;

    let store = SqliteStore::open(&file).await.unwrap();
    let mut kinds = Vec::new();
    for id in 0..4 {
        kinds.push(store.document("anna", JobId::from_u128(id)).await.unwrap().unwrap().0);
    }
    assert_eq!(kinds, [JobKind::Simulation, JobKind::Study, JobKind::WhatIf, JobKind::Simulation]);
}

#[tokio::test]
async fn queue_has_an_end() {
    let (_dir, store) = store().await;
    store.submit(&new("a"), 1).await.unwrap();
    assert!(matches!(store.submit(&new("b"), 1).await, Err(JobsError::QueueFull { waiting: 1 })));
}

#[tokio::test]
async fn owners_do_not_see_each_other() {
    let (_dir, store) = store().await;
    let job = submitted(&store, "a").await;
    assert!(store.job("bert", job.id).await.unwrap().is_none());
    assert_eq!(store.cancel("bert", job.id).await.unwrap(), CancelAnswer::Unknown);
    assert_eq!(store.hide("bert", job.id).await.unwrap(), DeleteAnswer::Unknown);
    let page = Page { states: vec![], before: None, limit: 10 };
    assert!(store.jobs("bert", &page).await.unwrap().is_empty());
    assert_eq!(store.jobs("anna", &page).await.unwrap().len(), 1);
}

#[tokio::test]
async fn synchronous_is_full_and_the_journal_is_written_ahead() {
    let (_dir, store) = store().await;
    let mut connection = store.pool.acquire().await.unwrap();
    let (synchronous,): (i64,) =
        sqlx::query_as("PRAGMA synchronous").fetch_one(&mut *connection).await.unwrap();
    let (journal,): (String,) =
        sqlx::query_as("PRAGMA journal_mode").fetch_one(&mut *connection).await.unwrap();
    assert_eq!((synchronous, journal.as_str()), (2, "wal"));
}

#[tokio::test]
async fn a_full_disk_is_told_and_forgotten_when_there_is_room() {
    let (_dir, store) = store().await;
    submitted(&store, "a").await;
    // Every connection of the pool gets as many pages as there are: the next one finds the disk full, and SQLite itself ends the
    // transaction.
    set_everywhere(&store, "PRAGMA max_page_count = 1").await;
    let large = NewJob { document: vec![b' '; 1 << 20], ..new("large") };
    let error = store.submit(&large, 10).await.unwrap_err();
    assert!(error.is_storage_full(), "{error}");
    // On the connections that it happened to, or on fresh ones in their place.
    set_everywhere(&store, "PRAGMA max_page_count = 1000000").await;
    assert!(matches!(store.submit(&large, 10).await.unwrap(), Submitted::Created(_)));
    store.try_write().await.unwrap();
    assert_eq!(store.claim().await.unwrap().unwrap().seq, 1);
}

/// Sets something on all connections that the pool may have.
async fn set_everywhere(store: &SqliteStore, pragma: &'static str) {
    let mut all = Vec::new();
    for _ in 0..8 {
        let mut connection = store.pool.acquire().await.unwrap();
        sqlx::query(pragma).execute(&mut *connection).await.unwrap();
        all.push(connection);
    }
}
