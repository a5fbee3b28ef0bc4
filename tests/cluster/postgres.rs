//! The contract, and what processes that share a database rely on. The database is that of `CONTUSE_TEST_POSTGRES`, in which every store
//! gets a schema of its own.

use crate::job_contract::damaged::{check_damaged, check_wrong_clock};
use crate::job_contract::upgraded::{COUNTED, Words, check_upgraded, filling};
use crate::job_contract::{check, new, queue_of, submitted};
use contuse::service::jobs::store::{
    CancelAnswer, Change, JobEnd, JobStore, NewJob, OwnerRequest, PostgresStore, Requeued,
};
use contuse::service::jobs::{JobId, JobState, JobsError};
use contuse::step::Ending;
use futures::StreamExt as _;
use futures::future::{join, join_all};
use sqlx::migrate::Migrator;
use std::collections::BTreeMap;
use std::path::Path;
use std::time::Duration;

const LONG: Duration = Duration::from_secs(60);

/// Address of a new schema; `None`, said aloud, if there is no database for tests.
pub async fn schema() -> Option<String> {
    let url = crate::address("CONTUSE_TEST_POSTGRES")?;
    let name = format!("test_{}", JobId::new_v4().simple());
    let pool = sqlx::PgPool::connect(&url).await.unwrap();
    sqlx::query(sqlx::AssertSqlSafe(format!("CREATE SCHEMA {name}"))).execute(&pool).await.unwrap();
    pool.close().await;
    let mark = if url.contains('?') { '&' } else { '?' };
    Some(format!("{url}{mark}options=-csearch_path%3D{name}"))
}

async fn stores<const N: usize>(lease: Duration) -> Option<[PostgresStore; N]> {
    let url = schema().await?;
    let mut stores = Vec::new();
    for _ in 0..N {
        stores.push(PostgresStore::open(&url, lease).await.unwrap());
    }
    stores.try_into().ok()
}

fn end() -> JobEnd {
    JobEnd { ending: Ending::Finished, summary: None, headline: None, recording: None, progress: None }
}

#[tokio::test]
async fn it_keeps_what_a_store_promises() {
    if schema().await.is_none() {
        return;
    }
    // Leases end at once: every running job is an orphan.
    Box::pin(check(async || PostgresStore::open(&schema().await.unwrap(), Duration::ZERO).await.unwrap()))
        .await;
}

#[tokio::test]
async fn a_filled_database_of_each_earlier_version_is_taken_up() {
    let words = Words {
        document: "convert_to('{}', 'UTF8')",
        yes: "TRUE",
        further: (", kind, memory_bytes, worker, lease_until", ", 'simulation', 0, 'lost', now()"),
    };
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("src/service/jobs/store/postgres/migrations");
    let migrations = Migrator::new(folder).await.unwrap().migrations;
    assert!(migrations.len() > 2);
    for version in 1..migrations.len() {
        let Some(url) = schema().await else { return };
        let pool = sqlx::PgPool::connect(&url).await.unwrap();
        Migrator::with_migrations(migrations[..version].to_vec()).run(&pool).await.unwrap();
        let counted = (version >= 3).then(|| COUNTED.to_owned());
        for statement in filling(&words).into_iter().chain(counted) {
            sqlx::query(sqlx::AssertSqlSafe(statement)).execute(&pool).await.unwrap();
        }
        pool.close().await;
        let store = PostgresStore::open(&url, Duration::from_secs(1)).await.unwrap();
        Box::pin(check_upgraded(&store)).await;
    }
}

#[tokio::test]
async fn a_damaged_row_does_not_stop_the_others() {
    let Some(url) = schema().await else { return };
    let pool = sqlx::PgPool::connect(&url).await.unwrap();
    let change = async |change| {
        sqlx::query(sqlx::AssertSqlSafe(change)).execute(&pool).await.unwrap();
    };
    // Leases end at once.
    let store = PostgresStore::open(&url, Duration::ZERO).await.unwrap();
    check_wrong_clock(&store, &change).await;
    change("DELETE FROM jobs".to_owned()).await;
    let damages = ["id = 'x' || seq", "attempts = 1099511627776", "attempts = 9223372036854775807"];
    check_damaged(&store, &change, &damages).await;
    // Nor does it end the leases of others.
    let jobs = [submitted(&store, "a").await, submitted(&store, "b").await];
    for _ in &jobs {
        store.claim(None).await.unwrap().unwrap();
    }
    change(format!("UPDATE jobs SET attempts = 1099511627776 WHERE seq = {}", jobs[0].seq)).await;
    let renewed = store.shared().unwrap().renew(&jobs.map(|job| job.seq)).await.unwrap();
    assert_eq!(renewed.into_values().collect::<Vec<_>>(), [(1, OwnerRequest::Result)]);
}

#[tokio::test]
async fn what_keeps_a_database_closed_is_reported_without_the_password() {
    let Some(url) = crate::address("CONTUSE_TEST_POSTGRES") else { return };
    let refusal = async |url: &str| {
        let error = PostgresStore::open(url, LONG).await.unwrap_err();
        assert!(matches!(error, JobsError::Database { .. }), "{error}");
        error.to_string()
    };
    let elsewhere = url.replace("/postgres", "/nowhere").replace("contuse@", "contuse:secret@");
    let error = refusal(&elsewhere).await;
    assert!(error.contains("database \"nowhere\" does not exist") && error.contains("createdb"), "{error}");
    let error = refusal(&url.replace("contuse@", "stranger:secret@")).await;
    assert!(error.contains("role \"stranger\" does not exist") && !error.contains("secret"), "{error}");
    // A port on which no one listens.
    let port = std::net::TcpListener::bind("127.0.0.1:0").unwrap().local_addr().unwrap().port();
    let error = refusal(&format!("postgres://contuse:secret@127.0.0.1:{port}/postgres")).await;
    assert!(error.contains("Connection refused") && error.contains("start the server"), "{error}");
    assert!(!error.contains("secret"), "{error}");
}

/// Address of a new database with properties of its own, and a connection to the server.
async fn database(properties: &str) -> Option<(String, String, sqlx::PgPool)> {
    let url = crate::address("CONTUSE_TEST_POSTGRES")?;
    let name = format!("test_{}", JobId::new_v4().simple());
    let server = sqlx::PgPool::connect(&url).await.unwrap();
    ask(&server, format!("CREATE DATABASE {name} {properties}")).await;
    Some((url.replace("/postgres", &format!("/{name}")), name, server))
}

async fn ask(pool: &sqlx::PgPool, statement: String) {
    sqlx::query(sqlx::AssertSqlSafe(statement)).execute(pool).await.unwrap();
}

#[tokio::test]
async fn a_database_that_cannot_store_every_name_is_refused() {
    let latin = "ENCODING 'LATIN1' TEMPLATE template0 LC_COLLATE 'C' LC_CTYPE 'C'";
    let Some((url, ..)) = database(latin).await else { return };
    let error = PostgresStore::open(&url, LONG).await.unwrap_err().to_string();
    assert!(
        error.contains("its encoding is LATIN1") && error.contains("createdb --encoding=UTF8"),
        "{error}"
    );
}

#[tokio::test]
async fn a_database_that_accepts_no_writes_is_noticed() {
    let Some((url, name, server)) = database("").await else { return };
    let store = PostgresStore::open(&url, LONG).await.unwrap();
    store.try_write().await.unwrap();
    ask(&server, format!("ALTER DATABASE {name} SET default_transaction_read_only = on")).await;
    let end = "SELECT pg_terminate_backend(pid) FROM pg_stat_activity WHERE datname";
    ask(&server, format!("{end} = '{name}'")).await;
    let error = store.try_write().await.unwrap_err();
    assert!(error.is_passing(), "{error}");
}

#[tokio::test]
async fn the_default_isolation_of_a_database_does_not_matter() {
    let Some((url, name, server)) = database("").await else { return };
    ask(&server, format!("ALTER DATABASE {name} SET default_transaction_isolation = 'serializable'")).await;
    let store = PostgresStore::open(&url, LONG).await.unwrap();
    let job = new("a");
    for answer in join_all((0..40).map(|_| store.submit(&job, queue_of(100)))).await {
        answer.unwrap();
    }
    let claims = join_all((0..40).map(|_| store.claim(None))).await;
    assert!(claims.into_iter().all(|claim| claim.is_ok()));
}

#[tokio::test]
async fn a_locked_table_is_a_fault_that_passes() {
    let Some(url) = schema().await else { return };
    let store = PostgresStore::open(&url, LONG).await.unwrap();
    let pool = sqlx::PgPool::connect(&url).await.unwrap();
    let mut other = pool.begin().await.unwrap();
    sqlx::query("LOCK TABLE jobs, identity").execute(&mut *other).await.unwrap();
    let (counts, written) = join(store.counts(), store.try_write()).await;
    assert!(counts.unwrap_err().is_passing() && written.unwrap_err().is_passing());
    other.rollback().await.unwrap();
    store.counts().await.unwrap();
}

#[tokio::test]
async fn the_file_of_a_mesh_is_removed_while_no_process_keeps_it() {
    let Some([here, there]) = stores(LONG).await else { return };
    let [here, there] = [&here, &there].map(|store| store.shared().unwrap());
    let kept = [here.lock_mesh("0a", false).await.unwrap(), there.lock_mesh("0a", false).await.unwrap()];
    let mut removal = there.lock_mesh("0a", true);
    assert!(tokio::time::timeout(Duration::from_millis(300), &mut removal).await.is_err());
    drop(here.lock_mesh("0b", true).await.unwrap());
    drop(kept);
    let removing = removal.await.unwrap();
    let mut upload = here.lock_mesh("0a", false);
    assert!(tokio::time::timeout(Duration::from_millis(300), &mut upload).await.is_err());
    drop(removing);
    upload.await.unwrap();
}

#[tokio::test]
async fn jobs_of_live_processes_are_no_orphans() {
    let Some([here, there]) = stores(LONG).await else { return };
    let job = submitted(&here, "a").await;
    here.claim(None).await.unwrap().unwrap();
    assert!(there.orphans().await.unwrap().is_empty());
    // Nor does another process end it, or the same one another attempt.
    assert!(!there.finish(job.seq, 1, &end()).await.unwrap());
    assert!(!there.requeue(job.seq, 1, Requeued::WorkerLost).await.unwrap());
    assert_eq!(there.shared().unwrap().renew(&[job.seq]).await.unwrap().len(), 0);
    let kept = here.shared().unwrap().renew(&[job.seq]).await.unwrap();
    assert_eq!(kept, BTreeMap::from([(job.seq, (1, OwnerRequest::Result))]));
    assert!(here.finish(job.seq, 1, &end()).await.unwrap());
}

#[tokio::test]
async fn job_of_a_lost_process_goes_to_one_other_and_its_late_reports_have_no_effect() {
    let Some([lost, second, third]) = stores(Duration::from_millis(200)).await else { return };
    let job = submitted(&lost, "a").await;
    let claimed = lost.claim(None).await.unwrap().unwrap();
    tokio::time::sleep(Duration::from_millis(300)).await;
    let (a, b) = join(second.orphans(), third.orphans()).await;
    let taken = [a.unwrap(), b.unwrap()];
    assert_eq!(taken.iter().map(Vec::len).sum::<usize>(), 1);
    let heir = if taken[0].is_empty() { &third } else { &second };
    assert!(!lost.finish(job.seq, claimed.attempt, &end()).await.unwrap());
    assert!(lost.shared().unwrap().renew(&[job.seq]).await.unwrap().is_empty());
    assert!(heir.requeue(job.seq, claimed.attempt, Requeued::WorkerLost).await.unwrap());
    let again = heir.claim(None).await.unwrap().unwrap();
    assert_eq!((again.seq, again.attempt), (job.seq, 2));
    // A lease is that of one attempt: an earlier one in the same process learns that it is over.
    let kept = heir.shared().unwrap().renew(&[job.seq]).await.unwrap();
    assert_eq!(kept, BTreeMap::from([(job.seq, (2, OwnerRequest::Result))]));
    assert!(!lost.requeue(job.seq, 2, Requeued::Shutdown).await.unwrap());
    assert!(heir.finish(job.seq, 2, &end()).await.unwrap());
    assert_eq!(heir.job("anna", job.id).await.unwrap().unwrap().state, JobState::Succeeded);
}

#[tokio::test]
async fn a_hidden_job_is_erased_by_another_process_if_its_own_is_lost() {
    let Some([lost, other]) = stores(Duration::from_millis(200)).await else { return };
    let job = submitted(&lost, "a").await;
    lost.hide("anna", job.id).await.unwrap();
    assert!(other.orphans().await.unwrap().is_empty());
    tokio::time::sleep(Duration::from_millis(300)).await;
    let orphans = other.orphans().await.unwrap();
    assert_eq!(
        orphans.iter().map(|o| (o.seq, o.request)).collect::<Vec<_>>(),
        [(job.seq, OwnerRequest::Deletion)]
    );
}

#[tokio::test]
async fn many_processes_claim_each_job_once() {
    let Some(stores) = stores::<4>(LONG).await else { return };
    for _ in 0..40 {
        stores[0].submit(&new("a"), queue_of(100)).await.unwrap();
    }
    let drain = async |store: &PostgresStore| {
        let mut seqs = Vec::new();
        while let Some(job) = store.claim(None).await.unwrap() {
            seqs.push(job.seq);
            assert!(store.finish(job.seq, job.attempt, &end()).await.unwrap());
        }
        seqs
    };
    let drained = join_all(stores.iter().map(drain)).await;
    let mut seqs: Vec<i64> = drained.into_iter().flatten().collect();
    seqs.sort_unstable();
    assert_eq!(seqs, (1..=40).collect::<Vec<i64>>());
}

#[tokio::test]
async fn equal_requests_to_many_processes_are_one_job() {
    let Some(stores) = stores::<4>(LONG).await else { return };
    let keyed = NewJob { idempotency_key: Some("k".into()), ..new("a") };
    let posts = (0..100).map(|i| stores[i % 4].submit(&keyed, queue_of(10)));
    for answer in join_all(posts).await {
        answer.unwrap();
    }
    let counts = stores[0].counts().await.unwrap();
    assert_eq!(counts.into_iter().map(|(_, n)| n).collect::<Vec<_>>(), [1, 0, 0, 0, 0]);
}

#[tokio::test]
async fn processes_hear_of_the_changes_of_others() {
    let Some([here, there]) = stores(LONG).await else { return };
    let mut changes = there.shared().unwrap().changes().await.unwrap();
    let job = submitted(&here, "a").await;
    assert_eq!(changes.next().await, Some(Change::Arrival(job.seq)));
    here.claim(None).await.unwrap().unwrap();
    assert_eq!(changes.next().await, Some(Change::Event(job.seq)));
    assert_eq!(here.cancel("anna", job.id).await.unwrap(), CancelAnswer::Stopping);
    assert_eq!(changes.next().await, Some(Change::Request(job.seq)));
}
