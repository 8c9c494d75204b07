"""A ring of sonars: wide cones that lose slanted surfaces, hear clothes badly, and each other.

A pulse leaves in a cone. Each of many rays in it brings back a share that depends on what it meets:
a hard flat surface answers almost only along its normal, cloth answers to all sides but weakly. The
echoes of a range bin add up, and the first bin that passes a threshold is the reading. Some pulses
arrive at a neighbour, which reports half of the whole way.
"""

from dataclasses import dataclass

import numpy as np

from data_synth._checks import array, flags, generator, instance, number, whole
from data_synth.outlines import cast_outlines

_RAYS = 31  # of a cone
_BIN = 0.05  # over which echoes add up, m


@dataclass(frozen=True, slots=True)
class SonarRing:
    """Sonars on a ring, equally spaced; all values but number, cone and cut are ours.

    Parameters
    ----------
    count
        Sonars, counter-clockwise; the first looks back and half a spacing to the right.
    radius
        Of the ring, from which ranges count, m.
    cone
        Opening angle, rad.
    cut
        Readings beyond it are infinite, m.
    least
        Nearest range that can be told from the pulse itself, m.
    mirror
        How far off its normal a hard surface still answers, rad.
    threshold
        Sum of echoes that counts as heard, rays.
    cloth
        Share that cloth sends back, whatever the slant.
    range_sigma
        Deviation of a range, share of it.
    loudness
        Deviation of the logarithm of an echo.
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
    """Return a reading of each sonar (count,), m from the ring; infinite where none heard.

    Parameters
    ----------
    ring
        The sonars.
    pose : (3,)
        Of the robot: x, y, heading, m and rad.
    faces, ellipses
        What stands there: see :func:`data_synth.outlines.cast_outlines`.
    soft : (e,)
        Which ellipses are clothed.
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
    clothed = np.zeros(len(faces) + len(ellipses) + 1, dtype=bool)  # the last: nothing
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
    """Let some sonars hear the pulse of a neighbour first."""
    count = ring.count
    listens = rng.random(count) < ring.crosstalk
    other = (np.arange(count) + rng.choice([-1, 1], count)) % count
    place = np.where(np.isfinite(ranges), ranges, 0.0)[other, None]
    place = mounts[other] + place * np.stack([np.cos(look[other]), np.sin(look[other])], axis=-1)
    whole = ranges[other] + np.hypot(*(place - mounts).T)
    return np.where(listens, np.minimum(ranges, whole / 2), ranges)
