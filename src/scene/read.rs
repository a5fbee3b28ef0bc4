//! What the readers of all documents have in common: structure by the schema, named materials, deserialisation.

use super::json::Parsed;
use super::problem::{Problem, ProblemList, Problems};
use super::structure::{self, Checked};
use serde::de::DeserializeOwned;
use serde_json::Value;

/// A document, and what the check of its structure found; `resolve` replaces the names of materials.
///
/// # Errors
/// All problems so far, if there is no document that could be checked further.
pub(super) fn read<T: DeserializeOwned>(
    parsed: &Parsed,
    schema: &Value,
    resolve: fn(&mut Checked),
) -> Result<(T, Checked), Problems> {
    let mut checked = structure::check(&parsed.value, schema);
    // Repeated keys come first.
    let mut problems: ProblemList = parsed.problems.iter().cloned().collect();
    problems.extend(std::mem::take(&mut checked.problems).into_vec());
    checked.problems = problems;
    if checked.is_cut_short {
        return Err(checked.problems.into());
    }
    resolve(&mut checked);
    match serde_path_to_error::deserialize(&checked.mended) {
        Ok(document) => Ok((document, checked)),
        Err(error) => {
            checked.problems.push(Problem::refused_by_serde(&error, &checked.mended));
            Err(checked.problems.into())
        }
    }
}

/// A document with its warnings.
///
/// # Errors
/// All problems, if one of them is an error.
pub(super) fn accept<T>(document: T, problems: Vec<Problem>) -> Result<(T, Vec<Problem>), Problems> {
    if problems.iter().any(Problem::is_error) { Err(Problems(problems)) } else { Ok((document, problems)) }
}
