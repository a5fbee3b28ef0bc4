"""Draws how the four numbers of an impact and their error bars change as the mesh is refined.

    python examples/bars_picture.py contuse scenarios/flashball_thigh/scene.json docs/pictures/bars.svg 100 10 5 2

runs the scene to each of these accuracies [%], within ten minutes each, and draws the mesh that each one ends on.
"""

import json
import subprocess
import sys
import tempfile
from pathlib import Path

import matplotlib

matplotlib.use("svg")
matplotlib.rcParams["svg.hashsalt"] = "bars"
import matplotlib.pyplot as plt

Bar = tuple[float, float]


def numbers(summary: dict) -> dict[str, Bar]:
    """The four numbers with their error bars."""
    results = summary["results"]
    impact = results["impacts"][results["headline"]["impact"]]
    tissue = results["tissue"]
    stress = tissue["significant_stress"][results["headline"]["significant_stress"]]
    of = {
        "peak force [N]": impact["peak_force_n"],
        "largest contact patch [mm²]": impact["largest_patch_area_mm2"],
        f"depth of {stress['threshold_pa'] / 1e3:g} kPa [mm]": stress["depth_mm"],
        "energy given to the tissue [J]": tissue["energy_given_j"],
    }
    return {name: (number["value"], number["error"]["total"]) for name, number in of.items()}


def run(contuse: str, scene: str, percent: str) -> tuple[float, dict[str, Bar]]:
    """Numbers of elements relative to the scene's own, and the numbers on that mesh."""
    with tempfile.TemporaryDirectory() as scratch:
        command = [contuse, "run", scene, "--accuracy", f"{percent}%", "--within", "10min", "--json", "-q", "-o", str(Path(scratch) / "run.mcap")]
        summary = json.loads(subprocess.run(command, check=True, capture_output=True).stdout)
    return summary["accuracy"]["mesh_factor"], numbers(summary)


def main() -> None:
    """Runs the scene and draws."""
    contuse, scene, picture, *percents = sys.argv[1:]
    # Two accuracies may end on one mesh.
    meshes = dict(run(contuse, scene, percent) for percent in percents)
    factors = sorted(meshes)
    figure, axes = plt.subplots(2, 2, figsize=(8, 5.2), sharex=True, layout="constrained")
    for axis, name in zip(axes.flat, meshes[factors[0]]):
        values, errors = zip(*(meshes[factor][name] for factor in factors))
        axis.errorbar(range(len(factors)), values, errors, fmt="o", capsize=4, color="#1f77b4")
        axis.axhline(values[-1], color="#888888", linewidth=0.8)
        axis.set_title(name, fontsize=10)
        axis.set_xticks(range(len(factors)), [f"× {factor:.3g}" for factor in factors])
    figure.supxlabel("numbers of elements, relative to the scene's own; the line is the value on the finest mesh", fontsize=9)
    figure.savefig(picture, metadata={"Date": None})


if __name__ == "__main__":
    main()
