//! The JSON Schema of the scene document, generated from its types.

use super::document::SceneDocument;
use schemars::generate::SchemaSettings;
use schemars::transform::{Transform, transform_subschemas};
use schemars::{JsonSchema, Schema};
use serde_json::Value;
use std::sync::LazyLock;

/// The JSON Schema (draft 2020-12) of a scene document.
pub fn scene_schema() -> Value {
    schema_of::<SceneDocument>("Contuse scene")
}

/// The schema of one type of the document, under a title.
pub fn schema_of<T: JsonSchema>(title: &str) -> Value {
    let settings = SchemaSettings::draft2020_12().with_transform(Polish);
    let mut schema = settings.into_generator().into_root_schema_for::<T>();
    schema.insert("title".into(), title.into());
    schema.to_value()
}

/// The schema of a scene document, made once.
pub(super) static SCENE: LazyLock<Value> = LazyLock::new(scene_schema);

/// Adds what the types imply but schemars omits: the range of a `u32`, and a title for each variant of an enum.
#[derive(Clone, Debug)]
struct Polish;

impl Transform for Polish {
    fn transform(&mut self, schema: &mut Schema) {
        if schema.get("format").and_then(Value::as_str) == Some("uint32") {
            schema.insert("maximum".into(), u32::MAX.into());
        }
        if let Some(title) = variant_name(schema) {
            schema.insert("title".into(), title.into());
        }
        transform_subschemas(self, schema);
    }
}

/// The keyword that selects a variant: the constant under `kind` or `law`.
fn variant_name(schema: &Schema) -> Option<String> {
    let properties = schema.get("properties")?;
    let tag = super::choice::TAGS.iter().find_map(|tag| properties.get(tag)?.get("const"))?;
    tag.as_str().map(str::to_owned)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::choice::{Choice, choices, variants};

    /// All schemas inside a schema, including itself.
    fn parts(schema: &Value) -> Vec<&Value> {
        let lists = ["oneOf", "anyOf"].iter().filter_map(|k| schema.get(k)?.as_array()).flatten();
        let maps = ["properties", "$defs"]
            .iter()
            .filter_map(|k| schema.get(k)?.as_object())
            .flat_map(|m| m.values());
        let inner = lists.chain(maps).chain(schema.get("items"));
        std::iter::once(schema).chain(inner.flat_map(parts)).collect()
    }

    #[test]
    fn schemas_have_no_keyword_that_the_check_does_not_know() {
        const ANNOTATIONS: [&str; 6] = ["$defs", "$schema", "default", "description", "format", "title"];
        const CHECKED: [&str; 13] = [
            "$ref",
            "additionalProperties",
            "anyOf",
            "const",
            "items",
            "maxItems",
            "maximum",
            "minItems",
            "minimum",
            "oneOf",
            "properties",
            "required",
            "type",
        ];
        let questions = schema_of::<crate::scene::material_question::MaterialQuestions>("questions");
        for part in parts(&SCENE).into_iter().chain(parts(&questions)) {
            for (keyword, value) in part.as_object().unwrap() {
                let is_known = ANNOTATIONS.contains(&&**keyword) || CHECKED.contains(&&**keyword);
                assert!(is_known, "{keyword:?} in {part:#}");
                assert!(keyword != "additionalProperties" || value == false, "{part:#}");
                assert!(keyword != "properties" || part.get("additionalProperties").is_some(), "{part:#}");
            }
        }
    }

    /// The check compares a document with one variant, the selected one.
    #[test]
    fn variants_of_the_schema_are_distinguished() {
        for part in parts(&SCENE) {
            let choices = variants(part).map_or_else(Vec::new, |v| choices(v, &SCENE));
            let words: Vec<String> = choices.iter().flat_map(Choice::words).collect();
            let distinct: std::collections::BTreeSet<&String> = words.iter().collect();
            assert!(distinct.len() == words.len(), "{words:?} in {part:#}");
        }
    }

    #[test]
    fn schema_names_its_variants() {
        let law = &SCENE["$defs"]["MaterialDocument"]["oneOf"][0];
        assert_eq!(law["title"], "mooney_rivlin");
        assert_eq!(SCENE["title"], "Contuse scene");
    }

    #[test]
    fn committed_schema_is_the_generated_one() {
        let path = concat!(env!("CARGO_MANIFEST_DIR"), "/api/scene.schema.json");
        let committed = std::fs::read_to_string(path).unwrap();
        let generated = format!("{:#}\n", scene_schema());
        assert!(committed == generated, "regenerate it: cargo run -- schema > api/scene.schema.json");
    }
}
