//! `contuse token`: bearer tokens for a service.

use super::{CliError, Exit};
use crate::service::tokens::{Scope, Tokens, is_day};
use clap::Args;
use std::io::Write;
use uuid::Uuid;

/// Arguments of `contuse token`.
#[derive(Args, Clone, Debug)]
pub struct TokenArgs {
    /// Name of the owner of the token, without spaces.
    name: String,
    /// Scope: `submit` (full access to the owner's jobs and meshes), `read` (read-only access to them), `metrics` (the counters alone).
    #[arg(long, default_value = "submit", value_parser = scope)]
    scope: Scope,
    /// Last day on which the token is accepted, in UTC, such as 2026-12-31 [default: no expiry]
    #[arg(long, value_parser = day)]
    until: Option<String>,
}

/// Makes a token, and the line that admits it in a file of tokens.
///
/// # Errors
/// If the name has spaces, or the output cannot be written.
pub fn token(args: &TokenArgs, out: &mut dyn Write) -> Result<Exit, CliError> {
    if args.name.is_empty() || args.name.starts_with('#') || args.name.contains(char::is_whitespace) {
        return Err(CliError::Usage(format!("{:?} is not a name: give a word without spaces", args.name)));
    }
    // 244 random bits.
    let token = format!("{}{}", Uuid::new_v4().simple(), Uuid::new_v4().simple());
    let line = Tokens::line(&args.name, &token, args.scope, args.until.as_deref());
    writeln!(out, "token, for {} alone: {token}", args.name)?;
    writeln!(out, "line for the file of --tokens-file: {line}")?;
    Ok(Exit::Success)
}

fn scope(text: &str) -> Result<Scope, String> {
    Scope::from_name(text).ok_or_else(|| format!("there are {}", Scope::ALL.map(Scope::as_str).join(", ")))
}

fn day(text: &str) -> Result<String, String> {
    if is_day(text) { Ok(text.to_owned()) } else { Err("give a day such as 2026-12-31".into()) }
}
