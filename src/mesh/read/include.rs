//! What a reader may need beside the file of the mesh: files that it includes, and arrays of the elements.

use std::collections::BTreeSet;

/// Reads the included file of this name, or says why it cannot.
pub type Include<'a> = &'a mut dyn FnMut(&str) -> Result<Vec<u8>, String>;

/// Names of the arrays of elements that are read beside the mesh; all others are only noted.
pub type FieldNames = BTreeSet<String>;
