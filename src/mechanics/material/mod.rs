//! Constitutive laws: energy per reference volume ψ [J/m³], stress P = ∂ψ/∂F [Pa], one file per law.
//!
//! A law is written once over [`Real`], see there. Its tangent comes from dual numbers ([`tangent_along`]), exact to
//! rounding, so that no second formula can disagree with the first.
// Kernels must be inlined whole into the loop over lanes: a call in between would spill every lane register.

mod balzani;
mod blatz_ko;
mod damage;
mod element_time;
mod ellipticity;
mod exponential;
mod exponential_invariants;
mod fibre_terms;
mod fibres;
mod fung;
mod holzapfel_gasser_ogden;
mod isochoric;
mod kinematics;
mod law;
mod list;
mod logarithm;
mod memories;
mod memory;
mod mooney_rivlin;
mod neo_hookean;
mod ogden;
mod paths;
mod peng_guo_moran;
mod principal_strain;
mod prony;
mod stability;
mod tangent;
#[cfg(test)]
mod tests;
mod validity;
mod volumetric;
mod weiss;
mod yeoh;

pub use damage::{RESIDUAL, Softening};
pub use element_time::ElementTime;
pub use ellipticity::least_acoustic_eigenvalue;
pub use exponential::FIBRE_EXPONENT_LIMIT;
pub use fibre_terms::I4Form;
pub use fibres::{FibreFamilies, MAX_FAMILIES};
pub use fung::OrthotropicModuli;
pub use holzapfel_gasser_ogden::MatrixForm;
pub use kinematics::{Invariants, Kinematics, bound_largest, volume_change};
pub use law::{BoundedResponse, Law, Response, TotalResponse};
pub use memories::{Memories, MemorySteps};
pub use memory::{ElasticPoint, History, Inelastic, Memory, Overstress};
pub use ogden::{MAX_OGDEN_TERMS, OgdenTerm};
pub use paths::{MaterialError, Path, PathPoint, PointStress, eval_path, eval_point};
pub use peng_guo_moran::FibreShear;
pub use prony::{Branch, MAX_BRANCHES, PronySeries, SecantStiffness, isochoric_stress};
pub use stability::{Instability, first_instability};
pub use tangent::{assemble_law_tangent, assemble_tangent, tangent_along};
pub use validity::{Deformations, Given, Validity};
use volumetric::KEEPS_ITS_VOLUME;
pub use volumetric::{BULK_MODULUS_OF_WATER, Volumetric};
pub use weiss::{MOST_TOE_EXPONENT, MOST_TOE_STRETCH, StraighteningFibres};

use super::real::{Outlined, Real};
use super::tensor::Tensor;

/// Generates from the list of laws the enum [`Material`], and `with_law!`, which matches it. `$dollar` is a dollar sign, for the inner macro.
macro_rules! laws {
    ($dollar:tt $($name:literal: $file:ident, $Law:ident, $Document:ident;)*) => {
        $(pub use $file::$Law;)*

        /// Any of the laws, by value, as named in a scene and stored in a plan. Laws with kernels of their own are matched once
        /// a chunk for the internal forces of hexahedra; all else matches at every point.
        #[allow(clippy::large_enum_variant)] // one a block of elements, read in its loops
        #[derive(Clone, Copy, Debug, PartialEq)]
        pub enum Material {
            $(#[doc = concat!("See [`", stringify!($Law), "`].")] $Law($Law),)*
        }

        $(impl From<$Law> for Material {
            fn from(law: $Law) -> Self {
                Self::$Law(law)
            }
        })*

        /// Runs `$body` with `$law` bound to the concrete law.
        macro_rules! with_law {
            ($dollar material:expr, $dollar law:ident => $dollar body:expr) => {
                match $dollar material {
                    $($crate::material::Material::$Law($dollar law) => $dollar body,)*
                }
            };
        }
        #[cfg(test)]
        pub(crate) use with_law;
    };
}

#[cfg(not(test))]
crate::with_laws!(laws $);
// Tests have one law more.
#[cfg(test)]
crate::with_laws!(laws $ "viscous_volume": tests, ViscousVolume, None;);

/// Generates `with_kernel_law!`, which resolves those of the laws that have force kernels of their own.
macro_rules! kernels {
    ($dollar:tt $($Law:ident),*) => {
        /// Runs `$body` with `$law` bound to the type that force kernels are compiled for: the law itself, or
        /// [`Material`].
        macro_rules! with_kernel_law {
            ($dollar material:expr, $dollar law:ident => $dollar body:expr) => {
                match $dollar material {
                    $($crate::material::Material::$Law($dollar law) => $dollar body,)*
                    $dollar law => $dollar body,
                }
            };
        }
        pub(crate) use with_kernel_law;
    };
}
// The most used laws: a kernel of its own is faster, and takes long to compile.
kernels!($ MooneyRivlin, NeoHookean, HolzapfelGasserOgden);

impl Material {
    /// ψ and P, including U(J), at a point with its own J (no element average). `H = F − I` [-].
    pub fn eval_total<R: Real>(&self, H: &Tensor<R>, fibres: &[[R; 3]]) -> TotalResponse<R> {
        let k = Kinematics::new(H);
        let response = self.eval(&k, fibres);
        let (energy, pressure) =
            self.volumetric().map_or((k.j.zero(), k.j.zero()), |U| (U.energy(k.j), U.pressure(k.j)));
        TotalResponse { psi: response.psi + energy, P: response.first_piola(&k, pressure) }
    }
    /// Name of the law in reports.
    pub fn name(&self) -> &'static str {
        with_law!(self, law => name_of(law))
    }
    /// Cost of an element with this law.
    pub fn element_time(&self) -> ElementTime {
        with_law!(self, law => law.element_time())
    }
    /// Range of validity of the law unless a scene specifies another.
    pub fn validity(&self) -> Validity {
        with_law!(self, law => validity_of(law))
    }
    /// Small-strain shear modulus G and bulk modulus K at rest, fibres apart [Pa].
    pub fn moduli_at_rest(&self) -> (f64, f64) {
        with_law!(self, law => law.moduli_at_rest())
    }
    /// Whether it is meant to keep its volume, as foam is not.
    pub fn keeps_its_volume(&self) -> bool {
        let (shear, bulk) = self.moduli_at_rest();
        bulk > KEEPS_ITS_VOLUME * shear
    }
    /// Bulk modulus at rest [Pa], if it is below that of water in a solid that is meant to keep its volume.
    pub fn capped_bulk_modulus(&self) -> Option<f64> {
        let (_, bulk) = self.moduli_at_rest();
        (bulk < BULK_MODULUS_OF_WATER && self.keeps_its_volume()).then_some(bulk)
    }
    /// Upper bound of the contribution of fibres in tension to the stiffness at rest [Pa],
    /// [`Law::fibre_modulus_at_rest`].
    pub fn fibre_modulus_at_rest(&self) -> f64 {
        with_law!(self, law => law.fibre_modulus_at_rest())
    }
    /// Number of fibre families of the law.
    pub fn family_count(&self) -> usize {
        with_law!(self, law => law.family_count())
    }
    /// The directions of the law's own fibre families, in the material axes.
    pub fn fibre_directions(&self) -> &[[f64; 3]] {
        with_law!(self, law => law.fibre_directions())
    }
    /// The same law without fibre families of zero stiffness, [`Law::without_idle_fibres`].
    #[must_use]
    pub fn without_idle_fibres(self) -> Self {
        with_law!(self, law => law.without_idle_fibres().into())
    }
    /// The same law with its isochoric stress times `factor` [-], [`Law::with_isochoric_scaled`].
    #[must_use]
    pub fn with_isochoric_scaled(self, factor: f64) -> Option<Self> {
        with_law!(self, law => law.with_isochoric_scaled(factor).map(Self::from))
    }
    /// Largest stretch [-] where an exponent exceeds [`FIBRE_EXPONENT_LIMIT`], else `None`: `|F a|` of the most
    /// stretched family, or a bound of the principal stretches of a law without fibres. `H = F − I` [-].
    pub fn overstretch(&self, H: &Tensor<f64>, fibres: &[[f64; 3]]) -> Option<f64> {
        let k = Kinematics::new(H);
        let inv = Invariants::new(&k);
        let exponent = self.eval_with_bounds(&k, &inv, fibres).fibre_exponent;
        // Not `>`: a NaN exponent exceeds the limit, too.
        if exponent <= FIBRE_EXPONENT_LIMIT {
            return None;
        }
        let stretch = |a: &[f64; 3]| k.F.apply(a).iter().map(|x| x * x).sum::<f64>().sqrt();
        Some(fibres.iter().map(stretch).reduce(f64::max).unwrap_or(inv.max_C.sqrt()))
    }
    /// The volumetric energy of a split law, `None` for a coupled one.
    pub fn volumetric(&self) -> Option<Volumetric> {
        with_law!(self, law => law.volumetric())
    }
}

/// Any law as one type, matched at every point, in a function of its own: all laws stand in the program once for each kind of number, not
/// once for each kind of number, element and pass. All passes but the internal forces are compiled for it alone, as are the internal forces
/// of laws with a common kernel: a call costs little compared with the law, and kernels dominate the compile time.
impl Law for Material {
    const NAME: &'static str = "any law";
    const FITTED: Deformations = <NeoHookean as Law>::FITTED;

    fn fibre_directions(&self) -> &[[f64; 3]] {
        self.fibre_directions()
    }
    #[inline(always)]
    fn eval_with_bounds<R: Real>(
        &self,
        k: &Kinematics<R>,
        inv: &Invariants<R>,
        fibres: &[[R; 3]],
    ) -> BoundedResponse<R> {
        k.j.outlined(EvalWithBounds { material: self, k, inv, fibres })
    }
    #[inline(always)]
    fn eval<R: Real>(&self, k: &Kinematics<R>, fibres: &[[R; 3]]) -> Response<R> {
        k.j.outlined(Eval { material: self, k, fibres })
    }
    #[inline(always)]
    fn history_len(&self) -> usize {
        with_law!(self, law => law.history_len())
    }
    #[inline(always)]
    fn update<R: Real>(
        &self,
        h: f64,
        elastic: &ElasticPoint<R>,
        fibres: &[[R; 3]],
        history: &mut impl History<R>,
    ) -> Overstress<R> {
        with_law!(self, law => law.update(h, elastic, fibres, history))
    }
    fn volumetric(&self) -> Option<Volumetric> {
        self.volumetric()
    }
    fn moduli_at_rest(&self) -> (f64, f64) {
        self.moduli_at_rest()
    }
    fn with_isochoric_scaled(self, factor: f64) -> Option<Self> {
        self.with_isochoric_scaled(factor)
    }
}

/// [`Law::eval_with_bounds`] of any law.
struct EvalWithBounds<'a, R> {
    material: &'a Material,
    k: &'a Kinematics<R>,
    inv: &'a Invariants<R>,
    fibres: &'a [[R; 3]],
}

impl<R: Real> Outlined for EvalWithBounds<'_, R> {
    type Output = BoundedResponse<R>;
    #[inline(always)]
    fn run(self) -> BoundedResponse<R> {
        with_law!(self.material, law => law.eval_with_bounds(self.k, self.inv, self.fibres))
    }
}

/// [`Law::eval`] of any law.
struct Eval<'a, R> {
    material: &'a Material,
    k: &'a Kinematics<R>,
    fibres: &'a [[R; 3]],
}

impl<R: Real> Outlined for Eval<'_, R> {
    type Output = Response<R>;
    #[inline(always)]
    fn run(self) -> Response<R> {
        with_law!(self.material, law => law.eval(self.k, self.fibres))
    }
}

/// [`Law::NAME`] of a value.
fn name_of<L: Law>(_: &L) -> &'static str {
    L::NAME
}

/// Range of validity of the law of a value.
fn validity_of<L: Law>(_: &L) -> Validity {
    Validity::fitted_to(L::FITTED)
}
