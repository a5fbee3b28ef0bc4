//! Whatever is in a table of elements, it becomes fields of all elements of the mesh, or an error with its line.

use crate::file_changes::{apply, change};
use contuse::mechanics::tensor::Vec3;
use contuse::mesh::generate::block::Block;
use contuse::mesh::read::table::add_table;
use contuse::mesh::{ElementField, Mesh, MeshError, Place};
use proptest::prelude::*;
use std::sync::LazyLock;

const TABLES: [&str; 2] = [
    "element,stiffness,fibre_x,fibre_y,fibre_z\n# of the first\n0,1.0,0,0,1\n1,1.3e-1,0,0.1,1\n\n5,2,1,0,0\n",
    "part,stiffness\r\nlow,2\r\nhigh,0.5\r\n",
];

/// Two parts of three elements.
static MESH: LazyLock<Mesh> = LazyLock::new(|| {
    let mut mesh = Block::uniform(Vec3::zeros(), Vec3::repeat(0.01), [2, 3, 1], "low").generate().unwrap();
    mesh.parts.push("high".into());
    mesh.part_of = vec![0, 0, 0, 1, 1, 1];
    mesh
});

/// Adds a table to the mesh, and checks what became of it.
fn check(table: &[u8]) -> Result<Mesh, TestCaseError> {
    let mut mesh = MESH.clone();
    let lines = table.split(|byte| *byte == b'\n').count();
    match add_table(&mut mesh, table) {
        Ok(()) => {
            // The table has a byte for each of its fields.
            prop_assert!((1..=table.len()).contains(&mesh.fields.names().count()));
            for name in mesh.fields.names() {
                let count = match mesh.fields.get(name) {
                    Some(ElementField::Scalars(values)) => values.len(),
                    Some(ElementField::Vectors(values)) => values.len(),
                    None => 0,
                };
                prop_assert_eq!(count, mesh.cells.len());
            }
        }
        Err(MeshError::Malformed { place: Place::Line(line), message }) => {
            prop_assert!((1..=lines).contains(&line) && !message.is_empty(), "line {line}: {message}");
        }
        Err(MeshError::Unsupported { what, remedy }) => prop_assert!(!what.is_empty() && !remedy.is_empty()),
        Err(other) => prop_assert!(false, "without its line: {other}"),
    }
    Ok(mesh)
}

#[test]
fn the_tables_are_read_as_they_are() {
    for (table, fields) in TABLES.into_iter().zip([vec!["fibre", "stiffness"], vec!["stiffness"]]) {
        let mesh = check(table.as_bytes()).unwrap();
        assert_eq!(mesh.fields.names().collect::<Vec<_>>(), fields);
    }
}

#[test]
fn a_table_of_a_million_rows_or_columns_ends_at_the_first_that_is_none() {
    let rows = "0,1\n".repeat(1_000_000);
    check(format!("element,a\n{rows}").as_bytes()).unwrap();
    check(format!("element{}\n0\n", ",a".repeat(1_000_000)).as_bytes()).unwrap();
    check(format!("element,a\n0{}\n", ",1".repeat(1_000_000)).as_bytes()).unwrap();
}

proptest! {
    #[test]
    fn a_changed_table_is_read_or_refused(
        table in prop::sample::select(TABLES.to_vec()),
        changes in prop::collection::vec(change(), 1..5),
    ) {
        let mut bytes = table.as_bytes().to_vec();
        for change in changes {
            apply(&mut bytes, change);
        }
        check(&bytes)?;
    }

    #[test]
    fn only_elements_of_the_mesh_and_finite_numbers_are_accepted(element in any::<i64>(), value in any::<f64>()) {
        let mut mesh = MESH.clone();
        let found = add_table(&mut mesh, format!("element,a\n{element},{value:e}\n").as_bytes());
        let is_valid = (0..6).contains(&element) && value.is_finite();
        prop_assert_eq!(found.is_ok(), is_valid, "{:?}", found);
        let small = element.rem_euclid(6);
        let found = add_table(&mut MESH.clone(), format!("element,a\n{small},{value:e}\n").as_bytes());
        prop_assert_eq!(found.is_ok(), value.is_finite(), "{:?}", found);
    }
}
