//! Stretched and crushed elements against the principal stretches that they were given.

use super::super::{BlockInput, BlockParameters, ForceInput, Formulation, PointInput};
use super::*;
use crate::element::{ElementKind, HEX8_CORNERS, OfElement, ReferenceGeometry};
use crate::material::{Material, Memories, NeoHookean, Volumetric};
use crate::tensor::{Mat3, Vec3};
use nalgebra::Rotation3;

const LIMITS: ErosionLimits = ErosionLimits { stretch: 1.5, volume_ratio: 0.4, damage: 1.0 };

/// Ten elements of their own, distorted, more than a batch of them.
fn block() -> (Vec<Vec3>, [ElementBlock; 1]) {
    let X: Vec<Vec3> = (0..80)
        .map(|i| {
            Vec3::from(HEX8_CORNERS[i % 8])
                + Vec3::new((7.0 * i as f64).sin(), (3.0 * i as f64).cos(), 0.3) * 0.1
        })
        .collect();
    let input = |e: usize| {
        let corners: [Vec3; 8] = std::array::from_fn(|a| X[8 * e + a]);
        BlockInput {
            element: 100 + e as u32,
            nodes: (0..8).map(|a| (8 * e + a) as u32).collect(),
            corners: OfElement::from_slice(&corners),
            axes: Mat3::identity(),
            geometry: ReferenceGeometry::new(ElementKind::Hex8, &corners),
        }
    };
    let parameters = BlockParameters {
        material: Material::NeoHookean(NeoHookean { c10: 1e4, volumetric: Volumetric::LnSquared(1e6) }),
        formulation: Formulation::MeanDilatation,
        single_precision: false,
        density: 1000.0,
        linear_viscosity: 0.06,
        quadratic_viscosity: 1.2,
        shear_viscosity: 3.0,
        memory: Memories::NONE,
        erosion: Some(LIMITS),
    };
    let inputs: Vec<BlockInput> = (0..10).map(input).collect();
    (X, [ElementBlock::new(0, parameters, 0, &inputs).unwrap()])
}

/// Stretches of the elements, turned in space.
fn displaced(X: &[Vec3], stretches: &[[f64; 3]]) -> Vec<Vec3> {
    let turned = Rotation3::from_scaled_axis(Vec3::new(0.4, -1.0, 2.0)).into_inner();
    let F = |e: usize| turned * Mat3::from_diagonal(&Vec3::from(stretches[e])) * turned.transpose();
    X.iter().enumerate().map(|(i, X)| F(i / 8) * X - X).collect()
}

#[test]
fn an_element_goes_beyond_its_limits_and_leaves_no_force() {
    let (X, blocks) = block();
    let mut stretches = [[1.0; 3]; 10];
    stretches[1] = [1.0, 1.51, 0.8];
    stretches[2] = [1.0, 1.49, 0.8];
    stretches[6] = [0.7, 0.7, 0.8];
    stretches[8] = [0.7, 0.75, 0.8];
    stretches[9] = [2.0, 2.0, 0.5];
    let u = displaced(&X, &stretches);
    let input = ForceInput::at(&u);
    let mut forces = ElementForces::new(&blocks);
    forces.evaluate(&Threads::ONE, &blocks, &input);
    let found = forces.find_eroding(&Threads::ONE, &blocks);
    assert_eq!(found.iter().map(|e| e.element).collect::<Vec<_>>(), [101, 106, 109]);
    let before = forces.totals(0).strain;

    let mut erosion = Erosion::default();
    for element in &found {
        erosion.add(element, &blocks);
    }
    assert!(erosion.elements() == [101, 106, 109] && erosion.contains(106) && !erosion.contains(102));
    forces.take_out(&erosion);
    forces.evaluate(&Threads::ONE, &blocks, &input);
    let v = vec![Vec3::new(1.0, 2.0, 3.0); 80];
    forces.add_viscous(&Threads::ONE, &blocks, &input, &v);
    let gone: f64 = found.iter().map(|e| e.energy).sum();
    assert!((forces.totals(0).strain + gone - before).abs() <= 1e-12 * before);
    let assembly = crate::force::Assembly::new(80, &blocks);
    for node in 0..80 {
        let is_gone = erosion.contains(100 + node as u32 / 8);
        // What is turned by the unit matrix of its stretches has the forces of rounding.
        let is_still = forces.at_node(&assembly, node).norm() < 1e-6;
        assert_eq!(is_still, is_gone || stretches[node / 8] == [1.0; 3]);
    }
    // What is gone is found no more, and has no stress.
    assert!(forces.find_eroding(&Threads::ONE, &blocks).is_empty());
    blocks[0].for_each_moved_batch(
        PointInput { erosion: &erosion, ..PointInput::at_rest(&u) },
        &mut |slots, points| {
            for (lane, slot) in slots.enumerate() {
                let is_still = points.von_mises.iter().all(|row| row.0[lane].abs() < 1e-6);
                assert_eq!(is_still, erosion.contains(100 + slot as u32) || stretches[slot] == [1.0; 3]);
            }
        },
    );
}

#[test]
fn history_of_what_is_gone_is_forgotten() {
    let (X, blocks) = block();
    let mut stretches = [[1.0; 3]; 10];
    (stretches[3], stretches[9]) = ([2.0; 3], [1.2; 3]);
    let u = displaced(&X, &stretches);
    let mut forces = ElementForces::new(&blocks);
    forces.evaluate(&Threads::ONE, &blocks, &ForceInput::at(&u));
    let mut erosion = Erosion::default();
    for element in &forces.find_eroding(&Threads::ONE, &blocks) {
        erosion.add(element, &blocks);
    }
    let mut history = ElementForces::no_history(&blocks);
    forces.copy_history(&mut history);
    erosion.forget(&blocks, &mut history);
    let rows = blocks[0].history_rows();
    assert_eq!(history[0][0].0[3], 0.0);
    assert!(history[0][rows].0[1] > 0.5);
}
