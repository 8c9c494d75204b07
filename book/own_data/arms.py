"""The angles of both arms from a film of an upper body: python arms.py FILM LENGTHS POSE OUT"""

from collections.abc import Iterator
from dataclasses import replace
from itertools import chain

import numpy as np

from robot_perception import datasets
from robot_perception.arms.body_model import Measures
from robot_perception.arms.tracker import ArmRules, ArmTracker, find_face
from robot_perception.cameras import Pinhole
from robot_perception.extras import needing
from robot_perception.scripts import Recording, Results, script

with needing():
    import click
    import cv2
    from tqdm import tqdm

FOCAL = 1.0  # focal length over the width of a picture; 1.0 is a view of 53 degrees
RULES = ArmRules(particles=400)
RATE = 15.0  # of the film that is written: pictures in a second
SEED = 0
OUTLINE, BONES, LOST = (0, 220, 0), (255, 220, 0), (230, 30, 30)  # colours
ANGLES = [f"{arm}_{name}_deg" for arm in ("left", "right")
          for name in ("sideways", "ahead", "about", "elbow")]  # fmt: skip


def numbers(text: str, count: int, what: str) -> np.ndarray:
    """So many numbers between commas."""
    try:
        found = np.array([float(part) for part in text.split(",")])
    except ValueError:
        found = np.zeros(0)
    if len(found) != count or not np.isfinite(found).all():
        raise ValueError(f"{what} must be {count} numbers between commas, got {text!r}")
    return found


def tracked(pictures, lengths, pose, rows: list) -> Iterator[np.ndarray]:
    """Each picture with the estimate in it; the angles are put into rows, too."""
    first = next(pictures, None)
    if first is None:
        raise ValueError("the film has no picture")
    height, width = first.shape[:2]
    camera = Pinhole((FOCAL * width,) * 2, ((width - 1) / 2, (height - 1) / 2), (width, height))
    hand = lengths[2] * 0.76  # the outline of a hand is narrow at its end: left out
    tracker = ArmTracker(camera, replace(Measures(), lengths=(*lengths[:2], hand)), RULES)
    rng = np.random.default_rng(SEED)
    state = tracker.start(first, rng=rng, face=find_face(first), pose=pose)
    lost = False
    for k, image in enumerate(chain([first], pictures)):
        if k:
            state, info = tracker.step(state, image, rng=rng)
            lost = info.lost
        rows.append((k + 1, *np.degrees(state.mean), *np.degrees(state.spread), int(lost)))
        yield drawn(image.copy(), state, lost)


def drawn(image: np.ndarray, state, lost: bool) -> np.ndarray:
    """A picture with the outlines of the limbs and the bones in them."""
    model = state.first.model
    contours = model.contours(state.mean[None])
    for u, v in contours.points[0][contours.visible[0]]:
        cv2.circle(image, (round(u), round(v)), 1, LOST if lost else OUTLINE, -1)
    for arm in model.pixels(model.joints(state.mean[None]))[0]:
        cv2.polylines(image, [np.rint(arm).astype(np.int32)], False, BONES, 1, cv2.LINE_AA)
    return image


@script
@click.argument("film", type=Recording())
@click.argument("lengths")
@click.argument("pose")
@click.argument("out", type=Results(".mp4", ".csv"))
def main(film, lengths, pose, out, force):
    """The angles of both arms from a film of an upper body, by the lengths of its arms."""
    arm = tuple(numbers(lengths, 3, "LENGTHS").tolist())
    told = None if pose == "rest" else np.radians(numbers(pose, 8, "POSE"))
    rows: list[tuple] = []
    pictures = tracked(iter(tqdm(datasets.read_video(film), "pictures")), arm, told, rows)
    count = datasets.write_video(out[".mp4"], pictures, rate=RATE, overwrite=force)
    names = ["frame", *ANGLES, *(f"{name}_sigma" for name in ANGLES), "lost"]
    columns = dict(zip(names, zip(*rows, strict=True), strict=True))
    datasets.write_columns(out[".csv"], columns, overwrite=force)
    print(f"pictures: {count}, of which lost: {sum(row[-1] for row in rows)}")


if __name__ == "__main__":
    main()
