//! Whether the service accepts work, checked for all who ask within a second at once: a check writes to the disk.

use std::time::Duration;
use tokio::sync::Mutex;
use tokio::time::Instant;

/// How long an answer holds.
const HOLDS: Duration = Duration::from_secs(1);

/// The last answer.
#[derive(Debug, Default)]
pub struct Readiness(Mutex<Option<(Instant, bool)>>);

impl Readiness {
    /// The last answer, or that of `check` if it is too old. Whoever asks meanwhile waits for the same check.
    pub async fn is_ready(&self, check: impl Future<Output = bool>) -> bool {
        let mut last = self.0.lock().await;
        if let Some((_, answer)) = last.filter(|(at, _)| at.elapsed() < HOLDS) {
            return answer;
        }
        let answer = check.await;
        *last = Some((Instant::now(), answer));
        answer
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::atomic::{AtomicU32, Ordering};

    #[tokio::test]
    async fn many_questions_are_one_check() {
        let (readiness, checks) = (Readiness::default(), AtomicU32::new(0));
        let check = async |answer| {
            checks.fetch_add(1, Ordering::SeqCst);
            tokio::time::sleep(Duration::from_millis(20)).await;
            answer
        };
        let answers = futures::future::join_all((0..100).map(|_| readiness.is_ready(check(false)))).await;
        assert!(answers.iter().all(|is_ready| !is_ready));
        assert_eq!(checks.load(Ordering::SeqCst), 1);
        assert!(!readiness.is_ready(check(true)).await, "for a second");
        tokio::time::sleep(HOLDS).await;
        assert!(readiness.is_ready(check(true)).await);
        assert_eq!(checks.load(Ordering::SeqCst), 2);
    }
}
