//! A generator of the document as a generator of the mesh: its size and its problems are known before anything is made.

use super::document::{Generator, LayerDocument, LimbSegmentDocument};
use super::problem::{Pointer, Problem};
use crate::mechanics::tensor::Vec3;
use crate::mesh::generate::block::{Block, Cuts};
use crate::mesh::generate::cylinder::Cylinder;
use crate::mesh::generate::grading::Grading;
use crate::mesh::generate::hollow_ball::HollowBall;
use crate::mesh::generate::layered_block::{Layer, LayeredBlock};
use crate::mesh::generate::limb_segment::LimbSegment;
use crate::mesh::generate::solid_ball::SolidBall;
use crate::mesh::{Mesh, MeshError, ParameterProblem};

/// A mesh generator with its parameters.
#[derive(Clone, Debug, PartialEq)]
pub enum Recipe {
    /// A cubed-sphere shell, see [`HollowBall`].
    HollowBall(HollowBall),
    /// A cube blended into a cubed sphere, see [`SolidBall`].
    SolidBall(SolidBall),
    /// A round baton, see [`Cylinder`].
    Cylinder(Cylinder),
    /// A brick along the axes, see [`Block`].
    Block(Block),
    /// A brick of layers along z, see [`LayeredBlock`].
    LayeredBlock(LayeredBlock),
    /// An elliptic limb with a bone hole, see [`LimbSegment`].
    LimbSegment(LimbSegment),
}

/// Runs `$body` with `$it` bound to the concrete generator.
macro_rules! with_generator {
    ($recipe:expr, $it:ident => $body:expr) => {
        match $recipe {
            Recipe::HollowBall($it) => $body,
            Recipe::SolidBall($it) => $body,
            Recipe::Cylinder($it) => $body,
            Recipe::Block($it) => $body,
            Recipe::LayeredBlock($it) => $body,
            Recipe::LimbSegment($it) => $body,
        }
    };
}

impl Recipe {
    /// The generator that a document asks for.
    pub fn new(generator: &Generator) -> Self {
        match *generator {
            // Projectiles: each is one part with a name of its own.
            Generator::HollowBall {
                center_m,
                outer_radius_m,
                inner_radius_m,
                elements_around,
                elements_through,
            } => Self::HollowBall(HollowBall {
                center: center_m.into(),
                outer_radius_m,
                inner_radius_m,
                elements_around,
                elements_through,
                part: "ball".into(),
            }),
            Generator::SolidBall {
                center_m,
                radius_m,
                elements_around,
                elements_through,
                grading,
                quarter,
            } => Self::SolidBall(SolidBall {
                center: center_m.into(),
                radius_m,
                elements_around,
                elements_through,
                grading,
                is_quarter: quarter,
                part: "ball".into(),
            }),
            Generator::Cylinder {
                center_m,
                axis,
                radius_m,
                length_m,
                elements_around,
                elements_through,
                elements_along,
            } => Self::Cylinder(Cylinder {
                center: center_m.into(),
                axis: axis.into(),
                radius_m,
                length_m,
                elements_around,
                elements_through,
                elements_along,
                part: "baton".into(),
            }),
            // Tissues.
            Generator::Block { min_m, max_m, elements, grading, grading_center_m } => {
                Self::Block(block(min_m, max_m, elements, grading, grading_center_m))
            }
            Generator::LayeredBlock {
                top_center_m,
                size_m,
                ref layers,
                elements,
                grading,
                uniform_within_m,
            } => {
                let layer = |layer: &LayerDocument| Layer {
                    part: layer.part.clone(),
                    thickness_m: layer.thickness_m,
                    elements: layer.elements,
                };
                let layers = layers.iter().map(layer).collect();
                Self::LayeredBlock(LayeredBlock {
                    top_center: top_center_m.into(),
                    size_m,
                    layers,
                    elements,
                    grading,
                    uniform_within_m,
                })
            }
            Generator::LimbSegment(ref limb) => Self::LimbSegment(limb_segment(limb)),
        }
    }

    /// The same mesh with all element counts multiplied by `factor`.
    #[must_use]
    pub fn refined(&self, factor: u32) -> Self {
        match self {
            Self::HollowBall(it) => Self::HollowBall(it.refined(factor)),
            Self::SolidBall(it) => Self::SolidBall(it.refined(factor)),
            Self::Cylinder(it) => Self::Cylinder(it.refined(factor)),
            Self::Block(it) => Self::Block(it.refined(factor)),
            Self::LayeredBlock(it) => Self::LayeredBlock(it.refined(factor)),
            Self::LimbSegment(it) => Self::LimbSegment(it.refined(factor)),
        }
    }

    /// Number of elements of the mesh; saturates instead of overflowing.
    pub fn element_count(&self) -> u64 {
        with_generator!(self, it => it.element_count())
    }

    /// Generates the mesh.
    ///
    /// # Errors
    /// `Parameters` with every number out of range.
    pub fn generate(&self) -> Result<Mesh, MeshError> {
        with_generator!(self, it => it.generate())
    }

    /// Every number out of range, as problems of the generator at `here`.
    pub fn problems(&self, here: &Pointer) -> Vec<Problem> {
        let found = with_generator!(self, it => it.problems());
        found.iter().map(|problem| problem_of(problem, here)).collect()
    }
}

/// The problem of a parameter, at its field of the document.
fn problem_of(found: &ParameterProblem, here: &Pointer) -> Problem {
    let pointer = field_path(&found.field).into_iter().fold(here.clone(), |p, key| p.key(&key));
    Problem::error(
        "bad_generator_parameter",
        &pointer,
        format!("the mesh cannot be made with this {}", found.field),
    )
    .value(found.value)
    .limit(found.limit.clone())
    .remedy(found.remedy.clone())
}

/// Path in the document of the field that a generator calls `name` ("center[1]", "cuts_x.ratio", "layers[0].thickness_m").
fn field_path(name: &str) -> Vec<String> {
    let mut steps = name.split(['[', ']', '.']).filter(|step| !step.is_empty());
    let field = steps.next().unwrap_or_default();
    if let Some(axis) = field.strip_prefix("cuts_").and_then(|axis| "xyz".find(axis)) {
        let field = match steps.next() {
            Some("ratio") => "grading",
            Some("position_m") => "grading_center_m",
            _ => "elements",
        };
        return vec![field.into(), axis.to_string()];
    }
    let field = match field {
        "center" => "center_m",
        "top_center" => "top_center_m",
        "min_corner_m" => "min_m",
        "max_corner_m" => "max_m",
        // The whole generator is too large, not one of its fields.
        "element_count" => return Vec::new(),
        field => field,
    };
    std::iter::once(field).chain(steps).map(str::to_owned).collect()
}

fn block(
    min_m: [f64; 3],
    max_m: [f64; 3],
    elements: [u32; 3],
    grading: Option<[f64; 3]>,
    center_m: Option<[f64; 3]>,
) -> Block {
    let cuts = |axis: usize| match grading {
        None => Cuts::Uniform { count: elements[axis] },
        Some(ratio) => Cuts::Towards {
            count: elements[axis],
            position_m: center_m.map_or(0.5 * (min_m[axis] + max_m[axis]), |c| c[axis]),
            grading: Grading::from_point(ratio[axis]),
        },
    };
    Block {
        min_corner_m: Vec3::from(min_m),
        max_corner_m: Vec3::from(max_m),
        cuts: [cuts(0), cuts(1), cuts(2)],
        part: "block".into(),
    }
}

/// The generator of a limb segment from its document.
pub fn limb_segment(limb: &LimbSegmentDocument) -> LimbSegment {
    LimbSegment {
        center: limb.center_m.into(),
        semi_axis_x_m: limb.semi_axis_x_m,
        semi_axis_z_m: limb.semi_axis_z_m,
        length_m: limb.length_m,
        bone_semi_axis_x_m: limb.bone_semi_axis_x_m,
        bone_semi_axis_z_m: limb.bone_semi_axis_z_m,
        bone_offset_m: limb.bone_offset_m,
        fat_thickness_m: limb.fat_thickness_m,
        skin_thickness_m: limb.skin_thickness_m,
        elements_around: limb.elements_around,
        elements_along: limb.elements_along,
        muscle_elements: limb.muscle_elements,
        fat_elements: limb.fat_elements,
        skin_elements: limb.skin_elements,
        impact_angle_deg: limb.impact_angle_deg,
        impact_along_m: limb.impact_along_m,
        grading_around: limb.grading_around,
        grading_along: limb.grading_along,
        grading_muscle: limb.grading_muscle,
        uniform_within_m: limb.uniform_within_m,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn problems_point_at_the_fields_of_the_document() {
        let block = Generator::Block {
            min_m: [0.0; 3],
            max_m: [1.0, -1.0, 1.0],
            elements: [0, 1, 1],
            grading: Some([1.0, 1.0, 0.5]),
            grading_center_m: None,
        };
        let found = Recipe::new(&block).problems(&Pointer::root());
        let mut pointers: Vec<&str> = found.iter().map(|p| p.pointer.as_str()).collect();
        pointers.sort_unstable();
        assert_eq!(pointers, ["/elements/0", "/grading/2", "/grading_center_m/1", "/max_m/1"]);

        let ball = Generator::HollowBall {
            center_m: [0.0; 3],
            outer_radius_m: 1.0,
            inner_radius_m: 2.0,
            elements_around: u32::MAX,
            elements_through: u32::MAX,
        };
        let recipe = Recipe::new(&ball);
        assert_eq!(recipe.element_count(), u64::MAX);
        let pointers: Vec<_> = recipe.problems(&Pointer::root()).into_iter().map(|p| p.pointer).collect();
        assert_eq!(pointers, ["/inner_radius_m", ""]);

        let layer = LayerDocument { part: "fat".into(), thickness_m: -1.0, elements: 1 };
        let plate = Generator::LayeredBlock {
            top_center_m: [f64::NAN, 0.0, 0.0],
            size_m: [1.0; 2],
            layers: vec![layer],
            elements: [1; 2],
            grading: [1.0; 2],
            uniform_within_m: 0.0,
        };
        let found = Recipe::new(&plate).problems(&Pointer::root());
        let pointers: Vec<_> = found.iter().map(|p| p.pointer.as_str()).collect();
        assert_eq!(pointers, ["/top_center_m/0", "/layers/0/thickness_m"]);
    }
}
