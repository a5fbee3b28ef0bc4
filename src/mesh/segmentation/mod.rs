//! Segmentations: volumes of labels from a scan, and the hexahedra made of them.

pub mod read;
pub mod volume;
