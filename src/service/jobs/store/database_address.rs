//! The address of a database on the command line.

use clap::builder::TypedValueParser;
use clap::error::ErrorKind;
use clap::{Arg, Command, Error};
use std::ffi::OsStr;

/// Reads the address of a database. Its errors show no part of it that may be a password.
#[derive(Clone, Copy, Debug)]
pub(super) struct DatabaseAddress;

impl TypedValueParser for DatabaseAddress {
    type Value = String;

    fn parse_ref(&self, command: &Command, _: Option<&Arg>, value: &OsStr) -> Result<String, Error> {
        let address = value.to_string_lossy().into_owned();
        let refusal = |reason| {
            let text = format!(
                "--database (CONTUSE_DATABASE) is not an address of PostgreSQL: {reason}; \
                 give postgres://user:password@host:port/name or postgresql://…\n"
            );
            Error::raw(ErrorKind::ValueValidation, text).with_cmd(command)
        };
        check(&address).map_err(refusal)?;
        Ok(address)
    }
}

/// Says what is wrong with an address.
fn check(address: &str) -> Result<(), String> {
    let is_scheme = |text: &str| text.bytes().all(|b| b.is_ascii_alphanumeric() || b"+-.".contains(&b));
    match address.split_once("://").map(|(scheme, _)| scheme).filter(|scheme| is_scheme(scheme)) {
        Some("postgres" | "postgresql") => {}
        Some(scheme) => return Err(format!("its scheme is `{scheme}`")),
        None => return Err("it has no scheme".into()),
    }
    #[cfg(feature = "cluster")]
    if let Err(error) = address.parse::<sqlx::postgres::PgConnectOptions>() {
        return Err(error.to_string());
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parsed(address: &str) -> Result<String, String> {
        let command = Command::new("test");
        DatabaseAddress.parse_ref(&command, None, OsStr::new(address)).map_err(|error| error.to_string())
    }

    #[test]
    fn another_scheme_is_refused_without_the_password() {
        for good in ["postgres://contuse@db/contuse", "postgresql://contuse:secret@db:5432/contuse"] {
            assert_eq!(parsed(good).as_deref(), Ok(good));
        }
        for (bad, reason) in [
            ("mysql://contuse:secret@db/contuse", "its scheme is `mysql`"),
            ("contuse:secret@db/contuse", "it has no scheme"),
            ("contuse:secret@http://db", "it has no scheme"),
            ("", "it has no scheme"),
        ] {
            let refusal = parsed(bad).unwrap_err();
            assert!(refusal.contains(reason) && refusal.contains("postgresql://"), "{refusal}");
            assert!(refusal.contains("CONTUSE_DATABASE") && !refusal.contains("secret"), "{refusal}");
        }
    }

    #[cfg(feature = "cluster")]
    #[test]
    fn an_address_without_meaning_is_refused_without_the_password() {
        for bad in ["postgres://contuse:secret@db:port/contuse", "postgres://u:secret@db/n?sslmode=secret?"] {
            let refusal = parsed(bad).unwrap_err();
            assert!(refusal.contains("CONTUSE_DATABASE") && !refusal.contains("u:secret"), "{refusal}");
        }
    }
}
