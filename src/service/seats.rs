//! Seats of connections within the limits. Where none is free, the connection that has waited longest for a request gives its seat up, so
//! that idle ones lock no one out.

use super::permits::{NoPermit, Permit, Permits};
use std::collections::BTreeMap;
use std::net::IpAddr;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError, Weak};
use tokio::sync::Notify;

/// The seats of a listener.
#[derive(Debug)]
pub(super) struct Seats {
    permits: Arc<Permits<IpAddr>>,
    idle: Mutex<Idle>,
}

/// Seats whose connections wait for a request, in the order in which they began to.
#[derive(Debug, Default)]
struct Idle {
    seats: BTreeMap<u64, (IpAddr, Weak<Seat>)>,
    next: u64,
}

impl Seats {
    /// So many seats, of which one address has three quarters at most.
    pub fn new(most: usize) -> Arc<Self> {
        Arc::new(Self { permits: Permits::new(most), idle: Mutex::default() })
    }

    /// A seat for a connection from an address, that of an idle one if none is free.
    ///
    /// # Errors
    /// If none is free, nor idle, of this address where it has all that it may have.
    pub fn take(self: &Arc<Self>, address: IpAddr) -> Result<Arc<Seat>, NoPermit> {
        loop {
            match self.permits.take(address) {
                Ok(permit) => return Ok(Seat::new(self, address, permit)),
                Err(NoPermit::Taken { .. }) if self.vacate(|_| true) => {}
                Err(NoPermit::OfClient { .. }) if self.vacate(|idle| *idle == address) => {}
                Err(refused) => return Err(refused),
            }
        }
    }

    /// Takes the seat of the connection that has been idle for longest among those from some addresses; false if none is.
    fn vacate(&self, is_meant: impl Fn(&IpAddr) -> bool) -> bool {
        let mut idle = self.idle();
        let oldest = idle.seats.iter().find(|(_, (address, _))| is_meant(address)).map(|(turn, _)| *turn);
        let taken = oldest.and_then(|turn| idle.seats.remove(&turn));
        drop(idle);
        // One that is gone has just left its seat itself.
        if let Some(seat) = taken.as_ref().and_then(|(_, seat)| seat.upgrade()) {
            drop(seat.permit().take());
            seat.given_up.notify_one();
        }
        taken.is_some()
    }

    fn idle(&self) -> MutexGuard<'_, Idle> {
        self.idle.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// What a connection does.
#[derive(Clone, Copy, Debug)]
enum State {
    /// It waits for a request, from this turn on.
    Idle(u64),
    /// It has a request.
    Busy,
    /// It has an answer, of which a part may not be sent yet.
    Answered,
}

/// The seat of a connection.
#[derive(Debug)]
pub(super) struct Seat {
    seats: Arc<Seats>,
    address: IpAddr,
    /// None when it was given up.
    permit: Mutex<Option<Permit<IpAddr>>>,
    state: Mutex<State>,
    given_up: Notify,
}

impl Seat {
    fn new(seats: &Arc<Seats>, address: IpAddr, permit: Permit<IpAddr>) -> Arc<Self> {
        let seat = Arc::new(Self {
            seats: Arc::clone(seats),
            address,
            permit: Mutex::new(Some(permit)),
            state: Mutex::new(State::Answered),
            given_up: Notify::new(),
        });
        seat.flushed();
        seat
    }

    /// Notes that the connection is not idle from now on; false if its seat is given up already.
    pub fn is_used(&self) -> bool {
        let mut state = self.state();
        if let State::Idle(turn) = *state
            && self.seats.idle().seats.remove(&turn).is_none()
        {
            return false;
        }
        *state = State::Busy;
        true
    }

    /// Notes that everything there was to send is sent.
    pub fn flushed(self: &Arc<Self>) {
        let mut state = self.state();
        if matches!(*state, State::Answered) {
            let mut idle = self.seats.idle();
            let turn = idle.next;
            idle.next += 1;
            idle.seats.insert(turn, (self.address, Arc::downgrade(self)));
            *state = State::Idle(turn);
        }
    }

    /// Waits until the seat is given up.
    pub async fn given_up(&self) {
        self.given_up.notified().await;
    }

    fn permit(&self) -> MutexGuard<'_, Option<Permit<IpAddr>>> {
        self.permit.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn state(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Drop for Seat {
    fn drop(&mut self) {
        if let State::Idle(turn) = *self.state() {
            self.seats.idle().seats.remove(&turn);
        }
    }
}

/// A request and its answer, on a seat that is busy until this is dropped and the answer sent.
#[derive(Debug)]
pub(super) struct Answering(Arc<Seat>);

impl Answering {
    /// Begins a request; `None` if the seat is given up.
    pub fn on(seat: &Arc<Seat>) -> Option<Self> {
        seat.is_used().then(|| Self(Arc::clone(seat)))
    }
}

impl Drop for Answering {
    fn drop(&mut self) {
        *self.0.state() = State::Answered;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_oldest_idle_connection_makes_room() {
        let seats = Seats::new(4);
        let [here, there] = [[10, 0, 0, 1], [10, 0, 0, 2]].map(IpAddr::from);
        let of_other = seats.take(there).unwrap();
        let own: Vec<Arc<Seat>> = (0..3).map(|_| seats.take(here).unwrap()).collect();
        let request = Answering::on(&own[0]).unwrap();
        // An address that has all its seats takes its own.
        let fourth = seats.take(here).unwrap();
        assert_eq!(own.iter().map(|seat| seat.is_used()).collect::<Vec<bool>>(), [true, false, true]);
        assert!(fourth.is_used() && Answering::on(&own[1]).is_none());
        assert_eq!(seats.take(here).unwrap_err(), NoPermit::OfClient { most: 3 });
        // An answer has to be sent before its connection is idle.
        drop(request);
        assert_eq!(seats.take(here).unwrap_err(), NoPermit::OfClient { most: 3 });
        own[0].flushed();
        assert!(of_other.is_used());
        assert!(seats.take(there).is_ok() && !own[0].is_used());
        drop((of_other, own, fourth));
        assert!(seats.idle().seats.is_empty());
    }
}
