r"""A ring of sonars with wide cones: they miss slanted surfaces and hardly hear clothes.

A pulse leaves in a cone of rays. A ray at angle α off the axis of a cone of opening Ω meets a
surface at distance r and at slant ψ off its normal, and brings back the echo

.. math:: e = \frac{g(\psi)\, \cos(\pi \alpha / \Omega)}{1 + r^2 / 4}, \qquad
    g(\psi) = \begin{cases} e^{-(\psi / \psi_0)^2} & \text{hard} \\
    c \cos\psi & \text{cloth} \end{cases}

with :math:`\psi_0` the ring's ``mirror`` and c its ``cloth``. A hard surface answers almost only
along its normal; cloth answers to all sides, but weakly. The echoes of a range bin add up, and the
nearest one in the first bin above a threshold is the reading. Sometimes a sonar hears the pulse of
its neighbour, and reports half of the whole way of that pulse.
"""

from dataclasses import dataclass

import numpy as np

from data_synth._checks import array, flags, generator, instance, number, whole
from data_synth.outlines import cast_outlines

_RAYS = 31  # in a cone
_BIN = 0.05  # length of a range bin, m


@dataclass(frozen=True, slots=True)
class SonarRing:
    """Sonars on a ring, equally spaced. Count, cone and cut are the paper's, other values ours.

    Parameters
    ----------
    count
        Number of sonars, counter-clockwise; the first looks back, half a spacing to the robot's
        right.
    radius
        Radius of the ring, m; ranges are measured from the ring.
    cone
        Opening angle, rad.
    cut
        Longest range, m; farther readings are infinite.
    least
        Shortest range, m; a nearer echo is lost in the pulse.
    mirror
        Slant at which the echo of a hard surface falls to 1/e, rad.
    threshold
        Sum of echoes from which on a pulse counts as heard, in rays that come back whole.
    cloth
        Share of a ray that cloth sends back along its normal; it falls with the cosine of the
        slant.
    range_sigma
        Standard deviation of a range, as a share of it.
    loudness
        Standard deviation of the logarithm of a sonar's gain, drawn anew at each reading.
    crosstalk
        Probability that a sonar also listens to the pulse of a neighbour.
    """

    count: int = 16
    radius: float = 0.22
    cone: float = float(np.deg2rad(15.0))
    cut: float = 2.0
    least: float = 0.12
    mirror: float = float(np.deg2rad(14.0))
    threshold: float = 1.4
    cloth: float = 0.55
    range_sigma: float = 0.012
    loudness: float = 0.5
    crosstalk: float = 0.08

    def __post_init__(self) -> None:
        whole("count", self.count, 1, 360)
        number("radius", self.radius, 0.0, 10.0)
        number("cone", self.cone, 0.0, np.pi)
        number("cut", self.cut, above=0.0, finite=False)
        number("least", self.least, 0.0)
        number("mirror", self.mirror, above=0.0, high=np.pi)
        number("threshold", self.threshold, above=0.0)
        number("cloth", self.cloth, 0.0, 1.0)
        number("range_sigma", self.range_sigma, 0.0, 1.0)
        number("loudness", self.loudness, 0.0, 5.0)
        number("crosstalk", self.crosstalk, 0.0, 1.0)

    @property
    def angles(self) -> np.ndarray:
        """Directions of the sonars, counter-clockwise from ahead, rad: (count,)."""
        return (np.arange(self.count) + 0.5) * 2 * np.pi / self.count - np.pi


def ping(
    ring: SonarRing,
    pose: np.ndarray,
    faces: np.ndarray,
    ellipses: np.ndarray,
    soft: np.ndarray,
    *,
    rng: np.random.Generator,
) -> np.ndarray:
    """Return the range (count,) that each sonar reads, m from the ring; infinite without an echo.

    Parameters
    ----------
    ring
        The sonars.
    pose : (3,)
        Pose of the robot: x, y and heading, m and rad.
    faces, ellipses
        Outlines of what stands there, as for :func:`data_synth.outlines.cast_outlines`.
    soft : (e,)
        Whether each ellipse is clothed.
    rng
        Source of the noise.
    """
    instance("ring", ring, SonarRing)
    generator(rng)
    x, y, heading = array("pose", pose, (3,))
    faces, ellipses = array("faces", faces, (None, 2, 2)), array("ellipses", ellipses, (None, 5))
    soft = flags("soft", soft, len(ellipses))
    count = ring.count
    off = np.linspace(-0.5, 0.5, _RAYS) * ring.cone
    look = heading + ring.angles
    mounts = np.array([x, y]) + ring.radius * np.stack([np.cos(look), np.sin(look)], axis=-1)
    rays = (look[:, None] + off).ravel()
    away, met, slant = (
        part.reshape(count, _RAYS)
        for part in cast_outlines(np.repeat(mounts, _RAYS, axis=0), rays, faces, ellipses)
    )
    clothed = np.zeros(len(faces) + len(ellipses) + 1, dtype=bool)  # entry -1: no hit
    clothed[len(faces) : -1] = soft
    answer = np.where(
        clothed[met], ring.cloth * np.cos(slant), np.exp(-((slant / ring.mirror) ** 2))
    )
    answer = answer * np.cos(np.pi / 2 * np.minimum(np.abs(off) / max(ring.cone, 1e-9) * 2, 1.0))
    bins = np.arange(0.0, min(ring.cut, 20.0) + 2 * _BIN, _BIN)
    place = np.where(np.isfinite(away), away / _BIN, len(bins)).astype(int).clip(max=len(bins))
    echo = np.zeros((count, len(bins) + 1))
    np.add.at(echo, (np.arange(count)[:, None], place), np.where(met >= 0, answer, 0.0))
    loud = np.exp(ring.loudness * rng.standard_normal(count))
    heard = echo[:, :-1] * loud[:, None] / (1 + bins**2 / 4) >= ring.threshold
    heard[:, : int(ring.least / _BIN)] = False
    first = np.where(heard.any(axis=1), heard.argmax(axis=1), -1)
    inside = place == first[:, None]
    nearest = np.where(inside, away, np.inf).min(axis=1)
    ranges = np.where(first >= 0, nearest, np.inf)
    ranges = _crosstalk(ring, ranges, mounts, look, rng)
    ranges = ranges * (1 + ring.range_sigma * rng.standard_normal(count))
    return np.where((ranges < ring.least) | (ranges >= ring.cut), np.inf, ranges)


def _crosstalk(
    ring: SonarRing,
    ranges: np.ndarray,
    mounts: np.ndarray,
    look: np.ndarray,
    rng: np.random.Generator,
) -> np.ndarray:
    """Return ranges of which some come from the pulse of a neighbour, where that echo is nearer."""
    count = ring.count
    listens = rng.random(count) < ring.crosstalk
    other = (np.arange(count) + rng.choice([-1, 1], count)) % count
    place = np.where(np.isfinite(ranges), ranges, 0.0)[other, None]
    place = mounts[other] + place * np.stack([np.cos(look[other]), np.sin(look[other])], axis=-1)
    whole = ranges[other] + np.hypot(*(place - mounts).T)
    return np.where(listens, np.minimum(ranges, whole / 2), ranges)
