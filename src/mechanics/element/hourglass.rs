//! The stabilisation of one-point hexahedra: an energy of the hourglass vectors.
//!
//! A one-point hexahedron feels its mean gradient only; what it has beyond, the four hourglass vectors q_α, must be given
//! stiffness. As in Puso (2000) that stiffness is the material's own, from an enhanced assumed strain element integrated by
//! hand, so there is no parameter. With the convected base vectors at the centre, `j_k = ∂x/∂ξ_k`, the Green strain that varies
//! over the element has, to first order in q, the covariant parts
//!
//! ```text
//! E_kk  = (j_k·q_l) ξ_l′ + …          2 E_kl = (j_k·q_k + j_l·q_l) ξ_n + parasitic shear in ξ_k, ξ_l
//! ```
//!
//! grouped by the coordinate ξ_n that they grow with: for each n three numbers, ε_kk = j_k·q_l, ε_ll = j_l·q_k and
//! γ_kl = j_k·q_k + j_l·q_l of the plane (k, l) across it, which are two bendings and the twist of a plate. The nine enhanced
//! modes of Simo & Rifai (1990) take away the parasitic shear (no shear locking) and free the strain along ξ_n (plane stress in
//! the plate, λ′ = 2μλ/(λ + 2μ), which is 2μ for an incompressible solid: no volumetric locking). What remains is
//!
//! ```text
//! ψ₂ = V/3 Σ_n [μ ε:ε + ½ λ′ (tr ε)²]_n + V/9 Σ_k ⅔ μ ε₄_k²          ε₄_k = j_k·q₄
//! ```
//!
//! in the metric of the reference element, the skew of each plane included: for a parallelepiped and small strains this *is* the
//! enhanced element. The fourth vector, which no smooth motion needs, has the part that Puso gives it.
//!
//! Where this differs from Puso, whose hourglass forces are integrated from rates with the current tangent in a frame that
//! turns with the element, and with a metric without skew: that has no energy, so a ledger could not close. Here:
//!
//! - the force is the exact gradient of ψ_hg(u), by q_α *and* by j_k, so energy and angular momentum are kept;
//! - j_k·q_α does not change when the element turns (both turn with it), so no frame has to be found: no polar decomposition;
//! - strains are relative to the current lengths, `ε_kl ← c_kl ε_kl`, `c_kl = ¼ + 3/2 / (x_k + x_l)`, x_k = |j_k|²/|G_k|²: in an element
//!   stretched by λ the stiffness is then close to ½ (1 + λ⁻²) of that at rest, which is what a neo-Hookean solid does; plain
//!   Green strain would give λ², next to nothing in an element that is being crushed;
//! - the energy is `ψ_hg = ψ₂ (1 + ψ₂/(μV))`, ψ₂ the quadratic form above: the fourth order, too, is that of a bent neo-Hookean
//!   plate, ∫ ½ μ (λ² + λ⁻² − 2) with λ = 1 + e η, whose two first terms are in the ratio 1 : ¾ e² = 1 : 1.1 ψ₂/(μV). Without it
//!   nothing would keep a surface that is pressed between the nodes of a harder one from folding;
//! - moduli are those of the law at rest, fibres apart: a modulus that followed the strain would need the gradient of that too;
//! - ψ_hg ≥ 0, and 0 only without hourglass: no state of the mean stress can make the element unstable in these modes, as it
//!   can enhanced elements under large compression (Wriggers & Reese 1996).
// Kernels must be inlined whole into the loop over lanes: a call in between would spill every lane register.

use super::hex8_modes::{ModalGeometry, V3};
use super::largest_eigenvalue::largest_eigenvalue;
use crate::real::Real;

/// In-plane directions (k, l) of the plane across direction n.
const PLANE: [(usize, usize); 3] = [(1, 2), (2, 0), (0, 1)];

/// Constants of the stabilisation of one element.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hourglass<R> {
    /// G_k/|G_k|, unit vectors along the base at rest [-].
    pub base: [V3<R>; 3],
    /// Inverse lengths 1/|G_k| of the base at rest [1/m].
    pub inverse_length: V3<R>,
    /// Stiffness of the plane across each direction against (ε_kk, ε_ll, γ_kl) in unit base vectors, V/3 included [J]:
    /// `[[d0, d1, d2], [d1, d0, d2], [d2, d2, d3]]`.
    pub plane: [[R; 4]; 3],
    /// 4/3 μ V/9 [J].
    pub fourth: R,
    /// 1/(μV) [1/J]; 0 without stiffness.
    pub inverse_scale: R,
    /// Largest stiffness of a plane against its strains ε_kk, ε_ll, γ_kl/√2 [J].
    pub largest: R,
}

/// ψ_hg and its derivatives.
#[derive(Clone, Copy, Debug)]
pub struct HourglassResponse<R> {
    /// Energy of the stabilisation ψ_hg [J].
    pub energy: R,
    /// ∂ψ_hg/∂l_k [N], q_α held.
    pub on_linear: [V3<R>; 3],
    /// Forces ∂ψ_hg/∂q_α on the hourglass modes [N].
    pub on_hourglass: [V3<R>; 4],
    /// Bound s of the stiffness against hourglass over that at rest, [`Hourglass::stiffness_bound`] [-]; 1 at rest.
    pub stiffening: R,
    /// Bound β of the stiffness against the unit base vectors [J]: `δ²ψ_hg ≤ s Σ_α κ_α |δq_α|² + β Σ_k |δl_k|²/|G_k|²`; 0 without
    /// hourglass.
    pub base_stiffness: R,
}

impl Hourglass<f64> {
    /// From the geometry, the shear modulus μ and the bulk modulus K at rest [Pa].
    pub fn new(geometry: &ModalGeometry, mu: f64, K: f64) -> Self {
        let length = geometry.base.map(|G| G.norm());
        let base = [0, 1, 2].map(|k| geometry.base[k] / length[k]);
        let plate = plate_modulus(mu, K);
        let plane = PLANE.map(|(k, l)| {
            // Inverse metric of the two unit vectors: s on the diagonal, t beside it.
            let cos = base[k].dot(&base[l]);
            let s = 1.0 / (1.0 - cos * cos);
            let t = -cos * s;
            let (ss, tt, st) = (s * s, t * t, s * t);
            let d = [
                2.0 * mu * ss + plate * ss,
                2.0 * mu * tt + plate * ss,
                (2.0 * mu + plate) * st,
                mu * (ss + tt) + plate * tt,
            ];
            d.map(|d| d * geometry.volume / 3.0)
        });
        Self {
            base: base.map(<[f64; 3]>::from),
            inverse_length: length.map(|L| 1.0 / L),
            plane,
            fourth: 4.0 / 3.0 * mu * geometry.volume / 9.0,
            inverse_scale: if mu > 0.0 { 1.0 / (mu * geometry.volume) } else { 0.0 },
            largest: plane.iter().map(largest_plane_stiffness).fold(0.0, f64::max),
        }
    }

    /// κ_α [J/m²]: at rest `ψ_hg ≤ ½ Σ_α κ_α |q_α|²`, and elsewhere with κ_α times [`HourglassResponse::stiffening`].
    ///
    /// In unit base vectors ε_kk² ≤ C |q_l|²/|G_k|² and ½ γ_kl² ≤ C (|q_l|²/|G_k|² + |q_k|²/|G_l|²), with C = 1 at rest and else the
    /// largest c_kk² x_k and c_kl² x_k: twice the right side bounds ε:ε.
    pub fn stiffness_bound(&self) -> [f64; 4] {
        let mut bound = [0.0; 4];
        let square = |k: usize| self.inverse_length[k].powi(2);
        for (d, (k, l)) in self.plane.iter().zip(PLANE) {
            let largest = largest_plane_stiffness(d);
            bound[l] += 2.0 * largest * square(k);
            bound[k] += 2.0 * largest * square(l);
        }
        // Alone in its sum, where the stiffening is by the mean of two.
        bound[3] = 2.0 * self.fourth * (square(0) + square(1) + square(2));
        bound
    }
}

/// λ′ = 2μλ/(λ + 2μ), λ = K − ⅔ μ: what is left of λ in plane stress [Pa].
fn plate_modulus(mu: f64, K: f64) -> f64 {
    let lambda = K - 2.0 / 3.0 * mu;
    let sum = lambda + 2.0 * mu;
    if sum > 0.0 { 2.0 * mu * lambda / sum } else { 0.0 }
}

/// Largest eigenvalue of a plane's stiffness against ε_kk² + ε_ll² + ½ γ_kl².
fn largest_plane_stiffness([d0, d1, d2, d3]: &[f64; 4]) -> f64 {
    let (d2, d3) = (std::f64::consts::SQRT_2 * d2, 2.0 * d3);
    largest_eigenvalue([[*d0, *d1, d2], [*d1, *d0, d2], [d2, d2, d3]])
}

impl<R: Real> Hourglass<R> {
    /// At linear modes `l` and hourglass vectors `q` of the displacement [m].
    #[inline(always)]
    pub fn eval(&self, l: &[V3<R>; 3], q: &[V3<R>; 4]) -> HourglassResponse<R> {
        let zero = self.fourth.zero();
        let inverse = &self.inverse_length;
        // Base vectors over their lengths at rest, and the squares of their stretches.
        let (mut j, mut x) = (self.base, [zero; 3]);
        for k in 0..3 {
            for i in 0..3 {
                j[k][i] = l[k][i].mul_add(inverse[k], j[k][i]);
            }
            x[k] = dot(&j[k], &j[k]);
        }
        let lengths = RelativeLengths::new(&x);
        let mut a = [[zero; 4]; 3];
        for (a, j) in a.iter_mut().zip(&j) {
            for (a, q) in a.iter_mut().zip(q) {
                *a = dot(j, q);
            }
        }

        // Strains and stresses of the planes, the derivatives of ψ₂ by a, and −2 of those by x.
        let (mut f, mut pull) = ([[zero; 4]; 3], [zero; 3]);
        let mut twice = zero;
        for (n, (k, l)) in PLANE.into_iter().enumerate() {
            let d = &self.plane[n];
            let (own_k, own_l, shear) = (lengths.own[k], lengths.own[l], lengths.shear[n]);
            let (raw1, raw2) = (a[k][l] * inverse[k], a[l][k] * inverse[l]);
            let raw3 = a[k][k].mul_add(inverse[l], a[l][l] * inverse[k]);
            let (e1, e2, g) = (raw1 * own_k, raw2 * own_l, raw3 * shear);
            let s1 = d[0].mul_add(e1, d[1].mul_add(e2, d[2] * g));
            let s2 = d[1].mul_add(e1, d[0].mul_add(e2, d[2] * g));
            let s3 = d[2].mul_add(e1 + e2, d[3] * g);
            twice = s1.mul_add(e1, s2.mul_add(e2, s3.mul_add(g, twice)));
            f[k][l] = s1 * own_k * inverse[k];
            f[l][k] = s2 * own_l * inverse[l];
            let on_raw3 = s3 * shear;
            f[k][k] = on_raw3.mul_add(inverse[l], f[k][k]);
            f[l][l] = on_raw3.mul_add(inverse[k], f[l][l]);
            let both = lengths.shear_slope[n] * s3 * raw3;
            pull[k] += lengths.own_slope[k].mul_add(s1 * raw1, both);
            pull[l] += lengths.own_slope[l].mul_add(s2 * raw2, both);
        }
        for k in 0..3 {
            let raw = a[k][3] * inverse[k];
            let e = raw * lengths.own[k];
            let s = self.fourth * e;
            twice = s.mul_add(e, twice);
            f[k][3] = s * lengths.own[k] * inverse[k];
            pull[k] = lengths.own_slope[k].mul_add(s * raw, pull[k]);
        }

        // ψ₂ (1 + s), s = ψ₂/(μV): its derivative is 1 + 2s times that of ψ₂.
        let s = twice * self.inverse_scale * 0.5;
        let growth = s * 2.0 + 1.0;
        let energy = (s + 1.0) * twice * 0.5;
        let (stiffening, base_stiffness) = self.stiffness(&lengths, &x, q, s);
        let (mut on_linear, mut on_hourglass) = ([[zero; 3]; 3], [[zero; 3]; 4]);
        for k in 0..3 {
            for i in 0..3 {
                let mut on_j = -(pull[k] * j[k][i]);
                for alpha in 0..4 {
                    on_j = f[k][alpha].mul_add(q[alpha][i], on_j);
                    on_hourglass[alpha][i] = f[k][alpha].mul_add(j[k][i], on_hourglass[alpha][i]);
                }
                on_linear[k][i] = on_j * inverse[k] * growth;
            }
        }
        for on in on_hourglass.as_flattened_mut() {
            *on = *on * growth;
        }
        HourglassResponse { energy, on_linear, on_hourglass, stiffening, base_stiffness }
    }
}

impl<R: Real> Hourglass<R> {
    /// (s, β) of [`HourglassResponse`], from `growth = ψ₂/(μV)`.
    ///
    /// A strain is e = m(j)·u with `m(j) = c j` and the relative hourglass vector u = q/|G|; of the shear, which has both base
    /// vectors as one j and both hourglass vectors as one u, likewise. Since m is a multiple of j and of its inversion j/|j|²,
    /// `|m| = c |j|`, `|∂m| ≤ c`, `|∂²m| ≤ 3/2 |j|⁻³`. With C the bound of |m|² over that at rest, c the largest of its kind,
    /// x = min |j|², w = Σ |u|², D the largest stiffness, Q = Σ κ_α |δq_α|² and T = Σ |δj_k|²:
    ///
    /// ```text
    /// δe D δe   ≤ C Q + 2 √(C Q) √(3/2 c² D w T) + 3/2 c² D w T
    /// s · δ²e   ≤       2 √(C Q) √(3/2 c² D w T) + 3/2 √(5/2) √C x^(−3/2) D w T
    /// ```
    ///
    /// the latter since the stress s has s·s ≤ 2 D ψ₂ ≤ 2 D² C w. Of ψ₂ (1 + ψ₂/(μV)), whose Hessian has the square of the gradient in
    /// it, (1 + 6 ψ₂/(μV)) times the sum is a bound. The mixed term is split by the fraction 2 c √w.
    #[inline(always)]
    fn stiffness(&self, lengths: &RelativeLengths<R>, x: &V3<R>, q: &[V3<R>; 4], growth: R) -> (R, R) {
        let square = self.inverse_length.map(|inverse| inverse * inverse);
        let sum = square[0] + square[1] + square[2];
        let mut w = sum * dot(&q[3], &q[3]);
        for k in 0..3 {
            w = (sum - square[k]).mul_add(dot(&q[k], &q[k]), w);
        }
        let c = lengths.own[0].max(lengths.own[1]).max(lengths.own[2]);
        let (C, growth) = (lengths.stiffening(x), growth * 6.0 + 1.0);
        let root = w.sqrt();
        // x^(−3/2) √C ≤ ½ (C + 1/x)/x, and 1/x ≤ 4/3 c.
        let second = (c * 3.61).mul_add(c, C * c * 1.59);
        let base = second.mul_add(w, c * root * 3.0) * self.largest;
        (C * (c * root).scale_add(2.0, 1.0) * growth, base * growth)
    }
}

/// c_kk, c_kl and their slopes.
struct RelativeLengths<R> {
    /// c_kk of each direction.
    own: V3<R>,
    /// −2 ∂c_kk/∂x_k of each direction.
    own_slope: V3<R>,
    /// c_kl of the plane across each direction.
    shear: V3<R>,
    /// −2 ∂c_kl/∂x_k = −2 ∂c_kl/∂x_l.
    shear_slope: V3<R>,
}

impl<R: Real> RelativeLengths<R> {
    /// From the squares of the stretches.
    #[inline(always)]
    fn new(x: &V3<R>) -> Self {
        let mut out = Self { own: *x, own_slope: *x, shear: *x, shear_slope: *x };
        for (n, (k, l)) in PLANE.into_iter().enumerate() {
            // One division for two reciprocals.
            let sum = x[k] + x[l];
            let both = x[n].constant(1.0) / (x[n] * sum);
            let (own, shear) = (sum * both, x[n] * both);
            out.own[n] = own * 0.75 + 0.25;
            out.own_slope[n] = own * own * 1.5;
            out.shear[n] = shear * 1.5 + 0.25;
            out.shear_slope[n] = shear * shear * 3.0;
        }
        out
    }

    /// Half the sum of the largest c_kk² x_k and the largest c_kl² x_k.
    #[inline(always)]
    fn stiffening(&self, x: &V3<R>) -> R {
        let (mut own, mut shear) = (x[0].zero(), x[0].zero());
        for (n, (k, l)) in PLANE.into_iter().enumerate() {
            own = own.max(self.own[n] * self.own[n] * x[n]);
            shear = shear.max(self.shear[n] * self.shear[n] * x[k].max(x[l]));
        }
        (own + shear) * 0.5
    }
}

#[inline(always)]
fn dot<R: Real>(a: &V3<R>, b: &V3<R>) -> R {
    a[2].mul_add(b[2], a[1].mul_add(b[1], a[0] * b[0]))
}
