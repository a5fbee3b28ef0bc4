//! Parameters of materials as people read them.

use crate::measure::summary::short;
use serde_json::Value;

/// Units by the ends of names in documents.
const UNITS: [(&str, &str); 7] = [
    ("_pa_s", "Pa s"),
    ("_pa", "Pa"),
    ("_kg_per_m3", "kg/m³"),
    ("_j_per_m3", "J/m³"),
    ("_j_per_m2", "J/m²"),
    ("_deg", "°"),
    ("_s", "s"),
];

/// The members of a document by their names, such as "c10 500 kPa"; without the range of validity.
pub(super) fn parameters(document: &Value) -> Vec<String> {
    let mut all = Vec::new();
    let members = document.as_object().into_iter().flatten();
    members.for_each(|(name, value)| take(name, value, &mut all));
    all
}

fn take(name: &str, value: &Value, all: &mut Vec<String>) {
    match value {
        Value::Object(_) if name != "valid_to" => all.extend(parameters(value)),
        Value::Array(items) if items.iter().all(Value::is_number) => all.extend(with_unit(name, items)),
        Value::Array(items) => items.iter().for_each(|item| take(name, item, all)),
        Value::Number(_) => all.extend(with_unit(name, std::slice::from_ref(value))),
        Value::String(form) if name == "volumetric" => all.push(volumetric(form)),
        _ => {}
    }
}

/// The energy U(J) of the change of volume, as in `docs/materials.md`.
fn volumetric(form: &str) -> String {
    match form {
        "ln_squared" => "U = K/2 (ln J)²".into(),
        "quadratic" => "U = K/2 (J − 1)²".into(),
        "quadratic_ln" => "U = K/4 (J² − 1 − 2 ln J)".into(),
        other => format!("volumetric energy {}", other.replace('_', " ")),
    }
}

/// The title of a law; of one without a title the name in documents, in words.
pub(super) fn title_of_law(law: &str) -> String {
    let title = match law {
        "neo_hookean" => "neo-Hookean",
        "coupled_neo_hookean" => "coupled neo-Hookean",
        "mooney_rivlin" => "Mooney–Rivlin",
        "yeoh" => "Yeoh",
        "ogden" => "Ogden",
        "demiray" => "Demiray",
        "veronda_westmann" => "Veronda–Westmann",
        "holzapfel_gasser_ogden" => "Holzapfel–Gasser–Ogden",
        "weiss_transversely_isotropic" => "Weiss, transversely isotropic",
        "balzani" => "Balzani",
        "peng_guo_moran" => "Peng–Guo–Moran",
        "fung_orthotropic" => "Fung, orthotropic",
        "blatz_ko" => "Blatz–Ko",
        other => return other.replace('_', " "),
    };
    title.into()
}

/// Name and numbers, in one unit; `None` without numbers.
fn with_unit(name: &str, numbers: &[Value]) -> Option<String> {
    let ending = UNITS.iter().find_map(|(end, unit)| Some((name.strip_suffix(end)?, *unit)));
    let (name, unit) = ending.unwrap_or((name, ""));
    let values: Vec<f64> = numbers.iter().filter_map(Value::as_f64).collect();
    let largest = values.iter().copied().map(f64::abs).reduce(f64::max)?;
    let (scale, prefix) = match (unit, largest) {
        ("Pa", size) if size >= 1e6 => (1e-6, "M"),
        ("Pa", size) if size >= 1e3 => (1e-3, "k"),
        ("s", size) if size < 1e-3 => (1e6, "µ"),
        ("s", size) if size < 1.0 => (1e3, "m"),
        _ => (1.0, ""),
    };
    let values: Vec<String> = values.into_iter().map(|value| short(scale * value)).collect();
    let words = format!("{} {} {prefix}{unit}", name.replace('_', " "), values.join(" / "));
    Some(words.trim_end().to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mechanics::with_laws;
    use serde_json::json;

    macro_rules! names_of_laws {
        ($($name:literal: $file:ident, $Law:ident, $Document:ident;)*) => { [$($name),*] };
    }

    #[test]
    fn every_law_has_a_title() {
        for name in with_laws!(names_of_laws) {
            let title = title_of_law(name);
            assert!(title != name.replace('_', " ") && !title.contains('_'), "{name}: {title}");
        }
        assert_eq!(title_of_law("of_another_version"), "of another version");
    }

    #[test]
    fn parameters_have_their_units() {
        let law = json!({
            "law": "holzapfel_gasser_ogden", "c_pa": 60000, "k2": 1, "fibres": {"angles_deg": [15, -15]},
            "terms": [{"mu_pa": 1200.5, "alpha": 3}], "bulk_modulus_pa": 5e7, "volumetric": "quadratic_ln",
            "relaxation_time_s": 2e-3, "valid_to": {"stretch": [0.5, 2.0]}
        });
        let mut said = parameters(&law);
        said.sort();
        let expected = [
            "U = K/4 (J² − 1 − 2 ln J)",
            "alpha 3",
            "angles 15 / -15 °",
            "bulk modulus 50 MPa",
            "c 60 kPa",
            "k2 1",
            "mu 1.2005 kPa",
            "relaxation time 2 ms",
        ];
        assert_eq!(said, expected);
    }
}
