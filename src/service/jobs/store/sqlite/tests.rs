//! Properties of SQLite that the guarantees of the store rely on.

use super::super::tests::damaged::{check_damaged, check_wrong_clock};
use super::super::tests::upgraded::{COUNTED, Words, check_upgraded, filling};
use super::super::tests::{check, new, queue_of, submitted};
use super::*;
use crate::mesh::read::MeshFormat;
use crate::service::jobs::store::{JobStore as _, NewJob, Page, Quotas, Submitted};
use crate::service::jobs::{JobId, JobKind, JobState, Phase};
use futures::future::join_all;
use sqlx::{AssertSqlSafe, SqlitePool};
use std::cell::Cell;

async fn store() -> (tempfile::TempDir, SqliteStore) {
    let dir = tempfile::tempdir().unwrap();
    let store = SqliteStore::open(&dir.path().join("jobs.sqlite")).await.unwrap();
    (dir, store)
}

#[tokio::test]
async fn it_keeps_what_a_store_promises() {
    let (dir, count) = (tempfile::tempdir().unwrap(), Cell::new(0));
    check(async || {
        let file = dir.path().join(format!("{}.sqlite", count.replace(count.get() + 1)));
        SqliteStore::open(&file).await.unwrap()
    })
    .await;
}

#[tokio::test]
async fn jobs_of_before_there_were_kinds_are_known_by_their_documents() {
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
    sqlx::query("UPDATE jobs SET phase = 'settling'").execute(&pool).await.unwrap();
    pool.close().await;

    let store = SqliteStore::open(&file).await.unwrap();
    let row = store.job("anna", JobId::from_u128(0)).await.unwrap().unwrap();
    assert_eq!(row.phase, Phase::DynamicRelaxation, "under its former name");
    let mut kinds = Vec::new();
    for id in 0..4 {
        kinds.push(store.document("anna", JobId::from_u128(id)).await.unwrap().unwrap().0);
    }
    assert_eq!(kinds, [JobKind::Simulation, JobKind::Study, JobKind::WhatIf, JobKind::Simulation]);
}

#[tokio::test]
async fn a_filled_store_of_each_earlier_version_is_taken_up() {
    for version in 1..migrations().migrations.len() {
        let dir = tempfile::tempdir().unwrap();
        let file = dir.path().join("jobs.sqlite");
        let options = SqliteConnectOptions::new().filename(&file).create_if_missing(true);
        let pool = SqlitePool::connect_with(options).await.unwrap();
        let mut earlier = migrations();
        earlier.migrations.to_mut().truncate(version);
        earlier.run(&pool).await.unwrap();
        let words = Words { document: "CAST('{}' AS BLOB)", yes: "1", further: ("", "") };
        let counted = (version >= 8).then(|| COUNTED.to_owned());
        for statement in filling(&words).into_iter().chain(counted) {
            sqlx::query(AssertSqlSafe(statement)).execute(&pool).await.unwrap();
        }
        pool.close().await;
        let store = SqliteStore::open(&file).await.unwrap();
        check_upgraded(&store).await;
        store.close().await;
    }
}

#[tokio::test]
async fn a_damaged_row_does_not_stop_the_others() {
    let (_dir, store) = store().await;
    let damages = [
        "id = 'x' || seq",
        "id = CAST('x' || seq AS BLOB)",
        "owner = x'ff'",
        "attempts = 'x'",
        "attempts = 1099511627776",
        "memory_bytes = 'x'",
        "trace = x'ff'",
        "scene = 7, warnings = '{'",
    ];
    check_damaged(&store, async |change| set(&store, change).await, &damages).await;
}

#[tokio::test]
async fn damaged_rows_hide_neither_jobs_nor_meshes_nor_the_age_of_the_queue() {
    let (_dir, store) = store().await;
    let report =
        serde_json::from_str(include_str!("../../../../../api/examples/mesh.response.json")).unwrap();
    for id in ["0a", "0b"] {
        store.add_mesh("anna", id, MeshFormat::Gmsh, 1, &report, Quotas::NONE).await.unwrap();
    }
    let oldest = submitted(&store, "oldest").await;
    submitted(&store, "a").await;
    let good = submitted(&store, "b").await;
    set(&store, "UPDATE jobs SET priority = 'x', created_at = 'x' WHERE name = 'a'".into()).await;
    set(&store, "UPDATE waiting_counts SET n = 2".into()).await;
    set(&store, "INSERT INTO waiting_counts (owner, priority, n) VALUES ('anna', 'x', 1)".into()).await;
    set(&store, "UPDATE meshes SET bytes = 'x' WHERE id = '0a'".into()).await;
    let jobs = store.jobs("anna", &Page { states: vec![], before: None, limit: 10 }).await.unwrap();
    // Nor the next page.
    let first = store.jobs("anna", &Page { states: vec![], before: Some(good.seq), limit: 1 }).await.unwrap();
    assert!(first.iter().map(|job| job.seq).eq([oldest.seq]));
    let positions: Vec<_> = jobs.iter().map(|job| (job.id, job.queue_position)).collect();
    assert_eq!(positions, [(good.id, Some(2)), (oldest.id, Some(1))]);
    let meshes = store.meshes("anna", "", 1).await.unwrap();
    assert_eq!(meshes.iter().map(|mesh| mesh.id.as_str()).collect::<Vec<_>>(), ["0b"]);
    assert!(store.queue_age_s().await.unwrap() >= 0.0);
}

#[tokio::test]
async fn all_that_has_ended_is_found_with_a_wrong_clock() {
    let (_dir, store) = store().await;
    check_wrong_clock(&store, async |change| set(&store, change).await).await;
}

async fn set(store: &SqliteStore, change: String) {
    sqlx::query(AssertSqlSafe(change)).execute(&store.pool).await.unwrap();
}

#[tokio::test]
async fn synchronous_is_full_and_the_journal_is_written_ahead() {
    let (_dir, store) = store().await;
    let mut change = store.begin().await.unwrap();
    let (synchronous,): (i64,) = sqlx::query_as("PRAGMA synchronous").fetch_one(&mut *change).await.unwrap();
    let (journal,): (String,) = sqlx::query_as("PRAGMA journal_mode").fetch_one(&mut *change).await.unwrap();
    assert_eq!((synchronous, journal.as_str()), (2, "wal"));
}

#[tokio::test]
async fn changes_that_wait_share_a_transaction_and_each_has_its_own_outcome() {
    let (_dir, store) = store().await;
    let ended = store.turn.ended().await;
    let first = store.begin().await.unwrap();
    let another = new("another");
    let waiting = join_all((0..12).map(|_| store.submit(&another, queue_of(10))));
    let release = async {
        // Until all wait.
        for _ in 0..100 {
            tokio::task::yield_now().await;
        }
        drop(first);
    };
    let (answers, ()) = futures::join!(waiting, release);
    let positions: Vec<_> = answers
        .into_iter()
        .filter_map(|answer| match answer {
            Ok(Submitted::Created(job)) => job.queue_position,
            other => {
                assert!(matches!(other, Err(JobsError::QueueFull { waiting: 10 })), "{other:?}");
                None
            }
        })
        .collect();
    assert_eq!(positions, (1..=10).collect::<Vec<_>>());
    assert_eq!(store.turn.ended().await - ended, 2, "the first one, and that of all others");
    assert_eq!(store.counts().await.unwrap()[0], (JobState::Queued, 10), "seen by readers");
}

#[tokio::test]
async fn a_change_that_is_given_up_is_undone_alone() {
    let (_dir, store) = store().await;
    let job = submitted(&store, "a").await;
    let mut given_up = store.begin().await.unwrap();
    let submission = new("b");
    let next = async {
        sqlx::query("DELETE FROM jobs").execute(&mut *given_up).await.unwrap();
        drop(given_up);
    };
    let (submitted, ()) = futures::join!(store.submit(&submission, queue_of(10)), next);
    assert!(matches!(submitted.unwrap(), Submitted::Created(_)));
    assert!(store.job("anna", job.id).await.unwrap().is_some());
}

#[tokio::test]
async fn a_lost_connection_is_that_of_its_changes_and_is_opened_again() {
    let (_dir, store) = store().await;
    let mut change = store.begin().await.unwrap();
    // As SQLite does by itself when a disk fails.
    sqlx::query("ROLLBACK").execute(&mut *change).await.unwrap();
    let error = change.commit().await.unwrap_err();
    assert!(matches!(error, JobsError::Store { .. }), "{error}");
    let job = submitted(&store, "a").await;
    assert!(store.job("anna", job.id).await.unwrap().is_some());
    store.close().await;
    assert!(store.submit(&new("b"), queue_of(10)).await.is_err());
}

#[tokio::test]
async fn a_full_disk_is_reported_and_forgotten_when_there_is_room() {
    let (_dir, store) = store().await;
    submitted(&store, "a").await;
    // The next write finds the disk full, and SQLite itself ends the transaction.
    store.turn.set("PRAGMA max_page_count = 1").await.unwrap();
    let large = NewJob { document: vec![b' '; 1 << 20], ..new("large") };
    let error = store.submit(&large, queue_of(10)).await.unwrap_err();
    assert!(error.is_storage_full(), "{error}");
    // On the connection concerned, or on a new one in its place.
    store.turn.set("PRAGMA max_page_count = 1000000").await.unwrap();
    assert!(matches!(store.submit(&large, queue_of(10)).await.unwrap(), Submitted::Created(_)));
    store.try_write().await.unwrap();
    assert_eq!(store.claim(None).await.unwrap().unwrap().seq, 1);
}
