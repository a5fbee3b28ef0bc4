//! `/mesh/{body}`: the boundary surface as a coloured triangle mesh, a `foxglove.SceneUpdate`.

use super::colour::viridis;
use super::pose::on_the_wire;
use super::proto::foxglove::{
    Color, KeyValuePair, Point3, Pose, SceneEntity, SceneUpdate, TriangleListPrimitive,
};
use super::proto::timestamp;
use crate::measure::fields::Fields;
use crate::mechanics::contact::Surface;
use crate::mechanics::rigid::{Shape, triangulated};
use crate::mechanics::tensor::Vec3;
use crate::plan::Plan;
use crate::step::Frame;

/// Topic prefix, followed by the body's name.
pub const TOPIC: &str = "/mesh/";
/// Schema of the surface mesh.
pub const SCHEMA: &str = "foxglove.SceneUpdate";
/// Name of the only frame of reference.
pub const FRAME_ID: &str = "world";
/// Colour if von Mises stress was not requested.
pub(super) const PLAIN: Color = Color { r: 0.7, g: 0.7, b: 0.72, a: 1.0 };

/// Vertex indices of the triangles of a surface, two per quadrilateral; vertex i is node `surface.nodes[i]`.
pub fn triangles(surface: &Surface) -> Vec<u32> {
    let vertex = |node: u32| surface.nodes.binary_search(&node).map_or(0, |i| i as u32);
    let mut indices = Vec::with_capacity(6 * surface.faces.len());
    for face in &surface.faces {
        let [a, b, c, d] = face.map(vertex);
        indices.extend([a, b, c]);
        if d != c {
            indices.extend([a, c, d]);
        }
    }
    indices
}

/// What is drawn of a deformable body: its boundary surface, as erosion has left it.
#[derive(Debug)]
pub struct Boundary {
    nodes: Vec<u32>,
    triangles: Vec<u32>,
    /// Number of elements of all bodies that had eroded.
    eroded: usize,
    /// What vertices are rounded to [m].
    quantum: f64,
}

impl Boundary {
    /// Boundary of a body of the plan, without erosion.
    pub fn new(plan: &Plan, body: usize) -> Self {
        let body = &plan.bodies[body];
        Self {
            nodes: body.boundary.nodes.clone(),
            triangles: triangles(&body.boundary),
            eroded: 0,
            quantum: quantum(&plan.X[body.nodes.start as usize..body.nodes.end as usize]),
        }
    }

    /// Its nodes, in ascending order.
    pub fn nodes(&self) -> &[u32] {
        &self.nodes
    }

    /// The place of one of its nodes [m], rounded to what can be seen: more digits would not compress.
    pub fn vertex(&self, frame: &Frame, body: usize, node: u32) -> Vec3 {
        frame.position_in(body, node).map(|x| (x / self.quantum).round() * self.quantum)
    }

    /// Von Mises stress at all nodes [Pa], if it was requested.
    pub fn stress<'a>(&self, fields: Option<&'a Fields>) -> Option<&'a [f64]> {
        fields.map(|f| &f.von_mises[..]).filter(|values| !values.is_empty())
    }

    /// Takes account of the elements that are eroded in a frame.
    pub fn follow(&mut self, frame: &Frame, body: usize) {
        let (plan_body, eroded) = (&frame.plan.bodies[body], frame.erosion.elements().len());
        if plan_body.erodes && eroded != self.eroded {
            let surface = plan_body.boundary_after(frame.erosion);
            self.triangles = triangles(&surface);
            self.nodes = surface.into_owned().nodes;
            self.eroded = eroded;
        }
    }
}

/// The power of two between 2⁻¹⁶ and 2⁻¹⁵ of the diagonal of the box of a body [m]: half of it, the error, is less than a
/// hundredth of a pixel where the body fills the screen.
fn quantum(X: &[Vec3]) -> f64 {
    let corner = |pick: fn(f64, f64) -> f64| X.iter().copied().reduce(|a, b| a.zip_map(&b, pick));
    let diagonal = corner(f64::max).zip(corner(f64::min)).map_or(0.0, |(high, low)| (high - low).norm());
    if diagonal > 0.0 { (diagonal.log2().floor() - 15.0).exp2() } else { f64::MIN_POSITIVE }
}

/// Triangulated surface of a rigid body, in its axes.
#[derive(Debug)]
pub struct RigidSurface {
    points: Vec<Point3>,
    indices: Vec<u32>,
}

impl RigidSurface {
    /// Triangulates a rigid shape in its own axes.
    pub fn new(shape: &Shape) -> Self {
        let (points, triangles) = triangulated(shape);
        Self { points: points.into_iter().map(Into::into).collect(), indices: triangles.concat() }
    }
}

/// The message of a rigid body at a field time; `None` for a deformable one.
pub fn rigid_message(frame: &Frame, body: usize, boundary: &RigidSurface) -> Option<SceneUpdate> {
    let mesh = TriangleListPrimitive {
        pose: Some(on_the_wire(&frame.pose(body)?)),
        points: boundary.points.clone(),
        color: Some(PLAIN),
        colors: Vec::new(),
        indices: boundary.indices.clone(),
    };
    Some(update(frame, body, vec![pair("time_s", frame.time.to_string())], mesh))
}

/// The message of one body at a field time; colours range from 0 to `top` [Pa] of von Mises stress.
pub fn message(
    frame: &Frame,
    body: usize,
    fields: Option<&Fields>,
    boundary: &Boundary,
    top: f64,
) -> SceneUpdate {
    let nodes = &boundary.nodes;
    let stress = boundary.stress(fields);
    let mut metadata = vec![pair("time_s", frame.time.to_string())];
    if stress.is_some() {
        metadata.push(pair("colour", "von_mises_pa, viridis".into()));
        metadata.push(pair("colour_range_pa", format!("0 … {top}")));
    }
    let mesh = TriangleListPrimitive {
        pose: Some(Pose::identity()),
        points: nodes.iter().map(|&node| boundary.vertex(frame, body, node).into()).collect(),
        color: stress.is_none().then_some(PLAIN),
        colors: stress
            .map(|s| nodes.iter().map(|&n| viridis(s[n as usize], top)).collect())
            .unwrap_or_default(),
        indices: boundary.triangles.clone(),
    };
    update(frame, body, metadata, mesh)
}

fn update(
    frame: &Frame,
    body: usize,
    metadata: Vec<KeyValuePair>,
    mesh: TriangleListPrimitive,
) -> SceneUpdate {
    let entity = SceneEntity {
        timestamp: Some(timestamp(frame.time)),
        frame_id: FRAME_ID.into(),
        id: frame.plan.bodies[body].name.clone(),
        metadata,
        triangles: vec![mesh],
        ..SceneEntity::default()
    };
    SceneUpdate { entities: vec![entity], ..SceneUpdate::default() }
}

fn pair(key: &str, value: String) -> KeyValuePair {
    KeyValuePair { key: key.into(), value }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    #[allow(clippy::float_cmp)] // powers of two
    fn vertices_are_rounded_by_the_size_of_their_body() {
        let box_of = |side: f64| [Vec3::zeros(), Vec3::new(side, 0.0, 0.0), Vec3::new(0.0, 0.1 * side, 0.0)];
        assert_eq!([1.0, 0.3].map(|side| quantum(&box_of(side))), [0.5_f64.powi(15), 0.5_f64.powi(17)]);
        assert!(quantum(&[Vec3::zeros()]) > 0.0);
    }

    #[test]
    fn a_quadrilateral_is_two_triangles_and_a_triangle_one() {
        let surface = Surface::new(vec![3, 5, 7, 9], vec![[3, 5, 9, 7], [3, 5, 7, 7]]);
        assert_eq!(triangles(&surface), [0, 1, 3, 0, 3, 2, 0, 1, 2]);
    }
}
