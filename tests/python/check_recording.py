"""Checks a recording with readers that are not Contuse's own (mcap, mcap-protobuf-support, protoc).

    python tests/python/check_recording.py FILE [--summary summary.json] [--expect-ending finished]

Prints what was checked and exits with 1 and a reason at the first thing that is wrong.
"""

import argparse
import json
import math
import sys

import numpy as np
from compile_schemas import compile_schemas
from google.protobuf import descriptor_pb2
from mcap.stream_reader import StreamReader
from mcap.records import Chunk, DataEnd, Footer
from recording import Message, Recording, positions, read, unpack

RUN_KEYS = [
    "engine", "engine_version", "engine_commit", "scene", "scene_hash", "units", "time_factor", "end_time_s", "every_steps",
    "field_times_s", "fields", "colour_range_pa", "plan_report", "notice",
]  # fmt: skip
ENDING_KEYS = ["complete", "ending", "why", "time_s", "step"]
NODAL = {"von_mises": "von_mises_pa", "pressure": "pressure_pa", "principal_strain": "principal_strain",
         "displacement": "displacement_m", "velocity": "velocity_m_per_s"}  # fmt: skip
CONTACT_ARRAYS = {"node": 1, "position_m": 3, "normal": 3, "normal_force_n": 1, "tangential_force_n": 3, "gap_m": 1,
                  "status": 1}  # fmt: skip


class Wrong(Exception):
    """What is wrong with the file."""


def need(condition: bool, reason: str) -> None:
    """Says what is wrong unless the condition holds."""
    if not condition:
        raise Wrong(reason)


def check_container(path: str, recording: Recording) -> str:
    """Checksums, summary section, index and statistics."""
    with open(path, "rb") as stream:
        records = list(StreamReader(stream, emit_chunks=True, validate_crcs=True).records)
    chunks = [r for r in records if isinstance(r, Chunk)]
    need(isinstance(records[-1], Footer), "the file does not end with a footer")
    need(records[-1].summary_crc != 0, "the summary section has no checksum")
    need(any(isinstance(r, DataEnd) and r.data_section_crc != 0 for r in records), "the data section has no checksum")
    need(all(c.uncompressed_crc != 0 for c in chunks), "a chunk has no checksum")
    need(all(c.compression == "zstd" for c in chunks), "a chunk is not compressed with zstd")
    summary = recording.summary
    need(summary is not None and summary.statistics is not None, "there are no statistics")
    need(len(summary.chunk_indexes) == len(chunks) > 0, "the index does not have every chunk")
    need(len(summary.metadata_indexes) == len(recording.metadata), "the index does not have all metadata")
    need(len(summary.attachment_indexes) == len(recording.attachments), "the index does not have every attachment")
    need(summary.statistics.message_count == len(recording.messages), "the statistics count other messages")
    return f"{len(chunks)} chunks, {len(recording.messages)} messages"


def check_schemas(recording: Recording) -> str:
    """The descriptors in the file are those of the .proto files."""
    wanted = {file.name: file.SerializeToString(deterministic=True) for file in compile_schemas().file}
    for schema in recording.summary.schemas.values():
        need(schema.encoding == "protobuf", f"{schema.name} is {schema.encoding}")
        files = descriptor_pb2.FileDescriptorSet.FromString(schema.data).file
        for file in files:
            need(file.name in wanted, f"{schema.name}: {file.name} is not in api/")
            same = file.SerializeToString(deterministic=True) == wanted[file.name]
            need(same, f"{schema.name}: {file.name} is not what api/ says")
    return f"{len(recording.summary.schemas)} schemas"


def check_metadata(recording: Recording, ending: str | None) -> str:
    """Metadata and attachments are there and parse."""
    run, end = recording.metadata.get("contuse.run", {}), recording.metadata.get("contuse.ending", {})
    for name, record, keys in [("contuse.run", run, RUN_KEYS), ("contuse.ending", end, ENDING_KEYS)]:
        need(not (missing := [k for k in keys if not record.get(k)]), f"{name} lacks {missing}")
    bodies = [topic.removeprefix("/reference/") for topic in recording.topics("/reference/")]
    need(sum(key.startswith("mesh_hash/") for key in run) == len(bodies), "a mesh hash is missing")
    json.loads(run["plan_report"])
    need((end["ending"] == "finished") == (end["complete"] == "true"), "complete is not what the ending says")
    need(ending is None or end["ending"] == ending, f"the ending is {end['ending']}, not {ending}")
    whole = end["ending"] in ("finished", "cancelled", "failed")
    for name in ["scene.json", "plan_report.json"] + ["summary.json"] * whole:
        need(name in recording.attachments, f"the attachment {name} is missing")
        recording.json(name)
    return f"ending {end['ending']}"


def check_times(recording: Recording) -> str:
    """Log times increase strictly and are the simulated time, stretched."""
    factor = float(recording.metadata["contuse.run"]["time_factor"])
    exponent = math.log10(factor)
    need(abs(exponent - round(exponent)) < 1e-9, f"the time factor {factor} is no power of ten")
    played = float(recording.metadata["contuse.run"]["end_time_s"]) * factor
    need(1 - 1e-9 <= played < 10, f"the run would be played for {played} s")
    last = -1
    for m in recording.messages:
        need(m.log_time > last, f"{m.topic}: log time {m.log_time} does not follow {last}")
        last = m.log_time
        time = time_of(m)
        need(abs(m.publish_time - 1e9 * time) <= 0.5 + 1e-6, f"{m.topic}: published at {m.publish_time} ns, not {time} s")
        # Messages of one step follow each other by a nanosecond; Foxglove's times are whole nanoseconds.
        rounding = 1 if hasattr(m.body, "time_s") else 1 + 0.51 * factor
        late = m.log_time - 1e9 * time * factor
        need(-rounding <= late <= 1e3 + rounding, f"{m.topic}: log time {m.log_time} at {time} s")
    return f"time factor {factor:g}"


def time_of(m: Message) -> float:
    """The simulated time that a message says."""
    if m.schema.startswith("contuse."):
        return m.body.time_s
    if m.schema == "foxglove.SceneUpdate":
        return entity_time(m)
    return m.body.timestamp.seconds + 1e-9 * m.body.timestamp.nanos


def entity_time(m: Message) -> float:
    """The time of an entity, which its metadata give in full."""
    entity = m.body.entities[0]
    stamp, time = entity.timestamp, float({pair.key: pair.value for pair in entity.metadata}["time_s"])
    need(abs(time - stamp.seconds - 1e-9 * stamp.nanos) <= 0.51e-9, f"{m.topic}: two times in one entity")
    return time


def check_cadence(recording: Recording) -> str:
    """Every topic has its messages, at its times."""
    run, end = recording.metadata["contuse.run"], recording.metadata["contuse.ending"]
    every, reached = int(run["every_steps"]), float(end["time_s"])
    steps = [m.step for m in recording.of("/energy")]
    need(len(steps) > 0, "there are no energies")
    need(all(0 < b - a <= every for a, b in zip(steps, steps[1:])), "energies are not every so many steps")
    energy_times = [m.time_s for m in recording.of("/energy")]
    contact = recording.of("/contact/forces")
    if contact:
        need([m.time_s for m in contact] == energy_times[: len(contact)], "contact forces are not with the energies")
        need(len(energy_times) - len(contact) <= 1, "contact forces are missing")
    field_times = [t for t in json.loads(run["field_times_s"]) if t <= reached * (1 + 1e-12)]
    need(set(field_times) <= set(energy_times), "energies are missing at field times")
    bodies, rigid = len(recording.topics("/reference/")), len(recording.topics("/pose/"))
    topics = sum((recording.topics(f"/{kind}/") for kind in ("stress", "mesh", "points")), [])
    need(len(topics) == (3 * bodies + rigid if json.loads(run["fields"]) else 0), f"the field topics are {topics}")
    for topic in topics:
        times = [time_of(m) for m in recording.messages if m.topic == topic]
        found = all(any(abs(t - wanted) <= 0.51e-9 for t in times) for wanted in field_times)
        # A run that failed or was cancelled may end with one more.
        need(found and len(times) - len(field_times) <= 1, f"{topic} has {len(times)} of {len(field_times)} field times")
    return f"{len(steps)} energies, {len(field_times)} field times, {bodies} bodies"


def cells_of(mesh) -> tuple[int, np.ndarray]:
    """Number of cells of a reference mesh, and the nodes of all of them."""
    if mesh.DESCRIPTOR.name == "ReferenceMesh":
        hexes = unpack(mesh.hexes)
        need(hexes.shape[1] == 8, "hexahedra have eight nodes")
        return len(hexes), hexes.ravel()
    types, nodes = unpack(mesh.cell_types), unpack(mesh.cell_nodes)
    need(len(nodes) == sum({10: 4, 12: 8, 13: 6, 24: 10}[int(kind)] for kind in types), "cells have the nodes of their types")
    return len(types), nodes


def check_arrays(recording: Recording) -> str:
    """Packed arrays have their lengths and are finite."""
    asked = json.loads(recording.metadata["contuse.run"]["fields"])
    count = 0
    for topic in recording.topics("/reference/"):
        mesh = recording.of(topic)[0]
        name = topic.removeprefix("/reference/")
        nodes, (cells, corners) = unpack(mesh.positions), cells_of(mesh)
        need(nodes.shape[1] == 3 and corners.max() < len(nodes), f"{topic} is no mesh")
        need(len(unpack(mesh.part_of)) == cells, f"{topic}: parts")
        for stress in recording.of(f"/stress/{name}"):
            arrays = {a.name: unpack(a) for a in stress.nodal}
            need(set(arrays) == {"displacement_m"} | {NODAL[f] for f in asked if f in NODAL}, f"{topic}: nodal fields {list(arrays)}")
            need(all(len(a) == len(nodes) for a in arrays.values()), f"{topic}: a nodal field is too short")
            for a in stress.element:
                arrays[a.name] = unpack(a)
                need(arrays[a.name].shape == ((cells,) if a.name == "eroded" else (cells, 6)), f"{topic}: {a.name}")
            need(("cauchy_pa" in arrays) == ("element_cauchy_stress" in asked), f"{topic}: element fields")
            need(all(np.isfinite(a).all() for a in arrays.values()), f"{topic}: a field is not finite")
            need(all((arrays[k] >= 0).all() for k in arrays if k == "von_mises_pa"), f"{topic}: negative von Mises")
            count += len(arrays)
        check_cloud_and_surface(recording, name, mesh)
    return f"{count} field arrays"


POINT = np.dtype([("x", "<f4"), ("y", "<f4"), ("z", "<f4"), ("red", "u1"), ("green", "u1"), ("blue", "u1"), ("alpha", "u1")])


def check_cloud_and_surface(recording: Recording, name: str, reference) -> None:
    """The Foxglove messages of one body agree with the fields."""
    surfaces, stresses = recording.of(f"/mesh/{name}"), recording.of(f"/stress/{name}")
    # Vertices are rounded to at most 2⁻¹⁵ of the diagonal of the box of the body.
    within = float(np.linalg.norm(np.ptp(unpack(reference.positions), axis=0))) / 2**15
    for cloud, surface, stress in zip(recording.of(f"/points/{name}"), surfaces, stresses, strict=True):
        mesh = surface.entities[0].triangles[0]
        need(len(mesh.indices) % 3 == 0 and max(mesh.indices) < len(mesh.points), f"surface of {name}: indices")
        need(len(mesh.colors) in (0, len(mesh.points)), f"surface of {name}: colours")
        layout = [(f.name, f.offset, f.type) for f in cloud.fields]
        need(layout == [(k, POINT.fields[k][1], 7 if k in "xyz" else 1) for k in POINT.names], f"points of {name}: {layout}")
        need(cloud.point_stride == POINT.itemsize, f"points of {name}: the stride is {cloud.point_stride}")
        points = np.frombuffer(cloud.data, POINT)
        vertices = np.array([[p.x, p.y, p.z] for p in mesh.points])
        need(np.array_equal(np.stack([points[k] for k in "xyz"], axis=1), vertices.astype("<f4")), f"points of {name} are no vertices")
        colours = np.array([[c.r, c.g, c.b] for c in mesh.colors or [mesh.color] * len(vertices)])
        shown = np.stack([points[k] for k in ("red", "green", "blue")], axis=1) / 255
        need(bool((np.abs(shown - colours) <= 0.5001 / 255).all()), f"points of {name}: colours")
        # Every vertex is within this of a node: in its cell of a grid of that size, or one beside it.
        cells = {tuple(cell) for cell in np.floor(positions(reference, stress) / within).astype(int).tolist()}
        near = np.stack(np.meshgrid(*[[-1, 0, 1]] * 3), axis=-1).reshape(-1, 3)
        for vertex in np.floor(vertices / within).astype(int):
            need(not cells.isdisjoint(map(tuple, (vertex + near).tolist())), f"surface of {name}: a vertex is no node")


def check_contacts(recording: Recording) -> str:
    """The contacts are those of the field times, and the resultants are their sums."""
    active = 0
    meshes = [recording.of(topic)[0] for topic in recording.topics("/reference/")]
    nodes = {mesh.body: len(unpack(mesh.positions)) for mesh in meshes}
    field_times = {message.time_s for topic in recording.topics("/stress/") for message in recording.of(topic)}
    for message in recording.of("/contact/forces"):
        for pair in message.pairs:
            need((pair.patch_area_m2 > 0) == (pair.patch_nodes > 0), f"{pair.pair}: area of the patch")
            if not pair.contacts:
                need(message.time_s not in field_times, f"{pair.pair}: no contacts at a field time")
                continue
            arrays = {a.name: unpack(a) for a in pair.contacts}
            need({a.name: a.components for a in pair.contacts} == CONTACT_ARRAYS, f"contact arrays {list(arrays)}")
            need(len({len(a) for a in arrays.values()}) == 1, "contact arrays of different lengths")
            need(all(np.isfinite(a).all() for a in arrays.values()), "contact arrays are not finite")
            normal, force = arrays["normal"].reshape(-1, 3).astype(float), vector(pair.force_n)
            resultant = (normal * arrays["normal_force_n"][:, None] + arrays["tangential_force_n"].reshape(-1, 3)).sum(axis=0)
            size = float(arrays["normal_force_n"].sum())
            need(np.abs(resultant - force).max(initial=0) <= 1e-5 * (1e-9 + size), f"{pair.pair}: the contacts do not sum up")
            need(np.allclose(np.linalg.norm(normal, axis=1), 1, atol=1e-6), f"{pair.pair}: a normal is not of unit length")
            # A contact that closes with hardly any force has one that single precision rounds to zero.
            need((arrays["normal_force_n"] >= 0).all(), f"{pair.pair}: an open contact is listed")
            need(np.isin(arrays["status"], [1, 2]).all(), f"{pair.pair}: status")
            # A face of the slave that is touched carries with all of its nodes, and one of them is listed.
            listed = len(set(arrays["node"].tolist()))
            need(listed <= pair.patch_nodes <= listed + 3 * len(normal), f"{pair.pair}: nodes of the patch")
            need((arrays["node"] < nodes.get(pair.slave_body, math.inf)).all(), f"{pair.pair}: a contact at no node")
            active += len(normal)
    return f"{active} active contacts"


def vector(v) -> np.ndarray:
    """A foxglove.Vector3 as an array."""
    return np.array([v.x, v.y, v.z])


def close(a: float, b: float, scale: float) -> bool:
    """Equal to rounding."""
    return abs(a - b) <= 1e-12 * max(abs(a), abs(b), scale)


def check_energies(recording: Recording, given: str | None) -> str:
    """The ledger adds up, and the summary says what the last message says."""
    energies = recording.of("/energy")
    for e in energies:
        total = sum(b.kinetic_j + b.strain_j + b.viscous_j + b.eroded_j for b in e.bodies)
        total += sum(p.friction_j + p.numerical_contact_j + p.impact_j for p in e.pairs)
        need(close(total, e.total_j, 1e3 * e.initial_total_j), f"the energies at {e.time_s} s do not add up")
    if "summary.json" not in recording.attachments:
        return "no summary to compare"
    summary, last = recording.json("summary.json"), energies[-1]
    if given:
        with open(given, encoding="utf-8") as stream:
            need(json.load(stream) == summary, f"{given} is not the summary in the file")
    need(json.loads(recording.of("/summary")[-1].json) == summary, "the last message of /summary is not summary.json")
    need(("results" in summary) != ("withheld" in summary), "results are neither plain nor withheld")
    results = summary["results"] if "results" in summary else summary["withheld"]["values"]
    scale, numerics = last.initial_total_j, summary["numerics"]
    pairs = [("initial energy", numerics["initial_energy_j"], last.initial_total_j),
             ("numerical contact", numerics["numerical_contact_dissipation_j"], sum(p.numerical_contact_j for p in last.pairs)),
             ("friction", numerics["friction_dissipation_j"], sum(p.friction_j for p in last.pairs))]  # fmt: skip
    if tissue := results.get("tissue"):
        pairs += [("absorbed", tissue["absorbed_energy_j"]["value"], last.absorbed_by_tissue_j),
                  ("absorbed by work", tissue["absorbed_energy_by_work_j"]["value"], last.absorbed_by_tissue_work_j),
                  ("peak absorbed", max(tissue["peak_absorbed_energy_j"]["value"], last.absorbed_by_tissue_j),
                   tissue["peak_absorbed_energy_j"]["value"])]  # fmt: skip
        origins = [recording.of(t)[0] for kind in ("/reference/", "/pose/") for t in recording.topics(kind)]
        roles = {origin.body: origin.role for origin in origins}
        first = energies[0]
        # What loads and projection gave it is none of what it had.
        lost = sum(a.kinetic_j + a.strain_j - b.kinetic_j - b.strain_j + b.external_work_j + b.projection_j
                   for a, b in zip(first.bodies, last.bodies) if roles[a.body] == "projectile")  # fmt: skip
        if "projectile_loss_j" in tissue:
            pairs.append(("projectile's loss", tissue["projectile_loss_j"]["value"], lost))
    friction = {e.pair: e.friction_j for e in last.pairs}
    for impact in results["impacts"]:
        pair = impact["pair"]
        pairs.append((f"friction of {pair}", impact["friction_dissipation_j"]["value"], friction[pair]))
    for name, said, recorded in pairs:
        need(close(said, recorded, scale), f"{name}: the summary says {said}, the recording {recorded}")
    need(numerics["balance_error"] >= max(e.balance_error for e in energies) * (1 - 1e-12), "the balance error is too small")
    check_no_plain_numbers(summary)
    return f"{len(pairs)} numbers of the summary agree"


def check_no_plain_numbers(summary: dict) -> None:
    """Withheld numbers say so, plain ones passed."""
    verdict = "passed" if "results" in summary else "failed"

    def walk(value) -> None:
        if isinstance(value, dict):
            if {"value", "error", "gate"} <= value.keys():
                need(value["gate"] == verdict, f"a number's gate is {value['gate']}, the run's {verdict}")
                need(value["value"] is None or isinstance(value["value"], (int, float)), "a number is no number")
            for inner in value.values():
                walk(inner)
        elif isinstance(value, list):
            for inner in value:
                walk(inner)

    walk(summary)


def main() -> None:
    """Checks one file."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("file")
    parser.add_argument("--summary", help="summary.json that the recording must agree with")
    parser.add_argument("--expect-ending", help="finished, cancelled, failed, worker_lost, ...")
    arguments = parser.parse_args()
    try:
        recording = read(arguments.file)
        print(f"{arguments.file}:", check_container(arguments.file, recording))
        print("  schemas:", check_schemas(recording))
        print("  metadata:", check_metadata(recording, arguments.expect_ending))
        print("  times:", check_times(recording))
        print("  cadence:", check_cadence(recording))
        print("  fields:", check_arrays(recording))
        print("  contacts:", check_contacts(recording))
        print("  energies:", check_energies(recording, arguments.summary))
    except Wrong as wrong:
        sys.exit(f"{arguments.file}: {wrong}")
    except Exception as error:  # what a reader says of a file that it cannot read is a reason too
        sys.exit(f"{arguments.file}: {type(error).__name__}: {error}")


if __name__ == "__main__":
    main()
