"""What is computed from real pictures, and what the page says of it."""

from types import SimpleNamespace

import cv2
import numpy as np
import pytest

from robot_perception.book import tutor_following as page
from robot_perception.chapters.tutor_following import training
from robot_perception.chapters.tutor_following.scene import at, hands
from studies.intervals import proportion


def test_the_real_open_hand_is_found_upright_and_not_when_tilted_far():
    stored = page.PHOTOGRAPHS.read().result
    assert len(stored.gestures) == 14
    assert stored.found[0] > 0.8 * page.ROOMS
    assert (np.diff(stored.found) < 0).all()
    assert stored.taken.sum() < 0.1 * page.ROOMS * 14


def test_four_patches_hold_the_head_in_more_pictures_than_one_and_gated_ones_in_most():
    stored = page.GIRL.read().result
    near = dict(zip(stored.trackers, stored.near.mean(axis=1), strict=True))
    for learns in ("adapting", "fixed"):
        assert near[f"four, {learns}"] > near[f"one patch, {learns}"] + 0.1
    assert near["four, gated"] == max(near.values()) > 0.5
    assert not stored.held.any()


def test_a_black_picture_is_no_hand():
    assert page.rooms_with_hand(np.zeros((224, 224, 3), np.uint8), 0.0) == 0


def test_in_most_kinds_of_real_photographs_hands_are_seen_that_are_not_there():
    shares = {what: one.read().result.share() for what, one in page.HANDLESS.items()}
    assert list(shares) == ["faces", "a girl's head", "a street", "a hall"]
    assert min(shares["a girl's head"].low, shares["a street"].low) > 0.2
    assert shares["a hall"].estimate == 0


def test_photographs_in_the_training_take_most_alarms_away():
    """In recordings that neither detector was trained on."""
    found = [one.read().result for one in page.HANDLESS.values()]
    before, after = (np.concatenate([getattr(one, name) for one in found]) > 0
                     for name in ("counts", "fewer"))  # fmt: skip
    first, second = (proportion(int(some.sum()), len(some)) for some in (before, after))
    assert second.high < first.low
    assert all(one.row()[2].estimate <= one.row()[1].estimate for one in found)


@pytest.mark.slow
def test_the_detector_that_saw_photographs_finds_rendered_hands_all_the_same():
    hits = []
    for person in range(60000, 60020):
        one = page.shot(np.random.default_rng(person))
        hits.append(at(hands(training.PHOTOGRAPHED).find(one.grey), one.hand).any())
    assert proportion(int(sum(hits)), len(hits)).high > 0.9
    assert np.mean(hits) >= 0.8


def test_alarms_are_counted_by_photograph_whatever_its_size(tmp_path):
    rng = np.random.default_rng(0)
    for k, size in enumerate(((480, 640), (60, 80), (240, 320))):
        cv2.imwrite(str(tmp_path / f"{k}.png"), np.full(size, 100 + k, np.uint8))
    noise = rng.integers(0, 256, (240, 320), dtype=np.uint8)
    cv2.imwrite(str(tmp_path / "3.png"), noise)
    found = page.false_hands(tmp_path, "*.png")
    assert found.counts.tolist() == [0, 0, 0, len(hands().find(noise))]
    assert found.fewer.tolist() == [0, 0, 0, len(hands(training.PHOTOGRAPHED).find(noise))]
    assert len(page.false_hands(tmp_path, "*.png", every=2).counts) == 2


def test_both_cascades_look_at_photographs_of_one_size(tmp_path, monkeypatch):
    found, shapes = {training.RENDERED: 3, training.PHOTOGRAPHED: 1}, set()

    def hands_by(name):
        return SimpleNamespace(find=lambda image: shapes.add(image.shape) or [None] * found[name])

    monkeypatch.setattr(page, "hands", hands_by)
    for k, size in enumerate(((480, 640), (60, 80), (90, 120))):
        cv2.imwrite(str(tmp_path / f"{k}.png"), np.full(size, 100, np.uint8))
    alarms = page.false_hands(tmp_path, "*.png")
    assert (alarms.counts.tolist(), alarms.fewer.tolist()) == ([3] * 3, [1] * 3)
    assert shapes == {(240, 320)}


def test_a_share_is_of_photographs_and_not_of_alarms():
    found = page.Alarms(np.array([0, 3, 0, 1]), np.array([0, 0, 2, 0]))
    assert found.share().estimate == 0.5
    count, before, after = found.row()
    assert (count, before.estimate, after.estimate) == (4, 0.5, 0.25)
