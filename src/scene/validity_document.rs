//! Range of validity of a law, in a scene document.

use crate::mechanics::material::{Deformations, Given, Material, Validity};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// The deformations to which a law's parameters were fitted, and those beyond which the results of a run are withheld. Without
/// them, those usual for the law raise warnings and withhold nothing.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ValidityDocument {
    /// Principal stretches to which it was fitted, from … to [-].
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub stretch: Option<[f64; 2]>,
    /// Volume ratios J to which it was fitted, from … to [-].
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub jacobian: Option<[f64; 2]>,
    /// Strain rates of the tests, from … to [1/s]. A part that is deformed faster is reported; nothing is withheld.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub strain_rate_per_s: Option<[f64; 2]>,
    /// Principal stretches beyond which the results of the run are withheld [-].
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub limit_stretch: Option<[f64; 2]>,
    /// Volume ratios J beyond which the results of the run are withheld [-].
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub limit_jacobian: Option<[f64; 2]>,
}

impl ValidityDocument {
    /// The given ranges of deformation by name, in the order of the fields.
    pub fn given(&self) -> [(&'static str, Option<[f64; 2]>); 4] {
        [
            ("stretch", self.stretch),
            ("jacobian", self.jacobian),
            ("limit_stretch", self.limit_stretch),
            ("limit_jacobian", self.limit_jacobian),
        ]
    }

    /// The range of a law: the given one, or that of the law, whose limits are widened to contain the given range.
    pub fn range_of(&self, material: &Material) -> Validity {
        let own = material.validity();
        let wider = |limit: [f64; 2], range: [f64; 2]| [limit[0].min(range[0]), limit[1].max(range[1])];
        let fitted = Deformations {
            stretch: self.stretch.unwrap_or(own.fitted.stretch),
            jacobian: self.jacobian.unwrap_or(own.fitted.jacobian),
        };
        let limit = Deformations {
            stretch: self.limit_stretch.unwrap_or_else(|| wider(own.limit.stretch, fitted.stretch)),
            jacobian: self.limit_jacobian.unwrap_or_else(|| wider(own.limit.jacobian, fitted.jacobian)),
        };
        let given = Given { stretch: self.stretch.is_some(), jacobian: self.jacobian.is_some() };
        let declared =
            Given { stretch: self.limit_stretch.is_some(), jacobian: self.limit_jacobian.is_some() };
        Validity { fitted, given, declared, limit, strain_rate: self.strain_rate_per_s }
    }
}
