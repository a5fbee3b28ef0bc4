//! A layer of hexahedra on the outer surface. It begins thin, so that its elements are sound on the steps of the octree, and gets
//! its thickness while nodes are moved.

use super::elements::{Elements, Skin};
use super::grid::OUTSIDE;
use super::surfaces::Surfaces;
use crate::mechanics::tensor::{Mat3, Vec3};
use crate::mesh::CellKind;

/// Thickness of the layer at first, in edges of the smallest element [-], at most.
const FIRST_THICKNESS: f64 = 0.35;

/// Added to the diagonal of the equations for the direction of a node, relative to their trace [-].
const DAMPING: f64 = 1e-3;

impl Elements {
    /// Puts a layer of elements of a new class onto the outer faces of the parts; it will be `thickness` thick [m].
    pub fn add_skin(&mut self, class: u8, is_part: &[bool], thickness: f64) {
        let mut skin =
            Skin { first_node: self.nodes.len(), first_element: self.hexes.len(), ..Skin::default() };
        let outer: Vec<([u32; 4], u32)> = self
            .faces
            .iter()
            .filter(|face| {
                face.behind == OUTSIDE && is_part[usize::from(self.classes[face.element as usize])]
            })
            .map(|face| (face.nodes, face.element))
            .collect();
        // The sums of n nᵀ and n over the faces at each node.
        let mut normals: Vec<(Mat3, Vec3)> = Vec::new();
        for (face, element) in outer {
            let x = face.map(|node| self.nodes[node as usize]);
            let normal = (x[2] - x[0]).cross(&(x[3] - x[1])).try_normalize(0.0).unwrap_or_else(Vec3::zeros);
            let above = face.map(|below| {
                let next = (skin.first_node + skin.below.len()) as u32;
                let node = *skin.above.entry(below).or_insert(next);
                if node == next {
                    skin.below.push(below);
                    normals.push((Mat3::zeros(), Vec3::zeros()));
                }
                let (matrix, sum) = &mut normals[node as usize - skin.first_node];
                *matrix += normal * normal.transpose();
                *sum += normal;
                node
            });
            let [[a, b, c, d], [e, f, g, h]] = [face, above];
            self.hexes.push([a, b, c, d, e, f, g, h]);
            self.classes.push(class);
            self.edges.push(self.edges[element as usize]);
            skin.under.push(element);
        }
        let finest = self.edges.iter().copied().fold(f64::INFINITY, f64::min);
        let first = thickness.min(FIRST_THICKNESS * finest);
        for (&below, (matrix, sum)) in skin.below.iter().zip(&normals) {
            let below = below as usize;
            self.nodes.push(self.nodes[below] + outwards(matrix, sum, self.is_fixed[below]) * first);
            self.is_fixed.push(self.is_fixed[below]);
            self.around.push(self.around[below]);
        }
        self.hang_skin(&skin);
        self.skin = Some(skin);
    }

    /// Volume of the layer [m³], and the mean of its inner and its outer area [m²], across the normal of the smooth surface: the
    /// volume over the area is the thickness, up to terms of the third order. `None` without a layer.
    pub fn skin_volume(&self, surfaces: &mut Surfaces) -> Option<[f64; 2]> {
        let skin = self.skin.as_ref()?;
        let mut sums = [0.0; 2];
        for hex in &self.hexes[skin.first_element..] {
            let x = hex.map(|node| self.nodes[node as usize]);
            sums[0] += CellKind::Hex8.volume_m3(&x);
            let normal = surfaces.outward_normal(&(x[4..].iter().sum::<Vec3>() / 4.0));
            let of = |i: usize| 0.5 * (x[i + 2] - x[i]).cross(&(x[i + 3] - x[i + 1]));
            sums[1] += 0.5 * normal.dot(&(of(0) + of(4)));
        }
        Some(sums)
    }

    /// Outer nodes hang between others where those below them do, on an edge of the surface.
    fn hang_skin(&mut self, skin: &Skin) {
        let edge = |a: u32, b: u32| [a.min(b), a.max(b)];
        let mut edges: Vec<[u32; 2]> = Vec::new();
        for hex in &self.hexes[skin.first_element..] {
            edges.extend((0..4).map(|i| edge(hex[i], hex[(i + 1) % 4])));
        }
        edges.sort_unstable();
        let mut more = Vec::new();
        for (below, &node) in &skin.above {
            let Some(&[a, b]) = self.hanging.get(below).map(Vec::as_slice) else { continue };
            if edges.binary_search(&edge(a, b)).is_ok() {
                more.push((node, vec![skin.above[&a], skin.above[&b]]));
            }
        }
        self.hanging.extend(more);
    }
}

/// The displacement d with n · d = 1 for all faces of a node, in the mean.
fn outwards(matrix: &Mat3, sum: &Vec3, is_fixed: [bool; 3]) -> Vec3 {
    let (mut matrix, mut right) = (*matrix, *sum);
    for k in (0..3).filter(|k| is_fixed[*k]) {
        matrix.row_mut(k).fill(0.0);
        matrix.column_mut(k).fill(0.0);
        right[k] = 0.0;
    }
    // Across the normals nothing is known: the damping keeps it where it is.
    let damped = matrix + Mat3::identity() * (DAMPING * matrix.trace().max(f64::MIN_POSITIVE));
    damped.cholesky().map_or_else(Vec3::zeros, |factor| factor.solve(&right))
}
