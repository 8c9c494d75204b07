"""Section 4: beyond which distance a descriptor is a new landmark's.

Descriptors of landmarks that are in the map, and of places that are not, at once; the threshold
goes from nothing to everything.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
from jaxtyping import Bool, Float

from robot_perception.chapters.sift_association import table1
from robot_perception.chapters.sift_association.views import PAPER, Stations, views
from robot_perception.evaluation.intervals import Interval, bootstrap_mean
from robot_perception.evaluation.sweep import sweep
from robot_perception.landmarks import Nearest
from robot_perception.teaching.claims import Finding, Size, claim
from robot_perception.teaching.verdicts import Accepted

MODELS = (table1.EUCLID, table1.RAW, "shrunk", "pooled")
LEVELS = 200


@dataclass(frozen=True, slots=True)
class Config:
    """The paper names no threshold and no curve. All values are ours.

    ``left_out`` is the share of the landmarks that are kept out of the map, so that their
    descriptors are new.
    """

    table: table1.Config = field(default_factory=table1.Config)
    p: int = 10
    left_out: float = 0.5


@dataclass(frozen=True, eq=False, slots=True)
class Curve:
    """Precision and recall of "new landmark", and wrong names given, by rising threshold.

    ``limits`` are squared distances; precision is the share of those called new that are, recall
    the share of the new ones that are called so. ``wrong`` is the share of all descriptors that are
    given the name of another place.
    """

    limits: Float[np.ndarray, " k"]
    precision: Float[np.ndarray, " k"]
    recall: Float[np.ndarray, " k"]
    wrong: Float[np.ndarray, " k"]

    @property
    def best(self) -> int:
        """Where the harmonic mean of precision and recall is largest."""
        total = np.maximum(self.precision + self.recall, 1e-12)
        return int((2 * self.precision * self.recall / total).argmax())


@dataclass(frozen=True, eq=False, slots=True)
class Result:
    """Curves by model; how many descriptors are new, of how many.

    ``printed`` is the share of the new ones that the rule as printed calls so, where no distance
    exceeds the threshold: by Euclid, at its best.
    """

    config: Config
    curves: Mapping[str, Curve]
    new: int
    descriptors: int
    printed: float


def run(config: Config, *, rng: np.random.Generator) -> Result:
    """Leave a part of the landmarks of one building out of the map and look for what is new."""
    seen = views(config.table.stations, int(rng.integers(2**31)))
    same, meant = seen.same(), seen.meant()
    places = rng.random(len(seen.landmarks)) >= config.left_out
    # what is left out is left out with all that lies beside it
    known = meant[:, places].any(axis=1)
    new = meant.any(axis=1) & ~same[:, places].any(axis=1)
    rows = np.flatnonzero((known | new) & (seen.aside == 0))
    rows = np.sort(rng.choice(rows, min(config.table.descriptors, len(rows)), replace=False))
    tests = seen.tests[rows].astype(np.float32)
    part, curves = table1.part_of(seen, places), {}
    for model in MODELS:
        nearest = table1.decide(model, part, config.p, config.table).two_nearest(tests)
        right = same[rows][:, places][np.arange(len(rows)), nearest.classes[:, 0]]
        curves[model] = curve(nearest, new[rows], right)
    best = curves[table1.EUCLID]
    away = table1.decide(table1.EUCLID, part, config.p, config.table).distances(tests)
    none_exceeds = (away <= best.limits[best.best]).all(axis=1)
    printed = float(none_exceeds[new[rows]].mean())
    return Result(config, curves, int(new[rows].sum()), len(rows), printed)


def curve(nearest: Nearest, new: Bool[np.ndarray, " m"], right: Bool[np.ndarray, " m"]) -> Curve:
    """Return precision and recall of "new" over thresholds of the squared distance."""
    away = nearest.distances[:, 0]
    limits = np.quantile(away, np.linspace(0, 1, LEVELS))
    called = away > limits[:, None]
    hits = (called & new).sum(axis=1)
    precision = np.where(called.any(axis=1), hits / np.maximum(called.sum(axis=1), 1), 1.0)
    wrong = (~called & ~right).mean(axis=1)
    return Curve(limits, precision, hits / max(new.sum(), 1), wrong)


@claim(
    "erratum-new-landmark",
    paper=PAPER,
    place="§4, text to eq. 9",
    basis="mathematics",
    statement="If none of the distances to the landmarks of the map exceeds a threshold, the "
    "descriptor is that of a new landmark.",
    paper_value="a rule in words",
    method="As printed, a new descriptor must be near to all landmarks: by the triangle inequality "
    "none can be in a map with two landmarks that are more than twice the threshold apart. "
    "Checked on rendered buildings, half of the landmarks not in the map: share of the new "
    "descriptors that are called new, at the threshold that is best if all are to exceed it.",
    accepted=Accepted(0.5, 1.0, "a rule must find more of the new ones than a coin", "theory"),
    seed=24,
)
def new_as_printed(size: Size, rng: np.random.Generator) -> Finding:
    """Compare the rule as printed with the one that is meant."""
    results = _results(size, rng)
    meant = _found(results)
    return Finding(
        bootstrap_mean(np.array([r.printed for r in results])),
        {"called new if all exceed the threshold": meant},
        note="As printed the rule calls "
        f"{100 * np.mean([r.printed for r in results]):.0f} % of the new descriptors new, as meant "
        f"{100 * meant.estimate:.0f} %.",
    )


@new_as_printed.sabotage("the rule that is meant: all exceed the threshold")
def all_exceed(size: Size, rng: np.random.Generator) -> Finding:
    """Call new what is far from all landmarks."""
    return Finding(_found(_results(size, rng)))


def _found(results: list[Result]) -> Interval:
    best = [r.curves[table1.EUCLID] for r in results]
    return bootstrap_mean(np.array([c.recall[c.best] for c in best]))


def _results(size: Size, rng: np.random.Generator) -> list[Result]:
    stations = Stations(count=2, frames=14, sightings=10)
    runs = 10 if size is Size.FULL else 3
    return sweep(_run, [Config(table1.Config(stations))] * runs, rng=rng, desc="new landmarks")


def _run(config: Config, *, rng: np.random.Generator) -> Result:
    return run(config, rng=rng)
