"""Experiments of the chapter "Walls from laser scans".

The paper is Andrade-Cetto, "Perception Issues in Mobile Robotics", section 2.1, Fig. 1 and Tables 1
and 2. It gives neither a noise of the scanner nor a tolerance; those are ours.
"""

import importlib.util
import subprocess
import sys
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import cache
from pathlib import Path

import numpy as np
from jaxtyping import Bool, Float
from scipy import stats
from scipy.spatial import ConvexHull

from data_synth.laser import Scanner, Scans, scan, scan_moving
from data_synth.office import Office, drive, make_office
from robot_perception.datasets import LaserLog, read_graph_log
from robot_perception.evaluation.consistency import normalised_squared
from robot_perception.geometry import act, compose, inverse, rotation
from robot_perception.teaching.claims import Accepted, Claim, Finding, Interval, Size
from robot_perception.teaching.exercises import Exercise, Sheet
from robot_perception.teaching.recordings import Recording
from robot_perception.walls import (
    Extraction,
    Gate,
    MapScore,
    RangeNoise,
    ScanReport,
    Segments,
    WallMap,
    build_map,
    count_distances,
    count_hull_steps,
    explained,
    extract_segments,
    find_crossings,
    find_split,
    fit_line,
    is_simple,
    merge,
    sample_faces,
    score_map,
    seen_from,
    simplify,
    simplify_path_hull,
    to_points,
    to_world,
)

PAPER = "perception-issues"


@dataclass(frozen=True, slots=True)
class Config:
    """One drive through a synthetic office. The paper gives none of these values: all are ours.

    Parameters
    ----------
    rooms
        Rooms on each side of the corridor.
    furniture
        Pieces of furniture tried in each room.
    scanner
        The scanner: 361 beams over half a turn, noise of 1.5 cm, readings in steps of 1 cm.
    extraction
        What is taken for a wall in one scan; its noise is that of the scanner and its rounding.
    gate
        Search range for walls already in the map.
    least_scans
        Fewest scans in which a wall must be seen.
    step
        Distance between scans, m.
    """

    rooms: int = 4
    furniture: int = 2
    scanner: Scanner = field(default_factory=Scanner)
    extraction: Extraction = field(default_factory=lambda: Extraction(RangeNoise(0.0155)))
    gate: Gate = field(default_factory=Gate)
    least_scans: int = 3
    step: float = 0.25


@dataclass(frozen=True, eq=False, slots=True)
class Result:
    """A drive and the map made from it.

    Parameters
    ----------
    config
        What was run.
    office, poses, scans
        The world, where the robot was, and what it measured.
    walls
        Walls seen in enough scans.
    report
        What became of all readings.
    seen
        Which samples of the faces the beams really reached.
    score
        Agreement of the map with the floor plan.
    """

    config: Config
    office: Office
    poses: Float[np.ndarray, "scans 3"]
    scans: Scans
    walls: WallMap
    report: ScanReport
    seen: Bool[np.ndarray, " samples"]
    score: MapScore

    @property
    def points(self) -> Float[np.ndarray, "readings 2"]:
        """All readings in the frame of the world, m."""
        return _world_points(self.scans.ranges, self.config.scanner.angles, self.poses)

    def summary(self) -> dict[str, float]:
        """Return the numbers about the map that the chapter tells, in mm and degrees."""
        return {
            "count": len(self.walls),
            "precision": self.score.precision,
            "recall": self.score.recall,
            "offset": float(1e3 * np.sqrt(np.mean(self.score.offsets**2))),
            "angle": float(np.rad2deg(np.sqrt(np.mean(self.score.angles**2)))),
            "readings": self.report.readings,
        }


def run(config: Config, *, rng: np.random.Generator) -> Result:
    """Drive through an office, build the wall map with known poses, and compare it with the plan.

    Parameters
    ----------
    config
        What to run.
    rng
        Source of the office and of the noise.
    """
    office = make_office(rng=rng, rooms=config.rooms, furniture=config.furniture)
    poses = drive(office, step=config.step)
    scans = scan(office.faces, poses, config.scanner, rng=rng)
    angles = config.scanner.angles
    walls, report = build_map(scans.ranges, angles, poses, config.extraction, config.gate)
    walls = walls.seen_in(config.least_scans)
    seen = _reached(office, poses, scans, config.scanner)
    score = score_map(walls, office.faces, seen)
    return Result(config, office, poses, scans, walls, report, seen, score)


@cache
def office_run(seed: int = 1) -> Result:
    """Return the chapter's drive; it is run once."""
    return run(Config(), rng=np.random.default_rng(seed))


def _world_points(ranges: np.ndarray, angles: np.ndarray, poses: np.ndarray) -> np.ndarray:
    valid = np.isfinite(ranges)
    points = act(poses, to_points(np.where(valid, ranges, 0.0), angles))
    return points[valid]


def _reached(office: Office, poses: np.ndarray, scans: Scans, scanner: Scanner) -> np.ndarray:
    """Samples of the faces with at least ten beams on the face within 10 cm."""
    true = np.where(np.isfinite(scans.ranges), scans.true_ranges, np.inf)
    valid = np.isfinite(true)
    hits = act(poses, to_points(np.where(valid, true, 0.0), scanner.angles))[valid]
    face = scans.faces[valid]
    samples, owner = sample_faces(office.faces)
    seen = np.zeros(len(samples), dtype=bool)
    for k in range(len(office.faces)):
        mine, beams = np.flatnonzero(owner == k), hits[face == k]
        if len(beams):
            along = office.faces[k, 1] - office.faces[k, 0]
            along = along / np.linalg.norm(along)
            where = np.sort((beams - office.faces[k, 0]) @ along)
            place = (samples[mine] - office.faces[k, 0]) @ along
            count = np.searchsorted(where, place + 0.1) - np.searchsorted(where, place - 0.1)
            seen[mine] = count >= 10
    return seen


# ---- one scan ------------------------------------------------------------------------------------


@dataclass(frozen=True, eq=False, slots=True)
class OneScan:
    """One scan, the chain of its readings, and what is made of it.

    Parameters
    ----------
    angles, ranges
        The readings, rad and m.
    points
        The readings that came back, m.
    truth
        Faces in the frame of the scanner, m.
    kept
        Vertices kept of the whole chain.
    segments
        The wall segments.
    """

    angles: Float[np.ndarray, " beams"]
    ranges: Float[np.ndarray, " beams"]
    points: Float[np.ndarray, "readings 2"]
    truth: Float[np.ndarray, "faces 2 2"]
    kept: np.ndarray
    segments: Segments


def one_scan(tolerance: float = 0.08, sigma: float = 0.015, *, pose: int = 72) -> OneScan:
    """Take one scan of the chapter's office with a given noise and extract its walls.

    Parameters
    ----------
    tolerance
        Tolerance ε, m.
    sigma
        Noise of the ranges, m.
    pose
        Which pose of the drive.
    """
    office, where = _place(pose)
    scanner = Scanner(range_sigma=sigma)
    ranges = scan(office.faces, where, scanner, rng=np.random.default_rng(7)).ranges[0]
    valid = np.isfinite(ranges)
    points = to_points(ranges[valid], scanner.angles[valid])
    noise = RangeNoise(float(np.hypot(max(sigma, 1e-3), 0.01 / np.sqrt(12))))
    segments, _ = extract_segments(ranges, scanner.angles, Extraction(noise, tolerance))
    truth = act(inverse(where[0]), office.faces)
    kept = simplify(points, tolerance)
    return OneScan(scanner.angles, ranges, points, truth, kept, segments)


@cache
def _place(pose: int) -> tuple[Office, np.ndarray]:
    office = make_office(rng=np.random.default_rng(1))
    return office, drive(office)[pose, None]


TOLERANCES, SIGMAS = (0.02, 0.05, 0.08, 0.2, 0.4, 0.8), (0.0, 0.005, 0.015, 0.03, 0.06)
"""Settings of the explorer of one scan, m."""


def tolerance_study() -> dict[str, float]:
    """Count the settings of the explorer with which all walls of the scan are found."""
    truth = len(one_scan().segments)
    high, low = [], []
    for tolerance in TOLERANCES:
        for sigma in SIGMAS:
            found = len(one_scan(tolerance, sigma).segments) == truth
            noise = float(np.hypot(sigma, 0.01 / np.sqrt(12)))  # and the rounding to 1 cm
            if 3 * noise <= tolerance < TOLERANCES[-1]:
                high.append(found)
            elif tolerance < 2 * noise:
                low.append(found)
    largest = np.abs(np.random.default_rng(0).normal(size=(4000, 100))).max(axis=1).mean()
    good = len(high) if all(high) else 0
    return {
        "good": good,
        "most": TOLERANCES[-2],
        "count": truth,
        "noisy": len(low),
        "right": sum(low),
        "largest": float(largest),
    }


@dataclass(frozen=True, slots=True)
class Step:
    """One call of the recursion of Table 1: sub-chain, farthest vertex, and whether it split."""

    i: int
    j: int
    f: int
    d: float
    split: bool


def recursion(chain: Float[np.ndarray, "n 2"], tolerance: float) -> list[Step]:
    """Return the calls of Table 1 in the order in which they are made."""
    steps, waiting = [], [(0, len(chain) - 1)]
    while waiting:
        i, j = waiting.pop()
        f, d = find_split(chain, i, j)
        steps.append(Step(i, j, f, d, d > tolerance))
        if d > tolerance:
            waiting += [(f, j), (i, f)]
    return steps


# ---- growth --------------------------------------------------------------------------------------

SIZES = {
    Size.QUICK: (500, 1000, 2000, 4000, 8000),
    Size.FULL: (1000, 2000, 4000, 8000, 16000, 32000),
}
"""Numbers of vertices for the growth; counts are exact, so few sizes are enough."""
HULL_SIZES = {
    Size.QUICK: (4000, 8000, 16000, 32000, 64000),
    Size.FULL: (16000, 32000, 64000, 128000, 256000, 512000),
}


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
    """Elementary steps against the number of vertices, and the exponent fitted to them."""

    sizes: np.ndarray
    counts: np.ndarray
    exponent: Interval


def growth(count: Callable[[np.ndarray, float], int], sizes: tuple[int, ...]) -> Growth:
    """Count the steps of an algorithm on worst-case chains and fit a power of the size.

    Parameters
    ----------
    count
        Function of chain and tolerance that returns the number of steps.
    sizes
        Numbers of vertices.
    """
    counts = np.array([count(worst_case(n), 0.1) for n in sizes], dtype=float)
    return Growth(np.array(sizes), counts, exponent(sizes, counts))


def exponent(sizes: tuple[int, ...], values: Float[np.ndarray, " sizes"]) -> Interval:
    """Fit the exponent of a power law, with the 95 % interval of the slope of a regression."""
    fit = stats.linregress(np.log(sizes), np.log(values))
    slope, half = float(fit.slope), float(stats.t.ppf(0.975, len(sizes) - 2) * fit.stderr)
    about = f"95 % of the slope of log cost over log n, n = {sizes[0]} to {sizes[-1]}"
    return Interval(slope, slope - half, slope + half, "", about)


def n_log_n_exponent(size: Size) -> float:
    """Return the exponent that n log n itself shows over the sizes."""
    sizes = np.array(HULL_SIZES[size], dtype=float)
    return exponent(HULL_SIZES[size], sizes * np.log2(sizes)).estimate


def time_exponent(work: Callable[[np.ndarray, float], object], sizes: tuple[int, ...]) -> Interval:
    """Fit the exponent of the time that a program takes on worst-case chains, best of five."""
    times = []
    for n in sizes:
        chain, best = worst_case(n), np.inf
        for _ in range(5):
            start = time.perf_counter()
            work(chain, 0.1)
            best = min(best, time.perf_counter() - start)
        times.append(best)
    return exponent(sizes, np.array(times))


def shapely_ends_with(n: int) -> int:
    """Return the exit code of a process that simplifies a worst-case chain with shapely."""
    program = (
        "import shapely; from robot_perception.chapters.walls import worst_case;"
        f"shapely.LineString(worst_case({n})).simplify(0.1, preserve_topology=False)"
    )
    return subprocess.run([sys.executable, "-c", program], capture_output=True).returncode


def peers() -> dict[str, Interval]:
    """Measure fastrdp and shapely on the worst case, where they are installed."""
    found = {}
    if importlib.util.find_spec("fastrdp"):
        import fastrdp

        found["exponent of fastrdp's time"] = time_exponent(
            fastrdp.rdp_index, (2000, 4000, 8000, 16000)
        )
    if importlib.util.find_spec("shapely"):
        import shapely

        found["exponent of shapely's time"] = time_exponent(
            lambda chain, tolerance: shapely.LineString(chain).simplify(
                tolerance, preserve_topology=False
            ),
            (1000, 2000, 4000, 8000),
        )
    return found


@dataclass(frozen=True, eq=False, slots=True)
class Hulls:
    """A chain, the vertex at which its two path hulls meet, their corners, and the farthest."""

    chain: Float[np.ndarray, "n 2"]
    tag: int
    corners: tuple[np.ndarray, np.ndarray]
    farthest: int


def hull_example(n: int = 60) -> Hulls:
    """Return a wavy chain with the convex hulls of its two halves."""
    rng = np.random.default_rng(2)
    x = np.linspace(0.0, 10.0, n)
    y = 1.4 * np.sin(0.9 * x) + 0.8 * np.sin(2.3 * x + 1) + rng.normal(0, 0.12, n)
    chain, tag = np.stack([x, y], axis=-1), (n - 1) // 2
    left, right = ConvexHull(chain[: tag + 1]).vertices, ConvexHull(chain[tag:]).vertices + tag
    return Hulls(chain, tag, (left, right), find_split(chain, 0, n - 1)[0])


def quadratic(size: Size, rng: np.random.Generator) -> Finding:
    """Count the distances of the plain algorithm on the worst case."""
    plain = growth(count_distances, SIZES[size])
    n, most = int(plain.sizes[-1]), int(plain.counts[-1])
    note = (
        f"{most:,} distances for {n:,} vertices. The exponents of time are those of the machine "
        "that records the ledger."
    )
    if size is Size.FULL and importlib.util.find_spec("shapely"):
        code = shapely_ends_with(100_000)
        note += f" A process that gives shapely 100,000 vertices ends with exit code {code}."
    return Finding(plain.exponent, peers(), note=note)


def path_hulls(size: Size, rng: np.random.Generator) -> Finding:
    """Count the steps of path hulls on the worst case; compare vertices on many simple chains."""
    hulls = growth(count_hull_steps, HULL_SIZES[size])
    trials = 300 if size is Size.QUICK else 3000
    different = 0
    for child in rng.spawn(trials):
        chain = simple_chain(child)
        tolerance = float(child.choice([0.02, 0.2, 1.0]))
        different += not np.array_equal(
            simplify_path_hull(chain, tolerance), simplify(chain, tolerance)
        )
    if different:  # the cost of a wrong answer is no finding
        raise ArithmeticError(f"path hulls kept other vertices on {different} of {trials} chains")
    per = hulls.counts / (hulls.sizes * np.log2(hulls.sizes))
    evidence = {
        "simple chains with other vertices than the plain algorithm": Interval.exact(
            different, about=f"of {trials}"
        ),
        "steps per n log₂ n": Interval(
            float(np.median(per)), float(per.min()), float(per.max()), "", "range over the sizes"
        ),
        "exponent of n log n over the same sizes": Interval.exact(n_log_n_exponent(size)),
    }
    return Finding(hulls.exponent, evidence)


def simple_chain(rng: np.random.Generator) -> Float[np.ndarray, "n 2"]:
    """Return a random simple chain: a scan, a spiral, or a walk to the right."""
    n = int(rng.integers(3, 400))
    kind = rng.integers(3)
    if kind == 0:
        angles = np.sort(rng.uniform(-np.pi / 2, np.pi / 2, n))
        return to_points(rng.uniform(0.5, 8.0, n), angles)
    if kind == 1:
        turns = np.linspace(0.0, min(n / 5, 20.0), n)
        return to_points(1 + turns + rng.uniform(-0.5, 0.5, n), turns)
    return np.stack([np.cumsum(rng.uniform(0.01, 1.0, n)), rng.normal(0, 1.0, n).cumsum()], axis=-1)


# ---- against an oracle ---------------------------------------------------------------------------


def reference_vertices(chain: Float[np.ndarray, "n 2"], tolerance: float) -> list[int]:
    """Simplify by brute force: rotate each sub-chain so that its chord is level, take the highest.

    No formula in common with the library.
    """
    kept, todo = {0, len(chain) - 1}, [(0, len(chain) - 1)]
    z = chain[:, 0] + 1j * chain[:, 1]
    while todo:
        i, j = todo.pop()
        if j - i < 2:
            continue
        level = (z[i + 1 : j] - z[i]) * np.exp(-1j * np.angle(z[j] - z[i]))
        height = np.abs(level.imag) if z[i] != z[j] else np.abs(level)
        if height.max() > tolerance:
            f = i + 1 + int(height.argmax())
            kept.add(f)
            todo += [(i, f), (f, j)]
    return sorted(kept)


def recursive(size: Size, rng: np.random.Generator) -> Finding:
    """Simplify the scans of drives and compare the vertices with the brute-force ones."""
    drives, agree, kept, total = (1 if size is Size.QUICK else 5), [], [], 0
    for child in rng.spawn(drives):
        office = make_office(rng=child)
        scanner = Scanner(resolution=0.0)
        scans = scan(office.faces, drive(office, step=0.5), scanner, rng=child)
        for ranges in scans.ranges:
            valid = np.isfinite(ranges)
            chain = to_points(ranges[valid], scanner.angles[valid])
            mine = simplify(chain, 0.08)
            agree.append(mine.tolist() == reference_vertices(chain, 0.08))
            kept.append(len(mine))
            total += len(chain)
    value = Interval.exact(np.mean(agree), about=f"all {len(agree)} scans of {drives} drives")
    evidence = {
        "vertices kept of a scan": Interval.of_quantiles(np.array(kept)),
        "readings per vertex kept": Interval.exact(total / sum(kept)),
    }
    return Finding(value, evidence)


# ---- chains that cross themselves ----------------------------------------------------------------


def crossing_chain(rng: np.random.Generator, n: int = 60) -> Float[np.ndarray, "n 2"]:
    """Return a random closed curve that crosses itself, as a robot's path does, with noise."""
    t = np.linspace(0.0, 1.9 * np.pi, n)
    a, b = rng.integers(1, 4), rng.integers(2, 5)
    curve = np.stack([np.sin(a * t + rng.uniform(0, 3)), np.sin(b * t)], axis=-1)
    return 4 * curve + rng.normal(0, 0.05, (n, 2))


def simple_needed(size: Size, rng: np.random.Generator) -> Finding:
    """Run path hulls unchecked on chains with and without crossings, and the check on both."""
    trials = 400 if size is Size.QUICK else 5000
    wrong, alarms, silent, crossing = 0, 0, 0, 0
    for child in rng.spawn(trials):
        chain = crossing_chain(child)
        if not is_simple(chain):
            crossing += 1
            wrong += _differs(chain)
        else:
            silent += _differs(chain)
        alarms += not is_simple(simple_chain(child))
    rates = scan_simplicity(rng.spawn(1)[0], 60 if size is Size.QUICK else 300)
    evidence = {
        "wrong vertices on chains that pass the check": Interval.exact(
            silent, about=f"of {trials - crossing} curves without a crossing"
        ),
        "false alarms": Interval.exact(alarms, about=f"of {trials} simple chains"),
        "single scans that cross themselves": Interval.of_proportion(*rates["still"]),
        "scans of 3 s on the move that cross themselves": Interval.of_proportion(*rates["slow"]),
        "two scans in one chain that cross themselves": Interval.of_proportion(*rates["joined"]),
    }
    value = Interval.of_proportion(wrong, crossing)
    return Finding(value, evidence, note="Share of crossing chains on which path hulls err.")


def _differs(chain: np.ndarray, tolerance: float = 0.3) -> bool:
    hulls = simplify_path_hull(chain, tolerance, assume_simple=True)
    return not np.array_equal(hulls, simplify(chain, tolerance))


def scan_simplicity(rng: np.random.Generator, scans: int) -> dict[str, tuple[int, int]]:
    """Count the scans whose chain crosses itself: at rest, swept slowly on the move, two joined.

    Parameters
    ----------
    rng
        Source of the office and of the noise.
    scans
        How many of each.

    Returns
    -------
    Pairs of crossing scans and scans, in the frame of the world.
    """
    office, scanner = make_office(rng=rng), Scanner()
    poses = drive(office)
    chosen = poses[rng.choice(len(poses) - 8, scans, replace=False)]
    crossing = {"still": 0, "slow": 0, "joined": 0}
    for pose in chosen:
        still = scan(office.faces, pose[None], scanner, rng=rng).ranges[0]
        here = _world_points(still[None], scanner.angles, pose[None])
        crossing["still"] += not is_simple(here)
        crossing["slow"] += not is_simple(moving_chain(office, pose, scanner, rng))
        after = compose(pose, np.array([0.3, 0.0, 0.0]))
        again = scan(office.faces, after[None], scanner, rng=rng).ranges[0]
        there = _world_points(again[None], scanner.angles, after[None])
        crossing["joined"] += not is_simple(np.concatenate([here, there]))
    return {name: (count, scans) for name, count in crossing.items()}


def moving_chain(
    office: Office, pose: np.ndarray, scanner: Scanner, rng: np.random.Generator
) -> Float[np.ndarray, "readings 2"]:
    """Return a scan of 3 s at 0.3 m/s, its readings placed where the robot was at each beam."""
    speed, duration = 0.3, 3.0
    ranges = scan_moving(office.faces, pose, (speed, 0.0), duration, scanner, rng=rng).ranges[0]
    time_ = np.linspace(0.0, duration, scanner.beams)
    way = speed * time_[:, None] * rotation(pose[2])[:, 0]
    valid = np.isfinite(ranges)
    points = act(pose, to_points(np.where(valid, ranges, 0.0), scanner.angles)) + way
    return points[valid]


@dataclass(frozen=True, eq=False, slots=True)
class Crossing:
    """A chain that crosses itself: vertices by both algorithms, and the edges that cross."""

    chain: Float[np.ndarray, "n 2"]
    plain: np.ndarray
    hulls: np.ndarray
    edges: np.ndarray


def crossing_example(tolerance: float = 0.3) -> Crossing:
    """Return the first random chain with few crossings on which unchecked path hulls go wrong."""
    for child in np.random.default_rng(5).spawn(1000):
        chain = crossing_chain(child)
        if len(find_crossings(chain)) <= 4 and _differs(chain, tolerance):
            break
    hulls = simplify_path_hull(chain, tolerance, assume_simple=True)
    return Crossing(chain, simplify(chain, tolerance), hulls, find_crossings(chain))


# ---- the erratum of Table 2 ----------------------------------------------------------------------


def simplify_as_printed(chain: Float[np.ndarray, "n 2"], epsilon: float) -> list[int]:
    r"""Simplify with the measure that Table 2 prints, :math:`|\det| / \lVert v_i - v_j \rVert^2`.

    Wrong on purpose: see erratum-table2.
    """
    kept, todo = {0, len(chain) - 1}, [(0, len(chain) - 1)]
    while todo:
        i, j = todo.pop()
        if j - i < 2 or (chain[i] == chain[j]).all():
            continue
        measure = printed_measure(chain, i, j)
        if measure.max() > epsilon:
            f = i + 1 + int(measure.argmax())
            kept.add(f)
            todo += [(i, f), (f, j)]
    return sorted(kept)


def printed_measure(chain: Float[np.ndarray, "n 2"], i: int, j: int) -> Float[np.ndarray, " inner"]:
    """Return what Table 2 prints, for the vertices between two others."""
    chord, arms = chain[j] - chain[i], chain[i + 1 : j] - chain[i]
    return np.abs(chord[0] * arms[:, 1] - chord[1] * arms[:, 0]) / (chord @ chord)


SCALES = (0.1, 0.2, 0.5, 1.0, 2.0, 5.0, 10.0)


def kept_by_scale(epsilon: float = 0.08) -> dict[str, np.ndarray]:
    """Count the vertices kept of one scan at several scales, by the right and the printed rule."""
    chain = one_scan().points
    return {
        "scale": np.array(SCALES),
        "distance": np.array([len(simplify(chain * s, epsilon)) for s in SCALES]),
        "printed": np.array([len(simplify_as_printed(chain * s, epsilon)) for s in SCALES]),
    }


def table2(size: Size, rng: np.random.Generator) -> Finding:
    """Find how the printed measure grows with the size of the chain."""
    triples = rng.normal(size=(1000, 3, 2))
    scales = np.array([1.0, 2.0, 4.0, 8.0])
    measure = np.array([[printed_measure(s * t, 0, 2)[0] for t in triples] for s in scales])
    slopes = np.polyfit(np.log(scales), np.log(measure), 1)[0]
    distance = np.array([find_split(t, 0, 2)[1] for t in triples])
    squared = np.isclose(measure[0], distance**2, rtol=0.01).mean()
    plain = np.isclose(measure[0], distance, rtol=0.01).mean()
    evidence = {
        "triples where it is the squared distance within 1 %": Interval.exact(squared),
        "triples where it is the distance within 1 %": Interval.exact(plain),
        "vertices of one scan, right rule": Interval.exact(len(simplify(one_scan().points, 0.08))),
        "vertices of one scan, printed rule": Interval.exact(
            len(simplify_as_printed(one_scan().points, 0.08))
        ),
    }
    value = Interval.exact(np.round(slopes.mean(), 9) + 0.0, about="power of the chain's scale")
    note = "A number without unit: the distance in units of the chord, so ε is a slope."
    return Finding(value, evidence, note=note)


# ---- Fig. 1 --------------------------------------------------------------------------------------


@dataclass(frozen=True, eq=False, slots=True)
class SearchRange:
    """The search range of one wall hypothesis: a line, its standard deviation, and candidates.

    Parameters
    ----------
    points
        Readings from which the hypothesis was made, m.
    along
        Positions along the wall from the middle of the readings, m.
    half_width
        Half width of the band in which the next look at the wall is expected, m.
    middle, direction, normal
        Frame of the wall.
    """

    points: Float[np.ndarray, "readings 2"]
    along: Float[np.ndarray, " places"]
    half_width: Float[np.ndarray, " places"]
    middle: Float[np.ndarray, "2"]
    direction: Float[np.ndarray, "2"]
    normal: Float[np.ndarray, "2"]


def search_range(
    readings: int = 30, sigma: float = 0.02, probability: float = 0.99, roughness: float = 0.0
) -> SearchRange:
    r"""Return the band in which a wall hypothesis lets another look at the same wall lie.

    At a distance t along the wall the standard deviation is
    :math:`\sigma^2(t) = (1, t)\, C\, (1, t)^\top` with C the covariance of (ρ, θ) seen from the
    middle of the readings.

    Parameters
    ----------
    readings
        How many readings, half a degree apart, on a wall 2 m away.
    sigma
        Noise of the ranges, m.
    probability
        Share of true matches let through, for one degree of freedom at each place.
    roughness
        Added standard deviation perpendicular to the wall, m.
    """
    rng = np.random.default_rng(0)
    angles = np.deg2rad(0.5) * (np.arange(readings) - (readings - 1) / 2) + np.pi / 2
    ranges = 2.0 / np.sin(angles) + sigma * rng.normal(size=readings)
    line = fit_line(ranges, angles, RangeNoise(sigma))
    theta = line.mean[1]
    normal = np.array([np.cos(theta), np.sin(theta)])
    points = to_points(ranges, angles)
    middle = points.mean(axis=0)
    J = np.array([[1.0, middle[0] * np.sin(theta) - middle[1] * np.cos(theta)], [0.0, 1.0]])
    cov = J @ line.cov @ J.T
    along = np.linspace(-3.0, 3.0, 61)
    variance = cov[0, 0] + 2 * along * cov[0, 1] + along**2 * cov[1, 1] + roughness**2
    half = stats.norm.ppf((1 + probability) / 2) * np.sqrt(variance)
    return SearchRange(points, along, half, middle, np.array([-normal[1], normal[0]]), normal)


@dataclass(frozen=True, eq=False, slots=True)
class Growing:
    """The map after so many scans: readings so far (thinned), walls, and the way."""

    scans: int
    points: Float[np.ndarray, "readings 2"]
    walls: WallMap
    way: Float[np.ndarray, "scans 2"]


@cache
def growing_map(frames: int = 24, most_points: int = 1500) -> tuple[Growing, ...]:
    """Return the map of the chapter's drive after equal numbers of scans."""
    result = office_run()
    config, count = result.config, len(result.poses)
    stops = np.unique(np.linspace(1, count, frames).round().astype(int))
    walls, states, done = WallMap.empty(), [], 0
    for stop in stops:
        for k in range(done, stop):
            ranges, pose = result.scans.ranges[k], result.poses[k]
            segments, _ = extract_segments(ranges, config.scanner.angles, config.extraction)
            walls = merge(walls, to_world(segments, pose), config.gate)
        done = int(stop)
        reached = np.isfinite(result.scans.ranges[:stop]).sum()
        thin = result.points[: reached : len(result.points) // most_points]  # a growing set
        states.append(Growing(done, thin, walls, result.poses[:stop, :2]))
    return tuple(states)


@dataclass(frozen=True, eq=False, slots=True)
class GateStudy:
    """Maps of one drive with gates of several widths.

    Parameters
    ----------
    roughness
        Of each gate, m.
    walls, precision, missed
        Number of walls, and the shares of length that are right and that were not found.
    believed
        Median standard deviation of the walls at their middles, without roughness, m.
    """

    roughness: np.ndarray
    walls: np.ndarray
    precision: np.ndarray
    missed: np.ndarray
    believed: float

    def summary(self) -> dict[str, float]:
        """Return the numbers that the chapter tells: no, middling and most roughness, cm and mm."""
        return {
            "most": int(self.walls[0]),
            "good": 100 * float(self.roughness[2]),
            "right": int(self.walls[2]),
            "last": 100 * float(self.roughness[-1]),
            "few": int(self.walls[-1]),
            "believed": 1e3 * self.believed,
        }


def gate_study(roughness: tuple[float, ...] = (0.0, 0.005, 0.02, 0.08, 0.3, 0.6)) -> GateStudy:
    """Build the map of one drive with poses 2 cm wrong, with gates of several widths.

    Parameters
    ----------
    roughness
        Standard deviations added across the wall, m; the angle's is in proportion.
    """
    rng = np.random.default_rng(9)
    small = run(Config(rooms=2, step=0.5), rng=rng)
    config, angles = small.config, small.config.scanner.angles
    poses = small.poses + rng.normal(0, [0.02, 0.02, np.deg2rad(0.3)], small.poses.shape)
    counts, precision, missed, believed = [], [], [], []
    for sigma in roughness:
        gate = Gate(roughness=sigma, roughness_angle=sigma * float(np.deg2rad(50.0)))
        walls, _ = build_map(small.scans.ranges, angles, poses, config.extraction, gate)
        score = score_map(walls.seen_in(config.least_scans), small.office.faces, small.seen)
        counts.append(len(walls.seen_in(config.least_scans)))
        precision.append(score.precision)
        missed.append(1.0 - score.recall)
        believed.append(np.median(believed_sigma(walls.seen_in(config.least_scans))))
    found = (np.array(values) for values in (counts, precision, missed))
    return GateStudy(np.array(roughness), *found, float(believed[0]))


def believed_sigma(walls: WallMap) -> Float[np.ndarray, " walls"]:
    """Return the standard deviation across each wall that its covariance states, m."""
    middles = walls.ends.mean(axis=1)
    one = [
        seen_from(walls.lines[k, None], walls.covs[k, None], middles[k])[1][0, 0, 0]
        for k in range(len(walls))
    ]
    return np.sqrt(np.array(one))


def looks_study() -> dict[str, float]:
    """Compare the map of the drive with and without the walls seen in fewer than three scans."""
    result = office_run()
    everything = growing_map()[-1].walls
    before = score_map(everything, result.office.faces, result.seen)
    return {
        "all": len(everything),
        "gone": len(everything) - len(result.walls),
        "before": before.precision,
        "after": result.score.precision,
        "cost": before.recall - result.score.recall,
    }


def line_consistency(runs: int, rng: np.random.Generator) -> np.ndarray:
    """Return normalised squared errors of fits to one wall, χ² with two degrees if C is right."""
    truth, angles = np.array([2.0, 0.4]), 0.4 + np.linspace(-0.9, 0.6, 60)
    ranges = truth[0] / np.cos(angles - truth[1]) + rng.normal(0, 0.02, (runs, 60))
    fits = fit_line(ranges, angles, RangeNoise(0.02))
    return normalised_squared(fits.mean - truth, fits.cov)


def fig1(size: Size, rng: np.random.Generator) -> Finding:
    """Build maps of several offices and compare each with its floor plan."""
    config = Config(rooms=3, step=0.5) if size is Size.QUICK else Config()
    results = [run(config, rng=child) for child in rng.spawn(4 if size is Size.QUICK else 20)]
    scores = [r.score for r in results]
    offsets = np.array([np.sqrt(np.mean(s.offsets**2)) for s in scores]) * 1e3
    angles = np.rad2deg([np.sqrt(np.mean(s.angles**2)) for s in scores])
    nees = line_consistency(2000, rng.spawn(1)[0])
    evidence = {
        "recall of the faces the beams reached": Interval.of_mean(
            np.array([s.recall for s in scores])
        ),
        "offset of a wall, rms": Interval.of_mean(offsets, "mm"),
        "direction of a wall, rms": Interval.of_mean(angles, "°"),
        "walls in the map": Interval.of_quantiles(np.array([len(r.walls) for r in results])),
        "average NEES of a fitted line (2 is right)": Interval.of_mean(nees),
    }
    value = Interval.of_mean(np.array([s.precision for s in scores]))
    note = (
        f"Share of the map's length that lies on a face of the floor plan, {len(results)} offices."
    )
    return Finding(value, evidence, note=note)


# ---- real recordings -----------------------------------------------------------------------------

REAL_EXTRACTION = Extraction(RangeNoise(0.02), tolerance=0.1)
REAL_GATE = Gate(roughness=0.05, roughness_angle=float(np.deg2rad(2.0)))
REAL_POSE = np.diag([0.03, 0.03, np.deg2rad(0.4)]) ** 2
"""Covariance of the poses of the graph logs; their description says 3–4 cm and 0.4–0.5°."""
LEAST_SCANS = 4


def recorded_map(log: LaserLog, every: int) -> dict[str, np.ndarray | float]:
    """Build the wall map of a recording and measure it without any floor plan.

    Parameters
    ----------
    log
        Scans with optimised poses.
    every
        Take one scan of so many.

    Returns
    -------
    dict
        ``points`` (thinned readings), ``ends`` and ``scans`` of the walls, ``way``, counts,
        ``length`` (total, m), ``explained`` (share of the readings within 3σ of a wall),
        ``reach`` (that 3σ, m), ``directions`` and ``direction_share`` (length per 5° modulo 90°),
        ``square`` (share of the length within 5° of two perpendicular directions), ``offset_mm``,
        ``turn_deg`` and ``shared`` (repeatability of the walls seen in both halves of the drive).
    """
    ranges, poses = log.ranges[::every], log.poses[::every]
    walls, report = _map(ranges, log.angles, poses)
    points = _world_points(ranges, log.angles, poses)
    reach = 3 * float(np.hypot(REAL_EXTRACTION.noise.range_sigma, REAL_GATE.roughness))
    checked = points[:: max(1, len(points) // 20_000)]
    folded = np.rad2deg(walls.lines[:, 1]) % 90.0
    share, _ = np.histogram(folded, 18, (0.0, 90.0), weights=walls.lengths)
    candidates = np.arange(0.0, 90.0, 0.5)
    apart = np.abs((folded[:, None] - candidates + 45.0) % 90.0 - 45.0)
    square = (walls.lengths @ (apart <= 5.0)) / walls.lengths.sum()
    half = len(ranges) // 2
    first, _ = _map(ranges[:half], log.angles, poses[:half])
    second, _ = _map(ranges[half:], log.angles, poses[half:])
    both = score_map(second, first.ends, reach=0.3)
    return {
        "points": np.round(points[:: max(1, len(points) // 2000)], 3),
        "ends": np.round(walls.ends, 3),
        "scans": walls.scans,
        "way": np.round(poses[:: max(1, len(poses) // 500), :2], 3),
        "used": len(ranges),
        "readings": report.readings,
        "walls": len(walls),
        "length": float(walls.lengths.sum()),
        "explained": float(explained(checked, walls, reach).mean()),
        "reach": reach,
        "directions": np.arange(2.5, 90.0, 5.0),
        "direction_share": np.round(share / share.sum(), 4),
        "square": float(square.max()),
        "square_at": float(candidates[square.argmax()]),
        "offset_mm": float(1e3 * stats.median_abs_deviation(both.offsets, scale="normal")),
        "turn_deg": float(np.rad2deg(stats.median_abs_deviation(both.angles, scale="normal"))),
        "shared": len(both.offsets),
    }


def summary(found: Mapping[str, np.ndarray | float]) -> dict[str, float]:
    """Return the numbers about a recorded map that the chapter tells, in cm, mm and degrees."""
    names = ("walls", "length", "explained", "shared")
    lengths = {"reach": 100 * found["reach"], "offset": found["offset_mm"]}
    return {name: found[name] for name in names} | lengths | {"turn": found["turn_deg"]}


def _map(ranges: np.ndarray, angles: np.ndarray, poses: np.ndarray) -> tuple[WallMap, ScanReport]:
    walls, report = build_map(ranges, angles, poses, REAL_EXTRACTION, REAL_GATE, pose_cov=REAL_POSE)
    return walls.seen_in(LEAST_SCANS), report


def _fr079(folder: Path) -> dict[str, np.ndarray | float]:
    return recorded_map(read_graph_log(folder / "fr079_graph.log.gz"), every=2)


def _intel(folder: Path) -> dict[str, np.ndarray | float]:
    return recorded_map(read_graph_log(folder / "intel_graph.log.gz"), every=3)


FR079 = Recording("carmen_fr079", _fr079, store="walls-fr079")
INTEL = Recording("carmen_intel", _intel, store="walls-intel")
RECORDINGS = (FR079, INTEL)


# ---- claims --------------------------------------------------------------------------------------

CLAIMS = (
    Claim(
        id="dp-recursive",
        chapter="walls",
        paper=PAPER,
        place="§2.1, Tables 1 and 2",
        statement="Splitting a chain at the vertex farthest from its chord, again and again, "
        "extracts its straight parts.",
        paper_value="",
        method="share of synthetic scans on which our vertices are those of a brute-force "
        "simplification that shares no formula with ours",
        accepted=Accepted(1.0, 1.0, "the vertices are defined without freedom, so all must agree"),
        compute=recursive,
    ),
    Claim(
        id="dp-quadratic",
        chapter="walls",
        paper=PAPER,
        place="§2.1",
        statement="The original algorithm has quadratic worst-case time.",
        paper_value="n²",
        method="exponent of the number of distances against n, on a zigzag of falling height",
        accepted=Accepted(
            1.95,
            2.05,
            "2; the terms of lower order in (n − 1)(n − 2)/2 shift the slope by less than 0.01",
        ),
        compute=quadratic,
    ),
    Claim(
        id="dp-path-hull",
        chapter="walls",
        paper=PAPER,
        place="§2.1",
        statement="With path hulls the same simplification takes O(n log n).",
        paper_value="n log n",
        method="exponent of the number of hull steps against n on the same zigzag, provided that "
        "all vertices agree with the plain algorithm",
        accepted=Accepted(
            0.95,
            round(float(n_log_n_exponent(Size.QUICK)), 3),
            "from linear, with 0.05 for terms of lower order, to the exponent that n log n itself "
            "shows over the smallest sizes",
        ),
        compute=path_hulls,
    ),
    Claim(
        id="dp-simple-chain",
        chapter="walls",
        paper=PAPER,
        place="§2.1",
        statement="The chain is assumed to be simple.",
        paper_value="",
        method="share of self-crossing curves on which unchecked path hulls keep other vertices "
        "than the plain algorithm",
        accepted=Accepted(
            0.01, 1.0, "the assumption is needed if path hulls err on some chains that break it"
        ),
        compute=simple_needed,
    ),
    Claim(
        id="walls-fig1",
        chapter="walls",
        paper=PAPER,
        place="Fig. 1",
        statement="Walls are inferred from consecutive readings within a search range and merged "
        "into a map.",
        paper_value="",
        method="share of the length of our map that lies on a face of the synthetic floor plan",
        accepted=None,
        compute=fig1,
    ),
    Claim(
        id="erratum-table2",
        chapter="walls",
        paper=PAPER,
        place="Table 2",
        statement="|det| / length² is the squared distance from the line.",
        paper_value="",
        method="power of the scale with which the printed measure grows when a chain is enlarged",
        accepted=Accepted(2.0, 2.0, "a squared distance grows with the square of the scale"),
        compute=table2,
    ),
)


# ---- exercises -----------------------------------------------------------------------------------


def _keeps_only_by_segment(answer: object) -> bool:
    """Whether a vertex is within 0.5 of the line but not of the segment of a three-vertex chain."""
    chain = np.asarray(answer, dtype=float)
    if chain.shape != (3, 2):
        raise ValueError(f"three points wanted, got shape {chain.shape}")
    share = (chain[1] - chain[0]) @ (chain[2] - chain[0])
    share = np.clip(share / ((chain[2] - chain[0]) @ (chain[2] - chain[0])), 0, 1)
    away = np.linalg.norm(chain[1] - chain[0] - share * (chain[2] - chain[0]))
    return bool(find_split(chain, 0, 2)[1] <= 0.5 < away)


EXERCISES = Sheet(
    {
        "walls-1": Exercise(
            answer=count_distances(worst_case(1000), 0.1),
            mistakes=(
                (1000 * 999 // 2, "the two ends of a sub-chain are not measured."),
                (1000 * 1000, "each round looks at one vertex fewer than the last."),
            ),
            hint="The first round measures 998 vertices, the next 997, and so on.",
        ),
        "walls-2": Exercise(
            answer=_keeps_only_by_segment,
            hint="Let the middle vertex lie beyond the end of the chord, almost on its line.",
        ),
        "walls-3": Exercise(
            answer=0.5,
            mistakes=((0.05, "0.05 is the printed measure, a slope; multiply by the chord."),),
            hint="The printed measure is the distance divided by the length of the chord.",
        ),
        "walls-4": Exercise(
            answer="only if the pose stood still",
            mistakes=(("yes", "what if the robot moves while the beam sweeps?"),),
            hint="Use the words of one of the three options.",
        ),
    }
)
check = EXERCISES.check
