//! The files of a deck: the keyword file and those that it includes, in the order in which they are read.

use crate::mesh::read::cursor::{Numbers, place_of, shown};
use crate::mesh::read::include::Include;
use crate::mesh::{MeshError, Place};
use std::borrow::Cow;
use std::ops::Range;

/// Largest number of files within each other.
const DEEPEST: usize = 10;
/// Largest number of included files.
const MOST_FILES: usize = 100;

/// A keyword file with its included files.
pub(super) struct Deck<'a> {
    files: Vec<File<'a>>,
    /// Files and ranges of their bytes, in the order in which they are read.
    pieces: Vec<(usize, Range<usize>)>,
}

struct File<'a> {
    name: String,
    bytes: Cow<'a, [u8]>,
    /// Offset of its first byte if all files are laid end to end.
    base: usize,
}

/// A line with its offset if all files are laid end to end; comments are omitted.
pub(super) struct Line<'d> {
    pub(super) offset: usize,
    pub(super) bytes: &'d [u8],
}

impl<'a> Deck<'a> {
    /// The deck of a keyword file; `include` reads the files that it names.
    ///
    /// # Errors
    /// `Malformed` or `Unsupported` with the line of an include that is not followed.
    pub(super) fn new(bytes: &'a [u8], include: Include) -> Result<Self, MeshError> {
        let file = File { name: String::new(), bytes: Cow::Borrowed(bytes), base: 0 };
        let mut deck = Self { files: vec![file], pieces: Vec::new() };
        deck.follow(&mut vec![0], include)?;
        Ok(deck)
    }

    /// Number of bytes of all files.
    pub(super) fn size(&self) -> usize {
        self.files.last().map_or(0, |file| file.base + file.bytes.len())
    }

    /// Place of an offset.
    pub(super) fn place(&self, offset: usize) -> Place {
        let index = self.files.partition_point(|file| file.base <= offset).saturating_sub(1);
        let file = &self.files[index];
        match place_of(&file.bytes, offset - file.base, Numbers::Text) {
            Place::Line(line) if index > 0 => Place::LineOf { file: file.name.clone(), line },
            place => place,
        }
    }

    /// All lines, without comments, in the order in which they are read.
    pub(super) fn lines(&self) -> impl Iterator<Item = Line<'_>> {
        self.pieces.iter().flat_map(|(index, range)| {
            let file = &self.files[*index];
            lines(&file.bytes, range.clone())
                .map(|(range, bytes)| Line { offset: file.base + range.start, bytes })
        })
    }

    /// Adds the pieces of the last of the `open` files and those of its included files; the others are around it.
    fn follow(&mut self, open: &mut Vec<usize>, include: Include) -> Result<(), MeshError> {
        let Some(&index) = open.last() else { return Ok(()) };
        let (includes, end) = self.includes(index)?;
        let mut start = 0;
        for Named { name, line, after } in includes {
            self.pieces.push((index, start..line));
            start = after;
            let place = self.place(self.files[index].base + line);
            let refused = |what: String, remedy: &str| MeshError::Unsupported {
                what: format!("{place}: the included file {} {what}", shown(name.as_bytes())),
                remedy: remedy.to_owned(),
            };
            if open.len() > DEEPEST || self.files.len() > MOST_FILES {
                let what = format!("is one of more than {MOST_FILES}, or lies deeper than {DEEPEST} others");
                return Err(refused(what, "put everything into one file"));
            }
            let bytes = include(&name).map_err(|reason| {
                refused(format!("is not read: {reason}"), "put everything into one file, or beside it")
            })?;
            // All files lie in one folder, so the same content includes the same files again.
            if open.iter().any(|around| *self.files[*around].bytes == *bytes) {
                let what = "is this file, or one that includes it: it would include itself without end";
                return Err(refused(what.into(), "remove this *INCLUDE"));
            }
            open.push(self.files.len());
            self.files.push(File { name: name.clone(), bytes: Cow::Owned(bytes), base: self.size() });
            self.follow(open, include)?;
            open.pop();
        }
        self.pieces.push((index, start..end));
        Ok(())
    }

    /// The includes of a file, and where it ends.
    fn includes(&self, index: usize) -> Result<(Vec<Named>, usize), MeshError> {
        let file = &self.files[index];
        let mut found = Vec::new();
        let mut in_include = false;
        // The beginning of a name that continues on the next line.
        let mut unfinished: Option<(String, usize)> = None;
        for (range, line) in lines(&file.bytes, 0..file.bytes.len()) {
            if let Some(keyword) = keyword_of(line) {
                let place = || self.place(file.base + range.start);
                match keyword.as_str() {
                    "INCLUDE" => in_include = true,
                    "END" => return Ok((found, range.start)),
                    other if other.starts_with("INCLUDE_") => {
                        return Err(MeshError::Unsupported {
                            what: format!("{}: *{other}", place()),
                            remedy: "put everything into one file, or include it as it is".into(),
                        });
                    }
                    _ => in_include = false,
                }
                continue;
            }
            let text = String::from_utf8_lossy(line);
            if !in_include || text.trim().is_empty() {
                continue;
            }
            let (mut name, start) = unfinished.take().unwrap_or_else(|| (String::new(), range.start));
            if let Some(part) = text.trim_end().strip_suffix(" +") {
                unfinished = Some((name + part.trim(), start));
                continue;
            }
            name += text.trim();
            found.push(Named { name, line: start, after: range.end });
        }
        Ok((found, file.bytes.len()))
    }
}

/// The name of an included file, and the bytes of its line or lines.
struct Named {
    name: String,
    line: usize,
    after: usize,
}

/// The keyword of a line in capitals, without asterisk, format and options; `None` for data.
pub(super) fn keyword_of(line: &[u8]) -> Option<String> {
    let text = String::from_utf8_lossy(line.strip_prefix(b"*")?);
    let name = text.split_whitespace().next().unwrap_or_default();
    Some(name.trim_end_matches(['+', '-', '%']).to_ascii_uppercase())
}

/// The lines in a range of bytes, without comments, each with its range; the line break is not part of it.
fn lines(bytes: &[u8], range: Range<usize>) -> impl Iterator<Item = (Range<usize>, &[u8])> {
    let mut start = range.start;
    std::iter::from_fn(move || {
        while start < range.end {
            let rest = &bytes[start..range.end];
            let length = rest.iter().position(|&b| b == b'\n').unwrap_or(rest.len());
            let here = start..(start + length + 1).min(range.end);
            start = here.end;
            let line = rest[..length].trim_ascii_end();
            if !line.starts_with(b"$") {
                return Some((here, line));
            }
        }
        None
    })
}
