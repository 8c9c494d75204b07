"""A robot's tutor, his hands and his orders in a film: python following.py FILM OUT"""

import json
from collections import Counter
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from robot_perception import checks, datasets
from robot_perception.scripts import (
    FILM,
    Recording,
    Results,
    installed,
    of_the_book,
    script,
    tell,
    within,
)
from studies.files import reading

with installed():
    import click
    import cv2
    from tqdm import tqdm

    from robot_perception.companion.faces.detection import FaceDetector
    from robot_perception.companion.faces.gallery import Gallery
    from robot_perception.companion.hands.cascade import Cascade, HandDetector
    from robot_perception.companion.interaction import Interaction, paper_table
    from robot_perception.companion.robot import (
        EVENTS,
        CompanionRobot,
        RobotInfo,
        RobotRules,
        RobotState,
    )

PACE = 10.0  # pictures in a second that are used, if there are as many: events count pictures
RATE = 10.0  # pictures in a second, where film or folder does not tell
WIDE = 640  # px: to this width larger pictures are made smaller
FACES = FaceDetector(scale=1.05, neighbours=2)
# trained on photographs without hands as well; or a file of `robot-perception hands --write`
HANDS = of_the_book("open_hand_photographs.json")
INTERACTION = Interaction(paper_table(), EVENTS)
RULES = RobotRules()
ACCEPTED = 0.9  # of new pictures of those in the gallery; more lets in more strangers, too
SEED = 0
GALLERY = "With a folder for each tutor, named like him, with pictures in it; as of faces.py."
ANYBODY, NOBODY = "tutor", "?"  # whom a face is taken for without a gallery; nobody
TUTOR, STRANGER, HAND = (0, 220, 0), (230, 30, 30), (255, 220, 0)  # colours
COLUMNS = ("frame", "time_s", "state", "event", "name", "x", "y", "w", "h", "hands")
RESULTS = {
    ".csv": f"A line for each picture that is used: {','.join(COLUMNS)}.",
    ".mp4": "These pictures with faces, hands, the tutor and the state.",
}


def check() -> None:
    """The constants."""
    within("PACE", PACE, 0.01, 1000, "pictures in a second")
    within("RATE", RATE, 0.01, 1000, "pictures in a second")
    checks.whole("WIDE", WIDE, 64, 8192)
    checks.share("ACCEPTED", ACCEPTED)
    checks.whole("SEED", SEED, 0)
    checks.instance("FACES", FACES, FaceDetector)
    checks.instance("HANDS", HANDS, str, Path)
    checks.instance("INTERACTION", INTERACTION, Interaction)
    checks.instance("RULES", RULES, RobotRules)
    checks.instance("ANYBODY", ANYBODY, str)
    checks.instance("NOBODY", NOBODY, str)


def robot(gallery: Path | None) -> CompanionRobot:
    """A robot that knows the people of a gallery, or takes everybody for its tutor."""
    parts = {"faces": FACES, "interaction": INTERACTION, "rules": RULES}
    with reading(HANDS, "no detector of hands"):
        hands = HandDetector(Cascade.from_plain(json.loads(Path(HANDS).read_text("utf-8"))))
    if gallery is None:
        return CompanionRobot(lambda grey, box: ANYBODY, hands, **parts)
    files, _ = datasets.gallery_files(gallery)
    people = {name: map(datasets.read_image, paths) for name, paths in files.items()}
    known = Gallery.learn(people, FACES, accepted=ACCEPTED)
    return CompanionRobot(lambda grey, box: known.recognise(grey, box).name, hands, **parts)


def place(state: RobotState, info: RobotInfo) -> np.ndarray | None:
    """Head and trunk of the tutor who is followed, or else his face; none if it is not seen."""
    if state.person is not None:
        return state.person.box
    return None if info.held is None else info.faces[info.held].box


def followed(film, every: int, companion: CompanionRobot, rows: list) -> Iterator[np.ndarray]:
    """The pictures that are used, with what is found; states and places are put into rows, too."""
    rng, state = np.random.default_rng(SEED), companion.start()
    smaller = min(WIDE / film.size[0], 1.0)
    size = [max(round(side * smaller), 1) for side in film.size]
    for k, image in enumerate(tqdm(film, "pictures", film.promised)):
        if k % every:
            continue
        small = cv2.resize(image, size, interpolation=cv2.INTER_AREA) if smaller < 1 else image
        state, info = companion.step(state, small, rng=rng)
        box = place(state, info)
        told = np.zeros(4) if box is None else box / smaller + [1, 1, 0, 0]
        name = NOBODY if box is None or state.link is None else state.link.name
        rows.append((k, state.name, info.interaction.event or "none", name, *told, len(info.hands)))
        yield drawn(image.copy(), state, info, smaller)


def drawn(image: np.ndarray, state: RobotState, info: RobotInfo, smaller: float) -> np.ndarray:
    """A picture with faces, hands, the tutor and the state."""
    boxes = [(face.box, TUTOR if k == info.held else STRANGER) for k, face in enumerate(info.faces)]
    boxes += [(hand, HAND) for hand in info.hands]
    boxes += [(state.person.box, TUTOR)] if state.person is not None else []
    for box, colour in boxes:
        left, top, wide, high = np.rint(box / smaller).astype(int).tolist()
        cv2.rectangle(image, (left, top, wide, high), colour, 2)
    cv2.putText(image, state.name, (6, image.shape[0] - 8), 0, 0.6, TUTOR, 2)
    return image


@script
@click.argument("film", type=Recording(FILM))
@click.argument("out", type=Results(RESULTS))
@click.option("--gallery", type=Recording(GALLERY), metavar="FOLDER", help=GALLERY)
def main(film, out, gallery, topic, force):
    """A robot's tutor, his hands and his orders in a film, or in a folder of pictures."""
    check()
    companion, recorded, rows = robot(gallery), datasets.read_film(film, topic=topic), []
    rate = recorded.rate or RATE
    every = max(round(rate / PACE), 1)
    frames = followed(recorded, every, companion, rows)
    datasets.write_video(out[".mp4"], frames, rate=rate / every, overwrite=force)
    k, *told = zip(*rows, strict=True)
    when = np.array(recorded.numbers)[list(k)], recorded.seconds(RATE)[list(k)]
    columns = dict(zip(COLUMNS, [*when, *told], strict=True))
    datasets.write_columns(out[".csv"], columns, overwrite=force)
    print(f"pictures: {recorded.count}, used: {len(rows)}")
    tell(recorded)
    often = Counter(columns["state"])
    print("states: " + ", ".join(f"{name}: {often[name]}" for name in INTERACTION.table.states))


if __name__ == "__main__":
    main()
