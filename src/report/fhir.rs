//! A run as a FHIR R4 Bundle: observations on a model, the program, and the scene.
//!
//! Codes are of a code system of our own: LOINC has none for a simulated impact. Units are UCUM.

use super::RecordedRun;
use super::text::capitalised;
use crate::measure::summary::{
    ErrorEstimate, InjuryMeasure, Interval, Quantity, Row, interval, listing, rounded, within,
};
use serde_json::{Value, json};
use sha2::{Digest, Sha256};
use std::fmt::Write as _;

/// Code system of the observations.
pub const CODE_SYSTEM: &str = "urn:contuse:observation";
/// System of the digests of scenes.
const SCENE_SYSTEM: &str = "urn:contuse:scene-sha256";
const UCUM: &str = "http://unitsofmeasure.org";
/// Extension of an element without a value.
const ABSENT: &str = "http://hl7.org/fhir/StructureDefinition/data-absent-reason";

/// A unit in the notation of UCUM.
fn ucum(unit: &str) -> String {
    match unit {
        "N s" => "N.s".into(),
        "-" => "1".into(),
        unit => unit.replace('²', "2").replace('³', "3"),
    }
}

/// What all observations of a bundle have in common.
struct Common<'a> {
    run: &'a RecordedRun,
    /// Reference to the program.
    device: String,
    /// Time of the computation if it is known, RFC 3339.
    computed: Option<&'a str>,
    /// What is observed: the model, not a person.
    focus: Value,
}

/// The bundle of a run, assembled at the time `recorded` of a computation that ended at `computed`, if that is known
/// (RFC 3339): a recording has simulated times only.
pub fn bundle(run: &RecordedRun, recorded: &str, computed: Option<&str>) -> Value {
    let hash = run.metadata.get("scene_hash").cloned().unwrap_or_default();
    let version = run.summary["engine_version"].as_str().unwrap_or("unknown").to_owned();
    let url = |name: &str| format!("urn:uuid:{}", name_based_uuid(&[&hash, &version, name]));
    let model = json!({
        "identifier": {"system": SCENE_SYSTEM, "value": if hash.is_empty() { "unknown" } else { &hash }},
        "display": run.summary["scene"].as_str().unwrap_or("a scene")
    });
    let common = Common { run, device: url("device"), computed, focus: json!([model.clone()]) };
    // Withheld numbers are reported as absent, with the reason.
    let listing = run.values.as_ref().map(listing).unwrap_or_default();
    let rows = listing.iter().flat_map(|group| &group.rows);
    let mut observations: Vec<(String, Value)> =
        rows.filter_map(|row| Some((url(row.code.as_deref()?), observation(row, &common)?))).collect();
    let criteria = run.criteria.iter();
    observations.extend(criteria.map(|of| (url(&of.name), injury_criterion(of, &common))));
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

fn coded(code: &str, text: &str) -> Value {
    json!({"coding": [{"system": CODE_SYSTEM, "code": code, "display": text}], "text": text})
}

/// A number as it is written elsewhere.
fn quantity(written: &str, unit: &str) -> Value {
    json!({"value": written.parse::<f64>().ok(), "unit": unit, "system": UCUM, "code": unit})
}

/// Whether the numbers of a run are its last word: it ended, the contact too, and nothing is withheld.
fn is_final(run: &RecordedRun) -> bool {
    run.summary["ending"] == "finished"
        && run.results().is_some_and(|results| {
            results.headline_impact().is_none_or(|impact| impact.contact_ended)
                && results.tissue.as_ref().is_none_or(|tissue| tissue.contact_ended)
        })
}

/// An observation without value.
fn without_value(code: &Value, common: &Common) -> Value {
    let mut resource = json!({
        "resourceType": "Observation",
        "status": if is_final(common.run) { "final" } else { "preliminary" },
        "category": [{"text": "Computer simulation"}],
        "code": code,
        "focus": common.focus,
        "device": {"reference": common.device},
        "method": {"text": "Finite elements with contact, computed on a model; not measured on a person"},
        "note": [{"text": common.run.summary["notice"].as_str().unwrap_or_default()}]
    });
    match common.computed {
        Some(computed) => resource["effectiveDateTime"] = computed.into(),
        None => {
            resource["_effectiveDateTime"] = json!({"extension": [{"url": ABSENT, "valueCode": "unknown"}]});
        }
    }
    resource
}

/// The observation of a row of the listing; `None` if the row is words.
fn observation(row: &Row, common: &Common) -> Option<Value> {
    let (quantity, unit) = row.quantity()?;
    let note = if row.note.is_empty() { String::new() } else { format!(" ({})", row.note) };
    let text = format!("{}{note}", capitalised(&row.title));
    let mut resource = without_value(&coded(row.code.as_deref()?, &text), common);
    let miss = common.run.is_miss().then_some("Nothing touched: there was no impact");
    if let Some(reason) = miss.or(common.run.withheld()) {
        resource["dataAbsentReason"] = absent("error", reason);
    } else {
        set_value(&mut resource, (quantity.value, &quantity.error), &ucum(unit));
        add_interval(&mut resource, quantity, &ucum(unit));
    }
    if let Some(value) = resource.get_mut("valueQuantity").filter(|_| quantity.is_lower_bound) {
        value["comparator"] = ">=".into();
    }
    Some(resource)
}

/// Sets the value with its error; if the error exceeds the value or is unknown, the reason replaces the value, and a finer mesh
/// may have one.
fn set_value(resource: &mut Value, (value, error): (f64, &ErrorEstimate), unit: &str) {
    let code = coded("numerical-error", "Estimated numerical error, half width");
    // UCUM's unit of a pure number is not shown in text.
    let unit_text = if unit == "1" { String::new() } else { format!(" {unit}") };
    let half_width = error.half_width();
    let digits = within(value, half_width);
    let error_digits = half_width.map(rounded);
    match &error_digits {
        Some(_) if error.is_resolved() => resource["valueQuantity"] = quantity(&digits, unit),
        Some(error) => {
            let text = format!(
                "Not resolved by the mesh: about {digits}{unit_text}, with a numerical error of ± {error}{unit_text}"
            );
            resource["dataAbsentReason"] = absent("error", &text);
        }
        None => {
            let text = format!("Its numerical error was not estimated: about {digits}{unit_text}");
            resource["dataAbsentReason"] = absent("unknown", &text);
        }
    }
    resource["component"] = json!([match error_digits {
        Some(error) => json!({"code": code, "valueQuantity": quantity(&error, unit)}),
        None =>
            json!({"code": code, "dataAbsentReason": absent("not-performed", "The error was not estimated")}),
    }]);
    if resource.get("valueQuantity").is_none() {
        resource["status"] = "preliminary".into();
    }
}

/// Adds the interval of a number where it ends at what is possible, and not where the numerical error does, or has no upper end.
fn add_interval(resource: &mut Value, of: &Quantity, unit: &str) {
    let is_cut = of.interval().is_some_and(|interval| !matches!(interval, Interval::Around(_)));
    let (true, Some(words)) = (is_cut, interval(of, 1.0)) else { return };
    let [low, high] = of.ends();
    let end = |value: f64| quantity(&within(value, None), unit);
    let (text, range) = if of.is_lower_bound {
        ("The lower bound with its error".into(), json!({"low": end(low)}))
    } else {
        let text = format!("The number with its error, within what is possible: {words}");
        (text, json!({"low": end(low), "high": end(high)}))
    };
    let code = coded("interval", &text);
    if let Some(components) = resource["component"].as_array_mut() {
        components.push(json!({"code": code, "valueRange": range}));
    }
}

/// A published injury criterion: its statement, its reference value and its source.
fn injury_criterion(criterion: &InjuryMeasure, common: &Common) -> Value {
    let mut resource = without_value(&coded(&criterion.name.replace('_', "-"), &criterion.title), common);
    let unit = ucum(&criterion.unit);
    match (criterion.value.filter(|_| criterion.applicable), &criterion.error) {
        (Some(value), Some(error)) => set_value(&mut resource, (value, error), &unit),
        (Some(value), None) => resource["valueQuantity"] = quantity(&within(value, None), &unit),
        (None, _) => resource["dataAbsentReason"] = absent("not-applicable", &criterion.statement),
    }
    if let Some(notes) = resource["note"].as_array_mut() {
        notes.push(json!({"text": criterion.statement}));
        notes.push(json!({"text": format!("Compared with: {}. {}", criterion.meaning, criterion.source)}));
    }
    resource
}

/// The summary in plain words.
fn plain_words(common: &Common) -> Option<Value> {
    let words: Vec<&str> =
        common.run.summary["plain_words"].as_array()?.iter().filter_map(Value::as_str).collect();
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
    use super::super::tests::{example, quantity_of};
    use super::*;

    fn entries(run: &mut RecordedRun) -> Vec<Value> {
        run.take_numbers().unwrap();
        let bundle = bundle(run, "2026-01-02T00:00:00Z", Some("2026-01-01T00:00:00Z"));
        bundle["entry"].as_array().unwrap().iter().map(|entry| entry["resource"].clone()).collect()
    }

    fn named<'a>(entries: &'a [Value], code: &str) -> &'a Value {
        entries.iter().find(|e| e.pointer("/code/coding/0/code") == Some(&json!(code))).unwrap()
    }

    #[test]
    fn what_is_not_resolved_is_no_plain_value() {
        let mut run = example();
        let results = &mut run.summary["results"];
        let impact = &mut results["impacts"][0];
        impact["peak_force_n"] = quantity_of(2729.5, 5270.0, false);
        impact["impulse_n_s"] = quantity_of(0.200_49, 0.0111, true);
        impact["contact_ended"] = true.into();
        results["tissue"]["contact_ended"] = true.into();
        let strain = &mut results["tissue"]["peak_principal_strain"];
        (strain["value"], strain["error"]) =
            (0.2602.into(), quantity_of(0.2602, 0.16, false)["error"].take());
        let stress = &mut results["tissue"]["significant_stress"][0];
        stress["depth_mm"] = quantity_of(60.0, 3.0, true);
        stress["depth_mm"]["is_lower_bound"] = true.into();
        stress["depth_reaches"] = json!(["the held nodes"]);
        let depth = format!("depth-above-{}-pa", stress["threshold_pa"].as_f64().unwrap());
        run.summary["plain_words"] = json!(["One.", "Two."]);
        let criterion = |name: &str, applicable: bool| {
            json!({"name": name, "title": name, "value": 0.5, "unit": "m/s", "applicable": applicable,
                "reference": [1.0, 1.0], "statement": "says so", "meaning": "25 % risk", "source": "Somebody"})
        };
        run.summary["injury_measures"] =
            json!([criterion("viscous_criterion", false), criterion("blunt_criterion", true)]);
        let entries = entries(&mut run);
        let force = named(&entries, "peak-force");
        assert!(force.get("valueQuantity").is_none(), "{force}");
        assert!(force["dataAbsentReason"]["text"].as_str().unwrap().contains("± 5300 N"), "{force}");
        assert_eq!(force["component"][0]["valueQuantity"]["value"], 5300.0);
        assert_eq!(
            named(&entries, "peak-principal-strain")["dataAbsentReason"]["text"],
            "Not resolved by the mesh: about 0.26, with a numerical error of ± 0.16"
        );
        assert_eq!(named(&entries, "impulse")["valueQuantity"]["value"], 0.2);
        // What the model cuts off is a lower bound.
        assert_eq!(named(&entries, &depth)["valueQuantity"]["comparator"], ">=");
        let range = &named(&entries, &depth)["component"][1]["valueRange"];
        assert!(range["low"]["value"] == 57.0 && range.get("high").is_none(), "{range}");
        assert!(named(&entries, "impulse")["valueQuantity"].get("comparator").is_none());
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
    fn the_time_of_a_bundle_is_not_that_of_its_observations() {
        let bundle = bundle(&example(), "2026-01-02T00:00:00Z", None);
        assert_eq!(bundle["timestamp"], "2026-01-02T00:00:00Z");
        let entries = bundle["entry"].as_array().unwrap();
        let observations = entries.iter().filter(|e| e["resource"]["resourceType"] == "Observation");
        assert!(observations.clone().count() > 5);
        for resource in observations.map(|entry| &entry["resource"]) {
            assert!(resource.get("effectiveDateTime").is_none());
            assert_eq!(resource["_effectiveDateTime"]["extension"][0]["valueCode"], "unknown");
        }
    }

    #[test]
    fn nothing_is_final_before_contact_has_ended() {
        let status_of = |impact_ended: bool, tissue_ended: bool| {
            let mut run = example();
            let results = &mut run.summary["results"];
            results["impacts"][0]["contact_ended"] = impact_ended.into();
            results["tissue"]["contact_ended"] = tissue_ended.into();
            let entries = entries(&mut run);
            named(&entries, "impulse")["status"].clone()
        };
        assert_eq!(status_of(true, true), "final");
        assert_eq!(status_of(false, true), "preliminary");
        assert_eq!(status_of(true, false), "preliminary");
    }
}
