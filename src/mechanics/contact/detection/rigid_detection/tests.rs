use super::*;
use crate::contact::solution::gauss_seidel::{Options, Workspace, solve_with_rigid};
use crate::contact::{ContactLaw, Reaction, RigidSides};
use crate::rigid::{Rotation, Shape};
use std::slice::from_ref;

/// Rigid bodies with their pairs, at rest.
struct Pile {
    bodies: Vec<RigidBody>,
    poses: Vec<Pose>,
    x: Vec<Vec3>,
    inverse_mass: Vec<Vec3>,
    pairs: Vec<ContactPair>,
    of_pairs: Vec<[Option<u32>; 2]>,
}

impl Pile {
    /// Bodies of 1 kg, each paired with the next, and the first with the plane z = 0.
    fn new(shapes: &[(Shape, Vec3, Rotation)], mu: f64) -> Self {
        let mut all = Self {
            bodies: Vec::new(),
            poses: Vec::new(),
            x: Vec::new(),
            inverse_mass: Vec::new(),
            pairs: Vec::new(),
            of_pairs: Vec::new(),
        };
        for (i, (shape, centre, orientation)) in shapes.iter().enumerate() {
            let node = 2 * i as u32;
            let inertia = shape.inertia_per_mass();
            all.bodies.push(RigidBody {
                centre: node,
                spin: node + 1,
                shape: shape.clone(),
                mass: 1.0,
                inertia,
            });
            all.poses.push(Pose { centre: *centre, orientation: *orientation });
            all.x.extend([*centre; 2]);
            all.inverse_mass.extend([Vec3::repeat(1.0), inertia.map(|i| 1.0 / i)]);
            let law = ContactLaw::of(mu);
            let (master, sides) = if i == 0 {
                (Master::Plane { point: Vec3::zeros(), normal: Vec3::z() }, [Some(0), None])
            } else {
                (Master::Rigid(i - 1), [Some(i as u32), Some(i as u32 - 1)])
            };
            all.pairs.push(ContactPair { slave: i, master, law });
            all.of_pairs.push(sides);
        }
        all
    }

    fn contacts(&self) -> Vec<Contact> {
        let surface = |body: &RigidBody| Surface::new(vec![body.centre], Vec::new());
        let surfaces: Vec<Surface> = self.bodies.iter().map(surface).collect();
        let mut detector = RigidDetector::new(&surfaces, (&self.pairs, 0), &self.bodies, &self.x);
        let motion = Motion { x: &self.x, x_end: &self.x, poses: &self.poses, poses_end: &self.poses };
        let mut contacts = Vec::new();
        detector.detect(&motion, &mut contacts).unwrap();
        for contact in &mut contacts {
            contact.law = self.pairs[contact.pair as usize].law;
        }
        contacts
    }
}

#[test]
fn a_pile_of_boxes_under_its_weight_comes_to_rest_in_few_sweeps() {
    for count in [2_usize, 5, 10] {
        let half = Vec3::repeat(0.05);
        let shapes: Vec<_> = (0..count)
            .map(|i| {
                let centre = Vec3::new(0.0, 0.0, 0.05 + 0.1 * i as f64);
                (Shape::Box { half }, centre, Rotation::identity())
            })
            .collect();
        for mu in [0.0, 0.3] {
            let pile = Pile::new(&shapes, mu);
            let contacts = pile.contacts();
            let mut v: Vec<Vec3> = (0..2 * count)
                .map(|i| if i % 2 == 0 { Vec3::new(0.0, 0.0, -0.01) } else { Vec3::zeros() })
                .collect();
            let rigid =
                RigidSides { of_pairs: &pile.of_pairs, first: 0, bodies: &pile.bodies, poses: &pile.poses };
            let mut reactions: Vec<Reaction> = Vec::new();
            let options = Options { max_sweeps: 20_000, ..Options::default() };
            let report = solve_with_rigid(
                &contacts,
                &rigid,
                &pile.inverse_mass,
                1e-3,
                &mut v,
                &mut reactions,
                &options,
                &mut Workspace::default(),
            );
            let fastest = v.iter().map(Vec3::amax).fold(0.0, f64::max);
            assert_eq!(contacts.len(), 4 * count, "four corners a face");
            assert!(report.converged && report.sweeps < 50 * count, "{count} boxes, μ = {mu}: {report:?}");
            assert!(fastest < 1e-9, "{fastest:e}");
        }
    }
}

#[test]
fn a_node_is_activated_at_any_speed_where_it_meets_the_shape() {
    let shapes = [
        Shape::Ball { radius: 0.05 },
        Shape::Box { half: Vec3::new(0.05, 0.002, 0.05) },
        Shape::Cylinder { radius: 0.05, half_length: 0.001 },
        Shape::Capsule { radius: 0.01, half_length: 0.04 },
    ];
    for shape in shapes {
        let pile = Pile::new(
            &[(shape.clone(), Vec3::new(0.0, 0.0, 1.0), Rotation::from_euler_angles(0.2, 0.1, 0.0))],
            0.0,
        );
        let surface = Surface::new(vec![2], vec![[2; 4]]);
        let pair = ContactPair { slave: 0, master: Master::Rigid(0), law: ContactLaw::Frictionless };
        for reach in [1e-3, 0.1, 10.0, 1e4] {
            // From outside, through the centre.
            let from = pile.poses[0].place(&Vec3::new(0.003, 0.06, 0.001));
            let to = from + (pile.poses[0].centre - from).normalize() * reach;
            let with = |node: Vec3| [pile.x[0], pile.x[1], node];
            let (x, x_end) = (with(from), with(to));
            let mut detector = RigidDetector::new(from_ref(&surface), (from_ref(&pair), 0), &pile.bodies, &x);
            let motion = Motion { x: &x, x_end: &x_end, poses: &pile.poses, poses_end: &pile.poses };
            let mut contacts = Vec::new();
            detector.detect(&motion, &mut contacts).unwrap();
            let ends_inside_or_beyond = reach > 0.059;
            assert_eq!(contacts.len(), usize::from(ends_inside_or_beyond), "{shape:?} {reach}");
            for contact in contacts {
                let (left, _) = shape.eval_distance(&pile.poses[0].local(&contact.point));
                assert!(left.abs() < 1e-6, "the point lies on the surface, off by {left:e}");
                let closing = contact.frame[0].dot(&(to - from));
                assert!(closing < 0.0 && contact.gap > 0.0 && contact.gap < -closing);
            }
        }
    }
}
