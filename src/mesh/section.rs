//! Section of a mesh or of a scan by a plane across x, y or z: the outlines of its parts, to draw them.

use super::cell::CellKind;
use super::read::stl::ClosedSurface;
use super::segmentation::{LabelCount, LabelVolume};
use super::{Mesh, MeshError};
use crate::mechanics::tensor::Vec3;
use serde::{Deserialize, Serialize};
use std::collections::{BTreeMap, BTreeSet};

/// Fraction of the extent to which points are rounded: those that coincide then are one.
const ROUNDING: f64 = 1e-5;
/// Largest number of cells along an axis of a scan: several voxels are one if there are more.
const CELLS_OF_SCAN: usize = 128;
/// Largest number of points of all outlines.
const MOST_POINTS: usize = 100_000;

/// A plane across an axis.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Plane {
    /// Number of the axis that it is perpendicular to.
    pub axis: usize,
    /// Its coordinate on that axis, in the unit of the mesh; `None`: in the middle.
    pub at: Option<f64>,
}

/// Outlines of the parts in a plane. Lengths are in the unit of the file; of a scan, in metres.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "service", derive(utoipa::ToSchema))]
pub struct Section {
    /// Coordinate of the plane.
    pub at: f64,
    /// The parts that it cuts.
    pub parts: Vec<PartSection>,
}

/// The outlines of a part, or of a label of a scan.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "service", derive(utoipa::ToSchema))]
pub struct PartSection {
    /// Name of the part, as the mesh has it.
    pub part: String,
    /// Label of the scan.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub label: Option<i64>,
    /// Closed lines around it, and the other way round around what is not of it. Their points have the coordinates on the other two axes.
    pub outlines: Vec<Vec<[f64; 2]>>,
}

impl Section {
    /// Outlines of the parts of a mesh in the plane.
    ///
    /// # Errors
    /// `Unsupported` for outlines of too many points.
    pub fn of_mesh(mesh: &Mesh, plane: Plane) -> Result<Self, MeshError> {
        let bounds = mesh.bounding_box().unwrap_or([Vec3::zeros(); 2]);
        let mut cut = Cut::new(plane, bounds, mesh.parts.len());
        for (element, cell) in mesh.cells.iter().enumerate() {
            let table = cell.kind.table();
            let corners: Vec<Vec3> =
                cell.nodes[..table.corners].iter().map(|node| mesh.nodes[*node as usize]).collect();
            cut.take(mesh.part_of[element] as usize, &corners, table.edges);
        }
        cut.section(mesh.parts.iter().map(|part| (part.clone(), None)))
    }

    /// Outline of a closed surface in the plane, as one part.
    ///
    /// # Errors
    /// `Unsupported` for outlines of too many points.
    pub fn of_surface(surface: &ClosedSurface, plane: Plane) -> Result<Self, MeshError> {
        let mut cut = Cut::new(plane, surface.bounding_box(), 1);
        for triangle in &surface.triangles {
            cut.take_triangle(0, &triangle.map(|node| surface.points[node as usize]));
        }
        cut.section(std::iter::once(("surface".to_owned(), None)))
    }

    /// Outlines of the labels of a scan in the plane.
    ///
    /// # Errors
    /// `Unsupported` for a grid with shear, and for outlines of too many points.
    pub fn of_scan(volume: &LabelVolume, plane: Plane) -> Result<Self, MeshError> {
        let frame = volume.frame()?;
        let counts: Vec<LabelCount> = volume.counts().into_iter().filter(|count| count.label != 0).collect();
        let part_of: BTreeMap<i64, usize> = counts.iter().map(|count| count.label).zip(0..).collect();
        let lengths = frame.lengths();
        let end = |n: u8| Vec3::from_fn(|k, _| if n >> k & 1 == 1 { lengths[k] } else { 0.0 });
        let ends = (0..8).map(|n| frame.world(&end(n)));
        let bounds = ends.fold([frame.corner; 2], |[low, high], x| [low.inf(&x), high.sup(&x)]);
        let mut cut = Cut::new(plane, bounds, counts.len());
        let steps = frame.dims.map(|n| n.div_ceil(CELLS_OF_SCAN));
        let table = CellKind::Hex8.table();
        let [is, js, ks] = [0, 1, 2].map(|k| (0..frame.dims[k]).step_by(steps[k]));
        let cells = ks
            .flat_map(|k| js.clone().map(move |j| [j, k]))
            .flat_map(|[j, k]| is.clone().map(move |i| [i, j, k]));
        for first in cells {
            let middle = [0, 1, 2].map(|k| (first[k] + steps[k] / 2).min(frame.dims[k] - 1));
            let label = volume.values[usize::from(volume.labels[frame.index(middle)])];
            let Some(&part) = part_of.get(&label) else { continue };
            let corners: Vec<Vec3> = table.points[..table.corners]
                .iter()
                .map(|xi| {
                    let index = |k: usize| if xi[k] > 0.0 { first[k] + steps[k] } else { first[k] };
                    frame.world(&Vec3::from_fn(|k, _| index(k).min(frame.dims[k]) as f64 * frame.spacing[k]))
                })
                .collect();
            cut.take(part, &corners, table.edges);
        }
        cut.section(counts.iter().map(|count| (count.part(), Some(count.label))))
    }
}

/// A point of the plane, in units of the rounding.
type Point = [i64; 2];

/// Collects the outlines of parts: the edges of the polygons in which the plane cuts cells, without those between two of a part.
struct Cut {
    axis: usize,
    at: f64,
    /// Units of the rounding in one of the mesh: a power of ten, so that coordinates have few digits.
    per_unit: f64,
    edges: Vec<BTreeSet<[Point; 2]>>,
}

impl Cut {
    fn new(plane: Plane, [low, high]: [Vec3; 2], parts: usize) -> Self {
        let extent = (high - low).amax();
        let digits = if extent > 0.0 { -(extent * ROUNDING).log10().floor() } else { 0.0 };
        Self {
            axis: plane.axis,
            at: plane.at.unwrap_or(0.5 * (low + high)[plane.axis]),
            per_unit: 10_f64.powf(digits),
            edges: vec![BTreeSet::new(); parts],
        }
    }

    /// Cuts a convex cell of a part.
    fn take(&mut self, part: usize, corners: &[Vec3], edges: &[[usize; 2]]) {
        let mut points: Vec<Point> = Vec::new();
        points.extend(edges.iter().filter_map(|[a, b]| self.crossing(&corners[*a], &corners[*b])));
        points.sort_unstable();
        points.dedup();
        if points.len() < 3 {
            return;
        }
        // Counter-clockwise around their mean.
        let mean = |k: usize| points.iter().map(|point| point[k] as f64).sum::<f64>() / points.len() as f64;
        let centre = [mean(0), mean(1)];
        points.sort_by(|a, b| {
            let angle = |p: &Point| (p[1] as f64 - centre[1]).atan2(p[0] as f64 - centre[0]);
            angle(a).total_cmp(&angle(b))
        });
        for (i, &start) in points.iter().enumerate() {
            self.add(part, [start, points[(i + 1) % points.len()]]);
        }
    }

    /// Cuts a triangle of the surface of a part, counter-clockwise seen from outside.
    fn take_triangle(&mut self, part: usize, corners: &[Vec3; 3]) {
        let is_below = |i: usize| corners[i % 3][self.axis] < self.at;
        let edge = |from: bool| (0..3).find(|i| is_below(*i) == from && is_below(i + 1) != from);
        let crossing = |i: usize| self.crossing(&corners[i], &corners[(i + 1) % 3]);
        let ends = [true, false].map(|from| edge(from).and_then(crossing));
        let [Some(upwards), Some(downwards)] = ends else { return };
        // What is inside lies to the left of the way from the edge that is passed downwards to the other, seen from above; x and z are
        // seen from below.
        let edge = if self.axis == 1 { [upwards, downwards] } else { [downwards, upwards] };
        if upwards != downwards {
            self.add(part, edge);
        }
    }

    /// Adds an edge of the outline of a part, or removes the one the other way round.
    fn add(&mut self, part: usize, [start, end]: [Point; 2]) {
        if !self.edges[part].remove(&[end, start]) {
            self.edges[part].insert([start, end]);
        }
    }

    /// Where the line between two points crosses the plane; the same point either way.
    fn crossing(&self, a: &Vec3, b: &Vec3) -> Option<Point> {
        let height = |x: &Vec3| x[self.axis] - self.at;
        let [below, above] = if height(a) < height(b) { [a, b] } else { [b, a] };
        let is_crossed = height(below) < 0.0 && height(above) >= 0.0;
        let along = height(below) / (height(below) - height(above));
        is_crossed.then(|| self.rounded(&(below + (above - below) * along)))
    }

    #[allow(clippy::cast_possible_truncation)] // saturates
    fn rounded(&self, point: &Vec3) -> Point {
        let mut others = (0..3).filter(|axis| *axis != self.axis);
        [(); 2].map(|()| others.next().map_or(0, |axis| (point[axis] * self.per_unit).round() as i64))
    }

    fn section(self, names: impl Iterator<Item = (String, Option<i64>)>) -> Result<Section, MeshError> {
        let back = |point: Point| point.map(|c| c as f64 / self.per_unit);
        let mut left = MOST_POINTS;
        let mut parts = Vec::new();
        for ((part, label), edges) in names.zip(self.edges) {
            let outlines: Vec<Vec<[f64; 2]>> =
                chained(edges).into_iter().map(|line| line.into_iter().map(back).collect()).collect();
            let count: usize = outlines.iter().map(Vec::len).sum();
            left = left.checked_sub(count).ok_or_else(|| MeshError::Unsupported {
                what: format!("a section whose outlines have more than {MOST_POINTS} points"),
                remedy: "take a plane elsewhere, or smooth the labels".into(),
            })?;
            if !outlines.is_empty() {
                parts.push(PartSection { part, label, outlines });
            }
        }
        Ok(Section { at: self.at, parts })
    }
}

/// The closed lines that edges form, without points on a straight line between their neighbours.
fn chained(mut edges: BTreeSet<[Point; 2]>) -> Vec<Vec<Point>> {
    let mut lines = Vec::new();
    while let Some([start, mut end]) = edges.pop_first() {
        let mut line = vec![start];
        while end != start {
            line.push(end);
            let next = edges.range([end, [i64::MIN; 2]]..).next().copied();
            let Some(next) = next.filter(|next| next[0] == end) else { break };
            edges.remove(&next);
            end = next[1];
        }
        let is_corner = |i: usize| {
            let [before, here, after] = [i + line.len() - 1, i, i + 1].map(|i| line[i % line.len()]);
            let along = |k: usize, from: Point, to: Point| i128::from(to[k]) - i128::from(from[k]);
            along(0, before, here) * along(1, here, after) != along(1, before, here) * along(0, here, after)
        };
        let corners: Vec<Point> = (0..line.len()).filter(|i| is_corner(*i)).map(|i| line[i]).collect();
        if corners.len() > 2 {
            lines.push(corners);
        }
    }
    lines
}

#[cfg(test)]
#[allow(clippy::float_cmp, clippy::unwrap_used)] // tests may panic
mod tests {
    use super::*;
    use crate::mesh::generate::hollow_ball::HollowBall;

    fn area(outlines: &[Vec<[f64; 2]>]) -> f64 {
        let of_line = |line: &Vec<[f64; 2]>| {
            let doubled = |i: usize| {
                let [[x0, y0], [x1, y1]] = [line[i], line[(i + 1) % line.len()]];
                x0 * y1 - x1 * y0
            };
            0.5 * (0..line.len()).map(doubled).sum::<f64>()
        };
        outlines.iter().map(of_line).sum()
    }

    #[test]
    fn a_ball_is_cut_in_two_rings_with_the_hole_the_other_way_round() {
        let mesh = HollowBall {
            center_m: [0.0; 3],
            outer_radius_m: 0.02,
            inner_radius_m: 0.01,
            elements_around: 8,
            elements_through: 2,
        };
        let mesh = mesh.generate().unwrap();
        let section = Section::of_mesh(&mesh, Plane { axis: 1, at: Some(1e-4) }).unwrap();
        let [ball] = &section.parts[..] else { panic!("{:?}", section.parts) };
        assert_eq!((ball.part.as_str(), ball.outlines.len()), ("ball", 2));
        let ring = std::f64::consts::PI * (4e-4 - 1e-4);
        assert!((area(&ball.outlines) / ring - 1.0).abs() < 0.05, "{} of {ring}", area(&ball.outlines));
        let beside = Section::of_mesh(&mesh, Plane { axis: 1, at: Some(0.03) }).unwrap();
        assert_eq!(beside.parts, []);
    }

    #[test]
    fn a_surface_is_cut_as_the_body_in_it_is() {
        use crate::mechanics::rigid::{Shape, triangulated};
        let (points, triangles) = triangulated(&Shape::Box { half: Vec3::new(3.0, 2.0, 1.0) });
        let brick = ClosedSurface { points, triangles };
        let sides = [3.0, 2.0, 1.0];
        for axis in 0..3 {
            let section = Section::of_surface(&brick, Plane { axis, at: Some(0.3) }).unwrap();
            let [part] = &section.parts[..] else { panic!("{:?}", section.parts) };
            let expected = 4.0 * sides.iter().product::<f64>() / sides[axis];
            assert_eq!((part.outlines.len(), part.outlines[0].len()), (1, 4));
            assert!((area(&part.outlines) - expected).abs() < 1e-6, "{axis}: {:?}", part.outlines);
        }
        let beside = Section::of_surface(&brick, Plane { axis: 2, at: Some(1.5) }).unwrap();
        assert_eq!(beside.parts, []);
    }

    #[test]
    fn a_column_of_labels_is_cut_across_and_along() {
        // 2 × 1 × 1 mm of label 4 beside as much of label 7 along x, in voxels of 1 mm, between empty ones.
        let labels = (0..12).map(|n| if n / 4 == 1 { [1, 1, 2, 2][n % 4] } else { 0 }).collect();
        let volume = LabelVolume {
            dims: [4, 3, 1],
            labels,
            values: vec![0, 4, 7],
            names: BTreeMap::from([(7, "fat".to_owned())]),
            origin: Vec3::repeat(5e-4),
            steps: [Vec3::x() * 1e-3, Vec3::y() * 1e-3, Vec3::z() * 1e-3],
            notes: Vec::new(),
        };
        let along = Section::of_scan(&volume, Plane { axis: 2, at: None }).unwrap();
        assert_eq!(along.at, 5e-4);
        let names: Vec<_> = along.parts.iter().map(|part| (part.part.as_str(), part.label)).collect();
        assert_eq!(names, [("label_4", Some(4)), ("fat", Some(7))]);
        assert_eq!(
            along.parts[1].outlines,
            [[[0.002, 0.001], [0.004, 0.001], [0.004, 0.002], [0.002, 0.002]]]
        );
        let across = Section::of_scan(&volume, Plane { axis: 0, at: Some(1e-3) }).unwrap();
        assert_eq!(across.parts.len(), 1);
        assert!((area(&across.parts[0].outlines) - 1e-6).abs() < 1e-15);
    }
}
