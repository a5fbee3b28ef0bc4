//! What the solver is told besides the physics: which of the things that a plan leaves out it keeps.

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
}

/// Where the error bars of the summary come from.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum ErrorBarsDocument {
    /// From three runs with half the numbers of elements, before the run itself; they add about a third to its time. Only
    /// generated meshes can be made coarser.
    #[default]
    TwoLevels,
    /// From a fourth run besides, with a quarter of the numbers of elements: the order of the mesh is observed and no more assumed,
    /// and a number whose three values show none has no error bar. Numbers of elements must be one or divisible by four.
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
    /// Contacts of pairs without friction have three unknowns, two of which turn out zero.
    TangentialReactions,
    /// Fibre families of stiffness k1 = 0 are swept too.
    IdleFibres,
    /// All fields are computed and recorded, asked for or not.
    UnaskedFields,
}

impl Keep {
    /// All of them.
    pub const ALL: [Self; 5] = [
        Self::QuietElements,
        Self::DistantPairs,
        Self::TangentialReactions,
        Self::IdleFibres,
        Self::UnaskedFields,
    ];

    /// Its name in documents and on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::QuietElements => "quiet_elements",
            Self::DistantPairs => "distant_pairs",
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
}
