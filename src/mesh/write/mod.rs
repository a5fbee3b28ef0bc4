//! Mesh files written.
