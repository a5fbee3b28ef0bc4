//! Limits of simultaneous requests that may take long: uploads, downloads, event streams. Each kind has a part of the connections,
//! so that short requests always find one, and each client a part of its kind: the owner of a token, wherever the requests come from, or an
//! address.

use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// Permits of one kind.
#[derive(Debug)]
pub struct Permits<C: Ord> {
    most: usize,
    most_of_client: usize,
    taken: Mutex<BTreeMap<C, usize>>,
}

/// A permit, free again when it is dropped.
#[derive(Debug)]
pub struct Permit<C: Ord> {
    permits: Arc<Permits<C>>,
    client: C,
}

/// Why there is no permit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum NoPermit {
    /// As many as there are at once are in use.
    Taken {
        /// How many there are at once.
        most: usize,
    },
    /// The client has as many as one client may.
    OfClient {
        /// How many one client may have.
        most: usize,
    },
}

impl<C: Clone + Ord> Permits<C> {
    /// This many permits, three quarters of them for one client.
    pub fn new(most: usize) -> Arc<Self> {
        let most = most.max(1);
        Arc::new(Self { most, most_of_client: (3 * most).div_ceil(4), taken: Mutex::default() })
    }

    /// Takes a permit.
    ///
    /// # Errors
    /// If the client has all that it may have, or all are taken.
    pub fn take(self: &Arc<Self>, client: C) -> Result<Permit<C>, NoPermit> {
        let mut taken = self.taken();
        if taken.get(&client).is_some_and(|count| *count >= self.most_of_client) {
            return Err(NoPermit::OfClient { most: self.most_of_client });
        }
        if taken.values().sum::<usize>() >= self.most {
            return Err(NoPermit::Taken { most: self.most });
        }
        *taken.entry(client.clone()).or_default() += 1;
        Ok(Permit { permits: Arc::clone(self), client })
    }
}

impl<C: Ord> Permits<C> {
    fn taken(&self) -> MutexGuard<'_, BTreeMap<C, usize>> {
        self.taken.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl<C: Ord> Drop for Permit<C> {
    fn drop(&mut self) {
        let mut taken = self.permits.taken();
        match taken.get_mut(&self.client) {
            Some(count) if *count > 1 => *count -= 1,
            _ => {
                taken.remove(&self.client);
            }
        }
    }
}

/// A permit of a request, for its [sender](super::http::Sender).
pub type RequestPermit = Permit<String>;

/// Permits of all kinds.
#[derive(Debug)]
pub struct AllPermits {
    /// Bodies that are received.
    pub uploads: Arc<Permits<String>>,
    /// Recordings and archives that are sent.
    pub downloads: Arc<Permits<String>>,
    /// Event streams that are open.
    pub streams: Arc<Permits<String>>,
}

impl AllPermits {
    /// A quarter of the connections for each kind.
    pub fn of(connections: usize) -> Self {
        let kind = || Permits::new(connections / 4);
        Self { uploads: kind(), downloads: kind(), streams: kind() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_client_leaves_permits_for_others() {
        let permits = Permits::new(4);
        let mut own: Vec<Permit<&str>> = (0..3).map(|_| permits.take("anna").unwrap()).collect();
        assert_eq!(permits.take("anna").unwrap_err(), NoPermit::OfClient { most: 3 });
        let other = permits.take("bert").unwrap();
        assert_eq!(permits.take("bert").unwrap_err(), NoPermit::Taken { most: 4 });
        own.pop();
        own.push(permits.take("anna").unwrap());
        drop((own, other));
        assert!(permits.taken().is_empty());
    }
}
