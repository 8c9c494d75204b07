"""How long a picture takes: what the benchmarks recorded, beside the paper's second."""

import json
from dataclasses import dataclass
from typing import Any

import numpy as np

from robot_perception.evaluation.intervals import exact
from robot_perception.teaching.claims import Finding
from robot_perception.teaching.records import records
from robot_perception.teaching.studies import Change, Study
from robot_perception.teaching.verdicts import Accepted, Origin

PAPER = "companion-robot"
WHOLE, SHAPES = "arms tracked by all cues", "arms in outline"
"""How two rows of the benchmarks begin: a film, and the silhouettes of a picture."""
IMAGES = 39
"""Of the film."""


@dataclass(frozen=True, slots=True)
class Config:
    """Which of the times counts.

    Parameters
    ----------
    textbook
        Whether the silhouettes are computed as the equations are written, one state after another.
    """

    textbook: bool = False


Times = tuple[Config, float, float, float]
"""What is asked; seconds a picture of all, of the silhouettes, and of these as written."""


def recorded_row(work: str) -> dict[str, Any]:
    """Return the row of the benchmarks that begins so.

    Raises
    ------
    LookupError
        If there is none.
    """
    rows = json.loads((records() / "performance.json").read_text(encoding="utf-8"))["rows"]
    for row in rows:
        if row["work"].startswith(work):
            return row
    raise LookupError(f"performance.json has no row {work!r}; `make bench` records one")


def run(config: Config, *, rng: np.random.Generator) -> Times:
    """Read the recorded times."""
    whole, shapes = recorded_row(WHOLE), recorded_row(SHAPES)
    return config, whole["ours_s"] / IMAGES, shapes["ours_s"], shapes["peer_s"]


second = Study(run, full=Config(), quick=Config())


@second.claim(
    "one-second",
    paper=PAPER,
    place="§V, “Implementation”",
    basis="substitute",
    statement="Both arms are tracked in about a second a picture.",
    paper_value="“a PentiumIV-3GHz requires about 1s per frame to process the two arm tracking”",
    method="Recorded by the benchmarks on one core of the machine that the page on performance "
    "names: flow, edges, distance transforms and two stages of 400 particles by all cues, "
    "320 × 240; seconds a picture. No machine of 2006 was to be had.",
    accepted=Accepted(0.0, 1.0, "the paper's second, or less", Origin.PAPER),
    sabotage=Change("silhouettes as the equations are written", textbook=True),
)
def one_second(found: Times) -> Finding:
    """Tell what a picture takes."""
    config, whole, shapes, written = found
    value = whole - shapes + written if config.textbook else whole
    return Finding(exact(value, "s"), {"pictures a second": exact(1 / whole)})
