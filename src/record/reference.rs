//! `/reference/{body}`: the undeformed mesh, which makes the recording self-contained.

use super::packed;
use super::proto::contuse::ReferenceMesh;
use crate::mesh::Cells;
use crate::plan::Plan;
use crate::scene::document::Role;

/// Topic prefix, followed by the body's name.
pub const TOPIC: &str = "/reference/";
/// Schema of a mesh of hexahedra.
const SCHEMA: &str = "contuse.v1.ReferenceMesh";
/// Schema of a mesh with other cells.
const MIXED_SCHEMA: &str = "contuse.v1.MixedReferenceMesh";

/// Schema of a message.
pub fn schema(message: &ReferenceMesh) -> &'static str {
    if message.hexes.is_some() { SCHEMA } else { MIXED_SCHEMA }
}

/// Name of a role.
pub(super) fn role_name(role: Role) -> &'static str {
    match role {
        Role::Projectile => "projectile",
        Role::Tissue => "tissue",
        Role::Other => "other",
    }
}

/// The message of one body.
pub fn message(plan: &Plan, body: usize) -> ReferenceMesh {
    let body = &plan.bodies[body];
    let (first, last) = (body.nodes.start, body.nodes.end as usize);
    let mut message = ReferenceMesh {
        time_s: 0.0,
        body: body.name.clone(),
        role: role_name(body.role).into(),
        parts: body.parts.clone(),
        positions: Some(packed::f64s(
            "position_m",
            "m",
            plan.X[first as usize..last].iter().map(|x| [x.x, x.y, x.z]),
        )),
        part_of: Some(packed::u32s("part_of", body.part_of.iter().map(|&part| [part]))),
        flight_velocity_m_per_s: Some(body.flight_velocity.into()),
        ..ReferenceMesh::default()
    };
    put_cells(&body.cells, first, &mut message);
    message
}

/// Adds the cells, with node numbers relative to the body's `first`.
fn put_cells(cells: &Cells, first: u32, message: &mut ReferenceMesh) {
    if let Some(hexes) = cells.hexes() {
        let local = hexes.iter().map(|hex| hex.map(|node| node - first));
        message.hexes = Some(packed::u32s("hexes", local));
        return;
    }
    let (types, nodes) = cells.in_vtk();
    message.cell_types = Some(packed::u8s("cell_types", types));
    message.cell_nodes = Some(packed::u32s("cell_nodes", nodes.into_iter().map(|node| [node - first])));
}

#[cfg(test)]
#[allow(clippy::unwrap_used)] // tests may panic
mod tests {
    use super::*;
    use crate::mesh::CellKind;

    #[test]
    fn mixed_cells_are_reported_with_their_types_in_the_order_of_vtk() {
        let mut cells = Cells::from(vec![[10, 11, 12, 13, 14, 15, 16, 17]]);
        let mut message = ReferenceMesh::default();
        put_cells(&cells, 10, &mut message);
        assert_eq!(schema(&message), SCHEMA);
        let hexes = message.hexes.unwrap();
        assert_eq!((hexes.count, hexes.components), (1, 8));
        assert!(message.cell_types.is_none() && message.cell_nodes.is_none());

        cells.push(CellKind::Wedge6, &[14, 15, 16, 18, 19, 20]);
        let mut message = ReferenceMesh::default();
        put_cells(&cells, 10, &mut message);
        assert_eq!((schema(&message), &message.hexes), (MIXED_SCHEMA, &None));
        assert_eq!(message.cell_types.unwrap().data, [12, 13]);
        let nodes = message.cell_nodes.unwrap();
        let numbers: Vec<u32> =
            nodes.data.as_chunks().0.iter().map(|bytes| u32::from_le_bytes(*bytes)).collect();
        assert_eq!(numbers, [0, 1, 2, 3, 4, 5, 6, 7, 4, 5, 6, 8, 9, 10]);
    }
}
