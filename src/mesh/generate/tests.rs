//! Tests of all generators: positive Jacobians, closed boundaries with outward faces, second-order convergence of volumes,
//! node sets.
#![allow(clippy::float_cmp, clippy::unwrap_used)] // tests may panic; exactly is what is meant

use super::Generator;
use super::block::Block;
use super::cylinder::Cylinder;
use super::hollow_ball::HollowBall;
use super::limb_segment::LimbSegment;
use super::solid_ball::SolidBall;
use crate::mechanics::tensor::Vec3;
use crate::mesh::quality::quality;
use crate::mesh::surface::{boundary, boundary_nodes, enclosed_volume_m3, topology_problems};
use crate::mesh::{Mesh, MeshError};
use proptest::prelude::*;

fn hollow_ball() -> HollowBall {
    HollowBall {
        center_m: [0.01, 0.02, 0.08],
        outer_radius_m: 0.015,
        inner_radius_m: 0.012,
        elements_around: 8,
        elements_through: 2,
    }
}

fn solid_ball() -> SolidBall {
    SolidBall {
        grading: 1.0,
        is_quarter: false,
        center_m: [0.0; 3],
        radius_m: 0.022,
        elements_around: 4,
        elements_through: 2,
    }
}

fn baton() -> Cylinder {
    Cylinder {
        center_m: [0.0, 0.0, 0.1],
        axis: [1.0, 2.0, -0.5],
        radius_m: 0.0185,
        length_m: 0.1,
        elements_around: 4,
        elements_through: 2,
        elements_along: 10,
    }
}

/// Valid elements (smallest scaled Jacobian at least `least`), a closed outward boundary that encloses the volume, no
/// topology problems, sorted node sets, no unused node.
fn assert_sound(mesh: &Mesh, least: f64) {
    let quality = quality(mesh).unwrap();
    assert!(
        quality.min_scaled_jacobian > least,
        "{} in {}",
        quality.min_scaled_jacobian,
        quality.worst_element
    );
    assert_eq!(quality.unused_nodes.count, 0);
    assert_eq!(quality.coincident_nodes.count, 0);
    assert_eq!(topology_problems(&mesh.cells), []);
    assert_eq!(mesh.part_of.len(), mesh.cells.len());
    let enclosed = enclosed_volume_m3(&boundary(&mesh.cells), &mesh.nodes);
    assert!((enclosed - quality.volume_m3).abs() < 1e-9 * enclosed, "{enclosed} {}", quality.volume_m3);
    for (name, set) in &mesh.node_sets {
        assert!(
            !set.is_empty() && set.windows(2).all(|w| w[0] < w[1]),
            "{name} is sorted without repetition"
        );
    }
}

/// The relative error of a volume falls by about four per refinement.
fn assert_converges(generator: &Generator, volume_m3: impl Fn(&Mesh) -> f64, exact_m3: f64) {
    let errors = [1, 2, 4].map(|factor| {
        (1.0 - volume_m3(&generator.clone().refined(factor).generate().unwrap()) / exact_m3).abs()
    });
    for pair in errors.windows(2) {
        let order = (pair[0] / pair[1]).log2();
        assert!((order - 2.0).abs() < 0.1, "order {order} of {errors:?}");
    }
}

#[test]
fn hollow_ball_converges_to_the_shell() {
    let ball = hollow_ball();
    assert_sound(&ball.generate().unwrap(), 0.7);
    assert_converges(&Generator::HollowBall(ball.clone()), Mesh::volume_m3, ball.exact_volume_m3());
    let mesh = ball.generate().unwrap();
    assert_eq!(mesh.cells.len(), 768);
    assert_eq!(mesh.notes, ["ball: faceted, 1.674 % below the exact volume 6.898937e-6 m³"]);
    for (set, radius) in [("outer", 0.015), ("inner", 0.012)] {
        assert_eq!(mesh.node_sets[set].len(), 6 * 64 + 2);
        for &a in &mesh.node_sets[set] {
            assert!(((mesh.nodes[a as usize] - Vec3::from(ball.center_m)).norm() - radius).abs() < 1e-15);
        }
    }
}

#[test]
fn solid_ball_converges_to_the_ball() {
    let ball = solid_ball();
    assert_sound(&ball.generate().unwrap(), 0.35);
    assert_converges(&Generator::SolidBall(ball.clone()), Mesh::volume_m3, ball.exact_volume_m3());
    let mesh = ball.generate().unwrap();
    assert_eq!(mesh.cells.len() as u64, ball.element_count());
    assert_eq!(mesh.node_sets["outer"], boundary_nodes(&boundary(&mesh.cells)));
}

#[test]
fn cylinder_converges_to_the_cylinder() {
    let baton = baton();
    assert_sound(&baton.generate().unwrap(), 0.5);
    assert_converges(&Generator::Cylinder(baton.clone()), Mesh::volume_m3, baton.exact_volume_m3());
    let mesh = baton.generate().unwrap();
    let (axis, center) = (Vec3::from(baton.axis).normalize(), Vec3::from(baton.center_m));
    for &a in &mesh.node_sets["side"] {
        let x = mesh.nodes[a as usize] - center;
        assert!(((x - axis * x.dot(&axis)).norm() - baton.radius_m).abs() < 1e-15);
    }
    for (set, along) in [("bottom", -0.05), ("top", 0.05)] {
        for &a in &mesh.node_sets[set] {
            assert!(((mesh.nodes[a as usize] - center).dot(&axis) - along).abs() < 1e-15);
        }
    }
    assert_eq!(mesh.node_sets["ends"].len(), 2 * mesh.node_sets["top"].len());
    let mut all = [&mesh.node_sets["side"][..], &mesh.node_sets["ends"]].concat();
    all.sort_unstable();
    all.dedup();
    assert_eq!(all, boundary_nodes(&boundary(&mesh.cells)));
}

#[test]
fn block_grades_towards_a_point() {
    let block = Block {
        min_m: [-0.05, -0.05, 0.0],
        max_m: [0.05, 0.05, 0.05],
        elements: [14, 3, 4],
        grading: Some([5.0, 1.0, 5.0]),
        grading_center_m: Some([0.0, 0.0, 0.05]),
        part: "gel".into(),
    };
    let mesh = block.generate().unwrap();
    assert_sound(&mesh, 0.999);
    assert_eq!(mesh.cells.len(), 14 * 3 * 4);
    assert!((mesh.volume_m3() - 5e-4).abs() < 1e-17);
    for (set, axis, at) in [("x_min", 0, -0.05), ("y_max", 1, 0.05), ("z_min", 2, 0.0), ("z_max", 2, 0.05)] {
        assert!(mesh.node_sets[set].iter().all(|&a| mesh.nodes[a as usize][axis] == at), "{set}");
    }
    assert_eq!(mesh.node_sets["z_max"].len(), 15 * 4);

    let fine = Generator::Block(block).refined(2).generate().unwrap();
    assert_eq!(fine.cells.len(), 8 * mesh.cells.len());
    let has = |x: &Vec3| fine.nodes.iter().any(|y| (x - y).norm() < 1e-15);
    assert!(mesh.nodes.iter().all(has));
    let thickness = |low: usize| mesh.nodes[(low + 1) * 15 * 4].z - mesh.nodes[low * 15 * 4].z;
    assert!((0..3).all(|low| thickness(low) > thickness(low + 1)), "thinnest at the top");
}

#[test]
fn limb_converges_to_its_layers() {
    let limb = LimbSegment::default();
    let mesh = limb.generate().unwrap();
    assert_sound(&mesh, 0.4);
    assert_eq!(mesh.cells.len(), 1680);
    let uniform = LimbSegment { grading_around: 1.0, ..LimbSegment::default() };
    for (part, exact) in mesh.parts.iter().zip(limb.exact_volumes_m3()) {
        assert_converges(&Generator::LimbSegment(uniform.clone()), |mesh| mesh.part_volume_m3(part), exact);
    }
}

#[test]
fn limb_has_its_sets_and_impact_on_top() {
    let limb = LimbSegment::default();
    let mesh = limb.generate().unwrap();
    let (point, normal) = limb.impact_point();
    assert_eq!((point, normal), (Vec3::new(0.0, 0.0, 0.07), Vec3::z()));
    let nearest = mesh.nodes.iter().map(|x| (x - point).norm()).fold(f64::INFINITY, f64::min);
    assert!(nearest < 1e-12, "even counts put a node at the impact, not {nearest} m away");

    assert_eq!(mesh.node_sets["bone"].len(), 20 * 13);
    for &a in &mesh.node_sets["bone"] {
        let x = mesh.nodes[a as usize];
        assert!((x.x.hypot(x.z) - 0.014).abs() < 1e-15);
    }
    for &a in &mesh.node_sets["skin_outer"] {
        let x = mesh.nodes[a as usize];
        assert!(((x.x / 0.075).hypot(x.z / 0.070) - 1.0).abs() < 1e-14);
    }
    assert!(mesh.node_sets["end_low"].iter().all(|&a| mesh.nodes[a as usize].y == -0.1));
    assert!(mesh.node_sets["end_high"].iter().all(|&a| mesh.nodes[a as usize].y == 0.1));
    let mut all: Vec<u32> = mesh.node_sets.values().flatten().copied().collect();
    all.sort_unstable();
    all.dedup();
    assert_eq!(all, boundary_nodes(&boundary(&mesh.cells)), "the sets cover the whole surface");
}

#[test]
fn layers_keep_their_thickness_and_axes_follow_the_limb() {
    let limb = LimbSegment { semi_axis_x_m: 0.09, semi_axis_z_m: 0.05, ..LimbSegment::default() };
    let mesh = limb.generate().unwrap();
    for (e, [e1, e2, e3]) in mesh.axes.iter().enumerate() {
        for (a, b, expected) in
            [(e1, e1, 1.0), (e2, e2, 1.0), (e3, e3, 1.0), (e1, e2, 0.0), (e1, e3, 0.0), (e2, e3, 0.0)]
        {
            assert!((a.dot(b) - expected).abs() < 1e-14);
        }
        assert!((e1.cross(e2) - e3).norm() < 1e-14);
        let corners = mesh.cells.points(e, &mesh.nodes);
        let outwards = corners[4] - corners[0];
        assert!(e3.dot(&outwards) > 0.0 && *e1 == Vec3::y());
        if mesh.parts[mesh.part_of[e] as usize] == "skin" {
            assert!((outwards.norm() - limb.skin_thickness_m).abs() < 1e-15);
        }
    }
}

#[test]
fn impact_angle_turns_the_fine_side() {
    let limb = LimbSegment { impact_angle_deg: 90.0, impact_along_m: 0.03, ..LimbSegment::default() };
    let (point, normal) = limb.impact_point();
    assert!((point - Vec3::new(0.075, 0.03, 0.0)).norm() < 1e-15);
    assert!((normal - Vec3::x()).norm() < 1e-15);
    let mesh = limb.generate().unwrap();
    assert_sound(&mesh, 0.4);
    // Distance along the skin between neighbouring columns of nodes, seen along the limb.
    let nearest = |x: f64| {
        let distances = mesh.node_sets["skin_outer"].iter().map(|&a| {
            let p = mesh.nodes[a as usize];
            (p.x - x).hypot(p.z)
        });
        distances.filter(|d| *d > 1e-6).fold(f64::INFINITY, f64::min)
    };
    assert!(nearest(-0.075) > 5.0 * nearest(0.075), "{} {}", nearest(-0.075), nearest(0.075));
}

#[test]
fn all_problems_come_at_once_with_field_value_limit_and_remedy() {
    let ball =
        HollowBall { outer_radius_m: -1.0, inner_radius_m: f64::NAN, elements_through: 0, ..hollow_ball() };
    let fields: Vec<String> = ball.problems().into_iter().map(|p| p.field).collect();
    assert_eq!(fields, ["outer_radius_m", "inner_radius_m", "elements_through"]);
    let Err(MeshError::Parameters { generator, problems }) = ball.generate() else { panic!("must fail") };
    assert_eq!((generator, problems.len()), ("hollow_ball", 3));

    let limb = LimbSegment { bone_offset_m: [0.06, 0.0], ..LimbSegment::default() };
    let problems = limb.problems();
    assert_eq!(problems[0].field, "bone_semi_axis_x_m");
    assert!(problems[0].limit.contains("extends by 0.00"), "{}", problems[0]);
    let limb = LimbSegment { bone_offset_m: [0.0, 0.2], ..LimbSegment::default() };
    assert_eq!(limb.problems()[0].field, "bone_semi_axis_x_m", "a bone wholly outside is found too");
    let limb = LimbSegment { fat_thickness_m: 0.064, ..LimbSegment::default() };
    assert_eq!(limb.problems()[0].field, "fat_thickness_m");
    let limb = LimbSegment { skin_thickness_m: 0.064, ..LimbSegment::default() };
    assert_eq!(limb.problems()[0].field, "skin_thickness_m");
    let limb = LimbSegment { elements_around: 6, ..LimbSegment::default() };
    assert_eq!(limb.problems()[0].field, "elements_around");

    let huge = SolidBall { elements_around: u32::MAX, elements_through: u32::MAX, ..solid_ball() };
    assert_eq!(huge.problems()[0].field, "element_count");
    assert!(Generator::Cylinder(baton()).refined(u32::MAX).generate().is_err());
    let cut = Block {
        grading: Some([2.0, 0.5, 1.0]),
        grading_center_m: Some([0.5, 9.0, 1.0]),
        ..Block::uniform(Vec3::zeros(), Vec3::repeat(1.0), [1, 0, 1], "b")
    };
    let fields: Vec<String> = cut.problems().into_iter().map(|p| p.field).collect();
    assert_eq!(fields, ["elements[1]", "grading[1]", "grading_center_m[1]"]);
}

#[test]
fn a_quarter_of_a_graded_ball_is_a_quarter_of_it() {
    let center_m = [0.1, -0.2, 0.3];
    let whole = SolidBall { elements_around: 8, elements_through: 4, grading: 6.0, center_m, ..solid_ball() };
    let quarter = SolidBall { is_quarter: true, ..whole.clone() };
    let (all, part) = (whole.generate().unwrap(), quarter.generate().unwrap());
    assert_sound(&all, 0.1);
    assert_sound(&part, 0.1);
    assert_eq!(4 * part.cells.len(), all.cells.len());
    assert_eq!(part.cells.len() as u64, quarter.element_count());
    assert!((4.0 * part.volume_m3() / all.volume_m3() - 1.0).abs() < 1e-12);
    for (axis, name) in ["x_min", "y_min"].into_iter().enumerate() {
        let nodes = &part.node_sets[name];
        let on_plane = part.nodes.iter().filter(|X| X[axis] == center_m[axis]).count();
        assert!(nodes.len() > 40 && nodes.len() == on_plane, "{} of {on_plane}", nodes.len());
        assert!(part.nodes.iter().all(|X| X[axis] >= center_m[axis]));
    }
    let odd = SolidBall { elements_around: 5, ..quarter };
    let fields: Vec<String> = odd.problems().into_iter().map(|p| p.field).collect();
    assert_eq!(fields, ["elements_around"]);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]

    #[test]
    fn solid_balls_and_cylinders_are_sound_for_all_counts(n in 1_u32..9, m in 1_u32..7, along in 1_u32..4) {
        assert_sound(&SolidBall { elements_around: n, elements_through: m, ..solid_ball() }.generate().unwrap(), 0.1);
        let baton = Cylinder { elements_around: n, elements_through: m, elements_along: along, ..baton() };
        assert_sound(&baton.generate().unwrap(), 0.1);
    }

    #[test]
    fn hollow_balls_are_sound_for_all_walls(n in 1_u32..9, m in 1_u32..4, inner in 0.001..0.0149_f64) {
        let ball = HollowBall { elements_around: n, elements_through: m, inner_radius_m: inner, ..hollow_ball() };
        assert_sound(&ball.generate().unwrap(), 0.1);
    }

    #[test]
    fn every_limb_without_problems_is_sound(
        x in 0.03..0.1_f64, z in 0.03..0.1_f64, bone_x in 0.005..0.03_f64, bone_z in 0.005..0.03_f64,
        offset_x in -0.03..0.03_f64, offset_z in -0.03..0.03_f64, fat in 0.001..0.02_f64,
        around in 6_u32..30, muscle in 1_u32..4, angle in -180.0..180.0_f64, along in -0.09..0.09_f64,
        grading_around in 1.0..15.0_f64, grading_along in 1.0..15.0_f64,
    ) {
        let limb = LimbSegment {
            semi_axis_x_m: x, semi_axis_z_m: z, bone_semi_axis_x_m: bone_x, bone_semi_axis_z_m: bone_z,
            bone_offset_m: [offset_x, offset_z], fat_thickness_m: fat, elements_around: around,
            elements_along: 5, muscle_elements: muscle, impact_angle_deg: angle, impact_along_m: along,
            grading_around, grading_along, ..LimbSegment::default()
        };
        match limb.generate() {
            Ok(mesh) => assert_sound(&mesh, 0.0),
            Err(error) => prop_assert!(!limb.problems().is_empty(), "{error}"),
        }
    }
}
