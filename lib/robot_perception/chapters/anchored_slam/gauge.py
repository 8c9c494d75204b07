"""What one anchor leaves unseen, and what a filter makes of it.

Three studies: the ranks of five sets of sensors under three analyses; worlds moved along the
directions in question, with all measurements taken again; and the information that a filter with
one anchor claims about the one direction it cannot see. The paper is Andrade-Cetto, "Perception
Issues in Mobile Robotics", section 2.2, eqs (24) to (27).
"""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache, partial
from types import MappingProxyType
from typing import Literal

import numpy as np
from jaxtyping import Bool, Float

from data_synth.posts import glimpse
from data_synth.wheels import SMALL, Slip, roll
from robot_perception.chapters.monobot import PAPER
from robot_perception.geometry import wrap_angle
from robot_perception.slam.observability import (
    Anchor,
    Heading,
    Landmarks,
    Position,
    Sensor,
    gauge_directions,
    information_along,
    rotate,
    see,
    translate,
)
from robot_perception.slam.observability.symbolic import (
    ANCHORS,
    Reading,
    fixed_point_matrix,
    lie_matrix,
    pose,
    read,
    trajectory_matrix,
)
from robot_perception.slam.planar import (
    CartesianSensor,
    History,
    MapBelief,
    Observations,
    Odometry,
    Settings,
    Step,
    Truth,
    run_filter,
)
from robot_perception.teaching.claims import Accepted, Claim, Condition, Finding, Interval, Size
from robot_perception.teaching.exercises import Exercise
from robot_perception.teaching.explore import choice, slider

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


def ranks(landmarks: int = 1, *, moving: bool = True) -> Mapping[tuple[str, str], Reading]:
    """Return what each analysis says about each set of sensors, in exact arithmetic.

    Parameters
    ----------
    landmarks
        Number of landmarks in the state.
    moving
        Whether the robot drives, or only turns on the spot.

    Returns
    -------
    mapping
        (set, analysis) -> :class:`Reading`.
    """
    return _ranks(landmarks, moving)


@cache
def _ranks(landmarks: int, moving: bool) -> Mapping[tuple[str, str], Reading]:
    table = {}
    start, turned = pose(0), pose(1)
    motion = {} if moving else {"displacement": (0, 0)}
    drive = {} if moving else {"poses": (start, (*start[:2], turned[2]))}
    speed = {} if moving else {"speed": 0}
    for name in SETS:
        used = sensors(name)
        matrices = (
            fixed_point_matrix(used, landmarks, **motion),
            trajectory_matrix(used, landmarks, **drive),
            lie_matrix(used, landmarks, **speed),
        )
        for reading, matrix in zip(READINGS, matrices, strict=True):
            table[name, reading] = read(matrix, used)
    return MappingProxyType(table)


def rank_table(landmarks: int = 1, *, moving: bool = True) -> str:
    """Return the ranks as a table of text, and what the analysis along the true path misses."""
    table = ranks(landmarks, moving=moving)
    size = table[SETS[0], READINGS[0]].dimension
    lines = [f"{f'rank of {size}':17s}" + "".join(f"{r:>11s}" for r in READINGS) + "  unseen"]
    for name in SETS:
        numbers = "".join(f"{table[name, reading].rank:11d}" for reading in READINGS)
        unseen = ", ".join(table[name, "true path"].unseen) or "nothing"
        lines.append(f"{name:17s}{numbers}  {unseen}")
    return "\n".join(lines)


# Worlds really moved -----------------------------------------------------------------------------

AT_REST = "position sensor, robot at rest"
DIRECTIONS = ("shift in x", "shift in y", "turn about the anchor", "turn about the robot")
TURN_STEP = np.deg2rad(15.0)
"""One unit of the slider: 1 m of a shift, 15° of a turn."""
PLACES = (Anchor(0.0, 0.0), Anchor(5.0, 0.5))
PATH = np.array([[1.0, 2.2, -0.2], [2.3, 2.0, 0.1], [3.6, 2.3, 0.4], [4.6, 3.1, 0.9]])
LANDMARKS = np.array([[0.4, 4.0], [2.6, 3.9], [5.8, 2.4], [3.4, 0.4]])


@dataclass(frozen=True, eq=False, slots=True)
class MovedWorld:
    """A world before and after it was moved, and what the sensors notice.

    Parameters
    ----------
    poses, moved_poses : (k, 3)
        Of the robot, m, m, rad.
    landmarks, moved_landmarks : (n, 2)
        m.
    anchors, misses : (a, 2) and (k, a, 2)
        Places of the anchors, which cannot move, and where the measurements from each moved pose
        ask them to be, m.
    fixes : (k or 0, 2)
        Where the position sensor saw the robot, m.
    metres, radians
        Largest change of all measurements of lengths and of all of the heading.
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
    """Move a small world along a direction and take all measurements again.

    Parameters
    ----------
    sensing
        One of :data:`SETS`, or :data:`AT_REST`.
    direction
        One of :data:`DIRECTIONS`; about the robot means where it is first.
    amount
        m of a shift, steps of 15° of a turn.

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
    heading = f" and {np.degrees(world.radians):.0f}° of heading" if world.radians > 0 else ""
    return (
        f"Robot and landmarks, grey, and again in blue after a {direction} by {by}. Sensors: "
        f"{sensing}. The largest residual is {world.metres:.2f} m{heading}."
    )


CONTROLS = {
    "sensing": choice("Sensors", (*SETS, AT_REST), "one anchor"),
    "direction": choice("Move the world", DIRECTIONS, "turn about the anchor"),
    "amount": slider("By", (-2, -1, 0, 1, 2), 1, "m, or × 15°"),
}
"""Controls of the gauge explorer; their names are those of :func:`move_world`."""
PRESETS = {
    "one anchor, turned about it": {},
    "one anchor, shifted": {"direction": "shift in x"},
    "two anchors": {"sensing": "two anchors"},
    "position sensor": {"sensing": "position sensor"},
    "robot at rest": {"sensing": AT_REST, "direction": "turn about the robot"},
}


# Information that nobody sent --------------------------------------------------------------------

Filter = Literal["standard", "first estimates", "ideal"]
FILTERS: tuple[Filter, ...] = ("standard", "first estimates", "ideal")
ANCHOR = 0


@dataclass(frozen=True, slots=True)
class Config:
    """A robot that circles among posts, one or more of which stand at known places; all ours.

    Parameters
    ----------
    runs, steps
        Independent runs, and moves in each.
    rounds, radius
        How often it circles, and how far from the middle, m.
    posts
        Posts at unknown places.
    anchors
        Posts at known places, 1 or 2.
    start_deviation, heading_deviation
        Of the start: each coordinate, m, and the heading, rad.
    look_deviation
        Of each coordinate of a post in the frame of the robot, m.
    reach
        Posts ahead and no farther away are seen, m.
    slip
        Errors of the wheels.
    """

    runs: int = 50
    steps: int = 150
    rounds: float = 2.0
    radius: float = 4.0
    posts: int = 10
    anchors: int = 1
    start_deviation: float = 0.5
    heading_deviation: float = np.deg2rad(10.0)
    look_deviation: float = 0.05
    reach: float = 6.0
    slip: Slip = SMALL


@dataclass(frozen=True, eq=False, slots=True)
class Drive:
    """One run: what was so, what was seen, and what the robot believed at the start.

    Parameters
    ----------
    path : (steps + 1, 3)
        True poses, m, m, rad.
    places : (posts, 2)
        True places, m; the anchors first.
    steps
        What the filter gets.
    start
        Belief in the first pose.
    """

    path: Float[np.ndarray, "poses 3"]
    places: Float[np.ndarray, "posts 2"]
    steps: tuple[Step, ...]
    start: MapBelief


def simulate(config: Config, *, rng: np.random.Generator) -> Drive:
    """Return one run of a study."""
    angle = np.linspace(0.0, 2 * np.pi * config.rounds, config.steps + 1)
    path = np.stack([np.sin(angle), 1 - np.cos(angle), angle], axis=-1)
    path[:, :2] *= config.radius
    known = np.array([[1.5, -1.0], [-3.0, 9.0]])[: config.anchors]
    off = rng.choice([-1.0, 1.0], config.posts) * rng.uniform(0.8, 2.5, config.posts)
    round_ = rng.uniform(0, 2 * np.pi, config.posts)
    ring = np.stack([np.sin(round_), -np.cos(round_)], axis=-1)
    own = [0.0, config.radius] + (config.radius + off)[:, None] * ring
    places = np.vstack([known, own])
    wheels = roll(path, config.slip, rng=rng)
    looks = glimpse(places, path, sigma=config.look_deviation, reach=config.reach, rng=rng)
    deviations = np.array([config.start_deviation] * 2 + [config.heading_deviation])
    believed = path[0] + deviations * rng.standard_normal(3)
    steps = tuple(
        Step(Odometry(increment, np.diag(deviation**2)), Observations(*look))
        for increment, deviation, look in zip(
            wheels.increments, wheels.deviations, looks[1:], strict=True
        )
    )
    return Drive(path, places, steps, MapBelief.start(believed, np.diag(deviations**2)))


def filter_drive(config: Config, drive: Drive, kind: Filter) -> History:
    """Run one of the three filters over a run; it keeps its belief after every step."""
    truth = Truth(drive.path, dict(enumerate(drive.places)))
    points = {"standard": "latest", "first estimates": "first", "ideal": truth}
    settings = Settings(
        CartesianSensor(config.look_deviation**2 * np.eye(2)),
        anchors=dict(enumerate(drive.places[: config.anchors])),
        linearisation=points[kind],
        keep=range(config.steps),
    )
    return run_filter(drive.start, drive.steps, settings)


def claimed_information(drive: Drive, history: History, kind: Filter) -> Float[np.ndarray, "looks"]:
    r"""Return the information that a filter claims about a turn of the world about the anchor.

    .. math:: I_k = N_k^\top P_k^{-1} N_k, \qquad
        N = \big(J (t - a),\, 1,\, J (p_1 - a), …\big)

    N is taken where the filter takes its Jacobians. If these points hang together, the next N is
    F N and H N = 0, so that :math:`I_k` can only fall: looks add nothing, and noise of the wheels
    takes away.

    Returns
    -------
    (steps + 1,)
        1/rad², at the start and after each step.
    """
    anchor = drive.places[ANCHOR]
    first: dict[int, np.ndarray] = {}
    point = drive.path[0] if kind == "ideal" else drive.start.mean
    before, values = drive.start, []
    values.append(information_along(gauge_directions(point, anchor)["turn"], before.cov))
    for k, step in enumerate(drive.steps):
        belief = history.kept[k]
        for name, place in zip(belief.ids.tolist(), belief.landmarks, strict=True):
            first.setdefault(name, place)
        match kind:
            case "ideal":
                at, places = drive.path[k + 1], drive.places[belief.ids]
            case "standard":
                at, places = belief.pose, belief.landmarks
            case "first estimates":
                at = step.motion.move(before.pose)
                places = np.array([first[name] for name in belief.ids.tolist()]).reshape(-1, 2)
        N = gauge_directions(np.concatenate([at, places.ravel()]), anchor)["turn"]
        values.append(information_along(N, belief.cov))
        before = belief
    return np.array(values)


@dataclass(frozen=True, eq=False, slots=True)
class Result:
    """What one filter claimed in all runs, and how wrong it was.

    Parameters
    ----------
    gains : (runs, steps + 1)
        Information about the turn of the world over that of the start; a filter that invents
        nothing stays at or below 1.
    deviations, errors : (runs, steps)
        Of the heading after each step: what the filter states, and estimate minus truth, rad.
    """

    gains: Float[np.ndarray, "runs looks"]
    deviations: Float[np.ndarray, "runs steps"]
    errors: Float[np.ndarray, "runs steps"]

    @property
    def nees(self) -> Float[np.ndarray, "steps"]:
        """Squared error of the heading over the stated variance, averaged over the runs."""
        return ((self.errors / self.deviations) ** 2).mean(axis=0)

    @property
    def rms(self) -> Float[np.ndarray, "steps"]:
        """Root mean square error of the heading, rad."""
        return np.sqrt((self.errors**2).mean(axis=0))

    @property
    def invented(self) -> Bool[np.ndarray, "runs"]:
        """Whether a run ever claims more than it started with (a millionth is rounding)."""
        return (self.gains > 1 + 1e-6).any(axis=1)


def run(
    config: Config, filters: tuple[Filter, ...] = FILTERS, *, rng: np.random.Generator
) -> dict[Filter, Result]:
    """Run filters over the same runs.

    Parameters
    ----------
    config
        The study.
    filters
        Which; all three if left out.
    rng
        Generator; each run spawns its own.

    Returns
    -------
    dict
        By filter.
    """
    drives = [simulate(config, rng=own) for own in rng.spawn(config.runs)]
    results = {}
    for kind in filters:
        histories = [filter_drive(config, drive, kind) for drive in drives]
        pairs = list(zip(drives, histories, strict=True))
        claimed = np.array([claimed_information(*pair, kind) for pair in pairs])
        variances = np.array([h.pose_covs[:, 2, 2] for h in histories])
        errors = np.array([wrap_angle(h.poses[:, 2] - d.path[1:, 2]) for d, h in pairs])
        results[kind] = Result(claimed / claimed[:, :1], np.sqrt(variances), errors)
    return results


# The claim ---------------------------------------------------------------------------------------

RUNS = {Size.QUICK: 10, Size.FULL: 50}


def _planar_observability(size: Size, rng: np.random.Generator) -> Finding:
    moving, standing = ranks(), ranks(moving=False)
    hidden = {key: r.dimension - r.rank for key, r in moving.items()}
    cured = ("two anchors", "anchor + compass", "position sensor")
    alone = max(hidden["one anchor", reading] for reading in READINGS[1:])
    at_rest = max(r.dimension - r.rank for (name, _), r in standing.items() if name == cured[-1])
    dimension = moving[SETS[0], READINGS[0]].dimension
    unit = f"of {dimension}"
    evidence = {
        f"rank, {name}, {reading}{how}": Interval.exact(table[name, reading].rank, unit)
        for how, table in (("", moving), (", on the spot", standing))
        for name in SETS
        for reading in READINGS
    }
    study = run(Config(runs=RUNS[size]), rng=rng)
    for kind, result in study.items():
        name = f"{kind}: information about the turn, end over start"
        evidence[name] = Interval.of_quantiles(result.gains[:, -1])
        inside = int((np.abs(result.errors) < 2 * result.deviations)[:, -1].sum())
        name = f"{kind}: heading within its stated 2σ at the end"
        evidence[name] = Interval.of_proportion(inside, RUNS[size])
    return Finding(
        Interval.exact(max(hidden[name, r] for name in cured for r in READINGS), "directions"),
        evidence,
        conditions=(
            Condition(
                "an anchor has the company of a second anchor or a compass: alone it leaves the "
                "turn of the world about itself unseen along the true path and nonlinearly, and "
                "has full rank only if all Jacobians are taken at one fixed point",
                needed=alone > 0,
            ),
            Condition("with a position sensor, the robot translates", needed=at_rest > 0),
        ),
        note=f"With one anchor the analysis at one point finds rank "
        f"{moving['one anchor', 'one point'].rank} of {dimension}, the analysis along the true "
        f"path {moving['one anchor', 'true path'].rank}. A standard filter believes the first: in "
        f"{study['standard'].invented.sum()} of {RUNS[size]} runs it claims information about "
        f"the turn that no sensor sent; at consistent points, in "
        f"{study['first estimates'].invented.sum()}.",
    )


CLAIMS: tuple[Claim, ...] = (
    Claim(
        id="planar-observability",
        chapter="anchored_slam",
        paper=PAPER,
        place="§2.2, eqs 24–27",
        statement="For the planar vehicle one two-dimensional anchor, or a sensor of its position, "
        "is enough for full observability.",
        paper_value="full rank",
        method="States minus rank, in exact arithmetic, by three analyses (Jacobians at one "
        "point, along the true path, Lie derivatives): the worst of the three under the conditions "
        "named; each condition was also left out.",
        accepted=Accepted(0, 0, "full observability leaves no direction unseen"),
        compute=_planar_observability,
        seed=21,
    ),
)


def _is_unseen(answer: object, of_it: tuple[float, ...] = (1, 1, 1, 1, 1)) -> bool:
    """Return whether looks at anchor and landmark stay the same along a direction."""
    direction = np.asarray(answer, dtype=float)
    if direction.shape != (5,) or not direction.any():
        return False
    _, H = see([Landmarks(), Anchor(1.0, 0.0)], np.array([3.0, 2.0, 0.0, 1.0, 4.0]))
    return bool(np.abs(H @ (of_it * direction)).max() < 1e-9 * np.abs(direction).max())


EXERCISES = {
    "anchored-turn": Exercise(
        _is_unseen,
        mistakes=(
            (partial(_is_unseen, of_it=(1, 1, -1, 1, 1)), "the heading: to which side?"),
            ((0, 0, 1, -2, -2), "that turns the world about the robot, and the anchor with it."),
            ((1, 0, 0, 1, 0), "a shift: the anchor cannot follow, so it is seen elsewhere."),
            ((0, 1, 0, 0, 1), "a shift: the anchor cannot follow, so it is seen elsewhere."),
        ),
        hint="Five numbers: J (t - a), then 1, then J (p - a), where J turns by a quarter.",
    ),
}
"""Exercises of this part, by name."""
