"""What holds for all tests: no deadlines, whose worker a test is, bounded memory, what was seen."""

import gc
import json
import os
import subprocess
import sys
from collections import Counter
from collections.abc import Iterator
from contextlib import ExitStack
from pathlib import Path
from typing import Any
from unittest.mock import patch

import pytest
from hypothesis import settings
from jupyter_client.provisioning import KernelProvisionerFactory
from playwright.sync_api import Browser, sync_playwright
from xdist.scheduler import LoadFileScheduling
from xdist.workermanage import WorkerController

from studies.pages.forked import CAN_FORK, Forked, forked_kernels
from studies.pages.forked import NAME as FORKED
from tests.proof import RECORD, SECONDS, WHOLE
from tests.site.browser import launch
from tests.site.counts import COUNTS

# No test asserts a time; `make test` is green or red by the code alone, not by luck.
settings.register_profile("book", settings(), deadline=None, derandomize=not WHOLE)
settings.load_profile("book")

os.environ.pop("STUDIES_WORKERS", None)  # what a test makes up is in no other process

VISITS = "tests/site/test_pages.py::"
MOST = 1.0e9
"""Bytes that a worker may hold beyond what it held at first, before it forgets films and worlds."""
FIRST = pytest.StashKey[int]()
"""Bytes that a worker held once it had collected all tests."""
REMEMBER = ("data_synth.", "robot_perception.chapters.", "robot_perception.book.")
"""Packages that hold what they have rendered."""


class Scheduling(LoadFileScheduling):
    """A file is one worker's, for its tests share what they need; visits of pages share nothing.

    Work that took longest when it was last recorded comes first, so that workers end together.
    """

    def __init__(self, config: pytest.Config, log: Any) -> None:
        super().__init__(config, log)
        self.took: dict[str, float] = json.loads(RECORD.read_text("utf-8"))["files"]

    def _split_scope(self, nodeid: str) -> str:
        return scope(nodeid)

    def _assign_work_unit(self, node: WorkerController) -> None:
        longest = max(self.workqueue, key=lambda unit: self.took.get(unit, 0.0))
        self.workqueue.move_to_end(longest, last=False)
        super()._assign_work_unit(node)


def scope(nodeid: str) -> str:
    """Return what is handed to one worker: a visit of a page, or a file of tests."""
    return nodeid if nodeid.startswith(VISITS) else nodeid.partition("::")[0]


@pytest.hookimpl(optionalhook=True)
def pytest_xdist_make_scheduler(config: pytest.Config, log: Any) -> LoadFileScheduling | None:
    """Let any worker that is free visit the next page."""
    return Scheduling(config, log) if config.getvalue("dist") == "loadfile" else None


def pytest_collection_finish(session: pytest.Session) -> None:
    """Take what was collected out of the search for garbage, which else reads it again each time.

    A worker collects all tests, some millions of objects: to look through them takes seconds.
    """
    gc.collect()
    gc.freeze()
    session.stash[FIRST] = _held()


@pytest.fixture(scope="module", autouse=True)
def _forgets(request: pytest.FixtureRequest) -> Iterator[None]:
    """After a file of tests let go of what worlds and chapters hold, where that is much."""
    yield
    if _held() > request.session.stash[FIRST] + MOST:
        for name in [name for name in sys.modules if name.startswith(REMEMBER)]:
            for value in vars(sys.modules[name]).values():
                if hasattr(value, "cache_clear"):
                    value.cache_clear()
        gc.collect()


def _held() -> int:
    """Return the bytes of memory that this process holds; none where the system does not say."""
    pages = Path("/proc/self/statm")
    return int(pages.read_text().split()[1]) * os.sysconf("SC_PAGE_SIZE") if pages.exists() else 0


@pytest.fixture(scope="session")
def browser() -> Iterator[Browser]:
    """The system's Chromium, one for all that a worker visits."""
    with sync_playwright() as playwright:
        found = launch(playwright)
        if found is None:
            pytest.skip("no Chromium on this machine; install the package chromium")
        yield found
        found.close()


class Kernels:
    """Has the kernels of notebooks forked, as the build does: they have then imported the most."""

    def __init__(self) -> None:
        self.held = ExitStack()
        self.server: subprocess.Popen | None = None

    @pytest.hookimpl(wrapper=True)
    def pytest_runtest_setup(self, item: pytest.Item) -> Iterator[None]:
        """Lend nbval the process that kernels are forked from."""
        if item.path.suffix != ".ipynb" or not CAN_FORK:
            return (yield)
        factory = KernelProvisionerFactory.instance()
        before, other = factory.default_provisioner_name, Forked.server
        if self.server is None:
            self.held.enter_context(forked_kernels())
            self.server = Forked.server
        Forked.server, factory.default_provisioner_name = self.server, FORKED
        try:
            return (yield)
        finally:
            Forked.server, factory.default_provisioner_name = other, before

    def pytest_sessionfinish(self) -> None:
        """Let the process end."""
        with patch.object(Forked, "server", self.server):
            self.held.close()


def pytest_configure(config: pytest.Config) -> None:
    """Notebooks lie outside of this folder, where the hooks of this file do not reach."""
    config.pluginmanager.register(Kernels())


def _noted(terminalreporter: Any) -> Iterator[tuple[str, Any]]:
    """Yield what tests on all workers noted of themselves."""
    for reports in terminalreporter.stats.values():
        for report in reports:
            if getattr(report, "when", "") == "call":
                yield from getattr(report, "user_properties", ())


def pytest_sessionfinish(session: pytest.Session) -> None:
    """Keep beside the build how long each file of tests took, over all workers."""
    reporter = session.config.pluginmanager.get_plugin("terminalreporter")
    if reporter is None or not SECONDS.parent.is_dir():
        return
    took: Counter[str] = Counter()
    for report in (one for reports in reporter.stats.values() for one in reports):
        if hasattr(report, "duration"):
            took[scope(report.nodeid)] += report.duration
    SECONDS.write_text(json.dumps(took.most_common(), indent=0), encoding="utf-8")


def pytest_terminal_summary(terminalreporter: Any) -> None:
    """Print what was seen of the site, over all workers."""
    seen = [
        (name.removeprefix("site: "), value)
        for name, value in _noted(terminalreporter)
        if name.startswith("site: ")
    ]
    if not seen:
        return
    totals: Counter[str] = Counter()
    for name, value in seen:
        totals[name] += value
    terminalreporter.section("the built site in Chromium")
    for name in COUNTS:
        terminalreporter.write_line(f"{totals[name]:6d}  {name}")
