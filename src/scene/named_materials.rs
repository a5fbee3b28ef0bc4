//! Parts whose material is a name of the library: the set's numbers are put in their place, before the document is read.
//!
//! `{"library": "muscle/zhai_2019_ogden"}` becomes the law of that set, with the bulk modulus, the form of U(J) and the range that stand
//! beside the name; density, Prony series and shear viscosity become the part's unless it has its own, or null in their place.

use super::materials::library::{MaterialSet, find, unknown};
use super::materials::{MaterialDocument, VolumetricDocument};
use super::problem::{Pointer, Problem};
use super::structure::Checked;
use super::validity_document::ValidityDocument;
use schemars::{JsonSchema, Schema};
use serde::{Deserialize, Serialize};
use serde_json::{Map, Value, json};

/// Member of a part with its shear viscosity.
const VISCOSITY: &str = "shear_viscosity_pa_s";

/// A law with its parameters, or a set of the library.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(untagged)]
pub enum WrittenMaterial {
    /// A constitutive law with its parameters.
    Law(MaterialDocument),
    /// A set of the library by its name.
    Set(LibraryMaterial),
}

/// A set of the library, as `contuse materials` lists them. What stands beside the name replaces what the set has.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct LibraryMaterial {
    /// Its name, such as `muscle/zhai_2019_ogden`.
    pub library: String,
    /// Bulk modulus K [Pa].
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub bulk_modulus_pa: Option<f64>,
    /// Form of the volumetric energy U(J).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub volumetric: Option<VolumetricDocument>,
    /// How far the law may be believed; ranges that are not given stay those of the set.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub valid_to: Option<ValidityDocument>,
}

/// A member that may be missing, but is not null.
pub(super) fn not_null(schema: &mut Schema) {
    schema.insert("type".into(), "number".into());
}

/// Replaces the names of sets of the library in a scene document by the sets.
pub(super) fn resolve_scene(checked: &mut Checked) {
    let mut mended = std::mem::take(&mut checked.mended);
    let bodies = Pointer::root().key("bodies");
    for (i, body) in items(mended.get_mut("bodies")).enumerate() {
        for (k, part) in items(body.get_mut("parts")).enumerate() {
            if let Value::Object(part) = part {
                resolve_part(part, &bodies.index(i).key("parts").index(k), checked);
            }
        }
    }
    checked.mended = mended;
}

/// The same in a question about materials, or a list of them.
pub(super) fn resolve_questions(checked: &mut Checked) {
    let mut mended = std::mem::take(&mut checked.mended);
    if let Some(material) = mended.get_mut("material") {
        resolve_material(material, &Pointer::root().key("material"), checked);
    }
    for (i, question) in items(Some(&mut mended)).enumerate() {
        if let Some(material) = question.get_mut("material") {
            resolve_material(material, &Pointer::root().index(i).key("material"), checked);
        }
    }
    checked.mended = mended;
}

fn items(list: Option<&mut Value>) -> impl Iterator<Item = &mut Value> {
    list.and_then(Value::as_array_mut).into_iter().flatten()
}

fn resolve_part(part: &mut Map<String, Value>, here: &Pointer, checked: &mut Checked) {
    let material = part.get_mut("material").map(|m| resolve_material(m, &here.key("material"), checked));
    match material {
        Some(Found::Set(set)) => add_defaults(part, set),
        Some(Found::Nothing) => {
            part.entry("density_kg_per_m3")
                .or_insert_with(|| placeholder(&here.key("density_kg_per_m3"), checked));
        }
        Some(Found::Law) | None => require_density(part, here, checked),
    }
    // Null omits the viscosity of a set.
    if part.get(VISCOSITY).is_some_and(Value::is_null) {
        part.remove(VISCOSITY);
    }
}

/// What a material was.
enum Found {
    Law,
    Set(&'static MaterialSet),
    /// A name that there is none of.
    Nothing,
}

/// Replaces the name of a set by its law.
fn resolve_material(material: &mut Value, here: &Pointer, checked: &mut Checked) -> Found {
    let Some(beside) = material.as_object_mut() else { return Found::Law };
    let Some(Value::String(name)) = beside.remove("library") else { return Found::Law };
    let Some(set) = find(&name) else {
        if !checked.touches_placeholder(here.as_str()) {
            checked.problems.push(unknown(&name, &here.key("library")));
        }
        checked.placeholders.push(here.as_str().to_owned());
        *material = json!({"law": "neo_hookean", "c10_pa": 1.0, "bulk_modulus_pa": 1e3});
        return Found::Nothing;
    };
    let mut law = written(&set.material);
    if let Value::Object(law) = &mut law {
        replace_members(law, std::mem::take(beside));
    }
    *material = law;
    Found::Set(set)
}

/// Puts what stands beside the name in the place of the set's own. Of the range only what is given is replaced; null removes a
/// part of it.
fn replace_members(law: &mut Map<String, Value>, beside: Map<String, Value>) {
    for (name, value) in beside.into_iter().filter(|(_, value)| !value.is_null()) {
        if name == "valid_to"
            && let (Some(Value::Object(own)), Value::Object(given)) = (law.get_mut(&name), &value)
        {
            own.extend(given.clone());
            own.retain(|_, range| !range.is_null());
        } else {
            law.insert(name, value);
        }
    }
}

/// What the part does not say itself.
fn add_defaults(part: &mut Map<String, Value>, set: &MaterialSet) {
    part.entry("density_kg_per_m3").or_insert_with(|| set.density_kg_per_m3.into());
    if let Some(prony) = &set.prony_series {
        part.entry("prony_series").or_insert_with(|| written(prony));
    }
    if let Some(viscosity) = set.shear_viscosity_pa_s {
        part.entry(VISCOSITY).or_insert_with(|| viscosity.into());
    }
    part.insert("library".into(), set.name.clone().into());
}

/// A law that is written out brings no density.
fn require_density(part: &mut Map<String, Value>, here: &Pointer, checked: &mut Checked) {
    const NAME: &str = "density_kg_per_m3";
    if part.contains_key(NAME) {
        return;
    }
    // Whether the material is a set, which brings a density, is not known where it is both.
    let material = here.key("material");
    let is_both =
        |problem: &Problem| problem.code == "several_variants" && problem.pointer == material.as_str();
    let is_both = checked.problems.iter().any(is_both);
    let here = here.key(NAME);
    if !is_both && !checked.touches_placeholder(here.as_str()) {
        checked.problems.push(
            Problem::error("missing_field", &here, format!("{NAME:?} is missing"))
                .limit("present (number)")
                .remedy(format!(
                    "add {NAME:?}: Density at rest [kg/m³]. Materials of the library bring theirs"
                )),
        );
    }
    part.insert(NAME.into(), placeholder(&here, checked));
}

/// A number that the checks of meaning may look at.
fn placeholder(here: &Pointer, checked: &mut Checked) -> Value {
    checked.placeholders.push(here.as_str().to_owned());
    1.0.into()
}

/// A document that was read can be written.
fn written(document: &impl Serialize) -> Value {
    serde_json::to_value(document).unwrap_or_default()
}
