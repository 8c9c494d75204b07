"""Fig. 13 rebuilt: circles, a rectangle, a beetle and a snail, by colour, by shape, by both.

The four films stand in for those of the paper. What is learned of the colours' motion comes from a
film of its own kind with another seed; parameters were chosen on the films `CHOOSING`.
"""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from time import perf_counter

import cv2
import numpy as np
from jaxtyping import Float, UInt8

from data_synth import coloured
from robot_perception.appearance.affine_snake import SnakeRules
from robot_perception.appearance.colour_distribution import Dynamics, describe, learn
from robot_perception.appearance.colour_shape import (
    ColourShapeRules,
    ColourShapeTracker,
    colours_inside,
)
from robot_perception.appearance.colour_spaces import Binning
from robot_perception.appearance.segmentation import filled
from robot_perception.appearance.single_cues import ColourTracker, EdgeTracker
from robot_perception.evaluation.sweep import sweep

WORLDS: dict[str, Callable[..., coloured.Sequence]] = {
    "circles": coloured.circles,
    "rectangle": coloured.rectangle,
    "beetle": coloured.beetle,
    "snail": coloured.snail,
}
CHOOSING = (9001, 9002, 9003, 9004)
"""Seeds of the films on which parameters were chosen; none of them is scored."""
TRAINING = 8001
"""Seed of the films from which A and B are learned."""
LOST = 0.2
"""Overlap below which an outline is no longer on the object."""
TRACKERS = ("colour, fixed", "colour, adapted", "shape", "fused", "CamShift")

RULES = ColourShapeRules(
    binning=Binning("opponent", (32, 32, 4)), opening=3, snake=SnakeRules(reach=(20.0, 3.0))
)
IN_RGB = replace(RULES, binning=Binning("RGB", (8, 8, 8)))


@dataclass(frozen=True, slots=True)
class Config:
    """Films and trackers.

    The paper names the four films, RGB for the circles and (B − G, G − R, R + G + B) for the
    others; the number of samples and all else is ours.

    Parameters
    ----------
    worlds
        Names of the films, of `WORLDS`.
    films
        Seeds of each.
    frames
        Frames of each film that are tracked.
    trackers
        Of `TRACKERS`.
    rules
        Of all trackers, but for the circles.
    in_rgb
        For the circles.
    order, ridge
        Of the dynamics that are learned. A weak ridge takes the way that the colours happened to go
        in training for a law, and drives the samples off the colours of another film.
    """

    worlds: tuple[str, ...] = tuple(WORLDS)
    films: tuple[int, ...] = tuple(range(1001, 1011))
    frames: int = 60
    trackers: tuple[str, ...] = TRACKERS
    rules: ColourShapeRules = RULES
    in_rgb: ColourShapeRules = IN_RGB
    order: int = 1
    ridge: float = 100.0

    def of(self, world: str) -> ColourShapeRules:
        """Return the rules for a film."""
        return self.in_rgb if world == "circles" else self.rules

    def film(self, world: str, seed: int) -> coloured.Sequence:
        """Return a film as long as it is tracked, and its first frame."""
        return WORLDS[world](rng=np.random.default_rng(seed), frames=self.frames + 1)


@dataclass(frozen=True, eq=False, slots=True)
class Result:
    """How well outlines overlap with the truth, by "film, tracker".

    Parameters
    ----------
    overlap
        Intersection over union of the insides, (films, frames).
    missed
        Whether the tracker itself said that it had lost the object, (films, frames).
    """

    overlap: Mapping[str, Float[np.ndarray, "films frames"]]
    missed: Mapping[str, np.ndarray]

    def mean(self, world: str, tracker: str) -> Float[np.ndarray, " films"]:
        """Return the mean overlap of each film."""
        return self.overlap[f"{world}, {tracker}"].mean(axis=1)

    def lost(self, world: str, tracker: str) -> float:
        """Return the share of the films in whose last frame the outline is off the object."""
        return float((self.overlap[f"{world}, {tracker}"][:, -1] < LOST).mean())


def truths(
    film: coloured.Sequence, rules: ColourShapeRules, *, rng: np.random.Generator
) -> Float[np.ndarray, "n 8"]:
    """Return the states of the target's true colours, frame by frame."""
    states, axes = [], None
    for image, outline in zip(film.frames, film.outlines, strict=True):
        seen = colours_inside(image, outline, rules, rng=rng)
        if seen is None:  # beyond the image
            continue
        found = describe(seen, axes)
        axes = found.axes
        states.append(found.state)
    states[0][6:] = 0.0  # from the axes of the space: no turn of the colours
    return np.array(states)


def trained(world: str, config: Config) -> Dynamics:
    """Return A, b and B learned from the film of a world that is for training."""
    film = WORLDS[world](rng=np.random.default_rng(TRAINING))
    states = truths(film, config.of(world), rng=np.random.default_rng(TRAINING))
    return learn(states, order=config.order, ridge=config.ridge)


def overlap(
    one: Float[np.ndarray, "n 2"], other: Float[np.ndarray, "m 2"], shape: tuple[int, int]
) -> float:
    """Return the intersection over union of the insides of two outlines within an image."""
    first, second = filled(one, shape), filled(other, shape)
    return float((first & second).sum() / max((first | second).sum(), 1))


def follow(
    tracker: str,
    film: coloured.Sequence,
    dynamics: Dynamics,
    rules: ColourShapeRules,
    *,
    rng: np.random.Generator,
) -> Iterator[tuple[Float[np.ndarray, "n 2"], bool]]:
    """Yield the outline in each frame after the first, and whether the tracker calls it lost."""
    first, outline = film.frames[0], film.outlines[0]
    if tracker == "CamShift":
        yield from _camshift(film)
        return
    if tracker == "fused":
        fused = ColourShapeTracker(dynamics, rules)
        state = fused.start(first, outline, rng=rng)
        for image in film.frames[1:]:
            state, _ = fused.step(state, image, rng=rng)
            yield state.outline, state.lost > 0
        return
    single = {
        "colour, fixed": ColourTracker(rules),
        "colour, adapted": ColourTracker(rules, adapt=True),
        "shape": EdgeTracker(rules),
    }[tracker]
    seen = single.start(first, outline)
    for image in film.frames[1:]:
        seen = single.step(seen, image)
        yield seen.outline, seen.lost > 0


def run(config: Config, *, rng: np.random.Generator) -> Result:
    """Return the overlap of all trackers on all films."""
    dynamics = {world: trained(world, config) for world in config.worlds}
    items = [
        (world, seed, dynamics[world], config) for world in config.worlds for seed in config.films
    ]
    found = sweep(_film, items, rng=rng, desc="films")
    names = [f"{world}, {tracker}" for world in config.worlds for tracker in config.trackers]
    by_name: dict[str, list] = {name: [] for name in names}
    for (world, *_), films in zip(items, found, strict=True):
        for tracker, one in films.items():
            by_name[f"{world}, {tracker}"].append(one)
    stacked = {name: np.array(films) for name, films in by_name.items()}
    return Result(
        {name: value[:, 0] for name, value in stacked.items()},
        {name: value[:, 1] > 0 for name, value in stacked.items()},
    )


def _film(
    item: tuple[str, int, Dynamics, Config], *, rng: np.random.Generator
) -> dict[str, Float[np.ndarray, "2 frames"]]:
    """Return overlap and losses of the trackers on one film; each has its own chance, always."""
    world, seed, dynamics, config = item
    film = config.film(world, seed)
    shape = film.frames.shape[1:3]
    chances = dict(zip(TRACKERS, rng.spawn(len(TRACKERS)), strict=True))
    found = {}
    for tracker in config.trackers:
        steps = follow(tracker, film, dynamics, config.of(world), rng=chances[tracker])
        rows = [
            (overlap(outline, truth, shape), float(lost))
            for (outline, lost), truth in zip(steps, film.outlines[1:], strict=True)
        ]
        found[tracker] = np.array(rows).T
    return found


def _camshift(film: coloured.Sequence) -> Iterator[tuple[Float[np.ndarray, "n 2"], bool]]:
    """Yield the ellipses of OpenCV's CamShift on hue and saturation of the first outline."""
    shape, ring = film.frames.shape[1:3], np.linspace(0, 2 * np.pi, 40, endpoint=False)
    inside = filled(film.outlines[0], shape)
    ranges, stop = [0, 180, 0, 256], (cv2.TERM_CRITERIA_EPS | cv2.TERM_CRITERIA_COUNT, 10, 1)
    hsv = cv2.cvtColor(film.frames[0], cv2.COLOR_RGB2HSV)
    model = cv2.calcHist([hsv], [0, 1], inside.astype(np.uint8), [30, 16], ranges)
    cv2.normalize(model, model, 0, 255, cv2.NORM_MINMAX)
    window = cv2.boundingRect(np.round(film.outlines[0]).astype(np.int32))
    outline = film.outlines[0]
    for image in film.frames[1:]:
        hsv = cv2.cvtColor(image, cv2.COLOR_RGB2HSV)
        likely = cv2.calcBackProject([hsv], [0, 1], model, ranges, 1)
        (centre, size, angle), found = cv2.CamShift(likely, window, stop)
        lost = min(size) < 2 or min(found[2:]) < 1
        if not lost:
            window, turn = found, np.deg2rad(angle)
            u, v = size[0] / 2 * np.cos(ring), size[1] / 2 * np.sin(ring)
            along = np.cos(turn) * u - np.sin(turn) * v, np.sin(turn) * u + np.cos(turn) * v
            outline = np.stack(along, axis=-1) + centre
        yield outline, lost


@dataclass(frozen=True, eq=False, slots=True)
class Stages:
    """Seconds that each stage takes in a frame, all samples together."""

    seconds: dict[str, float] = field(default_factory=dict)

    @property
    def total(self) -> float:
        """Seconds a frame."""
        return sum(self.seconds.values())


def stages(
    world: str = "snail", frames: int = 10, config: Config | None = None, seed: int = CHOOSING[0]
) -> Stages:
    """Return how long each stage of the fused tracker takes a frame, on the machine at hand."""
    config = Config() if config is None else config
    film = WORLDS[world](rng=np.random.default_rng(seed), frames=frames + 2)
    rng = np.random.default_rng(seed)
    tracker = ColourShapeTracker(trained(world, config), config.of(world))
    state = tracker.start(film.frames[0], film.outlines[0], rng=rng)
    state, _ = tracker.step(state, film.frames[1], rng=rng)  # compiles
    spent: dict[str, float] = {}
    began = 0.0

    def watch(stage: str) -> None:
        nonlocal began
        now = perf_counter()
        spent[stage] = spent.get(stage, 0.0) + now - began
        began = now

    for image in film.frames[2:]:
        began = perf_counter()
        state, _ = tracker.step(state, image, rng=rng, watch=watch)
    return Stages({stage: seconds / frames for stage, seconds in spent.items()})


def shown_colours(film: coloured.Sequence) -> UInt8[np.ndarray, "n 3"]:
    """Return the mean visible colour of the target in each frame, red, green and blue."""
    means = [image[mask].mean(axis=0) for image, mask in zip(film.frames, film.masks, strict=True)]
    return np.round(means).astype(np.uint8)
