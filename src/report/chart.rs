//! What the charts of a report have in common.

use plotters::prelude::*;

/// Font of all texts.
pub(super) const FONT: &str = "sans-serif";

/// Whether a drawing succeeded.
pub(super) type Drawn = Result<(), Box<dyn std::error::Error>>;

/// A chart with two linear axes.
pub(super) type Chart<'a, 'b> = ChartContext<
    'a,
    SVGBackend<'b>,
    Cartesian2d<plotters::coord::types::RangedCoordf64, plotters::coord::types::RangedCoordf64>,
>;

/// Height of a row of the legend, and of the rest of it, over that of a chart.
const LEGEND: [f64; 2] = [0.072, 0.1];

/// The upper end of an axis from `low` whose values reach `high`, with room above them for a legend of so many rows.
pub(super) fn with_room([low, high]: [f64; 2], rows: usize) -> f64 {
    let [row, rest] = LEGEND;
    low + (high - low) / (1.0 - (row * rows as f64 + rest).min(0.6))
}

/// The names of what is drawn, in the upper right corner.
pub(super) fn legend<'a, 'b: 'a>(chart: &mut Chart<'a, 'b>) -> Drawn {
    chart
        .configure_series_labels()
        .position(SeriesLabelPosition::UpperRight)
        .label_font((FONT, 17))
        .background_style(WHITE.mix(0.85))
        .border_style(BLACK.mix(0.25))
        .draw()
        .map_err(|error| error.to_string())?;
    Ok(())
}
