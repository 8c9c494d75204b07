r"""What a robot without calibration knows, and whether that is enough: section 2.2.

The robot drives to a key image by exact sightings; only the scale Z/f that it assumes is wrong, and
what else a variant changes.
"""

from copy import deepcopy
from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Float

from data_synth.ceiling import drive
from robot_perception.ceiling.mosaic import Mosaic
from robot_perception.ceiling.visual_memory import KeyImage, ServoRules, relative_pose, servo
from robot_perception.chapters.ceiling_navigation.world import (
    CENTRE,
    HALF,
    MOUNT,
    NO_SLIP,
    PAPER,
    SCALE,
    looking,
    seen,
)
from robot_perception.evaluation.intervals import Interval, exact
from robot_perception.geometry import wrap_angle
from robot_perception.teaching.claims import Finding
from robot_perception.teaching.studies import Change, Study
from robot_perception.teaching.verdicts import Accepted, Condition

SERVO = ServoRules(gain_distance=1.0, gain_bearing=2.5, gain_heading=-0.8, fastest=0.5)
"""The gains of the chapter, ours; the paper names the law (“visual servoing”) only."""
FACTORS = (0.25, 0.5, 1.0, 1.5)
"""Assumed over true scale."""
DOUBLE, BEYOND = 2.0, 3.0
"""A factor near k_α / k_ρ, and one above it."""
BEHIND, AHEAD = -0.3, 0.3
"""Places of a camera off the axle, m."""
EPSILON = np.deg2rad(2.0)
"""By how much a tilt has changed, rad."""
NEAR, TURNED = 0.05, np.deg2rad(15.0)
"""A robot has arrived if it is that near, m, and turned by less, rad; the library's tolerance, and
the turn that two successive key images may have."""
EVERY = Accepted(1.0, 1.0, "what is sufficient is so from every start")
STOP = 0.001
"""So near to the key image it stops, m, up to scale."""


@dataclass(frozen=True, slots=True)
class Config:
    """Starts, seconds, and what is wrong; all values are ours.

    ``factors`` are assumed over true scales; ``x`` is the place of the camera ahead of the axle, m,
    which the robot does not know; ``tilt`` is a change of its pitch since the key image, rad, and
    ``always`` a pitch that was there before, too.
    """

    starts: int = 20
    seconds: float = 60.0
    step: float = 0.1
    factors: tuple[float, ...] = FACTORS
    x: float = 0.0
    tilt: float = 0.0
    always: float = 0.0


@dataclass(frozen=True, eq=False, slots=True)
class Result:
    """Where robots stand in the end, (drives, 3), and what no sighting determines.

    ``ends`` is for the configuration, all factors; the others for single changes of it. ``unknown``
    counts directions, without the scale and with it.
    """

    ends: Float[np.ndarray, "drives 3"]
    changed: dict[str, Float[np.ndarray, "drives 3"]]
    unknown: tuple[int, int] = (0, 0)


CHANGES = {
    f"a scale {DOUBLE:g} times too large": {"factors": (DOUBLE,)},
    f"a scale {BEYOND:g} times too large": {"factors": (BEYOND,)},
    "camera 30 cm behind the axle": {"x": BEHIND},
    "camera 30 cm ahead of the axle": {"x": AHEAD},
    "tilt of 2° from the beginning": {"always": EPSILON},
    "tilt of 2° since the path was learned": {"tilt": EPSILON},
}
"""What is changed one at a time, with the true scale where the change is not in the scale."""
DOUBLED, TOO_LARGE, IS_BEHIND, IS_AHEAD, ALWAYS, SINCE = CHANGES
PATTERNS = {
    str(k): np.array(pose)
    for k, pose in enumerate([(0.8, 0.5, 0.3), (-0.6, 0.7, -1.0), (0.2, -0.9, 2.0)])
}
"""Three patterns above the place of the key image."""


def approach(
    start: Float[np.ndarray, "3"], factor: float, config: Config, rules: ServoRules = SERVO
) -> Float[np.ndarray, "steps 3"]:
    """Return the path of a robot that drives to the key image at the origin."""
    then = looking(pitch=config.always, x=config.x)
    now = looking(pitch=config.always + config.tilt, x=config.x)
    key, rng = KeyImage(seen(then, np.zeros(3), PATTERNS)), np.random.default_rng(0)
    poses = [start]
    for _ in range(round(config.seconds / config.step)):
        target = relative_pose(
            seen(now, poses[-1], PATTERNS), key, centre=np.array(CENTRE), scale=factor * SCALE
        )
        if np.hypot(*target[:2]) <= STOP * factor:
            break
        poses.append(drive(poses[-1], *servo(target, rules), config.step, NO_SLIP, rng=rng))
    return np.array(poses)


def arrived(ends: Float[np.ndarray, "drives 3"]) -> float:
    """Return the share of robots that stand near the key image and look as it does."""
    near = np.hypot(ends[:, 0], ends[:, 1]) <= NEAR
    return float(np.mean(near & (np.abs(wrap_angle(ends[:, 2])) <= TURNED)))


def starts(number: int, rng: np.random.Generator) -> Float[np.ndarray, "number 3"]:
    """Return places from which the robot starts: one to two metres before the key image."""
    aside = rng.uniform(-0.3, 0.3, (number, 2))
    return np.column_stack([rng.uniform(-2, -1, number), aside])


def alone(config: Config, *, rng: np.random.Generator) -> Result:
    """Drive with all factors of a configuration, from the same starts."""
    begin = starts(config.starts, rng)
    ends = [approach(s, factor, config)[-1] for factor in config.factors for s in begin]
    return Result(np.array(ends), {})


def run(config: Config, *, rng: np.random.Generator) -> Result:
    """Let robots drive to a key image, with one thing changed at a time."""
    changed = {
        name: alone(replace(config, **{"factors": (1.0,), **change}), rng=deepcopy(rng)).ends
        for name, change in CHANGES.items()
    }
    known = (unknown(known=False), unknown(known=True))
    return Result(alone(config, rng=rng).ends, changed, known)


def unknown(*, known: bool, poses: int = 6, patterns: int = 4) -> int:
    """Return how many directions of map, path and scale change no sighting, to first order.

    The first pattern is the frame. Z/f is one of the unknowns, or known. The rank of the
    derivatives of all sightings, by central differences.
    """
    rng = np.random.default_rng(7)
    spread = [*(HALF / 2), 1.0]
    there, path = rng.uniform(-1, 1, (patterns, 3)), rng.uniform(-1, 1, (poses, 3))
    there, path = there * spread, path * spread
    there[0] = 0.0

    def sightings(x: np.ndarray) -> np.ndarray:
        around, way = x[: 3 * patterns - 3].reshape(-1, 3), x[3 * patterns - 3 : -1].reshape(-1, 3)
        at = {str(k): pose for k, pose in enumerate([there[0], *around])}
        mosaic = Mosaic(at, float(np.exp(x[-1])) * SCALE, np.array(CENTRE))
        return np.array([mosaic.expected(way, name)[:, :3] for name in at]).ravel()

    x = np.concatenate([there[1:].ravel(), path.ravel(), [0.0]])
    steps = 1e-6 * np.eye(len(x))
    J = np.array([(sightings(x + d) - sightings(x - d)) / 2e-6 for d in steps]).T
    J = J[:, :-1] if known else J
    J = J / np.linalg.norm(J, axis=0)
    return J.shape[1] - int((np.linalg.svd(J, compute_uv=False) > 1e-6).sum())


def share(found: Result) -> Interval:
    """Return the share of the drives of the configuration that arrive."""
    return exact(arrived(found.ends), about="share of the drives")


upto_scale = Study(run, full=Config(), quick=Config(starts=3), seed=74)


@upto_scale.claim(
    "pose-up-to-scale",
    paper=PAPER,
    place="§2.2, text to eq. 2",
    basis="mathematics",
    statement="Without calibration the pose is known up to the scale Z/f, and that is enough to "
    "drive to a key image by visual servoing.",
    paper_value="“sufficient to achieve navigation using visual servoing”",
    method="A unicycle drives to a key image by exact sightings, from places one to two metres "
    "before it, with an assumed scale from a quarter to one and a half times the true one: share "
    "of the drives that end within 5 cm and 15° of it.",
    accepted=EVERY,
    value=share,
    sabotage=[
        Change(f"a scale assumed {BEYOND:g} times too large", alone, factors=(BEYOND,)),
        Change("a camera 30 cm behind the axle", alone, factors=(1.0,), x=BEHIND),
        Change("a camera tilted by 2° since the path was learned", alone, tilt=EPSILON),
    ],
)
def enough(found: Result, value: Interval) -> Finding:
    """Drive with wrong scales; then with what a wrong scale does not cover."""
    shares = {n: exact(arrived(e), about="share that arrives") for n, e in found.changed.items()}
    moved = np.hypot(*found.changed[SINCE][:, :2].T)
    return Finding(
        value,
        {
            "directions of map, path and scale that no sighting shows": exact(found.unknown[0]),
            "the same where the scale is known": exact(found.unknown[1]),
            "k_α / k_ρ": exact(SERVO.largest_scale),
            **shares,
            "a changed tilt moves the end by": exact(float(np.median(moved)), "m", "median"),
            "Z tan 2°": exact(MOUNT.height * float(np.tan(EPSILON)), "m"),
        },
        conditions=(
            Condition.judged(
                "the assumed scale is well below k_α / k_ρ times the true one",
                EVERY,
                outside=shares[TOO_LARGE],
            ),
            Condition.judged(
                "the camera is not behind the axle, or its place is corrected for",
                EVERY,
                outside=shares[IS_BEHIND],
            ),
            Condition.judged(
                "the camera is tilted as it was when the path was learned",
                EVERY,
                outside=shares[SINCE],
            ),
        ),
        note="The speed is proportional to the scale, and directions do not depend on it: a wrong "
        "scale is a wrong gain. Too large a gain still leads to the place, but turned away.",
    )


def heading_exponent(rules: ServoRules = SERVO) -> float:
    """Return the power of the distance with which heading errors fall near the key image."""
    lean = rules.gain_bearing - rules.gain_distance
    root = np.roots([1.0, lean, -rules.gain_distance * rules.gain_heading]).real.max()
    return float(-root / rules.gain_distance)
