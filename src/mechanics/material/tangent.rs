//! The exact tangent A = ∂P/∂F [Pa] by dual numbers.

use super::Material;
use crate::mechanics::dual::Dual;
use crate::mechanics::real::Real;
use crate::mechanics::tensor::Tensor;

/// `A : dF` [Pa], the change of P along `dF` at `F = I + H`; exact to rounding.
///
/// # Panics
/// With more fibres than [`super::MAX_FAMILIES`].
pub fn tangent_along<R: Real>(
    material: &Material,
    H: &Tensor<R>,
    fibres: &[[R; 3]],
    dF: &Tensor<R>,
) -> Tensor<R> {
    let lifted = Tensor::from_fn(|i, j| Dual { value: H.0[i][j], slope: dF.0[i][j] });
    let zero = H.0[0][0].zero();
    let mut directions = [[Dual { value: zero, slope: zero }; 3]; super::MAX_FAMILIES];
    for (lifted, a) in directions.iter_mut().zip(fibres) {
        *lifted = a.map(|value| Dual { value, slope: zero });
    }
    let P = material.eval_total(&lifted, &directions[..fibres.len()]).P;
    Tensor::from_fn(|i, j| P.0[i][j].slope)
}

/// A [Pa] as a 9×9 matrix, row and column 3 i + J for the component (i, J) of P and F.
///
/// # Panics
/// With more fibres than [`super::MAX_FAMILIES`].
pub fn assemble_tangent(material: &Material, H: &Tensor<f64>, fibres: &[[f64; 3]]) -> [[f64; 9]; 9] {
    let mut A = [[0.0; 9]; 9];
    for column in 0..9 {
        let unit = Tensor::from_fn(|i, j| f64::from(u8::from(3 * i + j == column)));
        let dP = tangent_along(material, H, fibres, &unit);
        for (row, entries) in A.iter_mut().enumerate() {
            entries[column] = dP.0[row / 3][row % 3];
        }
    }
    A
}
