"""Reads a recording with the independent readers of PyPI."""

import json
import pathlib
from dataclasses import dataclass, field

import numpy as np
from mcap.reader import make_reader
from mcap_protobuf.decoder import DecoderFactory

DTYPES = {"f32": "<f4", "f64": "<f8", "u32": "<u4", "u8": "u1"}


def unpack(array) -> np.ndarray:
    """A packed array as count × components numbers (count alone for scalars)."""
    numbers = np.frombuffer(array.data, dtype=DTYPES[array.dtype])
    if numbers.size != array.count * array.components:
        raise ValueError(f"{array.name}: {numbers.size} numbers, not {array.count} × {array.components}")
    return numbers if array.components == 1 else numbers.reshape(array.count, array.components)


def positions(mesh, stress) -> np.ndarray:
    """Positions x = X + V t + u [m] of the nodes of a body at the time of its fields, in double precision."""
    displacement = next(unpack(array) for array in stress.nodal if array.name == "displacement_m")
    flight = mesh.flight_velocity_m_per_s
    return unpack(mesh.positions) + np.array([flight.x, flight.y, flight.z]) * max(stress.time_s, 0.0) + displacement


@dataclass
class Message:
    """One message."""

    topic: str
    schema: str
    log_time: int
    publish_time: int
    body: object


@dataclass
class Recording:
    """All of a file, decoded."""

    summary: object
    messages: list[Message] = field(default_factory=list)
    metadata: dict[str, dict[str, str]] = field(default_factory=dict)
    attachments: dict[str, bytes] = field(default_factory=dict)

    def of(self, topic: str) -> list:
        """The bodies of the messages of a topic."""
        return [m.body for m in self.messages if m.topic == topic]

    def topics(self, prefix: str) -> list[str]:
        """The topics that begin so, in the order of their first messages."""
        return list(dict.fromkeys(m.topic for m in self.messages if m.topic.startswith(prefix)))

    def json(self, attachment: str):
        """An attachment as JSON."""
        return json.loads(self.attachments[attachment])


def read(path: str | pathlib.Path) -> Recording:
    """Reads and decodes everything; checksums are checked on the way."""
    with open(path, "rb") as stream:
        reader = make_reader(stream, validate_crcs=True, decoder_factories=[DecoderFactory()])
        recording = Recording(summary=reader.get_summary())
        for schema, channel, message, body in reader.iter_decoded_messages(log_time_order=False):
            times = (message.log_time, message.publish_time)
            recording.messages.append(Message(channel.topic, schema.name, *times, body))
        recording.metadata = {record.name: dict(record.metadata) for record in reader.iter_metadata()}
        recording.attachments = {record.name: record.data for record in reader.iter_attachments()}
    return recording
