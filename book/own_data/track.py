"""Follow a thing in a film: python track.py ellipse|camshift|shape FILM BOX OUT"""

from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np

from robot_perception import datasets
from robot_perception.scripts import (
    FILM,
    Kinds,
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

    from robot_perception.appearance.affine_snake import SnakeRules
    from robot_perception.appearance.certainty import CertaintyRules, certainty, original
    from robot_perception.appearance.colour_distribution import Dynamics
    from robot_perception.appearance.colour_histograms import histogram, two_views
    from robot_perception.appearance.colour_shape import ColourShapeRules, ColourShapeTracker
    from robot_perception.appearance.colour_spaces import Binning
    from robot_perception.appearance.head_ellipse import Ellipse, HeadRules, HeadTracker
    from robot_perception.appearance.single_cues import WindowTracker

RATE = 10.0  # pictures in a second, where film or folder does not tell
HEAD = HeadTracker(Binning("opponent"), HeadRules(gate=0.4, gives_up=0.45))  # when it is lost
HAIR = 0.6  # above that share of the half height there is hair, which shows from behind; 1: none
CAMSHIFT = WindowTracker(Binning("HSI", (30, 16, 1)))  # hues and saturations
SHAPE = ColourShapeRules(
    binning=Binning("opponent", (32, 32, 4)), opening=3, snake=SnakeRules(reach=(20.0, 3.0))
)
DRIFT = [0.01] * 3 + [0.005] * 3 + [0.03] * 2  # of the colours: mean, spread, turn (rad) a picture
SURE = CertaintyRules()  # below its `least` the thing counts as lost; least=0: as trackers say
COLUMNS = {"u_px": 1e5, "v_px": 1e5}  # of a file with an outline
KINDS = {
    "ellipse": "An upright ellipse by its colours: for heads.",
    "camshift": "A window by its colours, OpenCV's: the everyday way.",
    "shape": "Colours and outline: for things of one shape.",
}
BOX = Numbers(
    "u,v,width,height",
    "Where it is in the first picture, px: column and row of its first pixel, counted from 0, and"
    " its size, 56,20,31,45; or a CSV file with an outline, columns u_px,v_px.",
    or_file=True,
)
RESULTS = {
    ".csv": "Boxes: frame,x,y,w,h,certainty,lost; x and y count pixels from 1.",
    "_outlines.csv": "Outlines: frame,u_px,v_px, counted from 0.",
    ".mp4": "The pictures with the outline, red where the thing is lost.",
}
TURN = np.linspace(0, 2 * np.pi, 40, endpoint=False)
RING = np.stack([np.cos(TURN), np.sin(TURN)], axis=-1)

Outline = np.ndarray  # (n, 2), columns and rows, px
Step = Callable[[np.ndarray], tuple[Outline, bool]]  # from a picture to an outline, whether lost


def first_outline(box: Path | tuple[float, ...], size: tuple[int, int]) -> Outline:
    """The ellipse in a box u,v,width,height, or the outline in a file."""
    if isinstance(box, Path):
        outline = np.column_stack(list(datasets.read_columns(box, COLUMNS).values()))
    else:
        u, v, width, height = box
        if not min(width, height) > 0:
            raise ValueError(f"BOX must have an area, got {width:g} by {height:g} px")
        outline = [u + (width - 1) / 2, v + (height - 1) / 2] + RING * [width / 2, height / 2]
    if (outline.max(axis=0) < 0).any() or (outline.min(axis=0) > np.subtract(size, 1)).any():
        raise ValueError("BOX must reach into the picture of {} by {} px".format(*size))
    return outline


def by_ellipse(image: np.ndarray, outline: Outline) -> Step:
    (u, v), (width, height) = (outline.max(axis=0) + outline.min(axis=0)) / 2, np.ptp(outline, 0)
    ellipse = Ellipse(round(u), round(v), round(np.sqrt(width * height / 4.8)))  # of equal area
    state, (high, wide) = HEAD.start(image, ellipse), image.shape[:2]
    top = np.arange(high)[:, None] < ellipse.v - HAIR * ellipse.half_height
    if (top & (inside := ellipse.mask((wide, high)))).any():
        hair = histogram(HEAD.binning.index(image), HEAD.binning.count, top & inside)
        model = two_views(state.model, hair * (state.model.sum() / hair.sum()))
        state = replace(state, model=model)

    def step(image: np.ndarray) -> tuple[Outline, bool]:
        nonlocal state
        state, info = HEAD.step(state, image)
        found = state.ellipse
        return [found.u, found.v] + RING * [found.half_width, found.half_height], info.lost

    return step


def by_camshift(image: np.ndarray, outline: Outline) -> Step:
    state = CAMSHIFT.start(image, outline)

    def step(image: np.ndarray) -> tuple[Outline, bool]:
        nonlocal state
        state, info = CAMSHIFT.step(state, image)
        return state.outline, not info.found

    return step


def by_shape(image: np.ndarray, outline: Outline) -> Step:
    rng, stays = np.random.default_rng(1), np.diag([1.0] * 6 + [0.0] * 2)
    tracker = ColourShapeTracker(Dynamics(stays, np.zeros(8), np.diag(DRIFT)), SHAPE)
    state = tracker.start(image, outline, rng=rng)

    def step(image: np.ndarray) -> tuple[Outline, bool]:
        nonlocal state
        state, info = tracker.step(state, image, rng=rng)
        return state.outline, info.lost

    return step


TRACKERS = {"ellipse": by_ellipse, "camshift": by_camshift, "shape": by_shape}


def follow(kind: str, pictures, outline: Outline, rows: list) -> Iterator[np.ndarray]:
    """Each picture with the outline in it, red where lost; the outlines are put into rows."""
    step, lost = None, False
    for image in pictures:
        if step is None:
            step, first = TRACKERS[kind](image, outline), original(image, outline, SURE)
        else:
            outline, lost = step(image)
        sure = certainty(image, outline, first, SURE)
        lost = lost or sure.lost
        rows.append((outline, lost, sure.probability))
        drawn = image.copy()
        line = outline.round().astype(np.int32)
        cv2.polylines(drawn, [line], True, (230, 30, 30) if lost else (0, 220, 0), 2)
        yield drawn


@script
@click.argument("kind", type=Kinds(KINDS))
@click.argument("film", type=Recording(FILM))
@click.argument("box", type=BOX)
@click.argument("out", type=Results(RESULTS))
def main(kind, film, box, out, topic, force):
    """Follow a thing in a film, or in a folder of pictures, from its box in the first one."""
    within("RATE", RATE, 0.01, 1000, "pictures in a second")
    recorded, rows = datasets.read_film(film, topic=topic), []
    outline = first_outline(box, recorded.size)
    frames = follow(kind, tqdm(recorded, "pictures", recorded.promised), outline, rows)
    rate = recorded.rate or RATE
    count = datasets.write_video(out[".mp4"], frames, rate=rate, overwrite=force)
    numbers = np.array(recorded.numbers)
    outlines, lost, sure = zip(*rows, strict=True)
    low, high = (np.array([f(line, axis=0) for line in outlines]) for f in (np.min, np.max))
    corner = np.floor(low + 0.5)  # the first pixel inside; ends of a box lie between two
    size = np.maximum(np.ceil(high - 0.5) - corner + 1, 1)
    told = dict(zip("xywh", np.hstack([corner + 1, size]).T, strict=True))  # x and y count from 1
    columns = {"frame": numbers, **told, "certainty": sure, "lost": np.array(lost) * 1}
    datasets.write_columns(out[".csv"], columns, overwrite=force)
    u, v = np.vstack(outlines).T
    whose = np.repeat(numbers, [len(line) for line in outlines])
    columns = {"frame": whose, "u_px": u, "v_px": v}
    datasets.write_columns(out["_outlines.csv"], columns, overwrite=force)
    print(f"pictures: {count}, of which lost: {sum(lost)}, certainty: {np.mean(sure):.2f}")
    tell(recorded)
    last = ",".join(f"{value:.0f}" for value in [*corner[-1], *size[-1]])
    print(f"last box: {last}, certainty: {sure[-1]:.2f}{', lost' * bool(lost[-1])}")


if __name__ == "__main__":
    main()
