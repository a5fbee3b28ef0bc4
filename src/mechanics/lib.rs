//! The mathematics: no input or output, no serde, no clock, no logging, and no allocation in a step.
//!
//! Read `real` and `tensor` first, then `material` (one file per law), `element` and `force` (internal forces of
//! blocks of elements), `rigid` (rigid bodies), and `contact` (detection, the bi-potential law and its Gauss–Seidel
//! solver).

pub mod contact;
pub mod dual;
pub mod element;
mod elementary;
pub mod face_load;
pub mod followers;
pub mod force;
pub mod lanes;
pub mod material;
pub mod principal;
#[cfg(test)]
mod random;
pub mod real;
pub mod registers;
pub mod rigid;
mod row;
pub mod sparse;
pub mod tensor;
pub mod threads;
