"""Laws of the studies, on sessions written down by hand."""

from dataclasses import fields, replace

import numpy as np
import pandas as pd
import pytest

from robot_perception.book import people_fusion as page
from robot_perception.book.people_fusion import AHEAD, BEHIND, EVERYWHERE, View
from robot_perception.book.people_sensors import CHOOSE, LEARN, SENSORS, TEST, WALLED, Told
from robot_perception.people.aggregation import Aggregator, Hypotheses, SensorRules
from robot_perception.people.detections import Detections, polar
from studies.rows import Rows
from tests.chapters.people_fusion.sessions import session
from tests.chapters.people_sensors.test_studies import recording


def hypotheses(found):
    """Return distributions of distance and direction as persons who are certain."""
    one, names = np.ones(len(found.mean)), np.arange(len(found.mean))
    return Hypotheses(found.mean, found.cov, one, names, *[0 * one] * 3, {}, len(one))


def hypotheses_at(places):
    """Return persons at some distances and directions."""
    return hypotheses(recording([], places).found(0).positions)


def only(scene, view):
    """Judge the detections of one reading, taken for persons."""
    return page.judged(scene, 0, hypotheses(scene.found(0).positions), view)


def run(scene, known):
    """Return what was tracked in a session of one reading."""
    return page.Run(scene, 0.0, [0], [known], [np.zeros(len(known), dtype=bool)])


def first(scene):
    """Return the hypotheses after the only reading."""
    return Aggregator(page.RULES).step(Hypotheses.none(), scene.found(0), np.zeros(3))[0]


def rows(**columns):
    """Return rows written down by hand."""
    return Rows(pd.DataFrame(columns), "session", {})


def test_seeds_never_meet():
    scored = [TEST, page.FRESH, page.NEWER, page.SKIRTED]
    flat = [seed for seeds in (*scored, LEARN, CHOOSE, WALLED) for seed in seeds]
    assert len(flat) == len(set(flat))
    assert len(page.FRESH) == 40
    assert sorted(page.SKIRTED) == list(page.SKIRTED)


# Judging


def test_who_is_hidden_or_far_away_need_not_be_found_and_is_not_wrong():
    scene = recording(
        [(2, 0), (2, 1), (6, -1)], [(2, 0), (2, 1), (6, -1), (4, 2)], clear=[True, False, True]
    )
    seen = only(scene, View(by="place"))
    assert seen.asked.tolist() == [0]
    assert seen.counts.tolist() == [0, 3]
    assert (seen.who.tolist(), seen.which.tolist()) == ([0], [0])


def test_pairs_are_told_by_the_places_of_all_people_and_all_hypotheses():
    """The first person is hidden, and the first hypothesis is theirs."""
    scene = recording([(2, 1), (2, 0)], [(2, 1), (2, 0)], clear=[False, True])
    seen = only(scene, View(by="place"))
    assert (seen.who.tolist(), seen.which.tolist()) == ([1], [1])


@pytest.mark.parametrize(("view", "people", "found"), [(AHEAD, [0], [0]), (BEHIND, [1], [1])])
def test_a_hypothesis_counts_on_the_side_of_its_person(view, people, found):
    """The second hypothesis lies ahead, and is that of somebody just behind."""
    scene = recording([(2, 0), (2, 1.6)], [(2, 0), (2, 1.5)])
    seen = only(scene, replace(view, by="place"))
    assert seen.asked.tolist() == people
    assert seen.counts.tolist() == found


def test_by_direction_the_distance_does_not_matter_and_the_turn_is_the_short_way():
    people, found = np.array([[2, 3.1]]), np.array([[4, -3.1]])
    near = EVERYWHERE.reach * (2 * np.pi - 6.2) / page.TURN
    for by, gap in (("direction", near), ("place", np.hypot(2, 0.2))):
        assert page.apart(people, found, np.ones(1), View(by=by)).item() == pytest.approx(
            gap, rel=0.02
        )


@pytest.mark.parametrize(("sigma", "same"), [(1.1, "place"), (1.3, "direction")])
def test_a_hypothesis_is_judged_as_its_covariance_allows(sigma, same):
    """The camera's 2 m with 2 m are no distance; those of a sonar are one."""
    people = np.array([[2.0, 0.5], [3.0, -0.3]])
    found = polar(np.array([4.0, 3.2]), np.array([0.55, -0.4]), sigma, 0.1)
    for by in ("covariance", same):
        view = View(by=by)
        near = page.apart(people, found.mean, np.sqrt(found.cov[:, 0, 0]), view) <= view.reach
        assert near.tolist() == [[same == "direction", False], [False, True]]


def test_a_scene_that_is_half_right_is_counted_in_each_view():
    scene = recording([(2, 0), (2, 1)], [(2, 0), (4, -1)])
    counts = page.tally(run(scene, first(scene)), {"all": EVERYWHERE, "behind": BEHIND})
    assert counts["view"] == ["all", "behind"]
    assert [counts[name].tolist() for name in ("people", "found", "matched")] == [
        [2, 0], [2, 0], [1, 0],
    ]  # fmt: skip
    assert page.f_beta(2, 2, 1) == page.f_beta(2, 2, 1, 1.0) == 0.5
    assert page.f_beta(4, 6, 3) == pytest.approx(5 * 3 / (4 * 4 + 6))


def test_no_persons_no_hypotheses():
    seen = page.judged(recording([(2, 0)], []), 0, Hypotheses.none(), EVERYWHERE)
    assert (len(seen.asked), len(seen.counts), len(seen.who)) == (1, 0, 0)


# What a run remembers


def test_who_is_seen_again_and_again_becomes_a_person():
    one, n = recording([(2, 0)], [(2, 0)], sensor="sonar"), 20
    names = {entry.name for entry in fields(Told)} - {"times", "judged", "skirt"}
    columns = {name: np.repeat(getattr(one, name), n, axis=0) for name in names}
    many = replace(one, times=np.arange(n) / 10, judged=np.arange(n), **columns)
    counts = [len(persons) for _, persons, _ in page.committee(many).persons()]
    assert counts[0] == 0
    assert counts[-1] == 1
    assert counts == sorted(counts)


def test_hypotheses_are_kept_after_each_judged_reading_of_a_sensor_that_takes_part():
    whole = session([(2.0, 0.3)], 2.0)
    known = page.committee(whole, sensors=("laser",))
    own = [row for row, k in enumerate(whole.judged) if SENSORS[whole.sensors[k]] == "laser"]
    assert known.rows == own
    assert len(known.found) == len(known.static) == len(own) > 5
    times = whole.judged_at[own]
    assert known.at(times[3]) is known.found[3]
    assert known.at(times[3] - 1e-6) is known.found[2]


def test_what_is_not_judged_is_heard_and_not_kept():
    whole = session([(2.0, 0.3)], 2.0)
    truth = ("polar", "present", "clear", "beams", "cones", "side", "gaze", "swing")
    seldom = {name: getattr(whole, name)[::2] for name in ("judged", *truth)}
    known = page.committee(replace(whole, **seldom))
    assert known.rows == list(range(len(seldom["judged"])))
    for ours, theirs in zip(known.found, page.committee(whole).found[::2], strict=True):
        assert np.array_equal(ours.mean, theirs.mean)


def test_joined_readings_are_heard_by_the_committee():
    """Somebody whom only microphones detect is tracked with them, and not without."""
    whole = session([(2.0, 2.8)], 4.0, sees=())
    more = tuple(
        Detections(0.25 * k, "microphones", polar(np.full(1, 2.0), np.full(1, 2.8), 2.0, 0.1))
        for k in range(1, 16)
    )
    rules = page.with_microphones(page.RULES, SensorRules(0.3, 2.0, silence=False))
    with_, none = page.committee(whole, rules, more=more), page.committee(whole, rules)
    assert len(with_.found[-1].persons(rules)) == 1
    assert len(none.found[-1]) == 0
    assert with_.rows == none.rows


def test_all_readings_come_in_the_order_of_time_with_the_pose_of_the_last_one():
    whole = session([(2.0, 0.3)], 1.0)
    more = tuple(
        Detections(time, "microphones", polar(np.ones(1), np.zeros(1), 2.0, 0.1))
        for time in (0.5, 0.9)
    )
    own = np.flatnonzero(whole.sensors == 0).tolist()
    done = page.in_order(whole, own, more)
    times = [one.time for _, one, _ in done]
    assert times == sorted(times)
    assert [k for k, *_ in done if k >= 0] == own
    assert [one for k, one, _ in done if k < 0] == list(more)


# Rules that are changed


def test_scaled_rules():
    some = page.scaled(page.RULES, alpha=0.5, patience=2.0)
    for name in SENSORS:
        old, new = page.RULES.sensors[name], some.sensors[name]
        assert new.alpha == old.alpha / 2
        assert new.patience == 2 * old.patience
    assert some.sensors["camera"].alpha_behind == page.RULES.sensors["camera"].alpha_behind / 2
    assert page.scaled(page.RULES, alpha=100.0).sensors["camera"].alpha_behind == 1


def test_one_thing_at_a_time_is_another():
    assert len(set(page.OTHERS.values())) == len(page.OTHERS) == 3
    assert page.OTHERS["as chosen"] is page.RULES
    one, other = (page.ROOMS[name] for name in list(page.ROOMS)[1:3])
    assert (one | other).items() < page.ROOMS["both, and half as fast"].items()


@pytest.fixture
def both_seen(monkeypatch):
    """Let every session be one of two people, one ahead and one behind, who are both seen."""
    whole = session([(2.0, 0.3), (1.2, 2.8)], 4.0)
    monkeypatch.setattr(page, "record", lambda config: whole)
    monkeypatch.setattr(page, "found_by", page.found_by.__wrapped__)

    def counts(study, who="together", **how):
        return pd.DataFrame(study.one(1, who, **how)).set_index("view")

    return counts


def test_sensors_that_are_blind_ahead_find_those_behind_alone(both_seen):
    ours, other = both_seen(page.counted), both_seen(page.counted, blind=True)
    assert ours.matched["ahead"] > 0.8 * ours.people["ahead"]
    assert other.matched["ahead"] == 0
    assert other.matched["behind"] == ours.matched["behind"] > 0.8 * ours.people["behind"]


def test_sensors_that_hear_nothing_add_no_place(both_seen):
    ours, deaf = both_seen(page.counted), both_seen(page.counted, deaf=True)
    assert ours.matched["behind, by place"] > 0.8 * ours.people["behind"]
    assert deaf.matched["behind, by place"] < 0.5 * ours.people["behind"]
    assert deaf.matched["behind, by direction"] > 0.8 * ours.people["behind"]


def test_what_is_put_in_place_of_the_committee_changes_no_member(both_seen):
    second = {"together": ("laser",)}
    assert both_seen(page.counted, **second).equals(both_seen(page.counted, "laser alone"))
    for who in ("sonar alone", "without laser"):
        same = both_seen(page.counted, who, rules="strangers", **second)
        assert same.equals(both_seen(page.counted, who))
    strange = both_seen(page.counted, rules="strangers")
    assert strange.people.equals(both_seen(page.counted).people)
    assert not strange.equals(both_seen(page.counted))


def test_counts_are_called_by_other_names(both_seen):
    ours, camera = both_seen(page.counted), both_seen(page.counted, "camera alone")
    for how in ("ahead", "behind"):
        other = both_seen(page.relabelled, "camera alone", how=how)
        assert other.loc[how].equals(camera.loc["behind, by place"])
        assert len(other) == 1
    fourth = both_seen(page.relabelled, how="every fourth")
    assert (fourth.found * 3 == fourth.matched * 4).all()
    told = both_seen(page.relabelled, how="told")
    assert told.found.equals(ours.matched.rename("found"))
    assert both_seen(page.relabelled, "camera alone", how="told").equals(camera)


# Shares


def counts():
    """Return two sessions in which two systems find people everywhere, ahead and behind."""
    return rows(
        session=[1, 1, 2, 2, 1, 2], who=["together"] * 4 + ["without sonars"] * 2,
        view=["everywhere", "behind"] * 2 + ["behind"] * 2, people=[10, 4, 10, 6, 4, 6],
        found=[12, 3, 8, 4, 4, 4], matched=[8, 2, 6, 3, 1, 2],
    )  # fmt: skip


def test_shares_are_of_all_sessions_together():
    some = counts()
    together = some.where(who="together", view="everywhere")
    assert page.tracked(together).estimate == pytest.approx(14 / 20)
    assert page.false(together).estimate == pytest.approx(6 / 20)
    assert page.misses_behind(some).estimate == pytest.approx(5 / 6)
    assert page.over(some, "without sonars", "behind").estimate == pytest.approx(
        (2 / 4 + 3 / 6) / (1 / 4 + 2 / 6)
    )
    assert page.more(some, "behind").estimate == pytest.approx((1 / 4 + 1 / 6) / 2)
    assert page.false_more(some, "without sonars", "behind").estimate == pytest.approx(
        (1 / 3 + 1 / 4 - 3 / 4 - 2 / 4) / 2
    )


def test_the_gain_is_over_the_best_of_each_session():
    two = {"together": (9, 8), "laser alone": (9, 4), "sonar alone": (1, 1), "camera alone": (3, 8)}
    some = rows(
        session=[1, 2] * 4, who=np.repeat([*two], 2), view=["everywhere"] * 8, people=[10] * 8,
        found=[10] * 8, matched=[one for pair in two.values() for one in pair],
    )  # fmt: skip
    assert page.gain(some).estimate == pytest.approx(1.0)


# What does not move


def walker_and_chair(pace=0.0):
    """Return a session: somebody goes round the robot; a chair is turned round it at a pace."""
    whole = session([(2.0, -1.2), (2.0, 1.2)], 12.0, sees=("laser",))
    turned = np.arange(len(whole.times)) / len(whole.times) * 2.0
    places = whole.polar.copy()
    places[:, 0, 1] += turned  # the person walks, the chair does not
    means = whole.means.copy()
    lasers = np.repeat(np.arange(len(whole.counts)), whole.counts)
    pair = np.arange(len(means)) % 2
    means[:, 1] += np.where(pair == 0, turned[lasers], pace * whole.times[lasers])
    present = np.broadcast_to([True, False], whole.present.shape)
    return replace(whole, polar=places, means=means, present=present)


@pytest.mark.parametrize(("pace", "walkers", "static"), [(0.0, False, 1.0), (0.0, True, 0.0),
                                                         (0.12, False, 0.0)])  # fmt: skip
def test_what_stays_is_told_from_what_goes(monkeypatch, pace, walkers, static):
    whole = walker_and_chair(pace)
    monkeypatch.setattr(page, "record", lambda config: whole)
    found = page.settled.one(1, walkers=walkers)
    assert found["counted"] > 20
    assert found["static"] / found["followed"] == pytest.approx(static, abs=0.15)
    assert found["followed"] <= found["counted"]


@pytest.mark.parametrize(
    ("pace", "people", "things", "static"),
    [(0.0, False, 1.0, 1.0), (0.15, False, 1.0, 0.2), (0.0, True, 0.0, 0.0)],
)
def test_what_is_nobodys_stands_on_a_thing_and_is_static_if_it_stays(
    monkeypatch, pace, people, things, static
):
    whole = walker_and_chair(pace)
    monkeypatch.setattr(page, "record", lambda config: whole)
    found = page.grounded.one(1, people=people, rng=np.random.default_rng(1))
    assert found["counted"] > 20
    assert found["things"] == things * found["counted"]
    assert found["static"] / found["counted"] == pytest.approx(static, abs=0.1)
    assert 0 <= found["chance"] < 0.3 * found["counted"]


def test_between_two_readings_somebody_is_half_way():
    whole = session([(2.0, 0.5)], 4.0, sees=("laser",))
    places = whole.polar.copy()
    places[1:, 0] = [2.0, -0.5]  # between the first two readings
    moved, time = replace(whole, polar=places), whole.judged_at[:2].mean()
    half_way = np.array([[2.0 * np.cos(0.5), 0.0], [2.0, 0.5], [3.0, 0.2]])
    certain, vague = np.full(3, 0.1), np.full(3, 2.0)
    assert page.near_somebody(moved, time, half_way, certain).tolist() == [True, False, False]
    assert page.near_somebody(moved, time, half_way, vague).tolist() == [True, False, False]
    there = replace(moved, present=np.zeros_like(moved.present))
    assert not page.near_somebody(there, time, half_way, certain).any()


def test_a_hypothesis_is_compared_with_where_it_came_up_or_was_five_seconds_ago():
    run = page.committee(session([(2.0, -1.2)], 8.0, sees=("laser",)))
    times, k = run.told.judged_at[run.rows], len(run.rows) - 1
    name = run.found[k].identity[0]
    assert page.earlier(run, k, name) == pytest.approx(run.at(times[k] - page.LONG + 0.1).mean)
    early = int(np.searchsorted(times, 1.0))
    came = next(found for found in run.found if len(found))
    assert page.earlier(run, early, name) == pytest.approx(came.mean)


def test_of_a_slow_sensor_one_reading_of_four_is_left_and_others_stay():
    whole = session([(1.5, -1.2), (1.5, 2.0)], 6.0)
    slow, kind = page.slowed(whole, "sonar"), SENSORS.index("sonar")
    mine = np.flatnonzero(whole.sensors == kind)
    assert np.flatnonzero(slow.sensors == kind).tolist() == mine[::4].tolist()
    others = whole.sensors != kind
    assert (slow.sensors[others] == whole.sensors[others]).all()
    rows = page.committee(slow).rows
    assert len(rows) == others.sum() + len(mine[::4])
    turned = page.slowed(whole, "sonar", 1, np.pi)
    theirs = page.of_sensor(whole, "sonar")
    assert np.cos(turned.means[:, 1] - whole.means[:, 1]) == pytest.approx(1 - 2 * theirs)
    assert (turned.sensors == whole.sensors).all()


@pytest.mark.parametrize("sensor", ["laser", "camera"])
def test_a_sensor_adds_what_it_alone_sees(monkeypatch, sensor):
    """Each of three people is seen by one sensor alone."""
    whole = session([(3.0, 0.5), (1.5, 2.0), (1.5, -2.0)], 8.0)
    alone = np.argmax(np.abs(whole.means[:, [1]] - [0.5, 2.0, -2.0]) < 1e-6, axis=1)
    reading = np.repeat(whole.sensors, whole.counts)
    whole = page.without(whole, alone != reading)
    monkeypatch.setattr(page, "record", lambda config: whole)
    found = pd.DataFrame(page.slower.one(1, sensor)).assign(sensor=sensor)
    twice = pd.concat([found.assign(session=k) for k in (1, 2)])
    assert page.adds(Rows(twice, "session", {}), sensor).estimate > 1.1
    assert page.adds(Rows(twice, "session", {}), sensor, "left out").estimate == 1


def test_of_the_hypotheses_of_people_those_have_walked_whose_person_did():
    whole = session([(2.0, -1.2), (2.0, 1.2)], 4.0, sees=("laser",))
    places = whole.polar.copy()
    places[len(places) // 2 :, 1, 0] += 1.0  # the second person goes away
    moved, last = replace(whole, polar=places), len(places) - 1
    seen = page.judged(moved, last, hypotheses_at([(3.0, 1.2), (2.0, -1.2)]), View(by="place"))
    assert (seen.who.tolist(), seen.which.tolist()) == ([0, 1], [1, 0])
    assert page.walked(moved, last, 0.5, seen).tolist() == [0]


def test_to_discard_never_adds_a_false_one_and_to_move_does():
    """Of two people and three places, one place is nobody's; the place of a person is moved."""
    people = np.array([[0.0, 0.0], [5.0, 0.0]])
    found = np.array([[0.2, 0.0], [5.1, 0.0], [9.0, 9.0]])
    assert page.nobodys(people, found) == 1
    assert page.nobodys(people, found[1:]) == 1
    assert page.nobodys(people, found + 20.0 * np.eye(3)[:, :1] * [1, 0]) == 2
    assert page.nobodys(people[:0], found) == 3
