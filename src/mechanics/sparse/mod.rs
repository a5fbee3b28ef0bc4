//! Sparse symmetric systems of nodal unknowns: numbering, matrix, factor.
//!
//! The graph of the *nodes* is ordered once by nested dissection ([`Unknowns`]); that fixes the pattern of a
//! [`SymmetricMatrix`], which is assembled element by element in a fixed order; a [`Cholesky`] factor reuses its
//! symbolic analysis and its memory.

mod cholesky;
mod matrix;
mod ordering;
mod panels;
mod pattern_inverse;
#[cfg(test)]
mod tests;
mod unknowns;

pub(crate) use ordering::Graph;

pub use cholesky::{Cholesky, Definiteness};
pub use matrix::SymmetricMatrix;
pub use pattern_inverse::PatternInverse;
pub use unknowns::Unknowns;

/// Why a sparse system cannot be built or factored.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum SparseError {
    /// The graph could not be ordered.
    #[error("the graph of {nodes} nodes could not be ordered: {reason}")]
    Ordering {
        /// Number of nodes in the graph.
        nodes: usize,
        /// Message of the ordering.
        reason: String,
    },
    /// The factor does not fit: too many entries, or too little memory.
    #[error("the factor of {unknowns} unknowns does not fit: {reason}")]
    TooLarge {
        /// Number of unknowns of the system.
        unknowns: usize,
        /// Message of the analysis.
        reason: String,
    },
}
