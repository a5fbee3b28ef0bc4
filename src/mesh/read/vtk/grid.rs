//! An unstructured grid as VTK stores it, and the mesh made from it.

use super::cell_type::CellType;
use super::labels::{Labels, Owner, PART, is_set, part_rank};
use super::scalar::Values;
use crate::mechanics::tensor::Vec3;
use crate::mesh::cell::MOST_NODES;
use crate::mesh::read::FieldNames;
use crate::mesh::read::assembly::{Assembly, NodeTag, Unused};
use crate::mesh::{CellKind, ElementField, ElementFields, Mesh, MeshError, Place};
use std::collections::BTreeMap;

/// Points, cells, and the arrays that name parts and sets.
#[derive(Default)]
pub(super) struct Grid<'a> {
    /// Positions of the points.
    pub points: Vec<Vec3>,
    /// Points of all cells, one cell after the other.
    pub connectivity: Vec<i64>,
    /// Where each cell ends in `connectivity`.
    pub ends: Vec<i64>,
    /// Type of each cell.
    pub types: Vec<i64>,
    /// Byte offset of the cells in the file.
    pub cells_at: usize,
    /// Names of the parts by their numbers in the array `part`, where the file has them.
    pub part_names: Vec<String>,
    /// The array that gives the part of each cell, with its rank among those that could.
    parts: Option<(usize, Labels)>,
    /// Name and marks of each node set.
    sets: Vec<(String, Vec<i64>)>,
    /// Names of the requested cell arrays.
    requested: Option<&'a FieldNames>,
    /// The requested arrays that the file has, one value per cell.
    fields: ElementFields,
    /// Arrays that are not used.
    unused: Unused,
}

impl<'a> Grid<'a> {
    /// A grid of which the named arrays of cells are kept.
    pub(super) fn new(requested: &'a FieldNames) -> Self {
        Self { requested: Some(requested), ..Self::default() }
    }

    /// Whether an array is a field that was requested.
    fn is_field(&self, owner: Owner, name: &str, components: u64) -> bool {
        owner == Owner::Cells
            && matches!(components, 1 | 3)
            && self.requested.is_some_and(|requested| requested.include(name, part_rank(name).is_some()))
    }

    /// Whether an array, of integers, or of texts, could name parts or a set, or is requested, so that its values are to be read.
    pub(super) fn wants(
        &mut self,
        owner: Owner,
        name: &str,
        components: u64,
        (integers, texts): (bool, bool),
    ) -> bool {
        let names = components == 1
            && match owner {
                Owner::Cells => part_rank(name).is_some(),
                Owner::Points => integers && !name.starts_with("vtk"),
            };
        let wanted = names || !texts && self.is_field(owner, name, components);
        if !wanted {
            self.unused.add(name, None);
        }
        wanted
    }

    /// Adds an array that was wanted, of tuples of so many components.
    ///
    /// # Errors
    /// A message where there are two fields of one name.
    pub(super) fn add_array(
        &mut self,
        (owner, components): (Owner, u64),
        name: &str,
        values: Values,
    ) -> Result<(), String> {
        if self.is_field(owner, name, components)
            && let Some(numbers) = values.as_reals()
        {
            let field = if components == 1 {
                ElementField::Scalars(numbers)
            } else {
                ElementField::Vectors(numbers.as_chunks::<3>().0.iter().map(|v| Vec3::from(*v)).collect())
            };
            self.fields.add(name.to_owned(), field).map_err(|error| error.to_string())?;
            if part_rank(name).is_none() {
                return Ok(());
            }
        }
        match (owner, values) {
            (Owner::Points, Values::Integers(marks)) if is_set(&marks) => {
                self.sets.push((name.to_owned(), marks));
            }
            (Owner::Cells, values) => self.add_parts(name, values),
            _ => self.unused.add(name, None),
        }
        Ok(())
    }

    /// Keeps the labels of the array that comes first among those that name parts.
    fn add_parts(&mut self, name: &str, values: Values) {
        let better = part_rank(name).filter(|rank| self.parts.as_ref().is_none_or(|(best, _)| rank < best));
        let names = if name == PART { &self.part_names[..] } else { &[] };
        match (better, Labels::new(values, names)) {
            (Some(rank), Some(labels)) => self.parts = Some((rank, labels)),
            _ => self.unused.add(name, None),
        }
    }

    /// The mesh; `place` names the place of a byte offset.
    ///
    /// # Errors
    /// As [`read_mesh`](crate::mesh::read::read_mesh).
    pub(super) fn into_mesh(mut self, place: impl Fn(usize) -> Place) -> Result<Mesh, MeshError> {
        let at = self.cells_at;
        self.check().map_err(|message| MeshError::Malformed { place: place(at), message })?;
        let mut assembly = Assembly::default();
        for (tag, x) in (0..).zip(&self.points) {
            assembly.add_node(tag, *x);
        }
        let labels = self.parts.take().map(|(_, labels)| labels);
        self.add_cells(&mut assembly, labels.as_ref())
            .map_err(|message| MeshError::Malformed { place: place(at), message })?;
        for (name, marks) in std::mem::take(&mut self.sets) {
            let members = (0..).zip(&marks).filter(|(_, mark)| **mark != 0);
            let tags = members.map(|(tag, _)| NodeTag { tag, offset: at });
            assembly.node_sets.entry(name).or_default().extend(tags);
        }
        assembly.note_unused(("arrays", ""), &self.unused, Place::Byte);
        let is_volume = |cell: &usize| matches!(CellType::of(self.types[*cell]), Some(CellType::Volume(..)));
        let fields = self.fields.of_elements(&(0..self.types.len()).filter(is_volume));
        Ok(Mesh { fields, ..assembly.into_mesh(place)? })
    }

    /// Checks that the arrays of the cells belong together, and that their points exist.
    fn check(&self) -> Result<(), String> {
        if self.ends.len() != self.types.len() {
            return Err(format!("{} cells have {} types", self.ends.len(), self.types.len()));
        }
        let mut start = 0;
        for (cell, &end) in self.ends.iter().enumerate() {
            if end < start {
                return Err(format!("cell {cell} ends at {end}, before its start at {start}"));
            }
            start = end;
        }
        if usize::try_from(start) != Ok(self.connectivity.len()) {
            return Err(format!("the cells have {start} points, and {} are listed", self.connectivity.len()));
        }
        let points = self.points.len();
        let outside = |id: &i64| usize::try_from(*id).map_or(true, |id| id >= points);
        if let Some(index) = self.connectivity.iter().position(outside) {
            let cell = self.ends.partition_point(|end| *end <= (index as u64).cast_signed());
            let id = self.connectivity[index];
            return Err(format!(
                "cell {cell} has the point {id}; there are {points} points, numbered from 0"
            ));
        }
        match self.parts.as_ref().map(|(_, labels)| labels.len()) {
            Some(labels) if labels != self.types.len() => {
                Err(format!("{} cells have {labels} parts", self.types.len()))
            }
            _ => Ok(()),
        }
    }

    /// Points of a cell.
    fn nodes_of(&self, cell: usize) -> &[i64] {
        let start = if cell == 0 { 0 } else { self.ends[cell - 1] };
        &self.connectivity[start as usize..self.ends[cell] as usize]
    }

    /// Adds the cells with their parts; those of lower dimension become node sets.
    fn add_cells(&self, assembly: &mut Assembly, labels: Option<&Labels>) -> Result<(), String> {
        let wedges = self.order_of_wedges(assembly);
        let mut part_of_label: BTreeMap<usize, u32> = BTreeMap::new();
        let (mut boundary, mut unlabelled) = (BTreeMap::<usize, Vec<NodeTag>>::new(), 0);
        for (cell, &number) in self.types.iter().enumerate() {
            let nodes = self.nodes_of(cell);
            match CellType::of(number) {
                None => return Err(format!("cell {cell} is of type {number}, which VTK does not have")),
                Some(CellType::Empty) => {}
                Some(CellType::Other(name)) => {
                    *assembly.unsupported.entry(name.to_owned()).or_default() += 1;
                }
                Some(CellType::Boundary) => match labels {
                    Some(labels) => {
                        let set = boundary.entry(labels.of(cell)).or_default();
                        set.extend(nodes.iter().map(|&id| NodeTag { tag: id as u64, offset: self.cells_at }));
                    }
                    None => unlabelled += 1,
                },
                Some(CellType::Volume(kind, order)) => {
                    if nodes.len() != kind.node_count() {
                        let (title, found) = (kind.table().title, nodes.len());
                        return Err(format!("cell {cell} is a {title} with {found}"));
                    }
                    let order = if kind == CellKind::Wedge6 { wedges } else { order };
                    let ours = reordered(nodes, order);
                    assembly.add_cell(kind, &ours[..order.len()], self.cells_at);
                    // The first label stands for cells without labels.
                    let label = labels.map_or(0, |labels| labels.of(cell));
                    assembly.part_of.push(label as u32);
                    part_of_label.insert(label, 0);
                }
            }
        }
        // Parts in the order of their labels.
        let name = |label: usize| labels.map_or_else(|| "unnamed".to_owned(), |labels| labels.name(label));
        for (label, part) in &mut part_of_label {
            *part = assembly.part(&name(*label));
        }
        for part in &mut assembly.part_of {
            *part = part_of_label[&(*part as usize)];
        }
        for (label, set) in boundary {
            assembly.node_sets.insert(name(label), set);
        }
        if unlabelled > 0 {
            assembly.notes.push(format!(
                "{unlabelled} points, lines and surfaces without an array that names parts were omitted"
            ));
        }
        Ok(())
    }

    /// Places of our nodes of a wedge in its list. Its first triangle faces inwards, but outwards in files that follow the documentation
    /// of earlier versions of VTK; then all wedges read in the order of today are inside out.
    fn order_of_wedges(&self, assembly: &mut Assembly) -> &'static [usize] {
        let table = CellKind::Wedge6.table();
        let wedges = (0..self.types.len()).filter(|&cell| {
            self.types[cell] == i64::from(table.vtk.number) && self.nodes_of(cell).len() == table.points.len()
        });
        let volume = |cell: usize| {
            let ours = reordered(self.nodes_of(cell), table.vtk.order);
            let x: Vec<Vec3> = ours[..6].iter().map(|&id| self.points[id as usize]).collect();
            CellKind::Wedge6.volume_m3(&x)
        };
        let (mut count, mut inside_out) = (0, 0);
        for cell in wedges {
            count += 1;
            inside_out += usize::from(volume(cell) < 0.0);
        }
        if count == 0 || inside_out < count {
            return table.vtk.order;
        }
        assembly.notes.push(format!(
            "{count} wedges list the triangle that faces outwards first, as earlier versions of VTK documented them"
        ));
        &OUTWARD_FIRST
    }
}

/// Places of our nodes of a wedge whose first triangle faces outwards.
const OUTWARD_FIRST: [usize; 6] = [0, 2, 1, 3, 5, 4];

/// Node numbers in our order, as many as `order` has. They were checked to be in range.
fn reordered(nodes: &[i64], order: &[usize]) -> [u64; MOST_NODES] {
    let mut ours = [0; MOST_NODES];
    for (ours, &place) in ours.iter_mut().zip(order) {
        *ours = nodes[place] as u64;
    }
    ours
}
