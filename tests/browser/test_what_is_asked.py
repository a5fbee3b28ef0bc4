"""A question as people ask it, and its answer as a curve against speed."""

import re
import time

import pytest
from conftest import PATIENCE_MS
from playwright.sync_api import expect

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
    page.get_by_role("button", name="Answer").click()


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


def test_a_range_that_is_none_is_said_to_be(page):
    ask(page, "50", "20", "10")
    expect(page.get_by_text("the lower one first")).to_be_visible()


def test_a_crossing_is_where_the_curve_and_its_band_cross(page):
    page.goto("/#/ask")
    crossing = "async ([slope, offset]) => (await import('/viewer/plots/answer_curve.js')).crossingOf({ value: (v) => slope * v + offset, error: () => 1 }, 0, [2, 8])"
    assert page.evaluate(crossing, [1, -5]) == {"at": pytest.approx(5), "from": pytest.approx(4), "to": pytest.approx(6), "isAbove": False, "falls": False}
    # Above and below in all of the range.
    above = page.evaluate(crossing, [1, 5])
    assert above["at"] is None and above["isAbove"]
    # What falls through the level has no speed from which on it is above.
    assert page.evaluate(crossing, [-1, 5])["falls"]
    assert page.evaluate(crossing, [0, -5]) == {"at": None, "from": None, "to": None, "isAbove": False, "falls": False}


def test_a_curve_of_second_degree_is_found_again(page):
    fit = "async (points) => { const f = (await import('/viewer/scene/fit.js')).fitted(points, [1, 5]); return [f.value(2.5), f.holdOut]; }"
    value, hold_out = page.evaluate(fit, [{"speed": v, "value": 2 + 3 * v - 0.5 * v * v} for v in (1, 2, 3, 4, 5)])
    assert value == pytest.approx(2 + 7.5 - 3.125) and hold_out == pytest.approx(0, abs=1e-9)


def test_the_answer_is_a_curve_of_computed_points(page, record_property):
    asked = time.monotonic()
    ask(page, "5", "90", "120")
    picture = page.locator(".answer-curve")
    expect(picture.locator(".computed").first).to_be_visible(timeout=COMPUTED_MS)
    record_property("first_point_s", round(time.monotonic() - asked, 1))
    expect(page.get_by_text("Computed by")).to_be_visible(timeout=COMPUTED_MS)
    record_property("whole_curve_s", round(time.monotonic() - asked, 1))
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
    expected = [case["numbers"]["stress_depth_mm"]["value"] - top for case in cases if case["ending"] == "finished"]
    assert shown == pytest.approx(expected, abs=0.1)
    # The third click: a second curve for another person, on the same axes.
    page.get_by_role("button", name="And with more fat?").click()
    expect(page.locator(".answers li")).to_have_count(2)
    expect(picture.locator(".proposed")).to_have_count(2, timeout=COMPUTED_MS)
    record_property("second_curve_s", round(time.monotonic() - asked, 1))
    # No name of a field is on the page.
    assert not re.search(r"[a-z]_[a-z]", page.locator(".ask").inner_text().replace("flashball_thigh", ""))
    assert page.watch.errors == []
