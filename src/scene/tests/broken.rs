//! Broken variants of the valid scene, one per line.

use serde_json::{Value, json};

/// Pointer to the change, the new value, and the pointer and code of the expected problem.
pub type Break = (&'static str, Value, &'static str, &'static str);

/// All broken variants of the valid scene, by subject.
pub fn broken() -> Vec<Break> {
    [structure(), names(), materials(), motion(), times(), loads(), contact(), meshes(), solver()].concat()
}

#[rustfmt::skip]
fn structure() -> Vec<Break> {
    vec![
        ("/nmae", json!(1), "/nmae", "unknown_field"),
        ("/bodies/0/parts/0/densty", json!(1), "/bodies/0/parts/0/densty", "unknown_field"),
        ("/end_time_s", json!("soon"), "/end_time_s", "wrong_type"),
        ("/end_time_s", json!(null), "/end_time_s", "wrong_type"),
        ("/bodies", json!({}), "/bodies", "wrong_type"),
        ("/bodies/0/role", json!("projectil"), "/bodies/0/role", "unknown_variant"),
        ("/bodies/0/velocity_m_per_s", json!([1, 2]), "/bodies/0/velocity_m_per_s", "too_few_items"),
        ("/bodies/0/velocity_m_per_s", json!([1, 2, 3, 4]), "/bodies/0/velocity_m_per_s", "too_many_items"),
        ("/bodies/0/velocity_m_per_s/2", json!("fast"), "/bodies/0/velocity_m_per_s/2", "wrong_type"),
        ("/bodies/0/parts/0/material/law", json!("money_rivlin"), "/bodies/0/parts/0/material/law", "unknown_variant"),
        ("/bodies/0/parts/0/material", json!({"c10_pa": 1}), "/bodies/0/parts/0/material/law", "missing_field"),
        ("/bodies/0/parts/0/material/c01_pa", json!("1"), "/bodies/0/parts/0/material/c01_pa", "wrong_type"),
        ("/bodies/0/parts/0/material/volumetric", json!("ln"), "/bodies/0/parts/0/material/volumetric", "unknown_variant"),
        ("/bodies/0/parts/0/formulation", json!("redcued"), "/bodies/0/parts/0/formulation", "unknown_variant"),
        ("/bodies/0/mesh/generator/kind", json!("holow_ball"), "/bodies/0/mesh/generator/kind", "unknown_variant"),
        ("/bodies/0/mesh/generator/elements_around", json!(-1), "/bodies/0/mesh/generator/elements_around", "out_of_range"),
        ("/bodies/0/mesh/generator/elements_around", json!(5e9), "/bodies/0/mesh/generator/elements_around", "out_of_range"),
        ("/bodies/0/mesh/generator/elements_around", json!(1.5), "/bodies/0/mesh/generator/elements_around", "wrong_type"),
        ("/bodies/0/mesh", json!({}), "/bodies/0/mesh", "wrong_type"),
        ("/bodies/0/mesh", json!({"fil": {}}), "/bodies/0/mesh", "wrong_type"),
        ("/bodies/0/mesh", json!({"file": {"nam": "x"}}), "/bodies/0/mesh/file/name", "missing_field"),
        ("/bodies/1/parts/0/fibre_frame", json!({"kind": "mesh", "axis": 1}), "/bodies/1/parts/0/fibre_frame/axis", "unknown_field"),
        ("/bodies/1/parts/0/fibre_frame/kind", json!("mush"), "/bodies/1/parts/0/fibre_frame/kind", "unknown_variant"),
        ("/bodies/1/parts/0/material/fibres", json!({"angles": [1]}), "/bodies/1/parts/0/material/fibres", "wrong_type"),
        ("/bodies/1/fixed/0/axes", json!(["w"]), "/bodies/1/fixed/0/axes/0", "unknown_variant"),
        ("/contact/pairs", json!("al"), "/contact/pairs", "unknown_variant"),
        ("/contact/pairs/0/between", json!(["ball"]), "/contact/pairs/0/between", "too_few_items"),
        ("/contact/pairs/0/frction", json!(1), "/contact/pairs/0/frction", "unknown_field"),
        ("/integrator/kind", json!("magic"), "/integrator/kind", "unknown_variant"),
        ("/integrator/safety", json!(0.5), "/integrator/safety", "unknown_field"),
        ("/record/fields/0", json!("stress"), "/record/fields/0", "unknown_variant"),
    ]
}

#[rustfmt::skip]
fn names() -> Vec<Break> {
    vec![
        ("/bodies", json!([]), "/bodies", "no_bodies"),
        ("/bodies/1/name", json!("ball"), "/bodies/1/name", "repeated_name"),
        ("/planes/0/name", json!("ball"), "/planes/0/name", "repeated_name"),
        ("/bodies/0/name", json!(" "), "/bodies/0/name", "empty_name"),
        ("/bodies/0/name", json!("a/b"), "/bodies/0/name", "bad_name"),
        ("/bodies/0/name", json!("a\u{202e}b"), "/bodies/0/name", "bad_name"),
        ("/name", json!("x".repeat(201)), "/name", "bad_name"),
        ("/description", json!("x".repeat(10_001)), "/description", "too_long"),
        ("/bodies/0/parts/0/density_kg_per_m3", json!(1e300), "/bodies/0/parts/0/density_kg_per_m3", "out_of_range"),
        ("/bodies/0/parts/0/material/bulk_modulus_pa", json!(1e300), "/bodies/0/parts/0/material/bulk_modulus_pa", "out_of_range"),
        ("/bodies/0/initial_deformation", json!({"kind": "affine", "center_m": [0, 0, 0],
            "deformation_gradient": [[1e-12, 0, 0], [0, 1, 0], [0, 0, 1]]}), "/end_time_s", "budget_steps"),
        ("/contact/pairs/0/between/0", json!("bal"), "/contact/pairs/0/between/0", "unknown_body"),
        ("/contact/pairs/1/between", json!(["limb", "ball"]), "/contact/pairs/1/between", "repeated_pair"),
        ("/contact/pairs/1/between", json!(["floor", "floor"]), "/contact/pairs/1/between", "planes_only"),
        ("/bodies/1/fixed/0/set", json!("bnoe"), "/bodies/1/fixed/0/set", "unknown_set"),
        ("/measures/skin_set", json!("skin"), "/measures/skin_set", "unknown_set"),
        ("/bodies/1/role", json!("other"), "/measures/skin_set", "no_tissue"),
        ("/bodies/0/parts/0/part", json!("bal"), "/bodies/0/parts/0/part", "unknown_part"),
        ("/bodies/0/parts/0/part", json!("bal"), "/bodies/0/parts", "part_without_material"),
        ("/bodies/1/parts/1/part", json!("muscle"), "/bodies/1/parts/1/part", "repeated_part"),
        ("/bodies/0/parts", json!([]), "/bodies/0/parts", "no_parts"),
    ]
}

#[rustfmt::skip]
fn materials() -> Vec<Break> {
    vec![
        ("/bodies/0/parts/0/density_kg_per_m3", json!(0), "/bodies/0/parts/0/density_kg_per_m3", "not_positive"),
        ("/bodies/0/parts/0/density_kg_per_m3", json!(1), "/bodies/0/parts/0/density_kg_per_m3", "unusual_unit"),
        ("/bodies/0/parts/0/material/c10_pa", json!(-2e5), "/bodies/0/parts/0/material/c10_pa", "unstable_law"),
        ("/bodies/0/parts/0/material/c01_pa", json!(-4e5), "/bodies/0/parts/0/material/c01_pa", "unstable_law"),
        ("/bodies/0/parts/0/material/c01_pa", json!(-1e5), "/bodies/0/parts/0/material/c01_pa", "law_unstable_far_from_rest"),
        ("/bodies/0/parts/0/material/bulk_modulus_pa", json!(0), "/bodies/0/parts/0/material/bulk_modulus_pa", "not_positive"),
        ("/bodies/0/parts/0/material/bulk_modulus_pa", json!(5e5), "/bodies/0/parts/0/material/bulk_modulus_pa", "negative_poisson"),
        ("/bodies/0/parts/0/material/bulk_modulus_pa", json!(5e6), "/bodies/0/parts/0/material/volumetric", "soft_volume"),
        ("/bodies/0/parts/0/material/bulk_modulus_pa", json!(5e11), "/bodies/0/parts/0/material/bulk_modulus_pa", "stiff_volume"),
        ("/bodies/0/parts/0/material", json!({"law": "coupled_neo_hookean", "mu_pa": 3e5, "lambda_pa": -2e5}), "/bodies/0/parts/0/material/lambda_pa", "unstable_law"),
        ("/bodies/1/parts/0/material/c_pa", json!(0), "/bodies/1/parts/0/material/c_pa", "not_positive"),
        ("/bodies/1/parts/0/material/k1_pa", json!(-1), "/bodies/1/parts/0/material/k1_pa", "negative"),
        ("/bodies/1/parts/0/material/k1_pa", json!(0), "/bodies/1/parts/0/material/fibres", "idle_fibres"),
        ("/bodies/1/parts/0/material/k2", json!(0), "/bodies/1/parts/0/material/k2", "not_positive"),
        ("/bodies/1/parts/0/material/kappa", json!(0.34), "/bodies/1/parts/0/material/kappa", "out_of_range"),
        ("/bodies/1/parts/0/material/fibres/angles_deg", json!([1, 2, 3, 4, 5]), "/bodies/1/parts/0/material/fibres", "too_many_items"),
        ("/bodies/1/parts/0/material/fibres/angles_deg", json!([]), "/bodies/1/parts/0/material/fibres", "no_fibres"),
        ("/bodies/1/parts/0/material/fibres", json!({"directions": [[0, 0, 0]]}), "/bodies/1/parts/0/material/fibres/directions/0", "no_direction"),
        ("/bodies/0/parts/0/fibre_frame", json!({"kind": "mesh"}), "/bodies/0/parts/0/fibre_frame", "unused_fibre_frame"),
        ("/bodies/0/parts/0/material", json!({"law": "yeoh", "c10_pa": 5e5, "c20_pa": -2e5, "bulk_modulus_pa": 5e7}), "/bodies/0/parts/0/material/c20_pa", "unstable_law"),
        ("/bodies/0/parts/0/material", json!({"law": "demiray", "mu_pa": 5e5, "b": 0, "bulk_modulus_pa": 5e7}), "/bodies/0/parts/0/material/b", "not_positive"),
        ("/bodies/0/parts/0/material", json!({"law": "veronda_westmann", "c1_pa": 5e6, "c2": 0.05, "bulk_modulus_pa": 5e7}), "/bodies/0/parts/0/material/c2", "unstable_law"),
        ("/bodies/0/parts/0/material", json!({"law": "ogden", "terms": {"mu_alpha": []}, "bulk_modulus_pa": 5e7}), "/bodies/0/parts/0/material/terms/mu_alpha", "too_many_items"),
        ("/bodies/0/parts/0/material", json!({"law": "ogden", "terms": {"mu_alpha": [{"mu_pa": -5e5, "alpha": 2}]}, "bulk_modulus_pa": 5e7}), "/bodies/0/parts/0/material/terms/mu_alpha", "not_positive"),
        ("/bodies/0/parts/0/material", json!({"law": "ogden", "terms": {"febio": [{"c_pa": 5e5, "m": 80}]}, "bulk_modulus_pa": 5e7}), "/bodies/0/parts/0/material/terms/febio/0/m", "out_of_range"),
        ("/bodies/0/parts/0/material", json!({"law": "blatz_ko", "mu_pa": 0}), "/bodies/0/parts/0/material/mu_pa", "not_positive"),
        ("/bodies/1/parts/0/material", json!({"law": "balzani", "c1_pa": 1e4, "alpha1_pa": 1e4, "alpha2": 2, "fibres": {"angles_deg": [0]}, "bulk_modulus_pa": 2e7}), "/bodies/1/parts/0/material/alpha2", "out_of_range"),
        ("/bodies/1/parts/0/material", weiss("straight_stretch", 1.8), "/bodies/1/parts/0/material/straight_stretch", "out_of_range"),
        ("/bodies/1/parts/0/material", weiss("c4", 500.0), "/bodies/1/parts/0/material/c4", "out_of_range"),
        ("/bodies/1/parts/0/material", weiss("c5_pa", -1.0), "/bodies/1/parts/0/material/c5_pa", "negative"),
        ("/bodies/1/parts/0/material", json!({"law": "fung_orthotropic", "c_pa": 1e4, "young_pa": [1e5, 1e5, 1e5], "shear_pa": [1e4, 1e4, 1e4], "poisson": [0.6, 0.6, 0.6], "bulk_modulus_pa": 2e7}), "/bodies/1/parts/0/material/poisson", "unstable_law"),
        ("/bodies/1/parts/0/fibre_frame", json!({"kind": "constant", "axis": [1, 0, 0], "plane": [2, 0, 0]}), "/bodies/1/parts/0/fibre_frame/plane", "parallel_directions"),
    ]
}

/// A valid fibred tissue except for one number.
fn weiss(name: &str, value: f64) -> Value {
    let mut law = json!({"law": "weiss_transversely_isotropic", "c10_pa": 1e4, "c3_pa": 1e3, "c4": 20.0, "c5_pa": 1e5,
        "straight_stretch": 1.1, "fibres": {"angles_deg": [0.0]}, "bulk_modulus_pa": 2e7});
    law[name] = json!(value);
    law
}

#[rustfmt::skip]
fn motion() -> Vec<Break> {
    vec![
        ("/bodies/1/velocity_m_per_s", json!([0, 0, 1]), "/bodies/1/velocity_m_per_s/2", "fixed_but_flying"),
        ("/bodies/1/spin_rad_per_s", json!([0, 0, 1]), "/bodies/1/spin_rad_per_s", "fixed_but_spinning"),
        ("/bodies/0/velocity_m_per_s", json!([0, 0, -3000]), "/bodies/0/velocity_m_per_s", "unusual_unit"),
        ("/bodies/1/fixed/0/axes", json!([]), "/bodies/1/fixed/0/axes", "no_axes"),
        ("/bodies/0/initial_deformation", json!({"kind": "affine", "center_m": [0, 0, 0], "deformation_gradient": [[-1, 0, 0], [0, 1, 0], [0, 0, 1]]}), "/bodies/0/initial_deformation/deformation_gradient", "inverted"),
        ("/bodies/0/initial_deformation", json!({"kind": "spherical_inflation", "center_m": [0, 0, 0.1], "inner_radius_m": 0.02, "inner_stretch": 0.5}), "/bodies/0/initial_deformation/inner_stretch", "inverted"),
    ]
}

/// Steps that conserve energy and momenta.
fn conserving() -> Value {
    json!({"kind": "implicit", "step_s": 1e-6, "energy_momentum": true})
}

/// The valid scene with something that dissipates in its first part, and other steps.
fn dissipating(name: &str, value: Value, integrator: &Value) -> Value {
    let mut document = super::with("/integrator", integrator.clone());
    super::set(&mut document, &format!("/bodies/0/parts/0/{name}"), value);
    document
}

/// Implicit steps with additional settings.
fn implicit(name: &str, value: f64) -> Value {
    let mut integrator = json!({"kind": "implicit", "step_s": 1e-6});
    integrator[name] = json!(value);
    integrator
}

fn times() -> Vec<Break> {
    vec![
        ("/end_time_s", json!(0), "/end_time_s", "not_positive"),
        ("/end_time_s", json!(1e5), "/end_time_s", "budget_steps"),
        ("/end_time_s", json!(-1), "/end_time_s", "not_positive"),
        ("/record/field_times_s", json!([0, 2e-4]), "/record/field_times_s/1", "time_outside_run"),
        ("/record/field_times_s", json!([5e-5, 5e-5]), "/record/field_times_s/1", "times_not_ascending"),
        ("/record/field_interval_s", json!(1e-5), "/record/field_interval_s", "times_and_interval"),
        ("/record/every_steps", json!(0), "/record/every_steps", "out_of_range"),
        ("/integrator/safety_factor", json!(1.5), "/integrator/safety_factor", "out_of_range"),
        ("/integrator/safety_factor", json!(0), "/integrator/safety_factor", "out_of_range"),
        (
            "/integrator/largest_strain_increment",
            json!(0.6),
            "/integrator/largest_strain_increment",
            "out_of_range",
        ),
        ("/integrator", json!({"kind": "implicit", "step_s": 0}), "/integrator/step_s", "not_positive"),
        ("/integrator", implicit("theta", 0.4), "/integrator/theta", "out_of_range"),
        ("/integrator", implicit("xi", 1.1), "/integrator/xi", "out_of_range"),
        ("/integrator", implicit("newton_tolerance", 0.1), "/integrator/newton_tolerance", "out_of_range"),
        ("/integrator", implicit("smallest_step_s", 1e-5), "/integrator/smallest_step_s", "out_of_range"),
        ("/integrator", implicit("energy_gate", 2.0), "/integrator/energy_gate", "out_of_range"),
        ("/dynamic_relaxation/damping_per_s", json!(0), "/dynamic_relaxation/damping_per_s", "not_positive"),
        ("/gravity_m_per_s2", json!([0, 0, 0]), "/dynamic_relaxation", "relaxation_without_gravity"),
        (
            "",
            dissipating("shear_viscosity_pa_s", json!(10), &conserving()),
            "/bodies/0/parts/0/shear_viscosity_pa_s",
            "dissipation_in_conserving_steps",
        ),
        (
            "",
            dissipating(
                "prony_series",
                json!({"branches": [{"relative_modulus": 0.2, "relaxation_time_s": 1e-5}]}),
                &conserving(),
            ),
            "/bodies/0/parts/0/prony_series",
            "dissipation_in_conserving_steps",
        ),
        (
            "",
            dissipating("shear_viscosity_pa_s", json!(10), &json!({"kind": "quasi_static", "step_s": 1e-5})),
            "/bodies/0/parts/0/shear_viscosity_pa_s",
            "viscosity_in_load_steps",
        ),
    ]
}

/// A load on the limb's skin with additional settings.
fn load(set: &str, ramp: &Value) -> Value {
    json!([{"kind": "pressure", "set": set, "pressure_pa": 1e3, "ramp": ramp}])
}

/// A prescribed displacement of the limb's skin with additional settings.
fn prescribed(name: &str, value: Value) -> Value {
    let mut prescribed = json!({"set": "skin_outer", "displacement_m": [0, 0, 1e-3], "ramp": {"kind": "linear", "to_s": 1e-4}});
    prescribed[name] = value;
    json!([prescribed])
}

#[rustfmt::skip]
fn loads() -> Vec<Break> {
    vec![
        ("/gravity_ramp", json!({"kind": "linear", "from_s": 2, "to_s": 1}), "/gravity_ramp/to_s", "times_not_ascending"),
        ("/gravity_ramp", json!({"kind": "table", "times_s": [0, 1], "factors": [0]}), "/gravity_ramp/factors", "table_lengths"),
        ("/gravity_ramp", json!({"kind": "table", "times_s": [0, 0], "factors": [0, 1]}), "/gravity_ramp/times_s/1", "times_not_ascending"),
        ("/gravity_ramp", json!({"kind": "constant", "to_s": 1}), "/gravity_ramp/to_s", "unknown_field"),
        ("/bodies/1/face_loads", load("skin", &json!({"kind": "constant"})), "/bodies/1/face_loads/0/set", "unknown_set"),
        ("/bodies/1/face_loads", load("skin_outer", &json!({"kind": "linear", "to_s": 0})), "/bodies/1/face_loads/0/ramp/to_s", "times_not_ascending"),
        ("/bodies/1/prescribed", prescribed("set", json!("skin")), "/bodies/1/prescribed/0/set", "unknown_set"),
        ("/bodies/1/prescribed", prescribed("set", json!("bone")), "/bodies/1/prescribed/0/set", "held_twice"),
        ("/bodies/1/prescribed", prescribed("axes", json!([])), "/bodies/1/prescribed/0/axes", "no_axes"),
        ("/bodies/1/prescribed", prescribed("ramp", json!({"kind": "constant"})), "/bodies/1/prescribed/0/ramp", "prescribed_jump"),
        ("/bodies/0/prescribed", json!([{"set": "outer", "displacement_m": [0, 0, 0]}]), "/bodies/0/velocity_m_per_s/2", "prescribed_but_flying"),
        ("/preload", json!({"steps": 0}), "/preload/steps", "out_of_range"),
        ("/preload", json!({"newton_tolerance": 1}), "/preload/newton_tolerance", "out_of_range"),
        ("/preload", json!({}), "/dynamic_relaxation", "preload_and_dynamic_relaxation"),
        ("/integrator", json!({"kind": "quasi_static", "step_s": 1e-5}), "/dynamic_relaxation", "dynamic_relaxation_and_quasi_static"),
        ("/integrator", json!({"kind": "quasi_static", "step_s": 1e-5}), "/bodies/0/velocity_m_per_s", "motion_without_mass"),
        ("/integrator", json!({"kind": "quasi_static", "step_s": 1}), "/integrator/step_s", "out_of_range"),
        ("/integrator", json!({"kind": "quasi_static", "step_s": 1e-5, "smallest_step_s": 1}), "/integrator/smallest_step_s", "out_of_range"),
    ]
}

#[rustfmt::skip]
fn contact() -> Vec<Break> {
    vec![
        ("/contact/friction", json!(-0.1), "/contact/friction", "out_of_range"),
        ("/contact/pairs/0/friction", json!(11), "/contact/pairs/0/friction", "out_of_range"),
        ("/planes/0/normal", json!([0, 0, 0]), "/planes/0/normal", "no_direction"),
        ("/measures/stress_thresholds_pa", json!([1e5, 1e4]), "/measures/stress_thresholds_pa/1", "not_ascending"),
        ("/measures/force_window_s", json!(0), "/measures/force_window_s", "not_positive"),
        ("/measures/exceeded_in_volume_m3", json!(100), "/measures/exceeded_in_volume_m3", "out_of_range"),
    ]
}

#[rustfmt::skip]
fn solver() -> Vec<Break> {
    vec![
        ("/solver", json!({"keep": ["inactive_elements", "fast"]}), "/solver/keep/1", "unknown_variant"),
        ("/solver", json!({"keep": ["idle_fibres", "idle_fibres"]}), "/solver/keep/1", "repeated_item"),
        ("/solver", json!({"omit": []}), "/solver/omit", "unknown_field"),
        ("/solver", json!({"keep": "all"}), "/solver/keep", "wrong_type"),
    ]
}

#[rustfmt::skip]
fn meshes() -> Vec<Break> {
    vec![
        ("/bodies/0/mesh/generator/inner_radius_m", json!(0.02), "/bodies/0/mesh/generator/inner_radius_m", "bad_generator_parameter"),
        ("/bodies/0/mesh/generator/elements_around", json!(4_000_000_000_u32), "/bodies/0/mesh/generator", "budget_elements"),
        ("/bodies/0/mesh", json!({"file": {"name": "cub.msh"}}), "/bodies/0/mesh/file/name", "mesh_not_found"),
        ("/bodies/0/mesh", json!({"file": {"name": "noise.msh"}}), "/bodies/0/mesh/file/name", "bad_mesh"),
        ("/bodies/0/mesh", json!({"file": {"name": "bad.msh"}}), "/bodies/0/mesh", "negative_jacobian"),
        ("/bodies/0/mesh", json!({"file": {"name": "cube.msh", "parts": ["cueb"]}}), "/bodies/0/mesh/file/parts/0", "unknown_part"),
        ("/bodies/0/sets", json!([{"name": "pole", "min_m": [1, 1, 1], "max_m": [2, 2, 2]}]), "/bodies/0/sets/0", "empty_set"),
        ("/bodies/0/sets", json!([{"name": "outer", "min_m": [-1, -1, -1], "max_m": [1, 1, 1]}]), "/bodies/0/sets/0/name", "repeated_name"),
        ("/bodies/0/placement/scale", json!(0), "/bodies/0/placement/scale", "not_positive"),
        ("/bodies/0/placement/scale", json!(1000), "/bodies/0/mesh", "unusual_unit"),
        ("/bodies/0/placement/scale", json!(1e300), "/bodies/0/mesh", "impossible_size"),
        ("/bodies/0/placement/rotation/axis", json!([0, 0, 0]), "/bodies/0/placement/rotation/axis", "no_direction"),
    ]
}
