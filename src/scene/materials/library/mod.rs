//! The library: named sets of material parameters from public sources, each with what it was fitted to and where it was read.
//!
//! One JSON file a family. A number that no source gives is marked as assumed or derived in its set; nothing else is in here.

use crate::mechanics::material::Material;
use crate::scene::materials::MaterialDocument;
use crate::scene::memories::{Moduli, PronyDocument};
use crate::scene::problem::{Pointer, Problem, suggest};
use serde::{Deserialize, Serialize};
use std::sync::LazyLock;

#[cfg(test)]
mod tests;

/// The families, each with its sets in the order in which they are listed.
const FAMILIES: [(&str, &str); 6] = [
    ("muscle", include_str!("muscle.json")),
    ("fat", include_str!("fat.json")),
    ("skin", include_str!("skin.json")),
    ("gelatine", include_str!("gelatine.json")),
    ("silicone", include_str!("silicone.json")),
    ("rubber", include_str!("rubber.json")),
];

/// A named set of material parameters.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "service", derive(utoipa::ToSchema))]
#[serde(deny_unknown_fields)]
pub struct MaterialSet {
    /// Name, `family/set`: what `"material": {"library": …}` of a part names.
    pub name: String,
    /// Material and test that the set represents.
    pub tissue: String,
    /// The law with its parameters, as a scene has it; `valid_to` in it is the range that is stated.
    #[cfg_attr(feature = "service", schema(value_type = Object))]
    pub material: MaterialDocument,
    /// Small-strain shear modulus of the law as the source gives it, or as it follows from the source's constants [Pa]; under slow
    /// loading, unless `prony_series` says that the moduli are instantaneous.
    pub shear_modulus_pa: f64,
    /// Density at rest [kg/m³].
    pub density_kg_per_m3: f64,
    /// Relaxation of the isochoric stress, as a scene has it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[cfg_attr(feature = "service", schema(value_type = Option<Object>))]
    pub prony_series: Option<PronyDocument>,
    /// Shear viscosity of the part [Pa s].
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub shear_viscosity_pa_s: Option<f64>,
    /// Where the density is from.
    pub density_from: String,
    /// Where the bulk modulus is from; a scene may give its own beside the name.
    pub bulk_modulus_from: String,
    /// Temperature of the test.
    pub temperature: String,
    /// Strains of the test.
    pub strain_range: String,
    /// Rates or frequencies of the test.
    pub rate_range: String,
    /// What was fitted to which data, and by whom.
    pub fitted: String,
    /// What is derived here from the source, and how.
    pub derived: String,
    /// Statements on which the sources disagree.
    pub contradictions: Vec<String>,
    /// By how much they disagree: the smallest and the largest value of a parameter among the sources that `contradictions` names.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub spread: Vec<SourceSpread>,
    /// Where it was read, the main source first.
    pub sources: Vec<SetSource>,
    /// The numbers that the constants were fitted to here, where they were.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub fit: Option<Fit>,
}

/// [`SourceSpread::parameter`] of the small-strain shear modulus of a set, under slow and under sudden loading.
pub const SHEAR_MODULUS: &str = "shear_modulus_pa";
/// See [`SHEAR_MODULUS`]: that of sets that relax, since in an impact sources differ by what they are before they do.
pub const SUDDEN_SHEAR_MODULUS: &str = "sudden_shear_modulus_pa";

/// Range of a parameter between sources.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "service", derive(utoipa::ToSchema))]
#[serde(deny_unknown_fields)]
pub struct SourceSpread {
    /// The parameter: `shear_modulus_pa`, `sudden_shear_modulus_pa` (before any relaxation), or its place in a part, such as `shear_viscosity_pa_s` or
    /// `prony_series/branches/0/relaxation_time_s`.
    pub parameter: String,
    /// Smallest value, in the unit of the parameter.
    pub least: f64,
    /// Largest value, in the unit of the parameter.
    pub most: f64,
    /// Whose values these are.
    pub from: String,
}

/// A source of a set.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "service", derive(utoipa::ToSchema))]
#[serde(deny_unknown_fields)]
pub struct SetSource {
    /// In a word or two.
    pub short: String,
    /// Authors, title, place, year.
    pub citation: String,
    /// Address (URL) of the source.
    pub url: String,
    /// Extent to which the source was read: full text, abstract, card, table.
    pub read: String,
}

/// A fit that is redone by the tests.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "service", derive(utoipa::ToSchema))]
#[serde(deny_unknown_fields)]
pub struct Fit {
    /// Kind of test: how the specimen was deformed.
    pub test: FitTest,
    /// Stretch [-] and nominal stress [Pa] of each point.
    pub points: Vec<[f64; 2]>,
    /// Largest error of the law relative to a point [-].
    pub relative_error: f64,
}

/// Kind of test of a fit.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "service", derive(utoipa::ToSchema))]
#[serde(rename_all = "snake_case")]
pub enum FitTest {
    /// Tension along one direction, the sides free of load.
    UniaxialTension,
}

/// The sets of a family; none of a text that is no list of sets, which the tests would find.
fn read(text: &str) -> Vec<MaterialSet> {
    serde_json::from_str(text).unwrap_or_default()
}

static SETS: LazyLock<Vec<MaterialSet>> =
    LazyLock::new(|| FAMILIES.iter().flat_map(|(_, text)| read(text)).collect());

/// All sets, family by family.
pub fn sets() -> &'static [MaterialSet] {
    &SETS
}

impl MaterialSet {
    /// Family of the set, the first part of its name.
    pub fn family(&self) -> &str {
        self.name.split('/').next().unwrap_or_default()
    }
}

/// The set of a name.
pub fn find(name: &str) -> Option<&'static MaterialSet> {
    sets().iter().find(|set| set.name == name)
}

/// Problem at `here`: the library has no set of that name.
pub fn unknown(name: &str, here: &Pointer) -> Problem {
    Problem::error("unknown_material", here, format!("the library has no {name:?}"))
        .value(name)
        .limit("a name that `contuse materials` lists")
        .remedy(nearest_to(name))
}

/// Suggestions for an unknown name: the nearest one, those of its family, or some of all.
pub fn nearest_to(wrong: &str) -> String {
    let names = || sets().iter().map(|set| set.name.as_str());
    let family = wrong.split_once('/').map_or(wrong, |(family, _)| family);
    let of_family = || sets().iter().filter(|set| set.family() == family).map(|set| set.name.as_str());
    let near = suggest(wrong, names());
    if near.starts_with("did you mean") || of_family().next().is_none() {
        near
    } else {
        format!("known names of {family}: {}", of_family().collect::<Vec<_>>().join(", "))
    }
}

impl MaterialSet {
    /// The engine's law, with the constants of the set as they are; `None` where it cannot be made, which the tests would find.
    pub fn law(&self) -> Option<Material> {
        self.material.to_material()
    }

    /// Small-strain shear modulus under slow and under sudden loading [Pa], shear viscosity apart.
    pub fn slow_and_sudden_moduli_pa(&self) -> [f64; 2] {
        let G = self.shear_modulus_pa;
        match &self.prony_series {
            None => [G, G],
            Some(prony) if prony.moduli == Moduli::Instantaneous => [G * (1.0 - prony.sum()), G],
            Some(prony) => [G, G * (1.0 + prony.sum())],
        }
    }

    /// The main source in a word or two.
    pub fn short_source(&self) -> &str {
        self.sources.first().map_or("", |source| &source.short)
    }
}
