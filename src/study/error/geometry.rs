//! Geometry error: a curved surface meshed by flat facets is a different body.
//!
//! The next finer mesh is run twice: with its new nodes on the true surface, as generated, and with the scene's own
//! elements split, the new nodes at the midpoints of their edges and facets. Both resolve the fields alike, so their
//! difference is the effect of the surface. Maxima over nodes or elements are evaluated at different places on the two
//! meshes, which contributes to the difference as well.

use super::Row;
use crate::measure::QuantityOfInterest;
use crate::study::Setting;
use serde::Serialize;
use std::collections::BTreeMap;

/// The next finer mesh, on the facets of the scene's own.
pub(super) const ON_FACETS: Setting = Setting { mesh_level: 1, on_facets: true, ..Setting::OWN };

/// The distance of facets from their surface is of second order in the element size, so halving the elements removes
/// three quarters of it.
const OF_THE_WHOLE: f64 = 4.0 / 3.0;

/// Change of a quantity from the scene's own mesh to the next finer one, over its value there [-].
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Geometry {
    /// Total relative change between the two meshes.
    pub change: f64,
    /// Part of it due to moving the new nodes from the facets to the true surface.
    pub change_by_surface: f64,
    /// Error of the scene's own mesh due to its facets: 4/3 of that, assuming second order.
    pub error: f64,
}

/// Geometry error of every quantity that the three runs have and that is not zero.
pub(super) fn geometry(rows: &[Row]) -> BTreeMap<QuantityOfInterest, Geometry> {
    let row = |setting: Setting| rows.iter().find(|row| row.setting == setting);
    let finer = Setting { mesh_level: 1, ..Setting::OWN };
    let (Some(own), Some(fine), Some(facets)) = (row(Setting::OWN), row(finer), row(ON_FACETS)) else {
        return BTreeMap::new();
    };
    let of = |(quantity, fine): (&QuantityOfInterest, &f64)| {
        let over = |row: &Row| Some((fine - row.values.get(quantity)?) / fine.abs());
        let change_by_surface = over(facets)?;
        let error = OF_THE_WHOLE * change_by_surface.abs();
        Some((*quantity, Geometry { change: over(own)?, change_by_surface, error }))
    };
    fine.values.iter().filter(|(_, value)| **value != 0.0).filter_map(of).collect()
}
