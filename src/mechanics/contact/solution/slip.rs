//! Stick or slip of one closing contact, by its Schur complement and a scalar equation.
//!
//! With `u_n = 0` the normal reaction is `r_n = −(q_n + W_nt r_t)/W_nn`, and the drag law `u_t = −λ r_t`, λ ≥ 0,
//! gives `(S + λ I) r_t = b` with `S = W_tt − W_tn W_nt/W_nn`, `b = −q_t + W_tn q_n/W_nn`. λ = 0 is stick; slip is
//! `‖r_t(λ)‖ = μ r_n(λ)`.

use super::local::{Local, LocalOperator, length, solve_frictionless};

/// Fraction of the trace of W below which the normal compliance is zero: nothing on either side can move along n.
pub const IMMOVABLE: f64 = 1e-12;
/// Eigenvalue of S relative to its operator (of order one) below which it is zero.
const SINGULAR: f64 = 1e-13;
/// Newton–bisection needs far fewer; the interval is then at rounding in any case.
const MAX_ITERATIONS: usize = 200;

/// The operator of one contact, reduced to the eigenvectors of S: common to all solutions with it.
#[derive(Clone, Copy, Debug)]
pub(super) struct ContactOperator {
    /// `W_nn` as given, unscaled.
    alone: f64,
    /// `W_nn`, 0 where nothing can move along n.
    w_nn: f64,
    /// `W_nt` in the local frame.
    w_nt: [f64; 2],
    /// Eigenvalues of S, the smaller first, 0 where a tangential direction is immovable.
    s: [f64; 2],
    /// Eigenvectors of S, as unit vectors in the (t1, t2) plane.
    axes: [[f64; 2]; 2],
    /// `W_nt` along the eigenvectors.
    c: [f64; 2],
    /// `tr W / 3`; all other values are of W divided by it, of order one.
    scale: f64,
}

/// Exact solution `r` of one contact: `u = W r + q`, `K_μ ∋ r ⊥ u + μ ‖u_t‖ n ∈ K_μ*`, for 0 ≤ μ ≤ ∞.
///
/// `W` is symmetric positive semi-definite. Tests open (`q_n ≥ 0`), stick (`u = 0`) and slip in this order; slip is
/// solved by a safeguarded Newton iteration on one scalar, which finds the root of strongest drag where there are
/// several (μ large relative to the coupling of W; Bonnefon & Daviet 2011).
///
/// Where nothing can move along n (`W_nn` zero) the result is 0. In a tangential direction in which nothing can move
/// the reaction is the limit of vanishing compliance: on the cone if that direction slides, zero for μ = ∞.
pub fn solve_contact(W: &LocalOperator, q: Local, mu: f64) -> Local {
    ContactOperator::new(W).solve(q, mu)
}

/// A closing contact (`q_n < 0`, `W_nn > 0`, values of order one).
struct Closing<'a> {
    operator: &'a ContactOperator,
    /// `b` along the eigenvectors.
    b: [f64; 2],
    /// `q_n`, negative: the contact closes.
    q_n: f64,
    /// `1/μ`; 0 for μ = ∞.
    inverse_mu: f64,
}

fn dot(a: [f64; 2], b: [f64; 2]) -> f64 {
    a[0] * b[0] + a[1] * b[1]
}

impl ContactOperator {
    /// Reduces W, symmetric positive semi-definite.
    pub fn new(W: &LocalOperator) -> Self {
        let alone = W[0][0];
        let scale = (W[0][0] + W[1][1] + W[2][2]) / 3.0;
        let W = W.map(|row| row.map(|x| x / scale));
        let (w_nn, w_nt) = (W[0][0], [W[0][1], W[0][2]]);
        // The scaled trace is 3; a NaN moves nothing.
        let is_movable = w_nn > 3.0 * IMMOVABLE;
        if !is_movable {
            return Self {
                alone: 0.0,
                w_nn: 0.0,
                w_nt,
                s: [0.0; 2],
                axes: [[0.0; 2]; 2],
                c: [0.0; 2],
                scale,
            };
        }
        let s11 = W[1][1] - w_nt[0] * w_nt[0] / w_nn;
        let s22 = W[2][2] - w_nt[1] * w_nt[1] / w_nn;
        let s12 = W[1][2] - w_nt[0] * w_nt[1] / w_nn;
        let (s, axes) = eigen_2x2(s11, s12, s22);
        let s = s.map(|x| if x <= SINGULAR { 0.0 } else { x });
        Self { alone, w_nn, w_nt, s, axes, c: axes.map(|axis| dot(axis, w_nt)), scale }
    }

    /// Exact solution for the free velocity `q`, as [`solve_contact`].
    pub fn solve(&self, q: Local, mu: f64) -> Local {
        if q[0] >= 0.0 || self.w_nn == 0.0 {
            return [0.0; 3];
        }
        if mu == 0.0 {
            return [solve_frictionless(self.alone, q[0]), 0.0, 0.0];
        }
        let size = q[0].abs().max(q[1].abs()).max(q[2].abs());
        self.solve_closing(q.map(|x| x / size), mu).map(|x| x * size / self.scale)
    }

    /// The reaction of a closing contact: stick if that lies in the cone, else slip.
    ///
    /// With a singular S and a motion that no reaction can change, friction may jam: no finite reaction satisfies the
    /// law (Painlevé). The reaction is then the frictionless one, and the residual of the law shows it.
    fn solve_closing(&self, q: Local, mu: f64) -> Local {
        let closing = Closing::new(self, q, mu);
        if let Some(r) = closing.stick() {
            return r;
        }
        match closing.strongest_drag() {
            Some(y) => closing.reaction(y),
            None => [-q[0] / self.w_nn, 0.0, 0.0],
        }
    }

    /// A reaction in the local frame from its components along the eigenvectors.
    fn in_frame(&self, n: f64, t: [f64; 2]) -> Local {
        let along = |i: usize| self.axes[0][i] * t[0] + self.axes[1][i] * t[1];
        [n, along(0), along(1)]
    }
}

impl<'a> Closing<'a> {
    fn new(operator: &'a ContactOperator, q: Local, mu: f64) -> Self {
        let ContactOperator { w_nn, w_nt, s, axes, .. } = operator;
        let b = [-q[1] + w_nt[0] * q[0] / w_nn, -q[2] + w_nt[1] * q[0] / w_nn];
        let mut b = axes.map(|axis| dot(axis, b));
        for (b, s) in b.iter_mut().zip(s) {
            // No reaction, however large, changes the velocity along such an axis: for μ = ∞ it is omitted.
            if *s == 0.0 && (mu.is_infinite() || b.abs() <= SINGULAR) {
                *b = 0.0;
            }
        }
        Self { operator, b, q_n: q[0], inverse_mu: 1.0 / mu }
    }

    /// `r_t` along the eigenvectors at `y = 1/(s_min + λ)`.
    fn tangential(&self, y: f64) -> [f64; 2] {
        [self.b[0] * y, self.b[1] * y / (1.0 + (self.operator.s[1] - self.operator.s[0]) * y)]
    }

    /// `W_nn r_n` for a tangential reaction.
    fn normal(&self, t: [f64; 2]) -> f64 {
        -self.q_n - self.operator.c[0] * t[0] - self.operator.c[1] * t[1]
    }

    /// `W_nn (‖r_t‖/μ − r_n)` at `y`: negative inside the cone.
    fn excess(&self, y: f64) -> f64 {
        let t = self.tangential(y);
        self.operator.w_nn * self.inverse_mu * length(t[0], t[1]) - self.normal(t)
    }

    /// Derivative of the excess, d excess / dy.
    fn excess_slope(&self, y: f64) -> f64 {
        let t = self.tangential(y);
        let stretch = 1.0 + (self.operator.s[1] - self.operator.s[0]) * y;
        let dt = [self.b[0], self.b[1] / (stretch * stretch)];
        let size = length(t[0], t[1]);
        let growth = if size > 0.0 { (t[0] * dt[0] + t[1] * dt[1]) / size } else { 0.0 };
        self.operator.w_nn * self.inverse_mu * growth
            + self.operator.c[0] * dt[0]
            + self.operator.c[1] * dt[1]
    }

    /// The reaction with `u = 0`, if it exists and lies in the cone.
    fn stick(&self) -> Option<Local> {
        let mut t = [0.0; 2];
        for (t, (s, b)) in t.iter_mut().zip(self.operator.s.into_iter().zip(self.b)) {
            if s > 0.0 {
                *t = b / s;
            } else if b != 0.0 {
                return None;
            }
        }
        let n = self.normal(t) / self.operator.w_nn;
        let inside = n >= 0.0 && self.inverse_mu * length(t[0], t[1]) <= n;
        inside.then(|| self.operator.in_frame(n, t))
    }

    /// The slipping reaction at `y`; exactly on the cone for finite μ.
    fn reaction(&self, y: f64) -> Local {
        let t = self.tangential(y);
        let n = if self.inverse_mu > 0.0 {
            self.inverse_mu * length(t[0], t[1])
        } else {
            (self.normal(t) / self.operator.w_nn).max(0.0)
        };
        self.operator.in_frame(n, t)
    }

    /// The smallest root `y` of the excess, that is the largest λ; `None` if there is no finite one.
    ///
    /// The excess is negative for small `y` and positive at stick. Squared and expanded it is a quartic in `y`, whose
    /// critical points divide the axis so that no root can hide between two samples of equal sign.
    fn strongest_drag(&self) -> Option<f64> {
        // Below this `y` the reaction is in the cone whatever the directions.
        let b = length(self.b[0], self.b[1]);
        let c = length(self.operator.c[0], self.operator.c[1]);
        let unit = -self.q_n / (b * (self.operator.w_nn * self.inverse_mu + c));
        let end = 1.0 / self.operator.s[0];
        if !unit.is_finite() || unit >= end {
            return end.is_finite().then_some(end);
        }
        // A right end at which the excess is positive.
        let mut last = unit;
        while last < end && self.excess(last) <= 0.0 {
            last = (2.0 * last).min(end);
        }
        if last * SINGULAR >= 1.0 && self.operator.s[0] == 0.0 {
            return None;
        }
        if self.has_one_root() {
            return Some(self.root_between(unit, last));
        }
        // In z = y/unit the quartic (n0 + n1 z + n2 z²)² − a² z² ((1 + d z)² b1² + b2²) vanishes at every root.
        let d = (self.operator.s[1] - self.operator.s[0]) * unit;
        let (b1, b2) = (self.b[0] * unit, self.b[1] * unit);
        let (n0, n1, n2) = (
            -self.q_n,
            -self.q_n * d - self.operator.c[0] * b1 - self.operator.c[1] * b2,
            -self.operator.c[0] * b1 * d,
        );
        let a2 = (self.operator.w_nn * self.inverse_mu).powi(2);
        let quartic = [
            n0 * n0,
            2.0 * n0 * n1,
            n1 * n1 + 2.0 * n0 * n2 - a2 * (b1 * b1 + b2 * b2),
            2.0 * (n1 * n2 - a2 * b1 * b1 * d),
            n2 * n2 - a2 * b1 * b1 * d * d,
        ];
        // The first sign change between critical points.
        let mut lo = unit;
        let (points, count) = critical_points(&quartic, 1.0, last / unit);
        for &z in &points[..count] {
            let y = (z * unit).clamp(lo, last);
            if self.excess(y) > 0.0 {
                return Some(self.root_between(lo, y));
            }
            lo = y;
        }
        Some(self.root_between(lo, last))
    }

    /// Whether the excess grows monotonically up to stick.
    ///
    /// `‖r_t‖` grows by `r_t·r_t'/‖r_t‖`, and `r_t' = K r_t / y` with K between s_min/s_max and 1, hence by no less
    /// than `2 √κ/(1 + κ)` of `‖r_t'‖`, κ = s_max/s_min (Kantorovich); the coupling reduces this by at most `‖W_nt‖
    /// ‖r_t'‖`.
    fn has_one_root(&self) -> bool {
        let [least, most] = self.operator.s;
        let slowest = 2.0 * (least * most).sqrt() / (least + most);
        self.operator.w_nn * self.inverse_mu * slowest > length(self.operator.c[0], self.operator.c[1])
    }

    /// Newton's method with bisection: the excess is not positive at `lo` and positive at `hi` (to rounding).
    fn root_between(&self, mut lo: f64, mut hi: f64) -> f64 {
        let mut y = 0.5 * (lo + hi);
        for _ in 0..MAX_ITERATIONS {
            let g = self.excess(y);
            if g > 0.0 {
                hi = y;
            } else {
                lo = y;
            }
            let newton = y - g / self.excess_slope(y);
            let next = if newton > lo && newton < hi { newton } else { 0.5 * (lo + hi) };
            if g == 0.0 || (next - y).abs() <= f64::EPSILON * y || next <= lo || next >= hi {
                return if g == 0.0 { y } else { next };
            }
            y = next;
        }
        y
    }
}

/// Eigenvalues (ascending) and eigenvectors of `[[a, b], [b, c]]`, by one Jacobi rotation.
fn eigen_2x2(a: f64, b: f64, c: f64) -> ([f64; 2], [[f64; 2]; 2]) {
    if b == 0.0 {
        return if a <= c { ([a, c], [[1.0, 0.0], [0.0, 1.0]]) } else { ([c, a], [[0.0, 1.0], [1.0, 0.0]]) };
    }
    let tau = (c - a) / (2.0 * b);
    let t = tau.signum() / (tau.abs() + 1f64.hypot(tau));
    let cos = 1.0 / 1f64.hypot(t);
    let sin = t * cos;
    let (first, second) = (a - t * b, c + t * b);
    let (x, y) = ([cos, -sin], [sin, cos]);
    if first <= second { ([first, second], [x, y]) } else { ([second, first], [y, x]) }
}

/// Critical points of a quartic (coefficients by ascending power) inside `(lo, hi)`, ascending, and their number.
fn critical_points(p: &[f64; 5], lo: f64, hi: f64) -> ([f64; 3], usize) {
    let cubic = [p[1], 2.0 * p[2], 3.0 * p[3], 4.0 * p[4]];
    let value = |x: f64| ((cubic[3] * x + cubic[2]) * x + cubic[1]) * x + cubic[0];
    // The cubic is monotone between the roots of its own derivative.
    let (bends, bend_count) = quadratic_roots(3.0 * cubic[3], 2.0 * cubic[2], cubic[1]);
    let mut points = [0.0; 3];
    let mut count = 0;
    let mut left = lo;
    let inside = bends[..bend_count].iter().copied().filter(|&x| x > lo && x < hi);
    for right in inside.chain([hi]) {
        if (value(left) > 0.0) != (value(right) > 0.0) {
            points[count] = bisect(value, left, right);
            count += 1;
        }
        left = right;
    }
    (points, count)
}

/// Real roots of `a x² + b x + c`, ascending, and their number.
fn quadratic_roots(a: f64, b: f64, c: f64) -> ([f64; 2], usize) {
    let discriminant = b * b - 4.0 * a * c;
    if discriminant < 0.0 {
        return ([0.0; 2], 0);
    }
    let m = -0.5 * (b + b.signum() * discriminant.sqrt());
    let (x, y) = (m / a, c / m);
    match (x.is_finite(), y.is_finite()) {
        (true, true) => ([x.min(y), x.max(y)], 2),
        (true, false) => ([x, 0.0], 1),
        (false, true) => ([y, 0.0], 1),
        (false, false) => ([0.0; 2], 0),
    }
}

/// The point between `lo` and `hi`, of opposite signs, where `f` changes sign; a bracket for the root needs only some
/// forty bisections.
fn bisect(f: impl Fn(f64) -> f64, mut lo: f64, mut hi: f64) -> f64 {
    let positive = f(lo) > 0.0;
    for _ in 0..60 {
        let mid = 0.5 * (lo + hi);
        if (f(mid) > 0.0) == positive {
            lo = mid;
        } else {
            hi = mid;
        }
    }
    0.5 * (lo + hi)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_excess_grows_where_it_is_said_to_have_one_root() {
        let mut counts = [0, 0];
        for i in 0..4000 {
            // Operators of all kinds: S = diag(s, 1), coupled to the normal at all angles.
            let number = |k: u32| f64::from((i * 7919 + k * 104_729) % 1009) / 1009.0;
            let (anisotropy, angle, coupling) = (number(1), std::f64::consts::TAU * number(2), number(3));
            let c = [0.9 * coupling * angle.cos(), 0.9 * coupling * angle.sin()];
            let (low, high) = (0.01 + 0.99 * anisotropy, 1.0);
            let w = [
                [1.0, c[0], c[1]],
                [c[0], low + c[0] * c[0], c[0] * c[1]],
                [c[1], c[0] * c[1], high + c[1] * c[1]],
            ];
            let q = [-0.1 - number(4), 4.0 * number(5) - 2.0, 4.0 * number(6) - 2.0];
            let operator = ContactOperator::new(&w);
            let closing = Closing::new(&operator, q, 0.05 + 2.0 * number(7));
            let end = 1.0 / operator.s[0];
            let values: Vec<f64> = (1..=200).map(|k| closing.excess(end * f64::from(k) / 200.0)).collect();
            let grows = values.windows(2).all(|v| v[1] >= v[0] - 1e-12 * v[0].abs());
            assert!(grows || !closing.has_one_root(), "{w:?} {q:?}");
            counts[usize::from(closing.has_one_root())] += 1;
        }
        assert!(counts.iter().all(|&n| n > 500), "{counts:?}");
    }
}
