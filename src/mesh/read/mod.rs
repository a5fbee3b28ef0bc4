//! Mesh files read.
