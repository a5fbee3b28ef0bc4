//! Requests to end a run early.

/// Why a run is to stop before its end.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Interrupt {
    /// Cancelled by the user.
    Cancel,
    /// The wall-clock budget ran out.
    Deadline,
    /// The budget of steps is spent.
    Steps {
        /// Largest admissible number of steps.
        most: u64,
    },
    /// The budget of recorded bytes is spent.
    RecordingBytes {
        /// Largest admissible number of recorded bytes.
        most: u64,
    },
}

/// Callback that decides whether to stop.
pub type Ask<'a> = &'a (dyn Fn() -> Option<Interrupt> + Sync);
