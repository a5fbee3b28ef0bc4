//! The page of the verification tests: what each compares, with what, and the result.
//!
//! ```text
//! CONTUSE_VERIFICATION_RECORDS=target/verification cargo test --release --test verification
//! cargo run --release --example verification_report -- target/verification docs/verification.md
//! ```
//!
//! Pictures are written beside the page, under `pictures/`. Empty the folder of the records by hand before a new run.

use anyhow::{Context as _, Result};
use plotters::prelude::*;
use serde::Deserialize;
use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};

const HEAD: &str = "# Verification\n\n\
    Cases with known answers, and what Contuse computes. Written by\n\n    \
    CONTUSE_VERIFICATION_RECORDS=target/verification cargo test --release --test verification\n    \
    cargo run --release --example verification_report -- target/verification docs/verification.md\n\n\
    from what the tests in `tests/verification/` compare when they run: each row is an assertion that held. A case with several rows of \
    one name (elements, nodes, laws) shows the one nearest to its tolerance, and how many there are.\n\n";

/// One entry in the record of a test.
#[derive(Deserialize)]
#[serde(untagged)]
enum Line {
    Comparison { what: String, exact: f64, computed: f64, tolerance: f64 },
    Order { what: String, errors: Vec<f64>, order: f64, least_order: f64 },
    Picture { picture: String, x: String, y: String, curves: Vec<Curve> },
}

#[derive(Deserialize)]
struct Curve {
    name: String,
    points: Vec<(f64, f64)>,
}

fn main() -> Result<()> {
    let mut arguments = std::env::args().skip(1).map(PathBuf::from);
    let (Some(records), Some(page)) = (arguments.next(), arguments.next()) else {
        anyhow::bail!("usage: verification_report RECORDS PAGE");
    };
    let pictures = page.with_file_name("pictures");
    std::fs::create_dir_all(&pictures)?;
    let mut text = HEAD.to_owned();
    for (module, tests) in read_records(&records)? {
        writeln!(text, "## {}\n\n{}\n", module.replace('_', " "), header(&module)?)?;
        for (test, lines) in tests {
            writeln!(text, "*{}*\n", test.replace('_', " "))?;
            comparisons(&mut text, &lines)?;
            orders(&mut text, &lines)?;
            for (number, line) in lines.iter().enumerate() {
                if let Line::Picture { picture, x, y, curves } = line {
                    let name = format!("verification_{module}_{number}.svg");
                    draw(&pictures.join(&name), picture, [x, y], curves)
                        .with_context(|| format!("{picture} cannot be drawn"))?;
                    writeln!(text, "![{picture}](pictures/{name})\n")?;
                }
            }
        }
    }
    std::fs::write(&page, text.trim_end().to_owned() + "\n")?;
    Ok(())
}

type Tests = BTreeMap<String, Vec<Line>>;

/// The lines of every test, by module.
fn read_records(folder: &Path) -> Result<BTreeMap<String, Tests>> {
    let mut modules: BTreeMap<String, Tests> = BTreeMap::new();
    for entry in std::fs::read_dir(folder).with_context(|| format!("no records in {}", folder.display()))? {
        let path = entry?.path();
        let name = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        let Some((module, test)) = name.split_once('.') else { continue };
        let text = std::fs::read_to_string(&path)?;
        let lines = text.lines().map(serde_json::from_str).collect::<Result<Vec<Line>, _>>();
        let lines = lines.with_context(|| format!("{} is no record", path.display()))?;
        modules.entry(module.to_owned()).or_default().insert(test.to_owned(), lines);
    }
    Ok(modules)
}

/// Description of a test's case and source: the comment at the head of its file.
fn header(module: &str) -> Result<String> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("tests/verification/{module}.rs"));
    let source =
        std::fs::read_to_string(&path).with_context(|| format!("{} does not exist", path.display()))?;
    let lines = source.lines().map_while(|line| line.strip_prefix("//!"));
    let lines: Vec<&str> = lines.map(|line| line.strip_prefix(' ').unwrap_or(line)).collect();
    Ok(lines.join("\n"))
}

fn comparisons(text: &mut String, lines: &[Line]) -> Result<()> {
    // For each name the row closest to its tolerance, in order of first appearance, and the number of rows with that
    // name.
    let mut rows: Vec<(&str, [f64; 3], usize)> = Vec::new();
    let fraction = |[exact, computed, tolerance]: [f64; 3]| (computed - exact).abs() / tolerance;
    for line in lines {
        let Line::Comparison { what, exact, computed, tolerance } = line else { continue };
        let numbers = [*exact, *computed, *tolerance];
        match rows.iter_mut().find(|(known, _, _)| known == what) {
            Some((_, kept, count)) => {
                *count += 1;
                if !(fraction(*kept) >= fraction(numbers)) {
                    *kept = numbers;
                }
            }
            None => rows.push((what, numbers, 1)),
        }
    }
    if rows.is_empty() {
        return Ok(());
    }
    writeln!(text, "| | exact | computed | error | tolerance |\n|---|---|---|---|---|")?;
    for (what, [exact, computed, tolerance], count) in rows {
        let times = if count > 1 { format!(" (of {count})") } else { String::new() };
        let [exact_text, computed_text] = [exact, computed].map(number);
        writeln!(
            text,
            "| {what}{times} | {exact_text} | {computed_text} | {:.1e} | {tolerance:.1e} |",
            (computed - exact).abs()
        )?;
    }
    Ok(writeln!(text)?)
}

fn orders(text: &mut String, lines: &[Line]) -> Result<()> {
    let mut head = "| order of convergence | errors | observed | at least |\n|---|---|---|---|\n";
    for line in lines {
        let Line::Order { what, errors, order, least_order } = line else { continue };
        let errors: Vec<String> = errors.iter().map(|error| format!("{:.1e}", error.abs())).collect();
        writeln!(text, "{head}| {what} | {} | {order:.2} | {least_order} |", errors.join(" → "))?;
        head = "";
    }
    if head.is_empty() {
        writeln!(text)?;
    }
    Ok(())
}

/// Formats a value with seven significant digits.
fn number(value: f64) -> String {
    let magnitude = value.abs();
    if magnitude == 0.0 {
        "0".into()
    } else if (1e-3..1e6).contains(&magnitude) {
        let decimals = (6 - magnitude.log10().floor() as i32).clamp(0, 9);
        format!("{value:.*}", decimals.unsigned_abs() as usize)
    } else {
        format!("{value:.6e}")
    }
}

fn draw(path: &Path, title: &str, [x, y]: [&str; 2], curves: &[Curve]) -> Result<()> {
    let points = || curves.iter().flat_map(|curve| &curve.points);
    let range = |values: &mut dyn Iterator<Item = f64>| {
        let (low, high) = values.fold((f64::MAX, f64::MIN), |(l, h), v| (l.min(v), h.max(v)));
        let room = 0.05 * (high - low).max(f64::MIN_POSITIVE);
        low - room..high + room
    };
    // Axes and labels.
    let area = SVGBackend::new(path, (720, 400)).into_drawing_area();
    area.fill(&WHITE)?;
    let mut chart = ChartBuilder::on(&area)
        .caption(title, ("sans-serif", 18))
        .margin(12)
        .x_label_area_size(40)
        .y_label_area_size(70)
        .build_cartesian_2d(range(&mut points().map(|p| p.0)), range(&mut points().map(|p| p.1)))?;
    chart
        .configure_mesh()
        .x_desc(x)
        .y_desc(y)
        .light_line_style(TRANSPARENT)
        .x_label_formatter(&|x| format!("{x:.3e}"))
        .y_label_formatter(&|y| format!("{y:.3e}"))
        .draw()?;
    // Curves and legend.
    for (i, curve) in curves.iter().enumerate() {
        let colour = contuse::study::palette::COLOURS[i % contuse::study::palette::COLOURS.len()];
        chart
            .draw_series(LineSeries::new(curve.points.iter().copied(), colour))?
            .label(&curve.name)
            .legend(move |(x, y)| PathElement::new([(x, y), (x + 16, y)], colour));
    }
    let labels = &mut chart.configure_series_labels();
    labels.position(SeriesLabelPosition::UpperRight).background_style(WHITE.mix(0.8)).draw()?;
    area.present()?;
    Ok(())
}
