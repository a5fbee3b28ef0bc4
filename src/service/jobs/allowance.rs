//! Memory that a run may take, from what it is expected to take.
//!
//! The expected memory of a scene is that of its plan and state. A run takes more: the program, its threads, frames on their way to the
//! recording, coarser meshes for error bars.

/// Memory that every run may take [bytes].
const BASE: u64 = 256 << 20;
/// Memory beyond that which a run may take, for each byte that it is expected to take.
const PER_BYTE: u64 = 2;

/// Memory that a run may take [bytes].
pub(super) fn allowed(expected: u64) -> u64 {
    BASE.saturating_add(expected.saturating_mul(PER_BYTE))
}

/// Most memory that a run may be expected to take if so much is free [bytes]; `None` if it is too little for any run.
pub(super) fn expected_within(free: u64) -> Option<u64> {
    free.checked_sub(BASE).map(|rest| rest / PER_BYTE)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_expected_within_free_memory_is_allowed_there() {
        assert_eq!(expected_within(BASE - 1), None);
        for free in [BASE, BASE + 1, 1 << 30, (1 << 30) + 1] {
            let expected = expected_within(free).unwrap();
            assert!(allowed(expected) <= free && allowed(expected + 1) > free);
        }
        assert_eq!(allowed(u64::MAX), u64::MAX);
    }
}
