//! From a label volume to a mesh.

use super::classes::{Classes, refused};
use super::elements::{Elements, Face, hanging};
use super::grid::{ClassGrid, OUTSIDE};
use super::islands::{NOISE_VOXELS, remove_islands};
use super::labelling::{self, BEYOND};
use super::options::Options;
use super::sizes::{octree, within};
use super::smoothing::{LEAST_SCALED_JACOBIAN, Smoothing, follow};
use super::surfaces::Surfaces;
use super::volume::{Frame, LabelVolume};
use super::volumes;
use crate::mechanics::tensor::Vec3;
use crate::mesh::quality::element_quality;
use crate::mesh::{CellKind, HangingNodes, Mesh, MeshError};
use std::collections::BTreeMap;

/// Limits of the scaled Jacobian in successive passes over the nodes [-]: the first moves leave room for later ones.
const PASSES: [f64; 20] = [
    0.5, 0.45, 0.4, 0.35, 0.3, 0.3, 0.25, 0.25, 0.22, 0.22, 0.21, 0.21, 0.205, 0.205, 0.205, 0.205, 0.205,
    0.205, 0.205, 0.205,
];

/// Largest number of passes, the last of which are with the last limit.
const MOST_PASSES: usize = 80;

/// Deviation of the volumes of all labels from their aims at which the passes end [-].
const VOLUME_REACHED: f64 = 0.003;

/// Number of passes after which they end at [`VOLUME_TOLERANCE`].
const PASSES_TO_REACH: usize = 40;

/// Pass from which volumes are corrected.
const FIRST_CORRECTION: usize = 5;

/// Largest thickness of a skin, relative to the one given, where it makes up for thinner places [-].
const THICKEST: f64 = 1.25;

/// Roughness of the labels ([`ClassGrid::roughness`]) above which they are noise [-]: that of a ball of five voxels is 0.26.
const NOISE: f64 = 0.3;

/// Largest number of elements of noise, which its surfaces make several times slower than those of regions.
const MOST_OF_NOISE: u64 = 20_000;

/// Largest deviation of the volume of a label from its aim without a remark [-].
const VOLUME_TOLERANCE: f64 = 0.01;
/// Largest deviation of the volume of a label from its aim [-].
const MOST_DEVIATION: f64 = 0.1;
/// How the note on the volume of a label ends where it deviates by more.
pub const POORLY_RESOLVED: &str = ": smaller elements resolve it better";
/// Largest fraction of the voxels that are noise without a remark [-].
const MOST_NOISE: f64 = 0.05;
/// Remark of a note on more noise.
pub const RELABELLED: &str = " % of the voxels";

/// The mesh of a label volume, in the space of the scan. Parts are those of the options; node sets are `outer` (the surface
/// towards the outside), the names of holes, and `x_min` … `z_max`: where the scan, or the crop, cuts the body.
///
/// # Errors
/// `Unsupported` for options that do not fit the volume, for too many elements, and for a label without its volume.
pub fn mesh(volume: &LabelVolume, options: &Options) -> Result<Mesh, MeshError> {
    let frame = volume.frame()?;
    let classes = Classes::new(volume, options)?;
    let (grid, mut notes) = prepared(volume, &frame, &classes, options)?;
    let limits = Limits::of(&grid, &classes, options);
    let options = &limits.options;
    // The leaves are what is below the skin.
    let below = options.skin.as_ref().map(|skin| grid.eroded(skin.thickness_m));
    let below = below.as_ref().unwrap_or(&grid);
    let (tree, are_idle) = octree(below, &frame, &classes, options).map_err(|error| limits.reason(error))?;
    let mut leaves = labelling::classes(below, &tree);
    // Before what takes long.
    let is_part = |class: &&u8| classes.is_part.get(usize::from(**class)).is_some_and(|is_part| *is_part);
    let count = leaves.iter().filter(is_part).count();
    within(count as u64, options).map_err(|error| limits.reason(error))?;
    labelling::repair(&tree, &mut leaves, &classes.is_part);
    let mut elements = Elements::new(&tree, &leaves);
    within(elements.hexes.len() as u64, options).map_err(|error| limits.reason(error))?;
    let aims = aims(&grid, volume, &classes, options);
    place_nodes(&mut elements, &grid, &classes, &aims, options);
    notes.extend((0..).zip(are_idle).filter(|(_, is_idle)| *is_idle).map(|(place, _)| idle_place(place)));
    notes.extend(volume.notes.iter().cloned());
    let source = if options.is_of_surfaces() { "its surface" } else { "its voxels" };
    notes.extend(volume_notes(&elements, &classes, &aims, source)?);
    let mut mesh = assembled(&elements, &classes, options);
    let corner = Vec3::from_fn(|k, _| grid.first[k] as f64 * grid.spacing[k]);
    mesh.nodes.iter_mut().for_each(|x| *x = frame.world(&(*x + corner)));
    let turned = mesh.hanging.each().map(|(node, on)| (node, on.to_vec())).collect();
    follow(&mut mesh.nodes, &turned);
    mesh.notes = notes;
    check_quality(&mesh)?;
    Ok(mesh)
}

/// Note on a place of [`Options::near`], by its number from 0, around which no element is smaller than it would be without.
pub fn idle_place(place: usize) -> String {
    format!("point {} of near makes no element smaller", place + 1)
}

/// The options with fewer elements where the labels are noise.
struct Limits {
    options: Options,
    /// Why there are too many elements, where the roughness of the labels limits them.
    rough: Option<MeshError>,
}

impl Limits {
    fn of(grid: &ClassGrid, classes: &Classes, options: &Options) -> Self {
        let noise =
            Some(grid.roughness()).filter(|found| *found > NOISE && options.max_elements > MOST_OF_NOISE);
        let max_elements = if noise.is_some() { MOST_OF_NOISE } else { options.max_elements };
        let rough = noise.map(|noise| {
            if options.is_of_surfaces() {
                return too_coarse(grid, classes);
            }
            let what = format!(
                "labels that change at {:.0} % of the faces between voxels, which is noise above {:.0} %, with more than {MOST_OF_NOISE} elements",
                100.0 * noise,
                100.0 * NOISE
            );
            refused(what, "smooth the labels (a median filter)")
        });
        Self { options: Options { max_elements, ..options.clone() }, rough }
    }

    /// Why there are too many elements.
    fn reason(&self, error: MeshError) -> MeshError {
        self.rough.clone().unwrap_or(error)
    }
}

/// Surfaces of which the voxels keep nothing, or little but noise: those of the parts with the fewest voxels for their faces.
fn too_coarse(grid: &ClassGrid, classes: &Classes) -> MeshError {
    let roughness = grid.roughness_of_classes();
    let parts = || (0..classes.names.len()).filter(|class| classes.is_part[*class]);
    let most = parts().map(|class| roughness[class]).fold(0.0, f64::max);
    let named = parts().filter(|class| roughness[*class] >= most);
    let names: Vec<String> = named.map(|class| format!("{:?}", classes.names[class])).collect();
    let what = format!(
        "voxels of {:.3} mm, which are too coarse for the surface of {}",
        1e3 * grid.coarsest(),
        names.join(", ")
    );
    refused(what, "give a smaller \"voxel_size_m\": a third of the thickness or less")
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
        let fraction = changed as f64 / grid.classes.len() as f64;
        let remark = if fraction > MOST_NOISE {
            format!(", {:.0}{RELABELLED}", 100.0 * fraction)
        } else {
            String::new()
        };
        notes.push(format!(
            "{changed} voxels in groups of less than {least} are noise: they have the label around them{remark}"
        ));
    }
    let Some([low, high]) = grid.occupied() else {
        if options.is_of_surfaces() {
            return Err(too_coarse(&grid, classes));
        }
        return Err(refused("a part of the scan without any label", "crop it around the body"));
    };
    let bounds = [0, 1, 2].map(|k| {
        // As much as an element, and no more than the memory of the scan allows.
        let most = 2.0 + 0.5 * (high[k] - low[k]) as f64;
        let margin = (options.size_m / grid.spacing[k]).ceil().clamp(2.0, most) as i64;
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

/// Moves the nodes onto the surfaces of the labels, and these until the volumes are the aims.
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
    for i in 0..MOST_PASSES {
        let least = PASSES[i.min(PASSES.len() - 1)];
        smoothing.pass(&mut surfaces, least, i % 2 == 1);
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
        let enough = if i + 1 < PASSES_TO_REACH { VOLUME_REACHED } else { VOLUME_TOLERANCE };
        if i + 1 >= PASSES.len() && worst < enough {
            break;
        }
        let growth = volumes::growth(smoothing.elements, &missing);
        surfaces.growth.iter_mut().zip(growth).skip(1).for_each(|(sum, growth)| *sum += growth);
    }
}

/// Volume that each class gets [m³].
fn aims(grid: &ClassGrid, volume: &LabelVolume, classes: &Classes, options: &Options) -> Vec<f64> {
    if options.volumes_m3.is_empty() {
        return grid.volumes_m3();
    }
    let mut aims = vec![0.0; grid.count];
    for (label, class) in volume.values.iter().zip(&classes.of_label) {
        let of_label = options.volumes_m3.iter().find(|(known, _)| known == label);
        aims[usize::from(*class)] += of_label.map_or(0.0, |(_, volume)| *volume);
    }
    aims
}

/// What became of the volume of each label, against that of a `source`.
fn volume_notes(
    elements: &Elements,
    classes: &Classes,
    aims: &[f64],
    source: &str,
) -> Result<Vec<String>, MeshError> {
    let volumes = volumes::volumes_m3(elements, aims.len());
    let mut notes = Vec::new();
    for (class, name) in classes.names.iter().enumerate().skip(1) {
        let (aim, found) = (aims[class], volumes[class]);
        if aim == 0.0 && found == 0.0 {
            continue;
        }
        let deviation = found / aim - 1.0;
        if !(deviation.abs() <= MOST_DEVIATION) {
            let what = format!(
                "elements too large for {name:?}, which has {aim:.3e} m³ by {source} and would have {found:.3e} m³"
            );
            return Err(refused(
                what,
                "give it smaller elements by size_m, thin_size_m or near, list it as outside, or make it a skin",
            ));
        }
        let remark = if deviation.abs() > VOLUME_TOLERANCE { POORLY_RESOLVED } else { "" };
        notes.push(format!("{name}: {found:.4e} m³, {:+.2} % of {source}{remark}", 100.0 * deviation));
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
