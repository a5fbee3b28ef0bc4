//! The chart of depths: how deep each part is stressed above each threshold.

use super::chart::{Chart, Drawn, FONT, legend, with_room};
use crate::measure::summary::{SignificantStress, short};
use crate::study::palette::COLOURS;
use plotters::coord::Shift;
use plotters::prelude::*;

/// Fraction of its colour that a bar has where its depth is resolved, and where not [-].
const STRENGTH: [f64; 2] = [0.85, 0.3];

/// The range in which a part is stressed above the threshold of a row.
struct Bar<'a> {
    row: usize,
    part: &'a str,
    /// Depths at which it begins and ends [mm].
    range: [f64; 2],
}

/// One row per threshold: the depth range in which each part exceeds it, pale where the depth is not resolved, else with its error bar.
/// Neither goes on where the tissue ends.
pub(super) fn depth_picture(area: &DrawingArea<SVGBackend, Shift>, stresses: &[SignificantStress]) -> Drawn {
    let (bars, errors) = (bars(stresses), error_bars(stresses));
    let ends = bars.iter().map(|bar| bar.range[1]).chain(errors.iter().map(|(_, [_, high])| *high));
    let deepest = ends.fold(0.0, f64::max).max(1e-3);
    let (parts, rows) = (parts(&bars), stresses.len() as f64);
    let end_of_tissue = stresses.iter().find_map(end_of_tissue).filter(|end| *end < 1.05 * deepest);
    let names_in_legend =
        parts.len() + usize::from(!errors.is_empty()) + usize::from(end_of_tissue.is_some());
    area.fill(&WHITE)?;
    let mut chart = ChartBuilder::on(area)
        .margin(12)
        .x_label_area_size(50)
        .y_label_area_size(92)
        .build_cartesian_2d(0.0..1.05 * deepest, 0.0..with_room([0.0, rows], names_in_legend))?;
    chart
        .configure_mesh()
        .x_desc("depth below the surface [mm]")
        .disable_y_mesh()
        .light_line_style(TRANSPARENT)
        .y_labels(2 * stresses.len() + 3)
        .y_label_formatter(&|_| String::new())
        .label_style((FONT, 17))
        .axis_desc_style((FONT, 18))
        .draw()?;
    // One bar for each part and threshold.
    for (part, colour) in parts.iter().zip(COLOURS.iter().cycle().copied()) {
        let drawn =
            bars.iter().filter(|bar| bar.part == *part).map(|&Bar { row, range: [from, to], .. }| {
                let (y, strength) = (row as f64, STRENGTH[usize::from(!is_resolved(&stresses[row]))]);
                // A layer of one quadrature point has no thickness; a thin bar is drawn.
                let corners = [(from, y + 0.22), (to.max(from + 0.004 * deepest), y + 0.78)];
                Rectangle::new(corners, colour.mix(strength).filled())
            });
        chart.draw_series(drawn)?.label(*part).legend(move |(x, y)| {
            Rectangle::new([(x, y - 5), (x + 18, y + 5)], colour.mix(STRENGTH[0]).filled())
        });
    }
    // The errors, with one name for all.
    if !errors.is_empty() {
        let style = BLACK.stroke_width(2);
        let error = |(row, ends): (usize, [f64; 2])| {
            PathElement::new(ends.map(|depth| (depth.max(0.0), row as f64 + 0.5)), style)
        };
        chart
            .draw_series(errors.into_iter().map(error))?
            .label("numerical error of the depth")
            .legend(move |(x, y)| PathElement::new([(x, y), (x + 18, y)], style));
    }
    if let Some(end) = end_of_tissue {
        let line = PathElement::new([(end, 0.0), (end, rows)], BLACK.stroke_width(1));
        let symbol =
            |(x, y): (i32, i32)| PathElement::new([(x + 9, y - 6), (x + 9, y + 6)], BLACK.stroke_width(1));
        chart.draw_series(std::iter::once(line))?.label("end of the tissue").legend(symbol);
    }
    names(area, &chart, stresses)?;
    legend(&mut chart)
}

/// The thresholds beside their rows, and which depths are not resolved.
fn names(
    area: &DrawingArea<SVGBackend, Shift>,
    chart: &Chart<'_, '_>,
    stresses: &[SignificantStress],
) -> Drawn {
    for (row, stress) in stresses.iter().enumerate() {
        let (_, pixel) = chart.backend_coord(&(0.0, row as f64 + 0.5));
        let name = format!("> {} kPa", short(1e-3 * stress.threshold_pa));
        area.draw(&Text::new(name, (8, pixel - 8), (FONT, 18).into_font()))?;
        if !stress.layers.is_empty() && !is_resolved(stress) {
            area.draw(&Text::new("not resolved", (8, pixel + 10), (FONT, 13).into_font()))?;
        }
    }
    Ok(())
}

fn is_resolved(stress: &SignificantStress) -> bool {
    stress.depth_mm.as_ref().is_some_and(|depth| depth.error.is_resolved())
}

/// The largest depth of the tissue, if it is known [mm].
fn end_of_tissue(stress: &SignificantStress) -> Option<f64> {
    stress.depth_mm.as_ref()?.possible[1]
}

/// The bars of all rows, none of them beyond the end of the tissue.
fn bars(stresses: &[SignificantStress]) -> Vec<Bar<'_>> {
    let bars = stresses.iter().enumerate().flat_map(|(row, stress)| {
        let end = end_of_tissue(stress).unwrap_or(f64::INFINITY);
        stress.layers.iter().filter_map(move |layer| {
            let range = layer.depth_mm?.map(|depth| depth.min(end));
            Some(Bar { row, part: layer.part.as_str(), range })
        })
    });
    bars.collect()
}

/// The ends of the depths that are resolved, with their rows [mm].
fn error_bars(stresses: &[SignificantStress]) -> Vec<(usize, [f64; 2])> {
    let resolved = stresses.iter().enumerate().filter(|(_, stress)| is_resolved(stress));
    resolved.filter_map(|(row, stress)| Some((row, stress.depth_mm.as_ref()?.ends()))).collect()
}

/// The parts from the surface inwards, by their first depths.
fn parts<'a>(bars: &[Bar<'a>]) -> Vec<&'a str> {
    let mut parts: Vec<(&str, f64)> = Vec::new();
    for Bar { part, range: [from, _], .. } in bars {
        match parts.iter_mut().find(|(name, _)| name == part) {
            Some((_, first)) => *first = first.min(*from),
            None => parts.push((part, *from)),
        }
    }
    parts.sort_by(|a, b| a.1.total_cmp(&b.1));
    parts.into_iter().map(|(part, _)| part).collect()
}

#[cfg(test)]
#[allow(clippy::float_cmp)] // these values are exact
mod tests {
    use super::super::tests::example;
    use super::*;
    use serde_json::{Value, json};

    /// Bars, error bars and picture of the first threshold of the example, with a depth of 24 ± 3 mm in a tissue of 25 mm.
    fn drawn(depth: &Value) -> (f64, Vec<[f64; 2]>, String) {
        let mut run = example();
        let stresses = &mut run.summary["results"]["tissue"]["significant_stress"];
        let layer = json!({"part": "muscle", "depth_mm": [4.0, 26.0], "volume_mm3": 9.0});
        (stresses[0]["depth_mm"], stresses[0]["layers"]) = (depth.clone(), json!([layer]));
        run.take_numbers().unwrap();
        let stresses = &run.results().unwrap().tissue.as_ref().unwrap().significant_stress[..1];
        let mut svg = String::new();
        {
            let area = SVGBackend::with_string(&mut svg, (640, 380)).into_drawing_area();
            depth_picture(&area, stresses).unwrap();
        }
        let errors = error_bars(stresses).into_iter().map(|(_, ends)| ends).collect();
        (bars(stresses)[0].range[1], errors, svg)
    }

    #[test]
    fn no_bar_goes_on_where_the_tissue_ends() {
        let mut depth = super::super::tests::quantity_of(24.0, 3.0, true);
        depth["possible"] = json!([0.0, 25.0]);
        let (end, errors, svg) = drawn(&depth);
        assert!(end <= 25.0 && errors == [[21.0, 25.0]], "{end}, {errors:?}");
        assert!(svg.contains("end of the tissue") && !svg.contains("not resolved"), "{svg}");
        assert!(svg.contains("numerical error of the depth"), "{svg}");
        let mut unresolved = super::super::tests::quantity_of(24.0, 30.0, false);
        unresolved["possible"] = json!([0.0, 25.0]);
        let (_, errors, svg) = drawn(&unresolved);
        assert!(
            errors.is_empty() && svg.contains("not resolved") && !svg.contains("numerical error"),
            "{svg}"
        );
    }
}
