"""What splitting costs on the worst case, vertex by vertex and with path hulls."""

import json
import subprocess
import sys
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from importlib.util import find_spec
from timeit import repeat

import numpy as np
from jaxtyping import Float, Int
from scipy.spatial import ConvexHull

from robot_perception import walls
from robot_perception.chapters.walls.splitting import recursion
from robot_perception.evaluation.intervals import Interval, exact, exponent
from robot_perception.evaluation.sweep import sweep
from robot_perception.teaching.claims import Finding, Size, claim
from robot_perception.teaching.records import records
from robot_perception.teaching.verdicts import Accepted

SIZES = {"quick": 500 * 2 ** np.arange(5), "full": 1000 * 2 ** np.arange(6)}
"""Numbers of vertices for the growth; counts are exact, so few sizes are enough."""
HULL_SIZES = {"quick": 4000 * 2 ** np.arange(5), "full": 16_000 * 2 ** np.arange(6)}
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


def fit(cost: Callable[[np.ndarray, float], float], sizes: Int[np.ndarray, " sizes"]) -> Growth:
    """Fit a power of the size to the cost of worst-case chains, a function of chain and ε."""
    costs = np.array([cost(worst_case(n), 0.1) for n in sizes.tolist()], dtype=float)
    return Growth(sizes, costs, exponent(sizes.astype(float), costs))


def surplus(found: Growth) -> Interval:
    """Return the exponent with which the surplus T(2n) − 2T(n) of a cost grows.

    What is proportional to n cancels. Of n log n remains exactly 2n, of n to the power p a multiple
    of itself, so that the two differ where their own exponents do not. A cost without surplus is
    linear or less; its exponent is 0.

    Raises
    ------
    ValueError
        If a size is not twice the one before.
    """
    sizes = found.sizes
    if (sizes[1:] != 2 * sizes[:-1]).any():
        raise ValueError(f"each size must be twice the one before, got {sizes}")
    left = found.costs[1:] - 2 * found.costs[:-1]
    return exponent(sizes[:-1].astype(float), left) if left.max() > 0 else exact(0.0)


def n_log_n_exponent(size: str) -> float:
    """Return the exponent that n log n itself shows over the sizes."""
    sizes = HULL_SIZES[size].astype(float)
    return exponent(sizes, sizes * np.log2(sizes)).estimate


@dataclass(frozen=True, slots=True)
class Times:
    """Recorded times for a zigzag of 100 000 vertices, s: path hulls, and a peer without them."""

    hulls: float
    plain: float
    peer: str


def recorded_times() -> Times:
    """Return the times that the benchmarks recorded for a zigzag of 100 000 vertices.

    Raises
    ------
    LookupError
        If the record has no such row.
    """
    rows = json.loads((records() / "performance.json").read_text(encoding="utf-8"))["rows"]
    for row in rows:
        if row["work"].startswith(ZIGZAG) and row["peer"]:
            return Times(row["ours_s"], row["peer_s"], row["peer"])
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


@claim(
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
)
def dp_quadratic(size: Size, rng: np.random.Generator) -> Finding:
    """Count the distances of the plain algorithm on the worst case; at full size, time peers."""
    plain = fit(walls.count_distances, SIZES[size])
    note = f"{int(plain.costs[-1]):,} distances for {plain.sizes[-1]:,} vertices."
    if size is Size.QUICK:
        return Finding(plain.exponent, note=note)
    note += " The exponents of time are those of the machine that records the ledger."
    if find_spec("shapely"):
        code = _shapely_ends_with(100_000)
        note += f" A process that gives shapely 100,000 vertices ends with exit code {code}."
    return Finding(plain.exponent, _peers(), note=note)


@dp_quadratic.sabotage("path hulls in place of every vertex")
def hulls_on_the_worst_case(size: Size, rng: np.random.Generator) -> Finding:
    """Count the steps of the algorithm that is not quadratic."""
    return Finding(fit(walls.count_hull_steps, SIZES[size]).exponent)


def _peers() -> dict[str, Interval]:
    """Time the peers that are installed on the worst case, and fit the exponents."""
    return {
        f"exponent of {name} (time)": fit(
            partial(_best_time, name, program), least * 2 ** np.arange(4)
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
    return subprocess.run([sys.executable, "-c", program], capture_output=True).returncode


@claim(
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
)
def dp_path_hull(size: Size, rng: np.random.Generator) -> Finding:
    """Count the steps of path hulls on the worst case; compare vertices on many simple chains."""
    hulls = fit(walls.count_hull_steps, HULL_SIZES[size])
    trials = 300 if size is Size.QUICK else 3000
    different = sum(sweep(_errs, range(trials), rng=rng, desc="simple chains"))
    if different:  # the cost of a wrong answer is no finding
        raise ArithmeticError(f"path hulls kept other vertices on {different} of {trials} chains")
    per = hulls.costs / (hulls.sizes * np.log2(hulls.sizes))
    ends = (float(np.median(per)), float(per.min()), float(per.max()))
    evidence = {
        "simple chains with other vertices than the plain algorithm": exact(
            different, about=f"of {trials}"
        ),
        "steps per n log₂ n": Interval(*ends, "", "range over the sizes"),
        "exponent of the steps themselves": hulls.exponent,
        "exponent of n log n over the same sizes": exact(n_log_n_exponent(size)),
    }
    return Finding(surplus(hulls), evidence)


@dp_path_hull.sabotage("hulls that are built anew for both parts of every split")
def hulls_built_anew(size: Size, rng: np.random.Generator) -> Finding:
    """Count the steps without a history of the hulls, on chains that a quadratic cost allows."""
    return Finding(surplus(fit(_steps_without_history, 50 * 2 ** np.arange(5))))


@dp_path_hull.sabotage("every vertex measured in place of the corners of the hulls")
def every_vertex(size: Size, rng: np.random.Generator) -> Finding:
    """Count the distances of the plain algorithm."""
    return Finding(surplus(fit(walls.count_distances, SIZES[size])))


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
