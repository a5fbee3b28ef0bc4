"""A recording: forces, energies and fields as arrays, meshes for PyVista."""

from __future__ import annotations

import json
import os
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np
from mcap.exceptions import McapError
from mcap.reader import McapReader, make_reader
from mcap_protobuf.decoder import DecoderFactory
from numpy.typing import NDArray

from .errors import RecordingError

Array = NDArray[Any]
DTYPES = {"f32": "<f4", "f64": "<f8", "u32": "<u4", "u8": "u1"}
#: Nodes of the cells of a recording by their type in VTK, whose order of nodes is that of the recording.
VTK_NODES = {10: 4, 12: 8, 13: 6, 24: 10}
VTK_HEXAHEDRON = 12
#: What an MCAP file begins and, when it is whole, ends with.
MAGIC = b"\x89MCAP0\r\n"
#: Times of fields are kept to this [s].
TIME_RESOLUTION_S = 1e-9


def unpacked(array: Any) -> Array:
    """A packed array as count × components numbers (count alone for scalars)."""
    numbers: Array = np.frombuffer(array.data, dtype=DTYPES[array.dtype])
    return numbers if array.components == 1 else numbers.reshape(array.count, array.components)


def vtk_cells(reference: Any) -> tuple[Array, Array]:
    """The cells of a reference mesh as VTK wants them: the number of nodes and the nodes of each, and the type of each."""
    if reference.DESCRIPTOR.name == "ReferenceMesh":
        hexes = unpacked(reference.hexes).astype(np.int64)
        return np.insert(hexes, 0, 8, axis=1).ravel(), np.full(len(hexes), VTK_HEXAHEDRON)
    types = unpacked(reference.cell_types)
    counts = np.array([VTK_NODES[int(kind)] for kind in types])
    starts = np.cumsum(counts) - counts
    return np.insert(unpacked(reference.cell_nodes).astype(np.int64), starts, counts), types


@dataclass(frozen=True)
class Frame:
    """The nodes of a body at a field time: positions [m], n × 3, and fields by name (units are the ends of the names), vectors n × 3."""

    time_s: float
    positions_m: Array
    fields: dict[str, Array] = field(default_factory=dict)


class Recording:
    """A recording on disk; it is read when something of it is asked for. Raises `RecordingError` for a file that is none, or not whole."""

    def __init__(self, path: str | Path) -> None:
        self.path = Path(path)
        with self._reader():
            pass

    @contextmanager
    def _reader(self) -> Iterator[McapReader]:
        """A reader of the file, whose errors name it."""
        try:
            with open(self.path, "rb") as stream:
                _check_whole(stream, self.path)
                yield make_reader(stream, validate_crcs=True, decoder_factories=[DecoderFactory()])
        except OSError as error:
            raise RecordingError(f"{self.path}: {error.strerror or error}") from error
        except McapError as error:
            raise RecordingError(f"{self.path} is damaged: {error}") from error

    def messages(self, *topics: str) -> Iterator[tuple[str, Any]]:
        """Topics and decoded messages, in the order of time."""
        with self._reader() as reader:
            for _, channel, _, message in reader.iter_decoded_messages(topics=topics or None):
                yield channel.topic, message

    @cached_property
    def metadata(self) -> dict[str, str]:
        """What the run was: engine, scene, hashes, factor of time."""
        with self._reader() as reader:
            return {key: value for record in reader.iter_metadata() if record.name == "contuse.run" for key, value in record.metadata.items()}

    @cached_property
    def scene(self) -> dict[str, Any]:
        """The scene document that was run."""
        with self._reader() as reader:
            attachments = {a.name: a.data for a in reader.iter_attachments()}
        scene: dict[str, Any] = json.loads(attachments["scene.json"])
        return scene

    @cached_property
    def topics(self) -> list[str]:
        """The topics that have messages."""
        with self._reader() as reader:
            summary = reader.get_summary()
        return [channel.topic for channel in summary.channels.values()] if summary else []

    @cached_property
    def _references(self) -> dict[str, tuple[str, Any]]:
        """Topic name and reference mesh by body."""
        topics = [topic for topic in self.topics if topic.startswith("/reference/")]
        return {message.body: (topic.removeprefix("/reference/"), message) for topic, message in self.messages(*topics)} if topics else {}

    def _reference(self, body: str) -> tuple[str, Any]:
        if body not in self._references:
            known = ", ".join(map(repr, self._references)) or "none"
            raise RecordingError(f"{self.path} has no body {body!r} that deforms: it has {known}")
        return self._references[body]

    @property
    def bodies(self) -> list[str]:
        """Names of the bodies that deform."""
        return list(self._references)

    def forces(self, pair: int | str = 0) -> dict[str, Array]:
        """Time [s], force [N], impulse [N s] and area [m²] of a contact pair, by its name or its place in the last step, at every step that has it."""
        messages = [m for _, m in self.messages("/contact/forces")]
        names = [p.pair for p in messages[-1].pairs] if messages else []
        if isinstance(pair, str) and pair not in names or isinstance(pair, int) and pair >= len(names) > 0:
            raise RecordingError(f"{self.path} has no contact pair {pair!r}: it has {', '.join(map(repr, names)) or 'none'}")
        name = pair if isinstance(pair, str) else names[pair] if names else ""
        rows = [(m.time_s, p.force_norm_n, p.impulse_norm_n_s, p.patch_area_m2) for m in messages for p in m.pairs if p.pair == name]
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
        name, reference = self._reference(body)
        rest, flight = unpacked(reference.positions), reference.flight_velocity_m_per_s
        for _, message in self.messages(f"/stress/{name}"):
            fields = {array.name: unpacked(array) for array in message.nodal}
            if "displacement_m" not in fields:
                raise RecordingError(f"{self.path} has no displacements: an earlier version of Contuse recorded it")
            flown = np.array([flight.x, flight.y, flight.z]) * max(message.time_s, 0.0)
            yield Frame(message.time_s, rest + flown + fields["displacement_m"], fields)

    def frame(self, body: str, time_s: float) -> Frame:
        """The state of a body at the field time that is nearest. Raises `RecordingError` for times outside of what was recorded."""
        frames = list(self.frames(body))
        if not frames:
            raise RecordingError(f"{self.path} has no fields of {body!r}: the scene asked for none")
        first, last = frames[0].time_s, frames[-1].time_s
        if not first - TIME_RESOLUTION_S <= time_s <= last + TIME_RESOLUTION_S:
            raise RecordingError(f"{self.path} has no fields at {time_s:g} s: they are from {first:g} to {last:g} s")
        return min(frames, key=lambda frame: abs(frame.time_s - time_s))

    def to_pyvista(self, body: str, time_s: float) -> Any:
        """The deformed mesh of a body at the nearest field time as a `pyvista.UnstructuredGrid`, with fields and parts."""
        import pyvista

        _, reference = self._reference(body)
        frame = self.frame(body, time_s)
        grid = pyvista.UnstructuredGrid(*vtk_cells(reference), frame.positions_m)
        for name, values in frame.fields.items():
            grid.point_data[name] = values
        grid.cell_data["part"] = unpacked(reference.part_of)
        grid.field_data["parts"] = list(reference.parts)
        grid.field_data["time_s"] = [frame.time_s]
        return grid


def _check_whole(stream: BinaryIO, path: Path) -> None:
    """Looks at both ends of a file, and goes back to its beginning."""
    first = stream.read(len(MAGIC))
    size = stream.seek(0, os.SEEK_END)
    stream.seek(max(0, size - len(MAGIC)))
    last = stream.read()
    stream.seek(0)
    if first != MAGIC:
        raise RecordingError(f"{path} is no recording (MCAP): it begins with {first!r}")
    if last != MAGIC:
        raise RecordingError(f"{path} is not whole: its end is missing. Fetch it again, or wait until its run has ended")
