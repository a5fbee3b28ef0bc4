//! Meshes made of the labels of a scan, or of closed surfaces, in a scene document.

use crate::mechanics::tensor::Vec3;
use crate::mesh::defaults::{is_one, one};
use crate::mesh::segmentation::{Crop, LabelUse, Near, Options, SkinLayer};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Name of the part of a skin of given thickness.
pub const SKIN: &str = "skin";

/// Largest edge of the voxels in surfaces, relative to the smallest size of elements [-].
const VOXEL_OF_ELEMENT: f64 = 0.5;

/// A volume of labels from a scan, or of closed surfaces, which is filled with hexahedra: parts for its labels, node sets `outer`,
/// `x_min` … `z_max` where the scan or the crop cuts the body, and one for each hole. It has a `name`, or `surfaces`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SegmentationDocument {
    /// File name relative to the scene's folder (`.nii`, `.nii.gz`, `.nrrd`, `.mha`), or the id of an uploaded scan.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub name: Option<String>,
    /// Closed surfaces instead of a scan, from the outside to the inside: a point inside several belongs to the last of them.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub surfaces: Vec<ClosedSurfaceDocument>,
    /// Largest edge of the voxels that the surfaces are filled with [m]; by default half of the smallest of `size_m`, `near` and
    /// `thin_size_m`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub voxel_size_m: Option<f64>,
    /// What the labels of a scan become; label 0 is outside. All others are parts `label_<n>` by default.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub labels: Vec<LabelDocument>,
    /// Largest edge of the elements [m].
    pub size_m: f64,
    /// Points around which elements are smaller.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub near: Vec<NearDocument>,
    /// Size down to which elements are halved in layers thinner than two of them [m]; by default the smallest of `size_m` and `near`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub thin_size_m: Option<f64>,
    /// The box of the scan that is used; by default all of it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub crop: Option<CropDocument>,
    /// Thickness of a part `skin` under the outer surface, one element thick, for a scan that does not resolve it [m].
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub skin_thickness_m: Option<f64>,
    /// Volume below which a group of voxels is noise, and takes the label around it [m³]; by default that of 30 voxels.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub noise_m3: Option<f64>,
    /// Largest number of elements; by default what the limit for all bodies leaves.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub max_elements: Option<u64>,
}

/// What a label becomes: a part, a hole, or, with neither, outside.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct LabelDocument {
    /// The label, as the scan has it.
    pub label: i64,
    /// Name of its part; labels with the same name form one part.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub part: Option<String>,
    /// Name of the node set on the surface of a hole in its place: a bone that does not deform.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub hole: Option<String>,
}

/// A closed surface: what is in it becomes a part, a hole, or, with neither, outside.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ClosedSurfaceDocument {
    /// File name relative to the scene's folder (`.stl`, ASCII or binary), or the id of an uploaded surface.
    pub name: String,
    /// Scale factor (0.001 for a file in millimetres); all other lengths are those of the scaled surface.
    #[serde(default = "one", skip_serializing_if = "is_one")]
    pub scale: f64,
    /// Name of its part; surfaces with the same name form one part.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub part: Option<String>,
    /// Name of the node set on the surface of a hole in its place: a bone that does not deform.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub hole: Option<String>,
}

/// Small elements around a point.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct NearDocument {
    /// The point, in the space of the scan: before the placement [m].
    pub point_m: [f64; 3],
    /// Largest edge of the elements there [m]; reached by halving `size_m`.
    pub size_m: f64,
    /// Distance to which that applies [m]; beyond it, edges grow by 0.4 m a metre.
    #[serde(default)]
    pub within_m: f64,
}

/// A box along those axes of the scan that are nearest to x, y, z.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct CropDocument {
    /// Its centre, in the space of the scan [m].
    pub center_m: [f64; 3],
    /// Its lengths; rounded up to whole voxels [m].
    pub size_m: [f64; 3],
}

impl SegmentationDocument {
    /// What is requested of the mesh, of at most `elements` elements, with the volumes of its labels where these are not those of
    /// the voxels.
    pub fn options(&self, elements: u64, volumes_m3: Vec<(i64, f64)>) -> Options {
        let usage = |part: &Option<String>, hole: &Option<String>| match (part, hole) {
            (Some(part), _) => LabelUse::Part(part.clone()),
            (None, Some(hole)) => LabelUse::Hole(hole.clone()),
            (None, None) => LabelUse::Outside,
        };
        let of_labels = self.labels.iter().map(|label| (label.label, usage(&label.part, &label.hole)));
        let of_surfaces = (1..).zip(&self.surfaces).map(|(n, own)| (n, usage(&own.part, &own.hole)));
        let near = |near: &NearDocument| Near {
            point: Vec3::from(near.point_m),
            size_m: near.size_m,
            within_m: near.within_m,
        };
        Options {
            labels: of_labels.chain(of_surfaces).collect(),
            volumes_m3,
            size_m: self.size_m,
            near: self.near.iter().map(near).collect(),
            thin_size_m: self.thin_size_m,
            crop: self.crop(),
            skin: self.skin_thickness_m.map(|thickness_m| SkinLayer { part: SKIN.into(), thickness_m }),
            noise_m3: self.noise_m3,
            max_elements: self.max_elements.unwrap_or(elements).min(elements),
        }
    }

    /// The box that is used.
    pub fn crop(&self) -> Option<Crop> {
        let crop = self.crop.as_ref()?;
        Some(Crop { center: Vec3::from(crop.center_m), size_m: Vec3::from(crop.size_m) })
    }

    /// Largest edge of the voxels that surfaces are filled with [m].
    pub fn voxel_m(&self) -> f64 {
        let sizes = self.near.iter().map(|near| near.size_m).chain(self.thin_size_m);
        self.voxel_size_m.unwrap_or_else(|| VOXEL_OF_ELEMENT * sizes.fold(self.size_m, f64::min))
    }

    /// Whether the numbers can be computed with; if not, the checks of the document say why.
    pub fn is_sound(&self) -> bool {
        let is_positive = |x: &f64| *x > 0.0 && x.is_finite();
        let is_point = |point: &[f64; 3]| point.iter().all(|x| x.is_finite());
        let lengths = [Some(self.size_m), self.thin_size_m, self.skin_thickness_m, self.voxel_size_m];
        lengths.iter().flatten().all(is_positive)
            && self.name.is_some() == self.surfaces.is_empty()
            && self.surfaces.iter().all(|surface| is_positive(&surface.scale))
            && self.noise_m3.is_none_or(|noise| noise >= 0.0)
            && self
                .near
                .iter()
                .all(|near| is_positive(&near.size_m) && is_point(&near.point_m) && near.within_m >= 0.0)
            && self
                .crop
                .as_ref()
                .is_none_or(|crop| crop.size_m.iter().all(is_positive) && is_point(&crop.center_m))
    }

    /// Divides all sizes of elements by `factor`.
    pub fn divide_sizes(&mut self, factor: f64) {
        self.size_m /= factor;
        self.near.iter_mut().for_each(|near| near.size_m /= factor);
        self.thin_size_m = self.thin_size_m.map(|size| size / factor);
    }
}
