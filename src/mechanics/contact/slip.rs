//! Stick or slip of one closing contact, by its Schur complement and a scalar equation.
//!
//! With `u_n = 0` the normal reaction is `r_n = −(q_n + W_nt r_t)/W_nn`, and drag `u_t = −λ r_t`, λ ≥ 0, leaves
//! `(S + λ I) r_t = b` with `S = W_tt − W_tn W_nt/W_nn`, `b = −q_t + W_tn q_n/W_nn`. λ = 0 is stick; slip is
//! `‖r_t(λ)‖ = μ r_n(λ)`.

use super::local::{Local, LocalOperator};

/// An eigenvalue of S below this share of its operator (of order one) is zero.
const SINGULAR: f64 = 1e-13;
/// Newton–bisection needs far fewer; the interval is at rounding by then in any case.
const MAX_ITERATIONS: usize = 200;

/// A closing contact (`q_n < 0`, `W_nn > 0`, numbers of order one), reduced to its tangential eigenvectors.
struct Reduced {
    /// Eigenvalues of S, the smaller first.
    s: [f64; 2],
    /// Eigenvectors of S, as unit vectors in the (t1, t2) plane.
    axes: [[f64; 2]; 2],
    /// `b` along the eigenvectors.
    b: [f64; 2],
    /// `W_nt` along the eigenvectors.
    c: [f64; 2],
    /// `W_nn`.
    w_nn: f64,
    /// `q_n`, negative.
    q_n: f64,
    /// `1/μ`, 0 for μ = ∞.
    inverse_mu: f64,
}

/// The reaction of a closing contact: stick if that lies in the cone, else slip.
///
/// With a singular S and a motion that no reaction can change, friction may jam: no finite reaction satisfies the law
/// (Painlevé). Then the reaction is the frictionless one, and the residual of the law shows it.
pub(super) fn solve_slip(W: &LocalOperator, q: Local, mu: f64) -> Local {
    let reduced = Reduced::new(W, q, mu);
    if let Some(r) = reduced.stick() {
        return r;
    }
    match reduced.strongest_drag() {
        Some(y) => reduced.reaction(y),
        None => [-q[0] / W[0][0], 0.0, 0.0],
    }
}

impl Reduced {
    fn new(W: &LocalOperator, q: Local, mu: f64) -> Self {
        let w_nn = W[0][0];
        let w_nt = [W[0][1], W[0][2]];
        let b = [-q[1] + w_nt[0] * q[0] / w_nn, -q[2] + w_nt[1] * q[0] / w_nn];
        let s11 = W[1][1] - w_nt[0] * w_nt[0] / w_nn;
        let s22 = W[2][2] - w_nt[1] * w_nt[1] / w_nn;
        let s12 = W[1][2] - w_nt[0] * w_nt[1] / w_nn;
        let (s, axes) = eigen_2x2(s11, s12, s22);
        let along = |a: [f64; 2], x: [f64; 2]| a[0] * x[0] + a[1] * x[1];
        let mut b = [along(axes[0], b), along(axes[1], b)];
        let c = [along(axes[0], w_nt), along(axes[1], w_nt)];
        let s = s.map(|x| if x <= SINGULAR { 0.0 } else { x });
        for (b, s) in b.iter_mut().zip(s) {
            // No reaction, however large, changes the velocity along such an axis: with μ = ∞ it is left out.
            if s == 0.0 && (mu.is_infinite() || b.abs() <= SINGULAR) {
                *b = 0.0;
            }
        }
        Self { s, axes, b, c, w_nn, q_n: q[0], inverse_mu: 1.0 / mu }
    }

    /// `r_t` along the eigenvectors at `y = 1/(s_min + λ)`.
    fn tangential(&self, y: f64) -> [f64; 2] {
        [self.b[0] * y, self.b[1] * y / (1.0 + (self.s[1] - self.s[0]) * y)]
    }

    /// `W_nn r_n` for a tangential reaction.
    fn normal(&self, t: [f64; 2]) -> f64 {
        -self.q_n - self.c[0] * t[0] - self.c[1] * t[1]
    }

    /// `W_nn (‖r_t‖/μ − r_n)` at `y`: negative inside the cone.
    fn excess(&self, y: f64) -> f64 {
        let t = self.tangential(y);
        self.w_nn * self.inverse_mu * t[0].hypot(t[1]) - self.normal(t)
    }

    /// d excess / dy.
    fn excess_slope(&self, y: f64) -> f64 {
        let t = self.tangential(y);
        let stretch = 1.0 + (self.s[1] - self.s[0]) * y;
        let dt = [self.b[0], self.b[1] / (stretch * stretch)];
        let length = t[0].hypot(t[1]);
        let growth = if length > 0.0 { (t[0] * dt[0] + t[1] * dt[1]) / length } else { 0.0 };
        self.w_nn * self.inverse_mu * growth + self.c[0] * dt[0] + self.c[1] * dt[1]
    }

    /// The reaction with `u = 0`, if it exists and lies in the cone.
    fn stick(&self) -> Option<Local> {
        let mut t = [0.0; 2];
        for (t, (s, b)) in t.iter_mut().zip(self.s.into_iter().zip(self.b)) {
            if s > 0.0 {
                *t = b / s;
            } else if b != 0.0 {
                return None;
            }
        }
        let n = self.normal(t) / self.w_nn;
        let inside = n >= 0.0 && self.inverse_mu * t[0].hypot(t[1]) <= n;
        inside.then(|| self.to_frame(n, t))
    }

    /// The slipping reaction at `y`; exactly on the cone for finite μ.
    fn reaction(&self, y: f64) -> Local {
        let t = self.tangential(y);
        let n = if self.inverse_mu > 0.0 {
            self.inverse_mu * t[0].hypot(t[1])
        } else {
            (self.normal(t) / self.w_nn).max(0.0)
        };
        self.to_frame(n, t)
    }

    fn to_frame(&self, n: f64, t: [f64; 2]) -> Local {
        let along = |i: usize| self.axes[0][i] * t[0] + self.axes[1][i] * t[1];
        [n, along(0), along(1)]
    }

    /// The smallest root `y` of the excess, that is the largest λ; `None` if there is no finite one.
    ///
    /// The excess is negative for small `y` and positive at stick. Squared and multiplied out it is a quartic in `y`,
    /// whose critical points part the axis so that no root can hide between two samples of equal sign.
    fn strongest_drag(&self) -> Option<f64> {
        // Below this `y` the cone holds whatever the directions.
        let b = self.b[0].hypot(self.b[1]);
        let c = self.c[0].hypot(self.c[1]);
        let unit = -self.q_n / (b * (self.w_nn * self.inverse_mu + c));
        let end = 1.0 / self.s[0];
        if !unit.is_finite() || unit >= end {
            return end.is_finite().then_some(end);
        }
        // A right end at which the excess is positive.
        let mut last = unit;
        while last < end && self.excess(last) <= 0.0 {
            last = (2.0 * last).min(end);
        }
        if last * SINGULAR >= 1.0 && self.s[0] == 0.0 {
            return None;
        }
        // In z = y/unit the quartic (n0 + n1 z + n2 z²)² − a² z² ((1 + d z)² b1² + b2²) vanishes at every root.
        let d = (self.s[1] - self.s[0]) * unit;
        let (b1, b2) = (self.b[0] * unit, self.b[1] * unit);
        let (n0, n1, n2) = (-self.q_n, -self.q_n * d - self.c[0] * b1 - self.c[1] * b2, -self.c[0] * b1 * d);
        let a2 = (self.w_nn * self.inverse_mu).powi(2);
        let quartic = [
            n0 * n0,
            2.0 * n0 * n1,
            n1 * n1 + 2.0 * n0 * n2 - a2 * (b1 * b1 + b2 * b2),
            2.0 * (n1 * n2 - a2 * b1 * b1 * d),
            n2 * n2 - a2 * b1 * b1 * d * d,
        ];
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

    /// Newton with bisection: the excess is not positive at `lo` and positive at `hi` (to rounding).
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

/// The critical points of a quartic (coefficients by ascending power) inside `(lo, hi)`, ascending, and how many.
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

/// Real roots of `a x² + b x + c`, ascending, and how many.
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

/// The place between `lo` and `hi`, of opposite signs, where `f` changes sign; a bracket for the root needs no more
/// than some forty halvings.
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
