"""The films of the page, and what trackers make of them: the states of its explorers."""

from dataclasses import dataclass, replace
from functools import cache

import numpy as np
from jaxtyping import Float, UInt8

from data_synth.coloured import HeadScene, HeadSequence
from robot_perception.appearance.colour_histograms import (
    histogram,
    intersection,
    intersection_of_shares,
    shares,
)
from robot_perception.appearance.colour_spaces import Binning
from robot_perception.appearance.head_ellipse import Ellipse
from robot_perception.chapters.head_tracking import heads
from robot_perception.chapters.head_tracking.heads import RULES, Start, Variant
from robot_perception.teaching.recorded import recorded
from robot_perception.teaching.tables import Table

SCENES = {
    "the light changes": (3030, HeadScene(others=0, turns=False)),
    "he turns his back, others pass": (3018, heads.FIG9),
}
"""Film and what happens in it, by name; both of those on which numbers were chosen, picked since
they show what a model can lose."""
LIGHT, CROWD = SCENES
SHOWN = (0, 100, 140)
"""Pictures of the first that are shown."""

RATES = (0.0, *heads.RATES)
GATES = (0.0, 0.4, 0.5, 0.6, 0.8)
FLOORS = (0.0, heads.GIVES_UP)


@cache
def filmed(scene: str) -> HeadSequence:
    """Return a film of the page."""
    seed, happens = SCENES[scene]
    return heads.film(happens, seed)


@cache
def beginning(scene: str) -> Start:
    """Return what a tracker is told of its first picture."""
    film = filmed(scene)
    return heads.start(film.frames[0], film.ellipses[0])


# How fast, and above which score -----------------------------------------------------------------


@dataclass(frozen=True, eq=False, slots=True)
class Tracks:
    """What every a and threshold makes of a film, with and without giving up.

    Parameters
    ----------
    iou : (rates, gates, floors, n)
        Overlap with the true head.
    ellipses : (rates, gates, floors, n, 4)
        Centre (column, row), half width and half height, px.
    light : (n,)
        On the head: mean of its three channels, shares of full light.
    visible : (n,)
        Share of the head that is visible.
    """

    iou: Float[np.ndarray, "rates gates floors n"]
    ellipses: Float[np.ndarray, "rates gates floors n 4"]
    light: Float[np.ndarray, " n"]
    visible: Float[np.ndarray, " n"]


@recorded("head-tracks", ((scene,) for scene in SCENES))
def tracks(scene: str) -> Tracks:
    """Return what every a and threshold makes of a film, with and without giving up."""
    film, first = filmed(scene), beginning(scene)
    truth = heads.insides(film)
    errors = np.random.default_rng(1).normal(size=len(truth))
    half_widths = heads.sizes(film, heads.Config().depth_sigma * errors)
    shape = len(RATES), len(GATES), len(FLOORS), len(truth)
    iou, ellipses = np.empty(shape), np.empty((*shape, 4))
    for i, j, k in np.ndindex(shape[:3]):
        rules = replace(RULES, rate=RATES[i], gate=GATES[j], gives_up=FLOORS[k])
        track = heads.follow(film.frames, first, Variant(rules), half_widths)
        iou[i, j, k], ellipses[i, j, k] = heads.overlaps(track, truth), track.ellipses
    return Tracks(iou, ellipses, film.light.mean(axis=1), film.visible)


def ellipses(scene: str, rate: float = RULES.rate) -> Float[np.ndarray, "n 4"]:
    """Return the ellipses of our tracker in a film, or of the one with another a."""
    at = RATES.index(rate), GATES.index(RULES.gate), FLOORS.index(RULES.gives_up)
    return tracks(scene).ellipses[at]


@dataclass(frozen=True, eq=False, slots=True)
class Followed:
    """A state of the explorer: overlap by picture, with the chosen values and with a = 0."""

    film: str
    rate: float
    gate: float
    floor: float
    iou: Float[np.ndarray, " n"]
    fixed: Float[np.ndarray, " n"]
    light: Float[np.ndarray, " n"]
    visible: Float[np.ndarray, " n"]

    def missed(self, iou: Float[np.ndarray, " n"]) -> float:
        """Return the share of the frames in which a visible head is missed."""
        return float((iou[self.visible >= heads.SEEN] < heads.OFF).mean())

    @property
    def rule(self) -> str:
        """When the trackers give up, in words."""
        return f"given up below {self.floor:g}" if self.floor else "never given up"

    def words(self) -> str:
        """Return what the state shows."""
        return (
            f"Overlap of ellipse and head in each frame of the film in which {self.film}, with a "
            f"= {self.rate:g} above a threshold of {self.gate:g}, {self.rule}: the head is "
            f"missed in {self.missed(self.iou):.0%} of the frames, by the fixed model in "
            f"{self.missed(self.fixed):.0%}."
        )


def followed(film: str, rate: float, gate: float, floor: float) -> Followed:
    """Return a state of the explorer of rate, threshold and giving up.

    The fixed model, for which the threshold means nothing, gives up where the other one does.
    """
    found, j, k = tracks(film), GATES.index(gate), FLOORS.index(floor)
    iou, fixed = found.iou[RATES.index(rate), j, k], found.iou[0, j, k]
    return Followed(film, rate, gate, floor, iou, fixed, found.light, found.visible)


# What the light does to a histogram --------------------------------------------------------------


@dataclass(frozen=True, eq=False, slots=True)
class HeadColours:
    """A picture, the colours of the true head in it, and what they share with the first picture's.

    Parameters
    ----------
    at
        Its number.
    image : (height, width, 3)
        What lies round the head.
    first, now : (n, 2), (m, 2)
        R + G + B and G − R of pixels of the head, in the first picture and in this one.
    common : {cells: share}
        Intersection of the histograms of the two heads, by the cells of `COMPARED`.
    """

    at: int
    image: UInt8[np.ndarray, "height width 3"]
    first: Float[np.ndarray, "n 2"]
    now: Float[np.ndarray, "m 2"]
    common: dict[str, float]

    def words(self) -> str:
        """Return what the state shows."""
        parts = ", ".join(f"{share:.0%} in {cells}" for cells, share in self.common.items())
        return f"Frame {self.at}: how much of the head's colours matches those of frame 0: {parts}."


COMPARED = {space: Binning(space) for space in ("RGB", "normalised rgb", "HSI", "opponent")} | {
    "opponent, finer cells": Binning("opponent", heads.CELLS["some 4000"][0])
}
"""Ways to count colours; of the last, colours reach about as many cells as of RGB."""
HALF = 60


@cache
def look(at: int) -> HeadColours:
    """Return a state of the explorer of colours."""
    film = filmed(LIGHT)
    u, v = np.round(film.ellipses[at, :2]).astype(int)
    height, width = film.masks.shape[1:]
    left, top = np.clip(u - HALF, 0, width - 2 * HALF), np.clip(v - HALF, 0, height - 2 * HALF)
    image = film.frames[at, top : top + 2 * HALF, left : left + 2 * HALF]
    common = {}
    for name, cells in COMPARED.items():
        first, now = (
            histogram(cells.index(film.frames[k]), cells.count, film.masks[k]) for k in (0, at)
        )
        common[name] = float(intersection_of_shares(now, shares(first)))
    return HeadColours(at, image, _chroma(0), _chroma(at), common)


def _chroma(at: int, most: int = 400) -> Float[np.ndarray, "n 2"]:
    """Return R + G + B and G − R of some pixels of the head."""
    film = filmed(LIGHT)
    pixels = film.frames[at][film.masks[at]].astype(float)
    red, green, blue = pixels[:: max(len(pixels) // most, 1)].T
    return np.stack([red + green + blue, green - red], axis=-1)


# Eq. (28) and the size ---------------------------------------------------------------------------


@dataclass(frozen=True, eq=False, slots=True)
class Sizes:
    """Scores of ellipses of all sizes in the middle of the true head.

    Parameters
    ----------
    half_widths : (k,)
        px.
    printed, by_shares : (k,)
        Eq. (28) with numbers of pixels, and of shares.
    true : ()
        Half width of an ellipse of the head's area, px.
    """

    half_widths: np.ndarray
    printed: Float[np.ndarray, " k"]
    by_shares: Float[np.ndarray, " k"]
    true: int


def sizes() -> Sizes:
    """Score ellipses of all sizes around the head of the first picture."""
    first, binning = beginning(LIGHT), Binning()
    index, size = binning.index(first.image), first.image.shape[1::-1]
    whole = first.ellipse

    def counted(half_width: int) -> np.ndarray:
        return histogram(index, binning.count, Ellipse(whole.u, whole.v, half_width).mask(size))

    model, widths = counted(whole.half_width), np.arange(2, 2 * whole.half_width + 1)
    scores = [
        (intersection(c, model), intersection_of_shares(c, shares(model)))
        for c in map(counted, widths.tolist())
    ]
    printed, by_shares = np.array(scores).T
    return Sizes(widths, printed, by_shares, whole.half_width)


def setup_table() -> Table:
    """Return the paper's values, ours, and which of them matters."""
    cells = " × ".join(map(str, Binning().bins))
    rows = {
        "cells": ("(B − G, G − R, R + G + B)", cells, "yes"),
        "a, threshold": ("–, “empirically determined”", f"{RULES.rate:g}, {RULES.gate:g}", "yes"),
        "gives up": ("–", "never; see the explorer", "yes"),
        "search": ("“a local region”", f"± {RULES.radius} px, as Birchfield's", "not varied"),
        "size": ("by stereo", f"by distance ± {heads.Config().depth_sigma:.0%}", "yes"),
    }
    return Table(rows, {"paper": "in its words", "ours": "", "matters": ""})
