"""The client against a service that runs: `CONTUSE=target/release/contuse pytest api/python/tests`."""

import hashlib
import json
import os
import re
import runpy
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from contuse import Client, ContuseError, InvalidScene, JobFailed, NotMeasured, Recording, RecordingError, ServiceProblem, Summary, Unreachable

ROOT = Path(__file__).resolve().parents[3]
BINARY = Path(os.environ.get("CONTUSE", ROOT / "target/release/contuse"))


@pytest.fixture(scope="module")
def address(tmp_path_factory):
    data = tmp_path_factory.mktemp("service")
    command = [BINARY, "serve", "--listen", "127.0.0.1:0", "--data", data]
    process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True)
    words = process.stdout.readline()
    assert "http://" in words, words
    yield words.split()[-1]
    process.terminate()
    process.wait(timeout=60)


@pytest.fixture(scope="module")
def client(address):
    with Client(address) as client:
        yield client


@pytest.fixture(scope="module")
def scene():
    return json.loads((ROOT / "api/examples/job.request.json").read_text())


@pytest.fixture(scope="module")
def job(client, scene):
    heard = []
    job = client.wait(client.submit(scene), on_progress=heard.append)
    assert heard[-1].progress == 1
    assert [p.progress for p in heard] == sorted(p.progress for p in heard)
    return job


def test_a_job_has_its_priority(client, scene):
    assert client.submit(scene, priority="low").body["priority"] == "low"


def test_mistakes_have_their_places(client, scene):
    with pytest.raises(InvalidScene) as caught:
        client.submit({**scene, "end_time_s": -1})
    assert [problem.pointer for problem in caught.value.problems] == ["/end_time_s"]
    assert "/end_time_s" in str(caught.value)


def test_validation_runs_nothing(client, scene):
    before = len(list(client.jobs()))
    assert client.validate(scene)["plan"]["elements"] == 240
    assert len(list(client.jobs())) == before


def test_what_is_not_there_is_a_problem(client):
    with pytest.raises(ServiceProblem) as caught:
        client.job("nothing")
    assert caught.value.status == 404


def test_summary_has_the_four_numbers(client, job):
    summary = client.summary(job)
    numbers = [summary.peak_force_n, summary.patch_area_mm2, summary.absorbed_energy_j, *summary.depths_mm.values()]
    assert all(number.value >= 0 and number.error is not None for number in numbers)
    assert summary.peak_force_n.unit in str(summary.peak_force_n)


def test_summary_speaks_plain_words_and_says_what_criteria_cover(client, job):
    summary = client.summary(job)
    assert any("kPa" in sentence for sentence in summary.plain_words)
    assert "no diagnosis" in summary.notice
    by_name = {measure.name: measure for measure in summary.injury_measures}
    # The scene names no person, so nothing is known of a chest.
    assert not by_name["viscous_criterion"].applicable
    assert by_name["viscous_criterion"].statement in str(by_name["viscous_criterion"])


def test_what_was_not_measured_is_said():
    summary = Summary({"results": {"impacts": []}})
    for number in ("peak_force_n", "absorbed_energy_j"):
        with pytest.raises(NotMeasured):
            getattr(summary, number)


def test_an_address_without_a_service_is_named(monkeypatch):
    monkeypatch.setattr("contuse.client.REST_S", 0)
    # No service can listen on port 0.
    with Client("http://127.0.0.1:0") as without_service:
        for call in (lambda: without_service.job("x"), lambda: without_service.delete("x"), lambda: without_service.wait("x")):
            with pytest.raises(Unreachable, match="http://127.0.0.1:0"):
                call()


def test_recording_agrees_with_the_summary(client, job, tmp_path):
    recording = client.recording(job, tmp_path / "run.mcap")
    summary = client.summary(job)
    forces, energy = recording.forces(), recording.energy()
    assert forces["impulse_n_s"][-1] == pytest.approx(summary.impact["impulse_n_s"]["value"], rel=1e-12)
    assert energy["absorbed_j"][-1] == pytest.approx(summary.absorbed_energy_j.value, rel=1e-12)
    # The ledger closes to within its gate.
    assert np.ptp(energy["total_j"]) < 0.01 * energy["total_j"][0]
    assert recording.scene["name"] == job.name
    assert recording.bodies == ["ball", "block"]


def test_download_goes_on_where_it_broke_off(client, job, tmp_path):
    whole = client.recording(job, tmp_path / "whole.mcap").path.read_bytes()
    (tmp_path / "parts.mcap.partial").write_bytes(whole[:1000])
    assert client.recording(job, tmp_path / "parts.mcap").path.read_bytes() == whole


def test_a_file_that_is_no_whole_recording_is_refused(client, job, tmp_path):
    whole = client.recording(job, tmp_path / "whole.mcap").path.read_bytes()
    (tmp_path / "scene.json").write_text("{}")
    (tmp_path / "broken_off.mcap").write_bytes(whole[: len(whole) // 2])
    # The footer says where the index is: with that damaged nothing can be read.
    (tmp_path / "damaged.mcap").write_bytes(whole[:-60] + bytes(52) + whole[-8:])
    for name, words in [("nothing.mcap", "No such file"), ("scene.json", "no recording"), ("broken_off.mcap", "not whole")]:
        with pytest.raises(RecordingError, match=f"{name}.*{words}"):
            Recording(tmp_path / name)
    with pytest.raises(RecordingError, match="damaged.mcap"):
        Recording(tmp_path / "damaged.mcap").energy()


def test_bodies_and_times_that_are_not_there_are_refused(client, job, tmp_path):
    recording = client.recording(job, tmp_path / "run.mcap")
    with pytest.raises(RecordingError, match="'leg'.*'ball', 'block'"):
        recording.to_pyvista("leg", time_s=0)
    for time_s in (5, -5, float("nan")):
        with pytest.raises(RecordingError, match="from 0 to 0.0001 s"):
            recording.frame("block", time_s)


def test_pyvista_sees_the_mesh(client, job, tmp_path):
    pytest.importorskip("pyvista")
    recording = client.recording(job, tmp_path / "run.mcap")
    start, end = (recording.to_pyvista("block", time_s=t) for t in (0, 1e-4))
    assert start.n_cells == 144
    # The undeformed block is 60 × 60 × 30 mm; VTK integrates it by itself.
    assert start.compute_cell_sizes()["Volume"].sum() == pytest.approx(0.06 * 0.06 * 0.03, rel=1e-6)
    assert end["von_mises_pa"].max() > 1e4 > start["von_mises_pa"].max()
    assert end.field_data["time_s"][0] == pytest.approx(1e-4)


def test_a_mesh_is_uploaded_once(client):
    path = ROOT / "api/examples/cube.msh"
    mesh = client.upload(path)
    assert (mesh.id, mesh.bytes, mesh.format) == (hashlib.sha256(path.read_bytes()).hexdigest(), path.stat().st_size, "msh")
    assert mesh.body["parts"] == {"cube": 1}
    assert client.upload(str(path)) == mesh
    with pytest.raises(ServiceProblem) as caught:
        client.upload(ROOT / "api/examples/events.txt")
    assert caught.value.status == 422


def test_surfaces_beside_a_scene_are_uploaded(client, tmp_path):
    corners = [(0, 0, 0), (0.03, 0, 0), (0, 0.03, 0), (0, 0, 0.03)]
    faces = [[corners[n] for n in face] for face in ((0, 2, 1), (0, 1, 3), (1, 2, 3), (2, 0, 3))]
    facets = ["facet normal 0 0 0\nouter loop\n" + "".join("vertex {} {} {}\n".format(*x) for x in face) + "endloop\nendfacet\n" for face in faces]
    (tmp_path / "fat.stl").write_text("solid\n" + "".join(facets) + "endsolid\n")
    parts = [{"part": "fat", "density_kg_per_m3": 1000, "material": {"law": "neo_hookean", "c10_pa": 5e3, "bulk_modulus_pa": 2e7}}]
    filled = {"name": "fat", "role": "tissue", "fixed": [{"set": "outer"}], "parts": parts, "mesh": {"segmentation": {"surfaces": [{"name": "fat.stl", "part": "fat"}], "size_m": 0.005}}}
    ball = {"name": "wedge", "role": "projectile", "velocity_m_per_s": [0, 0, -1], "rigid": {"shape": {"kind": "stl", "name": "fat.stl"}, "center_m": [0.01, 0.01, 0.04], "mass_kg": 0.1}}
    scene = tmp_path / "scene.json"
    scene.write_text(json.dumps({"name": "surfaces", "end_time_s": 1e-3, "bodies": [ball, filled]}))
    assert [body["name"] for body in client.validate(scene)["bodies"]] == ["wedge", "fat"]


def test_a_scene_begins_with_a_mesh(client):
    mesh = client.upload(ROOT / "tests/data/meshes/layered_plate.msh")
    begun = client.first_scene(mesh, radius_m=0.01)
    assert {part["part"] for part in begun["parts"]} == {"skin", "fat", "muscle"}
    assert client.first_scene(mesh.id) != begun
    # What only the user knows is still to be chosen.
    with pytest.raises(InvalidScene):
        client.validate(begun["scene"])


def test_surfaces_are_triangles_at_a_time(client, job, tmp_path):
    last = client.surface(job, tmp_path / "last.stl").read_bytes()
    assert int.from_bytes(last[80:84], "little") == (len(last) - 84) // 50 > 0
    assert client.surface(job, tmp_path / "last.ply", time_s=1e-4).read_bytes().startswith(b"ply")
    assert client.surface(job, tmp_path / "first.stl", time_s=0).read_bytes() != last
    with pytest.raises(ContuseError, match=".stl or .ply"):
        client.surface(job, tmp_path / "surface.obj")


@pytest.mark.parametrize("scene", ["scene_frictionless.json", "scene_L0_inp.json"])
def test_meshes_beside_a_scene_go_with_it(client, tmp_path, scene):
    folder = ROOT / "scenarios/ball_on_block"
    job = client.wait(client.submit(str(folder / scene)))
    assert client.summary(job).peak_force_n.value > 0
    named = [body["mesh"]["file"]["name"] for body in client.recording(job, tmp_path / "run.mcap").scene["bodies"]]
    file = json.loads((folder / scene).read_text())["bodies"][0]["mesh"]["file"]["name"]
    assert named == [hashlib.sha256((folder / file).read_bytes()).hexdigest()] * 2


def test_meshes_elsewhere_stay_where_they_are(client, tmp_path):
    document = json.loads((ROOT / "scenarios/ball_on_block/scene.json").read_text())
    (tmp_path / "inside").mkdir()
    (tmp_path / "secret.msh").write_bytes((ROOT / "api/examples/cube.msh").read_bytes())
    for name in ("../secret.msh", str(tmp_path / "secret.msh"), "nothing.msh"):
        for body in document["bodies"]:
            body["mesh"]["file"]["name"] = name
        path = tmp_path / "inside/scene.json"
        path.write_text(json.dumps(document))
        with pytest.raises(InvalidScene) as caught:
            client.submit(path)
        assert all(problem.pointer.startswith("/bodies/") and "mesh" in problem.pointer for problem in caught.value.problems)


def test_a_question_is_answered(client, job, scene, tmp_path):
    speed = {"name": "speed", "low": 10, "high": 30, "change": {"kind": "speed_m_per_s", "body": "ball"}}
    question = {"parameters": [speed], "cases": [{"set": {"speed": 20}}]}
    answers = []
    path = tmp_path / "scene.json"
    path.write_text(json.dumps(scene))
    for base in ({"job": job.id}, {"scene": scene}, {"scene": path}):
        answers.append(client.results(client.wait(client.what_if({**question, **base})))["cases"])
    own, faster = answers[0]
    assert own["numbers"]["peak_force_n"]["value"] == pytest.approx(client.summary(job).peak_force_n.value, rel=1e-9)
    assert faster["parameters"] == {"speed": 20}
    assert answers[1] == answers[2] == answers[0]
    with pytest.raises(InvalidScene) as caught:
        client.what_if({**question, "job": "nothing"})
    assert [problem.pointer for problem in caught.value.problems] == ["/job"]


def test_a_study_has_rows(client):
    job = client.study({"kind": "error", "scene": ROOT / "scenarios/bar_on_wall/scene.json", "coarsest": -1, "finest": 0})
    rows = client.results(client.wait(job))["rows"]
    assert {"mesh -1", "mesh 0"} <= {row["name"] for row in rows}
    assert all(row["ending"] == "finished" and row["errors"]["peak_force_n"] >= 0 for row in rows)


def test_cancelled_jobs_raise_and_can_be_deleted(client, scene):
    job = client.submit({**scene, "end_time_s": 1.0, "record": {"every_steps": 1000, "fields": []}})
    client.cancel(job)
    with pytest.raises(JobFailed):
        client.wait(job)
    client.delete(job)
    with pytest.raises(ServiceProblem):
        client.job(job)


def test_example_runs(address, tmp_path, monkeypatch, capsys):
    pytest.importorskip("pyvista")
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(sys, "argv", ["impact.py", address])
    runpy.run_path(str(ROOT / "api/python/examples/impact.py"))
    said = capsys.readouterr().out
    assert "/end_time_s" in said and "energy given" in said and "numbers are not final" in said
    assert "kPa" in said and "no diagnosis" in said


def test_surfaces_for_rerun(client, job, tmp_path, monkeypatch):
    pytest.importorskip("rerun")
    recording = client.recording(job, tmp_path / "impact.mcap")
    target = tmp_path / "impact.rrd"
    monkeypatch.setattr(sys, "argv", ["rerun_surfaces.py", str(recording.path), str(target)])
    runpy.run_path(str(ROOT / "api/python/examples/rerun_surfaces.py"))
    rerun = [sys.executable, "-m", "rerun", "rrd"]
    subprocess.run([*rerun, "verify", target], check=True)
    chunks = subprocess.run([*rerun, "print", target], check=True, capture_output=True, text=True).stdout
    for topic in (topic for topic in recording.topics if topic.startswith("/mesh/")):
        frames = sum(1 for _ in recording.messages(topic))
        assert re.search(rf"with {frames} rows .* - {topic} - .*vertex_colors.*vertex_positions", chunks)
    assert re.search(rf"with {len(recording.forces()['time_s'])} rows .* - /force - .*scalars", chunks)
