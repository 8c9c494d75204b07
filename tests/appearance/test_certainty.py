"""A disc on a wall: what is seen at an outline round it, beside it, too large, after a change."""

import numpy as np
import pytest

from robot_perception.appearance.certainty import CertaintyRules, certainty, original
from robot_perception.appearance.colour_spaces import Binning
from robot_perception.appearance.segmentation import filled

TURN = np.linspace(0, 2 * np.pi, 60, endpoint=False)
RING = np.stack([np.cos(TURN), np.sin(TURN)], axis=-1)
RED, BLUE, GREY = (200, 40, 40), (40, 40, 200), (120, 120, 120)
PLAIN = CertaintyRules(bias=-2.0, match=1.0, apart=2.0, growth=-4.0)


def ring(u: float = 60, v: float = 50, radius: float = 20) -> np.ndarray:
    return [u, v] + radius * RING


def disc(colour=RED, at=(60, 50), radius: float = 20) -> np.ndarray:
    """Return a picture of a disc of one colour before a grey wall."""
    picture = np.full((100, 140, 3), GREY, np.uint8)
    picture[filled(ring(*at, radius), picture.shape[:2])] = colour
    return picture


def flag(at=(60, 50), radius: float = 20) -> np.ndarray:
    """Return a picture of a disc that is red on the left and blue on the right."""
    picture = disc(RED, at, radius)
    blue = filled(ring(*at, radius), picture.shape[:2])
    blue[:, : at[0]] = False
    picture[blue] = BLUE
    return picture


CASES = {  # a picture at first, one now, an outline; match, apart, growth
    "as at first": (disc(), disc(), ring(), (1, 1, 0)),
    "on the wall": (disc(), disc(), ring(110, 50), (0, 0, 0)),
    "where it went": (disc(), disc(at=(80, 45)), ring(80, 45), (1, 1, 0)),
    "another thing": (disc(), disc(BLUE), ring(), (0, 1, 0)),
    "half outside": (disc(), disc(at=(0, 50)), ring(0, 50), (1, 1, 0)),
    "twice too large": (disc(), disc(), ring(radius=40), (0.25, 0.25, np.log(2))),
    "within": (disc(), disc(), ring(radius=10), (1, 0, -np.log(2))),
    "slid to the side": (disc(), disc(), ring(80, 50), (0, 0.14, 0)),  # the rim shows both
    "slid down": (disc(), disc(), ring(60, 70), (0, 0.14, 0)),
    "all gone": (disc(), disc(), ring(500, 500), (0, 0, 0)),
    "of two colours": (flag(), flag(), ring(), (1, 1, 0)),
    "turned round": (flag(), flag()[:, 120::-1], ring(), (0, 1, 0)),
}


@pytest.mark.parametrize("name", CASES)
def test_what_is_seen_at_an_outline(name):
    before, image, outline, (match, apart, growth) = CASES[name]
    found = certainty(np.ascontiguousarray(image), outline, original(before, ring(), PLAIN), PLAIN)
    assert found.match == pytest.approx(match, abs=0.05)
    assert found.apart == pytest.approx(apart, abs=0.05)
    assert found.growth == pytest.approx(growth, abs=0.01)
    told = -2 + found.match + 2 * found.apart - 4 * abs(found.growth)
    right = 1 / (1 + np.exp(-told)) if name != "all gone" else 0
    assert found.probability == pytest.approx(right)
    assert found.lost == (found.probability < 0.3)


def test_the_limit_decides_what_is_lost():
    first = original(disc(), ring())
    for least, lost in ((0.0, False), (1.0, True)):
        rules = CertaintyRules(bias=1.0, match=0, apart=0, growth=0, least=least)
        assert certainty(disc(), ring(), first, rules).lost == lost


def test_an_original_needs_pixels_and_its_own_cells():
    with pytest.raises(ValueError, match="outline must hold pixels of the image"):
        original(disc(), ring(500, 500))
    few = CertaintyRules(binning=Binning("opponent", (4, 4, 4)))
    with pytest.raises(ValueError, match=r"first\.halves must be \(4, 64\)"):
        certainty(disc(), ring(), original(disc(), ring()), few)
    with pytest.raises(ValueError, match="rim must rise from 1"):
        CertaintyRules(rim=(0.9, 2))


@pytest.mark.parametrize("shift", [7, 33])
def test_neither_where_an_outline_begins_nor_which_way_it_runs_matters(shift):
    first = original(disc(), ring(), PLAIN)
    turned = np.roll(ring(), shift, axis=0)[::-1]
    one, other = (certainty(disc(), line, first, PLAIN) for line in (ring(), turned))
    assert one.probability == pytest.approx(other.probability)
