//! Cost of elements of each law, from a fixed table and never from a stopwatch, so that a scene always gets the same
//! plan.
//!
//! Measured on one core of a virtual Intel Xeon (Sapphire Rapids family, AVX-512) with `cargo bench --bench element_kernels`.

/// Time of one element-step on one core [ns]: with the data of the elements in the cache, and in main memory.
pub type Nanoseconds = [f64; 2];

/// Time of one element-step in each formulation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ElementTime {
    /// With mean dilatation, at 2×2×2 points.
    pub mean_dilatation: Nanoseconds,
    /// With full integration, at 2×2×2 points.
    pub full: Nanoseconds,
    /// With one point and stabilisation.
    pub reduced: Nanoseconds,
    /// Additional time per fibre family.
    pub family: Nanoseconds,
}

impl ElementTime {
    /// Times of the neo-Hookean law; `family` is that of Holzapfel–Gasser–Ogden.
    pub const NEO_HOOKEAN: Self = Self {
        mean_dilatation: [167.0, 233.0],
        full: [196.0, 256.0],
        reduced: [83.0, 157.0],
        family: [48.0, 31.0],
    };

    /// Times of a law that takes `extra` [ns] longer than the neo-Hookean one at each integration point: estimated from its
    /// operations, not measured.
    pub const fn neo_hookean_and(extra: f64) -> Self {
        let base = Self::NEO_HOOKEAN;
        Self {
            mean_dilatation: [base.mean_dilatation[0] + 8.0 * extra, base.mean_dilatation[1] + 8.0 * extra],
            full: [base.full[0] + 8.0 * extra, base.full[1] + 8.0 * extra],
            reduced: [base.reduced[0] + extra, base.reduced[1] + extra],
            family: base.family,
        }
    }
}
