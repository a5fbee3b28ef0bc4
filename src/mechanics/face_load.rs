//! Follower pressure on a face of four nodes, and loads of fixed direction.
//!
//! On the bilinear face x(ξ, η) with outward normal `x,ξ × x,η` a pressure p gives
//!
//! ```text
//! f_a = −p ∫ N_a (x,ξ × x,η) dξ dη          K_ab = −∂f_a/∂x_b = p ∫ N_a ([x,ξ]× N_b,η − [x,η]× N_b,ξ) dξ dη
//! ```
//!
//! (Hibbitt 1979; Bonet & Wood 2008, section 8.5). The integrand is at most quadratic along each axis, so 2×2 Gauss
//! points are exact. The sum of K over a surface is symmetric where the surface is closed, or where its edge is fixed
//! (Schweizerhof & Ramm 1984); the contribution of a free edge is not.

use super::tensor::{Mat3, Vec3};

/// Gauss points of a face: shape functions with their derivatives along ξ and η; the weights are 1.
fn points() -> [[(f64, f64, f64); 4]; 4] {
    const CORNERS: [(f64, f64); 4] = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)];
    let place = 3.0_f64.sqrt().recip();
    CORNERS.map(|(xi, eta)| {
        CORNERS.map(|(a, b)| {
            let (on_xi, on_eta) = (1.0 + a * xi * place, 1.0 + b * eta * place);
            (0.25 * on_xi * on_eta, 0.25 * a * on_eta, 0.25 * b * on_xi)
        })
    })
}

/// `x,ξ` and `x,η` at a point [m].
fn tangents(x: &[Vec3; 4], point: &[(f64, f64, f64); 4]) -> (Vec3, Vec3) {
    let sum =
        |slope: fn(&(f64, f64, f64)) -> f64| x.iter().zip(point).map(|(x, n)| x * slope(n)).sum::<Vec3>();
    (sum(|n| n.1), sum(|n| n.2))
}

/// `∫ N_a (x,ξ × x,η) dξ dη` of the corners [m²]: their outward area vectors. The nodal forces of a pressure p are −p
/// times these.
pub fn corner_areas(x: &[Vec3; 4]) -> [Vec3; 4] {
    let mut areas = [Vec3::zeros(); 4];
    for point in points() {
        let (along_xi, along_eta) = tangents(x, &point);
        let normal = along_xi.cross(&along_eta);
        for (area, n) in areas.iter_mut().zip(point) {
            *area += normal * n.0;
        }
    }
    areas
}

/// `∫ N_a ‖X,ξ × X,η‖ dξ dη` of the corners [m²], for loads per reference area of fixed direction.
pub fn corner_sizes(X: &[Vec3; 4]) -> [f64; 4] {
    let mut sizes = [0.0; 4];
    for point in points() {
        let (along_xi, along_eta) = tangents(X, &point);
        for (size, n) in sizes.iter_mut().zip(point) {
            *size += along_xi.cross(&along_eta).norm() * n.0;
        }
    }
    sizes
}

/// Symmetric part `½ (K_ab + K_baᵀ)` of the load stiffness −∂f_a/∂x_b of a unit pressure [m], `[a][b]`.
pub fn symmetric_stiffness(x: &[Vec3; 4]) -> [[Mat3; 4]; 4] {
    let mut K = [[Mat3::zeros(); 4]; 4];
    for point in points() {
        let (along_xi, along_eta) = tangents(x, &point);
        let (cross_xi, cross_eta) = (along_xi.cross_matrix(), along_eta.cross_matrix());
        for (row, a) in K.iter_mut().zip(&point) {
            for (K, b) in row.iter_mut().zip(&point) {
                *K += (cross_xi * b.2 - cross_eta * b.1) * a.0;
            }
        }
    }
    std::array::from_fn(|a| std::array::from_fn(|b| (K[a][b] + K[b][a].transpose()) * 0.5))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A cube with a bulge, faces outwards.
    const NODES: [[f64; 3]; 8] = [
        [0.0, 0.0, 0.0],
        [1.0, 0.1, 0.0],
        [1.2, 1.0, -0.1],
        [0.0, 1.0, 0.0],
        [0.0, 0.2, 1.0],
        [1.0, 0.0, 1.1],
        [1.3, 1.1, 1.0],
        [-0.1, 1.0, 1.0],
    ];
    const FACES: [[usize; 4]; 6] =
        [[0, 3, 2, 1], [4, 5, 6, 7], [0, 1, 5, 4], [1, 2, 6, 5], [2, 3, 7, 6], [3, 0, 4, 7]];

    fn forces(x: &[Vec3; 8]) -> [Vec3; 8] {
        let mut forces = [Vec3::zeros(); 8];
        for face in FACES {
            for (node, area) in face.iter().zip(corner_areas(&face.map(|a| x[a]))) {
                forces[*node] -= area;
            }
        }
        forces
    }

    #[test]
    fn a_closed_surface_is_in_balance_and_its_stiffness_is_the_derivative() {
        let x = NODES.map(Vec3::from);
        let f = forces(&x);
        // No resultant force and no moment.
        assert!(f.iter().sum::<Vec3>().norm() < 1e-15);
        assert!(x.iter().zip(&f).map(|(x, f)| x.cross(f)).sum::<Vec3>().norm() < 1e-15);
        // Assembled stiffness against central differences.
        let mut K = [[Mat3::zeros(); 8]; 8];
        for face in FACES {
            let own = symmetric_stiffness(&face.map(|a| x[a]));
            for (a, row) in face.iter().zip(&own) {
                for (b, block) in face.iter().zip(row) {
                    K[*a][*b] += block;
                }
            }
        }
        let step = 1e-6;
        for b in 0..8 {
            for axis in 0..3 {
                let moved = [step, -step].map(|step| {
                    let mut x = x;
                    x[b][axis] += step;
                    forces(&x)
                });
                for (a, row) in K.iter().enumerate() {
                    let slope = (moved[1][a] - moved[0][a]) / (2.0 * step);
                    assert!((slope - row[b].column(axis)).norm() < 1e-9, "{a} {b} {axis}");
                }
            }
        }
    }

    #[test]
    fn areas_of_a_rectangle_are_quarters() {
        let x = [[0.0, 0.0, 1.0], [2.0, 0.0, 1.0], [2.0, 3.0, 1.0], [0.0, 3.0, 1.0]].map(Vec3::from);
        for (area, size) in corner_areas(&x).iter().zip(corner_sizes(&x)) {
            assert!((area - Vec3::new(0.0, 0.0, 1.5)).norm() < 1e-15 && (size - 1.5).abs() < 1e-15);
        }
    }
}
