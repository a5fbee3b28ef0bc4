//! The explicit step.
