//! Elements: shape functions, quadrature and reference geometry.

mod hex8;
mod largest_eigenvalue;

pub use hex8::{
    DERIVATIVE, HEX8_DIAGONALS, HEX8_EDGES, Hex8, LocalGradients, POINTS, ReferenceGeometry, shape_at,
};
