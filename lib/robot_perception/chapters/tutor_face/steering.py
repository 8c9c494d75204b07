"""Particles that detections steer, against particles alone: section III, I-Condensation."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from data_synth.companion.face_films import FaceFilm, FaceScene
from robot_perception.chapters.tutor_face.scene import DETECTOR, SCORED, film, greys
from robot_perception.companion.boxes import overlap
from robot_perception.companion.faces.icondensation import FaceFilter, FaceFilterRules
from robot_perception.evaluation.intervals import Interval, bootstrap_mean
from robot_perception.evaluation.sweep import sweep
from robot_perception.teaching.claims import Finding
from robot_perception.teaching.results import kept
from robot_perception.teaching.studies import Change, Study
from robot_perception.teaching.tables import Table
from robot_perception.teaching.verdicts import Accepted, Origin

PAPER = "companion-robot"
FILTERS = {
    "I-Condensation": FaceFilterRules(),
    "condensation": FaceFilterRules(steered=0.0),
    "condensation, ten times the particles": FaceFilterRules(steered=0.0, particles=1500),
}
ALONE = "the detector alone"
"""The largest of the last detections is where the face is taken to be."""
OFF = 0.2
"""An overlap below that is a loss; ours."""


@dataclass(frozen=True, slots=True)
class Config:
    """Films of one person whom the robot's turns throw about.

    Parameters
    ----------
    seeds
        Of the films.
    frames
        Of each.
    jumps
        How often the face is suddenly elsewhere, times a hundred pictures.
    filters
        Names in ``FILTERS``, and ``ALONE``.
    blind
        Whether the detector finds nothing.
    """

    seeds: tuple[int, ...] = SCORED[:24]
    frames: int = 80
    jumps: float = 4.0
    filters: tuple[str, ...] = (*FILTERS, ALONE)
    blind: bool = False


@dataclass(frozen=True, eq=False, slots=True)
class Result:
    """Where the filters were.

    Parameters
    ----------
    config
        What was run.
    lost : (films, filters)
        Share of the pictures in which the estimate is off the face.
    """

    config: Config
    lost: Float[np.ndarray, "films filters"]

    def of(self, name: str) -> Interval:
        """Return the mean share of one filter."""
        return bootstrap_mean(self.lost[:, self.config.filters.index(name)])


@kept
def followed(
    seed: int, frames: int, scene: FaceScene, name: str, blind: bool
) -> Float[np.ndarray, "n 4"]:
    """Return the boxes of a filter in each picture of a film, the first of which it is told."""
    shown = film(seed, frames, scene)
    if name == ALONE:
        return kept_detections(shown)
    filter_ = FaceFilter(FILTERS[name])
    rng = np.random.default_rng(seed)
    state = filter_.start(shown.frames[0], shown.boxes[0, 0], rng=rng)
    boxes = [state.box]
    for frame, grey in zip(shown.frames[1:], greys(shown)[1:], strict=True):
        steers = filter_.rules.steered > 0 and not blind
        detections = DETECTOR.find(grey) if steers else np.zeros((0, 4))
        state, _ = filter_.step(state, frame, detections, rng=rng)
        boxes.append(state.box)
    return np.array(boxes)


def kept_detections(shown: FaceFilm) -> Float[np.ndarray, "n 4"]:
    """Return the largest of the last detections in each picture, the first of which is told."""
    boxes = [shown.boxes[0, 0]]
    for grey in greys(shown)[1:]:
        found = DETECTOR.find(grey)
        boxes.append(found[0] if len(found) else boxes[-1])
    return np.array(boxes)


def overlaps(
    boxes: Float[np.ndarray, "n 4"], truth: Float[np.ndarray, "n 4"]
) -> Float[np.ndarray, " n"]:
    """Return how far boxes overlap with others, one by one."""
    pairs = zip(boxes, truth, strict=True)
    return np.array([overlap(a[None], b[None])[0, 0] for a, b in pairs])


def run(config: Config, *, rng: np.random.Generator) -> Result:
    """Follow the face of each film with each filter."""
    scene = FaceScene(jumps=config.jumps, pace=1.5)

    def task(seed: int, rng: np.random.Generator) -> list[float]:
        truth = film(seed, config.frames, scene).boxes[:, 0]
        boxes = (
            followed(seed, config.frames, scene, name, config.blind) for name in config.filters
        )
        return [float((overlaps(of, truth) < OFF).mean()) for of in boxes]

    return Result(config, np.array(sweep(task, config.seeds, rng=rng, desc="films")))


films = Study(run, full=Config(), quick=Config(SCORED[:6], 60, filters=tuple(FILTERS)[:2]), seed=4)
LESS = Accepted(
    0.02, 1.0, "at least one picture in fifty less is lost; the paper names no number",
    Origin.CHOICE,
)  # fmt: skip


def table(result: Result) -> Table:
    """Return the losses by filter."""
    rows = {
        name: [float(FILTERS[name].particles) if name in FILTERS else None, result.of(name)]
        for name in result.config.filters
    }
    columns = {
        "particles": "",
        "lost": f"share of the pictures in which the overlap is below {OFF:g}",
    }
    return Table(rows, columns, f"95 % over {len(result.lost)} films", "filter")


@films.claim(
    "icondensation-face",
    paper=PAPER,
    place="§III",
    basis="substitute",
    statement="Particles that the detector steers lose a face less often than particles that only "
    "walk.",
    paper_value="“importance sampling offers a mathematically principled way of directing search "
    "according to the face detector output”",
    method="Rendered films of a person who is suddenly elsewhere now and then, as the robot turns: "
    "share of pictures lost by condensation less that of I-Condensation, same colour and shape "
    "cues, 150 particles. Mean over films.",
    accepted=LESS,
    sabotage=Change("a detector that finds nothing", blind=True),
)
def icondensation_face(result: Result) -> Finding:
    """Compare the two, and condensation with more particles."""
    ours, plain = (result.config.filters.index(name) for name in tuple(FILTERS)[:2])
    return Finding(
        bootstrap_mean(result.lost[:, plain] - result.lost[:, ours]),
        {f"lost by {name}": result.of(name) for name in result.config.filters},
        tables={"lost": table(result)} if len(result.config.filters) > 2 else {},
    )
