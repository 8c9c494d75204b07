r"""Two arms tracked by particles: eight angles, many cues, three filters.

The state is that of `body_model`; between pictures each angle walks at random,
:math:`x_t \sim \mathcal N(x_{t-1}, \Sigma)`. In the auxiliary filter, which the paper takes,
particles are first drawn where "rough correspondences between model patches and image features" are
good, here by the patches' likelihood at the expected state, and then weighed by all cues.

References
----------
Menezes, Lerasle and Dias, "Visual Tracking Modalities for a Companion Robot", section V. Numbers
are ours but for the 400 particles.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from types import MappingProxyType
from typing import Annotated, Any, final

import numpy as np
from jaxtyping import Bool, Float, UInt8

from robot_perception import checks
from robot_perception.arms.body_model import REST, BodyModel, Measures, Patches
from robot_perception.arms.likelihoods import (
    COLOUR,
    TEXTURE,
    Bodies,
    CollisionCue,
    Cue,
    EdgeCue,
    EdgeRules,
    LimitCue,
    Look,
    PatchCue,
    StabiliserCue,
    apart,
    confidences,
    edge_weight,
    features,
    summed,
)
from robot_perception.beliefs import ParticleSet
from robot_perception.cameras import Pinhole
from robot_perception.companion.boxes import check_box, check_reach, colour_picture
from robot_perception.companion.cues import patch_histograms
from robot_perception.companion.faces.detection import FaceDetector
from robot_perception.extras import needing
from robot_perception.fields import Positive, Share, checked, from_to
from robot_perception.particles import (
    StepInfo,
    auxiliary,
    condensation,
    effective_number,
    importance,
    systematic,
)

with needing():
    import cv2

__all__ = [
    "BOUNDS",
    "CUES",
    "FILTERS",
    "ArmInfo",
    "ArmRules",
    "ArmState",
    "ArmTracker",
    "CueMaker",
    "First",
    "Picture",
    "find_face",
]

Image = UInt8[np.ndarray, "height width 3"]
States = Float[np.ndarray, "m 8"]
_HANDS = (2, 5)
"""Indices of the limbs that are hands."""


@final
@dataclass(frozen=True, eq=False, slots=True)
class First:
    """Knowledge of the first picture, from which cues are made.

    Parameters
    ----------
    seen
        The picture.
    model
        The body.
    state : (8,)
        The pose in it, rad.
    patches
        On the limbs.
    reference : (p, 4, bins)
        How these look.
    """

    seen: Look
    model: BodyModel
    state: Float[np.ndarray, " 8"]
    patches: Patches
    reference: Float[np.ndarray, "p 4 bins"]


CueMaker = Callable[[First], Cue]


def _edges(first: First) -> Cue:
    return EdgeCue(gain=0.5, weight=edge_weight(first.seen))


def _patches(channels: tuple[int, ...]) -> CueMaker:
    def make(first: First) -> Cue:
        trust = confidences(first.reference, channels)
        return PatchCue(first.patches, first.reference, channels, trust, sigma=0.25)

    return make


CUES: Mapping[str, CueMaker] = MappingProxyType(
    {
        "edges": _edges,
        "colour": _patches(COLOUR),
        "texture": _patches(TEXTURE),
        "stabiliser": lambda first: StabiliserCue(),
    }
)
"""The paper's cues: silhouettes on edges, static and moving, patches of colour and of texture, each
as strong as the paper says, and the pull towards the pose at rest."""
BOUNDS: Mapping[str, CueMaker] = MappingProxyType(
    {"collisions": lambda first: CollisionCue(), "limits": lambda first: LimitCue()}
)
"""Cues that bound what a body can do. A state that breaks one of these is not measured."""


def _noise(name: str, value: Any) -> tuple[float, ...]:
    """Return four positive numbers."""
    found = checks.vector(name, value, 4).tolist()
    if not min(found) > 0:
        raise ValueError(f"{name} must be positive, got {found}")
    return tuple(found)


def _filter(name: str, value: Any) -> str:
    """Return a name in `FILTERS`."""
    return checks.one_of(name, value, FILTERS)


def _names(name: str, value: Any) -> tuple[str, ...]:
    """Return a tuple of texts; one text is none."""
    return checks.instances(name, checks.instance(name, value, tuple), str)


@final
@dataclass(frozen=True, slots=True)
class ArmRules:
    """Numbers of the tracker.

    Parameters
    ----------
    particles
        How many: 400, section V.
    noise
        Standard deviations of α, β, γ and δ in a picture, rad.
    filter
        A name in `FILTERS`.
    edges
        How edges are found.
    ahead
        Names of the cues that the auxiliary filter looks ahead with.
    bins
        Of the patches' histograms.
    rounds
        Of the search for the first pose.
    lost_edges, lost_patches
        Root mean square distance of the silhouette (px) and mean D² of the patches at the estimate:
        above both the arms are taken to be lost.
    """

    particles: Annotated[int, from_to(2, 10**6)] = 400
    noise: Annotated[tuple[float, float, float, float], _noise] = (0.13, 0.13, 0.20, 0.20)
    filter: Annotated[str, _filter] = "auxiliary"
    edges: EdgeRules = field(default_factory=EdgeRules)
    ahead: Annotated[tuple[str, ...], _names] = ("colour", "texture")
    bins: Annotated[int, from_to(2, 256)] = 8
    rounds: Annotated[int, from_to(0, 1000)] = 8
    lost_edges: Positive = 2.5
    lost_patches: Share = 0.35
    __post_init__ = checked


@final
@dataclass(frozen=True, eq=False, slots=True)
class ArmState:
    """State of the arm tracker.

    Parameters
    ----------
    particles
        States (m, 8), rad.
    grey : (height, width)
        Intensity of the last picture, for the flow.
    first
        What the cues were made from.
    cues, bounds
        By name.
    lost
        For how many pictures the arms have been taken to be lost.
    """

    particles: ParticleSet
    grey: UInt8[np.ndarray, "height width"] = field(repr=False)
    first: First = field(repr=False)
    cues: Mapping[str, Cue] = field(repr=False)
    bounds: Mapping[str, Cue] = field(repr=False)
    lost: Annotated[int, from_to(0)] = 0

    def __post_init__(self) -> None:
        checked(self)
        checks.shaped("particles.states", self.particles.states, ("m", 8))

    @property
    def mean(self) -> Float[np.ndarray, " 8"]:
        """The mean state, rad."""
        return self.particles.mean

    @property
    def spread(self) -> Float[np.ndarray, " 8"]:
        """Standard deviation of each angle, rad."""
        return np.sqrt(np.diag(self.particles.cov))


@final
@dataclass(frozen=True, eq=False, slots=True)
class ArmInfo:
    """Diagnostics of one step.

    Parameters
    ----------
    logs
        Logarithm of each cue's likelihood at the mean state, by name.
    joints : (2, 4, 3)
        Shoulder, elbow, wrist and fingertips at the mean state, m.
    contour
        Root mean square distance of the visible silhouette to edges there, px; infinite if nothing
        of it is visible.
    patches
        Mean D² of the patches there.
    saved
        Share of the particles that were not measured, as they break a bound.
    effective
        Effective number of particles.
    lost
        Whether the arms are taken to be lost.
    """

    logs: Mapping[str, float]
    joints: Float[np.ndarray, "2 4 3"]
    contour: float
    patches: float
    saved: float
    effective: float
    lost: bool


@final
@dataclass(eq=False)
class Picture:
    """Interface of a picture for a filter.

    Parameters
    ----------
    state
        Before it.
    seen
        What the picture says.
    rules
        Numbers.
    """

    state: ArmState
    seen: Look
    rules: ArmRules
    share: float = field(default=0.0, init=False)
    __post_init__ = checked

    @property
    def noise(self) -> Float[np.ndarray, " 8"]:
        """Standard deviations of the motion, rad."""
        return np.tile(self.rules.noise, 2)

    def move(self, states: States, rng: np.random.Generator) -> States:
        """Return a draw of the motion from each state."""
        states = checks.array("states", states, ("m", 8))
        checks.generator("rng", rng)
        return states + self.noise * rng.standard_normal(states.shape)

    def expect(self, states: States) -> States:
        """Return the expected next state of each."""
        return checks.array("states", states, ("m", 8))

    def ahead(self, states: States) -> Float[np.ndarray, " m"]:
        """Return the logarithm of what the auxiliary filter looks ahead with."""
        cues = {name: cue for name, cue in self.state.cues.items() if name in self.rules.ahead}
        logs = summed(cues, self.seen, Bodies(self.state.first.model, states))
        return sum(logs.values(), start=np.zeros(len(states)))

    def log_likelihood(self, states: States) -> Float[np.ndarray, " m"]:
        """Return the logarithm of the likelihood of each state.

        A state that breaks a bound is not measured: it is taken to be as bad as the worst of the
        others, and worse by what the bound says.
        """
        model, states = self.state.first.model, checks.array("states", states, ("m", 8))
        bounds = summed(self.state.bounds, self.seen, Bodies(model, states))
        logs = sum(bounds.values(), start=np.zeros(len(states)))
        free = logs == 0
        self.share = 1 - float(free.mean())
        if free.any():
            found = summed(self.state.cues, self.seen, Bodies(model, states[free]))
            measured = sum(found.values(), start=np.zeros(int(free.sum())))
            logs[~free] += measured.min()
            logs[free] = measured
        return logs

    def log_likelihoods(self, states: States) -> Float[np.ndarray, "m 2"]:
        """Return the logarithm of the likelihood of both arms of each state, as `apart` has them.

        An arm that breaks a bound is taken to be as bad as the worst of the others, and worse by
        what the bound says; a state is not measured if both of its arms do.
        """
        model, states = self.state.first.model, checks.array("states", states, ("m", 8))
        bounds = apart(self.state.bounds, self.seen, Bodies(model, states))
        logs = sum(bounds.values(), start=np.zeros((len(states), 2)))
        free = logs == 0
        asked = free.any(axis=1)
        self.share = 1 - float(asked.mean())
        if asked.any():
            found = apart(self.state.cues, self.seen, Bodies(model, states[asked]))
            measured = np.zeros((len(states), 2))
            measured[asked] = sum(found.values(), start=np.zeros((int(asked.sum()), 2)))
            for arm in range(2):
                worst = measured[free[:, arm], arm].min(initial=0.0)
                logs[:, arm] += np.where(free[:, arm], measured[:, arm], worst)
        return logs


def _auxiliary(picture: Picture, rng: np.random.Generator) -> tuple[ParticleSet, StepInfo]:
    return auxiliary(
        picture.state.particles, picture.move, picture.expect, picture.log_likelihood, rng=rng,
        ahead=picture.ahead,
    )  # fmt: skip


def _condensation(picture: Picture, rng: np.random.Generator) -> tuple[ParticleSet, StepInfo]:
    return condensation(picture.state.particles, picture.move, picture.log_likelihood, rng=rng)


def _apart(picture: Picture, rng: np.random.Generator) -> tuple[ParticleSet, StepInfo]:
    """Move all, weigh each arm by what the cues say of it, and draw the arms apart.

    A pair of a good left arm and a bad right one passes its left arm on. Drawn arms are paired at
    random, so the particles are of one weight, and an arm has as many guesses as both.
    """
    prior = picture.state.particles
    states = picture.move(prior.states, rng)
    logs = prior.log_weights[:, None] + picture.log_likelihoods(states)
    weights = np.exp(logs - logs.max(axis=0))
    count = len(states)
    drawn = np.stack([rng.permutation(systematic(own, count, rng=rng)) for own in weights.T])
    pairs = np.hstack([states[drawn[arm], 4 * arm : 4 * arm + 4] for arm in range(2)])
    effective = float(effective_number(logs.T).min())
    evidence = float(np.log(weights.mean(axis=0)).sum() + logs.max(axis=0).sum())
    return ParticleSet.uniform(pairs), StepInfo(effective, True, drawn[0], evidence)


def _importance(picture: Picture, rng: np.random.Generator) -> tuple[ParticleSet, StepInfo]:
    """Draw half of the motions towards where the colours of the hands are found."""
    prior = picture.state.particles
    noise, aims = picture.noise, _aims(picture, prior.states)

    def move(states: States, rng: np.random.Generator) -> States:
        chosen = rng.random(len(states)) < 0.5
        return picture.move(np.where(chosen[:, None], aims, states), rng)

    def log_ratio(before: States, after: States) -> Float[np.ndarray, " m"]:
        plain, aimed = (
            -(((after - centre) / noise) ** 2).sum(axis=1) / 2 for centre in (before, aims)
        )
        return plain - np.logaddexp(plain, aimed) + np.log(2)

    return importance(prior, move, picture.log_likelihood, rng=rng, share=1.0, log_ratio=log_ratio)


FILTERS: Mapping[str, Callable[[Picture, np.random.Generator], tuple[ParticleSet, StepInfo]]] = (
    MappingProxyType(
        {
            "auxiliary": _auxiliary,
            "condensation": _condensation,
            "importance": _importance,
            "apart": _apart,
        }
    )
)
"""Filters, by how particles are brought to a new picture: looking ahead by the patches, as the
paper does; moved and weighed; moved towards the hands' colours, with the weights that makes right;
or moved and weighed for each arm by itself. The first three draw both arms of a particle at once.
"""


@final
@dataclass(frozen=True, eq=False, slots=True)
class ArmTracker:
    """Tracks both arms of a person who faces the camera.

    Parameters
    ----------
    camera
        Without distortion.
    measures
        Of the body.
    rules
        Numbers.
    cues, bounds
        What makes each cue from the first picture, by the user's names; add, leave out or replace.
    """

    camera: Pinhole
    measures: Measures = field(default_factory=Measures)
    rules: ArmRules = field(default_factory=ArmRules)
    cues: Mapping[str, CueMaker] = field(default_factory=lambda: CUES)
    bounds: Mapping[str, CueMaker] = field(default_factory=lambda: BOUNDS)

    def __post_init__(self) -> None:
        checked(self)
        for name in ("cues", "bounds"):
            object.__setattr__(self, name, MappingProxyType(getattr(self, name)))
        if not self.cues:
            raise ValueError("cues must be one at least")

    def start(
        self,
        image: Image,
        *,
        rng: np.random.Generator,
        face: Float[np.ndarray, " 4"] | None = None,
        pose: Float[np.ndarray, " 8"] | None = None,
    ) -> ArmState:
        """Return what is known after the first picture.

        Parameters
        ----------
        image : (height, width, 3)
            Red, green, blue.
        rng
            Source of the particles.
        face : (4,), optional
            The square that marks the face, px; looked for if it is not given. It tells where the
            shoulders are.
        pose : (8,), optional
            Of the arms, rad; if it is not given it is looked for near the pose at rest, by edges
            and by the skin's colour on the hands.

        Raises
        ------
        TypeError
            If the image does not hold bytes.
        ValueError
            If the image is not in colour or not of the camera's size, no face is found or the one
            that is given lies outside of the picture, or the body is too near.
        """
        checks.generator("rng", rng)
        seen = features(self._picture(image), None, self.rules.edges)
        face = find_face(image) if face is None else check_reach("face", face, image)
        model = BodyModel.from_face(face, self.camera, self.measures)
        count = self.rules.particles
        if pose is None:
            pose = self._searched(seen, model, face, rng)
        pose = checks.vector("pose", pose, 8)
        states = pose + 0.3 * np.tile(self.rules.noise, 2) * rng.standard_normal((count, 8))
        patches = model.place(pose)
        surface = model.surface(pose[None], patches)
        reference = patch_histograms(
            seen.channels, surface.points, surface.visible, bins=self.rules.bins
        )[0][0]
        first = First(seen, model, pose, patches, reference)
        made = [{name: maker(first) for name, maker in makers.items()}
                for makers in (self.cues, self.bounds)]  # fmt: skip
        return ArmState(ParticleSet.uniform(states), seen.grey, first, *made)

    def step(
        self,
        state: ArmState,
        image: Image,
        *,
        rng: np.random.Generator,
        face: Float[np.ndarray, " 4"] | None = None,
    ) -> tuple[ArmState, ArmInfo]:
        """Return what is known after a picture.

        Parameters
        ----------
        state
            Before it.
        image : (height, width, 3)
            Red, green, blue, of the size of the first one.
        rng
            Source of the motion and the drawing.
        face : (4,), optional
            The square that marks the face by now, px, as a `FaceTracker` follows it: the shoulders
            go with it. If it is not given they stay where they were.

        Raises
        ------
        TypeError
            If the image does not hold bytes.
        ValueError
            If the image is not in colour or of another size, the face is no box or too near, or a
            cue returns something else than a finite number for each state.
        """
        checks.instance("state", state, ArmState)
        checks.generator("rng", rng)
        if face is not None:
            there = BodyModel.from_face(check_box("face", face), self.camera, self.measures)
            state = replace(state, first=replace(state.first, model=there))
        image = self._picture(image)
        checks.shaped("state.grey", state.grey, image.shape[:2], f"image {image.shape}")
        seen = features(image, state.grey, self.rules.edges)
        picture = Picture(state, seen, self.rules)
        particles, info = FILTERS[self.rules.filter](picture, rng)
        model, mean = state.first.model, particles.mean
        body = Bodies(model, mean[None])
        logs = {name: float(log[0]) for name, log in summed(state.cues, seen, body).items()}
        visible = body.contours.visible[0]
        distances = EdgeCue().distances(seen, body)[0]
        contour = float(np.sqrt(np.mean(distances[visible] ** 2))) if visible.any() else np.inf
        cue = PatchCue(state.first.patches, state.first.reference)
        patches = float(cue.squared(seen, body).mean() / len(COLOUR))
        lost = contour > self.rules.lost_edges and patches > self.rules.lost_patches
        after = ArmState(particles, seen.grey, state.first, state.cues, state.bounds,
                         state.lost + 1 if lost else 0)  # fmt: skip
        joints = model.joints(mean[None])[0]
        return after, ArmInfo(
            MappingProxyType(logs), joints, contour, patches, picture.share, info.effective, lost
        )

    def _picture(self, image: Any) -> Image:
        image = colour_picture("image", image)
        width, height = self.camera.size
        checks.shaped("image", image, (height, width, 3), beside="the camera's size")
        return image

    def _searched(
        self, seen: Look, model: BodyModel, face: np.ndarray, rng: np.random.Generator
    ) -> Float[np.ndarray, " 8"]:
        """Return a pose near the one at rest that fits edges, with hands of the face's colour."""
        patches = model.place(REST)
        hands = Patches(*(getattr(patches, name)[list(_HANDS)]
                          for name in ("limbs", "along", "around")))  # fmt: skip
        skin = _skin(seen, face, self.rules.bins)
        cues = {
            "edges": EdgeCue(),
            "hands": PatchCue(hands, np.tile(skin, (2, 1, 1))),
            "rest": StabiliserCue(1.0),
            **{name: maker(None) for name, maker in BOUNDS.items()},
        }

        def log_likelihood(states: States) -> Float[np.ndarray, " m"]:
            return sum(summed(cues, seen, Bodies(model, states)).values())

        spread = np.tile([0.25, 0.2, 0.4, 0.3], 2)
        particles = ParticleSet.uniform(
            REST + spread * rng.standard_normal((self.rules.particles, 8))
        )
        for k in range(self.rules.rounds):
            width = 0.7**k * spread

            def move(states: States, rng: np.random.Generator, width=width) -> States:
                return states + width * rng.standard_normal(states.shape)

            particles, _ = condensation(particles, move, log_likelihood, rng=rng)
        return particles.mean


def find_face(image: Image) -> Float[np.ndarray, " 4"]:
    """Return the square that marks the face that most windows agree on, px; of several the largest.

    The picture is looked at twice as large, so that faces from 12 px on are found.

    Raises
    ------
    TypeError
        If the image does not hold bytes.
    ValueError
        If it is not in colour, or no face is found.
    """
    grey = cv2.cvtColor(colour_picture("image", image), cv2.COLOR_RGB2GRAY)
    large = cv2.resize(grey, None, fx=2, fy=2, interpolation=cv2.INTER_CUBIC)
    for neighbours in (24, 16, 10, 6, 4):
        boxes = FaceDetector(neighbours=neighbours).find(large)
        if len(boxes):
            return boxes[0] / 2
    raise ValueError("image must show a face, found none; give the square that marks it")


def _skin(seen: Look, face: np.ndarray, bins: int) -> Float[np.ndarray, "4 bins"]:
    """Return the histograms of the middle of a face."""
    left, top, wide, high = face
    rows = slice(max(int(top + 0.35 * high), 0), max(int(top + 0.85 * high), 1))
    columns = slice(max(int(left + 0.25 * wide), 0), max(int(left + 0.75 * wide), 1))
    part = np.dstack([seen.image, seen.grey])[rows, columns].reshape(-1, 4).astype(int)
    if not len(part):
        raise ValueError(f"face must lie in the picture, got {face}")
    return np.stack([np.bincount(part[:, c] * bins // 256, minlength=bins) / len(part)
                     for c in range(4)])  # fmt: skip


def _aims(picture: Picture, states: States) -> States:
    """Return each state bent so that its hands come to where their colours are found."""
    first = picture.state.first
    joints = first.model.joints(picture.state.mean[None])[0]
    hands = first.model.pixels((joints[:, 2] + joints[:, 3]) / 2)
    goals, there = np.empty((2, 2)), np.zeros(2, dtype=bool)
    for arm in range(2):
        mine = np.flatnonzero(first.patches.limbs == _HANDS[arm])
        if mine.size:
            goals[arm], there[arm] = _nearby(picture.seen, first.reference[mine[0]], hands[arm])
    return _reached(first.model, states, goals, there, picture.noise)


def _nearby(
    seen: Look, reference: Float[np.ndarray, "4 bins"], at: Float[np.ndarray, " 2"]
) -> tuple[Float[np.ndarray, " 2"], bool]:
    """Return where colours are found near a place, by mean shift, and whether they are."""
    bins, half = reference.shape[-1], 14
    share = np.ones(seen.grey.shape, dtype=np.float32)
    for c in COLOUR:
        scaled = (reference[c] / max(float(reference[c].max()), 1e-12)).astype(np.float32)
        share *= scaled[seen.image[..., c].astype(int) * bins // 256]
    height, width = share.shape
    u, v = np.clip(np.rint(at - half), 0, [width - 1, height - 1]).astype(int)
    stop = (cv2.TERM_CRITERIA_EPS | cv2.TERM_CRITERIA_COUNT, 10, 1.0)
    _, (left, top, wide, high) = cv2.meanShift(share, (int(u), int(v), 2 * half, 2 * half), stop)
    inside = share[top : top + high, left : left + wide]
    there = bool(inside.size) and float(inside.sum()) > 30.0
    return np.array([left + wide / 2, top + high / 2]), there


def _reached(
    model: BodyModel,
    states: States,
    goals: Float[np.ndarray, "2 2"],
    there: Bool[np.ndarray, " 2"],
    noise: Float[np.ndarray, " 8"],
) -> States:
    """Return each state after one step of least squares that brings its hands to places.

    Angles move in proportion to their noise, and by three deviations at most.
    """
    step = 1e-4

    def hands(states: States) -> Float[np.ndarray, "m 2 2"]:
        joints = model.joints(states)
        return model.pixels((joints[:, :, 2] + joints[:, :, 3]) / 2)

    now = hands(states)
    found = states.copy()
    for arm in range(2):
        if not there[arm]:
            continue
        own = slice(4 * arm, 4 * arm + 4)
        jacobian = np.empty((len(states), 2, 4))
        for k in range(4):
            ahead = states.copy()
            ahead[:, 4 * arm + k] += step
            jacobian[:, :, k] = (hands(ahead)[:, arm] - now[:, arm]) / step
        scaled = jacobian * noise[own]
        gap = (goals[arm] - now[:, arm])[..., None]
        normal = scaled @ scaled.mT + 4.0 * np.eye(2)  # px²
        bent = (scaled.mT @ np.linalg.solve(normal, gap))[..., 0]
        found[:, own] += noise[own] * np.clip(bent, -3, 3)
    return found
