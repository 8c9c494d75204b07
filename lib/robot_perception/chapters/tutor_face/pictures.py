"""Real faces as grey pictures, for descriptions that need more of them than their distances."""

from pathlib import Path

import numpy as np

from robot_perception.companion.boxes import crop
from robot_perception.companion.faces.detection import FaceDetector
from robot_perception.datasets import read_image

Pictures = tuple[list[int], list[str], list[np.ndarray]]
"""Person of each picture, its name among those of the person, and its grey values, 0 to 1."""


def in_even_light(folder: Path) -> Pictures:
    """Read the pictures of `recordings.ORL_POINTS`: twenty people, cut out by hand."""
    files = sorted(folder.glob("s*/*.png"))
    people = [int(file.parent.name[1:]) for file in files]
    return people, [file.stem for file in files], [read_image(file) / 255.0 for file in files]


def in_many_lights(folder: Path) -> Pictures:
    """Read the pictures of `recordings.YALE_POINTS`: eight people, cut out by the detector."""
    detector, files = FaceDetector(), sorted(folder.glob("subject*.png"))
    named = [file.stem.removeprefix("subject").split(".") for file in files]
    pictures = [read_image(file) for file in files]
    faces = [crop(picture, detector.find(picture)[0]) for picture in pictures]
    return [int(number) for number, _ in named], [take for _, take in named], faces
