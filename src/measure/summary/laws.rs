//! Laws used beyond their fitted range, and results withheld beyond their limits.

use super::super::law_range::{LawRanges, PartRange};
use super::super::stress_depth::StressDepth;
use super::written::{number, seconds, volume};
use crate::mechanics::material::Given;
use serde::Serialize;

/// Fraction of a part's volume outside the fitted range above which it is reported [-].
const NOTABLE_FRACTION: f64 = 1e-3;

/// Stretches within this distance of 1 are small strains, where laws hardly differ [-].
const SMALL: f64 = 0.1;

/// Fraction of a part's volume that is always slower than the slowest test, above which it is reported [-]: tissue far from an impact is slow in
/// any scene, and a part of which most is has a stiffness that its tests do not show.
const MOSTLY: f64 = 0.5;

/// A part whose law was used beyond its fitted range.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct LawRange {
    /// Name of the body, as in the scene.
    pub body: String,
    /// Name of the part, as in the scene.
    pub part: String,
    /// Least and largest principal stretch at any look time [-].
    pub stretch: [f64; 2],
    /// Fitted range of the stretch [-].
    pub fitted_stretch: [f64; 2],
    /// Least and largest volume ratio J [-].
    pub jacobian: [f64; 2],
    /// Fitted range of J [-].
    pub fitted_jacobian: [f64; 2],
    /// Largest fraction of the part's volume outside the fitted range [-].
    pub fraction_outside: f64,
    /// First look time with any volume outside [s].
    pub outside_since_s: f64,
    /// Largest fraction of the part's volume beyond the limit of the law [-].
    pub fraction_beyond_limit: f64,
    /// Which ranges the scene or the set of its library gives; the others are those usual for the law.
    #[serde(skip)]
    pub given: Given,
}

/// All parts whose law was used beyond its fitted range, in the order of the plan.
pub(super) fn left_laws(ranges: &LawRanges) -> Vec<LawRange> {
    let of = |part: &PartRange| {
        Some(LawRange {
            body: part.body.clone(),
            part: part.part.clone(),
            stretch: part.stretch,
            fitted_stretch: part.validity.fitted.stretch,
            jacobian: part.jacobian,
            fitted_jacobian: part.validity.fitted.jacobian,
            fraction_outside: part.fraction(&part.left),
            outside_since_s: part.left.since?,
            fraction_beyond_limit: part.fraction(&part.beyond),
            given: part.validity.given,
        })
    };
    ranges.parts.iter().filter_map(of).collect()
}

impl LawRange {
    /// "fat (thigh) in 3.2 % of its volume from 40 µs on (stretch 0.45 to 1.6, fitted 0.60 to 1.5)": what left its range; ranges that are
    /// usual for the law are not called fitted.
    fn in_words(&self) -> String {
        let between = |[from, to]: [f64; 2]| format!("{} to {}", number(from), number(to));
        let mut what = Vec::new();
        for (name, seen, range, is_given) in [
            ("stretch", self.stretch, self.fitted_stretch, self.given.stretch),
            ("volume ratio", self.jacobian, self.fitted_jacobian, self.given.jacobian),
        ] {
            if seen[0] < range[0] || seen[1] > range[1] {
                let of = if is_given { "fitted" } else { "usual for its law" };
                what.push(format!("{name} {}, {of} {}", between(seen), between(range)));
            }
        }
        format!(
            "{} ({}) in {} % of its volume from {} on ({})",
            self.part,
            self.body,
            number(100.0 * self.fraction_outside),
            seconds(self.outside_since_s),
            what.join("; ")
        )
    }

    /// Whether the fraction is large enough to be reported.
    pub fn is_notable(&self) -> bool {
        self.fraction_outside > NOTABLE_FRACTION
    }
}

/// Strain rates of a part, beside those of the tests that its parameters are from, where they are given.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct LawRate {
    /// Name of the body, as in the scene.
    pub body: String,
    /// Name of the part, as in the scene.
    pub part: String,
    /// Largest strain rate at any look time, the largest principal value of the deviatoric rate of deformation [1/s].
    pub strain_rate_per_s: f64,
    /// Slowest and fastest test [1/s]; `None` where they are not given.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub tested_strain_rate_per_s: Option<[f64; 2]>,
    /// Fraction of the part's volume that was, at its fastest, deformed faster than in any test [-].
    pub fraction_faster: f64,
    /// Fraction of the part's volume that was always deformed more slowly than in the slowest test, undeformed tissue included [-].
    pub fraction_slower: f64,
}

/// All parts that have moved, in the order of the plan; none where no part has rates of its tests, or is a set of the library.
pub(super) fn law_rates(ranges: &LawRanges) -> Vec<LawRate> {
    let of = |part: &PartRange| LawRate {
        body: part.body.clone(),
        part: part.part.clone(),
        strain_rate_per_s: part.rates.largest,
        tested_strain_rate_per_s: part.rates.tested,
        fraction_faster: part.fraction_of(part.rates.faster),
        fraction_slower: part.fraction_of(part.rates.slower(part.volume)),
    };
    ranges.parts.iter().filter(|part| part.rates.largest > 0.0).map(of).collect()
}

/// The sentence on all parts whose laws were notably used beyond their ranges; `None` where there is none.
pub(super) fn ranges_in_words(ranges: &[LawRange]) -> Option<String> {
    let parts: Vec<String> = ranges.iter().filter(|law| law.is_notable()).map(LawRange::in_words).collect();
    (!parts.is_empty()).then(|| {
        format!(
            "Materials were deformed beyond the range of their laws, so that the stress there is an extrapolation: {}.",
            parts.join("; ")
        )
    })
}

/// The sentence on sets of the library whose sources state no range of stretch, beyond small strains; `None` where there is none.
pub(super) fn unstated_ranges_in_words(ranges: &LawRanges) -> Option<String> {
    let of = |part: &PartRange| {
        let set = part.set.as_ref().filter(|_| !part.validity.given.stretch)?;
        let [least, largest] = part.stretch;
        let is_small = least >= 1.0 - SMALL && largest <= 1.0 + SMALL;
        let [least, largest] = [least, largest].map(number);
        (!is_small)
            .then(|| format!("{} ({}) had stretches from {least} to {largest} ({set})", part.part, part.body))
    };
    let parts: Vec<String> = ranges.parts.iter().filter_map(of).collect();
    (!parts.is_empty()).then(|| {
        format!(
            "The sources of sets of the library state no range of stretch, so that it is not known whether their stress holds here: {}.",
            parts.join("; ")
        )
    })
}

/// The sentence on all parts that were deformed at rates which the tests of their parameters do not cover; `None` where there is none.
pub(super) fn rates_in_words(rates: &[LawRate]) -> Option<String> {
    let parts: Vec<String> = rates.iter().filter_map(LawRate::in_words).collect();
    (!parts.is_empty()).then(|| {
        format!(
            "Materials were deformed at rates that their tests do not cover, so that their stiffness is uncertain: {}.",
            parts.join("; ")
        )
    })
}

impl LawRate {
    /// "muscle (thigh) at up to 5100 /s, in 35 % of its volume faster and in 60 % of its volume slower than in any test (378 /s)"; `None` within the range of
    /// the tests.
    fn in_words(&self) -> Option<String> {
        let (whose, rate) = (format!("{} ({})", self.part, self.body), number(self.strain_rate_per_s));
        let Some([slowest, fastest]) = self.tested_strain_rate_per_s else {
            return Some(format!("{whose} at up to {rate} /s, without rates of tests to compare with"));
        };
        let [from, to] = [slowest, fastest].map(number);
        let tests = if from == to { format!("{to} /s") } else { format!("{from} to {to} /s") };
        let sides =
            [("faster", self.fraction_faster, NOTABLE_FRACTION), ("slower", self.fraction_slower, MOSTLY)];
        let notable = sides.into_iter().filter(|(_, fraction, least)| fraction > least);
        let how: Vec<String> =
            notable.map(|(how, of, _)| format!("in {} % of its volume {how}", number(100.0 * of))).collect();
        (!how.is_empty())
            .then(|| format!("{whose} at up to {rate} /s, {} than in any test ({tests})", how.join(" and ")))
    }
}

/// "gel (block) was stretched to 4.2 (limit 4.0), beyond the usual limit of its law, in 12 mm³ (0.1 % of its volume), first seen at 40 µs; 3 %
/// of the strain energy was there"; without the energy where elements have inverted, which leaves it undefined.
pub(super) fn beyond_limit(ranges: &LawRanges, part: &PartRange) -> String {
    let limit = part.validity.limit;
    let ([thin, long], [small, large]) = (part.stretch, part.jacobian);
    let mut what = Vec::new();
    for (is_beyond, name, value, limit) in [
        (long > limit.stretch[1], "stretched to", long, limit.stretch[1]),
        (thin < limit.stretch[0], "compressed to", thin, limit.stretch[0]),
        (small < limit.jacobian[0], "crushed to J =", small, limit.jacobian[0]),
        (large > limit.jacobian[1], "swollen to J =", large, limit.jacobian[1]),
    ] {
        if is_beyond {
            what.push(format!("{name} {} (limit {})", number(value), number(limit)));
        }
    }
    let energy = format!("; {:.1} % of the strain energy was there", 100.0 * ranges.fraction_of(part));
    format!(
        "{} ({}) was {}, beyond the {} limit of its law, in {} ({} % of its volume), first seen at {}{}",
        part.part,
        part.body,
        what.join(", "),
        if part.exceeds_declared() { "declared" } else { "usual" },
        volume(1e9 * part.beyond.volume()),
        number(100.0 * part.fraction(&part.beyond)),
        seconds(part.beyond.since.unwrap_or_default()),
        if part.has_turned_over { "" } else { &energy }
    )
}

/// The warning of stress where no wave can have arrived; `None` where there is none.
pub(super) fn numerical_stress(stress: &StressDepth) -> Option<String> {
    let found = stress.exceedances.iter().filter(|e| e.largest_numerical > 0.0).map(|e| {
        let (time, reach) = e.numerical_at;
        format!(
            "{} above {} kPa at {}, {} mm from it",
            volume(1e9 * e.largest_numerical),
            number(1e-3 * e.threshold),
            seconds(time),
            number(1e3 * reach)
        )
    });
    let found: Vec<String> = found.collect();
    (!found.is_empty()).then(|| {
        format!(
            "Some stress is an artefact of the mesh and is excluded from all results: it lies where no wave from the contact can have arrived \
             ({}), since stress propagates by one element per step, however long. Shorter elements along the surface around the contact reduce \
             it; more layers alone increase it.",
            found.join("; ")
        )
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn strain_rates_are_reported_where_they_leave_those_of_the_tests() {
        let rate = |strain_rate_per_s: f64,
                    tested: Option<[f64; 2]>,
                    [fraction_faster, fraction_slower]: [f64; 2]| LawRate {
            body: "thigh".into(),
            part: "muscle".into(),
            strain_rate_per_s,
            tested_strain_rate_per_s: tested,
            fraction_faster,
            fraction_slower,
        };
        let faster = rate(5100.0, Some([378.0; 2]), [0.35, 0.49]).in_words().unwrap();
        assert_eq!(
            faster,
            "muscle (thigh) at up to 5100 /s, in 35.00 % of its volume faster than in any test (378.0 /s)"
        );
        let slower = rate(20.0, Some([116.0, 378.0]), [0.0, 1.0]).in_words().unwrap();
        assert!(
            slower.contains("in 100.0 % of its volume slower than in any test (116.0 to 378.0 /s)"),
            "{slower}"
        );
        let spread = rate(5100.0, Some([116.0, 378.0]), [0.1, 0.6]).in_words().unwrap();
        assert!(
            spread.contains("in 10.00 % of its volume faster and in 60.00 % of its volume slower than"),
            "{spread}"
        );
        assert_eq!(rate(200.0, Some([116.0, 378.0]), [0.0, 0.5]).in_words(), None);
        let unknown = rate(5100.0, None, [0.0; 2]).in_words().unwrap();
        assert_eq!(unknown, "muscle (thigh) at up to 5100 /s, without rates of tests to compare with");
        let both = rates_in_words(&[
            rate(20.0, Some([116.0, 378.0]), [0.0, 1.0]),
            rate(5100.0, Some([378.0; 2]), [0.35, 0.49]),
        ])
        .unwrap();
        assert!(both.contains(&format!(": {slower}; {faster}.")), "{both}");
    }

    #[test]
    fn ranges_that_no_source_gives_are_not_called_fitted() {
        let words = |stretch: bool, jacobian: bool| {
            let law = LawRange {
                body: "thigh".into(),
                part: "fat".into(),
                stretch: [0.5, 1.7],
                fitted_stretch: [0.6, 1.5],
                jacobian: [0.8, 1.0],
                fitted_jacobian: [0.9, 1.1],
                fraction_outside: 0.5,
                outside_since_s: 1e-5,
                fraction_beyond_limit: 0.0,
                given: Given { stretch, jacobian },
            };
            ranges_in_words(&[law]).unwrap()
        };
        let usual = words(false, false);
        assert!(usual.contains("fat (thigh) in 50.00 % of its volume from 10.00 µs on"), "{usual}");
        assert!(usual.contains("usual for its law 0.6000 to 1.500") && !usual.contains("fitted"), "{usual}");
        let given = words(true, false);
        assert!(given.contains("stretch 0.5000 to 1.700, fitted 0.6000 to 1.500"), "{given}");
        assert!(given.contains("volume ratio 0.8000 to 1.000, usual for its law 0.9000 to 1.100"), "{given}");
    }
}
