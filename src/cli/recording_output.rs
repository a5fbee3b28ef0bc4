//! Outputs of a run, by their suffixes: a recording (`.mcap`), a series of VTK files (`.pvd`).

use super::CliError;
use super::output_file::check_writable;
use crate::measure::Sink;
use crate::record::vtk::folder_of;
use crate::record::{McapRecorder, RecordingInfo, VtuRecorder, partial_path};
use crate::scene::Scene;
use std::fs::File;
use std::io::Read as _;
use std::path::{Path, PathBuf};

/// Flag that errors name.
const FLAG: &str = "--output (-o)";
/// What an MCAP file begins with.
const MCAP: &[u8] = b"\x89MCAP0\r\n";
/// What the list of a series of VTK files begins with.
const PVD: &[u8] = b"<?xml version=\"1.0\"?>\n<VTKFile type=\"Collection\"";

/// Format of an output.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Format {
    Mcap,
    Vtu,
}

/// Rejects outputs of a run of `scene` that cannot be written, before the run rather than after it.
pub(super) fn check_outputs(paths: &[PathBuf], scene: &Scene) -> Result<(), CliError> {
    for (i, path) in paths.iter().enumerate() {
        if paths[..i].contains(path) {
            return Err(CliError::Usage(format!("{FLAG}: {} is given twice", path.display())));
        }
        check_path(path, FLAG)?;
        match format_of(path)? {
            Format::Mcap => check_writable(&partial_path(path), FLAG)?,
            Format::Vtu => check_series(path, FLAG)?,
        }
        if format_of(path)? == Format::Vtu && scene.document.record.fields.is_empty() {
            return Err(CliError::Usage(format!(
                "{FLAG}: the scene records no fields for {}; name some in /record/fields, such as von_mises",
                path.display()
            )));
        }
    }
    Ok(())
}

/// Rejects a path that a run must not write to.
fn check_path(path: &Path, flag: &str) -> Result<(), CliError> {
    let shown = path.display();
    if path.is_dir() {
        return Err(CliError::Usage(format!("{flag}: {shown} is a folder; name a file in it")));
    }
    if path.exists() && !begins_with(path, MCAP) && !begins_with(path, PVD) {
        return Err(CliError::Usage(format!(
            "{flag}: {shown} exists and is not a recording: it would be overwritten; remove it or name another file"
        )));
    }
    let folder = path.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."));
    if !folder.is_dir() {
        return Err(CliError::Usage(format!("{flag}: {shown}: there is no folder {}", folder.display())));
    }
    Ok(())
}

/// Rejects a series that cannot be written under this `.pvd` path, or whose folder holds other files: these would be
/// mixed with those of the series.
pub(super) fn check_series(pvd: &Path, flag: &str) -> Result<(), CliError> {
    check_path(pvd, flag)?;
    if format_of(pvd).ok() != Some(Format::Vtu) {
        return Err(CliError::Usage(format!("{flag}: {} does not end in .pvd", pvd.display())));
    }
    for folder in [folder_of(pvd), partial_path(&folder_of(pvd))] {
        if folder.exists() && !holds_only_vtu(&folder) {
            return Err(CliError::Usage(format!(
                "{flag}: the files of {} go to {}, which contains files other than .vtu; remove it or name another file",
                pvd.display(),
                folder.display()
            )));
        }
    }
    check_writable(&partial_path(pvd), flag)
}

fn holds_only_vtu(folder: &Path) -> bool {
    let is_vtu = |path: &Path| path.extension().is_some_and(|extension| extension == "vtu");
    let read = std::fs::read_dir(folder);
    let all =
        read.and_then(|mut entries| entries.try_fold(true, |all, entry| Ok(all && is_vtu(&entry?.path()))));
    all.is_ok_and(|holds_only_vtu| holds_only_vtu)
}

/// Format by the suffix.
fn format_of(path: &Path) -> Result<Format, CliError> {
    match path.extension().and_then(|extension| extension.to_str()) {
        Some("mcap") => Ok(Format::Mcap),
        Some("pvd") => Ok(Format::Vtu),
        _ => Err(CliError::Usage(format!(
            "{FLAG}: the suffix of {} names no format; use .mcap for a recording or .pvd for a series of VTK files (ParaView)",
            path.display()
        ))),
    }
}

/// Whether a file begins with these bytes: only recordings and series may be overwritten.
fn begins_with(path: &Path, magic: &[u8]) -> bool {
    let mut first = vec![0; magic.len()];
    let read = |mut file: File| file.read_exact(&mut first);
    path.is_file() && File::open(path).and_then(read).is_ok() && first == magic
}

/// Recorders of the outputs of a run.
pub(super) fn recorders(paths: &[PathBuf], info: &RecordingInfo) -> Result<Vec<Box<dyn Sink>>, CliError> {
    let recorder = |path: &PathBuf| -> Result<Box<dyn Sink>, CliError> {
        Ok(match format_of(path)? {
            Format::Mcap => Box::new(McapRecorder::new(path, info.clone())),
            Format::Vtu => Box::new(VtuRecorder::new(path)),
        })
    };
    paths.iter().map(recorder).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn formats_are_named_by_suffixes() {
        assert_eq!(format_of(Path::new("a/b.mcap")).ok(), Some(Format::Mcap));
        assert_eq!(format_of(Path::new("b.x.pvd")).ok(), Some(Format::Vtu));
        for path in ["b", "b.vtu", "b.PVD", ".pvd", "b.mcap.gz"] {
            let refused = format_of(Path::new(path)).unwrap_err().to_string();
            assert!(refused.contains(".mcap") && refused.contains(".pvd"), "{refused}");
        }
    }

    #[test]
    fn a_series_replaces_a_series_and_nothing_else() {
        let folder = tempfile::tempdir().unwrap();
        let (pvd, files) = (folder.path().join("a.pvd"), folder.path().join("a_vtu"));
        assert!(check_series(&pvd, FLAG).is_ok());
        std::fs::create_dir(&files).unwrap();
        std::fs::write(files.join("0_ball_0000.vtu"), "").unwrap();
        std::fs::write(&pvd, PVD).unwrap();
        assert!(check_series(&pvd, FLAG).is_ok());
        std::fs::write(files.join("notes.txt"), "").unwrap();
        let refused = check_series(&pvd, FLAG).unwrap_err().to_string();
        assert!(refused.contains("a_vtu") && refused.contains("name another file"), "{refused}");
        std::fs::write(&pvd, "<?xml version=\"1.0\"?><other/>").unwrap();
        assert!(check_series(&pvd, FLAG).unwrap_err().to_string().contains("not a recording"));
    }
}
