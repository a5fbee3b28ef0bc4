//! The spread of a parameter between the sources of a set of the library, in the unit of a change.

use super::document::Change;
use super::named::part_of;
use crate::scene::document::{PartDocument, SceneDocument};
use crate::scene::materials::library::{
    MaterialSet, SHEAR_MODULUS, SUDDEN_SHEAR_MODULUS, SourceSpread, find, unknown,
};
use crate::scene::problem::{Pointer, Problem};
use crate::scene::validate::Findings;

impl Change {
    /// Smallest and largest value between the sources of a set; `None` where the set is unknown or states no spread of what this
    /// changes.
    pub(super) fn spread_in(&self, set: &str) -> Option<[f64; 2]> {
        let set = find(set)?;
        let spread = self.stated(set)?;
        // A factor is relative to the set's own modulus, and scales those of the relaxation alike.
        let [slow, sudden] = set.slow_and_sudden_moduli_pa();
        let unit = match self {
            Self::StiffnessFactor { .. } if spread.parameter == SUDDEN_SHEAR_MODULUS => sudden,
            Self::StiffnessFactor { .. } => slow,
            _ => 1.0,
        };
        Some([spread.least / unit, spread.most / unit])
    }

    /// The spread that a set states of what this changes.
    fn stated<'a>(&self, set: &'a MaterialSet) -> Option<&'a SourceSpread> {
        let parameters = match self {
            Self::StiffnessFactor { .. } => vec![SHEAR_MODULUS, SUDDEN_SHEAR_MODULUS],
            Self::Number { pointer } => vec![place_in_part(pointer)?.1],
            _ => return None,
        };
        set.spread.iter().find(|spread| parameters.contains(&spread.parameter.as_str()))
    }

    /// The part of a scene whose material this changes.
    fn part_in<'a>(&self, scene: &'a SceneDocument) -> Option<&'a PartDocument> {
        let [body, part] = match self {
            Self::StiffnessFactor { body, part } => part_of(scene, body, part).ok()?,
            Self::Number { pointer } => place_in_part(pointer)?.0,
            _ => return None,
        };
        scene.bodies.get(body)?.parts.get(part)
    }
}

/// Indices of body and part, and the place in the part, of a pointer such as `/bodies/1/parts/0/shear_viscosity_pa_s`.
fn place_in_part(pointer: &str) -> Option<([usize; 2], &str)> {
    let (body, rest) = pointer.strip_prefix("/bodies/")?.split_once("/parts/")?;
    let (part, place) = rest.split_once('/')?;
    Some(([body.parse().ok()?, part.parse().ok()?], place))
}

/// Checks a distribution between the sources of a set; `here` is its place in the question.
pub(super) fn check(set: &str, change: &Change, scene: &SceneDocument, here: &Pointer, out: &mut Findings) {
    let here = here.key("set");
    let Some(known) = find(set) else { return out.push(unknown(set, &here)) };
    out.require(change.stated(known).is_some(), || {
        let stated: Vec<&str> = known.spread.iter().map(|spread| spread.parameter.as_str()).collect();
        let stated = if stated.is_empty() { "nothing".to_owned() } else { stated.join(", ") };
        Problem::error("no_spread", &here, format!("{set} states no spread of what this parameter changes"))
            .value(set)
            .limit(format!("a parameter whose spread the set states: {stated}"))
            .remedy(
                "stiffness_factor varies the shear modulus; the others are numbers at /bodies/…/parts/…/NAME. \
                 Otherwise give low and high",
            )
    });
    // The sources speak of that tissue, and a factor is relative to the modulus of that set.
    let Some(part) = change.part_in(scene) else { return };
    out.require(part.library.as_deref() == Some(set), || {
        let own = part.library.as_deref().unwrap_or_else(|| part.material.law_name());
        Problem::error("other_set", &here, format!("the part {:?} is of another material", part.part))
            .value(set)
            .limit(format!("the set of the part, which has {own}"))
            .remedy("name the set that the part has, or give low and high")
    });
}
