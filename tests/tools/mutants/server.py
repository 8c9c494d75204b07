"""Forks a run of pytest for each planted error, where all that is not ours is imported already.

``__main__`` starts it in a copy of the repository. A line of JSON asks for a run, another tells.
"""

import contextlib
import importlib
import json
import os
import resource
import signal
import sys
import tempfile
from collections import Counter
from pathlib import Path
from typing import Any

import pytest

FOREIGN = """IPython.display PIL.Image beartype cv2 filterpy.kalman grimp hypothesis.extra.numpy
ipywidgets joblib jupyter_client matplotlib.pyplot nbclient numba numpy pooch scipy.linalg
scipy.ndimage scipy.optimize scipy.spatial scipy.stats sphinx.application sympy"""
NBVAL = "-pno:nbval"  # to import it takes longer than most tests
PYTEST = ["-xq", "--tb=line", "-rfE", "--hypothesis-seed=0", "-m", "not slow"]
PYTEST += ["--hypothesis-profile=planted", "-pno:cacheprovider", "-pno:anyio"]


class Order:
    """Plugin: tests named come first, in their order; takes note of seconds and of what failed."""

    def __init__(self, first: list[str]) -> None:
        self.rank = {test: i for i, test in enumerate(first)}
        self.seconds: Counter[str] = Counter()
        self.failed: list[str] = []

    def pytest_collection_modifyitems(self, items: list[pytest.Item]) -> None:
        items.sort(key=lambda item: self.rank.get(item.nodeid, len(self.rank)))

    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        self.seconds[report.nodeid] += report.duration
        if report.failed:
            self.failed.append(report.nodeid)


def prepare() -> None:
    """Import what the tests need but for our own code, and let numba get ready to compile."""
    for name in FOREIGN.split():
        importlib.import_module(name)
    import numba
    import numpy as np
    from hypothesis import Phase, settings

    numba.njit(lambda a: a @ a + 1.0)(np.eye(2))
    phases = (Phase.explicit, Phase.generate)  # that there is a counter-example is enough
    settings.register_profile("planted", deadline=None, database=None, phases=phases)


def run(asked: dict[str, Any], folder: Path) -> int:
    """Run pytest, in a process of its own, and leave in a folder what it said."""
    os.setsid()
    limit = asked["limit"] or resource.RLIM_INFINITY
    resource.setrlimit(resource.RLIMIT_CPU, (limit, resource.RLIM_INFINITY))
    os.dup2(os.open(os.devnull, os.O_RDONLY), 0)
    for stream in (1, 2):
        os.dup2(os.open(folder / "output", os.O_CREAT | os.O_WRONLY | os.O_APPEND), stream)
    os.environ["HYPOTHESIS_STORAGE_DIRECTORY"] = str(folder)
    order = Order(asked["first"])
    words = [*PYTEST, f"--basetemp={folder / 'tests'}", *asked["tests"]]
    if not any(word.endswith(".ipynb") for word in asked["tests"]):
        words.append(NBVAL)
    code = pytest.main(words, [order])
    imports = True
    if code > 1:
        try:
            importlib.import_module(asked["module"])
        except Exception:
            imports = False
    said = {"seconds": order.seconds, "failed": order.failed, "imports": imports}
    (folder / "said").write_text(json.dumps(said))
    return int(code)


def answer(asked: dict[str, Any]) -> dict[str, Any]:
    """Return the exit code of a run, ``None`` if it had to be ended, its time and what it said."""
    with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as place:
        folder = Path(place)
        child = os.fork()
        if not child:
            code = 3
            with contextlib.suppress(BaseException):
                code = run(asked, folder)
            os._exit(code)
        signal.signal(signal.SIGALRM, lambda *_: os.killpg(child, signal.SIGKILL))
        signal.alarm(10 * asked["limit"])  # seconds by the clock; none is no limit
        _, status, used = os.wait4(child, 0)
        late = not signal.alarm(0) and asked["limit"]
        signal.signal(signal.SIGALRM, signal.SIG_DFL)
        with contextlib.suppress(ProcessLookupError):
            os.killpg(child, signal.SIGKILL)  # what it has left running
        code = os.waitstatus_to_exitcode(status)
        said = folder / "said"
        return {
            "code": None if late or code == -signal.SIGXCPU else code,
            "time": used.ru_utime + used.ru_stime,
            "output": (folder / "output").read_text(errors="replace"),
            **(json.loads(said.read_text()) if said.exists() else {}),
        }


if __name__ == "__main__":
    with os.fdopen(os.dup(1), "w") as answers:
        os.dup2(2, 1)
        prepare()
        for line in sys.stdin:
            print(json.dumps(answer(json.loads(line))), file=answers, flush=True)
