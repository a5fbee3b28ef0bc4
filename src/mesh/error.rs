//! What can go wrong with a mesh.

use super::cell::CellKind;
use std::fmt;

/// A number of a generator that is out of its range.
#[derive(Clone, Debug, PartialEq)]
pub struct ParameterProblem {
    /// The field of the generator, as it is spelled there (`inner_radius_m`, `cuts_x.inner_m[3]`).
    pub field: String,
    /// The value found; counts are given as numbers too.
    pub value: f64,
    /// The limit that it breaks ("> 0").
    pub limit: String,
    /// What to do about it.
    pub remedy: String,
}

impl fmt::Display for ParameterProblem {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} = {} must be {}: {}", self.field, self.value, self.limit, self.remedy)
    }
}

/// Where in a file something was found.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Place {
    /// A line of a text file, from 1.
    Line(usize),
    /// An offset from the beginning of a binary file, from 0.
    Byte(usize),
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Place::Line(line) => write!(f, "line {line}"),
            Place::Byte(offset) => write!(f, "byte {offset}"),
        }
    }
}

/// Why there is no mesh.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum MeshError {
    /// A generator was asked for something that it cannot build; all problems at once.
    #[error("{generator}: {}", list(problems))]
    Parameters {
        /// The generator ("hollow_ball").
        generator: &'static str,
        /// Every number that is out of range.
        problems: Vec<ParameterProblem>,
    },
    /// A file that breaks its format, or says something impossible.
    #[error("{place}: {message}")]
    Malformed {
        /// Where.
        place: Place,
        /// What was expected, and what was found.
        message: String,
    },
    /// Volume elements of kinds that are not read.
    #[error("of volume elements {} are understood, but the file holds {}", list(&understood()), list(kinds))]
    UnsupportedElements {
        /// Each kind found, with its count ("pyramid of 5 nodes (120)").
        kinds: Vec<String>,
    },
    /// A file in a version, an encoding or with a keyword that is refused.
    #[error("{what}: {remedy}")]
    Unsupported {
        /// What was found.
        what: String,
        /// What to do about it.
        remedy: String,
    },
    /// No volume element anywhere.
    #[error("the mesh has no volume elements")]
    Empty,
    /// A part was asked for that does not exist.
    #[error("no part is called {name:?}; the mesh has {}", list(known))]
    UnknownPart {
        /// The name asked for.
        name: String,
        /// The names there are.
        known: Vec<String>,
    },
    /// A kind of cell that is not split into smaller ones.
    #[error("a {kind} cannot be refined: refine the mesh where it is made")]
    Unrefinable {
        /// The kind.
        kind: &'static str,
    },
    /// A transformation that would turn elements inside out or move them nowhere.
    #[error("a mesh is transformed by finite numbers and a positive scale, not by the scale {scale}")]
    Transform {
        /// The scale given.
        scale: f64,
    },
    /// A surface without faces has no depth below it.
    #[error("the surface cannot carry a distance: {reason}")]
    Surface {
        /// Why not.
        reason: String,
    },
}

/// What the kinds that are read are called.
fn understood() -> Vec<&'static str> {
    CellKind::ALL.map(|kind| kind.table().title).to_vec()
}

/// Items one after the other, with commas.
fn list<T: fmt::Display>(items: &[T]) -> String {
    items.iter().map(T::to_string).collect::<Vec<_>>().join(", ")
}
