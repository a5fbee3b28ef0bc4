//! Local refinement: repeated splitting of hexahedra into eight, with hanging nodes between coarse and fine ones. Other kinds of elements
//! are not split, nor are hexahedra that touch them.
//!
//! Neighbours across faces, edges and corners differ by at most one level, so a face has at most one hanging node at its
//! centre and one at the middle of each edge, and the masters of hanging nodes do not hang. New nodes lie on the trilinear
//! elements: curved surfaces keep their facets.

use super::cells::{Cell, Cells};
use super::refine::{Split, edges_and_faces};
use super::refinement_region::{MOST_HALVINGS, Region};
use super::surface::{boundary, boundary_nodes};
use super::{CellKind, Mesh};

/// Refinement would exceed the allowed number of elements; nothing of that size has been allocated.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TooMany {
    /// Number of elements that refinement would need, at least.
    pub elements: u64,
}

/// Splits the elements of a mesh where the regions require it; also returns how many of the given elements were split.
///
/// Parts, material axes and node sets are inherited as in [`super::refine::refined`]; elements keep their order, with
/// children in place of their parent.
///
/// # Errors
/// [`TooMany`] if there would be more than `most` elements.
pub fn refined_in(mesh: &Mesh, regions: &[Region], most: u64) -> Result<(Mesh, usize), TooMany> {
    let mut refinement = Refinement::new(mesh);
    while refinement.split_once(regions, most)? {}
    Ok(refinement.finish(mesh))
}

/// A mesh during refinement.
struct Refinement {
    split: Split,
    cells: Cells,
    /// Original element of each element, and its level below it.
    origin: Vec<u32>,
    level: Vec<u8>,
}

impl Refinement {
    fn new(mesh: &Mesh) -> Self {
        Self {
            split: Split::new(mesh),
            cells: mesh.cells.clone(),
            origin: (0..mesh.cells.len() as u32).collect(),
            level: vec![0; mesh.cells.len()],
        }
    }

    /// Splits elements that are too large and those needed for balance; returns whether any was split.
    fn split_once(&mut self, regions: &[Region], most: u64) -> Result<bool, TooMany> {
        let is_split = self.balanced(|cell| {
            let Ok(nodes) = <[u32; 8]>::try_from(cell.nodes) else { return false };
            let corners = nodes.map(|node| self.split.nodes[node as usize]);
            regions.iter().any(|region| region.splits(&corners))
        });
        let count = is_split.iter().filter(|is_split| **is_split).count();
        let elements = (self.cells.len() + 7 * count) as u64;
        if elements > most {
            return Err(TooMany { elements });
        }
        let (mut cells, mut origin, mut level) = (Cells::default(), Vec::new(), Vec::new());
        for (e, cell) in self.cells.iter().enumerate() {
            let has_children = is_split[e] && self.split.add_children(cell, &mut cells).is_ok();
            if !has_children {
                cells.push(cell.kind, cell.nodes);
            }
            origin.resize(cells.len(), self.origin[e]);
            level.resize(cells.len(), self.level[e] + u8::from(has_children));
        }
        (self.cells, self.origin, self.level) = (cells, origin, level);
        Ok(count > 0)
    }

    /// Elements to split: those that are too large, and coarser ones that touch one of them.
    fn balanced(&self, is_too_large: impl Fn(Cell<'_>) -> bool) -> Vec<bool> {
        let kept = self.kept();
        let halvable = |e: usize| self.level[e] < MOST_HALVINGS && !kept.get(e).is_some_and(|kept| *kept);
        let elements = self.cells.iter().enumerate();
        let mut is_split: Vec<bool> = elements.map(|(e, cell)| halvable(e) && is_too_large(cell)).collect();
        let mut open: Vec<usize> = (0..self.cells.len()).filter(|e| is_split[*e]).collect();
        if open.is_empty() {
            return is_split;
        }
        let touching = self.elements_at_nodes();
        while let Some(e) = open.pop() {
            for node in self.nodes_on(e) {
                for other in touching[node as usize].iter().map(|other| *other as usize) {
                    if self.level[other] < self.level[e] && !is_split[other] && halvable(other) {
                        is_split[other] = true;
                        open.push(other);
                    }
                }
            }
        }
        is_split
    }

    /// Elements of a mixed mesh that cannot be split; empty if all are hexahedra. Other kinds are not, nor are hexahedra that touch
    /// them, since a split face does not fit their triangles, nor those that would differ by two levels from one that is kept.
    fn kept(&self) -> Vec<bool> {
        let kind = |e: usize| self.cells.kind(e);
        if (0..self.cells.len()).all(|e| kind(e) == CellKind::Hex8) {
            return Vec::new();
        }
        let touching = self.elements_at_nodes();
        let mut by_level: Vec<usize> = (0..self.cells.len()).collect();
        by_level.sort_by_key(|e| self.level[*e]);
        let mut kept = vec![false; self.cells.len()];
        for e in by_level {
            let others = self.nodes_on(e).into_iter().flat_map(|node| &touching[node as usize]);
            kept[e] = kind(e) != CellKind::Hex8
                || others.map(|other| *other as usize).any(|other| {
                    kind(other) != CellKind::Hex8 || (self.level[other] < self.level[e] && kept[other])
                });
        }
        kept
    }

    fn elements_at_nodes(&self) -> Vec<Vec<u32>> {
        let mut touching = vec![Vec::new(); self.split.nodes.len()];
        for e in 0..self.cells.len() {
            for node in self.nodes_on(e) {
                touching[node as usize].push(e as u32);
            }
        }
        touching
    }

    /// Corners of an element, and the nodes that hang on it.
    fn nodes_on(&self, e: usize) -> Vec<u32> {
        let cell = self.cells.get(e);
        let mut nodes = cell.nodes.to_vec();
        nodes.extend(edges_and_faces(cell).filter_map(|corners| self.split.made_middle(&corners)));
        nodes
    }

    fn finish(self, mesh: &Mesh) -> (Mesh, usize) {
        let hanging = self.split.hanging(&self.cells);
        let fine_boundary = boundary_nodes(&hanging.boundary(boundary(&self.cells)));
        let coarse_boundary = boundary_nodes(&mesh.hanging.boundary(boundary(&mesh.cells)));
        let of_origin = || self.origin.iter().map(|e| *e as usize);
        let mut split_origins: Vec<u32> =
            self.origin.iter().zip(&self.level).filter(|(_, level)| **level > 0).map(|(e, _)| *e).collect();
        split_origins.dedup();
        let fine = Mesh {
            part_of: of_origin().filter_map(|e| mesh.part_of.get(e).copied()).collect(),
            axes: of_origin().filter_map(|e| mesh.axes.get(e).copied()).collect(),
            fields: mesh.fields.of_elements(&of_origin()),
            parts: mesh.parts.clone(),
            node_sets: self.split.refined_sets(mesh, &coarse_boundary, &fine_boundary),
            notes: mesh.notes.clone(),
            nodes: self.split.nodes,
            cells: self.cells,
            hanging,
        };
        (fine, split_origins.len())
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)] // tests may panic
mod tests {
    use super::super::generate::block::Block;
    use super::super::generate::limb_segment::LimbSegment;
    use super::super::quality::quality;
    use super::super::refine::refined;
    use super::super::refinement_region::Place;
    use super::super::surface::{enclosed_volume_m3, is_closed};
    use super::*;
    use crate::mechanics::followers::Followers;
    use crate::mechanics::tensor::Vec3;

    fn block() -> Mesh {
        Block::uniform(Vec3::zeros(), Vec3::new(8.0, 8.0, 4.0), [8, 8, 4], "b").generate().unwrap()
    }

    fn at_top(mesh: &Mesh, within: f64, size: f64) -> Region {
        Region { places: Place::on_all(mesh, &[Vec3::new(4.0, 4.0, 4.0)]), within, size }
    }

    #[test]
    fn elements_are_small_near_the_place_and_the_boundary_is_closed() {
        for (size, halvings) in [(0.5, 1), (0.25, 2)] {
            let coarse = block();
            let (fine, split) = refined_in(&coarse, &[at_top(&coarse, 1.5, size)], 1_000_000).unwrap();
            let least = (0..fine.cells.len()).map(|e| {
                (fine.cells.points(e, &fine.nodes)[1] - fine.cells.points(e, &fine.nodes)[0]).norm()
            });
            assert!((least.fold(f64::INFINITY, f64::min) - 0.5_f64.powi(halvings)).abs() < 1e-12);
            assert!(split > 8 && split < coarse.cells.len() && !fine.hanging.is_empty());
            assert!((fine.volume_m3() - 256.0).abs() < 1e-10);
            let faces = fine.hanging.boundary(boundary(&fine.cells));
            assert!(is_closed(&faces));
            assert!((enclosed_volume_m3(&faces, &fine.nodes) - 256.0).abs() < 1e-10);
            assert!(
                faces.iter().any(|face| face[2] == face[3]),
                "coarse faces are cut where nodes hang on them"
            );
        }
    }

    #[test]
    fn hanging_nodes_lie_on_what_they_hang_on_and_linear_fields_stay_linear() {
        let coarse = block();
        let (fine, _) = refined_in(&coarse, &[at_top(&coarse, 1.0, 0.2)], 1_000_000).unwrap();
        let followers = Followers::new(fine.nodes.len(), &fine.hanging.ties()).unwrap();
        assert_eq!(followers.len(), fine.hanging.len());
        let hangs = |node: &u32| followers.contains(*node as usize);
        assert!(!fine.hanging.each().any(|(_, others)| others.iter().any(hangs)), "there are no chains");
        let mut placed = fine.nodes.clone();
        followers.follow(&mut placed);
        let worst = placed.iter().zip(&fine.nodes).map(|(a, b)| (a - b).norm()).fold(0.0, f64::max);
        assert!(worst < 1e-14, "{worst:e}");
    }

    #[test]
    fn neighbours_differ_by_one_halving() {
        let coarse = block();
        let (fine, _) = refined_in(&coarse, &[at_top(&coarse, 0.3, 0.13)], 1_000_000).unwrap();
        let edge =
            |e: usize| (fine.cells.points(e, &fine.nodes)[1] - fine.cells.points(e, &fine.nodes)[0]).norm();
        // Elements touch if their bounding boxes do.
        let boxes: Vec<[Vec3; 2]> = (0..fine.cells.len())
            .map(|e| [fine.cells.points(e, &fine.nodes)[0], fine.cells.points(e, &fine.nodes)[6]])
            .collect();
        for (a, [low_a, high_a]) in boxes.iter().enumerate() {
            for (b, [low_b, high_b]) in boxes.iter().enumerate().filter(|(b, _)| *b < a) {
                if (0..3).all(|i| low_a[i] <= high_b[i] + 1e-9 && low_b[i] <= high_a[i] + 1e-9) {
                    assert!((edge(a) / edge(b)).log2().abs() < 1.5, "{a} {b}");
                }
            }
        }
    }

    /// A block whose upper half is split into wedges or tetrahedra.
    fn mixed(split: impl Fn(Mesh) -> Mesh) -> Mesh {
        let half = |z: f64| {
            let (origin, size) = (Vec3::new(0.0, 0.0, z), Vec3::new(8.0, 8.0, 2.0));
            Block::uniform(origin, size, [8, 8, 2], "b").generate().unwrap()
        };
        let (lower, upper) = (half(0.0), split(half(2.0)));
        // Nodes of both at z = 2 are one.
        let mut nodes = lower.nodes.clone();
        let number: Vec<u32> = (upper.nodes.iter())
            .map(|X| {
                let known = lower.nodes.iter().position(|other| (other - X).norm() < 1e-9);
                known.unwrap_or_else(|| {
                    nodes.push(*X);
                    nodes.len() - 1
                }) as u32
            })
            .collect();
        let mut cells = lower.cells.clone();
        for cell in upper.cells.iter() {
            cells.push(cell.kind, &cell.nodes.iter().map(|node| number[*node as usize]).collect::<Vec<_>>());
        }
        let part_of = vec![0; cells.len()];
        Mesh {
            nodes,
            cells,
            part_of,
            axes: Vec::new(),
            node_sets: std::collections::BTreeMap::new(),
            ..lower
        }
    }

    #[test]
    fn hexahedra_that_touch_other_elements_are_not_split() {
        for split in [Mesh::split_to_wedges as fn(&Mesh) -> Mesh, Mesh::split_to_tetrahedra] {
            let coarse = mixed(|mesh| split(&mesh));
            let place = Place { point: Vec3::new(4.0, 4.0, 2.0), normal: Vec3::zeros() };
            let region = Region { places: vec![place], within: 2.0, size: 0.25 };
            let (fine, _) = refined_in(&coarse, &[region], 1_000_000).unwrap();
            let is_at_top = |X: &Vec3| (X.z - 2.0).abs() < 1e-9;
            let at_top = |mesh: &Mesh| mesh.nodes.iter().filter(|X| is_at_top(X)).count();
            assert_eq!(at_top(&fine), at_top(&coarse), "no new node on the other elements");
            // From there on elements may be smaller by one level a layer.
            let hexahedra = (0..fine.cells.len()).filter(|e| fine.cells.kind(*e) == CellKind::Hex8);
            let edges = hexahedra.map(|e| {
                let points = fine.cells.points(e, &fine.nodes);
                ((points[1] - points[0]).norm(), points.iter().any(is_at_top))
            });
            let mut least = [f64::INFINITY; 2];
            for (edge, touches) in edges {
                let least = &mut least[usize::from(!touches)];
                *least = least.min(edge);
            }
            assert!((least[0] - 1.0).abs() < 1e-12 && (least[1] - 0.25).abs() < 1e-12, "{least:?}");
            assert!((fine.volume_m3() - 256.0).abs() < 1e-10);
        }
    }

    #[test]
    fn what_hangs_already_is_used_again_when_everything_is_split() {
        let coarse = block();
        let (fine, _) = refined_in(&coarse, &[at_top(&coarse, 1.5, 0.5)], 1_000_000).unwrap();
        let finer = refined(&fine).unwrap();
        assert_eq!(finer.cells.len(), 8 * fine.cells.len());
        assert_eq!(quality(&finer).unwrap().coincident_nodes.count, 0);
        let faces = finer.hanging.boundary(boundary(&finer.cells));
        assert!(!finer.hanging.is_empty() && is_closed(&faces));
        assert!((enclosed_volume_m3(&faces, &finer.nodes) - 256.0).abs() < 1e-10);
        let mut placed = finer.nodes.clone();
        Followers::new(finer.nodes.len(), &finer.hanging.ties()).unwrap().follow(&mut placed);
        assert!(placed.iter().zip(&finer.nodes).all(|(a, b)| (a - b).norm() < 1e-14));
    }

    #[test]
    fn a_set_has_a_hanging_node_only_with_all_that_it_hangs_on() {
        let coarse = block();
        let (fine, _) = refined_in(&coarse, &[at_top(&coarse, 1.5, 0.5)], 1_000_000).unwrap();
        let (node, others) = fine.hanging.each().next().unwrap();
        let sorted = |nodes: &[u32]| {
            let mut nodes = nodes.to_vec();
            nodes.sort_unstable();
            nodes
        };
        let mut whole = sorted(&[others, &[node]].concat());
        let all = whole.clone();
        fine.hanging.complete(&mut whole);
        assert_eq!(whole, all);
        let mut part = sorted(&[&others[1..], &[node]].concat());
        fine.hanging.complete(&mut part);
        assert_eq!(part, sorted(&others[1..]));
    }

    #[test]
    fn parts_sets_and_axes_follow_and_too_many_elements_are_refused() {
        let limb = LimbSegment { elements_around: 16, elements_along: 6, ..LimbSegment::default() };
        let coarse = limb.generate().unwrap();
        let top = coarse.nodes.iter().max_by(|a, b| a.z.total_cmp(&b.z)).copied().unwrap();
        let region = Region { places: Place::on_all(&coarse, &[top]), within: 0.03, size: 0.006 };
        let (fine, split) = refined_in(&coarse, std::slice::from_ref(&region), 1_000_000).unwrap();
        assert!(split > 10 && fine.axes.len() == fine.cells.len() && fine.part_of.len() == fine.cells.len());
        for part in &coarse.parts {
            let (a, b) = (coarse.part_volume_m3(part), fine.part_volume_m3(part));
            assert!((a - b).abs() < 1e-12 * a, "{part}: {a} {b}");
        }
        let faces = fine.hanging.boundary(boundary(&fine.cells));
        assert!(is_closed(&faces));
        // The outer surface has its set before and after, with the nodes that hang on it.
        let outer: Vec<u32> = boundary_nodes(&faces);
        let known = |name: &str| fine.node_sets[name].iter();
        let mut named: Vec<u32> =
            ["bone", "skin_outer", "end_low", "end_high"].into_iter().flat_map(known).copied().collect();
        named.sort_unstable();
        named.dedup();
        assert_eq!(named, outer);
        let error = refined_in(&coarse, &[region], 600).unwrap_err();
        assert!(error.elements > 600);
    }
}
