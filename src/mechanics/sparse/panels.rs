//! Solutions by the panels of a supernodal factor L: one right-hand side at memory bandwidth, and blocks of the
//! inverse by the panels that they need.

use crate::lanes::dispatch_rare;
use faer::linalg::matmul::matmul;
use faer::linalg::triangular_solve::solve_lower_triangular_in_place;
use faer::sparse::linalg::cholesky::supernodal::SymbolicSupernodalCholesky;
use faer::{Accum, MatMut, MatRef, Par};
use pulp::{Simd, WithSimd};

/// Columns of a panel that a solution reads together, so that it reads and writes the right-hand side once for them.
const TOGETHER: usize = 4;

/// A factor L in terms of its panels.
pub(super) struct Panels<'a> {
    pub symbolic: &'a SymbolicSupernodalCholesky<usize>,
    values: &'a [f64],
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
        Self { symbolic, values }
    }

    pub fn panel(&self, s: usize) -> Panel<'a> {
        let (start, end) = (self.symbolic.supernode_begin()[s], self.symbolic.supernode_end()[s]);
        let pattern = self.symbolic.supernode(s).pattern();
        let (columns, range) = (end - start, &self.symbolic.col_ptr_for_val()[s..s + 2]);
        let values = &self.values[range[0]..range[1]];
        Panel { start, columns, rows: columns + pattern.len(), pattern, values }
    }

    /// Solves in place, `x ← L⁻ᵀ L⁻¹ x`.
    pub fn solve(&self, x: &mut [f64]) {
        dispatch_rare(Solution { panels: self, x });
    }

    /// Index of the panel of an unknown.
    pub fn of(&self, unknown: usize) -> usize {
        self.symbolic.supernode_end().partition_point(|end| *end <= unknown)
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
                let to = &mut Y[row_of(*row) * width..][..width];
                to.iter_mut().zip(product).for_each(|(to, product)| *to -= product);
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

/// Forward and backward substitution with the registers of an instruction set.
struct Solution<'a, 'b> {
    panels: &'a Panels<'b>,
    x: &'a mut [f64],
}

impl WithSimd for Solution<'_, '_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let Self { panels, x } = self;
        let mut work = Vec::new();
        for s in 0..panels.symbolic.n_supernodes() {
            panels.panel(s).forward(x, &mut work);
        }
        for s in (0..panels.symbolic.n_supernodes()).rev() {
            panels.panel(s).backward(x, &mut work);
        }
    }
}

impl Panel<'_> {
    /// Eliminates the unknowns of the panel; nothing changes where their right sides are zero, as far from few loaded nodes.
    #[inline(always)]
    fn forward(&self, x: &mut [f64], work: &mut Vec<f64>) {
        let own = self.start..self.start + self.columns;
        if x[own.clone()].iter().all(|x| *x == 0.0) {
            return;
        }
        work.clear();
        work.extend_from_slice(&x[own.clone()]);
        work.resize(self.rows, 0.0);
        let alone = self.columns % TOGETHER;
        for k in 0..alone {
            self.eliminate::<1>(k, work);
        }
        for k in (alone..self.columns).step_by(TOGETHER) {
            self.eliminate::<TOGETHER>(k, work);
        }
        x[own].copy_from_slice(&work[..self.columns]);
        for (row, sum) in self.pattern.iter().zip(&work[self.columns..]) {
            x[*row] += sum;
        }
    }

    /// Finds the unknowns of the panel from those behind it.
    #[inline(always)]
    fn backward(&self, x: &mut [f64], work: &mut Vec<f64>) {
        let own = self.start..self.start + self.columns;
        work.clear();
        work.extend_from_slice(&x[own.clone()]);
        work.extend(self.pattern.iter().map(|row| x[*row]));
        let alone = self.columns % TOGETHER;
        for k in (alone..self.columns).step_by(TOGETHER).rev() {
            self.substitute::<TOGETHER>(k, work);
        }
        for k in (0..alone).rev() {
            self.substitute::<1>(k, work);
        }
        x[own].copy_from_slice(&work[..self.columns]);
    }

    /// N columns from `k` on, from their row `k` on: the square on the diagonal, and what is below.
    #[inline(always)]
    fn group<const N: usize>(&self, k: usize) -> ([[f64; N]; N], [&[f64]; N]) {
        let column = |j: usize| &self.values[(k + j) * self.rows + k..][..self.rows - k];
        let square = std::array::from_fn(|j| std::array::from_fn(|i| column(j)[i]));
        (square, std::array::from_fn(|j| &column(j)[N..]))
    }

    /// Subtracts N columns times their unknowns.
    #[inline(always)]
    fn eliminate<const N: usize>(&self, k: usize, work: &mut [f64]) {
        let (square, below) = self.group::<N>(k);
        let (own, rest) = work[k..].split_at_mut(N);
        for j in 0..N {
            own[j] /= square[j][j];
            for i in j + 1..N {
                own[i] -= square[j][i] * own[j];
            }
        }
        let below = below.map(|column| &column[..rest.len()]);
        for (i, rest) in rest.iter_mut().enumerate() {
            for j in 0..N {
                *rest -= below[j][i] * own[j];
            }
        }
    }

    /// Solves for the unknowns of N columns. In eight partial sums each: a single one would be one long chain of additions.
    #[inline(always)]
    fn substitute<const N: usize>(&self, k: usize, work: &mut [f64]) {
        const LANES: usize = 8;
        let (square, below) = self.group::<N>(k);
        let (own, rest) = work[k..].split_at_mut(N);
        let below = below.map(|column| &column[..rest.len()]);
        let whole = rest.len() - rest.len() % LANES;
        let mut sums = [[0.0; LANES]; N];
        for start in (0..whole).step_by(LANES) {
            for j in 0..N {
                for lane in 0..LANES {
                    sums[j][lane] += below[j][start + lane] * rest[start + lane];
                }
            }
        }
        for j in (0..N).rev() {
            let last = (whole..rest.len()).map(|i| below[j][i] * rest[i]).sum::<f64>();
            let behind = (j + 1..N).map(|i| square[j][i] * own[i]).sum::<f64>();
            own[j] = (own[j] - sums[j].iter().sum::<f64>() - last - behind) / square[j][j];
        }
    }
}
