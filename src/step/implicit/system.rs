//! The linear systems of implicit steps: `S = M (1 + ½ α h) + ξ θ h² K(u)`, its factor, and what a unit impulse at the nodes
//! of the contacts does.

use crate::mechanics::contact::Contact;
use crate::mechanics::contact::compliance::NodeCompliance;
use crate::mechanics::force::StiffnessBatch;
use crate::mechanics::sparse::{Cholesky, Definiteness, SparseError, SymmetricMatrix};
use crate::mechanics::tensor::Vec3;
use crate::plan::{Implicit, Plan};
use crate::step::state::Tangent;

/// S at one displacement and step, factored.
pub(super) struct System<'p> {
    plan: &'p Plan,
    options: &'p Implicit,
    matrix: SymmetricMatrix,
    factor: Cholesky,
    stiffness: StiffnessBatch,
    compliance: NodeCompliance,
    diagonal: Vec<f64>,
    /// Where S was taken; `None` before there is any.
    pub tangent: Option<Tangent>,
    /// Matrices factored so far.
    pub factored: u64,
}

impl<'p> System<'p> {
    pub fn new(plan: &'p Plan, options: &'p Implicit) -> Result<Self, SparseError> {
        let matrix = SymmetricMatrix::new(&options.unknowns);
        let factor = Cholesky::new(&matrix)?;
        Ok(Self {
            plan,
            options,
            diagonal: vec![0.0; matrix.size()],
            matrix,
            factor,
            stiffness: StiffnessBatch::zeros(),
            compliance: NodeCompliance::default(),
            tangent: None,
            factored: 0,
        })
    }

    /// Makes the system that a state was left with, unless it is here already.
    pub fn restore(&mut self, left: Option<&Tangent>, damping: f64) -> Result<(), SparseError> {
        let Some(left) = left else {
            self.tangent = None;
            return Ok(());
        };
        if self.tangent.as_ref() == Some(left) {
            return Ok(());
        }
        self.take(&left.u, left.step, damping)?;
        if let Some(tangent) = &mut self.tangent {
            tangent.number = left.number;
        }
        if !left.contact_nodes.is_empty() {
            self.solve_compliance(left.contact_nodes.clone());
        }
        Ok(())
    }

    /// Takes S at displacements `u` [m] for a step `h` [s] with mass-proportional damping [1/s].
    pub fn take(&mut self, u: &[Vec3], h: f64, damping: f64) -> Result<Definiteness, SparseError> {
        let Self { plan, options, matrix, stiffness, diagonal, .. } = self;
        options.unknowns.for_each(|unknown, node, _| {
            diagonal[unknown] = plan.mass[node] * (1.0 + 0.5 * damping * h);
        });
        matrix.set_diagonal(diagonal);
        let factor = options.xi * options.theta * h * h;
        for block in &plan.blocks {
            for batch in 0..block.batch_count() {
                block.eval_stiffness(batch, u, stiffness);
                matrix.add_batch(&options.unknowns, block, batch, stiffness, factor);
            }
        }
        self.factored += 1;
        let found = self.factor.factorize(&self.matrix)?;
        let number = self.tangent.as_ref().map_or(0, |tangent| tangent.number) + 1;
        self.compliance = NodeCompliance::default();
        self.tangent = Some(Tangent { number, u: u.to_vec(), step: h, contact_nodes: Vec::new() });
        Ok(found)
    }

    /// Whether S, as it was taken, is positive definite.
    pub fn is_definite(&self) -> bool {
        self.factor.definiteness() == Definiteness::Positive
    }

    /// `x ← S⁻¹ x`.
    pub fn solve(&mut self, x: &mut [f64]) {
        self.factor.solve(x);
    }

    /// W of contacts, three rows each, row by row [1/kg].
    pub fn delassus(&mut self, contacts: &[Contact]) -> Vec<f64> {
        if !self.compliance.covers(contacts) {
            let nodes = self.compliance.nodes_with(contacts);
            self.solve_compliance(nodes);
        }
        self.compliance.delassus(contacts)
    }

    fn solve_compliance(&mut self, nodes: Vec<u32>) {
        self.compliance.solve(nodes, &self.options.unknowns, &mut self.factor);
        if let Some(tangent) = &mut self.tangent {
            tangent.contact_nodes = self.compliance.nodes().to_vec();
        }
    }
}
