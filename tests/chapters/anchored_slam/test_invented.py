"""What three filters with one anchor claim to know of a turn that no sensor sees."""

from dataclasses import replace

import numpy as np
import pytest

from data_synth.wheels import Slip
from robot_perception.chapters.anchored_slam import figures as draw
from robot_perception.chapters.anchored_slam import invented
from robot_perception.chapters.anchored_slam.invented import FILTERS, Config
from robot_perception.evaluation.consistency import average_bounds
from robot_perception.slam.observability import gauge_directions, information_along
from robot_perception.teaching.figures import figure

RUNS = 15


@pytest.fixture(scope="module")
def study():
    return invented.run(Config(runs=RUNS, steps=100), rng=np.random.default_rng(5))


@pytest.mark.parametrize("kind", ["first estimates", "ideal"])
def test_at_consistent_points_nothing_is_invented(study, kind):
    assert not study[kind].invented.any()
    # and it never comes back: wheels only take away
    assert (np.diff(study[kind].gains, axis=1) < 1e-6).all()


def test_the_plain_filter_invents_information(study):
    assert study["plain"].invented.all()
    assert np.median(study["plain"].gains[:, -1]) > 5


def test_without_noise_of_the_wheels_the_information_stands_still():
    config = Config(runs=3, steps=40, slip=Slip(0.0, 0.0, 0.0, 0.0))
    results = invented.run(config, rng=np.random.default_rng(6))
    for kind in ("first estimates", "ideal"):
        np.testing.assert_allclose(results[kind].gains, 1.0, atol=1e-7)


def test_no_honest_heading_is_surer_than_the_turn_it_started_with():
    config = Config(runs=1)
    drive = invented.simulate(config, rng=np.random.default_rng(7))
    for kind in FILTERS:
        point = drive.path[0] if kind == "ideal" else drive.start.mean
        N = gauge_directions(point, drive.places[0])["turn"]
        floor = 1 / information_along(N, drive.start.cov)
        lowest = invented.filter_drive(config, drive, kind).pose_covs[:, 2, 2].min()
        assert (lowest >= floor * (1 - 1e-9)) == (kind != "plain")


@pytest.mark.parametrize("kind", FILTERS)
def test_who_states_the_error_of_the_heading(study, kind):
    low, high = average_bounds(1, RUNS, 1 - 1e-4)
    after = study[kind].nees[[0, 40, 70, -1]]
    if kind == "plain":
        assert (after[1:] > high).all()
    else:
        assert ((low < after) & (after < high)).all()


def test_a_second_anchor_makes_the_plain_filter_honest_and_sharp(study):
    config = Config(runs=RUNS, steps=100, anchors=2, filters=("plain",))
    two = invented.run(config, rng=np.random.default_rng(8))["plain"]
    low, high = average_bounds(1, RUNS, 1 - 1e-4)
    assert low < two.nees[-1] < high
    assert two.rms[-1] < study["ideal"].rms[-1] / 5


def test_a_start_known_in_heading_leaves_little_to_invent():
    config = Config(RUNS, 100, heading_deviation=np.deg2rad(1.0), filters=("plain",))
    result = invented.run(config, rng=np.random.default_rng(9))["plain"]
    assert np.median(result.gains[:, -1]) < 1.2


def test_the_same_seed_gives_the_same_study():
    config = replace(Config(), runs=2, steps=10)
    first, again = (invented.run(config, rng=np.random.default_rng(3)) for _ in range(2))
    for kind in FILTERS:
        assert np.array_equal(first[kind].gains, again[kind].gains)


def test_drawings_show_the_numbers(study):
    _, ax = figure()
    draw.claimed_information.on(ax, study)
    lines = [line.get_ydata() for line in ax.lines if len(line.get_ydata()) > 2]
    for line, result in zip(lines, study.values(), strict=True):
        np.testing.assert_array_equal(line, np.median(result.gains, axis=0))
    _, axes = figure(1, 3, width=7.4)
    draw.heading_honesty.on(axes, study)
    for panel, result in zip(axes, study.values(), strict=True):
        np.testing.assert_allclose(panel.lines[1].get_ydata(), np.degrees(result.rms))
