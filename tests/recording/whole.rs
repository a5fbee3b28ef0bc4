//! A recording is whole after every ending.

use super::{read, record, scene};
use contuse::measure::Sink;
use contuse::measure::summary::Shown;
use contuse::plan::compile;
use contuse::record::{McapRecorder, RecordingInfo, partial_path};
use contuse::step::{Ending, FailureCause, Interrupt};
use contuse::study::Phase;
use std::sync::atomic::{AtomicBool, Ordering};

#[test]
fn finished() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("run.mcap");
    let (result, reported) = record(&scene(&[]), &path, 1, &|_| None);
    assert_eq!(result.outcome.ending, Ending::Finished);
    assert!(!partial_path(&path).exists());
    let contents = read(&path);
    assert_eq!((&contents.ending["ending"][..], &contents.ending["complete"][..]), ("finished", "true"));
    assert_eq!(contents.attachments, ["scene.json", "plan_report.json", "summary.json"]);
    for topic in ["/stress/ball", "/mesh/block", "/points/ball"] {
        assert_eq!(contents.topics[topic].len(), 9, "{topic}: 0 to 400 µs every 50");
    }
    assert_eq!(contents.topics["/reference/ball"].len(), 1);
    assert_eq!(contents.topics["/contact/forces"].len(), contents.topics["/energy"].len());
    let last = reported.last().unwrap();
    assert_eq!((last.progress, last.phase), (1.0, Phase::Closing));
    assert!(reported.windows(2).all(|w| w[1].progress >= w[0].progress));

    let Shown::Results(results) = &result.summary.results else { panic!("withheld") };
    let (impact, tissue) = (&results.impacts[0], results.tissue.as_ref().unwrap());
    assert!(impact.peak_force_n.value > 10.0 && impact.peak_force_n.value < impact.peak_step_force_n.value);
    let impulse = impact.impulse_vector_n_s.iter().map(|c| c * c).sum::<f64>().sqrt();
    assert!((impulse - impact.impulse_n_s.value).abs() < 1e-15);
    assert!(tissue.absorbed_energy_j.value > 0.0);
    let depths: Vec<f64> =
        tissue.significant_stress.iter().map(|s| s.depth_mm.as_ref().unwrap().value).collect();
    assert!(depths.windows(2).all(|w| w[0] >= w[1]) && depths[0] <= 15.0, "{depths:?}");
}

#[test]
fn cancelled() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("run.mcap");
    let stop = |requested| (requested == 11).then_some(Interrupt::Cancel);
    let (result, _) = record(&scene(&[]), &path, 1, &stop);
    assert_eq!(result.outcome.ending, Ending::Cancelled);
    assert_eq!(result.summary.ending, Some(Ending::Cancelled));
    let contents = read(&path);
    assert_eq!((&contents.ending["ending"][..], &contents.ending["complete"][..]), ("cancelled", "false"));
    assert!(contents.attachments.contains(&"summary.json".to_owned()));
    assert!(contents.topics["/energy"].len() > 2);
}

#[test]
fn failed_with_a_diagnosis() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("run.mcap");
    let late = |requested| (requested == 20).then_some(Interrupt::Deadline);
    let (result, _) = record(&scene(&[]), &path, 1, &late);
    let Ending::Failed { failure } = &result.outcome.ending else { panic!("{:?}", result.outcome.ending) };
    assert_eq!(failure.cause, FailureCause::Deadline);
    let contents = read(&path);
    assert_eq!((&contents.ending["ending"][..], &contents.ending["complete"][..]), ("failed", "false"));
    assert!(contents.ending["why"].contains(&failure.message));

    // It is said to be a part of the impact, which was looked at to its last step.
    let tissue = result.summary.values().tissue.as_ref().unwrap();
    assert!((tissue.looked_at_until_s - result.outcome.time_s).abs() < 1e-15);
    assert!(tissue.peaks.peak_von_mises_pa.is_some());
    let words = result.summary.plain_words.join("\n");
    assert!(words.starts_with("The run failed") && words.contains("not the whole impact"), "{words}");
}

#[test]
fn a_failed_gate_withholds_the_numbers() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("run.mcap");
    let gate = r#""contact": { "friction": 0.3 }, "integrator": { "kind": "explicit", "energy_gate": 1e-7 }"#;
    let (result, _) = record(&scene(&[(r#""contact": { "friction": 0.3 }"#, gate)]), &path, 1, &|_| None);
    let Ending::Failed { failure } = &result.outcome.ending else { panic!("{:?}", result.outcome.ending) };
    assert_eq!(failure.cause, FailureCause::EnergyGate);
    let json: serde_json::Value = serde_json::from_str(&result.summary.to_json().unwrap()).unwrap();
    assert!(json.get("results").is_none() && json["withheld"]["reason"].is_string());
    assert_eq!(json["withheld"]["values"]["impacts"][0]["peak_force_n"]["gate"], "failed");
    assert!(!json["withheld"]["reason"].as_str().unwrap().ends_with('.'), "sentences end it");
    let gates = json["gates"].as_array().unwrap();
    assert_eq!(gates.len(), 9);
    assert!(gates.iter().any(|gate| gate["result"] == "failed"), "{gates:?}");
    assert_eq!(json["ending"], "failed");
    read(&path);
}

#[test]
fn without_fields_there_are_no_field_topics() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("run.mcap");
    let all = r#"["von_mises", "pressure", "principal_strain", "displacement", "velocity", "element_cauchy_stress"]"#;
    record(&scene(&[(all, "[]")]), &path, 1, &|_| None);
    let contents = read(&path);
    let topics: Vec<_> = contents.topics.keys().map(String::as_str).collect();
    assert_eq!(
        topics,
        ["/contact/forces", "/energy", "/log", "/reference/ball", "/reference/block", "/summary"]
    );
}

#[test]
fn equal_runs_give_equal_files() {
    let folder = tempfile::tempdir().unwrap();
    let bytes = ["a", "b"].map(|name| {
        let path = folder.path().join(name);
        record(&scene(&[]), &path, if name == "a" { 1 } else { 2 }, &|_| None);
        std::fs::read(path).unwrap()
    });
    assert!(bytes[0] == bytes[1], "one thread and two give different files");
}

#[test]
fn a_dropped_recorder_closes_its_file() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("run.mcap");
    let (_, loaded) = scene(&[]);
    let plan = compile(&loaded.scene).unwrap();
    let mut recorder = McapRecorder::new(&path, RecordingInfo::default());
    recorder.start(&plan).unwrap();
    drop(recorder);
    let contents = read(&path);
    assert_eq!((&contents.ending["ending"][..], &contents.ending["complete"][..]), ("interrupted", "false"));
}

#[test]
fn a_recording_that_cannot_be_written_fails_the_run() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("no_such_folder").join("run.mcap");
    let (result, _) = record(&scene(&[]), &path, 1, &|_| None);
    let Ending::Failed { failure } = &result.outcome.ending else { panic!("{:?}", result.outcome.ending) };
    assert_eq!(failure.cause, FailureCause::RecordingFailed);
    assert!(matches!(result.summary.ending, Some(Ending::Failed { .. })));
}

#[test]
fn the_file_has_its_name_only_when_it_is_whole() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("run.mcap");
    let seen_early = AtomicBool::new(false);
    record(&scene(&[]), &path, 1, &|_| {
        seen_early.fetch_or(path.exists() || !partial_path(&path).exists(), Ordering::Relaxed);
        None
    });
    assert!(!seen_early.load(Ordering::Relaxed) && path.exists());
}

#[test]
fn a_run_that_spends_its_budget_leaves_what_it_has() {
    let folder = tempfile::tempdir().unwrap();
    for (name, interrupt) in [
        ("steps.mcap", Interrupt::Steps { most: 20 }),
        ("bytes.mcap", Interrupt::RecordingBytes { most: 1000 }),
    ] {
        let path = folder.path().join(name);
        let (result, _) = record(&scene(&[]), &path, 1, &|requested| (requested > 25).then_some(interrupt));
        let Ending::Failed { failure } = &result.outcome.ending else {
            panic!("{:?}", result.outcome.ending)
        };
        assert_eq!(failure.cause, FailureCause::Budget);
        let contents = read(&path);
        assert_eq!((&contents.ending["ending"][..], &contents.ending["complete"][..]), ("failed", "false"));
        assert!(contents.topics.values().map(Vec::len).sum::<usize>() > 20);
    }
}
