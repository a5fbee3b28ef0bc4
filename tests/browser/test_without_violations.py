"""No page has anything that axe-core finds fault with, at any of three sizes, and none is wider than the screen of a telephone."""

import json

import pytest
from axe_playwright_python.sync_playwright import Axe
from playwright.sync_api import expect
from test_what_is_said import post


@pytest.fixture(scope="module")
def job(page):
    presets = {preset["file"]: preset["scene"] for preset in page.request.get("/viewer/presets.json").json()}
    return post(page, "/v1/jobs", presets["flashball_thigh/scene_elastic.json"])["id"]


@pytest.fixture(scope="module")
def study(page):
    presets = {preset["file"]: preset["scene"] for preset in page.request.get("/viewer/presets.json").json()}
    return post(page, "/v1/studies", {"kind": "error", "scene": presets["bar_on_wall/scene.json"], "coarsest": -1, "finest": 0})["id"]


PAGES = {"#/": "table", "#/new": ".scene-picture canvas", "#/job/{job}": ".plots .u-over", "#/compare/{job}/{job}": ".plots .u-over", "#/what-if/{job}": "input", "#/ask": "select", "#/job/{study}": ".error-cost", "docs/": "h2"}


BEYOND_THE_SCREEN = """() => [...document.querySelectorAll("main :not(svg *)")].filter((one) => one.checkVisibility() && one.getBoundingClientRect().width)
  .filter((one) => one.getBoundingClientRect().right > innerWidth).map((one) => one.outerHTML.slice(0, 160))"""


@pytest.mark.parametrize("path", PAGES)
@pytest.mark.parametrize("size", [(1440, 900), (820, 1180), (390, 844)], ids=str)
def test_no_violations(page, job, study, path, size):
    page.set_viewport_size({"width": size[0], "height": size[1]})
    page.goto("/")
    page.goto("/" + path.format(job=job, study=study))
    expect(page.locator("main").locator(PAGES[path]).first).to_be_visible()
    page.evaluate("document.querySelectorAll('main details').forEach((one) => (one.open = true))")
    found = Axe().run(page).response["violations"]
    assert found == [], json.dumps([(one["id"], [node["html"][:160] for node in one["nodes"][:3]]) for one in found], indent=1)
    if size[0] == 390:
        assert page.evaluate(BEYOND_THE_SCREEN) == []
    page.set_viewport_size({"width": 1440, "height": 1000})
