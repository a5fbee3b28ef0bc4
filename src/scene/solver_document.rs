//! Solver settings besides the physics, among them the features that a plan keeps although they are not needed.

use crate::mechanics::contact::solution::solvers::Method;
use crate::mechanics::with_contact_solvers;
use clap::ValueEnum;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Settings of the solution that leave the physical problem unchanged.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SolverDocument {
    /// Features to keep although the scene does not need them, to measure what omitting them saves and that the results
    /// agree.
    #[serde(default)]
    pub keep: Vec<Keep>,
    /// How the error bars of the summary are determined.
    #[serde(default, skip_serializing_if = "ErrorBarsDocument::is_default")]
    pub error_bars: ErrorBarsDocument,
    /// Solver of the library (docs/contact-solvers.md) for the contact reactions. By default, explicit steps use
    /// matrix-free Gauss–Seidel on the nodal velocities, and implicit and load steps use `hybrid`. A solver given here gets
    /// `W`, `q` and `μ` of every step: for comparisons, and where the default fails; explicit steps then take longer.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub contact: Option<ContactSolver>,
}

macro_rules! contact_solvers {
    ($($(#[$doc:meta])* $variant:ident $name:literal,)*) => {
        /// A solver for contact problems (docs/contact-solvers.md).
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema, ValueEnum)]
        #[cfg_attr(feature = "service", derive(utoipa::ToSchema))]
        #[serde(rename_all = "snake_case")]
        pub enum ContactSolver {
            $($(#[$doc])* #[value(name = $name)] $variant,)*
        }

        impl ContactSolver {
            /// The method of the library.
            pub fn method(self) -> Method {
                match self {
                    $(Self::$variant => Method::$variant,)*
                }
            }
        }
    };
}

with_contact_solvers!(contact_solvers);

/// How the error bars of the summary are determined.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum ErrorBarsDocument {
    /// `contuse run` runs an impact to an accuracy of 10 % within an estimated time of 50 s; everything else uses two levels.
    #[default]
    Automatic,
    /// From three runs with half the numbers of elements, before the run itself; they add about a third to its time. A mesh
    /// from a file, which cannot be coarsened, is compared with a run that has every element split into eight, if the runs for
    /// that are expected to take at most a minute on one core: about twenty times as long as the run itself.
    TwoLevels,
    /// With a fourth run on a mesh between the two (numbers of elements divided by √2): a straight line is fitted to the
    /// three values of each quantity, and scatter about it widens the error bar. They add two thirds to the run's time. Only
    /// generated meshes can be coarsened.
    ThreeLevels,
    /// No other runs, hence no error bars.
    None,
}

impl ErrorBarsDocument {
    #[allow(clippy::trivially_copy_pass_by_ref)] // serde's signature
    fn is_default(&self) -> bool {
        *self == Self::default()
    }
}

impl SolverDocument {
    /// Whether all settings are the defaults.
    pub fn is_default(&self) -> bool {
        *self == Self::default()
    }
}

/// A feature that plans omit where a scene does not need it, and that can be kept.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize, JsonSchema)]
#[cfg_attr(feature = "service", derive(utoipa::ToSchema))]
#[serde(rename_all = "snake_case")]
pub enum Keep {
    /// All of a symmetric scene is computed, not only the half, quarter or eighth that its mirror images complete.
    MirrorImages,
    /// Inactive elements are evaluated too.
    InactiveElements,
    /// Pairs that cannot meet before the end are searched too.
    DistantPairs,
    /// Bodies are searched for self-contact in every step, even where no part of them can have come close since the last
    /// search.
    IdleSelfContact,
    /// Frictionless contacts have three unknowns, two of which are zero.
    TangentialReactions,
    /// Fibre families of stiffness k1 = 0 are evaluated too.
    IdleFibres,
    /// All fields are computed and recorded, requested or not.
    UnrequestedFields,
}

impl Keep {
    /// All features, in the order of declaration.
    pub const ALL: [Self; 7] = [
        Self::MirrorImages,
        Self::InactiveElements,
        Self::DistantPairs,
        Self::IdleSelfContact,
        Self::TangentialReactions,
        Self::IdleFibres,
        Self::UnrequestedFields,
    ];

    /// Its name in documents and on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::MirrorImages => "mirror_images",
            Self::InactiveElements => "inactive_elements",
            Self::DistantPairs => "distant_pairs",
            Self::IdleSelfContact => "idle_self_contact",
            Self::TangentialReactions => "tangential_reactions",
            Self::IdleFibres => "idle_fibres",
            Self::UnrequestedFields => "unrequested_fields",
        }
    }

    /// The feature with a given name.
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|keep| keep.name() == name)
    }
}

impl std::fmt::Display for Keep {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(self.name())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_those_of_the_documents() {
        for keep in Keep::ALL {
            assert_eq!(serde_json::to_value(keep).unwrap(), keep.name());
            assert_eq!(Keep::from_name(keep.name()), Some(keep));
        }
        assert_eq!(Keep::from_name("inactive"), None);
    }

    #[test]
    fn solvers_are_called_as_in_the_library() {
        for solver in ContactSolver::value_variants() {
            assert_eq!(serde_json::to_value(solver).unwrap(), solver.method().name().replace('-', "_"));
        }
    }
}
