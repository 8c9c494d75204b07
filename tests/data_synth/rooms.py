"""What tests of textured buildings ask of each: what stands in the way, and where its walls are."""

from typing import Any

import numpy as np
import shapely

from data_synth.laser import cast
from data_synth.stereo import Rig, surface_points


def standing(building: Any) -> shapely.MultiLineString:
    """Return the feet of all upright surfaces that reach below the robot's top."""
    frames = building.scene.frames
    upright = np.abs(frames[:, 2, 1]) > 0
    low = upright & (frames[:, 2, 2] + frames[:, 2, 1] < 1.0)
    ends = np.stack([frames[low, :2, 2], frames[low, :2, 2] + frames[low, :2, 0]], axis=1)
    return shapely.MultiLineString(list(ends))


def walls_where_a_laser_finds_them(building: Any, poses: np.ndarray) -> int:
    """Assert that level rays meet walls where the laser's own geometry does; count those rays."""
    rig = Rig()
    columns = np.arange(0.0, 320.0, 4.0)
    pixels = np.stack([columns, np.full(len(columns), rig.centre_px[1])], axis=-1)  # level rays
    met = 0
    for pose in poses:
        found = surface_points(building.scene, rig, pose, pixels)
        angles = pose[2] - np.arctan((columns - rig.centre_px[0]) / rig.focal_px)
        distance, _ = cast(pose[:2], angles, building.plan)
        away = np.hypot(*(found.points[:, :2] - pose[:2]).T)
        wall = building.kinds[found.surfaces] == "wall"
        np.testing.assert_allclose(away[wall], distance[wall], rtol=1e-6)
        assert (away <= distance + 1e-6).all()
        met += int(wall.sum())
    return met
