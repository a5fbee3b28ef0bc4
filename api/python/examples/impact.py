"""An impact from Python: run it whole, or cell by cell in an editor that knows `# %%`.

    python api/python/examples/impact.py http://127.0.0.1:8080
"""

# %% A scene is a document; the scenarios are good ones to begin with.
import json
import sys
from pathlib import Path

from contuse import Client, InvalidScene

address = sys.argv[1] if len(sys.argv) > 1 else "http://127.0.0.1:8080"
scene = json.loads((Path(__file__).parents[3] / "scenarios/flashball_thigh/scene.json").read_text())
scene["bodies"][0]["velocity_m_per_s"] = [0, 0, -80]

# %% Mistakes come all at once, each with its place.
client = Client(address)
try:
    client.validate({**scene, "end_time_s": -1})
except InvalidScene as error:
    print(error)

# %% Submit, and follow.
job = client.submit(scene)
job = client.wait(job, on_progress=lambda p: print(f"{p.phase} {p.progress:.0%}"))

# %% Four numbers with their errors.
summary = client.summary(job)
print("peak force      ", summary.peak_force_n)
print("largest patch   ", summary.largest_patch_area_mm2)
for threshold_pa, depth in summary.depths_mm.items():
    print(f"depth > {threshold_pa / 1e3:g} kPa", depth)
print("energy given    ", summary.energy_given_j)
print(*summary.warnings, sep="\n")

# %% The same in plain words, and what published injury criteria say, where they cover the scene.
print(*summary.plain_words, sep="\n")
print(*(measure for measure in summary.injury_measures if measure.applicable), sep="\n")
print(summary.notice)

# %% The recording, as arrays.
recording = client.recording(job, "impact.mcap")
forces = recording.forces()
print(f"{len(forces['time_s'])} steps, impulse {forces['impulse_n_s'][-1]:.4g} N s")

# %% And as a mesh: a cut through the tissue. `cut.plot(scalars="von_mises_pa", cmap="cividis", clim=[0, 1e5])` shows it.
grid = recording.to_pyvista("thigh", time_s=8e-5)
cut = grid.clip("y", origin=(0, 0, 0))
print(f"{grid.n_cells} cells, von Mises up to {grid['von_mises_pa'].max() / 1e3:.4g} kPa")
