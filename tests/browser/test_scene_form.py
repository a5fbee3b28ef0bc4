"""The form of a scene: its bodies in space before anything runs, what is wrong in its own units beside its fields, and studies."""

import json
import re

import pytest
from playwright.sync_api import expect

BALL, THIGH = "/bodies/0/mesh/generator", "/bodies/1/mesh/generator"


@pytest.fixture()
def form(page):
    page.goto("/")
    page.goto("/#/new")
    expect(page.get_by_text("ready to run")).to_be_visible()
    yield page
    assert page.watch.errors == []


def field(page, pointer):
    return page.locator(f'[data-pointer="{pointer}"]')


def put(page, pointer, text):
    """Types a text into a field, which may be in a folded section."""
    if not field(page, pointer).is_visible():
        page.evaluate("document.querySelectorAll('.scene-form details').forEach((one) => (one.open = true))")
    field(page, pointer).fill(text)


def error_at(page, pointer):
    """What stands at the only field that is marked."""
    expect(page.get_by_text("not yet")).to_be_visible()
    expect(field(page, pointer)).to_have_attribute("aria-invalid", "true")
    expect(page.locator(".field-error:not([hidden]):not(:empty)")).to_have_count(1)
    return page.locator(".field", has=field(page, pointer)).locator(".field-error").inner_text()


def test_the_bodies_are_seen_before_anything_runs(form):
    picture = form.locator(".scene-picture")
    expect(picture.locator("canvas")).to_be_visible()
    expect(picture).to_contain_text("velocity of flashball at 100 m/s")
    for layer in ("skin", "fat", "muscle", "bone"):
        expect(picture.locator(".layer-name", has_text=layer)).to_have_count(1)
    before = picture.screenshot()
    box = picture.locator("canvas").bounding_box()
    form.mouse.move(box["x"] + box["width"] / 2, box["y"] + box["height"] / 2)
    form.mouse.down()
    form.mouse.move(box["x"] + box["width"] / 2 + 120, box["y"] + box["height"] / 2, steps=4)
    form.mouse.up()
    form.wait_for_timeout(300)
    turned = picture.screenshot()
    assert turned != before, "a drag turns the bodies"
    # What is typed is what is seen; the old picture is pale until the service has answered.
    put(form, f"{BALL}/outer_radius_m", "14")
    expect(form.locator(".space.stale")).to_have_count(1)
    expect(form.locator(".space.stale")).to_have_count(0)
    assert picture.screenshot() != turned
    expect(form.get_by_text("ready to run")).to_be_visible()


def test_meshes_are_those_that_the_service_would_run(form):
    scene = form.evaluate("document.querySelector('.json textarea').value")
    answer = form.request.post("/v1/jobs/validate?geometry=true", data=scene, headers={"Content-Type": "application/json"}).json()
    assert [body["body"] for body in answer["geometry"]] == ["flashball", "thigh"]
    for body, drawn in zip(answer["bodies"], answer["geometry"]):
        assert len(drawn["cell_types"]) == body["elements"] == len(drawn["part_of"])
        assert len(drawn["positions_m"]) == 3 * body["nodes"]
        for k in range(3):
            along = drawn["positions_m"][k::3]
            assert min(along) == pytest.approx(body["bounding_box_m"][0][k], abs=1e-6)
            assert max(along) == pytest.approx(body["bounding_box_m"][1][k], abs=1e-6)
    plain = form.request.post("/v1/jobs/validate", data=scene, headers={"Content-Type": "application/json"}).json()
    assert "geometry" not in plain
    answer = form.request.post("/v1/jobs/validate?geometri=true", data=scene, headers={"Content-Type": "application/json"})
    assert answer.status == 400


@pytest.mark.parametrize("pointer, text, words, si", [
    (f"{BALL}/inner_radius_m", "20", "15 mm", "0.015"),
    (f"{BALL}/outer_radius_m", "-15", "> 0 mm", "metres"),
    (f"{BALL}/outer_radius_m", "wide", "a number is missing", "_m"),
    (f"{THIGH}/skin_thickness_m", "100", "mm", "0.0"),
    ("/end_time_s", "0", "0.1 to 10 ms", "1e-4"),
    ("/accuracy/time_budget_s", "0", "give it in seconds, such as 30", "ms"),
    ("/bodies/0/parts/0/material/bulk_modulus_pa", "0", "1 to 1000 kPa", "1e3"),
], ids=str)
def test_what_is_wrong_is_said_at_its_field_in_its_unit(form, pointer, text, words, si):
    put(form, pointer, text)
    said = error_at(form, pointer)
    assert words in said and si not in said and "/" not in said, said
    # The list leads to the field by its name; the pointer is for those who read JSON.
    listed = form.locator(".problems li")
    expect(listed).to_have_count(1)
    assert words in listed.inner_text() and pointer not in listed.inner_text()
    assert form.locator(".pointers code").all_text_contents() == [pointer]


@pytest.mark.parametrize("scene, once, words", [
    ({"accuracy": {"time_budget_s": 20}}, 0.4, "takes up to about 20 s: meshes are refined until errors are below 10 %"),
    ({"accuracy": {"time_budget_s": 20}}, 320, "takes at least about 5.3 min, more than the 20 s that it may"),
    ({"bodies": [{"mesh": {"generator": {}}}]}, 3, "takes about 4.0 s with its error bars"),
    ({"bodies": [{"mesh": {"file": "a.msh"}}]}, 2, "takes about 40 s with its error bars"),
    ({"bodies": [{"mesh": {"file": "a.msh"}}]}, 30, "takes about 30 s without error bars, which would take too long"),
    ({"solver": {"error_bars": "none"}}, 30, "takes about 30 s without error bars"),
], ids=str)
def test_the_time_is_that_of_the_whole_run(page, scene, once, words):
    page.goto("/")
    said = page.evaluate("async ([scene, once]) => (await import('/viewer/pages/run_time.js')).wholeRunWords(scene, once)", [scene, once])
    assert words in said, said


def test_fields_have_plain_names(form):
    grid = form.locator(".scene-form")
    form.evaluate("document.querySelectorAll('.scene-form details').forEach((one) => (one.open = true))")
    expect(grid.get_by_title("end_time_s", exact=True)).to_have_text("time to simulate [ms]")
    expect(grid.get_by_title("bulk_modulus_pa", exact=True).first).to_have_text("stiffness against compression (bulk modulus) [kPa]")


def test_words_of_the_document_are_choices_in_plain_words(form):
    schema = form.request.get("/scene.schema.json").json()["$defs"]
    words_of = lambda name: [one["const"] for one in schema[name]["oneOf"]]
    lists = {
        "role": "Role", "error_bars": "ErrorBarsDocument", "volumetric": "VolumetricDocument", "moduli": "Moduli", "matrix": "MatrixDocument", "self_contact": "SelfContact",
        "discretisation": "Discretisation", "formulation": "Formulation", "region": "Region", "of": "RequestedNumber",
    }
    for key, name in lists.items():
        choices = form.evaluate("async ([key, word]) => (await import('/viewer/scene/choices.js')).choicesOf(key, word)", [key, words_of(name)[0]])
        assert sorted(word for word, _ in choices) == sorted(words_of(name)), key
    # What others depend on is text; what can be exchanged is a choice with the word as its value.
    expect(field(form, f"{BALL}/kind")).to_have_text("hollow ball")
    expect(field(form, f"{THIGH}/kind")).to_have_text("limb segment")
    kinds = ["hollow_ball", "solid_ball", "cylinder", "block", "layered_block", "limb_segment"]
    assert None not in form.evaluate("async (kinds) => { const { kindOf } = await import('/viewer/scene/choices.js'); return kinds.map((kind) => kindOf('kind', kind)); }", kinds)
    role = field(form, "/bodies/0/role")
    expect(role).to_have_value("projectile")
    role.select_option(label="something else")
    assert json.loads(form.get_by_label("Scene as JSON").input_value())["bodies"][0]["role"] == "other"
    expect(field(form, "/bodies/0/role")).to_be_focused()


def test_axes_stand_beside_vectors_and_not_beside_lists(form):
    velocity = form.get_by_role("group", name="velocity [m/s]")
    expect(velocity.locator(".vector > span")).to_have_text(["x", "y", "z"])
    assert velocity.locator("input").last.input_value() == "-100"
    # Three thresholds are a list.
    expect(field(form, "/measures/stress_thresholds_pa")).to_have_value("10 30 100")
    for width in (1440, 390):
        form.set_viewport_size({"width": width, "height": 844})
        assert form.evaluate("document.documentElement.scrollWidth") <= width


def test_the_stiffness_of_the_scene_is_a_sentence_with_more_behind_it(form):
    note = form.locator("details.note")
    expect(note.locator("summary")).to_contain_text("less stiff against compression than water")
    more = note.locator("p")
    expect(more).not_to_be_visible()
    note.get_by_text("More").click()
    expect(more).to_contain_text("of water is 2.2 GPa")


def test_a_vector_is_marked_as_a_whole_and_an_overlap_where_the_body_is_placed(form):
    put(form, "/bodies/0/placement/translation_m/2", "60")
    said = form.locator(".field-error:not([hidden]):not(:empty)")
    expect(said).to_contain_text("overlap at the start")
    assert re.search(r"deepest by \d+\.\d+ mm at \(.*\) mm", said.inner_text()), said.inner_text()
    for k in range(3):
        expect(field(form, f"/bodies/0/placement/translation_m/{k}")).to_have_attribute("aria-invalid", "true")


def test_what_an_example_says_of_itself_goes_with_the_first_change(form):
    scene = lambda: json.loads(form.get_by_label("Scene as JSON").input_value())
    assert "100 m/s" in scene()["description"]
    put(form, f"{BALL}/outer_radius_m", "16")
    assert "description" not in scene() and scene()["bodies"][0]["mesh"]["generator"]["outer_radius_m"] == 0.016


def test_studies_begin_at_the_form(form):
    form.get_by_label("Begin with").select_option("bar_on_wall/scene.json")
    expect(form.get_by_text("ready to run")).to_be_visible()
    form.get_by_text("Study the computation instead").click()
    form.locator(".study-start select").nth(1).select_option("as given")
    form.get_by_role("button", name="Start this study", exact=True).click()
    form.wait_for_url(re.compile("#/job/"))
    expect(form.locator(".error-cost circle").first).to_be_visible()
    id = form.url.split("/job/")[1]
    study = form.request.get(f"/v1/jobs/{id}/summary").json()
    assert {row["setting"]["mesh_level"] for row in study["rows"]} == {-1, 0}
    form.go_back()
    form.get_by_text("Study the computation instead").click()
    form.get_by_role("button", name="Start the study of stability").click()
    form.wait_for_url(re.compile("#/job/"))
    expect(form.locator("h1")).to_contain_text("stability")
    job = form.url.split("/job/")[1]
    assert json.loads(form.request.post(f"/v1/jobs/{job}/cancel").text())["id"] == job


def test_a_projectile_that_does_not_move_is_no_impact(form):
    expect(form.get_by_text("ready to run")).to_be_visible()
    expect(form.get_by_text("does not move")).to_have_count(0)
    for i in range(3):
        put(form, f"/bodies/0/velocity_m_per_s/{i}", "0")
    expect(form.locator(".verdict .problems")).to_contain_text("the projectile does not move, and nothing else does — give it a velocity")


def test_a_rigid_ball_has_no_elements_and_a_body_without_a_name_its_role(form):
    form.get_by_label("Begin with").select_option(label="steel_ball_on_thigh")
    expect(form.get_by_role("row").filter(has_text="ball")).to_contain_text("rigid")
    put(form, "/bodies/0/name", "")
    expect(form.locator(".problems a").first).to_have_text(re.compile("^(projectile|tissue) › name$"))
    # The form converts to SI itself.
    put(form, "/bodies/0/name", "ball")
    put(form, "/bodies/0/rigid/shape/radius_m", "0")
    expect(form.locator(".problems li").first).to_contain_text("give it in mm")
    expect(form.locator(".problems li").first).not_to_contain_text("0.015")
