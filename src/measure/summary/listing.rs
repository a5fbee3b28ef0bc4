//! The listing: every number of the results, in one order, that the text, the report and FHIR observations show.

use super::listed::FEW_NODES;
use super::lower_bounds::GREATEST_DEPTH;
use super::of_interest::QuantityOfInterest as Of;
use super::quantity::Quantity;
use super::results::{Exceeded, Impact, Located, Results, SignificantStress, Split, StressedLayer, Tissue};
use super::written::{bare, error_of, marked, number, seconds, short, shown_in, volume, with_unit, within};

/// Fraction of the absorbed energy above which work not done through contact gets a row of its own [-].
const NOTABLE_WORK: f64 = 1e-3;

/// What the absorbed energy is beside the energy given, which is the one of the headline.
const ABOUT_ABSORBED: &str = "the energy given without what the mesh loses where nodes first touch, which a finer mesh passes on to the tissue";

/// Why a number is not resolved whose error is smaller: a largest value at a point.
const AT_A_POINT: &str = "largest at a point, which meshes do not resolve";
/// The same of a value exceeded in a volume.
const IN_FEW_POINTS: &str = "exceeded in a volume of few points, which meshes do not resolve";

/// Strain below which tissue is hardly deformed [-].
const HARDLY: f64 = 0.01;

/// Why a number may be larger after the end of the run.
const LASTS: &str = "contact has not ended";

/// The numbers of one contact, or of the tissue.
pub struct Group<'a> {
    /// Subject of the rows.
    pub title: String,
    /// Whether nothing touched: then the numbers describe no impact.
    pub nothing_touched: bool,
    /// The numbers.
    pub rows: Vec<Row<'a>>,
}

/// One number, or one remark.
pub struct Row<'a> {
    /// What it is.
    pub title: String,
    /// Whether it is a detail of the row before.
    pub is_part: bool,
    /// The quantity of interest that it is, of the contact and the threshold of the headline.
    pub of: Option<Of>,
    /// Name for other systems; absent for details, and for contacts other than that of the headline.
    pub code: Option<String>,
    /// Remark that limits or explains the number.
    pub note: String,
    /// Why the number is not resolved where its error is smaller.
    doubt: &'static str,
    entry: Entry<'a>,
}

/// The value of a row.
enum Entry<'a> {
    /// A quantity with its unit.
    Number(&'a Quantity, &'static str),
    /// Others, as text.
    Words(String),
}

impl<'a> Row<'a> {
    fn number(title: impl Into<String>, quantity: &'a Quantity, unit: &'static str) -> Self {
        Self::new(title.into(), Entry::Number(quantity, unit))
    }
    pub(super) fn words(title: impl Into<String>, words: impl Into<String>) -> Self {
        Self::new(title.into(), Entry::Words(words.into()))
    }
    fn new(title: String, entry: Entry<'a>) -> Self {
        Self { title, is_part: false, of: None, code: None, note: String::new(), doubt: "", entry }
    }
    /// A quantity of interest, with what it is exactly.
    fn of_interest(of: Of, exactly: &str, quantity: &'a Quantity, code: &str) -> Self {
        let separator = if exactly.is_empty() { "" } else { ", " };
        let row = Self::number(format!("{}{separator}{exactly}", of.title()), quantity, of.unit());
        Self { of: Some(of), ..row }.code(code)
    }
    /// A value with the time at which it is largest [s].
    fn at(title: impl Into<String>, quantity: &'a Quantity, time_s: f64, unit: &'static str) -> Self {
        Self::number(title, quantity, unit).note(format!("at {}", seconds(time_s))).growing()
    }
    fn exceeded(title: impl Into<String>, exceeded: &'a Exceeded, unit: &'static str) -> Self {
        Self::at(title, &exceeded.quantity, exceeded.time_s, unit).unresolved_since(IN_FEW_POINTS)
    }
    fn peak(title: &str, located: Option<&'a Located>, unit: &'static str) -> Self {
        match located {
            Some(located) => {
                Self::at(title, &located.quantity, located.time_s, unit).unresolved_since(AT_A_POINT)
            }
            None => {
                Self::words(title, "-").note("not evaluated after the start, or beyond the limit of a law")
            }
        }
    }

    fn part(self) -> Self {
        Self { is_part: true, ..self }
    }
    pub(super) fn note(self, note: impl Into<String>) -> Self {
        Self { note: note.into(), ..self }
    }
    fn unresolved_since(self, doubt: &'static str) -> Self {
        Self { doubt, ..self }
    }
    fn code(self, code: impl Into<String>) -> Self {
        Self { code: Some(code.into()), ..self }
    }
    /// With the reason behind its note where the number is a lower bound, and may be larger after the end of the run.
    fn growing(self) -> Self {
        let is_bound = self.quantity().is_some_and(|(quantity, _)| quantity.is_lower_bound);
        let separator = if self.note.is_empty() { "" } else { ", " };
        if is_bound { Self { note: format!("{}{separator}{LASTS}", self.note), ..self } } else { self }
    }

    /// The quantity with its unit; `None` for words.
    pub fn quantity(&self) -> Option<(&'a Quantity, &'static str)> {
        match self.entry {
            Entry::Number(quantity, unit) => Some((quantity, unit)),
            Entry::Words(_) => None,
        }
    }

    /// The value as text: with its unit, in brackets unless it is resolved, and as "≥" where it is a lower bound.
    pub fn value(&self) -> String {
        match &self.entry {
            Entry::Number(quantity, unit) => with_unit(quantity, unit),
            Entry::Words(words) => words.clone(),
        }
    }

    /// Why the number is not resolved though it exceeds its error; `None` where it is resolved, or does not exceed its error.
    pub fn doubt(&self) -> Option<&'static str> {
        let exceeds_error = |quantity: &Quantity| quantity.error.half_width() < Some(quantity.value.abs());
        let (quantity, _) = self.quantity()?;
        let is_doubtful = quantity.error.is_unresolved() && exceeds_error(quantity);
        Some(self.doubt).filter(|doubt| is_doubtful && !doubt.is_empty())
    }

    /// The note, the error with its contributions, and why the number is not resolved where the error does not show it.
    pub fn remark(&self) -> String {
        let error = self.quantity().map(|(quantity, unit)| error_of(quantity, unit));
        let note = Some(self.note.clone()).filter(|note| !note.is_empty());
        let doubt = self.doubt().map(str::to_owned);
        note.into_iter().chain(error).chain(doubt).collect::<Vec<_>>().join(", ")
    }
}

/// All rows of the results, by contact, and of the tissue.
pub fn listing(results: &Results) -> Vec<Group<'_>> {
    let headline = results.headline_impact();
    let reported = results.impacts.iter().filter(|impact| impact.is_reported());
    let mut groups: Vec<Group> = reported
        .map(|impact| Group {
            title: format!("Contact {}", impact.pair),
            nothing_touched: impact.contact_span_s.is_none(),
            rows: contact(impact, headline.is_some_and(|headline| std::ptr::eq(headline, impact))),
        })
        .collect();
    groups.extend(results.tissue.as_ref().map(|of| Group {
        title: "Tissue".into(),
        nothing_touched: results.nothing_touched,
        rows: tissue(of, results.headline.significant_stress),
    }));
    groups
}

fn contact(impact: &Impact, is_headline: bool) -> Vec<Row<'_>> {
    let single = with_unit(&impact.peak_step_force_n, "N");
    let mut rows = vec![
        Row::of_interest(Of::PeakForceN, &impact.force_average, &impact.peak_force_n, "peak-force"),
        Row::words("at", with_unit(&impact.peak_force_time_s, "s")).part(),
        Row::words("peak force of a single step", single).note("not a converged quantity"),
        Row::of_interest(Of::ImpulseNS, "", &impact.impulse_n_s, "impulse"),
        Row::number("duration of contact", &impact.contact_duration_s, "s")
            .growing()
            .code("contact-duration"),
    ];
    if !impact.touches_in_points {
        let axes = [&impact.patch_long_axis_mm, &impact.patch_short_axis_mm].map(bare);
        let nodes = format!("{} nodes across", impact.nodes_across_patch[0]);
        let (mean, largest) = (&impact.patch_area_mm2, &impact.largest_patch_area_mm2);
        let at_peak =
            Row::of_interest(Of::PatchAreaMm2, "mean area", mean, "contact-patch-area-at-peak-force");
        rows.push(at_peak.unresolved_since(FEW_NODES));
        let spread = format!("{} mm", marked(&axes.join(" × "), !mean.error.is_unresolved(), false));
        rows.push(Row::words("spread over", spread).note(nodes).part());
        let largest = Row::of_interest(Of::LargestPatchAreaMm2, "area", largest, "contact-patch-area");
        rows.push(largest.unresolved_since(FEW_NODES));
    }
    if !is_headline {
        for row in &mut rows {
            (row.of, row.code) = (None, None);
        }
    }
    rows
}

fn tissue(tissue: &Tissue, headline_stress: Option<usize>) -> Vec<Row<'_>> {
    let mut rows = energies(tissue);
    for (index, stress) in tissue.significant_stress.iter().enumerate() {
        rows.extend(above(stress, headline_stress == Some(index)));
    }
    rows.extend(tissue.dose_volumes.iter().map(|dose| {
        Row::number(format!("volume of {}", dose.measure.above(dose.threshold)), &dose.volume_mm3, "mm³")
            .growing()
    }));
    rows.extend(strains(tissue));
    rows
}

fn energies(tissue: &Tissue) -> Vec<Row<'_>> {
    let mut rows = Vec::new();
    if tissue.has_moving_frame() {
        let [x, y, z] = tissue.frame_velocity_m_per_s.map(number);
        rows.push(Row::words(
            "energies in the frame of the tissue, moving at",
            format!("({x}, {y}, {z}) m/s"),
        ));
    }
    let (given, absorbed) = (&tissue.energy_given_j, &tissue.absorbed_energy_j);
    rows.push(Row::of_interest(Of::EnergyGivenJ, "at the end", given, "energy-given").growing());
    let of_absorbed = Row::of_interest(Of::AbsorbedEnergyJ, "at the end", absorbed, "absorbed-energy");
    rows.push(of_absorbed.note(ABOUT_ABSORBED).growing());
    let by_work = with_unit(&tissue.absorbed_energy_by_work_j, "J");
    rows.push(Row::words("from the work of the reactions", by_work).part());
    rows.extend(split(&tissue.absorbed_split, absorbed));
    let peak = &tissue.peak_absorbed_energy_j;
    rows.push(Row::number("absorbed energy, at its peak", peak, "J").growing());
    rows.push(Row::words("at", with_unit(&tissue.peak_absorbed_energy_time_s, "s")).part());
    rows.extend(split(&tissue.peak_absorbed_split, peak));
    rows.extend(
        tissue.projectile_loss_j.as_ref().map(|lost| Row::number("lost by the projectile", lost, "J")),
    );
    rows
}

/// Components of an absorbed energy, which add up to it.
fn split<'a>(split: &'a Split, absorbed: &Quantity) -> impl Iterator<Item = Row<'a>> + use<'a> {
    let other = &split.not_from_contact_j;
    let is_notable = other.value.abs() > NOTABLE_WORK * absorbed.value.abs();
    let parts =
        [("strain", &split.strain_j), ("+ kinetic", &split.kinetic_j), ("+ dissipated", &split.dissipated_j)];
    let other = is_notable.then_some(("- work of loads and position projection", other));
    parts.into_iter().chain(other).map(|(title, energy)| Row::number(title, energy, "J").part())
}

/// Depth and volume above a threshold of stress, and the layers of that volume.
fn above<'a>(stress: &'a SignificantStress, is_headline: bool) -> impl Iterator<Item = Row<'a>> + use<'a> {
    let threshold = format!("{} kPa", short(1e-3 * stress.threshold_pa));
    let with_ends = |row: Row<'a>, ends: &[String]| match ends {
        [] => row.growing(),
        ends => row.note(format!("it reaches {}, where the model ends", ends.join(", "))),
    };
    let row = |what: &str, quantity, unit| {
        Row::number(format!("{what} of von Mises stress above {threshold}"), quantity, unit)
            .code(format!("{what}-above-{}-pa", stress.threshold_pa))
    };
    let depth = stress.depth_mm.as_ref().map(|depth| {
        let row = row("depth", depth, "mm");
        let row = if stress.reaches_greatest_depth() {
            row.note(format!("it reaches {GREATEST_DEPTH}"))
        } else if let Some(note) = between_nodes(stress) {
            row.note(note)
        } else {
            with_ends(row, &stress.depth_reaches)
        };
        Row { of: is_headline.then_some(Of::StressDepthMm), ..row }
    });
    let volume = with_ends(row("volume", &stress.volume_mm3, "mm³"), &stress.reaches);
    let layers = stress.layers.iter().filter(|_| stress.layers.len() > 1);
    depth.into_iter().chain([volume]).chain(layers.map(|layer| of_layer(layer, stress)))
}

/// What a depth of zero beside a volume says: the field of the stress, which the depth is read from, is below the threshold everywhere.
fn between_nodes(stress: &SignificantStress) -> Option<String> {
    let is_nowhere = stress.depth_mm.as_ref().is_some_and(|depth| depth.value == 0.0);
    let most = stress.depth_resolution_mm.filter(|_| is_nowhere && stress.volume_mm3.value > 0.0)?;
    Some(format!("too few points exceed it for a depth; {} mm at most", number(most)))
}

/// The part of a volume that lies in one layer, with the error of the whole: one below that is not resolved.
fn of_layer(layer: &StressedLayer, stress: &SignificantStress) -> Row<'static> {
    let Quantity { error, is_lower_bound, .. } = &stress.volume_mm3;
    let (scale, unit) = shown_in(layer.volume_mm3, "mm³");
    let volume = within(scale * layer.volume_mm3, error.half_width().map(|error| scale * error));
    let is_resolved = error.is_resolved() && error.half_width() < Some(layer.volume_mm3);
    let volume = marked(&volume, is_resolved, *is_lower_bound);
    let between = layer.depth_mm.map(|[from, to]| format!("{from:.1} to {to:.1} mm below the surface"));
    // Each layer has its largest volume at its own time: they need not add up to that of the whole.
    Row::words(format!("largest in {}, at any time", layer.part), format!("{volume}{unit}"))
        .note(between.unwrap_or_default())
        .part()
}

/// What a 95th percentile of the strain says that is almost zero.
fn hardly_strained(mps95: &Exceeded) -> String {
    let quantity = &mps95.quantity;
    let is_small = quantity.error.half_width().is_some_and(|error| quantity.value + error < HARDLY);
    let percent = 100.0 * HARDLY;
    if is_small {
        format!(" (less than 5 % of the part was strained by {percent} % or more)")
    } else {
        String::new()
    }
}

/// Strain and stress, exceeded in volumes and at points, and the deflection.
fn strains(tissue: &Tissue) -> Vec<Row<'_>> {
    let mut rows = Vec::new();
    match &tissue.exceeded_in_volume {
        Some(in_volume) => {
            let volume = format!("exceeded in {}", volume(in_volume.volume_mm3));
            let strain =
                Row::exceeded(format!("principal strain {volume}"), &in_volume.principal_strain, "-");
            let stress = Row::exceeded(format!("von Mises stress {volume}"), &in_volume.von_mises_pa, "Pa");
            rows.push(strain.code("principal-strain-exceeded-in-volume"));
            rows.push(stress.code("von-mises-exceeded-in-volume"));
        }
        None => rows.push(
            Row::words(Of::PrincipalStrainInVolume.title(), "-")
                .note("not evaluated after the start, beyond the limit of a law, or less tissue than that"),
        ),
    }
    for of in &tissue.percentiles {
        rows.extend(of.mps95.as_ref().map(|mps95| {
            let row = Row::exceeded(format!("MPS95 of {}", of.part), mps95, "-");
            let note = format!(
                "principal strain, 95th percentile by volume{}, {}",
                hardly_strained(mps95),
                row.note
            );
            row.note(note).code(format!("mps95-{}", of.part))
        }));
    }
    let peaks = &tissue.peaks;
    let density = peaks.peak_strain_energy_density_j_per_m3.as_ref();
    rows.push(
        Row::peak("peak von Mises stress", peaks.peak_von_mises_pa.as_ref(), "Pa").code("peak-von-mises"),
    );
    let strain = Row::peak(Of::PrincipalStrain.title(), peaks.peak_principal_strain.as_ref(), "-");
    rows.push(strain.code("peak-principal-strain"));
    rows.push(Row::peak("peak strain energy density", density, "J/m³").code("peak-strain-energy-density"));
    let deflection = Row::peak(Of::DeflectionMm.title(), Some(&tissue.deflection_mm), "mm");
    rows.push(deflection.code("skin-deflection"));
    rows
}

#[cfg(test)]
#[allow(clippy::unwrap_used)] // tests may panic
mod tests {
    use super::super::results::Percentiles;
    use super::*;

    #[test]
    fn a_percentile_of_a_part_that_is_hardly_strained_is_explained() {
        let summary = include_str!("../../../api/examples/summary.response.json");
        let summary: serde_json::Value = serde_json::from_str(summary).unwrap();
        let mut results: Results = serde_json::from_value(summary["results"].clone()).unwrap();
        let shown = |results: &mut Results, value: f64| {
            let quantity = Quantity::with_mesh_error(value, 1e-6, value > 1e-6);
            let quantity = Quantity { is_lower_bound: true, ..quantity };
            let mps95 = Exceeded { quantity, time_s: 1e-4, resolution: 0.0, is_peak: false };
            let part = "fat".to_owned();
            results.tissue.as_mut().unwrap().percentiles =
                vec![Percentiles { part, volume_mm3: 9.0, mps95: Some(mps95) }];
            let groups = listing(results);
            let row =
                groups.iter().flat_map(|group| &group.rows).find(|row| row.title == "MPS95 of fat").unwrap();
            (row.value(), row.note.clone())
        };
        let (value, note) = shown(&mut results, 1e-9);
        assert!(
            value == "(0)" && note.contains("less than 5 % of the part was strained by 1 % or more"),
            "{value} {note}"
        );
        let (value, note) = shown(&mut results, 0.02);
        assert!(value == "≥ 0.02000" && !note.contains("less than"), "{value} {note}");
        assert!(note.ends_with("at 100.0 µs, contact has not ended"), "{note}");
    }

    #[test]
    fn a_depth_of_zero_beside_a_volume_is_explained() {
        let summary = include_str!("../../../api/examples/summary.response.json");
        let summary: serde_json::Value = serde_json::from_str(summary).unwrap();
        let mut results: Results = serde_json::from_value(summary["results"].clone()).unwrap();
        let stress = &mut results.tissue.as_mut().unwrap().significant_stress[0];
        assert!(stress.volume_mm3.value > 0.0 && between_nodes(stress).is_none());
        stress.depth_mm.as_mut().unwrap().value = 0.0;
        stress.depth_resolution_mm = Some(24.0);
        assert_eq!(between_nodes(stress).unwrap(), "too few points exceed it for a depth; 24.00 mm at most");
        stress.volume_mm3.value = 0.0;
        assert_eq!(between_nodes(stress), None);
    }

    #[test]
    fn the_parts_of_an_absorbed_energy_add_up_and_show_what_is_not_resolved() {
        let quantity = |value: f64, error: f64| Quantity::with_mesh_error(value, error, error < value.abs());
        let shown = |not_from_contact: f64| {
            let parts = Split {
                strain_j: quantity(2.0, 0.1),
                kinetic_j: quantity(1.0, 3.0),
                recoverable_j: quantity(3.0, 0.1),
                dissipated_j: quantity(0.5, 0.01),
                not_from_contact_j: quantity(not_from_contact, 0.001),
            };
            let rows = split(&parts, &quantity(3.5 - not_from_contact, 0.1));
            rows.map(|row| [row.title.clone(), row.value(), row.remark()]).collect::<Vec<_>>()
        };
        let (plain, loaded) = (shown(1e-4), shown(0.3));
        assert!(plain.len() == 3 && plain[0][1] == "2.00 J", "{plain:?}");
        assert!(plain[1][1] == "(1.0) J" && plain[1][2].starts_with("± 3.0 J"), "{plain:?}");
        // None of these is negative, and the interval ends there.
        let unresolved = quantity(1.0, 3.0).no_less_than(0.0);
        assert!(Row::number("kinetic", &unresolved, "J").remark().starts_with("up to 4.0 J"));
        assert_eq!(loaded[3][..2], ["- work of loads and position projection", "0.3000 J"]);
    }

    #[test]
    fn a_number_that_exceeds_its_error_and_is_not_resolved_says_why() {
        let said = |error: f64, is_resolved: bool| {
            let patch = Quantity::with_mesh_error(1e6, error, is_resolved);
            let row = Row::number("patch", &patch, "mm²").unresolved_since(FEW_NODES);
            (row.doubt(), row.remark().ends_with("NOT RESOLVED, fewer than five nodes across it"))
        };
        assert_eq!(said(100.0, false), (Some(FEW_NODES), true));
        assert_eq!(said(100.0, true), (None, false));
        // Here the error shows it.
        assert_eq!(said(2e6, false), (None, false));
        let peak = Quantity::with_mesh_error(1.345, 0.067, false);
        let peak = Located { quantity: peak, position_m: [0.0; 3], time_s: 1e-3 };
        assert_eq!(Row::peak("peak", Some(&peak), "-").doubt(), Some(AT_A_POINT));
    }
}
