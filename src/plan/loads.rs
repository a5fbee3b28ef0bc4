//! Loads besides contact: prescribed displacements, face loads, and their load curves.

use super::body::PlanBody;
use crate::mechanics::face_load::corner_sizes;
use crate::mechanics::tensor::Vec3;
use crate::mesh::surface::faces_within;
use crate::scene::Scene;
use crate::scene::document::{FaceLoadDocument, RampDocument, SceneDocument};
use std::collections::BTreeMap;

/// A load curve: piecewise linear, constant before the first and after the last point.
#[derive(Clone, Debug, PartialEq)]
pub struct Ramp(Vec<(f64, f64)>);

impl Ramp {
    /// The load curve of a document; `None` stands for the default of the scene.
    fn new(document: Option<&RampDocument>, scene: &SceneDocument) -> Self {
        match document {
            None if scene.integrator.is_quasi_static() => Self(vec![(0.0, 0.0), (scene.end_time_s, 1.0)]),
            None | Some(RampDocument::Constant {}) => Self(vec![(0.0, 1.0)]),
            Some(RampDocument::Linear { from_s, to_s }) => Self(vec![(*from_s, 0.0), (*to_s, 1.0)]),
            Some(RampDocument::Table { times_s, factors }) => {
                Self(times_s.iter().copied().zip(factors.iter().copied()).collect())
            }
        }
    }

    /// A load curve through points (time [s], factor), ascending in time.
    pub fn of_points(points: Vec<(f64, f64)>) -> Self {
        Self(points)
    }

    /// Factor at a time [s] [-].
    pub fn at(&self, time: f64) -> f64 {
        let after = self.0.partition_point(|(t, _)| *t <= time);
        match (after.checked_sub(1).and_then(|i| self.0.get(i)), self.0.get(after)) {
            (Some((t0, a)), Some((t1, b))) => a + (b - a) * ((time - t0) / (t1 - t0)),
            (Some((_, factor)), None) | (None, Some((_, factor))) => *factor,
            // Without points the factor is 1.
            (None, None) => 1.0,
        }
    }

    /// Right derivative of the factor at a time [s] [1/s].
    fn rate(&self, time: f64) -> f64 {
        let after = self.0.partition_point(|(t, _)| *t <= time);
        match (after.checked_sub(1).and_then(|i| self.0.get(i)), self.0.get(after)) {
            (Some((t0, a)), Some((t1, b))) => (b - a) / (t1 - t0),
            _ => 0.0,
        }
    }
}

/// Position on the load curves.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum LoadTime {
    /// Before the clock starts: this fraction of the initial loads.
    Preload(f64),
    /// At this time of the run [s].
    Run(f64),
}

impl LoadTime {
    /// The factor of a load curve [-].
    pub fn factor(self, ramp: &Ramp) -> f64 {
        match self {
            Self::Preload(fraction) => fraction * ramp.at(0.0),
            Self::Run(time) => ramp.at(time.max(0.0)),
        }
    }
}

/// A pressure that follows its faces.
#[derive(Clone, Debug)]
pub struct FacePressure {
    /// Outward faces, with global nodes.
    pub faces: Vec<[u32; 4]>,
    /// Pressure at factor 1 [Pa], positive inwards.
    pub pressure: f64,
    /// Load curve of the pressure.
    pub ramp: Ramp,
}

/// Nodal forces of constant direction.
#[derive(Clone, Debug)]
pub struct NodalForces {
    /// Node and force at factor 1 [N].
    pub forces: Vec<(u32, Vec3)>,
    /// Load curve of the forces.
    pub ramp: Ramp,
}

/// A prescribed component of a node's displacement.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Prescribed {
    /// Global number of the node.
    pub node: u32,
    /// Axis, 0 to 2.
    pub axis: usize,
    /// Displacement at factor 1 [m].
    pub displacement: f64,
    /// Load curve, as an index into [`Loads::ramps`].
    pub ramp: usize,
}

/// All loads on nodes besides contact and weight.
#[derive(Clone, Debug, Default)]
pub struct Loads {
    /// Load curve of gravity; `None` where it is constant or absent.
    pub gravity: Option<Ramp>,
    /// Pressures that follow their faces.
    pub pressures: Vec<FacePressure>,
    /// Tractions and other nodal forces.
    pub forces: Vec<NodalForces>,
    /// Load curves of the prescribed displacements.
    pub ramps: Vec<Ramp>,
    /// Prescribed displacements, each component of a node at most once; the inverse mass along it is zero.
    pub prescribed: Vec<Prescribed>,
}

impl Loads {
    /// The loads of a scene, for its compiled bodies.
    pub(super) fn new(scene: &Scene, bodies: &[PlanBody], X: &[Vec3]) -> Self {
        let document = &scene.document;
        let mut loads = Self::default();
        let gravity = Ramp::new(document.gravity_ramp.as_ref(), document);
        if document.gravity_m_per_s2.is_some() && gravity != Ramp(vec![(0.0, 1.0)]) {
            loads.gravity = Some(gravity);
        }
        for (index, body) in bodies.iter().enumerate() {
            for load in &document.bodies[index].face_loads {
                loads.add_face_load(scene, load, (index, body), X);
            }
            for prescribed in &document.bodies[index].prescribed {
                let ramp = loads.ramps.len();
                loads.ramps.push(Ramp::new(prescribed.ramp.as_ref(), document));
                for node in set_nodes(scene, (index, body), &prescribed.set) {
                    loads.prescribed.extend(prescribed.axes.iter().map(|axis| {
                        let axis = *axis as usize;
                        Prescribed { node, axis, displacement: prescribed.displacement_m[axis], ramp }
                    }));
                }
            }
        }
        loads
    }

    fn add_face_load(
        &mut self,
        scene: &Scene,
        load: &FaceLoadDocument,
        (index, body): (usize, &PlanBody),
        X: &[Vec3],
    ) {
        let faces = faces_within(&body.boundary.faces, &set_nodes(scene, (index, body), load.set()));
        let ramp = Ramp::new(load.ramp(), &scene.document);
        match load {
            FaceLoadDocument::Pressure { pressure_pa, .. } => {
                self.pressures.push(FacePressure { faces, pressure: *pressure_pa, ramp });
            }
            FaceLoadDocument::Traction { traction_pa, .. } => {
                let mut sizes: BTreeMap<u32, f64> = BTreeMap::new();
                for face in &faces {
                    for (node, size) in face.iter().zip(corner_sizes(&face.map(|node| X[node as usize]))) {
                        *sizes.entry(*node).or_default() += size;
                    }
                }
                let traction = Vec3::from(*traction_pa);
                let forces = sizes.into_iter().map(|(node, size)| (node, traction * size)).collect();
                self.forces.push(NodalForces { forces, ramp });
            }
        }
    }

    /// Whether there are pressures or nodal forces.
    pub fn has_forces(&self) -> bool {
        !(self.pressures.is_empty() && self.forces.is_empty())
    }

    /// Whether a load or prescribed displacement acts on a body.
    pub(super) fn act_on(&self, body: &PlanBody) -> bool {
        let of_body = |node: &u32| body.nodes.contains(node);
        self.pressures.iter().flat_map(|p| p.faces.iter().flatten()).any(of_body)
            || self.forces.iter().flat_map(|f| &f.forces).any(|(node, _)| of_body(node))
            || self.prescribed.iter().any(|p| of_body(&p.node))
    }

    /// Prescribed displacement of a component at a time [m].
    pub fn displacement(&self, prescribed: &Prescribed, time: LoadTime) -> f64 {
        prescribed.displacement * time.factor(&self.ramps[prescribed.ramp])
    }

    /// Prescribed velocity right after a time [s] of the run [m/s].
    pub fn velocity(&self, prescribed: &Prescribed, time: f64) -> f64 {
        prescribed.displacement * self.ramps[prescribed.ramp].rate(time.max(0.0))
    }
}

/// Global nodes of a set of a body, ascending; `*` for all.
fn set_nodes(scene: &Scene, (index, body): (usize, &PlanBody), set: &str) -> Vec<u32> {
    if set == "*" {
        return body.nodes.clone().collect();
    }
    let nodes = scene.bodies[index].mesh.node_sets.get(set).into_iter().flatten();
    nodes.map(|node| node + body.nodes.start).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ramps_are_straight_between_their_points() {
        let ramp = Ramp(vec![(1.0, 0.0), (2.0, 1.0), (4.0, -1.0)]);
        for (time, factor) in [(0.0, 0.0), (1.0, 0.0), (1.5, 0.5), (2.0, 1.0), (3.0, 0.0), (9.0, -1.0)] {
            assert!((ramp.at(time) - factor).abs() < 1e-15, "{time}");
        }
        let half = LoadTime::Preload(0.5).factor(&Ramp(vec![(0.0, 0.8)]));
        assert!((half - 0.4).abs() < 1e-15);
    }
}
