"""Laws of the dark, of one cue after the other, of memory, and of the cost of the aggregation."""

from dataclasses import replace

import numpy as np
import pandas as pd
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from data_synth.people.staging import RIG, SENSORS
from robot_perception.book import people_fusion as page
from robot_perception.book.people_fusion import LIBRARY, OURS, RULES
from robot_perception.geometry import wrap_angle
from robot_perception.people.aggregation import AggregationRules, Aggregator, Hypotheses
from studies.rows import Rows
from tests.chapters.people_fusion.sessions import session
from tests.chapters.people_fusion.test_studies import run
from tests.chapters.people_sensors.test_studies import recording

BEHIND, AWAY = (1.5, 2.8), (4.0, -2.5)


@settings(max_examples=20)
@given(st.sampled_from(SENSORS), st.floats(0, 3))
def test_a_sensor_that_is_silenced_reports_nobody_from_then_on(sensor, since):
    whole = session([BEHIND, (2.0, 0.3)], 3.0)
    less = page.silenced(whole, sensor, since)
    for k, (time, which) in enumerate(zip(whole.times, whole.sensors, strict=True)):
        mute = SENSORS[which] == sensor and time >= since
        left = whole.found(k).positions.mean[: 0 if mute else None]
        assert less.found(k).positions.mean == pytest.approx(left)
        assert len(less.found(k).positions.cov) == len(left)


def test_turned_sonars_hear_as_much_elsewhere_and_the_others_are_as_they_were():
    whole = session([BEHIND], 1.0)
    turned = page.turn_sonars(whole, np.pi)
    for k, sensor in enumerate(whole.sensors):
        a, b = (one.found(k).positions.mean for one in (whole, turned))
        by = np.pi if SENSORS[sensor] == "sonar" else 0.0
        assert np.abs(wrap_angle(b[:, 1] - a[:, 1])) == pytest.approx(by)
        assert (np.abs(b[:, 1]) <= np.pi).all()
        assert a[:, 0] == pytest.approx(b[:, 0])


def night(monkeypatch, whole, rules, **changed):
    """Return what is kept of a session in which it gets dark after six seconds, as a table."""
    monkeypatch.setattr(page, "record", lambda config: whole)
    monkeypatch.setattr(page, "DUSKS", (6.0,))
    table = pd.DataFrame(page.darkened.one(1, rules, **changed))
    return table.set_index(["side", "near", "after"]).sort_index()


def test_a_hypothesis_that_sonars_confirm_outlives_the_light_where_they_weigh_enough(monkeypatch):
    kept = night(monkeypatch, session([BEHIND, AWAY]), LIBRARY)
    near, far = kept.loc["behind", True], kept.loc["behind", False]
    assert (near.there == 1).all()
    assert (far.there == 1).all()
    assert (near["with sonars"] == 1).all()
    assert (near.loc[5.0, ["with deaf ones", "without"]] == 0).all()
    assert (far.loc[5.0, ["with sonars", "with deaf ones", "without"]] == 0).all()
    assert (kept.loc["ahead"] == 0).all(axis=None)
    weak = night(monkeypatch, session([BEHIND, AWAY]), OURS)
    assert weak.loc["behind", True].loc[5.0, "with sonars"] == 0


def test_sonars_that_hear_nothing_stretch_the_life_of_a_hypothesis_too(monkeypatch):
    """Each reading takes the time since the last one, at the patience of its own sensor."""
    kept = night(monkeypatch, session([BEHIND]), OURS).loc["behind", True].sum()
    assert kept["with deaf ones"] > kept["without"] > 0


def test_sonars_that_hear_elsewhere_keep_nobody_who_is_behind(monkeypatch):
    kept = night(monkeypatch, session([BEHIND]), LIBRARY, turned=np.pi).loc["behind", True]
    assert kept.loc[5.0, "with sonars"] == 0


def test_those_who_leave_are_not_there(monkeypatch):
    whole = session([BEHIND, (2.5, 0.3)])
    left = replace(whole, present=whole.present & ~(whole.times > 8.5)[:, None])
    table = night(monkeypatch, left, LIBRARY)
    kept = table.there
    assert kept["ahead", False].tolist() == kept["behind", True].tolist() == [1, 1, 0, 0]
    assert kept["ahead", True].sum() == 0
    for ends in ("with sonars", "with deaf ones", "without"):  # whoever has left is not kept
        assert (table[ends] <= table.there).all()


def test_a_hypothesis_lives_on_in_the_one_that_it_is_made_one_with():
    whole = session([BEHIND], 1.0)
    one = whole.means[:1], whole.covs[:1], np.array([1.0])
    found = Hypotheses(*one, np.array([0]), *[np.zeros(1)] * 3, {}, 9)
    info = Aggregator(RULES).step(Hypotheses.none(), whole.found(0), np.zeros(3))[1]
    united, gone = (replace(info, absorbed=a, removed=r) for a, r in ((((0, 5),), ()), ((), (0,))))
    for infos, kept in (((united, info), [True, True]), ((united, gone), [True, False])):
        story = ((k, found, one) for k, one in enumerate(infos))
        assert page.outlived(whole, story, {5: 0}, np.array([0, 1])).tolist() == [kept]


def test_more_is_the_difference_of_the_shares_of_those_who_are_there():
    columns = {"session": [1, 1, 2, 3], "rules": [LIBRARY] * 4, "side": ["behind"] * 4,
               "near": [True, False, True, True], "after": [5.0] * 4, "there": [2, 9, 2, 0],
               "with sonars": [2, 9, 1, 0], "with deaf ones": [1, 0, 0, 0],
               "without": [0] * 4}  # fmt: skip
    rows = Rows(pd.DataFrame(columns), "session", {})
    assert page.kept_more(rows).estimate == 0.5
    assert page.kept_more(rows, than="without").estimate == 0.75


# One cue after the other


def glimpsed(since=0.0):
    """Return what is verified of two people, after a face at 0.55 rad in one image, and when.

    They are hypotheses after each scan, 3 at 0.5 rad from some time on and 4 at -0.5 rad.
    """
    ahead = [(2.0, 0.5), (2.0, -0.5)]
    laser = session(ahead, 2.0, ("laser",))
    row = int(np.flatnonzero(laser.sensors == SENSORS.index("camera"))[3])
    glimpse = replace(
        laser,
        counts=laser.counts + (np.arange(len(laser.times)) == row),
        means=np.insert(laser.means, laser.counts[:row].sum(), [2.0, 0.55], axis=0),
        covs=np.insert(laser.covs, laser.counts[:row].sum(), np.eye(2), axis=0),
    )
    lasers = np.flatnonzero(laser.sensors == 0)
    both = Hypotheses(
        np.array(ahead), np.tile(0.01 * np.eye(2), (2, 1, 1)), np.ones(2), np.array([3, 4]),
        *[np.zeros(2)] * 3, {}, 5,
    )  # fmt: skip
    found = [both.select(np.array([t >= since, True])) for t in laser.times[lasers]]
    static = [np.zeros(len(some), dtype=bool) for some in found]
    scene = replace(run(glimpse, both), rows=lasers.tolist(), found=found, static=static)
    return page.verified(scene), laser.times[lasers], laser.times[row]


def test_who_was_seen_once_in_a_direction_stays_verified():
    seen, times, then = glimpsed()
    for time, some, static in zip(times, seen.found, seen.static, strict=True):
        assert some.identity.tolist() == ([3] if time >= then else [])
        assert len(static) == len(some)


def test_a_face_verifies_nobody_who_comes_there_later():
    seen, times, then = glimpsed(since=1.5)
    assert times[-1] > 1.5 > then + 0.5
    assert [len(some) for some in seen.found] == [0] * len(times)


def test_legs_are_hidden_by_a_skirt_or_where_no_beam_meets_them():
    scene = recording([(2, 0), (2, 0.5), (2, -0.5), (2, 2.5), (6, 0.2), (2, 1), (2, -1)], [])
    scene = replace(
        scene,
        skirt=np.arange(7) == 1,
        beams=np.array([[3, 3, 0, 0, 0, 3, 3]]),
        gaze=np.array([[1.0, 1, 1, 1, 1, 0.5, 1]]),
        clear=np.arange(7)[None] != 6,
    )
    assert np.flatnonzero(page.of_kind(scene, "hidden")).tolist() == [1, 2]
    assert np.flatnonzero(page.of_kind(scene, "seen")).tolist() == [0]


def test_each_scheme_is_asked_after_the_same_readings_of_the_laser(monkeypatch):
    """Somebody in a skirt whom only the camera sees, somebody in trousers whom both see."""
    whole = session([(2.0, 0.5), (2.0, -0.5)], 6.0)
    lasers = np.repeat(whole.sensors == 0, whole.counts)
    hidden = lasers & (whole.means[:, 1] > 0)  # no beam meets the first one's legs
    whole = replace(page.without(whole, hidden), skirt=np.array([True, False]))
    monkeypatch.setattr(page, "record", lambda config: whole)
    found = {kind: pd.DataFrame(page.schemed.one(1, kind)).set_index("scheme")
             for kind in ("hidden", "seen")}  # fmt: skip
    readings = int((whole.sensors == 0).sum())
    for table in found.values():
        assert table.people.tolist() == [readings] * 3
    assert found["hidden"].tracked["concurrent"] > 0.8 * readings
    assert found["hidden"].tracked["sequential"] == found["hidden"].tracked["laser alone"] == 0
    assert found["seen"].tracked["sequential"] > 0.8 * readings
    assert found["hidden"].matched["concurrent"] > 1.6 * readings  # those of both people


def test_what_a_scheme_gains_is_a_share_of_these_people():
    names = np.repeat(["concurrent", "sequential", "laser alone"], 3)
    columns = {"session": [1, 2, 3] * 3, "scheme": names, "people": [10, 30, 0] * 3,
               "tracked": [8, 20, 0, 2, 6, 0, 8, 20, 0]}  # fmt: skip
    rows = Rows(pd.DataFrame(columns), "session", {})
    assert page.share_of_these(rows, "concurrent", "sequential").estimate == 0.5
    assert page.share_of_these(rows, "concurrent", "laser alone").estimate == 0.0


# Memory


@settings(max_examples=20)
@given(st.floats(0.02, 0.9), st.integers(1, 12))
def test_who_was_seen_n_times_is_remembered_for_what_the_page_derives(alpha, matches):
    found = page.forgotten.one(alpha, matches)
    assert found["share"] == pytest.approx(1 - (1 - alpha) ** matches, abs=1e-9)
    assert found["share"] <= found["lost"] + 1e-9
    assert found["lost"] <= found["share"] + 1 / 20 / page.PATIENCE + 1e-9


@settings(max_examples=20)
@given(st.floats(0.02, 0.3), st.integers(2, 30))
def test_a_second_counts_the_readings_unless_alpha_is_for_a_second(alpha, rate):
    assert page.repeated.one(alpha, rate)["power"] == pytest.approx(rate, rel=1e-6)
    assert page.repeated.one(alpha, rate, per_second=True)["power"] == pytest.approx(10, rel=1e-6)


# What it costs


@settings(max_examples=20)
@given(st.integers(1, 3), st.integers(1, 4), st.integers(0, 10**6))
def test_each_copy_of_a_sensor_reads_at_the_rate_of_its_kind(copies, people, seed):
    found = page.readings(copies, people, 0.0, np.random.default_rng(seed))
    times = [one.time for one in found]
    assert times == sorted(times)
    names = [one.sensor for one in found]
    assert len(set(names)) == 3 * copies
    for kind, rate in zip(SENSORS, RIG.rates, strict=True):
        count = names.count(f"{kind} {copies - 1}")
        assert abs(count - rate * (page.SETTLED + page.COUNTED)) <= 1
    assert max(len(one) for one in found) <= people + round(people / 3)


def test_the_cost_of_somebody_who_is_known_is_one_pair_a_reading_and_one_among_themselves():
    """With one hypothesis there is a pair with the detection, if there is one, and with itself."""
    cost = page.pairs(1, 1, 0.0, RULES, np.random.default_rng(1))
    assert sum(RIG.rates) * (1 + page.SEEN) == pytest.approx(cost, rel=0.1)


def test_exponents_are_those_of_power_laws():
    sizes = [1, 2, 4]
    columns = {"world": [0] * 3 + [1] * 3, "what": [page.SAME] * 6, "size": sizes * 2,
               "pairs": [3.0 * n**2 for n in sizes] + [5.0 * n for n in sizes]}  # fmt: skip
    assert page.power(Rows(pd.DataFrame(columns), "world", {})).estimate == pytest.approx(1.5)


def test_the_library_has_the_rules_that_the_page_compares():
    assert {OURS: RULES, LIBRARY: AggregationRules()} == page.RULES_OF
