//! The clock of the machine, which may be wrong: identifiers and dates are of the years from 1970 to 9999.

use std::time::{Duration, SystemTime, UNIX_EPOCH};
use uuid::{NoContext, Timestamp, Uuid};

/// End of the year 9999.
const END: Duration = Duration::from_secs(253_402_300_800);

/// Whether the clock says what jobs can be dated by.
pub fn is_plausible() -> bool {
    is_datable(SystemTime::now())
}

fn is_datable(now: SystemTime) -> bool {
    now.duration_since(UNIX_EPOCH).is_ok_and(|since| since < END)
}

/// A new identifier, which begins with the time if that can be.
pub fn new_id() -> Uuid {
    id_at(SystemTime::now())
}

fn id_at(now: SystemTime) -> Uuid {
    if is_datable(now) { Uuid::now_v7() } else { Uuid::new_v7(Timestamp::from_unix(NoContext, 0, 0)) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_wrong_clock_is_found_out_and_gives_identifiers() {
        let second = Duration::from_secs(1);
        for wrong in [UNIX_EPOCH - second, UNIX_EPOCH + END] {
            assert!(!is_datable(wrong));
            assert_ne!(id_at(wrong), id_at(wrong));
        }
        assert!(is_datable(UNIX_EPOCH) && is_datable(UNIX_EPOCH + END - second));
        assert!(is_plausible());
    }
}
