//! Ellipticity of a law at a state: waves of every direction and polarisation have a real speed.
//!
//! Where the acoustic tensor `Q_ik(n) = A_iJkL n_J n_L` of some direction n has a negative eigenvalue, the
//! deformation can localise, on any mesh into bands as narrow as its elements (Hadamard's condition of stability).

use super::{Material, assemble_law_tangent};
use crate::tensor::{Mat3, Tensor, Vec3};

/// Number of directions sampled on a hemisphere: some 6° apart.
const DIRECTIONS: usize = 800;

/// Least eigenvalue of the acoustic tensor over directions [Pa], ≥ 0 where the law is elliptic, at `H = F − I` [-] with J > 0.
///
/// `bulk` is U″ [Pa]: of the element's mean dilatation where the element uses that, of a split law otherwise, 0 for a
/// coupled law. The pressure does not matter: cof F is linear along a⊗n.
///
/// # Panics
/// With more fibres than [`super::MAX_FAMILIES`].
pub fn least_acoustic_eigenvalue(
    material: &Material,
    H: &Tensor<f64>,
    fibres: &[[f64; 3]],
    bulk: f64,
) -> f64 {
    let A = assemble_law_tangent(material, H, fibres);
    let cof = H.plus(&Tensor::diagonal(1.0)).cofactor();
    let along = |n: &Vec3| {
        let normal = Vec3::from(cof.apply(&[n.x, n.y, n.z]));
        let Q = Mat3::from_fn(|i, k| {
            let sum: f64 = (0..9).map(|m| A[3 * i + m / 3][3 * k + m % 3] * n[m / 3] * n[m % 3]).sum();
            sum + bulk * normal[i] * normal[k]
        });
        ((Q + Q.transpose()) * 0.5).symmetric_eigenvalues().min()
    };
    (0..DIRECTIONS).map(|i| along(&direction(i))).fold(f64::INFINITY, f64::min)
}

/// The i-th of [`DIRECTIONS`] on a hemisphere, on a Fibonacci spiral.
fn direction(i: usize) -> Vec3 {
    let z = (i as f64 + 0.5) / DIRECTIONS as f64;
    let (sin, cos) = (i as f64 * std::f64::consts::PI * (3.0 - 5.0_f64.sqrt())).sin_cos();
    let radius = (1.0 - z * z).sqrt();
    Vec3::new(radius * cos, radius * sin, z)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::material::{NeoHookean, Volumetric};

    fn diagonal(stretches: [f64; 3]) -> Tensor<f64> {
        Tensor::from_fn(|i, j| if i == j { stretches[i] - 1.0 } else { 0.0 })
    }

    #[test]
    fn at_rest_it_is_the_shear_modulus() {
        let law = Material::NeoHookean(NeoHookean { c10: 3e4, volumetric: Volumetric::LnSquared(5e7) });
        let least = least_acoustic_eigenvalue(&law, &diagonal([1.0; 3]), &[], 5e7);
        assert!((least / 6e4 - 1.0).abs() < 1e-9, "{least}");
    }

    #[test]
    fn a_polyconvex_law_stays_elliptic_where_it_is_crushed() {
        let law = Material::NeoHookean(NeoHookean { c10: 3e4, volumetric: Volumetric::QuadraticLn(5e7) });
        for stretches in [[0.2, 2.0, 2.5], [4.0, 0.5, 0.5], [0.1, 1.0, 1.0]] {
            assert!(least_acoustic_eigenvalue(&law, &diagonal(stretches), &[], 5e7) > 0.0, "{stretches:?}");
        }
    }

    #[test]
    fn what_softens_is_found() {
        // ln² beyond J = e: U″ = K (1 − ln J)/J², here −0.028 K at the point, along the stretch.
        let K = 1e7;
        let volumetric = Volumetric::LnSquared(K);
        let law = Material::NeoHookean(NeoHookean { c10: 1.0, volumetric });
        let J: f64 = 4.0;
        let H = diagonal([J.cbrt(); 3]);
        let bulk = volumetric.stiffness(J - 1.0);
        let least = least_acoustic_eigenvalue(&law, &H, &[], bulk);
        let expected = K * (1.0 - J.ln()) / (J * J) * J.powf(4.0 / 3.0);
        assert!((least / expected - 1.0).abs() < 1e-5, "{least} against {expected}");
    }
}
