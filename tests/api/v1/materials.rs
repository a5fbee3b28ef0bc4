//! `/v1/materials`

use crate::support::*;
use serde_json::Value;

#[test]
fn materials_are_listed_and_read_one_by_one() {
    let server = Server::start();
    let client = server.client();
    let list = client.get("/v1/materials");
    assert_eq!(list.status, 200);
    let sets: Vec<Value> = serde_json::from_str(&list.text()).unwrap();
    assert!(sets.len() > 15, "{}", sets.len());
    for set in &sets {
        let one = client.get(&format!("/v1/materials/{}", set["name"].as_str().unwrap()));
        assert_eq!(one.status, 200);
        assert_eq!(&serde_json::from_str::<Value>(&one.text()).unwrap(), set);
        assert!(set["material"]["law"].is_string() && set["sources"][0]["url"].is_string(), "{set}");
    }
    let missing = client.get("/v1/materials/muscle/zhai_2019_ogdn");
    assert_eq!(missing.status, 404);
    assert!(missing.text().contains("muscle/zhai_2019_ogden"), "{}", missing.text());
}
