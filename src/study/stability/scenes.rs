//! The scenes of the stability matrix: one small impact, made stiff or extreme.
//!
//! A rubber ball on a block of soft tissue, a few hundred elements. Each case changes one parameter, or two that
//! reinforce each other, with the impact speed such that the ball would penetrate the block by a third of its radius.

use serde_json::{Value, json};

/// Radius of the ball [m]; all other lengths are in proportion.
const RADIUS: f64 = 8e-3;
/// Shear modulus of the tissue [Pa].
const SHEAR: f64 = 1e4;
/// Nominal penetration into the block, in radii of the ball.
const DEPTH: f64 = 0.3;

/// One case of the matrix.
#[derive(Clone, Debug)]
pub struct Case {
    /// Name of the varied parameter.
    pub axis: String,
    /// Value of the parameter for display.
    pub label: String,
    /// Whether the scene is physically possible: such a cell should finish.
    pub is_physical: bool,
    /// Whether the run ends soon after contact, rather than at its end time.
    pub ends_with_contact: bool,
    /// Scene document of the case.
    pub document: Value,
}

/// Parameters of one case.
#[derive(Clone, Copy, Debug)]
struct Knobs {
    /// Ratio K/G of the tissue [-].
    k_over_g: f64,
    /// Exponent k2 of the fibres; `None` without fibres.
    fibre_k2: Option<f64>,
    speed: f64,
    /// Density of the ball over that of the tissue [-].
    density_ratio: f64,
    friction: f64,
    /// Ratio of height to width of the block's elements, or its inverse [-].
    aspect: f64,
    /// Scale of all lengths relative to the base case [-].
    size: f64,
}

/// Density of the heaviest ball [kg/m³].
const HEAVIEST: f64 = 1e5;

const BASE: Knobs = Knobs {
    k_over_g: 100.0,
    fibre_k2: None,
    speed: 10.0,
    density_ratio: 1.0,
    friction: 0.3,
    aspect: 1.0,
    size: 1.0,
};

/// All cases; the short list has only the ends of each axis.
pub fn cases(short: bool) -> Vec<Case> {
    let mut cases = Vec::new();
    let mut sweep = |axis: &'static str, values: &[f64], knobs: &dyn Fn(f64) -> Knobs| {
        let ends = [values.first(), values.last()];
        let chosen: Vec<f64> =
            if short { ends.into_iter().flatten().copied().collect() } else { values.to_vec() };
        cases.extend(chosen.into_iter().map(|value| Case {
            axis: axis.into(),
            label: format!("{value}"),
            is_physical: true,
            ends_with_contact: false,
            document: knobs(value).document(),
        }));
    };
    sweep("K/G", &[10.0, 1e2, 1e3, 1e4, 1e5, 1e6], &|k_over_g| Knobs { k_over_g, ..BASE });
    sweep("fibre exponent k2", &[1.0, 10.0, 100.0, 1000.0], &|k2| Knobs { fibre_k2: Some(k2), ..BASE });
    sweep("speed [m/s]", &[1.0, 10.0, 100.0, 300.0, 1000.0], &|speed| Knobs { speed, ..BASE });
    sweep("density ratio", &[1e-3, 1e-1, 1.0, 1e2, 1e5], &|density_ratio| Knobs { density_ratio, ..BASE });
    sweep("friction", &[0.0, 0.3, 0.7, 1.0, 2.0], &|friction| Knobs { friction, ..BASE });
    sweep("aspect ratio", &[1.0, 10.0, 30.0, 100.0], &|aspect| Knobs { aspect, ..BASE });
    sweep("radius [m]", &[1e-6, 1e-4, 1e-2, 1.0], &|radius| Knobs { size: radius / RADIUS, ..BASE });
    sweep("K/G at 100 m/s", &[10.0, 1e3, 1e5], &|k_over_g| Knobs { k_over_g, speed: 100.0, ..BASE });
    sweep("density ratio, no friction", &[1e-3, 1e2], &|density_ratio| Knobs {
        density_ratio,
        friction: 0.0,
        ..BASE
    });
    cases.extend(geometries());
    cases.extend(nonsense());
    cases
}

impl Knobs {
    fn document(self) -> Value {
        let radius = RADIUS * self.size;
        let [width, height] = [2.5 * radius, 1.25 * radius];
        let elements = [6, 6, (4.0 * self.aspect).min(100.0) as u32];
        // A thin block has few layers: thin means one element, not many.
        let height =
            if self.aspect > 1.0 { width / 6.0 / self.aspect * f64::from(elements[2]) } else { height };
        // Heavier materials are refused: from there on the tissue is lighter.
        let ball = (1000.0 * self.density_ratio).min(HEAVIEST);
        json!({
            "name": "stability",
            "end_time_s": DEPTH * radius.min(2.0 * height) / self.speed,
            "bodies": [
                {
                    "name": "ball", "role": "projectile", "velocity_m_per_s": [0, 0, -self.speed],
                    "mesh": {"generator": {"kind": "solid_ball", "center_m": [0, 0, 1.001 * radius], "radius_m": radius,
                             "elements_around": 3, "elements_through": 2}},
                    "parts": [{"part": "*", "density_kg_per_m3": ball, "material":
                        {"law": "mooney_rivlin", "c10_pa": 4e5, "c01_pa": 1e5, "bulk_modulus_pa": 5e7}}]
                },
                {
                    "name": "block", "role": "tissue", "fixed": [{"set": "z_min"}],
                    "mesh": {"generator": {"kind": "block", "min_m": [-width / 2.0, -width / 2.0, -height],
                             "max_m": [width / 2.0, width / 2.0, 0], "elements": elements}},
                    "parts": [{"part": "*", "density_kg_per_m3": ball / self.density_ratio, "material": self.tissue()}]
                }
            ],
            "contact": {"pairs": [{"between": ["ball", "block"], "friction": self.friction}]},
            "record": {"fields": [], "field_times_s": []},
            "solver": {"error_bars": "none"}
        })
    }

    fn tissue(self) -> Value {
        let bulk_modulus_pa = self.k_over_g * SHEAR;
        match self.fibre_k2 {
            None => json!({"law": "neo_hookean", "c10_pa": SHEAR / 2.0, "bulk_modulus_pa": bulk_modulus_pa}),
            Some(k2) => json!({"law": "holzapfel_gasser_ogden", "c_pa": SHEAR, "k1_pa": SHEAR, "k2": k2,
                "fibres": {"angles_deg": [30, -30]}, "bulk_modulus_pa": bulk_modulus_pa}),
        }
    }
}

/// Cubes in contact by faces, edges or corners, initial contact, and degenerate meshes.
fn geometries() -> Vec<Case> {
    let turned = |axis: [f64; 3], angle_deg: f64, lift: f64| {
        let mut document = cubes(lift);
        document["bodies"][0]["placement"] = json!({
            "rotation": {"axis": axis, "angle_deg": angle_deg}, "translation_m": [0, 0, lift]
        });
        document
    };
    let side = 1e-2;
    let diagonal = (1.0 / 3.0_f64.sqrt()).acos().to_degrees();
    let case = |label: &str, document: Value| Case {
        axis: "geometry".into(),
        label: label.into(),
        is_physical: true,
        ends_with_contact: false,
        document,
    };
    let near = 1e-5;
    vec![
        case("flat on flat", turned([0.0, 0.0, 1.0], 0.0, side / 2.0 + near)),
        case("initial touch", turned([0.0, 0.0, 1.0], 0.0, side / 2.0)),
        case("edge on flat", turned([1.0, 0.0, 0.0], 45.0, side / 2.0_f64.sqrt() + near)),
        case("corner on flat", turned([1.0, -1.0, 0.0], diagonal, side * 3.0_f64.sqrt() / 2.0 + near)),
        case("turned on its face", turned([0.0, 0.0, 1.0], 45.0, side / 2.0 + near)),
    ]
}

/// A cube of 1 cm, its centre `lift` [m] above a block.
fn cubes(lift: f64) -> Value {
    json!({
        "name": "stability", "end_time_s": 3e-4,
        "bodies": [
            {
                "name": "cube", "role": "projectile", "velocity_m_per_s": [0, 0, -10],
                "placement": {"translation_m": [0, 0, lift]},
                "mesh": {"generator": {"kind": "block", "min_m": [-5e-3, -5e-3, -5e-3], "max_m": [5e-3, 5e-3, 5e-3],
                         "elements": [3, 3, 3]}},
                "parts": [{"part": "*", "density_kg_per_m3": 1000, "material":
                    {"law": "mooney_rivlin", "c10_pa": 4e5, "c01_pa": 1e5, "bulk_modulus_pa": 5e7}}]
            },
            {
                "name": "block", "role": "tissue", "fixed": [{"set": "z_min"}],
                "mesh": {"generator": {"kind": "block", "min_m": [-15e-3, -15e-3, -10e-3], "max_m": [15e-3, 15e-3, 0],
                         "elements": [9, 9, 4]}},
                "parts": [{"part": "*", "density_kg_per_m3": 1000, "material":
                    {"law": "neo_hookean", "c10_pa": SHEAR / 2.0, "bulk_modulus_pa": 100.0 * SHEAR}}]
            }
        ],
        "contact": {"pairs": [{"between": ["cube", "block"], "friction": 0.3}]},
        "record": {"fields": [], "field_times_s": []},
        "solver": {"error_bars": "none"}
    })
}

/// Scenes that must be refused or diagnosed, never computed silently.
fn nonsense() -> Vec<Case> {
    let with = |label: &str, change: &dyn Fn(&mut Value)| {
        let mut document = BASE.document();
        change(&mut document);
        Case {
            axis: "nonsense".into(),
            label: label.into(),
            is_physical: false,
            ends_with_contact: false,
            document,
        }
    };
    vec![
        with("speed 1e308", &|d| d["bodies"][0]["velocity_m_per_s"] = json!([0, 0, -1e308])),
        with("density 0", &|d| d["bodies"][0]["parts"][0]["density_kg_per_m3"] = json!(0)),
        with("density 1e300", &|d| d["bodies"][0]["parts"][0]["density_kg_per_m3"] = json!(1e300)),
        with("K < 0", &|d| d["bodies"][1]["parts"][0]["material"]["bulk_modulus_pa"] = json!(-1e6)),
        with("K 1e300", &|d| d["bodies"][1]["parts"][0]["material"]["bulk_modulus_pa"] = json!(1e300)),
        with("friction −1", &|d| d["contact"]["pairs"][0]["friction"] = json!(-1)),
        with("end 1e30 s", &|d| d["end_time_s"] = json!(1e30)),
        with("radius 1e-200", &|d| d["bodies"][0]["mesh"]["generator"]["radius_m"] = json!(1e-200)),
        with("overlap", &|d| d["bodies"][0]["mesh"]["generator"]["center_m"] = json!([0, 0, 0])),
    ]
}
