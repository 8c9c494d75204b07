r"""A learned path driven again: from key image to key image by visual servoing, section 2.4.

The robot compares the patterns that it tracks with the places they had in the next key image. From
this it knows, up to the scale Z/f, where it stood then, and steers there. Nothing else is used: no
map in metres, no wheels.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from types import MappingProxyType
from typing import Annotated, Any

import numpy as np
from jaxtyping import Float, UInt8

from robot_perception import checks
from robot_perception.ceiling.contours import check_size, picture_size
from robot_perception.ceiling.correction import Correction
from robot_perception.ceiling.mapping import (
    MapRules,
    View,
    agreeing,
    inside,
    located,
    look_for,
)
from robot_perception.ceiling.mosaic import Mosaic, NoCommonPattern
from robot_perception.ceiling.patterns import Pattern
from robot_perception.ceiling.tracker import PatternState
from robot_perception.ceiling.visual_memory import (
    Follower,
    KeyImage,
    PathGraph,
    ServoRules,
    closed_loop,
    key_images,
)
from robot_perception.fields import Positive, checked, from_to, numbers

__all__ = ["Navigator", "ReplayInfo", "ReplayState"]


@dataclass(frozen=True, eq=False, slots=True)
class ReplayState:
    """Progress along a path.

    Parameters
    ----------
    tracked
        Where patterns in view are, by name.
    pose : (3,)
        Of the camera in the mosaic when it last saw a pattern, in the mosaic's units.
    key
        Number of the key image that the robot steers for; that of all once the last is reached.
    blind
        In how many pictures in a row no pattern of that key image was seen.
    count
        Pictures used.
    size : (height, width)
        Of the pictures, px; nothing before the first.
    """

    tracked: Mapping[str, PatternState]
    pose: Float[np.ndarray, " 3"]
    key: Annotated[int, from_to(0)] = 0
    blind: Annotated[int, from_to(0)] = 0
    count: Annotated[int, from_to(0)] = 0
    size: Annotated[tuple[int, int] | None, picture_size] = None

    def __post_init__(self) -> None:
        checked(self)
        object.__setattr__(self, "tracked", MappingProxyType(self.tracked))


@dataclass(frozen=True, eq=False, slots=True)
class ReplayInfo:
    """Diagnostics of one picture.

    Parameters
    ----------
    command : (2,)
        Speed, m/s, and turn rate, rad/s.
    target : (3,) or None
        Pose of the key image as seen from the camera, px times the assumed scale, and rad.
    sightings
        Places of the patterns that were seen, by name.
    status
        ``"driving"``, ``"arrived"``, or ``"lost"``: no pattern in common with the key image, so the
        robot stands.
    """

    command: tuple[float, float]
    target: Float[np.ndarray, " 3"] | None
    sightings: Mapping[str, Float[np.ndarray, " 4"]]
    status: str


@dataclass(frozen=True, eq=False, slots=True)
class Navigator:
    r"""Drives a learned path again.

    Parameters
    ----------
    route
        Key images, in order.
    patterns
        What their patterns look like, by name.
    mosaic
        Where they are relative to each other: says where in the picture a known one is expected.
        Its scale cancels.
    centre : (2,)
        Where the optical axis meets the picture, px.
    scale
        Z/f as the robot believes it, m for a px: how far away a key image is said to be.
    servo
        Of the control law.
    rules
        Of trackers and recognition.
    near
        From how near it turns to the next key image, m, as the pose up to scale; at the last one
        it comes as near as the servo's tolerance. Ours.
    patience
        The robot waits for so many pictures without a common pattern before it says that it is
        lost. Ours.
    correction
        Eq. (1), as that of `.mapping.Mapper`.

    Raises
    ------
    ValueError
        If there is no key image, or one has a pattern that is not known.

    References
    ----------
    Section 2.4.
    """

    route: Annotated[Sequence[KeyImage], key_images]
    patterns: Mapping[str, Pattern]
    mosaic: Mosaic
    centre: Annotated[tuple[float, float], numbers(2)]
    scale: Positive = 1.0
    servo: ServoRules = field(default_factory=ServoRules)
    rules: MapRules = field(default_factory=MapRules)
    near: Positive = 0.25
    patience: Annotated[int, from_to(0)] = 5
    correction: Correction | None = None
    _view: View = field(init=False, repr=False)

    def __post_init__(self) -> None:
        checked(self)
        for k, key in enumerate(self.route):
            unknown = [
                n for n in key.sightings if n not in self.patterns or n not in self.mosaic.poses
            ]
            if unknown:
                raise ValueError(
                    f"route[{k}] must show known patterns, got {checks.shown(unknown)}"
                )
        object.__setattr__(self, "_view", View(self.correction, self.rules))

    @classmethod
    def between(
        cls,
        graph: PathGraph,
        start: str,
        goal: str,
        patterns: Mapping[str, Pattern],
        mosaic: Mosaic,
        centre: tuple[float, float],
        scale: float = 1.0,
        **others: Any,
    ) -> "Navigator":
        """Return the navigator along the shortest route of a graph from a place to another.

        Parameters
        ----------
        graph
            Trajectories that were learned below one mosaic.
        start, goal
            Names of its places.
        patterns, mosaic, centre, scale, others
            As for a navigator along a route.

        Raises
        ------
        ValueError
            If no trajectories lead there, the two are one place, or as for a navigator.
        """
        route = checks.instance("graph", graph, PathGraph).route(start, goal)
        return cls(route, patterns, mosaic, centre, scale, **others)

    @property
    def _follower(self) -> Follower:
        return Follower(self.route, self.centre, self.scale, self.servo, self.near)

    def start(
        self, image: UInt8[np.ndarray, "height width"], *, rng: np.random.Generator
    ) -> ReplayState:
        """Return the state at the start: patterns of the first key image are looked for.

        Parameters
        ----------
        image : (height, width)
            Grey values, of the ideal camera where there is no correction.
        rng
            Source of randomness.

        Raises
        ------
        NoCommonPattern
            If none of them is found: the robot does not stand where the path begins.
        """
        image, rng = self._view.corrected(image), checks.generator("rng", rng)
        first = self.route[0].sightings
        anywhere = replace(self.rules, search=2.0 * max(image.shape), turn=np.pi)
        sought = self._view.sought(image)
        tracked = look_for(first, self.patterns, sought, anywhere, rng=rng)
        if not tracked:
            raise NoCommonPattern(
                f"image must show a pattern of the first key image, got none of {tuple(first)}"
            )
        sightings, wrong = agreeing(
            self.mosaic, {name: one.pose for name, one in tracked.items()}, self.rules
        )
        tracked = {name: one for name, one in tracked.items() if name not in wrong}
        pose = located(self.mosaic, sightings, self.rules.by)
        return ReplayState(tracked, pose, size=image.shape)

    def step(
        self,
        state: ReplayState,
        image: UInt8[np.ndarray, "height width"],
        *,
        rng: np.random.Generator,
    ) -> tuple[ReplayState, ReplayInfo]:
        """Return the state after a picture, and what the robot should do.

        Parameters
        ----------
        state
            Before it.
        image : (height, width)
            Grey values, of the ideal camera where there is no correction.
        rng
            Source of randomness.

        Raises
        ------
        TypeError
            If an argument is of another type.
        ValueError
            If the image is not (height, width), or not of the size of those before.
        """
        checks.instance("state", state, ReplayState)
        checks.generator("rng", rng)
        image, rules = self._view.corrected(image), self.rules
        check_size("image", image.shape, state.size)
        trackers = self._view.trackers(self.patterns)
        tracked, told = trackers.step(state.tracked, image, rng=rng)
        infos = told.patterns
        sightings = {name: infos[name].pose for name in tracked if not infos[name].lost}
        sightings, slid = agreeing(self.mosaic, sightings, rules)
        tracked = {name: one for name, one in tracked.items() if name not in slid}
        pose = located(self.mosaic, sightings, rules.by) if sightings else state.pose
        if state.count % rules.every == 0 or len(sightings) < rules.enough:
            again = look_for(
                self._expected(pose, state.key, image.shape, tracked),
                self.patterns,
                self._view.sought(image),
                rules,
                rng=rng,
            )
            tracked |= again
            sightings |= {name: one.pose for name, one in again.items()}
        state = replace(state, tracked=tracked, pose=pose, count=state.count + 1, size=image.shape)
        return self._towards(state, sightings)

    def drive(
        self,
        state: ReplayState,
        look: Callable[[], UInt8[np.ndarray, "height width"]],
        move: Callable[[float, float], object],
        *,
        rng: np.random.Generator,
        most: int = 600,
    ) -> Iterator[tuple[ReplayState, ReplayInfo]]:
        """Drive the route by pictures: yield what `step` returns for each, before the robot moves.

        It ends with the first that does not say ``"driving"``, see `.visual_memory.closed_loop`.

        Parameters
        ----------
        state
            Of `start`.
        look
            The picture that is seen now.
        move
            Drives with a speed, m/s, and a turn rate, rad/s, until the next picture.
        rng
            Source of randomness.
        most
            Pictures.

        Raises
        ------
        TypeError
            If an argument is of another type.
        ValueError
            If it is to look less than once.
        """
        last = checks.instance("state", state, ReplayState)
        checks.generator("rng", rng)

        def step(image: np.ndarray) -> ReplayInfo:
            nonlocal last
            last, info = self.step(last, image, rng=rng)
            return info

        return ((last, info) for info in closed_loop(step, look, move, most=most))

    def _towards(
        self, state: ReplayState, sightings: Mapping[str, np.ndarray]
    ) -> tuple[ReplayState, ReplayInfo]:
        """Return which key image comes next, and the command that leads there."""
        told = self._follower.steer(sightings, min(state.key, len(self.route)))
        blind = state.blind + 1 if told.status == "lost" else 0
        waits = 0 < blind <= self.patience
        status = "driving" if waits else told.status
        after = replace(state, key=told.key, blind=blind)
        return after, ReplayInfo(told.command, told.target, sightings, status)

    def _expected(
        self,
        pose: Float[np.ndarray, " 3"],
        key: int,
        shape: tuple[int, ...],
        tracked: Mapping[str, PatternState],
    ) -> dict[str, Float[np.ndarray, " 4"]]:
        """Return where patterns of the next three key images should be in view."""
        coming = self.route[key : key + 3]
        names = {name: None for key in coming for name in key.sightings if name not in tracked}
        places = {name: self.mosaic.expected(pose, name) for name in names}
        border, seen = self.rules.border, self._view.seen
        return {n: at for n, at in places.items() if inside(at, shape, border, seen)}
