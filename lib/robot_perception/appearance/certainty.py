r"""How sure it is that an outline is still round what it was round at first.

A tracker's own score says how well the best place fits, and there is a best place always. Here the
place that it chose is looked at again, by what a tracker does not ask:

- how much of the colours inside were inside at first, the *match*;
- how much of them is not all about, too, *apart*: what has slid to a wall has the wall's colours;
- along how much of the outline the colours change, the *edge*;
- by how much it is larger or smaller than at first, the *growth*.

The four make a probability by a logistic function. Its weights are ours, fitted to rendered heads.
"""

from dataclasses import dataclass, field

import numpy as np
from jaxtyping import Float, UInt8

from robot_perception import checks
from robot_perception.appearance._masks import Outline, check_outline
from robot_perception.appearance.affine_snake import area
from robot_perception.appearance.colour_histograms import histogram, shares
from robot_perception.appearance.colour_spaces import Binning, picture
from robot_perception.appearance.segmentation import filled
from robot_perception.extras import needing

with needing():
    import cv2

Image = UInt8[np.ndarray, "height width 3"]


@dataclass(frozen=True, slots=True)
class CertaintyRules:
    """How an outline is looked at again. All values are ours.

    Parameters
    ----------
    binning
        The cells of the histograms.
    rim
        From where to where colours count as all about, in sizes of the outline, from its middle.
    across
        As far inside and outside the outline colours are compared, in parts of its size.
    contrast
        Least difference of two colours with an edge between them, grey levels.
    bias, match, apart, edge, growth
        Weights of the logistic function.
    least
        Certainty below which what is followed counts as lost.

    Raises
    ------
    ValueError
        If the rim does not rise from 1, another number is out of its range, or not finite.
    """

    binning: Binning = field(default_factory=lambda: Binning("opponent", (16, 16, 8)))
    rim: tuple[float, float] = (1.15, 1.6)
    across: float = 0.15
    contrast: float = 12.0
    bias: float = 0.0
    match: float = 0.0
    apart: float = 0.0
    edge: float = 0.0
    growth: float = 0.0
    least: float = 0.5

    def __post_init__(self) -> None:
        checks.instance("binning", self.binning, Binning)
        low, high = checks.vector("rim", self.rim, 2).tolist()
        if not 1 <= low < high:
            raise ValueError(f"rim must rise from 1 or more, got {self.rim}")
        object.__setattr__(self, "rim", (low, high))
        for name in ("across", "contrast"):
            object.__setattr__(self, name, checks.positive(name, getattr(self, name)))
        for name in ("bias", "match", "apart", "edge", "growth"):
            object.__setattr__(self, name, checks.number(name, getattr(self, name)))
        object.__setattr__(self, "least", checks.share("least", self.least))


@dataclass(frozen=True, eq=False, slots=True)
class Original:
    """What was inside an outline at first.

    Parameters
    ----------
    colours : (bins,)
        Their shares.
    area
        Of the outline, px².

    Raises
    ------
    ValueError
        If a share is negative, all are none, or the area is not positive.
    """

    colours: Float[np.ndarray, " bins"]
    area: float

    def __post_init__(self) -> None:
        object.__setattr__(self, "colours", shares(self.colours))
        object.__setattr__(self, "area", checks.positive("area", self.area))


@dataclass(frozen=True, slots=True)
class Certainty:
    """What was seen at an outline.

    Parameters
    ----------
    match, apart, edge
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
    edge: float
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
    counts = histogram(rules.binning.index(image), rules.binning.count, inside)
    return Original(counts, area(outline))


def certainty(
    image: Image, outline: Outline, first: Original, rules: CertaintyRules = CertaintyRules()
) -> Certainty:
    r"""Return how sure it is that an outline is round what it was round at first.

    .. math:: p = \left( 1 + e^{-(b + w_m m + w_a a + w_e e + w_g |g|)} \right)^{-1}

    with the match :math:`m = \sum_i \min(H_i, F_i)` of the shares H of colours inside and F inside
    at first, :math:`a = 1 - \sum_i \min(H_i, R_i)` with R those in the rim, the share e of the
    outline's points that lie on an edge, and :math:`g = \tfrac12 \ln (A / A_0)` of the areas.

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
    checks.shaped("first.colours", first.colours, (rules.binning.count,), beside="this binning")
    growth = float(np.log(max(area(outline), 1e-9) / first.area)) / 2
    inside = filled(outline, image.shape[:2])
    if not inside.any():
        return Certainty(0.0, 0.0, 0.0, growth, 0.0, True)
    near, far = (filled(_scaled(outline, scale), image.shape[:2]) for scale in rules.rim)
    index, count = rules.binning.index(image), rules.binning.count
    rim = far & ~near
    colours = shares(histogram(index, count, inside))
    around = shares(histogram(index, count, rim)) if rim.any() else np.zeros(count)
    match = float(np.minimum(colours, first.colours).sum())
    apart = float(1 - np.minimum(colours, around).sum())
    edge = _edge(image, outline, rules)
    weights = rules.match, rules.apart, rules.edge, rules.growth
    told = rules.bias + np.dot(weights, (match, apart, edge, abs(growth)))
    probability = float(1 / (1 + np.exp(-np.clip(told, -500, 500))))
    return Certainty(match, apart, edge, growth, probability, probability < rules.least)


def _scaled(outline: Outline, scale: float) -> Outline:
    middle = outline.mean(axis=0)
    return middle + scale * (outline - middle)


def _edge(image: Image, outline: Outline, rules: CertaintyRules) -> float:
    """Return along which share of an outline, as far as it is in the image, colours change."""
    smooth = cv2.GaussianBlur(image, (0, 0), 1.0).astype(float)
    sides = [
        np.rint(_scaled(outline, 1 + side)).astype(int) for side in (rules.across, -rules.across)
    ]
    low, high = np.zeros(2), np.array(image.shape[1::-1])
    shown = np.logical_and(*(((low <= at) & (at < high)).all(axis=1) for at in sides))
    if not shown.any():
        return 0.0
    one, other = (smooth[at[shown, 1], at[shown, 0]] for at in sides)
    return float(np.mean(np.linalg.norm(one - other, axis=1) > rules.contrast))
