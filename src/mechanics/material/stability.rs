//! Stability of an isotropic law in the usual tests: Drucker's condition for the incompressible solid.

use super::{Material, assemble_law_tangent};
use crate::tensor::{Mat3, Tensor, Vec3};

/// Logarithmic strains of the tests, relative to that of the stretch that names their state.
const TESTS: [(&str, [f64; 3]); 3] =
    [("uniaxial", [1.0, -0.5, -0.5]), ("equibiaxial", [1.0, 1.0, -2.0]), ("planar", [1.0, 0.0, -1.0])];

/// Number of states between rest and each end of a test.
const STATES: u32 = 80;

/// Rounding of a tangent, relative to its largest entry [-].
const ROUNDING: f64 = 256.0 * f64::EPSILON;

/// State at which a law loses stability.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Instability {
    /// The test: "uniaxial", "equibiaxial" or "planar".
    pub test: &'static str,
    /// Stretch λ at that state [-].
    pub stretch: f64,
}

/// The state nearest to rest between two stretches, in uniaxial, equibiaxial or planar tension or compression, at
/// which `dτ : dε > 0` fails for some isochoric dε: τ the Kirchhoff stress, ε the logarithmic strain. Fibres are
/// omitted.
pub fn first_instability(material: &Material, [least, most]: [f64; 2]) -> Option<Instability> {
    (1..=STATES).find_map(|i| {
        let fraction = f64::from(i) / f64::from(STATES);
        let ends = [fraction * most.ln(), fraction * least.ln()];
        TESTS.into_iter().find_map(|(test, along)| {
            let end = ends.into_iter().find(|end| !is_stable(material, along.map(|x| x * end)))?;
            Some(Instability { test, stretch: end.exp() })
        })
    })
}

/// Whether dτ : dε > 0 for every isochoric dε along the principal axes, at these traceless logarithmic strains.
fn is_stable(material: &Material, logs: [f64; 3]) -> bool {
    let H = Tensor::from_fn(|i, j| if i == j { logs[i].exp_m1() } else { 0.0 });
    let A = assemble_law_tangent(material, &H, &[]);
    let P = material.eval_total(&H, &[]).P;
    let stretches = logs.map(f64::exp);
    // ∂τᵢ/∂ln λⱼ of τᵢ = Pᵢ λᵢ
    let D = Mat3::from_fn(|i, j| {
        let own = if i == j { P.0[i][i] * stretches[i] } else { 0.0 };
        A[4 * i][4 * j] * stretches[i] * stretches[j] + own
    });
    let (a, b) = (Vec3::new(1.0, -1.0, 0.0) / 2.0_f64.sqrt(), Vec3::new(1.0, 1.0, -2.0) / 6.0_f64.sqrt());
    let [aa, bb, ab] = [a.dot(&(D * a)), b.dot(&(D * b)), 0.5 * (a.dot(&(D * b)) + b.dot(&(D * a)))];
    // A high power makes one direction so much stiffer than another that the lesser stiffness is lost in rounding.
    let rounding = ROUNDING * D.amax();
    // Not `<=`: a NaN is not stable.
    aa + bb > 0.0 && aa * bb - ab * ab > -rounding * (aa + bb)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::material::{MooneyRivlin, NeoHookean, Ogden, OgdenTerm, Volumetric, Yeoh};

    const U: Volumetric = Volumetric::LnSquared(1e4);

    #[test]
    fn positive_constants_are_stable() {
        // For fat: at stretches of 0.5 and 4 its stiffnesses differ by 18 digits.
        let fat = Ogden::new(&[OgdenTerm { mu: 30.0, alpha: 20.0 }], Volumetric::LnSquared(5e7)).unwrap();
        for law in [
            fat.into(),
            NeoHookean { c10: 3.0, volumetric: U }.into(),
            MooneyRivlin { c10: 3.0, c01: 2.0, volumetric: U }.into(),
            Yeoh { c10: 3.0, c20: 0.5, c30: 0.1, volumetric: U }.into(),
        ] {
            assert_eq!(first_instability(&law, [0.25, 4.0]), None, "{law:?}");
        }
    }

    #[test]
    fn the_maximum_of_a_softening_law_s_kirchhoff_stress_is_found() {
        // Planar tension, I1 − 3 = x = λ² + λ⁻² − 2: τ1 − τ3 = 2 (C10 + 2 C20 x)(λ² − λ⁻²), whose slope by ln λ, with dx = 2 (λ² − λ⁻²), is
        // 4 (C10 + 2 C20 x)(λ² + λ⁻²) + 8 C20 (λ² − λ⁻²)².
        let (c10, c20) = (1.0, -0.05);
        let law = Yeoh { c10, c20, c30: 0.0, volumetric: U }.into();
        let slope = |l: f64| {
            let (sum, difference) = (l * l + 1.0 / (l * l), l * l - 1.0 / (l * l));
            4.0 * (c10 + 2.0 * c20 * (sum - 2.0)) * sum + 8.0 * c20 * difference * difference
        };
        let planar = (100..400).map(|i| 0.01 * f64::from(i)).find(|l| slope(*l) <= 0.0).unwrap();
        let found = first_instability(&law, [0.25, 4.0]).unwrap();
        // Equibiaxial tension loses stability first, at a strain between these bounds.
        assert!(
            found.stretch.ln().abs() <= planar.ln() && found.stretch.ln().abs() > 0.4 * planar.ln(),
            "{found:?} {planar}"
        );
        let in_planar_only = (1..=STATES)
            .map(|i| f64::from(i) / f64::from(STATES) * 4f64.ln())
            .find(|e| !is_stable(&law, [*e, 0.0, -e]));
        assert!((in_planar_only.unwrap() - planar.ln()).abs() < 0.03, "{in_planar_only:?} {}", planar.ln());
    }
}
