//! Whose blobs a store has. A database deletes the blobs that no row of it refers to, so it leaves its identity among them, and uses no
//! others.

use super::JobsError;
use super::store::Identity;
use crate::blobs::{BlobError, BlobStore, Draft};
use crate::service::shelves::DATABASE;
use std::io::Read as _;

/// More bytes than an identity has.
const MOST_BYTES: u64 = 64;

/// Makes a store of blobs that of a database, if it is no other's.
///
/// # Errors
/// `ForeignBlobs`, `UnmarkedBlobs`, or if the store fails.
pub fn claim(blobs: &dyn BlobStore, own: &Identity) -> Result<(), JobsError> {
    if !check(blobs, own)? {
        let mut draft = Draft::new(blobs.unnamed()?, MOST_BYTES);
        draft.append(own.id.as_bytes())?;
        draft.keep(DATABASE)?;
        // Another one may have done so at the same time.
        check(blobs, own)?;
    }
    Ok(())
}

/// Checks that a store of blobs is that of a database; false if it is no one's yet.
///
/// # Errors
/// `ForeignBlobs`, `UnmarkedBlobs`, or if the store fails.
pub fn check(blobs: &dyn BlobStore, own: &Identity) -> Result<bool, JobsError> {
    let address = || blobs.place("").trim_end_matches('/').to_owned();
    let Some(blob) = blobs.open(DATABASE)? else {
        return if own.has_blobs {
            Err(JobsError::UnmarkedBlobs { address: address(), own: own.id.clone() })
        } else {
            Ok(false)
        };
    };
    let mut found = String::new();
    blob.take(MOST_BYTES).read_to_string(&mut found).map_err(BlobError::of(DATABASE))?;
    // Written by hand, it may end with a line.
    match found.trim() {
        found if found == own.id => Ok(true),
        found => {
            Err(JobsError::ForeignBlobs { address: address(), found: found.to_owned(), own: own.id.clone() })
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::blobs::FolderBlobs;

    fn identity(id: &str) -> Identity {
        Identity { id: id.into(), has_blobs: false }
    }

    #[test]
    fn a_store_is_that_of_the_first_database_that_uses_it() {
        let dir = tempfile::tempdir().unwrap();
        let blobs = FolderBlobs::open(dir.path()).unwrap();
        let [first, second] = ["first", "second"].map(identity);
        assert!(!check(&blobs, &first).unwrap());
        claim(&blobs, &first).unwrap();
        claim(&blobs, &first).unwrap();
        assert!(check(&blobs, &Identity { has_blobs: true, ..first.clone() }).unwrap());
        for refused in [claim(&blobs, &second), check(&blobs, &second).map(drop)] {
            let text = refused.unwrap_err().to_string();
            assert!(
                ["--blobs", "--database", "first", "second"].iter().all(|part| text.contains(part)),
                "{text}"
            );
        }
        assert!(check(&blobs, &first).unwrap(), "as it was");
    }

    #[test]
    fn an_empty_store_is_not_that_of_a_database_that_has_blobs() {
        let dir = tempfile::tempdir().unwrap();
        let blobs = FolderBlobs::open(dir.path()).unwrap();
        let own = Identity { has_blobs: true, ..identity("first") };
        let text = claim(&blobs, &own).unwrap_err().to_string();
        assert!(text.contains("--blobs") && text.contains("`database`") && text.contains("first"), "{text}");
        // The remedy that it names.
        std::fs::write(dir.path().join(DATABASE), "first\n").unwrap();
        claim(&blobs, &own).unwrap();
    }
}
