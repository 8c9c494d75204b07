"""A camera on a robot that looks up at a ceiling, ray by ray.

The robot's frame has its first axis ahead, the second to the left, the third up, and its origin at
the height of the camera, which is `Mount.height` below the ceiling. The camera's first axis is that
of the pixels' columns u, the second that of their rows v, the third looks out. Mounted without
fault the two frames are one: u runs ahead, v to the left. Pixels have their middles at integers.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np

from data_synth._checks import array, generator, instance, number, whole
from data_synth._kernels import kernel
from data_synth.ceiling.plane import Ceiling

BEYOND = 96.0
"""Grey of what lies beyond the ceiling."""
LENS = 0.5
"""Deviation of what the lens smears, pixels."""

_WIDEST = 1e6  # of a lens, focal lengths
_NOWHERE = 1e9  # slope of a ray that does not go up
_STEPS = 1 / 256  # in which smoothed greys are kept


@dataclass(frozen=True, slots=True)
class Mount:
    """Place of a camera on its robot, and its lens; all values are ours.

    Parameters
    ----------
    height
        From the camera's centre straight up to the ceiling, m.
    focal
        Focal length, pixels.
    size
        Columns and rows of its images.
    centre
        Column and row where the optical axis meets the image; ``None`` for the image's middle.
    roll, pitch, yaw
        How the camera is turned out of its place, rad: first by yaw about the robot's upward axis,
        from ahead to the left; then by pitch about its own rows' axis v, so that more than 0 lets
        it look ahead; last by roll about its own columns' axis u, so that more than 0 lets it look
        to the right.
    x, y
        Place of the camera's centre in the robot's frame, ahead and to the left, m.
    distortion
        k₁ and k₂ of Brown's radial lens: what an ideal lens shows r from the centre, in focal
        lengths, is seen at r (1 + k₁ r² + k₂ r⁴).

    Raises
    ------
    ValueError
        If a part is out of range, the camera looks at no ceiling, or the lens folds the image.
    """

    height: float = 2.5
    focal: float = 200.0
    size: tuple[int, int] = (320, 240)
    centre: tuple[float, float] | None = None
    roll: float = 0.0
    pitch: float = 0.0
    yaw: float = 0.0
    x: float = 0.0
    y: float = 0.0
    distortion: tuple[float, float] = (0.0, 0.0)

    def __post_init__(self) -> None:
        number("height", self.height, 0.1, 100.0)
        number("focal", self.focal, 1.0, 1e5)
        for side in _pair("size", self.size):
            whole("size", side, 1, 4096)
        if self.centre is not None:
            for part in _pair("centre", self.centre):
                number("centre", part, -1e4, 1e4)
        for name in ("roll", "pitch"):
            number(name, getattr(self, name), -1.2, 1.2)
        number("yaw", self.yaw, -10.0, 10.0)
        for name in ("x", "y"):
            number(name, getattr(self, name), -10.0, 10.0)
        for k in _pair("distortion", self.distortion):
            number("distortion", k, -10.0, 10.0)
        if not _seen_at(self._fold, *self.distortion) > self._corner:
            raise ValueError(f"distortion must not fold the image, got {self.distortion}")

    @property
    def middle(self) -> tuple[float, float]:
        """Column and row where the optical axis meets the image."""
        if self.centre is not None:
            return self.centre
        return (self.size[0] - 1) / 2, (self.size[1] - 1) / 2

    @property
    def K(self) -> np.ndarray:
        """Intrinsic parameters (3, 3), from the camera's frame to pixels without distortion."""
        u, v = self.middle
        return np.array([[self.focal, 0.0, u], [0.0, self.focal, v], [0.0, 0.0, 1.0]])

    @property
    def rotation(self) -> np.ndarray:
        """R (3, 3) of X_C = R X_R + t, robot's frame to camera's: its rows are camera axes."""
        a, b, c = self.yaw, self.pitch, self.roll
        ahead = [np.cos(a) * np.cos(b), np.sin(a) * np.cos(b), -np.sin(b)]
        tipped = [np.cos(a) * np.sin(b), np.sin(a) * np.sin(b), np.cos(b)]  # before the roll
        left = [-np.sin(a), np.cos(a), 0.0]
        second = [np.cos(c) * p + np.sin(c) * q for p, q in zip(left, tipped, strict=True)]
        third = [np.cos(c) * q - np.sin(c) * p for p, q in zip(left, tipped, strict=True)]
        return np.array([ahead, second, third])

    @property
    def translation(self) -> np.ndarray:
        """Translation t (3,) of X_C = R X_R + t, m: where the robot's origin is for the camera."""
        return -self.rotation @ [self.x, self.y, 0.0]

    @property
    def _corner(self) -> float:
        """Distance of the farthest pixel's edge from the middle, focal lengths."""
        u, v = self.middle
        wide = max(abs(-0.5 - u), abs(self.size[0] - 0.5 - u))
        high = max(abs(-0.5 - v), abs(self.size[1] - 0.5 - v))
        return float(np.hypot(wide, high) / self.focal)

    @property
    def _fold(self) -> float:
        """Radius in an ideal lens up to which the image goes on growing, focal lengths."""
        first, second = self.distortion
        inner = 9 * first**2 - 20 * second  # where 1 + 3 k₁ r² + 5 k₂ r⁴ is 0
        if inner < 0 or np.sqrt(inner) <= 3 * first:
            return _WIDEST
        return float(min(np.sqrt(2 / (np.sqrt(inner) - 3 * first)), _WIDEST))


@dataclass(frozen=True, slots=True)
class Exposure:
    """Exposure of a camera: grey values, all ours.

    gain · grey · (1 - vignetting r²) + offset + noise · N(0, 1), where r is 1 as far from the
    optical axis as half a diagonal of the image.

    Parameters
    ----------
    gain
        Of the light.
    offset
        Added to it, grey values.
    noise
        Standard deviation of what is added at each pixel, grey values.
    vignetting
        Share of the light that is lost at r = 1.
    """

    gain: float = 1.0
    offset: float = 0.0
    noise: float = 0.0
    vignetting: float = 0.0

    def __post_init__(self) -> None:
        number("gain", self.gain, 0.0, 1e3)
        number("offset", self.offset, -1e3, 1e3)
        number("noise", self.noise, 0.0, 1e3)
        number("vignetting", self.vignetting, 0.0, 1.0)


@dataclass(frozen=True, slots=True)
class Occluder:
    """A level disc between camera and ceiling: a head, or a lamp that hangs.

    Parameters
    ----------
    x, y
        Its middle in the world, m.
    radius
        Of the disc, m.
    height
        Above the camera, m: nearer than the ceiling.
    grey
        What it looks like, grey value.
    """

    x: float
    y: float
    radius: float
    height: float
    grey: float

    def __post_init__(self) -> None:
        for name in ("x", "y"):
            number(name, getattr(self, name), -1e4, 1e4)
        number("radius", self.radius, 0.0, 1e3)
        number("height", self.height, 0.0, 100.0, above=0.0)
        number("grey", self.grey, 0.0, 255.0)


class CeilingCamera:
    """A camera below a ceiling: it knows where each of its rays meets it.

    The ceiling is smoothed once by a Gaussian of `LENS` pixels, as wide on the ceiling as they are
    straight above the camera. That is the lens, and it keeps fine detail from flickering between
    pixels; a picture is then read off between the texels bilinearly.

    Parameters
    ----------
    ceiling
        What is above.
    mount
        The camera.
    """

    def __init__(self, ceiling: Ceiling, mount: Mount) -> None:
        self.ceiling = instance("ceiling", ceiling, Ceiling)
        self.mount = instance("mount", mount, Mount)
        spread = LENS * mount.height / mount.focal / ceiling.resolution
        fine = np.ascontiguousarray(ceiling.texture, dtype=np.float32)
        if spread > 0.2:
            fine = cv2.GaussianBlur(fine, (0, 0), spread, borderType=cv2.BORDER_REPLICATE)
        self._greys = np.rint(fine / _STEPS).clip(0, 65535).astype(np.uint16)
        self._slopes, self._far = _rays(mount)

    def image(
        self,
        pose: np.ndarray,
        *,
        rng: np.random.Generator | None = None,
        exposure: Exposure = Exposure(),
        occluders: Sequence[Occluder] = (),
    ) -> np.ndarray:
        """Return what the camera sees from a place: grey values (rows, columns) of 8 bits.

        Parameters
        ----------
        pose : (3,)
            Of the robot: x, y, heading, m and rad.
        rng
            Source of the noise; needed if there is any.
        exposure
            What the camera makes of the light.
        occluders
            Discs that hide the ceiling; those nearer to the camera hide the others.

        Raises
        ------
        ValueError
            If there is noise without a source, or an occluder is above the ceiling.
        """
        x, y, heading = _pose(pose)
        instance("exposure", exposure, Exposure)
        discs = self._discs(occluders)
        if rng is not None:
            generator(rng)
        elif exposure.noise > 0:
            raise ValueError("rng must be given where exposure.noise is more than 0, got None")
        mount = self.mount
        shape = mount.size[::-1]
        noise = np.zeros((1, 1), dtype=np.float32)
        if exposure.noise > 0 and rng is not None:
            noise = rng.standard_normal(shape, dtype=np.float32)
        found = np.empty(shape, dtype=np.uint8)
        _render(
            *(self._greys, self.ceiling.resolution, self._slopes, self._far),
            *(mount.x, mount.y, mount.height, mount.focal),
            *(x, y, np.cos(heading), np.sin(heading), discs),
            *(exposure.gain, exposure.offset, exposure.noise, exposure.vignetting, noise, found),
        )
        return found

    def points_seen(self, pose: np.ndarray, world_points: np.ndarray) -> np.ndarray:
        """Return the pixels (n, 2), column and row, at which points of the ceiling are seen.

        They may lie outside the image. What the lens cannot show, because it is behind the camera
        or beyond the fold of its distortion, is infinitely far off.

        Parameters
        ----------
        pose : (3,)
            Of the robot: x, y, heading, m and rad.
        world_points : (n, 2)
            On the ceiling, m.
        """
        x, y, heading = _pose(pose)
        world_points = array("world_points", world_points, (None, 2), 1e6)
        mount = self.mount
        east, north = world_points[:, 0] - x, world_points[:, 1] - y
        ahead = np.cos(heading) * east + np.sin(heading) * north - mount.x
        left = np.cos(heading) * north - np.sin(heading) * east - mount.y
        # how far along each of the camera's axes
        along = [a * ahead + b * left + c * mount.height for a, b, c in mount.rotation]
        shown = along[2] > 0
        depth = np.where(shown, along[2], 1.0)
        right, down = along[0] / depth, along[1] / depth
        off = np.hypot(right, down)
        shown &= off <= mount._fold
        first, second = mount.distortion
        square = np.minimum(off, mount._fold) ** 2
        grown = mount.focal * (1 + first * square + second * square**2)
        u, v = mount.middle
        pixels = np.stack([u + grown * right, v + grown * down], axis=-1)
        return np.where(shown[:, None], pixels, np.inf)

    def _discs(self, occluders: Sequence[Occluder]) -> np.ndarray:
        if not isinstance(occluders, Sequence) or isinstance(occluders, str):
            raise TypeError(f"occluders must be a sequence, got {occluders!r:.60}")
        for disc in occluders:
            instance("occluders", disc, Occluder)
            if not disc.height < self.mount.height:
                raise ValueError(
                    f"occluders must be below the ceiling, {self.mount.height:g} m above the "
                    f"camera, got {disc.height:g}"
                )
        ordered = sorted(occluders, key=lambda disc: -disc.height)
        rows = [(disc.x, disc.y, disc.radius, disc.height, disc.grey) for disc in ordered]
        return np.array(rows, dtype=float).reshape(-1, 5)


def _pair(name: str, value: object) -> tuple:
    if not isinstance(value, tuple) or len(value) != 2:
        raise TypeError(f"{name} must be a pair, got {value!r:.60}")
    return value


def _pose(pose: np.ndarray) -> tuple[float, float, float]:
    x, y, heading = array("pose", pose, (3,), 1e6)
    return float(x), float(y), float(heading)


def _seen_at(ideal: np.ndarray | float, first: float, second: float) -> np.ndarray:
    """Return how far from the centre a distorting lens shows what is ``ideal`` from it."""
    square = np.square(ideal)
    return ideal * (1 + first * square + second * square**2)


def _rays(mount: Mount) -> tuple[np.ndarray, np.ndarray]:
    """Return how far ahead and left each pixel's ray goes for a metre up, and its r².

    A ray that does not go up gets a slope that leads beyond every ceiling.
    """
    columns, rows = mount.size
    u, v = mount.middle
    down, right = np.mgrid[:rows, :columns].astype(float)
    right, down = (right - u) / mount.focal, (down - v) / mount.focal
    off = np.hypot(right, down)
    low, high = np.zeros_like(off), np.full_like(off, mount._fold)
    for _ in range(70):  # the lens's inverse, by halves: it grows up to the fold
        middle = (low + high) / 2
        less = _seen_at(middle, *mount.distortion) < off
        low, high = np.where(less, middle, low), np.where(less, high, middle)
    grown = np.divide(low, off, out=np.ones_like(off), where=off > 0)
    right, down = right * grown, down * grown
    first, second, third = mount.rotation
    ahead, left, up = (right * first[k] + down * second[k] + third[k] for k in range(3))
    rises = up > np.hypot(ahead, left) / _NOWHERE
    up = np.where(rises, up, 1.0)
    slopes = np.where(rises, np.stack([ahead, left]) / up, _NOWHERE)
    radius = np.square(off * mount.focal) / ((columns / 2) ** 2 + (rows / 2) ** 2)
    return slopes, radius.astype(np.float32)


@kernel()
def _render(
    greys, texel, slopes, far, camera_x, camera_y, height, focal, x, y, cos, sin, discs,
    gain, offset, deviation, vignetting, noise, found,
):  # fmt: skip
    """Follow each pixel's ray up to the discs and the ceiling."""
    n = len(greys)
    middle = (n - 1) / 2
    for row in range(found.shape[0]):
        for column in range(found.shape[1]):
            ahead = camera_x + height * slopes[0, row, column]
            left = camera_y + height * slopes[1, row, column]
            a = (x + cos * ahead - sin * left) / texel + middle
            b = (y + sin * ahead + cos * left) / texel + middle
            grey = BEYOND
            if a > -0.5 and b > -0.5 and a < n - 0.5 and b < n - 0.5:
                a, b = min(max(a, 0.0), n - 1.0), min(max(b, 0.0), n - 1.0)
                j, i = min(int(a), n - 2), min(int(b), n - 2)
                p, q = a - j, b - i
                upper = (1 - p) * greys[i, j] + p * greys[i, j + 1]
                lower = (1 - p) * greys[i + 1, j] + p * greys[i + 1, j + 1]
                grey = ((1 - q) * upper + q * lower) * _STEPS
            for k in range(len(discs)):
                ahead = camera_x + discs[k, 3] * slopes[0, row, column]
                left = camera_y + discs[k, 3] * slopes[1, row, column]
                east = x + cos * ahead - sin * left - discs[k, 0]
                north = y + sin * ahead + cos * left - discs[k, 1]
                inside = (discs[k, 2] - np.sqrt(east * east + north * north)) * focal / discs[k, 3]
                grey += min(max(inside + 0.5, 0.0), 1.0) * (discs[k, 4] - grey)
            value = gain * grey * (1 - vignetting * far[row, column]) + offset
            if deviation > 0:
                value += deviation * noise[row, column]
            found[row, column] = int(min(max(value + 0.5, 0.0), 255.0))
