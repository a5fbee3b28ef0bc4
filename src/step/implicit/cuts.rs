//! Steps that did not converge and were cut.

use crate::step::failure::Failure;

/// Steps that had to be cut.
#[derive(Default)]
pub(super) struct Cuts {
    count: u64,
    shortest: f64,
    /// Time and reason of the first and of the last cut.
    ends: Option<[(f64, String); 2]>,
}

impl Cuts {
    /// Notes that a step at a time [s] was cut to a length [s], and why.
    pub fn note(&mut self, time: f64, step: f64, reason: &Failure) {
        self.shortest = if self.count == 0 { step } else { self.shortest.min(step) };
        self.count += 1;
        let last = (time, reason.message.clone());
        self.ends = Some(match self.ends.take() {
            Some([first, _]) => [first, last],
            None => [last.clone(), last],
        });
    }

    /// One warning of all cuts.
    pub fn warning(&self) -> Option<String> {
        let [(time, reason), (last, last_reason)] = self.ends.as_ref()?;
        let (count, shortest) = (self.count, self.shortest);
        if count == 1 {
            return Some(format!("The step was cut once, to {shortest:.3e} s at t = {time:.4e} s: {reason}"));
        }
        let first = format!(
            "The step was cut {count} times, to {shortest:.3e} s at least; first at t = {time:.4e} s: {reason}"
        );
        Some(format!("{first} Last at t = {last:.4e} s: {last_reason}"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::step::failure::FailureCause;

    #[test]
    fn many_cuts_are_one_warning() {
        let mut cuts = Cuts::default();
        assert_eq!(cuts.warning(), None);
        let reason = |why: &str| Failure::of_no_run(FailureCause::NewtonNotConverged, why);
        cuts.note(1.0, 0.5, &reason("Too long."));
        assert_eq!(
            cuts.warning().as_deref(),
            Some("The step was cut once, to 5.000e-1 s at t = 1.0000e0 s: Too long.")
        );
        for i in 2..40 {
            cuts.note(f64::from(i), 1.0 / f64::from(i), &reason("Too stiff."));
        }
        cuts.note(50.0, 0.1, &reason("Jammed."));
        let warning = cuts.warning().unwrap_or_default();
        assert!(warning.starts_with(
            "The step was cut 40 times, to 2.564e-2 s at least; first at t = 1.0000e0 s: Too long."
        ));
        assert!(
            warning.ends_with("Last at t = 5.0000e1 s: Jammed.") && !warning.contains("stiff"),
            "{warning}"
        );
    }
}
