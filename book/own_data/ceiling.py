"""A mosaic of a ceiling from a film of it: python ceiling.py FILM OUT"""

from collections.abc import Iterator
from pathlib import Path

import numpy as np

from robot_perception import datasets
from robot_perception.ceiling.mapping import Mapper, MapRules, consistent
from robot_perception.ceiling.mosaic import Mosaic, paint
from robot_perception.extras import needing
from robot_perception.files import written
from robot_perception.geometry import se3
from robot_perception.scripts import Recording, Results, script

with needing():
    import click
    import cv2
    from PIL import Image
    from tqdm import tqdm

HEIGHT, FOCAL = None, None  # m below the ceiling, and px of the film; None: all is in px
CENTRE = None  # where the optical axis meets the picture, px of the film; None: its middle
CORRECTION = None  # a ceiling.correction.Correction where the camera is tilted or bends lines
WIDE = 320  # px: to this width pictures are made smaller
EVERY = 1  # one picture of so many is used: between two the ceiling may move by some px
RATE = 30.0  # pictures of the film in a second
RULES = MapRules()
SEED = 1
WAY, PATTERN = (230, 30, 30), (0, 90, 200)  # colours

Seen = tuple[int, dict[str, np.ndarray]]  # a picture's number, from 0, and the patterns in it


def pictures(film: Path, what: str) -> Iterator[np.ndarray]:
    """The pictures that are used: grey, corrected, WIDE."""
    for k, image in enumerate(tqdm(datasets.read_video(film), what)):
        if k % EVERY == 0:
            grey = cv2.cvtColor(image, cv2.COLOR_RGB2GRAY)
            grey = CORRECTION.apply(grey) if CORRECTION else grey
            high = round(grey.shape[0] * WIDE / grey.shape[1])
            yield cv2.resize(grey, (WIDE, high), interpolation=cv2.INTER_AREA)


def camera(film: Path) -> tuple[float, tuple[float, float]]:
    """Z/f, m for a px of a picture, or 1, and the centre of a picture, px."""
    if (HEIGHT is None) != (FOCAL is None):
        raise ValueError("HEIGHT and FOCAL are needed both, or none")
    high, wide = next(datasets.read_video(film)).shape[:2]
    smaller, shape = WIDE / wide, (round(high * WIDE / wide), WIDE)
    middle = [(side - 1) / 2 for side in shape[::-1]]
    if CENTRE is not None:
        middle = [(at + 0.5) * smaller - 0.5 for at in CENTRE]
    return (1.0 if HEIGHT is None else HEIGHT / (FOCAL * smaller)), tuple(middle)


def build(film: Path, mapper: Mapper) -> tuple[Mosaic, list[Seen], dict[str, int]]:
    """The mosaic, what was seen in which picture, and how many pictures were skipped, and why."""
    rng, state, seen = np.random.default_rng(SEED), mapper.start(), []
    counts = dict.fromkeys(("pictures", "empty", "blind", "found", "closed"), 0)
    for k, image in enumerate(pictures(film, "mosaic")):
        counts["pictures"] += 1
        state, info = mapper.step(state, image, rng=rng)
        if not state.mosaic.poses:  # no distinctive window yet
            counts["empty"] += 1
            continue
        counts["found"] += len(info.found)
        counts["closed"] += info.closed
        if info.located:
            seen.append((k, dict(info.sightings)))
        else:
            counts["blind"] += 1
    if not state.mosaic.poses:
        raise ValueError(f"{film}: no picture has a distinctive window, as of a blank ceiling")
    return state.mosaic, seen, counts


def drawn(greys: np.ndarray, shown: np.ndarray, way: np.ndarray, places: dict) -> np.ndarray:
    """The ceiling, white where it is unknown, with the way and the patterns, px."""
    picture = np.where(shown, greys, 255)[..., None].repeat(3, axis=-1)
    cv2.polylines(picture, [np.rint(way).astype(np.int32)], False, WAY, 2)
    for name, at in places.items():
        u, v = np.rint(at).astype(int).tolist()
        cv2.circle(picture, (u, v), 4, PATTERN, -1)
        cv2.putText(picture, name, (u + 6, v - 6), 0, 0.5, PATTERN)
    return picture


@script
@click.argument("film", type=Recording())
@click.argument("out", type=Results(".tum", ".csv", ".png"))
def main(film, out, force):
    """A mosaic of a ceiling, and the way below it, from a film."""
    scale, centre = camera(film)
    mosaic, seen, counts = build(film, Mapper(scale, centre, RULES))
    numbers = np.array([k for k, _ in seen])
    agreed = [consistent(mosaic, sightings, RULES.gate)[0] for _, sightings in seen]
    way = np.array([mosaic.locate(sightings)[0] for sightings in agreed])
    datasets.write_tum(out[".tum"], numbers * EVERY / RATE, se3.from_se2(way), overwrite=force)
    unit = "px" if HEIGHT is None else "m"
    x, y, heading = np.array([*mosaic.poses.values()]).T
    often = [sum(name in sightings for sightings in agreed) for name in mosaic.poses]
    columns = {"pattern": [*mosaic.poses], f"x_{unit}": x, f"y_{unit}": y, "heading_rad": heading}
    columns |= {"pictures": often}
    datasets.write_columns(out[".csv"], columns, overwrite=force)
    located = set(numbers.tolist())
    used = (image for k, image in enumerate(pictures(film, "painting")) if k in located)
    greys, shown, corner = paint(used, way, centre=mosaic.centre, scale=scale)
    places = {name: (pose[:2] - corner) / scale for name, pose in mosaic.poses.items()}
    with written(out[".png"]) as file:
        picture = drawn(greys, shown, (way[:, :2] - corner) / scale, places)
        Image.fromarray(picture).save(file, "png")
    lost = f"before the first pattern: {counts['empty']}, without a known one: {counts['blind']}"
    print(f"pictures: {counts['pictures']}, skipped {lost}")
    print(f"patterns: {len(x)}, found again: {counts['found']}, loops closed: {counts['closed']}")
    print(f"way: {np.hypot(*np.diff(way[:, :2], axis=0).T).sum():.2f} {unit}")
    print(
        f"first pixel: {corner[0]:.4g}, {corner[1]:.4g} {unit}; from one to the next: {scale:.4g}"
    )


if __name__ == "__main__":
    main()
