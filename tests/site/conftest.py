"""The built site, served on loopback, opened in the system's Chromium, and counted."""

import fcntl
import functools
import os
import subprocess
import sys
import threading
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from http.server import SimpleHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path

import pytest
from playwright.sync_api import Browser, BrowserContext, Page

from tests.proof import WHOLE
from tests.site.browser import PATIENCE_MS, WINDOW
from tests.site.choice import VISITS, Sound, chosen, commit
from tests.site.contents import PAGES
from tests.site.counts import COUNTS

ROOT = Path(__file__).parents[2]
ALWAYS = (PAGES[0], "scorecard")
"""Pages that every run visits."""


def _sound(site: str) -> Sound:
    return Sound((ROOT / site).resolve(), ROOT / "build" / "visited")


def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    """Leave out visits of pages that nothing has changed, unless they are asked for by name."""
    site = os.environ.get("ROBOT_PERCEPTION_SITE")
    if WHOLE or not site or any("::" in asked for asked in config.args):
        return
    visits = [item.nodeid for item in items if item.nodeid.startswith(VISITS)]
    left = {*visits} - {*chosen(visits, _sound(site), PAGES, ALWAYS, commit())}
    config.hook.pytest_deselected(items=[item for item in items if item.nodeid in left])
    items[:] = [item for item in items if item.nodeid not in left]


def pytest_runtest_logreport(report: pytest.TestReport) -> None:
    """Keep which visits found their page sound."""
    site = os.environ.get("ROBOT_PERCEPTION_SITE")
    if site and report.when == "call" and report.nodeid.startswith(VISITS):
        sound = _sound(site)
        (sound.note if report.passed else sound.forget)(report.nodeid)


@dataclass
class Visit:
    """A page that is open, and what went wrong on it."""

    page: Page
    own: tuple[str, ...]
    errors: list[str] = field(default_factory=list)
    strangers: list[str] = field(default_factory=list)

    def __post_init__(self) -> None:
        """Listen to the console, to uncaught errors and to every request."""
        self.page.on("console", self._console)
        self.page.on("pageerror", lambda error: self.errors.append(f"uncaught: {error}"))
        self.page.on("request", self._request)
        self.page.on("requestfailed", lambda r: self.errors.append(f"failed: {r.url}"))

    def _console(self, message: object) -> None:
        if message.type in ("error", "warning"):
            self.errors.append(f"{message.type}: {message.text}")

    def _request(self, request: object) -> None:
        if not request.url.startswith((*self.own, "data:", "blob:", "about:")):
            self.strangers.append(request.url)

    def open(self, address: str) -> Page:
        """Open an address and wait until its formulas are set."""
        self.page.goto(address, wait_until="load")
        self.page.evaluate("async () => { await globalThis.MathJax?.startup?.promise; }")
        return self.page


@pytest.fixture(scope="session")
def site() -> Path:
    """The folder of the built site; built first unless ROBOT_PERCEPTION_SITE names one."""
    given = os.environ.get("ROBOT_PERCEPTION_SITE")
    if given:
        folder = (ROOT / given).resolve()
        assert (folder / "index.html").exists(), f"no site at ROBOT_PERCEPTION_SITE={given}"
        return folder
    build = ROOT / "build"
    build.mkdir(exist_ok=True)
    options = ["--config", "_config.yml", "--path-output", "build", "-W", "--keep-going"]
    with (build / ".lock").open("w") as lock:  # one worker builds, the others wait
        fcntl.flock(lock, fcntl.LOCK_EX)
        subprocess.run(
            [Path(sys.executable).with_name("jupyter-book"), "build", "book", *options],
            cwd=ROOT,
            check=True,
        )
    return build / "_build" / "html"


@pytest.fixture(scope="session")
def address(site: Path) -> Iterator[str]:
    """The address under which the site is served on loopback."""

    class Quiet(SimpleHTTPRequestHandler):
        def log_message(self, *_: object) -> None:
            pass

    with ThreadingHTTPServer(
        ("127.0.0.1", 0), functools.partial(Quiet, directory=str(site))
    ) as server:
        threading.Thread(target=server.serve_forever, daemon=True).start()
        yield f"http://127.0.0.1:{server.server_port}/"
        server.shutdown()


@pytest.fixture
def visit(browser: Browser, address: str, site: Path) -> Iterator[Callable[..., Visit]]:
    """Make visits, each in a fresh context; keyword arguments go to the browser context."""
    contexts: list[BrowserContext] = []

    def make(**options: object) -> Visit:
        context = browser.new_context(**({"viewport": WINDOW} | options))
        context.set_default_navigation_timeout(PATIENCE_MS)
        contexts.append(context)
        return Visit(context.new_page(), (address, site.as_uri()))

    yield make
    for context in contexts:
        context.close()


@pytest.fixture
def count(record_property: Callable[[str, object], None]) -> Callable[[str, int], None]:
    """Add to one line of the summary."""

    def add(name: str, number: int) -> None:
        assert name in COUNTS, name
        record_property(f"site: {name}", number)

    return add
