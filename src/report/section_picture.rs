//! The picture of a report: the section through the impact at the worst instant, with stress as colours.

use super::instant::{Body, Instant};
use super::section::{Corner, Line, Plane, Section, band, dot, level, minus};
use crate::measure::summary::number;
use serde_json::Value;
use std::fmt::Write as _;

/// Size of the picture, where its ruler ends at the left, and where names and legend begin at the right.
const SIZE: [f64; 2] = [840.0, 430.0];
const LEFT: f64 = 52.0;
const NAMES: f64 = 660.0;
const LEGEND: f64 = 752.0;
/// Half of the height of the picture: in radii of the projectile, and at least [m].
const AROUND: f64 = 2.3;
const LEAST: f64 = 0.03;
/// Bands of colour for each factor of ten of the stress, and the fraction of the lowest threshold at which they begin.
const BANDS: f64 = 6.0;
const BELOW: f64 = 0.1;
/// Of the nodes of the tissue this fraction may lie beyond the last colour: peaks at a point [-].
const BEYOND: f64 = 0.002;
/// Deepest tick of the ruler [mm].
const DEEPEST: f64 = 200.0;

/// The map cividis of matplotlib at equal distances.
const CIVIDIS: [u32; 17] = [
    0x0000_224e,
    0x0000_2e6a,
    0x001a_386f,
    0x0032_436d,
    0x0043_4e6c,
    0x0053_5a6d,
    0x0061_656f,
    0x006f_7073,
    0x007d_7c78,
    0x008c_8878,
    0x009b_9476,
    0x00ab_a072,
    0x00bc_ae6c,
    0x00cd_bb63,
    0x00de_c958,
    0x00f0_d846,
    0x00fe_e838,
];

/// The picture as SVG with its caption; `None` without tissue, projectile or recorded stress.
pub fn section_picture(instant: &Instant, scene: &Value, thresholds_pa: &[f64]) -> Option<(String, String)> {
    let tissue = instant.bodies.iter().find(|body| body.role == "tissue" && !body.stress.is_empty())?;
    let frame = Frame::of(instant, tissue, scene)?;
    let scale = Scale::of(tissue, thresholds_pa)?;
    let mut picture = Picture { frame, svg: String::new() };
    let section = Section::of(tissue, &picture.frame.plane);
    picture.fill(&section, &scale);
    picture.lines(&section.outlines, "#fff", 1.4);
    picture.bone(scene);
    for body in instant.bodies.iter().filter(|body| body.role == "projectile") {
        let section = Section::of(body, &picture.frame.plane);
        picture.solid(section.polygons.iter().map(|(_, polygon)| polygon), "#8b919c");
        picture.lines(&section.outlines, "#22262c", 1.4);
    }
    let rigid: Vec<Line> =
        instant.rigid.iter().filter_map(|triangle| picture.frame.plane.cut_triangle(triangle)).collect();
    picture.rigid(&rigid);
    picture.svg += "</g>\n";
    picture.names(&section, tissue);
    picture.ruler();
    picture.legend(&scale);
    let caption = format!(
        "Section through the impact {} µs after the start; colours: von Mises stress, lines: thresholds",
        number(1e6 * instant.time_s)
    );
    Some((picture.finished(), caption))
}

/// Plane and scale of the picture.
struct Frame {
    plane: Plane,
    /// Pixels to a metre.
    scale: f64,
    /// The skin above the impact at rest, in the picture [m].
    skin: f64,
}

impl Frame {
    fn of(instant: &Instant, tissue: &Body, scene: &Value) -> Option<Self> {
        let bodies = scene["bodies"].as_array()?;
        let velocity =
            bodies.iter().find(|body| body["role"] == "projectile")?["velocity_m_per_s"].as_array()?;
        let velocity: Vec<f64> = velocity.iter().filter_map(Value::as_f64).collect();
        let velocity: [f64; 3] = velocity.try_into().ok()?;
        let speed = dot(velocity, velocity).sqrt();
        let direction = velocity.map(|v| v / speed);
        let points = projectile(instant);
        let (low, high) = bounds(points.iter().copied())?;
        let centre: [f64; 3] = std::array::from_fn(|k| 0.5 * (low[k] + high[k]));
        let radius = (0..3).map(|k| 0.5 * (high[k] - low[k])).fold(0.0, f64::max);
        // Across the longest side of the tissue that does not run along the impact.
        let (low, high) = bounds(tissue.rest.iter().copied())?;
        let length = |k: usize| if direction[k].abs() > 0.7 { 0.0 } else { high[k] - low[k] };
        let axis = (0..3).max_by(|&a, &b| length(a).total_cmp(&length(b)))?;
        let normal: [f64; 3] = std::array::from_fn(|k| if k == axis { 1.0 } else { 0.0 });
        let along = dot(direction, normal);
        let up: [f64; 3] = std::array::from_fn(|k| along * normal[k] - direction[k]);
        let norm = dot(up, up).sqrt();
        let up = up.map(|x| x / norm);
        let right = [
            up[1] * normal[2] - up[2] * normal[1],
            up[2] * normal[0] - up[0] * normal[2],
            up[0] * normal[1] - up[1] * normal[0],
        ];
        // The node of the skin where the path of the projectile meets the tissue at rest.
        let off = |x: &[f64; 3]| {
            let arm = minus(*x, centre);
            let s = dot(arm, direction);
            (dot(arm, arm) - s * s).max(0.0).sqrt()
        };
        let nearest = tissue.rest.iter().map(off).fold(f64::INFINITY, f64::min);
        let skin = tissue.rest.iter().filter(|x| off(x) < nearest + 0.003);
        let skin = skin.max_by(|a, b| dot(**a, up).total_cmp(&dot(**b, up)))?;
        // Not through the nodes that often lie in the plane of symmetry.
        let mut origin: [f64; 3] = *skin;
        origin[axis] = centre[axis] + 0.004 * (high[axis] - low[axis]);
        let half = LEAST.max(AROUND * radius);
        let shift = 0.3 * half;
        for k in 0..3 {
            origin[k] -= shift * up[k];
        }
        (norm > 0.1 && speed > 0.0).then_some(Self {
            plane: Plane { origin, normal, right, up },
            scale: 0.5 * SIZE[1] / half,
            skin: shift,
        })
    }

    fn pixel(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        [0.5 * (LEFT + NAMES) + self.scale * x, 0.5 * SIZE[1] - self.scale * y]
    }

    /// Whether some of a polygon may lie in the picture.
    fn sees(&self, polygon: &[Corner]) -> bool {
        let at: Vec<[f64; 2]> = polygon.iter().map(|(at, _)| self.pixel(*at)).collect();
        let (from, to) = ([LEFT, 0.0], [NAMES, SIZE[1]]);
        (0..2).all(|k| at.iter().any(|p| p[k] > from[k]) && at.iter().any(|p| p[k] < to[k]))
    }
}

/// All points of the projectile; of a rigid one the corners of its triangles.
fn projectile(instant: &Instant) -> Vec<[f64; 3]> {
    let meshed = instant.bodies.iter().filter(|body| body.role == "projectile");
    let points: Vec<[f64; 3]> = meshed.flat_map(|body| body.positions.iter().copied()).collect();
    if points.is_empty() { instant.rigid.iter().flatten().copied().collect() } else { points }
}

fn bounds(points: impl Iterator<Item = [f64; 3]>) -> Option<([f64; 3], [f64; 3])> {
    points.fold(None, |bounds, p| {
        let (low, high) = bounds.unwrap_or((p, p));
        Some((std::array::from_fn(|k| low[k].min(p[k])), std::array::from_fn(|k| high[k].max(p[k]))))
    })
}

/// Bands of stress with their colours, even in its logarithm.
struct Scale {
    low: f64,
    high: f64,
    thresholds: Vec<f64>,
}

impl Scale {
    fn of(tissue: &Body, thresholds_pa: &[f64]) -> Option<Self> {
        let mut stress: Vec<f64> = tissue.stress.iter().copied().filter(|s| s.is_finite()).collect();
        stress.sort_by(f64::total_cmp);
        let index = ((1.0 - BEYOND) * stress.len() as f64) as usize;
        let most = *stress.get(index.min(stress.len().saturating_sub(1)))?;
        let low = BELOW * thresholds_pa.first().copied().filter(|t| *t > 0.0).unwrap_or(0.01 * most);
        let high = most.max(10.0 * low);
        (low > 0.0).then(|| Self { low, high, thresholds: thresholds_pa.to_vec() })
    }

    fn count(&self) -> usize {
        (BANDS * (self.high / self.low).log10()).ceil().clamp(1.0, 60.0) as usize
    }

    /// Begin and end of a band [Pa]; the first and the last are open.
    fn band(&self, index: usize) -> [f64; 2] {
        let edge = |i: usize| self.low * (self.high / self.low).powf(i as f64 / self.count() as f64);
        let low = if index == 0 { f64::NEG_INFINITY } else { edge(index) };
        [low, if index + 1 == self.count() { f64::INFINITY } else { edge(index + 1) }]
    }

    fn colour(&self, index: usize) -> String {
        let at = 16.0 * (index as f64 + 0.5) / self.count() as f64;
        let left = (at as usize).min(15);
        let [a, b] = [CIVIDIS[left], CIVIDIS[left + 1]];
        let channel = |shift: u32| {
            let [a, b] = [a, b].map(|colour| f64::from((colour >> shift) & 0xff));
            (a + (at - left as f64) * (b - a)).round() as u32
        };
        format!("#{:06x}", (channel(16) << 16) | (channel(8) << 8) | channel(0))
    }
}

/// A stress in kilopascals, without zeros behind the point.
fn kilopascals(stress: f64) -> String {
    let text = number(1e-3 * stress);
    if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').to_owned() } else { text }
}

/// The picture as it grows.
struct Picture {
    frame: Frame,
    svg: String,
}

impl Picture {
    /// The outline of a polygon as a path.
    fn path(&self, polygon: impl Iterator<Item = [f64; 2]>) -> String {
        let mut path = String::new();
        for (i, at) in polygon.enumerate() {
            let [x, y] = self.frame.pixel(at);
            let _ = write!(path, "{}{x:.1} {y:.1}", if i == 0 { "M" } else { "L" });
        }
        path + "Z"
    }

    fn add(&mut self, text: std::fmt::Arguments) {
        let _ = self.svg.write_fmt(text);
        self.svg.push('\n');
    }

    /// The tissue: what of each polygon lies in a band, in its colour.
    fn fill(&mut self, section: &Section, scale: &Scale) {
        let shown: Vec<&[Corner]> =
            section.polygons.iter().map(|(_, p)| &p[..]).filter(|p| self.frame.sees(p)).collect();
        for index in 0..scale.count() {
            let [low, high] = scale.band(index);
            let mut path = String::new();
            for polygon in &shown {
                let inside = band(polygon, low, high);
                if inside.len() > 2 {
                    path += &self.path(inside.iter().map(|(at, _)| *at));
                }
            }
            let colour = scale.colour(index);
            // The stroke covers the seams between polygons.
            self.add(format_args!(
                "<path d=\"{path}\" fill=\"{colour}\" stroke=\"{colour}\" stroke-width=\"0.7\"/>"
            ));
        }
        for &threshold in &scale.thresholds {
            let lines: Vec<Line> = shown.iter().filter_map(|polygon| level(polygon, threshold)).collect();
            self.lines(&lines, "#000", 1.1);
        }
    }

    fn lines(&mut self, lines: &[Line], colour: &str, width: f64) {
        let mut path = String::new();
        for line in lines {
            let [[a, b], [c, d]] = line.map(|end| self.frame.pixel(end));
            let _ = write!(path, "M{a:.1} {b:.1}L{c:.1} {d:.1}");
        }
        self.add(format_args!(
            "<path d=\"{path}\" fill=\"none\" stroke=\"{colour}\" stroke-width=\"{width}\" stroke-linecap=\"round\"/>"
        ));
    }

    fn solid<'a>(&mut self, polygons: impl Iterator<Item = &'a Vec<Corner>>, colour: &str) {
        let path: String = polygons.map(|polygon| self.path(polygon.iter().map(|(at, _)| *at))).collect();
        self.add(format_args!(
            "<path d=\"{path}\" fill=\"{colour}\" stroke=\"{colour}\" stroke-width=\"0.7\"/>"
        ));
    }

    /// A rigid body from the lines of its surface: filled around their middle, which is exact where it is convex.
    fn rigid(&mut self, lines: &[Line]) {
        let count = 2.0 * lines.len() as f64;
        if lines.is_empty() {
            return;
        }
        let middle: [f64; 2] =
            std::array::from_fn(|k| lines.iter().flatten().map(|end| end[k]).sum::<f64>() / count);
        let fan: Vec<Vec<Corner>> =
            lines.iter().map(|[a, b]| [middle, *a, *b].map(|at| (at, 0.0)).to_vec()).collect();
        self.solid(fan.iter(), "#8b919c");
        self.lines(lines, "#22262c", 1.4);
    }

    /// The bone of a generated limb, which the model holds as a hole with a rigid surface.
    fn bone(&mut self, scene: &Value) {
        let bodies = scene["bodies"].as_array().into_iter().flatten();
        let limb = bodies
            .map(|body| (&body["mesh"]["generator"], &body["placement"]))
            .find(|(g, _)| g["kind"] == "limb_segment");
        let Some((generator, placement)) = limb else { return };
        let Some(a) = generator["bone_semi_axis_x_m"].as_f64() else { return };
        let c = generator["bone_semi_axis_z_m"].as_f64().unwrap_or(a);
        let vector = |value: &Value, k: usize| value[k].as_f64().unwrap_or_default();
        let middle: [f64; 3] = std::array::from_fn(|k| {
            vector(&generator["center_m"], k) + vector(&placement["translation_m"], k)
        });
        let [x, z] = [0, 1].map(|k| vector(&generator["bone_offset_m"], k));
        let is_turned = placement.as_object().is_some_and(|p| p.keys().any(|key| key != "translation_m"));
        // Only where the picture is across the limb, which runs along y.
        if is_turned || self.frame.plane.normal[1].abs() < 0.9 {
            return;
        }
        let ellipse: Vec<[f64; 2]> = (0..72)
            .map(|i| {
                let angle = f64::from(i) / 36.0 * std::f64::consts::PI;
                self.frame.plane.place([
                    middle[0] + x + a * angle.cos(),
                    middle[1],
                    middle[2] + z + c * angle.sin(),
                ])
            })
            .collect();
        let path = self.path(ellipse.iter().copied());
        self.add(format_args!(
            "<path d=\"{path}\" fill=\"#ece5d3\" stroke=\"#22262c\" stroke-width=\"1.2\"/>"
        ));
        let [u, v] = self.frame.pixel(ellipse[18]);
        let [_, bottom] = self.frame.pixel(ellipse[54]);
        let at = if v < bottom { v } else { bottom } + 17.0;
        if at < SIZE[1] - 4.0 {
            self.add(format_args!("<text x=\"{u:.0}\" y=\"{at:.0}\" text-anchor=\"middle\">bone</text>"));
        }
    }

    /// The names of the parts, each beside a place of it to the right of the impact.
    fn names(&mut self, section: &Section, tissue: &Body) {
        let goal = 0.5 * (LEFT + NAMES) + 150.0;
        let mut anchors: Vec<([f64; 2], &str)> = Vec::new();
        for (part, name) in (0..).zip(&tissue.parts) {
            let middles = section.polygons.iter().filter(|(of, _)| *of == part).map(|(_, polygon)| {
                let count = polygon.len() as f64;
                self.frame
                    .pixel(std::array::from_fn(|k| polygon.iter().map(|(at, _)| at[k]).sum::<f64>() / count))
            });
            let score = |at: &[f64; 2]| (at[0] - goal).abs() + 0.4 * (at[1] - 0.3 * SIZE[1]).abs();
            let nearest = middles.min_by(|a, b| score(a).total_cmp(&score(b)));
            anchors.extend(nearest.map(|at| (at, name.as_str())));
        }
        anchors.sort_by(|a, b| a.0[1].total_cmp(&b.0[1]));
        let (column, mut lowest) = (NAMES + 14.0, 0.0f64);
        for ([x, y], name) in anchors.into_iter().filter(|([_, y], _)| (0.0..SIZE[1]).contains(y)) {
            let at = y.max(lowest + 18.0);
            lowest = at;
            for (colour, width) in [("#fff", 3.5), ("#22262c", 1.2)] {
                self.add(format_args!(
                    "<path d=\"M{x:.0} {y:.0}L{:.0} {at:.0}\" fill=\"none\" stroke=\"{colour}\" stroke-width=\"{width}\"/>",
                    column - 4.0
                ));
            }
            let name = name.replace('&', "&amp;").replace('<', "&lt;");
            self.add(format_args!("<text x=\"{column:.0}\" y=\"{:.0}\">{name}</text>", at + 5.0));
        }
    }

    /// Depths below the skin at rest, at the left.
    fn ruler(&mut self) {
        let y = |depth: f64| self.frame.pixel([0.0, self.frame.skin - 1e-3 * depth])[1];
        let per_mm = y(1.0) - y(0.0);
        let step =
            [1.0, 2.0, 5.0, 10.0, 20.0, 50.0].into_iter().find(|step| step * per_mm > 40.0).unwrap_or(100.0);
        let ticks: Vec<(f64, f64)> = (0..)
            .map(|i| f64::from(i) * step)
            .take_while(|depth| *depth <= DEEPEST)
            .map(|depth| (depth, y(depth)))
            .filter(|(_, at)| (10.0..SIZE[1] - 4.0).contains(at))
            .collect();
        let (Some((_, first)), Some((_, last))) = (ticks.first(), ticks.last()) else { return };
        self.add(format_args!(
            "<path d=\"M44 {first:.1}V{last:.1}\" stroke=\"#22262c\" stroke-width=\"1.3\"/>"
        ));
        for (depth, at) in &ticks {
            self.add(format_args!(
                "<path d=\"M38 {at:.1}H44\" stroke=\"#22262c\" stroke-width=\"1.3\"/><text x=\"34\" y=\"{:.1}\" text-anchor=\"end\">{depth}</text>",
                at + 4.5
            ));
        }
        self.add(format_args!("<text x=\"8\" y=\"{:.0}\">mm below the skin</text>", first - 12.0));
    }

    /// The bands from the bottom up, with the thresholds and the ends in kilopascals.
    fn legend(&mut self, scale: &Scale) {
        let (left, bottom, height) = (LEGEND, SIZE[1] - 24.0, 330.0);
        let each = height / scale.count() as f64;
        for index in 0..scale.count() {
            self.add(format_args!(
                "<rect x=\"{left}\" y=\"{:.2}\" width=\"16\" height=\"{:.2}\" fill=\"{}\"/>",
                bottom - each * (index + 1) as f64,
                each + 0.4,
                scale.colour(index)
            ));
        }
        let place = |stress: f64| bottom - height * (stress / scale.low).ln() / (scale.high / scale.low).ln();
        let inside = scale.thresholds.iter().copied().filter(|t| (scale.low..scale.high).contains(t));
        for stress in std::iter::once(scale.low).chain(inside.clone()).chain([scale.high]) {
            self.add(format_args!(
                "<text x=\"{}\" y=\"{:.1}\">{}</text>",
                left + 22.0,
                place(stress) + 4.5,
                kilopascals(stress)
            ));
        }
        for threshold in inside {
            let at = place(threshold);
            self.add(format_args!("<path d=\"M{left} {at:.1}h16\" stroke=\"#000\" stroke-width=\"1.4\"/>"));
        }
        self.add(format_args!("<text x=\"{left}\" y=\"{:.0}\">stress [kPa]</text>", bottom - height - 14.0));
    }

    fn finished(self) -> String {
        let [width, height] = SIZE;
        format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {width} {height}\" font-family=\"sans-serif\" font-size=\"13\" fill=\"#22262c\">\n\
             <defs><clipPath id=\"picture\"><rect x=\"{LEFT}\" width=\"{}\" height=\"{height}\"/></clipPath></defs>\n\
             <rect width=\"{width}\" height=\"{height}\" fill=\"#f4f6f8\"/>\n<g clip-path=\"url(#picture)\">\n{}</svg>\n",
            NAMES - LEFT,
            self.svg
        )
    }
}
