//! Detection: from surfaces and their motion to the candidate contacts of a step. It knows no law and no reaction.
//!
//! A producer of contacts is a [`detector`], and [`detectors`] the list of them: [`node_to_face`] and [`guard`] find nodes
//! against faces and edges against edges, `mortar` averages over faces; [`rigid_detection`] rigid shapes against nodes and
//! against each other.

pub mod bodies;
mod boundary;
mod broad_phase;
pub mod closest_point;
pub mod detector;
pub mod detectors;
mod edges;
pub mod finder;
mod frame;
pub mod guard;
pub mod initial_overlap;
pub mod known;
mod mirror_image;
mod mortar;
pub mod narrow_phase;
pub mod node_to_face;
mod pair;
mod part;
pub mod penetration;
pub mod rigid_detection;
pub mod rigid_faces;
mod rigid_manifold;
mod rigid_mesh;
mod segments;
mod self_contact;
pub mod slave_choice;
pub mod surfaces;
mod sweep;
pub mod time_of_impact;
pub mod winding;
