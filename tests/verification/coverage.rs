//! Error bars contain the truth: in nine of ten numbers whose exact value is known, over meshes, speeds, steps and integrators; and in
//! nine of ten of all numbers of balls on layered tissue, against a much finer mesh.

use contuse::study::coverage::{CoverageStudy, cases, impacts, study_coverage, study_impacts};
use std::sync::LazyLock;

static STUDY: LazyLock<CoverageStudy> = LazyLock::new(|| study_coverage(&cases(true), &|| None));

#[test]
fn nine_of_ten_numbers_are_within_their_error_bars() {
    let study = &*STUDY;
    assert!(study.without.is_empty(), "{:#?}", study.without);
    assert!(study.runs >= 40 && study.numbers.len() >= 100, "{} runs", study.runs);
    let missed: Vec<_> = study.numbers.iter().filter(|number| !number.is_covered()).collect();
    assert!(study.fraction(|_| true).0 >= 0.9, "{missed:#?}");
    // Nor does one quantity hide behind the others; the patch is that of a whole face, and its truth is easily met.
    for quantity in
        ["peak_force_n", "impulse_n_s", "contact_duration_s", "absorbed_energy_j", "friction_dissipation_j"]
    {
        let (fraction, numbers) = study.fraction(|number| number.quantity == quantity);
        assert!(numbers >= 8 && fraction >= 0.9, "{quantity}: {fraction} of {numbers}; {missed:#?}");
    }
}

#[test]
fn error_bars_are_no_excuse() {
    // A bar as long as the number itself would contain every truth.
    let wide = |number: &&contuse::study::coverage::Number| number.error_bar > 0.5 * number.exact.abs();
    let wide = STUDY.numbers.iter().filter(|number| number.exact != 0.0).filter(wide).count();
    assert!(wide * 10 <= STUDY.numbers.len(), "{wide} of {}", STUDY.numbers.len());
}

#[test]
fn nine_of_ten_numbers_of_impacts_on_tissue_are_within_their_error_bars() {
    let study = study_impacts(&impacts(true), &|| None);
    assert!(study.without.is_empty() && study.runs == 4, "{} runs, {:#?}", study.runs, study.without);
    let missed: Vec<_> = study.numbers.iter().filter(|number| !number.is_covered()).collect();
    for bars in ["two levels", "three levels"] {
        let (fraction, numbers) = study.fraction(|number| number.bars == bars);
        assert!(numbers >= 60 && fraction >= 0.9, "{bars}: {fraction} of {numbers}; {missed:#?}");
    }
}
