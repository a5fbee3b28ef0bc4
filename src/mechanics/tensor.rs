//! Vectors and 3×3 tensors: nalgebra's for points and nodes, and [`Tensor`] / [`Sym`] over any [`Real`] for kernels.
// Kernels must be inlined whole into the loop over lanes: a call in between would spill every lane register.

use super::real::Real;

/// A vector in space, `f64`; laid out as three consecutive numbers.
pub type Vec3 = nalgebra::Vector3<f64>;
/// A 3×3 matrix of `f64`.
pub type Mat3 = nalgebra::Matrix3<f64>;

/// A general 3×3 tensor, `t.0[row][column]`; for F and P the row is spatial, the column referential.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tensor<R>(pub [[R; 3]; 3]);

/// A symmetric 3×3 tensor, stored as xx, yy, zz, xy, yz, xz.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sym<R>(pub [R; 6]);

/// A [`Tensor`] component by component, without a closure: a closure would be compiled without the instruction set of the
/// kernel that it is called in.
macro_rules! tensor {
    ($i:ident, $j:ident => $e:expr) => {
        Tensor([tensor!(@row $i = 0, $j => $e), tensor!(@row $i = 1, $j => $e), tensor!(@row $i = 2, $j => $e)])
    };
    (@row $i:ident = $row:literal, $j:ident => $e:expr) => {{
        let $i: usize = $row;
        [tensor!(@at $j = 0 => $e), tensor!(@at $j = 1 => $e), tensor!(@at $j = 2 => $e)]
    }};
    (@at $j:ident = $column:literal => $e:expr) => {{
        let $j: usize = $column;
        $e
    }};
}
pub(crate) use tensor;

/// Index of the component (i, j) in a [`Sym`].
const SYM: [[usize; 3]; 3] = [[0, 3, 5], [3, 1, 4], [5, 4, 2]];

impl<R: Real> Tensor<R> {
    /// `c · I` in the lanes of `c`.
    #[inline(always)]
    pub fn diagonal(c: R) -> Self {
        let o = c.zero();
        Self([[c, o, o], [o, c, o], [o, o, c]])
    }
    /// Builds a tensor from its components `f(i, j)`.
    #[inline(always)]
    pub fn from_fn(mut f: impl FnMut(usize, usize) -> R) -> Self {
        Self([[f(0, 0), f(0, 1), f(0, 2)], [f(1, 0), f(1, 1), f(1, 2)], [f(2, 0), f(2, 1), f(2, 2)]])
    }
    /// Sum `self + other`, component by component.
    #[inline(always)]
    #[must_use]
    pub fn plus(&self, other: &Self) -> Self {
        tensor!(i, j => self.0[i][j] + other.0[i][j])
    }
    /// Multiple `c · self`, component by component.
    #[inline(always)]
    #[must_use]
    pub fn scaled(&self, c: R) -> Self {
        tensor!(i, j => self.0[i][j] * c)
    }
    /// `self + c · other`.
    #[inline(always)]
    #[must_use]
    pub fn plus_scaled(&self, c: R, other: &Self) -> Self {
        tensor!(i, j => other.0[i][j].mul_add(c, self.0[i][j]))
    }
    /// Matrix product `self · other`.
    #[inline(always)]
    #[must_use]
    pub fn dot(&self, other: &Self) -> Self {
        let (a, b) = (&self.0, &other.0);
        tensor!(i, j => a[i][2].mul_add(b[2][j], a[i][1].mul_add(b[1][j], a[i][0] * b[0][j])))
    }
    /// Matrix product `self · otherᵀ`.
    #[inline(always)]
    #[must_use]
    pub fn dot_transposed(&self, other: &Self) -> Self {
        let (a, b) = (&self.0, &other.0);
        tensor!(i, j => a[i][2].mul_add(b[j][2], a[i][1].mul_add(b[j][1], a[i][0] * b[j][0])))
    }
    /// Matrix product with a symmetric tensor, `self · s`.
    #[inline(always)]
    #[must_use]
    pub fn dot_sym(&self, s: &Sym<R>) -> Self {
        let a = &self.0;
        tensor!(i, j => a[i][2].mul_add(s.at(2, j), a[i][1].mul_add(s.at(1, j), a[i][0] * s.at(0, j))))
    }
    /// `self + other · s` with a symmetric tensor.
    #[inline(always)]
    #[must_use]
    pub fn plus_dot_sym(&self, other: &Self, s: &Sym<R>) -> Self {
        let (c, a) = (&self.0, &other.0);
        tensor!(i, j => a[i][2].mul_add(s.at(2, j), a[i][1].mul_add(s.at(1, j), a[i][0].mul_add(s.at(0, j), c[i][j]))))
    }
    /// Product `self · a` with a vector.
    #[inline(always)]
    pub fn apply(&self, a: &[R; 3]) -> [R; 3] {
        let t = &self.0;
        let mut out = *a;
        for i in 0..3 {
            out[i] = t[i][2].mul_add(a[2], t[i][1].mul_add(a[1], t[i][0] * a[0]));
        }
        out
    }
    /// Cofactor, `cof F = J F⁻ᵀ = ∂J/∂F`.
    #[inline(always)]
    #[must_use]
    pub fn cofactor(&self) -> Self {
        let f = &self.0;
        tensor!(i, j => {
            let (i1, i2, j1, j2) = ((i + 1) % 3, (i + 2) % 3, (j + 1) % 3, (j + 2) % 3);
            f[i1][j1].mul_sub(f[i2][j2], f[i1][j2] * f[i2][j1])
        })
    }
    /// Determinant, from the known cofactor.
    #[inline(always)]
    pub fn determinant_by(&self, cofactor: &Self) -> R {
        let (f, c) = (&self.0[0], &cofactor.0[0]);
        f[2].mul_add(c[2], f[1].mul_add(c[1], f[0] * c[0]))
    }
    /// Double contraction `self : other`.
    #[inline(always)]
    pub fn double_dot(&self, other: &Self) -> R {
        let mut s = self.0[0][0] * other.0[0][0];
        for (i, j) in [(0, 1), (0, 2), (1, 0), (1, 1), (1, 2), (2, 0), (2, 1), (2, 2)] {
            s = self.0[i][j].mul_add(other.0[i][j], s);
        }
        s
    }
    /// Trace, the sum of the diagonal.
    #[inline(always)]
    pub fn trace(&self) -> R {
        self.0[0][0] + self.0[1][1] + self.0[2][2]
    }
}

impl<R> Sym<R> {
    /// The indices (i, j) of the components, in their order.
    pub const INDICES: [(usize, usize); 6] = [(0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (0, 2)];
}

impl<R: Real> Sym<R> {
    /// Component (i, j) = (j, i).
    #[inline(always)]
    pub fn at(&self, i: usize, j: usize) -> R {
        self.0[SYM[i][j]]
    }
    /// Trace, the sum of the diagonal.
    #[inline(always)]
    pub fn trace(&self) -> R {
        self.0[0] + self.0[1] + self.0[2]
    }
    /// Deviator, `s − tr(s)/3 I`.
    #[inline(always)]
    #[must_use]
    pub fn deviator(&self) -> Self {
        self.plus_diagonal(self.trace() * (-1.0 / 3.0))
    }
    /// `self + c I`.
    #[inline(always)]
    #[must_use]
    pub fn plus_diagonal(&self, c: R) -> Self {
        let s = &self.0;
        Self([s[0] + c, s[1] + c, s[2] + c, s[3], s[4], s[5]])
    }
    /// Squared norm `s : s`.
    #[inline(always)]
    pub fn norm_squared(&self) -> R {
        let s = &self.0;
        let off = s[5].mul_add(s[5], s[4].mul_add(s[4], s[3] * s[3]));
        off.mul_add(off.constant(2.0), s[2].mul_add(s[2], s[1].mul_add(s[1], s[0] * s[0])))
    }
    /// Determinant of the symmetric matrix.
    #[inline(always)]
    pub fn determinant(&self) -> R {
        let [a, b, c, d, e, f] = self.0;
        let (x, y, z) = (b.mul_sub(c, e * e), d.mul_sub(c, e * f), d.mul_sub(e, b * f));
        f.mul_add(z, a.mul_sub(x, d * y))
    }
    /// `s · s`, symmetric.
    #[inline(always)]
    #[must_use]
    pub fn squared(&self) -> Self {
        let [a, b, c, d, e, f] = self.0;
        Self([
            f.mul_add(f, d.mul_add(d, a * a)),
            e.mul_add(e, d.mul_add(d, b * b)),
            e.mul_add(e, f.mul_add(f, c * c)),
            d.mul_add(a + b, f * e),
            e.mul_add(b + c, d * f),
            f.mul_add(a + c, d * e),
        ])
    }
    /// Matrix product with a tensor that commutes with this one: symmetric.
    #[inline(always)]
    #[must_use]
    pub fn dot_commuting(&self, other: &Self) -> Self {
        let mut out = *self;
        for (o, (i, j)) in out.0.iter_mut().zip(Self::INDICES) {
            let first = self.at(i, 0) * other.at(0, j);
            *o = self.at(i, 2).mul_add(other.at(2, j), self.at(i, 1).mul_add(other.at(1, j), first));
        }
        out
    }
    /// Double contraction `self : other`.
    #[inline(always)]
    pub fn double_dot(&self, other: &Self) -> R {
        let (s, t) = (&self.0, &other.0);
        let off = s[5].mul_add(t[5], s[4].mul_add(t[4], s[3] * t[3]));
        off.mul_add(off.constant(2.0), s[2].mul_add(t[2], s[1].mul_add(t[1], s[0] * t[0])))
    }
    /// Quadratic form `a · s a`.
    #[inline(always)]
    pub fn quadratic_form(&self, a: &[R; 3]) -> R {
        let s = &self.0;
        let twice = s[0].constant(2.0);
        let x = s[5].mul_add(a[2], s[3] * a[1]).mul_add(twice, s[0] * a[0]);
        let y = (s[4] * a[2]).mul_add(twice, s[1] * a[1]);
        (s[2] * a[2]).mul_add(a[2], y.mul_add(a[1], x * a[0]))
    }
    /// Bilinear form `a · s b`.
    #[inline(always)]
    pub fn bilinear_form(&self, a: &[R; 3], b: &[R; 3]) -> R {
        let [x, y, z] = self.apply(b);
        z.mul_add(a[2], y.mul_add(a[1], x * a[0]))
    }
    /// Product `s · a` with a vector.
    #[inline(always)]
    pub fn apply(&self, a: &[R; 3]) -> [R; 3] {
        let s = &self.0;
        [
            s[5].mul_add(a[2], s[3].mul_add(a[1], s[0] * a[0])),
            s[4].mul_add(a[2], s[1].mul_add(a[1], s[3] * a[0])),
            s[2].mul_add(a[2], s[4].mul_add(a[1], s[5] * a[0])),
        ]
    }
    /// `self + c (a⊗b + b⊗a)`.
    #[inline(always)]
    #[must_use]
    pub fn plus_dyads(&self, c: R, a: &[R; 3], b: &[R; 3]) -> Self {
        let mut out = *self;
        for (o, (i, j)) in out.0.iter_mut().zip(Self::INDICES) {
            *o = a[i].mul_add(b[j], a[j] * b[i]).mul_add(c, *o);
        }
        out
    }
    /// Multiple `c · self`, component by component.
    #[inline(always)]
    #[must_use]
    pub fn scaled(&self, c: R) -> Self {
        let mut out = *self;
        for x in &mut out.0 {
            *x = *x * c;
        }
        out
    }
    /// `self + c · other`.
    #[inline(always)]
    #[must_use]
    pub fn plus_scaled(&self, c: R, other: &Self) -> Self {
        let mut out = *self;
        for (o, x) in out.0.iter_mut().zip(&other.0) {
            *o = x.mul_add(c, *o);
        }
        out
    }
}

impl From<&Mat3> for Tensor<f64> {
    fn from(m: &Mat3) -> Self {
        tensor!(i, j => m[(i, j)])
    }
}

impl From<&Tensor<f64>> for Mat3 {
    fn from(t: &Tensor<f64>) -> Self {
        Mat3::from_fn(|i, j| t.0[i][j])
    }
}
