"""One scan, split at its farthest vertex again and again: Tables 1 and 2 of the paper."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache

import numpy as np
from jaxtyping import Float, Int

from data_synth.laser import Scanner, scan
from data_synth.office import Office, drive, make_office
from robot_perception import walls
from robot_perception.evaluation.intervals import exact
from robot_perception.geometry import act, compose, inverse
from robot_perception.teaching.claims import Finding
from robot_perception.teaching.studies import Change, Study
from robot_perception.teaching.verdicts import Accepted

Measure = Callable[[np.ndarray, int, int], np.ndarray]
"""How far from its chord each inner vertex of a sub-chain is: chain, i, j."""
Simplify = Callable[[np.ndarray, float], np.ndarray | list[int]]
"""Vertices kept of a chain with a tolerance."""
TOLERANCE = 0.08
"""The chapter's tolerance ε, m."""
TOLERANCES = (0.02, 0.03, 0.04, 0.05, 0.08, 0.2, 0.4, 0.8)
"""Tolerances ε of the explorer, m."""
PLACES = (0.0, 0.5, 1.0, 1.5, 2.0, 2.5), (-1.0, -0.5, 0.0, 0.5, 1.0, 1.5)
"""Where the explorer may put the scanner, m ahead and to the left of the chapter's place."""
ROUNDING = 0.01 / np.sqrt(12)
"""Standard deviation of rounding a reading to 1 cm, m."""


@dataclass(frozen=True, eq=False, slots=True)
class OneScan:
    """One scan in its own frame, m and rad; ``kept`` are the vertices kept of the whole chain."""

    tolerance: float
    sigma: float
    angles: Float[np.ndarray, " beams"]
    ranges: Float[np.ndarray, " beams"]
    points: Float[np.ndarray, "readings 2"]
    truth: Float[np.ndarray, "faces 2 2"]
    kept: Int[np.ndarray, " kept"]
    segments: walls.Segments

    @property
    def deviations(self) -> float:
        """The tolerance over the noise of the readings and of their rounding together."""
        return self.tolerance / float(np.hypot(self.sigma, ROUNDING))


def one_scan(
    tolerance: float = TOLERANCE, sigma: float = 0.015, at: tuple[float, float] = (0.0, 0.0)
) -> OneScan:
    """Take one scan of the chapter's office and extract its walls; tolerance ε and noise σ in m.

    It is taken so far ahead and to the left of the chapter's place, m.
    """
    office, pose = _place()
    pose = compose(pose, np.array([*at, 0.0]))
    scanner = Scanner(range_sigma=sigma)
    ranges = scan(office.faces, pose[None], scanner, rng=np.random.default_rng(7)).ranges[0]
    points = to_chain(ranges, scanner)
    noise = walls.RangeNoise(float(np.hypot(max(sigma, 1e-3), ROUNDING)))
    extraction = walls.Extraction(noise, tolerance)
    segments, _ = walls.extract_segments(ranges, scanner.angles, extraction)
    truth = act(inverse(pose), office.faces)
    kept = walls.simplify(points, tolerance)
    return OneScan(tolerance, sigma, scanner.angles, ranges, points, truth, kept, segments)


@cache
def _place() -> tuple[Office, np.ndarray]:
    office = make_office(rng=np.random.default_rng(1))
    return office, drive(office)[71]


def to_chain(ranges: Float[np.ndarray, " beams"], scanner: Scanner) -> Float[np.ndarray, "n 2"]:
    """Return the readings of a scan that came back, as points in its frame, m."""
    valid = np.isfinite(ranges)
    return walls.to_points(ranges[valid], scanner.angles[valid])


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
        f, d = walls.find_split(chain, i, j)
        steps.append(Step(i, j, f, d, d > tolerance))
        if d > tolerance:
            waiting += [(f, j), (i, f)]
    return steps


@cache
def asked() -> tuple[Step, ...]:
    """Return the calls on the opening scan that have a vertex to ask for."""
    return tuple(call for call in recursion(one_scan().points, TOLERANCE) if call.j > call.i + 1)


def split(
    chain: np.ndarray,
    tolerance: float,
    measure: Measure,
    place: Callable[[np.ndarray], int] = np.argmax,
) -> list[int]:
    """Return the vertices kept if ``measure`` says how far off, and ``place`` which one splits."""
    kept, todo = {0, len(chain) - 1}, [(0, len(chain) - 1)]
    while todo:
        i, j = todo.pop()
        far = measure(chain, i, j)
        if far.max(initial=0.0) > tolerance:
            f = i + 1 + int(place(far))
            kept.add(f)
            todo += [(i, f), (f, j)]
    return sorted(kept)


def reference_vertices(chain: Float[np.ndarray, "n 2"], tolerance: float) -> list[int]:
    """Simplify by turning each sub-chain until its chord is level: no formula of the library's."""
    return split(chain, tolerance, heights)


def heights(chain: np.ndarray, i: int, j: int) -> np.ndarray:
    """Return how far the vertices between two others are from their line, by turning it level."""
    z = chain[:, 0] + 1j * chain[:, 1]
    level = (z[i + 1 : j] - z[i]) * np.exp(-1j * np.angle(z[j] - z[i]))
    return np.abs(level.imag) if z[i] != z[j] else np.abs(level)


def printed_measure(chain: Float[np.ndarray, "n 2"], i: int, j: int) -> Float[np.ndarray, " inner"]:
    r"""Return what Table 2 prints for the vertices between two: |det| / ‖v_i − v_j‖²."""
    chord, arms = chain[j] - chain[i], chain[i + 1 : j] - chain[i]
    squared = chord @ chord or np.inf  # no line through one point: nothing to split
    return np.abs(chord[0] * arms[:, 1] - chord[1] * arms[:, 0]) / squared


def simplify_as_printed(chain: Float[np.ndarray, "n 2"], epsilon: float) -> list[int]:
    """Simplify with the measure that Table 2 prints. Wrong on purpose: see erratum-table2."""
    return split(chain, epsilon, printed_measure)


@dataclass(frozen=True, eq=False, slots=True)
class KeptByScale:
    """How many vertices of an enlarged scan are kept, by a distance and by the printed measure."""

    scales: Float[np.ndarray, " scales"]
    distance: Int[np.ndarray, " scales"]
    printed: Int[np.ndarray, " scales"]


def kept_by_scale(epsilon: float = TOLERANCE) -> KeptByScale:
    """Count the vertices kept of one scan at several scales, by the right and the printed rule."""
    scales = np.array([0.1, 0.2, 0.5, 1.0, 2.0, 5.0, 10.0])
    chains = [one_scan().points * scale for scale in scales]
    right = [len(walls.simplify(chain, epsilon)) for chain in chains]
    printed = [len(simplify_as_printed(chain, epsilon)) for chain in chains]
    return KeptByScale(scales, np.array(right), np.array(printed))


def enlarge(
    measure: str, *, rng: np.random.Generator
) -> tuple[Float[np.ndarray, "triples 3 2"], float]:
    """Return triples of points, and the power of their scale with which one of `MEASURES` grows."""
    triples, scales = rng.normal(size=(1000, 3, 2)), np.array([1.0, 2.0, 4.0, 8.0])
    values = np.array([[MEASURES[measure](s * t, 0, 2)[0] for t in triples] for s in scales])
    slopes = np.polyfit(np.log(scales), np.log(values), 1)[0]
    return triples, float(np.round(slopes.mean(), 9) + 0.0)


def _squared_distance(chain: np.ndarray, i: int, j: int) -> np.ndarray:
    chord = chain[j] - chain[i]
    return printed_measure(chain, i, j) ** 2 * (chord @ chord)


MEASURES: dict[str, Measure] = {
    "as printed": printed_measure,
    "with a squared determinant": _squared_distance,
}
enlarging = Study(enlarge, full="as printed", quick="as printed")


@enlarging.claim(
    "erratum-table2",
    paper="perception-issues",
    place="Table 2",
    basis="mathematics",  # the power is exact: the determinant grows as the square of the length
    statement="|det| / length² is the squared distance from the line.",
    method="power of the scale with which the printed measure grows when a chain is enlarged",
    accepted=Accepted(2.0, 2.0, "a squared distance grows with the square of the scale"),
    sabotage=Change(
        "the determinant squared as well, det² / length²", config="with a squared determinant"
    ),
)
def erratum_table2(enlarged: tuple[Float[np.ndarray, "triples 3 2"], float]) -> Finding:
    """Compare the printed measure with the distance and with its square."""
    triples, power = enlarged
    printed = np.array([printed_measure(t, 0, 2)[0] for t in triples])
    distance = np.array([walls.find_split(t, 0, 2)[1] for t in triples])
    squared, plain = (np.isclose(printed, d, rtol=0.01).mean() for d in (distance**2, distance))
    kept = one_scan().points
    evidence = {
        "triples where it is the squared distance within 1 %": exact(squared),
        "triples where it is the distance within 1 %": exact(plain),
        "vertices of one scan, right rule": exact(len(walls.simplify(kept, TOLERANCE))),
        "vertices of one scan, printed rule": exact(len(simplify_as_printed(kept, TOLERANCE))),
    }
    note = "A number without unit: the distance in units of the chord, so ε is a slope."
    return Finding(exact(power, about="power of the chain's scale"), evidence, note=note)
