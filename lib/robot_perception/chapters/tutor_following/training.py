"""The trained detectors of open hands, stored as JSON with what each stage reached.

``robot-perception hands --write`` trains one as the notebook has it, and stores it; the second one
is trained with ``--others`` for the recordings ``people_video`` and ``faces_orl``.
"""

import json
from dataclasses import asdict, dataclass
from functools import lru_cache
from pathlib import Path

import cv2
import numpy as np

from robot_perception.companion.hands.cascade import Cascade, StageReport
from robot_perception.datasets import picture_files, read_image, read_video
from studies.files import DamagedFile, reading
from studies.records import records
from studies.stored.plain import write_json


@dataclass(frozen=True, eq=False, slots=True)
class Trained:
    """A cascade and what its stages reached."""

    cascade: Cascade
    stages: tuple[StageReport, ...]


RENDERED, PHOTOGRAPHED = "open_hand", "open_hand_photographs"
"""Names of the models: of rendered pictures alone, and of photographs without hands as well."""
FILMS = {".avi", ".mp4", ".mkv", ".mov", ".webm"}
EVERY = 4
"""Pictures of a film from one that is taken to the next: those between show the same."""
TALL = 320
"""Pictures that are not half so large, px, are taken a second time, enlarged to that."""


def model_file(name: str = RENDERED) -> Path:
    """Return where a trained detector is stored."""
    return records() / f"{name}.json"


def photographs(folder: Path) -> tuple[list[np.ndarray], int]:
    """Return the grey values of a folder's pictures and films, and how many files are neither.

    Those of the folders in it, too.

    Raises
    ------
    ValueError
        If there are no pictures and no films.
    robot_perception.datasets.CorruptImage
        If one is damaged.
    """
    found, skipped = [], 0
    for each in [folder, *sorted(path for path in folder.rglob("*") if path.is_dir())]:
        pictures, others = picture_files(each)
        films = [file for file in others if file.suffix.lower() in FILMS]
        skipped += sum(file.is_file() for file in others) - len(films)
        found += map(read_image, pictures)
        for film in films:
            some = [image for k, image in enumerate(read_video(film)) if not k % EVERY]
            found += [cv2.cvtColor(image, cv2.COLOR_RGB2GRAY) for image in some]
    if not found:
        raise ValueError(f"{folder} has no pictures and no films")
    tall = [TALL / max(image.shape) for image in found]
    return found + [
        cv2.resize(image, None, fx=scale, fy=scale)
        for image, scale in zip(found, tall, strict=True)
        if scale > 2
    ], skipped


def write(found: Trained, file: Path) -> None:
    """Store a cascade as JSON, a line a feature and a line a stage."""
    reports = [{k: round(v, 4) for k, v in asdict(report).items()} for report in found.stages]
    write_json(file, found.cascade.to_plain() | {"training": reports})


def read(file: Path) -> Trained:
    """Read what `write` has stored.

    Raises
    ------
    studies.files.DamagedFile
        If it is no JSON, of another version, or something is missing.
    """
    with reading(file, "no trained detector"):
        plain = json.loads(file.read_text(encoding="utf-8"))
    try:
        reports = tuple(StageReport(**report) for report in plain["training"])
        return Trained(Cascade.from_plain(plain), reports)
    except (ValueError, KeyError, TypeError) as error:
        raise DamagedFile(f"{file}: {error}") from error


@lru_cache(maxsize=2)
def stored(name: str = RENDERED) -> Trained:
    """Return a detector of the book."""
    return read(model_file(name))
