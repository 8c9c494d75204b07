"""A robot that drives below the ceiling, and the paths that a teacher leads it along.

Positions only: arcs, and wheels that slip.
"""

from typing import Literal, get_args

import numpy as np

from data_synth._checks import array, generator, instance, number
from data_synth.wheels import SMALL, Slip

Path = Literal["line", "corner", "slalom", "loop"]

RADIUS = 1.5
"""Radius of the arcs of a corner and of a loop, m."""

_QUARTER = np.pi / 2 * RADIUS
_PIECES: dict[str, tuple[tuple[float, float], ...]] = {  # length, m, and curvature, 1/m
    "line": ((6.0, 0.0),),
    "corner": ((3.0, 0.0), (_QUARTER, 1 / RADIUS), (3.0, 0.0)),
    "slalom": (
        (0.5, 0.0),
        (np.pi / 2, 0.5),
        (np.pi, -0.5),
        (np.pi, 0.5),
        (np.pi / 2, -0.5),
        (0.5, 0.0),
    ),
    "loop": (
        (2.5, 0.0),
        (_QUARTER, 1 / RADIUS),
        (3.0, 0.0),
        (_QUARTER, 1 / RADIUS),
        (5.0, 0.0),
        (_QUARTER, 1 / RADIUS),
        (3.0, 0.0),
        (_QUARTER, 1 / RADIUS),
        (5.0, 0.0),  # over its start
    ),
}
_WAVES = 4  # of a teacher's hand
_SWAY = 0.015  # deviation of each, m
_LONGEST, _SHORTEST = 6.0, 2.5  # of them, m


def drive(
    pose: np.ndarray,
    speed: float,
    turn_rate: float,
    seconds: float,
    slip: Slip = SMALL,
    *,
    rng: np.random.Generator,
) -> np.ndarray:
    """Return where a robot gets to that wants to drive along an arc, x, y, heading (3,).

    The heading comes back from -π to π.

    Parameters
    ----------
    pose : (3,)
        Where it is: x, y, heading, m and rad.
    speed
        Ahead, m/s.
    turn_rate
        To the left, rad/s.
    seconds
        For which it drives, s.
    slip
        How wrong its wheels are: what they do not do of what they should.
    rng
        Source of the slip.
    """
    x, y, heading = array("pose", pose, (3,), 1e6)
    number("speed", speed, -100.0, 100.0)
    number("turn_rate", turn_rate, -100.0, 100.0)
    number("seconds", seconds, 0.0, 1e4)
    instance("slip", slip, Slip)
    generator(rng)
    distance, turned = speed * seconds, turn_rate * seconds
    chord = distance * np.sinc(turned / (2 * np.pi))  # which leaves at half the turn
    root = np.sqrt(abs(distance))
    errors = rng.standard_normal(3) * [
        slip.along * root,
        slip.across * root,
        np.hypot(slip.bend * root, slip.turn * np.sqrt(abs(turned))),
    ]
    ahead = chord * np.cos(turned / 2) + errors[0]
    left = chord * np.sin(turned / 2) + errors[1]
    return np.array(
        [
            x + np.cos(heading) * ahead - np.sin(heading) * left,
            y + np.sin(heading) * ahead + np.cos(heading) * left,
            _wrapped(heading + turned + errors[2]),
        ]
    )


def taught_path(kind: Path, *, step: float, rng: np.random.Generator | None = None) -> np.ndarray:
    """Return a path (n, 3) that a teacher leads a robot along: x, y, heading, m and rad.

    It begins at the origin along x, with a hand that sways near it; headings are tangential, from
    -π to π.

    Parameters
    ----------
    kind
        "line", 6 m; "corner", 3 m, a quarter of a circle to the left, 3 m; "slalom", arcs of 2 m
        of radius to the left and to the right; "loop", a rectangle of 8 m × 6 m with round corners,
        to the left, from the middle of a long side and 2.5 m beyond it after a round.
    step
        Between poses, along the path, m; what is left of the path at its end is not driven.
    rng
        Source of how a teacher's hand sways by some centimetres; ``None`` for a perfect hand.

    Raises
    ------
    ValueError
        If the kind is unknown or the step is not from 1 mm to 1 m.
    """
    if not isinstance(kind, str) or kind not in get_args(Path):
        raise ValueError(f"kind must be one of {', '.join(get_args(Path))}, got {kind!r:.60}")
    number("step", step, 1e-3, 1.0)
    pieces = np.array(_PIECES[kind])
    ends = np.cumsum(pieces[:, 0])
    driven = step * np.arange(int(ends[-1] / step + 1e-9) + 1)
    piece = np.searchsorted(ends[:-1], driven, side="right")
    starts = np.zeros((len(pieces), 3))
    for k, (length, bend) in enumerate(pieces[:-1]):
        starts[k + 1] = _along(starts[k], bend, np.array(length))
    poses = _along(starts[piece], pieces[piece, 1], driven - (ends - pieces[:, 0])[piece])
    if rng is not None:
        generator(rng)
        aside, slope = _sway(driven, rng)
        poses[:, 0] -= aside * np.sin(poses[:, 2])
        poses[:, 1] += aside * np.cos(poses[:, 2])
        poses[:, 2] += np.arctan2(slope, 1 - pieces[piece, 1] * aside)
    poses[:, 2] = _wrapped(poses[:, 2])
    return poses


def _along(start: np.ndarray, bend: np.ndarray | float, length: np.ndarray) -> np.ndarray:
    """Return the poses (…, 3) some lengths along arcs from their starts (…, 3)."""
    half = bend * length / 2
    chord, way = length * np.sinc(half / np.pi), start[..., 2] + half
    x, y = start[..., 0] + chord * np.cos(way), start[..., 1] + chord * np.sin(way)
    return np.stack([x, y, start[..., 2] + 2 * half], axis=-1)


def _sway(driven: np.ndarray, rng: np.random.Generator) -> tuple[np.ndarray, np.ndarray]:
    """Return how far a hand leads to the left (n,), m, and how that grows with the way."""
    waves = 2 * np.pi / rng.uniform(_SHORTEST, _LONGEST, (_WAVES, 1))
    heights = _SWAY * rng.standard_normal((_WAVES, 1))
    phases = waves * driven + rng.uniform(0, 2 * np.pi, (_WAVES, 1))
    return (heights * np.sin(phases)).sum(axis=0), (heights * waves * np.cos(phases)).sum(axis=0)


def _wrapped(angle: np.ndarray | float) -> np.ndarray:
    return (np.asarray(angle) + np.pi) % (2 * np.pi) - np.pi
