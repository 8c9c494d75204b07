"""A small cascade, trained on bars, and its detector: laws, and the scan against the plain one."""

import json
from dataclasses import replace

import cv2
import numpy as np
import pytest

from robot_perception.companion.boxes import overlap
from robot_perception.companion.faces.region import FaceTracker
from robot_perception.companion.hands.cascade import (
    Cascade,
    Goals,
    HandDetector,
    Stage,
    train,
)
from robot_perception.companion.hands.features import SIZE, feature_pool
from tests.unchecked import unchecked


def bars(rng, count):
    """Return windows with three bright bars on a dark ground, which stand for a hand."""
    found = rng.integers(20, 70, (count, SIZE, SIZE))
    for k in range(count):
        top, left = rng.integers(2, 5), rng.integers(3, 6)
        for bar in range(3):
            x = left + 6 * bar
            found[k, top : top + 16, x : x + 3] = rng.integers(150, 220)
    return found.astype(np.uint8)


def noise(rng, count):
    coarse = rng.integers(0, 256, (count, 6, 6)).astype(np.uint8)
    return np.stack([cv2.resize(c, (SIZE, SIZE)) for c in coarse])


def others(rng):
    def found(cascade, count):
        windows = noise(rng, 6 * count)
        if cascade is not None:
            windows = windows[cascade.passed(windows) == len(cascade.stages)]
        return windows[:count]

    return found


@pytest.fixture(scope="module")
def trained():
    rng = np.random.default_rng(0)
    told = []
    cascade, reports = train(
        bars(rng, 150),
        others(rng),
        feature_pool(rng, 300),
        count=300,
        goals=Goals(stages=4),
        told=told.append,
    )
    assert tuple(told) == reports
    return cascade, reports


def test_every_stage_reaches_its_goals(trained):
    _, reports = trained
    assert len(reports) >= 2
    for report in reports:
        assert report.detection >= 0.98  # the quantile of some 150 hands
        assert report.false_alarms <= 0.5
    assert [r.hands for r in reports[1:]] == [round(r.hands * r.detection) for r in reports[:-1]]


def test_new_windows_pass_or_do_not(trained):
    cascade, _ = trained
    rng = np.random.default_rng(9)
    count = len(cascade.stages)
    assert (cascade.passed(bars(rng, 200)) == count).mean() > 0.85
    assert (cascade.passed(noise(rng, 400)) == count).mean() < 0.15


def test_a_stage_is_only_reached_through_those_before(trained):
    cascade, _ = trained
    rng = np.random.default_rng(3)
    windows = np.concatenate([bars(rng, 40), noise(rng, 80)])
    passed = cascade.passed(windows)
    for k in range(len(cascade.stages)):
        part = Cascade(cascade.features, cascade.stages[: k + 1]).passed(windows)
        np.testing.assert_array_equal(part, np.minimum(passed, k + 1))


def test_flat_windows_are_rejected_at_once(trained):
    flat = np.full((3, SIZE, SIZE), 99, dtype=np.uint8)
    assert not trained[0].passed(flat).any()
    (first, *_) = trained[0].stages
    generous = Cascade(trained[0].features, (Stage(first.stumps, -1.0),))  # lets all others pass
    assert generous.passed(noise(np.random.default_rng(0), 3)).all()
    assert not generous.passed(flat).any()


def picture(rng):
    """Return a picture with bars of two sizes, and where they are."""
    image = cv2.resize(rng.integers(20, 70, (12, 16)).astype(np.uint8), (160, 120))
    boxes = []
    for x, y, side in ((20, 30, 24), (90, 50, 48)):
        part = cv2.resize(bars(rng, 1)[0], (side, side), interpolation=cv2.INTER_AREA)
        image[y : y + side, x : x + side] = part
        boxes.append((x, y, side, side))
    return image, np.array(boxes, dtype=float)


def test_the_compiled_scan_passes_the_windows_that_the_cascade_does(trained):
    cascade, _ = trained
    image, _ = picture(np.random.default_rng(4))
    detector = HandDetector(cascade, step=3, scale=1.4)
    boxes, looked = detector.windows(image)
    expected, count = [], 0
    factor = 1.0
    while min(image.shape) >= SIZE * factor:
        size = round(160 / factor), round(120 / factor)
        if min(size) < SIZE:
            break
        small = image if factor == 1 else cv2.resize(image, size, interpolation=cv2.INTER_AREA)
        for y in range(0, small.shape[0] - SIZE + 1, 3):
            for x in range(0, small.shape[1] - SIZE + 1, 3):
                count += 1
                window = np.ascontiguousarray(small[y : y + SIZE, x : x + SIZE])
                if cascade.passed(window[None])[0] == len(cascade.stages):
                    expected.append((x * factor, y * factor, SIZE * factor, SIZE * factor))
        factor *= 1.4
    assert looked == count
    np.testing.assert_allclose(boxes, np.array(expected).reshape(-1, 4))
    assert len(expected) > 0


def test_things_of_two_sizes_are_found_at_their_places(trained):
    image, truth = picture(np.random.default_rng(4))
    found = HandDetector(trained[0], step=1).find(image)
    assert (overlap(truth, found).max(axis=1) > 0.5).all()
    alone = HandDetector(trained[0], step=1, neighbours=0).find(image)
    assert len(alone) > len(found)


def test_as_many_windows_as_asked_must_agree(trained):
    image, _ = picture(np.random.default_rng(4))
    alone = HandDetector(trained[0], step=1, neighbours=0).find(image)
    counts = []
    for neighbours in (1, 2, 4, 8, 1000):
        found = HandDetector(trained[0], step=1, neighbours=neighbours).find(image)
        counts.append(len(found))
        if neighbours == 1:  # grouped all the same: no window of the many is left out of a group
            assert len(found) < len(alone)
            assert (overlap(alone, found).max(axis=1) > 0).all()
    assert (np.diff(counts) <= 0).all()
    assert counts[0] >= 2
    assert counts[-1] == 0


def test_a_window_gives_places_in_the_whole_picture(trained):
    image, truth = picture(np.random.default_rng(4))
    detector = HandDetector(trained[0], step=1)
    x, y, side, _ = truth[1]
    found = detector.find(image, np.array([x - 12.5, y - 10.25, side + 26, side + 20]))
    assert overlap(truth[1:], found).max() > 0.5
    assert detector.find(image, np.array([0.0, 0, 10, 10])).shape == (0, 4)


def test_only_sides_that_are_asked_for_are_looked_at(trained):
    image, truth = picture(np.random.default_rng(4))
    detector = HandDetector(trained[0], step=1)
    small, large = (detector.find(image, sides=sides) for sides in ((20.0, 30.0), (40.0, 60.0)))
    assert overlap(truth[:1], small).max() > 0.5
    assert overlap(truth[1:], large).max() > 0.5
    assert small[:, 2].max() < 31
    assert large[:, 2].min() >= 39
    assert detector.windows(image, (40.0, 60.0))[1] < detector.windows(image)[1] / 3


def test_no_hand_is_found_where_there_is_none(trained):
    detector = HandDetector(trained[0])
    assert detector.find(np.zeros((90, 90), np.uint8)).shape == (0, 4)
    assert detector.find(np.zeros((9, 9), np.uint8)).shape == (0, 4)


def test_stages_of_a_square_are_those_of_its_window(trained):
    cascade, _ = trained
    image, truth = picture(np.random.default_rng(4))
    detector = HandDetector(cascade)
    assert detector.stages_passed(image, truth[0]) == len(cascade.stages)
    x, y, side, _ = truth[1].astype(int)
    window = cv2.resize(
        image[y : y + side, x : x + side], (SIZE, SIZE), interpolation=cv2.INTER_AREA
    )
    assert detector.stages_passed(image, truth[1]) == cascade.passed(window[None])[0]


def test_json_keeps_the_cascade(trained):
    cascade, _ = trained
    again = Cascade.from_plain(json.loads(json.dumps(cascade.to_plain())))
    rng = np.random.default_rng(5)
    windows = np.concatenate([bars(rng, 100), noise(rng, 300)])
    np.testing.assert_array_equal(again.passed(windows), cascade.passed(windows))
    assert again.to_plain() == cascade.to_plain()


def test_another_format_or_version_is_named(trained):
    plain = trained[0].to_plain()
    for change, text in (
        ({"version": 2}, "version 1, got version 2: train the model anew"),
        ({"format": "else"}, "plain must be a boosted cascade"),
        ({"size": 20}, "windows of 24 px, got 20"),
        ({"features": plain["features"][:1]}, "stages must ask"),
        ({"stages": [{"threshold": 0.0}]}, "plain is no whole model"),
        ({"stages": []}, "stages must be from 1 to 100, got 0"),
        ({"version": 1.0}, r"version 1, got version 1\.0"),
        ({"version": True}, "version 1, got version True"),
        ({"size": 24.0}, "windows of 24 px"),
        ({"size": "24"}, "windows of 24 px"),
        ({"stages": plain["stages"][:1] * 10**5}, "stages must be at most 100, got 100000"),
        ({"features": plain["features"][:1] * 10**5}, "features must be at most 20000"),
    ):
        with pytest.raises(ValueError, match=text):
            Cascade.from_plain(plain | change)
    with pytest.raises(ValueError, match="plain must be a boosted cascade"):
        Cascade.from_plain([])


@pytest.mark.parametrize("value", [10**30, -1, 1.7, "12", True, None, [1], float("nan")])
@pytest.mark.parametrize("part", ["column", "row", "width", "height", "weight", "feature", "vote"])
def test_a_number_of_a_file_that_is_none_is_named(trained, part, value):
    plain = json.loads(json.dumps(trained[0].to_plain()))
    places = ("column", "row", "width", "height", "weight")
    if part in places:
        plain["features"][0][0][places.index(part)] = value
        told = r"features\[0\]\[0\]"
    else:
        plain["stages"][0]["stumps"][0][{"feature": 0, "vote": 3}[part]] = value
        told = r"stages\[0\] " + part
    fine = {"weight": (-1,), "vote": (10**30, -1, 1.7)}.get(part, ())
    if value in fine and not isinstance(value, bool):
        Cascade.from_plain(plain)
    else:
        with pytest.raises(ValueError, match=f"plain is no whole model: .*{told}"):
            Cascade.from_plain(plain)


@pytest.mark.parametrize("size", [0, -3, 25, 2**62])
@pytest.mark.parametrize("axis", [2, 3])
def test_a_rectangle_of_a_file_has_a_size(trained, axis, size):
    plain = json.loads(json.dumps(trained[0].to_plain()))
    plain["features"][0][0][axis] = size
    with pytest.raises(ValueError, match=rf"features\[0\]\[0\] must be from 1 to 24, got {size}"):
        Cascade.from_plain(plain)


def test_no_windows_pass_no_stage(trained):
    assert trained[0].passed(np.zeros((0, SIZE, SIZE), np.uint8)).shape == (0,)


@pytest.mark.parametrize(
    ("wrong", "error", "text"),
    [
        (lambda c: Cascade(c.features, ()), ValueError, "stages must be from 1 to 100, got 0"),
        (lambda c: Cascade(c.features[:1], c.stages), ValueError, "stages must ask 1 features"),
        (lambda c: Stage(c.stages[0].stumps, np.nan), ValueError, "threshold must be finite"),
        (lambda c: Goals(detection=1.2), ValueError, "detection must be"),
        (lambda c: HandDetector(c, scale=1.0), ValueError, "scale must be above 1.01"),
        (lambda c: HandDetector(c, least=10), ValueError, "least must be"),
        (lambda c: HandDetector(c).find(np.zeros((30, 30, 3), np.uint8)), ValueError, "image must"),
        (
            lambda c: HandDetector(c).stages_passed(
                np.zeros((30, 30), np.uint8), np.array([20.0, 0, 24, 24])
            ),
            ValueError,
            "box must lie in the picture",
        ),
        (
            lambda c: train(np.zeros((0, 24, 24), np.uint8), lambda a, b: None, c.features),
            ValueError,
            "hands must not be empty",
        ),
        (
            lambda c: train(
                bars(np.random.default_rng(0), 9),
                lambda cascade, count: np.zeros((0, 24, 24), np.uint8),
                c.features,
            ),
            ValueError,
            "others must find windows for the first stage, got 0",
        ),
    ],
)
def test_what_is_wrong_is_named(trained, wrong, error, text):
    with unchecked(), pytest.raises(error, match=text):
        wrong(trained[0])


def test_the_detector_is_a_detector_of_boxes_for_a_tracker(trained):
    image, truth = picture(np.random.default_rng(4))
    detector = replace(HandDetector(trained[0]), step=1)
    tracker = FaceTracker(detector, choose=lambda found: int(overlap(truth[1:], found)[0].argmax()))
    state, _ = tracker.step(tracker.start(), image)
    after, info = tracker.step(state, image)
    assert info.taken is not None
    assert overlap(after.box[None], truth[1:]).max() > 0.5


def test_hands_that_a_stage_rejects_are_not_trained_on_again():
    rng = np.random.default_rng(3)
    some = np.concatenate([bars(rng, 100), noise(rng, 40)])
    goals = Goals(detection=0.8, stages=3, most=3)
    _, reports = train(some, others(rng), feature_pool(rng, 200), count=200, goals=goals)
    assert reports[0].detection < 1
    assert [r.hands for r in reports[1:]] == [round(r.hands * r.detection) for r in reports[:-1]]


def told(monkeypatch, boxes):
    found = np.array(boxes, dtype=float), 1000
    monkeypatch.setattr(HandDetector, "windows", lambda self, image, sides=None: found)


@pytest.mark.parametrize("count", [1, 2, 3, 5])
def test_exactly_so_many_windows_make_a_hand_and_one_less_does_not(trained, monkeypatch, count):
    told(monkeypatch, [[20, 30, 24, 24]] * count)
    image = np.zeros((60, 80), dtype=np.uint8)
    assert len(HandDetector(trained[0], neighbours=count).find(image)) == 1
    assert len(HandDetector(trained[0], neighbours=count + 1).find(image)) == 0


def test_hands_on_which_more_windows_agree_come_first(trained, monkeypatch):
    image, few, many = np.zeros((60, 120), np.uint8), [10, 20, 24, 24], [80, 20, 24, 24]
    for boxes in ([few] * 2 + [many] * 5, [many] * 5 + [few] * 2):
        told(monkeypatch, boxes)
        found = HandDetector(trained[0], neighbours=2).find(image)
        np.testing.assert_array_equal(found, [many, few])


def test_windows_that_are_not_grouped_are_places_in_the_whole_picture(trained):
    image, truth = picture(np.random.default_rng(4))
    x, y, side, _ = truth[1]
    window = np.array([x - 12.0, y - 10.0, side + 26, side + 20])
    found = HandDetector(trained[0], step=1, neighbours=0).find(image, window)
    assert overlap(truth[1:], found).max() > 0.5
