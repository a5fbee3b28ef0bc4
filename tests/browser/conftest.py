"""A service on a free port with an empty data folder, and a Chromium with an empty profile that records what it receives.

    CONTUSE=target/release/contuse pytest tests/browser

`CONTUSE_PICTURES=docs/pictures` also takes the pictures of docs/service.md.
"""

import os
import re
import shutil
import subprocess
from pathlib import Path

import pytest
from playwright.sync_api import expect, sync_playwright

ROOT = Path(__file__).resolve().parents[2]
BINARY = Path(os.environ.get("CONTUSE", ROOT / "target/release/contuse"))
# WebGL without a graphics card, and a browser that contacts no server by itself.
FLAGS = """--headless --no-sandbox --disable-gpu --disable-quic --no-first-run --disable-background-networking
    --disable-component-update --disable-sync --use-gl=angle --use-angle=swiftshader --enable-unsafe-swiftshader""".split()
# Waits end when their condition holds; this is for what never comes.
PATIENCE_MS = 300_000
expect.set_options(timeout=PATIENCE_MS)


class Service:
    """`contuse serve`, until it is stopped."""

    def __init__(self, data, *options):
        command = [BINARY, "serve", "--listen", "127.0.0.1:0", "--data", data, *options]
        self.process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True)
        # It says where it listens, or ends.
        words = self.process.stdout.readline()
        assert "http://" in words, f"the service did not start: {words!r}"
        self.address = words.split()[-1]

    def stop(self):
        self.process.terminate()
        self.process.communicate(timeout=60)


@pytest.fixture(scope="session")
def service(tmp_path_factory):
    service = Service(tmp_path_factory.mktemp("service"))
    yield service
    service.stop()


@pytest.fixture(scope="session")
def browser():
    chromium = shutil.which("chromium")
    assert chromium, "Debian's package `chromium` is needed"
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=chromium, args=FLAGS)
        yield browser
        browser.close()


class Watch:
    """What a page says and asks for: nothing may break, and nothing may leave the service."""

    def __init__(self, page):
        self.errors, self.hosts = [], set()
        page.on("pageerror", lambda error: self.errors.append(str(error)))
        page.on("console", lambda message: self.hear(message))
        page.on("request", lambda request: self.hosts.add(re.sub(r"^(\w+://[^/]*|\w+:).*", r"\1", request.url, flags=re.DOTALL)))

    def hear(self, message):
        # That a scene is refused is an answer; the browser writes every such answer into its console.
        if message.type == "error" and not re.search(r"status of (400|401|422)", message.text):
            self.errors.append(message.text)


def open_page(browser, address, **options):
    # Nothing plays by itself, so that what is seen does not depend on the clock.
    page = browser.new_page(base_url=address, viewport={"width": 1440, "height": 1000}, reduced_motion="reduce", **options)
    page.set_default_timeout(PATIENCE_MS)
    page.watch = Watch(page)
    return page


@pytest.fixture(scope="session")
def page(browser, service):
    page = open_page(browser, service.address)
    yield page
    page.close()


@pytest.fixture(scope="session")
def pictures():
    """The folder for the pictures of docs/service.md, if they are wanted."""
    folder = os.environ.get("CONTUSE_PICTURES")
    return Path(folder) if folder else None
