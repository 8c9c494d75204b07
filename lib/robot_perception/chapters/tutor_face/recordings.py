"""Real faces: who is recognised among twenty people, who is found in which light, and in crowds.

The galleries that the notebook draws from two recordings need distances between pictures only. So
what is stored of them is each picture as a point of the space that all of them span: no face can be
drawn from it.
"""

from dataclasses import dataclass
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
from jaxtyping import Float64, Int64

from robot_perception.chapters.tutor_face.scene import SAME
from robot_perception.companion.boxes import crop, overlap
from robot_perception.companion.faces.detection import FaceDetector
from robot_perception.companion.faces.eigenfaces import enrol
from robot_perception.datasets import read_image
from studies.files import DamagedFile
from studies.intervals import proportion
from studies.stored.recordings import Recording
from studies.tables import Table

HALF = 5
"""Pictures of each person at enrolment, the first ones; the others are asked."""
KNOWN = 15
"""People in the gallery where the others are strangers."""
COUNTS = (1, 5, 10, 20, 40)
DETECTOR = FaceDetector()


@dataclass(frozen=True, eq=False, slots=True)
class Gallery:
    """Result of eigenfaces on twenty people.

    Parameters
    ----------
    counts : (k,)
        Of eigenimages.
    right : (k,)
        New pictures whose nearest is of the same person, all twenty in the gallery.
    known, strangers : (k,)
        With the first 15 in the gallery: new pictures of these that are accepted and rightly
        named, and pictures of the other five that are accepted.
    asked : (2,)
        New pictures of all twenty, and of the 15.
    others
        Pictures of the strangers.
    """

    counts: Int64[np.ndarray, " k"]
    right: Int64[np.ndarray, " k"]
    known: Int64[np.ndarray, " k"]
    strangers: Int64[np.ndarray, " k"]
    asked: Int64[np.ndarray, " 2"]
    others: int

    def table(self) -> Table:
        """Return the rates by the number of eigenimages."""
        rows = {
            f"{n}": [
                proportion(int(self.right[k]), int(self.asked[0])),
                proportion(int(self.known[k]), int(self.asked[1])),
                proportion(int(self.strangers[k]), self.others),
            ]
            for k, n in enumerate(self.counts)
        }
        columns = {
            "right": "20 people known: new pictures whose nearest is of the same person",
            "known": "15 people known: new pictures accepted and rightly named",
            "strangers": "pictures of the five others, accepted",
        }
        about = f"{HALF} pictures each at enrolment; 95 % over pictures of one recording"
        return Table(rows, columns, about, "eigenimages")


def gallery(folder: Path) -> Gallery:
    """Enrol the first five pictures of each person and ask for the others."""
    people = sorted(path for path in folder.iterdir() if path.is_dir())
    faces = np.array(
        [[read_image(folder / one.name / f"{k:02}.png") for k in range(1, 11)] for one in people]
    )
    faces = faces / 255.0
    names = np.repeat([[one.name] for one in people], 10, axis=1)
    rows = []
    for count in COUNTS:
        every, _, _ = _asked(faces, names, len(people), count)
        _, known, strangers = _asked(faces, names, KNOWN, count)
        rows.append((every, known, strangers))
    asked = np.array([len(people) * (10 - HALF), KNOWN * (10 - HALF)])
    others = (len(people) - KNOWN) * 10
    return Gallery(np.array(COUNTS), *np.array(rows).T, asked, others)


def _asked(faces: np.ndarray, names: np.ndarray, people: int, count: int) -> tuple[int, int, int]:
    """Return new pictures with the right nearest, those accepted too, and strangers accepted."""
    learnt, whose = faces[:people, :HALF], names[:people, :HALF]
    space = enrol(learnt.reshape(-1, *faces.shape[2:]), list(whose.ravel()), count)
    new = [space.recognise(face) for face in faces[:people, HALF:].reshape(-1, *faces.shape[2:])]
    true = names[:people, HALF:].ravel()
    right = sum(one.nearest == name for one, name in zip(new, true, strict=True))
    known = sum(one.name == name for one, name in zip(new, true, strict=True))
    others = faces[people:].reshape(-1, *faces.shape[2:])
    return right, known, sum(space.recognise(face).name is not None for face in others)


@dataclass(frozen=True, eq=False, slots=True)
class Lights:
    """Faces found by condition: the side of the light, glasses, expressions.

    Parameters
    ----------
    conditions
        Names of the pictures.
    pictures, found : (n,)
        How many there are, and in how many exactly one face is found.
    """

    conditions: tuple[str, ...]
    pictures: Int64[np.ndarray, " n"]
    found: Int64[np.ndarray, " n"]

    def table(self) -> Table:
        """Return what is found by kind of condition."""
        kinds = {
            "light from one side": ("leftlight", "rightlight"),
            "glasses": ("glasses",),
            "expressions and plain": (),
        }
        taken = [name for names in kinds.values() for name in names]
        rows = {}
        for kind, names in kinds.items():
            of = [
                k for k, name in enumerate(self.conditions)
                if name in names or (not names and name not in taken)
            ]  # fmt: skip
            rows[kind] = [
                int(self.pictures[of].sum()),
                proportion(int(self.found[of].sum()), int(self.pictures[of].sum())),
            ]
        columns = {"pictures": "of eight people", "found": "exactly one face; 95 %"}
        return Table(rows, columns, corner="condition")


def lights(folder: Path) -> Lights:
    """Look for the face in each picture."""
    counts: dict[str, list[int]] = {}
    for file in sorted(folder.glob("subject*.png")):
        boxes = DETECTOR.find(read_image(file))
        counts.setdefault(file.stem.split(".")[1], []).append(int(len(boxes) == 1))
    values = [np.array(of) for of in counts.values()]
    return Lights(
        tuple(counts), np.array([len(v) for v in values]), np.array([v.sum() for v in values])
    )


@dataclass(frozen=True, eq=False, slots=True)
class Crowd:
    """Faces found in photographs of several people.

    Parameters
    ----------
    files : (n,)
        The photographs.
    faces, found, false : (n,)
        Marked faces in each, those that are found, and detections that are at none.
    """

    files: tuple[str, ...]
    faces: Int64[np.ndarray, " n"]
    found: Int64[np.ndarray, " n"]
    false: Int64[np.ndarray, " n"]

    def table(self) -> Table:
        """Return what is found in each photograph and in all."""
        rows: dict[str, list] = {
            name: [int(x) for x in row]
            for name, *row in zip(self.files, self.faces, self.found, self.false, strict=True)
        }
        rows["all"] = [int(x.sum()) for x in (self.faces, self.found, self.false)]
        return Table(rows, {"faces": "", "found": "", "false": "detections at no face"})


def marked(file: Path) -> dict[str, np.ndarray]:
    """Return the boxes (k, 4) of the faces by photograph: left, top, width and height, px.

    Raises
    ------
    studies.files.DamagedFile
        If the file is no XML, or a box has no such numbers.
    """
    try:
        images = ElementTree.fromstring(file.read_bytes()).iter("image")
        sides = ("left", "top", "width", "height")
        return {
            image.attrib["file"]: np.array(
                [[float(box.attrib[side]) for side in sides] for box in image.iter("box")]
            ).reshape(-1, 4)
            for image in images
        }
    except (ElementTree.ParseError, KeyError, ValueError) as error:
        raise DamagedFile(f"{file}: {error!r:.80}") from error


def crowd(folder: Path) -> Crowd:
    """Look for the faces of each photograph."""
    rows = []
    for name, truth in marked(folder / "training_with_face_landmarks.xml").items():
        boxes = DETECTOR.find(read_image(folder / name))
        same = overlap(boxes, truth) >= SAME if len(boxes) else np.zeros((0, len(truth)), bool)
        hits, false = same.any(axis=0).sum(), (~same.any(axis=1)).sum()
        rows.append((name, len(truth), int(hits), int(false)))
    files, *counts = zip(*rows, strict=True)
    return Crowd(files, *(np.array(column) for column in counts))


@dataclass(frozen=True, eq=False, slots=True)
class Points:
    """Pictures of faces as points that are as far apart as the pictures are.

    Parameters
    ----------
    people : (n,)
        Whose each is.
    takes
        Name of each picture among those of a person.
    points : (n, k)
        Each picture in the space that all of them span, from their mean; the directions are
        orthonormal, and are not kept.
    """

    people: Int64[np.ndarray, " n"]
    takes: tuple[str, ...]
    points: Float64[np.ndarray, "n k"]


def points(people: list[int], takes: list[str], faces: list[np.ndarray]) -> Points:
    """Return pictures as points of the space that they span."""
    flat = np.array(faces, dtype=float).reshape(len(faces), -1)
    left, lengths, _ = np.linalg.svd(flat - flat.mean(axis=0), full_matrices=False)
    kept = lengths > 1e-9 * lengths[0]
    return Points(np.array(people), tuple(takes), (left * lengths)[:, kept])


def points_in_even_light(folder: Path) -> Points:
    """Read twenty people with ten pictures each, which are cut out by hand."""
    files = sorted(folder.glob("s*/*.png"))
    people = [int(file.parent.name[1:]) for file in files]
    faces = [read_image(file) / 255.0 for file in files]
    return points(people, [file.stem for file in files], faces)


def points_in_many_lights(folder: Path) -> Points:
    """Read eight people in many conditions, cut out where the detector finds the face."""
    files = sorted(folder.glob("subject*.png"))
    named = [file.stem.removeprefix("subject").split(".") for file in files]
    pictures = [read_image(file) for file in files]
    faces = [crop(picture, DETECTOR.find(picture)[0]) for picture in pictures]
    return points([int(number) for number, _ in named], [take for _, take in named], faces)


CROWD = Recording("faces_annotated", crowd, Crowd, "faces-annotated")
ORL = Recording("faces_orl", gallery, Gallery, "faces-orl")
YALE = Recording("faces_yale", lights, Lights, "faces-yale")
ORL_POINTS = Recording("faces_orl", points_in_even_light, Points, "faces-orl-points")
YALE_POINTS = Recording("faces_yale", points_in_many_lights, Points, "faces-yale-points")
