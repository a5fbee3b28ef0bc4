//! Stress with a history: what a law with internal variables adds to its elastic response ([`Law::update`](super::Law::update)), and memories,
//! which add to the isochoric stress of any law.
//!
//! A memory is one file with an `impl Memory`, and a line in the list of `memories.rs`. It answers what the passes
//! over elements and the steps ask of a memory; by name they know only the branches of a Prony series, whose energies are in the ledger
//! (`force/memory/branches.rs`). The numbers that a point remembers, those of the law first, are rows of the history in the state; elastic
//! materials have none.

use super::Kinematics;
use crate::real::Real;
use crate::tensor::Sym;

/// Elastic response at a point, to which its history adds.
#[derive(Clone, Copy, Debug)]
pub struct ElasticPoint<'a, R> {
    /// Invariants and metrics of the deformation gradient.
    pub k: &'a Kinematics<R>,
    /// Strain energy without U(J) [J/m³].
    pub psi: R,
    /// U(J) where J > 1 [J/m³], else 0: at the J of the formulation; 0 for materials that do not soften.
    pub tension: R,
    /// Second Piola–Kirchhoff stress without the pressure U′ [Pa], [`super::isochoric_stress`]; of a coupled law all of it.
    pub S_iso: Sym<R>,
    /// Upper bound of the largest eigenvalue of ∂²ψ/∂F² [Pa].
    pub stiffness_bound: R,
    /// Largest eigenvalue of C times that of C⁻¹ [-].
    pub condition: R,
    /// Edge of a cube of the volume of the element [m].
    pub size: R,
    /// Shear modulus of the law at rest [Pa].
    pub shear_modulus: f64,
}

/// What the internal variables of a law add to its elastic response.
#[derive(Clone, Copy, Debug)]
pub struct Overstress<R> {
    /// Further second Piola–Kirchhoff stress [Pa].
    pub S: Sym<R>,
    /// Free energy beyond the elastic one [J/m³]; what the work of S exceeds its change by is dissipated.
    pub stored: R,
    /// Upper bound of the norm of the tangent of F S [Pa].
    pub stiffness: R,
}

impl<R: Real> Overstress<R> {
    /// That of an elastic law.
    #[inline(always)]
    pub fn none(zero: R) -> Self {
        Self { S: Sym([zero; 6]), stored: zero, stiffness: zero }
    }
}

/// What law and memories so far make of the elastic response: with S_iso and its energy times 1 − d, and with a further stress.
#[derive(Clone, Copy, Debug)]
pub struct Inelastic<R> {
    /// Further second Piola–Kirchhoff stress, of the law's internal variables and of relaxation [Pa].
    pub S: Sym<R>,
    /// Energy stored with it [J/m³].
    pub stored: R,
    /// Upper bound of the norm of its tangent [Pa].
    pub stiffness: R,
    /// Damage d: fraction of the isochoric stress, and of the pressure in tension, that is lost for good [-].
    pub damage: R,
    /// Energy that damage dissipated in the step [J/m³].
    pub dissipated: R,
}

/// The numbers that a point remembers.
pub trait History<R> {
    /// A number at t_{n−1}; 0 at the start of a run.
    fn before(&self, index: usize) -> R;
    /// Sets the number at t_n.
    fn set(&mut self, index: usize, value: R);

    /// Six numbers as a symmetric tensor at t_{n−1}.
    #[inline(always)]
    fn tensor_before(&self, first: usize, zero: R) -> Sym<R>
    where
        R: Real,
    {
        let mut tensor = Sym([zero; 6]);
        for (i, component) in tensor.0.iter_mut().enumerate() {
            *component = self.before(first + i);
        }
        tensor
    }
    /// Sets six numbers to a symmetric tensor at t_n.
    #[inline(always)]
    fn set_tensor(&mut self, first: usize, tensor: &Sym<R>)
    where
        R: Real,
    {
        for (i, component) in tensor.0.iter().enumerate() {
            self.set(first + i, *component);
        }
    }
}

/// A memory of the isochoric stress of any split law.
pub trait Memory: Copy + std::fmt::Debug + PartialEq + Send + Sync + 'static {
    /// What its step needs of the step size, the same at all points.
    type Step: Copy + std::fmt::Debug;
    /// A material without this memory.
    const NONE: Self;

    /// Its name with the number of its terms, for reports.
    fn title(&self) -> String;
    /// Numbers that a point remembers; 0 without this memory.
    fn history_len(&self) -> usize;
    /// Whether it may lose stress for good ([`Inelastic::damage`]), also the pressure in tension: its elements then have
    /// [`ElasticPoint::tension`] and [`ElasticPoint::size`], and what they lose is taken from their internal forces.
    fn softens(&self) -> bool;
    /// Coefficients of a step of `h` [s]. With `h = 0` and the history of a time, [`Memory::update`] adds what the point has then.
    fn step(&self, h: f64) -> Self::Step;
    /// Takes the history over a step and adds to `to`, which has what the memories before this one add.
    fn update<R: Real>(
        &self,
        step: &Self::Step,
        elastic: &ElasticPoint<R>,
        history: &mut impl History<R>,
        to: &mut Inelastic<R>,
    );
}
