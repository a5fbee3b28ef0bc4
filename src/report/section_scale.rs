//! Colours of stress in the picture of a section.

use super::instant::Body;

/// Bands of colour for each factor of ten of the stress, and the fraction of the lowest threshold at which they begin.
const BANDS: f64 = 6.0;
const BELOW: f64 = 0.1;
/// Of the nodes of the tissue this fraction may lie beyond the last colour: peaks at a point [-].
const BEYOND: f64 = 0.002;

/// The map cividis of matplotlib at equal distances.
const CIVIDIS: [u32; 17] = [
    0x0000_224e,
    0x0000_2e6a,
    0x001a_386f,
    0x0032_436d,
    0x0043_4e6c,
    0x0053_5a6d,
    0x0061_656f,
    0x006f_7073,
    0x007d_7c78,
    0x008c_8878,
    0x009b_9476,
    0x00ab_a072,
    0x00bc_ae6c,
    0x00cd_bb63,
    0x00de_c958,
    0x00f0_d846,
    0x00fe_e838,
];

/// Bands of stress with their colours, even in its logarithm.
pub(super) struct Scale {
    /// End of the first band [Pa].
    pub low: f64,
    /// Begin of what lies beyond the last band [Pa].
    pub high: f64,
    /// Thresholds, drawn as lines [Pa].
    pub thresholds: Vec<f64>,
}

impl Scale {
    /// For the stress of tissues; `None` if they have none.
    pub fn of(tissues: &[&Body], thresholds_pa: &[f64]) -> Option<Self> {
        let stress = tissues.iter().flat_map(|body| body.stress.iter().copied());
        let mut stress: Vec<f64> = stress.filter(|s| s.is_finite()).collect();
        stress.sort_by(f64::total_cmp);
        let index = ((1.0 - BEYOND) * stress.len() as f64) as usize;
        let most = *stress.get(index.min(stress.len().saturating_sub(1)))?;
        let low = BELOW * thresholds_pa.first().copied().filter(|t| *t > 0.0).unwrap_or(0.01 * most);
        let high = most.max(10.0 * low);
        (low > 0.0).then(|| Self { low, high, thresholds: thresholds_pa.to_vec() })
    }

    /// Number of bands of colour, each of the same ratio of stresses, at most 60.
    pub fn count(&self) -> usize {
        (BANDS * (self.high / self.low).log10()).ceil().clamp(1.0, 60.0) as usize
    }

    /// Begin and end of a band [Pa]; the first and the last are open.
    pub fn band(&self, index: usize) -> [f64; 2] {
        let edge = |i: usize| self.low * (self.high / self.low).powf(i as f64 / self.count() as f64);
        let low = if index == 0 { f64::NEG_INFINITY } else { edge(index) };
        [low, if index + 1 == self.count() { f64::INFINITY } else { edge(index + 1) }]
    }

    /// Colour of a band.
    pub fn colour(&self, index: usize) -> String {
        let at = 16.0 * (index as f64 + 0.5) / self.count() as f64;
        let left = (at as usize).min(15);
        let [a, b] = [CIVIDIS[left], CIVIDIS[left + 1]];
        let channel = |shift: u32| {
            let [a, b] = [a, b].map(|colour| f64::from((colour >> shift) & 0xff));
            (a + (at - left as f64) * (b - a)).round() as u32
        };
        format!("#{:06x}", (channel(16) << 16) | (channel(8) << 8) | channel(0))
    }
}
