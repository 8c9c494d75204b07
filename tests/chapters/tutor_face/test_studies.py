"""The studies: worlds, and what they count, by law."""

from dataclasses import replace

import numpy as np
import pytest

from robot_perception.chapters.tutor_face import (
    bridging,
    crossing,
    detecting,
    identifying,
    linking,
    steering,
)
from robot_perception.chapters.tutor_face.scene import DETECTOR, found, look, person

RNG = np.random.default_rng


def test_the_box_of_a_look_is_where_the_detector_has_the_face():
    some = [look(RNG(k), person(k)) for k in range(12)]
    hits = [found(DETECTOR.find(one.image), one.box) for one in some]
    assert sum(hit is not None for hit in hits) >= 10


def test_a_detection_elsewhere_is_no_face():
    box = np.array([10.0, 10, 20, 20])
    assert found(np.zeros((0, 4)), box) is None
    assert found(np.array([[100.0, 100, 20, 20]]), box) is None
    assert found(np.array([[100.0, 100, 20, 20], [11, 10, 20, 20]]), box) == 1


def test_rates_are_of_their_turn_and_tone():
    hits = np.array([[True, False], [True, True], [False, False]])
    config = detecting.Config((1, 2, 3), (0, 45))
    result = detecting.Result(config, hits, np.zeros((3, 2), int), np.array([0, 0, 2]))
    assert result.rate(0).estimate == pytest.approx(2 / 3)
    assert result.rate(45).estimate == pytest.approx(1 / 3)
    assert result.rate_of_tone(0).estimate == 1
    assert result.rate_of_tone(2).estimate == 0
    assert list(detecting.by_tone(result).rows) == ["lightest", "third"]


def test_shuffled_names_recognise_by_chance_and_both_framings_are_of_the_same_pictures():
    detected, exact = identifying.faces(identifying.GALLERY)
    assert len(exact.pictures) == 10 * 10 + 4 * 3 >= len(detected.pictures)
    right = identifying.scored(detected, range(3), 20)[0]
    wrong = np.mean([identifying.scored(detected, range(3), 20, RNG(k))[0] for k in range(8)])
    assert right > 0.8 > 0.6 > wrong


def test_three_galleries_of_three_are_cut_from_ten():
    assert identifying.groups(identifying.CASES[0]) == [range(3), range(3, 6), range(6, 9)]
    assert identifying.groups(identifying.CASES[1]) == [range(10)]


def track(seen, boxes, last):
    truth = np.tile([0.0, 0, 10, 10], (len(seen), 1))
    ones = np.ones(len(seen))
    return bridging.Followed(truth, np.array(seen), boxes, truth, ones, ~np.array(seen), last)


def test_only_misses_after_the_first_detection_count():
    here = np.tile([1.0, 0, 10, 10], (5, 1))
    away = here + np.array([50.0, 0, 0, 0])
    boxes = np.where(np.arange(5)[:, None] == 3, away, here)
    boxes[4] = np.nan
    one = track([False, True, False, False, False], boxes, here)
    assert one.bridged() == (3.0, 1.0, 3.0)


def test_a_filter_that_cannot_see_is_condensation():
    config = steering.Config(steering.SCORED[:1], 12, filters=steering.films.quick.filters)
    blind = steering.run(replace(config, blind=True), rng=RNG(0))
    assert blind.lost[0, 0] == blind.lost[0, 1]


def link(rows, frames=8):
    """Return faces by picture: where they are, whom they are taken for, and who they are."""
    times, places, names, people = zip(*rows, strict=True)
    boxes = np.array([[x, 50.0, 40, 40] for x in places])
    return crossing.Seen(np.array(times), boxes, np.array(names), np.array(people)), frames


def test_a_verified_link_waits_and_the_nearest_face_takes_over():
    """Tutor 0 begins; from the third picture on tutor 1 stands where he stood."""
    rows = [(0, 50.0, 0, 0), (1, 52.0, 0, 0), *[(t, 54.0, 1, 1) for t in range(2, 8)]]
    faces, frames = link(rows)
    assert linking.linked(faces, frames, "verified", told=False) == (0, 0, *[-1] * 6)
    assert linking.linked(faces, frames, "nearest", told=False) == (0, 0, *[1] * 6)
    assert linking.judged(faces, frames, "verified", False) == (1.0, 1.0)
    assert linking.judged(faces, frames, "nearest", False)[0] == 0.0


def test_a_robot_that_is_told_needs_no_recognition():
    rows = [(0, 50.0, 0, 0), *[(t, 50.0, -1, 0) for t in range(1, 8)]]
    faces, frames = link(rows)
    assert linking.judged(faces, frames, "verified", False) == (1.0, 1 / 8)
    assert linking.judged(faces, frames, "verified", True) == (1.0, 1.0)


def test_before_a_tutor_comes_there_is_no_link():
    faces, frames = link([(3, 50.0, -1, 2), (5, 90.0, 1, 1)])
    assert linking.linked(faces, frames, "verified", told=False) == (*[-2] * 5, 1, -1, -1)


def test_tutors_are_enrolled_by_25_pictures_each():
    known = crossing.gallery(101)
    assert [known.names.count(name) for name in known.people] == [crossing.ENROLLED] * 2
