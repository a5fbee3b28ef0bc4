//! A steel ball on a soft block of hexahedra, wedges and tetrahedra: one impact, one impulse, one peak force.
//!
//! The meshes of the other cells are the hexahedra split. The reference is hexahedra of half the size, and the others must be within the
//! error bar of the hexahedra, three times the difference from half the size.

use crate::rig::{assert_at_most, plan_with, run};
use contuse::mechanics::tensor::Vec3;
use contuse::mesh::Mesh;
use contuse::mesh::generate::block::Block;
use contuse::step::PairLedger;
use serde_json::{Value, json};

/// Half of the smallest symmetric block would do; the whole one shows what is not symmetric.
fn block(n: u32) -> Mesh {
    let (origin, size) = (Vec3::new(-0.03, -0.03, 0.0), Vec3::new(0.06, 0.06, 0.03));
    Block::uniform(origin, size, [2 * n, 2 * n, n], "block").generate().unwrap()
}

/// Time over which a force is averaged [s].
const WINDOW: f64 = 4e-4;

struct Impact {
    /// After 4 ms [N s].
    impulse: f64,
    /// Largest mean force over [`WINDOW`] [N].
    force: f64,
    /// Error of the energy balance.
    balance: f64,
}

/// Largest mean force [N] over [`WINDOW`], from times [s] and impulses [N s].
fn largest_mean(impulses: &[(f64, f64)]) -> f64 {
    let at = |time: f64| {
        let after = impulses.partition_point(|(t, _)| *t < time).clamp(1, impulses.len() - 1);
        let ((t0, i0), (t1, i1)) = (impulses[after - 1], impulses[after]);
        i0 + (i1 - i0) * (time - t0) / (t1 - t0)
    };
    let begun = impulses.iter().filter(|(t, _)| *t >= WINDOW);
    begun.map(|(t, impulse)| (impulse - at(t - WINDOW)) / WINDOW).fold(0.0, f64::max)
}

fn impact(mesh: Mesh) -> Impact {
    impact_with(mesh, &json!({"kind": "explicit"}))
}

fn impact_with(mesh: Mesh, integrator: &Value) -> Impact {
    let scene = json!({
        "name": "steel ball on a soft block",
        "end_time_s": 4e-3,
        "bodies": [
            {
                "name": "ball",
                "role": "projectile",
                "rigid": {"shape": {"kind": "ball", "radius_m": 0.01}, "center_m": [0.001, 0.002, 0.0401], "density_kg_per_m3": 7850},
                "velocity_m_per_s": [0, 0, -3]
            },
            {
                "name": "block",
                "role": "tissue",
                "mesh": {"file": {"name": "block.msh"}},
                "parts": [{"part": "block", "density_kg_per_m3": 1060, "material": {
                    "law": "mooney_rivlin", "c10_pa": 20000, "c01_pa": 5000, "bulk_modulus_pa": 2e6
                }}],
                "fixed": [{"set": "z_min"}]
            }
        ],
        "contact": {"friction": 0.3},
        "integrator": integrator,
        "record": {"fields": [], "field_times_s": []}
    });
    let plan = plan_with(&scene, Some(mesh));
    let mut impulses = vec![(0.0, 0.0)];
    let (outcome, _) = run(&plan, |frame| {
        let of_pair = |pair: &PairLedger| Vec3::from(pair.impulse_n_s).norm();
        let impulse = frame.energy.pairs.values().next_back().map_or(0.0, of_pair);
        if frame.time > 0.0 {
            impulses.push((frame.time, impulse));
        }
    });
    let impulse = impulses.last().unwrap().1;
    Impact { impulse, force: largest_mean(&impulses), balance: outcome.balance_error }
}

#[test]
fn every_kind_of_cell_gives_the_same_impulse_and_force() {
    let (fine, coarse) = (impact(block(12)), impact(block(6)));
    let wedges = |n: u32| block(n).split_to_wedges();
    let quadratic = |n: u32| block(n).split_to_tetrahedra().to_quadratic_tetrahedra();
    let linear = |n: u32| block(n).split_to_tetrahedra();
    let cases = [
        ("wedges", [wedges(6), wedges(12)]),
        ("tetrahedra of ten nodes", [quadratic(3), quadratic(6)]),
        ("tetrahedra of four nodes", [linear(6), linear(12)]),
    ];
    let cases = cases.map(|(what, meshes)| (what, meshes.map(impact)));
    let impulse: fn(&Impact) -> f64 = |of| of.impulse;
    let quantities = [("impulse [N s]", impulse), ("peak force [N]", |of| of.force)];
    for (quantity, of) in quantities {
        let (fine, coarse) = (of(&fine), of(&coarse));
        let bar = 3.0 * (coarse - fine).abs();
        println!("{quantity}: hexahedra {coarse:.5}, of half the size {fine:.5}");
        assert_at_most(bar / fine, 0.3, &format!("relative error bar of the hexahedra, {quantity}"));
        // Each is within the error bar of the hexahedra.
        for (what, [found, finer]) in &cases {
            let (found, finer) = (of(found), of(finer));
            println!("{quantity}: {what} {found:.5}, of half the size {finer:.5}");
            assert_at_most((found - fine).abs(), bar, &format!("difference of the {quantity}, {what}"));
            assert_at_most(
                (finer - fine).abs(),
                0.05 * fine,
                &format!("difference of the finer meshes, {quantity}, {what}"),
            );
        }
    }
    for (what, [found, _]) in &cases {
        assert_at_most(found.balance, 1e-3, &format!("error of the energy balance, {what}"));
    }
}

#[test]
fn implicit_steps_of_four_node_tetrahedra_give_the_impulse_of_explicit_ones() {
    let mesh = || block(4).split_to_tetrahedra();
    let explicit = impact(mesh()).impulse;
    let Impact { impulse, balance, .. } = impact_with(mesh(), &json!({"kind": "implicit", "step_s": 2e-5}));
    println!("explicit {explicit:.6}, implicit {impulse:.6} N s, balance {balance:.1e}");
    assert_at_most(impulse / explicit - 1.0, 0.02, "relative difference of the impulse, implicit steps");
    assert_at_most(balance, 0.01, "error of the energy balance, implicit steps");
}
