//! A first scene of a mesh: a body for each group of parts that share nodes, with guessed roles, and a placeholder for everything
//! that only the user knows. Validation of the scene names each of them.

use super::materials::library::{MaterialSet, sets};
use crate::mechanics::tensor::Vec3;
use crate::mesh::Mesh;
use crate::mesh::segmentation::{LabelCount, LabelVolume};
use serde_json::{Value, json};
use std::collections::BTreeSet;

/// In the place of a set of the library.
pub const TO_BE_CHOSEN: &str = "to be chosen";

/// Words in the names of parts that strike.
const STRIKING: [&str; 9] =
    ["ball", "projectile", "impactor", "bullet", "baton", "hammer", "striker", "sphere", "pellet"];

/// Words in the names of node sets that hold a body.
const HOLDING: [&str; 7] = ["fixed", "fix", "clamp", "support", "bottom", "base", "bone"];

/// Families of the library, and words in the names of their parts and labels.
const TISSUES: [(&str, &[&str]); 3] = [
    ("fat", &["fat", "adipos", "subcut"]),
    ("skin", &["skin", "dermis", "cutis"]),
    (
        "muscle",
        &["muscle", "muscul", "vastus", "rectus", "biceps", "triceps", "gastrocnem", "soleus", "glute"],
    ),
];

/// Words in the names of bones.
pub(super) const BONES: [&str; 9] =
    ["bone", "femur", "tibia", "fibula", "humerus", "skull", "sternum", "pelvis", "vertebra"];

/// Number of elements that the size of those of a scan is chosen for.
const ELEMENTS_OF_SCAN: f64 = 6000.0;

/// A millimetre [m].
pub(super) const MILLIMETRE: f64 = 0.001;

/// Extent of a mesh above which it is not in metres, as bodies of people are smaller.
pub(super) const LARGEST_M: f64 = 5.0;

/// Parts that are connected by nodes.
struct Group {
    /// Names of the parts.
    parts: Vec<String>,
    /// Volume, in the unit of the file.
    volume: f64,
    /// Node sets with nodes of these parts only.
    sets: Vec<String>,
}

/// A scene with this mesh, read from `file_name` in the folder of the scene.
pub fn first_scene(mesh: &Mesh, file_name: &str) -> Value {
    let groups = groups(mesh);
    let striking = striking(&groups);
    // The tissue is the largest of the others.
    let others = groups.iter().enumerate().filter(|(index, _)| Some(*index) != striking);
    let tissue = others.max_by(|(_, a), (_, b)| a.volume.total_cmp(&b.volume)).map(|(index, _)| index);
    let extent = mesh.bounding_box().map_or(0.0, |[low, high]: [Vec3; 2]| (high - low).max());
    let in_millimetres = extent > LARGEST_M;
    let bodies: Vec<Value> = groups
        .iter()
        .enumerate()
        .map(|(index, group)| {
            let role = match index {
                _ if Some(index) == striking => "projectile",
                _ if Some(index) == tissue => "tissue",
                _ => "other",
            };
            body(group, role, (file_name, groups.len() > 1), in_millimetres)
        })
        .collect();
    let guessed = if in_millimetres {
        "roles, fixed sets, materials by names and the scale are guessed"
    } else {
        "roles, fixed sets and materials by names are guessed"
    };
    json!({
        "name": file_name.rsplit_once('.').map_or(file_name, |(stem, _)| stem),
        "description": format!("From the mesh {file_name}: {guessed}; other materials, velocities and the end time are to be given."),
        "end_time_s": null,
        "bodies": bodies,
    })
}

/// A scene with the labels of a scan, read from `file_name` in the folder of the scene: every label is a part of one body, or a hole
/// that is held where it is named as a bone.
pub fn first_scene_of_scan(volume: &LabelVolume, file_name: &str) -> Value {
    let labels: Vec<LabelCount> = volume.counts().into_iter().filter(|count| count.label != 0).collect();
    let [holes, parts] = [true, false].map(|is_hole| {
        labels.iter().map(LabelCount::part).filter(move |name| names_any(name, &BONES) == is_hole)
    });
    let listed: Vec<Value> = labels
        .iter()
        .map(|count| {
            let name = count.part();
            let usage = if names_any(&name, &BONES) { "hole" } else { "part" };
            json!({"label": count.label, usage: name})
        })
        .collect();
    // Labels with one name form one part.
    let parts: Vec<Value> = parts.collect::<BTreeSet<_>>().iter().map(|name| part(name)).collect();
    let held: Vec<Value> = holes.collect::<BTreeSet<_>>().iter().map(|set| json!({"set": set})).collect();
    let voxel = volume.spacing_m().into_iter().fold(f64::INFINITY, f64::min);
    let volume_m3: f64 = labels.iter().map(|count| count.volume_m3).sum();
    let mut body = json!({
        "name": "tissue",
        "role": "tissue",
        "mesh": {"segmentation": {"name": file_name, "labels": listed, "size_m": element_size(volume_m3, voxel)}},
        "parts": parts,
    });
    if !held.is_empty() {
        body["fixed"] = json!(held);
    }
    json!({
        "name": file_name.split('.').next().unwrap_or(file_name),
        "description": format!(
            "From the scan {file_name}: the size of the elements, materials by names and bones, which do not move, are guessed; \
             other materials, a projectile and the end time are to be given."
        ),
        "end_time_s": null,
        "bodies": [body],
    })
}

/// Size of elements with which a volume has about [`ELEMENTS_OF_SCAN`], at least two voxels [m], to two digits.
pub(super) fn element_size(volume_m3: f64, voxel_m: f64) -> Value {
    two_digits((volume_m3 / ELEMENTS_OF_SCAN).cbrt().max(2.0 * voxel_m))
}

/// A size > 0 to two digits; `null` for any other.
pub(super) fn two_digits(size: f64) -> Value {
    format!("{size:.1e}").parse::<f64>().ok().filter(|size| *size > 0.0).map_or(Value::Null, Value::from)
}

/// A part with a material of the library, where its name says of which family.
pub(super) fn part(name: &str) -> Value {
    let family = TISSUES.iter().find(|(_, words)| names_any(name, words)).map(|(family, _)| *family);
    let is_of = |set: &&MaterialSet| set.name.split('/').next() == family;
    let material = sets().iter().find(is_of).map_or(TO_BE_CHOSEN, |set| set.name.as_str());
    json!({"part": name, "material": {"library": material}})
}

fn body(group: &Group, role: &str, (file_name, is_part): (&str, bool), in_millimetres: bool) -> Value {
    let parts: Vec<Value> = group.parts.iter().map(|name| part(name)).collect();
    let mut file = json!({"name": file_name});
    if is_part {
        file["parts"] = json!(group.parts);
    }
    let mut body = json!({
        "name": if group.parts.len() == 1 { group.parts[0].clone() } else { format!("{}_and_others", group.parts[0]) },
        "role": role,
        "mesh": {"file": file},
        "parts": parts,
    });
    if in_millimetres {
        body["placement"] = json!({"scale": MILLIMETRE});
    }
    if role == "projectile" {
        body["velocity_m_per_s"] = Value::Null;
    } else if let Some(set) = group.sets.iter().find(|set| names_any(set, &HOLDING)) {
        body["fixed"] = json!([{"set": set}]);
    }
    body
}

/// Whether a name has one of these words in it.
pub(super) fn names_any(name: &str, words: &[&str]) -> bool {
    let name = name.to_lowercase();
    words.iter().any(|word| name.contains(word))
}

/// The group that strikes: one with a name that says so, or the smaller of two.
fn striking(groups: &[Group]) -> Option<usize> {
    let named = groups.iter().position(|group| group.parts.iter().any(|part| names_any(part, &STRIKING)));
    match groups {
        [_] => None,
        [a, b] => named.or(Some(usize::from(b.volume < a.volume))),
        _ => named,
    }
}

/// The parts of the mesh in groups that share nodes, in the order of their first parts.
fn groups(mesh: &Mesh) -> Vec<Group> {
    // Each part refers to an earlier part of its group, or to itself.
    let mut leader: Vec<usize> = (0..mesh.parts.len()).collect();
    let mut part_of_node: Vec<Option<usize>> = vec![None; mesh.nodes.len()];
    let mut volumes = vec![0.0; mesh.parts.len()];
    for (element, cell) in mesh.cells.iter().enumerate() {
        let part = mesh.part_of[element] as usize;
        volumes[part] += mesh.element_volume_m3(element);
        for &node in cell.nodes {
            let other = *part_of_node[node as usize].get_or_insert(part);
            let (a, b) = (first(&leader, part), first(&leader, other));
            leader[a.max(b)] = a.min(b);
        }
    }
    let leaders = (0..mesh.parts.len()).filter(|&part| leader[part] == part);
    leaders
        .map(|head| {
            let members: Vec<usize> =
                (0..mesh.parts.len()).filter(|&part| first(&leader, part) == head).collect();
            let is_inside =
                |node: &u32| part_of_node[*node as usize].is_some_and(|part| first(&leader, part) == head);
            let sets = mesh.node_sets.iter().filter(|(_, set)| set.iter().all(is_inside));
            Group {
                parts: members.iter().map(|&part| mesh.parts[part].clone()).collect(),
                volume: members.iter().map(|&part| volumes[part]).sum(),
                sets: sets.map(|(name, _)| name.clone()).collect(),
            }
        })
        .collect()
}

/// The first part of the group of a part.
fn first(leader: &[usize], mut part: usize) -> usize {
    while leader[part] != part {
        part = leader[part];
    }
    part
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::generate::block::Block;

    /// Two blocks apart, the lower one of two parts, in one mesh.
    fn mesh() -> Mesh {
        let mut mesh =
            Block::uniform(Vec3::zeros(), Vec3::new(0.1, 0.1, 0.04), [1, 1, 2], "skin").generate().unwrap();
        let size = Vec3::new(0.02, 0.02, 0.01);
        let other = Block::uniform(Vec3::new(0.0, 0.0, 0.05), size, [1, 1, 1], "round").generate().unwrap();
        let nodes = mesh.nodes.len() as u32;
        mesh.nodes.extend(&other.nodes);
        mesh.cells.extend(other.cells.map(|node| node + nodes).iter());
        mesh.parts.extend(["fat".into(), "round".into()]);
        mesh.part_of = vec![0, 1, 2];
        let bottom = mesh.node_sets["z_min"].clone();
        mesh.node_sets = [("bottom".to_owned(), bottom)].into();
        mesh
    }

    #[test]
    fn connected_parts_are_a_body_and_the_smaller_one_strikes() {
        let scene = first_scene(&mesh(), "thigh.k");
        assert_eq!(scene["name"], "thigh");
        let [tissue, round] = [&scene["bodies"][0], &scene["bodies"][1]];
        assert_eq!([&tissue["role"], &round["role"]], ["tissue", "projectile"]);
        assert_eq!(tissue["mesh"]["file"], json!({"name": "thigh.k", "parts": ["skin", "fat"]}));
        assert_eq!(tissue["fixed"], json!([{"set": "bottom"}]));
        assert_eq!(round["parts"], json!([{"part": "round", "material": {"library": TO_BE_CHOSEN}}]));
        assert!(round["velocity_m_per_s"].is_null() && round.get("placement").is_none());
    }

    #[test]
    fn one_body_is_the_tissue_and_large_numbers_are_millimetres() {
        let mesh = mesh().select_parts(&["skin", "fat"]).unwrap();
        let large = mesh.transformed(&nalgebra::Rotation3::identity(), &Vec3::zeros(), 1000.0).unwrap();
        let scene = first_scene(&large, "thigh.k");
        assert_eq!(scene["bodies"].as_array().map(Vec::len), Some(1));
        assert_eq!(scene["bodies"][0]["role"], "tissue");
        assert_eq!(scene["bodies"][0]["mesh"]["file"], json!({"name": "thigh.k"}));
        assert_eq!(scene["bodies"][0]["placement"]["scale"], 0.001);
    }

    #[test]
    fn labels_of_a_scan_are_what_their_names_say() {
        let volume = LabelVolume {
            dims: [4, 1, 1],
            labels: vec![0, 1, 2, 3],
            values: vec![0, 3, 8, 9],
            names: [(8, "Femur left".to_owned()), (9, "Subcutaneous fat".to_owned())].into(),
            origin: Vec3::zeros(),
            steps: [Vec3::x(), Vec3::y(), Vec3::z()],
            notes: Vec::new(),
        };
        let scene = first_scene_of_scan(&volume, "thigh.nii.gz");
        assert_eq!(scene["name"], "thigh");
        let body = &scene["bodies"][0];
        let scan = &body["mesh"]["segmentation"];
        let labels = json!([
            {"label": 3, "part": "label_3"}, {"label": 8, "hole": "Femur left"}, {"label": 9, "part": "Subcutaneous fat"}
        ]);
        assert_eq!(scan["labels"], labels);
        assert_eq!(scan["size_m"], 2.0, "two voxels");
        assert_eq!(body["fixed"], json!([{"set": "Femur left"}]));
        let material = |part: usize| body["parts"][part]["material"]["library"].as_str().unwrap();
        assert!(material(0).starts_with("fat/") && material(1) == TO_BE_CHOSEN, "{body}");
    }

    #[test]
    fn what_is_missing_is_named_by_validation() {
        use crate::mesh::write::gmsh::{Encoding, Version, write_gmsh};
        use crate::scene::{Budget, MeshBytes, MeshSource, MeshSourceError, Problem, load};
        struct One(Vec<u8>);
        impl MeshSource for One {
            fn read(&self, name: &str, _: u64) -> Result<MeshBytes, MeshSourceError> {
                Ok(MeshBytes { file_name: name.to_owned(), bytes: self.0.clone() })
            }
        }
        let source = One(write_gmsh(&mesh(), Version::V4_1, Encoding::Ascii));
        let document = first_scene(&mesh(), "thigh.msh");
        let load_it =
            |document: &Value| load(document.to_string().as_bytes(), &source, &Budget::COMMAND_LINE);
        let mut pointers: Vec<String> = load_it(&document)
            .unwrap_err()
            .0
            .into_iter()
            .filter(Problem::is_error)
            .map(|p| p.pointer)
            .collect();
        pointers.sort();
        assert_eq!(
            pointers,
            ["/bodies/1/parts/0/material/library", "/bodies/1/velocity_m_per_s", "/end_time_s",]
        );
        // Filled in, the scene is valid.
        let mut full = document;
        full["end_time_s"] = json!(0.01);
        full["bodies"][1]["velocity_m_per_s"] = json!([0, 0, -3]);
        let rubber = json!({"law": "neo_hookean", "c10_pa": 2e4, "bulk_modulus_pa": 5e6});
        for body in full["bodies"].as_array_mut().unwrap() {
            for part in body["parts"].as_array_mut().unwrap() {
                part["material"] = rubber.clone();
                part["density_kg_per_m3"] = json!(1000);
            }
        }
        load_it(&full).unwrap();
    }
}
