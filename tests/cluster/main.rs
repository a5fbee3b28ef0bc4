//! Stores that several machines share, on real servers: PostgreSQL of `tests/cluster/postgres`, S3 of `tests/cluster/s3.py`. The contracts
//! are those of the other stores, compiled against the library.

// A test fails by panicking.
#![allow(clippy::unwrap_used, clippy::expect_used, missing_docs)]

// Where the contracts look for what they use.
use contuse::blobs::{Blob, BlobDigest, BlobEntry, BlobError, BlobStore, Draft, Unnamed};
use contuse::mesh::read::MeshFormat;
use contuse::service::jobs::store::{
    CancelAnswer, DeleteAnswer, Event, Headline, HeadlineNumber, Job, JobEnd, JobStore, MeshDeletion, NewJob,
    OwnerRequest, Page, Quotas, Requeued, Submitted,
};
use contuse::service::jobs::{JobId, JobKind, JobState, JobsError, Progress};
use contuse::{measure, service, step};
use std::io::Write as _;

#[path = "../../src/blobs/tests/mod.rs"]
mod blob_contract;
#[path = "../../src/service/jobs/store/tests.rs"]
mod job_contract;
mod ownership;
mod postgres;
mod s3;

/// The address in a variable; its absence is said aloud: what `eprintln!` writes would be captured.
fn address(variable: &str) -> Option<String> {
    let address = std::env::var(variable).ok();
    if address.is_none() {
        let _ = writeln!(std::io::stderr(), "SKIPPED: {variable} names no server");
    }
    address
}
