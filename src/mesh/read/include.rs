//! Files that a mesh file includes.

/// Reads the included file of this name, or says why it cannot.
pub type Include<'a> = &'a mut dyn FnMut(&str) -> Result<Vec<u8>, String>;
