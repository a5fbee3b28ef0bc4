//! What a user needs beside a first scene to let something hit it: the parts and sets of the mesh, and where a ball touches it.

use super::first_scene::{first_scene, first_scene_of_scan};
use super::first_surfaces::{Nest, SurfaceFile};
use crate::mechanics::tensor::Vec3;
use crate::mesh::segmentation::{LabelCount, LabelVolume, body_of};
use crate::mesh::{Mesh, MeshError, surface};
use serde::{Deserialize, Serialize};
use serde_json::Value;

/// Names of the ends of a scan, where it cuts the body.
const ENDS: [[&str; 2]; 3] = [["x_min", "x_max"], ["y_min", "y_max"], ["z_min", "z_max"]];

/// How a ball comes to the target.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Approach {
    /// Radius of the ball [m].
    pub radius_m: f64,
    /// A point on the path of its centre [m]; `None`: the centre of the bounding box of the target.
    pub through_m: Option<[f64; 3]>,
}

impl Default for Approach {
    fn default() -> Self {
        Self { radius_m: 0.02, through_m: None }
    }
}

/// A first scene of an uploaded mesh or scan, or of uploaded closed surfaces.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "service", derive(utoipa::ToSchema))]
pub struct FirstScene {
    /// The scene, with `null` and `to be chosen` where only the user knows.
    #[cfg_attr(feature = "service", schema(value_type = Object))]
    pub scene: Value,
    /// The parts of the mesh, the labels of the scan, or the surfaces in the order of the scene.
    pub parts: Vec<FirstPart>,
    /// Node sets that can hold a body; of a scan, those where it is cut.
    pub sets: Vec<String>,
    /// Where a ball touches the target that comes along x, y or z, either way; none for a way on which it misses.
    pub touches: Vec<Touch>,
}

/// A part of a mesh, or a label of a scan.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "service", derive(utoipa::ToSchema))]
pub struct FirstPart {
    /// Name of the part, as the scene has it; of a hole that of its set.
    pub part: String,
    /// Label of the scan.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub label: Option<i64>,
    /// Volume [m³]; of a surface, with what lies in it.
    pub volume_m3: f64,
    /// Lower and upper corner of its bounding box [m].
    pub bounding_box_m: [[f64; 3]; 2],
}

/// Where a ball first touches the target.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "service", derive(utoipa::ToSchema))]
pub struct Touch {
    /// Direction in which the ball moves, a unit vector.
    pub direction: [f64; 3],
    /// Where it touches [m].
    pub point_m: [f64; 3],
    /// Centre of the ball at first contact [m]. The elements that fill a scan or surfaces deviate from these: begin a quarter of their size before it.
    pub center_m: [f64; 3],
}

impl FirstScene {
    /// First scene of a mesh that the scene refers to as `name`.
    pub fn of_mesh(mesh: &Mesh, name: &str, approach: &Approach) -> Self {
        Self::of_scene(mesh, first_scene(mesh, name), approach)
    }

    /// Completes a scene of a mesh. Lengths are those of the scene, which may scale the mesh.
    pub fn of_scene(mesh: &Mesh, scene: Value, approach: &Approach) -> Self {
        let scale = scene["bodies"][0]["placement"]["scale"].as_f64().unwrap_or(1.0);
        // The surface of the tissue alone: what strikes may be in the same file.
        let bodies = scene["bodies"].as_array().map(Vec::as_slice).unwrap_or_default();
        let tissue = bodies.iter().find(|body| body["role"] == "tissue");
        let parts = tissue.and_then(|body| body["parts"].as_array()).map(Vec::as_slice).unwrap_or_default();
        let names: Vec<&str> = parts.iter().filter_map(|part| part["part"].as_str()).collect();
        let is_target: Vec<bool> = mesh.parts.iter().map(|part| names.contains(&part.as_str())).collect();
        let boundary = surface::Boundary::of(&mesh.cells);
        let faces: Vec<[Vec3; 4]> = boundary
            .faces
            .iter()
            .zip(&boundary.owner)
            .filter(|(_, owner)| is_target[mesh.part_of[**owner as usize] as usize])
            .map(|(face, _)| face.map(|node| mesh.nodes[node as usize] * scale))
            .collect();
        let bounds = Bounds::of(faces.iter().flatten());
        let mut paths = Path::all(approach, &bounds);
        for [a, b, c, d] in faces {
            for path in &mut paths {
                path.meet_triangle(&[a, b, c]);
                path.meet_triangle(&[a, c, d]);
            }
        }
        let mut of_part = vec![(Bounds::default(), 0.0); mesh.parts.len()];
        for (element, cell) in mesh.cells.iter().enumerate() {
            let (bounds, volume) = &mut of_part[mesh.part_of[element] as usize];
            *volume += mesh.element_volume_m3(element) * scale.powi(3);
            cell.nodes.iter().for_each(|node| bounds.take(&(mesh.nodes[*node as usize] * scale)));
        }
        let part = |(part, (bounds, volume_m3)): (&String, (Bounds, f64))| FirstPart {
            part: part.clone(),
            label: None,
            volume_m3,
            bounding_box_m: bounds.corners(),
        };
        Self {
            parts: mesh.parts.iter().zip(of_part).map(part).collect(),
            sets: mesh.node_sets.keys().cloned().collect(),
            touches: paths.iter().filter_map(Path::touch).collect(),
            scene,
        }
    }

    /// First scene of closed surfaces, in any order.
    pub fn of_surfaces(files: &[SurfaceFile], approach: &Approach) -> Self {
        let nest = Nest::of(files);
        let corners = |file: &SurfaceFile| file.surface.bounding_box().map(|x| x * nest.scale);
        let all: Vec<Vec3> = nest.files.iter().flat_map(|file| corners(file)).collect();
        let mut paths = Path::all(approach, &Bounds::of(&all));
        for file in &nest.files {
            let points: Vec<Vec3> = file.surface.points.iter().map(|x| x * nest.scale).collect();
            for triangle in &file.surface.triangles {
                let triangle = triangle.map(|node| points[node as usize]);
                for path in &mut paths {
                    path.meet_triangle(&triangle);
                }
            }
        }
        let part = |file: &&SurfaceFile| FirstPart {
            part: file.part().to_owned(),
            label: None,
            volume_m3: nest.volume_m3(file),
            bounding_box_m: corners(file).map(Into::into),
        };
        Self {
            parts: nest.files.iter().map(part).collect(),
            sets: Vec::new(),
            touches: paths.iter().filter_map(Path::touch).collect(),
            scene: nest.first_scene(),
        }
    }

    /// First scene of a scan that the scene refers to as `name`.
    ///
    /// # Errors
    /// `Unsupported` for a grid with shear.
    pub fn of_scan(volume: &LabelVolume, name: &str, approach: &Approach) -> Result<Self, MeshError> {
        let frame = volume.frame()?;
        let counts: Vec<LabelCount> = volume.counts().into_iter().filter(|count| count.label != 0).collect();
        // Noise in the air is no body: it is not meshed.
        let body = body_of(volume, &frame);
        let is_body = |[i, j, k]: [usize; 3]| body[i + frame.dims[0] * (j + frame.dims[1] * k)];
        let mut range = [frame.dims, [0; 3]];
        for voxel in frame.voxels().filter(|voxel| is_body(*voxel)) {
            let [low, high] = range;
            range = [
                std::array::from_fn(|k| low[k].min(voxel[k])),
                std::array::from_fn(|k| high[k].max(voxel[k] + 1)),
            ];
        }
        let place = |index: Vec3| frame.world(&index.component_mul(&Vec3::from(frame.spacing)));
        let corners = (0..8).map(|corner| place(Vec3::from_fn(|k, _| range[corner >> k & 1][k] as f64)));
        let bounds =
            if body.contains(&true) { Bounds::of(&corners.collect::<Vec<_>>()) } else { Bounds::default() };
        let mut paths = Path::all(approach, &bounds);
        let mut is_cut = [[false; 2]; 3];
        for voxel in frame.voxels().filter(|voxel| is_body(*voxel)) {
            let mut is_outer = false;
            for axis in 0..3 {
                let [is_first, is_last] = [voxel[axis] == 0, voxel[axis] + 1 == frame.dims[axis]];
                is_cut[axis][0] |= is_first;
                is_cut[axis][1] |= is_last;
                let beside = |n: usize| {
                    let mut other = voxel;
                    other[axis] = n;
                    is_body(other)
                };
                is_outer |= is_first || is_last || !beside(voxel[axis] - 1) || !beside(voxel[axis] + 1);
            }
            for corner in (0..8).filter(|_| is_outer) {
                meet(
                    &mut paths,
                    &place(Vec3::from_fn(|axis, _| (voxel[axis] + (corner >> axis & 1)) as f64)),
                );
            }
        }
        let scene = first_scene_of_scan(volume, name);
        let ends = ENDS.iter().flatten().zip(is_cut.as_flattened());
        let part = |count: &LabelCount| FirstPart {
            part: count.part(),
            label: Some(count.label),
            volume_m3: count.volume_m3,
            bounding_box_m: count.bounding_box_m,
        };
        Ok(Self {
            parts: counts.iter().map(part).collect(),
            sets: ends.filter(|(_, is_cut)| **is_cut).map(|(name, _)| (*name).to_owned()).collect(),
            touches: paths.iter().filter_map(Path::touch).collect(),
            scene,
        })
    }
}

fn meet(paths: &mut [Path], point: &Vec3) {
    for path in paths {
        path.meet(point);
    }
}

/// A bounding box; empty at first.
#[derive(Clone, Copy, Debug)]
struct Bounds([Vec3; 2]);

impl Default for Bounds {
    fn default() -> Self {
        Self([Vec3::repeat(f64::INFINITY), Vec3::repeat(f64::NEG_INFINITY)])
    }
}

impl Bounds {
    fn of<'a>(points: impl IntoIterator<Item = &'a Vec3>) -> Self {
        let mut bounds = Self::default();
        points.into_iter().for_each(|point| bounds.take(point));
        bounds
    }

    fn take(&mut self, point: &Vec3) {
        self.0 = [self.0[0].inf(point), self.0[1].sup(point)];
    }

    /// Both corners; zero for an empty box.
    fn corners(&self) -> [[f64; 3]; 2] {
        if self.0[0].x > self.0[1].x { [[0.0; 3]; 2] } else { self.0.map(Into::into) }
    }
}

/// The way of a ball along an axis, and the first point that it touches.
struct Path {
    direction: Vec3,
    through: Vec3,
    radius: f64,
    /// How far beyond `through` its centre is when it touches, and where.
    first: Option<(f64, Vec3)>,
}

impl Path {
    /// The six ways along x, y, z.
    fn all(approach: &Approach, bounds: &Bounds) -> Vec<Self> {
        let [low, high] = bounds.corners().map(Vec3::from);
        let through = approach.through_m.map_or(0.5 * (low + high), Vec3::from);
        let ways = (0..3).flat_map(|axis| [-1.0, 1.0].map(|sign| Vec3::ith(axis, sign)));
        ways.map(|direction| Self { direction, through, radius: approach.radius_m, first: None }).collect()
    }

    /// Compares with a point of the target: the ball touches it where (centre − point)² = r².
    fn meet(&mut self, point: &Vec3) {
        let from = point - self.through;
        let along = from.dot(&self.direction);
        let half_chord = self.radius.powi(2) - (from.norm_squared() - along.powi(2));
        if half_chord < 0.0 {
            return;
        }
        self.note(along - half_chord.sqrt(), point);
    }

    /// Compares with a triangle: its corners, its edges and its inside.
    fn meet_triangle(&mut self, corners: &[Vec3; 3]) {
        for (i, a) in corners.iter().enumerate() {
            self.meet(a);
            self.meet_edge(a, &corners[(i + 1) % 3]);
        }
        let [a, b, c] = corners;
        let Some(normal) = (b - a).cross(&(c - a)).try_normalize(0.0) else { return };
        let approaching = normal.dot(&self.direction);
        if approaching == 0.0 {
            return;
        }
        // The side that the ball comes from.
        let normal = normal * -approaching.signum();
        let along = (normal.dot(&(self.through - a)) - self.radius) / approaching.abs();
        let point = self.through + self.direction * along - normal * self.radius;
        let is_inside = |i: usize| {
            let (from, to) = (corners[i], corners[(i + 1) % 3]);
            (to - from).cross(&(point - from)).dot(&normal) * -approaching.signum() >= 0.0
        };
        if (0..3).all(is_inside) {
            self.note(along, &point);
        }
    }

    /// Compares with the line between two points: the ball touches it where |(centre − a) × edge| = r |edge|.
    fn meet_edge(&mut self, a: &Vec3, b: &Vec3) {
        let edge = b - a;
        let (start, way) = ((self.through - a).cross(&edge), self.direction.cross(&edge));
        let (speed, half_slope) = (way.norm_squared(), start.dot(&way));
        let discriminant =
            half_slope.powi(2) - speed * (start.norm_squared() - self.radius.powi(2) * edge.norm_squared());
        if speed == 0.0 || discriminant < 0.0 {
            return;
        }
        let along = (-half_slope - discriminant.sqrt()) / speed;
        let part = edge.dot(&(self.through + self.direction * along - a)) / edge.norm_squared();
        if (0.0..=1.0).contains(&part) {
            self.note(along, &(a + edge * part));
        }
    }

    /// The first of all touches is kept.
    fn note(&mut self, centre: f64, point: &Vec3) {
        if self.first.is_none_or(|(least, _)| centre < least) {
            self.first = Some((centre, *point));
        }
    }

    fn touch(&self) -> Option<Touch> {
        self.first.map(|(along, point)| Touch {
            direction: self.direction.into(),
            point_m: point.into(),
            center_m: (self.through + self.direction * along).into(),
        })
    }
}

#[cfg(test)]
#[allow(clippy::float_cmp, clippy::unwrap_used)] // tests may panic
mod tests {
    use super::*;
    use crate::mesh::generate::block::Block;
    use std::collections::BTreeMap;

    fn close(a: [f64; 3], b: [f64; 3]) {
        assert!((Vec3::from(a) - Vec3::from(b)).norm() < 1e-12, "{a:?} instead of {b:?}");
    }

    fn coming(first: &FirstScene, direction: [f64; 3]) -> &Touch {
        first.touches.iter().find(|touch| touch.direction == direction).unwrap()
    }

    #[test]
    fn a_ball_touches_a_block_at_its_faces_and_beside_them_at_an_edge() {
        let block = Block::uniform(Vec3::zeros(), Vec3::new(100.0, 80.0, 40.0), [5, 4, 2], "fat");
        // In millimetres, as its size says.
        let mesh = block.generate().unwrap();
        let first = FirstScene::of_mesh(&mesh, "id", &Approach::default());
        let above = coming(&first, [0.0, 0.0, -1.0]);
        close(above.point_m, [0.05, 0.04, 0.04]);
        close(above.center_m, [0.05, 0.04, 0.06]);
        assert!((first.parts[0].volume_m3 - 3.2e-4).abs() < 1e-15, "{:?}", first.parts);
        assert!(first.sets.iter().any(|set| set == "z_min"), "{:?}", first.sets);
        // Beside the block by 12 of 20 mm: 16 mm above its edge.
        let beside = Approach { radius_m: 0.02, through_m: Some([0.112, 0.04, 0.0]) };
        let first = FirstScene::of_mesh(&mesh, "id", &beside);
        close(coming(&first, [0.0, 0.0, -1.0]).center_m, [0.112, 0.04, 0.056]);
        let far = Approach { radius_m: 0.02, through_m: Some([0.2, 0.04, 0.0]) };
        let ways: Vec<[f64; 3]> =
            FirstScene::of_mesh(&mesh, "id", &far).touches.iter().map(|touch| touch.direction).collect();
        assert_eq!(ways, [[-1.0, 0.0, 0.0], [1.0, 0.0, 0.0]]);
    }

    #[test]
    fn a_ball_touches_surfaces_inside_their_triangles_at_edges_and_at_corners() {
        use crate::mechanics::rigid::{Shape, triangulated};
        let file = |half: Vec3, name: &str| {
            let (points, triangles) = triangulated(&Shape::Box { half });
            SurfaceFile {
                file: format!("id of {name}"),
                name: name.to_owned(),
                surface: crate::mesh::read::stl::ClosedSurface { points, triangles },
            }
        };
        // In millimetres.
        let files = [file(Vec3::repeat(5.0), "femur.stl"), file(Vec3::new(50.0, 40.0, 30.0), "muscle.stl")];
        let at = |x: f64, y: f64| Approach { radius_m: 0.02, through_m: Some([x, y, 0.0]) };
        for ((x, y), above) in [
            ((0.013, 0.007), 0.02),
            ((0.062, 0.007), 0.016),
            ((0.013, -0.052), 0.016),
            ((0.058, 0.048), (4e-4_f64 - 2.0 * 64e-6).sqrt()),
        ] {
            let first = FirstScene::of_surfaces(&files, &at(x, y));
            let touch = coming(&first, [0.0, 0.0, -1.0]);
            close(touch.center_m, [x, y, 0.03 + above]);
            close(touch.point_m, [x.min(0.05), y.clamp(-0.04, 0.04), 0.03]);
        }
        let first = FirstScene::of_surfaces(&files, &Approach::default());
        assert_eq!(first.touches.len(), 6);
        let parts: Vec<&str> = first.parts.iter().map(|part| part.part.as_str()).collect();
        assert_eq!(parts, ["muscle", "femur"]);
        assert!((first.parts[0].volume_m3 - 4.8e-4).abs() < 1e-12);
        assert_eq!(first.scene["bodies"][0]["mesh"]["segmentation"]["surfaces"][1]["hole"], "femur");
    }

    #[test]
    fn a_ball_touches_the_labels_of_a_scan_which_are_cut_at_its_ends() {
        // A column of 2 mm × 2 mm along y, in voxels of 2 mm, in the middle of a scan of 6 × 4 × 6 mm.
        let labels = (0..18).map(|n| u16::from(n % 3 == 1 && n / 6 == 1)).collect();
        let volume = LabelVolume {
            dims: [3, 2, 3],
            labels,
            values: vec![0, 4],
            names: BTreeMap::from([(4, "Femoral Muscle".to_owned())]),
            origin: Vec3::zeros(),
            steps: [Vec3::x() * 2e-3, Vec3::y() * 2e-3, Vec3::z() * 2e-3],
            notes: Vec::new(),
        };
        let approach = Approach { radius_m: 5e-3, through_m: None };
        let first = FirstScene::of_scan(&volume, "id", &approach).unwrap();
        assert_eq!(first.sets, ["y_min", "y_max"]);
        assert_eq!((first.parts[0].part.as_str(), first.parts[0].label), ("Femoral Muscle", Some(4)));
        close(first.parts[0].bounding_box_m[1], [3e-3, 3e-3, 3e-3]);
        // It rests on the corners of voxels, 1 mm beside its axis.
        let above = coming(&first, [0.0, 0.0, -1.0]);
        close(above.center_m, [2e-3, 1e-3, 3e-3 + (25e-6_f64 - 1e-6).sqrt()]);
    }

    #[test]
    fn noise_in_the_air_is_not_touched() {
        // A block of 4³ voxels of 1 mm in the middle of 12³, and a single voxel above it.
        let is_in = |n: usize| (4..8).contains(&n);
        let label = |n: usize| {
            let [i, j, k] = [n % 12, n / 12 % 12, n / 144];
            u16::from(is_in(i) && is_in(j) && is_in(k) || [i, j, k] == [5, 5, 11])
        };
        let volume = LabelVolume {
            dims: [12; 3],
            labels: (0..1728).map(label).collect(),
            values: vec![0, 1],
            names: BTreeMap::new(),
            origin: Vec3::zeros(),
            steps: [Vec3::x() * 1e-3, Vec3::y() * 1e-3, Vec3::z() * 1e-3],
            notes: Vec::new(),
        };
        let first = FirstScene::of_scan(&volume, "id", &Approach::default()).unwrap();
        let above = coming(&first, [0.0, 0.0, -1.0]);
        assert!((above.point_m[2] - 7.5e-3).abs() < 1e-12, "{above:?}");
    }
}
