"""Driving against closed arcs, slip against its deviations, paths against their geometry."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy import stats
from scipy.integrate import solve_ivp

from data_synth.ceiling.robot import RADIUS, drive, taught_path
from data_synth.wheels import LARGE, SMALL, Slip

NONE = Slip(0.0, 0.0, 0.0, 0.0)
KINDS = ("line", "corner", "slalom", "loop")


def still(pose, speed, turn_rate, seconds):
    return drive(np.array(pose), speed, turn_rate, seconds, NONE, rng=np.random.default_rng(0))


def turned(angle):
    return np.exp(1j * angle)


@given(
    st.tuples(st.floats(-5, 5), st.floats(-5, 5), st.floats(-3, 3)),
    st.floats(-2, 2),
    st.floats(-2, 2),
    st.floats(0, 3),
)
def test_without_slip_it_drives_as_the_unicycles_equations_say(pose, speed, rate, seconds):
    way = solve_ivp(
        lambda _, p: [speed * np.cos(p[2]), speed * np.sin(p[2]), rate],
        *((0, seconds), pose),
        rtol=1e-9,
        atol=1e-9,
    ).y[:, -1]
    found = still(pose, speed, rate, seconds)
    np.testing.assert_allclose(found[:2], way[:2], atol=1e-6)
    assert turned(found[2]) == pytest.approx(turned(way[2]), abs=1e-6)
    assert -np.pi <= found[2] <= np.pi


def test_a_quarter_of_a_circle_and_a_straight_line():
    np.testing.assert_allclose(still([0.0, 0, 0], 1.0, 1.0, np.pi / 2), [1, 1, np.pi / 2])
    np.testing.assert_allclose(still([1.0, 2, np.pi / 2], 0.5, 0.0, 4.0), [1, 4, np.pi / 2])
    np.testing.assert_allclose(still([1.0, 2, 0], -0.5, 0.0, 4.0), [-1, 2, 0])


@pytest.mark.parametrize("slip", [SMALL, LARGE], ids=["small", "large"])
@pytest.mark.parametrize("steps", [1, 20])
def test_slip_has_its_deviations_whatever_the_length_of_the_steps(slip, steps):
    ends = []
    for rng in np.random.default_rng(5).spawn(400):
        pose = np.zeros(3)
        for _ in range(steps):
            pose = drive(pose, 0.5, 0.0, 4.0 / steps, slip, rng=rng)
        ends.append(pose)
    ends = np.array(ends) - [2, 0, 0]
    low, high = np.sqrt(stats.chi2.ppf([1e-4, 1 - 1e-4], 400) / 400)
    wanted = np.array([slip.along, slip.across, slip.bend]) * np.sqrt(2)
    ratio = np.sqrt((ends**2).mean(axis=0)) / wanted
    some = [0, 1, 2] if steps == 1 else [2]  # later steps carry the bend on to the side
    assert (low < ratio[some]).all()
    assert (ratio[some] < high).all()


def test_slip_is_along_and_across_the_robots_own_axes():
    slip = Slip(along=0.2, across=0.0, bend=0.0, turn=0.0)
    ends = np.array(
        [
            drive(np.array([0, 0, np.pi / 2]), 1.0, 0.0, 1.0, slip, rng=rng)
            for rng in np.random.default_rng(0).spawn(50)
        ]
    )
    np.testing.assert_allclose(ends[:, [0, 2]], [[0, np.pi / 2]] * 50, atol=1e-12)
    assert ends[:, 1].std() == pytest.approx(0.2, rel=0.3)


def test_turning_on_the_spot_slips_in_the_heading_only():
    slip = Slip(along=0.3, across=0.3, bend=0.0, turn=0.1)
    ends = np.array(
        [
            drive(np.zeros(3), 0.0, -0.5, 0.5, slip, rng=rng)
            for rng in np.random.default_rng(0).spawn(400)
        ]
    )
    np.testing.assert_allclose(ends[:, :2], 0)
    assert ends[:, 2].mean() == pytest.approx(-0.25, abs=0.01)
    assert ends[:, 2].std() == pytest.approx(0.05, rel=0.15)


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("seed", [None, 4])
def test_headings_are_tangential_and_bends_are_gentle(kind, seed):
    rng = None if seed is None else np.random.default_rng(seed)
    poses = taught_path(kind, step=0.001, rng=rng)
    between = np.diff(poses[:, :2], axis=0)
    tangent = between[:, 0] + 1j * between[:, 1]
    middle = turned(poses[:-1, 2]) + turned(poses[1:, 2])
    assert np.abs(np.angle(tangent / middle)).max() < 4e-4
    bend = np.angle(turned(poses[1:, 2]) / turned(poses[:-1, 2])) / np.abs(tangent)
    assert np.abs(bend).max() < 1 / RADIUS + (0.01 if seed is None else 0.3)
    length = np.abs(tangent)
    assert length == pytest.approx(0.001, rel=1e-4 if seed is None else 0.08)


@pytest.mark.parametrize(
    ("kind", "end"),
    [("line", (6, 0, 0)), ("corner", (4.5, 4.5, np.pi / 2)), ("loop", (2.5, 0, 0))],
)
def test_paths_end_where_they_should(kind, end):
    last = taught_path(kind, step=0.001)[-1]
    np.testing.assert_allclose(last, end, atol=1e-3)


def test_a_slalom_goes_left_and_right_and_ends_straight_ahead():
    poses = taught_path("slalom", step=0.001)
    assert poses[-1, 2] == pytest.approx(0, abs=1e-3)
    # an arc of 45° of 2 m rises by 2 (1 - cos 45°), the half of each of three humps
    rise = 2 * (1 - np.cos(np.pi / 4))
    assert poses[:, 1].max() == pytest.approx(2 * rise, abs=1e-5)
    assert poses[:, 1].min() == pytest.approx(0, abs=1e-5)
    assert np.abs(poses[:, 2]).max() == pytest.approx(np.pi / 4, abs=1e-3)


def test_a_loop_comes_back_over_its_start():
    poses = taught_path("loop", step=0.01)
    assert np.ptp(poses[:, 0]) == pytest.approx(8, abs=1e-3)
    assert np.ptp(poses[:, 1]) == pytest.approx(6, abs=1e-3)
    round_ = 2 * (5 + 3) + 2 * np.pi * RADIUS
    again = poses[int(round_ / 0.01) + 1 :]
    assert len(again) == pytest.approx(250, abs=2)
    np.testing.assert_allclose(again[:, 1:], 0, atol=1e-9)
    assert (again[:, 0] >= 0).all()
    assert np.angle(turned(poses[1:, 2]) / turned(poses[:-1, 2])).sum() == pytest.approx(2 * np.pi)


def test_steps_fit_the_path_and_a_hand_sways_by_centimetres():
    assert len(taught_path("line", step=0.1)) == 61
    assert len(taught_path("line", step=0.07)) == 86
    assert len(taught_path("line", step=6 / 187)) == 188  # whose quotient is just below
    np.testing.assert_allclose(taught_path("line", step=0.1)[0], 0)
    aside = np.concatenate(
        [
            taught_path("line", step=0.1, rng=rng)[:, 1]
            for rng in np.random.default_rng(0).spawn(100)
        ]
    )
    assert aside.std() == pytest.approx(0.015 * np.sqrt(4 / 2), rel=0.15)
    one, same = (taught_path("loop", step=0.1, rng=np.random.default_rng(1)) for _ in range(2))
    assert (one == same).all()


@pytest.mark.parametrize(("kind", "step", "words"), [("knot", 0.1, "kind"), ("line", 0.0, "step")])
def test_bad_paths_are_named(kind, step, words):
    with pytest.raises(ValueError, match=words):
        taught_path(kind, step=step)
