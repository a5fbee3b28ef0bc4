"""Answers whose numbers are lower bounds, or whose errors lead beyond what is possible: of a service that is a double here."""

import csv
import io
import json
import re

import pytest
from playwright.sync_api import expect

SPEEDS = [60, 72, 84, 96, 108, 120]
# Of a person in the middle, with 9.2 mm of fat: the farthest place from the skin, at the bone [mm].
DEEPEST = 1.9 + 9.2 + 65 - 14


def case(speed, numbers, bounds=(), reaches=()):
    return {"index": 0, "name": f"{speed} m/s", "origin": {"kind": "case"}, "parameters": {"speed": speed}, "edits": {}, "ending": "finished",
            "steps": 1, "numbers": numbers, "lower_bounds": list(bounds), "reaches": list(reaches)}


@pytest.fixture
def answered(page):
    """Asks a question, which is answered by cases."""
    routes = []

    def stub(address, answer, **options):
        routes.append(address)
        page.route(address, lambda route: route.fulfill(json=answer, **options))

    def stub_job(cases, name):
        stub("**/v1/what-if", {"id": name}, status=202)
        of = "what if: flashball_44 on thigh, fat 9.2 mm, 60 to 120 m/s, 100 kPa"
        stub(f"**/v1/jobs/{name}", {"id": name, "name": of, "state": "succeeded", "links": {"summary": f"/v1/jobs/{name}/summary"}})
        summary = {"cases": cases, "effort": {"computed": len(cases), "from_cache": 0}, "notice": "A double.", "requested_cases": len(cases),
                   "parameters": [{"name": "speed", "unit": "m/s"}], "quantities": {}, "sensitivities": [], "limits": []}
        stub(f"**/v1/jobs/{name}/summary", summary)
        routes.append(f"**/v1/jobs/{name}/events")
        page.route(routes[-1], lambda route: route.fulfill(status=204))

    def answer(cases, number, with_more_fat=None):
        stub_job(cases, "double")
        page.goto("/")
        page.evaluate("sessionStorage.clear()")
        page.goto(f"/#/ask?hit=flashball_44&where=thigh&who=50&from=60&to=120&kpa=100&number={number}")
        page.get_by_role("button", name="Answer", exact=True).click()
        expect(page.locator(".answer-curve .computed")).to_have_count(len(cases))
        if with_more_fat:
            stub_job(with_more_fat, "fatter")
            page.get_by_role("button", name="And with more fat?").click()
            expect(page.locator(".difference")).to_be_visible()

    yield answer
    for address in routes:
        page.unroute(address)


def text_of(page):
    """The comma-separated text of the answer: rows by their columns."""
    with page.expect_download() as download:
        page.get_by_role("button", name="Answer as CSV").click()
    return list(csv.DictReader(io.StringIO(download.value.path().read_text())))


def test_a_band_stays_in_the_body(page, answered):
    answered([case(v, {"stress_depth_mm": {"value": 20 + i, "error": 60}}) for i, v in enumerate(SPEEDS)], "depth")
    said = page.locator(".answers").inner_text()
    assert re.search(r"not resolved by these runs: between 0 and 62 mm, at 60 m/s", said), said
    ends = [(float(row["from [mm]"]), float(row["to [mm]"])) for row in text_of(page)]
    assert len(ends) > 2 * len(SPEEDS)
    assert {low for low, _ in ends} == {0} and all(high == pytest.approx(DEEPEST, abs=0.05) for _, high in ends)
    # The labels of the axis have room for the band, and for no more.
    ticks = [int(text.replace("−", "-")) for text in page.locator(".answer-curve text[text-anchor='end']").all_text_contents() if re.fullmatch(r"−?\d+", text)]
    assert min(ticks) >= 0 and max(ticks) <= 70
    # All of the band is in the picture, also between the ends of the curve.
    path, picture = page.locator(".answer-curve .band").bounding_box(), page.locator(".answer-curve").bounding_box()
    assert path["y"] >= picture["y"] and path["y"] + path["height"] <= picture["y"] + picture["height"]
    page.locator(".ask-answer summary").click()
    row = page.locator(".ask-answer tbody tr").first
    assert re.search(r"60\s+\(20\)\s+0\s+62\s+computed$", row.inner_text()), row.inner_text()


def test_the_cases_of_a_question_end_where_its_curve_does_and_lead_to_it(page, answered):
    numbers = {"stress_depth_mm": {"value": 50, "error": 20}, "peak_force_n": {"value": 900, "error": 1200}, "energy_given_j": {"value": 40, "error": 20}, "largest_patch_area_mm2": {"value": 300, "error": 12}}
    answered([{**case(v, numbers, ["largest_patch_area_mm2"] if v == 72 else ()), "index": i} for i, v in enumerate(SPEEDS)], "depth")
    address = page.evaluate("location.hash")
    curve = {row["speed [m/s]"]: (row["from [mm]"], row["to [mm]"]) for row in text_of(page) if row["origin"] == "computed"}
    page.locator(".answers a").click()
    rows = page.locator(".cases tbody tr")
    expect(rows).to_have_count(len(SPEEDS))
    # Half of 28 g times the square of 60 m/s; the depth to its farthest place; the last is as far as its error goes.
    first = [cell.inner_text().replace("\u00a0", " ") for cell in rows.first.locator("td").all()]
    assert first[1:] == ["(900), 0 to 2100", "300 ± 12", "50, 30 to 62", "40, 20 to 50"], first
    expect(page.get_by_text("both ends of the number with its error, within what is possible")).to_be_visible()
    with page.expect_download() as download:
        page.get_by_role("button", name="Cases as CSV").click()
    cases = list(csv.DictReader(io.StringIO(download.value.path().read_text())))
    assert {row["speed"]: (row["stress_depth_mm_from"], row["stress_depth_mm_to"]) for row in cases} == curve
    # The upper end of a lower bound is not known.
    assert [(row["largest_patch_area_mm2_from"], row["largest_patch_area_mm2_to"]) for row in cases[:2]] == [("288", "312"), ("288", "")]
    # Where it was asked, and where nothing is known of that.
    expect(page.get_by_role("link", name="Ask further")).to_have_count(0)
    link = page.get_by_role("link", name="Show the curve")
    assert link.get_attribute("href") == address
    page.evaluate("sessionStorage.clear()")
    page.reload()
    assert link.get_attribute("href") == address.replace("number=depth", "number=muscle")
    link.click()
    expect(page.locator(".proposed")).to_have_count(1)


# A ball and a fat of one's own, a percentile, and what the page has no question for.
@pytest.mark.parametrize("name, address", [
    ("ball 40 mm 20 g soft on arm, fat 12.3 mm, 10 to 40.5 m/s, 50 kPa", "#/ask?hit=own&where=arm&who=own&mm=40&g=20&of=soft&fat=12.3&from=10&to=40.5&kpa=50&number=muscle&jobs=1"),
    ("rigid ball 30 mm 100 g on thigh, fat 9.2 mm, 10 to 40 m/s, 100 kPa", "#/ask?hit=own&where=thigh&who=50&mm=30&g=100&of=rigid&from=10&to=40&kpa=100&number=muscle&jobs=1"),
    ("brick on thigh, fat 9.2 mm, 10 to 40 m/s, 100 kPa", None),
    ("flashball_44 on head, fat 9.2 mm, 10 to 40 m/s, 100 kPa", None),
    ("flashball_thigh", None),
])
def test_a_question_is_known_by_the_name_of_its_job(page, name, address):
    page.goto("/")
    body = """async (name) => {
        const { addressOf, askedIn } = await import("/viewer/pages/ask_address.js");
        const asked = askedIn(name);
        return asked && addressOf(asked, ["1"]);
    }"""
    assert page.evaluate(body, f"what if: {name}") == address


@pytest.mark.parametrize("number, key, value", [("force", "peak_force_n", 900), ("energy", "energy_given_j", 10)])
def test_no_force_and_no_energy_is_below_nothing_and_no_energy_beyond_that_of_the_projectile(page, answered, number, key, value):
    answered([case(v, {key: {"value": value, "error": 50 * value}}) for v in SPEEDS], number)
    for row in text_of(page):
        low, high = [float(cell) for name, cell in row.items() if re.match("from|to", name)]
        assert low == 0
        if number == "energy":
            assert high == pytest.approx(0.5 * 0.028 * float(row["speed [m/s]"]) ** 2)


def bounded(least_from):
    """Depths that rise through the top of the muscle; from a speed on they reach the bone."""
    def one(i, v):
        if v >= least_from:
            return case(v, {"stress_depth_mm": {"value": 58.2, "error": 1}}, ["stress_depth_mm"], ["the held nodes “bone”"])
        return case(v, {"stress_depth_mm": {"value": 6 + 3 * i, "error": 1}})

    return [one(i, v) for i, v in enumerate(SPEEDS)]


def test_lower_bounds_are_drawn_as_such_and_no_curve_goes_through_them(page, answered):
    answered(bounded(96), "muscle")
    picture = page.locator(".answer-curve")
    expect(picture.locator(".bound")).to_have_count(3)
    assert {circle.get_attribute("fill") for circle in picture.locator(".bound").all()} == {"#fff"}
    assert "at least 47.1 mm at 96 m/s" in picture.get_attribute("aria-label")
    expect(page.get_by_text("computed, a lower bound: at least so much")).to_be_visible()
    rows = text_of(page)
    assert max(float(row["speed [m/s]"]) for row in rows if row["origin"] == "proposed") == 84
    bounds = [row for row in rows if "lower bound" in row["origin"]]
    assert [row["to [mm]"] for row in bounds] == ["", "", ""] and "reaches the bone" in bounds[0]["origin"]
    # The curve crosses where its own points do, and the bound ends its uncertainty.
    said = page.locator(".answers").inner_text()
    assert re.search(r"exceeds 100 kPa from (79|80) m/s on \(between 7\d and 96 m/s with the uncertainty\)", said), said
    assert "At 96, 108, 120 m/s the number is a lower bound: the stress reaches the bone, where the model ends." in said


def test_a_curve_below_the_level_and_lower_bounds_above_it_say_between_which_speeds(page, answered):
    answered([case(v, {"stress_depth_mm": {"value": 3 + i, "error": 1}}) for i, v in enumerate(SPEEDS[:3])] + bounded(0)[3:], "muscle")
    said = page.locator(".answers").inner_text()
    assert "exceeds 100 kPa from a speed between 84 and 96 m/s on, beyond the uncertainty" in said, said
    expect(page.locator(".answer-curve .crossing")).to_have_count(0)


def test_lower_bounds_alone_say_from_which_speed_on_at_the_latest(page, answered):
    growing = [case(v, {"stress_depth_mm": {"value": 6 + 3 * i, "error": 1}}, ["stress_depth_mm"]) for i, v in enumerate(SPEEDS)]
    answered(growing, "muscle")
    said = page.locator(".answers").inner_text()
    assert re.search(r"exceeds 100 kPa from 80\.\d m/s on at the latest, beyond the uncertainty from 8\d\.\d m/s on\.", said), said
    assert "At all speeds the number is a lower bound: it was still growing" in said
    expect(page.locator(".answer-curve")).to_contain_text("≤ 80.")
    assert {row["to [mm]"] for row in text_of(page)} == {""}
    # A second person can be asked about all the same.
    expect(page.get_by_role("button", name="And with more fat?")).to_be_visible()
    answered([case(v, {"stress_depth_mm": {"value": 3, "error": 1}}, ["stress_depth_mm"]) for v in SPEEDS], "muscle")
    assert "may exceed 100 kPa: only lower bounds are known" in page.locator(".answers").inner_text()


def depths(first, error=1.0):
    """Depths that rise by 3 mm from one speed to the next; the top of the muscle of the first person is at 11.1 mm, of the second at 21.1 mm."""
    return [case(v, {"stress_depth_mm": {"value": first + 3 * i, "error": error}}) for i, v in enumerate(SPEEDS)]


@pytest.mark.parametrize("more, words", [
    (depths(10), r"With 10 mm more fat the speed at which the muscle exceeds 100 kPa moves from 80\.\d ± \d\.\d m/s to 104\.\d ± \d\.\d m/s: beyond the errors\."),
    (depths(15, 4), r"moves from 80\.\d ± \d\.\d m/s to 84 ± 1\d m/s: no difference beyond the errors\."),
    (depths(0), r"moves from 80\.\d ± \d\.\d m/s to more than 120 m/s: beyond the errors\."),
    (depths(22, 20), r"What 10 mm more fat changes is not resolved by these runs: the speed .* is 80\.\d ± \d\.\d m/s without them, anywhere from below 60 to above 120 m/s with them\."),
])
def test_what_more_fat_changes_is_said_with_its_errors(page, answered, more, words):
    answered(depths(6), "muscle", more)
    said = page.locator(".difference").inner_text()
    assert re.search(words, said), said


def test_an_unknown_error_is_no_error_of_nothing(page, answered):
    unknown = lambda first: [case(v, {"stress_depth_mm": {"value": first + 3 * i, **({} if i == 2 else {"error": 1})}}) for i, v in enumerate(SPEEDS)]
    answered(unknown(6), "muscle", unknown(16))
    picture = page.locator(".answer-curve")
    assert [circle.get_attribute("fill") for circle in picture.locator(".unknown").all()] == ["#fff", "#fff"]
    expect(picture.locator(".proposed")).to_have_count(2)
    # A band of each curve, but for the speeds beside that.
    expect(picture.locator(".band")).to_have_count(2)
    expect(picture).to_contain_text("80 m/s, error unknown")
    assert "mm at 84 m/s (error unknown)" in picture.get_attribute("aria-label")
    said = page.locator(".answers li").first.inner_text()
    assert "exceeds 100 kPa from about 80 m/s on, with unknown error. The numerical error is not known at 84 m/s, so that the curve has no band there." in said and "beyond" not in said, said
    assert "the numerical errors are not known, so that this may be no difference" in page.locator(".difference").inner_text()
    # No ends of what has no known error, neither of the point nor of a curve.
    assert {(row["from [mm]"], row["to [mm]"]) for row in text_of(page) if "error unknown" in row["origin"]} == {("", "")}


@pytest.mark.parametrize("errors, words, label", [
    ([5] * 6, r"exceeds 100 kPa from 80 m/s on \(between 60 and 100 m/s with the uncertainty\)", "80 m/s"),
    ([9] * 5 + [12], r"not resolved by these runs: with the uncertainty the muscle may exceed 100 kPa or stay below that, at all computed speeds, 60 to 120 m/s\.", "not resolved"),
])
def test_an_error_that_excludes_nothing_is_no_answer(page, answered, errors, words, label):
    answered([case(v, {"stress_depth_mm": {"value": 6 + 3 * i, "error": error}}) for i, (v, error) in enumerate(zip(SPEEDS, errors))], "muscle")
    said = page.locator(".answers").inner_text()
    assert re.search(words, said), said
    expect(page.locator(".answer-curve")).to_contain_text(label)


def test_a_level_that_all_numbers_exceed_is_not_resolved_where_errors_reach_it(page, answered):
    answered([case(v, {"stress_depth_mm": {"value": 12 + 3 * i, "error": 5}}) for i, v in enumerate(SPEEDS)], "muscle")
    said = page.locator(".answers").inner_text()
    assert re.search(r"not resolved by these runs below [67]\d(\.\d)? m/s; from there on the muscle exceeds 100 kPa, beyond the uncertainty\.", said), said


def test_a_question_that_is_refused_says_why_beside_the_button(page):
    page.goto("/#/ask")
    page.get_by_label("Who?").select_option("own")
    page.get_by_label("Thickness of the fat").fill("0")
    page.get_by_role("button", name="Answer").click()
    expect(page.get_by_role("alert")).to_have_text("The thickness of the fat must be from 0.5 to 60 mm.")
    expect(page.locator(".ask input:invalid")).to_have_count(1)
    page.get_by_label("Thickness of the fat").fill("10")
    expect(page.get_by_role("alert")).to_be_hidden()
    expect(page.locator(".sources")).to_contain_text("Fat as you gave it.")


def test_layers_and_the_end_of_the_model_are_drawn_and_the_picture_follows_the_window(page, answered):
    answered([case(v, {"stress_depth_mm": {"value": 9 + 11 * i, "error": 1}}) for i, v in enumerate(SPEEDS)], "fat")
    picture = page.locator(".answer-curve")
    assert picture.locator(".border text").all_text_contents() == ["skin", "top of the muscle", "bone under the impact", "deepest place, beside the bone"]
    assert picture.get_attribute("viewBox") == "0 0 760 360"
    page.set_viewport_size({"width": 390, "height": 844})
    expect(picture).to_have_attribute("viewBox", "0 0 400 310")
    page.set_viewport_size({"width": 1440, "height": 1000})
    expect(picture).to_have_attribute("viewBox", "0 0 760 360")


def test_a_changed_size_is_said_with_its_errors(page, answered):
    force = lambda factor, bounds=(): [case(v, {"peak_force_n": {"value": factor * 10 * v, "error": 50}}, bounds) for v in SPEEDS]
    answered(force(1), "force", force(0.9))
    said = page.locator(".difference").inner_text()
    assert "the peak force changes by between −160 and +40 N at 60 m/s, −120 ± 100 N at 120 m/s; beyond the errors at 2 of the 6 speeds." in said, said
    answered(force(1), "force", force(0.99))
    assert "With 10 mm more fat no difference beyond the errors: between −110 and +90 N at 60 m/s" in page.locator(".difference").inner_text()
    # Of a lower bound no difference is known.
    answered(force(1), "force", force(0.9, ["peak_force_n"]))
    assert "What 10 mm more fat changes is not known" in page.locator(".difference").inner_text()
    # The button stays, for another amount.
    expect(page.get_by_role("button", name="And with more fat?")).to_be_enabled()


def test_a_depth_that_ends_at_the_bone_at_all_speeds_says_so(page, answered):
    answered(bounded(0), "depth")
    said = page.locator(".answers").inner_text()
    assert "at least 58.2 mm at 60 m/s, and the same at all speeds up to 120 m/s." in said and "reaches the bone" in said, said
    answered(bounded(0), "muscle")
    said = page.locator(".answers").inner_text()
    assert "exceeds 100 kPa at all computed speeds, 60 to 120 m/s, beyond the uncertainty" in said, said


def test_a_force_that_still_grew_at_the_end_is_at_least_so_large(page, answered):
    answered([case(v, {"peak_force_n": {"value": 10 * v, "error": 5}}, ["peak_force_n"] if v > 100 else []) for v in SPEEDS], "force")
    said = page.locator(".answers").inner_text()
    assert "± 5.0 N at 60 m/s; at least 1200 N at 120 m/s." in said, said
    assert "At 108, 120 m/s the number is a lower bound: it was still growing when the computed time ended." in said
    assert page.watch.errors == []


def test_a_difference_ends_where_both_numbers_do(page, answered):
    depth = lambda value, error: [case(v, {"stress_depth_mm": {"value": value, "error": error}}) for v in SPEEDS]
    answered(depth(20, 60), "depth", depth(1.9, 0.06))
    # From 0 to 62 mm without the fat, 1.84 to 1.96 mm with it.
    said = page.locator(".difference").inner_text()
    assert "no difference beyond the errors: between −60 and +2 mm at 60 m/s" in said, said
    # What is not resolved is pale, and marks of the second curve stand beside those of the first.
    picture = page.locator(".answer-curve")
    expect(picture.locator(".computed.unresolved")).to_have_count(len(SPEEDS))
    expect(page.get_by_text("computed, not resolved, since the error")).to_be_visible()
    places = {float(circle.get_attribute("cx")) for circle in picture.locator(".computed").all()}
    assert len(places) == 2 * len(SPEEDS)


def test_one_wording_for_what_is_not_resolved_below_a_speed(page, answered):
    answered([case(v, {"stress_depth_mm": {"value": 12 + 3 * i, "error": 5}}) for i, v in enumerate(SPEEDS)], "muscle", [case(v, {"stress_depth_mm": {"value": 24 + 3 * i, "error": 5}}) for i, v in enumerate(SPEEDS)])
    said = page.locator(".ask-answer").inner_text()
    assert said.count("; from there on the muscle exceeds 100 kPa") == 2 and "between less than" not in said, said


def test_a_ball_and_a_fat_that_cannot_be_are_refused_at_once(page):
    page.goto("/")
    page.goto("/#/ask?hit=own&mm=5&g=3000&of=rigid")
    sources = page.locator(".sources")
    expect(sources).to_contain_text("usually between 100 and 25000 kg/m³")
    page.get_by_label("Diameter", exact=True).fill("90")
    expect(sources).not_to_contain_text("usually between")
    page.get_by_label("Who?").select_option("own")
    for thickness in ("0", "100", ""):
        page.get_by_label("Thickness of the fat").fill(thickness)
        expect(sources).to_contain_text("The thickness of the fat must be from 0.5 to 60 mm.")
        expect(sources).not_to_contain_text("as you gave it. Skin")
    page.get_by_label("What hits?").select_option("flashball_44")
    page.get_by_label("What hits?").select_option("own")
    assert [page.get_by_label(name, exact=True).input_value() for name in ("From", "To")] == ["10", "40"]


def test_a_question_has_a_title_in_plain_words(page, answered):
    answered([{**case(v, {"stress_depth_mm": {"value": 50, "error": 20}}), "index": i} for i, v in enumerate(SPEEDS)], "depth")
    page.locator(".answers a").click()
    expect(page.get_by_role("heading", level=1)).to_contain_text("Flash-ball, 44 mm, on the thigh with 9.2 mm of fat, 60 to 120 m/s, stress above 100 kPa")
    expect(page.locator(".cases tbody th").first).to_have_text("60 m/s")
