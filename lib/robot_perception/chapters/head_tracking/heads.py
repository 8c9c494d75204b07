"""Rendered heads in changing light, and how far variants of the tracker overlap with them."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import lru_cache, partial
from types import MappingProxyType

import numpy as np
from jaxtyping import Bool, Float, UInt8

from data_synth.coloured import HeadScene, HeadSequence, head
from robot_perception.appearance.colour_histograms import histogram, two_views
from robot_perception.appearance.colour_spaces import Binning
from robot_perception.appearance.head_ellipse import Ellipse, HeadRules, HeadState, HeadTracker
from robot_perception.appearance.segmentation import filled
from robot_perception.appearance.single_cues import WindowTracker
from robot_perception.evaluation.sweep import sweep
from robot_perception.teaching.results import kept

CHOOSING = tuple(range(3001, 3031))
"""Sequences of every scene on which the numbers that the paper leaves out were chosen."""
SCORED = tuple(range(5001, 5061))
"""Sequences that are scored; no number was chosen on them, and nothing was changed after."""
SEEN = 0.5
"""A head of which that share is visible should be followed; ours."""
OFF = 0.2
"""An overlap below that is none; ours."""
RATES = (0.02, 0.1, 0.5)
GATES = (0.0, 0.4, 0.5, 0.6, 0.7, 0.8)
"""Values of a and of the threshold that are compared."""
RULES = HeadRules(measure="shares", rate=0.02, gate=0.4)
"""Where the size comes from the distance. Of all pairs of `RATES` and `GATES` this one misses the
head least often in the films `CHOOSING`, all scenes together; as in the paper it never gives up."""
SEARCHING = replace(RULES, measure="printed")
"""Where it is searched: common pixels are counted, and more of them are better."""
GIVES_UP = 0.45
"""The score below which a tracker of ours says that it has lost the head, and then searches
further off and does not adapt; the paper has no such rule."""


@dataclass(frozen=True, slots=True)
class Variant:
    """A way to follow a head.

    Parameters
    ----------
    rules
        Of the tracker.
    space
        In which colours are counted; the paper's is "opponent".
    bins
        Along its coordinates; those of the space if not given.
    views
        Whether the model holds hair beside what the first image shows of the head.
    depth
        Whether the size comes from the distance, as in the paper; if not it is searched.
    mass
        Of the model, in that of the first ellipse: 2 are those of two views together. A model of
        one view has as much, else it would have less in common with all that is compared.
    """

    rules: HeadRules = RULES
    space: str = "opponent"
    bins: tuple[int, int, int] | None = None
    views: bool = True
    depth: bool = True
    mass: float = 2.0


CELLS = {
    "some 800": ((16, 16, 8), (9, 9, 10)),
    "some 2000": ((24, 24, 10), (13, 13, 13)),
    "some 4000": ((32, 32, 12), (16, 16, 16)),
}
"""Cells of the opponent space and of RGB: of those of the one, colours of bytes reach 818, 2186 and
4176, and all 810, 2197 and 4096 of the other."""
EIGHT = (2, 2, 2)
"""Cells of RGB, far fewer than of the opponent space."""


def pair(rate: float, gate: float, floor: float = 0.0) -> str:
    """Return the name of the tracker with a, a threshold and a score below which it gives up."""
    return f"a = {rate:g} above {gate:g}" + (", gives up" if floor else "")


FIXED = Variant(replace(RULES, rate=0.0))
GRID = {
    pair(rate, gate, floor): Variant(replace(RULES, rate=rate, gate=gate, gives_up=floor))
    for rate in RATES
    for gate in GATES
    for floor in (0.0, GIVES_UP)
    if floor == 0 or rate == RULES.rate
}
"""Trackers with every a and threshold, and with our a those that give up, too."""
VARIANTS: Mapping[str, Variant] = MappingProxyType(
    GRID
    | {
        "adapted": Variant(),
        "fixed": FIXED,
        "adapted, gives up": GRID[pair(RULES.rate, RULES.gate, GIVES_UP)],
        "fixed, gives up": replace(FIXED, rules=replace(FIXED.rules, gives_up=GIVES_UP)),
        "one view": Variant(views=False),
        "one view, fixed": replace(FIXED, views=False),
        "one view, fixed, gives up": replace(
            FIXED, views=False, rules=replace(FIXED.rules, gives_up=GIVES_UP)
        ),
        "mass of one": replace(FIXED, mass=1.0),
        "mass of one, one view": replace(FIXED, mass=1.0, views=False),
        "size searched": Variant(SEARCHING, depth=False),
        "searched by highest score": Variant(replace(SEARCHING, size="score"), depth=False),
        "RGB, eight": replace(FIXED, space="RGB", bins=EIGHT),
    }
    | {
        f"{space}, {cells}{more}": Variant(replace(RULES, **rules), space, bins[space == "RGB"])
        for cells, bins in CELLS.items()
        for space in ("opponent", "RGB")
        for more, rules in (
            ("", {"rate": 0.0}),
            (", adapted", {}),
            (", gives up", {"rate": 0.0, "gives_up": GIVES_UP}),
        )
    }
)
"""Who follows: fixed models in spaces and cells, unless they are called adapted."""


FIG9 = HeadScene()
"""The light changes, others pass, and the head turns its back; all numbers are ours."""


@dataclass(frozen=True, slots=True)
class Config:
    """Rendered sequences and who follows the head in them.

    Parameters
    ----------
    scene
        What happens in them, by default what does in Fig. 9.
    seeds
        Of the sequences; the paper has one film (Fig. 9), which is not to be had.
    frames
        Of each, 15 a second; the paper's number is not known.
    depth_sigma
        Of the distance that stands for the stereo module's, a share of it; ours.
    variants
        Names in ``VARIANTS``, and "CamShift" for OpenCV's.
    more
        The same, of those that only the full size has.
    """

    scene: HeadScene = FIG9
    seeds: tuple[int, ...] = SCORED
    frames: int = 150
    depth_sigma: float = 0.02
    variants: tuple[str, ...] = ("adapted", "fixed")
    more: tuple[str, ...] = ()


@dataclass(frozen=True, eq=False, slots=True)
class Track:
    """What a tracker said of each image.

    Parameters
    ----------
    ellipses : (n, 4)
        Centre (column, row), half width and half height, px.
    lost : (n,)
        Whether it said that it had lost the head.
    """

    ellipses: Float[np.ndarray, "n 4"]
    lost: Bool[np.ndarray, " n"]


@dataclass(frozen=True, eq=False, slots=True)
class Result:
    """Overlap of every variant with the truth in each image of each sequence.

    Parameters
    ----------
    variants
        Their names.
    iou : (variants, sequences, frames)
        Area that tracked and true outline share, of the area of both.
    visible : (sequences, frames)
        Share of the head that is visible.
    """

    variants: tuple[str, ...]
    iou: Float[np.ndarray, "variants sequences frames"]
    visible: Float[np.ndarray, "sequences frames"]

    def overlaps(self, variant: str) -> Float[np.ndarray, " sequences"]:
        """Return the mean overlap in each sequence, over images in which the head is visible."""
        return self._means(self.iou[self.variants.index(variant)])

    def off(self, variant: str) -> Float[np.ndarray, " sequences"]:
        """Return in which share of these images the overlap is below ``OFF``, by sequence."""
        return self._means(self.iou[self.variants.index(variant)] < OFF)

    def _means(self, values: np.ndarray) -> Float[np.ndarray, " sequences"]:
        seen = self.visible >= SEEN
        return (values * seen).sum(axis=1) / np.maximum(seen.sum(axis=1), 1)


@dataclass(frozen=True, eq=False, slots=True)
class Start:
    """What a tracker is told of the first image.

    Parameters
    ----------
    image : (height, width, 3)
        Red, green, blue.
    ellipse
        Of the tracker's form, with the area of the head.
    hair : (height, width)
        Which pixels of the head are taken for hair: those of its uppermost part.
    """

    image: UInt8[np.ndarray, "height width 3"]
    ellipse: Ellipse
    hair: Bool[np.ndarray, "height width"] = field(repr=False)


def start(image: UInt8[np.ndarray, "height width 3"], box: Float[np.ndarray, " 4"]) -> Start:
    """Return the start that a box of centre (column, row), half width and half height gives.

    Raises
    ------
    ValueError
        If the top of the box lies beyond the image: there the hair is looked for.
    """
    u, v, half_width, half_height = box
    size = image.shape[1::-1]
    ellipse = Ellipse(round(u), round(v), round(float(np.sqrt(half_width * half_height / 1.2))))
    rows, columns = np.arange(size[1])[:, None], np.arange(size[0])
    inside = ((columns - u) / half_width) ** 2 + ((rows - v) / half_height) ** 2 <= 1
    hair = inside & (rows < v - HAIR * half_height)
    if not hair.any():
        raise ValueError(f"box must show the top of the head, got {np.round(box, 1).tolist()}")
    return Start(image, ellipse, hair)


HAIR = 0.6
"""What of the head lies higher than that above its middle, of the half height, is hair; ours."""


def first_state(first: Start, variant: Variant) -> tuple[HeadTracker, HeadState]:
    """Return the tracker of a variant and its state after the first image."""
    tracker = HeadTracker(Binning(variant.space, variant.bins), variant.rules)
    state = tracker.start(first.image, first.ellipse)
    model, whole = state.model, state.model.sum()
    if variant.views:
        hair = histogram(tracker.binning.index(first.image), tracker.binning.count, first.hair)
        model = two_views(model, hair * (whole / hair.sum()))
    return tracker, replace(state, model=model * (variant.mass * whole / model.sum()))


def follow(
    frames: UInt8[np.ndarray, "n height width 3"],
    first: Start,
    variant: Variant,
    half_widths: Float[np.ndarray, " n"] | None = None,
) -> Track:
    """Return what a variant says of each image, the first of which it is told."""
    tracker, state = first_state(first, variant)
    states, lost = [state], [False]
    for k in range(1, len(frames)):
        half_width = None if half_widths is None else float(half_widths[k])
        state, info = tracker.step(state, frames[k], half_width=half_width)
        states.append(state)
        lost.append(info.lost)
    shapes = [(e.u, e.v, e.half_width, e.half_height) for e in (s.ellipse for s in states)]
    return Track(np.array(shapes, dtype=float), np.array(lost))


CAMSHIFT = WindowTracker(Binning("HSI", (30, 16, 1)))
"""OpenCV's, with the hues and saturations of the first picture."""


def camshift(frames: UInt8[np.ndarray, "n height width 3"], box: Float[np.ndarray, " 4"]) -> Track:
    """Return what OpenCV's CamShift says, told of the ellipse in a box."""
    turn = np.linspace(0, 2 * np.pi, 40, endpoint=False)
    ring = np.stack([np.cos(turn), np.sin(turn)], axis=-1)
    states = [CAMSHIFT.start(frames[0], box[:2] + ring * box[2:])]
    for frame in frames[1:]:
        states.append(CAMSHIFT.step(states[-1], frame)[0])
    low, high = (np.array([f(state.outline, axis=0) for state in states]) for f in (np.min, np.max))
    lost = np.array([state.lost > 0 for state in states])
    return Track(np.hstack([(low + high) / 2, (high - low) / 2]), lost)


def overlaps(track: Track, truth: Bool[np.ndarray, "n height width"]) -> Float[np.ndarray, " n"]:
    """Return the area that each ellipse shares with the truth, of the area of both."""
    rows, columns = np.arange(truth.shape[1])[:, None], np.arange(truth.shape[2])
    found = np.empty(len(truth))
    for k, (u, v, half_width, half_height) in enumerate(track.ellipses):
        mask = ((columns - u) / half_width) ** 2 + ((rows - v) / half_height) ** 2 <= 1
        found[k] = (mask & truth[k]).sum() / max((mask | truth[k]).sum(), 1)
    return found


@lru_cache(maxsize=2)
def film(scene: HeadScene, seed: int, frames: int = 150) -> HeadSequence:
    """Return the sequence of a seed."""
    return head(rng=np.random.default_rng(seed), frames=frames, scene=scene)


def insides(film: HeadSequence) -> Bool[np.ndarray, "n height width"]:
    """Return what lies inside the true outline of the head, hidden or not."""
    return np.array([filled(outline, film.masks.shape[1:]) for outline in film.outlines])


def sizes(film: HeadSequence, errors: Float[np.ndarray, " n"]) -> Float[np.ndarray, " n"]:
    """Return the half widths that distances give: those of the image before, with errors.

    Parameters
    ----------
    film
        What is seen.
    errors : (n,)
        Of each distance, as shares of it.
    """
    first = start(film.frames[0], film.ellipses[0]).ellipse.half_width
    depth = np.append(film.depth[0], film.depth[:-1]) * (1 + errors)
    return np.maximum(first * film.depth[0] / depth, 1.0)


def run(config: Config, *, rng: np.random.Generator) -> Result:
    """Return the overlap of all variants on all sequences."""
    found = sweep(partial(_with_errors, config), config.seeds, rng=rng, desc="heads")
    iou, visible = (np.array(part) for part in zip(*found, strict=True))
    return Result(config.variants + config.more, np.moveaxis(iou, 1, 0), visible)


def _with_errors(
    config: Config, seed: int, *, rng: np.random.Generator
) -> tuple[Float[np.ndarray, "variants n"], Float[np.ndarray, " n"]]:
    """Draw errors of the distances: all that is left to chance once there is a film."""
    errors = config.depth_sigma * rng.normal(size=config.frames)
    iou, visible = _followed(config.scene, seed, config.variants, tuple(errors.tolist()))
    if config.more:
        further, _ = _followed(config.scene, seed, config.more, tuple(errors.tolist()))
        iou = np.concatenate([iou, further])
    return iou, visible


@kept
def _followed(
    scene: HeadScene, seed: int, variants: tuple[str, ...], errors: tuple[float, ...]
) -> tuple[Float[np.ndarray, "variants n"], Float[np.ndarray, " n"]]:
    """Return the overlap of each variant with the head of a film, and what is visible of it."""
    shown = film(scene, seed, len(errors))
    first, truth = start(shown.frames[0], shown.ellipses[0]), insides(shown)
    half_widths = sizes(shown, np.array(errors))

    def track(name: str) -> Track:
        if name == "CamShift":
            return camshift(shown.frames, shown.ellipses[0])
        variant = VARIANTS[name]
        return follow(shown.frames, first, variant, half_widths if variant.depth else None)

    return np.array([overlaps(track(name), truth) for name in variants]), shown.visible
