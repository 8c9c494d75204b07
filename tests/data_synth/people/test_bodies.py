"""Bodies: legs by closed forms, skin of one pigment, and who hides whose legs."""

import numpy as np
import pytest

from data_synth.laser import Scanner
from data_synth.outlines import cast_outlines
from data_synth.people import Person, legs, make_person, skin
from data_synth.people.bodies import figures

PERSON = Person(stance=0.24, leg=(0.07, 0.06))
AHEAD = np.array([2.0, 0.0])
NO_FACE = np.zeros((0, 2, 2))


def beams(ellipses):
    """Which ellipse each beam of a scan from the origin meets."""
    angles = Scanner(beams=181).angles
    _, met, _ = cast_outlines(np.zeros((181, 2)), angles, NO_FACE, ellipses)
    return met


@pytest.mark.parametrize("heading", [0.0, 0.8, -2.5])
@pytest.mark.parametrize("phase", [0.0, 1.0, np.pi / 2])
def test_legs_stand_apart_and_swing_against_each_other(heading, phase):
    left, right = legs(PERSON, AHEAD, heading, phase, 0.2)
    np.testing.assert_allclose((left + right)[:2] / 2, AHEAD)
    gap = (left - right)[0] + 1j * (left - right)[1]
    expected = (0.4 * np.sin(phase) + 0.24j) * np.exp(1j * heading)
    assert gap == pytest.approx(expected)
    np.testing.assert_allclose(left[2:], [0.07, 0.06, heading])


def test_facing_the_robot_there_are_two_legs_and_sideways_one_hides_the_other():
    facing = beams(legs(PERSON, AHEAD, np.pi, 0.0, 0.0))
    assert set(facing[facing >= 0]) == {0, 1}
    angles = np.rad2deg(Scanner(beams=181).angles)
    for leg, side in ((0, -0.12), (1, 0.12)):  # the left leg of who faces it is on its right
        width = 2 * np.rad2deg(np.arcsin(0.06 / np.hypot(2, side)))
        assert (facing == leg).sum() == pytest.approx(width, abs=1)
        assert angles[facing == leg].mean() == pytest.approx(np.rad2deg(side / 2), abs=0.5)
    sideways = beams(legs(PERSON, AHEAD, np.pi / 2, 0.0, 0.0))
    assert set(sideways[sideways >= 0]) == {0}


def test_a_skirt_is_one_thing_as_wide_as_both_legs():
    skirt = Person(stance=0.24, leg=(0.07, 0.06), skirt=True)
    ((x, y, ahead, side, heading),) = legs(skirt, AHEAD, np.pi, 0.0, 0.0)
    assert (x, y, heading) == (*AHEAD, np.pi)
    assert 2 * side >= 0.24 + 2 * 0.06
    assert ahead > 0.07
    assert legs(skirt, AHEAD, 0.0, 1.0, 0.3)[0, 2] > ahead  # it widens with the steps


def test_skin_gets_darker_and_redder_with_the_tone():
    tones = np.array([skin(t) for t in np.linspace(0, 1, 9)])
    assert (np.diff(tones, axis=0) < 0).all()
    blue, green, red = tones.T
    assert (red > green).all()
    assert (green > blue).all()
    logs = np.diff(np.log(tones), axis=0)
    np.testing.assert_allclose(logs, logs[:1].repeat(8, axis=0))


def test_people_are_drawn_from_the_documented_ranges():
    crowd = [make_person(rng=rng) for rng in np.random.default_rng(0).spawn(400)]
    heads = np.array([p.head for p in crowd])
    assert 1.5 <= heads.min() < 1.52
    assert 1.76 < heads.max() <= 1.85
    tones = np.array([p.tone for p in crowd])
    assert tones.min() < 0.02
    assert tones.max() > 0.98
    assert 0.05 < np.mean([p.skirt for p in crowd]) < 0.16
    assert not any(make_person(rng=np.random.default_rng(k), skirt=False).skirt for k in range(20))
    assert all(make_person(rng=np.random.default_rng(k), skirt=True).skirt for k in range(20))


def test_a_figure_reaches_from_the_shins_to_the_head_and_only_who_is_there_has_one():
    people = [PERSON, Person(head=1.5)]
    zeros = np.zeros(2)
    places = np.array([[1.0, 2.0], [3.0, 4.0]])
    there = np.array([False, True])
    shown = figures(people, places, zeros, zeros, zeros, zeros, there, np.array([4, 5]))
    assert set(shown.owners) == {1}
    assert set(shown.light) == {5}
    assert shown.heads.sum() == 1
    head = shown.centres[shown.heads > 0][0]
    assert head[2] == 1.5
    assert np.hypot(*(shown.centres[:, :2] - places[1]).T).max() < 0.4
    tops = shown.centres[:, 2] + 1 / np.linalg.norm(shown.shapes, axis=2).max(axis=1)
    assert tops.max() < 1.5 + 0.2
    nobody = figures(people, places, zeros, zeros, zeros, zeros, there & False, zeros)
    assert len(nobody.centres) == 0
