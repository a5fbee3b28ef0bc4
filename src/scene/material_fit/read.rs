//! Reads and checks the question of a fit.

use super::document::FitQuestion;
use super::{check, curve_file};
use crate::scene::problem::{Problem, Problems};
use crate::scene::read::{accept, read};
use crate::scene::{json, named_materials, schema};
use serde_json::Value;
use std::io;
use std::sync::LazyLock;

static QUESTION: LazyLock<Value> = LazyLock::new(|| schema::schema_of::<FitQuestion>("Contuse material fit"));

impl FitQuestion {
    /// Reads and checks a question; `file` gives the bytes of a CSV file by its name. Also returns the warnings.
    ///
    /// # Errors
    /// All problems at once.
    pub fn read(
        bytes: &[u8],
        file: &dyn Fn(&str) -> io::Result<Vec<u8>>,
    ) -> Result<(Self, Vec<Problem>), Problems> {
        let parsed = json::parse(bytes)?;
        let (mut question, checked) = read::<Self>(&parsed, &QUESTION, named_materials::resolve_questions)?;
        let mut found = curve_file::read_curves(&mut question.tests, file);
        check::check(&question, &mut found);
        accept(question, checked.merged_with(found))
    }
}
