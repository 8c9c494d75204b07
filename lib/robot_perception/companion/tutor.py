r"""A person followed by particles: patches of colour, a silhouette, and models that may learn.

Condensation on :math:`x = [x, y, \theta, s]^\top`. The likelihood of a state is the product of
those of its cues, eq. (1); of the patches' colours and of the silhouette

.. math::
    p(z^C \mid x) \propto \exp\Bigl( -\sum_{k} \sum_{c} D^2(h_{x,k}^c, h_{\mathrm{ref},k}^c)
        / 2 \sigma_C^2 \Bigr), \qquad
    p(z^S \mid x) \propto \exp\bigl( -D_S^2 / 2 \sigma_S^2 \bigr)

and after each picture the model of a patch may take in what is seen at the estimate,
:math:`h_\mathrm{ref} \leftarrow (1 - \alpha) h_\mathrm{ref} + \alpha h_{\hat x}`. Equation numbers
are those of Menezes, Lerasle and Dias, "Visual Tracking Modalities for a Companion Robot", sections
IV and V. The deviations, rates and gates are ours: the paper names none.
"""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import Annotated, final

import numpy as np
from jaxtyping import Bool, Float, UInt8

from robot_perception import checks
from robot_perception.beliefs import ParticleSet
from robot_perception.companion.boxes import colour_picture
from robot_perception.companion.cues import (
    bhattacharyya,
    contour_distances,
    edge_distances,
    patch_histograms,
    patch_points,
)
from robot_perception.extras import needing
from robot_perception.fields import Positive, Share, checked, from_to, not_empty
from robot_perception.particles import condensation

with needing():
    import cv2

__all__ = [
    "PATCHES",
    "SILHOUETTE",
    "WHOLE",
    "TutorInfo",
    "TutorModel",
    "TutorRules",
    "TutorState",
    "TutorTracker",
]

Image = UInt8[np.ndarray, "height width 3"]
Cue = Callable[[Image, Float[np.ndarray, "m 4"]], Float[np.ndarray, " m"]]

PATCHES = np.array(
    [
        [-0.11, -0.50, 0.22, 0.27],
        [-0.25, -0.13, 0.24, 0.30],
        [0.01, -0.13, 0.24, 0.30],
        [-0.20, 0.19, 0.40, 0.29],
    ]
)
"""Head, both halves of the chest, and belly: left, top, width and height in heights of head and
trunk together, from their middle."""
WHOLE = np.array([[-0.25, -0.50, 0.50, 1.0]])
"""One patch for head and trunk."""
_SIDE = np.array(
    [
        (0.05, -0.49), (0.09, -0.44), (0.095, -0.36), (0.08, -0.28), (0.09, -0.22), (0.17, -0.18),
        (0.25, -0.13), (0.29, -0.05), (0.30, 0.08), (0.31, 0.20), (0.32, 0.34),
    ]
)  # fmt: skip
SILHOUETTE = np.concatenate([_SIDE * [-1, 1], _SIDE])
"""Points of the outline of head and shoulders (22, 2), in the same unit."""


def _with_sizes(name: str, value: np.ndarray) -> np.ndarray:
    """Return boxes, one at least, each with a width and a height."""
    if not len(value) or not value[:, 2:].min() > 0:
        least = f"{value[:, 2:].min():g}" if len(value) else "none"
        raise ValueError(f"{name} must be one at least, with a width and a height, got {least}")
    return value


@final
@dataclass(frozen=True, eq=False, slots=True)
class TutorModel:
    """Appearance model of a person.

    Parameters
    ----------
    patches : (p, 4)
        Left, top, width and height in the person's frame, whose unit is the height of what is
        followed.
    contour : (n, 2), optional
        Points of the silhouette in that frame; none if shape is no cue.
    cues
        More cues, by the user's names: functions of the picture and of states (m, 4) that return
        the logarithm of a likelihood for each.
    """

    patches: Annotated[Float[np.ndarray, "p 4"], _with_sizes] = field(
        default_factory=lambda: PATCHES
    )
    contour: Annotated[Float[np.ndarray, "n 2"], not_empty] | None = field(
        default_factory=lambda: SILHOUETTE
    )
    cues: Mapping[str, Cue] = field(default_factory=lambda: MappingProxyType({}))

    def __post_init__(self) -> None:
        checked(self)
        object.__setattr__(self, "cues", MappingProxyType(self.cues))


@final
@dataclass(frozen=True, slots=True)
class TutorRules:
    """Numbers of the filter; all ours.

    Parameters
    ----------
    particles
        How many.
    move, turn, grow
        Standard deviations of the motion in a picture: of the place, as a share of the scale; of
        the angle, rad; of the logarithm of the scale.
    colour_sigma
        σ of the distance of a patch's colours in one channel: squares are summed over patches and
        channels, so that each of them counts as a measure of its own.
    shape_sigma
        Of the silhouette's distance to edges, px.
    rate
        α, by which a model takes in what is seen; 0 for models that stay as they are.
    gate
        Distance above which a patch does not learn; 1 for no gate.
    whole_gate
        Mean distance of all patches above which nothing is learnt and the person is taken to be
        hidden; 1 for never.
    bins, grid
        Of the histograms of `patch_histograms`.
    """

    particles: Annotated[int, from_to(2, 10**6)] = 200
    move: Positive = 0.06
    turn: Positive = 0.03
    grow: Positive = 0.03
    colour_sigma: Positive = 0.12
    shape_sigma: Positive = 3.0
    rate: Share = 0.05
    gate: Share = 0.35
    whole_gate: Share = 0.45
    bins: Annotated[int, from_to(2, 256)] = 8
    grid: Annotated[int, from_to(2, 256)] = 8
    __post_init__ = checked


@final
@dataclass(frozen=True, eq=False, slots=True)
class TutorState:
    """State of the tracker of a person.

    Parameters
    ----------
    particles
        States (m, 4): x, y (px), θ (rad), s (px).
    reference : (p, 3, bins)
        The model of each patch.
    missed
        For how many pictures the person has been taken to be hidden.
    """

    particles: ParticleSet
    reference: Float[np.ndarray, "p 3 bins"]
    missed: Annotated[int, from_to(0)] = 0

    def __post_init__(self) -> None:
        checked(self)
        checks.shaped("particles.states", self.particles.states, ("m", 4))

    @property
    def estimate(self) -> Float[np.ndarray, " 4"]:
        """The mean state: x, y, θ, s."""
        return self.particles.mean

    @property
    def box(self) -> Float[np.ndarray, " 4"]:
        """The box of what is followed, as wide as `WHOLE` is: left, top, width, height, px."""
        x, y, _, s = self.estimate
        left, top, wide, high = WHOLE[0] * s
        return np.array([x + left, y + top, wide, high])


@final
@dataclass(frozen=True, eq=False, slots=True)
class TutorInfo:
    """Diagnostics of one step.

    Parameters
    ----------
    distances : (p,)
        Of each patch at the estimate, mean of the three channels.
    contour
        Distance of the silhouette at the estimate, px; ``None`` without shape.
    hidden
        Whether the person is taken to be hidden.
    learnt : (p,)
        Which patches took in what was seen.
    effective
        Effective number of particles before they were drawn anew for the next picture.
    """

    distances: Float[np.ndarray, " p"]
    contour: float | None
    hidden: bool
    learnt: Bool[np.ndarray, " p"]
    effective: float


@final
@dataclass(frozen=True, eq=False, slots=True)
class TutorTracker:
    """Follows a person.

    Parameters
    ----------
    model
        Patches, silhouette and more cues.
    rules
        Numbers.

    References
    ----------
    Section IV; Isard and Blake, "Contour tracking by stochastic propagation of conditional
    density", ECCV 1996; Nummiaro, Koller-Meier and Van Gool, "An adaptive color-based particle
    filter", Image and Vision Computing 21, 2003, for the adaptation.
    """

    model: TutorModel = field(default_factory=TutorModel)
    rules: TutorRules = field(default_factory=TutorRules)
    __post_init__ = checked

    def start(
        self, image: Image, box: Float[np.ndarray, " 4"], *, rng: np.random.Generator
    ) -> TutorState:
        """Return what is known after the first picture, in which the person is told.

        Parameters
        ----------
        image : (height, width, 3)
            Red, green, blue.
        box : (4,)
            Of head and trunk: left, top, width, height, px.
        rng
            Source of the particles.

        Raises
        ------
        TypeError, ValueError
            As `patch_histograms`; also if the box has no area or nothing of a patch lies in the
            picture.
        """
        checks.generator("rng", rng)
        left, top, wide, high = checks.vector("box", box, 4)
        if not (wide > 0 and high > 0):
            raise ValueError(f"box must have a width and a height, got {wide:g} and {high:g}")
        at = np.array([left + wide / 2, top + high / 2, 0.0, high])
        reference, inside = self._colours(image, at[None])
        if not inside.min() > 0:
            raise ValueError("box must let every patch reach into the picture, got one outside")
        states = np.tile(at, (self.rules.particles, 1))
        return TutorState(ParticleSet.uniform(self._moved(states, rng)), reference[0])

    def step(
        self, state: TutorState, image: Image, *, rng: np.random.Generator
    ) -> tuple[TutorState, TutorInfo]:
        """Return what is known after a picture.

        Where the person is taken to be hidden nothing is learnt, and the particles, which then
        weigh much alike, spread until colours and silhouette fit again.

        Parameters
        ----------
        state
            Before it.
        image : (height, width, 3)
            Red, green, blue.
        rng
            Source of the motion and the drawing.

        Raises
        ------
        TypeError, ValueError
            As `patch_histograms` and `edge_distances`; also if the state is of other patches, or a
            cue returns something else than a number a particle.
        """
        checks.instance("state", state, TutorState)
        image = colour_picture("image", image)
        rules = self.rules
        shape = len(self.model.patches), 3, rules.bins
        checks.shaped("state.reference", state.reference, shape, beside="these patches and bins")
        edges = self._edges(image)

        def log_likelihood(states: np.ndarray) -> np.ndarray:
            return self.log_likelihood(image, states, state.reference, edges)

        particles, info = condensation(state.particles, self._moved, log_likelihood, rng=rng)
        estimate = particles.mean
        seen, _ = self._colours(image, estimate[None])
        distances = bhattacharyya(seen[0], state.reference).mean(axis=-1)
        contour = None
        if edges is not None:
            contour = float(contour_distances(edges, estimate[None], self.model.contour)[0])
        hidden = bool(distances.mean() > rules.whole_gate)
        learnt = np.full(len(distances), not hidden and rules.rate > 0) & (distances <= rules.gate)
        blend = rules.rate * learnt[:, None, None]
        reference = (1 - blend) * state.reference + blend * seen[0]
        after = TutorState(particles, reference, state.missed + 1 if hidden else 0)
        return after, TutorInfo(distances, contour, hidden, learnt, info.effective)

    def log_likelihood(
        self,
        image: Image,
        states: Float[np.ndarray, "m 4"],
        reference: Float[np.ndarray, "p 3 bins"],
        edges: Float[np.ndarray, "height width"] | None = None,
    ) -> Float[np.ndarray, " m"]:
        """Return the logarithm of eq. (1) of many states, up to a constant.

        Parameters
        ----------
        image, states
            What is seen, and where the person may be.
        reference : (p, 3, bins)
            The models of the patches.
        edges : (height, width), optional
            Distances to edges, if they are known; they are computed otherwise.
        """
        rules, model = self.rules, self.model
        seen, _ = self._colours(image, states)
        squared = bhattacharyya(seen, reference) ** 2
        logs = -squared.sum(axis=(1, 2)) / (2 * rules.colour_sigma**2)
        if model.contour is not None:
            if edges is None:
                edges = self._edges(image)
            edges = checks.array("edges", edges, image.shape[:2])
            if (edges < 0).any():
                raise ValueError(f"edges must not be negative, got {edges.min():g}")
            logs -= contour_distances(edges, states, model.contour) ** 2 / (
                2 * rules.shape_sigma**2
            )
        for name, cue in model.cues.items():
            logs = logs + checks.array(
                f"cues[{name!r}](image, states)", cue(image, states), (len(states),)
            )
        return logs

    def _edges(self, image: np.ndarray) -> np.ndarray | None:
        if self.model.contour is None:
            return None
        return edge_distances(cv2.cvtColor(image, cv2.COLOR_RGB2GRAY))

    def _colours(self, image: np.ndarray, states: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        rules = self.rules
        points = patch_points(states, self.model.patches, grid=rules.grid)
        return patch_histograms(colour_picture("image", image), points, bins=rules.bins)

    def _moved(self, states: np.ndarray, rng: np.random.Generator) -> np.ndarray:
        """Return a draw of the motion, a random walk, from each state."""
        rules, noise = self.rules, rng.standard_normal(states.shape)
        scale = states[:, 3:]
        moved = states[:, :2] + rules.move * scale * noise[:, :2]
        turned = np.clip(states[:, 2:3] + rules.turn * noise[:, 2:3], -math.pi / 4, math.pi / 4)
        grown = np.clip(scale * np.exp(rules.grow * noise[:, 3:]), 8.0, 5000.0)
        return np.hstack([moved, turned, grown])
