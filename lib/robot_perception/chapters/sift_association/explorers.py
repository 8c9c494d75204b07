"""The states of the explorers: viewpoints, rules on a real pair, tracked frames and variances."""

from dataclasses import dataclass
from functools import cache

import numpy as np
from jaxtyping import Float, UInt8

from data_synth import stereo
from data_synth.stereo import Rig
from data_synth.textures import paint
from robot_perception.chapters.sift_association import recordings, table1, viewpoint
from robot_perception.landmarks import detect
from robot_perception.teaching.badges import recorded
from robot_perception.teaching.explore import choice, slider
from robot_perception.teaching.tables import Table

ANGLES = tuple(float(a) for a in range(0, 65, 5))
PICTURES = {"a poster": "poster", "a notice board": "notices", "a shelf of books": "books"}
VIEW_CONTROLS = {
    "subject": choice("Picture", PICTURES, "poster"),
    "angle": slider("Viewpoint", ANGLES, 15.0, "° aside"),
}
VIEW_PRESETS = {
    "30° aside": {"angle": 30.0},
    "a notice board, 45°": {"subject": "notices", "angle": 45.0},
    "too far": {"angle": 60.0},
}

ANY = 1e4
PAIR_CONTROLS = {
    "rows": choice("Rows", {"±2": 2.0, "±8": 8.0, "any": ANY}, 2.0),
    "threshold": choice(
        "Threshold", {"100": 100.0, "200": 200.0, "300": 300.0, "none": ANY}, 200.0
    ),
    "ratio": choice("Ratio to the second", {"0.7": 0.7, "0.8": 0.8, "0.9": 0.9, "none": 1.0}, 1.0),
}
PAIR_PRESETS = {
    "threshold alone": {"rows": ANY},
    "ratio alone": {"rows": ANY, "threshold": ANY, "ratio": 0.8},
    "nothing": {"rows": ANY, "threshold": ANY},
}

TABLE_MODELS = (table1.RAW, "shrunk", "pooled")
TABLE_MODELS += tuple(name + table1.WITH for name in TABLE_MODELS[:2])
TABLE_TRACKED = (3, 10, 30)
TABLE_CONTROLS = {
    "p": choice("Tracked frames", {str(p): p for p in TABLE_TRACKED}, 10),
    "model": choice("Decided by", {name: name for name in TABLE_MODELS}, table1.RAW),
    "where": choice("Descriptors from", {text: n for n, text in table1.TESTS.items()}, "again"),
    "track": choice("Track", {"to either side": "", "straight on": table1.STRAIGHT}, ""),
}
TABLE_PRESETS = {
    "its own frames": {"where": "trained", "p": 30},
    "three frames": {"p": 3},
    "straight on, then aside": {"p": 30, "where": "aside", "track": table1.STRAIGHT},
    "shrunk": {"model": "shrunk"},
}


# Viewpoint ---------------------------------------------------------------------------------------


@dataclass(frozen=True, eq=False, slots=True)
class View:
    """A picture from a viewpoint: which features of the view from ahead are found again, and how
    far their descriptors have moved; ``lost`` is how many are not.
    """

    image: UInt8[np.ndarray, "height width"]
    pixels: Float[np.ndarray, "n 2"]
    distances: Float[np.ndarray, " n"]
    lost: int


@cache
def view(subject: str, angle: float) -> View:
    """Return a state of the explorer of viewpoints."""
    scene, rig, config = _hung(subject), Rig(), viewpoint.Config()
    first, points = _ahead(subject)
    pose = viewpoint.stand(angle, config)
    image = stereo.render(scene, rig, pose, exposure=0.9, rng=np.random.default_rng(1)).left
    seen = detect(image)
    pairs = viewpoint.found_again(first, stereo.project(rig, pose, points), seen, config.distance)
    gaps = np.linalg.norm(first.descriptors[pairs[:, 0]] - seen.descriptors[pairs[:, 1]], axis=1)
    return View(image, seen.pixels[pairs[:, 1]], gaps, len(first) - len(pairs))


@cache
def _hung(picture: str) -> stereo.Scene:
    return viewpoint.hang(paint(picture, rng=np.random.default_rng(3)))


@cache
def _ahead(picture: str) -> tuple:
    scene, rig, config = _hung(picture), Rig(), viewpoint.Config()
    return viewpoint.seen_ahead(scene, rig, config, rng=np.random.default_rng(2))


def describe_view(subject: str, angle: float) -> str:
    """Return what a state of the explorer of viewpoints shows, in words."""
    found = view(subject, angle)
    total = len(found.pixels) + found.lost
    middle = f"{np.median(found.distances):.0f}" if len(found.pixels) else "nothing"
    name = next(text for text, kind in PICTURES.items() if kind == subject).capitalize()
    return (
        f"{name} seen from {angle:g}° aside: {len(found.pixels)} of {total} features are "
        f"found again; their descriptors have moved by {middle} of 512 in the median."
    )


# A real pair -------------------------------------------------------------------------------------


@cache
def aloe() -> recordings.Pair:
    """Return the features of the aloe: computed where the pictures are, else as stored."""
    return recordings.ALOE.read().result


def note() -> str:
    """Return a sentence that says whether the aloe was computed here."""
    return recordings.ALOE.read().note


@cache
def chosen(rows: float, threshold: float, ratio: float) -> recordings.Chosen:
    """Return a state of the explorer of the rules."""
    return recordings.choose(aloe(), rows, threshold, ratio)


def describe_pair(rows: float, threshold: float, ratio: float) -> str:
    """Return what a state of the explorer of the rules shows, in words."""
    found = chosen(rows, threshold, ratio)
    return (
        f"Of {np.count_nonzero(aloe().known)} features of the left picture "
        f"{(found.others >= 0).sum()} are matched, {found.share:.0%} of them right."
    )


# Table 1 -----------------------------------------------------------------------------------------


def rates(where: str, track: str = "") -> Table:
    """Return the recorded shares of right assignments."""
    return recorded()["table1"].tables[f"right, {table1.TESTS[where]}{track}"]


def confusions(where: str, track: str = "") -> Table:
    """Return the recorded shares of assignments to look-alikes."""
    return recorded()["table1"].tables[f"look-alikes, {table1.TESTS[where]}{track}"]


def describe_table(p: int, model: str, where: str, track: str) -> str:
    """Return what a state of the explorer of Table 1 shows, in words."""
    right = rates(where, track)[model, f"p = {p}"].estimate
    means = rates(where, track)[table1.EUCLID, f"p = {p}"].estimate
    first = rates(where, track)[table1.ONE_VIEW, f"p = {p}"].estimate
    alike = confusions(where, track)[model, f"p = {p}"].estimate
    way = "straight on" if track else "to either side of the path"
    return (
        f"Classes of {p} frames {way}, descriptors of {table1.TESTS[where]}, decided by {model}: "
        f"{right:.1f} % right, {alike:.1f} % taken for a look-alike; Euclid has {means:.1f} % to "
        f"the means and {first:.1f} % to the first views."
    )
