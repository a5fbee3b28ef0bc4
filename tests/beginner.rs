//! The mistakes of a beginner on the command line: each is reported before anything is computed, with a remedy.
#![allow(clippy::unwrap_used)] // tests say what they expect by panicking, their own functions too

use serde_json::{Value, json};
use std::process::{Command, Output};

fn run(args: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_contuse")).args(args).env_remove("RUST_LOG").output().unwrap()
}

fn text(bytes: &[u8]) -> &str {
    std::str::from_utf8(bytes).unwrap()
}

/// A block that is thrown at the floor.
fn falling_block() -> Value {
    json!({
        "name": "drop", "end_time_s": 1e-4,
        "bodies": [{
            "name": "block", "role": "tissue",
            "mesh": {"generator": {"kind": "block", "min_m": [0, 0, 0], "max_m": [0.02, 0.02, 0.02], "elements": [2, 2, 2]}},
            "velocity_m_per_s": [1, 0, -5],
            "parts": [{"part": "block", "density_kg_per_m3": 1000,
                "material": {"law": "neo_hookean", "c10_pa": 1e5, "bulk_modulus_pa": 1e7}}]
        }],
        "planes": [{"name": "floor", "point_m": [0, 0, 0], "normal": [0, 0, 1]}]
    })
}

/// A folder with the scene in it, and paths there.
struct Desk(tempfile::TempDir);

impl Desk {
    fn with(scene: &Value) -> Self {
        let desk = Self(tempfile::tempdir().unwrap());
        std::fs::write(desk.path("scene.json"), scene.to_string()).unwrap();
        desk
    }
    fn path(&self, name: &str) -> String {
        self.0.path().join(name).to_str().unwrap().to_owned()
    }
}

/// What a command says of an input that it refuses.
fn refusal(args: &[&str]) -> String {
    let output = run(args);
    assert_eq!(output.status.code(), Some(2), "{args:?}: {}", text(&output.stderr));
    assert!(output.stdout.is_empty(), "{args:?}: {}", text(&output.stdout));
    text(&output.stderr).to_owned()
}

#[test]
fn outputs_are_checked_before_the_run() {
    let desk = Desk::with(&falling_block());
    let (scene, nowhere) = (desk.path("scene.json"), desk.path("nodir/a.out"));
    for (args, flag) in [
        (vec!["run", &scene, "-o", &nowhere], "--output"),
        (vec!["what-if", &scene, "--vary", "speed=1..2", "--one-at-a-time", "--csv", &nowhere], "--csv"),
        (vec!["report", &scene, "-o", &nowhere], "--output"),
        (vec!["export", &scene, "--fhir", &nowhere], "--fhir"),
    ] {
        let said = refusal(&args);
        assert!(
            said.contains(flag) && said.contains("a.out") && said.contains("there is no folder"),
            "{said}"
        );
    }
    // A folder in which not even root may make a file.
    #[cfg(target_os = "linux")]
    assert!(refusal(&["run", &scene, "-o", "/proc/a.mcap"]).contains("folder that you may write to"));
}

#[test]
fn fields_and_surfaces_are_files_of_the_names_given() {
    let desk = Desk::with(&falling_block());
    let path = |name: &str| desk.path(name);
    let done = |args: &[&str]| {
        let output = run(args);
        assert_eq!(output.status.code(), Some(0), "{args:?}: {}", text(&output.stderr));
        text(&output.stdout).to_owned()
    };
    let (scene, recording) = (path("scene.json"), path("a.mcap"));
    done(&["run", &scene, "-q", "-o", &recording, "-o", &path("a.pvd")]);
    let surfaces = ["--stl", &path("b.stl"), "--ply", &path("b.ply"), "--at-ms", "0"];
    let said = done(&[&["export", &recording, "--vtu", &path("b.pvd")][..], &surfaces].concat());
    assert!(said.contains("b.stl: at 0 ms"), "{said}");
    let [of_run, exported] = ["a.pvd", "b.pvd"].map(|name| std::fs::read_to_string(path(name)).unwrap());
    assert_eq!(of_run.replace("a_vtu", "b_vtu"), exported);
    let stl =
        |flags: [&str; 2]| [&["export", &recording, "--stl", &path("x.stl")][..], &flags].concat().join(" ");
    for (args, words) in [
        (format!("run {scene} -o {}", path("a.vtu")), "use .mcap for a recording or .pvd"),
        (format!("export {recording} --vtu {}", path("a.xml")), "does not end in .pvd"),
        (stl(["--at-ms", "-1"]), "they are from 0 to"),
        (stl(["--body", "x"]), "there is no such body"),
    ] {
        let said = refusal(&args.split(' ').collect::<Vec<_>>());
        assert!(said.contains(words), "{words} in {said}");
    }
}

#[test]
fn outputs_replace_only_what_was_written_before() {
    let desk = Desk::with(&falling_block());
    let (scene, recording) = (desk.path("scene.json"), desk.path("a.mcap"));
    let [csv, fhir, page, bin] = ["a.csv", "a.json", "a.html", "z.bin"].map(|name| desk.path(name));
    for args in [
        vec!["run", &scene, "-q", "-o", &recording],
        vec!["export", &recording, "--fhir", &fhir, "--csv", &csv],
        vec!["export", &recording, "--fhir", &fhir, "--csv", &csv],
        vec!["report", &recording, "-o", &page],
        vec!["report", &recording, "-o", &page],
    ] {
        assert_eq!(run(&args).status.code(), Some(0), "{args:?}");
    }
    let before = std::fs::read(&recording).unwrap();
    for args in [
        vec!["export", &recording, "--stl", &recording],
        vec!["export", &recording, "--fhir", &scene],
        vec!["export", &recording, "--ply", &page],
        vec!["export", &recording, "--stl", &bin, "--ply", &bin],
        vec!["report", &recording, "-o", &recording],
        vec!["report", &scene, "-o", &scene],
    ] {
        let said = refusal(&args);
        assert!(said.contains("would be overwritten"), "{said}");
    }
    assert!(std::fs::read(&recording).unwrap() == before && !std::path::Path::new(&bin).exists());
}

#[test]
fn a_case_is_checked_as_a_range_is() {
    let mut scene = falling_block();
    scene["bodies"][0]["role"] = json!("projectile");
    let desk = Desk::with(&scene);
    let scene = desk.path("scene.json");
    let said = refusal(&["what-if", &scene, "--case", "speed=-100"]);
    assert!(said.contains("a speed cannot be -100") && said.contains("/cases/0/set/speed"), "{said}");
    let said = refusal(&["what-if", &scene, "--limit", "speed:peak_force_n<=2000"]);
    assert!(said.contains("--vary speed=80..120"), "{said}");
    let said = refusal(&["what-if", &scene, "--case", "friction=-1"]);
    assert_eq!(said.matches("in the case").count(), 1, "reported once: {said}");
    let said = refusal(&["what-if", &scene, "--case", "speed=1", "--deadline-s", "-1"]);
    assert!(said.contains("give seconds from now on"), "{said}");
}

#[test]
fn other_words_are_understood() {
    let mut scene = falling_block();
    scene["measures"] = json!({"person": {"region": "chest"}});
    scene["bodies"][0]["mesh"] = json!({"file": {"path": "thigh.msh"}});
    let desk = Desk::with(&scene);
    let output = run(&["validate", &desk.path("scene.json")]);
    let said = text(&output.stdout);
    assert!(said.contains("did you mean \"thorax\"?") && said.contains("did you mean \"name\"?"), "{said}");
}

#[test]
fn what_validation_warns_of_is_in_the_summary() {
    let mut scene = falling_block();
    scene["measures"] = json!({"stress_thresholds_pa": [10, 30]});
    scene["bodies"][0]["parts"][0]["material"]["bulk_modulus_pa"] = json!(5e4);
    let desk = Desk::with(&scene);
    let scene = desk.path("scene.json");
    let output = run(&["run", &scene, "--json", "-o", &desk.path("out.mcap")]);
    let summary: Value = serde_json::from_slice(&output.stdout).unwrap();
    let warnings = summary["warnings"].to_string();
    for words in ["/measures/stress_thresholds_pa/0", "10 kPa is 1e4", "bulk modulus in Pa"] {
        assert!(warnings.contains(words), "{words} in {warnings}");
    }
    // A summary is no scene.
    std::fs::write(desk.path("summary.json"), &output.stdout).unwrap();
    let said = refusal(&["report", &desk.path("summary.json"), "-o", &desk.path("a.html")]);
    assert!(said.contains("is the summary of a run"), "{said}");
    let said = refusal(&["report", &desk.path("nothing.mcap"), "-o", &desk.path("a.html")]);
    assert!(said.contains("No such file"), "{said}");
}

#[test]
fn a_run_of_hours_is_warned_of() {
    let mut scene = falling_block();
    scene["end_time_s"] = json!(100);
    scene["integrator"] = json!({"kind": "explicit"});
    let desk = Desk::with(&scene);
    let output = run(&["validate", &desk.path("scene.json")]);
    let said = text(&output.stdout);
    assert!(said.contains("many_steps") && said.contains("million steps"), "{said}");
}

#[test]
fn nothing_is_said_of_what_was_not_looked_at() {
    let desk = Desk::with(&falling_block());
    let out = desk.path("out.mcap");
    let output = run(&["run", &desk.path("scene.json"), "--json", "--deadline-s", "0", "-o", &out]);
    assert_eq!(output.status.code(), Some(3), "{}", text(&output.stderr));
    let summary: Value = serde_json::from_slice(&output.stdout).unwrap();
    let tissue = &summary["results"]["tissue"];
    assert_eq!(tissue["looked_at_until_s"], 0.0);
    assert!(tissue.get("peak_von_mises_pa").is_none(), "{tissue}");
    assert_eq!(tissue["significant_stress"], json!([]));
    let words = summary["plain_words"].to_string();
    assert!(words.contains("The run failed") && words.contains("not evaluated after 0 s"), "{words}");
    assert!(!words.contains("No tissue saw"), "{words}");
    let remedy = |output: &Output| {
        let summary: Value = serde_json::from_slice(&output.stdout).unwrap();
        summary["failure"]["remedy"].as_str().unwrap().to_owned()
    };
    assert!(remedy(&output).contains("--no-error-bars"), "{}", remedy(&output));
    let without =
        ["run", &desk.path("scene.json"), "--json", "--deadline-s", "0", "-o", &out, "--no-error-bars"];
    let remedy = remedy(&run(&without));
    assert!(remedy.contains("more wall-clock time") && !remedy.contains("error"), "{remedy}");
}

#[test]
fn withheld_results_are_no_success() {
    let mut scene = falling_block();
    scene["bodies"][0]["parts"][0]["material"]["valid_to"] =
        json!({"stretch": [0.999, 1.001], "limit_stretch": [0.999, 1.001]});
    let desk = Desk::with(&scene);
    let scene = desk.path("scene.json");
    let output = run(&["run", &scene, "--json", "-o", &desk.path("out.mcap")]);
    assert_eq!(output.status.code(), Some(5), "{}", text(&output.stderr));
    assert!(text(&output.stderr).contains("the results are withheld: "), "{}", text(&output.stderr));
    let summary: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert!(summary["ending"] == "finished" && summary.get("withheld").is_some(), "{summary:#}");
    let slower = "/bodies/0/velocity_m_per_s/2=-4";
    let output = run(&["what-if", &scene, "--case", slower, "--error-bars", "none"]);
    assert_eq!(output.status.code(), Some(5), "{}", text(&output.stderr));
}
