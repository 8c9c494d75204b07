"""The angles of both arms from a film of an upper body: python arms.py FILM LENGTHS POSE OUT"""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from robot_perception import checks, datasets
from robot_perception.arms.body_model import BodyModel, Measures
from robot_perception.arms.tracker import ArmRules, ArmState, ArmTracker, find_face
from robot_perception.cameras import Pinhole
from robot_perception.extras import needing
from robot_perception.scripts import Recording, Results, script, within

with needing():
    import click
    import cv2
    from tqdm import tqdm

FOCAL = 1.0  # focal length over the width of a picture; 1.0 is a view of 53 degrees
RULES = ArmRules(particles=400)
RATE = 15.0  # pictures in a second, where film or folder does not tell
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


def body(film: datasets.Film, lengths: str) -> ArmTracker:
    """A tracker of arms of these lengths before this camera, if the constants are sensible."""
    within("RATE", RATE, 0.01, 1000, "pictures in a second")
    checks.instance("RULES", RULES, ArmRules)
    checks.whole("SEED", SEED, 0)
    width, height = film.size
    focal = width * within("FOCAL", FOCAL, 0.2, 20, "widths of a picture")
    camera = Pinhole((focal, focal), ((width - 1) / 2, (height - 1) / 2), film.size)
    upper, fore, hand = numbers(lengths, 3, "LENGTHS").tolist()
    if not all(0.02 <= length <= 1 for length in (upper, fore, hand)):
        raise ValueError(f"LENGTHS must be from 0.02 to 1 m, got {lengths!r}: are they in cm?")
    # the outline of a hand is narrow at its end: left out
    return ArmTracker(camera, replace(Measures(), lengths=(upper, fore, 0.76 * hand)), RULES)


def first_pose(text: str, camera: Pinhole) -> np.ndarray | None:
    """The eight angles, rad, within the limits of the joints; none for arms at rest."""
    if text == "rest":
        return None
    pose, anybody = np.radians(numbers(text, 8, "POSE")), BodyModel(camera, np.array([0, 0, 10.0]))
    if not anybody.possible(pose[None])[0]:
        limits = ", ".join("{:.0f} to {:.0f}".format(*row) for row in np.degrees(anybody.limits))
        raise ValueError(f"POSE must be, in degrees, {limits} for each arm, got {text!r}")
    return pose


def face_in(image: np.ndarray) -> np.ndarray | None:
    """The square that marks a face, none if there is no face."""
    try:
        return find_face(image)
    except ValueError:
        return None


def first_face(text: str, film: datasets.Film) -> np.ndarray:
    """The square that was given, px, if it lies in the picture."""
    left, top, wide, high = face = numbers(text, 4, "--face")
    if min(left, top) < 0 or min(wide, high) < 8 or (face[:2] + face[2:] > film.size).any():
        raise ValueError(f"--face must lie in the picture of {film.size} px, got {text!r}")
    return face


def tracked(film, tracker: ArmTracker, face, pose, rows: list) -> Iterator[np.ndarray]:
    """Each picture with the estimate in it; the angles are put into rows, too.

    Pictures before the first one with a face are as they are.
    """
    rng, state, lost = np.random.default_rng(SEED), None, False
    for k, image in enumerate(tqdm(film, "pictures", film.promised)):
        if state is not None:
            state, info = tracker.step(state, image, rng=rng)
            lost = info.lost
        elif (there := face_in(image) if face is None else face) is not None:
            state = tracker.start(image, rng=rng, face=there, pose=pose)
        if state is not None:
            rows.append((k, *np.degrees(state.mean), *np.degrees(state.spread), int(lost)))
        yield image if state is None else drawn(image.copy(), state, lost)
    if state is None:
        raise ValueError(f"{film.path}: no picture shows a face; --face u,v,width,height gives it")


def drawn(image: np.ndarray, state: ArmState, lost: bool) -> np.ndarray:
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
@click.option("--face", help="Square of the face in the first picture: u,v,width,height, px.")
def main(film, lengths, pose, out, face, topic, force):
    """The angles of both arms from a film of an upper body, by the lengths of its arms."""
    recorded, rows = datasets.read_film(film, topic=topic), []
    tracker = body(recorded, lengths)
    told = first_pose(pose, tracker.camera)
    square = None if face is None else first_face(face, recorded)
    frames, rate = tracked(recorded, tracker, square, told, rows), recorded.rate or RATE
    count = datasets.write_video(out[".mp4"], frames, rate=rate, overwrite=force)
    k, *values = np.array(rows).T
    k = k.astype(int)
    names = ["frame", "time_s", *ANGLES, *(f"{name}_sigma" for name in ANGLES), "lost"]
    when = np.array(recorded.numbers)[k], recorded.seconds(RATE)[k]
    columns = dict(zip(names, [*when, *values], strict=True))
    datasets.write_columns(out[".csv"], columns, overwrite=force)
    lost = f"before the first face: {count - len(k)}, of which lost: {values[-1].sum():.0f}"
    print(f"pictures: {count}, {lost}")
    for remark in recorded.remarks:
        print(remark)


if __name__ == "__main__":
    main()
