//! A law with internal variables, for tests: a coupled neo-Hookean solid whose volume change meets a Maxwell element.

use super::*;

/// ψ of [`CoupledNeoHookean`] and `½ K e²`, e the elastic part of J − 1 in the Maxwell element: ė = J̇ − e/τ.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ViscousVolume {
    /// The elastic response.
    pub elastic: CoupledNeoHookean,
    /// Bulk modulus K of the Maxwell element [Pa].
    pub modulus: f64,
    /// Its relaxation time τ [s].
    pub time: f64,
}

impl Law for ViscousVolume {
    const NAME: &'static str = "viscous volume";
    const FITTED: Deformations = CoupledNeoHookean::FITTED;

    fn eval_with_bounds<R: Real>(
        &self,
        k: &Kinematics<R>,
        inv: &Invariants<R>,
        fibres: &[[R; 3]],
    ) -> BoundedResponse<R> {
        self.elastic.eval_with_bounds(k, inv, fibres)
    }
    /// J − 1 and e.
    fn history_len(&self) -> usize {
        2
    }
    /// Exact where J changes at a constant rate: `S = K e J C⁻¹`.
    fn update<R: Real>(
        &self,
        h: f64,
        elastic: &ElasticPoint<R>,
        _fibres: &[[R; 3]],
        history: &mut impl History<R>,
    ) -> Overstress<R> {
        let (k, x) = (elastic.k, h / self.time);
        let gain = if x > 0.0 { -(-x).exp_m1() / x } else { 0.0 };
        let e = history.before(1) * (-x).exp() + (k.j - history.before(0)) * gain;
        history.set(0, k.j);
        history.set(1, e);
        let (p, cof_C) = (e * self.modulus, k.dev_cof_C.plus_diagonal(k.mean_cof_C));
        let invariants = Invariants::new(k);
        Overstress {
            S: cof_C.scaled(p * k.J_inverse),
            stored: p * e * 0.5,
            stiffness: invariants.I2 * self.modulus + p.abs() * invariants.max_C.sqrt() * 2.0,
        }
    }
    fn volumetric(&self) -> Option<Volumetric> {
        self.elastic.volumetric()
    }
    fn moduli_at_rest(&self) -> (f64, f64) {
        self.elastic.moduli_at_rest()
    }
    fn with_isochoric_scaled(self, _factor: f64) -> Option<Self> {
        None
    }
}
