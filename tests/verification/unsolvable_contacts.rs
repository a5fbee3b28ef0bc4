//! Contact problems without a solution: masses squeezed between parts that approach each other. None counts as solved, however slow the
//! squeeze beside the velocities of other contacts, and whatever the solver.

use crate::rig::{plan, run_on};
use contuse::mechanics::contact::solution::delassus::Delassus;
use contuse::mechanics::contact::solution::problem::ContactProblem;
use contuse::mechanics::contact::solution::solvers::{
    Method, Options, SolveReport, solve, solve_frictionless,
};
use contuse::mechanics::tensor::{Mat3, Vec3};
use contuse::step::{Ending, FailureCause, State};
use serde_json::json;

/// A contact of a mass with another or with a wall: their numbers, the normal towards the first, and the speed at which the wall approaches.
type Touch = (Option<usize>, Option<usize>, Vec3, f64);

/// The axes of a contact as rows: normal, and two tangents.
fn frame(normal: &Vec3) -> Mat3 {
    let other = if normal.x.abs() < 0.9 { Vec3::x() } else { Vec3::y() };
    let t = normal.cross(&other).normalize();
    Mat3::from_columns(&[*normal, t, normal.cross(&t)]).transpose()
}

/// W and q of masses [kg] with velocities [m/s].
fn of_masses(masses: &[(f64, Vec3)], touches: &[Touch]) -> (Vec<f64>, Vec<f64>) {
    let sides =
        |(a, b, ..): &Touch| [(*a, 1.0), (*b, -1.0)].map(|(mass, sign)| mass.map(|mass| (mass, sign)));
    let rows = 3 * touches.len();
    let (mut W, mut q) = (vec![0.0; rows * rows], Vec::new());
    for (c, touch) in touches.iter().enumerate() {
        let both = sides(touch);
        let velocity: Vec3 = both.iter().flatten().map(|(mass, sign)| masses[*mass].1 * *sign).sum();
        q.extend((frame(&touch.2) * velocity - Vec3::x() * touch.3).iter());
        for (d, other) in touches.iter().enumerate() {
            let pairs =
                both.iter().flatten().flat_map(|a| sides(other).into_iter().flatten().map(move |b| (*a, b)));
            let coupling: f64 =
                pairs.filter(|(a, b)| a.0 == b.0).map(|(a, b)| a.1 * b.1 / masses[a.0].0).sum();
            let block = frame(&touch.2) * frame(&other.2).transpose() * coupling;
            for (i, j) in (0..9).map(|k| (k / 3, k % 3)) {
                W[(3 * c + i) * rows + 3 * d + j] = block[(i, j)];
            }
        }
    }
    (W, q)
}

fn problem(W: &[f64], q: &[f64], mu: f64) -> ContactProblem {
    let count = q.len() / 3;
    ContactProblem::new(Delassus::dense(count, W.to_vec()).unwrap(), q.to_vec(), vec![mu; count]).unwrap()
}

fn solve_from_rest(problem: &ContactProblem, method: Method) -> (Vec<f64>, SolveReport) {
    let mut r = vec![0.0; problem.q().len()];
    let report =
        solve(problem, &mut r, &Options { method, max_iterations: Some(3000), ..Options::default() });
    (r, report)
}

/// A mass between the floor and a press, hit by another that lands on the floor, with a third on top.
fn squeeze(speed: f64) -> (Vec<f64>, Vec<f64>) {
    let masses = [(1.0, Vec3::zeros()), (1.0, Vec3::new(-1.0, 0.2, -0.5)), (2.0, Vec3::new(0.1, 0.0, -2.0))];
    let up = Vec3::z();
    let across = Vec3::new(1.0, 0.0, 0.1).normalize();
    let on_floor = |mass| (Some(mass), None, up, 0.0);
    let press = (None, Some(0), up, speed);
    of_masses(
        &masses,
        &[on_floor(0), press, (Some(1), Some(0), across, 0.0), on_floor(1), (Some(2), Some(1), up, 0.0)],
    )
}

#[test]
fn a_slow_squeeze_hides_behind_no_reactions() {
    for speed in [1.0, 1e-1, 1e-2, 1e-3, 1e-4, 1e-5] {
        let (W, q) = squeeze(speed);
        for (mu, method) in [0.0, 0.3, 1.0].into_iter().flat_map(|mu| Method::ALL.map(|method| (mu, method)))
        {
            let report = solve_from_rest(&problem(&W, &q, mu), method).1;
            let what = format!("{speed:e}, μ = {mu}, {}: {report:?}", method.name());
            assert!(!report.converged, "{what}");
            assert!(report.is_jammed || !matches!(method, Method::Hybrid | Method::Frictionless), "{what}");
        }
        // One unknown per contact.
        let normal = |x: &[f64]| x.iter().step_by(3).copied().collect::<Vec<f64>>();
        let W: Vec<f64> = W.chunks_exact(q.len()).step_by(3).flat_map(normal).collect();
        let report = solve_frictionless(&W, &normal(&q), &mut [0.0; 5], &Options::default()).unwrap();
        assert!(!report.converged && report.is_jammed, "{speed:e}: {report:?}");
    }
}

/// What is below the tolerance of the whole may remain.
#[test]
fn no_squeeze_below_the_tolerance_is_an_error() {
    for mu in [0.0, 0.3] {
        let (W, q) = squeeze(1e-9);
        let report = solve_from_rest(&problem(&W, &q, mu), Method::Hybrid).1;
        assert!(report.converged && !report.is_jammed, "μ = {mu}: {report:?}");
    }
}

/// A mass between two walls that close on it as a wedge, lifted out by a heavier one: Newton steps see reactions without bound.
#[test]
fn a_wedged_mass_that_is_lifted_is_not_jammed() {
    let (sine, cosine) = (0.579_841_313_398_086_1, 0.814_729_434_399_41);
    let masses = [(1.0, Vec3::zeros()), (1.0 / 0.382_988_457_791_517, Vec3::z() * 2.317_143_611_672_151_3)];
    let wall = |side: f64| (Some(0), None, Vec3::new(side * cosine, 0.0, sine), cosine);
    for copies in [1, 3] {
        let one = [wall(1.0), wall(-1.0), (Some(0), Some(1), Vec3::z(), 0.0)];
        let touches: Vec<Touch> = one.into_iter().flat_map(|touch| vec![touch; copies]).collect();
        let (W, mut q) = of_masses(&masses, &touches);
        // The walls close along x, so that they slide on the mass, too.
        for (c, touch) in touches.iter().enumerate().filter(|(_, touch)| touch.1.is_none()) {
            let wall = Vec3::x() * touch.2.x.signum();
            q[3 * c..3 * c + 3].copy_from_slice((-frame(&touch.2) * wall).as_slice());
        }
        let (_, report) = solve_from_rest(&problem(&W, &q, 1.244_132_639_021_750_6), Method::Hybrid);
        assert!(report.converged && !report.is_jammed, "{copies}: {report:?}");
    }
}

/// Contacts of nodes that are driven change nothing, and are none.
#[test]
fn contacts_that_cannot_move_are_none() {
    for integrator in
        [json!({"kind": "implicit", "step_s": 5e-4}), json!({"kind": "quasi_static", "step_s": 5e-4})]
    {
        let scene = json!({
            "name": "driven", "end_time_s": 0.01,
            "bodies": [{
                "name": "plate", "role": "other",
                "mesh": {"generator": {"kind": "block", "min_m": [0, 0, 1e-5], "max_m": [0.02, 0.02, 0.01], "elements": [2, 2, 2]}},
                "parts": [{"part": "block", "density_kg_per_m3": 1000,
                    "material": {"law": "neo_hookean", "c10_pa": 1e5, "bulk_modulus_pa": 1e7}}],
                "prescribed": [{"set": "z_min", "displacement_m": [0.001, 0, 0], "ramp": {"kind": "linear", "to_s": 0.01}}]
            }],
            "planes": [{"name": "floor", "point_m": [0, 0, 0], "normal": [0, 0, 1]}],
            "contact": {"friction": 0.3},
            "integrator": integrator,
            "record": {"fields": [], "field_times_s": []}
        });
        let plan = plan(&scene);
        let (outcome, _) = run_on(&plan, State::new(&plan), 1, |_| ());
        assert_eq!(outcome.ending, Ending::Finished, "{integrator}");
    }
}

/// Reactions are thousands of times the velocities, but there are some.
#[test]
fn a_light_mass_under_a_heavy_one_is_not_jammed() {
    for (mass, mu) in [1e-2, 1e-4, 1e-6, 1e-8].into_iter().flat_map(|mass| [0.0, 0.3].map(|mu| (mass, mu))) {
        let masses = [(mass, Vec3::zeros()), (1.0, Vec3::new(0.3, 0.0, -1.0))];
        let touches = [(Some(0), None, Vec3::z(), 0.0), (Some(1), Some(0), Vec3::z(), 0.0)];
        let (W, q) = of_masses(&masses, &touches);
        let (r, report) = solve_from_rest(&problem(&W, &q, mu), Method::Hybrid);
        assert!(report.converged && !report.is_jammed, "{mass:e}, μ = {mu}: {report:?}");
        // The error of a velocity of the light mass is that of the heavy one, too.
        let off = (r[0] - 1.0).abs();
        assert!(off <= 2e-7 / mass.sqrt(), "{mass:e}, μ = {mu}: all of the momentum goes through, {off:e}");
    }
}

/// A ball between the floor and a press, at a hundredth of the speed of a box that slides beside it.
#[test]
fn a_slow_squeeze_ends_a_run_with_a_diagnosis() {
    let rigid = |name: &str, shape: serde_json::Value, center: [f64; 3], velocity: f64| {
        json!({
            "name": name, "role": "projectile", "velocity_m_per_s": [velocity, 0, 0],
            "rigid": {"shape": shape, "center_m": center, "mass_kg": 0.05}
        })
    };
    let mut scene = json!({
        "name": "press", "end_time_s": 2e-2, "gravity_m_per_s2": [0, 0, -9.81],
        "bodies": [
            rigid("ball", json!({"kind": "ball", "radius_m": 0.01}), [0.0, 0.0, 0.01], 0.0),
            rigid("box", json!({"kind": "box", "half_extents_m": [0.02, 0.02, 0.01]}), [0.0, 0.1, 0.01], 2.0),
            {
                "name": "press", "role": "tissue",
                "mesh": {"generator": {
                    "kind": "block", "min_m": [-0.02, -0.02, 0.0201], "max_m": [0.02, 0.02, 0.03], "elements": [4, 4, 2]
                }},
                "parts": [{"part": "*", "density_kg_per_m3": 1000.0, "material": {
                    "law": "neo_hookean", "c10_pa": 2e4, "bulk_modulus_pa": 2e6
                }}],
                "prescribed": [{"set": "*", "displacement_m": [0, 0, -4e-4], "ramp": {"kind": "linear", "to_s": 2e-2}}]
            }
        ],
        "planes": [{"name": "floor", "point_m": [0, 0, 0], "normal": [0, 0, 1]}],
        "contact": {"friction": 0.3},
        "record": {"fields": [], "field_times_s": []}
    });
    for integrator in [json!({"kind": "explicit"}), json!({"kind": "implicit", "step_s": 5e-4})] {
        scene["integrator"] = integrator;
        let plan = plan(&scene);
        let (outcome, _) = run_on(&plan, State::new(&plan), 1, |_| {});
        let Ending::Failed { failure } = &outcome.ending else { panic!("{outcome:#?}") };
        assert_eq!(failure.cause, FailureCause::ContactJammed, "{failure}");
        // The press reaches the ball at 5 ms.
        let time = failure.time_s.unwrap();
        assert!((4.4e-3..6e-3).contains(&time), "{time}");
        let cuts = outcome.warnings.iter().filter(|warning| warning.contains("cut")).count();
        assert!(cuts <= 1, "{:?}", outcome.warnings);
    }
}
