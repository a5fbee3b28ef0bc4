"""Prints how fast the page of a finished job is, for the main scene and for it with half and twice the elements in each direction.

    CONTUSE=target/release/contuse python tests/browser/measure_page.py

Each page is opened in a browser with an empty cache: time until its first frame is drawn, until the whole recording is read, for one
place of the slider, and the memory of its scripts. Without a graphics card.
"""

import json
import shutil
import tempfile
import time

from conftest import FLAGS, PATIENCE_MS, ROOT, Service
from playwright.sync_api import sync_playwright

# When the picture is there, in milliseconds since the navigation.
FIRST_FRAME = """() => {
  const look = () => {
    if (document.querySelector(".stage .mesh-view canvas")) requestAnimationFrame(() => (window.firstFrame = performance.now()));
    else requestAnimationFrame(look);
  };
  if (window === window.top) requestAnimationFrame(look);
}"""
# Mean time of a place of the slider, of each frame drawn after it was set [ms].
SLIDER = """async () => {
  const slider = document.querySelector("input[aria-label='Simulated time']");
  const count = 20, last = Number(slider.max);
  const drawn = () => new Promise((done) => requestAnimationFrame(done));
  await drawn();
  const start = performance.now();
  for (let i = 0; i < count; i++) {
    slider.value = (last * i) / count;
    slider.dispatchEvent(new Event("input", { bubbles: true }));
    await drawn();
  }
  return (performance.now() - start) / count;
}"""
TRANSFERRED = "() => performance.getEntriesByType('resource').reduce((sum, one) => sum + one.transferSize, 0)"


def finer(count, factor):
    return max(1, round(factor * count))


def scene(factor):
    """The main scene, with `factor` times the elements in each direction."""
    document = json.loads((ROOT / "scenarios/flashball_thigh/scene.json").read_text())
    for body in document["bodies"]:
        generator = body["mesh"]["generator"]
        for name in [name for name in generator if name.startswith("elements")]:
            value = generator[name]
            generator[name] = [finer(one, factor) for one in value] if isinstance(value, list) else finer(value, factor)
    return document


def finished(page, document):
    """The job of a scene, when it has ended, and its number of elements."""
    answer = page.request.post("/v1/jobs", data=document)
    assert answer.status == 202, answer.text()
    place = answer.headers["location"]
    while (job := page.request.get(place).json())["state"] in ("queued", "running"):
        time.sleep(0.2)
    assert job["state"] == "succeeded", job
    return job


def measured(browser, address, job):
    context = browser.new_context(base_url=address, viewport={"width": 1440, "height": 900}, reduced_motion="reduce")
    page = context.new_page()
    page.add_init_script(f"({FIRST_FRAME})()")
    page.goto(f"/#/job/{job['id']}")
    page.wait_for_selector(".plots .u-over", timeout=PATIENCE_MS)
    whole = page.evaluate("performance.now()")
    row = page.evaluate("window.firstFrame"), whole, page.evaluate(SLIDER), page.evaluate("performance.memory.usedJSHeapSize"), page.evaluate(TRANSFERRED)
    context.close()
    return row


def main():
    with tempfile.TemporaryDirectory() as data, sync_playwright() as playwright:
        service = Service(data)
        browser = playwright.chromium.launch(executable_path=shutil.which("chromium"), args=FLAGS)
        page = browser.new_context(base_url=service.address).new_page()
        print("| elements | first frame, ms | recording read, ms | a place of the slider, ms | memory of scripts, MB | transferred, MB |")
        print("|---|---|---|---|---|---|")
        for factor in (0.5, 1, 2):
            elements = page.request.post("/v1/jobs/validate", data=scene(factor)).json()["plan"]["elements"]
            job = finished(page, scene(factor))
            first, whole, slider, heap, bytes_ = measured(browser, service.address, job)
            print(f"| {elements} | {first:.0f} | {whole:.0f} | {slider:.0f} | {heap / 1e6:.0f} | {bytes_ / 1e6:.1f} |")
        browser.close()
        service.stop()


if __name__ == "__main__":
    main()
