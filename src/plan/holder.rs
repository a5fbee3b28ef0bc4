//! Supports of the bodies, which define the frame of reference of their energies.

use super::{Loads, Plan};

/// Supports of some bodies, along each axis.
///
/// Kinetic energy and work depend on the frame of reference. They describe an impact objectively in the frame of the
/// supports, or else in that of the common centre of mass.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Holder([Hold; 3]);

/// Support along one axis.
#[derive(Clone, Debug, Default, PartialEq)]
enum Hold {
    /// Nothing holds the tissue along this axis.
    #[default]
    Free,
    /// Held nodes or a plane.
    Fixed,
    /// Nodes with prescribed motion: indices into [`Loads::prescribed`].
    Driven(Vec<usize>),
}

impl Holder {
    /// Supports of the bodies selected by `is_of`; `on_plane` if they may touch a plane.
    pub fn new(plan: &Plan, is_of: impl Fn(usize) -> bool, on_plane: bool) -> Self {
        Self(std::array::from_fn(|axis| {
            let of_axis = plan.loads.prescribed.iter().enumerate();
            let driven = of_axis.filter(|(_, p)| p.axis == axis && is_of(plan.body_of_node(p.node)));
            let driven: Vec<usize> = driven.map(|(index, _)| index).collect();
            let nodes = plan.bodies.iter().enumerate().filter(|(b, _)| is_of(*b));
            let nodes = nodes.flat_map(|(_, body)| body.nodes.start as usize..body.nodes.end as usize);
            // Driven nodes are held nodes with a prescribed velocity.
            let without_mass = nodes.filter(|node| plan.holds(*node, axis)).count();
            match (on_plane || without_mass > driven.len(), driven.is_empty()) {
                (true, _) => Hold::Fixed,
                (false, false) => Hold::Driven(driven),
                (false, true) => Hold::Free,
            }
        }))
    }

    /// Velocity of the support at a time [s] along each axis [m/s]; `None` without support.
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
