//! A deformable body for VTK: the cells of its reference mesh, and its state at a field time.

use super::array::{Array, NumberType};
use super::grid::{CellArrays, FieldValue};
use super::packed_data::{Reason, arrays, checked, u32s};
use crate::mesh::{CellKind, Cells};
use crate::record::proto::contuse::{ReferenceMesh, Stress};
use crate::record::proto::foxglove::{NumericType, PointCloud};

/// VTK's type of a hexahedron.
const HEXAHEDRON: u8 = 12;
/// Mark of a cell that VTK hides (`vtkDataSetAttributes::HIDDENCELL`).
const HIDDEN: u8 = 32;

/// What does not change of a deformable body.
#[derive(Debug)]
pub(super) struct Body {
    /// Name of the body.
    pub name: String,
    /// Cells in the order and with the nodes of the mesh.
    pub cells: Cells,
    /// The same for VTK.
    pub arrays: CellArrays,
    /// Part of each cell.
    pub part_of: Array,
    /// Values of the whole that do not change.
    fields: Vec<(&'static str, FieldValue)>,
    node_count: usize,
}

impl Body {
    /// From its reference mesh.
    pub fn of(mesh: &ReferenceMesh) -> Result<Self, Reason> {
        let node_count = checked(mesh.positions.as_ref(), "position_m", ("f64", 3))?.len() / 24;
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
        let cells = cells_of(&types, nodes, node_count)?;
        let sizes = cells.iter().map(|cell| cell.nodes.len());
        let part_of = checked(mesh.part_of.as_ref(), "part_of", ("u32", 1))?;
        if part_of.len() != 4 * cells.len() {
            return Err(format!("part_of has {} entries for {} cells", part_of.len() / 4, cells.len()));
        }
        Ok(Self {
            name: mesh.body.clone(),
            arrays: CellArrays::new(nodes, sizes, &types),
            part_of: Array::new("part", NumberType::UInt32, 1, part_of),
            fields: vec![
                ("body", FieldValue::Texts(vec![mesh.body.clone()])),
                ("role", FieldValue::Texts(vec![mesh.role.clone()])),
                ("parts", FieldValue::Texts(mesh.parts.clone())),
            ],
            cells,
            node_count,
        })
    }

    /// Values of the whole at a time.
    pub fn field_data(&self, time_s: f64) -> Vec<(&'static str, FieldValue)> {
        let time = ("TimeValue", FieldValue::Numbers(vec![time_s]));
        std::iter::once(time).chain(self.fields.iter().cloned()).collect()
    }

    /// Its state, from the two messages of a field time.
    pub fn state(&self, stress: &Stress, cloud: &PointCloud) -> Result<BodyState, Reason> {
        let positions = positions_of(cloud)?;
        if positions.len() != self.node_count {
            return Err(format!("{} points for {} nodes", positions.len(), self.node_count));
        }
        let eroded = stress.element.iter().find(|array| array.name == "eroded");
        let eroded = eroded.map_or(Ok(&[][..]), |array| checked(Some(array), "eroded", ("u8", 1)))?.to_vec();
        let mut cell = arrays(&stress.element, self.cells.len())?;
        if !eroded.is_empty() {
            let hidden: Vec<u8> = eroded.iter().map(|&gone| if gone == 0 { 0 } else { HIDDEN }).collect();
            cell.push(Array::new("vtkGhostType", NumberType::UInt8, 1, &hidden));
        }
        Ok(BodyState {
            points: points_array(&positions),
            positions,
            nodal: arrays(&stress.nodal, self.node_count)?,
            cell,
            eroded,
        })
    }
}

/// State of a body at a field time.
pub(super) struct BodyState {
    /// Positions of the nodes, and the same for VTK.
    pub positions: Vec<[f32; 3]>,
    pub points: Array,
    /// Nodal fields.
    pub nodal: Vec<Array>,
    /// Fields of the cells.
    pub cell: Vec<Array>,
    /// 1 for each eroded cell; empty if the body cannot erode.
    pub eroded: Vec<u8>,
}

/// Positions for VTK.
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

/// Positions of the points of a cloud, whose first three fields are x, y, z.
fn positions_of(cloud: &PointCloud) -> Result<Vec<[f32; 3]>, Reason> {
    let stride = cloud.point_stride as usize;
    let is_place = |(i, name): (usize, &str)| {
        cloud.fields.get(i).is_some_and(|field| {
            let is_number = field.r#type == i32::from(NumericType::Float32);
            field.name == name && field.offset as usize == 4 * i && is_number
        })
    };
    if stride < 12
        || !cloud.data.len().is_multiple_of(stride)
        || !["x", "y", "z"].into_iter().enumerate().all(is_place)
    {
        return Err("the points do not begin with x, y, z".into());
    }
    Ok(cloud.data.chunks(stride).flat_map(|point| super::packed_data::triples(&point[..12])).collect())
}
