r"""Paths kept as key images, and a unicycle that follows them by what it sees of the ceiling.

A trajectory is learned as a few *key images*: which patterns were seen, and where in the image. To
drive it again, the robot compares what it sees now with the next key image. The patterns that both
have give the pose of the one camera in the frame of the other, and a control law drives it to zero.

Equation numbers are those of Ait Aider, Chateau and Lapresté, "Indoor autonomous navigation using
visual memory and pattern tracking", BMVC 2004. The paper names the law ("visual servoing") only;
that here is of Astolfi, "Exponential stabilization of a wheeled mobile robot via discontinuous
control", ASME Journal of Dynamic Systems, Measurement, and Control 121, 1999.
"""

import heapq
import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Annotated, Protocol, TypeVar

import numpy as np
from jaxtyping import Float

from robot_perception import checks
from robot_perception.ceiling import _sightings
from robot_perception.ceiling.mosaic import Mosaic, NoCommonPattern
from robot_perception.fields import Positive, checked, from_to, numbers, up_to
from robot_perception.geometry import se2, wrap_angle

__all__ = [
    "Breach",
    "Follower",
    "KeyImage",
    "KeyRules",
    "PathGraph",
    "ServoRules",
    "Steering",
    "Trajectory",
    "breaches",
    "choose_key_images",
    "closed_loop",
    "passed",
    "relative_pose",
    "servo",
]


@dataclass(frozen=True, eq=False, slots=True)
class KeyImage:
    r"""A picture of a trajectory: which patterns were seen, and where.

    .. math:: I_k = \left\{ \left( m_i, {}^I L_i^{(k)} \right), i = 1, 2, \dots \right\}

    Parameters
    ----------
    sightings
        The pose of each pattern in the image by its name: x, y, θ, s in px, px, rad, 1.

    References
    ----------
    Section 2.4.
    """

    sightings: Mapping[str, Annotated[Float[np.ndarray, "4"], _sightings.own]]
    __post_init__ = checked


def key_images(name: str, route: Sequence[KeyImage]) -> tuple[KeyImage, ...]:
    """Return key images, one at least."""
    found = checks.instances(name, route, KeyImage)
    if not found:
        raise ValueError(f"{name} must have a key image, got none")
    return found


def _shift(name: str, value: float) -> float:
    """Return a positive number, which may be infinite."""
    found = checks.number(name, value, finite=False)
    if found <= 0:
        raise ValueError(f"{name} must be positive, got {found}")
    return found


@dataclass(frozen=True, slots=True)
class KeyRules:
    """Rules for two successive key images: what they must have in common.

    Parameters
    ----------
    turn
        Condition ii: every pattern that both have turns by less than this, rad. The paper gives no
        number; 15° is ours.
    common
        Condition i: so many patterns are in both; the paper's 1.
    shift
        No pattern that both have moves farther, px. Ours; the paper has no such condition, and
        neither have we unless a number is given.
    """

    turn: Annotated[float, checks.positive] = math.radians(15)
    common: Annotated[int, from_to(1)] = 1
    shift: Annotated[float, _shift] = math.inf
    __post_init__ = checked


@dataclass(frozen=True, slots=True)
class Breach:
    """A condition that two successive key images break.

    Parameters
    ----------
    index
        Of the first of the two.
    condition
        ``"common"``, ``"turn"`` or ``"shift"``, as `KeyRules` calls them.
    value
        The number of common patterns, the largest turn, rad, or the largest shift, px.
    """

    index: int
    condition: str
    value: float


JOINTS = KeyRules(turn=2 * math.pi)
"""Rules for two trajectories that are driven one after the other: condition i of the paper."""


def choose_key_images(
    run: Sequence[Mapping[str, Float[np.ndarray, "4"]]], rules: KeyRules | None = None
) -> tuple[int, ...]:
    """Return which images of a learned trajectory are kept.

    The first and the last, and between them as few as this rule leads to: the next key image is the
    farthest that still fulfils all conditions beside the last one. How far is looked ends at the
    first image in which a pattern has turned, or moved, too far, even if it turns back later: else
    a bend to and fro would be cut off. An image that lacks the patterns does not end it, since a
    tracker may lose them for a moment.

    Parameters
    ----------
    run
        Sightings of each image of the run, by names.
    rules
        Conditions; those of `KeyRules` if not given.

    Returns
    -------
    tuple of int
        Indices, ascending.

    Raises
    ------
    ValueError
        If the run is empty, a sighting is wrong, or after some key image, which the message names,
        no image fulfils the conditions.

    References
    ----------
    Section 2.4, conditions i) and ii).
    """
    rules = _rules("rules", rules, KeyRules)
    images = [
        _sightings.sightings(f"run[{k}]", image)
        for k, image in enumerate(checks.iterable("run", run))
    ]
    if not images:
        raise ValueError("run must have an image, got none")
    chosen = [0]
    while (last := chosen[-1]) < len(images) - 1:
        best, broken = last, dict[str, float]()
        for k in range(last + 1, len(images)):
            broken = _broken(images[last], images[k], rules)
            if broken.keys() & {"turn", "shift"}:
                break
            if not broken:
                best = k
        if best == last:
            reason = f"no later image has {rules.common} of its patterns"
            if "turn" in broken:
                reason = f"a pattern turns by {broken['turn']:g} rad from one image to the next"
            elif "shift" in broken:
                reason = f"a pattern moves by {broken['shift']:g} px from one image to the next"
            raise ValueError(f"run must go on from its image {last} by the rules, but {reason}")
        chosen.append(best)
    return tuple(chosen)


def breaches(keys: Sequence[KeyImage], rules: KeyRules | None = None) -> tuple[Breach, ...]:
    """Return which successive key images break which condition.

    Parameters
    ----------
    keys
        Of a trajectory, in their order.
    rules
        Conditions; those of `KeyRules` if not given.

    Raises
    ------
    TypeError
        If one is no key image.
    """
    rules = _rules("rules", rules, KeyRules)
    keys = checks.instances("keys", keys, KeyImage)
    return tuple(
        Breach(k, condition, value)
        for k in range(len(keys) - 1)
        for condition, value in _broken(keys[k].sightings, keys[k + 1].sightings, rules).items()
    )


@dataclass(frozen=True, slots=True)
class Trajectory:
    """A learned way from one place to another.

    Parameters
    ----------
    start, goal
        Names of the places.
    keys
        Key images in the order of driving.
    """

    start: str
    goal: str
    keys: tuple[KeyImage, ...]


@dataclass(frozen=True, eq=False, slots=True)
class PathGraph:
    r"""Places, and the trajectories :math:`\Phi_{AB}` that were learned between them.

    A trajectory is driven one way only: the robot looks ahead, and driven backwards it would see
    every pattern turned by 180° where the key images have it. The way back is another trajectory.

    Parameters
    ----------
    rules
        What the last key image of a trajectory and the first of the next must have in common: one
        pattern, as in condition i, unless other rules are given.

    References
    ----------
    Section 2.4.
    """

    rules: KeyRules = JOINTS
    trajectories: tuple[Trajectory, ...] = field(init=False, default=())
    __post_init__ = checked

    @property
    def places(self) -> tuple[str, ...]:
        """Names of the places, in the order in which they were learned."""
        return tuple(dict.fromkeys(p for way in self.trajectories for p in (way.start, way.goal)))

    def add(self, start: str, goal: str, keys: Sequence[KeyImage]) -> "PathGraph":
        """Return the graph with a trajectory more; there may be several between two places.

        Parameters
        ----------
        start, goal
            Names of the places that it leads from and to.
        keys
            Its key images, see `choose_key_images`.

        Raises
        ------
        ValueError
            If there is no key image, or start and goal are the same place.
        """
        start, goal = checks.instance("start", start, str), checks.instance("goal", goal, str)
        keys = checks.instances("keys", keys, KeyImage)
        if not keys:
            raise ValueError("keys must have a key image, got none")
        if start == goal:
            raise ValueError(f"goal must be another place than start, got {goal!r}")
        graph = PathGraph(self.rules)
        ways = (*self.trajectories, Trajectory(start, goal, keys))
        object.__setattr__(graph, "trajectories", ways)
        return graph

    def route(self, start: str, goal: str) -> tuple[KeyImage, ...]:
        """Return the key images from one place to another, as few as possible.

        Dijkstra's search over trajectories: whether one may follow another depends on both, so that
        a search over places would not do.

        Parameters
        ----------
        start, goal
            Names of places; if they are the same, there is nothing to drive.

        Returns
        -------
        tuple of KeyImage
            In the order of driving.

        Raises
        ------
        ValueError
            If a place is unknown, or no trajectories lead from one to the other that share patterns
            where they join.
        """
        for name, place in (("start", start), ("goal", goal)):
            if checks.instance(name, place, str) not in self.places:
                known = checks.shown([*self.places])
                raise ValueError(f"{name} must be a place of the graph, {known}, got {place!r}")
        if start == goal:
            return ()
        ways = self.trajectories
        open_ = [(len(way.keys), k, (k,)) for k, way in enumerate(ways) if way.start == start]
        heapq.heapify(open_)
        done: set[int] = set()
        broken: list[str] = []
        while open_:
            length, last, path = heapq.heappop(open_)
            if ways[last].goal == goal:
                return tuple(key for k in path for key in ways[k].keys)
            if last in done:
                continue
            done.add(last)
            for k, way in enumerate(ways):
                if way.start != ways[last].goal or k in done:
                    continue
                if breaches((ways[last].keys[-1], way.keys[0]), self.rules):
                    broken.append(way.start)
                else:
                    heapq.heappush(open_, (length + len(way.keys), k, (*path, k)))
        joints = ", ".join(map(repr, dict.fromkeys(broken)))
        why = f"; key images do not fit together at {joints}" if broken else ""
        raise ValueError(
            f"start and goal must be joined, got no way from {start!r} to {goal!r}{why}"
        )


def relative_pose(
    current: Mapping[str, Float[np.ndarray, "4"]],
    key: KeyImage,
    *,
    centre: Float[np.ndarray, "2"],
    scale: float = 1.0,
    offset: Float[np.ndarray, "3"] | None = None,
    sigma_px: float = _sightings.SIGMA_PX,
    sigma_heading: float = _sightings.SIGMA_HEADING,
) -> Float[np.ndarray, "3"]:
    r"""Return the pose from which the key image was taken, in the frame of the robot as it is now.

    .. math:: {}^C T_{key} = {}^C T_i \left( {}^{key} T_i \right)^{-1}

    for a pattern that both have; the least squares of `mosaic.align` for several. No mosaic is
    needed. Position is proportional to the scale and direction and heading do not depend on it.

    A camera off the centre of the robot sees its own motion, and the pose is that of the camera.
    With its place on the robot, ``offset``, it is turned into that of the robot,

    .. math:: {}^R T_{key} = O\; {}^C T_{key}\; O^{-1},

    for which the scale must be known: an offset in metres is a number of pixels only by Z/f. The
    same is done by eq. (1) for whole pictures. Left out, or done with a wrong scale, the pose is
    still zero exactly at the place of the key image, but how the robot gets there changes. A camera
    ahead of the axle is harmless. One that is behind it by a moves to the wrong side when the robot
    turns: nearer to the target than a the loop is unstable, and the robot arrives turned away.

    A tilt of the camera that was the same when the path was learned leaves that zero in place, too,
    and deforms what lies between; one that has changed by ε since moves it, by about Z tan ε.

    Parameters
    ----------
    current
        Sightings of the image that the robot sees now, by names.
    key
        The key image.
    centre : (2,)
        Principal point, px.
    scale
        Z/f, m per px; 1 gives px.
    offset : (3,)
        Pose of the camera on the robot, m and rad; none if the picture is corrected.
    sigma_px, sigma_heading
        Standard deviations of a sighting, px and rad; only their ratio matters. Ours.

    Returns
    -------
    (3,)
        Position, ahead and to the left, and heading, m and rad.

    Raises
    ------
    NoCommonPattern
        If no pattern is in both.
    ValueError
        If a sighting is wrong, a number is out of its range, or the patterns contradict each other
        on the heading.

    References
    ----------
    Sections 2.2 and 2.4.
    """
    current = _sightings.sightings("current", current)
    seen = checks.instance("key", key, KeyImage).sightings
    centre, scale = _sightings.centre(centre), _sightings.scale(scale)
    a, b = _sightings.shares(sigma_px, sigma_heading, scale)
    mount = None if offset is None else _sightings.pose("offset", offset, (3,))
    names = [name for name in current if name in seen]
    if not names:
        raise NoCommonPattern(
            f"current and key must have a pattern in common, got {checks.shown([*current])} "
            f"and {checks.shown([*seen])}"
        )
    now = _sightings.metric(np.array([current[name] for name in names]), centre, scale)
    then = _sightings.metric(np.array([seen[name] for name in names]), centre, scale)
    pose = _sightings.aligned(now, then, np.full(len(names), a), np.full(len(names), b))
    if mount is None:
        return pose
    return se2.compose(se2.compose(mount, pose), se2.inverse(mount))


@dataclass(frozen=True, slots=True)
class ServoRules:
    r"""Gains and limits of `servo`, and when a key image counts as reached.

    Parameters
    ----------
    gain_distance
        :math:`k_\rho`, 1/s.
    gain_bearing
        :math:`k_\alpha`, 1/s.
    gain_heading
        :math:`k_\beta`, 1/s; negative.
    fastest
        Bound of the speed, m/s.
    fastest_turn
        Bound of the turn rate, rad/s.
    tolerance
        From how near a key image counts as reached, m; up to scale, as the pose.

    Raises
    ------
    ValueError
        If the law is not stable with these gains: :math:`k_\rho > 0`, :math:`k_\alpha > k_\rho`,
        :math:`k_\beta < 0`, and :math:`k_\alpha > 2 \lvert k_\beta \rvert`, which lets a robot that
        looks away turn round.

    Notes
    -----
    All numbers are ours.
    """

    gain_distance: Annotated[float, up_to(_sightings.LARGEST)] = 0.3
    gain_bearing: Annotated[float, up_to(_sightings.LARGEST)] = 1.5
    gain_heading: float = -0.7
    fastest: Annotated[float, up_to(_sightings.LARGEST)] = 0.3
    fastest_turn: Annotated[float, up_to(_sightings.LARGEST)] = 1.0
    tolerance: Annotated[float, up_to(_sightings.LARGEST)] = 0.05

    def __post_init__(self) -> None:
        checked(self)
        if not -self.gain_bearing / 2 < self.gain_heading < 0:
            raise ValueError(
                "gain_heading must be negative and less than half of gain_bearing "
                f"{self.gain_bearing:g}, got {self.gain_heading:g}"
            )
        if self.gain_bearing <= self.gain_distance:
            raise ValueError(
                f"gain_bearing must be larger than gain_distance {self.gain_distance:g}, "
                f"got {self.gain_bearing:g}"
            )

    @property
    def largest_scale(self) -> float:
        r"""Below which factor on the true scale the loop is stable: :math:`k_\alpha / k_\rho`."""
        return self.gain_bearing / self.gain_distance


def servo(target: Float[np.ndarray, "3"], rules: ServoRules | None = None) -> tuple[float, float]:
    r"""Return speed and turn rate that drive a unicycle to a pose, forwards.

    .. math::
        v = k_\rho\, \rho \max(\cos\alpha, 0), \qquad \omega = k_\alpha\, \alpha + k_\beta\, \beta

    :math:`\rho` is the distance of the target, :math:`\alpha` its bearing, and :math:`\beta` its
    heading less its bearing. Astolfi's law has :math:`v = k_\rho\, \rho` and holds for targets
    ahead; the cosine, ours, makes one that is behind a target to turn to, and changes nothing near
    :math:`\alpha = 0`. Where a bound is exceeded both are made smaller by one factor, so that the
    robot drives the same curve more slowly.

    Closed, the loop has

    .. math::
        \dot\rho = -k_\rho\, \rho \cos^2\alpha, \qquad
        \dot\alpha = k_\rho \cos\alpha \sin\alpha - k_\alpha\, \alpha - k_\beta\, \beta, \qquad
        \dot\beta = -k_\rho \cos\alpha \sin\alpha .

    Near zero its eigenvalues are :math:`-k_\rho` and the roots of
    :math:`\lambda^2 + (k_\alpha - k_\rho)\, \lambda - k_\rho k_\beta`: stable if and only if
    :math:`k_\rho > 0`, :math:`k_\beta < 0`, :math:`k_\alpha > k_\rho`. As the smaller root
    :math:`\lambda` is to :math:`-k_\rho`, so the heading falls: with
    :math:`\rho^{\lambda / -k_\rho}`, for our gains :math:`\rho^{0.71}`. Far from zero, too: the
    target stays ahead once it is there, and in :math:`\alpha, \beta` the divergence
    :math:`k_\rho \cos 2\alpha - k_\alpha` is negative, so that (Bendixson) there is no cycle.

    What the scale does: :math:`\alpha` and :math:`\beta` are angles, and do not depend on it.
    A scale :math:`\hat z` times too large makes :math:`\rho`, and so v alone, :math:`\hat z` times
    too large: it is a wrong gain, :math:`\hat z k_\rho`, and the loop stays stable as long as
    :math:`\hat z < k_\alpha / k_\rho` (`ServoRules.largest_scale`). With poses in px,
    :math:`k_\rho` must be so much smaller: the scale need not be known, its order of magnitude
    must.

    Parameters
    ----------
    target : (3,)
        Pose to drive to in the frame of the robot, m and rad; see `relative_pose`.
    rules
        Gains and bounds; those of `ServoRules` if not given.

    Returns
    -------
    speed
        v, m/s, never negative.
    turn_rate
        ω, rad/s.

    Raises
    ------
    ValueError
        If the target is not three finite numbers.

    References
    ----------
    Section 2.4; Astolfi 1999; Aicardi, Casalino, Bicchi and Balestrino, "Closed loop steering of
    unicycle-like vehicles via Lyapunov techniques", IEEE Robotics & Automation Magazine 2(1), 1995.
    """
    rules = _rules("rules", rules, ServoRules)
    x, y, heading = _sightings.pose("target", target, (3,)).tolist()
    alpha = math.atan2(y, x)
    beta = float(wrap_angle(heading - alpha))
    speed = rules.gain_distance * max(x, 0.0)  # ρ cos α is the distance ahead
    turn = rules.gain_bearing * alpha + rules.gain_heading * beta
    slower = max(1.0, speed / rules.fastest, abs(turn) / rules.fastest_turn)
    return speed / slower, turn / slower


def passed(target: Float[np.ndarray, "3"], rules: ServoRules | None = None) -> bool:
    r"""Tell whether a key image is reached, or left behind.

    Reached, if it is within the tolerance; left behind, if the robot has crossed the line through
    the place of the key image at right angles to its heading,

    .. math:: x \cos\varphi + y \sin\varphi \le 0

    which does not depend on where the robot looks: one that has turned away on its way has passed
    nothing. Neither does it depend on the scale; the tolerance does.

    Parameters
    ----------
    target : (3,)
        Pose of the key image in the frame of the robot, m and rad.
    rules
        With the tolerance; those of `ServoRules` if not given.

    Raises
    ------
    ValueError
        If the target is not three finite numbers.
    """
    rules = _rules("rules", rules, ServoRules)
    x, y, heading = _sightings.pose("target", target, (3,)).tolist()
    ahead = x * math.cos(heading) + y * math.sin(heading)
    return math.hypot(x, y) <= rules.tolerance or ahead <= 0


class Told(Protocol):
    """Action that follows a look at the ceiling."""

    @property
    def command(self) -> tuple[float, float]:
        """Speed, m/s, and turn rate, rad/s."""

    @property
    def status(self) -> str:
        """``"driving"``, or another word where the robot stands for good."""


Look = TypeVar("Look")
Step = TypeVar("Step", bound=Told)


def closed_loop(
    step: Callable[[Look], Step],
    look: Callable[[], Look],
    move: Callable[[float, float], object],
    *,
    most: int = 600,
) -> Iterator[Step]:
    """Look, decide, move, and so on: yield what each look leads to, before the robot moves.

    It ends with the first that does not say ``"driving"``, or after so many looks.

    Parameters
    ----------
    step
        What follows from a look: a command and a status.
    look
        What is seen now: a picture, or sightings.
    move
        Drives with a speed, m/s, and a turn rate, rad/s, until the next look.
    most
        Looks.

    Raises
    ------
    TypeError
        If one of them cannot be called.
    ValueError
        If it is to look less than once.
    """
    for name, one in (("step", step), ("look", look), ("move", move)):
        if not callable(one):
            raise TypeError(f"{name} must be a function, got {checks.shown(one)}")
    return _closed(step, look, move, checks.whole("most", most, 1))


def _closed(
    step: Callable[[Look], Step],
    look: Callable[[], Look],
    move: Callable[[float, float], object],
    most: int,
) -> Iterator[Step]:
    for _ in range(most):
        told = step(look())
        yield told
        if told.status != "driving":
            return
        move(*told.command)


@dataclass(frozen=True, eq=False, slots=True)
class Steering:
    """Steering by sightings on a path of key images.

    Parameters
    ----------
    key
        Number of the key image that is steered for; that of all once the last is reached.
    target : (3,) or None
        Its pose in the frame of the robot, see `relative_pose`; of the last one where it is
        reached.
    command : (2,)
        Speed, m/s, and turn rate, rad/s.
    status
        ``"driving"``, ``"arrived"``, or ``"lost"``: no pattern in common with that key image.
    """

    key: int
    target: Float[np.ndarray, " 3"] | None
    command: tuple[float, float]
    status: str


@dataclass(frozen=True, eq=False, slots=True)
class Follower:
    r"""Steers from key image to key image by sightings: the servo loop of section 2.4.

    Parameters
    ----------
    route
        Key images, in order.
    centre : (2,)
        Where the optical axis meets the picture, px.
    scale
        Z/f as the robot believes it, m for a px.
    servo
        Of the control law.
    near
        From how near it turns to the next key image, m, as the pose up to scale; at the last one
        it comes as near as the servo's tolerance. Ours.
    behind
        Whether a key image that is left behind counts as reached, see `passed`; else one must be
        near it.
    mosaic
        If given, the robot steers by its pose in it, for comparison: from where the mosaic has the
        robot to where it has the key image. Else a key image is compared with what is seen, and
        nothing else is used.

    Raises
    ------
    ValueError
        If there is no key image.

    References
    ----------
    Section 2.4.
    """

    route: Annotated[Sequence[KeyImage], key_images]
    centre: Annotated[tuple[float, float], numbers(2)]
    scale: Positive = 1.0
    servo: ServoRules = field(default_factory=ServoRules)
    near: Positive = 0.25
    behind: bool = True
    mosaic: Mosaic | None = None
    __post_init__ = checked

    def steer(self, sightings: Mapping[str, Float[np.ndarray, " 4"]], key: int = 0) -> Steering:
        """Return which key image comes next, and the command that leads there.

        Parameters
        ----------
        sightings
            Of what is seen now, by names.
        key
            Number of the key image that was steered for before.

        Raises
        ------
        ValueError
            If a sighting is not four numbers, or there is no such key image.
        """
        sightings = _sightings.sightings("sightings", sightings)
        key, count, target = checks.whole("key", key, 0, len(self.route)), len(self.route), None
        while key < count:
            try:
                target = self._target(sightings, self.route[key])
            except NoCommonPattern:
                return Steering(key, None, (0.0, 0.0), "lost")
            if not self._reached(target, last=key == count - 1):
                return Steering(key, target, servo(target, self.servo), "driving")
            key += 1
        return Steering(key, target, (0.0, 0.0), "arrived")

    def drive(
        self,
        look: Callable[[], Mapping[str, Float[np.ndarray, " 4"]]],
        move: Callable[[float, float], object],
        *,
        key: int = 0,
        most: int = 600,
    ) -> Iterator[Steering]:
        """Drive the route: yield what each look leads to, see `closed_loop`.

        Parameters
        ----------
        look
            Sightings of what is seen now.
        move
            Drives with a speed, m/s, and a turn rate, rad/s, until the next look.
        key
            Number of the key image with which it begins.
        most
            Looks.

        Raises
        ------
        TypeError
            If look or move cannot be called.
        ValueError
            If there is no such key image, or it is to look less than once.
        """
        at = checks.whole("key", key, 0, len(self.route))

        def step(sightings: Mapping[str, np.ndarray]) -> Steering:
            nonlocal at
            told = self.steer(sightings, at)
            at = told.key
            return told

        return closed_loop(step, look, move, most=most)

    def _target(
        self, sightings: Mapping[str, np.ndarray], key: KeyImage
    ) -> Float[np.ndarray, " 3"]:
        if self.mosaic is None:
            return relative_pose(sightings, key, centre=np.array(self.centre), scale=self.scale)
        here, there = (self.mosaic.locate(seen)[0] for seen in (sightings, key.sightings))
        return se2.between(here, there)

    def _reached(self, target: Float[np.ndarray, " 3"], *, last: bool) -> bool:
        rules = self.servo if last else replace(self.servo, tolerance=self.near)
        if self.behind:
            return passed(target, rules)
        return math.hypot(*target[:2]) <= rules.tolerance


def _broken(
    first: Mapping[str, np.ndarray], second: Mapping[str, np.ndarray], rules: KeyRules
) -> dict[str, float]:
    """Return the conditions that two images break, with the number that does."""
    shared = [name for name in first if name in second]
    found: dict[str, float] = {}
    if len(shared) < rules.common:
        found["common"] = float(len(shared))
    if not shared:
        return found
    turn = shift = 0.0
    for name in shared:  # plain numbers: of three patterns an array would cost more
        x, y, heading, _ = (second[name] - first[name]).tolist()
        turn = max(turn, abs(math.remainder(heading, 2 * math.pi)))
        shift = max(shift, math.hypot(x, y))
    if turn >= rules.turn:
        found["turn"] = turn
    if shift > rules.shift:
        found["shift"] = shift
    return found


def _rules(name: str, value: KeyRules | ServoRules | None, kind: type) -> KeyRules | ServoRules:
    """Return rules, or those that hold where none are given."""
    return kind() if value is None else checks.instance(name, value, kind)
