//! Volumes of the classes, and how much each has to grow for the one that it is to have.

use super::elements::Elements;
use super::grid::OUTSIDE;
use super::labelling::BEYOND;
use crate::mesh::CellKind;
use nalgebra::{DMatrix, DVector};

/// Part of a correction that is made at once [-].
const RELAXATION: f64 = 0.8;

/// Largest correction at once, in edges of the elements at the surface [-].
const MOST_AT_ONCE: f64 = 0.1;

/// Volumes of the classes [m³]; that of the skin counts to what it covers.
pub fn volumes_m3(elements: &Elements, count: usize) -> Vec<f64> {
    let mut volumes = vec![0.0; count];
    for (e, hex) in elements.hexes.iter().enumerate() {
        let skin = elements.skin.as_ref().filter(|skin| e >= skin.first_element);
        let owner = skin.map_or(e, |skin| skin.under[e - skin.first_element] as usize);
        let x = hex.map(|node| elements.nodes[node as usize]);
        volumes[usize::from(elements.classes[owner])] += CellKind::Hex8.volume_m3(&x);
    }
    volumes
}

/// By how much [m] each class grows so that `missing` [m³] is added to its volume, with the areas of the surfaces between classes:
/// Σ_b A_ab (g_a − g_b) = ΔV_a. The outside does not grow.
pub fn growth(elements: &Elements, missing: &[f64]) -> Vec<f64> {
    let count = missing.len();
    let mut matrix = DMatrix::<f64>::zeros(count, count);
    // Least edge of the elements at the surface of each class.
    let mut edges = vec![f64::INFINITY; count];
    for face in &elements.faces {
        if face.behind == BEYOND {
            continue;
        }
        let [a, b, c, d] = face.nodes.map(|node| elements.nodes[node as usize]);
        let area = 0.5 * (c - a).cross(&(d - b)).norm();
        let (i, j) = (usize::from(elements.classes[face.element as usize]), usize::from(face.behind));
        let edge = elements.edges[face.element as usize];
        edges[i] = edge.min(edges[i]);
        edges[j] = edge.min(edges[j]);
        matrix[(i, i)] += area;
        matrix[(j, j)] += area;
        matrix[(i, j)] -= area;
        matrix[(j, i)] -= area;
    }
    let total = matrix.trace();
    let mut right = DVector::from_column_slice(missing);
    let outside = usize::from(OUTSIDE);
    for i in 0..count {
        matrix[(outside, i)] = 0.0;
        matrix[(i, outside)] = 0.0;
        // A class without a surface does not grow.
        matrix[(i, i)] += 1e-9 * total;
    }
    matrix[(outside, outside)] = 1.0;
    right[outside] = 0.0;
    let found = matrix.lu().solve(&right).unwrap_or_else(|| DVector::zeros(count));
    let bounded = |(growth, edge): (&f64, f64)| {
        let most = MOST_AT_ONCE * edge;
        if growth.is_finite() && most.is_finite() { (RELAXATION * growth).clamp(-most, most) } else { 0.0 }
    };
    found.iter().zip(edges).map(bounded).collect()
}
