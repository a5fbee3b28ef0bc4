//! The parameters of a law: those that it needs to be stable, and those that are unusual.

use super::Findings;
use crate::mechanics::material::MAX_FAMILIES;
use crate::scene::document::{Families, MaterialDocument, VolumetricDocument};
use crate::scene::problem::{Pointer, Problem};
use crate::scene::validity_document::ValidityDocument;

/// A modulus outside this range [Pa] is probably in another unit.
const USUAL_MODULUS: [f64; 2] = [1.0, 1e13];

/// Larger than any modulus [Pa]: diamond has 1e12.
pub const MOST_MODULUS: f64 = 1e15;

/// Larger than any fibre exponent [-].
const MOST_EXPONENT: f64 = 1e6;

/// Stretches that an impact reaches: a law that loses stability between them is refused.
const REACHED_STRETCH: [f64; 2] = [0.5, 2.0];

/// K/G below which Poisson's ratio (3K − 2G)/(6K + 2G) is negative.
const ZERO_POISSON: f64 = 2.0 / 3.0;

/// K/G above which the explicit step is set by the bulk modulus alone.
const STIFF_RATIO: f64 = 1e4;

/// Checks one material.
pub fn check(material: &MaterialDocument, here: &Pointer, out: &mut Findings) {
    check_validity(&material.valid_to(), &here.key("valid_to"), out);
    match material {
        MaterialDocument::MooneyRivlin { c10_pa, c01_pa, bulk_modulus_pa, volumetric, .. } => {
            check_mooney_rivlin(*c10_pa, *c01_pa, here, out);
            check_bulk(*bulk_modulus_pa, 2.0 * (c10_pa + c01_pa), *volumetric, here, out);
        }
        MaterialDocument::NeoHookean { c10_pa, bulk_modulus_pa, volumetric, .. } => {
            modulus(&here.key("c10_pa"), "C10", *c10_pa, out);
            check_bulk(*bulk_modulus_pa, 2.0 * c10_pa, *volumetric, here, out);
        }
        MaterialDocument::CoupledNeoHookean { mu_pa, lambda_pa, .. } => {
            modulus(&here.key("mu_pa"), "the shear modulus", *mu_pa, out);
            out.at_most(&here.key("lambda_pa"), "λ", *lambda_pa, MOST_MODULUS, "give it in Pa");
            let K = lambda_pa + 2.0 / 3.0 * mu_pa;
            out.require(K > 0.0, || {
                let message =
                    format!("the bulk modulus λ + 2μ/3 = {K} Pa is not positive: the law is unstable");
                Problem::error("unstable_law", &here.key("lambda_pa"), message)
                    .value(*lambda_pa)
                    .limit(format!("> -2μ/3 = {}", -2.0 / 3.0 * mu_pa))
                    .remedy("λ = K − 2μ/3; λ = 0 has Poisson's ratio about 0")
            });
            check_ratio(K, *mu_pa, &here.key("lambda_pa"), out);
        }
        MaterialDocument::HolzapfelGasserOgden {
            c_pa,
            k1_pa,
            k2,
            kappa,
            fibres,
            bulk_modulus_pa,
            volumetric,
            ..
        } => {
            modulus(&here.key("c_pa"), "the matrix modulus c", *c_pa, out);
            check_fibre_stiffness(*k1_pa, *k2, *kappa, here, out);
            check_families(fibres, *k1_pa, here, out);
            check_bulk(*bulk_modulus_pa, *c_pa, *volumetric, here, out);
        }
    }
}

/// Ranges hold the state at rest, and limits hold what the law was fitted to.
fn check_validity(valid_to: &ValidityDocument, here: &Pointer, out: &mut Findings) {
    for (name, range) in valid_to.given() {
        let Some([from, to]) = range else { continue };
        out.require(from > 0.0 && from <= 1.0 && to >= 1.0, || {
            Problem::error("out_of_range", &here.key(name), "the range does not hold the state at rest")
                .value(format!("{from} to {to}"))
                .limit("0 < from <= 1 <= to")
                .remedy("30 % tension is a stretch of 1.3, 30 % compression one of 0.7")
        });
    }
    for (limit, inner, name) in [
        (valid_to.limit_stretch, valid_to.stretch, "limit_stretch"),
        (valid_to.limit_jacobian, valid_to.jacobian, "limit_jacobian"),
    ] {
        let (Some(limit), Some(inner)) = (limit, inner) else { continue };
        out.require(limit[0] <= inner[0] && limit[1] >= inner[1], || {
            Problem::error("contradiction", &here.key(name), "the limit is within what the law was fitted to")
                .value(format!("{} to {}", limit[0], limit[1]))
                .limit(format!("from at most {} to at least {}", inner[0], inner[1]))
                .remedy("widen the limit, or leave it out")
        });
    }
}

/// A modulus must be positive, and of a usual size.
fn modulus(place: &Pointer, what: &str, value: f64, out: &mut Findings) {
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

/// In uniaxial stress the incompressible solid has P = 2 (1 − λ⁻³)(C10 λ + C01), which changes sign at λ = −C01/C10: a
/// negative constant makes it unstable beyond that stretch, in tension (C10 < 0) or in compression (C01 < 0).
fn check_mooney_rivlin(c10: f64, c01: f64, here: &Pointer, out: &mut Findings) {
    let sum = c10 + c01;
    if sum.is_nan() || sum <= 0.0 {
        let message = format!(
            "the shear modulus 2 (C10 + C01) = {} Pa is not positive: the law is unstable",
            2.0 * sum
        );
        out.push(
            Problem::error("unstable_law", &here.key("c10_pa"), message)
                .value(c10)
                .limit(format!("> -C01 = {}", -c01))
                .remedy("make C10 + C01 positive"),
        );
        return;
    }
    for (name, value, other, sense) in [("c10_pa", c10, c01, "stretched"), ("c01_pa", c01, c10, "compressed")]
    {
        out.at_most(&here.key(name), "the modulus", value, MOST_MODULUS, "give it in Pa");
        out.usual(
            &here.key(name),
            "the modulus",
            if value == 0.0 { 1.0 } else { value },
            USUAL_MODULUS,
            "give it in Pa",
        );
        if value >= 0.0 {
            continue;
        }
        let critical = -c01 / c10;
        let reached = critical > REACHED_STRETCH[0] && critical < REACHED_STRETCH[1];
        let message = format!(
            "a negative constant makes the law unstable when it is {sense} beyond λ = {critical:.3} in uniaxial stress"
        );
        let place = here.key(name);
        let problem = if reached {
            Problem::error("unstable_law", &place, message)
        } else {
            Problem::warning("law_unstable_far_from_rest", &place, message)
        };
        out.push(
            problem
                .value(value)
                .limit(format!(">= 0 (with the other {other})"))
                .remedy("fit both constants under the condition that neither is negative"),
        );
    }
}

fn check_fibre_stiffness(k1: f64, k2: f64, kappa: f64, here: &Pointer, out: &mut Findings) {
    let k1_place = here.key("k1_pa");
    out.at_most(&k1_place, "the fibre stiffness k1", k1, MOST_MODULUS, "give it in Pa");
    out.at_most(&here.key("k2"), "the fibre exponent k2", k2, MOST_EXPONENT, "arteries have 1 to 1000");
    out.not_negative(
        &k1_place,
        "the fibre stiffness k1",
        k1,
        "0 leaves the fibres out; a negative one is unstable",
    );
    if k1 > 0.0 {
        out.usual(&k1_place, "the fibre stiffness k1", k1, USUAL_MODULUS, "give it in Pa");
        out.positive(
            &here.key("k2"),
            "the fibre exponent k2",
            k2,
            "a small k2 such as 0.01 is nearly linear",
        );
    } else {
        out.not_negative(
            &here.key("k2"),
            "the fibre exponent k2",
            k2,
            "without fibre stiffness leave it at 0",
        );
    }
    let remedy = "0 is aligned, 1/3 is isotropic";
    out.require((0.0..=1.0 / 3.0 + 1e-12).contains(&kappa), || {
        Problem::error("out_of_range", &here.key("kappa"), "the dispersion κ is out of its range")
            .value(kappa)
            .limit("between 0 and 1/3")
            .remedy(remedy)
    });
}

fn check_families(fibres: &Families, k1: f64, here: &Pointer, out: &mut Findings) {
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
            .limit("at least one family and k1 > 0")
            .remedy("use neo_hookean with C10 = c/2: it is the same solid and costs less")
    };
    out.require(count > 0 || k1 <= 0.0, || {
        Problem::error("no_fibres", &place, "k1 is given, but no family")
            .value(count)
            .limit("at least one family")
            .remedy("give angles_deg or directions")
    });
    out.require(k1 != 0.0, idle);
    if let Families::Directions(directions) = fibres {
        for (i, direction) in directions.iter().enumerate() {
            out.direction(&place.key("directions").index(i), "the fibre family", *direction);
        }
    }
}

/// The bulk modulus of a split law, and what its U(J) does far from rest.
fn check_bulk(K: f64, G: f64, volumetric: VolumetricDocument, here: &Pointer, out: &mut Findings) {
    let place = here.key("bulk_modulus_pa");
    modulus(&place, "the bulk modulus", K, out);
    check_ratio(K, G, &place, out);
    // A soft volume lets J go far from 1, where two of the three forms misbehave.
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

fn check_ratio(K: f64, G: f64, place: &Pointer, out: &mut Findings) {
    if !(K > 0.0 && G > 0.0) {
        return;
    }
    // The ratio at zero Poisson's ratio must not be refused for its rounding.
    out.require(K / G > ZERO_POISSON * (1.0 - 1e-9), || {
        let poisson = (3.0 * K - 2.0 * G) / (6.0 * K + 2.0 * G);
        Problem::warning("negative_poisson", place, format!("Poisson's ratio is negative ({poisson:.3})"))
            .value(K)
            .limit(format!("at least two thirds of the shear modulus of {G:.4e} Pa"))
            .remedy("give the bulk modulus in Pa (water has 2.2e9); soft tissue is nearly incompressible")
    });
    out.require(K / G <= STIFF_RATIO, || {
        Problem::warning(
            "stiff_volume",
            place,
            "the bulk modulus alone sets the explicit step, which is very small",
        )
        .value(K / G)
        .limit(format!("K/G <= {STIFF_RATIO:e}"))
        .remedy("a bulk modulus of 100 to 1000 G is nearly incompressible and allows a larger step")
    });
}
