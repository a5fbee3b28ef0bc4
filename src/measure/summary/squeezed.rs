//! Warning of tissue that is squeezed against its base.

use super::super::squeeze::Squeezed;
use super::written::{number, seconds};

/// Part of the thickness above whose loss a warning is raised [-]: its base then carries the contact as much as the tissue does.
const LOST_WARNING: f64 = 0.6;

/// The warning, where more of the thickness is lost.
pub(super) fn squeezed_in_words(of: &Squeezed) -> Option<String> {
    let Squeezed { body, pair, is_held, thickness, place, time } = of;
    let base = if *is_held { "the nodes that hold it" } else { "what it rests on" };
    let [before, then] = thickness.map(|thickness| number(1e3 * thickness));
    let [x, y, z] = [place.x, place.y, place.z].map(|c| format!("{:.1}", 1e3 * c));
    (of.lost() > LOST_WARNING).then(|| {
        format!(
            "The contact {pair} squeezed {body} against {base}: it lost {:.0} % of its thickness (above {:.0} %; {before} mm became {then} mm, \
             below x, y, z = {x}, {y}, {z} mm, at {}). Forces, stresses and their depth then depend on what is behind the tissue. If the body \
             goes on there, make the tissue thicker, or model what is behind it.",
            100.0 * of.lost(),
            100.0 * LOST_WARNING,
            seconds(*time)
        )
    })
}

#[cfg(test)]
#[allow(clippy::unwrap_used)] // tests may panic
mod tests {
    use super::*;
    use crate::mechanics::tensor::Vec3;

    #[test]
    fn tissue_that_becomes_thin_on_its_base_is_warned_of_with_its_values() {
        let of = |then: f64, is_held: bool| {
            let (body, pair) = ("gel".into(), "gel–ball".into());
            let thickness = [0.02, then];
            squeezed_in_words(&Squeezed {
                body,
                pair,
                is_held,
                thickness,
                place: Vec3::z() * 0.02,
                time: 2e-3,
            })
        };
        let said = of(0.005, true).unwrap();
        assert!(said.contains("gel against the nodes that hold it: it lost 75 % of its thickness"), "{said}");
        assert!(said.contains("20.00 mm became 5.000 mm, below x, y, z = 0.0, 0.0, 20.0 mm"), "{said}");
        assert!(of(0.005, false).unwrap().contains("against what it rests on"));
        assert_eq!(of(0.009, true), None);
    }
}
