//! The paths of `contuse material --path`.

use super::CliError;
use crate::mechanics::material;
use clap::ValueEnum;
use serde::Serialize;

/// A deformation path starting at rest.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum PathName {
    /// Stretch along x with free sides.
    Uniaxial,
    /// Equal stretch along x and y, the third side free.
    Equibiaxial,
    /// Simple shear x += γ y, the third side free.
    Shear,
}

/// A requested path with its values.
pub(super) struct PathRequest {
    pub name: PathName,
    pub values: Vec<f64>,
}

impl PathRequest {
    /// So many points on a path between two values; `None` for the usual ones.
    ///
    /// # Errors
    /// If an end is no deformation.
    pub fn new(name: PathName, [from, to]: [Option<f64>; 2], points: u32) -> Result<Self, CliError> {
        let (rest, usual) = if name == PathName::Shear { (0.0, 0.5) } else { (1.0, 1.5) };
        let (from, to) = (from.unwrap_or(rest), to.unwrap_or(usual));
        let possible = |value: f64| value.is_finite() && (name == PathName::Shear || value > 0.0);
        if !possible(from) || !possible(to) {
            return Err(CliError::Usage(format!(
                "--from {from} --to {to}: a stretch is a number > 0, a shear any number"
            )));
        }
        let last = f64::from(points.saturating_sub(1).max(1));
        let values = (0..points).map(|i| from + (to - from) * f64::from(i) / last).collect();
        Ok(Self { name, values })
    }
}

impl PathName {
    /// The path itself.
    pub fn path(self) -> material::Path {
        match self {
            Self::Uniaxial => material::Path::Uniaxial,
            Self::Equibiaxial => material::Path::Equibiaxial,
            Self::Shear => material::Path::SimpleShear,
        }
    }
    /// Name of the value along it.
    pub fn value_name(self) -> &'static str {
        if self == Self::Shear { "shear" } else { "stretch" }
    }
    /// Title of a picture.
    pub fn title(self) -> &'static str {
        match self {
            Self::Uniaxial => "Uniaxial stress along x",
            Self::Equibiaxial => "Equibiaxial stretch in the plane x, y",
            Self::Shear => "Simple shear in the plane x, y",
        }
    }
    /// Label of the axis of values.
    pub fn axis(self) -> &'static str {
        if self == Self::Shear { "amount of shear γ [-]" } else { "stretch λ [-]" }
    }
    /// Stress components to plot, with their row and column.
    pub fn components(self) -> &'static [(&'static str, (usize, usize))] {
        match self {
            Self::Uniaxial => &[("xx", (0, 0))],
            Self::Equibiaxial => &[("xx", (0, 0)), ("yy", (1, 1))],
            Self::Shear => &[("xy", (0, 1))],
        }
    }
}
