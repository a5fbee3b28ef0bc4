//! Quality of the elements of a mesh: scaled Jacobians, sizes, unused and coincident nodes.

use super::cell::CellKind;
use super::{ELEMENTS_OF_A_TASK, Mesh};
use crate::mechanics::tensor::Vec3;
use rayon::prelude::*;

/// Largest number of ids listed in [`Quality`]; the counts include all.
pub const LISTED: usize = 100;

/// Quality of one element.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ElementQuality {
    /// Smallest scaled Jacobian at the quadrature points [-], in [−1, 1].
    pub gauss_scaled_jacobian: f64,
    /// Smallest scaled Jacobian at the corners [-], in [−1, 1]; 1 for a brick, a regular tetrahedron, and a wedge with
    /// equal edges.
    pub corner_scaled_jacobian: f64,
    /// Volume of the element [m³].
    pub volume_m3: f64,
    /// Length of the shortest edge [m].
    pub min_edge_m: f64,
    /// Length of the longest edge [m].
    pub max_edge_m: f64,
}

impl ElementQuality {
    /// Smaller of the scaled Jacobians at the corners and at the Gauss points [-].
    pub fn min_scaled_jacobian(&self) -> f64 {
        self.gauss_scaled_jacobian.min(self.corner_scaled_jacobian)
    }
    /// Ratio of the longest to the shortest edge [-]; infinite when an edge has no length.
    pub fn aspect_ratio(&self) -> f64 {
        self.max_edge_m / self.min_edge_m
    }
}

/// Quality of one element from the positions [m] of its nodes.
pub fn element_quality(kind: CellKind, x: &[Vec3]) -> ElementQuality {
    let table = kind.table();
    let lengths = table.edges.iter().map(|&[a, b]| (x[a] - x[b]).norm());
    // As `CellKind::volume_m3`, with the Jacobians that are looked at anyway.
    let (mut gauss_scaled_jacobian, mut volume_m3) = (f64::INFINITY, 0.0);
    for (jacobian, weight) in kind.jacobians(x) {
        gauss_scaled_jacobian = gauss_scaled_jacobian.min(kind.scaled(&jacobian));
        volume_m3 += jacobian.determinant() * weight;
    }
    let at_corners = (0..table.corners).map(|corner| kind.corner_scaled_jacobian(x, corner));
    ElementQuality {
        gauss_scaled_jacobian,
        corner_scaled_jacobian: at_corners.fold(f64::INFINITY, f64::min),
        volume_m3,
        min_edge_m: lengths.clone().fold(f64::INFINITY, f64::min),
        max_edge_m: lengths.fold(0.0, f64::max),
    }
}

/// Elements or nodes with a common fault: their number, and the first ones.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Offenders {
    /// Number of all of them.
    pub count: usize,
    /// The first [`LISTED`] of them, ascending.
    pub first: Vec<u32>,
}

impl Offenders {
    fn push(&mut self, id: u32) {
        self.count += 1;
        if self.first.len() < LISTED {
            self.first.push(id);
        }
    }
}

/// Quality of a mesh.
#[derive(Clone, Debug, PartialEq)]
pub struct Quality {
    /// Smallest scaled Jacobian of all corners and Gauss points [-].
    pub min_scaled_jacobian: f64,
    /// Index of the element with that Jacobian.
    pub worst_element: u32,
    /// Elements whose Jacobian is not positive at some Gauss point: no element formulation can compute them.
    pub negative: Offenders,
    /// Elements with positive Jacobians at the Gauss points but not at a corner (wedges written as hexahedra, folded
    /// corners): they can be computed, with poor accuracy.
    pub folded_corners: Offenders,
    /// Largest ratio of longest to shortest edge in one element [-].
    pub max_aspect_ratio: f64,
    /// Index of the element with that ratio.
    pub slenderest_element: u32,
    /// Length of the shortest edge [m].
    pub min_edge_m: f64,
    /// Length of the longest edge [m].
    pub max_edge_m: f64,
    /// Volume of the mesh [m³].
    pub volume_m3: f64,
    /// Lower and upper corner of the bounding box of all nodes [m].
    pub bounding_box_m: [Vec3; 2],
    /// Nodes without an element: they have no mass.
    pub unused_nodes: Offenders,
    /// Nodes at exactly the position of an earlier one: intended where two bodies touch, a crack inside one body.
    pub coincident_nodes: Offenders,
}

/// Quality of all elements of a mesh; `None` without elements.
pub fn quality(mesh: &Mesh) -> Option<Quality> {
    let bounding_box_m = mesh.bounding_box()?;
    let mut out = Quality {
        min_scaled_jacobian: f64::INFINITY,
        worst_element: 0,
        negative: Offenders::default(),
        folded_corners: Offenders::default(),
        max_aspect_ratio: 0.0,
        slenderest_element: 0,
        min_edge_m: f64::INFINITY,
        max_edge_m: 0.0,
        volume_m3: 0.0,
        bounding_box_m,
        unused_nodes: unused_nodes(mesh),
        coincident_nodes: coincident_nodes(&mesh.nodes),
    };
    if mesh.cells.is_empty() {
        return None;
    }
    let of_element = |e: usize| {
        let cell = mesh.cells.get(e);
        element_quality(cell.kind, &cell.points(&mesh.nodes))
    };
    let elements: Vec<_> =
        (0..mesh.cells.len()).into_par_iter().with_min_len(ELEMENTS_OF_A_TASK).map(of_element).collect();
    for (e, element) in (0..).zip(elements) {
        if element.min_scaled_jacobian() < out.min_scaled_jacobian {
            out.min_scaled_jacobian = element.min_scaled_jacobian();
            out.worst_element = e;
        }
        if element.gauss_scaled_jacobian <= 0.0 {
            out.negative.push(e);
        } else if element.corner_scaled_jacobian <= 0.0 {
            out.folded_corners.push(e);
        }
        if element.aspect_ratio() > out.max_aspect_ratio {
            out.max_aspect_ratio = element.aspect_ratio();
            out.slenderest_element = e;
        }
        out.min_edge_m = out.min_edge_m.min(element.min_edge_m);
        out.max_edge_m = out.max_edge_m.max(element.max_edge_m);
        out.volume_m3 += element.volume_m3;
    }
    Some(out)
}

/// Index of the first element whose edges or volume leave the range of `f64`, so that its quality is undefined.
pub fn first_beyond_range(mesh: &Mesh) -> Option<usize> {
    mesh.cells.iter().position(|cell| {
        let ElementQuality { volume_m3, max_edge_m, gauss_scaled_jacobian, .. } =
            element_quality(cell.kind, &cell.points(&mesh.nodes));
        ![volume_m3, max_edge_m, gauss_scaled_jacobian].iter().all(|number| number.is_finite())
    })
}

/// Nodes that belong to no element.
fn unused_nodes(mesh: &Mesh) -> Offenders {
    let mut used = vec![false; mesh.nodes.len()];
    mesh.cells.connectivity().iter().for_each(|&a| used[a as usize] = true);
    let mut out = Offenders::default();
    (0..mesh.nodes.len()).filter(|&a| !used[a]).for_each(|a| out.push(a as u32));
    out
}

/// Nodes at exactly the position of an earlier node.
fn coincident_nodes(nodes: &[Vec3]) -> Offenders {
    // Adding zero makes −0 and 0 the same position.
    let key = |x: &Vec3| x.map(|c| (c + 0.0).to_bits()).into();
    let mut sorted: Vec<([u64; 3], u32)> =
        nodes.iter().enumerate().map(|(a, x)| (key(x), a as u32)).collect();
    sorted.sort_unstable();
    let mut again: Vec<u32> =
        sorted.chunk_by(|a, b| a.0 == b.0).flat_map(|run| run[1..].iter().map(|&(_, a)| a)).collect();
    again.sort_unstable();
    let mut out = Offenders::default();
    for a in again {
        out.push(a);
    }
    out
}

#[cfg(test)]
#[allow(clippy::float_cmp, clippy::unwrap_used)] // tests may panic
mod tests {
    use super::super::generate::block::Block;
    use super::*;

    fn block() -> Mesh {
        Block::uniform(Vec3::zeros(), Vec3::new(1.0, 2.0, 3.0), [1, 1, 3], "b").generate().unwrap()
    }

    #[test]
    fn bricks_are_perfect() {
        let quality = quality(&block()).unwrap();
        assert!((quality.min_scaled_jacobian - 1.0).abs() < 1e-14);
        assert!((quality.volume_m3 - 6.0).abs() < 1e-13);
        assert_eq!((quality.min_edge_m, quality.max_edge_m), (1.0, 2.0));
        assert!((quality.max_aspect_ratio - 2.0).abs() < 1e-14);
        assert_eq!(quality.negative, Offenders::default());
        assert_eq!(quality.bounding_box_m, [Vec3::zeros(), Vec3::new(1.0, 2.0, 3.0)]);
    }

    #[test]
    fn an_element_inside_out_is_named() {
        let mut mesh = block();
        let mut hexes = mesh.cells.hexes().unwrap().to_vec();
        hexes[1].rotate_left(4);
        mesh.cells = hexes.into();
        let quality = quality(&mesh).unwrap();
        assert_eq!(quality.negative, Offenders { count: 1, first: vec![1] });
        assert_eq!(quality.worst_element, 1);
        assert!((quality.min_scaled_jacobian + 1.0).abs() < 1e-14);
    }

    #[test]
    fn a_wedge_is_poor_but_not_negative() {
        let mut mesh = block();
        let hex = mesh.cells.nodes(2);
        // Corner 6 coincides with corner 7.
        mesh.nodes[hex[6] as usize] = mesh.nodes[hex[7] as usize];
        let quality = quality(&mesh).unwrap();
        assert_eq!(quality.negative.count, 0);
        assert_eq!(quality.folded_corners, Offenders { count: 1, first: vec![2] });
        assert!(quality.max_aspect_ratio.is_infinite());
        assert_eq!(quality.coincident_nodes.count, 1);
    }

    #[test]
    fn an_element_that_is_too_large_for_numbers_is_named() {
        let mut mesh = block();
        assert_eq!(first_beyond_range(&mesh), None);
        let top = mesh.cells.nodes(2)[6] as usize;
        for far in [1e308, 1e200] {
            mesh.nodes[top] = Vec3::repeat(far);
            assert_eq!(first_beyond_range(&mesh), Some(2), "{far}");
        }
        mesh.nodes.iter_mut().for_each(|x| *x = Vec3::zeros());
        assert_eq!(first_beyond_range(&mesh), None, "flat, which its Jacobian shows");
    }

    #[test]
    fn unused_nodes_are_counted_and_capped() {
        let mut mesh = block();
        let used = mesh.nodes.len() as u32;
        mesh.nodes.extend((0..150).map(|i| Vec3::new(f64::from(i), 9.0, 9.0)));
        let unused = quality(&mesh).unwrap().unused_nodes;
        assert_eq!((unused.count, unused.first.len(), unused.first[0]), (150, LISTED, used));
        assert!(super::quality(&Mesh::default()).is_none());
    }
}
