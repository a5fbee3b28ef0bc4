//! The command line, as a user calls it: `validate`, `material` and `schema`, their output and their exit codes.
#![allow(clippy::unwrap_used)] // tests say what they expect by panicking, their own functions too

use serde_json::{Value, json};
use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};

fn contuse(args: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_contuse"));
    command.args(args).env_remove("RUST_LOG");
    command
}

fn run(args: &[&str]) -> Output {
    contuse(args).output().unwrap()
}

/// Runs with `input` on standard input.
fn run_with(args: &[&str], input: &str) -> Output {
    let mut child =
        contuse(args).stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    child.stdin.take().unwrap().write_all(input.as_bytes()).unwrap();
    child.wait_with_output().unwrap()
}

fn text(bytes: &[u8]) -> &str {
    std::str::from_utf8(bytes).unwrap()
}

fn scenario(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("scenarios").join(name)
}

#[test]
fn every_scenario_that_ships_is_valid() {
    let mut count = 0;
    let below = |folder: PathBuf| std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    for folder in below(scenario("")).chain(below(scenario("validation"))).filter(|path| path.is_dir()) {
        for path in below(folder) {
            let name = path.file_name().unwrap().to_str().unwrap();
            if name.starts_with("scene") && path.extension().is_some_and(|e| e == "json") {
                let output = run(&["validate", path.to_str().unwrap()]);
                assert_eq!(output.status.code(), Some(0), "{}: {}", path.display(), text(&output.stdout));
                count += 1;
            }
        }
    }
    assert!(count >= 6);
}

#[test]
fn validate_reports_bodies_quality_and_masses() {
    let path = scenario("ball_on_block/scene.json");
    let output = run(&["validate", "--json", path.to_str().unwrap()]);
    assert_eq!(output.status.code(), Some(0));
    let answer: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(answer["valid"], true);
    assert_eq!(answer["estimate"]["elements"], 2336);
    assert_eq!(answer["bodies"][0]["name"], "ball");
    // ½ m v² of the faceted ball.
    let mass = answer["bodies"][0]["mass_kg"].as_f64().unwrap();
    assert!((0.5 * mass * 100.0 * 100.0 - 33.917).abs() < 5e-4, "{mass}");
    assert!((answer["bodies"][1]["mass_kg"].as_f64().unwrap() - 0.53).abs() < 1e-9);
    assert!(answer["bodies"][0]["quality"]["min_scaled_jacobian"].as_f64().unwrap() > 0.5);
}

#[test]
fn an_invalid_scene_is_exit_code_2_with_all_its_problems() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("scene.json");
    let scene = std::fs::read_to_string(scenario("two_bars/scene.json")).unwrap();
    let mut scene: Value = serde_json::from_str(&scene).unwrap();
    scene["end_time_s"] = json!(-1);
    scene["bodies"][0]["parts"][0]["material"]["lambda_pa"] = json!(-1e12);
    scene["bodies"][1]["mesh"] = json!({"file": {"name": "../secret.msh"}});
    scene["colour"] = json!("red");
    std::fs::write(&path, scene.to_string()).unwrap();

    let output = run(&["validate", "--json", path.to_str().unwrap()]);
    assert_eq!(output.status.code(), Some(2));
    let answer: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(answer["valid"], false);
    let pointers: Vec<&str> =
        answer["problems"].as_array().unwrap().iter().map(|p| p["pointer"].as_str().unwrap()).collect();
    for pointer in
        ["/colour", "/end_time_s", "/bodies/0/parts/0/material/lambda_pa", "/bodies/1/mesh/file/name"]
    {
        assert!(pointers.contains(&pointer), "{pointer} is not in {pointers:?}");
    }

    let output = run(&["validate", path.to_str().unwrap()]);
    assert_eq!(output.status.code(), Some(2));
    assert!(text(&output.stdout).contains("4 error(s)"), "{}", text(&output.stdout));
    assert!(text(&output.stdout).contains("remedy:"));
    assert_eq!(run(&["validate", "no/such/scene.json"]).status.code(), Some(2));
    assert_eq!(run(&["validate"]).status.code(), Some(2), "missing arguments are invalid input too");
}

fn rubber() -> Value {
    json!({"law": "mooney_rivlin", "c10_pa": 5e5, "c01_pa": 1e5, "bulk_modulus_pa": 5.96e7})
}

#[test]
fn material_answers_energy_and_stresses_at_f() {
    // Cauchy stress and energy of another finite element code for the same law and deformation.
    let question =
        json!({"material": rubber(), "F": [[1.12, 0.2, -0.05], [0.1, 0.95, 0.15], [0.05, -0.1, 1.03]]});
    let output = run_with(&["material", "-"], &question.to_string());
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    let answer: Value = serde_json::from_slice(&output.stdout).unwrap();
    let close = |value: &Value, expected: f64| (value.as_f64().unwrap() / expected - 1.0).abs() < 1e-9;
    assert!(close(&answer["J"], 1.096_495));
    assert!(close(&answer["psi_j_per_m3"], 318_155.906_739));
    let cauchy = &answer["cauchy_pa"];
    for (i, j, expected) in [
        (0, 0, 5_202_371.889_16),
        (1, 1, 4_828_681.403_86),
        (2, 2, 4_990_290.833_19),
        (0, 1, 303_741.317_649),
        (1, 2, 69_550.551_975_5),
        (0, 2, -18_696.102_621_5),
    ] {
        assert!(close(&cauchy[i][j], expected) && close(&cauchy[j][i], expected), "{i}{j}: {}", cauchy[i][j]);
    }
    assert_eq!(answer["P_pa"].as_array().unwrap().len(), 3);

    let list = json!([question, question]);
    let output = run_with(&["material", "-"], &list.to_string());
    let answers: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(answers, json!([answer, answer]), "a list is answered by a list");
}

#[test]
fn material_follows_paths_as_json_csv_and_svg() {
    let mut law = rubber();
    law["bulk_modulus_pa"] = json!(1e12);
    let question = json!({"material": law}).to_string();
    let path = ["material", "-", "--path", "uniaxial", "--from", "0.5", "--to", "2", "--points", "4"];
    let rows: Value = serde_json::from_slice(&run_with(&path, &question).stdout).unwrap();
    for (row, stretch) in rows.as_array().unwrap().iter().zip([0.5_f64, 1.0, 1.5, 2.0]) {
        // σ = 2 (λ² − 1/λ)(C10 + C01/λ) of the incompressible solid
        let expected = 2.0 * (stretch * stretch - 1.0 / stretch) * (5e5 + 1e5 / stretch);
        let got = row["cauchy_pa"][0][0].as_f64().unwrap();
        assert!(
            (got - expected).abs() <= 1e-4 * expected.abs() + 1.0,
            "λ = {stretch}: {got} against {expected}"
        );
    }
    assert_eq!(rows[1]["range"], "usual", "no source gives the range of these parameters");

    law["valid_to"] = json!({"stretch": [0.7, 1.6], "limit_stretch": [0.4, 1.8]});
    let limited = run_with(&path, &json!({"material": law}).to_string());
    let rows: Value = serde_json::from_slice(&limited.stdout).unwrap();
    let ranges: Vec<&Value> = rows.as_array().unwrap().iter().map(|row| &row["range"]).collect();
    assert_eq!(ranges, ["extrapolated", "fitted", "fitted", "beyond_limit"]);
    let reported = "2 of 4 points are beyond the range that the law is fitted to, or that is usual for it, 1 of them beyond its limit";
    assert!(text(&limited.stderr).contains(reported), "{}", text(&limited.stderr));

    let csv = run_with(&[&path[..], &["--format", "csv"]].concat(), &question);
    let lines: Vec<&str> = text(&csv.stdout).lines().collect();
    assert_eq!(lines.len(), 5);
    let columns = lines[0].split(',').count();
    assert!(lines[0].starts_with("item,stretch,J,psi_j_per_m3,P_xx_pa"));
    assert!(lines.iter().all(|line| line.split(',').count() == columns));

    let svg = run_with(&[&path[..], &["--format", "svg"]].concat(), &question);
    let picture = text(&svg.stdout);
    assert!(picture.starts_with("<svg") && picture.trim_end().ends_with("</svg>"));
    assert!(picture.contains("stress [MPa]") && picture.matches("<polyline").count() >= 2);
}

#[test]
fn wrong_questions_about_a_material_are_exit_code_2_and_say_why() {
    let rest = json!([[1, 0, 0], [0, 1, 0], [0, 0, 1]]);
    let mut unstable = rubber();
    unstable["c10_pa"] = json!(-1e6);
    for (input, words) in [
        (json!({"material": {"law": "money_rivlin"}, "F": rest}).to_string(), "mooney_rivlin"),
        (json!({"material": unstable, "F": rest}).to_string(), "unstable"),
        (json!({"material": rubber()}).to_string(), "/F"),
        (json!({"material": rubber(), "F": [[1, 0], [0, 1]]}).to_string(), "/F"),
        (json!({"material": rubber(), "F": [[-1, 0, 0], [0, 1, 0], [0, 0, 1]]}).to_string(), "inverted"),
        ("{".into(), "not JSON"),
    ] {
        let output = run_with(&["material", "-"], &input);
        let said = text(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{input}: {said}");
        assert!(said.contains(words), "{input}: {said}");
        assert!(output.stdout.is_empty());
    }
    assert_eq!(run(&["material", "no/such/file.json"]).status.code(), Some(2));
    let svg = run_with(
        &["material", "-", "--format", "svg"],
        &json!({"material": rubber(), "F": rest}).to_string(),
    );
    assert_eq!(svg.status.code(), Some(2), "a point is no picture");
}

#[test]
fn schema_prints_the_committed_schema() {
    let output = run(&["schema"]);
    let committed =
        std::fs::read(Path::new(env!("CARGO_MANIFEST_DIR")).join("api/scene.schema.json")).unwrap();
    assert!(output.stdout == committed);
}

#[test]
fn a_reader_that_leaves_early_is_no_failure() {
    let mut child = contuse(&["schema"]).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    drop(child.stdout.take());
    let output = child.wait_with_output().unwrap();
    assert_eq!((output.status.code(), text(&output.stderr)), (Some(0), ""));
}

#[test]
fn a_run_overwrites_recordings_and_nothing_else() {
    let folder = tempfile::tempdir().unwrap();
    let scene = folder.path().join("scene.json");
    let document = json!({
        "name": "drop", "end_time_s": 1e-5,
        "bodies": [{
            "name": "block",
            "mesh": {"generator": {"kind": "block", "min_m": [0, 0, 0], "max_m": [0.1, 0.1, 0.1], "elements": [1, 1, 1]}},
            "parts": [{"part": "block", "density_kg_per_m3": 1000,
                "material": {"law": "neo_hookean", "c10_pa": 1e5, "bulk_modulus_pa": 1e7}}]
        }]
    });
    std::fs::write(&scene, serde_json::to_vec(&document).unwrap()).unwrap();
    let scene = scene.to_str().unwrap();
    let recording = folder.path().join("out.mcap");
    // Twice: the second replaces a recording.
    for _ in 0..2 {
        let done = run(&["run", scene, "-q", "-o", recording.to_str().unwrap()]);
        assert!(done.status.success(), "{}", text(&done.stderr));
    }
    let refused = run(&["run", scene, "-q", "-o", scene]);
    assert_eq!(refused.status.code(), Some(2));
    assert!(text(&refused.stderr).contains("not a recording"), "{}", text(&refused.stderr));
    assert_eq!(std::fs::read(scene).unwrap(), serde_json::to_vec(&document).unwrap());
}

#[test]
fn plan_shows_what_is_kept_and_omitted() {
    let path = scenario("ball_on_block/scene_frictionless.json");
    let path = path.to_str().unwrap();
    let output = run(&["plan", path]);
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    let shown = text(&output.stdout);
    for words in
        ["2336 elements", "Mooney–Rivlin", "[--keep tangential_reactions]", "within 2 times", "Memory,"]
    {
        assert!(shown.contains(words), "{words} in {shown}");
    }
    assert!(!shown.contains("Restored"));

    let keep = ["--keep", "tangential_reactions", "--keep", "inactive_elements"];
    let shown = run(&[&["plan", path][..], &keep].concat());
    assert!(text(&shown.stdout).contains("Restored: tangential_reactions, inactive_elements"));
    let output = run(&[&["plan", path, "--json"][..], &keep].concat());
    let report: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(report["restored"], json!(["tangential_reactions", "inactive_elements"]));
    assert_eq!(report["pairs"][0]["unknowns_per_contact"], 3);
    let validated = run(&[&["validate", path, "--json"][..], &keep].concat());
    let validated: Value = serde_json::from_slice(&validated.stdout).unwrap();
    assert_eq!(validated["plan"], report, "validate and plan say the same");
}

#[test]
fn unknown_things_to_keep_are_answered_with_those_that_there_are() {
    let path = scenario("two_bars/scene.json");
    for command in [&["plan"][..], &["validate"], &["run"], &["study", "omissions"]] {
        let output = run(&[command, &[path.to_str().unwrap(), "--keep", "history"]].concat());
        assert_eq!(output.status.code(), Some(2));
        for name in contuse::scene::document::Keep::ALL.map(contuse::scene::document::Keep::name) {
            assert!(text(&output.stderr).contains(name), "{}", text(&output.stderr));
        }
    }
    assert_eq!(run(&["plan", "no/such/scene.json"]).status.code(), Some(2));
}

/// A block that falls on the floor for a few steps.
fn falling_block() -> Value {
    json!({
        "name": "drop", "end_time_s": 1e-4,
        "bodies": [{
            "name": "block",
            "mesh": {"generator": {"kind": "block", "min_m": [0, 0, 0], "max_m": [0.02, 0.02, 0.02], "elements": [2, 2, 2]}},
            "velocity_m_per_s": [1, 0, -5],
            "parts": [{"part": "block", "density_kg_per_m3": 1000,
                "material": {"law": "neo_hookean", "c10_pa": 1e5, "bulk_modulus_pa": 1e7}}]
        }],
        "planes": [{"name": "floor", "point_m": [0, 0, 0], "normal": [0, 0, 1]}],
        "record": {"fields": ["von_mises"]}
    })
}

#[test]
fn a_tissue_that_nothing_can_touch_is_reported_in_the_summary() {
    let folder = tempfile::tempdir().unwrap();
    let scene = folder.path().join("scene.json");
    let mut document = falling_block();
    document["bodies"][0]["role"] = json!("tissue");
    document["planes"][0]["point_m"] = json!([0, 0, -1]);
    std::fs::write(&scene, document.to_string()).unwrap();
    let warnings = |keep: &[&str]| {
        let recording = folder.path().join("out.mcap");
        let run_it = ["run", scene.to_str().unwrap(), "--json", "-o", recording.to_str().unwrap()];
        let output = run(&[&run_it[..], keep].concat());
        assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
        let summary: Value = serde_json::from_slice(&output.stdout).unwrap();
        summary["warnings"].to_string()
    };
    let said = warnings(&[]);
    assert!(said.contains("Nothing can touch in block–floor (they stay at least"), "{said}");
    let said = warnings(&["--keep", "distant_pairs"]);
    assert!(said.contains("Nothing touched in block–floor"), "{said}");
}

#[test]
fn study_omissions_tabulates_runs_that_agree() {
    let folder = tempfile::tempdir().unwrap();
    let scene = folder.path().join("scene.json");
    std::fs::write(&scene, falling_block().to_string()).unwrap();
    let scene = scene.to_str().unwrap();
    let output =
        run(&["study", "omissions", scene, "--repeat", "1", "--json", "--keep", "inactive_elements"]);
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    let study: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(study["holds"], true);
    let restored: Vec<&Value> =
        study["rows"].as_array().unwrap().iter().map(|row| &row["restored"]).collect();
    let all = ["mirror_images", "idle_self_contact", "tangential_reactions", "unrequested_fields"];
    let expected = [vec![json!([])], all.iter().map(|one| json!([one])).collect(), vec![json!(all)]].concat();
    assert_eq!(restored, expected.iter().collect::<Vec<_>>());
    for row in study["rows"].as_array().unwrap() {
        // To the last bit, and up to the asymmetry of a scene that is computed in whole.
        if row["theory"] == "bitwise" {
            assert_eq!(row["difference"], json!({"kind": "bitwise"}));
        }
        assert!(row["wall_s"].as_f64().unwrap() > 0.0 && row["recording_bytes"].as_u64().unwrap() > 0);
    }

    let output = run(&["study", "omissions", scene, "--repeat", "1"]);
    let table = text(&output.stdout);
    assert!(table.contains("+ inactive_elements") && table.contains("+ all of them"), "{table}");
    assert!(table.contains("every run is as theory says"), "{table}");
}

#[test]
fn study_of_a_scene_that_fails_is_exit_code_3() {
    let folder = tempfile::tempdir().unwrap();
    let scene = folder.path().join("scene.json");
    let mut document = falling_block();
    document["bodies"][0]["velocity_m_per_s"] = json!([0, 0, -2000]);
    std::fs::write(&scene, document.to_string()).unwrap();
    let output = run(&["study", "omissions", scene.to_str().unwrap(), "--repeat", "1"]);
    assert_eq!(output.status.code(), Some(3), "{}", text(&output.stdout));
    assert!(text(&output.stdout).contains("NOT as theory says"), "{}", text(&output.stdout));
}

#[test]
fn a_recording_is_reported_and_exported() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    let scene = path("scene.json");
    let mut block = falling_block();
    block["bodies"][0]["role"] = json!("tissue");
    std::fs::write(&scene, block.to_string()).unwrap();
    assert_eq!(run(&["run", &scene, "-o", &path("run.mcap"), "--quiet"]).status.code(), Some(0));

    let from_recording = run(&["report", &path("run.mcap"), "-o", &path("a.html")]);
    assert_eq!(from_recording.status.code(), Some(0), "{}", text(&from_recording.stderr));
    let page = std::fs::read_to_string(path("a.html")).unwrap();
    assert!(page.contains("<svg") && page.contains("Peak force") && page.contains("For research use only"));
    // It stands by itself: no file or address besides.
    assert!(!page.contains("src=") && !page.contains("href=") && !page.contains("url("));
    assert_eq!(run(&["report", &scene, "-o", &path("b.html")]).status.code(), Some(0));
    assert_eq!(page, std::fs::read_to_string(path("b.html")).unwrap(), "the scene gives the same page");

    let exported =
        run(&["export", &path("run.mcap"), "--fhir", &path("bundle.json"), "--csv", &path("lines.csv")]);
    assert_eq!(exported.status.code(), Some(0), "{}", text(&exported.stderr));
    let bundle: Value = serde_json::from_slice(&std::fs::read(path("bundle.json")).unwrap()).unwrap();
    assert_eq!((&bundle["resourceType"], &bundle["type"]), (&json!("Bundle"), &json!("collection")));
    let table = std::fs::read_to_string(path("lines.csv")).unwrap();
    let lines = || table.lines().filter(|line| !line.starts_with('#'));
    assert!(table.starts_with("# For research use only"), "{table}");
    let columns = lines().next().unwrap().matches("\",\"").count();
    assert!(lines().count() > 5 && columns >= 3, "{table}");

    assert_eq!(run(&["export", &path("run.mcap")]).status.code(), Some(2), "one format at least");
    assert_eq!(run(&["report", &path("missing.mcap")]).status.code(), Some(2));
    std::fs::write(path("no.mcap"), "no recording").unwrap();
    assert_eq!(run(&["report", &path("no.mcap"), "-o", &path("c.html")]).status.code(), Some(2));
}

#[test]
fn what_if_answers_case_by_case() {
    let folder = tempfile::tempdir().unwrap();
    let scene = folder.path().join("scene.json");
    let mut block = falling_block();
    block["bodies"][0]["role"] = json!("projectile");
    std::fs::write(&scene, block.to_string()).unwrap();
    let scene = scene.to_str().unwrap();
    let csv = folder.path().join("cases.csv");
    let flags =
        ["--vary", "speed=1..3", "--case", "speed=2.5", "--one-at-a-time", "--csv", csv.to_str().unwrap()];
    let output = run(&[&["what-if", scene, "--json"][..], &flags[..]].concat());
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    let lines: Vec<Value> =
        text(&output.stdout).lines().map(|line| serde_json::from_str(line).unwrap()).collect();
    let events: Vec<&str> = lines.iter().map(|line| line["event"].as_str().unwrap()).collect();
    assert_eq!(events, ["case", "error_bars", "case", "case", "case", "answer"]);
    assert_eq!(std::fs::read_to_string(&csv).unwrap().lines().count(), 5);
    let table = run(&[&["what-if", scene][..], &flags[..]].concat());
    assert!(text(&table.stdout).contains("One at a time"), "{}", text(&table.stdout));
    assert!(text(&table.stdout).contains("numerical errors not yet known"), "{}", text(&table.stdout));
    // A case in which nothing touches is a good answer without numbers.
    let miss = run(&["what-if", scene, "--case", "/planes/0/point_m/2=-1", "--error-bars", "none"]);
    assert_eq!(miss.status.code(), Some(0), "{}", text(&miss.stderr));
    let said = text(&miss.stdout);
    assert!(said.contains("nothing touched: there was no impact") && !said.contains("(0)"), "{said}");
    let refused = run(&["what-if", scene, "--vary", "speed=3..1", "--one-at-a-time"]);
    assert_eq!(refused.status.code(), Some(2));
    assert!(text(&refused.stderr).contains("/parameters/0/high"), "{}", text(&refused.stderr));
    // What is said twice is refused, and what was stopped says so at both ends and on standard error.
    let refused = run(&["what-if", scene, "--vary", "speed=1..3", "--vary", "speed=2..4", "--sample", "2"]);
    assert_eq!(refused.status.code(), Some(2));
    assert!(text(&refused.stderr).contains("given twice"), "{}", text(&refused.stderr));
    assert_eq!(run(&["what-if", scene, "--case", "speed=1,speed=2"]).status.code(), Some(2));
    let stopped = run(&[&["what-if", scene, "--deadline-s", "0"][..], &flags[..]].concat());
    assert_eq!(stopped.status.code(), Some(4));
    let said = "STOPPED (deadline): 0 of 4 case(s)";
    assert_eq!(text(&stopped.stdout).matches(said).count(), 2, "{}", text(&stopped.stdout));
    assert!(text(&stopped.stderr).contains(said), "{}", text(&stopped.stderr));
}
