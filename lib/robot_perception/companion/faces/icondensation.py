r"""A face followed by particles that a detector steers: importance sampling, ICONDENSATION.

The state is the middle of a face and its side, :math:`x = [u, v, s]^\top`. It moves by a random
walk, and with a small probability to anywhere:

.. math:: f(x) = (1 - \rho) \sum_j \pi_j\, \mathcal N(x; x_j, \Sigma_j) + \rho\, U(x)

Where a detector finds faces they say where to look, by
:math:`g(x) = \tfrac1n \sum_d \mathcal N(x; d, \Sigma_d)`. A share α of the particles is drawn from
g, the others from f, and each is weighed as a draw of the mixture,

.. math:: \pi \propto p(z \mid x)\, \frac{f(x)}{\alpha\, g(x) + (1 - \alpha) f(x)}

so that the detections say where to look, and not what to believe. With α = 0 it is condensation.
"""

from dataclasses import dataclass, field
from typing import Annotated, Any, final

import numpy as np
from jaxtyping import Float, UInt8

from robot_perception import checks
from robot_perception.beliefs import ParticleSet
from robot_perception.companion.boxes import check_box, check_boxes, colour_picture
from robot_perception.companion.cues import (
    bhattacharyya,
    contour_distances,
    edge_distances,
    patch_histograms,
    patch_points,
)
from robot_perception.extras import needing
from robot_perception.fields import Positive, Share, checked, from_to
from robot_perception.particles import effective_number, systematic

with needing():
    import cv2

__all__ = ["FaceFilter", "FaceFilterInfo", "FaceFilterRules", "FaceFilterState"]

PATCHES = np.array([[-0.28, -0.30, 0.56, 0.66], [-0.25, -0.66, 0.50, 0.22]])
"""Face and hair: left, top, width and height in sides of the face's box, from its middle."""
_TURN = np.linspace(0, 2 * np.pi, 24, endpoint=False)
ELLIPSE = np.stack([0.44 * np.cos(_TURN), 0.06 + 0.58 * np.sin(_TURN)], axis=1)
"""Points of the outline of a head, in the same unit."""
TOGETHER = 1_000_000
"""Pairs of particles whose densities are held in memory at a time."""

Image = UInt8[np.ndarray, "height width 3"]


def _part(name: str, value: Any) -> float:
    """Return a share that is less than the whole."""
    found = checks.share(name, value)
    if not found < 1:
        raise ValueError(f"{name} must be below 1, got {checks.shown(value)}")
    return found


def _sides(name: str, value: Any) -> tuple[float, float]:
    """Return two positive numbers of which the second is the larger."""
    low, high = checks.vector(name, value, 2).tolist()
    if not 0 < low < high:
        raise ValueError(f"{name} must rise from above 0, got {low:g} and {high:g}")
    return low, high


@final
@dataclass(frozen=True, slots=True)
class FaceFilterRules:
    """Numbers of the filter; the papers name none for faces, all are ours.

    Parameters
    ----------
    particles
        How many.
    move, grow
        Standard deviations of the walk in a picture: of the middle in sides of the face, and of the
        logarithm of the side.
    anywhere
        ρ, the probability of a jump to anywhere.
    steered
        α, the share of the particles that detections place; 0 for plain condensation.
    place_sigma, side_sigma
        Of a face round a detection: of its middle in sides, and of the logarithm of its side.
    colour_sigma, shape_sigma
        Of the mean squared distance of the patches' colours, and of the outline's distance to
        edges, px.
    sides
        Smallest and largest side of a face, px.
    bins
        Of the histograms.
    """

    particles: Annotated[int, from_to(2, 10**6)] = 150
    move: Positive = 0.10
    grow: Positive = 0.05
    anywhere: Share = 0.02
    steered: Annotated[float, _part] = 0.5
    place_sigma: Positive = 0.08
    side_sigma: Positive = 0.08
    colour_sigma: Positive = 0.08
    shape_sigma: Positive = 3.0
    sides: Annotated[tuple[float, float], _sides] = (24.0, 160.0)
    bins: Annotated[int, from_to(2, 256)] = 8
    __post_init__ = checked


@final
@dataclass(frozen=True, eq=False, slots=True)
class FaceFilterState:
    """State of the face filter.

    Parameters
    ----------
    particles
        States (m, 3): u, v, s, px.
    reference : (2, 3, bins)
        Colours of face and hair.
    """

    particles: ParticleSet
    reference: Float[np.ndarray, "2 3 bins"]

    def __post_init__(self) -> None:
        checked(self)
        checks.shaped("particles.states", self.particles.states, ("m", 3))

    @property
    def box(self) -> Float[np.ndarray, " 4"]:
        """The box of the mean state: left, top, width and height, px."""
        u, v, side = self.particles.mean
        return np.array([u - side / 2, v - side / 2, side, side])


@final
@dataclass(frozen=True, eq=False, slots=True)
class FaceFilterInfo:
    """Diagnostics of one step.

    Parameters
    ----------
    steered
        How many particles were placed by detections.
    effective
        Effective number of all of them.
    log_evidence
        Logarithm of the mean weight.
    """

    steered: int
    effective: float
    log_evidence: float


@final
@dataclass(frozen=True, eq=False, slots=True)
class FaceFilter:
    """Follows a face by colour and outline, steered by detections.

    Parameters
    ----------
    rules
        Numbers.

    References
    ----------
    Section III: "importance sampling offers a mathematically principled way of directing search
    according to the face detector output". Isard and Blake, "ICONDENSATION: unifying low-level and
    high-level tracking in a stochastic framework", ECCV 1998, weigh a particle from g by f / g; the
    weight by the mixture (Veach and Guibas 1995) has the same mean and is bounded by 1 / (1 - α).
    Jumps to anywhere take the place of their reinitialisation.
    """

    rules: FaceFilterRules = field(default_factory=FaceFilterRules)
    __post_init__ = checked

    def start(
        self, image: Image, box: Float[np.ndarray, " 4"], *, rng: np.random.Generator
    ) -> FaceFilterState:
        """Return what is known after a picture in which the face is told.

        Raises
        ------
        TypeError, ValueError
            As `patch_histograms`; also if the box has no area, or nothing of the face lies in the
            picture.
        """
        checks.generator("rng", rng)
        left, top, side, high = check_box("box", box)
        at = np.array([left + side / 2, top + high / 2, side])
        reference = self._colours(image, at[None])[0]
        if not reference[0].any():  # nothing of the face; the hair may be above the picture
            size = image.shape[1::-1]
            raise ValueError(f"box must reach into the picture of {size} px, got {box}")
        states = self._walked(np.tile(at, (self.rules.particles, 1)), rng)
        return FaceFilterState(ParticleSet.uniform(states), reference)

    def sees(self, image: Image, box: Float[np.ndarray, " 4"]) -> bool:
        """Tell whether something of a face in a box lies in the picture; hair does not count.

        Raises
        ------
        TypeError, ValueError
            As `patch_histograms`; also if the box has no area.
        """
        left, top, side, high = check_box("box", box)
        at = np.array([[left + side / 2, top + high / 2, side]])
        return bool(self._colours(image, at)[0, 0].any())

    def step(
        self,
        state: FaceFilterState,
        image: Image,
        boxes: Float[np.ndarray, "n 4"],
        *,
        rng: np.random.Generator,
    ) -> tuple[FaceFilterState, FaceFilterInfo]:
        """Return what is known after a picture.

        Parameters
        ----------
        state
            Before it.
        image : (height, width, 3)
            Red, green, blue.
        boxes : (n, 4)
            What a detector finds; none is as good as plain condensation.
        rng
            Source of the draws.

        Raises
        ------
        TypeError, ValueError
            As `patch_histograms`; also if a box has no area.
        """
        rules = self.rules
        checks.instance("state", state, FaceFilterState)
        image = colour_picture("image", image)
        boxes = check_boxes("boxes", boxes)
        count = rules.particles
        steered = round(rules.steered * count) if len(boxes) else 0
        size = np.array(image.shape[1::-1], dtype=float)
        before = state.particles
        ancestors = systematic(before.weights, count - steered, rng=rng)
        walked = self._walked(before.states[ancestors], rng)
        jumps = rng.uniform(size=len(walked)) < rules.anywhere
        walked[jumps] = self._anywhere(int(jumps.sum()), size, rng)
        told = self._near(boxes, steered, rng) if steered else np.zeros((0, 3))
        states = np.concatenate([walked, told])
        logs = self.log_likelihood(image, states, state.reference)
        if steered:
            share = steered / count
            f = self._prior(states, before, size)
            g = self._proposal(states, boxes)
            logs = logs + np.log(f + 1e-300) - np.log(share * g + (1 - share) * f + 1e-300)
        after = ParticleSet(states, logs)
        top = logs.max()
        evidence = float(top + np.log(np.exp(logs - top).mean()))
        info = FaceFilterInfo(steered, float(effective_number(after)), evidence)
        return FaceFilterState(after, state.reference), info

    def log_likelihood(
        self,
        image: Image,
        states: Float[np.ndarray, "m 3"],
        reference: Float[np.ndarray, "p 3 bins"],
    ) -> Float[np.ndarray, " m"]:
        """Return the logarithm of the likelihood of colour and outline, up to a constant."""
        rules = self.rules
        states = checks.array("states", states, ("m", 3))
        squared = bhattacharyya(self._colours(image, states), reference) ** 2
        edges = edge_distances(cv2.cvtColor(image, cv2.COLOR_RGB2GRAY))
        apart = contour_distances(edges, _framed(states), ELLIPSE)
        return -squared.mean(axis=(1, 2)) / (2 * rules.colour_sigma**2) - apart**2 / (
            2 * rules.shape_sigma**2
        )

    def _colours(self, image: np.ndarray, states: np.ndarray) -> np.ndarray:
        points = patch_points(_framed(states), PATCHES)
        return patch_histograms(colour_picture("image", image), points, bins=self.rules.bins)[0]

    def _walked(self, states: np.ndarray, rng: np.random.Generator) -> np.ndarray:
        rules, noise = self.rules, rng.standard_normal(states.shape)
        side = states[:, 2:]
        grown = np.clip(side * np.exp(rules.grow * noise[:, 2:]), *rules.sides)
        return np.hstack([states[:, :2] + rules.move * side * noise[:, :2], grown])

    def _anywhere(self, count: int, size: np.ndarray, rng: np.random.Generator) -> np.ndarray:
        low, high = np.log(self.rules.sides)
        return np.hstack(
            [rng.uniform(0, size, (count, 2)), np.exp(rng.uniform(low, high, (count, 1)))]
        )

    def _near(self, boxes: np.ndarray, count: int, rng: np.random.Generator) -> np.ndarray:
        chosen = boxes[rng.integers(len(boxes), size=count)]
        rules, noise = self.rules, rng.standard_normal((count, 3))
        side = chosen[:, 2:3]
        middle = chosen[:, :2] + chosen[:, 2:] / 2 + rules.place_sigma * side * noise[:, :2]
        return np.hstack([middle, side * np.exp(rules.side_sigma * noise[:, 2:])])

    def _prior(self, states: np.ndarray, before: ParticleSet, size: np.ndarray) -> np.ndarray:
        """Return f of many states, a density of u, v and log s."""
        rules = self.rules
        low, high = np.log(rules.sides)
        sides = np.log(states[:, 2])
        inside = ((states[:, :2] >= 0) & (states[:, :2] <= size)).all(axis=1)
        inside &= (sides >= low) & (sides <= high)
        jump = inside / (size.prod() * (high - low))
        walk = _mixture(states, before.states, before.weights, rules.move, rules.grow)
        return (1 - rules.anywhere) * walk + rules.anywhere * jump

    def _proposal(self, states: np.ndarray, boxes: np.ndarray) -> np.ndarray:
        """Return g of many states."""
        middles = np.hstack([boxes[:, :2] + boxes[:, 2:] / 2, boxes[:, 2:3]])
        even = np.full(len(boxes), 1 / len(boxes))
        return _mixture(states, middles, even, self.rules.place_sigma, self.rules.side_sigma)


def _framed(states: np.ndarray) -> np.ndarray:
    """Return states x, y, θ, s of upright faces."""
    return np.column_stack([states[:, :2], np.zeros(len(states)), states[:, 2]])


def _mixture(
    states: np.ndarray, middles: np.ndarray, weights: np.ndarray, place: float, side: float
) -> np.ndarray:
    """Return a mixture of normal densities of u, v and log s at many states, some at a time."""
    some = max(TOGETHER // len(middles), 1)
    parts = (states[k : k + some] for k in range(0, len(states), some))
    return np.concatenate([_densities(part, middles, weights, place, side) for part in parts])


def _densities(
    states: np.ndarray, middles: np.ndarray, weights: np.ndarray, place: float, side: float
) -> np.ndarray:
    spread = place * middles[:, 2]
    away = ((states[:, None, :2] - middles[None, :, :2]) ** 2).sum(axis=-1) / spread**2
    away += (np.log(states[:, None, 2] / middles[None, :, 2]) / side) ** 2
    scale = weights / ((2 * np.pi) ** 1.5 * spread**2 * side)
    return np.exp(-away / 2) @ scale
