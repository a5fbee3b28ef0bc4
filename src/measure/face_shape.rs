//! One face of the contact patch: its area vector, and its contributions to its corners.

use crate::mechanics::rigid::{Pose, Shape};
use crate::mechanics::tensor::{Mat3, Vec3};

/// Minimum cosine between a face's outward normal and the direction of the contact for the face to be in contact: 60°.
const TURNED: f64 = 0.5;

/// Minimum cosine between the face of a master and the direction of the whole contact: 80°.
const NOT_BESIDE: f64 = 0.17;

/// Corners without the repetition that marks a triangle.
pub(super) fn distinct(face: &[u32; 4]) -> &[u32] {
    if face[2] == face[3] { &face[..3] } else { face }
}

/// Corners of the bilinear quadrilateral.
const SIGNS: [[f64; 2]; 4] = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]];

/// Sampling points along each side of a face for its coverage by a projection.
const SAMPLES: usize = 8;
/// Largest factor of refinement of that sampling if the shape is smaller than the face.
const FINEST: f64 = 8.0;

/// Projection of a rigid body along the normal of the contact.
#[derive(Clone, Debug)]
pub(super) struct Shadow {
    /// Shape of the rigid body.
    pub shape: Shape,
    /// Position and orientation of the rigid body.
    pub pose: Pose,
    /// Unit normal of the contact.
    pub normal: Vec3,
    /// Unit normal in the axes of the body.
    pub direction: Vec3,
}

impl Shadow {
    fn covers(&self, x: &Vec3) -> bool {
        self.shape.is_met_by_line(&self.pose.local(x), &self.direction)
    }

    /// Extent of the body along a unit direction [m]; of a polyhedron at most twice that from its centre of mass.
    pub fn extent_along(&self, direction: &Vec3) -> f64 {
        let own = self.pose.orientation.inverse_transform_vector(direction).transpose();
        2.0 * self.shape.half_extent(&Mat3::from_rows(&[own; 3])).x
    }
}

/// Area of one face and its contributions to its corners.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct FaceShape {
    /// Outward area vector [m²].
    normal: Vec3,
    /// Norm of the area vector [m²].
    area: f64,
    /// ∫ N_a dA for each corner over the covered part [m²].
    areas: [f64; 4],
    /// ∫ N_a dA for each corner over the whole face [m²].
    whole: [f64; 4],
}

impl FaceShape {
    /// The face with these corners (global nodes) at their positions [m].
    pub fn new(face: &[u32; 4], position: &impl Fn(u32) -> Vec3) -> Self {
        let x = face.map(position);
        // Half the cross product of the diagonals is the area vector of a quadrilateral, and of a triangle (c = d).
        let normal = (x[2] - x[0]).cross(&(x[3] - x[1]));
        let areas = if face[2] == face[3] {
            let third = (x[1] - x[0]).cross(&(x[2] - x[0])).norm() / 6.0;
            [third, third, third, 0.0]
        } else {
            tributary_areas_of(&x, gauss_points().into_iter(), |_, dA| dA.norm())
        };
        Self { normal, area: normal.norm(), areas, whole: areas }
    }

    /// The part covered by a projection, which is convex; for a face beyond its rim as seen along the normal, since the
    /// rest may slope away.
    pub fn clipped(self, face: &[u32; 4], position: &impl Fn(u32) -> Vec3, shadow: &Shadow) -> Self {
        let x = face.map(position);
        if x.iter().all(|x| shadow.covers(x)) {
            return self;
        }
        // A shape much smaller than the face must not fall between the sampling points.
        let finer = (self.whole().sqrt() / shadow.shape.size()).ceil().clamp(1.0, FINEST);
        #[allow(clippy::cast_sign_loss)] // at least 1
        let samples = SAMPLES * finer as usize;
        let at = |i: usize| (2 * i + 1) as f64 / samples as f64 - 1.0;
        let places = (0..samples * samples).map(|i| [at(i % samples), at(i / samples)]);
        let weight = 4.0 / (samples * samples) as f64;
        let mut areas = tributary_areas_of(&x, places, |place, dA| {
            if shadow.covers(place) { weight * shadow.normal.dot(dA).abs() } else { 0.0 }
        });
        if face[2] == face[3] {
            areas[2] += std::mem::take(&mut areas[3]);
        }
        Self { areas, ..self }
    }

    /// Whether the outward normal opposes `n` by at least [`TURNED`]. At the rim of a flat end the lateral faces do not
    /// face the contact, and transmit no pressure.
    pub fn is_turned(&self, n: &Vec3) -> bool {
        -n.dot(&self.normal) > TURNED * self.area
    }

    /// Whether the face is in front of a contact with resultant normal `n`, not beside it: at the rim of a flat end,
    /// single contacts have oblique directions, which the lateral faces oppose.
    pub fn is_in_front(&self, n: &Vec3) -> bool {
        -n.dot(&self.normal) > NOT_BESIDE * self.area
    }

    /// ∫ N_a dA for one corner over the covered part, and over the whole face [m²].
    pub fn tributary_areas(&self, corner: usize) -> [f64; 2] {
        [self.areas[corner], self.whole[corner]]
    }

    /// ∫ dA over the whole face [m²].
    pub fn whole(&self) -> f64 {
        self.whole.iter().sum()
    }
}

/// ∫ N_a dA of a bilinear quadrilateral with the corners `x` [m], sampled in the unit square −1…1; `measure` weights a
/// sampling point [m] with its area vector [m²].
fn tributary_areas_of(
    x: &[Vec3; 4],
    places: impl Iterator<Item = [f64; 2]>,
    measure: impl Fn(&Vec3, &Vec3) -> f64,
) -> [f64; 4] {
    let mut areas = [0.0; 4];
    for [a, b] in places {
        let (mut place, mut along_a, mut along_b) = (Vec3::zeros(), Vec3::zeros(), Vec3::zeros());
        let N = SIGNS.map(|s| 0.25 * (1.0 + s[0] * a) * (1.0 + s[1] * b));
        for ((x, s), N) in x.iter().zip(SIGNS).zip(N) {
            place += x * N;
            along_a += x * (0.25 * s[0] * (1.0 + s[1] * b));
            along_b += x * (0.25 * s[1] * (1.0 + s[0] * a));
        }
        let dA = measure(&place, &along_a.cross(&along_b));
        areas.iter_mut().zip(N).for_each(|(area, N)| *area += N * dA);
    }
    areas
}

/// The 2×2 Gauss points of the unit square −1…1.
fn gauss_points() -> [[f64; 2]; 4] {
    let g = 1.0 / 3f64.sqrt();
    SIGNS.map(|[a, b]| [g * a, g * b])
}
