//! Systems of small meshes against dense linear algebra.

use super::{Cholesky, Definiteness, SymmetricMatrix, Unknowns};
use crate::element::{ElementKind, OfElement, ReferenceGeometry};
use crate::followers::Followers;
use crate::force::{BlockInput, BlockParameters, ElementBlock, Formulation, StiffnessBatch};
use crate::material::{Material, NeoHookean, Volumetric};
use crate::tensor::{Mat3, Vec3};
use nalgebra::{DMatrix, DVector};
use std::collections::BTreeMap;
use std::sync::Arc;

/// A row of `n` × n × n unit cubes of rubber.
fn cubes(n: u32) -> (Vec<Vec3>, Vec<[u32; 8]>, ElementBlock) {
    let m = n + 1;
    let id = |i: u32, j: u32, k: u32| (k * m + j) * m + i;
    let mut X = Vec::new();
    let mut hexes = Vec::new();
    for k in 0..m {
        for j in 0..m {
            for i in 0..m {
                X.push(Vec3::new(f64::from(i), f64::from(j), f64::from(k)));
                if i < n && j < n && k < n {
                    let face = |k| [id(i, j, k), id(i + 1, j, k), id(i + 1, j + 1, k), id(i, j + 1, k)];
                    let ([a, b, c, d], [e, f, g, h]) = (face(k), face(k + 1));
                    hexes.push([a, b, c, d, e, f, g, h]);
                }
            }
        }
    }
    let inputs: Vec<BlockInput> = hexes
        .iter()
        .enumerate()
        .map(|(e, nodes)| {
            let corners = nodes.map(|node| X[node as usize]);
            let geometry = ReferenceGeometry::new(ElementKind::Hex8, &corners);
            BlockInput {
                element: e as u32,
                nodes: OfElement::from_slice(nodes),
                corners: OfElement::from_slice(&corners),
                axes: Mat3::identity(),
                geometry,
            }
        })
        .collect();
    let parameters = BlockParameters::elastic(
        Material::NeoHookean(NeoHookean { c10: 0.5, volumetric: Volumetric::LnSquared(5.0) }),
        Formulation::MeanDilatation,
        1.0,
    );
    (X, hexes, ElementBlock::new(0, parameters, 0, &inputs).unwrap())
}

/// The bottom is fixed, and one node along x only.
fn is_free(X: &[Vec3], node: usize, axis: usize) -> bool {
    X[node].z > 0.0 && !(node == X.len() - 1 && axis == 0)
}

fn assemble(X: &[Vec3], block: &ElementBlock, unknowns: &Unknowns, shift: f64) -> SymmetricMatrix {
    let u: Vec<Vec3> = X.iter().map(|X| Vec3::new(0.02 * X.y * X.z, 0.05 * X.z, 0.1 * X.z)).collect();
    let mut matrix = SymmetricMatrix::new(unknowns);
    matrix.set_diagonal(&vec![shift; unknowns.count()]);
    let mut batch = StiffnessBatch::zeros();
    for b in 0..block.batch_count() {
        block.tangent_at(&u).eval_batch(b, &mut batch);
        matrix.add_batch(unknowns, block, b, &batch, 1.0);
    }
    matrix
}

fn dense(matrix: &SymmetricMatrix) -> DMatrix<f64> {
    let n = matrix.size();
    let mut out = DMatrix::zeros(n, n);
    for j in 0..n {
        for i in matrix.column_start[j]..matrix.column_start[j + 1] {
            out[(matrix.row[i], j)] = matrix.value[i];
            out[(j, matrix.row[i])] = matrix.value[i];
        }
    }
    out
}

#[test]
fn solutions_are_those_of_the_dense_matrix_definite_or_not() {
    let (X, hexes, block) = cubes(4);
    let unknowns = Unknowns::new(X.len(), |node, axis| is_free(&X, node, axis), hexes.iter()).unwrap();
    assert_eq!(unknowns.count(), 3 * 100 - 1);
    for (shift, expected) in [(0.0, Definiteness::Positive), (-2.0, Definiteness::Indefinite)] {
        let matrix = assemble(&X, &block, &unknowns, shift);
        let full = dense(&matrix);
        let mut factor = Cholesky::new(&matrix).unwrap();
        assert_eq!(factor.factorize(&matrix).unwrap(), expected);
        // More right-hand sides than one block contains.
        let columns = 100;
        let b: Vec<f64> = (0..columns * matrix.size()).map(|i| (i as f64 * 0.7).sin()).collect();
        let mut x = b.clone();
        factor.solve(&mut x);
        for (b, x) in b.chunks(matrix.size()).zip(x.chunks(matrix.size())) {
            let (b, x) = (DVector::from_row_slice(b), DVector::from_row_slice(x));
            let residual = (&full * &x - &b).norm() / (full.norm() * x.norm() + b.norm());
            assert!(residual < 1e-13, "{expected:?}: {residual:e}");
            let mut y = vec![0.0; matrix.size()];
            matrix.multiply(x.as_slice(), &mut y);
            assert!((DVector::from_vec(y) - &full * &x).norm() < 1e-12 * full.norm() * x.norm());
        }
        // One right-hand side with a single load, which most panels do not see.
        let mut x = vec![0.0; matrix.size()];
        x[40] = 1.0;
        let b = DVector::from_vec(x.clone());
        factor.solve(&mut x);
        let x = DVector::from_vec(x);
        assert!((&full * &x - b).norm() < 1e-13 * full.norm() * x.norm(), "{expected:?}");
    }
}

#[test]
fn blocks_of_the_inverse_are_those_of_solutions() {
    for n in [2, 5] {
        let (X, hexes, block) = cubes(n);
        let unknowns = Unknowns::new(X.len(), |node, axis| is_free(&X, node, axis), hexes.iter()).unwrap();
        for shift in [0.0, -2.0] {
            let matrix = assemble(&X, &block, &unknowns, shift);
            let mut factor = Cholesky::new(&matrix).unwrap();
            factor.factorize(&matrix).unwrap();
            let size = matrix.size();
            let wanted: Vec<usize> = (0..size).step_by(7).rev().collect();
            let mut inverse = vec![0.0; wanted.len() * wanted.len()];
            factor.inverse_block(&wanted, &mut inverse);
            // One right-hand side and many use different algorithms.
            let mut columns = vec![0.0; size * wanted.len()];
            for (j, unknown) in wanted.iter().enumerate() {
                columns[j * size + unknown] = 1.0;
            }
            let mut one = columns[..size].to_vec();
            factor.solve(&mut columns);
            factor.solve(&mut one);
            let largest = columns.iter().fold(0.0_f64, |a, x| a.max(x.abs()));
            for (x, y) in one.iter().zip(&columns) {
                assert!((x - y).abs() < 1e-12 * largest);
            }
            for (j, column) in columns.chunks(size).enumerate() {
                for (i, row) in wanted.iter().enumerate() {
                    assert!((inverse[i * wanted.len() + j] - column[*row]).abs() < 1e-12 * largest);
                }
            }
        }
    }
}

#[test]
fn the_inverse_in_the_pattern_has_the_entries_of_the_whole_one() {
    let (mut X, mut hexes, block) = cubes(6);
    // A second body that nothing couples to the first.
    let first = X.len() as u32;
    X.push(Vec3::new(0.0, 0.0, 9.0));
    hexes.push([first; 8]);
    let unknowns = Unknowns::new(X.len(), |node, axis| is_free(&X, node, axis), hexes.iter()).unwrap();
    let matrix = assemble(&X, &block, &unknowns, 0.5);
    let mut factor = Cholesky::new(&matrix).unwrap();
    factor.factorize(&matrix).unwrap();
    let size = matrix.size();
    let (all, mut inverse): (Vec<usize>, _) = ((0..size).collect(), vec![0.0; size * size]);
    factor.inverse_block(&all, &mut inverse);
    let largest = inverse.iter().fold(0.0_f64, |a, x| a.max(x.abs()));
    let pattern = factor.pattern_inverse().unwrap();
    let mut found = 0;
    for row in 0..size {
        for column in 0..size {
            if let Some(entry) = pattern.entry(row, column) {
                found += 1;
                assert!((entry - inverse[row * size + column]).abs() < 1e-6 * largest);
            }
        }
    }
    assert!(found > matrix.row.len() && found < size * size, "{found} of {size}²");
    // All nodes of an element are in it.
    let of_first = |axis: usize| unknowns.of(hexes[100][0] as usize, axis);
    for node in hexes[100] {
        for other in (0..3).filter_map(|axis| unknowns.of(node as usize, axis)) {
            assert!((0..3).filter_map(of_first).all(|own| pattern.entry(own, other).is_some()));
        }
    }
    let alone = unknowns.of(first as usize, 1).unwrap();
    let other = unknowns.of(hexes[100][6] as usize, 0).unwrap();
    assert!(pattern.entry(alone, other) == Some(0.0) && pattern.entry(alone, alone).unwrap() > 0.0);
}

#[test]
fn the_tangent_of_the_assembly_is_that_of_its_elements() {
    let (X, hexes, block) = cubes(2);
    let unknowns = Unknowns::new(X.len(), |node, axis| is_free(&X, node, axis), hexes.iter()).unwrap();
    let full = dense(&assemble(&X, &block, &unknowns, 0.0));
    let u: Vec<Vec3> = X.iter().map(|X| Vec3::new(0.02 * X.y * X.z, 0.05 * X.z, 0.1 * X.z)).collect();
    let mut expected = DMatrix::<f64>::zeros(unknowns.count(), unknowns.count());
    let mut batch = StiffnessBatch::zeros();
    block.tangent_at(&u).eval_batch(0, &mut batch);
    for (lane, hex) in hexes.iter().enumerate() {
        for (a, i, b, j) in (0..24 * 24).map(|n| (n / 72, n / 24 % 3, n % 24 / 3, n % 3)) {
            let pair = crate::force::corner_pair(a.max(b), a.min(b));
            let value = batch.0[pair][if a >= b { 3 * i + j } else { 3 * j + i }].0[lane];
            let place = |node: u32, axis| unknowns.of(node as usize, axis);
            if let (Some(row), Some(column)) = (place(hex[a], i), place(hex[b], j)) {
                expected[(row, column)] += value;
            }
        }
    }
    assert!((full - &expected).norm() < 1e-14 * expected.norm());
}

#[test]
fn followers_make_the_matrix_that_of_the_constrained_field() {
    let (X, hexes, block) = cubes(2);
    let all = Unknowns::new(X.len(), |_, _| true, hexes.iter()).unwrap();
    let K = dense(&assemble(&X, &block, &all, 0.0));
    // Ties between neighbours, across a face, and to a node far away.
    let ties = [
        (13, vec![(12, 0.5), (14, 0.5)]),
        (4, vec![(0, 0.25), (2, 0.25), (6, 0.25), (8, 0.25)]),
        (26, vec![(0, 0.3), (25, 0.7)]),
    ];
    let followers = Arc::new(Followers::new(X.len(), &BTreeMap::from(ties)).unwrap());
    let free = |node: usize, axis: usize| !(node == 2 && axis == 1);
    let few = Unknowns::with_followers(X.len(), free, hexes.iter(), followers.clone()).unwrap();
    assert_eq!(few.count(), 3 * (27 - 3) - 1);
    let reduced = dense(&assemble(&X, &block, &few, 0.0));
    let mut T = DMatrix::<f64>::zeros(all.count(), few.count());
    all.for_each(|row, node, axis| {
        for (mover, w) in followers.movers(node as u32) {
            if let Some(column) = few.of(mover as usize, axis) {
                T[(row, column)] = w;
            }
        }
    });
    let expected = T.transpose() * K * &T;
    assert!((reduced - &expected).norm() < 1e-13 * expected.norm());
}

#[test]
fn the_order_keeps_the_factor_thin() {
    // A cube of 12³ elements: nested dissection needs far less than the band of the natural order.
    let (X, hexes, _) = cubes(12);
    let unknowns = Unknowns::new(X.len(), |_, _| true, hexes.iter()).unwrap();
    let factor = Cholesky::new(&SymmetricMatrix::new(&unknowns)).unwrap();
    let (size, band) = (unknowns.count() as f64, 3.0 * f64::from(13 * 13 + 13 + 2));
    assert!(factor.flops() < 0.5 * size * band * band, "{:e} {:e}", factor.flops(), size * band * band);
}

#[test]
fn gathered_numbers_scatter_back() {
    let (X, hexes, _) = cubes(2);
    let unknowns = Unknowns::new(X.len(), |node, axis| is_free(&X, node, axis), hexes.iter()).unwrap();
    let mut numbers = vec![0.0; unknowns.count()];
    unknowns.gather(&X, &mut numbers);
    let mut field = vec![Vec3::repeat(-1.0); X.len()];
    unknowns.scatter(&numbers, &mut field);
    for (node, X_node) in X.iter().enumerate() {
        for axis in 0..3 {
            let expected = if is_free(&X, node, axis) { X_node[axis] } else { -1.0 };
            assert!((field[node][axis] - expected).abs() == 0.0);
        }
    }
}
