//! Supports of the bodies, which define the frame of reference of their energies.

use super::loads::Loads;

/// Supports of some bodies, along each axis.
///
/// Kinetic energy and work depend on the frame of reference. They describe an impact objectively in the frame of the
/// supports, or else in that of the common centre of mass.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Holder(pub(super) [Hold; 3]);

/// Support along one axis.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) enum Hold {
    /// Nothing holds the tissue along this axis.
    #[default]
    Free,
    /// Held nodes or a plane.
    Fixed,
    /// Nodes with prescribed motion: indices into [`Loads::prescribed`].
    Driven(Vec<usize>),
}

impl Holder {
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
