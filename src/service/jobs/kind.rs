//! Kind of a job: determined at submission, and stored with it.

use serde::{Deserialize, Serialize};

/// The kinds of jobs. Each has documents of its own.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum JobKind {
    /// Run of a scene.
    Simulation,
    /// Runs of a scene, or a matrix of scenes, with many settings.
    Study,
    /// Answer to a what-if question.
    WhatIf,
}

impl JobKind {
    const ALL: [Self; 3] = [Self::Simulation, Self::Study, Self::WhatIf];

    /// Name in the store.
    pub fn as_str(self) -> &'static str {
        match self {
            Self::Simulation => "simulation",
            Self::Study => "study",
            Self::WhatIf => "what_if",
        }
    }

    /// The kind with a name.
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|kind| kind.as_str() == name)
    }

    /// Name of its document.
    pub fn document(self) -> &'static str {
        match self {
            Self::Simulation => "scene",
            Self::Study => "study",
            Self::WhatIf => "question",
        }
    }

    /// Purpose of a job other than running a scene: it has no scene of its own, and therefore no plan.
    pub fn purpose(self) -> Option<&'static str> {
        match self {
            Self::Simulation => None,
            Self::WhatIf => Some("answers a what-if question"),
            Self::Study => Some("is a study"),
        }
    }
}
