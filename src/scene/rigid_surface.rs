//! Rigid bodies of triangulated surfaces.

use super::file_problem::{mesh_problem, source_problem};
use super::problem::{Pointer, Problem};
use super::source::{MeshBytes, MeshSource};
use super::validate::Findings;
use crate::mechanics::rigid::{MOST_PLANES, NoHull, Solid};
use crate::mechanics::tensor::Vec3;
use crate::mesh::read::stl::read_stl;

/// Volume of the hull over that of the surface up to which a surface is convex: its coordinates are rounded.
const CONVEX: f64 = 1.001;

/// The body inside the surface of a file of at most so many bytes, scaled; and the file.
///
/// # Errors
/// Why it cannot be read, or is that of no rigid body, as a problem below `here`.
pub fn read(
    source: &dyn MeshSource,
    (name, limit): (&str, u64),
    scale: f64,
    here: &Pointer,
) -> Result<(Solid, MeshBytes), Problem> {
    let place = here.key("name");
    let found = source.read(name, limit).map_err(|error| source_problem(&error, &place).value(name))?;
    let surface = read_stl(&found.bytes).map_err(|error| mesh_problem(&error, &place).value(name))?;
    let points: Vec<Vec3> = surface.points.iter().map(|x| x * scale).collect();
    let solid = Solid::new(&points, &surface.triangles).map_err(|reason| {
        let problem = match reason {
            NoHull::Flat(reason) => {
                let message = format!("the surface does not bound a rigid body: {reason}");
                Problem::error("bad_surface", &place, message)
                    .limit("a closed surface of finite thickness")
                    .remedy("check the surface, and \"scale\", which converts its unit to metres")
            }
            NoHull::ManyPlanes => {
                let message = format!("the convex hull of the surface has more than {MOST_PLANES} planes");
                Problem::error("too_many_planes", &place, message)
                    .limit(format!("at most {MOST_PLANES}"))
                    .remedy("reduce the surface, as `decimate` of PyVista does; plane faces cost nothing")
            }
        };
        problem.value(name)
    })?;
    Ok((solid, found))
}

/// Contact knows convex shapes only: whether another one is replaced by its hull has to be said. `None` if it is not.
pub(super) fn check_hull(solid: &Solid, accepted: bool, here: &Pointer, out: &mut Findings) -> Option<()> {
    if solid.hull_ratio < 1.0 / CONVEX {
        let times = 1.0 / solid.hull_ratio;
        let message = format!(
            "the surface encloses {times:.2} times the volume of its hull: some space is enclosed twice"
        );
        out.push(
            Problem::error("overlapping_surface", here, message)
                .value(times)
                .limit("a surface without nested or coincident shells")
                .remedy("remove triangles that are listed twice and shells inside others, as `clean` and `split_bodies` of PyVista do"),
        );
        return None;
    }
    let more = 100.0 * (solid.hull_ratio - 1.0);
    if solid.hull_ratio <= CONVEX {
        return Some(());
    }
    let message = format!("the surface is not convex: its hull encloses {more:.1} % more");
    if accepted {
        let problem = Problem::warning("convex_hull", here, message + ", and takes its place in contact");
        out.push(
            problem
                .value(solid.hull_ratio)
                .limit(format!("at most {CONVEX} for contact as the surface is"))
                .remedy("use the part of the surface that touches, with the mass and inertia of the whole"),
        );
        return Some(());
    }
    out.push(
        Problem::error("not_convex", here, message)
            .value(false)
            .limit(format!("a convex surface, up to a factor of {CONVEX} in volume; or \"convex_hull\": true"))
            .remedy("add \"convex_hull\": true to let the hull take part in contact, or use the convex part of the surface that touches"),
    );
    None
}
