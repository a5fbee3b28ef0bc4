//! Channel frequency classes: the low-pass filter of crash tests, applied to the force of a contact.

use super::impulse_history::{ImpulseHistory, PeakForce};
use crate::mechanics::tensor::Vec3;
use std::f64::consts::{PI, SQRT_2};

/// Design frequency of the filter over its class [-] (SAE J211-1, appendix C): two passes then have −3 dB at class /
/// 0.6.
const DESIGN: f64 = 2.0775;
/// Cut-off frequency over the class, at −3 dB [-].
const CUT_OFF: f64 = 1.0 / 0.6;
/// Samples per period of the design frequency; the standard requires about five.
const SAMPLES: f64 = 40.0;
/// Time before and after the contact for the filter to decay, in periods of the design frequency: e^(−2π·4/√2) is 2e-8.
const REST: f64 = 4.0;

/// Two-pole Butterworth filter of a class in Hz for samples T seconds apart, applied forward and backward in time, so
/// that there is no phase delay (SAE J211-1, appendix C; ISO 6487):
///
/// `Y(t) = a0 X(t) + a1 X(t−1) + a2 X(t−2) + b1 Y(t−1) + b2 Y(t−2)`, at rest before the first sample.
pub fn filter(values: &mut [Vec3], class: f64, T: f64) {
    let w = (PI * DESIGN * class * T).tan();
    let scale = 1.0 / (1.0 + SQRT_2 * w + w * w);
    let a0 = w * w * scale;
    let (b1, b2) = (-2.0 * (w * w - 1.0) * scale, (-1.0 + SQRT_2 * w - w * w) * scale);
    let pass = |values: &mut dyn Iterator<Item = &mut Vec3>| {
        let (mut x, mut y) = ([Vec3::zeros(); 2], [Vec3::zeros(); 2]);
        for value in values {
            let next = (*value + x[0] * 2.0 + x[1]) * a0 + y[0] * b1 + y[1] * b2;
            (x, y) = ([*value, x[0]], [next, y[0]]);
            *value = next;
        }
    };
    pass(&mut values.iter_mut());
    pass(&mut values.iter_mut().rev());
}

/// Filtered force of a pair, (time [s], force [N]), from its impulse at a time, between its first and last contact.
pub fn filtered_force(impulse_at: impl Fn(f64) -> Vec3, span: [f64; 2], class: f64) -> Vec<(f64, Vec3)> {
    let T = 1.0 / (SAMPLES * DESIGN * class);
    let rest = REST / (DESIGN * class);
    let begin = span[0] - rest;
    #[allow(clippy::cast_sign_loss)] // the span is not negative
    let count = ((span[1] + rest - begin) / T).ceil().max(1.0) as usize;
    let edge = |i: usize| begin + T * i as f64;
    let mut forces: Vec<Vec3> =
        (0..count).map(|i| (impulse_at(edge(i + 1)) - impulse_at(edge(i))) / T).collect();
    filter(&mut forces, class, T);
    forces.into_iter().enumerate().map(|(i, force)| (edge(i) + 0.5 * T, force)).collect()
}

/// Peak of the filtered force of a history. Its patch is the mean over half a period of the cut-off frequency around
/// it.
pub fn filtered_peak(history: &ImpulseHistory, class: f64) -> PeakForce {
    let (Some(first), Some(last)) = (history.samples().first(), history.samples().last()) else {
        return PeakForce::default();
    };
    let forces = filtered_force(|time| history.at(time).impulse, [first.time, last.time], class);
    let largest = forces.iter().max_by(|a, b| a.1.norm().total_cmp(&b.1.norm()));
    largest.map_or_else(PeakForce::default, |(time, force)| {
        let half = 0.25 / (CUT_OFF * class);
        let patch = history.mean_patch(time - half, time + half);
        PeakForce { force: force.norm(), time: time.max(0.0), patch, placing: 0.0 }
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Amplitude of a sine of this frequency [Hz] after the filter, far from both ends.
    fn gain(frequency: f64, class: f64) -> f64 {
        let T = 1.0 / (200.0 * class);
        let mut values: Vec<Vec3> =
            (0..20_000).map(|i| Vec3::x() * (2.0 * PI * frequency * T * f64::from(i)).sin()).collect();
        filter(&mut values, class, T);
        values[8_000..12_000].iter().map(|v| v.x.abs()).fold(0.0, f64::max)
    }

    #[test]
    fn the_gain_is_that_of_the_standard() {
        for class in [60.0, 180.0, 600.0, 1000.0] {
            let decibel = |fraction: f64| 20.0 * gain(fraction * class, class).log10();
            // SAE J211: within ±0.5 dB to 0.1 of the class, +0.5 to −1 dB at it, −3 dB at class / 0.6, then 24 dB an octave.
            assert!(decibel(0.1).abs() < 0.5 && (-1.0..0.5).contains(&decibel(1.0)), "{class}");
            assert!((decibel(CUT_OFF) + 3.01).abs() < 0.02, "{class}: {}", decibel(CUT_OFF));
            assert!(decibel(4.0 * CUT_OFF) < -30.0, "{class}: {}", decibel(4.0 * CUT_OFF));
        }
    }

    /// Two passes of the continuous filter have the impulse response with the transform |H|² = 1/(1 + (Ω/ω)⁴), which is
    /// `r(t) = ω/(2√2) e^(−ω|t|/√2) (cos + sin)(ω|t|/√2)`; the step response is its integral.
    #[test]
    fn a_step_passes_as_by_the_continuous_filter() {
        let (class, T) = (100.0, 1e-6);
        let w = 2.0 * PI * DESIGN * class;
        let n: usize = 60_000;
        let mut values: Vec<Vec3> =
            (0..n).map(|i| if i < n / 2 { Vec3::zeros() } else { Vec3::x() }).collect();
        // The step continues to the end, where the backward pass starts at rest: only the front is compared.
        filter(&mut values, class, T);
        let r = |t: f64| {
            let x = w * t.abs() / SQRT_2;
            w / (2.0 * SQRT_2) * (-x).exp() * (x.cos() + x.sin())
        };
        let mut sum = 0.0;
        for (i, value) in values.iter().enumerate().take(n / 2 + 3_000) {
            sum += r((i as f64 - (n / 2) as f64) * T) * T;
            if i % 500 == 0 {
                assert!((value.x - sum).abs() < 2e-3, "{i}: {} {sum}", value.x);
            }
        }
    }

    #[test]
    fn an_impulse_keeps_its_size() {
        // 2 N s within a microsecond: r(0) = ω/(2√2) times that, from the impulse response of the filter.
        let class = 1000.0;
        let impulse = |t: f64| Vec3::z() * (2.0 * (t / 1e-6).clamp(0.0, 1.0));
        let forces = filtered_force(impulse, [0.0, 1e-6], class);
        let T = forces[1].0 - forces[0].0;
        let sum: Vec3 = forces.iter().map(|(_, force)| force * T).sum();
        assert!((sum.z - 2.0).abs() < 1e-5, "{}", sum.z);
        let largest = forces.iter().map(|(_, force)| force.z).fold(0.0, f64::max);
        let exact = 2.0 * 2.0 * PI * DESIGN * class / (2.0 * SQRT_2);
        assert!((largest / exact - 1.0).abs() < 0.02, "{largest} {exact}");
    }
}
