//! The largest eigenvalue of a small symmetric matrix: all that the critical time step needs of an element's eigenvalues.
//!
//! Householder's tridiagonal form, then Newton-like steps from above on its pivots. Where `λ` is above all eigenvalues the
//! pivots of `λ I − T` are positive, and with `S1 = Σ 1/(λ − λ_i)` and `S2 = Σ 1/(λ − λ_i)²` the step `√(m/S2)` has the third
//! order for a largest eigenvalue of multiplicity m; with m = 1 it never goes too far. Pivots lose nothing where eigenvalues
//! lie together, as those of a cube do, and characteristic polynomials lose most there.

/// Steps; a usual matrix takes six.
const MOST_STEPS: usize = 100;

/// The largest eigenvalue of a symmetric matrix, to a few roundings of its norm; NaN if anything in it is not finite. Only the
/// lower triangle is read.
pub(crate) fn largest_eigenvalue<const N: usize>(mut A: [[f64; N]; N]) -> f64 {
    let (d, e_squared) = tridiagonal(&mut A);
    let norm = (0..N).map(|i| d[i].abs() + e_squared[i].sqrt()).sum::<f64>();
    // Above all eigenvalues (Gershgorin), and not above by nothing.
    let mut above = norm * (1.0 + 1e-12);
    if !(above > 0.0 && above.is_finite()) {
        return above;
    }
    let least_step = 2.0 * f64::EPSILON * norm;
    let (mut trial, mut safe) = (above, above);
    for _ in 0..MOST_STEPS {
        let Some((s1, s2)) = sums(&d, &e_squared, trial) else {
            // Too far: as far as is safe. If that is too far too, it is the eigenvalue, to rounding.
            if trial >= safe {
                return safe;
            }
            trial = safe;
            continue;
        };
        above = trial;
        let one = 1.0 / s2.sqrt();
        if one <= least_step {
            return above - one;
        }
        safe = above - one;
        trial = above - one * (s1 * s1 / s2).floor().max(1.0).sqrt();
    }
    above
}

/// S1 and S2 at λ; `None` where λ is not above all eigenvalues.
fn sums<const N: usize>(d: &[f64; N], e_squared: &[f64; N], lambda: f64) -> Option<(f64, f64)> {
    // A pivot q, and its first and second derivatives over q.
    let (mut q, mut r, mut t) = (1.0, 0.0, 0.0);
    let (mut s1, mut s2) = (0.0, 0.0);
    for i in 0..N {
        let w = e_squared[i] / q;
        q = lambda - d[i] - w;
        if !(q > 0.0) {
            return None;
        }
        let inverse = 1.0 / q;
        (r, t) = ((1.0 + w * r) * inverse, w * (t - 2.0 * r * r) * inverse);
        s1 += r;
        s2 += r * r - t;
    }
    Some((s1, s2))
}

/// Diagonal, and squares of the elements before it in their rows (the first is zero), of the tridiagonal form.
fn tridiagonal<const N: usize>(A: &mut [[f64; N]; N]) -> ([f64; N], [f64; N]) {
    let mut e_squared = [0.0; N];
    for k in 0..N.saturating_sub(1) {
        // Column k below the diagonal is turned into its first element.
        let mut v = [0.0; N];
        for i in k + 1..N {
            v[i] = A[i][k];
        }
        let first = v[k + 1];
        let rest: f64 = v[k + 2..].iter().map(|x| x * x).sum();
        let norm_squared = first * first + rest;
        e_squared[k + 1] = norm_squared;
        if !(rest > 0.0) {
            continue;
        }
        let alpha = norm_squared.sqrt().copysign(-first);
        v[k + 1] = first - alpha;
        // H = I − β v vᵀ, and H A H = A − v wᵀ − w vᵀ with w = p − ½ β (vᵀp) v, p = β A v.
        let beta = 1.0 / (norm_squared - alpha * first);
        let mut p = [0.0; N];
        for i in k + 1..N {
            let row = (k + 1..N).map(|j| if j <= i { A[i][j] * v[j] } else { A[j][i] * v[j] });
            p[i] = beta * row.sum::<f64>();
        }
        let half = 0.5 * beta * (k + 1..N).map(|i| v[i] * p[i]).sum::<f64>();
        for i in k + 1..N {
            p[i] -= half * v[i];
        }
        for i in k + 1..N {
            for j in k + 1..=i {
                A[i][j] -= v[i] * p[j] + p[i] * v[j];
            }
        }
    }
    (std::array::from_fn(|i| A[i][i]), e_squared)
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::SMatrix;

    /// Q diag(values) Qᵀ with an arbitrary orthogonal Q.
    fn with_eigenvalues(values: [f64; 8], seed: f64) -> [[f64; 8]; 8] {
        let wave = SMatrix::<f64, 8, 8>::from_fn(|i, j| ((8 * i + j) as f64 * 1.3 + seed).sin());
        let Q = wave.qr().q();
        let A = Q * SMatrix::<f64, 8, 8>::from_diagonal(&values.into()) * Q.transpose();
        std::array::from_fn(|i| std::array::from_fn(|j| A[(i, j)]))
    }

    #[test]
    fn it_is_the_largest_of_all() {
        for seed in 0..200 {
            let seed = f64::from(seed);
            let A =
                SMatrix::<f64, 8, 8>::from_fn(|i, j| ((8 * i.min(j) + i.max(j)) as f64 * 0.7 * seed).cos());
            let A = A.transpose() * A;
            let expected = A.symmetric_eigenvalues().max();
            let found = largest_eigenvalue::<8>(std::array::from_fn(|i| std::array::from_fn(|j| A[(i, j)])));
            assert!((found - expected).abs() <= 1e-14 * expected, "{seed}: {found} against {expected}");
        }
    }

    #[test]
    fn eigenvalues_that_lie_together_are_no_exception() {
        for (k, apart) in [0.0, 1e-15, 1e-12, 1e-9, 1e-6, 1e-3].into_iter().enumerate() {
            for count in 1..=8 {
                let values =
                    std::array::from_fn(|i| if i < count { 4.0 - apart * i as f64 } else { 0.3 * i as f64 });
                let found = largest_eigenvalue(with_eigenvalues(values, k as f64));
                assert!((found - 4.0).abs() < 4e-14, "{count} within {apart}: {found}");
            }
        }
    }

    #[test]
    fn diagonal_and_empty_matrices_are_no_exception() {
        let diagonal: [[f64; 8]; 8] =
            std::array::from_fn(|i| std::array::from_fn(|j| if i == j { i as f64 } else { 0.0 }));
        assert!((largest_eigenvalue(diagonal) - 7.0).abs() < 1e-14);
        assert!(largest_eigenvalue([[0.0; 8]; 8]).abs() < f64::MIN_POSITIVE);
        assert!(!largest_eigenvalue([[f64::NAN; 8]; 8]).is_finite());
    }
}
