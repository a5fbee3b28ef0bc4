//! What the solver is told besides the physics: which of the things that a plan leaves out it keeps.

use crate::mechanics::contact::solvers::Method;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// How to solve, apart from what. Nothing here changes the question that the scene asks.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SolverDocument {
    /// What is put back though the scene does not need it, to measure what leaving it out saves and that the results agree.
    #[serde(default)]
    pub keep: Vec<Keep>,
    /// Where the error bars of the summary come from.
    #[serde(default, skip_serializing_if = "ErrorBarsDocument::is_default")]
    pub error_bars: ErrorBarsDocument,
    /// Which solver of the library (docs/contact-solvers.md) finds the contact reactions. By default explicit steps sweep over the
    /// nodal velocities (Gauss–Seidel) and form no `W`, and implicit and load steps use `hybrid`. A solver that is named here gets
    /// `W`, `q` and `μ` of every step: for comparisons, and where the default stops; explicit steps take longer with it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub contact: Option<ContactSolver>,
}

/// A solver of contact problems.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[cfg_attr(feature = "service", derive(utoipa::ToSchema))]
#[serde(rename_all = "snake_case")]
pub enum ContactSolver {
    /// Picks and switches by itself.
    Hybrid,
    /// Block Gauss–Seidel with the exact solution of each contact.
    Nsgs,
    /// Semismooth Newton on all contacts.
    Newton,
    /// Primal-dual interior points on the second-order cones.
    InteriorPoint,
    /// Proximal points, each by Gauss–Seidel and Newton.
    Proximal,
    /// The fixed point of De Saxcé & Feng.
    DeSaxce,
    /// One projection a contact and sweep, with a step of its own.
    Uzawa,
    /// Extragradient steps of their own length.
    Extragradient,
    /// Projected gradient with Nesterov's momentum and restarts.
    AcceleratedGradient,
}

impl ContactSolver {
    /// All of them.
    pub const ALL: [Self; 9] = [
        Self::Hybrid,
        Self::Nsgs,
        Self::Newton,
        Self::InteriorPoint,
        Self::Proximal,
        Self::DeSaxce,
        Self::Uzawa,
        Self::Extragradient,
        Self::AcceleratedGradient,
    ];

    /// That of the library.
    pub fn method(self) -> Method {
        match self {
            Self::Hybrid => Method::Hybrid,
            Self::Nsgs => Method::Nsgs,
            Self::Newton => Method::Newton,
            Self::InteriorPoint => Method::InteriorPoint,
            Self::Proximal => Method::Proximal,
            Self::DeSaxce => Method::DeSaxce,
            Self::Uzawa => Method::Uzawa,
            Self::Extragradient => Method::Extragradient,
            Self::AcceleratedGradient => Method::AcceleratedGradient,
        }
    }

    /// Its name for people, and on the command line.
    pub fn name(self) -> &'static str {
        self.method().name()
    }

    /// The one of a name, as on the command line.
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|solver| solver.name() == name)
    }
}

/// Where the error bars of the summary come from.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum ErrorBarsDocument {
    /// From three runs with half the numbers of elements, before the run itself; they add about a third to its time. Only
    /// generated meshes can be made coarser.
    #[default]
    TwoLevels,
    /// From a fourth run besides, on a mesh between the two (numbers of elements divided by √2): a straight line is fitted to the three
    /// values of each number, and scatter about it widens the error bar. They add two thirds to the run's time.
    ThreeLevels,
    /// There are none.
    None,
}

impl ErrorBarsDocument {
    #[allow(clippy::trivially_copy_pass_by_ref)] // serde's signature
    fn is_default(&self) -> bool {
        *self == Self::default()
    }
}

impl SolverDocument {
    /// Whether nothing was asked.
    pub fn is_default(&self) -> bool {
        *self == Self::default()
    }
}

/// A thing that plans leave out where a scene does not need it, and that can be put back.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize, JsonSchema)]
#[cfg_attr(feature = "service", derive(utoipa::ToSchema))]
#[serde(rename_all = "snake_case")]
pub enum Keep {
    /// Elements that nothing has reached yet are swept too.
    QuietElements,
    /// Pairs that cannot meet before the end are looked at too.
    DistantPairs,
    /// Bodies are searched for self-contact in every step, also where nothing of them can have come near since the last search.
    IdleSelfContact,
    /// Contacts of pairs without friction have three unknowns, two of which turn out zero.
    TangentialReactions,
    /// Fibre families of stiffness k1 = 0 are swept too.
    IdleFibres,
    /// All fields are computed and recorded, asked for or not.
    UnaskedFields,
}

impl Keep {
    /// All of them.
    pub const ALL: [Self; 6] = [
        Self::QuietElements,
        Self::DistantPairs,
        Self::IdleSelfContact,
        Self::TangentialReactions,
        Self::IdleFibres,
        Self::UnaskedFields,
    ];

    /// Its name in documents and on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::QuietElements => "quiet_elements",
            Self::DistantPairs => "distant_pairs",
            Self::IdleSelfContact => "idle_self_contact",
            Self::TangentialReactions => "tangential_reactions",
            Self::IdleFibres => "idle_fibres",
            Self::UnaskedFields => "unasked_fields",
        }
    }

    /// The one of a name.
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
        assert_eq!(Keep::from_name("quiet"), None);
    }

    #[test]
    fn solvers_are_called_as_in_the_library() {
        for solver in ContactSolver::ALL {
            assert_eq!(serde_json::to_value(solver).unwrap(), solver.name().replace('-', "_"));
            assert_eq!(ContactSolver::from_name(solver.name()), Some(solver));
        }
        // Where something rubs `frictionless` is the hybrid, and where nothing does the default has one unknown anyway.
        assert_eq!(ContactSolver::ALL.len() + 1, Method::ALL.len());
    }
}
