//! The skin of a mesh: its outward quadrilateral faces.
