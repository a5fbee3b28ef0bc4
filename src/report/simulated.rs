//! What was simulated: bodies with their sizes, masses and speeds, layers, and materials with their sources.

use super::text::escaped;
use crate::measure::summary::number;
use crate::scene::materials::library::find;
use serde_json::Value;
use std::f64::consts::PI;

/// A row of the table of what was simulated: name, description, source of the material; as HTML.
pub(super) type Simulated = [String; 3];

/// Each body of a scene, followed by its parts.
pub(super) fn simulated(scene: &Value) -> Vec<Simulated> {
    let items = |value: &Value| value.as_array().cloned().unwrap_or_default();
    let of_body = |body: &Value| {
        let parts: Vec<Simulated> = items(&body["parts"]).iter().map(|part| of_part(part, body)).collect();
        [vec![of_body_itself(body)], parts].concat()
    };
    items(&scene["bodies"]).iter().flat_map(of_body).collect()
}

/// Role, shape, mass and speed of a body.
fn of_body_itself(body: &Value) -> Simulated {
    let role = body["role"].as_str().unwrap_or("body").replace('_', " ");
    let speed = norm(&body["velocity_m_per_s"]);
    let mass = body["rigid"]["mass_kg"].as_f64().or_else(|| mass_of_ball(body));
    let words = [
        Some(format!("{role}, {}", shape(body))),
        layers(&body["mesh"]["generator"]),
        mass.map(|mass| format!("{} g", number(1e3 * mass))),
        (speed > 0.0).then(|| format!("{} m/s", number(speed))),
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
    let size = radius.map_or_else(String::new, |radius| format!(" of {} mm", number(2e3 * radius)));
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
        of_limb.chain(of_block).map(|(name, m)| format!("{name} {} mm", number(1e3 * m))).collect();
    (!all.is_empty()).then(|| all.join(", "))
}

/// Mass of a generated ball of one density [kg].
fn mass_of_ball(body: &Value) -> Option<f64> {
    let generator = &body["mesh"]["generator"];
    let outer = generator["outer_radius_m"].as_f64().or_else(|| generator["radius_m"].as_f64())?;
    let inner = generator["inner_radius_m"].as_f64().unwrap_or(0.0);
    let [part] = body["parts"].as_array()?.as_slice() else { return None };
    let density = part["density_kg_per_m3"].as_f64()?;
    let is_ball = generator["kind"].as_str()?.ends_with("ball");
    is_ball.then_some(4.0 / 3.0 * PI * (outer.powi(3) - inner.powi(3)) * density)
}

/// Material of a part and its source.
fn of_part(part: &Value, body: &Value) -> Simulated {
    let material = &part["material"];
    let set = material["library"].as_str().and_then(find);
    let law = set.map_or_else(
        || material["law"].as_str().or_else(|| material["library"].as_str()).unwrap_or("-").replace('_', " "),
        |set| format!("{} ({})", set.name, set.tissue),
    );
    let viscosity = part["shear_viscosity_pa_s"].as_f64().filter(|eta| *eta > 0.0);
    let viscosity = viscosity.map_or_else(String::new, |eta| format!(", {} Pa s", number(eta)));
    let source = set.and_then(|set| set.sources.first()).map(|source| source.citation.clone());
    let source = source.unwrap_or_else(|| "parameters of the scene, which names no source".into());
    let name = match text(&part["part"]) {
        "*" => text(&body["name"]),
        name => name,
    };
    [
        format!("<span class=\"part\">{}</span>", escaped(name)),
        escaped(&format!("{law}{viscosity}")),
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
        let scene = json!({"bodies": [
            {"name": "ball", "role": "projectile", "velocity_m_per_s": [0, 3, -4],
             "mesh": {"generator": {"kind": "hollow_ball", "outer_radius_m": 0.02, "inner_radius_m": 0.01}},
             "parts": [{"part": "ball", "density_kg_per_m3": 1000, "shear_viscosity_pa_s": 5, "material": rubber}]},
            {"name": "thigh", "role": "tissue",
             "mesh": {"generator": {"kind": "limb_segment", "skin_thickness_m": 0.002, "fat_thickness_m": 0.008}},
             "parts": [{"part": "*", "density_kg_per_m3": 1000, "material": {"library": "gelatine/bonavia_2025_10pct"}}]},
            {"name": "shot", "role": "projectile", "rigid": {"shape": {"kind": "ball", "radius_m": 0.003}, "mass_kg": 0.001}}
        ]});
        let rows = simulated(&scene);
        // 4/3 π (8 − 1) cm³ of 1 g/cm³.
        assert_eq!(rows[0][1], "projectile, hollow ball of 40.00 mm, 29.32 g, 5.000 m/s");
        assert_eq!(rows[1][1], "mooney rivlin, 5.000 Pa s");
        assert_eq!(rows[2][1], "tissue, limb segment, skin 2.000 mm, fat 8.000 mm");
        assert!(rows[3][0].contains("thigh") && rows[4][1] == "projectile, rigid ball of 6.000 mm, 1.000 g");
    }

    #[test]
    fn materials_of_the_library_have_their_sources() {
        for set in crate::scene::materials::library::sets() {
            let part = json!({"part": "muscle", "material": {"library": set.name}});
            let [_, material, source] = of_part(&part, &Value::Null);
            assert!(material.contains(&escaped(&set.tissue)));
            assert_eq!(source, escaped(&set.sources[0].citation));
        }
    }
}
