//! A manufactured solution at finite strain: a displacement is chosen, the body force that it asks for is applied, and the error of
//! what comes out falls with the square of the element size in L2.
//!
//! Unit cube, held on all sides, u = A sin πx sin πy sin πz (strains to a third), coupled neo-Hookean law. A scene has no such
//! force; it is given to the plan.

use crate::rig::{assert_order, assert_within, order, plan, run};
use contuse::mechanics::tensor::{Mat3, Vec3};
use contuse::plan::{NodalForces, Plan, Ramp};
use serde_json::json;
use std::f64::consts::PI;

const MU: f64 = 1e5;
const LAMBDA: f64 = 1.5e5;
const A: [f64; 3] = [0.1, 0.06, -0.08];
/// Points and weights of the Gauss rule on [0, 1], exact to degree five.
const GAUSS: [(f64, f64); 3] =
    [(0.112_701_665_379_258_3, 5.0 / 18.0), (0.5, 8.0 / 18.0), (0.887_298_334_620_741_7, 5.0 / 18.0)];

fn displacement(X: &Vec3) -> Vec3 {
    Vec3::from(A) * ((PI * X.x).sin() * (PI * X.y).sin() * (PI * X.z).sin())
}

/// P = μ (F − F⁻ᵀ) + λ ln J F⁻ᵀ of that displacement.
fn stress(X: &Vec3) -> Mat3 {
    let ((s0, c0), (s1, c1), (s2, c2)) = ((PI * X.x).sin_cos(), (PI * X.y).sin_cos(), (PI * X.z).sin_cos());
    let slope = Vec3::new(c0 * s1 * s2, s0 * c1 * s2, s0 * s1 * c2) * PI;
    let F = Mat3::identity() + Vec3::from(A) * slope.transpose();
    let inverse = F.try_inverse().unwrap().transpose();
    F * MU + inverse * (LAMBDA * F.determinant().ln() - MU)
}

/// −Div P, by central differences of fourth order.
fn body_force(X: &Vec3) -> Vec3 {
    let h = 1e-3;
    let mut divergence = Vec3::zeros();
    for axis in 0..3 {
        let at = |steps: f64| stress(&(X + Vec3::ith(axis, steps * h))).column(axis).into_owned();
        divergence += ((at(1.0) - at(-1.0)) * 8.0 - (at(2.0) - at(-2.0))) / (12.0 * h);
    }
    -divergence
}

/// Visits the Gauss points of all elements of the regular mesh: X, weight [m³], and shape functions of the corners.
fn visit(plan: &Plan, mut at: impl FnMut(&[u32; 8], &Vec3, f64, &[f64; 8])) {
    for hex in plan.bodies[0].cells.hexes().unwrap() {
        let (low, high) = (plan.X[hex[0] as usize], plan.X[hex[6] as usize]);
        let size = high - low;
        for (x, wx) in GAUSS {
            for (y, wy) in GAUSS {
                for (z, wz) in GAUSS {
                    let X = low + size.component_mul(&Vec3::new(x, y, z));
                    let N = hex.map(|node| {
                        let corner = (plan.X[node as usize] - low).component_div(&size);
                        let along = |c: f64, s: f64| if c > 0.5 { s } else { 1.0 - s };
                        along(corner.x, x) * along(corner.y, y) * along(corner.z, z)
                    });
                    at(hex, &X, wx * wy * wz * size.x * size.y * size.z, &N);
                }
            }
        }
    }
}

/// √∫ |u_h − u|² dV on n³ elements.
fn error(n: u32) -> f64 {
    let mut plan = plan(&json!({
        "name": "manufactured solution",
        "end_time_s": 1.0,
        "bodies": [{
            "name": "cube",
            "mesh": {"generator": {"kind": "block", "min_m": [0, 0, 0], "max_m": [1, 1, 1], "elements": [n, n, n]}},
            "fixed": [{"set": "x_min"}, {"set": "x_max"}, {"set": "y_min"}, {"set": "y_max"}, {"set": "z_min"}, {"set": "z_max"}],
            "parts": [{"part": "block", "density_kg_per_m3": 1000.0, "material": {
                "law": "coupled_neo_hookean", "mu_pa": MU, "lambda_pa": LAMBDA
            }}]
        }],
        "integrator": {"kind": "quasi_static", "step_s": 0.5, "newton_tolerance": 1e-10},
        "record": {"fields": [], "field_times_s": []}
    }));
    let mut forces = vec![Vec3::zeros(); plan.node_count()];
    visit(&plan, |hex, X, weight, N| {
        let force = body_force(X) * weight;
        for (node, N) in hex.iter().zip(N) {
            forces[*node as usize] += force * *N;
        }
    });
    let forces = (0..).zip(forces).collect();
    plan.loads.forces.push(NodalForces { forces, ramp: Ramp::of_points(vec![(0.0, 0.0), (1.0, 1.0)]) });
    let (_, state) = run(&plan, |_| {});
    let mut square = 0.0;
    visit(&plan, |hex, X, weight, N| {
        let found: Vec3 = hex.iter().zip(N).map(|(node, N)| state.u[*node as usize] * *N).sum();
        square += weight * (found - displacement(X)).norm_squared();
    });
    square.sqrt()
}

#[test]
fn the_error_falls_with_the_square_of_the_element_size() {
    let errors = [4, 8, 16].map(error);
    for (pair, meshes) in errors.windows(2).zip(["4 to 8", "8 to 16"]) {
        let what = format!("displacement in L², {meshes} elements along an edge");
        assert_order(pair, 1.9, &what);
        assert_within(order(pair[0], pair[1]), 2.0, 0.1, &format!("order of the {what}"));
    }
}
