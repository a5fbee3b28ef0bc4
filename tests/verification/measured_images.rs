//! Stress and deformation of a symmetric scene are evaluated in the sector that is computed, and are those of all points.

use crate::rig::{plan, small_ball_on_block};
use contuse::measure::fields::Fields;
use contuse::measure::{Measures, MeasuringRecorder};
use contuse::plan::Plan;
use contuse::step::{Ending, Frame, Interrupt, Outcome, Recorder, RecorderError, RunOptions};
use serde_json::{Value, json};

/// Measures the frames of a sector as such, and as those of a plan without one.
struct Both<'a> {
    of_sector: MeasuringRecorder<'a>,
    of_whole: MeasuringRecorder<'a>,
    whole: &'a Plan,
}

impl Recorder for Both<'_> {
    fn start(&mut self, plan: &Plan) -> Result<(), RecorderError> {
        self.of_sector.start(plan)?;
        self.of_whole.start(self.whole)
    }

    fn record(&mut self, frame: &Frame) -> Result<(), RecorderError> {
        self.of_sector.record(frame)?;
        self.of_whole.record(&Frame { plan: self.whole, ..*frame })
    }

    fn finish(&mut self, plan: &Plan, outcome: &Outcome) -> Result<(), RecorderError> {
        self.of_sector.finish(plan, outcome)?;
        self.of_whole.finish(self.whole, outcome)
    }
}

/// A ball on a block of tissue that remembers, with all fields and measures.
fn scene(velocity: [f64; 3]) -> Value {
    let mut scene = small_ball_on_block([4, 2], [8, 8, 4], velocity, 3e-4);
    scene["bodies"][0]["role"] = json!("projectile");
    scene["bodies"][1]["role"] = json!("tissue");
    let part = &mut scene["bodies"][1]["parts"][0];
    part["shear_viscosity_pa_s"] = json!(5);
    part["prony_series"] = json!({"branches": [{"relative_modulus": 3, "relaxation_time_s": 5e-5}, {"relative_modulus": 1, "relaxation_time_s": 1e-3}]});
    scene["record"] = json!({"field_interval_s": 1e-4, "fields": ["von_mises", "pressure", "principal_strain", "element_cauchy_stress"]});
    scene["measures"] = json!({
        "skin_set": "z_max", "stress_thresholds_pa": [1e3, 1e4, 5e4], "principal_strain_thresholds": [0.01, 0.1],
        "strain_energy_density_thresholds_j_per_m3": [10, 1000], "exceeded_in_volume_m3": 1e-6
    });
    scene
}

/// Compares all numbers of two documents. Of equal peaks in several images one is named: places agree but for signs, since the planes contain
/// the origin.
fn assert_close(of_sector: &Value, of_whole: &Value, path: &str, count: &mut usize) {
    match (of_sector, of_whole) {
        (Value::Number(a), Value::Number(b)) => {
            let [a, b] = [a, b].map(|number| number.as_f64().unwrap().abs());
            assert!((a - b).abs() <= 1e-6 * a.max(b) + 1e-15, "{path}: {a}, not {b}");
            *count += 1;
        }
        (Value::Object(a), Value::Object(b)) => {
            assert_eq!(a.len(), b.len(), "{path}");
            a.iter().for_each(|(key, a)| assert_close(a, &b[key], &format!("{path}/{key}"), count));
        }
        (Value::Array(a), Value::Array(b)) => {
            assert_eq!(a.len(), b.len(), "{path}");
            a.iter()
                .zip(b)
                .enumerate()
                .for_each(|(i, (a, b))| assert_close(a, b, &format!("{path}/{i}"), count));
        }
        _ => {}
    }
}

/// Largest difference of two fields, relative to the largest value.
fn apart(a: &[f64], b: &[f64]) -> f64 {
    assert!(!a.is_empty() && a.len() == b.len());
    let largest = b.iter().fold(0.0_f64, |most, x| most.max(x.abs()));
    a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max) / largest
}

fn assert_measured_alike(scene: &Value, images: usize) {
    let mut keeping = scene.clone();
    keeping["solver"] = json!({"keep": ["mirror_images"]});
    let (of_sector, whole) = (plan(scene), plan(&keeping));
    assert_eq!(of_sector.sector.as_ref().map(|of| of.sector.images.count()), Some(images));
    let new = || MeasuringRecorder::new(Measures::new());
    let mut both = Both { of_sector: new(), of_whole: new(), whole: &whole };
    let options = RunOptions { threads: 1, interrupt: &|| None::<Interrupt> };
    let (outcome, _) = contuse::step::run(&of_sector, &options, &mut [&mut both]);
    assert_eq!(outcome.ending, Ending::Finished, "{outcome:#?}");

    let [got, expected] = [(&both.of_sector, &of_sector), (&both.of_whole, &whole)]
        .map(|(measuring, plan)| serde_json::to_value(measuring.summary(plan, &outcome)).unwrap());
    let mut count = 0;
    assert_close(&got["results"], &expected["results"], "results", &mut count);
    assert!(count > 60, "{count} numbers");
    // Volumes and energies beyond the ranges of the laws, part by part.
    let parts = [&both.of_sector, &both.of_whole].map(|measuring| {
        let parts = &measuring.measures().laws.parts;
        json!(
            parts
                .iter()
                .map(|p| json!([p.volume, p.left.volume(), p.beyond.volume(), p.stretch, p.jacobian]))
                .collect::<Vec<_>>()
        )
    });
    assert_close(&parts[0], &parts[1], "laws", &mut count);
    // Fields.
    let [a, b]: [&Fields; 2] =
        [&both.of_sector, &both.of_whole].map(|measuring| measuring.measures().fields.as_ref().unwrap());
    let nodal = [
        (&a.von_mises, &b.von_mises),
        (&a.pressure, &b.pressure),
        (&a.principal_strain, &b.principal_strain),
    ];
    for (a, b) in nodal {
        assert!(apart(a, b) < 1e-10, "{}", apart(a, b));
    }
    let [a, b] = [a, b].map(|fields| fields.element_cauchy.as_flattened());
    assert!(apart(a, b) < 1e-10, "{}", apart(a, b));
}

#[test]
fn a_quarter_is_measured_as_the_whole() {
    assert_measured_alike(&scene([0.0, 0.0, -30.0]), 4);
}

#[test]
fn a_half_is_measured_as_the_whole() {
    assert_measured_alike(&scene([12.0, 0.0, -30.0]), 2);
}
