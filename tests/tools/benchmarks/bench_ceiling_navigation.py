"""Navigation by the ceiling: pictures a second of mapper and navigator, and an adjustment."""

import numpy as np

from data_synth.ceiling import CeilingCamera, Mount, make_ceiling, taught_path
from robot_perception.ceiling.mapping import Mapper, MapState
from robot_perception.ceiling.mosaic import adjust
from robot_perception.ceiling.navigator import Navigator
from robot_perception.ceiling.visual_memory import KeyImage, KeyRules, choose_key_images
from robot_perception.geometry import se2
from tests.tools.benchmarks.harness import Row

MOUNT = Mount()
SCALE = MOUNT.height / MOUNT.focal
PICTURES = 40
LEAST = 20.0
"""Pictures a second: the paper asks for “near real time”."""


def _taught() -> tuple[list[np.ndarray], np.ndarray, list[MapState], list[dict]]:
    """Return pictures of a path, its poses, and what a mapper makes of each picture."""
    ceiling = make_ceiling("varied", rng=np.random.default_rng(7), side=10.0)
    eye, rng = CeilingCamera(ceiling, MOUNT), np.random.default_rng(8)
    path = taught_path("line", step=0.05)[:PICTURES] - np.array([1.0, 0.0, 0.0])
    images = [eye.image(pose) for pose in path]
    mapper = Mapper(SCALE, MOUNT.middle)
    state, states, sightings = mapper.start(), [], []
    for image in images:
        state, info = mapper.step(state, image, rng=rng)
        states.append(state)
        sightings.append(dict(info.sightings))
    return images, path, states, sightings


def rows() -> list[Row]:
    """Return the rows of the benchmark table that concern navigation by the ceiling."""
    images, path, states, sightings = _taught()
    mapper, last = Mapper(SCALE, MOUNT.middle), states[-1]
    chosen = choose_key_images(sightings, KeyRules(common=2))
    keys = [KeyImage(sightings[k]) for k in chosen]
    navigator = Navigator(keys, last.patterns, last.mosaic, MOUNT.middle, SCALE)
    begin = navigator.start(images[0], rng=np.random.default_rng(9))

    def mapped() -> MapState:
        rng, state = np.random.default_rng(8), states[0]
        for image in images[1:]:
            state, _ = mapper.step(state, image, rng=rng)
        return state

    def same_path() -> None:
        way, true = se2.between(states[0].pose, mapped().pose), se2.between(path[0], path[-1])
        assert np.hypot(*(way - true)[:2]) < 0.05

    def driven() -> tuple:
        rng, state, commands = np.random.default_rng(9), begin, []
        for image in images[1:]:
            state, info = navigator.step(state, image, rng=rng)
            commands.append(info.command)
        return state, commands

    def same_way() -> None:
        state, commands = driven()
        assert state.key >= len(keys) - 1
        assert np.abs([turn for _, turn in commands]).max() < 0.3  # the path is straight

    first = next(iter(last.mosaic.poses))
    return [
        Row(
            work=f"ceiling mosaic, {PICTURES - 1} images of 320 × 240: tracked, located, extended",
            ours=mapped,
            at_most=(PICTURES - 1) / LEAST,
            agree=same_path,
            repeats=3,
        ),
        Row(
            work=f"ceiling path driven again, {PICTURES - 1} images of 320 × 240",
            ours=driven,
            at_most=(PICTURES - 1) / LEAST,
            agree=same_way,
            repeats=3,
        ),
        Row(
            work=f"ceiling mosaic adjusted, {len(last.mosaic.poses)} patterns",
            ours=lambda: adjust(last.mosaic, last.links, fixed=first),
            at_most=0.1,
        ),
    ]
