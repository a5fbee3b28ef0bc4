//! Phases of a run.

use crate::plan::{DynamicRelaxation, LoadTime};

/// Phase of a run, before or after the start of the clock.
#[derive(Clone, Copy, Debug)]
pub(super) enum Phase {
    /// Dynamic relaxation: gravity and damping, full stick, no flight.
    DynamicRelaxation(DynamicRelaxation),
    /// End of dynamic relaxation, with the friction of the scene: contacts beyond the friction limit slip before the
    /// clock starts, and do not excite vibrations when it does.
    FrictionalRelaxation(DynamicRelaxation),
    /// Quasi-static loading over a pseudo-time of 1 s, no flight.
    Preloading,
    /// The transient analysis itself.
    Running,
}

impl Phase {
    /// Whether the bodies have their flight velocity.
    pub fn flies(self) -> bool {
        matches!(self, Self::Running)
    }

    /// Whether contacts are at full stick.
    pub fn sticks(self) -> bool {
        matches!(self, Self::DynamicRelaxation(_))
    }

    /// Mass-proportional damping of the phase [1/s].
    pub fn damping(self) -> f64 {
        match self {
            Self::DynamicRelaxation(relaxation) | Self::FrictionalRelaxation(relaxation) => {
                relaxation.damping
            }
            Self::Preloading | Self::Running => 0.0,
        }
    }

    /// Load time at a time [s], negative before the clock starts.
    pub fn load_time(self, time: f64) -> LoadTime {
        match self {
            Self::DynamicRelaxation(_) | Self::FrictionalRelaxation(_) => LoadTime::Run(0.0),
            Self::Preloading => LoadTime::Preload((1.0 + time).clamp(0.0, 1.0)),
            Self::Running => LoadTime::Run(time),
        }
    }
}
