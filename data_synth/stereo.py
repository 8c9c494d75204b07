"""Pictures that a robot's two eyes take of a world of textured flat surfaces.

Each surface is a parallelogram o + a·r + b·d, with a and b from 0 to 1, that carries a picture.
Where the ray of a pixel (u, v) meets its plane follows from one perspective warp,

    w·(a, b, 1) = [r d o]⁻¹ K⁻¹ (u, v, 1),

and w is one over the depth: the surface with the largest w at a pixel is what the eye sees.

A camera looks along its third axis; the first points right and the second down. Pixels are (u, v),
column and row, with whole numbers at their centres. The eyes are level, look straight ahead, and
have no distortion and the same rows; the left one is above the origin of the robot.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.ndimage import gaussian_filter

from data_synth._checks import array, generator, instance, number, whole, wholes
from data_synth._kernels import kernel
from data_synth.textures import Atlas, make_atlas

_SLACK = 1e-9  # no gap where surfaces meet, parts of their size
_EDGES = np.array([[1.0, 0, _SLACK], [0, 1, _SLACK], [-1, 0, 1 + _SLACK], [0, -1, 1 + _SLACK]])
_PROBES = 8  # at most, along the longer side of a pixel on a slanting surface
_SAME = 1e-3  # a point in sight lies no farther behind what is seen, parts of the depth
_MEMORY = 0.95  # of the exposure from frame to frame


@dataclass(frozen=True, eq=False, slots=True)
class Surface:
    """A parallelogram with a picture, seen from one side.

    Parameters
    ----------
    corner, right, down : (3,)
        Where the upper left corner of the picture is, and its upper and left edge as they are seen,
        m. Of the two sides of the surface it is the one that sees ``right`` turn clockwise into
        ``down``.
    picture
        Index of the picture.
    tiles
        How often it repeats along ``right`` and ``down``.
    gain
        What its grey values are multiplied by: the light.
    carrier
        Index of the surface that it hangs on; -1 if on none.
    """

    corner: np.ndarray
    right: np.ndarray
    down: np.ndarray
    picture: int
    tiles: tuple[float, float] = (1.0, 1.0)
    gain: float = 1.0
    carrier: int = -1

    def __post_init__(self) -> None:
        for name in ("corner", "right", "down"):
            object.__setattr__(self, name, array(name, getattr(self, name), (3,)))
        if not np.linalg.norm(np.cross(self.right, self.down)) > 0:
            raise ValueError(f"right {self.right} and down {self.down} must span a surface")
        whole("picture", self.picture, 0, 10**6)
        tiles = array("tiles", self.tiles, (2,))
        if not ((tiles > 0) & (tiles < 1e4)).all():
            raise ValueError(f"tiles must be above 0 and below 10 000, got {self.tiles}")
        number("gain", self.gain, 0.0, 10.0)
        whole("carrier", self.carrier, -1, 10**6)


@dataclass(frozen=True, eq=False, slots=True)
class Scene:
    """Surfaces and their pictures.

    Parameters
    ----------
    frames : (surfaces, 3, 3)
        Columns: the edges ``right`` and ``down`` and the corner, m.
    pictures : (surfaces,)
        Index of the picture of each.
    tiles : (surfaces, 2)
        How often it repeats along each edge.
    gains : (surfaces,)
        The light.
    carriers : (surfaces,)
        The surface that each hangs on; its own index if on none.
    atlas
        The pictures.

    Raises
    ------
    ValueError
        If the lengths disagree, there is no surface, or a surface names what there is not.
    """

    frames: np.ndarray
    pictures: np.ndarray
    tiles: np.ndarray
    gains: np.ndarray
    carriers: np.ndarray
    atlas: Atlas

    def __post_init__(self) -> None:
        count = len(array("frames", self.frames, (None, 3, 3)))
        if not count:
            raise ValueError("frames must be of one surface at least, got none")
        pictures = len(instance("atlas", self.atlas, Atlas).starts)
        wholes("pictures", self.pictures, (count,), 0, pictures - 1)
        array("tiles", self.tiles, (count, 2))
        array("gains", self.gains, (count,))
        wholes("carriers", self.carriers, (count,), 0, count - 1)


@dataclass(frozen=True, slots=True)
class Rig:
    """Two cameras side by side on a robot; all values are ours but for the size of the images.

    Parameters
    ----------
    focal_px
        Focal length, pixels.
    baseline
        From the left eye to the right one, m.
    size
        Width and height of the images, pixels.
    height
        Of the eyes above the floor, m.
    blur_px
        Deviation of the Gaussian that a point becomes, pixels.
    vignetting
        Share of the natural fall-off cos⁴ that is left by the lens.
    read_noise
        Deviation of the noise in the dark, grey values.
    photon_noise
        Variance of the noise for each grey value.
    flicker
        Deviation of the logarithm of the exposure over a drive.
    imbalance
        Deviation of the logarithm of the right exposure over the left.
    """

    focal_px: float = 280.0
    baseline: float = 0.15
    size: tuple[int, int] = (320, 240)
    height: float = 1.1
    blur_px: float = 0.6
    vignetting: float = 0.7
    read_noise: float = 1.2
    photon_noise: float = 0.015
    flicker: float = 0.12
    imbalance: float = 0.02

    def __post_init__(self) -> None:
        number("focal_px", self.focal_px, above=0.0)
        number("baseline", self.baseline, above=0.0)
        number("height", self.height, above=0.0)
        if not isinstance(self.size, tuple) or len(self.size) != 2:
            raise TypeError(f"size must be width and height, got {self.size!r:.60}")
        for side in self.size:
            whole("size", side, 1, 4096)
        number("blur_px", self.blur_px, 0.0, 100.0)
        number("vignetting", self.vignetting, 0.0, 1.0)
        for name in ("read_noise", "photon_noise", "flicker", "imbalance"):
            number(name, getattr(self, name), 0.0, 100.0)

    @property
    def centre_px(self) -> tuple[float, float]:
        """Point at which the optical axis meets the image, pixels."""
        return (self.size[0] - 1) / 2, (self.size[1] - 1) / 2

    @property
    def T_robot_camera(self) -> np.ndarray:
        """Points of the left camera to points of the robot (forward, leftward, up), (4, 4)."""
        return np.array([[0.0, 0, 1, 0], [-1, 0, 0, 0], [0, -1, 0, self.height], [0, 0, 0, 1]])


@dataclass(frozen=True, eq=False, slots=True)
class StereoFrame:
    """A pair of images.

    Parameters
    ----------
    left, right : (height, width)
        Grey values of 8 bits.
    """

    left: np.ndarray
    right: np.ndarray


@dataclass(frozen=True, eq=False, slots=True)
class Sight:
    """Points that the rays of some pixels meet.

    Parameters
    ----------
    points : (n, 3)
        In the world, m; NaN where there is nothing.
    surfaces : (n,)
        Index of the surface, -1 where there is nothing.
    carriers : (n,)
        Index of the surface that it hangs on, which is itself if it hangs on none; or -1.
    """

    points: np.ndarray
    surfaces: np.ndarray
    carriers: np.ndarray


def make_scene(surfaces: Sequence[Surface], pictures: Sequence[np.ndarray]) -> Scene:
    """Return a scene.

    Parameters
    ----------
    surfaces
        One at least.
    pictures
        Those which the surfaces name: grey values 0 to 255 in arrays whose sides are powers of two.

    Raises
    ------
    ValueError
        If there is no surface, or one names a picture or a carrier that there is not.
    """
    if not isinstance(surfaces, Sequence) or not len(surfaces):
        raise TypeError(f"surfaces must be a sequence of one at least, got {surfaces!r:.60}")
    for surface in surfaces:
        instance("surfaces", surface, Surface)
    atlas = make_atlas(pictures)
    chosen = np.array([surface.picture for surface in surfaces])
    carriers = np.array([surface.carrier for surface in surfaces])
    if chosen.max() >= len(atlas.starts) or carriers.max() >= len(surfaces):
        raise ValueError(
            f"surfaces name picture {chosen.max()} and carrier {carriers.max()}"
            f" of {len(atlas.starts)} pictures and {len(surfaces)} surfaces"
        )
    return Scene(
        np.array([np.stack([s.right, s.down, s.corner], axis=-1) for s in surfaces]),
        chosen,
        np.array([surface.tiles for surface in surfaces], dtype=float),
        np.array([surface.gain for surface in surfaces], dtype=float),
        np.where(carriers < 0, np.arange(len(surfaces)), carriers),
        atlas,
    )


def render(
    scene: Scene, rig: Rig, pose: np.ndarray, *, exposure: float = 1.0, rng: np.random.Generator
) -> StereoFrame:
    """Return what both eyes see: sampled finely, blurred, darker towards the corners, noisy.

    Parameters
    ----------
    scene, rig
        What is there, and what looks at it.
    pose : (3,)
        Of the robot: x, y, heading, m and rad.
    exposure
        Factor of all grey values.
    rng
        Source of the noise and of the difference between the eyes.
    """
    return StereoFrame(*_eyes(scene, rig, pose, exposure, rng))


def render_left(
    scene: Scene,
    rig: Rig,
    pose: np.ndarray,
    *,
    exposure: float = 1.0,
    rng: np.random.Generator,
) -> np.ndarray:
    """Return what the left eye of `render` sees, without the work for the right one."""
    return next(_eyes(scene, rig, pose, exposure, rng))


def _eyes(
    scene: Scene, rig: Rig, pose: np.ndarray, exposure: float, rng: np.random.Generator
) -> Iterator[np.ndarray]:
    """Yield what the left eye sees, and then the right one."""
    instance("scene", scene, Scene)
    instance("rig", rig, Rig)
    pose = array("pose", pose, (3,))
    number("exposure", exposure, 0.0, 100.0)
    balance = np.exp(rig.imbalance * generator(rng).standard_normal())
    for across, factor in ((0.0, exposure), (rig.baseline, exposure * balance)):
        light = ideal_image(scene, rig, pose, across=across)
        light = gaussian_filter(light, rig.blur_px, mode="nearest", truncate=4.0)
        light *= np.float32(factor) * _fall_off(rig)
        spread = np.sqrt(np.float32(rig.read_noise**2) + np.float32(rig.photon_noise) * light)
        light += spread * rng.standard_normal(light.shape, dtype=np.float32)
        yield np.rint(light.clip(0, 255)).astype(np.uint8)


def frames(
    scene: Scene, rig: Rig, poses: np.ndarray, *, rng: np.random.Generator
) -> Iterator[StereoFrame]:
    """Yield the pairs of a drive one after the other; the exposure wanders along the way.

    Parameters
    ----------
    scene, rig
        As of `render`.
    poses : (n, 3)
        Of the robot, m and rad.
    rng
        Source of the exposure and the noise; each pair has a generator of its own.
    """
    return (StereoFrame(*eyes) for eyes in _along(scene, rig, poses, rng))


def left_frames(
    scene: Scene, rig: Rig, poses: np.ndarray, *, rng: np.random.Generator
) -> Iterator[np.ndarray]:
    """Yield what the left eye of `frames` sees, without the work for the right one."""
    return (next(eyes) for eyes in _along(scene, rig, poses, rng))


def _along(
    scene: Scene, rig: Rig, poses: np.ndarray, rng: np.random.Generator
) -> Iterator[Iterator[np.ndarray]]:
    instance("scene", scene, Scene)
    instance("rig", rig, Rig)
    poses = array("poses", poses, (None, 3))
    wander = generator(rng).standard_normal(len(poses))
    wander[1:] *= np.sqrt(1 - _MEMORY**2)
    for k in range(1, len(poses)):
        wander[k] += _MEMORY * wander[k - 1]
    exposures = np.exp(rig.flicker * wander)
    each = zip(poses, exposures, rng.spawn(len(poses)), strict=True)
    return (_eyes(scene, rig, pose, exposure, own) for pose, exposure, own in each)


def ideal_image(scene: Scene, rig: Rig, pose: np.ndarray, *, across: float = 0.0) -> np.ndarray:
    """Return the grey values of an eye without lens and noise, (height, width).

    Parameters
    ----------
    scene, rig, pose
        As of `render`.
    across
        How far to the right of the left eye it is, m.
    """
    warps = _warps(scene, rig, pose, across)
    width, height = rig.size
    finer = warps @ np.array([[0.5, 0, -0.25], [0, 0.5, -0.25], [0, 0, 1]])
    nearest = np.zeros((2 * height, 2 * width))
    seen = np.full(nearest.shape, -1, dtype=np.int64)
    _cover(finer, _EDGES @ finer, nearest, seen)
    image = np.zeros((height, width), dtype=np.float32)
    atlas = scene.atlas
    _shade(
        *(warps, seen, scene.pictures, scene.tiles, scene.gains),
        *(atlas.texels, atlas.starts, atlas.sizes, image),
    )
    return image


def surface_points(scene: Scene, rig: Rig, pose: np.ndarray, pixels: np.ndarray) -> Sight:
    """Return what the rays through pixels of the left image meet first.

    Two detections show the same place of the world if their carriers are the same and their points
    are near each other; how near is for the caller to say.

    Parameters
    ----------
    scene, rig, pose
        As of `render`.
    pixels : (n, 2)
        Column and row, in the image or beside it.
    """
    warps = _warps(scene, rig, pose, 0.0)
    pixels = array("pixels", pixels, (None, 2))
    if not len(pixels):
        return Sight(np.empty((0, 3)), *np.empty((2, 0), dtype=int))
    rays = np.concatenate([pixels, np.ones((len(pixels), 1))], axis=-1)
    a, b, nearness = np.moveaxis(warps @ rays.T, 1, 0)  # (surfaces, n)
    slack = _SLACK * nearness
    inside = (a >= -slack) & (b >= -slack) & (a <= nearness + slack) & (b <= nearness + slack)
    nearness = np.where(inside & (nearness > 0), nearness, 0.0)
    surfaces = nearness.argmax(axis=0)
    depth = nearness[surfaces, np.arange(len(pixels))]
    with np.errstate(divide="ignore"):
        depth = np.where(depth > 0, 1 / depth, np.nan)
    surfaces = np.where(depth > 0, surfaces, -1)
    u, v = rig.centre_px
    away = np.stack([pixels[:, 0] - u, pixels[:, 1] - v, np.full(len(pixels), rig.focal_px)], -1)
    axes, eye = _eye(rig, pose, 0.0)
    points = eye + depth[:, None] / rig.focal_px * away @ axes
    return Sight(points, surfaces, np.where(surfaces < 0, -1, scene.carriers[surfaces]))


def project(rig: Rig, pose: np.ndarray, points: np.ndarray) -> np.ndarray:
    """Return column, row and depth of points in the left image; depth is negative behind the eye.

    Parameters
    ----------
    rig, pose
        As of `render`.
    points : (n, 3)
        In the world, m.

    Returns
    -------
    (n, 3)
        Pixels, pixels, m. The column in the right image is less by focal length · baseline / depth.

    Raises
    ------
    ValueError
        If a point lies in the plane of the eye, where there is no image of it.
    """
    instance("rig", rig, Rig)
    axes, eye = _eye(rig, array("pose", pose, (3,)), 0.0)
    right, down, ahead = ((array("points", points, (None, 3)) - eye) @ axes.T).T
    if (ahead == 0).any():
        raise ValueError(f"points must not lie beside the eye, {(ahead == 0).sum()} do")
    u, v = rig.centre_px
    return np.stack(
        [u + rig.focal_px * right / ahead, v + rig.focal_px * down / ahead, ahead], axis=-1
    )


def visible(scene: Scene, rig: Rig, pose: np.ndarray, points: np.ndarray) -> np.ndarray:
    """Tell which points of the world are in the left image and not hidden behind a surface, (n,).

    Parameters
    ----------
    scene, rig, pose
        As of `render`.
    points : (n, 3)
        In the world, m.
    """
    at = project(rig, pose, points)
    width, height = rig.size
    within = (at[:, 2] > 0) & (abs(at[:, :2] - rig.centre_px) <= np.array([width, height]) / 2).all(
        axis=-1
    )
    seen = np.zeros(len(at), dtype=bool)
    found = surface_points(scene, rig, pose, at[within, :2])
    depth = project(rig, pose, found.points[found.surfaces >= 0])[:, 2]
    first = np.full(within.sum(), np.inf)
    first[found.surfaces >= 0] = depth
    seen[within] = at[within, 2] <= first * (1 + _SAME)
    return seen


def _eye(rig: Rig, pose: np.ndarray, across: float) -> tuple[np.ndarray, np.ndarray]:
    """Axes of an eye as rows, right, down and ahead, and where it is."""
    x, y, heading = pose
    cos, sin = np.cos(heading), np.sin(heading)
    axes = np.array([[sin, -cos, 0.0], [0.0, 0.0, -1.0], [cos, sin, 0.0]])
    return axes, np.array([x, y, rig.height]) + across * axes[0]


def _warps(scene: Scene, rig: Rig, pose: np.ndarray, across: float) -> np.ndarray:
    """Warp of each surface from pixels to (a, b, 1) / depth, (surfaces, 3, 3).

    Zero for a surface seen from behind or from its edge: it covers nothing.
    """
    instance("scene", scene, Scene)
    instance("rig", rig, Rig)
    axes, eye = _eye(rig, array("pose", pose, (3,)), number("across", across))
    frames = scene.frames.copy()
    frames[:, :, 2] -= eye
    frames = axes @ frames
    front = np.linalg.det(frames) > 1e-12 * np.abs(frames).max(axis=(1, 2)) ** 3
    (u, v), f = rig.centre_px, rig.focal_px
    rays = np.array([[1 / f, 0, -u / f], [0, 1 / f, -v / f], [0, 0, 1]])
    warps = np.zeros_like(frames)
    warps[front] = np.linalg.solve(frames[front], np.broadcast_to(rays, (front.sum(), 3, 3)))
    return warps


def _fall_off(rig: Rig) -> np.ndarray:
    """Natural vignetting: the fourth power of the cosine of the angle off the axis."""
    (u, v), (width, height) = rig.centre_px, rig.size
    rows, columns = np.ogrid[:height, :width]
    squared = ((columns - u) ** 2 + (rows - v) ** 2) / rig.focal_px**2
    return (1 - rig.vignetting * (1 - (1 + squared) ** -2)).astype(np.float32)


@kernel()
def _cover(warps: np.ndarray, bounds: np.ndarray, nearest: np.ndarray, seen: np.ndarray) -> None:
    """Write for each pixel the surface whose plane is met first inside its edges.

    Along a row a, b and w are linear in the column, so each edge bounds the columns from one side.
    """
    rows, columns = nearest.shape
    for s in range(len(warps)):
        slopes = warps[s]
        if not slopes.any():
            continue
        for row in range(rows):
            low, high = 0.0, columns - 1.0
            for k in range(4):
                rise, at = bounds[s, k, 0], bounds[s, k, 1] * row + bounds[s, k, 2]
                if rise > 0:
                    low = max(low, -at / rise)
                elif rise < 0:
                    high = min(high, -at / rise)
                elif at < 0:
                    high = -1.0
            if not low <= high:
                continue
            at = slopes[2, 1] * row + slopes[2, 2]
            for column in range(int(np.ceil(low)), int(np.floor(high)) + 1):
                nearness = slopes[2, 0] * column + at
                if nearness > nearest[row, column]:
                    nearest[row, column] = nearness
                    seen[row, column] = s


@kernel()
def _shade(warps, seen, pictures, tiles, gains, texels, starts, sizes, image):
    """Write the grey value of each pixel; where surfaces meet, the mean of its four quarters."""
    rows, columns = image.shape
    for row in range(rows):
        for column in range(columns):
            s = seen[2 * row, 2 * column]
            plain = (
                seen[2 * row, 2 * column + 1] == s
                and seen[2 * row + 1, 2 * column] == s
                and seen[2 * row + 1, 2 * column + 1] == s
            )
            total, parts = 0.0, 1 if plain else 4
            for k in range(parts):
                u, v = float(column), float(row)
                if not plain:
                    s = seen[2 * row + k // 2, 2 * column + k % 2]
                    u, v = u + 0.5 * (k % 2) - 0.25, v + 0.5 * (k // 2) - 0.25
                if s >= 0:
                    grey = _grey(warps, s, u, v, tiles, texels, starts, sizes, pictures[s])
                    total += gains[s] * grey
            image[row, column] = total / parts


@kernel()
def _grey(warps, s, u, v, tiles, texels, starts, sizes, picture):
    """Mean of a picture over a pixel: probes along the longer side of the pixel's footprint, each
    bilinear in the two copies of which a texel is about as large as its shorter side.
    """
    w = warps[s, 2, 0] * u + warps[s, 2, 1] * v + warps[s, 2, 2]
    a = (warps[s, 0, 0] * u + warps[s, 0, 1] * v + warps[s, 0, 2]) / w
    b = (warps[s, 1, 0] * u + warps[s, 1, 1] * v + warps[s, 1, 2]) / w
    wide, high = tiles[s, 0] * sizes[picture, 0, 1], tiles[s, 1] * sizes[picture, 0, 0]
    au = wide * (warps[s, 0, 0] - a * warps[s, 2, 0]) / w  # texels from a pixel to the next
    av = wide * (warps[s, 0, 1] - a * warps[s, 2, 1]) / w
    bu = high * (warps[s, 1, 0] - b * warps[s, 2, 0]) / w
    bv = high * (warps[s, 1, 1] - b * warps[s, 2, 1]) / w
    longer, shorter = np.sqrt(au * au + bu * bu), np.sqrt(av * av + bv * bv)
    if longer < shorter:
        longer, shorter, au, bu = shorter, longer, av, bv
    # what has no footprint, NaN, has one probe of the finest copy: so stand the arguments
    probes = int(min(float(_PROBES), max(1.0, np.ceil(longer / max(1.0, shorter)))))
    level = min(starts.shape[1] - 1.0, np.log2(max(1.0, longer / probes, shorter)))
    total = 0.0
    for at in range(int(level), min(int(level) + 2, starts.shape[1])):
        share = 1.0 - abs(level - at)
        rows, columns, begin = sizes[picture, at, 0], sizes[picture, at, 1], starts[picture, at]
        down, across = rows / sizes[picture, 0, 0], columns / sizes[picture, 0, 1]
        for k in range(probes):
            along = (k + 0.5) / probes - 0.5
            i = (high * b + along * bu) * down - 0.5
            j = (wide * a + along * au) * across - 0.5
            top, left = int(np.floor(i)), int(np.floor(j))
            i, j, below, right = i - top, j - left, top + 1, left + 1
            if tiles[s, 1] == 1.0:
                top, below = min(max(top, 0), rows - 1), min(max(below, 0), rows - 1)
            if tiles[s, 0] == 1.0:
                left, right = min(max(left, 0), columns - 1), min(max(right, 0), columns - 1)
            top, below = (
                begin + (top & (rows - 1)) * columns,
                begin + (below & (rows - 1)) * columns,
            )
            left, right = left & (columns - 1), right & (columns - 1)
            upper = (1 - j) * texels[top + left] + j * texels[top + right]
            lower = (1 - j) * texels[below + left] + j * texels[below + right]
            total += share * ((1 - i) * upper + i * lower)
    return total / probes
