"""What one anchor leaves unseen: ranks of five sets of sensors, and worlds really moved.

The ranks are those of three analyses; the worlds are moved along the directions in question, with
all measurements taken again. The paper is Andrade-Cetto, "Perception Issues in Mobile Robotics",
section 2.2, eqs (24) to (27).
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from operator import attrgetter

import numpy as np
from jaxtyping import Float

from robot_perception.chapters.anchored_slam import invented
from robot_perception.chapters.monobot.rail import PAPER
from robot_perception.evaluation.intervals import Interval, exact, proportion, spread
from robot_perception.slam import observability
from robot_perception.slam.observability import Anchor, Heading, Landmarks, Position, StateSensor
from robot_perception.slam.observability.symbolic import ANCHORS, Reading, pose
from robot_perception.teaching.claims import Finding
from robot_perception.teaching.results import kept
from robot_perception.teaching.studies import Change, Study
from robot_perception.teaching.tables import Table
from robot_perception.teaching.verdicts import Accepted, Condition

# Ranks -------------------------------------------------------------------------------------------

SETS = ("plain", "one anchor", "two anchors", "anchor + compass", "position sensor")
RESTING = ", robot at rest"
AT_REST = f"position sensor{RESTING}"
READINGS = ("one point", "true path", "nonlinear")
"""The three analyses: Jacobians at one point; at the true states; Lie derivatives."""


def sensors(name: str, anchors: tuple[Anchor, Anchor] = ANCHORS) -> tuple[StateSensor, ...]:
    """Return a set of sensors by name."""
    first, second = anchors
    return {
        "plain": (Landmarks(),),
        "one anchor": (Landmarks(), first),
        "two anchors": (Landmarks(), first, second),
        "anchor + compass": (Landmarks(), first, Heading()),
        "position sensor": (Landmarks(), Position()),
    }[name]


@kept
def ranks(*, moving: bool) -> dict[tuple[str, str], Reading]:
    """Return what each analysis says of a set of sensors and one landmark, driving or at rest."""
    table = {}
    start, turned = pose(0), pose(1)
    motion = {} if moving else {"displacement": (0, 0)}
    drive = {} if moving else {"poses": (start, (*start[:2], turned[2]))}
    speed = {} if moving else {"speed": 0}
    for name in SETS:
        used = sensors(name)
        matrices = (
            observability.symbolic.fixed_point_matrix(used, 1, **motion),
            observability.symbolic.trajectory_matrix(used, 1, **drive),
            observability.symbolic.lie_matrix(used, 1, **speed),
        )
        for reading, matrix in zip(READINGS, matrices, strict=True):
            table[name, reading] = observability.symbolic.read(matrix, used)
    return table


def rank_table(*, moving: bool = True) -> Table:
    """Return the ranks as a table, with what the analysis along the true path misses."""
    found = ranks(moving=moving)
    said = {name: ", ".join(found[name, "true path"].unseen) or "nothing" for name in SETS}
    rows = {name: (*(found[name, r].rank for r in READINGS), said[name]) for name in SETS}
    columns = {
        "one point": "Jacobians at one point",
        "true path": "Jacobians at the true states",
        "nonlinear": "Lie derivatives",
        "unseen": "along the true path",
    }
    return Table(rows, columns, corner=f"rank of {found[SETS[0], READINGS[0]].dimension}")


def unseen(sensing: str, readings: Sequence[str] = READINGS) -> Interval:
    """Return how many directions a set of sensors leaves unseen, by the worst of some analyses."""
    name = sensing.removesuffix(RESTING)
    found = ranks(moving=name == sensing)
    worst = max(found[name, reading].dimension - found[name, reading].rank for reading in readings)
    return exact(worst, "unseen direction" if worst == 1 else "unseen directions")


# Worlds really moved -----------------------------------------------------------------------------

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

    sensing: str
    direction: str
    amount: float
    poses: Float[np.ndarray, "k 3"]
    landmarks: Float[np.ndarray, "n 2"]
    moved_poses: Float[np.ndarray, "k 3"]
    moved_landmarks: Float[np.ndarray, "n 2"]
    anchors: Float[np.ndarray, "a 2"]
    misses: Float[np.ndarray, "k a 2"]
    fixes: Float[np.ndarray, "f 2"]
    metres: float
    radians: float

    @property
    def residual(self) -> float:
        """The larger of both changes."""
        return max(self.metres, self.radians)


def move_world(sensing: str, direction: str, amount: float) -> MovedWorld:
    """Move a small world along a direction, by m or steps of 15°, and take all measurements again.

    About the robot means where it is first.
    """
    used = sensors(sensing.removesuffix(RESTING), PLACES)
    poses = PATH[:1] if sensing == AT_REST else PATH
    anchors = np.array([[s.x, s.y] for s in used if isinstance(s, Anchor)]).reshape(-1, 2)
    points, own = np.vstack([LANDMARKS, anchors]), 3 + LANDMARKS.size
    states = np.hstack([poses, np.tile(points.ravel(), (len(poses), 1))])
    moved = np.array([_move(state, direction, amount) for state in states])
    metres = radians = 0.0
    for sensor in used:
        before, after = (
            np.array([observability.see([sensor], state[:own])[0] for state in many])
            for many in (states, moved)
        )
        change = after - before
        if isinstance(sensor, Heading):
            radians = float(np.abs(change).max())
        else:
            metres = max(metres, float(np.hypot(change[:, ::2], change[:, 1::2]).max()))
    watched = any(isinstance(sensor, Position) for sensor in used)
    return MovedWorld(
        *(sensing, direction, amount),
        poses=poses,
        landmarks=LANDMARKS,
        moved_poses=moved[:, :3],
        moved_landmarks=moved[0, 3:own].reshape(-1, 2),
        anchors=anchors,
        misses=moved[:, own:].reshape(len(poses), -1, 2),
        fixes=poses[:, :2] if watched else np.empty((0, 2)),
        metres=metres,
        radians=radians,
    )


def _move(state: np.ndarray, direction: str, amount: float) -> np.ndarray:
    """Move robot and all points together."""
    if direction.startswith("shift"):
        return observability.translate(state, amount * np.eye(2)["xy".index(direction[-1])])
    about = np.array([PLACES[0].x, PLACES[0].y]) if direction == TURN else PATH[0, :2]
    return observability.rotate(state, amount * TURN_STEP, about)


# The claims --------------------------------------------------------------------------------------


@dataclass(frozen=True, slots=True)
class Config:
    """A set of sensors, the analyses that are asked what it leaves unseen, and runs.

    In so many runs filters with one anchor are asked what they claim.
    """

    sensing: str
    runs: int = 0
    readings: tuple[str, ...] = READINGS


@dataclass(frozen=True, eq=False, slots=True)
class Observed:
    """How many directions the sensors leave unseen, and what filters make of one anchor."""

    unseen: Interval
    filters: Mapping[str, invented.Result]


def observe(config: Config, *, rng: np.random.Generator) -> Observed:
    """Count what is unseen, and ask the filters."""
    circles = invented.Config(runs=config.runs)
    filters = invented.run(circles, rng=rng) if config.runs else {}
    return Observed(unseen(config.sensing, config.readings), filters)


ONE_ANCHOR = Study(
    observe, full=Config("one anchor", 50), quick=Config("one anchor", 10), seed=invented.SEED
)
POSITION = Study(observe, full=Config("position sensor"), quick=Config("position sensor"))
PRINTED = Config("one anchor", readings=READINGS[:1])
MATRIX = Study(observe, full=PRINTED, quick=PRINTED)
FULL = Accepted(0, 0, "full observability leaves no direction unseen")


@MATRIX.claim(
    "planar-anchor-matrix",
    paper=PAPER,
    place="§2.2, eq. 25 and the text after eq. 27",
    basis="mathematics",
    statement="With one two-dimensional anchor the observability matrix of the planar vehicle, all "
    "its Jacobians taken at one point, has full rank.",
    paper_value="full rank",
    method="States minus rank of the matrix of eqs 24 and 25 with one landmark, Jacobians at one "
    "point, in exact arithmetic, while the robot drives; and while it only turns on the spot.",
    accepted=Accepted(0, 0, "full rank means that no direction is missing"),
    sabotage=(
        Change("each Jacobian at the place where the robot is by then", readings=READINGS[1:2]),
        Change("no anchor", sensing="plain"),
    ),
)
def planar_anchor_matrix(observed: Observed) -> Finding:
    """Count what the printed matrix misses with one anchor, driving and at rest."""
    at_rest = unseen(f"one anchor{RESTING}", PRINTED.readings)
    return Finding(
        observed.unseen,
        {
            "missing ranks, on the spot": at_rest,
            "missing ranks, driving, without an anchor": unseen("plain", PRINTED.readings),
        },
        conditions=(
            Condition.judged(
                "the robot translates: the rank is full exactly if it does, and on the spot one "
                "direction is missing",
                FULL,
                outside=at_rest,
            ),
        ),
        note="The algebra is right. What full rank at one point says of the vehicle is another "
        "claim, planar-anchor.",
    )


@ONE_ANCHOR.claim(
    "planar-anchor",
    paper=PAPER,
    place="§2.2, eqs 24–27",
    basis="mathematics",
    statement="For the planar vehicle one two-dimensional anchor is enough for full observability.",
    paper_value="full rank",
    method="States minus rank with one anchor, in exact arithmetic, while the robot drives: the "
    "worst of three analyses (Jacobians at one point, along the true path, Lie derivatives).",
    accepted=FULL,
    sabotage=(
        Change("a second anchor", config=Config("two anchors")),
        Change("a compass beside the anchor", config=Config("anchor + compass")),
    ),
    value=attrgetter("unseen"),
)
def planar_anchor(observed: Observed, value: Interval) -> Finding:
    """Count the directions that one anchor leaves unseen, and say what filters claim."""
    found, filters, rows = ranks(moving=True), observed.filters, {}
    runs = len(filters["plain"].gains)
    for kind, result in filters.items():
        inside = (np.abs(result.errors) < 2 * result.deviations)[:, -1]
        rows[kind] = (spread(result.gains[:, -1]), proportion(int(inside.sum()), runs))
    columns = {
        "information": "about the turn, end over start: median and central 95 %",
        "within 2σ": "rate of runs whose heading is within its stated 2σ at the end, 95 %",
    }
    one = found["one anchor", "one point"]
    return Finding(
        value,
        {
            f"directions unseen, {name}": unseen(name)
            for name in ("plain", "two anchors", "anchor + compass")
        },
        {"ranks": rank_table(), "claimed": Table(rows, columns, f"over {runs} runs", "filter")},
        note=f"With one anchor the analysis at one point finds rank {one.rank} of "
        f"{one.dimension}, those along the true path and without linearisation find "
        f"{found['one anchor', 'true path'].rank}: the turn of the world about the anchor stays "
        f"unseen. A plain filter believes the first: in {filters['plain'].invented.sum()} of "
        f"{runs} runs it claims information about the turn that no sensor sent; at consistent "
        f"points, in {filters['first estimates'].invented.sum()}.",
    )


@POSITION.claim(
    "planar-position-sensor",
    paper=PAPER,
    place="§2.2, eqs 26–27",
    basis="mathematics",
    statement="For the planar vehicle a sensor of its position xy is enough for full "
    "observability.",
    paper_value="full rank",
    method="As for one anchor, with a sensor of the position, while the robot drives; and while it "
    "only turns on the spot.",
    accepted=FULL,
    sabotage=(
        Change("a robot that only turns on the spot", sensing=AT_REST),
        Change("no sensor but that of the landmarks", sensing="plain"),
    ),
)
def planar_position_sensor(observed: Observed) -> Finding:
    """Count the directions that a sensor of the position leaves unseen, driving and at rest."""
    at_rest = unseen(AT_REST)
    return Finding(
        observed.unseen,
        {"directions unseen, on the spot": at_rest},
        {"ranks, on the spot": rank_table(moving=False)},
        (
            Condition.judged(
                "the robot translates: on the spot the turn of the world about the robot stays "
                "unseen",
                FULL,
                outside=at_rest,
            ),
        ),
        note="The heading is seen only by the way that the position takes.",
    )
