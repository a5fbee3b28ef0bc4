//! Elements: shape functions, quadrature, reference geometry, stabilisation.

mod corner_penalty;
mod geometry;
mod hex8;
mod hex8_modes;
mod hourglass;
mod interface;
mod kind;
mod largest_eigenvalue;
mod tet10;
mod tet4;
mod wedge6;

pub use corner_penalty::{CornerResponse, corner_stiffness, eval_corner_penalty};
pub use geometry::{OfElement, ReferenceGeometry};
pub use hex8::{GAUSS, HEX8_CORNERS, HEX8_DIAGONALS, HEX8_EDGES, Hex8, POINTS, shape_at};
pub use hex8_modes::{ModalGeometry, Modes, V3};
pub use hourglass::{Hourglass, HourglassResponse};
pub use interface::Element;
pub(crate) use kind::for_each_element;
pub use kind::{ElementKind, MOST_NODES, MOST_POINTS};
pub(crate) use largest_eigenvalue::largest_eigenvalue;
pub use tet4::Tet4;
pub use tet10::Tet10;
pub use wedge6::Wedge6;
