"""The studies: what is driven, what is compared with the truth, and what is counted."""

from types import SimpleNamespace

import numpy as np
import pytest

from data_synth.posts import glimpse
from data_synth.wheels import SMALL, roll
from robot_perception.book import loop_closing as loop
from robot_perception.evaluation.consistency import average_bounds
from robot_perception.observations import Observations
from robot_perception.slam import planar
from studies.intervals import bootstrap_mean
from studies.rows import Rows, framed
from tests.unchecked import unchecked

RNG = np.random.default_rng


# What came out of a run


def test_the_anchor_is_the_nearest_of_the_first_landmarks():
    sightings = [
        Observations(np.array([], int), np.empty((0, 2)), np.empty((0, 2, 2))),
        Observations(
            np.array([-1, 7, 4]), np.array([[1.0, 0], [5, 0], [2, 1]]), np.zeros((3, 2, 2))
        ),
    ]
    assert loop.first_seen(sightings) == 4


def history(poses, *, used, belief, frozen, sizes):
    """Return a history of three steps that states the identity for the pose."""
    counts = planar.run_filter(
        planar.MapBelief.start(np.zeros(3), np.eye(3)),
        [planar.Step(None)],
        planar.Settings(planar.CartesianSensor(np.eye(2))),
    ).counts
    return planar.History(
        start=np.zeros(3),
        times=np.full(3, np.nan),
        poses=np.array(poses),
        pose_covs=np.broadcast_to(np.eye(3), (3, 3, 3)),
        nis=np.zeros(3),
        dof=np.zeros(3, int),
        sizes=np.array(sizes),
        used=used,
        belief=belief,
        frozen=frozen,
        counts=counts,
        kept={},
        points={},
    )


@pytest.fixture
def compared():
    """A run whose third landmark enters twice, and whose fifth is once taken for it."""
    names = [np.array([3, 5]), np.array([3, 5]), np.array([5, 3])]
    landmarks = np.arange(12.0).reshape(6, 2)
    mean = np.r_[0, 0, 0, landmarks[3], landmarks[3] + [0.0, 1.0]]
    run = history(
        [[3.0, 4.0, 2 * np.pi - 0.1]] * 3,
        used=(np.array([0, 1]), np.array([0, 1]), np.array([0, 2])),
        belief=planar.MapBelief(mean, np.eye(7), np.array([0, 2])),
        frozen={1: landmarks[5]},
        sizes=[2, 2, 3],
    )
    seen = [Observations(n, np.zeros((2, 2)), np.zeros((2, 2, 2))) for n in names]
    return loop.compared(
        run, SimpleNamespace(landmarks=landmarks, poses=np.zeros((3, 3)), seen=seen)
    )


def test_wrong_matches_are_counted_against_whom_a_name_meant_at_first(compared):
    assert compared.wrong == 1
    assert compared.twice == 1


def test_errors_are_of_the_nearest_turn_and_the_first_pose_has_no_nees(compared):
    np.testing.assert_allclose(compared.errors, np.tile([3, 4, -0.1], (3, 1)), atol=1e-12)
    np.testing.assert_allclose(compared.off, 5)
    np.testing.assert_allclose(compared.nees, [25.01, 25.01])


def test_the_map_counts_what_has_left_the_state_and_cost_is_of_the_covariance(compared):
    assert compared.map == pytest.approx(np.sqrt(1 / 3))
    assert 0 < compared.shape < compared.map
    assert compared.cost == pytest.approx((49 + 49 + 81) / 3)
    assert compared.stated == pytest.approx(np.sqrt(2))


# The building


@pytest.fixture(scope="module")
def driven():
    """The first drive round the building, by the first filter of some settings."""
    with unchecked():
        return {name: Rows(framed([loop.rounded.trial(drive=0, setting=name)]), "drive", {})
                for name in (loop.KNOWN, loop.UNKNOWN)}  # fmt: skip


def test_landmarks_of_the_scans_are_true_ones():
    run, _ = loop.round_building(0)
    ids = np.concatenate([seen.ids for seen in run.seen])
    assert len(ids) > 2 * len(run.poses)
    assert np.mean(ids < 0) < 0.005
    times = loop.sighted.trial(drive=0)
    assert sum(times["times"]) == np.count_nonzero(ids >= 0)


def test_known_names_are_never_wrong_and_leave_no_landmark_twice(driven):
    known = driven[loop.KNOWN]
    assert not known.of("wrong").any()
    assert not known.of("twice").any()
    assert (known.of("shape") <= known.of("map") + 1e-12).all()  # a motion can only improve
    assert driven[loop.UNKNOWN].of("twice", filter="plain") > 0


def test_closing_the_loop_with_known_names_makes_the_error_small(driven):
    known, unknown = (driven[name].where(filter="plain") for name in (loop.KNOWN, loop.UNKNOWN))
    assert known.of("end") < known.of("before") / 5
    assert unknown.of("end") > 1


def test_the_start_is_out_of_sight_before_and_in_sight_at_the_end():
    poses, away = loop.building()[1], loop.BEYOND + 1.5 * loop.SCANNER.max_range
    before = len(poses) - 1 - int(away / loop.STEP)
    assert np.hypot(*poses[before, :2]) > loop.SCANNER.max_range
    assert np.hypot(*(poses[-1, :2] - poses[int(loop.BEYOND / loop.STEP), :2])) < 0.2
    assert 70 < loop.STEP * before < 80


def test_all_levels_of_noise_and_all_settings_of_a_drive_share_its_chance():
    run, _ = loop.round_building(0)
    small, large = (run.wheels[name] for name in ("small", "large"))
    errors = [(one.increments - large.increments) for one in (small, large)]
    assert np.abs(errors[0]).max() > 0
    again, _ = loop.round_building.__wrapped__(0)
    np.testing.assert_array_equal(again.start, run.start)
    other, _ = loop.round_building.__wrapped__(1)
    assert not np.allclose(other.start, run.start)


def test_names_are_told_only_where_they_are_known_and_the_anchors_once():
    run, _ = loop.round_building(0)
    first = loop.first_seen(run.seen)
    told = [step.observations.ids for step in loop.steps_of(run, "small", "gated", [first], False)]
    assert (told[0] == first).sum() == 1
    assert all((ids < 0).all() for ids in told[1:])
    known = loop.steps_of(run, "small", "known", [], False)
    assert all((s.observations.ids == o.ids).all() for s, o in zip(known, run.seen, strict=True))


def test_only_the_external_filter_gets_positions():
    run, _ = loop.round_building(0)
    inside, outside = (
        [len(step.fixes) for step in loop.steps_of(run, "small", "known", [], external)]
        for external in (False, True)
    )
    assert sum(inside) == 0
    assert [k for k, count in enumerate(outside) if count] == list(range(0, len(run.poses), 5))


# The posts


def test_what_a_run_saw_is_the_worlds_glimpse_with_its_covariance():
    world = loop.Loop(noise=2.0)
    places, poses = loop.posts_along(world.length, world.step)
    run = loop.round_posts(world, RNG(5))
    seen = glimpse(places, poses, sigma=0.06, reach=6.0, rng=RNG(5).spawn(4)[0])
    for sighting, (ids, at) in zip(run.seen, seen, strict=True):
        np.testing.assert_array_equal(sighting.ids, ids)
        np.testing.assert_array_equal(sighting.values, at)
        expected = np.broadcast_to(0.06**2 * np.eye(2), (len(ids), 2, 2))
        np.testing.assert_allclose(sighting.covs, expected)
    own = roll(poses, SMALL, rng=RNG(0)).deviations[0, 0]
    assert run.wheels["own"].deviations[0, 0] == pytest.approx(2 * own)


def test_a_shifted_start_errs_in_place_and_not_in_heading():
    run = loop.round_posts(loop.Loop(step=0.5), RNG(3))
    start = loop.filtered(run, "plain", "own", "known", "shifted").start - run.poses[0]
    np.testing.assert_allclose(start[:2], 0.1 * run.start[:2], atol=1e-12)
    assert start[2] == 0


def test_a_filter_may_believe_less_of_its_wheels_than_is_true():
    true, believed = (
        loop.round_posts(loop.Loop(noise=0.3, believed=share), RNG(6)).wheels["own"]
        for share in (1.0, 0.25)
    )
    np.testing.assert_array_equal(believed.increments, true.increments)
    np.testing.assert_allclose(believed.deviations, true.deviations / 4)


def test_averages_are_over_runs_and_of_the_same_chance():
    world, ways = loop.Loop(length=30.0, step=0.5, noise=3.0, start="uncertain"), ("plain", "ideal")
    found = loop.averaged(world, ways, [(3, 0), (3, 1)])
    runs = [loop.round_posts(world, loop.chance(3, k)) for k in range(2)]
    for way in ways:
        each = [loop.compared(loop.filtered(run, way, "own", "known", world.start), run)
                for run in runs]  # fmt: skip
        squares = [one.errors[:, 0] ** 2 + one.errors[:, 1] ** 2 for one in each]
        np.testing.assert_allclose(found.rms[way] ** 2, np.mean(squares, axis=0))
        turned = [np.rad2deg(one.errors[:, 2]) ** 2 for one in each]
        np.testing.assert_allclose(found.heading[way] ** 2, np.mean(turned, axis=0))
        np.testing.assert_allclose(found.nees[way], np.mean([one.nees for one in each], axis=0))
    assert (found.runs, found.step) == (2, 0.5)


def test_the_average_nees_of_the_recorded_runs_is_that_of_their_means():
    rows = loop.honest.rows()
    for world in rows.levels("world"):
        for way, values in loop.along_path(world).nees.items():
            assert values.mean() == pytest.approx(rows.of("nees", world=world, filter=way).mean())


@pytest.mark.parametrize("way", loop.JACOBIANS[:5])
def test_noise_of_linear_size_leaves_the_filters_consistent(way):
    nees = loop.along_path("linear").nees[way]
    low, high = average_bounds(3, 50, 1 - 1e-4)
    assert all(low < nees[step] < high for step in (4, 100, 300, -1))
    # steps of a run hang together, so that the share varies; see the next test for what it is
    assert loop.consistency(loop.honest.rows(), "linear")[way, "in band"] > 0.75


def test_share_of_steps_in_the_band_is_what_honest_errors_of_such_memory_give():
    """Errors drawn from the filter's own covariances, with the runs' memory, fill the band so."""
    nees = loop.along_path("linear").nees["first estimates"]
    averages = nees - 3
    memory = np.corrcoef(averages[:-1], averages[1:])[0, 1]
    shocks = RNG(0).standard_normal((200, averages.size, 150))
    state, inside = RNG(1).standard_normal((200, 150)), np.zeros(200)
    low, high = average_bounds(3, 50)
    for k in range(averages.size):
        root = np.sqrt(max(memory, 0.0))  # squares remember the square of what errors remember
        state = root * state + np.sqrt(1 - root**2) * shocks[:, k]
        mean = (state**2).sum(axis=1) / 50
        inside += (low < mean) & (mean < high)
    least = np.quantile(inside / averages.size, 1e-2)
    assert np.mean((low < nees) & (nees < high)) >= least


def test_table_has_the_numbers_of_each_filter():
    rows = loop.honest.rows()
    table = loop.consistency(rows, "turned")
    assert list(table.rows) == list(loop.JACOBIANS)
    for way in loop.JACOBIANS:
        here = rows.where(world="turned", filter=way)
        assert table[way, "NEES"] == bootstrap_mean(here.of("nees"))
        assert table[way, "end (m)"].estimate == here.of("end").mean()


# The rule


def test_considered_landmarks_keep_the_filter_honest_and_frozen_ones_do_not():
    rows = loop.frozen.rows().where(start="exact")
    assert rows.of("retired", filter="rule at 50").min() > 20
    assert loop.over_unruled(rows, "cost", "exact").high < 0.2
    assert loop.over_unruled(rows, "cost", "exact", "considered at 50").estimate == 1
    assert loop.over_unruled(rows, "path", "exact").high < 1.5
    assert loop.over_unruled(rows, "nees", "exact").low > 30
    considered = loop.over_unruled(rows, "nees", "exact", "considered at 50")
    assert considered.estimate == pytest.approx(1, abs=0.2)


def test_the_rule_states_less_than_it_errs_and_the_others_what_they_err():
    table = loop.by_rule(loop.frozen.rows(), "exact")
    for way in ("plain", "considered at 50"):
        stated, error = (table[way, c].estimate for c in ("stated (m)", "path error (m)"))
        assert 0.5 < stated / error < 2
    assert table["rule at 50", "stated (m)"].estimate < table["rule at 50", "path error (m)"].low


def test_by_rank_two_removed_landmarks_are_enough_and_one_is_not():
    found = [loop.left.trial(removed=count) for count in range(3)]
    assert [one["unseen"] for one in found] == [3, 1, 0]
    assert loop.left.but(observed=False).trial(removed=2)["unseen"] == 3
    shares = [one["before"] for one in found]
    assert shares[0] == 0 < shares[1] < shares[2]


def test_the_second_landmark_leaves_when_the_filter_says_so():
    """By the sizes of the map that the filter keeps: it drops twice before the share is over."""
    run = loop.round_posts(loop.Loop(step=0.1), RNG(3))
    sizes = loop.filtered(run, "rule at 50", "own", "known", "exact").sizes
    seen = [set(step.ids.tolist()) for step in run.seen]
    known = [len(set().union(*seen[: k + 1])) for k in range(len(seen))]
    for removed in (1, 2):
        share = np.mean(np.array(known) - sizes < removed)
        assert loop.left.trial(removed=removed)["before"] == pytest.approx(share)
