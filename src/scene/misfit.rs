//! Violations of a single value, apart from its content: the JSON Schema keywords for types, numbers, lengths and
//! constants.

use serde_json::Value;

/// All violations of a value: code, message and limit of each.
pub(super) fn misfits(found: &Value, schema: &Value) -> Vec<(&'static str, String, String)> {
    let mut out = Vec::new();
    let mut add = |code, what: String, limit| out.push((code, format!("{found} {what}"), limit));
    let types = types(schema);
    if !types.is_empty() && !types.iter().any(|name| is_of_type(found, name)) {
        let several = if types.len() > 1 { "s" } else { "" };
        let what = format!("is not of type{several} \"{}\"", types.join("\", \""));
        add("wrong_type", what, types.join(" or "));
    }
    if let Some(number) = found.as_f64() {
        let limit = |keyword| schema.get(keyword).and_then(Value::as_f64);
        if let Some(least) = limit("minimum").filter(|least| number < *least) {
            add("out_of_range", format!("is less than the minimum of {least}"), format!(">= {least}"));
        }
        if let Some(most) = limit("maximum").filter(|most| number > *most) {
            add("out_of_range", format!("is greater than the maximum of {most}"), format!("<= {most}"));
        }
    }
    if let Some(items) = found.as_array() {
        let limit = |keyword| schema.get(keyword).and_then(Value::as_u64);
        let count = items.len() as u64;
        let plural = |count| if count == 1 { "item" } else { "items" };
        if let Some(least) = limit("minItems").filter(|least| count < *least) {
            let what = format!("has fewer than {least} {}", plural(least));
            add("too_few_items", what, format!("at least {least} items"));
        }
        if let Some(most) = limit("maxItems").filter(|most| count > *most) {
            let what = format!("has more than {most} {}", plural(most));
            add("too_many_items", what, format!("at most {most} items"));
        }
    }
    if let Some(word) = schema.get("const").filter(|word| *word != found) {
        out.push(("unknown_variant", format!("{word} was expected"), word.to_string()));
    }
    out
}

/// Names of the types that a schema admits, in alphabetical order.
fn types(schema: &Value) -> Vec<&str> {
    let mut names: Vec<&str> = match schema.get("type") {
        Some(Value::Array(names)) => names.iter().filter_map(Value::as_str).collect(),
        name => name.and_then(Value::as_str).into_iter().collect(),
    };
    names.sort_unstable();
    names
}

/// Whether a value is of a type of JSON Schema; 2.0 is an integer.
pub(super) fn is_of_type(value: &Value, name: &str) -> bool {
    match value {
        Value::Null => name == "null",
        Value::Bool(_) => name == "boolean",
        Value::Number(number) => {
            name == "number" || name == "integer" && number.as_f64().is_some_and(|x| x.fract() == 0.0)
        }
        Value::String(_) => name == "string",
        Value::Array(_) => name == "array",
        Value::Object(_) => name == "object",
    }
}
