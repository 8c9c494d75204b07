"""What splitting costs on the worst case, vertex by vertex and with path hulls."""

import json
import subprocess
import sys
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from importlib.util import find_spec
from timeit import repeat
from typing import Any

import numpy as np
from jaxtyping import Float, Int
from scipy.spatial import ConvexHull

from robot_perception import walls
from robot_perception.chapters.walls.splitting import recursion
from robot_perception.evaluation.intervals import Interval, exact, exponent
from robot_perception.evaluation.sweep import sweep
from robot_perception.teaching.claims import Finding
from robot_perception.teaching.records import records
from robot_perception.teaching.studies import Change, Study
from robot_perception.teaching.verdicts import Accepted


def _doubled(least: int, times: int) -> tuple[int, ...]:
    return tuple(least * 2**k for k in range(times))


SIZES = {"quick": _doubled(500, 5), "full": _doubled(1000, 6)}
"""Numbers of vertices for the growth; counts are exact, so few sizes are enough."""
HULL_SIZES = {"quick": _doubled(4000, 5), "full": _doubled(16_000, 6)}
ZIGZAG = "simplify a zigzag of 10⁵ points"
"""How the row of the benchmarks begins that has the times of the worst case."""
UNSPLIT = 1e9
"""A tolerance, m, above the size of every chain: it is looked at once and never split."""
PEERS = {
    "fastrdp": ("fastrdp.rdp_index(chain, tolerance)", 2000),
    "shapely": ("shapely.LineString(chain).simplify(tolerance, preserve_topology=False)", 1000),
}
"""Other packages: their call, and the least number of vertices that takes a time to measure."""


def worst_case(n: int) -> Float[np.ndarray, "n 2"]:
    """Return a zigzag of slowly falling height, on which every split cuts off one vertex.

    Seen from the chord of any sub-chain, its second vertex is the farthest. The chain runs from
    left to right, so it is simple. The heights follow a quarter of an ellipse, so that all
    vertices are corners of the convex hull too.
    """
    k = np.arange(n, dtype=float)
    height = 1.0 + np.sqrt(1.0 - (k / n) ** 2)
    return np.stack([k, np.where(k % 2, -height, height)], axis=-1)


@dataclass(frozen=True, eq=False, slots=True)
class Growth:
    """What an algorithm costs against the number of vertices, and the exponent fitted to it."""

    sizes: Int[np.ndarray, " sizes"]
    costs: Float[np.ndarray, " sizes"]
    exponent: Interval


def fit(cost: Callable[[np.ndarray, float], float], sizes: Sequence[int]) -> Growth:
    """Fit a power of the size to the cost of worst-case chains, a function of chain and ε."""
    costs = np.array([cost(worst_case(n), 0.1) for n in sizes], dtype=float)
    return Growth(np.array(sizes), costs, exponent(np.array(sizes, dtype=float), costs))


def surplus(found: Growth) -> Interval:
    """Return the exponent with which the surplus T(2n) − 2T(n) of a cost grows.

    What is proportional to n cancels. Of n log n remains exactly 2n, of n to the power p a multiple
    of itself, so that the two differ where their own exponents do not. A cost without surplus is
    linear or less; its exponent is 0.
    """
    sizes = found.sizes
    if (sizes[1:] != 2 * sizes[:-1]).any():
        raise ValueError(f"each size must be twice the one before, got {sizes}")
    left = found.costs[1:] - 2 * found.costs[:-1]
    return exponent(sizes[:-1].astype(float), left) if left.max() > 0 else exact(0.0)


def n_log_n_exponent(sizes: Int[np.ndarray, " sizes"]) -> float:
    """Return the exponent that n log n itself shows over the sizes."""
    return exponent(sizes.astype(float), sizes * np.log2(sizes)).estimate


def recorded_times() -> dict[str, Any]:
    """Return the row of the benchmarks for a zigzag of 100 000 vertices: path hulls and a peer."""
    rows = json.loads((records() / "performance.json").read_text(encoding="utf-8"))["rows"]
    for row in rows:
        if row["work"].startswith(ZIGZAG) and row["peer"]:
            return row
    raise LookupError(f"performance.json has no row {ZIGZAG!r}; `make bench` records one")


@dataclass(frozen=True, eq=False, slots=True)
class Hulls:
    """A chain, the vertex at which its two path hulls meet, their corners, and the farthest."""

    chain: Float[np.ndarray, "n 2"]
    tag: int
    corners: tuple[Int[np.ndarray, " left"], Int[np.ndarray, " right"]]
    farthest: int


def hull_example(n: int = 60) -> Hulls:
    """Return a wavy chain with the convex hulls of its two halves."""
    rng = np.random.default_rng(2)
    x = np.linspace(0.0, 10.0, n)
    y = 1.4 * np.sin(0.9 * x) + 0.8 * np.sin(2.3 * x + 1) + rng.normal(0, 0.12, n)
    chain, tag = np.stack([x, y], axis=-1), (n - 1) // 2
    left, right = ConvexHull(chain[: tag + 1]).vertices, ConvexHull(chain[tag:]).vertices + tag
    return Hulls(chain, tag, (left, right), walls.find_split(chain, 0, n - 1)[0])


@dataclass(frozen=True, slots=True)
class Config:
    """Numbers of vertices, and what is counted on the worst cases of them, a name of `COUNTS`.

    So many ``trials`` of simple chains are simplified in both ways; at the full size others are
    ``timed``.
    """

    counted: str
    sizes: tuple[int, ...]
    trials: int = 0
    timed: bool = False


Counted = tuple[Config, Growth, int]
"""How a count grows, and on how many chains path hulls differ from the plain algorithm."""


def run(config: Config, *, rng: np.random.Generator) -> Counted:
    """Count on the worst case, and compare vertices on simple chains."""
    growth = fit(COUNTS[config.counted], config.sizes)
    return config, growth, sum(sweep(_errs, range(config.trials), rng=rng, desc="simple chains"))


def _peers() -> dict[str, Interval]:
    """Time the peers that are installed on the worst case, and fit the exponents."""
    return {
        f"exponent of {name} (time)": fit(
            partial(_best_time, name, program), _doubled(least, 4)
        ).exponent
        for name, (program, least) in PEERS.items()
        if find_spec(name)
    }


def _best_time(name: str, program: str, chain: np.ndarray, tolerance: float) -> float:
    given = {"chain": chain, "tolerance": tolerance}
    return min(repeat(program, f"import {name}", number=1, repeat=5, globals=given))


def _shapely_ends_with(n: int) -> int:
    """Return the exit code of a process that simplifies a worst-case chain with shapely."""
    chain = f"from {__name__} import worst_case; chain, tolerance = worst_case({n}), 0.1"
    program = f"import shapely; {chain}; {PEERS['shapely'][0]}"
    return subprocess.run([sys.executable, "-P", "-c", program], capture_output=True).returncode


def _steps_without_history(chain: np.ndarray, tolerance: float) -> int:
    """Return the steps if each sub-chain of the recursion gets hulls for its one split."""
    parts = (chain[call.i : call.j + 1] for call in recursion(chain, tolerance))
    return sum(walls.count_hull_steps(part, UNSPLIT) for part in parts)


def _errs(_: int, *, rng: np.random.Generator) -> bool:
    chain = simple_chain(rng)
    tolerance = float(rng.choice([0.02, 0.2, 1.0]))
    hulls, plain = walls.simplify_path_hull(chain, tolerance), walls.simplify(chain, tolerance)
    return not np.array_equal(hulls, plain)


def simple_chain(rng: np.random.Generator) -> Float[np.ndarray, "n 2"]:
    """Return a random simple chain: a scan, a spiral, or a walk to the right."""
    n, kind = int(rng.integers(3, 400)), rng.integers(3)
    if kind == 0:
        angles = np.sort(rng.uniform(-np.pi / 2, np.pi / 2, n))
        return walls.to_points(rng.uniform(0.5, 8.0, n), angles)
    if kind == 1:
        turns = np.linspace(0.0, min(n / 5, 20.0), n)
        return walls.to_points(1 + turns + rng.uniform(-0.5, 0.5, n), turns)
    return np.stack([np.cumsum(rng.uniform(0.01, 1.0, n)), rng.normal(0, 1.0, n).cumsum()], axis=-1)


COUNTS: dict[str, Callable[[np.ndarray, float], float]] = {
    "distances": walls.count_distances,
    "hull steps": walls.count_hull_steps,
    "steps without history": _steps_without_history,
}


plain = Study(
    run,
    full=Config("distances", SIZES["full"], timed=True),
    quick=Config("distances", SIZES["quick"]),
)


@plain.claim(
    "dp-quadratic",
    paper="perception-issues",
    place="§2.1",
    basis="mathematics",  # the distances are counted; (n − 1)(n − 2)/2 is their closed form
    statement="The original algorithm has quadratic worst-case time.",
    paper_value="n²",
    method="exponent of the number of distances against n, on a zigzag of falling height",
    accepted=Accepted(
        1.95,
        2.05,
        "2; the terms of lower order in (n − 1)(n − 2)/2 shift the slope by less than 0.01",
        "our choice",
    ),
    sabotage=Change("path hulls in place of every vertex", counted="hull steps"),
)
def dp_quadratic(found: Counted) -> Finding:
    """Count the distances of the plain algorithm on the worst case; at full size, time peers."""
    config, growth, _ = found
    note = f"{int(growth.costs[-1]):,} distances for {growth.sizes[-1]:,} vertices."
    if not config.timed:
        return Finding(growth.exponent, note=note)
    # times belong to no draw and are measured each time: a study's result is kept
    note += " The exponents of time are those of the machine that records the ledger."
    if find_spec("shapely"):
        code = _shapely_ends_with(100_000)
        note += f" A process that gives shapely 100,000 vertices ends with exit code {code}."
    return Finding(growth.exponent, _peers(), note=note)


hulls = Study(
    run,
    full=Config("hull steps", HULL_SIZES["full"], trials=3000),
    quick=Config("hull steps", HULL_SIZES["quick"], trials=300),
)


@hulls.claim(
    "dp-path-hull",
    paper="perception-issues",
    place="§2.1",
    basis="mathematics",  # the steps are counted; one chain that takes more refutes the bound
    statement="With path hulls the same simplification takes O(n log n).",
    paper_value="n log n",
    method="exponent of the surplus T(2n) − 2T(n) of the hull steps T on the same zigzag, "
    "provided that all vertices agree with the plain algorithm; what is proportional to n "
    "cancels in it",
    accepted=Accepted(
        0,
        1.05,
        "n log n leaves a surplus that grows as n, to the power 1; the end is halfway to the "
        "surplus of n to the power 1.1. A linear cost leaves none, which counts as 0",
        "our choice",
    ),
    sabotage=[
        Change(
            "hulls that are built anew for both parts of every split",
            config=Config("steps without history", _doubled(50, 5)),
        ),
        Change(
            "every vertex measured in place of the corners of the hulls",
            config=Config("distances", SIZES["quick"]),
        ),
    ],
)
def dp_path_hull(found: Counted) -> Finding:
    """Count the steps of path hulls on the worst case; compare vertices on many simple chains."""
    config, growth, different = found
    trials = config.trials
    if different:  # the cost of a wrong answer is no finding
        raise ArithmeticError(f"path hulls kept other vertices on {different} of {trials} chains")
    per = growth.costs / (growth.sizes * np.log2(growth.sizes))
    ends = (float(np.median(per)), float(per.min()), float(per.max()))
    evidence = {
        "simple chains with other vertices than the plain algorithm": exact(
            different, about=f"of {trials}"
        ),
        "steps per n log₂ n": Interval(*ends, "", "range over the sizes"),
        "exponent of the steps themselves": growth.exponent,
        "exponent of n log n over the same sizes": exact(n_log_n_exponent(growth.sizes)),
    }
    return Finding(surplus(growth), evidence)
