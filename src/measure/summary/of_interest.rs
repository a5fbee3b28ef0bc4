//! Quantities of interest: the numbers of the summary that every output shows, and whose error is studied.

use super::quantity::Quantity;
use super::results::Results;
use super::written::short;
use crate::scene::document::RequestedNumber;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::fmt;

/// A result of the summary whose convergence can be studied.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum QuantityOfInterest {
    /// Largest mean force over the window [N].
    PeakForceN,
    /// Impulse of the contact [N s].
    #[serde(rename = "impulse_n_s")]
    ImpulseNS,
    /// Energy given to the tissue by the impact [J].
    EnergyGivenJ,
    /// Energy absorbed by the tissue at the end [J].
    AbsorbedEnergyJ,
    /// Largest area of the contact patch [mm²].
    LargestPatchAreaMm2,
    /// Area of the contact patch at the peak force [mm²].
    PatchAreaMm2,
    /// Depth of von Mises stress above the first threshold [mm].
    StressDepthMm,
    /// Largest principal Green–Lagrange strain at a point [-].
    PrincipalStrain,
    /// Principal Green–Lagrange strain exceeded in the volume that the scene sets [-].
    PrincipalStrainInVolume,
    /// Largest displacement of a node of the tissue's surface [mm].
    DeflectionMm,
}

/// Title and unit of a number.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct QuantityTitle {
    /// Human-readable name, with its threshold.
    pub title: String,
    /// Unit of the number; "-" for none.
    pub unit: &'static str,
}

impl QuantityOfInterest {
    /// All quantities of interest.
    pub const ALL: [Self; 10] = [
        Self::PeakForceN,
        Self::ImpulseNS,
        Self::EnergyGivenJ,
        Self::AbsorbedEnergyJ,
        Self::LargestPatchAreaMm2,
        Self::PatchAreaMm2,
        Self::StressDepthMm,
        Self::PrincipalStrain,
        Self::PrincipalStrainInVolume,
        Self::DeflectionMm,
    ];

    /// The numbers that stand first in every answer.
    pub const HEADLINE: [Self; 4] =
        [Self::PeakForceN, Self::LargestPatchAreaMm2, Self::StressDepthMm, Self::EnergyGivenJ];

    /// Name in documents, title, title in tables, and unit.
    fn words(self) -> [&'static str; 4] {
        match self {
            Self::PeakForceN => ["peak_force_n", "peak force", "peak force", "N"],
            Self::ImpulseNS => ["impulse_n_s", "impulse", "impulse", "N s"],
            Self::EnergyGivenJ => ["energy_given_j", "energy given to the tissue", "energy given", "J"],
            Self::AbsorbedEnergyJ => ["absorbed_energy_j", "absorbed energy", "absorbed energy", "J"],
            Self::LargestPatchAreaMm2 => {
                ["largest_patch_area_mm2", "largest contact patch", "largest patch", "mm²"]
            }
            Self::PatchAreaMm2 => {
                ["patch_area_mm2", "contact patch at the peak force", "patch at the peak force", "mm²"]
            }
            Self::StressDepthMm => ["stress_depth_mm", "depth of stress", "depth of stress", "mm"],
            Self::PrincipalStrain => ["principal_strain", "peak principal strain", "principal strain", "-"],
            Self::PrincipalStrainInVolume => [
                "principal_strain_in_volume",
                "principal strain exceeded in a volume",
                "principal strain in volume",
                "-",
            ],
            Self::DeflectionMm => ["deflection_mm", "deflection of the surface", "deflection", "mm"],
        }
    }

    /// Name in documents, with the unit.
    pub fn name(self) -> &'static str {
        self.words()[0]
    }

    /// Human-readable name.
    pub fn title(self) -> &'static str {
        self.words()[1]
    }

    /// Human-readable name for the head of a column.
    pub fn short_title(self) -> &'static str {
        self.words()[2]
    }

    /// Unit of the number; "-" for none.
    pub fn unit(self) -> &'static str {
        self.words()[3]
    }

    /// Titles and units of all, by their names; `threshold` is that of the depth of stress [Pa].
    pub fn titles(threshold: Option<f64>) -> BTreeMap<Self, QuantityTitle> {
        let of = |quantity: Self| {
            let title = quantity.short_title();
            let title = match (quantity, threshold) {
                (Self::StressDepthMm, Some(threshold)) => {
                    format!("{title} above {} kPa", short(1e-3 * threshold))
                }
                _ => title.to_owned(),
            };
            (quantity, QuantityTitle { title, unit: quantity.unit() })
        };
        Self::ALL.into_iter().map(of).collect()
    }

    /// The quantity with a name.
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|quantity| quantity.name() == name)
    }

    /// Value in the results, for the headline contact; `None` if the scene has none.
    pub fn of(self, results: &Results) -> Option<f64> {
        self.number(results).map(|number| number.value)
    }

    /// As [`Self::of`], with the error bar.
    pub fn number(self, results: &Results) -> Option<&Quantity> {
        let impact = results.headline_impact();
        let tissue = results.tissue.as_ref();
        match self {
            Self::PeakForceN => impact.map(|i| &i.peak_force_n),
            Self::ImpulseNS => impact.map(|i| &i.impulse_n_s),
            Self::LargestPatchAreaMm2 => impact.map(|i| &i.largest_patch_area_mm2),
            Self::PatchAreaMm2 => impact.map(|i| &i.patch_area_mm2),
            Self::EnergyGivenJ => tissue.map(|t| &t.energy_given_j),
            Self::AbsorbedEnergyJ => tissue.map(|t| &t.absorbed_energy_j),
            Self::StressDepthMm => tissue.and_then(|t| {
                t.significant_stress.get(results.headline.significant_stress?)?.depth_mm.as_ref()
            }),
            Self::PrincipalStrain => {
                tissue.and_then(|t| Some(&t.peaks.peak_principal_strain.as_ref()?.quantity))
            }
            Self::PrincipalStrainInVolume => {
                tissue.and_then(|t| Some(&t.exceeded_in_volume.as_ref()?.principal_strain.quantity))
            }
            Self::DeflectionMm => tissue.map(|t| &t.deflection_mm.quantity),
        }
    }
}

impl From<RequestedNumber> for QuantityOfInterest {
    fn from(number: RequestedNumber) -> Self {
        match number {
            RequestedNumber::PeakForce => Self::PeakForceN,
            RequestedNumber::Impulse => Self::ImpulseNS,
            RequestedNumber::ContactPatch => Self::LargestPatchAreaMm2,
            RequestedNumber::StressDepth => Self::StressDepthMm,
            RequestedNumber::EnergyGiven => Self::EnergyGivenJ,
            RequestedNumber::Deflection => Self::DeflectionMm,
        }
    }
}

impl fmt::Display for QuantityOfInterest {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_those_of_the_documents() {
        for quantity in QuantityOfInterest::ALL {
            assert_eq!(serde_json::to_value(quantity).unwrap(), quantity.name());
            assert_eq!(QuantityOfInterest::from_name(quantity.name()), Some(quantity));
        }
    }
}
