//! `POST /v1/studies`

use crate::support::*;
use serde_json::{Value, json};

fn scene() -> Value {
    json!({
        "name": "bar", "end_time_s": 1.2,
        "bodies": [{
            "name": "bar", "velocity_m_per_s": [0, 0, -0.01],
            "mesh": {"generator": {"kind": "block", "min_m": [0, 0, 0.005], "max_m": [1, 1, 10.005], "elements": [1, 1, 10]}},
            "parts": [{"part": "block", "density_kg_per_m3": 1,
                       "material": {"law": "coupled_neo_hookean", "mu_pa": 450, "lambda_pa": 0}}]
        }],
        "planes": [{"name": "wall", "point_m": [0, 0, 0], "normal": [0, 0, 1]}],
        "record": {"fields": [], "field_times_s": []}
    })
}

#[test]
fn a_study_is_a_job_whose_summary_is_its_answer() {
    let server = Server::simulating();
    let client = server.client();
    let body = json!({"kind": "error", "scene": scene(), "exact": {"impulse_n_s": 0.2}});
    let answer = client.post_json("/v1/studies", &body);
    assert_eq!(answer.status, 202);
    let job = answer.json();
    assert_eq!(job["name"], "error of bar");
    let address = job["links"]["self"].as_str().unwrap().to_owned();
    wait_for(&client, &address, "succeeded");
    let study = client.get(&format!("{address}/summary")).json();
    assert_eq!(study["references"]["impulse_n_s"], json!({"kind": "exact", "value": 0.2}));
    assert!(study["rows"].as_array().unwrap().iter().any(|row| row["ending"] == "finished"));
    assert_eq!(client.get(&format!("{address}/recording")).status, 404);
}

#[test]
fn every_problem_of_a_study_has_its_place() {
    let server = Server::simulating();
    let mut wrong = scene();
    wrong["end_time_s"] = json!(-1);
    let body = json!({"kind": "error", "scene": wrong, "finest": 9, "exact": {"weight": 1}});
    let answer = problem(&server.client().post_json("/v1/studies", &body), 422, "invalid-scene");
    let places: Vec<&str> =
        answer["errors"].as_array().unwrap().iter().map(|e| e["pointer"].as_str().unwrap()).collect();
    for place in ["/finest", "/exact/weight", "/scene/end_time_s"] {
        assert!(places.contains(&place), "{place} is not in {places:?}");
    }
    for body in [json!({}), json!({"kind": "horoscope"}), json!({"kind": "error"}), scene()] {
        assert_eq!(server.client().post_json("/v1/studies", &body).status, 422, "{body}");
    }
    for (body, place) in [
        (json!({"kind": "horoscope"}), "/kind"),
        (json!({"kind": "error", "scene": scene(), "finest": "very"}), "/finest"),
        (json!({"kind": "error", "scene": scene(), "implicit_steps_s": [1e-3, "x"]}), "/implicit_steps_s/1"),
        (
            json!({"kind": "error", "scene": scene(), "contact_solvers": ["nsgs", "lemke"]}),
            "/contact_solvers/1",
        ),
        (json!({"kind": "error", "scene": scene(), "geometry": "round"}), "/geometry"),
        (json!({"kind": "stability", "implicit": [-1]}), "/implicit/0"),
        (json!({"kind": "stability", "shorter": true}), "/shorter"),
    ] {
        let answer = problem(&server.client().post_json("/v1/studies", &body), 422, "invalid-scene");
        assert_eq!(answer["errors"][0]["pointer"], place, "{answer}");
    }
    // A study is no scene.
    let study = json!({"kind": "stability"});
    assert_eq!(server.client().post_json("/v1/jobs", &study).status, 422);
}

#[test]
fn every_entry_of_a_list_of_steps_is_validated() {
    let server = Server::simulating();
    let places = |body: &Value| -> Vec<String> {
        let answer = problem(&server.client().post_json("/v1/studies", body), 422, "invalid-scene");
        assert!(answer["detail"].as_str().unwrap().starts_with("The study has "), "{answer}");
        let errors = answer["errors"].as_array().unwrap();
        assert!(errors.iter().all(|e| e["limit"] != "" && e["remedy"] != ""), "{answer}");
        errors.iter().map(|e| e["pointer"].as_str().unwrap().to_owned()).collect()
    };
    let ratios = json!([0, 10, 4_294_967_295_u32, 10, 100_000]);
    let matrix = json!({"kind": "stability", "implicit": ratios});
    assert_eq!(places(&matrix), ["/implicit/0", "/implicit/2", "/implicit/3"]);
    let many: Vec<u32> = (1..=17).collect();
    assert_eq!(places(&json!({"kind": "stability", "implicit": many})), ["/implicit"]);

    let steps_s = json!([1e-3, 0, 1e-13, 1.2, 1.3, -1, 1e-3]);
    let study = json!({"kind": "error", "scene": scene(), "implicit_steps_s": steps_s});
    assert_eq!(places(&study), [1, 2, 4, 5, 6].map(|i| format!("/implicit_steps_s/{i}")));
    let answer = server.client().post_json("/v1/studies", &study).json();
    assert_eq!(answer["errors"][2]["limit"], "from 1e-12 to 1.2, the end of the scene");
    assert_eq!(answer["errors"][2]["value"], 1.3);
}
