"""Films below ceilings that are known, for the tests of those that drive there."""

from dataclasses import replace
from functools import lru_cache

import numpy as np

from data_synth.ceiling import CeilingCamera, Mount, make_ceiling
from robot_perception.ceiling.correction import Correction
from robot_perception.ceiling.mapping import MapInfo, Mapper, MapRules, MapState
from robot_perception.geometry import se2

MOUNT = Mount()
CENTRE = MOUNT.middle
SCALE = MOUNT.height / MOUNT.focal
TILTED = replace(MOUNT, roll=np.deg2rad(6), pitch=np.deg2rad(-5), x=0.15, y=-0.1)
BLANK = np.full(MOUNT.size[::-1], 128, np.uint8)
Run = tuple[tuple[MapState, MapInfo], ...]


@lru_cache
def camera(kind: str = "varied", seed: int = 3, mount: Mount = MOUNT) -> CeilingCamera:
    """Return the camera below a ceiling."""
    return CeilingCamera(make_ceiling(kind, rng=np.random.default_rng(seed), side=8.0), mount)


@lru_cache
def corrects(mount: Mount) -> Correction:
    """Return what makes the pictures of a mounted camera those of the ideal one."""
    level = np.array([0.0, 0.0, -1.0])
    parts = mount.K, mount.rotation, mount.translation, level, mount.height, mount.size
    return Correction(*parts, target=MOUNT.K)


def driven(count: int, ahead: float, turn: float) -> np.ndarray:
    """Return poses (count, 3) from the origin, each so far ahead of the last and turned."""
    path = [np.zeros(3)]
    for _ in range(count - 1):
        path.append(se2.compose(path[-1], np.array([ahead, 0.0, turn])))
    return np.array(path)


@lru_cache
def film(
    count: int = 14,
    ahead: float = 0.05,
    turn: float = 0.0,
    *,
    seed: int = 3,
    mount: Mount = MOUNT,
) -> np.ndarray:
    """Return the pictures (count, rows, columns) of a drive."""
    return np.array([camera("varied", seed, mount).image(p) for p in driven(count, ahead, turn)])


def mapped(
    pictures: np.ndarray,
    rules: MapRules | None = None,
    scale: float = SCALE,
    correction: Correction | None = None,
) -> Run:
    """Return states and what was seen in each picture, always from the same seed."""
    mapper = Mapper(scale, CENTRE, rules or MapRules(), correction)
    rng = np.random.default_rng(1)
    state, found = mapper.start(), []
    for picture in pictures:
        state, info = mapper.step(state, picture, rng=rng)
        found.append((state, info))
    return tuple(found)


@lru_cache
def run(count: int = 14, ahead: float = 0.05, turn: float = 0.0, *, seed: int = 3) -> Run:
    """Return what the rules as they are make of a drive."""
    return mapped(film(count, ahead, turn, seed=seed))
