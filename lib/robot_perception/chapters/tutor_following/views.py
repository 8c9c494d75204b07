"""What explorers, figures and the film show: a visit, a film of a walk, and one raised hand."""

from dataclasses import dataclass
from functools import lru_cache
from itertools import product

import cv2
import numpy as np
from jaxtyping import Bool, Float, Int, UInt8

from data_synth.companion.hands import clutter_picture, hand_window, make_hand
from robot_perception.chapters.tutor_face.scene import CHOOSING
from robot_perception.chapters.tutor_following import walking
from robot_perception.chapters.tutor_following.scene import FACES, RULES, SAME, Shot, hands, shot
from robot_perception.chapters.tutor_following.training import stored, window
from robot_perception.chapters.tutor_following.visiting import Kind, Moment, moments
from robot_perception.companion.boxes import overlap_in_pairs
from robot_perception.companion.hands.features import SIZE, feature_pool, feature_values
from robot_perception.companion.tutor import TutorRules, TutorTracker
from robot_perception.teaching.recorded import recorded

VISIT = CHOOSING[2]
"""Seed of the visit that is shown; none that is scored."""
WALK = CHOOSING[5]
"""Seed of the walk that is shown."""
TIMES = (0, 15, 25, 30, 35, 40, 45, 50, 55, 60, 65, 70, 80, 89)
"""Pictures of the walk that can be looked at."""
PATCHES = {"one": walking.ONE, "four and a silhouette": walking.SEVERAL}
LEARNING = {
    "never": TutorRules(rate=0.0, **walking.FREE),
    "slowly": TutorRules(rate=0.05, **walking.FREE),
    "fast": TutorRules(rate=0.2, **walking.FREE),
    "slowly, gated": RULES,
}
"""How a model takes in what is seen: α is 0, 0.05, 0.2, or 0.05 where the colours fit."""


@recorded("following-visit")
def visited() -> tuple[Moment, ...]:
    """Return the visit that is shown, picture by picture."""
    return tuple(moments(VISIT, Kind()))


@lru_cache(maxsize=1)
def ordered() -> Moment:
    """Return the last picture before it follows in which face and hand are found and known."""
    shown = visited()
    start = next(k for k, one in enumerate(shown) if one.state == "follow")
    idle = (one for one in reversed(shown[:start]) if one.state == "idle")
    return next(one for one in idle if one.held is not None and len(one.hands))


@lru_cache(maxsize=1)
def greeting() -> tuple[Shot, Float[np.ndarray, "n 4"], Float[np.ndarray, "m 4"]]:
    """Return a picture of somebody with a raised hand, and the faces and hands that are found."""
    one = shot(np.random.default_rng(CHOOSING[12]))
    return one, FACES.find(one.grey), hands().find(one.grey)


@dataclass(frozen=True, eq=False, slots=True)
class Followed:
    """A tracker on the walk that is shown.

    Parameters
    ----------
    image : (240, 320, 3)
        The picture.
    truth, box : (4,)
        The person, and where the tracker has him.
    overlaps : (n,)
        Of box and person in each picture of the walk.
    time
        Which picture it is.
    """

    image: UInt8[np.ndarray, "240 320 3"]
    truth: Float[np.ndarray, " 4"]
    box: Float[np.ndarray, " 4"]
    overlaps: Float[np.ndarray, " n"]
    time: int

    @property
    def held(self) -> bool:
        """Whether the person is still followed at the end of the walk."""
        return walking.locked(self.overlaps)

    def words(self) -> str:
        """Return what the drawing shows."""
        there = "on the person" if self.overlaps[self.time] >= SAME else "off the person"
        end = "still followed" if self.held else "lost"
        return f"Picture {self.time}: the tracker is {there}. At the end the person is {end}."


@recorded("following-boxes", product(PATCHES, LEARNING))
def boxes(patches: str, learning: str) -> Float[np.ndarray, "n 4"]:
    """Return where a tracker has the person in each picture of the walk that is shown."""
    shown, rng = walking.film(WALK, "long, whole"), np.random.default_rng([WALK, 1])
    tracker = TutorTracker(PATCHES[patches], LEARNING[learning])
    state = tracker.start(shown.frames[0], shown.boxes[0], rng=rng)
    found = [state.box]
    for image in shown.frames[1:]:
        state, _ = tracker.step(state, image, rng=rng)
        found.append(state.box)
    return np.array(found)


@lru_cache(maxsize=128)
def followed(patches: str, learning: str, time: int) -> Followed:
    """Return a picture of the walk with what a tracker makes of it."""
    shown, found = walking.film(WALK, "long, whole"), boxes(patches, learning)
    overlaps = overlap_in_pairs(found, shown.boxes)
    return Followed(shown.frames[time], shown.boxes[time], found[time], overlaps, time)


STEP = 5
"""From each place of the dragged window to the next, px."""
ACROSS, DOWN = tuple(range(0, 12 * STEP, STEP)), tuple(range(0, 10 * STEP, STEP))


@dataclass(frozen=True, eq=False, slots=True)
class Raised:
    """A raised hand and what is about it.

    Parameters
    ----------
    part : (rows, columns)
        Of the grey picture.
    side
        Of the window, px.
    best : (2,)
        Where the window's corner is when it is at the hand.
    """

    part: UInt8[np.ndarray, "rows columns"]
    side: int
    best: Int[np.ndarray, " 2"]


@lru_cache(maxsize=1)
def raised() -> Raised:
    """Return the part of a picture round a raised hand."""
    one = greeting()[0]
    left, top, side, _ = np.rint(one.hand).astype(int)
    best = np.array([ACROSS[5], DOWN[4]])
    u, v = left - best[0], top - best[1]
    wide, high = ACROSS[-1] + side, DOWN[-1] + side
    return Raised(one.grey[max(v, 0) : v + high, max(u, 0) : u + wide], int(side), best)


@dataclass(frozen=True, eq=False, slots=True)
class Windowed:
    """A window and what the stages say of it.

    Parameters
    ----------
    part : (rows, columns)
        Of the picture.
    x, y, side
        Of the window in it, px.
    window : (24, 24)
        As the cascade sees it.
    margins : (stages,)
        Votes above the threshold of each stage, as a share of all votes.
    passed
        How many stages it passes.
    """

    part: UInt8[np.ndarray, "rows columns"]
    x: int
    y: int
    side: int
    window: UInt8[np.ndarray, "24 24"]
    margins: Float[np.ndarray, " stages"]
    passed: int

    def words(self) -> str:
        """Return what the drawing shows."""
        count = len(self.margins)
        end = "It is taken for an open hand." if self.passed == count else "It is rejected."
        return f"The window passes {self.passed} of {count} stages. {end}"


@lru_cache(maxsize=128)
def windowed(x: int, y: int) -> Windowed:
    """Return what the cascade says of a window of the picture."""
    shown, cascade = raised(), stored().cascade
    inside = np.ascontiguousarray(shown.part[y : y + shown.side, x : x + shown.side])
    window = cv2.resize(inside, (SIZE, SIZE), interpolation=cv2.INTER_AREA)
    values = feature_values(window[None], cascade.features)
    margins = [
        (stage.stumps.scores(values)[0] - stage.threshold) / stage.stumps.votes.sum()
        for stage in cascade.stages
    ]
    passed = int(cascade.passed(window[None])[0])
    return Windowed(shown.part, x, y, shown.side, window, np.array(margins), passed)


@lru_cache(maxsize=1)
def example() -> UInt8[np.ndarray, "72 72"]:
    """Return an open hand, three times as fine as the cascade sees it."""
    rng = np.random.default_rng(CHOOSING[0])
    return hand_window(rng, make_hand(rng, tone=1), size=3 * SIZE, jitter=0.0)


@lru_cache(maxsize=1)
def samples() -> tuple[Float[np.ndarray, "features windows"], Bool[np.ndarray, " windows"]]:
    """Return the values of 1000 features on 300 windows of each kind, and which are of hands."""
    rng = np.random.default_rng(CHOOSING[0])
    shown = [hand_window(rng, make_hand(rng), tilt=rng.normal(0, 0.1)) for _ in range(300)]
    rooms = [clutter_picture(rng) for _ in range(10)]
    others = [window(rooms[k % 10], rng) for k in range(300)]
    values = feature_values(np.array([*shown, *others]), feature_pool(rng, 1000))
    return values, np.arange(600) < 300
