"""Colour, shape, or both: who keeps the object, on films that no number was chosen on.

All claims read one result: each film of the four kinds is followed once by every tracker.
"""

import numpy as np
from jaxtyping import Float

from robot_perception.chapters.colour_and_shape.experiments import LOST, WORLDS, Result
from robot_perception.chapters.colour_and_shape.followed import FEW, FRAMES, changed, followed
from robot_perception.chapters.colour_and_shape.snakes import PAPER
from robot_perception.evaluation.intervals import Interval, bootstrap_mean, proportion
from robot_perception.teaching.claims import Finding, Size, claim
from robot_perception.teaching.tables import Table
from robot_perception.teaching.verdicts import Accepted, Origin

FURTHER = Accepted(0.02, 1.0, "two hundredths of overlap; the paper names no number", Origin.CHOICE)
OFTEN = Accepted(0.02, 1.0, "two films in a hundred; the paper names no number", Origin.CHOICE)


def overlaps(found: Result, tracker: str) -> Float[np.ndarray, " films"]:
    """Return the mean overlap of a tracker in every film, of all kinds."""
    return np.concatenate([found.mean(world, tracker) for world in WORLDS])


def losses(found: Result, tracker: str) -> Float[np.ndarray, " films"]:
    """Return for every film 1 if the outline is off the object in the last frame, else 0."""
    last = [found.overlap[f"{world}, {tracker}"][:, -1] < LOST for world in WORLDS]
    return np.concatenate(last).astype(float)


def further(found: Result, other: str) -> Interval:
    """Return by how much the fused tracker overlaps further than another, film by film."""
    return bootstrap_mean(overlaps(found, "fused") - overlaps(found, other))


def more_often(found: Result, other: str) -> Interval:
    """Return in how many more of the films another tracker ends off the object."""
    return bootstrap_mean(losses(found, other) - losses(found, "fused"))


NAMES = {
    "fused": "both",
    "shape": "edges alone",
    "colour, fixed": "colour, fixed",
    "colour, adapted": "colour, adapted",
    "CamShift": "CamShift",
}


def among_few(found: Result) -> Result:
    """Return the result of the films on which changed trackers are followed as well."""
    return Result(
        {name: films[:FEW] for name, films in found.overlap.items()},
        {name: films[:FEW] for name, films in found.missed.items()},
    )


def overlap_table(found: Result) -> Table:
    """Return the mean overlap by tracker and kind of film."""
    rows = {
        name: [bootstrap_mean(found.mean(world, tracker)) for world in WORLDS]
        for tracker, name in NAMES.items()
    }
    what = "mean overlap of the inside of the outline with the true one"
    return Table(rows, dict.fromkeys(WORLDS, what), _about(found), "tracker")


def loss_table(found: Result) -> Table:
    """Return the share of films that end off the object, by tracker and kind."""
    rows = {
        name: [found.lost(world, tracker) for world in WORLDS] for tracker, name in NAMES.items()
    }
    what = f"share of the films in whose last frame the overlap is below {LOST:g}"
    return Table(rows, dict.fromkeys(WORLDS, what), _about(found), "tracker")


def _about(found: Result) -> str:
    films = len(found.overlap["circles, fused"])
    return f"{films} films of {FRAMES} frames each, 95 % over films"


@claim(
    "four-experiments",
    paper=PAPER,
    place="§3.4, Fig. 13",
    basis="substitute",
    statement="The tracker that joins colour and shape is on the object at the end in at least nine "
    "films of ten.",
    paper_value="shown working on four films",
    method="Rendered circles of changing colour, a rectangle round a lamp, beetles and snails; "
    "share of all films in whose last frame the outline overlaps with the object (0.2 or more).",
    accepted=Accepted(0.9, 1.0, "the paper shows four of four and no share", Origin.CHOICE),
    seed=79,
)
def four(size: Size, rng: np.random.Generator) -> Finding:
    """Count the films that the fused tracker follows to the end."""
    found = followed()
    return Finding(
        _followed_share(found),
        tables={"overlap": overlap_table(found), "lost": loss_table(found)},
        note="Another circle has the same shape, and for a while may have the same colour.",
    )


def _followed_share(found: Result) -> Interval:
    lost = losses(found, "fused")
    return proportion(int((1 - lost).sum()), len(lost))


@four.sabotage("samples that do not spread: B = 0")
def no_spread(size: Size, rng: np.random.Generator) -> Finding:
    """Move the samples without noise."""
    return Finding(_followed_share(changed("no spread")))


@claim(
    "colour-condensation",
    paper=PAPER,
    place="§3, §3.3",
    basis="substitute",
    statement="Samples of the colour distribution that are weighed by shape overlap further with "
    "the object than colours that are adapted without a check.",
    paper_value="“they do not check for the goodness of the adaptation, which can still lead to "
    "failure”",
    method="The films of `four-experiments`: mean overlap with the true outline of the fused "
    "tracker, less that of one whose colours are those of the piece it found last.",
    accepted=FURTHER,
    seed=80,
)
def condensation(size: Size, rng: np.random.Generator) -> Finding:
    """Compare weighed samples with unchecked adaptation."""
    found, one = followed(), changed("one sample")
    gained = overlaps(among_few(found), "fused") - overlaps(one, "fused")
    return Finding(
        further(found, "colour, adapted"),
        {
            "films lost more often": more_often(found, "colour, adapted"),
            "overlap, fifty samples less one": bootstrap_mean(gained),
        },
    )


@condensation.sabotage("one sample in place of fifty")
def one_sample(size: Size, rng: np.random.Generator) -> Finding:
    """Give shape nothing to choose from."""
    one, found = changed("one sample"), among_few(followed())
    return Finding(bootstrap_mean(overlaps(one, "fused") - overlaps(found, "colour, adapted")))


@claim(
    "colour-alone",
    paper=PAPER,
    place="§3",
    basis="substitute",
    statement="The colours of the first frame alone lose the object more often than colour and "
    "shape together.",
    paper_value="“the fusion of several visual modules … offers more reliability”",
    method="The films of `four-experiments`: share that end off the object with the histogram of "
    "the first frame, less that of the fused tracker.",
    accepted=OFTEN,
    seed=81,
)
def colour_alone(size: Size, rng: np.random.Generator) -> Finding:
    """Compare fixed colours with colour and shape."""
    found = followed()
    return Finding(more_often(found, "colour, fixed"), {"overlap": further(found, "colour, fixed")})


@colour_alone.sabotage("samples that do not spread: B = 0")
def stale(size: Size, rng: np.random.Generator) -> Finding:
    """Compare fixed colours with a fused tracker whose colours do not move by chance."""
    still, found = changed("no spread"), among_few(followed())
    return Finding(bootstrap_mean(losses(found, "colour, fixed") - losses(still, "fused")))


@claim(
    "shape-alone",
    paper=PAPER,
    place="§3",
    basis="substitute",
    statement="Edges alone lose the object more often than colour and shape together.",
    paper_value="“the fusion of several visual modules … offers more reliability”",
    method="The films of `four-experiments`: share that end off the object with an affine snake on "
    "all edges of the image, less that of the fused tracker.",
    accepted=OFTEN,
    seed=82,
)
def shape_alone(size: Size, rng: np.random.Generator) -> Finding:
    """Compare edges alone with colour and shape."""
    found = followed()
    by_kind = {
        f"overlap, {world}": bootstrap_mean(found.mean(world, "fused") - found.mean(world, "shape"))
        for world in WORLDS
    }
    return Finding(more_often(found, "shape"), by_kind)


@shape_alone.sabotage("the printed sign of Φ_area")
def printed_sign(size: Size, rng: np.random.Generator) -> Finding:
    """Compare edges alone with a fused tracker that prefers wrong areas."""
    printed, found = changed("printed area"), among_few(followed())
    return Finding(bootstrap_mean(losses(found, "shape") - losses(printed, "fused")))
