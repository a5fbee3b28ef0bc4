//! What holds bodies: whose frame their energies are told in.

use super::{Loads, Plan};

/// Who holds some bodies, along each axis.
///
/// Kinetic energy and work depend on who looks. What an impact does to bodies does not, if it is told in the frame of whoever holds
/// them, or else in that of their common centre of mass.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Holder([Hold; 3]);

/// Along one axis.
#[derive(Clone, Debug, Default, PartialEq)]
enum Hold {
    /// Nobody.
    #[default]
    Free,
    /// Held nodes or a plane.
    Fixed,
    /// Nodes that move as they are told: indices into [`Loads::prescribed`].
    Driven(Vec<usize>),
}

impl Holder {
    /// Of a plan's bodies, those that `is_of` says; `on_plane` where they are to touch a plane.
    pub fn new(plan: &Plan, is_of: impl Fn(usize) -> bool, on_plane: bool) -> Self {
        Self(std::array::from_fn(|axis| {
            let of_axis = plan.loads.prescribed.iter().enumerate();
            let driven = of_axis.filter(|(_, p)| p.axis == axis && is_of(plan.body_of_node(p.node)));
            let driven: Vec<usize> = driven.map(|(index, _)| index).collect();
            let nodes = plan.bodies.iter().enumerate().filter(|(b, _)| is_of(*b));
            let nodes = nodes.flat_map(|(_, body)| body.nodes.start as usize..body.nodes.end as usize);
            // A driven node is a held one that is told its way.
            let without_mass = nodes.filter(|node| plan.holds(*node, axis)).count();
            match (on_plane || without_mass > driven.len(), driven.is_empty()) {
                (true, _) => Hold::Fixed,
                (false, false) => Hold::Driven(driven),
                (false, true) => Hold::Free,
            }
        }))
    }

    /// Velocity of the holder at a time [s] along each axis [m/s]; `None` where nobody holds.
    pub fn velocity(&self, loads: &Loads, time: f64) -> [Option<f64>; 3] {
        self.0.each_ref().map(|hold| match hold {
            Hold::Free => None,
            Hold::Fixed => Some(0.0),
            Hold::Driven(driven) => {
                let of = |index: &usize| loads.velocity(&loads.prescribed[*index], time);
                Some(driven.iter().map(of).sum::<f64>() / driven.len() as f64)
            }
        })
    }
}
