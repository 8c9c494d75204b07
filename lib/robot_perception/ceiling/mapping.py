r"""A mosaic of patterns built while the robot drives: section 2.3 of the paper.

A picture is used in five steps: track the patterns in view; locate the robot by those that the
mosaic knows (eq. 2); look for known patterns that should be in view, by their contours; make new
patterns where too few are left, and put them into the mosaic (eq. 3).
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from types import MappingProxyType
from typing import Annotated, Any

import numpy as np
from jaxtyping import Bool, Float, Int, UInt8

from robot_perception import checks
from robot_perception.ceiling import _sightings
from robot_perception.ceiling.contours import (
    Arc,
    ContourRules,
    Edges,
    Segment,
    check_size,
    find_contours,
    find_edges,
    picture,
    picture_size,
    segments_and_arcs,
)
from robot_perception.ceiling.correction import Correction
from robot_perception.ceiling.mosaic import (
    Links,
    Mosaic,
    NoCommonPattern,
    adjust,
    camera_pose,
    in_camera,
    place,
)
from robot_perception.ceiling.patterns import (
    Pattern,
    PatternRules,
    Window,
    WindowRules,
    interest_windows,
    pattern_from,
)
from robot_perception.ceiling.recognition import EdgeField, RecognitionRules, recognise
from robot_perception.ceiling.tracker import (
    Layers,
    PatternInfo,
    PatternState,
    PatternTracker,
    TrackerRules,
)
from robot_perception.extras import needing
from robot_perception.fields import (
    NotNegative,
    Positive,
    Share,
    checked,
    from_to,
    numbers,
    one_of,
)
from robot_perception.geometry.angles import wrap_angle
from robot_perception.geometry.se2 import between, compose

with needing():
    import cv2

__all__ = [
    "AS_PRINTED",
    "MapInfo",
    "MapRules",
    "MapState",
    "Mapper",
    "PatternTrackers",
    "PatternsInfo",
    "Sought",
    "View",
    "agreeing",
    "consistent",
    "inside",
    "located",
    "look_for",
    "retrace",
]


STEADY = TrackerRules(sigmas=(3.0, 3.0, np.deg2rad(2.0), 0.01), tolerated=0.2, passes=1)
"""Tracker of a robot on a level floor, whose distance from the ceiling stays the same."""
BY = ("all", "oldest", "newest", "nearest")


@dataclass(frozen=True, slots=True)
class MapRules:
    """Rules of building a mosaic; all numbers are ours.

    Parameters
    ----------
    tracker, patterns, windows, contours, recognition
        Rules of what it stands on. A robot on a level floor keeps its distance from the ceiling, so
        the scale hardly wanders; between two pictures it moves by a few px.
    enough
        New patterns are made where fewer are tracked.
    repeated
        Where less than two patterns would be in view, windows are taken whose contours correlate
        that much with others in the picture: they can be tracked, though they may be confused when
        they are looked for.
    border
        A pattern whose centre comes closer to the border is let go, px.
    search
        A known pattern is looked for that far from where it is expected, px.
    turn
        And turned by as much, rad.
    candidates
        So many places at which its contours fit are tried.
    gate
        A pattern that is seen further from where the others say it is, px, is let go: the mosaic is
        rigid, so its tracker must have slid.
    closing
        What happens where a known pattern is found further than the gate from where it was
        expected, since errors have added up on the way. ``"chain"``: the mosaic stays as it was
        chained, as in the paper, and the robot is located by the pattern that it knows longer.
        ``"adjust"``: all poses are fitted to all that was seen (`.mosaic.adjust`), but for those
        that no chain of pictures joins to the pattern. ``"none"``: nothing; the mosaic stays, and
        all patterns are tracked on, though they contradict each other.
    every
        It is looked for in every so many pictures, since contours take longer than tracking.
    by
        By which of the known patterns in view the robot is located, eq. (2), and a new pattern is
        placed, eq. (3). ``"all"``: the pose is the least squares of all (`.mosaic.Mosaic.locate`),
        and new patterns are placed by it. The others take one, as the equations are printed; the
        paper says that one is enough, but not which: ``"oldest"`` or ``"newest"`` in the mosaic;
        ``"nearest"`` to the middle of the picture, for a new pattern to that.
    rigid
        Whether patterns beyond the gate are let go. The paper has no such rule.
    """

    tracker: TrackerRules = field(default_factory=lambda: STEADY)
    patterns: PatternRules = field(default_factory=PatternRules)
    windows: WindowRules = field(default_factory=lambda: WindowRules(most=6))
    contours: ContourRules = field(default_factory=ContourRules)
    recognition: RecognitionRules = field(default_factory=RecognitionRules)
    enough: Annotated[int, from_to(1, 10**4)] = 4
    repeated: Share = 0.97
    border: NotNegative = 30.0
    search: NotNegative = 40.0
    turn: Annotated[float, checks.not_negative] = np.deg2rad(15.0)
    candidates: Annotated[int, from_to(1, 10**4)] = 5
    gate: NotNegative = 6.0
    closing: Annotated[str, one_of("chain", "adjust", "none")] = "adjust"
    every: Annotated[int, from_to(1, 10**4)] = 5
    by: Annotated[str, one_of(*BY)] = "all"
    rigid: bool = True
    __post_init__ = checked


AS_PRINTED = MapRules(
    tracker=TrackerRules(deviation=0.1, worst=0.6, bad="left out", smoothing="scale"),
    patterns=PatternRules(fall="padded", centred=False),
    closing="none",
    by="oldest",
    rigid=False,
)
"""Rules as the paper prints them, where it prints any.

Of the tracker: the random walk of section 4.1, one look at each picture, bad vectors left out,
σ = s where s > 1, vectors that keep their means, the autocorrelation with zeros beyond the ends. Of
the mosaic: eqs (2) and (3) by one pattern, nothing that compares patterns with each other, nothing
about loops. What it leaves open stays ours; σ and the threshold of eq. (6) are chosen for vectors
that keep their means, whose correlations hardly fall.
"""


@dataclass(frozen=True, eq=False, slots=True)
class MapState:
    """State of the mapper after a picture.

    Parameters
    ----------
    mosaic
        Patterns' poses.
    patterns
        What they look like, by name.
    tracked
        Where those in view are.
    pose : (3,)
        Of the camera in the mosaic, m (px times the mosaic's scale) and rad.
    motion : (3,)
        Of the last step, in the camera's frame: where nothing known is seen, it is assumed to go
        on.
    links
        Poses of patterns relative to each other, over all pictures.
    count
        Pictures used; none before the first pattern.
    size : (height, width)
        Of the pictures, px; nothing before the first.
    """

    mosaic: Mosaic
    patterns: Mapping[str, Pattern]
    tracked: Mapping[str, PatternState]
    pose: Float[np.ndarray, " 3"]
    motion: Float[np.ndarray, " 3"]
    links: Links
    count: Annotated[int, from_to(0)] = 1
    size: Annotated[tuple[int, int] | None, picture_size] = None

    def __post_init__(self) -> None:
        checked(self)
        for name in ("patterns", "tracked"):
            object.__setattr__(self, name, MappingProxyType(getattr(self, name)))

    @property
    def pieces(self) -> tuple[tuple[str, ...], ...]:
        """Names of the patterns that a chain of pictures joins, group by group.

        There is more than one group where the robot was blind on the way. Nothing tells where one
        lies from another (`.mosaic.pieces`); the first holds the first pattern.
        """
        return self.links.groups(self.mosaic.poses)


@dataclass(frozen=True, eq=False, slots=True)
class MapInfo:
    """Diagnostics of one picture.

    Parameters
    ----------
    sightings
        Place (x, y, θ, s) of each pattern that was tracked, by name.
    tracking
        What each tracker says.
    located
        Whether the robot is located in the mosaic's frame: a known pattern was seen that a chain of
        pictures joins to the first one, or this was made. If not, the pose is a guess, though it
        may be right in the frame of its piece.
    new
        Names of the patterns that were made.
    lost
        Of those that were given up, unseen or near the border.
    found
        Of known ones that were found again.
    closed
        Whether one of them was further from where it was expected than the gate: a loop is closed.
    piece
        Number of the piece of the mosaic whose patterns were seen, see `MapState.pieces`; nothing
        where no known one was. 0 is that of the first pattern; where another one lies is a guess.
    """

    sightings: Mapping[str, Float[np.ndarray, " 4"]]
    tracking: Mapping[str, PatternInfo]
    located: bool
    new: tuple[str, ...] = ()
    lost: tuple[str, ...] = ()
    found: tuple[str, ...] = ()
    closed: bool = False
    piece: int | None = None


@dataclass(frozen=True, eq=False, slots=True)
class Mapper:
    r"""Builds a mosaic and localises the robot in it.

    Parameters
    ----------
    scale
        Z/f, m for a px. 1 where it is not known: then all positions are px.
    centre : (2,)
        Where the optical axis meets the picture, px.
    rules
        How.
    correction
        Eq. (1), where the camera is not mounted level and in the robot's frame: pictures are those
        of the camera, scale and centre those of the ideal picture. Where the camera sees nothing of
        it, nothing is sought, made or tracked, as beyond its border.

    References
    ----------
    Sections 2.1 and 2.3.
    """

    scale: Positive
    centre: Annotated[tuple[float, float], numbers(2)]
    rules: MapRules = field(default_factory=MapRules)
    correction: Correction | None = None
    _view: "View" = field(init=False, repr=False)

    def __post_init__(self) -> None:
        checked(self)
        object.__setattr__(self, "_view", View(self.correction, self.rules))

    @property
    def _middle(self) -> Float[np.ndarray, " 2"]:
        return np.array(self.centre)

    def start(self) -> MapState:
        """Return the state before the first picture: nothing is known."""
        nowhere = np.zeros(3)
        empty = Mosaic({}, self.scale, self._middle)
        return MapState(empty, {}, {}, nowhere, nowhere, Links(), 0)

    def step(
        self,
        state: MapState,
        image: UInt8[np.ndarray, "height width"],
        *,
        rng: np.random.Generator,
    ) -> tuple[MapState, MapInfo]:
        """Return the state after a picture.

        The first pattern that is made is the mosaic's frame. As long as no picture has a
        distinctive window, as of a blank ceiling, there is none: the state stays as it is, and the
        robot is not located.

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
        checks.instance("state", state, MapState)
        checks.generator("rng", rng)
        rules, image = self.rules, self._view.corrected(image)
        check_size("image", image.shape, state.size)
        if not state.mosaic.poses:
            return self._begun(state, image, rng)
        trackers = self._view.trackers(state.patterns)
        tracked, told = trackers.step(state.tracked, image, rng=rng)
        infos = told.patterns
        sightings = {name: infos[name].pose for name in tracked if not infos[name].lost}
        sightings, slid = agreeing(state.mosaic, sightings, rules)
        tracked = {name: one for name, one in tracked.items() if name not in slid}
        before, guess = state.pose, compose(state.pose, state.motion)
        known = bool(sightings)
        pose = located(state.mosaic, sightings, rules.by) if known else guess
        state = replace(state, tracked=tracked, pose=pose, count=state.count + 1, size=image.shape)
        sought, found, closed, together = None, (), False, sightings
        if state.count % rules.every == 0 or not known:
            sought = self._view.sought(image)
            again, expected = self._again(state, sought, rng)
            if again:
                found, known = tuple(again), True
                together = sightings | {name: one.pose for name, one in again.items()}
                state, sightings, closed = self._rejoined(state, sightings, again, expected)
        motion = between(before, state.pose) if known and not closed else state.motion
        state = replace(state, motion=motion)
        new: tuple[str, ...] = ()
        if len(sightings) < rules.enough:
            state, sightings, new = self._make(state, image, sought, sightings, rng)
        together = together | sightings
        links = state.links.add(together, centre=self._middle, scale=self.scale)
        state = replace(state, links=links)
        piece = _piece(state, next(iter(sightings))) if known else None
        lost = told.lost + slid
        return state, MapInfo(sightings, infos, piece == 0, new, lost, found, closed, piece)

    def _begun(
        self, state: MapState, image: np.ndarray, rng: np.random.Generator
    ) -> tuple[MapState, MapInfo]:
        """Return the state with the first patterns, if the picture has a distinctive window."""
        state, sightings, new = self._make(state, image, None, {}, rng)
        links = state.links.add(sightings, centre=self._middle, scale=self.scale)
        after = replace(state, links=links, count=state.count + bool(new), size=image.shape)
        return after, MapInfo(sightings, {}, bool(new), new, piece=0 if new else None)

    def _again(
        self, state: MapState, sought: "Sought", rng: np.random.Generator
    ) -> tuple[dict[str, PatternState], dict[str, Float[np.ndarray, " 4"]]]:
        """Return known patterns that are found again, and where those in view were expected."""
        mosaic, border, shape = state.mosaic, self.rules.border, sought.image.shape
        places = {n: mosaic.expected(state.pose, n) for n in mosaic.poses if n not in state.tracked}
        seen = sought.seen
        expected = {name: at for name, at in places.items() if inside(at, shape, border, seen)}
        return look_for(expected, state.patterns, sought, self.rules, rng=rng), expected

    def _rejoined(
        self,
        state: MapState,
        sightings: Mapping[str, Float[np.ndarray, " 4"]],
        again: Mapping[str, PatternState],
        expected: Mapping[str, Float[np.ndarray, " 4"]],
    ) -> tuple[MapState, dict[str, Float[np.ndarray, " 4"]], bool]:
        """Return the state with patterns that are found again, and whether that closed a loop."""
        seen = {name: one.pose for name, one in again.items()}
        off = max(np.hypot(*(seen[name] - expected[name])[:2]) for name in seen)
        mosaic, tracked, closed = state.mosaic, dict(state.tracked), bool(off > self.rules.gate)
        both = dict(sightings) | seen
        if closed and self.rules.closing == "adjust":
            links = state.links.add(both, centre=self._middle, scale=self.scale)
            mosaic = _adjusted(mosaic, links, next(iter(seen)))
        elif closed and self.rules.closing == "chain":  # what was chained since is let go
            both, tracked = seen, {}
        pose = located(mosaic, both, self.rules.by)
        state = replace(state, mosaic=mosaic, tracked=tracked | dict(again), pose=pose)
        return state, both, closed

    def _make(
        self,
        state: MapState,
        image: np.ndarray,
        sought: "Sought | None",
        sightings: Mapping[str, np.ndarray],
        rng: np.random.Generator,
    ) -> tuple[MapState, dict[str, np.ndarray], tuple[str, ...]]:
        """Return the state with new patterns, where the picture has distinctive windows left."""
        rules, scene = self.rules, sought or self._view.sought(image)
        taken = np.array([one.pose[:2] for one in state.tracked.values()]).reshape(-1, 2)
        windows = scene.windows(rules.windows, taken, rules.border)
        if len(sightings) + len(windows) < 2:
            anything = replace(rules.windows, rival=rules.repeated)
            windows = scene.windows(anything, taken, rules.border)
        patterns, tracked, mosaic = dict(state.patterns), dict(state.tracked), state.mosaic
        seen, new = dict(sightings), []
        for window in windows:
            name = str(len(patterns))
            pattern = pattern_from(
                image, scene.edges, scene.contours, window.centre, window.size, rules.patterns,
                rng=rng,
            )  # fmt: skip
            at = np.array([*window.centre, 0.0, 1.0])
            if not mosaic.poses:  # the first pattern is the frame of the mosaic
                mosaic = mosaic.with_pattern(name, np.zeros(3))
                state = replace(state, pose=located(mosaic, {name: at}, rules.by))
            else:
                there = self._placed(replace(state, mosaic=mosaic), sightings or seen, at)
                mosaic = mosaic.with_pattern(name, there)
            patterns[name], seen[name] = pattern, at
            tracked[name] = PatternTracker(pattern, rules.tracker).start(at)
            new.append(name)
        state = replace(state, mosaic=mosaic, patterns=patterns, tracked=tracked)
        return state, seen, tuple(new)

    def _placed(
        self, state: MapState, known: Mapping[str, np.ndarray], at: np.ndarray
    ) -> Float[np.ndarray, " 3"]:
        """Return the pose in the mosaic of a new pattern, by one that is known or by the pose.

        The second is eq. (3), too: with the pose of eq. (2) from one pattern it is the same.
        """
        by, mosaic, how = self.rules.by, state.mosaic, {"centre": self._middle, "scale": self.scale}
        if by == "all" or not known:
            return compose(state.pose, in_camera(at, **how))
        one = _chosen(mosaic, known, by, at[:2])
        return place(mosaic.poses[one], known[one], at, **how)


@dataclass(frozen=True, eq=False, slots=True)
class Sought:
    """A picture as recognition needs it.

    Parameters
    ----------
    image : (height, width)
        Grey values.
    edges, contours
        Of it.
    field
        Distances to the edges.
    seen : (height, width)
        Which pixels show the ceiling; all of them if not given.
    """

    image: Annotated[UInt8[np.ndarray, "height width"], picture]
    edges: Edges
    contours: Annotated[tuple[Segment | Arc, ...], segments_and_arcs]
    field: EdgeField
    seen: Bool[np.ndarray, "height width"] | None = None
    __post_init__ = checked

    @classmethod
    def of(
        cls,
        image: UInt8[np.ndarray, "height width"],
        rules: ContourRules | None = None,
        seen: Bool[np.ndarray, "height width"] | None = None,
        reach: int = 0,
    ) -> "Sought":
        """Return a picture with its edges and contours.

        Parameters
        ----------
        image : (height, width)
            Grey values.
        rules
            How contours are found.
        seen : (height, width)
            Which pixels show the ceiling; all of them if not given.
        reach
            An edge as near to others, px, is none.

        Raises
        ------
        TypeError
            If an argument is of another type.
        ValueError
            If the image is not (height, width).
        """
        image = picture("image", image)
        _mask(seen, image.shape)
        reach = checks.whole("reach", reach, 0, 10**4)
        edges = find_edges(image, rules)
        if seen is not None:
            around = np.ones((2 * reach + 1, 2 * reach + 1), np.uint8)
            edges = Edges(
                edges.mask & (cv2.erode(seen.astype(np.uint8), around) > 0), edges.gradient
            )
        return cls(image, edges, find_contours(edges, rules), EdgeField(edges), seen)

    def windows(
        self, rules: WindowRules, taken: Float[np.ndarray, "m 2"], border: float
    ) -> tuple[Window, ...]:
        """Return its distinctive windows; none whose middle is near to what it does not show.

        Parameters
        ----------
        rules
            Of `.patterns.interest_windows`.
        taken : (m, 2)
            Centres of windows that are there already, px.
        border
            So near, px.

        Raises
        ------
        TypeError
            If the rules are none.
        ValueError
            If a shape does not fit or the border is negative.
        """
        rules = checks.instance("rules", rules, WindowRules)
        taken = checks.array("taken", taken, ("m", 2))
        border = checks.not_negative("border", border)
        found = interest_windows(self.edges, self.contours, rules, taken=taken)
        if self.seen is None:
            return found
        return tuple(
            one
            for one in found
            if inside(np.array([*one.centre, 0.0, 1.0]), self.image.shape, border, self.seen)
        )


@dataclass(frozen=True, eq=False, slots=True)
class View:
    """Correction of a camera's pictures before patterns are looked for.

    Parameters
    ----------
    correction
        Eq. (1); nothing where the camera is the ideal one.
    rules
        Of the map.
    """

    correction: Correction | None
    rules: MapRules
    __post_init__ = checked

    @property
    def seen(self) -> Bool[np.ndarray, "height width"] | None:
        """Mask of the pixels of the ideal picture that the camera sees, if not all."""
        if self.correction is None or self.correction.seen.all():
            return None
        return self.correction.seen

    def corrected(
        self, image: UInt8[np.ndarray, "height width"]
    ) -> UInt8[np.ndarray, "height width"]:
        """Return the picture of the ideal camera.

        Parameters
        ----------
        image : (height, width)
            Of the robot's camera.

        Raises
        ------
        TypeError
            If it does not hold bytes.
        ValueError
            If it is not (height, width), or of another size than the correction's.
        """
        image = picture("image", image)
        return image if self.correction is None else self.correction.apply(image)

    def sought(self, image: UInt8[np.ndarray, "height width"]) -> Sought:
        """Return a corrected picture with its edges and contours.

        An edge of the ceiling counts if vectors across it end where the camera still sees.

        Parameters
        ----------
        image : (height, width)
            Grey values.

        Raises
        ------
        TypeError
            If it does not hold bytes.
        ValueError
            If it is not (height, width), or of another size than the correction's.
        """
        patterns = self.rules.patterns
        reach = int(np.ceil(patterns.samples // 2 * patterns.step)) + 1
        return Sought.of(image, self.rules.contours, self.seen, reach)

    def trackers(self, patterns: Mapping[str, Pattern]) -> "PatternTrackers":
        """Return the trackers of patterns.

        Parameters
        ----------
        patterns
            By name.

        Raises
        ------
        TypeError
            If one is none.
        """
        return PatternTrackers(patterns, self.rules.tracker, self.rules.border, seen=self.seen)


def _mask(seen: np.ndarray | None, shape: tuple[int | str, ...]) -> None:
    if seen is None:
        return
    if not isinstance(seen, np.ndarray) or seen.dtype != bool:
        raise TypeError(f"seen must be an array of booleans, got {checks.shown(seen)}")
    checks.shaped("seen", seen, shape, beside="this picture")


def _piece(state: MapState, name: str) -> int:
    """Return the number of the piece that has a pattern."""
    return next(k for k, group in enumerate(state.pieces) if name in group)


def _adjusted(mosaic: Mosaic, links: Links, name: str) -> Mosaic:
    """Return a mosaic in which what links join to a pattern is adjusted; the first of it stays.

    A robot that was blind for a while has made patterns that nothing joins to those before.
    """
    joined = next(group for group in links.groups(mosaic.poses) if name in group)
    own = {one: pose for one, pose in mosaic.poses.items() if one in joined}
    fitted = adjust(replace(mosaic, poses=own), links, fixed=next(iter(own)), loss="cauchy")[0]
    return replace(mosaic, poses=mosaic.poses | fitted.poses)


@dataclass(frozen=True, eq=False, slots=True)
class PatternsInfo:
    """Diagnostics of one picture with several patterns.

    Parameters
    ----------
    patterns
        What the tracker of each says, by name.
    lost
        Names of those that were let go.
    """

    patterns: Mapping[str, PatternInfo]
    lost: tuple[str, ...]


@dataclass(frozen=True, eq=False, slots=True)
class PatternTrackers:
    """Follows several patterns, each by a tracker of its own, and lets go what leaves.

    Parameters
    ----------
    patterns
        By name.
    rules
        Of the trackers.
    border
        A pattern whose centre comes closer to the border is let go, px.
    patience
        So is one that is not seen in that many pictures in a row.
    seen : (height, width)
        Which pixels show the ceiling; what does not counts as beyond the border.
    """

    patterns: Mapping[str, Pattern]
    rules: TrackerRules = field(default_factory=TrackerRules)
    border: NotNegative = 0.0
    patience: Annotated[int, from_to(1)] = 3
    seen: Bool[np.ndarray, "height width"] | None = None
    __post_init__ = checked

    def start(self, poses: Mapping[str, Float[np.ndarray, " 4"]]) -> Mapping[str, PatternState]:
        """Return the states of patterns whose places are known.

        Parameters
        ----------
        poses
            (x, y, θ, s) of each, by name.

        Raises
        ------
        ValueError
            If a place is not four numbers with a positive scale, or there is no pattern of its
            name.
        """
        poses = _sightings.sightings("poses", poses)
        self._known("poses", poses)
        return {name: self._tracker(name).start(pose) for name, pose in poses.items()}

    def step(
        self,
        state: Mapping[str, PatternState],
        image: UInt8[np.ndarray, "height width"],
        *,
        rng: np.random.Generator,
    ) -> tuple[Mapping[str, PatternState], PatternsInfo]:
        """Return the states after a picture, without those that were let go.

        Parameters
        ----------
        state
            Before it, by name; patterns that are not named are not looked for.
        image : (height, width)
            Grey values.
        rng
            Source of randomness.

        Raises
        ------
        TypeError
            If an argument is of another type.
        ValueError
            If a state has no pattern, or the image is not of the size of those before.
        """
        checks.entries("state", state, PatternState)
        checks.generator("rng", rng)
        self._known("state", state)
        layers = Layers(image)
        _mask(self.seen, layers.shape)
        steps = {
            name: self._tracker(name).step(one, layers, rng=rng) for name, one in state.items()
        }
        lost = tuple(
            name
            for name, (one, _) in steps.items()
            if one.lost >= self.patience
            or not inside(one.pose, image.shape, self.border, self.seen)
        )
        after = {name: one for name, (one, _) in steps.items() if name not in lost}
        return after, PatternsInfo({name: info for name, (_, info) in steps.items()}, lost)

    def _tracker(self, name: str) -> PatternTracker:
        return PatternTracker(self.patterns[name], self.rules)

    def _known(self, name: str, asked: Mapping[str, Any]) -> None:
        unknown = [one for one in asked if one not in self.patterns]
        if unknown:
            raise ValueError(f"{name} must have patterns, got none for {checks.shown(unknown)}")


def look_for(
    expected: Mapping[str, Float[np.ndarray, " 4"]],
    patterns: Mapping[str, Pattern],
    sought: Sought,
    rules: MapRules,
    *,
    rng: np.random.Generator,
) -> dict[str, PatternState]:
    """Return those of known patterns that are found near the places where they are expected.

    Contours say where a pattern may be. At the best of these places its tracker takes a step, and
    the one at which its grey vectors correlate most is taken, unless the pattern is lost there.

    Parameters
    ----------
    expected
        Places (x, y, θ, s), by name.
    patterns
        By name.
    sought
        The picture.
    rules
        Of recognition and tracking.
    rng
        Source of randomness.

    Raises
    ------
    TypeError
        If an argument is of another type.
    ValueError
        If a place is not four numbers, or there is no pattern of its name.
    """
    expected = _sightings.sightings("expected", expected)
    checks.entries("patterns", patterns, Pattern)
    checks.instance("sought", sought, Sought)
    checks.instance("rules", rules, MapRules)
    checks.generator("rng", rng)
    unknown = [name for name in expected if name not in patterns]
    if unknown:
        raise ValueError(f"expected must have patterns, got none for {checks.shown(unknown)}")
    layers, found = Layers(sought.image), {}
    for name, at in expected.items():
        tracker = PatternTracker(patterns[name], rules.tracker)
        best, tried = -np.inf, 0
        for one in recognise(patterns[name], sought.field, sought.contours, rules.recognition):
            away = np.hypot(*(one.pose - at)[:2])
            if away > rules.search or abs(wrap_angle(one.pose[2] - at[2])) > rules.turn:
                continue
            state, info = tracker.step(tracker.start(one.pose), layers, rng=rng)
            inner = inside(state.pose, layers.shape, rules.border, sought.seen)
            if not info.lost and info.match > best and inner:
                found[name], best = state, info.match
            tried += 1
            if tried == rules.candidates:
                break
    return found


def located(
    mosaic: Mosaic, sightings: Mapping[str, Float[np.ndarray, " 4"]], by: str = "all"
) -> Float[np.ndarray, " 3"]:
    """Return the pose of the camera in a mosaic, by all patterns in view or by one.

    Parameters
    ----------
    mosaic
        Where the patterns are.
    sightings
        Of one image, by names; patterns that the mosaic does not have are left out.
    by
        ``"all"``: `.mosaic.Mosaic.locate`; ``"oldest"``, ``"newest"``, ``"nearest"``: eq. (2) with
        that one, see `MapRules`.

    Returns
    -------
    (3,)
        m and rad.

    Raises
    ------
    NoCommonPattern
        If the mosaic has none of the patterns.
    ValueError
        If a sighting is wrong or the word is none of these.

    References
    ----------
    Section 2.2, eq. (2).
    """
    checks.instance("mosaic", mosaic, Mosaic)
    checks.one_of("by", by, BY)
    if by == "all":
        return mosaic.locate(sightings)[0]
    sightings = _sightings.sightings("sightings", sightings)
    known = {name: at for name, at in sightings.items() if name in mosaic.poses}
    if not known:
        raise NoCommonPattern(
            f"sightings must have a pattern of the mosaic, got {checks.shown([*sightings])}"
        )
    one = _chosen(mosaic, known, by, mosaic.centre)
    there = in_camera(known[one], centre=mosaic.centre, scale=mosaic.scale)
    return camera_pose(mosaic.poses[one], there)


def _chosen(mosaic: Mosaic, known: Mapping[str, np.ndarray], by: str, at: np.ndarray) -> str:
    """Return the name of the pattern by which another, or the camera, is located."""
    if by == "nearest":
        return min(known, key=lambda name: np.hypot(*(known[name][:2] - at)))
    age = {name: k for k, name in enumerate(mosaic.poses)}
    return (min if by == "oldest" else max)(known, key=lambda name: age[name])


def agreeing(
    mosaic: Mosaic, sightings: Mapping[str, Float[np.ndarray, " 4"]], rules: MapRules
) -> tuple[dict[str, Float[np.ndarray, " 4"]], tuple[str, ...]]:
    """Return what `consistent` does, or all sightings where the rules ask for no rigid mosaic.

    Parameters
    ----------
    mosaic
        Where the patterns are.
    sightings
        Of patterns of the mosaic, by name.
    rules
        With the gate.

    Raises
    ------
    TypeError
        If an argument is of another type.
    ValueError
        If a sighting is not four numbers or of no pattern of the mosaic.
    """
    checks.instance("rules", rules, MapRules)
    if not rules.rigid:
        checks.instance("mosaic", mosaic, Mosaic)
        return _sightings.sightings("sightings", sightings), ()
    return consistent(mosaic, sightings, rules.gate)


def consistent(
    mosaic: Mosaic, sightings: Mapping[str, Float[np.ndarray, " 4"]], gate: float
) -> tuple[dict[str, Float[np.ndarray, " 4"]], tuple[str, ...]]:
    """Return the sightings that agree on where the camera is, and the names of the others.

    While three patterns or more are seen, the one that is furthest from where the pose says it is
    goes, if that is further than the gate. Two that contradict each other both stay.

    Parameters
    ----------
    mosaic
        Where the patterns are.
    sightings
        Of patterns of the mosaic, by name.
    gate
        px.

    Raises
    ------
    TypeError
        If an argument is of another type.
    ValueError
        If a sighting is not four numbers or of no pattern of the mosaic, or the gate is negative.
    """
    checks.instance("mosaic", mosaic, Mosaic)
    kept, slid = _sightings.sightings("sightings", sightings), []
    gate = checks.not_negative("gate", gate)
    unknown = [name for name in kept if name not in mosaic.poses]
    if unknown:
        raise ValueError(f"sightings must be of the mosaic, got {checks.shown(unknown)}")
    while len(kept) > 2:
        _, residuals = mosaic.locate(kept)
        off = {name: np.hypot(*miss[:2]) / mosaic.scale for name, miss in residuals.items()}
        worst = max(off, key=lambda name: off[name])
        if off[worst] <= gate:
            break
        del kept[worst]
        slid.append(worst)
    return kept, tuple(slid)


def retrace(
    pieces: Sequence[Mosaic], seen: Sequence[Mapping[str, Float[np.ndarray, " 4"]]], gate: float
) -> tuple[Int[np.ndarray, " n"], Float[np.ndarray, "n 3"]]:
    """Return where the camera was in each picture, by the map that all of them made.

    Parameters
    ----------
    pieces
        Of the map, see `.mosaic.pieces`.
    seen : n of name -> (4,)
        Sightings of each picture, as `MapInfo` has them.
    gate
        Of `consistent`, px.

    Returns
    -------
    (n,)
        In which of the pieces, counted from 0.
    (n, 3)
        Pose in its frame, m and rad.

    Raises
    ------
    TypeError
        If an argument is of another type.
    ValueError
        If nothing was seen in a picture, its patterns are not of one piece, or the gate is
        negative.
    """
    parts = checks.instances("pieces", tuple(checks.iterable("pieces", pieces)), Mosaic)
    whose = {name: k for k, part in enumerate(parts) for name in part.poses}
    numbers, poses = [], []
    for sightings in checks.iterable("seen", seen):
        names = [*checks.instance("seen", sightings, Mapping)]
        own = {whose.get(name) for name in names}
        if len(own) != 1 or None in own:
            raise ValueError(
                f"seen must be patterns of one of the pieces, got {checks.shown(names)}"
            )
        numbers.append(own.pop())
        part = parts[numbers[-1]]
        poses.append(part.locate(consistent(part, sightings, gate)[0])[0])
    return np.array(numbers, dtype=int), np.array(poses).reshape(-1, 3)


def inside(
    place: Float[np.ndarray, " 4"],
    shape: tuple[int, ...],
    border: float,
    seen: Bool[np.ndarray, "height width"] | None = None,
) -> bool:
    """Tell whether a place keeps off the border of a picture by so many px.

    Parameters
    ----------
    place : (4,)
        (x, y, θ, s), px, px, rad and 1.
    shape
        Height and width of the picture.
    border
        px, along rows and columns.
    seen : (height, width)
        Which pixels show the ceiling; from the others, too, it must keep off.

    Raises
    ------
    TypeError
        If what is seen is no array of booleans.
    ValueError
        If the place is not four numbers, the shape not two whole ones, or the border negative.
    """
    x, y = checks.array("place", place, (4,))[:2]
    sides = tuple(checks.whole("shape", side, 1) for side in checks.iterable("shape", shape))
    if len(sides) != 2:
        raise ValueError(f"shape must be height and width, got {checks.shown(sides)}")
    border = checks.not_negative("border", border)
    high, wide = sides
    within = bool(border <= x <= wide - 1 - border and border <= y <= high - 1 - border)
    if seen is None or not within:
        return within
    _mask(seen, sides)
    left, top = math.floor(x - border), math.floor(y - border)
    right, bottom = math.ceil(x + border), math.ceil(y + border)
    return bool(seen[top : bottom + 1, left : right + 1].all())
