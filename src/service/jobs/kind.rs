//! What a job is for: decided where it is submitted, kept with it, and read back.

/// The kinds of jobs. Each has documents of its own.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum JobKind {
    /// Runs a scene.
    Simulation,
    /// Runs a scene, or a matrix of scenes, in many settings.
    Study,
    /// Answers a what-if question.
    WhatIf,
}

impl JobKind {
    const ALL: [Self; 3] = [Self::Simulation, Self::Study, Self::WhatIf];

    /// The name in the store.
    pub fn as_str(self) -> &'static str {
        match self {
            Self::Simulation => "simulation",
            Self::Study => "study",
            Self::WhatIf => "what_if",
        }
    }

    /// The kind of a name.
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|kind| kind.as_str() == name)
    }

    /// What its document is called.
    pub fn document(self) -> &'static str {
        match self {
            Self::Simulation => "scene",
            Self::Study => "study",
            Self::WhatIf => "question",
        }
    }

    /// What the job is for, if not for a scene: it has no scene of its own then, and so no plan.
    pub fn purpose(self) -> Option<&'static str> {
        match self {
            Self::Simulation => None,
            Self::WhatIf => Some("answers a what-if question"),
            Self::Study => Some("is a study"),
        }
    }
}
