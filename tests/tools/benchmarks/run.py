"""Run every benchmark on one core, print the table, record it."""

import os
import platform
from datetime import date
from importlib import import_module
from importlib.metadata import version
from pathlib import Path

import click
from tqdm import tqdm

from robot_perception.teaching.scores import performance
from tests.tools.benchmarks.harness import Timing, measure

FOLDER = Path(__file__).parent
PEERS = (
    "filterpy",
    "roboticstoolbox-python",
    "fastrdp",
    "shapely",
    "simplification",
    "stonesoup",
    "opencv-python-headless",
    "numpy",
    "scipy",
    "numba",
)


def machine() -> str:
    """Return a short description of the processor."""
    info = Path("/proc/cpuinfo")
    models = [
        line.split(":", 1)[1].strip()
        for line in (info.read_text().splitlines() if info.exists() else [])
        if line.startswith("model name")
    ]
    return f"{models[0] if models else platform.processor()}, {os.cpu_count()} cores"


def line(timing: Timing) -> str:
    """Return one line of the printed table."""
    peer = "" if timing.peer_s is None else f"{timing.peer_name} {timing.peer_s * 1e3:.4g} ms"
    ratio = "" if timing.ratio is None else f"{timing.ratio:.4g}×"
    reached = "reached" if timing.reached else "NOT reached"
    ours = f"{timing.ours_s * 1e3:.4g} ms"
    return f"{timing.work:58s} {ours:>12s}  {peer:>28s} {ratio:>8s}  {timing.target:26s} {reached}"


@click.command()
@click.option("--write", type=click.Path(dir_okay=False, path_type=Path), help="Record as JSON.")
@click.option("--only", default="", help="Only the modules whose name contains this.")
def main(write: Path | None, only: str) -> None:
    """Measure every row of every ``bench_*.py`` beside this file."""
    modules = sorted(p.stem for p in FOLDER.glob("bench_*.py") if only in p.stem)
    timings = []
    for name in modules:
        module = import_module(f"tests.tools.benchmarks.{name}")
        for row in tqdm(module.rows(), desc=name, leave=False):
            timings.append(row if isinstance(row, Timing) else measure(row))
            click.echo(line(timings[-1]))
    reached = sum(t.reached for t in timings)
    click.echo(f"{reached} of {len(timings)} rows reached, on {machine()}")
    if write is not None:
        document = {
            "date": str(date.today()),
            "machine": machine(),
            "versions": {name: version(name) for name in PEERS},
            "rows": [
                {
                    "work": t.work,
                    "ours_s": t.ours_s,
                    "peer": t.peer_name,
                    "peer_s": t.peer_s,
                    "ratio": t.ratio,
                    "target": t.target,
                    "reached": t.reached,
                }
                for t in timings
            ],
        }
        performance.write(document, write)


if __name__ == "__main__":
    main()
