//! What a reader may need beside the file of the mesh: files that it includes, and arrays of the elements.

use std::collections::BTreeSet;

/// Reads the included file of this name, or says why it cannot.
pub type Include<'a> = &'a mut dyn FnMut(&str) -> Result<Vec<u8>, String>;

/// The arrays of elements that are read beside the mesh; all others are only noted.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum FieldNames {
    /// The arrays with these names.
    Named(BTreeSet<String>),
    /// All that have one component or three and do not name parts.
    All,
}

impl FieldNames {
    /// No array.
    pub const NONE: Self = Self::Named(BTreeSet::new());

    /// Whether an array of this name is read as one of the elements, which `names_parts` or not.
    pub(super) fn include(&self, name: &str, names_parts: bool) -> bool {
        match self {
            Self::Named(names) => names.contains(name),
            Self::All => !names_parts,
        }
    }
}
