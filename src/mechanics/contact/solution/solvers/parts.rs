//! A problem whose contacts fall into groups that W does not connect, such as piles that do not touch: each group is a problem of its own,
//! solved to its own tolerance, so that one hard group costs nothing in the others.

use super::method::Method;
use super::options::{Options, SolveReport, Work};
use crate::contact::solution::connected::Connected;
use crate::contact::solution::delassus::Delassus;
use crate::contact::solution::problem::{ContactProblem, ProblemError, local, squared};

/// Tolerance of a group and free velocities below which it stays at rest, as fractions of the tolerance of the whole; the errors of all
/// groups together are then within it: `½² · 2 + ½² ≤ 1`, since `Σ max(r², q²) ≤ 2 max(Σ r², Σ q²)`.
const SHARE: f64 = 0.5;

/// Groups of contacts that W connects, directly or through others, each ascending, in the order of their first contacts.
pub(super) fn groups(W: &Delassus) -> Vec<Vec<usize>> {
    let contacts = W.contacts();
    let mut connected = Connected::default();
    connected.restart(contacts);
    match W {
        Delassus::Sparse(W) => {
            (0..contacts).for_each(|c| W.row(c).for_each(|(d, _)| connected.join(c, d)));
        }
        Delassus::Dense(W) => {
            for (c, d) in (0..contacts).flat_map(|c| (0..c).map(move |d| (c, d))) {
                if !connected.are_one(c, d) && (W.connects(c, d) || W.connects(d, c)) {
                    connected.join(c, d);
                }
            }
        }
    }
    connected.close();
    let mut lists = vec![Vec::new(); contacts];
    connected.firsts().iter().enumerate().for_each(|(c, first)| lists[*first].push(c));
    lists.retain(|list| !list.is_empty());
    lists
}

/// What the solutions of the groups took; that with the most iterations names the solver.
pub(super) struct OfGroups {
    pub total: Work,
    /// Whether each group is solved, to its own tolerance or by what its error is beside the free velocities of all.
    pub all_solved: bool,
    most: usize,
}

impl OfGroups {
    /// Adds the report of a group, whose error `is_small` beside the free velocities of all.
    fn add(&mut self, of_group: &SolveReport, is_small: bool) {
        if of_group.iterations > self.most {
            (self.most, self.total.solver) = (of_group.iterations, of_group.solver);
        }
        self.total.iterations += of_group.iterations;
        self.total.failed_contacts += of_group.failed_contacts;
        self.total.is_jammed |= of_group.is_jammed && !is_small;
        self.all_solved &= of_group.converged || is_small;
    }
}

/// Solves each group from `r` by `solve`; the limit of iterations is that of each.
pub(super) fn solve(
    problem: &ContactProblem,
    groups: &[Vec<usize>],
    r: &mut [f64],
    options: &Options,
    solve: impl Fn(&ContactProblem, &mut [f64], &Options) -> SolveReport,
) -> Result<OfGroups, ProblemError> {
    let free = |c: usize| squared(local(problem.q(), c)) / problem.scales()[c];
    let all: f64 = (0..problem.contacts()).map(free).sum();
    let least = (SHARE * options.tolerance).powi(2) * all / groups.len() as f64;
    let total = Work { solver: Method::Nsgs, iterations: 0, failed_contacts: 0, is_jammed: false };
    let mut work = OfGroups { total, all_solved: true, most: 0 };
    let mut left = problem.contacts();
    for group in groups {
        // A group has a share of the time that is left by its number of contacts.
        let given = || options.spent.map_or(0.0, |spent| spent());
        let (from, share) = (given(), group.len() as f64 / left as f64);
        let spent = || if from < 1.0 { (given() - from) / (share * (1.0 - from)) } else { 1.0 };
        left -= group.len();
        let own = Options { tolerance: SHARE * options.tolerance, spent: Some(&spent), ..*options };
        let at = |x: &[f64]| -> Vec<f64> { group.iter().flat_map(|c| local(x, *c)).collect() };
        let mut of_group = vec![0.0; 3 * group.len()];
        let of_free: f64 = group.iter().map(|c| free(*c)).sum();
        if of_free > least {
            let operator = problem.W().part(group)?;
            let mu = group.iter().map(|c| problem.mu()[*c]).collect();
            of_group = at(r);
            let report = solve(&ContactProblem::new(operator, at(problem.q()), mu)?, &mut of_group, &own);
            // Its errors must not hide behind the reactions of another.
            let is_small = report.error_of_free * of_free.sqrt() <= options.tolerance * all.sqrt();
            work.add(&report, is_small);
        }
        for (c, own) in group.iter().zip(of_group.chunks_exact(3)) {
            r[3 * c..3 * c + 3].copy_from_slice(own);
        }
    }
    Ok(work)
}

#[cfg(test)]
mod tests {
    use super::super::{solve, solve_connected};
    use super::*;
    use crate::contact::solution::delassus::Block;
    use crate::random::Random;

    /// Chains of contacts, interleaved: contact `i` belongs to chain `i % chains`.
    fn chains(chains: usize, length: usize, random: &mut Random) -> ContactProblem {
        let own: Block = [[2.0, 0.1, 0.0], [0.1, 2.0, 0.0], [0.0, 0.0, 2.0]];
        let next: Block = [[-0.7, 0.0, 0.1], [0.0, -0.5, 0.0], [0.1, 0.0, -0.5]];
        let count = chains * length;
        let blocks = (0..count).flat_map(|c| {
            let beside = c.checked_sub(chains).into_iter().chain((c + chains < count).then_some(c + chains));
            std::iter::once((c, c, own)).chain(beside.map(move |d| (c, d, next)))
        });
        let W = Delassus::from_blocks(count, blocks).unwrap();
        let q = (0..count).flat_map(|_| [random.next() - 0.5, random.next(), random.next()]).collect();
        ContactProblem::new(W, q, vec![0.4; count]).unwrap()
    }

    #[test]
    fn chains_that_do_not_touch_are_solved_one_by_one_within_the_tolerance_of_all() {
        let problem = chains(5, 8, &mut Random(3));
        let found = groups(problem.W());
        assert_eq!(found.len(), 5);
        assert_eq!(found[1], (0..8).map(|i| 1 + 5 * i).collect::<Vec<_>>());
        let (mut r, mut whole) = (vec![0.0; 120], vec![0.0; 120]);
        let options = Options { tolerance: 1e-11, ..Options::default() };
        let report = solve(&problem, &mut r, &options);
        assert!(report.converged && problem.error_scaled(&r) <= 1e-11, "{report:?}");
        let at_once = solve_connected(&problem, &mut whole, &options);
        assert!(at_once.converged && r.iter().zip(&whole).all(|(a, b)| (a - b).abs() < 1e-9));
    }

    #[test]
    fn a_group_that_hardly_moves_stays_at_rest() {
        let given = chains(2, 4, &mut Random(3));
        let slow = given.q().iter().enumerate().map(|(i, q)| if i / 3 % 2 == 0 { *q } else { 1e-12 * q });
        let problem = ContactProblem::new(given.W().clone(), slow.collect(), given.mu().to_vec()).unwrap();
        let mut r = vec![0.0; 24];
        assert!(solve(&problem, &mut r, &Options::default()).converged);
        assert!((0..8).all(|c| c % 2 == 0 || r[3 * c..3 * c + 3] == [0.0; 3]));
        assert!(r.iter().any(|r| *r > 0.0));
    }

    #[test]
    fn a_group_that_cannot_be_solved_hides_nothing_and_takes_no_time_of_others() {
        // A mass between a floor and a press, beside chains: both contacts of the mass have the same row of W, of opposite signs.
        let random = &mut Random(3);
        let given = chains(5, 8, random);
        let Delassus::Sparse(W) = given.W() else { panic!("sparse") };
        let eye: Block = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        let across = eye.map(|row| row.map(|x| -x));
        let squeezed = [(0, 0, eye), (0, 1, across), (1, 0, across), (1, 1, eye)];
        let rows = (0..40).flat_map(|c| W.row(c).map(move |(d, block)| (c + 2, d + 2, *block)));
        let W = Delassus::from_blocks(42, squeezed.into_iter().chain(rows)).unwrap();
        for speed in [1.0, 1e-3, 1e-5] {
            let q = [0.0, 0.0, 0.0, -speed, 0.0, 0.0].into_iter().chain(given.q().iter().copied());
            let problem = ContactProblem::new(W.clone(), q.collect(), vec![0.4; 42]).unwrap();
            let calls = std::cell::Cell::new(0.0);
            let spent = || calls.replace(calls.get() + 1.0) / 4000.0;
            let mut r = vec![0.0; 126];
            let report = solve(&problem, &mut r, &Options { spent: Some(&spent), ..Options::default() });
            assert!(report.is_jammed && !report.converged, "{speed}: {report:?}");
            assert!(given.error_scaled(&r[6..]) <= 1e-8, "{speed}: the others are solved");
        }
    }
}
