"""Pictures turned, nearer and in other light: what is counted, and the worse descriptors."""

import numpy as np
import pytest

from data_synth import stereo
from data_synth.stereo import Rig
from data_synth.textures import paint
from robot_perception.book import sift_association as page
from robot_perception.landmarks import detect
from studies.rows import Rows, framed
from tests.landmarks.worlds import descriptors

RNG = np.random.default_rng
QUIET = Rig(read_noise=0.0, photon_noise=0.0, imbalance=0.0)


@pytest.fixture
def quiet(monkeypatch):
    """A camera without noise."""
    monkeypatch.setattr(page, "RIG", QUIET)


@pytest.mark.parametrize("turned", [0.0, 0.4, -2.0])
def test_a_picture_is_turned_clockwise_about_its_middle(turned):
    scene = page.hang(paint("notices", rng=RNG(0)), turned)
    right, down, corner = scene.frames[0].T
    middle = np.array([0.0, 0.0, QUIET.height])
    assert corner + right / 2 + down / 2 == pytest.approx(middle)
    assert right @ down == pytest.approx(0.0, abs=1e-12)
    ends = stereo.project(QUIET, page.stand(0.0), np.array([middle, middle + right]))
    u, v = ends[1, :2] - ends[0, :2]
    assert np.exp(1j * np.arctan2(v, u)) == pytest.approx(np.exp(1j * turned))


@pytest.mark.parametrize("away", [1.0, 2.0, 4.0])
def test_the_camera_stands_as_far_away_as_it_is_told(away):
    middle = np.array([[0.0, 0.0, QUIET.height]])
    assert stereo.project(QUIET, page.stand(0.0, away), middle)[0, 2] == pytest.approx(away)


def test_places_of_a_picture_are_in_view_where_they_are_projected_into_the_image():
    scene, spots = page.hang(paint("poster", rng=RNG(1)), 0.5), RNG(2).uniform(0, 1.6, (200, 2))
    right, down, corner = scene.frames[0].T
    for away in (0.8, 2.0):
        seen = page.in_view(scene, away, spots)
        for spot, found in zip(spots, seen, strict=True):
            at = corner + spot[0] * right / np.linalg.norm(right)
            at = at + spot[1] * down / np.linalg.norm(down)
            u, v, _ = stereo.project(QUIET, page.stand(0.0, away), at[None])[0]
            assert found == (0 <= u <= 319 and 0 <= v <= 239)
    assert 0 < page.in_view(scene, 0.8, spots).sum() < 200


def test_each_others_nearest_are_those_of_all_distances():
    first, second = (descriptors(n, RNG(n)).astype(np.float32) for n in (30, 20))
    second[:10] = first[5:15] + 1
    apart = ((first[:, None].astype(float) - second) ** 2).sum(axis=-1)
    expected = [
        [i, apart[i].argmin()] for i in range(30) if apart[:, apart[i].argmin()].argmin() == i
    ]
    assert page.each_others_nearest(first, second).tolist() == expected
    assert len(page.each_others_nearest(first[:0], second)) == 0


def test_the_same_view_without_noise_is_recognised(quiet):
    picture = paint("poster", rng=RNG(3))
    right, count = page.recognised(picture, "SIFT", RNG(1))
    assert right > 0.95 * count > 50


def test_what_is_recognised_lies_at_the_same_place(quiet, monkeypatch):
    """Whoever takes every feature for one and the same recognises hardly any."""
    picture = paint("poster", rng=RNG(3))
    honest = page.recognised(picture, "SIFT", RNG(1), turned=0.8)
    monkeypatch.setattr(
        page,
        "each_others_nearest",
        lambda first, second: np.column_stack([np.arange(len(first)), np.zeros(len(first), int)]),
    )
    lost = page.recognised(picture, "SIFT", RNG(1), turned=0.8)
    assert honest[1] == lost[1]
    assert lost[0] < 0.1 * honest[0]


def test_from_near_only_what_both_show_is_counted(quiet):
    picture = paint("books", rng=RNG(3))
    counts = [page.recognised(picture, "SIFT", RNG(1), nearer=near)[1] for near in (1.0, 2.0)]
    assert counts[1] < 0.6 * counts[0]


@pytest.mark.parametrize(
    ("how", "change"),
    [
        ("not turned", {"turned": 0.8}),
        ("one size", {"nearer": 2.0}),
        ("grey values", {"exposure": 0.5}),
    ],
)
def test_each_worse_descriptor_fails_at_its_own_change_and_not_without(how, change):
    picture = paint("poster", rng=RNG(3))
    still, count = page.recognised(picture, how, RNG(1))
    assert still > 0.4 * count
    right, count = page.recognised(picture, how, RNG(1), **change)
    assert right < 0.15 * count
    good, count = page.recognised(picture, "SIFT", RNG(1), **change)
    assert good > 0.4 * count


def test_worse_descriptors_are_of_the_same_features():
    image = page.view("poster", 0.0).image
    features = detect(image)
    for how in ("SIFT", "not turned", "one size", "grey values"):
        found = page.described(image, how)
        assert (found.pixels == features.pixels).all()
        assert (found.angles == features.angles).all()
        same = (found.descriptors == features.descriptors).all() if how != "grey values" else False
        assert same == (how == "SIFT")
    assert found.descriptors.shape == (len(features), 18 * 18)


def test_the_worst_level_is_that_with_the_least_share_of_what_is_recognised_without():
    shares = {0: 0.8, 30: 0.6, 90: 0.7}
    trials = [
        {"album": k, "turn": turn, "recognised": share + 0.001 * k}
        for k in range(4)
        for turn, share in shares.items()
    ]
    rows = Rows(framed(trials), "album", {})
    assert page.worst(rows, "turn").estimate == pytest.approx(0.6015 / 0.8015)
    assert page.worst(rows, "turn", 90).estimate == pytest.approx(0.7015 / 0.8015)
    levels, means = page.by_level(rows, "turn")
    assert levels == [0, 30, 90]
    assert [one.estimate for one in means] == pytest.approx([0.8015, 0.6015, 0.7015])
