//! Nodes between opposing faces.

use super::*;

#[test]
fn a_node_in_a_valley_is_held_by_both_sides_and_on_a_ridge_by_one() {
    // Two faces with the common edge x = 0; `rise` of their outer edges.
    for (rise, sides) in [(0.7, 2), (0.05, 1), (-0.7, 1)] {
        let sheet = [
            Vec3::new(0.0, 0.0, 0.0),
            Vec3::new(0.0, 1.0, 0.0),
            Vec3::new(1.0, 0.0, rise),
            Vec3::new(1.0, 1.0, rise),
            Vec3::new(-1.0, 0.0, rise),
            Vec3::new(-1.0, 1.0, rise),
        ];
        let valley = Surface::new((0..6).collect(), vec![[0, 2, 3, 1], [4, 0, 1, 5]]);
        for aside in [0.0, 0.005, -0.02] {
            let mut x = sheet.to_vec();
            let slave = node(&mut x, Vec3::new(aside, 0.4, 0.01 + (rise * aside).abs()));
            let contacts = detect(&[valley.clone(), slave], &[pair(1, Master::Surface(0))], &x, &x);
            assert_eq!(contacts.len(), sides, "{rise} {aside}");
            assert_frames(&contacts);
            for contact in &contacts {
                assert!(contact.gap > 0.0 && contact.gap < 0.04 && contact.frame[0].z > 0.5);
            }
            assert!(contacts.is_sorted_by_key(|contact| contact.face));
        }
    }
}
