//! Defaults of members of documents, and whether a member has its default.

#[allow(clippy::trivially_copy_pass_by_ref)] // serde's signature
pub(crate) fn is_false(flag: &bool) -> bool {
    !flag
}

#[allow(clippy::trivially_copy_pass_by_ref)] // serde's signature
pub(crate) fn is_one(ratio: &f64) -> bool {
    ratio.to_bits() == 1.0_f64.to_bits()
}

pub(crate) fn one() -> f64 {
    1.0
}

#[allow(clippy::trivially_copy_pass_by_ref)] // serde's signature
pub(crate) fn is_zero_length(length: &f64) -> bool {
    length.to_bits() == 0.0_f64.to_bits()
}
