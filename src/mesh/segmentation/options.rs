//! What is requested of a mesh of a label volume.

use crate::mechanics::tensor::Vec3;

/// What becomes of the voxels of a label.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum LabelUse {
    /// Elements of a part of this name.
    Part(String),
    /// A hole; the nodes on its surface are a set of this name.
    Hole(String),
    /// Outside, as label 0.
    Outside,
}

/// Small elements around a point.
#[derive(Clone, Debug, PartialEq)]
pub struct Near {
    /// The point, in the space of the scan [m].
    pub point: Vec3,
    /// Largest edge of the elements there [m].
    pub size_m: f64,
    /// Distance to which that applies [m]; elements grow beyond it.
    pub within_m: f64,
}

/// A box along the axes of the scan.
#[derive(Clone, Debug, PartialEq)]
pub struct Crop {
    /// Its centre, in the space of the scan [m].
    pub center: Vec3,
    /// Its lengths along the axes of the scan that are nearest to x, y, z [m].
    pub size_m: Vec3,
}

/// A layer on the outer surface.
#[derive(Clone, Debug, PartialEq)]
pub struct SkinLayer {
    /// Name of its part.
    pub part: String,
    /// Its thickness [m]; what it takes is taken from the parts below.
    pub thickness_m: f64,
}

/// What a scan is meshed with: use of its labels, sizes of elements, layers, smoothing; see [`super::mesh`].
#[derive(Clone, Debug, PartialEq)]
pub struct Options {
    /// Use of each label but 0; labels of the scan that are not listed are refused. Empty: all are parts `label_<n>`.
    pub labels: Vec<(i64, LabelUse)>,
    /// Volume that each label but 0 gets [m³]; empty: that of its voxels.
    pub volumes_m3: Vec<(i64, f64)>,
    /// Largest edge of the elements [m].
    pub size_m: f64,
    /// Where they are smaller.
    pub near: Vec<Near>,
    /// Size to which elements are halved where a layer is too thin for them [m]; `None`: the smallest of all.
    pub thin_size_m: Option<f64>,
    /// The part of the scan that is meshed; `None`: all of it.
    pub crop: Option<Crop>,
    /// A skin that the scan does not resolve.
    pub skin: Option<SkinLayer>,
    /// Groups of voxels below this volume are noise [m³].
    pub noise_m3: Option<f64>,
    /// Largest number of elements.
    pub max_elements: u64,
}

impl Options {
    /// Whether the labels are those of closed surfaces, whose volumes are known.
    pub fn is_of_surfaces(&self) -> bool {
        !self.volumes_m3.is_empty()
    }
}
