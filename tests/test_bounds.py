"""Compiled kernels with numba's own check of every index, in a cache of their own."""

import os
import subprocess
import sys
from dataclasses import dataclass, fields, replace
from pathlib import Path

import numpy as np
import pytest
from numba import njit

from data_synth import fisheye
from data_synth.coloured import canvas
from robot_perception.appearance import segmentation
from robot_perception.particles import systematic
from tests.hostile.calls import arms
from tests.hostile.calls import data_synth as worlds
from tests.hostile.fields import leaves, wrong_fields
from tests.unchecked import unchecked

ROOT = Path(__file__).parents[1]
ROOMS = sorted(p.stem for p in (ROOT / "tests" / "hostile" / "calls").glob("[!_]*.py"))
KERNELS = (
    *("tests/test_particles.py", "tests/test_gating.py", "tests/test_fusion.py"),
    *("tests/data_synth/test_fisheye.py", "tests/data_synth/test_stereo.py", "tests/walls"),
    *("tests/landmarks", "tests/appearance", "tests/slam", "tests/test_bounds.py"),
)


@pytest.fixture(scope="module")
def checked(tmp_path_factory):
    """Return a function that runs a module of Python with numba's check of every index."""
    cache = str(tmp_path_factory.mktemp("compiled"))
    environment = os.environ | {"NUMBA_BOUNDSCHECK": "1", "NUMBA_CACHE_DIR": cache}

    def run(*arguments: str) -> subprocess.CompletedProcess:
        command = [sys.executable, "-m", *arguments]
        return subprocess.run(command, env=environment, cwd=ROOT, capture_output=True, text=True)

    return run


@pytest.mark.slow  # everything is compiled anew
def test_no_kernel_leaves_an_array(checked):
    done = checked("pytest", "-q", "-m", "not slow", "-p", "no:cacheprovider", *KERNELS)
    assert done.returncode == 0, done.stdout[-3000:]


@pytest.mark.slow  # likewise; `make check` asks for the rooms that a change reaches
@pytest.mark.parametrize("room", ROOMS)
def test_nothing_that_is_handed_over_lets_a_kernel_leave_an_array(room, checked):
    done = checked("tests.hostile.fields", room)
    assert done.returncode == 0, done.stderr[-3000:]  # the interpreter has not ended
    assert not done.stdout, done.stdout[-3000:]


def test_an_index_outside_is_told_from_numpy_s():
    @njit(boundscheck=True)
    def entry(values: np.ndarray, index: int) -> float:
        return values[index]

    for reads, told in ((entry, True), (np.ndarray.__getitem__, False)):
        with pytest.raises(IndexError) as error:
            reads(np.ones(3), 3)
        assert leaves(error.value) == told


HANDED = [
    *(arms.SEEN, arms.CONTOURS, arms.SURFACE, worlds.SCENE, worlds.SCENE.atlas),
    *(worlds.SMALL.stage, worlds.shown()),
]


@pytest.mark.parametrize("thing", HANDED, ids=lambda thing: type(thing).__name__)
def test_what_kernels_read_is_refused_where_an_array_of_it_is_too_short(thing):
    arrays = {f.name: getattr(thing, f.name) for f in fields(thing)}
    arrays = {k: v for k, v in arrays.items() if isinstance(v, np.ndarray)}
    assert len(arrays) > 1
    for name, value in arrays.items():
        for wrong in ([np.delete(value, -1, axis) for axis in range(value.ndim)], [value[None]]):
            for short in wrong:
                with unchecked(), pytest.raises(ValueError, match=" must "):
                    replace(thing, **{name: short})
        with unchecked(), pytest.raises(TypeError, match=f"{name} must"):
            replace(thing, **{name: value.astype(str)})


@pytest.mark.parametrize(
    "thing", [*HANDED[3:], worlds.says()], ids=lambda thing: type(thing).__name__
)
@pytest.mark.parametrize("far", [-(2**62), -2, 2**15, 2**31, 2**62])
def test_a_place_that_there_is_not_is_refused(thing, far):
    for field in fields(thing):
        places = getattr(thing, field.name)
        if isinstance(places, np.ndarray) and places.dtype == np.int64 and field.name != "seeds":
            outside = np.append(places.ravel()[:-1], far).reshape(places.shape)
            with unchecked(), pytest.raises(ValueError, match=" must "):
                replace(thing, **{field.name: outside})


@dataclass
class Inner:
    values: np.ndarray
    places: np.ndarray

    def __post_init__(self) -> None:
        if len(self.values) != len(self.places):
            raise ValueError("values must be as many as places")


@dataclass
class Outer:
    inner: tuple[Inner, ...]


def test_objects_are_replaced_field_by_field_where_they_let_themselves():
    made = dict(wrong_fields(Outer((Inner(np.ones((2, 3)), np.zeros(2, dtype=int)),))))
    assert made[".inner[0].places=last 1000"].inner[0].places.tolist() == [0, 1000]
    assert np.isnan(made[".inner[0].values=all nan"].inner[0].values).all()
    assert made[".inner[0].values=shorter along axis 1"].inner[0].values.shape == (2, 2)
    assert ".inner[0].values=shorter along axis 0" not in made
    assert made[".inner=None"].inner is None


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
