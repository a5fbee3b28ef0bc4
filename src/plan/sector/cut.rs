//! The scene of a sector: the part of each body on the upper sides of the planes of symmetry.

use super::symmetry::Symmetry;
use crate::mechanics::tensor::Mat3;
use crate::mesh::mirror::{MirrorImages, MirrorPlane};
use crate::mesh::{ElementFields, Mesh};
use crate::scene::{RigidSceneBody, Scene, SceneBody};

/// Where the nodes and elements of a body in the sector come from, by their numbers in the body.
pub(super) struct Cut {
    /// For each node, that of the whole in each image.
    pub nodes: Vec<Vec<u32>>,
    /// For each element, that of the whole in each image.
    pub elements: Vec<Vec<u32>>,
}

/// The sector of a scene, and where it comes from, body by body.
pub(super) fn sector_of(scene: &Scene, Symmetry { planes, images }: &Symmetry) -> (Scene, Vec<Cut>) {
    let part_of = |(body, images): (&SceneBody, &Vec<Option<MirrorImages>>)| match &body.rigid {
        Some(rigid) => rigid_part(rigid, planes),
        None => meshed_part(body, planes, &images.iter().flatten().collect::<Vec<_>>()),
    };
    let (bodies, cuts) = scene.bodies.iter().zip(images).map(part_of).unzip();
    let sector = Scene {
        document: scene.document.clone(),
        choice: scene.choice.clone(),
        bodies,
        warnings: Vec::new(),
        content_hash: scene.content_hash.clone(),
        mesh_files: scene.mesh_files.clone(),
        kept_files: scene.kept_files.clone(),
    };
    (sector, cuts)
}

/// The part of a rigid body: its share of the mass and inertia, which moves in the planes and rotates about their common normal.
fn rigid_part(rigid: &RigidSceneBody, planes: &[MirrorPlane]) -> (SceneBody, Cut) {
    let share = planes.iter().fold(1.0, |share, _| 0.5 * share);
    let is_normal = |axis: usize| planes.iter().any(|plane| plane.axis == axis);
    // Principal axes are parallel to coordinate axes.
    let rotates = |principal: usize| {
        let along = (rigid.pose.orientation * Mat3::identity().column(principal)).iamax();
        planes.iter().all(|plane| plane.axis == along)
    };
    let part = RigidSceneBody {
        mass: rigid.mass * share,
        inertia: rigid.inertia * share,
        held: [[0, 1, 2].map(is_normal), [0, 1, 2].map(|principal| !rotates(principal))],
        ..rigid.clone()
    };
    let images = 1_usize << planes.len();
    // Centre and spin.
    let nodes = [0, 1].map(|node| vec![node; images]).to_vec();
    (SceneBody { rigid: Some(part), ..SceneBody::default() }, Cut { nodes, elements: Vec::new() })
}

/// The part of a mesh, with its nodes on the planes.
fn meshed_part(body: &SceneBody, planes: &[MirrorPlane], images: &[&MirrorImages]) -> (SceneBody, Cut) {
    let mesh = &body.mesh;
    // An element is above a plane if a node is: none extends across.
    let is_on = |plane: usize, node: u32| images[plane].nodes[node as usize] == node;
    let is_above = |plane: usize, node: u32| {
        !is_on(plane, node) && mesh.nodes[node as usize][planes[plane].axis] > planes[plane].at
    };
    let is_kept = |element: usize| {
        let nodes = mesh.cells.nodes(element);
        (0..planes.len()).all(|plane| nodes.iter().any(|node| is_above(plane, *node)))
    };
    let elements: Vec<usize> = (0..mesh.cells.len()).filter(|element| is_kept(*element)).collect();
    let mut used = vec![false; mesh.nodes.len()];
    elements.iter().flat_map(|e| mesh.cells.nodes(*e)).for_each(|node| used[*node as usize] = true);
    let kept: Vec<u32> = (0..mesh.nodes.len() as u32).filter(|node| used[*node as usize]).collect();

    let numbered = || (0_u32..).zip(&kept);
    let mut mirrored: [Vec<u32>; 3] = std::array::from_fn(|_| Vec::new());
    for (number, plane) in planes.iter().enumerate() {
        mirrored[plane.axis] =
            numbered().filter(|(_, node)| is_on(number, **node)).map(|(new, _)| new).collect();
    }
    // The number of a node or element in each image.
    let numbers = |own: u32, of: &dyn Fn(&MirrorImages, u32) -> u32| -> Vec<u32> {
        let is_reflected = |image: usize, bit: usize| image & (1 << bit) != 0;
        let in_image = |image: usize| {
            let planes = images.iter().enumerate().filter(|(bit, _)| is_reflected(image, *bit));
            planes.fold(own, |number, (_, images)| of(images, number))
        };
        (0..1 << planes.len()).map(in_image).collect()
    };
    let of_node = |node: &u32| numbers(*node, &|images, node| images.nodes[node as usize]);
    let of_element = |element: &usize| numbers(*element as u32, &|images, e| images.elements[e as usize]);
    let cut = Cut {
        nodes: kept.iter().map(of_node).collect(),
        elements: elements.iter().map(of_element).collect(),
    };
    let part = SceneBody {
        rigid: None,
        mesh: part_of_mesh(mesh, &elements),
        refined: body.refined,
        materials: body.materials.clone(),
        law_of: elements.iter().map(|e| body.law_of[*e]).collect(),
        part_entry: elements.iter().map(|e| body.part_entry[*e]).collect(),
        axes: elements.iter().filter_map(|e| body.axes.get(*e).copied()).collect(),
        mirrored,
    };
    (part, cut)
}

/// Some elements of a mesh, in their order, with the nodes that they use.
fn part_of_mesh(mesh: &Mesh, elements: &[usize]) -> Mesh {
    let mut part = Mesh {
        nodes: mesh.nodes.clone(),
        part_of: elements.iter().map(|e| mesh.part_of[*e]).collect(),
        parts: mesh.parts.clone(),
        node_sets: mesh.node_sets.clone(),
        axes: elements.iter().filter_map(|e| mesh.axes.get(*e).copied()).collect(),
        fields: ElementFields::default(),
        hanging: mesh.hanging.clone(),
        ..Mesh::default()
    };
    for element in elements {
        let cell = mesh.cells.get(*element);
        part.cells.push(cell.kind, cell.nodes);
    }
    part.drop_unused_nodes();
    part
}
