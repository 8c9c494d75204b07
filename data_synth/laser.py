"""A SICK-like laser scanner in a world of straight faces."""

from dataclasses import dataclass

import numpy as np

from data_synth._checks import array, generator, instance, number, reals, whole


@dataclass(frozen=True, slots=True)
class Scanner:
    """A scanner that sweeps half a turn.

    Parameters
    ----------
    beams
        Beams from -90° to 90°, both included: 181 for 1°, 361 for 0.5°.
    range_sigma
        Standard deviation of a range, m.
    max_range
        Beyond it nothing comes back, m.
    resolution
        Readings are rounded to multiples of it, m; 0 for none.
    spot
        Half the opening angle of a beam, rad. A beam that meets two surfaces at once reports a
        range between them (a mixed pixel).
    dropout
        Share of readings lost for no reason.
    """

    beams: int = 361
    range_sigma: float = 0.015
    max_range: float = 12.0
    resolution: float = 0.01
    spot: float = np.deg2rad(0.25)
    dropout: float = 0.002

    def __post_init__(self) -> None:
        whole("beams", self.beams, 2, 10**6)
        number("range_sigma", self.range_sigma, 0.0)
        number("max_range", self.max_range, above=0.0, finite=False)
        number("resolution", self.resolution, 0.0)
        number("spot", self.spot, 0.0, np.pi / 2)
        number("dropout", self.dropout, 0.0, 1.0)

    @property
    def angles(self) -> np.ndarray:
        """Directions of the beams in the frame of the scanner, rad."""
        return np.linspace(-np.pi / 2, np.pi / 2, self.beams)


@dataclass(frozen=True, eq=False, slots=True)
class Scans:
    """Readings and what they are readings of.

    Parameters
    ----------
    ranges
        Readings (scans, beams), m; infinite where nothing came back.
    true_ranges
        Distances along the middle of each beam, m, infinite where there is nothing.
    faces
        Index of the face hit by the middle of each beam, -1 for none.
    mixed
        Which readings are mixed pixels.
    """

    ranges: np.ndarray
    true_ranges: np.ndarray
    faces: np.ndarray
    mixed: np.ndarray


@dataclass(frozen=True, eq=False, slots=True)
class Sight:
    """Points that the beams of some scans meet, before noise.

    Parameters
    ----------
    distances
        Distances along the left rim, the middle and the right rim of each beam
        (scans, beams, 3), m, infinite where there is nothing.
    faces
        Index of the face met, (scans, beams, 3), -1 for none.
    """

    distances: np.ndarray
    faces: np.ndarray


def cast(
    origins: np.ndarray, directions: np.ndarray, faces: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Return the distance along rays to the nearest face, and which face it is.

    Parameters
    ----------
    origins : (rays, 2) or (2,)
        Where the rays start, m.
    directions : (rays,)
        Their directions, rad.
    faces : (faces, 2, 2)
        Ends of the faces, m.

    Returns
    -------
    distances, indices
        Infinite and -1 where a ray meets nothing.

    Raises
    ------
    ValueError
        If there is no face, or the shapes are not as they should be.
    """
    faces, directions = (
        array("faces", faces, (None, 2, 2)),
        array("directions", directions, (None,)),
    )
    origins = reals("origins", origins)
    if not len(faces):
        raise ValueError("faces must be one at least, got none")
    if origins.shape not in ((2,), (len(directions), 2)) or not np.isfinite(origins).all():
        raise ValueError(
            f"origins must be finite, one or one for each of {len(directions)} directions,"
            f" got {origins.shape}"
        )
    ray = np.stack([np.cos(directions), np.sin(directions)], axis=-1)[:, None]
    start, along = faces[:, 0], faces[:, 1] - faces[:, 0]
    arm = start - np.broadcast_to(origins, (len(directions), 2))[:, None]
    area = ray[..., 0] * along[:, 1] - ray[..., 1] * along[:, 0]
    with np.errstate(divide="ignore", invalid="ignore"):
        distance = (arm[..., 0] * along[:, 1] - arm[..., 1] * along[:, 0]) / area
        share = (arm[..., 0] * ray[..., 1] - arm[..., 1] * ray[..., 0]) / area
    hit = (area != 0) & (distance > 1e-9) & (share >= 0) & (share <= 1)
    distance = np.where(hit, distance, np.inf)
    nearest = distance.argmin(axis=1)
    distances = distance[np.arange(len(nearest)), nearest]
    return distances, np.where(np.isfinite(distances), nearest, -1)


def scan(
    faces: np.ndarray, poses: np.ndarray, scanner: Scanner, *, rng: np.random.Generator
) -> Scans:
    """Return the scans taken from the poses by a scanner that stands still while it scans."""
    return measure(sight(faces, poses, scanner), scanner, rng=rng)


def sight(
    faces: np.ndarray, poses: np.ndarray, scanner: Scanner, *, reach: float = np.inf
) -> Sight:
    """Return what the beams meet from the poses: the costly part, the same for every noise.

    Parameters
    ----------
    faces : (faces, 2, 2)
        Ends of the faces, m.
    poses : (scans, 3)
        Where the scanner is, m and rad.
    scanner
        The scanner.
    reach
        Faces farther away than that are left out, which saves time, m.
    """
    instance("scanner", scanner, Scanner)
    faces = array("faces", faces, (None, 2, 2))
    poses = reals("poses", poses)
    poses = array("poses", poses[None] if poses.ndim == 1 else poses, (None, 3))
    reach = number("reach", reach, 0.0, finite=False)
    beam_poses = np.broadcast_to(poses[:, None], (len(poses), scanner.beams, 3))
    return _sight(faces, beam_poses, scanner, reach)


def scan_moving(
    faces: np.ndarray,
    pose: np.ndarray,
    velocity: tuple[float, float],
    duration: float,
    scanner: Scanner,
    *,
    rng: np.random.Generator,
) -> Scans:
    """Return one scan taken on the move, beam after beam.

    Parameters
    ----------
    faces, scanner
        As of `sight`.
    pose : (3,)
        Where the scanner is when the sweep begins, m and rad.
    velocity
        Forward speed and turn rate, m/s and rad/s.
    duration
        Time of the sweep, s.
    rng
        Source of noise.
    """
    instance("scanner", scanner, Scanner)
    faces, pose = array("faces", faces, (None, 2, 2)), array("pose", pose, (3,))
    velocity = array("velocity", velocity, (2,))
    duration = number("duration", duration, 0.0, 1e6)
    time = np.linspace(0.0, duration, scanner.beams)
    heading = pose[2] + velocity[1] * time
    step = velocity[0] * duration / (scanner.beams - 1)
    x = pose[0] + np.r_[0.0, np.cumsum(step * np.cos(heading[:-1]))]
    y = pose[1] + np.r_[0.0, np.cumsum(step * np.sin(heading[:-1]))]
    seen = _sight(faces, np.stack([x, y, heading], axis=-1)[None], scanner)
    return measure(seen, scanner, rng=rng)


def _sight(faces: np.ndarray, poses: np.ndarray, scanner: Scanner, reach: float = np.inf) -> Sight:
    shape = poses.shape[:2]
    offsets = scanner.spot * np.array([-1.0, 0.0, 1.0])
    directions = poses[..., 2] + scanner.angles
    distances, index = np.empty((*shape, 3)), np.empty((*shape, 3), dtype=int)
    along = faces[:, 1] - faces[:, 0]
    squared = np.maximum((along**2).sum(axis=-1), np.finfo(float).tiny)
    for k in range(shape[0]):
        near = np.arange(len(faces))
        if np.isfinite(reach):
            arm = poses[k, 0, :2] - faces[:, 0]
            share = ((arm * along).sum(axis=-1) / squared).clip(0, 1)
            near = np.flatnonzero(np.hypot(*(arm - share[:, None] * along).T) <= reach)
        if not near.size:
            distances[k], index[k] = np.inf, -1
            continue
        for side, offset in enumerate(offsets):
            distances[k, :, side], hit = cast(poses[k, :, :2], directions[k] + offset, faces[near])
            index[k, :, side] = np.where(hit < 0, -1, near[hit])
    return Sight(distances, index)


def measure(sight: Sight, scanner: Scanner, *, rng: np.random.Generator) -> Scans:
    """Return the readings of a scanner: mixed pixels, noise, rounding, dropouts."""
    instance("sight", sight, Sight)
    instance("scanner", scanner, Scanner)
    generator(rng)
    distances, index = sight.distances, sight.faces
    shape = distances.shape[:2]
    true, face = distances[..., 1], index[..., 1]
    near, far = distances.min(axis=-1), distances.max(axis=-1)
    # a spot on one tilted surface has a spread too; two surfaces are told by a clear step
    spread = np.subtract(far, near, out=np.zeros(shape), where=np.isfinite(far))
    step = spread > 0.1 + 0.05 * near
    step &= (index[..., 0] != index[..., 1]) | (index[..., 2] != index[..., 1])
    share = rng.uniform(size=shape)
    blended = near + share * spread
    ranges = np.where(step, blended, true) + rng.normal(0.0, scanner.range_sigma, shape)
    if scanner.resolution > 0:
        ranges = np.round(ranges / scanner.resolution) * scanner.resolution
    lost = (rng.uniform(size=shape) < scanner.dropout) | (ranges > scanner.max_range)
    ranges = np.where(lost | ~np.isfinite(true), np.inf, np.maximum(ranges, 0.01))
    return Scans(ranges, true, face, step)
