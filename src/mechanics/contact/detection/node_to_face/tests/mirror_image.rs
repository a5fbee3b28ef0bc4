//! Surfaces that end at a plane of symmetry.

use super::*;

#[test]
fn the_mirror_image_continues_a_surface_that_ends_at_a_plane_of_symmetry() {
    // A roof with its ridge in the plane x = 0, in whole and as its half.
    let mut x: Vec<Vec3> = Vec::new();
    for (across, up) in [(-1.0, 0.0), (0.0, 1.0), (1.0, 0.0)] {
        x.extend([0.0, 2.0].map(|y| Vec3::new(across, y, up)));
    }
    let whole = Surface::new((0..6).collect(), vec![[0, 2, 3, 1], [2, 4, 5, 3]]);
    let mirrored = [vec![2, 3], Vec::new(), Vec::new()];
    let half = Surface { mirrored, ..Surface::new((2..6).collect(), vec![[2, 4, 5, 3]]) };
    let slave = node(&mut x, Vec3::zeros());
    let at = x.len() - 1;
    // Over the ridge, over the half, and beyond both.
    for p in [
        Vec3::new(0.0, 1.0, 1.02),
        Vec3::new(0.4, 1.0, 0.62),
        Vec3::new(0.0, 1.0, 0.99),
        Vec3::new(0.0, 1.0, 1.5),
    ] {
        x[at] = p;
        let held = |master: &Surface| {
            detect(&[slave.clone(), master.clone()], &[pair(0, Master::Surface(1))], &x, &x)
                .first()
                .map(|contact| (contact.gap, contact.frame[0].z))
        };
        let (of_half, of_whole) = (held(&half), held(&whole));
        assert_eq!(of_half, of_whole, "{p}");
    }
    // Without its mirror image the half has a border, beyond whose plane nothing is held.
    x[at] = Vec3::new(-0.05, 1.0, 1.02);
    let open = Surface { mirrored: Default::default(), ..half };
    assert!(detect(&[slave, open], &[pair(0, Master::Surface(1))], &x, &x).is_empty());
}

#[test]
fn a_surface_meets_its_mirror_image_at_the_plane() {
    // A cube of half the size of the whole, whose side at x = 0 is a plane of symmetry, and a node of it that has come there.
    let mut x = Vec::new();
    let cube = block(2, 2, &mut x, |p| p);
    let on = |node: &&u32| x[**node as usize].x == 0.0;
    let on_plane: Vec<u32> = cube.nodes.iter().filter(on).copied().collect();
    let is_cut = |face: &&[u32; 4]| !face.iter().all(|node| on_plane.contains(node));
    let faces = cube.faces.iter().filter(is_cut).copied().collect();
    let half = Surface {
        mirrored: [on_plane.clone(), Vec::new(), Vec::new()],
        ..Surface::new(cube.nodes.clone(), faces)
    };
    let far = cube.nodes.iter().copied().find(|node| x[*node as usize] == Vec3::new(1.0, 0.0, 0.0)).unwrap();
    let found =
        |x_end: &[Vec3]| detect(std::slice::from_ref(&half), &[pair(0, Master::Surface(0))], &x, x_end);
    assert!(found(&x).iter().all(|contact| contact.frame[0] != Vec3::x()));
    let mut x_end = x.clone();
    x_end[far as usize].x = -0.1;
    let met: Vec<Contact> =
        found(&x_end).into_iter().filter(|contact| contact.frame[0] == Vec3::x()).collect();
    assert_eq!(met.len(), 1);
    assert_eq!((met[0].slave, met[0].gap, met[0].stencil.nodes()), (far, 1.0, &[far][..]));
    assert!(!met[0].kind.has_friction);
}
