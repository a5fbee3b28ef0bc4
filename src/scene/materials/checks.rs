//! Checks shared by the laws: moduli, the bulk modulus of U(J), stability, the range of validity.

use super::{Families, VolumetricDocument};
use crate::mechanics::material::{MAX_FAMILIES, Material, first_instability};
use crate::scene::problem::{Pointer, Problem};
use crate::scene::validate::Findings;
use crate::scene::validity_document::ValidityDocument;

/// A modulus outside this range [Pa] is probably in another unit.
pub(super) const USUAL_MODULUS: [f64; 2] = [1.0, 1e13];

/// Upper bound of any modulus [Pa]: diamond has 1e12.
pub const MOST_MODULUS: f64 = 1e15;

/// Upper bound of any fibre exponent [-].
pub(super) const MOST_EXPONENT: f64 = 1e6;

/// Stretches reached in an impact: a law that loses stability between them is refused.
pub(super) const REACHED_STRETCH: [f64; 2] = [0.5, 2.0];

/// Stretches between which a loss of stability gives a warning.
const FAR_STRETCH: [f64; 2] = [0.25, 4.0];

/// K/G below which Poisson's ratio (3K − 2G)/(6K + 2G) is negative.
const ZERO_POISSON: f64 = 2.0 / 3.0;

/// K/G above which the bulk modulus alone determines the explicit step.
const STIFF_RATIO: f64 = 1e4;

/// Bulk modulus [Pa] that the library assumes for tissue that its sources call nearly incompressible.
const NEARLY_INCOMPRESSIBLE: f64 = 5e7;

/// Bulk modulus [Pa] up to which steps are as long as is usual for tissue, however soft it is in shear.
const STIFF_BULK: f64 = 2.0 * NEARLY_INCOMPRESSIBLE;

/// Ranges must contain the state at rest, and limits the range to which the law was fitted.
pub(super) fn validity(valid_to: &ValidityDocument, here: &Pointer, out: &mut Findings) {
    for (name, range) in valid_to.given() {
        let Some([from, to]) = range else { continue };
        out.require(from > 0.0 && from <= 1.0 && to >= 1.0, || {
            Problem::error("out_of_range", &here.key(name), "the range does not contain the state at rest")
                .value(format!("{from} to {to}"))
                .limit("0 < from <= 1 <= to")
                .remedy("30 % tension is a stretch of 1.3, 30 % compression one of 0.7")
        });
    }
    if let Some([from, to]) = valid_to.strain_rate_per_s {
        out.require(from >= 0.0 && from <= to && to > 0.0, || {
            Problem::error("out_of_range", &here.key("strain_rate_per_s"), "the range holds no strain rate")
                .value(format!("{from} to {to}"))
                .limit("0 <= from <= to, to > 0")
                .remedy("give the slowest and the fastest test in 1/s, the slowest first")
        });
    }
    for (limit, inner, name) in [
        (valid_to.limit_stretch, valid_to.stretch, "limit_stretch"),
        (valid_to.limit_jacobian, valid_to.jacobian, "limit_jacobian"),
    ] {
        let (Some(limit), Some(inner)) = (limit, inner) else { continue };
        out.require(limit[0] <= inner[0] && limit[1] >= inner[1], || {
            Problem::error(
                "contradiction",
                &here.key(name),
                "the limit is inside the range to which the law was fitted",
            )
            .value(format!("{} to {}", limit[0], limit[1]))
            .limit(format!("from at most {} to at least {}", inner[0], inner[1]))
            .remedy("widen the limit; omitted, it is that of the library's set, or contains the range")
        });
    }
}

/// A modulus must be positive, and should be of a usual size.
pub(super) fn modulus(place: &Pointer, what: &str, value: f64, out: &mut Findings) {
    out.positive(
        place,
        what,
        value,
        "moduli of soft tissue are about 1e3 to 1e6 Pa, of rubber 1e5 to 1e7 Pa",
    );
    out.at_most(place, what, value, MOST_MODULUS, "give it in Pa");
    if value > 0.0 {
        out.usual(place, what, value, USUAL_MODULUS, "give it in Pa");
    }
}

/// At most as many fibre families as a law may have, each with a direction; none only if the fibre stiffness [Pa] is zero.
pub(super) fn families(
    fibres: &Families,
    stiffness: f64,
    idle_remedy: &str,
    here: &Pointer,
    out: &mut Findings,
) {
    let count = fibres.count();
    let place = here.key("fibres");
    out.require(count <= MAX_FAMILIES, || {
        Problem::error("too_many_items", &place, "there are too many fibre families")
            .value(count)
            .limit(format!("at most {MAX_FAMILIES}"))
            .remedy("merge families, or describe their spread by κ")
    });
    let idle = || {
        Problem::warning("idle_fibres", &place, "the law has no fibre that carries load")
            .value(count)
            .limit("at least one family, with a stiffness above 0")
            .remedy(idle_remedy)
    };
    out.require(count > 0 || stiffness <= 0.0, || {
        Problem::error("no_fibres", &place, "the fibres have a stiffness, but there is no family")
            .value(count)
            .limit("at least one family")
            .remedy("give angles_deg or directions")
    });
    out.require(stiffness != 0.0, idle);
    if let Families::Directions(directions) = fibres {
        for (i, direction) in directions.iter().enumerate() {
            out.direction(&place.key("directions").index(i), "the fibre family", *direction);
        }
    }
}

/// An isotropic law must be stable over the stretches reached in an impact; a loss of stability beyond gives a warning.
/// Laws that are invalid, or unstable at rest, are reported by other checks.
pub(super) fn stability(law: Option<Material>, place: &Pointer, out: &mut Findings) {
    let Some(law) = law.filter(|law| law.moduli_at_rest().0 > 0.0) else { return };
    let Some(found) = first_instability(&law, FAR_STRETCH) else { return };
    let sense = if found.stretch > 1.0 { "tension" } else { "compression" };
    let (test, stretch) = (found.test, found.stretch);
    let message = format!("the law becomes unstable at a stretch of {stretch:.3} in {test} {sense}");
    let is_reached = stretch > REACHED_STRETCH[0] && stretch < REACHED_STRETCH[1];
    let problem = if is_reached {
        Problem::error("unstable_law", place, message)
    } else {
        Problem::warning("law_unstable_far_from_rest", place, message)
    };
    out.push(
        problem
            .value(stretch)
            .limit("dτ : dε > 0 (Drucker) in uniaxial, equibiaxial and planar tests at stretches of 0.5 to 2")
            .remedy("fit the constants under the constraint of stability, or use fewer of them"),
    );
}

/// Checks the bulk modulus of a split law, and its U(J) far from rest.
pub(super) fn bulk(K: f64, G: f64, volumetric: VolumetricDocument, here: &Pointer, out: &mut Findings) {
    let place = here.key("bulk_modulus_pa");
    modulus(&place, "the bulk modulus", K, out);
    ratio(K, G, &place, out);
    // With a soft volume, J moves far from 1, where two of the three forms misbehave.
    if !(K > 0.0 && G > 0.0 && K < 10.0 * G) {
        return;
    }
    let trouble = match volumetric {
        VolumetricDocument::LnSquared => "K/2 (ln J)² softens beyond J = e",
        VolumetricDocument::Quadratic => "K/2 (J − 1)² lets elements collapse at finite energy",
        VolumetricDocument::QuadraticLn => return,
    };
    out.push(
        Problem::warning(
            "soft_volume",
            &here.key("volumetric"),
            format!("the volume is soft (K/G < 10), and {trouble}"),
        )
        .value(K / G)
        .limit("K/G >= 10 with this form of U(J)")
        .remedy("choose quadratic_ln, which is infinite at J = 0 and never softens"),
    );
}

/// Warns of a law that is auxetic, or so stiff in volume that the time step becomes very small.
pub(super) fn ratio(K: f64, G: f64, place: &Pointer, out: &mut Findings) {
    if !(K > 0.0 && G > 0.0) {
        return;
    }
    // Rounding must not refuse a Poisson's ratio of exactly zero.
    out.require(K / G > ZERO_POISSON * (1.0 - 1e-9), || {
        let poisson = (3.0 * K - 2.0 * G) / (6.0 * K + 2.0 * G);
        Problem::warning("negative_poisson", place, format!("Poisson's ratio is negative ({poisson:.3})"))
            .value(K)
            .limit(format!("at least two thirds of the shear modulus of {G:.4e} Pa"))
            .remedy("give the bulk modulus in Pa (water has 2.2e9); soft tissue is nearly incompressible")
    });
    // Tissue of a few kPa exceeds the ratio with any usual bulk modulus: what counts is whether the step is shorter than usual.
    out.require(K / G <= STIFF_RATIO || K <= STIFF_BULK, || {
        let longer = (K / NEARLY_INCOMPRESSIBLE).sqrt();
        Problem::warning(
            "stiff_volume",
            place,
            format!("the bulk modulus alone (K/G = {:.1e}) determines the explicit time step, which is very small", K / G),
        )
        .value(K)
        .limit(format!("K <= {STIFF_BULK:e} Pa, or K/G <= {STIFF_RATIO:e}"))
        .remedy(format!(
            "{NEARLY_INCOMPRESSIBLE:e} Pa, as in the library, is nearly incompressible and allows steps {longer:.1} times as long; `contuse run --lower-bulk-modulus` \
             lowers it as far as the accuracy allows"
        ))
    });
}
