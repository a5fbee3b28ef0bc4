//! Kinds of cells. All properties of a kind are in one table, which surfaces, quality, refinement, readers and writers use.

mod hex8;
mod points;
mod table;
#[cfg(test)]
mod tests;
mod tet10;
mod tet4;
mod wedge6;

pub use points::{CellPoints, MOST_NODES};
pub use table::{AbaqusName, CellFace, CellTable, Foreign, Oblique, Split};

use crate::mechanics::element::ElementKind;
use crate::mechanics::tensor::{Mat3, Vec3};

/// Topology of a mesh cell: its shape and its nodes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum CellKind {
    /// Hexahedron of eight nodes, trilinear.
    #[default]
    Hex8,
    /// Tetrahedron of four nodes, linear.
    Tet4,
    /// Tetrahedron of ten nodes, quadratic.
    Tet10,
    /// Wedge of six nodes: a linear triangle times a linear line.
    Wedge6,
}

impl CellKind {
    /// All kinds, in the order of their declaration.
    pub const ALL: [Self; 4] = [Self::Hex8, Self::Tet4, Self::Tet10, Self::Wedge6];

    /// Static properties of the kind: node positions, edges, faces, Gmsh and VTK types, finite element.
    pub fn table(self) -> &'static CellTable {
        match self {
            Self::Hex8 => &hex8::TABLE,
            Self::Tet4 => &tet4::TABLE,
            Self::Tet10 => &tet10::TABLE,
            Self::Wedge6 => &wedge6::TABLE,
        }
    }

    /// Finite element that cells of this kind are computed with.
    pub fn element(self) -> ElementKind {
        self.table().element
    }

    /// Number of nodes of a cell.
    pub fn node_count(self) -> usize {
        self.table().points.len()
    }

    /// The kind with this Gmsh element type.
    pub fn of_gmsh(number: i32) -> Option<Self> {
        Self::ALL.into_iter().find(|kind| i32::from(kind.table().gmsh.number) == number)
    }

    /// The kind of an Abaqus element type in capitals ("C3D8R").
    pub fn of_abaqus(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|kind| {
            let AbaqusName { name: own, suffixes } = kind.table().abaqus;
            name.strip_prefix(own).is_some_and(|rest| rest.chars().all(|c| suffixes.contains(c)))
        })
    }

    /// Volume [m³] from the positions of the nodes [m]; negative when the cell is inverted.
    ///
    /// V = Σ w det ∂x/∂ξ over the quadrature points, which is exact for the kind's interpolation.
    pub fn volume_m3(self, x: &[Vec3]) -> f64 {
        self.jacobians(x).map(|(jacobian, weight)| jacobian.determinant() * weight).sum()
    }

    /// ∂x/∂ξ at the quadrature points [m], with their weights [-].
    pub(super) fn jacobians(self, x: &[Vec3]) -> impl Iterator<Item = (Mat3, f64)> {
        let table = self.table();
        table.quadrature.iter().map(move |&(xi, weight)| ((table.jacobian)(x, xi), weight))
    }

    /// Whether natural coordinates lie in the reference cell.
    pub fn contains(self, xi: &Vec3) -> bool {
        self.table().half_spaces.iter().all(|&(normal, most)| Vec3::from(normal).dot(xi) <= most)
    }

    /// Scaled Jacobian at natural coordinates [-], in [−1, 1]; 1 in the ideal cell, which has equal edges (Knupp 2000).
    pub fn scaled_jacobian(self, x: &[Vec3], xi: [f64; 3]) -> f64 {
        self.scaled(&(self.table().jacobian)(x, xi))
    }

    /// The scaled Jacobian of `jacobian = ∂x/∂ξ` [-].
    pub(super) fn scaled(self, jacobian: &Mat3) -> f64 {
        match &self.table().oblique {
            None => scaled_determinant(jacobian),
            Some(Oblique { frame, .. }) => scaled_determinant(&(jacobian * columns(*frame))),
        }
    }

    /// Scaled Jacobian at a corner [-]: the triple product of the unit vectors along the edges there, divided by that of
    /// the ideal cell. 1 in the ideal cell, 0 where the corner is flat.
    ///
    /// # Panics
    /// If the kind has no such corner.
    pub fn corner_scaled_jacobian(self, x: &[Vec3], corner: usize) -> f64 {
        let table = self.table();
        let jacobian = (table.jacobian)(x, table.points[corner]);
        let Some(oblique) = &table.oblique else { return scaled_determinant(&jacobian) };
        let here = Vec3::from(table.points[corner]);
        let along = oblique.neighbours[corner].map(|other| Vec3::from(table.points[other]) - here);
        let edges = Mat3::from_columns(&along);
        // The neighbours are in any order: the sign for the reference cell identifies a right-handed one.
        scaled_determinant(&(jacobian * edges)) * edges.determinant().signum() / oblique.corner
    }
}

fn columns(directions: [[f64; 3]; 3]) -> Mat3 {
    Mat3::from_columns(&directions.map(Vec3::from))
}

/// Determinant divided by the lengths of the columns, in [−1, 1]; 1 for orthogonal columns, 0 where one vanishes.
fn scaled_determinant(columns: &Mat3) -> f64 {
    let lengths: f64 = columns.column_iter().map(|c| c.norm()).product();
    if lengths > 0.0 { columns.determinant() / lengths } else { 0.0 }
}
