"""Front end, drives, topology and exact maps, on what can be worked out otherwise."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.distance import cdist

from data_synth import stereo
from robot_perception.chapters.visual_slam import (
    association,
    drives,
    explorers,
    factorisation,
    figures,
    frontend,
    maps,
    recordings,
    resampling,
    stability,
)
from robot_perception.evaluation.intervals import bootstrap_mean
from robot_perception.geometry import se3
from robot_perception.landmarks.metrics import METRICS, euclidean_mean
from robot_perception.particles import StepInfo
from robot_perception.slam.visual import FrameInfo
from tests.chapters.ledger import recorded
from tests.unchecked import unchecked

RNG = np.random.default_rng


@pytest.fixture(scope="module")
def seen():
    return frontend.seen()


def test_points_lie_where_the_renderer_says(seen):
    """In the middle half a decimetre: some pairs do not belong together."""
    _, poses = frontend.world()
    rows = RNG(0).choice(len(seen.points), 500, replace=False)
    gaps = []
    for row in rows:
        at = stereo.project(frontend.RIG, poses[seen.frames[row]], seen.places[row][None])[0]
        assert at[:2] == pytest.approx(seen.pixels[row], abs=1e-6)
        gaps.append(abs(seen.points[row, 2] - at[2]) / at[2])
    assert np.median(gaps) < 0.02


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
    _, poses = frontend.world()
    lengths = np.bincount(seen.tracks)[seen.tracks]
    depths = [
        stereo.project(frontend.RIG, pose, seen.places[seen.frames == k])[:, 2]
        for k, pose in enumerate(poses)
    ]
    wrong = np.abs(seen.points[:, 2] / np.concatenate(depths) - 1) > 0.1
    once, stay = stability.wrong_depths(seen)
    assert [once, stay] == pytest.approx([wrong[lengths == 1].mean(), wrong[lengths > 5].mean()])
    assert 1.5 * stay < once


def test_errors_of_a_disparity_last(seen):
    """In neighbouring frames they correlate by about one half."""
    T = se3.compose(se3.from_se2(seen.poses), frontend.RIG.T_robot_camera)[seen.frames]
    truth = np.einsum("ni,ni->n", T[:, :3, 2], seen.places - T[:, :3, 3])
    errors = frontend.RIG.focal_px * frontend.RIG.baseline * (1 / seen.points[:, 2] - 1 / truth)
    order = np.lexsort((seen.frames, seen.tracks))
    lasting = (np.bincount(seen.tracks) > 5)[seen.tracks] & (np.abs(errors) < 3)
    one, next_ = order[:-1], order[1:]
    pairs = (seen.tracks[one] == seen.tracks[next_]) & lasting[one] & lasting[next_]
    correlation = np.corrcoef(errors[one[pairs]], errors[next_[pairs]])[0, 1]
    assert 0.4 < correlation < 0.6


def ages(seen):
    """Return for each point in how many frames its track was seen by then."""
    counts, found = {}, []
    for track in seen.tracks.tolist():
        counts[track] = counts.get(track, 0) + 1
        found.append(counts[track])
    return np.array(found)


def recognised(drive):
    """Return points, landmarks and gaps (m) of the tracks that were taken for a landmark."""
    seen, first = drive.seen, np.flatnonzero(ages(drive.seen) == 6)
    new = np.isin(drive.rows, first) & (drive.rows != drive.founders[drive.names])
    rows, names = drive.rows[new], drive.names[new]
    return rows, names, np.linalg.norm(seen.places[rows] - drive.places[names], axis=1)


def test_most_that_is_taken_for_another_lies_on_the_same_surface():
    drive = explorers.driven(10)
    rows, names, gaps = recognised(drive)
    far = gaps > drives.SAME
    assert (len(rows), np.count_nonzero(far)) == (drive.matched, drive.wrong)
    same = drive.seen.carriers[rows[far]] == drive.seen.carriers[drive.founders[names[far]]]
    assert 0.5 < same.mean() < 0.9


def test_points_of_stable_tracks_are_used_and_each_is_looked_up():
    """Each track of more than five frames is recognised or a landmark; later points may be lost."""
    drive = explorers.driven(10)
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
    report, begin = drives.roll(seen.poses[:120], rng=RNG(2)), frontend.seen(120)
    asked = []

    def watching(question):
        asked.append(question)
        return euclidean_mean(question)

    one, other, none = (
        drives.run(begin, drives.Options(2), report, rng=RNG(4), **more)
        for more in ({}, {"metric": watching}, {"metric": lambda q: 1e9 + euclidean_mean(q)})
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
    seen = frontend.seen(120)
    report = drives.roll(seen.poses, rng=RNG(3))
    options = drives.Options(6, share=0.3, level=0.5, reach=0.0, noise=8.0, association="each")
    with unchecked():
        return drives.run(seen, options, report, rng=RNG(4))


def test_where_each_names_by_its_own_map_the_heaviest_is_scored(each):
    """Its map is the exact one of its path and of the points that it is said to have used."""
    best, known = each.maps.best, each.maps.known
    assert 10 < each.drawn.sum() < 100
    assert len(each.founders) == known[best].sum() < each.maps.ids.size
    exact, _ = factorisation.exact_map(each, each.path)
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
    assert (len(gaps), np.count_nonzero(gaps > drives.SAME)) == (each.matched, each.wrong)


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
    found, m = drives._of_best(infos, best), best
    for frame in range(5, -1, -1):
        assert found[frame].names == tags[frame, m]
        assert found[frame].new == (tags[frame, m] % 2 == 0)
        m = ancestors[frame][m]


def test_the_same_place_lies_on_the_same_surface(seen):
    rows = np.flatnonzero(seen.tracks == np.argmax(np.bincount(seen.tracks)))[:3]
    assert (drives.apart(seen, rows, rows) < drives.AGAIN).all()
    others = replace(seen, carriers=np.arange(len(seen.carriers)))
    assert (np.isfinite(drives.apart(others, rows, rows)) == np.eye(3)).all()


def test_what_is_in_the_map_again_was_there_before():
    drive = explorers.driven(10)
    near = cdist(drive.places, drive.places) < drives.AGAIN
    carriers, made = drive.seen.carriers[drive.founders], drive.seen.frames[drive.founders]
    same, before = carriers[:, None] == carriers, made[:, None] > made
    assert drive.twice == (near & same & before).any(axis=1).sum() > 0


def test_the_filter_takes_what_the_wheels_report():
    poses = frontend.world()[1]
    report = drives.roll(poses, rng=RNG(2))
    motion = drives.motions(report)[6]
    assert (motion.increment == report.increments[6]).all()
    assert np.sqrt(np.diag(motion.increment_cov)) == pytest.approx(report.deviations[6])


def test_the_path_is_that_of_ancestors():
    drive = explorers.driven(10)
    m = drive.maps.best
    for k in range(len(drive.poses) - 1, 400, -1):
        assert (drive.path[k] == drive.poses[k, m]).all()
        m = drive.ancestors[k, m]
    assert (drive.survivors()[:-60] == 1).all()


def test_the_paths_to_a_frame_are_those_of_its_particles():
    drive = explorers.driven(10)
    paths, alive = drive.paths(300), drive.survivors(300)
    assert (paths[300] == drive.poses[300]).all()
    assert (paths[299] == drive.poses[299, drive.ancestors[300]]).all()
    assert [len(alive), alive[299], alive[300]] == [301, len(set(drive.ancestors[300])), 10]


def test_told_the_names_nothing_is_wrong(seen):
    report = drives.roll(seen.poses, rng=RNG(3))
    with unchecked():
        drive = drives.run(seen, drives.Options(), report, rng=RNG(4), told=True)
    assert drive.matched > 100
    assert drive.wrong == 0
    assert recognised(drive)[2].max() < drives.AGAIN


def test_a_map_is_right_where_rooms_order_and_visits_all_are():
    whole = maps.Topology(inside=1.0, ordered=True, apart=0.0)
    assert whole.right
    for wrong in ({"inside": 0.9}, {"ordered": False}, {"apart": 0.6}):
        assert not replace(whole, **wrong).right


def test_a_right_map_is_right_and_a_torn_one_is_not():
    drive = explorers.driven(100)
    assert maps.topology(drive).right
    half = len(drive.poses) // 2
    poses = drive.poses.copy()
    poses[half:, :, 1] += 1.5
    torn = replace(drive, poses=poses)
    found = maps.topology(torn)
    assert found.apart > maps.MARGIN
    assert not found.right


def test_rooms_are_the_floors_and_the_order_is_that_of_the_drive():
    floors = maps.rooms()
    assert len(floors) == 7
    assert (floors[:, 1] > floors[:, 0]).all()
    truth = frontend.world()[1]
    order = maps.order(maps.room_of(truth))
    assert len(order) > 8
    assert len(set(order)) == 6  # nobody enters one room


def test_exact_maps_are_not_those_of_another_path():
    drive = explorers.driven(10)
    exact, cov = factorisation.exact_map(drive, drive.path)
    assert exact == pytest.approx(drive.means, abs=1e-8)
    moved, _ = factorisation.exact_map(drive, drive.path + np.array([0.1, 0, 0]))
    assert moved - exact == pytest.approx(np.tile([0.1, 0, 0], (len(exact), 1)), abs=1e-8)
    assert (np.linalg.eigvalsh(cov) > 0).all()


def test_numbers_of_weights():
    printed, effective = resampling.numbers(np.array([0.5, 0.25, 0.25]))
    assert printed == pytest.approx(1)
    assert effective == pytest.approx(1 / 0.375)


def test_lasting_points_keep_their_tracks(seen):
    long = frontend.lasting(seen, 5)
    lengths = np.bincount(long.tracks)
    assert lengths.min() > 5
    assert len(lengths) == np.count_nonzero(np.bincount(seen.tracks) > 5)


def test_buildings_have_one_plan_and_are_hung_and_driven_otherwise():
    (one, path), (other, way) = frontend.world(), frontend.world(1)
    assert (one.plan == other.plan).all()
    assert maps.order(maps.room_of(path)) == maps.order(maps.room_of(way))
    assert np.abs(path - way)[:, :2].max() > 0.0
    assert one.kinds.tolist() != other.kinds.tolist()
    assert not {0, *frontend.CHOOSING} & set(frontend.SCORED)


def test_limits_are_those_that_as_many_right_pairs_pass(monkeypatch):
    """Of made-up distances, and of the buildings that they were chosen in."""
    first, *others = METRICS
    own = {name: np.linspace(0, 200, 401) * (k + 1) for k, name in enumerate(METRICS)}
    with monkeypatch.context() as patch:
        patch.setattr(frontend, "seen", lambda building: building)
        patch.setattr(association, "right_pairs", lambda seen: own)
        found = association.limits()
    assert found[first] == pytest.approx(150, abs=0.5)
    assert [found[name] / found[first] for name in others] == pytest.approx([2, 3, 4])


@pytest.mark.slow
def test_the_limits_are_those_of_the_buildings_that_they_were_chosen_in():
    found = association.limits()
    assert {name: found[name] for name in METRICS} == pytest.approx(association.LIMITS, rel=0.005)


def test_right_pairs_are_tracks_of_one_place_by_their_first_frames(seen):
    rows = association.beginnings(seen)
    assert rows.shape[1] == 6
    assert (seen.tracks[rows] == seen.tracks[rows[:, :1]]).all()
    assert (np.diff(seen.frames[rows], axis=1) == 1).all()
    assert (ages(seen)[rows[:, 0]] == 1).all()
    assert len(rows) == np.count_nonzero(np.bincount(seen.tracks) > 5)
    with unchecked():
        right = association.right_pairs(seen)
    means = seen.descriptors[rows].astype(float).mean(axis=1)
    last = rows[:, -1]
    earlier = seen.frames[rows[:, 0]][:, None] > seen.frames[last]
    gaps = np.where(earlier, drives.apart(seen, last, last), np.inf)
    new = np.isfinite(gaps).any(axis=1)
    pairs = np.linalg.norm(means[new] - means[gaps[new].argmin(axis=1)], axis=1)
    assert right["Euclid to the mean"] == pytest.approx(pairs, abs=1e-3)
    assert {len(own) for own in right.values()} == {np.count_nonzero(new)}


def test_a_filter_that_is_alone_has_one_particle_only_where_names_are_shared():
    named = {f.name: f.options for f in association.named(*association.WAYS, alone=True)}
    assert [o.particles for n, o in named.items() if n.startswith("shared")] == [1, 1, 1]
    assert [o.particles for n, o in named.items() if n.startswith("each")] == [10, 10, 50]
    assert {o.association for n, o in named.items() if n.startswith("each")} == {"each"}
    assert named["each, own gate"].reach == 0.0


def test_means_and_ratios_are_those_of_buildings():
    """Of the drives through one building the mean is taken first."""
    numbers = np.array([[1.0, 3.0], [4.0, 6.0], [0.0, 2.0]])
    found = maps.mean(numbers, "m")
    of_means = bootstrap_mean(np.array([2.0, 5.0, 1.0]), "m")
    assert (found.estimate, found.low, found.high) == (
        of_means.estimate,
        of_means.low,
        of_means.high,
    )
    assert maps.ratio(2 * numbers, numbers).estimate == 2.0
    assert maps.worst(numbers) == 5.0


def accounts(**errors):
    """Return accounts of filters with some errors of the path, and of nothing else."""
    empty = maps.Account(*[np.ones((2, 2))] * len(maps.Account._fields))
    return {name: empty._replace(path=np.asarray(path)) for name, path in errors.items()}


def test_the_particles_needed_are_those_of_equal_error():
    """Errors that fall as a power: the rule that is as good with a third as many needs a third."""
    power = {1: 0.5, 2: 0.8}
    law = np.array([[1.0, 1.1], [2.0, 2.2]])
    falls = np.array([[power[1]] * 2, [power[2]] * 2])
    found = {}
    for count in resampling.COUNTS:
        for rule, size in (("below M/2", 3 * count), ("always", count)):
            name = resampling.called(rule, count, 1.0)
            found |= accounts(**{name: law * size**-falls})
    needed = resampling.needed(found)
    assert [needed.estimate, needed.low, needed.high] == pytest.approx([1 / 3] * 3)


def test_errors_by_number_of_particles_are_those_of_the_ledger():
    """One row for each number: both rules, and the frames after which one says nothing."""
    rules = recorded()["neff-resampling"].tables["rules"]
    shown = resampling.by_count(rules)
    assert list(shown.rows) == [f"M = {count}" for count in resampling.COUNTS]
    assert shown["M = 3", "below M/2 (m)"] == rules["below M/2, M = 3", "ATE (m)"]
    assert shown["M = 20", "always (m)"] == rules["always, M = 20", "ATE (m)"]
    spared = 100 * recorded()["neff-resampling"].evidence["draws spared, below M/2, M = 3"].estimate
    assert shown["M = 3", "spared (%)"] == pytest.approx(spared)


def test_drives_of_all_filters_have_the_same_wheels_and_draws():
    """And the buildings come in order, each with its own drives."""
    twice = (maps.Filter("one"), maps.Filter("other"))
    with unchecked():
        found = maps.run(maps.Config(twice, 2, (0, 1), frames=120), rng=RNG(0))
    one, other = found.values()
    assert all((a == b).all() for a, b in zip(one, other, strict=True))
    assert one.path.shape == (2, 2)
    assert len(set(one.wheels.ravel())) == 4
    with unchecked():
        first = maps.run(maps.Config(twice[:1], 2, (0,), frames=120), rng=RNG(0))["one"]
    assert (first.path[0] == one.path[0]).all()


def test_half_of_the_landmarks_are_less_misplaced():
    drive = explorers.driven(10)
    motion = maps.align(drive.path, drive.seen.poses)
    gaps = np.linalg.norm(maps.act(motion, drive.means[:, :2]) - drive.places[:, :2], axis=1)
    assert np.mean(gaps <= maps.misplaced(drive)) == pytest.approx(0.5, abs=0.01)


def test_accounts_say_what_the_drives_did():
    one, ten = (explorers.driven(count) for count in (1, 10))
    both = maps.Account(*np.transpose([maps.account(drive) for drive in (one, ten)]))
    assert both.landmarks.tolist() == [len(drive.places) for drive in (one, ten)]
    assert both.wheels[0] == both.wheels[1]
    assert both.right.tolist() == [0, 1]
    weighed = ten.effective[ten.observed > 0]
    assert both.effective == pytest.approx([1, weighed.mean() / 10])


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
    looser = recordings._loosened(np.arange(2), points, covs).covs
    assert looser - covs == pytest.approx(
        np.array([np.diag([0, 0.05**2, 0]), np.diag([0, 0.2**2, 0])])
    )
    assert (covs == np.eye(3)).all()
