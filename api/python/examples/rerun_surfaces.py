"""Writes a recording for rerun (https://rerun.io), with coloured surfaces and the force: `rerun impact.rrd` shows them at once.

    pip install rerun-sdk
    python api/python/examples/rerun_surfaces.py impact.mcap impact.rrd
"""

# %% The surfaces are those of `/mesh`: coloured by von Mises stress, rigid bodies placed by their pose.
import sys

import numpy as np
import rerun as rr
import rerun.blueprint as rrb

from contuse import Recording

source, target = sys.argv[1:3]
recording = Recording(source)
topics = [topic for topic in recording.topics if topic.startswith("/mesh/")]


def rows(messages, names):
    return np.array([[getattr(message, name) for name in names] for message in messages])


def normals(points, triangles):
    """Normals at the vertices, by which surfaces are shaded: sums over the triangles around them, by area."""
    a, b, c = (points[triangles[:, i]] for i in range(3))
    found = np.zeros_like(points)
    for i in range(3):
        np.add.at(found, triangles[:, i], np.cross(b - a, c - a))
    return found / np.maximum(np.linalg.norm(found, axis=1, keepdims=True), 1e-30)


# %% The picture above, the force below, both on the simulated time, as slow as other players have it.
views = rrb.Vertical(rrb.Spatial3DView(origin="/mesh"), rrb.TimeSeriesView(origin="/force"), row_shares=[3, 1])
clock = rrb.TimePanel(timeline="simulated", playback_speed=1 / float(recording.metadata["time_factor"]))
rr.init("contuse", recording_id=recording.metadata["scene_hash"])
rr.save(target, default_blueprint=rrb.Blueprint(views, clock, collapse_panels=True))
for topic, update in recording.messages(*topics):
    [entity] = update.entities
    [surface] = entity.triangles
    rr.set_time("simulated", duration=entity.timestamp.seconds + 1e-9 * entity.timestamp.nanos)
    rr.log(topic, rr.Transform3D(translation=rows([surface.pose.position], "xyz")[0], quaternion=rows([surface.pose.orientation], "xyzw")[0]))
    points, triangles = rows(surface.points, "xyz"), np.reshape(surface.indices, (-1, 3))
    colours = rows(surface.colors, "rgba") if surface.colors else None
    rr.log(topic, rr.Mesh3D(vertex_positions=points, triangle_indices=triangles, vertex_normals=normals(points, triangles), vertex_colors=colours))

# %% Each recorded step has a force.
forces = recording.forces()
rr.send_columns("/force", [rr.TimeColumn("simulated", duration=forces["time_s"])], rr.Scalars.columns(scalars=forces["force_n"]))
rr.disconnect()
