"""A picture in empty space seen from aside: where its features are found again."""

import numpy as np
import pytest

from data_synth import stereo
from data_synth.stereo import Rig
from data_synth.textures import paint
from robot_perception.book import sift_association as page
from robot_perception.book.sift_association import found_again
from tests.chapters.sift_association.worlds import features

RNG = np.random.default_rng
QUIET = Rig(read_noise=0.0, photon_noise=0.0, imbalance=0.0)


def again(pixels, *, first=((50.0, 40.0),), depth=2.0, scales=2.0, angles=0.0, was=0.0):
    """Return which features at pixels are taken for the first ones, seen from 2 m away."""
    at = np.column_stack([np.reshape(first, (-1, 2)), np.full(len(first), depth)])
    seen = features(pixels, scales=scales, angles=angles)
    return found_again(features(first, angles=was), at, seen).tolist()


def test_a_feature_is_found_where_it_must_be_and_no_farther():
    assert again([[51.4, 40.0]]) == [[0, 0]]
    assert again([[51.6, 40.0]]) == []
    assert again([[51.1, 41.1]]) == []
    assert again([[51.0, 40.0], [50.2, 40.1], [90.0, 90.0]]) == [[0, 1]]


def test_its_size_is_like_and_smaller_where_the_point_is_farther():
    assert again([[50.0, 40.0]], scales=2.0 * 1.39) == [[0, 0]]
    assert again([[50.0, 40.0]], scales=2.0 / 1.39) == [[0, 0]]
    assert again([[50.0, 40.0]], scales=2.0 * 1.41) == []
    assert again([[50.0, 40.0]], scales=2.0 / 1.41) == []
    assert again([[50.0, 40.0]], depth=4.0, scales=1.0) == [[0, 0]]
    assert again([[50.0, 40.0]], depth=4.0, scales=2.0) == []


def test_its_direction_is_like_across_the_branch_of_the_angle():
    for was, angle in ((0.1, 2 * np.pi - 0.1), (2 * np.pi - 0.1, 0.1)):
        assert again([[50.0, 40.0]], was=was, angles=angle) == [[0, 0]]
    assert again([[50.0, 40.0]], angles=np.deg2rad(29)) == [[0, 0]]
    assert again([[50.0, 40.0]], angles=np.deg2rad(31)) == []


def test_each_of_several_is_found_by_itself_and_nothing_among_nothing():
    three = [[50.0, 40.0], [80.0, 40.0], [50.0, 90.0]]
    assert again([[50.0, 90.3], [80.2, 40.0]], first=three) == [[1, 1], [2, 0]]
    nothing, one = features([]), features([[50.0, 40.0]])
    assert found_again(nothing, np.empty((0, 3)), one).shape == (0, 2)
    assert found_again(one, np.array([[50.0, 40.0, 2.0]]), nothing).shape == (0, 2)


@pytest.mark.parametrize("angle", [0.0, 30.0, -45.0])
def test_the_camera_goes_round_the_middle_and_looks_at_it(angle):
    pose = page.stand(angle)
    middle = stereo.project(QUIET, pose, np.array([[0.0, 0.0, QUIET.height]]))[0]
    assert middle == pytest.approx([*QUIET.centre_px, page.DISTANCE])
    assert np.rad2deg(np.arctan2(pose[1], -pose[0])) == pytest.approx(angle)


def test_a_picture_hangs_about_the_middle_in_its_own_shape():
    for kind in ("poster", "notices"):
        picture = paint(kind, rng=RNG(0))
        corner, right, down = (page.hang(picture).frames[0][:, k] for k in (2, 0, 1))
        assert corner + right / 2 + down / 2 == pytest.approx([0, 0, QUIET.height])
        shape = np.linalg.norm(down) / np.linalg.norm(right)
        assert shape == pytest.approx(picture.shape[0] / picture.shape[1])
        assert max(np.linalg.norm(right), np.linalg.norm(down)) == pytest.approx(1.6)


def test_without_noise_the_same_view_is_the_same():
    """Every feature finds itself, or its twin of another direction, and nothing has moved."""
    scene = page.hang(paint("poster", rng=RNG(3)))
    looks = [page.seen_ahead(scene, QUIET, rng=RNG(k)) for k in (1, 2)]
    (first, points), (second, _) = looks
    at = stereo.project(QUIET, page.stand(0.0), points)
    pairs = found_again(first, at, second)
    assert len(pairs) == len(first) > 50
    assert (first.pixels[pairs[:, 0]] == second.pixels[pairs[:, 1]]).all()
    own = first.angles[pairs[:, 0]] == second.angles[pairs[:, 1]]
    assert own.mean() > 0.9
    assert (first.descriptors[pairs[own, 0]] == second.descriptors[pairs[own, 1]]).all()


def test_a_record_is_the_mean_over_all_features_of_all_pictures(monkeypatch):
    """Two pictures with few and many features: each feature counts once."""
    parts = {
        "poster": (10, np.array([8, 0]), np.array([80.0, 0.0]), 3000.0),
        "sign": (30, np.array([24, 6]), np.array([480.0, 600.0]), 6000.0),
    }
    monkeypatch.setattr(page, "gone_round", lambda kind, angles, rng: parts[kind])
    monkeypatch.setattr(page, "KINDS", ("poster", "sign"))
    monkeypatch.setattr(page, "ANGLES", (0, 30))
    found = page.viewed.trial(album=0)
    assert found["moved"] == pytest.approx([17.5, 100.0])
    assert found["found"] == pytest.approx([0.8, 0.15])
    assert found["other"] == 225.0


def test_noise_moves_descriptors_less_than_thirty_degrees_and_these_less_than_another_landmark():
    features, found, moved, other = page.gone_round("notices", (0, 30), RNG(7))
    near, far = moved / found
    assert 0 < near < far < other / features
    assert features >= found[0] > found[1] > 0


def test_a_camera_that_stays_where_it_was_sees_the_same_at_every_angle(monkeypatch):
    """Nothing but the noise differs."""
    seen = []
    round_trip = (1, np.ones(1), np.ones(1), 1.0)
    monkeypatch.setattr(page, "gone_round", lambda kind, at, rng: seen.append(at) or round_trip)
    page.viewed.but(still=True).trial(album=0)
    page.viewed.trial(album=0)
    assert [set(at) for at in seen[: len(page.KINDS)]] == [{0.0}] * len(page.KINDS)
    assert tuple(seen[-1]) == page.ANGLES
