"""Compiled kernels with numba's own check of every index, in a cache of their own."""

import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from data_synth import fisheye
from data_synth.coloured import canvas
from robot_perception.appearance import segmentation
from robot_perception.particles import systematic

KERNELS = (
    "tests/hostile/test_hostile.py::test_the_ends_of_floating_point_end_in_no_foreign_error",
    *("tests/test_particles.py", "tests/test_gating.py", "tests/test_fusion.py"),
    *("tests/data_synth/test_fisheye.py", "tests/data_synth/test_stereo.py", "tests/walls"),
    *("tests/landmarks", "tests/appearance", "tests/slam", "tests/test_bounds.py"),
)


@pytest.mark.slow  # everything is compiled anew
def test_no_kernel_leaves_an_array(tmp_path):
    environment = os.environ | {"NUMBA_BOUNDSCHECK": "1", "NUMBA_CACHE_DIR": str(tmp_path)}
    command = [sys.executable, "-m", "pytest", "-q", "-m", "not slow", "-p", "no:cacheprovider"]
    done = subprocess.run(
        [*command, *KERNELS],
        env=environment,
        cwd=Path(__file__).parents[1],
        capture_output=True,
        text=True,
    )
    assert done.returncode == 0, done.stdout[-3000:]


@pytest.mark.parametrize("bright", [1e31, 1e200, 1e308, -1e308])
def test_light_beyond_all_lamps_is_refused(bright):
    eye = fisheye.Fisheye(size=16, focal_px=4.5)
    with pytest.raises(ValueError, match=r"light must be within 1e\+30, got 1e\+"):
        fisheye.expose(eye, np.full((16, 16, 3), bright), 1.0, rng=np.random.default_rng(0))


def test_kernels_take_what_is_no_number_for_an_end_of_their_arrays():
    light = np.full((2, 2, 3), np.nan, dtype=np.float32)
    image, ones = np.empty(light.shape, dtype=np.uint8), np.ones((2, 2), dtype=np.float32)
    table = np.arange(7, 11, dtype=np.uint8)
    fisheye._develop(light, ones, 1.0, 0.1, 0.1, np.ones_like(light), table, image)
    assert (image == 7).all()
    for wrong in (np.nan, np.inf, -np.inf, 1e308):
        outline = np.array([[0.0, 0], [wrong, 4], [3, wrong], [-wrong, 2]])
        segmentation._fill(outline, np.zeros((5, 5), dtype=bool))
        canvas._fill(outline, 0, 0, 4, np.zeros((5, 5), dtype=np.float32))
        canvas._draw(outline, np.ones(4), 0, 0, np.zeros((5, 5), dtype=np.float32))


def test_a_comb_stays_in_its_places_where_the_sum_of_weights_is_the_largest_number():
    weights = np.full(1000, np.finfo(float).max / 1000)
    assert (np.bincount(systematic(weights, 5000, rng=np.random.default_rng(0))) == 5).all()
