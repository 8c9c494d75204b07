"""Real hands before rendered rooms, and a real head followed by patches of colour."""

from dataclasses import dataclass
from functools import partial
from pathlib import Path
from types import MappingProxyType

import cv2
import numpy as np
from jaxtyping import Float, Int64

from data_synth.companion.canvas import lay, photograph, room
from robot_perception.chapters.tutor_face.scene import CHOOSING
from robot_perception.chapters.tutor_following.scene import FREE, RULES, SAME, hands
from robot_perception.chapters.tutor_following.training import PHOTOGRAPHED, RENDERED
from robot_perception.companion.boxes import overlap_in_pairs
from robot_perception.companion.tutor import TutorModel, TutorRules, TutorTracker
from robot_perception.datasets import read_boxes, read_image, read_images
from robot_perception.evaluation.intervals import Interval, proportion
from robot_perception.teaching.recordings import Recording

ROOMS = 40
"""Rendered rooms into which each hand is put."""
OPEN = "5_P"
"""The gesture of the one open hand among the photographs; its fingers point to the right."""
QUARTER = -90.0
"""Degrees by which it is turned, so that the fingers point upwards."""
TILTS = (0.0, 15.0, 30.0, 45.0)
HEIGHTS = (70.0, 150.0)
"""Of the photograph in the picture, px: least and most."""


@dataclass(frozen=True, eq=False, slots=True)
class Hands:
    """What the detector makes of photographs of hands.

    Parameters
    ----------
    gestures : (n,)
        Of the photographs, the open hand left out.
    taken : (n,)
        Rooms in which that hand is taken for an open one.
    found : (tilts,)
        Rooms in which the open hand is found.
    """

    gestures: tuple[str, ...]
    taken: Int64[np.ndarray, " n"]
    found: Int64[np.ndarray, " tilts"]


def gestures(folder: Path) -> Hands:
    """Put each hand into rendered rooms and look for open ones."""
    files = sorted(folder.glob("*.jpg"))
    others = [file for file in files if not file.name.startswith(OPEN)]
    (shown,) = (file for file in files if file.name.startswith(OPEN))
    taken = [_found(read_image(file, colour=True), 0.0) for file in others]
    image = read_image(shown, colour=True)
    found = [_found(image, QUARTER + tilt) for tilt in TILTS]
    return Hands(tuple(file.name[:3] for file in others), np.array(taken), np.array(found))


def _found(image: np.ndarray, degrees: float) -> int:
    """Return in how many rooms the detector finds an open hand where the photograph is."""
    light = (image / 255.0) ** 2.2
    cover = cv2.GaussianBlur((image.max(axis=2) > 24).astype(np.float32), (0, 0), 1.0)
    sprite = np.dstack([light, cover]).astype(np.float32)
    hits = 0
    for k in range(ROOMS):
        rng = np.random.default_rng([CHOOSING[0], k])
        tall = float(rng.uniform(*HEIGHTS))
        canvas = room((200, 200), rng=rng, clutter=10)
        lay(canvas, sprite, (99.5, 99.5), tall, angle=np.radians(degrees))
        grey = cv2.cvtColor(photograph(canvas, rng=rng), cv2.COLOR_RGB2GRAY)
        boxes = hands().find(grey)
        off = np.abs(boxes[:, :2] + boxes[:, 2:] / 2 - 99.5)
        hits += int((off < tall / 2).all(axis=1).any())
    return hits


HEAD = np.array([[-0.4, -0.5, 0.8, 1.0]])
"""One patch for a head."""
QUARTERS = np.array([[u, v, 0.4, 0.5] for u in (-0.4, 0.0) for v in (-0.5, 0.0)])
"""Four for its quarters."""
HEADS = {
    "one patch, adapting": TutorTracker(TutorModel(HEAD, None), TutorRules(**FREE)),
    "one patch, fixed": TutorTracker(TutorModel(HEAD, None), TutorRules(rate=0.0, **FREE)),
    "four, adapting": TutorTracker(TutorModel(QUARTERS, None), TutorRules(**FREE)),
    "four, gated": TutorTracker(TutorModel(QUARTERS, None), RULES),
    "four, fixed": TutorTracker(TutorModel(QUARTERS, None), TutorRules(rate=0.0, **FREE)),
}
LAST = 10
"""Pictures at the end of the recording that say whether the head is still followed; ours."""
RUNS = 10
"""Each tracker follows the head so many times, with other particles."""


@dataclass(frozen=True, eq=False, slots=True)
class Girl:
    """A real head that turns round, followed by patches.

    Parameters
    ----------
    trackers
        Their names.
    near : (trackers, runs)
        Share of the pictures in which box and head overlap by ``SAME``.
    held : (trackers, runs)
        Whether they do at the end.
    """

    trackers: tuple[str, ...]
    near: Float[np.ndarray, "trackers runs"]
    held: Float[np.ndarray, "trackers runs"]


def girl(folder: Path) -> Girl:
    """Follow the head through the recording, several times by each tracker."""
    pictures = read_images(folder / "img", "*.jpg", colour=True)
    boxes = read_boxes(folder / "groundtruth_rect.csv", pictures.numbers).boxes
    frames = list(pictures)
    rows = []
    for tracker in HEADS.values():
        runs = [_followed(tracker, frames, boxes, np.random.default_rng(k)) for k in range(RUNS)]
        rows.append([(np.mean(run >= SAME), np.median(run[-LAST:]) >= SAME) for run in runs])
    near, held = np.moveaxis(np.array(rows, dtype=float), -1, 0)
    return Girl(tuple(HEADS), near, held)


def _followed(
    tracker: TutorTracker, frames: list[np.ndarray], boxes: np.ndarray, rng: np.random.Generator
) -> Float[np.ndarray, " n"]:
    """Return how far the tracked head overlaps the true one in each picture."""
    state = tracker.start(frames[0], boxes[0], rng=rng)
    found = [boxes[0]]
    for image in frames[1:]:
        state, _ = tracker.step(state, image, rng=rng)
        x, y, _, s = state.estimate
        left, top, wide, high = HEAD[0] * s
        found.append(np.array([x + left, y + top, wide, high]))
    return overlap_in_pairs(np.array(found), boxes)


LONGEST = 320
"""Longest side to which a photograph is brought, px: that of the robot's pictures."""


@dataclass(frozen=True, eq=False, slots=True)
class Alarms:
    """Open hands that the detector sees in photographs without one.

    Parameters
    ----------
    counts : (n,)
        In each photograph, by the detector that was trained on rendered pictures.
    fewer : (n,)
        By the one that was trained on photographs, too, of other recordings.
    """

    counts: Int64[np.ndarray, " n"]
    fewer: Int64[np.ndarray, " n"]

    def share(self) -> Interval:
        """Return the share of the photographs with an alarm."""
        return _share(self.counts)

    def row(self) -> list:
        """Return how many photographs there are, and the shares with an alarm by both."""
        return [len(self.counts), self.share(), _share(self.fewer)]


def _share(counts: np.ndarray) -> Interval:
    """Return the share of the photographs with an alarm."""
    return proportion(int((counts > 0).sum()), len(counts))


def alarms(folder: Path, pattern: str, every: int = 1) -> Alarms:
    """Look for open hands in every so many photographs of a recording that shows none."""
    counts = []
    detectors = hands(RENDERED), hands(PHOTOGRAPHED)
    for file in sorted(folder.glob(pattern))[::every]:
        image = read_image(file)
        scale = LONGEST / max(image.shape)
        size = round(image.shape[1] * scale), round(image.shape[0] * scale)
        way = cv2.INTER_AREA if scale < 1 else cv2.INTER_LINEAR
        shown = cv2.resize(image, size, interpolation=way)
        counts.append([len(detector.find(shown)) for detector in detectors])
    return Alarms(*np.array(counts, dtype=np.int64).reshape(-1, len(detectors)).T)


def _handless(dataset: str, pattern: str, store: str, every: int = 1) -> Recording[Alarms]:
    """Return what the detector makes of the photographs of a recording that shows no hand."""
    return Recording(dataset, partial(alarms, pattern=pattern, every=every), Alarms, store)


IN_FACES = _handless("faces_yale", "*.png", "handless-faces")
IN_HEADS = _handless("head_girl", "img/*.jpg", "handless-girl", every=10)
IN_STREETS = _handless("kitti_stereo_straight", "image_l/*.png", "handless-street")
IN_HALLS = _handless("euroc_static_stereo", "cam*/*.png", "handless-hall")
HANDLESS = MappingProxyType(
    {"faces": IN_FACES, "a girl's head": IN_HEADS, "a street": IN_STREETS, "a hall": IN_HALLS}
)
"""By what the photographs show."""
PHOTOGRAPHS = Recording("hands_hgr1", gestures, Hands, "hands-hgr1")
GIRL = Recording("head_girl", girl, Girl, "girl-patches")
