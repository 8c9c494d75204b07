r"""Colour and shape tracked together: samples of a colour distribution, weighed by an outline.

A frame is one step of the condensation algorithm on the states of `colour_distribution`: each
sample warps the colours of the object as they were last seen, segments the frame by them, and an
affine snake on the edge of that segmentation says whether it still has the object's shape. The best
sample's segmentation then says which edges of the image the outline may follow.

The colours are taken anew, within the new outline, after each frame; and their description takes
the best sample's place. The paper leaves both open, and what happens when the object is lost: here
the outline waits, the samples go on spreading, and where no piece of a segmentation lies below the
outline, the largest one is compared with the shape, wherever it is.

References
----------
Andrade-Cetto, "Perception issues in mobile robotics", section 3.3.
"""

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Annotated

import numpy as np
from jaxtyping import Bool, Float, UInt8

from robot_perception import checks
from robot_perception.appearance import colour_distribution as distributions
from robot_perception.appearance import shape_scores as scores
from robot_perception.appearance._masks import Mask, Outline, check_mask, check_outline
from robot_perception.appearance.affine_snake import (
    SnakeRules,
    affine_snake,
    area,
    free_snake,
    image_edges,
    resample,
)
from robot_perception.appearance.colour_distribution import ColourDistribution, Dynamics
from robot_perception.appearance.colour_spaces import Binning, picture
from robot_perception.appearance.segmentation import Blob, blob, clean, dilate, filled, segment
from robot_perception.beliefs import ParticleSet
from robot_perception.fields import Level, Positive, checked, from_to, odd, within
from robot_perception.particles import condensation

__all__ = [
    "ColourShapeInfo",
    "ColourShapeRules",
    "ColourShapeState",
    "ColourShapeTracker",
    "colours_inside",
    "inner",
]

Image = UInt8[np.ndarray, "height width 3"]
SMALLEST = 30.0
"""Area below which a piece or an outline is none, px²."""
THINNEST = 0.05
"""Smallest spread of an outline over its largest below which it is none."""
BINNING = Binning("opponent", (64, 64, 16))
SNAKE = SnakeRules(reach=(8.0, 3.0))


def _weights(name: str, value: tuple[float, float, float]) -> tuple[float, float, float]:
    """Return three weights, one of them positive at least."""
    a, b, c = checks.array(name, value, (3,)).tolist()
    if min(a, b, c) < 0 or not 0 < a + b + c <= 1e3:
        raise ValueError(f"{name} must not be negative, nor all 0, got {(a, b, c)}")
    return a, b, c


@dataclass(frozen=True, slots=True)
class ColourShapeRules:
    r"""Rules of the tracker. The paper gives the form of all, the value of none.

    Parameters
    ----------
    samples
        N.
    binning
        Space and bins of the histograms :math:`\mathcal H^{(n)}`.
    importance
        :math:`\mu_1, \mu_2, \mu_3` of the affine similarity, the area and the quality.
    sigma
        σ of the weights.
    momentum
        μ of the predicted area.
    noise
        Factor of B.
    printed_area
        Whether :math:`\Phi_{area}` has the printed sign, 0 for a perfect match.
    affine
        Whether the snakes are affine; free ones otherwise.
    shape
        Whether the shape weighs samples; otherwise all that find a piece weigh the same, and the
        first of them leads to the outline.
    refresh
        Whether the colours are taken anew after each frame.
    colours
        How many of them are kept, drawn at random.
    inset
        Pixels from the outline within which colours are not taken.
    points
        Of the outline.
    opening, closing
        Of the segmentation, px.
    band
        Radius of the dilation of :math:`\nabla S` in which edges of the image count, px.
    strength
        Share of the greatest gradient in that band that an edge must have.
    snake
        Stiffness and motion of the snakes.
    worst
        :math:`\rho` of the best sample above which the object is lost.
    """

    samples: Annotated[int, from_to(1, 10**5)] = 50
    binning: Binning = BINNING
    importance: Annotated[tuple[float, float, float], _weights] = (0.5, 0.4, 0.1)
    sigma: Annotated[float, within(1e-6, checks.LARGEST)] = 0.1
    momentum: Annotated[float, within(0, 1e3)] = 0.0
    noise: Annotated[float, within(0, 1e3)] = 1.0
    printed_area: bool = False
    affine: bool = True
    shape: bool = True
    refresh: bool = True
    colours: Annotated[int, from_to(1, 10**5)] = 500
    inset: Annotated[int, from_to(0, 50)] = 2
    points: Annotated[int, from_to(6, 1000)] = 80
    opening: Annotated[int, odd(1, 99)] = 5
    closing: Annotated[int, odd(1, 99)] = 5
    band: Annotated[int, from_to(1, 100)] = 4
    strength: Level = 0.2
    snake: SnakeRules = SNAKE
    worst: Positive = 0.45
    __post_init__ = checked


@dataclass(frozen=True, eq=False, slots=True)
class ColourShapeState:
    r"""State of the tracker after a frame; `ColourShapeTracker.start` makes the first.

    Parameters
    ----------
    particles
        Samples :math:`(m, \lambda, \theta, \phi)`, with the states before where the dynamics ask
        for them.
    colours : (n, 3)
        Colours of the object as last seen, coordinates of the colour space.
    distribution
        What describes them; its axes are those that the samples' next angles turn.
    outline : (points, 2)
        :math:`r_t`, px.
    areas
        Of the outline now and a frame before, px².
    lost
        For how many frames in a row the object has not been found.
    shape
        Height and width of the images.
    """

    particles: ParticleSet
    colours: Float[np.ndarray, "colours 3"]
    distribution: ColourDistribution
    outline: Outline
    areas: tuple[float, float]
    lost: Annotated[int, from_to(0)]
    shape: tuple[int, int]
    __post_init__ = checked


@dataclass(frozen=True, eq=False, slots=True)
class ColourShapeInfo:
    r"""Diagnostics of one step.

    Parameters
    ----------
    states : (N, 8)
        The samples.
    ancestors : (N,)
        From which sample before each comes.
    weights : (N,)
        :math:`\pi`, with sum 1; all 0 if no sample found a piece.
    rho : (N,)
        :math:`\rho`; infinite where no piece was found.
    scores : (N, 3)
        :math:`\Phi_{affine}, \Phi_{area}, \Phi_{quality}`; 0 where no piece was found.
    blobs : (N, height, width)
        Pieces that were taken for the object.
    outlines : (N, points, 2)
        Snakes on their edges, px; where no piece was found the outline before.
    best
        Number of the sample with the greatest weight.
    edges : (height, width)
        :math:`\nabla I^*`, the edges of the image that the outline followed.
    lost
        Whether the object was not found.
    """

    states: Float[np.ndarray, "m 8"]
    ancestors: np.ndarray
    weights: Float[np.ndarray, " m"]
    rho: Float[np.ndarray, " m"]
    scores: Float[np.ndarray, "m 3"]
    blobs: Bool[np.ndarray, "m height width"]
    outlines: Float[np.ndarray, "m n 2"]
    best: int
    edges: Mask
    lost: bool


def _unwatched(_: str) -> None:
    """Take no notice of the end of a stage."""


@dataclass(frozen=True, eq=False, slots=True)
class ColourShapeTracker:
    """Follows an object by the colours it has, checked by the shape it keeps.

    Parameters
    ----------
    dynamics
        How the colours move from frame to frame.
    rules
        How colours and shape are tracked.
    """

    dynamics: Dynamics
    rules: ColourShapeRules = field(default_factory=ColourShapeRules)
    __post_init__ = checked

    def start(
        self, image: Image, outline: Outline, *, rng: np.random.Generator
    ) -> ColourShapeState:
        """Return the state of an object whose outline is known.

        Parameters
        ----------
        image : (height, width, 3)
            Red, green, blue.
        outline : (n, 2)
            Closed, points (u, v), px.
        rng
            Source of randomness.

        Raises
        ------
        TypeError
            If the image does not hold bytes.
        ValueError
            If it has another shape, or the outline lies on a line or has no pixel in it.
        """
        image, rules = picture("image", image), self.rules
        outline = resample(check_outline("outline", outline), rules.points)
        checks.generator("rng", rng)
        seen = colours_inside(image, outline, rules, rng=rng)
        if seen is None:
            raise ValueError(f"outline must hold pixels of the image {image.shape[:2]}")
        found = distributions.describe(seen)
        state = np.append(found.state[:6], [0.0, 0.0])  # angles are turns since the frame before
        states = np.tile(state, (rules.samples, self.dynamics.order))
        areas = (area(outline),) * 2
        particles = ParticleSet.uniform(states)
        return ColourShapeState(particles, seen, found, outline, areas, 0, image.shape[:2])

    def warped(
        self, state: ColourShapeState, states: Float[np.ndarray, "m 8"]
    ) -> Float[np.ndarray, "m n 3"]:
        r"""Return the colours :math:`\mathcal C^{(n)}` of samples: those last seen, warped.

        Parameters
        ----------
        state
            Before the frame.
        states : (N, 8)
            The samples.

        Raises
        ------
        TypeError
            If the state is of another type.
        ValueError
            If a sample is not finite or has a negative length.
        """
        checks.instance("state", state, ColourShapeState)
        states = checks.array("states", states, ("m", distributions.SIZE))
        after = ColourDistribution.of(states, state.distribution.axes)
        return distributions.warp(state.colours, state.distribution, after)

    def step(
        self,
        state: ColourShapeState,
        image: Image,
        *,
        rng: np.random.Generator,
        watch: Callable[[str], None] = _unwatched,
    ) -> tuple[ColourShapeState, ColourShapeInfo]:
        """Return the state after a frame, and what led to it.

        Parameters
        ----------
        state
            Before the frame.
        image : (height, width, 3)
            Red, green, blue, of the size of the first.
        rng
            Source of randomness.
        watch
            Is told the name of each stage when it ends; stages of each sample come in turn.

        Raises
        ------
        TypeError
            If an argument is of another type, or the image does not hold bytes.
        ValueError
            If the image has another shape.
        """
        checks.instance("state", state, ColourShapeState)
        image = picture("image", image)
        if image.shape[:2] != state.shape:
            raise ValueError(f"image must be {state.shape} as the first, got {image.shape[:2]}")
        checks.generator("rng", rng)
        checks.instance("watch", watch, Callable)
        index = self.rules.binning.index(image)
        watch("bins of the pixels")
        expected = filled(state.outline, state.shape)
        looks: list[_Look | None] = []

        def move(states: np.ndarray, rng: np.random.Generator) -> np.ndarray:
            return self.dynamics.propagate(states, rng=rng, noise=self.rules.noise)

        def log_likelihood(states: np.ndarray) -> np.ndarray:
            watch("draw and propagate")
            # copies, of which there are many without noise, see the same
            each, same = np.unique(states, axis=0, return_inverse=True)
            clouds = self.warped(state, each[:, : distributions.SIZE])
            watch("warp")
            seen = [self._look(state, expected, index, cloud, watch) for cloud in clouds]
            looks.extend(seen[i] for i in same)
            if all(look is None for look in looks):
                return np.zeros(len(looks))  # nothing to choose by: the samples just spread
            return np.array([-np.inf if look is None else self._log(look) for look in looks])

        particles, seen = condensation(state.particles, move, log_likelihood, rng=rng)
        rho = np.array([np.inf if look is None else look.rho for look in looks])
        best = int(np.argmax(particles.log_weights))
        chosen = looks[best]
        after, ridges, found = self._updated(state, image, chosen, particles, best, rng)
        watch("outline on the image's edges")
        states = particles.states[:, : distributions.SIZE]
        nothing = np.zeros(state.shape, dtype=bool)
        info = ColourShapeInfo(
            states,
            seen.ancestors,
            particles.weights if np.isfinite(rho).any() else np.zeros(len(rho)),
            rho,
            np.array([np.zeros(3) if look is None else look.scores for look in looks]),
            np.array([nothing if look is None else look.blob.mask for look in looks]),
            np.array([state.outline if look is None else look.outline for look in looks]),
            best,
            nothing if ridges is None else ridges,
            not found,
        )
        return after, info

    def _log(self, look: "_Look") -> float:
        return float(scores.log_weight(look.rho, self.rules.sigma)) if self.rules.shape else 0.0

    def _look(
        self,
        state: ColourShapeState,
        expected: Mask,
        index: np.ndarray,
        cloud: np.ndarray,
        watch: Callable[[str], None],
    ) -> "_Look | None":
        """Return what a frame looks like to a sample; ``None`` if nothing has its colours."""
        rules = self.rules
        inside = cloud[((cloud >= 0) & (cloud <= 1)).all(axis=1)]
        counts = np.bincount(rules.binning.of(inside), minlength=rules.binning.count)
        watch("histogram")
        mask = segment(index, counts)
        watch("segment")
        mask = clean(mask, rules.opening, rules.closing)
        watch("morphology")
        piece = blob(mask, expected)
        watch("blob")
        if piece is None or piece.area < SMALLEST or (piece.overlap == 0 and not state.lost):
            return None
        start = state.outline
        if piece.overlap == 0:
            v, u = np.nonzero(piece.mask)
            start = start + (np.array([u.mean(), v.mean()]) - start.mean(axis=0))
        border = piece.boundary()
        outline = self._fit(start, border)
        watch("snake")
        if outline is None:
            return None
        predicted = scores.predicted_area(*state.areas, rules.momentum)
        match = scores.area_difference if rules.printed_area else scores.area_congruence
        found = np.array(
            [
                scores.affine_similarity(border, outline),
                match(predicted, area(outline)),
                scores.quality(piece.euler),
            ]
        )
        rho = float(scores.rho(*found, importance=rules.importance))
        watch("scores")
        return _Look(piece, start, outline, found, rho)

    def _fit(self, start: Outline, border: Mask) -> Outline | None:
        """Return a snake on edges; ``None`` if there are none, or it shrinks to nothing."""
        if not border.any():
            return None
        fit = (affine_snake if self.rules.affine else free_snake)(start, border, self.rules.snake)
        return fit.outline if sound(fit.outline) else None

    def _updated(
        self,
        state: ColourShapeState,
        image: Image,
        look: "_Look | None",
        particles: ParticleSet,
        best: int,
        rng: np.random.Generator,
    ) -> tuple[ColourShapeState, Mask | None, bool]:
        """Return the state after the samples were weighed, the edges followed, whether found."""
        rules, ridges, outline = self.rules, None, None
        if look is not None and look.rho <= rules.worst:
            border = dilate(look.blob.boundary(), rules.band)
            ridges = image_edges(image, border, rules.strength)
            outline = self._fit(look.start, ridges)
            outline = look.outline if outline is None else outline
            seen = colours_inside(image, outline, rules, rng=rng)
            middle = outline.mean(axis=0)
            if seen is None or not ((middle >= 0) & (middle < state.shape[::-1])).all():
                outline = None
        if outline is None:
            waits = ColourShapeState(
                particles,
                state.colours,
                state.distribution,
                state.outline,
                (state.areas[0], state.areas[0]),
                state.lost + 1,
                state.shape,
            )
            return waits, ridges, False
        colours, distribution = state.colours, state.distribution
        if rules.refresh:
            colours = seen
            distribution = distributions.describe(seen, state.distribution.axes)
            states = particles.states.copy()
            states[best, : distributions.SIZE] = distribution.state
            particles = ParticleSet(states, particles.log_weights)
        areas = (area(outline), state.areas[0])
        found = ColourShapeState(particles, colours, distribution, outline, areas, 0, state.shape)
        return found, ridges, True


@dataclass(frozen=True, eq=False, slots=True)
class _Look:
    """One sample's view of a frame."""

    blob: Blob
    start: Outline
    outline: Outline
    scores: Float[np.ndarray, "3"]
    rho: float


def colours_inside(
    image: Image, outline: Outline, rules: ColourShapeRules, *, rng: np.random.Generator
) -> Float[np.ndarray, "m 3"] | None:
    r"""Return colours of the pixels inside an outline, :math:`\mathcal C`; ``None`` without any.

    Parameters
    ----------
    image : (height, width, 3)
        Red, green, blue.
    outline : (n, 2)
        Points (u, v), px.
    rules
        The colour space, how many colours, and the distance from the outline; where nothing lies
        so far inside, all pixels count.
    rng
        Source of the draw.

    Raises
    ------
    TypeError
        If the image does not hold bytes, or an argument is of another type.
    ValueError
        If the outline lies on a line.
    """
    image = picture("image", image)
    checks.instance("rules", rules, ColourShapeRules)
    pixels = image[inner(filled(outline, image.shape[:2]), rules.inset)]
    checks.generator("rng", rng)
    if not len(pixels):
        return None
    if len(pixels) > rules.colours:
        pixels = pixels[rng.choice(len(pixels), rules.colours, replace=False)]
    return rules.binning.space.coordinates(pixels)


def inner(mask: Mask, inset: int) -> Mask:
    """Return the pixels of a mask that lie so far from its rim; all if none does.

    Parameters
    ----------
    mask : (height, width)
        True inside.
    inset
        Pixels from the rim; what lies beyond the image is not outside.

    Raises
    ------
    TypeError
        If the mask does not hold True and False.
    ValueError
        If the mask is empty or the inset out of its range.
    """
    inset = checks.whole("inset", inset, 0, 200)
    mask = check_mask("mask", mask)
    deep = mask & ~dilate(~mask, inset)
    return deep if deep.any() else mask


def sound(outline: Outline) -> bool:
    """Tell whether an outline still has an area.

    Parameters
    ----------
    outline : (n, 2)
        Points (u, v), px.
    """
    if not np.isfinite(outline).all() or area(outline) < SMALLEST:
        return False
    spread = np.linalg.svd(outline - outline.mean(axis=0), compute_uv=False)
    return bool(spread[1] > THINNEST * spread[0])
