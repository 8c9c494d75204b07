"""Paths in space, and the files in which benchmarks hold them."""

from pathlib import Path

import numpy as np
from scipy.spatial.transform import Rotation

from robot_perception.geometry import se3


def path_in_space(rng: np.random.Generator, k: int = 40) -> tuple[np.ndarray, np.ndarray]:
    """Return rising times and poses of a body that wanders and tumbles."""
    times = 1.4e9 + np.cumsum(rng.uniform(0.04, 0.06, k)).round(6)
    return times, se3.exp(np.cumsum(rng.normal(scale=0.3, size=(k, 6)), axis=0))


def write_path(path: Path, kind: str, times: np.ndarray, poses: np.ndarray) -> Path:
    """Write a path in a format of `read_space_track`."""
    turns, at = Rotation.from_matrix(poses[:, :3, :3]).as_quat(), poses[:, :3, 3]
    if kind == "TUM":
        np.savetxt(path, np.column_stack([times, at, turns]), fmt="%.12f")
    elif kind == "KITTI":
        np.savetxt(path, poses[:, :3].reshape(-1, 12), fmt="%.12e")
    elif kind == "space":
        names = "time_s,x_m,y_m,z_m,qx,qy,qz,qw,note"
        rows = np.column_stack([times, at, turns, np.zeros(len(times))])
        np.savetxt(path, rows, fmt="%.12f", delimiter=",", header=names, comments="")
    else:
        names = "#timestamp [ns],p_RS_R_x [m],p_RS_R_y [m],p_RS_R_z [m],q_RS_w [],q_RS_x [],"
        names += "q_RS_y [],q_RS_z [],v_RS_R_x [m s^-1]"
        nanoseconds = [f"{round(t * 1e6)}000" for t in times]
        rows = np.column_stack([at, np.roll(turns, 1, axis=1), np.zeros(len(times))])
        lines = [
            ",".join([t, *(f"{v:.12f}" for v in row)])
            for t, row in zip(nanoseconds, rows, strict=True)
        ]
        path.write_text("\n".join([names, *lines]) + "\n")
    return path
