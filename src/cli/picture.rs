//! Pictures into files: SVG, or PNG made of it.

use super::CliError;
#[cfg(feature = "png")]
use crate::study::png;
use clap::Args;
use std::path::{Path, PathBuf};

/// What is said by a program that was built without the feature `png`.
const NO_PNG: &str = "this program was built without PNG: let it draw SVG (a name that ends with .svg, or --svg FILE), \
                      or build it with `cargo build --release --features png`";

#[cfg(not(feature = "png"))]
fn png(_svg: &str) -> Result<Vec<u8>, String> {
    Err(NO_PNG.into())
}

/// Where a picture goes.
#[derive(Args, Debug)]
pub struct PictureArgs {
    /// Draw it as SVG.
    #[arg(long, value_name = "FILE")]
    pub svg: Option<PathBuf>,
    /// Draw it as PNG (if built with the feature `png`).
    #[arg(long, value_name = "FILE", value_parser = png_path)]
    pub png: Option<PathBuf>,
}

impl PictureArgs {
    /// Draws, and writes what was asked for; nothing is drawn where nothing is.
    ///
    /// # Errors
    /// The drawing library's own words, or that a file cannot be written.
    pub fn write(&self, draw: impl FnOnce() -> Result<String, String>) -> Result<(), CliError> {
        if self.svg.is_none() && self.png.is_none() {
            return Ok(());
        }
        let picture = draw().map_err(CliError::Picture)?;
        if let Some(path) = &self.svg {
            std::fs::write(path, &picture)?;
        }
        if let Some(path) = &self.png {
            std::fs::write(path, png(&picture).map_err(CliError::Picture)?)?;
        }
        Ok(())
    }
}

/// Writes a picture into a file of which only the name is told: as PNG where it ends so, else as SVG.
///
/// # Errors
/// As [`PictureArgs::write`].
pub fn write_by_name(path: &Path, draw: impl FnOnce() -> Result<String, String>) -> Result<(), CliError> {
    let (svg, png) = if is_png(path) { (None, Some(path)) } else { (Some(path), None) };
    PictureArgs { svg: svg.map(Path::to_owned), png: png.map(Path::to_owned) }.write(draw)
}

fn is_png(path: &Path) -> bool {
    path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("png"))
}

/// The path of a PNG; refused before any work is done where the program makes none.
fn png_path(text: &str) -> Result<PathBuf, &'static str> {
    if cfg!(feature = "png") { Ok(text.into()) } else { Err(NO_PNG) }
}

/// The path of a picture, a PNG by its name or an SVG; as [`png_path`].
pub fn picture_path(text: &str) -> Result<PathBuf, &'static str> {
    if is_png(Path::new(text)) { png_path(text) } else { Ok(text.into()) }
}
