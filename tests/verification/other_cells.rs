//! A steel ball on a soft block of hexahedra, wedges and tetrahedra: one impact, one impulse.
//!
//! The meshes of the other cells are the hexahedra split. The reference is hexahedra of half the size, and the others must be within the
//! error bars of both, three times the difference from half the size: wedges are not within that of the hexahedra alone.

use crate::rig::{assert_at_most, plan_with, run};
use contuse::mechanics::tensor::Vec3;
use contuse::mesh::Mesh;
use contuse::mesh::generate::block::Block;
use serde_json::{Value, json};

/// Half of the smallest symmetric block would do; the whole one shows what is not symmetric.
fn block(n: u32) -> Mesh {
    let (low, high) = (Vec3::new(-0.03, -0.03, 0.0), Vec3::new(0.03, 0.03, 0.03));
    Block::uniform(low, high, [2 * n, 2 * n, n], "block").generate().unwrap()
}

/// Impulse after 4 ms [N s], and the error of the energy balance.
fn impulse(mesh: Mesh) -> (f64, f64) {
    impulse_with(mesh, &json!({"kind": "explicit"}))
}

fn impulse_with(mesh: Mesh, integrator: &Value) -> (f64, f64) {
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
    let mut last = Vec3::zeros();
    let (outcome, _) = run(&plan, |frame| {
        last = frame.energy.pairs.values().next_back().map_or(last, |pair| Vec3::from(pair.impulse_n_s));
    });
    (last.norm(), outcome.balance_error)
}

#[test]
fn every_kind_of_cell_gives_the_same_impulse() {
    let ((fine, _), (coarse, _)) = (impulse(block(12)), impulse(block(6)));
    let bar = 3.0 * (coarse - fine).abs();
    println!("hexahedra: {coarse:.5} and, of half the size, {fine:.5} N s");
    assert_at_most(bar / fine, 0.3, "relative error bar of the hexahedra");
    let wedges = |n: u32| block(n).split_to_wedges();
    let quadratic = |n: u32| block(n).split_to_tetrahedra().to_quadratic_tetrahedra();
    let linear = |n: u32| block(n).split_to_tetrahedra();
    let cases = [
        ("wedges", [wedges(6), wedges(12)]),
        ("tetrahedra of ten nodes", [quadratic(3), quadratic(6)]),
        ("tetrahedra of four nodes", [linear(6), linear(12)]),
    ];
    // The error bars of both meet.
    for (what, meshes) in cases {
        let [(found, balance), (finer, _)] = meshes.map(impulse);
        println!("{what}: {found:.5} and, of half the size, {finer:.5} N s, balance {balance:.1e}");
        let own = 3.0 * (found - finer).abs();
        assert_at_most((found - fine).abs(), bar + own, &format!("difference of the impulse [N s], {what}"));
        assert_at_most(
            (finer - fine).abs(),
            0.05 * fine,
            &format!("difference of the finer meshes [N s], {what}"),
        );
        assert_at_most(balance, 1e-3, &format!("error of the energy balance, {what}"));
    }
}

#[test]
fn implicit_steps_of_four_node_tetrahedra_give_the_impulse_of_explicit_ones() {
    let mesh = || block(4).split_to_tetrahedra();
    let (explicit, _) = impulse(mesh());
    let (implicit, balance) = impulse_with(mesh(), &json!({"kind": "implicit", "step_s": 2e-5}));
    println!("explicit {explicit:.6}, implicit {implicit:.6} N s, balance {balance:.1e}");
    assert_at_most(implicit / explicit - 1.0, 0.02, "relative difference of the impulse, implicit steps");
    assert_at_most(balance, 0.01, "error of the energy balance, implicit steps");
}
