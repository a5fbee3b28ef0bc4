"""Checks a series of VTK files with PyVista: it holds what the recording of the same run holds.

    python tests/python/check_vtu.py RECORDING.mcap SERIES.pvd

Prints what was compared and exits with 1 and a reason at the first difference.
"""

import pathlib
import sys
import xml.etree.ElementTree as ET

import numpy as np
import pyvista
from recording import Recording, positions, read, unpack

VERTEX, TRIANGLE, HEXAHEDRON = 1, 5, 12
NODES = {10: 4, 12: 8, 13: 6, 24: 10}
PAIR_NUMBERS = ["patch_area_m2", "patch_long_axis_m", "patch_short_axis_m", "peak_pressure_pa", "patch_nodes", "nodes_across_patch"]


class Different(Exception):
    """Where series and recording differ."""


def need(condition: bool, reason: str) -> None:
    """Says what differs unless the condition holds."""
    if not condition:
        raise Different(reason)


def same(found: np.ndarray, wanted: np.ndarray, what: str) -> None:
    """Equal shapes and equal numbers, to the last bit."""
    need(found.shape == wanted.shape, f"{what}: {found.shape} numbers, not {wanted.shape}")
    need(np.array_equal(found, wanted), f"{what} differs by up to {np.abs(found.astype(float) - wanted).max(initial=0)}")


def blocks_of(pvd: pathlib.Path) -> dict[float, dict[str, object]]:
    """The grids of each time by name, as PyVista reads them; the names are those that ParaView shows."""
    names: dict[float, list[str]] = {}
    for dataset in ET.parse(pvd).getroot()[0].findall("DataSet"):
        names.setdefault(float(dataset.attrib["timestep"]), []).append(dataset.attrib["name"])
    reader = pyvista.get_reader(pvd)
    need(list(names) == list(reader.time_values), "the times are not in order")
    series = {}
    for time, of_time in names.items():
        reader.set_active_time_value(time)
        grids = list(reader.read())
        need(len(grids) == len(of_time) and list(names.values())[0] == of_time, f"at {time} s there are other parts")
        for grid in grids:
            need(float(grid.field_data["TimeValue"][0]) == time, f"a file of {time} s says another time")
        series[time] = dict(zip(of_time, grids))
    return series


def cells_of(mesh) -> tuple[np.ndarray, list[np.ndarray]]:
    """VTK's types of the cells of a reference mesh, and the nodes of each."""
    if mesh.DESCRIPTOR.name == "ReferenceMesh":
        nodes = unpack(mesh.hexes)
        return np.full(len(nodes), HEXAHEDRON), list(nodes)
    types = unpack(mesh.cell_types)
    ends = np.cumsum([NODES[int(kind)] for kind in types])
    return types, np.split(unpack(mesh.cell_nodes), ends[:-1])


def check_cells(grid, mesh, kept: np.ndarray, what: str) -> None:
    """The cells are those of the reference mesh that are kept."""
    types, nodes = cells_of(mesh)
    same(grid.celltypes, types[kept], f"{what}: types of cells")
    same(grid.cell_connectivity, np.concatenate([nodes[i] for i in kept]), f"{what}: nodes of cells")
    same(grid.cell_data["part"], unpack(mesh.part_of)[kept], f"{what}: parts")
    need(list(grid.field_data["parts"]) == list(mesh.parts), f"{what}: names of parts")


def check_deformable(recording: Recording, series: dict) -> str:
    """Positions, fields and cells of the deformable bodies."""
    count = 0
    for topic in recording.topics("/reference/"):
        name, mesh = topic.removeprefix("/reference/"), recording.of(topic)[0]
        stresses = recording.of(f"/stress/{name}")
        need([s.time_s for s in stresses] == list(series), f"{mesh.body}: the times are not the field times")
        for stress in stresses:
            grid, what = series[stress.time_s][mesh.body], f"{mesh.body} at {stress.time_s} s"
            same(grid.points, positions(mesh, stress).astype("<f4"), f"{what}: positions")
            need(set(grid.point_data) == {a.name for a in stress.nodal}, f"{what}: nodal fields")
            for array in stress.nodal:
                same(grid.point_data[array.name], unpack(array), f"{what}: {array.name}")
            element = {a.name: unpack(a) for a in stress.element}
            kept = np.arange(len(unpack(mesh.part_of)))
            if "eroded" in element:
                kept = kept[element.pop("eroded") == 0]
                same(grid.cell_data["element"], kept, f"{what}: elements that are not eroded")
            need(set(grid.cell_data) - {"element", "part"} == set(element), f"{what}: fields of elements")
            for field, values in element.items():
                same(grid.cell_data[field], values[kept], f"{what}: {field}")
            check_cells(grid, mesh, kept, what)
            count += len(grid.point_data) + len(grid.cell_data) + 1
        check_orientation(series[stresses[0].time_s][mesh.body], mesh.body)
    return f"{count} arrays of deformable bodies"


def check_orientation(grid, what: str) -> None:
    """Nodes are in VTK's order: the outward surface encloses the sum of the volumes of the cells."""
    # The other algorithm turns the sides of wedges around.
    is_linear = not (grid.celltypes == pyvista.CellType.QUADRATIC_TETRA).any()
    options = {"algorithm": "geometry"} if is_linear else {"algorithm": "dataset_surface", "nonlinear_subdivision": 0}
    surface = grid.extract_surface(**options).triangulate()
    volumes = grid.compute_cell_sizes(length=False, area=False)["Volume"]
    need(bool((volumes > 0).all()), f"{what}: a cell is inside out")
    a, b, c = (surface.points.astype(float)[surface.regular_faces[:, i]] for i in range(3))
    enclosed = float(np.einsum("ij,ij->i", a, np.cross(b, c)).sum()) / 6
    # Faces that are not plane are triangles on one side and bilinear on the other.
    need(abs(enclosed - volumes.sum()) <= 0.02 * enclosed, f"{what}: {enclosed} m³ enclosed, {volumes.sum()} m³ of cells")


def check_rigid(recording: Recording, series: dict) -> str:
    """Surfaces of the rigid bodies, placed by their poses."""
    count = 0
    for topic in recording.topics("/pose/"):
        name = topic.removeprefix("/pose/")
        poses = {pose.time_s: pose for pose in recording.of(topic)}
        surfaces = recording.of(f"/mesh/{name}")
        need(len(surfaces) == len(series), f"{name}: the times are not the field times")
        for (time, blocks), update in zip(series.items(), surfaces):
            entity = update.entities[0]
            grid, mesh, pose = blocks[entity.id], entity.triangles[0], poses[time]
            q, centre = pose.orientation, pose.position_m
            axis, local = np.array([q.x, q.y, q.z]), np.array([[p.x, p.y, p.z] for p in mesh.points])
            # R(q) x = x + 2 w (a × x) + 2 a × (a × x)
            turned = local + 2 * q.w * np.cross(axis, local) + 2 * np.cross(axis, np.cross(axis, local))
            placed = turned + [centre.x, centre.y, centre.z]
            need(np.allclose(grid.points, placed, rtol=2e-7, atol=1e-9), f"{name} at {time} s: positions")
            same(grid.cells_dict[TRIANGLE].ravel(), np.array(mesh.indices), f"{name} at {time} s: triangles")
            count += 1
    return f"{count} surfaces of rigid bodies"


def check_contacts(recording: Recording, series: dict) -> str:
    """The contacts of each pair, and its numbers."""
    points = 0
    at_field_times = [m for m in recording.of("/contact/forces") if m.time_s in series]
    for message in at_field_times:
        for pair in message.pairs:
            grid, what = series[message.time_s][f"contact {pair.pair}"], f"contacts of {pair.pair} at {message.time_s} s"
            arrays = {a.name: unpack(a) for a in pair.contacts}
            same(grid.points, arrays.pop("position_m").reshape(-1, 3), f"{what}: positions")
            need(set(grid.point_data) == set(arrays) and set(grid.celltypes) <= {VERTEX}, f"{what}: arrays")
            for name, values in arrays.items():
                same(grid.point_data[name], values, f"{what}: {name}")
            fields = {name: np.ravel(grid.field_data[name]) for name in ["force_n", "impulse_n_s", *PAIR_NUMBERS]}
            for name in ["force_n", "impulse_n_s"]:
                vector = getattr(pair, name)
                same(fields[name], np.array([vector.x, vector.y, vector.z]), f"{what}: {name}")
            for name in PAIR_NUMBERS:
                same(fields[name], np.array([float(getattr(pair, name))]), f"{what}: {name}")
            points += grid.n_points
    need(not recording.of("/contact/forces") or len(at_field_times) == len(series), "contacts are not at the field times")
    return f"{points} contacts"


def main() -> None:
    """Compares one series with one recording."""
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    recording, series = read(sys.argv[1]), blocks_of(pathlib.Path(sys.argv[2]))
    try:
        print(f"{sys.argv[2]}: {len(series)} times of {len(next(iter(series.values())))} parts")
        print(f"  {check_deformable(recording, series)}, {check_rigid(recording, series)}, {check_contacts(recording, series)}")
    except Different as different:
        sys.exit(f"{sys.argv[2]}: {different}")


if __name__ == "__main__":
    main()
