"""Who is where in a film, or in a folder of pictures: python faces.py GALLERY FILM OUT"""

from collections.abc import Iterator
from pathlib import Path

import numpy as np

from robot_perception import datasets
from robot_perception.companion.boxes import crop
from robot_perception.companion.faces.detection import FaceDetector
from robot_perception.companion.faces.eigenfaces import Eigenfaces, enrol
from robot_perception.extras import needing
from robot_perception.scripts import Recording, Results, script

with needing():
    import click
    import cv2
    from tqdm import tqdm

KINDS = {".jpg", ".jpeg", ".png"}  # of the pictures of the gallery
PATTERN = "*.jpg"  # where FILM is a folder of pictures, which files
RATE = 10.0  # of the film that is written: pictures in a second
DETECTOR = FaceDetector()
COUNT = 20  # eigenimages, where there are pictures enough
ACCEPTED = 0.95  # of new pictures of those in the gallery; more lets in more strangers, too
EVEN = True  # spread the grey values of a face, so that a dim picture is like a bright one
NOBODY = "?"  # the name of those who are not in the gallery
KNOWN, UNKNOWN = (0, 220, 0), (230, 30, 30)  # colours


def gallery(folder: Path) -> tuple[Eigenfaces, int]:
    """Everybody who has a folder there, and how many pictures have no face that was found."""
    people = sorted(path for path in folder.iterdir() if path.is_dir())
    if not people:
        raise ValueError(f"{folder}: the gallery needs a folder for each person")
    faces, names, skipped = [], [], 0
    for person in people:
        for file in sorted(path for path in person.iterdir() if path.suffix.lower() in KINDS):
            image = datasets.read_image(file)
            boxes = DETECTOR.find(image)
            skipped += not len(boxes)
            if len(boxes):
                faces.append(crop(image, boxes[0], equalise=EVEN))
                names.append(person.name)
        if names.count(person.name) < 2:
            raise ValueError(f"{person}: two pictures with a face are needed at least")
    count = min(COUNT, len(faces) - 2)
    return enrol(np.array(faces), names, count, accepted=ACCEPTED), skipped


def seen(pictures, known: Eigenfaces, rows: list) -> Iterator[np.ndarray]:
    """Each picture with its faces and names in it; these are put into rows, too."""
    for k, image in enumerate(pictures):
        grey, drawn = cv2.cvtColor(image, cv2.COLOR_RGB2GRAY), image.copy()
        for box in DETECTOR.find(grey):
            found = known.recognise(crop(grey, box, equalise=EVEN))
            left, top, wide, high = np.rint(box).astype(int).tolist()
            name, colour = found.name or NOBODY, KNOWN if found.name else UNKNOWN
            rows.append((k, left + 1, top + 1, wide, high, name, found.distance))
            cv2.rectangle(drawn, (left, top), (left + wide, top + high), colour, 2)
            cv2.putText(drawn, name, (left, max(top - 4, 10)), 0, 0.5, colour)
        yield drawn


@script
@click.argument("people", metavar="GALLERY", type=Recording())
@click.argument("film", type=Recording())
@click.argument("out", type=Results(".mp4", ".csv"))
def main(people, film, out, force):
    """Who is where in a film, or in a folder of pictures."""
    known, skipped = gallery(people)
    rows: list[tuple] = []
    if film.is_dir():
        pictures = datasets.read_images(film, PATTERN, colour=True)
    else:
        pictures = datasets.read_video(film)
    frames = seen(tqdm(pictures, "pictures"), known, rows)
    count = datasets.write_video(out[".mp4"], frames, rate=RATE, overwrite=force)
    numbers = np.array(getattr(pictures, "numbers", range(1, count + 1)))
    columns = list(zip(*rows, strict=True)) or [()] * 7
    named = dict(zip(("frame", "x", "y", "w", "h", "name", "distance"), columns, strict=True))
    named["frame"] = numbers[list(named["frame"])] if rows else ()
    datasets.write_columns(out[".csv"], named, overwrite=force)
    print(f"gallery: {len(known.people)} people, {len(known.names)} pictures, skipped: {skipped}")
    print(f"pictures: {count}, faces: {len(rows)}")
    for name in (*known.people, NOBODY):
        print(f"{name}: {list(named['name']).count(name)}")


if __name__ == "__main__":
    main()
