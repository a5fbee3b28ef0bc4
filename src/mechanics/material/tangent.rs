//! The exact tangent A = ∂P/∂F [Pa] by dual numbers.

use super::{Kinematics, Law, MAX_FAMILIES, Material};
use crate::dual::Dual;
use crate::real::Real;
use crate::tensor::Tensor;

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
    let (lifted, directions) = lift(H, fibres, dF);
    let P = material.eval_total(&lifted, &directions[..fibres.len()]).P;
    Tensor::from_fn(|i, j| P.0[i][j].slope)
}

/// [`assemble_tangent`] without the volumetric energy U of a split law; that of a coupled law is complete.
///
/// # Panics
/// With more fibres than [`super::MAX_FAMILIES`].
pub fn assemble_law_tangent(material: &Material, H: &Tensor<f64>, fibres: &[[f64; 3]]) -> [[f64; 9]; 9] {
    assemble(|unit| {
        let (lifted, directions) = lift(H, fibres, unit);
        let k = Kinematics::new(&lifted);
        let fibres = &directions[..fibres.len()];
        let P = material.eval(&k, fibres).first_piola(&k, k.j.zero());
        Tensor::from_fn(|i, j| P.0[i][j].slope)
    })
}

/// A [Pa] as a 9×9 matrix, row and column 3 i + J for the component (i, J) of P and F.
///
/// # Panics
/// With more fibres than [`super::MAX_FAMILIES`].
pub fn assemble_tangent(material: &Material, H: &Tensor<f64>, fibres: &[[f64; 3]]) -> [[f64; 9]; 9] {
    assemble(|unit| tangent_along(material, H, fibres, unit))
}

/// `H` as dual numbers with the slope `dF`, and fibres with zero slope.
fn lift<R: Real>(
    H: &Tensor<R>,
    fibres: &[[R; 3]],
    dF: &Tensor<R>,
) -> (Tensor<Dual<R>>, [[Dual<R>; 3]; MAX_FAMILIES]) {
    let lifted = Tensor::from_fn(|i, j| Dual { value: H.0[i][j], slope: dF.0[i][j] });
    let zero = H.0[0][0].zero();
    let mut directions = [[Dual { value: zero, slope: zero }; 3]; MAX_FAMILIES];
    for (lifted, a) in directions.iter_mut().zip(fibres) {
        *lifted = a.map(|value| Dual { value, slope: zero });
    }
    (lifted, directions)
}

/// The matrix of a linear map of tensors.
fn assemble(along: impl Fn(&Tensor<f64>) -> Tensor<f64>) -> [[f64; 9]; 9] {
    let mut A = [[0.0; 9]; 9];
    for column in 0..9 {
        let unit = Tensor::from_fn(|i, j| f64::from(u8::from(3 * i + j == column)));
        let dP = along(&unit);
        for (row, entries) in A.iter_mut().enumerate() {
            entries[column] = dP.0[row / 3][row % 3];
        }
    }
    A
}
