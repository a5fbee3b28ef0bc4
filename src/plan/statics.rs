//! Equilibrium without mass: under-constrained bodies, and the regularisation of their systems.

use super::body::PlanBody;
use super::parts::Parts;
use crate::mechanics::contact::detection::closest_point::Patch;
use crate::mechanics::tensor::Vec3;
use nalgebra::{Matrix6, Vector6};

/// Stabilisation of an under-constrained body, as a fraction of G/(ρ L²), the square of its shear frequencies [-].
///
/// Newton's residual falls by about this factor per iteration: small enough to converge fast. The compliance of the rigid
/// motions is its reciprocal, which enters the contact solver together with that of the elements: large enough to preserve
/// digits.
const STEADYING: f64 = 1e-2;
/// Motions whose eigenvalue is below this fraction of the largest are free [-].
const FREE: f64 = 1e-10;

/// Data for equilibrium without mass.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Statics {
    /// Under-constrained bodies, in ascending order of their index.
    pub under_constrained: Vec<UnderConstrained>,
}

/// An under-constrained body: it can move as a rigid one unless contact holds it.
#[derive(Clone, Debug, PartialEq)]
pub struct UnderConstrained {
    /// Index of the body.
    pub body: usize,
    /// Number of rigid motions that held nodes do not prevent, up to six.
    pub motions: usize,
    /// α [1/s²]: the matrix of Newton's iteration is `h² (K + α M)` for this body, since K alone is singular. The residual
    /// does not contain it, so the equilibrium is that of K.
    pub steadying: f64,
    /// Initial search distance for contacts [m], without which the body would move unbounded. Mean size of its faces.
    pub reach: f64,
}

impl Statics {
    /// The under-constrained bodies among the given parts; the inverse mass of a held node is zero.
    pub(super) fn new(Parts { bodies, blocks, X, inverse_mass, followers, .. }: &Parts) -> Self {
        let of_body = |(index, body): (usize, &PlanBody)| {
            let nodes = || body.nodes.start as usize..body.nodes.end as usize;
            // Followers constrain nothing.
            let own_nodes = nodes().filter(|node| !followers.contains(*node));
            let motions = free_motions(own_nodes, X, inverse_mass);
            let own = blocks.iter().filter(|block| block.body == index).map(|block| &block.parameters);
            // The softest part moves most.
            let square = own.map(|p| p.material.moduli_at_rest().0 / p.density).fold(f64::INFINITY, f64::min);
            let (low, high) = nodes().fold((X[nodes().start], X[nodes().start]), |(low, high), node| {
                (low.inf(&X[node]), high.sup(&X[node]))
            });
            let sizes = body.boundary.faces.iter().map(|face| Patch::new(face, X).area().sqrt());
            UnderConstrained {
                body: index,
                motions,
                steadying: STEADYING * square / (high - low).norm_squared(),
                reach: sizes.sum::<f64>() / body.boundary.faces.len() as f64,
            }
        };
        let deformable = bodies.iter().enumerate().filter(|(_, body)| body.rigid.is_none());
        Self {
            under_constrained: deformable
                .map(of_body)
                .filter(|under_constrained| under_constrained.motions > 0)
                .collect(),
        }
    }
}

/// How many of the six rigid motions of these nodes the held ones leave free.
fn free_motions(nodes: impl Iterator<Item = usize> + Clone, X: &[Vec3], inverse_mass: &[Vec3]) -> usize {
    let centre = nodes.clone().map(|node| X[node]).sum::<Vec3>() / nodes.clone().count() as f64;
    let size = nodes.clone().map(|node| (X[node] - centre).norm()).fold(0.0, f64::max);
    let mut held = Matrix6::<f64>::zeros();
    for node in nodes {
        for axis in (0..3).filter(|axis| inverse_mass[node][*axis] == 0.0) {
            let along = Vec3::ith(axis, 1.0);
            let turning = ((X[node] - centre) / size).cross(&along);
            let row = Vector6::new(along.x, along.y, along.z, turning.x, turning.y, turning.z);
            held += row * row.transpose();
        }
    }
    let squares = held.symmetric_eigenvalues();
    squares.iter().filter(|square| **square <= FREE * squares.amax()).count()
}
