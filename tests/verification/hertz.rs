//! A ball on a rigid plane: Hertz (1882) for the normal load, Cattaneo (1938) and Mindlin (1949) for the tangential one.
//!
//! R = 10 mm, E = 1 MPa, ν = 0.3, F = 0.05 N: a = 0.698807494 mm, δ = 48.8331913 µm, p₀ = 48887.326 Pa. These are of the half
//! space and of small strain; here p₀/E = 5 % and a/R = 7 %, so a few per cent between theory and the limit of the meshes are
//! physical. What is meshed is the foot of the ball below its equator, 30° wide, which is some seven contact radii in all
//! directions; the equator goes down by δ.
//!
//! With friction and a tangential load Q the contact slips outside of c/a = (1 − Q/(μ P))^(1/3): 0.7937 at Q/(μ P) = 0.5. Sphere and
//! plane must not couple normal and tangential load, which a rigid plane does not where ν = ½.

use crate::rig::{assert_at_most, assert_close, plan_with, run};
use contuse::mechanics::tensor::Vec3;
use contuse::mesh::Mesh;
use contuse::mesh::generate::block::Block;
use contuse::plan::Plan;
use contuse::step::Frame;
use serde_json::{Value, json};

const R: f64 = 0.01;
const F: f64 = 0.05;
const A: f64 = 0.698_807_494e-3;
const DELTA: f64 = 48.833_191_3e-6;
const P0: f64 = 48_887.326;
/// Half the width of the foot, as an angle.
const WIDTH: f64 = std::f64::consts::FRAC_PI_6;

/// The foot of a ball with its pole at the origin: n elements from the pole to the side and to the top. A quarter, or a half
/// (y ≥ 0).
fn foot(n: u32, is_half: bool) -> Mesh {
    let (x_low, along) = if is_half { (-1.0, 2 * n) } else { (0.0, n) };
    let block = Block {
        min_m: [x_low, 0.0, 0.0],
        max_m: [1.0; 3],
        elements: [along, n, n],
        grading: Some([12.0, 12.0, 24.0]),
        grading_center_m: Some([0.0; 3]),
        part: "foot".into(),
    };
    let mut mesh = block.generate().unwrap();
    for X in &mut mesh.nodes {
        let (x, y) = ((WIDTH * X.x).tan(), (WIDTH * X.y).tan());
        let surface = Vec3::new(x, y, -1.0).normalize() * R;
        let top = Vec3::new(x, y, 0.0) * R;
        *X = surface * (1.0 - X.z) + top * X.z + Vec3::z() * R;
    }
    mesh
}

/// The foot on the plane z = 0: shear modulus and bulk modulus [Pa], prescribed motion of its top.
fn scene([shear, bulk]: [f64; 2], friction: f64, prescribed: &Value, end: f64, step: f64) -> Value {
    json!({
        "name": "Hertz",
        "end_time_s": end,
        "bodies": [{
            "name": "ball",
            "mesh": {"file": {"name": "foot.msh"}},
            "fixed": [{"set": "y_min", "axes": ["y"]}],
            "prescribed": prescribed,
            "parts": [{"part": "foot", "density_kg_per_m3": 1000.0, "material": {
                "law": "neo_hookean", "c10_pa": 0.5 * shear, "bulk_modulus_pa": bulk
            }}]
        }],
        "planes": [{"name": "plane", "point_m": [0, 0, 0], "normal": [0, 0, 1]}],
        "contact": {"friction": friction},
        "integrator": {"kind": "quasi_static", "step_s": step},
        "record": {"fields": [], "field_times_s": []}
    })
}

/// What the contact shows of a load step, of the whole ball.
#[derive(Clone, Copy, Debug, Default)]
struct Look {
    /// Normal and tangential force [N].
    normal: f64,
    tangential: f64,
    /// Radius, from the second moment of the pressure: ⟨r²⟩ = 2/5 a² [m].
    a: f64,
    /// Pressure at the pole [Pa].
    p0: f64,
    /// Second moments of normal and tangential traction about the pole [N m²].
    normal_moment: f64,
    tangential_moment: f64,
    /// Way of the top [m].
    delta: f64,
    time: f64,
}

fn look(frame: &Frame, plan: &Plan, part: f64) -> Look {
    let mut look = Look { time: frame.time, ..Look::default() };
    for (contact, reaction) in frame.contacts.iter().zip(frame.reactions) {
        let [p_n, p_1, p_2] = reaction.impulse.map(|p| p / frame.mean_step);
        let along = (contact.frame[1] * p_1 + contact.frame[2] * p_2).x;
        look.normal += p_n / part;
        look.tangential += along / part;
        let x = frame.position(contact.slave);
        let r_squared = x.x * x.x + x.y * x.y;
        look.normal_moment += p_n / part * r_squared;
        look.tangential_moment += along / part * r_squared;
        if plan.X[contact.slave as usize].xy().norm() < 1e-9 {
            let area = pole_area(frame, plan, contact.slave);
            look.p0 = p_n / area;
        }
    }
    look.a = (2.5 * look.normal_moment / look.normal.max(1e-300)).sqrt();
    let top = plan.X.iter().position(|X| (X - Vec3::z() * R).norm() < 1e-9).unwrap();
    look.delta = -frame.u[top].z;
    look
}

/// Area that the node at the pole stands for [m²].
fn pole_area(frame: &Frame, plan: &Plan, pole: u32) -> f64 {
    let faces: Vec<[u32; 4]> =
        plan.bodies[0].boundary.faces.iter().filter(|f| f.contains(&pole)).copied().collect();
    let below: Vec<[u32; 4]> = faces
        .into_iter()
        .filter(|face| {
            let [a, b, c, d] = face.map(|node| plan.X[node as usize]);
            (c - a).cross(&(d - b)).normalize().z < -0.9
        })
        .collect();
    let x: Vec<Vec3> = (0..plan.node_count()).map(|a| frame.position(a as u32)).collect();
    contuse::mesh::surface::tributary_areas(&below, &x)[pole as usize]
}

/// The looks of all load steps.
fn looks(scene: &Value, mesh: Mesh, part: f64) -> Vec<Look> {
    let plan = plan_with(scene, Some(mesh));
    let mut looks = Vec::new();
    let (outcome, _) = run(&plan, |frame| looks.push(look(frame, &plan, part)));
    assert_at_most(outcome.balance_error, 1e-6, "error of the energy balance");
    assert!(outcome.warnings.is_empty(), "{outcome:#?}");
    looks
}

/// Between the load steps around which `of` passes `value`: everything, with forces as powers of it.
fn at(looks: &[Look], of: impl Fn(&Look) -> f64, value: f64) -> Look {
    let pair = looks.windows(2).find(|w| of(&w[0]) < value && of(&w[1]) >= value).unwrap();
    let s = (value - of(&pair[0])) / (of(&pair[1]) - of(&pair[0]));
    let mix = |of: fn(&Look) -> f64| of(&pair[0]) + s * (of(&pair[1]) - of(&pair[0]));
    Look {
        normal: mix(|l| l.normal),
        tangential: mix(|l| l.tangential),
        a: mix(|l| l.a),
        p0: mix(|l| l.p0),
        normal_moment: mix(|l| l.normal_moment),
        tangential_moment: mix(|l| l.tangential_moment),
        delta: mix(|l| l.delta),
        time: mix(|l| l.time),
    }
}

/// At F = 0.05 N.
fn hertz(n: u32) -> Look {
    let (young, nu) = (1e6, 0.3);
    let moduli = [young / (2.0 * (1.0 + nu)), young / (3.0 * (1.0 - 2.0 * nu))];
    let prescribed = json!([{"set": "z_max", "axes": ["z"], "displacement_m": [0, 0, -60e-6]}]);
    let mut scene = scene(moduli, 0.0, &prescribed, 1.0, 0.05);
    scene["bodies"][0]["fixed"].as_array_mut().unwrap().push(json!({"set": "x_min", "axes": ["x"]}));
    at(&looks(&scene, foot(n, false), 0.25), |look| look.normal, F)
}

#[test]
fn a_ball_on_a_plane_touches_as_hertz_says() {
    // Measured against Hertz: a 1.052, 1.023, 1.0045; δ 0.984, 0.989, 0.993; p₀ 1.046, 1.021, 1.025.
    let found = [6, 12].map(hertz);
    for (look, tolerance) in found.iter().zip([0.06, 0.03]) {
        assert_close(look.a, A, tolerance, "a");
        assert_close(look.delta, DELTA, tolerance, "δ");
        assert_close(look.p0, P0, tolerance, "p₀");
    }
}

/// c/a at Q/(μ P) = 0.5, from the second moments of the tractions about the pole: M_q = μ M_p (1 − (c/a)⁵), since q is μ p less the
/// same for a contact of radius c. (The traction at the pole alone, q₀ = μ p₀ (1 − c/a), is a small difference of two pressures that
/// the meshes know to 5 %.)
fn stick_radius(n: u32) -> f64 {
    let (shear, friction) = (1e6 / 3.0, 0.3);
    let ramp = json!({"kind": "table", "times_s": [0, 1], "factors": [0, 1]});
    let prescribed = json!([
        {"set": "z_max", "axes": ["z"], "displacement_m": [0, 0, -40e-6], "ramp": ramp},
        {"set": "z_max", "axes": ["x"], "displacement_m": [12e-6, 0, 0],
         "ramp": {"kind": "table", "times_s": [1, 2], "factors": [0, 1]}}
    ]);
    let scene = scene([shear, 1000.0 * shear], friction, &prescribed, 2.0, 0.1);
    let looks = looks(&scene, foot(n, true), 0.5);
    let ratio = |look: &Look| -look.tangential / (friction * look.normal.max(1e-300));
    let found = at(&looks, ratio, 0.5);
    (1.0 + found.tangential_moment / (friction * found.normal_moment)).powf(0.2)
}

#[test]
fn a_tangential_load_slips_outside_of_the_radius_of_cattaneo_and_mindlin() {
    // Measured: 0.7449 on four elements across the radius, 0.7897 on seven.
    assert_close(stick_radius(6), 0.7937, 0.07, "c/a");
    assert_close(stick_radius(12), 0.7937, 0.01, "c/a");
}
