//! A frictional contact problem on its own: `W`, `q` and `μ`, and error measures of a reaction.

use super::delassus::{Block, Delassus, DelassusError};
use super::local::{Local, natural_map, squared_residual};

/// Why a problem is not valid.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum ProblemError {
    /// The operator cannot be built.
    #[error(transparent)]
    Operator(#[from] DelassusError),
    /// An array of the wrong length.
    #[error("{array} has {given} numbers instead of {expected}")]
    Length {
        /// Name of the array: `q` or `mu`.
        array: &'static str,
        /// Numbers required for nc contacts.
        expected: usize,
        /// Numbers given in the array.
        given: usize,
    },
    /// A number that is not finite.
    #[error("{array}[{index}] is not a finite number")]
    NotFinite {
        /// Name of the array: `W` or `q`.
        array: &'static str,
        /// Index of the number; for W the first row of its block.
        index: usize,
    },
    /// A number whose square overflows, or a diagonal entry that is nearly zero.
    #[error(
        "{array}[{index}] = {value:e} is out of range: magnitude at most {LARGEST:e}, diagonal at least 1/{LARGEST:e} or 0"
    )]
    OutOfRange {
        /// Name of the array: `W` or `q`.
        array: &'static str,
        /// Index of the number; for W a row.
        index: usize,
        /// The number that is out of range.
        value: f64,
    },
    /// A coefficient of friction that is negative or NaN.
    #[error("mu[{contact}] = {mu} is not a coefficient of friction (0 or more)")]
    Friction {
        /// Index of the contact in the problem, from 0.
        contact: usize,
        /// Coefficient of friction μ of that contact [-].
        mu: f64,
    },
}

/// Coefficient of friction from which a contact is at full stick [-], as with μ = ∞: rounding of the slip alone, times μ, exceeds usual
/// tolerances.
pub const FULL_STICK: f64 = 1e6;

/// Largest magnitude of a number in W and q: the sums of squares in the error measures stay finite.
pub const LARGEST: f64 = 1e100;

/// Find `r, u ∈ R^{3 nc}` with `u = W r + q` and, for each contact, `K_μ ∋ r ⊥ u + μ ‖u_t‖ n ∈ K_μ*`.
///
/// Three rows `(n, t1, t2)` per contact; impulses [N s] and velocities [m/s], or forces and gaps. W may be rank
/// deficient, slightly unsymmetric, and have zero diagonal blocks. All numbers are finite, except that a coefficient
/// may be `μ = ∞` (full stick), as which those from [`FULL_STICK`] on count.
#[derive(Clone, Debug, PartialEq)]
pub struct ContactProblem {
    W: Delassus,
    q: Vec<f64>,
    mu: Vec<f64>,
    /// `D_c = tr W_cc / 3`; the mean of the other contacts where nothing can move.
    d: Vec<f64>,
}

impl ContactProblem {
    /// `W` 3 nc × 3 nc, `q` 3 nc, `mu` nc [-].
    ///
    /// # Errors
    /// [`ProblemError`] where lengths do not match or numbers are not valid.
    pub fn new(W: Delassus, q: Vec<f64>, mu: Vec<f64>) -> Result<Self, ProblemError> {
        let contacts = W.contacts();
        for (array, expected, given) in [("q", 3 * contacts, q.len()), ("mu", contacts, mu.len())] {
            if given != expected {
                return Err(ProblemError::Length { array, expected, given });
            }
        }
        if let Some(index) = q.iter().position(|x| !x.is_finite()) {
            return Err(ProblemError::NotFinite { array: "q", index });
        }
        if let Some(contact) = mu.iter().position(|&mu| !(mu >= 0.0)) {
            return Err(ProblemError::Friction { contact, mu: mu[contact] });
        }
        if !W.is_finite() {
            let mut place = None;
            W.for_each_block(|c, _, block| {
                if place.is_none() && block.iter().flatten().any(|x| !x.is_finite()) {
                    place = Some(3 * c);
                }
            });
            return Err(ProblemError::NotFinite { array: "W", index: place.unwrap_or(0) });
        }
        check_range(&W, &q)?;
        let d = mean_diagonals((0..contacts).map(|c| W.diagonal_block(c)));
        let mu = mu.into_iter().map(|mu| if mu >= FULL_STICK { f64::INFINITY } else { mu }).collect();
        Ok(Self { W, q, mu, d })
    }

    /// Number of contacts nc.
    pub fn contacts(&self) -> usize {
        self.mu.len()
    }

    /// The Delassus operator W, 3 nc × 3 nc.
    pub fn W(&self) -> &Delassus {
        &self.W
    }

    /// The free relative velocities q, 3 nc.
    pub fn q(&self) -> &[f64] {
        &self.q
    }

    /// Coefficients of friction μ [-], nc.
    pub fn mu(&self) -> &[f64] {
        &self.mu
    }

    /// `D_c = tr W_cc / 3`, positive, nc: the natural scale of each contact. Where W_cc is zero, the mean of the
    /// others (1 if all are zero).
    pub fn scales(&self) -> &[f64] {
        &self.d
    }

    /// Relative velocities `u = W r + q`.
    pub fn velocity(&self, r: &[f64]) -> Vec<f64> {
        let mut u = vec![0.0; self.q.len()];
        self.W.apply(r, &self.q, &mut u);
        u
    }

    /// [`Errors::scaled`] of `r` (3 nc).
    pub fn error_scaled(&self, r: &[f64]) -> f64 {
        self.errors(r).scaled
    }

    /// [`Errors::plain`] of `r` (3 nc).
    pub fn error_plain(&self, r: &[f64]) -> f64 {
        self.errors(r).plain
    }

    /// All error measures of `r` (3 nc).
    pub fn errors(&self, r: &[f64]) -> Errors {
        Errors::new(&self.d, (&self.q, &self.mu), r, &self.velocity(r))
    }
}

/// Checks that numbers can be squared, and that the diagonal can be a divisor.
fn check_range(W: &Delassus, q: &[f64]) -> Result<(), ProblemError> {
    let out_of_range = |array, index, value| Err(ProblemError::OutOfRange { array, index, value });
    if let Some(index) = q.iter().position(|x| x.abs() > LARGEST) {
        return out_of_range("q", index, q[index]);
    }
    let mut found = None;
    W.for_each_block(|c, d, block| {
        for (i, x) in block.iter().enumerate().flat_map(|(i, row)| row.iter().map(move |x| (i, *x))) {
            if x.abs() > LARGEST {
                found = found.or(Some((3 * c + i, x)));
            }
        }
        let trace = block[0][0] + block[1][1] + block[2][2];
        if c == d && trace > 0.0 && trace < 1.0 / LARGEST {
            found = found.or(Some((3 * c, trace)));
        }
    });
    found.map_or(Ok(()), |(index, value)| out_of_range("W", index, value))
}

/// Error measures of reactions; 0 at an exact solution.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Errors {
    /// With F the residual ([`squared_residual`]) at ρ_c = 1/D_c, `‖D^½ F‖ / max(‖D^½ r‖, ‖D^−½ q‖)` [-]. Independent of units.
    pub scaled: f64,
    /// With F the natural map at ρ = 1, `‖F‖ / max(‖q‖, ‖r‖, ‖u‖)` [-], as in Siconos 4.4. Depends on units: of
    /// little use where ‖W‖ is far from 1.
    pub plain: f64,
    /// `‖D^½ F‖ / ‖D^−½ q‖`, with the velocity of approach for F where it is larger [-]: relative to the free velocities alone, so that
    /// growing reactions cannot hide a contact that nothing can stop.
    pub of_free: f64,
    /// The same relative to the motion [-]: the free velocities, `‖D^−½ q‖`, or what reactions change, `(rᵀ W r)^½`, if that is larger.
    /// Where bodies are light, reactions are far larger than it.
    pub of_motion: f64,
}

impl Errors {
    /// Errors of reactions `r` with velocities `u = W r + q` and the scale `d` of each contact.
    pub(super) fn new(d: &[f64], (q, mu): (&[f64], &[f64]), r: &[f64], u: &[f64]) -> Self {
        let (mut error, mut unstopped, mut plain) = (0.0, 0.0, 0.0);
        let (mut reaction, mut free, mut change) = (0.0, 0.0, 0.0);
        for (c, &d) in d.iter().enumerate() {
            let (r, u, q) = (local(r, c), local(u, c), local(q, c));
            let residual = squared_residual(r, u, mu[c], 1.0 / d);
            error += d * residual;
            // Beside a reaction without bounds the residual is lost in rounding; the approach is not.
            unstopped += (d * residual).max(u[0].min(0.0).powi(2) / d);
            plain += squared(natural_map(r, u, mu[c], 1.0));
            reaction += d * squared(r);
            free += squared(q) / d;
            change += work(r, u) - work(r, q);
        }
        let size = |x: &[f64]| x.iter().map(|x| x * x).sum::<f64>();
        let largest = size(q).max(size(r)).max(size(u)).sqrt();
        Self {
            scaled: ratio(error.sqrt(), reaction.max(free).sqrt()),
            plain: ratio(plain.sqrt(), largest),
            of_free: ratio(unstopped.sqrt(), free.sqrt()),
            of_motion: ratio(unstopped.sqrt(), squared_motion(free, change, reaction).sqrt()),
        }
    }
}

/// Part of `‖r̂‖²` that `r̂ᵀ Ŵ r̂` must exceed to be more than rounding.
const NULL: f64 = 1e-13;

/// The square of what contact moves: of the free velocities, `‖q̂‖²`, or of what reactions change, `r̂ᵀ Ŵ r̂`, where it is larger. Reactions
/// without an effect on velocities, which grow without bound where nothing can stop an approach, have no part in it.
#[inline]
pub(super) fn squared_motion(free: f64, change: f64, reactions: f64) -> f64 {
    free.max(change - NULL * reactions)
}

/// Scalar product of a reaction and a velocity.
#[inline]
pub(super) fn work(r: Local, u: Local) -> f64 {
    r[0] * u[0] + r[1] * u[1] + r[2] * u[2]
}

/// The three components of contact `c`.
#[inline]
pub(super) fn local(x: &[f64], c: usize) -> Local {
    [x[3 * c], x[3 * c + 1], x[3 * c + 2]]
}

pub(super) fn squared(a: Local) -> f64 {
    a[0] * a[0] + a[1] * a[1] + a[2] * a[2]
}

/// Whether all three components are exactly zero.
#[inline]
pub(super) fn is_zero(a: Local) -> bool {
    a.iter().all(|x| *x == 0.0)
}

/// Ratio of an error to a size: 0/0 is no error; a NaN is kept.
fn ratio(error: f64, size: f64) -> f64 {
    if error == 0.0 { 0.0 } else { error / size }
}

/// `tr W_cc / 3` of the diagonal blocks of W; the mean of the others where it is zero, 1 if all are.
pub(super) fn mean_diagonals(blocks: impl Iterator<Item = Block>) -> Vec<f64> {
    let mut d: Vec<f64> = blocks.map(|block| (block[0][0] + block[1][1] + block[2][2]) / 3.0).collect();
    let (count, sum) = d.iter().filter(|d| **d > 0.0).fold((0, 0.0), |(n, s), d| (n + 1, s + d));
    let mean = if count > 0 { sum / f64::from(count) } else { 1.0 };
    for d in d.iter_mut().filter(|d| !(**d > 0.0)) {
        *d = mean;
    }
    d
}
