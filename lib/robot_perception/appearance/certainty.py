r"""Certainty that an outline still surrounds the object that it surrounded at first.

A tracker's own score says how well the best place fits, and there is a best place always. Here the
place that it chose is looked at again, by what a tracker does not ask:

- how much of the colours inside stand in that half in which they stood at first, left, right, above
  or below, the *match*: an outline that has slid by half keeps the colours of one half;
- how much of them is not all about, too, *apart*: what has slid to a wall has the wall's colours;
- by how much it is larger or smaller than at first, the *growth*.

The three make a probability by a logistic function. Its weights and the limit are ours. They were
fitted to heads, rendered ones (`data_synth.coloured.head`) and one in a film of a moving car.
"""

from dataclasses import dataclass, field
from typing import Annotated

import numpy as np
from jaxtyping import Float, UInt8

from robot_perception import checks
from robot_perception.appearance._masks import Mask, Outline, check_outline
from robot_perception.appearance.affine_snake import area
from robot_perception.appearance.colour_histograms import histogram, shares
from robot_perception.appearance.colour_spaces import Binning, picture
from robot_perception.appearance.segmentation import filled
from robot_perception.fields import Positive, Share, at_least, checked

Image = UInt8[np.ndarray, "height width 3"]


def _rim(name: str, value: tuple[float, float]) -> tuple[float, float]:
    """Return two sizes that rise from 1 or more."""
    low, high = checks.array(name, value, (2,)).tolist()
    if not 1 <= low < high:
        raise ValueError(f"{name} must rise from 1 or more, got {value}")
    return low, high


@dataclass(frozen=True, slots=True)
class CertaintyRules:
    """Rules by which an outline is looked at again. All values are ours.

    Parameters
    ----------
    binning
        The cells of the histograms.
    rim
        From where to where colours count as all about, in sizes of the outline, from its middle.
    bias, match, apart, growth
        Weights of the logistic function.
    least
        Certainty below which what is followed counts as lost.
    """

    binning: Binning = field(default_factory=lambda: Binning("opponent", (16, 16, 8)))
    rim: Annotated[tuple[float, float], _rim] = (1.15, 1.6)
    bias: float = -4.7
    match: float = 8.2
    apart: float = 6.2
    growth: float = -3.2
    least: Share = 0.3
    __post_init__ = checked


def _as_shares(name: str, halves: Float[np.ndarray, "4 bins"]) -> Float[np.ndarray, "4 bins"]:
    """Return histograms that are each divided by their sum."""
    if not halves.any(axis=1).all():
        raise ValueError(f"{name} must each hold a pixel, got an empty histogram")
    return np.array([shares(half) for half in halves])


@dataclass(frozen=True, eq=False, slots=True)
class Original:
    """Contents of an outline in the first picture.

    Parameters
    ----------
    halves : (4, bins)
        Shares of the colours of its left and right, its upper and lower half.
    area
        Of the outline, px².

    Raises
    ------
    ValueError
        If a half has no colour.
    """

    halves: Annotated[Float[np.ndarray, "4 bins"], at_least(0), _as_shares]
    area: Positive
    __post_init__ = checked


@dataclass(frozen=True, slots=True)
class Certainty:
    """Certainty of one outline, and the parts that it is made of.

    Parameters
    ----------
    match, apart
        Shares, from 0 to 1.
    growth
        Natural logarithm of the size over that at first; the size is the root of the area.
    probability
        That the outline still is where it should be.
    lost
        Whether that is too little.
    """

    match: float
    apart: float
    growth: float
    probability: float
    lost: bool


def original(image: Image, outline: Outline, rules: CertaintyRules = CertaintyRules()) -> Original:
    """Return what is inside an outline that is known to be right.

    Parameters
    ----------
    image : (height, width, 3)
        Red, green, blue.
    outline : (n, 2)
        Closed, points (u, v), px.
    rules
        The histogram.

    Raises
    ------
    TypeError
        If the image does not hold bytes.
    ValueError
        If it has another shape, or the outline lies on a line or has no pixel in it.
    """
    image, outline = picture("image", image), check_outline("outline", outline)
    checks.instance("rules", rules, CertaintyRules)
    inside = filled(outline, image.shape[:2])
    if not inside.any():
        raise ValueError(f"outline must hold pixels of the image {image.shape[:2]}")
    return Original(_halves(image, inside, rules), area(outline))


def certainty(
    image: Image, outline: Outline, first: Original, rules: CertaintyRules = CertaintyRules()
) -> Certainty:
    r"""Return how sure it is that an outline is round what it was round at first.

    .. math:: p = \left( 1 + e^{-(b + w_m m + w_a a + w_g |g|)} \right)^{-1}

    with the match :math:`m = \min_h \sum_i \min(H_{hi}, F_{hi})` of the shares H of colours in each
    half and F in that half at first, :math:`a = 1 - \sum_i \min(H_i, R_i)` of the shares inside and
    in the rim, and :math:`g = \tfrac12 \ln (A / A_0)` of the areas.

    Parameters
    ----------
    image : (height, width, 3)
        Red, green, blue.
    outline : (n, 2)
        Closed, points (u, v), px. Where it has no pixel of the image in it nothing is certain.
    first
        Of `original`.
    rules
        Those by which it was made.

    Raises
    ------
    TypeError
        If the image does not hold bytes, or an argument is of another type.
    ValueError
        If the image has another shape, the outline lies on a line, or the histogram has other bins.
    """
    image, outline = picture("image", image), check_outline("outline", outline)
    checks.instance("rules", rules, CertaintyRules)
    checks.instance("first", first, Original)
    checks.shaped("first.halves", first.halves, (4, rules.binning.count), beside="this binning")
    growth = float(np.log(max(area(outline), 1e-9) / first.area)) / 2
    inside = filled(outline, image.shape[:2])
    if not inside.any():
        return Certainty(0.0, 0.0, growth, 0.0, True)
    near, far = (filled(_scaled(outline, scale), image.shape[:2]) for scale in rules.rim)
    index, count = rules.binning.index(image), rules.binning.count
    rim = far & ~near
    colours = shares(histogram(index, count, inside))
    around = shares(histogram(index, count, rim)) if rim.any() else np.zeros(count)
    match = float(np.minimum(_halves(image, inside, rules), first.halves).sum(axis=1).min())
    apart = float(1 - np.minimum(colours, around).sum())
    told = rules.bias + rules.match * match + rules.apart * apart + rules.growth * abs(growth)
    probability = float(1 / (1 + np.exp(-np.clip(told, -500, 500))))
    return Certainty(match, apart, growth, probability, probability < rules.least)


def _halves(image: Image, inside: Mask, rules: CertaintyRules) -> Float[np.ndarray, "4 bins"]:
    """Return shares of colours of a mask's left and right, its upper and lower half."""
    index = rules.binning.index(image)
    v, u = np.nonzero(inside)
    u, v = (2 * x - (x.min() + x.max()) for x in (u, v))  # from the middle, to both sides
    parts = [u <= 0, u >= 0, v <= 0, v >= 0]
    counts = [np.bincount(index[inside][part], minlength=rules.binning.count) for part in parts]
    return np.array([shares(each.astype(float)) for each in counts])


def _scaled(outline: Outline, scale: float) -> Outline:
    middle = outline.mean(axis=0)
    return middle + scale * (outline - middle)
