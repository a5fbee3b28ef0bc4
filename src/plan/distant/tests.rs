use super::*;

fn cube(low: [f64; 3], flight: [f64; 3]) -> BodyMotion {
    let low = Vec3::from(low);
    BodyMotion {
        low,
        high: low + Vec3::repeat(1.0),
        flight: Vec3::from(flight),
        reach: 0.01,
        held: false,
        straight: true,
    }
}

/// Which of the pairs are omitted.
fn omitted(motions: &[BodyMotion], pairs: &[(usize, Other)], until: f64) -> Vec<bool> {
    cannot_meet(motions, pairs, until).iter().map(Option::is_some).collect()
}

/// Uniform in (−1, 1), from a linear congruential generator.
fn random(state: &mut u64) -> f64 {
    *state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
    (*state >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
}

#[test]
fn the_closest_approach_is_below_every_distance_seen_and_near_the_least() {
    let mut state = 7;
    for _ in 0..300 {
        let mut body = || {
            let mut vector = |size: f64| [0; 3].map(|_| size * random(&mut state));
            cube(vector(5.0), vector(4.0))
        };
        let (a, b) = (body(), body());
        let bound = closest_approach(&a, &b, 2.0);
        let at = |t: f64| {
            let apart = |i: usize| {
                let shift = (a.flight[i] - b.flight[i]) * t;
                (a.low[i] + shift - b.high[i]).max(b.low[i] - a.high[i] - shift).max(0.0)
            };
            (apart(0).powi(2) + apart(1).powi(2) + apart(2).powi(2)).sqrt()
        };
        let least = (0..=20_000).map(|i| at(f64::from(i) * 1e-4)).fold(f64::INFINITY, f64::min);
        // Between two samples, the boxes move by at most 14 · 1e-4.
        assert!(bound <= least + 1e-12 && bound >= least - 2e-3, "{bound} {least}");
    }
}

#[test]
fn boxes_that_fly_past_each_other_are_apart_though_the_spaces_they_sweep_cross() {
    // One crosses the path of the other a second earlier.
    let early = cube([0.0, 0.0, 0.0], [4.0, 0.0, 0.0]);
    let late = cube([5.0, -9.0, 0.0], [0.0, 4.0, 0.0]);
    assert_eq!(omitted(&[early.clone(), late], &[(0, Other::Body(1))], 4.0), [true]);
    let in_time = cube([5.0, -5.0, 0.0], [0.0, 4.0, 0.0]);
    assert_eq!(omitted(&[early, in_time], &[(0, Other::Body(1))], 4.0), [false]);
}

#[test]
fn reach_and_time_decide() {
    let pair = [(0, Other::Body(1))];
    for (gap, until, expected) in
        [(0.02, 0.0, true), (0.009, 0.0, false), (0.02, 0.0099, true), (0.02, 0.0101, false)]
    {
        let motions = [cube([0.0; 3], [1.0, 0.0, 0.0]), cube([1.0 + gap, 0.0, 0.0], [0.0; 3])];
        assert_eq!(omitted(&motions, &pair, until), [expected], "{gap} {until}");
    }
    let floor = Other::Plane(Vec3::zeros(), Vec3::z());
    let falling = [cube([0.0, 0.0, 1.0], [0.0, 0.0, -1.0])];
    assert_eq!(omitted(&falling, &[(0, floor)], 0.98), [true]);
    assert_eq!(omitted(&falling, &[(0, floor)], 1.0), [false]);
}

#[test]
fn whoever_may_be_touched_and_all_its_partners_stay() {
    let striker = cube([0.0; 3], [10.0, 0.0, 0.0]);
    let target = cube([1.5, 0.0, 0.0], [0.0; 3]);
    let behind = cube([50.0, 0.0, 0.0], [0.0; 3]);
    let far_behind = cube([90.0, 0.0, 0.0], [0.0; 3]);
    let motions = [striker, target, behind, far_behind];
    let chain = [(0, Other::Body(1)), (1, Other::Body(2)), (2, Other::Body(3))];
    // The target may be thrown at the body behind, and that at the next.
    assert_eq!(omitted(&motions, &chain, 1.0), [false; 3]);
    // Without the impact none is.
    assert_eq!(omitted(&motions, &chain[1..], 1.0), [true; 2]);
    // A group that the impact cannot reach is for itself.
    assert_eq!(omitted(&motions, &[chain[0], chain[2]], 1.0), [false, true]);
}

#[test]
fn what_is_held_is_never_thrown() {
    let striker = cube([0.0; 3], [10.0, 0.0, 0.0]);
    let wall = BodyMotion { held: true, ..cube([1.5, 0.0, 0.0], [0.0; 3]) };
    let far = cube([50.0, 0.0, 0.0], [0.0; 3]);
    let pairs = [(0, Other::Body(1)), (1, Other::Body(2))];
    assert_eq!(omitted(&[striker, wall.clone(), far], &pairs, 1.0), [false, true]);
    // Two that are held need not even be apart.
    let other = BodyMotion { straight: false, ..wall.clone() };
    assert_eq!(omitted(&[wall, other], &[(0, Other::Body(1)), (0, Other::Body(0))], 1.0), [true; 2]);
}

#[test]
fn what_does_not_fly_straight_may_be_anywhere() {
    let spinning = BodyMotion { straight: false, ..cube([0.0; 3], [0.0; 3]) };
    let far = cube([1e3, 0.0, 0.0], [0.0; 3]);
    assert_eq!(omitted(&[spinning, far.clone()], &[(0, Other::Body(1))], 1e-6), [false]);
}

#[test]
fn a_body_that_nothing_deforms_does_not_meet_itself() {
    let itself = (0, Other::Body(0));
    let flying = cube([0.0; 3], [3.0, 0.0, 0.0]);
    assert_eq!(omitted(std::slice::from_ref(&flying), &[itself], 1.0), [true]);
    let spinning = BodyMotion { straight: false, ..flying.clone() };
    assert_eq!(omitted(&[spinning], &[itself], 1.0), [false]);
    // That it may fold deflects no other body, …
    let far = cube([50.0, 0.0, 0.0], [0.0; 3]);
    assert_eq!(omitted(&[flying.clone(), far], &[itself, (0, Other::Body(1))], 1.0), [true; 2]);
    // … but what may be hit may fold.
    let near = cube([1.5, 0.0, 0.0], [0.0; 3]);
    assert_eq!(omitted(&[flying, near], &[itself, (0, Other::Body(1))], 1.0), [false; 2]);
}
