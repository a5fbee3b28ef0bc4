//! VTK's cell types (`vtkCellType.h`).

use crate::mesh::CellKind;

/// How a VTK cell type is read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum CellType {
    /// A supported cell, and the position in the file's list of each of its nodes.
    Volume(CellKind, &'static [usize]),
    /// A volume of another kind, by its name.
    Other(&'static str),
    /// A point, line or surface, of which only the nodes count.
    Boundary,
    /// No cell at all.
    Empty,
}

/// A voxel is a hexahedron whose nodes are listed row by row.
const VOXEL: u8 = 11;
const VOXEL_ORDER: [usize; 8] = [0, 1, 3, 2, 4, 5, 7, 6];

impl CellType {
    /// The type with this number, if it is known.
    pub(super) fn of(number: i64) -> Option<Self> {
        let number = u8::try_from(number).ok()?;
        let ours = CellKind::ALL.into_iter().find(|kind| kind.table().vtk.number == number);
        if let Some(kind) = ours {
            return Some(Self::Volume(kind, kind.table().vtk.order));
        }
        Some(match number {
            0 => Self::Empty,
            1..=9 | 21..=23 | 28 | 30 | 34..=36 | 60..=63 | 68..=70 | 75..=77 => Self::Boundary,
            VOXEL => Self::Volume(CellKind::Hex8, &VOXEL_ORDER),
            14 => Self::Other("pyramid of 5 nodes"),
            15 => Self::Other("pentagonal prism"),
            16 => Self::Other("hexagonal prism"),
            25 => Self::Other("hexahedron of 20 nodes"),
            26 => Self::Other("prism of 15 nodes"),
            27 => Self::Other("pyramid of 13 nodes"),
            29 => Self::Other("hexahedron of 27 nodes"),
            31 => Self::Other("prism of 12 nodes"),
            32 => Self::Other("prism of 18 nodes"),
            33 => Self::Other("hexahedron of 24 nodes"),
            37 => Self::Other("pyramid of 19 nodes"),
            41 => Self::Other("convex point set"),
            42 => Self::Other("polyhedron"),
            64..=67 | 71..=74 | 78..=81 => Self::Other("cell of higher order"),
            _ => return None,
        })
    }
}
