"""Detection: where a spot is, what turning and scaling do, and what is refused."""

import cv2
import numpy as np
import pytest

from robot_perception.landmarks import Features, Sift, detect
from robot_perception.landmarks.features import same_code
from tests.landmarks.worlds import COLUMNS, blob, features, shifted, texture
from tests.unchecked import unchecked


@pytest.mark.parametrize(("u", "v", "sigma"), [(100.0, 90.0, 3.0), (151.3, 90.7, 3.0), (80, 99, 6)])
def test_a_spot_is_found_where_it_is(u, v, sigma):
    """OpenCV's default is off by 0.25 px to the right and below, or 0.5 px of a coarser octave."""
    found = detect(blob(u, v, sigma))
    assert len(found) >= 1
    np.testing.assert_allclose(found.pixels, np.tile([u, v], (len(found), 1)), atol=0.05)
    # the difference of Gaussians of ratio 2^(1/3) answers most where their mean blur is the spot's
    np.testing.assert_allclose(found.scales, sigma / 2 ** (1 / 6), rtol=0.02)


def test_a_quarter_turn_turns_pixels_and_angles():
    image = texture(0)
    before, after = detect(image), detect(np.ascontiguousarray(np.rot90(image)))
    expected = np.stack([before.pixels[:, 1], COLUMNS - 1 - before.pixels[:, 0]], axis=1)
    far = np.linalg.norm(expected[:, None] - after.pixels, axis=-1)
    turn = np.abs((before.angles[:, None] - after.angles - np.pi / 2 + np.pi) % (2 * np.pi) - np.pi)
    same = (far < 0.1) & (turn < 0.01)
    assert same.any(axis=1).mean() > 0.9
    assert len(before) > 100


def test_descriptors_are_whole_numbers_of_one_length():
    found = detect(texture(1)).descriptors
    assert found.shape[1] == 128
    np.testing.assert_array_equal(found, np.rint(found))
    assert found.min() >= 0
    assert found.max() <= 255
    np.testing.assert_allclose(np.linalg.norm(found, axis=1), 512, rtol=0.02)


def test_parameters_reach_the_detector():
    image = texture(2)
    every = detect(image)
    assert 20 <= len(detect(image, Sift(most=20))) <= 22  # of two directions one is as strong
    assert len(detect(image, Sift(contrast=0.1))) < len(every)
    assert len(detect(image, Sift(edge=2.0))) < len(every)
    assert len(detect(image, Sift(sigma=3.0))) < len(every)
    assert len(detect(image, Sift(layers=6))) != len(every)
    with same_code():
        theirs = cv2.SIFT_create(enable_precise_upscale=True).detectAndCompute(image, None)
    np.testing.assert_array_equal(every.descriptors, theirs[1])
    np.testing.assert_array_equal(every.pixels, [point.pt for point in theirs[0]])


def switches() -> tuple[bool, bool, int]:
    """Return the switches of OpenCV that say which code runs, and in how many threads."""
    return cv2.useOptimized(), cv2.ipp.useIPP(), cv2.getNumThreads()


def test_features_are_those_of_the_code_that_every_processor_has(monkeypatch):
    """In one thread; and where it fails, all switches are as before."""
    seen, before = [], switches()

    class Broken:
        def detectAndCompute(self, image, mask):
            seen.append(switches())
            raise cv2.error("no memory")

    monkeypatch.setattr(cv2, "SIFT_create", lambda *args, **options: Broken())
    with pytest.raises(cv2.error):
        detect(texture(4))
    assert seen == [(False, False, 1)]
    assert switches() == before


@pytest.mark.parametrize("held", [False, True])
def test_features_are_the_same_whatever_units_opencv_may_use(held):
    image, before = texture(4), switches()
    here = detect(image)
    cv2.setUseOptimized(not held)
    cv2.setNumThreads(4)
    try:
        again = detect(image)
        assert switches()[0] != held
    finally:
        cv2.setUseOptimized(before[0])
        cv2.setNumThreads(before[2])
    for name in ("pixels", "descriptors", "scales", "angles"):
        np.testing.assert_array_equal(getattr(again, name), getattr(here, name))


def test_light_changes_little():
    image = texture(3)
    bright = np.clip(1.2 * image.astype(float) + 10, 0, 255).astype(np.uint8)
    before, after = detect(image), detect(bright)
    near = np.linalg.norm(before.pixels[:, None] - after.pixels, axis=-1).argmin(axis=1)
    apart = np.linalg.norm(before.descriptors - after.descriptors[near], axis=1)
    assert np.median(apart) < 50


def test_nothing_is_found_where_there_is_nothing():
    for image in (np.zeros((16, 16), np.uint8), np.full((240, 320), 255, np.uint8)):
        found = detect(image)
        assert len(found) == 0
        assert found.descriptors.shape == (0, 128)


def test_some_of_the_features():
    found = detect(shifted(texture(4), 3.0))
    half = found[::2]
    assert len(half) == (len(found) + 1) // 2
    np.testing.assert_array_equal(half.descriptors, found.descriptors[::2])
    np.testing.assert_array_equal(found[found.scales > 3].angles, found.angles[found.scales > 3])


@pytest.mark.parametrize(
    ("image", "error", "message"),
    [
        (np.zeros((240, 320, 3), np.uint8), ValueError, r"image must be grey, .*\(240, 320, 3\)"),
        (np.zeros((240, 320)), TypeError, r"image must be .*uint8\), got float64"),
        (np.zeros((240, 320), np.uint16), TypeError, "got uint16"),
        (np.zeros((240, 15), np.uint8), ValueError, r"at least 16 px wide and high, got \(240, 15"),
        (np.zeros((0, 0), np.uint8), ValueError, "at least 16 px"),
        ([[1, 2]], TypeError, "image must be a picture of bytes"),
    ],
)
def test_pictures_of_other_kinds_are_refused(image, error, message):
    with unchecked(), pytest.raises(error, match=message):
        detect(image)


def test_features_must_fit_together():
    good = features([[1, 2], [3, 4]], [0, 1])
    parts = {
        "pixels": good.pixels[:1],
        "descriptors": np.full((2, 128), np.nan, np.float32),
        "scales": good.scales[:1],
        "angles": np.array([0.0, np.inf]),
    }
    for name, wrong in parts.items():
        fields = {field: getattr(good, field) for field in parts} | {name: wrong}
        with unchecked(), pytest.raises(ValueError, match="must be"):
            Features(**fields)
    assert features([[1, 2]], [0]).descriptors.dtype == np.float32
    doubled = Features(good.pixels, good.descriptors.astype(float), good.scales, good.angles)
    assert doubled.descriptors.dtype == np.float32
    with unchecked(), pytest.raises(ValueError, match="descriptors must be within"):
        Features(good.pixels, np.full((2, 128), 1e39), good.scales, good.angles)
