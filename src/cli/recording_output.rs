//! Outputs of a run, by their suffixes: a recording (`.mcap`), a series of VTK files (`.pvd`).

use super::CliError;
use super::output_file::{check_distinct, check_replaced, check_writable};
use crate::measure::Sink;
use crate::record::vtk::folder_of;
use crate::record::{McapRecorder, RecordingInfo, VtuRecorder, partial_path};
use crate::scene::Scene;
use std::path::{Path, PathBuf};

/// Flag that errors name.
const FLAG: &str = "--output (-o)";

/// Format of an output.
struct Format {
    /// Suffix of its path.
    suffix: &'static str,
    /// What it is, for people.
    what: &'static str,
    /// What its file begins with: other files are not overwritten.
    magic: &'static [u8],
    /// Whether it holds nothing if the scene records no fields.
    fields_only: bool,
    /// Rejects a path that it cannot be written to, naming the flag.
    check: fn(&Path, &str) -> Result<(), CliError>,
    /// Its recorder.
    recorder: fn(&Path, &RecordingInfo) -> Box<dyn Sink>,
}

/// The formats.
static FORMATS: [Format; 2] = [
    Format {
        suffix: "mcap",
        what: "a recording",
        magic: b"\x89MCAP0\r\n",
        fields_only: false,
        check: |path, flag| check_writable(&partial_path(path), flag),
        recorder: |path, info| Box::new(McapRecorder::new(path, info.clone())),
    },
    Format {
        suffix: "pvd",
        what: "a series of VTK files (ParaView)",
        magic: b"<?xml version=\"1.0\"?>\n<VTKFile type=\"Collection\"",
        fields_only: true,
        check: check_folder,
        recorder: |path, _| Box::new(VtuRecorder::new(path)),
    },
];

/// Help of `--output`.
pub(super) fn help() -> String {
    format!(
        "Output to write: {}; may be given several times [default: the scene's name with .mcap, in the current folder]",
        suffixes()
    )
}

/// The suffixes with what they stand for.
fn suffixes() -> String {
    FORMATS.each_ref().map(|format| format!(".{} for {}", format.suffix, format.what)).join(" or ")
}

/// Rejects outputs of a run of `scene` that cannot be written, before the run rather than after it.
pub(super) fn check_outputs(paths: &[PathBuf], scene: &Scene) -> Result<(), CliError> {
    check_distinct(paths)?;
    for path in paths {
        check_path(path, FLAG)?;
        let format = format_of(path)?;
        (format.check)(path, FLAG)?;
        if format.fields_only && scene.document.record.fields.is_empty() {
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
    check_replaced(path, "a recording", FORMATS.each_ref().map(|format| format.magic), flag)?;
    let shown = path.display();
    let folder = path.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."));
    if !folder.is_dir() {
        return Err(CliError::Usage(format!("{flag}: {shown}: there is no folder {}", folder.display())));
    }
    Ok(())
}

/// Rejects a path that a series of VTK files cannot be written to.
pub(super) fn check_series(pvd: &Path, flag: &str) -> Result<(), CliError> {
    check_path(pvd, flag)?;
    if pvd.extension().is_none_or(|suffix| suffix != "pvd") {
        return Err(CliError::Usage(format!("{flag}: {} does not end in .pvd", pvd.display())));
    }
    check_folder(pvd, flag)
}

/// Rejects a series whose folder cannot be written or holds other files: these would be mixed with those of the series.
fn check_folder(pvd: &Path, flag: &str) -> Result<(), CliError> {
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
fn format_of(path: &Path) -> Result<&'static Format, CliError> {
    let is_of = |format: &&Format| path.extension().is_some_and(|suffix| suffix == format.suffix);
    FORMATS.iter().find(is_of).ok_or_else(|| {
        let (shown, suffixes) = (path.display(), suffixes());
        CliError::Usage(format!("{FLAG}: the suffix of {shown} names no format; use {suffixes}"))
    })
}

/// Recorders of the outputs of a run.
pub(super) fn recorders(paths: &[PathBuf], info: &RecordingInfo) -> Result<Vec<Box<dyn Sink>>, CliError> {
    paths.iter().map(|path| Ok((format_of(path)?.recorder)(path, info))).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn formats_are_named_by_suffixes() {
        let suffix = |path: &str| format_of(Path::new(path)).unwrap().suffix;
        assert_eq!((suffix("a/b.mcap"), suffix("b.x.pvd")), ("mcap", "pvd"));
        assert!(help().contains(".mcap") && help().contains(".pvd"));
        for path in ["b", "b.vtu", "b.PVD", ".pvd", "b.mcap.gz"] {
            let refused = format_of(Path::new(path)).err().unwrap().to_string();
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
        std::fs::write(&pvd, format_of(&pvd).unwrap().magic).unwrap();
        assert!(check_series(&pvd, FLAG).is_ok());
        std::fs::write(files.join("notes.txt"), "").unwrap();
        let refused = check_series(&pvd, FLAG).unwrap_err().to_string();
        assert!(refused.contains("a_vtu") && refused.contains("name another file"), "{refused}");
        std::fs::write(&pvd, "<?xml version=\"1.0\"?><other/>").unwrap();
        assert!(check_series(&pvd, FLAG).unwrap_err().to_string().contains("not a recording"));
    }
}
