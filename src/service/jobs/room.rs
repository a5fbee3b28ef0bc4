//! Room for uploads that are under way: what is still to come counts as if it were on the disk, and all of it as kept by its owner. What is
//! to come of one owner takes three quarters of the room at most, so that slow uploads lock no one else out.

use super::JobsError;
use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// Bytes of uploads that are under way.
#[derive(Clone, Copy, Debug, Default)]
struct UnderWay {
    /// For which there is room.
    promised: u64,
    /// Of these, those that are on the disk.
    arrived: u64,
}

impl UnderWay {
    fn to_come(self) -> u64 {
        self.promised.saturating_sub(self.arrived)
    }
}

/// Room of all uploads, by owner.
#[derive(Debug, Default)]
pub(super) struct Room(Mutex<BTreeMap<String, UnderWay>>);

/// What limits the uploads of an owner [bytes].
#[derive(Clone, Copy, Debug)]
pub(super) struct Limits {
    /// Free space of the disk.
    pub free: u64,
    /// Free space that has to stay.
    pub least_free: u64,
    /// What the owner keeps already.
    pub kept: u64,
    /// What the owner may keep.
    pub most_kept: u64,
}

impl Room {
    fn all(&self) -> MutexGuard<'_, BTreeMap<String, UnderWay>> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// Room for an upload, which is free again when this is dropped.
#[derive(Debug)]
pub(super) struct Promise {
    room: Arc<Room>,
    owner: String,
    bytes: UnderWay,
}

impl Promise {
    /// No room yet.
    pub fn none(room: &Arc<Room>, owner: &str) -> Self {
        Self { room: Arc::clone(room), owner: owner.to_owned(), bytes: UnderWay::default() }
    }

    /// Bytes for which there is no room among so many that come next.
    pub fn lacks(&self, next: u64) -> u64 {
        next.saturating_sub(self.bytes.to_come())
    }

    /// Takes room for more bytes.
    ///
    /// # Errors
    /// `NoRoom`, `OwnerKeeps` or `OwnerUploads`
    pub fn extend(&mut self, more: u64, limits: Limits) -> Result<(), JobsError> {
        let mut all = self.room.all();
        let to_come = all.values().fold(0, |sum: u64, owner| sum.saturating_add(owner.to_come()));
        let of_owner = all.get(&self.owner).map_or(0, |owner| owner.promised);
        let Limits { free, least_free, kept, most_kept } = limits;
        let kept_with = |promised: u64| kept.saturating_add(promised).saturating_add(more);
        // Other uploads may come to nothing, what is kept stays.
        if kept_with(self.bytes.promised) > most_kept {
            return Err(JobsError::OwnerKeeps { most: most_kept, what: "bytes" });
        }
        if kept_with(of_owner) > most_kept {
            return Err(JobsError::OwnerUploads { under_way: of_owner, most: most_kept });
        }
        // One owner leaves a part of the room to others, as of connections.
        let own = all.get(&self.owner).map_or(0, |owner| owner.to_come());
        let of_all = free.saturating_sub(least_free).saturating_sub(to_come - own);
        if own.saturating_add(more) > of_all / 4 * 3 {
            return Err(JobsError::NoRoom { free, to_come, more, least: least_free });
        }
        all.entry(self.owner.clone()).or_default().promised += more;
        self.bytes.promised += more;
        Ok(())
    }

    /// Notes that so many bytes, for which there was room, are on the disk.
    pub fn arrived(&mut self, bytes: u64) {
        self.bytes.arrived += bytes;
        if let Some(of_owner) = self.room.all().get_mut(&self.owner) {
            of_owner.arrived += bytes;
        }
    }
}

impl Drop for Promise {
    fn drop(&mut self) {
        let mut all = self.room.all();
        let Some(of_owner) = all.get_mut(&self.owner) else { return };
        of_owner.promised -= self.bytes.promised;
        of_owner.arrived -= self.bytes.arrived;
        if of_owner.promised == 0 {
            all.remove(&self.owner);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const LIMITS: Limits = Limits { free: 1000, least_free: 100, kept: 200, most_kept: 900 };

    #[test]
    fn uploads_under_way_share_the_disk() {
        let room = Arc::<Room>::default();
        let [mut of_anna, mut of_bert] = ["anna", "bert"].map(|owner| Promise::none(&room, owner));
        assert!(matches!(of_anna.extend(676, LIMITS), Err(JobsError::NoRoom { to_come: 0, .. })));
        of_anna.extend(600, LIMITS).unwrap();
        assert!(matches!(of_bert.extend(226, LIMITS), Err(JobsError::NoRoom { to_come: 600, .. })));
        of_bert.extend(225, LIMITS).unwrap();
        // What is on the disk is counted there.
        of_anna.arrived(600);
        assert_eq!((of_anna.lacks(1), of_bert.lacks(225)), (1, 0));
        of_bert.extend(75, Limits { free: 500, ..LIMITS }).unwrap();
        assert!(of_bert.extend(1, Limits { free: 500, ..LIMITS }).is_err());
        drop((of_anna, of_bert));
        assert!(room.all().is_empty());
    }

    #[test]
    fn uploads_under_way_count_as_kept() {
        let room = Arc::<Room>::default();
        let [mut first, mut second] = [(); 2].map(|()| Promise::none(&room, "anna"));
        assert!(matches!(first.extend(701, LIMITS), Err(JobsError::OwnerKeeps { most: 900, .. })));
        first.extend(500, LIMITS).unwrap();
        first.arrived(500);
        assert!(matches!(second.extend(201, LIMITS), Err(JobsError::OwnerUploads { under_way: 500, .. })));
        Promise::none(&room, "bert").extend(201, LIMITS).unwrap();
        second.extend(200, LIMITS).unwrap();
        drop(first);
        second.extend(470, LIMITS).unwrap();
    }
}
