"""Sessions as they are staged: what a config decides, and what is known at a time."""

from dataclasses import replace

import numpy as np
import pytest

from data_synth.people import FisheyeImage, LaserScan, SonarScan, readings, truth
from data_synth.people.staging import PEOPLE, RIG, SENSORS, Config, rig, staged, truths
from data_synth.sonar import SonarRing

SHORT = Config(5, 0.5)
SILENT = ("laser", "sonar")


def heard(config):
    """Return all readings of a session."""
    session, rng = staged(config)
    return list(readings(session, rig(config.sensors), rng=rng))


def test_the_same_config_is_the_same_session_and_the_same_noise():
    once, again = (heard(replace(SHORT, sensors=SILENT)) for _ in range(2))
    for one, other in zip(once, again, strict=True):
        np.testing.assert_array_equal(one.ranges, other.ranges)
    other = heard(replace(SHORT, seed=6, sensors=SILENT))
    assert not np.array_equal(once[0].ranges, other[0].ranges)


@pytest.mark.parametrize("sensors", [SENSORS, ("laser",), ("sonar", "camera")])
def test_those_who_take_part_report_and_as_often_as_is_said(sensors):
    config = replace(SHORT, sensors=sensors)
    kinds = dict(zip((LaserScan, SonarScan, FisheyeImage), SENSORS, strict=True))
    found = [kinds[type(reading)] for reading in heard(config)]
    assert set(found) == set(sensors)
    assert config.readings == len(found)


def test_what_the_laser_reports_does_not_depend_on_the_others():
    alone = heard(replace(SHORT, sensors=("laser",)))
    among = [one for one in heard(SHORT) if isinstance(one, LaserScan)]
    for one, other in zip(alone, among, strict=True):
        np.testing.assert_array_equal(one.ranges, other.ranges)


def test_a_rig_has_the_ring_that_is_given():
    ring = SonarRing(count=8)
    assert rig(SENSORS, ring) == replace(RIG, ring=ring)


@pytest.mark.slow
def test_people_and_office_are_as_the_config_says():
    session, _ = staged(SHORT)
    slow, _ = staged(replace(SHORT, pace=0.5))
    paces = [[person.pace for person in one.people] for one in (session, slow)]
    assert len(paces[0]) == PEOPLE
    np.testing.assert_allclose(paces[1], np.array(paces[0]) / 2)
    skirts = [
        [
            person.skirt
            for seed in range(20)
            for person in staged(Config(seed, 0.1, skirts=s))[0].people
        ]
        for s in (True, False)
    ]
    assert any(skirts[0])
    assert not any(skirts[1])
    bare, _ = staged(replace(SHORT, distractors=False))
    assert len(bare.office.posts) < len(session.office.posts)
    dark, _ = staged(replace(SHORT, lights_out=0.2))
    assert np.isinf(session.lights_out).all()
    assert (dark.lights_out == 0.2).all()
    drives, _ = staged(replace(SHORT, duration=15.0, robot="drives"))
    assert np.ptp(drives.robot[:, :2], axis=0).max() > 0.1
    assert not np.ptp(session.robot, axis=0).any()


def test_what_is_known_is_the_truth_and_how_people_stand_to_the_robot():
    session, _ = staged(SHORT)
    times = [0.1, 0.4]
    known = truths(session, times)
    for k, time in enumerate(times):
        now = session.at(time)
        told = truth(session.office, session.people, now, RIG)
        for name in ("polar", "present", "clear", "beams", "cones"):
            np.testing.assert_array_equal(known[name][k], getattr(told, name))
        for p, place in enumerate(now.positions):
            gap = (now.robot[:2] - place) / np.hypot(*(now.robot[:2] - place))
            body, face = ([np.cos(turn[p]), np.sin(turn[p])] for turn in (now.headings, now.gazes))
            assert known["side"][k, p] == pytest.approx(abs(gap[0] * body[1] - gap[1] * body[0]))
            assert known["gaze"][k, p] == pytest.approx(gap @ face)
        np.testing.assert_array_equal(known["swing"][k], now.swings)


@pytest.mark.parametrize(
    ("changes", "reason"),
    [
        ({"robot": "flies"}, "robot must be stands or drives"),
        ({"sensors": ("nose",)}, "sensors must be of laser, sonar, camera"),
        ({"sensors": "laser"}, "sensors must be of laser, sonar, camera"),
        ({"faces": 1.5}, "faces must be"),
        ({"duration": 0.0}, "duration must be"),
    ],
)
def test_what_is_no_session_is_refused(changes, reason):
    with pytest.raises(ValueError, match=reason):
        replace(SHORT, **changes)


def test_nothing_is_known_at_no_time():
    session, _ = staged(SHORT)
    with pytest.raises(ValueError, match="times must be one at least"):
        truths(session, [])
