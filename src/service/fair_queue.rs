//! A queue for a few slots, fair to those who wait: small work is not delayed by large work, nor one owner's by another's.
//!
//! There are two lanes. Neither takes all slots while the other waits, so that each always advances. Of those who wait in a
//! lane, the next is one whose owner has the fewest slots, then one whose owner was served longest ago.

use std::collections::{BTreeMap, VecDeque};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;
use tokio::sync::oneshot;

/// Kind of work, by the time that it takes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Lane {
    /// Takes well below a second.
    Small,
    /// Takes seconds; may not take the last slot, which is for small work.
    Large,
}

/// Limits of a queue.
#[derive(Clone, Copy, Debug)]
pub struct QueueLimits {
    /// Number of slots, at least 2.
    pub at_once: usize,
    /// Maximum number of those who wait in each lane.
    pub waiting: usize,
    /// Maximum number of those who wait in each lane for one owner.
    pub waiting_of_owner: usize,
    /// Maximum time of waiting.
    pub timeout: Duration,
}

/// Why work was not begun.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Refusal {
    /// The lane is full for everyone.
    Full {
        /// Number of those who wait in it.
        waiting: usize,
    },
    /// The owner waits for as many slots as one owner may.
    OwnerLimit {
        /// Number of those who wait for this owner.
        waiting: usize,
    },
    /// No slot became free in time.
    TooLong {
        /// How long the request had waited.
        waited: Duration,
    },
}

/// A queue for slots; copies share them.
#[derive(Clone, Debug)]
pub struct FairQueue {
    limits: QueueLimits,
    state: Arc<Mutex<State>>,
}

/// A slot, free again when it is dropped.
#[derive(Debug)]
pub struct Slot {
    queue: FairQueue,
    owner: String,
    lane: Lane,
}

#[derive(Debug, Default)]
struct State {
    small: usize,
    large: usize,
    /// Slots of each owner who has one.
    slots_of: BTreeMap<String, usize>,
    /// When each owner who has or waits for a slot got one, as a count of slots given.
    served: BTreeMap<String, u64>,
    given: u64,
    waiting: VecDeque<Waiter>,
}

#[derive(Debug)]
struct Waiter {
    owner: String,
    lane: Lane,
    slot: oneshot::Sender<Slot>,
}

impl FairQueue {
    /// A queue with all its slots free.
    pub fn new(limits: QueueLimits) -> Self {
        Self { limits, state: Arc::default() }
    }

    /// Waits for a slot.
    ///
    /// # Errors
    /// If too many wait already, or none becomes free in time.
    pub async fn enter(&self, owner: &str, lane: Lane) -> Result<Slot, Refusal> {
        let receiver = self.join(owner, lane)?;
        self.give();
        match tokio::time::timeout(self.limits.timeout, receiver).await {
            Ok(Ok(slot)) => Ok(slot),
            // The sender lives in the queue until it is used.
            Ok(Err(_)) | Err(_) => Err(Refusal::TooLong { waited: self.limits.timeout }),
        }
    }

    fn join(&self, owner: &str, lane: Lane) -> Result<oneshot::Receiver<Slot>, Refusal> {
        let mut state = self.state();
        // Clients that left no longer count.
        state.waiting.retain(|waiter| !waiter.slot.is_closed());
        let in_lane = || state.waiting.iter().filter(|waiter| waiter.lane == lane);
        let (all, own) = (in_lane().count(), in_lane().filter(|waiter| waiter.owner == owner).count());
        if all >= self.limits.waiting {
            return Err(Refusal::Full { waiting: all });
        }
        if own >= self.limits.waiting_of_owner {
            return Err(Refusal::OwnerLimit { waiting: own });
        }
        let (slot, receiver) = oneshot::channel();
        state.waiting.push_back(Waiter { owner: owner.to_owned(), lane, slot });
        Ok(receiver)
    }

    /// Gives all free slots to those who wait.
    fn give(&self) {
        loop {
            let mut state = self.state();
            let Some(waiter) = state.next(self.limits.at_once) else { return };
            let Waiter { owner, lane, slot } = waiter;
            state.given += 1;
            let given = state.given;
            state.served.insert(owner.clone(), given);
            *state.slots_of.entry(owner.clone()).or_default() += 1;
            *state.of_lane(lane) += 1;
            drop(state);
            // A slot that no one takes any more is dropped here, and therefore free again.
            let _ = slot.send(Slot { queue: self.clone(), owner, lane });
        }
    }

    fn state(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl State {
    fn of_lane(&mut self, lane: Lane) -> &mut usize {
        match lane {
            Lane::Small => &mut self.small,
            Lane::Large => &mut self.large,
        }
    }

    /// Takes the next one who may have a slot out of the queue.
    fn next(&mut self, at_once: usize) -> Option<Waiter> {
        if self.small + self.large >= at_once {
            return None;
        }
        let waits = |lane| self.waiting.iter().any(|waiter| waiter.lane == lane);
        let last_slot = at_once.saturating_sub(1).max(1);
        // The last slot is kept for the lane that has none.
        let may_small = self.small < last_slot || self.large > 0 || !waits(Lane::Large);
        let may_large = self.large < last_slot;
        let lane = match (may_small && waits(Lane::Small), may_large && waits(Lane::Large)) {
            (true, _) => Lane::Small,
            (false, true) => Lane::Large,
            (false, false) => return None,
        };
        let rank = |waiter: &Waiter| {
            let slots = self.slots_of.get(&waiter.owner).copied().unwrap_or(0);
            (slots, self.served.get(&waiter.owner).copied().unwrap_or(0))
        };
        let in_lane = self.waiting.iter().enumerate().filter(|(_, waiter)| waiter.lane == lane);
        let (index, _) = in_lane.min_by_key(|(index, waiter)| (rank(waiter), *index))?;
        self.waiting.remove(index)
    }
}

impl Drop for Slot {
    fn drop(&mut self) {
        {
            let mut state = self.queue.state();
            *state.of_lane(self.lane) -= 1;
            let slots = state.slots_of.get(&self.owner).copied().unwrap_or(0);
            if slots > 1 {
                state.slots_of.insert(self.owner.clone(), slots - 1);
            } else {
                state.slots_of.remove(&self.owner);
                if !state.waiting.iter().any(|waiter| waiter.owner == self.owner) {
                    state.served.remove(&self.owner);
                }
            }
        }
        self.queue.give();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn queue(patience_ms: u64) -> FairQueue {
        let timeout = Duration::from_millis(patience_ms);
        FairQueue::new(QueueLimits { at_once: 2, waiting: 6, waiting_of_owner: 4, timeout })
    }

    /// Joins the queue in the order of the calls, and reports its name when it has a slot, for a moment.
    fn join(
        queue: &FairQueue,
        owner: &'static str,
        lane: Lane,
        log: &Arc<Mutex<Vec<&'static str>>>,
    ) -> tokio::task::JoinHandle<()> {
        let (receiver, log, queue) = (queue.join(owner, lane).unwrap(), Arc::clone(log), queue.clone());
        tokio::spawn(async move {
            queue.give();
            let slot = receiver.await.unwrap();
            log.lock().unwrap().push(owner);
            tokio::task::yield_now().await;
            drop(slot);
        })
    }

    #[tokio::test]
    async fn small_work_has_a_slot_however_much_large_work_waits() {
        let queue = queue(20);
        let first = queue.enter("anna", Lane::Large).await.unwrap();
        let late = queue.enter("anna", Lane::Large).await.unwrap_err();
        assert!(matches!(late, Refusal::TooLong { .. }), "the last slot is for small work");
        let small = queue.enter("anna", Lane::Small).await.unwrap();
        drop((first, small));
        // The other way round, too.
        let small = queue.enter("anna", Lane::Small).await.unwrap();
        let other = queue.join("anna", Lane::Large).unwrap();
        let blocked = queue.join("anna", Lane::Small).unwrap();
        queue.give();
        let large = other.await.unwrap();
        drop(blocked);
        drop((small, large));
        assert_eq!(queue.state().slots_of.len(), 0);
    }

    #[tokio::test]
    async fn owners_take_turns() {
        let queue = queue(1000);
        let log = Arc::default();
        let busy = [
            queue.enter("carl", Lane::Small).await.unwrap(),
            queue.enter("carl", Lane::Small).await.unwrap(),
        ];
        let mut all: Vec<_> = (0..4).map(|_| join(&queue, "anna", Lane::Small, &log)).collect();
        all.extend((0..2).map(|_| join(&queue, "bert", Lane::Small, &log)));
        let [first, second] = busy;
        drop(first);
        for task in all {
            task.await.unwrap();
        }
        drop(second);
        assert_eq!(*log.lock().unwrap(), ["anna", "bert", "anna", "bert", "anna", "anna"]);
    }

    #[tokio::test]
    async fn a_full_queue_refuses_at_once() {
        let queue = queue(1000);
        let _busy = [
            queue.enter("carl", Lane::Small).await.unwrap(),
            queue.enter("carl", Lane::Small).await.unwrap(),
        ];
        let mut waiting: Vec<_> = (0..4).map(|_| queue.join("anna", Lane::Small).unwrap()).collect();
        assert_eq!(queue.join("anna", Lane::Small).unwrap_err(), Refusal::OwnerLimit { waiting: 4 });
        waiting.extend((0..2).map(|_| queue.join("bert", Lane::Small).unwrap()));
        assert_eq!(queue.join("bert", Lane::Small).unwrap_err(), Refusal::Full { waiting: 6 });
        assert!(queue.join("bert", Lane::Large).is_ok(), "the other lane has room");
        drop(waiting);
        assert!(queue.join("bert", Lane::Small).is_ok(), "those who left make room");
    }
}
