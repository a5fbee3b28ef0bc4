"""What the picture of a run does: sections, depths, what is under the pointer, motion between frames; and two runs at equal times."""

import json
import re

import pytest
from conftest import open_page
from playwright.sync_api import expect
from test_viewer import picture_of
from test_what_is_said import post

FRAMES = "() => new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done)))"


@pytest.fixture(scope="module")
def jobs(page):
    presets = {preset["file"]: preset["scene"] for preset in page.request.get("/viewer/presets.json").json()}
    scene = presets["flashball_thigh/scene_elastic.json"]
    scene["record"] = {"field_interval_s": 1e-5, "fields": ["von_mises"]}
    jobs = {"near": post(page, "/v1/jobs", scene)}
    # The same 0.5 mm further away: 5 µs later at 100 m/s.
    scene["bodies"][0]["placement"]["translation_m"][2] += 5e-4
    jobs["far"] = post(page, "/v1/jobs", scene)
    # It ends long before the ball arrives.
    scene["bodies"][0]["placement"]["translation_m"][2] += 0.3
    jobs["away"] = post(page, "/v1/jobs", scene)
    yield jobs
    assert page.watch.errors == []


def open_job(page, job):
    page.goto("/")
    page.goto(f"/#/job/{job['id']}")
    expect(page.locator(".plots .u-over").first).to_be_visible()


@pytest.mark.parametrize(("width", "height"), [(1440, 900), (820, 1180), (390, 844)])
def test_the_first_screen_answers(page, jobs, width, height):
    page.set_viewport_size({"width": width, "height": height})
    open_job(page, jobs["near"])
    box = page.locator(".mesh-view").bounding_box()
    assert box["y"] + box["height"] <= height, "the picture is on the first screen"
    if width == 1440:
        answer = page.locator(".answer").bounding_box()
        assert answer["y"] + answer["height"] <= height, "and so is the answer, beside it"
        assert answer["x"] > box["x"] + box["width"]
    else:
        assert page.locator(".cards").bounding_box()["y"] > box["y"]
        tops = {round(tool.bounding_box()["y"]) for tool in page.locator(".title .tools > *").all()}
        assert len(tops) == 1, "what can be done with the job is one row"
    page.set_viewport_size({"width": 1440, "height": 1000})


def test_a_ball_that_touches_nothing_is_in_the_first_picture(page, jobs):
    open_job(page, jobs["away"])
    expect(page.get_by_label("Nothing touched")).to_be_visible()
    page.evaluate(FRAMES)
    # The grey of the projectile: neither tissue nor background have it.
    pixels = picture_of(page.locator(".mesh-view canvas")).tobytes()
    assert sum(90 < r < 150 and 0 <= g - r < 20 and 5 < b - g < 25 for r, g, b in zip(*[iter(pixels)] * 3)) > 100


def test_time_goes_between_frames(page, jobs):
    open_job(page, jobs["near"])
    time = page.get_by_label("Simulated time", exact=True)
    time.fill("2.5")
    expect(page.locator(".time-output")).to_have_text(re.compile("^25.00"))
    time.focus()
    page.keyboard.press("ArrowRight")
    expect(page.locator(".time-output")).to_have_text(re.compile("^30.00"))


def test_an_instant_is_read_before_those_in_between(page, jobs):
    """Requests for the recording are answered one by one: the last instant is there long before the others are."""
    held = []
    page.route("**/recording", lambda route: held.append(route))
    page.goto("/")
    page.goto(f"/#/job/{jobs['near']['id']}")
    slider, shown = page.get_by_label("Simulated time", exact=True), page.locator(".time-output")
    answered, asked_at, shown_at = 0, None, None
    while not page.locator(".plots .u-over").first.is_visible():
        if asked_at is None and slider.is_visible():
            assert not shown.inner_text().startswith("100")
            slider.press("End")
            asked_at = answered
        if asked_at is not None and shown_at is None and "reading" not in shown.inner_text():
            shown_at = answered
        if held:
            held.pop(0).continue_()
            answered += 1
        page.wait_for_timeout(50)
    page.unroute("**/recording")
    assert answered - shown_at > shown_at - asked_at > 0
    expect(shown).to_have_text(re.compile("^100"))


def test_a_view_that_was_turned_stays_when_the_rest_has_come(page, jobs):
    held = []
    page.route("**/recording", lambda route: held.append(route))
    page.goto("/")
    page.goto(f"/#/job/{jobs['near']['id']}")
    is_turned = False
    while not page.locator(".plots .u-over").first.is_visible():
        if not is_turned and page.locator(".mesh-view canvas").is_visible():
            drag(page, 120)
            is_turned = True
        if held:
            held.pop(0).continue_()
        page.wait_for_timeout(50)
    page.unroute("**/recording")
    assert is_turned
    page.get_by_label("Simulated time", exact=True).fill("0")
    turned = middle_of_picture(page)
    page.get_by_role("button", name="Impact").click()
    assert middle_of_picture(page) != turned


def test_a_comparison_shows_what_is_there(page, jobs):
    """Requests for recordings are answered one by one: numbers need none, pictures a frame of each, curves all of them."""
    held = []
    page.route("**/recording", lambda route: held.append(route))
    page.goto("/")
    page.goto(f"/#/compare/{jobs['near']['id']}/{jobs['far']['id']}")
    expect(page.locator("tbody").first.locator("tr")).to_have_count(4)
    answered, pictures_at = 0, None
    while not page.locator(".plots .u-over").first.is_visible():
        if pictures_at is None and page.locator(".mesh-view canvas").count() == 3:
            pictures_at = answered
        if held:
            held.pop(0).continue_()
            answered += 1
        page.wait_for_timeout(50)
    page.unroute("**/recording")
    assert 0 < pictures_at < answered / 2
    expect(page.locator(".stage .time-output").first).to_have_text(page.locator(".time-bar .time-output").inner_text())


def middle_of_picture(page):
    """The picture without the buttons and names at its edges."""
    image = picture_of(page.locator(".mesh-view canvas"))
    width, height = image.size
    return image.crop((width // 3, height // 3, 2 * width // 3, 2 * height // 3)).tobytes()


def drag(page, distance):
    """Turns the view of the picture."""
    point_at(page, 0.5, 0.5)
    page.mouse.down()
    box = page.locator(".mesh-view").bounding_box()
    page.mouse.move(box["x"] + 0.5 * box["width"] + distance, box["y"] + 0.5 * box["height"], steps=4)
    page.mouse.up()


def point_at(page, x, y):
    box = page.locator(".mesh-view").bounding_box()
    page.mouse.move(box["x"] + x * box["width"], box["y"] + y * box["height"])


def test_layers_have_names_and_the_flat_section_a_ruler(page, jobs):
    open_job(page, jobs["near"])
    expect(page.locator(".overlay .layer-name").first).to_be_visible()
    page.get_by_label("View").select_option("flat")
    page.get_by_role("button", name="Whole").click()
    expect(page.locator(".overlay .layer-name")).to_have_text(["skin", "fat", "muscle", "bone"])
    # The lines at thresholds have their names, too.
    names = page.locator(".overlay .contour-name").all_text_contents()
    assert names and set(names) <= {"10 kPa", "30 kPa", "100 kPa"}
    ticks = [float(tick) for tick in page.locator(".overlay .tick").all_text_contents()]
    assert ticks[0] == 0 and ticks == sorted(ticks) and len(ticks) >= 3


@pytest.mark.parametrize("bone, height", [(None, 113), ([0, -0.5, 0], 113), ([0, -0.05, 0], 94)])
def test_the_name_of_a_threshold_does_not_lie_on_bone(page, bone, height):
    page.goto("/")
    place = """async (bone) => {
        const THREE = await import("three");
        const { Overlay } = await import("/viewer/mesh/overlay.js");
        const overlay = new Overlay();
        overlay.setContours([{ text: "100 kPa", at: [0, 0, 0], bone }]);
        overlay.draw(new THREE.OrthographicCamera(-1, 1, 1, -1, -1, 1), false, 200, 200);
        return Number(overlay.element.querySelector(".contour-name").getAttribute("y"));
    }"""
    assert page.evaluate(place, bone) == height


def test_the_whole_stays_the_whole_in_another_view(page, jobs):
    open_job(page, jobs["near"])
    page.get_by_label("Simulated time", exact=True).fill("0")
    page.get_by_role("button", name="Whole").click()
    page.evaluate(FRAMES)
    in_space = middle_of_picture(page)
    page.get_by_role("button", name="Impact").click()
    page.evaluate(FRAMES)
    assert middle_of_picture(page) != in_space
    page.get_by_label("View").select_option("flat")
    page.get_by_role("button", name="Whole").click()
    page.get_by_label("View").select_option("space")
    page.evaluate(FRAMES)
    assert middle_of_picture(page) == in_space


def test_the_pointer_reads_layer_depth_and_stress(page, jobs):
    page.get_by_label("Simulated time", exact=True).fill("0")
    page.get_by_label("View").select_option("flat")
    page.get_by_role("button", name="Impact").click()
    page.evaluate(FRAMES)
    # Along the line of the impact, at rest: what the ruler says is what the pointer says.
    place = "(depth) => { const ticks = [...document.querySelectorAll('.overlay .tick')]; const at = (i) => Number(ticks[i].getAttribute('y')) - 4;" \
        " const [a, b] = [Number(ticks[0].textContent), Number(ticks[1].textContent)]; return at(0) + (depth - a) / (b - a) * (at(1) - at(0)); }"
    height = page.locator(".mesh-view").bounding_box()["height"]
    for depth, layer in [(1, "skin"), (6, "fat"), (20, "muscle")]:
        point_at(page, 0.5, page.evaluate(place, depth) / height)
        words = page.locator(".probe")
        expect(words).to_contain_text(re.compile(f"^{layer} · .*mm below the nearest surface · stress .*kPa · displacement"))
        shown = float(re.search(r"· ([\d.]+)\s*mm below", words.inner_text())[1])
        assert shown == pytest.approx(depth, abs=0.6)
    page.mouse.move(0, 0)
    expect(page.locator(".probe")).to_be_hidden()


def test_the_wheel_zooms_to_the_pointer(page, jobs):
    point_at(page, 0.5, 0.6)
    before = page.locator(".probe").inner_text()
    ticks = page.locator(".overlay .tick").all_text_contents()
    page.mouse.wheel(0, -600)
    page.evaluate(FRAMES)
    assert page.locator(".overlay .tick").all_text_contents() != ticks, "it zooms"
    point_at(page, 0.5, 0.6)
    assert page.locator(".probe").inner_text() == before, "what is under the pointer stays there"


def test_colours_fit_the_run_and_can_be_fixed_or_logarithmic(page, jobs):
    open_job(page, jobs["near"])
    page.get_by_text("Picture settings").click()
    ends = lambda: [float(page.get_by_label(f"{end} of the colours").input_value()) for end in ("Bottom", "Top")]
    mode = page.get_by_label("Range of the colours")
    shown = {}
    for name in ("fit", "fixed", "log"):
        mode.select_option(name)
        page.evaluate(FRAMES)
        shown[name] = ends(), picture_of(page.locator(".mesh-view canvas")).tobytes()
    assert shown["fit"][0][0] == 0 and shown["log"][0][0] > 0
    assert len({picture for _, picture in shown.values()}) == 3
    expect(page.locator(".legend").first).to_contain_text("logarithmic")
    # Thresholds have their names, also where they lie close to each other.
    for name in ("fit", "log"):
        mode.select_option(name)
        expect(page.locator(".stage .levels li")).to_have_text(["10", "30", "100 kPa"])
        lefts = page.locator(".stage .levels li").evaluate_all("(names) => names.map((name) => name.getBoundingClientRect())")
        assert all(one["right"] < next["left"] for one, next in zip(lefts, lefts[1:]))
    # The tissue undeformed, the projectile where it is.
    page.get_by_label("Deformation of the tissue").select_option("0")
    page.evaluate(FRAMES)
    assert picture_of(page.locator(".mesh-view canvas")).tobytes() != shown["log"][1]


def test_one_finger_scrolls_and_motion_plays(browser, service, jobs):
    page = open_page(browser, service.address, has_touch=True)
    page.emulate_media(reduced_motion="no-preference")
    page.set_viewport_size({"width": 390, "height": 844})
    page.goto(f"/#/job/{jobs['near']['id']}")
    expect(page.get_by_role("button", name="Pause")).to_be_visible()
    assert page.locator(".mesh-view canvas").evaluate("(canvas) => getComputedStyle(canvas).touchAction") == "pan-y"
    page.get_by_role("button", name="Pause").click()
    expect(page.get_by_role("button", name="Play")).to_be_visible()
    assert page.watch.errors == []
    page.close()


SIDES_OF_TWO_SIZES = """async () => {
  const { Cells, surfaceOf } = await import("/viewer/mesh/cells.js");
  const names = new Map();
  const node = (...x) => names.get(x.join()) ?? names.set(x.join(), names.size).size - 1;
  const hexahedron = (x, y, z, h) => [0, h].flatMap((up) => [[0, 0], [h, 0], [h, h], [0, h]].map(([a, b]) => node(x + a, y + b, z + up)));
  const small = [2, 3].flatMap((x) => [0, 1].flatMap((y) => [0, 1].flatMap((z) => hexahedron(x, y, z, 1))));
  const cells = new Cells(Uint32Array.from([...hexahedron(0, 0, 0, 2), ...small]));
  const parts = [null, Uint32Array.from({ length: 9 }, (_, e) => Number(e > 0))];
  return parts.map((partOf) => [...surfaceOf({ X: new Float32Array(3 * names.size), cells, partOf }).sides].reduce((counts, kind) => (counts[kind]++, counts), [0, 0, 0]));
}"""


def test_no_layer_ends_where_elements_change_their_size(page):
    # One hexahedron beside eight smaller ones: inside, between parts, on the surface.
    page.goto("/")
    assert page.evaluate(SIDES_OF_TWO_SIZES) == [[29, 0, 25], [24, 5, 25]]


def test_two_runs_are_compared_at_equal_times(page, jobs):
    contact = [page.request.get(jobs[name]["links"]["summary"]).json()["results"]["impacts"][0]["contact_span_s"][0] for name in ("near", "far")]
    page.goto(f"/#/compare/{jobs['near']['id']}/{jobs['far']['id']}")
    clocks = page.locator(".stage .time-output")
    expect(clocks).to_have_count(3)
    microseconds = lambda: [float(re.match(r"[\d.]+", text)[0]) for text in clocks.all_inner_texts()[:2]]
    near, far = microseconds()
    assert near == far
    page.get_by_label("Equal times are").select_option("contact")
    expect(page.get_by_text("The difference is at equal times since first contact")).to_be_visible()
    near, far = microseconds()
    assert far - near == pytest.approx(1e6 * (contact[1] - contact[0]), abs=0.02)
    # The choice is in the address.
    page.reload()
    expect(page.get_by_text("The difference is at equal times since first contact")).to_be_visible()
    assert microseconds() == [near, far]
    # The later one has ended before: no difference is made up.
    page.get_by_label("Simulated time", exact=True).focus()
    page.keyboard.press("End")
    expect(page.get_by_text("differences are at equal times since first contact only")).to_be_visible()
    expect(clocks.nth(2)).to_have_text("none at this time")
    assert sorted(text.startswith("ended at") for text in clocks.all_inner_texts()[:2]) == [False, True]
