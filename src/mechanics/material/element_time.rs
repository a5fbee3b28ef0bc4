//! What elements of a law cost, from a fixed table and never from a stopwatch, so that a scene always gets the same plan.
//!
//! Measured on one core of a virtual Intel Xeon (Sapphire Rapids family, AVX-512) with `cargo bench --bench element_kernels`.

/// Time of one element-step on one core [ns]: while the data of the elements lie in the cache, and when they do not.
pub type Nanoseconds = [f64; 2];

/// Time of an element-step in each formulation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ElementTime {
    /// Of mean dilatation.
    pub mean_dilatation: Nanoseconds,
    /// Of full integration.
    pub full: Nanoseconds,
    /// Of one point, stabilised.
    pub reduced: Nanoseconds,
    /// Of each family of fibres, on top.
    pub family: Nanoseconds,
}

impl ElementTime {
    /// Of the neo-Hookean law, and of each family of Holzapfel–Gasser–Ogden on top of that.
    pub const NEO_HOOKEAN: Self = Self {
        mean_dilatation: [167.0, 233.0],
        full: [196.0, 256.0],
        reduced: [83.0, 157.0],
        family: [48.0, 31.0],
    };

    /// Of a law that takes `extra` [ns] longer than the neo-Hookean one at each of its points: estimated from its operations, not
    /// measured.
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
