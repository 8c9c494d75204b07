"""A mosaic of a ceiling from a film of it: python ceiling.py FILM OUT"""

from collections import Counter
from collections.abc import Iterator

import numpy as np

from robot_perception import checks, datasets
from robot_perception.geometry import se3
from robot_perception.scripts import FILM, Recording, Results, installed, script, tell, within
from studies.files import written

with installed():
    import click
    import cv2
    from PIL import Image
    from tqdm import tqdm

    from robot_perception.ceiling.correction import Correction
    from robot_perception.ceiling.mapping import Mapper, MapRules, MapState, retrace
    from robot_perception.ceiling.mosaic import Mosaic, paint, pieces

HEIGHT, FOCAL = None, None  # m below the ceiling, and px of the film; None: all is in px
CENTRE = None  # where the optical axis meets the picture, px of the film; None: its middle
CORRECTION = None  # a ceiling.correction.Correction where the camera is tilted or bends lines
WIDE = 320  # px: to this width pictures are made smaller
EVERY = 1  # one picture of so many is used: between two the ceiling may move by some px
RATE = 30.0  # pictures in a second, where film or folder does not tell
RULES = MapRules()
SEED = 1
WAY, PATTERN = (230, 30, 30), (0, 90, 200)  # colours
RESULTS = {
    ".png": "The mosaic, with the way and the patterns.",
    ".tum": "The way in the piece that is drawn.",
    "_pictures.csv": "Where each picture that is used was taken: frame,time_s,piece,x,y,heading.",
    ".csv": "The patterns: pattern,piece,x,y,heading,pictures.",
}


def check() -> None:
    """The constants."""
    if (HEIGHT is None) != (FOCAL is None):
        raise ValueError("HEIGHT and FOCAL are needed both, or none")
    if HEIGHT is not None:
        within("HEIGHT", HEIGHT, 0.1, 100, "m")
        within("FOCAL", FOCAL, 10, 1e5, "px")
    within("RATE", RATE, 0.01, 1000, "pictures in a second")
    checks.whole("WIDE", WIDE, 64, 8192)
    checks.whole("EVERY", EVERY, 1)
    checks.whole("SEED", SEED, 0)
    checks.instance("RULES", RULES, MapRules)
    checks.instance("CORRECTION", CORRECTION, Correction, type(None))


def pictures(film: datasets.Film, what: str) -> Iterator[tuple[int, np.ndarray]]:
    """The pictures that are used, with their places in the film: grey, corrected, WIDE."""
    size = WIDE, max(round(film.size[1] * WIDE / film.size[0]), 1)
    for k, image in enumerate(tqdm(film, what, film.promised)):
        if k % EVERY == 0:
            grey = cv2.cvtColor(image, cv2.COLOR_RGB2GRAY)
            grey = CORRECTION.apply(grey) if CORRECTION else grey
            yield k, cv2.resize(grey, size, interpolation=cv2.INTER_AREA)


def mapper(film: datasets.Film) -> Mapper:
    """With Z/f, m for a px of a picture, or 1, and the centre of a picture, px."""
    smaller = WIDE / film.size[0]
    centre = (np.array(film.size) - 1) / 2 if CENTRE is None else checks.vector("CENTRE", CENTRE, 2)
    scale = 1.0 if HEIGHT is None else HEIGHT / (FOCAL * smaller)
    return Mapper(scale, (centre + 0.5) * smaller - 0.5, RULES)


def build(film: datasets.Film) -> tuple[MapState, dict[int, dict], Counter]:
    """The map, what was seen in which picture, and how many pictures were skipped, and why."""
    rng, own, seen, counts = np.random.default_rng(SEED), mapper(film), {}, Counter()
    state = own.start()
    for k, image in pictures(film, "mosaic"):
        state, info = own.step(state, image, rng=rng)
        if not state.mosaic.poses:  # no distinctive window yet
            counts += Counter(all=1, empty=1)
            continue
        counts += Counter(
            all=1, found=len(info.found), closed=info.closed, blind=info.piece is None
        )
        if info.piece is not None:
            seen[k] = dict(info.sightings)
    if not state.mosaic.poses:
        raise ValueError(f"{film.path}: no picture has a distinctive window, as of a blank ceiling")
    return state, seen, counts


def drawn(part: Mosaic, way: np.ndarray, used: Iterator[np.ndarray], unit: str) -> np.ndarray:
    """The ceiling, white where it is unknown, with the way and the patterns, px."""
    greys, shown, corner = paint(used, way, centre=part.centre, scale=part.scale)
    picture = np.where(shown, greys, 255)[..., None].repeat(3, axis=-1)
    line = np.rint((way[:, :2] - corner) / part.scale).astype(np.int32)
    cv2.polylines(picture, [line], False, WAY, 2)
    for name, pose in part.poses.items():
        u, v = np.rint((pose[:2] - corner) / part.scale).astype(int).tolist()
        cv2.circle(picture, (u, v), 4, PATTERN, -1)
        cv2.putText(picture, name, (u + 6, v - 6), 0, 0.5, PATTERN)
    print(f"way: {np.hypot(*np.diff(way[:, :2], axis=0).T).sum():.2f} {unit}")
    start = f"{corner[0]:.4g}, {corner[1]:.4g} {unit}"
    print(f"first pixel: {start}; from one to the next: {part.scale:.4g}")
    return picture


@script
@click.argument("film", type=Recording(FILM))
@click.argument("out", type=Results(RESULTS))
def main(film, out, topic, force):
    """A mosaic of a ceiling, and the way below it, from a film or a folder of pictures."""
    check()
    state, seen, counts = build(recorded := datasets.read_film(film, topic=topic))
    parts, unit = pieces(state.mosaic, state.links), "px" if HEIGHT is None else "m"
    piece, way = retrace(parts, [*seen.values()], RULES.gate)
    frames, times = np.array(recorded.numbers)[[*seen]], recorded.seconds(RATE)[[*seen]]
    names = f"x_{unit}", f"y_{unit}", "heading_rad"
    columns = {"frame": frames, "time_s": times, "piece": piece + 1}
    columns |= dict(zip(names, way.T, strict=True))
    datasets.write_columns(out["_pictures.csv"], columns, overwrite=force)
    rows = [(k, name, *at) for k, part in enumerate(parts, 1) for name, at in part.poses.items()]
    whose, patterns, *poses = zip(*rows, strict=True)
    columns = {"pattern": patterns, "piece": whose, **dict(zip(names, poses, strict=True))}
    columns |= {"pictures": [sum(name in one for one in seen.values()) for name in patterns]}
    datasets.write_columns(out[".csv"], columns, overwrite=force)
    lost = f"before the first pattern: {counts['empty']}, without a known one: {counts['blind']}"
    print(f"pictures: {counts['all']}, skipped {lost}")
    tell(recorded)
    again = f"found again: {counts['found']}, loops closed: {counts['closed']}"
    print(f"patterns: {len(patterns)}, {again}")
    if len(parts) > 1:
        print(f"the mosaic is in {len(parts)} pieces: where one lies from another is not known")
    largest = np.bincount(piece).argmax()
    for k, part in enumerate(parts) if len(parts) > 1 else ():
        span = " to ".join(map(str, frames[piece == k][[0, -1]])) if k in piece else "none"
        own = f"pictures {span}, patterns {' '.join(part.poses)}"
        print(f"piece {k + 1}{', drawn' * bool(k == largest)}: {own}")
    mine = piece == largest
    datasets.write_tum(out[".tum"], times[mine], se3.from_se2(way[mine]), overwrite=force)
    rows, film = {*np.array([*seen])[mine].tolist()}, datasets.read_film(film, topic=topic)
    used = (image for k, image in pictures(film, "painting") if k in rows)
    with written(out[".png"]) as file:
        Image.fromarray(drawn(parts[largest], way[mine], used, unit)).save(file, "png")


if __name__ == "__main__":
    main()
