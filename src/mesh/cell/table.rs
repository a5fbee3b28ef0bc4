//! What there is to know of a kind of cell.

use crate::mechanics::tensor::{Mat3, Vec3};

/// One side of a cell, by the numbers of the cell's nodes.
#[derive(Debug)]
pub struct CellFace {
    /// Three or four corners, counter-clockwise seen from outside.
    pub corners: &'static [usize],
    /// What the surface of a mesh takes it for: bilinear facets on all of its nodes, counter-clockwise seen from outside. A triangle
    /// is a quadrilateral whose last corner is there twice, which makes its bilinear map the linear one.
    pub facets: &'static [[usize; 4]],
}

/// How a cell is split into eight of its kind.
#[derive(Debug)]
pub struct Split {
    /// New nodes: each in the middle of these nodes of the cell.
    pub middles: &'static [&'static [usize]],
    /// Nodes of each child: those of the cell, and behind them the new ones.
    pub children: &'static [&'static [usize]],
}

/// Natural coordinates that are oblique in the ideal cell, whose edges are all equal.
#[derive(Debug)]
pub struct Oblique {
    /// Natural directions that are square to each other there.
    pub frame: [[f64; 3]; 3],
    /// The corners that edges lead to from each corner.
    pub neighbours: &'static [[usize; 3]],
    /// Triple product of the unit vectors along the edges at a corner of it [-].
    pub corner: f64,
}

/// What another program calls a kind, and in which order it lists its nodes.
#[derive(Debug)]
pub struct Foreign {
    /// Its number of the kind.
    pub number: u8,
    /// Its place of each of our nodes.
    pub order: &'static [usize],
}

/// What Abaqus calls a kind. Its order of nodes and faces is ours.
#[derive(Debug)]
pub struct AbaqusName {
    /// The element type ("C3D8").
    pub name: &'static str,
    /// Letters that may follow: other integration or other fields, the same shape.
    pub suffixes: &'static str,
}

/// All that there is to know of a kind. Nodes are in the order of Abaqus: corners first, then the middles of edges.
#[derive(Debug)]
pub struct CellTable {
    /// Short name ("hex8").
    pub name: &'static str,
    /// Name in messages ("hexahedron of 8 nodes").
    pub title: &'static str,
    /// Natural coordinates of the nodes.
    pub points: &'static [[f64; 3]],
    /// How many of the nodes are corners.
    pub corners: usize,
    /// Natural coordinates of the centre.
    pub centre: [f64; 3],
    /// Half-spaces n · ξ ≤ d whose intersection is the reference cell.
    pub half_spaces: &'static [([f64; 3], f64)],
    /// End corners of the edges.
    pub edges: &'static [[usize; 2]],
    /// The sides; side `i` is Abaqus' `S{i+1}`.
    pub faces: &'static [CellFace],
    /// How its natural coordinates lie in the ideal cell; `None` where they run along the edges at every corner, square to each other.
    pub oblique: Option<Oblique>,
    /// Quadrature points and weights: exact for the volume of any cell of the kind.
    pub quadrature: &'static [([f64; 3], f64)],
    /// The place x(ξ) [m], given the positions of the nodes.
    pub place: fn(&[Vec3], [f64; 3]) -> Vec3,
    /// The Jacobian ∂x/∂ξ [m]; column `j` is ∂x/∂ξ_j.
    pub jacobian: fn(&[Vec3], [f64; 3]) -> Mat3,
    /// How it is refined; `None` where it cannot be.
    pub split: Option<Split>,
    /// VTK's cell type (`vtkCellType.h`).
    pub vtk: Foreign,
    /// Gmsh's element type (reference manual, "MSH file format").
    pub gmsh: Foreign,
    /// Abaqus' element type (Analysis User's Manual, "Solid (continuum) elements").
    pub abaqus: AbaqusName,
}

/// Σ_a x_a N_a.
pub(super) fn interpolated(x: &[Vec3], shape: impl Fn(usize) -> f64) -> Vec3 {
    x.iter().enumerate().map(|(a, x)| x * shape(a)).sum()
}

/// Σ_a x_a ⊗ ∂N_a/∂ξ.
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
