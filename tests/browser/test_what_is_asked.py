"""A question as people ask it, and its answer as a curve against speed."""

import math
import re
import time

import pytest
from conftest import PATIENCE_MS, open_page
from playwright.sync_api import expect
from test_what_is_said import post

# Until all speeds of a question are computed.
COMPUTED_MS = 5 * PATIENCE_MS


def ask(page, person, low, high):
    """Asks from the first page on, in two clicks."""
    page.goto("/")
    page.get_by_role("link", name="Ask", exact=True).click()
    page.get_by_label("What hits?").select_option("flashball_44")
    page.get_by_label("Who?").select_option(person)
    page.get_by_label("From").fill(low)
    page.get_by_label("To", exact=True).fill(high)
    page.get_by_role("button", name="Answer", exact=True).click()


def test_projectiles_and_people_have_sources(page):
    page.goto("/#/ask")
    sources = page.locator(".sources")
    page.get_by_label("What hits?").select_option("flashball_44")
    expect(sources).to_contain_text(re.compile("28 g, 44 mm, soft rubber, about 60 Shore A"))
    thickness = []
    for percent in ("5", "50", "95"):
        page.get_by_label("Who?").select_option(percent)
        thickness.append(float(re.search(r"fat ([\d.]+) mm", sources.inner_text())[1]))
    # Log-normal: the geometric mean of the two ends is the median; the mean of the source is above it.
    assert thickness[0] * thickness[2] == pytest.approx(thickness[1] ** 2, rel=0.02)
    assert thickness[1] < 10.4
    expect(sources).to_contain_text("Gibney")


def test_a_ball_and_a_thickness_of_ones_own(page):
    page.goto("/")
    page.goto("/#/ask?hit=own&mm=40&g=20&of=soft&who=own&fat=12.3")
    sources = page.locator(".sources")
    expect(sources).to_contain_text("20 g, 40 mm, soft rubber, about 60 Shore A")
    expect(sources).to_contain_text("fat 12.3 mm")
    assert page.get_by_label("What hits?").input_value() == page.get_by_label("Who?").input_value() == "own"
    assert [page.get_by_label(name, exact=True).input_value() for name in ("Diameter", "Mass", "Thickness of the fat")] == ["40", "20", "12.3"]
    # As heavy as it is said to be: hollow, with the density of its rubber.
    body = """async ([diameter_mm, mass_g, made]) => {
        const [{ hardnessesFrom, ownBall }, library] = await Promise.all([import('/viewer/scene/own_ball.js'), fetch('/v1/materials').then((answer) => answer.json())]);
        const ball = ownBall({ diameter_mm, mass_g, hardness: hardnessesFrom(library).find(({ id }) => id === made) });
        return typeof ball === "string" ? ball : ball.body(0, 10);
    }"""
    hollow = page.evaluate(body, [40, 20, "soft"])
    generator = hollow["mesh"]["generator"]
    volume = 4 / 3 * math.pi * (generator["outer_radius_m"] ** 3 - generator["inner_radius_m"] ** 3)
    assert volume * hollow["parts"][0]["density_kg_per_m3"] == pytest.approx(0.020, rel=1e-4)
    solid = page.evaluate(body, [40, 43, "nbr_linder_2011"])
    assert solid["mesh"]["generator"]["kind"] == "solid_ball" and solid["parts"][0]["material"] == {"library": "rubber/nbr_linder_2011"}
    assert page.evaluate(body, [40, 100, "rigid"])["rigid"]["mass_kg"] == 0.1
    # No rubber of that size weighs so much.
    page.get_by_label("Mass", exact=True).fill("100")
    expect(sources).to_contain_text("weighs from 7.4 g (hollow) to 34 g (solid)")
    page.get_by_role("button", name="Answer", exact=True).click()
    expect(page.get_by_role("alert")).to_contain_text("choose a rigid one")
    # The service accepts what the page would ask.
    page.get_by_label("Mass", exact=True).fill("20")
    assert "mm=40&g=20&of=soft&fat=12.3" in page.evaluate("location.hash")
    for ball in (hollow, solid):
        tissue = {"name": "block", "role": "tissue", "mesh": {"generator": {"kind": "block", "min_m": [-0.05, -0.05, -0.03], "max_m": [0.05, 0.05, 0], "elements": [4, 4, 2]}},
                  "parts": [{"part": "block", "density_kg_per_m3": 1000, "material": {"law": "neo_hookean", "c10_pa": 2e4, "bulk_modulus_pa": 5e6}}], "fixed": [{"set": "z_min"}]}
        answer = page.request.post("/v1/jobs/validate", data={"name": "own", "end_time_s": 1e-3, "bodies": [ball, tissue]})
        assert answer.ok, answer.text()


def test_a_range_that_is_none_is_said_to_be(page):
    ask(page, "50", "20", "10")
    expect(page.get_by_text("the lower one first")).to_be_visible()


def crossing_of(page, points):
    """The crossing of 0 by the curve through points [speed, value, error], whose error is linear between them, and known there."""
    return page.evaluate(
        """async (points) => {
            const { crossingOf } = await import('/viewer/plots/crossing.js');
            const linear = (k) => (v) => {
                const i = Math.max(1, points.findIndex(([speed]) => speed >= v));
                const [a, b] = [points[i - 1], points[i]];
                return a[k] + ((v - a[0]) / (b[0] - a[0])) * (b[k] - a[k]);
            };
            const [value, error] = [linear(1), linear(2)];
            const range = [points[0][0], points.at(-1)[0]];
            return crossingOf({ value, lower: (v) => value(v) - error(v), upper: (v) => value(v) + error(v), range, stretches: [range] }, 0);
        }""",
        points,
    )


def test_a_crossing_is_where_the_curve_and_its_band_cross(page):
    page.goto("/#/ask")
    rising = crossing_of(page, [[2, -3, 1], [8, 3, 1]])
    assert rising == {"at": pytest.approx(5), "from": pytest.approx(4), "to": pytest.approx(6), "isAbove": False, "falls": False, "hasError": True}
    # What falls through the level has no speed from which on it is above.
    assert crossing_of(page, [[2, 3, 1], [8, -3, 1]])["falls"]
    assert crossing_of(page, [[2, -5, 1], [8, -5, 1]]) == {"at": None, "from": None, "to": None, "isAbove": False, "falls": False, "hasError": True}


def test_from_which_speed_on_the_band_stays_above(page):
    page.goto("/#/ask")
    # All of the band is above: from the start on.
    above = crossing_of(page, [[2, 5, 1], [8, 11, 1]])
    assert above == {"at": None, "from": 2, "to": 2, "isAbove": True, "falls": False, "hasError": True}
    # The band dips below in the middle: only from where it has left the level for good.
    assert crossing_of(page, [[2, 5, 1], [4, 5, 9], [8, 5, 1]])["to"] == pytest.approx(6, abs=0.05)
    # It dips below at the end: nowhere for good.
    assert crossing_of(page, [[2, 5, 1], [8, 5, 9]])["to"] is None


def test_a_curve_goes_through_computed_points_and_not_beyond_them(page):
    page.goto("/#/ask")
    fit = """async ([points, speeds]) => {
        const f = (await import('/viewer/scene/fit.js')).fitted(points.map(([speed, value]) => ({ speed, value })));
        return f && [speeds.map(f.value), speeds.map(f.error), f.holdOut];
    }"""
    speeds = [60, 72, 84, 96, 108, 120]
    # A straight line is found again, without error.
    values, errors, _ = page.evaluate(fit, [[[v, 3 * v - 2] for v in speeds], [66, 90, 117]])
    assert values == pytest.approx([196, 268, 349]) and errors == pytest.approx([0, 0, 0], abs=1e-9)
    # A step is neither undershot nor overshot, and computed points have no error of the curve.
    step = [[v, y] for v, y in zip(speeds, [-3, -1, 0.2, 0.3, 4, 4])]
    values, errors, hold_out = page.evaluate(fit, [step, speeds + [60 + k for k in range(61)]])
    assert values[:6] == pytest.approx([y for _, y in step]) and errors[:6] == pytest.approx([0] * 6, abs=1e-9)
    assert all(b >= a - 1e-12 for a, b in zip(values[6:], values[7:])) and max(errors) == pytest.approx(hold_out) and hold_out > 0.5
    # Through 0, 1 and 0 without the middle: 1 off.
    assert page.evaluate(fit, [[[1, 0], [2, 1], [3, 0]], [1.5]]) == [[0.75], [1], 1]
    assert page.evaluate(fit, [[[1, 0], [2, 1]], [1.5]]) is None


def test_the_answer_is_a_curve_of_computed_points(page, record_property):
    asked = time.monotonic()
    ask(page, "5", "90", "120")
    picture = page.locator(".answer-curve")
    expect(picture.locator(".computed").first).to_be_visible(timeout=COMPUTED_MS)
    record_property("first_point_s", round(time.monotonic() - asked, 1))
    expect(page.get_by_text("Computed by")).to_be_visible(timeout=COMPUTED_MS)
    record_property("whole_curve_s", round(time.monotonic() - asked, 1))
    expect(page.get_by_text("Each covers 7.9 ms, until contact has ended.")).to_be_visible()
    computed = picture.locator(".computed").count()
    assert computed + len(re.findall("No number at", page.locator(".answers").inner_text())) > 3
    expect(picture.locator(".proposed")).to_have_count(1)
    expect(picture.locator(".band")).to_have_count(1)
    # The points are those of the service, measured from the top of the muscle.
    job = page.locator(".answers a").get_attribute("href").rsplit("/", 1)[1]
    cases = page.request.get(f"/v1/jobs/{job}/summary").json()["cases"]
    assert len([case for case in cases if case["ending"] == "finished"]) == computed
    top = 1.9 + float(re.search(r"fat ([\d.]+) mm", page.locator(".answers b").inner_text())[1])
    label = picture.get_attribute("aria-label").replace("−", "-")
    shown = [float(value) for value in re.findall(r"([-\d.]+) mm at", label)]
    depths = [case["numbers"]["stress_depth_mm"] for case in cases if case["ending"] == "finished"]
    assert len(shown) == len(depths)
    for value, depth in zip(shown, depths):
        assert value == pytest.approx(depth["value"] - top, abs=0.1 + 0.06 * depth.get("error", 0))
    # The third click: a second curve for another person, on the same axes.
    page.get_by_role("button", name="And with more fat?").click()
    expect(page.locator(".answers li")).to_have_count(2)
    expect(picture.locator(".proposed")).to_have_count(2, timeout=COMPUTED_MS)
    record_property("second_curve_s", round(time.monotonic() - asked, 1))
    expect(page.locator(".difference")).to_contain_text("10 mm more fat")
    # Another amount can be asked for, in place of this one.
    expect(page.get_by_role("button", name="And with more fat?")).to_be_enabled()
    # No name of a field is on the page.
    assert not re.search(r"[a-z]_[a-z]", page.locator(".ask").inner_text().replace("flashball_thigh", ""))
    assert page.watch.errors == []


@pytest.fixture
def questions(page):
    """The requests of the page, as it goes on, that ask or stop: the ends of their addresses."""
    sent = []
    page.on("request", lambda request: request.method == "POST" and sent.append(request.url.rsplit("/", 1)[1]))
    return sent


def test_an_address_has_the_question_and_its_answer(page, browser, service):
    address = page.evaluate("location.hash")
    assert re.fullmatch(r"#/ask\?hit=flashball_44&where=thigh&who=5&from=90&to=120&kpa=100&number=muscle&jobs=[\w-]+,[\w-]+&more=10", address)
    said = page.locator(".answers").inner_text()
    # Asked anew in another browser, which knows no job of it: the service has one already.
    known = address.split("jobs=")[1].split(",")[0]
    asking = open_page(browser, service.address)
    asking.goto("/" + re.sub("&jobs=.*", "", address))
    asking.get_by_role("button", name="Answer", exact=True).click()
    expect(asking.locator(".proposed")).to_have_count(1, timeout=COMPUTED_MS)
    assert f"jobs={known}" in asking.evaluate("location.hash")
    asking.close()
    # To the numbers of the job and back, as a reload, and in another browser: the same answer, and nothing is asked.
    other = open_page(browser, service.address)
    for one, come in [(page, page.reload), (other, lambda: other.goto("/" + address))]:
        sent = []
        one.on("request", lambda request, sent=sent: request.method == "POST" and sent.append(request.url))
        come()
        expect(one.locator(".proposed")).to_have_count(2, timeout=COMPUTED_MS)
        assert one.locator(".answers").inner_text() == said and one.get_by_label("Who?").input_value() == "5"
        assert one.get_by_role("link", name="Ask", exact=True).get_attribute("aria-current") == "page"
        assert sent == [] and one.evaluate("location.hash") == address
    # From the job alone, in a browser that remembers nothing of it.
    other.evaluate("sessionStorage.clear()")
    other.goto(f"/#/job/{known}")
    other.get_by_role("link", name="Show the curve").click()
    expect(other.locator(".proposed")).to_have_count(1, timeout=COMPUTED_MS)
    assert sent == [] and other.evaluate("location.hash") == re.sub(f"{known}.*", known, address)
    other.close()
    page.locator(".answers a").first.click()
    expect(page.locator(".cases")).to_be_visible()
    page.go_back()
    expect(page.locator(".proposed")).to_have_count(2, timeout=COMPUTED_MS)
    assert page.evaluate("location.hash") == address and page.watch.errors == []


def test_an_address_with_unknown_values_is_the_usual_question(page, browser, service):
    other = open_page(browser, service.address)
    other.goto("/#/ask?hit=brick&where=head&who=42&from=90&to=20&kpa=-1&number=colour&more=x")
    values = [other.get_by_label(name).input_value() for name in ("What hits?", "Where?", "Who?", "From", "Threshold of stress")]
    assert values == ["flashball_44", "thigh", "50", "60", "100"]
    expect(other.get_by_role("button", name="And with more fat?")).to_be_hidden()
    assert other.watch.errors == []
    other.close()


def test_a_changed_question_leaves_the_answer_of_the_one_before(page, questions):
    notice = page.get_by_text("the question before it was changed")
    expect(notice).to_be_hidden()
    page.get_by_label("Who?").select_option("95")
    expect(notice).to_be_visible()
    page.get_by_label("Who?").select_option("5")
    expect(notice).to_be_hidden()
    # A threshold is asked for only where it is used; the number is another of the same cases, so that nothing is computed.
    question = page.locator(".ask .question select")
    question.select_option("force")
    expect(page.get_by_label("Threshold of stress")).to_be_hidden()
    expect(notice).to_be_visible()
    page.get_by_role("button", name="Answer", exact=True).click()
    expect(notice).to_be_hidden()
    expect(page.locator(".answers")).to_contain_text(re.compile(r"(± \d+ N|between 0 and \d+ N,|N with unknown error) at 90 m/s; .* N,?( with unknown error)? at 120 m/s\."), timeout=COMPUTED_MS)
    assert "deeper" not in page.locator(".answers").inner_text()
    # Asked again: the job of before.
    question.select_option("muscle")
    page.get_by_role("button", name="Answer", exact=True).click()
    expect(page.locator(".answers")).to_contain_text("100 kPa", timeout=COMPUTED_MS)
    assert questions == []


def test_a_question_is_stopped_and_a_job_of_another_is_not_its_answer(page, questions):
    # The job is of speeds up to 120 m/s.
    address = re.sub(",.*", "", page.evaluate("location.hash").replace("to=120", "to=119"))
    page.goto("/#/")
    page.goto("/" + address)
    expect(page.locator(".computed").first).to_be_visible(timeout=COMPUTED_MS)
    assert questions == ["what-if"] and page.evaluate("location.hash") != address
    page.get_by_role("button", name="Stop").click()
    expect(page.get_by_text(re.compile(r"stopped, \d of 6 speeds"))).to_be_visible()
    assert questions == ["what-if", "cancel"]
    expect(page.get_by_role("button", name="Answer", exact=True)).to_be_enabled()
    expect(page.get_by_role("button", name="Stop")).to_be_hidden()


@pytest.mark.parametrize("size", [(1440, 900), (820, 1180), (390, 844)])
def test_an_answer_is_on_the_screen_when_it_is_asked_for(page, size):
    page.set_viewport_size(dict(zip(("width", "height"), size)))
    page.goto("/")
    ask(page, "5", "90", "120")
    expect(page.locator(".proposed")).to_have_count(1, timeout=COMPUTED_MS)
    for seen in (page.locator(".answers"), page.locator(".curve-title"), page.locator(".answer-curve")):
        box = seen.bounding_box()
        assert box["y"] >= 0 and box["y"] + box["height"] <= size[1] and box["x"] >= 0 and box["x"] + box["width"] <= size[0]
    page.set_viewport_size({"width": 1440, "height": 1000})


CASE = """async (data) => {
  const { WhatIfAnswer } = await import("/viewer/pages/what_if_answer.js");
  const answer = new WhatIfAnswer();
  answer.take({ event: "case", data });
  return answer.element.textContent;
}"""


def test_cases_have_units_before_the_answer_is_whole(page):
    page.goto("/")
    case = {"index": 0, "of": 2, "name": "base", "origin": {"kind": "base"}, "ending": "finished", "numbers": {},
            "parameters": {"fat thickness": 0.008, "speed": 100}, "units": {"fat thickness": "m", "speed": "m/s"}}
    said = page.evaluate(CASE, case)
    # 8 mm and 100 m/s, as they are set.
    assert "fat thickness [mm]" in said and "speed [m/s]" in said and "as it was8100–" in said


def test_a_question_about_a_job_is_stopped_and_asked_once(page, questions):
    presets = {preset["file"]: preset["scene"] for preset in page.request.get("/viewer/presets.json").json()}
    job = post(page, "/v1/jobs", presets["flashball_thigh/scene_elastic.json"])
    page.goto(f"/#/what-if/{job['id']}")
    page.get_by_role("slider", name="Speed").focus()
    page.keyboard.press("ArrowRight")
    page.keyboard.press("ArrowRight")
    ask = page.get_by_role("button", name="What if?")
    ask.click()
    expect(page.get_by_text("Done:")).to_be_visible(timeout=COMPUTED_MS)
    address = page.evaluate("location.hash")
    # The same again is the same job.
    ask.click()
    expect(page.get_by_text("Done:")).to_be_visible(timeout=COMPUTED_MS)
    assert questions == ["what-if"] and page.evaluate("location.hash") == address
    # With each parameter alone it is another question, which takes long enough to be stopped.
    page.get_by_label("what matters most").check()
    ask.click()
    page.get_by_role("button", name="Stop").click()
    expect(page.get_by_text(re.compile("Stopped"))).to_be_visible(timeout=COMPUTED_MS)
    assert questions == ["what-if", "what-if", "cancel"] and page.evaluate("location.hash") != address
    expect(ask).to_be_enabled()
    assert page.watch.errors == []
