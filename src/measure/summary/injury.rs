//! Published injury criteria: what they are here, what they are compared with, and whether they may be.
//!
//! A criterion is a fit to some experiments. Outside of what they covered it is told to be not applicable, with the reason.

use super::super::measures::Measures;
use super::Shown;
use crate::measure::presented_area::Onslaught;
use crate::plan::Plan;
use crate::scene::document::{PersonDocument, Region};
use serde::Serialize;

/// Energy densities of 50 % risk of skin penetration, the weakest and the strongest region [J/cm²].
const PENETRATION_J_PER_CM2: [f64; 2] = [23.99, 52.74];
/// Blunt criterion of 50 % risk of a thoracic injury of AIS 2 or 3 [-].
const BLUNT_CRITERION: f64 = 0.37;
/// Viscous criterion of 25 % risk of a thoracic injury of AIS 4 or more [m/s].
const VISCOUS_CRITERION_M_PER_S: f64 = 1.0;

/// One criterion.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct InjuryMeasure {
    /// Its name, for programs.
    pub name: &'static str,
    /// Its name, for people.
    pub title: &'static str,
    /// Its value; absent where the scene does not say enough.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub value: Option<f64>,
    /// Unit of the value.
    pub unit: &'static str,
    /// What it is compared with; one number twice, or a range.
    pub reference: [f64; 2],
    /// What the reference means.
    pub meaning: &'static str,
    /// Whether the experiments behind it cover this scene.
    pub applicable: bool,
    /// What it says here, or why it says nothing.
    pub statement: String,
    /// Author, year, journal.
    pub source: &'static str,
}

/// All criteria; none where the scene has no projectile, or no tissue. What comes of the run itself is withheld with its results.
pub(super) fn injury_measures(measures: &Measures, plan: &Plan, results: &Shown) -> Vec<InjuryMeasure> {
    let Some(onslaught) = Onslaught::new(plan) else { return Vec::new() };
    let person = plan.measures.person.as_ref();
    let mut all = vec![penetration(&onslaught, person), blunt(&onslaught, person)];
    if matches!(results, Shown::Results(_)) {
        all.push(viscous(measures, person));
    }
    all
}

/// Kinetic energy over the presented area, before the impact.
fn penetration(onslaught: &Onslaught, person: Option<&PersonDocument>) -> InjuryMeasure {
    let value = 1e-4 * onslaught.energy_density();
    let [weakest, strongest] = PENETRATION_J_PER_CM2;
    let on_head = person.is_some_and(|person| person.region == Region::Head);
    let verdict = match value {
        x if x < weakest => {
            format!("{x:.2} J/cm² is below all regions' 50 % risk ({weakest} to {strongest} J/cm²)")
        }
        x if x <= strongest => {
            format!("{x:.2} J/cm² lies among the regions' 50 % risks ({weakest} to {strongest} J/cm²)")
        }
        x => format!("{x:.2} J/cm² is above all regions' 50 % risk ({weakest} to {strongest} J/cm²)"),
    };
    InjuryMeasure {
        name: "skin_penetration_energy_density",
        title: "energy density (skin penetration)",
        value: Some(value),
        unit: "J/cm²",
        reference: [weakest, strongest],
        meaning: "50 % risk of skin penetration by a 12-gauge fin-stabilised rubber projectile, weakest and strongest region of trunk \
                  and legs of cadavers",
        applicable: !on_head,
        statement: if on_head {
            "not applicable: the experiments were on trunk and legs".into()
        } else {
            format!("{verdict}; other projectiles than the one tested are compared by their presented area")
        },
        source: "C. A. Bir, S. J. Stewart, M. Wilhelm (2005), Journal of Forensic Sciences 50, 1426–1429",
    }
}

/// BC = ln(E / (W^(1/3) T D)), E [J], W [kg], T [cm], D [cm].
fn blunt(onslaught: &Onslaught, person: Option<&PersonDocument>) -> InjuryMeasure {
    let measure = InjuryMeasure {
        name: "blunt_criterion",
        title: "blunt criterion",
        value: None,
        unit: "-",
        reference: [BLUNT_CRITERION; 2],
        meaning: "50 % risk of an injury of the chest of AIS 2 or 3 by a blunt projectile",
        applicable: false,
        statement: String::new(),
        source: "L. M. Sturdivan, D. C. Viano, H. R. Champion (2004), Journal of Trauma 56, 651–663; C. Bir, D. C. Viano (2004), \
                 Journal of Trauma 57, 1218–1224",
    };
    let refused =
        |reason: &str| InjuryMeasure { statement: format!("not applicable: {reason}"), ..measure.clone() };
    let Some(person) = person else {
        return refused("the scene does not say where the person is hit (`measures.person`)");
    };
    if person.region != Region::Thorax {
        return refused("the limit is that of the chest");
    }
    let (Some(mass), Some(wall)) = (person.body_mass_kg, person.wall_thickness_m) else {
        return refused("it needs `measures.person.body_mass_kg` and `wall_thickness_m`");
    };
    let value = (onslaught.kinetic_energy / (mass.cbrt() * 100.0 * wall * 100.0 * onslaught.diameter())).ln();
    let side = if value > BLUNT_CRITERION { "above" } else { "at or below" };
    InjuryMeasure {
        value: Some(value),
        applicable: true,
        statement: format!("{value:.2} is {side} the 50 % risk of AIS 2 or 3 ({BLUNT_CRITERION})"),
        ..measure
    }
}

/// VC = max V C, C the deflection over the depth of the chest, V its rate.
fn viscous(measures: &Measures, person: Option<&PersonDocument>) -> InjuryMeasure {
    let depth = person.and_then(|person| person.chest_depth_m);
    let value = depth.map(|depth| measures.deflection.largest_rate / depth);
    let measure = InjuryMeasure {
        name: "viscous_criterion",
        title: "viscous criterion",
        value,
        unit: "m/s",
        reference: [VISCOUS_CRITERION_M_PER_S; 2],
        meaning: "25 % risk of an injury of the chest of AIS 4 or more, frontal impact",
        applicable: false,
        statement: String::new(),
        source: "I. V. Lau, D. C. Viano (1986), SAE Technical Paper 861882 (30th Stapp Car Crash Conference)",
    };
    let refused =
        |reason: &str| InjuryMeasure { statement: format!("not applicable: {reason}"), ..measure.clone() };
    match (person.map(|person| person.region), value) {
        (None, _) => refused("the scene does not say where the person is hit (`measures.person`)"),
        (Some(region), _) if region != Region::Thorax => refused("the limit is that of the chest"),
        (_, None) => refused("it needs `measures.person.chest_depth_m`"),
        (_, Some(value)) => {
            let side = if value > VISCOUS_CRITERION_M_PER_S { "above" } else { "at or below" };
            InjuryMeasure {
                applicable: true,
                statement: format!(
                    "{value:.3} m/s is {side} the 25 % risk of AIS 4 or more ({VISCOUS_CRITERION_M_PER_S} m/s)"
                ),
                ..measure
            }
        }
    }
}
