"""Fig. 7: the study of the building, the study of the posts, their claims, and the explorers."""

from dataclasses import replace
from itertools import product

import numpy as np
import pytest
from scipy import stats

from data_synth.posts import glimpse
from data_synth.wheels import roll
from robot_perception.chapters.anchored_slam import building, loops, posts
from robot_perception.chapters.anchored_slam.building import CLAIMS
from robot_perception.chapters.anchored_slam.figures import building as draw
from robot_perception.chapters.anchored_slam.loops import Case
from robot_perception.chapters.anchored_slam.posts import LINEAR, TURNED
from robot_perception.evaluation.consistency import average_bounds
from robot_perception.observations import Observations
from robot_perception.teaching.explore import MOST_STATES, Explorer
from robot_perception.teaching.figures import figure

RNG = np.random.default_rng
VERDICTS = {
    "planar-loop": "refuted",
    "controllability-rule": "conditional",
    "jacobian-consistency": "conditional",
}
FEW = (Case("plain", association="known"), Case("anchored"), Case("external", "small"))


@pytest.fixture(scope="module")
def study():
    return building.run(building.Config(seeds=2), rng=RNG(0), cases=FEW)


# The building


def test_a_seed_does_not_depend_on_how_many_there_are(study):
    one = building.run(building.Config(seeds=1), rng=RNG(0), cases=FEW[:1])
    np.testing.assert_array_equal(one.runs[FEW[0]].errors[0], study.runs[FEW[0]].errors[0])
    assert not np.allclose(study.runs[FEW[0]].errors[1], study.runs[FEW[0]].errors[0])


def test_landmarks_of_the_scans_are_true_ones(study):
    number, none = study.sightings
    assert number > 2
    assert none < 0.005


def test_known_names_are_never_wrong_and_leave_no_landmark_twice(study):
    known = study.runs[FEW[0]]
    assert not known.false.any()
    assert not known.twice.any()
    assert (known.map_shape <= known.map_error + 1e-12).all()  # a motion can only improve


def test_the_start_is_out_of_sight_before_and_in_sight_at_the_end(study):
    here, reach = study.poses[study.before, :2], study.config.scanner.max_range
    assert np.hypot(*here) > reach
    assert np.hypot(*(study.poses[-1, :2] - study.poses[int(8 / 0.2), :2])) < 0.2
    way = study.config.step * study.before
    assert 70 < way < 80


def test_closing_the_loop_with_known_names_makes_the_error_small(study):
    plain = study.runs[FEW[0]]
    assert (plain.distance() < plain.distance(study.before) / 5).all()


def test_the_anchor_is_the_nearest_of_the_first_landmarks():
    sightings = [
        Observations(np.array([], int), np.empty((0, 2)), np.empty((0, 2, 2))),
        Observations(
            np.array([-1, 7, 4]), np.array([[1.0, 0], [5, 0], [2, 1]]), np.zeros((3, 2, 2))
        ),
    ]
    assert loops.first_observed(sightings) == 4


def test_wrong_associations_are_counted_against_who_a_landmark_was_at_first():
    names = [np.array([3, 5]), np.array([3, 5]), np.array([5, 3])]
    used = (np.array([0, 1]), np.array([0, 1]), np.array([0, 2]))
    landmarks = np.arange(12.0).reshape(6, 2)
    start = loops.MapBelief(
        np.r_[0, 0, 0, landmarks[3], landmarks[5], landmarks[3]], np.eye(9), np.array([0, 1, 2])
    )
    history = loops.History(
        start=np.zeros(3),
        times=np.full(3, np.nan),
        poses=np.zeros((3, 3)),
        pose_covs=np.broadcast_to(np.eye(3), (3, 3, 3)),
        nis=np.zeros(3),
        dof=np.zeros(3, int),
        sizes=np.array([2, 2, 3]),
        used=used,
        belief=start,
        frozen={},
        counts=loops.run_filter(
            loops.MapBelief.start(np.zeros(3), np.eye(3)),
            [loops.Step(None)],
            loops.Settings(loops.CartesianSensor(np.eye(2))),
        ).counts,
        kept={},
    )
    seen = [Observations(n, np.zeros((2, 2)), np.zeros((2, 2, 2))) for n in names]
    runs = loops.stack([loops.account(history, np.zeros((3, 3)), seen, landmarks)])
    assert runs.false.tolist() == [1]  # landmark 0 was the third, then the fifth is taken for it
    assert runs.twice.tolist() == [1]  # the third came into the map again, as 2
    np.testing.assert_allclose(runs.map_error, 0, atol=1e-12)
    assert runs.states[0] == pytest.approx((49 + 49 + 81) / 3)


# The posts: only linearisation can make the filter wrong


@pytest.fixture(scope="module")
def linear():
    return posts.run_posts(replace(LINEAR, runs=50), posts.JACOBIANS[:5], rng=RNG(11))


@pytest.mark.parametrize("variant", posts.JACOBIANS[:5])
def test_noise_of_linear_size_leaves_the_filters_consistent(linear, variant):
    runs = linear[variant]
    low, high = average_bounds(3, 50, 1 - 1e-4)
    for step in (4, 100, 300, -1):
        assert low < runs.nees[:, step].mean() < high
    # steps of a run hang together, so that the share varies; see the next test for what it is
    assert runs.coverage.averaged_share > 0.75


def test_share_of_steps_in_the_band_is_what_honest_errors_of_such_memory_give(linear):
    """Errors drawn from the filter's own covariances, with the runs' memory, fill the band so."""
    runs = linear["first estimates"]
    averages = runs.coverage.averages - 3
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
    assert runs.coverage.averaged_share >= least


def test_an_uncertain_start_breaks_the_plain_filter_and_not_the_one_with_first_estimates():
    config = replace(TURNED, runs=30)
    runs = posts.run_posts(config, ("plain", "first estimates", "true Jacobians"), rng=RNG(2))
    high = average_bounds(3, 30, 1 - 1e-6)[1]
    assert runs["plain"].nees[:, -1].mean() > high
    for variant in ("first estimates", "true Jacobians"):
        assert runs[variant].nees[:, -1].mean() < high


def test_what_a_run_saw_is_the_worlds_glimpse_with_its_covariance():
    config = posts.PostsConfig(noise=2.0)
    places, poses = config.world
    sightings, chance = posts.observe(config, rng=RNG(5))
    streams = RNG(5).spawn(4)
    seen = glimpse(places, poses, sigma=0.06, reach=6.0, rng=streams[0])
    for sighting, (ids, at) in zip(sightings, seen, strict=True):
        np.testing.assert_array_equal(sighting.ids, ids)
        np.testing.assert_array_equal(sighting.values, at)
        np.testing.assert_allclose(
            sighting.covs, np.broadcast_to(0.06**2 * np.eye(2), (len(ids), 2, 2))
        )
    assert chance.wheels["own"].deviations[0, 0] == pytest.approx(
        2 * roll(poses, posts.SMALL, rng=RNG(0)).deviations[0, 0]
    )


def test_considered_landmarks_keep_the_filter_honest_and_frozen_ones_do_not():
    runs = posts.run_posts(replace(posts.RULE, runs=12), posts.RULE_VARIANTS, rng=RNG(4))
    plain, rule, considered = (runs[name] for name in posts.RULE_VARIANTS)
    assert rule.retired.min() > 20
    assert rule.states.mean() < 0.2 * plain.states.mean()
    assert considered.states.mean() == pytest.approx(plain.states.mean())
    assert rule.nees.mean() > 20 * plain.nees.mean()
    assert considered.nees.mean() == pytest.approx(plain.nees.mean(), rel=0.2)


def test_ratio_of_means_against_the_delta_method():
    rng = RNG(0)
    below = rng.uniform(1, 2, 400)
    above = 0.5 * below + rng.normal(0, 0.1, 400)
    value = loops.ratio_of(above, below, rng, "test")
    residual = above - value.estimate * below
    half = stats.norm.ppf(0.975) * residual.std(ddof=1) / np.sqrt(400) / below.mean()
    assert value.estimate == pytest.approx(above.mean() / below.mean())
    np.testing.assert_allclose(
        [value.low, value.high], value.estimate + np.array([-half, half]), atol=0.15 * half
    )


# Claims


@pytest.fixture(scope="module")
def entries():
    return {claim.id: claim.run("quick") for claim in CLAIMS}


def test_verdicts(entries):
    assert {key: entry.verdict for key, entry in entries.items()} == VERDICTS


@pytest.mark.slow
@pytest.mark.parametrize("claim", CLAIMS, ids=lambda claim: claim.id)
def test_full_size_gives_the_same_verdict(claim):
    assert claim.run("full").verdict == VERDICTS[claim.id]


def test_the_anchor_and_the_plain_filter_end_alike_and_the_external_sensor_does_not(entries):
    evidence = entries["planar-loop"].evidence
    external = evidence["end error, external over plain"]["estimate"]
    assert external < 0.5 < entries["planar-loop"].interval.low


def test_recorded_ends_are_the_evidence(entries):
    ends = building.recorded_ends(entries["planar-loop"].evidence)
    key = "end: plain; large noise, gated, exact start"
    assert ends["large"]["plain"][0] == entries["planar-loop"].evidence[key]["estimate"]
    known = building.recorded_ends(entries["planar-loop"].evidence, "known")
    assert set(known["large"]) == {"plain", "anchored"}
    _, axes = figure(1, 2)
    draw.end_errors(axes, {"large": ends["large"], "known": known["large"]})
    assert [t.get_text() for t in axes[0].get_yticklabels()] == list(ends["large"])


def test_recorded_table_prints_the_evidence(entries):
    evidence = entries["planar-loop"].evidence
    rows = building.recorded_table(evidence).split("\n")
    ends = building.recorded_ends(evidence)
    assert len(rows) == sum(1 + len(names) for names in ends.values())
    assert len({len(row) for row in rows}) == 1
    where = "plain; large noise, gated, exact start"
    row = next(row for row in rows if row.startswith("plain"))
    for name in ("before", "end", "map", "map, aligned"):
        assert f"{evidence[f'{name}: {where}']['estimate']:.2f}" in row
    assert row.endswith(f"{evidence[f'median NEES: {where}']['estimate']:.1f}")


def test_table_has_a_line_for_each_case(linear):
    lines = posts.nees_table({"linear": linear}).split("\n")
    assert len(lines) == 1 + len(linear)
    nees = loops.mean_of(linear["plain"].nees.mean(axis=1), "")
    assert f"{nees.estimate:.1f} [{nees.low:.1f}, {nees.high:.1f}]" in lines[1]


# Pictures


def test_readings_of_a_good_path_lie_on_the_plan():
    maps = building.two_maps(("external", "plain"), every=40, beams=12)
    for name, points in maps.readings.items():
        gaps = _distance(points, maps.faces)
        assert (np.median(gaps) < 0.15) == (name == "external")
    _, axes = figure(1, 2)
    draw.two_maps(axes, maps)
    off = np.hypot(*(maps.paths["external"][-1, :2] - maps.poses[-1, :2]))
    assert f"{off:.2f} m" in axes[0].get_title(loc="left")


def _distance(points, faces):
    along = faces[:, 1] - faces[:, 0]
    arm = points[:, None] - faces[:, 0]
    share = ((arm * along).sum(axis=-1) / (along**2).sum(axis=-1)).clip(0, 1)
    return np.linalg.norm(arm - share[..., None] * along, axis=-1).min(axis=1)


def ends_of(controls):
    values = {name: (c.values[0], c.values[-1]) for name, c in controls.items()}
    return [dict(zip(values, chosen, strict=True)) for chosen in product(*values.values())]


def check_lines(axes):
    for ax in np.ravel(axes):
        assert ax.lines
        for line in ax.lines:
            y = np.asarray(line.get_ydata(), dtype=float)
            assert np.isfinite(y).any()


def test_explorer_of_noise_and_length():
    _, axes = figure(1, 2)
    for values in ends_of(posts.GROWTH_CONTROLS):
        draw.growth(axes, posts.growth(**values))
        check_lines(axes)
    quiet, loud = (posts.growth(noise, 90.0) for noise in (0.3, 6.0))
    for name in posts.GROWTH_FILTERS:
        assert loud.error[name].max() > quiet.error[name].max()
    short, long = (posts.growth(3.0, length) for length in (30.0, 120.0))
    assert long.error["plain"].max() > short.error["plain"].max()
    assert long.along[-1] > 3 * short.along[-1]


def test_explorer_of_anchors():
    _, axes = figure(1, 2)
    for values in ends_of(posts.ANCHOR_CONTROLS):
        state = posts.nailed(**values)
        assert len(state.anchors) == values["count"]
        draw.nailed(axes, state)
        check_lines(axes)
    none, one, two = (posts.nailed(count, 0) for count in (0, 1, 2))
    assert none.error.mean() > one.error.mean() > two.error.mean()
    assert two.heading[-1] < 0.7 * none.heading[-1]


def test_controls_are_names_that_an_explorer_can_have():
    for controls in (posts.GROWTH_CONTROLS, posts.ANCHOR_CONTROLS, posts.PLAY_CONTROLS):
        assert not [name for name in controls if hasattr(Explorer, name)]
        assert np.prod([len(c.values) for c in controls.values()]) <= MOST_STATES


def test_explorer_of_the_ellipses():
    _, ax = figure()
    for values in ends_of(posts.PLAY_CONTROLS):
        draw.moment(ax, posts.moment(**values), values["variant"])
        check_lines(ax)
    before, after = (posts.moment("plain", frame) for frame in (33, posts.FRAMES - 1))
    assert np.trace(after.pose_cov) < 0.1 * np.trace(before.pose_cov)
    assert len(after.landmarks) == len(after.posts)


def test_every_variant_has_its_own_colour():
    assert len(set(draw.TINTS.values())) == len(draw.TINTS)
    assert set(posts.JACOBIANS) == set(draw.TINTS)


def test_words_say_what_the_pictures_show():
    state = posts.growth(0.3, 30.0)
    assert f"external: at most {state.error['external'].max():.2f} m" in posts.describe_growth(
        0.3, 30.0
    )
    assert f"{posts.nailed(2, 15).error[-1]:.2f} m at the end" in posts.describe_nailed(2, 15)
    last = posts.FRAMES - 1
    assert f"{len(posts.moment('plain', last).posts)} landmarks" in posts.describe_moment(
        "plain", last
    )


# Exercises


def test_drift_of_the_exercise_is_what_the_wheels_do():
    poses = np.stack([np.linspace(0, 88.3, 442), np.zeros(442), np.zeros(442)], axis=-1)
    slip = loops.Slip(along=0.0, across=0.0, bend=np.deg2rad(0.5), turn=0.0)
    ends = []
    for own in RNG(0).spawn(1000):
        ahead, _, turned = roll(poses, slip, rng=own).increments.T
        heading = np.r_[0.0, np.cumsum(turned)[:-1]]
        ends.append(ahead @ np.sin(heading))
    answer = building.EXERCISES["anchored-drift"].answer
    low, high = np.sqrt(stats.chi2.ppf([1e-4, 1 - 1e-4], 1000) / 1000)
    assert low < np.std(ends) / answer < high


def test_exercise_of_the_frozen_landmark_is_the_nees_of_many_looks():
    rng = RNG(1)
    error = 0.10 * rng.standard_normal(20_000) + 0.03 * rng.standard_normal(20_000)
    answer = building.EXERCISES["anchored-frozen"].answer
    assert np.mean(error**2) / 0.03**2 == pytest.approx(answer, rel=0.05)


@pytest.mark.parametrize("key", ["anchored-drift", "anchored-frozen"])
def test_exercises_judge_right_and_wrong(key):
    exercise = building.EXERCISES[key]
    assert exercise.judge(exercise.answer)[0] == "right"
    assert exercise.judge(...)[0] == "not yet"
    for wrong, words in exercise.mistakes:
        outcome, said = exercise.judge(wrong)
        assert outcome == "wrong"
        assert words in said
