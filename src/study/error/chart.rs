//! Error against run time as SVG: one panel per quantity, both axes logarithmic, the Pareto front as a line.

use super::{ErrorStudy, Row};
use crate::measure::QuantityOfInterest;
use crate::study::palette::COLOURS;
use plotters::coord::Shift;
use plotters::prelude::*;

type Area<'a> = DrawingArea<SVGBackend<'a>, Shift>;
type Failure = Box<dyn std::error::Error>;

/// Size of a panel [px].
const PANEL: (u32, u32) = (560, 400);
const COLUMNS: usize = 2;
/// Lower bound of the error axis [-].
const LEAST_ERROR: f64 = 1e-5;

/// Draws the study.
///
/// # Errors
/// The message of the drawing library.
pub fn chart(study: &ErrorStudy) -> Result<String, String> {
    let quantities: Vec<QuantityOfInterest> = study.references.keys().copied().collect();
    let rows = quantities.len().div_ceil(COLUMNS).max(1);
    let size = (PANEL.0 * COLUMNS as u32, PANEL.1 * rows as u32);
    let mut svg = String::new();
    {
        let area = SVGBackend::with_string(&mut svg, size).into_drawing_area();
        let drawn = area.fill(&WHITE).map_err(Failure::from).and_then(|()| {
            let panels = area.split_evenly((rows, COLUMNS));
            panels.iter().zip(&quantities).try_for_each(|(panel, q)| draw(panel, study, *q))
        });
        drawn.and_then(|()| Ok(area.present()?)).map_err(|error| error.to_string())?;
    }
    Ok(svg)
}

/// Group of a setting: one colour and one legend entry.
fn family(row: &Row) -> String {
    let setting = &row.setting;
    if let Some(solver) = setting.contact_solver {
        let steps = if setting.implicit_step_s.is_some() { ", implicit steps" } else { "" };
        return format!("contact by {}{steps}", solver.method().name());
    }
    let change = match () {
        () if setting.on_facets => "meshes on the facets",
        () if setting.step_divisor > 1.0 => "smaller steps",
        () if setting.contact_tolerance.is_some() => "contact tolerance",
        () if setting.implicit_step_s.is_some() => "implicit steps",
        () if setting.mass_redistribution.is_some() => "redistributed mass",
        () => "meshes",
    };
    setting.formulation_name().map_or_else(|| change.to_owned(), |name| format!("{change}, {name}"))
}

fn draw(area: &Area, study: &ErrorStudy, quantity: QuantityOfInterest) -> Result<(), Failure> {
    // The reference run itself has no error to plot.
    let known = |row: &Row| row.errors.get(&quantity).copied().filter(|error| *error > 0.0);
    let point = |row: &Row| known(row).map(|error| (row.cost_s(), 100.0 * error.max(LEAST_ERROR)));
    let points: Vec<(f64, f64)> = study.rows.iter().filter_map(point).collect();
    let title = quantity.short_title();
    let mut chart = ChartBuilder::on(area)
        .caption(title, ("sans-serif", 18))
        .margin(12)
        .x_label_area_size(40)
        .y_label_area_size(60)
        .build_cartesian_2d(
            decades(points.iter().map(|p| p.0)).log_scale(),
            decades(points.iter().map(|p| p.1)).log_scale(),
        )?;
    chart
        .configure_mesh()
        .x_desc("processor time [s]")
        .y_desc("error [%]")
        .light_line_style(TRANSPARENT)
        .x_label_formatter(&|x| format!("{x}"))
        // Long rows of digits are unreadable as labels.
        .y_label_formatter(&|y| if *y < 1e6 { format!("{y}") } else { format!("{y:e}") })
        .draw()?;
    // Pareto front.
    let mut front: Vec<(f64, f64)> =
        study.rows.iter().filter(|row| row.is_on_front(&study.rows, quantity)).filter_map(point).collect();
    front.sort_by(|a, b| a.0.total_cmp(&b.0));
    chart.draw_series(LineSeries::new(front, BLACK.mix(0.4)))?;
    // Below the uncertainty of the reference an error is meaningless.
    if let Some(reference) = study.references.get(&quantity) {
        let floor = 100.0 * reference.uncertainty() / reference.value().abs();
        if floor.is_finite() && floor > 100.0 * LEAST_ERROR {
            let range = chart.x_range();
            let line = [(range.start, floor), (range.end, floor)];
            chart.draw_series(DashedLineSeries::new(line, 5, 5, BLACK.mix(0.4).into()))?;
        }
    }
    // One series per family of settings.
    let mut families: Vec<String> = Vec::new();
    for name in study.rows.iter().map(family) {
        if !families.contains(&name) {
            families.push(name);
        }
    }
    for (i, name) in families.into_iter().enumerate() {
        let style = COLOURS[i % COLOURS.len()].filled();
        let of_family = study.rows.iter().filter(|row| family(row) == name).filter_map(point);
        // Colours repeat with triangles as markers.
        if i < COLOURS.len() {
            chart
                .draw_series(of_family.map(|p| Circle::new(p, 4, style)))?
                .label(name)
                .legend(move |(x, y)| Circle::new((x + 8, y), 4, style));
        } else {
            chart
                .draw_series(of_family.map(|p| TriangleMarker::new(p, 5, style)))?
                .label(name)
                .legend(move |(x, y)| TriangleMarker::new((x + 8, y), 5, style));
        }
    }
    chart
        .configure_series_labels()
        .position(SeriesLabelPosition::LowerLeft)
        .background_style(WHITE.mix(0.8))
        .border_style(BLACK.mix(0.3))
        .draw()?;
    Ok(())
}

/// Range of whole decades around positive numbers.
fn decades(values: impl Iterator<Item = f64>) -> std::ops::Range<f64> {
    let (low, high) = values
        .filter(|x| x.is_finite() && *x > 0.0)
        .fold((f64::INFINITY, 0.0_f64), |(low, high), x| (low.min(x), high.max(x)));
    if low > high {
        return 1.0..10.0;
    }
    let power = |x: f64| 10_f64.powf(x);
    power(low.log10().floor())..power((high.log10().floor()) + 1.0)
}
