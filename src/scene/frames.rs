//! Material axes of elements from the fibre frames of the document.

use super::document::{FibreFrameDocument, SurfaceDocument};
use crate::mechanics::material::Material;
use crate::mechanics::tensor::{Mat3, Vec3};
use crate::mesh::laplace::{self, LaplaceError};
use crate::mesh::{ElementField, Mesh};

/// Sine of the angle between two directions below which they are parallel.
const PARALLEL: f64 = 1e-9;
/// Gradient of the solution of Laplace's equation, relative to the mean of the part, below which it has no direction.
const FLAT: f64 = 1e-6;

/// Why elements have no material axes.
#[derive(Clone, Debug, PartialEq)]
pub enum NoAxes {
    /// The frame is to come from the mesh, which has none.
    MeshHasNone,
    /// The centres of these elements lie on the axis of the cylinder, or on the centre line.
    OnAxis(Vec<usize>),
    /// The directions of the frame have no length, or are parallel.
    Degenerate,
    /// The mesh has no array of that name with three components.
    NoArray {
        /// Index of the array among the families.
        family: usize,
        /// Whether there is one with another number of components.
        scalars: bool,
    },
    /// The law does not have as many fibre families as there are arrays, or does not have one or two distinct ones.
    Families {
        /// Number of families of the law.
        of_law: usize,
    },
    /// The array has no direction for these elements: zero, or not finite.
    NoDirection {
        /// Index of the array among the families.
        family: usize,
        /// Indices of these elements in the mesh.
        elements: Vec<usize>,
    },
    /// There is no such surface, or Laplace's equation has no solution.
    Surface {
        /// Whether it is the end, rather than the beginning.
        at_end: bool,
        /// The missing surface, or why there is no solution.
        reason: String,
    },
    /// The gradient vanishes in these elements.
    Flat(Vec<usize>),
    /// The direction in the plane of e1 and e2 is missing, or along e1 in these elements.
    NoPlane(Option<Vec<usize>>),
}

/// Axes e1 ∥ `axis`, e2 in the plane of both, as columns; `None` when they do not span a plane.
pub fn constant_frame(axis: [f64; 3], plane: [f64; 3]) -> Option<Mat3> {
    // Normalised first, so that only the angle between the directions matters.
    let e1 = Vec3::from(axis).try_normalize(0.0)?;
    let p = Vec3::from(plane).try_normalize(0.0)?;
    let e2 = (p - e1 * e1.dot(&p)).try_normalize(PARALLEL)?;
    let frame = Mat3::from_columns(&[e1, e2, e1.cross(&e2)]);
    frame.iter().all(|x| x.is_finite()).then_some(frame)
}

/// Material axes of some elements of a mesh, columns e1, e2, e3, in their order; for a law with these fibres. Without a frame those of
/// the mesh, or x, y, z where it has none. Of `arrays` they need not be orthogonal: they take the families of the law to the arrays.
///
/// # Errors
/// [`NoAxes`] where the axes are undefined.
pub fn axes_of(
    frame: Option<&FibreFrameDocument>,
    law: &Material,
    mesh: &Mesh,
    elements: &[usize],
) -> Result<Vec<Mat3>, NoAxes> {
    let of_mesh = |&element: &usize| mesh.axes.get(element).map(|e| Mat3::from_columns(e));
    match frame {
        // One frame for all elements, or that of the mesh.
        None => Ok(elements.iter().map(|e| of_mesh(e).unwrap_or_else(Mat3::identity)).collect()),
        Some(FibreFrameDocument::Mesh {}) => {
            elements.iter().map(of_mesh).collect::<Option<_>>().ok_or(NoAxes::MeshHasNone)
        }
        Some(FibreFrameDocument::Constant { axis, plane }) => {
            let frame = constant_frame(*axis, *plane).ok_or(NoAxes::Degenerate)?;
            Ok(vec![frame; elements.len()])
        }
        // Radial directions about an axis or a centre line.
        Some(FibreFrameDocument::Cylindrical { origin_m, axis }) => {
            let e1 = Vec3::from(*axis).try_normalize(0.0).ok_or(NoAxes::Degenerate)?;
            let around = |element| {
                let arm = centre(mesh, element) - Vec3::from(*origin_m);
                outwards(e1, arm, size(mesh, element))
            };
            each(elements, around, NoAxes::OnAxis)
        }
        Some(FibreFrameDocument::CentreLine { points_m }) => {
            let line: Vec<Vec3> = points_m.iter().map(|point| Vec3::from(*point)).collect();
            let along = along_line(&line).ok_or(NoAxes::Degenerate)?;
            let around = |element| {
                let (e1, arm) = along(centre(mesh, element))?;
                outwards(e1, arm, size(mesh, element)).or_else(|| is_along(law).then(|| any_frame(e1)))
            };
            each(elements, around, NoAxes::OnAxis)
        }
        // Directions of each element: arrays, or the gradient of a solution of Laplace's equation.
        Some(FibreFrameDocument::Arrays { families }) => of_arrays(families, law, mesh, elements),
        Some(FibreFrameDocument::Laplace { from, to, plane }) => {
            if plane.is_none() && !is_along(law) {
                return Err(NoAxes::NoPlane(None));
            }
            let found = gradients([from, to], mesh, elements)?;
            let upright = |&g: &Vec3| match plane {
                Some(plane) => constant_frame(g.into(), *plane),
                None => Some(any_frame(g.normalize())),
            };
            let frames: Vec<Option<Mat3>> = found.iter().map(upright).collect();
            complete(elements, frames, |elements| NoAxes::NoPlane(Some(elements)))
        }
    }
}

/// A frame for each element; those without one are an error.
fn each(
    elements: &[usize],
    frame: impl Fn(usize) -> Option<Mat3>,
    without: impl FnOnce(Vec<usize>) -> NoAxes,
) -> Result<Vec<Mat3>, NoAxes> {
    complete(elements, elements.iter().map(|element| frame(*element)).collect(), without)
}

fn complete<T>(
    elements: &[usize],
    found: Vec<Option<T>>,
    without: impl FnOnce(Vec<usize>) -> NoAxes,
) -> Result<Vec<T>, NoAxes> {
    let missing = elements.iter().zip(&found).filter(|(_, found)| found.is_none());
    let missing: Vec<usize> = missing.map(|(element, _)| *element).collect();
    if missing.is_empty() { Ok(found.into_iter().flatten().collect()) } else { Err(without(missing)) }
}

fn centre(mesh: &Mesh, element: usize) -> Vec3 {
    let corners = mesh.cells.points(element, &mesh.nodes);
    corners.iter().sum::<Vec3>() / corners.len() as f64
}

/// Distance of a corner from the centre of an element [m].
fn size(mesh: &Mesh, element: usize) -> f64 {
    (mesh.cells.points(element, &mesh.nodes)[0] - centre(mesh, element)).norm()
}

/// e1, and e3 along what of `arm` is normal to it, unless that is nothing against the size of the element.
fn outwards(e1: Vec3, arm: Vec3, size: f64) -> Option<Mat3> {
    let e3 = (arm - e1 * e1.dot(&arm)).try_normalize(PARALLEL * (arm.norm() + size))?;
    Some(Mat3::from_columns(&[e1, e3.cross(&e1), e3]))
}

/// Some frame with a unit vector e1.
fn any_frame(e1: Vec3) -> Mat3 {
    let e2 = e1.cross(&Vec3::ith(e1.iamin(), 1.0)).normalize();
    Mat3::from_columns(&[e1, e2, e1.cross(&e2)])
}

/// Whether all fibres of a law are along e1.
fn is_along(law: &Material) -> bool {
    law.fibre_directions().iter().all(|d| d[1] == 0.0 && d[2] == 0.0)
}

/// Unit tangent at the point of a line nearest to a given point, and the vector from there to the point; `None` for a line of zero length.
///
/// Tangents at the points of the line are the mean of the adjacent segments', and are interpolated between them.
fn along_line(line: &[Vec3]) -> Option<impl Fn(Vec3) -> Option<(Vec3, Vec3)>> {
    let segment = |i: usize| (line[i + 1] - line[i]).try_normalize(0.0);
    let segments = (0..line.len().checked_sub(1)?).map(segment).collect::<Option<Vec<Vec3>>>()?;
    let (first, last) = (*segments.first()?, *segments.last()?);
    let middle = segments.windows(2).map(|pair| (pair[0] + pair[1]).try_normalize(PARALLEL));
    let inner = middle.collect::<Option<Vec<Vec3>>>()?;
    let tangents: Vec<Vec3> = std::iter::once(first).chain(inner).chain([last]).collect();
    Some(move |x: Vec3| {
        let on_segment = |i: usize| {
            let way = line[i + 1] - line[i];
            let fraction = ((x - line[i]).dot(&way) / way.norm_squared()).clamp(0.0, 1.0);
            (x - line[i] - way * fraction, i, fraction)
        };
        let nearest = (0..line.len() - 1).map(on_segment).min_by(|a, b| a.0.norm().total_cmp(&b.0.norm()));
        let (arm, i, fraction) = nearest?;
        Some((tangents[i].lerp(&tangents[i + 1], fraction).try_normalize(0.0)?, arm))
    })
}

/// Axes that take the families of a law to arrays of the mesh.
fn of_arrays(names: &[String], law: &Material, mesh: &Mesh, elements: &[usize]) -> Result<Vec<Mat3>, NoAxes> {
    // Unit vectors, the first two as given: the third is normal to them.
    let frame = |a: Vec3, b: Option<Vec3>| -> Option<Mat3> {
        let Some(b) = b else { return Some(any_frame(a)) };
        let normal = a.cross(&b).try_normalize(PARALLEL);
        Some(Mat3::from_columns(&[a, b, normal.unwrap_or_else(|| any_frame(a).column(2).into())]))
    };
    let of_law: Vec<Vec3> = law.fibre_directions().iter().map(|d| Vec3::from(*d)).collect();
    let refused = NoAxes::Families { of_law: of_law.len() };
    let from = match (of_law[..].first(), of_law.get(1)) {
        (Some(a), b) if of_law.len() <= 2 && names.len() == of_law.len() => frame(*a, b.copied()),
        _ => None,
    };
    let from = from.and_then(nalgebra::Matrix::try_inverse).ok_or(refused)?;
    let mut families: Vec<Vec<Vec3>> = Vec::new();
    for (family, name) in names.iter().enumerate() {
        let field = mesh.fields.get(name);
        let Some(ElementField::Vectors(vectors)) = field else {
            return Err(NoAxes::NoArray { family, scalars: field.is_some() });
        };
        let unit = |e: &usize| vectors[*e].try_normalize(0.0).filter(|v| v.iter().all(|x| x.is_finite()));
        let units = elements.iter().map(unit).collect();
        families.push(complete(elements, units, |elements| NoAxes::NoDirection { family, elements })?);
    }
    let of_element = |i: usize| frame(families[0][i], families.get(1).map(|family| family[i]));
    (0..elements.len()).map(|i| Some(of_element(i)? * from)).collect::<Option<_>>().ok_or(NoAxes::Degenerate)
}

/// Gradients in a part, none of which vanishes.
fn gradients(surfaces: [&SurfaceDocument; 2], mesh: &Mesh, elements: &[usize]) -> Result<Vec<Vec3>, NoAxes> {
    let mut of_part = vec![false; mesh.nodes.len()];
    for &element in elements {
        mesh.cells.get(element).nodes.iter().for_each(|node| of_part[*node as usize] = true);
    }
    let nodes = |at_end: bool| {
        let found = nodes_of(surfaces[usize::from(at_end)], mesh, &of_part);
        found.ok_or_else(|| NoAxes::Surface { at_end, reason: "the mesh has no such surface".into() })
    };
    let found = laplace::gradients(mesh, elements, &nodes(false)?, &nodes(true)?);
    let found = found.map_err(|error| {
        let at_end = !matches!(error, LaplaceError::NoNodes { at_end: false });
        NoAxes::Surface { at_end, reason: error.to_string() }
    })?;
    let mean = found.iter().map(Vec3::norm).sum::<f64>() / found.len() as f64;
    let steep = found.into_iter().map(|g| Some(g).filter(|g| g.norm() > FLAT * mean)).collect();
    complete(elements, steep, NoAxes::Flat)
}

/// Nodes of a part in a surface; `None` where the mesh has no set or part of that name.
fn nodes_of(surface: &SurfaceDocument, mesh: &Mesh, of_part: &[bool]) -> Option<Vec<u32>> {
    let mut nodes = match surface {
        SurfaceDocument::Set(name) => mesh.node_sets.get(name)?.clone(),
        SurfaceDocument::Part(name) => {
            let other = mesh.parts.iter().position(|part| part == name)?;
            let cells = mesh.cells.iter().zip(&mesh.part_of).filter(|(_, part)| **part as usize == other);
            cells.flat_map(|(cell, _)| cell.nodes.iter().copied()).collect()
        }
    };
    nodes.retain(|node| of_part[*node as usize]);
    nodes.sort_unstable();
    nodes.dedup();
    Some(nodes)
}

#[cfg(test)]
mod tests;
