"""Laws of what a sensor makes of people, on sessions written down by hand."""

from dataclasses import replace

import numpy as np
import pandas as pd
import pytest

from data_synth.people.staging import SENSORS
from robot_perception.book import people_sensors as page
from robot_perception.book.people_sensors import Told
from studies.rows import Rows


def recording(polar, found, *, clear=True, sensor="laser"):
    """Return a session of one reading: people and detections at distances and directions."""
    polar, found = np.array(polar, float).reshape(-1, 2), np.array(found, float).reshape(-1, 2)
    p, one = len(polar), np.ones((1, len(polar)))
    return Told(
        times=np.array([1.0]),
        sensors=np.array([SENSORS.index(sensor)]),
        poses=np.zeros((1, 3)),
        reckoned=np.zeros((1, 3)),
        counts=np.array([len(found)]),
        means=found,
        covs=np.tile(np.diag([0.01, 0.01]), (len(found), 1, 1)),
        judged=np.array([0]),
        polar=polar[None],
        present=one > 0,
        clear=np.broadcast_to(clear, (1, p)).copy(),
        beams=one.astype(int),
        cones=one.astype(int),
        side=0 * one,
        gaze=one,
        swing=0 * one,
        skirt=np.zeros(p, dtype=bool),
    )


def told(monkeypatch, **what):
    """Let every session be one that is written down by hand."""
    asked = []

    def record(config):
        asked.append(config)
        return recording(**what)

    monkeypatch.setattr(page, "record", record)
    return asked


def test_each_detection_is_one_persons():
    people, found = np.array([[2, 0], [2, 0.1]]), np.array([[2, 0.05], [4, 2]])
    who, which = page.paired(people, found, "laser")
    assert (len(who), which.tolist()) == (1, [0])


def test_a_camera_is_judged_by_direction_round_the_back():
    who, which = page.paired(np.array([[2, 3.1]]), np.array([[4, -3.1]]), "camera")
    assert (who.tolist(), which.tolist()) == ([0], [0])


def test_a_session_is_counted(monkeypatch):
    asked = told(monkeypatch, polar=[(2, 0), (2, 0.1)], found=[(2, 0.05), (4, 2)])
    assert page.decoyed.one(1, True) == {"readings": 1, "found": 2, "false": 1}
    page.decoyed.one(1, False)
    page.decoyed.one(1, True, kept=False)
    page.reported.one(1, "laser", True)
    page.along.one(1)
    assert [config.distractors for config in asked] == [True, False, False, True, True]
    assert [config.sensors for config in asked] == [("laser",)] * 4 + [("sonar",)]
    assert (asked[-1].robot, asked[-1].duration) == ("drives", 90.0)


def test_who_is_asked_about_is_counted_by_distance(monkeypatch):
    told(monkeypatch, polar=[(1.2, 0.1), (2.2, 0), (2.8, 3.0)], found=[(2.25, 0)])
    some = page.looked.one(1, "upright")  # who is behind is not asked about
    assert some["asked"].tolist() == [0, 0, 1, 0, 1, 0, 0, 0, 0, 0]
    assert some["found"].tolist() == [0, 0, 0, 0, 1, 0, 0, 0, 0, 0]


def test_a_kind_of_people_is_what_its_sensor_could_find():
    one = recording([(2, 0)], [])
    for kind, changes in {
        "upright": {"beams": 0 * one.beams, "side": one.side + 0.7, "skirt": np.array([True])},
        "in a cone": {"cones": 0 * one.cones},
        "facing": {"clear": ~one.clear, "gaze": one.gaze - 0.3},
    }.items():
        assert page.of_kind(one, kind).all()
        for name, value in changes.items():
            assert not page.of_kind(replace(one, **{name: value}), kind).any(), (kind, name)
    turned = replace(one, side=one.side + 0.9)
    assert page.of_kind(turned, "sideways").all()
    assert not page.of_kind(replace(turned, swing=one.swing + 0.1), "sideways").any()
    assert page.of_kind(replace(one, skirt=np.array([True])), "in a skirt").all()
    assert not page.of_kind(replace(one, present=~one.present), "upright").any()


def test_errors_are_those_of_people_near_ahead_by_their_own_detections(monkeypatch):
    asked = told(monkeypatch, polar=[(1.2, 0.0), (1.5, 1.0), (2.5, -1.0), (1.0, 3.0)],
                 found=[(1.3, 0.1), (3.0, 1.0), (2.4, -1.0), (1.2, 3.0)])  # fmt: skip
    assert page.measured.one(1, "laser") == pytest.approx({"off": 0.1, "times": 1})
    told(monkeypatch, polar=[(2.5, 0.0)], found=[])
    assert page.measured.one(1, "laser") == {"off": 0.0, "times": 0}
    assert [config.sensors for config in asked] == [("laser",)]


def test_sessions_without_a_detection_have_no_say_in_the_error():
    columns = {"session": [1, 1, 2, 2, 3, 3], "sensor": ["sonar", "laser"] * 3}
    columns |= {"off": [0.4, 0.1, 9.0, 0.0, 0.2, 0.1], "times": [1, 2, 3, 0, 1, 1]}
    table = pd.DataFrame(columns)
    assert page.inaccuracy(Rows(table, "session", {}, "")).estimate == pytest.approx(3.0)


def test_shares_are_taken_over_the_sessions_that_were_asked():
    table = pd.DataFrame({"session": [1, 1, 2, 2], "kind": "upright", "within": [0.5, 1.0] * 2,
                          "asked": [0, 4, 0, 2], "found": [0, 1, 0, 2]})  # fmt: skip
    rows = Rows(table, "session", {}, "")
    assert page.rate(rows, "upright").estimate == pytest.approx(0.5)
    with pytest.raises(ValueError, match="below"):
        page.rate(rows, "upright", high=0.5)
    assert page.by_distance(rows, "upright") == {}  # three sessions have a say, or none


def test_rooms_of_different_studies_are_different_ones():
    used = [page.LEARN, page.CHOOSE, page.TEST, page.WALLED, [page.OFFICE],
            page.decoyed.axes["session"], [page.PAGE.seed], page.compared.axes["session"],
            page.hidden.axes["person"], page.coloured.axes["session"]]  # fmt: skip
    together = [seed for seeds in used for seed in seeds]
    assert len(set(together)) == len(together)
