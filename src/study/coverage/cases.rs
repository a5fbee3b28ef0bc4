//! Scenes with exact solutions, each over meshes, speeds, steps and integrators.

use serde_json::{Value, json};

const PEAK_FORCE: &str = "/impacts/0/peak_force_n";
const IMPULSE: &str = "/impacts/0/impulse_n_s";
const DURATION: &str = "/impacts/0/contact_duration_s";
const PATCH: &str = "/impacts/0/patch_area_mm2";
const FRICTION: &str = "/impacts/0/friction_dissipation_j";
const ABSORBED: &str = "/tissue/absorbed_energy_j";

/// A run with known exact results.
#[derive(Clone, Debug)]
pub struct Case {
    /// Name of the scenario.
    pub scenario: &'static str,
    /// Mesh, speed and stepping.
    pub label: String,
    /// Scene document of the run.
    pub document: Value,
    /// Pointers into the results of the summary, and the exact values there.
    pub exact: Vec<(&'static str, f64)>,
}

/// Time integration, for a wave that crosses an element in `crossing_s`.
#[derive(Clone, Copy, Debug)]
enum Stepping {
    Explicit { courant: f64 },
    Viscous { courant: f64 },
    Implicit { theta: f64 },
}

impl Stepping {
    fn document(self, crossing_s: f64) -> Value {
        match self {
            Self::Explicit { courant } => json!({"kind": "explicit", "safety_factor": courant,
                "linear_bulk_viscosity": 0, "quadratic_bulk_viscosity": 0}),
            Self::Viscous { courant } => json!({"kind": "explicit", "safety_factor": courant}),
            Self::Implicit { theta } => {
                json!({"kind": "implicit", "step_s": 0.9 * crossing_s, "theta": theta})
            }
        }
    }
    fn label(self) -> String {
        match self {
            Self::Explicit { courant } => format!("explicit, Courant number {courant}"),
            Self::Viscous { courant } => format!("explicit, Courant number {courant}, bulk viscosity"),
            Self::Implicit { theta } => format!("implicit, θ = {theta}"),
        }
    }
}

const EXPLICIT: [Stepping; 2] = [Stepping::Explicit { courant: 0.9 }, Stepping::Explicit { courant: 0.5 }];
const VISCOUS: [Stepping; 2] = [Stepping::Viscous { courant: 0.9 }, Stepping::Viscous { courant: 0.5 }];
const IMPLICIT: [Stepping; 2] = [Stepping::Implicit { theta: 0.5 }, Stepping::Implicit { theta: 0.6 }];

/// All cases; the short list omits the finest meshes.
pub fn cases(short: bool) -> Vec<Case> {
    let finest = if short { 20 } else { 80 };
    let bars = || [10, 20, 40, 80].into_iter().filter(move |n| *n <= finest);
    let mut cases = Vec::new();
    for n in bars() {
        for speed in [0.01, 0.003] {
            let all = EXPLICIT.into_iter().chain(IMPLICIT);
            cases.extend(all.map(|stepping| bar_on_wall(n, speed, stepping)));
        }
        for speed in [0.01, 0.03] {
            let all = EXPLICIT.into_iter().chain(VISCOUS).chain(IMPLICIT);
            cases.extend(all.map(|stepping| two_bars(n, speed, stepping)));
        }
        for speed in [1.0, 3.0, 10.0] {
            cases.extend(VISCOUS.map(|stepping| shock(2 * n, speed, stepping)));
        }
    }
    for n in [2, 4, 8].into_iter().filter(|n| short.then_some(4).is_none_or(|most| *n <= most)) {
        for stretch in [1.1, 1.25] {
            cases.extend(EXPLICIT.map(|stepping| breathing_ball(n, stretch, stepping)));
        }
        for angle_deg in [15.0, 20.0, 30.0] {
            cases.extend(EXPLICIT.map(|stepping| incline(n, angle_deg, stepping)));
        }
    }
    cases
}

fn nothing_recorded() -> Value {
    json!({"fields": [], "field_times_s": []})
}

/// A bar along z with its lower end at `z`, of `n` elements; ν = 0.
fn bar(
    (name, role): (&str, &str),
    (z, length, width): (f64, f64, f64),
    n: u32,
    (density, youngs_modulus): (f64, f64),
    velocity: f64,
) -> Value {
    json!({
        "name": name, "role": role, "velocity_m_per_s": [0, 0, velocity],
        "mesh": {"generator": {"kind": "block", "min_m": [0, 0, z], "max_m": [width, width, z + length],
                 "elements": [1, 1, n]}},
        "parts": [{"part": "block", "density_kg_per_m3": density,
                   "material": {"law": "coupled_neo_hookean", "mu_pa": 0.5 * youngs_modulus, "lambda_pa": 0}}]
    })
}

/// Doyen, Ern & Piperno (2011), scaled to strains of 1/3000 and less: pressure √(Eρ) v for 2L/c, then the bar rebounds
/// with its initial speed.
fn bar_on_wall(n: u32, speed: f64, stepping: Stepping) -> Case {
    let (E, rho, L) = (900.0_f64, 1.0, 10.0);
    let c = (E / rho).sqrt();
    Case {
        scenario: "bar on a wall",
        label: format!("{n} elements, {speed} m/s, {}", stepping.label()),
        document: json!({
            "name": "bar on a wall", "end_time_s": 1.5,
            "bodies": [bar(("bar", "projectile"), (0.5 * speed, L, 1.0), n, (rho, E), -speed)],
            "planes": [{"name": "wall", "point_m": [0, 0, 0], "normal": [0, 0, 1]}],
            "integrator": stepping.document(L / f64::from(n) / c),
            "measures": {"force_window_s": 0.05}, "record": nothing_recorded()
        }),
        exact: vec![
            (PEAK_FORCE, rho * c * speed),
            (IMPULSE, 2.0 * rho * L * speed),
            (DURATION, 2.0 * L / c),
            (PATCH, 1e6),
        ],
    }
}

/// Carpenter, Taylor & Katona (1991) in rubber: two equal bars exchange their velocities.
fn two_bars(n: u32, speed: f64, stepping: Stepping) -> Case {
    let (E, rho, L, width) = (1e6_f64, 1000.0, 0.1, 0.01);
    let c = (E / rho).sqrt();
    let (area, mass) = (width * width, rho * L * width * width);
    Case {
        scenario: "two bars",
        label: format!("{n} elements each, {speed} m/s, {}", stepping.label()),
        document: json!({
            "name": "two bars", "end_time_s": 2.5 * L / c,
            "bodies": [
                bar(("striker", "projectile"), (-L, L, width), n, (rho, E), speed),
                bar(("target", "tissue"), (0.0, L, width), n, (rho, E), 0.0)
            ],
            "contact": {"pairs": [{"between": ["striker", "target"], "friction": 0}]},
            "integrator": stepping.document(L / f64::from(n) / c),
            "measures": {"force_window_s": 0.1 * L / c}, "record": nothing_recorded()
        }),
        exact: vec![
            (PEAK_FORCE, 0.5 * rho * c * speed * area),
            (IMPULSE, mass * speed),
            (DURATION, 2.0 * L / c),
            (PATCH, 1e6 * area),
            (ABSORBED, 0.5 * mass * speed * speed),
        ],
    }
}

/// Stretch behind the shock in coupled neo-Hookean rubber, μ = λ, that stops `speed`: P(Λ)(1 − Λ) + ρ v² = 0 (jump
/// conditions ρ U v = −P, v = U (1 − Λ)), by bisection.
fn shock_stretch(mu: f64, rho: f64, speed: f64) -> f64 {
    let excess = |stretch: f64| {
        let P = mu * (stretch - 1.0 / stretch) + mu * stretch.ln() / stretch;
        -P * (1.0 - stretch) - rho * speed * speed
    };
    let (mut low, mut high) = (1e-3, 1.0);
    for _ in 0..100 {
        let middle = 0.5 * (low + high);
        if excess(middle) > 0.0 { low = middle } else { high = middle }
    }
    0.5 * (low + high)
}

/// A bar in uniaxial strain hitting a wall, while the shock travels through it.
fn shock(n: u32, speed: f64, stepping: Stepping) -> Case {
    let (mu, rho, side) = (1e5, 1000.0, 0.02);
    let front_speed = speed / (1.0 - shock_stretch(mu, rho, speed));
    let (end_s, force) = (0.8 / front_speed, rho * front_speed * speed * side * side);
    Case {
        scenario: "shock",
        label: format!("{n} elements, {speed} m/s, {}", stepping.label()),
        document: json!({
            "name": "shock", "end_time_s": end_s,
            "bodies": [{
                "name": "bar", "role": "projectile", "velocity_m_per_s": [-speed, 0, 0],
                "mesh": {"generator": {"kind": "block", "min_m": [0, 0, 0], "max_m": [1, side, side], "elements": [n, 1, 1]}},
                "fixed": [{"set": "*", "axes": ["y", "z"]}],
                "parts": [{"part": "block", "density_kg_per_m3": rho,
                           "material": {"law": "coupled_neo_hookean", "mu_pa": mu, "lambda_pa": mu}}]
            }],
            "planes": [{"name": "wall", "point_m": [0, 0, 0], "normal": [1, 0, 0]}],
            "integrator": stepping.document(1.0 / f64::from(n) / front_speed),
            "measures": {"force_window_s": 0.1 * end_s}, "record": nothing_recorded()
        }),
        exact: vec![
            (PEAK_FORCE, force),
            (IMPULSE, force * end_s),
            (DURATION, end_s),
            (PATCH, 1e6 * side * side),
        ],
    }
}

/// An inflated ball that is released: its energy is conserved, so it absorbs nothing.
fn breathing_ball(n: u32, stretch: f64, stepping: Stepping) -> Case {
    Case {
        scenario: "breathing ball",
        label: format!("{n} elements around a quarter, stretch {stretch}, {}", stepping.label()),
        document: json!({
            "name": "breathing ball", "end_time_s": 4.8e-4,
            "bodies": [{
                "name": "ball", "role": "tissue",
                "mesh": {"generator": {"kind": "hollow_ball", "outer_radius_m": 0.015, "inner_radius_m": 0.01,
                         "elements_around": n, "elements_through": n.div_ceil(2)}},
                "parts": [{"part": "ball", "density_kg_per_m3": 1000, "material":
                    {"law": "mooney_rivlin", "c10_pa": 0.55e6, "c01_pa": 0.138e6, "bulk_modulus_pa": 1e9}}],
                "initial_deformation": {"kind": "spherical_inflation", "center_m": [0, 0, 0], "inner_radius_m": 0.01,
                                        "inner_stretch": stretch}
            }],
            "integrator": stepping.document(1e-6), "record": nothing_recorded()
        }),
        exact: vec![(ABSORBED, 0.0)],
    }
}

/// A block on an incline: it sticks, and the plane carries its weight; or it slides, and the plane exerts N and μN.
fn incline(n: u32, angle_deg: f64, stepping: Stepping) -> Case {
    let (g, friction, side, height, end_s) = (9.81, 0.3, 0.1, 0.025, 0.3);
    let (sin, cos) = angle_deg.to_radians().sin_cos();
    let weight = 1000.0 * side * side * height * g;
    let normal = weight * cos;
    // Stick: the plane carries the weight. Slip: normal force and friction act over the sliding distance.
    let exact = if sin <= friction * cos {
        vec![(IMPULSE, weight * end_s)]
    } else {
        let way = 0.5 * g * (sin - friction * cos) * end_s * end_s;
        vec![
            (IMPULSE, normal * (1.0 + friction * friction).sqrt() * end_s),
            (FRICTION, friction * normal * way),
        ]
    };
    Case {
        scenario: "block on an incline",
        label: format!("{n}×{n}×{} elements, {angle_deg}°, {}", n.div_ceil(2), stepping.label()),
        document: json!({
            "name": "incline", "end_time_s": end_s,
            "bodies": [{
                "name": "block", "role": "projectile",
                "mesh": {"generator": {"kind": "block", "min_m": [-0.5 * side, -0.5 * side, 0],
                         "max_m": [0.5 * side, 0.5 * side, height], "elements": [n, n, n.div_ceil(2)]}},
                "parts": [{"part": "block", "density_kg_per_m3": 1000,
                           "material": {"law": "neo_hookean", "c10_pa": 2e5, "bulk_modulus_pa": 1e6}}]
            }],
            "planes": [{"name": "incline", "point_m": [0, 0, 0], "normal": [0, 0, 1]}],
            "contact": {"pairs": "all", "friction": friction},
            "gravity_m_per_s2": [g * sin, 0, -g * cos],
            "dynamic_relaxation": {"duration_s": 0.1, "damping_per_s": 2000},
            "integrator": stepping.document(1e-4),
            "measures": {"force_window_s": 0.02}, "record": nothing_recorded()
        }),
        exact,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_shock_is_that_of_the_jump_conditions() {
        let stretch = shock_stretch(1e5, 1000.0, 10.0);
        assert!((stretch - 0.559_192_662).abs() < 1e-9, "{stretch}");
        assert!((10.0 / (1.0 - stretch) - 22.685_647_8).abs() < 1e-6);
    }
}
