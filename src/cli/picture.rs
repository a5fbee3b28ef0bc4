//! Pictures written to files: SVG, or PNG rendered from it.

use super::CliError;
use super::output_file::{PICTURE, check_distinct, check_output, write_file};
#[cfg(feature = "png")]
use crate::study::png;
use clap::Args;
use std::path::{Path, PathBuf};

/// Message of a program built without the feature `png`.
const NO_PNG: &str = "this program was built without PNG: request SVG (a name ending in .svg, or --svg FILE), \
                      or build it with `cargo build --release --features png`";

#[cfg(not(feature = "png"))]
fn png(_svg: &str) -> Result<Vec<u8>, String> {
    Err(NO_PNG.into())
}

/// Output files of a picture.
#[derive(Args, Debug)]
pub struct PictureArgs {
    /// Write the picture as SVG.
    #[arg(long, value_name = "FILE")]
    pub svg: Option<PathBuf>,
    /// Write the picture as PNG (if built with the feature `png`).
    #[arg(long, value_name = "FILE", value_parser = png_path)]
    pub png: Option<PathBuf>,
}

impl PictureArgs {
    /// Draws and writes the picture, if any output was requested.
    ///
    /// # Errors
    /// The message of the drawing library, or that a file cannot be written.
    pub fn write(&self, draw: impl FnOnce() -> Result<String, String>) -> Result<(), CliError> {
        if self.svg.is_none() && self.png.is_none() {
            return Ok(());
        }
        self.check()?;
        let picture = draw().map_err(CliError::Picture)?;
        if let Some(path) = &self.svg {
            write_file(path, |file| file.write_all(picture.as_bytes()))?;
        }
        if let Some(path) = &self.png {
            let image = png(&picture).map_err(CliError::Picture)?;
            write_file(path, |file| file.write_all(&image))?;
        }
        Ok(())
    }

    /// Rejects files that cannot be written, before the work.
    ///
    /// # Errors
    /// Why a file cannot be written, or that it would replace one that is no picture.
    pub fn check(&self) -> Result<(), CliError> {
        check_distinct(self.svg.iter().chain(&self.png))?;
        let files = [(&self.svg, "--svg"), (&self.png, "--png")];
        let mut given = files.into_iter().filter_map(|(path, flag)| Some((path.as_ref()?, flag)));
        given.try_for_each(|(path, flag)| check_output(path, &PICTURE, flag))
    }
}

/// Writes a picture to a file: as PNG if the name ends in .png, otherwise as SVG.
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

/// Path of a PNG; rejected before any work if the program cannot write PNG.
fn png_path(text: &str) -> Result<PathBuf, &'static str> {
    if cfg!(feature = "png") { Ok(text.into()) } else { Err(NO_PNG) }
}

/// Path of a picture, PNG or SVG by its name; as [`png_path`].
pub fn picture_path(text: &str) -> Result<PathBuf, &'static str> {
    if is_png(Path::new(text)) { png_path(text) } else { Ok(text.into()) }
}
