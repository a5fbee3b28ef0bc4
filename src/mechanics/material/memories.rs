//! The list of memories, what a material has of them, and the history of a point: of its law, then of each memory.

use super::memory::{ElasticPoint, History, Inelastic, Memory, Overstress};
use super::{Law, damage, prony};
use crate::real::Real;

/// The history of one of several memories: its numbers begin at `first`.
struct Part<'a, H> {
    history: &'a mut H,
    first: usize,
}

impl<R, H: History<R>> History<R> for Part<'_, H> {
    #[inline(always)]
    fn before(&self, index: usize) -> R {
        self.history.before(self.first + index)
    }
    #[inline(always)]
    fn set(&mut self, index: usize, value: R) {
        self.history.set(self.first + index, value);
    }
}

/// Generates from the list of memories the type [`Memories`] that has one of each.
macro_rules! memories {
    ($($(#[$doc:meta])* $name:ident: $file:ident::$Memory:ident,)*) => {
        /// The memories of a material, each [`Memory::NONE`] where it has not that one; applied in this order.
        #[derive(Clone, Copy, Debug, PartialEq)]
        pub struct Memories {
            $($(#[$doc])* pub $name: $file::$Memory,)*
        }

        /// The step size, and [`Memory::Step`] of each kind of memory, prepared once a step.
        #[derive(Clone, Copy, Debug)]
        pub struct MemorySteps {
            h: f64,
            $($name: <$file::$Memory as Memory>::Step,)*
        }

        impl Memories {
            /// A material without memory.
            pub const NONE: Self = Self { $($name: <$file::$Memory as Memory>::NONE,)* };

            /// Numbers that a point remembers.
            pub fn history_len(&self) -> usize {
                [$(self.$name.history_len(),)*].iter().sum()
            }
            /// [`Memory::title`] of those that the material has.
            pub fn titles(&self) -> Vec<String> {
                let all = [$((self.$name.history_len() > 0).then(|| self.$name.title()),)*];
                all.into_iter().flatten().collect()
            }
            /// Whether stress can be lost for good.
            pub fn softens(&self) -> bool {
                [$(self.$name.softens(),)*].contains(&true)
            }
            /// Coefficients of a step of `h` [s].
            pub fn step(&self, h: f64) -> MemorySteps {
                MemorySteps { h, $($name: self.$name.step(h),)* }
            }
            /// Takes the history of a point over a step; what its law and then the memories add to the elastic response.
            #[inline(always)]
            pub fn update<R: Real>(
                &self,
                law: &impl Law,
                steps: &MemorySteps,
                (elastic, fibres): (&ElasticPoint<R>, &[[R; 3]]),
                history: &mut impl History<R>,
            ) -> Inelastic<R> {
                let zero = elastic.psi.zero();
                let Overstress { S, stored, stiffness } = law.update(steps.h, elastic, fibres, history);
                let mut to = Inelastic { S, stored, stiffness, damage: zero, dissipated: zero };
                let mut first = law.history_len();
                $(
                    let count = self.$name.history_len();
                    if count > 0 {
                        self.$name.update(&steps.$name, elastic, &mut Part { history, first }, &mut to);
                        first += count;
                    }
                )*
                let _ = first;
                to
            }
        }
    };
}

// A new memory is a file in this folder and a line here.
memories! {
    /// Stress relaxation by a Prony series.
    prony: prony::PronySeries,
    /// Softening of the isochoric stress beyond an energy.
    softening: damage::Softening,
}

impl Memories {
    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.history_len() == 0
    }
    /// Number of symmetric tensors in reference axes that the numbers of a point begin with; all others are invariants.
    pub fn tensor_count(&self) -> usize {
        // Prony series come first, and remember a stress and one for each branch.
        match self.branches().len() {
            0 => 0,
            branches => branches + 1,
        }
    }
    /// Terms of relaxation, whose energies are counted each on its own; none without relaxation.
    pub fn branches(&self) -> &[prony::Branch] {
        self.prony.branches()
    }
}
