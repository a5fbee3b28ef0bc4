//! Laplace's equation between two surfaces of some elements of a mesh: ∇²φ = 0, φ = 0 on the one, φ = 1 on the other, no flux
//! through the rest. Its gradient runs from the one to the other around what is in the way, as fibres do.
//!
//! Finite elements of the mesh's own interpolation; conjugate gradients with the diagonal as preconditioner, on the matrices of the
//! elements (they are never summed). Hanging nodes follow their masters.

use super::cell::MOST_NODES;
use super::{Cell, CellKind, Mesh};
use crate::mechanics::followers::Followers;
use crate::mechanics::tensor::{Mat3, Vec3};
use std::collections::BTreeMap;

/// Residual of the solution relative to that at the start.
const TOLERANCE: f64 = 1e-12;
/// Iterations per unknown after which the solution is given up; rounding apart, one suffices.
const PATIENCE: usize = 3;

/// Why there is no solution.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum LaplaceError {
    /// A surface has no node of the elements.
    #[error("no node of these elements is in the surface")]
    NoNodes {
        /// Whether it is the surface where φ = 1.
        at_end: bool,
    },
    /// Both surfaces have a node.
    #[error("the two surfaces meet at {count} nodes")]
    Meet {
        /// Number of nodes in both.
        count: usize,
    },
    /// The masters of hanging nodes are inconsistent, or the iterations did not converge.
    #[error("Laplace's equation cannot be solved: {0}")]
    Unsolved(String),
}

/// Gradients of the shape functions of a kind at its quadrature points, in natural coordinates: `[point][node]`.
type LocalGradients = Vec<Vec<Vec3>>;

/// Local gradients of every kind, found from the Jacobians of unit vectors at single nodes.
fn local_gradients() -> BTreeMap<CellKind, LocalGradients> {
    let of_kind = |kind: CellKind| {
        let table = kind.table();
        let at = |&(xi, _): &([f64; 3], f64)| {
            let of_node = |node: usize| {
                let mut x = vec![Vec3::zeros(); kind.node_count()];
                x[node] = Vec3::x();
                (table.jacobian)(&x, xi).row(0).transpose()
            };
            (0..kind.node_count()).map(of_node).collect()
        };
        (kind, table.quadrature.iter().map(at).collect())
    };
    CellKind::ALL.into_iter().map(of_kind).collect()
}

/// Calls `take` with the gradients ∂N/∂X [1/m] and the volume [m³] of each quadrature point of a cell.
fn for_each_point(
    local: &BTreeMap<CellKind, LocalGradients>,
    cell: Cell,
    nodes: &[Vec3],
    mut take: impl FnMut(&[Vec3], f64),
) {
    let table = cell.kind.table();
    let x = cell.points(nodes);
    let mut gradients = [Vec3::zeros(); MOST_NODES];
    for (&(xi, weight), of_point) in table.quadrature.iter().zip(&local[&cell.kind]) {
        let jacobian = (table.jacobian)(&x, xi);
        let to_global = jacobian.try_inverse().unwrap_or_else(Mat3::zeros).transpose();
        for (gradient, own) in gradients.iter_mut().zip(of_point) {
            *gradient = to_global * own;
        }
        take(&gradients[..of_point.len()], weight * jacobian.determinant());
    }
}

/// The solution in some elements of a mesh, between the nodes `from` and `to`: its mean gradient in each of them [1/m], in their order.
///
/// # Errors
/// [`LaplaceError`] where the surfaces are no boundary of these elements.
pub fn gradients(
    mesh: &Mesh,
    elements: &[usize],
    from: &[u32],
    to: &[u32],
) -> Result<Vec<Vec3>, LaplaceError> {
    let followers = Followers::new(mesh.nodes.len(), &mesh.hanging.ties())
        .map_err(|error| LaplaceError::Unsolved(error.to_string()))?;
    let system = System::new(mesh, elements, followers);
    let phi = system.solve(from, to)?;
    let local = local_gradients();
    let mean = |&element: &usize| {
        let cell = mesh.cells.get(element);
        let (mut sum, mut volume) = (Vec3::zeros(), 0.0);
        for_each_point(&local, cell, &mesh.nodes, |gradients, weight| {
            let at_point: Vec3 =
                gradients.iter().zip(cell.nodes).map(|(g, node)| g * phi[*node as usize]).sum();
            sum += at_point * weight;
            volume += weight;
        });
        sum / volume
    };
    Ok(elements.iter().map(mean).collect())
}

/// Stiffness matrices of Laplace's equation, element by element.
struct System<'a> {
    mesh: &'a Mesh,
    elements: &'a [usize],
    followers: Followers,
    /// Element matrices one after the other, row-major.
    matrices: Vec<f64>,
}

impl<'a> System<'a> {
    fn new(mesh: &'a Mesh, elements: &'a [usize], followers: Followers) -> Self {
        let local = local_gradients();
        let mut matrices = Vec::new();
        for &element in elements {
            let cell = mesh.cells.get(element);
            let (count, start) = (cell.nodes.len(), matrices.len());
            matrices.resize(start + count * count, 0.0);
            for_each_point(&local, cell, &mesh.nodes, |gradients, weight| {
                for (a, g) in gradients.iter().enumerate() {
                    for (b, h) in gradients.iter().enumerate() {
                        matrices[start + count * a + b] += weight * g.dot(h);
                    }
                }
            });
        }
        Self { mesh, elements, followers, matrices }
    }

    /// Each element's nodes with its matrix.
    fn each(&self) -> impl Iterator<Item = (&[u32], &[f64])> {
        let mut rest = &self.matrices[..];
        self.elements.iter().map(move |&element| {
            let nodes = self.mesh.cells.get(element).nodes;
            let (own, others) = rest.split_at(nodes.len() * nodes.len());
            rest = others;
            (nodes, own)
        })
    }

    /// y = K x, with hanging nodes of x set and those of y handed over.
    fn multiply(&self, x: &mut [f64], y: &mut [f64]) {
        self.follow(x);
        y.fill(0.0);
        for (nodes, matrix) in self.each() {
            for (node, row) in nodes.iter().zip(matrix.chunks_exact(nodes.len())) {
                y[*node as usize] +=
                    row.iter().zip(nodes).map(|(k, other)| k * x[*other as usize]).sum::<f64>();
            }
        }
        for (node, masters) in self.followers.each() {
            let own = std::mem::take(&mut y[node as usize]);
            for (master, weight) in masters {
                y[*master as usize] += weight * own;
            }
        }
    }

    fn follow(&self, x: &mut [f64]) {
        for (node, masters) in self.followers.each() {
            x[node as usize] = masters.iter().map(|(master, weight)| weight * x[*master as usize]).sum();
        }
    }

    /// Diagonal of K with the hanging nodes handed over, up to the coupling between masters of one node: good enough to divide by.
    fn diagonal(&self) -> Vec<f64> {
        let mut diagonal = vec![0.0; self.mesh.nodes.len()];
        for (nodes, matrix) in self.each() {
            for (a, node) in nodes.iter().enumerate() {
                for (master, weight) in self.followers.movers(*node) {
                    diagonal[master as usize] += weight * weight * matrix[a * (nodes.len() + 1)];
                }
            }
        }
        diagonal
    }

    /// φ at all nodes.
    fn solve(&self, from: &[u32], to: &[u32]) -> Result<Vec<f64>, LaplaceError> {
        let diagonal = self.diagonal();
        // Nodes of the elements, or masters of such nodes; hanging nodes follow.
        let is_unknown =
            |node: &u32| diagonal[*node as usize] > 0.0 && !self.followers.contains(*node as usize);
        let mut given = vec![false; diagonal.len()];
        let mut phi = vec![0.0; diagonal.len()];
        for (at_end, nodes) in [(false, from), (true, to)] {
            let mut nodes = nodes.iter().filter(|node| is_unknown(node)).peekable();
            nodes.peek().ok_or(LaplaceError::NoNodes { at_end })?;
            nodes.for_each(|node| {
                given[*node as usize] = true;
                phi[*node as usize] = f64::from(at_end);
            });
        }
        let count = from.iter().filter(|node| is_unknown(node) && phi[**node as usize] > 0.0).count();
        if count > 0 {
            return Err(LaplaceError::Meet { count });
        }
        let inverse: Vec<f64> = (0..)
            .zip(&diagonal)
            .map(|(node, d)| if is_unknown(&node) && !given[node as usize] { 1.0 / d } else { 0.0 })
            .collect();
        self.iterate(&inverse, &mut phi)?;
        self.follow(&mut phi);
        Ok(phi)
    }

    /// Conjugate gradients from φ on, at the nodes where the inverse diagonal is not zero.
    fn iterate(&self, inverse: &[f64], phi: &mut [f64]) -> Result<(), LaplaceError> {
        let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        let mut product = vec![0.0; phi.len()];
        self.multiply(phi, &mut product);
        let free = |value: f64, inverse: f64| if inverse > 0.0 { value } else { 0.0 };
        let mut residual: Vec<f64> = product.iter().zip(inverse).map(|(y, i)| free(-y, *i)).collect();
        let conditioned =
            |residual: &[f64]| -> Vec<f64> { residual.iter().zip(inverse).map(|(r, i)| r * i).collect() };
        let mut direction = conditioned(&residual);
        let mut size = dot(&residual, &direction);
        let enough = TOLERANCE * TOLERANCE * size;
        let unknowns = inverse.iter().filter(|i| **i > 0.0).count();
        for _ in 0..PATIENCE * unknowns.max(100) {
            if size <= enough {
                return Ok(());
            }
            self.multiply(&mut direction, &mut product);
            // Followers have no unknown of their own.
            product.iter_mut().zip(inverse).for_each(|(y, i)| *y = free(*y, *i));
            let step = size / dot(&direction, &product);
            for node in 0..phi.len() {
                phi[node] += step * free(direction[node], inverse[node]);
                residual[node] -= step * product[node];
            }
            let next = conditioned(&residual);
            let grown = dot(&residual, &next);
            direction.iter_mut().zip(&next).for_each(|(d, n)| *d = n + grown / size * *d);
            size = grown;
        }
        let left = (size / enough).sqrt() * TOLERANCE;
        Err(LaplaceError::Unsolved(format!("after many iterations the residual is {left:.1e} of the first")))
    }
}

#[cfg(test)]
mod tests;
