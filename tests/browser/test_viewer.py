"""The viewer, as a reader uses it: from the form to the comparison of two impacts. The tests build on each other, in order."""

import csv
import hashlib
import io
import json
import re
from urllib.parse import parse_qs, urlsplit

import pytest
from conftest import Service, open_page
from PIL import Image
from playwright.sync_api import expect

SPEED = '[data-pointer="/bodies/0/velocity_m_per_s/2"]'
JOBS = {}


def scene_of(page):
    return json.loads(page.get_by_label("Scene as JSON").input_value())


def put_text(page, text):
    """Writes into the JSON, behind its door."""
    if not page.get_by_label("Scene as JSON").is_visible():
        page.get_by_text("The same as JSON").click()
    page.get_by_label("Scene as JSON").fill(text)


def put_scene(page, scene):
    put_text(page, json.dumps(scene))


def begin_with(page, preset):
    page.get_by_label("Begin with").select_option(preset)
    name = preset.split("/")[0]
    expect(page.get_by_label("Scene as JSON")).to_have_value(re.compile(name))


def run(page):
    """Submits what is in the form, and waits for its page; the id of the job."""
    expect(page.get_by_text("ready to run")).to_be_visible()
    page.get_by_role("button", name="Run this impact").click()
    page.wait_for_url(re.compile("#/job/"))
    return page.url.rsplit("/", 1)[1]


def wait_for_results(page):
    expect(page.get_by_label("The four numbers")).to_be_visible()
    expect(page.locator(".mesh-view canvas").first).to_be_visible()
    expect(page.locator(".plots .u-over").first).to_be_visible()


def picture_of(locator):
    return Image.open(io.BytesIO(locator.screenshot())).convert("RGB")


def colours(image):
    """How many different colours a picture has, after rounding to 32 steps."""
    return len(image.point(lambda channel: channel // 8).getcolors(1 << 24))


def take(page, pictures, name, **options):
    if pictures:
        page.evaluate("scrollTo(0, 0)")
        shot = Image.open(io.BytesIO(page.screenshot(**options))).convert("RGB")
        shot.save(pictures / f"{name}.png", optimize=True)


def test_the_list_is_empty_and_leads_on(page):
    page.goto("/")
    expect(page.get_by_text("not a medical device")).to_be_visible()
    expect(page.get_by_text("Nothing has been computed yet")).to_be_visible()
    page.get_by_role("link", name="New impact").first.click()
    expect(page.get_by_role("heading", name="New impact")).to_be_visible()
    expect(page.get_by_text("ready to run")).to_be_visible()


def test_errors_stand_beside_their_inputs(page):
    scene = scene_of(page)
    page.locator(SPEED).fill("fast")
    expect(page.locator(".field", has=page.locator(SPEED)).locator(".field-error")).to_contain_text("number")
    expect(page.locator(SPEED)).to_have_attribute("aria-invalid", "true")
    expect(page.get_by_role("button", name="Run this impact")).to_be_disabled()
    # Two mistakes of different stages, in a part that was folded.
    scene["bodies"][1]["parts"][0]["density_kg_per_m3"] = -1
    scene["end_time_s"] = 0
    put_scene(page, scene)
    expect(page.locator(".problems li")).to_have_count(2)
    density = page.locator('[data-pointer="/bodies/1/parts/0/density_kg_per_m3"]')
    expect(density).to_be_visible()
    expect(density).to_have_attribute("aria-invalid", "true")
    put_text(page, '{"name": "broken off')
    expect(page.locator(".verdict")).to_contain_text("Line 1")


def test_a_running_job_is_watched_looked_at_and_cancelled(page):
    page.get_by_label("Begin with").select_option("hollow_ball_breathing/scene.json")
    scene = scene_of(page)
    scene["end_time_s"] = 0.3
    scene["record"] = {"field_interval_s": 2e-4, "every_steps": 10}
    scene["solver"] = {**scene.get("solver", {}), "error_bars": "none"}
    put_scene(page, scene)
    run(page)
    bar = page.get_by_label("Progress of the job")
    expect(bar).to_be_visible()
    expect(bar).to_have_attribute("value", re.compile("[1-9]"))
    steps = page.locator(".event-log li", has_text="stepping")
    expect(steps).to_have_count(1)
    # Until the first chunk is complete there is nothing to look at, and the page says so; the button waits for the next step.
    look = page.get_by_role("button", name="Look at it now")
    look.click()
    seen = page.locator(".mesh-view canvas, .progress-panel p:text('nothing to look at yet')")
    expect(seen.first).to_be_visible()
    while not page.locator(".mesh-view canvas").is_visible():
        if look.is_enabled():
            look.click()
        page.wait_for_timeout(100)
    expect(steps).to_have_count(1)
    page.get_by_role("button", name="Cancel").click()
    expect(page.locator("h1 .badge")).to_have_text("cancelled")
    expect(page.get_by_role("heading", name="Take it with you")).to_be_visible()


def test_a_job_is_deleted_after_a_question(page):
    page.once("dialog", lambda dialog: dialog.accept())
    page.get_by_role("button", name="Delete").click()
    expect(page.get_by_text("Nothing has been computed yet")).to_be_visible()


def test_an_example_runs_and_shows_its_four_numbers(page):
    page.goto("/#/new")
    expect(page.get_by_text("ready to run")).to_be_visible()
    begin_with(page, "flashball_thigh/scene_elastic.json")
    scene = scene_of(page)
    del scene["record"]["field_times_s"]
    scene["record"]["field_interval_s"] = 5e-6
    put_scene(page, scene)
    JOBS["fast"] = run(page)
    wait_for_results(page)
    cards = page.get_by_label("The four numbers").get_by_role("article")
    expect(cards).to_have_count(4)
    for card, unit in zip(cards.all(), ["N", "mm²", "mm", "J"]):
        # An error as large as the number is said in words.
        expect(card.locator(".big")).to_contain_text(re.compile(rf"\d.* {unit} .*(± |not resolved: up to \d)"))
    page.locator(".warning-line button").click()
    expect(page.get_by_text("passed").first).to_be_visible()


def test_the_mesh_is_coloured_and_the_keyboard_moves_time(page):
    canvas, slider = page.locator(".mesh-view canvas"), page.get_by_label("Simulated time", exact=True)
    expect(page.locator(".legend").first).to_contain_text("kPa")
    slider.focus()
    page.keyboard.press("Home")
    expect(page.locator(".time-output")).to_have_text(re.compile("^0\\sµs"))
    before = picture_of(canvas)
    page.keyboard.press("ArrowRight")
    expect(page.locator(".time-output")).to_have_text(re.compile("^5\\.0.*µs"))
    page.keyboard.press("End")
    expect(page.locator(".time-output")).to_have_text(re.compile("^100"))
    # The largest pressure of a node is no result.
    expect(page.locator(".patch p")).to_contain_text(re.compile(r"nodes touch.*; 95 % of it has a pressure below about [\d.]+\skPa"))
    page.wait_for_function("() => new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done)))")
    after = picture_of(canvas)
    assert colours(before) > 5, "something is drawn"
    assert colours(after) > colours(before) + 20, "stress makes colours"
    page.get_by_label("Colour by").select_option("principal_strain")
    expect(page.locator(".legend").first).to_contain_text("principal strain")
    assert picture_of(canvas).tobytes() != after.tobytes()
    page.get_by_label("Colour by").select_option("von_mises_pa")


def saved(page, click):
    with page.expect_download() as download:
        click()
    return download.value


def read_csv(page, name):
    text = saved(page, page.get_by_role("button", name=f"{name} as CSV").click).path().read_text()
    head, *rows = csv.reader(io.StringIO(text))
    return [dict(zip(head, row)) for row in rows]


def test_downloads_are_what_they_say(page, service):
    job = page.request.get(f"/v1/jobs/{JOBS['fast']}").json()
    summary = page.request.get(f"/v1/jobs/{JOBS['fast']}/summary").json()["results"]
    recording = saved(page, page.get_by_role("button", name="Recording (MCAP").click)
    assert hashlib.sha256(recording.path().read_bytes()).hexdigest() == job["recording"]["sha256"]
    # The curve is made from the impulses of the recording, the summary by the engine.
    force = read_csv(page, "Contact force")
    column = next(name for name in force[0] if name.startswith("mean over"))
    mean = max(float(row[column] or 0) for row in force)
    assert mean == pytest.approx(summary["impacts"][0]["peak_force_n"]["value"], rel=0.01)
    energy = read_csv(page, "Energy")
    scale = float(energy[0]["kinetic [J]"])
    for row in energy:
        total, supplied = (float(next(v for k, v in row.items() if k.startswith(word))) for word in ("sum", "supplied"))
        assert abs(total - supplied) < 0.01 * scale
    profile = read_csv(page, "Depth profile")
    assert float(profile[0]["depth straight in [mm]"]) == 0 and len(profile) > 5
    layout = json.loads(saved(page, page.get_by_role("button", name="Layout").click).path().read_text())
    assert "/mesh/thigh" in layout["configById"]["3D!mesh"]["topics"]
    # What other viewers are given to open is the recording, under a name that they know as one.
    link = page.get_by_role("link", name="Open in Lichtblick").get_attribute("href")
    source = parse_qs(urlsplit(link).query)["ds.url"][0]
    assert source.startswith(service.address) and source.endswith(".mcap")
    assert hashlib.sha256(page.request.get(source).body()).hexdigest() == job["recording"]["sha256"]
    image = Image.open(saved(page, page.get_by_role("button", name="Energy as PNG").click).path())
    assert colours(image.convert("RGB")) > 5


def test_plots_have_tables(page):
    section = page.locator("figure.plot", has_text="Contact force").first
    section.get_by_text("Table").click()
    expect(section.locator("tbody tr").nth(5)).to_be_visible()
    section.get_by_text("Table", exact=True).click()


def test_a_rigid_ball_is_shown_too(page, pictures):
    page.goto("/#/new")
    expect(page.get_by_text("ready to run")).to_be_visible()
    begin_with(page, "steel_ball_on_thigh/scene.json")
    # A new impact is refined until its numbers are accurate; here its own mesh is looked at.
    assert scene_of(page)["accuracy"]["relative"] == 0.1
    page.get_by_label(re.compile("^Meshes")).select_option("own")
    assert "accuracy" not in scene_of(page)
    run(page)
    wait_for_results(page)
    page.get_by_text("Picture settings").click()
    with_ball = picture_of(page.locator(".mesh-view canvas"))
    page.get_by_label("ball", exact=True).uncheck()
    assert picture_of(page.locator(".mesh-view canvas")).tobytes() != with_ball.tobytes()
    page.get_by_label("ball", exact=True).check()
    page.get_by_text("Picture settings").click()
    page.get_by_label("Simulated time", exact=True).fill("11")
    page.set_viewport_size({"width": 1440, "height": 1500})
    take(page, pictures, "viewer_impact")
    page.set_viewport_size({"width": 1440, "height": 1000})


def test_two_runs_side_by_side_share_a_camera(page, pictures):
    page.goto(f"/#/job/{JOBS['fast']}")
    page.get_by_role("link", name="Change and run again").click()
    expect(page.get_by_text("ready to run")).to_be_visible()
    page.locator(SPEED).fill("-60")
    JOBS["slow"] = run(page)
    wait_for_results(page)
    page.goto("/#/")
    for id in (JOBS["slow"], JOBS["fast"]):
        page.locator("tr", has=page.locator(f'a[href="#/job/{id}"]')).get_by_role("checkbox").check()
    page.get_by_role("link", name="Compare two").click()
    expect(page.locator(".mesh-view canvas")).to_have_count(3)
    expect(page.locator("tbody").first.locator("tr")).to_have_count(4)
    expect(page.locator(".plots .u-over").first).to_be_visible()
    page.get_by_label("Simulated time", exact=True).fill("16")
    page.get_by_label("Simulated time", exact=True).blur()
    take(page, pictures, "viewer_compare", full_page=True)
    first, second = page.locator(".mesh-view canvas").nth(0), page.locator(".mesh-view canvas").nth(1)
    before = picture_of(second)
    box = first.bounding_box()
    middle = (box["x"] + box["width"] / 2, box["y"] + box["height"] / 2)
    page.mouse.move(*middle)
    page.mouse.down()
    page.mouse.move(middle[0] + 120, middle[1] + 20, steps=4)
    page.mouse.up()
    assert picture_of(second).tobytes() != before.tobytes()


def test_what_if_answers_with_a_table(page):
    page.goto(f"/#/job/{JOBS['slow']}")
    wait_for_results(page)
    report = saved(page, page.get_by_role("button", name="Report (HTML)").click).path().read_text()
    assert "<html" in report and "not a diagnosis" in report.replace("no diagnosis", "not a diagnosis")
    page.get_by_role("link", name="What if?").click()
    speed = page.get_by_role("slider", name="Speed")
    speed.focus()
    for _ in range(20):
        page.keyboard.press("ArrowRight")
    page.get_by_role("button", name="What if?").click()
    rows = page.locator("main tbody tr")
    expect(page.get_by_text("Done:")).to_be_visible()
    expect(rows).to_have_count(2)
    expect(rows.nth(0)).to_contain_text("as it was")
    cases = list(csv.DictReader(io.StringIO(saved(page, page.get_by_role("button", name="Cases as CSV").click).path().read_text())))
    assert float(cases[0]["speed"]) == 60 and float(cases[1]["speed"]) > 60
    # The base is the job itself, and has its numbers.
    summary = page.request.get(f"/v1/jobs/{JOBS['slow']}/summary").json()["results"]
    assert float(cases[0]["peak_force_n"]) == pytest.approx(summary["impacts"][0]["peak_force_n"]["value"], rel=1e-9)
    assert float(cases[1]["energy_given_j"]) > float(cases[0]["energy_given_j"])


def test_a_limit_is_found_and_kept_in_the_address(page):
    page.goto(f"/#/what-if/{JOBS['slow']}")
    force = page.request.get(f"/v1/jobs/{JOBS['slow']}/summary").json()["results"]["impacts"][0]["peak_force_n"]["value"]
    page.get_by_label("Limit").fill(f"{force:.0f}")
    page.get_by_role("button", name="Find the limit").click()
    expect(page.get_by_text("Done:")).to_be_visible()
    said = page.locator(".limits li")
    # This mesh does not resolve the force: the place is in brackets.
    expect(said).to_have_text(re.compile(r"^Speed: the peak force stays at or below \d+ N up to \(\d+\) m/s; the number is not resolved"))
    answer = page.request.get(f"/v1/jobs/{page.url.rsplit('=', 1)[1]}/summary").json()["limits"][0]
    assert answer["kept_at"] == pytest.approx(60, abs=2)
    assert f"({answer['kept_at']:.0f}) m/s" in said.inner_text()
    page.reload()
    expect(said).to_have_count(1)


def test_fat_may_be_as_thick_as_that_of_people(page):
    fat = page.get_by_role("slider", name="Thickness of the fat")
    # From half of the 8 mm of the scene to the 95th percentile of the regions that can be asked about.
    assert 4 == pytest.approx(1e3 * float(fat.get_attribute("min"))) and 20 < 1e3 * float(fat.get_attribute("max")) < 23


def test_sliders_propose_numbers_once_cases_are_spread_over_them(page):
    page.goto(f"/#/what-if/{JOBS['slow']}")
    page.get_by_label("spread over all sliders").check()
    page.get_by_role("button", name="What if?").click()
    expect(page.get_by_text("Done:")).to_be_visible()
    proposals = page.locator(".what-if-proposal tbody tr")
    expect(proposals).to_have_count(4)
    before = proposals.nth(0).inner_text()
    speed = page.get_by_role("slider", name="Speed")
    speed.focus()
    for _ in range(20):
        page.keyboard.press("ArrowRight")
    assert proposals.nth(0).inner_text() != before
    # Both errors; the numerical one is that of the base, in proportion.
    answer = page.request.get(f"/v1/jobs/{page.url.rsplit('=', 1)[1]}/summary").json()
    base = answer["cases"][0]["numbers"]
    for row, key in zip(proposals.all(), ["peak_force_n", "largest_patch_area_mm2", "stress_depth_mm", "energy_given_j"]):
        words = re.search(r"(\(?)([\d.]+)(\)?) ±\s([\d.]+) numerical, ±\s([\d.]+) proposal", row.inner_text())
        bracket, closing = words[1], words[3]
        number, numerical, proposal = (float(words[group]) for group in (2, 4, 5))
        assert numerical / number == pytest.approx(base[key]["error"] / base[key]["value"], rel=0.1)
        assert proposal == pytest.approx(next(s["hold_out_error"] for s in answer["surrogates"] if s["quantity"] == key), rel=0.1)
        assert bracket + closing == ("()" if max(numerical, proposal) >= number else "")
    expect(page.get_by_text("Proposed, not computed")).to_be_visible()
    page.keyboard.press("End")
    expect(proposals.nth(0)).to_contain_text("beyond what was computed")


UNNAMED = """() => [...document.querySelectorAll("input, select, textarea, button, canvas, svg, img")].filter((e) =>
    !(e.closest("[aria-hidden], .u-wrap, .plot-area") || e.getAttribute("aria-label") || e.labels?.length || e.textContent.trim() || e.hasAttribute("alt")
      || e.hidden)).map((e) => e.outerHTML.slice(0, 200))"""


@pytest.mark.parametrize("path", ["#/", "#/new", "#/ask", "#/job/{fast}", "#/compare/{fast}/{slow}", "#/what-if/{fast}", "docs/#submit_job"])
def test_everything_has_a_name_and_fits(page, path):
    for width, height in [(820, 1180), (390, 844)]:
        page.set_viewport_size({"width": width, "height": height})
        page.goto("/")
        page.goto("/" + path.format(**JOBS))
        expect(page.locator("main h1")).to_be_visible()
        assert page.evaluate("document.documentElement.scrollWidth") <= width
        assert page.evaluate(UNNAMED) == []
    page.set_viewport_size({"width": 1440, "height": 1000})


def test_a_run_to_an_accuracy_says_which_mesh_it_runs(page):
    scene = page.request.get("/viewer/presets.json").json()[0]["scene"]
    scene["accuracy"] = {"relative": 0.1}
    job = page.request.post("/v1/jobs", data=json.dumps(scene), headers={"Content-Type": "application/json"}).json()
    page.goto(f"/#/job/{job['id']}")
    log = page.locator(".event-log")
    # Three meshes at least; how many follow depends on the machine.
    for mesh in (1, 2, 3):
        expect(log.locator("li", has_text=f"mesh {mesh}, with")).to_have_count(1)
    expect(log).to_contain_text(re.compile(r"error bars of the mesh before: up to ± [\d.]+ %, ± 10 % are requested"))
    page.request.post(f"/v1/jobs/{job['id']}/cancel")


def test_a_service_with_tokens_asks_for_one(browser, tmp_path):
    (tmp_path / "tokens").write_text("reader 0123456789abcdef\n")
    service = Service(tmp_path / "data", "--tokens-file", tmp_path / "tokens")
    try:
        page = open_page(browser, service.address)
        page.goto("/")
        page.get_by_label("Token").fill("0123456789abcdef")
        page.get_by_role("button", name="Continue").click()
        expect(page.get_by_text("Nothing has been computed yet")).to_be_visible()
        page.close()
    finally:
        service.stop()


def test_nothing_broke_and_nothing_left_the_service(page, service):
    assert page.watch.errors == []
    assert page.watch.hosts <= {service.address, "blob:", "data:"}
