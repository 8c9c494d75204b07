"""Laws of the dark, of one cue after the other, and of the cost of the aggregation."""

from dataclasses import fields, replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from robot_perception.chapters.people_fusion import committee, scaling, sequential, survival
from robot_perception.chapters.people_sensors.sessions import (
    CHOOSE,
    LEARN,
    RIG,
    SENSORS,
    TEST,
    Recording,
)
from robot_perception.geometry import wrap_angle
from robot_perception.people.aggregation import Aggregator, Hypotheses
from tests.chapters.people_fusion.test_studies import run
from tests.chapters.people_sensors.test_studies import recording

SPREAD = {"laser": (0.1, 0.05), "sonar": (0.3, 0.15), "camera": (2.0, 0.05)}


def session(people, duration=12.0, sees=("laser", "sonar", "camera")):
    """Return a session in which those who stand still are seen in each reading of some sensors.

    The laser sees those ahead, the sonars those within 2 m, the camera all, at 2 m.
    """
    people = np.array(people, float).reshape(-1, 2)
    rows = sorted(
        (float(time), sensor)
        for sensor, (rate, delay) in enumerate(zip(RIG.rates, RIG.delays, strict=True))
        for time in np.arange(delay, duration, 1 / rate)
    )
    parts = []
    for _, sensor in rows:
        name = SENSORS[sensor]
        heard = {
            "laser": np.abs(people[:, 1]) < np.pi / 2,
            "sonar": people[:, 0] < survival.HEARD,
            "camera": people[:, 0] > 0,
        }[name] & (name in sees)
        found = people[heard]
        parts.append(np.c_[np.full(len(found), 2.0), found[:, 1]] if name == "camera" else found)
    only, n = recording(people, []), len(rows)
    spreads = [np.diag(SPREAD[SENSORS[sensor]]) ** 2 for _, sensor in rows]
    covs = [np.tile(one, (len(p), 1, 1)) for one, p in zip(spreads, parts, strict=True)]
    times, sensors = (np.array(column) for column in zip(*rows, strict=True))
    still = {f.name for f in fields(Recording)} - {
        *("times", "sensors", "poses", "reckoned", "counts", "means", "covs", "judged", "skirt")
    }
    return replace(
        only,
        times=times,
        sensors=sensors,
        poses=np.zeros((n, 3)),
        reckoned=np.zeros((n, 3)),
        counts=np.array([len(part) for part in parts]),
        means=np.concatenate(parts),
        covs=np.concatenate(covs),
        judged=np.arange(n),
        **{name: np.repeat(getattr(only, name), n, axis=0) for name in still},
    )


BEHIND, AWAY = (1.5, 2.8), (4.0, -2.5)


@given(st.sampled_from(SENSORS), st.floats(0, 3))
def test_a_sensor_that_is_silenced_reports_nobody_from_then_on(sensor, since):
    whole = session([BEHIND, (2.0, 0.3)], 3.0)
    less = survival.silenced(whole, sensor, since)
    for k, (time, which) in enumerate(zip(whole.times, whole.sensors, strict=True)):
        mute = SENSORS[which] == sensor and time >= since
        left = whole.found(k).positions.mean[: 0 if mute else None]
        assert less.found(k).positions.mean == pytest.approx(left)
        assert len(less.found(k).positions.cov) == len(left)


def test_turned_sonars_hear_as_much_elsewhere_and_the_others_are_as_they_were():
    whole = session([BEHIND], 1.0)
    turned = survival.turned_sonars(whole, np.pi)
    for k, sensor in enumerate(whole.sensors):
        a, b = (one.found(k).positions.mean for one in (whole, turned))
        by = np.pi if SENSORS[sensor] == "sonar" else 0.0
        assert np.abs(wrap_angle(b[:, 1] - a[:, 1])) == pytest.approx(by)
        assert (np.abs(b[:, 1]) <= np.pi).all()
        assert a[:, 0] == pytest.approx(b[:, 0])


def test_a_hypothesis_that_sonars_confirm_outlives_the_light_where_they_weigh_enough():
    whole = session([BEHIND, AWAY])
    (kept,) = survival.nights(whole, survival.RULES[survival.LIBRARY], (6.0,))
    near, far = np.argsort(kept.polar[:, 0])
    assert kept.polar[[near, far]] == pytest.approx(np.array([BEHIND, AWAY]))
    assert kept.there.all()
    assert kept.kept[near, 0].all()
    assert not kept.kept[near, 1:, -1].any()
    assert not kept.kept[far, :, -1].any()
    (weak,) = survival.nights(whole, survival.RULES[survival.OURS], (6.0,))
    assert not weak.kept[..., -1].any()


def test_sonars_that_hear_nothing_stretch_the_life_of_a_hypothesis_too():
    """Each reading takes the time since the last one, at the patience of its own sensor."""
    (kept,) = survival.nights(session([BEHIND]), survival.RULES[survival.OURS], (6.0,))
    (_, deaf, without) = kept.kept[0].sum(axis=1)
    assert deaf > without > 0


def test_only_people_on_the_sides_asked_for_are_followed_and_those_who_leave_are_not_there():
    whole = session([BEHIND, (2.0, 0.3)])
    rules, after = survival.RULES[survival.LIBRARY], whole.times > 8.5
    left = replace(whole, present=whole.present & ~after[:, None])
    (kept,) = survival.nights(left, rules, (6.0,), ("ahead",))
    assert kept.polar == pytest.approx(np.array([[2.0, 0.3]]))
    assert kept.of("ahead", 3.0).all()
    assert not kept.of("ahead", 2.0).any()
    assert not kept.of("behind", 3.0).any()
    assert kept.there.tolist() == [[True, True, False, False]]


def test_a_hypothesis_lives_on_in_the_one_that_it_is_made_one_with():
    whole = session([BEHIND], 1.0)
    one = whole.means[:1], whole.covs[:1], np.array([1.0])
    found = Hypotheses(*one, np.array([0]), *[np.zeros(1)] * 3, {}, 9)
    info = Aggregator(committee.RULES).step(Hypotheses.none(), whole.found(0), np.zeros(3))[1]
    united, gone = (replace(info, absorbed=a, removed=r) for a, r in ((((0, 5),), ()), ((), (0,))))
    for infos, kept in (((united, info), [True, True]), ((united, gone), [True, False])):
        story = ((k, found, one) for k, one in enumerate(infos))
        assert survival.outlived(whole, story, {5: 0}, [0, 1]).tolist() == [kept]


def test_more_is_the_difference_of_the_shares_of_those_who_are_there():
    polar = np.array([BEHIND, BEHIND, BEHIND, AWAY])
    there, kept = np.ones((4, 4), dtype=bool), np.zeros((4, 3, 4), dtype=bool)
    there[1] = False
    kept[[0, 1, 2], 0], kept[2, 1] = True, True
    some = survival.Kept(np.array([0, 0, 2, 2]), polar, there, kept)
    behind = some.of("behind")
    assert behind.tolist() == [True, True, True, False]
    assert some.more(2.0, behind).estimate == 0.5
    assert some.share(2.0, 1, behind).estimate == 0.5
    assert some.more(2.0, some.of("behind", 5.0)).estimate == pytest.approx(1 / 3)


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
    found = tuple(both.select(np.array([t >= since, True])) for t in laser.times[lasers])
    static = tuple(np.zeros(len(some), dtype=bool) for some in found)
    scene = replace(run(glimpse, both), rows=lasers, hypotheses=found, static=static)
    return sequential.verified(scene), laser.times[lasers], laser.times[row]


def test_who_was_seen_once_in_a_direction_stays_verified():
    seen, times, then = glimpsed()
    for time, some, static in zip(times, seen.hypotheses, seen.static, strict=True):
        assert some.identity.tolist() == ([3] if time >= then else [])
        assert len(static) == len(some)


def test_a_face_verifies_nobody_who_comes_there_later():
    seen, times, then = glimpsed(since=1.5)
    assert times[-1] > 1.5 > then + 0.5
    assert [len(some) for some in seen.hypotheses] == [0] * len(times)


def test_sessions_with_skirts_are_no_others():
    assert not set(sequential.SKIRTED) & {*LEARN, *CHOOSE, *TEST}
    assert sorted(set(sequential.SKIRTED)) == list(sequential.SKIRTED)


def test_legs_are_hidden_by_a_skirt_or_where_no_beam_meets_them():
    scene = recording([(2, 0), (2, 0.5), (2, -0.5), (2, 2.5), (6, 0.2), (2, 1), (2, -1)], [])
    scene = replace(
        scene,
        skirt=np.arange(7) == 1,
        beams=np.array([[3, 3, 0, 0, 0, 3, 3]]),
        gaze=np.array([[1.0, 1, 1, 1, 1, 0.5, 1]]),
        clear=np.arange(7)[None] != 6,
    )
    assert np.flatnonzero(sequential.kind_of(scene, "hidden")).tolist() == [1, 2]
    assert np.flatnonzero(sequential.kind_of(scene, "seen")).tolist() == [0]


def test_a_tally_counts_the_kind_and_all_hypotheses():
    scene = recording([(2, 0), (2, 0.8)], [(2, 0), (2, 0.8), (4, -0.8)])
    scene = replace(scene, skirt=np.array([True, False]))
    found = Aggregator(committee.RULES).step(Hypotheses.none(), scene.found(0), np.zeros(3))[0]
    assert sequential.tally(run(scene, found), "hidden") == (1, 1, 3, 1)


def test_what_the_concurrent_scheme_gains_is_a_share_of_these_people():
    people = np.array([10.0, 30.0])
    names = (sequential.CONCURRENT, sequential.SEQUENTIAL, sequential.UNVERIFIED)
    tracked = dict(zip(names, np.array([[8.0, 20], [2, 6], [8, 20]]), strict=True))
    shares = sequential.Shares(people, tracked, tracked, tracked)
    assert sequential.gained(shares).estimate == 0.5
    assert sequential.gained(shares, sequential.UNVERIFIED).estimate == 0.0


@given(st.integers(1, 3), st.integers(1, 4), st.integers(0, 10**6))
def test_each_copy_of_a_sensor_reads_at_the_rate_of_its_kind(copies, people, seed):
    found = scaling.readings(copies, people, 0.0, rng=np.random.default_rng(seed))
    times = [one.time for one in found]
    assert times == sorted(times)
    names = [one.sensor for one in found]
    assert len(set(names)) == 3 * copies
    for kind, rate in zip(SENSORS, RIG.rates, strict=True):
        count = names.count(f"{kind} {copies - 1}")
        assert abs(count - rate * (scaling.SETTLED + scaling.COUNTED)) <= 1
    assert max(len(one) for one in found) <= people + round(people / 3)


def test_the_cost_of_somebody_who_is_known_is_one_pair_a_reading_and_one_among_themselves():
    """With one hypothesis there is a pair with the detection, if there is one, and with itself."""
    cost = scaling.pairs(1, 1, 0.0, committee.RULES, rng=np.random.default_rng(1))
    assert sum(RIG.rates) * (1 + scaling.SEEN) == pytest.approx(cost, rel=0.1)


def test_exponents_are_those_of_power_laws():
    sizes = (1, 2, 4)
    costs = np.array([[3.0 * n**2 for n in sizes], [5.0 * n for n in sizes]])
    assert scaling.exponents(sizes, costs).estimate == pytest.approx(1.5)
