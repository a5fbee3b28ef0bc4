//! Interpenetration of the two sides of each pair, measured on the elements rather than on the list of contacts.
//!
//! A point is inside a mesh if one of its elements contains it ([`Locator`]), inside a rigid body if the signed
//! distance of its shape is negative, and inside a plane if it lies behind it. Its depth is the distance to the nearest
//! boundary face. Depth is evaluated at the boundary nodes of both sides (for a rigid body, at points of its surface),
//! volume at the Gauss points of the elements (for a rigid body, on a lattice), so that edges crossing between their
//! nodes show up in the volume. Between the nodes of a mesh on a round rigid body no volume counts as shared up to the depth that contact
//! leaves there ([`left_to_nodes`]). A node is inside its own body if the boundary surface winds around the place just
//! outside of it ([`nodes_inside`](crate::mechanics::contact::detection::winding::nodes_inside)).
//!
//! Of a symmetric scene two bodies are compared in the part that is computed, whose points count for their mirror images; a point beyond
//! a plane of symmetry is looked for at its mirror image.

mod look;
mod mesh;
mod side;

use super::computed::Computed;
use crate::mechanics::contact::Master;
use crate::mechanics::contact::detection::bodies::meeting;
use crate::mechanics::tensor::Vec3;
use crate::step::Frame;
use look::{look, smaller_volume};
use mesh::{Found, Mesh};
use side::Side;
use std::cell::OnceCell;

/// Penetration depth over face size above which the results of a run are withheld [-].
pub const DEPTH_LIMIT: f64 = 0.1;
/// Overlapping volume over the volume of the smaller body above which the results are withheld [-].
pub const OVERLAP_LIMIT: f64 = 0.01;
/// Remedy for a penetration or overlap beyond its limit.
pub const TOO_DEEP: &str = "Refine the coarser of the two surfaces, or lower the speed; in an implicit run shorten the steps. \
                            Where soft bodies crush each other to folds no mesh keeps them apart.";

/// The deepest penetration and the largest overlap at the look times.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Penetration {
    /// Depth with the largest fraction of a face size so far.
    pub deepest: Depth,
    /// Overlap with the largest fraction of a body volume so far.
    pub largest: Overlap,
}

/// Depth of a point inside another body.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Depth {
    /// Depth of the point below the surface [m].
    pub depth: f64,
    /// Depth over the size (√area) of the nearest face; for a rigid body over the mean face size of the other side
    /// (between rigid bodies and planes over the smallest thickness) [-].
    pub fraction: f64,
    /// The fraction that contact leaves to the nodes of a mesh on a round rigid body [-].
    pub left_to_nodes: f64,
    /// Names of the bodies involved.
    pub between: String,
    /// Time of the maximum [s].
    pub time: f64,
}

/// A volume occupied by two bodies at once.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Overlap {
    /// Volume occupied by both bodies [m³].
    pub volume: f64,
    /// Overlapping volume over the volume of the smaller body [-].
    pub fraction: f64,
    /// Names of the bodies involved.
    pub between: String,
    /// Time of the maximum [s].
    pub time: f64,
}

impl Penetration {
    /// Accumulates a frame at a look time, when all displacements are known, given that of the whole and that of what is computed of it
    /// ([`ComputedMotion`](super::computed::ComputedMotion)). `touched`: whether a pair has been in contact so far; a body that has not
    /// touched itself cannot have entered itself.
    pub fn accumulate(&mut self, [whole, own]: [&Frame; 2], touched: impl Fn(usize) -> bool) {
        // Current positions; non-finite ones end the run with a failure of their own.
        let plan = own.plan;
        let Some(contact) = &plan.contact else { return };
        let x = positions(own);
        if !x.iter().all(|x| x.iter().all(|c| c.is_finite())) {
            return;
        }
        let planes = Computed::of(whole.plan).planes();
        let sides: Vec<Side> =
            (0..plan.bodies.len()).map(|body| Side::of_body(own, body, &x).in_images_of(planes)).collect();
        // Each pair once; with itself only after contact.
        let x_of_whole = OnceCell::new();
        let listed = contact.pairs.listed().map(|(index, pair)| (index, *pair));
        let every = contact.pairs.every_two();
        let boxes: Vec<[Vec3; 2]> =
            every.surfaces().map(|surface| sides[contact.surface_body[surface]].bounds()).collect();
        let number = |(first, second)| contact.pairs.unlisted().start + every.number(first, second);
        let unlisted = meeting(&boxes).into_iter().map(number).map(|index| (index, contact.pairs.get(index)));
        for (index, pair) in listed.chain(unlisted) {
            let (slave, master) = contact.bodies_of(&pair);
            let side = &sides[slave];
            let mut keep = |found: Found, volume: &dyn Fn() -> f64| {
                if found.depth > 0.0 || found.volume > 0.0 {
                    self.keep(&plan.name_of(index), own.time, found, volume);
                }
            };
            match (&pair.master, master, side) {
                (Master::Plane { point, normal }, ..) => {
                    let found = look([side, &Side::Plane(*point, *normal)], planes);
                    keep(found, &|| smaller_volume(side, None));
                }
                (_, Some(master), _) if master != slave => {
                    let other = &sides[master];
                    keep(look([side, other], planes), &|| smaller_volume(side, Some(other)));
                }
                // A body may meet its own mirror image: the whole of it is searched.
                (.., Side::Mesh(_)) if touched(index) => {
                    let x = x_of_whole.get_or_init(|| positions(whole));
                    let mesh = Mesh::new(&whole.plan.bodies[slave], whole.erosion, x);
                    keep(mesh.look_at_itself(), &|| mesh.volume_up_to(f64::INFINITY));
                }
                _ => {}
            }
        }
    }

    /// Describes what exceeded its limit.
    pub fn excess(&self) -> Option<String> {
        let Self { deepest, largest } = self;
        let said = |fraction: f64, of: &str, between: &str, time: f64, limit: f64| {
            let [fraction, limit] = [fraction, limit].map(|x| 100.0 * x);
            (fraction > limit).then(|| {
                format!("{between}: at {:.2} ms {fraction:.1} % of {of} (limit {limit:.0} %)", 1e3 * time)
            })
        };
        let deep = said(deepest.fraction, "a face deep inside", &deepest.between, deepest.time, DEPTH_LIMIT);
        deep.or_else(|| {
            said(largest.fraction, "the volume shared", &largest.between, largest.time, OVERLAP_LIMIT)
        })
    }

    /// Keeps the maxima, given the volume of the smaller body, evaluated on demand.
    fn keep(&mut self, between: &str, time: f64, found: Found, smaller: impl FnOnce() -> f64) {
        let Found { depth, fraction, left_to_nodes, volume } = found;
        if fraction > self.deepest.fraction {
            let between = between.to_owned();
            self.deepest = Depth { depth, fraction, left_to_nodes, between, time };
        }
        let fraction = if volume > 0.0 { volume / smaller() } else { 0.0 };
        if fraction > self.largest.fraction {
            self.largest = Overlap { volume, fraction, between: between.to_owned(), time };
        }
    }
}

/// Current positions of all nodes of a frame [m].
fn positions(frame: &Frame) -> Vec<Vec3> {
    let bodies = frame.plan.bodies.iter().enumerate();
    bodies
        .flat_map(|(index, body)| body.nodes.clone().map(move |node| frame.position_in(index, node)))
        .collect()
}

#[cfg(test)]
#[allow(clippy::unwrap_used)] // tests may panic
mod tests {
    use super::*;
    use crate::mechanics::force::Erosion;
    use crate::mechanics::rigid::{Pose, Rotation, Shape};
    use crate::plan::{Plan, compile};
    use crate::scene::{Budget, NoFiles, load};
    use serde_json::json;
    use std::f64::consts::PI;

    /// Two blocks of 2×2×2 elements and 1 m edges, one on top of the other.
    fn blocks() -> Plan {
        let block = |name: &str, low: f64| {
            json!({
                "name": name,
                "mesh": {"generator": {"kind": "block", "min_m": [0, 0, low], "max_m": [1, 1, low + 1.0], "elements": [2, 2, 2]}},
                "parts": [{"part": "*", "density_kg_per_m3": 1000, "material":
                    {"law": "neo_hookean", "c10_pa": 1e4, "bulk_modulus_pa": 1e6}}]
            })
        };
        let scene =
            json!({"name": "blocks", "end_time_s": 1e-3, "bodies": [block("a", 0.0), block("b", 1.0)]});
        let loaded = load(&serde_json::to_vec(&scene).unwrap(), &NoFiles, &Budget::COMMAND_LINE).unwrap();
        compile(&loaded.scene).unwrap()
    }

    #[test]
    fn a_block_in_a_block_has_its_depth_and_its_volume() {
        let plan = blocks();
        for (depth, volume) in [(-0.01, 0.0), (0.0, 0.0), (0.25, 0.25)] {
            let mut x = plan.X.clone();
            for node in plan.bodies[1].nodes.clone() {
                // Offset, so that no node lies on an edge of the other block.
                x[node as usize] += Vec3::new(0.1, 0.2, -depth);
            }
            let [a, b] = [0, 1].map(|body| Side::Mesh(Mesh::new(&plan.bodies[body], Erosion::none(), &x)));
            let found = look([&a, &b], &[]);
            assert!((found.depth - f64::max(depth, 0.0)).abs() < 1e-12, "{depth}: {}", found.depth);
            assert!((found.fraction - 2.0 * f64::max(depth, 0.0)).abs() < 1e-12);
            // A Gauss point represents an eighth of an element: the overlap is exact along z, and within 15 %
            // laterally.
            assert!((found.volume - volume * 0.9 * 0.8).abs() <= 0.15 * volume, "{depth}: {}", found.volume);
        }
    }

    #[test]
    fn a_quarter_has_the_depth_and_the_volume_of_the_whole() {
        let plan = blocks();
        let computed = Computed::of(&plan);
        assert_eq!(computed.planes().len(), 2);
        // The upper block is narrower and bulges into the lower one: it is deepest at nodes on the planes of symmetry.
        let positions = |plan: &Plan| {
            let mut x = plan.X.clone();
            for node in plan.bodies[1].nodes.clone() {
                let x = &mut x[node as usize];
                let across = [x.x - 0.5, x.y - 0.5].map(|d| 0.9 * d);
                let bulge = 0.2 - 0.3 * (across[0].powi(2) + across[1].powi(2));
                *x = Vec3::new(0.5 + across[0], 0.5 + across[1], x.z - bulge);
            }
            x
        };
        let [whole, quarter] = [&plan, computed.plan].map(|of| {
            let x = positions(of);
            let planes = if std::ptr::eq(of, &raw const plan) { &[][..] } else { computed.planes() };
            let [a, b] = [0, 1].map(|body| {
                Side::Mesh(Mesh::new(&of.bodies[body], Erosion::none(), &x)).in_images_of(planes)
            });
            (look([&a, &b], planes), smaller_volume(&a, Some(&b)))
        });
        assert!(whole.0.depth > 0.19 && whole.0.volume > 0.05, "{} {}", whole.0.depth, whole.0.volume);
        let pairs = |found: &(Found, f64)| [found.0.depth, found.0.fraction, found.0.volume, found.1];
        for (whole, quarter) in pairs(&whole).into_iter().zip(pairs(&quarter)) {
            assert!((whole - quarter).abs() <= 1e-9 * whole, "{quarter}, not {whole}");
        }
    }

    #[test]
    fn a_ball_behind_a_plane_and_two_boxes_have_the_depth_and_volume_of_the_closed_forms() {
        let pose = |z: f64| Pose { centre: Vec3::new(0.3, 0.1, z), orientation: Rotation::identity() };
        let (radius, depth) = (0.5, 0.25);
        let ball = Side::Rigid(Shape::Ball { radius }, pose(radius - depth));
        let found = look([&ball, &Side::Plane(Vec3::zeros(), Vec3::z())], &[]);
        let cap = PI * depth * depth * (3.0 * radius - depth) / 3.0;
        assert!((found.depth / depth - 1.0).abs() < 0.01, "{}", found.depth);
        assert!((found.volume / cap - 1.0).abs() < 0.15, "{} for {cap}", found.volume);

        let shape = Shape::Box { half: Vec3::repeat(0.5) };
        let apart = [0.0, 1.01].map(|z| Side::Rigid(shape.clone(), pose(z)));
        let apart = look([&apart[0], &apart[1]], &[]);
        assert!(apart.depth == 0.0 && apart.volume == 0.0);
        let [a, b] = [0.0, 0.7].map(|z| Side::Rigid(shape.clone(), pose(z)));
        let found = look([&a, &b], &[]);
        assert!(
            (found.depth - 0.3).abs() < 1e-12 && (found.volume / 0.3 - 1.0).abs() < 0.15,
            "{}",
            found.volume
        );
    }

    #[test]
    fn a_much_larger_body_is_not_evaluated_as_a_whole() {
        let plan = blocks();
        let [a, b] = [0, 1].map(|body| Side::Mesh(Mesh::new(&plan.bodies[body], Erosion::none(), &plan.X)));
        let pose = Pose { centre: Vec3::zeros(), orientation: Rotation::identity() };
        let ball = Side::Rigid(Shape::Ball { radius: 0.3 }, pose);
        let (small, large) = (4.0 / 3.0 * PI * 0.027, Side::Rigid(Shape::Ball { radius: 3.0 }, pose));
        for (body, other, volume) in
            [(&a, &ball, small), (&ball, &a, small), (&a, &large, 1.0), (&a, &b, 1.0)]
        {
            assert!((smaller_volume(body, Some(other)) - volume).abs() < 1e-12, "{volume}");
        }
        assert!((smaller_volume(&a, None) - 1.0).abs() < 1e-12);
        // The volume of the ball is reached by one of the eight elements.
        assert!((a.volume_up_to(small) - 0.125).abs() < 1e-12);
    }
}
