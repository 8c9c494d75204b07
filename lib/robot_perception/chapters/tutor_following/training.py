"""The cascade of open hands: how it is trained, and the trained one that the chapter uses.

The paper trains on 2000 pictures of upright hands and 6000 without; ours are rendered. Hands that
are scored, and pictures on which thresholds were chosen, come from other seeds.
"""

import json
from collections.abc import Callable
from dataclasses import asdict, dataclass, field
from functools import cache
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from jaxtyping import UInt8

from data_synth.companion.hands import GESTURES, clutter_picture, hand_window, make_hand
from robot_perception.companion.hands.cascade import (
    Cascade,
    Goals,
    HandDetector,
    StageReport,
    train,
)
from robot_perception.companion.hands.features import SIZE, feature_pool
from robot_perception.evaluation.progress import progress
from robot_perception.files import reading, written
from robot_perception.teaching.records import records

MODEL = "open_hand.json"
TILT = 0.20
"""Standard deviation of the tilt of the hands that it is trained on, rad; ours."""


@dataclass(frozen=True, slots=True)
class Config:
    """What a cascade is trained on.

    Parameters
    ----------
    hands, others
        Windows with a hand, and without one for each stage: the paper's numbers.
    features
        From which each stump is chosen; ours.
    pictures
        Without a hand, from which the others are taken; ours.
    gestures
        Windows of other gestures, of which up to a third of the others are; ours.
    goals
        Of the stages; ours.
    seed
        Of all of them.
    """

    hands: int = 2000
    others: int = 6000
    features: int = 4000
    pictures: int = 700
    gestures: int = 3000
    goals: Goals = field(default_factory=lambda: Goals(most=80))
    seed: int = 20


def hands(count: int, rng: np.random.Generator, tilt: float = TILT) -> UInt8[np.ndarray, "m 24 24"]:
    """Return windows of open hands, upright but for a tilt."""
    return np.stack([
        hand_window(rng, make_hand(rng), tilt=float(np.clip(rng.normal(0, tilt), -0.5, 0.5)))
        for _ in range(count)
    ])  # fmt: skip


def closed(count: int, rng: np.random.Generator) -> UInt8[np.ndarray, "m 24 24"]:
    """Return windows of hands that are not open: fists, and those that point."""
    kinds = [gesture for gesture in GESTURES if gesture != "open"]
    return np.stack([
        hand_window(rng, make_hand(rng, kinds[k % len(kinds)]), tilt=float(rng.normal(0, 0.4)))
        for k in range(count)
    ])  # fmt: skip


class Others:
    """Windows without an open hand that pass a cascade: of pictures, and other gestures."""

    def __init__(
        self, pictures: list[np.ndarray], gestures: np.ndarray, rng: np.random.Generator
    ) -> None:
        self.pictures, self.gestures, self.rng = pictures, gestures, rng

    def __call__(self, cascade: Cascade | None, count: int) -> UInt8[np.ndarray, "k 24 24"]:
        """Return so many windows, or all there are."""
        near = self.gestures
        if cascade is not None:
            near = near[cascade.passed(near) == len(cascade.stages)]
        near = near[self.rng.permutation(len(near))[: count // 3]]
        found, total = [near], len(near)
        for k in self.rng.permutation(len(self.pictures)):
            windows = self._windows(self.pictures[k], 400)
            if cascade is not None:
                windows = _those(self.pictures[k], cascade)
                most = max(count // 25, 40)  # of one picture, so that many count
                windows = windows[self.rng.permutation(len(windows))[:most]]
            else:
                windows = windows[: count // len(self.pictures) + 1]
            found.append(windows)
            total += len(windows)
            if total >= count:
                break
        return np.concatenate(found)[:count]

    def _windows(self, image: np.ndarray, count: int) -> np.ndarray:
        """Return windows of any place and size."""
        found = []
        for _ in range(count // 40):
            side = int(self.rng.uniform(SIZE, 120))
            x = int(self.rng.integers(0, image.shape[1] - side + 1))
            y = int(self.rng.integers(0, image.shape[0] - side + 1))
            found.append(_cut(image, x, y, side))
        return np.stack(found)


def _cut(image: np.ndarray, x: int, y: int, side: int) -> np.ndarray:
    inside = np.ascontiguousarray(image[y : y + side, x : x + side])
    return cv2.resize(inside, (SIZE, SIZE), interpolation=cv2.INTER_AREA)


def _those(image: np.ndarray, cascade: Cascade) -> np.ndarray:
    """Return the windows of a picture that pass a cascade, as its detector sees them."""
    boxes, _ = HandDetector(cascade, neighbours=0).windows(image)
    cut = [_cut(image, *(int(n) for n in box[:3])) for box in np.floor(boxes)]
    if not cut:
        return np.zeros((0, SIZE, SIZE), dtype=np.uint8)
    windows = np.stack(cut)
    return windows[cascade.passed(windows) == len(cascade.stages)]


def trained(
    config: Config | None = None, told: Callable[[StageReport], None] = lambda report: None
) -> tuple[Cascade, tuple[StageReport, ...]]:
    """Train a cascade on rendered hands and rooms."""
    config = Config() if config is None else config
    parts = np.random.default_rng(config.seed).spawn(5)
    positive = hands(config.hands, parts[0])
    pictures = [clutter_picture(parts[1]) for _ in progress(range(config.pictures), "pictures")]
    pool = feature_pool(parts[2], config.features)
    return train(
        positive,
        Others(pictures, closed(config.gestures, parts[4]), parts[3]),
        pool,
        count=config.others,
        goals=config.goals,
        told=told,
    )


def write(file: Path, cascade: Cascade, reports: tuple[StageReport, ...], config: Config) -> None:
    """Write a model as JSON, a line a feature and a stage."""
    plain: dict[str, Any] = cascade.to_plain()
    plain["trained"] = {
        "hands": config.hands,
        "others": config.others,
        "seed": config.seed,
        "stages": [asdict(report) for report in reports],
    }
    lists = ("features", "stages")
    head = {k: v for k, v in plain.items() if k not in lists}
    body = "".join(
        f',\n "{name}": [\n' + ",\n".join("  " + json.dumps(x) for x in plain[name]) + "\n ]"
        for name in lists
    )
    text = json.dumps(head, indent=1)[:-2] + body + "\n}\n"
    with written(file) as beside:
        beside.write_text(text, encoding="utf-8")


@cache
def model() -> Cascade:
    """Return the trained cascade of the book."""
    return Cascade.from_plain(plain_model())


def plain_model() -> dict[str, Any]:
    """Return the stored model, with the report of its training."""
    file = records() / MODEL
    with reading(file, "no trained model; `robot-perception hands --write` trains one"):
        return json.loads(file.read_text(encoding="utf-8"))
