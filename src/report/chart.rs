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
