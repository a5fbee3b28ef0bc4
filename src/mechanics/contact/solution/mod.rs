//! Solution: from contacts, as signed weights of nodes in local frames, to their reactions. It knows no surface.
//!
//! [`gauss_seidel`] solves explicit steps on the nodal velocities themselves. Independently of steps, a
//! [`problem::ContactProblem`] is `W`, `q` and `μ` alone, and [`solvers::solve`] finds its reactions.

pub mod compliance;
mod connected;
mod contact_row;
pub mod delassus;
pub mod gauss_seidel;
pub mod generalised_jacobian;
pub mod local;
pub mod problem;
pub mod slip;
pub mod solvers;
pub mod step_problem;
