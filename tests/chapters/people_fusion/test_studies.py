"""Laws of the studies, on sessions written down by hand."""

from dataclasses import fields, replace

import numpy as np
import pytest

from robot_perception.book.people_sensors import WALLED
from robot_perception.chapters.people_fusion import committee, rates, sequential, survival
from robot_perception.chapters.people_fusion.behaviours import SEEDS
from robot_perception.chapters.people_fusion.committee import Rates, Tracked, View
from robot_perception.chapters.people_sensors import sessions
from robot_perception.chapters.people_sensors.sessions import (
    CHOOSE,
    LEARN,
    SENSORS,
    TEST,
    Config,
    Recording,
)
from robot_perception.people.aggregation import Aggregator, Hypotheses
from robot_perception.people.detections import polar
from tests.chapters.people_sensors.test_studies import recording


def only(scene, where="everywhere", by="place"):
    """Return rates of the detections of one reading, taken for persons."""
    return committee.frame(scene, 0, hypotheses(scene.found(0).positions), View(where, by))


def hypotheses(found):
    """Return distributions of distance and direction as persons who are certain."""
    one, names = np.ones(len(found.mean)), np.arange(len(found.mean))
    return Hypotheses(found.mean, found.cov, one, names, *[0 * one] * 3, {}, len(one))


def run(scene, hypotheses):
    """Return what was tracked in a session of one reading."""
    static = np.zeros(len(hypotheses), dtype=bool)
    return Tracked(scene, np.array([0]), (hypotheses,), (static,), 0.0)


def first(scene):
    """Return the hypotheses after the only reading."""
    return Aggregator(committee.RULES).step(Hypotheses.none(), scene.found(0), np.zeros(3))[0]


def test_seeds_never_meet():
    assert not set(LEARN) & set(CHOOSE) | set(LEARN) & set(TEST) | set(CHOOSE) & set(TEST)
    assert len(TEST) == 40
    nights = {config.seed for config in survival.NIGHTS}
    assert not {*WALLED, *nights} & {*LEARN, *CHOOSE, *TEST, *SEEDS}
    assert not nights & {*WALLED, *sequential.SKIRTED}


def test_who_is_hidden_or_far_away_need_not_be_found_and_is_not_wrong():
    scene = recording(
        [(2, 0), (2, 1), (6, -1)], [(2, 0), (2, 1), (6, -1), (4, 2)], clear=[True, False, True]
    )
    frame = only(scene)
    assert frame.people_ids.tolist() == [0]
    assert frame.hypotheses_ids.tolist() == [0, 3]


@pytest.mark.parametrize(("where", "people", "found"), [("ahead", [0], [0]), ("behind", [1], [1])])
def test_a_hypothesis_counts_on_the_side_of_its_person(where, people, found):
    """The second hypothesis lies ahead, and is that of somebody just behind."""
    scene = recording([(2, 0), (2, 1.6)], [(2, 0), (2, 1.5)])
    frame = only(scene, where)
    assert frame.people_ids.tolist() == people
    assert frame.hypotheses_ids.tolist() == found


def test_by_direction_the_distance_does_not_matter():
    scene = recording([(2, 3.1)], [(4, -3.1)])
    near = committee.REACH * (2 * np.pi - 6.2) / committee.TURN
    for by, apart in (("direction", near), ("place", np.hypot(2, 0.2))):
        assert only(scene, by=by).apart.item() == pytest.approx(apart, rel=0.02)


@pytest.mark.parametrize(("sigma", "same"), [(1.1, "place"), (1.3, "direction")])
def test_a_hypothesis_is_judged_as_its_covariance_allows(sigma, same):
    """The camera's 2 m with 2 m are no distance; those of a sonar are one."""
    people = np.array([[2.0, 0.5], [3.0, -0.3]])
    found = polar(np.array([4.0, 3.2]), np.array([0.55, -0.4]), sigma, 0.1)
    for by in ("covariance", same):
        apart = View(by=by).apart(people, found.mean, np.sqrt(found.cov[:, 0, 0]))
        near = apart <= committee.REACH
        assert near.tolist() == [[same == "direction", False], [False, True]]


def test_rates_of_a_scene_that_is_half_right():
    scene = recording([(2, 0), (2, 1)], [(2, 0), (4, -1)])
    found = Rates(*np.array([committee.sums(run(scene, first(scene)), View())] * 2).T)
    assert found.tracked.estimate == found.false.estimate == 0.5
    assert found.worth() == pytest.approx([0.5, 0.5])
    assert found.worth(1.0) == pytest.approx([0.5, 0.5])
    assert found.mota.estimate == 0
    assert found.gospa == pytest.approx([1.0, 1.0])


def test_scaled_rules():
    some = rates.scaled(committee.RULES, alpha=0.5, patience=2.0)
    for name in SENSORS:
        old, new = committee.RULES.sensors[name], some.sensors[name]
        assert new.alpha == old.alpha / 2
        assert new.patience == 2 * old.patience
    assert rates.scaled(committee.RULES, alpha=100.0).sensors["camera"].alpha_behind == 1


def test_who_is_seen_again_and_again_becomes_a_person(monkeypatch):
    one, n = recording([(2, 0)], [(2, 0)], sensor="sonar"), 20
    names = {entry.name for entry in fields(Recording)} - {"times", "judged", "skirt"}
    rows = {name: np.repeat(getattr(one, name), n, axis=0) for name in names}
    many = replace(one, times=np.arange(n) / 10, judged=np.arange(n), **rows)
    monkeypatch.setattr(sessions, "record", lambda config: many)
    tracked = committee.tracked.__wrapped__(Config(1))
    counts = [len(persons) for _, persons, _ in tracked.persons]
    assert counts[0] == 0
    assert counts[-1] == 1
    assert counts == sorted(counts)
    assert all(len(frame.hypotheses) <= 1 for frame in committee.frames(tracked))


def test_no_persons_no_hypotheses():
    (frame,) = committee.frames(run(recording([(2, 0)], []), Hypotheses.none()))
    assert (len(frame.people), len(frame.hypotheses)) == (1, 0)


def test_each_row_of_a_comparison_is_its_own(monkeypatch):
    """Rows that share a system have their own views, and none takes another's sessions."""

    def tracked(config, system):
        scene = recording([(2, 0), (2, 2)], [(2, 0)][: config.seed])
        return run(scene, first(scene))

    monkeypatch.setattr(committee, "tracked", tracked)
    ours, other = committee.System(), committee.System(dark=True)
    rows = (("all", ours, View()), ("ahead", ours, View("ahead")), ("dark", other, View("behind")))
    both = committee.Comparison((Config(0), Config(1)), rows)
    found = committee.compare(both, rng=np.random.default_rng(0))
    assert [one.people.tolist() for one in found.values()] == [[2, 2], [1, 1], [1, 1]]
    assert [one.matched.tolist() for one in found.values()] == [[0, 1], [0, 1], [0, 0]]
    assert list(found) == ["all", "ahead", "dark"]


def test_a_person_missed_costs_four_that_are_nobody():
    missed, false = (
        Rates(*np.array([[10.0], [found], [matched], [0], [0]]))
        for found, matched in ((9, 9), (14, 10))
    )
    assert missed.worth() == pytest.approx(false.worth(), abs=0.01)
    assert missed.worth(1.0) > false.worth(1.0) + 0.1


def test_the_full_size_changes_one_thing_each_beside_the_ways_to_count():
    full = rates.RATE.full
    names = [name for one in (full, *full.more) for name, *_ in one.rows]
    assert len(set(names)) == len(names) == 7 + 8 + 15 + 7
    assert rates.RATE.quick.rows == full.rows
    changed = {one.rows[0][0]: one.sessions for one in full.more[1:]}
    for name, (seen, *_) in changed.items():
        ours = rates.FEW[0]
        other = {f.name for f in fields(Config) if getattr(seen, f.name) != getattr(ours, f.name)}
        assert other == set(rates.PROPERTIES[name])
