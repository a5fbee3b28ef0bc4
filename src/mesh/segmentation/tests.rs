//! A synthetic scan of a limb, from voxels to elements.
#![allow(clippy::unwrap_used)] // tests may panic

use super::*;
use crate::mechanics::tensor::{Mat3, Vec3};
use crate::mesh::quality::quality;
use crate::mesh::surface::{boundary, enclosed_volume_m3, is_closed, topology_problems};
use nalgebra::Rotation3;
use std::collections::BTreeMap;

mod small;

/// A limb with an elliptic section, skin, fat, muscle and two bones, in a scan with noise and anisotropic voxels at an angle.
pub(crate) struct Limb {
    pub(crate) semi_axes: [f64; 2],
    pub(crate) length: f64,
    pub(crate) skin: f64,
    pub(crate) fat: f64,
    pub(crate) bones: [([f64; 2], f64); 2],
    pub(crate) spacing: [f64; 3],
    /// Probability that a voxel has a wrong label [-].
    pub(crate) noise: f64,
}

impl Default for Limb {
    fn default() -> Self {
        Self {
            semi_axes: [0.025, 0.022],
            length: 0.03,
            skin: 0.002,
            fat: 0.005,
            bones: [([0.007, 0.0], 0.005), ([-0.008, -0.002], 0.004)],
            spacing: [0.0005, 0.0005, 0.0015],
            noise: 0.01,
        }
    }
}

impl Limb {
    /// Rotation of the limb from x (section), y (section), z (along it) into the space of the scan.
    pub(crate) fn rotation() -> Mat3 {
        Rotation3::from_euler_angles(0.2, -0.15, 0.3).into_inner()
    }

    /// Depth below the outer ellipse [m]; negative outside.
    fn depth(&self, p: [f64; 2]) -> f64 {
        let [a, b] = self.semi_axes;
        // Nearest point of the ellipse by Newton's method in its parameter.
        let mut t = (p[1] / b).atan2(p[0] / a);
        for _ in 0..8 {
            let (s, c) = t.sin_cos();
            let f = (a * a - b * b) * s * c - p[0] * a * s + p[1] * b * c;
            let df = (a * a - b * b) * (c * c - s * s) - p[0] * a * c - p[1] * b * s;
            if df.abs() > 1e-12 {
                t -= (f / df).clamp(-0.3, 0.3);
            }
        }
        let away = [p[0] - a * t.cos(), p[1] - b * t.sin()];
        let distance = away[0].hypot(away[1]);
        let is_inside = (p[0] / a).powi(2) + (p[1] / b).powi(2) < 1.0;
        if is_inside { distance } else { -distance }
    }

    /// Label at a position of the section: 1 skin, 2 fat, 3 muscle, 4 and 5 bones.
    fn label(&self, p: [f64; 2]) -> u8 {
        for (i, (centre, radius)) in (4..).zip(&self.bones) {
            if (p[0] - centre[0]).hypot(p[1] - centre[1]) < *radius {
                return i;
            }
        }
        match self.depth(p) {
            d if d < 0.0 => 0,
            d if d < self.skin => 1,
            d if d < self.skin + self.fat => 2,
            _ => 3,
        }
    }

    /// Exact volumes of the labels 1 to 5 [m³]: the area within a depth of a convex curve is A − L d + π d².
    pub(crate) fn volumes(&self) -> [f64; 5] {
        use std::f64::consts::PI;
        let [a, b] = self.semi_axes;
        let h = ((a - b) / (a + b)).powi(2);
        let around = PI * (a + b) * (1.0 + 3.0 * h / (10.0 + (4.0 - 3.0 * h).sqrt()));
        let within = |d: f64| PI * a * b - around * d + PI * d * d;
        let bones = self.bones.map(|(_, radius)| PI * radius * radius);
        let muscle = within(self.skin + self.fat) - bones[0] - bones[1];
        let [whole, inner] = [within(0.0), within(self.skin)];
        [whole - inner, inner - within(self.skin + self.fat), muscle, bones[0], bones[1]]
            .map(|area| area * self.length)
    }

    /// The scan: the limb from end to end, with air around it.
    pub(crate) fn scan(&self) -> LabelVolume {
        let margin = 0.004;
        let dims = [
            (2.0 * (self.semi_axes[0] + margin) / self.spacing[0]).ceil() as usize,
            (2.0 * (self.semi_axes[1] + margin) / self.spacing[1]).ceil() as usize,
            (self.length / self.spacing[2]).round() as usize,
        ];
        let mut random = 12345_u64;
        let mut next = || {
            random = random.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (random >> 33) as f64 / f64::from(1_u32 << 31)
        };
        let centre = |i: usize, k: usize| (i as f64 + 0.5 - 0.5 * dims[k] as f64) * self.spacing[k];
        let section: Vec<u8> = (0..dims[0] * dims[1])
            .map(|n| self.label([centre(n % dims[0], 0), centre(n / dims[0], 1)]))
            .collect();
        let mut labels = Vec::with_capacity(section.len() * dims[2]);
        for _ in 0..dims[2] {
            for &label in &section {
                let is_wrong = next() < self.noise;
                labels.push(u16::from(if is_wrong { (next() * 6.0) as u8 } else { label }));
            }
        }
        let rotation = Self::rotation();
        let steps = [0, 1, 2].map(|k| rotation.column(k) * self.spacing[k]);
        let first = Vec3::from_fn(|k, _| centre(0, k));
        LabelVolume {
            dims,
            labels,
            values: (0..6).collect(),
            names: BTreeMap::new(),
            origin: rotation * first + Vec3::new(0.1, -0.2, 0.3),
            steps,
            notes: Vec::new(),
        }
    }

    /// The point of the outer surface on the second axis of the section, half way along the limb.
    pub(crate) fn top(&self) -> Vec3 {
        Self::rotation() * Vec3::new(0.0, self.semi_axes[1], 0.0) + Vec3::new(0.1, -0.2, 0.3)
    }
}

fn part(name: &str) -> LabelUse {
    LabelUse::Part(name.into())
}

fn options() -> Options {
    Options {
        labels: vec![
            (1, part("skin")),
            (2, part("fat")),
            (3, part("muscle")),
            (4, LabelUse::Hole("radius".into())),
            (5, LabelUse::Hole("ulna".into())),
        ],
        volumes_m3: Vec::new(),
        size_m: 0.004,
        near: Vec::new(),
        thin_size_m: None,
        crop: None,
        skin: None,
        noise_m3: None,
        max_elements: 200_000,
    }
}

/// Whether all nodes of a face are in one of the sets of the surface.
fn on_surface(mesh: &crate::mesh::Mesh, face: &[u32; 4]) -> bool {
    let has_all = |set: &Vec<u32>| face.iter().all(|node| set.binary_search(node).is_ok());
    mesh.node_sets.values().any(has_all)
}

/// Checks what holds for every mesh, and prints it.
fn check(mesh: &crate::mesh::Mesh) {
    let found = quality(mesh).unwrap();
    println!(
        "{} elements, {} hanging; scaled Jacobian from {:.3}",
        mesh.cells.len(),
        mesh.hanging.len(),
        found.min_scaled_jacobian
    );
    println!("  shortest edge {:.2e} m, aspect ratio up to {:.1}", found.min_edge_m, found.max_aspect_ratio);
    mesh.notes.iter().for_each(|note| println!("  {note}"));
    assert!(found.min_scaled_jacobian >= 0.2, "{}", found.min_scaled_jacobian);
    assert_eq!((found.unused_nodes.count, found.coincident_nodes.count), (0, 0));
    assert!(topology_problems(&mesh.cells).is_empty());
    let faces = mesh.hanging.boundary(boundary(&mesh.cells));
    assert!(is_closed(&faces));
    assert!(faces.iter().all(|face| on_surface(mesh, face)), "there are no faces inside");
    let enclosed = enclosed_volume_m3(&faces, &mesh.nodes);
    println!("  volume {:.5e}, enclosed {enclosed:.5e}", mesh.volume_m3());
    let masters: Vec<u32> = mesh.hanging.each().flat_map(|(_, on)| on.to_vec()).collect();
    let hangs: Vec<u32> = mesh.hanging.each().map(|(node, _)| node).collect();
    assert!(masters.iter().all(|node| hangs.binary_search(node).is_err()), "there are no chains");
}

/// Whether the notes say of every label that its volume is that of its voxels within 1 %.
fn assert_voxels_kept(mesh: &crate::mesh::Mesh) {
    let notes: Vec<&String> = mesh.notes.iter().filter(|note| note.contains("of its voxels")).collect();
    assert!(notes.len() >= 4 && notes.iter().all(|note| note.ends_with("of its voxels")), "{notes:?}");
}

fn deviations(mesh: &crate::mesh::Mesh, exact: &[(&str, f64)]) -> Vec<f64> {
    exact.iter().map(|(name, volume)| mesh.part_volume_m3(name) / volume - 1.0).collect()
}

#[test]
fn a_hole_as_wide_as_an_element_is_resolved() {
    // The element in the middle is all bone.
    let from_axis = |n: usize| (n % 60) as f64 - 29.5;
    let label = |n: usize| if from_axis(n).hypot(from_axis(n / 60)) < 9.0 { 4 } else { 3 };
    let volume = LabelVolume {
        dims: [60, 60, 24],
        labels: (0..60 * 60 * 24).map(label).collect(),
        values: (0..6).collect(),
        names: BTreeMap::new(),
        origin: Vec3::zeros(),
        steps: [Vec3::x() * 0.001, Vec3::y() * 0.001, Vec3::z() * 0.001],
        notes: Vec::new(),
    };
    let options = Options { size_m: 0.012, thin_size_m: Some(0.006), ..options() };
    let mesh = mesh(&volume, &options).unwrap();
    assert_eq!(mesh.notes.iter().filter(|note| note.starts_with("radius: ")).count(), 1, "{:?}", mesh.notes);
    check(&mesh);
}

#[test]
fn more_elements_than_allowed_are_refused_before_they_exist() {
    let volume = LabelVolume {
        dims: [20; 3],
        labels: vec![1; 20 * 20 * 20],
        values: vec![0, 1],
        names: BTreeMap::new(),
        origin: Vec3::zeros(),
        steps: [0, 1, 2].map(|k| Vec3::ith(k, 0.001)),
        notes: Vec::new(),
    };
    let near = Near { point: Vec3::repeat(0.01), size_m: 1e-5, within_m: 0.01 };
    let fine = Options { labels: Vec::new(), near: vec![near], max_elements: 60_000, ..options() };
    let error = mesh(&volume, &fine).unwrap_err().to_string();
    // A leaf that is halved becomes eight: the number is the first that is too large.
    let found: u64 = error.split(' ').next().and_then(|count| count.parse().ok()).unwrap();
    assert!((60_001..60_008).contains(&found) && error.contains("enlarge the sizes"), "{error}");
}

#[test]
fn noise_is_refused_before_it_takes_long() {
    // Two labels at random: their groups are no islands.
    let mut random = 1_u64;
    let mut label = || {
        random = random.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        3 + (random >> 60 & 1) as u16
    };
    let volume = LabelVolume {
        dims: [64, 64, 64],
        labels: (0..64 * 64 * 64).map(|_| label()).collect(),
        values: (0..6).collect(),
        names: BTreeMap::new(),
        origin: Vec3::zeros(),
        steps: [Vec3::x() * 0.001, Vec3::y() * 0.001, Vec3::z() * 0.001],
        notes: Vec::new(),
    };
    let fine = Options { size_m: 0.002, ..options() };
    let error = mesh(&volume, &fine).unwrap_err().to_string();
    assert!(error.contains("46 % of the faces") && error.contains("median filter"), "{error}");
    // Of surfaces it is the voxels that are wrong.
    let of_surfaces = Options { volumes_m3: vec![(3, 1e-4), (4, 1e-4)], ..fine };
    let error = mesh(&volume, &of_surfaces).unwrap_err().to_string();
    assert!(error.contains("too coarse for the surface of \"") && error.contains("voxel_size_m"), "{error}");
    let error = mesh(&volume, &Options { size_m: 0.012, ..options() }).unwrap_err().to_string();
    assert!(error.starts_with("elements too large for \"muscle\""), "{error}");
    // The remedy.
    let mut smooth = volume;
    let [nx, ny] = [smooth.dims[0], smooth.dims[0] * smooth.dims[1]];
    smooth.labels =
        (0..smooth.labels.len()).map(|n| if n % nx < 20 && n / ny < 40 { 3 } else { 4 }).collect();
    mesh(&smooth, &Options { size_m: 0.004, ..options() }).unwrap();
}

#[test]
fn a_surface_thinner_than_its_voxels_asks_for_smaller_ones() {
    let volume = LabelVolume {
        dims: [4, 4, 3],
        labels: (0..48).map(|n| u16::from(n == 21)).collect(),
        values: vec![0, 1],
        names: BTreeMap::new(),
        origin: Vec3::zeros(),
        steps: [Vec3::x() * 0.003, Vec3::y() * 0.003, Vec3::z() * 0.003],
        notes: Vec::new(),
    };
    let options =
        Options { labels: vec![(1, part("plate"))], volumes_m3: vec![(1, 1e-8)], size_m: 0.006, ..options() };
    let error = mesh(&volume, &options).unwrap_err().to_string();
    let what = "voxels of 3.000 mm, which are too coarse for the surface of \"plate\"";
    assert!(error.contains(what) && error.contains("voxel_size_m"), "{error}");
    let error = mesh(&volume, &Options { volumes_m3: Vec::new(), ..options }).unwrap_err().to_string();
    assert!(error.contains("crop"), "{error}");
}

#[test]
fn a_limb_keeps_its_volumes_with_skin_from_the_scan() {
    let limb = Limb::default();
    let options = Options { thin_size_m: Some(0.001), max_elements: 400_000, ..options() };
    let mesh = mesh(&limb.scan(), &options).unwrap();
    check(&mesh);
    // The voxels have 2 % more skin than the limb.
    let within = [0.03, 0.01, 0.01];
    let [skin, fat, muscle, ..] = limb.volumes();
    let found = deviations(&mesh, &[("skin", skin), ("fat", fat), ("muscle", muscle)]);
    println!("  against the exact volumes: {found:.4?}");
    assert!(found.iter().zip(within).all(|(d, most)| d.abs() < most), "{found:?}");
    assert_voxels_kept(&mesh);
}

#[test]
fn a_limb_keeps_its_volumes_with_a_skin_of_given_thickness() {
    let limb = Limb::default();
    let mut options = Options {
        skin: Some(SkinLayer { part: "skin".into(), thickness_m: limb.skin }),
        near: vec![Near { point: limb.top(), size_m: 0.0016, within_m: 0.006 }],
        thin_size_m: Some(0.003),
        ..options()
    };
    options.labels[0] = (1, part("fat"));
    let mesh = mesh(&limb.scan(), &options).unwrap();
    check(&mesh);
    // The thickness is kept in the mean only, and what the skin lacks the fat has.
    let within = [0.04, 0.02, 0.01];
    let mut thick: Vec<f64> = (0..mesh.cells.len())
        .filter(|e| mesh.parts[mesh.part_of[*e] as usize] == "skin")
        .map(|e| {
            let x = mesh.cells.points(e, &mesh.nodes);
            ((x[4] - x[0]).norm() + (x[5] - x[1]).norm() + (x[6] - x[2]).norm() + (x[7] - x[3]).norm()) / 4.0
        })
        .collect();
    thick.sort_by(f64::total_cmp);
    println!(
        "thickness {:?}",
        (0..=20).map(|i| (thick[i * (thick.len() - 1) / 20] * 1e5).round() / 100.0).collect::<Vec<_>>()
    );
    let [skin, fat, muscle, ..] = limb.volumes();
    let found = deviations(&mesh, &[("skin", skin), ("fat", fat), ("muscle", muscle)]);
    println!("  against the exact volumes: {found:.4?}");
    assert!(found.iter().zip(within).all(|(d, most)| d.abs() < most), "{found:?}");
    assert_voxels_kept(&mesh);
}
