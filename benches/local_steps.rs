//! Largest possible saving by local time steps: the distribution of the elements' critical time steps while a scene
//! runs.
//!
//! `cargo bench --bench local_steps`. At each output time the elements are put into groups that would step with 1, 2,
//! 4, … times the smallest critical time step; the bound is the fraction of element-steps that remains if that cost
//! nothing: no work at the borders of groups, no interpolation, every group in full lanes. Bulk viscosity, which
//! shortens the steps of elements that are being crushed, is not included.

use contuse::mechanics::force::{ElementForces, ForceInput, Threads};
use contuse::plan::compile;
use contuse::scene::{Budget, load_file};
use contuse::step::{Frame, Recorder, RecorderError, RunOptions, run};
use std::path::Path;

/// Largest power of two in the ratio of a group's step to the smallest.
const GROUPS: i32 = 5;

fn main() {
    for (scenario, end_time) in [
        ("flashball_thigh/scene_elastic", None),
        ("flashball_thigh/scene_elastic", Some(2e-3)),
        ("ball_on_block/scene", None),
    ] {
        let path =
            Path::new(env!("CARGO_MANIFEST_DIR")).join("scenarios").join(scenario).with_extension("json");
        let Ok(mut loaded) = load_file(&path, &Budget::COMMAND_LINE) else { continue };
        if let Some(end_time) = end_time {
            let document = &mut loaded.scene.document;
            document.end_time_s = end_time;
            document.record.field_times_s = None;
        }
        let Ok(plan) = compile(&loaded.scene) else { continue };
        println!(
            "{scenario}: fraction of elements that may step with 1, 2, 4, 8, 16, 32 times the smallest step"
        );
        let options = RunOptions { threads: 1, interrupt: &|| None };
        let _ = run(&plan, &options, &mut [&mut Spread { forces: ElementForces::new(&plan.blocks) }]);
    }
}

struct Spread {
    forces: ElementForces,
}

impl Recorder for Spread {
    fn record(&mut self, frame: &Frame) -> Result<(), RecorderError> {
        if !frame.is_field_time {
            return Ok(());
        }
        let plan = frame.plan;
        let input = ForceInput::at(frame.u);
        self.forces.evaluate(&Threads::ONE, &plan.blocks, &input);
        let steps: Vec<f64> = plan
            .blocks
            .iter()
            .enumerate()
            .flat_map(|(index, block)| self.forces.stable_steps(index).take(block.elements.len()))
            .collect();
        // Count the elements in each group.
        let smallest = steps.iter().copied().fold(f64::INFINITY, f64::min);
        let mut groups = [0_usize; GROUPS as usize + 1];
        for step in &steps {
            groups[((step / smallest).log2().floor() as i32).clamp(0, GROUPS) as usize] += 1;
        }
        let fraction = |count: &usize| *count as f64 / steps.len() as f64;
        let left: f64 =
            groups.iter().enumerate().map(|(i, count)| fraction(count) / f64::from(1_u32 << i)).sum();
        let fractions: Vec<String> =
            groups.iter().map(|count| format!("{:5.1} %", 100.0 * fraction(count))).collect();
        println!(
            "  t = {:6.1} µs, smallest step {:.3} µs: {}; element-steps remaining at best: {:.0} %",
            1e6 * frame.time,
            1e6 * smallest,
            fractions.join(" "),
            100.0 * left
        );
        Ok(())
    }
}
