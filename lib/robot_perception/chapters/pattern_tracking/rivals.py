"""Other ways to find the patch, told the same: the first picture, where it was, how far it goes.

None of them knows the truth. They may use `REACH` σ of the random walk to each side.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from itertools import product

import cv2
import numpy as np
from jaxtyping import Float, UInt8

from robot_perception.ceiling.patterns import Pattern
from robot_perception.ceiling.tracker import PatternTracker, TrackerRules
from robot_perception.chapters.pattern_tracking.scene import RULES, SIGMAS, START, WINDOW

REACH = 3.0
"""σ to each side."""
Image = UInt8[np.ndarray, "rows columns"]


@dataclass(frozen=True, eq=False, slots=True)
class Task:
    """What a tracker is given.

    Parameters
    ----------
    pattern
        Of the patch.
    first
        The first picture, in which the patch lies at the start.
    pictures
        Those that follow.
    """

    pattern: Pattern
    first: Image
    pictures: tuple[Image, ...]


Method = Callable[[Task, np.random.Generator], Float[np.ndarray, " 4"]]


def condensation(rules: TrackerRules = RULES, pictures: int = 1) -> Method:
    """Return the paper's tracker, which may look at the first few pictures."""

    def find(task: Task, rng: np.random.Generator) -> Float[np.ndarray, " 4"]:
        tracker = PatternTracker(task.pattern, rules)
        state = tracker.start(START)
        for image in task.pictures[:pictures]:
            state, _ = tracker.step(state, image, rng=rng)
        return state.pose

    return find


def templates(task: Task, rng: np.random.Generator) -> Float[np.ndarray, " 4"]:
    """Return the best place of the window, to a pixel, turned and scaled in steps of 0.7 σ."""
    reach = np.rint(REACH * SIGMAS[:2]).astype(int)
    steps = 0.7 * np.arange(-4, 5)
    best, found = -np.inf, START
    for turn, scale in product(steps * SIGMAS[2], START[3] + steps * SIGMAS[3]):
        template = warped(task.first, float(turn), float(scale))
        size = np.array(template.shape[::-1])
        corner = np.rint(START[:2] - (size - 1) / 2).astype(int)
        (left, top), (right, bottom) = corner - reach, corner + size + reach
        score = cv2.matchTemplate(
            task.pictures[0][top:bottom, left:right], template, cv2.TM_CCOEFF_NORMED
        )
        _, highest, _, at = cv2.minMaxLoc(score)
        if highest > best:
            best, found = highest, np.array([*(START[:2] + at - reach), turn, scale])
    return found


def warped(image: Image, turn: float, scale: float) -> UInt8[np.ndarray, "high wide"]:
    """Return the window at the start, as it looks when it is turned and scaled about its middle.

    The corners that a turn brings in are taken from round the window.
    """
    size = np.rint(np.array(WINDOW) * scale / 2).astype(int) * 2 + 1
    cos, sin = np.cos(turn) / scale, np.sin(turn) / scale
    back = np.array([[cos, sin], [-sin, cos]])  # from the template to the picture
    shift = START[:2] - back @ ((size - 1) / 2)
    flags = cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP
    return cv2.warpAffine(image, np.column_stack([back, shift]), tuple(size.tolist()), flags=flags)


def alignment(task: Task, rng: np.random.Generator) -> Float[np.ndarray, " 4"]:
    """Return where ECC aligns the window, from where it was: an affine motion, its nearest turn."""
    half = WINDOW[0] // 2
    left, top = (START[:2] - half).astype(int)
    template = task.first[top : top + WINDOW[1], left : left + WINDOW[0]]
    start = np.array([[1, 0, left], [0, 1, top]], dtype=np.float32)
    rules = cv2.TERM_CRITERIA_EPS | cv2.TERM_CRITERIA_COUNT, 100, 1e-4
    try:
        _, motion = cv2.findTransformECC(
            template, task.pictures[0], start, cv2.MOTION_AFFINE, rules, None, 5
        )
    except cv2.error:  # it says that it does not converge
        return START
    return _pose(motion, START[:2] - [left, top])


def flow(task: Task, rng: np.random.Generator) -> Float[np.ndarray, " 4"]:
    """Return where the pattern's points flow (Lucas and Kanade), by the similarity of most."""
    points = task.pattern.seen(START).astype(np.float32)[:, None]
    after, found, _ = cv2.calcOpticalFlowPyrLK(
        task.first, task.pictures[0], points, None, winSize=(21, 21), maxLevel=3
    )
    good = found.ravel() == 1
    if good.sum() < 3:
        return START
    cv2.setRNGSeed(int(rng.integers(2**31)))
    motion, _ = cv2.estimateAffinePartial2D(points[good], after[good])
    return START if motion is None else _pose(motion, START[:2])


def _pose(motion: Float[np.ndarray, "2 3"], centre: np.ndarray) -> Float[np.ndarray, " 4"]:
    """Return where a motion takes the window's middle, and how far it turns and grows."""
    turn = np.arctan2(motion[1, 0] - motion[0, 1], motion[0, 0] + motion[1, 1])
    scale = np.sqrt(abs(np.linalg.det(motion[:, :2])))
    return np.array([*(motion @ [*centre, 1.0]), turn, scale])


METHODS: Mapping[str, Method] = {
    "one picture": condensation(),
    "three pictures": condensation(pictures=3),
    "5000 particles": condensation(replace(RULES, particles=5000)),
    "template matching": templates,
    "ECC": alignment,
    "optical flow": flow,
}
"""Who is compared, by name: the paper's tracker with one and three pictures and with more
particles, and OpenCV's."""
