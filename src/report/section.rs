//! The section of a body with a plane: polygons with values, the lines between its parts, and lines of equal value.

use super::instant::Body;
use std::collections::BTreeMap;

/// A plane with the directions of the picture: to the right and up, both unit vectors in it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Plane {
    /// Point of the plane, the origin of the picture [m].
    pub origin: [f64; 3],
    /// Unit normal of the plane; heights are measured along it.
    pub normal: [f64; 3],
    /// Direction to the right of the picture, a unit vector.
    pub right: [f64; 3],
    /// Direction up in the picture, a unit vector.
    pub up: [f64; 3],
}

/// A corner of the section: to the right and up in the picture [m], and the value there.
pub type Corner = ([f64; 2], f64);

/// A line of the section [m].
pub type Line = [[f64; 2]; 2];

/// The section of a body.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Section {
    /// A convex polygon for each cell that the plane cuts, with the part of the cell.
    pub polygons: Vec<(u32, Vec<Corner>)>,
    /// Lines between parts, and around the body.
    pub outlines: Vec<Line>,
}

pub(super) fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

pub(super) fn minus(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    std::array::from_fn(|k| a[k] - b[k])
}

impl Plane {
    /// Signed distance of a point [m].
    pub fn height(&self, point: [f64; 3]) -> f64 {
        dot(self.normal, minus(point, self.origin))
    }

    /// Place of a point in the picture [m].
    pub fn place(&self, point: [f64; 3]) -> [f64; 2] {
        let arm = minus(point, self.origin);
        [dot(self.right, arm), dot(self.up, arm)]
    }

    /// Where the plane cuts the edge between two points, and the fraction of the way there; `None` if it does not.
    fn cut(&self, a: [f64; 3], b: [f64; 3]) -> Option<([f64; 2], f64)> {
        let (from, to) = (self.height(a), self.height(b));
        if (from > 0.0) == (to > 0.0) {
            return None;
        }
        let fraction = from / (from - to);
        Some((self.place(std::array::from_fn(|k| a[k] + fraction * (b[k] - a[k]))), fraction))
    }

    /// The line in which the plane cuts a triangle.
    pub fn cut_triangle(&self, corners: &[[f64; 3]; 3]) -> Option<Line> {
        let [a, b, c] = *corners;
        let ends: Vec<[f64; 2]> =
            [(a, b), (b, c), (c, a)].iter().filter_map(|&(a, b)| Some(self.cut(a, b)?.0)).collect();
        ends.try_into().ok()
    }
}

impl Section {
    /// The section of a body without its eroded cells; without recorded stress all values are 0.
    pub fn of(body: &Body, plane: &Plane) -> Self {
        let mut section = Self::default();
        // Faces that the plane cuts, unless the cells on both sides are of one part: the line, and the part on one side.
        let mut faces: BTreeMap<Vec<u32>, (Line, u32)> = BTreeMap::new();
        let is_intact = |cell: usize| body.eroded.get(cell).is_none_or(|&gone| gone == 0);
        let cells = body.cells.iter().zip(&body.part_of).enumerate();
        for (_, (cell, &part)) in cells.filter(|(index, _)| is_intact(*index)) {
            let at = |corner: usize| body.positions[cell.nodes[corner] as usize];
            let value =
                |corner: usize| body.stress.get(cell.nodes[corner] as usize).copied().unwrap_or_default();
            let corners = cell.kind.table().edges.iter().filter_map(|&[a, b]| {
                let (place, fraction) = plane.cut(at(a), at(b))?;
                Some((place, value(a) + fraction * (value(b) - value(a))))
            });
            let corners: Vec<Corner> = corners.collect();
            if corners.len() < 3 {
                continue;
            }
            section.polygons.push((part, around(corners)));
            for face in cell.kind.table().faces {
                let count = face.corners.len();
                let ends = (0..count).filter_map(|i| {
                    let (a, b) = (face.corners[i], face.corners[(i + 1) % count]);
                    Some(plane.cut(at(a), at(b))?.0)
                });
                let Ok(line) = <Line>::try_from(ends.collect::<Vec<_>>()) else { continue };
                let mut key: Vec<u32> = face.corners.iter().map(|&corner| cell.nodes[corner]).collect();
                key.sort_unstable();
                if faces.remove(&key).is_none_or(|(_, other)| other != part) {
                    faces.insert(key, (line, part));
                }
            }
        }
        section.outlines = faces.into_values().map(|(line, _)| line).collect();
        section
    }
}

/// The corners of a convex polygon in their order around it.
fn around(mut corners: Vec<Corner>) -> Vec<Corner> {
    let count = corners.len() as f64;
    let [x, y] = [0, 1].map(|k| corners.iter().map(|(at, _)| at[k]).sum::<f64>() / count);
    let angle = |(at, _): &Corner| (at[1] - y).atan2(at[0] - x);
    corners.sort_by(|a, b| angle(a).total_cmp(&angle(b)));
    corners
}

/// The part of a convex polygon with values from `low` to `high`, linear along its edges.
pub fn band(polygon: &[Corner], low: f64, high: f64) -> Vec<Corner> {
    let above = clipped(polygon, |value| value - low);
    clipped(&above, |value| high - value)
}

/// The part of a polygon in which a function of the value is positive.
fn clipped(polygon: &[Corner], inside: impl Fn(f64) -> f64) -> Vec<Corner> {
    let mut kept = Vec::new();
    for (i, &(a, v)) in polygon.iter().enumerate() {
        let (b, w) = polygon[(i + 1) % polygon.len()];
        let (from, to) = (inside(v), inside(w));
        if from >= 0.0 {
            kept.push((a, v));
        }
        if (from >= 0.0) != (to >= 0.0) {
            let f = from / (from - to);
            kept.push(([a[0] + f * (b[0] - a[0]), a[1] + f * (b[1] - a[1])], v + f * (w - v)));
        }
    }
    kept
}

/// The line of equal value through a convex polygon; `None` if it does not pass.
pub fn level(polygon: &[Corner], value: f64) -> Option<Line> {
    let ends = (0..polygon.len()).filter_map(|i| {
        let ((a, v), (b, w)) = (polygon[i], polygon[(i + 1) % polygon.len()]);
        let f = (value - v) / (w - v);
        ((v > value) != (w > value)).then(|| [a[0] + f * (b[0] - a[0]), a[1] + f * (b[1] - a[1])])
    });
    ends.collect::<Vec<_>>().try_into().ok()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::{CellKind, Cells};

    /// Two cubes on top of each other, of different parts; the value is the height.
    fn tower() -> Body {
        let mut cells = Cells::default();
        cells.push(CellKind::Hex8, &[0, 1, 2, 3, 4, 5, 6, 7]);
        cells.push(CellKind::Hex8, &[4, 5, 6, 7, 8, 9, 10, 11]);
        let square = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
        let layer = |z: f64| square.map(|[x, y]| [x, y, z]);
        let positions: Vec<[f64; 3]> = [0.0, 1.0, 2.0].into_iter().flat_map(layer).collect();
        let stress = positions.iter().map(|at| at[2]).collect();
        Body { cells, part_of: vec![0, 1], rest: positions.clone(), positions, stress, ..Body::default() }
    }

    fn plane() -> Plane {
        Plane {
            origin: [0.0, 0.4, 0.0],
            normal: [0.0, -1.0, 0.0],
            right: [1.0, 0.0, 0.0],
            up: [0.0, 0.0, 1.0],
        }
    }

    #[test]
    fn a_section_has_a_polygon_for_each_cell_and_lines_between_parts() {
        let section = Section::of(&tower(), &plane());
        assert_eq!(
            section.polygons.iter().map(|(part, corners)| (*part, corners.len())).collect::<Vec<_>>(),
            [(0, 4), (1, 4)]
        );
        for (part, corners) in &section.polygons {
            for (at, value) in corners {
                assert!((at[1] - value).abs() < 1e-12 && *value >= f64::from(*part));
            }
        }
        // Three sides of each square, and one between them.
        assert_eq!(section.outlines.len(), 7);
        // Without the upper one, the four sides of the lower.
        let eroded = Section::of(&Body { eroded: vec![0, 1], ..tower() }, &plane());
        assert_eq!(eroded.polygons, section.polygons[..1]);
        assert_eq!(eroded.outlines.len(), 4);
    }

    #[test]
    fn bands_and_levels_divide_a_polygon() {
        let square: Vec<Corner> =
            vec![([0.0, 0.0], 0.0), ([1.0, 0.0], 0.0), ([1.0, 1.0], 1.0), ([0.0, 1.0], 1.0)];
        let strip = band(&square, 0.25, 0.5);
        assert_eq!(strip.len(), 4);
        assert!(
            strip.iter().all(|(at, value)| (at[1] - value).abs() < 1e-12 && (0.25..=0.5).contains(value))
        );
        assert_eq!(level(&square, 0.5).map(|line| line.map(|end| end[1])), Some([0.5, 0.5]));
        assert_eq!(level(&square, 2.0), None);
        assert!(band(&square, 2.0, 3.0).is_empty());
    }
}
