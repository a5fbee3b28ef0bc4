//! Contact of surfaces with themselves.

use super::*;

#[test]
fn self_contact_needs_opposed_faces_and_omits_the_own_wall() {
    // A thin plate alone does not touch itself, …
    let mut x = Vec::new();
    let plate = block(6, 1, &mut x, |p| Vec3::new(p.x, p.y, 0.02 * p.z));
    let own = [pair(0, Master::Surface(0))];
    assert_eq!(detect(std::slice::from_ref(&plate), &own, &x, &x), []);
    // … rolled up until two of its ends meet face to face, it does.
    let roll = |p: Vec3| {
        let (angle, radius) = (std::f64::consts::TAU * 0.9998 * p.x, 1.0 + 0.1 * p.z);
        Vec3::new(radius * angle.cos(), radius * angle.sin(), p.y)
    };
    let mut x = Vec::new();
    let ring = block(24, 1, &mut x, roll);
    let found = detect(&[ring], &own, &x, &x);
    assert!(!found.is_empty());
    assert!(found.iter().all(|c| c.gap > 0.0 && c.frame[0].y.abs() > 0.99), "{:?}", found[0]);
}

#[test]
fn a_body_that_is_crushed_does_not_touch_itself() {
    let own = [pair(0, Master::Surface(0))];
    let mut x = Vec::new();
    let cube = block(4, 4, &mut x, |p| p);
    let mut detector = new(std::slice::from_ref(&cube), &own, &x);
    for height in [0.5_f64, 0.1, 0.03, 0.01] {
        // Wider towards the bottom, barrelled, and sheared.
        let crushed = |p: &Vec3| {
            let wide = height.powf(-0.5) * (1.0 + p.z * (1.0 - p.z));
            Vec3::new((p.x - 0.5) * wide + 0.3 * p.z, (p.y - 0.5) * wide, p.z * height)
        };
        let y: Vec<Vec3> = x.iter().map(crushed).collect();
        assert_eq!(find(&mut detector, &y, &y).0, [], "{height}");
    }
}

#[test]
fn a_part_that_has_entered_another_part_is_held() {
    let own = [pair(0, Master::Surface(0))];
    let roll = |turn: f64| {
        move |p: Vec3| {
            let (angle, radius) = (std::f64::consts::TAU * turn * p.x, 1.0 + 0.2 * p.z);
            Vec3::new(radius * angle.cos(), radius * angle.sin(), 0.3 * p.y)
        }
    };
    let mut rest = Vec::new();
    let ring = block(24, 2, &mut rest, roll(0.9));
    for depth in [1e-9, 1e-4, 2e-3] {
        let mut x = Vec::new();
        block(24, 2, &mut x, roll(1.0 + depth / std::f64::consts::TAU));
        let mut detector = new(std::slice::from_ref(&ring), &own, &rest);
        let (contacts, _) = find(&mut detector, &x, &x);
        // At least all 23 nodes of either end that are on no edge.
        let inside = contacts.iter().filter(|c| c.gap < 0.0 && c.frame[0].y.abs() > 0.99).count();
        assert!(inside >= 40, "{depth}: {inside} of {}", contacts.len());
    }
}

#[test]
fn the_age_of_the_list_of_a_surface_against_itself_never_shows() {
    let own = [pair(0, Master::Surface(0))];
    // A ring that closes, and opens, while it flies and rotates.
    let ring_at = |step: i32| {
        let t = f64::from(step);
        let turn = 0.98 + 0.0203 * (0.05 * t).sin();
        move |p: Vec3| {
            let (angle, radius) = (std::f64::consts::TAU * turn * p.x + 0.003 * t, 1.0 + 0.2 * p.z);
            Vec3::new(radius * angle.cos() + 0.1 * t, radius * angle.sin(), 0.3 * p.y)
        }
    };
    let places = |step: i32| {
        let mut x = Vec::new();
        let ring = block(24, 2, &mut x, ring_at(step));
        (ring, x)
    };
    let (ring, start) = places(0);
    let new = || new(std::slice::from_ref(&ring), &own, &start);
    let (mut aged, mut always) = (new(), new().with_self_contact_in_every_step());
    let (mut total, mut rebuilt) = (0, 0);
    for step in 0..200 {
        let ((_, x), (_, x_end)) = (places(step), places(step + 1));
        let (from_aged, is_new) = find(&mut aged, &x, &x_end);
        assert_eq!(from_aged, find(&mut new(), &x, &x_end).0, "step {step}");
        assert_eq!(from_aged, find(&mut always, &x, &x_end).0, "step {step}");
        rebuilt += usize::from(is_new);
        total += from_aged.len();
    }
    assert!(total > 300 && rebuilt < 100, "{total} contacts, {rebuilt} lists");
}
