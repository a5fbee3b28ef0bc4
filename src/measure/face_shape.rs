//! One face of the contact patch: its area vector, and what it gives to its corners.

use crate::mechanics::rigid::{Pose, Shape};
use crate::mechanics::tensor::Vec3;

/// Least cosine between a face's outward normal and the direction of the contact, for the face to press: 60°.
const TURNED: f64 = 0.5;

/// The same between the face of a master and the direction of the whole contact: 80°.
const NOT_BESIDE: f64 = 0.17;

/// Corners without the repetition that marks a triangle.
pub(super) fn distinct(face: &[u32; 4]) -> &[u32] {
    if face[2] == face[3] { &face[..3] } else { face }
}

/// Corners of the bilinear quadrilateral.
const SIGNS: [[f64; 2]; 4] = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]];

/// Places along each side of a face at which it is asked whether a shadow covers it.
const SAMPLES: usize = 8;
/// So many times more where the shape is smaller than the face.
const FINEST: f64 = 8.0;

/// What a rigid body covers for who looks along the normal of the contact.
#[derive(Clone, Copy, Debug)]
pub(super) struct Shadow {
    /// Its shape.
    pub shape: Shape,
    /// Where it is.
    pub pose: Pose,
    /// The unit normal.
    pub normal: Vec3,
    /// The same in its axes.
    pub direction: Vec3,
}

impl Shadow {
    fn covers(&self, x: &Vec3) -> bool {
        self.shape.is_met_by_line(&self.pose.local(x), &self.direction)
    }
}

/// What one face gives to its corners.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct FaceShape {
    /// Area vector, out of the face [m²].
    normal: Vec3,
    /// Its norm [m²].
    area: f64,
    /// ∫ N_a dA for each corner over what of it is covered [m²].
    shares: [f64; 4],
    /// The same over all of it [m²].
    whole: [f64; 4],
}

impl FaceShape {
    /// From its corners (global nodes) and where they are [m].
    pub fn new(face: &[u32; 4], position: &impl Fn(u32) -> Vec3) -> Self {
        let x = face.map(position);
        // Half the cross product of the diagonals is the area vector of a quadrilateral, and of a triangle (c = d).
        let normal = (x[2] - x[0]).cross(&(x[3] - x[1]));
        let shares = if face[2] == face[3] {
            let third = (x[1] - x[0]).cross(&(x[2] - x[0])).norm() / 6.0;
            [third, third, third, 0.0]
        } else {
            shares_of(&x, gauss_points().into_iter(), |_, dA| dA.norm())
        };
        Self { normal, area: normal.norm(), shares, whole: shares }
    }

    /// What a shadow, which is convex, covers of it; of a face beyond its rim as it is seen along the normal, since the rest of it may hang down.
    pub fn clipped(self, face: &[u32; 4], position: &impl Fn(u32) -> Vec3, shadow: &Shadow) -> Self {
        let x = face.map(position);
        if x.iter().all(|x| shadow.covers(x)) {
            return self;
        }
        // A shape much smaller than the face must not lie between the places.
        let finer = (self.whole().sqrt() / shadow.shape.size()).ceil().clamp(1.0, FINEST);
        #[allow(clippy::cast_sign_loss)] // at least 1
        let samples = SAMPLES * finer as usize;
        let at = |i: usize| (2 * i + 1) as f64 / samples as f64 - 1.0;
        let places = (0..samples * samples).map(|i| [at(i % samples), at(i / samples)]);
        let weight = 4.0 / (samples * samples) as f64;
        let mut shares = shares_of(&x, places, |place, dA| {
            if shadow.covers(place) { weight * shadow.normal.dot(dA).abs() } else { 0.0 }
        });
        if face[2] == face[3] {
            shares[2] += std::mem::take(&mut shares[3]);
        }
        Self { shares, ..self }
    }

    /// Whether its outward normal opposes `n` by at least [`TURNED`]. At the rim of a flat end the sides of the body are not
    /// turned to the contact, and press on nothing.
    pub fn is_turned(&self, n: &Vec3) -> bool {
        -n.dot(&self.normal) > TURNED * self.area
    }

    /// Whether it is not beside a contact that presses along `n` as a whole: at the rim of a flat end, where the directions of single contacts
    /// are oblique, the sides are turned to these.
    pub fn is_in_front(&self, n: &Vec3) -> bool {
        -n.dot(&self.normal) > NOT_BESIDE * self.area
    }

    /// ∫ N_a dA for one corner over what of the face is covered, and over all of it [m²].
    pub fn tributary_shares(&self, corner: usize) -> [f64; 2] {
        [self.shares[corner], self.whole[corner]]
    }

    /// ∫ dA over all of it [m²].
    pub fn whole(&self) -> f64 {
        self.whole.iter().sum()
    }
}

/// ∫ N_a dA of a bilinear quadrilateral with the corners `x` [m], by places in the unit square −1…1; `measure` is what a place [m] with
/// its area vector [m²] counts.
fn shares_of(
    x: &[Vec3; 4],
    places: impl Iterator<Item = [f64; 2]>,
    measure: impl Fn(&Vec3, &Vec3) -> f64,
) -> [f64; 4] {
    let mut shares = [0.0; 4];
    for [a, b] in places {
        let (mut place, mut along_a, mut along_b) = (Vec3::zeros(), Vec3::zeros(), Vec3::zeros());
        let N = SIGNS.map(|s| 0.25 * (1.0 + s[0] * a) * (1.0 + s[1] * b));
        for ((x, s), N) in x.iter().zip(SIGNS).zip(N) {
            place += x * N;
            along_a += x * (0.25 * s[0] * (1.0 + s[1] * b));
            along_b += x * (0.25 * s[1] * (1.0 + s[0] * a));
        }
        let dA = measure(&place, &along_a.cross(&along_b));
        shares.iter_mut().zip(N).for_each(|(share, N)| *share += N * dA);
    }
    shares
}

/// The 2×2 Gauss points of the unit square −1…1.
fn gauss_points() -> [[f64; 2]; 4] {
    let g = 1.0 / 3f64.sqrt();
    SIGNS.map(|[a, b]| [g * a, g * b])
}
