//! Output files: checked before the work begins, with errors that name them. A file that exists is replaced only where it is of the
//! kind that is written, as its beginning says: no input and no file of another program is lost.

use super::CliError;
use std::fs::{self, File, OpenOptions};
use std::io::{self, Read as _, Write};
use std::path::{Path, PathBuf};

/// A kind of files that are written.
#[derive(Debug)]
pub(super) struct Kind {
    /// What such a file is, with its article.
    pub what: &'static str,
    /// Suffix that its name must have.
    pub suffix: Option<&'static str>,
    /// What such files begin with, one of these.
    pub beginnings: &'static [&'static [u8]],
}

pub(super) const STL: Kind = Kind {
    what: "a surface of a recording",
    suffix: Some("stl"),
    beginnings: &[b"Contuse: deformed surfaces"],
};
pub(super) const PLY: Kind = Kind {
    what: "a surface of a recording",
    suffix: Some("ply"),
    beginnings: &[b"ply\nformat binary_little_endian 1.0\ncomment Contuse: deformed surfaces"],
};
pub(super) const CSV: Kind = Kind {
    what: "a table of Contuse",
    suffix: Some("csv"),
    beginnings: &[b"# For research use only", b"time [s],", b"case,ending,steps", b"setting,ending,elements"],
};
pub(super) const FHIR: Kind = Kind {
    what: "a FHIR bundle of Contuse",
    suffix: Some("json"),
    beginnings: &[b"{\n  \"entry\": [\n    {\n      \"fullUrl\": \"urn:uuid:"],
};
pub(super) const REPORT: Kind = Kind {
    what: "a report",
    suffix: None,
    beginnings: &[
        b"<!doctype html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n<meta name=\"viewport\"",
    ],
};
pub(super) const PICTURE: Kind =
    Kind { what: "a picture", suffix: None, beginnings: &[b"<svg ", b"\x89PNG\r\n"] };
pub(super) const MESH: Kind = Kind {
    what: "a mesh for Gmsh or ParaView",
    suffix: None,
    beginnings: &[b"$MeshFormat", b"<?xml version=\"1.0\"?>\n<VTKFile type=\"UnstructuredGrid\""],
};

/// Rejects an output that would replace a file of another kind, cannot be written, or has the name of another kind.
pub(super) fn check_output(path: &Path, kind: &Kind, flag: &str) -> Result<(), CliError> {
    check_replaced(path, kind.what, kind.beginnings.iter().copied(), flag)?;
    check_writable(path, flag)?;
    let has = |suffix: &&str| path.extension().is_some_and(|own| own.eq_ignore_ascii_case(suffix));
    match kind.suffix.filter(|suffix| !has(suffix)) {
        Some(suffix) => {
            let shown = path.display();
            Err(CliError::Usage(format!("{flag}: {shown} does not end in .{suffix}, as {} does", kind.what)))
        }
        None => Ok(()),
    }
}

/// Rejects a folder, and a file that exists and begins with none of these: it is of another kind than what is written.
pub(super) fn check_replaced<'a>(
    path: &Path,
    what: &str,
    beginnings: impl IntoIterator<Item = &'a [u8]>,
    flag: &str,
) -> Result<(), CliError> {
    let shown = path.display();
    if path.is_dir() {
        return Err(CliError::Usage(format!("{flag}: {shown} is a folder; name a file in it")));
    }
    // Pipes and devices have no contents that would be lost.
    if path.is_file() && !beginnings.into_iter().any(|beginning| begins_with(path, beginning)) {
        return Err(CliError::Usage(format!(
            "{flag}: {shown} exists and is not {what}: it would be overwritten; remove it or name another file"
        )));
    }
    Ok(())
}

fn begins_with(path: &Path, beginning: &[u8]) -> bool {
    let mut first = vec![0; beginning.len()];
    let read = |mut file: File| file.read_exact(&mut first);
    File::open(path).and_then(read).is_ok() && first == beginning
}

/// Rejects two outputs, or an input and an output, that are one file.
pub(super) fn check_distinct<'a>(files: impl IntoIterator<Item = &'a PathBuf>) -> Result<(), CliError> {
    let mut known = Vec::new();
    for path in files {
        let place = place(path);
        if known.contains(&place) {
            let shown = path.display();
            return Err(CliError::Usage(format!(
                "{shown} is given twice: it would be overwritten; name another file"
            )));
        }
        known.push(place);
    }
    Ok(())
}

/// Where a file is or would be, without links.
fn place(path: &Path) -> PathBuf {
    let folder = path.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let new = || folder.canonicalize().map(|folder| folder.join(path.file_name().unwrap_or_default()));
    path.canonicalize().or_else(|_| new()).unwrap_or_else(|_| path.to_owned())
}

/// Rejects a file that cannot be written, naming its flag. An existing file keeps its contents; a missing one is not
/// left behind.
pub(super) fn check_writable(path: &Path, flag: &str) -> Result<(), CliError> {
    let existed = path.exists();
    let opened = OpenOptions::new().append(true).create(true).open(path);
    match opened {
        Ok(_) if existed => Ok(()),
        Ok(_) => fs::remove_file(path).map_err(|source| refused(path, flag, &source)),
        Err(source) => Err(refused(path, flag, &source)),
    }
}

fn refused(path: &Path, flag: &str, why: &io::Error) -> CliError {
    let folder = path.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let reason =
        if folder.is_dir() { why.to_string() } else { format!("there is no folder {}", folder.display()) };
    CliError::Usage(format!(
        "{flag}: {} cannot be written: {reason}; name a file in a folder that you may write to with {flag}",
        path.display()
    ))
}

/// Writes a whole file.
pub(super) fn write_file(
    path: &Path,
    write: impl FnOnce(&mut dyn Write) -> io::Result<()>,
) -> Result<(), CliError> {
    let written = File::create(path).and_then(|file| {
        let mut file = io::BufWriter::new(file);
        write(&mut file)?;
        file.flush()
    });
    written.map_err(|source| CliError::File { path: path.to_owned(), source })
}

#[cfg(test)]
#[allow(clippy::unwrap_used)] // tests may panic
mod tests {
    use super::*;

    #[test]
    fn only_files_of_the_same_kind_are_replaced() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("a.stl");
        assert!(check_output(&file, &STL, "--stl").is_ok() && !file.exists());
        std::fs::write(&file, "Contuse: deformed surfaces at 1e-3 s, in metres").unwrap();
        assert!(check_output(&file, &STL, "--stl").is_ok());
        for other in ["", "solid bone", "\u{89}MCAP0\r\n"] {
            std::fs::write(&file, other).unwrap();
            let refused = check_output(&file, &STL, "--stl").unwrap_err().to_string();
            assert!(refused.contains("--stl") && refused.contains("would be overwritten"), "{refused}");
            assert_eq!(std::fs::read_to_string(&file).unwrap(), other);
        }
        let refused = check_output(&folder.path().join("a.ply"), &STL, "--stl").unwrap_err().to_string();
        assert!(refused.contains("does not end in .stl"), "{refused}");
        assert!(check_output(folder.path(), &REPORT, "-o").unwrap_err().to_string().contains("is a folder"));
    }

    #[test]
    fn one_file_by_two_paths_is_given_twice() {
        let folder = tempfile::tempdir().unwrap();
        let [a, again, b] = ["a.msh", "./a.msh", "b.msh"].map(|name| folder.path().join(name));
        assert!(check_distinct([&a, &b]).is_ok());
        assert!(check_distinct([&a, &again]).unwrap_err().to_string().contains("given twice"));
        std::fs::write(&a, "").unwrap();
        assert!(check_distinct([&again, &b, &a]).is_err());
    }
}
