//! The JSON Schema of the scene document, generated from its types.

use super::document::SceneDocument;
use jsonschema::Validator;
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

/// The schema with its compiled checker, made once.
pub(super) static SCENE: LazyLock<Compiled> = LazyLock::new(|| Compiled::new(scene_schema()));

/// A schema and its checker.
pub(super) struct Compiled {
    /// The schema.
    pub schema: Value,
    /// Its checker; an error text when the schema does not compile, which a test excludes.
    pub validator: Result<Validator, String>,
}

impl Compiled {
    /// Compiles a schema.
    pub fn new(schema: Value) -> Self {
        let validator = jsonschema::validator_for(&schema).map_err(|error| error.to_string());
        Self { schema, validator }
    }
}

/// Says what the types imply but schemars leaves out: the range of a `u32`, and a title for each variant of an enum.
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

/// The word by which a variant is chosen: the constant under `kind` or `law`.
fn variant_name(schema: &Schema) -> Option<String> {
    let properties = schema.get("properties")?;
    let tag = super::structure::TAGS.iter().find_map(|tag| properties.get(tag)?.get("const"))?;
    tag.as_str().map(str::to_owned)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn schema_compiles_and_names_its_variants() {
        assert!(SCENE.validator.is_ok());
        let law = &SCENE.schema["$defs"]["MaterialDocument"]["oneOf"][0];
        assert_eq!(law["title"], "mooney_rivlin");
        assert_eq!(SCENE.schema["title"], "Contuse scene");
    }

    #[test]
    fn committed_schema_is_the_generated_one() {
        let path = concat!(env!("CARGO_MANIFEST_DIR"), "/api/scene.schema.json");
        let committed = std::fs::read_to_string(path).unwrap();
        let generated = format!("{:#}\n", scene_schema());
        assert!(committed == generated, "write it anew: cargo run -- schema > api/scene.schema.json");
    }
}
