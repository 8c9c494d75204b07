"""The real recordings: what the studies compute, on worlds whose answer is known, and on them."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import stats

from explorables.figures import figure
from explorables.figures.style import MEANING
from robot_perception import chapters, datasets
from robot_perception.book import recordings_corners, recordings_park, recordings_robots
from robot_perception.chapters.anchored_slam import figures as drawings
from robot_perception.datasets import LandmarkGraph, ReadReport, Relations
from robot_perception.datasets.mrclam import Mrclam, SurveyedLandmarks, Track
from robot_perception.datasets.victoria import Fixes, VehicleLog
from robot_perception.geometry import wrap_angle
from robot_perception.slam.planar import (
    Association,
    MapBelief,
    RangeBearing,
    Settings,
    dead_reckoning,
    run_filter,
    smooth,
)
from robot_perception.slam.planar.calibration import Calibration
from studies.records import records
from tests.slam.planar.logged import DELAY, DRAG, LANDMARKS, SCALE, SIGMA, make_robot

# ---- five robots ---------------------------------------------------------------------------------


def everything(robot):
    return np.ones(len(robot.landmarks.times), dtype=bool)


def known_sensors(persistence):
    return Calibration(
        DELAY, SCALE, DRAG, np.array([4e-4, 1e-3]), np.zeros(2), np.array(SIGMA),
        np.full(2, persistence), 0.4, 0,
    )  # fmt: skip


def test_filter_with_the_right_sensors_is_consistent_and_lasting_errors_make_a_white_one_sure():
    """The whole chain on a world of the recording's form: times, delay, cuts, map, judgement."""
    nees, drives = {}, 6
    for persistence in (0.0, 0.6):
        sensors = known_sensors(persistence)
        noises = {"white": sensors.sigma**2, "lasting": sensors.sigma**2 * sensors.inflation}
        for k, rng in enumerate(np.random.default_rng(5).spawn(drives)):
            robot = make_robot(
                rng,
                seconds=120.0,
                persistence=persistence,
                bias=np.zeros(2),
                wander=tuple(np.sqrt(sensors.density)),
            )
            drive = recordings_robots.make_drive(robot, sensors)
            assert drive.covered.all()
            anchors = recordings_robots.choose_anchors(drive, LANDMARKS)[2]
            for name, noise in noises.items():
                history = run_filter(
                    MapBelief.start(drive.truth[0], recordings_robots.START),
                    drive.steps,
                    Settings(RangeBearing(np.diag(noise)), anchors),
                )
                assert set(history.belief.ids.tolist()) | set(anchors) == {6, 7, 8, 9}
                found = recordings_robots.judge(history, drive, everything(robot))
                nees[persistence, name, k] = found.nees.mean()

    def mean(persistence, name):
        return np.mean([nees[persistence, name, k] for k in range(drives)])

    # Near 3. The errors of a drive hang together over some 20 s, so that six drives of two minutes
    # count as about 36 values: ± 1.96 √(6/36) = ± 0.8.
    assert mean(0.0, "white") == pytest.approx(3.0, abs=0.8)
    assert mean(0.0, "lasting") == mean(0.0, "white")  # nothing lasts: no inflation
    assert mean(0.6, "white") > 9.0
    assert mean(0.6, "lasting") < 4.5


@pytest.mark.slow
def test_without_barcodes_the_landmarks_are_still_the_right_ones():
    robot = make_robot(np.random.default_rng(8), seconds=100.0, bias=np.zeros(2))
    _, runs = recordings_robots.run_robot(robot, LANDMARKS, *[known_sensors(0.0)] * 2)
    for method in ("nearest", "joint"):
        for run in runs[method]:
            apart = run.history.belief.landmarks[:, None] - LANDMARKS.positions
            assert np.sqrt(np.mean((apart**2).sum(axis=-1).min(axis=1))) < 0.2  # to the nearest
            assert run.scores["ate"] < 0.2


def test_anchors_are_the_first_landmark_seen_and_the_one_farthest_from_it():
    drive = recordings_robots.make_drive(
        make_robot(np.random.default_rng(2), seconds=30.0), known_sensors(0.5)
    )
    none, one, two = recordings_robots.choose_anchors(drive, LANDMARKS)
    assert (list(none), list(one), list(two)) == ([], [6], [6, 8])
    np.testing.assert_array_equal(two[8], [-4, 0])


def test_images_are_a_pause_apart_and_each_is_used_at_its_own_time():
    robot = make_robot(np.random.default_rng(2), seconds=30.0)
    drive = recordings_robots.make_drive(robot, known_sensors(0.5), pause=1.0)
    assert (np.diff(drive.times[1:]) >= 1.0).all()
    assert set(drive.times[1:]) <= set(robot.landmarks.times)
    assert drive.times[0] == pytest.approx(robot.commands.times[0] + DELAY)
    for step, time in zip(drive.steps, drive.times[1:], strict=True):
        np.testing.assert_array_equal(
            step.observations.values, robot.landmarks.values[robot.landmarks.times == time]
        )
        assert step.time == pytest.approx(time - drive.times[0])


def test_a_drive_begins_no_sooner_than_motion_capture():
    robot = make_robot(np.random.default_rng(2), seconds=30.0)
    late = robot.truth.times >= 1005.0
    robot = replace(robot, truth=Track(robot.truth.times[late], robot.truth.poses[late]))
    drive = recordings_robots.make_drive(robot, known_sensors(0.5))
    assert drive.covered[0]
    assert 1005.0 <= drive.times[0] < 1005.1
    seen = np.concatenate([step.observations.values for step in drive.steps])
    np.testing.assert_array_equal(robot.landmarks.values[drive.rows], seen)


def test_a_gate_locks_right_sightings_out_and_one_that_gives_in_lets_them_in_again():
    """A filter that is sure of a wrong heading: it rejects what would set it right."""
    rng = np.random.default_rng(6)
    robot = make_robot(rng, seconds=120.0, bias=np.zeros(2), wander=(0.02, 0.03))
    drive = recordings_robots.make_drive(robot, known_sensors(0.0))
    right = np.arange(len(robot.landmarks.times)) % 7 > 0
    anchors = dict(zip(LANDMARKS.ids.tolist(), LANDMARKS.positions, strict=True))
    wrong = MapBelief.start(drive.truth[0] + [0, 0, 1.0], recordings_robots.START)
    found = {}
    for patience in (None, recordings_robots.PATIENCE):
        association = Association("known", recordings_robots.LEVEL, patience=patience)
        sensor = RangeBearing(np.diag(np.square(SIGMA)))
        history = run_filter(wrong, drive.steps, Settings(sensor, anchors, association))
        off = np.hypot(*(history.poses - drive.truth[1:])[-20:, :2].T).mean()
        scores = recordings_robots.judge(history, drive, right).scores
        found[patience] = scores | {"off": off}
        assert scores["rejected"] == history.counts.rejected
    locked, patient, most = *found.values(), recordings_robots.PATIENCE * len(anchors)
    assert 0.8 * locked["rejected"] < locked["right"] < 0.92 * locked["rejected"]
    assert locked["longest"] > 100
    assert locked["off"] > 1.0
    assert patient["longest"] <= most
    assert patient["rejected"] < 2 * most
    assert patient["off"] < 0.1


def test_the_account_of_a_gate_counts_right_ones_and_the_longest_stretch():
    robot = make_robot(np.random.default_rng(2), seconds=30.0)
    late = robot.truth.times >= 1005.0  # so that the first sightings are not in the drive
    robot = replace(robot, truth=Track(robot.truth.times[late], robot.truth.poses[late]))
    drive = recordings_robots.make_drive(robot, known_sensors(0.0))
    assert drive.rows[0] > 0
    start = MapBelief.start(drive.truth[0], recordings_robots.START)
    history = run_filter(start, drive.steps, Settings(RangeBearing(np.diag(np.square(SIGMA)))))
    names = np.concatenate(history.used)
    names[[1, 4, 5, 6, 9, 10]] = -1
    ends = np.cumsum([len(used) for used in history.used])[:-1]
    marked = replace(history, used=tuple(np.split(names, ends)))
    right = everything(robot)
    right[drive.rows[[4, 9, 11]]] = False
    for run, expected in ((history, [0, 0, 0]), (marked, [6, 4, 3])):
        scores = recordings_robots.judge(run, drive, right).scores
        assert [scores[name] for name in ("rejected", "right", "longest")] == expected


def test_any_of_the_nine_data_sets_is_computed_by_its_number(monkeypatch, tmp_path):
    """Two robots for five, and a landmark that none of them ever sees."""
    sevens = SurveyedLandmarks(
        np.append(LANDMARKS.ids, 20),
        np.vstack([LANDMARKS.positions, [[1.0, 1.0]]]),
        np.ones((5, 2)),
    )
    rngs = np.random.default_rng(7).spawn(2)
    robots = {k: make_robot(rng, seconds=20.0) for k, rng in enumerate(rngs, start=1)}
    monkeypatch.setattr(recordings_robots, "read_mrclam", lambda folder: Mrclam(sevens, robots, ()))
    monkeypatch.setenv("ROBOT_PERCEPTION_DATA", str(tmp_path))
    with pytest.raises(datasets.DatasetMissing, match="put the files of MRCLAM_Dataset7 into"):
        recordings_robots.robots(7)
    for wrong in (0, 10):
        with pytest.raises(ValueError, match="data_set must be"):
            recordings_robots.robots(wrong)
    (tmp_path / "utias_mrclam_7").mkdir()
    read = recordings_robots.robots(7)
    assert read.live
    found = read.result
    assert list(found.robots) == [1, 2]
    # what robot 1 is told, and not its own
    other = recordings_robots.measure_sensors(robots[2], sevens)
    np.testing.assert_array_equal(found.robots[1].inflation, other.inflation)
    for robot in found.robots.values():
        assert np.isnan(robot.marks[:, -1]).all()
        assert np.isfinite(robot.marks[:, :-1]).all()
    error = recordings_robots.anchor_table(found)["no anchor", "error (m)"]
    assert error.estimate == pytest.approx(found.errors["lasting"].ate[:, 0].mean())
    _, ax = figure()
    drawings.robot_path(ax, found, 2, 1)


def test_what_motion_capture_did_not_see_is_not_judged():
    robot = make_robot(np.random.default_rng(4), seconds=60.0, bias=np.zeros(2))
    short = Track(robot.truth.times[:700], robot.truth.poses[:700])  # 35 s
    drive, runs = recordings_robots.run_robot(
        replace(robot, truth=short), LANDMARKS, *[known_sensors(0.0)] * 2
    )
    seen = int(drive.covered[1:].sum())
    assert 0 < seen < len(drive.steps)
    assert len(runs["white"][0].nees) == seen
    assert np.isfinite(runs["white"][0].scores["ate"])


def test_a_whole_turn_of_the_truth_is_no_error():
    robot = make_robot(np.random.default_rng(4), seconds=60.0, bias=np.zeros(2))
    drive, runs = recordings_robots.run_robot(robot, LANDMARKS, *[known_sensors(0.0)] * 2)
    turned = replace(drive, truth=drive.truth + np.array([0, 0, 2 * np.pi]))
    for judged in runs["white"]:
        again = recordings_robots.judge(judged.history, turned, everything(robot))
        np.testing.assert_allclose(again.nees, judged.nees, rtol=1e-6)


# ---- the park ------------------------------------------------------------------------------------


def circle_graph(steps=100, radius=20.0):
    """A car on a circle: log, graph of every tenth moment, and fixes of its true place."""
    speed, dt = 2.0, 0.1
    times = dt * np.arange(10 * steps + 1)
    steering = np.arctan(recordings_park.AXLES / radius)
    wheel = speed * (1 - np.tan(steering) * recordings_park.TRACK / recordings_park.AXLES)
    car = VehicleLog(times, np.full(times.size, wheel), np.full(times.size, steering))
    turn = speed * 10 * dt / radius
    chord = 2 * radius * np.sin(turn / 2)
    motion = [chord * np.cos(turn / 2), chord * np.sin(turn / 2), turn]
    graph = LandmarkGraph(
        np.tile(motion, (steps, 1)),
        np.tile(np.eye(3) * 1e-6, (steps, 1, 1)),
        np.array([1, 3]),
        np.array([5, 5]),
        np.tile([3.0, 1.0], (2, 1)),
        np.tile(np.eye(2), (2, 1, 1)),
        ReadReport(records(), {}, {}),
    )
    angle = speed * times / radius
    place = radius * np.stack([np.sin(angle), 1 - np.cos(angle)], axis=1)
    return graph, car, Fixes(times[::7], place[::7])


def test_the_way_travelled_tells_the_time_of_a_pose():
    graph, car, fixes = circle_graph()
    dead = dead_reckoning(np.zeros(3), (step.motion for step in recordings_park.make_steps(graph)))
    there, covered = recordings_park.positions_at_fixes(dead, graph, car, fixes)
    assert covered.sum() > 0.95 * len(covered)
    # chords of 2 m on a radius of 20 m lie up to 2.5 cm inside the circle, and 200 m of way are
    # 8 cm longer along the circle
    np.testing.assert_allclose(there[covered, :2], fixes.positions[covered], atol=0.12)
    late = Fixes(fixes.times + 1000.0, fixes.positions)
    assert not recordings_park.positions_at_fixes(dead, graph, car, late)[1].any()


def test_backward_the_way_grows_as_well():
    graph, car, fixes = circle_graph()
    path = np.zeros((len(graph.motions) + 1, 3))
    back = VehicleLog(car.times, -car.speeds, car.steerings)
    _, forward = recordings_park.positions_at_fixes(path, graph, car, fixes)
    np.testing.assert_array_equal(
        recordings_park.positions_at_fixes(path, graph, back, fixes)[1], forward
    )
    there, covered = recordings_park.positions_at_fixes(
        np.arange(303.0).reshape(-1, 3), graph, back, fixes
    )
    assert (np.diff(there[covered, 0]) > 0).all()


def test_headings_are_interpolated_the_short_way_round():
    graph, car, fixes = circle_graph()
    dead = dead_reckoning(np.zeros(3), (step.motion for step in recordings_park.make_steps(graph)))
    assert np.ptp(np.diff(dead[:, 2])) > 6  # it has gone round
    there, covered = recordings_park.positions_at_fixes(dead, graph, car, fixes)
    away = wrap_angle(there[covered, 2] - fixes.times[covered] * 2.0 / 20.0)
    np.testing.assert_allclose(away, 0, atol=0.01)


def test_fixes_after_the_last_pose_are_not_covered():
    graph, car, fixes = circle_graph()
    short = replace(graph, motions=graph.motions[:40], motion_covs=graph.motion_covs[:40])
    covered = recordings_park.positions_at_fixes(np.zeros((41, 3)), short, car, fixes)[1]
    np.testing.assert_array_equal(covered, fixes.times <= 40.0)


def test_jumps_of_the_receiver_are_told_from_driving():
    times = np.array([0.0, 1, 2, 3, 60])
    places = np.array([[0.0, 0], [5, 0], [40, 0], [42, 0], [300, 0]])
    np.testing.assert_array_equal(
        recordings_park.jumps(Fixes(times, places)), [False, False, True, False, False]
    )


def test_each_sighting_belongs_to_the_step_that_leads_to_its_pose():
    graph, *_ = circle_graph(steps=5)
    steps = recordings_park.make_steps(graph)
    assert [step.observations.ids.tolist() for step in steps] == [[5], [], [5], [], []]
    early = replace(graph, observers=np.array([0, 3]))
    with pytest.raises(ValueError, match="seen before the first motion"):
        recordings_park.make_steps(early)


def test_a_step_is_timed_from_one_request_to_the_next():
    graph, *_ = circle_graph(steps=30)
    times = recordings_park.step_times(recordings_park.make_steps(graph), runs=2)
    assert times.shape == (30,)
    assert (times > 0).all()


# ---- the building --------------------------------------------------------------------------------


def test_interval_of_a_root_mean_square_covers_it():
    """Law: over many samples, the 95 % interval holds the true value about that often."""
    hits = 0
    for rng in np.random.default_rng(9).spawn(300):
        errors = rng.normal(0, 2, 70)
        value, low, high = recordings_corners.root_mean_square(errors)
        hits += low <= 2.0 <= high
        assert value == pytest.approx(np.sqrt(np.mean(errors**2)))
    assert stats.binomtest(hits, 300, 0.93).pvalue > 1e-3  # a little short, for squares are skewed


def test_steps_and_loops_are_scored_apart_in_metres_and_degrees():
    """Law: the root mean square of the errors that were put into the relations."""
    pairs = np.array([(k, k + 1) for k in range(5)] + [(k, k + 20) for k in range(4)])
    errors = np.random.default_rng(4).normal(size=(9, 2))
    motions = np.zeros((9, 6))
    motions[:, [0, 5]] = errors * [0.1, np.deg2rad(3)]
    motions[:, 0] += pairs[:, 1] - pairs[:, 0]
    relations = Relations(pairs.astype(float), motions, ReadReport(records(), {}, {}))
    poses = np.column_stack([np.arange(30.0), np.zeros((30, 2))])
    values, low, high = recordings_corners.score(poses, relations, np.arange(30.0))
    for row, part in zip(values, (errors[:5], errors[5:]), strict=True):
        np.testing.assert_allclose(row, np.sqrt(np.mean(part**2, axis=0)) * [0.1, 3], rtol=1e-9)
    assert (low < values).all()
    assert (values < high).all()


def test_a_relation_may_name_the_later_scan_first():
    pairs = np.array([[3, 4], [7, 6], [2, 25], [28, 1]])
    motions = np.zeros((4, 6))
    motions[:, 0] = np.diff(pairs)[:, 0] + [0.1, 0.2, 0.3, 0.4]
    relations = Relations(pairs.astype(float), motions, ReadReport(records(), {}, {}))
    poses = np.column_stack([np.arange(30.0), np.zeros((30, 2))])
    values = recordings_corners.score(poses, relations, np.arange(30.0))[0]
    expected = np.sqrt([np.mean([0.1**2, 0.2**2]), np.mean([0.3**2, 0.4**2])])
    np.testing.assert_allclose(values[:, 0], expected)


# ---- what is stored, and its drawings ------------------------------------------------------------


@pytest.fixture(scope="module")
def stored():
    """The stored results, as a reader without the recordings has them."""
    found = (recordings_robots.UTIAS, recordings_park.VICTORIA, recordings_corners.INTEL)
    return {recording.store: recording.stored().result for recording in found}


def test_recordings_of_further_pages_are_the_chapters_and_those_only_once(stored):
    found = [recording.store for recording in chapters.recordings(["anchored_slam"])]
    assert sorted(found) == sorted(stored)


def test_stored_results_are_small(stored):
    for name in stored:
        assert (records() / f"{name}.npz").stat().st_size < 200_000


def test_tables_say_what_is_stored(stored):
    found = stored["anchored-utias"]
    table, lasting = recordings_robots.robot_table(found), found.errors["lasting"]
    for row, name in enumerate(list(table.rows)[:-1]):
        assert name == str(row + 1)
        expected = [found.dead[row], *lasting.ate[row], *lasting.inside[row]]
        np.testing.assert_allclose(table.rows[name], expected)
    means = [table["mean", f"{anchors} (m)"] for anchors in ("no", "one", "two")]
    np.testing.assert_allclose(means, lasting.ate.mean(axis=0))
    methods = recordings_robots.method_table(found)
    assert list(methods.rows) == list(recordings_robots.METHODS.values())
    for method, words in recordings_robots.METHODS.items():
        inside = found.errors[method].inside[:, 2].mean()
        assert methods[words, "two, inside"] == pytest.approx(inside)
    change = recordings_robots.anchor_table(found)["two anchors", "change (m)"]
    assert change.estimate == pytest.approx((lasting.ate[:, 2] - lasting.ate[:, 0]).mean())
    gates = recordings_robots.gate_table(found)
    for row, name in enumerate(gates.rows):
        assert gates[name, "rejected"] == lasting.rejected[row, 0]
        assert gates[name, "none (m)"] == found.errors["ungated"].ate[row, 0]
    why = recordings_robots.innovation_table(found)
    assert why[recordings_robots.METHODS["white"], "NIS"] == pytest.approx(
        found.errors["white"].nis[:, 0].mean()
    )
    sensors = recordings_robots.sensor_table(found)
    assert sum(sensors[name, "wrong"] for name in sensors.rows) == 9
    assert sensors["2", "σ (m)"] == found.robots[2].sensors.sigma[0]
    building = stored["anchored-intel"]
    worst = recordings_corners.relation_table(building)["filter, blind, worst", "loop (m)"]
    assert worst == building.errors["blind"][:, 1, 0].max()


def test_drawings_are_drawn_again_without_leaving_the_last_ones(stored):
    found = stored["anchored-utias"]
    _, ax = figure(height=6.0)
    counts = set()
    for robot in (1, 4):
        for anchors in range(3):
            drawings.robot_path(ax, found, robot, anchors)
            counts.add((len(ax.lines), len(ax.texts), anchors > 0))
            (shown,) = [line for line in ax.lines if line.get_marker() == "s"]
            assert len(shown.get_xdata()) == anchors
    assert len(counts) == 2  # an anchor is named where one is drawn


def test_drawings_show_the_numbers(stored):
    found, park = stored["anchored-utias"], stored["anchored-victoria"]
    _, ax = figure()
    drawings.nees_over_time.on(ax, found, 2)
    np.testing.assert_array_equal(
        ax.lines[2].get_ydata(), np.maximum(found.robots[2].nees[2], 0.05)
    )
    _, ax = figure()
    building = stored["anchored-intel"]
    drawings.building_paths.on(ax, building)
    np.testing.assert_array_equal(ax.lines[-1].get_xdata(), building.ways["told"].T[0])
    _, ax = figure()
    drawings.step_times.on(ax, park)
    np.testing.assert_array_equal(ax.lines[0].get_ydata(), park.microseconds[0])
    _, ax = figure()
    drawings.loop_errors.on(ax, building)
    blind = [line for line in ax.lines if line.get_color() == MEANING["names unknown"]]
    np.testing.assert_array_equal(blind[0].get_ydata(), building.errors["blind"][:, 1, 0])


@given(st.integers(0, 2**31))
@settings(max_examples=20)
def test_ellipses_hold_their_share(seed):
    """Points of the drawn rings have the squared length of the level."""
    rng = np.random.default_rng(seed)
    root = rng.normal(size=(3, 2, 2))
    covs, centres = root @ root.mT + 0.1 * np.eye(2), rng.normal(size=(3, 2))
    _, ax = figure()
    drawings.ellipses(ax, centres, covs, "black", deviations=np.sqrt(stats.chi2.ppf(0.9, 2)))
    rings = np.stack(ax.lines[0].get_data(), axis=-1).reshape(3, -1, 2)[:, :-1]
    offsets = rings - centres[:, None]
    squared = np.einsum("nki,nij,nkj->nk", offsets, np.linalg.inv(covs), offsets)
    np.testing.assert_allclose(squared, stats.chi2.ppf(0.9, 2), rtol=1e-6)


# ---- the recordings themselves -------------------------------------------------------------------


def need(name):
    found = datasets.find(name)
    if found is None:
        pytest.skip(f"the recording {name} is not on this computer")
    return found


def batch_trees(steps, history):
    """Return GTSAM's least squares over all poses and trees, begun at the filter's."""
    gtsam = pytest.importorskip("gtsam")
    factors, values = gtsam.NonlinearFactorGraph(), gtsam.Values()
    exact = gtsam.noiseModel.Isotropic.Sigma(3, 1e-6)
    factors.add(gtsam.PriorFactorPose2(0, gtsam.Pose2(), exact))
    values.insert(0, gtsam.Pose2())
    for name, place in zip(history.belief.ids.tolist(), history.belief.landmarks, strict=True):
        values.insert(100_000 + name, gtsam.Point2(*place))
    for k, step in enumerate(steps):
        values.insert(k + 1, gtsam.Pose2(*history.poses[k]))
        noise = gtsam.noiseModel.Gaussian.Covariance(step.motion.noise)
        motion = gtsam.Pose2(*step.motion.increment)
        factors.add(gtsam.BetweenFactorPose2(k, k + 1, motion, noise))
        for name, (x, y), cov in zip(
            step.observations.ids.tolist(),
            step.observations.values,
            step.observations.covs,
            strict=True,
        ):
            far, sigma = np.hypot(x, y), np.sqrt(cov[0, 0])  # the same along and across
            spread = gtsam.noiseModel.Diagonal.Sigmas(np.array([sigma / far, sigma]))
            seen = gtsam.Rot2(np.arctan2(y, x)), far, spread
            factors.add(gtsam.BearingRangeFactor2D(k + 1, 100_000 + name, *seen))
    best = gtsam.LevenbergMarquardtOptimizer(factors, values).optimize()
    return np.array([best.atPoint2(100_000 + name) for name in history.belief.ids.tolist()])


def test_on_the_first_stretch_of_the_park_filters_and_optima_agree():
    """Oracle: GTSAM, of range and bearing as wide as the file's coordinates."""
    graph = datasets.read_landmark_graph(need("victoria_park") / "victoria_park_graph.txt.gz")
    steps = recordings_park.make_steps(graph)[:300]
    histories = {
        name: recordings_park.run_drive(steps, name) for name in recordings_park.LINEARISATIONS
    }
    theirs = batch_trees(steps, histories["latest"])
    for history in histories.values():
        ours = smooth(steps, history, recordings_park.SENSOR).landmarks
        for best in (ours, theirs):  # m; the trees' deviations are 0.9 m
            assert np.sqrt(np.mean(np.sum((history.belief.landmarks - best) ** 2, axis=1))) < 0.1
        np.testing.assert_allclose(ours, theirs, atol=0.1)  # m; for the noises differ in form


def test_in_the_park_first_estimates_end_at_the_batch_optimum_and_latest_ones_do_not(stored):
    """Of the stored study."""
    park = stored["anchored-victoria"]
    latest, first = park.runs.values()
    assert first.apart < 1.0  # m; the deviations are 2 m
    assert first.squared < 0.5
    assert latest.apart > 10.0
    assert latest.squared > 50.0  # χ² with two degrees of freedom
    table = recordings_park.batch_table(park)
    assert [table[row, "apart (m)"] for row in table.rows] == [latest.apart, first.apart]


@pytest.mark.slow
def test_the_optimum_of_the_park_is_that_of_gtsam_and_does_not_depend_on_the_guess():
    graph = datasets.read_landmark_graph(need("victoria_park") / "victoria_park_graph.txt.gz")
    steps = recordings_park.make_steps(graph)
    ours = [
        smooth(steps, recordings_park.run_drive(steps, name), recordings_park.SENSOR).landmarks
        for name in recordings_park.LINEARISATIONS
    ]
    np.testing.assert_allclose(*ours, atol=0.01)
    theirs = batch_trees(steps, recordings_park.run_drive(steps, "first"))
    np.testing.assert_allclose(ours[0], theirs, atol=1.0)  # m; the trees' deviations are 2 m


def test_neither_satellites_nor_innovations_tell_the_two_filters_apart(stored):
    """Of the stored study: what the batch optimum above shows, they do not."""
    found = stored["anchored-victoria"]
    runs = found.runs.values()
    assert {len(run.trees) for run in runs} == {151}
    assert (found.steps, found.sightings) == (6968, 3640)
    assert found.apart > 10
    ate = [run.ate for run in runs]
    assert max(ate) < found.ate_dead / 10
    assert abs(ate[1] - ate[0]) < 0.5
    assert max(abs(run.nis - 1) for run in runs) < 0.15


@pytest.mark.slow
def test_park_is_as_stored(stored):
    live, park = recordings_park.filtered_twice(need("victoria_park")), stored["anchored-victoria"]
    for name in ("ate_dead", "apart", "turned", "ate", "fit"):
        assert getattr(live, name) == pytest.approx(getattr(park, name), rel=0.01)
    for method, run in live.runs.items():
        for name in ("ate", "nis", "apart", "stated", "squared"):
            stored_one = getattr(park.runs[method], name)
            assert getattr(run, name) == pytest.approx(stored_one, rel=0.01), name


@pytest.mark.slow
def test_robots_are_as_stored(stored):
    live = recordings_robots.all_robots(need("utias_mrclam_6"))
    for method in ("lasting", "first"):
        cells, expected = (
            recordings_robots.cells(found.errors[method])
            for found in (live, stored["anchored-utias"])
        )
        np.testing.assert_allclose(cells, expected, atol=0.005)


@pytest.mark.slow
def test_building_is_as_stored(stored):
    live = recordings_corners.every_choice(need("carmen_intel"))
    for name in ("odometry", "calibrated", "corrected", "told"):
        expected = stored["anchored-intel"].errors[name]
        np.testing.assert_allclose(live.errors[name], expected, rtol=0.02, atol=1e-3)


def test_two_anchors_bring_the_real_robots_near_the_truth(stored):
    """Of the stored study: every robot, with its own interval of luck left out."""
    ate = stored["anchored-utias"].errors["lasting"].ate
    assert (ate[:, 2] < 0.25).all()
    assert (ate[:, 2] < ate[:, 0]).all()
    assert (stored["anchored-utias"].dead > 0.8).all()


def test_five_robots_of_one_set_are_five_cases(stored):
    """Of the stored study: the interval over robots is as wide as what the anchors change."""
    table = recordings_robots.anchor_table(stored["anchored-utias"])
    for anchors in recordings_robots.ANCHORS[1:]:
        change = table[anchors, "change (m)"]
        assert change.estimate < 0
        assert (change.high - change.low) / 2 > 0.9 * abs(change.estimate)


def test_noise_told_as_lasting_explains_the_small_innovations(stored):
    """Of the stored study: the sightings' own errors are as small against it as the innovations."""
    table = recordings_robots.innovation_table(stored["anchored-utias"])
    for method in ("white", "lasting"):
        own, nis = (table[recordings_robots.METHODS[method], column] for column in table.columns)
        assert 0.4 < nis / own < 2.5


def test_first_estimates_are_believed_more_often_where_the_heading_is_not_seen(stored):
    """Of the stored study: without anchor they cure real robots too; with two, nothing is ill."""
    errors = stored["anchored-utias"].errors
    lasting, first = (errors[name].inside.mean(axis=0) for name in ("lasting", "first"))
    assert first[0] > lasting[0] + 0.2
    assert abs(first[2] - lasting[2]) < 0.1
