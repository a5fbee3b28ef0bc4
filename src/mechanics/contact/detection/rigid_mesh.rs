//! Mesh side of a pair with a rigid body, divided into parts that threads process independently.

use super::boundary::Boundary;
use super::part::range_of;
use super::rigid_faces::Place;
use crate::contact::{Contact, Surface};
use crate::tensor::Vec3;
use std::ops::Range;

/// Largest number of places of a face: the corners of a box, two on each edge, one inside. Polyhedra may have more corners.
const MOST_PLACES: usize = 17;

/// The boundary surface of a mesh.
#[derive(Clone, Debug)]
pub(super) struct MeshSide {
    pub boundary: Boundary,
    /// Edges of each face that are checked with it: each edge of the mesh once.
    pub owns: Vec<[bool; 4]>,
}

impl MeshSide {
    /// At the positions `x` [m].
    pub fn new(surface: &Surface, x: &[Vec3]) -> Self {
        let mut owns = vec![[false; 4]; surface.faces.len()];
        let edge = |(face, k): (usize, usize)| {
            let corners = &surface.faces[face];
            let count = if corners[2] == corners[3] { 3 } else { 4 };
            let (a, b) = (corners[k % count], corners[(k + 1) % count]);
            ([a.min(b), a.max(b)], face, k)
        };
        let places = (0..surface.faces.len()).flat_map(|face| (0..4).map(move |k| (face, k)));
        let mut edges: Vec<([u32; 2], usize, usize)> = places.map(edge).collect();
        edges.sort_unstable();
        edges.dedup_by_key(|edge| edge.0);
        for (_, face, k) in edges {
            owns[face][k] = true;
        }
        Self { boundary: Boundary::new(surface, x), owns }
    }
}

/// A run of the nodes and of the faces of a mesh, examined by one thread, with room for what it finds.
#[derive(Clone, Debug, Default)]
pub(super) struct MeshPart {
    /// Places of its nodes in the boundary, and its faces.
    pub nodes: Range<usize>,
    pub faces: Range<usize>,
    pub of_nodes: Vec<Contact>,
    pub of_faces: Vec<Contact>,
    /// Faces near the body.
    pub near: Vec<u32>,
    /// Places of the present face.
    pub places: Vec<Place>,
}

impl MeshPart {
    /// Room for a contact of each of so many nodes and faces.
    pub fn with_capacity(most: usize) -> Self {
        let contacts = || Vec::with_capacity(most);
        let (near, places) = (Vec::with_capacity(most), Vec::with_capacity(MOST_PLACES));
        Self { of_nodes: contacts(), of_faces: contacts(), near, places, ..Self::default() }
    }

    /// Begins with the `i`-th part of a mesh.
    pub fn begin(&mut self, i: usize, mesh: &MeshSide) {
        self.nodes = range_of(i, mesh.boundary.nodes.len());
        self.faces = range_of(i, mesh.owns.len());
    }
}
