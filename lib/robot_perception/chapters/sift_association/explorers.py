"""The explorers: viewpoints, rules on a real pair, tracked frames and variances."""

from dataclasses import dataclass
from functools import cache, partial

import numpy as np

from data_synth.stereo import Rig, Scene
from data_synth.textures import paint
from robot_perception.chapters.sift_association import figures as draw
from robot_perception.chapters.sift_association import recordings, table1, viewpoint
from robot_perception.chapters.sift_association.recordings import Chosen, Pair
from robot_perception.chapters.sift_association.viewpoint import View
from robot_perception.landmarks import Features
from robot_perception.teaching.badges import recorded
from robot_perception.teaching.controls import choice, slider
from robot_perception.teaching.explorations import Exploration
from robot_perception.teaching.figures import figure, image_axes
from robot_perception.teaching.recordings import Read
from robot_perception.teaching.tables import Table

ANGLES = tuple(map(float, range(0, 65, 5)))
PICTURES = {"a poster": "poster", "a notice board": "notices", "a shelf of books": "books"}


def view(subject: str, angle: float) -> View:
    """Return a picture from a viewpoint."""
    return viewpoint.seen_from(angle, *_ahead(subject), rng=np.random.default_rng(1))


@cache
def _ahead(subject: str) -> tuple[Scene, Features, np.ndarray]:
    scene = viewpoint.hang(paint(subject, rng=np.random.default_rng(3)))
    return scene, *viewpoint.seen_ahead(scene, Rig(), rng=np.random.default_rng(2))


def describe_view(state: tuple[str, float, View]) -> str:
    """Return what is seen from a viewpoint, in words."""
    subject, angle, seen = state
    found = len(seen.pixels)
    middle = f"{np.median(seen.distances):.0f}" if found else "nothing"
    (name,) = (text for text, kind in PICTURES.items() if kind == subject)
    return (
        f"{name.capitalize()} seen from {angle:g}° to the side: {found} of {found + seen.lost} "
        f"features are found again; their descriptors have moved by {middle} of 512 in the "
        "median."
    )


VIEW = Exploration(
    lambda state: draw.view(state[-1]),
    lambda subject, angle: (subject, angle, view(subject, angle)),
    describe_view,
    {
        "subject": choice("Picture", PICTURES, "poster"),
        "angle": slider("Viewpoint", ANGLES, 15.0, "° aside"),
    },
    name="sift-view",
    caption="A picture in empty space. Circles: features of the view from straight ahead that are "
    "found again; the larger the circle, the farther the descriptor has moved; green up to 200 of "
    "512, magenta beyond.",
    presets={
        "30° aside": {"angle": 30.0},
        "a notice board, 45°": {"subject": "notices", "angle": 45.0},
        "too far": {"angle": 60.0},
    },
    axes=None,
    finding=lambda state: (len(state[-1].pixels), np.median(state[-1].distances)),
)


ANY = 1e4


@cache
def aloe() -> Read[Pair]:
    """Return the features of the aloe: computed where the pictures are, else as stored."""
    return recordings.ALOE.read()


def matched(rows: float = 2.0, threshold: float = 200.0, ratio: float = 1.0) -> Chosen:
    """Return what rules make of the aloe."""
    return recordings.choose(aloe().result, rows, threshold, ratio)


def describe_pair(found: Chosen) -> str:
    """Return how many of the features are matched, and how many right, in words."""
    return (
        f"Of {np.count_nonzero(aloe().result.known)} features of the left picture "
        f"{(found.others >= 0).sum()} are matched, {found.share:.0%} of them right."
    )


PLANT = Exploration(
    lambda ax, found: draw.matches.on(ax, aloe().result, found),
    matched,
    describe_pair,
    {
        "rows": choice("Rows", {"±2": 2.0, "±8": 8.0, "any": ANY}, 2.0),
        "threshold": choice(
            "Threshold", {"100": 100.0, "200": 200.0, "300": 300.0, "none": ANY}, 200.0
        ),
        "ratio": choice(
            "Ratio to the second", {"0.7": 0.7, "0.8": 0.8, "0.9": 0.9, "none": 1.0}, 1.0
        ),
    },
    name="sift-aloe",
    caption="Left picture of the aloe. Each line leads from a feature to the place of its match "
    "in the right picture: green right within 2 px, magenta wrong; grey dots: features without a "
    "match.",
    presets={
        "threshold alone": {"rows": ANY},
        "ratio alone": {"rows": ANY, "threshold": ANY, "ratio": 0.8},
        "nothing": {"rows": ANY, "threshold": ANY},
    },
    axes=lambda: image_axes(aloe().result.first),
    finding=lambda found: found.share,
)


MODELS = (table1.RAW, "shrunk", "pooled", table1.RAW + table1.WITH, "shrunk" + table1.WITH)


@dataclass(frozen=True, slots=True)
class Decision:
    """What decides, by how many tracked frames, on which descriptors, after which track."""

    p: int
    model: str
    where: str
    track: str

    def tables(self) -> tuple[Table, Table]:
        """Return the recorded shares of right assignments and of those to look-alikes."""
        tables, end = recorded()["table1"].tables, f"{table1.TESTS[self.where]}{self.track}"
        return tables[f"right, {end}"], tables[f"look-alikes, {end}"]

    def share(self, model: str) -> float:
        """Return the share of right assignments of a model, %."""
        return self.tables()[0][model, f"p = {self.p}"].estimate


def describe_table(state: Decision) -> str:
    """Return what a state of the explorer of Table 1 shows, in words."""
    alike = state.tables()[1][state.model, f"p = {state.p}"].estimate
    way = "straight on" if state.track else "to either side of the path"
    return (
        f"Classes of {state.p} frames {way}, descriptors of {table1.TESTS[state.where]}, decided "
        f"by {state.model}: {state.share(state.model):.1f} % right, {alike:.1f} % taken for a "
        f"look-alike; Euclid has {state.share(table1.EUCLID):.1f} % to the means and "
        f"{state.share(table1.ONE_VIEW):.1f} % to the first views."
    )


TABLE = Exploration(
    lambda axes, s: draw.table_state(axes, s.p, s.model, *s.tables()),
    Decision,
    describe_table,
    {
        "p": choice("Tracked frames", (3, 10, 30), 10),
        "model": choice("Decided by", MODELS, table1.RAW),
        "where": choice("Descriptors from", {text: n for n, text in table1.TESTS.items()}, "again"),
        "track": choice("Track", {"to either side": "", "straight on": table1.STRAIGHT}, ""),
    },
    name="sift-table",
    caption="Above: descriptors assigned to the wrong landmark, when compared with the first "
    "view of each, with the mean of its p descriptors, and with their variances as chosen. "
    "Below: the share of correct assignments over tracked frames; dashed: first views; thin: the "
    "other choices.",
    presets={
        "its own frames": {"where": "trained", "p": 30},
        "three frames": {"p": 3},
        "straight on, then aside": {"p": 30, "where": "aside", "track": table1.STRAIGHT},
        "shrunk": {"model": "shrunk"},
    },
    axes=partial(figure, 2, 1, width=6.4, height=6.4, gridspec_kw={"left": 0.2}),
    finding=lambda state: state.share(state.model) - state.share(table1.EUCLID),
)
