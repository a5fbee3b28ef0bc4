//! Semismooth Newton steps on all contacts at once, as in [`super::newton`], with GMRES for their linear systems (Saad &
//! Schultz 1986): only products with W, and far fewer of them than gradient steps take. The blocks of the contacts on the
//! diagonal precondition it.

use super::fixed_point::Iterate;
use super::measure::At;
use super::options::{Ending, Limits};
use crate::contact::solution::delassus::Block;
use crate::contact::solution::generalised_jacobian::{Linearised, linearise_alart_curnier};
use crate::contact::solution::local::Local;
use crate::contact::solution::problem::{is_zero, local};
use crate::tensor::{Mat3, Vec3};

/// Default limit of Newton steps.
pub(super) const MAX_STEPS: usize = 60;
/// Newton steps in a row without a better iterate after which the method stops.
const PATIENCE: usize = 6;
/// Most products with W per Newton step.
const MOST_PRODUCTS: usize = 60;
/// Ratio of errors at or below which a whole step is accepted at once, and the next system is solved as precisely as the
/// tolerance asks.
const ENOUGH: f64 = 0.9;
const FAST: f64 = 0.1;
/// Ratio to the best error below which an iterate is better.
const BETTER: f64 = 0.999;
/// Residuals of the linear systems relative to their right sides: before the iteration converges fast, and the least.
const COARSE: f64 = 1e-2;
const FINEST: f64 = 1e-9;
/// Compliance that a block of the preconditioner has along each axis, relative to its mean: a node in a plane of symmetry has none along the
/// normal, or one of rounding.
const LEAST_COMPLIANCE: f64 = 1e-6;
/// Part of the tolerance that the linear system may leave.
const PART: f64 = 0.1;

/// Newton steps until the error is within the tolerance, or they make no progress; ends with the best iterate. `own`: the
/// diagonal blocks of W.
pub(super) fn solve<P: Iterate>(scaled: &mut P, own: &[Block], limits: &Limits) -> Ending {
    let mut error = scaled.error();
    let mut best = (error, scaled.at().r.to_vec());
    let (mut steps, mut idle, mut precision) = (0, 0, COARSE);
    while error > limits.tolerance && steps < limits.iterations && idle <= PATIENCE && !limits.interrupted() {
        let (direction, effect) = NewtonSystem::new(&scaled.at(), own).solve(scaled, precision);
        let (r, u) = search(&scaled.at(), &direction, &effect, error);
        scaled.set_known(&r, &u);
        let before = std::mem::replace(&mut error, scaled.error());
        let fine = (PART * limits.tolerance / error).clamp(FINEST, COARSE);
        precision = if error <= FAST * before { fine } else { COARSE };
        (steps, idle) = (steps + 1, idle + 1);
        if error < BETTER * best.0 {
            best = (error, scaled.at().r.to_vec());
            idle = 0;
        }
    }
    // The velocities of the best iterate, without the rounding of the steps.
    scaled.set_reactions(&best.1);
    Ending { iterations: steps, error: scaled.error() }
}

/// Reactions and velocities after the whole step along `direction`, whose `effect` is `W direction`, if that reduces the error enough,
/// otherwise after the whole or the half one, whichever has the lower error.
fn search(at: &At, direction: &[f64], effect: &[f64], error: f64) -> (Vec<f64>, Vec<f64>) {
    let along = |x: &[f64], d: &[f64], length: f64| -> Vec<f64> {
        x.iter().zip(d).map(|(x, d)| x + length * d).collect()
    };
    let reached = |length: f64| {
        let (r, u) = (along(at.r, direction, length), along(at.u, effect, length));
        (At { r: &r, u: &u, ..*at }.error(), (r, u))
    };
    let whole = reached(1.0);
    if whole.0 <= ENOUGH * error {
        return whole.1;
    }
    let half = reached(0.5);
    if whole.0 < half.0 { whole.1 } else { half.1 }
}

/// The linear system `(∂F/∂r + ∂F/∂u W) d = −F` of a Newton step.
struct NewtonSystem {
    at: Vec<Linearised>,
    /// Inverses of its diagonal blocks.
    preconditioner: Vec<Mat3>,
}

impl NewtonSystem {
    fn new(at: &At, own: &[Block]) -> Self {
        let linearise = |c: usize| linearise_alart_curnier(local(at.r, c), local(at.u, c), at.mu[c]);
        let at: Vec<Linearised> = (0..own.len()).map(linearise).collect();
        let matrix = |block: &Block| Mat3::from_fn(|i, j| block[i][j]);
        let inverse = |(at, own): (&Linearised, &Block)| {
            let own = matrix(own) + Mat3::from_diagonal_element(LEAST_COMPLIANCE);
            let block = matrix(&at.by_r) + matrix(&at.by_u) * own;
            block.try_inverse().unwrap_or_else(Mat3::identity)
        };
        let preconditioner = at.iter().zip(own).map(inverse).collect();
        Self { at, preconditioner }
    }

    /// `∂F/∂r x + ∂F/∂u W x`, given `W x`.
    fn apply(&self, x: &[f64], effect: &[f64]) -> Vec<f64> {
        let of_contact = |(c, at): (usize, &Linearised)| -> Local {
            let (x, w) = (local(x, c), local(effect, c));
            [0, 1, 2].map(|i| (0..3).map(|j| at.by_r[i][j] * x[j] + at.by_u[i][j] * w[j]).sum())
        };
        self.at.iter().enumerate().flat_map(of_contact).collect()
    }

    fn precondition(&self, x: &[f64]) -> Vec<f64> {
        let of_contact =
            |(x, inverse): (&[f64], &Mat3)| -> [f64; 3] { (inverse * Vec3::new(x[0], x[1], x[2])).into() };
        x.chunks_exact(3).zip(&self.preconditioner).flat_map(of_contact).collect()
    }

    /// The step d and its effect `W d`, with a residual below `precision` relative to the right side, or after
    /// [`MOST_PRODUCTS`].
    fn solve<P: Iterate>(&self, scaled: &mut P, precision: f64) -> (Vec<f64>, Vec<f64>) {
        // The steps of open contacts are known.
        let is_open = |at: &Linearised| at.by_u == [[0.0; 3]; 3];
        let known = |at: &Linearised| if is_open(at) { at.f.map(|f| -f) } else { [0.0; 3] };
        let mut step: Vec<f64> = self.at.iter().flat_map(known).collect();
        let is_at_rest = step.chunks_exact(3).all(|step| is_zero([step[0], step[1], step[2]]));
        let mut effect = if is_at_rest { vec![0.0; step.len()] } else { scaled.product(&step) };
        let applied = self.apply(&step, &effect);
        let residual: Vec<f64> =
            self.at.iter().flat_map(|at| at.f).zip(applied).map(|(f, applied)| -f - applied).collect();
        let size = norm(&residual);
        if size == 0.0 {
            return (step, effect);
        }
        let mut krylov = Krylov::new(residual, size);
        let mut tried: Vec<(Vec<f64>, Vec<f64>)> = Vec::new();
        while tried.len() < MOST_PRODUCTS && krylov.residual() > precision * size {
            let x = self.precondition(krylov.last());
            let w = scaled.product(&x);
            let is_new = krylov.extend(self.apply(&x, &w));
            tried.push((x, w));
            if !is_new {
                break;
            }
        }
        for ((x, w), factor) in tried.iter().zip(krylov.coefficients()) {
            add_scaled(&mut step, factor, x);
            add_scaled(&mut effect, factor, w);
        }
        (step, effect)
    }
}

/// Orthonormal directions, and the least-squares problem of the residual in them, triangular by rotations.
struct Krylov {
    basis: Vec<Vec<f64>>,
    /// Columns of the triangle.
    triangle: Vec<Vec<f64>>,
    rotations: Vec<[f64; 2]>,
    right: Vec<f64>,
}

impl Krylov {
    fn new(residual: Vec<f64>, size: f64) -> Self {
        let first = residual.into_iter().map(|x| x / size).collect();
        Self { basis: vec![first], triangle: Vec::new(), rotations: Vec::new(), right: vec![size] }
    }

    fn last(&self) -> &[f64] {
        self.basis.last().map_or(&[], |last| last)
    }

    fn residual(&self) -> f64 {
        self.right.last().map_or(0.0, |last| last.abs())
    }

    /// Takes up the image of the last direction; returns whether it has a new one.
    fn extend(&mut self, mut image: Vec<f64>) -> bool {
        let size = norm(&image);
        let mut column = Vec::with_capacity(self.basis.len() + 1);
        for direction in &self.basis {
            let part = dot(direction, &image);
            add_scaled(&mut image, -part, direction);
            column.push(part);
        }
        let rest = norm(&image);
        for (i, [c, s]) in self.rotations.iter().enumerate() {
            (column[i], column[i + 1]) =
                (c * column[i] + s * column[i + 1], c * column[i + 1] - s * column[i]);
        }
        let place = self.rotations.len();
        let radius = column[place].hypot(rest);
        let [c, s] = if radius > 0.0 { [column[place] / radius, rest / radius] } else { [1.0, 0.0] };
        column[place] = radius;
        let right = self.right[place];
        self.right[place] = c * right;
        self.right.push(-s * right);
        self.rotations.push([c, s]);
        self.triangle.push(column);
        let is_new = rest > f64::EPSILON * size;
        self.basis.push(image.into_iter().map(|x| if is_new { x / rest } else { 0.0 }).collect());
        is_new
    }

    /// Factors of the directions that minimise the residual.
    fn coefficients(&self) -> Vec<f64> {
        let mut factors = self.right[..self.triangle.len()].to_vec();
        for i in (0..factors.len()).rev() {
            let own = self.triangle[i][i];
            factors[i] = if own == 0.0 { 0.0 } else { factors[i] / own };
            for j in 0..i {
                factors[j] -= self.triangle[i][j] * factors[i];
            }
        }
        factors
    }
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

fn norm(a: &[f64]) -> f64 {
    dot(a, a).sqrt()
}

fn add_scaled(y: &mut [f64], a: f64, x: &[f64]) {
    y.iter_mut().zip(x).for_each(|(y, x)| *y += a * x);
}
