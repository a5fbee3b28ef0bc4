//! Measured curves in CSV files: a header with the names of the two columns, then numbers. Lines that begin with `#` are comments.

use super::document::{TestDocument, TestKind};
use crate::scene::problem::{Pointer, Problem};
use crate::scene::validate::Findings;
use std::io;

/// Lines of one file that are reported one by one.
const REPORTED_LINES: usize = 20;

/// Reads the file of every test that names one.
pub(super) fn read_curves(
    tests: &mut [TestDocument],
    file: &dyn Fn(&str) -> io::Result<Vec<u8>>,
) -> Findings {
    let mut out = Findings::default();
    for (index, test) in tests.iter_mut().enumerate() {
        let here = TestDocument::place(index).key("csv");
        let Some(name) = &test.csv else { continue };
        if !test.points.is_empty() {
            let message = "the test has its points twice: in the question and in a file";
            out.push(
                Problem::error("contradiction", &here, message)
                    .value(name.as_str())
                    .limit("one of \"points\" and \"csv\"")
                    .remedy("remove one of them"),
            );
            continue;
        }
        match file(name).map(String::from_utf8) {
            Ok(Ok(text)) => test.points = read_points(&text, test.kind, &here, &mut out),
            Ok(Err(_)) => out.push(
                Problem::error("not_utf8", &here, format!("{name} is not UTF-8"))
                    .value(name.as_str())
                    .limit("a text file in UTF-8")
                    .remedy("save the file as CSV in UTF-8"),
            ),
            Err(error) => out.push(
                Problem::error("unreadable_file", &here, format!("{name} cannot be read: {error}"))
                    .value(name.as_str())
                    .limit("a readable file")
                    .remedy("give its path relative to the folder of the question"),
            ),
        }
    }
    out
}

/// The points of a text; each line that is none is a problem.
fn read_points(text: &str, kind: TestKind, here: &Pointer, out: &mut Findings) -> Vec<[f64; 2]> {
    let columns = kind.columns().join(",");
    let mut lines = text
        .trim_start_matches('\u{feff}')
        .lines()
        .enumerate()
        .map(|(i, line)| (i + 1, line.trim()))
        .filter(|(_, line)| !line.is_empty() && !line.starts_with('#'));
    // The header, whose names carry the units.
    let header = lines.next().map_or("", |(_, line)| line);
    let is_header = header.split(',').map(str::trim).eq(kind.columns());
    out.require(is_header, || {
        Problem::error("wrong_header", here, "the file does not begin with the names of its columns")
            .value(header)
            .limit(columns.as_str())
            .remedy("convert to these units and name the columns so")
    });
    if !is_header {
        return Vec::new();
    }
    // The points.
    let mut wrong = 0;
    let mut points = Vec::new();
    for (number, line) in lines {
        if let Some(point) = point_of(line) {
            points.push(point);
            continue;
        }
        wrong += 1;
        if wrong <= REPORTED_LINES {
            out.push(
                Problem::error("not_a_point", here, format!("line {number} is not a point of the curve"))
                    .value(line)
                    .limit("two finite numbers, separated by a comma")
                    .remedy(format!("write {columns}, decimal points, no units")),
            );
        }
    }
    out.require(wrong <= REPORTED_LINES, || {
        let more = wrong - REPORTED_LINES;
        Problem::error("not_a_point", here, format!("{more} more lines are not points of the curve"))
            .value(more)
            .limit("0")
            .remedy("correct the lines above and look for others like them")
    });
    points
}

fn point_of(line: &str) -> Option<[f64; 2]> {
    let (x, y) = line.split_once(',')?;
    let number = |text: &str| text.trim().parse::<f64>().ok().filter(|number| number.is_finite());
    Some([number(x)?, number(y)?])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn points_are_read_and_every_wrong_line_is_reported() {
        let mut out = Findings::default();
        let text = "\u{feff}# pull\nstretch, nominal_stress_pa\n1.1,2e3\n\n1.2;3e3\n 1.3 , 4000 \n1.4,inf\n";
        let points = read_points(text, TestKind::Uniaxial, &Pointer::root(), &mut out);
        assert_eq!(points, [[1.1, 2e3], [1.3, 4e3]]);
        let messages: Vec<_> = out.0.iter().map(|p| p.message.as_str()).collect();
        assert_eq!(messages, ["line 5 is not a point of the curve", "line 7 is not a point of the curve"]);

        let mut out = Findings::default();
        assert!(read_points("1.1,2e3\n", TestKind::Shear, &Pointer::root(), &mut out).is_empty());
        let found = out.0.into_vec();
        assert_eq!((&*found[0].code, found[0].limit.as_str()), ("wrong_header", "shear,nominal_stress_pa"));
    }
}
