//! The convex hull of a closed triangulated surface as a rigid shape, with the mass and the principal axes of what the surface encloses.

use super::pose::Rotation;
use crate::tensor::{Mat3, Vec3};
use nalgebra::SymmetricEigen;
use parry3d_f64::math::Vector;
use parry3d_f64::shape::ConvexPolyhedron;
use parry3d_f64::transformation::try_convex_hull;

/// Most planes of a hull: every node near the body is compared with each of them in every step.
pub const MOST_PLANES: usize = 600;
/// Distance from a plane, relative to the size of the shape, that is rounding.
const ROUNDING: f64 = 1e-6;
/// Cosine below which two planes differ.
const SAME_PLANE: f64 = 1.0 - 1e-12;
/// Square of the sine between a plane and those that hold a point below which it is none of its own.
const PARALLEL: f64 = 1e-14;
/// Distance from a plane, relative to the inner radius, at which a point is behind it.
const EXACT: f64 = 1e-13;
/// Most changes of the planes that hold a point; a few are usual.
const MOST_CHANGES: usize = 100;

/// A convex polyhedron in the principal axes, about the centre of mass, of the surface that it was made of.
#[derive(Clone, Debug, PartialEq)]
pub struct Polyhedron {
    /// Its corners [m].
    corners: Vec<Vec3>,
    /// Triangles on it, counter-clockwise seen from outside.
    triangles: Vec<[u32; 3]>,
    /// Outward unit normals of its planes, and their distances from the origin [m].
    planes: Vec<(Vec3, f64)>,
    /// Distance of the mean of its corners from the nearest plane [m].
    inner_radius: f64,
    /// Smallest distance between a plane and the farthest corner [m].
    thickness: f64,
    /// Volume and moments of inertia per mass of what the surface encloses [m³], [m²].
    volume: f64,
    inertia_per_mass: Vec3,
    /// The same hull as parry has it, for its distance queries.
    parry: ConvexPolyhedron,
}

/// A polyhedron, and where the surface had it.
#[derive(Clone, Debug, PartialEq)]
pub struct Solid {
    /// The hull in principal axes.
    pub hull: Polyhedron,
    /// Centre of mass of what the surface encloses, in its own axes [m].
    pub centre: Vec3,
    /// Rotation from the principal axes to those of the surface.
    pub axes: Rotation,
    /// Volume of the hull over that of the surface [-]: 1 for a convex surface.
    pub hull_ratio: f64,
}

/// Why there is no hull of a surface.
#[derive(Clone, Debug, PartialEq)]
pub enum NoHull {
    /// It has no volume, or corners too close to each other.
    Flat(String),
    /// It has more than [`MOST_PLANES`] planes.
    ManyPlanes,
}

impl<T: Into<String>> From<T> for NoHull {
    fn from(reason: T) -> Self {
        Self::Flat(reason.into())
    }
}

/// Volume, first and second moments of what closed triangles enclose, about the origin.
///
/// Each triangle is the base of a tetrahedron at the origin, of signed volume V: ∫ x = V/4 Σ x_a,
/// ∫ x xᵀ = V/20 (Σ x_a x_aᵀ + s sᵀ), s the sum of its corners.
fn moments(x: &[Vec3], triangles: &[[u32; 3]]) -> (f64, Vec3, Mat3) {
    let (mut volume, mut first, mut second) = (0.0, Vec3::zeros(), Mat3::zeros());
    for triangle in triangles {
        let corners = triangle.map(|node| x[node as usize]);
        let of_triangle = corners[0].dot(&corners[1].cross(&corners[2])) / 6.0;
        let sum: Vec3 = corners.iter().sum();
        volume += of_triangle;
        first += sum * (of_triangle / 4.0);
        let squares: Mat3 = corners.iter().map(|x| x * x.transpose()).sum();
        second += (squares + sum * sum.transpose()) * (of_triangle / 20.0);
    }
    (volume, first, second)
}

impl Solid {
    /// Convex hull of a closed surface of triangles, counter-clockwise seen from outside; positions in metres.
    ///
    /// # Errors
    /// Why it has no hull.
    pub fn new(x: &[Vec3], triangles: &[[u32; 3]]) -> Result<Self, NoHull> {
        // About a point of the surface, so that no digits are lost where it is far from the origin.
        let origin = *x.first().ok_or("it has no points")?;
        let near: Vec<Vec3> = x.iter().map(|x| x - origin).collect();
        let (volume, first, second) = moments(&near, triangles);
        let size = near.iter().map(Vec3::norm).fold(0.0, f64::max);
        if !(volume > ROUNDING * ROUNDING * size.powi(3)) {
            return Err(format!("it encloses a volume of {volume:.4e} m³").into());
        }
        let centre = first / volume;
        let central = second / volume - centre * centre.transpose();
        let inertia = Mat3::identity() * central.trace() - central;
        let (axes, inertia_per_mass) = principal(&inertia);
        let local: Vec<Vec3> = near.iter().map(|x| axes.inverse_transform_vector(&(x - centre))).collect();
        let hull = Polyhedron::around(&local, (volume, inertia_per_mass))?;
        let hull_ratio = moments(&hull.corners, &hull.triangles).0 / volume;
        Ok(Self { hull, centre: centre + origin, axes, hull_ratio })
    }
}

/// Principal axes, as a rotation to them, and moments about them in ascending order. Where axes are principal already, they stay.
fn principal(inertia: &Mat3) -> (Rotation, Vec3) {
    let off = inertia - Mat3::from_diagonal(&inertia.diagonal());
    if off.amax() <= 1e-9 * inertia.amax() {
        return (Rotation::identity(), inertia.diagonal());
    }
    let SymmetricEigen { eigenvectors, eigenvalues } = inertia.symmetric_eigen();
    let mut order = [0, 1, 2];
    order.sort_by(|a, b| eigenvalues[*a].total_cmp(&eigenvalues[*b]));
    let [e1, e2] = [order[0], order[1]].map(|i| eigenvectors.column(i).into_owned());
    let axes = Mat3::from_columns(&[e1, e2, e1.cross(&e2)]);
    let rotation = nalgebra::Rotation3::from_matrix_unchecked(axes);
    (Rotation::from_rotation_matrix(&rotation), Vec3::from(order.map(|i| eigenvalues[i])))
}

impl Polyhedron {
    /// The hull of points, with the volume and the moments of inertia per mass of the body.
    fn around(points: &[Vec3], (volume, inertia_per_mass): (f64, Vec3)) -> Result<Self, NoHull> {
        let vectors: Vec<Vector> = points.iter().map(|x| Vector::new(x.x, x.y, x.z)).collect();
        let (hull, triangles) = try_convex_hull(&vectors).map_err(|error| error.to_string())?;
        let parry = ConvexPolyhedron::from_convex_mesh(hull.clone(), &triangles)
            .ok_or("the corners of its hull are too close to each other")?;
        let corners: Vec<Vec3> = hull.iter().map(|v| Vec3::new(v.x, v.y, v.z)).collect();
        let size = corners.iter().map(Vec3::norm).fold(0.0, f64::max);
        let mut planes: Vec<(Vec3, f64)> = Vec::new();
        for triangle in &triangles {
            let [a, b, c] = triangle.map(|corner| corners[corner as usize]);
            // Slivers lie in the planes of their neighbours.
            let area = (b - a).cross(&(c - a));
            if let Some(normal) = area.try_normalize(ROUNDING * size * size)
                && !planes.iter().any(|(other, _)| other.dot(&normal) > SAME_PLANE)
            {
                let offset = corners.iter().map(|x| normal.dot(x)).fold(f64::NEG_INFINITY, f64::max);
                if (offset - normal.dot(&a)).abs() > ROUNDING * size {
                    return Err("its hull is not convex after rounding".into());
                }
                if planes.len() == MOST_PLANES {
                    return Err(NoHull::ManyPlanes);
                }
                planes.push((normal, offset));
            }
        }
        let middle = corners.iter().sum::<Vec3>() / corners.len() as f64;
        let inside = |(normal, offset): &(Vec3, f64)| offset - normal.dot(&middle);
        let width = |(normal, offset): &(Vec3, f64)| {
            offset - corners.iter().map(|x| normal.dot(x)).fold(f64::INFINITY, f64::min)
        };
        let inner_radius = planes.iter().map(inside).fold(f64::INFINITY, f64::min);
        let thickness = planes.iter().map(width).fold(f64::INFINITY, f64::min);
        if planes.len() < 4 || !(inner_radius > ROUNDING * size) {
            return Err("its hull has no thickness".into());
        }
        Ok(Self { corners, triangles, planes, inner_radius, thickness, volume, inertia_per_mass, parry })
    }

    /// Corners in the axes of the body [m].
    pub fn corners(&self) -> &[Vec3] {
        &self.corners
    }
    /// Triangles of the hull, counter-clockwise seen from outside.
    pub fn triangles(&self) -> &[[u32; 3]] {
        &self.triangles
    }
    /// Number of planes, coplanar triangles counted once.
    pub fn plane_count(&self) -> usize {
        self.planes.len()
    }
    /// The hull as parry has it, for queries against other shapes.
    pub fn parry(&self) -> &ConvexPolyhedron {
        &self.parry
    }
    /// Volume of the body [m³].
    pub fn volume(&self) -> f64 {
        self.volume
    }
    /// Principal moments of inertia per mass [m²].
    pub fn inertia_per_mass(&self) -> Vec3 {
        self.inertia_per_mass
    }
    /// Smallest distance between a plane and the farthest corner [m].
    pub fn thickness(&self) -> f64 {
        self.thickness
    }
    /// Radius of the ball about the centre of mass that contains it [m].
    pub fn outer_radius(&self) -> f64 {
        self.corners.iter().map(Vec3::norm).fold(0.0, f64::max)
    }
    /// Half extents along directions, the columns of `axes` transposed, of a box about the centre of mass [m].
    pub fn half_extent(&self, axes: &Mat3) -> Vec3 {
        self.corners.iter().fold(Vec3::zeros(), |most, x| most.sup(&(axes * x).abs()))
    }

    /// Signed distance of a point [m], negative inside, and the outward normal at the nearest point of the surface.
    pub fn eval_distance(&self, p: &Vec3) -> (f64, Vec3) {
        self.eval_core_distance(p, 0.0)
    }

    /// As [`Self::eval_distance`], for the polyhedron whose planes are further inwards by `less` [m].
    pub fn eval_core_distance(&self, p: &Vec3, less: f64) -> (f64, Vec3) {
        let highest = self.highest_plane(p, less);
        if highest.0 <= 0.0 {
            return highest;
        }
        let arm = p - self.nearest_in_core(p, less);
        // On the surface, up to rounding, the plane has the normal.
        arm.try_normalize(ROUNDING * self.inner_radius).map_or(highest, |normal| (arm.norm(), normal))
    }

    /// The plane that a point is farthest outside of, or nearest to: its distance [m] and its normal.
    fn highest_plane(&self, p: &Vec3, less: f64) -> (f64, Vec3) {
        let mut highest = (f64::NEG_INFINITY, Vec3::x());
        for (normal, offset) in &self.planes {
            let height = normal.dot(p) - offset + less;
            if height > highest.0 {
                highest = (height, *normal);
            }
        }
        highest
    }

    /// The nearest point behind all planes, moved inwards by `less` [m], by the dual method of D. Goldfarb and A. Idnani, Math.
    /// Program. 27 (1983) 1–33: x = p − Σ λ n over at most three planes that hold it, λ > 0, to which the plane that x is farthest
    /// outside of is added until there is none.
    fn nearest_in_core(&self, p: &Vec3, less: f64) -> Vec3 {
        let (mut x, mut holding) = (*p, Holding::default());
        for _ in 0..MOST_CHANGES {
            let (height, normal) = self.highest_plane(&x, less);
            if height <= EXACT * self.inner_radius {
                break;
            }
            x -= holding.add(&normal, height);
        }
        x
    }

    /// Whether a line through `p` along `d` meets it.
    pub fn is_met_by_line(&self, p: &Vec3, d: &Vec3) -> bool {
        let (mut from, mut to) = (f64::NEG_INFINITY, f64::INFINITY);
        for (normal, offset) in &self.planes {
            let (slope, left) = (normal.dot(d), offset - normal.dot(p));
            if slope > 0.0 {
                to = to.min(left / slope);
            } else if slope < 0.0 {
                from = from.max(left / slope);
            } else if left < 0.0 {
                return false;
            }
        }
        from <= to
    }
}

/// Up to three planes that hold a point: normals, and the λ of each [m].
#[derive(Clone, Copy, Debug, Default)]
struct Holding {
    count: usize,
    normals: [Vec3; 3],
    forces: [f64; 3],
}

impl Holding {
    /// Adds the plane of a unit normal that the point is outside of by `height` [m], without those that hold no longer. Returns the
    /// way that the point moves against it [m].
    fn add(&mut self, normal: &Vec3, mut height: f64) -> Vec3 {
        let (mut way, mut force) = (Vec3::zeros(), 0.0);
        loop {
            // As the new plane pushes by a unit, the point moves by z, and those of the others push less by `relief`.
            let (relief, z) = self.split(normal);
            let slope = z.norm_squared();
            let full = if slope > PARALLEL { height / slope } else { f64::INFINITY };
            let ends = (0..self.count).filter(|i| relief[*i] > 0.0).map(|i| (self.forces[i] / relief[i], i));
            let first = ends.min_by(|a, b| a.0.total_cmp(&b.0)).filter(|(end, _)| *end < full);
            let step = first.map_or(full, |(end, _)| end);
            if !step.is_finite() {
                return way;
            }
            for i in 0..self.count {
                self.forces[i] -= step * relief[i];
            }
            force += step;
            if slope > PARALLEL {
                way += z * step;
                height -= slope * step;
            }
            let Some((_, first)) = first else {
                if self.count < 3 {
                    (self.normals[self.count], self.forces[self.count]) = (*normal, force);
                    self.count += 1;
                }
                return way;
            };
            self.count -= 1;
            self.normals.swap(first, self.count);
            self.forces.swap(first, self.count);
        }
    }

    /// A vector as a sum of the normals, with these factors, and what is orthogonal to them.
    fn split(&self, v: &Vec3) -> ([f64; 3], Vec3) {
        let [a, b, c] = &self.normals;
        match self.count {
            0 => ([0.0; 3], *v),
            1 => ([v.dot(a), 0.0, 0.0], v - a * v.dot(a)),
            count => {
                let c = if count == 3 { *c } else { a.cross(b) };
                let (to_a, to_b, to_c) = (b.cross(&c), c.cross(a), a.cross(b));
                let parts = [to_a, to_b, to_c].map(|to| v.dot(&to) / to_a.dot(a));
                (parts, if count == 3 { Vec3::zeros() } else { c * parts[2] })
            }
        }
    }
}

#[cfg(test)]
mod tests;
