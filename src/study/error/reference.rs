//! References for the errors, and convergence of the meshes to them.

use super::{Reference, Row};
use crate::measure::QuantityOfInterest;
use crate::measure::convergence::{extrapolate, fitted_limit};
use crate::study::Setting;
use serde::Serialize;
use std::collections::{BTreeMap, BTreeSet};

/// Smallest order at which an error counts as decreasing [-].
const FALLS: f64 = 0.2;
/// Numbers of meshes that a limit is fitted to: at least, and the finest of them at most.
const FITTED: [usize; 2] = [4, 5];
/// Relative errors up to this are rounding [-].
const ROUNDING: f64 = 1e-9;

/// Convergence of the scene's own meshes to an exact value.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(tag = "kind", rename_all = "snake_case")]
pub enum Approach {
    /// Every mesh gives the exact value up to rounding.
    Met,
    /// The error decreases from mesh to mesh.
    Falls {
        /// Observed order from the coarsest mesh to the finest [-].
        order: f64,
    },
    /// No convergence: the meshes tend to another value, or to none.
    Stays {
        /// Observed order, negative if the error grows [-].
        order: f64,
        /// Limit of the meshes: Richardson's if it is credible, otherwise the value of the finest mesh.
        tends_to: f64,
    },
}

/// A quantity on meshes of consecutive levels, the last being the finest that has it.
struct Levels {
    /// Element size and value on every mesh that has it, those between levels included, from coarse to fine.
    sizes: Vec<(f64, f64)>,
    coarsest: i32,
    values: Vec<f64>,
    /// Levels of the ladder without the quantity: gaps from which no order can be inferred.
    missing: Vec<i32>,
}

impl Levels {
    /// `None` if no mesh has it.
    fn of(rows: &[Row], quantity: QuantityOfInterest) -> Option<Self> {
        let of_sizes = |row: &&Row| {
            let Setting { mesh_level, mesh_factor, .. } = row.setting;
            row.setting == Setting { mesh_level, mesh_factor, ..Setting::OWN }
        };
        let size = |row: &Row| Some(((row.elements as f64).cbrt().recip(), *row.values.get(&quantity)?));
        let mut sizes: Vec<(f64, f64)> = rows.iter().filter(of_sizes).filter_map(size).collect();
        sizes.sort_by(|(a, _), (b, _)| b.total_cmp(a));
        let of_meshes =
            |row: &&Row| row.setting == Setting { mesh_level: row.setting.mesh_level, ..Setting::OWN };
        let requested: BTreeSet<i32> =
            rows.iter().filter(of_meshes).map(|row| row.setting.mesh_level).collect();
        let value = |row: &Row| Some((row.setting.mesh_level, *row.values.get(&quantity)?));
        let known: BTreeMap<i32, f64> = rows.iter().filter(of_meshes).filter_map(value).collect();
        let finest = *known.last_key_value()?.0;
        let at = |level: i32| Some((level, *known.get(&level)?));
        let mut in_a_row: Vec<(i32, f64)> = (0..).map_while(|down| at(finest.checked_sub(down)?)).collect();
        in_a_row.reverse();
        let coarsest = in_a_row.first()?.0;
        let values = in_a_row.into_iter().map(|(_, value)| value).collect();
        let (first, last) = (requested.first().copied()?, requested.last().copied()?);
        let missing = (first..=last).filter(|level| !known.contains_key(level)).collect();
        Some(Self { sizes, coarsest, values, missing })
    }

    /// Limit of the meshes. With fewer than three no order is known: the reason names the missing ones.
    fn reference(&self) -> Option<Reference> {
        let [fewest, most] = FITTED;
        if self.sizes.len() >= fewest {
            return fitted_limit(&self.sizes[self.sizes.len().saturating_sub(most)..]);
        }
        let found = extrapolate(&self.values)?;
        if self.missing.is_empty() || self.values.len() > 2 {
            return Some(found);
        }
        let names: Vec<String> =
            self.missing.iter().map(|level| Setting { mesh_level: *level, ..Setting::OWN }.name()).collect();
        let why = |reason: String| format!("{reason} (no such number on {})", names.join(", "));
        Some(match found {
            Reference::Finest { value, uncertainty, reason } => {
                Reference::Finest { value, uncertainty, reason: why(reason) }
            }
            Reference::Unknown { value, reason } => Reference::Unknown { value, reason: why(reason) },
            other => other,
        })
    }

    /// Convergence to an exact value; `None` for a single mesh, or if the exact value is zero.
    fn approach(&self, exact: f64) -> Option<Approach> {
        let error = |value: &f64| ((value - exact) / exact).abs();
        let errors: Vec<(i32, f64)> = (self.coarsest..).zip(self.values.iter().map(error)).collect();
        if errors.len() < 2 || exact == 0.0 {
            return None;
        }
        if errors.iter().all(|(_, error)| *error <= ROUNDING) {
            return Some(Approach::Met);
        }
        let mut errors = errors.into_iter().filter(|(_, error)| *error > 0.0);
        let ((coarse, before), (fine, after)) = (errors.next()?, errors.next_back()?);
        let order = (before / after).log2() / f64::from(fine - coarse);
        Some(if order >= FALLS {
            Approach::Falls { order }
        } else {
            Approach::Stays { order, tends_to: extrapolate(&self.values)?.value() }
        })
    }
}

/// Exact values, otherwise the limit of the meshes with the scene's own formulation and step.
pub(super) fn references(
    rows: &[Row],
    known: &BTreeMap<QuantityOfInterest, Reference>,
) -> BTreeMap<QuantityOfInterest, Reference> {
    let reference = |quantity: QuantityOfInterest| {
        if let Some(known) = known.get(&quantity) {
            return Some((quantity, known.clone()));
        }
        Some((quantity, Levels::of(rows, quantity)?.reference()?))
    };
    QuantityOfInterest::ALL.into_iter().filter_map(reference).collect()
}

/// Convergence of the meshes to the exact values.
pub(super) fn approaches(
    rows: &[Row],
    known: &BTreeMap<QuantityOfInterest, Reference>,
) -> BTreeMap<QuantityOfInterest, Approach> {
    let approach = |(quantity, known): (&QuantityOfInterest, &Reference)| {
        Some((*quantity, Levels::of(rows, *quantity)?.approach(known.value())?))
    };
    known.iter().filter_map(approach).collect()
}

/// Relative errors of a run, for the quantities with a nonzero reference [-].
pub(super) fn errors(
    values: &BTreeMap<QuantityOfInterest, f64>,
    references: &BTreeMap<QuantityOfInterest, Reference>,
) -> BTreeMap<QuantityOfInterest, f64> {
    let error = |(quantity, value): (&QuantityOfInterest, &f64)| {
        let reference = references.get(quantity).filter(|reference| reference.is_known())?.value();
        (reference != 0.0).then(|| (*quantity, ((value - reference) / reference).abs()))
    };
    values.iter().filter_map(error).collect()
}

#[cfg(test)]
#[allow(clippy::unwrap_used)] // tests may panic
mod tests {
    use super::super::front::advice;
    use super::*;

    const FORCE: QuantityOfInterest = QuantityOfInterest::PeakForceN;

    /// Runs on meshes of these levels; one without a value has failed.
    fn rows(values: &[(i32, Option<f64>)]) -> Vec<Row> {
        let row = |(mesh_level, value): &(i32, Option<f64>)| {
            let setting = Setting { mesh_level: *mesh_level, ..Setting::OWN };
            Row {
                setting,
                name: setting.name(),
                ending: if value.is_some() { "finished" } else { "inverted_element" }.into(),
                reason: None,
                elements: 8_usize.pow((mesh_level + 4).unsigned_abs()),
                steps: 1,
                wall_s: 1.0,
                cpu_s: None,
                values: value.iter().map(|value| (FORCE, *value)).collect(),
                errors: BTreeMap::new(),
            }
        };
        values.iter().map(row).collect()
    }

    fn reference(values: &[(i32, Option<f64>)]) -> Reference {
        references(&rows(values), &BTreeMap::new())[&FORCE].clone()
    }

    #[test]
    fn only_meshes_in_a_row_are_extrapolated() {
        // 2 + h: the limit follows from three consecutive levels, even if a coarser or the finest one failed.
        let value = |level: i32| (level, Some(2.0 + 0.5_f64.powi(level)));
        for values in [
            vec![value(-1), value(0), value(1)],
            vec![value(-3), (-2, None), value(-1), value(0), value(1)],
            vec![value(-1), value(0), value(1), (2, None)],
        ] {
            let found = reference(&values);
            let is_line = matches!(found, Reference::Fitted { meshes: 4, .. })
                || matches!(found, Reference::Extrapolated { order, .. } if (order - 1.0).abs() < 1e-12);
            assert!(is_line, "{found:?}");
            assert!((found.value() - 2.0).abs() < 1e-12, "{found:?}");
        }
        // A ratio of four across a missing level is not mistaken for two.
        let Reference::Finest { value: finest, uncertainty, reason } =
            reference(&[value(-2), (-1, None), value(0), value(1)])
        else {
            panic!("extrapolated over a gap")
        };
        assert!(
            (finest - 2.5).abs() < 1e-12 && (uncertainty - 1.5).abs() < 1e-12,
            "{finest} ± {uncertainty}"
        );
        assert!(
            reason.contains("only two meshes") && reason.ends_with("(no such number on mesh -1)"),
            "{reason}"
        );
    }

    #[test]
    fn one_mesh_is_no_reference_and_nothing_is_recommended() {
        let rows = rows(&[(-1, Some(3.0)), (0, None), (1, Some(2.0))]);
        let references = references(&rows, &BTreeMap::new());
        let Reference::Unknown { reason, .. } = &references[&FORCE] else { panic!("{references:?}") };
        assert!(reason.ends_with("(no such number on mesh 0)"), "{reason}");
        assert!(errors(&rows[2].values, &references).is_empty());
        assert!(advice(&rows, &references).iter().all(|advice| advice.setting.is_none()));
    }

    #[test]
    fn an_exact_value_that_the_meshes_do_not_approach_is_noticed() {
        let approach = |values: &[f64], exact: f64| {
            let levels: Vec<_> = (0..).zip(values.iter().map(|value| Some(*value))).collect();
            approaches(&rows(&levels), &BTreeMap::from([(FORCE, Reference::Exact { value: exact })]))
                .get(&FORCE)
                .copied()
        };
        let meshes = [3.0, 2.5, 2.25];
        let found = approach(&meshes, 2.0);
        assert!(matches!(found, Some(Approach::Falls { order }) if (order - 1.0).abs() < 1e-12), "{found:?}");
        for wrong in [40.0, 3.5] {
            let found = approach(&meshes, wrong);
            let Some(Approach::Stays { order, tends_to }) = found else { panic!("{wrong}: {found:?}") };
            assert!(order < 0.0 && (tends_to - 2.0).abs() < 1e-12, "{wrong}: {found:?}");
        }
        assert_eq!(approach(&[1e6, 999_999.999_999_999_9, 1e6], 1e6), Some(Approach::Met));
        assert_eq!(approach(&[1.0], 1.0), None);
        assert_eq!(approach(&meshes, 0.0), None);
    }
}
