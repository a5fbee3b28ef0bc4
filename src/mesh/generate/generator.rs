//! A mesh generator of a scene document.

use super::block::Block;
use super::cylinder::Cylinder;
use super::hollow_ball::HollowBall;
use super::layered_block::LayeredBlock;
use super::limb_segment::LimbSegment;
use super::solid_ball::SolidBall;
use crate::mesh::{Mesh, MeshError, ParameterProblem};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A mesh generated from a few parameters.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(tag = "kind", rename_all = "snake_case", deny_unknown_fields)]
pub enum Generator {
    /// A cubed-sphere shell: part `ball`, node sets `outer`, `inner`.
    HollowBall(HollowBall),
    /// A solid ball, a cube blended into a cubed sphere: part `ball`, node set `outer`; a quarter also has `x_min` and
    /// `y_min`.
    SolidBall(SolidBall),
    /// A round baton: part `baton`, node sets `side`, `bottom`, `top`, `ends`.
    Cylinder(Cylinder),
    /// A block along x, y, z: part `block`, node sets `x_min` … `z_max`.
    Block(Block),
    /// Layers along z, such as skin, fat, muscle: one part per name, node sets `x_min` … `z_max`.
    LayeredBlock(LayeredBlock),
    /// A limb along y with an elliptic section: bone hole, muscle, fat, skin; parts `muscle`, `fat`, `skin`; node sets
    /// `bone`, `skin_outer`, `end_low`, `end_high`; material axes e1 along the limb, e2 circumferential, e3 outwards.
    LimbSegment(LimbSegment),
}

/// Runs `$body` with `$it` bound to the concrete generator.
macro_rules! with_generator {
    ($generator:expr, $it:ident => $body:expr) => {
        match $generator {
            Generator::HollowBall($it) => $body,
            Generator::SolidBall($it) => $body,
            Generator::Cylinder($it) => $body,
            Generator::Block($it) => $body,
            Generator::LayeredBlock($it) => $body,
            Generator::LimbSegment($it) => $body,
        }
    };
}

impl Generator {
    /// All parameters out of range, with their fields as in `elements[1]` or `layers[0].thickness_m`.
    pub fn problems(&self) -> Vec<ParameterProblem> {
        with_generator!(self, it => it.problems())
    }

    /// Number of elements of the mesh; saturates instead of overflowing.
    pub fn element_count(&self) -> u64 {
        with_generator!(self, it => it.element_count())
    }

    /// All element counts, for modification.
    pub fn counts_mut(&mut self) -> Vec<&mut u32> {
        with_generator!(self, it => it.counts_mut())
    }

    /// For each count, in their order, whether even numbers keep elements from extending across the middle of the body.
    pub fn counts_across(&self) -> Vec<bool> {
        with_generator!(self, it => it.counts_across())
    }

    /// Generates the mesh.
    ///
    /// # Errors
    /// `Parameters` with all problems of [`Self::problems`].
    pub fn generate(&self) -> Result<Mesh, MeshError> {
        with_generator!(self, it => it.generate())
    }

    /// The same mesh with all element counts multiplied by `factor`.
    #[cfg(test)]
    #[must_use]
    pub(crate) fn refined(mut self, factor: u32) -> Self {
        self.counts_mut().into_iter().for_each(|count| *count = count.saturating_mul(factor));
        self
    }
}
