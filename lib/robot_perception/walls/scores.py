"""Agreement of a wall map with a floor plan, and with the readings it was made from."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float

from robot_perception.checks import array, instance, not_negative, shown
from robot_perception.geometry import wrap_angle
from robot_perception.walls.wall_map import WallMap

_STEP = 0.05  # spacing of the samples along walls, m


@dataclass(frozen=True, eq=False, slots=True)
class MapScore:
    """Agreement of a map with a floor plan.

    Parameters
    ----------
    precision
        Share of the length of the map that lies on a face of the plan.
    recall
        Share of the length of the faces that lies on a wall of the map.
    offsets
        Distance of each matched wall from its face at the middle of the wall, towards the
        scanner's side negative, m.
    angles
        Difference of direction of each matched wall, rad.
    """

    precision: float
    recall: float
    offsets: Float[np.ndarray, " matched"]
    angles: Float[np.ndarray, " matched"]

    @property
    def rms_offset(self) -> float:
        """Root mean square of the offsets, m."""
        return float(np.sqrt(np.mean(self.offsets**2)))

    @property
    def rms_angle(self) -> float:
        """Root mean square of the differences of direction, rad."""
        return float(np.sqrt(np.mean(self.angles**2)))


def score_map(
    walls: WallMap,
    faces: Float[np.ndarray, "faces 2 2"],
    seen: Bool[np.ndarray, " samples"] | None = None,
    *,
    reach: float = 0.05,
    turn: float = np.deg2rad(5.0),
) -> MapScore:
    """Compare a map with the faces of a floor plan.

    Both are cut into samples 5 cm apart. A sample of the map is right if a face of nearly the same
    direction and the same front passes within ``reach``, and a sample of a face is found if such
    a wall does.

    Parameters
    ----------
    walls
        The map.
    faces
        Ends of each face, the free space to the left of the way from the first to the second, m.
    seen
        Which samples of the faces (see :func:`sample_faces`) count for recall; all by default.
    reach
        Largest distance, m.
    turn
        Largest difference of direction, rad.

    Raises
    ------
    ValueError
        If the map or the plan is empty, the samples seen are not those of the faces, or a limit is
        negative.
    """
    instance("walls", walls, WallMap)
    faces = array("faces", faces, ("faces", 2, 2))
    reach = not_negative("reach", reach)
    turn = not_negative("turn", turn)
    if len(walls) == 0 or len(faces) == 0:
        raise ValueError(f"nothing to compare: {len(walls)} walls, {len(faces)} faces")
    face_theta = _into_the_wall(faces)
    samples, owner = sample_faces(faces)
    seen = np.ones(len(samples), dtype=bool) if seen is None else np.asarray(seen)
    if seen.dtype != bool or seen.shape != (len(samples),) or not seen.any():
        raise ValueError(
            f"seen must say of each of {len(samples)} samples of faces whether it counts, and"
            f" one at least must, got {shown(seen)}"
        )
    points, wall = sample_faces(walls.ends)
    alike = np.abs(wrap_angle(walls.lines[:, 1, None] - face_theta)) <= turn
    near = distance_to_segments(points, faces)
    right = ((near <= reach) & alike[wall]).any(axis=1)
    found = (distance_to_segments(samples, walls.ends) <= reach) & alike[:, owner].T
    middles = walls.ends.mean(axis=1)
    distance = np.where(alike, distance_to_segments(middles, faces), np.inf)
    best = distance.argmin(axis=1)
    matched = np.flatnonzero(distance.min(axis=1) <= reach)
    theta, foot = face_theta[best[matched]], faces[best[matched], 0]
    normal = np.stack([np.cos(theta), np.sin(theta)], axis=-1)
    return MapScore(
        precision=float(right.mean()),
        recall=float(found.any(axis=1)[seen].mean()),
        offsets=((middles[matched] - foot) * normal).sum(axis=-1),
        angles=wrap_angle(walls.lines[matched, 1] - theta),
    )


def sample_faces(
    faces: Float[np.ndarray, "faces 2 2"],
) -> tuple[Float[np.ndarray, "samples 2"], np.ndarray]:
    """Return points every 5 cm along segments, and to which segment each belongs."""
    faces = array("faces", faces, ("faces", 2, 2))
    lengths = np.linalg.norm(faces[:, 1] - faces[:, 0], axis=-1)
    counts = np.maximum(1, np.round(lengths / _STEP).astype(int))
    owner = np.repeat(np.arange(len(faces)), counts)
    position = np.arange(counts.sum()) - np.repeat(np.cumsum(counts) - counts, counts)
    share = (position + 0.5) / counts[owner]
    return faces[owner, 0] + share[:, None] * (faces[owner, 1] - faces[owner, 0]), owner


def distance_to_segments(
    points: Float[np.ndarray, "points 2"], segments: Float[np.ndarray, "segments 2 2"]
) -> Float[np.ndarray, "points segments"]:
    """Return the distance of each point from each segment (not its line), m."""
    points, segments = array("points", points, ("n", 2)), array("segments", segments, ("m", 2, 2))
    start, along = segments[:, 0], segments[:, 1] - segments[:, 0]
    squared = np.maximum((along**2).sum(axis=-1), np.finfo(float).tiny)
    arm = points[:, None] - start
    share = np.clip((arm * along).sum(axis=-1) / squared, 0.0, 1.0)
    return np.linalg.norm(arm - share[..., None] * along, axis=-1)


def explained(
    points: Float[np.ndarray, "points 2"], walls: WallMap, distance: float
) -> Bool[np.ndarray, " points"]:
    """Say which readings lie within a distance of some wall of the map."""
    points = array("points", points, ("points", 2))
    instance("walls", walls, WallMap)
    distance = not_negative("distance", distance)
    result = np.zeros(len(points), dtype=bool)
    for block in np.array_split(np.arange(len(points)), max(1, len(points) // 20_000)):
        near = distance_to_segments(points[block], walls.ends) <= distance
        result[block] = near.any(axis=1)
    return result


def _into_the_wall(faces: np.ndarray) -> np.ndarray:
    """Direction of the normal that points away from the free space, right of the face, rad."""
    along = faces[:, 1] - faces[:, 0]
    return np.arctan2(-along[:, 0], along[:, 1])
