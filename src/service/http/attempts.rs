//! Wrong tokens, counted for each address.
//!
//! A right token is accepted whatever came from its address before: others may be behind the same address, and a token cannot be
//! guessed by trying.

use std::collections::BTreeMap;
use std::net::IpAddr;
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

/// Number of wrong tokens that are answered as such within [`WINDOW`].
const MOST: u32 = 10;
/// Time after the first wrong token for which they count.
const WINDOW: Duration = Duration::from_secs(60);
/// Number of addresses that are remembered.
const MOST_ADDRESSES: usize = 10_000;

/// Wrong tokens of each address.
#[derive(Debug, Default)]
pub struct Attempts(Mutex<BTreeMap<IpAddr, (Instant, u32)>>);

impl Attempts {
    /// Counts a wrong token; the time to wait if there were too many [s].
    pub fn wrong(&self, address: IpAddr) -> Option<u64> {
        self.wrong_at(address, Instant::now())
    }

    fn wrong_at(&self, address: IpAddr, now: Instant) -> Option<u64> {
        let mut known = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let is_over = |began: Instant| now.duration_since(began) >= WINDOW;
        if known.len() >= MOST_ADDRESSES && !known.contains_key(&address) {
            known.retain(|_, (began, _)| !is_over(*began));
            // Too many addresses at once: the count begins again for all.
            if known.len() >= MOST_ADDRESSES {
                known.clear();
            }
        }
        let (began, count) = known.entry(address).or_insert((now, 0));
        if is_over(*began) {
            (*began, *count) = (now, 0);
        }
        *count = count.saturating_add(1);
        (*count > MOST).then(|| WINDOW.saturating_sub(now.duration_since(*began)).as_secs() + 1)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn repeated_wrong_tokens_have_to_wait_for_a_minute() {
        let (attempts, start) = (Attempts::default(), Instant::now());
        let [here, there] = [[10, 0, 0, 1], [10, 0, 0, 2]].map(IpAddr::from);
        for _ in 0..MOST {
            assert_eq!(attempts.wrong_at(here, start), None);
        }
        assert_eq!(attempts.wrong_at(here, start + Duration::from_secs(20)), Some(41));
        assert_eq!(attempts.wrong_at(there, start), None);
        assert_eq!(attempts.wrong_at(here, start + WINDOW), None);
    }
}
