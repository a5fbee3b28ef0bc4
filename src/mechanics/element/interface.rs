//! What an element is.
// Kernels must be inlined whole into the loop over lanes: a call in between would spill every lane register.

use crate::real::Real;
use crate::tensor::Tensor;

/// An isoparametric element of N nodes and Q points of equal weight in local coordinates; everything else is made of this.
///
/// Gradients are kept in local coordinates and unscaled: `∂u/∂ξ` is [`Element::DERIVATIVE`] times that of
/// [`Element::local_gradients`]. With d that factor, ω the weight of a point and g the derivatives at hand, a stress P gives the force
/// conjugate to g(u) `ω det(F_X) P F_X⁻ᵀ d = ω d³ P cof g(X)`, which is `P cof g(X / s)` for [`Element::SCALE`] `s = (ω d³)^(−½)`. Then
/// `det g(X / s) = w / s`, w the reference volume of the point.
pub trait Element<const N: usize, const Q: usize>: Copy + std::fmt::Debug + Send + Sync + 'static {
    /// ∂u/∂ξ over the derivatives of [`Element::local_gradients`].
    const DERIVATIVE: f64;
    /// Weight ω of a point in local coordinates.
    const WEIGHT: f64;
    /// What reference positions are divided by, s.
    const SCALE: f64;
    /// Pairs of nodes whose distances are watched so that no step stretches an element too much: edges, and more where they do not
    /// determine a uniform rate of strain.
    const LENGTHS: &'static [(usize, usize)];
    /// Neighbours of each corner along its three edges, right-handed, where corners can fold while all points are well: they are penalised
    /// ([`eval_corner_penalty`](super::eval_corner_penalty)).
    const CORNERS: &'static [[usize; 3]] = &[];
    /// Triple product of those edges over the volume of the element, where opposite sides are parallel [-].
    const CORNER_DETERMINANT: f64 = 1.0;
    /// Whether each law has kernels of internal forces of its own for it, where it has for any; else one kernel serves all laws, matched at every point: for
    /// an element whose speed matters less than the size of the program.
    const KERNELS_OF_LAWS: bool = true;
    /// Cost of an element in units of that of a hexahedron, as measured or assumed [-].
    const RELATIVE_COST: f64 = 1.0;
    /// Whether it has a pressure averaged over nodes.
    const NODAL_PRESSURE: bool = false;
    /// Whether it has kernels in single precision.
    const SINGLE_PRECISION: bool = false;
    /// Local gradients of a nodal field at all points; or local stresses, work-conjugate to them.
    type Local<R: Real>: Copy;

    /// Local gradients of nodal values `u[component][node]` at all points.
    fn local_gradients<R: Real>(u: &[[R; N]; 3]) -> Self::Local<R>;
    /// Local gradient at point `q`, one row per component.
    fn local_gradient_at<R: Real>(g: &Self::Local<R>, q: usize) -> Tensor<R>;
    /// No stress at any point.
    fn no_stress<R: Real>(zero: R) -> Self::Local<R>;
    /// Adds the local stress `P cof` at point `q`, weight included.
    fn add_local_stress<R: Real>(sums: &mut Self::Local<R>, q: usize, P: &Tensor<R>, cof: &Tensor<R>);
    /// The transpose of [`Element::local_gradients`]: nodal forces `f[component][node]`.
    fn nodal_forces<R: Real>(sums: &Self::Local<R>) -> [[R; N]; 3];
    /// Shape functions N_a at the points.
    fn shapes() -> &'static [[f64; N]; Q];
    /// ∂N_a/∂ξ_k at the points: `[point][node a][axis k]`.
    fn shape_gradients() -> &'static [[[f64; 3]; N]; Q];

    /// Volume lumped at each node, by which mass is lumped, from that of the points [m³]: row sums of the consistent mass, unless
    /// these are not positive.
    fn lumped_volumes(volume: &[f64; Q]) -> [f64; N] {
        std::array::from_fn(|a| (0..Q).map(|q| Self::shapes()[q][a] * volume[q]).sum())
    }
}
