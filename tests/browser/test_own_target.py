"""A scan of the reader's own, on the page alone: from the file to the summary."""

import json
import re

import pytest
from axe_playwright_python.sync_playwright import Axe
from playwright.sync_api import expect

# A limb along y of 48 mm diameter: voxels of 2 mm; muscle without a name, fat and a bone with theirs, as 3D Slicer names them.
COUNT, LENGTH, VOXEL = 26, 16, 2.0
HEADER = """NRRD0004
type: uchar
dimension: 3
space: right-anterior-superior
sizes: {0} {1} {0}
space directions: ({2},0,0) (0,{2},0) (0,0,{2})
space origin: ({3},{4},{3})
encoding: raw
Segment0_LabelValue:=2
Segment0_Name:=subcutaneous fat
Segment1_LabelValue:=3
Segment1_Name:=femur

"""


def scan():
    def label(i, k):
        radius = VOXEL * ((i - (COUNT - 1) / 2) ** 2 + (k - (COUNT - 1) / 2) ** 2) ** 0.5
        return 3 if radius < 7 else 1 if radius < 17 else 2 if radius < 24 else 0

    middle = [-VOXEL * (n - 1) / 2 for n in (COUNT, LENGTH)]
    header = HEADER.format(COUNT, LENGTH, VOXEL, *middle)
    return header.encode() + bytes(label(i, k) for k in range(COUNT) for _ in range(LENGTH) for i in range(COUNT))


@pytest.fixture
def panel(page):
    page.goto("/")
    page.goto("/#/new")
    panel = page.locator(".own-target")
    panel.locator("summary").first.click()
    yield panel
    assert page.watch.errors == []


def choose(panel, name, content):
    panel.locator("input[type=file]").set_input_files({"name": name, "mimeType": "application/octet-stream", "buffer": content})


def at_every_size(page, pictures, name):
    """Nothing is wider than the page, and axe-core finds no fault."""
    for width, height in ((1440, 900), (820, 1180), (390, 844)):
        page.set_viewport_size({"width": width, "height": height})
        assert page.evaluate("document.documentElement.scrollWidth") <= width
        assert Axe().run(page).response["violations"] == []
        if pictures:
            page.screenshot(path=pictures / f"{name}-{width}.png", full_page=True)
    page.set_viewport_size({"width": 1440, "height": 1000})


def tissue_of(scene):
    return next(body for body in scene["bodies"] if body["role"] == "tissue")


def scene_of(page):
    return json.loads(page.get_by_label("Scene as JSON").input_value())


def test_what_is_no_mesh_is_refused_with_its_reason(page, panel):
    choose(panel, "thigh.nrrd", scan()[:3000])
    expect(panel.locator(".alert")).to_contain_text("thigh.nrrd cannot be used")
    expect(panel.locator(".alert")).to_contain_text("the file ends here")
    expect(panel.locator("progress")).to_be_hidden()


def test_a_scan_becomes_the_target_of_an_impact(page, panel, pictures):
    choose(panel, "thigh.seg.nrrd", scan())
    expect(panel).to_contain_text("voxels with labels")
    expect(panel).to_contain_text("box 48 × 32 × 48 mm")
    expect(panel.locator("progress")).to_be_hidden()
    # Names say what fat and bone are; of the other label nothing is known.
    fat, bone, other = (panel.get_by_label(f"What is {name}?") for name in ("subcutaneous fat", "femur", "label_1"))
    expect(fat).to_have_value(re.compile("^fat/"))
    expect(bone).to_have_value("fixed")
    expect(other).to_have_value("")
    # It comes from above, onto the middle.
    z = panel.get_by_label("Point of impact, z [mm]")
    expect(z).to_have_value("24")
    use_it = panel.get_by_role("button", name="Use it as the target")
    use_it.click()
    expect(panel).to_contain_text("Still missing: what label_1 is")
    other.select_option("muscle/zhai_2019_ogden")
    panel.get_by_label("What hits?").select_option("own")
    panel.get_by_label("Diameter [mm]").fill("30")
    panel.get_by_label("Mass [g]").fill("50")
    panel.get_by_label("Speed [m/s]").fill("8")
    panel.get_by_label("Size of the elements [mm]").fill("8")
    panel.get_by_label("Size at the impact [mm]").fill("4")
    panel.get_by_label("Time to simulate [ms]").fill("1")
    panel.get_by_label("Point of impact, y [mm]").fill("2")
    panel.get_by_label("From where?").select_option("0,0,-1")
    at_every_size(page, pictures, "own-target")
    use_it.click()
    expect(page.get_by_label("Scene as JSON")).to_have_value(re.compile('"hole": "femur"'))
    scene = scene_of(page)
    tissue = tissue_of(scene)
    labels = {entry["label"]: entry for entry in tissue["mesh"]["segmentation"]["labels"]}
    assert labels[3] == {"label": 3, "hole": "femur"} and tissue["fixed"] == [{"set": "femur"}]
    ball = scene["bodies"][0]
    assert ball["rigid"]["mass_kg"] == 0.05 and ball["velocity_m_per_s"] == [0, 0, -8]
    assert abs(ball["rigid"]["center_m"][1] - 0.002) < 1e-9
    expect(page.get_by_text("ready to run")).to_be_visible()
    page.get_by_role("button", name="Run this impact").click()
    page.wait_for_url(re.compile("#/job/"))
    expect(page.get_by_label("The four numbers")).to_be_visible()
    expect(page.locator("h1")).to_contain_text("thigh")


def test_a_scan_is_cropped_around_the_impact_and_gets_a_skin(page, panel, pictures):
    choose(panel, "thigh.seg.nrrd", scan())
    panel.get_by_label("What is label_1?").select_option("muscle/zhai_2019_ogden")
    cropped, lengths = panel.get_by_label("only a box around the impact"), panel.get_by_label("Lengths of the box, z [mm]")
    # The whole of this small scan is fine enough; its ends along y are all that can be held.
    expect(lengths).to_be_hidden()
    expect(panel.get_by_label("Point of impact, z [mm]")).to_have_value("24")
    assert panel.locator(".held label").all_inner_texts() == ["y_min", "y_max"]
    size = float(panel.get_by_label("Size of the elements [mm]").input_value())
    cropped.check()
    expect(lengths).to_be_visible()
    for axis, length in zip("xyz", (28, 20, 30), strict=True):
        panel.get_by_label(f"Lengths of the box, {axis} [mm]").fill(str(length))
    expect(panel.locator(".held label")).to_have_text(["x_min", "x_max", "y_min", "y_max", "z_min"])
    assert float(panel.get_by_label("Size of the elements [mm]").input_value()) < size
    panel.get_by_label("z_min").check()
    panel.get_by_label("Size of the elements [mm]").fill("4")
    panel.get_by_label("Size at the impact [mm]").fill("2")
    use_it = panel.get_by_role("button", name="Use it as the target")
    skin = panel.get_by_label("Thickness of the skin [mm]")
    skin.fill("-2")
    use_it.click()
    expect(panel).to_contain_text("Still missing: the thickness of the skin")
    expect(skin).to_have_attribute("aria-invalid", "true")
    skin.fill("2")
    expect(skin).not_to_have_attribute("aria-invalid", "true")
    use_it.click()
    expect(page.get_by_label("Scene as JSON")).to_have_value(re.compile('"segmentation"'))
    expect(page.get_by_text("ready to run")).to_be_visible()
    tissue = tissue_of(scene_of(page))
    segmentation = tissue["mesh"]["segmentation"]
    assert segmentation["crop"] == {"center_m": segmentation["near"][0]["point_m"], "size_m": [0.028, 0.02, 0.03]}
    assert segmentation["skin_thickness_m"] == 0.002
    assert next(part for part in tissue["parts"] if part["part"] == "skin")["material"]["library"].startswith("skin/")
    # The bone is below the box.
    assert tissue["fixed"] == [{"set": "z_min"}]
    # The section of the labels with the box.
    picture = page.locator(".geometry svg")
    expect(picture).to_have_attribute("aria-label", re.compile("femur 12 mm"))
    expect(picture.locator(".crop")).to_have_count(1)
    expect(picture).to_contain_text("section at y = 0 mm")
    at_every_size(page, pictures, "own-scan-cropped")
    # What the service refuses stands at the field that says it.
    panel.get_by_label("Size at the impact [mm]").fill("6")
    panel.get_by_label("Size of the elements [mm]").fill("0.05")
    use_it.click()
    expect(page.get_by_text("not yet")).to_be_visible()
    expect(panel.get_by_label("Size of the elements [mm]")).to_have_attribute("aria-invalid", "true")
    expect(panel).to_contain_text("elements or more, of which at most")


def block(n=(4, 4, 3), size=20):
    """A block in millimetres as Abaqus writes it: muscle under skin, held at the bottom."""
    nx, ny, nz = n
    node = lambda i, j, k: 1 + i + (nx + 1) * (j + (ny + 1) * k)
    nodes = [(node(i, j, k), i * size, j * size, k * size) for k in range(nz + 1) for j in range(ny + 1) for i in range(nx + 1)]
    cells = [(i, j, k) for k in range(nz) for j in range(ny) for i in range(nx)]
    corners = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (0, 0, 1), (1, 0, 1), (1, 1, 1), (0, 1, 1)]
    lines = ["*NODE", *(", ".join(map(str, one)) for one in nodes)]
    for part, is_own in (("muscle", lambda k: k < nz - 1), ("skin", lambda k: k == nz - 1)):
        lines.append(f"*ELEMENT, TYPE=C3D8, ELSET={part}")
        lines += [", ".join(map(str, [1 + e, *(node(i + a, j + b, k + c) for a, b, c in corners)])) for e, (i, j, k) in enumerate(cells) if is_own(k)]
    lines += ["*NSET, NSET=bottom", *(str(node(i, j, 0)) for j in range(ny + 1) for i in range(nx + 1))]
    return "\n".join(lines).encode()


def test_a_mesh_in_millimetres_becomes_the_target(page, panel, pictures):
    choose(panel, "block.inp", block())
    unit = panel.get_by_label("Unit of the file")
    expect(unit).to_have_value("0.001")
    expect(panel).to_contain_text("box 80 × 80 × 60 mm")
    expect(panel.get_by_label("What is muscle?")).to_have_value(re.compile("^muscle/"))
    expect(panel.get_by_label("bottom")).to_be_checked()
    expect(panel.get_by_label("Size of the elements [mm]")).to_have_count(0)
    panel.get_by_label("From where?").select_option("-1,0,0")
    expect(panel.get_by_label("Point of impact, x [mm]")).to_have_value("80")
    panel.get_by_role("button", name="Use it as the target").click()
    expect(page.get_by_label("Scene as JSON")).to_have_value(re.compile('"scale": 0.001'))
    scene = scene_of(page)
    tissue = scene["bodies"][1]
    assert tissue["placement"] == {"scale": 0.001} and tissue["fixed"] == [{"set": "bottom"}]
    assert scene["bodies"][0]["velocity_m_per_s"] == [-10, 0, 0]
    expect(page.get_by_text("ready to run")).to_be_visible()
    # Its section is drawn, here with the layer of skin at the top.
    picture = page.locator(".geometry svg")
    expect(picture).to_have_attribute("aria-label", re.compile("muscle 80 mm, skin 80 mm"))
    at_every_size(page, pictures, "own-mesh")


def test_the_unit_of_a_mesh_scales_it_and_where_it_is_hit(page, panel):
    choose(panel, "block.inp", block(size=2))
    # Six units high: in metres that is no part of a person, so it is millimetres, which here it is not.
    unit, top = panel.get_by_label("Unit of the file"), panel.get_by_label("Point of impact, z [mm]")
    expect(unit).to_have_value("0.001")
    expect(top).to_have_value("6")
    unit.select_option("cm")
    expect(top).to_have_value("60")
    expect(panel).to_contain_text("box 80 × 80 × 60 mm")
    panel.get_by_label("From where?").select_option("0,1,0")
    expect(panel.get_by_label("Point of impact, y [mm]")).to_have_value("0")
    panel.get_by_role("button", name="Use it as the target").click()
    expect(page.get_by_label("Scene as JSON")).to_have_value(re.compile('"scale": 0.01'))
    ball, tissue = scene_of(page)["bodies"]
    assert tissue["placement"] == {"scale": 0.01}
    assert abs(ball["rigid"]["center_m"][2] - 0.03) < 1e-9 and ball["velocity_m_per_s"] == [0, 10, 0]
    # Cut along the path, which is that of y.
    expect(page.locator(".geometry svg")).to_contain_text("section at x = 40 mm")
    expect(page.locator(".geometry svg")).to_have_attribute("aria-label", re.compile("muscle 80 mm"))


def brick(name, *half):
    """A box around the origin in millimetres, as a program writes a segment: ASCII STL, named after its file."""
    at = lambda n: " ".join(str(h if n >> k & 1 else -h) for k, h in enumerate(half))
    faces = [(0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5)]
    triangles = [nodes for a, b, c, d in faces for nodes in ((a, b, c), (a, c, d))]
    lines = [["facet normal 0 0 0", "outer loop", *(f"vertex {at(n)}" for n in nodes), "endloop", "endfacet"] for nodes in triangles]
    return {"name": name, "mimeType": "model/stl", "buffer": "\n".join(["solid", *sum(lines, []), "endsolid", ""]).encode()}


def test_closed_surfaces_in_each_other_become_the_target(page, panel, pictures):
    files = panel.locator("input[type=file]")
    nest = [brick("femur.stl", 7, 20, 7), brick("subcutaneous fat.stl", 35, 35, 24), brick("muscle.stl", 31, 31, 20)]
    files.set_input_files([nest[0], {"name": "block.inp", "mimeType": "text/plain", "buffer": block()}])
    expect(panel.locator(".alert")).to_contain_text("choose one file, or several closed surfaces")
    opened = {**nest[2], "buffer": nest[2]["buffer"].replace(b"vertex 31 31 20", b"vertex 31 31 21", 1)}
    files.set_input_files([nest[1], opened])
    expect(panel.locator(".alert")).to_contain_text("muscle.stl cannot be used")
    files.set_input_files(nest)
    expect(panel).to_contain_text("36 triangles")
    expect(panel).to_contain_text("box 70 × 70 × 48 mm")
    for name, use in (("subcutaneous fat", "^fat/"), ("muscle", "^muscle/"), ("femur", "^fixed$")):
        expect(panel.get_by_label(f"What is {name}?")).to_have_value(re.compile(use))
    # One unit for all; sizes of elements follow it, so that of a larger body a box is enough.
    unit, top, size = panel.get_by_label("Unit of the file"), panel.get_by_label("Point of impact, z [mm]"), panel.get_by_label("Size of the elements [mm]")
    cropped = panel.get_by_label("only a box around the impact")
    expect(cropped).not_to_be_checked()
    expect(unit).to_have_value("0.001")
    expect(top).to_have_value("24")
    unit.select_option("cm")
    expect(top).to_have_value("240")
    expect(cropped).to_be_checked()
    unit.select_option("mm")
    expect(top).to_have_value("24")
    expect(cropped).not_to_be_checked()
    assert float(size.input_value()) == 3.4
    # Elements larger than a layer lose it, which is an error with its remedy; the proposed sizes are small enough.
    near = panel.get_by_label("Size at the impact [mm]")
    proposed = near.input_value()
    panel.get_by_label("Time to simulate [ms]").fill("0.5")
    size.fill("12")
    near.fill("6")
    panel.get_by_role("button", name="Use it as the target").click()
    expect(page.get_by_label("Scene as JSON")).to_have_value(re.compile('"hole": "femur"'))
    expect(page.get_by_text('elements too large for "subcutaneous fat"').first).to_be_visible()
    expect(page.get_by_role("button", name="Run this impact")).to_be_disabled()
    size.fill("3.4")
    near.fill(proposed)
    panel.get_by_role("button", name="Use it as the target").click()
    expect(page.get_by_text('elements too large for "subcutaneous fat"')).to_have_count(0)
    expect(page.get_by_text("ready to run")).to_be_visible()
    tissue = tissue_of(scene_of(page))
    surfaces = tissue["mesh"]["segmentation"]["surfaces"]
    assert [surface.get("part") for surface in surfaces] == ["subcutaneous fat", "muscle", None]
    assert all(surface["scale"] == 0.001 for surface in surfaces) and tissue["fixed"] == [{"set": "femur"}]
    # Their sections are drawn in each other.
    picture = page.locator(".geometry svg")
    expect(picture).to_have_attribute("aria-label", re.compile("70 mm, muscle 62 mm, femur 14 mm"))
    at_every_size(page, pictures, "own-surfaces")
    page.get_by_role("button", name="Run this impact").click()
    page.wait_for_url(re.compile("#/job/"))
    expect(page.get_by_label("The four numbers")).to_be_visible()
