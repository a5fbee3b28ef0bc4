//! Limit and order of convergence of a sequence of meshes, and their uncertainty (Roache 1994; Celik et al. 2008).

use serde::Serialize;

/// Ratio of element sizes, and of time steps, from one run to the next finer one.
pub const REFINEMENT: f64 = 2.0;
/// Assumed order of convergence if none is observed: impacts converge at first order.
const ASSUMED_ORDER: f64 = 1.0;
/// Factor of safety on an error of assumed order (Roache 1994).
const SAFETY_ASSUMED: f64 = 3.0;
/// Credible observed orders: below, the sequence hardly converges; above, two of its members are close by chance.
const BELIEVED: std::ops::RangeInclusive<f64> = 0.5..=2.5;
/// Factor of safety on an error of observed order (Roache 1994).
const SAFETY_OBSERVED: f64 = 1.25;
/// Factor on a [`fitted_uncertainty`] where it is not known that the sequence has begun to converge, as while few nodes lie across a contact: the
/// factor of safety is that of an assumed order then.
pub const PRE_ASYMPTOTIC: f64 = SAFETY_ASSUMED / SAFETY_OBSERVED;
/// Orders that a sequence of meshes is fitted with [-]: that of impacts, and lower ones where values approach their limit slower.
const FITTED_ORDERS: [f64; 3] = [1.0, 0.75, 0.5];

/// Orders whose limits bound that of the assumed order [-].
const OTHER_ORDERS: [f64; 2] = [0.75, 1.5];

/// Relative difference below which two values are equal: their underlying sums are no more accurate [-].
const ROUNDING: f64 = 1e-9;

/// Reference value against which errors are measured.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(tag = "kind", rename_all = "snake_case")]
pub enum Reference {
    /// Exact solution, known from elsewhere.
    Exact {
        /// Exact value of the quantity.
        value: f64,
    },
    /// Value of another code, with its uncertainty.
    Given {
        /// Value of the other code, in the unit of the quantity.
        value: f64,
        /// Half-width of its uncertainty, in the same unit.
        uncertainty: f64,
    },
    /// Limit of the meshes (Richardson extrapolation).
    Extrapolated {
        /// Extrapolated value for vanishing element size.
        value: f64,
        /// Observed order of convergence.
        order: f64,
        /// Uncertainty of the value: the grid convergence index of the finest mesh.
        uncertainty: f64,
    },
    /// Limit of a line fitted to four meshes or more.
    Fitted {
        /// Value of the line for vanishing element size.
        value: f64,
        /// Number of meshes.
        meshes: usize,
        /// Uncertainty of the value: its distance from the limits of other orders, and the scatter about the line.
        uncertainty: f64,
    },
    /// The finest mesh itself, if the sequence allows no extrapolation.
    Finest {
        /// Value on the finest mesh.
        value: f64,
        /// Uncertainty: three times the largest difference of the last meshes, at an assumed first order.
        uncertainty: f64,
        /// Why no extrapolation was possible.
        reason: String,
    },
    /// No reference: nothing to compare with.
    Unknown {
        /// Value on the only mesh.
        value: f64,
        /// Why there is no reference.
        reason: String,
    },
}

impl Reference {
    /// The reference value, whichever kind it is.
    pub fn value(&self) -> f64 {
        match self {
            Self::Exact { value }
            | Self::Given { value, .. }
            | Self::Extrapolated { value, .. }
            | Self::Fitted { value, .. }
            | Self::Finest { value, .. }
            | Self::Unknown { value, .. } => *value,
        }
    }
    /// Whether errors can be measured against it.
    pub fn is_known(&self) -> bool {
        !matches!(self, Self::Unknown { .. })
    }
    /// Uncertainty of the reference; infinite if unknown.
    pub fn uncertainty(&self) -> f64 {
        match self {
            Self::Exact { .. } => 0.0,
            Self::Given { uncertainty, .. }
            | Self::Extrapolated { uncertainty, .. }
            | Self::Fitted { uncertainty, .. }
            | Self::Finest { uncertainty, .. } => *uncertainty,
            Self::Unknown { .. } => f64::INFINITY,
        }
    }
}

/// Error of a value from another one at an assumed first order, with a factor of safety of three. `ratio` is the element
/// size of the other in units of the own one: above one it is the coarser mesh, below one the finer, which gives the grid
/// convergence index of a coarse mesh (Roache 1994).
pub fn assumed_error(other: f64, own: f64, ratio: f64) -> f64 {
    SAFETY_ASSUMED * (own - other).abs() / (ratio.powf(ASSUMED_ORDER) - 1.0).abs()
}

/// Time-step error of a run with `own` steps, from two others that differ only in their numbers of steps, at an assumed
/// first order with a factor of safety of three. Infinite if both have the same number of steps.
pub fn assumed_step_error(own: u64, (few, many): (u64, u64), (value, better): (f64, f64)) -> f64 {
    let step = |count: u64| (1.0 / count as f64).powf(ASSUMED_ORDER);
    SAFETY_ASSUMED * (better - value).abs() * step(own) / (step(few) - step(many)).abs()
}

/// Uncertainty of the last of at least three values on meshes of sizes h, from coarse to fine: `(h, value)`.
///
/// A curve φ₀ + a hᵖ is fitted by least squares with weights 1/h (L. Eça, M. Hoekstra, J. Comput. Phys. 262 (2014) 104–130), with the
/// order p of 1, ¾ or ½ that leaves the least scatter. Where the scatter is below the mean difference of successive values,
/// σ < Δφ, the uncertainty is `1.25 |a hᵖ| + σ + |φ − φ_fit|`; else a factor of 3 replaces 1.25, and σ/Δφ multiplies the sum. Values
/// that scatter so are not extrapolated farther than their differences allow: by three times the largest of them for meshes of up to twice
/// the size, in proportion to 1/(h − 1) beyond, which covers the error of orders from ½ on.
pub fn fitted_uncertainty(levels: &[(f64, f64)]) -> f64 {
    let Some((finest, value)) = levels.last().copied() else { return f64::INFINITY };
    let Some(fit) = Fit::best(levels) else { return f64::INFINITY };
    let spread = spread(levels);
    if spread == 0.0 {
        return 0.0;
    }
    let (of_curve, off_curve) = fit.errors((finest, value));
    if fit.scatter < spread {
        return SAFETY_OBSERVED * of_curve + off_curve;
    }
    let allowed =
        |(h, phi): &(f64, f64)| SAFETY_ASSUMED * (phi - value).abs() / f64::max(h / finest - 1.0, 1.0);
    let most = levels.iter().map(allowed).fold(0.0, f64::max);
    (SAFETY_ASSUMED * fit.scatter / spread * (of_curve + off_curve)).min(most)
}

/// Limit of at least four values on meshes of sizes h, from coarse to fine: `(h, value)`. Impacts converge at first order, so it is that
/// of the line φ₀ + a h with weights 1/h, uncertain by the distance to the limits of the orders ¾ and 1½ and by the scatter about the
/// line. Where that exceeds the mean difference of successive values, it is the last value, with its [`fitted_uncertainty`].
pub fn fitted_limit(levels: &[(f64, f64)]) -> Option<Reference> {
    let finest = levels.last()?.1;
    let line = Fit::new(levels, ASSUMED_ORDER);
    if line.scatter > spread(levels) {
        let reason = "the values scatter about their line by more than they differ from mesh to mesh".into();
        return Some(Reference::Finest { value: finest, uncertainty: fitted_uncertainty(levels), reason });
    }
    let off = OTHER_ORDERS.map(|order| (Fit::new(levels, order).limit - line.limit).abs());
    let uncertainty = off.into_iter().fold(0.0, f64::max) + line.scatter;
    Some(Reference::Fitted { value: line.limit, meshes: levels.len(), uncertainty })
}

/// Mean difference of successive values.
fn spread(levels: &[(f64, f64)]) -> f64 {
    let values = levels.iter().map(|(_, phi)| *phi);
    (values.clone().fold(f64::NEG_INFINITY, f64::max) - values.fold(f64::INFINITY, f64::min))
        / (levels.len() as f64 - 1.0)
}

/// The curve φ₀ + a hᵖ of a given order p through values on meshes of the sizes h, by least squares with weights 1/h.
struct Fit {
    order: f64,
    slope: f64,
    limit: f64,
    /// Standard deviation of the values from the curve.
    scatter: f64,
}

impl Fit {
    /// The one with the least scatter.
    fn best(levels: &[(f64, f64)]) -> Option<Self> {
        let fits = FITTED_ORDERS.map(|order| Self::new(levels, order)).into_iter();
        fits.reduce(|best, next| if next.scatter < best.scatter { next } else { best })
    }

    /// What the curve leaves of the error of a mesh and its value, and how far values are from the curve.
    fn errors(&self, (h, value): (f64, f64)) -> (f64, f64) {
        ((self.slope * h.powf(self.order)).abs(), self.scatter + (value - self.at(h)).abs())
    }

    fn new(levels: &[(f64, f64)], order: f64) -> Self {
        let weight_sum: f64 = levels.iter().map(|(h, _)| h.recip()).sum();
        let mean = |of: &dyn Fn(f64, f64) -> f64| -> f64 {
            levels.iter().map(|&(h, phi)| of(h.powf(order), phi) / (h * weight_sum)).sum()
        };
        let (mean_h, mean_phi) = (mean(&|h, _| h), mean(&|_, phi| phi));
        let slope = mean(&|h, phi| (h - mean_h) * (phi - mean_phi)) / mean(&|h, _| (h - mean_h).powi(2));
        let limit = mean_phi - slope * mean_h;
        let count = levels.len() as f64;
        let variance = mean(&|h, phi| (phi - limit - slope * h).powi(2)) * count / (count - 2.0);
        Self { order, slope, limit, scatter: variance.sqrt() }
    }

    fn at(&self, h: f64) -> f64 {
        self.limit + self.slope * h.powf(self.order)
    }
}

/// Reference of values on meshes from coarse to fine, each finer by [`REFINEMENT`]; `None` without values.
pub fn extrapolate(values: &[f64]) -> Option<Reference> {
    let finest = *values.last()?;
    let unknown = |uncertainty: f64, reason: &str| {
        Some(Reference::Finest { value: finest, uncertainty, reason: reason.into() })
    };
    let [.., coarse, middle, fine] = *values else {
        return match *values {
            [coarse, fine] => {
                unknown(assumed_error(coarse, fine, REFINEMENT), "only two meshes: order 1 is assumed")
            }
            _ => Some(Reference::Unknown { value: finest, reason: "there is only one mesh".into() }),
        };
    };
    let (before, after) = (middle - coarse, fine - middle);
    let spread = assumed_error(coarse, middle, REFINEMENT).max(assumed_error(middle, fine, REFINEMENT));
    if are_equal(coarse, middle) && are_equal(middle, fine) {
        return unknown(spread, "the meshes give the same value");
    }
    if !(before * after > 0.0) {
        return unknown(spread, "the values do not approach their limit from one side");
    }
    let order = observed_order(coarse, middle, fine);
    if !BELIEVED.contains(&order) {
        let reason = format!("the observed order {order:.2} is outside {BELIEVED:?}");
        return unknown(spread, &reason);
    }
    let step = after / (REFINEMENT.powf(order) - 1.0);
    Some(Reference::Extrapolated { value: fine + step, order, uncertainty: SAFETY_OBSERVED * step.abs() })
}

/// Whether two values differ by rounding only.
pub fn are_equal(a: f64, b: f64) -> bool {
    (a - b).abs() <= ROUNDING * a.abs().max(b.abs())
}

/// Observed order of three values, each mesh finer by [`REFINEMENT`]; NaN unless they converge monotonically.
pub fn observed_order(coarse: f64, middle: f64, fine: f64) -> f64 {
    ((middle - coarse) / (fine - middle)).ln() / REFINEMENT.ln()
}

#[cfg(test)]
#[allow(clippy::float_cmp)] // these values are exact
mod tests {
    use super::*;

    /// 2 + h^p on meshes h = 1, 1/2, 1/4, …
    fn sequence(order: f64) -> Vec<f64> {
        (0..4).map(|level| 2.0 + 0.5_f64.powi(level).powf(order)).collect()
    }

    #[test]
    fn limit_and_order_of_a_pure_power_are_found() {
        for p in [0.7, 1.0, 2.0] {
            let Some(Reference::Extrapolated { value, order, uncertainty }) = extrapolate(&sequence(p))
            else {
                panic!("order {p} is not credible")
            };
            assert!((value - 2.0).abs() < 1e-12 && (order - p).abs() < 1e-12, "{value} {order}");
            assert!(uncertainty > (sequence(p)[3] - 2.0).abs(), "{uncertainty}");
        }
    }

    #[test]
    fn what_does_not_converge_is_not_extrapolated() {
        for (values, uncertainty) in [
            (vec![1.0, 2.0, 1.5], 3.0),
            (vec![1.0, 2.0, 3.0], 3.0),
            (vec![1.0, 2.0, 2.01], 3.0),
            (vec![1.0, 2.0], 3.0),
        ] {
            let found = extrapolate(&values);
            let Some(Reference::Finest { value, uncertainty: found, .. }) = found else {
                panic!("{found:?}")
            };
            assert!((value - values.last().unwrap()).abs() < 1e-15 && (found - uncertainty).abs() < 1e-12);
        }
        assert!(extrapolate(&[1.0]).is_some_and(|r| r.uncertainty().is_infinite()));
        assert_eq!(extrapolate(&[]), None);
    }

    #[test]
    fn a_fitted_uncertainty_holds_the_error_of_smooth_sequences_and_grows_with_scatter() {
        let levels = |order: f64, noise: [f64; 3]| -> Vec<(f64, f64)> {
            [2.0, 1.41, 1.0]
                .into_iter()
                .zip(noise)
                .map(|(h, e): (f64, f64)| (h, 5.0 + 0.1 * h.powf(order) + e))
                .collect()
        };
        let smooth = fitted_uncertainty(&levels(1.0, [0.0; 3]));
        assert!((smooth - 1.25 * 0.1).abs() < 1e-12, "{smooth}");
        for order in [0.7, 1.5, 2.0] {
            let found = fitted_uncertainty(&levels(order, [0.0; 3]));
            assert!(found > 0.1 && found < 0.5, "order {order}: {found}");
        }
        let scattered = fitted_uncertainty(&levels(1.0, [0.05, -0.05, 0.05]));
        assert!(scattered > 2.0 * smooth, "{scattered}");
        assert_eq!(fitted_uncertainty(&[(2.0, 3.0), (1.5, 3.0), (1.0, 3.0)]), 0.0);
        assert_eq!(fitted_uncertainty(&[]), f64::INFINITY);
    }

    #[test]
    fn a_fitted_limit_holds_the_limit_of_orders_about_one() {
        let sizes = [4.0_f64, 2.83, 2.0, 1.41, 1.0];
        for order in [0.75, 1.0, 1.5] {
            let levels: Vec<(f64, f64)> = sizes.iter().map(|h| (*h, 5.0 + 0.1 * h.powf(order))).collect();
            let Some(Reference::Fitted { value, meshes: 5, uncertainty }) = fitted_limit(&levels) else {
                panic!("order {order} is not fitted")
            };
            assert!(
                (value - 5.0).abs() <= uncertainty && uncertainty < 0.2,
                "{order}: {value} ± {uncertainty}"
            );
        }
        // No line: the finest mesh, with an uncertainty that holds the others.
        let scattered = fitted_limit(&[(4.0, 5.0), (2.0, 6.0), (1.41, 5.0), (1.0, 6.0)]);
        assert!(
            matches!(scattered, Some(Reference::Finest { value, uncertainty, .. }) if value == 6.0 && uncertainty >= 1.0),
            "{scattered:?}"
        );
        assert_eq!(fitted_limit(&[]), None);
    }

    #[test]
    fn errors_of_steps_are_those_of_the_run_itself() {
        // value = 2 + 1/steps: a run of 400 steps has an error of 1/400, estimated from runs of 100 and 200.
        let error = |own| assumed_step_error(own, (100, 200), (2.01, 2.005));
        assert!((error(400) - 3.0 / 400.0).abs() < 1e-12 && (error(100) - 3.0 / 100.0).abs() < 1e-12);
    }

    #[test]
    fn equal_values_have_no_error() {
        assert!(extrapolate(&[3.0, 3.0, 3.0]).is_some_and(|r| r.uncertainty() == 0.0));
        let found = extrapolate(&[1e6, 999_999.999_999_999_9, 1e6]);
        let Some(Reference::Finest { uncertainty, reason, .. }) = found else { panic!("{found:?}") };
        assert!(uncertainty < 1e-8 && reason == "the meshes give the same value", "{uncertainty}: {reason}");
    }
}
