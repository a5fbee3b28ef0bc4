//! The charts of a report, as SVG.

use super::chart::{Chart, Drawn, FONT, legend, with_room};
use super::depth_picture::depth_picture;
use super::{RecordedRun, Series};
use crate::measure::summary::{Impact, Quantity, Results, marked, unit_of_time, within};
use crate::study::palette::COLOURS;
use plotters::coord::Shift;
use plotters::element::DashedPathElement;
use plotters::prelude::*;

const SIZE: (u32, u32) = (640, 380);
/// Largest number of points of a line; longer ones keep the minimum and maximum of each interval.
const MOST_POINTS: usize = 1200;

/// A chart with its title.
pub(super) struct Picture {
    pub title: &'static str,
    pub svg: String,
}

/// All charts for which the run has data.
pub(super) fn pictures(run: &RecordedRun) -> Result<Vec<Picture>, String> {
    let mut all = Vec::new();
    let mut add = |title: &'static str, draw: &dyn Fn(&DrawingArea<SVGBackend, Shift>) -> Drawn| {
        let mut svg = String::new();
        {
            let area = SVGBackend::with_string(&mut svg, SIZE).into_drawing_area();
            draw(&area).and_then(|()| Ok(area.present()?)).map_err(|error| error.to_string())?;
        }
        all.push(Picture { title, svg });
        Ok::<(), String>(())
    };
    let impact = run.results().and_then(Results::headline_impact);
    let pair = impact.and_then(|impact| run.pairs.get(&impact.pair));
    if let (Some(impact), Some(pair)) = (impact, pair) {
        let force = pair.averaged_force(super::csv::force_average(run));
        add("Impact force", &|area| force_picture(area, &force, impact))?;
    }
    if run.total.len() > 1 {
        add("Energy", &|area| energy_picture(area, run))?;
    }
    let tissue = run.results().and_then(|results| results.tissue.as_ref());
    let stresses = tissue.map_or(&[][..], |tissue| &tissue.significant_stress);
    if stresses.iter().any(|stress| !stress.layers.is_empty()) {
        add("Depth of stress", &|area| depth_picture(area, stresses))?;
    }
    if let Some(impact) = impact.filter(|impact| impact.patch_area_mm2.value > 0.0) {
        add("Contact patch", &|area| patch_picture(area, impact))?;
    }
    Ok(all)
}

/// Force averaged over the window, with the peak and its error bar.
fn force_picture(area: &DrawingArea<SVGBackend, Shift>, force: &Series, impact: &Impact) -> Drawn {
    let value = impact.peak_force_n.value;
    let [low, high] = impact.peak_force_n.ends();
    let at = impact.peak_force_time_s.value;
    let (unit, scale) = if high >= 2e3 { ("kN", 1e-3) } else { ("N", 1.0) };
    let top = with_room([0.0, scale * high.max(force.iter().map(|p| p.1).fold(0.0, f64::max))], 2);
    let (time_unit, time_scale) = time_unit(force);
    let mut chart =
        axes(area, end(force) * time_scale, 0.0..top.max(1e-12), &format!("force [{unit}]"), time_unit)?;
    // The force with the area below it.
    let line = thinned(force).into_iter().map(|(t, f)| (time_scale * t, scale * f));
    let area_below = std::iter::once((0.0, 0.0)).chain(line.clone()).chain([(end(force) * time_scale, 0.0)]);
    chart.draw_series(std::iter::once(Polygon::new(
        area_below.collect::<Series>(),
        COLOURS[0].mix(0.12).filled(),
    )))?;
    // A mean stands at the middle of its window: the line ends half a window before the run.
    let middle = if impact.force_window_s.is_some() { ", at the middle of its window" } else { "" };
    let style = COLOURS[0].stroke_width(2);
    chart
        .draw_series(LineSeries::new(line, style))?
        .label(format!("force, {}{middle}", impact.force_average))
        .legend(move |(x, y)| PathElement::new([(x, y), (x + 20, y)], style));
    // The peak with its error bar.
    let colour = COLOURS[1].stroke_width(2);
    let bar = vec![(time_scale * at, scale * low.max(0.0)), (time_scale * at, scale * high)];
    chart
        .draw_series(std::iter::once(PathElement::new(bar, colour)))?
        .label("peak and its numerical error")
        .legend(move |(x, y)| PathElement::new([(x, y), (x + 20, y)], colour));
    chart.draw_series(std::iter::once(Circle::new(
        (time_scale * at, scale * value),
        4,
        COLOURS[1].filled(),
    )))?;
    legend(&mut chart)
}

/// Energy of the bodies, energy absorbed by the tissue, and total energy.
fn energy_picture(area: &DrawingArea<SVGBackend, Shift>, run: &RecordedRun) -> Drawn {
    let mut lines: Vec<(String, &Series)> =
        run.bodies.iter().map(|(name, line)| (format!("{name}: kinetic + strain"), line)).collect();
    if run.absorbed.iter().any(|(_, energy)| *energy != 0.0) {
        lines.push(("absorbed by the tissue".into(), &run.absorbed));
    }
    lines.push(("everything".into(), &run.total));
    let all = || lines.iter().flat_map(|(_, line)| line.iter().map(|p| p.1));
    let (low, high) = (all().fold(0.0, f64::min), all().fold(0.0, f64::max));
    let (time_unit, time_scale) = time_unit(&run.total);
    let range = low..with_room([low, high], lines.len()).max(low + 1e-12);
    let mut chart = axes(area, end(&run.total) * time_scale, range, "energy [J]", time_unit)?;
    for (index, (label, line)) in lines.iter().enumerate() {
        let points = thinned(line).into_iter().map(|(t, e)| (time_scale * t, e));
        // What may coincide with a line of a body is dashed, so that both are seen: what the tissue absorbs, and the total in black.
        let (style, dashes) = if index + 1 == lines.len() {
            (BLACK.stroke_width(1), Some([3, 4]))
        } else {
            let is_body = index < run.bodies.len();
            (COLOURS[index % COLOURS.len()].stroke_width(2), (!is_body).then_some([9, 7]))
        };
        match dashes {
            Some([dash, gap]) => {
                chart
                    .draw_series(DashedLineSeries::new(points, dash, gap, style))?
                    .label(label.as_str())
                    .legend(move |(x, y)| DashedPathElement::new([(x, y), (x + 20, y)], dash, gap, style));
            }
            None => {
                chart
                    .draw_series(LineSeries::new(points, style))?
                    .label(label.as_str())
                    .legend(move |(x, y)| PathElement::new([(x, y), (x + 20, y)], style));
            }
        }
    }
    legend(&mut chart)
}

/// A number as in the tables, without a unit.
fn written(of: &Quantity) -> String {
    marked(&within(of.value, of.error.half_width()), of.error.is_resolved(), of.is_lower_bound)
}

/// Ellipse of the patch with its two axes, and a scale bar; a dashed line without a filling where the patch is not resolved.
fn patch_picture(area: &DrawingArea<SVGBackend, Shift>, impact: &Impact) -> Drawn {
    let all = [&impact.patch_long_axis_mm, &impact.patch_short_axis_mm, &impact.patch_area_mm2];
    let ([long, short, _], [of_long, of_short, of_area]) = (all.map(|of| of.value), all.map(written));
    let is_resolved = all.iter().all(|of| of.error.is_resolved());
    let across = 1.5 * long.max(short).max(1e-3);
    let (width, height) = (f64::from(SIZE.0) - 24.0, f64::from(SIZE.1) - 24.0);
    let (half_x, half_y) = if width > height {
        (across / 2.0 * width / height, across / 2.0)
    } else {
        (across / 2.0, across / 2.0 * height / width)
    };
    area.fill(&WHITE)?;
    let mut chart = ChartBuilder::on(area).margin(12).build_cartesian_2d(-half_x..half_x, -half_y..half_y)?;
    let ellipse = (0..=180).map(|i| {
        let angle = f64::from(i) / 90.0 * std::f64::consts::PI;
        (0.5 * long * angle.cos(), 0.5 * short * angle.sin())
    });
    let ellipse: Vec<(f64, f64)> = ellipse.collect();
    if is_resolved {
        chart.draw_series(std::iter::once(Polygon::new(ellipse.clone(), COLOURS[0].mix(0.2).filled())))?;
        chart.draw_series(std::iter::once(PathElement::new(ellipse, COLOURS[0].stroke_width(2))))?;
    } else {
        chart.draw_series(DashedLineSeries::new(ellipse, 5, 5, COLOURS[0].stroke_width(2)))?;
    }
    // Scale bar and labels.
    let scale = nice(0.35 * across);
    let (left, low) = (-0.94 * half_x, -0.86 * half_y);
    chart.draw_series(std::iter::once(PathElement::new(
        [(left, low), (left + scale, low)],
        BLACK.stroke_width(3),
    )))?;
    let doubt = if is_resolved { "" } else { "; in brackets: not resolved" };
    let label = |text: String, at: (f64, f64)| Text::new(text, at, (FONT, 18).into_font());
    chart.draw_series([
        label(format!("{scale} mm"), (left, low + 0.12 * half_y)),
        label(
            format!("{of_area} mm², spread over {of_long} mm × {of_short} mm{doubt}"),
            (left, 0.94 * half_y),
        ),
        label("ellipse of the same second moments, at the peak force".into(), (left, 0.80 * half_y)),
    ])?;
    Ok(())
}

/// The largest of 1, 2 or 5 times a power of ten that does not exceed `length`.
fn nice(length: f64) -> f64 {
    let power = 10_f64.powf(length.log10().floor());
    [5.0, 2.0, 1.0].map(|m| m * power).into_iter().find(|l| *l <= length).unwrap_or(power)
}

/// Axes of a chart over time from 0 to `end`.
fn axes<'a, 'b>(
    area: &'a DrawingArea<SVGBackend<'b>, Shift>,
    end: f64,
    range: std::ops::Range<f64>,
    title: &str,
    time_unit: &str,
) -> Result<Chart<'a, 'b>, Box<dyn std::error::Error>> {
    area.fill(&WHITE)?;
    let mut chart = ChartBuilder::on(area)
        .margin(12)
        .x_label_area_size(50)
        .y_label_area_size(74)
        .build_cartesian_2d(0.0..end.max(1e-12), range)
        .map_err(|error| error.to_string())?;
    chart
        .configure_mesh()
        .x_desc(format!("time [{time_unit}]"))
        .y_desc(title)
        .light_line_style(TRANSPARENT)
        .bold_line_style(BLACK.mix(0.12))
        .label_style((FONT, 17))
        .axis_desc_style((FONT, 18))
        .draw()
        .map_err(|error| error.to_string())?;
    Ok(chart)
}

fn end(line: &Series) -> f64 {
    line.last().map_or(0.0, |p| p.0)
}

/// A convenient time unit for a line, and its inverse [1/s].
fn time_unit(line: &Series) -> (&'static str, f64) {
    let (scale, unit) = unit_of_time(end(line));
    (unit, scale)
}

/// The line with at most as many points as can be resolved: minimum and maximum of each interval, in order.
fn thinned(line: &Series) -> Series {
    let stretch = (2 * line.len()).div_ceil(MOST_POINTS).max(1);
    if stretch <= 2 {
        return line.clone();
    }
    let ends = |points: &[(f64, f64)]| {
        let least = points.iter().copied().min_by(|a, b| a.1.total_cmp(&b.1));
        let greatest = points.iter().copied().max_by(|a, b| a.1.total_cmp(&b.1));
        let mut ends: Vec<(f64, f64)> = least.into_iter().chain(greatest).collect();
        ends.sort_by(|a, b| a.0.total_cmp(&b.0));
        ends
    };
    line.chunks(stretch).flat_map(ends).collect()
}

#[cfg(test)]
#[allow(clippy::unwrap_used)] // tests may panic
mod tests {
    use super::super::tests::example;
    use super::*;

    fn drawn(draw: impl Fn(&DrawingArea<SVGBackend, Shift>) -> Drawn) -> String {
        let mut svg = String::new();
        {
            let area = SVGBackend::with_string(&mut svg, SIZE).into_drawing_area();
            draw(&area).unwrap();
        }
        svg
    }

    #[test]
    fn every_line_of_a_force_has_a_name() {
        let run = example();
        let impact = run.results().unwrap().headline_impact().unwrap();
        let force = vec![(0.0, 0.0), (1e-4, 500.0), (2e-4, 900.0)];
        let svg = drawn(|area| force_picture(area, &force, impact));
        let name = format!("force, {}", impact.force_average);
        assert!(svg.contains(&name) && svg.contains("peak and its numerical error"), "{svg}");
    }

    #[test]
    fn lines_that_coincide_are_all_seen_and_their_names_lie_above_them() {
        let line: Series = (0..=10).map(|i| (1e-4 * f64::from(i), f64::from(i))).collect();
        let mut run = RecordedRun { absorbed: line.clone(), total: line.clone(), ..RecordedRun::default() };
        run.bodies.insert("thigh".into(), line);
        let svg = drawn(|area| energy_picture(area, &run));
        // Whole: the line of the thigh, and its sign in the legend, both of the first colour.
        let [red, green, blue] = [COLOURS[0].0, COLOURS[0].1, COLOURS[0].2];
        let first = format!("stroke=\"#{red:02X}{green:02X}{blue:02X}\"");
        assert_eq!(svg.matches(&first).count(), 2, "{svg}");
        assert!(with_room([0.0, 10.0], 3) > 13.0 && with_room([0.0, 10.0], 3) < 20.0);
    }
}
