//! Contact problems as JSON files: `{"name", "nc", "mu", "q", "W", …}`, one problem each.
//!
//! `W.format` is `dense` (row-major `v`), `coo` (`i`, `j` from 0, `v`) or `sym-upper-b64` (`b64`: URL-safe base64 of the
//! little-endian upper triangle, row by row, `dtype` `f8` or `f4`). Three rows (n, t1, t2) a contact.

use crate::mechanics::contact::solution::delassus::{Block, Delassus};
use crate::mechanics::contact::solution::problem::{ContactProblem, LARGEST};
use crate::scene::problem::Pointer;
use crate::scene::{Problem, Problems};
use base64::Engine as _;
use base64::alphabet::URL_SAFE;
use base64::engine::{DecodePaddingMode, GeneralPurpose, GeneralPurposeConfig};
use serde_json::{Map, Value, json};

/// Order of the rows.
const FRAME: &str = "per contact (n,t1,t2): index 3*c is normal";
/// Default remedy for a file that cannot be read.
const REMEDY: &str = "write it as docs/contact-solvers.md says under \"Your own problems\"";

/// A contact problem with its name.
#[derive(Clone, Debug, PartialEq)]
pub struct NamedContactProblem {
    /// Name of the problem.
    pub name: String,
    /// The problem in the form W, q, μ.
    pub problem: ContactProblem,
}

/// Reads one file; `place` is prepended to every pointer.
///
/// # Errors
/// All errors in the file, with their locations.
pub fn read_contact_problem(bytes: &[u8], place: &str) -> Result<NamedContactProblem, Problems> {
    let root = Pointer::from_text(place);
    let document: Value = serde_json::from_slice(bytes)
        .map_err(|error| Problem::error("json", &root, format!("This is no JSON: {error}.")).alone())?;
    let Value::Object(members) = document else {
        return Err(Problem::error("type", &root, "A contact problem is an object.").alone());
    };
    Reader { members: &members, root, problems: Vec::new() }.read()
}

/// Collects problems while reading.
struct Reader<'a> {
    members: &'a Map<String, Value>,
    root: Pointer,
    problems: Vec<Problem>,
}

impl Reader<'_> {
    fn read(mut self) -> Result<NamedContactProblem, Problems> {
        let name = self.members.get("name").and_then(Value::as_str).map(str::to_owned);
        if name.is_none() {
            self.report("missing", &self.root.key("name"), "A problem has a name.");
        }
        // Vectors μ and q, and the optional declarations.
        let mu = self.numbers(self.members.get("mu"), &self.root.key("mu"));
        let q = self.numbers(self.members.get("q"), &self.root.key("q"));
        let contacts = mu.as_ref().map_or(0, Vec::len);
        if let Some(nc) = self.members.get("nc")
            && mu.is_some()
            && nc.as_u64() != Some(contacts as u64)
        {
            self.report(
                "length",
                &self.root.key("nc"),
                format!("There are {contacts} numbers in mu, but nc is {nc}."),
            );
        }
        self.expect_word(self.members.get("frame"), &[FRAME], &self.root.key("frame"));
        if self.members.get("dim").is_some_and(|dim| dim.as_u64() != Some(3)) {
            self.report(
                "unsupported",
                &self.root.key("dim"),
                "Only problems in three dimensions are solved.",
            );
        }
        // Assemble the problem if nothing is wrong.
        let W = self.operator(contacts);
        if let (Some(name), Some(mu), Some(q), Some(W), true) = (name, mu, q, W, self.problems.is_empty()) {
            match ContactProblem::new(W, q, mu) {
                Ok(problem) => return Ok(NamedContactProblem { name, problem }),
                Err(error) => self.report("value", &self.root.clone(), format!("{error}.")),
            }
        }
        let problem_of =
            |problem: Problem| if problem.remedy.is_empty() { problem.remedy(REMEDY) } else { problem };
        Err(Problems(self.problems.into_iter().map(problem_of).collect()))
    }

    /// Checks an optional word, which must be one of these or begin with it.
    fn expect_word(&mut self, found: Option<&Value>, words: &[&str], pointer: &Pointer) {
        let Some(found) = found else { return };
        if !found.as_str().is_some_and(|text| words.iter().any(|word| text.starts_with(word))) {
            let problem = Problem::error("unsupported", pointer, "Numbers in this order are not read.");
            self.problems.push(problem.value(found.clone()).limit(words.join(" or ")));
        }
    }

    fn report(&mut self, code: &'static str, pointer: &Pointer, message: impl Into<String>) {
        self.problems.push(Problem::error(code, pointer, message));
    }

    /// Reads a list of finite numbers.
    fn numbers(&mut self, value: Option<&Value>, pointer: &Pointer) -> Option<Vec<f64>> {
        let Some(Value::Array(items)) = value else {
            self.report("type", pointer, "This must be a list of numbers.");
            return None;
        };
        let bad = items.iter().position(|x| !x.as_f64().is_some_and(|x| x.abs() <= LARGEST));
        if let Some(index) = bad {
            let message = "This is not a number that can be calculated with.";
            let problem = Problem::error("value", &pointer.index(index), message);
            self.problems
                .push(problem.value(items[index].clone()).limit(format!("a number of at most {LARGEST:e}")));
            return None;
        }
        Some(items.iter().filter_map(Value::as_f64).collect())
    }

    fn operator(&mut self, contacts: usize) -> Option<Delassus> {
        let pointer = self.root.key("W");
        let Some(Value::Object(W)) = self.members.get("W") else {
            self.report("type", &pointer, "W must be an object with a format.");
            return None;
        };
        let n = 3 * contacts;
        if let Some(shape) = W.get("shape").filter(|shape| **shape != json!([n, n])) {
            let problem =
                Problem::error("length", &pointer.key("shape"), "W has another shape than mu asks for.");
            self.problems
                .push(problem.value(shape.clone()).limit(format!("[{n}, {n}], three rows a contact")));
        }
        self.expect_word(W.get("order"), &["row-major"], &pointer.key("order"));
        match W.get("format").and_then(Value::as_str) {
            Some("dense") => {
                let values = self.numbers(W.get("v"), &pointer.key("v"))?;
                self.dense(contacts, values, &pointer.key("v"))
            }
            Some("coo") => self.coordinates(contacts, W, &pointer),
            Some("sym-upper-b64") => self.triangle(contacts, W, &pointer),
            _ => {
                let found = W.get("format").cloned().unwrap_or_default();
                let problem =
                    Problem::error("unsupported", &pointer.key("format"), "This format is not known.");
                self.problems.push(problem.value(found).limit("dense, coo or sym-upper-b64"));
                None
            }
        }
    }

    fn dense(&mut self, contacts: usize, values: Vec<f64>, pointer: &Pointer) -> Option<Delassus> {
        match Delassus::dense(contacts, values) {
            Ok(W) => Some(W),
            Err(error) => {
                self.report("length", pointer, format!("{error}."));
                None
            }
        }
    }

    fn coordinates(
        &mut self,
        contacts: usize,
        W: &Map<String, Value>,
        pointer: &Pointer,
    ) -> Option<Delassus> {
        let v = self.numbers(W.get("v"), &pointer.key("v"));
        let i = self.indices(W.get("i"), 3 * contacts, &pointer.key("i"));
        let j = self.indices(W.get("j"), 3 * contacts, &pointer.key("j"));
        let (v, i, j) = (v?, i?, j?);
        if i.len() != v.len() || j.len() != v.len() {
            let lengths = format!("There are {} rows, {} columns and {} values.", i.len(), j.len(), v.len());
            self.report("length", pointer, lengths);
            return None;
        }
        let entries = i.iter().zip(&j).zip(&v).map(|((&i, &j), &v)| {
            let mut block: Block = [[0.0; 3]; 3];
            block[i % 3][j % 3] = v;
            (i / 3, j / 3, block)
        });
        Delassus::from_blocks(contacts, entries).ok()
    }

    /// Reads a list of indices below `end`.
    fn indices(&mut self, value: Option<&Value>, end: usize, pointer: &Pointer) -> Option<Vec<usize>> {
        let Some(Value::Array(items)) = value else {
            self.report("type", pointer, "This must be a list of indices.");
            return None;
        };
        let index = |x: &Value| x.as_u64().and_then(|x| usize::try_from(x).ok()).filter(|x| *x < end);
        if let Some(bad) = items.iter().position(|x| index(x).is_none()) {
            let problem = Problem::error("value", &pointer.index(bad), "This is not a row of W.");
            self.problems
                .push(problem.value(items[bad].clone()).limit(format!("0 to {}", end.saturating_sub(1))));
            return None;
        }
        Some(items.iter().filter_map(index).collect())
    }

    fn triangle(&mut self, contacts: usize, W: &Map<String, Value>, pointer: &Pointer) -> Option<Delassus> {
        let config = GeneralPurposeConfig::new().with_decode_padding_mode(DecodePaddingMode::Indifferent);
        let text = W.get("b64").and_then(Value::as_str);
        let Some(bytes) = text.and_then(|text| GeneralPurpose::new(&URL_SAFE, config).decode(text).ok())
        else {
            self.report("value", &pointer.key("b64"), "This is no URL-safe base64.");
            return None;
        };
        // Decode the packed numbers.
        let packed: Vec<f64> = match W.get("dtype").and_then(Value::as_str) {
            Some("f8" | "<f8") => {
                bytes.as_chunks::<8>().0.iter().map(|bytes| f64::from_le_bytes(*bytes)).collect()
            }
            Some("f4" | "<f4") => {
                bytes.as_chunks::<4>().0.iter().map(|bytes| f64::from(f32::from_le_bytes(*bytes))).collect()
            }
            _ => {
                self.report("unsupported", &pointer.key("dtype"), "The type must be f8 or f4.");
                return None;
            }
        };
        let n = 3 * contacts;
        let expected = n * (n + 1) / 2;
        if packed.len() != expected {
            let lengths =
                format!("The triangle of {n} rows has {expected} numbers, here are {}.", packed.len());
            self.report("length", &pointer.key("b64"), lengths);
            return None;
        }
        // Expand the upper triangle to a full symmetric matrix.
        let mut values = vec![0.0; n * n];
        let mut packed = packed.into_iter();
        for i in 0..n {
            for (j, x) in (i..n).zip(&mut packed) {
                values[i * n + j] = x;
                values[j * n + i] = x;
            }
        }
        self.dense(contacts, values, &pointer.key("b64"))
    }
}

/// Document of a problem, with W by its nonzero values; μ = ∞ cannot be represented.
pub fn contact_problem_document(named: &NamedContactProblem, source: &str) -> Value {
    let problem = &named.problem;
    let n = 3 * problem.contacts();
    let (mut i, mut j, mut v) = (Vec::new(), Vec::new(), Vec::new());
    problem.W().for_each_block(|c, d, block| {
        for (a, row) in block.iter().enumerate() {
            for (b, x) in row.iter().enumerate().filter(|(_, x)| **x != 0.0) {
                i.push(3 * c + a);
                j.push(3 * d + b);
                v.push(*x);
            }
        }
    });
    json!({
        "name": named.name,
        "source": source,
        "dim": 3,
        "nc": problem.contacts(),
        "frame": FRAME,
        "mu": problem.mu(),
        "q": problem.q(),
        "W": { "format": "coo", "shape": [n, n], "i": i, "j": j, "v": v },
    })
}
