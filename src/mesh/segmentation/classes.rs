//! The classes into which the labels of a volume are sorted.

use super::grid::OUTSIDE;
use super::labelling::BEYOND;
use super::options::{LabelUse, Options};
use super::volume::LabelVolume;
use crate::mesh::MeshError;

/// Classes of the labels.
pub struct Classes {
    /// Class of each index of the labels of the volume.
    pub of_label: Vec<u8>,
    /// Name of each class; empty for the outside.
    pub names: Vec<String>,
    /// Whether each class has elements.
    pub is_part: Vec<bool>,
}

/// An error of options that do not fit a volume.
pub fn refused(what: impl Into<String>, remedy: impl Into<String>) -> MeshError {
    MeshError::Unsupported { what: what.into(), remedy: remedy.into() }
}

impl Classes {
    /// Classes of the labels of a volume: those that share a name are one.
    ///
    /// # Errors
    /// `Unsupported` for labels that are not listed, for too many, and where none becomes a part.
    pub fn new(volume: &LabelVolume, options: &Options) -> Result<Self, MeshError> {
        let mut out = Self { of_label: Vec::new(), names: vec![String::new()], is_part: vec![false] };
        let mut unlisted = Vec::new();
        // Use of each label; 0 is outside, and without a list every other one is a part.
        for &label in &volume.values {
            let listed =
                options.labels.iter().find(|(known, _)| *known == label).map(|(_, usage)| usage.clone());
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
            // Labels with one name and use share a class.
            let known = (1..out.names.len()).find(|&i| out.names[i] == name && out.is_part[i] == is_part);
            let class = known.unwrap_or_else(|| {
                out.names.push(name);
                out.is_part.push(is_part);
                out.names.len() - 1
            });
            let class = u8::try_from(class).ok().filter(|class| *class < BEYOND - 1);
            out.of_label.push(
                class.ok_or_else(|| {
                    refused("more than 253 parts and holes", "give several labels one name")
                })?,
            );
        }
        // All labels that are not listed are named at once.
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
}
