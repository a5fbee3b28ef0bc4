//! A recorder that saves the contact problems of a run, one JSON file each.
//!
//! Every [`EVERY_STEPS`]-th step with contacts is saved, starting with the first, and at most [`MOST_FILES`] in all. A
//! step with μ = ∞ in a contact is omitted, since JSON has no such number. Dynamic relaxation has no frames.

use super::contact_problem_file::{NamedContactProblem, contact_problem_document};
use crate::mechanics::contact::RigidSides;
use crate::mechanics::contact::solution::step_problem::step_problem;
use crate::mechanics::rigid::Pose;
use crate::plan::Plan;
use crate::step::{Frame, Recorder, RecorderError};
use std::path::PathBuf;

/// Number of steps with contacts from one file to the next.
pub const EVERY_STEPS: u64 = 20;
/// Maximum number of files per run.
pub const MOST_FILES: usize = 200;

/// Writes the contact problems of a run to a folder.
#[derive(Debug)]
pub struct ContactProblemRecorder {
    folder: PathBuf,
    scene: String,
    steps_with_contact: u64,
    files: usize,
    /// Time of the last frame [s], once the clock runs.
    last_time: Option<f64>,
}

impl ContactProblemRecorder {
    /// A recorder into a folder, which is created; files are named after the scene and the step.
    pub fn new(folder: PathBuf, scene: &str) -> Self {
        let plain = |c: char| if c.is_alphanumeric() || "_-".contains(c) { c } else { '_' };
        Self {
            folder,
            scene: scene.chars().map(plain).collect(),
            steps_with_contact: 0,
            files: 0,
            last_time: None,
        }
    }

    /// Number of files written so far.
    pub fn files(&self) -> usize {
        self.files
    }

    fn write(&mut self, frame: &Frame, h: f64) -> Result<(), RecorderError> {
        let plan = frame.plan;
        let poses: Vec<Pose> = (0..plan.bodies.len()).filter_map(|body| frame.pose(body)).collect();
        let sides = plan.rigid.as_ref().map_or(RigidSides::NONE, |rigid| RigidSides {
            of_pairs: &rigid.of_pairs,
            first: rigid.first_pair,
            bodies: &rigid.bodies,
            poses: &poses,
        });
        let masses = (&plan.inverse_mass[..], &sides);
        let problem = step_problem(frame.contacts, frame.reactions, masses, h, frame.v_after)
            .map_err(|error| RecorderError(Box::new(error)))?;
        let name = format!("{}_{:08}_{}c", self.scene, frame.step, frame.contacts.len());
        let path = self.folder.join(format!("{name}.json"));
        let source = format!("contuse, scene {}, t = {:e} s, h = {h:e} s", self.scene, frame.time);
        let document = contact_problem_document(&NamedContactProblem { name, problem }, &source);
        std::fs::write(path, document.to_string()).map_err(|error| RecorderError(Box::new(error)))?;
        self.files += 1;
        Ok(())
    }
}

impl Recorder for ContactProblemRecorder {
    fn start(&mut self, _: &Plan) -> Result<(), RecorderError> {
        std::fs::create_dir_all(&self.folder).map_err(|error| RecorderError(Box::new(error)))
    }

    fn record(&mut self, frame: &Frame) -> Result<(), RecorderError> {
        // h̄ = ½ (h₋ + h₊), and there is no h₋ when the clock starts.
        let before = self.last_time.map_or(0.0, |last| frame.time - last);
        let h = 2.0 * frame.mean_step - before;
        self.last_time = Some(frame.time);
        if frame.contacts.is_empty() {
            return Ok(());
        }
        self.steps_with_contact += 1;
        let due = (self.steps_with_contact - 1).is_multiple_of(EVERY_STEPS);
        let writable = frame.contacts.iter().all(|contact| contact.law.mu().is_finite());
        if due && writable && self.files < MOST_FILES && h > 0.0 {
            self.write(frame, h)?;
        }
        Ok(())
    }
}
