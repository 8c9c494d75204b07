"""A full turn is a circle: what is seen does not depend on the beam at which a scan begins."""

from collections.abc import Callable

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from data_synth.laser import cast
from robot_perception.geometry import closes
from robot_perception.people import legs, sonar
from robot_perception.walls import (
    Extraction,
    LandmarkRules,
    RangeNoise,
    extract_segments,
    find_landmarks,
    find_poles,
)

BEAMS = 720
STEP = 2 * np.pi / BEAMS
BEHIND = -np.pi + STEP * np.arange(BEAMS)  # cut apart behind the scanner
ROOM = np.array([[-4, -3], [3, -3], [3, 1], [5, 1], [5, 4], [1, 4], [1, 3], [-4, 3], [-4, -3.0]])
SQUARE = np.array([[-2, -2], [3, -2], [3, 4], [-2, 4], [-2, -2.0]])
EXTRACTION = Extraction(RangeNoise(0.01), tolerance=0.05, least_length=0.25)
RULES = LandmarkRules(EXTRACTION)


def circle(centre: tuple[float, float], radius: float) -> np.ndarray:
    turn = np.linspace(0, -2 * np.pi, 91)
    return np.array(centre) + radius * np.stack([np.cos(turn), np.sin(turn)], axis=-1)


POLES = (circle((-2.0, 0.1), 0.15), circle((1.0, -2.0), 0.15))
LEGS = tuple(circle(at, 0.07) for at in ((-1.5, 0.15), (-1.5, -0.15), (0.2, 1.4), (-0.1, 1.4)))
SCENES = {  # nothing hides anything in a square, so that no break is in it
    "square": (SQUARE,),
    "empty": (ROOM,),
    "poles": (ROOM, *POLES),
    "people": (ROOM, *LEGS),
}


def look(*chains: np.ndarray, angles: np.ndarray = BEHIND) -> np.ndarray:
    """Return exact ranges of a full turn."""
    faces = np.concatenate([np.stack([c[:-1], c[1:]], axis=1) for c in chains])
    return cast(np.zeros(2), angles, faces)[0]


SIGHTS = {name: look(*things) for name, things in SCENES.items()}


def noisy(scene: str, seed: int) -> np.ndarray:
    """Return a scan of a scene with noise, and readings that are lost."""
    rng = np.random.default_rng(seed)
    ranges = SIGHTS[scene] + rng.normal(0, 0.01, BEAMS)
    return np.where(rng.random(BEAMS) < 0.005, np.inf, ranges)


def walls(ranges, angles):
    found, report = extract_segments(ranges, angles, EXTRACTION)
    unit = np.stack([np.cos(found.lines[:, 1]), np.sin(found.lines[:, 1])], axis=-1)
    return [found.lines[:, :1] * unit, found.ends, found.covs], report


def landmarks(ranges, angles):
    found, report = find_landmarks(ranges, angles, RULES)
    kinds = np.array([["concave", "convex", "pole"].index(kind) for kind in report.kinds])
    return [found.values, found.covs, kinds], (report.apart, report.flat, report.not_round)


def poles(ranges, angles):
    found, not_round = find_poles(ranges, angles, RULES)
    return [found.values, found.covs], not_round


def leg_segments(ranges, angles):
    first, last = legs.segments(ranges, angles).T
    return [np.stack([np.cos(angles), np.sin(angles)], 1)[k] for k in (first, last)], None


def leg_profiles(ranges, angles):
    found = legs.profiles(ranges, angles)
    shown = (found.middles, found.widths, found.deviations, found.bulges, found.free)
    return [*shown, legs.are_legs(found)], None


def pairs_of_legs(ranges, angles):
    found = legs.detect(ranges, angles)
    (r, phi) = found.mean.T
    return [np.stack([r * np.cos(phi), r * np.sin(phi)], 1), found.cov], None


def sonars(ranges, angles):
    cones = ranges.reshape(24, -1).min(axis=1)
    found = sonar.detect(cones, angles[:: BEAMS // 24], 0.25)
    (r, phi) = found.mean.T
    return [np.stack([r * np.cos(phi), r * np.sin(phi)], 1), found.cov], None


DETECTORS: dict[str, Callable] = {
    "walls": walls,
    "corners and poles": landmarks,
    "poles": poles,
    "segments": leg_segments,
    "profiles": leg_profiles,
    "legs": pairs_of_legs,
    "sonars": sonars,
}
GRAIN = {"sonars": BEAMS // 24}  # a ring begins at one of its sensors


def in_order(found: list[np.ndarray]) -> list[np.ndarray]:
    """Return what was found in an order that does not depend on where the scan begins."""
    x, y = found[0].T.round(6)
    order = np.lexsort((y, x))
    return [values[order] for values in found]


@pytest.mark.parametrize("scene", SCENES)
@pytest.mark.parametrize("name", DETECTORS)
@given(st.integers(0, 10**6), st.integers(1, BEAMS - 1))
@settings(max_examples=15, deadline=None)
def test_it_does_not_matter_at_which_beam_a_turn_begins(name, scene, seed, shift):
    shift -= shift % GRAIN.get(name, 1)
    ranges, angles = noisy(scene, seed), BEHIND
    expected, account = DETECTORS[name](ranges, angles)
    found, told = DETECTORS[name](np.roll(ranges, -shift), angles + shift * STEP)
    assert told == account
    assert len(found[0]) == len(expected[0])
    for here, there in zip(in_order(found), in_order(expected), strict=True):
        np.testing.assert_allclose(here, there, atol=1e-6)


def test_something_is_there_to_be_found():
    counts = {
        (name, scene): len(DETECTORS[name](SIGHTS[scene], BEHIND)[0][0])
        for name in DETECTORS
        for scene in SCENES
    }
    assert (counts["walls", "square"], counts["walls", "empty"]) == (4, 6)  # two are hidden
    assert (counts["corners and poles", "square"], counts["corners and poles", "empty"]) == (4, 4)
    assert counts["poles", "poles"] == counts["legs", "people"] == 2
    assert all(counts[name, "people"] for name in ("segments", "profiles", "sonars"))


@pytest.mark.parametrize("name", ["walls", "corners and poles", "poles", "legs"])
def test_a_turn_in_single_precision_whose_ends_point_alike_is_one_turn(name):
    """As robots send it: the last beam at the angle of the first, but for rounding."""
    first, last = np.float32(-np.pi), np.float32(np.pi)
    angles = float(first) + float((last - first) / np.float32(BEAMS - 1)) * np.arange(BEAMS)
    assert angles[-1] - angles[0] > 2 * np.pi
    ranges = look(*SCENES["people" if name == "legs" else "poles"], angles=angles)
    expected, _ = DETECTORS[name](ranges[:-1], angles[:-1])
    found, _ = DETECTORS[name](ranges, angles)
    assert len(found[0]) == len(expected[0])
    np.testing.assert_allclose(in_order(found)[0], in_order(expected)[0], atol=5e-3)


@pytest.mark.parametrize(
    ("name", "scene", "more"),
    [("walls", "empty", 1), ("segments", "empty", 1), ("poles", "poles", -1)],
)
def test_less_than_a_turn_ends_where_it_ends(name, scene, more):
    """The wall behind the scanner is two, the pole there has nothing on one side."""
    whole, _ = DETECTORS[name](SIGHTS[scene], BEHIND)
    found, _ = DETECTORS[name](SIGHTS[scene][1:-1], BEHIND[1:-1])
    assert len(found[0]) == len(whole[0]) + more


@pytest.mark.parametrize(
    ("angles", "is_turn"),
    [
        (np.linspace(-np.pi, np.pi, 361), True),
        (np.linspace(-np.pi, np.pi, 360, endpoint=False), True),
        (np.linspace(0, 2 * np.pi, 8, endpoint=False), True),
        (np.linspace(-np.pi, np.pi, 361)[1:-1], False),
        (np.linspace(-np.pi / 2, np.pi / 2, 361), False),
        (np.linspace(-2.35, 2.35, 1081), False),
        (np.array([-np.pi, np.pi]), False),
        (np.empty(0), False),
    ],
)
def test_a_scan_closes_where_its_ends_are_neighbours(angles, is_turn):
    assert closes(angles) is is_turn


@given(st.integers(3, 2000), st.floats(-10, 10), st.booleans())
def test_a_turn_closes_wherever_it_begins(beams, first, doubled):
    assert closes(first + 2 * np.pi / (beams - doubled) * np.arange(beams)) or beams == 3
