"""What the picture of an answer has: bands where errors are known, labels that nothing runs through, a legend of what is there; and where it stands."""

import re

import pytest
from playwright.sync_api import expect
from test_what_is_bounded import SPEEDS, answered, bounded, case, depths, text_of


def with_errors(errors):
    """Depths that rise through the top of the muscle at 80 m/s, with errors that may be unknown."""
    return [case(v, {"stress_depth_mm": {"value": 6 + 3 * i, **({} if error is None else {"error": error})}}) for i, (v, error) in enumerate(zip(SPEEDS, errors))]


def test_a_band_is_drawn_between_neighbours_whose_errors_are_known(page, answered):
    answered(with_errors([1, 1, 1, 1, None, None]), "muscle")
    picture = page.locator(".answer-curve")
    expect(picture.locator(".unknown")).to_have_count(2)
    # From the first point to the last one with an error, and no farther.
    band = picture.locator(".band").bounding_box()
    centre = lambda mark: mark.bounding_box()["x"] + mark.bounding_box()["width"] / 2
    points = picture.locator(".computed")
    assert band["x"] == pytest.approx(centre(points.nth(0)), abs=1.5) and band["x"] + band["width"] == pytest.approx(centre(points.nth(3)), abs=1.5)
    rows = [row for row in text_of(page) if row["origin"].startswith("proposed")]
    ends = {float(row["speed [m/s]"]): (row["from [mm]"], row["to [mm]"]) for row in rows}
    assert all(("" in both) == (speed > 96) for speed, both in ends.items()) and max(ends) == 120
    # The errors that are not known are not those of the crossing.
    said = page.locator(".answers").inner_text()
    assert re.search(r"exceeds 100 kPa from 80\.\d m/s on \(between 7\d\.\d and 8\d\.\d m/s with the uncertainty\)\. The numerical error is not known at 108, 120 m/s, so that the curve has no band there\.", said), said
    assert re.fullmatch(r"80\.\d m/s", picture.locator(".label[font-weight]").text_content())
    # Points that are alone with their errors have no band.
    answered(with_errors([1, None, 1, None, 1, None]), "muscle")
    expect(picture.locator(".band")).to_have_count(0)
    assert "not known at 72, 96, 120 m/s, so that the curve has no band." in page.locator(".answers").inner_text()


# Of a neighbour of the crossing; where its upper end would be; where it may come back; of all.
@pytest.mark.parametrize("errors", [[1, 1, None, 1, 1, 1], [5, 5, 5, None, 5, 5], [1, 1, 1, None, 20, 20], [None] * 6])
def test_the_error_of_a_crossing_is_unknown_where_that_of_its_band_is(page, answered, errors):
    answered(with_errors(errors), "muscle")
    said = page.locator(".answers").inner_text()
    assert "exceeds 100 kPa from about 80 m/s on, with unknown error." in said, said
    expect(page.locator(".answer-curve")).to_contain_text("80 m/s, error unknown")


def test_what_is_above_at_all_speeds_is_so_beyond_the_errors_that_are_known(page, answered):
    high = lambda errors: [case(v, {"stress_depth_mm": {"value": 20 + i, **({} if error is None else {"error": error})}}) for i, (v, error) in enumerate(zip(SPEEDS, errors))]
    answered(high([None, 1, 1, 1, 1, None]), "muscle")
    said = page.locator(".answers").inner_text()
    assert "at all computed speeds, 60 to 120 m/s, beyond the uncertainty where that is known. Ask about lower ones. The numerical error is not known at 60, 120 m/s" in said, said
    answered(high([15, 9, 1, 1, None, None]), "muscle")
    said = page.locator(".answers").inner_text()
    assert re.search(r"not resolved by these runs below 7\d\.\d m/s; from there on the muscle exceeds 100 kPa, beyond the uncertainty where that is known\.", said), said


def legend_of(page):
    return page.get_by_label("What the marks mean").inner_text()


def test_the_legend_has_what_is_drawn(page, answered):
    answered(with_errors([0.5] * 6), "muscle")
    said = legend_of(page)
    assert "with a band of both errors" in said and "large: where a curve crosses" in said and "bar is the numerical error" in said
    assert not re.search("lower bound|brackets|unknown", said), said
    # Above everywhere nothing crosses; a depth in brackets is explained.
    answered([case(v, {"stress_depth_mm": {"value": 12, "error": 5}}) for v in SPEEDS], "muscle")
    said = legend_of(page)
    assert "crosses" not in said and "in brackets" in said and "≥" not in said, said
    answered(bounded(96), "muscle")
    said = legend_of(page)
    assert "computed, a lower bound" in said and "≥ 12" in said, said
    answered(with_errors([1, 1, 1, None, 1, 1]), "muscle")
    assert "a band of both errors between points whose errors are known" in legend_of(page)
    answered(with_errors([None] * 6), "muscle")
    said = legend_of(page)
    assert "no band, as errors are unknown" in said and "its bar" not in said, said


# Words whose boxes hold a point of a curve, of a bar or of a line across, or are over the words of another.
STRUCK = """() => {
  const picture = document.querySelector(".answer-curve");
  const labels = [...picture.querySelectorAll(".label")];
  const holds = ({ x, y, width, height }, at) => at.x > x && at.x < x + width && at.y > y && at.y < y + height;
  const along = (line) => Array.from({ length: 401 }, (_, i) => line.getPointAtLength((i / 400) * line.getTotalLength()));
  const lines = [...picture.querySelectorAll("path[fill=none]:not([stroke='#e3e8ee'])")].flatMap(along);
  return labels.filter((one) => {
    const box = one.getBBox();
    const isOver = (other) => other !== one && [[0, 0], [1, 0], [0, 1], [1, 1]].some(([i, k]) => holds(box, { x: other.getBBox().x + i * other.getBBox().width, y: other.getBBox().y + k * other.getBBox().height }));
    return lines.some((at) => holds(box, at)) || labels.some(isOver);
  }).map((one) => one.textContent);
}"""


@pytest.mark.parametrize("number, values", [("muscle", [57.5, 58, 58.5, 59, 59.5, 60]), ("muscle", [6, 9, 12, 15, 18, 21]), ("depth", [57.5, 58, 58.5, 59, 59.5, 60]), ("fat", [2, 3, 8, 20, 40, 57])])
def test_nothing_runs_through_the_words_of_the_picture(page, answered, number, values):
    answered([case(v, {"stress_depth_mm": {"value": value, "error": 0.5}}) for v, value in zip(SPEEDS, values)], number)
    picture = page.locator(".answer-curve")
    assert picture.locator(".label").count() >= 2
    assert page.evaluate(STRUCK) == []


@pytest.mark.parametrize("width, height", [(820, 1180), (390, 844)])
def test_the_address_of_an_answer_begins_with_it_on_a_narrow_screen(page, answered, width, height):
    answered(depths(6), "muscle", depths(10))
    page.set_viewport_size({"width": width, "height": height})
    page.reload()
    expect(page.locator(".proposed")).to_have_count(2)
    top = lambda name: page.get_by_label(name, exact=True).bounding_box()["y"]
    assert 0 < top("Answer") < height / 4 < top("Question")
    # The question is reached by one press.
    page.get_by_role("button", name="Change the question").click()
    assert abs(top("Question")) < height / 3
    page.set_viewport_size({"width": 1440, "height": 1000})
    expect(page.get_by_role("button", name="Change the question")).to_be_hidden()


def test_each_curve_has_a_line_about_its_runs(page, answered):
    answered(depths(6), "muscle", depths(10))
    lines = page.locator(".states p").all_text_contents()
    assert [line.split(":")[0] for line in lines[:2]] == ["thigh, front, fat 9.2 mm", "10 mm more fat"] and all("computed by 6 runs" in line for line in lines[:2])
    # What the service says of all of its results is said once.
    assert lines[2:] == ["A double."]
