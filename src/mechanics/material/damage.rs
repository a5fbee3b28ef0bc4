//! Softening beyond a strain energy: damage with a fracture energy (Simo 1987; Oliver 1989).
//!
//! ```text
//! S_iso = (1 − d) S°_iso        τ(t) = max over time of √(2 ψ°)        1 − d = τ₀/τ e^(−(τ − τ₀)/τ_s)   for τ > τ₀
//! ```
//!
//! with ψ° and S° of the material without damage. U(J) and its pressure are degraded likewise, and part of ψ°, where J > 1: a fully damaged
//! volume bears pressure, but no tension. With relaxation ψ° is the energy of slow loading, and the stress that relaxes is
//! reduced by the same factor. Stretched to failure, a volume dissipates `∫ψ° dd = ½ τ₀² +
//! τ₀ τ_s`, whatever its law. An element of size L dissipates the fracture energy G_c per area of a crack across it if that is
//! G_c/L: `τ_s = G_c/(L τ₀) − ½ τ₀`, so that the fracture energy does not depend on the mesh. It must be positive: an element
//! larger than `2 G_c/τ₀² = G_c/ψ₀` would store more energy at the onset than its fracture dissipates. There the onset is lower
//! (Bažant & Oh 1983), so that the fracture energy stays. L is the edge of a cube of the same volume: an element of height h across the
//! crack dissipates h/L times G_c.

use super::memory::{ElasticPoint, History, Inelastic, Memory};
use crate::real::Real;

/// Least τ_s over τ₀ [-].
const LEAST_SLOPE: f64 = 0.01;
/// Residual fraction of the stress at full damage [-], so that a fully damaged element keeps its shape.
pub const RESIDUAL: f64 = 1e-3;

/// Softening of the isochoric stress.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Softening {
    /// Strain energy ψ° at the onset [J/m³]; infinite without softening.
    pub onset: f64,
    /// Fracture energy G_c [J/m²].
    pub fracture_energy: f64,
}

impl Softening {
    /// Size [m] of elements above which they soften at a lower strain energy.
    pub fn largest_size(&self) -> f64 {
        self.fracture_energy / (self.onset * (1.0 + 2.0 * LEAST_SLOPE))
    }
}

impl Memory for Softening {
    type Step = ();
    const NONE: Self = Self { onset: f64::INFINITY, fracture_energy: 0.0 };

    /// The largest ψ° so far.
    fn title(&self) -> String {
        "softening".into()
    }
    fn history_len(&self) -> usize {
        usize::from(self.onset.is_finite())
    }
    fn softens(&self) -> bool {
        self.history_len() > 0
    }
    fn step(&self, _: f64) {}

    #[inline(always)]
    fn update<R: Real>(
        &self,
        (): &(),
        elastic: &ElasticPoint<R>,
        history: &mut impl History<R>,
        to: &mut Inelastic<R>,
    ) {
        let before = history.before(0);
        let largest = before.max(elastic.psi + elastic.tension);
        history.set(0, largest);
        let tear = self.tear(elastic.size);
        let (damage, dissipated) = tear.at(largest);
        to.dissipated = dissipated - tear.at(before).1;
        to.damage = damage;

        // Stress that relaxes is lost with the rest.
        let kept = -damage + 1.0;
        to.S = to.S.scaled(kept);
        to.stored = to.stored * kept;
    }
}

/// The softening of an element of one size.
struct Tear<R> {
    /// Energy at the onset ψ₀ [J/m³].
    onset: R,
    /// Ratio of τ_s to τ₀ [-].
    slope: R,
}

impl Softening {
    /// Onset and slope of the damage curve for elements of a size [m].
    #[inline(always)]
    fn tear<R: Real>(&self, size: R) -> Tear<R> {
        let per_volume = size.constant(self.fracture_energy) / size;
        let onset = (per_volume * (1.0 / (1.0 + 2.0 * LEAST_SLOPE))).min(size.constant(self.onset));
        Tear { onset, slope: per_volume * 0.5 / onset - 0.5 }
    }
}

impl<R: Real> Tear<R> {
    /// Damage [-], and dissipated energy [J/m³], where ψ° was at most `largest` [J/m³]: with x = τ/τ₀, s = τ_s/τ₀ and
    /// e = e^(−(x − 1)/s), `d = 1 − e/x` and `∫ψ° dd = ψ₀ (1 + 2 s (1 − e) − x e)`, both times 1 − [`RESIDUAL`].
    #[inline(always)]
    fn at(&self, largest: R) -> (R, R) {
        let one = largest.constant(1.0);
        let x = (largest / self.onset).max(one).sqrt();
        // 1 − e, which is accurate near the onset.
        let fallen = -((one - x) / self.slope).exp_m1();
        let remaining = one - fallen;
        let damage = one - remaining / x;
        let work = (self.slope * 2.0).mul_add(fallen, one) - x * remaining;
        (damage * (1.0 - RESIDUAL), work * self.onset * (1.0 - RESIDUAL))
    }
}

#[cfg(test)]
mod tests;
