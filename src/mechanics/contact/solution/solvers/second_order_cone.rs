//! The Jordan algebra of the second-order cone `Q = { x_0 ≥ ‖x_t‖ }` in three dimensions, and its Nesterov–Todd
//! scaling.

use crate::contact::solution::delassus::Block;
use crate::contact::solution::local::Local;

/// Determinant `x_0² − ‖x_t‖²`, without cancellation near the border of the cone.
pub(super) fn determinant(x: Local) -> f64 {
    let t = x[1].hypot(x[2]);
    (x[0] - t) * (x[0] + t)
}

/// Jordan product `x ∘ y`.
pub(super) fn product(x: Local, y: Local) -> Local {
    [x[0] * y[0] + x[1] * y[1] + x[2] * y[2], x[0] * y[1] + y[0] * x[1], x[0] * y[2] + y[0] * x[2]]
}

/// The `z` with `x ∘ z = b`, for x inside the cone.
pub(super) fn quotient(x: Local, b: Local) -> Local {
    let t = x[1] * b[1] + x[2] * b[2];
    let z0 = (x[0] * b[0] - t) / determinant(x);
    [z0, (b[1] - z0 * x[1]) / x[0], (b[2] - z0 * x[2]) / x[0]]
}

/// The largest fraction of the step `d` from `x` that stays in the cone.
pub(super) fn longest_step(x: Local, d: Local) -> f64 {
    // (x + s d)_0² = ‖(x + s d)_t‖², the least positive root.
    let a = determinant_like(d, d);
    let b = determinant_like(x, d);
    let c = determinant(x);
    let mut s = f64::INFINITY;
    if d[0] < 0.0 {
        s = -x[0] / d[0];
    }
    let discriminant = b * b - a * c;
    if discriminant >= 0.0 {
        let root = discriminant.sqrt();
        let m = -(b + b.signum() * root);
        for candidate in [m / a, c / m] {
            if candidate > 0.0 && candidate < s {
                s = candidate;
            }
        }
    }
    s
}

fn determinant_like(x: Local, y: Local) -> f64 {
    x[0] * y[0] - x[1] * y[1] - x[2] * y[2]
}

/// Scaling of x and y inside the cone: the symmetric `V` with `V x = V⁻¹ y = λ`.
pub(super) struct Scaling {
    /// The scaling matrix `V`.
    pub root: Block,
    /// `H = V²`, with `y = H x`.
    pub square: Block,
    /// The scaled point `λ`.
    pub lambda: Local,
}

impl Scaling {
    /// Scaling of `x`, `y` inside the cone.
    pub fn new(x: Local, y: Local) -> Self {
        // Both normalised to determinant 1, and the scaling point w between them.
        let (root_x, root_y) = (determinant(x).sqrt(), determinant(y).sqrt());
        let (x1, y1) = (x.map(|a| a / root_x), y.map(|a| a / root_y));
        let cos = x1[0] * y1[0] + x1[1] * y1[1] + x1[2] * y1[2];
        let gamma = (0.5 * (1.0 + cos)).sqrt();
        let w = [
            (y1[0] + x1[0]) / (2.0 * gamma),
            (y1[1] - x1[1]) / (2.0 * gamma),
            (y1[2] - x1[2]) / (2.0 * gamma),
        ];
        let beta = (root_y / root_x).sqrt();
        let v = {
            let scale = 1.0 / (2.0 * (w[0] + 1.0)).sqrt();
            [(w[0] + 1.0) * scale, w[1] * scale, w[2] * scale]
        };
        // V and H as scaled reflections.
        let reflect = |v: Local, beta: f64| -> Block {
            std::array::from_fn(|i| {
                std::array::from_fn(|j| {
                    let sign = if i != j {
                        0.0
                    } else if i == 0 {
                        -1.0
                    } else {
                        1.0
                    };
                    beta * (2.0 * v[i] * v[j] + sign)
                })
            })
        };
        let root = reflect(v, beta);
        let square = reflect(w, beta * beta);
        let lambda = crate::contact::solution::delassus::times(&root, x);
        Self { root, square, lambda }
    }
}
