//! Stress of a material at a given deformation, and along the usual test paths.
//!
//! A path prescribes some entries of F; the others are such that the remaining faces are free of load. They are found
//! by Newton's method on the exact tangent, for the compressible law as it is, without assuming incompressibility.

use super::{FibreFamilies, Material, assemble_tangent};
use crate::tensor::{Mat3, Tensor};
use nalgebra::{DMatrix, DVector};

/// Loading of a homogeneous specimen; `value` is the stretch λ or the shear γ [-].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Path {
    /// F e_x = λ e_x, the faces normal to y and z free of load: the Cauchy stress is σ_xx alone.
    Uniaxial,
    /// F = λ on x and y without shear between them, the face normal to z free of load.
    Equibiaxial,
    /// x += γ y in the plane x, y of unchanged area, the face normal to z free of load.
    SimpleShear,
}

/// Energy and stress at a point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PointStress {
    /// Strain energy per reference volume [J/m³].
    pub psi: f64,
    /// First Piola–Kirchhoff stress [Pa], rows spatial.
    pub P: Mat3,
    /// Cauchy stress σ = P Fᵀ / J [Pa].
    pub cauchy: Mat3,
}

/// One point of a path.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PathPoint {
    /// The prescribed stretch or shear [-].
    pub value: f64,
    /// Deformation gradient, including the free entries [-].
    pub F: Mat3,
    /// Energy and stress there.
    pub stress: PointStress,
}

/// Why the stress at a material point cannot be evaluated.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum MaterialError {
    /// det F is not positive and finite.
    #[error("the deformation is inverted or not a number: J = {J}")]
    Inverted {
        /// J = det F [-].
        J: f64,
    },
    /// The prescribed value is not a positive stretch, or not finite.
    #[error("{value} is not a valid value on a {path:?} path")]
    NoSuchValue {
        /// The path of the request.
        path: Path,
        /// The prescribed value [-].
        value: f64,
    },
    /// More than [`super::MAX_FAMILIES`] directions, or one without a direction.
    #[error("fibre directions must be at most {limit}, each finite and not zero", limit = super::MAX_FAMILIES)]
    NoSuchFibres,
    /// Newton's method found no state with free lateral faces, however small the increments.
    #[error("{path:?} path: no state with free lateral faces found beyond {reached} towards {value}")]
    NotConverged {
        /// The path of the request.
        path: Path,
        /// The prescribed value [-].
        value: f64,
        /// The last value with a solution on the way there [-].
        reached: f64,
    },
    /// An exponent has passed [`super::FIBRE_EXPONENT_LIMIT`], where the law is no longer its exponential.
    #[error("stretched to {stretch}, beyond the range of the exponential law")]
    Overstretched {
        /// Fibre stretch |F a|, or largest principal stretch [-].
        stretch: f64,
    },
}

/// Energy and stress at `F` [-], the material axes along x, y, z.
///
/// # Errors
/// `Inverted` unless J > 0; `Overstretched` beyond the exponential range of the fibres.
pub fn eval_point(material: &Material, F: &Mat3) -> Result<PointStress, MaterialError> {
    eval_with_fibres(material, material.fibre_directions(), F)
}

/// The states along a path at `values` (stretches or shears [-]), in the given order, each found from the previous
/// one, the first from rest.
///
/// `fibres_in_xyz` are the directions of the families in x, y, z, of any length; a law without fibres ignores them.
///
/// # Errors
/// `NoSuchFibres`, `NoSuchValue` for bad input; `NotConverged` where no state with free lateral faces is found;
/// `Overstretched` beyond the exponential range of the fibres.
pub fn eval_path(
    material: &Material,
    fibres_in_xyz: &[[f64; 3]],
    path: Path,
    values: &[f64],
) -> Result<Vec<PathPoint>, MaterialError> {
    let families = FibreFamilies::new(fibres_in_xyz).ok_or(MaterialError::NoSuchFibres)?;
    let specimen = Specimen { material, fibres: families.directions(), path };
    let mut state = (path.value_at_rest(), Mat3::identity());
    let mut points = Vec::with_capacity(values.len());
    for &value in values {
        if !path.admits(value) {
            return Err(MaterialError::NoSuchValue { path, value });
        }
        state = specimen.load_to(value, state)?;
        let stress = eval_with_fibres(material, specimen.fibres, &state.1)?;
        points.push(PathPoint { value, F: state.1, stress });
    }
    Ok(points)
}

/// Energy and stress at `F` with the families given in x, y, z.
fn eval_with_fibres(
    material: &Material,
    fibres: &[[f64; 3]],
    F: &Mat3,
) -> Result<PointStress, MaterialError> {
    let J = F.determinant();
    // Not `J <= 0`: a NaN is rejected, too.
    if !(J > 0.0 && J.is_finite()) {
        return Err(MaterialError::Inverted { J });
    }
    let H = displacement_gradient(F);
    if let Some(stretch) = material.overstretch(&H, fibres) {
        return Err(MaterialError::Overstretched { stretch });
    }
    let response = material.eval_total(&H, fibres);
    let P = Mat3::from(&response.P);
    Ok(PointStress { psi: response.psi, P, cauchy: P * F.transpose() / J })
}

/// Displacement gradient H = F − I.
fn displacement_gradient(F: &Mat3) -> Tensor<f64> {
    Tensor::from(&(F - Mat3::identity()))
}

impl Path {
    /// The value of the undeformed state.
    fn value_at_rest(self) -> f64 {
        match self {
            Self::Uniaxial | Self::Equibiaxial => 1.0,
            Self::SimpleShear => 0.0,
        }
    }

    /// Whether `value` is possible on this path.
    fn admits(self, value: f64) -> bool {
        value.is_finite() && (value > 0.0 || self == Self::SimpleShear)
    }

    /// The entries (i, J) of F determined by the free faces.
    ///
    /// The entries below the diagonal stay 0, which excludes rigid rotations; the P of a free entry being 0, those
    /// below are 0 too by the symmetry of P Fᵀ.
    fn free_entries(self) -> &'static [(usize, usize)] {
        match self {
            Self::Uniaxial => &[(1, 1), (2, 2), (0, 1), (0, 2), (1, 2)],
            Self::Equibiaxial | Self::SimpleShear => &[(2, 2), (0, 2), (1, 2)],
        }
    }

    /// F at `value` from F at `reached`, the free diagonal scaled such that J is unchanged: the initial guess of
    /// Newton's method.
    fn prescribe(self, value: f64, (reached, mut F): (f64, Mat3)) -> Mat3 {
        match self {
            Self::Uniaxial => {
                F[(0, 0)] = value;
                F[(1, 1)] *= (reached / value).sqrt();
                F[(2, 2)] *= (reached / value).sqrt();
            }
            Self::Equibiaxial => {
                F[(0, 0)] = value;
                F[(1, 1)] = value;
                F[(2, 2)] *= (reached / value).powi(2);
            }
            Self::SimpleShear => F[(0, 1)] = value,
        }
        F
    }
}

/// A material on a path.
struct Specimen<'a> {
    material: &'a Material,
    fibres: &'a [[f64; 3]],
    path: Path,
}

impl Specimen<'_> {
    /// The state at `value` from a state on the path, in increments of at most 0.05 that are halved where Newton's
    /// method fails and doubled where it converges; it may fail two hundred times.
    fn load_to(&self, value: f64, mut state: (f64, Mat3)) -> Result<(f64, Mat3), MaterialError> {
        const LARGEST: f64 = 0.05;
        const SMALLEST: f64 = 1e-7;
        const MOST_FAILURES: u32 = 200;
        let (mut increment, mut failures) = (LARGEST, 0);
        loop {
            let to_go = value - state.0;
            let last = to_go.abs() <= increment;
            let next = if last { value } else { state.0 + increment * to_go.signum() };
            if let Some(F) = self.solve_free_entries(self.path.prescribe(next, state)) {
                state = (next, F);
                if last {
                    return Ok(state);
                }
                increment = LARGEST.min(2.0 * increment);
            } else {
                (increment, failures) = (0.5 * increment, failures + 1);
                if increment < SMALLEST || failures > MOST_FAILURES {
                    return Err(MaterialError::NotConverged { path: self.path, value, reached: state.0 });
                }
            }
        }
    }

    /// Newton's method for P = 0 at the free entries of F, with a line search that reduces the residual in every
    /// iteration; `None` if it fails.
    ///
    /// Converged when the last change of F is below 10⁻¹²; by quadratic convergence the error is then of rounding. A
    /// test on the residual would need a scale that depends on the law.
    fn solve_free_entries(&self, mut F: Mat3) -> Option<Mat3> {
        const DONE: f64 = 1e-12;
        const ITERATIONS: usize = 50;
        let free = self.path.free_entries();
        let mut residual = self.eval_residual(&F)?;
        for _ in 0..ITERATIONS {
            let A = assemble_tangent(self.material, &displacement_gradient(&F), self.fibres);
            let entry = |(i, j): (usize, usize)| 3 * i + j;
            let K = DMatrix::from_fn(free.len(), free.len(), |a, b| A[entry(free[a])][entry(free[b])]);
            let change = -K.lu().solve(&residual)?;
            let largest = change.amax();
            if !largest.is_finite() {
                return None;
            }
            (F, residual) = self.search_line(&F, &change, &residual)?;
            if largest <= DONE {
                return Some(F);
            }
        }
        None
    }

    /// The first of F + t `change`, t = 1, ½, ¼ …, with a smaller residual; near the solution t = 1 without a test,
    /// where the residual is of rounding and need not decrease.
    fn search_line(
        &self,
        F: &Mat3,
        change: &DVector<f64>,
        residual: &DVector<f64>,
    ) -> Option<(Mat3, DVector<f64>)> {
        let close = change.amax() <= 1e-9;
        let mut t = 1.0;
        while t > 1e-6 {
            let mut trial = *F;
            for (&entry, d) in self.path.free_entries().iter().zip(change.iter()) {
                trial[entry] += t * d;
            }
            if let Some(next) =
                self.eval_residual(&trial).filter(|next| close || next.norm() < residual.norm())
            {
                return Some((trial, next));
            }
            t *= 0.5;
        }
        None
    }

    /// P at the free entries [Pa]; `None` if F is inverted or a value is not finite.
    fn eval_residual(&self, F: &Mat3) -> Option<DVector<f64>> {
        let free = self.path.free_entries();
        if F.determinant() <= 0.0 {
            return None;
        }
        let P = self.material.eval_total(&displacement_gradient(F), self.fibres).P;
        let residual = DVector::from_fn(free.len(), |a, _| P.0[free[a].0][free[a].1]);
        residual.iter().all(|r| r.is_finite()).then_some(residual)
    }
}
