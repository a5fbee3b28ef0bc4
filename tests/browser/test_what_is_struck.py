"""What the page says of the impact: where its surface is, which pair it speaks of, and what a run does not have."""

import pytest
from playwright.sync_api import expect
from test_what_is_said import post

LINE = """async (path) => {
  const { Recording } = await import("/viewer/recording/recording.js");
  const { impactLine } = await import("/viewer/plots/impact_line.js");
  return impactLine(await (await Recording.open(path)).read());
}"""

STRETCH = {"kind": "affine", "center_m": [0, 0, 0], "deformation_gradient": [[1.1, 0, 0], [0, 0.95, 0], [0, 0, 0.957]]}


def ball(name, x, velocity):
    rigid = {"shape": {"kind": "ball", "radius_m": 0.01}, "center_m": [x, 0, 0.0303], "density_kg_per_m3": 1500}
    return {"name": name, "role": "projectile", "velocity_m_per_s": [0, 0, -velocity], "rigid": rigid}


def block(name, x, role, **more):
    mesh = {"generator": {"kind": "block", "min_m": [x - 0.03, -0.03, 0], "max_m": [x + 0.03, 0.03, 0.02], "elements": [6, 6, 3]}}
    part = {"part": "*", "density_kg_per_m3": 1000, "material": {"law": "neo_hookean", "c10_pa": 4e4, "bulk_modulus_pa": 5e6}}
    return {"name": name, "role": role, "mesh": mesh, "parts": [part], **more}


def scene(name, bodies, end, **more):
    record = {"fields": ["von_mises"], "field_interval_s": 5e-4}
    return {"name": name, "end_time_s": end, "bodies": bodies, "solver": {"error_bars": "none"}, "record": record, **more}


@pytest.fixture(scope="module")
def jobs(page):
    held = {"fixed": [{"set": "z_min"}]}
    # Away from the middle, and deep in the first recorded frame.
    struck = [ball("ball", 0.003, 20), block("arm", 0, "tissue", **held)]
    beside = [ball("stone", 0.08, 30), block("armour", 0.08, "other", **held)]
    scenes = {
        "long": scene("long", struck, 1e-3),
        "short": scene("short", struck, 5e-4),
        "two": scene("two", [*struck, *beside], 1e-3),
        "free": scene("free", [block("arm", 0, "tissue", initial_deformation=STRETCH)], 5e-4, contact={"pairs": []}),
    }
    yield {name: post(page, "/v1/jobs", document) for name, document in scenes.items()}
    assert page.watch.errors == []


def open_job(page, job):
    page.goto("/")
    page.goto(f"/#/job/{job['id']}")
    expect(page.locator(".plots .u-over").first).to_be_visible()


def plot(page, title):
    return page.locator("figure.plot").filter(has=page.locator("strong", has_text=title))


def legend(page, title):
    return plot(page, title).locator(".u-legend .u-value").all_inner_texts()


def test_depth_begins_at_the_surface_at_rest_straight_in(page, jobs):
    page.goto("/")
    line = page.evaluate(LINE, jobs["long"]["links"]["recording"])
    # Along the surface, the force is where it is to a fraction of an element of 10 mm.
    assert line["centre"][:2] == pytest.approx([0.003, 0], abs=2e-3)
    assert line["centre"][2] == pytest.approx(0.02, abs=1e-6)
    assert line["direction"] == pytest.approx([0, 0, -1], abs=1e-6)


def test_a_target_of_one_generated_part_is_called_by_its_name(page, jobs):
    open_job(page, jobs["long"])
    expect(page.locator(".overlay .layer-name")).to_have_text(["arm"])
    tissue = page.get_by_label("What happened to the tissue").get_by_role("listitem").first
    expect(tissue.locator("b")).to_have_text("tissue")


def test_card_and_plots_are_of_one_pair(page, jobs):
    summary = page.request.get(jobs["two"]["links"]["summary"]).json()["results"]
    impacts = summary["impacts"]
    pair = impacts[summary["headline"]["impact"]]["pair"]
    force = lambda impact: impact["peak_force_n"]["value"]
    assert max(impacts, key=force)["pair"] != pair, "another impact is harder, but not on the tissue"
    open_job(page, jobs["two"])
    expect(page.get_by_label("The four numbers").get_by_role("article").first).to_contain_text(pair)
    expect(plot(page, "Contact force").locator("figcaption")).to_contain_text(pair)


def test_no_value_is_read_where_a_run_has_none(page, jobs):
    open_job(page, jobs["long"])
    page.get_by_label("Simulated time", exact=True).press("Home")
    time, mean, step = legend(page, "Contact force")
    assert (time, mean) == ("0 ms", "–") and step.endswith("N")
    page.goto(f"/#/compare/{jobs['long']['id']}/{jobs['short']['id']}")
    page.get_by_label("Simulated time", exact=True).press("End")
    _, long, short = legend(page, "Impulse")
    assert long.endswith("N s") and short == "ended at 0.5000 ms"
    assert [text.split()[0] for text in page.locator(".stage .time-output").all_inner_texts()[:2]] == ["1.000", "ended"]


def test_a_run_without_contact_speaks_of_none(page, jobs):
    open_job(page, jobs["free"])
    expect(page.locator(".plots > :visible")).to_have_count(1)
    expect(page.locator("main")).to_contain_text("in this scene")
    # Nothing is held, so nothing stands for bone.
    assert not any(words in page.locator("main").inner_text().lower() for words in ("contact had ended", "bone"))
