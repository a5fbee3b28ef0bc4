//! Guarantees of every job store, without HTTP.

#[path = "tests/damaged.rs"]
pub mod damaged;
#[path = "tests/upgraded.rs"]
pub mod upgraded;

use super::*;
use crate::service::jobs::failures::{internal, worker_lost};
use crate::service::jobs::{FinalRecording, Phase, Priority};
use crate::service::shelves::{mesh_name, recording_name};
use crate::step::{Ending, FailureCause};

/// Checks a store, starting empty.
pub(super) async fn check<S: JobStore>(empty: impl AsyncFn() -> S) {
    jobs_are_claimed_once_in_the_order_of_their_coming(&empty().await).await;
    owners_take_turns_and_order_their_own_jobs(&empty().await).await;
    attempt_that_is_over_changes_nothing(&empty().await).await;
    orphans_are_those_without_a_worker_and_those_that_were_hidden(&empty().await).await;
    what_a_job_is_for_is_read_back(&empty().await).await;
    queue_has_an_end(&empty().await).await;
    owners_keep_what_they_may(&empty().await).await;
    one_key_is_one_job(&empty().await).await;
    event_streams_are_numbered_and_end(&empty().await).await;
    mesh_in_use_stays(&empty().await).await;
    job_and_the_deletion_of_its_mesh_exclude_each_other(&empty().await).await;
    what_ended_long_ago_is_found(&empty().await).await;
    job_waits_for_its_memory(&empty().await).await;
    job_that_lost_its_process_runs_alone(&empty().await).await;
    counts_follow_the_jobs(&empty().await).await;
    owners_do_not_see_each_other(&empty().await).await;
    blobs_of_jobs_and_meshes_are_known(&empty().await).await;
}

pub fn new(name: &str) -> NewJob {
    NewJob {
        owner: "anna".into(),
        idempotency_key: None,
        body_sha256: "0".into(),
        kind: JobKind::Study,
        priority: Priority::Normal,
        trace: None,
        document: b"{}".to_vec(),
        name: name.into(),
        content_hash: "0".into(),
        end_time_s: 1.0,
        warnings: vec![],
        memory_bytes: 0,
        meshes: std::collections::BTreeSet::new(),
    }
}

/// Limits of one waiting job of each owner.
fn one_of_owner() -> Quotas {
    Quotas { waiting_of_owner: 1, ..Quotas::NONE }
}

/// Limits of a queue for so many jobs.
pub fn queue_of(waiting: u64) -> Quotas {
    Quotas { waiting, ..Quotas::NONE }
}

pub async fn submitted(store: &dyn JobStore, name: &str) -> Job {
    match store.submit(&new(name), queue_of(10)).await.unwrap() {
        Submitted::Created(row) => *row,
        other => panic!("{other:?}"),
    }
}

fn end(ending: Ending) -> JobEnd {
    JobEnd { ending, summary: None, headline: None, recording: None, progress: None }
}

async fn jobs_are_claimed_once_in_the_order_of_their_coming(store: &dyn JobStore) {
    for name in ["a", "b", "c"] {
        submitted(store, name).await;
    }
    let claims = futures::future::join_all((0..5).map(|_| store.claim(None))).await;
    let mut seqs: Vec<i64> = claims.into_iter().filter_map(|c| c.unwrap()).map(|c| c.seq).collect();
    seqs.sort_unstable();
    assert_eq!(seqs, [1, 2, 3]);
    assert!(store.claim(None).await.unwrap().is_none());
}

/// Submits jobs, given as owner, name and priority.
async fn submit_all(store: &dyn JobStore, jobs: &[(&str, &str, Priority)]) -> Vec<Job> {
    let mut all = Vec::new();
    for (owner, name, priority) in jobs {
        let job = NewJob { owner: (*owner).into(), priority: *priority, ..new(name) };
        let Submitted::Created(job) = store.submit(&job, Quotas::NONE).await.unwrap() else {
            panic!("no new job")
        };
        all.push(*job);
    }
    all
}

async fn owners_take_turns_and_order_their_own_jobs(store: &dyn JobStore) {
    use Priority::{High, Low, Normal};
    let jobs = submit_all(
        store,
        &[
            ("anna", "a1", Low),
            ("anna", "a2", Normal),
            ("anna", "a3", Normal),
            ("anna", "a4", High),
            ("bert", "b1", Low),
            ("bert", "b2", Normal),
            ("carl", "c1", Normal),
        ],
    )
    .await;
    // Their positions are those among their own jobs, in the answer to the submission as it was then.
    let positions =
        |jobs: &[Job]| jobs.iter().rev().map(|job| job.queue_position.unwrap()).collect::<Vec<_>>();
    assert_eq!(positions(&jobs), [1, 1, 1, 1, 2, 1, 1]);
    let page = Page { states: vec![], before: None, limit: 10 };
    assert_eq!(positions(&store.jobs("anna", &page).await.unwrap()), [4, 2, 3, 1]);
    assert_eq!(store.job("anna", jobs[0].id).await.unwrap().unwrap().queue_position, Some(4));
    let next = async || {
        let claimed = store.claim(None).await.unwrap().unwrap();
        jobs.iter().find(|job| job.seq == claimed.seq).map(|job| (job.name.clone(), claimed)).unwrap()
    };
    // Whoever has the fewest runs, then whose turn is longest ago.
    let mut claimed = Vec::new();
    for _ in 0..4 {
        claimed.push(next().await);
    }
    assert_eq!(claimed.iter().map(|(name, _)| name.as_str()).collect::<Vec<_>>(), ["a4", "b2", "c1", "a2"]);
    // One worker: all have none running when it is free.
    for (_, job) in claimed {
        store.finish(job.seq, job.attempt, &end(Ending::Finished)).await.unwrap();
    }
    for expected in ["b1", "a3", "a1"] {
        let (name, job) = next().await;
        assert_eq!(name, expected);
        store.finish(job.seq, job.attempt, &end(Ending::Finished)).await.unwrap();
    }
}

async fn attempt_that_is_over_changes_nothing(store: &dyn JobStore) {
    let job = submitted(store, "a").await;
    let first = store.claim(None).await.unwrap().unwrap();
    assert!(store.requeue(first.seq, first.attempt, Requeued::WorkerLost).await.unwrap());
    let second = store.claim(None).await.unwrap().unwrap();
    assert_eq!((first.attempt, second.attempt), (1, 2));

    let progress = Progress::at(Phase::Stepping, 0.5, 0, 0.0);
    store.record_progress(first.seq, first.attempt, &progress).await.unwrap();
    assert!(!store.finish(first.seq, first.attempt, &end(Ending::Finished)).await.unwrap());
    assert!(!store.requeue(first.seq, first.attempt, Requeued::Shutdown).await.unwrap());
    let row = store.job("anna", job.id).await.unwrap().unwrap();
    assert_eq!((row.state, row.progress), (JobState::Running, 0.0));

    assert!(store.finish(second.seq, second.attempt, &end(Ending::Finished)).await.unwrap());
    assert!(!store.finish(second.seq, second.attempt, &end(internal().into())).await.unwrap());
    let row = store.job("anna", job.id).await.unwrap().unwrap();
    assert_eq!((row.state, row.progress), (JobState::Succeeded, 1.0));
    let (events, ended) = store.events_after(job.seq, 0, 100).await.unwrap();
    let kinds: Vec<&str> = events.iter().map(|e| e.kind.as_str()).collect();
    assert_eq!(kinds, ["queued", "running", "requeued", "running", "succeeded"]);
    assert!(ended);
}

async fn orphans_are_those_without_a_worker_and_those_that_were_hidden(store: &dyn JobStore) {
    let mut jobs = Vec::new();
    for name in ["again", "cancelled", "deleted", "poison", "waiting"] {
        jobs.push(submitted(store, name).await);
    }
    for _ in 0..4 {
        store.claim(None).await.unwrap().unwrap();
    }
    assert_eq!(store.cancel("anna", jobs[1].id).await.unwrap(), CancelAnswer::Stopping);
    let deleted = store.hide("anna", jobs[2].id).await.unwrap();
    assert_eq!(deleted, DeleteAnswer::Running { seq: jobs[2].seq });
    let requests: Vec<OwnerRequest> =
        store.orphans().await.unwrap().into_iter().map(|orphan| orphan.request).collect();
    assert_eq!(
        requests,
        [OwnerRequest::Result, OwnerRequest::Stop, OwnerRequest::Deletion, OwnerRequest::Result]
    );
    assert_eq!(store.request(jobs[1].seq).await.unwrap(), OwnerRequest::Stop);
    assert_eq!(store.request(99).await.unwrap(), OwnerRequest::Deletion);

    assert!(store.finish(jobs[3].seq, 1, &end(worker_lost(1).into())).await.unwrap());
    let row = store.job("anna", jobs[3].id).await.unwrap().unwrap();
    assert_eq!(row.failure.unwrap().cause, FailureCause::WorkerLost);
}

async fn what_a_job_is_for_is_read_back(store: &dyn JobStore) {
    let job = submitted(store, "a").await;
    assert_eq!(store.document("anna", job.id).await.unwrap().unwrap(), (JobKind::Study, b"{}".to_vec()));
    assert_eq!(store.claim(None).await.unwrap().unwrap().kind, JobKind::Study);
}

async fn queue_has_an_end(store: &dyn JobStore) {
    store.submit(&new("a"), queue_of(1)).await.unwrap();
    assert!(matches!(store.submit(&new("b"), queue_of(1)).await, Err(JobsError::QueueFull { waiting: 1 })));
}

async fn owners_keep_what_they_may(store: &dyn JobStore) {
    let (anna, bert) = (new("a"), NewJob { owner: "bert".into(), ..new("b") });
    let one = one_of_owner();
    let first = submitted(store, "a").await;
    assert!(matches!(store.submit(&anna, one).await, Err(JobsError::OwnerWaits { waiting: 1 })));
    store.submit(&bert, one).await.unwrap();
    // Jobs that have ended are kept, too, with what they left.
    let claimed = store.claim(None).await.unwrap().unwrap();
    let recording = FinalRecording { bytes: 90, sha256: "0".into(), complete: true, attempt: 1 };
    let ended = JobEnd { summary: Some("{}".into()), recording: Some(recording), ..end(Ending::Finished) };
    store.finish(claimed.seq, claimed.attempt, &ended).await.unwrap();
    let refused = |answer: Result<_, JobsError>| matches!(answer, Err(JobsError::OwnerKeeps { .. }));
    assert!(refused(store.submit(&anna, Quotas { jobs_of_owner: 1, ..Quotas::NONE }).await.map(drop)));
    // Two documents of two bytes each, a summary of two, and the recording.
    let bytes = |bytes_of_owner| Quotas { bytes_of_owner, ..Quotas::NONE };
    assert!(refused(store.submit(&anna, bytes(95)).await.map(drop)));
    let report = serde_json::from_str(include_str!("../../../../api/examples/mesh.response.json")).unwrap();
    assert!(refused(store.add_mesh("anna", "0a", MeshFormat::Gmsh, 2, &report, bytes(95)).await.map(drop)));
    assert!(store.mesh("anna", "0a").await.unwrap().is_none());
    assert!(store.add_mesh("anna", "0a", MeshFormat::Gmsh, 1, &report, bytes(95)).await.unwrap());
    assert!(refused(store.submit(&anna, bytes(96)).await.map(drop)));
    store.submit(&bert, bytes(96)).await.unwrap();
    store.submit(&anna, bytes(97)).await.unwrap();
    // What is deleted is free again.
    store.hide("anna", first.id).await.unwrap();
    store.erase(first.seq).await.unwrap();
    store.submit(&anna, bytes(96)).await.unwrap();
}

async fn one_key_is_one_job(store: &dyn JobStore) {
    let keyed = NewJob { idempotency_key: Some("k".into()), ..new("a") };
    let answers = futures::future::join_all((0..100).map(|_| store.submit(&keyed, queue_of(1)))).await;
    let (mut created, mut ids) = (0, std::collections::BTreeSet::new());
    for answer in answers {
        match answer.unwrap() {
            Submitted::Created(job) => {
                created += 1;
                ids.insert(job.id);
            }
            Submitted::Replayed(job) => {
                ids.insert(job.id);
            }
            other => panic!("the body is the same: {other:?}"),
        }
    }
    assert_eq!((created, ids.len()), (1, 1));
    let other = NewJob { body_sha256: "1".into(), ..keyed.clone() };
    assert!(matches!(store.submit(&other, queue_of(10)).await.unwrap(), Submitted::KeyReused));
    assert!(matches!(store.replay("anna", "k", "0").await.unwrap(), Some(Submitted::Replayed(_))));
    assert!(store.replay("bert", "k", "0").await.unwrap().is_none());
}

async fn event_streams_are_numbered_and_end(store: &dyn JobStore) {
    let job = submitted(store, "a").await;
    let claimed = store.claim(None).await.unwrap().unwrap();
    let event = Event { kind: "case", data: serde_json::json!({"index": 0}) };
    let [first, second] = [0.25, 0.5].map(|fraction| Progress::at(Phase::Stepping, fraction, 7, 0.5));
    store.record_progress(claimed.seq, 1, &first).await.unwrap();
    futures::future::join_all((0..8).map(|_| store.record_event(claimed.seq, 1, &event))).await;
    store.record_progress(claimed.seq, 1, &second).await.unwrap();
    let row = store.job("anna", job.id).await.unwrap().unwrap();
    assert_eq!((row.progress, row.step, row.simulated_time_s), (0.5, 7, 0.5));
    let (events, ended) = store.events_after(job.seq, 2, 4).await.unwrap();
    assert_eq!(events.iter().map(|e| e.n).collect::<Vec<_>>(), [3, 4, 5, 6]);
    assert!(!ended);
    let number = HeadlineNumber { value: 1234.5, error: Some(67.0), resolved: true, lower_bound: false };
    let headline = Headline {
        projectile: Some("ball".into()),
        speed_m_per_s: Some(20.0),
        threshold_pa: None,
        numbers: [(crate::measure::QuantityOfInterest::PeakForceN, number)].into(),
    };
    let finished = JobEnd {
        summary: Some("{}".into()),
        headline: Some(headline.clone()),
        recording: Some(FinalRecording { bytes: 3, sha256: "0".into(), complete: true, attempt: 1 }),
        ..end(Ending::Finished)
    };
    assert!(store.finish(claimed.seq, 1, &finished).await.unwrap());
    let row = store.job("anna", job.id).await.unwrap().unwrap();
    assert_eq!(
        (row.recording.clone(), row.recording_name()),
        (finished.recording, recording_name(job.id, 1))
    );
    // What a list says of it is in its row.
    let page = Page { states: vec![], before: None, limit: 1 };
    assert_eq!(store.jobs("anna", &page).await.unwrap()[0].headline.as_ref(), Some(&headline));
    assert_eq!(store.summary("anna", job.id).await.unwrap().as_deref(), Some("{}"));
    let (events, ended) = store.events_after(job.seq, 12, 4).await.unwrap();
    assert_eq!((events.len(), ended), (1, true));
}

async fn mesh_in_use_stays(store: &dyn JobStore) {
    let report = serde_json::from_str(include_str!("../../../../api/examples/mesh.response.json")).unwrap();
    for owner in ["anna", "bert"] {
        assert!(store.add_mesh(owner, "0a", MeshFormat::Gmsh, 1, &report, Quotas::NONE).await.unwrap());
    }
    assert!(!store.add_mesh("anna", "0a", MeshFormat::Gmsh, 1, &report, Quotas::NONE).await.unwrap());
    let using = NewJob { document: br#"{"mesh": "0a"}"#.to_vec(), meshes: ["0a".into()].into(), ..new("a") };
    let Submitted::Created(job) = store.submit(&using, queue_of(10)).await.unwrap() else {
        panic!("no new job")
    };
    assert_eq!(store.delete_mesh("anna", "0a").await.unwrap(), MeshDeletion::InUse { job: job.id });
    store.cancel("anna", job.id).await.unwrap();
    assert_eq!(store.delete_mesh("anna", "0a").await.unwrap(), MeshDeletion::Deleted { unowned: None });
    // Nor does a job come that was validated before.
    let waiting = store.counts().await.unwrap();
    assert!(
        matches!(store.submit(&using, queue_of(10)).await.unwrap(), Submitted::MeshGone { id } if id == "0a")
    );
    assert_eq!(store.counts().await.unwrap(), waiting);
    assert!(store.has_owner("0a", MeshFormat::Gmsh).await.unwrap());
    let unowned = Some(MeshFormat::Gmsh);
    assert_eq!(store.delete_mesh("bert", "0a").await.unwrap(), MeshDeletion::Deleted { unowned });
    assert_eq!(store.delete_mesh("bert", "0a").await.unwrap(), MeshDeletion::Unknown);
    assert!(!store.has_owner("0a", MeshFormat::Gmsh).await.unwrap());
}

/// However a job and the deletion of its mesh meet, there is either the job with its mesh, or neither.
async fn job_and_the_deletion_of_its_mesh_exclude_each_other(store: &dyn JobStore) {
    let report = serde_json::from_str(include_str!("../../../../api/examples/mesh.response.json")).unwrap();
    for i in 0..20 {
        let id = format!("{i:02x}");
        store.add_mesh("anna", &id, MeshFormat::Gmsh, 1, &report, Quotas::NONE).await.unwrap();
        let document = format!(r#"{{"mesh": "{id}"}}"#).into_bytes();
        let using = NewJob { document, meshes: [id.clone()].into(), ..new("a") };
        let (submitted, deletion) =
            futures::future::join(store.submit(&using, queue_of(100)), store.delete_mesh("anna", &id)).await;
        match (submitted.unwrap(), deletion.unwrap()) {
            (Submitted::Created(job), MeshDeletion::InUse { job: user }) => assert_eq!(job.id, user),
            (Submitted::MeshGone { .. }, MeshDeletion::Deleted { .. }) => {}
            other => panic!("{other:?}"),
        }
    }
}

async fn what_ended_long_ago_is_found(store: &dyn JobStore) {
    let job = submitted(store, "a").await;
    assert_eq!(store.expired_jobs(0, i64::MIN, 10).await.unwrap().1, None);
    store.cancel("anna", job.id).await.unwrap();
    let (expired, last) = store.expired_jobs(0, i64::MIN, 10).await.unwrap();
    assert_eq!((expired.found, last), (vec![("anna".to_owned(), job.id)], Some(job.seq)));
    assert_eq!(store.expired_jobs(0, job.seq, 10).await.unwrap().1, None);
    assert_eq!(store.expired_jobs(1, i64::MIN, 10).await.unwrap().1, None);
    store.add_result(job.seq, "r").await.unwrap();
    assert_eq!(store.own_results(job.seq).await.unwrap(), ["r"]);
    store.try_write().await.unwrap();
    assert_eq!(store.faults().await.unwrap(), (vec![], vec![]));
}

async fn job_waits_for_its_memory(store: &dyn JobStore) {
    store.submit(&NewJob { memory_bytes: 100, ..new("large") }, queue_of(10)).await.unwrap();
    submitted(store, "small").await;
    assert!(store.claim(Some(99)).await.unwrap().is_none(), "nor does the next one overtake it");
    assert_eq!(store.claim(Some(100)).await.unwrap().unwrap().memory_bytes, 100);
    assert_eq!(store.claim(Some(0)).await.unwrap().unwrap().memory_bytes, 0);
}

async fn job_that_lost_its_process_runs_alone(store: &dyn JobStore) {
    submitted(store, "killer").await;
    let job = store.claim(Some(0)).await.unwrap().unwrap();
    assert!(!job.alone);
    store.requeue(job.seq, job.attempt, Requeued::ProcessLost).await.unwrap();
    assert!(store.claim(Some(u64::MAX)).await.unwrap().is_none(), "something else runs");
    let again = store.claim(None).await.unwrap().unwrap();
    assert_eq!((again.seq, again.attempt, again.alone), (job.seq, 2, true));
    // However it waits again.
    store.requeue(again.seq, again.attempt, Requeued::Shutdown).await.unwrap();
    assert!(store.claim(Some(u64::MAX)).await.unwrap().is_none());
}

async fn counts_follow_the_jobs(store: &dyn JobStore) {
    let jobs = [submitted(store, "a").await, submitted(store, "b").await, submitted(store, "c").await];
    assert_eq!(store.job("anna", jobs[2].id).await.unwrap().unwrap().queue_position, Some(3));
    let claimed = store.claim(None).await.unwrap().unwrap();
    store.finish(claimed.seq, claimed.attempt, &end(Ending::Finished)).await.unwrap();
    store.hide("anna", jobs[1].id).await.unwrap();
    store.erase(jobs[1].seq).await.unwrap();
    let counts: Vec<u64> = store.counts().await.unwrap().into_iter().map(|(_, count)| count).collect();
    assert_eq!(counts, [1, 0, 1, 0, 0]);
    // So do those of owners: one waits, and with another one two would.
    assert!(matches!(
        store.submit(&new("d"), one_of_owner()).await,
        Err(JobsError::OwnerWaits { waiting: 1 })
    ));
    let page = Page { states: vec![JobState::Queued, JobState::Succeeded], before: None, limit: 10 };
    let rows = store.jobs("anna", &page).await.unwrap();
    let positions: Vec<_> = rows.iter().map(|row| (row.seq, row.queue_position)).collect();
    assert_eq!(positions, [(jobs[2].seq, Some(1)), (jobs[0].seq, None)]);
}

async fn owners_do_not_see_each_other(store: &dyn JobStore) {
    let job = submitted(store, "a").await;
    assert!(store.job("bert", job.id).await.unwrap().is_none());
    assert_eq!(store.cancel("bert", job.id).await.unwrap(), CancelAnswer::Unknown);
    assert_eq!(store.hide("bert", job.id).await.unwrap(), DeleteAnswer::Unknown);
    let page = Page { states: vec![], before: None, limit: 10 };
    assert!(store.jobs("bert", &page).await.unwrap().is_empty());
    assert_eq!(store.jobs("anna", &page).await.unwrap().len(), 1);
}

async fn blobs_of_jobs_and_meshes_are_known(store: &dyn JobStore) {
    assert!(store.blobs().await.unwrap().names.is_empty());
    let job = submitted(store, "a").await;
    let report = serde_json::from_str(include_str!("../../../../api/examples/mesh.response.json")).unwrap();
    store.add_mesh("anna", "0a", MeshFormat::Gmsh, 1, &report, Quotas::NONE).await.unwrap();
    let known = store.blobs().await.unwrap().names;
    assert_eq!(Vec::from_iter(known), [mesh_name("0a", MeshFormat::Gmsh), recording_name(job.id, 1)]);
}
