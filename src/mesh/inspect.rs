//! Contents of a mesh: kinds, parts, sets, size, and element quality with the worst elements.

use super::Mesh;
use super::quality::{ElementQuality, element_quality};
use super::report::{MeshReport, finite};
use serde::Serialize;

/// Number of the worst elements that are listed.
pub const WORST: usize = 10;

/// Number of bins of the histogram between scaled Jacobians 0 and 1.
const BINS: usize = 10;

/// Contents of a mesh, and its elements in more detail than its report has.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Inspection {
    /// Contents and quality, as of an uploaded mesh.
    #[serde(flatten)]
    pub report: MeshReport,
    /// Number of elements of each kind.
    pub kinds: Vec<KindCount>,
    /// Volumes of the parts, in the order of the mesh.
    pub part_volumes: Vec<PartVolume>,
    /// Numbers of elements by their smallest scaled Jacobian.
    pub histogram: Vec<Bin>,
    /// The elements with the smallest scaled Jacobians, worst first.
    pub worst: Vec<WorstElement>,
}

/// Elements of one kind.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct KindCount {
    /// Name of the kind ("hex8").
    pub kind: &'static str,
    /// Number of elements of this kind.
    pub elements: usize,
}

/// Volume of a part.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PartVolume {
    /// Name of the part, as the mesh has it.
    pub part: String,
    /// Sum over its elements, in the cube of the unit of the file.
    pub volume: f64,
}

/// Elements whose smallest scaled Jacobian is above `from` and at most `to` [-].
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Bin {
    /// Scaled Jacobian that its elements exceed [-]; −1 in the first bin, which has all that are not positive.
    pub from: f64,
    /// Largest scaled Jacobian of its elements [-].
    pub to: f64,
    /// Number of elements in this bin.
    pub elements: usize,
}

/// An element of poor quality, and where it is.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct WorstElement {
    /// Index of the element, in the order of the file.
    pub element: usize,
    /// Name of its kind, as in `kinds` ("hex8").
    pub kind: &'static str,
    /// Name of its part.
    pub part: String,
    /// Mean of the positions of its nodes.
    pub centre: [f64; 3],
    /// Smallest scaled Jacobian of its corners and quadrature points [-].
    pub scaled_jacobian: f64,
    /// Ratio of its longest to its shortest edge [-]; null if an edge has no length.
    pub aspect_ratio: Option<f64>,
}

/// Contents and quality of a mesh; `None` without elements.
pub fn inspect(mesh: &Mesh) -> Option<Inspection> {
    let report = MeshReport::of(mesh)?;
    let of_element: Vec<ElementQuality> =
        mesh.cells.iter().map(|cell| element_quality(cell.kind, &cell.points(&mesh.nodes))).collect();
    let kinds = mesh.cells.counts().into_iter();
    Some(Inspection {
        report,
        kinds: kinds.map(|(kind, elements)| KindCount { kind: kind.table().name, elements }).collect(),
        part_volumes: part_volumes(mesh, &of_element),
        histogram: histogram(&of_element),
        worst: worst(mesh, &of_element),
    })
}

fn part_volumes(mesh: &Mesh, of_element: &[ElementQuality]) -> Vec<PartVolume> {
    let empty = |name: &String| PartVolume { part: name.clone(), volume: 0.0 };
    let mut volumes: Vec<PartVolume> = mesh.parts.iter().map(empty).collect();
    for (&part, element) in mesh.part_of.iter().zip(of_element) {
        volumes[part as usize].volume += element.volume_m3;
    }
    volumes
}

/// One bin for Jacobians that are not positive, and equal ones above zero. Jacobians are at most 1 up to rounding.
fn histogram(of_element: &[ElementQuality]) -> Vec<Bin> {
    let width = 1.0 / BINS as f64;
    let positive = (0..BINS).map(|bin| (bin as f64 * width, (bin + 1) as f64 * width));
    let ends = std::iter::once((-1.0, 0.0)).chain(positive);
    let mut bins: Vec<Bin> = ends.map(|(from, to)| Bin { from, to, elements: 0 }).collect();
    for element in of_element {
        let jacobian = element.min_scaled_jacobian();
        // Also where it is not a number.
        let bin = if jacobian > 0.0 { ((jacobian / width).ceil() as usize).min(BINS) } else { 0 };
        bins[bin].elements += 1;
    }
    bins
}

fn worst(mesh: &Mesh, of_element: &[ElementQuality]) -> Vec<WorstElement> {
    let mut order: Vec<usize> = (0..of_element.len()).collect();
    let jacobian = |element: &usize| of_element[*element].min_scaled_jacobian();
    order.sort_by(|a, b| jacobian(a).total_cmp(&jacobian(b)));
    let described = |element: usize| {
        let cell = mesh.cells.get(element);
        let sum: crate::mechanics::tensor::Vec3 =
            cell.nodes.iter().map(|&node| mesh.nodes[node as usize]).sum();
        WorstElement {
            element,
            kind: cell.kind.table().name,
            part: mesh.parts[mesh.part_of[element] as usize].clone(),
            centre: (sum / cell.nodes.len() as f64).into(),
            scaled_jacobian: of_element[element].min_scaled_jacobian(),
            aspect_ratio: finite(of_element[element].aspect_ratio()),
        }
    };
    order.into_iter().take(WORST).map(described).collect()
}

#[cfg(test)]
#[allow(clippy::float_cmp, clippy::unwrap_used)] // tests may panic
mod tests {
    use super::super::generate::block::Block;
    use super::*;
    use crate::mechanics::tensor::Vec3;

    #[test]
    fn a_mesh_is_described_with_its_worst_elements() {
        let mut mesh =
            Block::uniform(Vec3::zeros(), Vec3::new(1.0, 1.0, 3.0), [1, 1, 3], "low").generate().unwrap();
        mesh.parts.push("high".into());
        mesh.part_of = vec![0, 0, 1];
        // The uppermost element is sheared.
        mesh.nodes.iter_mut().filter(|x| x.z > 2.5).for_each(|x| x.x += 1.0);
        let found = inspect(&mesh).unwrap();
        assert_eq!((found.report.nodes, found.report.elements), (16, 3));
        assert_eq!(found.kinds, [KindCount { kind: "hex8", elements: 3 }]);
        assert_eq!(found.report.parts, [("low".into(), 2), ("high".into(), 1)].into());
        assert_eq!(found.part_volumes[1].part, "high");
        assert!((found.part_volumes[1].volume - 1.0).abs() < 1e-14);
        let corners = (found.report.bounding_box_min, found.report.bounding_box_max);
        assert_eq!(corners, ([0.0; 3], [2.0, 1.0, 3.0]));
        let quality = found.report.quality.unwrap();
        assert_eq!(quality.worst_element, 2);
        let worst = &found.worst[0];
        assert_eq!((worst.element, worst.part.as_str(), worst.centre), (2, "high", [1.0, 0.5, 2.5]));
        assert!((worst.scaled_jacobian - 0.5_f64.sqrt()).abs() < 1e-14);
        let counts: Vec<usize> = found.histogram.iter().map(|bin| bin.elements).collect();
        assert_eq!(counts, [0, 0, 0, 0, 0, 0, 0, 0, 1, 0, 2]);
        assert!(inspect(&Mesh::default()).is_none());
    }
}
