"""What the viewer says of runs that went wrong, of numbers without errors, and to those who use no mouse."""

import copy
import csv
import io
import json
import re

import pytest
from playwright.sync_api import expect

# What hollow_ball on a thigh needs for all criteria to apply.
PERSON = {"region": "thorax", "body_mass_kg": 80, "wall_thickness_m": 0.03, "chest_depth_m": 0.23}


def post(page, path, document):
    """Submits, and waits until the job has ended, however slow the machine: its events end then."""
    job = page.request.post(path, data=json.dumps(document), headers={"Content-Type": "application/json"}).json()
    page.request.get(f"/v1/jobs/{job['id']}/events", headers={"Accept": "text/event-stream"}, timeout=0)
    return page.request.get(f"/v1/jobs/{job['id']}").json()


@pytest.fixture(scope="module")
def jobs(page):
    presets = {preset["file"]: preset["scene"] for preset in page.request.get("/viewer/presets.json").json()}
    good = presets["flashball_thigh/scene_elastic.json"]
    good["measures"]["person"] = PERSON
    broken = copy.deepcopy(good)
    # Metres an hour are no metres a second.
    broken["bodies"][0]["velocity_m_per_s"] = [0, 0, -360_000]
    withheld, slow, longer = (copy.deepcopy(good) for _ in range(3))
    withheld["bodies"][0]["parts"][0]["material"]["valid_to"] = {"limit_stretch": [0.95, 1.05]}
    slow["bodies"][0]["velocity_m_per_s"] = [0, 0, -60]
    longer["end_time_s"] = 2e-3
    scenes = {"good": good, "broken": {**broken, "name": "too fast"}, "withheld": {**withheld, "name": "withheld"}, "slow": {**slow, "name": "slow"}, "longer": {**longer, "name": "longer"}}
    jobs = {name: post(page, "/v1/jobs", scene) for name, scene in scenes.items()}
    speed = {"name": "speed", "low": 50, "high": 100, "change": {"kind": "speed_m_per_s", "body": "flashball"}}
    angle = {"name": "angle", "low": -45, "high": 45, "change": {"kind": "angle_deg", "body": "flashball", "about": [0, 1, 0]}}
    jobs["question"] = post(page, "/v1/what-if", {"job": jobs["good"]["id"], "parameters": [speed, angle], "one_at_a_time": True})
    assert [name for name, job in jobs.items() if job["state"] != "succeeded"] == ["broken"]
    yield jobs
    assert page.watch.errors == []


def open_job(page, job):
    page.goto("/")
    page.goto(f"/#/job/{job['id']}")
    expect(page.locator(".plots .u-over").first).to_be_visible()


def legend(page, plot):
    """What the legend of a plot reads, without the names."""
    return page.locator("figure.plot", has_text=plot).first.locator(".u-legend .u-value").all_inner_texts()


def test_a_failed_run_says_why_where_the_gates_stood(page, jobs):
    for width in (1366, 390):
        page.set_viewport_size({"width": width, "height": 900})
        open_job(page, jobs["broken"])
        assert page.evaluate("document.documentElement.scrollWidth") <= width
    page.set_viewport_size({"width": 1440, "height": 1000})
    line = page.locator(".warning-line")
    expect(line).to_contain_text("failed at")
    expect(line).to_contain_text(jobs["broken"]["failure"]["message"])
    expect(page.locator("main")).not_to_contain_text(re.compile("gates? passed|✓"))
    # That the numbers are unfinished is said once for all, and none leaves its card.
    numbers = page.get_by_label("The four numbers")
    assert numbers.inner_text().count("where the run ended") == 1
    # A verdict of the scene alone is no result of a run that ended early.
    for row in page.locator(".criteria tbody tr").all():
        expect(row).to_contain_text(re.compile("the run itself gives no result|the run failed before its end"))
    for card in numbers.get_by_role("article").all():
        assert card.evaluate("(card) => [...card.querySelectorAll('*')].every((e) => e.getBoundingClientRect().right <= card.getBoundingClientRect().right)")


def test_each_layer_has_a_sentence(page, jobs):
    open_job(page, jobs["good"])
    summary = page.request.get(jobs["good"]["links"]["summary"]).json()
    stresses = summary["results"]["tissue"]["significant_stress"]
    layers = page.get_by_label("What happened to each layer").get_by_role("listitem")
    expect(layers).to_have_count(4)
    for shown, name in zip(layers.all(), ["skin", "fat", "muscle", "bone"]):
        expect(shown.locator("b")).to_have_text(name)
        above = [stress for stress in stresses if any(layer["part"] == name for layer in stress["layers"])]
        if above:
            expect(shown).to_contain_text(f"above {above[-1]['threshold_pa'] / 1e3:.0f} kPa")
            expect(shown).to_contain_text(re.compile("mm deep.* of it"))
            # A layer has no error of its own.
            expect(shown).not_to_contain_text(re.compile(r"± [\d.]+ [cm]m³"))
    # From the skin to the bone of the limb: 70 mm − 14 mm. What still grew has no place where it ends.
    expect(layers.nth(3)).to_contain_text("56 mm deep")
    if stresses[0]["depth_mm"].get("is_lower_bound"):
        expect(layers.nth(3)).not_to_contain_text("mm before it")
    # Words that a reader would have to look up are not on the first screen, and nothing is said twice.
    words = page.locator(".first-screen").inner_text()
    assert not re.search(r"von Mises|gate|measures\.|_pa\b|Green", words)
    assert "100 kPa" not in page.locator(".cards").inner_text()


def test_warnings_are_one_line_with_a_door(page, jobs):
    open_job(page, jobs["good"])
    summary = page.request.get(jobs["good"]["links"]["summary"]).json()
    door = page.locator(".warning-line button")
    listed = page.locator(".trust .warnings li")
    expect(listed.first).not_to_be_visible()
    door.click()
    assert not re.search(r"[a-z]_(s|pa|m)\b", page.locator(".trust").inner_text()), "words, no names of the document"
    plain = """async (text) => (await import('/viewer/summary/plain_terms.js')).plainly(text).map((one) => one.textContent ?? one).join("")"""
    for warning in summary["warnings"]:
        expect(listed.filter(has_text=re.split("[`(]", page.evaluate(plain, warning))[0])).to_have_count(1)
    expect(door).to_have_text(f"All {listed.count()}")
    # The order is that of the summary, and the worst is in the line. The mesh resolves too little, which has a remedy.
    first = re.split("[`(:;]", page.evaluate(plain, summary["warnings"][0]))[0].strip()
    expect(listed.first).to_contain_text(first)
    expect(page.locator(".warning-line")).to_contain_text(first)
    expect(listed.filter(has_text=re.compile("too coarse for (one|some) of the main numbers"))).to_have_count(1)
    page.get_by_role("link", name="Run it again, refined").click()
    expect(page.get_by_label(re.compile("^Meshes"))).to_have_value("refined")


def test_a_report_fits_a_phone(page, jobs):
    address = jobs["good"]["links"]["summary"].replace("/summary", "/report")
    page.set_viewport_size({"width": 390, "height": 844})
    page.goto(address)
    assert page.evaluate("document.documentElement.scrollWidth") <= 390
    # Times and volumes are in units that keep them short.
    words = page.locator("main").inner_text()
    long = re.findall(r"\b\d{5,} (?:µs|mm³)", words)
    assert not long, long
    page.set_viewport_size({"width": 1440, "height": 1000})


def test_names_of_the_document_are_words(page):
    page.goto("/")
    words = "async (text) => (await import('/viewer/scene/scene_units.js')).inWords(text)"
    text = "left_ball comes late: raise end_time_s, or omit `measures.force_window_s` and `valid_to` (at /bodies/1/parts/0/density_kg_per_m3)"
    assert page.evaluate(words, text) == "left_ball comes late: raise “time to simulate”, or omit “averaging time of the force” and “valid up to” (at bodies › number 2 › parts › number 1 › density)"


def test_terms_of_engineers_are_plain_words_with_an_explanation(page):
    page.goto("/")
    parts = """async (text) => (await import('/viewer/summary/plain_terms.js')).plainly(text).map((one) => one.dataset ? [one.textContent, one.dataset.about] : one)"""
    said = page.evaluate(parts, "Bulk modulus capped: K/G of 2500, and K/G counts; `--lower-bulk-modulus` adds it")
    assert said[1] == ["Stiffness against compression", "bulk modulus, K: the pressure that a change of volume takes"]
    assert said[3] == ["the ratio of stiffness against compression to that in shear", "K/G: bulk modulus over shear modulus"]
    # Explained where it is first met.
    assert said[5] == "the ratio of stiffness against compression to that in shear"
    assert said[7][0] == "an accuracy with lower stiffness against compression" and said[8] == " adds it"
    assert page.evaluate(parts, "the held nodes “bone”")[1][0] == "fixed surface"


def test_criteria_are_shown_with_what_they_are_not(page, jobs):
    open_job(page, jobs["good"])
    summary = page.request.get(jobs["good"]["links"]["summary"]).json()
    rows, others = page.locator(".criteria tbody tr"), page.locator(".criteria details li")
    applicable = [measure for measure in summary["injury_measures"] if measure["applicable"]]
    expect(rows).to_have_count(len(applicable))
    expect(others).to_have_count(len(summary["injury_measures"]) - len(applicable))
    for row, measure in zip(rows.all(), applicable):
        expect(row).to_contain_text(measure["statement"])
        expect(row).to_contain_text(measure["source"])
        # Its value and its reference are in that sentence, and nowhere else.
        text = row.inner_text()
        assert all(text.count(number) == 1 for number in re.findall(r"\d+\.\d+", measure["statement"])), text
    expect(page.locator(".criteria")).to_contain_text("no diagnosis")


def test_cards_name_their_threshold_and_their_errors(page, jobs):
    cards = page.get_by_label("The four numbers").get_by_role("article")
    expect(cards.nth(2).locator("h2")).to_have_text("Depth of stress above 10 kPa")
    for card in cards.all():
        expect(card.locator(".error")).to_contain_text(re.compile("± |up to |between "))


def test_numbers_have_the_digits_that_their_errors_leave(page, jobs):
    digits = "async (pairs) => { const { within } = await import('/viewer/format.js'); return pairs.map(([value, error]) => within(value, error)); }"
    # To the second digit of the error, also where that rounds up; no more than four digits, which it has without an error.
    pairs = [[5552, 5300], [59.3, 17], [40, 0.75], [1.324, 0.03], [88.56, 250], [-3, 250], [0.4, 0.0996], [2151, 0.001], [0, 1], [7.923, None]]
    assert page.evaluate(digits, pairs) == ["5600", "59", "40.00", "1.324", "90", "0", "0.40", "2151", "0", "7.923"]
    results = page.request.get(jobs["good"]["links"]["summary"]).json()["results"]
    energy = results["tissue"]["energy_given_j"]
    shown = float(page.get_by_label("The four numbers").get_by_role("article").nth(3).locator("b").inner_text().removeprefix("≥\u00a0"))
    assert shown != energy["value"] and abs(shown - energy["value"]) < 0.06 * energy["error"]["total"]


def test_legends_follow_the_keys(page, jobs):
    page.get_by_label("Simulated time", exact=True).focus()
    page.keyboard.press("End")
    end = legend(page, "Contact force")
    page.keyboard.press("ArrowLeft")
    before = legend(page, "Contact force")
    assert re.match(r"100\.0 µs", end[0]) and re.match(r"75\.00 µs", before[0])
    assert "–" not in before and before != end
    # A pointer reads its own place, and leaves the slider's behind.
    impulse = page.locator("figure.plot", has_text="Impulse")
    place = impulse.locator(".u-legend .u-value").first
    impulse.locator(".u-over").hover(position={"x": 20, "y": 20})
    # The first move may come before the plot knows where the page was scrolled to.
    impulse.locator(".u-over").hover(position={"x": 60, "y": 40})
    expect(place).not_to_have_text(before[0])
    page.mouse.move(0, 0)
    expect(place).to_have_text(before[0])
    page.get_by_text("Picture settings").click()
    cut = page.get_by_label("Place of the cut")
    cut.focus()
    page.keyboard.press("ArrowRight")
    expect(cut).to_have_attribute("aria-valuetext", re.compile(r"^-?\d+\.\d mm$"))


def test_a_depth_profile_is_of_layers(page, jobs):
    with page.expect_download() as download:
        page.get_by_role("button", name="Depth profile as CSV").click()
    head, *rows = csv.reader(io.StringIO(download.value.path().read_text()))
    # Skin and fat have no node of their own: all of them are at an interface, in the skin or beside it.
    assert head == ["depth straight in [mm]", "muscle [kPa]", "muscle, with its neighbour [kPa]", "fat, with its neighbour [kPa]", "skin, with its neighbour [kPa]"]
    both = [row for row in rows if row[3] and row[4]]
    assert len(both) == 1, "one interface of skin and fat"
    # Of two nodes that mirror each other either layer may take either.
    assert float(both[0][3]) == pytest.approx(float(both[0][4]), rel=1e-4)
    # Depth is measured in the deformed tissue here.
    assert 0.5 < float(both[0][0]) < 2.5
    depths = [float(row[0]) for row in rows]
    assert depths == sorted(set(depths))
    assert all(float(row[0]) > float(both[0][0]) for row in rows if row[1] or row[2])


def test_the_list_has_the_projectile_and_the_numbers_of_each_run(page, jobs):
    page.goto("/#/")
    found = page.request.get(f"/v1/jobs/{jobs['good']['id']}").json()["headline"]
    results = page.request.get(jobs["good"]["links"]["summary"]).json()["results"]
    assert found["numbers"]["peak_force_n"]["value"] == results["impacts"][results["headline"]["impact"]]["peak_force_n"]["value"]
    assert found["numbers"]["energy_given_j"]["error"] == results["tissue"]["energy_given_j"]["error"]["total"] and found["speed_m_per_s"] > 0
    row = page.locator("main tbody tr", has=page.locator(f"a[href='#/job/{jobs['good']['id']}']"))
    expect(row).to_contain_text(re.compile(rf"{found['projectile']}, [\d.]+ m/s.* N.* mm².* mm above [\d.]+ kPa.* J", re.DOTALL))
    expect(page.get_by_text("in brackets: the error is as large as the number")).to_be_visible()
    withheld = page.request.get(f"/v1/jobs/{jobs['withheld']['id']}").json()
    assert withheld["headline"]["numbers"] == {} and withheld["headline"]["projectile"] == found["projectile"]


def test_a_withheld_run_has_no_result(page, jobs):
    badge = {"good": "succeeded", "withheld": "withheld", "broken": "failed"}
    for name, words in badge.items():
        page.goto("/")
        row = page.locator("tr", has=page.locator(f'a[href="#/job/{jobs[name]["id"]}"]'))
        expect(row.locator(".badge")).to_have_text(words)
        page.goto(f"/#/job/{jobs[name]['id']}")
        expect(page.locator("h1 .badge")).to_have_text(words)
        expect(page.locator("h1 .badge.good")).to_have_count(1 if name == "good" else 0)


def test_what_cannot_be_compared_is_said(page, jobs):
    rows, remark = page.locator("tbody").first.locator("tr"), page.locator("main section.panel").first
    reasons = {"broken": "B ended early", "withheld": "the numbers of B are withheld", "longer": "A ends at 100.0", "slow": "up to 100.0"}
    for name, reason in reasons.items():
        page.goto(f"/#/compare/{jobs['good']['id']}/{jobs[name]['id']}")
        expect(page.locator("thead").first).to_contain_text(jobs[name]["name"])
        expect(remark).to_contain_text(reason)
        # A number that is not resolved has no difference, whatever else keeps it from having one.
        if name != "slow":
            expect(rows.filter(has_text=re.compile("not comparable|not resolved in"))).to_have_count(4)
        if name == "slow":
            expect(rows.nth(0)).to_contain_text(re.compile("averaged over|not resolved in"))
        else:
            expect(remark).not_to_contain_text(re.compile("(beyond|within) the errors"))
    # A run differs from itself by nothing.
    page.goto(f"/#/compare/{jobs['good']['id']}/{jobs['good']['id']}")
    expect(rows.nth(3)).to_contain_text("0 (0 %) within the errors")
    # Numbers that may still grow are compared as they are at one time.
    page.goto(f"/#/compare/{jobs['longer']['id']}/{jobs['longer']['id']}")
    expect(rows.nth(2)).to_contain_text("≥")
    expect(rows.nth(2)).to_contain_text(re.compile(r"0 \(0 %\) within the errors|not resolved in A and B|both are lower bounds"))
    # Of two that an end of the model cuts there is no difference.
    summary = page.request.get(f"/v1/jobs/{jobs['longer']['id']}/summary").json()
    for stress in summary["results"]["tissue"]["significant_stress"]:
        stress["depth_mm"]["is_lower_bound"] = True
        stress["depth_reaches"] = ["the held nodes “bone”"]
    said = page.evaluate(
        """async (summary) => {
            const { numbersTable } = await import("/viewer/pages/compare_numbers.js");
            return numbersTable(["A", "B"].map((label) => ({ label, job: { name: label }, summary }))).textContent;
        }""",
        summary,
    )
    assert "both are lower bounds" in said


def test_no_difference_is_shown_of_what_is_not_resolved(page, jobs):
    summary = page.request.get(jobs["good"]["links"]["summary"]).json()
    unresolved = page.request.get(jobs["good"]["links"]["summary"]).json()
    unresolved["results"]["tissue"]["energy_given_j"]["error"].update(total=900.0, resolved=False)
    rows = page.evaluate(
        """async (summaries) => {
            const { numbersTable } = await import("/viewer/pages/compare_numbers.js");
            const table = numbersTable(["A", "B"].map((label, i) => ({ label, job: { name: label }, summary: summaries[i] })));
            return [...table.querySelectorAll("tbody tr")].map((row) => row.textContent);
        }""",
        [summary, unresolved],
    )
    assert rows[3].endswith("not comparable not resolved in B"), rows
    assert "within the errors" in rows[0], rows


def test_error_bars_end_at_what_is_possible(page, jobs):
    said = page.evaluate(
        """async (numbers) => {
            const { digits, errorWords } = await import("/viewer/summary/quantity.js");
            return numbers.map((number) => `${digits(number)} ${errorWords(number)}`);
        }""",
        [{"value": 7.8, "error": {"total": total, "resolved": total < 7.8}, "possible": possible, "is_lower_bound": total < 1} for total, possible in [(9, [0, 8]), (2, [0, 8]), (0.1, [0, 8]), (9, [0, None])]],
    )
    assert said == ["(7.8) up to 8.00", "7.8 between 5.8 and 8.00", "≥\u00a07.80 ± 0.10", "(7.8) up to 16.8"]
    # Only the lower end of a lower bound is uncertain.
    bounds = page.evaluate(
        """async (numbers) => {
            const { digits, errorWords, intervalOf } = await import("/viewer/summary/quantity.js");
            return numbers.map((number) => [`${digits(number)} ${errorWords(number)}`, intervalOf(number).low, intervalOf(number).isOpen]);
        }""",
        [{"value": value, "error": {"total": 2, "resolved": value > 2}, "possible": [0, 8], "is_lower_bound": True} for value in (7.5, 1e-9)],
    )
    assert bounds == [["≥\u00a07.5 ± 2.0", 5.5, True], ["(0) ± 2.0", 0, True]]
    # On the card, with the words for that end.
    summary = page.request.get(jobs["good"]["links"]["summary"]).json()
    energy = summary["results"]["tissue"]["energy_given_j"]
    energy.update(value=7.8, possible=[0, 8], is_lower_bound=True)
    energy["error"].update(total=9.0, resolved=False)
    words = page.evaluate(
        """async (summary) => {
            const { headlineCards } = await import("/viewer/summary/cards.js");
            return headlineCards(summary).lastElementChild.textContent;
        }""",
        summary,
    )
    assert "(≥\u00a07.8) J not resolved: ± 9.0\u202fJ" in words and "all that the impact supplies" not in words, words
    del energy["is_lower_bound"]
    words = page.evaluate(
        """async (summary) => {
            const { headlineCards } = await import("/viewer/summary/cards.js");
            return headlineCards(summary).lastElementChild.textContent;
        }""",
        summary,
    )
    assert "(7.8) J not resolved: up to 8.00\u202fJ, all that the impact supplies" in words, words


def test_no_difference_is_drawn_with_a_run_that_is_withheld(page, jobs):
    page.goto(f"/#/compare/{jobs['good']['id']}/{jobs['withheld']['id']}")
    expect(page.locator(".plots .u-over").first).to_be_visible()
    expect(page.locator(".mesh-view canvas")).to_have_count(2)
    # Pictures and curves say so, in short and with the whole reason.
    marks = page.locator("main .withheld .term")
    expect(marks).to_have_text([re.compile("was stretched to")] * 2)
    expect(marks.first).to_have_attribute("data-about", re.compile("beyond the declared limit of its law"))
    open_job(page, jobs["withheld"])
    expect(marks).to_have_count(2)
    open_job(page, jobs["good"])
    expect(marks).to_have_count(0)


def test_what_matters_most_ranks_what_rises_and_falls(page, jobs):
    page.goto("/")
    row = page.locator("tr", has=page.locator(f'a[href="#/job/{jobs["question"]["id"]}"]'))
    expect(row).to_contain_text(re.compile(r"\d of \d+ runs"))
    page.goto(f"/#/job/{jobs['question']['id']}")
    effects = page.locator(".what-matters tbody tr", has_text="peak force")
    expect(effects).to_have_count(2)
    answer = page.request.get(jobs["question"]["links"]["summary"]).json()
    values = {s["parameter"]: s["values"] for s in answer["sensitivities"] if s["quantity"] == "peak_force_n"}
    effect = {name: max(three) - min(three) for name, three in values.items()}
    for shown, name in zip(effects.all(), sorted(effect, key=effect.get, reverse=True)):
        cells = shown.locator("td").all_inner_texts()
        assert cells[0] == name
        assert float(cells[2]) == pytest.approx(effect[name], abs=0.06 * answer["cases"][0]["numbers"]["peak_force_n"]["error"])
    expect(effects.filter(has_text="angle")).to_contain_text("not monotone")
    expect(page.locator("thead").first).to_contain_text("depth of stress above")


def test_jobs_without_a_recording_offer_only_what_works(page, jobs):
    page.goto(f"/#/job/{jobs['good']['id']}")
    tools = page.locator(".title .tools")
    expect(tools.get_by_role("link")).to_have_text(["Change and run again", "Compare", "What if?"])
    page.goto(f"/#/job/{jobs['question']['id']}")
    expect(page.locator("h1")).to_contain_text("what if:")
    expect(tools.get_by_role("button", name="Delete")).to_be_visible()
    expect(tools.get_by_role("link")).to_have_count(0)
    # Whoever comes by an old address reads why.
    page.goto(f"/#/compare/{jobs['question']['id']}/{jobs['good']['id']}")
    expect(page.get_by_role("alert")).to_contain_text("has no recording")
    page.watch.errors.remove(next(error for error in page.watch.errors if "has no recording" in error))


def test_an_error_study_is_a_picture_and_tables(page, jobs):
    presets = {preset["file"]: preset["scene"] for preset in page.request.get("/viewer/presets.json").json()}
    job = post(page, "/v1/studies", {"kind": "error", "scene": presets["bar_on_wall/scene.json"], "coarsest": -1, "finest": 0})
    study = page.request.get(job["links"]["summary"]).json()
    page.goto(f"/#/job/{job['id']}")
    expect(page.locator(".title .tools a")).to_have_count(0)
    # Of each number a picture: a point for each setting whose error is known, with its name.
    titles = {name: f"{one['title']} [{one['unit']}]" for name, one in study["quantities"].items()}
    for name in study["references"]:
        known = [row for row in study["rows"] if row["ending"] == "finished" and name in row["errors"]]
        if known:
            page.locator(".study select").select_option(titles[name])
            expect(page.locator(".error-cost circle")).to_have_count(len(known))
            assert "mesh 2 × coarser" in page.locator(".error-cost").get_attribute("aria-label")
    assert not re.search(r"_n\b|_j\b|mesh [-+]1", page.locator(".study").inner_text()), "words, not names of the wire"
    page.get_by_text("All settings and limits as tables").click()
    settings, cheapest, limits = (page.get_by_role("group", name=name).locator("tbody tr") for name in ("Settings", "Cheapest", "Limits"))
    expect(settings).to_have_count(len(study["rows"]))
    for shown, row in zip(settings.all(), study["rows"]):
        level = re.match(r"mesh ([-+]?\d)", row["name"]).group(1)
        name = {"0": "mesh as given", "-1": "mesh 2 × coarser"}[level]
        expect(shown.locator("th")).to_have_text(row["name"].replace(f"mesh {level}", name, 1))
        number, error = re.fullmatch(r"([\d.]+) \(([\d.]+)\s%\)", shown.locator("td").nth(3).inner_text()).groups()
        assert float(number) == pytest.approx(row["values"]["peak_force_n"], rel=1e-3)
        assert float(error) == pytest.approx(100 * row["errors"]["peak_force_n"], rel=0.05)
    expect(limits).to_have_count(len(study["references"]))
    for advice in study["advice"]:
        name = titles.get(advice.get("quantity"), "all numbers")
        row = cheapest.filter(has=page.get_by_role("rowheader", name=name, exact=True))
        expect(row).to_contain_text("mesh" if "setting" in advice else "none of these")
    with page.expect_download() as download:
        page.get_by_role("button", name="Results (JSON)").click()
    assert json.loads(download.value.path().read_text()) == study


def test_a_stability_study_is_a_picture_and_a_table_of_cells(page, jobs):
    job = post(page, "/v1/studies", {"kind": "stability", "short": True})
    study = page.request.get(job["links"]["summary"]).json()
    for width in (1440, 390):
        page.set_viewport_size({"width": width, "height": 1000})
        page.goto("/")
        page.goto(f"/#/job/{job['id']}")
        expect(page.locator(".field-of-matrix")).to_have_count(len(study["cells"]))
        expect(page.locator(".field-of-matrix.good")).to_have_count(sum(cell["verdict"] == "finished" for cell in study["cells"]))
        page.get_by_text("All cells as a table").click()
        cells = page.get_by_role("group", name="Stiff and extreme cases").locator("tbody tr")
        expect(cells).to_have_count(len(study["cells"]))
        assert page.evaluate("document.documentElement.scrollWidth") <= width
    page.set_viewport_size({"width": 1440, "height": 1000})
    shown = cells.evaluate_all("(rows) => rows.map((row) => [...row.children].map((cell) => cell.textContent))")
    for words, cell in zip(shown, study["cells"]):
        assert words == [cell["axis"], cell["value"], cell["stepping"], cell["verdict"], cell.get("reason", ""), cell.get("remedy", "")]
    assert {"finished", "refused"} <= {words[3] for words in shown}


def test_a_question_is_found_again_after_leaving(page, jobs):
    page.goto("/")
    page.goto(f"/#/what-if/{jobs['good']['id']}")
    speed = page.get_by_role("slider", name="Speed")
    speed.focus()
    for _ in range(20):
        page.keyboard.press("ArrowRight")
    page.get_by_label("what matters most").check()
    page.get_by_role("button", name="What if?").click()
    page.wait_for_url(re.compile(r"\?job="))
    address = page.evaluate("location.hash")
    # Away while it computes, and back through the list.
    page.get_by_role("link", name="Impacts").click()
    page.locator(f'tbody a[href="{address}"]').click()
    expect(page.get_by_text("Done:")).to_be_visible()
    rows = page.get_by_role("group", name="what differs from the base").locator("tbody tr")
    answer = page.request.get(f"/v1/jobs/{address.split('job=')[1]}/summary").json()
    expect(rows).to_have_count(len(answer["cases"]))
    # By its address alone, too; and the next question still has the case of the first.
    page.reload()
    expect(page.get_by_text("Done:")).to_be_visible()
    expect(rows).to_have_count(len(answer["cases"]))
    page.get_by_role("slider", name="Speed").focus()
    page.keyboard.press("ArrowLeft")
    page.get_by_role("button", name="What if?").click()
    expect(rows).to_have_count(3)
    expect(page.get_by_text("Done:")).to_be_visible()
    assert page.evaluate("location.hash") != address
    page.get_by_role("link", name="This question among the jobs").click()
    expect(page.get_by_role("link", name="Ask further")).to_have_attribute("href", re.compile(re.escape(f"#/what-if/{jobs['good']['id']}?job=")))
