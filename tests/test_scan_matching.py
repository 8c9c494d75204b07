"""Scans of a known room, from known places: the motion between them is found, if they tell it."""

import numpy as np
import pytest

from data_synth import laser
from robot_perception.geometry import se2
from robot_perception.geometry.scan_matching import follow_scans, match_scans

ROOM = np.array([[-2.0, -1.5], [4.0, -1.5], [4.0, 2.5], [1.0, 2.5], [1.0, 3.5], [-2.0, 3.5]])
FACES = np.stack([ROOM, np.roll(ROOM, -1, axis=0)], axis=1)
SCANNER = laser.Scanner(max_range=20.0)


def scans(poses: np.ndarray, faces: np.ndarray = FACES, seed: int = 1) -> list[np.ndarray]:
    """Return the points of scans from some poses, each in the frame of its scanner."""
    seen = laser.scan(faces, poses, SCANNER, rng=np.random.default_rng(seed))
    ahead = np.stack([np.cos(SCANNER.angles), np.sin(SCANNER.angles)], axis=-1)
    return [r[np.isfinite(r), None] * ahead[np.isfinite(r)] for r in seen.ranges]


@pytest.mark.parametrize("seed", range(5))
def test_a_motion_is_found(seed):
    rng = np.random.default_rng(seed)
    first = np.array([*rng.uniform(-0.5, 0.5, 2), rng.uniform(-3, 3)])
    motion = np.array([*rng.uniform(-0.15, 0.15, 2), rng.uniform(-0.1, 0.1)])
    before, now = scans(np.stack([first, se2.compose(first, motion)]), seed=seed)
    found = match_scans(before, now)
    away = found.motion - motion
    assert np.hypot(*away[:2]) < 0.01
    assert abs(away[2]) < 0.005
    assert found.share > 0.9
    assert found.residual < 0.02


def test_where_the_frame_of_the_first_scan_is_makes_no_difference():
    far = np.array([30.0, -20.0, 2.0])
    before, now = scans(np.array([[0, 0, 0], [0.1, 0.05, 0.05]]))
    motion = match_scans(before, now).motion
    moved = match_scans(se2.act(far, before), now, far).motion
    np.testing.assert_allclose(moved, se2.compose(far, motion), atol=2e-3)


def test_somebody_who_walks_moves_no_room():
    poses = np.array([[0, 0, 0], [0.1, 0.05, 0.05]])
    before, now = scans(poses)
    turn = np.linspace(0, 2 * np.pi, 20)
    legs = 0.06 * np.stack([np.cos(turn), np.sin(turn)], axis=-1)
    before, now = (
        np.vstack([scan, np.add(legs, at)])
        for scan, at in ((before, (1.5, 0.2)), (now, (1.5, 0.5)))
    )
    away = match_scans(before, now).motion - poses[1]
    assert np.hypot(*away[:2]) < 0.01


def test_what_is_not_alike_has_no_motion():
    before, _ = scans(np.zeros((2, 3)))
    assert match_scans(before, before[:20]) is None
    assert match_scans(before, before + 100.0) is None


def test_along_a_corridor_the_guess_stays():
    """Two walls say how far they are, and nothing of the way between them."""
    walls = np.array([[[-50.0, -1], [50, -1]], [[50.0, 1], [-50, 1]]])
    before, now = scans(np.array([[0, 0, 0], [0.2, 0.1, 0]]), walls)
    x, y, heading = match_scans(before, now, np.array([0.2, 0.0, 0.0])).motion
    assert y == pytest.approx(0.1, abs=0.01)
    assert heading == pytest.approx(0, abs=0.005)
    assert x == pytest.approx(0.2, abs=0.05)


def test_a_path_is_followed_and_goes_on_where_a_scan_says_nothing():
    poses = [np.zeros(3)]
    for k in range(15):
        step = np.array([0.1, 0.0, 0.06 if k < 5 else 0.0])
        poses.append(se2.compose(poses[-1], step))
    seen = scans(np.array(poses))
    seen[8] = seen[8][:3]  # nor can the next be compared with it
    found = follow_scans(seen)
    away = found - poses
    assert np.hypot(*away[:, :2].T).max() < 0.05
    assert np.abs(away[:, 2]).max() < 0.02
    assert follow_scans([]).shape == (0, 3)
