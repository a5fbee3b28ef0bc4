//! The cells of a mesh: node lists of mixed kinds.

#[cfg(test)]
mod tests;

use super::cell::{CellKind, CellPoints};
use crate::mechanics::tensor::Vec3;

/// Ordered cells, each with its kind and its nodes.
///
/// All nodes are stored contiguously. If all cells are of one kind, nothing else is stored, and cell `i` begins at `i`
/// times its number of nodes: hexahedra take no more memory than a list of `[u32; 8]`. Mixed kinds also store the kind and
/// the start of each cell.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Cells<N = u32> {
    nodes: Vec<N>,
    layout: Layout,
}

/// Which nodes belong to which cell.
#[derive(Clone, Debug, PartialEq, Eq)]
enum Layout {
    /// All cells are of this kind.
    Alike(CellKind),
    /// At least two kinds: kind and start of each cell.
    Mixed { kinds: Vec<CellKind>, starts: Vec<usize> },
}

/// A view of one cell.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Cell<'a, N = u32> {
    /// Kind, which fixes the number and the order of the nodes.
    pub kind: CellKind,
    /// Nodes of the cell, as many as the kind has, in the order of its table.
    pub nodes: &'a [N],
}

impl<N> Default for Cells<N> {
    fn default() -> Self {
        Self { nodes: Vec::new(), layout: Layout::Alike(CellKind::default()) }
    }
}

impl<N: Copy> Cells<N> {
    /// Number of cells of all kinds.
    pub fn len(&self) -> usize {
        match &self.layout {
            Layout::Alike(kind) => self.nodes.len() / kind.node_count(),
            Layout::Mixed { kinds, .. } => kinds.len(),
        }
    }

    /// Whether there are no cells.
    pub fn is_empty(&self) -> bool {
        self.nodes.is_empty()
    }

    /// The cell with a given index.
    ///
    /// # Panics
    /// If the cell does not exist.
    pub fn get(&self, cell: usize) -> Cell<'_, N> {
        let (kind, start) = match &self.layout {
            Layout::Alike(kind) => (*kind, cell * kind.node_count()),
            Layout::Mixed { kinds, starts } => (kinds[cell], starts[cell]),
        };
        Cell { kind, nodes: &self.nodes[start..start + kind.node_count()] }
    }

    /// Kind of a cell.
    ///
    /// # Panics
    /// If the cell does not exist.
    pub fn kind(&self, cell: usize) -> CellKind {
        self.get(cell).kind
    }

    /// Nodes of a cell.
    ///
    /// # Panics
    /// If the cell does not exist.
    pub fn nodes(&self, cell: usize) -> &[N] {
        self.get(cell).nodes
    }

    /// All cells in order.
    pub fn iter(&self) -> impl ExactSizeIterator<Item = Cell<'_, N>> {
        (0..self.len()).map(|cell| self.get(cell))
    }

    /// Nodes of all cells, one cell after the other.
    pub fn connectivity(&self) -> &[N] {
        &self.nodes
    }

    /// Each cell as eight nodes if all are eight-node hexahedra; otherwise `None`.
    pub fn hexes(&self) -> Option<&[[N; 8]]> {
        let is_hex8 = self.is_empty() || self.layout == Layout::Alike(CellKind::Hex8);
        is_hex8.then(|| self.nodes.as_chunks().0)
    }

    /// The kinds that occur, with the number of cells of each.
    pub fn counts(&self) -> Vec<(CellKind, usize)> {
        let count = |kind: CellKind| match &self.layout {
            Layout::Alike(alike) => self.len() * usize::from(kind == *alike),
            Layout::Mixed { kinds, .. } => kinds.iter().filter(|other| **other == kind).count(),
        };
        let counted = CellKind::ALL.into_iter().map(|kind| (kind, count(kind)));
        counted.filter(|(_, count)| *count > 0).collect()
    }

    /// Appends a cell.
    ///
    /// # Panics
    /// If the number of nodes is not that of the kind.
    pub fn push(&mut self, kind: CellKind, nodes: &[N]) {
        assert_eq!(nodes.len(), kind.node_count(), "nodes of a {}", kind.table().name);
        match &mut self.layout {
            Layout::Alike(alike) if *alike == kind => {}
            Layout::Alike(alike) if self.nodes.is_empty() => *alike = kind,
            Layout::Alike(alike) => {
                let starts: Vec<usize> = (0..self.nodes.len()).step_by(alike.node_count()).collect();
                self.layout = Layout::Mixed { kinds: vec![*alike; starts.len()], starts };
            }
            Layout::Mixed { .. } => {}
        }
        if let Layout::Mixed { kinds, starts } = &mut self.layout {
            kinds.push(kind);
            starts.push(self.nodes.len());
        }
        self.nodes.extend_from_slice(nodes);
    }

    /// The cells with renumbered nodes; `name` is given the cell and the node.
    ///
    /// # Errors
    /// The first error of `name`.
    pub fn try_map<M, E>(&self, mut name: impl FnMut(usize, N) -> Result<M, E>) -> Result<Cells<M>, E> {
        let mut nodes = Vec::with_capacity(self.nodes.len());
        for (index, cell) in self.iter().enumerate() {
            for &node in cell.nodes {
                nodes.push(name(index, node)?);
            }
        }
        Ok(Cells { nodes, layout: self.layout.clone() })
    }

    /// The cells with renumbered nodes.
    #[must_use]
    pub fn map<M>(&self, name: impl Fn(N) -> M) -> Cells<M> {
        Cells { nodes: self.nodes.iter().map(|node| name(*node)).collect(), layout: self.layout.clone() }
    }
}

impl Cells {
    /// Positions [m] of the nodes of a cell; `x` has those of all nodes.
    ///
    /// # Panics
    /// If the cell or one of its nodes does not exist.
    pub fn points(&self, cell: usize, x: &[Vec3]) -> CellPoints {
        self.get(cell).points(x)
    }

    /// VTK type of each cell, and the nodes of all cells in the order of VTK, one cell after the other.
    pub fn in_vtk(&self) -> (Vec<u8>, Vec<u32>) {
        let types = self.iter().map(|cell| cell.kind.table().vtk.number).collect();
        let mut nodes = Vec::with_capacity(self.nodes.len());
        for cell in self.iter() {
            let start = nodes.len();
            nodes.resize(start + cell.nodes.len(), 0);
            for (&place, &node) in cell.kind.table().vtk.order.iter().zip(cell.nodes) {
                nodes[start + place] = node;
            }
        }
        (types, nodes)
    }
}

impl Cell<'_> {
    /// Positions [m] of its nodes; `x` has those of all nodes.
    ///
    /// # Panics
    /// If one of its nodes does not exist.
    pub fn points(&self, x: &[Vec3]) -> CellPoints {
        CellPoints::new(self.nodes, |node| x[node as usize])
    }
}

impl<'a, N: Copy> Extend<Cell<'a, N>> for Cells<N> {
    fn extend<I: IntoIterator<Item = Cell<'a, N>>>(&mut self, cells: I) {
        cells.into_iter().for_each(|cell| self.push(cell.kind, cell.nodes));
    }
}

impl<'a, N: Copy + 'a> FromIterator<Cell<'a, N>> for Cells<N> {
    fn from_iter<I: IntoIterator<Item = Cell<'a, N>>>(cells: I) -> Self {
        let mut all = Self::default();
        all.extend(cells);
        all
    }
}

/// Hexahedra of eight nodes each.
impl<N: Copy> Extend<[N; 8]> for Cells<N> {
    fn extend<I: IntoIterator<Item = [N; 8]>>(&mut self, hexes: I) {
        hexes.into_iter().for_each(|hex| self.push(CellKind::Hex8, &hex));
    }
}

/// Hexahedra of eight nodes each.
impl<N> From<Vec<[N; 8]>> for Cells<N> {
    fn from(hexes: Vec<[N; 8]>) -> Self {
        Self { nodes: hexes.into_flattened(), layout: Layout::Alike(CellKind::Hex8) }
    }
}
