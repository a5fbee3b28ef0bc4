//! `--keep NAME`: what is put back though the plan would leave it out.

use crate::scene::document::Keep;
use clap::Args;
use clap::builder::{PossibleValuesParser, TypedValueParser};

/// What is put back, besides what the scene itself keeps.
#[derive(Args, Clone, Debug, Default)]
pub struct KeepArgs {
    /// Put back something that the plan would leave out; may be given several times.
    #[arg(long, value_name = "NAME", value_parser = names())]
    pub keep: Vec<Keep>,
}

fn names() -> impl TypedValueParser<Value = Keep> {
    let parser = PossibleValuesParser::new(Keep::ALL.map(Keep::name));
    // Only names that are known come through.
    parser.try_map(|name| Keep::from_name(&name).ok_or_else(|| format!("there is no {name}")))
}
