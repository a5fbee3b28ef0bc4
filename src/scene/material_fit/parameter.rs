//! A free parameter of a fit: a number of the constants, by its JSON pointer.

use super::document::{Constants, FitQuestion};
use crate::scene::memories;
use crate::scene::problem::{Pointer, Problem};
use crate::scene::validate::Findings;
use serde_json::{Number, Value};

/// A number that is fitted.
#[derive(Clone, Debug, PartialEq)]
pub struct Parameter {
    /// JSON pointer to it.
    pub pointer: String,
    /// Value at which the iteration starts, in the unit of the parameter.
    pub start: f64,
    /// Whether the other sign is inadmissible: its logarithm is fitted.
    pub has_fixed_sign: bool,
    /// A change that matters, of a parameter that may have either sign.
    pub scale: f64,
}

impl FitQuestion {
    /// The parameters that the fit changes, with their starting values.
    pub fn parameters(&self) -> Vec<Parameter> {
        let constants = self.constants();
        self.free.iter().filter_map(|pointer| Parameter::of(&constants, pointer, self.largest_pa())).collect()
    }
}

impl Parameter {
    /// The parameter at a pointer, `None` if there is no number; `stress` is the size of the measured values [Pa].
    pub(super) fn of(constants: &Constants, pointer: &str, stress: f64) -> Option<Self> {
        let start = written(constants).pointer(pointer)?.as_f64()?;
        let unit = if pointer.ends_with("_pa") { stress } else { 1.0 };
        let scale = if start == 0.0 { unit } else { start.abs() };
        let has_fixed_sign = !constants.admits(pointer, if start == 0.0 { -unit } else { -start });
        Some(Self { pointer: pointer.to_owned(), start, has_fixed_sign, scale })
    }
}

impl Constants {
    /// Problems of the constants in a scene, which takes no steps here: a stiff volume costs nothing.
    pub fn check(&self) -> Vec<Problem> {
        let mut found = Findings::default();
        let root = Pointer::root();
        self.material.check(&root.key("material"), &mut found);
        if let Some(series) = &self.prony_series {
            memories::check(series, self.material.is_split(), &root.key("prony_series"), &mut found);
        }
        found.0.retain(|problem| problem.code != "stiff_volume");
        found.0.into_vec()
    }

    /// Whether another value at a pointer gives no further error, stability of the law apart.
    fn admits(&self, pointer: &str, value: f64) -> bool {
        let is_inadmissible = |p: &&Problem| p.is_error() && p.code != "unstable_law";
        let errors = |constants: &Self| constants.check().iter().filter(is_inadmissible).count();
        self.with_numbers([(pointer, value)]).is_some_and(|other| errors(&other) <= errors(self))
    }

    /// The constants with other numbers at some pointers; `None` where there is no such number, or a value is not finite.
    pub fn with_numbers<'a>(&self, numbers: impl IntoIterator<Item = (&'a str, f64)>) -> Option<Self> {
        let mut document = written(self);
        for (pointer, value) in numbers {
            set_number(&mut document, pointer, value)?;
        }
        serde_json::from_value(document).ok()
    }

    /// JSON pointers to all numbers that a fit may change.
    pub(super) fn pointers(&self) -> Vec<String> {
        let mut found = Vec::new();
        collect(&written(self), &Pointer::root(), &mut found);
        found
    }
}

/// Replaces the number at a pointer.
fn set_number(document: &mut Value, pointer: &str, value: f64) -> Option<()> {
    let place = document.pointer_mut(pointer).filter(|place| place.is_number())?;
    *place = Value::Number(Number::from_f64(value)?);
    Some(())
}

/// Constants that were read can be written.
fn written(constants: &Constants) -> Value {
    serde_json::to_value(constants).unwrap_or_default()
}

/// Ranges of validity are no parameters.
fn collect(value: &Value, here: &Pointer, found: &mut Vec<String>) {
    match value {
        Value::Number(_) => found.push(here.as_str().to_owned()),
        Value::Array(items) => {
            items.iter().enumerate().for_each(|(i, item)| collect(item, &here.index(i), found));
        }
        Value::Object(members) => members
            .iter()
            .filter(|(name, _)| *name != "valid_to")
            .for_each(|(name, member)| collect(member, &here.key(name), found)),
        _ => {}
    }
}
