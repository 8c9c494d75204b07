"""The gauge study: exact ranks, worlds really moved, and what three filters claim to know."""

from dataclasses import asdict, replace
from itertools import product
from types import MappingProxyType

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.distance import pdist

from data_synth.wheels import Slip
from robot_perception.chapters.anchored_slam import gauge
from robot_perception.chapters.anchored_slam.figures import gauge as draw
from robot_perception.chapters.anchored_slam.gauge import (
    AT_REST,
    CLAIMS,
    CONTROLS,
    DIRECTIONS,
    EXERCISES,
    FILTERS,
    PRESETS,
    READINGS,
    SETS,
    Config,
)
from robot_perception.evaluation.consistency import average_bounds
from robot_perception.slam.observability import (
    analyse,
    fixed_point_matrix,
    information_along,
    trajectory_matrix,
)
from robot_perception.slam.observability.gauge import gauge_directions
from robot_perception.slam.observability.symbolic import Reading
from robot_perception.teaching.claims import Size
from robot_perception.teaching.explore import explore
from robot_perception.teaching.figures import figure

RUNS = 15

# Ranks -------------------------------------------------------------------------------------------


def numeric_rank(name, reading, moving):
    """Return the rank by floating point, in the world of the explorer with one landmark."""
    used = gauge.sensors(name, gauge.PLACES)
    poses = gauge.PATH if moving else gauge.PATH * [0, 0, 1] + [1, 2, 0]
    states = np.hstack([poses, np.tile(gauge.LANDMARKS[0], (len(poses), 1))])
    if reading == "one point":
        increment = np.array([0.8, -0.1, 0.2]) * [moving, moving, 1]
        return analyse(fixed_point_matrix(used, states[0], increment)).rank
    return analyse(trajectory_matrix(used, states)).rank


@pytest.mark.parametrize("moving", [True, False])
def test_exact_ranks_equal_those_of_floating_point(moving):
    table = gauge.ranks(moving=moving)
    assert set(table) == set(product(SETS, READINGS))
    assert all(reading.proven for reading in table.values())
    for (name, reading), entry in table.items():
        assert entry.rank == numeric_rank(name, reading, moving), (name, reading)


def test_table_says_what_the_ranks_say():
    lines = gauge.rank_table().splitlines()
    assert lines[0].split()[:3] == ["rank", "of", "5"]
    for name, line in zip(SETS, lines[1:], strict=True):
        cells = line.removeprefix(name).split()
        assert [int(cell) for cell in cells[:3]] == [gauge.ranks()[name, r].rank for r in READINGS]
    assert lines[2].endswith("turn about the anchor")
    assert "position sensor" in (still := gauge.rank_table(moving=False).splitlines()[-1])
    assert still.endswith("turn about the robot")


# Moved worlds ------------------------------------------------------------------------------------

UNSEEN = {
    "plain": set(DIRECTIONS),
    "one anchor": {"turn about the anchor"},
    AT_REST: {"turn about the robot"},
}


@pytest.mark.parametrize("direction", DIRECTIONS)
@pytest.mark.parametrize("sensing", [*SETS, AT_REST])
def test_residuals_vanish_exactly_along_what_is_unseen(sensing, direction):
    for amount in CONTROLS["amount"].values:
        world = gauge.move_world(sensing, direction, amount)
        largest = max(world.metres, world.radians)
        if amount == 0 or direction in UNSEEN.get(sensing, set()):
            assert largest < 1e-12
        else:
            assert largest > 0.1


def test_what_is_unseen_is_what_the_exact_analysis_names():
    for name, moving in (*product(SETS, (True,)), ("position sensor", False)):
        named = gauge.ranks(moving=moving)[name, "nonlinear"].unseen
        seen = UNSEEN.get(name if moving else AT_REST, set())
        assert set(named) <= seen
        assert bool(named) == bool(seen)


@given(st.sampled_from([*SETS, AT_REST]), st.sampled_from(DIRECTIONS), st.floats(-3, 3, width=32))
@settings(max_examples=60)
def test_moving_keeps_all_distances_and_the_gap_is_the_residual(sensing, direction, amount):
    world = gauge.move_world(sensing, direction, amount)
    before = np.vstack([world.poses[:, :2], world.landmarks])
    after = np.vstack([world.moved_poses[:, :2], world.moved_landmarks])
    np.testing.assert_allclose(pdist(before), pdist(after), atol=1e-12)
    gaps = np.linalg.norm(world.misses - world.anchors, axis=-1)
    shifts = np.linalg.norm((world.moved_poses - world.poses)[: len(world.fixes), :2], axis=-1)
    largest = max(gaps.max(initial=0.0), shifts.max(initial=0.0))
    assert world.metres == pytest.approx(largest, abs=1e-12)


@pytest.mark.parametrize(
    "call",
    [
        lambda: gauge.sensors("sonar"),
        lambda: gauge.move_world("sonar", DIRECTIONS[0], 1.0),
        lambda: gauge.move_world("plain", "sonar", 1.0),
    ],
)
def test_unknown_names_are_named(call):
    with pytest.raises(ValueError, match="'sonar'; there are"):
        call()


def test_explorer_says_what_was_computed():
    fig, ax = figure(width=5.6, height=5.0)

    def draw_one(**parameters):
        draw.moved_world(ax, **asdict(gauge.move_world(**parameters)))
        return fig

    explorer = explore(draw_one, alt=gauge.describe, presets=PRESETS, **CONTROLS)
    for parameters in explorer.end_points():
        alt = explorer.frame(effort=0, **parameters).alt
        world = gauge.move_world(**parameters)
        (words,) = [t.get_text() for t in ax.texts if t.get_text().startswith("largest")]
        assert f"{world.metres:.2f} m" in words
        assert words.removeprefix("largest residual ") in alt
        assert ("heading" in words) == (world.radians > 0)
    assert len(list(explorer.grid())) <= 120


# Information that nobody sent --------------------------------------------------------------------


@pytest.fixture(scope="module")
def study():
    return gauge.run(Config(runs=RUNS, steps=100), rng=np.random.default_rng(5))


@pytest.mark.parametrize("kind", ["first estimates", "ideal"])
def test_at_consistent_points_nothing_is_invented(study, kind):
    assert not study[kind].invented.any()
    # and it never comes back: wheels only take away
    assert (np.diff(study[kind].gains, axis=1) < 1e-6).all()


def test_the_standard_filter_invents_information(study):
    assert study["standard"].invented.all()
    assert np.median(study["standard"].gains[:, -1]) > 5


def test_without_noise_of_the_wheels_the_information_stands_still():
    config = Config(runs=3, steps=40, slip=Slip(0.0, 0.0, 0.0, 0.0))
    results = gauge.run(config, rng=np.random.default_rng(6))
    for kind in ("first estimates", "ideal"):
        np.testing.assert_allclose(results[kind].gains, 1.0, atol=1e-7)


def test_no_honest_heading_is_surer_than_the_turn_it_started_with():
    config = Config(runs=1)
    drive = gauge.simulate(config, rng=np.random.default_rng(7))
    for kind in FILTERS:
        point = drive.path[0] if kind == "ideal" else drive.start.mean
        N = gauge_directions(point, drive.places[gauge.ANCHOR])["turn"]
        floor = 1 / information_along(N, drive.start.cov)
        lowest = gauge.filter_drive(config, drive, kind).pose_covs[:, 2, 2].min()
        assert (lowest >= floor * (1 - 1e-9)) == (kind != "standard")


@pytest.mark.parametrize("kind", FILTERS)
def test_who_states_the_error_of_the_heading(study, kind):
    low, high = average_bounds(1, RUNS, 1 - 1e-4)
    after = study[kind].nees[[0, 40, 70, -1]]
    if kind == "standard":
        assert (after[1:] > high).all()
    else:
        assert ((low < after) & (after < high)).all()


def test_a_second_anchor_makes_the_standard_filter_honest_and_sharp(study):
    config = Config(runs=RUNS, steps=100, anchors=2)
    two = gauge.run(config, ("standard",), rng=np.random.default_rng(8))["standard"]
    low, high = average_bounds(1, RUNS, 1 - 1e-4)
    assert low < two.nees[-1] < high
    assert two.rms[-1] < study["ideal"].rms[-1] / 5


def test_a_start_known_in_heading_leaves_little_to_invent():
    config = Config(runs=RUNS, steps=100, heading_deviation=np.deg2rad(1.0))
    result = gauge.run(config, ("standard",), rng=np.random.default_rng(9))["standard"]
    assert np.median(result.gains[:, -1]) < 1.2


def test_the_same_seed_gives_the_same_study():
    config = replace(Config(), runs=2, steps=10)
    first, again = (gauge.run(config, rng=np.random.default_rng(3)) for _ in range(2))
    for kind in FILTERS:
        assert np.array_equal(first[kind].gains, again[kind].gains)


def test_drawings_show_the_numbers(study):
    _, ax = figure()
    draw.claimed_information(ax, {name: r.gains for name, r in study.items()})
    lines = [line.get_ydata() for line in ax.lines if len(line.get_ydata()) > 2]
    for line, result in zip(lines, study.values(), strict=True):
        np.testing.assert_array_equal(line, np.median(result.gains, axis=0))
    _, axes = figure(1, 3, width=7.4)
    stated = {name: r.deviations for name, r in study.items()}
    draw.heading_honesty(axes, stated, {name: r.rms for name, r in study.items()})
    for panel, result in zip(axes, study.values(), strict=True):
        np.testing.assert_allclose(panel.lines[1].get_ydata(), np.degrees(result.rms))


# The claim and the exercise ----------------------------------------------------------------------


def test_the_claim_is_conditional_and_says_on_what():
    (claim,) = CLAIMS
    entry = claim.run("quick")
    assert entry.verdict == "conditional"
    assert entry.value["estimate"] == 0
    company, translates = entry.conditions
    assert "second anchor or a compass" in company
    assert "translates" in translates
    for (name, reading), exact in gauge.ranks().items():
        assert entry.evidence[f"rank, {name}, {reading}"]["estimate"] == exact.rank
    assert "in 10 of 10 runs" in entry.note
    assert entry.note.endswith("at consistent points, in 0.")


@pytest.mark.parametrize(
    ("better", "verdict"),
    [
        ({}, "conditional"),
        ({"one anchor": 5}, "conditional"),
        ({"one anchor": 5, "position sensor": 5}, "reproduced"),
        ({"two anchors": 4}, "refuted"),
    ],
)
def test_the_verdict_follows_from_the_ranks(monkeypatch, better, verdict):
    honest = {moving: gauge.ranks(moving=moving) for moving in (True, False)}

    def doctored(*, moving=True):
        table = dict(honest[moving])
        for (name, reading), exact in honest[moving].items():
            rank = better.get(name, exact.rank)
            table[name, reading] = Reading(exact.dimension, rank, exact.unseen)
        return MappingProxyType(table)

    monkeypatch.setattr(gauge, "ranks", doctored)
    monkeypatch.setattr(gauge, "RUNS", {Size.QUICK: 2})
    assert CLAIMS[0].run("quick").verdict == verdict


def test_exercise_judges_right_and_wrong():
    exercise = EXERCISES["anchored-turn"]
    assert exercise.judge([-2, 2, 1, -4, 0])[0] == "right"
    assert exercise.judge([1, -1, -0.5, 2, 0])[0] == "right"
    hints = {
        exercise.judge(answer)[1]
        for answer in ([-2, 2, -1, -4, 0], [0, 0, 1, -2, -2], [1, 0, 0, 1, 0], [0] * 5, [1, 2])
    }
    assert len(hints) == 4  # the last two get the general hint
    assert all(exercise.judge(answer)[0] == "wrong" for answer in ([0] * 5, [1, 2], "north"))
