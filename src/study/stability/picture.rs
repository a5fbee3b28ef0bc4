//! The matrix as SVG: a row for each axis and time integration, a field for each value, coloured by verdict and energy
//! error.

use super::{Cell, StabilityStudy, Verdict};
use plotters::prelude::*;

/// Width of the labels, width and height of a field [px].
const LABELS: i32 = 350;
const FIELD: (i32, i32) = (118, 34);
const HEAD: i32 = 60;

/// Draws the study.
///
/// # Errors
/// The message of the drawing library.
pub fn picture(study: &StabilityStudy) -> Result<String, String> {
    let rows = rows(study);
    let columns = rows.iter().map(|(_, cells)| cells.len()).max().unwrap_or(0);
    let size = (
        pixel(LABELS, FIELD.0, columns).unsigned_abs() + 20,
        pixel(HEAD, FIELD.1, rows.len()).unsigned_abs() + 20,
    );
    let mut svg = String::new();
    draw(&mut svg, size, study, &rows).map_err(|error| error.to_string())?;
    Ok(svg)
}

type Rows<'a> = Vec<(String, Vec<&'a Cell>)>;

/// The cells of each axis and stepping, in the order in which they were run.
fn rows(study: &StabilityStudy) -> Rows<'_> {
    let mut rows: Rows = Vec::new();
    for cell in &study.cells {
        let name = format!("{} · {}", cell.axis, cell.stepping);
        match rows.iter_mut().find(|(known, _)| *known == name) {
            Some((_, cells)) => cells.push(cell),
            None => rows.push((name, vec![cell])),
        }
    }
    rows
}

fn draw(
    svg: &mut String,
    size: (u32, u32),
    study: &StabilityStudy,
    rows: &Rows,
) -> Result<(), Box<dyn std::error::Error>> {
    let area = SVGBackend::with_string(svg, size).into_drawing_area();
    area.fill(&WHITE)?;
    let text = ("sans-serif", 14).into_font();
    let title = format!(
        "{} of {} physical cells finish within their limits; colour: error of the energy balance",
        study.physical_finished, study.physical
    );
    area.draw(&Text::new(title, (12, 12), ("sans-serif", 16).into_font()))?;
    for (r, (name, cells)) in rows.iter().enumerate() {
        let y = pixel(HEAD, FIELD.1, r);
        area.draw(&Text::new(name.clone(), (12, y + 9), text.clone()))?;
        for (c, cell) in cells.iter().enumerate() {
            let x = pixel(LABELS, FIELD.0, c);
            let corners = [(x, y), (x + FIELD.0 - 3, y + FIELD.1 - 3)];
            area.draw(&Rectangle::new(corners, colour(cell).filled()))?;
            area.draw(&Text::new(cell.value.clone(), (x + 5, y + 2), text.clone()))?;
            area.draw(&Text::new(word(cell), (x + 5, y + 17), ("sans-serif", 11).into_font()))?;
        }
    }
    area.present()?;
    Ok(())
}

/// Start of the field with a number.
fn pixel(first: i32, size: i32, number: usize) -> i32 {
    i32::try_from(number).map_or(i32::MAX, |number| first.saturating_add(size.saturating_mul(number)))
}

fn word(cell: &Cell) -> String {
    match cell.verdict {
        Verdict::Finished => format!("{:.1e}", cell.balance_error),
        Verdict::Refused => "refused".into(),
        Verdict::Diagnosed => cell.ending.replace('_', " "),
        Verdict::Wrong => "WRONG".into(),
    }
}

/// Blue to yellow by the energy error of finished cells; grey for refused, orange and red for failed cells.
fn colour(cell: &Cell) -> RGBColor {
    match cell.verdict {
        Verdict::Finished => {
            // Logarithmic scale from 1e-6 to 1e-2.
            let fraction = ((cell.balance_error.max(1e-6).log10() + 6.0) / 4.0).clamp(0.0, 1.0);
            let blend = |low: f64, high: f64| (low + fraction * (high - low)).round() as u8;
            RGBColor(blend(150.0, 250.0), blend(200.0, 235.0), blend(235.0, 130.0))
        }
        Verdict::Refused => RGBColor(215, 215, 215),
        Verdict::Diagnosed => RGBColor(240, 160, 90),
        Verdict::Wrong => RGBColor(220, 50, 50),
    }
}
