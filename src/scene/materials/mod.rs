//! Materials in a scene document: one file per law.

mod balzani;
mod blatz_ko;
mod checks;
mod exponential_invariants;
mod families;
mod fung;
mod holzapfel_gasser_ogden;
mod law;
pub mod library;
mod mooney_rivlin;
mod neo_hookean;
mod ogden;
mod peng_guo_moran;
mod volumetric;
mod weiss;
mod yeoh;

pub use checks::MOST_MODULUS;
pub use families::Families;
pub use holzapfel_gasser_ogden::{I4Invariants, MatrixDocument};
pub use law::LawDocument;
pub use ogden::{FebioTerm, MuAlpha, OgdenTerms};
pub use volumetric::VolumetricDocument;

use super::memories::Rules;
use super::problem::Pointer;
use super::validate::Findings;
use super::validity_document::ValidityDocument;
use crate::mechanics::material::{Law, Material};
use crate::mechanics::with_laws;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Generates, from the list of laws ([`with_laws`]), the enum [`MaterialDocument`] and the methods that dispatch on it.
macro_rules! laws {
    ($($name:literal: $file:ident, $Law:ident, $Document:ident;)*) => {
        $(pub use $file::$Document;)*

        /// A constitutive law with its parameters.
        #[allow(missing_docs)] // their documents have it
        #[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
        #[serde(tag = "law")]
        pub enum MaterialDocument {
            $(
                #[serde(rename = $name)]
                $Law($Document),
            )*
        }

        impl MaterialDocument {
            /// The law's name in documents.
            pub fn law_name(&self) -> &'static str {
                match self {
                    $(Self::$Law(_) => $name,)*
                }
            }

            fn law(&self) -> &dyn LawDocument {
                match self {
                    $(Self::$Law(law) => law,)*
                }
            }

            fn law_mut(&mut self) -> &mut dyn LawDocument {
                match self {
                    $(Self::$Law(law) => law,)*
                }
            }
        }
    };
}

with_laws!(laws);

impl MaterialDocument {
    /// Checks the parameters: stability of the law, and unusual values.
    pub fn check(&self, here: &Pointer, out: &mut Findings) {
        checks::validity(&self.valid_to(), &here.key("valid_to"), out);
        self.law().check(here, out);
    }

    /// Multiplies every stiffness except the volumetric one (the bulk modulus, or λ).
    pub fn scale_stiffness(&mut self, factor: f64) {
        self.law_mut().scale_stiffness(factor);
    }

    /// Multiplies the bulk modulus of a split law.
    pub fn scale_bulk_modulus(&mut self, factor: f64) {
        self.law_mut().scale_bulk_modulus(factor);
    }

    /// The law; `None` when it has too many fibre directions, or one without a direction.
    pub fn to_material(&self) -> Option<Material> {
        self.law().to_material()
    }

    /// Range of validity given in the document.
    pub fn valid_to(&self) -> ValidityDocument {
        self.law().valid_to().unwrap_or_default()
    }

    /// Whether all dependence on J alone is in U(J), so that an element may average it.
    pub fn is_split(&self) -> bool {
        self.law().is_split()
    }

    /// What internal variables of the law need of steps and elements; `None` for an elastic law.
    pub fn rules(&self) -> Option<Rules> {
        self.to_material().filter(|law| law.history_len() > 0).map(|_| self.law().rules())
    }

    /// Number of fibre families of the law.
    pub fn family_count(&self) -> usize {
        self.law().family_count()
    }
}
