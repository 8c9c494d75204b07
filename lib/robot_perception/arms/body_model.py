r"""Two arms of truncated cones on a trunk, and what a camera sees of them.

The frame is the camera's: x to the right, y down, z ahead, m. The person faces the camera. A state
has four angles an arm, the arm on the left of the picture first:

.. math:: x = [\alpha_l, \beta_l, \gamma_l, \delta_l, \alpha_r, \beta_r, \gamma_r, \delta_r]^\top

α lifts the upper arm sideways in the plane of the body, β out of it towards the camera, γ turns it
about its axis, and δ bends the elbow; at zero the arms hang. With :math:`s = \mp 1` for the left
and the right of the picture, the upper arm points along u and the forearm along w:

.. math::
    u &= (s \sin\alpha \cos\beta,\; \cos\alpha \cos\beta,\; -\sin\beta)^\top \\
    e_1 &= (s \cos\alpha,\; -\sin\alpha,\; 0)^\top, \qquad e_2 = \partial u / \partial \beta \\
    w &= \cos\delta\, u + \sin\delta\, (\cos\gamma\, e_1 + \sin\gamma\, e_2)

The paper draws its angles in a figure (Fig. 12) that is known to us by its caption only; these are
ours, with the "shoulder fronto-planar rotation" that its text names as the first one.

References
----------
Menezes, Lerasle and Dias, "Visual Tracking Modalities for a Companion Robot", section V; the closed
form of the silhouette is that of a cone's generators whose tangent planes pass through the camera.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Annotated, Any, final, no_type_check

import numpy as np
from jaxtyping import Bool, Float, Int

from robot_perception import checks
from robot_perception.cameras import Pinhole
from robot_perception.fields import at_least, checked, copied
from robot_perception.kernels import kernel

__all__ = [
    "LIMBS",
    "REST",
    "BodyModel",
    "Contours",
    "Measures",
    "Patches",
    "Surface",
    "contours_textbook",
]

States = Float[np.ndarray, "m 8"]

LIMBS = (
    "left upper arm", "left forearm", "left hand", "right upper arm", "right forearm", "right hand",
)  # fmt: skip
"""Limbs, in the order in which they lie in the picture."""
REST = np.array([0.24, 0.05, 1.2, 0.25] * 2)
"""Arms that hang beside the body, elbows a little bent forwards, rad; ours."""
_SLACK = 0.01
"""A point is hidden by what lies nearer by more than that, m: limbs touch at their joints."""


def _size(name: str, value: Any) -> float:
    """Return a size of a body, from a millimetre to ten metres."""
    found = checks.number(name, value)
    _check_sizes(name, np.array([found]))
    return found


def _sizes(count: int) -> Callable[[str, Any], tuple[float, ...]]:
    """Return the check of so many sizes of a body."""

    def check(name: str, value: Any) -> tuple[float, ...]:
        found = checks.vector(name, value, count)
        _check_sizes(name, found)
        return tuple(found.tolist())

    return check


def _check_sizes(name: str, found: np.ndarray) -> None:
    if not (found.min() >= 1e-3 and found.max() <= 10):
        raise ValueError(f"{name} must be positive, from 0.001 to 10 m, got {found.tolist()}")


def _counts(size: int) -> Callable[[str, Any], tuple[int, ...]]:
    """Return the check of so many numbers of points, up to 1000 each."""

    def check(name: str, value: Any) -> tuple[int, ...]:
        found = checks.integers(name, value, (size,), 1)
        if found.max() > 1000:
            raise ValueError(f"{name} must be at most 1000, got {found.max()}")
        return tuple(found.tolist())

    return check


def _known_limbs(name: str, value: np.ndarray) -> np.ndarray:
    """Return indices of `LIMBS`, one at least."""
    if not value.size or value.max() >= len(LIMBS):
        raise ValueError(f"{name} must be one at least, each below 6, got {value.tolist()}")
    return value


def _rising(name: str, value: np.ndarray) -> np.ndarray:
    """Return pairs whose second number is the larger."""
    if not (value[:, 1] > value[:, 0]).all():
        raise ValueError(f"{name} must rise, got {value.tolist()}")
    return value


def _rising_shares(name: str, value: np.ndarray) -> np.ndarray:
    """Return pairs of shares whose second is the larger."""
    if not (value[:, 1] > value[:, 0]).all() or value.min() < 0 or value.max() > 1:
        raise ValueError(f"{name} must rise within 0 and 1, got {checks.shown(value.tolist())}")
    return value


def _wide(name: str, value: np.ndarray) -> np.ndarray:
    """Return middles and half widths, these positive."""
    if not value[:, 1].min() > 0:
        raise ValueError(f"{name} must have a positive half width, got {value[:, 1].min():g}")
    return value


@final
@dataclass(frozen=True, slots=True)
class Measures:
    """Sizes of a body, each from a millimetre to ten metres, m; all ours.

    Parameters
    ----------
    lengths
        Of upper arm, forearm and hand.
    radii
        At shoulder, elbow, wrist and fingertips.
    apart
        From one shoulder to the other.
    drop
        From the middle of the face down to the shoulders.
    face
        Side of the square by which a detector marks the face.
    trunk
        Half width and half depth of the trunk, an elliptic cylinder.
    head
        Radius of the head.
    """

    lengths: Annotated[tuple[float, float, float], _sizes(3)] = (0.29, 0.25, 0.13)
    radii: Annotated[tuple[float, float, float, float], _sizes(4)] = (0.052, 0.045, 0.034, 0.026)
    apart: Annotated[float, _size] = 0.37
    drop: Annotated[float, _size] = 0.25
    face: Annotated[float, _size] = 0.177
    trunk: Annotated[tuple[float, float], _sizes(2)] = (0.17, 0.11)
    head: Annotated[float, _size] = 0.10
    __post_init__ = checked


@final
@dataclass(frozen=True, eq=False, slots=True)
class Patches:
    """Parts of the limbs' surfaces.

    Parameters
    ----------
    limbs : (p,)
        On which of `LIMBS` each lies.
    along : (p, 2)
        From where to where along the limb, as shares of its length that rise.
    around : (p, 2)
        Middle and half width around it, rad; 0 is the side to which the elbow bends.
    """

    limbs: Annotated[Int[np.ndarray, " p"], at_least(0), _known_limbs]
    along: Annotated[Float[np.ndarray, "p 2"], _rising_shares]
    around: Annotated[Float[np.ndarray, "p 2"], _wide]
    __post_init__ = checked

    def __len__(self) -> int:
        return len(self.limbs)


@final
@dataclass(frozen=True, eq=False, slots=True)
class Contours:
    """Points of the silhouettes of many states.

    Parameters
    ----------
    points : (m, n, 2)
        Column and row, px; n is the same for all states.
    visible : (m, n)
        Whether no other limb and not the trunk lies before it. A limb that points at the camera has
        no silhouette along its sides: none of its points is visible.

    Raises
    ------
    TypeError
        If an array is of another type.
    ValueError
        If the shapes disagree.
    """

    points: Float[np.ndarray, "m n 2"]
    visible: Bool[np.ndarray, "m n"]

    def __post_init__(self) -> None:
        shape = checks.typed("points", self.points, np.floating, ("m", "n", 2)).shape
        checks.typed("visible", self.visible, np.bool_, shape[:2], f"points {shape}")


@final
@dataclass(frozen=True, eq=False, slots=True)
class Surface:
    """Points of the patches of many states.

    Parameters
    ----------
    points : (m, p, g, 2)
        Column and row, px.
    visible : (m, p, g)
        Whether the surface there faces the camera and nothing lies before it.

    Raises
    ------
    TypeError
        If an array is of another type.
    ValueError
        If the shapes disagree, or a patch has no point.
    """

    points: Float[np.ndarray, "m p g 2"]
    visible: Bool[np.ndarray, "m p g"]

    def __post_init__(self) -> None:
        shape = checks.typed("points", self.points, np.floating, ("m", "p", "g", 2)).shape
        checks.typed("visible", self.visible, np.bool_, shape[:3], f"points {shape}")
        if not shape[2]:
            raise ValueError(f"points must be one of each patch at least, got {shape}")


@final
@dataclass(frozen=True, eq=False, slots=True)
class BodyModel:
    """Two arms before a camera.

    Parameters
    ----------
    camera
        Without distortion.
    middle : (3,)
        The place between the shoulders in the camera's frame, m.
    measures
        Of the body.
    limits : (4, 2)
        Least and most of α, β, γ and δ, rad; ours.
    counts
        Points along each side of upper arm, forearm and hand.
    grid
        Points along and around a patch.

    Raises
    ------
    ValueError
        If the body is not before the camera or the camera's lens distorts.
    """

    camera: Pinhole
    middle: Annotated[Float[np.ndarray, " 3"], copied]
    measures: Measures = field(default_factory=Measures)
    limits: Annotated[Float[np.ndarray, "4 2"], _rising] = field(
        default_factory=lambda: np.array([[-0.2, 2.6], [-0.4, 1.5], [-0.4, 3.0], [0.0, 2.5]])
    )
    counts: Annotated[tuple[int, int, int], _counts(3)] = (8, 7, 4)
    grid: Annotated[tuple[int, int], _counts(2)] = (6, 10)

    def __post_init__(self) -> None:
        checked(self)
        if self.camera.distortion:
            raise ValueError("camera must have no distortion; undistort the pictures first")
        away = checks.moderate("middle", self.middle, 1e6)[2]
        if not away > sum(self.measures.lengths) + self.measures.radii[0]:
            raise ValueError(f"middle must be farther away than an arm is long, got {away:g}")

    @classmethod
    def from_face(
        cls, face: Float[np.ndarray, " 4"], camera: Pinhole, measures: Measures | None = None
    ) -> "BodyModel":
        """Return the body below a face: its side tells how far away the person is.

        Parameters
        ----------
        face : (4,)
            Left, top, width and height of the square that marks it, px.
        camera
            That saw it.
        measures
            Of the body.

        Raises
        ------
        ValueError
            If the face has no size, or is so large that the arms would reach the camera.
        """
        measures = Measures() if measures is None else measures
        checks.instance("measures", measures, Measures)
        checks.instance("camera", camera, Pinhole)
        left, top, wide, high = checks.vector("face", face, 4)
        if not (wide > 0 and high > 0):
            raise ValueError(f"face must have a width and a height, got {wide:g} and {high:g}")
        away = camera.focal[0] * measures.face / ((wide + high) / 2)
        u, v = left + wide / 2 - camera.centre[0], top + high / 2 - camera.centre[1]
        middle = np.array([u / camera.focal[0] * away, v / camera.focal[1] * away, away])
        return cls(camera, middle + np.array([0, measures.drop, 0]), measures)

    @property
    def points(self) -> int:
        """Number of points of a silhouette, hidden ones included."""
        return 4 * sum(self.counts)

    def joints(self, states: States) -> Float[np.ndarray, "m 2 4 3"]:
        """Return shoulder, elbow, wrist and fingertips of both arms, m."""
        states = _states(states)
        ends = np.empty((len(states), 2, 4, 3))
        _skeletons(states, *self._sizes(), ends, np.empty((len(states), 2, 2, 3)))
        return ends

    def pixels(self, points: Float[np.ndarray, "... 3"]) -> Float[np.ndarray, "... 2"]:
        """Return where points lie in the picture, px.

        Raises
        ------
        ValueError
            If a point is not before the camera.
        """
        points = checks.array("points", points, (..., 3))
        checks.moderate("points", points, 1e6)
        if points.size and not points[..., 2].min() > 0:
            raise ValueError(f"points must be before the camera, got z of {points[..., 2].min():g}")
        return points[..., :2] / points[..., 2:] * self.camera.focal + self.camera.centre

    def possible(self, states: States) -> Bool[np.ndarray, " m"]:
        """Tell which states are within the limits of the joints."""
        return self.possible_arms(states).all(axis=1)

    def possible_arms(self, states: States) -> Bool[np.ndarray, "m 2"]:
        """Tell of each arm whether it is within the limits of its joints."""
        states = _states(states).reshape(-1, 2, 4)
        low, high = self.limits.T
        return ((states >= low) & (states <= high)).all(axis=2)

    def collides(self, states: States) -> Bool[np.ndarray, " m"]:
        r"""Tell in which states a limb goes through trunk, head or the other arm.

        Limbs collide where their axes come nearer than the sum of their radii there; forearm and
        hand collide with the trunk where their axes enter it, and with the head where they come
        nearer than its radius and theirs. The upper arm begins in the trunk and is not tested with
        it. All ours: the paper speaks of a collision detection mechanism and no more.
        """
        ends = self.joints(states)
        measures = self.measures
        found = np.empty(len(ends), dtype=bool)
        head = self.middle - [0, measures.drop, 0]
        _collide(
            ends, np.array(measures.radii), self.middle, np.array(measures.trunk), head,
            measures.head, found,
        )  # fmt: skip
        return found

    def contours(self, states: States) -> Contours:
        """Return the silhouettes of the limbs, hidden parts told.

        Points lie evenly along both sides of each limb, in the order of `LIMBS`.
        """
        states = _states(states)
        found = np.empty((len(states), self.points, 2))
        visible = np.empty((len(states), self.points), dtype=bool)
        _project(states, *self._sizes(), *self._shape(), *self._lens(), np.array(self.counts),
                 found, visible)  # fmt: skip
        return Contours(found, visible)

    def surface(self, states: States, patches: Patches) -> Surface:
        """Return the points of patches, and which of them are seen."""
        states = _states(states)
        checks.instance("patches", patches, Patches)
        size = self.grid[0] * self.grid[1]
        found = np.empty((len(states), len(patches), size, 2))
        visible = np.empty((len(states), len(patches), size), dtype=bool)
        _cover(states, *self._sizes(), *self._shape(), *self._lens(), patches.limbs, patches.along,
               patches.around, np.array(self.grid), found, visible)  # fmt: skip
        return Surface(found, visible)

    def place(
        self,
        state: Float[np.ndarray, " 8"],
        spans: Float[np.ndarray, "k 2"] = ((0.25, 0.85), (0.15, 0.8), (0.2, 0.9)),
    ) -> Patches:
        """Return one patch a limb, right round it, from the side that the camera sees in a state.

        Half of such a patch is seen from anywhere, so that a limb that turns about its axis does
        not lose its patch; a narrower one tells how far the limb has turned.

        Parameters
        ----------
        state : (8,)
            Of the body.
        spans : (3, 2)
            Along upper arm, forearm and hand; by default the paper's three patches an arm, at
            places of ours.
        """
        spans = _rising_shares("spans", checks.array("spans", spans, (3, 2)))
        state = _states(checks.vector("state", state, 8)[None])
        ends, sides = np.empty((1, 2, 4, 3)), np.empty((1, 2, 2, 3))
        _skeletons(state, *self._sizes(), ends, sides)
        around = np.empty((len(LIMBS), 2))
        for limb in range(len(LIMBS)):
            arm, part = divmod(limb, 3)
            start, end = ends[0, arm, part], ends[0, arm, part + 1]
            along = (end - start) / np.linalg.norm(end - start)
            first = sides[0, arm, min(part, 1)]
            to_camera = -(start + end) / 2
            around[limb] = (
                math.atan2(to_camera @ np.cross(along, first), to_camera @ first),
                math.pi,
            )
        return Patches(np.arange(len(LIMBS)), np.tile(spans, (2, 1)), around)

    def _sizes(self) -> tuple:
        measures = self.measures
        return self.middle, np.array(measures.lengths), measures.apart

    def _shape(self) -> tuple:
        return np.array(self.measures.radii), np.array(self.measures.trunk)

    def _lens(self) -> tuple:
        return np.array(self.camera.focal), np.array(self.camera.centre)


def contours_textbook(model: BodyModel, states: States) -> Contours:
    r"""Return the same as `BodyModel.contours`, written as the equations are.

    On a truncated cone from :math:`c_0` along a, with radius :math:`r(t) = r_0 - k t`, the normal
    is the same all along a generator, :math:`n(\varphi) \propto d(\varphi) + k a` with
    :math:`d = \cos\varphi\, e_1 + \sin\varphi\, e_2`. The silhouette is where it is square to the
    ray from the camera, the origin:

    .. math:: n \cdot (c_0 + r_0 d) = 0 \iff
        (e_1 \cdot c_0) \cos\varphi + (e_2 \cdot c_0) \sin\varphi + k\, a \cdot c_0 + r_0 = 0

    which has two solutions, or none for a limb that points at the camera.
    """
    measures = checks.instance("model", model, BodyModel).measures
    every, seen = [], []
    for ends in model.joints(states):
        limbs = [
            (arm[part], arm[part + 1], measures.radii[part], measures.radii[part + 1])
            for arm in ends
            for part in range(3)
        ]
        points, visible = [], []
        for own, limb in enumerate(limbs):
            others = [limb for k, limb in enumerate(limbs) if k != own]
            count = model.counts[own % 3]
            for line in _silhouette(*limb, count):
                points.append(model.pixels(line))
                visible.append([
                    np.isfinite(p).all()
                    and not any(_before(p, *other) for other in others)
                    and not _before_trunk(p, model)
                    for p in line
                ])  # fmt: skip
        every.append(np.concatenate(points))
        seen.append(np.concatenate(visible))
    size = model.points
    return Contours(np.array(every).reshape(-1, size, 2), np.array(seen, bool).reshape(-1, size))


def _silhouette(c0: np.ndarray, c1: np.ndarray, r0: float, r1: float, count: int) -> list:
    """Return points along both sides of a cone (count, 3); not a number where there is none."""
    length = np.linalg.norm(c1 - c0)
    a = (c1 - c0) / length
    helper = np.eye(3)[np.abs(a).argmin()]
    e1 = np.cross(a, helper) / np.linalg.norm(np.cross(a, helper))
    e2 = np.cross(a, e1)
    k = (r0 - r1) / length
    x, y, z = e1 @ c0, e2 @ c0, k * (a @ c0) + r0
    size = np.hypot(x, y)
    t = ((np.arange(count) + 0.5) / count * length)[:, None]
    lines = []
    for sign in (-1, 1):
        with np.errstate(invalid="ignore"):
            angle = np.arctan2(y, x) + sign * np.arccos(-z / size)
        d = np.cos(angle) * e1 + np.sin(angle) * e2
        lines.append(c0 + t * a + (r0 - k * t) * d)
    return lines


def _before(p: np.ndarray, c0: np.ndarray, c1: np.ndarray, r0: float, r1: float) -> bool:
    """Tell whether a cone lies between the camera and a point."""
    size = float(np.linalg.norm(p))
    return _entry(p, c0, c1, r0, r1) * size < size - _SLACK


def _before_trunk(p: np.ndarray, model: BodyModel) -> bool:
    """Tell whether the trunk does; in a frame that makes it round."""
    wide, deep = model.measures.trunk
    stretch = np.array([1.0, 1.0, wide / deep])
    top = model.middle * stretch
    end = top + np.array([0, _TRUNK, 0])
    share = _entry(p * stretch, top, end, wide, wide)
    size = float(np.linalg.norm(p))
    return share * size < size - _SLACK


def _entry(p: np.ndarray, c0: np.ndarray, c1: np.ndarray, r0: float, r1: float) -> float:
    """Return which share of the ray to a point lies before it enters a solid cone; inf if never."""
    cone = np.empty(11)
    _prepare(c0, c1, r0, r1, 1.0, cone)
    return float(_enters_at(p[0], p[1], p[2], cone))


_TRUNK = 0.8
"""Length of the trunk, which leaves the picture below, m."""


def _states(states: Any) -> np.ndarray:
    states = checks.array("states", states, ("m", 8))
    checks.moderate("states", states, 1e3)
    return states


@no_type_check
@kernel()
def _skeletons(states, middle, lengths, apart, ends, sides):  # pragma: no cover - compiled
    """Fill in the joints, and the side of upper arm and forearm to which the elbow bends."""
    for i in range(len(states)):
        for arm in range(2):
            s = 2.0 * arm - 1.0
            alpha, beta, gamma, delta = states[i, 4 * arm : 4 * arm + 4]
            sa, ca, sb, cb = np.sin(alpha), np.cos(alpha), np.sin(beta), np.cos(beta)
            sg, cg, sd, cd = np.sin(gamma), np.cos(gamma), np.sin(delta), np.cos(delta)
            ends[i, arm, 0] = middle
            ends[i, arm, 0, 0] += s * apart / 2
            u = (s * sa * cb, ca * cb, -sb)
            e1 = (s * ca, -sa, 0.0)
            e2 = (-s * sa * sb, -ca * sb, -cb)
            for c in range(3):
                turned = cg * e1[c] + sg * e2[c]
                w = cd * u[c] + sd * turned
                sides[i, arm, 0, c] = turned
                sides[i, arm, 1, c] = cd * turned - sd * u[c]
                ends[i, arm, 1, c] = ends[i, arm, 0, c] + lengths[0] * u[c]
                ends[i, arm, 2, c] = ends[i, arm, 1, c] + lengths[1] * w
                ends[i, arm, 3, c] = ends[i, arm, 2, c] + lengths[2] * w


@no_type_check
@kernel()
def _prepare(c0, c1, r0, r1, stretch, cone):  # pragma: no cover - compiled
    """Fill in what `_enters_at` asks of a cone, in a frame whose z is stretched."""
    length = 0.0
    for c in range(3):
        wide = stretch if c == 2 else 1.0
        cone[3 + c] = wide * c0[c]
        cone[c] = wide * (c1[c] - c0[c])
        length += cone[c] ** 2
    length = np.sqrt(length)
    along, size = 0.0, 0.0
    for c in range(3):
        cone[c] /= length
        along += cone[c] * cone[3 + c]
        size += cone[3 + c] ** 2
    k = (r0 - r1) / length
    cone[6], cone[7], cone[8] = along, length, k
    cone[9] = r0 + k * along
    cone[10] = size - along**2 - cone[9] ** 2


@no_type_check
@kernel()
def _enters_at(x, y, z, cone):  # pragma: no cover - compiled
    """Return which share of the ray to a point lies before it enters a solid cone; inf if never.

    At t p the ray is within the cone where |t p - c0|² - h² <= (r0 - k h)², with h the way along
    the axis, and within its length where 0 <= h <= L.
    """
    pa = x * cone[0] + y * cone[1] + z * cone[2]
    pc = x * cone[3] + y * cone[4] + z * cone[5]
    ca, k = cone[6], cone[8]
    qa = x * x + y * y + z * z - pa * pa * (1 + k * k)
    qb = -2 * (pc - pa * ca) + 2 * k * pa * cone[9]
    qc = cone[10]
    disc = qb * qb - 4 * qa * qc
    if qa > 0 and disc < 0:
        return np.inf
    low, high = -np.inf, np.inf
    if abs(pa) > 1e-12:  # between both ends
        low, high = ca / pa, (ca + cone[7]) / pa
        if low > high:
            low, high = high, low
    elif ca > 0 or ca < -cone[7]:
        return np.inf
    if abs(qa) < 1e-14:
        if qb == 0:
            return low if qc <= 0 else np.inf
        edge = -qc / qb
        if qb > 0:
            high = min(high, edge)
        else:
            low = max(low, edge)
    elif qa > 0:
        root = np.sqrt(disc)
        low, high = max(low, (-qb - root) / (2 * qa)), min(high, (-qb + root) / (2 * qa))
    elif disc >= 0:  # the ray is steeper than the cone: inside before and after
        root = np.sqrt(disc)
        first, second = (-qb + root) / (2 * qa), (-qb - root) / (2 * qa)
        if low > first and low < second:
            low = second
        if low <= first and first < high:
            high = first
    low = max(low, 0.0)
    return low if low <= high else np.inf


@no_type_check
@kernel()
def _boxes(ends, radii, middle, trunk, focal, centre, boxes, cones):  # pragma: no cover - compiled
    """Fill in the box of each limb and of the trunk in the picture, wide enough, and its cone."""
    foot = middle.copy()
    foot[1] += _TRUNK
    _prepare(middle, foot, trunk[0], trunk[0], trunk[0] / trunk[1], cones[6])
    near, far = middle[2] - trunk[1], middle[2] + trunk[1]
    for c in range(2):
        x = middle[c] - 1.2 * trunk[0] * (1 - c)
        boxes[6, c] = focal[c] * min(x / near, x / far) + centre[c]
        x = middle[c] + 1.2 * trunk[0]
        boxes[6, 2 + c] = focal[c] * max(x / near, x / far) + centre[c] if c == 0 else np.inf
    for limb in range(6):
        arm, part = limb // 3, limb % 3
        _prepare(
            ends[arm, part], ends[arm, part + 1], radii[part], radii[part + 1], 1.0, cones[limb]
        )
        boxes[limb, 0], boxes[limb, 1] = np.inf, np.inf
        boxes[limb, 2], boxes[limb, 3] = -np.inf, -np.inf
        for e in range(2):
            x, y, z = ends[arm, part + e]
            wide = 1.2 * radii[part + e] / (z - radii[part + e])
            for c in range(2):
                at = (x if c == 0 else y) / z
                boxes[limb, c] = min(boxes[limb, c], focal[c] * (at - wide) + centre[c])
                boxes[limb, 2 + c] = max(boxes[limb, 2 + c], focal[c] * (at + wide) + centre[c])


@no_type_check
@kernel()
def _seen(p, own, u, v, middle, trunk, boxes, cones):  # pragma: no cover - compiled
    """Tell whether neither a limb but the own one nor the trunk lies before a point."""
    most = 1.0 - _SLACK / np.sqrt(p[0] * p[0] + p[1] * p[1] + p[2] * p[2])
    for limb in range(7):
        if limb == own or not (
            boxes[limb, 0] <= u <= boxes[limb, 2] and boxes[limb, 1] <= v <= boxes[limb, 3]
        ):
            continue
        stretch = 1.0
        if limb == 6:
            if p[2] < middle[2] - trunk[1]:  # nearer than the trunk reaches
                continue
            stretch = trunk[0] / trunk[1]
        if _enters_at(p[0], p[1], stretch * p[2], cones[limb]) < most:
            return False
    return True


@no_type_check
@kernel()
def _project(
    states, middle, lengths, apart, radii, trunk, focal, centre, counts, found, visible
):  # pragma: no cover - compiled
    m = len(states)
    ends, sides = np.empty((m, 2, 4, 3)), np.empty((m, 2, 2, 3))
    _skeletons(states, middle, lengths, apart, ends, sides)
    boxes, p, cones = np.empty((7, 4)), np.empty(3), np.empty((7, 11))
    a, e1, e2 = np.empty(3), np.empty(3), np.empty(3)
    for i in range(m):
        _boxes(ends[i], radii, middle, trunk, focal, centre, boxes, cones)
        at = 0
        for limb in range(6):
            arm, part = limb // 3, limb % 3
            c0, c1 = ends[i, arm, part], ends[i, arm, part + 1]
            r0, r1, length = radii[part], radii[part + 1], lengths[part]
            for c in range(3):
                a[c] = (c1[c] - c0[c]) / length
            _across(a, e1, e2)
            k = (r0 - r1) / length
            x, y, z = 0.0, 0.0, 0.0
            for c in range(3):
                x += e1[c] * c0[c]
                y += e2[c] * c0[c]
                z += a[c] * c0[c]
            z = k * z + r0
            size = np.sqrt(x * x + y * y)
            there = abs(z) <= size
            middle_angle = np.arctan2(y, x)
            half = np.arccos(-z / size) if there else 0.0
            for sign in range(2):
                angle = middle_angle + (2 * sign - 1) * half
                cos, sin = np.cos(angle), np.sin(angle)
                for j in range(counts[part]):
                    t = (j + 0.5) / counts[part] * length
                    r = r0 - k * t
                    for c in range(3):
                        p[c] = c0[c] + t * a[c] + r * (cos * e1[c] + sin * e2[c])
                    u = focal[0] * p[0] / p[2] + centre[0]
                    v = focal[1] * p[1] / p[2] + centre[1]
                    found[i, at, 0], found[i, at, 1] = u, v
                    visible[i, at] = there and _seen(p, limb, u, v, middle, trunk, boxes, cones)
                    at += 1


@no_type_check
@kernel()
def _across(a, e1, e2):  # pragma: no cover - compiled
    """Fill in two directions square to one and to each other."""
    least = 0
    for c in range(1, 3):
        if abs(a[c]) < abs(a[least]):
            least = c
    b = (least + 1) % 3, (least + 2) % 3
    size = np.sqrt(a[b[0]] ** 2 + a[b[1]] ** 2)
    # a × the unit vector along the least component
    e1[least] = 0.0
    e1[b[0]], e1[b[1]] = a[b[1]] / size, -a[b[0]] / size
    e2[0] = a[1] * e1[2] - a[2] * e1[1]
    e2[1] = a[2] * e1[0] - a[0] * e1[2]
    e2[2] = a[0] * e1[1] - a[1] * e1[0]


@no_type_check
@kernel()
def _cover(
    states, middle, lengths, apart, radii, trunk, focal, centre, limbs, along, around, grid, found,
    visible,
):  # pragma: no cover - compiled  # fmt: skip
    m = len(states)
    ends, sides = np.empty((m, 2, 4, 3)), np.empty((m, 2, 2, 3))
    _skeletons(states, middle, lengths, apart, ends, sides)
    boxes, p, cones = np.empty((7, 4)), np.empty(3), np.empty((7, 11))
    a, b, out = np.empty(3), np.empty(3), np.empty(3)
    turns = np.empty((len(limbs), grid[1], 2))
    for q in range(len(limbs)):
        for h in range(grid[1]):
            angle = around[q, 0] + around[q, 1] * (2 * (h + 0.5) / grid[1] - 1)
            turns[q, h, 0], turns[q, h, 1] = np.cos(angle), np.sin(angle)
    for i in range(m):
        _boxes(ends[i], radii, middle, trunk, focal, centre, boxes, cones)
        for q in range(len(limbs)):
            arm, part = limbs[q] // 3, limbs[q] % 3
            c0, c1 = ends[i, arm, part], ends[i, arm, part + 1]
            first = sides[i, arm, min(part, 1)]
            r0, r1, length = radii[part], radii[part + 1], lengths[part]
            k = (r0 - r1) / length
            for c in range(3):
                a[c] = (c1[c] - c0[c]) / length
            b[0] = a[1] * first[2] - a[2] * first[1]
            b[1] = a[2] * first[0] - a[0] * first[2]
            b[2] = a[0] * first[1] - a[1] * first[0]
            for h in range(grid[1]):
                cos, sin = turns[q, h, 0], turns[q, h, 1]
                facing = 0.0  # the normal is the same all along a generator
                for c in range(3):
                    out[c] = cos * first[c] + sin * b[c]
                    facing += (out[c] + k * a[c]) * (c0[c] + r0 * out[c])
                for g in range(grid[0]):
                    share = along[q, 0] + (along[q, 1] - along[q, 0]) * (g + 0.5) / grid[0]
                    t = share * length
                    r = r0 - k * t
                    for c in range(3):
                        p[c] = c0[c] + t * a[c] + r * out[c]
                    u = focal[0] * p[0] / p[2] + centre[0]
                    v = focal[1] * p[1] / p[2] + centre[1]
                    at = g * grid[1] + h
                    found[i, q, at, 0], found[i, q, at, 1] = u, v
                    visible[i, q, at] = facing < 0 and _seen(
                        p, limbs[q], u, v, middle, trunk, boxes, cones
                    )


@no_type_check
@kernel()
def _collide(ends, radii, middle, trunk, head, head_radius, found):  # pragma: no cover - compiled
    for i in range(len(ends)):
        hit = False
        for left in range(3):
            for right in range(3):
                a0, a1 = ends[i, 0, left], ends[i, 0, left + 1]
                b0, b1 = ends[i, 1, right], ends[i, 1, right + 1]
                s, t, gap = _nearest(a0, a1, b0, b1)
                r = radii[left] + s * (radii[left + 1] - radii[left])
                r += radii[right] + t * (radii[right + 1] - radii[right])
                hit |= gap < r
        for arm in range(2):
            for part in range(1, 3):
                a0, a1 = ends[i, arm, part], ends[i, arm, part + 1]
                hit |= _enters(a0, a1, middle, trunk)
                s, _, gap = _nearest(a0, a1, head, head)
                hit |= gap < head_radius + radii[part] + s * (radii[part + 1] - radii[part])
        found[i] = hit


@no_type_check
@kernel()
def _enters(a0, a1, middle, trunk):  # pragma: no cover - compiled
    """Tell whether a segment enters the trunk."""
    x0, x1 = (a0[0] - middle[0]) / trunk[0], (a1[0] - middle[0]) / trunk[0]
    z0, z1 = (a0[2] - middle[2]) / trunk[1], (a1[2] - middle[2]) / trunk[1]
    low, high = 0.0, 1.0  # the part between shoulders and below
    y0, y1 = a0[1] - middle[1], a1[1] - middle[1]
    if y0 < 0 and y1 < 0:
        return False
    if y0 < 0:
        low = -y0 / (y1 - y0)
    elif y1 < 0:
        high = y0 / (y0 - y1)
    dx, dz = x1 - x0, z1 - z0
    size = dx * dx + dz * dz
    t = -(x0 * dx + z0 * dz) / size if size > 0 else 0.0
    t = min(max(t, low), high)
    return (x0 + t * dx) ** 2 + (z0 + t * dz) ** 2 < 1


@no_type_check
@kernel()
def _nearest(a0, a1, b0, b1):  # pragma: no cover - compiled
    """Return where along two segments they are nearest to each other, and how near that is."""
    aa, bb, ab, ac, bc = 0.0, 0.0, 0.0, 0.0, 0.0
    for c in range(3):
        u, v, w = a1[c] - a0[c], b1[c] - b0[c], a0[c] - b0[c]
        aa += u * u
        bb += v * v
        ab += u * v
        ac += u * w
        bc += v * w
    if bb <= 1e-18:
        s, t = min(max(-ac / aa, 0.0), 1.0), 0.0
    else:
        det = aa * bb - ab * ab
        s = min(max((ab * bc - ac * bb) / det, 0.0), 1.0) if det > 1e-12 * aa * bb else 0.0
        t = (ab * s + bc) / bb
        if t < 0.0:
            t, s = 0.0, min(max(-ac / aa, 0.0), 1.0)
        elif t > 1.0:
            t, s = 1.0, min(max((ab - ac) / aa, 0.0), 1.0)
    gap = 0.0
    for c in range(3):
        d = a0[c] + s * (a1[c] - a0[c]) - b0[c] - t * (b1[c] - b0[c])
        gap += d * d
    return s, t, np.sqrt(gap)
