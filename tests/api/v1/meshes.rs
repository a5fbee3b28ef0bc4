//! `POST /v1/meshes`, `GET /v1/meshes/{id}`

use crate::support::client::{Answer, Client};
use crate::support::*;
use serde_json::json;

fn upload(client: &Client, query: &str, bytes: &[u8]) -> Answer {
    client.send("POST", &format!("/v1/meshes{query}"), &[("Content-Type", "application/octet-stream")], bytes)
}

#[test]
fn mesh_is_named_by_its_bytes() {
    let server = Server::start();
    let client = server.client();
    let first = upload(&client, "", b"$MeshFormat");
    assert_eq!(first.status, 201, "{first:?}");
    let mesh = first.json();
    assert_eq!(first.header("location").unwrap(), format!("/v1/meshes/{}", mesh["id"].as_str().unwrap()));
    assert_eq!((&mesh["format"], &mesh["bytes"], &mesh["nodes"]), (&json!("msh"), &json!(11), &json!(8)));
    let again = upload(&client, "", b"$MeshFormat");
    assert_eq!((again.status, &again.json()["id"]), (200, &mesh["id"]));
    assert_eq!(client.get(first.header("location").unwrap()).json(), mesh);

    let mut scene = quick();
    scene["mesh"] = mesh["id"].clone();
    finished(&client, &scene);
}

#[test]
fn what_is_no_mesh_leaves_nothing() {
    let server = Server::with(|c| c.budget.mesh_bytes = 1000);
    let client = server.client();
    problem(&upload(&client, "", b"$ broken"), 422, "invalid-mesh");
    problem(&upload(&client, "", b"hello"), 422, "invalid-mesh");
    problem(&upload(&client, "", b""), 422, "invalid-mesh");
    problem(&upload(&client, "", &[b'$'; 1001]), 413, "body-too-large");
    problem(&upload(&client, "?format=stl", b"$"), 400, "bad-parameter");
    problem(&upload(&client, "?path=/etc/passwd", b"$"), 400, "bad-parameter");
    let form = [("Content-Type", "multipart/form-data; boundary=x")];
    problem(&client.send("POST", "/v1/meshes", &form, b"$"), 415, "unsupported-media-type");
    for folder in ["meshes", "uploads"] {
        assert_eq!(std::fs::read_dir(server.data.path().join(folder)).unwrap().count(), 0, "{folder}");
    }
}

#[test]
fn unknown_meshes_are_not_found() {
    let server = Server::start();
    for id in ["x", "..%2fjobs.sqlite", &"a".repeat(64), "%ff"] {
        problem(&server.client().get(&format!("/v1/meshes/{id}")), 404, "mesh-not-found");
    }
    problem(&server.client().get("/v1/meshes"), 405, "method-not-allowed");
}
