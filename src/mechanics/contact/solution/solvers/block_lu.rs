//! LU factors of a sparse matrix of 3×3 blocks with a symmetric pattern, by fronts (Duff & Reid 1983): blocks are ordered by nested
//! dissection of their graph, and pivots stay inside a panel, so that the pattern of the factors depends on that of the matrix alone.

use crate::contact::solution::delassus::Block;
use crate::sparse::{Graph, SparseError};
use faer::linalg::matmul::matmul;
use faer::linalg::solvers::{PartialPivLu, Solve};
use faer::sparse::SymbolicSparseColMatRef;
use faer::sparse::linalg::SupernodalThreshold;
use faer::sparse::linalg::cholesky::{
    CholeskySymbolicParams, SymbolicCholeskyRaw, SymmetricOrdering, factorize_symbolic_cholesky,
};
use faer::{Accum, Mat, MatMut, MatRef, Par, Side};
use std::sync::Arc;

/// A block of the matrix: its row, its column, and its values.
pub(super) type Entry = (u32, u32, Block);

/// The order of elimination of a pattern, and its panels.
#[derive(Debug)]
pub(super) struct Elimination {
    /// Rows and columns of the pattern, for which it was found.
    pattern: Vec<(u32, u32)>,
    /// Place of each block in the order.
    place: Vec<u32>,
    panels: Vec<Panel>,
}

/// Blocks that are eliminated together, and those behind them that they change, by their places; the panels whose fronts it takes up.
#[derive(Debug)]
struct Panel {
    own: std::ops::Range<usize>,
    behind: Vec<usize>,
    children: Vec<usize>,
}

/// A panel after its elimination: the factors of its own square A₁₁, `A₁₁⁻¹ A₁₂` and `A₂₁`.
#[derive(Debug)]
struct Eliminated {
    own: PartialPivLu<f64>,
    right: Mat<f64>,
    below: Mat<f64>,
}

/// The factors.
#[derive(Debug)]
pub(super) struct BlockLu {
    elimination: Arc<Elimination>,
    panels: Vec<Eliminated>,
}

impl Elimination {
    /// Orders the graph of `blocks` rows and columns that the entries connect.
    pub fn new(blocks: usize, entries: &[Entry]) -> Result<Self, SparseError> {
        let pairs: Vec<[u32; 2]> = entries.iter().map(|(row, column, _)| [*row, *column]).collect();
        let graph = Graph::from_cliques(blocks, pairs.iter().map(|pair| &pair[..]));
        let order = graph.elimination_order()?;
        let mut place = vec![0; blocks];
        order.iter().enumerate().for_each(|(i, block)| place[*block as usize] = i as u32);
        // The upper triangle of the ordered graph, by columns.
        let (mut starts, mut rows) = (vec![0], Vec::new());
        for (i, block) in order.iter().enumerate() {
            let before =
                graph.of(*block).map(|other| place[other as usize] as usize).filter(|other| *other < i);
            let first = rows.len();
            rows.extend(before);
            rows.push(i);
            rows[first..].sort_unstable();
            starts.push(rows.len());
        }
        let upper = SymbolicSparseColMatRef::new_checked(blocks, blocks, &starts, None, &rows);
        let parameters = CholeskySymbolicParams {
            supernodal_flop_ratio_threshold: SupernodalThreshold::FORCE_SUPERNODAL,
            ..CholeskySymbolicParams::default()
        };
        let symbolic =
            factorize_symbolic_cholesky(upper, Side::Upper, SymmetricOrdering::Identity, parameters);
        let too_large = |reason| SparseError::TooLarge { unknowns: 3 * blocks, reason };
        let symbolic = symbolic.map_err(|e| too_large(format!("{e:?}")))?;
        let SymbolicCholeskyRaw::Supernodal(symbolic) = symbolic.raw() else {
            return Err(too_large("no panels".into()));
        };
        let ends = symbolic.supernode_end();
        let mut panels: Vec<Panel> = Vec::with_capacity(ends.len());
        for (s, (start, end)) in symbolic.supernode_begin().iter().zip(ends).enumerate() {
            let behind = symbolic.supernode(s).pattern().to_vec();
            panels.push(Panel { own: *start..*end, behind, children: Vec::new() });
        }
        for s in 0..panels.len() {
            if let Some(first) = panels[s].behind.first() {
                let parent = ends.partition_point(|end| end <= first);
                panels[parent].children.push(s);
            }
        }
        Ok(Self { pattern: pattern(entries), place, panels })
    }

    /// Whether it is that of these entries.
    pub fn fits(&self, blocks: usize, entries: &[Entry]) -> bool {
        let of = |(row, column, _): &Entry| (*row, *column);
        let same_size = self.place.len() == blocks && self.pattern.len() == entries.len();
        same_size && self.pattern.iter().zip(entries).all(|(known, entry)| *known == of(entry))
    }

    /// The factors of the matrix of these entries; those at the same place are added.
    pub fn factorise(self: Arc<Self>, entries: &[Entry]) -> BlockLu {
        let by_panel = self.by_panel(entries);
        let mut local = vec![0; self.place.len()];
        let mut updates: Vec<Option<Mat<f64>>> = Vec::new();
        let mut panels = Vec::with_capacity(self.panels.len());
        for (panel, own_entries) in self.panels.iter().zip(&by_panel) {
            // The front: what the matrix has of the panel, and what its children leave.
            let width = panel.own.len();
            panel
                .own
                .clone()
                .chain(panel.behind.iter().copied())
                .enumerate()
                .for_each(|(i, at)| local[at] = i);
            let size = 3 * (width + panel.behind.len());
            let mut front = Mat::<f64>::zeros(size, size);
            for (row, column, block) in own_entries.iter().map(|e| entries[*e as usize]) {
                let at = |block: u32| 3 * local[self.place[block as usize] as usize];
                for (i, values) in block.iter().enumerate() {
                    for (j, value) in values.iter().enumerate() {
                        front[(at(row) + i, at(column) + j)] += value;
                    }
                }
            }
            for &child in &panel.children {
                if let Some(update) = updates[child].take() {
                    add_front(&mut front, &update, &self.panels[child].behind, &local);
                }
            }
            // Elimination, and what it leaves for the parent.
            let (own, mut right, below, mut rest) = front.as_mut().split_at_mut(3 * width, 3 * width);
            let own = own.partial_piv_lu();
            own.solve_in_place(right.as_mut());
            matmul(rest.as_mut(), Accum::Add, below.as_ref(), right.as_ref(), -1.0, Par::Seq);
            updates.push(Some(rest.to_owned()));
            panels.push(Eliminated { own, right: right.to_owned(), below: below.to_owned() });
        }
        BlockLu { elimination: self, panels }
    }

    /// Numbers of the entries by the panel that eliminates their row or column, whichever is first.
    fn by_panel(&self, entries: &[Entry]) -> Vec<Vec<u32>> {
        let mut lists = vec![Vec::new(); self.panels.len()];
        for (number, (row, column, _)) in entries.iter().enumerate() {
            let first = self.place[*row as usize].min(self.place[*column as usize]) as usize;
            lists[self.panels.partition_point(|panel| panel.own.end <= first)].push(number as u32);
        }
        lists
    }
}

fn pattern(entries: &[Entry]) -> Vec<(u32, u32)> {
    entries.iter().map(|(row, column, _)| (*row, *column)).collect()
}

/// Adds what a child leaves of the blocks at the places `behind` it, with their places in the front.
fn add_front(front: &mut Mat<f64>, update: &Mat<f64>, behind: &[usize], local: &[usize]) {
    for (j, column) in behind.iter().enumerate() {
        for k in 0..3 {
            let (to, from) = (3 * local[*column] + k, update.col_as_slice(3 * j + k));
            let to = front.col_as_slice_mut(to);
            for (row, from) in behind.iter().zip(from.chunks_exact(3)) {
                let at = 3 * local[*row];
                to[at..at + 3].iter_mut().zip(from).for_each(|(to, from)| *to += from);
            }
        }
    }
}

impl BlockLu {
    /// Solves in place.
    pub fn solve(&self, b: &mut [f64]) {
        let place = &self.elimination.place;
        let mut x = vec![0.0; b.len()];
        for (b, at) in b.chunks_exact(3).zip(place) {
            x[3 * *at as usize..][..3].copy_from_slice(b);
        }
        let mut behind = Vec::new();
        for (panel, eliminated) in self.elimination.panels.iter().zip(&self.panels) {
            let own = &mut x[3 * panel.own.start..3 * panel.own.end];
            eliminated.own.solve_in_place(column(own));
            behind.clear();
            behind.resize(3 * panel.behind.len(), 0.0);
            let own = MatRef::from_column_major_slice(&*own, own.len(), 1);
            matmul(column(&mut behind), Accum::Replace, eliminated.below.as_ref(), own, -1.0, Par::Seq);
            for (at, change) in panel.behind.iter().zip(behind.chunks_exact(3)) {
                x[3 * at..3 * at + 3].iter_mut().zip(change).for_each(|(x, change)| *x += change);
            }
        }
        for (panel, eliminated) in self.elimination.panels.iter().zip(&self.panels).rev() {
            behind.clear();
            behind.extend(panel.behind.iter().flat_map(|at| [x[3 * at], x[3 * at + 1], x[3 * at + 2]]));
            let own = column(&mut x[3 * panel.own.start..3 * panel.own.end]);
            let behind_column = MatRef::from_column_major_slice(&behind, behind.len(), 1);
            matmul(own, Accum::Add, eliminated.right.as_ref(), behind_column, -1.0, Par::Seq);
        }
        for (b, at) in b.chunks_exact_mut(3).zip(place) {
            b.copy_from_slice(&x[3 * *at as usize..][..3]);
        }
    }
}

/// Numbers as a matrix of one column.
fn column(numbers: &mut [f64]) -> MatMut<'_, f64> {
    let rows = numbers.len();
    MatMut::from_column_major_slice_mut(numbers, rows, 1)
}
