#![allow(clippy::unwrap_used, clippy::float_cmp)] // tests may panic; exact values

use super::*;
use crate::measure::depth_ridge::middle_of;
use crate::mechanics::tensor::Vec3;
use crate::mesh::distance::DepthField;
use crate::mesh::generate::block::Block;
use crate::mesh::surface::{boundary, faces_within};
use crate::mesh::{CellKind, Mesh};

/// A block below z = 0 whose skin is its top, deformed by `map`, and the field of stresses given at the points; elements
/// whose centres lie deeper than `interface` [m] are a second part.
fn field_of(
    (size, elements): (Vec3, [u32; 3]),
    map: impl Fn(Vec3) -> Vec3,
    interface: f64,
    stress: impl Fn(&Vec3) -> f64,
) -> StressField {
    let low = Vec3::new(-0.5 * size.x, -0.5 * size.y, -size.z);
    let mut mesh = Block::uniform(low, size, elements, "b").generate().unwrap();
    mesh.nodes.iter_mut().for_each(|X| *X = map(*X));
    filled(&mesh, interface, stress)
}

fn filled(mesh: &Mesh, interface: f64, stress: impl Fn(&Vec3) -> f64) -> StressField {
    below((mesh, &faces_within(&boundary(&mesh.cells), &mesh.node_sets["z_max"])), interface, stress)
}

/// Two nodes of an end at the depths 56 and 57 m, of which the first is above the threshold of 1 Pa, and a node above each.
#[test]
fn a_region_that_is_deepest_between_two_nodes_of_an_end_is_at_that_end() {
    let vertex = |depth, stress, ends| Vertex { stress, ..Vertex::new(0, depth, ends) };
    let region_of = |first_ends: u32| {
        let vertices = vec![
            vertex(56.0, 2.0, first_ends),
            vertex(57.0, 0.0, first_ends),
            vertex(50.0, 3.0, 0),
            vertex(51.0, 0.0, 0),
        ];
        let edges = vec![[0, 1], [0, 2], [1, 3], [2, 3]];
        let (lines, middles, elements) = (Vec::new(), Vec::new(), Vec::new());
        let field = StressField { vertices, lines, middles, elements, edges, part_count: 1 };
        field.region(1.0)
    };
    let region = region_of(0b10);
    assert_eq!((region.depth, region.ends[1], region.edge), (56.5, 56.5, 1.0));
    assert_eq!(region.ends[0], f64::NEG_INFINITY);
    assert!(region_of(0).ends.iter().all(|depth| *depth == f64::NEG_INFINITY));
}

/// The field of a mesh below some of its faces.
fn below((mesh, skin): (&Mesh, &[[u32; 4]]), interface: f64, stress: impl Fn(&Vec3) -> f64) -> StressField {
    let skin = DepthField::new(skin, &mesh.nodes).unwrap();
    let points: Vec<Vec<(Vec3, f64)>> = mesh
        .cells
        .iter()
        .map(|cell| {
            let (x, table, kind) = (cell.points(&mesh.nodes), cell.kind.table(), cell.kind.element());
            let volume = (table.jacobian)(&x, table.centre).determinant() / kind.point_count() as f64;
            let place = |q: usize| x.iter().zip(kind.shapes_at(q)).map(|(x, N)| x * *N).sum::<Vec3>();
            (0..kind.point_count()).map(|q| (place(q), volume)).collect()
        })
        .collect();
    let tissue = mesh.cells.iter().zip(&points).enumerate().map(|(slot, (cell, points))| {
        let centre = points.iter().map(|(X, _)| X.z).sum::<f64>() / points.len() as f64;
        let mut volumes = [0.0; MOST_POINTS];
        volumes.iter_mut().zip(points).for_each(|(to, (_, volume))| *to = *volume);
        let x = cell.points(&mesh.nodes);
        let corners = &x[..cell.kind.table().corners];
        let middle = skin.depth(&middle_of(corners.iter().copied()));
        let ridge = Ridge::of(cell.kind, &x, (&skin.depths(corners), middle), |point| skin.depth(point));
        TissueElement {
            ridge,
            slot,
            part: usize::from(-centre > interface),
            cell: cell.kind,
            nodes: cell.nodes.to_vec(),
            volumes,
        }
    });
    let mut field = StressField::new(
        (&skin.depths(&mesh.nodes), &vec![0; mesh.nodes.len()]),
        (2, mesh.cells.len()),
        tissue,
    );
    field.begin();
    for (slot, points) in points.iter().enumerate() {
        for (q, (X, volume)) in points.iter().enumerate() {
            field.add(slot, q, (stress(X), *volume));
        }
    }
    field.end();
    field
}

const COLUMN: Vec3 = Vec3::new(1.0, 1.0, 10.0);

#[test]
fn stress_linear_in_depth_is_found_exactly_on_graded_meshes_of_every_kind() {
    let graded = |X: Vec3| Vec3::new(X.x, X.y, X.z * (0.6 - 0.04 * X.z));
    let block = Block::uniform(Vec3::new(-0.5, -0.5, -10.0), COLUMN, [2, 2, 6], "b");
    let mut mesh = block.generate().unwrap();
    mesh.nodes.iter_mut().for_each(|X| *X = graded(*X));
    for mesh in &CellKind::ALL.map(|kind| mesh.split_to(kind)) {
        let field = filled(mesh, 99.0, |X| 20.0 + 3.0 * X.z);
        for exact in [0.01, 0.3, 2.0, 3.3, 6.6] {
            let region = field.region(20.0 - 3.0 * exact);
            assert!((region.depth - exact).abs() < 1e-9, "{region:?} of {exact}");
            assert!(region.bounds.iter().all(|bound| (bound - exact).abs() < 1e-5), "{region:?}");
            assert!(region.layers[0][0].abs() < 1e-12 && region.layers[1] == Region::NOWHERE);
            let below = field.largest_below(exact);
            assert!((below - (20.0 - 3.0 * exact)).abs() < 1e-9, "{below} below {exact}");
        }
    }
}

/// Stress beneath a point load P on an incompressible half-space (Boussinesq; Johnson 1985, section 3.2): radial, so the
/// von Mises stress is 3 P z / (2π R³), and on the axis it exceeds τ down to √(3 P / (2π τ)).
#[test]
fn depth_below_a_point_load_converges_with_second_order_and_within_its_bounds() {
    let stress = |X: &Vec3| -X.z / X.norm().powi(3);
    let mut errors = Vec::new();
    for n in [8, 16, 32] {
        let field = field_of((Vec3::new(8.0, 8.0, 8.0), [n; 3]), |X| X, 99.0, stress);
        // Depths at all places between two nodes: the mean error and the mean width of the bounds.
        let mut sums = [0.0; 2];
        for exact in (0..20).map(|i| 2.05 + 0.1 * f64::from(i)) {
            let Region { depth, bounds: [lower, upper], .. } = field.region(1.0 / (exact * exact));
            assert!(lower <= exact && exact <= upper, "{n}: {lower} {depth} {upper}, {exact}");
            sums = [sums[0] + (depth - exact).abs() / 20.0, sums[1] + (upper - lower) / 20.0];
        }
        errors.push(sums);
    }
    for pair in errors.windows(2) {
        let order = [0, 1].map(|of: usize| (pair[0][of] / pair[1][of]).log2());
        assert!(order.iter().all(|order| *order > 1.7), "{order:?} of {errors:?}");
    }
    assert!(errors[2][0] < 0.01, "{errors:?}");
}

#[test]
fn a_stress_front_is_found_within_its_bounds_which_are_an_element() {
    for front in [2.2, 2.5, 3.0, 3.1, 3.49] {
        let field = field_of((COLUMN, [1, 1, 20]), |X| X, 99.0, |X| if -X.z < front { 7.0 } else { 0.0 });
        let Region { depth, bounds: [lower, upper], .. } = field.region(2.0);
        assert!(lower <= front && front <= upper && upper - lower < 1.5, "{lower} {depth} {upper}, {front}");
        assert!((depth - front).abs() < 0.5, "{depth} {front}");
    }
}

#[test]
fn at_an_interface_each_part_has_its_own_stress() {
    // Stiff above 4 m, soft below.
    let stress = |X: &Vec3| if X.z > -4.0 { 9.0 } else { 1.0 + 0.1 * X.z };
    let field = field_of((COLUMN, [1, 1, 10]), |X| X, 4.0, stress);
    let high = field.region(5.0);
    assert!((high.depth - 4.0).abs() < 1e-12 && high.layers[1] == Region::NOWHERE, "{high:?}");
    let low = field.region(0.35);
    assert!((low.layers[0][1] - 4.0).abs() < 1e-12, "{low:?}");
    assert!((low.layers[1][0] - 4.0).abs() < 1e-12 && (low.layers[1][1] - 6.5).abs() < 1e-9, "{low:?}");
}

#[test]
fn the_depth_is_continuous_in_the_stress() {
    let depth = |scale: f64| {
        field_of((COLUMN, [2, 2, 8]), |X| X, 99.0, |X| scale * (X.z + 0.3 * X.x).exp()).region(0.05).depth
    };
    let depths: Vec<f64> = (0..400).map(|i| depth(1.0 + f64::from(i) * 0.005)).collect();
    // ln 3 in all, in small steps.
    assert!(depths.windows(2).all(|pair| pair[1] > pair[0] && pair[1] - pair[0] < 0.02), "{depths:?}");
    assert!((depths[399] - depths[0] - 2.995_f64.ln()).abs() < 0.1);
}

#[test]
fn what_is_nowhere_exceeded_has_no_depth() {
    let field = field_of((COLUMN, [1, 1, 4]), |X| X, 99.0, |_| 1.0);
    assert_eq!(
        field.region(2.0),
        Region {
            depth: 0.0,
            edge: 0.0,
            bounds: [0.0; 2],
            layers: vec![Region::NOWHERE; 2],
            ends: [f64::NEG_INFINITY; MOST_ENDS]
        }
    );
    assert_eq!((field.deepest(), field.largest_below(10.5)), (Some(10.0), 0.0));
}

#[test]
fn tissue_is_as_deep_as_it_is_thick_on_odd_and_even_numbers_of_elements_of_every_kind() {
    // 60 m wide and 30 m thick: below its middle the base is as far from the sides as from the top, and no surface itself.
    let low = Vec3::new(-30.0, -30.0, -30.0);
    for across in [2, 3, 4, 5] {
        let block = Block::uniform(low, Vec3::new(60.0, 60.0, 30.0), [across, across, 3], "b");
        let mesh = block.generate().unwrap();
        for mesh in &CellKind::ALL.map(|kind| mesh.split_to(kind)) {
            let is_base = |face: &[u32; 4]| face.iter().all(|node| mesh.nodes[*node as usize].z < -29.0);
            let skin: Vec<[u32; 4]> =
                boundary(&mesh.cells).into_iter().filter(|face| !is_base(face)).collect();
            let field = below((mesh, &skin), 99.0, |_| 1.0);
            assert!(field.deepest().is_some_and(|deepest| (deepest - 30.0).abs() < 1e-9), "{across}");
            let region = field.region(0.5);
            assert!((region.depth - 30.0).abs() < 1e-9, "{across}: {region:?}");
        }
    }
}

#[test]
fn in_an_odd_number_of_layers_with_surfaces_on_both_sides_stress_reaches_the_middle() {
    let block = Block::uniform(Vec3::new(-15.0, -15.0, -3.0), Vec3::new(30.0, 30.0, 3.0), [5, 5, 3], "b");
    let mesh = block.generate().unwrap();
    // Linear in the distance from the top.
    let field = below((&mesh, &boundary(&mesh.cells)), 99.0, |X| 10.0 + X.z);
    for (threshold, exact) in [(9.5, 0.5), (8.8, 1.2), (8.4, 1.5), (7.6, 1.5)] {
        let Region { depth, layers, .. } = field.region(threshold);
        assert!((depth - exact).abs() < 0.03 && layers[0][1] == depth, "{depth} of {exact}");
    }
    assert!(field.deepest().is_some_and(|deepest| (deepest - 1.5).abs() < 1e-9));
    assert!((field.largest_below(1.5) - 8.5).abs() < 0.03 && field.largest_below(1.6) == 0.0);
}
