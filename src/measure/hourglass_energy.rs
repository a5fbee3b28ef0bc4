//! Fraction of the strain energy in the stabilisation (hourglass modes of one-point elements, crushed corners of
//! others): deformation that the mesh does not resolve.

use crate::step::Energy;

/// Fraction above which a warning is issued, the customary limit.
pub const HOURGLASS_WARNING: f64 = 0.05;

/// A body whose strain energy never exceeds this fraction of the energy scale counts as being at rest.
const NEGLIGIBLE: f64 = 1e-6;

/// Peaks so far, because a fraction at one time is meaningless while a body is nearly at rest.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct HourglassEnergy {
    /// Largest energy of the stabilisation and largest strain energy of each body [J].
    peaks: Vec<[f64; 2]>,
    /// Strain energy below which a body counts as being at rest [J].
    floor: f64,
}

impl HourglassEnergy {
    /// Accumulates the ledger of one step; `rounding` is the energy that rounding alone may produce [J].
    pub fn accumulate(&mut self, energy: &Energy, rounding: f64) {
        self.floor = rounding.max(NEGLIGIBLE * energy.scale_j);
        self.peaks.resize(energy.bodies.len(), [0.0; 2]);
        for (peak, body) in self.peaks.iter_mut().zip(&energy.bodies) {
            *peak = [peak[0].max(body.hourglass_j), peak[1].max(body.strain_j)];
        }
    }

    /// Peak energy of the stabilisation over peak strain energy of each body [-]; 0 if it hardly strains.
    pub fn fractions(&self) -> impl Iterator<Item = f64> {
        let fraction =
            |[hourglass, strain]: &[f64; 2]| if *strain > self.floor { hourglass / strain } else { 0.0 };
        self.peaks.iter().map(fraction)
    }

    /// Largest fraction over all bodies [-].
    pub fn largest_fraction(&self) -> f64 {
        self.fractions().fold(0.0, f64::max)
    }
}

#[cfg(test)]
#[allow(clippy::float_cmp)] // these values are exact
mod tests {
    use super::*;
    use crate::step::BodyEnergy;

    #[test]
    fn the_fraction_is_that_of_the_peaks_of_each_body() {
        let energy = |pairs: [[f64; 2]; 2]| Energy {
            bodies: pairs
                .map(|[hourglass_j, strain_j]| BodyEnergy { strain_j, hourglass_j, ..BodyEnergy::default() })
                .into(),
            ..Energy::default()
        };
        let mut measure = HourglassEnergy::default();
        assert_eq!(measure.largest_fraction(), 0.0);
        // Energies at the level of rounding do not count.
        measure.accumulate(&energy([[0.0, 0.0], [1e-20, 2e-20]]), 1e-19);
        assert_eq!(measure.largest_fraction(), 0.0);
        measure.accumulate(&energy([[0.0, 3.0], [0.5, 8.0]]), 1e-19);
        measure.accumulate(&energy([[0.0, 1.0], [0.25, 10.0]]), 1e-19);
        assert_eq!(measure.fractions().collect::<Vec<_>>(), [0.0, 0.05]);
        assert_eq!(measure.largest_fraction(), 0.05);
    }
}
