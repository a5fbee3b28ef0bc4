//! The committed examples are what the service says.

use crate::support::*;
use serde_json::Value;
use std::path::PathBuf;

fn folder() -> PathBuf {
    PathBuf::from(concat!(env!("CARGO_MANIFEST_DIR"), "/api/examples"))
}

fn example(name: &str) -> Value {
    serde_json::from_str(&std::fs::read_to_string(folder().join(name)).unwrap()).unwrap()
}

/// Names of all members, however deep; items of lists are all like the first.
fn shape(value: &Value, place: &str, out: &mut Vec<String>) {
    match value {
        Value::Object(members) => members.iter().for_each(|(name, member)| {
            out.push(format!("{place}/{name}"));
            shape(member, &format!("{place}/{name}"), out);
        }),
        Value::Array(items) => items.iter().take(1).for_each(|item| shape(item, &format!("{place}/0"), out)),
        _ => {}
    }
}

fn assert_alike(answer: &Value, name: &str) {
    let (mut said, mut committed) = (Vec::new(), Vec::new());
    shape(answer, "", &mut said);
    shape(&example(name), "", &mut committed);
    assert_eq!(said, committed, "api/examples/{name}");
}

#[test]
fn answers_have_the_shape_of_the_examples() {
    let server = Server::simulating();
    let client = server.client();
    let request = example("job.request.json");

    assert_alike(&client.post_json("/v1/jobs/validate", &request).json(), "validation.response.json");
    let (job, end) = finished(&client, &request);
    assert_alike(&end, "job.response.json");
    assert_alike(&client.get("/v1/jobs").json(), "job_list.response.json");
    let summary = client.get(&format!("{job}/summary")).json();
    assert_alike(&summary, "summary.response.json");

    let mut wrong = request;
    wrong["end_time_s"] = (-1.0).into();
    let answer = problem(&client.post_json("/v1/jobs", &wrong), 422, "invalid-scene");
    assert_alike(&answer, "invalid_scene.response.json");

    let cube = std::fs::read(folder().join("cube.msh")).unwrap();
    let octets = [("Content-Type", "application/octet-stream")];
    let mesh = client.send("POST", "/v1/meshes", &octets, &cube).json();
    assert_alike(&mesh, "mesh.response.json");
}
