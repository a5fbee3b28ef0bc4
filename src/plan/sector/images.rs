//! Images of a sector in planes of symmetry.

use crate::mechanics::tensor::Vec3;
use crate::mesh::mirror::MirrorPlane;

/// The images in some planes. An *image* is a set of planes as bits, in which the sector is reflected one after the other: 0 is the sector itself.
#[derive(Clone, Debug, PartialEq)]
pub struct Images(pub Vec<MirrorPlane>);

impl Images {
    /// Number of images, the sector itself included.
    pub fn count(&self) -> usize {
        1 << self.0.len()
    }

    /// A direction in an image.
    pub fn reflected(&self, direction: Vec3, image: usize) -> Vec3 {
        self.planes_of(image).fold(direction, |direction, plane| plane.reflected(direction))
    }

    /// A point in an image [m].
    pub fn image_of_point(&self, point: Vec3, image: usize) -> Vec3 {
        self.planes_of(image).fold(point, |point, plane| plane.image(point))
    }

    /// The planes that an image is reflected in.
    fn planes_of(&self, image: usize) -> impl Iterator<Item = &MirrorPlane> {
        self.0.iter().enumerate().filter(move |(bit, _)| image & (1 << bit) != 0).map(|(_, plane)| plane)
    }
}
