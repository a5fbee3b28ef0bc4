//! Checks of a body's initial motion and constraints: velocity, spin, deformation, fixed nodes.

use super::Findings;
use crate::mechanics::tensor::Mat3;
use crate::scene::document::{Axis, BodyDocument, InitialDeformation};
use crate::scene::problem::{Pointer, Problem};

/// Upper bound of the speed of blunt projectiles [m/s].
pub(super) const USUAL_SPEED: f64 = 2000.0;

/// Checks body number `index`.
pub fn check(index: usize, body: &BodyDocument, out: &mut Findings) {
    let here = Pointer::root().key("bodies").index(index);
    let speed = body.velocity_m_per_s.iter().map(|v| v * v).sum::<f64>().sqrt();
    let velocity = here.key("velocity_m_per_s");
    out.require(speed <= USUAL_SPEED, || {
        Problem::warning("unusual_unit", &velocity, "the body is very fast: is the unit right?")
            .value(speed)
            .limit(format!("usually at most {USUAL_SPEED} m/s"))
            .remedy("give the velocity in m/s")
    });
    check_fixed(body, &here, out);
    if let Some(deformation) = &body.initial_deformation {
        check_deformation(deformation, &here.key("initial_deformation"), out);
    }
}

/// A fixed axis excludes a velocity along it.
fn check_fixed(body: &BodyDocument, here: &Pointer, out: &mut Findings) {
    for (i, fixed) in body.fixed.iter().enumerate() {
        let axes = here.key("fixed").index(i).key("axes");
        out.require(!fixed.axes.is_empty(), || {
            Problem::error("no_axes", &axes, "nothing is held")
                .value(Vec::<f64>::new())
                .limit("at least one of x, y, z")
                .remedy("name the axes, or omit \"axes\" to hold all three")
        });
        for axis in &fixed.axes {
            let along = body.velocity_m_per_s[*axis as usize];
            out.require(along == 0.0, || {
                Problem::error(
                    "fixed_but_flying",
                    &here.key("velocity_m_per_s").index(*axis as usize),
                    format!(
                        "nodes of the set {:?} are held along {axis}, but the body has a velocity along it",
                        fixed.set
                    ),
                )
                .value(along)
                .limit("0")
                .remedy(format!("set this velocity to 0, or do not hold {axis}"))
            });
        }
        let spinning = body.spin_rad_per_s.iter().any(|w| *w != 0.0);
        out.require(!spinning, || {
            Problem::error("fixed_but_spinning", &here.key("spin_rad_per_s"), "a held body cannot spin")
                .value(body.spin_rad_per_s.to_vec())
                .limit("[0, 0, 0] for a body with held nodes")
                .remedy("remove the spin or \"fixed\"")
        });
    }
}

fn check_deformation(deformation: &InitialDeformation, here: &Pointer, out: &mut Findings) {
    match deformation {
        InitialDeformation::SphericalInflation { inner_radius_m, inner_stretch, .. } => {
            out.positive(
                &here.key("inner_radius_m"),
                "the inner radius",
                *inner_radius_m,
                "give it in metres",
            );
            let remedy = "1 is at rest, above 1 is inflated";
            out.positive(&here.key("inner_stretch"), "the stretch", *inner_stretch, remedy);
        }
        InitialDeformation::Affine { deformation_gradient: rows, .. } => {
            let J = Mat3::from_fn(|i, j| rows[i][j]).determinant();
            out.require(J > 0.0 && J.is_finite(), || {
                let place = here.key("deformation_gradient");
                Problem::error("inverted", &place, "the deformation inverts the body")
                    .value(J)
                    .limit("det F > 0")
                    .remedy("give a deformation gradient with a positive determinant")
            });
        }
    }
}

impl std::fmt::Display for Axis {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Self::X => "x",
            Self::Y => "y",
            Self::Z => "z",
        })
    }
}
