//! Reference geometry of one element: volumes, lumped volumes, and what the critical time step needs of its gradients.

use super::kind::for_each_element;
use super::largest_eigenvalue::largest_eigenvalue;
use super::{Element, ElementKind};
use crate::tensor::{Mat3, Vec3};
use smallvec::SmallVec;

/// One for each node or point of an element; of up to eight without an allocation, which a large mesh would have millions of.
pub type OfElement<T> = SmallVec<[T; 8]>;

/// Reference geometry of one element.
#[derive(Clone, Debug, PartialEq)]
pub struct ReferenceGeometry {
    /// Kind of element, which gives nodes and quadrature.
    pub kind: ElementKind,
    /// Reference volume of each point [m³].
    pub volume: OfElement<f64>,
    /// Smallest Jacobian determinant over the points, relative to the mean: ≤ 0 for an inverted element.
    pub smallest_jacobian: f64,
    /// Volume lumped at each node, by which mass is lumped; [`Element::lumped_volumes`] unless moved [m³].
    pub corner_volume: OfElement<f64>,
    /// Largest eigenvalue λ of `Σ_q V_q ∇N_a·∇N_b` against the nodes' volumes [1/m²]: with a tangent of norm α and density
    /// ρ, `ω² ≤ α λ / ρ`.
    pub gradient_bound: f64,
}

impl ReferenceGeometry {
    /// From the positions X of the nodes [m]; one that lacks is at zero, so that the element has no volume.
    pub fn new(kind: ElementKind, nodes: &[Vec3]) -> Self {
        Self::with_mass_at(kind, nodes, |volumes| volumes)
    }

    /// The same with volume moved from node to node, by which mass is lumped: `move_volume` changes these volumes.
    pub fn with_mass_at(
        kind: ElementKind,
        nodes: &[Vec3],
        move_volume: impl FnOnce(OfElement<f64>) -> OfElement<f64>,
    ) -> Self {
        macro_rules! of_kind {
            ($($Kind:ident, $N:literal, $Q:literal, $OnePoint:ident;)*) => {
                match kind { $(ElementKind::$Kind => Self::of::<super::$Kind, $N, $Q>(kind, nodes, move_volume),)* }
            };
        }
        for_each_element!(of_kind)
    }

    fn of<E: Element<N, Q>, const N: usize, const Q: usize>(
        kind: ElementKind,
        nodes: &[Vec3],
        move_volume: impl FnOnce(OfElement<f64>) -> OfElement<f64>,
    ) -> Self {
        let at = |a: usize| nodes.get(a).copied().unwrap_or_default();
        let X: [[f64; N]; 3] = std::array::from_fn(|i| std::array::from_fn(|a| at(a)[i]));
        let g = E::local_gradients(&X);
        let jacobians: [Mat3; Q] =
            std::array::from_fn(|q| Mat3::from(&E::local_gradient_at(&g, q)) * E::DERIVATIVE);
        let volume = jacobians.map(|j| j.determinant() * E::WEIGHT);
        let mean = volume.iter().sum::<f64>() / Q as f64;
        let inverse_jacobian = jacobians.map(|j| j.try_inverse().unwrap_or_else(Mat3::zeros));
        let corner_volume = move_volume(OfElement::from_slice(&E::lumped_volumes(&volume)));
        let gradient_bound = gradient_bound::<E, N, Q>(&inverse_jacobian, &volume, &corner_volume);
        let smallest_jacobian =
            volume.iter().copied().fold(f64::INFINITY, f64::min) / mean.abs().max(f64::MIN_POSITIVE);
        Self {
            kind,
            volume: OfElement::from_slice(&volume),
            smallest_jacobian,
            corner_volume,
            gradient_bound,
        }
    }

    /// Volume of the element [m³].
    pub fn total_volume(&self) -> f64 {
        self.volume.iter().sum()
    }
}

/// The largest eigenvalue of the matrix `D^(−½) (Σ_q V_q ∇N·∇Nᵀ) D^(−½)`, D the volumes of the nodes.
fn gradient_bound<E: Element<N, Q>, const N: usize, const Q: usize>(
    inverse: &[Mat3; Q],
    volume: &[f64; Q],
    corner_volume: &[f64],
) -> f64 {
    let scale: [f64; N] = std::array::from_fn(|a| {
        corner_volume.get(a).map_or(0.0, |v| 1.0 / v.abs().sqrt().max(f64::MIN_POSITIVE))
    });
    // The lower triangle.
    let mut G = [[0.0; N]; N];
    for (q, local) in E::shape_gradients().iter().enumerate() {
        let gradients: [Vec3; N] =
            std::array::from_fn(|a| inverse[q].tr_mul(&Vec3::from(local[a])) * scale[a]);
        for a in 0..N {
            let weighted = gradients[a] * volume[q];
            for b in 0..=a {
                G[a][b] += weighted.dot(&gradients[b]);
            }
        }
    }
    largest_eigenvalue(G)
}
