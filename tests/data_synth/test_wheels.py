"""Odometry: exact without slip, of the stated spread with it, whatever the length of the steps."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy import stats

from data_synth.wheels import LARGE, SMALL, Slip, roll, true_increments

STILL = Slip(0.0, 0.0, 0.0, 0.0)


def path(count, seed):
    rng = np.random.default_rng(seed)
    return np.cumsum(rng.normal(0, [0.2, 0.2, 0.8], (count, 3)), axis=0)


@given(st.integers(2, 30), st.integers(0, 10**6))
def test_steps_without_slip_lead_along_the_path(count, seed):
    poses = path(count, seed)
    heading = poses[0, 2]
    place = complex(*poses[0, :2])
    for k, (ahead, left, turn) in enumerate(
        roll(poses, STILL, rng=np.random.default_rng(0)).increments
    ):
        place += complex(ahead, left) * np.exp(1j * heading)
        heading += turn
        assert place == pytest.approx(complex(*poses[k + 1, :2]))
        assert np.exp(1j * heading) == pytest.approx(np.exp(1j * poses[k + 1, 2]))


@pytest.mark.parametrize("slip", [SMALL, LARGE], ids=["small", "large"])
@pytest.mark.parametrize("steps", [20, 200])
def test_error_of_ten_metres_does_not_depend_on_the_steps(slip, steps):
    poses = np.stack([np.linspace(0, 10, steps + 1)] + [np.zeros(steps + 1)] * 2, axis=-1)
    total = np.stack(
        [
            (roll(poses, slip, rng=rng).increments - true_increments(poses)).sum(axis=0)
            for rng in np.random.default_rng(0).spawn(400)
        ]
    )
    expected = np.array([slip.along, slip.across, slip.bend]) * np.sqrt(10)
    low, high = np.sqrt(stats.chi2.ppf([1e-4, 1 - 1e-4], 400) / 400)
    ratio = np.sqrt((total**2).mean(axis=0)) / expected
    assert (low < ratio).all()
    assert (ratio < high).all()


@given(st.integers(2, 30), st.integers(0, 10**6))
def test_increments_do_not_care_for_whole_turns(count, seed):
    poses = path(count, seed)
    turned = poses + 2 * np.pi * np.random.default_rng(seed).integers(-2, 3, (count, 1)) * [0, 0, 1]
    np.testing.assert_allclose(true_increments(turned), true_increments(poses), atol=1e-9)
    assert (np.abs(true_increments(turned)[:, 2]) <= np.pi).all()


@pytest.mark.parametrize("way", [-3, 3])
def test_turning_on_the_spot_costs_heading_only(way):
    poses = np.stack([np.zeros(9), np.zeros(9), np.linspace(0, way, 9)], axis=-1)
    reported = roll(poses, LARGE, rng=np.random.default_rng(0))
    np.testing.assert_allclose(reported.deviations[:, :2], 0)
    assert np.sqrt((reported.deviations[:, 2] ** 2).sum()) == pytest.approx(LARGE.turn * np.sqrt(3))


@pytest.mark.parametrize(
    ("poses", "words"),
    [
        (np.zeros((1, 3)), r"\(1, 3\)"),
        (np.zeros((4, 2)), r"\(4, 2\)"),
        (np.array([[0, 0, 0], [np.nan, 0, 0]]), "1 entries"),
    ],
)
def test_bad_paths_are_named(poses, words):
    with pytest.raises(ValueError, match=words):
        roll(poses, SMALL, rng=np.random.default_rng(0))


@pytest.mark.parametrize("name", ["along", "across", "bend", "turn"])
def test_bad_slip_is_named(name):
    with pytest.raises(ValueError, match=f"{name} .*-0.1"):
        Slip(**({"along": 0.0, "across": 0.0, "bend": 0.0, "turn": 0.0} | {name: -0.1}))
