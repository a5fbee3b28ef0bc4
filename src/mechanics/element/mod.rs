//! Elements: shape functions, quadrature, reference geometry, stabilisation.

mod corner_penalty;
mod hex8;
mod hex8_modes;
mod hourglass;
mod largest_eigenvalue;

pub use corner_penalty::{CornerResponse, corner_stiffness, eval_corner_penalty};
pub use hex8::{
    DERIVATIVE, HEX8_CORNERS, HEX8_DIAGONALS, HEX8_EDGES, Hex8, LocalGradients, POINTS, ReferenceGeometry,
    shape_at,
};
pub use hex8_modes::{ModalGeometry, Modes, V3};
pub use hourglass::{Hourglass, HourglassResponse};
pub(in crate::mechanics) use largest_eigenvalue::largest_eigenvalue;
