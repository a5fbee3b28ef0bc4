//! Series of VTK files: from a run and from its recording the same, and surfaces of it.

use super::{NOT_INTERRUPTED, record, scene, small_plan};
use contuse::measure::{MeasuredFrame, Measures, MeasuringRecorder, Sink};
use contuse::record::vtk::Folder;
use contuse::record::{VtuRecorder, on_own_thread};
use contuse::report::fields::{field_times, write_series};
use contuse::report::surface::surfaces_at;
use contuse::step::{Ending, FailureCause, RecorderError, run};
use std::collections::BTreeMap;
use std::fs::File;
use std::path::{Path, PathBuf};

/// The files of a series, the list among them.
fn files(pvd: &Path) -> BTreeMap<PathBuf, Vec<u8>> {
    let folder = std::fs::read_dir(pvd.with_file_name("a_vtu")).unwrap().map(|entry| entry.unwrap().path());
    let all = folder.chain([pvd.to_owned()]);
    all.map(|path| (path.file_name().unwrap().into(), std::fs::read(path).unwrap())).collect()
}

#[test]
fn a_run_and_its_recording_give_the_same_files() {
    let folder = tempfile::tempdir().unwrap();
    let [recording, one, two] = ["a.mcap", "one/a.pvd", "two/a.pvd"].map(|name| folder.path().join(name));
    record(&scene(&[]), &recording, 2, &|_| None);
    for path in [&one, &two] {
        std::fs::create_dir(path.parent().unwrap()).unwrap();
    }
    let (plan, mut recorder) = (small_plan(), VtuRecorder::new(&one));
    let mut measuring = MeasuringRecorder::new(Measures::new()).with(&mut recorder);
    on_own_thread(&plan, &mut measuring, |measuring| run(&plan, &NOT_INTERRUPTED, &mut [measuring]));
    let times =
        write_series(File::open(&recording).unwrap(), &recording, Folder::create(&two).unwrap()).unwrap();
    // Nine times of ball, block, and three pairs (each body also with itself).
    assert_eq!((times, files(&one).len()), (9, 9 * 5 + 1));
    assert!(files(&one) == files(&two), "run and recording differ");
}

/// Removes a folder at a step, as if the disk had failed.
struct Removing(PathBuf);

impl Sink for Removing {
    fn record(&mut self, measured: &MeasuredFrame) -> Result<(), RecorderError> {
        if measured.frame.step == 20 {
            std::fs::remove_dir_all(&self.0).unwrap();
        }
        Ok(())
    }
}

#[test]
fn a_series_that_cannot_be_written_ends_the_run() {
    let folder = tempfile::tempdir().unwrap();
    let pvd = folder.path().join("a.pvd");
    let (plan, mut recorder) = (small_plan(), VtuRecorder::new(&pvd));
    let mut removing = Removing(folder.path().join("a_vtu.partial"));
    let mut measuring = MeasuringRecorder::new(Measures::new()).with(&mut recorder).with(&mut removing);
    let (outcome, _) = run(&plan, &NOT_INTERRUPTED, &mut [&mut measuring]);
    let Ending::Failed { failure } = &outcome.ending else { panic!("{:?}", outcome.ending) };
    assert_eq!(failure.cause, FailureCause::RecordingFailed);
    assert!(failure.message.contains("a_vtu.partial"), "{}", failure.message);
    assert!(!pvd.exists(), "a series that is not whole has no list");
}

#[test]
fn a_recording_that_is_cut_leaves_no_series() {
    let folder = tempfile::tempdir().unwrap();
    let [recording, pvd] = ["a.mcap", "a.pvd"].map(|name| folder.path().join(name));
    record(&scene(&[]), &recording, 1, &|_| None);
    let whole = std::fs::read(&recording).unwrap();
    std::fs::write(&recording, &whole[..whole.len() / 2]).unwrap();
    let refused = write_series(File::open(&recording).unwrap(), &recording, Folder::create(&pvd).unwrap());
    assert!(refused.unwrap_err().to_string().contains("not a readable recording"));
    let left: Vec<_> =
        std::fs::read_dir(folder.path()).unwrap().map(|entry| entry.unwrap().file_name()).collect();
    assert_eq!(left, ["a.mcap"]);
    // And one without fields says so.
    record(
        &scene(&[(
            "\"record\": {\n    \"fields\": [\"von_mises\", \"pressure\", \"principal_strain\", \"displacement\", \"velocity\", \"element_cauchy_stress\"]",
            "\"record\": {\n    \"fields\": []",
        )]),
        &recording,
        1,
        &|_| None,
    );
    let refused = write_series(File::open(&recording).unwrap(), &recording, Folder::create(&pvd).unwrap());
    assert!(refused.unwrap_err().to_string().contains("record.fields"));
}

#[test]
fn surfaces_are_closed_and_of_the_nearest_time() {
    let folder = tempfile::tempdir().unwrap();
    let recording = folder.path().join("a.mcap");
    record(&scene(&[]), &recording, 1, &|_| None);
    let open = || File::open(&recording).unwrap();
    assert_eq!(field_times(open(), &recording).unwrap().len(), 9);
    let start = surfaces_at(open(), &recording, Some(2e-5)).unwrap();
    let [ball, block] = &start.bodies[..] else { panic!("{} bodies", start.bodies.len()) };
    assert_eq!(
        (start.time_s, &ball.name[..], block.triangles.len()),
        (0.0, "ball", 2 * 2 * (8 * 8 + 2 * 8 * 4))
    );
    // 40 mm × 40 mm × 15 mm.
    let volume: f64 = block
        .triangles
        .iter()
        .map(|triangle| {
            let [a, b, c] = triangle
                .map(|corner| nalgebra::Vector3::from(block.positions[corner as usize]).cast::<f64>());
            a.dot(&b.cross(&c)) / 6.0
        })
        .sum();
    assert!((volume / 2.4e-5 - 1.0).abs() < 1e-6, "{volume}");
    let end = surfaces_at(open(), &recording, None).unwrap();
    assert!((end.time_s - 4e-4).abs() < 1e-12 && end.bodies[1].positions != block.positions);
    let refused = surfaces_at(open(), &recording, Some(1e-3)).unwrap_err().to_string();
    assert!(refused.contains("from 0 to 0.4 ms"), "{refused}");
}
