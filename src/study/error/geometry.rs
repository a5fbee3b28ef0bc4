//! The error of the geometry apart: a curved surface that is meshed by flat facets is another body.
//!
//! The next finer mesh is run twice: with its new nodes on the true surface, as the generator puts them, and with the scene's own
//! elements split, the new nodes in the middle of their edges and facets. Both resolve the fields alike, so their difference is
//! what the surface does. Numbers that are the largest of all nodes or elements are looked for at other places on the two, which is
//! in the difference as well.

use super::{Quantity, Row};
use crate::study::Setting;
use serde::Serialize;
use std::collections::BTreeMap;

/// The next finer mesh, on the facets of the scene's own.
pub(super) const ON_FACETS: Setting = Setting { mesh_level: 1, on_facets: true, ..Setting::OWN };

/// The distance of facets from their surface falls with the square of the element size, so what a halving of the elements takes off
/// is three quarters of it.
const OF_THE_WHOLE: f64 = 4.0 / 3.0;

/// How a quantity changes from the scene's own mesh to the next finer one, over its value there [-].
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Geometry {
    /// The whole change.
    pub change: f64,
    /// What of it comes with the new nodes' going from the facets to the true surface.
    pub change_by_surface: f64,
    /// Error of the scene's own mesh by its facets alone: 4/3 of that, since second order is assumed.
    pub error: f64,
}

/// Of every quantity that the three runs have and that is not zero.
pub(super) fn geometry(rows: &[Row]) -> BTreeMap<Quantity, Geometry> {
    let row = |setting: Setting| rows.iter().find(|row| row.setting == setting);
    let finer = Setting { mesh_level: 1, ..Setting::OWN };
    let (Some(own), Some(fine), Some(facets)) = (row(Setting::OWN), row(finer), row(ON_FACETS)) else {
        return BTreeMap::new();
    };
    let of = |(quantity, fine): (&Quantity, &f64)| {
        let over = |row: &Row| Some((fine - row.values.get(quantity)?) / fine.abs());
        let change_by_surface = over(facets)?;
        let error = OF_THE_WHOLE * change_by_surface.abs();
        Some((*quantity, Geometry { change: over(own)?, change_by_surface, error }))
    };
    fine.values.iter().filter(|(_, value)| **value != 0.0).filter_map(of).collect()
}
