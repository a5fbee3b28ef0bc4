//! Parses parameters, cases and limits from flags.

use crate::measure::QuantityOfInterest;
use crate::study::what_if::document::{
    CaseDocument, Change, Layer, LimitDocument, LimitMeasure, ParameterDocument,
};
use std::collections::BTreeMap;

/// Parses a parameter with its range, as in "speed=80..120".
pub(super) fn parameter(text: &str) -> Result<ParameterDocument, String> {
    let (name, range) = text.split_once('=').ok_or("write PARAMETER=LOW..HIGH, such as speed=80..120")?;
    let (low, high) = range.split_once("..").ok_or("write the range as LOW..HIGH, such as 80..120")?;
    Ok(ParameterDocument { low: Some(number(low)?), high: Some(number(high)?), ..named(name)? })
}

/// Parses "speed=120,fat=0.012", with the parameters that it names.
pub(super) fn case(text: &str) -> Result<(Vec<ParameterDocument>, CaseDocument), String> {
    let (mut parameters, mut set) = (Vec::new(), BTreeMap::new());
    for setting in text.split(',') {
        let (name, value) = setting.split_once('=').ok_or("write PARAMETER=VALUE,PARAMETER=VALUE")?;
        parameters.push(named(name)?);
        if set.insert(name.to_owned(), number(value)?).is_some() {
            return Err(format!(
                "{name:?} has two values in one case: give each of them a --case of its own"
            ));
        }
    }
    Ok((parameters, CaseDocument { name: None, set }))
}

/// Adds the parameters of flags to those of a file: new ranges, and parameters named only in cases.
pub(super) fn add_parameters<'a>(
    known: &mut Vec<ParameterDocument>,
    vary: &[ParameterDocument],
    of_cases: impl Iterator<Item = &'a ParameterDocument>,
) -> Result<(), String> {
    let of_file = known.len();
    for parameter in vary {
        let name = &parameter.name;
        match known.iter().position(|known| known.name == *name) {
            None => known.push(parameter.clone()),
            Some(index) if index < of_file => {
                return Err(format!(
                    "--vary {name}: the question of the file has a parameter of this name: change its range there, or name one of them \
                     otherwise"
                ));
            }
            Some(_) => return Err(format!("--vary {name} is given twice: a parameter has one range")),
        }
    }
    for parameter in of_cases {
        if known.iter().all(|known| known.name != parameter.name) {
            known.push(parameter.clone());
        }
    }
    Ok(())
}

/// Parses "speed:peak_force_n<=2000" or "speed:von_mises@0.01<=30e3".
pub(super) fn limit(text: &str) -> Result<LimitDocument, String> {
    let form =
        "write PARAMETER:NUMBER<=LIMIT, such as speed:peak_force_n<=2000 or speed:von_mises@0.01<=30e3";
    let (left, at_most) = text.split_once("<=").ok_or(form)?;
    // From the right: parameters may contain a colon.
    let (parameter, measure) = left.rsplit_once(':').ok_or(form)?;
    let measure = match measure.strip_prefix("von_mises@") {
        Some(depth) => LimitMeasure::VonMisesPaBelowDepthM(number(depth)?),
        None => LimitMeasure::Quantity(QuantityOfInterest::from_name(measure).ok_or_else(|| {
            format!(
                "there is no number {measure:?}; there are {} and von_mises@DEPTH",
                QuantityOfInterest::ALL.map(QuantityOfInterest::name).join(", ")
            )
        })?),
    };
    Ok(LimitDocument { parameter: parameter.into(), measure, at_most: number(at_most)?, tolerance: 1e-3 })
}

fn number(text: &str) -> Result<f64, String> {
    text.trim().parse().map_err(|_| format!("{text:?} is not a number"))
}

/// A parameter with this name, without a range.
fn named(name: &str) -> Result<ParameterDocument, String> {
    let change = match name {
        "speed" => Change::Speed { body: None },
        "mass" => Change::Mass { body: None },
        "around" => Change::ImpactAround { body: None, limb: None },
        "along" => Change::ImpactAlong { body: None, limb: None },
        "fat" => Change::LayerThickness { layer: Layer::Fat, limb: None },
        "skin" => Change::LayerThickness { layer: Layer::Skin, limb: None },
        "friction" => Change::Friction { between: None },
        pointer if pointer.starts_with('/') => Change::Number { pointer: pointer.into() },
        "over:x" => over_the_surface([1.0, 0.0, 0.0]),
        "over:y" => over_the_surface([0.0, 1.0, 0.0]),
        "over:z" => over_the_surface([0.0, 0.0, 1.0]),
        other => match other.strip_prefix("stiffness:").and_then(|place| place.split_once('/')) {
            Some((body, part)) => Change::StiffnessFactor { body: body.into(), part: part.into() },
            None => {
                return Err(format!(
                    "there is no parameter {name:?}; there are speed, mass, around, along, over:x, over:y, over:z, fat, skin, \
                     friction, stiffness:BODY/PART, and JSON pointers such as /end_time_s"
                ));
            }
        },
    };
    Ok(ParameterDocument { name: name.into(), change, low: None, high: None, distribution: None })
}

fn over_the_surface(along: [f64; 3]) -> Change {
    Change::ImpactOffset { body: None, target: None, along }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn flags_are_read() {
        let speed = parameter("speed=80..1.2e2").unwrap();
        assert_eq!(
            (speed.change, speed.low, speed.high),
            (Change::Speed { body: None }, Some(80.0), Some(120.0))
        );
        let over = parameter("over:y=-0.01..0.02").unwrap();
        assert_eq!((over.change, over.low), (over_the_surface([0.0, 1.0, 0.0]), Some(-0.01)));
        let (parameters, case) = case("fat=0.01,stiffness:thigh/fat=1.5").unwrap();
        assert_eq!(
            parameters[1].change,
            Change::StiffnessFactor { body: "thigh".into(), part: "fat".into() }
        );
        assert!((case.set["fat"] - 0.01).abs() < 1e-15);
        let limit = limit("stiffness:thigh/fat:von_mises@0.01<=30e3").unwrap();
        assert_eq!(limit.parameter, "stiffness:thigh/fat");
        assert_eq!((limit.measure, limit.at_most), (LimitMeasure::VonMisesPaBelowDepthM(0.01), 30e3));
        for wrong in ["speed", "speed=1", "speed=a..b", "sped=1..2"] {
            assert!(parameter(wrong).is_err());
        }
        assert!(super::limit("speed:force<=1").is_err());
    }

    #[test]
    fn what_is_said_twice_is_refused() {
        assert!(case("speed=1,speed=2").unwrap_err().contains("two values"));
        let add = |file: &[&str], vary: &[&str], cases: &[&str]| {
            let mut known: Vec<_> = file.iter().map(|text| parameter(text).unwrap()).collect();
            let vary: Vec<_> = vary.iter().map(|text| parameter(text).unwrap()).collect();
            let of_cases: Vec<_> = cases.iter().flat_map(|text| case(text).unwrap().0).collect();
            add_parameters(&mut known, &vary, of_cases.iter())?;
            Ok::<_, String>(known.iter().map(|known| known.name.clone()).collect::<Vec<_>>())
        };
        assert!(add(&["speed=1..2"], &["speed=1..2"], &[]).unwrap_err().contains("of the file"));
        assert!(add(&[], &["fat=1..2", "fat=2..3"], &[]).unwrap_err().contains("twice"));
        let all = add(&["speed=1..2"], &["fat=1..2"], &["speed=3,fat=1", "skin=2", "skin=3"]);
        assert_eq!(all.unwrap(), ["speed", "fat", "skin"]);
    }
}
