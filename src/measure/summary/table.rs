//! The summary as a plain-text table.

use super::Summary;
use super::injury::InjuryMeasure;
use super::listing::{Group, listing};
use super::numerics::numerics_group;
use super::results::Shown;
use super::written::seconds;
use crate::step::Ending;
use std::fmt::Write as _;

/// Renders the summary as plain text, one number per line, with its unit and error.
pub fn render_table(summary: &Summary) -> String {
    let mut table = Table::default();
    table.outcome(summary);
    table.results(summary);
    table.criteria(&summary.injury_measures);
    table.sentences("In plain words", summary.plain_words.iter());
    table.numerics(summary);
    let is_new = |warning: &&String| !summary.plain_words.contains(warning);
    table.sentences("Warnings", summary.warnings.iter().filter(is_new));
    table.line(&format!("\n{}", summary.notice));
    table.0
}

#[derive(Default)]
struct Table(String);

impl Table {
    fn line(&mut self, line: &str) {
        // Writing to a String cannot fail.
        let _ = writeln!(self.0, "{line}");
    }
    fn heading(&mut self, heading: &str) {
        self.line(&format!("\n{heading}"));
    }
    fn row(&mut self, name: &str, value: &str, remark: &str) {
        self.line(format!("  {name:<42} {value:<24} {remark}").trim_end());
    }
    fn sentences<'a>(&mut self, heading: &str, sentences: impl Iterator<Item = &'a String>) {
        let mut sentences = sentences.peekable();
        if sentences.peek().is_some() {
            self.heading(heading);
        }
        sentences.for_each(|words| self.line(&format!("  {words}")));
    }

    /// How the run ended.
    fn outcome(&mut self, summary: &Summary) {
        self.line(&format!(
            "{}: {} at {} of {}, {} steps",
            summary.scene,
            ending(summary.ending.as_ref()),
            seconds(summary.time_s),
            seconds(summary.end_time_s),
            summary.steps
        ));
        if let Some(failure) = summary.ending.as_ref().and_then(Ending::failure) {
            self.line(&format!("  {failure}"));
            failure.place().iter().for_each(|place| self.line(&format!("  where: {place}")));
        }
        if summary.values().nothing_touched {
            self.line("  Nothing touched: there was no impact to evaluate.");
        }
    }

    /// The numbers, or why they are withheld.
    fn results(&mut self, summary: &Summary) {
        match &summary.results {
            Shown::Withheld { reason, remedy, .. } => {
                self.line(&format!("  The results are withheld: {reason}. {remedy}"));
            }
            Shown::Results(results) => {
                for group in listing(results) {
                    self.group(&group);
                }
            }
        }
    }

    /// Quality of the computation, its checks, and where the error bars come from.
    fn numerics(&mut self, summary: &Summary) {
        self.group(&numerics_group(&summary.numerics, &summary.relaxation));
        for gate in &summary.gates {
            let verdict = format!("{:?}", gate.result).to_lowercase();
            self.row(
                &format!("check {}", gate.name),
                &format!("{verdict} ({:.2e} of {:.0e})", gate.value, gate.limit),
                "",
            );
        }
        self.line(&format!("  error bars: {}", summary.error_bars));
        summary.accuracy.iter().for_each(|accuracy| self.line(&format!("  {}", accuracy.words())));
    }

    fn group(&mut self, group: &Group) {
        self.heading(&group.title);
        if group.nothing_touched {
            self.line("  Nothing touched.");
            return;
        }
        for row in &group.rows {
            let indent = if row.is_part { "  " } else { "" };
            self.row(&format!("{indent}{}", row.title), &row.value(), &row.remark());
        }
    }

    fn criteria(&mut self, criteria: &[InjuryMeasure]) {
        if criteria.is_empty() {
            return;
        }
        self.heading("Injury criteria");
        for criterion in criteria {
            let fields = criterion.missing.iter().map(|field| format!("`{field}`")).collect::<Vec<_>>();
            let fields = if fields.is_empty() { String::new() } else { format!(" ({})", fields.join(", ")) };
            self.row(&criterion.title, &criterion.in_words(), &format!("{}{fields}", criterion.statement));
        }
    }
}

fn ending(ending: Option<&Ending>) -> &'static str {
    match ending {
        None => "running",
        Some(Ending::Failed { .. }) => "FAILED",
        Some(ending) => ending.name(),
    }
}
