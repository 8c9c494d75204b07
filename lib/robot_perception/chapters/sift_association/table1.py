"""Table 1: which landmark is this, by Euclid (eq. 8) and by Mahalanobis (eq. 9)?

The landmarks are tracked at stations of a drive; the descriptors to be assigned come from other
frames, from the same way or from aside. Right is who lies at the same place of the world.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import cache

import numpy as np
from jaxtyping import Float

from robot_perception.chapters.sift_association import variances as law
from robot_perception.chapters.sift_association.views import Stations, Views, views
from robot_perception.evaluation.intervals import Interval, bootstrap_mean
from robot_perception.evaluation.sweep import sweep
from robot_perception.landmarks import (
    DescriptorClasses,
    Euclidean,
    Mahalanobis,
    floored_variances,
    pooled_variances,
    raw_variances,
    shrunk_variances,
)
from robot_perception.teaching.tables import Table

EUCLID, ONE_VIEW, RAW = "Euclid", "Euclid, one view", "raw"
VARIANCES = (RAW, "floored", "shrunk", "pooled")
WITH = ", log-determinant"
MODELS = (
    ONE_VIEW,
    EUCLID,
    *(name + end for name in VARIANCES for end in ("", WITH) if (name, end) != ("pooled", WITH)),
)
"""What decides. The log-determinant of pooled variances is the same for all classes."""

TRACKED = (3, 5, 10, 20, 30)
TESTS = {"trained": "the frames of the track themselves", "again": "the same way", "aside": "aside"}
"""Where the descriptors to be assigned come from."""

GAIN = 94.04 - 83.85
"""Of the paper's Table 1, percentage points."""


@dataclass(frozen=True, slots=True)
class Config:
    """The paper: 3000 descriptors, little change of viewpoint. All other values are ours.

    ``floor`` is the least variance of the floored model, ``strength`` the degrees of freedom of the
    shrunk one.
    """

    stations: Stations = field(default_factory=Stations)
    descriptors: int = 3000
    floor: float = 100.0
    strength: float = 10.0


@dataclass(frozen=True, eq=False, slots=True)
class Outcome:
    """How many of the descriptors are assigned right, and how the others are wrong, in percent."""

    right: float
    alike: float
    descriptors: int


@dataclass(frozen=True, eq=False, slots=True)
class Result:
    """Outcomes by model, number of tracked frames and where the descriptors come from."""

    config: Config
    landmarks: int
    outcomes: Mapping[tuple[str, int, str], Outcome]
    distance: Mapping[int, float]
    zeros: Mapping[int, float]

    def gain(self, model: str, p: int, where: str) -> float:
        """Return how many points a model is better than Euclid."""
        return self.outcomes[model, p, where].right - self.outcomes[EUCLID, p, where].right


def decide(model: str, seen: Views, p: int, config: Config) -> Euclidean | Mahalanobis:
    """Return what assigns descriptors to the landmarks, of p frames each."""
    if model == ONE_VIEW:
        return Euclidean(seen.stacks[:, seen.stacks.shape[1] // 2].astype(float))
    return decide_by(model, seen.classes(p), config)


def decide_by(model: str, classes: DescriptorClasses, config: Config) -> Euclidean | Mahalanobis:
    """Return what assigns descriptors to classes."""
    if model == EUCLID:
        return Euclidean(classes.means)
    name, comma, _ = model.partition(",")
    return Mahalanobis(classes.means, estimate(name, classes, config), bool(comma))


def estimate(name: str, classes: DescriptorClasses, config: Config) -> Float[np.ndarray, "n d"]:
    """Return the variances of a model."""
    if name == "raw":
        return raw_variances(classes)
    if name == "floored":
        return floored_variances(classes, config.floor)
    if name == "shrunk":
        return shrunk_variances(classes, config.strength)
    return pooled_variances(classes)


def run(
    config: Config,
    *,
    rng: np.random.Generator,
    tracked: tuple[int, ...] = TRACKED,
    models: tuple[str, ...] = MODELS,
) -> Result:
    """Assign descriptors to the landmarks of one building by every model."""
    seen = views(config.stations, int(rng.integers(2**31)))
    same, alike = seen.same(), seen.alike()
    known = seen.meant().any(axis=1)
    out: dict[tuple[str, int, str], Outcome] = {}
    distance, zeros = {}, {}
    chosen = {
        where: _some(np.flatnonzero(known & mask), config.descriptors, rng)
        for where, mask in (("again", seen.aside == 0), ("aside", seen.aside > 0))
    }
    for p in tracked:
        drawn, truth, looks = _trained(seen, p, config.descriptors, rng)
        for model in models:
            nearest = decide(model, seen, p, config)
            for where, rows in chosen.items():
                found = nearest.two_nearest(seen.tests[rows].astype(np.float32)).classes[:, 0]
                out[model, p, where] = _outcome(same[rows, found], alike[rows, found])
            found = nearest.two_nearest(drawn).classes[:, 0]
            at = np.arange(len(found))
            out[model, p, "trained"] = _outcome(truth[at, found], looks[at, found])
        distance[p] = _own_distance(seen, p, chosen["again"])
        zeros[p] = law.zero_share(_window(seen, p))
    return Result(config, len(seen.stacks), out, distance, zeros)


def _some(rows: np.ndarray, count: int, rng: np.random.Generator) -> np.ndarray:
    return np.sort(rng.choice(rows, min(count, len(rows)), replace=False))


def _outcome(right: np.ndarray, alike: np.ndarray) -> Outcome:
    return Outcome(100 * float(right.mean()), 100 * float((alike & ~right).mean()), len(right))


def _window(seen: Views, p: int) -> np.ndarray:
    start = (seen.stacks.shape[1] - p) // 2
    return seen.stacks[:, start : start + p]


def _trained(
    seen: Views, p: int, count: int, rng: np.random.Generator
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Draw descriptors from among those that made the classes."""
    part = _window(seen, p)
    rows = rng.integers(len(part), size=count)
    drawn = part[rows, rng.integers(p, size=count)].astype(np.float32)
    own = replace(seen, tests=part[rows, 0], tested=seen.landmarks[rows])
    return drawn, own.same(), own.alike()


def _own_distance(seen: Views, p: int, rows: np.ndarray) -> float:
    """Return the mean of eq. (9), raw, of descriptors to their own class."""
    meant = seen.meant()[rows]
    owners = meant.argmax(axis=1)
    classes = seen.classes(p)
    apart = seen.tests[rows].astype(float) - classes.means[owners]
    return float((apart**2 / raw_variances(classes)[owners]).sum(axis=1).mean())


@cache
def study(buildings: int, config: Config, seed: int) -> tuple[Result, ...]:
    """Return the results of some buildings."""
    rng = np.random.default_rng(seed)
    return tuple(sweep(run_one, [config] * buildings, rng=rng, desc="Table 1"))


def run_one(config: Config, *, rng: np.random.Generator) -> Result:
    """Run one building; a task of a sweep."""
    return run(config, rng=rng)


def gain(results: tuple[Result, ...], model: str, p: int, where: str) -> Interval:
    """Return how many points a model is better than Euclid, over buildings."""
    return bootstrap_mean(np.array([r.gain(model, p, where) for r in results]), "points")


def rates(results: tuple[Result, ...], where: str, models: tuple[str, ...] = MODELS) -> Table:
    """Return the share of right assignments by model and number of tracked frames."""
    tracked = sorted({p for _, p, _ in results[0].outcomes})
    rows = {
        model: [
            bootstrap_mean(np.array([r.outcomes[model, p, where].right for r in results]), "%")
            for p in tracked
        ]
        for model in models
    }
    columns = {f"p = {p}": "" for p in tracked}
    about = f"right assignments (%), mean and 95 % bootstrap interval over {len(results)} buildings"
    return Table(rows, columns, about, "decided by")


def part_of(seen: Views, rows: np.ndarray) -> Views:
    """Return views with some of the landmarks."""
    return replace(seen, stacks=seen.stacks[rows], landmarks=seen.landmarks[rows])


def setup_table() -> Table:
    """Return what the paper says of its Table 1, what ours has, and what of it matters."""
    config = Config()
    own = config.stations
    way = own.frames * own.step
    rows = {
        "descriptors": ("3000", f"{config.descriptors} a building", "no"),
        "landmarks": ("–", f"tracked at {own.count} stations of a drive", "yes: each is a rival"),
        "tracked frames p": (
            "“a significant number”",
            ", ".join(map(str, TRACKED)),
            "yes: see below",
        ),
        "change of viewpoint": (
            "“little variations”",
            f"{100 * way:.0f} cm of way in {own.frames} frames",
            "yes",
        ),
        "descriptors tested": (
            "–",
            "of the tracks; of other frames; from aside",
            "most of all",
        ),
        "variance of an entry": (
            "of the p descriptors",
            f"raw; at least {config.floor:g}; shrunk with ν₀ = {config.strength:g}; pooled",
            "yes: see below",
        ),
    }
    return Table(rows, {"paper": "– where it says nothing", "ours": "", "matters": ""})
