//! How long a pair is in contact, also where its surfaces chatter.
//!
//! A stiff body bounces on soft tissue many times within one impact: it touches for a step, and again much later. The time that it
//! touches then shrinks with the step, and so would a window that is a fraction of it. Touches belong to one contact if the bodies
//! still approached each other between them, or if no gap is longer than a fraction of the time from the first to the last of them. A
//! ball that falls again has longer flights.

/// Longest gap between touches of one contact, as a fraction of the time of that contact [-].
const LONGEST_GAP: f64 = 0.2;
/// Number of touches that are kept; beyond it those with the shorter gaps between them are joined.
const MOST_TOUCHES: usize = 1024;

/// The times at which a pair touches.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ContactTime {
    /// Beginning and end of each touch [s], in order; those between which the bodies approached each other are one.
    touches: Vec<[f64; 2]>,
    /// Longest gap within the last of them [s].
    bridged: f64,
}

impl ContactTime {
    /// Adds a time with contact [s], from which an earlier one may continue; `is_approaching`: whether the bodies still approach
    /// each other.
    pub fn add(&mut self, from: f64, to: f64, is_approaching: bool) {
        match self.touches.last_mut() {
            Some([_, end]) if from <= *end || is_approaching => {
                self.bridged = self.bridged.max(from - *end);
                *end = to;
            }
            _ => {
                self.touches.push([from, to]);
                self.bridged = 0.0;
            }
        }
        if self.touches.len() > MOST_TOUCHES {
            self.join_closest();
        }
    }

    /// Time in contact [s], short gaps included.
    pub fn duration(&self) -> f64 {
        self.contacts().iter().map(|of| span(of)).sum()
    }

    /// Whether the latest contact is over at a time [s] at which the pair does not touch: it has been open for longer than before.
    pub fn has_ended(&self, now: f64) -> bool {
        self.contacts().last().is_none_or(|touches| {
            let last = touches.last().map_or(now, |[_, end]| *end);
            now - last >= longest_gap(touches).map_or(self.bridged, |(gap, _)| gap.max(self.bridged))
        })
    }

    /// The touches of each contact.
    fn contacts(&self) -> Vec<&[[f64; 2]]> {
        let (mut found, mut open) = (Vec::new(), vec![&self.touches[..]]);
        while let Some(touches) = open.pop() {
            match longest_gap(touches) {
                Some((gap, at)) if gap > LONGEST_GAP * span(touches) => {
                    let (before, after) = touches.split_at(at);
                    open.extend([after, before]);
                }
                _ if touches.is_empty() => {}
                _ => found.push(touches),
            }
        }
        found
    }

    /// Joins the touches with the shorter half of the gaps.
    fn join_closest(&mut self) {
        let gaps = self.touches.windows(2).map(|pair| pair[1][0] - pair[0][1]);
        let mut sorted: Vec<f64> = gaps.collect();
        sorted.sort_by(f64::total_cmp);
        let middle = sorted[sorted.len() / 2];
        self.touches.dedup_by(|next, kept| {
            let is_close = next[0] - kept[1] <= middle;
            if is_close {
                kept[1] = next[1];
            }
            is_close
        });
    }
}

/// Time from the first to the last of some touches [s].
fn span(touches: &[[f64; 2]]) -> f64 {
    touches.first().zip(touches.last()).map_or(0.0, |([begin, _], [_, end])| end - begin)
}

/// The longest gap between touches [s], and the index of the touch after it; `None` for a single one.
fn longest_gap(touches: &[[f64; 2]]) -> Option<(f64, usize)> {
    let gaps = touches.windows(2).map(|pair| pair[1][0] - pair[0][1]);
    gaps.zip(1..).max_by(|a, b| a.0.total_cmp(&b.0))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(touches: &[[f64; 2]]) -> ContactTime {
        let mut time = ContactTime::default();
        for [from, to] in touches {
            time.add(*from, *to, false);
        }
        time
    }

    fn close(a: f64, b: f64) {
        assert!((a - b).abs() < 1e-12 * b.abs().max(1.0), "{a} is not {b}");
    }

    #[test]
    fn contact_without_gaps_lasts_as_long_as_it_touches() {
        let time = of(&[[1.0, 1.5], [1.5, 3.0]]);
        close(time.duration(), 2.0);
        assert!(time.has_ended(3.0));
        assert!(of(&[]).has_ended(1.0) && of(&[]).duration() == 0.0);
    }

    #[test]
    fn chatter_is_one_contact() {
        // A touch of 1 µs every 30 µs for 3 ms.
        let touches: Vec<_> = (0..100).map(|i| 3e-5 * f64::from(i)).map(|t| [t, t + 1e-6]).collect();
        let time = of(&touches);
        close(time.duration(), 99.0 * 3e-5 + 1e-6);
        let last = touches[99][1];
        assert!(!time.has_ended(last + 2e-5) && time.has_ended(last + 3.1e-5));
    }

    #[test]
    fn bodies_that_still_approach_are_in_one_contact() {
        let mut time = ContactTime::default();
        for [from, to] in [[4e-5, 4.4e-5], [7.7e-4, 7.74e-4], [9.4e-4, 9.5e-4]] {
            time.add(from, to, true);
        }
        close(time.duration(), 9.1e-4);
        assert!(!time.has_ended(1e-3) && time.has_ended(1.7e-3));
    }

    #[test]
    fn a_ball_that_falls_again_makes_contacts_of_their_own() {
        // Contacts of 5 ms, and flights that become shorter by a half.
        let time = of(&[[0.0, 0.005], [0.105, 0.11], [0.16, 0.165], [0.19, 0.195]]);
        close(time.duration(), 0.02);
        // A touch and one after a flight.
        close(of(&[[0.0, 1e-6], [1.0, 1.000_001]]).duration(), 2e-6);
    }

    #[test]
    fn many_touches_take_bounded_memory_and_last_as_long() {
        let time = of(&(0..100_000).map(f64::from).map(|t| [t, t + 0.1]).collect::<Vec<_>>());
        assert!(time.touches.len() <= MOST_TOUCHES);
        close(time.duration(), 99_999.1);
    }
}
