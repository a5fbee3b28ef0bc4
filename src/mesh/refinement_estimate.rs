//! Number of elements that local refinement makes at least, without splitting the mesh.
//!
//! Elements wholly inside a region count in closed form: with k halvings each becomes 8ᵏ. Only those at the rim of a region are
//! followed level by level, on their own. Elements split for balance come on top.

use super::refinement_region::{MOST_HALVINGS, ROUNDING, Region};
use super::{CellKind, Mesh};
use crate::mechanics::element::HEX8_CORNERS;
use crate::mechanics::tensor::Vec3;

/// Largest number of elements that are followed: a rim of this many surrounds a volume of many more.
const MOST_FOLLOWED: usize = 200_000;

/// Corners of a hexahedron [m].
type Corners = [Vec3; 8];

/// Lower bound of the number of elements after refinement; the search ends once it exceeds `most`.
pub fn least_elements(mesh: &Mesh, regions: &[Region], most: u64) -> u64 {
    let mut elements = mesh.cells.len() as u64;
    let corners_of = |e: usize| Corners::try_from(&*mesh.cells.points(e, &mesh.nodes)).ok();
    let hexahedra = (0..mesh.cells.len()).filter(|e| mesh.cells.kind(*e) == CellKind::Hex8);
    let mut rim = Vec::new();
    for corners in hexahedra.filter_map(corners_of) {
        count(corners, MOST_HALVINGS, regions, &mut elements, &mut rim);
    }
    for halvings_left in (0..MOST_HALVINGS).rev() {
        if rim.is_empty() || elements > most || rim.len() > MOST_FOLLOWED {
            break;
        }
        let mut next = Vec::new();
        for child in rim.iter().flat_map(children) {
            count(child, halvings_left, regions, &mut elements, &mut next);
        }
        rim = next;
    }
    elements
}

/// Adds what an element becomes beyond itself; one at the rim of a region is split once, and its children are still to be counted.
fn count(
    corners: Corners,
    halvings_left: u8,
    regions: &[Region],
    elements: &mut u64,
    rim: &mut Vec<Corners>,
) {
    if halvings_left == 0 || !regions.iter().any(|region| region.splits(&corners)) {
        return;
    }
    let near = || regions.iter().filter(|region| region.splits(&corners));
    if near().all(|region| contains(region, &corners)) {
        let deepest = near().map(|region| halvings(&corners, region.size)).max().unwrap_or(0);
        // At least the one that was found to be due.
        let halvings = u32::from(deepest.clamp(1, halvings_left));
        *elements = elements.saturating_add(8_u64.saturating_pow(halvings) - 1);
    } else {
        *elements = elements.saturating_add(7);
        rim.push(corners);
    }
}

/// Whether an element, and so all of its children, lies within the region of a single place.
fn contains(region: &Region, corners: &Corners) -> bool {
    let low = corners.iter().fold(corners[0], |low, x| low.inf(x));
    let high = corners.iter().fold(corners[0], |high, x| high.sup(x));
    let farthest = |point: &Vec3| (point - low).abs().sup(&(high - point).abs()).norm();
    region.places.iter().any(|place| farthest(&place.point) <= region.within)
}

/// How often an element and all of its children are halved for edges of a size [m], whatever the normal: as often as the second
/// longest of its three directions requires.
fn halvings(corners: &Corners, size: f64) -> u8 {
    let mut shortest = shortest_edges(corners);
    shortest.sort_by(f64::total_cmp);
    let [_, mut edge, _] = shortest;
    let mut count = 0;
    while edge > size * (1.0 + ROUNDING) && count < MOST_HALVINGS {
        edge *= 0.5;
        count += 1;
    }
    count
}

/// Shortest edge [m] in each natural direction, along the mean of its four edges: half of it bounds the edges of children from below.
fn shortest_edges(corners: &Corners) -> [f64; 3] {
    let edges = |axis: usize| {
        let of_axis = CellKind::Hex8.table().edges.iter();
        let of_axis = of_axis.filter(move |[a, b]| HEX8_CORNERS[*a][axis] * HEX8_CORNERS[*b][axis] < 0.0);
        of_axis.map(move |&[a, b]| (corners[b] - corners[a]) * HEX8_CORNERS[b][axis])
    };
    std::array::from_fn(|axis| {
        let mean = edges(axis).sum::<Vec3>().try_normalize(0.0).unwrap_or_else(Vec3::zeros);
        edges(axis).map(|edge| edge.dot(&mean)).fold(f64::INFINITY, f64::min)
    })
}

/// The eight children of an element.
fn children(corners: &Corners) -> Vec<Corners> {
    let Some(split) = CellKind::Hex8.table().split.as_ref() else { return Vec::new() };
    let middle = |of: &&[usize]| of.iter().map(|i| corners[*i]).sum::<Vec3>() / of.len() as f64;
    let points: Vec<Vec3> = corners.iter().copied().chain(split.middles.iter().map(middle)).collect();
    split.children.iter().map(|child| std::array::from_fn(|i| points[child[i]])).collect()
}

#[cfg(test)]
#[allow(clippy::unwrap_used)] // tests may panic
mod tests {
    use super::super::generate::block::Block;
    use super::super::generate::limb_segment::LimbSegment;
    use super::super::local_refinement::refined_in;
    use super::super::refinement_region::Place;
    use super::*;

    fn block() -> Mesh {
        Block::uniform(Vec3::zeros(), Vec3::new(8.0, 8.0, 4.0), [8, 8, 4], "b").generate().unwrap()
    }

    fn at_top(mesh: &Mesh, within: f64, size: f64) -> Region {
        Region { places: Place::on_all(mesh, &[Vec3::new(4.0, 4.0, 4.0)]), within, size }
    }

    #[test]
    fn the_bound_is_close_where_there_is_a_rim_and_exact_where_everything_is_split() {
        let coarse = block();
        for (within, size) in [(1.5, 0.5), (1.5, 0.25), (0.3, 0.13), (3.0, 0.25)] {
            let region = [at_top(&coarse, within, size)];
            let least = least_elements(&coarse, &region, u64::MAX);
            let (fine, _) = refined_in(&coarse, &region, 1_000_000).unwrap();
            let made = fine.cells.len() as u64;
            assert!(least <= made && 4 * least > made, "{within} {size}: {least} of {made}");
        }
        let everywhere = [at_top(&coarse, 20.0, 0.25)];
        assert_eq!(least_elements(&coarse, &everywhere, u64::MAX), 256 * 64);
        assert_eq!(least_elements(&coarse, &[at_top(&coarse, 1.5, 1.0)], u64::MAX), 256);
        assert_eq!(least_elements(&coarse, &[], u64::MAX), 256);
    }

    #[test]
    fn distorted_elements_and_overlapping_regions_are_not_counted_too_often() {
        let limb = LimbSegment { elements_around: 16, elements_along: 6, ..LimbSegment::default() };
        let coarse = limb.generate().unwrap();
        let top = coarse.nodes.iter().max_by(|a, b| a.z.total_cmp(&b.z)).copied().unwrap();
        let region = |within, size| Region { places: Place::on_all(&coarse, &[top]), within, size };
        for regions in [vec![region(0.03, 0.006)], vec![region(0.06, 0.012), region(0.02, 0.004)]] {
            let least = least_elements(&coarse, &regions, u64::MAX);
            let (fine, _) = refined_in(&coarse, &regions, 10_000_000).unwrap();
            assert!(least <= fine.cells.len() as u64, "{least} of {}", fine.cells.len());
            assert!(least > coarse.cells.len() as u64);
        }
    }

    #[test]
    fn tiny_elements_are_counted_without_being_made() {
        let coarse = block();
        // Half a ball of radius 1.5 holds some 7e12 cubes of 1e-4.
        let least = least_elements(&coarse, &[at_top(&coarse, 1.5, 1e-4)], 5_000_000);
        assert!(least > 5_000_000, "{least}");
    }
}
