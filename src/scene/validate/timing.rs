//! Checks of times: the end, the integrator, dynamic relaxation, and the recording.

use super::Findings;
use crate::scene::budget::Budget;
use crate::scene::document::{IntegratorDocument, RecordDocument, SceneDocument};
use crate::scene::problem::{Pointer, Problem};
use serde_json::Value;

/// Checks all times and integrator settings of the scene.
pub fn check(document: &SceneDocument, budget: &Budget, out: &mut Findings) {
    let root = Pointer::root();
    let end = document.end_time_s;
    out.positive(&root.key("end_time_s"), "the end time", end, "impacts last about 1e-4 to 1e-2 s");
    check_integrator(&document.integrator, &root.key("integrator"), out);
    if let IntegratorDocument::Implicit { step_s, .. }
    | IntegratorDocument::Auto { step_s: Some(step_s), .. } = &document.integrator
    {
        out.require(!(*step_s > end), || {
            let message = "the step is longer than the run";
            Problem::error("out_of_range", &root.key("integrator").key("step_s"), message)
                .value(*step_s)
                .limit(format!("<= end_time_s = {end}"))
                .remedy("give a hundredth of the run, or less")
        });
    }
    check_rigid(document, &root, out);
    check_viscosity(document, &root, out);
    check_relaxation(document, &root, out);
    check_record(&document.record, end, budget, &root.key("record"), out);
}

/// Without elements there is no critical time step, so rigid bodies need a largest step.
fn check_rigid(document: &SceneDocument, root: &Pointer, out: &mut Findings) {
    let IntegratorDocument::Explicit { max_step_s, .. } = &document.integrator else { return };
    let has_elements = document.bodies.iter().any(|body| body.rigid.is_none());
    out.require(has_elements || document.bodies.is_empty() || max_step_s.is_some(), || {
        let place = root.key("integrator").key("max_step_s");
        Problem::error("no_step", &place, "all bodies are rigid: no element limits the time step")
            .limit("a largest time step [s] for a scene of rigid bodies")
            .remedy("1e-4 s is a good trial for bodies of centimetres at metres per second")
    });
}

/// Softening and erosion need explicit steps; viscosity and relaxation need time, which energy-conserving steps and quasi-static runs
/// without real time have not.
fn check_viscosity(document: &SceneDocument, root: &Pointer, out: &mut Findings) {
    let integrator = &document.integrator;
    if matches!(integrator, IntegratorDocument::Explicit { .. } | IntegratorDocument::Auto { .. }) {
        return;
    }
    let conserves = matches!(integrator, IntegratorDocument::Implicit { energy_momentum: true, .. });
    for (b, body) in document.bodies.iter().enumerate() {
        for (p, part) in body.parts.iter().enumerate() {
            let here = root.key("bodies").index(b).key("parts").index(p);
            for (field, rules) in part.rules() {
                let here = here.key(field);
                match rules.without_explicit_steps {
                    Some(code) => out.push(needs_explicit_steps(code, &here, rules.name)),
                    None => out.require(!conserves, || conserving(&here, rules.name)),
                }
            }
            out.require(part.erosion.is_none(), || {
                needs_explicit_steps("erosion_without_explicit_steps", &here.key("erosion"), "erosion")
            });
            if part.shear_viscosity_pa_s <= 0.0 {
                continue;
            }
            let place = here.key("shear_viscosity_pa_s");
            out.require(!conserves, || conserving(&place, "viscosity"));
            if integrator.is_quasi_static() {
                let message = "quasi-static steps have no velocities: the viscosity has no effect";
                out.push(
                    Problem::warning("viscosity_in_load_steps", &place, message)
                        .value(part.shear_viscosity_pa_s)
                        .limit("0 in quasi-static runs")
                        .remedy("take explicit or implicit steps, or omit the viscosity"),
                );
            }
        }
    }
}

fn needs_explicit_steps(code: &'static str, place: &Pointer, what: &str) -> Problem {
    Problem::error(code, place, format!("only explicit steps support {what}"))
        .limit(format!("no {what} in implicit and quasi-static runs"))
        .remedy(format!("step explicitly, or omit the {what}"))
}

fn conserving(place: &Pointer, what: &str) -> Problem {
    let message = format!("energy-conserving steps do not support {what}");
    Problem::error("dissipation_in_conserving_steps", place, message)
        .limit("`energy_momentum` false")
        .remedy("omit `energy_momentum`: the θ scheme supports it")
}

fn check_integrator(integrator: &IntegratorDocument, here: &Pointer, out: &mut Findings) {
    match integrator {
        IntegratorDocument::Explicit { .. } => check_explicit(integrator, here, out),
        IntegratorDocument::Implicit { .. } => check_implicit(integrator, here, out),
        IntegratorDocument::Auto { step_s, theta, .. } => {
            check_step(*step_s, here, out);
            check_weight("theta", *theta, here, out);
        }
        // Checked in `loads`, with the loads themselves.
        IntegratorDocument::QuasiStatic { .. } => {}
    }
    let energy_gate = integrator.energy_gate();
    out.require(energy_gate > 0.0 && energy_gate <= 1.0, || {
        Problem::error(
            "out_of_range",
            &here.key("energy_gate"),
            "the limit on the energy balance error is out of its range",
        )
        .value(energy_gate)
        .limit("> 0 and <= 1")
        .remedy("0.01 is the default")
    });
}

fn check_explicit(integrator: &IntegratorDocument, here: &Pointer, out: &mut Findings) {
    let IntegratorDocument::Explicit {
        safety_factor,
        max_step_s,
        largest_strain_increment,
        linear_bulk_viscosity,
        quadratic_bulk_viscosity,
        ..
    } = integrator
    else {
        return;
    };
    out.require(*safety_factor > 0.0 && *safety_factor <= 1.0, || {
        let message = "the safety factor is a fraction of the critical time step";
        Problem::error("out_of_range", &here.key("safety_factor"), message)
            .value(*safety_factor)
            .limit("> 0 and <= 1")
            .remedy("0.9 is the default; above 1 the run is unstable")
    });
    if let Some(step) = max_step_s {
        out.positive(&here.key("max_step_s"), "the largest step", *step, "omit it for no bound");
    }
    let remedy = "0.1 is the default; above 0.5 one step may invert an element";
    let here_strain = here.key("largest_strain_increment");
    out.between(&here_strain, "the strain of a step", *largest_strain_increment, [1e-3, 0.5], remedy);
    let viscosities = [
        ("linear_bulk_viscosity", *linear_bulk_viscosity),
        ("quadratic_bulk_viscosity", *quadratic_bulk_viscosity),
    ];
    for (name, value) in viscosities {
        let remedy = "the defaults are 0.06 (linear) and 1.2 (quadratic); 0 switches it off";
        out.between(&here.key(name), "the viscosity", value, [0.0, 10.0], remedy);
    }
}

fn check_implicit(integrator: &IntegratorDocument, here: &Pointer, out: &mut Findings) {
    let IntegratorDocument::Implicit {
        step_s,
        theta,
        xi,
        energy_momentum,
        newton_tolerance,
        smallest_step_s,
        ..
    } = integrator
    else {
        return;
    };
    check_step(Some(*step_s), here, out);
    check_weight("theta", *theta, here, out);
    if let Some(xi) = xi {
        check_weight("xi", *xi, here, out);
    }
    let is_middle = |weight: f64| (weight - 0.5).abs() < f64::EPSILON;
    let (name, weight) = if is_middle(*theta) { ("xi", xi.unwrap_or(0.5)) } else { ("theta", *theta) };
    out.require(!energy_momentum || is_middle(weight), || {
        let message = "the conserving scheme evaluates forces at the middle of the step";
        Problem::error("energy_momentum_weight", &here.key(name), message)
            .value(weight)
            .limit("0.5 where `energy_momentum` is true")
            .remedy("omit `theta` and `xi`, or `energy_momentum`")
    });
    check_newton_tolerance(*newton_tolerance, "the impulses of a step", here, out);
    check_smallest_step(*smallest_step_s, *step_s, here, out);
}

/// Tolerance of Newton's iteration, relative to the quantity that scales its residual.
pub(super) fn check_newton_tolerance(tolerance: f64, of: &str, here: &Pointer, out: &mut Findings) {
    out.require((1e-13..=1e-3).contains(&tolerance), || {
        let message = format!("the tolerance is a fraction of {of}");
        Problem::error("out_of_range", &here.key("newton_tolerance"), message)
            .value(tolerance)
            .limit(">= 1e-13 and <= 1e-3")
            .remedy("1e-8 is the default")
    });
}

/// Smallest step of a scheme that halves steps which do not converge.
pub(super) fn check_smallest_step(smallest: Option<f64>, step: f64, here: &Pointer, out: &mut Findings) {
    let Some(smallest) = smallest else { return };
    out.require(smallest > 0.0 && smallest <= step, || {
        let message = "the smallest step must not exceed the step";
        Problem::error("out_of_range", &here.key("smallest_step_s"), message)
            .value(smallest)
            .limit(format!("> 0 and <= step_s = {step}"))
            .remedy("omit it for 1e-4 of the step")
    });
}

fn check_step(step: Option<f64>, here: &Pointer, out: &mut Findings) {
    let remedy =
        "the time in which the results change by a few per cent, such as 1/100 of the contact duration";
    if let Some(step) = step {
        out.positive(&here.key("step_s"), "the step", step, remedy);
    }
}

fn check_weight(name: &str, weight: f64, here: &Pointer, out: &mut Findings) {
    out.require((0.5..=1.0).contains(&weight), || {
        let message = "the weight of the end of the step is out of range: below 0.5 the scheme is unstable";
        Problem::error("out_of_range", &here.key(name), message)
            .value(weight)
            .limit(">= 0.5 and <= 1")
            .remedy("0.5 conserves energy, 0.6 damps unresolved frequencies, 1 damps most")
    });
}

fn check_relaxation(document: &SceneDocument, root: &Pointer, out: &mut Findings) {
    let gravity = document.gravity_m_per_s2.unwrap_or_default();
    let strength = gravity.iter().map(|g| g * g).sum::<f64>().sqrt();
    out.require(strength <= 1e4, || {
        Problem::warning("unusual_unit", &root.key("gravity_m_per_s2"), "gravity is very strong")
            .value(strength)
            .limit("usually 9.81 m/s²")
            .remedy("give it in m/s²")
    });
    let Some(relaxation) = &document.dynamic_relaxation else { return };
    let here = root.key("dynamic_relaxation");
    out.positive(
        &here.key("duration_s"),
        "the duration",
        relaxation.duration_s,
        "omit \"dynamic_relaxation\" for none",
    );
    let remedy = "about twice the lowest frequency of the body [rad/s] converges fastest";
    out.positive(&here.key("damping_per_s"), "the damping", relaxation.damping_per_s, remedy);
    out.require(strength > 0.0, || {
        Problem::error("relaxation_without_gravity", &here, "dynamic relaxation needs gravity")
            .limit("a scene with gravity")
            .remedy("add gravity_m_per_s2, or omit \"dynamic_relaxation\"")
    });
}

fn check_record(record: &RecordDocument, end: f64, budget: &Budget, here: &Pointer, out: &mut Findings) {
    out.require(record.every_steps >= 1, || {
        Problem::error("out_of_range", &here.key("every_steps"), "nothing is recorded every 0 steps")
            .value(record.every_steps)
            .limit(">= 1")
            .remedy("1 records contact and energy at every step")
    });
    for (i, field) in record.fields.iter().enumerate() {
        out.require(!record.fields[..i].contains(field), || {
            Problem::error("repeated_field", &here.key("fields").index(i), "the field is listed already")
                .value(serde_json::to_value(field).unwrap_or_default())
                .limit("each field once")
                .remedy("keep one of them")
        });
    }
    out.require(record.field_times_s.is_none() || record.field_interval_s.is_none(), || {
        let message = "both times and an interval are given";
        Problem::error("times_and_interval", &here.key("field_interval_s"), message)
            .value(record.field_interval_s.map_or(Value::Null, Value::from))
            .limit("one of field_times_s and field_interval_s")
            .remedy("keep one of them")
    });
    if let Some(interval) = record.field_interval_s {
        let place = here.key("field_interval_s");
        out.positive(&place, "the interval", interval, "omit it for 1/50 of the run");
        let frames = end / interval;
        out.require(!(interval > 0.0 && end > 0.0) || frames <= budget.frames as f64, || {
            too_many_frames(&place, frames, budget).value(interval)
        });
    }
    if let Some(times) = &record.field_times_s {
        check_times(times, end, budget, &here.key("field_times_s"), out);
    }
}

fn check_times(times: &[f64], end: f64, budget: &Budget, here: &Pointer, out: &mut Findings) {
    out.require(times.len() as u64 <= budget.frames, || too_many_frames(here, times.len() as f64, budget));
    let mut previous = f64::NEG_INFINITY;
    for (i, &time) in times.iter().enumerate() {
        // 30 × 1e-5 is not 3e-4 to the last bit; times this close beyond the end count as the end.
        out.require(time >= 0.0 && (time <= end * (1.0 + 1e-9) || end <= 0.0), || {
            Problem::error("time_outside_run", &here.index(i), "the time lies outside the run")
                .value(time)
                .limit(format!("between 0 and end_time_s = {end}"))
                .remedy("remove the time, or run longer")
        });
        out.require(time > previous, || {
            Problem::error("times_not_ascending", &here.index(i), "the time is not later than the one before")
                .value(time)
                .limit(format!("> {previous}"))
                .remedy("sort the times and give each once")
        });
        previous = previous.max(time);
    }
}

fn too_many_frames(place: &Pointer, frames: f64, budget: &Budget) -> Problem {
    Problem::error("budget_frames", place, format!("this gives {frames:.0} frames of fields"))
        .limit(format!("at most {} frames", budget.frames))
        .remedy("record fields less often")
}
