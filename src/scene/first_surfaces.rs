//! A first scene of closed surfaces in each other.

use super::first_scene::{BONES, LARGEST_M, MILLIMETRE, element_size, names_any, part, two_digits};
use crate::mesh::names::fault;
use crate::mesh::read::stl::ClosedSurface;
use serde_json::{Value, json};
use std::collections::BTreeSet;

/// A closed surface of a file.
#[derive(Clone, Debug, PartialEq)]
pub struct SurfaceFile {
    /// Reference to the file in scenes: its name in their folder, or the id of an upload.
    pub file: String,
    /// Name that the file has on the user's disk, of what is in it.
    pub name: String,
    /// The surface, in the unit of the file.
    pub surface: ClosedSurface,
}

impl SurfaceFile {
    /// Name of the part or hole that it becomes: the name of the file without its extension.
    pub fn part(&self) -> &str {
        let stem = self.name.rsplit_once('.').map_or(self.name.as_str(), |(stem, _)| stem);
        if fault(stem).is_none() { stem } else { "tissue" }
    }
}

/// Closed surfaces from the outside to the inside, in metres by one scale: programs write all files of a body in one unit.
pub struct Nest<'a> {
    /// Larger ones first, and taken to be around smaller ones.
    pub files: Vec<&'a SurfaceFile>,
    /// Metres in the unit of the files.
    pub scale: f64,
}

impl<'a> Nest<'a> {
    /// The nest of files in any order.
    pub fn of(files: &'a [SurfaceFile]) -> Self {
        let mut files: Vec<&SurfaceFile> = files.iter().collect();
        files.sort_by(|a, b| b.surface.volume().total_cmp(&a.surface.volume()));
        let extent = |file: &&SurfaceFile| {
            let [low, high] = file.surface.bounding_box();
            (high - low).max()
        };
        let largest = files.iter().map(extent).fold(0.0, f64::max);
        Self { files, scale: if largest > LARGEST_M { MILLIMETRE } else { 1.0 } }
    }

    /// Volume that a surface of it encloses [m³].
    pub fn volume_m3(&self, file: &SurfaceFile) -> f64 {
        file.surface.volume() * self.scale.powi(3)
    }

    /// The scene: each surface is a part of one body, or a hole that is held where it is named as a bone.
    pub fn first_scene(&self) -> Value {
        // A bone all around would leave no tissue.
        let is_hole = |i: usize, file: &SurfaceFile| i > 0 && names_any(&file.name, &BONES);
        let listed = self.files.iter().enumerate().map(|(i, file)| {
            let usage = if is_hole(i, file) { "hole" } else { "part" };
            let mut listed = json!({"name": file.file, usage: file.part()});
            if self.scale < 1.0 {
                listed["scale"] = json!(self.scale);
            }
            listed
        });
        let size_m = element_size(self.files.first().map_or(0.0, |file| self.volume_m3(file)), 0.0);
        let mut segmentation = json!({"surfaces": listed.collect::<Vec<_>>(), "size_m": size_m});
        let thinnest = self.thinnest_m();
        if size_m.as_f64().is_some_and(|size| thinnest < size) {
            segmentation["thin_size_m"] = two_digits(thinnest);
        }
        let named = |holes: bool| -> BTreeSet<&str> {
            let of_use = self.files.iter().enumerate().filter(|(i, file)| is_hole(*i, file) == holes);
            of_use.map(|(_, file)| file.part()).collect()
        };
        let parts: Vec<Value> = named(false).into_iter().map(part).collect();
        let mut body = json!({"name": "tissue", "role": "tissue", "mesh": {"segmentation": segmentation}, "parts": parts});
        let held: Vec<Value> = named(true).into_iter().map(|set| json!({"set": set})).collect();
        if !held.is_empty() {
            body["fixed"] = json!(held);
        }
        let names = self.files.iter().map(|file| file.name.as_str()).collect::<Vec<_>>().join(", ");
        json!({
            "name": self.files.first().map(|file| file.part()),
            "description": format!(
                "From the closed surfaces {names}: their order, scale, the size of the elements, materials by names and bones, which do \
                 not move, are guessed; other materials, a projectile and the end time are to be given."
            ),
            "end_time_s": null,
            "bodies": [body],
        })
    }

    /// Least thickness of a layer between a surface and the next, by volume and area [m]; infinite without one.
    fn thinnest_m(&self) -> f64 {
        let thickness = |pair: &[&SurfaceFile]| {
            let [outer, inner] = [pair[0], pair[1]];
            (self.volume_m3(outer) - self.volume_m3(inner)) / (outer.surface.area() * self.scale.powi(2))
        };
        let layers = self.files.windows(2).map(thickness);
        layers.filter(|thickness| *thickness > 0.0).fold(f64::INFINITY, f64::min)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mechanics::tensor::Vec3;

    #[test]
    fn surfaces_are_nested_by_their_volumes_and_have_one_unit() {
        let tetrahedron = |size: f64| ClosedSurface {
            points: [Vec3::zeros(), Vec3::x(), Vec3::y(), Vec3::z()].map(|x| x * size).to_vec(),
            triangles: vec![[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]],
        };
        // The bone alone might be in metres.
        let named = [(4.0, "Left femur.stl"), (60.0, "muscle.stl"), (80.0, "subcutaneous.stl")];
        let files = named.map(|(size, name)| SurfaceFile {
            file: format!("folder/{name}"),
            name: name.to_owned(),
            surface: tetrahedron(size),
        });
        let scene = Nest::of(&files).first_scene();
        let body = &scene["bodies"][0];
        let listed = json!([
            {"name": "folder/subcutaneous.stl", "part": "subcutaneous", "scale": 0.001},
            {"name": "folder/muscle.stl", "part": "muscle", "scale": 0.001},
            {"name": "folder/Left femur.stl", "hole": "Left femur", "scale": 0.001},
        ]);
        assert_eq!(body["mesh"]["segmentation"]["surfaces"], listed);
        assert_eq!(body["mesh"]["segmentation"]["size_m"], 2.4e-3);
        assert_eq!(body["fixed"], json!([{"set": "Left femur"}]));
        assert_eq!(body["parts"].as_array().map(Vec::len), Some(2));
    }
}
