//! Every law of a scene document in every formulation: statically against its material point, and in an impact.

use crate::rig::{assert_at_most, assert_close, plan, run};
use contuse::mechanics::material::{Path, eval_path};
use contuse::step::Energy;
use serde_json::{Value, json};

/// The laws by the side of those that other tests run.
fn laws() -> Vec<Value> {
    let fibres = json!({"angles_deg": [30.0, -30.0]});
    let mut laws = vec![
        json!({"law": "yeoh", "c10_pa": 5e4, "c20_pa": -2e3, "c30_pa": 200.0}),
        json!({"law": "demiray", "mu_pa": 1e5, "b": 2.0}),
        json!({"law": "veronda_westmann", "c1_pa": 4e4, "c2": 2.5}),
        json!({"law": "ogden", "terms": {"mu_alpha": [{"mu_pa": 6e4, "alpha": 2.6}, {"mu_pa": -1e4, "alpha": -3.3}]}}),
        json!({"law": "ogden", "terms": {"febio": [{"c_pa": 8e4, "m": 12.0}, {"c_pa": 2e4, "m": -2.0}]}}),
        json!({"law": "weiss_transversely_isotropic", "c10_pa": 4e4, "c01_pa": 1e4, "c3_pa": 3e3, "c4": 20.0, "c5_pa": 4e5,
               "straight_stretch": 1.06, "fibres": fibres, "i4": "isochoric"}),
        json!({"law": "fung_orthotropic", "c_pa": 1e5, "young_pa": [4e5, 3e5, 2e5], "shear_pa": [1e5, 8e4, 1.2e5],
               "poisson": [0.3, 0.2, 0.1]}),
        json!({"law": "peng_guo_moran", "c10_pa": 5e4, "c2_pa": 1e5, "c3_pa": 1e5, "gamma_pa": 3e5, "beta": 20.0, "shear_stretch": 1.05,
            "fibres": fibres}),
        json!({"law": "balzani", "c1_pa": 5e4, "alpha1_pa": 2e5, "alpha2": 2.5, "fibres": fibres}),
    ];
    for law in &mut laws {
        law["bulk_modulus_pa"] = json!(2e6);
    }
    laws.push(json!({"law": "blatz_ko", "mu_pa": 1e5}));
    laws
}

/// Law, formulation and a cube of the law, 1 cm wide.
fn cubes() -> Vec<(String, Value)> {
    let of = |law: Value| {
        let is_split = law["law"] != "blatz_ko";
        let formulations = ["full", "reduced", "mean_dilatation"];
        formulations.into_iter().take(if is_split { 3 } else { 2 }).map(move |formulation| {
            let part = json!({
                "part": "block", "density_kg_per_m3": 1000.0, "material": law, "formulation": formulation,
                "fibre_frame": {"kind": "constant", "axis": [1, 0, 0], "plane": [0, 1, 0]}
            });
            let body = json!({
                "name": "cube",
                "mesh": {"generator": {"kind": "block", "min_m": [0, 0, 0], "max_m": [0.01, 0.01, 0.01], "elements": [2, 2, 2]}},
                "parts": [part]
            });
            let scene = json!({"name": "cube", "bodies": [body], "record": {"fields": [], "field_times_s": []}});
            (format!("{} {formulation}", law["law"]), scene)
        })
    };
    laws().into_iter().flat_map(of).collect()
}

#[test]
fn a_stretched_cube_has_the_energy_of_its_material_point() {
    for (what, mut scene) in cubes() {
        let stretch = 1.15;
        scene["end_time_s"] = json!(1.0);
        scene["integrator"] = json!({"kind": "quasi_static", "step_s": 0.25, "newton_tolerance": 1e-11});
        let body = &mut scene["bodies"][0];
        body["fixed"] = json!([
            {"set": "x_min", "axes": ["x"]}, {"set": "y_min", "axes": ["y"]}, {"set": "z_min", "axes": ["z"]}
        ]);
        body["prescribed"] =
            json!([{"set": "x_max", "axes": ["x"], "displacement_m": [0.01 * (stretch - 1.0), 0, 0]}]);
        let plan = plan(&scene);
        let law = plan.blocks[0].parameters.material;
        let point = eval_path(&law, law.fibre_directions(), Path::Uniaxial, &[stretch]).unwrap()[0];
        let mut energy = Energy::default();
        run(&plan, |frame| energy = frame.energy.clone());
        assert_close(energy.bodies[0].strain_j, point.stress.psi * 1e-6, 1e-8, &what);
    }
}

#[test]
fn a_thrown_cube_bounces_off_a_wall_and_keeps_its_energy() {
    for (what, mut scene) in cubes() {
        scene["end_time_s"] = json!(2e-3);
        scene["bodies"][0]["velocity_m_per_s"] = json!([2.0, 0.0, -5.0]);
        scene["planes"] = json!([{"name": "floor", "point_m": [0, 0, -1e-4], "normal": [0, 0, 1]}]);
        scene["contact"] = json!({"pairs": [{"between": ["floor", "cube"], "friction": 0.3}]});
        for integrator in
            [json!({"kind": "explicit", "safety_factor": 0.5}), json!({"kind": "implicit", "step_s": 5e-5})]
        {
            scene["integrator"] = integrator;
            let (outcome, _) = run(&plan(&scene), |_| {});
            assert_at_most(outcome.balance_error, 0.01, &format!("{what}: error of the energy balance"));
        }
    }
}
