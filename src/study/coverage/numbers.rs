//! The numbers of a summary that have an error bar, read from its JSON: none can be forgotten.

use serde_json::Value;

/// A number with its error bar.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct WithBar {
    /// Pointer to it in the results of the summary.
    pub pointer: String,
    pub value: f64,
    /// Half-width of the error bar.
    pub error_bar: f64,
    /// Whether the summary prints it as a plain number.
    pub resolved: bool,
}

impl WithBar {
    /// Name of the quantity: its pointer without indices and without the lists that all summaries have.
    pub fn quantity(&self) -> String {
        let is_part = |part: &&str| {
            !part.is_empty() && part.parse::<usize>().is_err() && !["impacts", "tissue"].contains(part)
        };
        self.pointer.split('/').filter(is_part).collect::<Vec<_>>().join("/")
    }

    /// The number at a pointer; `None` if there is none, or it has no error bar.
    pub fn at(results: &Value, pointer: &str) -> Option<Self> {
        let found = results.pointer(pointer)?;
        let of_bar = |name: &str| found.get("error")?.get(name);
        Some(Self {
            pointer: pointer.to_owned(),
            value: found.get("value")?.as_f64()?,
            error_bar: of_bar("total")?.as_f64()?,
            resolved: of_bar("resolved")?.as_bool()?,
        })
    }

    /// All numbers with an error bar, in the order of the document.
    pub fn all(results: &Value) -> Vec<Self> {
        let mut all = Vec::new();
        collect(results, results, "", &mut all);
        all
    }
}

/// Value of the number at a pointer, whether or not it has an error bar.
pub(super) fn value_at(results: &Value, pointer: &str) -> Option<f64> {
    results.pointer(pointer)?.get("value")?.as_f64()
}

fn collect(results: &Value, here: &Value, pointer: &str, all: &mut Vec<WithBar>) {
    if let Some(number) = WithBar::at(results, pointer) {
        all.push(number);
        return;
    }
    match here {
        Value::Object(members) => {
            members.iter().for_each(|(key, value)| collect(results, value, &format!("{pointer}/{key}"), all));
        }
        Value::Array(items) => {
            items
                .iter()
                .enumerate()
                .for_each(|(i, item)| collect(results, item, &format!("{pointer}/{i}"), all));
        }
        _ => {}
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)] // tests may panic
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn numbers_with_error_bars_are_found_wherever_they_are() {
        let results = json!({
            "impacts": [{"pair": "a–b", "impulse_n_s": {"value": 2.0, "error": {"total": 0.1, "resolved": true}},
                         "peak_step_force_n": {"value": 3.0, "error": "not estimated"}}],
            "tissue": {"split": {"strain_j": {"value": 1.0, "error": {"total": 2.0, "resolved": false}}}}
        });
        let found = WithBar::all(&results);
        let names: Vec<String> = found.iter().map(WithBar::quantity).collect();
        assert_eq!(names, ["impulse_n_s", "split/strain_j"]);
        assert!(found[0].resolved && !found[1].resolved && (found[0].error_bar - 0.1).abs() < 1e-15);
        assert_eq!(value_at(&results, "/impacts/0/peak_step_force_n"), Some(3.0));
        assert_eq!(WithBar::at(&results, "/impacts/0/peak_step_force_n"), None);
    }
}
