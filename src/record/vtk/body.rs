//! A deformable body for VTK: the cells of its reference mesh, and its state at a field time.

use super::array::{Array, NumberType};
use super::grid::{CellArrays, FieldValue};
use super::packed_data::{Reason, array_of, arrays, checked, rows, u32s};
use crate::mesh::cell::MOST_NODES;
use crate::mesh::{Cell, CellKind, Cells};
use crate::record::proto::contuse::{ReferenceMesh, Stress};
use crate::record::stress::{self, ERODED};
use std::sync::Arc;

/// VTK's type of a hexahedron.
const HEXAHEDRON: u8 = 12;

/// What does not change of a deformable body.
#[derive(Debug)]
pub(super) struct Body {
    /// Name of the body.
    pub name: String,
    /// Its cells, with the nodes in the order of the mesh.
    pub cells: Cells,
    /// All of them for VTK.
    whole: Arc<CellsOfBody>,
    /// Part of each, little-endian u32.
    part_of: Vec<u8>,
    /// Values of the whole that do not change.
    fields: Vec<(&'static str, FieldValue)>,
    /// Positions of its nodes at rest [m], and the velocity of its flight [m/s].
    rest: Vec<[f64; 3]>,
    flight: [f64; 3],
}

/// Cells for VTK, with what does not depend on the deformation.
#[derive(Debug)]
pub(super) struct CellsOfBody {
    /// Nodes and types of the cells.
    pub cells: CellArrays,
    /// Their parts; the numbers of the elements, if some may be missing.
    pub data: Vec<Array>,
}

/// State of a body at a field time.
pub(super) struct BodyState {
    /// Positions of the nodes [m].
    pub positions: Vec<[f32; 3]>,
    /// The same for VTK.
    pub points: Array,
    /// Fields with a value at each node, in the units of the recording.
    pub nodal: Vec<Array>,
    /// Cells that are not eroded.
    pub cells: Arc<CellsOfBody>,
    /// Fields with a value for each of these cells.
    pub cell: Vec<Array>,
    /// 1 for each eroded cell of the mesh; empty if none can erode.
    pub eroded: Vec<u8>,
}

impl Body {
    /// From its reference mesh.
    pub fn of(mesh: &ReferenceMesh) -> Result<Self, Reason> {
        let rest = rest_of(checked(mesh.positions.as_ref(), "position_m", ("f64", 3))?);
        let flight = mesh.flight_velocity_m_per_s.unwrap_or_default();
        let (types, nodes) = match &mesh.hexes {
            Some(hexes) => {
                let nodes = checked(Some(hexes), "hexes", ("u32", 8))?;
                (vec![HEXAHEDRON; nodes.len() / 32], nodes)
            }
            None => (
                checked(mesh.cell_types.as_ref(), "cell_types", ("u8", 1))?.to_vec(),
                checked(mesh.cell_nodes.as_ref(), "cell_nodes", ("u32", 1))?,
            ),
        };
        let cells = cells_of(&types, nodes, rest.len())?;
        let part_of = checked(mesh.part_of.as_ref(), "part_of", ("u32", 1))?;
        if part_of.len() != 4 * cells.len() {
            return Err(format!("part_of has {} entries for {} cells", part_of.len() / 4, cells.len()));
        }
        Ok(Self {
            name: mesh.body.clone(),
            whole: Arc::new(cells_for_vtk(&cells, part_of, None)),
            part_of: part_of.to_vec(),
            fields: vec![
                ("body", FieldValue::Texts(vec![mesh.body.clone()])),
                ("role", FieldValue::Texts(vec![mesh.role.clone()])),
                ("parts", FieldValue::Texts(mesh.parts.clone())),
            ],
            cells,
            rest,
            flight: [flight.x, flight.y, flight.z],
        })
    }

    /// Values of the whole at a time.
    pub fn field_data(&self, time_s: f64) -> Vec<(&'static str, FieldValue)> {
        let time = ("TimeValue", FieldValue::Numbers(vec![time_s]));
        std::iter::once(time).chain(self.fields.iter().cloned()).collect()
    }

    /// Its state, from the message of a field time.
    pub fn state(&self, stress: &Stress) -> Result<BodyState, Reason> {
        let nodal = arrays(&stress.nodal, self.rest.len())?;
        let positions = stress::positions(stress, &self.rest, self.flight).ok_or_else(|| {
            format!("{} of the nodes is missing: an earlier version recorded it", stress::DISPLACEMENT)
        })?;
        let positions: Vec<_> = positions.iter().map(|x| x.map(|x| x as f32)).collect();
        // Eroded cells are omitted: of cells marked as hidden ParaView 5.11 leaves a hole without the faces behind.
        let count = self.cells.len();
        let eroded = stress.element.iter().find(|array| array.name == ERODED);
        let eroded = eroded.map_or(Ok(&[][..]), |array| checked(Some(array), ERODED, ("u8", 1)))?;
        if !eroded.is_empty() && eroded.len() != count {
            return Err(format!("{ERODED} has {} entries for {count} cells", eroded.len()));
        }
        let kept: Option<Vec<u32>> = (!eroded.is_empty()).then(|| {
            (0..count as u32).zip(eroded).filter(|(_, gone)| **gone == 0).map(|(cell, _)| cell).collect()
        });
        let kept = kept.as_deref();
        let fields = stress.element.iter().filter(|array| array.name != ERODED);
        Ok(BodyState {
            points: points_array(&positions),
            positions,
            nodal,
            cells: match kept {
                None => Arc::clone(&self.whole),
                Some(_) => Arc::new(cells_for_vtk(&self.cells, &self.part_of, kept)),
            },
            cell: fields.map(|array| array_of(array, count, kept)).collect::<Result<_, _>>()?,
            eroded: eroded.to_vec(),
        })
    }
}

/// Positions of packed little-endian f64.
fn rest_of(data: &[u8]) -> Vec<[f64; 3]> {
    let numbers: Vec<f64> = data.as_chunks().0.iter().map(|bytes| f64::from_le_bytes(*bytes)).collect();
    numbers.as_chunks().0.to_vec()
}

/// The kept cells for VTK, or all of them.
fn cells_for_vtk(cells: &Cells, part_of: &[u8], kept: Option<&[u32]>) -> CellsOfBody {
    let cell = |index: u32| {
        let Cell { kind, nodes } = cells.get(index as usize);
        let vtk = &kind.table().vtk;
        let mut in_order = [0; MOST_NODES];
        for (&place, &node) in vtk.order.iter().zip(nodes) {
            in_order[place] = node;
        }
        (vtk.number, in_order.into_iter().take(nodes.len()))
    };
    let part = Array::new("part", NumberType::UInt32, 1, &rows(part_of, 4, kept));
    let Some(kept) = kept else {
        return CellsOfBody { cells: CellArrays::new((0..cells.len() as u32).map(cell)), data: vec![part] };
    };
    let numbers: Vec<u8> = kept.iter().flat_map(|cell| cell.to_le_bytes()).collect();
    CellsOfBody {
        cells: CellArrays::new(kept.iter().copied().map(cell)),
        data: vec![part, Array::new("element", NumberType::UInt32, 1, &numbers)],
    }
}

/// Positions [m] as VTK's array of points, in single precision.
pub(super) fn points_array(positions: &[[f32; 3]]) -> Array {
    let data: Vec<u8> = positions.iter().flatten().flat_map(|x| x.to_le_bytes()).collect();
    Array::new("Points", NumberType::Float32, 3, &data)
}

/// Cells in the order of the mesh, from VTK types and nodes in VTK's order.
fn cells_of(types: &[u8], nodes: &[u8], node_count: usize) -> Result<Cells, Reason> {
    let nodes: Vec<u32> = u32s(nodes).collect();
    if let Some(node) = nodes.iter().find(|&&node| node as usize >= node_count) {
        return Err(format!("a cell has node {node} of {node_count}"));
    }
    let (mut cells, mut rest) = (Cells::default(), &nodes[..]);
    for number in types {
        let kind = CellKind::ALL.into_iter().find(|kind| kind.table().vtk.number == *number);
        let kind = kind.ok_or_else(|| format!("a cell has the unknown type {number}"))?;
        let own = rest.split_at_checked(kind.node_count());
        let (foreign, after) = own.ok_or("the cells have fewer nodes than their types say")?;
        let own: Vec<u32> = kind.table().vtk.order.iter().map(|&place| foreign[place]).collect();
        cells.push(kind, &own);
        rest = after;
    }
    if rest.is_empty() { Ok(cells) } else { Err("the cells have more nodes than their types say".into()) }
}
