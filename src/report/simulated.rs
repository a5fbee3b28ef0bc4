//! What was simulated: bodies with their sizes, masses and speeds, layers, and materials with their parameters and sources.

use super::RecordedRun;
use super::parameters::{parameters, title_of_law};
use super::text::escaped;
use crate::measure::summary::{number, short};
use crate::scene::materials::library::find;
use serde_json::Value;
use std::f64::consts::PI;

/// A row of the table of what was simulated: name, description, source of the material; as HTML.
pub(super) type Simulated = [String; 3];

/// Each body of a run, followed by its parts.
pub(super) fn simulated(run: &RecordedRun) -> Vec<Simulated> {
    let named = named_materials(run);
    let of_body = |body: &Value| {
        // Parts that are sets of the library, with the numbers that they ran with.
        let resolved = |part: &Value| {
            let is_it = |of: &&Value| of["body"] == body["name"] && of["part"] == part["part"];
            named.iter().find(is_it).map_or_else(|| part.clone(), |of| of["resolved"].clone())
        };
        let parts: Vec<(&Value, Value)> = items(&body["parts"]).map(|part| (part, resolved(part))).collect();
        let itself = of_body_itself(body, &parts, run);
        let of_parts = parts.iter().map(|(part, resolved)| of_part(part, resolved, body));
        std::iter::once(itself).chain(of_parts).collect::<Vec<_>>()
    };
    items(&run.scene["bodies"]).flat_map(of_body).collect()
}

fn items(list: &Value) -> impl Iterator<Item = &Value> {
    list.as_array().into_iter().flatten()
}

/// What the plan says of parts that are sets of the library.
fn named_materials(run: &RecordedRun) -> Vec<Value> {
    let report = run.metadata.get("plan_report").and_then(|text| serde_json::from_str::<Value>(text).ok());
    report.map_or_else(Vec::new, |report| items(&report["named_materials"]).cloned().collect())
}

/// Role, shape, mass and speed of a body.
fn of_body_itself(body: &Value, parts: &[(&Value, Value)], run: &RecordedRun) -> Simulated {
    let role = body["role"].as_str().unwrap_or("body").replace('_', " ");
    let speed = norm(&body["velocity_m_per_s"]);
    let mass = body["rigid"]["mass_kg"].as_f64().or_else(|| mass_of_ball(body, parts));
    let mass = mass.or_else(|| mass_of_motion(body, run));
    let words = [
        Some(format!("{role}, {}", shape(body))),
        layers(&body["mesh"]["generator"]),
        mass.map(|mass| format!("{} g", number(1e3 * mass))),
        (speed > 0.0).then(|| format!("{} m/s", short(speed))),
    ];
    let words: Vec<String> = words.into_iter().flatten().collect();
    [format!("<b>{}</b>", escaped(text(&body["name"]))), escaped(&words.join(", ")), String::new()]
}

/// Shape of a body, with the diameter where it is a ball.
fn shape(body: &Value) -> String {
    let (generator, rigid) = (&body["mesh"]["generator"], &body["rigid"]["shape"]);
    let (kind, rigidity) = match (generator["kind"].as_str(), rigid["kind"].as_str()) {
        (Some(kind), _) => (kind, ""),
        (_, Some(kind)) => (kind, "rigid "),
        _ => return "a mesh from a file".into(),
    };
    let radius = [&generator["outer_radius_m"], &generator["radius_m"], &rigid["radius_m"]];
    let radius = radius.into_iter().find_map(Value::as_f64).filter(|_| kind.ends_with("ball"));
    let size = radius.map_or_else(String::new, |radius| format!(" of {} mm", short(2e3 * radius)));
    format!("{rigidity}{}{size}", kind.replace('_', " "))
}

/// Thicknesses of the layers of a generated body.
fn layers(generator: &Value) -> Option<String> {
    let of_limb = ["skin", "fat"].into_iter().filter_map(|layer| {
        generator[format!("{layer}_thickness_m")].as_f64().map(|thickness| (layer.to_owned(), thickness))
    });
    let of_block = generator["layers"].as_array().into_iter().flatten();
    let of_block =
        of_block.filter_map(|layer| Some((text(&layer["part"]).to_owned(), layer["thickness_m"].as_f64()?)));
    let all: Vec<String> =
        of_limb.chain(of_block).map(|(name, m)| format!("{name} {} mm", short(1e3 * m))).collect();
    (!all.is_empty()).then(|| all.join(", "))
}

/// Mass of a generated ball of one density [kg].
fn mass_of_ball(body: &Value, parts: &[(&Value, Value)]) -> Option<f64> {
    let generator = &body["mesh"]["generator"];
    let outer = generator["outer_radius_m"].as_f64().or_else(|| generator["radius_m"].as_f64())?;
    let inner = generator["inner_radius_m"].as_f64().unwrap_or(0.0);
    let [(_, part)] = parts else { return None };
    let density = part["density_kg_per_m3"].as_f64()?;
    let is_ball = generator["kind"].as_str()?.ends_with("ball");
    is_ball.then_some(4.0 / 3.0 * PI * (outer.powi(3) - inner.powi(3)) * density)
}

/// Mass of a body that begins with a velocity and nothing else, from its energy then, m = 2 E/v² [kg].
fn mass_of_motion(body: &Value, run: &RecordedRun) -> Option<f64> {
    let speed = norm(&body["velocity_m_per_s"]);
    let has_more = [&body["spin_rad_per_s"], &body["initial_deformation"], &run.scene["preload"]];
    if speed == 0.0 || has_more.iter().any(|of| !of.is_null()) {
        return None;
    }
    let (time, energy) = *run.bodies.get(text(&body["name"]))?.first()?;
    (time == 0.0).then_some(2.0 * energy / (speed * speed))
}

/// Material of a part, with its parameters and its source; `resolved` has the numbers of a set of the library.
fn of_part(part: &Value, resolved: &Value, body: &Value) -> Simulated {
    let material = &part["material"];
    let set = material["library"].as_str().and_then(find);
    let law = resolved["material"]["law"].as_str().or_else(|| material["library"].as_str());
    let law = title_of_law(law.unwrap_or("-"));
    let law = set.map_or_else(|| law.clone(), |set| format!("{} ({})", set.name, set.tissue));
    let mut constants = parameters(&resolved["material"]);
    let density = resolved["density_kg_per_m3"].as_f64().map(|density| format!("{} kg/m³", short(density)));
    let viscosity = resolved["shear_viscosity_pa_s"].as_f64().filter(|eta| *eta > 0.0);
    constants.extend(parameters(&resolved["prony_series"]));
    constants.extend(viscosity.map(|eta| format!("viscosity {} Pa s", short(eta))));
    constants.extend(density);
    let constants = if constants.is_empty() { String::new() } else { format!(": {}", constants.join(", ")) };
    let source = set.and_then(|set| set.sources.first()).map(|source| source.citation.clone());
    let source = source.unwrap_or_else(|| "parameters of the scene, which names no source".into());
    let name = match text(&part["part"]) {
        "*" => text(&body["name"]),
        name => name,
    };
    [
        format!("<span class=\"part\">{}</span>", escaped(name)),
        escaped(&format!("{law}{constants}")),
        escaped(&source),
    ]
}

fn text(value: &Value) -> &str {
    value.as_str().unwrap_or("-")
}

fn norm(vector: &Value) -> f64 {
    vector.as_array().into_iter().flatten().filter_map(Value::as_f64).map(|c| c * c).sum::<f64>().sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn bodies_have_sizes_masses_speeds_and_sources() {
        let rubber = json!({"law": "mooney_rivlin", "c10_pa": 5e5, "c01_pa": 1e5, "bulk_modulus_pa": 5e7});
        let gelatine = json!({"library": "gelatine/bonavia_2025_10pct"});
        let scene = json!({"bodies": [
            {"name": "ball", "role": "projectile", "velocity_m_per_s": [0, 3, -4],
             "mesh": {"generator": {"kind": "hollow_ball", "outer_radius_m": 0.02, "inner_radius_m": 0.01}},
             "parts": [{"part": "ball", "density_kg_per_m3": 1000, "shear_viscosity_pa_s": 5, "material": rubber}]},
            {"name": "thigh", "role": "tissue",
             "mesh": {"generator": {"kind": "limb_segment", "skin_thickness_m": 0.002, "fat_thickness_m": 0.008}},
             "parts": [{"part": "*", "material": gelatine}]},
            {"name": "shot", "role": "projectile", "rigid": {"shape": {"kind": "ball", "radius_m": 0.003}, "mass_kg": 0.001}},
            {"name": "plug", "role": "projectile", "velocity_m_per_s": [10, 0, 0], "mesh": {"file": "plug.msh"}}
        ]});
        let resolved = json!({"density_kg_per_m3": 1030, "material": {"law": "neo_hookean", "c10_pa": 2100}});
        let named = json!([{"body": "thigh", "part": "*", "resolved": resolved}]);
        let report = json!({"named_materials": named}).to_string();
        let mut run = RecordedRun { scene, ..RecordedRun::default() };
        run.metadata.insert("plan_report".into(), report);
        run.bodies.insert("plug".into(), vec![(0.0, 0.25), (1e-6, 0.2)]);
        let rows = simulated(&run);
        // 4/3 π (8 − 1) cm³ of 1 g/cm³.
        assert_eq!(rows[0][1], "projectile, hollow ball of 40 mm, 29.32 g, 5 m/s");
        let constants = rows[1][1].strip_prefix("Mooney–Rivlin: ").unwrap();
        for constant in
            ["c10 500 kPa", "c01 100 kPa", "bulk modulus 50 MPa", "viscosity 5 Pa s", "1000 kg/m³"]
        {
            assert!(constants.contains(constant), "{constants}");
        }
        assert_eq!(rows[2][1], "tissue, limb segment, skin 2 mm, fat 8 mm");
        assert!(
            rows[3][0].contains("thigh") && rows[3][1].ends_with(": c10 2.1 kPa, 1030 kg/m³"),
            "{rows:?}"
        );
        assert_eq!(rows[4][1], "projectile, rigid ball of 6 mm, 1.000 g");
        assert_eq!(rows[5][1], "projectile, a mesh from a file, 5.000 g, 10 m/s");
    }

    #[test]
    fn materials_of_the_library_have_their_sources() {
        for set in crate::scene::materials::library::sets() {
            let part = json!({"part": "muscle", "material": {"library": set.name}});
            let [_, material, source] = of_part(&part, &part, &Value::Null);
            assert!(material.contains(&escaped(&set.tissue)));
            assert_eq!(source, escaped(&set.sources[0].citation));
        }
    }
}
