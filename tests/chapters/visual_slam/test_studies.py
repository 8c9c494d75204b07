"""Front end, drives, topology and exact maps, on what can be worked out otherwise."""

from dataclasses import replace
from functools import cache
from types import SimpleNamespace

import numpy as np
import pandas as pd
import pytest
from scipy.spatial.distance import cdist

from data_synth import stereo
from robot_perception.book import visual_slam as slam
from robot_perception.chapters.visual_slam import figures, recordings
from robot_perception.geometry import se3
from robot_perception.landmarks.metrics import euclidean_mean
from robot_perception.observations import Observations
from robot_perception.particles import StepInfo
from robot_perception.slam.visual import FrameInfo
from studies.intervals import bootstrap_mean
from studies.rows import Rows
from studies.verdicts import deciding
from tests.chapters.visual_slam.drives import ages, asked_of, begun
from tests.unchecked import unchecked

RNG = np.random.default_rng


@cache
def driven(count=10):
    """Return a drive over it with so many particles."""
    seen = begun()
    with unchecked():
        return slam.drive_through(seen, slam.Options(count), slam.roll(seen.poses, RNG(3)), RNG(4))


@pytest.fixture(scope="module")
def seen():
    return begun()


def test_points_lie_where_the_renderer_says(seen):
    """In the middle half a decimetre: some pairs do not belong together."""
    _, poses = slam.world()
    rows = RNG(0).choice(len(seen.points), 500, replace=False)
    gaps = []
    for row in rows:
        at = stereo.project(slam.RIG, poses[seen.frames[row]], seen.places[row][None])[0]
        assert at[:2] == pytest.approx(seen.pixels[row], abs=1e-6)
        gaps.append(abs(seen.points[row, 2] - at[2]) / at[2])
    assert np.median(gaps) < 0.02


def test_points_surprise_as_their_covariances_say():
    """Errors drawn from the covariances, seen from poses on a curve: the mean of χ² of 3 is 3.

    Without errors nothing surprises; a point that comes before its landmark is not compared.
    """
    rng, frames, tracks, stable = RNG(7), 9, 400, 2
    poses = np.column_stack([np.linspace(0, 3, frames), rng.normal(size=(frames, 2))])
    places = rng.normal(size=(tracks, 3)) * [1, 1, 0.2] + [9, 0, 1]
    k, n = (grid.ravel() for grid in np.mgrid[:frames, :tracks])
    inverse = np.linalg.inv(se3.compose(se3.from_se2(poses), slam.MOUNT))[k]
    exact = np.einsum("nij,nj->ni", inverse[:, :3, :3], places[n]) + inverse[:, :3, 3]
    root = 0.1 * rng.normal(size=(len(k), 3, 3)) + 0.1 * np.eye(3)
    errors = np.einsum("nij,nj->ni", root, rng.normal(size=(len(k), 3)))
    none = np.zeros(len(k))

    def seen_with(errors):
        covs = root @ root.mT
        return slam.Seen(poses, k, n, none, exact + errors, covs, none, places[n], none)

    assert slam.surprises(seen_with(0 * errors), stable).max() < 1e-18
    found = slam.surprises(seen_with(errors), stable)
    assert found.shape == ((frames - stable - 1) * tracks,)
    assert found.mean() == pytest.approx(3, abs=0.2)
    errors[k < stable] += 100.0
    np.testing.assert_allclose(slam.surprises(seen_with(errors), stable), found)


def test_a_track_is_one_place(seen):
    """Of the stable tracks nine in ten stay within a decimetre of where they began."""
    lengths = np.bincount(seen.tracks)
    stay = []
    for track in RNG(1).choice(np.flatnonzero(lengths > 5), 200, replace=False):
        rows = np.flatnonzero(seen.tracks == track)
        assert (np.diff(seen.frames[rows]) == 1).all()
        stay.append(np.ptp(seen.places[rows], axis=0).max() < 0.1)
    assert np.mean(stay) > 0.9


def test_points_of_one_frame_are_wrong_in_depth_more_often(seen):
    _, poses = slam.world()
    lengths = np.bincount(seen.tracks)[seen.tracks]
    depths = [
        stereo.project(slam.RIG, pose, seen.places[seen.frames == k])[:, 2]
        for k, pose in enumerate(poses)
    ]
    wrong = np.abs(seen.points[:, 2] / np.concatenate(depths) - 1) > 0.1
    once, stay = slam.wrong_depths(seen)
    assert [once, stay] == pytest.approx([wrong[lengths == 1].mean(), wrong[lengths > 5].mean()])
    assert 1.5 * stay < once


def test_errors_of_a_disparity_last(seen):
    """In neighbouring frames they correlate by about one half."""
    T = se3.compose(se3.from_se2(seen.poses), slam.RIG.T_robot_camera)[seen.frames]
    truth = np.einsum("ni,ni->n", T[:, :3, 2], seen.places - T[:, :3, 3])
    errors = slam.RIG.focal_px * slam.RIG.baseline * (1 / seen.points[:, 2] - 1 / truth)
    order = np.lexsort((seen.frames, seen.tracks))
    lasting = (np.bincount(seen.tracks) > 5)[seen.tracks] & (np.abs(errors) < 3)
    one, next_ = order[:-1], order[1:]
    pairs = (seen.tracks[one] == seen.tracks[next_]) & lasting[one] & lasting[next_]
    correlation = np.corrcoef(errors[one[pairs]], errors[next_[pairs]])[0, 1]
    assert 0.4 < correlation < 0.6


def recognised(drive):
    """Return points, landmarks and gaps (m) of the tracks that were taken for a landmark."""
    seen, first = drive.seen, np.flatnonzero(ages(drive.seen) == 6)
    new = np.isin(drive.rows, first) & (drive.rows != drive.founders[drive.names])
    rows, names = drive.rows[new], drive.names[new]
    return rows, names, np.linalg.norm(seen.places[rows] - drive.places[names], axis=1)


def test_a_track_that_is_taken_for_a_landmark_far_away_is_taken_wrongly():
    drive = driven()
    gaps = recognised(drive)[2]
    assert (len(gaps), np.count_nonzero(gaps > slam.SAME)) == (drive.matched, drive.wrong)
    assert 0 < drive.wrong < drive.matched


def test_points_of_stable_tracks_are_used_and_each_is_looked_up():
    """Each track of more than five frames is recognised or a landmark; later points may be lost."""
    drive = driven()
    age = ages(drive.seen)
    assert age[drive.rows].min() == 6
    assert np.isin(np.flatnonzero(age == 6), drive.rows).all()
    assert np.count_nonzero(age == 6) == drive.matched + len(drive.places)
    used, made = (
        np.bincount(frames, minlength=len(drive.poses))
        for frames in (drive.seen.frames[drive.rows], drive.seen.frames[drive.founders])
    )
    assert (used - made == drive.observed).all()


def test_costs_are_asked_of_the_metric(seen):
    """By default distances to the mean descriptors; a metric that likes nothing recognises none."""
    report = slam.roll(seen.poses, RNG(2))
    asked = []

    def watching(question):
        asked.append(question)
        return euclidean_mean(question)

    one, other, none = (
        slam.drive_through(seen, slam.Options(2), report, RNG(4), ask)
        for ask in (
            lambda rows, founders: euclidean_mean,
            lambda rows, founders: watching,
            lambda rows, founders: lambda q: 1e9 + euclidean_mean(q),
        )
    )
    assert (one.poses == other.poses).all()
    assert (one.names == other.names).all()
    assert one.matched > none.matched == 0
    for question in asked:
        expected = cdist(question.descriptors, question.looks.means)
        assert euclidean_mean(question) == pytest.approx(expected, abs=1e-4)


@pytest.fixture(scope="module")
def each():
    """Return a drive on which particles do not agree: weights are dull, and the gate is narrow."""
    seen = begun()
    report = slam.roll(seen.poses, RNG(3))
    options = slam.Options(6, share=0.3, level=0.5, reach=0.0, noise=8.0, association="each")
    with unchecked():
        return slam.drive_through(seen, options, report, RNG(4))


def test_where_each_names_by_its_own_map_the_heaviest_is_scored(each):
    """Its map is the exact one of its path and of the points that it is said to have used."""
    best, known = each.maps.best, each.maps.known
    assert 10 < each.drawn.sum() < 100
    assert len(each.founders) == known[best].sum() < each.maps.ids.size
    exact, _ = slam.exact_map(each, each.path)
    assert exact == pytest.approx(each.means, abs=1e-8)


def test_where_each_names_by_its_own_map_points_are_used_and_each_is_looked_up(each):
    age = ages(each.seen)
    assert np.isin(np.flatnonzero(age == 6), each.rows).all()
    assert np.count_nonzero(age == 6) == each.matched + len(each.places)
    used, made = (
        np.bincount(frames, minlength=len(each.poses))
        for frames in (each.seen.frames[each.rows], each.seen.frames[each.founders])
    )
    assert (used - made == each.observed).all()
    gaps = recognised(each)[2]
    assert (len(gaps), np.count_nonzero(gaps > slam.SAME)) == (each.matched, each.wrong)


@pytest.mark.parametrize("best", range(4))
def test_of_each_frame_counts_what_the_ancestor_of_the_best_made(best):
    """Names that tell frame and particle, and ancestors that no two particles share."""
    rng = RNG(5)
    ancestors = [rng.permutation(4) for _ in range(6)]
    tags = np.arange(24).reshape(6, 4, 1)
    infos = [
        FrameInfo(tag, np.ones(1, dtype=bool), tag % 2 == 0, StepInfo(4.0, True, before, 0.0))
        for tag, before in zip(tags, ancestors, strict=True)
    ]
    found, m = slam.of_best(infos, best), best
    for frame in range(5, -1, -1):
        assert found[frame].names == tags[frame, m]
        assert found[frame].new == (tags[frame, m] % 2 == 0)
        m = ancestors[frame][m]


def test_the_same_place_lies_on_the_same_surface(seen):
    rows = np.flatnonzero(seen.tracks == np.argmax(np.bincount(seen.tracks)))[:3]
    assert (slam.apart(seen, rows, rows) < slam.AGAIN).all()
    others = seen._replace(carriers=np.arange(len(seen.carriers)))
    assert (np.isfinite(slam.apart(others, rows, rows)) == np.eye(3)).all()


def test_what_is_in_the_map_again_was_there_before():
    drive = driven()
    near = cdist(drive.places, drive.places) < slam.AGAIN
    carriers, made = drive.seen.carriers[drive.founders], drive.seen.frames[drive.founders]
    same, before = carriers[:, None] == carriers, made[:, None] > made
    assert drive.twice == (near & same & before).any(axis=1).sum() > 0


def test_the_filter_takes_what_the_wheels_report():
    poses = slam.world()[1]
    report = slam.roll(poses, RNG(2))
    motion = slam.motions(report)[6]
    assert (motion.increment == report.increments[6]).all()
    assert np.sqrt(np.diag(motion.increment_cov)) == pytest.approx(report.deviations[6])


def test_the_path_is_that_of_ancestors():
    drive = driven()
    m = drive.maps.best
    for k in range(len(drive.poses) - 1, 60, -1):
        assert (drive.path[k] == drive.poses[k, m]).all()
        m = drive.ancestors[k, m]
    assert (slam.survivors(drive)[:-60] == 1).all()


def test_the_paths_to_a_frame_are_those_of_its_particles():
    drive = driven()
    paths, alive = slam.paths(drive, 80), slam.survivors(drive, 80)
    assert (paths[80] == drive.poses[80]).all()
    assert (paths[79] == drive.poses[79, drive.ancestors[80]]).all()
    assert [len(alive), alive[79], alive[80]] == [81, len(set(drive.ancestors[80])), 10]


def test_told_the_names_nothing_is_wrong(seen):
    report = slam.roll(seen.poses, RNG(3))
    with unchecked():
        drive = slam.drive_through(seen, slam.Options(), report, RNG(4), slam.told(seen))
    assert drive.matched > 0
    assert drive.wrong == 0
    assert recognised(drive)[2].max() < slam.AGAIN


def true_map(off=0.0):
    """Return the true path, torn by so many metres half way, and a landmark in each room."""
    truth, places = slam.world()[1], np.pad(slam.rooms().mean(axis=1), ((0, 0), (0, 1)))
    path = truth.copy()
    path[len(path) // 2 :, 1] += off
    return SimpleNamespace(
        path=path, means=places, places=places, seen=SimpleNamespace(poses=truth)
    )


def test_a_map_is_right_where_rooms_order_and_visits_all_are(monkeypatch):
    drive, floors = true_map(), slam.rooms()
    assert slam.topology(drive, floors).right
    with monkeypatch.context() as patch:
        patch.setattr(slam, "torn_by", lambda errors, passed: 0.6)
        assert not slam.topology(drive, floors).right
    with monkeypatch.context() as patch:
        patch.setattr(slam, "SHARE_RIGHT", 1.01)
        assert not slam.topology(drive, floors).right
    with monkeypatch.context() as patch:
        orders = iter([[0, 1], [1, 0]])
        patch.setattr(slam, "order", lambda passed: next(orders))
        found = slam.topology(drive, floors)
        assert not found.ordered
        assert not found.right


def test_a_torn_map_is_not_right():
    found = slam.topology(true_map(off=1.5), slam.rooms())
    assert found.torn > slam.MARGIN
    assert not found.right


def test_wheels_that_err_not_put_landmarks_where_they_are():
    drive = driven()
    exact = slam.by_wheels(replace(drive, odometry=drive.seen.poses))
    assert np.median(np.linalg.norm(exact.means - exact.places, axis=1)) < 0.05
    moved = drive.seen.poses + np.array([1.0, 2.0, 0.0])
    shifted = slam.by_wheels(replace(drive, odometry=moved)).means - exact.means
    assert shifted == pytest.approx(np.tile([1.0, 2.0, 0.0], (len(shifted), 1)))


def test_right_maps_are_counted_by_what_is_asked():
    maps = {"inside": [1, 1, 0.9, 1], "ordered": [True, False, True, True], "torn": [0, 0, 0, 3]}
    table = {"building": [0, 0, 1, 1]} | maps | {f"alone_{k}": v[::-1] for k, v in maps.items()}
    rows = Rows(pd.DataFrame(table), "building", {})
    for how, shares in (
        ({}, [0.5, 0.5]),
        ({"order": False}, [1.0, 0.5]),
        ({"torn": 2.0}, [0.5, 0.0]),
        ({"order": False, "torn": 2.0}, [1.0, 0.0]),
        ({"whose": "alone_", "order": False}, [0.5, 1.0]),
    ):
        assert slam.shares(rows, **how).tolist() == shares, how
    assert slam.right_maps(rows, order=False).estimate == 0.75
    always = slam.right_maps(rows.where(torn=0, inside=1), order=False)  # a rate of one building
    assert 0 < always.low < always.high == 1


def test_more_particles_are_compared_building_by_building():
    table = {"building": [0, 0, 1, 1], "particles": [50, 400] * 2, "inside": 1.0, "torn": 0.0}
    rows = Rows(pd.DataFrame(table | {"ordered": [False, True, True, True]}), "building", {})
    assert slam.more_with(rows, 400, 50).estimate == 0.5


def test_the_least_sure_share_stands_for_all():
    table = pd.DataFrame({"building": range(4), "particles": 10, "ordered": True, "torn": 0.0})
    studies = [
        SimpleNamespace(
            rows=lambda k=k: Rows(table.assign(inside=np.arange(4) < k), "building", {})
        )
        for k in (3, 1, 4)
    ]
    assert slam.at_worst(studies, 10).estimate == 0.25


def test_plans_are_driven_with_other_wheels_pictures_names_and_particles(monkeypatch):
    asked = []

    def seen_in(building, alike):
        return SimpleNamespace(poses=slam.world()[1], alike=alike)

    def drive_through(seen, options, report, rng, *ask):
        wheels = slam.dead_reckoning(seen.poses[0], slam.motions(report))
        asked.append((seen.alike, options.particles, len(ask), wheels - seen.poses))

    for name, one in (("seen_in", seen_in), ("drive_through", drive_through)):
        monkeypatch.setattr(slam, name, one)
    monkeypatch.setattr(slam, "judged", lambda drive, floors: {})
    monkeypatch.setattr(slam, "rooms", lambda building, alike: None)
    for changes in ({}, {"slip": 0.01}, {"alike": False}, {"named": True}, {"only": 1}):
        slam.planned.one(310, 0, 10, **changes)
    kinds = [(alike, particles, ask) for alike, particles, ask, _ in asked]
    assert kinds == [(True, 10, 0), (True, 10, 0), (False, 10, 0), (True, 10, 1), (True, 1, 0)]
    ours, small, *others = (np.abs(off[:, :2]).max() for *_, off in asked)
    assert small < 0.05 * ours
    assert others == [ours] * 3


def test_what_decides_is_how_much_the_wheels_err(monkeypatch):
    """Up to ours where maps hold with ours; up to half of ours where they fail, or nobody knows."""
    few, many, some = (bootstrap_mean(np.array(ends)) for ends in ([0, 0.2], [0.8, 1], [0.2, 0.9]))
    names = {id(study): name for name, study in slam.BY_WHEELS.items()}
    for ours, last, decides in ((many, many, 0), (few, many, 1), (some, many, 1), (few, few, None)):
        found = dict.fromkeys(names.values(), many)
        found |= {"three times ours": few, "ours": ours, "a tenth": last}

        def at_worst(studies, count, found=found):
            return min((found[names[id(one)]] for one in studies), key=lambda share: share.low)

        monkeypatch.setattr(slam, "at_worst", at_worst)
        monkeypatch.setattr(slam, "right_maps", lambda rows, ours=ours: ours)
        rows = SimpleNamespace(where=lambda particles: None)
        judged = [one.judged(rows, slam.MORE_OFTEN) for one in slam.wheels_decide(10)]
        decide = deciding(slam.MORE_OFTEN, ours, judged)
        assert list(decide) == ([] if decides is None else [judged[decides]])


def test_visits_of_a_room_lie_apart_by_their_mean_errors():
    passed = np.repeat([0, 1, 0, 2, 1], [6, 8, 5, 4, 9])
    errors = np.zeros((len(passed), 2))
    errors[14:19] = [0.3, 0.4]  # the second visit of the first room
    errors[23:] = [0.0, 0.2]  # of the second
    assert slam.torn_by(errors, passed) == pytest.approx(0.5)
    assert slam.torn_by(errors[:14], passed[:14]) == 0.0
    assert slam.order(passed) == [0, 1, 0, 2, 1]


def test_rooms_are_the_floors_and_the_order_is_that_of_the_drive():
    floors = slam.rooms()
    assert len(floors) == 7
    assert (floors[:, 1] > floors[:, 0]).all()
    order = slam.order(slam.room_of(slam.world()[1], floors))
    assert len(order) > 8
    assert len(set(order)) == 6  # nobody enters one room


def test_exact_maps_are_not_those_of_another_path():
    drive = driven()
    exact, cov = slam.exact_map(drive, drive.path)
    assert exact == pytest.approx(drive.means, abs=1e-8)
    moved, _ = slam.exact_map(drive, drive.path + np.array([0.1, 0, 0]))
    assert moved - exact == pytest.approx(np.tile([0.1, 0, 0], (len(exact), 1)), abs=1e-8)
    assert (np.linalg.eigvalsh(cov) > 0).all()


def test_numbers_of_weights():
    printed, effective = slam.both_numbers(np.array([0.5, 0.25, 0.25]))
    assert printed == pytest.approx(1)
    assert effective == pytest.approx(1 / 0.375)


def test_lasting_points_keep_their_tracks(seen):
    long = slam.lasting(seen, 5)
    lengths = np.bincount(long.tracks)
    assert lengths.min() > 5
    assert len(lengths) == np.count_nonzero(np.bincount(seen.tracks) > 5)


def test_buildings_have_one_plan_and_are_hung_and_driven_otherwise():
    (one, path), (other, way), floors = slam.world(), slam.world(1), slam.rooms()
    assert (one.plan == other.plan).all()
    assert slam.order(slam.room_of(path, floors)) == slam.order(slam.room_of(way, floors))
    assert np.abs(path - way)[:, :2].max() > 0.0
    assert one.kinds.tolist() != other.kinds.tolist()
    assert not {0, *slam.CHOOSING} & set(slam.SCORED)


def test_sabotages_change_one_thing(monkeypatch):
    asked = asked_of(monkeypatch, slam)
    slam.held.one(200, 0, 5, five=0)
    slam.held.one(200, 0, 0, five=0)
    slam.stabled.one(21, 0, 5, least=5)
    assert [options.stable for options, _, _ in asked] == [0, 0, 5]
    assert asked[-1][2]["least"] == 5
    for rule, more in (("below M/2", {}), ("always", {}), ("below M/2", {"ours": "never"}),
                       ("always", {"other": "never"})):  # fmt: skip
        slam.redrawn.one(200, 0, 50, rule, **more)
    assert [options.share for options, _, _ in asked[-4:]] == [0.5, 1.0, 0.0, 0.0]
    assert all(more == {"framed": True} for *_, more in asked[-4:])
    for rule, few in (("below M/2", 50), ("below M/2", 1), ("always", 50), ("always", 1)):
        slam.spared.one(240, 0, rule, few=few)
    assert [options.particles for options, _, _ in asked[-4:]] == [50, 50, 50, 1]
    assert [options.share for options, _, _ in asked[-4:]] == [0.5, 0.5, 1.0, 1.0]


def test_drives_of_all_filters_have_the_same_wheels_and_draws(monkeypatch):
    seen = begun()
    monkeypatch.setattr(slam, "seen_in", lambda building, alike, **how: seen)
    with unchecked():
        one, other, third = (slam.driven(1, 21, draw, slam.Options(2)) for draw in (0, 0, 1))
    assert one == other
    assert one["wheels"] != third["wheels"]
    keys = {slam.luck(building, draw, 1)[0].integers(10**9) for building in (21, 22, 200)
            for draw in range(3)}  # fmt: skip
    assert len(keys) == 9


def test_with_the_same_numbers_in_each_frame_rules_differ_where_a_draw_is_spared():
    """And not before: whatever one of the two has drawn, the next frame is the same."""
    report = slam.roll(begun().poses, RNG(2))
    ours, always = (
        slam.drive_through(
            begun(), slam.Options(4, share=share, noise=20.0), report, RNG(3).spawn(120)
        )
        for share in (0.5, 1.0)
    )
    spared = np.flatnonzero(ours.drawn != always.drawn)
    assert spared.size
    first = spared[0]
    assert first > 5
    assert (ours.poses[:first] == always.poses[:first]).all()
    assert (ours.poses[first:] != always.poses[first:]).any()


def test_all_descend_from_some():
    """Of ancestors that are known: one of four from the first, or each from itself."""
    drive = driven()
    none = replace(drive, ancestors=np.tile(np.arange(10), (61, 1)))
    assert slam.related(none) == 1.0
    pairs = np.tile(np.arange(10), (61, 1))
    pairs[[15, 35, 55]] = np.arange(10) // 2  # once in each twenty frames
    assert slam.related(replace(drive, ancestors=pairs)) == 0.5


def test_a_map_in_plain_arrays_has_means_and_covariances_for_each_particle():
    maps = driven().maps
    assert slam.plain(driven()) == maps.means.nbytes + maps.covs.nbytes


def test_the_law_of_the_number_that_counts():
    """Of weights that are drawn: a normal spread, judged by points of some sharpness."""
    for r in (0.3, 0.8, 2.0):
        x = RNG(1).standard_normal((200_000, 3))
        w = np.exp(-(x**2).sum(axis=1) / (2 * r**2))
        assert slam.law(r) == pytest.approx(w.mean() ** 2 / (w**2).mean(), rel=0.05)


def rows_of(**measures):
    """Return rows of three buildings, two drives each, with some measures."""
    table = pd.DataFrame({"building": [1, 1, 2, 2, 3, 3], "draw": [0, 1] * 3} | measures)
    return Rows(table, "building", {})


def test_means_and_ratios_are_those_of_buildings():
    """Of the drives through one building the mean is taken first."""
    rows = rows_of(
        path=[1.0, 3, 4, 6, 0, 2], wrong=[1, 1, 0, 2, 1, 1], matched=[10, 10, 5, 5, 4, 4]
    )
    found, of_means = slam.mean(rows, "path", "m"), bootstrap_mean(np.array([2.0, 5.0, 1.0]), "m")
    assert replace(found, about="") == replace(of_means, about="")
    twice = rows_of(path=[2.0, 6, 8, 12, 0, 4])
    assert slam.ratio(twice, rows, "path").estimate == 2.0
    assert slam.worst(rows) == 5.0
    assert slam.wrong_share(rows) == pytest.approx([0.1, 0.2, 0.25])


def test_half_of_the_landmarks_are_less_misplaced():
    drive = driven()
    motion = slam.align(drive.path, drive.seen.poses)
    gaps = np.linalg.norm(slam.act(motion, drive.means[:, :2]) - drive.places[:, :2], axis=1)
    found = slam.account(drive, slam.rooms())
    assert np.mean(gaps <= found["places"]) == pytest.approx(0.5, abs=0.01)


def test_accounts_say_what_the_drives_did():
    one, ten = (driven(count) for count in (1, 10))
    first, second = (slam.account(drive, slam.rooms()) for drive in (one, ten))
    assert [found["landmarks"] for found in (first, second)] == [len(d.places) for d in (one, ten)]
    weighed = ten.effective[ten.observed > 0]
    assert [first["effective"], second["effective"]] == pytest.approx([1, weighed.mean() / 10])


def test_turned_points_are_those_of_a_view_from_a_height():
    """What is level turns; what is upright stays upright; a full turn changes nothing."""
    foot, top = np.array([[3.0, -2.0, 0.0], [3.0, -2.0, 2.0]])
    for turn in (0, 30, 135):
        low, high = figures.turned(np.stack([foot, top]), turn)
        assert high - low == pytest.approx([0, 2 * np.cos(np.deg2rad(35))])
    axes = np.array([10.0, 1.1, 0.0]) + np.vstack([np.zeros(3), np.eye(3)])
    origin, x, y, _ = figures.turned(axes, 90)
    assert origin == pytest.approx(np.zeros(2))
    assert x == pytest.approx([0, np.sin(np.deg2rad(35))])  # away from the reader
    assert y == pytest.approx([-1, 0])
    assert figures.turned(axes, 360) == pytest.approx(figures.turned(axes, 0))


def test_the_path_of_a_camera_in_the_plane():
    """Its z axis looks ahead, its x axis to the right: a turn to the left is a positive one."""
    a = 0.3
    turned = np.eye(4)
    turned[:3, 2], turned[:3, 0] = [-np.sin(a), 0, np.cos(a)], [np.cos(a), 0, np.sin(a)]
    turned[:3, 3] = [2.0, 0.5, 7.0]
    assert recordings.planar(np.stack([np.eye(4), turned])) == pytest.approx(
        np.array([[0, 0, 0], [7, -2, a]])
    )


def test_heights_of_a_recording_count_less_the_farther_they_are():
    points, covs = np.array([[0.0, 0, 5], [0, 0, 20]]), np.stack([np.eye(3)] * 2)
    looser = recordings._loosened(Observations(np.arange(2), points, covs)).covs
    assert looser - covs == pytest.approx(
        np.array([np.diag([0, 0.05**2, 0]), np.diag([0, 0.2**2, 0])])
    )
    assert (covs == np.eye(3)).all()
