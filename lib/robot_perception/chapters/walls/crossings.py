"""Chains that cross themselves: what path hulls do then, and whether scans ever are such chains."""

from dataclasses import dataclass
from functools import partial

import numpy as np
from jaxtyping import Bool, Float, Int
from scipy.spatial import ConvexHull

from data_synth.laser import Scanner, scan_moving
from data_synth.office import Office, drive, make_office
from robot_perception import walls
from robot_perception.chapters.walls.growth import simple_chain
from robot_perception.chapters.walls.splitting import Simplify, heights, split, to_chain
from robot_perception.evaluation.intervals import exact, proportion
from robot_perception.evaluation.sweep import sweep
from robot_perception.geometry import act, compose
from robot_perception.teaching.claims import Finding
from robot_perception.teaching.recorded import recorded
from robot_perception.teaching.studies import Change, Study
from robot_perception.teaching.verdicts import Accepted


def crossing_chain(rng: np.random.Generator, n: int = 60) -> Float[np.ndarray, "n 2"]:
    """Return a random closed curve that crosses itself, as a robot's path does, with noise."""
    t = np.linspace(0.0, 1.9 * np.pi, n)
    a, b = rng.integers(1, 4), rng.integers(2, 5)
    curve = np.stack([np.sin(a * t + rng.uniform(0, 3)), np.sin(b * t)], axis=-1)
    return 4 * curve + rng.normal(0, 0.05, (n, 2))


@dataclass(frozen=True, eq=False, slots=True)
class Crossing:
    """A chain that crosses itself: vertices by both algorithms, and the edges that cross."""

    chain: Float[np.ndarray, "n 2"]
    plain: Int[np.ndarray, " kept"]
    hulls: Int[np.ndarray, " found"]
    edges: Int[np.ndarray, "crossings 2"]

    @property
    def differ(self) -> bool:
        """Whether unchecked path hulls keep other vertices than the plain algorithm."""
        return not np.array_equal(self.hulls, self.plain)


unchecked: Simplify = partial(walls.simplify_path_hull, assume_simple=True)
"""Path hulls without the check that the chain is simple."""


def simplified(
    chain: Float[np.ndarray, "n 2"],
    tolerance: float = 0.3,
    by_hulls: Simplify = unchecked,
) -> Crossing:
    """Simplify a chain by both algorithms, hulls unchecked, and find where it crosses."""
    hulls = by_hulls(chain, tolerance)
    return Crossing(chain, walls.simplify(chain, tolerance), hulls, walls.find_crossings(chain))


@recorded("walls-crossing")
def crossing_example() -> Crossing:
    """Return the first random chain with few crossings on which unchecked path hulls go wrong."""
    tried = (simplified(crossing_chain(child)) for child in np.random.default_rng(5).spawn(1000))
    return next(found for found in tried if len(found.edges) <= 4 and found.differ)


def scan_simplicity(rng: np.random.Generator, scans: int) -> dict[str, int]:
    """Count the scans of an office whose chain, in the frame of the world, crosses itself.

    Taken at rest (``still``), swept on the move (``slow``), and two ``joined`` to one chain.
    """
    office = make_office(rng=rng)
    poses = drive(office)
    crossing = {"scans": scans, "still": 0, "slow": 0, "joined": 0}
    for pose in poses[rng.choice(len(poses) - 8, scans, replace=False)]:
        after = compose(pose, np.array([0.3, 0.0, 0.0]))
        takes = ((pose, 0.0), (pose, 0.3), (after, 0.0))
        still, slow, again = (_chain(office, place, speed, rng) for place, speed in takes)
        chains = {"still": still, "slow": slow, "joined": np.concatenate([still, again])}
        for name, chain in chains.items():
            crossing[name] += not walls.is_simple(chain)
    return crossing


def _chain(office: Office, pose: np.ndarray, speed: float, rng: np.random.Generator) -> np.ndarray:
    """Return a scan of 3 s in the world, its readings placed where the robot was at each beam."""
    scanner, duration = Scanner(), 3.0
    ranges = scan_moving(office.faces, pose, (speed, 0.0), duration, scanner, rng=rng).ranges[0]
    points = to_chain(ranges, scanner)
    points[:, 0] += speed * np.linspace(0.0, duration, scanner.beams)[np.isfinite(ranges)]
    return act(pose, points)


@dataclass(frozen=True, slots=True)
class Config:
    """Numbers of curves and of scans, and the hulls that are used, a name of `HULLS`."""

    trials: int
    scans: int
    hulls: str = "Melkman"


Counted = tuple[Bool[np.ndarray, "3 curves"], dict[str, int]]


def run(config: Config, *, rng: np.random.Generator) -> Counted:
    """Tell of curves whether they cross themselves, whether hulls err on them, and false alarms.

    Beside them, how many scans cross.
    """
    tried = sweep(partial(_tried, config.hulls), range(config.trials), rng=rng, desc="curves")
    return np.array(tried).T, scan_simplicity(rng.spawn(1)[0], config.scans)


def _tried(hulls: str, _: int, *, rng: np.random.Generator) -> tuple[bool, bool, bool]:
    found = simplified(crossing_chain(rng), by_hulls=HULLS[hulls])
    return len(found.edges) > 0, found.differ, not walls.is_simple(simple_chain(rng))


def _by_quickhull(chain: np.ndarray, tolerance: float) -> np.ndarray:
    return np.array(split(chain, tolerance, _corner_heights))


def _corner_heights(chain: np.ndarray, i: int, j: int) -> np.ndarray:
    """Return the distances of the corners of the convex hull, 0 for the vertices inside it."""
    far = heights(chain, i, j)
    if j - i > 2:
        inside = np.ones(j - i + 1, dtype=bool)
        inside[ConvexHull(chain[i : j + 1]).vertices] = False
        far[inside[1:-1]] = 0.0
    return far


HULLS: dict[str, Simplify] = {"Melkman": unchecked, "Quickhull": _by_quickhull}
crossed = Study(run, full=Config(5000, 300), quick=Config(400, 60))


@crossed.claim(
    "dp-simple-chain",
    paper="perception-issues",
    place="§2.1",
    basis="mathematics",  # a counterexample decides, and vertices are compared exactly
    statement="The chain is assumed to be simple.",
    method="share of self-crossing curves on which unchecked path hulls keep other vertices "
    "than the plain algorithm",
    accepted=Accepted(
        0.01,
        1.0,
        "the assumption is needed if path hulls err on some chains that break it",
        "our choice",
    ),
    sabotage=Change(
        "Quickhull, which is right for every chain, in place of Melkman's algorithm",
        hulls="Quickhull",
        scans=1,
    ),
)
def dp_simple_chain(found: Counted) -> Finding:
    """Count the curves on which path hulls err, the false alarms and the scans that cross."""
    (crossing, wrong, alarm), rates = found
    evidence = {
        "wrong vertices on chains that pass the check": exact(
            float((wrong & ~crossing).sum()),
            about=f"of {(~crossing).sum()} curves without a crossing",
        ),
        "false alarms": exact(float(alarm.sum()), about=f"of {alarm.size} simple chains"),
        "single scans that cross themselves": proportion(rates["still"], rates["scans"]),
        "scans of 3 s on the move that cross themselves": proportion(rates["slow"], rates["scans"]),
        "two scans in one chain that cross themselves": proportion(rates["joined"], rates["scans"]),
    }
    share = proportion(int((crossing & wrong).sum()), int(crossing.sum()))
    return Finding(share, evidence, note="Share of crossing chains on which path hulls err.")
