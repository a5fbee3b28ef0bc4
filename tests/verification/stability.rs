//! The short matrices: every cell ends within its limits or with a diagnosis.

use contuse::study::stability::{Stepping, Verdict, cases, ordinary_impacts, study_stability};

#[test]
fn ordinary_impacts_run_to_the_end_of_contact() {
    let study = study_stability(&ordinary_impacts(true, 1), &[Stepping::Explicit], 2, &|| None, &mut |_| {});
    for cell in &study.cells {
        let name = format!("{}, {}", cell.axis, cell.value);
        assert_eq!(cell.verdict, Verdict::Finished, "{name}: {cell:?}");
        assert!(cell.balance_error <= 0.01 && cell.growth <= 1.01, "{name}: {cell:?}");
        assert!(cell.deflection_m > 1e-3, "{name}: {cell:?}");
        assert!(cell.face_penetration < 0.1, "{name}: {cell:?}");
    }
}

#[test]
fn short_matrix_has_no_undiagnosed_cell() {
    let steppings = [Stepping::Explicit, Stepping::Implicit { step_ratio: 10 }];
    let study = study_stability(&cases(true), &steppings, 2, &|| None, &mut |_| {});
    assert_eq!(study.wrong, 0);
    // Of what could happen all but a seventh finishes; most of the rest are steps at θ = ½ ten times as long as the explicit one, which
    // leave a node that comes into contact half of their length inside.
    assert!(
        7 * study.physical_finished >= 6 * study.physical,
        "{} of {}",
        study.physical_finished,
        study.physical
    );
    for cell in &study.cells {
        let name = format!("{} {}, {}", cell.axis, cell.value, cell.stepping);
        if cell.verdict == Verdict::Finished {
            assert!(cell.balance_error <= 0.01 && cell.growth <= 1.01, "{name}: {cell:?}");
        } else {
            assert!(cell.reason.is_some() && cell.remedy.is_some(), "{name} has no diagnosis");
        }
    }
    // Nonsense that no engine could compute never passes as computed.
    let refused = |cell: &&contuse::study::stability::Cell| cell.verdict == Verdict::Refused;
    assert!(study.cells.iter().filter(|c| !c.is_physical).filter(refused).count() >= 14);
}
