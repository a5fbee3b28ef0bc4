//! Refused requests, counted for the audit log: however many there are, they take a few lines a minute.

use serde::Serialize;
use std::collections::BTreeMap;
use std::net::{IpAddr, Ipv4Addr, Ipv6Addr};
use std::sync::{Mutex, PoisonError};

/// Number of kinds that are counted apart; all others are counted together, by status.
const MOST_KINDS: usize = 100;

/// What is counted together.
#[derive(Clone, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Serialize)]
pub(super) struct Kind {
    /// Owner of the token; null if none was known.
    pub owner: Option<String>,
    /// Network of the clients, `203.0.113.0/24` or `2001:db8:1::/48`; null for many networks.
    pub network: Option<String>,
    /// Status of the answers.
    pub status: u16,
}

/// Refused requests of each kind since they were last taken.
#[derive(Debug, Default)]
pub(super) struct Refusals(Mutex<BTreeMap<Kind, u64>>);

impl Refusals {
    /// Counts a refused request.
    pub fn count(&self, owner: Option<&str>, address: Option<IpAddr>, status: u16) {
        let kind = Kind { owner: owner.map(str::to_owned), network: address.map(network), status };
        let mut counts = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let is_counted_apart = counts.len() < MOST_KINDS || counts.contains_key(&kind);
        let kind = if is_counted_apart { kind } else { Kind { status, ..Kind::default() } };
        *counts.entry(kind).or_default() += 1;
    }

    /// Takes the counts, which begin again.
    pub fn take(&self) -> BTreeMap<Kind, u64> {
        std::mem::take(&mut *self.0.lock().unwrap_or_else(PoisonError::into_inner))
    }
}

/// The network of an address: what one customer of a provider usually has at most.
fn network(address: IpAddr) -> String {
    match address {
        IpAddr::V4(address) => format!("{}/24", Ipv4Addr::from_bits(address.to_bits() & (!0 << 8))),
        IpAddr::V6(address) => format!("{}/48", Ipv6Addr::from_bits(address.to_bits() & (!0 << 80))),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn networks_are_named_as_usual() {
        assert_eq!(network([203, 0, 113, 7].into()), "203.0.113.0/24");
        assert_eq!(network("2001:db8:1:2::3".parse().unwrap()), "2001:db8:1::/48");
    }

    #[test]
    fn many_networks_are_few_kinds() {
        let refusals = Refusals::default();
        for i in 0..100_000_u32 {
            refusals.count(None, Some(IpAddr::from(Ipv4Addr::from_bits(i << 8))), 401);
        }
        refusals.count(Some("anna"), None, 429);
        let counts = refusals.take();
        assert_eq!(counts.len(), MOST_KINDS + 2, "those of all others by status");
        assert_eq!(counts.values().sum::<u64>(), 100_001);
        assert!(refusals.take().is_empty());
    }
}
