"""Who is where in a film, or in a folder of pictures: python faces.py GALLERY FILM OUT"""

from collections import Counter
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from robot_perception import checks, datasets
from robot_perception.scripts import FILM, Recording, Results, installed, script, tell, within

with installed():
    import click
    import cv2
    from tqdm import tqdm

    from robot_perception.companion.faces.detection import FaceDetector
    from robot_perception.companion.faces.gallery import Gallery

RATE = 10.0  # pictures in a second, where film or folder does not tell
DETECTOR = FaceDetector()
COUNT = 20  # eigenimages, where there are pictures enough
ACCEPTED = 0.95  # of new pictures of those in the gallery; more lets in more strangers, too
EVEN = True  # spread the grey values of a face, so that a dim picture is like a bright one
NOBODY = "?"  # the name of those who are not in the gallery
KNOWN, UNKNOWN = (0, 220, 0), (230, 30, 30)  # colours
COLUMNS = ("frame", "time_s", "x", "y", "w", "h", "name", "distance")
GALLERY = "A folder with a folder for each person, named like the person, with pictures in it."
RESULTS = {
    ".csv": f"A line for each face: {','.join(COLUMNS)}.",
    ".mp4": "The pictures with faces and names.",
}


def check() -> None:
    """The constants."""
    within("RATE", RATE, 0.01, 1000, "pictures in a second")
    checks.instance("DETECTOR", DETECTOR, FaceDetector)
    checks.whole("COUNT", COUNT, 1)
    checks.share("ACCEPTED", ACCEPTED)
    checks.flag("EVEN", EVEN)
    checks.instance("NOBODY", NOBODY, str)


def learnt(folder: Path) -> tuple[Gallery, int]:
    """Everybody who has a folder there, and how many other files there are."""
    files, skipped = datasets.gallery_files(folder)
    if NOBODY in files:
        raise ValueError(f"{folder}: {NOBODY!r} stands for nobody; NOBODY may be another word")
    people = {name: map(datasets.read_image, paths) for name, paths in files.items()}
    return Gallery.learn(people, DETECTOR, COUNT, accepted=ACCEPTED, equalise=EVEN), len(skipped)


def seen(film: datasets.Film, gallery: Gallery, rows: list) -> Iterator[np.ndarray]:
    """Each picture with its faces and labels in it; faces are put into rows, too."""
    labels = legend(gallery)
    for k, image in enumerate(tqdm(film, "pictures", film.promised)):
        grey, drawn = cv2.cvtColor(image, cv2.COLOR_RGB2GRAY), image.copy()
        for box in DETECTOR.find(grey):
            found = gallery.recognise(grey, box)
            left, top, wide, high = np.rint(box).astype(int).tolist()
            name, colour = found.name or NOBODY, KNOWN if found.name else UNKNOWN
            rows.append((k, left + 1, top + 1, wide, high, name, found.distance))
            cv2.rectangle(drawn, (left, top, wide, high), colour, 2)
            cv2.putText(drawn, labels.get(name, "?"), (left, max(top - 4, 10)), 0, 0.5, colour)
        yield drawn


def legend(gallery: Gallery) -> dict[str, str]:
    """What stands beside whose face: a number, and the name if OpenCV has its letters."""
    people = enumerate(gallery.known.people, 1)
    return {name: f"{k} {name}" if name.isascii() else f"{k}" for k, name in people}


@script
@click.argument("people", metavar="GALLERY", type=Recording(GALLERY))
@click.argument("film", type=Recording(FILM))
@click.argument("out", type=Results(RESULTS))
def main(people, film, out, topic, force):
    """Who is where in a film, or in a folder of pictures."""
    check()
    gallery, skipped = learnt(people)
    recorded, rows = datasets.read_film(film, topic=topic), []
    frames, rate = seen(recorded, gallery, rows), recorded.rate or RATE
    count = datasets.write_video(out[".mp4"], frames, rate=rate, overwrite=force)
    k, *told = zip(*rows, strict=True) if rows else [()] * 7
    k = np.array(k, dtype=int)
    when = np.array(recorded.numbers)[k], recorded.seconds(RATE)[k]
    datasets.write_columns(
        out[".csv"], dict(zip(COLUMNS, [*when, *told], strict=True)), overwrite=force
    )
    pictures = f"{len(gallery.known.names)} pictures with a face, {gallery.faceless} without"
    print(f"gallery: {len(gallery.known.people)} people, {pictures}, other files: {skipped}")
    print(f"pictures: {count}, faces: {len(rows)}")
    tell(recorded)
    often = Counter(told[-2])
    for number, name in enumerate(gallery.known.people, 1):
        print(f"{number} {name}: {often[name]}")
    print(f"{NOBODY}: {often[NOBODY]}")


if __name__ == "__main__":
    main()
