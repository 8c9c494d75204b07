"""Names, right ones and wrong ones, and filters that get them, on what can be worked out."""

from types import SimpleNamespace

import numpy as np
import pytest
from scipy.spatial.distance import cdist

from data_synth.wheels import true_increments
from robot_perception.book import look_alikes as look
from robot_perception.evaluation.trajectories import absolute_error
from robot_perception.geometry import act, compose, inverse, se3
from robot_perception.landmarks.metrics import METRICS
from tests.chapters.visual_slam.drives import ages, asked_of, begun
from tests.unchecked import unchecked

RNG = np.random.default_rng


@pytest.fixture(scope="module")
def seen():
    return begun(200)


def test_limits_are_those_that_as_many_right_pairs_pass(monkeypatch):
    """Of made-up distances, and of the buildings that they were chosen in."""
    first, *others = METRICS
    own = {name: np.linspace(0, 200, 401) * (k + 1) for k, name in enumerate(METRICS)}
    with monkeypatch.context() as patch:
        patch.setattr(look, "seen_in", lambda building: building)
        patch.setattr(look, "right_pairs", lambda seen, metrics, stable: own)
        found = look.limits()
    assert found[first] == pytest.approx(150, abs=0.5)
    assert [found[name] / found[first] for name in others] == pytest.approx([2, 3, 4])


@pytest.mark.slow
def test_the_limits_are_those_of_the_buildings_that_they_were_chosen_in():
    found = look.limits(METRICS | look.DENSITIES)
    assert found == pytest.approx(look.ALL_LIMITS, rel=0.005)
    pace = {"slowness": look.SLOWNESS, "patience": 2}
    slow = look.limits({name: METRICS[name] for name in look.SLOW_LIMITS}, look.LONG, **pace)
    assert slow == pytest.approx(look.SLOW_LIMITS, rel=0.005)


def test_right_pairs_are_tracks_of_one_place_by_their_first_frames(seen):
    rows = look.beginnings(seen)
    assert rows.shape[1] == 6
    assert (seen.tracks[rows] == seen.tracks[rows[:, :1]]).all()
    assert (np.diff(seen.frames[rows], axis=1) == 1).all()
    assert (ages(seen)[rows[:, 0]] == 1).all()
    assert len(rows) == np.count_nonzero(np.bincount(seen.tracks) > 5)
    with unchecked():
        right = look.right_pairs(seen)
    means = seen.descriptors[rows].astype(float).mean(axis=1)
    last = rows[:, -1]
    earlier = seen.frames[rows[:, 0]][:, None] > seen.frames[last]
    gaps = np.where(earlier, look.apart(seen, last, last), np.inf)
    new = np.isfinite(gaps).any(axis=1)
    pairs = np.linalg.norm(means[new] - means[gaps[new].argmin(axis=1)], axis=1)
    assert right["Euclid to the mean"] == pytest.approx(pairs, abs=1e-3)
    assert {len(own) for own in right.values()} == {np.count_nonzero(new)}


def test_long_tracks_are_looked_up_by_as_many_frames_as_are_asked_for(seen):
    rows = look.beginnings(seen, 11)
    assert rows.shape[1] == 12
    assert (ages(seen)[rows] == np.arange(1, 13)).all()
    assert len(rows) == np.count_nonzero(np.bincount(seen.tracks) > 11)


def test_slow_drives_wait_for_tracks_and_make_landmarks_of_long_ones(monkeypatch):
    asked = asked_of(monkeypatch, look)
    for knows in (False, True):
        for distance in look.slowed.axes["distance"]:
            look.slowed.one(230, 0, distance, knows=knows)
    options = [one for one, _, _ in asked]
    assert {(one.stable, one.patience, one.reach, one.particles) for one in options} == {
        (23, 2, 1.0, 10)
    }
    assert [one.limit for one in options] == [149.0, 38.6, 19.9, 1.0, 149.0, 1.0, 1.0, 1.0]
    told = [ask is look.told for _, ask, _ in asked]
    assert told == [False, False, False, True, False, True, True, True]
    assert all(more == {"slowness": 4} for _, _, more in asked)


@pytest.mark.slow
def test_a_slow_drive_is_the_same_way_with_more_frames():
    fast, slow = (look.world(220, slowness=slowness)[1] for slowness in (1, 4))
    assert len(slow) == 4 * len(fast)
    lengths = [np.hypot(*np.diff(path[:, :2], axis=0).T).sum() for path in (fast, slow)]
    assert lengths[1] == pytest.approx(lengths[0], rel=0.02)
    patient = look.seen_in(0, frames=12, slowness=2, patience=2)
    assert len(patient.poses) == 24
    gaps = np.diff(patient.frames[np.lexsort((patient.frames, patient.tracks))])
    within = np.diff(np.sort(patient.tracks)) == 0
    assert set(gaps[within]) == {1, 2, 3}  # tracks that were missed, and went on
    hasty = look.seen_in(0, frames=12, slowness=2)
    assert np.bincount(patient.tracks).mean() > np.bincount(hasty.tracks).mean()


def test_descriptors_vary_more_between_visits_than_their_tracks_say(monkeypatch):
    """Two tracks of one place, by numbers of which all is known."""
    rng, length = RNG(1), look.LONG + 1
    noise = rng.normal(0, 2.0, (2, length, 128))
    visits = np.stack([np.zeros(128), rng.normal(0, 6.0, 128)])
    descriptors = (100 + visits[:, None] + noise).reshape(-1, 128)
    frames = np.r_[np.arange(length), 100 + np.arange(length)]
    count = 2 * length
    seen = SimpleNamespace(
        frames=frames,
        tracks=np.repeat([0, 1], length),
        descriptors=descriptors,
        places=np.zeros((count, 3)),
        carriers=np.zeros(count, dtype=int),
    )
    monkeypatch.setattr(look, "seen_in", lambda building, **pace: seen)
    found = look.outgrown.one(230)
    assert found["pairs"] == 1
    assert found["within"] == pytest.approx(4, rel=0.1)
    assert found["between"] == pytest.approx((36 + 4 + 4 / 23) / (1 + 1 / 23), rel=0.3)
    assert look.outgrown.one(230, itself=True)["between"] == pytest.approx(4, rel=0.3)


def test_a_filter_that_is_alone_has_one_particle_only_where_names_are_shared(monkeypatch):
    asked = asked_of(monkeypatch, look)
    for alone in (False, True):
        for whose in look.named.axes["whose"]:
            look.named.one(200, 0, whose, alone=alone)
    counts = [options.particles for options, _, _ in asked]
    assert counts == [10, 10, 10, 1, 10, 10]
    assert [options.association for options, _, _ in asked[:3]] == ["shared", "each", "each"]
    assert [options.reach for options, _, _ in asked[:3]] == [0.3, 0.3, 0.0]


def test_wrong_names_are_as_many_as_asked_for_and_far_away(seen):
    report = look.roll(seen.poses, RNG(3))
    found = {}
    for share in (0.0, 0.3):
        ask = look.misnamed(seen, share, RNG(5))
        with unchecked():
            drive = look.drive_through(seen, look.Options(reach=1000.0), report, RNG(4), ask)
        found[share] = drive.wrong / drive.matched
    assert found[0.0] == 0.0
    assert found[0.3] == pytest.approx(0.3, abs=0.07)


def test_a_misnamed_track_is_no_landmark_near_its_place(seen):
    founders = np.flatnonzero(np.diff(seen.tracks, prepend=-1))[:200]
    asked = SimpleNamespace(rows=np.arange(20))
    table = look.misnamed(seen, 1.0, RNG(1))(founders[:20], founders)(asked)
    gaps = cdist(seen.places[founders[:20]], seen.places[founders])
    assert (np.isfinite(table) == (gaps > look.SAME)).all()
    right = look.misnamed(seen, 0.0, RNG(1))(founders[:20], founders)(asked)
    assert (right == look.apart(seen, founders[:20], founders)).all()


def test_densities_are_distances_and_the_logarithm_of_the_volume():
    rng = RNG(2)
    descriptors = rng.normal(50, 20, (3, 16))
    means, squares = rng.normal(50, 20, (5, 16)), rng.uniform(10, 900, (5, 16))
    looks = SimpleNamespace(firsts=means, means=means, squares=squares, counts=np.full(5, 6))
    asked = SimpleNamespace(descriptors=descriptors, looks=looks)
    found = look.DENSITIES[look.RAW + look.LOGS](asked) ** 2
    variances = squares / 5
    apart = (descriptors[:, None] - means) ** 2 / variances
    expected = apart.sum(axis=-1) + np.log(variances * 12).sum(axis=-1)
    assert found == pytest.approx(expected, rel=1e-6)


def test_a_changed_study_changes_one_thing(monkeypatch):
    asked = asked_of(monkeypatch, look)
    look.compared.one(21, 0, look.RAW, limit=1e6)
    look.compared.one(21, 0, look.EUCLID, limit=1e6)
    look.compared.one(21, 0, look.RAW + look.WIDE)
    limits = [(options.limit, options.reach) for options, _, _ in asked]
    assert limits == [(1e6, 0.3), (149.0, 0.3), (45.3, 1.0)]
    for distance in (look.EUCLID, look.RAW, look.TOLD):
        look.mapped.one(210, 0, distance, knows=True)
    assert [ask is look.told for _, ask, _ in asked[3:]] == [False, True, True]
    assert [options.limit for options, _, _ in asked[3:]] == [149.0, 1.0, 1.0]
    look.mapped.one(210, 0, look.RAW)
    assert asked[-1][0].limit == 45.3
    assert asked[-1][1] is not look.told


@pytest.fixture(scope="module")
def driven(seen):
    """Return a drive with names that are told, and what its wheels report."""
    report = look.roll(seen.poses, RNG(3))
    with unchecked():
        return look.drive_through(
            seen, look.Options(reach=1000.0), report, RNG(4), look.told(seen)
        ), report


def test_from_above_a_landmark_is_seen_where_it_is(driven):
    drive, report = driven
    steps, gaps, sizes = look.from_above(drive, report), [], []
    assert len(steps) == len(drive.poses)
    assert steps[0].motion is None
    for pose, step in zip(drive.seen.poses, steps, strict=True):
        places = drive.places[step.observations.ids]
        there = se3.act(se3.inverse(se3.from_se2(pose)), places)[:, :2]
        errors = step.observations.values - there
        gaps += np.linalg.norm(errors, axis=1).tolist()
        sizes += np.einsum(
            "ni,nij,nj->n", errors, np.linalg.inv(step.observations.covs), errors
        ).tolist()
    assert np.median(gaps) < 0.1
    assert np.median(sizes) < 0.5  # the covariances have the axes of the errors, and are wide


def circled(frames=80, noise=0.03):
    """Return the steps of a robot that drives round among points, its true path and the wheels."""
    rng = RNG(1)
    places, angle = rng.uniform(-6, 6, (40, 2)), np.linspace(0, 3 * np.pi, frames)
    path = np.column_stack([4 * np.cos(angle), 4 * np.sin(angle), angle + np.pi / 2])
    sigmas, steps, alone = np.array([0.03, 0.03, 0.02]), [], [path[0]]
    for k, pose in enumerate(path):
        motion = None
        if k:
            increment = compose(inverse(path[k - 1]), pose) + sigmas * rng.standard_normal(3)
            motion = look.planar.Odometry(increment, np.diag(sigmas**2))
            alone.append(motion.move(alone[-1]))
        there = act(inverse(pose), places)
        ids = np.flatnonzero((there[:, 0] > 0) & (np.linalg.norm(there, axis=1) < 5))
        values = there[ids] + noise * rng.standard_normal((len(ids), 2))
        covs = np.tile(noise**2 * np.eye(2), (len(ids), 1, 1))
        steps.append(look.planar.Step(motion, look.Observations(ids, values, covs)))
    return steps, path, np.array(alone)


def test_at_first_one_filter_and_many_are_the_same():
    """Landmarks that were seen from a pose that is exact have no error in common."""
    steps, path, _ = circled()
    steps = steps[:21]
    many = [belief.pose for belief in look.separate(path[0], steps)]
    whole = look.joint(path[0], steps).poses
    assert whole[1] == pytest.approx(many[1], abs=1e-9)
    assert whole[20] != pytest.approx(many[20], abs=1e-6)


def test_all_filters_find_the_path_that_the_wheels_lose():
    steps, path, alone = circled()
    wheels = absolute_error(alone, path, False)
    many = np.array([belief.pose for belief in look.separate(path[0], steps)])
    for found in (look.joint(path[0], steps).poses, look.joint(path[0], steps, 0.99).poses, many):
        assert absolute_error(found, path, False) < wheels / 5


def test_a_gate_turns_wrong_names_away(driven):
    drive, report = driven
    steps, start = look.from_above(drive, report), drive.seen.poses[0]
    wrong = steps[:150]
    last = wrong[-1].observations
    moved = last.values + np.array([5.0, 0.0])
    wrong[-1] = look.planar.Step(wrong[-1].motion, look.Observations(last.ids, moved, last.covs))
    assert look.joint(start, wrong, 0.99).used[-1].max() == -1
    assert look.joint(start, wrong).used[-1].min() >= 0


def test_entries_that_differ_are_those_that_changed_or_are_new():
    before = np.arange(9.0).reshape(3, 3) + 1
    after = np.ones((4, 4))
    after[:3, :3] = before
    after[1, 2] += 1e-12 + 1
    assert np.count_nonzero(look.differs(before, after)) == 8
    assert not look.differs(before, before).any()


def test_one_pose_finds_the_names_and_the_paths_of_filters_that_are_told_them(seen, driven):
    drive, report = driven
    steps, start = look.from_above(drive, report), seen.poses[0]
    paths = {
        True: look.joint(start, steps).poses,
        False: [belief.pose for belief in look.separate(start, steps)],
    }
    for together, path in paths.items():
        with unchecked():
            alone = look.one_pose(seen, report, drive.options, look.told(seen), together)
        assert (alone.founders == drive.founders).all()
        assert (alone.matched, alone.wrong) == (drive.matched, 0)
        assert alone.path == pytest.approx(np.array(path), abs=1e-9)
    assert np.abs(paths[True] - np.array(paths[False])).max() > 1e-3


def test_one_pose_names_what_looks_alike_only_inside_its_gate(seen, driven):
    _, report = driven
    ask, found = look.misnamed(seen, 1.0, RNG(5)), {}
    for reach in (0.0, 0.3, 1000.0):
        with unchecked():
            drive = look.one_pose(seen, report, look.Options(reach=reach), ask, True)
        found[reach] = drive.matched
        assert drive.wrong == drive.matched
        assert drive.means.shape == (len(drive.founders), 2)
    assert found[0.0] < found[0.3] < found[1000.0]


def test_a_drive_has_the_filter_the_gate_the_wheels_and_the_names_that_are_asked_for(monkeypatch):
    seen, asked = begun(20), []

    def drive_through(seen, options, report, own, ask):
        asked.append((options.reach, report, None))
        return SimpleNamespace()

    def one_pose(seen, report, options, ask, together):
        asked.append((options.reach, report, together))
        return SimpleNamespace()

    monkeypatch.setattr(look, "seen_in", lambda building: seen)
    monkeypatch.setattr(look, "drive_through", drive_through)
    monkeypatch.setattr(look, "one_pose", one_pose)
    monkeypatch.setattr(look, "judged", lambda drive, report, building: {"path": 1.0})
    look.spoilt.one(310, 0, "1 m", 0.16)
    look.spoilt.one(310, 0, "1 m", 0.16, worse=0.1)
    look.hypothesised.one(310, 0, "its own", "joint")
    look.skidded.one(310, 0, 3.0, "separate", believed=1 / 3)
    look.skidded.one(310, 0, 3.0, "10 particles", believed=1 / 3)
    assert [(reach, together) for reach, _, together in asked] == [
        *[(1.0, None)] * 2, (0.0, True), (0.3, False), (0.3, None)
    ]  # fmt: skip
    first = asked[0][1].deviations
    sizes = [np.median(report.deviations / first) for _, report, _ in asked]
    assert sizes == pytest.approx([1.0, 0.1, 1.0, 1.0, 3.0])
    assert (asked[3][1].increments == asked[4][1].increments).all()


def test_a_map_is_right_by_its_rooms_and_their_order(driven, monkeypatch):
    drive, report = driven
    for inside, ordered in ((0.96, True), (0.94, True), (0.96, False)):
        found = SimpleNamespace(inside=inside, ordered=ordered, torn=2.0)
        monkeypatch.setattr(look, "rooms", lambda building: None)
        monkeypatch.setattr(look, "topology", lambda drive, floors, found=found: found)
        got = look.judged(drive, report, 0)
        assert got["right"] == got["alone"] == (inside == 0.96 and ordered)
    assert got["wheels"] == pytest.approx(absolute_error(drive.odometry, drive.seen.poses, False))


def test_the_map_of_the_wheels_alone_has_the_landmarks_where_the_wheels_put_them(monkeypatch):
    seen, judged = begun(), []
    report = look.replace(look.roll(seen.poses, RNG(3)), increments=true_increments(seen.poses))
    founders = np.flatnonzero(np.diff(seen.tracks, prepend=-1))[:300]
    drive = SimpleNamespace(
        seen=seen, founders=founders, places=seen.places[founders], path=seen.poses,
        means=seen.places[founders], matched=0, wrong=0,
    )  # fmt: skip

    def topology(drive, floors):
        judged.append(np.linalg.norm(drive.means - drive.places, axis=1))
        return SimpleNamespace(inside=1.0, ordered=True, torn=0.0)

    monkeypatch.setattr(look, "rooms", lambda building: None)
    monkeypatch.setattr(look, "topology", topology)
    look.judged(drive, report, 0)
    assert 0.0 < np.median(judged[1]) < 0.1


def drives(paths):
    """Return rows of drives through two buildings, each drive with wheels that are 1 m off."""
    columns = {"path": np.array(paths), "wheels": np.ones(4), "building": np.array([1, 1, 2, 2])}
    return SimpleNamespace(of=columns.get, levels=lambda name: [1, 2])


def test_a_drive_is_lost_that_ends_up_farther_off_than_by_the_wheels_alone():
    some, others = drives([0.5, 1.5, 2.0, 3.0]), drives([0.5, 0.9, 0.9, 1.1])
    assert look.lost(some).tolist() == [0.5, 1.0]
    assert look.lost(others).tolist() == [0.0, 0.5]
    assert look.loses_more(some, others).estimate == 0.5


def test_bad_wheels_are_three_times_as_bad_and_names_are_wrong_where_they_should_be(monkeypatch):
    seen = begun()
    monkeypatch.setattr(look, "seen_in", lambda building: seen)
    reports = {trouble: look.troubled(210, trouble) for trouble in look.TROUBLES}
    good, bad, wrong = (reports[trouble] for trouble in ("none", "wheels", "names"))
    assert bad[1].deviations == pytest.approx(3 * good[1].deviations)
    assert (wrong[1].increments == good[1].increments).all()
    assert good[0].wrong == bad[0].wrong == 0 < wrong[0].wrong


def test_only_one_filter_is_lost():
    lost = dict.fromkeys(look.FOLLOWERS, 0.3) | {"one filter": 5.0}
    told = [(share, f, error) for share in look.SHARES for f, error in lost.items()]
    assert look.only_one_filter_is_lost(told)
    for share in look.SHARES[1:]:
        other = [
            (s, f, 4.0 if (s, f) == (share, "one filter, gate") else error) for s, f, error in told
        ]
        assert not look.only_one_filter_is_lost(other)


def test_each_line_of_the_forest_is_a_ratio_of_recorded_means():
    rows = look.mapped.rows()
    errors = [rows.of("path", distance=d).mean() for d in (look.RAW, look.EUCLID)]
    of_plans = look.by_paths()["ten plans, gate of 1 m"][0]
    assert of_plans.found.estimate == pytest.approx(errors[0] / errors[1])
    assert of_plans.limit == look.mahalanobis_map.accepted.high
    shares = {line.name: line.found.estimate for line in look.by_matches()["one plan, gate of 1 m"]}
    (share,) = shares.values()
    wide = [look.wrong_share(look.compared.rows().where(distance=d + look.WIDE)).mean()
            for d in (look.RAW, look.EUCLID)]  # fmt: skip
    assert share == pytest.approx(wide[0] / wide[1])


def test_a_state_of_the_explorer_is_a_drive_through_each_of_ten_buildings():
    for state in look.buildings.parameters():
        found = look.in_buildings(**state)
        assert len(found.off) == len(found.wheels) == len(found.right) == 10
        assert found.lost == np.count_nonzero(found.off > found.wheels)
    right = look.in_buildings(16, "none", "one filter")
    drives = look.hypothesised.rows().where(draw=0, gate="none", filter="joint")
    assert right.off.tolist() == drives.of("path").tolist()
