#![allow(clippy::float_cmp, clippy::unwrap_used)] // tests may panic; exactly is what is meant

use super::*;
use proptest::prelude::*;
use std::collections::BTreeSet;

/// Volume of a reference cell: of the pyramids from its first node to the faces, which are plane.
fn reference_volume(kind: CellKind) -> f64 {
    let place = |node: usize| Vec3::from(kind.table().points[node]) - Vec3::from(kind.table().points[0]);
    let of_face = |face: &CellFace| {
        let corners: Vec<Vec3> = face.corners.iter().map(|corner| place(*corner)).collect();
        let fan = corners[1..].windows(2).map(|edge| corners[0].dot(&edge[0].cross(&edge[1])));
        fan.sum::<f64>() / 6.0
    };
    kind.table().faces.iter().map(of_face).sum()
}

#[test]
fn reference_cells_have_known_volumes() {
    for (kind, volume) in [(CellKind::Hex8, 8.0), (CellKind::Tet10, 1.0 / 6.0), (CellKind::Wedge6, 1.0)] {
        assert!((reference_volume(kind) - volume).abs() < 1e-14, "{kind:?}");
    }
}

/// The nodes of a reference cell under a map.
fn mapped(kind: CellKind, map: impl Fn(Vec3) -> Vec3) -> Vec<Vec3> {
    kind.table().points.iter().map(|&xi| map(Vec3::from(xi))).collect()
}

const SHEAR: Mat3 = Mat3::new(2.0, 0.5, 0.1, 0.0, 3.0, 0.7, 0.3, 0.0, 4.0);

#[test]
fn a_sheared_cell_has_its_exact_volume() {
    for kind in CellKind::ALL {
        let x = mapped(kind, |xi| SHEAR * xi + Vec3::new(5.0, -3.0, 1.0));
        let exact = SHEAR.determinant() * reference_volume(kind);
        assert!((kind.volume_m3(&x) / exact - 1.0).abs() < 1e-13, "{kind:?}");
        let mirrored: Vec<Vec3> = x.iter().map(|x| Vec3::new(-x.x, x.y, x.z)).collect();
        assert!((kind.volume_m3(&mirrored) / exact + 1.0).abs() < 1e-13, "{kind:?} inside out");
    }
}

#[test]
fn curved_and_twisted_cells_have_the_volumes_of_closed_forms() {
    // A tetrahedron with the lowest face z = −4 b s (1 − s), s = ξ + η: its volume grows by ∫ 4 b s (1 − s) s ds = b/3.
    let b = 0.1;
    let bulge = |xi: Vec3| {
        let s = xi.x + xi.y;
        if xi.z == 0.0 { xi - Vec3::z() * (4.0 * b * s * (1.0 - s)) } else { xi }
    };
    let exact = 1.0 / 6.0 + b / 3.0;
    let volume = CellKind::Tet10.volume_m3(&mapped(CellKind::Tet10, bulge));
    assert!((volume - exact).abs() < 1e-14, "{volume} {exact}");

    // A wedge with its top rotated by φ: the section at t is (1 − t) + t R, of determinant (1 − t)² + 2 t (1 − t) cos φ +
    // t².
    let angle = 0.7_f64;
    let turned = |xi: Vec3| {
        let (sine, cosine) = if xi.z > 0.0 { angle.sin_cos() } else { (0.0, 1.0) };
        Vec3::new(cosine * xi.x - sine * xi.y, sine * xi.x + cosine * xi.y, xi.z)
    };
    let exact = (2.0 + angle.cos()) / 3.0;
    let volume = CellKind::Wedge6.volume_m3(&mapped(CellKind::Wedge6, turned));
    assert!((volume - exact).abs() < 1e-14, "{volume} {exact}");
}

#[test]
fn faces_look_outwards_close_the_cell_and_keep_to_their_planes() {
    for kind in CellKind::ALL {
        let table = kind.table();
        let centre = Vec3::from(table.centre);
        let mut edges = BTreeSet::new();
        let mut nodes: BTreeSet<usize> = BTreeSet::new();
        for face in table.faces {
            let corners: Vec<Vec3> = face.corners.iter().map(|&i| Vec3::from(table.points[i])).collect();
            let normal = (corners[1] - corners[0]).cross(&(corners[2] - corners[0]));
            assert!(normal.dot(&(corners[0] - centre)) > 0.0, "{kind:?} {face:?}");
            for (i, &a) in face.corners.iter().enumerate() {
                assert!(edges.insert((a, face.corners[(i + 1) % face.corners.len()])), "{kind:?} {face:?}");
            }
            // The facets lie on the face, have its orientation, and cover it.
            let area = |[a, b, c, d]: [Vec3; 4]| (c - a).cross(&(d - b)) * 0.5;
            let mut sum = Vec3::zeros();
            for facet in face.facets {
                nodes.extend(facet);
                let of_facet = area(facet.map(|i| Vec3::from(table.points[i])));
                assert!(of_facet.dot(&normal) > 0.0, "{kind:?} {facet:?}");
                sum += of_facet;
            }
            let last = corners.len() - 1;
            assert!((sum - area([corners[0], corners[1], corners[2], corners[last]])).norm() < 1e-14);
            // The face lies in one of the planes that bound the reference cell.
            let on_plane = |(n, d): &([f64; 3], f64)| {
                face.facets.iter().flatten().all(|&i| Vec3::from(*n).dot(&Vec3::from(table.points[i])) == *d)
            };
            assert_eq!(table.half_spaces.iter().filter(|plane| on_plane(plane)).count(), 1);
        }
        assert!(edges.iter().all(|&(a, b)| edges.contains(&(b, a))), "{kind:?}: each edge once each way");
        assert_eq!(edges.len(), 2 * table.edges.len());
        assert!(table.edges.iter().all(|&[a, b]| edges.contains(&(a, b))));
        assert_eq!(nodes.len(), table.points.len(), "{kind:?}: all nodes are on faces");
        assert_eq!(table.corners + table.faces.len(), table.edges.len() + 2, "Euler");
        for (corner, neighbours) in table.oblique.iter().flat_map(|o| o.neighbours).enumerate() {
            assert!(neighbours.iter().all(|&other| edges.contains(&(corner, other))), "{kind:?} {corner}");
        }
    }
}

#[test]
fn points_are_the_places_of_the_nodes_and_inside() {
    for kind in CellKind::ALL {
        let table = kind.table();
        let x = mapped(kind, |xi| SHEAR * xi);
        for (&xi, x) in table.points.iter().zip(&x) {
            assert!(((table.place)(&mapped(kind, |xi| SHEAR * xi), xi) - x).norm() < 1e-14);
            assert!(kind.contains(&Vec3::from(xi)));
            assert!(
                !kind.contains(&(Vec3::from(xi) * 1.01 - Vec3::from(table.centre) * 0.01)),
                "{kind:?} {xi:?}"
            );
        }
        assert!(kind.contains(&Vec3::from(table.centre)));
        let weights: f64 = table.quadrature.iter().map(|(_, weight)| weight).sum();
        assert!((weights - reference_volume(kind)).abs() < 1e-14);
        assert!(table.quadrature.iter().all(|(xi, _)| kind.contains(&Vec3::from(*xi))));
        assert!(table.points.len() <= MOST_NODES && table.corners <= 8);
    }
    let middle_of = |[a, b]: [usize; 2]| {
        (Vec3::from(CellKind::Tet10.table().points[a]) + Vec3::from(CellKind::Tet10.table().points[b])) / 2.0
    };
    for (i, edge) in CellKind::Tet10.table().edges.iter().enumerate() {
        assert_eq!(Vec3::from(CellKind::Tet10.table().points[4 + i]), middle_of(*edge));
    }
}

#[test]
fn ideal_cells_have_a_scaled_jacobian_of_one() {
    let height = (2.0_f64 / 3.0).sqrt();
    let regular = |xi: Vec3| {
        let (half, root) = (0.5, 3.0_f64.sqrt());
        Vec3::new(xi.x + half * xi.y + half * xi.z, root / 2.0 * xi.y + root / 6.0 * xi.z, height * xi.z)
    };
    let upright = |xi: Vec3| Vec3::new(xi.x + 0.5 * xi.y, 3.0_f64.sqrt() / 2.0 * xi.y, 0.5 * xi.z);
    for kind in CellKind::ALL {
        let x = match kind {
            CellKind::Hex8 => mapped(kind, |xi| xi * 0.5),
            CellKind::Tet4 | CellKind::Tet10 => mapped(kind, regular),
            CellKind::Wedge6 => mapped(kind, upright),
        };
        for [a, b] in kind.table().edges {
            assert!(((x[*a] - x[*b]).norm() - 1.0).abs() < 1e-14, "{kind:?}: all edges are equal");
        }
        for corner in 0..kind.table().corners {
            assert!((kind.corner_scaled_jacobian(&x, corner) - 1.0).abs() < 1e-14, "{kind:?} {corner}");
        }
        for (xi, _) in kind.table().quadrature {
            assert!((kind.scaled_jacobian(&x, *xi) - 1.0).abs() < 1e-14, "{kind:?}");
        }
    }
}

#[test]
fn foreign_orders_are_orders_and_names_are_found() {
    for kind in CellKind::ALL {
        let table = kind.table();
        for foreign in [&table.vtk, &table.gmsh] {
            let sorted: BTreeSet<usize> = foreign.order.iter().copied().collect();
            assert_eq!(sorted, (0..table.points.len()).collect());
        }
        assert_eq!(CellKind::of_gmsh(i32::from(table.gmsh.number)), Some(kind));
        assert_eq!(CellKind::of_abaqus(table.abaqus.name), Some(kind));
    }
    assert_eq!(CellKind::of_abaqus("C3D8RH"), Some(CellKind::Hex8));
    assert_eq!(CellKind::of_abaqus("C3D10M"), Some(CellKind::Tet10));
    for other in ["C3D20", "C3D8T", "C3D15", "C3D5", "S4R", "AC3D4"] {
        assert_eq!(CellKind::of_abaqus(other), None, "{other}");
    }
    // VTK's wedge begins with the triangle that faces inwards (vtkWedge of VTK 9.7, whose volume is positive then).
    let wedge = CellKind::Wedge6.table();
    let mut points = [Vec3::zeros(); 6];
    for (&place, &xi) in wedge.vtk.order.iter().zip(wedge.points) {
        points[place] = xi.into();
    }
    let normal = (points[1] - points[0]).cross(&(points[2] - points[0]));
    assert!(normal.dot(&(points[3] - points[0])) > 0.0);
}

proptest! {
    #[test]
    fn the_jacobian_is_the_derivative_of_the_place(
        which in 0_usize..4, xi in prop::array::uniform3(-0.9..0.9_f64),
        moved in prop::collection::vec(prop::array::uniform3(-0.1..0.1_f64), MOST_NODES),
    ) {
        let kind = CellKind::ALL[which];
        let table = kind.table();
        let x: Vec<Vec3> = table.points.iter().zip(&moved).map(|(xi, by)| SHEAR * Vec3::from(*xi) + Vec3::from(*by)).collect();
        let jacobian = (table.jacobian)(&x, xi);
        let h = 1e-5;
        for axis in 0..3 {
            let at = |step: f64| {
                let mut xi = xi;
                xi[axis] += step;
                (table.place)(&x, xi)
            };
            let difference = (at(h) - at(-h)) / (2.0 * h);
            prop_assert!((difference - jacobian.column(axis)).norm() < 1e-9, "{kind:?}");
        }
    }
}
