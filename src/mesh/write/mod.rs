//! Writers of mesh files.

pub mod gmsh;
