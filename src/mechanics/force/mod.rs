//! Internal forces of blocks of elements.

/// A block of elements of one kernel. SKELETON
#[derive(Debug)]
pub struct ElementBlock {}
/// Node sums. SKELETON
#[derive(Debug, Default)]
pub struct Assembly {}
