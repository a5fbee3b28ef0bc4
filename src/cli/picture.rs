//! Pictures into files: SVG, or PNG made of it.

use super::CliError;
use crate::study::png;
use clap::Args;
use std::path::{Path, PathBuf};

/// Where a picture goes.
#[derive(Args, Debug)]
pub struct PictureArgs {
    /// Draw it as SVG.
    #[arg(long, value_name = "FILE")]
    pub svg: Option<PathBuf>,
    /// Draw it as PNG.
    #[arg(long, value_name = "FILE")]
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
    let is_png = path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("png"));
    let (svg, png) = if is_png { (None, Some(path)) } else { (Some(path), None) };
    PictureArgs { svg: svg.map(Path::to_owned), png: png.map(Path::to_owned) }.write(draw)
}
