//! A database and the bucket with its blobs, on the servers for tests.

use crate::postgres::schema;
use contuse::service::config::ServiceConfig;
use contuse::service::doctor::examine;
use contuse::service::jobs::simulator::Simulator;
use contuse::service::jobs::store::StoreAddress;
use contuse::service::purge;
use std::sync::Arc;

/// Stores under a data folder of their own.
fn stores(database: &str, blobs: &str) -> (tempfile::TempDir, StoreAddress) {
    let dir = tempfile::tempdir().unwrap();
    let stores = StoreAddress::in_folder(dir.path().join("data"));
    (dir, StoreAddress { database: Some(database.into()), blobs: Some(blobs.into()), ..stores })
}

/// Opens stores as a service does; otherwise why not.
async fn open(database: &str, blobs: &str) -> Result<(), String> {
    let (_dir, store) = stores(database, blobs);
    let config = ServiceConfig { store, ..ServiceConfig::default() };
    let engine = Arc::new(Simulator::new(&config.runs));
    purge(config, engine, 36_500).await.map(drop).map_err(|error| error.to_string())
}

#[tokio::test(flavor = "multi_thread")]
async fn a_bucket_is_that_of_one_database_and_a_database_has_one_bucket() {
    let (Some(first), Some(second)) = (schema().await, schema().await) else { return };
    let Some(bucket) = crate::address("CONTUSE_TEST_BLOBS") else { return };
    let [here, there, nowhere] = ["here", "there", "nowhere"].map(|name| format!("{bucket}/{name}"));
    open(&first, &here).await.unwrap();
    open(&first, &here).await.unwrap();
    let foreign = open(&second, &here).await.unwrap_err();
    assert!(foreign.contains("belongs to another database") && foreign.contains(&here), "{foreign}");
    open(&second, &there).await.unwrap();
    assert!(open(&first, &there).await.unwrap_err().contains("belongs to another database"));
    let empty = open(&first, &nowhere).await.unwrap_err();
    assert!(empty.contains("has no object `database`") && empty.contains(&nowhere), "{empty}");
    // As `contuse doctor` reports, which writes nothing.
    for (blobs, refusal) in
        [(&here, None), (&there, Some("belongs to another")), (&nowhere, Some("no object"))]
    {
        let (_dir, stores) = stores(&first, blobs);
        let found = examine(&stores).await.unwrap();
        assert_eq!(found.is_sound(), refusal.is_none());
        assert!(refusal.is_none_or(|words| found.blobs.unwrap().contains(words)));
    }
}
