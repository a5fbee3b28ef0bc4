//! Checks of the inputs of the measures.

use super::Findings;
use crate::scene::document::{MeasuresDocument, Role, SceneDocument};
use crate::scene::problem::{Pointer, Problem};

/// Usual stress thresholds for soft tissue [Pa]; below, kPa were probably meant.
const USUAL_STRESS: [f64; 2] = [100.0, 1e9];
/// Admissible volumes for the values exceeded in them [m³], from a cube of 0.1 mm to one of 10 cm.
const EXCEEDED_IN_VOLUME: [f64; 2] = [1e-12, 1e-3];
/// Largest number of thresholds of one kind; each adds a number per quadrature point.
const MAX_THRESHOLDS: usize = 32;

/// Checks thresholds, force window and filter, person and skin set.
pub fn check(document: &SceneDocument, out: &mut Findings) {
    let here = Pointer::root().key("measures");
    let measures = &document.measures;
    for (name, thresholds, remedy) in [
        ("stress_thresholds_pa", &measures.stress_thresholds_pa, "give it in Pa: 10 kPa is 1e4"),
        (
            "strain_energy_density_thresholds_j_per_m3",
            &measures.strain_energy_density_thresholds_j_per_m3,
            "give it in J/m³: 1 mJ/cm³ is 1e3",
        ),
        ("principal_strain_thresholds", &measures.principal_strain_thresholds, "30 % is 0.3"),
    ] {
        check_thresholds(&here.key(name), thresholds, remedy, out);
        if name == "stress_thresholds_pa" {
            for (i, &threshold) in thresholds.iter().enumerate().filter(|(_, threshold)| **threshold > 0.0) {
                out.usual(
                    &here.key(name).index(i),
                    "the threshold of stress",
                    threshold,
                    USUAL_STRESS,
                    remedy,
                );
            }
        }
    }
    if let Some(volume) = measures.exceeded_in_volume_m3 {
        let place = here.key("exceeded_in_volume_m3");
        let remedy = "give it in m³: 100 mm³ is 1e-7";
        out.between(&place, "the volume", volume, EXCEEDED_IN_VOLUME, remedy);
    }
    check_force(document, &here, out);
    check_person(&here.key("person"), measures, out);
    if let Some(set) = &measures.skin_set {
        out.require(document.bodies.iter().any(|b| b.role == Role::Tissue), || {
            Problem::error("no_tissue", &here.key("skin_set"), "no body has the role of tissue")
                .value(set.as_str())
                .limit("a node set of a body whose role is \"tissue\"")
                .remedy("give a body the role \"tissue\", or omit skin_set")
        });
    }
}

/// Smallest number of intervals in the history of a force; a filter needs ten of them in the time 1 / class (SAE J211).
const FORCE_PIECES: f64 = 8192.0;
const PIECES_OF_CLASS: f64 = 10.0;

/// A window or a filter, not both; and a history of the force that is fine enough for the filter.
fn check_force(document: &SceneDocument, here: &Pointer, out: &mut Findings) {
    let measures = &document.measures;
    if let Some(window) = measures.force_window_s {
        let remedy = "by default 1/10 of the duration of contact";
        out.positive(&here.key("force_window_s"), "the window", window, remedy);
    }
    let Some(filter) = measures.force_filter else { return };
    let place = here.key("force_filter");
    out.require(measures.force_window_s.is_none(), || {
        Problem::error("contradiction", &place, "the force is either averaged over a window or filtered")
            .value(filter.name())
            .remedy("omit force_window_s or force_filter")
    });
    let longest = FORCE_PIECES / (PIECES_OF_CLASS * filter.class());
    out.require(document.end_time_s <= longest, || {
        Problem::error(
            "out_of_range",
            &place,
            "the run is too long for this class: the recorded force history would be too coarse",
        )
        .value(document.end_time_s)
        .limit(format!("at most {longest:.3} s with {}", filter.name()))
        .remedy("choose a lower class, or a window, or end the run earlier")
    });
}

fn check_thresholds(here: &Pointer, thresholds: &[f64], remedy: &str, out: &mut Findings) {
    out.require(thresholds.len() <= MAX_THRESHOLDS, || {
        Problem::error("too_many_items", here, "there are too many thresholds")
            .value(thresholds.len())
            .limit(format!("at most {MAX_THRESHOLDS}"))
            .remedy("keep those that you need")
    });
    let mut previous = f64::NEG_INFINITY;
    for (i, &threshold) in thresholds.iter().enumerate() {
        let place = here.index(i);
        out.positive(&place, "a threshold", threshold, remedy);
        out.require(threshold > previous, || {
            Problem::error("not_ascending", &place, "the threshold is not above the one before")
                .value(threshold)
                .limit(format!("> {previous}"))
                .remedy("sort the thresholds and give each once")
        });
        previous = previous.max(threshold);
    }
}

fn check_person(here: &Pointer, measures: &MeasuresDocument, out: &mut Findings) {
    let Some(person) = &measures.person else { return };
    for (name, what, value, range, remedy) in [
        ("body_mass_kg", "the mass of a person", person.body_mass_kg, [2.0, 400.0], "give it in kilograms"),
        (
            "wall_thickness_m",
            "the body wall",
            person.wall_thickness_m,
            [0.005, 0.2],
            "give it in metres: 30 mm is 0.03",
        ),
        (
            "chest_depth_m",
            "the depth of a chest",
            person.chest_depth_m,
            [0.05, 0.6],
            "give it in metres: 23 cm is 0.23",
        ),
    ] {
        if let Some(value) = value {
            out.between(&here.key(name), what, value, range, remedy);
        }
    }
}
