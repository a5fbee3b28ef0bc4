//! Reads and checks the question of a fit.

use super::document::FitQuestion;
use super::{check, curve_file};
use crate::scene::problem::{Problem, Problems};
use crate::scene::{json, named_materials, schema, structure};
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
        let mut checked = structure::check(&parsed.value, &QUESTION);
        checked.problems.splice(0..0, parsed.problems);
        if checked.is_cut_short {
            return Err(Problems(checked.problems));
        }
        named_materials::resolve_questions(&mut checked);
        let mut question: Self = match serde_path_to_error::deserialize(&checked.mended) {
            Ok(question) => question,
            Err(error) => {
                checked.problems.push(Problem::refused_by_serde(&error, &checked.mended));
                return Err(Problems(checked.problems));
            }
        };
        let mut found = curve_file::read_curves(&mut question.tests, file);
        check::check(&question, &mut found);
        let problems = checked.merged_with(found);
        if problems.iter().any(Problem::is_error) {
            Err(Problems(problems))
        } else {
            Ok((question, problems))
        }
    }
}
