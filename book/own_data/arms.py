"""The angles of both arms from a film of an upper body: python arms.py FILM LENGTHS POSE OUT"""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from robot_perception import checks, datasets
from robot_perception.scripts import (
    FILM,
    Numbers,
    Recording,
    Results,
    installed,
    script,
    tell,
    within,
)

with installed():
    import click
    import cv2
    from tqdm import tqdm

    from robot_perception.arms.body_model import BodyModel, Measures
    from robot_perception.arms.tracker import ArmRules, ArmState, ArmTracker, find_face
    from robot_perception.cameras import Pinhole

FOCAL = 1.0  # focal length over the width of a picture; 1.0 is a view of 53 degrees
RULES = ArmRules(particles=400)
RATE = 15.0  # pictures in a second, where film or folder does not tell
SEED = 0
OUTLINE, BONES, LOST = (0, 220, 0), (255, 220, 0), (230, 30, 30)  # colours
ANGLES = [f"{arm}_{name}_deg" for arm in ("left", "right")
          for name in ("sideways", "ahead", "about", "elbow")]  # fmt: skip
LENGTHS = Numbers("upper,fore,hand", "Lengths of upper arm, forearm and hand, m: 0.29,0.25,0.17.")
POSE = Numbers(
    ",".join(2 * ["sideways,ahead,about,elbow"]),
    "In the first picture with a face, degrees: four angles of the arm on the left of the picture,"
    " then four of the one on the right; rest is both arms beside the body.",
    word="rest",
)
FACE = Numbers("u,v,width,height", "Square of the face in the first picture, px.")
RESULTS = {
    ".csv": "A line for each picture from the first face on: frame,time_s, eight angles in degrees,"
    " their spreads, lost.",
    ".mp4": "All pictures, with outlines and bones.",
}


def body(film: datasets.Film, lengths: tuple[float, ...]) -> ArmTracker:
    """A tracker of arms of these lengths before this camera, if the constants are sensible."""
    within("RATE", RATE, 0.01, 1000, "pictures in a second")
    checks.instance("RULES", RULES, ArmRules)
    checks.whole("SEED", SEED, 0)
    width, height = film.size
    focal = width * within("FOCAL", FOCAL, 0.2, 20, "widths of a picture")
    camera = Pinhole((focal, focal), ((width - 1) / 2, (height - 1) / 2), film.size)
    upper, fore, hand = lengths
    if not all(0.02 <= length <= 1 for length in lengths):
        raise ValueError(f"LENGTHS must be from 0.02 to 1 m, got {told(lengths)}: are they in cm?")
    # the outline of a hand is narrow at its end: left out
    return ArmTracker(camera, replace(Measures(), lengths=(upper, fore, 0.76 * hand)), RULES)


def told(numbers: tuple[float, ...]) -> str:
    """Numbers as they were given."""
    return ",".join(f"{number:g}" for number in numbers)


def first_pose(angles: tuple[float, ...] | str, camera: Pinhole) -> np.ndarray | None:
    """The eight angles, rad, within the limits of the joints; none for arms at rest."""
    if angles == "rest":
        return None
    pose, anybody = np.radians(angles), BodyModel(camera, np.array([0, 0, 10.0]))
    if not anybody.possible(pose[None])[0]:
        limits = ", ".join("{:.0f} to {:.0f}".format(*row) for row in np.degrees(anybody.limits))
        raise ValueError(f"POSE must be, in degrees, {limits} for each arm, got {told(angles)}")
    return pose


def face_in(image: np.ndarray) -> np.ndarray | None:
    """The square that marks a face, none if there is no face."""
    try:
        return find_face(image)
    except ValueError:
        return None


def first_face(square: tuple[float, ...], film: datasets.Film) -> np.ndarray:
    """The square that was given, px, if it lies in the picture."""
    left, top, wide, high = face = np.array(square)
    if min(left, top) < 0 or min(wide, high) < 8 or (face[:2] + face[2:] > film.size).any():
        raise ValueError(f"--face must lie in the picture of {film.size} px, got {told(square)}")
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
@click.argument("film", type=Recording(FILM))
@click.argument("lengths", type=LENGTHS)
@click.argument("pose", type=POSE)
@click.argument("out", type=Results(RESULTS))
@click.option("--face", type=FACE, metavar="SQUARE", help=FACE.what)
def main(film, lengths, pose, out, face, topic, force):
    """The angles of both arms from a film of an upper body, by the lengths of its arms."""
    recorded, rows = datasets.read_film(film, topic=topic), []
    tracker = body(recorded, lengths)
    first = first_pose(pose, tracker.camera)
    square = None if face is None else first_face(face, recorded)
    frames, rate = tracked(recorded, tracker, square, first, rows), recorded.rate or RATE
    count = datasets.write_video(out[".mp4"], frames, rate=rate, overwrite=force)
    k, *values = np.array(rows).T
    k = k.astype(int)
    names = ["frame", "time_s", *ANGLES, *(f"{name}_sigma" for name in ANGLES), "lost"]
    when = np.array(recorded.numbers)[k], recorded.seconds(RATE)[k]
    columns = dict(zip(names, [*when, *values], strict=True))
    datasets.write_columns(out[".csv"], columns, overwrite=force)
    lost = f"before the first face: {count - len(k)}, of which lost: {values[-1].sum():.0f}"
    print(f"pictures: {count}, {lost}")
    tell(recorded)


if __name__ == "__main__":
    main()
