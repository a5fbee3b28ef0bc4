//! Solutions by the panels of a supernodal factor L: one right-hand side at memory bandwidth, and blocks of the
//! inverse by the panels that they need.

use faer::linalg::matmul::matmul;
use faer::linalg::triangular_solve::solve_lower_triangular_in_place;
use faer::sparse::linalg::cholesky::supernodal::{SupernodalLltRef, SymbolicSupernodalCholesky};
use faer::{Accum, MatMut, MatRef, Par};

/// A factor L in terms of its panels.
pub(super) struct Panels<'a> {
    pub symbolic: &'a SymbolicSupernodalCholesky<usize>,
    factor: SupernodalLltRef<'a, usize, f64>,
}

/// Columns `start..` of L: the triangle on the diagonal and the rows of the pattern below it, by columns.
pub(super) struct Panel<'a> {
    pub start: usize,
    pub columns: usize,
    pub rows: usize,
    pub pattern: &'a [usize],
    pub values: &'a [f64],
}

impl<'a> Panels<'a> {
    pub fn new(symbolic: &'a SymbolicSupernodalCholesky<usize>, values: &'a [f64]) -> Self {
        Self { symbolic, factor: SupernodalLltRef::new(symbolic, values) }
    }

    pub fn panel(&self, s: usize) -> Panel<'a> {
        let (start, end) = (self.symbolic.supernode_begin()[s], self.symbolic.supernode_end()[s]);
        let pattern = self.symbolic.supernode(s).pattern();
        let (columns, range) = (end - start, &self.symbolic.col_ptr_for_val()[s..s + 2]);
        let values = &self.factor.values()[range[0]..range[1]];
        Panel { start, columns, rows: columns + pattern.len(), pattern, values }
    }

    /// Index of the panel of an unknown.
    pub fn of(&self, unknown: usize) -> usize {
        self.symbolic.supernode_end().partition_point(|end| *end <= unknown)
    }

    /// Solves in place, `x ← L⁻ᵀ L⁻¹ x`.
    pub fn solve(&self, x: &mut [f64]) {
        let mut below = Vec::new();
        for s in 0..self.symbolic.n_supernodes() {
            let panel = self.panel(s);
            below.clear();
            below.resize(panel.pattern.len(), 0.0);
            for (k, column) in panel.values.chunks_exact(panel.rows).enumerate() {
                let (diagonal, own) = x[panel.start + k..panel.start + panel.columns].split_at_mut(1);
                diagonal[0] /= column[k];
                add_scaled(own, -diagonal[0], &column[k + 1..panel.columns]);
                add_scaled(&mut below, diagonal[0], &column[panel.columns..]);
            }
            for (row, sum) in panel.pattern.iter().zip(&below) {
                x[*row] -= sum;
            }
        }
        for s in (0..self.symbolic.n_supernodes()).rev() {
            let panel = self.panel(s);
            below.clear();
            below.extend(panel.pattern.iter().map(|row| x[*row]));
            for (k, column) in panel.values.chunks_exact(panel.rows).enumerate().rev() {
                let (diagonal, own) = x[panel.start + k..panel.start + panel.columns].split_at_mut(1);
                let sum = dot(&column[k + 1..panel.columns], own) + dot(&column[panel.columns..], &below);
                diagonal[0] = (diagonal[0] - sum) / column[k];
            }
        }
    }

    /// Rows and columns `unknowns` of the inverse, row by row: `Yᵀ Y` with `Y = L⁻¹ E`, by the panels on the paths
    /// from those unknowns to the root of the elimination tree; all other rows of Y are zero.
    pub fn inverse_block(&self, unknowns: &[usize], to: &mut [f64]) {
        let width = unknowns.len();
        // E, with rows for the panels on these paths only.
        let (place, rows) = self.places(unknowns);
        let row_of = |unknown: usize| {
            let s = self.of(unknown);
            place[s].map_or(0, |place| place + unknown - self.symbolic.supernode_begin()[s])
        };
        let mut Y = vec![0.0; rows * width];
        for (column, unknown) in unknowns.iter().enumerate() {
            Y[row_of(*unknown) * width + column] = 1.0;
        }
        // Forward substitution, panel by panel.
        let mut below = Vec::new();
        for (s, place) in place.iter().enumerate() {
            let Some(place) = *place else { continue };
            let panel = self.panel(s);
            let L = MatRef::from_column_major_slice(panel.values, panel.rows, panel.columns);
            let (top, bottom) = L.split_at_row(panel.columns);
            let own = &mut Y[place * width..(place + panel.columns) * width];
            let mut own = MatMut::from_row_major_slice_mut(own, panel.columns, width);
            solve_lower_triangular_in_place(top, own.as_mut(), Par::Seq);
            below.clear();
            below.resize(panel.pattern.len() * width, 0.0);
            let product = MatMut::from_row_major_slice_mut(&mut below, panel.pattern.len(), width);
            matmul(product, Accum::Replace, bottom, own.as_ref(), 1.0, Par::Seq);
            for (row, product) in panel.pattern.iter().zip(below.chunks_exact(width)) {
                add_scaled(&mut Y[row_of(*row) * width..][..width], -1.0, product);
            }
        }
        // Yᵀ Y.
        let Y = MatRef::from_row_major_slice(&Y, rows, width);
        let to = MatMut::from_row_major_slice_mut(to, width, width);
        matmul(to, Accum::Replace, Y.transpose(), Y, 1.0, Par::Seq);
    }

    /// First row of each panel that `L⁻¹` of these unknowns fills, and the number of rows.
    fn places(&self, unknowns: &[usize]) -> (Vec<Option<usize>>, usize) {
        let mut is_filled = vec![false; self.symbolic.n_supernodes()];
        for unknown in unknowns {
            is_filled[self.of(*unknown)] = true;
        }
        let (mut place, mut rows) = (vec![None; is_filled.len()], 0);
        for s in 0..is_filled.len() {
            if is_filled[s] {
                let panel = self.panel(s);
                place[s] = Some(rows);
                rows += panel.columns;
                if let Some(row) = panel.pattern.first() {
                    is_filled[self.of(*row)] = true;
                }
            }
        }
        (place, rows)
    }
}

/// Adds a multiple, `y += a x`.
fn add_scaled(y: &mut [f64], a: f64, x: &[f64]) {
    for (y, x) in y.iter_mut().zip(x) {
        *y += a * x;
    }
}

/// a·b in eight partial sums: a single one would be one long chain of additions.
fn dot(a: &[f64], b: &[f64]) -> f64 {
    let mut sums = [0.0; 8];
    let (a8, b8) = (a.chunks_exact(8), b.chunks_exact(8));
    let rest: f64 = a8.remainder().iter().zip(b8.remainder()).map(|(a, b)| a * b).sum();
    for (a, b) in a8.zip(b8) {
        for i in 0..8 {
            sums[i] += a[i] * b[i];
        }
    }
    sums.iter().sum::<f64>() + rest
}
