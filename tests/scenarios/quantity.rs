//! The words in which `expected.json` asks for numbers.

use crate::seen::{Row, Seen};
use contuse::mechanics::tensor::Vec3;
use contuse::step::Outcome;
use serde::Deserialize;

/// A number of a run; `at_s` is a time, the end by default, `pair` the index of a contact pair, the first by default.
#[derive(Debug, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum Quantity {
    /// Number of steps.
    Steps,
    /// Simulated time reached [s].
    TimeReachedS,
    /// Largest error of the energy balance [-].
    BalanceError,
    /// Smallest Jacobian [-].
    SmallestJacobian,
    /// Kinetic and strain energy at the start [J].
    InitialEnergyJ,
    /// What is missing of the initial kinetic and strain energy at the end, as a fraction of it [-].
    EnergyLostFraction,
    /// Numerical contact dissipation over the energy that errors are measured against [-].
    NumericalContactFraction {
        /// When [s].
        at_s: Option<f64>,
    },
    /// Friction work over the mass of a body [J/kg].
    FrictionWorkJPerKg {
        /// Which.
        body: String,
    },
    /// Length of the impulse of a pair so far [N s].
    ImpulseNS {
        /// When [s].
        at_s: Option<f64>,
        /// Which.
        #[serde(default)]
        pair: usize,
    },
    /// Mean velocity of a body along an axis [m/s].
    VelocityMPerS {
        /// Which.
        body: String,
        /// 0, 1, 2 for x, y, z.
        axis: usize,
        /// When [s].
        at_s: Option<f64>,
    },
    /// How far the centre of mass of a body has come along an axis [m].
    TravelM {
        /// Which.
        body: String,
        /// 0, 1, 2 for x, y, z.
        axis: usize,
        /// When [s].
        at_s: Option<f64>,
    },
    /// Time of the first step with a contact force [s].
    ContactStartS,
    /// Time of the last step with a contact force [s].
    ContactEndS,
    /// How often contact opened.
    Openings,
    /// Mean contact force between two times [N].
    MeanForceN {
        /// From [s].
        from_s: f64,
        /// To [s].
        to_s: f64,
    },
    /// Standard deviation of the contact force of the steps between two times [N].
    ForceDeviationN {
        /// From [s].
        from_s: f64,
        /// To [s].
        to_s: f64,
    },
    /// Largest contact force of a step [N]: not a converged number in general.
    LargestStepForceN,
    /// The farthest that any node of a set moves after a time [m].
    CreepM {
        /// Body.
        body: String,
        /// Node set.
        set: String,
        /// From [s].
        from_s: f64,
    },
    /// Smallest mean distance of a node set from the centre of mass of its body, over that at rest [-].
    SmallestStretch {
        /// Body.
        body: String,
        /// Node set.
        set: String,
    },
    /// Twice the time about which the mean distance of a node set is its own mirror image: the mean of the two times at
    /// which it first passes its length at rest, there and back [s].
    BreathingPeriodS {
        /// Body.
        body: String,
        /// Node set.
        set: String,
    },
}

impl Quantity {
    /// The node set that it needs: body and name.
    pub fn node_set(&self) -> Option<(&str, &str)> {
        match self {
            Self::CreepM { body, set, .. }
            | Self::SmallestStretch { body, set }
            | Self::BreathingPeriodS { body, set } => Some((body, set)),
            _ => None,
        }
    }

    /// The number.
    pub fn eval(&self, seen: &Seen, outcome: &Outcome) -> f64 {
        let first = &seen.rows[0];
        match self {
            Self::Steps => outcome.steps as f64,
            Self::TimeReachedS => outcome.time_s,
            Self::BalanceError => outcome.balance_error,
            Self::SmallestJacobian => outcome.smallest_jacobian,
            Self::InitialEnergyJ => first.energy.initial_total_j,
            Self::EnergyLostFraction => {
                let kept =
                    |row: &Row| row.energy.bodies.iter().map(|b| b.kinetic_j + b.strain_j).sum::<f64>();
                1.0 - seen.at(None, kept) / first.energy.initial_total_j
            }
            Self::NumericalContactFraction { at_s } => {
                seen.at(*at_s, |row| row.energy.numerical_contact_j() / row.energy.turnover_j)
            }
            Self::FrictionWorkJPerKg { body } => {
                let work = |row: &Row| row.energy.pairs.values().map(|p| p.friction_j).sum::<f64>();
                seen.at(None, work) / seen.mass[seen.body(body)]
            }
            Self::ImpulseNS { at_s, pair } => {
                seen.at(*at_s, |row| Vec3::from(row.energy.pairs[*pair].impulse_n_s).norm())
            }
            Self::VelocityMPerS { body, axis, at_s } => {
                let b = seen.body(body);
                seen.at(*at_s, |row| row.velocity[b][*axis])
            }
            Self::TravelM { body, axis, at_s } => {
                let b = seen.body(body);
                seen.at(*at_s, |row| row.center[b][*axis]) - first.center[b][*axis]
            }
            Self::ContactStartS => touching(seen).next().map_or(f64::NAN, |row| row.time),
            Self::ContactEndS => touching(seen).last().map_or(f64::NAN, |row| row.time),
            Self::Openings => {
                seen.rows.windows(2).filter(|w| force(&w[0]) > 0.0 && force(&w[1]) == 0.0).count() as f64
            }
            Self::MeanForceN { from_s, to_s } => {
                let impulse = |t| seen.at(Some(t), |row| Vec3::from(row.energy.pairs[0].impulse_n_s).norm());
                (impulse(*to_s) - impulse(*from_s)) / (to_s - from_s)
            }
            Self::ForceDeviationN { from_s, to_s } => {
                let within = seen.rows.iter().filter(|row| (*from_s..*to_s).contains(&row.time));
                let forces: Vec<f64> = within.map(force).collect();
                let mean = forces.iter().sum::<f64>() / forces.len() as f64;
                (forces.iter().map(|f| (f - mean).powi(2)).sum::<f64>() / forces.len() as f64).sqrt()
            }
            Self::LargestStepForceN => seen.rows.iter().map(force).fold(0.0, f64::max),
            Self::CreepM { body, set, from_s } => {
                let place = seen.set(body, set);
                let later = || seen.rows.iter().filter(|row| row.time >= *from_s);
                let start = later().next().map(|row| &row.sets[place]);
                let moved = |row: &Row| distance_moved(&row.sets[place], start.unwrap());
                later().map(moved).fold(0.0, f64::max)
            }
            Self::SmallestStretch { body, set } => {
                stretches(seen, body, set).map(|(_, s)| s).fold(f64::MAX, f64::min)
            }
            Self::BreathingPeriodS { body, set } => {
                breathing_period(&stretches(seen, body, set).collect::<Vec<_>>())
            }
        }
    }
}

/// Length of the sum of all contact forces of a step [N].
fn force(row: &Row) -> f64 {
    row.force.iter().sum::<Vec3>().norm()
}

fn touching(seen: &Seen) -> impl Iterator<Item = &Row> {
    seen.rows.iter().filter(|row| force(row) > 0.0)
}

fn distance_moved(a: &[Vec3], b: &[Vec3]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b).norm()).fold(0.0, f64::max)
}

/// Time and mean distance of a set from the centre, over that at rest.
fn stretches<'a>(seen: &'a Seen, body: &str, set: &str) -> impl Iterator<Item = (f64, f64)> + 'a {
    let (b, place) = (seen.body(body), seen.set(body, set));
    let mean = |nodes: &[Vec3], center: Vec3| nodes.iter().map(|x| (x - center).norm()).sum::<f64>();
    let center = seen.at_rest[place].iter().sum::<Vec3>() / seen.at_rest[place].len() as f64;
    let rest = mean(&seen.at_rest[place], center);
    seen.rows.iter().map(move |row| (row.time, mean(&row.sets[place], row.center[b]) / rest))
}

fn breathing_period(stretches: &[(f64, f64)]) -> f64 {
    let mut crossings = stretches.windows(2).filter(|w| (w[0].1 - 1.0) * (w[1].1 - 1.0) < 0.0).map(|w| {
        let ((t0, s0), (t1, s1)) = (w[0], w[1]);
        t0 + (t1 - t0) * (1.0 - s0) / (s1 - s0)
    });
    match (crossings.next(), crossings.next()) {
        (Some(there), Some(back)) => there + back,
        _ => f64::NAN,
    }
}
