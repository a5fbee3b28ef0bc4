//! The picture of a report: the section through the impact at the worst instant, with stress as colours.

use super::instant::{Body, Instant};
use super::section::{Corner, Line, Section, band, level};
use super::section_frame::{Frame, LEFT, NAMES, SIZE};
use super::section_scale::Scale;
use crate::measure::summary::{number, rounded, seconds};
use serde_json::Value;
use std::fmt::Write as _;

/// Where the legend begins [px], and the deepest tick of the ruler [mm].
const LEGEND: f64 = 752.0;
const DEEPEST: f64 = 200.0;

/// The picture as SVG with its caption, which says `what` happens at the instant; `None` without tissue, projectile or recorded stress.
pub fn section_picture(
    instant: &Instant,
    what: &str,
    scene: &Value,
    thresholds_pa: &[f64],
) -> Option<(String, String)> {
    let is_tissue = |body: &&Body| body.role == "tissue" && !body.stress.is_empty();
    let tissues: Vec<&Body> = instant.bodies.iter().filter(is_tissue).collect();
    let frame = Frame::of(instant, &tissues, scene)?;
    let scale = Scale::of(&tissues, thresholds_pa)?;
    let mut picture = Picture { frame, svg: String::new() };
    let sections: Vec<Section> = tissues.iter().map(|body| Section::of(body, &picture.frame.plane)).collect();
    for section in &sections {
        picture.fill(section, &scale);
        picture.lines(&section.outlines, "#fff", 1.4);
    }
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
    picture.names(sections.iter().zip(tissues));
    picture.ruler();
    picture.legend(&scale);
    let caption = format!(
        "Section through the impact at {what}, {} after the start; colours: von Mises stress, lines: thresholds",
        seconds(instant.time_s)
    );
    Some((picture.finished(), caption))
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
    fn names<'a>(&mut self, tissues: impl Iterator<Item = (&'a Section, &'a Body)>) {
        let goal = 0.5 * (LEFT + NAMES) + 150.0;
        let mut anchors: Vec<([f64; 2], &str)> = Vec::new();
        let parts =
            tissues.flat_map(|(section, body)| (0..).zip(&body.parts).map(move |part| (section, part)));
        for (section, (part, name)) in parts {
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

    /// Depths below the surface at rest, at the left.
    fn ruler(&mut self) {
        let y = |depth: f64| self.frame.pixel([0.0, self.frame.skin - 1e-3 * depth])[1];
        let per_mm = y(1.0) - y(0.0);
        let step =
            [1.0, 2.0, 5.0, 10.0, 20.0, 50.0].into_iter().find(|step| step * per_mm > 40.0).unwrap_or(100.0);
        let ticks: Vec<(f64, f64)> = (0..=(DEEPEST / step) as u32)
            .map(|i| f64::from(i) * step)
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
        self.add(format_args!("<text x=\"8\" y=\"{:.0}\">mm below the surface</text>", first - 12.0));
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
        // The last band is open: its end would look like the largest stress, which is none of the results here.
        let [above, _] = scale.band(scale.count() - 1);
        let last = (scale.high, format!("&gt; {}", rounded(1e-3 * above)));
        let below = std::iter::once(scale.low).chain(inside.clone());
        for (stress, words) in below.map(|stress| (stress, kilopascals(stress))).chain([last]) {
            self.add(format_args!(
                "<text x=\"{}\" y=\"{:.1}\">{words}</text>",
                left + 22.0,
                place(stress) + 4.5
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::{CellKind, Cells};
    use serde_json::json;

    /// A slab of tissue from a height up, with one part and the same stress at all nodes.
    fn slab(bottom: f64, part: &str) -> Body {
        let mut cells = Cells::default();
        cells.push(CellKind::Hex8, &[0, 1, 2, 3, 4, 5, 6, 7]);
        let square = [[-0.03, -0.03], [0.03, -0.03], [0.03, 0.03], [-0.03, 0.03]];
        let layer = |z: f64| square.map(|[x, y]| [x, y, z]);
        let rest: Vec<[f64; 3]> = [bottom, bottom + 0.01].into_iter().flat_map(layer).collect();
        Body {
            role: "tissue".into(),
            parts: vec![part.into()],
            cells,
            part_of: vec![0],
            positions: rest.clone(),
            rest,
            stress: vec![2e4; 8],
            ..Body::default()
        }
    }

    #[test]
    fn every_body_of_tissue_is_drawn() {
        let ball = [[-0.006, -0.006, 0.02], [0.006, 0.006, 0.032], [0.0, 0.0, 0.026]];
        let bodies = vec![slab(0.0, "muscle"), slab(0.01, "skin")];
        let instant = Instant { bodies, rigid: vec![ball], ..Instant::default() };
        let scene = json!({"bodies": [{"role": "projectile", "velocity_m_per_s": [0, 0, -8]}]});
        let (svg, caption) = section_picture(&instant, "the peak force", &scene, &[1e4]).unwrap();
        assert!(caption.starts_with("Section through the impact at the peak force, 0 s"), "{caption}");
        let height = |name: &str| {
            let (before, _) = svg.split_once(&format!(">{name}</text>")).unwrap();
            before.rsplit_once("y=\"").unwrap().1.trim_end_matches('"').parse::<f64>().unwrap()
        };
        assert!(height("skin") < height("muscle"), "{svg}");
        // The last band is open: it does not end with a largest stress.
        let scale: Vec<&str> = svg.lines().filter(|line| line.starts_with("<text x=\"774\"")).collect();
        assert!(scale.iter().any(|line| line.contains(">&gt; 14</text>")), "{svg}");
        assert!(!scale.iter().any(|line| line.contains(">20</text>")), "{svg}");
    }
}
