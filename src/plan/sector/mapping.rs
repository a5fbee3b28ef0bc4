//! How the whole follows from a sector.

use super::images::Images;
use super::point_history::PointHistory;
use crate::mechanics::lanes::Row;
use crate::mechanics::tensor::Vec3;

/// How the nodes, elements and histories of a symmetric scene follow from the sector of it that is computed.
#[derive(Debug)]
pub struct Sector {
    /// Its images in the planes of symmetry, on the upper side of each of which it is.
    pub images: Images,
    /// For each node of the whole, the node of the sector that it mirrors, and the image that it belongs to.
    pub source: Vec<(u32, u8)>,
    /// For each node of the sector, its node of the whole in each image.
    pub(super) nodes: Vec<Vec<u32>>,
    /// For each element of the sector, its element of the whole in each image.
    pub(super) elements: Vec<Vec<u32>>,
    /// Where the history of the whole follows from; empty if nothing is remembered.
    pub(super) history: Vec<PointHistory>,
}

impl Sector {
    /// Node of the whole that is a node of the sector in an image.
    pub fn image_of_node(&self, node: u32, image: usize) -> u32 {
        self.nodes[node as usize][image]
    }

    /// Element of the whole that is an element of the sector in an image.
    pub fn image_of_element(&self, element: u32, image: usize) -> u32 {
        self.elements[element as usize][image]
    }

    /// The history of the whole, chunk by chunk, from that of the sector.
    pub fn unfold_history(&self, of_sector: &[Vec<Row>], whole: &mut [Vec<Row>]) {
        for point in &self.history {
            let signs = self.images.reflected(Vec3::repeat(1.0), usize::from(point.image));
            point.copy(&signs, of_sector, whole);
        }
    }

    /// The history of the sector, chunk by chunk, from that of the whole.
    pub fn fold_history(&self, whole: &[Vec<Row>], of_sector: &mut [Vec<Row>]) {
        for point in self.history.iter().filter(|point| point.image == 0) {
            let PointHistory { to, from, .. } = *point;
            PointHistory { to: from, from: to, ..*point }.copy(&Vec3::repeat(1.0), whole, of_sector);
        }
    }
}
