//! A symmetric scene whose half, quarter or eighth is computed is the scene that is computed in whole.

use crate::rig::{contact_force, loaded, plan, small_ball_on_block, summary};
use contuse::mechanics::tensor::Vec3;
use contuse::plan::{Plan, SectorPlan};
use contuse::step::{Ending, Frame, Interrupt, Outcome, Recorder, RecorderError, RunOptions, State};
use serde_json::{Value, json};

/// What is compared at a step.
#[derive(Default)]
struct Step {
    time: f64,
    force: Vec3,
    energies: Vec<f64>,
    momenta: Vec<f64>,
    contacts: usize,
    /// Von Mises stress [Pa] at each point, at look times.
    stress: Vec<f64>,
}

#[derive(Default)]
struct Steps(Vec<Step>);

impl Recorder for Steps {
    fn record(&mut self, frame: &Frame) -> Result<(), RecorderError> {
        let energy = frame.energy;
        let of_body = |b: &contuse::step::BodyEnergy| {
            [b.kinetic_j, b.strain_j, b.viscous_j, b.contact_work_j, b.external_work_j]
        };
        let of_pair = |p: &contuse::step::PairLedger| [p.friction_j, p.numerical_j, p.work_on_slave_j];
        let sums = [energy.total_j, energy.scale_j, energy.initial_total_j];
        let bodies = energy.bodies.iter().flat_map(of_body);
        self.0.push(Step {
            time: frame.time,
            force: contact_force(frame),
            energies: bodies.chain(energy.pairs.values().flat_map(of_pair)).chain(sums).collect(),
            momenta: energy
                .momentum_kg_m_per_s
                .into_iter()
                .chain(energy.angular_momentum_kg_m2_per_s)
                .collect(),
            contacts: frame.reactions.iter().filter(|reaction| reaction.impulse[0] > 0.0).count(),
            stress: if frame.is_look_time { stresses(frame) } else { Vec::new() },
        });
        Ok(())
    }
}

/// Von Mises stresses of all points in the order of the elements [Pa].
fn stresses(frame: &Frame) -> Vec<f64> {
    let mut all = vec![0.0; 8 * frame.plan.element_count()];
    for block in &frame.plan.blocks {
        block.for_each_moved_batch(frame.points(), &mut |slots, points| {
            for (lane, element) in block.elements[slots].iter().enumerate() {
                for q in 0..points.count {
                    all[8 * *element as usize + q] = points.von_mises[q].0[lane];
                }
            }
        });
    }
    all
}

fn run_plan(plan: &Plan) -> (Vec<Step>, Outcome, State) {
    let mut steps = Steps::default();
    let options = RunOptions { threads: 1, interrupt: &|| None::<Interrupt> };
    let (outcome, state) = contuse::step::run(plan, &options, &mut [&mut steps]);
    assert_eq!(outcome.ending, Ending::Finished, "{outcome:#?}");
    (steps.0, outcome, state)
}

/// Compares a scene of so many `images` with the whole: largest differences of force, energies, momenta and stresses, relative to the largest of each,
/// are at most `near`. The whole is not quite symmetric itself, since a node in a plane of symmetry is held by one of the two faces that it
/// is between: displacements differ by about as much as those of its own mirror images.
fn assert_same(document: &Value, images: usize, near: [f64; 4]) {
    let mut keeping = document.clone();
    keeping["solver"] = json!({"keep": ["mirror_images"]});
    let (of_sector, of_whole) = (plan(document), plan(&keeping));
    assert!(of_whole.sector.is_none());
    let Some(SectorPlan { plan: part, sector }) = &of_sector.sector else { panic!("the scene is symmetric") };
    assert_eq!(sector.images.count(), images);
    assert_eq!(of_sector.element_count(), images * part.element_count());
    let (got, _, state) = run_plan(&of_sector);
    let (expected, _, whole) = run_plan(&of_whole);
    assert_eq!(got.len(), expected.len());
    assert!(expected.iter().any(|step| step.contacts > 4), "there is an impact");

    // Along the normals of the planes the sector has no force and no momentum; the whole has those of its rounding and of contacts that
    // prefer one of two faces of a mirror.
    let largest = |values: &dyn Fn(&Step) -> f64| expected.iter().map(values).fold(0.0, f64::max);
    let force = largest(&|step| step.force.norm());
    let energy = largest(&|step| step.energies.iter().copied().fold(0.0, f64::max));
    let momentum = largest(&|step| step.momenta.iter().fold(0.0, |most: f64, m| most.max(m.abs())));
    let stress = largest(&|step| step.stress.iter().copied().fold(0.0, f64::max));
    let apart = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    let mut most = [0.0_f64; 4];
    for (a, b) in got.iter().zip(&expected) {
        assert!((a.time - b.time).abs() <= 1e-12);
        for plane in &sector.images.0 {
            assert!(a.force[plane.axis].abs() <= 1e-12 * force);
        }
        most[0] = most[0].max((a.force - b.force).norm() / force);
        most[1] = most[1].max(apart(&a.energies, &b.energies) / energy);
        most[2] = most[2].max(apart(&a.momenta, &b.momenta) / momentum);
        most[3] = most[3].max(apart(&a.stress, &b.stress) / stress);
    }
    let moved = whole.u.iter().map(Vec3::norm).fold(0.0, f64::max);
    let asymmetry = (0..whole.u.len()).map(|node| {
        let (source, image) = sector.source[node];
        let own = whole.u[sector.image_of_node(source, 0) as usize];
        (whole.u[node] - sector.images.reflected(own, image as usize)).norm() / moved
    });
    let asymmetry = asymmetry.fold(0.0, f64::max);
    let apart = state.u.iter().zip(&whole.u).map(|(a, b)| (a - b).norm() / moved).fold(0.0, f64::max);
    assert!(apart <= 5.0 * asymmetry, "apart by {apart:e} of the displacement, the whole by {asymmetry:e}");
    assert!(most.iter().zip(near).all(|(most, near)| *most <= near), "{most:?}, not {near:?}");
}

/// A ball on a block, hit in the middle; steps of equal length, so that the same times are compared.
fn ball_on_block(velocity: [f64; 3]) -> Value {
    let mut scene = small_ball_on_block([4, 2], [8, 8, 4], velocity, 2e-4);
    scene["integrator"] = json!({"kind": "explicit", "max_step_s": 5e-7});
    scene
}

/// For contacts of two meshes.
const NEAR: [f64; 4] = [5e-3, 5e-4, 1e-8, 5e-3];

#[test]
fn a_quarter_of_a_ball_on_a_fibred_block() {
    assert_same(&ball_on_block([0.0, 0.0, -30.0]), 4, NEAR);
}

#[test]
fn what_a_quarter_remembers() {
    let mut scene = ball_on_block([0.0, 0.0, -30.0]);
    let prony = json!({"branches": [{"relative_modulus": 3, "relaxation_time_s": 5e-5}, {"relative_modulus": 1, "relaxation_time_s": 1e-3}]});
    for body in 0..2 {
        scene["bodies"][body]["parts"][0]["prony_series"] = prony.clone();
    }
    assert_same(&scene, 4, NEAR);
}

#[test]
fn a_quarter_in_implicit_steps() {
    let mut scene = ball_on_block([0.0, 0.0, -30.0]);
    scene["integrator"] = json!({"kind": "implicit", "step_s": 2e-6});
    assert_same(&scene, 4, NEAR);
}

#[test]
fn half_of_two_flat_blocks_in_implicit_steps() {
    let block = |name: &str, low: f64, velocity: [f64; 3], fixed: Value| {
        json!({"name": name, "velocity_m_per_s": velocity, "fixed": fixed,
            "mesh": {"generator": {"kind": "block", "min_m": [0, 0, low], "max_m": [0.008, 0.008, low + 0.004], "elements": [4, 4, 2]}},
            "parts": [{"part": "block", "density_kg_per_m3": 1000, "material": {"law": "neo_hookean", "c10_pa": 2e5, "bulk_modulus_pa": 1e7}}]})
    };
    let bodies = [
        block("lower", 0.0, [0.0; 3], json!([{"set": "z_min"}])),
        block("upper", 0.004, [0.1, 0.0, -1.0], json!([])),
    ];
    let scene = json!({"name": "flat", "end_time_s": 5e-5, "bodies": bodies, "contact": {"friction": 0.3},
        "integrator": {"kind": "implicit", "step_s": 1e-5}, "record": {"fields": [], "field_times_s": []}});
    // As far as Newton's iteration and the contact solver converge.
    assert_same(&scene, 2, [1e-4, 1e-4, 1e-5, 1e-3]);
}

#[test]
fn half_of_an_oblique_impact() {
    assert_same(&ball_on_block([12.0, 0.0, -30.0]), 2, NEAR);
}

#[test]
fn half_of_a_spinning_ball_away_from_the_origin() {
    let mut scene = ball_on_block([12.0, 0.0, -30.0]);
    scene["bodies"][0]["spin_rad_per_s"] = json!([0, 700, 0]);
    for body in 0..2 {
        scene["bodies"][body]["placement"] = json!({"translation_m": [0.4, -0.7, 0.2]});
    }
    scene["gravity_m_per_s2"] = json!([0, 0, -9.81]);
    assert_same(&scene, 2, NEAR);
}

#[test]
fn a_quarter_of_a_rigid_ball_on_a_limb_with_locally_refined_skin() {
    let mut scene = rigid_on_limb(&json!({"kind": "ball", "radius_m": 0.02}));
    scene["bodies"][1]["refinement"] = json!([{"around": "impact", "within_m": 0.015, "size_m": 0.012}]);
    assert_same(&scene, 4, [1e-6, 1e-10, 1e-13, 1e-9]);
}

#[test]
fn a_quarter_of_a_rigid_capsule() {
    let mut scene = rigid_on_limb(
        &json!({"kind": "capsule", "radius_m": 0.02, "half_length_m": 0.02, "axis": [1, 0, 0]}),
    );
    scene["bodies"][1]["mesh"]["generator"]["elements_around"] = json!(20);
    assert_same(&scene, 4, [0.1, 1e-3, 1e-5, 0.05]);
}

#[test]
fn contacts_in_planes_of_symmetry_count_once_and_boundary_mass_is_that_of_the_whole() {
    // Edges of the block in both planes hold the capsule between their nodes.
    let mut scene = json!({
        "name": "capsule on gel", "end_time_s": 4e-4,
        "bodies": [
            {"name": "capsule", "role": "projectile", "velocity_m_per_s": [0, 0, -10],
             "rigid": {"shape": {"kind": "capsule", "radius_m": 0.01, "half_length_m": 0.012, "axis": [0, 1, 0]},
                "center_m": [0, 0, 0.0402], "density_kg_per_m3": 2000}},
            {"name": "gel", "role": "tissue", "fixed": [{"set": "z_min"}],
             "mesh": {"generator": {"kind": "block", "min_m": [-0.03, -0.03, 0], "max_m": [0.03, 0.03, 0.03], "elements": [6, 6, 4]}},
             "parts": [{"part": "block", "density_kg_per_m3": 1000,
                "material": {"law": "neo_hookean", "c10_pa": 2e4, "bulk_modulus_pa": 2e6}}]}
        ],
        "contact": {"friction": 0.3, "pairs": [{"between": ["capsule", "gel"]}]},
        "record": {"fields": [], "field_times_s": []}, "solver": {"error_bars": "none"}
    });
    let numbers = |scene: &Value| {
        let summary = summary(&loaded(scene, None));
        let impact = &summary.values().impacts[0];
        [&impact.patch_area_mm2, &impact.impulse_n_s, &impact.peak_force_n].map(|number| number.value)
    };
    for redistributed in [0.0, 0.75] {
        scene["contact"]["mass_redistribution"] = json!(redistributed);
        scene["solver"] = json!({"error_bars": "none"});
        assert_eq!(plan(&scene).sector.expect("symmetric").sector.images.count(), 4);
        let of_sector = numbers(&scene);
        scene["solver"]["keep"] = json!(["mirror_images"]);
        let of_whole = numbers(&scene);
        // The whole holds a capsule by one of the two faces beside a plane: its patches are not quite symmetric.
        for ((part, whole), near) in of_sector.into_iter().zip(of_whole).zip([1e-2, 1e-3, 1e-3]) {
            assert!((part - whole).abs() <= near * whole, "{of_sector:?}, not {of_whole:?}");
        }
    }
}

/// A rigid body over a limb.
fn rigid_on_limb(shape: &Value) -> Value {
    json!({
        "name": "rigid on limb", "end_time_s": 5e-4,
        "bodies": [
            {"name": "striker", "rigid": {"shape": shape, "mass_kg": 0.1, "center_m": [0, 0, 0.0905]},
             "velocity_m_per_s": [0, 0, -20]},
            {"name": "limb", "role": "tissue",
             "mesh": {"generator": {"kind": "limb_segment", "semi_axis_x_m": 0.075, "semi_axis_z_m": 0.07, "length_m": 0.12,
                "bone_semi_axis_x_m": 0.014, "bone_semi_axis_z_m": 0.014, "fat_thickness_m": 0.008, "skin_thickness_m": 0.002,
                "elements_around": 12, "elements_along": 6, "muscle_elements": 2, "fat_elements": 1, "skin_elements": 1}},
             "fixed": [{"set": "bone"}],
             "parts": [{"part": "*", "density_kg_per_m3": 1000, "shear_viscosity_pa_s": 5,
                "material": {"law": "neo_hookean", "c10_pa": 4e4, "bulk_modulus_pa": 2e7}}]}
        ],
        "contact": {"friction": 0.2},
        "record": {"fields": [], "field_times_s": []},
        "integrator": {"kind": "explicit", "max_step_s": 4e-6}
    })
}

#[test]
fn what_differs_on_both_sides_is_computed_in_whole() {
    let symmetric = ball_on_block([0.0, 0.0, -30.0]);
    let planes = |scene: &Value| plan(scene).sector.map_or(0, |of| of.sector.images.0.len());
    assert_eq!(planes(&symmetric), 2);
    let with = |change: &dyn Fn(&mut Value)| {
        let mut scene = symmetric.clone();
        change(&mut scene);
        planes(&scene)
    };
    let block =
        |scene: &mut Value, field: &str, value: Value| scene["bodies"][1]["mesh"]["generator"][field] = value;
    // One plane is left.
    assert_eq!(with(&|scene| scene["bodies"][0]["velocity_m_per_s"][1] = json!(1)), 1);
    assert_eq!(with(&|scene| block(scene, "elements", json!([7, 8, 4]))), 1);
    assert_eq!(with(&|scene| scene["gravity_m_per_s2"] = json!([1, 0, 0])), 1);
    assert_eq!(with(&|scene| scene["bodies"][1]["fixed"] = json!([{"set": "x_min"}])), 1);
    assert_eq!(with(&|scene| scene["bodies"][0]["spin_rad_per_s"] = json!([100, 0, 0])), 1);
    // Fibres along one direction of two are mirrored to the other; one family aslant is not.
    let one_family = json!({"angles_deg": [29.0]});
    assert_eq!(with(&|scene| scene["bodies"][1]["parts"][0]["material"]["fibres"] = one_family.clone()), 0);
    assert_eq!(with(&|scene| scene["bodies"][0]["placement"] = json!({"translation_m": [1e-4, 0, 0]})), 1);
    // What the images do not derive.
    assert_eq!(with(&|scene| scene["bodies"][1]["parts"][0]["erosion"] = json!({"stretch": 3.0})), 0);
    assert_eq!(with(&|scene| scene["contact"]["discretisation"] = json!("mortar")), 0);
}
