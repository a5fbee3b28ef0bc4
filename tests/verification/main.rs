//! Cases with known answers: closed forms, the literature, and other codes, one file a subject.
//!
//! The numbers that are compared with were computed independently of this crate. `docs/verification.md` shows what came out; `record.rs`
//! says how a new case gets onto it.
// Symbols of the field: F, J, P. A test may stop at the first surprise; exactly is what is meant where it is compared.
#![allow(non_snake_case, clippy::unwrap_used, clippy::float_cmp)]

mod accuracy;
mod assembled_step;
mod averaged_pressure;
mod ball_on_block;
mod bar_on_wall;
mod breathing_hollow_ball;
mod cantilever;
mod contact_holds;
mod contact_patch;
mod contact_problem_variants;
mod contact_solvers;
mod cook;
mod coulomb_cone;
mod coverage;
mod crushing;
mod energy_momentum;
mod erosion;
mod error_study;
mod followers;
mod free_flight;
mod hertz;
mod hertz_impact;
mod impact_offset;
mod implicit;
mod incline;
mod invariance;
mod laws;
mod ledger;
mod local_refinement;
mod manufactured_solution;
mod material_fit;
mod material_points;
mod measured_images;
mod mirror_images;
mod model_ends;
mod momentum;
mod mortar;
mod oblique_soft_ball;
mod omitted;
mod other_cells;
mod parity;
mod patch_test;
mod plausible;
mod pressurised_ball;
mod quasi_static;
mod record;
mod relaxation;
mod relaxation_branches;
mod relaxation_references;
mod rig;
mod rigid_ball;
mod rigid_between_nodes;
mod rigid_on_mesh;
mod rigid_rotation;
mod rigid_spin;
mod rigid_stack;
mod rigid_surface;
mod rigid_sweep;
mod shock;
mod softening;
mod solid_sphere_breathing;
mod split_mesh;
mod stability;
mod two_bars;
mod unsolvable_contacts;
mod viscosity;
mod what_if;
mod what_if_spread;
