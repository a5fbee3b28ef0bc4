//! Linear systems of implicit steps: `S = M (1 + ½ α h) + ξ θ h² K(u)`, its factorisation, and the compliance at the
//! nodes of the contacts. In quasi-static steps `S = h² (K + α M)`, with α for bodies that are supported by contact
//! only.
//!
//! K is the tangent of the blocks of elements, with the derivatives of their viscous and memory forces, and the symmetric part of that of the pressures.

use crate::mechanics::contact::solution::compliance::{
    MOST_NODES, NodeCompliance, add_impulse, relative_velocity,
};
use crate::mechanics::contact::solution::delassus::Block;
use crate::mechanics::contact::{Contact, Reaction, RigidSides};
use crate::mechanics::force::{EndOfStep, StiffnessBatch};
use crate::mechanics::lanes::Row;
use crate::mechanics::sparse::{Cholesky, Definiteness, SparseError, SymmetricMatrix};
use crate::mechanics::tensor::Vec3;
use crate::plan::{Implicit, Plan};
use crate::step::loads;
use crate::step::state::Tangent;

/// Factorised S at one displacement and step size.
pub(super) struct System<'p> {
    plan: &'p Plan,
    options: &'p Implicit,
    matrix: SymmetricMatrix,
    factor: Cholesky,
    stiffness: StiffnessBatch,
    compliance: NodeCompliance,
    /// Contacts of this step for which W was last evaluated, and the stored part of it.
    kept: (Vec<Contact>, Kept),
    diagonal: Vec<f64>,
    /// Nodal work array for products with W.
    field: Vec<Vec3>,
    /// Solution of the last product with W, of these reactions; none if `pushed` is empty.
    unknown: Vec<f64>,
    pushed: Vec<f64>,
    /// Linearisation point of S; `None` before the first.
    pub tangent: Option<Tangent>,
    /// Number of factorisations so far.
    pub factored: u64,
}

/// Where S is evaluated.
pub(super) struct Linearisation<'a> {
    /// Displacements [m], nodes × 3.
    pub u: &'a [Vec3],
    /// Velocities [m/s] and history, of which viscosity and memory depend; empty if nothing depends on time.
    pub v: &'a [Vec3],
    pub history: &'a [Vec<Row>],
    /// Length h of the time step [s].
    pub h: f64,
}

/// Stored part of W.
enum Kept {
    Nothing,
    /// All of W, row by row.
    All(Vec<f64>),
    /// Diagonal blocks of W.
    Own(Vec<Block>),
}

/// Number of times the regularisation of bodies supported by contact only is raised, by a factor of ten, until the
/// matrix is positive definite: compressed bodies tend to rotate until contact prevents it.
const MOST_RAISES: i32 = 4;

impl<'p> System<'p> {
    pub fn new(plan: &'p Plan, options: &'p Implicit) -> Result<Self, SparseError> {
        let matrix = SymmetricMatrix::new(&options.unknowns);
        let factor = Cholesky::new(&matrix)?;
        Ok(Self {
            plan,
            options,
            diagonal: vec![0.0; matrix.size()],
            unknown: vec![0.0; matrix.size()],
            matrix,
            factor,
            stiffness: StiffnessBatch::zeros(),
            compliance: NodeCompliance::default(),
            kept: (Vec::new(), Kept::Nothing),
            field: vec![Vec3::zeros(); plan.node_count()],
            pushed: Vec::new(),
            tangent: None,
            factored: 0,
        })
    }

    /// Restores the system of a saved state, unless it is present already.
    pub fn restore(&mut self, left: Option<&Tangent>, damping: f64) -> Result<(), SparseError> {
        let Some(left) = left else {
            self.tangent = None;
            return Ok(());
        };
        if self.tangent.as_ref() == Some(left) {
            return Ok(());
        }
        let at = Linearisation { u: &left.u, v: &left.v, history: &left.history, h: left.step };
        self.take(&at, damping, left.pressures.clone())?;
        if let Some(tangent) = &mut self.tangent {
            tangent.number = left.number;
        }
        if !left.contact_nodes.is_empty() {
            self.solve_compliance(left.contact_nodes.clone());
        }
        Ok(())
    }

    /// Evaluates S with mass-proportional damping [1/s] and pressures [Pa].
    pub fn take(
        &mut self,
        at: &Linearisation,
        damping: f64,
        pressures: Vec<f64>,
    ) -> Result<Definiteness, SparseError> {
        let raises =
            if self.options.statics.as_ref().is_some_and(|statics| !statics.under_constrained.is_empty()) {
                MOST_RAISES
            } else {
                0
            };
        for raise in 0..=raises {
            self.fill(at, (damping, 10.0_f64.powi(raise)), &pressures);
            self.factored += 1;
            if self.factor.factorize(&self.matrix)? == Definiteness::Positive {
                break;
            }
        }
        let number = self.tangent.as_ref().map_or(0, |tangent| tangent.number) + 1;
        self.compliance = NodeCompliance::default();
        self.forget_contacts();
        self.tangent = Some(Tangent {
            number,
            u: at.u.to_vec(),
            v: at.v.to_vec(),
            history: at.history.to_vec(),
            step: at.h,
            pressures,
            contact_nodes: Vec::new(),
        });
        Ok(self.factor.definiteness())
    }

    /// Assembles S; `raised` multiplies the regularisation.
    fn fill(&mut self, at: &Linearisation, (damping, raised): (f64, f64), pressures: &[f64]) {
        let Linearisation { u, v, history, h } = *at;
        self.fill_diagonal(h, damping, raised);
        let Self { plan, options, matrix, stiffness, diagonal, .. } = self;
        matrix.set_diagonal(diagonal);
        let factor = options.xi * options.theta * h * h;
        // Load steps have no velocities.
        let velocity_slope = options.inertia() / (options.theta * h);
        let end = EndOfStep { u, v, h, velocity_slope, history };
        for block in &plan.blocks {
            let depends_on_time = !v.is_empty() && block.parameters.is_viscous();
            let tangent = block.tangent_at(u);
            for batch in 0..block.batch_count() {
                tangent.eval_batch(batch, stiffness);
                if depends_on_time {
                    block.add_rate_stiffness(batch, &end, stiffness);
                }
                matrix.add_batch(&options.unknowns, block, batch, stiffness, factor);
            }
            tangent.for_each_nodal_term(&plan.X, &mut |term| {
                matrix.add_square(&options.unknowns, factor * term.modulus, &term.patch);
            });
        }
        loads::add_stiffness(plan, u, pressures, (factor, &options.unknowns), matrix);
    }

    /// Mass part of S.
    fn fill_diagonal(&mut self, h: f64, damping: f64, raised: f64) {
        let Self { plan, options, diagonal, .. } = self;
        let Some(statics) = &options.statics else {
            options.unknowns.for_each(|unknown, node, axis| {
                diagonal[unknown] = plan.inertia(node)[axis] * (1.0 + 0.5 * damping * h);
            });
            return;
        };
        diagonal.fill(0.0);
        for under_constrained in &statics.under_constrained {
            let nodes = &plan.bodies[under_constrained.body].nodes;
            for node in nodes.start as usize..nodes.end as usize {
                for unknown in (0..3).filter_map(|axis| options.unknowns.of(node, axis)) {
                    diagonal[unknown] = plan.mass[node] * raised * under_constrained.steadying * h * h;
                }
            }
        }
    }

    /// Whether S, as evaluated last, is positive definite.
    pub fn is_definite(&self) -> bool {
        self.factor.definiteness() == Definiteness::Positive
    }

    /// `x ← S⁻¹ x`.
    pub fn solve(&mut self, x: &mut [f64]) {
        self.factor.solve(x);
    }

    /// W of contacts, row by row [1/kg], as [`NodeCompliance::delassus`]. It is kept until the matrix or the contacts
    /// change, or until [`System::forget_contacts`].
    pub fn delassus(&mut self, contacts: &[Contact], rigid: &RigidSides, unknowns: usize) -> Vec<f64> {
        if let (kept, Kept::All(W)) = &self.kept
            && kept == contacts
            && W.len() == (unknowns * contacts.len()).pow(2)
        {
            return W.clone();
        }
        self.pushed.clear();
        if !self.compliance.covers(contacts, rigid) {
            let mut nodes = self.compliance.nodes_with(contacts, rigid);
            if nodes.len() > MOST_NODES {
                nodes = NodeCompliance::default().nodes_with(contacts, rigid);
            }
            self.solve_compliance(nodes);
        }
        let W = self.compliance.delassus(contacts, rigid, unknowns);
        self.kept = (contacts.to_vec(), Kept::All(W.clone()));
        W
    }

    /// Diagonal blocks of W [1/kg] only; kept like W.
    pub fn own_blocks(&mut self, contacts: &[Contact], rigid: &RigidSides) -> Vec<Block> {
        if let (kept, Kept::Own(blocks)) = &self.kept
            && kept == contacts
        {
            return blocks.clone();
        }
        self.pushed.clear();
        let blocks = NodeCompliance::own_blocks(contacts, rigid, &self.options.unknowns, &mut self.factor);
        self.kept = (contacts.to_vec(), Kept::Own(blocks.clone()));
        blocks
    }

    /// `W r` by a solution with S: impulses `r` [N s] of contacts in, velocities `u` [m/s] out, three components per
    /// contact. The contacts are those of the last [`System::own_blocks`]; the solution for the last `r` is known.
    pub fn product(&mut self, contacts: &[Contact], rigid: &RigidSides, r: &[f64], u: &mut [f64]) {
        if self.pushed != r {
            self.field.fill(Vec3::zeros());
            for (contact, r) in contacts.iter().zip(r.chunks_exact(3)) {
                add_impulse(contact, rigid, [r[0], r[1], r[2]], &mut self.field);
            }
            self.options.unknowns.gather(&self.field, &mut self.unknown);
            self.factor.solve(&mut self.unknown);
            self.pushed.clear();
            self.pushed.extend_from_slice(r);
        }
        self.field.fill(Vec3::zeros());
        self.options.unknowns.scatter(&self.unknown, &mut self.field);
        for (contact, u) in contacts.iter().zip(u.chunks_exact_mut(3)) {
            u.copy_from_slice(&relative_velocity(contact, rigid, &self.field, Vec3::zeros()));
        }
    }

    /// `S⁻¹ Cᵀ r` into `x`, given `Cᵀ r` as impulses of the nodes; known where the last product was that of these
    /// `reactions`.
    pub fn respond(&mut self, reactions: &[Reaction], impulses: &[Vec3], x: &mut [f64]) {
        let r = reactions.iter().flat_map(|reaction| reaction.impulse);
        if !self.pushed.is_empty() && r.eq(self.pushed.iter().copied()) {
            x.copy_from_slice(&self.unknown);
        } else {
            self.options.unknowns.gather(impulses, x);
            self.factor.solve(x);
        }
    }

    /// Starts a new step: the poses of rigid bodies may have changed, and with them W of the same contacts.
    pub fn forget_contacts(&mut self) {
        self.kept = (Vec::new(), Kept::Nothing);
        self.pushed.clear();
    }

    fn solve_compliance(&mut self, nodes: Vec<u32>) {
        self.compliance.solve(nodes, &self.options.unknowns, &mut self.factor);
        if let Some(tangent) = &mut self.tangent {
            tangent.contact_nodes = self.compliance.nodes().to_vec();
        }
    }
}
