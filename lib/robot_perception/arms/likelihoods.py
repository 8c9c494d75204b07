r"""Likelihood of a pose of two arms in a picture, cue by cue.

A cue is a function of what a picture says (`Look`) and of bodies in many states (`Bodies`) that
returns the logarithm of a likelihood for each state, up to a constant; any function of that kind is
one. The likelihood of a state is the product of those of all cues:

.. math:: p(z^1, \dots, z^M \mid x) \propto \prod_m p(z^m \mid x) \qquad (1)

Equation numbers are those of Menezes, Lerasle and Dias, "Visual Tracking Modalities for a Companion
Robot", section V. All deviations, gains and prices are ours: the paper names none.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import Annotated, Any, final

import numpy as np
from jaxtyping import Bool, Float, UInt8

from robot_perception import checks
from robot_perception.arms.body_model import REST, BodyModel, Contours, Patches, Surface
from robot_perception.companion import cues as shared
from robot_perception.companion.boxes import colour_picture
from robot_perception.companion.cues import (
    bhattacharyya,
    distance_transform,
    edge_picture,
    patch_histograms,
)
from robot_perception.extras import needing
from robot_perception.fields import (
    OPEN,
    NotNegative,
    Positive,
    Share,
    at_least,
    checked,
    copied,
    not_empty,
)

with needing():
    import cv2

__all__ = [
    "CHANNELS",
    "Bodies",
    "CollisionCue",
    "Cue",
    "EdgeCue",
    "EdgeRules",
    "LimitCue",
    "Look",
    "PatchCue",
    "StabiliserCue",
    "apart",
    "confidences",
    "edge_weight",
    "look",
    "mean_square",
    "sampled",
    "square_of_sum",
    "sum_of_squares",
    "summed",
]

Image = UInt8[np.ndarray, "height width 3"]
Distances = Float[np.ndarray, "m n"]
Visible = Bool[np.ndarray, "m n"]
Logarithms = Float[np.ndarray, " m"]

CHANNELS = ("red", "green", "blue", "intensity")
"""Channels of the histograms: three of colour, and one of texture."""
COLOUR, TEXTURE = (0, 1, 2), (3,)


def _thresholds(name: str, value: Any) -> tuple[float, float]:
    """Return two numbers from 0 on of which the second is no smaller."""
    low, high = checks.vector(name, value, 2).tolist()
    if not 0 <= low <= high:
        raise ValueError(f"{name} must rise from 0 or more, got {low:g} and {high:g}")
    return low, high


def _channels(name: str, value: Any) -> tuple[int, ...]:
    """Return which of `CHANNELS` are compared, one at least."""
    found = checks.integers(name, value, ("k",), 0)
    if not found.size or found.max() >= len(CHANNELS):
        raise ValueError(f"{name} must be from 0 to 3, got {found.tolist()}")
    return tuple(found.tolist())


@final
@dataclass(frozen=True, slots=True)
class EdgeRules:
    """Rules of edge detection; all values are ours.

    Parameters
    ----------
    thresholds
        Of Canny's detector.
    most
        Larger distances are cut to it, px, so that a contour that lacks an edge does not outweigh
        all others.
    moves
        Length of the optical flow from which on an edge moves, px a picture.
    """

    thresholds: Annotated[tuple[float, float], _thresholds] = (15.0, 50.0)
    most: Positive = 5.0
    moves: Positive = 0.7
    __post_init__ = checked


@final
@dataclass(frozen=True, eq=False)
class Look:
    """Features of a picture, computed once for all states.

    Parameters
    ----------
    image : (height, width, 3)
        Red, green, blue.
    grey : (height, width)
        Intensity.
    edges : (height, width)
        Where edges are.
    static, moving : (height, width)
        Distance of each pixel to the nearest edge and to the nearest edge that moves, px: I_DT, cut
        to the most there is, and I'_DT, which is not cut: K times the most would cut the smaller of
        the two for all edges. Infinite where no edge moves, as without a picture before.
    most
        To which I_DT is cut, px.
    """

    image: Annotated[Image, not_empty]
    grey: UInt8[np.ndarray, "height width"]
    edges: Bool[np.ndarray, "height width"]
    static: Annotated[Float[np.ndarray, "height width"], OPEN, at_least(0)]
    moving: Annotated[Float[np.ndarray, "height width"], OPEN, at_least(0)]
    most: Positive

    def __post_init__(self) -> None:
        for name in ("static", "moving"):
            checks.typed(name, getattr(self, name), np.floating)  # no list, nor a number
        checked(self)

    @cached_property
    def channels(self) -> UInt8[np.ndarray, "height width 4"]:
        """`CHANNELS` of each pixel."""
        return np.dstack([self.image, self.grey])

    @property
    def moves(self) -> bool:
        """True if an edge moves."""
        return bool((self.moving == 0).any())


def look(
    image: Image,
    before: UInt8[np.ndarray, "height width"] | None = None,
    rules: EdgeRules | None = None,
) -> Look:
    r"""Return what a picture says.

    Edges are those of Canny's detector on the blurred intensity; one moves where the optical flow
    (OpenCV's dense inverse search) is long enough. The distance transform is the exact Euclidean
    one.

    Parameters
    ----------
    image : (height, width, 3)
        Red, green, blue.
    before : (height, width), optional
        Intensity of the picture before.
    rules
        Numbers.

    Raises
    ------
    TypeError
        If a picture does not hold bytes.
    ValueError
        If the image is not in colour, or the pictures are not of the same size.

    References
    ----------
    Section V, "Shape cues" and "Motion cues".
    """
    image = colour_picture("image", image)
    rules = EdgeRules() if rules is None else checks.instance("rules", rules, EdgeRules)
    if before is not None:
        checks.typed("before", before, np.uint8, image.shape[:2], f"image {image.shape}")
    return features(image, before, rules)


def features(
    image: Image, before: UInt8[np.ndarray, "height width"] | None, rules: EdgeRules
) -> Look:
    """Return the same as `look`, where pictures have been checked."""
    grey = cv2.cvtColor(image, cv2.COLOR_RGB2GRAY)
    edges = edge_picture(grey, thresholds=rules.thresholds)
    moving = np.zeros_like(edges)
    if before is not None:
        finder = cv2.DISOpticalFlow_create(cv2.DISOPTICAL_FLOW_PRESET_ULTRAFAST)
        flow = finder.calc(np.ascontiguousarray(before), grey, None)
        moving = edges & (cv2.magnitude(flow[..., 0], flow[..., 1]) > rules.moves)
    static = distance_transform(edges, most=rules.most)
    return Look(image, grey, edges, static, distance_transform(moving), rules.most)


@final
@dataclass(eq=False)
class Bodies:
    """Bodies in many states, projected when a cue asks for it.

    Parameters
    ----------
    model
        Of the body.
    states : (m, 8)
        Angles, rad.
    """

    model: BodyModel
    states: Float[np.ndarray, "m 8"]
    _surfaces: dict[Patches, Surface] = field(default_factory=dict, init=False, repr=False)
    __post_init__ = checked

    def __len__(self) -> int:
        return len(self.states)

    @cached_property
    def contours(self) -> Contours:
        """Silhouettes of the limbs."""
        return self.model.contours(self.states)

    def surface(self, patches: Patches) -> Surface:
        """Return the points of patches."""
        checks.instance("patches", patches, Patches)
        if patches not in self._surfaces:
            self._surfaces[patches] = self.model.surface(self.states, patches)
        return self._surfaces[patches]


Cue = Callable[[Look, Bodies], Logarithms]


def sampled(
    distance: Float[np.ndarray, "height width"], contours: Contours, most: float
) -> Distances:
    """Return the distance at each point of silhouettes: that of the nearest pixel.

    Parameters
    ----------
    distance : (height, width)
        A distance transform, px.
    contours
        Points (m, n, 2).
    most
        The distance outside of the picture.
    """
    points = checks.instance("contours", contours, Contours).points
    return shared.sampled(distance, points, most)


def square_of_sum(distances: Distances, visible: Visible, sigma: float) -> Logarithms:
    r"""Return :math:`-D^2 / 2 \sigma_s^2` with :math:`D = \sum_j I_{DT}(j)`, as eq. (2) is printed.

    Parameters
    ----------
    distances, visible : (m, n)
        At the points of the silhouettes, px, and which of these are seen.
    sigma
        σ_s, px.

    References
    ----------
    Eq. (2). The text above it speaks of the sum of the squared distances: `sum_of_squares`.
    """
    distances, sigma = _told(distances, visible, sigma)
    total = np.where(visible, distances, 0.0).sum(axis=1)
    return -(total**2) / (2 * sigma**2)


def sum_of_squares(distances: Distances, visible: Visible, sigma: float) -> Logarithms:
    r"""Return :math:`-\sum_j I_{DT}(j)^2 / 2 \sigma_s^2`, as the text of section V says.

    Parameters are those of `square_of_sum`.
    """
    distances, sigma = _told(distances, visible, sigma)
    total = (np.where(visible, distances, 0.0) ** 2).sum(axis=1)
    return -total / (2 * sigma**2)


def mean_square(
    distances: Distances, visible: Visible, sigma: float, price: float | None = None
) -> Logarithms:
    r"""Return minus the mean of the squared distances over :math:`2 \sigma_s^2`.

    The mean does not fall when a pose hides its limbs. With a price every hidden point counts as if
    it were that far from an edge; without one the mean is over the visible points alone. Ours.

    Parameters
    ----------
    distances, visible : (m, n)
        At the points of the silhouettes, px, and which of these are seen.
    sigma
        σ_s, px.
    price
        px.
    """
    distances, sigma = _told(distances, visible, sigma)
    if price is None:
        count = np.maximum(visible.sum(axis=1), 1)
        mean = (np.where(visible, distances, 0.0) ** 2).sum(axis=1) / count
    else:
        price = checks.moderate("price", checks.not_negative("price", price), 1e6)
        mean = (np.where(visible, distances, price) ** 2).mean(axis=1)
    return -mean / (2 * sigma**2)


def _told(distances: Any, visible: Any, sigma: Any) -> tuple[Distances, float]:
    """Return distances and a deviation, if they are some."""
    distances = checks.array("distances", distances, ("m", "n"))
    checks.moderate("distances", distances, 1e6)
    if not distances.shape[1]:
        raise ValueError("distances must be of one point at least, got none")
    checks.typed("visible", visible, np.bool_, distances.shape, "distances")
    sigma = checks.positive("sigma", sigma)
    if not 1e-6 <= sigma <= 1e6:
        raise ValueError(f"sigma must be from 1e-6 to 1e6, got {sigma:g}")
    return distances, sigma


@final
@dataclass(frozen=True, slots=True)
class EdgeCue:
    r"""Silhouettes on edges.

    .. math:: \min(I_{DT}(j),\; K \cdot I'_{DT}(j))

    is taken as the distance of point j, with :math:`I_{DT}` alone for K of ``None``. From K = 1 on
    the minimum is :math:`I_{DT}` everywhere, since edges that move are edges: only a K below 1
    favours them. And a contour that lies on edges that stand still costs nothing, whatever K is.
    Ours is

    .. math:: \min(I'_{DT}(j),\; I_{DT}(j) + c)

    by which an edge that stands still costs a toll.

    Parameters
    ----------
    sigma
        σ_s, px, of the mean square.
    gain
        K.
    toll
        c, px; ``None`` for the paper's form.
    price
        Of a hidden point, px; ``None`` counts the visible ones only.
    weight
        λ_s, by which the logarithm is multiplied.

    Raises
    ------
    ValueError
        If there are a gain and a toll.

    References
    ----------
    Section V, "Shape cues" and "Motion cues".
    """

    sigma: Positive = 0.65
    gain: Positive | None = None
    toll: Positive | None = None
    price: Positive | None = 4.0
    weight: NotNegative = 1.0

    def __post_init__(self) -> None:
        checked(self)
        if self.gain is not None and self.toll is not None:
            raise ValueError(f"gain and toll must not both be given, got {self.gain}, {self.toll}")

    def distances(self, seen: Look, bodies: Bodies) -> Distances:
        """Return the distance of each point of the silhouettes, px."""
        _both(seen, bodies)
        contours = bodies.contours
        found = sampled(seen.static, contours, seen.most)
        if self.gain is not None and seen.moves:
            moving = sampled(seen.moving, contours, seen.most / self.gain)
            found = np.minimum(found, self.gain * moving)
        if self.toll is not None and seen.moves:
            moving = sampled(seen.moving, contours, seen.most + self.toll)
            found = np.minimum(found + self.toll, moving)
        return found

    def __call__(self, seen: Look, bodies: Bodies) -> Logarithms:
        """Return the logarithm of a likelihood for each state."""
        distances = self.distances(seen, bodies)
        return self.weight * mean_square(distances, bodies.contours.visible, self.sigma, self.price)

    def arms(self, seen: Look, bodies: Bodies) -> Float[np.ndarray, "m 2"]:
        """Return what each arm has of the logarithm: the terms of its own points."""
        distances, visible = self.distances(seen, bodies), bodies.contours.visible
        if self.price is None:
            points = visible.sum(axis=1, keepdims=True).clip(1)
            squares = np.where(visible, distances, 0.0) ** 2
        else:
            points = visible.shape[1]
            squares = np.where(visible, distances, self.price) ** 2
        each = squares.reshape(len(bodies), 2, -1).sum(axis=2)
        return -self.weight * each / points / (2 * self.sigma**2)


@final
@dataclass(frozen=True, eq=False, slots=True)
class PatchCue:
    r"""Patches on the limbs that look as they did.

    .. math:: \log p = -\sum_p \lambda_p \sum_{c} D^2(h_{x,p}^c, h_{\mathrm{ref},p}^c)
        / 2 \sigma_C^2, \qquad D^2 = 1 - \sum_j \sqrt{h_{j,x}\, h_{j,\mathrm{ref}}}

    Parameters
    ----------
    patches
        Where they are.
    reference : (p, 4, bins)
        How they look.
    channels
        Which of `CHANNELS` are compared: 0, 1, 2 for colour, 3 for texture.
    weights : (p,)
        λ_p; by default 1.
    sigma
        σ_C.
    price
        D² of a patch of which less than ``least`` is seen.
    least
        Share of the patch's points.

    References
    ----------
    Section V, "Color cues" and "Implementation".
    """

    patches: Patches
    reference: Annotated[Float[np.ndarray, "p 4 bins"], at_least(0)]
    channels: Annotated[tuple[int, ...], _channels] = COLOUR
    weights: Annotated[Float[np.ndarray, " p"], at_least(0)] | None = None
    sigma: Positive = 0.5
    price: Share = 0.35
    least: Share = 0.15

    def __post_init__(self) -> None:
        checked(self)
        count = len(self.patches)
        checks.shaped("reference", self.reference, (count, len(CHANNELS), "bins"), "patches")
        if self.weights is None:
            object.__setattr__(self, "weights", np.ones(count))

    def squared(self, seen: Look, bodies: Bodies) -> Float[np.ndarray, "m p"]:
        """Return the sum of D² over the channels of each patch."""
        _both(seen, bodies)
        surface, bins = bodies.surface(self.patches), self.reference.shape[2]
        found, share = patch_histograms(seen.channels, surface.points, surface.visible, bins=bins)
        alike = _sum(np.sqrt(found) * np.sqrt(self.reference))
        squared = _sum(np.maximum(1.0 - alike, 0.0)[..., list(self.channels)])
        enough = (share > 0) & (share >= self.least)
        return np.where(enough, squared, self.price * len(self.channels))

    def __call__(self, seen: Look, bodies: Bodies) -> Logarithms:
        """Return the logarithm of a likelihood for each state."""
        return -(self.squared(seen, bodies) @ self.weights) / (2 * self.sigma**2)

    def arms(self, seen: Look, bodies: Bodies) -> Float[np.ndarray, "m 2"]:
        """Return what each arm has of the logarithm: the terms of its own patches."""
        own = (self.patches.limbs[:, None] // 3 == np.arange(2)) * self.weights[:, None]
        return -(self.squared(seen, bodies) @ own) / (2 * self.sigma**2)


def _sum(terms: np.ndarray) -> np.ndarray:
    """Return the sum along the last axis, one term after the other, whatever their number."""
    return np.add.accumulate(terms, axis=-1)[..., -1]


def confidences(
    reference: Float[np.ndarray, "p 4 bins"],
    channels: tuple[int, ...] = COLOUR,
    sigma: float = 0.7,
) -> Float[np.ndarray, " p"]:
    r"""Return how much the paper trusts each patch, from its first look alone.

    .. math:: \lambda_p = \exp\Bigl( -\sum_c D^2(h_{\mathrm{ref},p}^c, \mathcal U)
        / 2 \sigma^2 \Bigr), \qquad \mathcal U_j = 1 / N_{bi}

    "Typically, uniform coloured patches produce low likelihood values, whereas higher likelihood
    values characterise confident patches": a patch of one colour is far from the uniform histogram.
    σ is ours.

    Parameters
    ----------
    reference : (p, 4, bins)
        Histograms of the patches.
    channels
        That are compared.
    sigma
        σ.

    References
    ----------
    Section V, "Implementation".
    """
    reference = checks.array("reference", reference, ("p", len(CHANNELS), "bins"))
    channels = _channels("channels", channels)
    sigma = checks.positive("sigma", sigma)
    if not 1e-6 <= sigma <= 1e6:
        raise ValueError(f"sigma must be from 1e-6 to 1e6, got {sigma:g}")
    if not reference.shape[-1]:
        raise ValueError("reference must have bins, got none")
    if reference.size and reference.min() < 0:
        raise ValueError(f"reference must not be negative, got {reference.min():g}")
    uniform = np.full(reference.shape[-1], 1 / reference.shape[-1])
    squared = bhattacharyya(reference[:, list(channels)], uniform) ** 2
    return np.exp(-squared.sum(axis=1) / (2 * sigma**2))


def edge_weight(seen: Look) -> float:
    """Return λ_s: how far a pixel of a picture is from an edge, as a share of the most.

    "Parameter λ_s weights the edges density contribution and is fixed from the first DT image of
    the sequence": where edges are dense, an edge near a contour says little. The form is ours.
    """
    return float(checks.instance("seen", seen, Look).static.mean() / seen.most)


@final
@dataclass(frozen=True, eq=False, slots=True)
class StabiliserCue:
    r"""A pull towards the pose at rest.

    .. math:: \log p_{st}(x) = -\lambda_{st} \lVert x_\mathrm{def} - x \rVert^2

    Parameters
    ----------
    strength
        λ_st, per rad².
    rest : (8,)
        x_def, rad.

    References
    ----------
    Section V, "Non-observable parts stabilisation".
    """

    strength: NotNegative = 0.15
    rest: Annotated[Float[np.ndarray, " 8"], copied] = field(default_factory=lambda: REST)
    __post_init__ = checked

    def __call__(self, seen: Look, bodies: Bodies) -> Logarithms:
        """Return the logarithm of a likelihood for each state."""
        return -self.strength * ((bodies.states - self.rest) ** 2).sum(axis=1)

    def arms(self, seen: Look, bodies: Bodies) -> Float[np.ndarray, "m 2"]:
        """Return what each arm has of the logarithm: the terms of its own angles."""
        _both(seen, bodies)
        squares = (bodies.states - self.rest) ** 2
        return -self.strength * squares.reshape(len(bodies), 2, 4).sum(axis=2)


@final
@dataclass(frozen=True, slots=True)
class CollisionCue:
    r"""No limb goes through another part of the body.

    .. math:: \log p_{coll}(x) = -\lambda_{co} f_{co}(x), \qquad f_{co} \in \{0, 1\}

    Parameters
    ----------
    strength
        λ_co.

    References
    ----------
    Section V, "Collision detection".
    """

    strength: NotNegative = 30.0
    __post_init__ = checked

    def __call__(self, seen: Look, bodies: Bodies) -> Logarithms:
        """Return the logarithm of a likelihood for each state."""
        return -self.strength * bodies.model.collides(bodies.states)


@final
@dataclass(frozen=True, slots=True)
class LimitCue:
    """No joint beyond its limits; ours, of the same form as `CollisionCue`.

    Parameters
    ----------
    strength
        By which the logarithm is lowered.
    """

    strength: NotNegative = 30.0
    __post_init__ = checked

    def __call__(self, seen: Look, bodies: Bodies) -> Logarithms:
        """Return the logarithm of a likelihood for each state."""
        return -self.strength * ~bodies.model.possible(bodies.states)

    def arms(self, seen: Look, bodies: Bodies) -> Float[np.ndarray, "m 2"]:
        """Return the logarithm of each arm by its own joints."""
        _both(seen, bodies)
        return -self.strength * ~bodies.model.possible_arms(bodies.states)


def _both(seen: Look, bodies: Bodies) -> None:
    checks.instance("seen", seen, Look)
    checks.instance("bodies", bodies, Bodies)


def summed(cues: Mapping[str, Cue], seen: Look, bodies: Bodies) -> dict[str, Logarithms]:
    """Return the logarithm of each cue's likelihood, by its name.

    Parameters
    ----------
    cues
        By names of the user's.
    seen
        A picture.
    bodies
        In m states.

    Raises
    ------
    ValueError
        If a cue returns something else than a finite number for each state.
    """
    _both(seen, bodies)
    checks.instance("cues", cues, Mapping)
    for name, cue in cues.items():
        checks.instance(f"cues[{name!r}]", cue, Callable)
    return {
        name: checks.array(f"cues[{name!r}](look, bodies)", cue(seen, bodies), (len(bodies),))
        for name, cue in cues.items()
    }


def apart(
    cues: Mapping[str, Cue], seen: Look, bodies: Bodies
) -> dict[str, Float[np.ndarray, "m 2"]]:
    r"""Return what each cue says of each of the two arms, by the cue's name.

    Where the likelihood of a state is a product over its arms,

    .. math:: p(z \mid x) \propto p_l(z \mid x_l) \, p_r(z \mid x_r),

    a cue has a method ``arms`` that returns the logarithms of both factors. A cue without one, such
    as that of collisions, is about both arms at once: each gets all that it says.

    Parameters and errors are those of `summed`.
    """
    _both(seen, bodies)
    checks.instance("cues", cues, Mapping)
    found = {}
    for name, cue in cues.items():
        checks.instance(f"cues[{name!r}]", cue, Callable)
        if hasattr(cue, "arms"):
            value = checks.array(f"cues[{name!r}].arms", cue.arms(seen, bodies), (len(bodies), 2))
        else:
            whole = checks.array(f"cues[{name!r}](look, bodies)", cue(seen, bodies), (len(bodies),))
            value = np.repeat(whole[:, None], 2, axis=1)
        found[name] = value
    return found
