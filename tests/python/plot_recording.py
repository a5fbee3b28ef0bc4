"""Draws a recording: von Mises stress in a cut at four times, force and energy over time.

    python tests/python/plot_recording.py FILE out.png

The cut holds the direction of the impact and the place of the first contact, and lies across the tissue.
"""

import json
import sys

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np
from recording import Recording, positions, read, unpack

# Six tetrahedra that fill a hexahedron, about its diagonal 0-6.
TETRAHEDRA = np.array([[0, 1, 2, 6], [0, 2, 3, 6], [0, 3, 7, 6], [0, 7, 4, 6], [0, 4, 5, 6], [0, 5, 1, 6]])
EDGES = [(0, 1), (0, 2), (0, 3), (1, 2), (1, 3), (2, 3)]
STYLES = ["-", "--", "-.", ":", (0, (3, 1, 1, 1)), (0, (5, 2))]


def frames(recording: Recording, body: str) -> list[tuple[float, np.ndarray, np.ndarray]]:
    """Times [s], positions [m] and von Mises stresses [Pa] of a body's nodes at the field times."""
    (mesh,), result = recording.of(f"/reference/{body}"), []
    for stress in recording.of(f"/stress/{body}"):
        values = next(unpack(array) for array in stress.nodal if array.name == "von_mises_pa")
        result.append((stress.time_s, positions(mesh, stress), values.astype(float)))
    return result


def cut(x: np.ndarray, values: np.ndarray, hexes: np.ndarray, origin: np.ndarray, normal: np.ndarray):
    """Points and values of the polygons in which a plane cuts the mesh, and their triangles."""
    height = (x - origin) @ normal
    tets = hexes[:, TETRAHEDRA].reshape(-1, 4)
    above = height[tets] > 0
    crossed = tets[above.any(axis=1) & ~above.all(axis=1)]
    points, stress, triangles = [], [], []
    for tet in crossed:
        corners = []
        for a, b in EDGES:
            i, j = tet[a], tet[b]
            if (height[i] > 0) != (height[j] > 0):
                s = height[i] / (height[i] - height[j])
                corners.append((x[i] + s * (x[j] - x[i]), values[i] + s * (values[j] - values[i])))
        first = len(points)
        points += [c[0] for c in corners]
        stress += [c[1] for c in corners]
        # With the edges in this order, corners 0 1 2 and 1 2 3 make up a quadrilateral.
        triangles += [(first, first + 1, first + 2)] + [(first + 1, first + 2, first + 3)] * (len(corners) == 4)
    return np.array(points).reshape(-1, 3), np.array(stress), np.array(triangles).reshape(-1, 3)


def plane(recording: Recording) -> tuple[np.ndarray, np.ndarray, np.ndarray, float]:
    """Origin, in-plane axes (across, along the impact) and half width [m] of the pictures."""
    meshes = {t.removeprefix("/reference/"): recording.of(t)[0] for t in recording.topics("/reference/")}
    positions = {name: unpack(mesh.positions) for name, mesh in meshes.items()}
    projectile = next((n for n, m in meshes.items() if m.role == "projectile"), next(iter(meshes)))
    target = next((n for n, m in meshes.items() if m.role == "tissue"), list(meshes)[-1])
    flight = meshes[projectile].flight_velocity_m_per_s
    impact = np.array([flight.x, flight.y, flight.z])
    impact = impact / np.linalg.norm(impact) if np.linalg.norm(impact) > 0 else np.array([0.0, 0.0, -1.0])
    extent = np.ptp(positions[target], axis=0)
    normal = np.eye(3)[np.argmax(extent * (1 - np.abs(impact)))]
    normal = normal - impact * (normal @ impact)
    normal /= np.linalg.norm(normal)
    touches = (unpack(a) for m in recording.of("/contact/forces") for p in m.pairs for a in p.contacts
               if a.name == "position_m" and a.count)  # fmt: skip
    origin = next(touches, positions[projectile]).reshape(-1, 3).mean(axis=0).astype(float)
    half = 1.1 * np.ptp(positions[projectile], axis=0).max()
    # A little beside the planes of symmetry, where meshes like to have their nodes.
    return origin + 1e-3 * half * normal, np.cross(normal, impact), -impact, half


def draw_cuts(figure, grid, recording: Recording) -> None:
    """The cuts at four times."""
    top = json.loads(recording.metadata["contuse.run"]["colour_range_pa"])[1]
    origin, across, up, half = plane(recording)
    bodies = [t.removeprefix("/stress/") for t in recording.topics("/stress/")]
    data = {body: frames(recording, body) for body in bodies}
    hexes = {body: unpack(recording.of(f"/reference/{body}")[0].hexes).astype(int) for body in bodies}
    times = np.array([frame[0] for frame in data[bodies[0]]])
    axes = [figure.add_subplot(grid[0, i]) for i in range(4)]
    for axis, fraction in zip(axes, (0.25, 0.5, 0.75, 1.0)):
        index = int(np.argmin(np.abs(times - fraction * times[-1])))
        for body in bodies:
            _, x, stress = data[body][index]
            points, values, triangles = cut(x, stress, hexes[body], origin, np.cross(across, up))
            if len(triangles):
                u, v = 1e3 * (points - origin) @ across, 1e3 * (points - origin) @ up
                shown = axis.tripcolor(u, v, triangles, values / 1e3, shading="gouraud", vmin=0, vmax=top / 1e3)
        axis.set(xlim=(-1e3 * half, 1e3 * half), ylim=(-1e3 * half, 1e3 * half), aspect="equal", xlabel="mm")
        axis.set_title(f"{1e6 * times[index]:.0f} µs")
    axes[0].set_ylabel("mm")
    figure.colorbar(shown, ax=axes, label="von Mises stress [kPa]", extend="max", fraction=0.02, pad=0.01)


def draw_force(axis, recording: Recording, window: float) -> None:
    """Force of each pair, averaged over the window."""
    messages = recording.of("/contact/forces")
    times = np.array([m.time_s for m in messages])
    for index, pair in enumerate(messages[0].pairs):
        impulse = np.array([[getattr(m.pairs[index].impulse_n_s, c) for c in "xyz"] for m in messages])
        earlier = np.stack([np.interp(times - window, times, impulse[:, c], left=0.0) for c in range(3)], axis=1)
        force = np.linalg.norm(impulse - earlier, axis=1) / window
        middle = 1e6 * (times - window / 2)
        axis.plot(middle, force, linestyle=STYLES[index % len(STYLES)], label=pair.pair)
    axis.set(xlabel="time [µs]", ylabel=f"force over {1e6 * window:g} µs [N]", xlim=(0, 1e6 * times[-1]))
    axis.legend()


def draw_energy(axis, recording: Recording) -> None:
    """The ledger, with its sum."""
    messages = recording.of("/energy")
    times = 1e6 * np.array([m.time_s for m in messages])
    curves = {f"{b.body}: kinetic + strain": [m.bodies[i].kinetic_j + m.bodies[i].strain_j for m in messages]
              for i, b in enumerate(messages[0].bodies)}  # fmt: skip
    curves["viscous"] = [sum(b.viscous_j for b in m.bodies) for m in messages]
    curves["friction"] = [sum(p.friction_j for p in m.pairs) for m in messages]
    curves["numerical contact"] = [sum(p.numerical_contact_j for p in m.pairs) for m in messages]
    for (name, values), style in zip(curves.items(), STYLES * len(curves)):
        axis.plot(times, values, linestyle=style, label=name)
    axis.plot(times, [m.total_j - m.external_work_j for m in messages], color="black", linewidth=2, label="sum")
    axis.set(xlabel="time [µs]", ylabel="energy [J]", xlim=(0, times[-1]), ylim=(0, None))
    axis.legend(fontsize="small")


def main() -> None:
    """Draws one file."""
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    recording = read(sys.argv[1])
    results = recording.json("summary.json")
    results = results.get("results") or results["withheld"]["values"]
    figure = plt.figure(figsize=(15, 8.5), layout="constrained")
    rows = figure.add_gridspec(2, 1, height_ratios=[1, 0.95])
    draw_cuts(figure, rows[0].subgridspec(1, 4), recording)
    curves = rows[1].subgridspec(1, 2)
    summary = recording.json("summary.json")
    window = results["impacts"][0].get("force_window_s") or summary["time_s"] / 50
    draw_force(figure.add_subplot(curves[0, 0]), recording, window)
    draw_energy(figure.add_subplot(curves[0, 1]), recording)
    run = recording.metadata["contuse.run"]
    figure.suptitle(f"{run['scene']} ({run['engine']} {run['engine_version']})")
    figure.savefig(sys.argv[2], dpi=110)


if __name__ == "__main__":
    main()
