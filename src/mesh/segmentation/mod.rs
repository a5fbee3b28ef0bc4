//! Segmentations: volumes of labels from a scan, and the hexahedra made of them.
//!
//! `read` reads a [`LabelVolume`], [`Filling`] makes one of closed surfaces (`rasterise`). [`mesh`] crops it, removes noise (`islands`), fills its box with a balanced `octree`, gives each
//! leaf the label of most of its volume (`labelling`), and moves the nodes between labels onto their surfaces (`surfaces`,
//! `smoothing`) while every label keeps the volume of its voxels, or of what its surface encloses (`volumes`, `enclosed`). Hanging nodes are as those of local refinement.
//!
//! The octree lies along the axes of the scan: its ends, and those of a crop, are then flat faces of elements, at whatever angle the
//! scan was taken.
#![allow(clippy::cast_possible_wrap)] // the voxels of a scan fit into memory

mod classes;
mod elements;
mod enclosed;
mod erosion;
mod grid;
mod indicator;
mod islands;
mod labelling;
mod mesher;
mod octree;
mod options;
mod rasterise;
pub mod read;
mod sizes;
mod skin;
mod smoothing;
mod surfaces;
#[cfg(test)]
pub(crate) mod tests;
mod volume;
mod volumes;

pub use islands::body_of;
pub use mesher::{POORLY_RESOLVED, RELABELLED, idle_place, mesh};
pub use options::{Crop, LabelUse, Near, Options, SkinLayer};
pub use rasterise::{Filled, Filling, Unfilled};
pub use volume::{Frame, LabelCount, LabelVolume, MOST_LABELS, ScanInspection};
