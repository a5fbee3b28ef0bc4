//! A segment of a limb: muscle around a bone hole, under fat and skin.

use super::ellipse::Ellipse;
use super::grading::{Grading, graded};
use super::parameters::{Checks, refuse};
use super::{faceting_note, node_set};
use crate::mechanics::tensor::Vec3;
use crate::mesh::defaults::{is_zero_length, one};
use crate::mesh::{CellKind, ELEMENTS_OF_A_TASK, Mesh, MeshError, ParameterProblem};
use nalgebra::Vector2;
use rayon::prelude::*;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::f64::consts::PI;

/// Names of the parts, from the inside.
const PARTS: [&str; 3] = ["muscle", "fat", "skin"];

/// Largest rotation of the surface normal across one element around the limb [°].
const MAX_TURN_DEG: f64 = 75.0;

/// A limb along y with an elliptic section: from the inside bone hole, muscle, fat, skin; finer towards the impact.
///
/// Fat and skin have constant thickness; muscle fills the rest around the bone. The bone is a hole with the node set `bone`
/// on its surface. Parts `muscle`, `fat` and `skin`; node sets `bone`, `skin_outer`, `end_low` (lower y) and `end_high`.
/// Material axes: e1 along the limb (+y), e2 around it, e3 outwards.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct LimbSegment {
    /// Centre of the segment, on its axis [m].
    #[serde(default)]
    pub center_m: [f64; 3],
    /// Outer semi-axis of the section along x, skin included [m].
    pub semi_axis_x_m: f64,
    /// Outer semi-axis of the section along z, skin included [m].
    pub semi_axis_z_m: f64,
    /// Length along y [m].
    pub length_m: f64,
    /// Semi-axis of the bone along x [m].
    pub bone_semi_axis_x_m: f64,
    /// Semi-axis of the bone along z [m].
    pub bone_semi_axis_z_m: f64,
    /// Offset of the bone axis from the limb axis along x and z [m].
    #[serde(default)]
    pub bone_offset_m: [f64; 2],
    /// Thickness of the fat layer [m].
    pub fat_thickness_m: f64,
    /// Thickness of the skin layer [m].
    pub skin_thickness_m: f64,
    /// Elements around the section.
    pub elements_around: u32,
    /// Elements along the limb.
    pub elements_along: u32,
    /// Layers of elements through the muscle.
    pub muscle_elements: u32,
    /// Layers of elements through the fat.
    pub fat_elements: u32,
    /// Layers of elements through the skin.
    pub skin_elements: u32,
    /// Angular position of the impact on the section, from +z towards +x [degree]; elements are smallest there.
    #[serde(default)]
    pub impact_angle_deg: f64,
    /// Position of the impact along the limb, y from the middle [m]; elements are smallest there.
    #[serde(default)]
    pub impact_along_m: f64,
    /// Size ratio of the largest to the smallest element around the limb.
    #[serde(default = "one")]
    pub grading_around: f64,
    /// Size ratio of the largest to the smallest element along the limb.
    #[serde(default = "one")]
    pub grading_along: f64,
    /// Thickness ratio of the innermost to the outermost layer of the muscle.
    #[serde(default = "one")]
    pub grading_muscle: f64,
    /// Distance from the impact, along and around the limb, within which the elements are uniform and smallest [m];
    /// somewhat more than the radius of the contact patch.
    #[serde(default, skip_serializing_if = "is_zero_length")]
    pub uniform_within_m: f64,
}

impl Default for LimbSegment {
    /// Approximately a thigh, with 1 680 elements of about 5 mm where it is hit from above (+z).
    fn default() -> Self {
        Self {
            center_m: [0.0; 3],
            semi_axis_x_m: 0.075,
            semi_axis_z_m: 0.070,
            length_m: 0.2,
            bone_semi_axis_x_m: 0.014,
            bone_semi_axis_z_m: 0.014,
            bone_offset_m: [0.0, 0.0],
            fat_thickness_m: 0.008,
            skin_thickness_m: 0.002,
            elements_around: 20,
            elements_along: 12,
            muscle_elements: 4,
            fat_elements: 2,
            skin_elements: 1,
            impact_angle_deg: 0.0,
            impact_along_m: 0.0,
            grading_around: 12.0,
            grading_along: 8.0,
            grading_muscle: 4.0,
            uniform_within_m: 0.0,
        }
    }
}

impl LimbSegment {
    /// All parameters out of range.
    pub fn problems(&self) -> Vec<ParameterProblem> {
        let mut checks = Checks::default();
        checks.finite("center_m", &self.center_m);
        for (field, length) in [
            ("semi_axis_x_m", self.semi_axis_x_m),
            ("semi_axis_z_m", self.semi_axis_z_m),
            ("length_m", self.length_m),
            ("bone_semi_axis_x_m", self.bone_semi_axis_x_m),
            ("bone_semi_axis_z_m", self.bone_semi_axis_z_m),
            ("fat_thickness_m", self.fat_thickness_m),
            ("skin_thickness_m", self.skin_thickness_m),
        ] {
            checks.positive_length(field, length);
        }
        checks.count("elements_around", self.elements_around, 6);
        checks.count("elements_along", self.elements_along, 1);
        checks.count("muscle_elements", self.muscle_elements, 1);
        checks.count("fat_elements", self.fat_elements, 1);
        checks.count("skin_elements", self.skin_elements, 1);
        checks.grading("grading_around", self.grading_around);
        checks.grading("grading_along", self.grading_along);
        checks.grading("grading_muscle", self.grading_muscle);
        checks.distance("uniform_within_m", self.uniform_within_m);
        checks.budget(self.element_count());
        for (i, offset) in self.bone_offset_m.into_iter().enumerate() {
            let remedy = "give a distance in metres";
            checks.require(offset.is_finite(), format!("bone_offset_m[{i}]"), offset, "finite", remedy);
        }
        let (angle, along, half) = (self.impact_angle_deg, self.impact_along_m, self.length_m / 2.0);
        checks.require(angle.is_finite(), "impact_angle_deg", angle, "finite", "give an angle in degrees");
        let limit = format!("between {} and {half}", -half);
        checks.require(
            along.abs() <= half,
            "impact_along_m",
            along,
            limit,
            "strike the limb between its ends",
        );
        // The shape of the section is only checked for valid parameters.
        if checks.none() {
            self.check_section(&mut checks);
        }
        checks.into_problems()
    }

    /// Checks that fat and skin do not fold, that the bone lies inside the muscle, and that element rotations are small
    /// enough.
    fn check_section(&self, checks: &mut Checks) {
        let (outer, cover) = (self.outer(), self.fat_thickness_m + self.skin_thickness_m);
        let (fat, skin) =
            (("fat_thickness_m", self.fat_thickness_m), ("skin_thickness_m", self.skin_thickness_m));
        // The thicker one is the mistake.
        let ((field, value), (_, other)) = if fat.1 >= skin.1 { (fat, skin) } else { (skin, fat) };
        checks.require(
            cover < outer.min_curvature_radius(),
            field,
            value,
            format!("< {}", outer.min_curvature_radius() - other),
            "fat and skin together must be thinner than the smallest radius of curvature of the section",
        );
        if !checks.none() {
            return;
        }
        // Smallest muscle thickness between bone and fat, on the rays of a fine section.
        let least =
            (0..720).map(|i| self.muscle_thickness(PI * f64::from(i) / 360.0)).fold(f64::INFINITY, f64::min);
        checks.require(
            least > 0.0,
            "bone_semi_axis_x_m",
            self.bone_semi_axis_x_m,
            format!("small enough to stay inside the muscle, beyond which it extends by {} m", -least),
            "reduce the bone, or move it by bone_offset_m",
        );
        let normals: Vec<_> = self.stations().iter().map(|&tau| outer.normal(tau)).collect();
        let turn = (0..normals.len())
            .map(|i| normals[i].dot(&normals[(i + 1) % normals.len()]).clamp(-1.0, 1.0).acos().to_degrees())
            .fold(0.0, f64::max);
        checks.require(
            turn <= MAX_TURN_DEG,
            "elements_around",
            f64::from(self.elements_around),
            format!("enough that no element turns by more than {MAX_TURN_DEG}° (one turns by {turn:.0}°)"),
            "give more elements around, or lower grading_around",
        );
    }

    /// Number of elements of the mesh.
    pub fn element_count(&self) -> u64 {
        let layers =
            u64::from(self.muscle_elements) + u64::from(self.fat_elements) + u64::from(self.skin_elements);
        layers.saturating_mul(u64::from(self.elements_around)).saturating_mul(u64::from(self.elements_along))
    }

    /// For each count, whether even numbers keep elements from extending across the middle of the body.
    pub fn counts_across(&self) -> Vec<bool> {
        vec![true, true, false, false, false]
    }

    /// All element counts, for modification.
    pub fn counts_mut(&mut self) -> Vec<&mut u32> {
        vec![
            &mut self.elements_around,
            &mut self.elements_along,
            &mut self.muscle_elements,
            &mut self.fat_elements,
            &mut self.skin_elements,
        ]
    }

    /// Impact point on the exact skin surface [m], and its outward normal.
    pub fn impact_point(&self) -> (Vec3, Vec3) {
        let tau = self.outer().parameter_at(self.impact_angle_deg.to_radians());
        let (p, n) = (self.outer().point(tau), self.outer().normal(tau));
        (Vec3::from(self.center_m) + Vec3::new(p.x, self.impact_along_m, p.y), Vec3::new(n.x, 0.0, n.y))
    }

    /// Exact volumes of muscle, fat and skin [m³]: areas between offset ellipses times the length.
    pub fn exact_volumes_m3(&self) -> [f64; 3] {
        let outer = self.outer();
        let bone = PI * self.bone_semi_axis_x_m * self.bone_semi_axis_z_m;
        let under_skin = outer.offset_area(self.skin_thickness_m);
        let under_fat = outer.offset_area(self.skin_thickness_m + self.fat_thickness_m);
        [under_fat - bone, under_skin - under_fat, outer.offset_area(0.0) - under_skin]
            .map(|a| a * self.length_m)
    }

    /// Generates the mesh section by section along y; within each, column by column around, from the bone outwards.
    ///
    /// # Errors
    /// `Parameters` with all problems of [`Self::problems`].
    pub fn generate(&self) -> Result<Mesh, MeshError> {
        refuse("limb_segment", self.problems())?;
        let section: Vec<Vec<Vector2<f64>>> = self.stations().iter().map(|&tau| self.column(tau)).collect();
        let half = self.length_m / 2.0;
        let along = Grading { ratio: self.grading_along, uniform_within: self.uniform_within_m };
        let sections = graded(-half, half, self.impact_along_m, along, self.elements_along);
        let layers = self.muscle_elements + self.fat_elements + self.skin_elements;
        let around = self.elements_around;

        let mut mesh = Mesh { parts: PARTS.map(String::from).to_vec(), ..Mesh::default() };
        for &y in &sections {
            let place = |p: &Vector2<f64>| Vec3::from(self.center_m) + Vec3::new(p.x, y, p.y);
            mesh.nodes.extend(section.iter().flatten().map(place));
        }
        let node = |j: u32, i: u32, k: u32| (j * around + i % around) * (layers + 1) + k;
        for j in 0..self.elements_along {
            for i in 0..around {
                for k in 0..layers {
                    // ξ along the limb, η around it, ζ outwards: the same right-handed triad as the material axes.
                    let face =
                        |k| [node(j, i, k), node(j + 1, i, k), node(j + 1, i + 1, k), node(j, i + 1, k)];
                    let ([a, b, c, d], [e, f, g, h]) = (face(k), face(k + 1));
                    mesh.cells.push(CellKind::Hex8, &[a, b, c, d, e, f, g, h]);
                    mesh.part_of.push(self.part_of_layer(k));
                }
            }
        }
        let axes = |element| material_axes(&mesh.cells.get(element).points(&mesh.nodes));
        let elements = (0..mesh.cells.len()).into_par_iter().with_min_len(ELEMENTS_OF_A_TASK);
        mesh.axes = elements.map(axes).collect();

        let last = self.elements_along;
        let through = |k: u32| (0..=last).flat_map(move |j| (0..around).map(move |i| node(j, i, k)));
        let across = |j: u32| (0..around).flat_map(move |i| (0..=layers).map(move |k| node(j, i, k)));
        mesh.node_sets.insert("bone".into(), node_set(through(0)));
        mesh.node_sets.insert("skin_outer".into(), node_set(through(layers)));
        mesh.node_sets.insert("end_low".into(), node_set(across(0)));
        mesh.node_sets.insert("end_high".into(), node_set(across(last)));
        for (part, exact) in PARTS.into_iter().zip(self.exact_volumes_m3()) {
            mesh.notes.push(faceting_note(part, mesh.part_volume_m3(part), exact));
        }
        Ok(mesh)
    }

    /// The outer ellipse of the section.
    fn outer(&self) -> Ellipse {
        Ellipse { x: self.semi_axis_x_m, z: self.semi_axis_z_m }
    }

    /// Parameters τ of the columns around the section, descending from opposite the impact: from +z over −x, the direction
    /// of e2.
    fn stations(&self) -> Vec<f64> {
        let impact = self.outer().parameter_at(self.impact_angle_deg.to_radians());
        // Arc length along the surface, converted to an angle at the impact.
        let uniform_within = self.uniform_within_m / self.outer().speed(impact);
        let grading = Grading { ratio: self.grading_around, uniform_within };
        let mut turns = graded(-PI, PI, 0.0, grading, self.elements_around);
        turns.pop();
        turns.iter().map(|turn| impact - turn).collect()
    }

    /// End of the column at τ in the muscle: on the normal of the outer ellipse, below fat and skin.
    fn muscle_outer(&self, tau: f64) -> Vector2<f64> {
        self.outer().point(tau) - self.outer().normal(tau) * (self.fat_thickness_m + self.skin_thickness_m)
    }

    /// End of the column at τ on the bone: on the ray from the bone axis to [`Self::muscle_outer`]. Rays from one point
    /// never cross, so the muscle cannot fold wherever the bone lies.
    fn bone_surface(&self, tau: f64) -> Vector2<f64> {
        let axis = Vector2::from(self.bone_offset_m);
        let ray = (self.muscle_outer(tau) - axis).normalize();
        axis + ray * self.bone().radius_along(&ray)
    }

    /// Muscle thickness along the column at τ [m]; negative where the bone, or its axis, is outside.
    fn muscle_thickness(&self, tau: f64) -> f64 {
        let axis = Vector2::from(self.bone_offset_m);
        let ray = self.muscle_outer(tau) - axis;
        let thickness = ray.norm() - (self.bone_surface(tau) - axis).norm();
        // The muscle is convex: the axis is inside if it lies behind every tangent.
        thickness.min(ray.dot(&self.outer().normal(tau)))
    }

    /// The ellipse of the bone, about its own axis.
    fn bone(&self) -> Ellipse {
        Ellipse { x: self.bone_semi_axis_x_m, z: self.bone_semi_axis_z_m }
    }

    /// Points (x, z) of the column at τ, from the bone outwards.
    fn column(&self, tau: f64) -> Vec<Vector2<f64>> {
        let (bone, muscle) = (self.bone_surface(tau), self.muscle_outer(tau));
        let (skin, normal) = (self.outer().point(tau), self.outer().normal(tau));
        let under_skin = skin - normal * self.skin_thickness_m;
        let fractions = graded(0.0, 1.0, 1.0, Grading::from_point(self.grading_muscle), self.muscle_elements);
        let mut column: Vec<_> = fractions.iter().map(|f| bone.lerp(&muscle, *f)).collect();
        let even = |from: Vector2<f64>, to: Vector2<f64>, count: u32| {
            (1..=count).map(move |i| from.lerp(&to, f64::from(i) / f64::from(count)))
        };
        column.extend(even(muscle, under_skin, self.fat_elements));
        column.extend(even(under_skin, skin, self.skin_elements));
        column
    }

    /// Part of layer `k` from the bone, as an index into [`PARTS`].
    fn part_of_layer(&self, k: u32) -> u32 {
        u32::from(k >= self.muscle_elements) + u32::from(k >= self.muscle_elements + self.fat_elements)
    }
}

/// Axes of one element: e1 = +y along the limb, e2 along the mid-line of the element around the limb, e3 = e1 × e2
/// outwards.
fn material_axes(corners: &[Vec3]) -> [Vec3; 3] {
    let middle = |ids: [usize; 4]| ids.iter().map(|&i| corners[i]).sum::<Vec3>() / 4.0;
    let around = middle([2, 3, 6, 7]) - middle([0, 1, 4, 5]);
    let e1 = Vec3::y();
    let e2 = (around - e1 * around.dot(&e1)).normalize();
    [e1, e2, e1.cross(&e2)]
}
