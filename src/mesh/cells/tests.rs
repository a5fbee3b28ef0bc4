#![allow(clippy::float_cmp, clippy::unwrap_used)] // tests may panic; exactly is what is meant

use super::*;
use crate::mesh::distance::DepthField;
use crate::mesh::generate::block::Block;
use crate::mesh::locate::Locator;
use crate::mesh::quality::quality;
use crate::mesh::read::{MeshFormat, read_mesh};
use crate::mesh::refine::refined;
use crate::mesh::surface::{
    Boundary, TopologyProblem, boundary, boundary_nodes, enclosed_volume_m3, topology_problems,
    tributary_areas,
};
use crate::mesh::triangulated_surface::TriangulatedSurface;
use crate::mesh::write::gmsh::{Encoding, Version, write_gmsh};
use crate::mesh::{Mesh, MeshError};
use std::collections::BTreeSet;

const HEX: [u32; 8] = [0, 1, 2, 3, 4, 5, 6, 7];
const TET: [u32; 4] = [4, 5, 6, 8];

#[test]
fn mixed_kinds_keep_order_and_nodes() {
    let mut cells = Cells::default();
    let pushed = [
        (CellKind::Tet4, &TET[..]),
        (CellKind::Tet4, &TET[..]),
        (CellKind::Hex8, &HEX[..]),
        (CellKind::Wedge6, &HEX[2..]),
        (CellKind::Tet4, &HEX[..4]),
    ];
    for (kind, nodes) in pushed {
        cells.push(kind, nodes);
    }
    assert_eq!(cells.len(), pushed.len());
    for (i, (kind, nodes)) in pushed.into_iter().enumerate() {
        assert_eq!((cells.kind(i), cells.nodes(i)), (kind, nodes));
    }
    assert_eq!(cells.counts(), [(CellKind::Hex8, 1), (CellKind::Tet4, 3), (CellKind::Wedge6, 1)]);
    assert_eq!(cells.hexes(), None);
    let moved = cells.map(|node| node + 10);
    assert_eq!((moved.kind(3), moved.nodes(3)), (CellKind::Wedge6, &[12, 13, 14, 15, 16, 17][..]));
    assert_eq!(cells.iter().collect::<Cells>(), cells);
    assert_eq!(cells.try_map(|cell, node| if cell < 2 { Ok(node) } else { Err(cell) }), Err(2));
}

#[test]
fn hexahedra_alone_are_arrays_of_eight() {
    let cells = Cells::from(vec![HEX; 3]);
    assert_eq!(cells.hexes(), Some(&[HEX; 3][..]));
    let mut pushed = Cells::default();
    assert_eq!(pushed.hexes(), Some(&[][..]));
    pushed.extend([HEX; 3]);
    assert_eq!(pushed, cells);
    assert_eq!(cells.counts(), [(CellKind::Hex8, 3)]);
    pushed.push(CellKind::Tet4, &TET);
    assert_eq!((pushed.len(), pushed.hexes()), (4, None));
    assert_eq!(Cells::<u32>::default().counts(), []);
}

/// Replaces the hexahedra of a mesh by cells of the kinds given by `kind`; those with `None` are omitted.
fn remeshed(hexes: &Mesh, kind: impl Fn(usize) -> Option<CellKind>) -> Mesh {
    let mut mesh = Mesh { cells: Cells::default(), part_of: Vec::new(), ..hexes.clone() };
    let given = hexes.nodes.len();
    // For each kind, the cells that fill the hexahedra, on the given nodes and new ones.
    let fillings = CellKind::ALL.map(|kind| {
        let Mesh { nodes, cells, .. } = hexes.split_to(kind);
        let before = (mesh.nodes.len() - given) as u32;
        mesh.nodes.extend(&nodes[given..]);
        (kind, cells.map(|node| if (node as usize) < given { node } else { node + before }))
    });
    for e in 0..hexes.cells.len() {
        for (kind, cells) in fillings.iter().filter(|filling| Some(filling.0) == kind(e)) {
            let each = cells.len() / hexes.cells.len();
            (e * each..(e + 1) * each).for_each(|cell| mesh.cells.push(*kind, cells.nodes(cell)));
        }
    }
    mesh.part_of = vec![0; mesh.cells.len()];
    mesh.drop_unused_nodes();
    mesh
}

/// A box of 6 × 4 × 1 m, 24 m³, made of cells of one kind.
fn block_of(kind: CellKind) -> Mesh {
    let block = Block::uniform(Vec3::zeros(), Vec3::new(6.0, 4.0, 1.0), [3, 2, 1], "b").generate().unwrap();
    remeshed(&block, |_| Some(kind))
}

/// Three cubes of 1 m in an L: tetrahedra, wedges on them, a hexahedron next to those.
fn mixed() -> Mesh {
    let block = Block::uniform(Vec3::zeros(), Vec3::new(2.0, 1.0, 2.0), [2, 1, 2], "b").generate().unwrap();
    let kinds = [Some(CellKind::Tet4), None, Some(CellKind::Wedge6), Some(CellKind::Hex8)];
    remeshed(&block, |e| kinds[e])
}

/// All test meshes, with their volume [m³].
fn meshes() -> Vec<(String, Mesh, f64)> {
    let of_one = CellKind::ALL.map(|kind| (format!("{kind:?}"), block_of(kind), 24.0));
    of_one.into_iter().chain([("mixed".into(), mixed(), 3.0)]).collect()
}

/// Bends a point, so that faces with four corners are warped.
fn bent(x: &Vec3) -> Vec3 {
    let (sine, cosine) = (0.1 * x.x).sin_cos();
    Vec3::new((x.z + 10.0) * sine, x.y + 0.05 * x.x * x.z, (x.z + 10.0) * cosine + 0.03 * x.x * x.y)
}

/// Euler characteristic: nodes − edges + faces.
fn euler_characteristic(faces: &[[u32; 4]]) -> i64 {
    let mut edges = BTreeSet::new();
    for face in faces {
        let n = if face[2] == face[3] { 3 } else { 4 };
        edges.extend((0..n).map(|i| (face[i].min(face[(i + 1) % n]), face[i].max(face[(i + 1) % n]))));
    }
    i64::try_from(boundary_nodes(faces).len() + faces.len()).unwrap() - i64::try_from(edges.len()).unwrap()
}

#[test]
fn meshes_of_every_kind_are_sound_and_closed() {
    for (name, mesh, exact) in meshes() {
        assert_eq!(topology_problems(&mesh.cells), [], "{name}");
        assert!((mesh.volume_m3() / exact - 1.0).abs() < 1e-13, "{name}");
        let boundary = Boundary::of(&mesh.cells);
        assert!((enclosed_volume_m3(&boundary.faces, &mesh.nodes) / exact - 1.0).abs() < 1e-13, "{name}");
        assert_eq!(euler_characteristic(&boundary.faces), 2, "{name}");
        let area: f64 = tributary_areas(&boundary.faces, &mesh.nodes).iter().sum();
        let sides = if name == "mixed" { 14.0 } else { 2.0 * (24.0 + 6.0 + 4.0) };
        assert!((area / sides - 1.0).abs() < 1e-13, "{name}: {area}");
        for (face, (&owner, &side)) in boundary.faces.iter().zip(boundary.owner.iter().zip(&boundary.side)) {
            let cell = mesh.cells.get(owner as usize);
            let facets = cell.kind.table().faces[usize::from(side)].facets;
            assert!(facets.iter().any(|facet| facet.map(|i| cell.nodes[i]) == *face), "{name}");
        }
        let quality = quality(&mesh).unwrap();
        assert!(
            quality.min_scaled_jacobian > 0.2 && quality.volume_m3 == mesh.volume_m3(),
            "{name}: {quality:?}"
        );
        assert_eq!((quality.negative.count, quality.folded_corners.count), (0, 0), "{name}");
        assert_eq!(quality.unused_nodes.count, 0, "{name}");
    }
}

#[test]
fn warped_faces_enclose_what_the_cells_between_them_hold() {
    for (name, mut mesh, _) in meshes() {
        if mesh.cells.kind(0) == CellKind::Tet10 {
            continue; // curved faces are not their facets
        }
        mesh.nodes.iter_mut().for_each(|x| *x = bent(x));
        let enclosed = enclosed_volume_m3(&boundary(&mesh.cells), &mesh.nodes);
        assert!((mesh.volume_m3() / enclosed - 1.0).abs() < 1e-13, "{name}");
    }
}

#[test]
fn refinement_keeps_volume_surface_sets_and_shapes() {
    for (name, mut mesh, exact) in meshes() {
        if mesh.cells.kind(0) == CellKind::Tet10 {
            assert!(matches!(refined(&mesh), Err(MeshError::Unrefinable { .. })));
            continue;
        }
        let fine = refined(&mesh).unwrap();
        assert_eq!((fine.cells.len(), fine.part_of.len()), (8 * mesh.cells.len(), 8 * mesh.cells.len()));
        assert!((fine.volume_m3() / exact - 1.0).abs() < 1e-13, "{name}");
        assert!(fine.cells.iter().all(|cell| cell.kind.volume_m3(&cell.points(&fine.nodes)) > 0.0), "{name}");
        assert_eq!(topology_problems(&fine.cells), [], "{name}");
        assert_eq!(euler_characteristic(&boundary(&fine.cells)), 2, "{name}");
        let top = mesh.bounding_box().unwrap()[1].z;
        let on_top: Vec<u32> =
            (0..fine.nodes.len() as u32).filter(|a| fine.nodes[*a as usize].z == top).collect();
        assert_eq!(fine.node_sets["z_max"], on_top, "{name}");

        // A bent mesh keeps the volume of each cell: the children follow the interpolation of their parent.
        mesh.nodes.iter_mut().for_each(|x| *x = bent(x));
        let fine = refined(&mesh).unwrap();
        for e in 0..mesh.cells.len() {
            let children: f64 = (8 * e..8 * e + 8).map(|child| fine.element_volume_m3(child)).sum();
            assert!((children / mesh.element_volume_m3(e) - 1.0).abs() < 1e-13, "{name}");
        }
    }
}

#[test]
fn descendants_of_a_tetrahedron_have_at_most_three_shapes() {
    let corners = [[0.0; 3], [1.0, 0.1, 0.2], [0.3, 1.2, 0.1], [0.2, 0.4, 1.5]];
    let mut mesh = Mesh { nodes: corners.map(Vec3::from).to_vec(), ..Mesh::default() };
    mesh.cells.push(CellKind::Tet4, &[0, 1, 2, 3]);
    for level in 1..=3 {
        mesh = refined(&mesh).unwrap();
        let shape = |cell: Cell| {
            let x = cell.points(&mesh.nodes);
            let lengths = cell.kind.table().edges.iter().map(|[a, b]| (x[*a] - x[*b]).norm());
            let mut lengths: Vec<i64> =
                lengths.map(|length| (length * f64::from(1 << level) * 1e9).round() as i64).collect();
            lengths.sort_unstable();
            lengths
        };
        let shapes: BTreeSet<Vec<i64>> = mesh.cells.iter().map(shape).collect();
        assert!(shapes.len() <= 3, "{level}: {} shapes", shapes.len());
    }
}

#[test]
fn points_are_found_in_the_cells_that_they_come_from() {
    let everywhere = [Vec3::repeat(-50.0), Vec3::repeat(50.0)];
    for (name, mut mesh, _) in meshes() {
        mesh.nodes.iter_mut().for_each(|x| *x = bent(x));
        let locator = Locator::within(&everywhere, &mesh.cells, &mesh.nodes);
        for (element, cell) in mesh.cells.iter().enumerate() {
            let table = cell.kind.table();
            for (xi, _) in table.quadrature {
                let point = (table.place)(&cell.points(&mesh.nodes), *xi);
                assert_eq!(locator.element_at(&point, |_| true), Some(element), "{name}");
                assert_eq!(locator.element_at(&point, |e| e != element), None, "{name}");
            }
        }
    }
}

#[test]
fn depth_is_the_distance_to_the_nearest_side() {
    for kind in CellKind::ALL {
        let mesh = block_of(kind);
        let field = DepthField::new(&boundary(&mesh.cells), &mesh.nodes).unwrap();
        for x in [Vec3::new(1.3, 2.2, 0.7), Vec3::new(0.1, 3.0, 0.5), Vec3::new(5.0, 3.95, 0.4)] {
            let sides = [x.x, 6.0 - x.x, x.y, 4.0 - x.y, x.z, 1.0 - x.z];
            let exact = sides.into_iter().fold(f64::INFINITY, f64::min);
            assert!((field.depth(&x) - exact).abs() < 1e-12, "{kind:?}");
        }
    }
}

#[test]
fn rays_meet_the_surface_and_ways_go_over_it() {
    for kind in CellKind::ALL {
        let mesh = block_of(kind);
        let boundary = TriangulatedSurface::new(&boundary(&mesh.cells), mesh.nodes.clone());
        let (distance, hit) = boundary.entry(&Vec3::new(1.3, 2.2, 5.0), &-Vec3::z()).unwrap();
        assert!((distance - 4.0).abs() < 1e-13 && (hit.place - Vec3::new(1.3, 2.2, 1.0)).norm() < 1e-13);
        assert!((hit.normal - Vec3::z()).norm() < 1e-12, "{kind:?}: {hit:?}");
        let far = boundary.walk(&hit, &Vec3::new(3.0, 1.0, 0.0), 10.0_f64.sqrt()).unwrap();
        assert!((far.place - Vec3::new(4.3, 3.2, 1.0)).norm() < 1e-12, "{kind:?}: {far:?}");
        assert!(boundary.walk(&hit, &Vec3::x(), 6.0).is_err(), "{kind:?}: behind a sharp edge");
    }
}

#[test]
fn gmsh_files_carry_every_kind_and_mixed_ones() {
    for (name, mesh, _) in meshes() {
        let mesh = Mesh { notes: Vec::new(), ..mesh };
        for version in [Version::V2_2, Version::V4_1] {
            for encoding in [Encoding::Ascii, Encoding::LittleEndian, Encoding::BigEndian] {
                let bytes = write_gmsh(&mesh, version, encoding);
                assert_eq!(
                    read_mesh(&bytes, MeshFormat::Gmsh).unwrap(),
                    mesh,
                    "{name} {version:?} {encoding:?}"
                );
            }
        }
    }
}

#[test]
fn neighbours_of_other_degree_come_apart() {
    let pair = |kinds: [CellKind; 2]| {
        let block =
            Block::uniform(Vec3::zeros(), Vec3::new(2.0, 1.0, 1.0), [2, 1, 1], "b").generate().unwrap();
        topology_problems(&remeshed(&block, |e| Some(kinds[e])).cells)
    };
    assert_eq!(pair([CellKind::Tet10, CellKind::Tet10]), []);
    let apart = pair([CellKind::Tet4, CellKind::Tet10]);
    assert_eq!(apart.len(), 2, "two triangles lie between the cubes");
    assert!(apart.iter().all(|problem| matches!(problem, TopologyProblem::NodesBetweenCorners { .. })));
}
