r"""Pairs of legs in one scan of a laser at knee height.

The readings are cut into segments of similar distance. A segment with the width, depth and shape
of a leg is taken for a leg, and two legs within a step of each other for a person. The legs of a
table may pass, too; a person in a skirt, or with one leg behind the other, is missed.
"""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float, Int

from robot_perception import checks
from robot_perception.beliefs import Gaussian
from robot_perception.fields import checked
from robot_perception.geometry.angles import check_turn, closes
from robot_perception.people._readings import check_readings
from robot_perception.people.detections import polar


@dataclass(frozen=True, slots=True)
class LegRules:
    r"""Rules for a leg and for a pair of legs. The paper gives no values: all are our choice.

    Parameters
    ----------
    jump
        Largest difference between neighbouring readings of one segment, m.
    least_readings
        Fewest readings of a leg, at least 2: fewer show no shape.
    widths
        Least and largest width of a leg, m.
    deviation
        Largest standard deviation of the distances in a leg's segment, m.
    hollow
        How far the front of a leg may lie behind the line between its ends, on average, m. A leg
        bulges towards the laser; this leaves room for noise.
    apart
        Least and largest distance between the axes of a person's legs, m.
    range_sigma
        Standard deviation of a person's distance, m.
    side_step
        Standard deviation of a person's position across the line of sight, m: how far people sway
        or step aside.

    Raises
    ------
    ValueError
        If a number is not positive, ``least_readings`` is below 2, or the ends of a range do not
        rise.

    References
    ----------
    Schaffernicht et al. 2005 (see `Detections`), sections 2.1 and 3.1.
    """

    jump: float = 0.1
    least_readings: int = 2
    widths: tuple[float, float] = (0.05, 0.25)
    deviation: float = 0.04
    hollow: float = 0.015
    apart: tuple[float, float] = (0.1, 0.5)
    range_sigma: float = 0.05
    side_step: float = 0.1

    def __post_init__(self) -> None:
        for name in ("jump", "deviation", "hollow", "range_sigma", "side_step"):
            object.__setattr__(self, name, checks.positive(name, getattr(self, name)))
        object.__setattr__(
            self, "least_readings", checks.whole("least_readings", self.least_readings, 2)
        )
        for name in ("widths", "apart"):
            low, high = checks.vector(name, getattr(self, name), 2).tolist()
            if not 0 <= low < high:
                raise ValueError(f"{name} must rise from 0 or more, got {(low, high)}")
            object.__setattr__(self, name, (low, high))


@dataclass(frozen=True, eq=False, slots=True)
class Profiles:
    """Shapes of segments.

    Parameters
    ----------
    spans : (k, 2)
        Index of the first and of the last reading of each segment.
    middles : (k, 2)
        Axis of a cylinder with such a front, in the frame of the laser, m.
    widths : (k,)
        Distance from end to end, plus half a gap between beams at either end, m.
    deviations : (k,)
        Standard deviation of the distances, m.
    bulges : (k,)
        How far the readings between the ends lie in front of the line through the ends, on
        average, m; negative for a hollow.
    free : (k,)
        Whether the next reading on at least one side is farther away. A strip of wall that shows
        between two nearer objects is not free.
    """

    spans: Int[np.ndarray, "k 2"]
    middles: Float[np.ndarray, "k 2"]
    widths: Float[np.ndarray, " k"]
    deviations: Float[np.ndarray, " k"]
    bulges: Float[np.ndarray, " k"]
    free: Bool[np.ndarray, " k"]
    __post_init__ = checked

    def __len__(self) -> int:
        return len(self.spans)


def segments(
    ranges: Float[np.ndarray, " n"],
    angles: Float[np.ndarray, " n"],
    rules: LegRules = LegRules(),
) -> Int[np.ndarray, "k 2"]:
    """Return the first and the last reading of each segment of similar distances.

    Parameters
    ----------
    ranges : (n,)
        Readings, m; infinite where nothing came back, which ends a segment.
    angles : (n,)
        Directions of the beams, rising, rad. In a scan of a full turn the last beam is next to the
        first (`geometry.closes`); in a segment across this seam the index of the first reading is
        larger than that of the last.
    rules
        Their ``jump`` says which neighbours are similar.

    Returns
    -------
    (k, 2)
        Indices of readings.

    Raises
    ------
    ValueError
        If the shapes disagree, there is no beam, a reading is NaN or not positive, the angles do
        not rise, or they span more than a turn.
    """
    ranges, angles = _scan(ranges, angles)
    return _cut(ranges, closes(angles), checks.instance("rules", rules, LegRules).jump)


def profiles(
    ranges: Float[np.ndarray, " n"],
    angles: Float[np.ndarray, " n"],
    rules: LegRules = LegRules(),
) -> Profiles:
    r"""Return the shapes of all segments that have enough readings.

    The front of a cylinder of radius a, seen from afar, lies on average
    :math:`a \int_0^1 \sqrt{1 - u^2}\, du = \pi a / 4` in front of its axis. So the axis lies by
    this much behind the mean of the readings, with half the width for a.

    Parameters and exceptions are those of `segments`.
    """
    ranges, angles = _scan(ranges, angles)
    ring = closes(angles)
    spans = _cut(ranges, ring, checks.instance("rules", rules, LegRules).jump)
    counts = (spans[:, 1] - spans[:, 0]) % len(ranges) + 1
    spans, counts = (found[counts >= rules.least_readings] for found in (spans, counts))
    first, last = spans.T
    rows = np.repeat(np.arange(len(spans)), counts)
    taken = np.arange(len(rows)) - np.repeat(np.cumsum(counts) - counts, counts) + first[rows]
    taken %= len(ranges)

    def mean(values: np.ndarray) -> np.ndarray:
        return np.bincount(rows, values, len(spans)) / counts

    r = ranges[taken]
    x, y = r * np.cos(angles[taken]), r * np.sin(angles[taken])
    middle_r, middle_x, middle_y = mean(r), mean(x), mean(y)
    deviations = np.sqrt(mean((r - middle_r[rows]) ** 2))
    begin = np.cumsum(counts) - counts
    end = begin + counts - 1
    along_x, along_y = x[end] - x[begin], y[end] - y[begin]
    chords = np.hypot(along_x, along_y)
    gaps = (angles[last] - angles[first] + 2 * np.pi * (last < first)) / (counts - 1)
    widths = chords + middle_r * gaps
    # beams run counter-clockwise, so the laser is to the left of the line from first to last
    ahead = along_x[rows] * (y - y[begin[rows]]) - along_y[rows] * (x - x[begin[rows]])
    inner = np.maximum(counts - 2, 1)
    bulges = mean(ahead) * counts / (inner * np.maximum(chords, np.finfo(float).tiny))
    outwards = 1 + np.pi / 8 * widths / np.hypot(middle_x, middle_y)
    middles = np.stack([middle_x, middle_y], axis=-1) * outwards[:, None]
    sides = np.concatenate([ranges[-1:], ranges, ranges[:1]])
    if not ring:
        sides[[0, -1]] = np.inf
    free = (sides[first] > ranges[first]) | (sides[last + 2] > ranges[last])
    return Profiles(spans, middles, widths, deviations, bulges, free)


def are_legs(found: Profiles, rules: LegRules = LegRules()) -> Bool[np.ndarray, " k"]:
    """Tell which segments look like a leg: by width, depth and shape, and by standing free.

    Parameters
    ----------
    found
        Shapes of the segments.
    rules
        Limits for a leg.
    """
    checks.instance("found", found, Profiles)
    low, high = checks.instance("rules", rules, LegRules).widths
    thick = (found.widths >= low) & (found.widths <= high)
    compact = found.deviations <= rules.deviation
    return thick & compact & (found.bulges >= -rules.hollow) & found.free


def pairs(
    middles: Float[np.ndarray, "k 2"], rules: LegRules = LegRules()
) -> Int[np.ndarray, "p 2"]:
    """Return which legs belong to one person: the closest pair first, each leg in one pair.

    Parameters
    ----------
    middles : (k, 2)
        Axes of the legs, m.
    rules
        Their ``apart`` says how far apart a pair may stand.

    Returns
    -------
    (p, 2)
        Indices of rows of ``middles``, the closest pair first.

    Raises
    ------
    ValueError
        If the shape is another, or a number is not finite.
    """
    middles = checks.array("middles", middles, ("k", 2))
    low, high = checks.instance("rules", rules, LegRules).apart
    one, other = np.triu_indices(len(middles), 1)
    apart = np.hypot(*(middles[one] - middles[other]).T)
    near = np.flatnonzero((apart >= low) & (apart <= high))
    taken, found = np.zeros(len(middles), dtype=bool), []
    for k in near[np.argsort(apart[near], kind="stable")].tolist():
        if not (taken[one[k]] or taken[other[k]]):
            taken[one[k]] = taken[other[k]] = True
            found.append([one[k], other[k]])
    return np.array(found, dtype=np.int64).reshape(-1, 2)


def detect(
    ranges: Float[np.ndarray, " n"],
    angles: Float[np.ndarray, " n"],
    rules: LegRules = LegRules(),
) -> Gaussian:
    r"""Return the positions of people in a scan: the middles of pairs of legs.

    Each has the covariance

    .. math:: C = \operatorname{diag}\left(\sigma_r^2,\, \arctan^2(s / r)\right)

    The variance of the distance is the same everywhere. That of the direction grows as the distance
    shrinks, because a step of length s to the side turns the line of sight more.

    Parameters and exceptions are those of `segments`.

    Returns
    -------
    Gaussian
        Positions :math:`(r, \varphi)` in the frame of the laser, m and rad: a batch with one entry
        for each pair, empty if there is none.

    References
    ----------
    Schaffernicht et al. 2005 (see `Detections`), sections 2.1 and 3.1.
    """
    found = profiles(ranges, angles, rules)
    middles = found.middles[are_legs(found, rules)]
    x, y = middles[pairs(middles, rules)].mean(axis=1).T
    r = np.hypot(x, y)
    return polar(r, np.arctan2(y, x), rules.range_sigma, np.arctan2(rules.side_step, r))


def _scan(ranges: np.ndarray, angles: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return checked readings and their checked directions."""
    ranges = checks.array("ranges", ranges, ("n",), finite=False)
    angles = checks.array("angles", angles, ranges.shape, f"ranges {ranges.shape}")
    check_readings("ranges", ranges)
    checks.moderate("ranges", ranges[np.isfinite(ranges)])
    return ranges, check_turn(angles)


def _cut(ranges: np.ndarray, ring: bool, jump: float) -> np.ndarray:
    """Return the first and last readings of segments; in a ring the last is next to the first."""
    there = np.flatnonzero(np.isfinite(ranges))
    if not there.size:
        return np.zeros((0, 2), dtype=np.int64)
    apart = (np.diff(there) > 1) | (np.abs(np.diff(ranges[there])) > jump)
    spans = np.stack([there[np.r_[True, apart]], there[np.r_[apart, True]]], axis=-1)
    across = ring and np.isfinite(ranges[[0, -1]]).all() and abs(ranges[-1] - ranges[0]) <= jump
    if across and len(spans) == 1:  # one closed segment: let it begin at the farthest
        first = int(np.argmax(ranges))
        return np.array([[first, (first - 1) % len(ranges)]])
    if across:
        spans[-1, 1] = spans[0, 1]
        spans = spans[1:]
    return spans
