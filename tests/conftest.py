"""What holds for all tests: no deadlines, whose worker a test is, bounded memory, claims once."""

import gc
import os
import sys
from collections import Counter
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from hypothesis import settings
from xdist.scheduler import LoadFileScheduling

from tests.site.counts import COUNTS

settings.register_profile("book", settings(), deadline=None)  # no test asserts a time
settings.load_profile("book")

os.environ.pop("ROBOT_PERCEPTION_WORKERS", None)  # what a test makes up is in no other process

VISITS = "tests/site/test_pages.py::"
MOST = 1.0e9
"""Bytes that a worker may hold after a file of tests, before it forgets films and worlds."""
REMEMBER = ("data_synth.", "robot_perception.chapters.", "robot_perception.book.")
"""Packages that hold what they have rendered."""

COMPUTED: list[str] = []
"""Claims of the book that the running test has computed."""


class Scheduling(LoadFileScheduling):
    """A file is one worker's, for its tests share what they need; visits of pages share nothing."""

    def _split_scope(self, nodeid: str) -> str:
        return nodeid if nodeid.startswith(VISITS) else super()._split_scope(nodeid)


@pytest.hookimpl(optionalhook=True)
def pytest_xdist_make_scheduler(config: pytest.Config, log: Any) -> LoadFileScheduling | None:
    """Let any worker that is free visit the next page."""
    return Scheduling(config, log) if config.getvalue("dist") == "loadfile" else None


def pytest_collection_finish() -> None:
    """Take note of each claim of the book that is computed from now on."""
    # never imported before its checks
    studies = sys.modules.get("robot_perception.teaching.studies")
    if studies is None:
        return
    find = studies.Claim.find

    def noted(self: Any, size: str = "quick") -> Any:
        if self.compute.__module__.startswith("robot_perception.chapters"):
            COMPUTED.append(f"{self.id} ({size})")
        return find(self, size)

    studies.Claim.find = noted


@pytest.fixture(scope="module", autouse=True)
def _forgets() -> Iterator[None]:
    """After a file of tests let go of what worlds and chapters hold, where that is much."""
    yield
    if _held() > MOST:
        for name in [name for name in sys.modules if name.startswith(REMEMBER)]:
            for value in vars(sys.modules[name]).values():
                if hasattr(value, "cache_clear"):
                    value.cache_clear()
        gc.collect()


def _held() -> int:
    """Return the bytes of memory that this process holds; none where the system does not say."""
    pages = Path("/proc/self/statm")
    return int(pages.read_text().split()[1]) * os.sysconf("SC_PAGE_SIZE") if pages.exists() else 0


@pytest.hookimpl(wrapper=True)
def pytest_runtest_makereport(item: pytest.Item, call: pytest.CallInfo) -> Iterator[None]:
    """Say in the last report of a test which claims it computed."""
    if call.when == "teardown":
        item.user_properties += [("claim", name) for name in COMPUTED]
        COMPUTED.clear()
    return (yield)


def _noted(terminalreporter: Any, when: str) -> Iterator[tuple[str, Any]]:
    """Yield what tests on all workers noted of themselves."""
    for reports in terminalreporter.stats.values():
        for report in reports:
            if getattr(report, "when", "") == when:
                yield from getattr(report, "user_properties", ())


def _twice(terminalreporter: Any) -> list[str]:
    """Return the claims that were computed more than once."""
    names = Counter(
        value for name, value in _noted(terminalreporter, "teardown") if name == "claim"
    )
    return sorted(name for name, count in names.items() if count > 1)


def pytest_sessionfinish(session: pytest.Session) -> None:
    """Let the run fail if a claim was computed twice."""
    terminalreporter = session.config.pluginmanager.get_plugin("terminalreporter")
    if session.exitstatus == 0 and terminalreporter is not None and _twice(terminalreporter):
        session.exitstatus = pytest.ExitCode.TESTS_FAILED


def pytest_terminal_summary(terminalreporter: Any) -> None:
    """Print which claims were computed twice, and what was seen of the site, over all workers."""
    if twice := _twice(terminalreporter):
        terminalreporter.section("claims computed more than once: let their tests share a finding")
        for name in twice:
            terminalreporter.write_line(name)
    seen = [
        (name.removeprefix("site: "), value)
        for name, value in _noted(terminalreporter, "call")
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
