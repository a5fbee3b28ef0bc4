//! Checks of meshes made of the labels of a scan, or of surfaces: of the document alone, of its numbers against the scan, and of the volumes of the mesh.

use super::Findings;
use crate::mechanics::contact::Discretisation;
use crate::mesh::Mesh;
use crate::mesh::names::fault;
use crate::mesh::segmentation::{Frame, LabelVolume, POORLY_RESOLVED, RELABELLED, idle_place};
use crate::scene::document::{BodyDocument, MeshDocument, SceneDocument};
use crate::scene::problem::{Pointer, Problem};
use crate::scene::segmentation_document::{
    ClosedSurfaceDocument, LabelDocument, NearDocument, SegmentationDocument,
};
use serde_json::Value;

/// Checks all scans of the document.
pub fn check(document: &SceneDocument, out: &mut Findings) {
    for (i, body) in document.bodies.iter().enumerate() {
        let Some(MeshDocument::Segmentation(scan)) = &body.mesh else { continue };
        let body_place = Pointer::root().key("bodies").index(i);
        let here = body_place.key("mesh").key("segmentation");
        check_sizes(scan, &here, out);
        check_source(scan, &here, out);
        check_labels(&scan.labels, &here.key("labels"), out);
        check_surfaces(&scan.surfaces, &here.key("surfaces"), out);
        check_no_refinement(body, &body_place, out);
        check_no_erosion(body, &body_place, "made of a scan", out);
        check_no_mortar(document, &here, "the mesh of a scan", out);
    }
}

/// Checks of the mesh of a file: what hanging nodes do not support.
pub fn check_mesh_of_file(index: usize, document: &SceneDocument, mesh: &Mesh, out: &mut Findings) {
    let body = &document.bodies[index];
    let is_file = matches!(body.mesh, Some(MeshDocument::File(_))) && body.refinement.is_empty();
    if mesh.hanging.is_empty() || !is_file {
        return;
    }
    let here = Pointer::root().key("bodies").index(index);
    check_no_erosion(body, &here, "whose file has hanging nodes", out);
    check_no_mortar(document, &here.key("mesh").key("file"), "a file with hanging nodes", out);
}

fn check_no_mortar(document: &SceneDocument, here: &Pointer, what: &str, out: &mut Findings) {
    out.require(document.contact.discretisation != Discretisation::Mortar, || {
        Problem::error("hanging_with_mortar", here, "mortar contact does not support hanging nodes")
            .value("mortar")
            .limit(format!("another contact.discretisation with {what}"))
            .remedy("remove contact.discretisation")
    });
}

/// Warns of points outside of the scan, and of labels that it does not have.
pub fn check_scan(scan: &SegmentationDocument, volume: &LabelVolume, here: &Pointer, out: &mut Findings) {
    for (i, label) in
        scan.labels.iter().enumerate().filter(|(_, label)| !volume.values.contains(&label.label))
    {
        let message = format!("the scan has no voxel with label {}", label.label);
        out.push(
            Problem::warning("absent_label", &here.key("labels").index(i).key("label"), message)
                .value(label.label)
                .limit("a label of the scan; `contuse mesh info` lists them")
                .remedy("correct the label, or omit the entry"),
        );
    }
    // A grid with shear is refused where it is read.
    let Ok(frame) = volume.frame() else { return };
    for (i, near) in scan.near.iter().enumerate().filter(|(_, near)| is_outside(near, scan, &frame)) {
        let message = "the point is outside the scan, so it refines no elements";
        out.push(
            Problem::warning("outside_of_scan", &here.key("near").index(i).key("point_m"), message)
                .value(near.point_m.to_vec())
                .limit("a point of the scan in metres; `contuse mesh info` shows its box")
                .remedy("give the point in metres, in the space of the scan: before the placement"),
        );
    }
}

/// Whether a point is so far outside of a scan that it means no place in it.
fn is_outside(near: &NearDocument, scan: &SegmentationDocument, frame: &Frame) -> bool {
    let (local, lengths) = (frame.local(&near.point_m.into()), frame.lengths());
    let reach = near.within_m + scan.size_m;
    !(0..3).all(|k| local[k] >= -reach && local[k] <= lengths[k] + reach)
}

/// Warns of what was requested of the mesh, and changed nothing: points in the scan around which no element is smaller, and a skin without a
/// surface to lie on.
pub fn check_effect(
    scan: &SegmentationDocument,
    volume: &LabelVolume,
    mesh: &Mesh,
    here: &Pointer,
    out: &mut Findings,
) {
    let Ok(frame) = volume.frame() else { return };
    let inside = scan.near.iter().enumerate().filter(|(_, near)| !is_outside(near, scan, &frame));
    for (i, near) in inside.filter(|(i, _)| mesh.notes.contains(&idle_place(*i))) {
        let message = "no element around the point is smaller than it would be without";
        out.push(
            Problem::warning("without_effect", &here.key("near").index(i), message)
                .value(near.size_m)
                .limit(format!("smaller than the elements there, of at most size_m = {}", scan.size_m))
                .remedy(
                    "give it a smaller size_m, move point_m to the tissue, in metres, or remove the entry",
                ),
        );
    }
    let has_surface = mesh.node_sets.get("outer").is_some_and(|nodes| !nodes.is_empty());
    if let Some(thickness) = scan.skin_thickness_m.filter(|_| !has_surface) {
        let message =
            "there is no skin: the body has no outer surface, as the scan or its crop cuts it on all sides";
        out.push(
            Problem::warning("without_effect", &here.key("skin_thickness_m"), message)
                .value(thickness)
                .limit("a body with air around a part of it")
                .remedy("enlarge the crop beyond the surface of the body, or remove skin_thickness_m"),
        );
    }
}

/// Warns of labels whose volume the mesh does not have.
pub fn check_label_volumes(mesh: &Mesh, here: &Pointer, out: &mut Findings) {
    for note in mesh.notes.iter().filter(|note| note.ends_with(POORLY_RESOLVED)) {
        out.push(
            Problem::warning(
                "label_volume",
                here,
                format!("the meshed volume differs from that of a label: {note}"),
            )
            .limit("within 1 % of its voxels, or of what its surface encloses")
            .remedy("give smaller elements by thin_size_m, near or size_m, or skin_thickness_m for a skin"),
        );
    }
}

/// Warns where much of a scan is noise.
pub fn check_noise(mesh: &Mesh, here: &Pointer, out: &mut Findings) {
    for note in mesh.notes.iter().filter(|note| note.ends_with(RELABELLED)) {
        out.push(
            Problem::warning(
                "label_noise",
                here,
                format!("the mesh does not match the labels of the scan: {note}"),
            )
            .limit("noise of at most 5 % of the voxels")
            .remedy("smooth the labels; noise_m3 is the largest volume that counts as noise"),
        );
    }
}

/// The labels come from a scan, or from surfaces.
fn check_source(scan: &SegmentationDocument, here: &Pointer, out: &mut Findings) {
    let has_surfaces = !scan.surfaces.is_empty();
    out.require(scan.name.is_some() != has_surfaces, || {
        let (code, message, remedy) = if has_surfaces {
            ("several_variants", "the labels are those of a scan, or of surfaces", "remove one of them")
        } else {
            ("missing_source", "there is nothing to mesh", "name a scan, or list closed surfaces")
        };
        Problem::error(code, here, message).limit("one of name and surfaces").remedy(remedy)
    });
    out.require(!has_surfaces || scan.labels.is_empty(), || {
        Problem::error("labels_of_surfaces", &here.key("labels"), "surfaces have no labels")
            .value(scan.labels.len())
            .limit("labels of a scan")
            .remedy("give each surface its part or hole, and remove the labels")
    });
    out.require(has_surfaces || scan.voxel_size_m.is_none(), || {
        Problem::error("voxels_of_scan", &here.key("voxel_size_m"), "a scan has its own voxel size")
            .value(scan.voxel_size_m)
            .limit("absent, with a scan")
            .remedy("remove voxel_size_m")
    });
}

fn check_surfaces(surfaces: &[ClosedSurfaceDocument], here: &Pointer, out: &mut Findings) {
    for (i, surface) in surfaces.iter().enumerate() {
        let place = here.index(i);
        let remedy = "0.001 converts millimetres to metres";
        out.positive(&place.key("scale"), "the scale", surface.scale, remedy);
        check_use((&surface.part, &surface.hole), surface.name.as_str(), &place, out);
    }
}

fn check_sizes(scan: &SegmentationDocument, here: &Pointer, out: &mut Findings) {
    let usual = "tissue is resolved by 0.5 to 5 mm; sizes are in metres";
    out.positive(&here.key("size_m"), "the size of elements", scan.size_m, usual);
    let finite = |point: &[f64; 3]| point.iter().all(|x| x.is_finite());
    for (i, near) in scan.near.iter().enumerate() {
        let here = here.key("near").index(i);
        out.positive(&here.key("size_m"), "the size of elements", near.size_m, usual);
        out.require(!(near.size_m > scan.size_m), || {
            Problem::error(
                "out_of_range",
                &here.key("size_m"),
                "elements near a point would be larger than elsewhere",
            )
            .value(near.size_m)
            .limit(format!("at most size_m = {}", scan.size_m))
            .remedy("increase size_m of the segmentation, the size of the largest elements")
        });
        out.not_negative(
            &here.key("within_m"),
            "the distance",
            near.within_m,
            "0 refines at the point alone",
        );
        out.require(finite(&near.point_m), || not_finite(&here.key("point_m")));
    }
    if let Some(size) = scan.thin_size_m {
        out.positive(&here.key("thin_size_m"), "the size of elements", size, usual);
    }
    if let Some(size) = scan.voxel_size_m {
        out.positive(&here.key("voxel_size_m"), "the size of voxels", size, "half of an element resolves it");
    }
    if let Some(thickness) = scan.skin_thickness_m {
        let remedy = "skin is 1 to 3 mm thick; without skin_thickness_m there is none";
        out.positive(&here.key("skin_thickness_m"), "the thickness of the skin", thickness, remedy);
    }
    if let Some(noise) = scan.noise_m3 {
        out.not_negative(&here.key("noise_m3"), "the volume of noise", noise, "0 keeps every voxel as it is");
    }
    if let Some(crop) = &scan.crop {
        let here = here.key("crop");
        for (k, size) in crop.size_m.into_iter().enumerate() {
            out.positive(&here.key("size_m").index(k), "a length of the crop", size, "give it in metres");
        }
        out.require(finite(&crop.center_m), || not_finite(&here.key("center_m")));
    }
}

fn not_finite(here: &Pointer) -> Problem {
    Problem::error("not_finite", here, "a coordinate is not finite")
        .limit("three finite numbers")
        .remedy("give the coordinates in metres")
}

fn check_labels(labels: &[LabelDocument], here: &Pointer, out: &mut Findings) {
    for (i, label) in labels.iter().enumerate() {
        let place = here.index(i);
        check_use((&label.part, &label.hole), label.label, &place, out);
        out.require(labels[..i].iter().all(|other| other.label != label.label), || {
            Problem::error("repeated_item", &place.key("label"), "this label is listed already")
                .value(label.label)
                .limit("each label once")
                .remedy("remove one of them")
        });
        out.require(label.label != 0 || (label.part.is_none() && label.hole.is_none()), || {
            Problem::error("out_of_range", &place.key("label"), "label 0 is the outside")
                .value(0)
                .limit("another label")
                .remedy("give the tissue another label in the program that segmented the scan")
        });
    }
}

/// A label or a surface is a part or a hole, of a valid name.
fn check_use(
    (part, hole): (&Option<String>, &Option<String>),
    of: impl Into<Value>,
    place: &Pointer,
    out: &mut Findings,
) {
    out.require(part.is_none() || hole.is_none(), || {
        Problem::error("several_variants", place, "it is a part or a hole")
            .value(of)
            .limit("one of part and hole")
            .remedy("remove one of them")
    });
    for (key, name) in [("part", part), ("hole", hole)] {
        let Some(limit) = name.as_deref().and_then(fault) else { continue };
        out.push(
            Problem::error("bad_name", &place.key(key), "this is not a name")
                .limit(limit)
                .remedy("choose another name"),
        );
    }
}

fn check_no_refinement(body: &BodyDocument, here: &Pointer, out: &mut Findings) {
    out.require(body.refinement.is_empty(), || {
        Problem::error(
            "refinement_of_scan",
            &here.key("refinement"),
            "a mesh made from a scan is refined by its segmentation",
        )
        .limit("no refinement of a body made from a scan")
        .remedy("give mesh.segmentation.near instead")
    });
}

fn check_no_erosion(body: &BodyDocument, here: &Pointer, what: &str, out: &mut Findings) {
    out.require(body.parts.iter().all(|part| part.erosion.is_none()), || {
        Problem::error(
            "hanging_with_erosion",
            &here.key("parts"),
            "erosion between coarse and fine elements would expose a surface without faces",
        )
        .limit(format!("no erosion of a body {what}"))
        .remedy("remove the erosion")
    });
}
