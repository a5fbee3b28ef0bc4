//! Parameters of a mesh generator out of range, as problems of the document.

use super::problem::{Pointer, Problem};
use crate::mesh::ParameterProblem;

/// The problem of a parameter of the generator at `here`.
pub fn generator_problem(found: &ParameterProblem, here: &Pointer) -> Problem {
    // The whole generator is too large, not one of its fields.
    let path = if found.field == "element_count" { "" } else { &found.field };
    let steps = path.split(['[', ']', '.']).filter(|step| !step.is_empty());
    let message = format!("the mesh cannot be made with this {}", found.field);
    Problem::error("bad_generator_parameter", &steps.fold(here.clone(), |p, key| p.key(key)), message)
        .value(found.value)
        .limit(found.limit.clone())
        .remedy(found.remedy.clone())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::document::Generator;
    use serde_json::json;

    #[test]
    fn problems_point_at_the_fields_of_the_document() {
        let pointers = |document| {
            let generator: Generator = serde_json::from_value(document).unwrap();
            let found = generator.problems();
            found.iter().map(|of| generator_problem(of, &Pointer::root()).pointer).collect::<Vec<_>>()
        };
        let block = json!({
            "kind": "block", "min_m": [0, 0, 0], "max_m": [1, -1, 1], "elements": [0, 1, 1], "grading": [1, 1, 0.5]
        });
        assert_eq!(pointers(block), ["/elements/0", "/max_m/1", "/grading_center_m/1", "/grading/2"]);
        let ball = json!({
            "kind": "hollow_ball", "outer_radius_m": 1, "inner_radius_m": 2,
            "elements_around": u32::MAX, "elements_through": u32::MAX
        });
        assert_eq!(pointers(ball), ["/inner_radius_m", ""]);
        let plate = json!({
            "kind": "layered_block", "size_m": [1, 1], "elements": [1, 1], "grading": [0.5, 1],
            "layers": [{"part": "fat", "thickness_m": -1, "elements": 1}]
        });
        assert_eq!(pointers(plate), ["/grading/0", "/layers/0/thickness_m"]);
    }
}
