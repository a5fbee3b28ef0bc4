//! Entries of the inverse of a matrix in the pattern of its factor, from the last panel to the first (Erisman & Tinney
//! 1975): as much work as a few factorisations, and no solutions. They contain the compliance of each node, and of two nodes
//! of one element against each other. In single precision, half the time and memory: they scale and precondition, and no term cancels another,
//! since `Z₁₁ = L₁⁻ᵀ L₁⁻¹ + Uᵀ Z₂₂ U`.
//!
//! With a panel `[L₁; L₂]` and `U = L₂ L₁⁻¹`, the inverse has `Z₂₁ = −Z₂₂ U` and `Z₁₁ = L₁⁻ᵀ L₁⁻¹ − Uᵀ Z₂₁`, where Z₂₂ is in the
//! panels behind it.

use super::panels::{Panel, Panels};
use faer::linalg::matmul::matmul;
use faer::linalg::triangular_solve::solve_lower_triangular_in_place;
use faer::{Accum, Mat, MatMut, MatRef, Par};

/// The entries of a factor's inverse.
pub struct PatternInverse<'a> {
    pub(super) panels: Panels<'a>,
    pub(super) entries: &'a InverseEntries,
}

/// The entries, stored as those of the factor.
pub(super) struct InverseEntries {
    values: Vec<f32>,
    /// The last panel on the path from each panel to the root of its elimination tree.
    roots: Vec<usize>,
}

impl InverseEntries {
    pub fn new(panels: &Panels) -> Self {
        let count = panels.symbolic.n_supernodes();
        let mut inverse = Self { values: vec![0.0; panels.symbolic.len_val()], roots: vec![0; count] };
        for s in (0..count).rev() {
            let panel = panels.panel(s);
            let parent = panel.pattern.first().map(|row| panels.of(*row));
            inverse.roots[s] = parent.map_or(s, |parent| inverse.roots[parent]);
            inverse.fill(panels, s, &panel);
        }
        inverse
    }

    /// Memory [bytes].
    pub fn memory(&self) -> usize {
        4 * self.values.len() + 8 * self.roots.len()
    }

    fn fill(&mut self, panels: &Panels, s: usize, panel: &Panel) {
        let (columns, below) = (panel.columns, panel.pattern.len());
        let values: Vec<f32> = panel.values.iter().map(|value| *value as f32).collect();
        let L = MatRef::from_column_major_slice(&values, panel.rows, columns);
        let (top, bottom) = L.split_at_row(columns);
        let mut inverse = Mat::<f32>::identity(columns, columns);
        solve_lower_triangular_in_place(top, inverse.as_mut(), Par::Seq);
        let mut U = Mat::<f32>::zeros(below, columns);
        matmul(U.as_mut(), Accum::Replace, bottom, inverse.as_ref(), 1.0, Par::Seq);
        let Z = self.behind(panels, panel.pattern);
        let Z = MatRef::from_column_major_slice(&Z, below, below);
        let range = panels.symbolic.col_ptr_for_val()[s]..panels.symbolic.col_ptr_for_val()[s + 1];
        let own = MatMut::from_column_major_slice_mut(&mut self.values[range], panel.rows, columns);
        let (mut top, mut bottom) = own.split_at_row_mut(columns);
        matmul(bottom.as_mut(), Accum::Replace, Z, U.as_ref(), -1.0, Par::Seq);
        matmul(top.as_mut(), Accum::Replace, inverse.transpose(), inverse.as_ref(), 1.0, Par::Seq);
        matmul(top.as_mut(), Accum::Add, U.transpose(), bottom.as_ref(), -1.0, Par::Seq);
    }

    /// Rows and columns of the pattern of a panel, all of which are in the panels behind it.
    fn behind(&self, panels: &Panels, pattern: &[usize]) -> Vec<f32> {
        let mut Z = vec![0.0; pattern.len() * pattern.len()];
        let mut first = 0;
        while first < pattern.len() {
            // The rows that are columns of one panel, and where the rows behind them are in it.
            let s = panels.of(pattern[first]);
            let panel = panels.panel(s);
            let end = first + pattern[first..].partition_point(|row| *row < panel.start + panel.columns);
            let values = &self.values[panels.symbolic.col_ptr_for_val()[s]..];
            let mut searched = 0;
            for (i, row) in pattern.iter().enumerate().skip(first) {
                let place = if *row < panel.start + panel.columns {
                    row - panel.start
                } else {
                    searched += panel.pattern[searched..].partition_point(|other| other < row);
                    panel.columns + searched
                };
                for (j, column) in pattern.iter().enumerate().take(end).skip(first) {
                    let value = values[(column - panel.start) * panel.rows + place];
                    Z[j * pattern.len() + i] = value;
                    Z[i * pattern.len() + j] = value;
                }
            }
            first = end;
        }
        Z
    }
}

impl PatternInverse<'_> {
    /// An entry of the inverse: zero for unknowns that nothing couples, `None` if it is not in the pattern.
    pub fn entry(&self, row: usize, column: usize) -> Option<f64> {
        let (first, second) = (row.min(column), row.max(column));
        let s = self.panels.of(first);
        let panel = self.panels.panel(s);
        let place = if second < panel.start + panel.columns {
            second - panel.start
        } else if self.entries.roots[s] == self.entries.roots[self.panels.of(second)] {
            panel.columns + panel.pattern.binary_search(&second).ok()?
        } else {
            return Some(0.0);
        };
        let start = self.panels.symbolic.col_ptr_for_val()[s];
        Some(f64::from(self.entries.values[start + (first - panel.start) * panel.rows + place]))
    }
}
