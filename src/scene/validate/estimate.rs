//! Estimated cost of a scene, from its counts, its shortest edges and the wave speeds of its materials at rest.

use super::Findings;
use crate::mechanics::element::ReferenceGeometry;
use crate::mechanics::material::Material;
use crate::mechanics::tensor::Vec3;
use crate::mesh::CellKind;
use crate::scene::budget::Budget;
use crate::scene::document::{BodyDocument, FieldName, IntegratorDocument, SceneDocument};
use crate::scene::elements::has_averaged_pressure;
use crate::scene::problem::{Pointer, Problem};
use crate::scene::scene_body::SceneBody;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// What a run takes of each element and of each node beside the program, roughly: more than most scenes of many elements do.
pub const BYTES_PER_ELEMENT: u64 = 4_000;
const BYTES_PER_NODE: u64 = 500;

/// Bytes recorded for contact and energy of one step, roughly.
const BYTES_PER_STEP: u64 = 2_000;

/// Estimated cost of a scene before it is compiled. The plan has a better estimate of the critical time step.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Estimate {
    /// Number of nodes of all bodies.
    pub nodes: u64,
    /// Number of elements of all bodies.
    pub elements: u64,
    /// Shortest time in which a wave crosses an element [s]: about the critical time step, which is shorter where the run
    /// compresses elements.
    pub shortest_crossing_s: f64,
    /// Number of steps to the end at that step: a lower bound, since compressed elements shorten the step.
    pub steps: u64,
    /// Approximate size of plan and state [bytes].
    pub memory_bytes: u64,
    /// Number of field frames.
    pub frames: u64,
    /// Approximate size of the recording before compression [bytes].
    pub recording_bytes: u64,
}

/// Speed of the fastest wave at rest [m/s]: √((K + 4/3 G + fibres)/ρ), all fibres along the wave.
pub fn wave_speed(material: &Material, density: f64) -> f64 {
    let (G, K) = material.moduli_at_rest();
    ((K + 4.0 / 3.0 * G + material.fibre_modulus_at_rest()) / density).sqrt()
}

/// Entries of the factor for n unknowns, in units of n^(4/3) [-]; nested dissection of a block of hexahedra gives about 25.
const FACTOR_ENTRIES: f64 = 30.0;
/// The same where tetrahedra average pressure over nodes; a block of 16³ hexahedra in six each has 131.
const AVERAGED_FACTOR_ENTRIES: f64 = 200.0;

/// Memory of the linear systems of implicit steps [bytes], estimated before they are analysed.
pub fn system_bytes(nodes: u64, averages_pressure: bool) -> u64 {
    let unit = if averages_pressure { AVERAGED_FACTOR_ENTRIES } else { FACTOR_ENTRIES };
    let entries = unit * (3.0 * nodes as f64).powf(4.0 / 3.0);
    (entries * size_of::<f64>() as f64) as u64
}

/// Shortest time in which a wave crosses an element of any body [s]; infinite without elements.
pub fn shortest_crossing(document: &SceneDocument, bodies: &[SceneBody]) -> f64 {
    crossings(document, bodies).iter().map(|c| c[0]).fold(f64::INFINITY, f64::min)
}

fn crossings(document: &SceneDocument, bodies: &[SceneBody]) -> Vec<[f64; 2]> {
    document.bodies.iter().zip(bodies).map(|(written, body)| crossing_times(written, body)).collect()
}

/// Estimates the cost of a scene with its integrator, and compares it with the budget.
pub fn check(
    document: &SceneDocument,
    integrator: &IntegratorDocument,
    bodies: &[SceneBody],
    budget: &Budget,
    out: &mut Findings,
) -> Estimate {
    let crossings = crossings(document, bodies);
    let shortest = crossings.iter().map(|c| c[0]).fold(f64::INFINITY, f64::min);
    let step = integrator.step(shortest);
    let relaxation = document.dynamic_relaxation.as_ref().map_or(0.0, |s| s.duration_s);

    // Counts.
    let nodes: u64 = bodies.iter().map(|b| b.mesh.nodes.len() as u64).sum();
    let elements: u64 = bodies.iter().map(|b| b.mesh.cells.len() as u64).sum();
    let preloading = document.preload.as_ref().map_or(0, |preload| u64::from(preload.steps));
    let steps = count((document.end_time_s + relaxation) / step).saturating_add(preloading);
    let frames = frame_count(document);
    // Only implicit solutions have a matrix.
    let systems = if integrator.is_implicit() || document.preload.is_some() {
        let mut pairs = document.bodies.iter().zip(bodies);
        system_bytes(nodes, pairs.any(|(written, body)| has_averaged_pressure(written, body)))
    } else {
        0
    };
    let estimate = Estimate {
        nodes,
        elements,
        shortest_crossing_s: shortest,
        steps,
        memory_bytes: elements * BYTES_PER_ELEMENT + nodes * BYTES_PER_NODE + systems,
        frames,
        recording_bytes: recording_bytes(document, nodes, elements, steps, frames),
    };
    check_budget(document, integrator.is_implicit(), &estimate, budget, out);
    check_steps(steps, budget, out);
    let longest = crossings.iter().map(|c| c[1]).fold(0.0, f64::max);
    check_end_time(document.end_time_s, longest, out);
    estimate
}

/// Shortest crossing time of a wave through one element, and crossing time of the whole body [s].
fn crossing_times(written: &BodyDocument, body: &SceneBody) -> [f64; 2] {
    // Wave speed of each law: those of the parts, and those of elements with a stiffness factor.
    let mut speeds = vec![0.0; body.materials.len()];
    let of_parts = (0..written.parts.len()).map(|entry| (entry, entry));
    let of_elements =
        body.law_of.iter().zip(&body.part_entry).map(|(law, entry)| (*law as usize, *entry as usize));
    for (law, entry) in of_parts.chain(of_elements) {
        if speeds[law] == 0.0 {
            speeds[law] = wave_speed(&body.materials[law], written.parts[entry].density_kg_per_m3);
        }
    }
    // Elements as they are at the start, which may be deformed.
    let mut shortest = f64::INFINITY;
    for (element, &entry) in body.part_entry.iter().enumerate() {
        let cell = body.mesh.cells.get(element);
        let x = cell.points(&body.mesh.nodes).map(|X| written.start_position(X));
        let mut length = crossing_length(cell.kind, &x);
        if written.initial_deformation.is_some() {
            length = length.min(thickness(cell.kind, &x));
        }
        let part = &written.parts[entry as usize];
        let diffusivity = part.shear_viscosity_pa_s / part.density_kg_per_m3;
        shortest = shortest.min(stable_step(length, speeds[body.law_of[element] as usize], diffusivity));
    }
    let size = body.mesh.bounding_box().map_or(0.0, |[low, high]| (high - low).min());
    let fastest = speeds.iter().copied().fold(0.0, f64::max);
    [shortest, size / fastest]
}

/// Critical time step [s] of an element of length [m], wave speed [m/s] and diffusivity (shear viscosity over density)
/// [m²/s]; the crossing time where there is no viscosity.
fn stable_step(length: f64, speed: f64, diffusivity: f64) -> f64 {
    let damping = 4.0 * diffusivity / (length * length);
    2.0 / ((2.0 * speed / length).hypot(damping) + damping)
}

/// Characteristic length of an element for the critical time step [m]. For a hexahedron 1/√(Σ 1/L²) over the shortest edge
/// L along each natural direction, since the fastest mode of a brick has ω² = 4 c² Σ 1/L²; for other kinds 2/√λ, λ the bound of
/// their gradients against their lumped mass.
fn crossing_length(kind: CellKind, x: &[Vec3]) -> f64 {
    if kind != CellKind::Hex8 {
        return 2.0 / ReferenceGeometry::new(kind.element(), x).gradient_bound.sqrt();
    }
    let table = kind.table();
    let mut shortest = [f64::INFINITY; 3];
    for &[a, b] in table.edges {
        // The two corners differ in one natural coordinate.
        let direction = (0..3).find(|&k| table.points[a][k] * table.points[b][k] < 0.0).unwrap_or(0);
        shortest[direction] = shortest[direction].min((x[a] - x[b]).norm());
    }
    1.0 / shortest.iter().map(|L| L.powi(-2)).sum::<f64>().sqrt()
}

/// Volume over the area of the largest face [m]: accounts for a deformation that flattens an element without shortening its
/// edges.
fn thickness(kind: CellKind, x: &[Vec3]) -> f64 {
    let of_facet = |facet: &[usize; 4]| {
        let [a, b, c, d] = facet.map(|i| x[i]);
        0.5 * (c - a).cross(&(d - b)).norm()
    };
    let areas = kind.table().faces.iter().map(|face| face.facets.iter().map(of_facet).sum::<f64>());
    kind.volume_m3(x) / areas.fold(0.0, f64::max)
}

/// A number as a count, rounded up and saturated; 0 for negative numbers and NaN.
#[allow(clippy::cast_sign_loss)]
fn count(number: f64) -> u64 {
    number.ceil() as u64
}

/// Number of field frames; the start and the end are always recorded.
fn frame_count(document: &SceneDocument) -> u64 {
    let record = &document.record;
    match (&record.field_times_s, record.field_interval_s) {
        (Some(times), _) => times.len() as u64 + 2,
        (None, Some(interval)) => count(document.end_time_s / interval).saturating_add(1),
        (None, None) => 51,
    }
}

fn recording_bytes(document: &SceneDocument, nodes: u64, elements: u64, steps: u64, frames: u64) -> u64 {
    let of_field = |field: &FieldName| match field {
        FieldName::VonMises | FieldName::Pressure | FieldName::PrincipalStrain => 8 * nodes,
        FieldName::Displacement | FieldName::Velocity => 24 * nodes,
        FieldName::ElementCauchyStress => 48 * elements,
    };
    // Besides the fields, each frame has the boundary surface and the points.
    let frame: u64 = document.recorded_fields().iter().map(of_field).sum::<u64>() + 100 * nodes;
    let steps = steps / u64::from(document.record.every_steps.max(1));
    frame.saturating_mul(frames).saturating_add(steps.saturating_mul(BYTES_PER_STEP))
}

fn check_budget(
    document: &SceneDocument,
    is_implicit: bool,
    estimate: &Estimate,
    budget: &Budget,
    out: &mut Findings,
) {
    let root = Pointer::root();
    // Wording of the problems.
    let (stepping, fewer_steps, less_memory) = if is_implicit {
        (
            "implicit steps",
            "run for a shorter time, or give a longer integrator.step_s",
            "step explicitly, which needs no matrix, or use a coarser mesh",
        )
    } else {
        (
            "explicit steps",
            "run for a shorter time, enlarge the smallest elements, lower the bulk modulus, or step implicitly",
            "use a coarser mesh",
        )
    };
    let mut limit =
        |place: Pointer, code: &'static str, what: String, value: u64, limit: u64, remedy: &str| {
            out.require(value <= limit, || {
                Problem::error(code, &place, what)
                    .value(value)
                    .limit(format!("at most {limit}"))
                    .remedy(remedy)
            });
        };
    limit(
        root.key("end_time_s"),
        "budget_steps",
        format!("the run would take about {} {stepping} to {} s", estimate.steps, document.end_time_s),
        estimate.steps,
        budget.steps,
        fewer_steps,
    );
    limit(
        root.key("bodies"),
        "budget_memory",
        format!(
            "the run with {stepping} would take about {} MB of memory",
            estimate.memory_bytes / 1_000_000
        ),
        estimate.memory_bytes,
        budget.memory_bytes,
        less_memory,
    );
    limit(
        root.key("record"),
        "budget_recording",
        format!("the recording would have about {} MB", estimate.recording_bytes / 1_000_000),
        estimate.recording_bytes,
        budget.recording_bytes,
        "record fewer fields, fewer frames, or contact and energy less often",
    );
}

/// Number of steps above which a run takes hours, as a rule.
const MANY_STEPS: u64 = 1_000_000;

/// A run of very many steps is probably unintended.
fn check_steps(steps: u64, budget: &Budget, out: &mut Findings) {
    // Beyond the budget there already is an error.
    out.require(steps <= MANY_STEPS || steps > budget.steps, || {
        let place = Pointer::root().key("end_time_s");
        Problem::warning("many_steps", &place, format!("the run takes at least {:.1} million steps", 1e-6 * steps as f64))
            .value(steps)
            .limit(format!("usually at most {MANY_STEPS}"))
            .remedy("give the end time in seconds: impacts last about 1e-4 to 1e-2 s; or allow longer steps (enlarge the smallest elements)")
    });
}

/// An end time far from the crossing time of a wave through a body is probably in another unit.
fn check_end_time(end: f64, crossing: f64, out: &mut Findings) {
    let place = Pointer::root().key("end_time_s");
    let ratio = end / crossing;
    out.require(!(ratio.is_finite() && ratio > 0.0) || (1e-3..=1e6).contains(&ratio), || {
        Problem::warning(
            "unusual_unit",
            &place,
            format!("a wave crosses the slowest body in about {crossing:.3e} s: is the end time right?"),
        )
        .value(end)
        .limit("usually 1e-3 to 1e6 times that")
        .remedy("give the end time in seconds")
    });
}
