//! The laws over SIMD lanes against the same laws over scalars.

use super::*;
use crate::lanes::{BATCH, Lane, Row};
use pulp::{Arch, Simd, WithSimd};

/// ψ, P, the stiffness bound and the fibre exponent of a law at eight deformations.
struct LanesOfLaw<'a> {
    law: &'a Material,
    deformations: &'a [Mat3; BATCH],
}

/// Values compared for each deformation: 9 components of P, ψ, bound, exponent.
type Outcome = [Row; 12];

impl WithSimd for LanesOfLaw<'_> {
    type Output = Outcome;
    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> Outcome {
        let mut out = [Row::default(); 12];
        for part in 0..BATCH / S::F64_LANES {
            let H = Tensor::from_fn(|i, j| {
                let row = Row(std::array::from_fn(|lane| gradient(&self.deformations[lane]).0[i][j]));
                Lane::load(simd, &row, part)
            });
            let fibres: Vec<_> =
                self.law.fibre_directions().iter().map(|a| a.map(|x| Lane::splat(simd, x))).collect();
            let k = Kinematics::new(&H);
            let inv = Invariants::new(&k);
            let response = self.law.eval_total(&H, &fibres);
            for (i, row) in response.P.0.iter().enumerate() {
                for (j, p) in row.iter().enumerate() {
                    p.store(&mut out[3 * i + j], part);
                }
            }
            response.psi.store(&mut out[9], part);
            crate::material::with_law!(self.law, law => {
                let point = law.eval_with_bounds(&k, &inv, &fibres);
                point.stiffness_bound.store(&mut out[10], part);
                point.fibre_exponent.store(&mut out[11], part);
            });
        }
        out
    }
}

#[test]
fn lanes_give_what_plain_numbers_give() {
    let mut random = Random(10);
    for law in all_laws(40.0) {
        let fibres = law.fibre_directions();
        let mut deformations: [Mat3; BATCH] = std::array::from_fn(|_| random.deformation(0.5));
        // Neighbouring lanes at rest, and far beyond the exponent limit.
        deformations[2] = Mat3::identity();
        let far = if matches!(law, Material::Ogden(_)) {
            [5.0, 6.0, 1.0 / 24.0]
        } else {
            [30.0, 40.0, 1.0 / 900.0]
        };
        deformations[5] = Mat3::from_diagonal(&far.into());
        let plain = Arch::Scalar.dispatch(LanesOfLaw { law: &law, deformations: &deformations });
        let lanes = Arch::new().dispatch(LanesOfLaw { law: &law, deformations: &deformations });
        for lane in 0..BATCH {
            let F = &deformations[lane];
            let (psi, P) = eval(&law, F);
            for outcome in [&plain, &lanes] {
                let P_lane = Mat3::from_fn(|i, j| outcome[3 * i + j].0[lane]);
                assert!((P_lane - P).norm() <= 1e-11 * P.norm(), "{law:?}: {P_lane} against {P}");
                assert!(
                    (outcome[9].0[lane] - psi).abs() <= 1e-11 * psi,
                    "{law:?}: {} {psi}",
                    outcome[9].0[lane]
                );
                let k = Kinematics::new(&gradient(F));
                let inv = Invariants::new(&k);
                let (bound, exponent) = crate::material::with_law!(law, law => {
                    let point = law.eval_with_bounds(&k, &inv, fibres);
                    (point.stiffness_bound, point.fibre_exponent)
                });
                assert!((outcome[10].0[lane] - bound).abs() <= 1e-11 * bound, "{law:?}: {bound}");
                assert!((outcome[11].0[lane] - exponent).abs() <= 1e-12 * exponent, "{law:?}: {exponent}");
            }
        }
        let at_rest: Vec<f64> = lanes[..10].iter().map(|row| row.0[2]).collect();
        assert!(at_rest.iter().all(|x| *x == 0.0), "{law:?}: {at_rest:?}");
    }
}
