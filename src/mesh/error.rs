//! Errors of meshes: parameters of generators, files, and operations.

use super::cell::CellKind;
use std::fmt;

/// A parameter of a generator that is out of its range.
#[derive(Clone, Debug, PartialEq)]
pub struct ParameterProblem {
    /// Field of the generator, as spelled there (`inner_radius_m`, `layers[0].thickness_m`); `element_count` for all of them together.
    pub field: String,
    /// The value found; counts are numbers too.
    pub value: f64,
    /// The limit that it violates ("> 0").
    pub limit: String,
    /// How to correct it.
    pub remedy: String,
}

impl fmt::Display for ParameterProblem {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} = {} must be {}: {}", self.field, self.value, self.limit, self.remedy)
    }
}

/// A place in a file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Place {
    /// Line of a text file, from 1.
    Line(usize),
    /// Line of a file that the file includes.
    LineOf {
        /// Name of the included file.
        file: String,
        /// Line in it, from 1.
        line: usize,
    },
    /// Byte offset in a binary file, from 0.
    Byte(usize),
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Place::Line(line) => write!(f, "line {line}"),
            Place::LineOf { file, line } => write!(f, "line {line} of {file}"),
            Place::Byte(offset) => write!(f, "byte {offset}"),
        }
    }
}

/// Why a mesh could not be made.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum MeshError {
    /// Invalid parameters of a generator; all problems at once.
    #[error("{generator}: {}", list(problems))]
    Parameters {
        /// Name of the generator ("hollow_ball").
        generator: &'static str,
        /// All parameters out of range.
        problems: Vec<ParameterProblem>,
    },
    /// A file that violates its format, or is inconsistent.
    #[error("{place}: {message}")]
    Malformed {
        /// Line or byte of the error.
        place: Place,
        /// What was expected, and what was found.
        message: String,
    },
    /// Volume elements of unsupported kinds.
    #[error("supported volume elements are {}, but the file contains {}", list(&understood()), list(kinds))]
    UnsupportedElements {
        /// Each kind found, with its count ("pyramid of 5 nodes (120)").
        kinds: Vec<String>,
    },
    /// A file with an unsupported version, encoding or keyword.
    #[error("{what}: {remedy}")]
    Unsupported {
        /// Version, encoding or keyword that was found.
        what: String,
        /// How to correct it.
        remedy: String,
    },
    /// There is no volume element.
    #[error("the mesh has no volume elements")]
    Empty,
    /// A requested part does not exist.
    #[error("no part is called {name:?}; the mesh has {}", list(known))]
    UnknownPart {
        /// Name of the part that was requested.
        name: String,
        /// Names of the existing parts.
        known: Vec<String>,
    },
    /// A kind of cell that cannot be refined.
    #[error("a {kind} cannot be refined: refine the mesh in the program that made it")]
    Unrefinable {
        /// Name of the kind.
        kind: &'static str,
    },
    /// A transformation that would invert elements or give positions that are not finite.
    #[error("a mesh transformation needs finite numbers and a positive scale, not the scale {scale}")]
    Transform {
        /// The given scale [-].
        scale: f64,
    },
    /// A surface that no distance can be computed from.
    #[error("no distance can be measured from the surface: {reason}")]
    Surface {
        /// The defect of the surface.
        reason: String,
    },
}

/// Names of the supported kinds.
fn understood() -> Vec<&'static str> {
    CellKind::ALL.map(|kind| kind.table().title).to_vec()
}

/// Items separated by commas.
fn list<T: fmt::Display>(items: &[T]) -> String {
    items.iter().map(T::to_string).collect::<Vec<_>>().join(", ")
}
