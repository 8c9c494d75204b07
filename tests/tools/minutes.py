"""Time the proof as a newcomer meets it: ``make minutes``.

A new clone of the last commit with empty caches is set up, built and tested, and then one change
each of three kinds is checked. Nothing else should run meanwhile. What each command took, and each
file of tests, is written to ``tests/tools/minutes.json``: a test compares the README with it, and
the tests that took longest start first. Computers differ, so a fixed loop of plain Python is timed
beside it.
"""

import argparse
import json
import os
import platform
import resource
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from datetime import date
from pathlib import Path
from typing import Any

from tests.proof import RECORD, SECONDS

ROOT = Path(__file__).parents[2]
FROM_NOTHING = ("setup", "book", "test")
"""What a newcomer runs, in this order."""
SHORT = 1.0
"""Files of tests that took less are not recorded, s."""


def reworded(text: str) -> str:
    """Change a word of prose in the notebook on covariance intersection."""
    cells = json.loads(text)
    prose = [cell for cell in cells["cells"] if cell["cell_type"] == "markdown"]
    prose[1]["source"][-1] = f"{prose[1]['source'][-1]} Indeed."
    return json.dumps(cells, indent=1, ensure_ascii=False) + "\n"


def renamed(text: str) -> str:
    """Change how a study cell of that notebook computes a product, not what."""
    return text.replace(
        "first**2 + second**2 + 2 * reach * first * second",
        "first**2 + second**2 + 2 * (reach * first * second)",
    )


def restated(text: str) -> str:
    """Change how a filter's prediction computes a product, not what."""
    return text.replace("F @ prior.cov @ F.mT + Q", "F @ (prior.cov @ F.mT) + Q")


CHANGES: dict[str, tuple[str, Callable[[str], str]]] = {
    "check a word": ("book/covariance_intersection.ipynb", reworded),
    "check a study cell": ("book/covariance_intersection.ipynb", renamed),
    "check a function": ("lib/robot_perception/kalman.py", restated),
}
"""By what is timed: the file that is changed, and how."""


def timed(
    clone: Path, *command: str, environment: dict[str, str], green: bool = True
) -> dict[str, float]:
    """Run a command and return its seconds by the clock and of the processor; print its end.

    Raises
    ------
    SystemExit
        If it fails and should be green; what it said is printed.
    """
    used, start = _used(), time.monotonic()
    done = subprocess.run(
        command, cwd=clone, env=environment, stdout=subprocess.PIPE, stderr=subprocess.STDOUT
    )
    took = {"clock": round(time.monotonic() - start), "processor": round(_used() - used)}
    said = done.stdout.decode(errors="replace")
    print(f"{' '.join(command)}: {took['clock']} s, {took['processor']} s of the processor")
    print(*said.splitlines()[-3:], sep="\n", flush=True)
    if done.returncode and green:
        sys.exit(said[-20_000:])
    return took


def loop() -> float:
    """Time ten million steps of plain Python, s: the best of five, alone on a core."""

    def once() -> float:
        start = time.perf_counter()
        sum(number * number for number in range(10_000_000))
        return time.perf_counter() - start

    return min(once() for _ in range(5))


def _used() -> float:
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def measure(folder: Path) -> dict[str, Any]:
    """Return how long everything took in a new clone below a folder."""
    clone = folder / "clone"
    subprocess.run(["git", "clone", "-q", str(ROOT), str(clone)], check=True)
    environment = os.environ | {"ROBOT_PERCEPTION_CACHE": str(folder / "cache")}
    for name in ("PYTHONPATH", "NUMBA_CACHE_DIR"):
        environment.pop(name, None)
    took = {name: timed(clone, "make", name, environment=environment) for name in FROM_NOTHING}
    files = json.loads((clone / SECONDS.relative_to(ROOT)).read_text("utf-8"))
    took["book again"] = timed(clone, "make", "book", environment=environment)
    for name, (file, change) in CHANGES.items():
        path = clone / file
        before = path.read_text("utf-8")
        after = change(before)
        if after == before:
            raise ValueError(f"{name}: nothing in {file} is what should be changed")
        path.write_text(after, "utf-8")
        # a change of code is red until the keys of recorded rows are renewed: that is its answer
        took[name] = timed(clone, "make", "check", environment=environment, green=False)
        path.write_text(before, "utf-8")
    return {
        "date": date.today().isoformat(),
        "commit": _git("rev-parse", "--short=8", "HEAD"),
        "processor": platform.processor() or platform.machine(),
        "cores": os.cpu_count(),
        "loop": round(loop(), 2),
        "seconds": took,
        "files": {name: round(seconds, 1) for name, seconds in files if seconds >= SHORT},
    }


def _git(*words: str) -> str:
    run = ["git", "-C", str(ROOT), *words]
    return subprocess.run(run, check=True, capture_output=True, text=True).stdout.strip()


def main() -> None:
    """Measure, print, and write if that is asked for."""
    ask = argparse.ArgumentParser(prog="tests.tools.minutes", description=__doc__)
    ask.add_argument("--write", action="store_true", help="write the record")
    asked = ask.parse_args()
    with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as folder:
        found = measure(Path(folder))
    text = json.dumps(found, indent=1, ensure_ascii=False) + "\n"
    if asked.write:
        RECORD.write_text(text, encoding="utf-8")
    else:
        print(text)


if __name__ == "__main__":
    main()
