//! Performance profile of solvers (Dolan & Moré 2002) as SVG: the fraction of problems on which a solver is within a
//! factor τ of the fastest.

use crate::study::palette::COLOURS;
use plotters::prelude::*;

/// Times of one solver on all problems.
pub struct Timing {
    /// Name of the solver.
    pub solver: &'static str,
    /// Processor time of each problem [s]; `None` where it did not converge.
    pub cpu_s: Vec<Option<f64>>,
}

const SIZE: (u32, u32) = (900, 600);
/// Largest factor τ shown.
const LARGEST: f64 = 1000.0;

/// Draws the profile as SVG text.
///
/// # Errors
/// The message of the drawing library.
pub fn profile_picture(tolerance: f64, timings: &[Timing]) -> Result<String, String> {
    let mut svg = String::new();
    {
        let area = SVGBackend::with_string(&mut svg, SIZE).into_drawing_area();
        draw(&area, tolerance, timings).map_err(|error| error.to_string())?;
    }
    Ok(svg)
}

fn draw(
    area: &DrawingArea<SVGBackend, plotters::coord::Shift>,
    tolerance: f64,
    timings: &[Timing],
) -> Result<(), Box<dyn std::error::Error>> {
    area.fill(&WHITE)?;
    let problems = timings.first().map_or(0, |timing| timing.cpu_s.len());
    let mut chart = ChartBuilder::on(area)
        .caption(
            format!("{problems} contact problems to a scaled error of {tolerance:e}"),
            ("sans-serif", 22),
        )
        .margin(15)
        .x_label_area_size(45)
        .y_label_area_size(60)
        .build_cartesian_2d((1.0..LARGEST).log_scale(), 0.0..1.02)?;
    chart
        .configure_mesh()
        .x_desc("processor time over that of the fastest, τ [-]")
        .y_desc("fraction of problems solved within τ")
        .light_line_style(TRANSPARENT)
        .draw()?;
    // One step function per solver; the first is emphasised.
    for (i, timing) in timings.iter().enumerate() {
        let style = COLOURS[i % COLOURS.len()].stroke_width(if i == 0 { 3 } else { 2 });
        chart
            .draw_series(LineSeries::new(steps(&ratios(timing, timings)), style))?
            .label(timing.solver)
            .legend(move |(x, y)| PathElement::new([(x, y), (x + 25, y)], style));
    }
    chart
        .configure_series_labels()
        .position(SeriesLabelPosition::LowerRight)
        .background_style(WHITE.mix(0.8))
        .border_style(BLACK)
        .draw()?;
    area.present()?;
    Ok(())
}

/// Time relative to the fastest for every problem; infinite if not converged.
fn ratios(timing: &Timing, all: &[Timing]) -> Vec<f64> {
    let fastest = |k: usize| all.iter().filter_map(|t| t.cpu_s[k]).fold(f64::INFINITY, f64::min);
    timing.cpu_s.iter().enumerate().map(|(k, cpu)| cpu.map_or(f64::INFINITY, |s| s / fastest(k))).collect()
}

/// Corners of the step function: (τ, fraction of ratios within τ).
fn steps(ratios: &[f64]) -> Vec<(f64, f64)> {
    let mut sorted: Vec<f64> = ratios.iter().copied().filter(|r| *r <= LARGEST).collect();
    sorted.sort_by(f64::total_cmp);
    let fraction = |count: usize| count as f64 / ratios.len() as f64;
    let mut points = vec![(1.0, fraction(sorted.iter().filter(|r| **r <= 1.0).count()))];
    for (i, &ratio) in sorted.iter().enumerate().filter(|(_, r)| **r > 1.0) {
        points.extend([(ratio, fraction(i)), (ratio, fraction(i + 1))]);
    }
    points.push((LARGEST, fraction(sorted.len())));
    points
}

#[cfg(test)]
#[allow(clippy::float_cmp)] // exactly is what is meant
mod tests {
    use super::*;

    #[test]
    fn a_staircase_counts_what_is_within_the_factor() {
        let timings = [
            Timing { solver: "a", cpu_s: vec![Some(1.0), Some(4.0), None] },
            Timing { solver: "b", cpu_s: vec![Some(2.0), Some(2.0), Some(1.0)] },
        ];
        assert_eq!(ratios(&timings[0], &timings), [1.0, 2.0, f64::INFINITY]);
        let third = 1.0 / 3.0;
        let expected = [(1.0, third), (2.0, third), (2.0, 2.0 * third), (LARGEST, 2.0 * third)];
        assert_eq!(steps(&ratios(&timings[0], &timings)), expected);
        assert!(profile_picture(1e-8, &timings).is_ok_and(|svg| svg.contains("<svg")));
    }
}
