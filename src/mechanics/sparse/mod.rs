//! Sparse symmetric systems of nodal unknowns: numbering, matrix, factor.
//!
//! The graph of the *nodes* is ordered once by nested dissection ([`Unknowns`]); a [`SymmetricMatrix`] has its pattern from
//! then on and is filled element by element in a fixed order; a [`Cholesky`] factor keeps its symbolic analysis and its memory.

mod cholesky;
mod matrix;
mod ordering;
mod panels;
#[cfg(test)]
mod tests;
mod unknowns;

pub use cholesky::{Cholesky, Definiteness};
pub use matrix::SymmetricMatrix;
pub use unknowns::Unknowns;

/// Why a sparse system cannot be made or factored.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum SparseError {
    /// The graph could not be ordered.
    #[error("the graph of {nodes} nodes could not be ordered: {reason}")]
    Ordering {
        /// Nodes of the graph.
        nodes: usize,
        /// What the ordering said.
        reason: String,
    },
    /// The factor does not fit: too many entries, or too little memory.
    #[error("the factor of {unknowns} unknowns does not fit: {reason}")]
    TooLarge {
        /// Unknowns.
        unknowns: usize,
        /// What the analysis said.
        reason: String,
    },
}
