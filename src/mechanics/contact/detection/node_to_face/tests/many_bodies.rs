//! Pairs of every two of many surfaces.

use super::*;
use crate::contact::detection::edges::BENT;
use crate::contact::detection::guard::Guard;
use crate::contact::detection::mortar::Mortar;
use crate::contact::pairs::EveryTwo;

#[test]
fn pairs_that_are_not_listed_have_the_contacts_of_listed_ones() {
    // Blocks of different meshes in a ring, which move past each other; only neighbours meet.
    let (mut x, mut surfaces) = (Vec::new(), Vec::new());
    for i in 0..8_u32 {
        let angle = f64::from(i) * std::f64::consts::TAU / 8.0;
        let centre = Vec3::new(1.25 * angle.cos(), 1.25 * angle.sin(), 0.1 * angle);
        surfaces.push(block(2 + i % 3, 2, &mut x, |p| centre + (p - Vec3::repeat(0.5)) * 0.95));
    }
    let sizes = (0..8_usize).map(|i| (i, 0.95 / (2 + i % 3) as f64)).collect();
    let unlisted = Pairs::new(Vec::new(), EveryTwo::new(sizes, ContactLaw::Frictionless), Vec::new());
    let listed: Pairs = unlisted.each().map(|(_, pair)| pair).collect();
    for is_mortar in [false, true] {
        let of = |pairs: &Pairs| {
            let surfaces = PairSurfaces::new(&surfaces, pairs, &x);
            let nodes = NodeToFace::of(surfaces.clone(), &x);
            let bent = if is_mortar { f64::INFINITY } else { BENT };
            let detector: Box<dyn Detector> =
                if is_mortar { Box::new(Mortar::new(nodes)) } else { Box::new(nodes) };
            (detector, Guard::new(&surfaces, bent, &x))
        };
        let (mut aged, mut all) = (of(&unlisted), of(&listed));
        let mut near = NodeToFace::new(&surfaces, &unlisted, &x);
        let (mut x, mut total, mut most) = (x.clone(), 0, 0);
        for step in 0..100 {
            let t = f64::from(step);
            let moved = |(i, p): (usize, &Vec3)| {
                let turn = Vec3::new(-p.y, p.x, 0.0) * (0.01 * (0.2 * t + (i / 9) as f64).sin());
                let jump = if step == 50 && i < 20 { Vec3::new(-1.0, 1.0, 0.0) } else { Vec3::zeros() };
                p + turn + p * (0.004 * (0.3 * t).sin()) + jump
            };
            let x_end: Vec<Vec3> = x.iter().enumerate().map(moved).collect();
            let mut found = [Vec::new(), Vec::new()];
            for (found, (detector, guard)) in found.iter_mut().zip([&mut aged, &mut all]) {
                detector.detect(&Motion::of_nodes(&x, &x_end), found).unwrap();
                guard.detect(&Motion::of_nodes(&x, &x_end), found).unwrap();
            }
            assert_eq!(found[0], found[1], "step {step}");
            near.detect(&Motion::of_nodes(&x, &x_end), &mut Vec::new()).unwrap();
            (total, most) = (total + found[0].len(), most.max(near.states.len()));
            x = x_end;
        }
        assert_eq!(NodeToFace::new(&surfaces, &listed, &x).states.len(), 28);
        assert!(total > 500 && most < 28, "{total} contacts, {most} pairs");
    }
}
