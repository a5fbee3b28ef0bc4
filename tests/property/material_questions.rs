//! Whatever is requested of a material, the answer is a question that means something, or problems.

use crate::changes::{changed, changes};
use contuse::scene::material_question::MaterialQuestions;
use proptest::prelude::*;
use serde_json::json;

proptest! {
    #[test]
    fn a_changed_question_is_read_or_refused_with_reasons(changes in changes()) {
        let question = json!([
            {"material": {"law": "mooney_rivlin", "c10_pa": 4e4, "c01_pa": 1e4, "bulk_modulus_pa": 1e6},
             "F": [[1.1, 0.1, 0], [0, 0.95, 0], [0, 0, 1]]},
            {"material": {"law": "holzapfel_gasser_ogden", "c_pa": 3e4, "k1_pa": 2e4, "k2": 0.8, "kappa": 0.1,
                          "fibres": {"angles_deg": [29.0, -29.0]}, "bulk_modulus_pa": 1e6},
             "F": [[1.2, 0, 0], [0, 1, 0], [0, 0, 0.9]]}
        ]);
        let bytes = changed(&question, changes).to_string().into_bytes();
        if let Err(problems) = MaterialQuestions::read(&bytes) {
            prop_assert!(problems.error_count() > 0, "{problems:?}");
            for problem in &problems.0 {
                prop_assert!(!problem.message.is_empty() && !problem.remedy.is_empty(), "{problem:?}");
            }
        }
    }
}
