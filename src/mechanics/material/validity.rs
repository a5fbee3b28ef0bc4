//! Range of validity of a law: the deformations that its parameters are usually fitted to, and those beyond which it
//! is meaningless.

/// Ranges of principal stretches λ and volume ratio J [-].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Deformations {
    /// Least and largest principal stretch λ [-].
    pub stretch: [f64; 2],
    /// Least and largest volume ratio J [-].
    pub jacobian: [f64; 2],
}

impl Deformations {
    /// Factor [-] by which stretches and J exceed the range: at most 1 within.
    pub fn excess(&self, stretch: [f64; 2], jacobian: [f64; 2]) -> f64 {
        let beyond =
            |[least, most]: [f64; 2], [from, to]: [f64; 2]| f64::max(from / least.max(VANISHING), most / to);
        beyond(stretch, self.stretch).max(beyond(jacobian, self.jacobian))
    }
}

/// Least stretch or J that is distinguished from zero [-].
const VANISHING: f64 = 1e-9;

/// Which of the two ranges are given for a law.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Given {
    /// The range of principal stretches is given.
    pub stretch: bool,
    /// The range of the volume ratio is given.
    pub jacobian: bool,
}

/// Range of validity of a law.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Validity {
    /// Deformations that its parameters are fitted to.
    pub fitted: Deformations,
    /// Which of these were given for the parameters; the others are usual for the law.
    pub given: Given,
    /// Which of the limits were declared; the others are usual for such laws.
    pub declared: Given,
    /// Deformations beyond which its results are not those of an intact tissue.
    pub limit: Deformations,
    /// Strain rates of the tests that its parameters are fitted to, from … to [1/s]; `None` where no source gives them.
    pub strain_rate: Option<[f64; 2]>,
}

/// No limit of a stretch or volume ratio [-].
const NO_LIMIT: [f64; 2] = [0.0, f64::INFINITY];

/// Beyond a stretch of 4, or crushed to a tenth, no soft tissue or rubber of these laws is intact; with J below 0.1
/// the mesh has failed.
const LIMIT: Deformations = Deformations { stretch: [0.1, 4.0], jacobian: [0.1, 10.0] };

/// For nearly incompressible laws: a volume change by a tenth requires a tenth of the bulk modulus.
pub(super) const NEARLY_INCOMPRESSIBLE: [f64; 2] = [0.9, 1.1];

/// Soft tissue and rubber: one constant fits rubber in tension up to about 1.5, two up to about 2 (L. R. G. Treloar,
/// The Physics of Rubber Elasticity, ch. 5); soft tissue is seldom tested beyond 1.5.
pub(super) const TISSUE: Deformations = Deformations { stretch: [0.6, 1.5], jacobian: NEARLY_INCOMPRESSIBLE };

impl Validity {
    /// The limits that were given; those usual for such laws limit nothing here.
    pub fn declared_limit(&self) -> Deformations {
        Deformations {
            stretch: if self.declared.stretch { self.limit.stretch } else { NO_LIMIT },
            jacobian: if self.declared.jacobian { self.limit.jacobian } else { NO_LIMIT },
        }
    }
    /// Range of a law fitted to these, unless a scene specifies another.
    pub(super) fn fitted_to(fitted: Deformations) -> Self {
        Self { fitted, given: Given::default(), declared: Given::default(), limit: LIMIT, strain_rate: None }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_excess_is_one_at_the_edge_of_the_range() {
        let range = Deformations { stretch: [0.5, 2.0], jacobian: [0.9, 1.1] };
        let excess = |stretch, jacobian| range.excess(stretch, jacobian);
        assert!((excess([1.0, 2.0], [1.0; 2]) - 1.0).abs() < 1e-15);
        assert!((excess([0.25, 1.0], [1.0; 2]) - 2.0).abs() < 1e-15);
        assert!((excess([1.0; 2], [0.3, 1.0]) - 3.0).abs() < 1e-12);
        assert!(excess([0.8, 1.5], [0.95, 1.05]) < 1.0 && excess([0.0, 1.0], [1.0; 2]).is_finite());
    }
}
