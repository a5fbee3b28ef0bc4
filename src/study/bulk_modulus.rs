//! What a lower bulk modulus costs: tissue is as incompressible as water (2.2 GPa), and scenes use less, because the time step is as
//! much longer.
//!
//! One scene, one mesh, several factors on the bulk modulus of every split law; the results with the largest are the reference.

use super::error::{ErrorRequest, Row, TARGETS, study_error};
use super::setting::Setting;
use crate::measure::QuantityOfInterest;
use crate::scene::document::SceneDocument;
use crate::scene::{Budget, MeshSource};
use crate::step::Interrupt;
use serde::Serialize;
use std::collections::BTreeMap;

/// Least and greatest factor on the bulk modulus [-].
pub const FACTORS: [f64; 2] = [1e-3, 1e3];

/// Subject and settings of the study.
pub struct BulkRequest<'a> {
    /// Scene with a definite time integration.
    pub document: &'a SceneDocument,
    /// Source of its meshes.
    pub source: &'a dyn MeshSource,
    /// Budget of a run.
    pub budget: &'a Budget,
    /// Factors on its bulk moduli [-].
    pub factors: &'a [f64],
    /// Threads of each run.
    pub threads: usize,
    /// Called before every step.
    pub interrupt: &'a (dyn Fn() -> Option<Interrupt> + Sync),
    /// Called before each run with its index, the number of runs, and its setting.
    pub progress: &'a mut dyn FnMut(usize, usize, &Setting),
}

/// Results of the study.
#[derive(Clone, Debug, Serialize)]
pub struct BulkStudy {
    /// Name of the scene.
    pub scene: String,
    /// Runs with increasing bulk moduli; `errors` are the differences from the last one that finished [-].
    pub rows: Vec<Row>,
    /// For each quantity, the smallest factor that is within 1, 3 and 10 % of the reference, as are all larger ones; null where only
    /// the reference is.
    pub smallest: BTreeMap<QuantityOfInterest, [Option<f64>; TARGETS.len()]>,
    /// Why it was stopped early; absent otherwise.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub stopped: Option<String>,
}

/// Runs the scene with each factor.
pub fn study_bulk_modulus(request: &mut BulkRequest) -> BulkStudy {
    let mut factors = request.factors.to_vec();
    factors.sort_by(f64::total_cmp);
    factors.dedup();
    let ladder: Vec<Setting> =
        factors.iter().map(|factor| Setting { bulk_factor: *factor, ..Setting::OWN }).collect();
    let study = study_error(&mut ErrorRequest {
        document: request.document,
        source: request.source,
        budget: request.budget,
        ladder: &ladder,
        known: &BTreeMap::new(),
        threads: request.threads,
        interrupt: request.interrupt,
        progress: request.progress,
    });
    let mut rows = study.rows;
    let reference = rows.iter().rfind(|row| row.is_finished()).map(|row| row.values.clone());
    let reference = reference.unwrap_or_default();
    for row in &mut rows {
        let change = |(q, value): (&QuantityOfInterest, &f64)| {
            let of = reference.get(q).filter(|of| **of != 0.0)?;
            Some((*q, value / of - 1.0))
        };
        row.errors = row.values.iter().filter_map(change).collect();
    }
    let smallest =
        reference.keys().map(|q| (*q, TARGETS.map(|target| smallest(&rows, *q, target)))).collect();
    BulkStudy { scene: study.scene, rows, smallest, stopped: study.stopped }
}

/// Smallest factor from which on a quantity is within `target` of the reference; the reference itself does not count.
fn smallest(rows: &[Row], quantity: QuantityOfInterest, target: f64) -> Option<f64> {
    let is_within = |row: &&Row| row.errors.get(&quantity).is_some_and(|change| change.abs() <= target);
    let mut finished = rows.iter().rev().filter(|row| row.is_finished());
    let _reference = finished.next()?;
    finished.take_while(is_within).last().map(|row| row.setting.bulk_factor)
}
