"""Draws a series of VTK files with PyVista, without a screen: the thigh cut open, the ball, and the contacts on it.

    contuse run scenarios/flashball_thigh/scene.json -o flashball_thigh.pvd
    python examples/paraview_picture.py flashball_thigh.pvd docs/pictures/paraview.png

ParaView shows the same after Open, Apply, Clip and Glyph.
"""

import sys

import numpy as np
import pyvista

TIME_S = 7.5e-5
TOP_PA = 1e5


def main() -> None:
    """Draws one field time."""
    series, picture = sys.argv[1:]
    reader = pyvista.get_reader(series)
    reader.set_active_time_value(min(reader.time_values, key=lambda time: abs(time - TIME_S)))
    blocks = list(reader.read())
    bodies = {str(block.field_data["body"][0]): block for block in blocks if "body" in block.field_data}
    contacts = [block for block in blocks if "pair" in block.field_data and block.n_points]
    plotter = pyvista.Plotter(off_screen=True, window_size=(840, 520))
    colours = {"scalars": "von_mises_pa", "clim": (0, TOP_PA), "cmap": "viridis", "show_scalar_bar": False}
    ball, thigh = bodies["flashball"], bodies["thigh"]
    middle = np.array(ball.center)
    for body in (ball, thigh):
        # Whole elements on the far side of the plane through the middle of the ball.
        far = body.extract_cells(np.flatnonzero(body.cell_centers().points[:, 1] >= middle[1]))
        shown = plotter.add_mesh(far, show_edges=True, edge_color="#404040", line_width=0.5, **colours)
    for points in contacts:
        force = points.point_data["normal"] * points.point_data["normal_force_n"][:, None] + points.point_data["tangential_force_n"]
        points.point_data["force_n"] = force
        largest = np.linalg.norm(force, axis=1).max()
        arrows = points.glyph(orient="force_n", scale="force_n", factor=0.012 / largest)
        plotter.add_mesh(arrows, color="#d62728", show_scalar_bar=False)
    bar = {"n_labels": 5, "fmt": "%.0f", "color": "black", "vertical": False, "width": 0.4, "position_x": 0.03, "position_y": 0.86}
    plotter.add_scalar_bar("von Mises stress [Pa]", mapper=shown.mapper, title_font_size=16, label_font_size=14, **bar)
    plotter.set_background("white")
    plotter.camera_position = [tuple(middle + [0.0, -0.15, 0.045]), tuple(middle - [0, 0, 0.015]), (0, 0, 1)]
    plotter.screenshot(picture)
    print(f"{picture}: {reader.active_time_value} s")


if __name__ == "__main__":
    main()
