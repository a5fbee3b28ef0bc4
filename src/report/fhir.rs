//! A run as a FHIR R4 Bundle: observations on a model, the program, and the scene.
//!
//! Codes are of a code system of our own: LOINC has none for a simulated impact. Units are UCUM.

use super::{RecordedRun, Shown, headline_impact, is_miss, recorded, title, values};
use crate::measure::QuantityOfInterest;
use crate::measure::summary::{number, rounded};
use serde_json::{Value, json};
use sha2::{Digest, Sha256};
use std::fmt::Write as _;

/// Code system of the observations.
pub const CODE_SYSTEM: &str = "urn:contuse:observation";
/// System of the digests of scenes.
const SCENE_SYSTEM: &str = "urn:contuse:scene-sha256";
const UCUM: &str = "http://unitsofmeasure.org";

/// Codes of the quantities of interest.
const CODES: [(&str, QuantityOfInterest); 8] = [
    ("peak-force", QuantityOfInterest::PeakForceN),
    ("impulse", QuantityOfInterest::ImpulseNS),
    ("contact-patch-area", QuantityOfInterest::LargestPatchAreaMm2),
    ("energy-given", QuantityOfInterest::EnergyGivenJ),
    ("absorbed-energy", QuantityOfInterest::AbsorbedEnergyJ),
    ("peak-principal-strain", QuantityOfInterest::PrincipalStrain),
    ("principal-strain-exceeded-in-volume", QuantityOfInterest::PrincipalStrainInVolume),
    ("skin-deflection", QuantityOfInterest::DeflectionMm),
];

/// A unit in the notation of UCUM.
fn ucum(unit: &'static str) -> &'static str {
    match unit {
        "N s" => "N.s",
        "mm²" => "mm2",
        "-" => "1",
        unit => unit,
    }
}

/// One observation: code, display text, UCUM unit, and the quantity of the summary.
struct Observed<'a> {
    code: String,
    text: String,
    unit: &'static str,
    quantity: &'a Value,
}

/// What all observations of a bundle have in common.
struct Common<'a> {
    summary: &'a Value,
    /// Reference to the program.
    device: String,
    /// Time of the computation or of the export, RFC 3339.
    recorded: &'a str,
    /// What is observed: the model, not a person.
    focus: Value,
}

/// The bundle of a run; `recorded` is the time of the job, or of the export, RFC 3339.
pub fn bundle(run: &RecordedRun, recorded: &str) -> Value {
    let hash = run.metadata.get("scene_hash").cloned().unwrap_or_default();
    let version = run.summary["engine_version"].as_str().unwrap_or("unknown").to_owned();
    let url = |name: &str| format!("urn:uuid:{}", name_based_uuid(&[&hash, &version, name]));
    let model = json!({
        "identifier": {"system": SCENE_SYSTEM, "value": if hash.is_empty() { "unknown" } else { &hash }},
        "display": run.summary["scene"].as_str().unwrap_or("a scene")
    });
    let common =
        Common { summary: &run.summary, device: url("device"), recorded, focus: json!([model.clone()]) };
    let mut observations: Vec<(String, Value)> = observed(&run.summary)
        .iter()
        .map(|observed| (url(&observed.code), observation(observed, &common)))
        .collect();
    let criteria = run.summary["injury_measures"].as_array().into_iter().flatten();
    observations.extend(criteria.map(|criterion| {
        let name = url(criterion["name"].as_str().unwrap_or_default());
        (name, injury_criterion(criterion, &common))
    }));
    observations.extend(plain_words(&common).map(|resource| (url("plain-words"), resource)));
    let device = common.device;
    // Provenance: the program and the scene.
    let targets: Vec<Value> = observations.iter().map(|(url, _)| json!({"reference": url})).collect();
    let mut entries = vec![json!({"fullUrl": device, "resource": device_resource(&version, run)})];
    entries.push(json!({"fullUrl": url("provenance"), "resource": {
        "resourceType": "Provenance",
        "target": if targets.is_empty() { vec![json!({"reference": device})] } else { targets },
        "recorded": recorded,
        "activity": {"text": "Simulation of a blunt impact on soft tissue"},
        "agent": [{"type": {"text": "Assembled by software"}, "who": {"reference": device}}],
        "entity": [{"role": "source", "what": model}]
    }}));
    entries.extend(
        observations.into_iter().map(|(url, resource)| json!({"fullUrl": url, "resource": resource})),
    );
    json!({
        "resourceType": "Bundle",
        "type": "collection",
        "timestamp": recorded,
        "identifier": {"system": "urn:contuse:bundle", "value": url("bundle")},
        "entry": entries
    })
}

fn device_resource(version: &str, run: &RecordedRun) -> Value {
    let commit = run.metadata.get("engine_commit").filter(|commit| *commit != "unknown");
    let value = commit.map_or_else(|| version.to_owned(), |commit| format!("{version} ({commit})"));
    json!({
        "resourceType": "Device",
        "status": "active",
        "deviceName": [{"name": "Contuse", "type": "user-friendly-name"}],
        "type": {"text": "Simulation software for research; no medical device"},
        "version": [{"value": value}],
        "note": [{"text": run.summary["notice"].as_str().unwrap_or_default()}]
    })
}

/// All observations of a summary, in a fixed order.
fn observed<'a>(summary: &'a Value) -> Vec<Observed<'a>> {
    // Withheld numbers are reported as absent, with the reason.
    let values = values(summary);
    let mut all = Vec::new();
    let mut add = |code: &str, text: &str, unit: &'static str, quantity: Option<&'a Value>| {
        if let Some(quantity) = quantity.filter(|quantity| quantity["value"].is_number()) {
            all.push(Observed { code: code.to_owned(), text: text.to_owned(), unit, quantity });
        }
    };
    // The quantities of interest; depths are listed with their thresholds below.
    for (code, quantity) in CODES {
        add(code, &title(values, quantity), ucum(quantity.unit()), recorded(values, quantity));
    }
    let (impact, tissue) = (headline_impact(values), &values["tissue"]);
    add("contact-duration", "Duration of contact", "s", impact.map(|impact| &impact["contact_duration_s"]));
    // Other peaks of the tissue.
    let density = &tissue["peak_strain_energy_density_j_per_m3"];
    add("peak-von-mises", "Peak von Mises stress", "Pa", tissue.get("peak_von_mises_pa"));
    add("peak-strain-energy-density", "Peak strain energy density", "J/m3", Some(density));
    if let Some(volume) = tissue.pointer("/exceeded_in_volume/volume_mm3").and_then(Value::as_f64) {
        let text = format!("Von Mises stress exceeded in {} mm³", number(volume));
        let stress = tissue.pointer("/exceeded_in_volume/von_mises_pa");
        add("von-mises-exceeded-in-volume", &text, "Pa", stress);
    }
    for of in tissue["percentiles"].as_array().into_iter().flatten() {
        let part = of["part"].as_str().unwrap_or_default();
        let text = format!("Principal Green-Lagrange strain of {part}, 95th percentile by volume (MPS95)");
        add(&format!("mps95-{part}"), &text, "1", of.get("mps95"));
    }
    for stress in tissue["significant_stress"].as_array().into_iter().flatten() {
        let threshold = stress["threshold_pa"].as_f64().unwrap_or_default();
        let ends: Vec<&str> =
            stress["reaches"].as_array().into_iter().flatten().filter_map(Value::as_str).collect();
        let at_least = if ends.is_empty() {
            String::new()
        } else {
            format!(" (at least: it reaches {})", ends.join(", "))
        };
        let above = format!("von Mises stress above {threshold} Pa{at_least}");
        add(
            &format!("depth-above-{threshold}-pa"),
            &format!("Depth of {above}"),
            "mm",
            stress.get("depth_mm"),
        );
        add(
            &format!("volume-above-{threshold}-pa"),
            &format!("Volume of {above}"),
            "mm3",
            stress.get("volume_mm3"),
        );
    }
    all
}

fn coded(code: &str, text: &str) -> Value {
    json!({"coding": [{"system": CODE_SYSTEM, "code": code, "display": text}], "text": text})
}

fn quantity(value: f64, unit: &str) -> Value {
    json!({"value": value, "unit": unit, "system": UCUM, "code": unit})
}

/// Whether the numbers of a run are its last word: it ended, the contact too, and nothing is withheld.
fn is_final(summary: &Value) -> bool {
    let values = values(summary);
    let ended = |of: &Value| of["contact_ended"] != false;
    summary["ending"] == "finished"
        && summary["withheld"].is_null()
        && headline_impact(values).is_none_or(ended)
        && ended(&values["tissue"])
}

/// An observation without value.
fn without_value(code: &Value, common: &Common) -> Value {
    json!({
        "resourceType": "Observation",
        "status": if is_final(common.summary) { "final" } else { "preliminary" },
        "category": [{"text": "Computer simulation"}],
        "code": code,
        "focus": common.focus,
        "effectiveDateTime": common.recorded,
        "device": {"reference": common.device},
        "method": {"text": "Finite elements with contact, computed on a model; not measured on a person"},
        "note": [{"text": common.summary["notice"].as_str().unwrap_or_default()}]
    })
}

fn observation(observed: &Observed, common: &Common) -> Value {
    let summary = common.summary;
    let mut resource = without_value(&coded(&observed.code, &observed.text), common);
    let withheld = summary.pointer("/withheld/reason").and_then(Value::as_str);
    let withheld = if is_miss(summary) { Some("Nothing touched: there was no impact") } else { withheld };
    match (withheld, Shown::of(observed.quantity)) {
        (None, Some(shown)) => set_value(&mut resource, shown, observed.unit),
        (reason, _) => {
            let text = reason.unwrap_or("There is no such number");
            resource["dataAbsentReason"] = absent("error", text);
        }
    }
    resource
}

/// Sets the value with its error; if the error exceeds the value or is unknown, the reason replaces the value, and a finer mesh
/// may have one.
fn set_value(resource: &mut Value, shown: Shown, unit: &str) {
    let error = coded("numerical-error", "Estimated numerical error, half width");
    // UCUM's unit of a pure number is not shown in text.
    let unit_text = if unit == "1" { String::new() } else { format!(" {unit}") };
    match shown.error {
        Some(_) if shown.is_resolved => resource["valueQuantity"] = quantity(shown.value, unit),
        Some(half_width) => {
            let text = format!(
                "Not resolved by the mesh: about {}{unit_text}, with a numerical error of ± {}{unit_text}",
                number(shown.value),
                rounded(half_width)
            );
            resource["dataAbsentReason"] = absent("error", &text);
        }
        None => {
            let text =
                format!("Its numerical error was not estimated: about {}{unit_text}", rounded(shown.value));
            resource["dataAbsentReason"] = absent("unknown", &text);
        }
    }
    resource["component"] = json!([match shown.error {
        Some(half_width) => json!({"code": error, "valueQuantity": quantity(half_width, unit)}),
        None =>
            json!({"code": error, "dataAbsentReason": absent("not-performed", "The error was not estimated")}),
    }]);
    if resource.get("valueQuantity").is_none() {
        resource["status"] = "preliminary".into();
    }
}

/// A published injury criterion: its statement, its reference value and its source.
fn injury_criterion(criterion: &Value, common: &Common) -> Value {
    let text = |name: &str| criterion[name].as_str().unwrap_or_default();
    let mut resource = without_value(&coded(&text("name").replace('_', "-"), text("title")), common);
    let unit = match text("unit") {
        "J/cm²" => "J/cm2",
        "-" => "1",
        unit => unit,
    };
    match Shown::of(criterion) {
        Some(shown) if criterion["applicable"] == true && criterion.get("error").is_some() => {
            set_value(&mut resource, shown, unit);
        }
        Some(shown) if criterion["applicable"] == true => {
            resource["valueQuantity"] = quantity(shown.value, unit);
        }
        _ => resource["dataAbsentReason"] = absent("not-applicable", text("statement")),
    }
    if let Some(notes) = resource["note"].as_array_mut() {
        notes.push(json!({"text": text("statement")}));
        notes.push(json!({"text": format!("Compared with: {}. {}", text("meaning"), text("source"))}));
    }
    resource
}

/// The summary in plain words.
fn plain_words(common: &Common) -> Option<Value> {
    let words: Vec<&str> =
        common.summary["plain_words"].as_array()?.iter().filter_map(Value::as_str).collect();
    let mut resource = without_value(&coded("plain-words", "The simulated impact in plain words"), common);
    resource["valueString"] = words.join(" ").into();
    (!words.is_empty()).then_some(resource)
}

fn absent(code: &str, text: &str) -> Value {
    let system = "http://terminology.hl7.org/CodeSystem/data-absent-reason";
    json!({"coding": [{"system": system, "code": code}], "text": text})
}

/// A name-based UUID (version 8, RFC 9562) from a digest: the same run has the same identifiers.
fn name_based_uuid(parts: &[&str]) -> String {
    let mut hash = Sha256::new();
    for part in parts {
        hash.update((part.len() as u64).to_le_bytes());
        hash.update(part);
    }
    let digest = hash.finalize();
    let mut bytes: [u8; 16] = std::array::from_fn(|i| digest[i]);
    bytes[6] = bytes[6] & 0x0f | 0x80;
    bytes[8] = bytes[8] & 0x3f | 0x80;
    let mut text = String::with_capacity(36);
    for (i, byte) in bytes.iter().enumerate() {
        if [4, 6, 8, 10].contains(&i) {
            text.push('-');
        }
        // Writing to a String cannot fail.
        let _ = write!(text, "{byte:02x}");
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    fn quantity_of(value: f64, error: f64, resolved: bool) -> Value {
        json!({"value": value, "error": {"total": error, "resolved": resolved}, "gate": "passed"})
    }

    fn entries(summary: Value) -> Vec<Value> {
        let run = RecordedRun { summary, ..RecordedRun::default() };
        let bundle = bundle(&run, "2026-01-01T00:00:00Z");
        bundle["entry"].as_array().unwrap().iter().map(|entry| entry["resource"].clone()).collect()
    }

    fn named<'a>(entries: &'a [Value], code: &str) -> &'a Value {
        entries.iter().find(|e| e.pointer("/code/coding/0/code") == Some(&json!(code))).unwrap()
    }

    #[test]
    fn what_is_not_resolved_is_no_plain_value() {
        let impact = json!({
            "peak_force_n": quantity_of(2729.5, 5270.0, false), "impulse_n_s": quantity_of(0.2, 0.01, true)
        });
        let criterion = |name: &str, applicable: bool| {
            json!({"name": name, "title": name, "value": 0.5, "unit": "m/s", "applicable": applicable,
                "statement": "says so", "meaning": "25 % risk", "source": "Somebody"})
        };
        let entries = entries(json!({
            "ending": "finished", "notice": "research", "plain_words": ["One.", "Two."],
            "results": {
                "impacts": [impact], "headline": {"impact": 0},
                "tissue": {"peak_principal_strain": quantity_of(0.2602, 0.16, false)}
            },
            "injury_measures": [criterion("viscous_criterion", false), criterion("blunt_criterion", true)]
        }));
        let force = named(&entries, "peak-force");
        assert!(force.get("valueQuantity").is_none(), "{force}");
        assert!(force["dataAbsentReason"]["text"].as_str().unwrap().contains("± 5300 N"), "{force}");
        assert_eq!(force["component"][0]["valueQuantity"]["value"], 5270.0);
        assert_eq!(
            named(&entries, "peak-principal-strain")["dataAbsentReason"]["text"],
            "Not resolved by the mesh: about 0.2602, with a numerical error of ± 0.16"
        );
        assert_eq!(named(&entries, "impulse")["valueQuantity"]["value"], 0.2);
        assert_eq!(named(&entries, "plain-words")["valueString"], "One. Two.");
        assert_eq!(named(&entries, "viscous-criterion")["dataAbsentReason"]["text"], "says so");
        assert_eq!(named(&entries, "blunt-criterion")["valueQuantity"]["value"], 0.5);
        // Final is what has a value, of a model at a time.
        let status = |code: &str| named(&entries, code)["status"].clone();
        assert_eq!([status("peak-force"), status("impulse")], [json!("preliminary"), json!("final")]);
        let impulse = named(&entries, "impulse");
        assert_eq!(impulse["effectiveDateTime"], "2026-01-01T00:00:00Z");
        assert_eq!(impulse["focus"][0]["identifier"]["system"], SCENE_SYSTEM);
        assert_eq!(impulse["category"][0]["text"], "Computer simulation");
    }

    #[test]
    fn nothing_is_final_before_contact_has_ended() {
        let status_of = |impact_ended: bool, tissue_ended: bool| {
            let impact = json!({"impulse_n_s": quantity_of(0.2, 0.01, true), "contact_ended": impact_ended});
            let entries = entries(json!({"ending": "finished", "results": {
                "impacts": [impact], "headline": {"impact": 0}, "tissue": {"contact_ended": tissue_ended}
            }}));
            named(&entries, "impulse")["status"].clone()
        };
        assert_eq!(status_of(true, true), "final");
        assert_eq!(status_of(false, true), "preliminary");
        assert_eq!(status_of(true, false), "preliminary");
    }
}
