use super::*;
use crate::mechanics::force::BATCH;
use crate::mechanics::material::Given;

/// Ranges of two parts of one body: elements 2 to 4 of the batch are of the second, whose limit of stretch is declared.
fn ranges() -> LawRanges {
    let part = |stretch: [f64; 2], declared: bool| {
        let validity = Validity {
            fitted: Deformations { stretch: [0.6, 1.5], jacobian: [0.9, 1.1] },
            given: Given::default(),
            declared: Given { stretch: declared, jacobian: false },
            limit: Deformations { stretch, jacobian: [0.1, 10.0] },
            strain_rate: Some([0.0, 50.0]),
        };
        PartRange::at_rest("body".into(), "part".into(), validity, 0)
    };
    LawRanges {
        parts: vec![part([0.1, 4.0], false), part([0.4, 2.0], true)],
        bodies: vec![BodyRange::default()],
        part_of: vec![0, 0, 1, 1, 1, 0, 0, 0],
        reached: vec![Reached::default(); BATCH],
    }
}

/// Points with strains up to a largest size, some of them damaged.
fn points(size: f64, damage: f64) -> PointBatch {
    let mut points = PointBatch { count: 8, ..PointBatch::default() };
    for q in 0..points.count {
        for lane in 0..BATCH {
            let wave = |k: f64| (1.7 * k + (8 * lane + q) as f64 * 2.399_963).sin();
            points.volume[q][lane] = 1.0 + 0.1 * wave(1.0);
            points.psi[q][lane] = 100.0 * wave(2.0).abs();
            points.principal_strain[q][lane] = size * wave(3.0).abs();
            points.least_principal_strain[q][lane] = -0.45 * size.min(1.0) * wave(4.0).abs();
            points.jacobian[q][lane] = 1.0 + 0.3 * size * wave(5.0);
            points.damage[q][lane] = damage * wave(6.0);
            points.strain_rate[q][lane] = 100.0 * wave(7.0).abs();
        }
    }
    points
}

/// Contribution of each point, in the order of the elements.
fn point_by_point(ranges: &mut LawRanges, points: &PointBatch) {
    for lane in 0..BATCH {
        let part = &mut ranges.parts[ranges.part_of[lane] as usize];
        let body = &mut ranges.bodies[part.in_body];
        for q in 0..points.count {
            body.all.now += points.volume[q][lane] * points.psi[q][lane];
        }
        part.accumulate_damage(lane..lane + 1, points);
        part.rates.accumulate(&mut ranges.reached, lane..lane + 1, points, 1.0);
        part.accumulate_deformation(body, lane..lane + 1, points);
    }
}

#[test]
fn comparing_the_extremes_first_changes_no_bit() {
    for size in [0.0, 1e-3, 0.1, 0.3, 0.7, 1.2, 3.0, 20.0] {
        for damage in [0.0, 0.9] {
            for nan in [None, Some(0), Some(1), Some(2)] {
                let mut points = points(size, damage);
                let fields =
                    [&mut points.least_principal_strain, &mut points.principal_strain, &mut points.jacobian];
                if let Some(field) = nan {
                    fields.into_iter().nth(field).into_iter().for_each(|field| field[3][2] = f64::NAN);
                }
                let [mut found, mut expected] = [ranges(), ranges()];
                for _ in 0..2 {
                    found.accumulate(0..BATCH, &points);
                    point_by_point(&mut expected, &points);
                }
                // Debug output has all bits of a number but the sign of NaN.
                assert_eq!(format!("{found:?}"), format!("{expected:?}"), "{size} {damage} {nan:?}");
                let is_outside = found.parts.iter().any(|part| part.left.volume.now > 0.0);
                assert!(is_outside == (size > 0.5 || matches!(nan, Some(0 | 2))), "{size} {nan:?}");
            }
        }
    }
}

#[test]
fn a_batch_that_is_not_full_is_evaluated_as_far_as_its_elements() {
    let mut points = points(0.1, 0.0);
    for q in 0..points.count {
        points.principal_strain[q][5] = 100.0;
    }
    let mut ranges = ranges();
    ranges.accumulate(0..5, &points);
    assert!(ranges.parts[0].stretch[1] < 1.2 && ranges.parts[0].left.volume.now == 0.0);
    ranges.accumulate(0..6, &points);
    assert!(ranges.parts[0].stretch[1] > 10.0 && ranges.parts[0].beyond.volume.now > 0.0);
    assert!(ranges.parts[1].stretch[1] < 1.2, "another part");
}

/// Erosion deletes an element when the stretch of its mean deformation exceeds a limit, and results are withheld no earlier; volumes are those of
/// points.
#[test]
#[allow(clippy::float_cmp)] // these sums are exact
fn limits_of_what_erodes_are_those_of_the_mean_deformation_of_an_element() {
    // Points with stretches of 1 and 2.2; the limit is 2.
    let mut points = points(0.0, 0.0);
    for q in 0..points.count {
        points.principal_strain[q][3] = if q % 2 == 0 { 0.0 } else { 1.92 };
        points.volume[q][3] = 1.0;
    }
    for q in 0..points.count {
        points.psi[q][3] = 1.0;
    }
    for (erodes_at, mean_strain, beyond, withheld) in
        [(None, 0.9, 4.0, 4.0), (Some(1.9), 0.9, 4.0, 0.0), (Some(1.9), 1.6, 0.0, 0.0)]
    {
        let mut ranges = ranges();
        ranges.parts[1].erodes_at = erodes_at;
        ranges.parts[1].validity.declared.stretch = true;
        points.mean_strain[3] = mean_strain;
        ranges.accumulate(0..BATCH, &points);
        assert_eq!(ranges.parts[1].beyond.volume.now, beyond, "{erodes_at:?}, {mean_strain}");
        assert_eq!(ranges.parts[1].energy_beyond_declared.now, withheld, "{erodes_at:?}, {mean_strain}");
        assert_eq!(ranges.parts[1].left.volume.now, beyond, "the next step erodes what is not counted");
    }
}
