"""How often a learned path is reproduced: section 2.4.

Ceilings, starts and what is other than when the path was learned; `replays` drives.
"""

from dataclasses import dataclass, replace
from functools import partial

import numpy as np
from jaxtyping import Float

from robot_perception.chapters.ceiling_navigation import runs
from robot_perception.chapters.ceiling_navigation.replays import Lesson, Trial, replay
from robot_perception.chapters.ceiling_navigation.world import PAPER
from robot_perception.evaluation.intervals import Interval, bootstrap_mean, proportion
from robot_perception.evaluation.sweep import sweep
from robot_perception.teaching.claims import Finding
from robot_perception.teaching.studies import Change, Study
from robot_perception.teaching.tables import Table
from robot_perception.teaching.verdicts import Accepted, Origin

TILT = np.deg2rad(5.0)
TRUE, SCALED, HEADS, ONE, REPEATED, TILTED, PAINTED = (
    "true scale",
    "scale half as large again",
    "six heads in the way",
    "one pattern in common is enough",
    "a ceiling that repeats",
    "camera tilted by 5° since",
    "ceiling painted white since",
)
CHANGES = {
    TRUE: ({}, {}),
    SCALED: ({}, {"factor": 1.5}),
    HEADS: ({}, {"heads": 6}),
    ONE: ({"common": 1}, {}),
    REPEATED: ({"plan": "repeated"}, {}),
    TILTED: ({}, {"tilt": TILT}),
    PAINTED: ({}, {"plan": "plain"}),
}
"""What is other than in the first variant, when the path is learned and when it is driven."""


@dataclass(frozen=True, slots=True)
class Config:
    """Ceilings, starts below each, and variants; all values are ours.

    The first variant is the claim's, with ``starts`` below each ceiling, the others with one.
    """

    seeds: tuple[int, ...] = runs.SCORING[:10]
    starts: int = 2
    variants: tuple[str, ...] = (SCALED, TRUE, HEADS, ONE, REPEATED, TILTED)
    most: float = 5.0


@dataclass(frozen=True, eq=False, slots=True)
class Result:
    """Of each variant: mean distance of the path from what was driven and of the ends, m.

    ``arrived`` and ``reproduced`` tell what became of each drive.
    """

    off: dict[str, Float[np.ndarray, " drives"]]
    end: dict[str, Float[np.ndarray, " drives"]]
    arrived: dict[str, np.ndarray]
    reproduced: dict[str, np.ndarray]

    @property
    def claimed(self) -> str:
        """The variant of the claim."""
        return next(iter(self.off))


def run(config: Config, *, rng: np.random.Generator) -> Result:
    """Drive paths again, below every ceiling, in every variant."""
    rows: dict[str, list] = {}
    for variant in config.variants:
        learned, driven = CHANGES[variant]
        starts = config.starts if variant == config.variants[0] else 1
        items = [(seed, k + 1) for seed in config.seeds for k in range(starts)]
        of, trial = Lesson(most=config.most, **learned), Trial(**driven)
        rows[variant] = sweep(partial(_one, of, trial), items, rng=rng, desc=variant)
    parts = (
        {v: np.array([row[k] for row in found]) for v, found in rows.items()} for k in range(4)
    )
    return Result(*parts)


def _one(
    of: Lesson, trial: Trial, item: tuple[int, int], *, rng: np.random.Generator
) -> tuple[float, float, bool, bool]:
    """Return how one drive went; its draws follow from its seed and number alone."""
    seed, number = item
    found = replay(replace(of, seed=seed), trial, number)
    return found.off, found.end, found.status == "arrived", found.reproduced


def share(found: Result) -> Interval:
    """Return the share of the claimed drives that reproduce the path."""
    fits = found.reproduced[found.claimed]
    return proportion(int(fits.sum()), len(fits))


def table(found: Result) -> Table:
    """Return what became of the drives of each variant."""
    rows = {}
    for variant, fits in found.reproduced.items():
        came = found.arrived[variant]
        off = bootstrap_mean(found.off[variant][came]) if came.sum() > 1 else ""
        rows[variant] = (len(fits), int(came.sum()), int(fits.sum()), off)
    columns = {
        "drives": "from places up to 30 cm and 14° beside the beginning",
        "arrived": "that came to the last key image, by their own account",
        "reproduced": "that were within 10 cm of the path on average, and of its end",
        "off (m)": "mean distance of the path from what was driven, of those that arrived",
    }
    return Table(rows, columns, "95 % bootstrap interval over drives", "variant")


replaying = Study(
    run,
    full=Config(),
    quick=Config(runs.SCORING[2:3], 2, (SCALED,), most=1.5),
    seed=77,
)


@replaying.claim(
    "visual-memory",
    paper=PAPER,
    place="§2.4, with §2.2",
    basis="substitute",
    statement="A robot reproduces a learned path from key image to key image by visual servoing, "
    "without calibration.",
    paper_value="“enables the mobile robot to reproduce learned trajectories”",
    method="A unicycle with slipping wheels is led round a corner below a rendered ceiling, then "
    "put down up to 30 cm and 14° beside the beginning, and drives by its pictures with a scale "
    "half as large again as the true one: share of the drives that arrive and stay within 10 cm of "
    "the path on average, and of its end.",
    accepted=Accepted(0.5, 1.0, "more often than not; the paper names no number", Origin.CHOICE),
    value=share,
    sabotage=Change(
        "a ceiling that was painted white since the path was learned", variants=(PAINTED,), starts=4
    ),
)
def reproduces(found: Result, value: Interval) -> Finding:
    """Drive learned paths again."""
    claimed = found.claimed
    came = found.arrived[claimed]
    evidence = {"off the path, of those that arrive": bootstrap_mean(found.off[claimed][came], "m")}
    for variant, fits in found.reproduced.items():
        if variant != claimed:
            evidence[f"reproduced, {variant}"] = proportion(int(fits.sum()), len(fits))
    return Finding(
        value,
        evidence,
        tables={"drives": table(found)},
        note="The scale cancels where it decides: a key image is reached where it looks as it did. "
        "A camera that has been tilted since sees that place elsewhere.",
    )
