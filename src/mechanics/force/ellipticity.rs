//! Whether the material of elements is elliptic: evaluated where a run has failed, never in a step.

use super::block::ElementBlock;
use super::parameters::Formulation;
use crate::lanes::BATCH;
use crate::material::least_acoustic_eigenvalue;
use crate::tensor::{Mat3, Tensor, Vec3};

impl ElementBlock {
    /// Least eigenvalue of the acoustic tensor over directions and points [Pa] of the element in a slot of this block, at the
    /// displacements `u` [m], nodes × 3; negative where the material has lost ellipticity, `None` where a point is inverted.
    pub fn least_acoustic_eigenvalue(&self, slot: usize, u: &[Vec3]) -> Option<f64> {
        let material = &self.parameters.material;
        let points = self.points_of(slot / BATCH, u);
        let lane = slot % BATCH;
        let of_points = &points.F[..self.kind.point_count()];
        let F: Vec<Mat3> = of_points.iter().map(|F| Mat3::from_fn(|i, j| F[3 * i + j].0[lane])).collect();
        let J: Vec<f64> = F.iter().map(Mat3::determinant).collect();
        if !J.iter().all(|J| *J > 0.0) {
            return None;
        }
        let volume: Vec<f64> = points.volume[..F.len()].iter().map(|V| V.0[lane]).collect();
        let mean = J.iter().zip(&volume).map(|(J, V)| J * V).sum::<f64>() / volume.iter().sum::<f64>();
        let of_batch = self.fibres_of(slot / BATCH);
        let fibres: Vec<[f64; 3]> = of_batch.iter().map(|a| [0, 1, 2].map(|i| a[i].0[lane])).collect();
        let least = F.iter().zip(&J).map(|(F, J)| {
            let J = if self.parameters.formulation == Formulation::MeanDilatation { mean } else { *J };
            let bulk = material.volumetric().map_or(0.0, |U| U.stiffness(J - 1.0));
            let H = Tensor::from_fn(|i, j| F[(i, j)] - f64::from(u8::from(i == j)));
            least_acoustic_eigenvalue(material, &H, &fibres, bulk)
        });
        Some(least.fold(f64::INFINITY, f64::min))
    }
}
