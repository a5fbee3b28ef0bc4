//! Plots of stress against stretch, as SVG.

use crate::study::palette::COLOURS;
use plotters::prelude::*;

/// One line of a plot.
pub struct Line {
    /// Entry in the legend.
    pub label: String,
    /// Points of the line: stretch or shear [-], stress [Pa].
    pub points: Vec<(f64, f64)>,
}

const SIZE: (u32, u32) = (900, 600);

/// Draws stresses, in a unit appropriate to their size.
///
/// # Errors
/// The message of the drawing library.
pub fn stress_plot(title: &str, axis: &str, lines: &[Line]) -> Result<String, String> {
    let all = || lines.iter().flat_map(|line| &line.points);
    let (unit, scale) = unit_for(all().map(|p| p.1.abs()).fold(0.0, f64::max));
    let x = padded(all().map(|p| p.0));
    let y = padded(all().map(|p| p.1 / scale));
    let mut svg = String::new();
    {
        let area = SVGBackend::with_string(&mut svg, SIZE).into_drawing_area();
        draw(&area, title, axis, unit, scale, [x, y], lines).map_err(|error| error.to_string())?;
    }
    Ok(svg)
}

fn draw(
    area: &DrawingArea<SVGBackend, plotters::coord::Shift>,
    title: &str,
    axis: &str,
    unit: &str,
    scale: f64,
    [x, y]: [std::ops::Range<f64>; 2],
    lines: &[Line],
) -> Result<(), Box<dyn std::error::Error>> {
    area.fill(&WHITE)?;
    let mut chart = ChartBuilder::on(area)
        .caption(title, ("sans-serif", 22))
        .margin(15)
        .x_label_area_size(45)
        .y_label_area_size(75)
        .build_cartesian_2d(x, y)?;
    chart
        .configure_mesh()
        .x_desc(axis)
        .y_desc(format!("stress [{unit}]"))
        .light_line_style(TRANSPARENT)
        .draw()?;
    // One curve per law and stress component.
    for (i, line) in lines.iter().enumerate() {
        let style = COLOURS[i % COLOURS.len()].stroke_width(2);
        let points = line.points.iter().map(|&(x, y)| (x, y / scale));
        // A single point is drawn as a marker.
        if line.points.len() == 1 {
            chart.draw_series(points.map(|p| Circle::new(p, 3, style)))?;
            continue;
        }
        chart
            .draw_series(LineSeries::new(points, style))?
            .label(line.label.as_str())
            .legend(move |(x, y)| PathElement::new([(x, y), (x + 25, y)], style));
    }
    chart
        .configure_series_labels()
        .position(SeriesLabelPosition::UpperLeft)
        .background_style(WHITE.mix(0.8))
        .border_style(BLACK.mix(0.3))
        .draw()?;
    area.present()?;
    Ok(())
}

/// Unit in which the largest stress is a convenient number, and its size [Pa].
fn unit_for(largest: f64) -> (&'static str, f64) {
    match largest {
        x if x >= 1e9 => ("GPa", 1e9),
        x if x >= 1e6 => ("MPa", 1e6),
        x if x >= 1e3 => ("kPa", 1e3),
        _ => ("Pa", 1.0),
    }
}

/// Range of the values, widened by 4 %; never empty.
fn padded(values: impl Iterator<Item = f64>) -> std::ops::Range<f64> {
    let (low, high) = values.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), x| (l.min(x), h.max(x)));
    if low > high {
        return 0.0..1.0;
    }
    let margin = if high > low { 0.04 * (high - low) } else { low.abs().max(1.0) * 0.5 };
    low - margin..high + margin
}
