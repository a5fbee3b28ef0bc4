//! What a job was made of, told from the document that is kept of it.

use super::study_job::StudyDocument;
use crate::study::what_if::WhatIfDocument;

/// The document of a job that was accepted.
#[derive(Clone, Debug)]
pub enum JobDocument {
    /// A scene.
    Scene,
    /// A what-if question with its base.
    Question(Box<WhatIfDocument>),
    /// A study.
    Study(Box<StudyDocument>),
}

impl JobDocument {
    /// What a body that was accepted is.
    pub fn of(body: &[u8]) -> Self {
        let study = StudyDocument::of(body).map(|study| Self::Study(Box::new(study)));
        let question = || WhatIfDocument::of(body).map(|question| Self::Question(Box::new(question)));
        study.or_else(question).unwrap_or(Self::Scene)
    }

    /// What the job is for, if not for a scene: it has no scene of its own then, and so no plan.
    pub fn purpose(&self) -> Option<&'static str> {
        match self {
            Self::Scene => None,
            Self::Question(_) => Some("answers a what-if question"),
            Self::Study(_) => Some("is a study"),
        }
    }
}
