//! Topology of a surface (neighbours across edges, faces around nodes, sizes) and its normals.

use super::closest_point::Patch;
use crate::contact::Surface;
use crate::tensor::Vec3;

/// No face across the edge: it is on the border of an open surface.
pub(super) const NONE: u32 = u32::MAX;
/// The mirror image of the face is across the edge, in the plane of symmetry normal to x; then y and z.
const MIRROR: [u32; 3] = [NONE - 1, NONE - 2, NONE - 3];

/// What is across an edge of a face.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::contact) enum Across {
    /// Nothing: the border of an open surface.
    Border,
    /// The mirror image of the face itself, in the plane of symmetry normal to this axis.
    Mirror(usize),
    /// A face.
    Face(u32),
}

/// A surface with the topology that detection needs. Constant over a run.
#[derive(Clone, Debug)]
pub(in crate::contact) struct Boundary {
    /// Global numbers of the nodes, sorted.
    pub nodes: Vec<u32>,
    /// Corner nodes of each face.
    pub faces: Vec<[u32; 4]>,
    /// Square root of each face's area at the start [m]: the length that tolerances refer to.
    pub sizes: Vec<f64>,
    /// The largest of `sizes` [m], and their mean.
    pub largest_size: f64,
    pub mean_size: f64,
    /// Whether every edge has a face on either side, or its mirror image, so that there is an inside.
    pub is_closed: bool,
    /// The face across each edge, `NONE`, or one of `MIRROR`.
    neighbours: Vec<[u32; 4]>,
    /// A node on the plane of symmetry normal to each axis, if the surface ends at one.
    pub mirrors: [Option<u32>; 3],
    /// The axes normal to the planes of symmetry that node i of `nodes` is on; empty if there are none.
    held: Vec<[bool; 3]>,
    /// Faces around node i of `nodes`: `around[starts[i]..starts[i + 1]]`, ascending.
    starts: Vec<u32>,
    around: Vec<u32>,
    /// Index in `nodes` of a global node number, offset by the least; `NONE` where there is none.
    places: Vec<u32>,
    least: u32,
}

impl Boundary {
    /// `x` [m]: positions of all nodes at the start of the run.
    pub fn new(surface: &Surface, x: &[Vec3]) -> Self {
        let nodes = surface.nodes.clone();
        let least = nodes.iter().copied().min().unwrap_or(0);
        let most = nodes.iter().copied().max().unwrap_or(0);
        let mut places = vec![NONE; (most - least) as usize + 1];
        for (i, &node) in nodes.iter().enumerate() {
            places[(node - least) as usize] = i as u32;
        }
        let sizes: Vec<f64> = surface.faces.iter().map(|f| Patch::new(f, x).area().sqrt()).collect();
        let neighbours = neighbours(surface);
        let mirrors = surface.mirrored.each_ref().map(|nodes| nodes.first().copied());
        let is_on = |node: &u32| surface.mirrored.each_ref().map(|on| on.binary_search(node).is_ok());
        let has_all = |(face, across): (&[u32; 4], &[u32; 4])| !across[..corner_count(face)].contains(&NONE);
        let mut boundary = Self {
            is_closed: surface.faces.iter().zip(&neighbours).all(has_all),
            neighbours,
            mirrors,
            held: if mirrors == [None; 3] { Vec::new() } else { nodes.iter().map(is_on).collect() },
            faces: surface.faces.clone(),
            largest_size: sizes.iter().copied().fold(0.0, f64::max),
            mean_size: sizes.iter().sum::<f64>() / sizes.len().max(1) as f64,
            sizes,
            starts: Vec::new(),
            around: Vec::new(),
            nodes,
            places,
            least,
        };
        boundary.gather_faces_around_nodes();
        boundary
    }

    fn gather_faces_around_nodes(&mut self) {
        let mut incident = Vec::new();
        for (i, face) in self.faces.iter().enumerate() {
            for &node in &face[..corner_count(face)] {
                if let Some(place) = self.place(node) {
                    incident.push((place as u32, i as u32));
                }
            }
        }
        incident.sort_unstable();
        self.starts = vec![0; self.nodes.len() + 1];
        for &(place, _) in &incident {
            self.starts[place as usize + 1] += 1;
        }
        for i in 0..self.nodes.len() {
            self.starts[i + 1] += self.starts[i];
        }
        self.around = incident.into_iter().map(|(_, face)| face).collect();
    }

    /// Index in `nodes` of a global node number.
    pub fn place(&self, node: u32) -> Option<usize> {
        let i = node.checked_sub(self.least)? as usize;
        self.places.get(i).filter(|&&place| place != NONE).map(|&place| place as usize)
    }

    /// Faces around a node (global number), ascending; none if it is not on this surface.
    pub fn faces_around(&self, node: u32) -> &[u32] {
        self.place(node).map_or(&[], |i| &self.around[self.starts[i] as usize..self.starts[i + 1] as usize])
    }

    /// Whether a face has a node in common with a face around a node.
    pub fn is_beside(&self, node: u32, face: u32) -> bool {
        let around = self.faces[face as usize].iter().flat_map(|&corner| self.faces_around(corner));
        around.copied().any(|beside| self.faces[beside as usize].contains(&node))
    }

    /// Its nodes that are not on the plane of symmetry normal to an axis.
    pub fn nodes_off(&self, axis: usize) -> impl Iterator<Item = u32> {
        self.nodes.iter().zip(&self.held).filter(move |(_, held)| !held[axis]).map(|(node, _)| *node)
    }

    /// What is across edge `k` of a face.
    pub fn across(&self, face: u32, k: usize) -> Across {
        match self.neighbours[face as usize][k] {
            NONE => Across::Border,
            other => match MIRROR.iter().position(|mirror| *mirror == other) {
                Some(axis) => Across::Mirror(axis),
                None => Across::Face(other),
            },
        }
    }

    /// A sum of normals at a node with those of the mirror images there, up to its length.
    fn with_mirror_images(&self, node: u32, mut sum: Vec3) -> Vec3 {
        if let Some(held) = self.place(node).and_then(|place| self.held.get(place)) {
            (0..3).filter(|axis| held[*axis]).for_each(|axis| sum[axis] = 0.0);
        }
        sum
    }

    /// Length of the shortest edge at a node, over the faces around it [m]; infinite without faces.
    pub fn shortest_edge_at(&self, node: u32, x: &[Vec3]) -> f64 {
        let of_face = |face: &u32| {
            let face = &self.faces[*face as usize];
            let n = corner_count(face);
            let k = face[..n].iter().position(|&f| f == node)?;
            let to = |k: usize| (x[face[k % n] as usize] - x[node as usize]).norm();
            Some(to(k + 1).min(to(k + n - 1)))
        };
        self.faces_around(node).iter().filter_map(of_face).fold(f64::INFINITY, f64::min)
    }

    /// Unit normal of the surface at a node: mean normal of its faces, weighted with the areas of their corners; zero
    /// where there are no faces.
    pub fn node_normal(&self, node: u32, x: &[Vec3]) -> Vec3 {
        let mut sum = Vec3::zeros();
        for &face in self.faces_around(node) {
            let face = &self.faces[face as usize];
            let n = corner_count(face);
            if let Some(k) = face[..n].iter().position(|&f| f == node) {
                let at = |k: usize| x[face[k % n] as usize];
                sum += (at(k + 1) - at(k)).cross(&(at(k + n - 1) - at(k)));
            }
        }
        self.with_mirror_images(node, sum).try_normalize(0.0).unwrap_or_else(Vec3::zeros)
    }

    /// Pseudo-normal at a node: the normals of its faces weighted with their angles; its sign relative to an offset
    /// distinguishes inside from outside also at a node (Bærentzen & Aanæs 2005). Not normalised.
    pub fn vertex_normal(&self, node: u32, x: &[Vec3]) -> Vec3 {
        let mut sum = Vec3::zeros();
        for &face in self.faces_around(node) {
            let face = &self.faces[face as usize];
            let patch = Patch::new(face, x);
            if let Some(k) = face[..patch.corner_count()].iter().position(|&f| f == node) {
                let (next, previous) = patch.edges_at(k);
                let cross = next.cross(&previous);
                let sine = cross.norm();
                if sine > 0.0 {
                    sum += cross * (sine.atan2(next.dot(&previous)) / sine);
                }
            }
        }
        self.with_mirror_images(node, sum)
    }

    /// Whether a face around the node has an edge without neighbour there.
    pub fn on_border(&self, node: u32) -> bool {
        self.faces_around(node).iter().any(|&f| {
            let face = &self.faces[f as usize];
            let n = corner_count(face);
            let is_at = |k: usize| face[k] == node || face[(k + 1) % n] == node;
            (0..n).any(|k| is_at(k) && self.across(f, k) == Across::Border)
        })
    }
}

/// Number of corners: 3 for a face that repeats its last node, else 4.
pub(super) fn corner_count(face: &[u32; 4]) -> usize {
    if face[2] == face[3] { 3 } else { 4 }
}

/// The face across each edge, or that its mirror image is. Edges of more than two faces count as border.
fn neighbours(Surface { faces, mirrored, .. }: &Surface) -> Vec<[u32; 4]> {
    let mut edges = Vec::new();
    for (i, face) in faces.iter().enumerate() {
        let n = corner_count(face);
        for k in 0..n {
            let (a, b) = (face[k], face[(k + 1) % n]);
            edges.push((a.min(b), a.max(b), i, k));
        }
    }
    edges.sort_unstable();
    let mut neighbours = vec![[NONE; 4]; faces.len()];
    let mirror_of = |a: u32, b: u32| {
        let has = |on: &Vec<u32>| [a, b].iter().all(|node| on.binary_search(node).is_ok());
        mirrored.iter().position(has).map_or(NONE, |axis| MIRROR[axis])
    };
    for run in edges.chunk_by(|e, f| (e.0, e.1) == (f.0, f.1)) {
        match *run {
            [(_, _, i, k), (_, _, j, l)] => {
                neighbours[i][k] = j as u32;
                neighbours[j][l] = i as u32;
            }
            [(a, b, i, k)] => neighbours[i][k] = mirror_of(a, b),
            _ => {}
        }
    }
    neighbours
}
