//! Checks of the Prony series of a part.

use super::Findings;
use crate::mechanics::material::MAX_BRANCHES;
use crate::scene::materials::MaterialDocument;
use crate::scene::problem::{Pointer, Problem};
use crate::scene::prony_document::{Moduli, PronyDocument};

/// Usual relaxation times in impacts [s].
const USUAL_TIMES: [f64; 2] = [1e-6, 1e4];

/// Checks the series of a part of a material; `here` is its place in the document.
pub fn check(material: &MaterialDocument, prony: &PronyDocument, here: &Pointer, out: &mut Findings) {
    // Relaxation acts on the isochoric stress.
    out.require(material.is_split(), || {
        Problem::error(
            "coupled_law_with_prony_series",
            here,
            "the series acts on the isochoric stress, which this law does not separate",
        )
        .limit("a split law")
        .remedy("choose a split law: neo_hookean in place of coupled_neo_hookean")
    });
    let branches = here.key("branches");
    let count = prony.branches.len();
    out.require((1..=MAX_BRANCHES).contains(&count), || {
        Problem::error("number_of_branches", &branches, format!("the series has {count} branches"))
            .value(count as u64)
            .limit(format!("1 to {MAX_BRANCHES}"))
            .remedy("one branch per decade of time is enough; omit the series where nothing relaxes")
    });
    // Relaxation time and relative modulus of each branch.
    for (i, branch) in prony.branches.iter().enumerate() {
        let here = branches.index(i);
        let time = here.key("relaxation_time_s");
        let remedy = "soft tissue relaxes over milliseconds to minutes; a branch slower than the run is part of the law";
        out.positive(&time, "a relaxation time", branch.relaxation_time_s, remedy);
        if branch.relaxation_time_s > 0.0 {
            out.usual(&time, "the relaxation time", branch.relaxation_time_s, USUAL_TIMES, remedy);
        }
        let remedy = "moduli are relative to the constants of the law, see moduli";
        out.not_negative(
            &here.key("relative_modulus"),
            "a relative modulus",
            branch.relative_modulus,
            remedy,
        );
        out.at_most(
            &here.key("relative_modulus"),
            "the relative modulus",
            branch.relative_modulus,
            1e4,
            remedy,
        );
    }
    // Instantaneous constants: 1 − Σ g must remain under slow loading.
    out.require(prony.moduli == Moduli::LongTerm || prony.sum() < 1.0, || {
        Problem::error("nothing_is_left", &branches, "relaxation leaves no stress under slow loading")
            .value(prony.sum())
            .limit("relative moduli that sum up to less than 1, since the law's constants are the instantaneous ones")
            .remedy("check the moduli, or say \"long_term\" where they are relative to slow loading")
    });
}
