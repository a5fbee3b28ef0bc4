//! Rows that were damaged from outside: they are reported, and the others go on.

use super::*;
use crate::service::jobs::store::OwnerRequest;

/// Checks an empty store, whose rows `change` changes, with each damage of a row.
pub async fn check_damaged(store: &dyn JobStore, change: impl AsyncFn(String), damages: &[&str]) {
    for damage in damages {
        let damaged =
            async |job: &Job| change(format!("UPDATE jobs SET {damage} WHERE seq = {}", job.seq)).await;
        // One that waits, and one whose process is lost.
        let running = submitted(store, "a").await;
        store.claim(None).await.unwrap().unwrap();
        let (waiting, good) = (submitted(store, "b").await, submitted(store, "c").await);
        damaged(&running).await;
        damaged(&waiting).await;
        for orphan in store.orphans().await.unwrap() {
            store.requeue(orphan.seq, orphan.attempt, Requeued::WorkerLost).await.unwrap();
        }
        let claimed = store.claim(None).await.unwrap().unwrap();
        assert_eq!((claimed.seq, claimed.document), (good.seq, b"{}".to_vec()), "{damage}");
        assert!(store.claim(None).await.unwrap().is_none(), "{damage}");
        assert!(store.finish(good.seq, 1, &end(Ending::Finished)).await.unwrap(), "{damage}");
        let counts = store.counts().await.unwrap();
        assert_eq!((counts[0].1, counts[1].1), (0, 0), "{damage}: they have ended");
        assert_eq!(store.faults().await.unwrap(), (vec![], vec![running.seq, waiting.seq]), "{damage}");

        let can_be_named = !damage.starts_with("id") && !damage.starts_with("owner");
        assert_eq!(store.blobs().await.unwrap().unreadable, if damage.starts_with("id") { 2 } else { 0 });
        let (expired, last) = store.expired_jobs(0, i64::MIN, 100).await.unwrap();
        assert_eq!(
            (expired.unreadable, last),
            (if can_be_named { 0 } else { 2 }, Some(good.seq)),
            "{damage}"
        );
        assert!(expired.found.contains(&("anna".to_owned(), good.id)), "{damage}");
        for job in [&running, &waiting] {
            if can_be_named {
                let deleted = store.hide("anna", job.id).await.unwrap();
                assert!(matches!(deleted, DeleteAnswer::Idle { .. }), "{damage}: {deleted:?}");
                assert_eq!(store.request(job.seq).await.unwrap(), OwnerRequest::Deletion);
            }
            change(format!("DELETE FROM jobs WHERE seq = {}", job.seq)).await;
        }
    }
}

/// Checks that what ended in the future, by a clock that was wrong, is found with all that has ended.
pub async fn check_wrong_clock(store: &dyn JobStore, change: impl AsyncFn(String)) {
    let job = submitted(store, "a").await;
    store.cancel("anna", job.id).await.unwrap();
    change("UPDATE jobs SET finished_at = '2999-01-01T00:00:00.000Z'".into()).await;
    assert_eq!(store.expired_jobs(0, i64::MIN, 100).await.unwrap().0.found, [("anna".to_owned(), job.id)]);
    assert!(store.expired_jobs(1, i64::MIN, 100).await.unwrap().0.found.is_empty());
}
