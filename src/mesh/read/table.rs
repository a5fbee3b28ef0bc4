//! Tables of the elements or parts of a mesh: CSV with a header. The first column is `element`, the number of an element from 0 in
//! the order of the file, or `part`, a name. Every other column is a field; three called `a_x`, `a_y`, `a_z` are the vectors `a`.
//! Lines that begin with `#` are comments.

use super::cursor::shown;
use crate::mechanics::tensor::Vec3;
use crate::mesh::{ElementField, Mesh, MeshError, Place};
use std::collections::BTreeMap;

/// Largest number of columns: each takes memory for all elements.
const MOST_COLUMNS: usize = 32;

/// What the rows stand for.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Rows {
    Elements,
    Parts,
}

/// Adds the columns of a table to the fields of a mesh. Elements without a row have NaN.
///
/// # Errors
/// `Malformed`, with the line, for a header or a row that is none, an element or part that does not exist or has a row already;
/// `Unsupported` for a column whose name a field of the mesh has.
pub fn add_table(mesh: &mut Mesh, table: &[u8]) -> Result<(), MeshError> {
    let text = std::str::from_utf8(table).map_err(|error| {
        let line = table[..error.valid_up_to()].split(|byte| *byte == b'\n').count();
        malformed(line, "the table is not UTF-8".into())
    })?;
    let mut lines = (1..)
        .zip(text.trim_start_matches('\u{feff}').lines().map(str::trim))
        .filter(|(_, line)| !line.is_empty() && !line.starts_with('#'));
    let (first, header) = lines.next().ok_or_else(|| malformed(1, "the table is empty".into()))?;
    let (rows, names) = read_header(header).map_err(|message| malformed(first, message))?;
    let mut columns = vec![vec![f64::NAN; mesh.cells.len()]; names.len()];
    let mut elements_of: BTreeMap<&str, Vec<usize>> = BTreeMap::new();
    if rows == Rows::Parts {
        for (element, &part) in mesh.part_of.iter().enumerate() {
            elements_of.entry(&mesh.parts[part as usize]).or_default().push(element);
        }
    }
    let mut seen = vec![false; mesh.cells.len()];
    for (number, line) in lines {
        let mut entries = line.split(',').map(str::trim);
        let of = entries.next().unwrap_or_default();
        let elements = match rows {
            Rows::Elements => of.parse().ok().filter(|e| *e < mesh.cells.len()).map(|e| vec![e]),
            Rows::Parts => elements_of.get(of).cloned(),
        };
        let elements = elements.ok_or_else(|| malformed(number, unknown(rows, of, mesh)))?;
        if elements.iter().any(|e| std::mem::replace(&mut seen[*e], true)) {
            return Err(malformed(number, format!("{} has a row already", shown(of.as_bytes()))));
        }
        for (name, column) in names.iter().zip(&mut columns) {
            let entry = entries.next().unwrap_or_default();
            let value = entry.parse().ok().filter(|value: &f64| value.is_finite()).ok_or_else(|| {
                let entry = shown(entry.as_bytes());
                malformed(number, format!("{entry} of the column {name} is not a finite number"))
            })?;
            for e in &elements {
                column[*e] = value;
            }
        }
        if entries.next().is_some() {
            return Err(malformed(number, format!("the row has more than {} entries", names.len() + 1)));
        }
    }
    add_columns(mesh, names, columns)
}

fn malformed(line: usize, message: String) -> MeshError {
    MeshError::Malformed { place: Place::Line(line), message }
}

fn unknown(rows: Rows, of: &str, mesh: &Mesh) -> String {
    let of = shown(of.as_bytes());
    match rows {
        Rows::Elements => {
            format!("there is no element {of}: they are numbered from 0 to {}", mesh.cells.len() - 1)
        }
        Rows::Parts => format!("the mesh has no part {of}"),
    }
}

/// What the rows stand for, and the names of the columns.
fn read_header(header: &str) -> Result<(Rows, Vec<String>), String> {
    let mut names = header.split(',').map(str::trim);
    let rows = match names.next() {
        Some("element") => Rows::Elements,
        Some("part") => Rows::Parts,
        other => {
            let other = shown(other.unwrap_or_default().as_bytes());
            return Err(format!("the first column is called \"element\" or \"part\", not {other}"));
        }
    };
    let names: Vec<String> = names.map(str::to_owned).collect();
    if names.is_empty() || names.len() > MOST_COLUMNS || names.iter().any(String::is_empty) {
        return Err(format!("the first column is followed by 1 to {MOST_COLUMNS} others, each with a name"));
    }
    match (1..names.len()).find(|&i| names[..i].contains(&names[i])) {
        Some(i) => Err(format!("two columns are called {}", shown(names[i].as_bytes()))),
        None => Ok((rows, names)),
    }
}

/// Makes fields of the columns: vectors of those that end in `_x`, `_y`, `_z`.
fn add_columns(mesh: &mut Mesh, names: Vec<String>, columns: Vec<Vec<f64>>) -> Result<(), MeshError> {
    let mut columns: BTreeMap<String, Vec<f64>> = names.into_iter().zip(columns).collect();
    let bases: Vec<String> =
        columns.keys().filter_map(|name| Some(name.strip_suffix("_x")?.to_owned())).collect();
    for base in bases {
        let named = ["_x", "_y", "_z"].map(|axis| format!("{base}{axis}"));
        if named.iter().all(|name| columns.contains_key(name)) {
            let [x, y, z] = named.map(|name| columns.remove(&name).unwrap_or_default());
            let vectors = x.iter().zip(&y).zip(&z).map(|((x, y), z)| Vec3::new(*x, *y, *z)).collect();
            mesh.fields.add(base, ElementField::Vectors(vectors))?;
        }
    }
    columns.into_iter().try_for_each(|(name, values)| mesh.fields.add(name, ElementField::Scalars(values)))
}

#[cfg(test)]
#[allow(clippy::unwrap_used)] // tests may panic
mod tests {
    use super::*;
    use crate::mesh::generate::block::Block;

    fn mesh() -> Mesh {
        let mut mesh =
            Block::uniform(Vec3::zeros(), Vec3::new(1.0, 1.0, 3.0), [1, 1, 3], "low").generate().unwrap();
        mesh.parts.push("high".into());
        mesh.part_of = vec![0, 0, 1];
        mesh
    }

    #[test]
    fn columns_become_fields_of_elements_or_parts() {
        let mut mesh = mesh();
        add_table(&mut mesh, b"\xef\xbb\xbfelement, a_x,a_y ,a_z,s\r\n# the top\n2,0,0,1,0.5\n\n0,1,0,0,2\n")
            .unwrap();
        assert_eq!(mesh.fields.names().collect::<Vec<_>>(), ["a", "s"]);
        let Some(ElementField::Vectors(a)) = mesh.fields.get("a") else { panic!("no vectors") };
        assert_eq!((a[0], a[2]), (Vec3::x(), Vec3::z()));
        assert!(a[1].x.is_nan());
        add_table(&mut mesh, b"part,k\nhigh,3\nlow,7").unwrap();
        assert_eq!(mesh.fields.get("k"), Some(&ElementField::Scalars(vec![7.0, 7.0, 3.0])));
    }

    #[test]
    fn whatever_is_no_table_is_refused_with_its_line() {
        for (table, line, word) in [
            ("", 1, "empty"),
            ("id,a\n", 1, "\"element\" or \"part\""),
            ("element\n", 1, "1 to 32"),
            ("element,a,\n", 1, "each with a name"),
            ("element,a,a\n", 1, "two columns"),
            ("element,a\n3,1\n", 2, "numbered from 0 to 2"),
            ("element,a\n-1,1\n", 2, "there is no element"),
            ("element,a\n99999999999999999999,1\n", 2, "there is no element"),
            ("part,a\nbone,1\n", 2, "no part"),
            ("element,a\n0,1\n\n0,2\n", 4, "already"),
            ("element,a\n0\n", 2, "is not a finite number"),
            ("element,a\n0,x\n", 2, "is not a finite number"),
            ("element,a\n0,nan\n", 2, "is not a finite number"),
            ("element,a\n0,1e999\n", 2, "is not a finite number"),
            ("element,a\n0,1,2\n", 2, "more than 2"),
        ] {
            let error = add_table(&mut mesh(), table.as_bytes()).unwrap_err();
            let MeshError::Malformed { place, message } = &error else { panic!("{error}") };
            assert_eq!(*place, Place::Line(line), "{table:?}: {message}");
            assert!(message.contains(word), "{table:?}: {message}");
        }
        let error = add_table(&mut mesh(), b"element,a\n0,1\n1,\xff").unwrap_err();
        assert!(error.to_string().starts_with("line 3"), "{error}");
        let columns = format!("element{}", ",a".repeat(100_000));
        assert!(add_table(&mut mesh(), columns.as_bytes()).is_err());
        let mut twice = mesh();
        add_table(&mut twice, b"element,a\n0,1").unwrap();
        assert!(
            add_table(&mut twice, b"part,a\nlow,1").unwrap_err().to_string().contains("two arrays \"a\"")
        );
    }
}
