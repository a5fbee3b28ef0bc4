//! Supernodal factorisation of a sparse symmetric matrix: one symbolic analysis; the memory of factors and solutions
//! is reused.
//!
//! `L Lᵀ` where the matrix is positive definite; otherwise `L B Lᵀ` with Bunch–Kaufman pivots inside the supernodes.
//! The matrix is in the order of elimination. Everything runs on one thread, so that the bits are always the same.

use super::panels::Panels;
use super::pattern_inverse::{InverseEntries, PatternInverse};
use super::{SparseError, SymmetricMatrix};
use faer::dyn_stack::{MemBuffer, MemStack, StackReq};
use faer::linalg::cholesky::llt::factor::LltRegularization;
use faer::sparse::linalg::cholesky::{
    CholeskySymbolicParams, IntranodeLbltRef, LltRef, SymbolicCholesky, SymbolicCholeskyRaw,
    SymmetricOrdering, factorize_symbolic_cholesky,
};
use faer::sparse::{SparseColMatRef, SymbolicSparseColMatRef};
use faer::{Conj, MatMut, Par, Side, Spec};

/// Number of right-hand sides for which the panels of the factor are read once.
const COLUMNS: usize = 96;

/// Result of a factorisation.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Definiteness {
    /// Positive definite: the factor is `L Lᵀ`.
    Positive,
    /// Not positive definite: a step or load too large for a stable equilibrium, or no equilibrium at all.
    Indefinite,
}

/// A factor, ready to solve.
pub struct Cholesky {
    symbolic: SymbolicCholesky<usize>,
    definiteness: Definiteness,
    values: Vec<f64>,
    /// Subdiagonal of B and the pivots; empty until a matrix is indefinite.
    subdiagonal: Vec<f64>,
    pivots: [Vec<usize>; 2],
    /// Entries of the inverse, once they are asked for.
    inverse: Option<InverseEntries>,
    memory: MemBuffer,
    flops: f64,
}

impl std::fmt::Debug for Cholesky {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Cholesky")
            .field("unknowns", &self.symbolic.nrows())
            .field("entries", &self.entries())
            .field("flops", &self.flops)
            .finish_non_exhaustive()
    }
}

impl Cholesky {
    /// Analyses the pattern of a matrix, without factoring it.
    ///
    /// # Errors
    /// [`SparseError::TooLarge`].
    pub fn new(matrix: &SymmetricMatrix) -> Result<Self, SparseError> {
        let size = matrix.size();
        let too_large = |reason: String| SparseError::TooLarge { unknowns: size, reason };
        // The analysis reads the upper triangle.
        let (start, row) = transposed_pattern(matrix);
        let upper = SymbolicSparseColMatRef::new_checked(size, size, &start, None, &row);
        let symbolic = factorize_symbolic_cholesky(
            upper,
            Side::Upper,
            SymmetricOrdering::Identity,
            CholeskySymbolicParams::default(),
        )
        .map_err(|e| too_large(format!("{e:?}")))?;
        let memory = symbolic
            .factorize_numeric_llt_scratch::<f64>(Par::Seq, Spec::default())
            .or(symbolic.solve_in_place_scratch::<f64>(COLUMNS, Par::Seq));
        let memory = allocate(memory).map_err(too_large)?;
        let flops = count_flops(&symbolic);
        let values = vec![0.0; symbolic.len_val()];
        let definiteness = Definiteness::Positive;
        let (subdiagonal, pivots) = (Vec::new(), [Vec::new(), Vec::new()]);
        Ok(Self { symbolic, definiteness, values, subdiagonal, pivots, inverse: None, memory, flops })
    }

    /// Number of entries of the factor, including zeros inside supernodes.
    pub fn entries(&self) -> usize {
        self.values.len()
    }

    /// Number of floating-point operations of a factorisation, `Σ |column|²`.
    pub fn flops(&self) -> f64 {
        self.flops
    }

    /// Memory of the factor and its buffers [bytes].
    pub fn memory(&self) -> usize {
        let inverse = self.inverse.as_ref().map_or(0, InverseEntries::memory);
        8 * (self.values.len() + self.subdiagonal.len() + 2 * self.pivots[0].len())
            + inverse
            + self.memory.len()
    }

    /// Definiteness found by the last factorisation.
    pub fn definiteness(&self) -> Definiteness {
        self.definiteness
    }

    /// Factors a matrix with the pattern that was analysed.
    ///
    /// # Errors
    /// [`SparseError::TooLarge`] when there is no memory for the pivots of an indefinite matrix.
    pub fn factorize(&mut self, matrix: &SymmetricMatrix) -> Result<Definiteness, SparseError> {
        let size = matrix.size();
        self.inverse = None;
        let pattern =
            SymbolicSparseColMatRef::new_checked(size, size, &matrix.column_start, None, &matrix.row);
        let A = SparseColMatRef::new(pattern, &matrix.value[..]);
        // Cholesky; where that fails, with pivots.
        let llt = self.symbolic.factorize_numeric_llt(
            &mut self.values,
            A,
            Side::Lower,
            LltRegularization::default(),
            Par::Seq,
            MemStack::new(&mut self.memory),
            Spec::default(),
        );
        self.definiteness = if llt.is_ok() { Definiteness::Positive } else { Definiteness::Indefinite };
        if self.definiteness == Definiteness::Indefinite {
            self.make_room_for_pivots(size)?;
            let [forward, backward] = &mut self.pivots;
            self.symbolic.factorize_numeric_intranode_lblt(
                &mut self.values,
                &mut self.subdiagonal,
                forward,
                backward,
                A,
                Side::Lower,
                Par::Seq,
                MemStack::new(&mut self.memory),
                Spec::default(),
            );
        }
        Ok(self.definiteness)
    }

    /// Rows and columns `unknowns` (each once) of A⁻¹, row by row. The bits depend on the list as a whole.
    pub fn inverse_block(&mut self, unknowns: &[usize], to: &mut [f64]) {
        if let Some(panels) = self.panels() {
            return panels.inverse_block(unknowns, to);
        }
        let size = self.symbolic.nrows();
        let mut column = vec![0.0; size];
        for (j, unknown) in unknowns.iter().enumerate() {
            column.fill(0.0);
            column[*unknown] = 1.0;
            self.solve(&mut column);
            for (i, row) in unknowns.iter().enumerate() {
                to[i * unknowns.len() + j] = column[*row];
            }
        }
    }

    /// Entries of A⁻¹ in the pattern of the factor, computed once for each; `None` where the factor has no panels.
    pub fn pattern_inverse(&mut self) -> Option<PatternInverse<'_>> {
        if self.inverse.is_none() {
            self.inverse = self.panels().as_ref().map(InverseEntries::new);
        }
        Some(PatternInverse { panels: self.panels()?, entries: self.inverse.as_ref()? })
    }

    /// The panels of the factor of a positive definite matrix; `None` for small or very sparse ones, which are factored without panels.
    fn panels(&self) -> Option<Panels<'_>> {
        match (self.symbolic.raw(), self.definiteness) {
            (SymbolicCholeskyRaw::Supernodal(symbolic), Definiteness::Positive) => {
                Some(Panels::new(symbolic, &self.values))
            }
            _ => None,
        }
    }

    fn make_room_for_pivots(&mut self, size: usize) -> Result<(), SparseError> {
        if self.subdiagonal.len() < size {
            self.subdiagonal = vec![0.0; size];
            self.pivots = [vec![0; size], vec![0; size]];
            let memory = self
                .symbolic
                .factorize_numeric_intranode_lblt_scratch::<f64>(Par::Seq, Spec::default())
                .or(self.symbolic.solve_in_place_scratch::<f64>(COLUMNS, Par::Seq));
            if memory.size_bytes() > self.memory.len() {
                self.memory =
                    allocate(memory).map_err(|reason| SparseError::TooLarge { unknowns: size, reason })?;
            }
        }
        Ok(())
    }

    /// Solves `A x = b` for right-hand sides one after the other in `x`, each as long as the number of unknowns: b
    /// in, x out.
    pub fn solve(&mut self, x: &mut [f64]) {
        let size = self.symbolic.nrows();
        if size == 0 {
            return;
        }
        // One right-hand side by panels, several in blocks.
        if let (Some(panels), true) = (self.panels(), x.len() == size) {
            return panels.solve(x);
        }
        for block in x.chunks_mut(COLUMNS * size) {
            let columns = block.len() / size;
            let rhs = MatMut::from_column_major_slice_mut(block, size, columns);
            let stack = MemStack::new(&mut self.memory);
            match self.definiteness {
                Definiteness::Positive => LltRef::new(&self.symbolic, &self.values).solve_in_place_with_conj(
                    Conj::No,
                    rhs,
                    Par::Seq,
                    stack,
                ),
                Definiteness::Indefinite => {
                    let [forward, backward] = &self.pivots;
                    let perm = faer::perm::PermRef::new_checked(forward, backward, size);
                    IntranodeLbltRef::new(&self.symbolic, &self.values, &self.subdiagonal, perm)
                        .solve_in_place_with_conj(Conj::No, rhs, Par::Seq, stack);
                }
            }
        }
    }
}

fn allocate(memory: StackReq) -> Result<MemBuffer, String> {
    MemBuffer::try_new(memory).map_err(|_| format!("{} bytes of working memory", memory.size_bytes()))
}

/// The upper triangle by columns: the lower one by rows.
fn transposed_pattern(matrix: &SymmetricMatrix) -> (Vec<usize>, Vec<usize>) {
    let size = matrix.size();
    let mut start = vec![0; size + 1];
    for row in &matrix.row {
        start[row + 1] += 1;
    }
    for i in 0..size {
        start[i + 1] += start[i];
    }
    let (mut next, mut column) = (start.clone(), vec![0; matrix.row.len()]);
    for j in 0..size {
        for row in &matrix.row[matrix.column_start[j]..matrix.column_start[j + 1]] {
            column[next[*row]] = j;
            next[*row] += 1;
        }
    }
    (start, column)
}

/// Σ |column of L|².
fn count_flops(symbolic: &SymbolicCholesky<usize>) -> f64 {
    let of_panel = |rows: usize, columns: usize| -> f64 {
        (0..columns).map(|k| (rows - k) as f64).map(|length| length * length).sum()
    };
    match symbolic.raw() {
        SymbolicCholeskyRaw::Simplicial(simplicial) => {
            simplicial.col_ptr().windows(2).map(|w| of_panel(w[1] - w[0], 1)).sum()
        }
        SymbolicCholeskyRaw::Supernodal(supernodal) => (0..supernodal.n_supernodes())
            .map(|s| {
                let columns = supernodal.supernode_end()[s] - supernodal.supernode_begin()[s];
                of_panel(columns + supernodal.supernode(s).pattern().len(), columns)
            })
            .sum(),
    }
}
