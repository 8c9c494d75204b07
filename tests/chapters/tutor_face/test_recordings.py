"""What is computed from real faces, and what the page says of it."""

import numpy as np

from robot_perception.chapters.tutor_face import recordings


def test_forty_eigenimages_recognise_what_is_known_of_the_recording():
    """The figure that is known of it: 95 of 100, first five pictures against last five."""
    stored = recordings.ORL.read().result
    assert stored.asked.tolist() == [100, 75]
    assert stored.right[-1] == 95
    assert (np.diff(stored.right) > 0).all()
    assert (np.diff(stored.strangers) < 0).all()
    assert stored.strangers[-1] > 0


def test_every_face_of_the_other_recording_is_found():
    stored = recordings.YALE.read().result
    assert stored.pictures.sum() == stored.found.sum() == 87
    rows = stored.table().rows
    assert sum(row[0] for row in rows.values()) == 87


def test_of_faces_that_do_not_vary_within_a_person_all_are_right_and_strangers_are_far():
    rng = np.random.default_rng(0)
    person = rng.uniform(size=(20, 1, 6, 5))
    faces = person + 0.001 * rng.standard_normal((20, 10, 6, 5))
    names = np.repeat([[f"{k}"] for k in range(20)], 10, axis=1)
    right, known, strangers = recordings._asked(faces, names, 15, 14)
    assert right == 75
    assert known > 60
    assert strangers == 0
