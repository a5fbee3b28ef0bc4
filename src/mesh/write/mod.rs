//! Mesh files written.

pub mod gmsh;
