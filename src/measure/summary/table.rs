//! The summary as a plain-text table.

use super::Summary;
use super::injury::InjuryMeasure;
use super::of_interest::QuantityOfInterest as Of;
use super::quantity::{ErrorEstimate, Quantity};
use super::results::{Exceeded, Impact, Located, Shown, Split, Tissue};
use super::run_state::RunState;
use super::written::{number, rounded, seconds};
use std::fmt::Write as _;

/// Fraction of the absorbed energy above which work not done through contact gets a row of its own [-].
const NOTABLE_WORK: f64 = 1e-3;

/// Renders the summary as plain text, one number per line, with its unit and error.
pub fn render_table(summary: &Summary) -> String {
    let mut table = Table::default();
    // Outcome of the run.
    table.line(&format!(
        "{}: {} at {} of {}, {} steps",
        summary.scene,
        ending(&summary.state),
        seconds(summary.time_s),
        seconds(summary.end_time_s),
        summary.steps
    ));
    if let RunState::Failed { failure } = &summary.state {
        table.line(&format!("  {failure}"));
    }
    if summary.values().nothing_touched {
        table.line("  Nothing touched: there are no numbers of an impact.");
    }
    // Results, injury criteria and plain words.
    match &summary.results {
        Shown::Withheld { reason, remedy, .. } => {
            table.line(&format!("  The results are withheld: {reason}. {remedy}"));
        }
        Shown::Results(results) => {
            results.impacts.iter().filter(|i| i.is_reported()).for_each(|impact| table.impact(impact));
            if let Some(tissue) = results.tissue.as_ref().filter(|_| !results.nothing_touched) {
                table.tissue(tissue);
            }
        }
    }
    table.criteria(&summary.injury_measures);
    if !summary.plain_words.is_empty() {
        table.heading("In plain words");
        summary.plain_words.iter().for_each(|words| table.line(&format!("  {words}")));
    }
    // Numerical quality and gates.
    let n = &summary.numerics;
    table.heading("Numerics");
    if let Some(J) = n.smallest_jacobian {
        table.row("smallest Jacobian J", &format!("{J:.4}"), "");
    }
    if let Some(fraction) = n.active_element_fraction {
        table.row("elements evaluated, mean over the steps", &percent(fraction), "");
    }
    table.row("error of the energy balance", &percent(n.balance_error), "");
    let numerical = format!(
        "{} J ({})",
        number(n.numerical_contact_dissipation_j),
        percent(n.numerical_contact_dissipation_fraction)
    );
    table.row("numerical contact dissipation", &numerical, "");
    if n.rigid_impact_dissipation_j > 0.0 {
        let lost = format!("{} J", number(n.rigid_impact_dissipation_j));
        table.row("lost by rigid bodies that stop each other", &lost, "they do not rebound");
    }
    table.row("friction dissipation", &format!("{} J", number(n.friction_dissipation_j)), "");
    for branch in &summary.relaxation {
        table.row(&branch.title(), &branch.in_words(), "");
    }
    if n.hourglass_energy_fraction > 0.0 {
        table.row("strain energy in the stabilisation", &percent(n.hourglass_energy_fraction), "");
    }
    let deepest = percent(n.deepest_penetration_fraction);
    table.row(
        "deepest penetration",
        &format!("{} mm ({deepest} of a face)", number(1e3 * n.deepest_penetration_m)),
        "",
    );
    for gate in &summary.gates {
        let verdict = format!("{:?}", gate.result).to_lowercase();
        table.row(
            &format!("gate {}", gate.name),
            &format!("{verdict} ({:.2e} of {:.0e})", gate.value, gate.limit),
            "",
        );
    }
    table.line(&format!("  error bars: {}", summary.error_bars));
    summary.accuracy.iter().for_each(|accuracy| table.line(&format!("  {}", accuracy.words())));
    if !summary.warnings.is_empty() {
        table.heading("Warnings");
        summary.warnings.iter().for_each(|warning| table.line(&format!("  {warning}")));
    }
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
    fn quantity(&mut self, name: &str, quantity: &Quantity, unit: &str) {
        self.row(name, &plain(quantity, 1.0, unit), &error_of(quantity, 1.0, unit));
    }
    /// A quantity of interest, with a remark on what it is exactly.
    fn of_interest(&mut self, of: Of, exactly: &str, quantity: &Quantity) {
        let separator = if exactly.is_empty() { "" } else { ", " };
        self.quantity(&format!("{}{separator}{exactly}", of.title()), quantity, of.unit());
    }
    fn peak(&mut self, name: &str, located: Option<&Located>, scale: f64, unit: &str) {
        match located {
            Some(located) => self.at(name, &located.quantity, located.time_s, scale, unit),
            None => self.row(name, "-", "not evaluated after the start, or beyond the limit of a law"),
        }
    }
    fn exceeded(&mut self, name: &str, exceeded: &Exceeded, scale: f64, unit: &str) {
        self.at(name, &exceeded.quantity, exceeded.time_s, scale, unit);
    }
    /// The largest value over time, with its time [s].
    fn at(&mut self, name: &str, quantity: &Quantity, time_s: f64, scale: f64, unit: &str) {
        let remark = format!("at {}, {}", seconds(time_s), error_of(quantity, scale, unit));
        self.row(name, &plain(quantity, scale, unit), &remark);
    }

    fn impact(&mut self, impact: &Impact) {
        self.heading(&format!("Contact {}", impact.pair));
        if impact.contact_span_s.is_none() {
            self.line("  Nothing touched.");
            return;
        }
        self.of_interest(Of::PeakForceN, &impact.force_average, &impact.peak_force_n);
        self.row("  at", &time(&impact.peak_force_time_s), "");
        self.row(
            "peak force of a single step",
            &plain(&impact.peak_step_force_n, 1.0, "N"),
            "not a converged quantity",
        );
        self.of_interest(Of::ImpulseNS, "", &impact.impulse_n_s);
        let duration = &impact.contact_duration_s;
        let error = match &duration.error {
            ErrorEstimate::Estimated(error) => format!("± {}", seconds(error.total)),
            ErrorEstimate::NotEstimated | ErrorEstimate::NothingTouched => error_of(duration, 1.0, "s"),
        };
        let going_on = if impact.contact_ended { error } else { format!("{error}; contact has not ended") };
        self.row("duration of contact", &time(duration), &going_on);
        if impact.touches_in_points {
            return;
        }
        self.of_interest(Of::PatchAreaMm2, "mean area", &impact.patch_area_mm2);
        let axes = [&impact.patch_long_axis_mm, &impact.patch_short_axis_mm]
            .map(|q| in_brackets(q, number(q.value)))
            .join(" × ");
        self.row("  axes", &format!("{axes} mm"), &format!("{} nodes across", impact.nodes_across_patch[0]));
        self.of_interest(Of::LargestPatchAreaMm2, "area", &impact.largest_patch_area_mm2);
    }

    fn tissue(&mut self, tissue: &Tissue) {
        self.heading("Tissue");
        if tissue.has_moving_frame() {
            let [x, y, z] = tissue.frame_velocity_m_per_s.map(number);
            self.row("energies in the tissue's frame, moving at", &format!("({x}, {y}, {z}) m/s"), "");
        }
        self.of_interest(Of::EnergyGivenJ, "at the end", &tissue.energy_given_j);
        self.of_interest(Of::AbsorbedEnergyJ, "at the end", &tissue.absorbed_energy_j);
        self.row("  from the work of the reactions", &plain(&tissue.absorbed_energy_by_work_j, 1.0, "J"), "");
        self.split(&tissue.absorbed_split, &tissue.absorbed_energy_j);
        self.quantity("absorbed energy, at its peak", &tissue.peak_absorbed_energy_j, "J");
        self.row("  at", &time(&tissue.peak_absorbed_energy_time_s), "");
        self.split(&tissue.peak_absorbed_split, &tissue.peak_absorbed_energy_j);
        if let Some(loss) = &tissue.projectile_loss_j {
            self.quantity("lost by the projectile", loss, "J");
        }
        // Significant stress and doses.
        for s in &tissue.significant_stress {
            let threshold = format!("{} kPa", number(1e-3 * s.threshold_pa));
            if let Some(depth) = &s.depth_mm {
                self.quantity(&format!("depth of von Mises above {threshold}"), depth, "mm");
            }
            self.quantity(&format!("volume of von Mises above {threshold}"), &s.volume_mm3, "mm³");
            if !s.reaches.is_empty() {
                self.row("  reaches", &s.reaches.join(", "), "lower bounds: the model ends there");
            }
        }
        for dose in &tissue.dose_volumes {
            let measure = match dose.measure {
                "principal_strain" => format!("principal strain above {}", number(dose.threshold)),
                _ => format!("energy density above {} kJ/m³", number(1e-3 * dose.threshold)),
            };
            self.quantity(&format!("volume of {measure}"), &dose.volume_mm3, "mm³");
        }
        // Strain and stress: exceeded in volumes, and at points.
        match &tissue.exceeded_in_volume {
            Some(in_volume) => {
                let volume = format!("exceeded in {} mm³", number(in_volume.volume_mm3));
                self.exceeded(&format!("principal strain {volume}"), &in_volume.principal_strain, 1.0, "");
                self.exceeded(&format!("von Mises {volume}"), &in_volume.von_mises_pa, 1e-3, "kPa");
            }
            None => self.row(
                Of::PrincipalStrainInVolume.title(),
                "-",
                "not evaluated after the start, beyond the limit of a law, or less tissue than that",
            ),
        }
        for of in &tissue.percentiles {
            if let Some(mps95) = &of.mps95 {
                self.exceeded(&format!("MPS95 of {}", of.part), mps95, 1.0, "");
            }
        }
        self.peak("peak von Mises stress", tissue.peaks.peak_von_mises_pa.as_ref(), 1e-3, "kPa");
        self.peak(Of::PrincipalStrain.title(), tissue.peaks.peak_principal_strain.as_ref(), 1.0, "");
        let density = tissue.peaks.peak_strain_energy_density_j_per_m3.as_ref();
        self.peak("peak strain energy density", density, 1e-3, "kJ/m³");
        self.peak(Of::DeflectionMm.title(), Some(&tissue.deflection_mm), 1.0, "mm");
    }

    fn criteria(&mut self, criteria: &[InjuryMeasure]) {
        if criteria.is_empty() {
            return;
        }
        self.heading("Injury criteria");
        for criterion in criteria {
            let unit = if criterion.unit == "-" { String::new() } else { format!(" {}", criterion.unit) };
            // A criterion that follows from the scene alone has no error.
            let is_plain = criterion.error.as_ref().is_none_or(ErrorEstimate::is_resolved);
            let shown = |v: f64| if is_plain { number(v) } else { format!("({})", number(v)) };
            let value = criterion.value.map_or_else(|| "-".into(), |v| format!("{}{unit}", shown(v)));
            let fields = criterion.missing.iter().map(|field| format!("`{field}`")).collect::<Vec<_>>();
            let fields = if fields.is_empty() { String::new() } else { format!(" ({})", fields.join(", ")) };
            self.row(criterion.title, &value, &format!("{}{fields}", criterion.statement));
        }
    }

    /// Components of an absorbed energy, which add up to it.
    fn split(&mut self, split: &Split, absorbed: &Quantity) {
        self.quantity("  strain", &split.strain_j, "J");
        self.quantity("  + kinetic", &split.kinetic_j, "J");
        self.quantity("  + dissipated", &split.dissipated_j, "J");
        if split.not_from_contact_j.value.abs() > NOTABLE_WORK * absorbed.value.abs() {
            self.quantity("  - work of loads and position projection", &split.not_from_contact_j, "J");
        }
    }
}

/// The number with its unit; in brackets if its error is unknown or exceeds the value.
fn plain(quantity: &Quantity, scale: f64, unit: &str) -> String {
    format!("{} {unit}", in_brackets(quantity, number(scale * quantity.value)))
}

/// The formatted number, in brackets unless it is resolved.
fn in_brackets(quantity: &Quantity, shown: String) -> String {
    if quantity.error.is_resolved() { shown } else { format!("({shown})") }
}

/// A time, in brackets unless it is resolved.
fn time(quantity: &Quantity) -> String {
    in_brackets(quantity, seconds(quantity.value))
}

/// "± 200 N (mesh 150, step 45, contact 5)".
fn error_of(quantity: &Quantity, scale: f64, unit: &str) -> String {
    let error = match &quantity.error {
        ErrorEstimate::Estimated(error) => error,
        ErrorEstimate::NotEstimated => return "error not estimated".into(),
        ErrorEstimate::NothingTouched => return "nothing touched".into(),
    };
    let [total, mesh, step, contact] =
        [error.total, error.mesh, error.step, error.contact].map(|e| rounded(scale * e));
    // Others are shown only where they are more than rounding.
    let notable = [("bulk modulus", error.bulk_modulus), ("resolution", error.resolution)];
    let notable = notable.into_iter().filter(|(_, part)| *part > 0.01 * error.total);
    let others: Vec<String> =
        notable.map(|(name, part)| format!(", {name} {}", rounded(scale * part))).collect();
    let others = others.concat();
    let verdict = if error.resolved { "" } else { ": NOT RESOLVED" };
    let unit = if unit.is_empty() { String::new() } else { format!(" {unit}") };
    format!("± {total}{unit} (mesh {mesh}, step {step}, contact {contact}{others}){verdict}")
}

fn ending(state: &RunState) -> &'static str {
    match state {
        RunState::Running => "running",
        RunState::Finished => "finished",
        RunState::Cancelled => "cancelled",
        RunState::Failed { .. } => "FAILED",
    }
}

fn percent(fraction: f64) -> String {
    format!("{} %", number(100.0 * fraction))
}

#[cfg(test)]
mod tests {
    use super::super::{Estimate, GateResult};
    use super::*;

    #[test]
    fn the_parts_of_an_absorbed_energy_add_up_and_show_what_is_not_resolved() {
        let quantity = |value: f64, error: f64| Quantity {
            value,
            error: ErrorEstimate::Estimated(Estimate {
                bulk_modulus: 0.0,
                total: error,
                mesh: error,
                step: 0.0,
                contact: 0.0,
                resolution: 0.0,
                resolved: error < value.abs(),
            }),
            gate: GateResult::Passed,
        };
        let shown = |not_from_contact: f64| {
            let split = Split {
                strain_j: quantity(2.0, 0.1),
                kinetic_j: quantity(1.0, 3.0),
                recoverable_j: quantity(3.0, 0.1),
                dissipated_j: quantity(0.5, 0.01),
                not_from_contact_j: quantity(not_from_contact, 0.001),
            };
            let mut table = Table::default();
            table.split(&split, &quantity(3.5 - not_from_contact, 0.1));
            table.0
        };
        let (plain, loaded) = (shown(1e-4), shown(0.3));
        assert!(plain.contains("(1.000) J") && plain.contains("± 3.0 J"), "{plain}");
        assert!(plain.contains("2.000 J") && plain.lines().count() == 3, "{plain}");
        let last = loaded.lines().last().unwrap_or_default();
        assert!(
            last.contains("- work of loads and position projection") && last.contains("0.3000 J"),
            "{last}"
        );
    }
}
