//! From a label volume to a mesh.

use super::elements::{Elements, Face, hanging};
use super::grid::{ClassGrid, OUTSIDE};
use super::islands::remove_islands;
use super::labelling::{self, BEYOND};
use super::octree::{Leaf, MOST_CELLS, MOST_HALVINGS, Octree};
use super::options::{LabelUse, Options};
use super::smoothing::{Smoothing, follow};
use super::surfaces::Surfaces;
use super::volume::{Frame, LabelVolume};
use super::volumes;
use crate::mechanics::tensor::Vec3;
use crate::mesh::quality::element_quality;
use crate::mesh::{CellKind, HangingNodes, Mesh, MeshError};
use std::collections::BTreeMap;

/// Smallest scaled Jacobian of an element [-].
const LEAST_SCALED_JACOBIAN: f64 = 0.2;

/// Limits of the scaled Jacobian in successive sweeps over the nodes [-]: the first moves leave room for later ones.
const SWEEPS: [f64; 20] = [
    0.5, 0.45, 0.4, 0.35, 0.3, 0.3, 0.25, 0.25, 0.22, 0.22, 0.21, 0.21, 0.205, 0.205, 0.205, 0.205, 0.205,
    0.205, 0.205, 0.205,
];

/// Largest number of sweeps, the last of which are with the last limit.
const MOST_SWEEPS: usize = 40;

/// Deviation of the volumes of all labels from those of their voxels at which the sweeps end [-].
const VOLUME_REACHED: f64 = 0.003;

/// Sweep from which volumes are corrected.
const FIRST_CORRECTION: usize = 5;

/// Edge of an element per distance from where it is to be small [-].
const GROWTH: f64 = 0.4;

/// A layer is thin where no ball of this diameter, in edges of the element, lies in it [-].
const THIN: f64 = 2.0;

/// Fraction of the volume of a leaf from which a label counts there [-].
const COUNTS: f64 = 0.02;

/// Largest thickness of a skin, relative to the one given, where it makes up for thinner places [-].
const THICKEST: f64 = 1.25;

/// Volume below which a group of voxels is noise, in voxels.
const NOISE_VOXELS: f64 = 30.0;

/// Largest deviation of the volume of a label from that of its voxels without a remark [-].
const VOLUME_TOLERANCE: f64 = 0.01;

/// Classes of the labels.
struct Classes {
    /// Class of each index of the labels of the volume.
    of_label: Vec<u8>,
    /// Name of each class; empty for the outside.
    names: Vec<String>,
    /// Whether each class has elements.
    is_part: Vec<bool>,
}

/// The mesh of a label volume, in the space of the scan. Parts are those of the options; node sets are `outer` (the surface
/// towards the outside), the names of holes, and `x_min` … `z_max`: where the scan, or the crop, cuts the body.
///
/// # Errors
/// `Unsupported` for options that do not fit the volume, for too many elements, and for a label without any.
pub fn mesh(volume: &LabelVolume, options: &Options) -> Result<Mesh, MeshError> {
    let frame = volume.frame()?;
    let classes = classes(volume, options)?;
    let (grid, mut notes) = prepared(volume, &frame, &classes, options)?;
    // The leaves are what is below the skin.
    let below = options.skin.as_ref().map(|skin| grid.eroded(skin.thickness_m));
    let below = below.as_ref().unwrap_or(&grid);
    let tree = octree(below, &frame, &classes, options)?;
    let mut leaves = labelling::classes(below, &tree);
    labelling::repair(&tree, &mut leaves, &classes.is_part);
    let mut elements = Elements::new(&tree, &leaves);
    within(elements.hexes.len() as u64, options)?;
    let aims = grid.volumes_m3();
    place_nodes(&mut elements, &grid, &classes, &aims, options);
    notes.extend(volume.notes.iter().cloned());
    notes.extend(volume_notes(&elements, &classes, &aims)?);
    let mut mesh = assembled(&elements, &classes, options);
    let corner = Vec3::from_fn(|k, _| grid.first[k] as f64 * grid.spacing[k]);
    mesh.nodes.iter_mut().for_each(|x| *x = frame.world(&(*x + corner)));
    let turned = mesh.hanging.each().map(|(node, on)| (node, on.to_vec())).collect();
    follow(&mut mesh.nodes, &turned);
    mesh.notes = notes;
    check_quality(&mesh)?;
    Ok(mesh)
}

/// Every move of a node keeps the limit of the scaled Jacobian; should an element be below it, there is no mesh.
fn check_quality(mesh: &Mesh) -> Result<(), MeshError> {
    let quality = |e: usize| element_quality(mesh.cells.kind(e), &mesh.cells.points(e, &mesh.nodes));
    let bad = (0..mesh.cells.len()).find(|e| !(quality(*e).min_scaled_jacobian() >= LEAST_SCALED_JACOBIAN));
    bad.map_or(Ok(()), |e| {
        let found = quality(e).min_scaled_jacobian();
        let what = format!("element {e} with a scaled Jacobian of {found:.3}, below {LEAST_SCALED_JACOBIAN}");
        Err(refused(what, "use elements of another size"))
    })
}

fn refused(what: impl Into<String>, remedy: impl Into<String>) -> MeshError {
    MeshError::Unsupported { what: what.into(), remedy: remedy.into() }
}

fn within(elements: u64, options: &Options) -> Result<(), MeshError> {
    if elements <= options.max_elements {
        return Ok(());
    }
    let what = format!("{elements} elements or more, of which at most {} are allowed", options.max_elements);
    Err(refused(what, "enlarge the sizes, or crop the scan around the impact"))
}

/// Classes of the labels of a volume: those that share a name are one.
fn classes(volume: &LabelVolume, options: &Options) -> Result<Classes, MeshError> {
    let mut out = Classes { of_label: Vec::new(), names: vec![String::new()], is_part: vec![false] };
    let mut unlisted = Vec::new();
    for &label in &volume.values {
        let listed = options.labels.iter().find(|(known, _)| *known == label).map(|(_, usage)| usage.clone());
        let usage = match listed {
            _ if label == 0 => LabelUse::Outside,
            Some(usage) => usage,
            None if options.labels.is_empty() => LabelUse::Part(format!("label_{label}")),
            None => {
                unlisted.push(label.to_string());
                continue;
            }
        };
        let (name, is_part) = match usage {
            LabelUse::Outside => {
                out.of_label.push(OUTSIDE);
                continue;
            }
            LabelUse::Part(name) => (name, true),
            LabelUse::Hole(name) => (name, false),
        };
        let known = (1..out.names.len()).find(|&i| out.names[i] == name && out.is_part[i] == is_part);
        let class = known.unwrap_or_else(|| {
            out.names.push(name);
            out.is_part.push(is_part);
            out.names.len() - 1
        });
        let class = u8::try_from(class).ok().filter(|class| *class < BEYOND);
        out.of_label.push(
            class.ok_or_else(|| refused("more than 254 parts and holes", "give several labels one name"))?,
        );
    }
    if !unlisted.is_empty() {
        let what = format!("the labels {} of the scan, which are not listed", unlisted.join(", "));
        return Err(refused(what, "list them as parts, as holes, or as outside"));
    }
    if !out.is_part.contains(&true) {
        return Err(refused(
            "a scan without a label that becomes a part",
            "list one of its labels as a part",
        ));
    }
    Ok(out)
}

/// The voxels that are meshed, without noise: those of the crop, and air around the body where it does not end with them.
fn prepared(
    volume: &LabelVolume,
    frame: &Frame,
    classes: &Classes,
    options: &Options,
) -> Result<(ClassGrid, Vec<String>), MeshError> {
    let mut grid = ClassGrid::new(volume, frame, cropped(frame, options)?, &classes.of_label);
    let voxel: f64 = grid.spacing.iter().product();
    let least = options.noise_m3.map_or(NOISE_VOXELS, |noise| noise / voxel).ceil();
    let changed = remove_islands(&mut grid, least as usize);
    let mut notes = Vec::new();
    if changed > 0 {
        notes.push(format!(
            "{changed} voxels in groups of less than {least} are noise: they have the label around them"
        ));
    }
    let Some([low, high]) = grid.occupied() else {
        return Err(refused("a part of the scan without any label", "crop it around the body"));
    };
    let bounds = [0, 1, 2].map(|k| {
        let margin = (options.size_m / grid.spacing[k]).ceil().max(2.0) as i64;
        let end = grid.dims[k];
        [
            if low[k] == 0 { 0 } else { low[k] as i64 - margin },
            if high[k] == end { end as i64 } else { high[k] as i64 + margin },
        ]
    });
    Ok((grid.resized([bounds.map(|b| b[0]), bounds.map(|b| b[1])]), notes))
}

/// Voxels of the crop, rounded outwards.
fn cropped(frame: &Frame, options: &Options) -> Result<[[usize; 3]; 2], MeshError> {
    let Some(crop) = &options.crop else { return Ok([[0; 3], frame.dims]) };
    let center = frame.local(&crop.center);
    let voxels = |k: usize, side: f64| (center[k] + 0.5 * side * crop.size_m[k]) / frame.spacing[k];
    let clamped = |n: f64, k: usize| n.clamp(0.0, frame.dims[k] as f64) as usize;
    // A side that lies between voxels up to rounding takes no more of them.
    let low = [0, 1, 2].map(|k| clamped((voxels(k, -1.0) + 1e-6).floor(), k));
    let high = [0, 1, 2].map(|k| clamped((voxels(k, 1.0) - 1e-6).ceil(), k));
    if (0..3).any(|k| low[k] >= high[k]) {
        return Err(refused("a crop outside of the scan", "move its centre into the scan"));
    }
    Ok([low, high])
}

/// The octree, fine where it is asked to be and at thin layers.
fn octree(
    grid: &ClassGrid,
    frame: &Frame,
    classes: &Classes,
    options: &Options,
) -> Result<Octree, MeshError> {
    let lengths = grid.lengths();
    let counts = lengths.map(|length| (length / options.size_m).round().max(1.0));
    let most = 8 * options.max_elements;
    if !(counts.product() <= most as f64) {
        within(counts.product().min(1e18) as u64, options)?;
    }
    let base = [0, 1, 2].map(|k| counts[k] as u32);
    let edge = (0..3).map(|k| lengths[k] / counts[k]).fold(0.0, f64::max);
    let corner = Vec3::from_fn(|k, _| grid.first[k] as f64 * grid.spacing[k]);
    let places: Vec<(Vec3, f64, f64)> = options
        .near
        .iter()
        .map(|near| (frame.local(&near.point) - corner, near.size_m, near.within_m))
        .collect();
    let finest = places.iter().fold(options.size_m, |least, (_, size, _)| least.min(*size));
    let thin = options.thin_size_m.unwrap_or(finest);
    let halvings = (edge / finest.min(thin) - 1e-6).log2().ceil().clamp(0.0, f64::from(MOST_HALVINGS));
    if base.iter().any(|n| u64::from(*n) << (halvings as u32) >= u64::from(MOST_CELLS)) {
        return Err(refused(
            "more than a million elements along an axis",
            "enlarge the sizes, or crop the scan",
        ));
    }
    let mut tree = Octree::new(base, &lengths, halvings as u8);
    let (mut fractions, mut found) = (Vec::new(), Vec::new());
    let mut asks = |tree: &Octree, leaf: Leaf| {
        let [low, high] = tree.bounds(leaf);
        labelling::fractions(grid, [low, high], &mut fractions);
        let is_solid = |class: usize| classes.is_part[class];
        if !(0..grid.count).any(|class| fractions[class] > 0.0 && is_solid(class)) {
            return false;
        }
        let edge = tree.edge(leaf.level);
        let is_coarse = |(point, size, within): &(Vec3, f64, f64)| {
            let distance = (point - point.sup(&low).inf(&high)).norm();
            edge > (size + GROWTH * (distance - within).max(0.0)).min(options.size_m) * (1.0 + 1e-6)
        };
        if edge > options.size_m * 1.5 || places.iter().any(is_coarse) {
            return true;
        }
        found.clear();
        found.extend((1..grid.count).filter(|class| fractions[*class] > COUNTS).map(|class| class as u8));
        edge > thin * (1.0 + 1e-6) && found.iter().any(|class| is_thin(grid, [low, high], *class, edge))
    };
    match tree.refine(most, &mut asks) {
        Ok(()) => Ok(tree),
        Err(leaves) => Err(within(leaves, options).err().unwrap_or(MeshError::Empty)),
    }
}

/// Whether no ball of a diameter of [`THIN`] edges around a point near a leaf is all of one class.
fn is_thin(grid: &ClassGrid, [low, high]: [Vec3; 2], class: u8, edge: f64) -> bool {
    const POINTS: usize = 7;
    let radius = 0.5 * THIN * edge;
    let lengths = grid.lengths();
    let is_solid = |centre: &Vec3| {
        let steps = [-1.0, 0.0, 1.0];
        let at = |x: f64, y: f64, z: f64| {
            let away = Vec3::new(x, y, z);
            let length = away.norm();
            let p = centre + if length > 0.0 { away * (radius / length) } else { away };
            // Beyond the box, the body goes on.
            grid.class_at(&p.sup(&Vec3::zeros()).inf(&lengths)) == class
        };
        grid.class_at(centre) == class
            && steps.iter().all(|x| steps.iter().all(|y| steps.iter().all(|z| at(*x, *y, *z))))
    };
    let (low, size) = (low.add_scalar(-radius), (high - low).add_scalar(2.0 * radius));
    let place = |n: usize| n as f64 / (POINTS - 1) as f64;
    !(0..POINTS).any(|i| {
        (0..POINTS).any(|j| {
            (0..POINTS)
                .any(|k| is_solid(&(low + size.component_mul(&Vec3::new(place(i), place(j), place(k))))))
        })
    })
}

/// Moves the nodes onto the surfaces of the labels, and these until the volumes are those of the voxels.
fn place_nodes(
    elements: &mut Elements,
    grid: &ClassGrid,
    classes: &Classes,
    aims: &[f64],
    options: &Options,
) {
    let mut surfaces = Surfaces::new(grid);
    let thickness = options.skin.as_ref().map(|skin| skin.thickness_m);
    if let Some(thickness) = thickness {
        elements.add_skin(grid.count as u8, &classes.is_part, thickness);
    }
    let mut smoothing = Smoothing::new(elements, thickness.unwrap_or(0.0));
    for i in 0..MOST_SWEEPS {
        let least = SWEEPS[i.min(SWEEPS.len() - 1)];
        smoothing.sweep(&mut surfaces, least, i % 2 == 1);
        if i < FIRST_CORRECTION {
            continue;
        }
        smoothing.keep_thickness();
        if let (Some(aim), Some([volume, area])) = (thickness, smoothing.elements.skin_volume(&mut surfaces))
        {
            // Where the layer stays thin, it is thicker elsewhere.
            let wanted = smoothing.thickness + aim - volume / area;
            smoothing.thickness = wanted.clamp(aim / THICKEST, THICKEST * aim);
        }
        let volumes = volumes::volumes_m3(smoothing.elements, grid.count);
        let missing: Vec<f64> = aims.iter().zip(&volumes).map(|(aim, volume)| aim - volume).collect();
        let deviation = |(missing, aim): (&f64, &f64)| if *aim > 0.0 { (missing / aim).abs() } else { 0.0 };
        let worst = missing.iter().zip(aims).skip(1).map(deviation).fold(0.0, f64::max);
        if i + 1 >= SWEEPS.len() && worst < VOLUME_REACHED {
            break;
        }
        let growth = volumes::growth(smoothing.elements, &missing);
        surfaces.growth.iter_mut().zip(growth).skip(1).for_each(|(sum, growth)| *sum += growth);
    }
}

/// What became of the volume of each label.
fn volume_notes(elements: &Elements, classes: &Classes, aims: &[f64]) -> Result<Vec<String>, MeshError> {
    let volumes = volumes::volumes_m3(elements, aims.len());
    let mut notes = Vec::new();
    for (class, name) in classes.names.iter().enumerate().skip(1) {
        let (aim, found) = (aims[class], volumes[class]);
        if found == 0.0 {
            if aim > 0.0 {
                return Err(refused(
                    format!(
                        "elements too large for {name:?}, which has {aim:.3e} m³ in the scan, and no element"
                    ),
                    "give it smaller elements by thin_size_m or near, list it as outside, or make it a skin",
                ));
            }
            continue;
        }
        let deviation = found / aim - 1.0;
        let remark =
            if deviation.abs() > VOLUME_TOLERANCE { ": smaller elements resolve it better" } else { "" };
        notes.push(format!("{name}: {found:.4e} m³, {:+.2} % of its voxels{remark}", 100.0 * deviation));
    }
    Ok(notes)
}

/// The mesh of the elements of parts and of the skin, along the axes of the scan.
fn assembled(elements: &Elements, classes: &Classes, options: &Options) -> Mesh {
    let mut mesh = Mesh { nodes: elements.nodes.clone(), ..Mesh::default() };
    let parts: Vec<usize> = (1..classes.names.len()).filter(|class| classes.is_part[*class]).collect();
    mesh.parts = parts.iter().map(|class| classes.names[*class].clone()).collect();
    let mut kept = Vec::new();
    for (hex, class) in elements.hexes.iter().zip(&elements.classes) {
        // The class of the skin is none of these.
        if let Some(part) = parts.iter().position(|part| *part == usize::from(*class)) {
            mesh.cells.push(CellKind::Hex8, hex);
            mesh.part_of.push(part as u32);
            kept.push(*hex);
        }
    }
    let mut hanging = hanging(&elements.corners, &kept);
    if let (Some(skin), Some(layer)) = (&elements.skin, &options.skin) {
        let known = mesh.parts.iter().position(|part| *part == layer.part);
        let part = known.unwrap_or_else(|| {
            mesh.parts.push(layer.part.clone());
            mesh.parts.len() - 1
        });
        elements.hexes[skin.first_element..].iter().for_each(|hex| mesh.cells.push(CellKind::Hex8, hex));
        mesh.part_of.resize(mesh.cells.len(), part as u32);
        let of_skin = elements.hanging.iter().filter(|(node, _)| **node as usize >= skin.first_node);
        hanging.extend(of_skin.map(|(node, on)| (*node, on.clone())));
    }
    mesh.hanging = HangingNodes::new(hanging);
    mesh.node_sets = sets(elements, classes);
    mesh.drop_unused_nodes();
    mesh
}

/// Sets of the nodes on the surfaces of the parts.
fn sets(elements: &Elements, classes: &Classes) -> BTreeMap<String, Vec<u32>> {
    const ENDS: [&str; 6] = ["x_min", "x_max", "y_min", "y_max", "z_min", "z_max"];
    let mut sets: BTreeMap<String, Vec<u32>> = BTreeMap::new();
    let is_part = |face: &&Face| classes.is_part[usize::from(elements.classes[face.element as usize])];
    for face in elements.faces.iter().filter(is_part) {
        let name = match face.behind {
            BEYOND => ENDS[usize::from(face.side)],
            OUTSIDE => "outer",
            class if classes.is_part[usize::from(class)] => continue,
            class => &classes.names[usize::from(class)],
        };
        sets.entry(name.to_owned()).or_default().extend(face.nodes);
    }
    // Holes whose elements are coarser, or finer, than those of the parts around them.
    for face in elements.faces.iter().filter(|face| !is_part(face)) {
        let has_part = face.behind != BEYOND && classes.is_part[usize::from(face.behind)];
        if has_part {
            let name = &classes.names[usize::from(elements.classes[face.element as usize])];
            sets.entry(name.clone()).or_default().extend(face.nodes);
        }
    }
    if let Some(skin) = &elements.skin {
        for end in ENDS {
            if let Some(set) = sets.get_mut(end) {
                let more: Vec<u32> = set.iter().filter_map(|node| skin.above.get(node)).copied().collect();
                set.extend(more);
            }
        }
        sets.insert("outer".into(), skin.above.values().copied().collect());
    }
    for set in sets.values_mut() {
        set.sort_unstable();
        set.dedup();
    }
    sets
}
