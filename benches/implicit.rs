//! Cost of the parts of an implicit step on one thread: `cargo bench --bench implicit`.
//!
//! `ball_on_block` on its mesh, and a block of 20³ elements. Each part is repeated, and its best processor-bound time
//! is reported; then the scene itself is stepped implicitly to 1e-4 s in steps of 1 µs.

use contuse::mechanics::force::StiffnessBatch;
use contuse::mechanics::sparse::{Cholesky, SymmetricMatrix};
use contuse::mechanics::tensor::Vec3;
use contuse::plan::{Integrator, Plan, compile};
use contuse::scene::{Budget, FolderSource, load};
use contuse::step::{RunOptions, run};
use serde_json::{Value, json};
use std::path::Path;
use std::time::Instant;

/// Repetitions of each part.
const TIMES: u32 = 5;

fn main() {
    let implicit = json!({"kind": "implicit", "step_s": 1e-6});
    for (name, scene) in [("ball_on_block", ball_on_block()), ("block of 20³", Some(block()))] {
        let Some(mut scene) = scene else { continue };
        scene["integrator"] = implicit.clone();
        scene["record"] = json!({"fields": [], "field_times_s": []});
        let Some(plan) = plan(&scene) else { continue };
        parts(name, &plan);
        if name == "ball_on_block" {
            whole(&plan);
        }
    }
}

fn folder() -> std::path::PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("scenarios/ball_on_block")
}

fn ball_on_block() -> Option<Value> {
    serde_json::from_slice(&std::fs::read(folder().join("scene.json")).ok()?).ok()
}

fn block() -> Value {
    json!({
        "name": "block",
        "end_time_s": 1e-4,
        "bodies": [{
            "name": "block",
            "mesh": {"generator": {"kind": "block", "min_m": [0, 0, 0], "max_m": [0.1, 0.1, 0.1], "elements": [20, 20, 20]}},
            "parts": [{"part": "block", "density_kg_per_m3": 1000, "material": {
                "law": "neo_hookean", "c10_pa": 1e5, "bulk_modulus_pa": 1e8
            }}]
        }]
    })
}

fn plan(scene: &Value) -> Option<Plan> {
    let bytes = serde_json::to_vec(scene).ok()?;
    let loaded = load(&bytes, &FolderSource::new(folder()), &Budget::COMMAND_LINE);
    let loaded = loaded.map_err(|problems| eprintln!("{problems}")).ok()?;
    compile(&loaded.scene).map_err(|e| eprintln!("{e}")).ok()
}

/// Shortest time of a few repetitions [s].
fn best(mut work: impl FnMut()) -> f64 {
    (0..TIMES).fold(f64::INFINITY, |best, _| {
        let start = Instant::now();
        work();
        best.min(start.elapsed().as_secs_f64())
    })
}

fn parts(name: &str, plan: &Plan) {
    let Integrator::Implicit(implicit) = &plan.integrator else { return };
    let (unknowns, elements) = (&implicit.unknowns, plan.element_count());
    let u = vec![Vec3::zeros(); plan.node_count()];
    let mut batch = StiffnessBatch::zeros();
    // Element stiffnesses alone, then with assembly.
    let stiffness = best(|| {
        for block in &plan.blocks {
            let tangent = block.tangent_at(&u);
            (0..block.batch_count()).for_each(|b| tangent.eval_batch(b, &mut batch));
        }
    });
    let mut matrix = SymmetricMatrix::new(unknowns);
    let mut mass = vec![0.0; unknowns.count()];
    unknowns.for_each(|unknown, node, _| mass[unknown] = plan.mass[node]);
    let assembly = best(|| {
        matrix.set_diagonal(&mass);
        for block in &plan.blocks {
            let tangent = block.tangent_at(&u);
            for b in 0..block.batch_count() {
                tangent.eval_batch(b, &mut batch);
                matrix.add_batch(unknowns, block, b, &batch, 0.25e-12);
            }
        }
    });
    // Analysis, factorisation, solutions.
    let analysis = best(|| drop(Cholesky::new(&matrix)));
    let Ok(mut factor) = Cholesky::new(&matrix) else { return };
    let factorisation = best(|| drop(factor.factorize(&matrix)));
    let mut x = vec![1.0; unknowns.count()];
    let one = best(|| factor.solve(&mut x));
    let mut columns = vec![1.0; 96 * unknowns.count()];
    let many = best(|| factor.solve(&mut columns));
    println!(
        "{name}: {elements} elements, {} unknowns, factor of {:.2} M entries\n  \
         stiffness     {:8.2} ms ({:.2} µs an element)\n  with assembly {:8.2} ms\n  analysis      {:8.2} ms\n  \
         factorisation {:8.2} ms ({:.1} GFLOP/s)\n  one solution  {:8.2} ms\n  96 solutions  {:8.2} ms",
        unknowns.count(),
        1e-6 * factor.entries() as f64,
        1e3 * stiffness,
        1e6 * stiffness / elements as f64,
        1e3 * assembly,
        1e3 * analysis,
        1e3 * factorisation,
        1e-9 * factor.flops() / factorisation,
        1e3 * one,
        1e3 * many,
    );
}

fn whole(plan: &Plan) {
    let start = Instant::now();
    let (outcome, state) = run(plan, &RunOptions { threads: 1, interrupt: &|| None }, &mut []);
    println!(
        "  to {:.1e} s in {} steps: {:.2} s, {} matrices, balance error {:.1e}; {:?} {:?}",
        outcome.time_s,
        outcome.steps,
        start.elapsed().as_secs_f64(),
        state.implicit.tangent.map_or(0, |tangent| tangent.number),
        outcome.balance_error,
        outcome.ending,
        outcome.warnings
    );
}
