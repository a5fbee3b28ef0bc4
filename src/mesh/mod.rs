//! Meshes: read, write, generate, surface, quality.
//!
//! A [`Mesh`] is plain data in metres. `generate` makes one from a few numbers, `read` reads one from a file; `surface`
//! finds its skin; `quality` judges it.

pub mod generate;
pub mod quality;
pub mod read;
pub mod surface;

use crate::mechanics::tensor::Vec3;
use std::collections::BTreeMap;

/// A mesh of eight-node hexahedra in named parts, with named node sets.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Mesh {
    /// Positions X [m], one a node.
    pub nodes: Vec<Vec3>,
    /// Corner nodes of each hex8: 0–3 counter-clockwise on the bottom seen from the top, 4–7 above them (the order of
    /// Gmsh, Abaqus and VTK).
    pub hexes: Vec<[u32; 8]>,
    /// Part of each element, an index into `parts`.
    pub part_of: Vec<u32>,
    /// Names of the parts ("muscle", "rubber", …).
    pub parts: Vec<String>,
    /// Node sets by name ("bone_surface", "bottom", …), each sorted and without repetition.
    pub node_sets: BTreeMap<String, Vec<u32>>,
    /// Material axes of each element, rows e1, e2, e3 (orthonormal, right-handed, in the reference frame); empty when
    /// the mesh carries none (then the axes are x, y, z, or what the scene says).
    pub axes: Vec<[Vec3; 3]>,
    /// What the surface approximates, for the notes of the report ("faceted ball: 1.7 % below the exact volume").
    pub notes: Vec<String>,
}
