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
    let server = Server::with(|c| c.runs.budget.mesh_bytes = 1000);
    let client = server.client();
    problem(&upload(&client, "", b"$ broken"), 422, "invalid-mesh");
    problem(&upload(&client, "", b"hello"), 422, "invalid-mesh");
    problem(&upload(&client, "", b""), 422, "invalid-mesh");
    problem(&upload(&client, "", &[b'$'; 1001]), 413, "body-too-large");
    problem(&upload(&client, "?format=obj", b"$"), 400, "bad-parameter");
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
fn a_first_scene_of_a_scan_says_what_is_missing_and_where_a_ball_touches_it() {
    let server = Server::simulating();
    let client = server.client();
    let id = upload(&client, "", &scan()).json()["id"].as_str().unwrap().to_owned();
    let address = format!("/v1/meshes/{id}/first-scene");
    let first = client.get(&format!("{address}?radius_m=0.01&through_m=-0.0275,-0.0275,0")).json();
    let segmentation = &first["scene"]["bodies"][0]["mesh"]["segmentation"];
    assert_eq!(segmentation["name"], json!(id));
    assert!(first["scene"]["end_time_s"].is_null(), "{first}");
    // It is cut at all ends but the upper one, below the air.
    assert_eq!(first["sets"], json!(["x_min", "x_max", "y_min", "y_max", "z_min"]));
    let touches = first["touches"].as_array().unwrap();
    let above = touches.iter().find(|touch| touch["direction"] == json!([0.0, 0.0, -1.0])).unwrap();
    let z = above["center_m"][2].as_f64().unwrap();
    assert!((z - 0.0375).abs() < 1e-3, "{above}");
    for query in ["?radius_m=0", "?radius_m=x", "?through_m=1,2", "?through_m=1,2,inf", "?speed=1"] {
        problem(&client.get(&format!("{address}{query}")), 400, "bad-parameter");
    }
    problem(&client.get(&format!("/v1/meshes/{}/first-scene", "a".repeat(64))), 404, "mesh-not-found");
    let surface = b"solid a\nfacet normal 0 0 0\nouter loop\n".as_slice();
    problem(&upload(&client, "", surface), 422, "invalid-mesh");
}

/// A box around (x, y, z) = (0, 0, 0) in millimetres, as ASCII STL.
fn brick(half: [f64; 3]) -> Vec<u8> {
    let faces = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let corner = |n: usize| {
        let at = |k: usize| if n >> k & 1 == 1 { half[k] } else { -half[k] };
        format!("vertex {} {} {}\n", at(0), at(1), at(2))
    };
    let triangle = |nodes: [usize; 3]| {
        format!("facet normal 0 0 0\nouter loop\n{}endloop\nendfacet\n", nodes.map(corner).concat())
    };
    let text: String = faces.map(|[a, b, c, d]| triangle([a, b, c]) + &triangle([a, c, d])).concat();
    format!("solid brick\n{text}endsolid brick\n").into_bytes()
}

#[test]
fn surfaces_in_each_other_are_begun_together_and_run() {
    let server = Server::simulating();
    let client = server.client();
    let sizes = [("muscle", [30.0, 30.0, 20.0]), ("Left femur", [8.0, 8.0, 8.0])];
    let [muscle, bone] =
        sizes.map(|(_, half)| upload(&client, "", &brick(half)).json()["id"].as_str().unwrap().to_owned());
    // In any order: the larger one is around the other.
    let address = format!("/v1/meshes/{bone}/first-scene");
    let with = format!("name=Left%20femur.stl&with={muscle}:muscle.stl");
    let first = client.get(&format!("{address}?{with}&radius_m=0.01")).json();
    let parts: Vec<&str> =
        first["parts"].as_array().unwrap().iter().map(|p| p["part"].as_str().unwrap()).collect();
    assert_eq!(parts, ["muscle", "Left femur"]);
    let body = &first["scene"]["bodies"][0];
    let surfaces = json!([
        {"name": muscle, "part": "muscle", "scale": 0.001}, {"name": bone, "hole": "Left femur", "scale": 0.001}
    ]);
    assert_eq!(body["mesh"]["segmentation"]["surfaces"], surfaces);
    assert_eq!(body["fixed"], json!([{"set": "Left femur"}]));
    let touches = first["touches"].as_array().unwrap();
    let above = touches.iter().find(|touch| touch["direction"] == json!([0.0, 0.0, -1.0])).unwrap();
    assert!((above["center_m"][2].as_f64().unwrap() - 0.03).abs() < 1e-9, "{above}");
    let unnamed = client.get(&format!("{address}?with={muscle}")).json();
    let parts = [0, 1].map(|n| unnamed["parts"][n]["part"].as_str().unwrap().to_owned());
    assert_eq!(parts, ["part_2", "part_1"]);
    problem(&client.get(&format!("{address}?with={muscle}/{bone}:again.stl")), 400, "bad-parameter");
    // Completed, it runs.
    let mut scene = first["scene"].clone();
    scene["end_time_s"] = json!(2e-4);
    scene["bodies"][0]["mesh"]["segmentation"]["size_m"] = json!(0.01);
    scene["bodies"].as_array_mut().unwrap().push(json!({
        "name": "ball", "role": "projectile", "velocity_m_per_s": [0, 0, -5],
        "rigid": {"shape": {"kind": "ball", "radius_m": 0.01}, "center_m": [0, 0, 0.031], "mass_kg": 0.01}
    }));
    scene["solver"] = json!({"error_bars": "none"});
    let (_, job) = finished(&client, &scene);
    assert_eq!(job["state"], "succeeded", "{job}");
    // One alone, too, which is then the tissue; and cut.
    let alone = client.get(&address).json();
    assert_eq!(alone["scene"]["bodies"][0]["mesh"]["segmentation"]["surfaces"][0]["part"], json!("part_1"));
    let section = client.get(&format!("/v1/meshes/{muscle}/section?normal=z")).json();
    assert_eq!(
        section["parts"][0]["outlines"],
        json!([[[-30.0, -30.0], [30.0, -30.0], [30.0, 30.0], [-30.0, 30.0]]])
    );
    // What is no surface, not there, or no id.
    let scan = upload(&client, "", &scan()).json()["id"].as_str().unwrap().to_owned();
    problem(&client.get(&format!("{address}?with={scan}")), 422, "invalid-mesh");
    problem(&client.get(&format!("{address}?with={}", "a".repeat(64))), 404, "mesh-not-found");
    problem(&client.get(&format!("{address}?with=muscle.stl")), 400, "bad-parameter");
}

#[test]
fn a_scan_is_cut_by_a_plane() {
    let server = Server::simulating();
    let client = server.client();
    let id = upload(&client, "", &scan()).json()["id"].as_str().unwrap().to_owned();
    let address = format!("/v1/meshes/{id}/section");
    let section = client.get(&format!("{address}?normal=y&at=-0.03")).json();
    // Files of MetaImage have x and y reversed; the first voxel lies around 0.
    let [x, z] = [[-0.0575, 0.0025], [-0.0025, 0.0175]];
    let muscle = json!({"part": "label_2", "label": 2, "outlines": [[[x[0], z[0]], [x[1], z[0]], [x[1], z[1]], [x[0], z[1]]]]});
    assert_eq!(section["parts"].as_array().unwrap().len(), 2);
    assert_eq!(section["parts"][1], muscle);
    assert_eq!(client.get(&format!("{address}?normal=y&at=1")).json(), json!({"at": 1.0, "parts": []}));
    for query in ["", "?normal=w", "?normal=x&at=inf", "?normal=x&at=1&scale=1"] {
        problem(&client.get(&format!("{address}{query}")), 400, "bad-parameter");
    }
    problem(&client.get(&format!("/v1/meshes/{}/section?normal=x", "a".repeat(64))), 404, "mesh-not-found");
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
    assert!(report.get("quality").is_none(), "voxels are no elements: {report}");
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

/// A block of 4 × 4 × 2 cubes of 5 mm as a legacy file of VTK, with a fibre and a stiffness factor in every cell.
fn mesh_with_arrays() -> Vec<u8> {
    let lines = |items: Vec<String>| items.join("\n") + "\n";
    let at = |i: usize, j: usize, k: usize| i + 5 * j + 25 * k;
    let points = (0..75).map(|n| {
        format!("{} {} {}", 0.005 * f64::from(n % 5), 0.005 * f64::from(n / 5 % 5), 0.005 * f64::from(n / 25))
    });
    let cell = |n: usize| {
        let (i, j, k) = (n % 4, n / 4 % 4, n / 16);
        let ring = |k: usize| [at(i, j, k), at(i + 1, j, k), at(i + 1, j + 1, k), at(i, j + 1, k)];
        let nodes: Vec<String> = [ring(k), ring(k + 1)].concat().iter().map(usize::to_string).collect();
        format!("8 {}", nodes.join(" "))
    };
    let header =
        "# vtk DataFile Version 3.0\nblock\nASCII\nDATASET UNSTRUCTURED_GRID\nPOINTS 75 double\n".to_owned();
    let text = header
        + &lines(points.collect())
        + "CELLS 32 288\n"
        + &lines((0..32).map(cell).collect())
        + "CELL_TYPES 32\n"
        + &"12\n".repeat(32)
        + "CELL_DATA 32\nVECTORS fibre double\n"
        + &lines((0..32).map(|n| format!("1 {} 0", 0.1 * f64::from(n))).collect())
        + "SCALARS grade double\nLOOKUP_TABLE default\n"
        + &lines((0..32).map(|n| format!("{}", 1 + n / 16)).collect());
    text.into_bytes()
}

/// A tetrahedron with its tip down as ASCII STL, in millimetres.
fn tip() -> String {
    let x = ["0 0 0", "-9 -9 9", "9 -9 9", "0 9 9"];
    let facet = |[a, b, c]: [usize; 3]| {
        format!(
            "facet normal 0 0 0\nouter loop\nvertex {}\nvertex {}\nvertex {}\nendloop\nendfacet\n",
            x[a], x[b], x[c]
        )
    };
    let facets: String = [[0, 2, 1], [0, 3, 2], [0, 1, 3], [1, 2, 3]].map(facet).concat();
    format!("solid tip\n{facets}endsolid tip\n")
}

#[test]
fn a_surface_and_arrays_of_elements_go_from_upload_to_summary() {
    let server = Server::simulating();
    let client = server.client();
    let [surface, mesh] = [tip().into_bytes(), mesh_with_arrays()].map(|file| {
        let kept = upload(&client, "", &file);
        assert_eq!(kept.status, 201, "{kept:?}");
        kept.json()
    });
    assert_eq!((&surface["format"], &surface["elements"]), (&json!("stl"), &json!(4)));
    assert!(surface.get("quality").is_none(), "triangles of a surface are no elements: {surface}");
    let open = tip().replacen("vertex 0 9 9", "vertex 0 9 8", 1);
    let refused = problem(&upload(&client, "", open.as_bytes()), 422, "invalid-mesh");
    assert!(refused["detail"].as_str().unwrap().contains("is open"), "{refused}");

    let scene = json!({
        "name": "tip", "end_time_s": 2e-4,
        "bodies": [
            {"name": "tip", "role": "projectile", "velocity_m_per_s": [0, 0, -5],
             "rigid": {"shape": {"kind": "stl", "name": surface["id"], "scale": 0.001}, "center_m": [0.011, 0.011, 0.0171], "mass_kg": 0.02}},
            {"name": "tissue", "role": "tissue", "sets": [{"name": "low", "min_m": [-1, -1, -1], "max_m": [1, 1, 1e-6]}], "fixed": [{"set": "low"}],
             "mesh": {"file": {"name": mesh["id"]}},
             "parts": [{"part": "*", "density_kg_per_m3": 1000,
                        "fibre_frame": {"kind": "arrays", "families": ["fibre"]}, "stiffness_factor": {"array": "grade"},
                        "material": {"law": "holzapfel_gasser_ogden", "c_pa": 1e4, "k1_pa": 1e4, "k2": 1,
                                     "fibres": {"angles_deg": [0]}, "bulk_modulus_pa": 2e7}}]}
        ],
        "solver": {"error_bars": "none"}
    });
    let (_, job) = finished(&client, &scene);
    assert_eq!(job["state"], "succeeded", "{job}");
}
