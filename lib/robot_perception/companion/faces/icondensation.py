r"""Particle filter of a face with importance sampling from a face detector (ICONDENSATION).

The state is the centre of the face and the side of its box, :math:`x = [u, v, s]^\top`. It moves by
a random walk and, with a small probability ρ, jumps to anywhere in the picture. The predicted
density, from the particles :math:`x_j` and weights :math:`\pi_j` of the picture before, is

.. math:: f(x) = (1 - \rho) \sum_j \pi_j\, \mathcal N(x; x_j, \Sigma_j) + \rho\, U(x)

The detections d of the new picture, n of them, give a second density, the importance function

.. math:: g(x) = \frac 1 n \sum_d \mathcal N(x; d, \Sigma_d)

All normal densities are of u, v and log s. A share α of the new particles is drawn from g, the
others from f. Each is weighted as a draw from the mixture of the two:

.. math:: \pi \propto p(z \mid x)\, \frac{f(x)}{\alpha\, g(x) + (1 - \alpha) f(x)}

So the detections decide where particles are placed, but the posterior remains that of the prior f
and the likelihood :math:`p(z \mid x)`. With α = 0 it is CONDENSATION.
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
"""Patches of face and hair: left, top, width and height, from the centre, in units of the side."""
_TURN = np.linspace(0, 2 * np.pi, 24, endpoint=False)
ELLIPSE = np.stack([0.44 * np.cos(_TURN), 0.06 + 0.58 * np.sin(_TURN)], axis=1)
"""Points of the outline of a head, from the centre, in units of the side."""
TOGETHER = 1_000_000
"""Most pairs of a particle and a component of a mixture whose densities are computed at a time."""

Image = UInt8[np.ndarray, "height width 3"]


def _part(name: str, value: Any) -> float:
    """Return a share below 1."""
    found = checks.share(name, value)
    if not found < 1:
        raise ValueError(f"{name} must be below 1, got {checks.shown(value)}")
    return found


def _sides(name: str, value: Any) -> tuple[float, float]:
    """Return two positive numbers that rise."""
    low, high = checks.vector(name, value, 2).tolist()
    if not 0 < low < high:
        raise ValueError(f"{name} must rise from above 0, got {low:g} and {high:g}")
    return low, high


@final
@dataclass(frozen=True, slots=True)
class FaceFilterRules:
    """Parameters of the filter. The papers give no values for faces: all are our choice.

    Parameters
    ----------
    particles
        Number of particles.
    move, grow
        Standard deviations of the random walk from one picture to the next: of the centre, in
        units of the side, and of the logarithm of the side.
    anywhere
        ρ, the probability of a jump to anywhere.
    steered
        α, the share of the particles that is drawn around detections; 0 for plain CONDENSATION.
    place_sigma, side_sigma
        Standard deviations of a face around a detection: of the centre, in units of the side, and
        of the logarithm of the side.
    colour_sigma, shape_sigma
        Standard deviations of the likelihood: of the Bhattacharyya distance of the patches'
        colours, and of the distance of the outline to edges, px.
    sides
        Smallest and largest side of a face, px.
    bins
        Number of bins of a colour histogram.
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
        States (m, 3) with their weights: u, v, s, px.
    reference : (2, 3, bins)
        Reference histograms of face and hair, one for each channel.
    """

    particles: ParticleSet
    reference: Float[np.ndarray, "2 3 bins"]

    def __post_init__(self) -> None:
        checked(self)
        checks.shaped("particles.states", self.particles.states, ("m", 3))

    @property
    def box(self) -> Float[np.ndarray, " 4"]:
        """Box of the mean state: left, top, width and height, px."""
        u, v, side = self.particles.mean
        return np.array([u - side / 2, v - side / 2, side, side])


@final
@dataclass(frozen=True, eq=False, slots=True)
class FaceFilterInfo:
    """Diagnostics of one step.

    Parameters
    ----------
    steered
        Number of particles that were drawn around detections.
    effective
        Effective number of particles.
    log_evidence
        Logarithm of the mean weight before normalisation.
    """

    steered: int
    effective: float
    log_evidence: float


@final
@dataclass(frozen=True, eq=False, slots=True)
class FaceFilter:
    """Tracks a face by colour and outline, steered by detections.

    Parameters
    ----------
    rules
        Parameters of the filter.

    References
    ----------
    Menezes et al., section III: "importance sampling offers a mathematically principled way of
    directing search according to the face detector output". Isard and Blake, "ICONDENSATION:
    unifying low-level and high-level tracking in a stochastic framework", ECCV 1998, weight a
    particle from g by f / g. The weight by the mixture (Veach and Guibas 1995) has the same
    expectation, and it is bounded by 1 / (1 - α). Jumps to anywhere replace their reinitialisation.
    """

    rules: FaceFilterRules = field(default_factory=FaceFilterRules)
    __post_init__ = checked

    def start(
        self, image: Image, box: Float[np.ndarray, " 4"], *, rng: np.random.Generator
    ) -> FaceFilterState:
        """Return the state at a first picture in which the box of the face is given.

        Particles are spread by one step of the random walk; the colours become the reference.

        Parameters
        ----------
        image : (height, width, 3)
            Red, green, blue.
        box : (4,)
            Left, top, width and height of the face, px.
        rng
            Source of the draws.

        Raises
        ------
        TypeError, ValueError
            As `patch_histograms`; also if the box has no area, or no part of the face lies in the
            picture.
        """
        checks.generator("rng", rng)
        left, top, side, high = check_box("box", box)
        at = np.array([left + side / 2, top + high / 2, side])
        reference = self._colours(image, at[None])[0]
        if not reference[0].any():  # the face lies outside; hair may lie above the picture
            size = image.shape[1::-1]
            raise ValueError(f"box must reach into the picture of {size} px, got {box}")
        states = self._walked(np.tile(at, (self.rules.particles, 1)), rng)
        return FaceFilterState(ParticleSet.uniform(states), reference)

    def sees(self, image: Image, box: Float[np.ndarray, " 4"]) -> bool:
        """Tell whether some part of the face in a box lies in the picture; hair does not count.

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
        """Return the state after the next picture: resample, predict, draw from detections, update.

        Parameters
        ----------
        state
            State after the picture before.
        image : (height, width, 3)
            Red, green, blue.
        boxes : (n, 4)
            Faces that a detector finds in this picture: left, top, width and height, px. Without
            any, the step is one of plain CONDENSATION.
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
        r"""Return the log-likelihood of states by colour and outline, up to a constant.

        .. math:: \log p(z \mid x) = -\frac{\overline{B^2}}{2 \sigma_c^2}
            - \frac{e^2}{2 \sigma_s^2}

        with the Bhattacharyya distances B of the histograms of patches and channels to the
        reference, and the root mean squared distance e of the outline to edges, px.
        """
        rules = self.rules
        states = checks.array("states", states, ("m", 3))
        squared = bhattacharyya(self._colours(image, states), reference) ** 2
        edges = edge_distances(cv2.cvtColor(image, cv2.COLOR_RGB2GRAY))
        apart = contour_distances(edges, _framed(states), ELLIPSE)
        return -squared.mean(axis=(1, 2)) / (2 * rules.colour_sigma**2) - apart**2 / (
            2 * rules.shape_sigma**2
        )

    def _colours(self, image: np.ndarray, states: np.ndarray) -> np.ndarray:
        """Return the histograms of face and hair at many states (m, 2, 3, bins)."""
        points = patch_points(_framed(states), PATCHES)
        return patch_histograms(colour_picture("image", image), points, bins=self.rules.bins)[0]

    def _walked(self, states: np.ndarray, rng: np.random.Generator) -> np.ndarray:
        """Return states after a step of the random walk, sides kept within their range."""
        rules, noise = self.rules, rng.standard_normal(states.shape)
        side = states[:, 2:]
        grown = np.clip(side * np.exp(rules.grow * noise[:, 2:]), *rules.sides)
        return np.hstack([states[:, :2] + rules.move * side * noise[:, :2], grown])

    def _anywhere(self, count: int, size: np.ndarray, rng: np.random.Generator) -> np.ndarray:
        """Draw states from U: uniform in u, v over the picture and in log s."""
        low, high = np.log(self.rules.sides)
        return np.hstack(
            [rng.uniform(0, size, (count, 2)), np.exp(rng.uniform(low, high, (count, 1)))]
        )

    def _near(self, boxes: np.ndarray, count: int, rng: np.random.Generator) -> np.ndarray:
        """Draw states from g, around detections."""
        chosen = boxes[rng.integers(len(boxes), size=count)]
        rules, noise = self.rules, rng.standard_normal((count, 3))
        side = chosen[:, 2:3]
        middle = chosen[:, :2] + chosen[:, 2:] / 2 + rules.place_sigma * side * noise[:, :2]
        return np.hstack([middle, side * np.exp(rules.side_sigma * noise[:, 2:])])

    def _prior(self, states: np.ndarray, before: ParticleSet, size: np.ndarray) -> np.ndarray:
        """Return f at many states, a density of u, v and log s."""
        rules = self.rules
        low, high = np.log(rules.sides)
        sides = np.log(states[:, 2])
        inside = ((states[:, :2] >= 0) & (states[:, :2] <= size)).all(axis=1)
        inside &= (sides >= low) & (sides <= high)
        jump = inside / (size.prod() * (high - low))
        walk = _mixture(states, before.states, before.weights, rules.move, rules.grow)
        return (1 - rules.anywhere) * walk + rules.anywhere * jump

    def _proposal(self, states: np.ndarray, boxes: np.ndarray) -> np.ndarray:
        """Return g at many states, a density of u, v and log s."""
        middles = np.hstack([boxes[:, :2] + boxes[:, 2:] / 2, boxes[:, 2:3]])
        even = np.full(len(boxes), 1 / len(boxes))
        return _mixture(states, middles, even, self.rules.place_sigma, self.rules.side_sigma)


def _framed(states: np.ndarray) -> np.ndarray:
    """Return states (x, y, θ, s) of upright faces: θ is 0."""
    return np.column_stack([states[:, :2], np.zeros(len(states)), states[:, 2]])


def _mixture(
    states: np.ndarray, middles: np.ndarray, weights: np.ndarray, place: float, side: float
) -> np.ndarray:
    """Return a mixture of normal densities of u, v and log s at many states, in chunks.

    A component's centre is a row of ``middles`` (u, v, s). Its standard deviations are ``place``
    times the component's side for u and v, and ``side`` for log s.
    """
    some = max(TOGETHER // len(middles), 1)
    parts = (states[k : k + some] for k in range(0, len(states), some))
    return np.concatenate([_densities(part, middles, weights, place, side) for part in parts])


def _densities(
    states: np.ndarray, middles: np.ndarray, weights: np.ndarray, place: float, side: float
) -> np.ndarray:
    """Return the mixture at the states of one chunk."""
    spread = place * middles[:, 2]
    away = ((states[:, None, :2] - middles[None, :, :2]) ** 2).sum(axis=-1) / spread**2
    away += (np.log(states[:, None, 2] / middles[None, :, 2]) / side) ** 2
    scale = weights / ((2 * np.pi) ** 1.5 * spread**2 * side)
    return np.exp(-away / 2) @ scale
