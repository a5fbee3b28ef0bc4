//! Limits of simultaneous requests that may take long: uploads, downloads, event streams. Each kind has a part of the connections,
//! so that short requests always find one, and each address a part of its kind.

use std::collections::BTreeMap;
use std::net::IpAddr;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// Permits of one kind.
#[derive(Debug)]
pub struct Permits {
    most: usize,
    most_of_address: usize,
    taken: Mutex<BTreeMap<IpAddr, usize>>,
}

/// A permit, free again when it is dropped.
#[derive(Debug)]
pub struct Permit {
    permits: Arc<Permits>,
    address: IpAddr,
}

/// Why there is no permit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum NoPermit {
    /// As many as there are at once are in use.
    Taken {
        /// How many there are at once.
        most: usize,
    },
    /// The address has as many as one address may.
    OfAddress {
        /// How many one address may have.
        most: usize,
    },
}

impl Permits {
    /// This many permits, three quarters of them for one address.
    pub fn new(most: usize) -> Arc<Self> {
        let most = most.max(1);
        Arc::new(Self { most, most_of_address: (3 * most).div_ceil(4), taken: Mutex::default() })
    }

    /// Takes a permit.
    ///
    /// # Errors
    /// If all are taken, or all that the address may have.
    pub fn take(self: &Arc<Self>, address: IpAddr) -> Result<Permit, NoPermit> {
        let mut taken = self.taken();
        if taken.values().sum::<usize>() >= self.most {
            return Err(NoPermit::Taken { most: self.most });
        }
        let count = taken.entry(address).or_default();
        if *count >= self.most_of_address {
            return Err(NoPermit::OfAddress { most: self.most_of_address });
        }
        *count += 1;
        Ok(Permit { permits: Arc::clone(self), address })
    }

    fn taken(&self) -> MutexGuard<'_, BTreeMap<IpAddr, usize>> {
        self.taken.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Drop for Permit {
    fn drop(&mut self) {
        let mut taken = self.permits.taken();
        match taken.get_mut(&self.address) {
            Some(count) if *count > 1 => *count -= 1,
            _ => {
                taken.remove(&self.address);
            }
        }
    }
}

/// Permits of all kinds.
#[derive(Debug)]
pub struct AllPermits {
    /// Bodies that are received.
    pub uploads: Arc<Permits>,
    /// Recordings and archives that are sent.
    pub downloads: Arc<Permits>,
    /// Event streams that are open.
    pub streams: Arc<Permits>,
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
    fn one_address_leaves_permits_for_others() {
        let permits = Permits::new(4);
        let [here, there] = [[10, 0, 0, 1], [10, 0, 0, 2]].map(IpAddr::from);
        let mut own: Vec<Permit> = (0..3).map(|_| permits.take(here).unwrap()).collect();
        assert_eq!(permits.take(here).unwrap_err(), NoPermit::OfAddress { most: 3 });
        let other = permits.take(there).unwrap();
        assert_eq!(permits.take(there).unwrap_err(), NoPermit::Taken { most: 4 });
        own.pop();
        own.push(permits.take(here).unwrap());
        drop((own, other));
        assert!(permits.taken().is_empty());
    }
}
