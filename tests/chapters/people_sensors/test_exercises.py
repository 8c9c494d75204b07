"""The answers of the exercises are what happens."""

import numpy as np
import pytest

from data_synth.people.sound import EARS
from data_synth.sonar import SonarRing
from robot_perception.book import people_sensors as page
from robot_perception.book.people_sensors import EXERCISES
from robot_perception.geometry import wrap_angle
from robot_perception.people import sound
from tests.chapters.exercises import assert_judged, assert_told


def test_a_leg_is_met_twice_up_to_the_distance_of_the_exercise():
    far, gap = EXERCISES["people-beams"].answer, np.deg2rad(1.0)
    for distance, least in ((0.999 * far, 2), (1.001 * far, 1)):
        starts = np.linspace(0, gap, 101)[:-1] * distance
        beams = starts[:, None] + gap * distance * np.arange(10)
        assert ((beams > 0) & (beams < 0.12)).sum(axis=1).min() == least


def test_a_cone_is_as_wide_as_in_the_exercise():
    half = SonarRing().cone / 2
    rims = 1.5 / np.cos(half) * np.array([np.sin(half), np.sin(-half)])
    assert np.ptp(rims) == pytest.approx(EXERCISES["people-cone"].answer)


def test_a_voice_is_late_as_in_the_exercise():
    left, right = sound.arrivals(EARS.places, np.deg2rad([30.0]))[0]
    assert 1e3 * (right - left) == pytest.approx(EXERCISES["people-delay"].answer)


def close(directions, phi, degrees):
    return (np.abs(wrap_angle(directions - phi)) < np.deg2rad(degrees)).any()


def believe(sensor, place, laser, sonar, camera):
    face = close(camera[:, 1], place[1], 10)
    known = close(sonar[:, 1], place[1], 15)
    return sensor == "sonar" or (face and not known)


def test_the_committee_of_the_solution_beats_the_sonars_and_all_places_are_too_many():
    exercise = EXERCISES["people-own"]
    assert_judged(exercise, believe)
    assert exercise.judge(page.RIVALS["sonars alone"])[0] == "wrong"
    assert exercise.judge(page.RIVALS["laser alone"])[0] == "wrong"
    assert_told(exercise, page.RIVALS["laser or sonars"], "before you believe the laser")


def test_whom_a_rule_finds_is_whom_the_explorer_shows():
    laser, sonars = page.RIVALS["laser alone"], page.RIVALS["sonars alone"]
    found = sum(page.found_by("sonar", how)[0] for how in page.HOW)
    assert page.tried(sonars)[0] == found
    assert page.tried(laser)[0] <= sum(page.found_by("laser", how)[0] for how in page.HOW)
    assert page.tried(lambda *_: False) == (0, 0)
