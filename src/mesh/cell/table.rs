//! The table of properties of a kind of cell.

use crate::mechanics::element::ElementKind;
use crate::mechanics::tensor::{Mat3, Vec3};

/// A face of a cell, in local node numbers.
#[derive(Debug)]
pub struct CellFace {
    /// Three or four corners, counter-clockwise seen from outside.
    pub corners: &'static [usize],
    /// Its representation on the surface of a mesh: bilinear facets on all of its nodes, counter-clockwise seen from
    /// outside. A triangle is a quadrilateral with its last corner repeated, which makes its bilinear map linear.
    pub facets: &'static [[usize; 4]],
}

/// Splitting of a cell into eight of its kind.
#[derive(Debug)]
pub struct Split {
    /// New nodes, each at the middle of these nodes of the cell.
    pub middles: &'static [&'static [usize]],
    /// Nodes of each child: those of the cell, followed by the new ones.
    pub children: &'static [&'static [usize]],
}

/// Natural coordinates that are oblique in the ideal cell, which has equal edges.
#[derive(Debug)]
pub struct Oblique {
    /// Natural directions that are orthogonal there.
    pub frame: [[f64; 3]; 3],
    /// For each corner, the corners at the other ends of its edges.
    pub neighbours: &'static [[usize; 3]],
    /// Triple product of the unit vectors along the edges at a corner [-].
    pub corner: f64,
}

/// Identifier of a kind in another program, and its node order there.
#[derive(Debug)]
pub struct Foreign {
    /// Number of the kind in that program.
    pub number: u8,
    /// Local index there of each of our nodes.
    pub order: &'static [usize],
}

/// Name of a kind in Abaqus; nodes and faces are in the order of Abaqus.
#[derive(Debug)]
pub struct AbaqusName {
    /// Element type in Abaqus ("C3D8").
    pub name: &'static str,
    /// Letters that may follow: other integration or other fields, same shape.
    pub suffixes: &'static str,
}

/// All properties of a kind. Nodes are in the order of Abaqus: corners first, then the middles of edges.
#[derive(Debug)]
pub struct CellTable {
    /// Short name of the kind in messages and documents ("hex8").
    pub name: &'static str,
    /// Name in messages ("hexahedron of 8 nodes").
    pub title: &'static str,
    /// Its finite element, with the same nodes in the same order.
    pub element: ElementKind,
    /// Natural coordinates of the nodes [-].
    pub points: &'static [[f64; 3]],
    /// Number of corner nodes.
    pub corners: usize,
    /// Natural coordinates of the centre [-].
    pub centre: [f64; 3],
    /// Half-spaces n · ξ ≤ d whose intersection is the reference cell.
    pub half_spaces: &'static [([f64; 3], f64)],
    /// End corners of the edges.
    pub edges: &'static [[usize; 2]],
    /// Faces; face `i` is `S{i+1}` in Abaqus.
    pub faces: &'static [CellFace],
    /// Natural coordinates of the ideal cell; `None` where they run along orthogonal edges at every corner.
    pub oblique: Option<Oblique>,
    /// Quadrature points and weights: exact for the volume of any cell of the kind.
    pub quadrature: &'static [([f64; 3], f64)],
    /// Position x(ξ) [m], from the positions of the nodes.
    pub place: fn(&[Vec3], [f64; 3]) -> Vec3,
    /// Jacobian ∂x/∂ξ [m]; column `j` is ∂x/∂ξ_j.
    pub jacobian: fn(&[Vec3], [f64; 3]) -> Mat3,
    /// How the cell is refined; `None` if it cannot be.
    pub split: Option<Split>,
    /// VTK's cell type (`vtkCellType.h`).
    pub vtk: Foreign,
    /// Gmsh's element type (reference manual, "MSH file format").
    pub gmsh: Foreign,
    /// Abaqus' element type (Analysis User's Manual, "Solid (continuum) elements").
    pub abaqus: AbaqusName,
}

/// Position Σ_a x_a N_a [m].
pub(super) fn interpolated(x: &[Vec3], shape: impl Fn(usize) -> f64) -> Vec3 {
    x.iter().enumerate().map(|(a, x)| x * shape(a)).sum()
}

/// Jacobian Σ_a x_a ⊗ ∂N_a/∂ξ [m].
pub(super) fn interpolated_jacobian(x: &[Vec3], gradient: impl Fn(usize) -> [f64; 3]) -> Mat3 {
    let mut columns = [Vec3::zeros(); 3];
    for (a, x) in x.iter().enumerate() {
        let gradient = gradient(a);
        for (column, g) in columns.iter_mut().zip(gradient) {
            *column += x * g;
        }
    }
    Mat3::from_columns(&columns)
}
