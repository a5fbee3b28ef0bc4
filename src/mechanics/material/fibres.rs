//! Fibre families of a law, as directions in the material axes.

/// The largest number of fibre families in one law.
pub const MAX_FAMILIES: usize = 4;

/// Unit directions of the families in the element's material axes (e1 the fibre axis, e2 in the plane of the
/// families, e3 normal to it).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FibreFamilies {
    directions: [[f64; 3]; MAX_FAMILIES],
    count: usize,
}

impl FibreFamilies {
    /// A law without fibres.
    pub const NONE: Self = Self { directions: [[0.0; 3]; MAX_FAMILIES], count: 0 };

    /// From up to [`MAX_FAMILIES`] directions of any positive length; `None` if there are more, or one is zero or not
    /// finite.
    pub fn new(directions: &[[f64; 3]]) -> Option<Self> {
        let mut out = [[0.0; 3]; MAX_FAMILIES];
        for (i, d) in directions.iter().enumerate() {
            let length = d.iter().map(|x| x * x).sum::<f64>().sqrt();
            if !(length.is_finite() && length > 0.0) {
                return None;
            }
            *out.get_mut(i)? = d.map(|x| x / length);
        }
        Some(Self { directions: out, count: directions.len() })
    }
    /// Unit directions, one per family.
    #[inline(always)]
    pub fn directions(&self) -> &[[f64; 3]] {
        &self.directions[..self.count]
    }
}
