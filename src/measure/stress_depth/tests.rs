#![allow(clippy::unwrap_used, clippy::float_cmp)] // tests may panic; exact values

use super::*;
use crate::measure::stress_field::TissueElement;
use crate::mechanics::element::MOST_POINTS;
use crate::mesh::cell::CellKind;
use crate::mesh::distance::DepthField;

/// A column of cubes of 1 m³ in slots 0, 1, … of body 1, below a skin at z = 0.
fn column(count: u32, thresholds: &[f64]) -> StressDepth {
    let layer = |i: u32| {
        let z = -f64::from(i);
        [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)].map(|(x, y)| Vec3::new(x, y, z))
    };
    let X: Vec<Vec3> = (0..=count).flat_map(layer).collect();
    let skin = DepthField::new(&[[0, 1, 2, 3]], &X).unwrap();
    let nodes: Vec<[u32; 8]> =
        (0..count).map(|i| [4, 5, 6, 7, 0, 1, 2, 3].map(|local| 4 * i + local)).collect();
    let elements = nodes.iter().enumerate().map(|(slot, nodes)| TissueElement {
        slot,
        part: 0,
        cell: CellKind::Hex8,
        nodes: nodes.to_vec(),
        volumes: [0.125; MOST_POINTS],
        ridge: None,
    });
    // One side of the top, and the bottom, are ends.
    let ends: Vec<u32> =
        (0..X.len()).map(|i| if i < 2 { 1 } else { u32::from(i >= X.len() - 4) << 1 }).collect();
    let field = StressField::new((&skin.depths(&X), &ends), (1, count as usize), elements);
    let parts = TissueParts {
        bodies: vec![1],
        names: vec!["gel".into()],
        volumes: vec![f64::from(count)],
        of_slot: vec![0; count as usize],
    };
    StressDepth::of(Some(field), parts, thresholds)
}

/// An element in a slot, all of whose points have the same stress, strain and energy density.
fn feed(measure: &mut StressDepth, body: usize, slot: usize, stress: f64) {
    let mut points = PointBatch { count: MOST_POINTS, ..PointBatch::default() };
    for q in 0..MOST_POINTS {
        points.volume[q][0] = 0.125;
        for field in [&mut points.von_mises, &mut points.psi, &mut points.principal_strain] {
            field[q][0] = stress;
        }
    }
    measure.accumulate(body, slot..slot + 1, &points, |_, _| Vec3::new(0.5, 0.5, -0.5 - slot as f64));
}

#[test]
fn depths_and_volumes_are_maxima_over_time() {
    let mut measure = column(4, &[1.0, 5.0]);
    measure.strain_in_volume = ExceededIn::new(1.5);
    measure.begin(1.0, None);
    feed(&mut measure, 0, 0, 100.0); // another body
    feed(&mut measure, 1, 0, 7.0);
    feed(&mut measure, 1, 1, 2.0);
    measure.end();
    measure.begin(2.0, None);
    feed(&mut measure, 1, 0, 3.0);
    measure.end();
    let [low, high] = [&measure.exceedances[0], &measure.exceedances[1]];
    // At the nodes 7, 4.5, 1, 0: 5 is crossed at 0.8, and 1 is reached at 2.
    assert!((low.depth - 2.0).abs() < 1e-12 && low.depth_time == 1.0, "{low:?}");
    assert!((high.depth - 0.8).abs() < 1e-12 && high.layers[0].depth == [0.0, high.depth], "{high:?}");
    // The truth, where the stress of one element ends, is within the resolution.
    assert!(high.depth_resolution() > 0.2 && high.depth_resolution() < 1.0, "{high:?}");
    assert_eq!((low.volume, low.largest_volume, high.volume, high.largest_volume), (1.0, 2.0, 0.0, 1.0));
    assert_eq!((low.largest_point, high.largest_point), (0.125, 0.125));
    assert_eq!((measure.von_mises.value, measure.von_mises.time), (7.0, 1.0));
    assert_eq!(measure.energy_density.value, 7.0);
    // 7 in 1 m³ and 2 in the next: 1.5 m³ exceed 2, and so do 5 % of the column's 4 m³ with 7.
    assert_eq!((measure.strain_in_volume.value, measure.strain_percentiles[0].value), (2.0, 7.0));
}

#[test]
fn what_no_wave_can_have_reached_counts_nowhere() {
    use crate::measure::pair::Source;
    let mut source = None;
    Source::widen(&mut source, Vec3::new(0.5, 0.5, 0.0), 0.3);
    let mut measure = column(3, &[1.0]);
    (measure.at_ends, measure.ends) = (vec![0, 0, 2], vec!["the side".into(), "the held nodes".into()]);
    // Elements of 1 m: stress within 0.3 m plus that is physical, stress beyond is a mesh artefact.
    measure.begin(1.0, source.map(WaveReach::of));
    feed(&mut measure, 1, 0, 2.0);
    feed(&mut measure, 1, 2, 3.0);
    measure.end();
    let found = &measure.exceedances[0];
    assert_eq!((found.largest_volume, found.largest_numerical), (1.0, 1.0));
    assert_eq!(measure.ends_of(found), ["the side"]);
    assert_eq!((measure.von_mises.value, found.numerical_at), (2.0, (1.0, 0.3)));
    assert!((found.depth - 1.0).abs() < 1e-12, "{found:?}");
    // Without a known wave all points count, and regions at an end are reported as such.
    measure.begin(2.0, None);
    feed(&mut measure, 1, 2, 3.0);
    measure.end();
    let found = &measure.exceedances[0];
    assert_eq!((measure.ends_of(found), measure.von_mises.value), (measure.ends.clone(), 3.0));
    assert!((found.depth - 3.0).abs() < 1e-12 && measure.ends_of_depth(found) == ["the held nodes"]);
}

#[test]
fn an_end_at_which_the_region_is_shallower_does_not_truncate_its_depth() {
    let mut measure = column(4, &[1.0]);
    (measure.at_ends, measure.ends) = (vec![1, 0, 0, 2], vec!["the side".into(), "the bottom".into()]);
    for (deepest, expected) in [(2, &[][..]), (3, &measure.ends.clone()[1..])] {
        measure.begin(1.0, None);
        (0..=deepest).for_each(|slot| feed(&mut measure, 1, slot, 2.0));
        measure.end();
        let found = &measure.exceedances[0];
        assert_eq!(measure.ends_of(found).len(), deepest - 1);
        assert_eq!(measure.ends_of_depth(found), expected, "{found:?}");
    }
}

#[test]
fn an_end_within_one_edge_of_the_depth_truncates_it() {
    let mut measure = column(4, &[1.0]);
    measure.ends = vec!["the side".into(), "the bone".into()];
    let truncated = |measure: &mut StressDepth, edge: f64| {
        let mut ends = [f64::NEG_INFINITY; MOST_ENDS];
        (ends[0], ends[1]) = (2.0, 56.0);
        let region = Region { depth: 56.6, edge, bounds: [56.6; 2], layers: vec![[0.0, 56.6]], ends };
        measure.exceedances = vec![Exceedance::new(1.0, 1)];
        measure.exceedances[0].add_region(&region, 1.0);
        let found = &measure.exceedances[0];
        assert_eq!(measure.ends_of(found), measure.ends);
        measure.ends_of_depth(found)
    };
    assert_eq!(truncated(&mut measure, 1.0), ["the bone"]);
    assert!(truncated(&mut measure, 0.5).is_empty());
}

#[test]
fn a_region_whose_depth_an_end_cuts_off_has_its_volume_cut_off_there_too() {
    // In the last element the points are at the threshold or below it, and the stress grows towards the bottom.
    let mut measure = column(4, &[1.0]);
    measure.ends = vec!["the side".into(), "the bottom".into()];
    measure.begin(1.0, None);
    let mut points = PointBatch { count: MOST_POINTS, ..PointBatch::default() };
    for q in 0..MOST_POINTS {
        (points.volume[q][0], points.von_mises[q][0]) = (0.125, if q < 4 { 0.99 } else { 0.5 });
    }
    measure.accumulate(1, 3..4, &points, |_, _| Vec3::new(0.5, 0.5, -3.5));
    measure.end();
    let found = &measure.exceedances[0];
    assert!(found.volume == 0.0 && (found.depth - 4.0).abs() < 1e-12, "{found:?}");
    assert_eq!([measure.ends_of(found), measure.ends_of_depth(found)], [["the bottom"]; 2]);
}

#[test]
fn without_a_skin_there_is_volume_but_no_depth() {
    let mut measure = StressDepth { field: None, ..column(1, &[1.0]) };
    measure.begin(0.0, None);
    feed(&mut measure, 1, 0, 2.0);
    measure.end();
    let found = &measure.exceedances[0];
    assert!(!measure.has_skin() && found.depth == 0.0 && found.volume == 1.0);
    assert!(found.layers[0].is_reached() && !found.layers[0].has_depth());
}
