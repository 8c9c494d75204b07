"""Upper bodies of cloth and skin: meshes that are bent, folded, lit, and seen with a depth buffer.

The camera's frame has x to the right, y down and z ahead, m. A body faces the camera. Its arms are
told by eight angles (rad), four an arm, the left one in the picture first: away from the body in
its plane; out of it towards the camera; about the upper arm's axis; and the bend of the elbow. At
zero all limbs hang. No cone is any part of it: limbs are surfaces with muscles, folds and joints.
"""

import math
from dataclasses import dataclass, field

import cv2
import numpy as np
from scipy.spatial.transform import Rotation

from data_synth._checks import array, generator, instance, number, reals, whole
from data_synth._kernels import kernel
from data_synth.coloured.canvas import texture
from data_synth.coloured.filming import linear, one_of
from data_synth.companion.canvas import rows_and_columns, tint
from data_synth.companion.faces import FACE_BOX, SPAN, FaceIdentity, FaceView, face_sprite, square

__all__ = ["SIDES", "Build", "Outfit", "Person", "Stage", "make_outfit", "make_person"]

SIDES = (-1, 1)
"""The arm on the left of the picture, and the one on the right."""
PATTERNS = ("plain", "stripes", "checks", "print")
_TEXELS = 64
_FINE = 2
_AROUND = 24


@dataclass(frozen=True, slots=True)
class Build:
    """Measures of a body, m.

    Parameters
    ----------
    upper, fore, hand
        Lengths of upper arm, forearm and hand.
    apart
        From one shoulder to the other.
    drop
        From the middle of the face down to the shoulders.
    thick
        Radius of the upper arm, to which all others are in proportion.
    """

    upper: float = 0.29
    fore: float = 0.25
    hand: float = 0.17
    apart: float = 0.37
    drop: float = 0.25
    thick: float = 0.052

    def __post_init__(self) -> None:
        for name in ("upper", "fore", "hand", "apart", "drop", "thick"):
            number(name, getattr(self, name), 0.01, 1.0)


@dataclass(frozen=True, eq=False, slots=True)
class Outfit:
    """Clothes of a body.

    Parameters
    ----------
    shirt, other
        Light that its cloth gives back, red, green and blue, and its second colour.
    pattern
        ``"plain"``, ``"stripes"``, ``"checks"`` or ``"print"``.
    short
        Whether the sleeves end at the elbow.
    loose
        Height of the folds as a share of a limb's radius.
    seed
        Of the folds and the print.
    """

    shirt: tuple[float, float, float]
    other: tuple[float, float, float]
    pattern: str = "plain"
    short: bool = False
    loose: float = 0.08
    seed: int = 0

    def __post_init__(self) -> None:
        for name in ("shirt", "other"):
            object.__setattr__(self, name, tint(name, getattr(self, name)))
        one_of("pattern", self.pattern, PATTERNS)
        instance("short", self.short, bool)
        number("loose", self.loose, 0.0, 0.4)
        whole("seed", self.seed, 0, 2**32 - 1)


@dataclass(frozen=True, eq=False, slots=True)
class Person:
    """Somebody.

    Parameters
    ----------
    build
        Measures.
    outfit
        Clothes.
    identity
        Face and skin.
    """

    build: Build
    outfit: Outfit
    identity: FaceIdentity

    def __post_init__(self) -> None:
        instance("build", self.build, Build)
        instance("outfit", self.outfit, Outfit)
        instance("identity", self.identity, FaceIdentity)

    def joints(self, angles: np.ndarray, middle: np.ndarray) -> np.ndarray:
        """Return shoulder, elbow, wrist and fingertips of both arms (2, 4, 3), m.

        Parameters
        ----------
        angles : (8,)
            Of both arms.
        middle : (3,)
            Between the shoulders.
        """
        angles, middle = array("angles", angles, (8,), 10.0), array("middle", middle, (3,))
        found = np.empty((2, 4, 3))
        for k, side in enumerate(SIDES):
            upper, fore = _turns(side, angles[4 * k : 4 * k + 4])
            shoulder = middle + np.array([side * self.build.apart / 2, 0, 0])
            elbow = shoulder + self.build.upper * upper.apply([0, 1, 0])
            along = fore.apply([0, 1, 0])
            wrist = elbow + self.build.fore * along
            found[k] = shoulder, elbow, wrist, wrist + self.build.hand * along
        return found


@dataclass(frozen=True, eq=False, slots=True)
class Stage:
    """Camera and lamp.

    Parameters
    ----------
    focal
        Focal length, px.
    size
        Rows and columns of the picture.
    away
        From the camera to the shoulders, m.
    high
        Of the middle between the shoulders above the middle of the picture, m.
    azimuth, elevation
        Where the lamp stands, rad.
    ambient
        Share of the light that comes from all sides.
    aside
        Of the middle between the shoulders to the right of the middle of the picture, m.
    turn
        Of head and trunk about the vertical through it, rad: positive brings the shoulder on the
        right of the picture nearer.
    """

    focal: float = 320.0
    size: tuple[int, int] = (240, 320)
    away: float = 1.9
    high: float = 0.12
    azimuth: float = 0.4
    elevation: float = 0.6
    ambient: float = 0.5
    aside: float = 0.0
    turn: float = 0.0

    def __post_init__(self) -> None:
        number("focal", self.focal, 10.0, 1e5)
        object.__setattr__(self, "size", rows_and_columns("size", self.size, 16, 2048))
        number("away", self.away, 1.0, 20.0)
        for name in ("high", "azimuth", "elevation", "aside"):
            number(name, getattr(self, name), -4.0, 4.0)
        number("turn", self.turn, -1.2, 1.2)
        number("ambient", self.ambient, 0.0, 1.0)

    @property
    def middle(self) -> np.ndarray:
        """The place between the shoulders (3,), m."""
        return np.array([self.aside, -self.high, self.away])

    def joints(self, person: Person, angles: np.ndarray) -> np.ndarray:
        """Return shoulders, elbows, wrists and fingertips (2, 4, 3), m in the camera's frame."""
        instance("person", person, Person)
        return self._turned(person.joints(angles, self.middle))

    def _turned(self, points: np.ndarray) -> np.ndarray:
        """Return places of a body that faces the camera, turned about its vertical axis."""
        if self.turn == 0:
            return points
        return self.middle + (points - self.middle) @ self._turning.T

    @property
    def _turning(self) -> np.ndarray:
        return Rotation.from_rotvec([0.0, self.turn, 0.0]).as_matrix()

    def pixels(self, points: np.ndarray) -> np.ndarray:
        """Return columns and rows (…, 2) of points (…, 3) before the camera."""
        points = reals("points", points)
        if points.ndim < 1 or points.shape[-1] != 3 or not np.isfinite(points).all():
            raise ValueError(f"points must be finite, (…, 3), got {points.shape}")
        if points.size and not (points[..., 2].min() > 1e-6 and np.abs(points).max() < 1e6):
            raise ValueError("points must be before the camera, within 1e6 m")
        rows, columns = self.size
        return self.focal * points[..., :2] / points[..., 2:] + [(columns - 1) / 2, (rows - 1) / 2]

    def face(self, person: Person) -> np.ndarray:
        """Return the square that marks the face (4,): left, top, width and height, px."""
        instance("person", person, Person)
        u, v = self.pixels(self.middle - [0, person.build.drop, 0])
        tall = self.focal * SPAN / self.away
        return square((u, v), FACE_BOX[2] * tall)

    def paint(
        self, person: Person, angles: np.ndarray, canvas: np.ndarray, light: float = 1.0
    ) -> tuple[np.ndarray, np.ndarray]:
        """Return a canvas with a person before it, and which part each pixel is of.

        Parameters
        ----------
        person
            Who stands there.
        angles : (8,)
            Of both arms, rad.
        canvas : (rows, columns, 3)
            Shares of full light, 32-bit floating point.
        light
            That falls on the person.

        Returns
        -------
        (rows, columns, 3)
            Shares of full light.
        (rows, columns)
            0 for the background, 1 for the head, 2 for the trunk; 3, 4, 5 for upper arm, forearm
            and hand on the left, 6, 7, 8 on the right.
        """
        instance("person", person, Person)
        angles = array("angles", angles, (8,), 10.0)
        light = number("light", light, 0.0, 4.0)
        rows, columns = self.size
        if not isinstance(canvas, np.ndarray) or canvas.dtype != np.float32:
            raise TypeError("canvas must be an array of 32-bit floating point numbers")
        array("canvas", canvas, (rows, columns, 3))
        fine = _FINE * rows, _FINE * columns
        colour = cv2.resize(canvas, fine[::-1], interpolation=cv2.INTER_LINEAR)
        depth = np.full(fine, np.inf, dtype=np.float32)
        parts = np.zeros(fine, dtype=np.uint8)
        self._draw(_trunk(person, self.middle), person, 2, colour, depth, parts, light)
        self._head(person, colour, depth, parts, light)
        for k, side in enumerate(SIDES):
            for part, mesh in enumerate(_arm(person, side, angles[4 * k : 4 * k + 4], self.middle)):
                self._draw(mesh, person, 3 + 3 * k + part, colour, depth, parts, light)
        painted = cv2.resize(colour, (columns, rows), interpolation=cv2.INTER_AREA)
        return painted, parts[_FINE // 2 :: _FINE, _FINE // 2 :: _FINE].copy()

    def _head(
        self,
        person: Person,
        colour: np.ndarray,
        depth: np.ndarray,
        parts: np.ndarray,
        light: float,
    ) -> None:
        """Lay the head before the trunk; its depth is that of the body's plane."""
        # the face turns in steps, so that it is not drawn anew for every picture
        view = FaceView(
            yaw=round(-self.turn, 1),
            azimuth=self.azimuth,
            elevation=self.elevation,
            ambient=self.ambient,
        )
        tall = _FINE * self.focal * SPAN / self.away
        sprite = face_sprite(person.identity, view, round(min(max(tall, 24), 400)))
        u, v = _FINE * self.pixels(self.middle - [0, person.build.drop, 0]) + (_FINE - 1) / 2
        v -= (FACE_BOX[1] - 0.5) * tall
        high, wide = sprite.shape[:2]
        top, left = round(v - high / 2), round(u - wide / 2)
        rows = np.arange(max(top, 0), min(top + high, colour.shape[0]))
        columns = np.arange(max(left, 0), min(left + wide, colour.shape[1]))
        if not (rows.size and columns.size):
            return
        box = np.ix_(rows, columns)
        laid = sprite[np.ix_(rows - top, columns - left)]
        cover = laid[..., 3:]
        colour[box] = colour[box] * (1 - cover) + light * laid[..., :3] * cover
        solid = cover[..., 0] > 0.5
        depth[box] = np.where(solid, self.away - 0.09, depth[box])
        parts[box] = np.where(solid, 1, parts[box])

    def _draw(
        self,
        mesh: "Mesh",
        person: Person,
        part: int,
        colour: np.ndarray,
        depth: np.ndarray,
        parts: np.ndarray,
        light: float,
    ) -> None:
        lamp = np.array([
            math.sin(self.azimuth) * math.cos(self.elevation),
            -math.sin(self.elevation),
            -math.cos(self.azimuth) * math.cos(self.elevation),
        ])  # fmt: skip
        points, normals = self._turned(mesh.points), mesh.normals
        if self.turn:
            normals = normals @ self._turning.T
        shade = self.ambient + (1 - self.ambient) * np.clip(normals @ lamp, 0, None)
        places = _FINE * self.pixels(points) + (_FINE - 1) / 2
        skin = mesh.texture is None
        cloth = np.asarray(person.identity.skin if skin else mesh.texture, dtype=np.float32)
        _splat(
            places,
            points[..., 2],
            (light * shade).astype(np.float32),
            np.broadcast_to(cloth, (_TEXELS, _TEXELS, 3)) if skin else cloth,
            mesh.texels,
            part,
            colour,
            depth,
            parts,
        )


@dataclass(frozen=True, eq=False, slots=True)
class Mesh:
    """A surface of rings.

    Parameters
    ----------
    points, normals : (rings, around, 3)
        Places and directions outwards; the last place of a ring is its first one.
    texels : (rings, around, 2)
        Where each lies in the texture, in turns.
    texture : (64, 64, 3), optional
        Light that comes back; bare skin if there is none.
    """

    points: np.ndarray
    normals: np.ndarray
    texels: np.ndarray = field(repr=False)
    texture: np.ndarray | None = field(default=None, repr=False)


def make_outfit(rng: np.random.Generator, pattern: str | None = None) -> Outfit:
    """Return what somebody wears; any pattern if none is given."""
    generator(rng)
    drawn = str(rng.choice(PATTERNS))
    hue, strong, bright = rng.uniform(0, 2 * np.pi), rng.uniform(0.1, 0.3), rng.uniform(0.3, 0.7)
    shirt = bright + strong * np.cos(hue + 2 * np.pi / 3 * np.arange(3))
    other = np.clip(rng.uniform(0.15, 0.85) + rng.uniform(-0.2, 0.2, 3), 0.05, 0.9)
    colours = [tuple(linear(c.clip(0.04, 0.95)).tolist()) for c in (shirt, other)]
    short, loose = bool(rng.uniform() < 0.3), float(rng.uniform(0.04, 0.12))
    seed = int(rng.integers(2**32))
    return Outfit(*colours, drawn if pattern is None else pattern, short, loose, seed)


def make_person(
    rng: np.random.Generator, identity: FaceIdentity, outfit: Outfit | None = None
) -> Person:
    """Return somebody whose measures are within some percent of the usual ones."""
    generator(rng)
    usual = Build()
    names = ("upper", "fore", "hand", "apart", "drop", "thick")
    share = np.exp(np.array([0.03, 0.03, 0.03, 0.03, 0.03, 0.06]) * rng.standard_normal(6))
    build = Build(*(getattr(usual, name) * float(s) for name, s in zip(names, share, strict=True)))
    return Person(build, make_outfit(rng) if outfit is None else outfit, identity)


def _turns(side: int, angles: np.ndarray) -> tuple[Rotation, Rotation]:
    """Return how upper arm and forearm are turned."""
    away, ahead, about, bend = angles
    upper = Rotation.from_euler("ZXY", [-side * away, -ahead, side * about])
    return upper, upper * Rotation.from_euler("Z", -side * bend)


def _cloth(outfit: Outfit) -> np.ndarray:
    """Return the texture of the cloth (64, 64, 3), which joins at its edges."""
    v, u = (np.indices((_TEXELS, _TEXELS)) + 0.5) / _TEXELS
    if outfit.pattern == "stripes":
        second = np.sin(2 * np.pi * 4 * v) > 0.2
    elif outfit.pattern == "checks":
        second = np.sin(2 * np.pi * 4 * v) * np.sin(2 * np.pi * 3 * u) > 0
    elif outfit.pattern == "print":
        rng = np.random.default_rng(outfit.seed)
        second = texture(7, 1, rng=rng, size=(_TEXELS, _TEXELS)) > 0.4
    else:
        second = np.zeros(u.shape, dtype=bool)
    pair = np.array([outfit.shirt, outfit.other], dtype=np.float32)
    return np.ascontiguousarray(pair[second.astype(int)])


def _folds(outfit: Outfit, along: np.ndarray, around: np.ndarray, bend: float, k: int):
    """Return by which share cloth stands off; it wrinkles as the elbow bends."""
    rng = np.random.default_rng([outfit.seed, k])
    phase = rng.uniform(0, 2 * np.pi, 3)
    wrinkles = (
        np.sin(2 * np.pi * 3 * along + 2 * around + phase[0] + bend)
        + np.sin(2 * np.pi * 5 * along - 3 * around + phase[1] - 2 * bend)
        + 0.7 * np.sin(4 * around + phase[2])
    )
    return outfit.loose * (0.5 + 0.5 * min(bend, 2.0)) * wrinkles / 2


def _rings(count: int) -> tuple[np.ndarray, np.ndarray]:
    """Return places along, 0 to 1, and angles around, each (count, around)."""
    along = np.linspace(0, 1, count)
    around = np.linspace(0, 2 * np.pi, _AROUND + 1)
    return np.broadcast_arrays(along[:, None], around[None])


def _mesh(
    points: np.ndarray, texels: np.ndarray, cloth: np.ndarray | None, inside: np.ndarray
) -> Mesh:
    """Return a mesh with normals that point away from a line inside (rings, 3)."""
    down = np.gradient(points, axis=0)
    open_ring = points[:, :-1]
    aside = np.roll(open_ring, -1, axis=1) - np.roll(open_ring, 1, axis=1)
    aside = np.concatenate([aside, aside[:, :1]], axis=1)
    normals = np.cross(down, aside)
    normals /= np.maximum(np.linalg.norm(normals, axis=-1, keepdims=True), 1e-12)
    outwards = ((points - inside[:, None]) * normals).sum(axis=-1, keepdims=True)
    return Mesh(points, np.where(outwards < 0, -normals, normals), texels, cloth)


def _limb(turn: Rotation, start: np.ndarray, length: float, radii: tuple) -> Mesh:
    """Return a limb with round ends.

    Parameters
    ----------
    turn
        From a limb that hangs.
    start
        Where it begins.
    length
        From there to its end.
    radii
        Of the rings, sideways and forwards (rings, around) each, and the texels and the cloth.
    """
    sideways, forwards, texels, cloth = radii
    count = len(sideways)
    _, around = _rings(count)
    ends = float(sideways[0].mean()), float(sideways[-1].mean())
    t = np.linspace(0, 1, count)
    y = -ends[0] + t * (length + ends[0] + ends[1])  # round ends reach beyond the joints
    cap = np.ones(count)
    for near, radius in ((y, ends[0]), (length - y, ends[1])):
        past = np.clip(-near / radius, 0, 0.999)
        cap = np.minimum(cap, np.sqrt(1 - past**2))
    local = np.stack(
        [
            cap[:, None] * sideways * np.cos(around),
            np.broadcast_to(y[:, None], around.shape),
            cap[:, None] * forwards * np.sin(around),
        ],
        axis=-1,
    )
    axis = np.stack([np.zeros(count), y, np.zeros(count)], axis=-1)
    points = turn.apply(local.reshape(-1, 3)).reshape(local.shape) + start
    return _mesh(points, texels, cloth, turn.apply(axis) + start)


def _arm(person: Person, side: int, angles: np.ndarray, middle: np.ndarray) -> list[Mesh]:
    """Return upper arm, forearm and hand."""
    build, outfit = person.build, person.outfit
    upper, fore = _turns(side, angles)
    about, bend = float(angles[2]), float(angles[3])
    shoulder, elbow, wrist, _ = person.joints(np.tile(angles, 2), middle)[(side + 1) // 2]
    cloth = _cloth(outfit)
    thick, meshes = build.thick, []
    for k, (turn, start, length, first, last) in enumerate(
        [(upper, shoulder, build.upper, 1.0, 0.84), (fore, elbow, build.fore, 0.84, 0.58)]
    ):
        along, around = _rings(22)
        radius = thick * (first + (last - first) * along)
        if k == 0:  # the biceps swells on the side to which the elbow bends
            swell = 0.10 * min(bend / 2.0, 1.0) * np.sin(np.pi * along)
            radius = radius * (1 + swell * np.clip(side * np.cos(around), 0, None))
        else:
            radius = radius * (1 + 0.10 * np.sin(np.pi * along**0.7))
        bare = outfit.short and k == 1
        if not bare:
            radius = radius * (1.06 + _folds(outfit, along, around, bend, 2 * (side + 1) + k))
        twist = -0.5 * side * about * (1 - along) / (2 * np.pi) if k == 0 else 0.0 * along
        scale = length / 0.29
        texels = np.stack([around / (2 * np.pi) + twist, scale * along], axis=-1)
        meshes.append(_limb(turn, start, length, (radius, radius, texels, None if bare else cloth)))
    along, around = _rings(14)
    wide = thick * (0.55 + 0.28 * np.sin(np.pi * np.clip(along * 1.05, 0, 1)) ** 0.8)
    flat = 0.55 * wide
    shape = (wide, flat, np.stack([around / 7, along], axis=-1), None)
    meshes.append(_limb(fore, wrist, build.hand - 0.05, shape))
    return meshes


_TRUNK = np.array([
    (-0.075, 0.055, 0.055), (-0.055, 0.075, 0.065), (-0.035, 0.120, 0.080), (0.0, 0.180, 0.095),
    (0.06, 0.190, 0.110), (0.15, 0.180, 0.120), (0.28, 0.160, 0.110), (0.40, 0.165, 0.115),
    (0.55, 0.185, 0.125), (0.80, 0.190, 0.125),
])  # fmt: skip
"""Rings of a trunk: below the shoulders, half width, half depth; m."""


def _trunk(person: Person, middle: np.ndarray) -> Mesh:
    """Return neck, shoulders and trunk."""
    along, around = _rings(34)
    y = _TRUNK[0, 0] + along[:, 0] * (_TRUNK[-1, 0] - _TRUNK[0, 0])
    wide = np.interp(y, _TRUNK[:, 0], _TRUNK[:, 1]) * person.build.apart / 0.37
    deep = np.interp(y, _TRUNK[:, 0], _TRUNK[:, 2])
    cos, sin = np.cos(around), np.sin(around)
    super_ = (np.abs(cos) ** 2.6 + np.abs(sin) ** 2.6) ** (-1 / 2.6)
    off = 1 + 0.3 * _folds(person.outfit, 2 * along, around, 0.6, 9)
    points = middle + np.stack(
        [
            wide[:, None] * super_ * cos * off,
            np.broadcast_to(y[:, None], around.shape),
            deep[:, None] * super_ * sin * off,
        ],
        axis=-1,
    )
    texels = np.stack([3 * around / (2 * np.pi), np.broadcast_to(y[:, None], around.shape) / 0.29],
                      axis=-1)  # fmt: skip
    axis = middle + np.stack([0 * y, y, 0 * y], axis=-1)
    return _mesh(points, texels, _cloth(person.outfit), axis)


@kernel()
def _splat(places, deep, shade, cloth, texels, part, colour, depth, parts):
    """Draw the quads of a mesh as two triangles each, the nearest one at each pixel."""
    rings, around = deep.shape
    rows, columns = depth.shape
    size = cloth.shape[0]
    corners = np.empty((3, 2), dtype=np.int64)
    for i in range(rings - 1):
        for j in range(around - 1):
            for half in range(2):
                corners[0, 0], corners[0, 1] = i, j
                corners[1, 0], corners[1, 1] = i + 1, j + 1
                if half == 0:
                    corners[2, 0], corners[2, 1] = i + 1, j
                else:
                    corners[2, 0], corners[2, 1] = i, j + 1
                a, b, c = places[i, j], places[i + 1, j + 1], places[corners[2, 0], corners[2, 1]]
                area = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
                if abs(area) < 1e-9:
                    continue
                low_u = max(int(np.ceil(min(a[0], b[0], c[0]))), 0)
                high_u = min(int(np.floor(max(a[0], b[0], c[0]))), columns - 1)
                low_v = max(int(np.ceil(min(a[1], b[1], c[1]))), 0)
                high_v = min(int(np.floor(max(a[1], b[1], c[1]))), rows - 1)
                for v in range(low_v, high_v + 1):
                    for u in range(low_u, high_u + 1):
                        wc = ((b[0] - a[0]) * (v - a[1]) - (b[1] - a[1]) * (u - a[0])) / area
                        wb = ((u - a[0]) * (c[1] - a[1]) - (v - a[1]) * (c[0] - a[0])) / area
                        wa = 1 - wb - wc
                        if wa < -1e-6 or wb < -1e-6 or wc < -1e-6:
                            continue
                        z, s, x, y = 0.0, 0.0, 0.0, 0.0
                        for k in range(3):
                            p, q = corners[k, 0], corners[k, 1]
                            w = wa if k == 0 else wb if k == 1 else wc
                            z += w * deep[p, q]
                            s += w * shade[p, q]
                            x += w * texels[p, q, 0]
                            y += w * texels[p, q, 1]
                        if z < depth[v, u]:
                            depth[v, u] = z
                            parts[v, u] = part
                            m, n = int(np.floor(y * size)) % size, int(np.floor(x * size)) % size
                            for k in range(3):
                                colour[v, u, k] = s * cloth[m, n, k]
