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
    assert!(server.files().is_empty(), "{:?}", server.files());
}

#[test]
fn unknown_meshes_are_not_found() {
    let server = Server::start();
    for id in ["x", "..%2fjobs.sqlite", &"a".repeat(64), "%ff"] {
        problem(&server.client().get(&format!("/v1/meshes/{id}")), 404, "mesh-not-found");
    }
}

#[test]
fn a_mesh_is_validated_before_it_is_kept() {
    let server = Server::simulating();
    let client = server.client();
    let cube = |top: &str, far: &str| {
        let level = |z: &str, first: u32| {
            let corners = [("0", "0"), ("1", "0"), (far, "1"), ("0", "1")];
            let line = |(i, (x, y)): (u32, (&str, &str))| format!("{}, {x}, {y}, {z}\n", first + i);
            (0..).zip(corners).map(line).collect::<String>()
        };
        let nodes = level("0", 1) + &level(top, 5);
        format!("*NODE\n{nodes}*ELEMENT, TYPE=C3D8, ELSET=cube\n1, 1, 2, 3, 4, 5, 6, 7, 8\n")
    };
    let flat = upload(&client, "", cube("0", "1").as_bytes());
    assert_eq!(flat.status, 201, "{flat:?}");
    let quality = &flat.json()["quality"];
    assert_eq!((&quality["max_aspect_ratio"], &quality["negative_elements"]), (&json!(null), &json!(1)));
    assert_eq!(client.get(flat.header("location").unwrap()).json(), flat.json());
    let huge = problem(&upload(&client, "", cube("1", "1e308").as_bytes()), 422, "invalid-mesh");
    assert!(huge["detail"].as_str().unwrap().contains("element 0"), "{huge}");
    assert_eq!(upload(&client, "", cube("1e-300", "1e-300").as_bytes()).status, 201);

    let wedge =
        cube("1", "1").replace("C3D8", "C3D6").replace("1, 2, 3, 4, 5, 6, 7, 8\n", "1, 2, 3, 5, 6, 7\n");
    let kept = upload(&client, "", wedge.as_bytes());
    assert_eq!((kept.status, &kept.json()["elements"]), (201, &json!(1)), "{kept:?}");
    assert_eq!(kept.json()["notes"], json!(["2 nodes without a volume element were omitted"]), "{kept:?}");
}

#[test]
fn every_body_whose_mesh_was_not_uploaded_is_reported_with_a_remedy() {
    let server = Server::simulating();
    let text = include_str!("../../../api/examples/job.request.json");
    let mut scene: serde_json::Value = serde_json::from_str(text).unwrap();
    for body in 0..2 {
        scene["bodies"][body]["mesh"] = json!({"file": {"name": "ball.msh"}});
    }
    let answer = problem(&server.client().post_json("/v1/jobs/validate", &scene), 422, "invalid-scene");
    let errors = answer["errors"].as_array().unwrap().iter();
    let missing: Vec<_> = errors.filter(|e| e["code"] == "mesh_not_found").collect();
    assert_eq!(missing.len(), 2, "{answer}");
    for (body, error) in missing.into_iter().enumerate() {
        assert_eq!(error["pointer"], format!("/bodies/{body}/mesh/file/name"));
        assert!(error["remedy"].as_str().unwrap().contains("POST /v1/meshes"), "{answer}");
    }
}

/// A scan of 12 × 12 × 8 voxels of 5 mm as MetaImage: fat (1) on muscle (2), and air above.
fn scan() -> Vec<u8> {
    let mut file =
        "ObjectType = Image\nNDims = 3\nBinaryData = True\nCompressedData = False\nElementSpacing = 5 5 5\n\
                    DimSize = 12 12 8\nElementType = MET_UCHAR\nElementDataFile = LOCAL\n"
            .to_owned()
            .into_bytes();
    for k in 0..8 {
        let label = [2, 2, 2, 2, 1, 1, 0, 0][k];
        file.extend([label; 144]);
    }
    file
}

#[test]
fn a_scan_goes_from_upload_to_summary() {
    let server = Server::simulating();
    let client = server.client();
    let kept = upload(&client, "", &scan());
    assert_eq!(kept.status, 201, "{kept:?}");
    let report = kept.json();
    assert_eq!((&report["format"], &report["elements"]), (&json!("mha"), &json!(6 * 144)));
    assert_eq!(report["parts"], json!({"label_1": 288, "label_2": 576}));
    let cut = problem(&upload(&client, "", &scan()[..1000]), 422, "invalid-mesh");
    assert!(cut["detail"].as_str().unwrap().contains("byte 1000"), "{cut}");

    let tissue = json!({"law": "neo_hookean", "c10_pa": 5e3, "bulk_modulus_pa": 2e7});
    let scene = json!({
        "name": "scan", "end_time_s": 2e-4,
        "bodies": [
            {"name": "ball", "role": "projectile", "velocity_m_per_s": [0, 0, -10],
             "rigid": {"shape": {"kind": "ball", "radius_m": 0.01}, "center_m": [-0.0275, -0.0275, 0.0376],
                       "density_kg_per_m3": 7850}},
            {"name": "tissue", "role": "tissue", "fixed": [{"set": "z_min"}],
             "mesh": {"segmentation": {
                "name": report["id"], "size_m": 0.01,
                "labels": [{"label": 1, "part": "fat"}, {"label": 2, "part": "muscle"}],
                "near": [{"point_m": [-0.0275, -0.0275, 0.0275], "size_m": 0.005, "within_m": 0.005}]}},
             "parts": [{"part": "*", "density_kg_per_m3": 1000, "material": tissue}]}
        ],
        "solver": {"error_bars": "none"}
    });
    let (_, job) = finished(&client, &scene);
    assert_eq!(job["state"], "succeeded", "{job}");
}
