//! The Delassus operator W of a contact problem: dense, or sparse in blocks of three rows and columns.

use super::local::Local;

/// One block of W, row by row: the velocity of one contact due to the reaction of another. Need not be symmetric.
pub type Block = [[f64; 3]; 3];

/// Why an operator cannot be built.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum DelassusError {
    /// The values do not form a square matrix with three rows per contact.
    #[error("{given} values, but {contacts} contacts have {expected}")]
    Size {
        /// Number of contacts nc.
        contacts: usize,
        /// Number of values required, (3 nc)².
        expected: usize,
        /// Number of values given.
        given: usize,
    },
    /// A block of a contact that does not exist.
    #[error("block ({row}, {column}) of {contacts} contacts")]
    Block {
        /// Row of the block.
        row: usize,
        /// Column of the block.
        column: usize,
        /// Number of contacts nc.
        contacts: usize,
    },
}

/// `W` [1/kg for impulses and velocities], 3 nc × 3 nc, three rows (n, t1, t2) per contact.
///
/// Need not be symmetric to rounding, nor of full rank.
#[derive(Clone, Debug, PartialEq)]
pub enum Delassus {
    /// All values, row by row.
    Dense(DenseDelassus),
    /// Only blocks that may be non-zero.
    Sparse(SparseDelassus),
}

/// All values of W, row by row.
#[derive(Clone, Debug, PartialEq)]
pub struct DenseDelassus {
    contacts: usize,
    values: Vec<f64>,
}

/// Blocks of W by rows (block CSR), columns ascending in each; every diagonal block is stored.
#[derive(Clone, Debug, PartialEq)]
pub struct SparseDelassus {
    /// Start of each row of blocks, and the end: nc + 1.
    starts: Vec<usize>,
    columns: Vec<u32>,
    blocks: Vec<Block>,
}

impl Delassus {
    /// From all `(3 contacts)²` values, row by row.
    ///
    /// # Errors
    /// [`DelassusError::Size`].
    pub fn dense(contacts: usize, values: Vec<f64>) -> Result<Self, DelassusError> {
        let n = 3 * contacts;
        if values.len() == n * n {
            return Ok(Self::Dense(DenseDelassus { contacts, values }));
        }
        Err(DelassusError::Size { contacts, expected: n * n, given: values.len() })
    }

    /// From blocks (row, column, values) in any order; those at the same place are added in the order given.
    ///
    /// # Errors
    /// [`DelassusError::Block`].
    pub fn from_blocks(
        contacts: usize,
        given: impl IntoIterator<Item = (usize, usize, Block)>,
    ) -> Result<Self, DelassusError> {
        let mut list: Vec<(u32, u32, Block)> = Vec::new();
        for (row, column, block) in given {
            if row >= contacts || column >= contacts {
                return Err(DelassusError::Block { row, column, contacts });
            }
            list.push((row as u32, column as u32, block));
        }
        list.extend((0..contacts as u32).map(|c| (c, c, [[0.0; 3]; 3])));
        // A stable sort, so that sums have the same bits whatever else is in the list.
        list.sort_by_key(|&(row, column, _)| (row, column));
        let mut sparse = SparseDelassus { starts: vec![0], columns: Vec::new(), blocks: Vec::new() };
        for run in list.chunk_by(|a, b| (a.0, a.1) == (b.0, b.1)) {
            while sparse.starts.len() <= run[0].0 as usize {
                sparse.starts.push(sparse.blocks.len());
            }
            // Add the blocks at the same place.
            let mut sum = run[0].2;
            for (_, _, block) in &run[1..] {
                add(&mut sum, block);
            }
            sparse.columns.push(run[0].1);
            sparse.blocks.push(sum);
        }
        sparse.starts.push(sparse.blocks.len());
        sparse.starts.truncate(contacts + 1);
        Ok(Self::Sparse(sparse))
    }

    /// Number of contacts nc.
    pub fn contacts(&self) -> usize {
        match self {
            Self::Dense(W) => W.contacts,
            Self::Sparse(W) => W.starts.len() - 1,
        }
    }

    /// Number of stored blocks.
    pub fn block_count(&self) -> usize {
        match self {
            Self::Dense(W) => W.contacts * W.contacts,
            Self::Sparse(W) => W.blocks.len(),
        }
    }

    /// Relative velocities `u = W r + q`.
    pub fn apply(&self, r: &[f64], q: &[f64], u: &mut [f64]) {
        match self {
            Self::Dense(W) => W.apply(r, q, u),
            Self::Sparse(W) => {
                for c in 0..self.contacts() {
                    let mut sum = [q[3 * c], q[3 * c + 1], q[3 * c + 2]];
                    for (d, block) in W.row(c) {
                        let x = [r[3 * d], r[3 * d + 1], r[3 * d + 2]];
                        for (s, row) in sum.iter_mut().zip(block) {
                            *s += row[0] * x[0] + row[1] * x[1] + row[2] * x[2];
                        }
                    }
                    u[3 * c..3 * c + 3].copy_from_slice(&sum);
                }
            }
        }
    }

    /// Diagonal block `W_cc` of contact `c`.
    pub fn diagonal_block(&self, c: usize) -> Block {
        match self {
            Self::Dense(W) => W.block(c, c),
            Self::Sparse(W) => W.row(c).find(|(d, _)| *d == c).map_or([[0.0; 3]; 3], |(_, b)| *b),
        }
    }

    /// The operator of some contacts, ascending, that no block connects to others.
    ///
    /// # Errors
    /// [`DelassusError::Block`] if they are connected to others.
    pub fn part(&self, contacts: &[usize]) -> Result<Self, DelassusError> {
        let nc = contacts.len();
        match self {
            Self::Dense(W) => {
                let rows = contacts.iter().flat_map(|c| 3 * c..3 * c + 3);
                let row =
                    |i: usize| contacts.iter().flat_map(move |d| W.row(i)[3 * d..3 * d + 3].iter().copied());
                Self::dense(nc, rows.flat_map(row).collect())
            }
            Self::Sparse(W) => {
                let place = |d: usize| contacts.binary_search(&d).unwrap_or(nc);
                let row = |(i, c): (usize, &usize)| W.row(*c).map(move |(d, block)| (i, place(d), *block));
                Self::from_blocks(nc, contacts.iter().enumerate().flat_map(row))
            }
        }
    }

    /// Calls `visit` for every stored block `(row, column, block)`, row by row.
    pub fn for_each_block(&self, mut visit: impl FnMut(usize, usize, &Block)) {
        match self {
            Self::Dense(W) => {
                for c in 0..W.contacts {
                    for d in 0..W.contacts {
                        visit(c, d, &W.block(c, d));
                    }
                }
            }
            Self::Sparse(W) => {
                for c in 0..self.contacts() {
                    for (d, block) in W.row(c) {
                        visit(c, d, block);
                    }
                }
            }
        }
    }

    /// Whether every number is finite.
    pub fn is_finite(&self) -> bool {
        match self {
            Self::Dense(W) => W.values.iter().all(|x| x.is_finite()),
            Self::Sparse(W) => W.blocks.iter().flatten().flatten().all(|x| x.is_finite()),
        }
    }
}

impl DenseDelassus {
    /// Block `W_cd` of contacts `c` and `d`.
    pub fn block(&self, c: usize, d: usize) -> Block {
        let n = 3 * self.contacts;
        std::array::from_fn(|i| {
            let at = (3 * c + i) * n + 3 * d;
            [self.values[at], self.values[at + 1], self.values[at + 2]]
        })
    }

    /// Whether a reaction of contact `d` changes the velocity of contact `c`.
    pub fn connects(&self, c: usize, d: usize) -> bool {
        self.block(c, d).iter().flatten().any(|x| *x != 0.0)
    }

    /// Row `i` of 3 nc.
    fn row(&self, i: usize) -> &[f64] {
        let n = 3 * self.contacts;
        &self.values[i * n..(i + 1) * n]
    }

    fn apply(&self, r: &[f64], q: &[f64], u: &mut [f64]) {
        // Zero reactions are skipped: most contacts of a dense problem are open.
        let pressed: Vec<usize> = (0..self.contacts).filter(|&d| r[3 * d..3 * d + 3] != [0.0; 3]).collect();
        for (i, (u, q)) in u.iter_mut().zip(q).enumerate() {
            let row = self.row(i);
            let dot = |d: &usize| {
                let at = 3 * d;
                row[at] * r[at] + row[at + 1] * r[at + 1] + row[at + 2] * r[at + 2]
            };
            *u = q + pressed.iter().map(dot).sum::<f64>();
        }
    }
}

impl SparseDelassus {
    /// The blocks of row `c`, with their columns.
    #[inline]
    pub fn row(&self, c: usize) -> impl Iterator<Item = (usize, &Block)> {
        let range = self.starts[c]..self.starts[c + 1];
        self.columns[range.clone()].iter().map(|&d| d as usize).zip(&self.blocks[range])
    }
}

fn add(sum: &mut Block, block: &Block) {
    for (s, b) in sum.iter_mut().flatten().zip(block.iter().flatten()) {
        *s += b;
    }
}

/// Product `W x` with one block.
#[inline]
pub(super) fn times(W: &Block, x: Local) -> Local {
    let row = |w: Local| w[0] * x[0] + w[1] * x[1] + w[2] * x[2];
    [row(W[0]), row(W[1]), row(W[2])]
}
