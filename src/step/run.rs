//! The time loop of a run.

use super::energy::{Energy, turnover_in_words};
use super::failure::{Failure, FailureCause, Stop};
use super::frame::{Ending, Frame, LOOKS, Outcome, Recorder, RecorderError};
use super::integrator::{preloader, stepper};
use super::interrupt::{Ask, Interrupt};
use super::phase::Phase;
use super::state::State;
use super::stepper::Stepper;
use super::unfold::Unfolding;
use crate::mechanics::force::Threads;
use crate::mechanics::tensor::Vec3;
use crate::plan::{DynamicRelaxation, Integrator, Plan};

/// Largest negative numerical contact dissipation over the energy scale: beyond it contact creates energy.
const LARGEST_CONTACT_CREATION: f64 = 1e-3;
/// Final fraction of the relaxation time that has the friction of the scene [-].
const RELEASING: f64 = 1.0 / 3.0;
/// Fraction of the energy scale above which numerical dissipation raises a warning, by contact or by the time
/// integrator.
const NOTABLE_LOSS: f64 = 0.02;

/// How to run a plan.
pub struct RunOptions<'a> {
    /// Worker threads of this run; the bits of the result do not depend on it.
    pub threads: usize,
    /// Called before every step, and between the iterations of an implicit one.
    pub interrupt: Ask<'a>,
}

/// Runs a plan to its end, or to a diagnosed failure: of a symmetric scene the sector, of which recorders receive the whole. Recorders are
/// started, fed and finished on every path.
pub fn run(plan: &Plan, options: &RunOptions, recorders: &mut [&mut dyn Recorder]) -> (Outcome, State) {
    let Some(sector) = &plan.sector else { return run_from(plan, State::new(plan), options, recorders) };
    let mut unfolding = Unfolding::new(plan, sector, recorders);
    let (outcome, state) = run_from(&sector.plan, State::new(&sector.plan), options, &mut [&mut unfolding]);
    unfolding.end(outcome, &state)
}

/// Runs all of a plan, starting from a state: a restart gives the same bits as an uninterrupted run.
pub fn run_from(
    plan: &Plan,
    mut state: State,
    options: &RunOptions,
    recorders: &mut [&mut dyn Recorder],
) -> (Outcome, State) {
    let mut warnings = Vec::new();
    let (stepper, ending) = match start(plan, &state, options, recorders) {
        Ok(mut stepper) => {
            let driven = drive(plan, stepper.as_mut(), &mut state, options, recorders, &mut warnings);
            (Some(stepper), driven.unwrap_or_else(|failure| Ending::Failed { failure }))
        }
        Err(failure) => (None, Ending::Failed { failure }),
    };
    let mut outcome = conclude(plan, &state, stepper.as_deref(), ending);
    outcome.warnings.splice(0..0, warnings);
    finish(plan, outcome, state, recorders)
}

fn start<'p>(
    plan: &'p Plan,
    state: &State,
    options: &RunOptions,
    recorders: &mut [&mut dyn Recorder],
) -> Result<Box<dyn Stepper + 'p>, Failure> {
    for recorder in recorders.iter_mut() {
        recorder.start(plan).map_err(|e| recording_failed(state, &e))?;
    }
    let internal = |text: String| Failure::new(state, FailureCause::Internal, text);
    let threads = worker_threads(options).map_err(internal)?;
    stepper(plan, threads).map_err(|e| Failure::new(state, FailureCause::Internal, format!("There is {e}.")))
}

fn worker_threads(options: &RunOptions) -> Result<Threads, String> {
    Threads::new(options.threads.max(1))
        .map_err(|e| format!("The operating system refused to start worker threads: {e}."))
}

fn finish(
    plan: &Plan,
    mut outcome: Outcome,
    state: State,
    recorders: &mut [&mut dyn Recorder],
) -> (Outcome, State) {
    for recorder in recorders.iter_mut() {
        if let Err(error) = recorder.finish(plan, &outcome)
            && !matches!(outcome.ending, Ending::Failed { .. })
        {
            outcome.ending = Ending::Failed { failure: recording_failed(&state, &error) };
        }
    }
    (outcome, state)
}

/// Relaxes or preloads the plan if requested, then steps to the end.
fn drive(
    plan: &Plan,
    stepper: &mut dyn Stepper,
    state: &mut State,
    options: &RunOptions,
    recorders: &mut [&mut dyn Recorder],
    warnings: &mut Vec<String>,
) -> Result<Ending, Failure> {
    // Dynamic relaxation and preload precede the first step.
    if let (Some(relaxation), 0) = (plan.dynamic_relaxation, state.step)
        && let Some(interrupt) = relax(plan, stepper, state, relaxation, options)?
    {
        return interrupted(interrupt, plan, state);
    }
    if state.step == 0
        && let Some(interrupt) = preload(plan, state, options, warnings)?
    {
        return interrupted(interrupt, plan, state);
    }
    let mut last_look = f64::NEG_INFINITY;
    loop {
        // Solve the step at t_n and check its energy balance.
        let interrupt = (options.interrupt)();
        let target = next_target(plan, state.time);
        let at_end = state.time >= plan.end_time;
        let longest = target.map_or(0.0, |t| t - state.time);
        if let Some(interrupt) = solve(stepper, state, Phase::Running, longest, options.interrupt)? {
            return interrupted(interrupt, plan, state);
        }
        stepper.balance(state);
        let verdict = gate(plan, state, stepper.energy());
        // Complete frames are due at field times and look times.
        let is_field_time =
            plan.field_times.contains(&state.time) || at_end || interrupt.is_some() || verdict.is_err();
        // The first step in each of the equal parts of the run, unless the part has a field time.
        let part = |time: f64| (LOOKS * time / plan.end_time).floor();
        let look = part(state.time);
        let has_field_time = target.is_some_and(|target| part(target) <= look);
        let is_look_time = is_field_time || (look > last_look && !has_field_time);
        if is_look_time {
            last_look = look;
            stepper.note_history();
        }
        let (contacts, reactions) = stepper.contacts();
        let frame = Frame {
            plan,
            time: state.time,
            step: state.step,
            u: &state.u,
            v: &state.v,
            v_after: stepper.v_after(state),
            history: if is_look_time { stepper.history() } else { &[] },
            erosion: &state.erosion,
            orientations: &state.orientations,
            contacts,
            reactions,
            mean_step: stepper.mean_step(state),
            energy: stepper.energy(),
            is_field_time,
            is_look_time,
        };
        for recorder in recorders.iter_mut() {
            recorder.record(&frame).map_err(|e| recording_failed(state, &e))?;
        }
        // A failed gate or an interruption ends the run after its frame is recorded.
        verdict?;
        if at_end {
            return Ok(Ending::Finished);
        }
        if let Some(interrupt) = interrupt {
            return interrupted(interrupt, plan, state);
        }
        stepper.advance(state, Phase::Running);
        snap(state, target);
    }
}

/// Solves a step; returns the reason if it was interrupted.
fn solve(
    stepper: &mut dyn Stepper,
    state: &State,
    phase: Phase,
    longest: f64,
    interrupt: Ask,
) -> Result<Option<Interrupt>, Failure> {
    match stepper.solve(state, phase, longest, interrupt) {
        Ok(()) => Ok(None),
        Err(Stop::Interrupted(interrupt)) => Ok(Some(interrupt)),
        Err(Stop::Failed(failure)) => Err(failure),
    }
}

/// Dynamic relaxation: gravity and damping at full stick, finally with the friction of the scene, until the relaxation
/// time is over; then the clock starts at rest. Bodies with an initial velocity stay in their initial position.
fn relax(
    plan: &Plan,
    stepper: &mut dyn Stepper,
    state: &mut State,
    relaxation: DynamicRelaxation,
    options: &RunOptions,
) -> Result<Option<Interrupt>, Failure> {
    // Moving bodies are held in their initial positions.
    let released_v = std::mem::replace(&mut state.v, vec![Vec3::zeros(); plan.node_count()]);
    state.time = -relaxation.duration;
    let flying = plan.bodies.iter().filter(|body| body.flight_velocity != Vec3::zeros());
    let waiting: Vec<(usize, Vec3)> =
        flying.flat_map(|body| body.nodes.clone()).map(|n| (n as usize, state.u[n as usize])).collect();
    while state.time < 0.0 {
        if let Some(interrupt) = (options.interrupt)() {
            return Ok(Some(interrupt));
        }
        let sticks = state.time < -RELEASING * relaxation.duration;
        let phase = if sticks {
            Phase::DynamicRelaxation(relaxation)
        } else {
            Phase::FrictionalRelaxation(relaxation)
        };
        if let Some(interrupt) = solve(stepper, state, phase, -state.time, options.interrupt)? {
            return Ok(Some(interrupt));
        }
        stepper.advance(state, phase);
        for &(node, place) in &waiting {
            (state.u[node], state.v[node]) = (place, Vec3::zeros());
        }
        snap(state, Some(0.0));
    }
    start_clock(plan, state, released_v);
    Ok(None)
}

/// Quasi-static preload: increases the loads to their values at the start of the run; then the clock starts at rest.
fn preload(
    plan: &Plan,
    state: &mut State,
    options: &RunOptions,
    warnings: &mut Vec<String>,
) -> Result<Option<Interrupt>, Failure> {
    let internal = |text: String| Failure::new(state, FailureCause::Internal, text);
    let threads = worker_threads(options).map_err(internal)?;
    let made = preloader(plan, threads).map_err(|e| internal(format!("There is {e}.")))?;
    let (Some(mut stepper), Some(preload)) = (made, &plan.preload) else { return Ok(None) };
    let released_v = std::mem::replace(&mut state.v, vec![Vec3::zeros(); plan.node_count()]);
    state.time = -1.0;
    let mut is_last = false;
    // The final load step, at constant loads, removes the gaps left by linearisation.
    while !is_last {
        if let Some(interrupt) = (options.interrupt)() {
            return Ok(Some(interrupt));
        }
        is_last = state.time >= 0.0;
        let longest = if is_last { preload.step } else { -state.time };
        if let Some(interrupt) = solve(&mut *stepper, state, Phase::Preloading, longest, options.interrupt)? {
            return Ok(Some(interrupt));
        }
        stepper.advance(state, Phase::Preloading);
        snap(state, (!is_last).then_some(0.0));
    }
    warnings.extend(stepper.warnings().into_iter().map(|warning| format!("Preload: {warning}")));
    start_clock(plan, state, released_v);
    Ok(None)
}

/// State at the start of the clock: deformation from relaxation or preload is kept, and the bodies receive their
/// velocities.
fn start_clock(plan: &Plan, state: &mut State, released_v: Vec<Vec3>) {
    *state = State {
        u: std::mem::take(&mut state.u),
        v: released_v,
        orientations: std::mem::take(&mut state.orientations),
        ..State::new(plan)
    };
}

/// Next time that must be met exactly; `None` at the end.
fn next_target(plan: &Plan, time: f64) -> Option<f64> {
    plan.field_times.iter().copied().find(|t| *t > time)
}

/// Sets the clock to the target if they differ by rounding.
fn snap(state: &mut State, target: Option<f64>) {
    if let Some(target) = target
        && (target - state.time).abs() <= 1e-6 * state.last_step
    {
        state.time = target;
    }
}

/// Energy gate: the balance, and no energy created by contact.
fn gate(plan: &Plan, state: &State, energy: &Energy) -> Result<(), Failure> {
    let limit = plan.energy_gate;
    let numerical = energy.least_contact_loss_j(plan.is_static());
    let message = if !(energy.balance_error <= limit) {
        let imbalance = energy.total_j - energy.initial_total_j - energy.external_work_j;
        format!(
            "The error of the energy balance is {:.2} % (limit {:.2} %): {imbalance:+.3e} J against a scale of {:.3e} J.",
            100.0 * energy.balance_error,
            100.0 * limit,
            energy.scale_j
        )
    } else if numerical < -LARGEST_CONTACT_CREATION * energy.scale_j {
        format!(
            "Contact created {:.3e} J of energy numerically, more than {:.1} % of {:.3e} J.",
            -numerical,
            100.0 * LARGEST_CONTACT_CREATION,
            energy.scale_j
        )
    } else if !plan.is_static() && energy.algorithmic_j() < -limit * energy.scale_j {
        format!(
            "The time integrator created {:.3e} J of energy, more than {:.2} % of {:.3e} J.",
            -energy.algorithmic_j(),
            100.0 * limit,
            energy.scale_j
        )
    } else {
        return Ok(());
    };
    let cause = FailureCause::EnergyGate;
    Err(Failure::new(state, cause, message))
}

fn interrupted(interrupt: Interrupt, plan: &Plan, state: &State) -> Result<Ending, Failure> {
    match interrupt {
        Interrupt::Cancel => Ok(Ending::Cancelled),
        Interrupt::Deadline => Err(Failure::deadline(plan, state)),
        Interrupt::Steps { most } => {
            let message = format!("The budget of {most} steps was exhausted at t = {:.4e} s.", state.time);
            Err(Failure::new(state, FailureCause::Budget, message))
        }
        Interrupt::RecordingBytes { most } => {
            let message =
                format!("The budget of {most} bytes of recording was exhausted at t = {:.4e} s.", state.time);
            Err(Failure::new(state, FailureCause::Budget, message))
        }
    }
}

fn recording_failed(state: &State, error: &RecorderError) -> Failure {
    // Includes the underlying errors: only the operating system knows that the disk is full.
    let mut message = error.to_string();
    let mut source = std::error::Error::source(error);
    while let Some(reason) = source {
        let said = reason.to_string();
        if !message.contains(&said) {
            message = format!("{message}: {said}");
        }
        source = reason.source();
    }
    Failure::new(state, FailureCause::RecordingFailed, message + ".")
}

fn conclude(plan: &Plan, state: &State, stepper: Option<&dyn Stepper>, ending: Ending) -> Outcome {
    let mut outcome = Outcome {
        ending,
        time_s: state.time,
        steps: state.step,
        smallest_step_s: 0.0,
        smallest_jacobian: 1.0,
        element_steps: state.step * plan.element_count() as u64,
        evaluated_element_steps: 0,
        balance_error: 0.0,
        most_contacts: 0,
        warnings: Vec::new(),
    };
    // Extremes of the run.
    if let Some(stepper) = stepper {
        let extremes = stepper.extremes();
        outcome.smallest_step_s =
            if extremes.smallest_step.is_finite() { extremes.smallest_step } else { 0.0 };
        outcome.smallest_jacobian =
            if extremes.smallest_j.is_finite() { 1.0 + extremes.smallest_j } else { 1.0 };
        outcome.most_contacts = extremes.most_contacts;
        outcome.balance_error = extremes.balance_error;
        outcome.evaluated_element_steps = extremes.evaluated_elements;
        let (count, residual) = stepper.unconverged();
        if count > 0 {
            outcome.warnings.push(format!(
                "The contact forces of {count} steps are less accurate than required: the contact solver ended above its tolerance, at a \
                 residual of {residual:.1e} of the velocities of contact at most."
            ));
        }
    }
    // Warnings of the stepper and of large numerical losses.
    outcome.warnings.extend(stepper.iter().flat_map(|stepper| stepper.warnings()));
    let lost: f64 = state.ledger.pairs.values().map(|p| p.numerical_j).sum();
    let scale = state.ledger.turnover(plan);
    let whole = turnover_in_words(state.ledger.scale(plan), scale);
    if !plan.is_static() && lost > NOTABLE_LOSS * scale && scale > 0.0 {
        let remedy = match plan.integrator {
            Integrator::Explicit(_) => "a finer mesh at the contact reduces it",
            Integrator::Implicit(_) => "shorter steps and a finer mesh at the contact reduce it",
        };
        outcome.warnings.push(format!(
            "The computation of contact lost {:.1} % of {whole}: {remedy}.",
            100.0 * lost / scale
        ));
    }
    let missed = state.ledger.algorithmic.iter().sum::<f64>() + if plan.is_static() { lost } else { 0.0 };
    if !plan.is_static() && missed > NOTABLE_LOSS * scale && scale > 0.0 {
        outcome.warnings.push(format!(
            "The time integration lost {:.1} % of {whole}, which counts as dissipated by the bodies: shorter steps, \
             `integrator.theta` closer to 0.5 or `integrator.energy_momentum` reduce it.",
            100.0 * missed / scale
        ));
    }
    if plan.is_static() && missed.abs() > plan.energy_gate * scale && scale > 0.0 {
        outcome.warnings.push(format!(
            "The energy balance misses {:.1} % of the energy of the load: the work of loads and reactions is taken from the ends of the load \
             steps, and smaller ones follow it closer.",
            100.0 * missed / scale
        ));
    }
    outcome
}
