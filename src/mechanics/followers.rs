//! Nodes that follow others: `u_c = Σ w_m u_m` with fixed weights, w ≥ 0 and Σ w = 1, such as the hanging nodes
//! between coarse and fine elements.
//!
//! With `u = T q`, q of the independent nodes, forces on a follower act on its masters by the transpose, `Tᵀ f`:
//! their power is the same to the last digit, so no energy is created or lost. Lumped mass is transferred in the same
//! way, `M_m += w M_c` (the lumped `Tᵀ M T`):
//!
//! - The total mass and, at any velocity, the linear momentum are exactly those of the free nodes.
//! - The kinetic energy is not less, `Σ w |v_m|² ≥ |Σ w v_m|²`, so that the element-wise bound of the critical time
//!   step holds:
//!   `uᵀK u ≤ Σ_e λ_e u_eᵀM_e u_e ≤ λ_max (Σ_m M_m |q_m|² + Σ_c M_c Σ_m w |q_m|²) = λ_max qᵀM' q`.
//! - Where `X_c = Σ w X_m`, as for hanging nodes, the moment of the forces is the same and angular momentum is
//!   conserved. The moment of inertia is greater by `M_c Σ w |X_m − X_c|²` per follower: of second order in the size
//!   of the elements.

use super::tensor::Vec3;
use std::collections::BTreeMap;

/// Marks a missing node, or one that is no follower.
const NONE: u32 = u32::MAX;
/// Tolerance within which weights add up to 1.
const ROUNDING: f64 = 1e-12;

/// The masters of a node, with their weights.
pub type Masters = Vec<(u32, f64)>;

/// Why ties between nodes are invalid.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum FollowerError {
    /// The node follows itself, directly or through others.
    #[error("node {0} follows itself")]
    Cycle(u32),
    /// Weights that are negative, not finite, or do not add up to 1; or no masters.
    #[error("the weights of the masters of node {0} must be non-negative with sum 1")]
    Weights(u32),
    /// A follower or a master that does not exist.
    #[error("node {0} follows a node that does not exist, or does not exist itself")]
    NoSuchNode(u32),
}

/// The followers among some nodes, each with masters that are independent.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Followers {
    /// Node numbers of the followers, ascending.
    nodes: Vec<u32>,
    /// Masters of each follower, ascending.
    masters: Lists,
    /// Index in `nodes` of each node, [`NONE`] for others; empty without followers.
    place: Vec<u32>,
    /// Followers of each node, ascending, with its weight in each.
    led: Lists,
}

/// Lists of nodes with weights, contiguous in memory.
#[derive(Clone, Debug, Default, PartialEq)]
struct Lists {
    start: Vec<u32>,
    entries: Masters,
}

impl Lists {
    fn new(lists: impl Iterator<Item = Masters>) -> Self {
        let (mut start, mut entries) = (vec![0], Vec::new());
        for list in lists {
            entries.extend(list);
            start.push(entries.len() as u32);
        }
        Self { start, entries }
    }

    fn of(&self, index: usize) -> &[(u32, f64)] {
        &self.entries[self.start[index] as usize..self.start[index + 1] as usize]
    }
}

impl Followers {
    /// For so many nodes, with the masters of each follower, which may be followers themselves.
    ///
    /// # Errors
    /// [`FollowerError`].
    pub fn new(node_count: usize, ties: &BTreeMap<u32, Masters>) -> Result<Self, FollowerError> {
        if ties.is_empty() {
            return Ok(Self::default());
        }
        // Check nodes and weights.
        for (&node, masters) in ties {
            let exists = |node: u32| (node as usize) < node_count;
            if !exists(node) || !masters.iter().all(|(master, _)| exists(*master)) {
                return Err(FollowerError::NoSuchNode(node));
            }
            let sum: f64 = masters.iter().map(|(_, w)| w).sum();
            if !((sum - 1.0).abs() <= ROUNDING && masters.iter().all(|(_, w)| *w >= 0.0)) {
                return Err(FollowerError::Weights(node));
            }
        }
        // Replace masters that follow others by their own masters.
        let mut resolved = BTreeMap::new();
        for &node in ties.keys() {
            resolve(node, ties, &mut resolved)?;
        }
        // Tables in both directions.
        let nodes: Vec<u32> = resolved.keys().copied().collect();
        let (mut place, mut led) = (vec![NONE; node_count], vec![Masters::new(); node_count]);
        for (i, (node, masters)) in resolved.iter().enumerate() {
            place[*node as usize] = i as u32;
            for (master, w) in masters {
                led[*master as usize].push((*node, *w));
            }
        }
        let masters = Lists::new(resolved.into_values());
        Ok(Self { nodes, masters, place, led: Lists::new(led.into_iter()) })
    }

    /// Whether there are no followers.
    pub fn is_empty(&self) -> bool {
        self.nodes.is_empty()
    }

    /// Number of nodes that follow others.
    pub fn len(&self) -> usize {
        self.nodes.len()
    }

    /// Each follower with its masters, ascending.
    pub fn each(&self) -> impl Iterator<Item = (u32, &[(u32, f64)])> {
        self.nodes.iter().enumerate().map(|(i, node)| (*node, self.masters.of(i)))
    }

    /// Masters of a node; none for most.
    #[inline]
    pub fn masters(&self, node: usize) -> &[(u32, f64)] {
        match self.place.get(node) {
            Some(&place) if place != NONE => self.masters.of(place as usize),
            _ => &[],
        }
    }

    /// Whether a node follows others.
    #[inline]
    pub fn contains(&self, node: usize) -> bool {
        self.place.get(node).is_some_and(|place| *place != NONE)
    }

    /// Followers of a node, with its weight in each.
    #[inline]
    pub fn led_by(&self, node: usize) -> &[(u32, f64)] {
        if self.is_empty() { &[] } else { self.led.of(node) }
    }

    /// The nodes that determine the motion of a node, with their weights: its masters, or itself.
    pub fn movers(&self, node: u32) -> impl Iterator<Item = (u32, f64)> + Clone + '_ {
        let masters = self.masters(node as usize);
        let itself = masters.is_empty().then_some((node, 1.0));
        itself.into_iter().chain(masters.iter().copied())
    }

    /// Sets the motion of each follower to that of its masters: `u_c = Σ w u_m`.
    pub fn follow(&self, field: &mut [Vec3]) {
        for (node, masters) in self.each() {
            field[node as usize] =
                masters.iter().fold(Vec3::zeros(), |sum, (master, w)| sum + field[*master as usize] * *w);
        }
    }

    /// Transfers forces, or impulses, from followers to their masters: `f_m += w f_c`, `f_c = 0`.
    pub fn hand_over(&self, forces: &mut [Vec3]) {
        for (node, masters) in self.each() {
            let force = std::mem::replace(&mut forces[node as usize], Vec3::zeros());
            for (master, w) in masters {
                forces[*master as usize] += force * *w;
            }
        }
    }

    /// Transfers the masses of followers [kg], or other additive quantities of nodes, to their masters.
    pub fn hand_over_masses(&self, masses: &mut [f64]) {
        for (node, masters) in self.each() {
            let mass = std::mem::take(&mut masses[node as usize]);
            for (master, w) in masters {
                masses[*master as usize] += mass * w;
            }
        }
    }

    /// Memory of the tables [bytes].
    pub fn memory(&self) -> usize {
        let lists = |lists: &Lists| 4 * lists.start.len() + size_of_val(&lists.entries[..]);
        4 * (self.nodes.len() + self.place.len()) + lists(&self.masters) + lists(&self.led)
    }
}

/// Resolves the independent masters of a follower into `done`. A follower whose masters are still being resolved has
/// an empty list there.
fn resolve(
    node: u32,
    ties: &BTreeMap<u32, Masters>,
    done: &mut BTreeMap<u32, Masters>,
) -> Result<(), FollowerError> {
    // Depth first, with an explicit stack: chains may be long.
    let mut path = vec![node];
    while let Some(&node) = path.last() {
        if done.get(&node).is_some_and(|masters| !masters.is_empty()) {
            path.pop();
            continue;
        }
        let Some(direct) = ties.get(&node) else { return Err(FollowerError::NoSuchNode(node)) };
        let is_open = |master: &u32| ties.contains_key(master) && !done.contains_key(master);
        let waits_for = |master: &u32| done.get(master).is_some_and(Vec::is_empty);
        if direct.iter().any(|(master, _)| *master == node || waits_for(master)) {
            return Err(FollowerError::Cycle(node));
        }
        if let Some((next, _)) = direct.iter().find(|(master, _)| is_open(master)) {
            done.insert(node, Masters::new());
            path.push(*next);
            continue;
        }
        // All direct masters are resolved: combine their weights.
        let mut sum: BTreeMap<u32, f64> = BTreeMap::new();
        for (master, w) in direct.iter().filter(|(_, w)| *w > 0.0) {
            match done.get(master) {
                Some(masters) => masters.iter().for_each(|(m, v)| *sum.entry(*m).or_default() += w * v),
                None => *sum.entry(*master).or_default() += w,
            }
        }
        done.insert(node, sum.into_iter().collect());
        path.pop();
    }
    Ok(())
}

#[cfg(test)]
#[allow(clippy::unwrap_used, clippy::float_cmp)] // tests may panic; exact equality is intended
mod tests {
    use super::*;

    fn ties(list: &[(u32, &[(u32, f64)])]) -> BTreeMap<u32, Masters> {
        list.iter().map(|(node, masters)| (*node, masters.to_vec())).collect()
    }

    #[test]
    fn chains_end_at_nodes_that_follow_none() {
        let half = |a, b| [(a, 0.5), (b, 0.5)];
        let chain = ties(&[(2, &half(1, 0)), (3, &half(2, 1)), (4, &half(3, 2))]);
        let followers = Followers::new(6, &chain).unwrap();
        assert_eq!(followers.masters(3), [(0, 0.25), (1, 0.75)]);
        assert_eq!(followers.masters(4), [(0, 0.375), (1, 0.625)]);
        assert_eq!(followers.led_by(0), [(2, 0.5), (3, 0.25), (4, 0.375)]);
        assert!(followers.masters(1).is_empty() && followers.led_by(5).is_empty() && followers.len() == 3);
        assert_eq!(followers.movers(5).collect::<Vec<_>>(), [(5, 1.0)]);
    }

    #[test]
    fn cycles_and_weights_that_are_no_fractions_are_refused() {
        let one = |m| [(m, 1.0)];
        let error = |list: &[(u32, &[(u32, f64)])]| Followers::new(5, &ties(list)).unwrap_err();
        assert!(matches!(error(&[(0, &one(1)), (1, &one(2)), (2, &one(0))]), FollowerError::Cycle(_)));
        assert_eq!(error(&[(3, &one(3))]), FollowerError::Cycle(3));
        assert_eq!(error(&[(3, &[(0, 1.5), (1, -0.5)])]), FollowerError::Weights(3));
        assert_eq!(error(&[(3, &[(0, 0.4), (1, 0.5)])]), FollowerError::Weights(3));
        assert_eq!(error(&[(3, &[])]), FollowerError::Weights(3));
        assert_eq!(error(&[(3, &one(5))]), FollowerError::NoSuchNode(3));
        assert_eq!(error(&[(7, &one(1))]), FollowerError::NoSuchNode(7));
    }

    #[test]
    fn power_mass_and_momentum_stay_and_kinetic_energy_does_not_fall() {
        let tied = ties(&[(2, &[(0, 0.5), (1, 0.5)]), (4, &[(0, 0.25), (1, 0.25), (2, 0.25), (3, 0.25)])]);
        let followers = Followers::new(5, &tied).unwrap();
        let mut v: Vec<Vec3> = (0..5).map(|i| Vec3::new(f64::from(i).sin(), f64::from(i * i), 1.0)).collect();
        followers.follow(&mut v);
        assert_eq!(v[2], (v[0] + v[1]) * 0.5);
        let f: Vec<Vec3> = (0..5).map(|i| Vec3::new(1.0, f64::from(i), f64::from(i).cos())).collect();
        let power = |f: &[Vec3]| f.iter().zip(&v).map(|(f, v)| f.dot(v)).sum::<f64>();
        let mut g = f.clone();
        followers.hand_over(&mut g);
        assert!((power(&f) - power(&g)).abs() < 1e-13 * power(&f).abs());
        assert!(g[2] == Vec3::zeros() && g[4] == Vec3::zeros());

        let m = [1.0, 2.0, 3.0, 4.0, 5.0];
        let mut lumped = m;
        followers.hand_over_masses(&mut lumped);
        let momentum = |m: &[f64; 5]| m.iter().zip(&v).map(|(m, v)| v * *m).sum::<Vec3>();
        let kinetic = |m: &[f64; 5]| m.iter().zip(&v).map(|(m, v)| m * v.norm_squared()).sum::<f64>();
        assert!((lumped.iter().sum::<f64>() - 15.0).abs() < 1e-14 && lumped[2] == 0.0 && lumped[4] == 0.0);
        assert!((momentum(&m) - momentum(&lumped)).norm() < 1e-13 * momentum(&m).norm());
        assert!(kinetic(&lumped) > kinetic(&m));
    }
}
