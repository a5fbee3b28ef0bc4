//! `--keep NAME`: restores what the plan would omit.

use crate::scene::document::Keep;
use clap::Args;
use clap::builder::{PossibleValuesParser, TypedValueParser};

/// Items to restore, in addition to those kept by the scene itself.
#[derive(Args, Clone, Debug, Default)]
pub struct KeepArgs {
    /// Restore an item that the plan would omit; may be given several times.
    #[arg(long, value_name = "NAME", value_parser = names())]
    pub keep: Vec<Keep>,
}

fn names() -> impl TypedValueParser<Value = Keep> {
    let parser = PossibleValuesParser::new(Keep::ALL.map(Keep::name));
    // Only known names get here.
    parser.try_map(|name| Keep::from_name(&name).ok_or_else(|| format!("there is no {name}")))
}
