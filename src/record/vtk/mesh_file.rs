//! A mesh at rest as one `.vtu` file, which the reader of meshes reads back: parts, node sets, fields of the elements.

use super::{Array, CellArrays, Grid, NumberType};
use crate::mesh::{ElementField, Mesh};
use std::collections::BTreeMap;
use std::io::{self, Write};

/// Writes a mesh, with further fields of its elements by name. The parts are the cell array `part`, numbers from 0 of the names in the
/// field data `parts`; node sets are point arrays of zeros and ones.
///
/// # Errors
/// If writing fails.
pub fn write_vtu(
    mesh: &Mesh,
    fields: &BTreeMap<String, ElementField>,
    out: &mut dyn Write,
) -> io::Result<()> {
    let reals =
        |values: &mut dyn Iterator<Item = f64>| values.flat_map(f64::to_le_bytes).collect::<Vec<u8>>();
    let coordinates = reals(&mut mesh.nodes.iter().flat_map(|x| x.iter().copied()));
    let points = Array::new("Points", NumberType::Float64, 3, &coordinates);
    let cells = CellArrays::new(mesh.cells.iter().map(|cell| {
        let vtk = &cell.kind.table().vtk;
        // Each of our nodes has a place in VTK's list.
        let mut nodes = vec![0; cell.nodes.len()];
        cell.nodes.iter().zip(vtk.order).for_each(|(node, place)| nodes[*place] = *node);
        (vtk.number, nodes)
    }));
    let parts: Vec<u8> = mesh.part_of.iter().flat_map(|part| part.to_le_bytes()).collect();
    let mut cell_data = vec![Array::new("part", NumberType::UInt32, 1, &parts)];
    for (name, field) in fields {
        let (components, bytes) = match field {
            ElementField::Scalars(values) => (1, reals(&mut values.iter().copied())),
            ElementField::Vectors(values) => (3, reals(&mut values.iter().flat_map(|v| v.iter().copied()))),
        };
        cell_data.push(Array::new(name, NumberType::Float64, components, &bytes));
    }
    let marks = |(name, set): (&String, &Vec<u32>)| {
        let mut marks = vec![0_u8; mesh.nodes.len()];
        for node in set {
            marks[*node as usize] = 1;
        }
        Array::new(name, NumberType::UInt8, 1, &marks)
    };
    let sets: Vec<Array> = mesh.node_sets.iter().map(marks).collect();
    let grid = Grid {
        point_count: mesh.nodes.len(),
        points: &points,
        cells: &cells,
        point_data: sets.iter().collect(),
        cell_data: cell_data.iter().collect(),
        field_data: vec![("parts", super::FieldValue::Texts(mesh.parts.clone()))],
    };
    grid.write(out)
}

#[cfg(test)]
#[allow(clippy::unwrap_used)] // tests may panic
mod tests {
    use super::*;
    use crate::mechanics::tensor::Vec3;
    use crate::mesh::CellKind;
    use crate::mesh::generate::block::Block;
    use crate::mesh::read::{FieldNames, MeshFormat, read_mesh_with};

    #[test]
    fn what_is_written_is_read_back_to_the_last_bit() {
        let size = Vec3::new(0.1, 0.2, 1.0 / 3.0);
        let hexes = Block::uniform(Vec3::zeros(), size, [2, 1, 3], "low").generate().unwrap();
        for kind in CellKind::ALL {
            let mut mesh = hexes.split_to(kind);
            mesh.parts.push("high".into());
            let count = mesh.cells.len();
            mesh.part_of = (0..count as u32).map(|e| e % 2).collect();
            let scalars = ElementField::Scalars((0..count).map(|e| 1.0 / (e + 1) as f64).collect());
            let vectors = ElementField::Vectors((0..count).map(|e| Vec3::new(e as f64, 0.1, -1.0)).collect());
            let fields = BTreeMap::from([("s".to_owned(), scalars), ("v".to_owned(), vectors)]);
            let mut bytes = Vec::new();
            write_vtu(&mesh, &fields, &mut bytes).unwrap();
            let requested: FieldNames = FieldNames::Named(["s", "v", "absent"].map(String::from).into());
            let read =
                read_mesh_with(&bytes, MeshFormat::Vtu, &requested, &mut |_| Err(String::new())).unwrap();
            assert_eq!((&read.nodes, &read.cells, &read.part_of), (&mesh.nodes, &mesh.cells, &mesh.part_of));
            assert_eq!(
                (&read.node_sets, &read.parts[..]),
                (&mesh.node_sets, &["low", "high"].map(String::from)[..])
            );
            for (name, field) in &fields {
                assert_eq!(read.fields.get(name), Some(field));
            }
            assert_eq!(read.fields.names().count(), 2);
            let all = read_mesh_with(&bytes, MeshFormat::Vtu, &FieldNames::All, &mut |_| Err(String::new()));
            assert_eq!(all.unwrap().fields, read.fields);
        }
    }
}
