"""A recording: forces, energies and fields as arrays, meshes for PyVista."""

from __future__ import annotations

import json
from collections.abc import Iterator
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
from mcap.reader import make_reader
from mcap_protobuf.decoder import DecoderFactory
from numpy.typing import NDArray

Array = NDArray[Any]
DTYPES = {"f32": "<f4", "f64": "<f8", "u32": "<u4", "u8": "u1"}
#: Cells of eight corners in VTK, whose order is that of the recording.
VTK_HEXAHEDRON = 12


def unpacked(array: Any) -> Array:
    """A packed array as count × components numbers (count alone for scalars)."""
    numbers: Array = np.frombuffer(array.data, dtype=DTYPES[array.dtype])
    return numbers if array.components == 1 else numbers.reshape(array.count, array.components)


@dataclass(frozen=True)
class Frame:
    """The nodes of a body at a field time: positions [m], n × 3, and fields by name (units are the ends of the names)."""

    time_s: float
    positions_m: Array
    fields: dict[str, Array] = field(default_factory=dict)


class Recording:
    """A recording on disk; it is read when something of it is asked for."""

    def __init__(self, path: str | Path) -> None:
        self.path = Path(path)

    def messages(self, *topics: str) -> Iterator[tuple[str, Any]]:
        """Topics and decoded messages, in the order of time."""
        with open(self.path, "rb") as stream:
            reader = make_reader(stream, validate_crcs=True, decoder_factories=[DecoderFactory()])
            for _, channel, _, message in reader.iter_decoded_messages(topics=topics or None):
                yield channel.topic, message

    @cached_property
    def metadata(self) -> dict[str, str]:
        """What the run was: engine, scene, hashes, factor of time."""
        with open(self.path, "rb") as stream:
            records = make_reader(stream).iter_metadata()
            return {key: value for record in records if record.name == "contuse.run" for key, value in record.metadata.items()}

    @cached_property
    def scene(self) -> dict[str, Any]:
        """The scene document that was run."""
        with open(self.path, "rb") as stream:
            attachments = {a.name: a.data for a in make_reader(stream).iter_attachments()}
        scene: dict[str, Any] = json.loads(attachments["scene.json"])
        return scene

    @cached_property
    def _references(self) -> dict[str, tuple[str, Any]]:
        """Topic name and reference mesh by body."""
        with open(self.path, "rb") as stream:
            summary = make_reader(stream).get_summary()
        channels = summary.channels.values() if summary else []
        topics = [channel.topic for channel in channels if channel.topic.startswith("/reference/")]
        return {message.body: (topic.removeprefix("/reference/"), message) for topic, message in self.messages(*topics)} if topics else {}

    @property
    def bodies(self) -> list[str]:
        """Names of the bodies that deform."""
        return list(self._references)

    def forces(self, pair: int = 0) -> dict[str, Array]:
        """Time [s], force [N], impulse [N s] and area [m²] of a contact pair at every recorded step."""
        rows = [(m.time_s, m.pairs[pair].force_norm_n, m.pairs[pair].impulse_norm_n_s, m.pairs[pair].patch_area_m2) for _, m in self.messages("/contact/forces")]
        return dict(zip(("time_s", "force_n", "impulse_n_s", "area_m2"), np.array(rows).reshape(-1, 4).T))

    def energy(self) -> dict[str, Array]:
        """Time [s], and kinetic, strain, total and absorbed energy [J] at every recorded step."""
        rows = [
            (m.time_s, sum(b.kinetic_j for b in m.bodies), sum(b.strain_j for b in m.bodies), m.total_j, m.absorbed_by_tissue_j)
            for _, m in self.messages("/energy")
        ]
        return dict(zip(("time_s", "kinetic_j", "strain_j", "total_j", "absorbed_j"), np.array(rows).reshape(-1, 5).T))

    def frames(self, body: str) -> Iterator[Frame]:
        """The states of a body at the field times."""
        name, _ = self._references[body]
        for _, cloud in self.messages(f"/points/{name}"):
            rows = np.frombuffer(cloud.data, "<f4").reshape(-1, len(cloud.fields))
            columns = {f.name: rows[:, i] for i, f in enumerate(cloud.fields)}
            time_s = cloud.timestamp.seconds + 1e-9 * cloud.timestamp.nanos
            yield Frame(time_s, rows[:, :3], {k: v for k, v in columns.items() if k not in "xyz"})

    def frame(self, body: str, time_s: float) -> Frame:
        """The state of a body at the field time that is nearest."""
        frames = list(self.frames(body))
        if not frames:
            raise ValueError(f"the recording has no fields of {body!r}: the scene asked for none")
        return min(frames, key=lambda frame: abs(frame.time_s - time_s))

    def to_pyvista(self, body: str, time_s: float) -> Any:
        """The deformed mesh of a body at the nearest field time as a `pyvista.UnstructuredGrid`, with fields and parts."""
        import pyvista

        _, reference = self._references[body]
        hexes = unpacked(reference.hexes).astype(np.int64)
        frame = self.frame(body, time_s)
        cells = np.hstack([np.full((len(hexes), 1), 8), hexes])
        grid = pyvista.UnstructuredGrid(cells.ravel(), np.full(len(hexes), VTK_HEXAHEDRON), frame.positions_m.astype(float))
        for name, values in frame.fields.items():
            grid.point_data[name] = values
        grid.cell_data["part"] = unpacked(reference.part_of)
        grid.field_data["parts"] = list(reference.parts)
        grid.field_data["time_s"] = [frame.time_s]
        return grid
