//! Which element of a deformed mesh contains a point.

use super::cell::CellKind;
use super::cells::Cells;
use crate::mechanics::tensor::Vec3;
use parry3d_f64::bounding_volume::Aabb;
use parry3d_f64::math::Vector;
use parry3d_f64::partitioning::{Bvh, BvhBuildStrategy};

/// Largest number of Newton steps for the natural coordinates of a point.
const MOST_STEPS: usize = 20;
/// Bound on the natural coordinates during Newton's method.
const FAR: f64 = 4.0;

/// Cells at given positions, searched by a tree of bounding boxes.
pub struct Locator<'a> {
    cells: &'a Cells,
    x: &'a [Vec3],
    /// Elements of the leaves.
    elements: Vec<u32>,
    tree: Bvh,
}

/// Elements at the positions `x` [m] whose bounding boxes intersect a box, ascending. No other element contains a point of
/// the box.
pub fn elements_near([low, high]: &[Vec3; 2], cells: &Cells, x: &[Vec3]) -> Vec<u32> {
    // For each node the sides of the box beyond which it lies, a bit each; an element whose nodes share one is beside it.
    let beyond = |x: &Vec3| {
        (0..3)
            .fold(0_u8, |sides, i| sides | u8::from(x[i] < low[i]) << i | u8::from(x[i] > high[i]) << (3 + i))
    };
    let beyond: Vec<u8> = x.iter().map(beyond).collect();
    let is_beside = |nodes: &[u32]| nodes.iter().fold(!0, |sides, node| sides & beyond[*node as usize]) != 0;
    (0..).zip(cells.iter()).filter(|(_, cell)| !is_beside(cell.nodes)).map(|(element, _)| element).collect()
}

impl<'a> Locator<'a> {
    /// Some elements at the positions `x` [m] of all nodes, which must be finite.
    pub fn of(elements: Vec<u32>, cells: &'a Cells, x: &'a [Vec3]) -> Self {
        let boxes: Vec<Aabb> =
            elements.iter().map(|element| aabb(&cells.get(*element as usize).points(x))).collect();
        let tree = Bvh::from_leaves(BvhBuildStrategy::Binned, &boxes);
        Self { cells, x, elements, tree }
    }

    /// Elements at the positions `x` [m] of all nodes, which must be finite, whose bounding boxes intersect the box of the
    /// points to be located.
    pub fn within(place: &[Vec3; 2], cells: &'a Cells, x: &'a [Vec3]) -> Self {
        Self::of(elements_near(place, cells, x), cells, x)
    }

    /// The first element accepted by `takes` that contains the point [m] in its interior or on its boundary: the natural
    /// coordinates of the point lie in the reference cell.
    pub fn element_at(&self, point: &Vec3, takes: impl Fn(usize) -> bool) -> Option<usize> {
        let at = Aabb::new(to_parry(point), to_parry(point));
        let found = self.tree.intersect_aabb(&at).map(|leaf| self.elements[leaf as usize] as usize);
        found.filter(|&e| takes(e) && self.contains(e, point)).min()
    }

    fn contains(&self, element: usize, point: &Vec3) -> bool {
        let cell = self.cells.get(element);
        contains(cell.kind, &cell.points(self.x), point)
    }
}

fn to_parry(p: &Vec3) -> Vector {
    Vector::new(p.x, p.y, p.z)
}

fn aabb(points: &[Vec3]) -> Aabb {
    let nothing = (Vec3::repeat(f64::INFINITY), Vec3::repeat(f64::NEG_INFINITY));
    let (low, high) = points.iter().fold(nothing, |(low, high), x| (low.inf(x), high.sup(x)));
    Aabb::new(to_parry(&low), to_parry(&high))
}

/// Whether x(ξ) = p has a solution in the reference cell, by Newton's method; false for an element crushed so far that
/// there is none.
fn contains(kind: CellKind, x: &[Vec3], point: &Vec3) -> bool {
    let table = kind.table();
    let mut xi = Vec3::from(table.centre);
    for _ in 0..MOST_STEPS {
        let at = [xi.x, xi.y, xi.z];
        let map = (table.jacobian)(x, at);
        let Some(step) = map.lu().solve(&(point - (table.place)(x, at))) else { return false };
        xi += step;
        if !(xi.amax() <= FAR) {
            return false;
        }
        if step.amax() <= 1e-12 {
            // A folded corner covers other positions a second time.
            return kind.contains(&xi) && map.determinant() > 0.0;
        }
    }
    false
}

#[cfg(test)]
#[allow(clippy::unwrap_used)] // tests may panic
mod tests {
    use super::super::generate::block::Block;
    use super::*;

    #[test]
    fn a_box_that_few_elements_meet_finds_these() {
        let mesh =
            Block::uniform(Vec3::zeros(), Vec3::new(3.0, 1.0, 1.0), [3, 1, 1], "b").generate().unwrap();
        for (low, high, found) in
            [(2.5, 2.6, Some(2)), (1.5, 2.6, Some(2)), (0.1, 2.6, Some(2)), (5.0, 6.0, None)]
        {
            let place = [Vec3::new(low, 0.4, 0.4), Vec3::new(high, 0.6, 0.6)];
            let locator = Locator::within(&place, &mesh.cells, &mesh.nodes);
            assert_eq!(locator.element_at(&place[1], |_| true), found);
        }
    }

    #[test]
    fn elements_near_a_box_are_those_whose_bounding_boxes_meet_it() {
        let mesh =
            Block::uniform(Vec3::zeros(), Vec3::new(3.0, 2.0, 1.0), [4, 3, 2], "b").generate().unwrap();
        let x: Vec<Vec3> =
            mesh.nodes.iter().map(|p| Vec3::new(p.x + 0.3 * p.y, p.y, p.z - 0.2 * p.x)).collect();
        for k in 0..60 {
            let t = f64::from(k);
            let low =
                Vec3::new(5.0 * (0.618_034 * t).fract() - 1.0, 3.0 * (0.754_878 * t).fract() - 0.5, -0.5);
            let high = low + Vec3::new(0.1 * (t % 7.0), 0.4, 0.1 * (t % 11.0));
            let meets = |element: &u32| {
                let corners = mesh.cells.get(*element as usize).points(&x);
                let extreme =
                    |i: usize, of: fn(f64, f64) -> f64| corners.iter().map(|p| p[i]).reduce(of).unwrap();
                (0..3).all(|i| extreme(i, f64::min) <= high[i] && extreme(i, f64::max) >= low[i])
            };
            let expected: Vec<u32> = (0..mesh.cells.len() as u32).filter(meets).collect();
            assert_eq!(elements_near(&[low, high], &mesh.cells, &x), expected, "{low:?}");
        }
    }

    #[test]
    fn points_of_a_bent_block_are_found_in_the_elements_that_they_come_from() {
        let mesh =
            Block::uniform(Vec3::zeros(), Vec3::new(3.0, 2.0, 1.0), [4, 3, 2], "b").generate().unwrap();
        let bent = |p: &Vec3| {
            let (sine, cosine) = (0.6 * p.x).sin_cos();
            Vec3::new((p.z + 3.0) * sine, p.y + 0.1 * p.x * p.z, (p.z + 3.0) * cosine)
        };
        let x: Vec<Vec3> = mesh.nodes.iter().map(bent).collect();
        let locator = Locator::within(&[Vec3::repeat(-10.0), Vec3::repeat(10.0)], &mesh.cells, &x);
        for (element, cell) in mesh.cells.iter().enumerate() {
            for k in 0..20 {
                let t = f64::from(k);
                let xi = [0.618_034, 0.754_878, 0.569_840].map(|step| 1.9 * (t * step).fract() - 0.95);
                let point = (cell.kind.table().place)(&cell.points(&x), xi);
                assert_eq!(locator.element_at(&point, |_| true), Some(element));
                assert_eq!(locator.element_at(&point, |e| e != element), None);
            }
        }
        assert_eq!(locator.element_at(&Vec3::new(0.0, 1.0, 2.9), |_| true), None, "below the inner side");
    }
}
