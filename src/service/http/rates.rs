//! Requests of each owner, whose rate is limited: a bucket that fills steadily, and from which each request takes one.

use std::collections::BTreeMap;
use std::sync::{Mutex, PoisonError};
use std::time::Instant;

/// Time for which an owner may save requests up [s]: a page asks for many at once.
const SAVED_S: f64 = 10.0;

/// Rates of owners. They are those of tokens, so there are not many.
#[derive(Debug)]
pub struct Rates {
    per_s: f64,
    /// When the bucket of an owner was looked at, and the requests that it had then.
    buckets: Mutex<BTreeMap<String, (Instant, f64)>>,
}

impl Rates {
    /// This many requests per second for each owner.
    pub fn new(per_s: u32) -> Self {
        Self { per_s: per_s.max(1).into(), buckets: Mutex::default() }
    }

    /// Counts a request of an owner; the time to wait if there were too many [s].
    pub fn take(&self, owner: &str) -> Option<u64> {
        self.take_at(owner, Instant::now())
    }

    fn take_at(&self, owner: &str, now: Instant) -> Option<u64> {
        let most = self.per_s * SAVED_S;
        let mut buckets = self.buckets.lock().unwrap_or_else(PoisonError::into_inner);
        let (at, left) = buckets.entry(owner.to_owned()).or_insert((now, most));
        *left = most.min(*left + now.duration_since(*at).as_secs_f64() * self.per_s);
        *at = now;
        if *left < 1.0 {
            return Some(((1.0 - *left) / self.per_s).ceil() as u64);
        }
        *left -= 1.0;
        None
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::time::Duration;

    #[test]
    fn requests_are_saved_up_and_come_back_with_time() {
        let (rates, start) = (Rates::new(2), Instant::now());
        for _ in 0..20 {
            assert_eq!(rates.take_at("anna", start), None);
        }
        assert_eq!(rates.take_at("anna", start), Some(1));
        assert_eq!(rates.take_at("bert", start), None);
        let later = start + Duration::from_millis(600);
        assert_eq!(rates.take_at("anna", later), None);
        assert_eq!(rates.take_at("anna", later), Some(1));
    }
}
