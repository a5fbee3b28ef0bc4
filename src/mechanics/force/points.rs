//! Stress and deformation at the quadrature points, for measures and recordings.

use super::block::ElementBlock;
use crate::mechanics::element::{Hex8, POINTS, shape_at};
use crate::mechanics::lanes::BATCH;
use crate::mechanics::material::{Kinematics, MAX_FAMILIES, TotalResponse};
use crate::mechanics::tensor::{Mat3, Tensor, Vec3};

/// One quadrature point.
#[derive(Clone, Debug, PartialEq)]
pub struct PointField {
    /// Reference position X [m].
    pub position: Vec3,
    /// Reference volume [m³].
    pub volume: f64,
    /// Deformation gradient F [-].
    pub F: Mat3,
    /// Its determinant J [-].
    pub J: f64,
    /// Cauchy stress σ [Pa], with the element's pressure in it, without viscous pressure.
    pub cauchy: Mat3,
    /// Strain energy per reference volume ψ [J/m³].
    pub psi: f64,
}

impl ElementBlock {
    /// Visits every quadrature point: `visit(element, index in the element, point)`, elements in the order of the slots.
    pub fn for_each_point(&self, X: &[Vec3], u: &[Vec3], visit: &mut dyn FnMut(u32, usize, &PointField)) {
        for (slot, element) in self.elements.iter().enumerate() {
            for (q, point) in self.points_of(slot, X, u).iter().enumerate() {
                visit(*element, q, point);
            }
        }
    }

    /// The eight points of the element in a slot of this block.
    pub fn points_of(&self, slot: usize, X: &[Vec3], u: &[Vec3]) -> [PointField; POINTS] {
        let batch = &self.batches[slot / BATCH];
        let lane = slot % BATCH;
        let nodes = self.nodes_of(slot);
        let values = std::array::from_fn(|i| std::array::from_fn(|a| u[nodes[a] as usize][i]));
        let local = Hex8::local_gradients(&values);
        let geometry = batch.local_geometry(lane);
        let cof_X: [Tensor<f64>; POINTS] =
            std::array::from_fn(|q| Hex8::local_gradient_at(&geometry, q).cofactor());
        let H: [Tensor<f64>; POINTS] = std::array::from_fn(|q| {
            let inverse_weight = batch.inverse_weight[q].0[lane];
            Hex8::local_gradient_at(&local, q).dot_transposed(&cof_X[q]).scaled(inverse_weight)
        });
        let volume: [f64; POINTS] = std::array::from_fn(|q| 1.0 / batch.inverse_weight[q].0[lane]);
        let families = self.parameters.material.family_count();
        let mut fibres = [[0.0; 3]; MAX_FAMILIES];
        for (a, lanes) in fibres.iter_mut().zip(&self.fibres[slot / BATCH * families..]).take(families) {
            *a = [lanes[0].0[lane], lanes[1].0[lane], lanes[2].0[lane]];
        }
        let kinematics = H.map(|H| Kinematics::new(&H));
        let mean = (0..POINTS).map(|q| volume[q] * kinematics[q].j).sum::<f64>() / batch.volume.0[lane];
        std::array::from_fn(|q| {
            let k = &kinematics[q];
            let j = if self.parameters.mean_dilatation { mean } else { k.j };
            let TotalResponse { psi, P } =
                self.parameters.material.eval_with_dilatation(k, &fibres[..families], j);
            let F = Mat3::from(&k.F);
            let cauchy = Mat3::from(&P) * F.transpose() / k.J;
            let shape = shape_at(Hex8::point(q));
            let position = (0..8).map(|a| X[nodes[a] as usize] * shape[a]).sum();
            PointField { position, volume: volume[q], F, J: k.J, cauchy, psi }
        })
    }
}
