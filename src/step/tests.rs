//! Steps of small scenes.

use super::*;
use crate::mechanics::material::*;
use crate::mechanics::tensor::Mat3;
use crate::mechanics::tensor::Vec3;
use crate::mesh::Mesh;
use crate::mesh::generate::hollow_ball::HollowBall;
use crate::plan::{Plan, compile};
use crate::scene::{Scene, SceneBody};

struct Trace(Vec<(f64, Energy)>);
impl Recorder for Trace {
    fn start(&mut self, _: &Plan) -> Result<(), RecorderError> {
        Ok(())
    }
    fn record(&mut self, f: &Frame) -> Result<(), RecorderError> {
        self.0.push((f.time(), f.energy.clone()));
        Ok(())
    }
    fn finish(&mut self, _: &Plan, _: &Outcome) -> Result<(), RecorderError> {
        Ok(())
    }
}

#[test]
fn breathing() {
    for n in [4u32, 8] {
        let mesh: Mesh = HollowBall {
            center: Vec3::zeros(),
            outer_radius_m: 0.015,
            inner_radius_m: 0.01,
            elements_around: n,
            elements_through: n / 2,
            part: "ball".into(),
        }
        .generate()
        .unwrap();
        let document: crate::scene::document::SceneDocument = serde_json::from_value(serde_json::json!({
        "name": "b", "end_time_s": 6e-4,
        "bodies": [{"name": "ball", "mesh": {"generator": {"kind": "hollow_ball", "outer_radius_m": 0.015, "inner_radius_m": 0.01, "elements_around": 4, "elements_through": 2}},
          "parts": [{"part": "ball", "density_kg_per_m3": 1000.0, "material": {"law": "mooney_rivlin", "c10_pa": 0.55e6, "c01_pa": 0.138e6, "bulk_modulus_pa": 1e8}}],
          "initial_deformation": {"kind": "spherical_inflation", "center_m": [0,0,0], "inner_radius_m": 0.01, "inner_stretch": 1.25}
        }]
    })).unwrap();
        let ne = mesh.hexes.len();
        let scene = Scene {
            document,
            bodies: vec![SceneBody {
                mesh,
                materials: vec![Material::MooneyRivlin(MooneyRivlin {
                    c10: 0.55e6,
                    c01: 0.138e6,
                    volumetric: Volumetric::LnSquared(1e8),
                })],
                part_entry: vec![0; ne],
                axes: Vec::<Mat3>::new(),
            }],
            content_hash: String::new(),
        };
        let plan = compile(&scene).unwrap();
        println!("{:#?}", plan.report);
        let mut trace = Trace(vec![]);
        let t0 = std::time::Instant::now();
        let (outcome, _) = run(&plan, &RunOptions { threads: 1, interrupt: &|| None }, &mut [&mut trace]);
        let dt = t0.elapsed().as_secs_f64();
        println!("{outcome:?} {dt} s, {} M element-steps/s", outcome.element_steps as f64 / dt / 1e6);
        let k = (trace.0.len() / 40).max(1);
        for (t, e) in trace.0.iter().step_by(k) {
            println!(
                "{t:.3e} K {:.5} U {:.5} visc {:.5} err {:.2e}",
                e.bodies[0].kinetic_j, e.bodies[0].strain_j, e.bodies[0].viscous_j, e.balance_error
            );
        }
    }
}

#[test]
fn sweep_speed() {
    use crate::mechanics::force::*;
    let mesh: Mesh = HollowBall {
        center: Vec3::zeros(),
        outer_radius_m: 0.015,
        inner_radius_m: 0.01,
        elements_around: 10,
        elements_through: 4,
        part: "ball".into(),
    }
    .generate()
    .unwrap();
    for law in 0..3 {
        let material = match law {
            0 => Material::MooneyRivlin(MooneyRivlin {
                c10: 0.55e6,
                c01: 0.138e6,
                volumetric: Volumetric::LnSquared(1e8),
            }),
            1 => Material::NeoHookean(NeoHookean { c10: 0.55e6, volumetric: Volumetric::LnSquared(1e8) }),
            _ => Material::HolzapfelGasserOgden(HolzapfelGasserOgden {
                c: 1e5,
                k1: 1e5,
                k2: 1.0,
                kappa: 0.1,
                families: FibreFamilies::new(&[[1.0, 0.5, 0.0], [1.0, -0.5, 0.0]]).unwrap(),
                i4: I4Form::Full,
                matrix: MatrixForm::Isochoric,
                volumetric: Volumetric::LnSquared(1e8),
            }),
        };
        let inputs: Vec<BlockInput> = (0..mesh.hexes.len())
            .map(|e| BlockInput {
                element: e as u32,
                nodes: mesh.hexes[e],
                axes: Mat3::identity(),
                geometry: crate::mechanics::element::ReferenceGeometry::new(&mesh.corners(e)),
            })
            .collect();
        let block = ElementBlock::new(
            0,
            BlockParameters {
                material,
                mean_dilatation: true,
                density: 1000.0,
                linear_viscosity: 0.06,
                quadratic_viscosity: 1.2,
            },
            0,
            &inputs,
        );
        let slots = block.slot_count();
        let u: Vec<Vec3> = mesh.nodes.iter().map(|x| x * 0.01 + Vec3::new(x.y, x.z, x.x) * 0.1).collect();
        let z = vec![0.0; slots];
        let (mut d, mut q, mut f, mut t) =
            (z.clone(), z.clone(), vec![Vec3::zeros(); 8 * slots], vec![BatchTotals::default(); slots / 8]);
        let mut best = f64::MAX;
        for _ in 0..30 {
            let t0 = std::time::Instant::now();
            for _ in 0..10 {
                block.sweep(
                    0,
                    &SweepInput { u: &u, inverse_step: 1e6, dilatation: &z, viscous_pressure: &z },
                    SweepOutput {
                        force: &mut f,
                        dilatation: &mut d,
                        viscous_pressure: &mut q,
                        totals: &mut t,
                    },
                );
            }
            best = best.min(t0.elapsed().as_secs_f64() / 10.0);
        }
        println!(
            "law {law} {} elements: {:.3} M element-steps/s, sweep {:.1} us",
            mesh.hexes.len(),
            mesh.hexes.len() as f64 / best / 1e6,
            best * 1e6
        );
        let mut best = f64::MAX;
        for _ in 0..30 {
            let t0 = std::time::Instant::now();
            largest_stretch_rate(&block, 0..block.batch_count(), &mesh.nodes, &u);
            best = best.min(t0.elapsed().as_secs_f64());
        }
        println!("rate {:.1} us", best * 1e6);
    }
}

use crate::mesh::generate::block::Block;
fn scene_of(doc: serde_json::Value, bodies: Vec<(Mesh, Material)>) -> Scene {
    let document = serde_json::from_value(doc).unwrap();
    let bodies = bodies
        .into_iter()
        .map(|(mesh, m)| {
            let n = mesh.hexes.len();
            SceneBody { mesh, materials: vec![m], part_entry: vec![0; n], axes: vec![] }
        })
        .collect();
    Scene { document, bodies, content_hash: String::new() }
}
fn go(scene: &Scene, every: usize) -> (Outcome, State, Vec<(f64, Energy)>) {
    let plan = compile(scene).unwrap();
    let mut trace = Trace(vec![]);
    let t0 = std::time::Instant::now();
    let (outcome, state) = run(&plan, &RunOptions { threads: 1, interrupt: &|| None }, &mut [&mut trace]);
    let dt = t0.elapsed().as_secs_f64();
    println!("{outcome:?} {dt} s, {} M element-steps/s", outcome.element_steps as f64 / dt / 1e6);
    let k = (trace.0.len() / every).max(1);
    for (t, e) in trace.0.iter().step_by(k) {
        let p = e.pairs[0];
        println!(
            "{t:.4e} E {:.5e} K {:.4e} U {:.4e} visc {:.3e} I {:.4e} {:.4e} {:.4e} fric {:.3e} num {:.3e} err {:.2e}",
            e.total_j,
            e.bodies.iter().map(|b| b.kinetic_j).sum::<f64>(),
            e.bodies.iter().map(|b| b.strain_j).sum::<f64>(),
            e.bodies.iter().map(|b| b.viscous_j).sum::<f64>(),
            p.impulse_n_s[0],
            p.impulse_n_s[1],
            p.impulse_n_s[2],
            p.friction_j,
            p.numerical_j,
            e.balance_error
        );
    }
    (outcome, state, trace.0)
}
#[test]
fn bar() {
    let mesh = Block::uniform(Vec3::new(0.005, 0.0, 0.0), Vec3::new(10.0, 1.0, 1.0), [100, 1, 1], "block")
        .generate()
        .unwrap();
    let scene = scene_of(
        serde_json::json!({"name": "bar", "end_time_s": 1.5, "bodies": [{"name": "bar", "mesh": {"file": {"name": "x"}}, "velocity_m_per_s": [-0.01, 0, 0], "parts": [{"part": "block", "density_kg_per_m3": 1.0, "material": {"law": "coupled_neo_hookean", "mu_pa": 450.0, "lambda_pa": 0.0}}]}],
       "planes": [{"name": "wall", "point_m": [0,0,0], "normal": [1,0,0]}], "integrator": {"kind": "explicit", "safety_factor": 0.9, "linear_bulk_viscosity": 0.0, "quadratic_bulk_viscosity": 0.0}}),
        vec![(mesh, Material::CoupledNeoHookean(CoupledNeoHookean { mu: 450.0, lambda: 0.0 }))],
    );
    let (_, state, _) = go(&scene, 40);
    println!("v end {:?}", state.v[0]);
}
#[test]
fn ball_block() {
    let ball = HollowBall {
        center: Vec3::new(0.0, 0.0, 0.06501),
        outer_radius_m: 0.015,
        inner_radius_m: 0.012,
        elements_around: 8,
        elements_through: 2,
        part: "ball".into(),
    }
    .generate()
    .unwrap();
    let block =
        Block::uniform(Vec3::new(-0.05, -0.05, 0.0), Vec3::new(0.1, 0.1, 0.05), [20, 20, 10], "block")
            .generate()
            .unwrap();
    for mu in [0.0, 0.3] {
        let scene = scene_of(
            serde_json::json!({"name": "bb", "end_time_s": 1e-4, "bodies": [
      {"name": "ball", "mesh": {"file": {"name": "x"}}, "velocity_m_per_s": [0, 0, -100], "parts": [{"part": "ball", "density_kg_per_m3": 1000.0, "material": {"law": "mooney_rivlin", "c10_pa": 5e5, "c01_pa": 1e5, "bulk_modulus_pa": 5e7}}]},
      {"name": "block", "mesh": {"file": {"name": "x"}}, "fixed": [{"set": "z_min"}], "parts": [{"part": "block", "density_kg_per_m3": 1060.0, "material": {"law": "mooney_rivlin", "c10_pa": 2e4, "c01_pa": 5e3, "bulk_modulus_pa": 2e7}}]}],
       "contact": {"friction": mu}}),
            vec![
                (
                    ball.clone(),
                    Material::MooneyRivlin(MooneyRivlin {
                        c10: 5e5,
                        c01: 1e5,
                        volumetric: Volumetric::Quadratic(5e7),
                    }),
                ),
                (
                    block.clone(),
                    Material::MooneyRivlin(MooneyRivlin {
                        c10: 2e4,
                        c01: 5e3,
                        volumetric: Volumetric::Quadratic(2e7),
                    }),
                ),
            ],
        );
        go(&scene, 20);
    }
}
