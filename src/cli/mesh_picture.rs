//! Picture of a mesh or of a scan: its surface in one oblique view, a colour for each part, the worst elements marked.

use crate::mechanics::tensor::Vec3;
use crate::mesh::inspect::WorstElement;
use crate::mesh::names::shortened;
use crate::mesh::segmentation::{LabelCount, LabelVolume};
use crate::mesh::{Mesh, MeshError, surface::Boundary};
use crate::study::palette::COLOURS;
use plotters::style::RGBColor;
use std::collections::BTreeMap;
use std::fmt::Write as _;

/// Size of the view [px], and of the legend beside it.
const WIDTH: f64 = 760.0;
const HEIGHT: f64 = 600.0;
const LEGEND: f64 = 220.0;
const EDGE: f64 = 30.0;
/// Number of faces that are drawn as polygons; more are drawn as squares of the size of [`CELL`], so that the picture stays small.
const MOST_POLYGONS: usize = 12_000;
const CELL: f64 = 2.5;
/// Number of shades of a colour, and the darkest of them relative to the brightest.
const SHADES: u8 = 12;
const DARKEST: f64 = 0.45;
/// Number of parts in the legend.
const MOST_NAMES: usize = 24;

/// What is drawn: faces of a surface, seen from outside counter-clockwise, each with the number of its part.
#[derive(Debug, Default)]
pub(super) struct Faces {
    faces: Vec<([Vec3; 4], usize)>,
    names: Vec<String>,
}

impl Faces {
    /// The boundary surface of a mesh.
    pub(super) fn of_mesh(mesh: &Mesh) -> Self {
        let boundary = Boundary::of(&mesh.cells);
        let at = |(face, owner): (&[u32; 4], &u32)| {
            (face.map(|node| mesh.nodes[node as usize]), mesh.part_of[*owner as usize] as usize)
        };
        Self {
            faces: boundary.faces.iter().zip(&boundary.owner).map(at).collect(),
            names: mesh.parts.clone(),
        }
    }

    /// The sides of labelled voxels that have none beside them.
    ///
    /// # Errors
    /// `Unsupported` for a grid with shear.
    pub(super) fn of_scan(volume: &LabelVolume) -> Result<Self, MeshError> {
        let frame = volume.frame()?;
        let names = volume.counts().iter().filter(|count| count.label != 0).map(LabelCount::part).collect();
        let part_of: BTreeMap<i64, usize> =
            volume.counts().iter().map(|count| count.label).filter(|label| *label != 0).zip(0..).collect();
        let label = |voxel: [usize; 3]| volume.values[usize::from(volume.labels[frame.index(voxel)])];
        let corner = |voxel: [usize; 3], on: Vec3| {
            let index = Vec3::from_fn(|k, _| voxel[k] as f64 + on[k]);
            frame.world(&index.component_mul(&Vec3::from(frame.spacing)))
        };
        let mut faces = Vec::new();
        for voxel in frame.voxels() {
            let Some(&part) = part_of.get(&label(voxel)) else { continue };
            for (axis, is_high) in (0..3).flat_map(|axis| [(axis, false), (axis, true)]) {
                let is_end = if is_high { voxel[axis] + 1 == frame.dims[axis] } else { voxel[axis] == 0 };
                let mut beside = voxel;
                beside[axis] = if is_high { voxel[axis] + 1 } else { voxel[axis].saturating_sub(1) };
                if !is_end && label(beside) != 0 {
                    continue;
                }
                let [u, v] = [Vec3::ith((axis + 1) % 3, 1.0), Vec3::ith((axis + 2) % 3, 1.0)];
                let base = Vec3::ith(axis, if is_high { 1.0 } else { 0.0 });
                let around =
                    if is_high { [Vec3::zeros(), u, u + v, v] } else { [Vec3::zeros(), v, u + v, u] };
                faces.push((around.map(|on| corner(voxel, base + on)), part));
            }
        }
        Ok(Self { faces, names })
    }

    /// The picture as SVG, with the worst elements of the mesh.
    pub(super) fn svg(&self, title: &str, worst: &[WorstElement]) -> String {
        let view = View::of(&self.faces);
        let mut seen: Vec<Seen> =
            self.faces.iter().filter_map(|(corners, part)| view.face(corners, *part)).collect();
        seen.sort_by(|a, b| a.depth.total_cmp(&b.depth));
        let mut svg = format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {} {HEIGHT}\" font-family=\"sans-serif\" font-size=\"13\">\n\
             <title>{}</title>\n<rect width=\"100%\" height=\"100%\" fill=\"#fff\"/>\n",
            WIDTH + LEGEND,
            escaped(title)
        );
        if seen.len() <= MOST_POLYGONS {
            polygons(&seen, &mut svg);
        } else {
            squares(&seen, &mut svg);
        }
        axes(&view, &mut svg);
        for (rank, element) in worst.iter().enumerate() {
            let [x, y, _] = view.place(&Vec3::from(element.centre));
            let _ = writeln!(
                svg,
                "<circle cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"7\" fill=\"none\" stroke=\"#b00020\" stroke-width=\"2\"/>\
                 <text x=\"{:.1}\" y=\"{:.1}\" fill=\"#b00020\">{}</text>",
                x + 9.0,
                y - 5.0,
                rank + 1
            );
        }
        self.legend(worst, &mut svg);
        svg + "</svg>\n"
    }

    fn legend(&self, worst: &[WorstElement], svg: &mut String) {
        let mut y = EDGE;
        let mut line = |mark: &str, text: &str, svg: &mut String| {
            let _ = writeln!(
                svg,
                "{}<text x=\"{}\" y=\"{y}\">{}</text>",
                mark.replace('@', &(y - 10.0).to_string()),
                WIDTH + 18.0,
                escaped(text)
            );
            y += 19.0;
        };
        for (part, name) in self.names.iter().take(MOST_NAMES).enumerate() {
            let square = format!(
                "<rect x=\"{WIDTH}\" y=\"@\" width=\"12\" height=\"12\" fill=\"{}\"/>",
                colour(part, SHADES)
            );
            line(&square, &shortened(name).chars().take(26).collect::<String>(), svg);
        }
        if self.names.len() > MOST_NAMES {
            line("", &format!("and {} more parts", self.names.len() - MOST_NAMES), svg);
        }
        if !worst.is_empty() {
            line("", "", svg);
            line("", "worst: scaled Jacobian", svg);
        }
        for (rank, element) in worst.iter().enumerate() {
            line(
                "",
                &format!("{}: element {} ({:.3})", rank + 1, element.element, element.scaled_jacobian),
                svg,
            );
        }
    }
}

/// A face that is seen.
struct Seen {
    /// Corners [px].
    corners: [[f64; 2]; 4],
    /// Nearness to the reader of its middle.
    depth: f64,
    part: usize,
    shade: u8,
}

/// The oblique view: from the right, the front and above, with z up.
struct View {
    right: Vec3,
    up: Vec3,
    towards: Vec3,
    middle: Vec3,
    scale: f64,
}

impl View {
    fn of(faces: &[([Vec3; 4], usize)]) -> Self {
        let towards = Vec3::new(0.55, -0.65, 0.52).normalize();
        let right = Vec3::z().cross(&towards).normalize();
        let up = towards.cross(&right);
        let range = |axis: &Vec3| {
            let along = faces.iter().flat_map(|(corners, _)| corners).map(|x| x.dot(axis));
            along.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], x| [low.min(x), high.max(x)])
        };
        let [across, height, depth] = [range(&right), range(&up), range(&towards)];
        let middle = [(right, across), (up, height), (towards, depth)]
            .iter()
            .map(|(axis, [low, high])| *axis * 0.5 * (low + high))
            .sum::<Vec3>();
        let [w, h] = [(WIDTH, across), (HEIGHT, height)]
            .map(|(pixels, [low, high])| (pixels - 2.0 * EDGE) / (high - low).max(f64::MIN_POSITIVE));
        let scale = w.min(h);
        let is_sound = scale.is_finite() && middle.iter().all(|x| x.is_finite());
        let (scale, middle) = if is_sound { (scale, middle) } else { (1.0, Vec3::zeros()) };
        Self { right, up, towards, middle, scale }
    }

    /// Place in the picture [px], and nearness to the reader.
    fn place(&self, x: &Vec3) -> [f64; 3] {
        let from = (x - self.middle) * self.scale;
        [0.5 * WIDTH + from.dot(&self.right), 0.5 * HEIGHT - from.dot(&self.up), from.dot(&self.towards)]
    }

    /// A face, if its outside is seen; the light comes from above, left of the reader.
    fn face(&self, corners: &[Vec3; 4], part: usize) -> Option<Seen> {
        let normal = (corners[2] - corners[0]).cross(&(corners[3] - corners[1]));
        // A triangle has its last corner twice, which does not change the direction.
        let normal = normal.try_normalize(0.0)?;
        (normal.dot(&self.towards) > 0.0).then_some(())?;
        let light = (self.towards + 0.6 * self.up - 0.35 * self.right).normalize();
        let brightness = DARKEST + (1.0 - DARKEST) * normal.dot(&light).max(0.0);
        let placed = corners.map(|x| self.place(&x));
        Some(Seen {
            corners: placed.map(|[x, y, _]| [x, y]),
            depth: 0.25 * placed.iter().map(|[_, _, depth]| depth).sum::<f64>(),
            part,
            shade: (brightness * f64::from(SHADES)).round() as u8,
        })
    }
}

/// Faces as polygons, the nearest last.
fn polygons(seen: &[Seen], svg: &mut String) {
    *svg += "<g stroke=\"#22262c\" stroke-width=\"0.4\" stroke-linejoin=\"round\">\n";
    for face in seen {
        let points = face.corners.map(|[x, y]| format!("{x:.1},{y:.1}")).join(" ");
        let _ = writeln!(svg, "<polygon points=\"{points}\" fill=\"{}\"/>", colour(face.part, face.shade));
    }
    *svg += "</g>\n";
}

/// Faces as squares, of which each has the colour of the nearest face at its centre; the squares of a row that are alike are one.
fn squares(seen: &[Seen], svg: &mut String) {
    let [columns, rows] = [WIDTH, HEIGHT].map(|pixels| (pixels / CELL) as usize);
    let mut cells: Vec<Option<(usize, u8)>> = vec![None; columns * rows];
    for face in seen {
        let range = |axis: usize, count: usize| {
            let along = face.corners.map(|corner| corner[axis] / CELL);
            let [low, high] = [
                along.iter().fold(f64::INFINITY, |a, b| a.min(*b)),
                along.iter().fold(0.0, |a: f64, b| a.max(*b)),
            ];
            (low.max(0.0) as usize)..((high as usize) + 1).min(count)
        };
        let own = (range(0, columns), range(1, rows));
        let is_small = own.0.len() <= 2 && own.1.len() <= 2;
        for (row, column) in own.1.flat_map(|row| own.0.clone().map(move |column| (row, column))) {
            let centre = [(column as f64 + 0.5) * CELL, (row as f64 + 0.5) * CELL];
            // What is smaller than a square fills it, so that no gaps remain.
            if is_small || contains(&face.corners, centre) {
                cells[row * columns + column] = Some((face.part, face.shade));
            }
        }
    }
    let mut paths: BTreeMap<(usize, u8), String> = BTreeMap::new();
    for (row, cells) in cells.chunks_exact(columns).enumerate() {
        let mut column = 0;
        for alike in cells.chunk_by(|a, b| a == b) {
            if let Some(look) = alike[0] {
                let (x, y) = (column as f64 * CELL, row as f64 * CELL);
                let _ = write!(
                    paths.entry(look).or_default(),
                    "M{x} {y}h{}v{CELL}h-{0}z",
                    alike.len() as f64 * CELL
                );
            }
            column += alike.len();
        }
    }
    for ((part, shade), path) in paths {
        let _ = writeln!(svg, "<path d=\"{path}\" fill=\"{}\"/>", colour(part, shade));
    }
}

/// Whether a convex polygon contains a point, on whichever side its corners run.
fn contains(corners: &[[f64; 2]; 4], [x, y]: [f64; 2]) -> bool {
    let side = |i: usize| {
        let ([ax, ay], [bx, by]) = (corners[i], corners[(i + 1) % 4]);
        (bx - ax) * (y - ay) - (by - ay) * (x - ax)
    };
    let sides = [0, 1, 2, 3].map(side);
    sides.iter().all(|side| *side >= 0.0) || sides.iter().all(|side| *side <= 0.0)
}

/// Directions of x, y, z at the lower left.
fn axes(view: &View, svg: &mut String) {
    const LENGTH: f64 = 36.0;
    let [x, y] = [EDGE + 14.0, HEIGHT - EDGE - 14.0];
    for (axis, name) in [(Vec3::x(), "x"), (Vec3::y(), "y"), (Vec3::z(), "z")] {
        let [dx, dy] = [axis.dot(&view.right) * LENGTH, -axis.dot(&view.up) * LENGTH];
        let _ = writeln!(
            svg,
            "<path d=\"M{x} {y}l{dx:.1} {dy:.1}\" stroke=\"#22262c\" stroke-width=\"1.5\"/>\
             <text x=\"{:.1}\" y=\"{:.1}\" text-anchor=\"middle\">{name}</text>",
            x + 1.3 * dx,
            y + 1.3 * dy + 4.0
        );
    }
}

/// Colour of a part in a shade.
fn colour(part: usize, shade: u8) -> String {
    // Without black, in which no shade is seen.
    let RGBColor(r, g, b) = COLOURS[part % (COLOURS.len() - 1)];
    let part = f64::from(shade) / f64::from(SHADES);
    let [r, g, b] = [r, g, b].map(|c| (part * (0.75 * f64::from(c) + 0.25 * 255.0)).round() as u8);
    format!("#{r:02x}{g:02x}{b:02x}")
}

fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;")
}

#[cfg(test)]
#[allow(clippy::unwrap_used)] // tests may panic
mod tests {
    use super::*;
    use crate::mesh::generate::block::Block;
    use crate::mesh::inspect::inspect;

    fn block(n: u32) -> Mesh {
        Block::uniform(Vec3::zeros(), Vec3::new(0.1, 0.06, 0.04), [n, n, n], "fat & skin").generate().unwrap()
    }

    #[test]
    fn three_sides_of_a_block_are_seen_with_its_worst_elements() {
        let mesh = block(2);
        let svg = Faces::of_mesh(&mesh).svg("a block", &inspect(&mesh).unwrap().worst);
        assert_eq!(svg.matches("<polygon").count(), 3 * 4, "{svg}");
        assert_eq!(svg.matches("<circle").count(), 8);
        assert!(svg.contains("fat &amp; skin") && svg.contains("8: element 7 (1.000)"), "{svg}");
    }

    #[test]
    fn the_picture_of_a_large_mesh_is_small() {
        let svg = Faces::of_mesh(&block(70)).svg("a block", &[]);
        assert!(!svg.contains("<polygon") && svg.len() < 60_000, "{}", svg.len());
        // Three sides, each in one shade.
        assert_eq!(svg.matches("<path d=\"M").count(), 3 + 3);
    }

    #[test]
    fn a_scan_is_drawn_by_the_sides_of_its_voxels() {
        let volume = LabelVolume {
            dims: [3, 1, 1],
            labels: vec![0, 1, 2],
            values: vec![0, 3, 8],
            names: BTreeMap::new(),
            origin: Vec3::zeros(),
            steps: [Vec3::x(), Vec3::y(), Vec3::z()],
            notes: Vec::new(),
        };
        let faces = Faces::of_scan(&volume).unwrap();
        assert_eq!((faces.faces.len(), faces.names.len()), (10, 2));
        let svg = faces.svg("a scan", &[]);
        assert_eq!(svg.matches("<polygon").count(), 5, "{svg}");
    }
}
