"""What one anchor leaves unseen: ranks of five sets of sensors, and worlds really moved.

The ranks are those of three analyses; the worlds are moved along the directions in question, with
all measurements taken again. The paper is Andrade-Cetto, "Perception Issues in Mobile Robotics",
section 2.2, eqs (24) to (27).
"""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from types import MappingProxyType

import numpy as np
from jaxtyping import Float

from robot_perception.chapters.anchored_slam import invented
from robot_perception.chapters.monobot.rail import PAPER
from robot_perception.evaluation.intervals import Interval, exact, proportion, spread
from robot_perception.slam.observability import (
    Anchor,
    Heading,
    Landmarks,
    Position,
    Sensor,
    rotate,
    see,
    symbolic,
    translate,
)
from robot_perception.slam.observability.symbolic import ANCHORS, Reading, pose
from robot_perception.teaching.claims import Finding, Size, claim
from robot_perception.teaching.explore import choice
from robot_perception.teaching.tables import Table
from robot_perception.teaching.verdicts import Accepted, Condition

# Ranks -------------------------------------------------------------------------------------------

SETS = ("plain", "one anchor", "two anchors", "anchor + compass", "position sensor")
READINGS = ("one point", "true path", "nonlinear")
"""The three analyses: Jacobians at one point; at the true states; Lie derivatives."""


def sensors(name: str, anchors: tuple[Anchor, Anchor] = ANCHORS) -> tuple[Sensor, ...]:
    """Return a set of sensors by name.

    Raises
    ------
    ValueError
        If there is no set of that name.
    """
    first, second = anchors
    table = {
        "plain": (Landmarks(),),
        "one anchor": (Landmarks(), first),
        "two anchors": (Landmarks(), first, second),
        "anchor + compass": (Landmarks(), first, Heading()),
        "position sensor": (Landmarks(), Position()),
    }
    if name not in table:
        raise ValueError(f"no set of sensors {name!r}; there are {', '.join(table)}")
    return table[name]


@cache
def ranks(*, moving: bool) -> Mapping[tuple[str, str], Reading]:
    """Return what each analysis says about each set of sensors, in exact arithmetic.

    There is one landmark; the robot drives, or only turns on the spot.
    """
    table = {}
    start, turned = pose(0), pose(1)
    motion = {} if moving else {"displacement": (0, 0)}
    drive = {} if moving else {"poses": (start, (*start[:2], turned[2]))}
    speed = {} if moving else {"speed": 0}
    for name in SETS:
        used = sensors(name)
        matrices = (
            symbolic.fixed_point_matrix(used, 1, **motion),
            symbolic.trajectory_matrix(used, 1, **drive),
            symbolic.lie_matrix(used, 1, **speed),
        )
        for reading, matrix in zip(READINGS, matrices, strict=True):
            table[name, reading] = symbolic.read(matrix, used)
    return MappingProxyType(table)


def rank_table(*, moving: bool = True) -> Table:
    """Return the ranks as a table, with what the analysis along the true path misses."""
    found = ranks(moving=moving)
    rows = {
        name: (
            *(found[name, reading].rank for reading in READINGS),
            ", ".join(found[name, "true path"].unseen) or "nothing",
        )
        for name in SETS
    }
    columns = {
        "one point": "Jacobians at one point",
        "true path": "Jacobians at the true states",
        "nonlinear": "Lie derivatives",
        "unseen": "along the true path",
    }
    return Table(rows, columns, corner=f"rank of {found[SETS[0], READINGS[0]].dimension}")


# Worlds really moved -----------------------------------------------------------------------------

AT_REST = "position sensor, robot at rest"
TURN = "turn about the anchor"
DIRECTIONS = ("shift in x", "shift in y", TURN, "turn about the robot")
TURN_STEP = np.deg2rad(15.0)
"""One unit of an amount: 1 m of a shift, 15° of a turn."""
PLACES = (Anchor(0.0, 0.0), Anchor(5.0, 0.5))
PATH = np.array([[1.0, 2.2, -0.2], [2.3, 2.0, 0.1], [3.6, 2.3, 0.4], [4.6, 3.1, 0.9]])
LANDMARKS = np.array([[0.4, 4.0], [2.6, 3.9], [5.8, 2.4], [3.4, 0.4]])


@dataclass(frozen=True, eq=False, slots=True)
class MovedWorld:
    """A world before and after it was moved, in m and rad, and what the sensors notice.

    The misses are where the measurements from each moved pose ask the anchors, which cannot move,
    to be; the fixes are where a position sensor saw the robot. Metres and radians are the largest
    change of all measurements of lengths and of all of the heading.
    """

    poses: Float[np.ndarray, "k 3"]
    landmarks: Float[np.ndarray, "n 2"]
    moved_poses: Float[np.ndarray, "k 3"]
    moved_landmarks: Float[np.ndarray, "n 2"]
    anchors: Float[np.ndarray, "a 2"]
    misses: Float[np.ndarray, "k a 2"]
    fixes: Float[np.ndarray, "f 2"]
    metres: float
    radians: float


def move_world(sensing: str, direction: str, amount: float) -> MovedWorld:
    """Move a small world along a direction, by m or steps of 15°, and take all measurements again.

    About the robot means where it is first.

    Raises
    ------
    ValueError
        If there is no such set or direction.
    """
    used = sensors(sensing.removesuffix(", robot at rest"), PLACES)
    poses = PATH[:1] if sensing == AT_REST else PATH
    states = np.hstack([poses, np.tile(LANDMARKS.ravel(), (len(poses), 1))])
    moved = np.array([_move(state, direction, amount) for state in states])
    metres = radians = 0.0
    for sensor in used:
        before, after = (np.array([see([sensor], s)[0] for s in many]) for many in (states, moved))
        change = after - before
        if isinstance(sensor, Heading):
            radians = max(radians, float(np.abs(change).max()))
        else:
            metres = max(metres, float(np.hypot(change[:, ::2], change[:, 1::2]).max()))
    anchors = np.array([[s.x, s.y] for s in used if isinstance(s, Anchor)]).reshape(-1, 2)
    asked = np.hstack([poses, np.tile(anchors.ravel(), (len(poses), 1))])
    asked = np.array([_move(state, direction, amount)[3:] for state in asked])
    watched = any(isinstance(sensor, Position) for sensor in used)
    return MovedWorld(
        poses=poses,
        landmarks=LANDMARKS,
        moved_poses=moved[:, :3],
        moved_landmarks=moved[0, 3:].reshape(-1, 2),
        anchors=anchors,
        misses=asked.reshape(len(poses), -1, 2),
        fixes=poses[:, :2] if watched else np.empty((0, 2)),
        metres=metres,
        radians=radians,
    )


def _move(state: np.ndarray, direction: str, amount: float) -> np.ndarray:
    """Move robot and all points together."""
    match direction:
        case "shift in x":
            return translate(state, np.array([amount, 0.0]))
        case "shift in y":
            return translate(state, np.array([0.0, amount]))
        case "turn about the anchor":
            return rotate(state, amount * TURN_STEP, np.array([PLACES[0].x, PLACES[0].y]))
        case "turn about the robot":
            return rotate(state, amount * TURN_STEP, PATH[0, :2])
    raise ValueError(f"no direction {direction!r}; there are {', '.join(DIRECTIONS)}")


def describe(sensing: str, direction: str, amount: float) -> str:
    """Return the words for a reader who does not see the moved world."""
    world = move_world(sensing, direction, amount)
    by = f"{15 * amount:g}°" if direction.startswith("turn") else f"{amount:g} m"
    heading = f", heading {np.degrees(world.radians):.0f}°" if world.radians > 0 else ""
    return (
        f"Robot and landmarks, grey, and again in blue after a {direction} by {by}. Sensors: "
        f"{sensing}. The largest residual is {world.metres:.2f} m{heading}."
    )


CONTROLS = {
    "sensing": choice("Sensors", (*SETS, AT_REST), "one anchor"),
    "direction": choice("Move the world", DIRECTIONS, "shift in x"),
    "amount": choice(
        "By", {f"{m} m, or {15 * m}°".replace("-", "−"): m for m in (-2, -1, 1, 2)}, 1
    ),
}
"""Controls of the gauge explorer; their names are those of :func:`move_world`."""
PRESETS = {
    "one anchor, turned about it": {"direction": TURN},
    "two anchors": {"sensing": "two anchors", "direction": TURN},
    "anchor and compass": {"sensing": "anchor + compass", "direction": TURN},
    "position sensor": {"sensing": "position sensor", "direction": "turn about the robot"},
    "robot at rest": {"sensing": AT_REST, "direction": "turn about the robot"},
}


# The claims --------------------------------------------------------------------------------------

RUNS = {Size.QUICK: 10, Size.FULL: 50}


def _unseen(name: str, *, moving: bool = True) -> Interval:
    """Return how many directions a set of sensors leaves unseen, by the worst of the analyses."""
    found = ranks(moving=moving)
    worst = max(found[name, reading].dimension - found[name, reading].rank for reading in READINGS)
    return exact(worst, "unseen direction" if worst == 1 else "unseen directions")


@claim(
    "planar-anchor",
    paper=PAPER,
    place="§2.2, eqs 24–27",
    basis="mathematics",
    statement="For the planar vehicle one two-dimensional anchor is enough for full observability.",
    paper_value="full rank",
    method="States minus rank with one anchor, in exact arithmetic, while the robot drives: the "
    "worst of three analyses (Jacobians at one point, along the true path, Lie derivatives).",
    accepted=Accepted(0, 0, "full observability leaves no direction unseen"),
    seed=21,
)
def planar_anchor(size: Size, rng: np.random.Generator) -> Finding:
    """Count the directions that one anchor leaves unseen, and ask filters what they claim."""
    found = ranks(moving=True)
    study = invented.run(invented.Config(runs=RUNS[size]), rng=rng)
    rows = {}
    for kind, result in study.items():
        inside = (np.abs(result.errors) < 2 * result.deviations)[:, -1]
        rows[kind] = (spread(result.gains[:, -1]), proportion(int(inside.sum()), RUNS[size]))
    columns = {
        "information": "about the turn, end over start: median and central 95 %",
        "within 2σ": "rate of runs whose heading is within its stated 2σ at the end, 95 %",
    }
    one = found["one anchor", "one point"]
    return Finding(
        _unseen("one anchor"),
        {
            f"directions unseen, {name}": _unseen(name)
            for name in ("plain", "two anchors", "anchor + compass")
        },
        {
            "ranks": rank_table(),
            "claimed": Table(rows, columns, f"over {RUNS[size]} runs", "filter"),
        },
        note=f"With one anchor the analysis at one point finds rank {one.rank} of "
        f"{one.dimension}, those along the true path and without linearisation find "
        f"{found['one anchor', 'true path'].rank}: the turn of the world about the anchor stays "
        f"unseen. A plain filter believes the first: in "
        f"{study['plain'].invented.sum()} of {RUNS[size]} runs it claims information about "
        f"the turn that no sensor sent; at consistent points, in "
        f"{study['first estimates'].invented.sum()}.",
    )


@planar_anchor.sabotage("a second anchor")
def second_anchor(size: Size, rng: np.random.Generator) -> Finding:
    """Count what two anchors leave unseen."""
    return Finding(_unseen("two anchors"))


@planar_anchor.sabotage("a compass beside the anchor")
def anchor_and_compass(size: Size, rng: np.random.Generator) -> Finding:
    """Count what an anchor and a compass leave unseen."""
    return Finding(_unseen("anchor + compass"))


@claim(
    "planar-position-sensor",
    paper=PAPER,
    place="§2.2, eqs 26–27",
    basis="mathematics",
    statement="For the planar vehicle a sensor of its position xy is enough for full "
    "observability.",
    paper_value="full rank",
    method="As for one anchor, with a sensor of the position, while the robot drives; and while it "
    "only turns on the spot.",
    accepted=Accepted(0, 0, "full observability leaves no direction unseen"),
)
def planar_position_sensor(size: Size, rng: np.random.Generator) -> Finding:
    """Count the directions that a sensor of the position leaves unseen, driving and at rest."""
    at_rest = _unseen("position sensor", moving=False)
    return Finding(
        _unseen("position sensor"),
        {"directions unseen, on the spot": at_rest},
        {"ranks, on the spot": rank_table(moving=False)},
        (
            Condition(
                "the robot translates: on the spot the turn of the world about the robot stays "
                "unseen",
                needed=at_rest.low > 0,
            ),
        ),
        note="The heading is seen only by the way that the position takes.",
    )


@planar_position_sensor.sabotage("a robot that only turns on the spot")
def on_the_spot(size: Size, rng: np.random.Generator) -> Finding:
    """Count what the sensor of the position leaves unseen if the robot does not translate."""
    return Finding(_unseen("position sensor", moving=False))


@planar_position_sensor.sabotage("no sensor but that of the landmarks")
def landmarks_alone(size: Size, rng: np.random.Generator) -> Finding:
    """Count what the landmarks alone leave unseen."""
    return Finding(_unseen("plain"))
