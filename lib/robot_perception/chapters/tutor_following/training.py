"""The training of the detector of open hands: 2000 rendered hands against 6000 other windows.

``robot-perception hands --write`` runs it and stores the cascade as JSON, with what each stage
reached; the chapter reads that file.
"""

import json
from collections.abc import Callable
from dataclasses import asdict, dataclass
from functools import lru_cache, partial
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
from robot_perception.files import DamagedFile, reading, written
from robot_perception.teaching.records import records

SEED = 28
"""Of the training. The rendered hands that are scored have seeds of their own."""
GOALS = Goals(stages=13, most=80)
"""Each stage keeps 99.5 % of the hands and lets half of the others pass, with 80 features at most;
ours."""


@dataclass(frozen=True, slots=True)
class Config:
    """What the detector is trained on.

    Parameters
    ----------
    hands, others
        Windows with upright hands, and without, for each stage: section III names 2000 and 6000.
    features
        Drawn at random, from which boosting chooses; ours.
    pictures
        Rooms in which windows without a hand are looked for; ours.
    gestures
        Windows with fists, pointing fingers and hands on their side among the others; ours.
    tilt
        Standard deviation of the tilt of the hands, rad; ours: "upright" is not exact.
    goals
        Of the stages; ours.
    """

    hands: int = 2000
    others: int = 6000
    features: int = 4000
    pictures: int = 900
    gestures: int = 3000
    tilt: float = 0.10
    goals: Goals = GOALS


BRIEF = Config(150, 300, 400, 20, 60, goals=Goals(stages=2, most=10))
"""A training of seconds, to try it."""


@dataclass(frozen=True, eq=False, slots=True)
class Trained:
    """A cascade and what its stages reached."""

    cascade: Cascade
    stages: tuple[StageReport, ...]


def trained(
    config: Config, rng: np.random.Generator, told: Callable[[StageReport], None] = lambda _: None
) -> Trained:
    """Train a detector of open hands; some seven minutes of one processor."""
    hands_rng, others_rng, pool_rng = rng.spawn(3)
    hands = np.array(
        [
            hand_window(hands_rng, make_hand(hands_rng), tilt=hands_rng.normal(0, config.tilt))
            for _ in range(config.hands)
        ]
    )
    pictures = [clutter_picture(others_rng) for _ in range(config.pictures)]
    gestures = np.array([_gesture(others_rng) for _ in range(config.gestures)])
    others = partial(_others, pictures=pictures, gestures=gestures, rng=others_rng)
    pool = feature_pool(pool_rng, config.features)
    found = train(hands, others, pool, count=config.others, goals=config.goals, told=told)
    return Trained(*found)


def _gesture(rng: np.random.Generator) -> UInt8[np.ndarray, "24 24"]:
    """Return a window with a hand that is not open, or not upright."""
    gesture = str(rng.choice(GESTURES))
    away = gesture == "open"
    tilt = rng.choice([-1, 1]) * rng.uniform(1.2, np.pi) if away else rng.normal(0, 0.4)
    return hand_window(rng, make_hand(rng, gesture), tilt=float(tilt))


def _others(
    cascade: Cascade | None,
    count: int,
    *,
    pictures: list[np.ndarray],
    gestures: UInt8[np.ndarray, "m 24 24"],
    rng: np.random.Generator,
) -> UInt8[np.ndarray, "k 24 24"]:
    """Return windows without an open hand that a cascade lets pass, or any if there is none."""
    if cascade is None:
        some = [window(pictures[rng.integers(len(pictures))], rng) for _ in range(count // 2)]
        return np.concatenate([np.array(some), rng.permutation(gestures)[: count - count // 2]])
    hard = gestures[cascade.passed(gestures) == len(cascade.stages)][: count // 2]
    wanted, found = count - len(hard), []
    detector = HandDetector(cascade, scale=1.12, step=1, neighbours=0)
    for at in rng.permutation(len(pictures)):
        boxes = rng.permutation(detector.windows(pictures[at])[0])[:60]
        found += [_cut(pictures[at], box) for box in boxes]
        if len(found) >= wanted:
            break
    windows = np.array(found[:wanted], dtype=np.uint8).reshape(-1, SIZE, SIZE)
    windows = windows[cascade.passed(windows) == len(cascade.stages)]
    return np.concatenate([windows, hard])


def window(picture: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """Return a square of any size of a picture, as small as the detector's window."""
    side = round(float(np.exp(rng.uniform(np.log(SIZE), np.log(min(picture.shape))))))
    low = rng.integers(0, np.array(picture.shape[::-1]) - side + 1)
    return _cut(picture, np.array([*low, side, side]))


def _cut(picture: np.ndarray, box: np.ndarray) -> np.ndarray:
    """Return a square of a picture, as small as the detector's window."""
    left, top, side = np.rint(box[:3]).astype(int)
    inside = np.ascontiguousarray(picture[top : top + side, left : left + side])
    return cv2.resize(inside, (SIZE, SIZE), interpolation=cv2.INTER_AREA)


def model_file() -> Path:
    """Return where the trained detector is stored."""
    return records() / "open_hand.json"


def write(found: Trained, file: Path) -> None:
    """Store a cascade as JSON, a line a feature and a line a stage."""
    plain: dict[str, Any] = found.cascade.to_plain()
    plain["training"] = [
        {k: round(v, 4) for k, v in asdict(report).items()} for report in found.stages
    ]
    parts = []
    for name, value in plain.items():
        text = json.dumps(value)
        if isinstance(value, list):
            rows = ",\n  ".join(json.dumps(row, separators=(",", ":")) for row in value)
            text = f"[\n  {rows}\n ]"
        parts.append(f' "{name}": {text}')
    with written(file) as beside:
        beside.write_text("{\n" + ",\n".join(parts) + "\n}\n", encoding="utf-8")


def read(file: Path) -> Trained:
    """Read what `write` has stored.

    Raises
    ------
    robot_perception.files.DamagedFile
        If it is no JSON, of another version, or something is missing.
    """
    with reading(file, "no trained detector"):
        plain = json.loads(file.read_text(encoding="utf-8"))
    try:
        reports = tuple(StageReport(**report) for report in plain["training"])
        return Trained(Cascade.from_plain(plain), reports)
    except (ValueError, KeyError, TypeError) as error:
        raise DamagedFile(f"{file}: {error}") from error


@lru_cache(maxsize=1)
def stored() -> Trained:
    """Return the detector of the book."""
    return read(model_file())
