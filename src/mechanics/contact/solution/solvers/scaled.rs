//! The problem in dimensionless numbers: `r̂ = D^½ r`, `û = D^−½ u`, `Ŵ = D^−½ W D^−½`, one number D per contact.
//!
//! The law is homogeneous, so it is the same in r̂ and û. Every diagonal block has trace 3, ρ = 1 is appropriate for
//! every contact, and the scaled error of [`ContactProblem::error_scaled`] is `‖F̂‖ / max(‖r̂‖, ‖q̂‖)` with the
//! natural map F̂ at ρ = 1.

use super::measure::{At, UNBOUNDED};
use super::options::largest_of_motion;
use crate::contact::solution::delassus::{Block, Delassus};
use crate::contact::solution::local::Local;
use crate::contact::solution::problem::{ContactProblem, LARGEST, is_zero, local};

/// The problem and its iterate, scaled.
#[derive(Clone, Debug)]
pub(super) struct Scaled {
    /// Number of contacts nc.
    pub contacts: usize,
    /// Coefficients of friction μ [-], nc.
    pub mu: Vec<f64>,
    pub q: Vec<f64>,
    /// The current reactions r̂, 3 nc.
    pub r: Vec<f64>,
    /// Their velocities `W r + q`, updated with them.
    pub u: Vec<f64>,
    /// Contacts without a local solution in the last sweep.
    pub failed_contacts: usize,
    /// Diagonal blocks `Ŵ_cc`, nc.
    pub diagonal: Vec<Block>,
    /// Proximal weight α and centre: velocities have `α (r − centre)` added.
    proximal: f64,
    centre: Vec<f64>,
    /// The columns of W: velocities due to a unit reaction.
    columns: Columns,
    /// `D^½` of each contact.
    root: Vec<f64>,
    /// As in [`At`].
    q_size: f64,
    hidden: f64,
    /// Whether reactions were found to grow without bound ([`At::is_jammed`]).
    pub is_jammed: bool,
}

/// W stored by columns.
#[derive(Clone, Debug)]
enum Columns {
    /// All entries, column after column.
    Dense(Vec<f64>),
    /// Blocks by columns: starts, rows, blocks.
    Sparse { starts: Vec<usize>, rows: Vec<u32>, blocks: Vec<Block> },
}

impl Scaled {
    /// The scaled problem, with the initial reactions `r`, to be solved to a scaled error of `tolerance`.
    pub fn new(problem: &ContactProblem, r: &[f64], tolerance: f64) -> Self {
        let contacts = problem.contacts();
        let root: Vec<f64> = problem.scales().iter().map(|d| d.sqrt()).collect();
        // Free velocities and initial reactions; what is no number, or so large that its square overflows, starts at zero.
        let mut q = problem.q().to_vec();
        for_each_contact(&mut q, &root, |q, root| *q /= root);
        let mut r = r.to_vec();
        for_each_contact(&mut r, &root, |r, root| {
            *r *= root;
            if !(r.abs() <= LARGEST) {
                *r = 0.0;
            }
        });
        // The operator, and its diagonal blocks.
        let mut diagonal = vec![[[0.0; 3]; 3]; contacts];
        let columns = Columns::new(problem.W(), |c, d, block| {
            let factor = 1.0 / (root[c] * root[d]);
            let scaled = block.map(|row| row.map(|x| x * factor));
            if c == d {
                diagonal[c] = scaled;
            }
            scaled
        });
        // Reactions that hide the free velocities are no guess.
        let [q_size, r_size] = [&q, &r].map(|x| x.iter().map(|x| x * x).sum::<f64>().sqrt());
        if r_size > UNBOUNDED * q_size {
            r.fill(0.0);
        }
        let u = q.clone();
        let mut scaled = Self {
            contacts,
            mu: problem.mu().to_vec(),
            q,
            r,
            u,
            diagonal,
            columns,
            root,
            q_size,
            hidden: largest_of_motion(tolerance) / tolerance,
            is_jammed: false,
            proximal: 0.0,
            failed_contacts: 0,
            centre: Vec::new(),
        };
        scaled.update_velocity();
        scaled
    }

    /// Writes the iterate in the units of the problem.
    pub fn store(&self, r: &mut [f64]) {
        r.copy_from_slice(&self.r);
        for_each_contact(r, &self.root, |r, root| *r /= root);
    }

    /// Recomputes `u = W r + q`.
    pub fn update_velocity(&mut self) {
        self.u.copy_from_slice(&self.q);
        for c in 0..self.contacts {
            let r = local(&self.r, c);
            if !is_zero(r) {
                self.columns.add(c, r, &mut self.u);
            }
        }
        if self.proximal > 0.0 {
            for ((u, r), centre) in self.u.iter_mut().zip(&self.r).zip(&self.centre) {
                *u += self.proximal * (r - centre);
            }
        }
    }

    /// The proximal weight α.
    pub fn proximal(&self) -> f64 {
        self.proximal
    }

    /// Replaces the reactions and updates their velocities.
    pub fn set_reactions(&mut self, r: &[f64]) {
        self.r.copy_from_slice(r);
        self.update_velocity();
    }

    /// Whether all contacts are frictionless.
    pub fn is_frictionless(&self) -> bool {
        self.mu.iter().all(|mu| *mu == 0.0)
    }

    /// Sets `r = start + length · direction` and updates the velocities.
    pub fn move_from(&mut self, start: &[f64], direction: &[f64], length: f64) {
        for ((r, s), d) in self.r.iter_mut().zip(start).zip(direction) {
            *r = s + length * d;
        }
        self.update_velocity();
    }

    /// Adds `α (r − r_now)` to the velocities from now on; α = 0 ends that.
    pub fn set_proximal(&mut self, alpha: f64) {
        for block in &mut self.diagonal {
            for i in 0..3 {
                block[i][i] += alpha - self.proximal;
            }
        }
        self.proximal = alpha;
        self.centre.clone_from(&self.r);
        self.update_velocity();
    }

    /// Sets the reaction of contact `c`, and updates all velocities.
    #[inline]
    pub fn change(&mut self, c: usize, new: Local) {
        let old = local(&self.r, c);
        let change = [new[0] - old[0], new[1] - old[1], new[2] - old[2]];
        if !is_zero(change) {
            self.r[3 * c..3 * c + 3].copy_from_slice(&new);
            self.columns.add(c, change, &mut self.u);
            if self.proximal > 0.0 {
                for i in 0..3 {
                    self.u[3 * c + i] += self.proximal * change[i];
                }
            }
        }
    }

    /// Adds the effect of a reaction `x` of contact `c` to the velocities `u`.
    pub fn add_column(&self, c: usize, x: Local, u: &mut [f64]) {
        self.columns.add(c, x, u);
    }

    /// Visits the blocks of column `c` in the rows that have an index in `place`.
    pub fn for_column(&self, c: usize, place: &[usize], mut visit: impl FnMut(usize, &Block)) {
        match &self.columns {
            Columns::Dense(values) => {
                let n = 3 * self.contacts;
                for (d, &at) in place.iter().enumerate().filter(|(_, p)| **p != usize::MAX) {
                    let block =
                        std::array::from_fn(|i| std::array::from_fn(|j| values[(3 * c + j) * n + 3 * d + i]));
                    visit(at, &block);
                }
            }
            Columns::Sparse { starts, rows, blocks } => {
                let range = starts[c]..starts[c + 1];
                for (row, block) in rows[range.clone()].iter().zip(&blocks[range]) {
                    if place[*row as usize] != usize::MAX {
                        visit(place[*row as usize], block);
                    }
                }
            }
        }
    }

    /// About what a Newton step costs, in Gauss–Seidel sweeps (measured on packings of spheres): the factorisation of a dense matrix, or of a
    /// sparse one, whose fill grows with blocks times contacts, against products with all blocks and the law of each contact.
    pub fn newton_cost_in_sweeps(&self) -> f64 {
        let contacts = self.contacts as f64;
        match &self.columns {
            Columns::Dense(_) => (0.1 * contacts).max(1.0),
            Columns::Sparse { blocks, .. } => {
                let blocks = blocks.len() as f64;
                (3.5 * blocks * contacts / (18.0 * blocks + 200.0 * contacts)).max(1.0)
            }
        }
    }

    /// The iterate.
    pub fn at(&self) -> At<'_> {
        let Self { mu, q, r, u, q_size, hidden, .. } = self;
        At { mu, q, r, u, q_size: *q_size, hidden: *hidden }
    }

    /// [`At::error`] of the iterate.
    pub fn error(&self) -> f64 {
        self.at().error()
    }
}

/// Changes the three numbers of every contact by means of one number per contact.
fn for_each_contact(x: &mut [f64], of_contact: &[f64], change: impl Fn(&mut f64, f64)) {
    for (x, &own) in x.chunks_exact_mut(3).zip(of_contact) {
        for x in x {
            change(x, own);
        }
    }
}

impl Columns {
    fn new(W: &Delassus, mut scaled: impl FnMut(usize, usize, &Block) -> Block) -> Self {
        let (contacts, n) = (W.contacts(), 3 * W.contacts());
        if let Delassus::Dense(_) = W {
            let mut values = vec![0.0; n * n];
            W.for_each_block(|c, d, block| {
                for (i, row) in scaled(c, d, block).into_iter().enumerate() {
                    for (j, x) in row.into_iter().enumerate() {
                        values[(3 * d + j) * n + 3 * c + i] = x;
                    }
                }
            });
            return Self::Dense(values);
        }
        // Count the blocks of each column, then distribute them.
        let mut starts = vec![0; contacts + 1];
        W.for_each_block(|_, d, _| starts[d + 1] += 1);
        for d in 0..contacts {
            starts[d + 1] += starts[d];
        }
        let mut next = starts.clone();
        let mut rows = vec![0; W.block_count()];
        let mut blocks = vec![[[0.0; 3]; 3]; W.block_count()];
        W.for_each_block(|c, d, block| {
            rows[next[d]] = c as u32;
            blocks[next[d]] = scaled(c, d, block);
            next[d] += 1;
        });
        Self::Sparse { starts, rows, blocks }
    }

    /// Adds the effect of a reaction `x` of contact `c` to the velocities `u`.
    #[inline]
    fn add(&self, c: usize, x: Local, u: &mut [f64]) {
        match self {
            Self::Dense(values) => {
                let n = u.len();
                let column = |j: usize| &values[(3 * c + j) * n..(3 * c + j + 1) * n];
                for (((u, a), b), d) in u.iter_mut().zip(column(0)).zip(column(1)).zip(column(2)) {
                    *u += a * x[0] + b * x[1] + d * x[2];
                }
            }
            Self::Sparse { starts, rows, blocks } => {
                let range = starts[c]..starts[c + 1];
                for (row, block) in rows[range.clone()].iter().zip(&blocks[range]) {
                    let at = 3 * *row as usize;
                    for (u, row) in u[at..at + 3].iter_mut().zip(block) {
                        *u += row[0] * x[0] + row[1] * x[1] + row[2] * x[2];
                    }
                }
            }
        }
    }
}
