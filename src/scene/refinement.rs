//! Local refinement of the meshes of the bodies, after all are placed: the position of the impact depends on two of them.

use super::document::{Around, BodyDocument, RefinementDocument, Role, SceneDocument};
use super::problem::{Pointer, Problem, suggest};
use super::validate::Findings;
use crate::mechanics::tensor::Vec3;
use crate::mesh::Mesh;
use crate::mesh::local_refinement::refined_in;
use crate::mesh::refinement_estimate::least_elements;
use crate::mesh::refinement_region::{Place, Region};
use crate::mesh::surface::boundary;
use crate::mesh::triangulated_surface::TriangulatedSurface;

/// The placed meshes of all bodies, for refinement; those of rigid bodies are empty.
pub struct Meshes<'a> {
    /// The document with the requested refinement.
    pub document: &'a SceneDocument,
    /// One for each body; `None` where problems were found.
    pub placed: &'a [Option<Mesh>],
}

impl Meshes<'_> {
    /// The refined mesh of a body and how many of its elements were split, with at most `spare` additional elements; `None`
    /// where no refinement is requested, or problems were found.
    pub fn refined(&self, index: usize, spare: u64, out: &mut Findings) -> Option<(Mesh, usize)> {
        let mesh = self.placed.get(index)?.as_ref()?;
        let here = Pointer::root().key("bodies").index(index).key("refinement");
        let requested = &self.document.bodies[index].refinement;
        let regions = requested
            .iter()
            .enumerate()
            .map(|(i, requested)| self.region(index, mesh, requested, &here.index(i), out));
        let regions: Option<Vec<Region>> = regions.collect::<Vec<_>>().into_iter().collect();
        let regions = regions.filter(|regions| !regions.is_empty())?;
        for (i, (region, requested)) in regions.iter().zip(requested).enumerate() {
            out.require(region.splits_any(mesh), || without_effect(mesh, region, requested, &here.index(i)));
        }
        let before = mesh.cells.len() as u64;
        let most = before.saturating_add(spare);
        let too_many = |elements: u64| {
            let message = format!("the locally refined mesh has an estimated {elements} elements or more");
            Problem::error("budget_elements", &here, message)
                .value(elements)
                .limit(format!("at most {spare} more than the {before} of the given mesh"))
                .remedy("give a larger `size_m`, or a smaller `within_m`")
        };
        // Splitting up to the limit takes long: what exceeds it by far is refused before.
        let least = least_elements(mesh, &regions, most);
        if least > most {
            out.push(too_many(least));
            return None;
        }
        let refined =
            refined_in(mesh, &regions, most).map_err(|error| out.push(too_many(error.elements))).ok()?;
        for (i, (region, requested)) in regions.iter().zip(requested).enumerate() {
            out.require(!region.splits_any(&refined.0), || {
                incomplete(&refined.0, region, requested, &here.index(i))
            });
        }
        Some(refined)
    }

    fn region(
        &self,
        body: usize,
        mesh: &Mesh,
        requested: &RefinementDocument,
        here: &Pointer,
        out: &mut Findings,
    ) -> Option<Region> {
        // Invalid numbers are reported by the checks of the document.
        if !(requested.size_m > 0.0 && requested.size_m.is_finite() && requested.within_m >= 0.0) {
            return None;
        }
        let around = here.key("around");
        let points: Vec<Vec3> = match &requested.around {
            Around::PointM(point) => vec![Vec3::from(*point)],
            Around::Set(name) => {
                let Some(set) = mesh.node_sets.get(name) else {
                    out.push(unknown_set(mesh, name, &around));
                    return None;
                };
                set.iter().map(|node| mesh.nodes[*node as usize]).collect()
            }
            Around::Impact => {
                let impact = self.impact_on(body, mesh);
                out.require(impact.is_some(), || no_impact(&around));
                vec![self.at_rest(body, mesh, impact?)]
            }
        };
        let places = Place::on_all(mesh, &points);
        Some(Region { places, within: requested.within_m, size: requested.size_m })
    }

    /// Point of first impact on a body: where the path of the projectile's centre, as seen from the other body, enters its
    /// boundary surface. Where no body is a projectile, each of the others may be.
    fn impact_on(&self, body: usize, mesh: &Mesh) -> Option<Vec3> {
        let bodies = &self.document.bodies;
        let own_surface = self.boundary(body, mesh);
        let others = (0..bodies.len()).filter(|other| *other != body);
        if bodies[body].role == Role::Projectile {
            // From a point far ahead, back towards the projectile.
            let centre = self.centre(body)?;
            let ahead = others.filter_map(|other| {
                let way = self.approach(body, other)?;
                let [low, high] = mesh.bounding_box()?;
                let far = centre + way.normalize() * (high - low).norm();
                Some(own_surface.entry(&far, &-way)?.1.place)
            });
            return ahead.take(1).next();
        }
        let has_projectile = bodies.iter().any(|body| body.role == Role::Projectile);
        let strikers = others.filter(|other| !has_projectile || bodies[*other].role == Role::Projectile);
        let hits = strikers
            .filter_map(|other| own_surface.entry(&self.centre(other)?, &self.approach(other, body)?));
        hits.min_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, point)| point.place)
    }

    /// Position in the mesh of a point [m] of a body that starts deformed, displaced like its nearest node.
    fn at_rest(&self, body: usize, mesh: &Mesh, point: Vec3) -> Vec3 {
        let start = |X: &Vec3| self.document.bodies[body].start_position(X);
        let far = |X: &Vec3| (start(X) - point).norm_squared();
        let nearest = mesh.nodes.iter().min_by(|a, b| far(a).total_cmp(&far(b)));
        nearest.map_or(point, |X| point - (start(X) - X))
    }

    fn boundary(&self, body: usize, mesh: &Mesh) -> TriangulatedSurface {
        let positions = mesh.nodes.iter().map(|X| self.document.bodies[body].start_position(X)).collect();
        TriangulatedSurface::new(&boundary(&mesh.cells), positions)
    }

    /// Velocity of one body relative to another [m/s]; `None` if it is zero.
    fn approach(&self, of: usize, from: usize) -> Option<Vec3> {
        let [of, from] = [of, from].map(|body| Vec3::from(self.document.bodies[body].velocity_m_per_s));
        Some(of - from).filter(|way| way.norm() > 0.0)
    }

    /// Centre of volume of a body in its initial configuration [m].
    fn centre(&self, body: usize) -> Option<Vec3> {
        let written = &self.document.bodies[body];
        match &written.rigid {
            Some(rigid) => Some(rigid.center_m.into()),
            None => Some(centre_of_volume(written, self.placed[body].as_ref()?)),
        }
    }
}

/// Centre of volume of the mesh of a body in its initial configuration [m].
pub fn centre_of_volume(body: &BodyDocument, mesh: &Mesh) -> Vec3 {
    let (mut volume, mut moment) = (0.0, Vec3::zeros());
    for cell in mesh.cells.iter() {
        let corners = cell.points(&mesh.nodes).map(|X| body.start_position(X));
        let of_element = cell.kind.volume_m3(&corners);
        volume += of_element;
        moment += corners.iter().sum::<Vec3>() * (of_element / corners.len() as f64);
    }
    moment / volume
}

/// A region that splits no element: either there are none, or they are small enough.
fn without_effect(mesh: &Mesh, region: &Region, requested: &RefinementDocument, here: &Pointer) -> Problem {
    let problem =
        |key: &str, message: String| Problem::warning("refinement_without_effect", &here.key(key), message);
    let Some([least, most]) = region.sizes_in(mesh) else {
        let distance = region.distance(mesh);
        if !distance.is_finite() {
            let message = "no element is split: only hexahedra are, and the mesh has none";
            return problem("around", message.to_owned())
                .limit("a mesh with hexahedra")
                .remedy("mesh the body with small elements there in the program that made the mesh, and remove the refinement");
        }
        let message = format!(
            "no element is split: none is within {} m of the place, the nearest is {distance:.4e} m away",
            requested.within_m
        );
        return problem("within_m", message)
            .value(requested.within_m)
            .limit(format!("at least {distance:.4e} m, the distance of the nearest element"))
            .remedy("give a larger `within_m`, or a place on the body; coordinates are those of the placed mesh, in metres");
    };
    let message = format!(
        "no element is split: those within {} m of the place already have edges along the surface of {least:.4e} to {most:.4e} m",
        requested.within_m
    );
    problem("size_m", message)
        .value(requested.size_m)
        .limit(format!("less than {most:.4e} m, the largest size there (the smallest is {least:.4e} m)"))
        .remedy(format!("give a `size_m` of {:.4e} or less, or remove the refinement", 0.5 * most))
}

/// A region in which larger elements are left.
fn incomplete(mesh: &Mesh, region: &Region, requested: &RefinementDocument, here: &Pointer) -> Problem {
    let [_, most] = region.sizes_in(mesh).unwrap_or([0.0; 2]);
    let message = format!(
        "hexahedra with edges along the surface of up to {most:.4e} m are left within {} m of the place: only hexahedra are split, and \
         not those that touch other elements",
        requested.within_m
    );
    Problem::warning("refinement_incomplete", &here.key("size_m"), message)
        .value(requested.size_m)
        .limit("a body of hexahedra")
        .remedy("mesh the body with small elements there in the program that made the mesh")
}

fn unknown_set(mesh: &Mesh, name: &str, here: &Pointer) -> Problem {
    Problem::error("unknown_set", &here.key("set"), format!("the mesh has no node set {name:?}"))
        .value(name)
        .limit("a node set of the mesh")
        .remedy(suggest(name, mesh.node_sets.keys().map(String::as_str)))
}

fn no_impact(here: &Pointer) -> Problem {
    let message = "no other body moves centrally towards this one, so the position of the impact is unknown";
    Problem::error("unknown_impact", here, message)
        .value("impact")
        .limit("a body whose centre moves towards this one, or a projectile that moves towards another body")
        .remedy("give the position: {\"point_m\": [x, y, z]}")
}
