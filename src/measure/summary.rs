//! The clinical summary: a few numbers, each with its unit, its estimated numerical error, and the gate that it passed.
//!
//! A run that fails a gate gives no plain numbers: what it computed stands under `withheld`, with the reason.

use super::measures::{Measures, PairMeasures};
use super::stress_depth::Peak;
use crate::plan::Plan;
use crate::step::{Ending, Failure, FailureCause, Outcome};
use serde::Serialize;

/// Said with every answer.
pub const NOTICE: &str =
    "For research use only. Contuse is no medical device, and its results are no diagnosis and no medical advice.";
/// Share of the initial energy above which numerical contact dissipation is warned about.
const CONTACT_DISSIPATION_WARNING: f64 = 0.02;
/// Share of the energy scale that contact may create at most.
const CONTACT_CREATION_LIMIT: f64 = 0.001;
/// Nodes across a contact patch that are the least for a resolved patch.
const NODES_ACROSS: u32 = 5;

/// What is known of a number's numerical error.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub enum ErrorEstimate {
    /// Nobody looked.
    #[serde(rename = "not estimated")]
    NotEstimated,
}

/// Whether the run passed its gates.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum GateResult {
    /// It did.
    Passed,
    /// It did not.
    Failed,
}

/// A number of the summary; its unit is the end of its name.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Quantity {
    /// The number.
    pub value: f64,
    /// Its numerical error.
    pub error: ErrorEstimate,
    /// Whether the run that it comes from passed its gates.
    pub gate: GateResult,
}

/// A check that decides whether numbers may be shown.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Gate {
    /// Name.
    pub name: &'static str,
    /// What it means.
    pub meaning: &'static str,
    /// Measured value [-].
    pub value: f64,
    /// Limit of the value [-].
    pub limit: f64,
    /// The verdict.
    pub result: GateResult,
}

/// State of the run that is summed up.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(tag = "ending", rename_all = "snake_case")]
pub enum RunState {
    /// It still runs.
    Running,
    /// It reached the end time.
    Finished,
    /// Somebody stopped it.
    Cancelled,
    /// It went wrong, and this is why.
    Failed {
        /// The diagnosis.
        failure: Failure,
    },
}

/// The summary.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Summary {
    /// No medical device, no diagnosis.
    pub notice: &'static str,
    /// Version of the engine.
    pub engine_version: &'static str,
    /// Name of the scene.
    pub scene: String,
    /// How the run ended.
    #[serde(flatten)]
    pub state: RunState,
    /// Simulated time reached [s].
    pub time_s: f64,
    /// Simulated time asked for [s].
    pub end_time_s: f64,
    /// Steps done.
    pub steps: u64,
    /// The numbers, or why there are none.
    #[serde(flatten)]
    pub results: Shown,
    /// How good the computation was.
    pub numerics: Numerics,
    /// The gates.
    pub gates: Vec<Gate>,
    /// Sentences to read before the numbers are used.
    pub warnings: Vec<String>,
}

/// Numbers, plain or withheld.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Shown {
    /// The gates were passed.
    Results(Results),
    /// A gate was failed.
    Withheld {
        /// Which, and by how much.
        reason: String,
        /// What was computed; not to be used as results.
        values: Results,
    },
}

/// The numbers.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Results {
    /// One for each contact pair.
    pub impacts: Vec<Impact>,
    /// The tissue; absent without one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub tissue: Option<Tissue>,
}

/// What one contact pair did.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Impact {
    /// Name of the pair.
    pub pair: String,
    /// Slave and master.
    pub between: [String; 2],
    /// Whether one of them is the tissue.
    pub on_tissue: bool,
    /// Largest mean force over the window: max |ΔI|/τ [N].
    pub peak_force_n: Quantity,
    /// Middle of that window [s].
    pub peak_force_time_s: Quantity,
    /// The window τ [s].
    pub force_window_s: f64,
    /// Largest force of a single step [N]: not a converged quantity.
    pub peak_step_force_n: Quantity,
    /// Norm of the impulse so far [N s].
    pub impulse_n_s: Quantity,
    /// The impulse on the first of `between` [N s].
    pub impulse_vector_n_s: [f64; 3],
    /// Time with contact [s].
    pub contact_duration_s: Quantity,
    /// First and last time with contact [s]; absent when they never touched.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub contact_span_s: Option<[f64; 2]>,
    /// Whether contact has ended.
    pub contact_ended: bool,
    /// Area of the patch at the peak force [mm²].
    pub patch_area_mm2: Quantity,
    /// Its long axis [mm].
    pub patch_long_axis_mm: Quantity,
    /// Its short axis [mm].
    pub patch_short_axis_mm: Quantity,
    /// Largest area at any time [mm²].
    pub largest_patch_area_mm2: Quantity,
    /// Nodes across the short axis, at the peak force and when the patch was largest.
    pub nodes_across_patch: [u32; 2],
    /// Dissipated by friction [J].
    pub friction_dissipation_j: Quantity,
    /// Numerical contact dissipation [J].
    pub numerical_contact_dissipation_j: Quantity,
}

/// What happened to the tissue.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Tissue {
    /// Energy absorbed at the end: strain + kinetic + dissipated [J].
    pub absorbed_energy_j: Quantity,
    /// The same from the work of the contact reactions [J].
    pub absorbed_energy_by_work_j: Quantity,
    /// Its parts at the end.
    pub absorbed_split: Split,
    /// Largest energy absorbed at any time [J].
    pub peak_absorbed_energy_j: Quantity,
    /// When [s].
    pub peak_absorbed_energy_time_s: Quantity,
    /// Its parts at that time.
    pub peak_absorbed_split: Split,
    /// Whether contact with the tissue has ended: if not, the absorbed energy is not final.
    pub contact_ended: bool,
    /// Strain + kinetic energy lost by the projectile [J]; absent without one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub projectile_loss_j: Option<Quantity>,
    /// Depth and volume of significant stress, one for each threshold.
    pub significant_stress: Vec<SignificantStress>,
    /// Largest von Mises stress at a quadrature point at a field time [Pa].
    pub peak_von_mises_pa: Located,
    /// Largest principal Green–Lagrange strain [-].
    pub peak_principal_strain: Located,
    /// Largest strain energy density [J/m³].
    pub peak_strain_energy_density_j_per_m3: Located,
    /// Largest displacement of a node of the skin [mm].
    pub deflection_mm: Located,
}

/// Parts of the absorbed energy.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Split {
    /// Strain energy [J].
    pub strain_j: Quantity,
    /// Kinetic energy [J].
    pub kinetic_j: Quantity,
    /// Strain + kinetic: what the tissue could give back [J].
    pub recoverable_j: Quantity,
    /// Dissipated by bulk viscosity [J].
    pub dissipated_j: Quantity,
}

/// A peak, where and when.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Located {
    /// The number.
    #[serde(flatten)]
    pub quantity: Quantity,
    /// Reference position [m].
    pub position_m: [f64; 3],
    /// Time [s].
    pub time_s: f64,
}

/// What exceeds a threshold of von Mises stress, evaluated at the field times.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct SignificantStress {
    /// The threshold [Pa].
    pub threshold_pa: f64,
    /// Largest depth below the skin, in the reference configuration [mm]; absent when the tissue has no skin.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub depth_mm: Option<Quantity>,
    /// When [s].
    pub depth_time_s: f64,
    /// Largest reference volume above the threshold at any field time [mm³].
    pub volume_mm3: Quantity,
    /// That volume at the end [mm³].
    pub volume_at_end_mm3: Quantity,
}

/// How good the computation was.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Numerics {
    /// Smallest Jacobian J at any time [-]; absent while running.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub smallest_jacobian: Option<f64>,
    /// Smallest step [s]; absent while running.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub smallest_step_s: Option<f64>,
    /// Energy at the start [J].
    pub initial_energy_j: f64,
    /// Energy that errors are compared with [J].
    pub energy_scale_j: f64,
    /// Largest error of the energy balance [-].
    pub balance_error: f64,
    /// What lumped contact nodes lost when they were caught, all pairs [J]: a discretisation error.
    pub numerical_contact_dissipation_j: f64,
    /// The same over the initial energy [-].
    pub numerical_contact_dissipation_share: f64,
    /// Dissipated by friction, all pairs [J].
    pub friction_dissipation_j: f64,
    /// Largest difference of the absorbed energy's two computations over the energy scale [-].
    pub absorbed_energy_disagreement: f64,
}

/// Makes quantities that share one verdict.
#[derive(Clone, Copy)]
struct Mint(GateResult);

impl Mint {
    fn quantity(self, value: f64) -> Quantity {
        // −0 would be printed as such.
        Quantity { value: value + 0.0, error: ErrorEstimate::NotEstimated, gate: self.0 }
    }
    fn located(self, scale: f64, peak: &Peak) -> Located {
        let position_m = peak.position.into();
        Located { quantity: self.quantity(scale * peak.value), position_m, time_s: peak.time }
    }
}

impl Summary {
    /// Of what was measured; `outcome` is `None` while the run goes on.
    pub fn compose(measures: &Measures, plan: &Plan, outcome: Option<&Outcome>) -> Self {
        let state = match outcome.map(|o| &o.ending) {
            None => RunState::Running,
            Some(Ending::Finished) => RunState::Finished,
            Some(Ending::Cancelled) => RunState::Cancelled,
            Some(Ending::Failed { failure }) => RunState::Failed { failure: failure.clone() },
        };
        let numerics = numerics(measures, outcome);
        let gates = gates(&numerics, plan);
        let mut reason = withholding_reason(&gates, &state);
        let verdict = |reason: &Option<String>| if reason.is_some() { GateResult::Failed } else { GateResult::Passed };
        let mut values = results(measures, plan, Mint(verdict(&reason)));
        if reason.is_none() && !values.is_finite() {
            reason = Some("a result is infinite or not a number".to_owned());
            values = results(measures, plan, Mint(GateResult::Failed));
        }
        let mut warnings = outcome.map(|o| o.warnings.clone()).unwrap_or_default();
        warnings.extend(own_warnings(measures, &numerics, outcome.is_some()).into_iter().filter(|w| !warnings.contains(w)).collect::<Vec<_>>());
        Self {
            notice: NOTICE,
            engine_version: env!("CARGO_PKG_VERSION"),
            scene: plan.name.clone(),
            state,
            time_s: outcome.map_or(measures.time, |o| o.time_s),
            end_time_s: plan.end_time,
            steps: outcome.map_or(measures.step, |o| o.steps),
            results: match reason {
                None => Shown::Results(values),
                Some(reason) => Shown::Withheld { reason, values },
            },
            numerics,
            gates,
            warnings,
        }
    }

    /// The numbers, whether withheld or not.
    pub fn values(&self) -> &Results {
        match &self.results {
            Shown::Results(values) | Shown::Withheld { values, .. } => values,
        }
    }

    /// The summary as indented JSON.
    ///
    /// # Errors
    /// Never for a summary made by [`Summary::compose`]; the type is that of the serialiser.
    pub fn to_json(&self) -> Result<String, serde_json::Error> {
        serde_json::to_string_pretty(self)
    }
}

impl Results {
    /// Whether the headline numbers are finite (NaN poisons sums, so they stand for the others).
    fn is_finite(&self) -> bool {
        let impacts = self.impacts.iter().flat_map(|i| [i.peak_force_n.value, i.impulse_n_s.value, i.patch_area_mm2.value]);
        let tissue = self.tissue.iter().flat_map(|t| {
            [t.absorbed_energy_j.value, t.absorbed_energy_by_work_j.value, t.peak_von_mises_pa.quantity.value]
        });
        impacts.chain(tissue).all(f64::is_finite)
    }
}

/// How good the computation was.
fn numerics(measures: &Measures, outcome: Option<&Outcome>) -> Numerics {
    let energy = &measures.energy;
    let scale = measures.energy_scale();
    let over = |value: f64, scale: f64| if scale > 0.0 { value / scale } else { 0.0 };
    let numerical: f64 = energy.pairs.iter().map(|p| p.numerical_j).sum();
    // A scene that starts from rest has no initial energy to compare with.
    let reference = if energy.initial_total_j > 0.0 { energy.initial_total_j } else { scale };
    let balance = outcome.map_or(0.0, |o| o.balance_error).max(measures.largest_balance_error);
    Numerics {
        smallest_jacobian: outcome.map(|o| o.smallest_jacobian),
        smallest_step_s: outcome.map(|o| o.smallest_step_s),
        initial_energy_j: energy.initial_total_j,
        energy_scale_j: scale,
        balance_error: balance,
        numerical_contact_dissipation_j: numerical,
        numerical_contact_dissipation_share: over(numerical, reference),
        friction_dissipation_j: energy.pairs.iter().map(|p| p.friction_j).sum(),
        absorbed_energy_disagreement: measures.absorbed.as_ref().map_or(0.0, |a| over(a.disagreement, scale)),
    }
}

/// The gates of a run.
fn gates(numerics: &Numerics, plan: &Plan) -> Vec<Gate> {
    let gate = |name, meaning, value: f64, limit: f64| {
        // Written so that NaN fails.
        let result = if value <= limit { GateResult::Passed } else { GateResult::Failed };
        Gate { name, meaning, value, limit, result }
    };
    let limit = plan.explicit.energy_gate;
    let creation = -numerics.numerical_contact_dissipation_share;
    vec![
        gate("energy_balance", "largest error of the energy balance", numerics.balance_error, limit),
        gate(
            "contact_creates_no_energy",
            "energy created by contact over the initial energy",
            // NaN passes through, a dissipation counts as nothing created.
            if creation < 0.0 { 0.0 } else { creation + 0.0 },
            CONTACT_CREATION_LIMIT,
        ),
        gate(
            "absorbed_energy_agreement",
            "difference of the absorbed energy from the tissue's state and from the work of the reactions",
            numerics.absorbed_energy_disagreement,
            limit,
        ),
    ]
}

/// Why the numbers are withheld, if they are.
fn withholding_reason(gates: &[Gate], state: &RunState) -> Option<String> {
    if let RunState::Failed { failure } = state
        && matches!(failure.cause, FailureCause::EnergyGate | FailureCause::NotFinite)
    {
        return Some(failure.message.clone());
    }
    let failed = gates.iter().find(|g| g.result == GateResult::Failed)?;
    Some(format!("the gate {} failed: {} is {:.3e}, at most {:.3e} is allowed", failed.name, failed.meaning, failed.value, failed.limit))
}

/// Warnings that follow from the measures.
fn own_warnings(measures: &Measures, numerics: &Numerics, has_ended: bool) -> Vec<String> {
    let mut warnings = Vec::new();
    let share = numerics.numerical_contact_dissipation_share;
    if share > CONTACT_DISSIPATION_WARNING {
        warnings.push(format!(
            "Numerical contact dissipation is {:.1} % of the initial energy (above {:.0} %): refine the contact surfaces.",
            100.0 * share,
            100.0 * CONTACT_DISSIPATION_WARNING
        ));
    }
    for pair in &measures.pairs {
        let patch = &pair.force.peak.patch;
        if pair.force.contact_span.is_some() && patch.nodes_across < NODES_ACROSS {
            warnings.push(format!(
                "Only {} nodes lie across the contact patch of {} at the peak force (fewer than {NODES_ACROSS}): its area \
                 and the peak pressure are not resolved.",
                patch.nodes_across, pair.name
            ));
        }
        if has_ended && pair.on_tissue && pair.force.is_touching() {
            warnings.push(format!("Contact of {} has not ended: the absorbed energy is not final.", pair.name));
        }
    }
    warnings
}

/// The numbers.
fn results(measures: &Measures, plan: &Plan, mint: Mint) -> Results {
    let impacts = measures.pairs.iter().enumerate().map(|(index, pair)| impact(measures, plan, index, pair, mint));
    Results { impacts: impacts.collect(), tissue: tissue(measures, mint) }
}

fn impact(measures: &Measures, plan: &Plan, index: usize, pair: &PairMeasures, mint: Mint) -> Impact {
    let (force, now) = (&pair.force, pair.force.now());
    let patch = &force.peak.patch;
    let ledger = measures.energy.pairs.get(index).copied().unwrap_or_default();
    Impact {
        pair: pair.name.clone(),
        between: pair.between.clone(),
        on_tissue: pair.on_tissue,
        peak_force_n: mint.quantity(force.peak.force),
        peak_force_time_s: mint.quantity(force.peak.time),
        force_window_s: plan.measures.force_window,
        peak_step_force_n: mint.quantity(force.peak_step.0),
        impulse_n_s: mint.quantity(now.impulse.norm()),
        impulse_vector_n_s: now.impulse.into(),
        contact_duration_s: mint.quantity(force.contact_time),
        contact_span_s: force.contact_span,
        contact_ended: !force.is_touching(),
        patch_area_mm2: mint.quantity(1e6 * patch.area),
        patch_long_axis_mm: mint.quantity(1e3 * patch.axes[0]),
        patch_short_axis_mm: mint.quantity(1e3 * patch.axes[1]),
        largest_patch_area_mm2: mint.quantity(1e6 * force.largest_patch.area),
        nodes_across_patch: [patch.nodes_across, force.largest_patch.nodes_across],
        friction_dissipation_j: mint.quantity(ledger.friction_j),
        numerical_contact_dissipation_j: mint.quantity(ledger.numerical_j),
    }
}

fn tissue(measures: &Measures, mint: Mint) -> Option<Tissue> {
    let (absorbed, stress) = (measures.absorbed.as_ref()?, measures.stress.as_ref()?);
    let split = |a: &super::absorbed_energy::Absorbed| Split {
        strain_j: mint.quantity(a.strain),
        kinetic_j: mint.quantity(a.kinetic),
        recoverable_j: mint.quantity(a.recoverable()),
        dissipated_j: mint.quantity(a.dissipated),
    };
    let significant = stress.exceedances.iter().map(|e| SignificantStress {
        threshold_pa: e.threshold,
        depth_mm: stress.has_skin().then(|| mint.quantity(1e3 * e.depth)),
        depth_time_s: e.depth_time,
        volume_mm3: mint.quantity(1e9 * e.largest_volume),
        volume_at_end_mm3: mint.quantity(1e9 * e.volume),
    });
    let d = &measures.deflection;
    let deflection = Peak { value: d.largest, position: d.position, time: d.time };
    Some(Tissue {
        absorbed_energy_j: mint.quantity(absorbed.now.by_state()),
        absorbed_energy_by_work_j: mint.quantity(absorbed.now.work),
        absorbed_split: split(&absorbed.now),
        peak_absorbed_energy_j: mint.quantity(absorbed.peak.by_state()),
        peak_absorbed_energy_time_s: mint.quantity(absorbed.peak.time),
        peak_absorbed_split: split(&absorbed.peak),
        contact_ended: !measures.pairs.iter().any(|p| p.on_tissue && p.force.is_touching()),
        projectile_loss_j: absorbed.has_projectile().then(|| mint.quantity(absorbed.projectile_loss)),
        significant_stress: significant.collect(),
        peak_von_mises_pa: mint.located(1.0, &stress.von_mises),
        peak_principal_strain: mint.located(1.0, &stress.principal_strain),
        peak_strain_energy_density_j_per_m3: mint.located(1.0, &stress.energy_density),
        deflection_mm: mint.located(1e3, &deflection),
    })
}
