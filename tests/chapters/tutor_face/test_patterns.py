"""Local binary patterns of faces, and the galleries that are asked by them."""

import numpy as np
import pytest

from robot_perception.book import tutor_face as tutor
from robot_perception.chapters.tutor_face import pictures
from studies.project import project


def face(seed, rows=24, columns=19):
    """Return a picture of noise, in the steps of a camera."""
    return np.random.default_rng(seed).integers(0, 256, (rows, columns)) / 255


def test_a_pattern_says_which_pixels_on_a_circle_of_two_are_as_bright_at_least():
    """Oracle: pixel by pixel."""
    image = face(0)
    found = tutor.patterns(image)
    assert found.shape == (20, 15)
    angles = np.arange(8) * np.pi / 4
    ring = np.round(2 * np.stack([np.sin(angles), np.cos(angles)], axis=-1)).astype(int)
    for row in range(2, 22):
        for column in range(2, 17):
            bits = [image[row + v, column + u] >= image[row, column] for v, u in ring]
            assert found[row - 2, column - 2] == sum(1 << k for k, bit in enumerate(bits) if bit)


def test_light_that_keeps_the_order_of_grey_values_changes_no_pattern():
    image = face(1)
    np.testing.assert_array_equal(tutor.patterns(image), tutor.patterns(0.3 * image**2 + 0.1))


def test_each_cell_holds_shares_of_its_pixels_by_59_kinds():
    found = tutor.counted_in_cells(face(2, 46, 39))
    cells = found.reshape(49, 59)
    np.testing.assert_allclose(cells.sum(axis=1), 1)
    flat = tutor.counted_in_cells(np.full((46, 39), 0.5)).reshape(49, 59)
    assert (flat.argmax(axis=1) == 57).all()  # all eight are as bright: the last run
    assert (flat.max(axis=1) == 1).all()


def test_each_run_of_brighter_pixels_is_a_kind_and_all_others_are_one(monkeypatch):
    runs = sorted({sum(1 << (a + k) % 8 for k in range(n)) for a in range(8) for n in range(9)})
    assert len(runs) == 58
    for code in range(256):
        monkeypatch.setattr(tutor, "patterns", lambda _, code=code: np.full((7, 7), code))
        kind = tutor.counted_in_cells(face(5)).reshape(49, 59)[0].argmax()
        assert kind == (runs.index(code) if code in runs else 58)


def test_the_distance_is_none_to_itself_and_the_same_both_ways():
    one, other = tutor.counted_in_cells(face(3)), tutor.counted_in_cells(face(4))
    assert tutor.chi_square(one, one) == 0
    assert tutor.chi_square(one, other) == tutor.chi_square(other, one) > 0
    assert tutor.chi_square(np.array([1.0, 0, 0]), np.array([0, 1.0, 0])) == 2
    found = tutor.chi_square(np.array([1.0, 0]), np.array([0.5, 0.5]))
    assert found == pytest.approx(1 / 6 + 1 / 2)


def test_nearest_pictures_are_those_of_all_eigenimages_if_the_distances_are(monkeypatch):
    """Oracle: eigenfaces, which leave nothing out of 30 pictures with 29 eigenimages."""
    whose = np.repeat(np.arange(8), 10)
    points = np.random.default_rng(0).normal(size=(80, 1, 40)) + whose[:, None, None] / 8
    apart = np.linalg.norm(points - points[:, 0], axis=-1)
    monkeypatch.setattr(tutor, "pictures_in", lambda _: (whose, points))
    monkeypatch.setattr(tutor, "apart_in", lambda _: (whose, apart))
    for gallery in (1000, 1001, 1002):
        place = {"gallery": gallery, "light": "even"}
        by_points = tutor.enrolled.but(eigenimages=29).trial(**place)
        found = tutor.described.trial(**place)
        for name in ("person", "stranger", "right"):
            np.testing.assert_array_equal(found[name], by_points[name])


def test_whoever_is_within_the_limit_of_the_gallery_passes(monkeypatch):
    """People at places of a line, each with pictures one apart: the limit is one or two."""
    whose = np.repeat(np.arange(8), 10)
    at = 1000.0 * whose + np.tile(np.arange(10.0), 8)
    monkeypatch.setattr(tutor, "apart_in", lambda _: (whose, np.abs(at[:, None] - at)))
    found = tutor.described.trial(gallery=1000, light="even")
    strange = found["stranger"] == 1
    assert (found["right"][~strange] == 1).all()
    assert (found["accepted"][strange] == 0).all()
    assert found["accepted"][~strange].mean() > 0.8


@pytest.mark.parametrize(
    ("recording", "read"),
    [
        (tutor.ORL_POINTS, pictures.in_even_light),
        (tutor.YALE_POINTS, pictures.in_many_lights),
    ],
)
def test_the_pictures_are_those_whose_points_are_stored(recording, read):
    folder = project().data.find(recording.dataset)
    if folder is None:
        pytest.skip(f"no recording {recording.dataset} here")
    people, takes, faces = read(folder)
    stored = recording.read().result
    assert people == stored.people.tolist()
    assert tuple(takes) == stored.takes
    flat = np.array([one.ravel() for one in faces])
    for k in (0, 40, 80):
        theirs = np.linalg.norm(stored.points - stored.points[k], axis=1)
        np.testing.assert_allclose(np.linalg.norm(flat - flat[k], axis=1), theirs, atol=1e-9)


def test_distances_are_stored_of_the_same_pictures_as_points():
    for light in tutor.LIGHTS:
        whose, apart = tutor.apart_in(light)
        np.testing.assert_array_equal(whose, tutor.pictures_in(light)[0])
        assert apart.shape == (len(whose), len(whose))
        assert (np.diag(apart) == 0).all()
        assert (apart == apart.T).all()
