//! The sum of element forces at each node, in a fixed order.

use crate::mechanics::tensor::Vec3;

/// Which element corners each node sums: a compressed list, ascending in the slot of the element.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Assembly {
    /// Where the list of each node starts, nodes + 1.
    start: Vec<u32>,
    /// Corner indices `8 slot + corner` into the element forces.
    corners: Vec<u32>,
}

impl Assembly {
    /// From the nodes of the corners of every slot: `(corner index, node)` pairs in ascending corner order.
    pub fn new(node_count: usize, corners: &[(u32, u32)]) -> Self {
        let mut start = vec![0_u32; node_count + 1];
        for (_, node) in corners {
            start[*node as usize + 1] += 1;
        }
        for node in 0..node_count {
            start[node + 1] += start[node];
        }
        let mut next = start.clone();
        let mut list = vec![0; corners.len()];
        for (corner, node) in corners {
            let place = &mut next[*node as usize];
            list[*place as usize] = *corner;
            *place += 1;
        }
        Self { start, corners: list }
    }

    /// Sum of the element forces [N] at a node.
    #[inline]
    pub fn sum_at(&self, node: usize, element_forces: &[Vec3]) -> Vec3 {
        let range = self.start[node] as usize..self.start[node + 1] as usize;
        let mut sum = Vec3::zeros();
        for corner in &self.corners[range] {
            sum += element_forces[*corner as usize];
        }
        sum
    }

    /// Bytes in memory.
    pub fn memory(&self) -> usize {
        4 * (self.start.len() + self.corners.len())
    }
}
